"""The reporter that writes a run's trajectory in formats of other programs, in the same steps as HISTORY."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from pydlpoly.background import BackgroundWriter
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.records import FloatArray
from pydlpoly.reporters.configuration import bead_names
from pydlpoly.reporters.schedule import every
from pydlpoly.scene.model import Scene
from pydlpoly.simulation import Simulation
from pydlpoly.trajectories import FORMATS, open_writer
from pydlpoly.trajectories.base import LINKS, Links, Topology, named_links


class FormatsReporter:
    """Writes frames in each of the formats of ``OutputPlan.trajectory_formats`` while the simulation goes on.

    Frames hold what ``traj_key`` asks for, images, and the arrays of ``Simulation.bead_arrays``. See
    ``BackgroundWriter`` for when errors are raised.

    Args:
        simulation: the run.
        folder: where the files are, named after ``OutputPlan.trajectory_stem``.
        append: the run continues; frames of later steps than the present one are dropped first.

    Raises:
        InputError: a format cannot hold this run's frames, a package is missing, or a file is another run's.
        RunError: a file cannot be opened.
    """

    def __init__(self, simulation: Simulation, folder: Path, *, append: bool = False) -> None:
        scene = simulation.scene
        output = scene.output
        self._start, self._every = output.trajectory_start, output.trajectory_every
        self._level = output.trajectory_level
        self._names = tuple(bead_names(scene))
        self._indices = np.arange(1, len(self._names) + 1)
        self._unknown = np.full(len(self._names), np.nan)
        like, topology = self.frame(simulation), topology_of(scene)
        with ExitStack() as opened:
            self._writers: list[BackgroundWriter] = []
            for name in output.trajectory_formats:
                path = folder / FORMATS[name].files(output.trajectory_stem)[0]
                keep_until = simulation.step if append else None
                writer = open_writer(name, path, like, topology, append=append, keep_until=keep_until)
                self._writers.append(BackgroundWriter(writer))
                opened.callback(self._writers[-1].close)
                due = self.next_step(simulation.step)
                if append and due is not None:
                    writer.accepts(due)
            opened.pop_all()
        if not append and self._start == 0:
            self.report(simulation)

    def next_step(self, step: int) -> int | None:
        """Return the next step of the form start + k·interval."""
        return every(step, self._every, self._start)

    def report(self, simulation: Simulation) -> None:
        """Have one frame written in every format."""
        frame = self.frame(simulation)
        for writer in self._writers:
            writer.write(frame)

    def frame(self, simulation: Simulation) -> Frame:
        """Return the present state as a frame of the level that CONTROL asks for."""
        scene, state = simulation.scene, simulation.state
        return Frame(
            self._names,
            self._indices,
            scene.beads.mass,
            scene.beads.charge,
            self._unknown,  # displacements: no format but HISTORY has room for them
            state.positions,
            state.velocities if self._level >= 1 else None,
            state.forces if self._level >= 2 else None,
            step=state.step,
            time=state.time,
            timestep=scene.dynamics.timestep,
            level=self._level,
            imcon=scene.imcon,
            cell=state.cell,
            images=state.images.astype(np.int64),
            arrays=_arrays(simulation),
        )

    def sync(self) -> None:
        """Wait until all frames are on the disk. Raises RunError when one could not be written."""
        for writer in self._writers:
            writer.sync()

    def close(self) -> None:
        """Write what waits and close the files. Raises RunError when a frame could not be written."""
        with ExitStack() as closing:
            for writer in self._writers:
                closing.callback(writer.close)


def topology_of(scene: Scene) -> Topology:
    """Return the title, molecules and bonded groups of a scene; fixed distances count as bonds."""
    groups: dict[str, list[FloatArray]] = {kind: [] for kind in LINKS}
    for term in scene.bonded.terms if scene.bonded is not None else ():
        if term.kind in groups:
            groups[term.kind].append(np.asarray(term.beads))
    if scene.constraints is not None:
        groups["bond"].append(np.asarray(scene.constraints.beads))
    species = (np.array(scene.species, dtype=object), scene.beads.species)
    links: Mapping[str, Links] = {
        kind: named_links(np.concatenate(beads), species) for kind, beads in groups.items() if beads
    }
    return Topology(scene.title, scene.units.reduced, np.asarray(scene.beads.molecule, dtype=np.int64), links)


def _arrays(simulation: Simulation) -> dict[str, FloatArray]:
    """Numbers of each bead beyond positions and velocities, where the scene has some."""
    arrays = getattr(simulation, "bead_arrays", None)
    return {} if arrays is None else {name: np.asarray(values) for name, values in arrays().items()}
