"""Measures the results of docs/accuracy-and-speed.md anew and writes them between its marks.

``--only SCENE`` (water, mixture, polymer, lj; may be repeated) leaves the others alone; ``--budget`` is the time for
each, ``--threads`` the number of threads. A part stands between ``<!-- measured: name -->`` and ``<!-- end: name -->``.
Wants a quiet machine.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

from performance import table

from pydlpoly import Scene, load
from pydlpoly.bench.results import significant
from pydlpoly.bench.scenes import lennard_jones, polymer_melt, water
from pydlpoly.cli import example_folder
from pydlpoly.errors import PydlpolyError
from pydlpoly.tradeoff import TradeoffReport, tradeoff
from pydlpoly.tradeoff.cli import seconds_of
from pydlpoly.tradeoff.report import QUANTITIES, control_lines, deviation_text, duration

PAGE = Path(__file__).with_name("accuracy-and-speed.md")
SCENES: dict[str, Callable[[], Scene]] = {
    "water": lambda: water(3000),
    "mixture": lambda: load(example_folder("mixture")),
    "polymer": lambda: polymer_melt(150),
    "lj": lambda: lennard_jones(8),
}


def section(report: TradeoffReport) -> str:
    """Return what is told of a scene: where, the candidates that matter, and the recommendation."""
    reference = report.reference
    shown = report.noteworthy()
    found = [one.deviations or {} for one in shown]
    columns = [name for name in QUANTITIES if any(name in one for one in found)]
    rows = []
    for one, errors in zip(shown, found, strict=True):
        cells = [deviation_text(errors[name]).replace("+-", " ± ") if name in errors else "" for name in columns]
        speed = "" if one.speed is None else significant(one.speed.median)
        verdict = one.verdict if one.status == "measured" else f"{one.status}: {one.why}"
        own = " (CONTROL)" if one.own else ""
        rows.append(["*" if one.front else "", f"{one.label}{own}", speed, *cells, verdict])
    unit = report.time_unit or "time"
    headers = [
        "front",
        "integrator, timestep, precision",
        f"{unit}/s",
        *(QUANTITIES[name] for name in columns),
        "verdict",
    ]
    best = report.recommendation
    goal = f"within {100.0 * report.target:.3g} %"
    words = f"Nothing was found {goal} for certain." if best is None else f"Fastest {goal}: {best.label}."
    if best is not None:
        words += f" In CONTROL: {', '.join(f'`{line}`' for line in control_lines(best, report.time_unit))}."
    return (
        f"Measured on {report.machine.text()}.\n\n{report.beads} beads, {report.threads} thread"
        f"{'s' * (report.threads > 1)}, budget {duration(report.budget)}, against {reference.integrator} with timestep "
        f"{reference.timestep:g}; {len(report.candidates)} candidates.\n\n{table(headers, rows)}\n{words}\n"
    )


def _between(fresh: str, marks: re.Match[str]) -> str:
    return f"{marks[1]}\n{fresh}\n{marks[2]}"


def main() -> int:
    """Measure and rewrite the page; the return value is the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", action="append", choices=list(SCENES))
    parser.add_argument("--budget", default="15min")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    for name in options.only or SCENES:
        try:
            report = tradeoff(SCENES[name](), budget=seconds_of(options.budget), threads=options.threads, seed=1)
        except PydlpolyError as error:
            print(f"{name}: {error}", file=sys.stderr)
            return 1
        print(report.text(everything=True), file=sys.stderr)
        mark = re.compile(rf"(<!-- measured: {name} -->\n).*?(<!-- end: {name} -->\n)", re.DOTALL)
        text = PAGE.read_text(encoding="utf-8")
        PAGE.write_text(mark.sub(partial(_between, section(report)), text), encoding="utf-8")
        print(f"{name}: written")
    return 0


if __name__ == "__main__":
    sys.exit(main())
