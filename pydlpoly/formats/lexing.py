"""Cuts text files into words with line numbers, and turns words into numbers by Fortran's rules."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple, NoReturn

from pydlpoly.errors import InputError

# Fortran's list-directed reals: no digit before or after the point, d and q exponents, and the exponent without a
# letter that Fortran itself prints when the exponent has three digits (0.1234567890-100).
_REAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdDqQ][+-]?[0-9]+|[+-][0-9]+)?")
_BARE_EXPONENT = re.compile(r"(?<=[0-9.])([+-][0-9]+)$")
_NUMBER_LIKE = re.compile(r"[+-]?\.?[0-9]|[+-]?(?:nan|inf|infinity)(?:$|\()", re.IGNORECASE)

WORD_LIMIT = 8
"""Characters of a species name that count; DL_POLY drops the rest."""


class Line(NamedTuple):
    """One line of a file: its number from 1, its words, and its text without the line end."""

    number: int
    words: tuple[str, ...]
    text: str


def read_text(path: str | Path) -> str:
    """Return the whole text of a file, with every line end as ``\\n``.

    Bytes that are not UTF-8 are taken as Latin-1, so that an accent in a title never stops a run.

    Raises:
        InputError: the file does not exist, cannot be read, or is a folder.
    """
    try:
        raw = Path(path).read_bytes()
    except OSError as error:
        raise cannot_read(path, error) from error
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    return plain_line_ends(text)


def cannot_read(path: str | Path, error: OSError | ValueError) -> InputError:
    """Return the error for a file that the operating system does not hand out."""
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return InputError(f"the file cannot be read: {reason}", path=str(path))


def plain_line_ends(text: str) -> str:
    """Return the text with Windows' and old Macs' line ends replaced by ``\\n``."""
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def split_words(text: str, comments: str = "#!") -> tuple[str, ...]:
    """Return the blank-separated words of a line up to the first word that begins with a comment character."""
    words = text.split()
    if comments:
        for position, word in enumerate(words):
            if word[0] in comments:
                return tuple(words[:position])
    return tuple(words)


def content_lines(lines: Iterable[str], first: int = 1, comments: str = "#!") -> list[Line]:
    """Return the lines that hold at least one word outside comments; ``first`` is the number of the first one given."""
    return [
        Line(number, words, text.rstrip())
        for number, text in enumerate(lines, first)
        if (words := split_words(text, comments))
    ]


def parse_number(word: str) -> float | None:
    """Return the value of a Fortran real or a simple fraction ``a/b``, or None when the word is neither.

    Accepts ``1``, ``.5``, ``10000.``, ``1d-6``, ``5.d-4``, ``0.5-100``. Words for NaN and infinity, numbers too large
    for a double, and fractions over zero are not numbers.
    """
    above, slash, below = word.partition("/")
    if slash:
        numerator, denominator = _parse_real(above), _parse_real(below)
        if numerator is None or denominator is None or denominator == 0.0:
            return None
        value = numerator / denominator
        return value if math.isfinite(value) else None
    return _parse_real(word)


def _parse_real(word: str) -> float | None:
    if not _REAL.fullmatch(word):
        return None
    plain = word.lower().replace("d", "e").replace("q", "e")
    if "e" not in plain:
        plain = _BARE_EXPONENT.sub(r"e\1", plain)
    value = float(plain)
    return value if math.isfinite(value) else None


def parse_integer(word: str) -> int | None:
    """Return the value of a whole number, also when it is written as a real (``3.0``), or None."""
    value = parse_number(word)
    if value is None or value != int(value):
        return None
    # int() of the word itself keeps every digit of numbers beyond 2**53.
    return int(word) if re.fullmatch(r"[+-]?[0-9]{1,18}", word) else int(value)


def looks_like_number(word: str) -> bool:
    """Tell whether a word was meant as a number, well-formed or not (``25.O``, ``1.0.0``, ``nan``)."""
    return _NUMBER_LIKE.match(word) is not None


class LineReader:
    """Walks through the content lines of one file, with one line of look-ahead, and makes errors with their place."""

    def __init__(self, lines: list[Line], path: str, last_line: int) -> None:
        """Take the content lines, the file's name, and the number of the file's last line for "file ended" errors."""
        self.path = path
        self._lines = lines
        self._position = 0
        self.last_line = last_line

    def peek(self, ahead: int = 0) -> Line | None:
        """Return the line that ``next`` will give (or one further on), or None at the end."""
        position = self._position + ahead
        return self._lines[position] if position < len(self._lines) else None

    def next(self, expected: str) -> Line:
        """Return the next line; at the end of the file raise an error that says what was expected."""
        line = self.peek()
        if line is None:
            raise InputError(f"the file ends here; expected {expected}", path=self.path, line=self.last_line)
        self._position += 1
        return line

    def fail(self, message: str, line: Line | int, word: str | None = None) -> NoReturn:
        """Raise an InputError at this line."""
        number = line if isinstance(line, int) else line.number
        raise InputError(message, path=self.path, line=number, word=word)
