"""Figures of averages in bins: the profiles of PROFILE and the maps of MAP, a group of quantities each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pydlpoly.analysis.profile import labelled
from pydlpoly.analysis.profile_plot import (
    curve_label,
    draw_map,
    draw_profiles,
    group_of,
    grouped,
    map_height,
    panels_of,
    to_scale,
)
from pydlpoly.drawing import HEIGHT, STYLES, WIDTH, new_axes
from pydlpoly.formats.binned_table import BinnedTable
from pydlpoly.report.collect import Run
from pydlpoly.report.style import Drawing, Table, table_of

MOST_MAPS = 16
_TITLES = {
    "density": "density",
    "mass-density": "mass density",
    "velocity": "velocity",
    "temperature": "temperature",
    "concentration": "concentrations",
    "local-density": "local density",
    "other": "averages",
}
_MEANING = {
    "density": "Number density",
    "mass-density": "Mass density",
    "velocity": "Mean velocity of the mobile beads",
    "temperature": "Temperature",
    "concentration": "Mean amount of dissolved species a bead",
    "local-density": "Mean local density",
    "other": "Averages",
}


def profile(run: Run, group: str) -> Drawing | None:
    """One group of quantities of PROFILE along its axis."""
    table = run.bead_profile
    names = _members(table, group)
    if table is None or not names:
        return None
    axis = table.axes[0]
    rows = panels_of(names[: 2 * STYLES], STYLES)
    figure, axes_of = new_axes(HEIGHT if len(rows) == 1 else 0.4 + 2.3 * len(rows), len(rows))
    for axes, row in zip(axes_of, rows, strict=True):
        draw_profiles(axes, table, row)
    axes_of[-1].set_xlabel(labelled(table, axis))
    known = any(np.isfinite(table.errors[name]).any() for name in names if name in table.errors)
    words = [
        f"{_MEANING[group]} along {axis} in {len(table.centres[0])} bins, from {run.profile_file}, "
        f"{_samples(table)}: {_ranges(table, group, names)}.",
        "Bands: standard errors." if known else "The samples are too few for errors.",
        *_remarks(table, names),
    ]
    if group == "temperature" and "kinetic_temperature" in names:
        words.append("The kinetic one is relative to the mean flow of each bin.")
    head = [labelled(table, axis)]
    columns = [table.centres[0]]
    for name in names[:4]:
        label = curve_label(name, group) if len(names) > 1 else name.replace("_", " ")
        head += [label, "error"] if known else [label]
        columns += [table[name], table.errors[name]] if known and name in table.errors else [table[name]]
    title = f"Profile: {_TITLES[group]}"
    return Drawing(f"profile-{group}", title, figure, " ".join(words), table_of(head, columns, 16))


def averages_in_plane(run: Run, quantity: str) -> Drawing | None:
    """One quantity of MAP over its plane."""
    table = run.bead_map
    group = group_of(quantity)
    if table is None or quantity not in _members(table, group):
        return None
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, map_height(table)), layout="constrained")
    levels = draw_map(figure, figure.subplots(), table, quantity)
    bins = " x ".join(str(len(middles)) for middles in table.centres)
    word = quantity.replace("_", " ")
    meaning = f"{_MEANING[group]} ({word})" if word.lower() != _MEANING[group].lower() else _MEANING[group]
    words = [
        f"{meaning} in the plane of {' and '.join(table.axes)} in {bins} bins, from {run.map_file}, {_samples(table)}: "
        f"{np.nanmin(table[quantity]):.4g} to {np.nanmax(table[quantity]):.4g}{_unit(table, quantity)}. "
        "Pale is low, dark is high.",
        "Lines are contours with their values, drawn through means of neighbouring bins."
        if len(levels)
        else "No contours: means of neighbouring bins vary no more than those of chance would.",
        *([] if to_scale(table) else ["The axes have different scales."]),
        *_remarks(table, [quantity]),
    ]
    left = len(maps_of(run)) - MOST_MAPS
    if left > 0 and quantity == maps_of(run)[MOST_MAPS - 1]:
        words.append(f"{left} more quantities are not drawn.")
    return Drawing(f"map-{quantity}", f"Map: {word}", figure, " ".join(words), _extremes(table, quantity))


def maps_of(run: Run) -> list[str]:
    """Return the quantities of MAP that can be drawn."""
    if run.bead_map is None:
        return []
    return [name for group in grouped(run.bead_map) for name in _members(run.bead_map, group)]


def _members(table: BinnedTable | None, group: str) -> Sequence[str]:
    """Quantities of the group that say something: no masses that are all alike, no quantity without a number."""
    if table is None:
        return ()
    names = [name for name in grouped(table).get(group, ()) if np.isfinite(table[name]).any()]
    if group == "mass-density" and "number_density" in table.values:
        number, mass = table["number_density"], table["mass_density"]
        if np.allclose(mass * number.sum(), number * mass.sum(), rtol=1e-6):
            return ()
    return names


def _samples(table: BinnedTable) -> str:
    return f"{table.samples} {'sample' if table.samples == 1 else 'samples'}"


def _unit(table: BinnedTable, name: str) -> str:
    label = labelled(table, name)
    return f" {label[label.index('(') + 1 : -1]}" if "(" in label else ""


def _ranges(table: BinnedTable, group: str, names: Sequence[str]) -> str:
    told = [
        f"{curve_label(name, group)} {np.nanmin(table[name]):.4g} to {np.nanmax(table[name]):.4g}"
        for name in names[: 2 * STYLES]
    ]
    return ", ".join(told) + _unit(table, names[0])


def _remarks(table: BinnedTable, names: Sequence[str]) -> list[str]:
    """What a reader would not see: bins without beads, and beads outside the bins."""
    words = []
    empty = max(int(np.count_nonzero(~np.isfinite(table[name]))) for name in names)
    if empty:
        words.append(f"{empty} {'bin' if empty == 1 else 'bins'} never held a bead and {_have(empty)} no mean.")
    if table.outside > 0.0:
        words.append(f"{table.outside:.3g} beads of a sample were outside the bins.")
    return words


def _have(count: int) -> str:
    return "has" if count == 1 else "have"


def _extremes(table: BinnedTable, quantity: str) -> Table:
    """Lowest, mean and highest value of a map, and where."""
    values = table[quantity]
    cells = []
    for find in (np.nanargmin, np.nanargmax):
        place = np.unravel_index(int(find(values)), values.shape)
        at = ", ".join(f"{middles[k]:.3g}" for middles, k in zip(table.centres, place, strict=True))
        cells.append(f"{values[place]:.5g} at ({at})")
    head = ("lowest", "mean of the bins", "highest")
    return Table(head, ((cells[0], f"{np.nanmean(values):.5g}", cells[1]),))
