"""One CONTROL setting as text and back: numbers, switches, options, vectors and their units, by the keyword table."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from functools import cache
from typing import Literal

from pydlpoly.errors import InputError, suggest
from pydlpoly.formats.keywords import KEYWORDS, OPTION_SYNONYMS, Keyword
from pydlpoly.formats.records import Setting, SettingValue
from pydlpoly.units import DIMENSIONS, convert, parse_unit, unit_warning

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[ed][+-]?\d+)?", re.IGNORECASE | re.ASCII)
_INTEGER = re.compile(r"[+-]?\d{1,30}", re.ASCII)
_TRUE, _FALSE = ("on", "y", "yes", "true"), ("off", "n", "no", "false")


@dataclass(frozen=True)
class Parsed:
    """A setting read from text, the words that were left over, and what the user should know about it."""

    setting: Setting
    leftover: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Effect:
    """What pydlpoly does with a setting, and why if it is not simply used."""

    kind: Literal["used", "ignored", "refused"]
    reason: str = ""


@dataclass
class Reading:
    """What has been read so far of a file."""

    path: str
    lenient: bool
    settings: dict[str, Setting] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)

    def complain(self, message: str, line: int, word: str) -> None:
        """Raise an error, or note it when the reading is lenient."""
        error = InputError(message, path=self.path, line=line, word=word)
        if not self.lenient:
            raise error
        self.warnings.append(str(error))

    def add(self, parsed: Parsed, word: str) -> None:
        """Take over a setting that ``word`` gives; a second one is an error, or replaces the first when lenient."""
        setting = parsed.setting
        before = self.settings.pop(setting.keyword, None)
        if before is not None:
            again = "is given twice" if word.lower() == setting.keyword else f"gives {setting.keyword} a second time"
            self.complain(f"{again}, first in line {before.line}", setting.line, word)
        if parsed.leftover:
            self.complain(
                f"is left over after {format_setting(setting)!r}; one keyword, one value and one unit make a line",
                setting.line,
                " ".join(parsed.leftover),
            )
        self.settings[setting.keyword] = setting
        self.warnings.extend(f"{self.path}:{setting.line}: {text}" for text in parsed.warnings)


def parse_number(word: str) -> int | float | None:
    """Return the value of a Fortran real or integer (``1``, ``.5``, ``1d-6``), or None if it is no finite number.

    Whole numbers without point or exponent are returned as int, so that 64-bit seeds keep every digit.
    """
    if _INTEGER.fullmatch(word):
        return int(word)
    if not _NUMBER.fullmatch(word):
        return None
    value = float(word.lower().replace("d", "e"))
    return value if math.isfinite(value) else None


def parse_setting(row: Keyword, text: str, *, path: str = "", line: int = 0) -> Parsed:
    """Read what follows a new-style keyword.

    Args:
        row: the keyword's row of the table.
        text: the rest of the line, without comments.
        path: the file to name in errors.
        line: the line the setting is on.

    Raises:
        InputError: the value or its unit is missing, malformed, or of another kind than the table says.
    """
    words = text.split()
    if not words:
        raise InputError(f"a value is expected: {usage(row)}", path=path, line=line or None, word=row.keyword)
    if row.kind == "string":
        return Parsed(Setting(row.keyword, text.strip(), None, line))
    if row.kind == "bool":
        return _switch(row, words, path, line)
    if row.kind == "option":
        return _option(row, words, path, line)
    if row.kind == "vector":
        return _vector(row, text, path, line)
    return _number(row, words, path, line)


def usage(row: Keyword) -> str:
    """Return what a keyword takes, for messages: ``cutoff <number> <unit: ang, nm, …>``."""
    if row.kind == "bool":
        return f"{row.keyword} on|off"
    if row.kind == "option":
        return f"{row.keyword} {'|'.join(row.options)}"
    if row.kind == "string":
        return f"{row.keyword} <text>"
    if row.kind == "int":
        return f"{row.keyword} <whole number>"
    unit = "" if row.dimension in ("number", "integers", "any") else f" <unit: {DIMENSIONS[row.dimension][1]}>"
    if row.kind == "vector":
        numbers = f"{row.length} numbers" if row.length else "numbers"
        return f"{row.keyword} [ <{numbers}> ]{unit}"
    return f"{row.keyword} <number>{unit}"


def _switch(row: Keyword, words: list[str], path: str, line: int) -> Parsed:
    word = words[0].lower()
    if word not in _TRUE + _FALSE:
        message = f"{row.keyword} is a switch and takes on or off (also y, n, yes, no, true, false)"
        raise InputError(message, path=path, line=line or None, word=words[0])
    value = word in _TRUE
    warnings = []
    if value and word not in ("on", "y"):
        warnings.append(f"{row.keyword}: DL_POLY reads {words[0]!r} as off; pydlpoly takes it as on; write on")
    return Parsed(Setting(row.keyword, value, None, line), tuple(words[1:]), tuple(warnings))


def _option(row: Keyword, words: list[str], path: str, line: int) -> Parsed:
    synonyms = OPTION_SYNONYMS.get(row.keyword, {})
    word = words[0].lower()
    value = synonyms.get(word, word)
    if value not in row.options:
        alike = [option for option in row.options if option.startswith(word[:4])]
        hint = f"; did you mean {', '.join(alike)}?" if alike else suggest(word, [*row.options, *synonyms])
        message = f"is no option of {row.keyword}, which takes {', '.join(row.options)}{hint}"
        raise InputError(message, path=path, line=line or None, word=words[0])
    return Parsed(Setting(row.keyword, value, None, line), tuple(words[1:]))


def _vector(row: Keyword, text: str, path: str, line: int) -> Parsed:
    text = text.strip()
    if row.keyword == "random_seed" and len(text.split()) == 1 and "[" not in text:
        return _single_seed(row, text, path, line)
    inside, closed, after = text[1:].partition("]")
    if not text.startswith("[") or not closed:
        message = f"numbers in brackets are expected: {usage(row)}"
        raise InputError(message, path=path, line=line or None, word=row.keyword)
    numbers = tuple(_read_number(row, word, path, line) for word in inside.split())
    if (row.length and len(numbers) != row.length) or not numbers:
        message = f"{row.length or 'some'} numbers are expected in the brackets, not {len(numbers)}"
        raise InputError(message, path=path, line=line or None, word=row.keyword)
    unit, leftover, warnings = _unit(row, after.split(), path, line)
    value = numbers if row.dimension == "integers" else tuple(float(n) for n in numbers)
    return Parsed(Setting(row.keyword, value, unit, line), leftover, warnings)


def _single_seed(row: Keyword, word: str, path: str, line: int) -> Parsed:
    number = parse_number(word)
    if not isinstance(number, int) or not 0 <= number < 2**64:
        message = "a seed is three whole numbers in brackets or one whole number from 0 to 18446744073709551615"
        raise InputError(message, path=path, line=line or None, word=word)
    return Parsed(Setting(row.keyword, (number,), None, line))


def _number(row: Keyword, words: list[str], path: str, line: int) -> Parsed:
    number = _read_number(row, words[0], path, line)
    if row.kind == "int":
        return Parsed(Setting(row.keyword, number, None, line), tuple(words[1:]))
    unit, leftover, warnings = _unit(row, words[1:], path, line)
    value: int | float = float(number)
    if row.kind == "steps" and unit is not None and unit.lower() == "steps":
        value = whole(number, path, line, words[0])
    return Parsed(Setting(row.keyword, value, unit, line), leftover, warnings)


def _read_number(row: Keyword, word: str, path: str, line: int) -> int | float:
    number = parse_number(word)
    if number is None:
        raise InputError(f"a number is expected: {usage(row)}", path=path, line=line or None, word=word)
    if row.dimension == "integers":
        return whole(number, path, line, word)
    if not math.isfinite(float(number)):  # whole numbers of up to 30 digits always fit
        raise InputError("this number is out of range", path=path, line=line or None, word=word)
    return number


def whole(number: int | float, path: str, line: int, word: str) -> int:
    """Return a number that must be whole (``50`` or ``50.0``) as int.

    Raises:
        InputError: it has a fraction.
    """
    if number != int(number):
        raise InputError("a whole number is expected", path=path, line=line or None, word=word)
    return int(number)


def _unit(row: Keyword, words: list[str], path: str, line: int) -> tuple[str | None, tuple[str, ...], tuple[str, ...]]:
    """Take the unit word off the words after a number; return unit, leftover words and warnings."""
    if row.dimension == "integers":
        return None, tuple(words), ()
    if not words:
        if row.dimension not in ("number", "any"):
            message = f"a unit is needed after the number: {usage(row)}"
            raise InputError(message, path=path, line=line or None, word=row.keyword)
        return None, (), ()
    unit = words[0]
    where = line or None
    if row.dimension == "any":
        parse_unit(unit, path=path, line=where)
    else:  # any timestep and temperature will do: only the dimension is tested here
        convert(1.0, unit, row.dimension, timestep=1.0, temperature=1.0, path=path, line=where)
    warning = unit_warning(unit)
    return unit, tuple(words[1:]), () if warning is None else (f"{row.keyword}: {warning}",)


def format_setting(setting: Setting) -> str:
    """Return a setting as a new-style line, such that reading it gives an equal setting.

    Raises:
        InputError: a text cannot be written because it is empty or has a comment character or a line break in it.
    """
    row = KEYWORDS[setting.keyword]
    value = setting.value
    if isinstance(value, bool):
        text = "on" if value else "off"
    elif isinstance(value, tuple):
        seed = row.keyword == "random_seed" and len(value) == 1
        text = format_number(value[0]) if seed else f"[ {' '.join(format_number(v) for v in value)} ]"
    elif isinstance(value, (int, float)):
        text = format_number(value)
    else:
        text = value
        if not text.strip() or re.search(r"[#!\r\n]", text) or text != text.strip():
            message = "this text cannot be written into CONTROL: it is empty or has #, ! or a line break in it"
            raise InputError(message, word=text)
    return f"{setting.keyword} {text}" + (f" {setting.unit}" if setting.unit else "")


def format_number(value: int | float) -> str:
    """Return the shortest text that reads back as the same number."""
    return repr(int(value)) if isinstance(value, int) else repr(float(value))


@cache
def default_setting(keyword: str) -> Setting | None:
    """Return the table's default as a setting, or None when the keyword has no default."""
    row = KEYWORDS[keyword]
    return parse_setting(row, row.default, path="the keyword table").setting if row.default else None


def effect_of(setting: Setting) -> Effect:
    """Return what pydlpoly does with a setting under its canonical keyword.

    A refused keyword whose value switches it off (off, zero, negative or the default) changes nothing and counts as
    ignored.
    """
    row = KEYWORDS[setting.keyword]
    text = row.option_effects.get(setting.value, row.effect) if isinstance(setting.value, str) else row.effect
    kind, _, reason = text.partition(": ")
    if kind == "refused" and _is_off(setting.value, setting.keyword):
        return Effect("ignored", "it is switched off")
    if kind == "used":
        return Effect("used")
    return Effect("refused" if kind == "refused" else "ignored", reason)


def _is_off(value: SettingValue, keyword: str) -> bool:
    if isinstance(value, (bool, int, float)) and value <= 0:
        return True
    default = default_setting(keyword)
    return default is not None and value == default.value
