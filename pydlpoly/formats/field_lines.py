"""The lines of one FIELD file while they are read: counts, numbers, names, warnings and errors with their place."""

from __future__ import annotations

from pydlpoly.errors import suggest
from pydlpoly.formats.lexing import WORD_LIMIT, Line, LineReader, looks_like_number, parse_integer, parse_number


class FieldLines(LineReader):
    """A line reader that knows FIELD's manners and remembers what later lines are checked against.

    Attributes:
        lenient: slips that cannot change the physics become warnings.
        species: species in order of appearance, with the line that named each first.
        units: canonical energy unit, or None before the ``units`` line.
    """

    def __init__(self, lines: list[Line], path: str, last_line: int, lenient: bool) -> None:
        """Take the content lines after the title."""
        super().__init__(lines, path, last_line)
        self.lenient = lenient
        self.species: dict[str, int] = {}
        self.units: str | None = None
        self._warnings: list[str] = []
        self._repeated: dict[str, list[int]] = {}
        self._remarks: list[tuple[int, str]] = []
        self._long_names: dict[str, str] = {}

    def warn(self, message: str, line: Line | int) -> None:
        """Keep a warning with its place."""
        self._warnings.append(f"{self.path}:{line if isinstance(line, int) else line.number}: {message}")

    def warn_once(self, message: str, line: Line | int) -> None:
        """Keep a warning that many lines may cause; it is told once, with the first line and the number of lines."""
        self._repeated.setdefault(message, []).append(line if isinstance(line, int) else line.number)

    @property
    def warnings(self) -> tuple[str, ...]:
        """All warnings so far."""
        repeated = [
            f"{self.path}:{places[0]}: {message}" + (f" (on {len(places)} lines)" if len(places) > 1 else "")
            for message, places in self._repeated.items()
        ]
        if self._remarks:
            place, word = self._remarks[0]
            more = f" (text on {len(self._remarks)} lines)" if len(self._remarks) > 1 else ""
            repeated.append(f"{self.path}:{place}: {word!r}: text after the numbers is not used{more}")
        return (*self._warnings, *repeated)

    def complain(self, message: str, line: Line | int, word: str | None = None) -> None:
        """Raise an error, or keep it as a warning when the reader is lenient."""
        if not self.lenient:
            self.fail(message, line, word)
        self.warn(message if word is None else f"{word!r}: {message}", line)

    def need_units(self, line: Line) -> None:
        """Refuse energies whose unit has not been said."""
        if self.units is None:
            self.complain("expected a units line before the first energies", line, line.words[0])
            self.units = "internal"

    def count(self, line: Line, what: str, least: int = 0) -> int:
        """Return the whole number of a directive line; words between, such as ``types`` or ``units``, are skipped."""
        word = next((word for word in line.words[1:] if not word.isalpha()), None)
        if word is None:
            self.fail(f"expected {what} after this", line, line.words[0])
        value = parse_integer(word)
        if value is None:
            self.fail(f"expected {what}, a whole number", line, word)
        if value < least:
            self.fail(f"expected {what}, at least {least}", line, word)
        return value

    def number(self, line: Line, position: int, what: str) -> float:
        """Return the number that must stand at this position."""
        if position >= len(line.words):
            self.fail(f"the line is too short; expected {what}", line)
        value = parse_number(line.words[position])
        if value is None:
            self.fail(f"expected {what}, a number", line, line.words[position])
        return value

    def trailing_numbers(self, line: Line, start: int) -> tuple[float, ...]:
        """Return the numbers from this position on; text after them is a remark, a damaged number is an error."""
        values: list[float] = []
        for position in range(start, len(line.words)):
            word = line.words[position]
            value = parse_number(word)
            if value is None:
                if looks_like_number(word):
                    self.fail("expected a number", line, word)
                self.remark(line, position)
                break
            values.append(value)
        return tuple(values)

    def remark(self, line: Line, position: int) -> None:
        """Note that words from this position on are not used."""
        self._remarks.append((line.number, line.words[position]))

    def species_name(self, word: str, line: Line, *, defines: bool = False) -> str:
        """Return the part of a species name that counts; refuse two long names that this makes the same.

        Where species are defined (atom lines) the whole name is kept; elsewhere it may also be given cut.
        """
        short = word[:WORD_LIMIT]
        if len(word) >= WORD_LIMIT:
            full = self._long_names.setdefault(short, word) if defines else self._long_names.get(short, word)
            if full != word and (defines or word != short):
                told = f"only {WORD_LIMIT} characters of a species name count, and {full!r} has the same ones"
                self.fail(told, line, word)
        if word != short:
            self.warn_once(f"species name {word!r} is cut to {short!r}", line)
        return short

    def known_species(self, line: Line, position: int) -> str:
        """Return the species named at this position, which must be one of the molecules' species."""
        if position >= len(line.words):
            self.fail("the line is too short; expected two species", line)
        word = line.words[position]
        name = self.species_name(word, line)
        if name not in self.species:
            near = suggest(name, self.species) or f"; the molecules have {', '.join(self.species) or 'none'}"
            self.fail(f"unknown species{near}", line, word)
        return name
