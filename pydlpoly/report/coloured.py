"""Pictures of the newest configuration in which shades say what beads carry: internal temperature, concentrations."""

from __future__ import annotations

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

MOST_SPECIES = 6
_SCALE, _LABEL = 0.12, 0.55  # inches of the scale above the picture, and of its numbers and label


def carried_by(run: Run) -> list[str]:
    """Return the names of what can be drawn: "temperature", "concentration_NAME"."""
    return list(run.carried.values) if run.carried is not None and run.has_output else []


def by_value(run: Run, quantity: str) -> Drawing | None:
    """Beads in shades of what they carry."""
    snapshot = run.carried
    if snapshot is None or quantity not in carried_by(run):
        return None
    finite = np.isfinite(snapshot.positions).all(axis=1) & np.isfinite(snapshot.values[quantity])
    if not finite.any():
        return None
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    places, values = wrapped(snapshot)[finite], snapshot.values[quantity][finite]
    corners = corners_of(snapshot, places)
    high = height_of(corners)
    total = high + _SCALE + _LABEL
    figure = Figure(figsize=(WIDTH, total))
    scale = figure.add_axes((0.06, high / total, 0.88, _SCALE / total))
    axes = figure.add_axes((0.01, 0.0, 0.98, 0.98 * high / total))
    low, most = _paint(axes, snapshot, places, values, corners)
    warm = quantity == TEMPERATURE
    word = "internal temperature" if warm else f"concentration of {quantity.removeprefix(CONCENTRATION)}"
    unit = run.units.of("temperature") if warm else ""
    shades = ScalarMappable(Normalize(low, most), by_lightness())
    figure.colorbar(shades, cax=scale, orientation="horizontal", label=axis_label(word, unit), ticks=MaxNLocator(5))
    scale.xaxis.set_ticks_position("top")
    scale.xaxis.set_label_position("top")
    told = (f"{values.min():.5g}", f"{values.mean():.5g}", f"{values.max():.5g}")
    words = [
        f"{int(finite.sum())} beads in shades of what they carry, from {snapshot.file}: {word} {told[0]} to {told[2]}, "
        f"mean {told[1]}{unit and ' ' + unit}. Pale is low, dark is high; only beads near the surface are seen."
    ]
    drawn, left = carried_by(run)[:MOST_SPECIES], len(carried_by(run)) - MOST_SPECIES
    if left > 0 and quantity == drawn[-1]:
        words.append(f"{left} more species are not drawn.")
    step = "" if snapshot.step is None else f" (step {snapshot.step})"
    title = f"{'Start' if snapshot.step == 0 else 'Last frame'}{step}: {word}"
    table = Table(("lowest", "mean", "highest"), (told,))
    return Drawing(f"last-{quantity}", title, figure, " ".join(words), table)


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
