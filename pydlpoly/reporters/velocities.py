"""Reporter of VAFDAT_<species>, which samples while running.

The sums go into the checkpoint, so that a run that continues ends with the same files. Averaged files are replaced as a
whole with every checkpoint: a kill leaves those of the last one.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.formats.records import FloatArray
from pydlpoly.formats.vafdat import CorrelationWriter, VelocityCorrelation, write_correlation
from pydlpoly.scene.model import Scene
from pydlpoly.simulation import Simulation


class VelocityReporter:
    """Writes VAFDAT_<species>: ⟨v(t0 + t)·v(t0)⟩ of the mobile beads of each species.

    As in DL_POLY: a sample is ``vaf_binsize`` steps long, and one begins every ``vaf_frequency`` steps after the
    equilibration (where samples overlap and the length is no multiple of that, each begins anew where it ends). With
    ``vaf_averaging`` the files hold the mean over all samples that are complete, otherwise one data set for each.
    A sample takes every step, so that steps are taken one by one.

    Args:
        simulation: the run.
        folder: where the files go.
        append: the run continues from a checkpoint.
    """

    name = "vaf"

    def __init__(self, simulation: Simulation, folder: Path, *, append: bool = False) -> None:
        scene, plan = simulation.scene, simulation.scene.output
        self._scene, self._folder = scene, folder
        self._length, self._every = plan.vaf_steps, plan.vaf_every
        overlapping = -(-self._length // self._every)
        self._period = max(self._length, self._every) if overlapping == 1 else self._length
        kinds, beads = len(scene.species), scene.bead_count
        self._mobile = np.where(scene.beads.frozen, kinds, scene.beads.species)  # the frozen are counted apart
        self._numbers = np.bincount(self._mobile, minlength=kinds + 1)[:kinds]
        self._start = max(scene.run.averages_after, simulation.step if append else 0)
        self._origins = np.zeros((overlapping, beads, 3))
        self._times = np.zeros((overlapping, self._length + 1))
        self._running = np.zeros((overlapping, self._length + 1, kinds))
        self._sums = np.zeros((self._length + 1, kinds))
        self._sets = 0
        self._last = np.zeros(self._length + 1)  # times of the last complete sample
        stored = simulation.restored_state(self.name)
        if stored:
            self._restore(stored)
        self._writers: list[CorrelationWriter] = []
        if not plan.vaf_averaging:
            keep = self._sets if stored else None
            for path in self.paths(scene, folder):
                self._writers.append(CorrelationWriter(path, scene.title, self._length + 1, keep))
        if not stored and simulation.step == self._start:
            self.report(simulation)

    @staticmethod
    def paths(scene: Scene, folder: Path) -> list[Path]:
        """Return the files, one for each species."""
        return [folder / f"VAFDAT_{name}" for name in scene.species]

    def next_step(self, step: int) -> int | None:
        """Return the next step that belongs to a sample."""
        if step < self._start:
            return self._start
        inside = (step - self._start) % self._period
        if self._period > self._length and inside >= self._length:
            return step + self._period - inside
        return step + 1

    def report(self, simulation: Simulation) -> None:
        """Take this step into every sample under way; close and begin those that end and begin here."""
        velocities = simulation.velocities
        for k in range(len(self._origins)):
            since = simulation.step - self._start - k * self._every
            if since < 0:
                continue
            point = since % self._period
            if self._period == self._length and point == 0 and since > 0:
                self._take(k, self._length, velocities, simulation.time)
                self._complete(k)
            if point == 0:
                self._origins[k] = velocities
            self._take(k, point, velocities, simulation.time)
            if point == self._length:
                self._complete(k)

    def _take(self, k: int, point: int, velocities: FloatArray, time: float) -> None:
        products = np.einsum("ij,ij->i", velocities, self._origins[k])
        self._running[k, point] = np.bincount(self._mobile, weights=products, minlength=len(self._numbers) + 1)[:-1]
        self._times[k, point] = time

    def _complete(self, k: int) -> None:
        self._sets += 1
        self._last = self._times[k].copy()
        self._sums = self._sums + self._running[k] if self._scene.output.vaf_averaging else self._running[k].copy()
        for writer, one in zip(self._writers, self.correlations(), strict=False):
            writer.write(one)

    def correlations(self) -> list[VelocityCorrelation]:
        """Return the function of each species: the mean so far, or the last sample."""
        averaged = self._scene.output.vaf_averaging
        samples = max(self._sets, 1) if averaged else 1
        steps = np.arange(self._length + 1) * self._scene.dynamics.timestep
        times = np.asarray(steps if averaged else self._last - self._last[0], dtype=np.float64)
        found = []
        for species, number, sums in zip(self._scene.species, self._numbers, self._sums.T, strict=True):
            first = float(sums[0])
            values = np.asarray(sums / first if first != 0.0 else sums, dtype=np.float64)
            at_origin = first / (number * samples) if number else 0.0
            found.append(VelocityCorrelation(species, at_origin, float(self._last[0]), times, values))
        return found

    def state(self) -> dict[str, NDArray[Any]]:
        """Return samples and sums for the checkpoint."""
        return {
            "origins": self._origins.copy(),
            "times": self._times.copy(),
            "running": self._running.copy(),
            "sums": self._sums.copy(),
            "last": self._last.copy(),
            "counts": np.array([self._start, self._sets], dtype=np.int64),
        }

    def _restore(self, stored: dict[str, NDArray[Any]]) -> None:
        self._origins, self._times = stored["origins"].copy(), stored["times"].copy()
        self._running, self._sums = stored["running"].copy(), stored["sums"].copy()
        self._last = stored["last"].copy()
        self._start, self._sets = (int(count) for count in stored["counts"])

    def sync(self) -> None:
        """Write the averages, when a sample is complete, or wait until all data sets are on the disk."""
        for writer in self._writers:
            writer.sync()
        if self._sets and not self._writers:
            for path, one in zip(self.paths(self._scene, self._folder), self.correlations(), strict=True):
                write_correlation(path, self._scene.title, one)

    def close(self) -> None:
        """Close the files."""
        for writer in self._writers:
            writer.close()
