"""The state of beads in LAMMPS: a copy in the process in front, fetched when it is looked at."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pydlpoly.engines.lammps_translate.carried import Carried
from pydlpoly.formats.records import FloatArray


class Source(Protocol):
    """Where beads come from."""

    def fetch(self) -> dict[str, NDArray[Any]]:
        """Return the beads by name of the array, in the order of their ids."""


class LammpsState:
    """The state of the beads in LAMMPS, fetched when it is looked at; see ``Engine`` for the attributes.

    Args:
        engine: the engine, which fetches beads.
        native: the same scene in the compiled core, whose pair distances it lends.
        carried: what the beads carry.
    """

    def __init__(self, engine: Source, native: Any, carried: Carried) -> None:
        self._engine, self._native = engine, native
        self.step: int = 0
        self.time: float = 0.0
        self.cell: FloatArray = np.ascontiguousarray(native.cell)
        self.thermostat: list[float] = list(native.thermostat)
        self.distances_every = self.distances_after = 0
        self._arrays: dict[str, NDArray[Any]] = {
            "positions": np.asarray(native.positions),
            "velocities": np.asarray(native.velocities),
            "forces": np.asarray(native.forces),
            "images": np.asarray(native.images, dtype=np.int64),
        }
        self._carried = carried
        if self._carried.heat:
            self._arrays["temperature"] = np.asarray(native.bead_temperatures)
        if self._carried.dissolved:
            self._arrays["concentrations"] = np.array(native.concentrations)
        self._clock = (0, 0.0)  # step and time of the arrays
        self.fresh = True

    def __getattr__(self, name: str) -> Any:
        """What is not here is as in the native core."""
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._native, name)

    @property
    def positions(self) -> FloatArray:
        """(N, 3) a copy of the positions, wrapped into the cell."""
        return self._fetched("positions")

    @positions.setter
    def positions(self, value: FloatArray) -> None:
        self._set("positions", value)

    @property
    def velocities(self) -> FloatArray:
        """(N, 3) a copy of the velocities."""
        return self._fetched("velocities")

    @velocities.setter
    def velocities(self, value: FloatArray) -> None:
        self._set("velocities", value)

    @property
    def forces(self) -> FloatArray:
        """(N, 3) a copy of the total forces."""
        return self._fetched("forces")

    @forces.setter
    def forces(self, value: FloatArray) -> None:
        self._set("forces", value)

    @property
    def images(self) -> NDArray[np.int32]:
        """(N, 3) cells crossed since the start."""
        return self._fetched("images").astype(np.int32)

    @images.setter
    def images(self, value: NDArray[np.int32]) -> None:
        self._set("images", np.asarray(value, dtype=np.int64))

    @property
    def bead_temperatures(self) -> FloatArray | list[float]:
        """(N,) a copy of the internal temperatures as k_B T, empty where beads have none."""
        return self._fetched("temperature") if self._carried.heat else []

    @bead_temperatures.setter
    def bead_temperatures(self, value: FloatArray | list[float]) -> None:
        self._set("temperature", np.asarray(value))

    @property
    def concentrations(self) -> FloatArray:
        """(N, species) a copy of the amounts of dissolved species."""
        return self._fetched("concentrations") if self._carried.dissolved else np.asarray(self._native.concentrations)

    @concentrations.setter
    def concentrations(self, value: FloatArray) -> None:
        self._set("concentrations", value)

    def local_densities(self) -> FloatArray:
        """Return a copy of the local densities (N,). Raises ValueError without ``mdpd``."""
        return self._fetched("density") if self._carried.density else np.asarray(self._native.local_densities())

    def replace_carried(self, temperatures: FloatArray | None, concentrations: FloatArray | None) -> None:
        """Take over what LAMMPS's beads were given between two steps."""
        for name, values in (("temperature", temperatures), ("concentrations", concentrations)):
            if values is not None:
                self._set(name, values)

    @property
    def volume(self) -> float:
        """Of the cell."""
        return abs(float(np.linalg.det(self.cell)))

    def wrap(self) -> None:
        """Bring positions back into the cell, counting the cells they cross."""
        positions = self._fetched("positions")
        shifts = np.floor(positions @ np.linalg.inv(self.cell) + 0.5)
        self._arrays["positions"] = positions - shifts @ self.cell
        self._arrays["images"] = self._arrays["images"] + shifts.astype(np.int64)

    def store(self, beads: dict[str, NDArray[Any]]) -> None:
        """Take what LAMMPS says of the present step."""
        self._arrays, self.fresh, self._clock = beads, True, (self.step, self.time)
        self.wrap()

    def advance(self, steps: int, timestep: float) -> None:
        """Count steps that LAMMPS has taken."""
        self.step += steps
        self.time += steps * timestep
        self.fresh = False

    def fall_back(self) -> None:
        """Go back to the last step whose beads are here; LAMMPS is gone."""
        self.step, self.time = self._clock
        self.fresh = True

    # Pair distances

    def enable_distances(self, reach: float, bins: int, every: int, after: int = 0) -> None:
        """Sample pair distances in steps divisible by ``every`` and later than ``after``."""
        self._native.enable_distances(reach, bins, every, after)
        self.distances_every, self.distances_after = every, after

    def until_sample(self) -> int:
        """Return how many steps there are to the next sample; a large number without samples."""
        if self.distances_every <= 0:
            return 2**31
        return self.distances_every - self.step % self.distances_every

    def sample_if_due(self) -> None:
        """Count the distances of this step if it is to be sampled."""
        every = self.distances_every
        if every > 0 and self.step > self.distances_after and self.step % every == 0:
            self._native.positions = self.positions
            self._native.sample_distances()

    def distance_counts(self) -> NDArray[np.int64]:
        """As the core's."""
        return np.asarray(self._native.distance_counts())

    def restore_distances(self, counts: list[int], samples: int, volumes: float) -> None:
        """As the core's."""
        self._native.restore_distances(counts, samples, volumes)

    @property
    def distance_samples(self) -> int:
        """Number of samples."""
        return int(self._native.distance_samples)

    @property
    def distance_volumes(self) -> float:
        """Sum of the cell's volumes over the samples."""
        return float(self._native.distance_volumes)

    def _fetched(self, name: str) -> NDArray[Any]:
        if not self.fresh:
            self.store(self._engine.fetch())
        return self._arrays[name].copy()

    def _set(self, name: str, value: NDArray[Any]) -> None:
        self._fetched(name)  # the others stay as they are now
        self._arrays[name] = np.array(value, dtype=np.int64 if name == "images" else np.float64)
