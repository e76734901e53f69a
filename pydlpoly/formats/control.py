"""CONTROL files: tells the two styles apart, reads and writes the new style, and gives settings in internal units.

The new style has one ``keyword value unit`` a line; the old style, with its abbreviated directives, is next door in
``control_old``. Both become the same record, under the new-style keywords.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

from pydlpoly.errors import InputError
from pydlpoly.formats.control_old import parse_old
from pydlpoly.formats.control_old_directives import NAMES, is_directive
from pydlpoly.formats.control_old_write import write_old
from pydlpoly.formats.control_values import (
    Effect,
    Parsed,
    Reading,
    default_setting,
    effect_of,
    format_setting,
    parse_setting,
)
from pydlpoly.formats.dl_meso_control import MESO_ONLY, parse_meso
from pydlpoly.formats.keywords import KEYWORDS, lookup, nearest
from pydlpoly.formats.records import Control, Setting, SettingValue
from pydlpoly.units import convert, parse_unit, time_to_steps

__all__ = [
    "Effect",
    "effect_of",
    "looks_like_dl_meso",
    "parse_control",
    "read_control",
    "value_in",
    "write_control",
]

_OLD_METHODS = {"dpds1": "first", "dpds2": "second"}
"""Names of the DPD thermostat that DL_POLY's help advertises: method and order in one word."""


def read_control(path: str | Path, lenient: bool = False, dl_meso: bool = False) -> Control:
    """Read a CONTROL file of either style, or in DL_MESO's dialect.

    Args:
        path: the file.
        lenient: turn unknown keywords, duplicates and leftover words into ``Control.warnings`` instead of errors.
        dl_meso: take a file that is not in the new style as one of DL_MESO's even where none of its directives tells.

    Raises:
        InputError: the file cannot be opened, or has an error in it.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", path=str(path)) from error
    except ValueError as error:  # a null character in the name
        raise InputError(f"cannot be read: {error}", path=str(path)) from error
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    return parse_control(text, path=str(path), lenient=lenient, dl_meso=dl_meso)


def parse_control(text: str, path: str = "CONTROL", lenient: bool = False, dl_meso: bool = False) -> Control:
    """Read the text of a CONTROL file of either style or dialect; see ``read_control``."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if not text.strip():
        raise InputError("the file is empty; a CONTROL file begins with a title", path=path)
    if _is_new_style(lines):
        return _parse_new(lines, path, lenient)
    if dl_meso or _has_meso_marker(lines):
        return parse_meso(lines, path, lenient)
    try:
        return parse_old(lines, path, lenient)
    except InputError as error:
        if not _lacks_title(lines):
            raise
        told = "; a file in the new style, which this one seems to be, begins with a line title <text>"
        raise InputError(error.message + told, path=path, line=error.line, word=error.word) from None


def looks_like_dl_meso(text: str) -> bool:
    """Return whether a CONTROL is in DL_MESO's dialect: old style, with a directive that no DL_POLY has."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return not _is_new_style(lines) and _has_meso_marker(lines)


def _has_meso_marker(lines: list[str]) -> bool:
    for line in lines[1:]:  # the title may hold any word
        words = line.split()
        if words and words[0].lower() == "finish":
            return False
        if words and words[0].lower() in MESO_ONLY:
            return True
    return False


def _is_new_style(lines: list[str]) -> bool:
    """Tell the new style: the first word of the file, comments and blank lines apart, is ``title``.

    That is DL_POLY's rule, and it takes an old file for a new one when its title happens to begin with that word. So
    such a file counts as old after all when a later line is ``finish``, which every old file needs and no new one has,
    and no line makes only new sense (such as ``time_run``). Other old directives decide nothing: by their leading
    letters they would take a slip such as ``cutof 1.0 ang`` in a new file for old style.
    """
    first_words = [body.split()[0].lower() for body in map(_strip_comment, lines) if body]
    if not first_words or first_words[0] != "title":
        return False
    only_new = any(lookup(word) is not None and not is_directive(word) for word in first_words[1:])
    return only_new or "finish" not in first_words[1:]


def _lacks_title(lines: list[str]) -> bool:
    """Return whether a file that was taken for old has words that are of the new style only, and no ``finish``."""
    words = [body.split()[0].lower() for body in map(_strip_comment, lines) if body]
    return "finish" not in words and any("_" in word and lookup(word) is not None for word in words)


def _strip_comment(line: str) -> str:
    return re.split(r"[#!]", line, maxsplit=1)[0].strip()


def _parse_new(lines: list[str], path: str, lenient: bool) -> Control:
    reading = Reading(path, lenient)
    title: str | None = None
    continued: tuple[int, str] | None = None
    for number, line in enumerate(lines, start=1):
        body = _strip_comment(line)
        if not body:
            continue
        if continued is not None:
            number, body = continued[0], f"{continued[1]} {body}"
            continued = None
        word, rest = [*body.split(None, 1), ""][:2]
        if word.lower() == "title":
            if title is not None:
                reading.complain("is given twice", number, word)
            title = rest
            continue
        row = lookup(word)
        if row is not None and row.kind == "vector" and body.endswith("&"):
            continued = number, body[:-1].rstrip()
            continue
        _read_line(reading, word, rest, number)
    if continued is not None:
        raise InputError("the file ends after a line that is to be continued", path=path, line=continued[0], word="&")
    return Control(title or "", tuple(reading.settings.values()), "new", path, tuple(reading.warnings))


def _read_line(reading: Reading, word: str, rest: str, number: int) -> None:
    row = lookup(word)
    if row is None:
        old = "; it is an old-style directive, and the file is in the new style" if is_directive(word) else ""
        hint = old if word.lower() in NAMES else nearest(word) or old
        reading.complain(f"is no keyword of CONTROL{hint}", number, word)
        return
    method = rest.split()[0].lower() if rest.split() else ""
    if row.keyword == "ensemble_method" and method in _OLD_METHODS:
        _read_old_method(reading, method, rest.split()[1:], number)
        return
    reading.add(parse_setting(row, rest, path=reading.path, line=number), word)


def _read_old_method(reading: Reading, method: str, leftover: list[str], number: int) -> None:
    """Take ``ensemble_method dpds1`` as ``dpd`` with ``ensemble_dpd_order first``, and say so."""
    order = _OLD_METHODS[method]
    warning = f"{method} is an old name; it is read as ensemble_method dpd with ensemble_dpd_order {order}"
    method_set = Parsed(Setting("ensemble_method", "dpd", None, number), tuple(leftover), (warning,))
    reading.add(method_set, "ensemble_method")
    reading.add(Parsed(Setting("ensemble_dpd_order", order, None, number)), method)


def write_control(control: Control) -> str:
    """Return the text of a CONTROL file in the record's own style; reading it gives an equal record.

    A new-style title loses ``#`` and ``!``, which begin comments there. Converting between the styles is writing a copy
    with the other style: ``write_control(replace(control, style="new"))``.

    Raises:
        InputError: a setting has no form in this style, or a text has a comment character in it.
    """
    if control.style == "old":
        return write_old(control)
    title = re.sub(r"[#!\r\n]", " ", control.title).strip()
    lines = [f"title {title}".strip(), *(format_setting(setting) for setting in control)]
    return "\n".join(lines) + "\n"


def value_in(
    control: Control, keyword: str, default_from_table: bool = True, timestep: float | None = None
) -> SettingValue:
    """Return a setting's value in internal units: Å, ps, Da, K, steps, …

    Args:
        control: the file.
        keyword: a keyword of the table.
        default_from_table: use the table's default when the file does not give the keyword.
        timestep: Δt in ps, for times in steps and steps in times; without it the file's own timestep is used.

    Returns:
        int for whole numbers and steps, float for other numbers, bool for switches, str for options and texts, a tuple
        for vectors.

    Raises:
        InputError: the keyword is neither given nor has a default, or its unit needs a timestep that is not there.
        KeyError: there is no such keyword.
    """
    row = KEYWORDS[keyword]
    setting = control.get(keyword)
    if setting is None:
        setting = default_setting(keyword) if default_from_table else None
        if setting is None and row.kind == "string" and default_from_table:
            return ""
        if setting is None:
            raise InputError(f"CONTROL does not give {keyword} ({row.meaning})", path=control.path)
    value = setting.value
    if isinstance(value, (bool, str)) or row.dimension == "integers":
        return value
    factor = _factor(control, setting, row.dimension, timestep)
    if isinstance(value, tuple):
        return tuple(number * factor for number in value)
    number = value * factor
    if not math.isfinite(number):
        raise InputError("this number is out of range", path=control.path, line=setting.line or None, word=row.keyword)
    return time_to_steps(number, 1.0) if row.kind == "steps" else number


def _factor(control: Control, setting: Setting, dimension: str, timestep: float | None) -> float:
    """Return what a setting's numbers are multiplied with to be in internal units."""
    unit = setting.unit or ""
    if dimension == "any":
        return parse_unit(unit).factor
    if dimension == "steps" and unit.lower() == "steps":
        return 1.0
    read = parse_unit(unit, path=control.path, line=setting.line or None)
    if setting.keyword == "timestep" and read.steps:
        message = "a timestep cannot be given in steps"
        raise InputError(message, path=control.path, line=setting.line or None, word=unit)
    if timestep is None and (dimension == "steps" or read.steps) and control.get("timestep") is not None:
        timestep = float(value_in(control, "timestep"))  # type: ignore[arg-type]  # a float keyword
    temperature = None
    if read.system_temperature and setting.keyword != "temperature":
        if control.get("temperature") is None:
            message = f"{setting.keyword} in this unit needs a temperature, which CONTROL does not give"
            raise InputError(message, path=control.path, line=setting.line or None, word=unit)
        temperature = float(value_in(control, "temperature"))  # type: ignore[arg-type]  # a float keyword
    return convert(
        1.0, unit, dimension, timestep=timestep, temperature=temperature, path=control.path, line=setting.line or None
    )
