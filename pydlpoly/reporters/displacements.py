"""Reporter of MSDTMP."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pydlpoly.formats.msdtmp import DisplacementWriter
from pydlpoly.reporters.configuration import bead_names
from pydlpoly.reporters.file_reporter import FileReporter
from pydlpoly.reporters.schedule import every
from pydlpoly.simulation import Simulation


class DisplacementReporter(FileReporter[DisplacementWriter]):
    """Writes MSDTMP: how far every bead is from where it started, and its temperature m v²/(3 k_B).

    Args:
        simulation: the run.
        path: the file.
        append: the run continues from a checkpoint.
    """

    def __init__(self, simulation: Simulation, path: Path, *, append: bool = False) -> None:
        scene = simulation.scene
        self._start, self._every = scene.output.msd_start, scene.output.msd_every
        keep = simulation.step if append else None
        self._writer = DisplacementWriter(path, scene.title, bead_names(scene), append=append, keep_until=keep)
        if not append and self._start == 0:
            self.report(simulation)

    def next_step(self, step: int) -> int | None:
        """Return the next step of the form start + k·interval."""
        return every(step, self._every, self._start)

    def report(self, simulation: Simulation) -> None:
        """Write one frame."""
        scene = simulation.scene
        moved = np.linalg.norm(simulation.displacements(), axis=1)
        squares = np.sum(simulation.velocities**2, axis=1)
        temperatures = scene.beads.mass * squares / (3.0 * scene.units.boltzmann)
        self._writer.write(simulation.step, simulation.time, scene.dynamics.timestep, moved, temperatures)
