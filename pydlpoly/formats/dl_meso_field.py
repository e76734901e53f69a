"""FIELD files in DL_MESO's dialect: SPECIES, MOLECULES with the places of their beads, INTERACTIONS, EXTERNAL.

They become the records of DL_POLY's FIELD with reduced units: beads outside molecules are molecules of one bead, and
bonded terms have the restraint form, because bonded beads keep their pair forces in DL_MESO.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple, NoReturn, cast

from pydlpoly.errors import suggest
from pydlpoly.formats.extensions import read_extensions
from pydlpoly.formats.field_keys import canonical_directive
from pydlpoly.formats.field_lines import FieldLines
from pydlpoly.formats.field_molecules import bead_number, check_beads
from pydlpoly.formats.lexing import Line, parse_integer, parse_number
from pydlpoly.formats.records import (
    AtomLine,
    BondedLine,
    ExternalLine,
    Field,
    MesoField,
    Molecule,
    MoleculeBlock,
    PairLine,
    Remark,
)

_TOP = {
    "speci": "species",
    "molecul": "molecules",
    "interact": "interactions",
    "extern": "external",
    "surf": "surface",
    "froz": "frozen",
    "units": "units",
    "close": "close",
}
_INSIDE = {
    "nummol": "nummols",
    "bead": "beads",
    "bond": "bonds",
    "constr": "constraints",
    "angle": "angles",
    "dihed": "dihedrals",
    "no": "no",
    "finish": "finish",
}
_BEADS = {"bonds": 2, "constraints": 2, "angles": 3, "dihedrals": 4}


class _Law(NamedTuple):
    """A bonded law: DL_POLY's key in the restraint form, and the names of its numbers."""

    key: str
    numbers: tuple[str, ...]


_LAWS: Mapping[str, Mapping[str, _Law]] = {
    "bonds": {"harm": _Law("-hrm", ("k", "r0")), "fene": _Law("-fne", ("k", "rmax"))},
    "angles": {
        "harm": _Law("-hrm", ("k", "theta0")),
        "hcos": _Law("-hcs", ("k", "theta0")),
        "cos": _Law("-cos", ("A", "delta", "m")),
    },
    "dihedrals": {
        "harm": _Law("-hrm", ("k", "phi0")),
        "hcos": _Law("-hcs", ("k", "phi0")),
        "cos": _Law("-cos", ("A", "delta", "m")),
    },
}
"""The bonded laws that mean the same in both programs, by block and key."""

_PAIR_LAWS = {"dpd": ("a", "rc", "drag"), "lj": ("epsilon", "sigma", "drag"), "wca": ("epsilon", "sigma", "drag")}
_REFUSED_PAIRS = {"mdpd": "many-body DPD", "tab": "tabulated interactions"}
_REFUSED_FIELDS = {"shea": "shear by sliding faces", "ushe": "shear by sliding faces"}


class _Species(NamedTuple):
    mass: float
    charge: float
    beads: int
    frozen: int
    line: int


class _Parts(NamedTuple):
    """A molecule as far as one pass can read it."""

    molecule: Molecule
    coordinates: tuple[tuple[float, float, float], ...]
    mirrored: bool


def parse_meso_field(title: str, lines: FieldLines) -> Field:
    """Read the lines after the title; errors as in ``read_field``."""
    lines.units = "dpd"
    return _MesoParser(lines).parse(title)


class _MesoParser:
    """Reads the blocks of one file, which may come in any order, and gathers the record."""

    def __init__(self, lines: FieldLines) -> None:
        self.lines = lines
        self.heads: dict[str, Line] = {}
        self.species = self._find_species()
        self.parts: list[_Parts] = []
        self.pairs: list[PairLine] = []
        self.externals: list[ExternalLine] = []
        self.remarks: list[Remark] = []
        self.thermal, self.units_line = False, 0

    def parse(self, title: str) -> Field:
        """Read up to ``close`` and return the record."""
        lines = self.lines
        while (line := self._next_block()) is not None:
            directive = canonical_directive(line.words[0], _TOP)
            if directive is None:
                self._fail_unknown(line)
            if directive in self.heads and directive != "external":
                head = self.heads[directive]
                lines.fail(f"{directive} is given twice (first on line {head.number})", line, line.words[0])
            self.heads[directive] = line
            getattr(self, f"_read_{directive}")(line)
        for needed in ("species", "interactions"):
            if needed not in self.heads:
                lines.fail(f"a FIELD of DL_MESO needs a block {needed}, which is missing", 1, needed)
        return self._record(title)

    def _record(self, title: str) -> Field:
        """Put loose beads before molecules, as in DL_MESO's CONFIG."""
        inside = {atom.name for part in self.parts for atom in part.molecule.atoms}
        loose = [
            Molecule(name, one.beads, (self._atom(name, one.line),), (), one.line)
            for name, one in self.species.items()
            if one.beads or name not in inside
        ]
        count = len(loose)
        return Field(
            title=title,
            units="dpd",
            molecules=(*loose, *(part.molecule for part in self.parts)),
            pairs=tuple(self.pairs),
            externals=tuple(self.externals),
            path=self.lines.path,
            warnings=self.lines.warnings,
            remarks=tuple(self.remarks),
            extensions=read_extensions(self.lines),
            meso=MesoField(
                coordinates=(((0.0, 0.0, 0.0),),) * count + tuple(part.coordinates for part in self.parts),
                mirrored=(False,) * count + tuple(part.mirrored for part in self.parts),
                loose=sum(one.beads for one in self.species.values()),
                thermal=self.thermal,
                units_line=self.units_line,
            ),
        )

    def _next_block(self) -> Line | None:
        lines = self.lines
        if lines.peek() is None and lines.lenient:
            lines.warn("the file ends without close", lines.last_line)
            return None
        line = lines.next("a further block (species, molecules, interactions, external) or close")
        return None if canonical_directive(line.words[0], _TOP) == "close" else line

    def _fail_unknown(self, line: Line) -> NoReturn:
        lines, word = self.lines, line.words[0]
        for block, found in (("species", len(self.species)), ("interactions", len(self.pairs))):
            if list(self.heads)[-1:] == [block] and len(line.words) > 2:
                said = f"{block} on line {self.heads[block].number} says {found}, but here is one more"
                lines.fail(f"{said}; correct the number or remove the line", line, word)
        if canonical_directive(word, _INSIDE):
            lines.fail("this directive belongs inside a molecule, between its name and finish", line, word)
        near = suggest(word, [*_TOP.values()])
        lines.fail(f"unknown directive; expected species, molecules, interactions, external, close{near}", line, word)

    # -- species ------------------------------------------------------------------------------------------------------

    def _find_species(self) -> dict[str, _Species]:
        """Read the SPECIES block ahead of everything else, because molecules may come before it."""
        lines, ahead = self.lines, 0
        while (head := lines.peek(ahead)) is not None:
            counted = len(head.words) > 1 and parse_integer(head.words[1]) is not None
            if counted and canonical_directive(head.words[0], _TOP) == "species":
                return self._species_lines(head, ahead + 1)
            ahead += 1
        return {}

    def _species_lines(self, head: Line, ahead: int) -> dict[str, _Species]:
        lines = self.lines
        count = lines.count(head, "the number of species", least=1)
        found: dict[str, _Species] = {}
        for done in range(count):
            line = lines.peek(ahead + done)
            said = f"SPECIES on line {head.number} says {count}, but only {done} came before this"
            if line is None:
                lines.fail(f"the file ends here; {said}", lines.last_line)
            if canonical_directive(line.words[0], _TOP) and len(line.words) < 3:
                lines.fail(f"{said}; correct the number or add the missing ones", line, line.words[0])
            name = lines.species_name(line.words[0], line, defines=True)
            if name in found:
                lines.fail(f"this species is already given on line {found[name].line}", line, name)
            found[name] = self._one_species(line)
            lines.species[name] = line.number
        return found

    def _one_species(self, line: Line) -> _Species:
        lines = self.lines
        mass = lines.number(line, 1, "the mass")
        charge = lines.number(line, 2, "the charge") if len(line.words) > 2 else 0.0
        count = self._whole(line, 3, "the number of beads outside molecules") if len(line.words) > 3 else 0
        frozen = self._whole(line, 4, "the frozen flag (0 moves, 1 is frozen)") if len(line.words) > 4 else 0
        if len(line.words) > 5:
            lines.complain("takes mass, charge, number and frozen flag; this is left over", line, line.words[5])
        return _Species(mass, charge, count, frozen, line.number)

    def _whole(self, line: Line, position: int, what: str) -> int:
        value = parse_integer(line.words[position])
        if value is None or value < 0:
            self.lines.fail(f"expected {what}, a whole number of at least 0", line, line.words[position])
        return value

    def _read_species(self, _: Line) -> None:
        for _name in self.species:
            self.lines.next("a species")

    def _atom(self, name: str, line: int) -> AtomLine:
        one = self.species[name]
        return AtomLine(name, one.mass, one.charge, 1, one.frozen, line)

    # -- molecules ----------------------------------------------------------------------------------------------------

    def _read_molecules(self, head: Line) -> None:
        count = self.lines.count(head, "the number of molecule types")
        self.parts = [self._molecule(head, ordinal, count) for ordinal in range(1, count + 1)]

    def _molecule(self, head: Line, ordinal: int, count: int) -> _Parts:
        lines = self.lines
        name, start = self._molecule_name(head, ordinal, count)
        given: dict[str, int] = {}
        copies: int | None = None
        atoms: tuple[AtomLine, ...] = ()
        coordinates: tuple[tuple[float, float, float], ...] = ()
        blocks: list[MoleculeBlock] = []
        mirrored = True
        while True:
            line = lines.next(f"finish, which ends molecule {name!r} (begun on line {start})")
            word = line.words[0]
            directive = canonical_directive(word, _INSIDE)
            if directive == "finish":
                break
            if directive is None or (directive == "no" and not self._is_no_isomer(line)):
                near = suggest(word, _INSIDE.values())
                lines.fail(f"unknown directive inside molecule {name!r}; expected beads or finish{near}", line, word)
            if directive in given:
                lines.fail(f"{directive} is given twice (first on line {given[directive]})", line, word)
            given[directive] = line.number
            if directive == "no":
                mirrored = False
            elif directive == "nummols":
                copies = lines.count(line, "the number of copies")
            elif directive == "beads":
                atoms, coordinates = self._read_beads(line)
            else:
                blocks.append(self._read_block(directive, line))
        for needed in ("nummols", "beads"):
            if needed not in given:
                lines.fail(f"molecule {name!r} has no {needed}", line, line.words[0])
        molecule = Molecule(name, copies or 0, atoms, tuple(blocks), start)
        check_beads(lines, molecule)
        return _Parts(molecule, coordinates, mirrored)

    def _molecule_name(self, head: Line, ordinal: int, count: int) -> tuple[str, int]:
        lines = self.lines
        expected = f"the name of molecule {ordinal} of {count} (molecules on line {head.number})"
        line, following = lines.peek(), lines.peek(1)
        starts = canonical_directive(line.words[0], _INSIDE) if line else None
        then = canonical_directive(following.words[0], _INSIDE) if following else None
        if line and starts in ("nummols", "beads") and then not in (None, starts, "finish"):
            lines.warn("a molecule has no name", line)
            return "", line.number
        line = lines.next(expected)
        if canonical_directive(line.words[0], _TOP) and len(line.words) == 2 and then is None:
            lines.fail(f"expected {expected}", line, line.words[0])
        return line.text.strip(), line.number

    def _is_no_isomer(self, line: Line) -> bool:
        return line.words[0].lower() == "no" and len(line.words) > 1 and line.words[1].lower().startswith("isomer")

    def _read_beads(self, head: Line) -> tuple[tuple[AtomLine, ...], tuple[tuple[float, float, float], ...]]:
        lines = self.lines
        wanted = lines.count(head, "the number of beads in one molecule", least=1)
        atoms: list[AtomLine] = []
        places: list[tuple[float, float, float]] = []
        for done in range(wanted):
            expected = f"a bead line (beads on line {head.number} says {wanted}, {done} so far)"
            line = lines.next(expected)
            name = lines.species_name(line.words[0], line)
            if name not in self.species:
                if canonical_directive(line.words[0], _INSIDE):
                    lines.fail(f"expected {expected}", line, line.words[0])
                near = suggest(name, self.species) or f"; there are {', '.join(self.species) or 'none'}"
                lines.fail(f"unknown species{near}", line, line.words[0])
            atoms.append(self._atom(name, line.number))
            x, y, z = (lines.number(line, k, f"the coordinate {axis}") for k, axis in enumerate("xyz", 1))
            places.append((x, y, z))
            if len(line.words) > 4:
                lines.complain("takes a species and three coordinates; this is left over", line, line.words[4])
        return tuple(atoms), tuple(places)

    def _read_block(self, directive: str, head: Line) -> MoleculeBlock:
        count = self.lines.count(head, f"the number of {directive}")
        rows = tuple(self._bonded(directive, head, done, count) for done in range(count))
        kind = cast(Literal["bonds", "constraints", "angles", "dihedrals"], directive)
        return MoleculeBlock(kind, rows, head.number)

    def _bonded(self, directive: str, head: Line, done: int, count: int) -> BondedLine:
        lines, beads = self.lines, _BEADS[directive]
        line = lines.next(f"line {done + 1} of {count} of {directive} (begun on line {head.number})")
        word = line.words[0]
        if canonical_directive(word, _INSIDE) and not (len(line.words) > beads + 1):
            said = f"{directive} on line {head.number} says {count}, but only {done} came before this"
            lines.fail(f"{said}; correct the number or add the missing ones", line, word)
        if directive == "constraints":
            start = 0 if parse_number(word) is not None else 1
            members = tuple(bead_number(lines, line, start + k, beads) for k in range(beads))
            return BondedLine("", members, (lines.number(line, start + beads, "the length"),), line.number)
        law = self._law(directive, line)
        members = tuple(bead_number(lines, line, 1 + k, beads) for k in range(beads))
        return BondedLine(law.key, members, self._numbers(line, 1 + beads, law.numbers), line.number)

    def _law(self, directive: str, line: Line) -> _Law:
        laws, key = _LAWS[directive], line.words[0][:4].lower()
        if key not in laws:
            message = f"this law is not modelled in {directive} of DL_MESO's dialect; modelled are {', '.join(laws)}"
            self.lines.fail(message + suggest(key, laws), line, line.words[0])
        return laws[key]

    def _numbers(self, line: Line, start: int, names: tuple[str, ...]) -> tuple[float, ...]:
        """Return the law's numbers; those left out are 0 in DL_MESO, and more than there are must be 0."""
        lines, found = self.lines, self.lines.trailing_numbers(line, start)
        takes = f"takes {len(names)} numbers ({' '.join(names)}), found {len(found)}"
        if not found or any(found[len(names) :]):
            lines.fail(takes, line, line.words[0])
        if len(found) < len(names):
            left = " ".join(names[len(found) :])
            self.remarks.append(Remark("choice", f"{line.words[0]} without {left}: 0, as in DL_MESO", line.number))
        return (*found, *(0.0,) * len(names))[: len(names)]

    # -- the other blocks ---------------------------------------------------------------------------------------------

    def _read_interactions(self, head: Line) -> None:
        lines = self.lines
        count = lines.count(head, "the number of interactions")
        seen: dict[tuple[str, ...], PairLine] = {}
        for done in range(count):
            line = lines.next(f"interaction {done + 1} of {count} (interactions on line {head.number})")
            if canonical_directive(line.words[0], _TOP) and len(line.words) < 4:
                said = f"{head.words[0]} on line {head.number} says {count}, but only {done} came before this"
                lines.fail(f"{said}; correct the number or add the missing ones", line, line.words[0])
            pair = self._pair(line)
            same = tuple(sorted(pair.species))
            if same in seen:
                said = f"the pair {' '.join(pair.species)} is already given on line {seen[same].line}"
                equal = (seen[same].key, seen[same].parameters) == (pair.key, pair.parameters)
                (lines.complain if equal else lines.fail)(f"{said}; remove one of the two", line)
                continue
            seen[same] = pair
            self.pairs.append(pair)

    def _pair(self, line: Line) -> PairLine:
        lines = self.lines
        species = (self._species_at(line, 0), self._species_at(line, 1))
        if len(line.words) < 3:
            lines.fail("the line is too short; expected two species, the law's key and its numbers", line)
        word = line.words[2]
        key = word[:4].lower()
        if key in _REFUSED_PAIRS:
            lines.fail(
                f"{_REFUSED_PAIRS[key]} is read from a FIELD of DL_POLY only; here {', '.join(_PAIR_LAWS)} are",
                line,
                word,
            )
        if key not in _PAIR_LAWS:
            near = suggest(word, _PAIR_LAWS) or f"; known are {', '.join(_PAIR_LAWS)}"
            lines.fail(f"unknown interaction{near}", line, word)
        found = self._numbers(line, 3, _PAIR_LAWS[key])
        if any(number < 0.0 for number in found):
            lines.warn(f"{' '.join(line.words[2:])}: negative numbers lose their sign, as in DL_MESO", line)
            found = tuple(abs(number) for number in found)
        if key == "wca":
            found = (*found[:2], 0.0, found[2])  # DL_POLY's wca has a shift of r before the drag
        return PairLine(species, key, found, line.number)

    def _species_at(self, line: Line, position: int) -> str:
        """Return a species given by its name or, as DL_MESO also allows, by its number."""
        word = line.words[position] if position < len(line.words) else ""
        number = parse_integer(word) if word else None
        if word not in self.species and number is not None and 1 <= number <= len(self.species):
            return list(self.species)[number - 1]
        return self.lines.known_species(line, position)

    def _read_external(self, head: Line) -> None:
        line = self.lines.next(f"the external field's key and numbers ({head.words[0].lower()} on line {head.number})")
        key = line.words[0][:4].lower()
        if key in _REFUSED_FIELDS:
            self.lines.fail(f"{_REFUSED_FIELDS[key]} is not modelled", line, line.words[0])
        if key not in ("grav", "elec"):
            near = suggest(key, ("grav", "elec")) or "; known are grav, elec"
            self.lines.fail(f"unknown external field{near}", line, line.words[0])
        self.externals.append(ExternalLine(key, self._numbers(line, 1, ("x", "y", "z")), line.number))

    def _read_surface(self, head: Line) -> None:
        self.lines.fail(
            "walls at the faces of the box are not read here; a new-style CONTROL has wall_method",
            head,
            head.words[0],
        )

    def _read_frozen(self, head: Line) -> None:
        self.lines.fail(
            "walls of frozen beads are not read here; a new-style CONTROL has wall_method",
            head,
            head.words[0],
        )

    def _read_units(self, head: Line) -> None:
        word = head.words[1].lower() if len(head.words) > 1 else "internal"
        if word not in ("internal", "dpd", "kt"):
            self.lines.fail("unknown energy unit; known are internal, kT", head, head.words[1])
        self.thermal, self.units_line = word == "kt", head.number
