"""The progress bar of a run: steps, rate, time left, temperatures and pressure; only for a person at a terminal."""

from __future__ import annotations

import math
import time as clock
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

if TYPE_CHECKING:
    from pydlpoly.simulation import Simulation

_REFRESH_SECONDS = 0.5
_RATE_SECONDS = 10.0  # the rate is an average over so long: steady to the eye, but it follows a machine that slows down
_CONFIGURATIONAL_SECONDS = 5.0  # the configurational temperature takes as long as some steps
_CONFIGURATIONAL_SHARE = 0.02  # of the run's time at most


class ProgressBar:
    """Shows how far a run is; to be called as often as one likes, at least several times a second."""

    def __init__(self, simulation: Simulation, progress: Progress, task: TaskID) -> None:
        self._simulation, self._progress, self._task = simulation, progress, task
        self._shown = clock.perf_counter()
        self._configurational_due = self._shown + _CONFIGURATIONAL_SECONDS
        self._configurational_step: int | None = None
        self._past: deque[tuple[float, int]] = deque([(self._shown, simulation.step)])

    def __call__(self) -> None:
        """Move the bar when half a second has gone by since the last time."""
        if clock.perf_counter() - self._shown >= _REFRESH_SECONDS:
            self.show()

    def show(self) -> None:
        """Move the bar and print rate, temperature and pressure, and the configurational temperature known last."""
        simulation = self._simulation
        seen, units = simulation.observe(), simulation.scene.units
        rate = f"{self._rate() * simulation.scene.bead_count / 1e6:.2f} M bead-steps/s"
        temperature = f"T {seen.temperature:.4g} {units.temperature_label}".rstrip()
        pressure = f"P {seen.pressure:.4g} {units.pressure_label}".rstrip()
        note = "  ".join((rate, temperature, pressure, *self._configurational()))
        self._progress.update(self._task, completed=simulation.step, note=note)

    def _configurational(self) -> list[str]:
        """Nothing or the text of the configurational temperature, computed only when nobody has done so for a while."""
        simulation, begin = self._simulation, clock.perf_counter()
        known = simulation.last_configurational_temperature
        if known is not None and known[0] != self._configurational_step:
            self._configurational_due = max(self._configurational_due, begin + _CONFIGURATIONAL_SECONDS)
        elif begin >= self._configurational_due:
            value = simulation.configurational_temperature
            end = clock.perf_counter()
            known = simulation.step, value
            pause = max(_CONFIGURATIONAL_SECONDS, (end - begin) / _CONFIGURATIONAL_SHARE)
            self._configurational_due = end + pause
        if known is None:
            return []
        self._configurational_step, value = known
        return [] if math.isnan(value) else [f"Tconf {value:.4g} {simulation.scene.units.temperature_label}".rstrip()]

    def _rate(self) -> float:
        """Steps per second over the last seconds."""
        self._shown = clock.perf_counter()
        self._past.append((self._shown, self._simulation.step))
        while len(self._past) > 2 and self._past[1][0] < self._shown - _RATE_SECONDS:
            self._past.popleft()
        (begin, first), (end, last) = self._past[0], self._past[-1]
        return (last - first) / max(end - begin, 1e-9)


@contextmanager
def progress_bar(simulation: Simulation, last: int) -> Iterator[Callable[[], None] | None]:
    """Show a bar up to step ``last`` while the context is open; None when standard error is no terminal."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    columns = (MofNCompleteColumn(), BarColumn(bar_width=20), TimeRemainingColumn(), TextColumn("{task.fields[note]}"))
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("steps", total=last, completed=simulation.step, note="")
        bar = ProgressBar(simulation, progress, task)
        yield bar
        bar.show()
