"""A whole run with its files: what ``pydlpoly run`` does, usable from Python.

Everything that can be refused is refused before the first file is touched. Files of an earlier run are kept once, under
their name with ``.bak`` appended. Ctrl-C and SIGTERM end the run early, but in good order: every reporter of the step
is called, and everything is written so that the run can be continued with the same bits.
"""

from __future__ import annotations

import os
import signal
import sys
import time as clock
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from pydlpoly.callbacks import CallbackFunction
from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.atomic import sole_writer
from pydlpoly.formats.output import RunSummary
from pydlpoly.interrupts import deferred_signals
from pydlpoly.reporters import (
    BinReporter,
    CheckpointReporter,
    DensityReporter,
    DiagnosticsReporter,
    DisplacementReporter,
    OutputReporter,
    StatisticsReporter,
    StressCorrelations,
    StressProfile,
    TrajectoryReporter,
    VelocityReporter,
    samplers,
    stress_reporters,
)
from pydlpoly.scene.beads_state import carried_names
from pydlpoly.scene.model import Scene
from pydlpoly.simulation import Reporter, Simulation
from pydlpoly.trajectories import FORMATS
from pydlpoly.trajectories.reporter import FormatsReporter

_SIGNALS = (signal.SIGINT, signal.SIGTERM)  # batch systems announce the end of a job with the second
_SCREEN = "SCREEN"
_PARTS = {  # of the loop over steps, in the words of OUTPUT
    "engine": "of which motion and forces",
    OutputReporter.__name__: "of which OUTPUT, averages",
    StatisticsReporter.__name__: "of which STATIS",
    DiagnosticsReporter.__name__: "of which DIAGNOSTICS",
    TrajectoryReporter.__name__: "of which HISTORY",
    DensityReporter.__name__: "of which ZDNDAT",
    VelocityReporter.__name__: "of which VAFDAT",
    DisplacementReporter.__name__: "of which MSDTMP",
    StressProfile.__name__: "of which STRPRF",
    StressCorrelations.__name__: "of which COR",
    BinReporter.__name__: "of which PROFILE, MAP",
    FormatsReporter.__name__: "of which trajectory",
    CheckpointReporter.__name__: "of which checkpoints",
}


class _File(Reporter, Protocol):
    """A reporter with files of its own."""

    def sync(self) -> None:
        """Have everything so far reach the disk."""

    def close(self) -> None:
        """Close the files."""


@dataclass(frozen=True)
class RunResult:
    """How a run ended.

    Attributes:
        interrupted: Ctrl-C or SIGTERM ended it before its last step; everything was written and it can be continued.
        checkpoint: the file to continue from, None when CONTROL switches it off.
    """

    simulation: Simulation
    summary: RunSummary
    folder: Path
    interrupted: bool
    checkpoint: Path | None


def run_scene(
    scene: Scene,
    folder: str | Path,
    *,
    steps: int | None = None,
    threads: int | None = None,
    seed: int | None = None,
    checkpoint: str | Path | None = None,
    progress: bool = False,
    callbacks: Sequence[tuple[CallbackFunction, int]] = (),
    engine: str = "native",
    ranks: int | None = None,
    accelerator: str = "",
) -> RunResult:
    """Run a scene to its last step, writing the files its CONTROL asks for.

    Args:
        scene: what to model.
        folder: where the files go; made when it does not exist.
        steps: total number of steps in place of the scene's.
        threads, seed: as for ``Simulation``; a run that continues has the checkpoint's seed.
        checkpoint: continue from this file instead of starting anew. STATIS, DIAGNOSTICS and trajectories are appended
            to; records of steps after the checkpoint's are dropped first, since they are computed anew.
        progress: show a progress bar on a terminal.
        callbacks: functions and their intervals in steps, as for ``Simulation.add_callback``.
        engine, ranks, accelerator: as for ``Simulation``.

    Raises:
        InputError: the checkpoint cannot be continued, or the files cannot be written, or another run is writing them;
            nothing has been touched.
        RunError: the run stopped being physical; the text says where the last whole state is.
    """
    last = scene.run.steps if steps is None else steps
    begin = clock.perf_counter()
    engine_options = {"engine": engine, "ranks": ranks, "accelerator": accelerator}
    simulation = _simulation(scene, last, threads, seed, checkpoint, engine_options)
    for function, every in callbacks:
        simulation.add_callback(function, every)
    target = Path(folder)
    with deferred_signals(simulation.interrupt, _SIGNALS):
        paths = _prepare_folder(target, scene, keep=checkpoint is None)
        with sole_writer(target):
            if checkpoint is None:
                _set_aside(paths, target)
            with _reporters(simulation, target, append=checkpoint is not None) as (log, keeper):
                if checkpoint is not None:
                    keeper.written_step = simulation.step
                set_up = clock.perf_counter() - begin
                summary, interrupted = _run(simulation, last, log, keeper, set_up, progress and not _fights_with(scene))
    path = target / scene.output.checkpoint_file if scene.output.checkpoint_file else None
    return RunResult(simulation, summary, target, interrupted, path)


def _simulation(
    scene: Scene,
    last: int,
    threads: int | None,
    seed: int | None,
    checkpoint: str | Path | None,
    engine: dict[str, Any],
) -> Simulation:
    if checkpoint is None:
        if scene.run.start == "continue":
            raise InputError("CONTROL asks to continue a run (restart continue): say which checkpoint to continue from")
        simulation = Simulation(scene, threads=threads, seed=seed, **engine)
    else:
        if seed is not None:
            raise InputError("a run that continues keeps the seed of its checkpoint; leave the seed out")
        simulation = Simulation.resume(checkpoint, scene=scene, threads=threads, **engine)
        if simulation.step >= last:
            raise InputError(
                f"is at step {simulation.step} already; to go on, ask for more than that in all (time_run or --steps), "
                f"not {last}",
                path=str(checkpoint),
            )
    # What is printed and stored is the run as it is, not as CONTROL would have it.
    plan = replace(scene.run, steps=last, seed=simulation.seed, threads=threads or scene.run.threads)
    simulation.scene = replace(simulation.scene, run=plan)
    return simulation


def _run(
    simulation: Simulation, last: int, log: OutputReporter, keeper: CheckpointReporter, set_up: float, progress: bool
) -> tuple[RunSummary, bool]:
    """Take the steps and write the end of the files; return the summary and whether the run was interrupted."""
    failure: RunError | None = None
    loop = clock.perf_counter()
    try:
        simulation.run(last - simulation.step, progress=progress)
    except KeyboardInterrupt:
        pass  # how far the run got says whether it is done
    except RunError as error:
        failure = error
    timings = {"set-up": set_up, "steps": clock.perf_counter() - loop, **_parts_of_loop(simulation)}
    warnings = [note.text for note in simulation.scene.notes if note.kind == "warning"]
    if failure is not None:
        failure = RunError(f"{failure}; {_last_whole_state(keeper)}")
        with suppress(RunError):  # the disk may be what failed
            log.finish(simulation, [*warnings, f"the run stopped: {failure}"], timings)
        raise failure
    interrupted = simulation.step < last
    if interrupted:
        warnings.append(f"the run was interrupted at step {simulation.step} of {last}")
    if keeper.written_step != simulation.step:
        begin = clock.perf_counter()
        keeper.report(simulation)
        timings["last checkpoint"] = clock.perf_counter() - begin
    return log.finish(simulation, warnings, timings), interrupted


def _parts_of_loop(simulation: Simulation) -> dict[str, float]:
    """Return seconds of the loop by part; what several reporters look at counts for the first of them."""
    return {_PARTS.get(name, f"of which {name}"): seconds for name, seconds in simulation.seconds.items()}


def _last_whole_state(keeper: CheckpointReporter) -> str:
    if keeper.written_step is None:
        return "no checkpoint had been written yet"
    return f"the last checkpoint is that of step {keeper.written_step}"


def _fights_with(scene: Scene) -> bool:
    """Whether a progress bar would be drawn across OUTPUT on the same terminal."""
    return scene.output.output_file == _SCREEN and sys.stdout.isatty()


def _file_names(scene: Scene) -> list[str]:
    output = scene.output
    names = [
        None if output.output_file == _SCREEN else output.output_file,
        output.statistics_file if output.statistics_every > 0 else None,
        output.diagnostics_file if output.diagnostics_every > 0 else None,
        output.trajectory_file if output.trajectory_every > 0 else None,
        *(_format_files(scene) if output.trajectory_every > 0 else ()),
        output.rdf_file if output.rdf_every > 0 else None,
        output.profile.file if output.profile.every > 0 else None,
        output.correlations.file if output.correlations.terms else None,
        "ZDNDAT" if output.zden_every > 0 else None,
        output.msd_file if output.msd_every > 0 else None,
        *(path.name for path in VelocityReporter.paths(scene, Path()) if output.vaf_every > 0),
        output.bead_profile.file if output.bead_profile.every > 0 else None,
        output.bead_map.file if output.bead_map.every > 0 else None,
        output.configuration_file,
        output.beads_file if carried_names(scene) else None,
        output.checkpoint_file,
    ]
    return [name for name in names if name is not None]


def _format_files(scene: Scene) -> tuple[str, ...]:
    output = scene.output
    return tuple(file for name in output.trajectory_formats for file in FORMATS[name].files(output.trajectory_stem))


def _prepare_folder(folder: Path, scene: Scene, *, keep: bool) -> list[Path]:
    """Make sure that all files can be written, and return them; ``keep``: those of an earlier run will be set aside."""
    paths = [folder / name for name in _file_names(scene)]
    last = (scene.output.configuration_file, scene.output.beads_file)
    _refuse_clashes(paths, scene, [] if keep else [folder / name for name in last if name])
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path in paths:
            if path.is_dir():
                raise InputError("is a folder; expected a file that can be written", path=str(path))
            if not os.access(path.parent, os.W_OK) or (path.exists() and not os.access(path, os.W_OK)):
                found = "no permission to write here" if path.parent.is_dir() else "there is no such folder"
                raise InputError(f"cannot be written: {found}", path=str(path))
    except OSError as error:
        raise InputError(f"the output folder cannot be used: {error.strerror or error}", path=str(folder)) from error
    return paths


def _set_aside(paths: list[Path], folder: Path) -> None:
    try:
        for path in paths:
            if path.is_file():
                path.replace(path.with_name(path.name + ".bak"))
    except OSError as error:
        raise InputError(f"the output folder cannot be used: {error.strerror or error}", path=str(folder)) from error


def _refuse_clashes(paths: list[Path], scene: Scene, allowed: list[Path]) -> None:
    """Refuse names that would have one file overwrite another, or the input; ``allowed`` may have been read before."""
    sources = {os.path.realpath(source) for source in scene.sources}
    seen: set[str] = set()
    for path in paths:
        real = os.path.realpath(path)
        if real in sources and path not in allowed:
            raise InputError("is an input file of this run; give the output another name or folder", path=str(path))
        if real in seen:
            raise InputError("two output files of this run have this name", path=str(path))
        seen.add(real)


@contextmanager
def _reporters(
    simulation: Simulation, folder: Path, *, append: bool
) -> Iterator[tuple[OutputReporter, CheckpointReporter]]:
    """Open the scene's files, attach their reporters, and close the files whatever happens."""
    output = simulation.scene.output
    screen = output.output_file == _SCREEN
    path = folder / output.output_file if output.output_file is not None and not screen else None
    with ExitStack() as opened:
        files: list[_File] = []
        try:
            if output.statistics_every > 0:
                statistics = StatisticsReporter(simulation, folder / output.statistics_file, append=append)
                opened.callback(statistics.close)
                files.append(statistics)
            if output.diagnostics_every > 0:
                diagnostics = DiagnosticsReporter(simulation, folder / output.diagnostics_file, append=append)
                opened.callback(diagnostics.close)
                files.append(diagnostics)
            if output.trajectory_every > 0 and output.trajectory_file:
                trajectory = TrajectoryReporter(simulation, folder / output.trajectory_file, append=append)
                opened.callback(trajectory.close)
                files.append(trajectory)
            if output.trajectory_every > 0 and output.trajectory_formats:
                formats = FormatsReporter(simulation, folder, append=append)
                opened.callback(formats.close)
                files.append(formats)
            for sampler in samplers(simulation, folder, append=append):
                opened.callback(sampler.close)
                files.append(sampler)
            log = OutputReporter(simulation, path, append=append, stream=sys.stdout if screen else None)
            opened.callback(log.close)
        except RunError as error:  # a file that cannot be opened is a matter of the input, not of the physics
            raise InputError(str(error)) from error
        stress = stress_reporters(simulation, folder)
        keeper = CheckpointReporter(simulation, folder, [*files, *stress])
        simulation.reporters += [log, *files, *stress, keeper]
        yield log, keeper
