"""The example ``droplet``: a film contracts to an oscillating droplet. Draws docs/images/droplet.png.

The extents along x, y and z are the roots of 5 times the diagonal of the gyration tensor, which are the half axes of an
ellipsoid. Takes about two minutes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pydlpoly import Simulation, load
from pydlpoly.cli import example_folder

DOCS = Path(__file__).resolve().parent
EVERY, SHOWN = 20, (0, 400, 900, 1600, 8000)


def about_the_middle(positions: NDArray[np.float64], edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) nearest places to the droplet's middle: a bead that left through a face comes back through the other."""
    middle = np.angle(np.exp(2j * np.pi * positions / edges).mean(axis=0)) * edges / (2.0 * np.pi)
    places = positions - middle
    places -= edges * np.round(places / edges)
    return np.asarray(places - places.mean(axis=0))


def half_axes(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3,) root of 5 ⟨r²⟩ along each axis; places from the middle."""
    return np.asarray(np.sqrt(5.0 * np.mean(places**2, axis=0)))


def main() -> None:
    """Run the example and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--picture", type=Path, default=DOCS / "images" / "droplet.png")
    arguments = parser.parse_args()
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    scene = load(example_folder("droplet"))
    simulation = Simulation(scene)
    times, axes_of, shapes = [], [], {}
    for step in range(0, scene.run.steps + 1, EVERY):
        places = about_the_middle(simulation.state.positions, np.diag(scene.cell))
        times.append(simulation.time)
        axes_of.append(half_axes(places))
        if step in SHOWN:
            shapes[step] = places
        if step < scene.run.steps:
            simulation.run(EVERY)
    figure = plt.figure(figsize=(11.0, 5.2), layout="constrained")
    grid = figure.add_gridspec(2, len(SHOWN))
    plot = figure.add_subplot(grid[0, :])
    for k, name in enumerate("xyz"):
        plot.plot(times, np.array(axes_of)[:, k], label=name)
    plot.set(xlabel="time", ylabel="half axis", xlim=(0.0, times[-1]))
    plot.legend(frameon=False)
    for k, (step, places) in enumerate(shapes.items()):
        axis = figure.add_subplot(grid[1, k])
        shown = places[np.argsort(-places[:, 1])]
        axis.scatter(shown[:, 0], shown[:, 2], s=3.0, c=shown[:, 1], cmap="Blues_r", linewidths=0.0)
        axis.set(title=f"t = {step * scene.dynamics.timestep:g}", xlim=(-11.0, 11.0), ylim=(-7.0, 7.0), aspect="equal")
        axis.set_axis_off()
    figure.savefig(arguments.picture, dpi=110)
    print(f"half axes at the end: {' '.join(f'{x:.2f}' for x in axes_of[-1])}")


if __name__ == "__main__":
    main()
