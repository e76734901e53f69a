"""Figures of COR: the relaxation of the shear stress, the viscosity as it grows with the lag, other correlations."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from pydlpoly.drawing import STYLES, axis_label, banded, legend, new_axes
from pydlpoly.formats.cor import Correlation, Derived
from pydlpoly.report.collect import Run
from pydlpoly.report.evidence import with_error
from pydlpoly.report.series import Average
from pydlpoly.report.style import Drawing, Table, table_of
from pydlpoly.reporters.multiple_tau import running_integral

_SHEAR = re.compile(r"stress_(xy|xz|yz)-stress_(?P<same>\1)")


def relaxation(run: Run) -> Drawing | None:
    """Correlations of shear components with themselves, on logarithmic axes."""
    shown = _drawable(one for one in _of(run) if _SHEAR.fullmatch(one.name))
    if not any(np.any(one.values[1:] > 0.0) for one in shown):
        return None
    figure, (axes,) = new_axes()
    below = 0
    for k, one in enumerate(shown):
        later = one.lags > 0.0
        positive = later & (one.values > 0.0)
        below += int(np.count_nonzero(later & ~positive))
        values = np.where(positive, one.values, np.nan)  # a gap, not a line across it
        error = None if one.errors is None else np.minimum(one.errors, 0.9 * values)
        banded(axes, k, one.lags[1:], values[1:], None if error is None else error[1:], _short(one), points=True)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(axis_label("lag", run.units.of("time")))
    axes.set_ylabel(axis_label("⟨σ(0) σ(t)⟩", _squared(run)))
    legend(axes)
    words = [f"How shear stress is forgotten, {_source(run)}, both axes logarithmic. {_at_zero(run, shown)}"]
    if any(one.errors is not None for one in shown):
        words.append("Bands: standard errors.")
    if below:
        words.append(f"{below} values that are not above 0 have no place on these axes: they are lost in noise.")
    words += _left_out(run, shown, lambda one: bool(_SHEAR.fullmatch(one.name)))
    return Drawing("stress-relaxation", "Stress relaxation", figure, " ".join(words), _table(run, shown))


def viscosity(run: Run) -> Drawing | None:
    """The integral of Green and Kubo as it grows with the lag, of each shear component and their mean."""
    found = run.correlations.derived.get("viscosity") if run.correlations is not None else None
    shears = _drawable(one for one in _of(run) if _SHEAR.fullmatch(one.name))
    if found is None or not shears or len(found.components) != len(shears):
        return None
    factor = _factor(found, shears)
    if factor is None:
        return None
    figure, (axes,) = new_axes()
    grown = [(one.lags, factor * running_integral(one.lags, one.values[:, None])[:, 0]) for one in shears]
    for k, (one, (lags, values)) in enumerate(zip(shears, grown, strict=True)):
        banded(axes, k, lags[1:], values[1:], None, _short(one))
    same = all(np.array_equal(lags, grown[0][0]) for lags, _ in grown)
    columns, head = [grown[0][0]], [axis_label("lag", run.units.of("time"))]
    if same and len(grown) > 1:
        mean = np.mean([values for _, values in grown], axis=0)
        banded(axes, len(grown), grown[0][0][1:], mean[1:], None, "mean")
        columns, head = [*columns, mean], [*head, "mean"]
    if math.isfinite(found.error):
        last = max(float(lags[-1]) for lags, _ in grown)
        axes.errorbar([last], [found.value], [found.error], color="black", capsize=4, fmt="none", linewidth=1.2)
    axes.axhline(0.0, color="black", linewidth=0.6, zorder=1)
    axes.set_xscale("log")
    unit = "" if found.units == "reduced" else found.units
    axes.set_xlabel(axis_label("lag", run.units.of("time")))
    axes.set_ylabel(axis_label("integral up to the lag", unit))
    legend(axes)
    average = with_error(Average(found.value, found.error, 1))
    few = "" if math.isfinite(found.error) else " (too few samples for an error)"
    words = (
        f"Viscosity {average}{unit and ' ' + unit}{few}: V/(k_B T) ∫⟨σ(0) σ(t)⟩ dt up to the longest lag, "
        f"{_source(run)}. It is right where the curves have levelled off; later lags add noise alone."
    )
    if same:
        columns, head = [*columns, *(values for _, values in grown)], [*head, *map(_short, shears)]
    return Drawing("viscosity", "Viscosity", figure, words, table_of(head, columns, 16))


def others(run: Run) -> Drawing | None:
    """Every other correlation function, over the logarithm of the lag."""
    shown = _drawable(one for one in _of(run) if not _SHEAR.fullmatch(one.name))[:STYLES]
    if not shown:
        return None
    figure, (axes,) = new_axes()
    for k, one in enumerate(shown):
        error = None if one.errors is None else one.errors[1:]
        banded(axes, k, one.lags[1:], one.values[1:], error, _short(one))
    axes.set_xscale("log")
    axes.set_xlabel(axis_label("lag", run.units.of("time")))
    axes.set_ylabel(axis_label("⟨A(0) B(t)⟩", _squared(run)))
    legend(axes)
    words = [
        f"Correlations of other components of the stress, {_source(run)}, the lag logarithmic; means are left in.",
        _at_zero(run, shown),
    ]
    if any(one.errors is not None for one in shown):
        words.append("Bands: standard errors.")
    words += _left_out(run, shown, lambda one: not _SHEAR.fullmatch(one.name))
    return Drawing("correlations", "Correlations of the stress", figure, " ".join(words), _table(run, shown))


def _of(run: Run) -> Sequence[Correlation]:
    return run.correlations.correlations if run.correlations is not None else ()


def _drawable(found: Iterable[Correlation]) -> list[Correlation]:
    """Those with two points at least, all of them numbers."""
    return [one for one in found if len(one.lags) > 2 and bool(np.isfinite(one.values).all())]


def _factor(found: Derived, shears: Sequence[Correlation]) -> float | None:
    """V/(k_B T) as the file has it: what makes the components of the viscosity of the integrals."""
    totals = np.array([running_integral(one.lags, one.values[:, None])[-1, 0] for one in shears])
    squares = float(totals @ totals)
    return float(totals @ np.asarray(found.components)) / squares if squares > 0.0 else None


def _short(one: Correlation) -> str:
    left, _, right = one.name.replace("stress_", "").partition("-")
    return f"σ_{left}" if left == right else f"σ_{left} with σ_{right}"


def _squared(run: Run) -> str:
    unit = run.units.of("pressure")
    return f"{unit}²" if unit else ""


def _source(run: Run) -> str:
    return f"from {run.correlations_file}"


def _at_zero(run: Run, shown: Sequence[Correlation]) -> str:
    told = ", ".join(f"{_short(one)} {one.values[0]:.4g}" for one in shown)
    unit = _squared(run)
    return f"At lag 0, which is not drawn: {told}{unit and ' ' + unit}."


def _left_out(run: Run, shown: Sequence[Correlation], of_figure: Callable[[Correlation], bool]) -> list[str]:
    missing = [one.name for one in _of(run) if of_figure(one) and all(one is not other for other in shown)]
    return [f"Not drawn, too short or not finite or one too many: {', '.join(missing)}."] if missing else []


def _table(run: Run, shown: Sequence[Correlation]) -> Table | None:
    lags = shown[0].lags
    if any(not np.array_equal(one.lags, lags) for one in shown):
        return None
    head, columns = [axis_label("lag", run.units.of("time"))], [lags]
    for one in shown[:4]:
        head, columns = [*head, _short(one)], [*columns, one.values]
        if one.errors is not None:
            head, columns = [*head, "error"], [*columns, one.errors]
    return table_of(head, columns, 16)
