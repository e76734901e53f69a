"""Figures of quantities against time: temperatures, pressure, energies, momentum, volume, anything in STATIS."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pydlpoly.drawing import BAND, FAINT, HEIGHT, axis_label, legend, line, new_axes, thinned
from pydlpoly.formats.records import FloatArray
from pydlpoly.report.collect import Run
from pydlpoly.report.evidence import momentum_goes_to, thermal_momentum, with_error
from pydlpoly.report.series import Average, Series, all_series, pick
from pydlpoly.report.style import Drawing, Table, table_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TERMS = (
    ("short_range_energy", "pairs"),
    ("electrostatic_energy", "charges"),
    ("bond_energy", "bonds"),
    ("angle_energy", "angles"),
    ("dihedral_energy", "dihedrals and inversions"),
    ("tether_energy", "tethers"),
)


def temperature(run: Run) -> Drawing | None:
    """Kinetic and configurational temperature with the thermostat's."""
    found = all_series(run)
    kinetic = found.get("temperature") or found.get("kinetic_temperature")
    if kinetic is None:
        return None
    configurational = found.get("configurational_temperature")
    figure, (axes,) = new_axes()
    _faint(axes, kinetic, "kinetic, each")
    _running(axes, 0, kinetic, "kinetic, mean")
    words = [f"Kinetic temperature {_in_words(kinetic)}."]
    if configurational is not None:
        _running(axes, 1, configurational, "configurational, mean")
        words.append(f"Configurational temperature {_in_words(configurational)}.")
    elif run.log is not None and "configurational" in run.log.temperatures:
        value, error = run.log.temperatures["configurational"]
        average = Average(value, error, 1)
        axes.axhline(value, color="#D55E00", linestyle=(0, (5, 1.5)), label="configurational (OUTPUT)")
        words.append(f"Configurational temperature {with_error(average)} {kinetic.unit}".rstrip() + ", as OUTPUT ends.")
    else:
        words.append("The configurational temperature was not recorded (diagnostics_frequency in CONTROL).")
    if run.target_temperature is not None:
        axes.axhline(run.target_temperature, color="black", linestyle=(0, (1, 1.2)), linewidth=1.2, label="thermostat")
        words.append(f"The thermostat is at {run.target_temperature:.5g} {kinetic.unit}".rstrip() + ".")
    _finish(run, axes, axis_label("temperature", kinetic.unit))
    _equilibration(run, axes)
    focus = [kinetic, *([configurational] if configurational is not None else [])]
    _limits(axes, focus, run.target_temperature)
    return Drawing("temperature", "Temperature", figure, " ".join(words), _table(run, focus))


def pressure(run: Run) -> Drawing | None:
    """The pressure with its running average."""
    drawn = one_quantity(run, "pressure", "Pressure")
    if drawn is None:
        return None
    found = all_series(run)
    parts = {
        name.removeprefix("pressure_"): one.average()
        for name, one in found.items()
        if name.startswith("pressure_") and name != "pressure_volume"
    }
    told = [f"{name} {with_error(part)}" for name, part in parts.items() if part.samples and part.value != 0.0]
    words = f" Of it: {', '.join(told)}." if told else ""
    return Drawing(drawn.name, drawn.title, drawn.figure, drawn.caption + words, drawn.table)


def energy(run: Run) -> Drawing | None:
    """Total and potential energy, each in axes of its own."""
    found = all_series(run)
    shown = [(found.get("extended_energy"), "total"), (found.get("configurational_energy"), "potential")]
    return _stacked(run, "energy", "Energy", [(one, name) for one, name in shown if one is not None])


def energy_terms(run: Run) -> Drawing | None:
    """The parts of the potential energy that are there."""
    found = all_series(run)
    shown = [(found[name], label) for name, label in _TERMS if name in found and np.any(found[name].values != 0.0)]
    return _stacked(run, "energy-terms", "Potential energy by part", shown) if len(shown) > 1 else None


def momentum(run: Run) -> Drawing | None:
    """How far the total momentum has drifted, in units of its thermal size."""
    drift, thermal = all_series(run).get("momentum_drift"), thermal_momentum(run)
    if drift is None or not thermal > 0.0:
        return None
    figure, (axes,) = new_axes()
    values = drift.values / thermal
    line(axes, 0, drift.times, values, "drift of the total momentum")
    axes.set_ylim(bottom=0.0)
    _finish(run, axes, "fraction of its thermal size")
    taken = momentum_goes_to(run)
    words = (
        f"The total momentum drifts by at most {np.nanmax(values):.2g} of √(3 M k_B T), its size if nothing kept it."
    )
    words += (
        f" It is not conserved here: {taken}." if taken is not None else " Pair forces, drag and noise conserve it."
    )
    head = (axis_label("time", run.units.of("time")), "fraction")
    return Drawing("momentum", "Drift of the momentum", figure, words, table_of(head, [drift.times, values]))


def one_quantity(run: Run, name: str, title: str = "") -> Drawing | None:
    """Any quantity of STATIS or DIAGNOSTICS; None when there is none of this name."""
    if name not in all_series(run):
        return None
    series = pick(run, name)
    figure, (axes,) = new_axes()
    _faint(axes, series, "each record")
    _running(axes, 0, series, "mean so far ± error")
    _finish(run, axes, axis_label(series.label, series.unit))
    _equilibration(run, axes)
    _limits(axes, [series])
    heading = title or series.label[:1].upper() + series.label[1:]
    return Drawing(name, heading, figure, f"{heading} {_in_words(series)}.", _table(run, [series]))


def _stacked(run: Run, name: str, title: str, shown: list[tuple[Series, str]]) -> Drawing | None:
    if not shown:
        return None
    figure, rows = new_axes(max(HEIGHT, 0.7 + 0.95 * len(shown)), len(shown))
    for axes, (series, label) in zip(rows, shown, strict=True):
        _faint(axes, series, "each record")
        _running(axes, 0, series, "mean so far ± error")
        _limits(axes, [series])
        _equilibration(run, axes)
        axes.set_ylabel(label)
    legend(rows[0])
    rows[-1].set_xlabel(axis_label("time", run.units.of("time")))
    per = f"per bead, {run.units.energy or 'reduced'}" if run.beads else run.units.energy or "reduced"
    figure.supylabel(f"energy ({per})", fontsize=10)
    words = " ".join(f"{label[:1].upper() + label[1:]}: {_in_words(series)}." for series, label in shown)
    unit = " per bead" if run.beads else ""
    words = f"Energies{unit}. {words}"
    return Drawing(name, title, figure, words, _table(run, [one for one, _ in shown], [label for _, label in shown]))


def _faint(axes: Axes, series: Series, label: str) -> None:
    width = 0.6 if series.counted.any() else 1.2  # alone, when nothing counts yet
    axes.plot(*thinned(series.times, series.values), color=FAINT, linewidth=width, alpha=0.8, label=label, zorder=1)


def _running(axes: Axes, k: int, series: Series, label: str) -> None:
    """The running average and, as a band, its standard error on both sides."""
    times, means, errors = series.running()
    if not len(times):
        return
    known = np.isfinite(errors)
    if known.any():
        low, high = means - errors, means + errors
        axes.fill_between(times[known], low[known], high[known], color=BAND, alpha=0.55, linewidth=0.0, zorder=1.5)
    line(axes, k, times, means, label)


def _finish(run: Run, axes: Axes, label: str) -> None:
    axes.set_xlabel(axis_label("time", run.units.of("time")))
    axes.set_ylabel(label)
    handles, _ = axes.get_legend_handles_labels()
    if len(handles) > 1:
        legend(axes)


def _equilibration(run: Run, axes: Axes) -> None:
    """Shade the equilibration."""
    if run.equilibration and run.timestep:
        end = min(run.equilibration * run.timestep, axes.dataLim.x1)
        axes.axvspan(axes.dataLim.x0, end, color="#eef1f4", zorder=0, linewidth=0.0)


def _limits(axes: Axes, shown: list[Series], *values: float | None) -> None:
    """Let the samples that count fill the axes: the first steps of a run may be far away."""
    inside = [one.values[one.counted & np.isfinite(one.values)] for one in shown]
    known = np.concatenate([*inside, np.array([value for value in values if value is not None])])
    # The spread of values step by step of the configurational temperature is of no interest.
    if len(shown) > 1:
        weighted = [_settled(one) if one.weights is not None else x for one, x in zip(shown, inside, strict=True)]
        known = np.concatenate([*weighted, np.array([value for value in values if value is not None])])
    known = known[np.isfinite(known)]
    if len(known) < 2 or not np.ptp(known) > 0.0:
        return
    low, high = float(known.min()), float(known.max())
    room = 0.15 * (high - low)
    axes.set_ylim(low - room, high + room)
    seen = [one.values[np.isfinite(one.values)] for one in shown if one.weights is None]
    outside = sum(int(np.count_nonzero((values < low - room) | (values > high + room))) for values in seen)
    if outside:
        axes.text(1.0, 1.0, f"{outside} outside", transform=axes.transAxes, ha="right", va="top", fontsize=8.5)


def _settled(series: Series) -> FloatArray:
    """Running averages without the first fifth, in which a start far from equilibrium may rule."""
    means = series.running()[1]
    return means[len(means) // 5 :]


def _in_words(series: Series) -> str:
    average = series.average()
    if not average.samples:
        last = series.values[-1]
        return f"has no average: no record after the equilibration; its last value is {last:.5g} {series.unit}".rstrip()
    unit = f" {series.unit}" if series.unit else ""
    error = "" if average.known else " (too few for an error)"
    records = "record" if average.samples == 1 else "records"
    return f"{with_error(average)}{unit}, the mean of {average.samples} {records}{error}"


def _table(run: Run, shown: list[Series], labels: list[str] | None = None) -> Table | None:
    """Running averages with errors at some times."""
    first = shown[0]
    times, means, errors = first.running()
    names = labels or [one.label for one in shown]
    if len(shown) == 1:
        if not len(times):
            return table_of((axis_label("time", run.units.of("time")), names[0]), [first.times, first.values])
        return table_of((axis_label("time", run.units.of("time")), "mean so far", "error"), [times, means, errors])
    columns = [one.running() for one in shown]
    if not len(times) or any(len(column[0]) == 0 for column in columns):
        return None
    rest = [np.interp(times, column[0], column[1]) for column in columns[1:]]
    head = (axis_label("time", run.units.of("time")), *(f"{name}, mean so far" for name in names))
    return table_of(head, [times, means, *rest])
