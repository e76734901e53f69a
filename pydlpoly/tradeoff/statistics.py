"""Means, statistical errors of correlated samples, and what may be said about a deviation in view of its error."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import NormalDist
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from pydlpoly.formats.records import FloatArray

Verdict = Literal["within", "outside", "cannot tell"]

CONFIDENCE = 0.95
REACH = NormalDist().inv_cdf(0.5 + 0.5 * CONFIDENCE)
"""Standard errors to the end of an interval of this confidence."""

_TOGETHER = 5  # quantities, of which one that is outside condemns a candidate
_FEWEST_BLOCKS = 8


@dataclass(frozen=True)
class Deviation:
    """How far a quantity is off, as a fraction of its scale, and what that means for the target.

    Attributes:
        value: measured minus reference; for g(r) the size of the largest deviation.
        error: its statistical error, the reference's included: half of an interval of 95 % confidence is 1.96 of it,
            so that few independent samples make it larger (Student).
        verdict: "within" or "outside" the target, else "cannot tell"; see ``judge``.
    """

    value: float
    error: float
    verdict: Verdict


def block_error(samples: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the standard errors of the means of correlated series, and from how many degrees of freedom they are.

    Neighbouring samples are averaged in pairs again and again (Flyvbjerg and Petersen, J. Chem. Phys. 91, 461 (1989)):
    the error that blocks seem to have grows with their length until they are independent. Of each series the first
    level is taken that no longer blocks exceed by more than half of the uncertainty of their errors, which errs on the
    large side: 10 % for independent samples. The longest blocks are those of which there are still 8.

    Args:
        samples: (n,) or (n, series), in the order of time.

    Returns:
        errors and degrees of freedom, both (series,); infinite errors for fewer than two samples.
    """
    values = np.asarray(samples, dtype=np.float64)
    values = values.reshape(len(values), -1)
    errors: list[FloatArray] = []
    freedom: list[int] = []
    while len(values) >= 2 and (not errors or len(values) >= _FEWEST_BLOCKS):
        errors.append(values.std(axis=0, ddof=1) / np.sqrt(len(values)))
        freedom.append(len(values) - 1)
        values = 0.5 * (values[: len(values) // 2 * 2 : 2] + values[1 : len(values) // 2 * 2 : 2])
    if not errors:
        return np.full(values.shape[1], np.inf), np.ones(values.shape[1])
    table, counts = np.array(errors), np.array(freedom, dtype=np.float64)
    least = table - 0.5 * table / np.sqrt(2.0 * counts)[:, None]  # below which these errors are not
    chosen = np.full(table.shape[1], len(table) - 1)
    for level in range(len(table) - 2, -1, -1):
        flat = np.all(least[level + 1 :] <= table[level], axis=0)
        chosen = np.where(flat, level, chosen)
    return np.take_along_axis(table, chosen[None, :], axis=0)[0], counts[chosen]


def mean_and_error(samples: ArrayLike) -> tuple[float, float, float]:
    """Return the mean of a series, its standard error and the error's degrees of freedom."""
    values = np.asarray(samples, dtype=np.float64)
    error, freedom = block_error(values)
    return float(values.mean()), float(error[0]), float(freedom[0])


def ratio_and_error(above: FloatArray, below: FloatArray) -> tuple[float, float, float]:
    """Return mean over mean of two series, its standard error and the error's degrees of freedom."""
    ratio = float(np.mean(above) / np.mean(below))
    error, freedom = block_error((above - ratio * below) / np.mean(below))
    return ratio, float(error[0]), float(freedom[0])


def slope_and_error(times: FloatArray, values: FloatArray, blocks: int = 20) -> tuple[float, float, float]:
    """Return how fast a quantity drifts, its standard error and degrees of freedom.

    From the steps between means of blocks, as if they were independent. So they are where the quantity makes a random
    walk, as the energy does when pairs cross a cutoff; where it swings about a straight line the error is too large.
    """
    count = min(blocks, len(values))
    if count < 4:
        return 0.0, float("inf"), 1.0
    t = np.array([part.mean() for part in np.array_split(times, count)])
    x = np.array([part.mean() for part in np.array_split(values, count)])
    rates = np.diff(x) / np.diff(t)
    slope = float((x[-1] - x[0]) / (t[-1] - t[0]))
    return slope, float(rates.std(ddof=1) / np.sqrt(count - 1)), float(count - 2)


def student(freedom: ArrayLike, confidence: float = CONFIDENCE) -> FloatArray:
    """Return how many standard errors a two-sided interval reaches when the error is known from so few numbers.

    Expansion about the normal distribution, good to a per cent from four degrees of freedom on.
    """
    nu = np.asarray(freedom, dtype=np.float64)
    z = NormalDist().inv_cdf(0.5 + 0.5 * confidence)
    first, second = (z**3 + z) / 4.0, (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0
    third = (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0
    return np.asarray(z + first / nu + second / nu**2 + third / nu**3)


def judge(value: float, error: float, freedom: float, target: float) -> Deviation:
    """Say whether a deviation is within the target, with 95 % confidence; ``freedom`` is that of its error.

    Each of the quantities must be within, but one that is outside is enough: so that chance does not do that with five
    of them, "outside" takes a confidence of 99 %.
    """
    if not np.isfinite(value) or not np.isfinite(error):
        return Deviation(0.0, float("inf"), "cannot tell")
    reach = float(student(freedom)) * error
    verdict: Verdict = "within" if abs(value) + reach <= target else "cannot tell"
    if abs(value) - float(student(freedom, 1.0 - (1.0 - CONFIDENCE) / _TOGETHER)) * error > target:
        verdict = "outside"
    return Deviation(value, reach / REACH, verdict)


def judge_many(values: FloatArray, errors: FloatArray, freedom: FloatArray, target: float) -> Deviation:
    """Return the largest of many deviations, and judge them together.

    "within" needs every one to be within. That one of many is outside is the more likely by chance the more there are,
    so that each must be outside with a confidence that makes 99 % for all. The largest is the one that is largest in
    spite of its error.
    """
    spread = student(freedom, 1.0 - (1.0 - CONFIDENCE) / _TOGETHER / len(values)) * errors
    reach = student(freedom) * errors
    worst = int(np.argmax(np.abs(values) - spread))
    verdict: Verdict = "within" if np.all(np.abs(values) + reach <= target) else "cannot tell"
    if np.abs(values[worst]) - spread[worst] > target:
        verdict = "outside"
    return Deviation(float(abs(values[worst])), float(reach[worst]) / REACH, verdict)


def combine(first: tuple[float, float], second: tuple[float, float]) -> tuple[float, float]:
    """Return the error of a difference and its degrees of freedom (Welch) from both errors and theirs."""
    (a, n), (b, m) = first, second
    error = float(np.hypot(a, b))
    if not np.isfinite(error) or error == 0.0:
        return error, min(n, m)
    return error, error**4 / (a**4 / n + b**4 / m)
