"""Pictures of averages in bins: profiles along one axis as curves with bands, maps over two as shaded fields.

What belongs together is one group and one picture: densities, velocities, temperatures, concentrations.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pydlpoly.analysis.profile import labelled
from pydlpoly.bench.plot import new_figure, save_figure
from pydlpoly.drawing import HEIGHT, STYLES, WIDTH, banded, by_lightness, legend, look
from pydlpoly.errors import InputError
from pydlpoly.formats.binned_table import BinnedTable
from pydlpoly.formats.records import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GROUPS = ("density", "mass-density", "velocity", "temperature", "concentration", "local-density", "other")
"""What can be one picture, in the order of the files."""
_WORDS = {
    "density": "number density",
    "mass-density": "mass density",
    "local-density": "local density",
    "other": "average",
}
_PREFIXES = {"number_density": "density", "velocity_": "velocity", "concentration_": "concentration"}
_SINGLE = {
    "mass_density": "mass-density",
    "kinetic_temperature": "temperature",
    "temperature": "temperature",
    "local_density": "local-density",
}
_LINES, _BLOCKS = 5, 12  # contour levels; parts of a map along each axis that contours are drawn through
_FLATTEST, _TALLEST = 0.4, 1.6  # height over width of a map
_STRUCTURE = 2.0  # by how much more means of parts must vary than those of independent bins would


def group_of(quantity: str) -> str:
    """Return which of ``GROUPS`` a quantity belongs to."""
    found = (group for prefix, group in _PREFIXES.items() if quantity.startswith(prefix))
    return _SINGLE.get(quantity) or next(found, "other")


def grouped(table: BinnedTable, quantities: Sequence[str] = ()) -> dict[str, tuple[str, ...]]:
    """Return the table's quantities by group, in the order of ``GROUPS``. Raises InputError for one it lacks."""
    names = _chosen(table, quantities)
    groups = {group: tuple(name for name in names if group_of(name) == group) for group in GROUPS}
    return {group: members for group, members in groups.items() if members}


def curve_label(quantity: str, group: str) -> str:
    """Return what a curve is called beside others of its group."""
    if quantity == "number_density":
        return "all beads"
    if quantity == "temperature":
        return "internal"
    short = quantity.removeprefix("number_density_").removeprefix("velocity_").removeprefix("concentration_")
    return "kinetic" if group == "temperature" else short.replace("_", " ")


def draw_profiles(axes: Axes, table: BinnedTable, names: Sequence[str]) -> None:
    """Draw profiles of one group, at most six, over bands of their standard errors."""
    group, place = group_of(names[0]), table.centres[0]
    for k, name in enumerate(names):
        banded(axes, k, place, table[name], table.errors.get(name), curve_label(name, group))
    one = len(names) == 1
    axes.set_ylabel(labelled(table, names[0]) if one else _with_unit(table, names[0], _WORDS.get(group, group)))
    if not one:
        legend(axes)


def draw_map(figure: Figure, axes: Axes, table: BinnedTable, name: str) -> FloatArray:
    """Draw a map, pale where it is low and dark where it is high, with labelled contour lines; return their levels.

    Contours go through means of neighbouring bins, and there are none where these differ by no more than chance has
    bins differ. Bins that never held a bead are hatched.
    """
    from matplotlib.ticker import MaxNLocator

    values = table[name]
    across, along = table.centres
    axes.set_facecolor("#f4f6f8")
    axes.patch.set_hatch("xxx")
    axes.patch.set_edgecolor("#c9ced4")
    shown = np.ma.masked_invalid(values.T)
    image = axes.pcolormesh(across, along, shown, shading="nearest", cmap=by_lightness(), rasterized=True)
    axes.set_aspect("equal" if to_scale(table) else "auto")
    axes.grid(visible=False)
    axes.set_xlabel(labelled(table, table.axes[0]))
    upwards = labelled(table, table.axes[1])
    axes.set_ylabel(upwards, rotation="vertical" if len(upwards) > 1 else "horizontal")
    bar = figure.colorbar(image, ax=axes, location="top", label=labelled(table, name), aspect=40, pad=0.02)
    bar.locator = MaxNLocator(5)
    bar.update_ticks()
    return _contours(axes, table, values)


def map_height(table: BinnedTable) -> float:
    """Return how many inches high one map is in a figure of our width."""
    return 1.25 + 0.83 * WIDTH * min(max(_shape(table), _FLATTEST), _TALLEST)


def to_scale(table: BinnedTable) -> bool:
    """Return whether a map is drawn with the same scale along both axes; long narrow ones are not."""
    return _FLATTEST <= _shape(table) <= _TALLEST


def _shape(table: BinnedTable) -> float:
    """Height over width."""
    wide, high = (float(np.ptp(middles)) * len(middles) / max(len(middles) - 1, 1) for middles in table.centres)
    return high / wide if wide > 0.0 else 1.0


def panels_of(names: Sequence[str], most: int) -> list[tuple[str, ...]]:
    """Return names in rows of at most so many."""
    return [tuple(names[k : k + most]) for k in range(0, len(names), most)]


def plot_table(table: BinnedTable, path: Path, quantities: Sequence[str] = ()) -> None:
    """Draw a table as ``plot_profile`` or ``plot_map``, by its number of axes."""
    plot = plot_profile if len(table.axes) == 1 else plot_map
    plot(table, path, quantities)


def plot_profile(table: BinnedTable, path: Path, quantities: Sequence[str] = ()) -> None:
    """Draw profiles along one axis, one panel a group of quantities; bands are two standard errors wide.

    Args:
        table: averages in bins along one axis.
        path: the picture; its ending says the format (.png, .svg, .pdf).
        quantities: names; by default all.

    Raises:
        InputError: the table has two axes or lacks a quantity, matplotlib is missing, it does not know the
            format, or the file cannot be written.
    """
    if len(table.axes) != 1:
        raise InputError("averages over two axes are a map, not a profile", path=str(path))
    rows = [row for names in grouped(table, quantities).values() for row in panels_of(names, STYLES)]
    figure = new_figure(path, 6.0, HEIGHT * len(rows))
    with look():
        for place, row in enumerate(rows, 1):
            axes = figure.add_subplot(len(rows), 1, place)
            draw_profiles(axes, table, row)
            axes.set_xlabel(labelled(table, table.axes[0]))
        save_figure(figure, path)


def plot_map(table: BinnedTable, path: Path, quantities: Sequence[str] = ()) -> None:
    """Draw maps over two axes, one panel a quantity; bins that never held a bead are hatched. As ``plot_profile``."""
    if len(table.axes) != 2:
        raise InputError("averages along one axis are a profile, not a map", path=str(path))
    names = _chosen(table, quantities)
    figure = new_figure(path, WIDTH, map_height(table) * len(names))
    with look():
        for place, name in enumerate(names, 1):
            draw_map(figure, figure.add_subplot(len(names), 1, place), table, name)
        save_figure(figure, path)


def _chosen(table: BinnedTable, quantities: Sequence[str]) -> tuple[str, ...]:
    for name in quantities:
        if name not in table.values:
            raise InputError(f"is not in the table; expected some of {', '.join(table.values)}", word=name)
    return tuple(quantities) or tuple(table.values)


def _with_unit(table: BinnedTable, name: str, word: str) -> str:
    return labelled(table, name).replace(name.replace("_", " "), word, 1)


def _contours(axes: Axes, table: BinnedTable, values: FloatArray) -> FloatArray:
    from matplotlib.ticker import MaxNLocator

    parts = [np.array_split(np.arange(count), min(count, _BLOCKS)) for count in values.shape]
    coarse = np.array([[_mean(values[np.ix_(a, b)]) for b in parts[1]] for a in parts[0]])
    known = coarse[np.isfinite(coarse)]
    if min(coarse.shape) < 2 or len(known) < 4 or not np.ptp(known) > 0.0 or not _structured(values, coarse):
        return np.zeros(0)
    low, high = float(known.min()), float(known.max())
    levels = np.array([x for x in MaxNLocator(_LINES).tick_values(low, high) if low < x < high])
    across, along = (
        np.array([middles[part].mean() for part in rows]) for middles, rows in zip(table.centres, parts, strict=True)
    )
    if len(levels):
        lines = axes.contour(across, along, np.ma.masked_invalid(coarse.T), levels, colors="black", linewidths=0.8)
        for label in axes.clabel(lines, fontsize=8.5, fmt="%.4g"):
            label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6})
    return levels


def _structured(values: FloatArray, coarse: FloatArray) -> bool:
    """Whether means of parts vary more than those of as many independent bins would; true where a part is one bin."""
    many = values.size / coarse.size
    if many < 2.0:
        return True
    spread, known = float(np.nanvar(values)), coarse[np.isfinite(coarse)]
    return float(np.var(known)) * many > _STRUCTURE * (spread - float(np.var(known)))


def _mean(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")
