"""Writes the generated parts of the documentation from the code; with ``--check`` only names the pages that are stale.

A generated part stands between ``<!-- generated: name -->`` and ``<!-- end: name -->`` in a hand-written page;
everything outside of these lines is left alone.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path

import pydlpoly
from pydlpoly import _core
from pydlpoly.engines.lammps_translate.bonded import BONDED_STYLES, SOMETIMES
from pydlpoly.engines.lammps_translate.bonded import why_refused as why_bonded_refused
from pydlpoly.engines.lammps_translate.charges import METHODS
from pydlpoly.engines.lammps_translate.heat import HEAT
from pydlpoly.engines.lammps_translate.integrators import INTEGRATOR_STYLES
from pydlpoly.engines.lammps_translate.many_body import MANY_BODY
from pydlpoly.engines.lammps_translate.pairs import PAIR_STYLES
from pydlpoly.engines.lammps_translate.pairs import why_refused as why_pair_refused
from pydlpoly.engines.lammps_translate.species import SPECIES
from pydlpoly.formats.control import parse_control
from pydlpoly.formats.diagnostics import COLUMNS, HEAT_COLUMNS
from pydlpoly.formats.keywords import KEYWORDS, SYNONYMS, Keyword
from pydlpoly.formats.statis import STATISTICS_NAMES
from pydlpoly.gallery import gallery, relative_cost
from pydlpoly.scene.integrators import INTEGRATORS, THERMOSTATS
from pydlpoly.trajectories import FORMATS
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


def trajectory_formats() -> str:
    """Return the registry of trajectory formats."""
    rows = []
    for one in FORMATS.values():
        files = ", ".join(code(name) for name in one.files("TRAJECTORY" if one.extension else "HISTORY"))
        rows.append([code(one.name), one.description, files, code(one.needs), code(one.reads)])
    return table(["name", "format", "files", "package to write", "package to read"], rows)


def examples() -> str:
    """Return the shipped examples: a table, and the pictures there are."""
    headers = ["name", "shows", "beads", "steps", "time", "files"]
    rows, pictures = [], []
    for one in gallery():
        control = parse_control(one.texts()["CONTROL"])
        steps = str(control.get("time_run").value)
        files = f"recipe `{one.recipe}`" if one.recipe else "as they are"
        rows.append([code(one.name), one.shows, str(one.beads), steps, relative_cost(one), files])
        image = f"images/example-{one.name}.png"
        if (DOCS / image).is_file():
            pictures.append(f"\n## {one.name}\n\n{control.title}.\n\n![{one.name}: {one.shows}]({image})\n")
    return table(headers, rows) + "".join(pictures)


# -- LAMMPS -----------------------------------------------------------------------------------------------------------


def lammps_pair_laws() -> str:
    """Return what each pair law becomes in LAMMPS."""
    rows = []
    for law in _core.pair_laws():
        style = PAIR_STYLES.get(law["key"])
        if law["key"] == "mdpd":
            rows.append([code("mdpd"), f"{code('mdpd')} with `mdpd_kernel lucy`", "see below"])
            continue
        if style is None:
            rows.append([code(law["key"]), "refused", why_pair_refused(law["key"])])
            continue
        own = f"{code(style.style)}; `lepton` for other numbers" if style.sometimes else code(style.style or "lepton")
        rows.append([code(law["key"]), own, "energy, forces and virial to 1e-10"])
    return table(["pair law", "LAMMPS's style", "equal, or why not"], rows)


def lammps_bonded_laws() -> str:
    """Return what each bonded law becomes in LAMMPS."""
    rows = []
    for law in _core.bonded_laws():
        kind, key = law["kind"], law["key"]
        style = BONDED_STYLES.get((kind, key))
        if style is None:
            rows.append([kind, code(key), "refused", why_bonded_refused(kind, key)])
            continue
        sometimes = style.style and (kind, key) in SOMETIMES
        own = f"{code(style.style)}; `lepton` for other numbers" if sometimes else code(style.style or "lepton")
        rows.append([kind, code(key), own, "energy, forces and virial to 1e-10"])
    return table(["term", "law", "LAMMPS's style", "equal, or why not"], rows)


def lammps_integrators() -> str:
    """Return what each integrator becomes in LAMMPS."""
    rows = [[code(name), style.fixes, style.equal, style.differs] for name, style in INTEGRATOR_STYLES.items()]
    others = [name for name in (*INTEGRATORS, *THERMOSTATS) if name not in INTEGRATOR_STYLES]
    rows.append([" ".join(map(code, others)), "refused", "", "LAMMPS has no such step, or is not given it"])
    return table(["integrator", "LAMMPS's fixes and styles", "equal", "differs"], rows)


def lammps_charges() -> str:
    """Return what each way of electrostatics becomes in LAMMPS."""
    ewald = "forces to the precision of both sums, 1e-5 with `spme_precision 1e-7`"
    return table(
        ["method", "LAMMPS's style", "equal"],
        (
            [code(row["name"]), METHODS[row["name"]], ewald if row["reciprocal"] else "to 1e-10"]
            if row["name"] in METHODS
            else [code(row["name"]), "refused", "it is not translated"]
            for row in _core.charge_methods()
        ),
    )


def lammps_carried(rows: tuple[tuple[str, str, str], ...]) -> str:
    """Return what becomes of a model whose beads carry something."""
    return table(["of the scene", "in LAMMPS", "equal, or why not"], (list(row) for row in rows))


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
    "lammps-pair-laws": lammps_pair_laws,
    "lammps-bonded-laws": lammps_bonded_laws,
    "lammps-integrators": lammps_integrators,
    "lammps-charges": lammps_charges,
    "lammps-many-body": partial(lammps_carried, MANY_BODY),
    "lammps-heat": partial(lammps_carried, HEAT),
    "lammps-species": partial(lammps_carried, SPECIES),
    "trajectory-formats": trajectory_formats,
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
