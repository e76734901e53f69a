"""Reporter of HISTORY."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pydlpoly.background import BackgroundWriter
from pydlpoly.formats.history import HistoryWriter
from pydlpoly.reporters.configuration import bead_names
from pydlpoly.reporters.file_reporter import FileReporter
from pydlpoly.reporters.schedule import every
from pydlpoly.simulation import Simulation


class TrajectoryReporter(FileReporter[BackgroundWriter]):
    """Writes HISTORY, while the simulation goes on: see ``BackgroundWriter`` for when errors are raised."""

    def __init__(self, simulation: Simulation, path: Path, *, append: bool = False) -> None:
        scene = simulation.scene
        self._start, self._every = scene.output.trajectory_start, scene.output.trajectory_every
        self._level = scene.output.trajectory_level
        writer = HistoryWriter(
            path,
            scene.title,
            self._level,
            scene.imcon,
            bead_names(scene),
            scene.beads.mass,
            scene.beads.charge,
            append=append,
            keep_until=simulation.step if append else None,
        )
        self._writer = BackgroundWriter(writer)
        if not append and self._start == 0:
            self.report(simulation)

    def next_step(self, step: int) -> int | None:
        """Return the next step of the form start + k·interval."""
        return every(step, self._every, self._start)

    def report(self, simulation: Simulation) -> None:
        """Have one frame written."""
        state = simulation.state
        self._writer.write(
            state.step,
            state.time,
            simulation.scene.dynamics.timestep,
            state.cell,
            state.positions,
            velocities=state.velocities if self._level >= 1 else None,
            forces=state.forces if self._level >= 2 else None,
            displacements=np.linalg.norm(simulation.displacements(), axis=1),
        )
