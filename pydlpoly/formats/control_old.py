"""Old-style CONTROL files: a title, then abbreviated directives up to ``finish``, read as new-style settings.

A directive is known by its leading letters; filler words (every, steps, cutoff, …) and the unit that the number has
anyway may stand around a number. ``control_old_write`` goes the other way by the same tables.
"""

from __future__ import annotations

import re

from pydlpoly.errors import suggest
from pydlpoly.formats.control_old_directives import HANDLERS, NAMES, find_directive
from pydlpoly.formats.control_old_line import Line
from pydlpoly.formats.control_old_tables import NOT_MODELLED
from pydlpoly.formats.control_values import Parsed, Reading
from pydlpoly.formats.keywords import lookup
from pydlpoly.formats.records import Control, Setting


def parse_old(lines: list[str], path: str, lenient: bool) -> Control:
    """Read the lines of an old-style file; see ``read_control`` for the arguments and errors."""
    reading = Reading(path, lenient)
    finished = False
    for number, raw in enumerate(lines[1:], start=2):
        words = re.sub(r"(^|\s)[#!].*", "", raw).split()
        if not words:
            continue
        if words[0].lower() == "finish":
            finished = True
            break
        _read_directive(Line(reading, number, words), lines[number:])
    if not finished:
        last = max(number for number, raw in enumerate(lines, start=1) if raw.strip())
        reading.complain("is missing at the end of this old-style file", last, "finish")
    _fill_defaults(reading)
    return Control(lines[0].strip(), tuple(reading.settings.values()), "old", path, tuple(reading.warnings))


def _read_directive(line: Line, following: list[str]) -> None:
    word = line.words[0].lower()
    _refuse_foreign(line, following)
    name = find_directive(word)
    if name is None:
        line.reading.complain(_unknown(word), line.number, line.words[0])
        return
    HANDLERS[name](line)
    leftover = tuple(line.words[line.position :])
    for keyword, value, unit in line.made:
        line.reading.add(Parsed(Setting(keyword, value, unit, line.number)), line.words[0])
    if leftover:
        message = "is left over after an old-style directive; a remark must begin with # or !"
        line.reading.complain(message, line.number, " ".join(leftover))


def _unknown(word: str) -> str:
    if lookup(word) is not None:
        return "is a new-style keyword in an old-style file; a new-style file begins with the word title"
    return f"is no directive of an old-style CONTROL{suggest(word, NAMES)}"


def _refuse_foreign(line: Line, following: list[str]) -> None:
    """Refuse what DL_POLY Classic and its relatives put into CONTROL and DL_POLY does not know, by its name."""
    word = line.words[0].lower()
    if word.startswith("&"):
        raise line.error("is a Fortran namelist, which no DL_POLY 4 or 5 CONTROL has")
    if word != "io" and any("=" in w for w in line.words):
        raise line.error("has the form key=value, which no DL_POLY 4 or 5 CONTROL has", " ".join(line.words))
    if word in NOT_MODELLED:
        raise line.error(f"asks for {NOT_MODELLED[word]}, which is not modelled")
    end = next(
        (f.split()[0] for f in following if f.split() and f.lower().split()[0].startswith("end" + word[:3])), None
    )
    if end is not None:
        raise line.error(f"opens a block that ends with {end}; blocks of DL_POLY Classic are not modelled")


def _fill_defaults(reading: Reading) -> None:
    """Write out the defaults that differ between the styles, so that new-style names mean the same."""
    given = reading.settings
    if "ensemble" not in given:
        reading.warnings.append(f"{reading.path}: no ensemble is given; nve is taken, as in DL_POLY")
        given["ensemble"] = Setting("ensemble", "nve")
    for keyword in ("print_frequency", "stats_frequency"):
        given.setdefault(keyword, Setting(keyword, 100, "steps"))
    for name in ("rdf", "zden", "vaf"):
        if f"{name}_calculate" in given and f"{name}_print" not in given:
            if name != "vaf":  # which is written all the same
                text = f"{name} is collected but not written, because 'print {name}' is missing"
                reading.warnings.append(f"{reading.path}: {text}")
            given[f"{name}_print"] = Setting(f"{name}_print", False)
