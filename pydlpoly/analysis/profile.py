"""Profiles along a cell vector and maps over two, of a HISTORY file or of arrays: densities, flow, temperature."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from pydlpoly.analysis.frames import Analysis, masses_of, periodic_axes, velocities_of
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.binned import AXES, BinnedMeans, Sample
from pydlpoly.errors import InputError
from pydlpoly.formats.binned_table import BinnedTable
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray
from pydlpoly.units import BOLTZMANN

Axis = Literal["x", "y", "z"]
_PLAIN = ("number_density", "mass_density")
_MOVING = ("velocity_x", "velocity_y", "velocity_z", "kinetic_temperature")
_UNITS = {
    "number_density": "1/Å³",
    "mass_density": "Da/Å³",
    "kinetic_temperature": "K",
    **dict.fromkeys(_MOVING[:3], "Å/ps"),
}


@dataclass(frozen=True, eq=False)
class BinnedProfiles:
    """Averages in bins; ``table`` holds them, ``profiles["velocity_x"]`` is one of them, shaped as the bins."""

    table: BinnedTable

    def __getitem__(self, quantity: str) -> FloatArray:
        """Return the averages of a quantity. Raises KeyError when it was not collected."""
        return self.table[quantity]

    def numbers(self) -> list[Number]:
        """Return each quantity's lowest and highest average."""
        return numbers_of(self.table)

    def curves(self) -> list[Curve]:
        """Return profiles along one axis; a map has none."""
        return curves_of(self.table)


class Profile(Analysis[BinnedProfiles]):
    """Averages in bins along one cell vector, or over two.

    Args:
        axes: one or two of "x", "y", "z": the first, second or third cell vector. "xy" is a map.
        bins: how many along each; one number counts for both.
        quantities: "number_density", "mass_density", "velocity_x", "velocity_y", "velocity_z" or "kinetic_temperature";
            by default all that the first frame has.
        without: quantities to leave out.
        reduced: temperatures are reduced, with k_B = 1.

    Raises:
        InputError: axes or bins are none.
    """

    def __init__(
        self,
        axes: Sequence[Axis] | str = "z",
        *,
        bins: int | Sequence[int] = 100,
        quantities: Sequence[str] = (),
        without: Sequence[str] = (),
        reduced: bool = False,
    ) -> None:
        self._axes, self._bins = checked_axes(axes), checked_bins(bins, len(axes))
        self._asked, self._without = tuple(quantities), tuple(without)
        self._boltzmann = 1.0 if reduced else BOLTZMANN
        self._means: BinnedMeans | None = None

    def add(self, frame: Frame) -> None:
        """Take one frame."""
        if self._means is None:
            moving = () if frame.velocities is None else _MOVING
            chosen = tuple(name for name in self._asked or (*_PLAIN, *moving) if name not in self._without)
            for name in chosen:
                if name not in (*_PLAIN, *_MOVING):
                    known = ", ".join((*_PLAIN, *_MOVING))
                    raise InputError(f"frames do not hold this; expected some of {known}", word=name)
            self._means = BinnedMeans(
                self._axes, self._bins, chosen, boltzmann=self._boltzmann, errors=len(self._axes) == 1
            )
        needs_velocities = not set(self._means.quantities) <= set(_PLAIN)
        velocities = velocities_of(frame) if needs_velocities else None
        self._means.add(Sample(frame.positions, frame.cell, periodic_axes(frame), masses_of(frame), velocities))

    def result(self) -> BinnedProfiles:
        """Return the averages so far. Raises InputError without frames."""
        if self._means is None:
            raise InputError("there are no frames to analyse")
        length = {AXES[axis]: "Å" for axis in self._axes}
        return BinnedProfiles(self._means.table(units={**length, **_UNITS}))


def profile_of_arrays(
    positions: ArrayLike,
    cell: ArrayLike,
    *,
    axes: Sequence[Axis] | str = "z",
    bins: int | Sequence[int] = 100,
    periodic: tuple[bool, bool, bool] = (True, True, True),
    masses: ArrayLike | None = None,
    velocities: ArrayLike | None = None,
    values: Mapping[str, ArrayLike] | None = None,
    boltzmann: float = 1.0,
) -> BinnedTable:
    """Return averages in bins of arrays.

    Args:
        positions: (N, 3) or (frames, N, 3).
        cell: (3, 3) vectors by row around the origin, three edges, or one edge.
        axes, bins: as for ``Profile``.
        periodic: along which cell vectors; beads outside the cell along the others are counted apart.
        masses: (N,), 1 by default.
        velocities: shaped as the positions; without them there are no velocities and kinetic temperatures.
        values: (N,) or (frames, N) each, by name: what else is averaged over the beads of a bin.
        boltzmann: k_B in the units of mass times velocity squared.

    Raises:
        InputError: the shapes do not belong together.
    """
    places = np.asarray(positions, dtype=np.float64)
    places = places[None] if places.ndim == 2 else places
    frames, beads = places.shape[:2] if places.ndim == 3 and places.shape[2] == 3 else (0, 0)
    box = np.asarray(cell, dtype=np.float64)
    box = box if box.ndim == 2 else np.diag(np.broadcast_to(box, 3))
    if frames == 0 or box.shape != (3, 3):
        raise InputError(f"expected positions (N, 3) or (frames, N, 3) and a cell (3, 3), not {np.shape(positions)}")
    moving = None if velocities is None else _shaped("velocities", velocities, places.shape)
    carried = {name: _shaped(name, array, (frames, beads)) for name, array in (values or {}).items()}
    weights = None if masses is None else _shaped("masses", masses, (beads,))
    names = (*_PLAIN, *(_MOVING if moving is not None else ()), *carried)
    numbers = checked_axes(axes)
    means = BinnedMeans(numbers, checked_bins(bins, len(numbers)), names, boltzmann=boltzmann, errors=len(numbers) == 1)
    for k in range(frames):
        here = {name: array[k] for name, array in carried.items()}
        speed = None if moving is None else moving[k]
        means.add(Sample(places[k], box, periodic, weights, speed, values=here))
    return means.table()


def checked_axes(axes: Sequence[str]) -> tuple[int, ...]:
    """Return the numbers of one or two different axes. Raises InputError for anything else."""
    if len(axes) not in (1, 2) or len(set(axes)) < len(axes) or not set(axes) <= set(AXES):
        raise InputError(f"expected one or two different axes of x, y and z, not {''.join(axes)}")
    return tuple(AXES.index(axis) for axis in axes)


def checked_bins(bins: int | Sequence[int], count: int) -> tuple[int, ...]:
    """Return how many bins each axis has. Raises InputError when there are none, or not as many numbers as axes."""
    numbers = (bins,) * count if isinstance(bins, int) else tuple(bins)
    if len(numbers) != count or min(numbers) < 1:
        raise InputError(f"expected a number of bins for each of {count} axes, not {bins}")
    return numbers


def _shaped(what: str, array: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    values = np.asarray(array, dtype=np.float64)
    if values.size != int(np.prod(shape)):
        raise InputError(f"{what} must be of shape {shape}, not {values.shape}")
    return values.reshape(shape)


def numbers_of(table: BinnedTable) -> list[Number]:
    """Return each quantity's lowest and highest average, with their errors where there are any."""
    found = []
    for name, values in table.values.items():
        if not np.isfinite(values).any():
            continue
        for what, place in (("lowest", np.nanargmin(values)), ("highest", np.nanargmax(values))):
            error = table.errors[name].ravel()[place] if name in table.errors else np.nan
            found.append(
                Number(f"{name}: {what}", float(values.ravel()[place]), float(error), table.units.get(name, ""))
            )
    return found


def curves_of(table: BinnedTable) -> list[Curve]:
    """Return the profiles of a table along one axis as curves; a map has none."""
    if len(table.axes) > 1:
        return []
    axis, place = table.axes[0], table.centres[0]
    nothing = np.full(len(place), np.nan)
    return [
        Curve(name, name, labelled(table, axis), labelled(table, name), place, values, table.errors.get(name, nothing))
        for name, values in table.values.items()
    ]


def labelled(table: BinnedTable, name: str) -> str:
    """Return a quantity's or an axis's name for a picture, with its unit in brackets."""
    unit = table.units.get(name, "").replace("ang", "Å").replace("^3", "³")
    return name.replace("_", " ") + (f" ({unit})" if unit else "")
