"""Measures the numbers of docs/performance.md anew and writes them between its marks: ``python docs/performance.py``.

``--only PART`` (ratios, carried, simd, threads, cost, instructions, python; may be repeated) leaves the other parts as
they are. A part stands between ``<!-- measured: name -->`` and ``<!-- end: name -->``. Wants a quiet machine, LAMMPS
and valgrind.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from callgrind import instructions
from cost import cost

from pydlpoly import Simulation, reporters
from pydlpoly.bench.measure import Options, measure
from pydlpoly.bench.results import Report, Spread
from pydlpoly.bench.scenes import SCENES, build, chosen, water
from pydlpoly.errors import PydlpolyError

PAGE = Path(__file__).with_name("performance.md")
_COMPARED = ["water-3k", "water-24k", "water-192k", "water-786k", "mixture", "cutoffs", "triclinic", "gas", "lj"]
_COUNTED = ["water-24k", "mixture", "triclinic", "lj"]


def table(headers: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [" | ".join(headers), " | ".join("---" for _ in headers), *(" | ".join(row) for row in rows)]
    return "".join(f"| {line} |\n" for line in lines)


def ratios() -> str:
    """Every scene against LAMMPS, in double and mixed precision."""
    report = _measured([*_COMPARED, "polymer", "lipids"], Options(precisions=("double", "mixed"), lammps=True))
    rows = []
    for scene in report.scenes:
        found = {
            comparison.of: comparison.ratio.text() for comparison in scene.comparisons if comparison.to == "LAMMPS"
        }
        ours = [one for one in scene.contenders if one.program == "pydlpoly"]
        cells = [found.get(one.label, "not compared") for one in ours] or [scene.unavailable or "", ""]
        theirs = next((one.plan for one in scene.contenders if one.program == "lammps"), "; ".join(scene.notes))
        path = ours[0].plan.split(":")[0] if ours else ""
        memory = ", ".join(f"{one.bytes_per_bead:.0f}" for one in ours if one.bytes_per_bead is not None)
        rows.append([scene.name, str(scene.beads), path, *cells, memory, theirs])
    headers = [
        "scene",
        "beads",
        "path",
        "double / LAMMPS",
        "mixed / LAMMPS",
        "bytes a bead (double, mixed)",
        "LAMMPS as",
    ]
    versions = {one.version for scene in report.scenes for one in scene.contenders if one.program == "lammps"}
    words = f"LAMMPS {', '.join(versions)}. Median and quartiles of the ratios of rates:\n\n"
    return _where(report) + words + table(headers, rows)


def carried() -> str:
    """Scenes of LAMMPS's own examples whose beads know more than where they are, against LAMMPS on one core."""
    report = _measured(["film", "heat", "species"], Options(threads=(1, 2), lammps=True))
    return _where(report) + _comparisons([report])


def simd() -> str:
    """Instruction sets against each other."""
    report = _measured(["water-24k", "mixture"], Options(simds=_simds(), precisions=("double",)))
    mixed = _measured(["water-24k", "mixture"], Options(simds=_simds(), precisions=("mixed",)))
    return _where(report) + _comparisons([report, mixed])


def threads() -> str:
    """Two threads against one."""
    report = _measured(["water-3k", "water-24k", "water-192k", "lj"], Options(threads=(1, 2)))
    return _where(report) + _comparisons([report])


def costs() -> str:
    """A bead and step against size, density, cutoffs and species."""
    return _where(_measured(["water-3k"], Options(steps=1, repetitions=1))) + cost()


def counted() -> str:
    """Instructions of a bead and step."""
    rows = []
    for name in _COUNTED:
        cells = [
            f"{instructions(name, simd=simd, precision=precision):.0f}"
            for precision in ("double", "mixed")
            for simd in ("plain", "avx2")
        ]
        rows.append([name, *cells, f"{instructions(name, lammps=True):.0f}"])
    return table(["scene", "double, plain", "double, avx2", "mixed, plain", "mixed, avx2", "LAMMPS, skin 0.3"], rows)


def python() -> str:
    """What Python and the files cost."""
    lines = [f"* 1000 beads, chunks of {n} steps with an observation each: {text}" for n, text in _chunk_costs()]
    lines.append(f"* `pydlpoly run` of 1000 beads with STATIS every 100 and OUTPUT every 1000 steps: {_run_cost()}")
    lines.append(
        "* HISTORY of 24 000 beads (positions) every 20 steps, one thread: the run with frames written in the "
        f"background is {_history_gain()} times as fast as with frames written between the steps. The gain needs a "
        "processor that is free."
    )
    return "\n".join(lines) + "\n"


def _measured(names: list[str], options: Options) -> Report:
    return measure(chosen(names), options, done=lambda result: print(result.text(), file=sys.stderr))


def _simds() -> tuple[str, ...]:
    probe = measure(chosen(["water-3k"]), Options(steps=1, repetitions=1)).scenes[0].contenders[0].plan
    order = ("plain", "avx2", "avx512")
    return order[: order.index(probe.rsplit(" ", 1)[-1]) + 1]


def _where(report: Report) -> str:
    return f"Measured on {report.machine.text()}.\n\n"


def _comparisons(reports: Iterable[Report]) -> str:
    rows = [
        [scene.name, one.of.removeprefix("pydlpoly "), one.to.removeprefix("pydlpoly "), one.ratio.text()]
        for report in reports
        for scene in report.scenes
        for one in scene.comparisons
    ]
    return table(["scene", "of", "to", "ratio of rates"], rows)


class _CoreClock:
    """Takes the time that an engine spends in the core's steps, in place of its ``run``."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def attach(self, simulation: Simulation) -> None:
        """Count this simulation's steps, too."""
        engine = simulation._engine
        run = engine.run

        def timed(steps: int) -> None:
            begin = time.perf_counter()
            run(steps)
            self.seconds += time.perf_counter() - begin

        setattr(engine, "run", timed)  # noqa: B010  # an attribute of this object hides the method


def _chunk_costs() -> list[tuple[int, str]]:
    costs = []
    simulation = Simulation(water(1000), seed=1, threads=1)
    simulation.run(500)
    clock = _CoreClock()
    clock.attach(simulation)
    for steps in (100, 1000):
        shares = []
        for _ in range(15):
            simulation._rate, clock.seconds = 1e9, 0.0  # one chunk
            begin = time.perf_counter()
            simulation.run(steps)
            simulation.observe()
            shares.append(100.0 * ((time.perf_counter() - begin) / clock.seconds - 1.0))
        costs.append((steps, f"Python takes {Spread.of(shares).text(2)} % of the core's time"))
    return costs


def _run_cost() -> str:
    scene = water(1000)
    scene = replace(scene, output=replace(scene.output, statistics_every=100, print_every=1000))
    shares = []
    for seed in range(5):
        with TemporaryDirectory() as folder:
            simulation, clock = Simulation(scene, seed=seed, threads=1), _CoreClock()
            simulation.run(100)
            clock.attach(simulation)
            log = reporters.OutputReporter(simulation, Path(folder) / "OUTPUT")
            statistics = reporters.StatisticsReporter(simulation, Path(folder) / "STATIS")
            keeper = reporters.CheckpointReporter(simulation, Path(folder), [statistics])
            simulation.reporters += [log, statistics, keeper]
            begin = time.perf_counter()
            simulation.run(20_000)
            shares.append(100.0 * ((time.perf_counter() - begin) / clock.seconds - 1.0))
            log.close()
            statistics.close()
    return f"Python takes {Spread.of(shares).text(2)} % of the core's time, checkpoints every 1000 steps included"


def _history_gain() -> str:
    scene = build(SCENES["water-24k"])
    assert not isinstance(scene, str)
    scene = replace(scene, output=replace(scene.output, trajectory_every=20))
    seconds: dict[str, list[float]] = {"between": [], "background": []}
    with TemporaryDirectory() as folder:
        running = {}
        for kind in seconds:
            simulation = Simulation(scene, seed=1, threads=1)
            simulation.run(300)
            trajectory = reporters.TrajectoryReporter(simulation, Path(folder) / kind)
            if kind == "between":
                setattr(trajectory, "_writer", trajectory._writer._writer)  # noqa: B010  # without the thread
            simulation.reporters.append(trajectory)
            running[kind] = simulation, trajectory
        for repetition in range(9):
            for kind in list(running)[:: 1 if repetition % 2 else -1]:
                simulation, trajectory = running[kind]
                begin = time.perf_counter()
                simulation.run(100)
                trajectory.sync()
                seconds[kind].append(time.perf_counter() - begin)
        for _, trajectory in running.values():
            trajectory.close()
    return Spread.of(np.divide(seconds["between"], seconds["background"]).tolist()).text()


PARTS: dict[str, Callable[[], str]] = {
    "ratios": ratios,
    "carried": carried,
    "simd": simd,
    "threads": threads,
    "cost": costs,
    "instructions": counted,
    "python": python,
}


def _between(fresh: str, marks: re.Match[str]) -> str:
    return f"{marks[1]}\n{fresh}\n{marks[2]}"


def main() -> int:
    """Measure and rewrite the page; the return value is the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", action="append", choices=list(PARTS))
    for name in parser.parse_args().only or PARTS:
        try:
            fresh = PARTS[name]()
        except PydlpolyError as error:
            print(f"{name}: {error}", file=sys.stderr)
            return 1
        mark = re.compile(rf"(<!-- measured: {name} -->\n).*?(<!-- end: {name} -->\n)", re.DOTALL)
        text = PAGE.read_text(encoding="utf-8")
        PAGE.write_text(mark.sub(partial(_between, fresh), text), encoding="utf-8")
        print(f"{name}: written")
    return 0


if __name__ == "__main__":
    sys.exit(main())
