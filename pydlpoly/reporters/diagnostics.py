"""Reporter of DIAGNOSTICS: temperatures, parts of the pressure, momentum."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pydlpoly.formats.diagnostics import DiagnosticsWriter
from pydlpoly.observation import STRESS_PARTS
from pydlpoly.reporters.file_reporter import FileReporter
from pydlpoly.reporters.schedule import every
from pydlpoly.simulation import Simulation


class DiagnosticsReporter(FileReporter[DiagnosticsWriter]):
    """Writes DIAGNOSTICS."""

    def __init__(self, simulation: Simulation, path: Path, *, append: bool = False) -> None:
        units = simulation.scene.units
        self._every = simulation.scene.output.diagnostics_every
        words = {"temperature": units.temperature_label, "energy": units.label, "pressure": units.pressure_label}
        self._writer = DiagnosticsWriter(
            path,
            None if units.reduced else words,
            heat=simulation.scene.heat is not None,
            append=append,
            keep_until=simulation.step if append else None,
        )
        if not append:
            self.report(simulation)

    def next_step(self, step: int) -> int | None:
        """Return the next multiple of ``diagnostics_frequency``."""
        return every(step, self._every)

    def report(self, simulation: Simulation) -> None:
        """Write one record."""
        seen, scene = simulation.observe(), simulation.scene
        squared_force, laplacian = simulation.configurational()
        record = {
            "time": seen.time,
            "kinetic_temperature": seen.temperature,
            "configurational_temperature": simulation.configurational_temperature,
            "squared_force": squared_force,
            "laplacian": laplacian,
            "energy": seen.energy["total"] / scene.units.factor / scene.bead_count,
            **{f"pressure_{name}": float(np.trace(seen.stress_parts[name])) / 3.0 for name in STRESS_PARTS},
            **{f"momentum_{axis}": float(value) for axis, value in zip("xyz", seen.momentum, strict=True)},
        }
        if scene.heat is not None:
            per_bead = scene.units.factor * scene.bead_count
            record |= {
                "internal_temperature": simulation.internal_temperature,
                "internal_energy": seen.energy["internal"] / per_bead,
                "conserved_energy": seen.energy["conserved"] / per_bead,
            }
        self._writer.write(seen.step, record)
