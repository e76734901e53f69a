"""Velocity autocorrelation functions and the diffusion coefficients of their integrals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pydlpoly.analysis.frames import Analysis, beads_of, time_of, velocities_of
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.analysis.windows import Spool, correlate, errors_of, lags_of, spacing_of, times_of
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class VelocityCorrelations:
    """Velocity autocorrelation functions by species.

    Attributes:
        species: names.
        times: (lags,) in ps, from 0.
        at_origin: (species,) ⟨v·v⟩ = 3 k_B T/m in (Å/ps)².
        values: (species, lags) ⟨v(t0)·v(t0 + t)⟩/⟨v·v⟩, and its standard error ``error``.
        diffusion: (species, lags) a third of the integral up to each time in Å²/ps, and its error ``diffusion_error``.
    """

    species: tuple[str, ...]
    times: FloatArray
    at_origin: FloatArray
    values: FloatArray
    error: FloatArray
    diffusion: FloatArray
    diffusion_error: FloatArray

    def numbers(self) -> list[Number]:
        """Return the diffusion coefficients of the whole integrals."""
        rows = zip(self.species, self.diffusion[:, -1].tolist(), self.diffusion_error[:, -1].tolist(), strict=True)
        return [Number(f"D of {name} (VAF)", value, error, "Å²/ps") for name, value, error in rows]

    def curves(self) -> list[Curve]:
        """Return the normalised functions."""
        rows = zip(self.species, self.values, self.error, strict=True)
        return [Curve("vaf", name, "t (ps)", "Z(t)/Z(0)", self.times, v, e) for name, v, e in rows]


class VelocityAutocorrelation(Analysis[VelocityCorrelations]):
    """⟨v(t0)·v(t0 + t)⟩ over all origins t0 and beads of a species; D = 1/3 of the integral, by the trapezoidal rule.

    Args:
        longest: largest t in ps, by default a quarter of the trajectory.
    """

    def __init__(self, *, longest: float | None = None) -> None:
        self._longest = longest
        self._spool, self._times = Spool(), list[float]()
        self._first: Frame | None = None

    def add(self, frame: Frame) -> None:
        """Take one frame with velocities."""
        self._first = self._first or frame
        self._spool.append(velocities_of(frame))
        self._times.append(time_of(frame))

    def result(self) -> VelocityCorrelations:
        """Return functions, diffusion coefficients and errors."""
        spacing = spacing_of(self._times)
        lags = lags_of(len(self._times), self._longest, spacing)
        assert self._first is not None
        species = tuple(dict.fromkeys(self._first.names))
        rows = []
        for name in species:
            windows = correlate(self._spool, beads_of(self._first, name), lags, squared_differences=False)
            value, off = windows.value, windows.deviations
            scale = value[0] if value[0] != 0.0 else 1.0
            ratio = value / scale
            integral = _integral(value[None, :], spacing)[0] / 3.0
            error = errors_of((off - ratio * off[:, :1]) / scale)
            rows.append((value[0], ratio, error, integral, errors_of(_integral(off, spacing)) / 3.0))
        columns = [np.array(column) for column in zip(*rows, strict=True)]
        return VelocityCorrelations(species, times_of(spacing, lags), *columns)


def _integral(values: FloatArray, spacing: float) -> FloatArray:
    """Integrals of rows from 0 up to each point by the trapezoidal rule."""
    steps = 0.5 * spacing * (values[:, 1:] + values[:, :-1])
    return np.asarray(np.pad(np.cumsum(steps, axis=1), ((0, 0), (1, 0))))
