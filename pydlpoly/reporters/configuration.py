"""The present state as the record that REVCON is written from."""

from __future__ import annotations

import numpy as np

from pydlpoly.formats.records import Configuration
from pydlpoly.scene.model import Scene
from pydlpoly.simulation import Simulation


def bead_names(scene: Scene) -> list[str]:
    """Return the species name of every bead."""
    names: list[str] = np.array(scene.species, dtype=object)[scene.beads.species].tolist()
    return names


def configuration_of(simulation: Simulation) -> Configuration:
    """Return the present state as the record that REVCON is written from."""
    scene, state = simulation.scene, simulation.state
    return Configuration(
        names=tuple(bead_names(scene)),
        positions=state.positions,
        title=scene.title,
        imcon=scene.imcon,
        cell=state.cell,
        velocities=state.velocities,
        forces=state.forces,
        step=state.step,
        timestep=scene.dynamics.timestep,
        time=state.time,
    )
