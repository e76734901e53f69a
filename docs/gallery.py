"""Runs the shipped examples and draws the last frame of each: docs/images/example-NAME.png.

``python docs/gallery.py`` runs all of them (a minute or two), with names only those. Beads are drawn along an axis of
the cell, the farthest first and palest. The table ``picture`` of an ``example.toml`` may say: ``steps`` (those of
CONTROL without it), ``along`` (x, y or z; y without it), ``hide`` (species that are left out), ``colour`` (``species``,
``vx``, the velocity along x, or an array that beads carry, such as ``temperature``), ``diameter`` (of a bead;
without it that of beads of the mean density).
"""

from __future__ import annotations

import io
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pydlpoly import Simulation, load
from pydlpoly.gallery import Example, gallery

IMAGES = Path(__file__).with_name("images")
COLOURS = ("#3b75af", "#d1495b", "#edae49", "#5a9367", "#8d6a9f", "#6b7a8f")
RADIUS = 0.36  # beads of a fluid of density 3 overlap a little
WIDTH, HEIGHT, DOTS = 4.6, 5.6, 100  # the most of each in inches, dots per inch
PALE = 0.6  # share of white of the farthest bead
DEEP = 3.0  # depth to which a dense fluid is seen, in mean distances of beads


def run(example: Example) -> Simulation:
    """Return the example's simulation after the steps of its picture; the seed is CONTROL's, or 1."""
    with TemporaryDirectory() as folder:
        for name, text in example.texts().items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        scene = load(folder)
    simulation = Simulation(scene, seed=scene.run.seed if scene.run.seed is not None else 1, threads=1)
    simulation.run(example.picture.get("steps", scene.run.steps))
    return simulation


class Shading(NamedTuple):
    """One number a bead, and what it is called; numbers beyond the ends look like the ends."""

    name: str
    values: NDArray[np.float64]
    low: float
    high: float


def shades(colour: str, simulation: Simulation) -> Shading | None:
    """Return the numbers that beads are coloured by; None where it is by species."""
    if colour == "species":
        return None
    if colour == "vx":
        return Shading("v along x", simulation.velocities[:, 0], -2.0, 2.0)
    values = simulation.bead_arrays()[colour]
    low, high = np.quantile(values, (0.02, 0.98)).tolist()
    return Shading(colour.replace("_", " of "), values, low, high)


def draw(example: Example, simulation: Simulation) -> bytes:
    """Return a PNG file of the beads."""
    from matplotlib import colormaps
    from matplotlib.collections import EllipseCollection
    from matplotlib.colors import Normalize, to_rgb
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    scene, state = simulation.scene, simulation.state
    picture = example.picture
    shading = shades(picture.get("colour", "species"), simulation)
    depth = "xyz".index(picture.get("along", "y"))
    across, upwards = (axis for axis in range(3) if axis != depth)
    hidden = [scene.species.index(name) for name in picture.get("hide", [])]
    shown = np.flatnonzero(~np.isin(scene.beads.species, hidden))
    order = shown[np.argsort(state.positions[shown, depth])]
    places = state.positions[order]
    edges = np.linalg.norm(simulation.cell, axis=1)
    spacing = (np.prod(edges) / scene.bead_count) ** (1.0 / 3.0)
    if shading is not None:
        scale = Normalize(shading.low, shading.high)
        colours = colormaps["coolwarm"](scale(shading.values[order]))[:, :3]
    else:
        palette = np.array([to_rgb(colour) for colour in COLOURS])
        colours = palette[scene.beads.species[order] % len(palette)]
    nearest = places[:, depth].max()
    empty = bool(hidden) or "diameter" in picture  # around what is seen
    deepest = nearest - places[:, depth].min() if empty else DEEP * spacing
    fade = 0.0 if shading is not None else PALE  # of shades, pale ones are in the middle
    pale = fade * np.clip((nearest - places[:, depth]) / deepest, 0.0, 1.0)[:, None]

    height = min(WIDTH * edges[upwards] / edges[across], HEIGHT)
    figure = Figure((WIDTH, height + 0.35), dpi=DOTS)
    axes = figure.add_axes((0.01, 0.01, 0.98, height / (height + 0.35) - 0.01))
    size = picture.get("diameter", 2.0 * RADIUS * spacing / 0.693)
    beads = EllipseCollection(
        size,
        size,
        0.0,
        units="xy",
        offsets=places[:, [across, upwards]],
        offset_transform=axes.transData,
        facecolors=colours * (1.0 - pale) + pale,
        edgecolors=0.65 * colours * (1.0 - pale) + pale,
        linewidths=0.4,
    )
    axes.add_collection(beads)
    half = 0.5 * edges
    axes.set(xlim=(-half[across], half[across]), ylim=(-half[upwards], half[upwards]), aspect="equal")
    axes.set(xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_color("#888888")
    if shading is not None:
        values = (shading.low, 0.5 * (shading.low + shading.high), shading.high)
        labels = [(f"{value:.3g}", colormaps["coolwarm"](scale(value))) for value in values]
        labels[0] = (f"{shading.name}: {labels[0][0]}", labels[0][1])
    else:
        kinds = [k for k in range(len(scene.species)) if k not in hidden]
        labels = [(scene.species[k], COLOURS[k % len(COLOURS)]) for k in kinds]
        labels += [(f"{scene.species[k]}: not drawn", "none") for k in hidden]
    handles = [
        Line2D([], [], marker="o", linestyle="", markersize=8, markerfacecolor=colour, markeredgecolor="#888888")
        for _, colour in labels
    ]
    figure.legend(handles, [text for text, _ in labels], loc="upper center", ncols=6, frameon=False, fontsize=10)
    return small_png(figure)


def small_png(figure: object) -> bytes:
    """Return the figure as a PNG file of 128 colours."""
    from PIL import Image

    plain, small = io.BytesIO(), io.BytesIO()
    figure.savefig(plain, format="png", facecolor="white")  # type: ignore[attr-defined]
    with Image.open(plain) as image:
        image.convert("RGB").quantize(128, dither=Image.Dither.NONE).save(small, format="png", optimize=True)
    return small.getvalue()


def main() -> int:
    """Draw the examples; the return value is the exit code."""
    wanted = sys.argv[1:]
    every = {one.name: one for one in gallery()}
    if not set(wanted) <= set(every):
        print(f"there are {', '.join(every)}", file=sys.stderr)
        return 1
    for name in wanted or every:
        path = IMAGES / f"example-{name}.png"
        path.write_bytes(draw(every[name], run(every[name])))
        print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
