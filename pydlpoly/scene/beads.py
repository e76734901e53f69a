"""FIELD's molecules laid out as beads, and CONFIG compared with them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import SceneError
from pydlpoly.formats.records import Configuration, Field, FloatArray, Molecule
from pydlpoly.scene.settings import Notes, place

# DL_POLY calls lighter beads massless (shells, virtual sites) and does not integrate them.
_MASSLESS = 1e-6
# Bead numbers have 32 bits in the core.
MOST_BEADS = 2**31 - 1


@dataclass(frozen=True, eq=False)
class Layout:
    """What FIELD alone says about the beads, in the order CONFIG must have; arrays of length N as in ``Beads``."""

    species_names: tuple[str, ...]
    species: NDArray[np.int32]
    mass: FloatArray
    charge: FloatArray
    frozen: NDArray[np.bool_]
    molecule: NDArray[np.int64]

    def counts(self) -> tuple[int, ...]:
        """Return the number of beads of each species."""
        return tuple(int(n) for n in np.bincount(self.species, minlength=len(self.species_names)))

    def mobile_counts(self) -> tuple[int, ...]:
        """Return the number of beads of each species that can move."""
        return tuple(int(n) for n in np.bincount(self.species[~self.frozen], minlength=len(self.species_names)))


def lay_out(field: Field, notes: Notes) -> Layout:
    """Number the species by first appearance and repeat the molecules.

    Raises:
        SceneError: no bead at all or more than can be numbered, a bead that moves without mass, or a name that does not
            fit into files.
    """
    names = tuple(dict.fromkeys(atom.name for molecule in field.molecules for atom in molecule.atoms))
    number = {name: k for k, name in enumerate(names)}
    if field.bead_count == 0:
        raise SceneError("there are no beads: all molecules together have none", path=field.path)
    if field.bead_count > MOST_BEADS:
        told = f"the molecules add up to {field.bead_count} beads, more than {MOST_BEADS}"
        raise SceneError(told, path=field.path)
    for molecule in field.molecules:
        _check_atoms(molecule, field, notes)
    blocks = [_Block(molecule, number) for molecule in field.molecules]
    return Layout(
        species_names=names,
        species=np.concatenate([np.tile(b.species, b.count) for b in blocks]),
        mass=np.concatenate([np.tile(b.mass, b.count) for b in blocks]),
        charge=np.concatenate([np.tile(b.charge, b.count) for b in blocks]),
        frozen=np.concatenate([np.tile(b.frozen, b.count) for b in blocks]),
        molecule=np.repeat(
            np.arange(sum(b.count for b in blocks), dtype=np.int64),
            np.repeat([len(b.species) for b in blocks], [b.count for b in blocks]),
        ),
    )


class _Block:
    """The beads of one copy of a molecule, with the repeats of its atom lines written out."""

    def __init__(self, molecule: Molecule, number: dict[str, int]) -> None:
        repeats = [atom.repeat for atom in molecule.atoms]
        self.count = molecule.count
        self.species = np.repeat(np.array([number[a.name] for a in molecule.atoms], dtype=np.int32), repeats)
        self.mass = np.repeat(np.array([abs(a.mass) for a in molecule.atoms], dtype=np.float64), repeats)
        self.charge = np.repeat(np.array([a.charge for a in molecule.atoms], dtype=np.float64), repeats)
        self.frozen = np.repeat(np.array([a.frozen != 0 for a in molecule.atoms], dtype=np.bool_), repeats)


def _check_atoms(molecule: Molecule, field: Field, notes: Notes) -> None:
    for atom in molecule.atoms:
        where = place(field.path, atom.line)
        if atom.mass < 0.0:
            notes.warning(
                f"negative mass {atom.mass:g} of {atom.name}: its absolute value is taken, as in DL_POLY", where
            )
        if not atom.name.isascii():
            told = "a species name has a letter outside ASCII, and DL_POLY's files have no room for it"
            raise SceneError(told, path=field.path, line=atom.line or None, word=atom.name)
        if abs(atom.mass) < _MASSLESS and not atom.frozen and molecule.count:
            message = f"bead {atom.name} of molecule {molecule.name} has no mass ({atom.mass:g}) and is not frozen: "
            message += "massless beads cannot be integrated yet; give it a mass or freeze it"
            raise SceneError(message, path=field.path, line=atom.line or None, word=atom.name)


def check_configuration(layout: Layout, field: Field, config: Configuration) -> None:
    """Compare CONFIG with FIELD bead by bead.

    Raises:
        SceneError: another number of beads, another name at some position, or coordinates that are not finite.
    """
    expected = np.array(layout.species_names)[layout.species]
    found = np.array(config.names, dtype=np.str_)
    common = min(len(expected), len(found))
    different = np.nonzero(expected[:common] != found[:common])[0]
    first = _first_difference(int(different[0]), field, config) if len(different) else ""
    if len(expected) != len(found):
        message = f"{len(found)} beads, but the molecules of {field.path} add up to {len(expected)}"
        raise SceneError(message + (f"; {first}" if first else ""), path=config.path)
    if first:
        raise SceneError(first, path=config.path, word=config.names[int(different[0])])
    for what, array in (("position", config.positions), ("velocity", config.velocities)):
        if array is not None and not np.isfinite(array).all():
            bead = int(np.nonzero(~np.isfinite(array).all(axis=1))[0][0])
            raise SceneError(f"the {what} of bead {bead + 1} ({config.names[bead]}) is not finite", path=config.path)


def _first_difference(index: int, field: Field, config: Configuration) -> str:
    """Say what FIELD expects at this bead (counted from 0) and where in which molecule it stands."""
    remaining = index
    for molecule in field.molecules:
        size = molecule.beads_per_molecule
        if remaining < size * molecule.count:
            copy, site = divmod(remaining, size)
            name = _site_name(molecule, site)
            site_text = (
                f"bead {site + 1} of copy {copy + 1} of molecule {molecule.name}, {place(field.path, molecule.line)}"
            )
            return f"bead {index + 1} is {config.names[index]}, but {field.path} expects {name} there ({site_text})"
        remaining -= size * molecule.count
    raise AssertionError("the index lies beyond the molecules")


def _site_name(molecule: Molecule, site: int) -> str:
    for atom in molecule.atoms:
        if site < atom.repeat:
            return atom.name
        site -= atom.repeat
    raise AssertionError("the site lies beyond the molecule")


def has_tethers(field: Field) -> bool:
    """Whether a molecule that is there has tethers."""
    blocks = [block for molecule in field.molecules if molecule.count for block in molecule.blocks]
    return any(block.directive == "tethers" and block.lines for block in blocks)
