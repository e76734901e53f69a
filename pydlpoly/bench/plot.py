"""A picture of the results: rates by scene and contender."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pydlpoly.bench.results import Report
from pydlpoly.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def new_figure(path: Path, width: float, height: float) -> Figure:
    """Return an empty figure of this size in inches. Raises InputError when matplotlib is missing."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise InputError("a plot needs matplotlib: pip install matplotlib", path=str(path)) from None
    return Figure(figsize=(width, height), layout="constrained")


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure; the name's ending says the format. See ``write_plot`` for the errors."""
    try:
        figure.savefig(path)
    except ValueError as error:
        raise InputError(f"cannot be drawn: {error}", path=str(path)) from error
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", path=str(path)) from error


def write_plot(report: Report, path: Path) -> None:
    """Draw the rates with their quartiles as bars; the name's ending says the format (.png, .svg, .pdf).

    Raises:
        InputError: matplotlib is missing, it does not know the format, or the file cannot be written.
    """
    rows = [(scene.name, one) for scene in report.scenes for one in scene.contenders]
    figure = new_figure(path, 8.0, 1.2 + 0.32 * len(rows))
    axes = figure.subplots()
    labels = list(dict.fromkeys(one.label for _, one in rows))
    for place, (_, one) in enumerate(rows):
        rate = one.rate
        error = [[(rate.median - rate.low) / 1e6], [(rate.high - rate.median) / 1e6]]
        axes.barh(place, rate.median / 1e6, xerr=error, color=f"C{labels.index(one.label) % 10}", capsize=3)
    axes.set_yticks(range(len(rows)), [f"{name}\n{one.label}" for name, one in rows], fontsize=7)
    axes.invert_yaxis()
    axes.set_xlabel(f"million bead-steps a second\n{report.machine.text()}", fontsize=7)
    save_figure(figure, path)
