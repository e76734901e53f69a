"""Averages of what beads do and carry in bins over a cell, over time: profiles along one axis and maps over two.

Bins are fractions of the cell along its vectors; where the cell varies they vary with it. An average over beads in a
bin is a sum over all samples divided by the sum of its weights: a sample in which the bin held many beads counts more.
With p = Σ m v and Q = Σ m v² over the mobile beads of a bin, the velocity is p/Σ m and the kinetic
temperature (Q − p²/Σ m)/(3 k_B N), of velocities relative to that mean flow.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.formats.binned_table import BinnedTable
from pydlpoly.formats.blocks import BlockSums, standard_errors
from pydlpoly.formats.records import FloatArray, IntArray

AXES = ("x", "y", "z")
_MOMENTA = {f"velocity_{axis}": f"momentum_{axis}" for axis in AXES}
_KINETIC = "kinetic_temperature"
_BY_SPECIES = "number_density_"
_COUNT, _MOBILE, _MASS, _MOBILE_MASS, _SQUARES = "count", "mobile", "mass", "mobile_mass", "squares"


@dataclass(frozen=True, eq=False)
class Sample:
    """The beads at one time.

    Attributes:
        positions: (N, 3); cell: (3, 3) by row, around the origin; periodic: along which cell vectors.
        masses: (N,); velocities: (N, 3), where a quantity needs them.
        species: (N,) numbers; mobile: (N,), None when all can move.
        values: (N,) each, by the names of quantities that are averages over beads.
    """

    positions: FloatArray
    cell: FloatArray
    periodic: tuple[bool, bool, bool] = (True, True, True)
    masses: FloatArray | None = None
    velocities: FloatArray | None = None
    species: NDArray[np.integer[Any]] | None = None
    mobile: NDArray[np.bool_] | None = None
    values: Mapping[str, FloatArray] = field(default_factory=dict)


def bin_numbers(sample: Sample, axes: Sequence[int], bins: Sequence[int]) -> IntArray:
    """Return the bin of every bead, (N,), the last axis fastest; −1 for beads outside the cell along an open axis."""
    numbers = np.zeros(len(sample.positions), dtype=np.int64)
    outside = np.zeros(len(sample.positions), dtype=np.bool_)
    places = np.asarray(sample.positions) @ np.linalg.inv(sample.cell)
    for axis, count in zip(axes, bins, strict=True):
        place = places[:, axis] + 0.5
        if sample.periodic[axis]:
            place = place - np.floor(place)
        else:
            outside |= (place < 0.0) | (place > 1.0)
        # Rounding may have put a place just below a face onto it.
        numbers = numbers * count + np.clip((place * count).astype(np.int64), 0, count - 1)
    numbers[outside] = -1
    return numbers


def _mobile(sample: Sample) -> FloatArray:
    return np.ones(len(sample.positions)) if sample.mobile is None else sample.mobile.astype(np.float64)


def _masses(sample: Sample) -> FloatArray:
    return np.ones(len(sample.positions)) if sample.masses is None else sample.masses


def _velocities(sample: Sample) -> FloatArray:
    if sample.velocities is None:
        raise ValueError("velocities are needed for the velocity and the kinetic temperature in bins")
    return sample.velocities


_WEIGHTS: dict[str, Callable[[Sample], FloatArray]] = {
    _COUNT: lambda sample: np.ones(len(sample.positions)),
    _MASS: _masses,
    _MOBILE: _mobile,
    _MOBILE_MASS: lambda sample: _masses(sample) * _mobile(sample),
    _SQUARES: lambda sample: _masses(sample) * _mobile(sample) * np.sum(_velocities(sample) ** 2, axis=1),
    **{
        name: lambda sample, k=k: _masses(sample) * _mobile(sample) * _velocities(sample)[:, k]  # type: ignore[misc]
        for k, name in enumerate(_MOMENTA.values())
    },
}


class BinnedMeans:
    """Sums over samples, and the averages that follow from them.

    Args:
        axes: one or two of 0, 1, 2: the cell vectors that the bins divide.
        bins: how many bins along each.
        quantities: "number_density", "number_density_<species>", "mass_density", "velocity_x" …, "kinetic_temperature",
            or names of ``Sample.values``.
        species: names of species, for ``number_density_``.
        boltzmann: k_B in the units of mass times velocity squared.
        errors: keep averages over blocks of samples, from which errors follow; 32 times the memory.

    Raises:
        ValueError: axes and bins do not belong together.
    """

    def __init__(
        self,
        axes: Sequence[int],
        bins: Sequence[int],
        quantities: Sequence[str],
        *,
        species: Sequence[str] = (),
        boltzmann: float = 1.0,
        errors: bool = True,
    ) -> None:
        """Start without samples; see the class."""
        if len(axes) not in (1, 2) or len(axes) != len(bins) or len(set(axes)) < len(axes) or min(bins) < 1:
            raise ValueError("expected one or two different axes, and at least one bin for each")
        self.axes, self.bins, self.quantities = tuple(axes), tuple(bins), tuple(quantities)
        self._species, self._boltzmann = tuple(species), boltzmann
        self._columns = tuple(dict.fromkeys(name for quantity in quantities for name in self._needs(quantity)))
        self._total = int(np.prod(bins))
        # After the bins: the cell's volume, its widths along the axes, and beads outside the bins.
        size = len(self._columns) * self._total + 2 + len(self.axes)
        self._sums: BlockSums | RunningSums = BlockSums(size) if errors else RunningSums(size)

    def add(self, sample: Sample) -> None:
        """Take a sample. Raises ValueError when it lacks what a quantity needs."""
        numbers = bin_numbers(sample, self.axes, self.bins)
        inside = numbers >= 0
        whole = bool(inside.all())
        kept = numbers if whole else numbers[inside]
        rows = []
        for name in self._columns:
            weights = self._weights(name, sample)
            rows.append(np.bincount(kept, weights if whole else weights[inside], minlength=self._total))
        cell = np.asarray(sample.cell)
        widths = 1.0 / np.linalg.norm(np.linalg.inv(cell), axis=0)[list(self.axes)]
        rest = [abs(float(np.linalg.det(cell))), *widths.tolist(), float(len(numbers) - len(kept))]
        self._sums.add(np.concatenate([*rows, rest]))

    @property
    def samples(self) -> int:
        """Number of samples so far."""
        return self._sums.taken

    def table(self, title: str = "", units: Mapping[str, str] | None = None) -> BinnedTable:
        """Return the averages; errors only when they were asked for, not a number with fewer than four samples."""
        mean = self._sums.mean()
        shape = self.bins
        means = {name: column.reshape(shape) for name, column in self._by_column(mean).items()}
        values = {name: self._value(name, means) for name in self.quantities}
        errors = {}
        if isinstance(self._sums, BlockSums):
            blocks = self._by_column(self._sums.means())
            errors = {name: self._error(name, means, blocks).reshape(shape) for name in self.quantities}
        widths = mean[-1 - len(self.axes) : -1]
        centres = tuple(
            ((np.arange(count) + 0.5) / count - 0.5) * width for count, width in zip(self.bins, widths, strict=True)
        )
        axes = tuple(AXES[axis] for axis in self.axes)
        return BinnedTable(title, axes, centres, self.samples, float(mean[-1]), values, errors, dict(units or {}))

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the sums as arrays, for a checkpoint."""
        return {**self._sums.state(), "shape": self._shape(), "quantities": np.array(self.quantities, dtype=np.str_)}

    def restore(self, stored: Mapping[str, NDArray[Any]]) -> None:
        """Go on from a state. Raises ValueError or KeyError when it is of other bins or quantities."""
        same = np.array_equal(stored["shape"], self._shape())
        if not same or tuple(stored["quantities"].tolist()) != self.quantities:
            raise ValueError("it has other axes, bins or quantities")
        self._sums.restore(stored)

    def _shape(self) -> NDArray[np.int64]:
        return np.array([*self.axes, *self.bins], dtype=np.int64)

    def _needs(self, quantity: str) -> tuple[str, ...]:
        """Names of the sums that a quantity is made of; the last is what it is divided by, if not a volume."""
        if quantity == "number_density":
            return (_COUNT,)
        if quantity.startswith(_BY_SPECIES):
            return (quantity,)
        if quantity == "mass_density":
            return (_MASS,)
        if quantity in _MOMENTA:
            return (_MOMENTA[quantity], _MOBILE_MASS)
        if quantity == _KINETIC:
            return (_SQUARES, *_MOMENTA.values(), _MOBILE_MASS, _MOBILE)
        return (quantity, _COUNT)

    def _weights(self, name: str, sample: Sample) -> FloatArray:
        if name in _WEIGHTS:
            return _WEIGHTS[name](sample)
        if name.startswith(_BY_SPECIES):
            if sample.species is None:
                raise ValueError("species are needed for their densities")
            number = self._species.index(name.removeprefix(_BY_SPECIES))
            return np.asarray(sample.species == number, dtype=np.float64)
        if name not in sample.values:
            raise ValueError(f"a sample without {name!r}, which is averaged")
        return np.asarray(sample.values[name], dtype=np.float64)

    def _by_column(self, sums: FloatArray) -> dict[str, FloatArray]:
        """Split (…, all) into (…, bins) by name, and the volume of a bin as "volume", (…, 1)."""
        count, total = len(self._columns), self._total
        parts = sums[..., : count * total].reshape(*sums.shape[:-1], count, total)
        columns = {name: parts[..., k, :] for k, name in enumerate(self._columns)}
        volume = sums[..., count * total, None] / total
        return {**columns, "volume": np.broadcast_to(volume, (*sums.shape[:-1], total))}

    def _value(self, quantity: str, sums: Mapping[str, FloatArray]) -> FloatArray:
        needs = self._needs(quantity)
        if len(needs) == 1:
            return _ratio(sums[needs[0]], sums["volume"])
        if quantity == _KINETIC:
            squares = sums[_SQUARES] - sum(_ratio(sums[p] ** 2, sums[_MOBILE_MASS]) for p in _MOMENTA.values())
            return _ratio(squares, 3.0 * self._boltzmann * sums[_MOBILE])
        return _ratio(sums[needs[0]], sums[needs[1]])

    def _error(self, quantity: str, means: Mapping[str, FloatArray], blocks: Mapping[str, FloatArray]) -> FloatArray:
        """Standard errors, (bins,), of what each block's sums deviate by to first order from the ratio of the means."""
        mean = {name: column.ravel() for name, column in means.items()}
        value, needs = self._value(quantity, mean), self._needs(quantity)
        if quantity == _KINETIC:
            flows = {p: _ratio(mean[p], mean[_MOBILE_MASS]) for p in _MOMENTA.values()}
            squares = blocks[_SQUARES] + sum(
                flow**2 * blocks[_MOBILE_MASS] - 2.0 * flow * blocks[p] for p, flow in flows.items()
            )
            weight = 3.0 * self._boltzmann * blocks[_MOBILE]
            series = _ratio(squares - value * weight, 3.0 * self._boltzmann * mean[_MOBILE])
        else:
            below = needs[1] if len(needs) > 1 else "volume"
            series = _ratio(blocks[needs[0]] - value * blocks[below], mean[below])
        return standard_errors(series)


class RunningSums:
    """Sums over samples without blocks: as ``BlockSums``, for averages without errors."""

    def __init__(self, count: int) -> None:
        """Start without samples."""
        self.taken = 0
        self._sums = np.zeros(count)

    def add(self, values: FloatArray) -> None:
        """Take one sample, (count,)."""
        self._sums += values
        self.taken += 1

    def mean(self) -> FloatArray:
        """Return the averages, (count,); zeros before the first sample."""
        average: FloatArray = self._sums / max(self.taken, 1)
        return average

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the sums as arrays by name."""
        return {"counts": np.array([self.taken], dtype=np.int64), "sums": self._sums.copy()}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on exactly where ``state`` was taken. Raises ValueError when it is of other quantities."""
        if state["sums"].shape != self._sums.shape:
            raise ValueError(f"expected {len(self._sums)} sums")
        self.taken = int(state["counts"][0])
        self._sums = np.array(state["sums"], dtype=np.float64)


def _ratio(above: FloatArray, below: FloatArray) -> FloatArray:
    """Quotients, not a number where there is nothing to divide by."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(below > 0.0, above / below, np.nan)
