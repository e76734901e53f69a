"""Writes the generated parts of the documentation from the code; with ``--check`` only names the pages that are stale.

A generated part stands between ``<!-- generated: name -->`` and ``<!-- end: name -->`` in a hand-written page;
everything outside of these lines is left alone.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import pydlpoly
from pydlpoly import _core
from pydlpoly.cli import example_folder, example_names
from pydlpoly.formats.control import read_control
from pydlpoly.formats.diagnostics import COLUMNS, HEAT_COLUMNS
from pydlpoly.formats.keywords import KEYWORDS, SYNONYMS, Keyword
from pydlpoly.formats.statis import STATISTICS_NAMES
from pydlpoly.units import (
    AVOGADRO,
    BOLTZMANN,
    COULOMB_CONSTANT,
    DIMENSIONS,
    ENERGY_UNITS,
    KATM_PER_INTERNAL_PRESSURE,
)

DOCS = Path(__file__).resolve().parent
_PART = re.compile(r"(<!-- generated: (?P<name>[\w-]+) -->\n).*?(<!-- end: (?P=name) -->\n)", re.DOTALL)


def table(headers: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table; vertical bars inside cells are escaped."""
    lines = [" | ".join(headers), " | ".join("---" for _ in headers)]
    lines += [" | ".join(cell.replace("|", "\\|").strip() for cell in row) for row in rows]
    return "".join(f"| {line} |\n" for line in lines)


def code(text: str) -> str:
    """Return text as inline code, empty text as nothing."""
    return f"`{text}`" if text else ""


# -- CONTROL ----------------------------------------------------------------------------------------------------------


def _unit(row: Keyword) -> str:
    if row.kind in ("bool", "string", "int", "option") or row.dimension in ("number", "integers", "any"):
        return ""
    return DIMENSIONS[row.dimension][1]


def _kind(row: Keyword) -> str:
    if row.kind == "option":
        refused = {word for word, effect in row.option_effects.items() if effect.startswith("refused")}
        return " ".join(f"`{word}`" for word in row.options if word not in refused)
    words = {"bool": "on or off", "int": "whole number", "float": "number", "steps": "steps or time", "string": "text"}
    return words.get(row.kind) or (f"{row.length} numbers" if row.length else "numbers")


def _used(row: Keyword) -> bool:
    return row.effect == "used" or any(effect.startswith("refused") for effect in row.option_effects.values())


def _effect(row: Keyword) -> str:
    """What pydlpoly does with a used keyword, and with the options where that differs."""
    texts = [] if row.effect == "used" else [row.effect]
    by_effect: dict[str, list[str]] = {}
    for word, effect in row.option_effects.items():
        by_effect.setdefault(effect, []).append(f"`{word}`")
    texts += [f"{', '.join(words)}: {effect}" for effect, words in by_effect.items()]
    return "; ".join(texts) or "used"


def control_used() -> str:
    """Return the keywords that act."""
    headers = ["keyword", "kind", "unit", "default", "meaning", "effect", "old style"]
    rows = [
        [
            code(row.keyword),
            _kind(row),
            _unit(row),
            "required" if row.required else code(row.default),
            row.meaning,
            _effect(row),
            code(row.old),
        ]
        for row in KEYWORDS.values()
        if _used(row)
    ]
    return table(headers, rows)


def _control_rest(start: str) -> str:
    headers = ["keyword", "kind", "unit", "default", "meaning", "why" if start == "ignored" else "what is not modelled"]
    rows = [
        [
            code(row.keyword),
            _kind(row),
            _unit(row),
            code(row.default),
            row.meaning,
            row.effect.removeprefix(f"{start}: "),
        ]
        for row in KEYWORDS.values()
        if not _used(row) and row.effect.startswith(start)
    ]
    return table(headers, rows)


def control_refused() -> str:
    """Return the keywords that stop a run unless they have their default."""
    return _control_rest("refused")


def control_ignored() -> str:
    """Return the keywords that are read and named, and change nothing."""
    return _control_rest("ignored")


def control_synonyms() -> str:
    """Return other spellings of keywords."""
    return table(["spelling", "read as"], ([code(word), code(keyword)] for word, keyword in SYNONYMS.items()))


# -- Laws, columns, units, names --------------------------------------------------------------------------------------


def pair_laws() -> str:
    """Return the registry of pair laws."""
    headers = ["key", "numbers in FIELD", "drag is number", "law", "soft", "tail", "mixable", "force shift"]
    rows = []
    for law in _core.pair_laws():
        energies = [name for k, name in enumerate(law["parameter_names"]) if law["energy_mask"] >> k & 1]
        numbers = " ".join(f"**{name}**" if name in energies else name for name in law["parameter_names"])
        flags = ["yes" if law[flag] else "" for flag in ("soft", "has_tail", "mixable", "shiftable")]
        rows.append([code(law["key"]), numbers or "none", str(law["drag_slot"] or "-"), law["description"], *flags])
    return table(headers, rows)


def bonded_laws() -> str:
    """Return the registry of bonded laws."""
    headers = ["block", "key", "restraint", "numbers in FIELD", "law"]
    rows = []
    for law in _core.bonded_laws():
        names = law["parameter_names"]
        words = []
        for k, name in enumerate(names):
            word = f"**{name}**" if law["energy_mask"] >> k & 1 else f"{name}°" if law["degree_mask"] >> k & 1 else name
            words.append(f"[{word}]" if k >= len(names) - law["optional"] else word)
        block = "teth" if law["kind"] == "tether" else f"{law['kind']}s"
        rows.append([code(block), code(law["key"]), code(law["restraint_key"]), " ".join(words), law["description"]])
    return table(headers, rows)


def statis_columns() -> str:
    """Return the columns of STATIS."""
    rows = ([str(q.index), code(q.name), q.label, q.unit] for q in STATISTICS_NAMES)
    return table(["number", "name in Python", "DL_POLY's label", "kind"], rows)


def diagnostics_columns() -> str:
    """Return the columns of DIAGNOSTICS."""
    return table(["name", "kind", "meaning"], ([code(c.name), c.kind, c.meaning] for c in (*COLUMNS, *HEAT_COLUMNS)))


def energy_units() -> str:
    """Return FIELD's energy units."""
    rows = []
    for unit in ENERGY_UNITS.values():
        temperature, pressure = unit.temperature_label or "k_B T, k_B = 1", unit.pressure_label or "energy/length³"
        rows.append([code(unit.name), f"{unit.factor:.10g}", unit.label or "reduced", temperature, pressure])
    headers = ["word after `units`", "in internal units (10 J/mol)", "reported energy", "temperature", "pressure"]
    return table(headers, rows)


def constants() -> str:
    """Return the physical constants."""
    rows = [
        ["k_B", f"{BOLTZMANN:.10g}", "internal energy per kelvin"],
        ["1/(4πε₀)", f"{COULOMB_CONSTANT:.10g}", "internal energy × Å/e²"],
        ["internal pressure", f"{KATM_PER_INTERNAL_PRESSURE:.10g}", "katm"],
        ["Avogadro's number", f"{AVOGADRO:.10g}", "1/mol"],
    ]
    return table(["constant", "value", "unit"], rows)


def python_names() -> str:
    """Return the names that ``import pydlpoly`` gives, with the first sentence of their documentation."""
    rows = []
    for name in pydlpoly.__all__:
        thing = getattr(pydlpoly, name)
        text = "version of the package" if name == "__version__" else inspect.cleandoc(thing.__doc__).split("\n\n")[0]
        rows.append([code(name), " ".join(text.split())])
    return table(["name", "what it is"], rows)


def examples() -> str:
    """Return the shipped examples with the titles of their CONTROL files."""
    rows = ([code(name), read_control(example_folder(name) / "CONTROL").title] for name in example_names())
    return table(["name", "title"], rows)


PARTS: dict[str, Callable[[], str]] = {
    "control-used": control_used,
    "control-refused": control_refused,
    "control-ignored": control_ignored,
    "control-synonyms": control_synonyms,
    "pair-laws": pair_laws,
    "bonded-laws": bonded_laws,
    "statis-columns": statis_columns,
    "diagnostics-columns": diagnostics_columns,
    "energy-units": energy_units,
    "constants": constants,
    "python-names": python_names,
    "examples": examples,
}
"""The generated parts by name."""


def regenerate(text: str) -> str:
    """Return a page with its generated parts replaced by fresh ones. Raises KeyError for an unknown part."""
    return _PART.sub(lambda found: f"{found[1]}\n{PARTS[found['name']]()}\n{found[3]}", text)


def main() -> int:
    """Rewrite the pages, or with ``--check`` name those that are out of date; the return value is the exit code."""
    check, stale = "--check" in sys.argv[1:], []
    for page in sorted(DOCS.glob("*.md")):
        text = page.read_text(encoding="utf-8")
        fresh = regenerate(text)
        if fresh != text:
            stale.append(page.name)
            if not check:
                page.write_text(fresh, encoding="utf-8")
    for name in stale:
        print(f"{name}: {'out of date' if check else 'written'}")
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
