"""Reads FIELD files: energy unit, molecules, pair laws, RDF pairs, external fields; DL_MESO's dialect is next door."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn

from pydlpoly.errors import InputError, suggest
from pydlpoly.formats.dl_meso_field import parse_meso_field
from pydlpoly.formats.extensions import read_extensions
from pydlpoly.formats.field_keys import (
    EXTERNAL_KEYS,
    KEPT_WHOLE,
    MOLECULE_DIRECTIVES,
    PAIR_KEYS,
    TOP_DIRECTIVES,
    UNIT_WORDS,
    canonical_directive,
    canonical_unit,
)
from pydlpoly.formats.field_lines import FieldLines
from pydlpoly.formats.field_molecules import read_molecules
from pydlpoly.formats.field_writer import write_field
from pydlpoly.formats.lexing import (
    Line,
    content_lines,
    parse_integer,
    parse_number,
    plain_line_ends,
    read_text,
    split_words,
)
from pydlpoly.formats.records import ExternalLine, Field, Molecule, OtherBlock, PairLine

__all__ = ["looks_like_dl_meso_field", "parse_field", "read_field", "write_field"]


def read_field(path: str | Path, lenient: bool = False) -> Field:
    """Read a FIELD file in DL_POLY's or DL_MESO's dialect.

    Args:
        path: the file.
        lenient: slips that cannot change the physics (no ``close``, an identical entry given twice, no ``units`` line,
            superfluous numbers on atom lines) become warnings of the record.

    Raises:
        InputError: the file cannot be read as a FIELD; the text gives file, line, word and what was expected.
    """
    return parse_field(read_text(path), path=str(path), lenient=lenient)


def parse_field(text: str, path: str = "FIELD", lenient: bool = False) -> Field:
    """Read the text of a FIELD file; arguments and errors as in ``read_field``."""
    raw = plain_line_ends(text).split("\n")
    last = len(raw) - 1 if raw[-1] == "" and len(raw) > 1 else len(raw)
    lines = FieldLines(content_lines(raw[1:], first=2), path, last, lenient)
    if _dl_meso_line(raw):
        return parse_meso_field(raw[0].rstrip(), lines)
    _check_dialect(raw, path)
    return _FieldParser(lines).parse(title=raw[0].rstrip())


def looks_like_dl_meso_field(text: str) -> bool:
    """Tell whether a FIELD file is in DL_MESO's dialect, which names its blocks SPECIES and INTERACTIONS."""
    return _dl_meso_line(plain_line_ends(text).split("\n")) is not None


def _dl_meso_line(raw: list[str]) -> Line | None:
    for line in content_lines(raw[1:], first=2):
        word = line.words[0].lower()
        # Exactly a word and a count: an atom line of a species with such a name has more numbers.
        counted = len(line.words) == 2 and parse_integer(line.words[1]) is not None
        if counted and word.startswith(("species", "interact")):
            return line
        if canonical_directive(word, TOP_DIRECTIVES) == "close":
            break
    return None


def _check_dialect(raw: list[str], path: str) -> None:
    """Refuse files that have nothing of a FIELD, quoting the first odd line."""
    lines = content_lines(raw[1:], first=2)
    if any(_is_field_directive(line) for line in lines):
        return
    # A title may be anything, but a first line that is a keyword and a number is no title when no FIELD follows.
    first = split_words(raw[0])
    is_keyword = len(first) == 2 and "_" in first[0] and parse_number(first[1]) is not None
    odd = Line(1, first, raw[0]) if is_keyword or not lines else lines[0]
    shown = " ".join(odd.text.split())[:60]
    expected = "expected a title, then units and molecules"
    if not shown:
        raise InputError(f"not a DL_POLY or DL_MESO FIELD: the file is empty; {expected}", path=path)
    raise InputError(
        f"not a DL_POLY or DL_MESO FIELD: line {odd.number} is {shown!r}; {expected}", path=path, line=odd.number
    )


def _is_field_directive(line: Line) -> bool:
    word = line.words[0]
    if canonical_directive(word, TOP_DIRECTIVES) in ("units", "close"):
        return True
    counted = any(parse_integer(w) is not None for w in line.words[1:])
    known = canonical_directive(word, TOP_DIRECTIVES) or canonical_directive(word, MOLECULE_DIRECTIVES)
    return counted and known is not None


class _FieldParser:
    """Reads the blocks of one file in the order they come and gathers the record."""

    def __init__(self, lines: FieldLines) -> None:
        self.lines = lines
        self.heads: dict[str, Line] = {}
        self.molecules: tuple[Molecule, ...] = ()
        self.pairs: tuple[PairLine, ...] = ()
        self.rdf_pairs: tuple[tuple[str, str], ...] = ()
        self.externals: list[ExternalLine] = []
        self.others: list[OtherBlock] = []

    def parse(self, title: str) -> Field:
        """Read up to ``close`` and return the record."""
        lines = self.lines
        while (line := self._next_block()) is not None:
            directive = canonical_directive(line.words[0], TOP_DIRECTIVES)
            if directive is None:
                self._fail_unknown(line)
            if directive == "neutral":
                lines.fail("neutral (charge) groups are not known to DL_POLY 4 and later", line, line.words[0])
            self._check_order(directive, line)
            if directive in KEPT_WHOLE:
                self.others.append(self._read_other(directive, line))
            else:
                getattr(self, f"_read_{directive}")(line)
            self.heads[directive] = line
        if not self.molecules and "molecules" not in self.heads:
            lines.complain("the file has no molecules; expected units, molecules, vdw, close", 1)
        return Field(
            title=title,
            units=lines.units or "internal",
            molecules=self.molecules,
            pairs=self.pairs,
            externals=tuple(self.externals),
            rdf_pairs=self.rdf_pairs,
            others=tuple(self.others),
            extensions=read_extensions(lines),
            path=lines.path,
            warnings=lines.warnings,
        )

    def _next_block(self) -> Line | None:
        """Return the line that begins the next block, or None at ``close``."""
        lines = self.lines
        if lines.peek() is None and lines.lenient:
            lines.warn("the file ends without close", lines.last_line)
            return None
        line = lines.next("a further block (vdw, rdf, extern, …) or close")
        return None if canonical_directive(line.words[0], TOP_DIRECTIVES) == "close" else line

    def _check_order(self, directive: str, line: Line) -> None:
        lines, word = self.lines, line.words[0]
        if directive in self.heads:
            lines.fail(f"{directive} is given twice (first on line {self.heads[directive].number})", line, word)
        if directive not in ("units", "molecules") and "molecules" not in self.heads:
            lines.fail("molecules must come before this block, because they name the species", line, word)

    def _fail_unknown(self, line: Line) -> NoReturn:
        lines, word = self.lines, line.words[0]
        following = lines.peek()
        if "vdw" in self.heads and word in lines.species:
            said = f"vdw on line {self.heads['vdw'].number} says {len(self.pairs)}"
            lines.fail(f"{said}, but here is one more pair; correct the number or remove the line", line, word)
        if following and canonical_directive(following.words[0], MOLECULE_DIRECTIVES) == "nummols":
            said = "this looks like a molecule, but "
            if "molecules" not in self.heads:
                lines.fail(f"{said}molecules and their number must come first", line, word)
            said += f"molecules on line {self.heads['molecules'].number} says {len(self.molecules)}"
            lines.fail(f"{said}, and so many have come before", line, word)
        if canonical_directive(word, MOLECULE_DIRECTIVES):
            lines.fail("this directive belongs inside a molecule, between its name and finish", line, word)
        near = suggest(word, [*TOP_DIRECTIVES.values(), "extern"])
        lines.fail(f"unknown directive; expected units, molecules, vdw, rdf, extern, close{near}", line, word)

    def _read_units(self, line: Line) -> None:
        if self.lines.units is not None:
            self.lines.fail("units must come before the first energies", line, line.words[0])
        word = line.words[1] if len(line.words) > 1 else ""
        unit = canonical_unit(word) if word else "internal"
        if unit is None:
            near = suggest(word, UNIT_WORDS) or f"; known are {', '.join(UNIT_WORDS)}, or nothing for internal"
            self.lines.fail(f"unknown energy unit{near}", line, word)
        self.lines.units = unit

    def _read_molecules(self, line: Line) -> None:
        count = self.lines.count(line, "the number of molecule types")
        self.molecules = read_molecules(self.lines, count, line)

    def _read_vdw(self, head: Line) -> None:
        lines = self.lines
        lines.need_units(head)
        count = lines.count(head, "the number of pairs")
        pairs: list[PairLine] = []
        seen: dict[tuple[str, ...], PairLine] = {}
        for done in range(count):
            pair = self._pair_line(head, done, count)
            same = tuple(sorted(pair.species))
            if same in seen:
                self._repeated_pair(seen[same], pair)
                continue
            seen[same] = pair
            pairs.append(pair)
        self.pairs = tuple(pairs)

    def _pair_line(self, head: Line, done: int, count: int) -> PairLine:
        lines = self.lines
        line = self._species_line(head, done, count, "pair")
        species = (lines.known_species(line, 0), lines.known_species(line, 1))
        if len(line.words) < 3:
            lines.fail("the line is too short; expected two species, the pair law's key and its numbers", line)
        key = line.words[2][:4].lower()
        if key not in PAIR_KEYS:
            near = suggest(line.words[2], PAIR_KEYS) or f"; known are {' '.join(sorted(PAIR_KEYS))}"
            lines.fail(f"unknown pair law{near}", line, line.words[2])
        return PairLine(species, key, lines.trailing_numbers(line, 3), line.number)

    def _species_line(self, head: Line, done: int, count: int, what: str) -> Line:
        """Return the next line of a block whose lines begin with two species, not the start of another block."""
        lines = self.lines
        name = head.words[0].lower()
        line = lines.next(f"{what} {done + 1} of {count} ({name} on line {head.number})")
        word = line.words[0]
        if canonical_directive(word, TOP_DIRECTIVES) and not self._is_entry(line):
            said = f"{name} on line {head.number} says {count}, but only {done} came before this"
            lines.fail(f"{said}; correct the number or add the missing ones", line, word)
        return line

    def _repeated_pair(self, first: PairLine, again: PairLine) -> None:
        said = f"the pair {' '.join(again.species)} is already given on line {first.line}"
        if (first.key, first.parameters) == (again.key, again.parameters):
            self.lines.complain(f"{said}; remove one of the two", again.line)
        else:
            self.lines.fail(f"{said}; remove one of the two", again.line)

    def _read_rdf(self, head: Line) -> None:
        lines = self.lines
        count = lines.count(head, "the number of pairs")
        seen: dict[tuple[str, ...], int] = {}
        pairs: list[tuple[str, str]] = []
        for done in range(count):
            line = self._species_line(head, done, count, "RDF pair")
            pair = (lines.known_species(line, 0), lines.known_species(line, 1))
            same = tuple(sorted(pair))
            if same in seen:
                lines.complain(f"the pair {' '.join(pair)} is already given on line {seen[same]}", line)
                continue
            seen[same] = line.number
            pairs.append(pair)
        self.rdf_pairs = tuple(pairs)

    def _read_external(self, head: Line) -> None:
        lines = self.lines
        lines.need_units(head)
        line = lines.next(f"the external field's key and numbers ({head.words[0].lower()} on line {head.number})")
        key = line.words[0][:4].lower()
        if key not in EXTERNAL_KEYS:
            near = suggest(line.words[0], EXTERNAL_KEYS) or f"; known are {' '.join(sorted(EXTERNAL_KEYS))}"
            lines.fail(f"unknown external field{near}", line, line.words[0])
        self.externals.append(ExternalLine(key, lines.trailing_numbers(line, 1), line.number))

    def _is_entry(self, line: Line) -> bool:
        """Tell an entry of a species that is called like a directive from the directive with its number."""
        return line.words[0] in self.lines.species and len(line.words) > 1 and parse_integer(line.words[1]) is None

    def _read_other(self, directive: str, head: Line) -> OtherBlock:
        """Keep a block as it stands, its head included, up to the next directive."""
        lines = self.lines
        kept = [head.text.strip()]
        while (line := lines.peek()) is not None:
            if canonical_directive(line.words[0], TOP_DIRECTIVES) not in (None, directive) and not self._is_entry(line):
                break
            kept.append(lines.next("").text.strip())
        return OtherBlock(directive, tuple(kept), head.number)
