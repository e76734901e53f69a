"""FIELD's bonded blocks as arrays of terms, the pairs they take out of the pair forces, and their 1-4 pairs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import SceneError
from pydlpoly.formats.bonded_table import TABLE_KINDS, canonical_species
from pydlpoly.formats.records import BondedLine, BondedTable, Field, FloatArray, Molecule
from pydlpoly.scene.bonded_laws import KINDS, BondedEntry, read_bonded, refusal
from pydlpoly.scene.cell import widths
from pydlpoly.scene.charges import Strength
from pydlpoly.scene.model import Beads, Bonded, BondedKind, BondedTerm
from pydlpoly.scene.settings import Notes, place, places

# Which beads of a term the vectors lead between that the core works with.
_VECTORS: dict[BondedKind, tuple[tuple[int, int], ...]] = {
    "bond": ((0, 1),),
    "angle": ((0, 1), (2, 1)),
    "dihedral": ((0, 1), (1, 2), (3, 2)),
    "inversion": ((1, 0), (2, 0), (3, 0)),
    "tether": (),
}
# Laws that DL_POLY's documentation and code read differently, or that its code computes in an odd way.
_ODD = {
    (
        "angle",
        "mmbd",
    ): "mmbd takes the deviation in radians, as DL_POLY's code does, although its coefficients are those for degrees",
    ("angle", "kky"): "kky fades with distance, as documented; DL_POLY's code multiplies by the inverse of the factor",
    ("dihedral", "rbf"): "the hill of rbf at 180 degrees acts from both sides; DL_POLY's code has one half of it",
    (
        "inversion",
        "xpln",
    ): "the numbers of xpln are k m phi0, as documented; DL_POLY's code takes the second for the angle "
    "and the third for m",
}
_Line = tuple[BondedLine, BondedEntry]
_Tables = Mapping[tuple[str, tuple[str, ...]], BondedTable]
# How far the slopes of a table may be off from those of its energies, as a part of the largest one; the median counts.
_SLOPES_DIFFER = 0.1


def resolve_bonded(
    field: Field,
    factor: float,
    beads: Beads,
    cell: FloatArray,
    periodic: tuple[bool, bool, bool],
    config_path: str,
    notes: Notes,
    strength: Strength,
    charges: bool,
    tables: Iterable[BondedTable] = (),
) -> Bonded | None:
    """Return the bonded terms of all molecules, or None when there are none and no pair is excluded.

    Exclusions follow DL_POLY: every pair of beads that appears together in a bond, constraint, angle, dihedral or
    inversion has no pair forces, unless its key is the restraint form; nothing is inferred from the graph of bonds.

    Args:
        field: FIELD with its molecules.
        factor: FIELD's energy unit in internal units.
        beads: the beads with their start positions, which are the anchors of tethers.
        cell: (3, 3) cell vectors by row.
        periodic: periodicity along the three cell vectors.
        config_path: CONFIG, for messages.
        notes: receives choices and what has no effect.
        strength: of two unit charges, for Coulomb bonds.
        charges: whether the scene has electrostatics, for the 1-4 factors.
        tables: tabulated laws.

    Raises:
        SceneError: a law that is not modelled, numbers it cannot take, or beads of a term so far apart at the start
            that the image is not certain.
    """
    parts = []
    first = 0
    found = {(table.kind, canonical_species(table.kind, table.species)): table for table in tables}
    for table in found.values():
        _note_slopes(table, notes)
    for number, molecule in enumerate(field.molecules):
        size, count = molecule.beads_per_molecule, molecule.count
        if count and any(block.directive in (*KINDS, "constraints") and block.lines for block in molecule.blocks):
            offsets = first + size * np.arange(count)
            parts.append(
                _MoleculeTerms(molecule, number, field, factor, found, notes, strength, charges).spread(offsets)
            )
        first += size * count
    if not parts:
        return None
    terms = tuple(term for part in parts for term in part.terms)
    anchors = beads.positions if any(term.kind == "tether" for term in terms) else None
    excluded = np.concatenate([part.excluded for part in parts])
    scaled = np.concatenate([part.scaled for part in parts])
    scales = np.concatenate([part.scales for part in parts])
    coulomb_scaled = coulomb_scales = None
    if charges:
        coulomb_scaled = np.concatenate([part.coulomb_scaled for part in parts if part.coulomb_scaled is not None])
        coulomb_scales = np.concatenate([part.coulomb_scales for part in parts if part.coulomb_scales is not None])
    arrays = (excluded, scaled, scales, coulomb_scaled, coulomb_scales, *(term.beads for term in terms))
    for array in arrays:
        if array is not None:
            array.setflags(write=False)  # a scene is immutable
    bonded = Bonded(terms, excluded, scaled, scales, anchors, coulomb_scaled, coulomb_scales)
    _check_lengths(bonded, beads, cell, periodic, config_path)
    return bonded


class _MoleculeTerms:
    """The terms of one molecule type, with bead numbers counted from 0 within a copy."""

    def __init__(
        self,
        molecule: Molecule,
        number: int,
        field: Field,
        factor: float,
        tables: _Tables,
        notes: Notes,
        strength: Strength,
        charges: bool,
    ) -> None:
        self._molecule, self._number, self._field, self._notes = molecule, number, field, notes
        self._names, self._tables, self._factor = molecule.bead_names, tables, factor
        self._strength, self._charges = strength, charges
        self._lines: dict[BondedKind, list[_Line]] = {}
        for block in molecule.blocks:
            if block.directive in KINDS:
                kind = KINDS[block.directive]
                self._lines[kind] = [(line, read_bonded(kind, line, field, factor)) for line in block.lines]
        self._note_odd(factor)

    def spread(self, offsets: NDArray[np.int64]) -> Bonded:
        """Return the terms of all copies; ``offsets`` holds the first bead of each."""
        coulomb, pairs = self._scaled_pairs()
        return Bonded(
            terms=tuple(self._terms(offsets)),
            excluded=_copies(np.array(sorted(self._excluded()), dtype=np.int64).reshape(-1, 2), offsets),
            scaled=_copies(np.array(list(pairs), dtype=np.int64).reshape(-1, 2), offsets),
            scales=np.tile(np.array(list(pairs.values()), dtype=np.float64), len(offsets)),
            coulomb_scaled=_copies(np.array(list(coulomb), dtype=np.int64).reshape(-1, 2), offsets),
            coulomb_scales=np.tile(np.array(list(coulomb.values()), dtype=np.float64), len(offsets)),
        )

    def _terms(self, offsets: NDArray[np.int64]) -> Iterator[BondedTerm]:
        for kind, lines in self._lines.items():
            groups: dict[tuple[str, bool, tuple[float, ...], tuple[str, ...]], list[BondedLine]] = {}
            for line, entry in lines:
                species = self._species(kind, line) if entry.law.table else ()
                parameters = self._with_charges(line, entry) if entry.law.key == "coul" else entry.parameters
                groups.setdefault((entry.law.key, entry.restraint, parameters, species), []).append(line)
            for (key, restraint, parameters, species), members in groups.items():
                local = np.array([line.beads for line in members], dtype=np.int64) - 1
                where = places(self._field.path, [line.line for line in members])
                term = BondedTerm(kind, key, parameters, _copies(local, offsets), restraint, self._number, where)
                yield self._with_table(term, species, members[0]) if species else term

    def _species(self, kind: BondedKind, line: BondedLine) -> tuple[str, ...]:
        return canonical_species(kind, [self._names[bead - 1] for bead in line.beads])

    def _with_table(self, term: BondedTerm, species: tuple[str, ...], line: BondedLine) -> BondedTerm:
        table = self._tables.get((term.kind, species))
        if table is None:
            name = TABLE_KINDS[term.kind].name
            raise refusal(line, self._field, f"the {term.kind} of {' '.join(species)} has no table ({name})")
        angle = 1.0 if term.kind == "bond" else math.pi / 180.0
        values = self._factor * np.array([table.energy, table.slope / angle])
        values.setflags(write=False)
        return replace(
            term,
            table=values,
            table_start=table.start * angle,
            table_spacing=table.spacing * angle,
            explanation=f"{term.explanation}, {place(table.path, table.line)}",
        )

    def _with_charges(self, line: BondedLine, entry: BondedEntry) -> tuple[float, ...]:
        """Return the number of a Coulomb bond times the strength and the charges of its beads."""
        charges = [atom.charge for atom in self._molecule.atoms for _ in range(atom.repeat)]
        product = math.prod(charges[bead - 1] for bead in line.beads)
        if product == 0.0:
            text = f"the bond {line.key} of beads {line.beads[0]} and {line.beads[1]} has no force: one has no charge"
            self._notes.ignored(text, place(self._field.path, line.line))
        return (entry.parameters[0] * self._strength.value()[0] * product,)

    def _excluded(self) -> set[tuple[int, int]]:
        constraints = self._molecule.block("constraints")
        fixed = {(min(line.beads) - 1, max(line.beads) - 1) for line in constraints.lines} if constraints else set()
        return fixed | {
            (min(pair) - 1, max(pair) - 1)
            for kind, lines in self._lines.items()
            if kind != "tether"
            for line, entry in lines
            if not entry.restraint
            for pair in itertools.combinations(line.beads, 2)
        }

    def _scaled_pairs(self) -> tuple[dict[tuple[int, int], float], ...]:
        """Return the factors of 1-4 pairs, of electrostatics and pair law; DL_POLY's rules where terms share one.

        Without electrostatics the first has none.
        """
        ends_of_angles = {
            (min(line.beads[0], line.beads[2]), max(line.beads[0], line.beads[2]))
            for line, entry in self._lines.get("angle", [])
            if not entry.restraint
        }
        scales: dict[tuple[int, int], tuple[float, float]] = {}
        for line, entry in self._lines.get("dihedral", []):
            self._check_factors(line, entry)
            ends = min(line.beads[0], line.beads[3]), max(line.beads[0], line.beads[3])
            if entry.restraint:
                continue
            where = place(self._field.path, line.line)
            if ends in ends_of_angles or ends in scales:
                if any(entry.factors):
                    reason = "an angle" if ends in ends_of_angles else "an earlier dihedral"
                    dropped = " ".join(f"{x:g}" for x in entry.factors if x)
                    text = f"the 1-4 factor {dropped} is dropped, as in DL_POLY: {reason} has the same ends"
                    self._notes.ignored(text, where)
                continue
            scales[ends] = entry.factors[0] if self._charges else 0.0, entry.factors[1]
        return tuple({(i - 1, j - 1): pair[k] for (i, j), pair in scales.items() if pair[k]} for k in range(2))

    def _check_factors(self, line: BondedLine, entry: BondedEntry) -> None:
        electrostatic, pair = entry.factors
        if entry.restraint and (electrostatic or pair):
            message = (
                "the restraint form leaves the 1-4 pair its whole pair force, and the 1-4 factors (numbers 4 and 5) "
            )
            message += f"would count it again; leave them out, or write {entry.law.key}"
            raise refusal(line, self._field, message)
        if electrostatic and not self._charges:
            name = self._molecule.name or "(no name)"
            text = f"the electrostatic 1-4 factors of molecule {name} have no effect: no electrostatics act"
            self._notes.ignored(text, place(self._field.path, None))

    def _note_odd(self, factor: float) -> None:
        for kind, lines in self._lines.items():
            for line, entry in lines:
                where = place(self._field.path, line.line)
                if (kind, entry.law.key) in _ODD:
                    self._notes.choice(_ODD[kind, entry.law.key], where)
                if (kind, entry.law.key) == ("tether", "rhrm") and factor != 1.0:
                    text = "rc of a rhrm tether is a length; DL_POLY's code multiplies it by the energy unit"
                    self._notes.choice(text, where)
                if (kind, entry.law.key) == ("dihedral", "cos") and not entry.parameters[2].is_integer():
                    text = f"the energy jumps at 180 degrees because m = {entry.parameters[2]:g} is not a whole number"
                    self._notes.warning(text, where)


def _note_slopes(table: BondedTable, notes: Notes) -> None:
    """Warn when a table's third column is not the slope of its second."""
    slopes = np.gradient(table.energy, table.spacing)[1:-1]
    largest = float(np.median(np.abs(slopes)))
    apart = float(np.median(np.abs(table.slope[1:-1] - slopes)))
    if apart > _SLOPES_DIFFER * largest:
        column = "-r dU/dr" if table.kind == "bond" else "-dU/dx per degree"
        text = (
            f"table of {' '.join(table.species)}: the third column, {column}, is not the slope of the energies (half "
        )
        text += f"of all points are off by more than {apart:.3g}, where the slope is {largest:.3g}); both are used"
        notes.warning(text, place(table.path, table.line))


def _copies(local: NDArray[np.int64], offsets: NDArray[np.int64]) -> NDArray[np.int32]:
    """Repeat rows of local bead numbers for every copy of the molecule."""
    return (offsets[:, None, None] + local[None, :, :]).reshape(-1, local.shape[1]).astype(np.int32)


def _an(kind: str) -> str:
    return f"an {kind}" if kind[0] in "ai" else f"a {kind}"


def _check_lengths(
    bonded: Bonded, beads: Beads, cell: FloatArray, periodic: tuple[bool, bool, bool], config_path: str
) -> None:
    """Refuse a start in which the image that a term's vector leads to is not certain."""
    axes = list(periodic)
    limit = 0.5 * float(widths(cell)[axes].min()) if any(axes) else math.inf
    inverse = np.linalg.inv(cell)
    for term in bonded.terms:
        for a, b in _VECTORS[term.kind]:
            apart = beads.positions[term.beads[:, a]] - beads.positions[term.beads[:, b]]
            fractions = (apart @ inverse) * np.array(periodic)
            lengths = np.linalg.norm((fractions - np.rint(fractions)) @ cell, axis=1)
            if (lengths > limit).any():
                worst = int(lengths.argmax())
                i, j = sorted(int(term.beads[worst, k]) + 1 for k in (a, b))
                message = f"beads {i} and {j} of {_an(term.kind)} ({term.explanation}) are {lengths[worst]:g} apart, "
                message += f"more than half the cell's width ({limit:g}): which image is meant is not certain"
                raise SceneError(message, path=config_path)
