"""The progress bar of a run: steps, rate, time left, temperature and pressure; only for a person at a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

if TYPE_CHECKING:
    from pydlpoly.simulation import Simulation

_REFRESH_SECONDS = 0.5


class ProgressReporter:
    """Shows the run's progress about twice a second."""

    def __init__(self, simulation: Simulation, progress: Progress, task: TaskID) -> None:
        self._simulation, self._progress, self._task = simulation, progress, task

    def next_step(self, step: int) -> int:
        """Return a step about half a second ahead."""
        return step + max(1, int(self._simulation.steps_per_second * _REFRESH_SECONDS))

    def report(self, simulation: Simulation) -> None:
        """Move the bar and print rate, temperature and pressure."""
        seen = simulation.observe()
        units = simulation.scene.units
        rate = simulation.steps_per_second * simulation.scene.bead_count / 1e6
        text = (
            f"{rate:.2f} M bead-steps/s  T {seen.temperature:.4g} {units.temperature_label}  "
            f"P {seen.pressure:.4g} {units.pressure_label}"
        )
        self._progress.update(self._task, completed=simulation.step, note=text)


@contextmanager
def progress_reporter(simulation: Simulation, last: int) -> Iterator[ProgressReporter]:
    """Show a bar up to step ``last`` while the context is open; prints nothing when standard error is no terminal."""
    console = Console(stderr=True)
    columns = (MofNCompleteColumn(), BarColumn(), TimeRemainingColumn(), TextColumn("{task.fields[note]}"))
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        task = progress.add_task("steps", total=last, completed=simulation.step, note="")
        reporter = ProgressReporter(simulation, progress, task)
        yield reporter
        reporter.report(simulation)
