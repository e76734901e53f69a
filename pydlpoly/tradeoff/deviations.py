"""How far the averages of a run are off those of the reference, with statistical errors."""

from __future__ import annotations

import numpy as np

from pydlpoly.tradeoff.samples import FEWEST_SAMPLES, Plan, Samples
from pydlpoly.tradeoff.statistics import (
    Deviation,
    block_error,
    combine,
    judge,
    judge_many,
    mean_and_error,
    ratio_and_error,
    slope_and_error,
)

Estimate = tuple[float, float, float]  # a mean, its statistical error, and the error's degrees of freedom
_FEWEST_PAIRS = 0.02  # in a shell, of those in the fullest one, for it to be compared


def configurational(samples: Samples) -> tuple[float, float, float] | None:
    """k_B times the configurational temperature, its error and degrees of freedom; None where there is none."""
    squared_force, curvature = samples.column("squared_force"), samples.column("curvature")
    if not np.isfinite(squared_force).all() or not np.isfinite(curvature).all() or not curvature.mean() > 0.0:
        return None
    return ratio_and_error(squared_force, curvature)


def deviations(samples: Samples, reference: Samples, plan: Plan) -> dict[str, Deviation]:
    """Return how far the averages of a run are off, each as a fraction of its scale."""
    found: dict[str, Deviation] = {}
    if min(len(samples.rows), len(reference.rows)) < FEWEST_SAMPLES:
        return found

    longer = np.sqrt(reference.time / samples.time)
    wanted = plan.wanted

    def add(name: str, mine: Estimate, theirs: Estimate, least: float = 0.0, exact: float | None = None) -> None:
        """Compare with the reference, or with an exact value; the scale is the size of that, or at least ``least``."""
        error, freedom = not_below(mine[1:], theirs[1:], float(longer))
        value = mine[0] - (theirs[0] if exact is None else exact)
        if exact is None:
            error, freedom = combine((error, freedom), theirs[1:])
        scale = max(abs(theirs[0] if exact is None else exact), least) or 1.0
        found[name] = judge(value / scale, error / scale, freedom, plan.target)

    def both(name: str) -> tuple[Estimate, Estimate]:
        return mean_and_error(samples.column(name)), mean_and_error(reference.column(name))

    mine, theirs = both("temperature")
    add("temperature", mine, theirs, exact=wanted)
    positions, other = configurational(samples), configurational(reference)
    if positions is not None and other is not None:
        add("configurational_temperature", positions, other, exact=None if wanted is None else wanted * plan.boltzmann)
    for name, least in (("pressure", plan.ideal_pressure), ("energy", plan.thermal)):
        mine, theirs = both(name)
        add(name, mine, theirs, least)
    structure = _structure(samples, reference, plan)
    if structure is not None:
        found["rdf"] = structure
    if not plan.thermostat:
        slope, error, freedom = slope_and_error(samples.column("time"), samples.column("total"))
        scale = 1.5 * plan.thermal / plan.run_time
        found["drift"] = judge(slope / scale, error / scale, freedom, plan.target)
    if plan.lag > 0.0:
        found["diffusion"] = Deviation(0.0, float("inf"), "cannot tell")
        if min(len(samples.diffusion), len(reference.diffusion)) >= 2:
            add("diffusion", mean_and_error(samples.diffusion), mean_and_error(reference.diffusion))
    return found


def not_below(mine: tuple[float, float], theirs: tuple[float, float], longer: float) -> tuple[float, float]:
    """Return an error and its degrees of freedom, but no less than the reference's error says for so short a run.

    Fluctuations last as long in both. A run that is shorter than they last does not know its error.
    """
    return mine if mine[0] >= theirs[0] * longer else (theirs[0] * longer, theirs[1])


def _structure(samples: Samples, reference: Samples, plan: Plan) -> Deviation | None:
    """Return the largest deviation of g(r) over shells in which enough pairs were counted."""
    mine, theirs = np.array(samples.shells), np.array(reference.shells)
    unit = plan.shells.ravel()
    seen = theirs.sum(axis=0).reshape(plan.shells.shape)
    enough = (seen >= np.maximum(1.0, _FEWEST_PAIRS * seen.max(axis=1, keepdims=True))).ravel()
    if not enough.any():
        return None
    a, b = (x[:, enough] * unit[enough] for x in (mine, theirs))
    (s, n), (u, m) = block_error(a), block_error(b)
    least = u * np.sqrt(reference.time / samples.time)
    s, n = np.maximum(s, least), np.where(s < least, m, n)
    errors = np.hypot(s, u)
    with np.errstate(invalid="ignore", divide="ignore"):
        freedom = np.where(errors > 0.0, errors**4 / (s**4 / n + u**4 / m), np.minimum(n, m))
    return judge_many(a.mean(axis=0) - b.mean(axis=0), errors, np.nan_to_num(freedom, nan=1.0), plan.target)
