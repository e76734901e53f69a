"""Correlation functions while a run goes on, over times much longer than what is kept of its past.

The multiple-tau correlator of Ramírez, Sukumaran, Vorselaars and Likhtman, J. Chem. Phys. 133, 154103 (2010): level 0
correlates samples at the lags 0 … points − 1; each further level correlates means over ``window`` values of the level
before, at the lags from points/window on. Samples are taken in chunks of fixed size, so that sums are the same bits
however often someone looks at them, and sums are kept by blocks of time, for errors.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pydlpoly.formats.blocks import standard_error
from pydlpoly.formats.records import FloatArray, IntArray

_CHUNK = 256  # samples that are correlated at once
_BLOCKS = 32


class MultipleTau:
    """Correlation functions ⟨A(t) B(t + τ)⟩ of some pairs of quantities.

    Args:
        count: how many pairs.
        points: lags of a level, at least 2.
        levels: at least 1.
        window: values of one level that make one of the next; at least 2 with several levels, and at most ``points``.

    Raises:
        ValueError: a number is out of range.
    """

    def __init__(self, count: int, *, points: int = 16, levels: int = 8, window: int = 2) -> None:
        """Start without samples; see the class."""
        if count < 1 or points < 2 or levels < 1 or window < 1:
            raise ValueError("expected at least one pair, two points, one level and a window of 1")
        if levels > 1 and not 2 <= window <= points:
            raise ValueError(f"several levels need a window between 2 and the {points} points, not {window}")
        self.points, self.levels, self.window = points, levels, window
        self.taken = 0
        self._waiting = np.zeros((0, 2, count))
        self._past = [np.zeros((0, 2, count)) for _ in range(levels)]
        self._carried = [np.zeros((0, 2, count)) for _ in range(levels)]
        self._sums = np.zeros((_BLOCKS, levels, points, count))
        self._counts = np.zeros((_BLOCKS, levels, points), dtype=np.int64)
        self._chunks, self._length = 0, 1  # chunks so far, chunks a block

    def add(self, left: ArrayLike, right: ArrayLike) -> None:
        """Take one sample of A and of B, (count,) each."""
        sample = np.array([left, right], dtype=np.float64)
        self._waiting = np.concatenate([self._waiting, sample[None]])
        self.taken += 1
        if len(self._waiting) == _CHUNK:
            self._flush()

    def lags(self) -> IntArray:
        """Return the lags that have been met, in samples."""
        return self._finished()._lags()

    def values(self) -> FloatArray:
        """Return the correlation functions at ``lags``, (lags, count)."""
        return self._finished()._values()

    def block_values(self) -> FloatArray:
        """Return the functions of those blocks of time in which all lags were met, (blocks, lags, count)."""
        done = self._finished()
        used = done._used()
        full = done._counts[: self._chunks // self._length][:, used].min(axis=1, initial=1) > 0
        sums, counts = done._sums[: len(full)][full][:, used], done._counts[: len(full)][full][:, used]
        blocks: FloatArray = sums / counts[..., None]
        return blocks

    def integrals(self, spacing: float) -> tuple[FloatArray, FloatArray]:
        """Return the running integral by the trapezoidal rule and its standard error, (lags, count) each.

        Args:
            spacing: time between samples.

        The error comes from the blocks and is not a number when there are too few.
        """
        times = np.asarray(self.lags() * spacing, dtype=np.float64)
        blocks = running_integral(times, self.block_values())
        errors = np.array([[standard_error(series) for series in lag.T] for lag in np.moveaxis(blocks, 1, 0)])
        return running_integral(times, self.values()), errors.reshape(len(times), -1)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything a checkpoint needs, as arrays by name."""
        shape = (self.points, self.levels, self.window, self.taken, self._chunks, self._length)
        parts = {"shape": np.array(shape, dtype=np.int64), "sums": self._sums.copy(), "counts": self._counts.copy()}
        parts["waiting"] = self._waiting
        for level in range(self.levels):
            parts[f"past{level}"], parts[f"carried{level}"] = self._past[level], self._carried[level]
        return parts

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on exactly where ``state`` was taken. Raises ValueError when it is of another shape."""
        shape = [int(number) for number in state["shape"]]
        if shape[:3] != [self.points, self.levels, self.window] or state["sums"].shape != self._sums.shape:
            raise ValueError("the correlator has another shape")
        self.taken, self._chunks, self._length = shape[3:]
        self._sums, self._counts = np.array(state["sums"]), np.array(state["counts"])
        self._waiting = np.array(state["waiting"])
        self._past = [np.array(state[f"past{level}"]) for level in range(self.levels)]
        self._carried = [np.array(state[f"carried{level}"]) for level in range(self.levels)]

    def _finished(self) -> MultipleTau:
        """A correlator that has the waiting samples, too."""
        if not len(self._waiting):
            return self
        other = deepcopy(self)
        other._flush()
        return other

    def _used(self) -> NDArray[np.bool_]:
        met: NDArray[np.bool_] = self._counts.sum(axis=0) > 0
        return met

    def _lags(self) -> IntArray:
        steps = self.window ** np.arange(self.levels, dtype=np.int64)
        lags: IntArray = (steps[:, None] * np.arange(self.points, dtype=np.int64))[self._used()]
        return lags

    def _values(self) -> FloatArray:
        used = self._used()
        values: FloatArray = self._sums.sum(axis=0)[used] / self._counts.sum(axis=0)[used][:, None]
        return values

    def _flush(self) -> None:
        if self._chunks == self._length * _BLOCKS:
            self._sums = np.concatenate([self._sums[::2] + self._sums[1::2], np.zeros_like(self._sums[::2])])
            self._counts = np.concatenate([self._counts[::2] + self._counts[1::2], np.zeros_like(self._counts[::2])])
            self._length *= 2
        block = self._chunks // self._length
        new, self._waiting = self._waiting, self._waiting[:0]
        for level in range(self.levels):
            self._correlate(level, block, new)
            if level + 1 == self.levels:
                break
            values = np.concatenate([self._carried[level], new])
            whole = len(values) // self.window * self.window
            new, self._carried[level] = _means(values[:whole], self.window), values[whole:]
        self._chunks += 1

    def _correlate(self, level: int, block: int, new: FloatArray) -> None:
        values = np.concatenate([self._past[level], new])
        first = 0 if level == 0 else -(-self.points // self.window)
        for lag in range(first, min(self.points, len(values))):
            right = values[max(len(self._past[level]), lag) :, 1]
            left = values[len(values) - len(right) - lag : len(values) - lag, 0]
            self._sums[block, level, lag] += np.sum(left * right, axis=0)
            self._counts[block, level, lag] += len(right)
        self._past[level] = values[max(0, len(values) - self.points + 1) :]


def running_integral(times: FloatArray, values: FloatArray) -> FloatArray:
    """Return ∫_0^t C dt' by the trapezoidal rule along the last axis but one, 0 at the first time."""
    if values.shape[-2] == 0:
        return values
    areas = 0.5 * (values[..., 1:, :] + values[..., :-1, :]) * np.diff(times)[:, None]
    integral: FloatArray = np.concatenate([np.zeros_like(values[..., :1, :]), np.cumsum(areas, axis=-2)], axis=-2)
    return integral


def _means(values: FloatArray, window: int) -> FloatArray:
    means: FloatArray = values.reshape(len(values) // window, window, *values.shape[1:]).mean(axis=1)
    return means
