"""What a simulation's beads do at one step, and the checks of what a simulation is told they do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.beads_state import why_not
from pydlpoly.scene.model import Scene

_MOST_CELLS = 2.0**30  # that a bead may be away from the cell


@dataclass(frozen=True, eq=False)
class State:
    """A copy of what a simulation's beads do now; changing it changes nothing in the simulation.

    Attributes:
        positions: (N, 3) wrapped into the cell, Å.
        velocities: (N, 3), Å/ps.
        forces: (N, 3) total force including drag and noise, Da Å/ps².
        images: (N, 3) cells crossed since the start; unwrapped = positions + images @ cell.
        step: number of steps taken since the scene's start; time: ps.
        temperature: (N,) internal temperatures, K (reduced with ``units dpd``); None where beads carry no heat.
        concentrations: (N, species) of dissolved species; None where there are none.
        density: (N,) local densities at the last evaluation of the forces; None where no pair law depends on them.
    """

    positions: FloatArray
    velocities: FloatArray
    forces: FloatArray
    images: NDArray[np.int32]
    cell: FloatArray
    step: int
    time: float
    temperature: FloatArray | None = None
    concentrations: FloatArray | None = None
    density: FloatArray | None = None

    @property
    def unwrapped(self) -> FloatArray:
        """(N, 3) positions followed across cell boundaries since the start."""
        return self.positions + self.images @ self.cell


def check_motion(scene: Scene, positions: FloatArray | None, velocities: FloatArray | None) -> None:
    """Check positions and velocities that beads are to have; None needs no check.

    Raises:
        ValueError: an array has another shape than (N, 3), or is not finite, or a bead is too far away.
    """
    shape = (scene.bead_count, 3)
    for name, array in (("positions", positions), ("velocities", velocities)):
        if array is not None and (np.shape(array) != shape or not np.isfinite(array).all()):
            raise ValueError(f"{name} must be finite and of shape {shape}")
    if positions is None:
        return
    cells = np.abs(np.asarray(positions) @ np.linalg.inv(scene.cell)).max(axis=1)
    if cells.size and not cells.max() < _MOST_CELLS:
        raise ValueError(
            f"the position of bead {int(np.argmax(cells)) + 1} is {cells.max():.4g} cells away; at most "
            f"{_MOST_CELLS:.4g} can be counted"
        )


def check_carried(scene: Scene, temperature: FloatArray | None, concentrations: FloatArray | None) -> None:
    """Check what beads are to carry; None needs no check.

    Raises:
        ValueError: an array has another shape or impossible numbers, or the beads do not carry this.
    """
    beads = scene.beads
    for what, array, carried in (
        ("temperature", temperature, beads.temperature),
        ("concentrations", concentrations, beads.concentrations),
    ):
        if array is None:
            continue
        if carried is None:
            raise ValueError(f"beads of this scene carry no {what}")
        if np.shape(array) != carried.shape:
            raise ValueError(f"{what} must be of shape {carried.shape}, not {np.shape(array)}")
        columns = np.asarray(array, dtype=np.float64).reshape(len(beads), -1)
        for column in columns.T:
            wrong = why_not(what, column)
            if wrong is not None:
                raise ValueError(f"{what} of bead {wrong[0] + 1} is {column[wrong[0]]:g}; {wrong[1]}")
