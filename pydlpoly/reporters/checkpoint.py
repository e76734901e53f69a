"""Reporter of the checkpoint, and of the files that say where the run is: REVCON, REVBEADS, RDFDAT."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pydlpoly.formats.atomic import atomic_file
from pydlpoly.formats.beads_file import write_beads
from pydlpoly.formats.config_writer import write_config_to
from pydlpoly.reporters.configuration import configuration_of
from pydlpoly.reporters.distances import write_distances
from pydlpoly.reporters.schedule import every
from pydlpoly.scene.beads_state import carried_names
from pydlpoly.simulation import Simulation


class CheckpointReporter:
    """Writes REVCON, REVBEADS and the checkpoint, each replaced as a whole; other files reach the disk first."""

    def __init__(self, simulation: Simulation, folder: Path, others: Sequence[object] = ()) -> None:
        output = simulation.scene.output
        self._every = output.checkpoint_every
        self._configuration = folder / output.configuration_file if output.configuration_file else None
        self._checkpoint = folder / output.checkpoint_file if output.checkpoint_file else None
        self._carried = carried_names(simulation.scene)
        self._beads = folder / output.beads_file if output.beads_file and self._carried else None
        self._rdf = folder / output.rdf_file if output.rdf_file and output.rdf_every > 0 else None
        self._others = others
        self.written_step: int | None = None

    def next_step(self, step: int) -> int | None:
        """Return the next multiple of ``data_dump_frequency``."""
        return every(step, self._every)

    def report(self, simulation: Simulation) -> None:
        """Write the files."""
        for other in self._others:
            sync = getattr(other, "sync", None)
            if sync is not None:
                sync()
        if self._configuration is not None:
            with atomic_file(self._configuration) as file:
                write_config_to(file, configuration_of(simulation))
        if self._beads is not None:
            arrays = simulation.bead_arrays()
            write_beads(self._beads, simulation.scene.title, self._carried, [arrays[name] for name in self._carried])
        if self._checkpoint is not None:
            simulation.save(self._checkpoint)
        if self._rdf is not None:
            write_distances(simulation, self._rdf)
        self.written_step = simulation.step
