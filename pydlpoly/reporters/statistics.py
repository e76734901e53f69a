"""Reporter of STATIS."""

from __future__ import annotations

from pathlib import Path

from pydlpoly.formats.statis import StatisticsWriter
from pydlpoly.reporters.file_reporter import FileReporter
from pydlpoly.reporters.schedule import every
from pydlpoly.reporters.statistics_record import statistics_record, variable_cell_columns
from pydlpoly.simulation import Simulation


class StatisticsReporter(FileReporter[StatisticsWriter]):
    """Writes STATIS."""

    def __init__(self, simulation: Simulation, path: Path, *, append: bool = False) -> None:
        scene = simulation.scene
        self._every = scene.output.statistics_every
        self._writer = StatisticsWriter(
            path,
            scene.title,
            scene.units.statis_label,
            scene.species,
            variable_cell=variable_cell_columns(scene),
            yaml=scene.output.statistics_yaml,
            append=append,
            keep_until=simulation.step if append else None,
        )
        if not append:
            self.report(simulation)

    def next_step(self, step: int) -> int | None:
        """Return the next multiple of ``stats_frequency``."""
        return every(step, self._every)

    def report(self, simulation: Simulation) -> None:
        """Write one record."""
        self._writer.write(statistics_record(simulation))
