"""What a simulation needs of an engine: a state that can be read and set, steps, and what was observed in the last."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pydlpoly.engines.totals import Totals
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Scene

ENGINES = ("native", "lammps")
"""The engines by name."""


@dataclass(frozen=True)
class EngineOptions:
    """What an engine other than the native one is told.

    Attributes:
        ranks: number of processes; None for those of the MPI job around this process, else 1.
        accelerator: LAMMPS's own switches for accelerators, such as ``-sf gpu -pk gpu 1``.
    """

    ranks: int | None = None
    accelerator: str = ""


class Engine(Protocol):
    """One simulation in motion.

    ``system`` holds the state. It has the attributes of the compiled core's ``System`` that simulations use: ``step``,
    ``time``, ``cell``, ``positions``, ``velocities``, ``forces``, ``images``, ``thermostat``, ``volume``,
    ``distance_samples`` and ``distance_volumes``; ``wrap``, ``enable_distances``, ``distance_counts`` and
    ``restore_distances``. What is set takes effect with ``initialise``.
    """

    @property
    def system(self) -> Any:
        """The state."""

    def start(self, scene: Scene) -> None:
        """Give the beads the velocities that the scene's start asks for, and compute the first forces."""

    def meet_constraints(self) -> None:
        """Bring positions to the lengths of constraints, and take out of velocities what would change them."""

    def initialise(self) -> None:
        """Compute and observe the forces of the present state."""

    def run(self, steps: int) -> None:
        """Take steps and observe the last one. Raises RunError when the run cannot go on."""

    def totals(self) -> Totals:
        """Return what was observed at the last observed step."""

    def configurational(self) -> tuple[float, float]:
        """Return Σ|∇U|² and Σ∇²U over the mobile beads, internal units."""

    def layer_sums(self, axis: int, layers: int) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.int64]]:
        """Return kinetic, pair and bonded sums (layers, 6) and beads (layers, species)."""

    def distance_counts(self, bins: int, species: int) -> NDArray[np.int64]:
        """Return pair distance counts, (species, species, bins), pairs counted once under a ≤ b."""

    def plan(self) -> list[str]:
        """Return in words how steps are computed."""

    def notes(self) -> list[str]:
        """Return what a user should know about results of this engine."""

    # Of scenes whose beads carry heat or dissolved species, or have local densities.

    @property
    def transport(self) -> Any:
        """The core's transport, whose ``tally`` is what became of dissolved species; None without them."""

    @property
    def heat_account(self) -> tuple[float, float]:
        """What sources and held beads gave since the start, and work that beads were charged for ahead (energy)."""

    @heat_account.setter
    def heat_account(self, account: tuple[float, float]) -> None: ...

    def exchange(self, temperatures: FloatArray | None, concentrations: FloatArray | None) -> None:
        """Replace what beads carry, as k_B T (N,) and (N, species), without a new evaluation of the forces."""

    def local_densities(self) -> FloatArray:
        """Return the local density of every bead, (N,)."""
