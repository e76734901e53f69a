"""Scenes whose beads carry heat, and what the core knows of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from pydlpoly import Scene, Simulation
from pydlpoly.formats.records import FloatArray

from .scene_builder import NVE, make_scene

NO_FORCES = ("A A dpd 0.0 1.0",)
STEP = "timestep"


def heat(*lines: str) -> str:
    """The text of the block."""
    return "\n".join(["extension heat", *lines, "end extension"])


def temperatures(simulation: Simulation) -> FloatArray:
    """(N,) internal temperatures, reduced units."""
    return np.asarray(simulation._engine.system.bead_temperatures)


def set_temperatures(simulation: Simulation, values: FloatArray) -> None:
    """Give the beads internal temperatures, reduced units."""
    simulation._engine.system.bead_temperatures = list(values)
    simulation._observation = None
    simulation._engine.initialise()


def resting_pairs(count: int, distance: float, block: str, timestep: float, **changes: Any) -> Scene:
    """``count`` pairs of an A and a B that rest at a distance, far from all other pairs."""
    side = int(np.ceil(count ** (1 / 3)))
    places = 4.0 * (np.stack(np.meshgrid(*[np.arange(side)] * 3), axis=-1).reshape(-1, 3)[:count] + 0.25 - side / 2)
    positions = np.concatenate([places, places + np.array([distance, 0.0, 0.0])])
    laws = ("A A dpd 0.0 1.0", "A B dpd 0.0 1.0", "B B dpd 0.0 1.0")
    control = {**NVE, STEP: f"{timestep} internal_t"}
    return make_scene(
        {"A": count, "B": count},
        laws,
        cell=4.0 * side,
        positions=positions,
        velocities=np.zeros((2 * count, 3)),
        control=control,
        extensions=block,
        **changes,
    )


def fluid(block: str, *, order: str = "ou", beads: int = 375, cell: float = 5.0, timestep: float = 0.01,
          control: dict[str, str | None] | None = None, laws: tuple[str, ...] = ("A A dpd 25.0 1.0 4.5",),
          **changes: Any) -> Scene:  # fmt: skip
    """DPD water in a small cell whose beads carry heat."""
    settings: dict[str, str | None] = {"ensemble_dpd_order": order, STEP: f"{timestep} internal_t"}
    if order == "nve":
        settings |= NVE
    return make_scene({"A": beads}, laws, cell=cell, control={**settings, **(control or {})}, extensions=block,
                      **changes)  # fmt: skip
