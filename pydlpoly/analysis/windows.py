"""Time correlations over windows: every frame is an origin, all lags at once by FFT, errors from blocks of origins."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from tempfile import TemporaryFile
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import InputError
from pydlpoly.formats.blocks import standard_error
from pydlpoly.formats.records import FloatArray

_BLOCKS = 16
_NUMBERS_AT_ONCE = 4_000_000  # of one FFT: some 100 MB
_UNEVEN = 1e-4


class Spool:
    """A vector for every bead and frame, kept in a temporary file: correlations need all frames of a bead at once."""

    def __init__(self) -> None:
        """Start without frames."""
        self._file = TemporaryFile()  # noqa: SIM115 # it lives as long as this object
        finalize(self, self._file.close)
        self.frames, self.beads = 0, 0

    def append(self, vectors: FloatArray) -> None:
        """Take the vectors of one frame, (N, 3)."""
        if self.frames and len(vectors) != self.beads:
            raise InputError(f"the frames differ: {len(vectors)} beads after {self.beads}")
        self.beads = len(vectors)
        self._file.write(np.ascontiguousarray(vectors, dtype=np.float64).tobytes())
        self.frames += 1

    def groups(self, beads: NDArray[np.int64]) -> Iterator[FloatArray]:
        """Return the vectors of a few of these beads at a time, (frames, n, 3)."""
        self._file.flush()
        shape = (self.frames, self.beads, 3)
        table = np.memmap(self._file, dtype=np.float64, mode="r", shape=shape)
        size = max(1, _NUMBERS_AT_ONCE // (12 * max(self.frames, 1)))
        for start in range(0, len(beads), size):
            yield np.array(table[:, beads[start : start + size]])


@dataclass(frozen=True, eq=False)
class Windows:
    """Averages over origins by lag, in blocks of origins.

    Attributes:
        sums: (blocks, lags) of the quantity over origins and beads.
        counts: (blocks, lags) over how many.
    """

    sums: FloatArray
    counts: FloatArray

    @property
    def value(self) -> FloatArray:
        """(lags,) the averages."""
        return np.asarray(self.sums.sum(axis=0) / self.counts.sum(axis=0))

    @property
    def deviations(self) -> FloatArray:
        """(blocks, lags) series with mean 0, the error of whose mean is that of the average; linear in it."""
        total = self.counts.sum(axis=0)
        return np.asarray((self.sums - self.value * self.counts) * len(self.sums) / total)


def errors_of(deviations: FloatArray) -> FloatArray:
    """Return the standard errors of means, (columns,), of series (blocks, columns); not a number when too few."""
    return np.array([standard_error(column) for column in deviations.T])


def correlate(spool: Spool, beads: NDArray[np.int64], lags: int, *, squared_differences: bool) -> Windows:
    """Return averages over all origins of x(t)·x(t + lag), or of |x(t + lag) − x(t)|².

    By FFT, as in Calandrini et al., Collection SFN 12, 201 (2011): |x' − x|² = |x'|² + |x|² − 2 x'·x.

    Args:
        spool: the vectors.
        beads: ids of those to average over.
        lags: the largest lag in frames.
        squared_differences: which of the two.
    """
    frames = spool.frames
    edges = np.linspace(0, frames, min(_BLOCKS, max(1, frames // 4)) + 1).astype(int)
    sums = np.zeros((len(edges) - 1, lags + 1))
    for vectors in spool.groups(beads):
        places = vectors - vectors.mean(axis=0) if squared_differences else vectors
        squares = np.concatenate([[0.0], np.cumsum(np.einsum("tnx,tnx->t", places, places))])
        for block, (start, stop) in enumerate(pairwise(edges.tolist())):
            products = _products(places[start:stop], places[start : stop + lags], lags)
            if not squared_differences:
                sums[block] += products
                continue
            last = np.clip(frames - np.arange(lags + 1), start, stop)  # end of the origins that have this lag
            here = squares[last] - squares[start]
            later = (
                squares[last + np.arange(lags + 1) * (last > start)]
                - squares[np.minimum(start + np.arange(lags + 1), frames)]
            )
            sums[block] += np.where(last > start, here + later - 2.0 * products, 0.0)
    counts = np.clip(frames - np.arange(lags + 1)[None, :] - edges[:-1, None], 0, np.diff(edges)[:, None])
    return Windows(sums, counts.astype(np.float64) * len(beads))


def _products(first: FloatArray, second: FloatArray, lags: int) -> FloatArray:
    """Σ over t, beads and axes of first(t)·second(t + lag), (lags + 1,)."""
    length = 1 << int(np.ceil(np.log2(len(first) + len(second))))
    spectrum = np.zeros(length // 2 + 1, dtype=np.complex128)
    for axis in range(3):
        a, b = (np.fft.rfft(x[:, :, axis], length, axis=0) for x in (first, second))
        spectrum += np.einsum("fn,fn->f", a.conj(), b)
    reached = min(lags + 1, len(second))  # what stands behind are the negative lags
    products = np.zeros(lags + 1)
    products[:reached] = np.fft.irfft(spectrum, length)[:reached]
    return products


def spacing_of(times: list[float]) -> float:
    """Return the time between frames. Raises InputError when there are fewer than two, or they are not even."""
    if len(times) < 2:
        raise InputError("at least two frames are needed")
    steps = np.diff(times)
    mean = float(steps.mean())
    if not mean > 0.0 or np.abs(steps - mean).max() > max(_UNEVEN * mean, 2e-6):
        raise InputError("frames at even intervals of time are needed")
    return mean


def times_of(spacing: float, lags: int) -> FloatArray:
    """Return the times of the lags, (lags + 1,)."""
    return np.asarray(spacing * np.arange(lags + 1), dtype=np.float64)


def lags_of(frames: int, longest: float | None, spacing: float) -> int:
    """Return the largest lag in frames: ``longest`` as a time, by default a quarter of the trajectory."""
    lags = frames // 4 if longest is None else round(longest / spacing)
    return min(max(lags, 1), frames - 1)
