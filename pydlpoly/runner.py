"""A whole run with its files: what ``pydlpoly run`` does, usable from Python.

Everything that can be refused is refused before the first file is touched. Files of an earlier run are kept once, under
their name with ``.bak`` appended.
"""

from __future__ import annotations

import os
import sys
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.output import RunSummary
from pydlpoly.reporters import CheckpointReporter, OutputReporter, StatisticsReporter, TrajectoryReporter
from pydlpoly.scene.model import OutputPlan, Scene
from pydlpoly.simulation import Simulation


@dataclass(frozen=True)
class RunResult:
    """How a run ended.

    Attributes:
        interrupted: Ctrl-C ended it before its last step; everything was written and it can be continued.
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
) -> RunResult:
    """Run a scene to its last step, writing the files its CONTROL asks for.

    Args:
        scene: what to model.
        folder: where the files go; made when it does not exist.
        steps: total number of steps in place of the scene's.
        threads, seed: as for ``Simulation``.
        checkpoint: continue from this file (appending to STATIS, HISTORY and OUTPUT) instead of starting anew.
        progress: show a progress bar on a terminal.

    Raises:
        InputError: the checkpoint cannot be continued, or the folder cannot be written.
        RunError: the run stopped being physical; the last good state is in REVCON and the checkpoint.
    """
    last = scene.run.steps if steps is None else steps
    begin = clock.perf_counter()
    if checkpoint is None:
        simulation = Simulation(scene, threads=threads, seed=seed)
    else:
        simulation = Simulation.resume(checkpoint, scene=scene, threads=threads)
        if simulation.step >= last:
            raise InputError(
                f"is at step {simulation.step} already; to go on, ask for more than that in all (time_run or --steps), "
                f"not {last}",
                path=str(checkpoint),
            )
    target = Path(folder)
    output = scene.output
    _prepare_folder(target, [] if checkpoint else _file_names(output))
    append = checkpoint is not None
    set_up = clock.perf_counter() - begin
    with _reporters(simulation, target, append=append) as (log, keeper):
        interrupted, failure = False, None
        loop = clock.perf_counter()
        try:
            simulation.run(last - simulation.step, progress=progress)
        except KeyboardInterrupt:
            interrupted = True
        except RunError as error:
            failure = error
        loop = clock.perf_counter() - loop
        warnings = [note.text for note in scene.notes if note.kind == "warning"]
        if failure is None:
            keeper.report(simulation)
        else:
            warnings.append(f"the run stopped: {failure}")
        if interrupted:
            warnings.append(f"the run was interrupted at step {simulation.step} of {last}")
        summary = log.finish(simulation, warnings, {"set-up": set_up, "steps": loop})
        if failure is not None:
            raise failure
    path = target / output.checkpoint_file if output.checkpoint_file else None
    return RunResult(simulation, summary, target, interrupted, path)


def _file_names(output: OutputPlan) -> list[str]:
    names = [
        output.output_file,
        output.statistics_file if output.statistics_every > 0 else None,
        output.trajectory_file if output.trajectory_every > 0 else None,
        output.rdf_file if output.rdf_every > 0 else None,
        output.configuration_file,
        output.checkpoint_file,
    ]
    return [name for name in names if name is not None and name != "SCREEN"]


def _prepare_folder(folder: Path, names: list[str]) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError("no permission to write")
        for name in names:
            path = folder / name
            if path.is_file():
                path.replace(path.with_name(path.name + ".bak"))
    except OSError as error:
        raise InputError(f"the output folder cannot be used ({error})", path=str(folder)) from error


@contextmanager
def _reporters(
    simulation: Simulation, folder: Path, *, append: bool
) -> Iterator[tuple[OutputReporter, CheckpointReporter]]:
    """Open the scene's files, attach their reporters, and close the files whatever happens."""
    output = simulation.scene.output
    files: list[StatisticsReporter | TrajectoryReporter] = []
    log_path = None
    if output.output_file == "SCREEN":
        log_path = Path("/dev/stdout") if sys.platform != "win32" else None
    elif output.output_file is not None:
        log_path = folder / output.output_file
    log = OutputReporter(simulation, log_path, append=append)
    try:
        if output.statistics_every > 0:
            files.append(StatisticsReporter(simulation, folder / output.statistics_file, append=append))
        if output.trajectory_every > 0:
            files.append(TrajectoryReporter(simulation, folder / output.trajectory_file, append=append))
        keeper = CheckpointReporter(simulation, folder, files)
        simulation.reporters += [log, *files, keeper]
        yield log, keeper
    finally:
        log.close()
        for file in files:
            file.close()
