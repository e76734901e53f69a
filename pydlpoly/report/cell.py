"""Figures of the cell where it varies: its volume, and its edges and angles."""

from __future__ import annotations

import numpy as np

from pydlpoly.drawing import HEIGHT, axis_label, banded, legend, new_axes
from pydlpoly.formats.records import FloatArray
from pydlpoly.report.against_time import one_quantity
from pydlpoly.report.collect import Run
from pydlpoly.report.series import all_series
from pydlpoly.report.style import Drawing, table_of

_VARIES = 1e-9
_ANGLES = {"cell_alpha": "α", "cell_beta": "β", "cell_gamma": "γ"}
_Curves = list[tuple[str, FloatArray]]


def volume(run: Run) -> Drawing | None:
    """The volume, where it varies."""
    series = all_series(run).get("volume")
    if series is None or not _varies(series.values):
        return None
    return one_quantity(run, "volume", "Volume")


def cell(run: Run) -> Drawing | None:
    """Edges and angles of the cell, where any of them varies."""
    found = all_series(run)
    times, edges = _edges(run)
    angles = [(mark, found[name].values) for name, mark in _ANGLES.items() if name in found]
    angles = [(mark, values) for mark, values in angles if _varies(values)]
    if len(times) < 2 or not (angles or any(_varies(values) for _, values in edges)):
        return None
    same = len(edges) == 3 and all(np.allclose(values, edges[0][1], rtol=1e-12) for _, values in edges)
    shown = [("a = b = c", edges[0][1])] if same else edges
    panels = [(axis_label("edge", run.units.of("length")), shown)] if any(_varies(v) for _, v in edges) else []
    if angles:
        times_of_angles = found["cell_gamma"].times
        panels.append(("angle (°)", angles))
        times = times if len(times) == len(times_of_angles) else times_of_angles
    figure, rows = new_axes(HEIGHT if len(panels) == 1 else HEIGHT + 1.2, len(panels))
    for axes, (label, curves) in zip(rows, panels, strict=True):
        for k, (name, values) in enumerate(curves):
            banded(axes, k, times, values, None, name)
        axes.set_ylabel(label)
        legend(axes)
    rows[-1].set_xlabel(axis_label("time", run.units.of("time")))
    every = [curve for _, curves in panels for curve in curves]
    told = "; ".join(
        f"{name} {values[0]:.5g} at first, {values[-1]:.5g} at last, {values.min():.5g} to {values.max():.5g} in all"
        for name, values in every
    )
    unit = run.units.of("length")
    units = f" (edges in {unit}, angles in degrees)" if unit else " (angles in degrees)" if angles else ""
    head = [axis_label("time", run.units.of("time")), *(name for name, _ in every)]
    table = table_of(head, [times, *(values for _, values in every)])
    return Drawing("cell", "Shape of the cell", figure, f"The cell varies: {told}{units}.", table)


def _edges(run: Run) -> tuple[FloatArray, _Curves]:
    """Times, and lengths of the cell vectors, which STATIS has where a barostat acts."""
    found = all_series(run)
    names = [[f"cell_{vector}{axis}" for axis in "xyz"] for vector in "abc"]
    if all(name in found for row in names for name in row):
        lengths = [(row[0][5], np.sqrt(sum(found[name].values ** 2 for name in row))) for row in names]
        return found["cell_ax"].times, lengths
    series = found.get("cell_gamma")
    return (series.times if series is not None else np.zeros(0)), []


def _varies(values: FloatArray) -> bool:
    known = values[np.isfinite(values)]
    return len(known) > 1 and float(np.ptp(known)) > _VARIES * float(np.mean(np.abs(known)))
