"""Pictures of averages in bins: profiles along one axis as curves with bands, maps over two as images."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pydlpoly.analysis.profile import curves_of, labelled
from pydlpoly.analysis.writing import draw
from pydlpoly.bench.plot import new_figure, save_figure
from pydlpoly.errors import InputError
from pydlpoly.formats.binned_table import BinnedTable


def plot_table(table: BinnedTable, path: Path, quantities: Sequence[str] = ()) -> None:
    """Draw a table as ``plot_profile`` or ``plot_map``, by its number of axes."""
    plot = plot_profile if len(table.axes) == 1 else plot_map
    plot(table, path, quantities)


def plot_profile(table: BinnedTable, path: Path, quantities: Sequence[str] = ()) -> None:
    """Draw profiles along one axis, one panel a quantity; bands are two standard errors wide.

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
    names = _chosen(table, quantities)
    draw(path, [curve for curve in curves_of(table) if curve.name in names])


def plot_map(table: BinnedTable, path: Path, quantities: Sequence[str] = ()) -> None:
    """Draw maps over two axes, one panel a quantity; bins that never held a bead stay blank. As ``plot_profile``."""
    if len(table.axes) != 2:
        raise InputError("averages along one axis are a profile, not a map", path=str(path))
    names = _chosen(table, quantities)
    across, along = table.centres
    figure = new_figure(path, 6.0, 4.5 * len(names))
    for place, name in enumerate(names, 1):
        axes = figure.add_subplot(len(names), 1, place)
        image = axes.pcolormesh(across, along, table[name].T, shading="nearest")
        axes.set_aspect("equal")
        axes.set_xlabel(labelled(table, table.axes[0]))
        axes.set_ylabel(labelled(table, table.axes[1]))
        figure.colorbar(image, ax=axes, label=labelled(table, name))
    save_figure(figure, path)


def _chosen(table: BinnedTable, quantities: Sequence[str]) -> tuple[str, ...]:
    for name in quantities:
        if name not in table.values:
            raise InputError(f"is not in the table; expected some of {', '.join(table.values)}", word=name)
    return tuple(quantities) or tuple(table.values)
