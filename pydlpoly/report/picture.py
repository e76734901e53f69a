"""Pictures of configurations in parallel projection: beads as discs, far ones first and paler, and the cell's edges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pydlpoly.drawing import WIDTH, columns_of
from pydlpoly.formats.records import FloatArray, IntArray
from pydlpoly.report.collect import Run
from pydlpoly.report.snapshots import Snapshot
from pydlpoly.report.style import Drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_BEADS = 50_000
_TURN, _TILT = np.radians(28.0), np.radians(14.0)
_PALEST = 0.6  # how far the colour of the farthest beads goes towards white
_HANDLE = 8  # letters that a disc of the legend is wide, with the room about it
DISC = 0.46  # radius in units of the mean distance of beads, (V/N)^(1/3)
# Colour of a bead and of the mark on it: told apart by lightness, and by the mark where colours cannot be seen.
_COLOURS = ("#0072B2", "#F0C45A", "#D55E00", "#7FD1B0", "#5A3A72", "#BFC7CE", "#8A1F3D", "#EFB6D0")
_MARKS = ("", "dot", "ring", "dot", "", "ring", "dot", "ring")


@dataclass(frozen=True, eq=False)
class View:
    """Beads as the viewer sees them, the farthest first: (n,) species, (n, 2) places, (n,) nearness from 0 to 1."""

    kinds: IntArray
    places: FloatArray
    near: FloatArray


def last_frame(run: Run) -> Drawing | None:
    """The newest configuration there is."""
    if run.last is None or not run.has_output:
        return None
    step = "" if run.last.step is None else f" (step {run.last.step})"
    return _drawing(run, run.last, "last", f"Last frame{step}")


def start_frame(run: Run) -> Drawing | None:
    """The start configuration."""
    if run.start is None:
        return None
    known = run.start.step
    return _drawing(run, run.start, "start", "Start" if known in (0, None) else f"First frame (step {known})")


def hidden_species(run: Run, snapshot: Snapshot) -> str | None:
    """Return the species that hides the others: the most abundant of single beads that are mobile and uncharged.

    None when no other species moves, as with a liquid on a wall, or when it is not known which beads are single ones.
    """
    scene = run.scene
    if scene is None or scene.bead_count != len(snapshot.kinds):
        return None
    beads = scene.beads
    alone = np.bincount(beads.molecule)[beads.molecule] == 1
    plain = alone & ~beads.frozen & (beads.charge == 0.0)
    amounts = np.bincount(beads.species, minlength=len(scene.species))
    candidates = [k for k in range(len(amounts)) if amounts[k] and bool(plain[beads.species == k].all())]
    if not candidates:
        return None
    found = max(candidates, key=lambda k: amounts[k])
    return scene.species[found] if bool(((beads.species != found) & ~beads.frozen).any()) else None


def _drawing(run: Run, snapshot: Snapshot, name: str, title: str) -> Drawing | None:
    finite = np.isfinite(snapshot.positions).all(axis=1)
    if not finite.any():
        return None
    hidden = hidden_species(run, snapshot)
    shown = finite.copy()
    if hidden is not None and hidden in snapshot.species:
        shown &= snapshot.kinds != snapshot.species.index(hidden)
    places = wrapped(snapshot)
    view = view_of(places[shown], snapshot.kinds[shown])
    drawn = len(view.kinds)
    corners = corners_of(snapshot, places[finite])
    present = [k for k in range(len(snapshot.species)) if np.any(view.kinds == k)]
    names = [snapshot.species[k] for k in present]
    columns = columns_of(names, _HANDLE)
    figure, axes = _figure(corners, 0.12 + 0.23 * -(-len(names) // columns))
    _paint(axes, snapshot, view, corners, spacing_of(snapshot, places[finite]))
    _legend(axes, names, present, columns)
    amounts = ", ".join(f"{int(np.sum(snapshot.kinds == k))} {name}" for k, name in enumerate(snapshot.species))
    words = [f"{len(snapshot.kinds)} beads: {amounts}; from {snapshot.file}. The lines are the cell's edges."]
    if hidden is not None:
        words.append(f"{hidden}, the most abundant species of single beads, is not drawn.")
    if drawn < int(shown.sum()):
        words.append(f"Of {int(shown.sum())} beads the {drawn} nearest to the viewer are drawn.")
    if not finite.all():
        words.append(f"{int((~finite).sum())} beads have no finite position.")
    return Drawing(name, title, figure, " ".join(words))


def wrapped(snapshot: Snapshot) -> FloatArray:
    """Return positions inside the cell around the origin, (N, 3), along its periodic axes."""
    axes = np.array(snapshot.periodic)
    if not axes.any() or not abs(np.linalg.det(snapshot.cell)) > 0.0:
        return snapshot.positions
    inside = snapshot.positions @ np.linalg.inv(snapshot.cell)
    inside[:, axes] -= np.floor(inside[:, axes] + 0.5)
    return np.asarray(inside @ snapshot.cell)


def _axes_of_view() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Unit vectors to the right, up, and towards the viewer, who looks from the front, from the right and above."""
    right = np.array([np.cos(_TURN), np.sin(_TURN), 0.0])
    front = np.array([np.sin(_TURN), -np.cos(_TURN), 0.0])
    towards = np.cos(_TILT) * front + np.sin(_TILT) * np.array([0.0, 0.0, 1.0])
    return right, np.cross(towards, right), towards


def view_of(places: FloatArray, kinds: IntArray) -> View:
    """Return (n, 3) beads as the viewer sees them, at most ``MOST_BEADS``, the nearest ones."""
    right, up, towards = _axes_of_view()
    depth = places @ towards
    order = np.argsort(depth, kind="stable")[-MOST_BEADS:]
    flat = np.stack([places @ right, places @ up], axis=1)[order]
    span = float(np.ptp(depth[order])) if len(order) else 0.0
    near = (depth[order] - depth[order].min()) / span if span > 0.0 else np.ones(len(order))
    return View(kinds[order], flat, near)


def corners_of(snapshot: Snapshot, places: FloatArray) -> FloatArray:
    """The cell's corners, (8, 3): corner number abc in binary; those around all beads where there is no cell."""
    if abs(np.linalg.det(snapshot.cell)) > 0.0:
        factors = np.array([[k >> 2 & 1, k >> 1 & 1, k & 1] for k in range(8)]) - 0.5
        return np.asarray(factors @ snapshot.cell)
    low, high = places.min(axis=0), places.max(axis=0)
    factors = np.array([[k >> 2 & 1, k >> 1 & 1, k & 1] for k in range(8)])
    return np.asarray(low + factors * (high - low))


def spacing_of(snapshot: Snapshot, places: FloatArray) -> float:
    """Return the mean distance of beads, (V/N)^(1/3)."""
    volume = abs(float(np.linalg.det(snapshot.cell))) or float(np.prod(np.ptp(places, axis=0) + 1e-9))
    return float(max(volume / len(snapshot.kinds), 1e-30) ** (1.0 / 3.0))


def height_of(corners: FloatArray) -> float:
    """Return how many inches high a cell is in a picture of our width."""
    right, up, _ = _axes_of_view()
    wide, high = float(np.ptp(corners @ right)), float(np.ptp(corners @ up))
    return WIDTH * min(max(high / max(wide, 1e-30), 0.4), 1.6)


def _figure(corners: FloatArray, below: float) -> tuple[Figure, Axes]:
    """A figure in the shape of the cell as it is seen, with so many inches below for the legend."""
    from matplotlib.figure import Figure

    above = height_of(corners)
    figure = Figure(figsize=(WIDTH, above + below))
    return figure, figure.add_axes((0.01, below / (above + below), 0.98, 0.99 * above / (above + below)))


def _paint(axes: Axes, snapshot: Snapshot, view: View, corners: FloatArray, spacing: float) -> None:
    """Beads in the colours and with the marks of their species."""
    from matplotlib.colors import to_rgb

    paint_cell(axes, view, corners, spacing)
    if not len(view.places):
        return
    base = np.array([to_rgb(_COLOURS[k % len(_COLOURS)]) for k in range(len(snapshot.species))])
    pale = (_PALEST * (1.0 - view.near))[:, None]
    faces = base[view.kinds] * (1.0 - pale) + pale
    rims = 0.55 * base[view.kinds] * (1.0 - pale) + 0.85 * pale
    widths, colours, lines = _with_marks(view.kinds, faces, rims, 2.0 * DISC * spacing)
    offsets = np.repeat(view.places, 2, axis=0)
    keep = widths > 0.0
    paint_discs(axes, offsets[keep], widths[keep], colours[keep], lines[keep], len(view.kinds))


def paint_cell(axes: Axes, view: View, corners: FloatArray, spacing: float) -> None:
    """Draw the cell's edges, those behind the beads dashed, and have the axes hold cell and beads."""
    from matplotlib.collections import LineCollection

    right, up, towards = _axes_of_view()
    flat = np.stack([corners @ right, corners @ up], axis=1)
    axes.set_aspect("equal")
    axes.axis("off")
    margin = DISC * spacing
    low, high = flat.min(axis=0), flat.max(axis=0)
    if len(view.places):
        low, high = np.minimum(low, view.places.min(axis=0)), np.maximum(high, view.places.max(axis=0))
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    edges = [(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b) in (1, 2, 4)]
    farthest = int(np.argmin(corners @ towards))
    behind = [flat[[a, b]] for a, b in edges if farthest in (a, b)]
    before = [flat[[a, b]] for a, b in edges if farthest not in (a, b)]
    axes.add_collection(LineCollection(behind, colors="#667380", linewidths=0.8, linestyles="dashed", zorder=1))
    axes.add_collection(LineCollection(before, colors="#1d2731", linewidths=0.9, zorder=3))


def paint_discs(
    axes: Axes, places: FloatArray, widths: FloatArray, faces: FloatArray, rims: FloatArray, beads: int
) -> None:
    """Draw discs at (n, 2) places, one over the other in their order, as one picture of pixels."""
    from matplotlib.collections import EllipseCollection

    discs = EllipseCollection(
        widths,
        widths,
        np.zeros(len(widths)),
        units="xy",
        facecolors=faces,
        edgecolors=rims,
        linewidths=0.5 if beads < 8000 else 0.25,
        offsets=places,
        offset_transform=axes.transData,
        zorder=2,
    )
    discs.set_rasterized(True)
    axes.add_collection(discs)


def _with_marks(
    kinds: IntArray, faces: FloatArray, rims: FloatArray, width: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Widths, face and rim colours of a disc and its mark for each bead; the mark has width 0 where there is none."""
    marks = np.array([_MARKS[k % len(_MARKS)] for k in range(int(kinds.max()) + 1)])[kinds]
    size = np.select([marks == "dot", marks == "ring"], [0.32, 0.5], 0.0)
    widths = np.stack([np.full(len(kinds), width), size * width], axis=1).ravel()
    inside = np.where((marks == "dot")[:, None], rims, faces)
    colours = np.stack([faces, inside], axis=1).reshape(-1, 3)
    return widths, colours, np.repeat(rims, 2, axis=0)


def _legend(axes: Axes, names: list[str], kinds: list[int], columns: int) -> None:
    """Discs as in the picture, below it."""
    from matplotlib.colors import to_rgb
    from matplotlib.lines import Line2D

    handles: list[tuple[Line2D, ...]] = []
    for k in kinds:
        colour, mark = _COLOURS[k % len(_COLOURS)], _MARKS[k % len(_MARKS)]
        red, green, blue = to_rgb(colour)
        rim = (0.55 * red, 0.55 * green, 0.55 * blue)
        disc = Line2D([], [], linestyle="", marker="o", markersize=9, color=colour, markeredgecolor=rim)
        inner = Line2D([], [], linestyle="", marker="o", markersize=3 if mark == "dot" else 4.5, markeredgecolor=rim)
        inner.set_markerfacecolor(rim if mark == "dot" else colour)
        handles.append((disc, inner) if mark else (disc,))
    if handles:
        axes.legend(handles, names, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=columns, handletextpad=0.2)
