"""The measurement: who runs when, how long, and what is compared with what.

All contenders of a scene live at the same time, each in a process of its own, and take turns: within a repetition each
runs for a moment, forwards in one repetition and backwards in the next. What is compared are the two runs of the same
repetition, so that a machine that slows down for a while slows down both; the median over the repetitions forgets the
cases where it did not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

from pydlpoly.bench.lammps_input import LammpsInput, lammps_input
from pydlpoly.bench.processes import Process, RefusedError, start_lammps, start_pydlpoly
from pydlpoly.bench.results import Comparison, Contender, Report, SceneResult, Spread, this_machine
from pydlpoly.bench.scenes import BenchScene, build
from pydlpoly.errors import RunError
from pydlpoly.scene.model import Scene

_SCAN_SECONDS = 0.3


@dataclass(frozen=True)
class Options:
    """What to measure.

    Attributes:
        threads, precisions, simds: every combination is a contender; simd None is the best the processor has.
        steps: steps of a repetition, None to take what lasts ``seconds``.
        repetitions: how often each contender runs.
        lammps: compare with LAMMPS on one core.
        python: compare with the pydlpoly of this interpreter.
    """

    threads: tuple[int, ...] = (1,)
    precisions: tuple[str, ...] = ("double",)
    simds: tuple[str | None, ...] = (None,)
    steps: int | None = None
    seconds: float = 0.5
    repetitions: int = 9
    lammps: bool = False
    python: str | None = None


@dataclass
class _Running:
    """A contender at work."""

    process: Process
    label: str
    program: str
    threads: int
    precision: str
    simd: str | None
    plan: str
    steps: int = 0
    temperature: float = 0.0


def measure(
    scenes: Iterable[BenchScene],
    options: Options,
    *,
    done: Callable[[SceneResult], None] = lambda _: None,
    progress: Callable[[str, int, int], None] = lambda *_: None,
) -> Report:
    """Run the scenes and return what was found.

    Args:
        scenes: from ``scenes.chosen``.
        options: see there.
        done: called with each scene's result.
        progress: called with a scene's name and how many of how many repetitions it has done.

    Raises:
        InputError: LAMMPS or the other interpreter is missing.
    """
    report = Report(this_machine(), options.repetitions)
    for scene in scenes:
        result = _measure_scene(scene, options, progress)
        report.scenes.append(result)
        done(result)
    return report


def _measure_scene(bench: BenchScene, options: Options, progress: Callable[[str, int, int], None]) -> SceneResult:
    progress(bench.name, 0, options.repetitions)
    scene = build(bench)
    if isinstance(scene, str):
        return SceneResult(bench.name, bench.about, bench.beads, unavailable=scene)
    try:
        with TemporaryDirectory() as folder, _running(bench, scene, options, Path(folder)) as (running, notes):
            for one in running:
                one.steps = options.steps or calibrated(one.process, options.seconds)
            seconds = _alternate(running, options.repetitions, lambda k: progress(bench.name, k, options.repetitions))
            contenders = tuple(_contender(one, times, bench.beads) for one, times in zip(running, seconds, strict=True))
    except RunError as error:
        return SceneResult(bench.name, bench.about, bench.beads, unavailable=str(error), failed=True)
    return SceneResult(bench.name, bench.about, bench.beads, contenders, tuple(_comparisons(contenders)), tuple(notes))


@contextmanager
def _running(
    bench: BenchScene, scene: Scene, options: Options, folder: Path
) -> Iterator[tuple[list[_Running], list[str]]]:
    """Start all contenders from the same equilibrated state; give them and notes on those that cannot be."""
    notes: list[str] = []
    running: list[_Running] = []
    state: Path | None = None
    with ExitStack() as opened:
        programs = [("pydlpoly", None), *([("other", options.python)] if options.python else [])]
        combinations = product(options.threads, options.precisions, options.simds, programs)
        for threads, precision, simd, (program, python) in combinations:
            process = opened.enter_context(
                start_pydlpoly(bench.name, threads=threads, precision=precision, simd=simd, state=state, python=python)
            )
            if "unavailable" in process.description:
                notes.append(f"not run by {python or 'pydlpoly'}: {process.description['unavailable']}")
                continue
            if state is None:
                state = folder / "state.npz"
                process.ask(save=str(state))
            label = _label(program, threads, precision, simd)
            plan = str(process.description["plan"])
            running.append(_Running(process, label, program, threads, precision, simd, plan))
        if options.lammps and state is not None:
            given = lammps_input(scene)
            if isinstance(given, str):
                notes.append(f"no comparison with LAMMPS: {given}")
            else:
                process = opened.enter_context(start_lammps(given, folder, scene.beads.species, state))
                plan = fastest_setup(process, given)
                running.append(_Running(process, "LAMMPS", "lammps", 1, "double", None, plan))
                running[-1].temperature = float(process.ask(thermo=True)["temperature"])
        yield running, notes


def _label(program: str, threads: int, precision: str, simd: str | None) -> str:
    words = [f"{threads} thread{'s' if threads > 1 else ''}", precision, *([simd] if simd else [])]
    return f"{'pydlpoly' if program == 'pydlpoly' else 'other build'} ({', '.join(words)})"


def calibrated(process: Process, seconds: float) -> int:
    """Return the number of steps that takes about so long, 20 at least; whole hundreds where there are that many.

    Fewer would say more about the ends of a run, where beads are converted and observed, than about its steps.
    """
    steps, taken = 2, process.seconds(2)
    while taken < 0.2 * seconds:
        steps *= 4
        taken = process.seconds(steps)
    found = max(20, round(steps * seconds / taken))
    return found if found < 100 else round(found / 100) * 100


def fastest_setup(process: Process, given: LammpsInput) -> str:
    """Find LAMMPS's fastest pair style and then neighbour list in short runs, leave it set up so, and name it."""
    usual = "skin 0.3"
    style = _fastest(process, {name: [*lines, *given.neighbours[usual]] for name, lines in given.pairs.items()})
    pairs = given.pairs[style]
    neighbours = _fastest(process, {name: [*pairs, *lines] for name, lines in given.neighbours.items()})
    process.ask(commands=[*pairs, *given.neighbours[neighbours]])
    return f"pair style {style}, {neighbours}"


def _fastest(process: Process, candidates: dict[str, list[str]]) -> str:
    """The candidate with the shortest of three short runs, which take turns."""
    best = dict.fromkeys(candidates, float("inf"))
    steps = 0
    for _ in range(3):
        for name, commands in list(candidates.items()):
            try:
                process.ask(commands=commands)
            except RefusedError:  # a pair style of a package that this LAMMPS was built without
                del candidates[name]
                continue
            steps = steps or calibrated(process, _SCAN_SECONDS)
            best[name] = min(best[name], process.seconds(steps))
    return min(best, key=lambda name: best[name])


def _alternate(running: list[_Running], repetitions: int, done: Callable[[int], None]) -> list[list[float]]:
    """Seconds of every repetition of each contender, in their order."""
    seconds: list[list[float]] = [[] for _ in running]
    for repetition in range(repetitions):
        order = list(zip(running, seconds, strict=True))
        for one, times in order if repetition % 2 == 0 else reversed(order):
            times.append(one.process.seconds(one.steps))
        done(repetition + 1)
    return seconds


def _contender(one: _Running, seconds: list[float], beads: int) -> Contender:
    said = one.process.description
    return Contender(
        label=one.label,
        program=one.program,
        threads=one.threads,
        precision=one.precision,
        simd=one.simd,
        plan=one.plan,
        version=str(said["version"]),
        package=str(said.get("package", "")),
        steps=one.steps,
        seconds=tuple(seconds),
        rate=Spread.of([beads * one.steps / time for time in seconds]),
        bytes_per_bead=said.get("bytes_per_bead"),
        temperature=float(said.get("temperature", one.temperature)),
    )


def _comparisons(contenders: tuple[Contender, ...]) -> Iterator[Comparison]:
    """Each of ours with our first, with the other build's under the same settings, and with LAMMPS."""
    ours = [one for one in contenders if one.program == "pydlpoly"]
    for one in ours[1:]:
        yield _comparison(one, ours[0])
    for one in ours:
        for other in contenders:
            same = (other.threads, other.precision, other.simd) == (one.threads, one.precision, one.simd)
            if other.program == "lammps" or (other.program == "other" and same):
                yield _comparison(one, other)


def _comparison(one: Contender, other: Contender) -> Comparison:
    rates = [[c.steps / time for time in c.seconds] for c in (one, other)]
    return Comparison(one.label, other.label, Spread.of([a / b for a, b in zip(*rates, strict=True)]))
