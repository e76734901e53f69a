"""Pictures of the newest configuration in which shades say what beads carry: internal temperature, concentrations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pydlpoly.drawing import WIDTH, axis_label, by_lightness
from pydlpoly.formats.records import FloatArray
from pydlpoly.report.collect import Run
from pydlpoly.report.picture import (
    DISC,
    corners_of,
    height_of,
    paint_cell,
    paint_discs,
    spacing_of,
    view_of,
    wrapped,
)
from pydlpoly.report.snapshots import Snapshot
from pydlpoly.report.style import Drawing, Table
from pydlpoly.scene.beads_state import CONCENTRATION, TEMPERATURE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST = 3  # pictures below each other
_SCALE, _LABEL = 0.12, 0.55  # inches of the scale above a picture, and of its numbers and label


def by_temperature(run: Run) -> Drawing | None:
    """Beads in shades of their internal temperatures."""
    names = [TEMPERATURE] if run.carried is not None and TEMPERATURE in run.carried.values else []
    unit = run.units.of("temperature")
    return _drawing(run, names, "last-temperature", "internal temperature", unit)


def by_concentration(run: Run) -> Drawing | None:
    """Beads in shades of how much of each dissolved species they have."""
    names = [name for name in (run.carried.values if run.carried is not None else ()) if name.startswith(CONCENTRATION)]
    return _drawing(run, names, "last-concentration", "concentrations", "")


def _drawing(run: Run, names: Sequence[str], name: str, title: str, unit: str) -> Drawing | None:
    snapshot = run.carried
    if snapshot is None or not names or not run.has_output:
        return None
    finite = np.isfinite(snapshot.positions).all(axis=1)
    for one in names:
        finite &= np.isfinite(snapshot.values[one])
    if not finite.any():
        return None
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    places = wrapped(snapshot)[finite]
    corners = corners_of(snapshot, places)
    high, shown = height_of(corners), names[:_MOST]
    total = (high + _SCALE + _LABEL) * len(shown) + 0.05
    figure = Figure(figsize=(WIDTH, total))
    rows, top = [], total
    for one in shown:
        values = snapshot.values[one][finite]
        word = "internal temperature" if one == TEMPERATURE else one.removeprefix(CONCENTRATION)
        scale = figure.add_axes((0.06, (top - _LABEL - _SCALE) / total, 0.88, _SCALE / total))
        axes = figure.add_axes((0.01, (top - _LABEL - _SCALE - high) / total, 0.98, 0.98 * high / total))
        top -= high + _SCALE + _LABEL
        low, most = _paint(axes, snapshot, places, values, corners)
        shades = ScalarMappable(Normalize(low, most), by_lightness())
        figure.colorbar(shades, cax=scale, orientation="horizontal", label=axis_label(word, unit))
        scale.xaxis.set_ticks_position("top")
        scale.xaxis.set_label_position("top")
        rows.append((word, f"{values.min():.5g}", f"{values.mean():.5g}", f"{values.max():.5g}"))
    step = "" if snapshot.step is None else f" (step {snapshot.step})"
    told = ", ".join(f"{word} {low} to {most}, mean {mean}" for word, low, mean, most in rows)
    words = [
        f"{int(finite.sum())} beads in shades of what they carry, from {snapshot.file}: {told}{unit and ' ' + unit}.",
        "Pale is low, dark is high. Only beads near the surface are seen.",
    ]
    if len(shown) < len(names):
        words.append(f"The first {len(shown)} of {len(names)} species are drawn.")
    which = "Start" if snapshot.step == 0 else "Last frame"
    table = Table(("quantity", "lowest", "mean", "highest"), tuple(rows))
    return Drawing(name, f"{which}{step}: {title}", figure, " ".join(words), table)


def _paint(
    axes: Axes, snapshot: Snapshot, places: FloatArray, values: FloatArray, corners: FloatArray
) -> tuple[float, float]:
    """Draw beads in shades of their values; return the ends of the scale."""
    view = view_of(places, np.arange(len(places)))
    spacing = spacing_of(snapshot, places)
    paint_cell(axes, view, corners, spacing)
    low, high = float(values.min()), float(values.max())
    if not high > low:
        low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
    faces = np.asarray(by_lightness()((values[view.kinds] - low) / (high - low)))[:, :3]
    widths = np.full(len(view.kinds), 2.0 * DISC * spacing)
    paint_discs(axes, view.places, widths, faces, 0.55 * faces, len(view.kinds))
    return low, high
