"""How figures are drawn: colours that the colour-blind tell apart, line styles and markers that do without.

Pictures of analyses and those of reports look alike by this; matplotlib is imported only when something is drawn.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from pydlpoly.formats.records import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

WIDTH = 4.5  # inches: in a narrow window, letters keep their size
HEIGHT = 3.1
_POINTS = 400
_LETTERS = 55  # of a legend in one row
# Okabe and Ito's palette without its light colours, from dark to less dark and back.
_LINES = (
    ("#0072B2", "-", "o"),
    ("#D55E00", (0, (5, 1.5)), "s"),
    ("#009E73", (0, (1, 1.2)), "^"),
    ("#000000", (0, (6, 1.5, 1, 1.5)), "D"),
    ("#A6548B", (0, (3, 1, 1, 1, 1, 1)), "v"),
    ("#8A6000", (0, (9, 3)), "P"),
)
STYLES = len(_LINES)
_SHADES = 64
FAINT, BAND = "#7a8794", "#9fc4de"


@contextmanager
def look() -> Iterator[None]:
    """Have matplotlib draw in our way inside this block."""
    import matplotlib

    settings: dict[Any, Any] = {
        "font.family": "sans-serif",
        "font.size": 10.0,
        "axes.labelsize": 10.0,
        "xtick.labelsize": 9.5,
        "ytick.labelsize": 9.5,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.linewidth": 0.7,
        "axes.grid": True,
        "axes.axisbelow": True,
        "grid.color": "#e3e7eb",
        "grid.linewidth": 0.6,
        "axes.formatter.useoffset": False,
        "axes.formatter.limits": (-4, 5),
        "legend.fontsize": 9.5,
        "legend.frameon": False,
        "legend.handlelength": 2.8,
        "lines.linewidth": 1.6,
        "lines.markersize": 4.0,
        "svg.fonttype": "none",  # letters stay letters: small, searchable, read aloud
        "svg.hashsalt": "pydlpoly",
        "path.simplify_threshold": 0.2,
    }
    with matplotlib.rc_context(settings):
        yield


def new_axes(height: float = HEIGHT, rows: int = 1) -> tuple[Figure, list[Axes]]:
    """Return a figure of our width with axes below each other that share x."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False)
    return figure, list(axes[:, 0])


def line(axes: Axes, k: int, x: FloatArray, y: FloatArray, label: str, *, points: bool = False) -> None:
    """Draw curve number ``k``: its own colour, dashes and markers, which ``points`` puts on every point."""
    colour, dashes, marker = _LINES[k % STYLES]
    x, y = thinned(x, y)
    every = 1 if points else max(1, len(x) // 8)
    start = (k * every // STYLES) % max(1, len(x))
    axes.plot(x, y, color=colour, linestyle=dashes, marker=marker, markevery=(start, every), label=label)


def banded(
    axes: Axes, k: int, x: FloatArray, y: FloatArray, error: FloatArray | None, label: str, *, points: bool = False
) -> None:
    """Draw curve number ``k`` over a band of its standard errors, where they are known."""
    if error is not None and np.isfinite(error).any():
        axes.fill_between(x, y - error, y + error, color="#c9ced4", alpha=0.6, linewidth=0.0)
    line(axes, k, x, y, label, points=points)


def legend(axes: Axes) -> None:
    """Put the legend above the axes, where it hides nothing, in as many columns as have room."""
    _, labels = axes.get_legend_handles_labels()
    columns = columns_of(labels, 9)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.2, columnspacing=1.2)


def columns_of(labels: Sequence[str], handle: int) -> int:
    """Return how many columns of a legend have room, a handle being as wide as so many letters."""
    sizes = [len(label) + handle for label in labels]
    fits = (n for n in range(1, 1 + len(sizes)) if sum(int(max(p)) for p in np.array_split(sizes, n)) <= _LETTERS)
    return max(fits, default=1)  # columns as matplotlib fills them


def thinned(x: FloatArray, y: FloatArray, most: int = _POINTS) -> tuple[FloatArray, FloatArray]:
    """Return at most so many points of a curve, smallest and largest of each stretch among them."""
    if len(x) <= most:
        return x, y
    keep = {0, len(x) - 1}
    for part in np.array_split(np.arange(len(x)), most // 2):
        values = np.where(np.isfinite(y[part]), y[part], -np.inf)
        keep |= {int(part[np.argmin(values)]), int(part[np.argmax(values)])}
    chosen = sorted(keep)
    return x[chosen], y[chosen]


def by_lightness() -> Colormap:
    """Return colours from pale to dark, so that they are in order also where colours cannot be seen."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    return ListedColormap(colormaps["YlGnBu"](np.linspace(0.05, 0.85, _SHADES)))


def axis_label(text: str, unit: str) -> str:
    """Return a label with its unit."""
    return f"{text} ({unit})" if unit else text
