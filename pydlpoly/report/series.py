"""Quantities of a run against time, with averages, running averages and errors from blocks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import InputError, suggest
from pydlpoly.formats.blocks import beyond_chance, block_means, line_through, standard_error, three_of
from pydlpoly.formats.diagnostics import COLUMNS, HEAT_COLUMNS
from pydlpoly.formats.records import FloatArray
from pydlpoly.formats.statis import STATISTICS_NAMES
from pydlpoly.report.collect import Run, Units

LEAST_SAMPLES = 8
"""From fewer samples nothing is concluded, as in the run's own warnings (``pydlpoly.temperatures``)."""
_RUNNING_POINTS = 60


@dataclass(frozen=True)
class Average:
    """A mean with its standard error, from blocks as in OUTPUT (``pydlpoly.formats.blocks``).

    Attributes:
        value, error: not a number where there are no samples, or fewer than 4 for an error.
        samples: how many there are.
        chance: what the mean exceeds by chance as seldom as three standard errors; infinite for fewer than 8 samples.
    """

    value: float
    error: float
    samples: int
    chance: float = math.inf

    @property
    def known(self) -> bool:
        """Whether the error is known."""
        return math.isfinite(self.error)


def average_of(values: FloatArray, weights: FloatArray | None = None) -> Average:
    """Return the mean of samples, or Σ values·weights/Σ weights; what is not finite is left out."""
    finite = np.isfinite(values) if weights is None else np.isfinite(values) & np.isfinite(weights)
    values = values[finite]
    count = len(values)
    if weights is None:
        value, blocks = float(np.mean(values)) if count else math.nan, block_means(values)
    else:
        weights = weights[finite]
        if not float(weights.sum()) > 0.0:
            return Average(math.nan, math.nan, 0)
        value = float(np.sum(values * weights) / np.sum(weights))
        # Linear in both sums: this series has the error of the ratio.
        blocks = block_means((values - value) * weights) / float(np.mean(weights))
    chance = beyond_chance(blocks) if count >= LEAST_SAMPLES else math.inf
    return Average(value, standard_error(blocks), count, chance)


@dataclass(frozen=True, eq=False)
class Series:
    """A quantity against time.

    Attributes:
        name, label, kind: kind says the unit, as in ``Units.of``.
        unit: its word, empty in reduced units.
        times, values: (n,); ``counted``: (n,) those after the equilibration.
        weights: (n,) when the mean is Σ values·weights/Σ weights, as for the configurational temperature.
    """

    name: str
    label: str
    kind: str
    unit: str
    times: FloatArray
    values: FloatArray
    counted: NDArray[np.bool_]
    weights: FloatArray | None = None

    def average(self) -> Average:
        """Return the mean over the samples that count."""
        return self._average(int(self.counted.sum()))

    def running(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return times, means of all samples that count up to then, and their errors, at up to 60 times."""
        times = self.times[self.counted]
        if not len(times):
            return np.zeros(0), np.zeros(0), np.zeros(0)
        ends = np.unique(np.linspace(1, len(times), min(len(times), _RUNNING_POINTS)).astype(int))
        means = [self._average(int(end)) for end in ends]
        return times[ends - 1], np.array([one.value for one in means]), np.array([one.error for one in means])

    def _average(self, count: int) -> Average:
        weights = None if self.weights is None else self.weights[self.counted][:count]
        return average_of(self.values[self.counted][:count], weights)


def all_series(run: Run) -> dict[str, Series]:
    """Return every quantity of STATIS and DIAGNOSTICS by name, and what OUTPUT alone has.

    Energies are per bead where the number of beads is known.
    """
    found: dict[str, Series] = {}
    table, units, after = run.statistics, run.units, run.equilibration
    if table is not None and len(table):
        labels = {one.name: (one.label, one.unit) for one in STATISTICS_NAMES}
        for name in table.columns:
            label, kind = labels.get(name, (_extra_label(name), "area" if name.startswith("msd_") else ""))
            values, per = table[name], ""
            if kind in ("energy", "virial") and run.beads:
                values, per = values / run.beads, " per bead"
            counted = table.step > after
            found[name] = Series(name, label.lower() + per, kind, units.of(kind), table.time, values, counted)
    return found | _of_output(run, units) | _of_diagnostics(run, units)


def pick(run: Run, name: str) -> Series:
    """Return one quantity. Raises InputError when there is none of this name, with the nearest ones."""
    known = all_series(run)
    if name not in known:
        raise InputError(f"there is no such quantity in this folder{suggest(name, known)}", word=name)
    return known[name]


def _of_output(run: Run, units: Units) -> dict[str, Series]:
    """What print-outs say of heat, for runs without DIAGNOSTICS."""
    log = run.log
    if log is None or not len(log.steps):
        return {}
    found = {}
    for words, values in log.printed.items():
        kind = "temperature" if "temperature" in words else "energy"
        per_bead = kind == "energy" and bool(run.beads)
        name, label = words.replace(" ", "_"), words + (" per bead" if per_bead else "")
        scaled = values / run.beads if per_bead and run.beads else values
        counted = log.steps > run.equilibration
        found[name] = Series(name, label, kind, units.of(kind), log.times, scaled, counted)
    return found


def _of_diagnostics(run: Run, units: Units) -> dict[str, Series]:
    columns = run.diagnostics
    if columns is None or not {"step", "time"} <= columns.keys() or not len(columns["step"]):
        return {}
    counted = columns["step"] > run.equilibration
    kinds = {column.name: column.kind for column in (*COLUMNS, *HEAT_COLUMNS)}
    found = {
        name: Series(
            name,
            name.replace("_", " ") + (" per bead" if kinds.get(name) == "energy" else ""),
            kinds.get(name, ""),
            units.of(kinds.get(name, "")),
            columns["time"],
            values,
            counted,
        )
        for name, values in columns.items()
        if name not in ("step", "time")
    }
    if {"squared_force", "laplacian"} <= columns.keys():
        weights = columns["laplacian"] * units.boltzmann
        with np.errstate(divide="ignore", invalid="ignore"):
            values = columns["squared_force"] / weights
        found["configurational_temperature"] = Series(
            "configurational_temperature",
            "configurational temperature",
            "temperature",
            units.of("temperature"),
            columns["time"],
            values,
            counted,
            weights,
        )
    return found


def _extra_label(name: str) -> str:
    if name.startswith("msd_"):
        return f"mean-square displacement of {name[4:]}"
    return name.replace("_", " ")


def trend_and_chance(series: Series) -> tuple[float, float]:
    """Return the change of a straight line through the samples that count, and what chance allows."""
    chosen = series.counted & np.isfinite(series.values)
    times, values = block_means(series.times[chosen]), block_means(series.values[chosen])
    if int(chosen.sum()) < LEAST_SAMPLES:
        return 0.0, math.inf
    slope, error = line_through(times, values)
    span = float(times[-1] - times[0])
    return slope * span, three_of(len(values) - 2) * error * span


def change_and_chance(series: Series) -> tuple[float, float]:
    """Return by how much the halves of the samples that count differ, late minus early, and what chance allows."""
    values = series.values[series.counted]
    values = values[np.isfinite(values)]
    half = len(values) // 2
    early, late = average_of(values[:half]), average_of(values[-half:] if half else values[:0])
    return late.value - early.value, math.hypot(early.chance, late.chance)
