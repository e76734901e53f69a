"""Mean-square displacements and the diffusion coefficients of their slopes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pydlpoly.analysis.frames import Analysis, beads_of, periodic_axes, time_of
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.analysis.windows import Spool, Windows, correlate, errors_of, lags_of, spacing_of, times_of
from pydlpoly.errors import InputError
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class SquareDisplacements:
    """Mean-square displacements by species.

    Attributes:
        species: names.
        times: (lags,) in ps, from 0.
        msd: (species, lags) in Å², and its standard error ``error``.
        diffusion: (species,) a sixth of the slope in Å²/ps, and its standard error ``diffusion_error``.
        fit: times between which the straight line was fitted, ps.
    """

    species: tuple[str, ...]
    times: FloatArray
    msd: FloatArray
    error: FloatArray
    diffusion: FloatArray
    diffusion_error: FloatArray
    fit: tuple[float, float]

    def numbers(self) -> list[Number]:
        """Return the diffusion coefficients."""
        rows = zip(self.species, self.diffusion.tolist(), self.diffusion_error.tolist(), strict=True)
        return [Number(f"D of {name} (MSD)", value, error, "Å²/ps") for name, value, error in rows]

    def curves(self) -> list[Curve]:
        """Return the mean-square displacements."""
        rows = zip(self.species, self.msd, self.error, strict=True)
        return [Curve("msd", name, "t (ps)", "MSD (Å²)", self.times, m, e) for name, m, e in rows]


class MeanSquareDisplacement(Analysis[SquareDisplacements]):
    """⟨|r(t0 + t) − r(t0)|²⟩ over all origins t0 and beads of a species.

    Beads are followed across cell boundaries, which they must not reach from more than half a cell away in one frame.
    Where the cell varies, steps are taken by fractions of it (as von Bülow et al., J. Chem. Phys. 153, 021101 (2020)
    advise, the steps are summed, not the places unwrapped). D = slope/6 of a straight line through the fit's range.

    Args:
        longest: largest t in ps, by default a quarter of the trajectory.
        fit: range of t for the line in ps, by default from half of the longest to the longest.
    """

    def __init__(self, *, longest: float | None = None, fit: tuple[float, float] | None = None) -> None:
        self._longest, self._fit = longest, fit
        self._spool, self._times = Spool(), list[float]()
        self._names: tuple[str, ...] = ()
        self._last: FloatArray = np.zeros((0, 3))
        self._place: FloatArray = np.zeros((0, 3))
        self._first: Frame | None = None

    def add(self, frame: Frame) -> None:
        """Take one frame."""
        axes = np.array(periodic_axes(frame))
        inverse = np.linalg.inv(frame.cell) if axes.any() else np.eye(3)
        cell = frame.cell if axes.any() else np.eye(3)
        inside = frame.positions @ inverse
        if self._first is None:
            self._first, self._place = frame, np.zeros_like(inside)
        elif len(inside) != len(self._last):
            raise InputError(f"the frames differ: {len(inside)} beads after {len(self._last)}")
        else:
            step = inside - self._last
            step[:, axes] -= np.round(step[:, axes])
            self._place = self._place + step @ cell
        self._last = inside
        self._spool.append(self._place)
        self._times.append(time_of(frame))

    def result(self) -> SquareDisplacements:
        """Return displacements, diffusion coefficients and errors."""
        spacing = spacing_of(self._times)
        lags = lags_of(len(self._times), self._longest, spacing)
        times = times_of(spacing, lags)
        fit = self._fit or (0.5 * times[-1] if lags > 1 else 0.0, times[-1])
        weights = _slope_weights(times, fit)
        assert self._first is not None
        species = tuple(dict.fromkeys(self._first.names))
        found = [self._windows(name, lags) for name in species]
        return SquareDisplacements(
            species,
            times,
            np.array([one.value for one in found]),
            np.array([errors_of(one.deviations) for one in found]),
            np.array([one.value @ weights / 6.0 for one in found]),
            np.array([float(errors_of(one.deviations @ weights[:, None])[0]) / 6.0 for one in found]),
            (float(fit[0]), float(fit[1])),
        )

    def _windows(self, species: str, lags: int) -> Windows:
        assert self._first is not None
        return correlate(self._spool, beads_of(self._first, species), lags, squared_differences=True)


def _slope_weights(times: FloatArray, fit: tuple[float, float]) -> FloatArray:
    """(lags,) weights of which the sum with a function is the slope of the line through it in the range."""
    slack = 1e-6 * times[1]
    chosen = (times >= fit[0] - slack) & (times <= fit[1] + slack)
    if chosen.sum() < 2:
        raise InputError(f"the fit from {fit[0]:g} to {fit[1]:g} holds fewer than two of the times up to {times[-1]:g}")
    apart = np.where(chosen, times - times[chosen].mean(), 0.0)
    return np.asarray(apart / np.sum(apart**2))
