"""Whether something that should be conserved stays what it was."""

from __future__ import annotations

import math

import numpy as np

from pydlpoly.formats.blocks import three_of
from pydlpoly.report.evidence import Evidence
from pydlpoly.report.finding import Finding, unknown
from pydlpoly.report.series import LEAST_SAMPLES
from pydlpoly.tradeoff.statistics import slope_and_error

ENERGY = 0.01


def drift_of(evidence: Evidence, name: str, subject: str, label: str, advice: str) -> list[Finding]:
    """A drift of an energy per bead by more than 1 % of k_B T over the run, and than its error.

    1 % of k_B T is a change of the temperature by at most as much: where it all went into motion, 2/3 of a per cent.
    """
    scene, series = evidence.run.scene, evidence.series.get(name)
    if scene is None or series is None or not evidence.run.beads:
        return []
    known = series.counted & np.isfinite(series.values)
    times, values = series.times[known], series.values[known]
    if len(times) < LEAST_SAMPLES:
        return [unknown(subject, "there are too few samples after the equilibration")]
    slope, error, freedom = slope_and_error(times, values)
    chance = three_of(int(freedom)) * error
    kinetic = evidence.kinetic()
    temperature = kinetic.value if kinetic is not None else 0.0
    thermal = temperature * scene.units.boltzmann / scene.units.factor
    span = float(times[-1] - times[0])
    change = slope * span / thermal if thermal > 0.0 else math.inf
    text = f"{label} changes by {change:.2g} k_B T per bead over {evidence.number(span, 'time')}"
    if abs(change) > ENERGY and abs(slope) > chance:
        return [Finding("warning", subject, text, f"{advice}; `pydlpoly tradeoff {evidence.folder}`")]
    return [Finding("fine", subject, text)]
