"""Reporter of ZDNDAT, which samples while running.

The counts go into the checkpoint, so that a run that continues ends with the same file. ZDNDAT is replaced as a whole
with every checkpoint: a kill leaves that of the last one.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.formats.records import FloatArray
from pydlpoly.formats.zdndat import write_density
from pydlpoly.reporters.schedule import every
from pydlpoly.simulation import Simulation


class DensityReporter:
    """Writes ZDNDAT: beads of each species by their place along z, in bins over the cell's height.

    Where the cell varies, bins are fractions of its height, and height and volume are means over the samples.

    Args:
        simulation: the run.
        path: the file.
    """

    name = "zden"

    def __init__(self, simulation: Simulation, path: Path) -> None:
        scene = simulation.scene
        self._scene, self._path = scene, path
        self._after, self._every = scene.run.averages_after, scene.output.zden_every
        self._counts = np.zeros((len(scene.species), scene.output.zden_bins), dtype=np.int64)
        self._samples = 0
        self._sizes = np.zeros(2)  # sums of height and volume
        stored = simulation.restored_state(self.name)
        if stored:
            self._counts = stored["counts"].astype(np.int64)
            self._samples, self._sizes = int(stored["samples"]), stored["sizes"].copy()

    def next_step(self, step: int) -> int | None:
        """Return the next multiple of ``zden_frequency`` after the equilibration."""
        return every(max(step, self._after), self._every)

    def report(self, simulation: Simulation) -> None:
        """Take one sample."""
        positions, cell = simulation.positions, simulation.cell
        height = float(np.abs(cell[:, 2]).sum())
        bins = self._counts.shape[1]
        place = ((positions[:, 2] / height + 0.5) * bins).astype(np.int64)
        numbers = self._scene.beads.species * bins + np.clip(place, 0, bins - 1)
        self._counts += np.bincount(numbers, minlength=self._counts.size).reshape(self._counts.shape)
        self._samples += 1
        self._sizes += (height, abs(float(np.linalg.det(cell))))

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the counts for the checkpoint."""
        samples = np.array(self._samples, dtype=np.int64)
        return {"counts": self._counts.copy(), "samples": samples, "sizes": self._sizes.copy()}

    def profiles(self) -> tuple[FloatArray, FloatArray]:
        """Return z (bins,) in Å and the densities (species, bins) per Å³; zeros before the first sample."""
        bins = self._counts.shape[1]
        height, volume = self._sizes / max(self._samples, 1)
        z = ((np.arange(bins) + 0.5) / bins - 0.5) * height
        if not self._samples:
            return z, np.zeros(self._counts.shape)
        return z, self._counts / (self._samples * volume / bins)

    def sync(self) -> None:
        """Write the file, when anything has been sampled."""
        if self._samples:
            write_density(self._path, self._scene.title, self._scene.species, *self.profiles())

    def close(self) -> None:
        """Nothing is open between writes."""
