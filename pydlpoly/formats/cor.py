"""COR: correlation functions and what follows from them, in the YAML of DL_POLY 5."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import PathLike, read_text, replace_file
from pydlpoly.formats.fortran import parse_real
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class Correlation:
    """One correlation function.

    Attributes:
        name: such as ``stress_xy-stress_xy``.
        points, blocks, window: shape of the correlator.
        lags: (n,) times; values: (n,); errors: (n,) standard errors, None where the file has none.
    """

    name: str
    points: int
    blocks: int
    window: int
    lags: FloatArray
    values: FloatArray
    errors: FloatArray | None = None


@dataclass(frozen=True)
class Derived:
    """A number that follows from correlation functions: its mean, one value a function, unit, standard error."""

    name: str
    value: float
    components: Sequence[float]
    units: str
    error: float


@dataclass(frozen=True, eq=False)
class CorrelationTable:
    """What the file holds; ``derived`` by name."""

    title: str
    correlations: tuple[Correlation, ...]
    derived: dict[str, Derived]


def write_correlations(
    path: PathLike, title: str, correlations: Sequence[Correlation], derived: Sequence[Derived] = ()
) -> None:
    """Replace COR. Standard errors (``error``) are entries of ours; everything else is DL_POLY's.

    Raises:
        RunError: the file cannot be written.
    """
    quoted = title.strip().replace("'", "''")
    lines = ["%YAML 1.2", "---", f"title: '{quoted}'"]
    if derived:
        lines.append("observables:")
        for number in derived:
            lines += [
                f"      {number.name}:",
                f"            value: {_number(number.value)}",
                f"            components: {_numbers(number.components)}",
                f"            units: {number.units}",
                f"            error: {_number(number.error)}",
            ]
    lines.append("correlations:")
    for one in correlations:
        lines += [
            f"      {one.name}:",
            "            parameters:",
            f"                  points_per_block: {one.points}",
            f"                  number_of_blocks: {one.blocks}",
            f"                  window_size: {one.window}",
            f"            lags: {_numbers(one.lags.tolist())}",
            f"            value: {_numbers(one.values.tolist())}",
        ]
        if one.errors is not None:
            lines.append(f"            error: {_numbers(one.errors.tolist())}")
    replace_file(Path(path), "\n".join(lines) + "\n")


def _number(value: float) -> str:
    return ".nan" if value != value else f"{value:.8E}"


def _numbers(values: Sequence[float]) -> str:
    return "[ " + ", ".join(map(_number, values)) + " ]"


_ENTRY = re.compile(r"^( *)([^\s:#][^:]*):(?: +(.*?))?\s*$")


def read_cor(path: PathLike) -> CorrelationTable:
    """Read a COR file: lists and numbers on one line each, as DL_POLY and this module write them.

    Raises:
        InputError: the file is missing, is no COR, or is cut short.
    """
    name = os.fspath(path)
    title, section, item, deep = "", "", "", 0
    found: dict[str, list[tuple[str, dict[str, tuple[int, str]]]]] = {"observables": [], "correlations": []}
    for number, line in enumerate(read_text(path).splitlines(), 1):
        entry = _ENTRY.match(line)
        if entry is None:
            continue
        indent, key, value = len(entry[1]), entry[2].strip(), entry[3] or ""
        if indent == 0:
            section, item = key, ""
            title = _unquoted(value) if key == "title" else title
        elif section in found and (not item or indent <= deep):
            item, deep = key, indent
            found[section].append((item, {}))
        elif section in found and value:
            found[section][-1][1][key] = number, value
    if section not in found:
        raise InputError("is no COR: it has no correlations", path=name)
    correlations = [_correlation(item, _Entries(entries, item, name)) for item, entries in found["correlations"]]
    derived = {item: _derived(item, _Entries(entries, item, name)) for item, entries in found["observables"]}
    if not correlations:
        raise InputError("is cut short: it has no correlations", path=name)
    return CorrelationTable(title, tuple(correlations), derived)


@dataclass(frozen=True)
class _Entries:
    """Texts of one item by key, with their lines, as numbers."""

    texts: dict[str, tuple[int, str]]
    item: str
    path: str

    def text(self, key: str) -> tuple[int, str]:
        if key not in self.texts:
            raise InputError(f"is cut short: {self.item} has no {key}", path=self.path)
        return self.texts[key]

    def number(self, key: str, otherwise: float | None = None) -> float:
        if key not in self.texts and otherwise is not None:
            return otherwise
        line, text = self.text(key)
        return self._real(text, line)

    def numbers(self, key: str) -> FloatArray:
        line, text = self.text(key)
        if not (text.startswith("[") and text.endswith("]")):
            raise InputError(f"is cut short: the list of {key} of {self.item} has no end", path=self.path, line=line)
        words = [word.strip() for word in text[1:-1].split(",") if word.strip()]
        return np.array([self._real(word, line) for word in words], dtype=np.float64)

    def _real(self, word: str, line: int) -> float:
        try:
            return float("nan") if word.lower() == ".nan" else parse_real(word)
        except ValueError:
            raise InputError("expected a number", path=self.path, line=line, word=word) from None


def _correlation(item: str, entries: _Entries) -> Correlation:
    shape = [int(entries.number(key, 1)) for key in ("points_per_block", "number_of_blocks", "window_size")]
    lags, values = entries.numbers("lags"), entries.numbers("value")
    errors = entries.numbers("error") if "error" in entries.texts else None
    if len(lags) != len(values) or (errors is not None and len(errors) != len(lags)):
        message = f"{item} has {len(lags)} lags and {len(values)} values"
        raise InputError(message, path=entries.path, line=entries.texts["value"][0])
    return Correlation(item, shape[0], shape[1], shape[2], lags, values, errors)


def _derived(item: str, entries: _Entries) -> Derived:
    components = entries.numbers("components").tolist()
    unit, error = entries.text("units")[1], entries.number("error", float("nan"))
    return Derived(item, entries.number("value"), components, unit, error)


def _unquoted(text: str) -> str:
    inside = len(text) > 1 and text[0] == text[-1] == "'"
    return text[1:-1].replace("''", "'") if inside else text
