"""Averages of correlated samples with their errors, from sums over blocks that grow with the run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pydlpoly.formats.records import FloatArray

LEAST_BLOCKS = 4
_BLOCKS_FOR_ERRORS = 8
_CAPACITY = 32
_LARGEST_CORRELATION = 0.95


@dataclass(frozen=True)
class Estimate:
    """An average and its standard error.

    Attributes:
        value: the average.
        error: standard error; not a number when there are fewer than ``LEAST_BLOCKS`` blocks.
        samples: how many samples the average is made of; ``blocks``: how many blocks the error is made of.
    """

    value: float
    error: float
    samples: int
    blocks: int


class BlockSums:
    """Sums of some quantities over blocks of equally many samples.

    When there are 32 blocks, neighbours are joined and blocks become twice as long: the memory stays small, and blocks
    outgrow the correlation of the samples.

    Args:
        count: how many quantities a sample has.
    """

    def __init__(self, count: int) -> None:
        """Start without samples; see the class."""
        if count < 1:
            raise ValueError(f"the number of quantities must be positive, not {count}")
        self.taken = 0
        self._length = 1
        self._sums = np.zeros((_CAPACITY, count))

    def add(self, values: ArrayLike) -> None:
        """Take one sample, shape (count,)."""
        if self.taken == self._length * _CAPACITY:
            self._sums = np.concatenate([self._sums[::2] + self._sums[1::2], np.zeros_like(self._sums[::2])])
            self._length *= 2
        self._sums[self.taken // self._length] += np.asarray(values, dtype=np.float64)
        self.taken += 1

    def mean(self) -> FloatArray:
        """Return the averages over all samples, shape (count,); zeros before the first."""
        average: FloatArray = np.sum(self._sums, axis=0) / max(self.taken, 1)
        return average

    def means(self) -> FloatArray:
        """Return the averages over each full block, shape (blocks, count)."""
        full: FloatArray = self._sums[: self.taken // self._length] / self._length
        return full

    def estimate(self, k: int) -> Estimate:
        """Return the average of quantity ``k``."""
        return Estimate(float(self.mean()[k]), standard_error(self.means()[:, k]), self.taken, len(self.means()))

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything a checkpoint needs, as arrays by name."""
        counts = np.array([self.taken, self._length], dtype=np.int64)
        return {"counts": counts, "sums": self._sums.copy()}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on exactly where ``state`` was taken. Raises ValueError when it is of other quantities."""
        if state["sums"].shape != self._sums.shape:
            raise ValueError(f"expected {self._sums.shape[1]} quantities")
        self.taken, self._length = (int(count) for count in state["counts"])
        self._sums = np.array(state["sums"], dtype=np.float64)


def block_means(values: FloatArray) -> FloatArray:
    """Return the averages over blocks that ``BlockSums`` would have after these samples, (n,) or (n, quantities)."""
    length = 1
    while len(values) > length * _CAPACITY:
        length *= 2
    full = values[: len(values) // length * length]
    means: FloatArray = full.reshape(-1, length, *values.shape[1:]).mean(axis=1)
    return means


def standard_error(series: FloatArray) -> float:
    """Return the standard error of the mean of values of consecutive blocks, not a number when there are too few.

    Blocks are joined as long as 8 remain, and the largest error counts. Where neighbours are correlated still (by c),
    the error is that of independent blocks times √((1 + c)/(1 − c)).
    """
    joined = list(_joined(series, _BLOCKS_FOR_ERRORS)) or list(_joined(series, LEAST_BLOCKS))
    return max((_error_of_mean(values) for values in joined), default=float("nan"))


def standard_errors(blocks: FloatArray) -> FloatArray:
    """Return ``standard_error`` of every column of averages over blocks, (blocks, n) to (n,)."""
    count = len(blocks)
    least = _BLOCKS_FOR_ERRORS if count >= _BLOCKS_FOR_ERRORS else LEAST_BLOCKS
    errors: FloatArray = np.full(blocks.shape[1:], np.nan if count < LEAST_BLOCKS else 0.0)
    while len(blocks) >= least:
        count = len(blocks)
        rest = blocks - np.mean(blocks, axis=0)
        squares = np.sum(rest**2, axis=0)
        with np.errstate(invalid="ignore"):
            alike = np.clip(np.sum(rest[1:] * rest[:-1], axis=0) / squares, 0.0, _LARGEST_CORRELATION)
        variance = np.where(squares == 0.0, 0.0, squares / (count - 1) * (1.0 + alike) / (1.0 - alike))
        errors = np.maximum(errors, np.sqrt(variance / count))
        blocks = blocks[: count // 2 * 2].reshape(-1, 2, *blocks.shape[1:]).mean(axis=1)
    return errors


def beyond_chance(series: FloatArray) -> float:
    """Return what the mean's deviation exceeds by chance as seldom as three standard errors; not a number when few.

    An error from few blocks is uncertain itself: the factor is Student's instead of 3. Here blocks are joined as long
    as 4 remain, so that samples that are close in time do not count as many.
    """
    joined = _joined(series, LEAST_BLOCKS)
    return max((three_of(len(values) - 1) * _error_of_mean(values) for values in joined), default=float("nan"))


def line_through(times: FloatArray, series: FloatArray) -> tuple[float, float]:
    """Return the slope of the straight line through averages of blocks, and its standard error."""
    count = len(series)
    if count < LEAST_BLOCKS:
        return float("nan"), float("nan")
    apart = times - np.mean(times)
    spread = float(np.sum(apart**2))
    slope = float(np.sum(apart * series)) / spread
    rest = series - np.mean(series) - slope * apart
    return slope, float(np.sqrt(_inflated(rest, count - 2) / spread))


def three_of(freedom: int) -> float:
    """Return how many standard errors, known with so many degrees of freedom, are as rare as three that are exact.

    Student's distribution, by Cornish and Fisher's series.
    """
    return 3.0 + 7.5 / freedom + 17.25 / freedom**2 + 30.2 / freedom**3


def _joined(series: FloatArray, least: int) -> Iterator[FloatArray]:
    """The series, and the series with blocks joined by two, four, … as long as ``least`` remain."""
    while len(series) >= least:
        yield series
        series = series[: len(series) // 2 * 2].reshape(-1, 2).mean(axis=1)


def _error_of_mean(series: FloatArray) -> float:
    count = len(series)
    return float(np.sqrt(_inflated(series - np.mean(series), count - 1) / count))


def _inflated(rest: FloatArray, freedom: int) -> float:
    """Variance of deviations, made larger when neighbours deviate alike."""
    squares = float(np.sum(rest**2))
    if squares == 0.0:
        return 0.0
    alike = min(max(float(np.sum(rest[1:] * rest[:-1])) / squares, 0.0), _LARGEST_CORRELATION)
    return squares / freedom * (1.0 + alike) / (1.0 - alike)
