"""Reads the molecules of a FIELD file: atom lines, bonded blocks, rigid units, mean-force constraints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NoReturn

from pydlpoly.errors import suggest
from pydlpoly.formats.field_keys import (
    BONDED,
    MOLECULE_DIRECTIVES,
    TOP_DIRECTIVES,
    canonical_directive,
)
from pydlpoly.formats.field_lines import FieldLines
from pydlpoly.formats.lexing import Line, looks_like_number, parse_integer, parse_number
from pydlpoly.formats.records import AtomLine, BondedLine, Molecule, MoleculeBlock


class _Parts:
    """What has been gathered of one molecule so far."""

    def __init__(self, name: str, line: int) -> None:
        self.name, self.line = name, line
        self.count: int | None = None
        self.atoms: tuple[AtomLine, ...] = ()
        self.atoms_line = 0
        self.blocks: list[MoleculeBlock] = []

    @property
    def label(self) -> str:
        return f"molecule {self.name!r}" if self.name else "the molecule without a name"


def read_molecules(lines: FieldLines, count: int, head: Line) -> tuple[Molecule, ...]:
    """Return ``count`` molecules from the lines that follow the ``molecules`` directive ``head``."""
    return tuple(_read_molecule(lines, ordinal, count, head) for ordinal in range(1, count + 1))


def _read_molecule(lines: FieldLines, ordinal: int, count: int, head: Line) -> Molecule:
    parts = _read_name(lines, ordinal, count, head)
    while True:
        line = lines.next(f"finish, which ends {parts.label} (begun on line {parts.line})")
        directive = canonical_directive(line.words[0], MOLECULE_DIRECTIVES)
        if directive == "finish":
            return _finished(lines, parts, line)
        if directive == "nummols":
            if parts.count is not None:
                lines.fail(f"{parts.label} has nummols twice", line, line.words[0])
            parts.count = lines.count(line, "the number of copies")
        elif directive == "atoms":
            if parts.atoms_line:
                lines.fail(f"{parts.label} has atoms twice (first on line {parts.atoms_line})", line, line.words[0])
            parts.atoms_line = line.number
            parts.atoms = _read_atoms(lines, line)
        elif directive == "neutral":
            lines.fail("neutral (charge) groups are not known to DL_POLY 4 and later", line, line.words[0])
        elif directive is None:
            _fail_unknown(lines, parts, line)
        else:
            _read_block(lines, parts, directive, line)


def _read_name(lines: FieldLines, ordinal: int, count: int, head: Line) -> _Parts:
    expected = f"the name of molecule {ordinal} of {count} (molecules on line {head.number})"
    line = lines.peek() or lines.next(expected)
    following = lines.peek(1)
    starts = canonical_directive(line.words[0], MOLECULE_DIRECTIVES)
    then = canonical_directive(following.words[0], MOLECULE_DIRECTIVES) if following else None
    if starts == "nummols" and then != "nummols":
        lines.warn("a molecule has no name", line)
        return _Parts("", line.number)
    if then is None and canonical_directive(line.words[0], TOP_DIRECTIVES):
        lines.fail(f"expected {expected}", line, line.words[0])
    lines.next(expected)
    return _Parts(line.text.strip(), line.number)


def _fail_unknown(lines: FieldLines, parts: _Parts, line: Line) -> NoReturn:
    word = line.words[0]
    if canonical_directive(word, TOP_DIRECTIVES):
        lines.fail(f"expected finish, which ends {parts.label} (begun on line {parts.line}), before this", line, word)
    if parts.blocks:
        block = parts.blocks[-1]
        kind = BONDED.get(block.directive)
        if kind and (word[:4].lower() in kind.keys or (not kind.keys and parse_integer(word) is not None)):
            said = f"{block.directive} on line {block.line} says {len(block.lines)}, but here is one more"
            lines.fail(f"{said}; correct the number or remove the line", line, word)
    if parts.atoms_line and len(line.words) > 1 and parse_number(line.words[1]) is not None and not parts.blocks:
        total = sum(atom.repeat for atom in parts.atoms)
        said = f"atoms on line {parts.atoms_line} says {total}, but here is one more"
        if any(atom.name == word for atom in parts.atoms) or not suggest(word, MOLECULE_DIRECTIVES.values()):
            lines.fail(f"{said}; correct the number or remove the line", line, word)
    near = suggest(word, MOLECULE_DIRECTIVES.values())
    lines.fail(f"unknown directive inside {parts.label}; expected a bonded block or finish{near}", line, word)


def _finished(lines: FieldLines, parts: _Parts, line: Line) -> Molecule:
    if parts.count is None:
        lines.fail(f"{parts.label} has no nummols line (the number of its copies)", line, line.words[0])
    if not parts.atoms:
        lines.fail(f"{parts.label} has no atoms", line, line.words[0])
    molecule = Molecule(parts.name, parts.count, parts.atoms, tuple(parts.blocks), parts.line)
    check_beads(lines, molecule)
    return molecule


def _read_atoms(lines: FieldLines, head: Line) -> tuple[AtomLine, ...]:
    wanted = lines.count(head, "the number of beads in one molecule", least=1)
    atoms: list[AtomLine] = []
    found = 0
    while found < wanted:
        expected = f"an atom line (atoms on line {head.number} says {wanted} beads, {found} so far)"
        line = lines.next(expected)
        if canonical_directive(line.words[0], MOLECULE_DIRECTIVES) and not _is_atom_line(line):
            lines.fail(f"expected {expected}", line, line.words[0])
        atom = _atom_line(lines, line)
        atoms.append(atom)
        found += atom.repeat
        if found > wanted:
            lines.fail(f"the atom lines make up {found} beads, but atoms on line {head.number} says {wanted}", line)
    return tuple(atoms)


def _is_atom_line(line: Line) -> bool:
    """A species may be called ``Bonds1``; only a name with a mass and a charge behind it is taken as one."""
    return len(line.words) > 2 and all(parse_number(word) is not None for word in line.words[1:3])


def _atom_line(lines: FieldLines, line: Line) -> AtomLine:
    words = line.words
    name = lines.species_name(words[0], line, defines=True)
    lines.species.setdefault(name, line.number)
    mass = lines.number(line, 1, "the mass")
    if mass < 0.0:
        lines.warn(f"the negative mass {words[1]} is taken without its sign, as DL_POLY does", line)
        mass = -mass
    numbers = _atom_numbers(lines, line)
    if not numbers:
        lines.warn_once("atom lines without a charge; it is taken as 0", line)
    charge, repeat, frozen, group = (*numbers, *(0.0, 1.0, 0.0, 0.0)[len(numbers) :])
    if group:
        lines.warn_once("the sixth number of an atom line (the charge group) has no effect, as in DL_POLY", line)
    if repeat != int(repeat) or repeat < 0:
        lines.fail("the repeat count must be a whole number, not negative", line, words[3])
    if frozen != int(frozen):
        lines.fail("the frozen flag must be a whole number (0 moves, 1 is frozen)", line, words[4])
    return AtomLine(name, mass, charge, int(repeat) or 1, int(frozen), line.number)


def _atom_numbers(lines: FieldLines, line: Line) -> tuple[float, ...]:
    """Return charge, repeat, frozen and group as far as they are given; what follows must not be a number."""
    expected = ("the charge", "the repeat count", "the frozen flag", "the charge group")
    numbers: list[float] = []
    for position, word in enumerate(line.words[2:], 2):
        value = parse_number(word)
        if len(numbers) == len(expected):
            if value is not None:
                lines.complain(
                    "an atom line has at most five numbers (mass, charge, repeat, frozen, group)", line, word
                )
            break
        if value is None:
            if looks_like_number(word) and len(numbers) < 3:
                lines.fail(f"expected {expected[len(numbers)]}, a number", line, word)
            lines.remark(line, position)
            break
        numbers.append(value)
    return tuple(numbers)


def _read_block(lines: FieldLines, parts: _Parts, directive: str, head: Line) -> None:
    earlier = next((b for b in parts.blocks if b.directive == directive), None)
    if earlier:
        lines.fail(f"{parts.label} has {directive} twice (first on line {earlier.line})", head, head.words[0])
    if directive not in ("pmf", "rigid", "constraints"):
        lines.need_units(head)
    if directive == "pmf":
        rows = _read_pmf(lines, head)
    else:
        count = lines.count(head, f"the number of {directive} lines")
        if directive == "rigid":
            rows = tuple(_read_rigid(lines, head, i, count) for i in range(count))
        else:
            rows = tuple(_read_bonded(lines, directive, head, i, count) for i in range(count))
    # The directives that do not head a block have been dealt with by the caller.
    parts.blocks.append(MoleculeBlock(directive, rows, head.number))  # type: ignore[arg-type]


def _read_bonded(lines: FieldLines, directive: str, head: Line, done: int, count: int) -> BondedLine:
    kind = BONDED[directive]
    line = lines.next(f"line {done + 1} of {count} of {directive} (begun on line {head.number})")
    key = ""
    if kind.keys:
        word = line.words[0]
        key = word[:4].lower()
        if key not in kind.keys:
            if canonical_directive(word, MOLECULE_DIRECTIVES):
                said = f"{directive} on line {head.number} says {count}, but only {done} came before this"
                lines.fail(f"{said}; correct the number or add the missing ones", line, word)
            near = suggest(word, kind.keys) or f"; known are {' '.join(sorted(kind.keys))}"
            lines.fail(f"unknown key in {directive}{near}", line, word)
    elif canonical_directive(line.words[0], MOLECULE_DIRECTIVES):
        said = f"{directive} on line {head.number} says {count}, but only {done} came before this"
        lines.fail(f"{said}; correct the number or add the missing ones", line, line.words[0])
    start = 1 if kind.keys else 0
    beads = tuple(bead_number(lines, line, start + i, kind.beads) for i in range(kind.beads))
    parameters = lines.trailing_numbers(line, start + kind.beads)
    if directive in ("constraints", "shells") and not parameters:
        what = "the length" if directive == "constraints" else "the spring constant"
        lines.fail(f"expected {what} after the two bead numbers", line)
    return BondedLine(key, beads, parameters, line.number)


def bead_number(lines: FieldLines, line: Line, position: int, needed: int) -> int:
    """Return the bead number at this position of a line that needs ``needed`` of them."""
    if position >= len(line.words):
        lines.fail(f"the line is too short; expected {needed} bead number{'s' if needed > 1 else ''}", line)
    word = line.words[position]
    bead = parse_integer(word)
    if bead is None:
        lines.fail("expected a bead number (a whole number, counted from 1 within the molecule)", line, word)
    return bead


def _read_rigid(lines: FieldLines, head: Line, done: int, count: int) -> BondedLine:
    line = first = lines.next(f"rigid unit {done + 1} of {count} (rigid on line {head.number})")
    size = parse_integer(line.words[0])
    if size is None:
        if canonical_directive(line.words[0], MOLECULE_DIRECTIVES):
            lines.fail(f"rigid on line {head.number} says {count}, but only {done} came before this", line)
        lines.fail("expected the number of beads in the rigid unit", line, line.words[0])
    if size < 2:
        lines.fail("a rigid unit has at least two beads", line, line.words[0])
    words = list(line.words[1:])
    beads: list[int] = []
    while True:
        for position, word in enumerate(words):
            bead = parse_integer(word)
            if bead is None:
                lines.fail(f"expected bead number {len(beads) + 1} of {size} of the rigid unit", line, word)
            beads.append(bead)
            if len(beads) == size:
                _no_more_numbers(lines, line, words[position + 1 :], size)
                return BondedLine("", tuple(beads), (), first.number)
        line = lines.next(f"bead number {len(beads) + 1} of {size} of the rigid unit begun on line {first.number}")
        words = list(line.words)


def _no_more_numbers(lines: FieldLines, line: Line, words: Sequence[str], size: int) -> None:
    if words and looks_like_number(words[0]):
        lines.fail(f"the rigid unit says {size} beads, but more numbers follow", line, words[0])


def _read_pmf(lines: FieldLines, head: Line) -> tuple[BondedLine, ...]:
    """Read the length and the two units; lines have the keys ``length`` and ``unit`` (parameters: the weights)."""
    length = next((v for w in head.words[1:] if (v := parse_number(w)) is not None), None)
    if length is None or length <= 0.0:
        lines.fail("expected the constraint's length, a positive number, after pmf", head, head.words[0])
    rows = [BondedLine("length", (), (length,), head.number)]
    for ordinal in (1, 2):
        line = lines.next(f"pmf unit, number {ordinal} of 2")
        if line.words[0].lower() != "pmf" or len(line.words) < 3 or not line.words[1].lower().startswith("unit"):
            lines.fail(f"expected 'pmf unit' and its number of beads (unit {ordinal} of 2)", line, line.words[0])
        size = lines.count(line, "the number of beads in the unit", least=1)
        members = [_pmf_member(lines, line, i, size) for i in range(size)]
        beads, weights = zip(*members, strict=True)
        rows.append(BondedLine("unit", beads, weights, line.number))
    return tuple(rows)


def _pmf_member(lines: FieldLines, head: Line, done: int, size: int) -> tuple[int, float]:
    line = lines.next(f"bead {done + 1} of {size} of the pmf unit on line {head.number}")
    bead = bead_number(lines, line, 0, 1)
    weights = lines.trailing_numbers(line, 1)
    return bead, weights[0] if weights else 0.0


def check_beads(lines: FieldLines, molecule: Molecule) -> None:
    """Refuse bead numbers outside the molecule, a bead bonded to itself, and the same beads listed twice."""
    beads = molecule.beads_per_molecule
    for block in molecule.blocks:
        seen: dict[tuple[int, ...], int] = {}
        for row in block.lines:
            for bead in row.beads:
                if not 1 <= bead <= beads:
                    lines.fail(f"the molecule has beads 1 to {beads}", row.line, str(bead))
            if len(set(row.beads)) != len(row.beads):
                twice = next(b for b in row.beads if row.beads.count(b) > 1)
                lines.fail(f"bead {twice} appears twice in one entry of {block.directive}", row.line)
            _check_repeated(lines, block.directive, row, seen)
        if block.directive == "pmf" and set(block.lines[1].beads) & set(block.lines[2].beads):
            lines.fail("the two pmf units share a bead", block.line)


def _check_repeated(lines: FieldLines, directive: str, row: BondedLine, seen: dict[tuple[int, ...], int]) -> None:
    if directive == "pmf":
        return
    if directive == "rigid":
        shared = next((b for b in row.beads if (b,) in seen), None)
        if shared is not None:
            lines.fail(f"bead {shared} is already in the rigid unit on line {seen[(shared,)]}", row.line)
        seen.update({(b,): row.line for b in row.beads})
        return
    beads = row.beads
    same = (beads[0], *sorted(beads[1:])) if directive == "inversions" else min(beads, beads[::-1])
    if same not in seen:
        seen[same] = row.line
    elif directive == "dihedrals":
        lines.warn_once("dihedrals given more than once for the same beads; they add up", row.line)
    else:
        lines.complain(f"the same beads are listed in {directive} on line {seen[same]}", row.line)
