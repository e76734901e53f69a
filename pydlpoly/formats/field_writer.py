"""Writes FIELD files: every record of a Field as DL_POLY reads it, numbers with all their digits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite

from pydlpoly.errors import InputError
from pydlpoly.formats.field_keys import WRITTEN
from pydlpoly.formats.lexing import WORD_LIMIT, split_words
from pydlpoly.formats.records import AtomLine, BondedLine, Field, Molecule, MoleculeBlock

_UNITS = {"ev": "eV", "kcal": "kcal", "kj": "kJ", "k": "K", "internal": "internal", "dpd": "dpd"}
_RIGID_WIDTH = 16  # the count and 15 bead numbers make a rigid unit's first line, 16 bead numbers each further one


def write_field(field: Field) -> str:
    """Return the text of a FIELD file; reading it gives an equal record.

    Raises:
        InputError: a name, unit or title cannot be written so that it would be read back.
    """
    if field.units not in _UNITS:
        raise InputError(f"unknown energy unit; known are {', '.join(_UNITS)}", path=field.path, word=field.units)
    return "\n".join(_lines(field)) + "\n"


def _lines(field: Field) -> Iterator[str]:
    yield _one_line(field.title, "the title")
    yield f"units {_UNITS[field.units]}"
    yield f"molecules {len(field.molecules)}"
    for molecule in field.molecules:
        yield from _molecule(molecule)
    if field.rdf_pairs:
        yield f"rdf {len(field.rdf_pairs)}"
        yield from (f"{_species(a):8s} {_species(b)}" for a, b in field.rdf_pairs)
    if field.pairs:
        yield f"vdw {len(field.pairs)}"
    for pair in field.pairs:
        a, b = pair.species
        yield _joined(f"{_species(a):8s} {_species(b):8s} {pair.key:4s}", pair.parameters)
    for block in field.others:
        yield from (_one_line(line, f"a line of {block.directive}") for line in block.lines)
    for external in field.externals:
        yield "extern"
        yield _joined(external.key, external.parameters)
    yield "close"
    for extension in field.extensions:
        yield f"extension {extension.name}"
        yield from (_one_line(text, f"a line of extension {extension.name}") for _, text in extension.lines)
        yield "end extension"


def _molecule(molecule: Molecule) -> Iterator[str]:
    yield _molecule_name(molecule.name)
    yield f"nummols {molecule.count}"
    yield f"atoms {molecule.beads_per_molecule}"
    yield from (_atom(atom) for atom in molecule.atoms)
    for block in molecule.blocks:
        yield from _pmf(block) if block.directive == "pmf" else _block(block)
    yield "finish"


def _atom(atom: AtomLine) -> str:
    return f"{_joined(f'{_species(atom.name):8s}', (atom.mass, atom.charge))} {atom.repeat} {atom.frozen}"


def _block(block: MoleculeBlock) -> Iterator[str]:
    yield f"{WRITTEN[block.directive]} {len(block.lines)}"
    for line in block.lines:
        if block.directive == "rigid":
            yield from _rigid(line)
        else:
            beads = " ".join(f"{bead:5d}" for bead in line.beads)
            yield _joined(f"{line.key:4s} {beads}" if line.key else beads, line.parameters)


def _rigid(line: BondedLine) -> Iterator[str]:
    numbers = (len(line.beads), *line.beads)
    for start in range(0, len(numbers), _RIGID_WIDTH):
        yield " ".join(f"{number:5d}" for number in numbers[start : start + _RIGID_WIDTH])


def _pmf(block: MoleculeBlock) -> Iterator[str]:
    length, *units = block.lines
    yield _joined("pmf", length.parameters)
    for unit in units:
        yield f"pmf unit {len(unit.beads)}"
        yield from (_joined(f"{bead:5d}", (weight,)) for bead, weight in zip(unit.beads, unit.parameters, strict=True))


def _joined(start: str, numbers: Sequence[float]) -> str:
    broken = next((number for number in numbers if not isfinite(number)), None)
    if broken is not None:
        raise InputError("a number that is not finite cannot be written", word=f"{start.strip()} … {broken}")
    return " ".join((start, *(repr(float(number)) for number in numbers))).rstrip()


def _one_line(text: str, what: str) -> str:
    if "\n" in text or "\r" in text:
        raise InputError(f"{what} must be one line", word=text)
    return text


def _species(name: str) -> str:
    if not 1 <= len(name) <= WORD_LIMIT or split_words(name) != (name,):
        expected = f"1 to {WORD_LIMIT} characters without blanks, not beginning with # or !"
        raise InputError(f"this species name cannot be written; expected {expected}", word=name)
    return name


def _molecule_name(name: str) -> str:
    if _one_line(name, "a molecule's name") != name.strip() or (name and not split_words(name)):
        raise InputError("a molecule's name must not begin with #, !, or a blank, or end with one", word=name)
    return name
