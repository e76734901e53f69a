"""What runs are seen to do, and what they all have in common."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pydlpoly.formats.records import FloatArray
from pydlpoly.tradeoff.statistics import combine, mean_and_error, student

COLUMNS = ("time", "temperature", "pressure", "energy", "total", "squared_force", "curvature")
FEWEST_SAMPLES = 8  # for a judgement
SHELLS = 16  # of g(r), out to the cutoff


@dataclass
class Samples:
    """What a run was seen to do, one row a sample; ``interval`` is the simulated time between them."""

    interval: float
    rows: list[tuple[float, ...]] = field(default_factory=list)
    shells: list[FloatArray] = field(default_factory=list)
    diffusion: list[float] = field(default_factory=list)

    @property
    def time(self) -> float:
        """Simulated time that the averages are over."""
        return len(self.rows) * self.interval

    def column(self, name: str) -> FloatArray:
        """Return one quantity of every sample."""
        return np.array([row[COLUMNS.index(name)] for row in self.rows])


@dataclass
class Plan:
    """What all runs have in common.

    Attributes:
        timestep: the scene's own; ``stride``: timed steps from one sample to the next, where one more is taken.
        usual: the temperature that is expected; ``wanted``: the thermostat's, None where it need not be met.
        lag: simulated time between the positions that give the diffusion, 0 for none.
    """

    seed: int
    threads: int | None
    target: float
    timestep: float
    stride: int
    usual: float
    wanted: float | None
    lag: float
    shells: FloatArray  # (pairs of species, shells): g for one pair counted in one sample; 0 where there are no beads
    first: NDArray[np.int64]
    second: NDArray[np.int64]
    run_time: float
    boltzmann: float
    ideal_pressure: float
    thermal: float
    thermostat: bool

    def pairs_counted(self, counts: NDArray[np.int64]) -> FloatArray:
        """Return the counts of the pairs of species one after the other."""
        return np.asarray(counts[self.first, self.second], dtype=np.float64).ravel()


def settled(energies: FloatArray, parts: int = 3) -> bool:
    """Whether the last part of a series has the mean of the part before it, with 99 % confidence that it has not."""
    size = len(energies) // parts
    (a, s, n), (b, u, m) = mean_and_error(energies[-2 * size : -size]), mean_and_error(energies[-size:])
    error, freedom = combine((s, n), (u, m))
    return abs(a - b) <= float(student(freedom, 0.99)) * error
