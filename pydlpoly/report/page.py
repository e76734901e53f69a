"""The page: what the template is given, and the file it becomes."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pydlpoly import __version__
from pydlpoly.drawing import axis_label
from pydlpoly.formats.atomic import replace_file
from pydlpoly.report.collect import Run, collect_run
from pydlpoly.report.evidence import Evidence, with_error
from pydlpoly.report.figures import draw, figures_of
from pydlpoly.report.finding import Finding
from pydlpoly.report.judge import judge_run
from pydlpoly.report.speed import steps_a_second
from pydlpoly.report.style import Drawing, Table, check_packages, svg

if TYPE_CHECKING:
    from markupsafe import Markup

_SPEED = ("speed", "time")
_OPEN = ("Scene", "System", "Integrator and thermostat", "Pair table")  # parts of the explanation that are unfolded
_AVERAGES = (
    ("temperature", "kinetic temperature", "temperature"),
    ("configurational_temperature", "configurational temperature", "temperature"),
    ("pressure", "pressure", "pressure"),
    ("stress_xx", "stress xx", "pressure"),
    ("stress_yy", "stress yy", "pressure"),
    ("stress_zz", "stress zz", "pressure"),
    ("extended_energy", "total energy", "energy"),
    ("configurational_energy", "potential energy", "energy"),
    ("short_range_energy", "of pairs", "energy"),
    ("electrostatic_energy", "of charges", "energy"),
    ("bond_energy", "of bonds", "energy"),
    ("angle_energy", "of angles", "energy"),
    ("dihedral_energy", "of dihedrals and inversions", "energy"),
    ("tether_energy", "of tethers", "energy"),
    ("volume", "volume", "volume"),
)


@dataclass(frozen=True)
class Shown:
    """A figure as the template takes it: ``svg`` is markup."""

    name: str
    title: str
    caption: str
    svg: Markup
    table: Table | None


def write_report(
    folder: str | Path, path: str | Path | None = None, *, inputs: str | Path | None = None
) -> tuple[Path, list[Finding]]:
    """Write the report of a run, in one instant.

    Args:
        folder: where the run's files are.
        path: the HTML file, by default report.html in that folder.
        inputs: where CONTROL, FIELD and CONFIG are, when they are elsewhere.

    Returns:
        The file, and what was found, warnings first.

    Raises:
        InputError: there is no such folder, or matplotlib or Jinja2 is missing.
        RunError: the file cannot be written.
    """
    check_packages(template=True)
    run = collect_run(folder, inputs)
    findings = judge_run(run)
    target = Path(path) if path is not None else Path(folder) / "report.html"
    replace_file(target, render(run, findings))
    return target, findings


def render(run: Run, findings: list[Finding]) -> str:
    """Return the page."""
    from jinja2 import Environment, StrictUndefined

    figures = {name: shown for name in figures_of(run) if (shown := _shown(draw(run, name))) is not None}
    pictures = [name for name in figures if name == "start" or name.partition("-")[0] == "last"]
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["commands"] = _commands
    template = environment.from_string((resources.files("pydlpoly.report") / "template.html").read_text("utf-8"))
    return template.render(
        title=run.title,
        folder=str(run.folder),
        version=__version__,
        made=datetime.now().astimezone().strftime("%Y-%m-%d %H:%M"),
        status=_status(run, findings),
        warnings=[one for one in findings if one.level == "warning"],
        notes=[one for one in findings if one.level == "note"],
        checked=[one for one in findings if one.level in ("fine", "unknown")],
        facts=_facts(run),
        averages=_averages(run),
        equilibration=run.equilibration,
        pictures=[figures[name] for name in pictures],
        figures=[shown for name, shown in figures.items() if name not in (*pictures, *_SPEED)],
        speeds=[figures[name] for name in _SPEED if name in figures],
        explanation=_explanation(run),
        scene_source=run.scene_source,
        files=sorted(run.files),
    )


def _shown(drawing: Drawing | None) -> Shown | None:
    from markupsafe import Markup, escape

    if drawing is None:
        return None
    label = escape(f"{drawing.title}. {drawing.caption}")
    name = re.sub(r"[^\w-]", lambda found: f"_{ord(found[0]):x}", drawing.name)  # species may be called A+ or H2O*
    picture = svg(drawing.figure, name).replace("<svg", f'<svg role="img" aria-label="{label}"', 1)
    return Shown(name, drawing.title, drawing.caption, Markup(picture), drawing.table)


def _commands(text: str) -> Markup:
    """Words between backticks as code, everything else as plain text."""
    from markupsafe import Markup, escape

    pieces = re.split(r"`([^`]*)`", text)
    return Markup("").join(Markup("<code>{}</code>").format(p) if k % 2 else escape(p) for k, p in enumerate(pieces))


def _status(run: Run, findings: list[Finding]) -> str:
    done, asked = run.done_steps, run.asked_steps
    if not run.has_output:
        return "nothing was run"
    steps = "" if done is None else f"{done} steps" if asked is None else f"{done} of {asked} steps"
    how = next((one.subject.lower() for one in findings if one.subject in ("Run stopped", "Run incomplete")), "")
    return ", ".join(part for part in (how or ("complete" if done and done == asked else ""), steps) if part)


def _facts(run: Run) -> list[tuple[str, str]]:
    """What the run was, in a few lines."""
    units, scene = run.units, run.scene
    facts: list[tuple[str, str]] = []
    if run.beads:
        species = ""
        if scene is not None:
            amounts = (int((scene.beads.species == k).sum()) for k in range(len(scene.species)))
            named = (f"{count} {name}" for count, name in zip(amounts, scene.species, strict=True))
            species = f" ({', '.join(named)})"
        facts.append(("beads", f"{run.beads}{species}"))
    if scene is not None:
        facts.append(("integrator", scene.dynamics.integrator))
    if run.target_temperature is not None:
        facts.append(("temperature asked for", _with_unit(f"{run.target_temperature:.6g}", units.of("temperature"))))
    if run.timestep:
        facts.append(("timestep", _with_unit(f"{run.timestep:g}", units.of("time"))))
    done, asked = run.done_steps, run.asked_steps
    if done is not None or asked is not None:
        facts.append(("steps", f"{'none' if done is None else done} of {'?' if asked is None else asked}"))
    if done and run.timestep:
        facts.append(("simulated time", _with_unit(f"{done * run.timestep:g}", units.of("time"))))
    rate = steps_a_second(run)
    if rate:
        bead_steps = f", {rate * run.beads / 1e6:.3g} million bead-steps a second" if run.beads else ""
        facts.append(("speed", f"{rate:.4g} steps a second{bead_steps}"))
    if run.log is not None and run.log.loop_seconds is not None:
        facts.append(("time for the steps", f"{run.log.loop_seconds:.4g} s"))
    if run.log is not None and run.log.threads is not None:
        facts += [("threads", str(run.log.threads)), ("seed", str(run.log.seed))]
    words = ("reduced, k_B = 1",) if units.reduced else (units.energy, "K", "katm", "ps", "Å")
    facts.append(("units", ", ".join(dict.fromkeys(word for word in words if word))))
    return facts


def _averages(run: Run) -> list[tuple[str, str, int]]:
    """Rows of quantity with its unit, mean with error, and number of samples."""
    evidence, rows = Evidence(run), []
    for name, label, kind in _AVERAGES:
        average = evidence.average(name)
        series = evidence.series.get(name)
        if average is None or series is None or not series.values.any():
            continue
        if name == "volume" and not np.ptp(series.values) > 0.0:
            continue
        unit = run.units.of(kind) + (" per bead" if kind == "energy" and run.beads else "")
        rows.append((axis_label(label, unit.strip()), with_error(average), average.samples))
    return rows


def _explanation(run: Run) -> list[tuple[str, str, bool]]:
    """The parts of the explanation: title, text, and whether it is unfolded at first."""
    parts = re.split(r"(?m)^(.+)\n-{3,}\n", "\n" + run.explanation)[1:]
    pairs: Iterable[tuple[str, str]] = zip(parts[::2], parts[1::2], strict=True)
    return [(title, text.rstrip(), title in _OPEN) for title, text in pairs]


def _with_unit(text: str, unit: str) -> str:
    return f"{text} {unit}".rstrip()
