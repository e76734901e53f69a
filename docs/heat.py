"""Makes docs/images/heat.png: the example's profiles of temperature against the solution of the heat equation.

``python docs/heat.py`` takes a minute. Conduction and drag do not depend on temperature here, as in the equation.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl
import numpy as np

from pydlpoly import Scene, Simulation, load
from pydlpoly.cli import example_folder
from pydlpoly.formats.records import FloatArray

mpl.use("Agg")
import matplotlib.pyplot as plt

HALF, RATE, LAYERS = 6.0, 0.02, 24
DENSITY, CONDUCTIVITY, RANGE = 4.0, 1.41, 1.58
SELF_DIFFUSION = 0.02  # of the beads, from their displacements
TIMES = (0.5, 1.5, 4.0, 10.0)


def scene() -> Scene:
    """Return the shipped example without polynomials."""
    source = Path(example_folder("heat"))
    with TemporaryDirectory() as folder:
        for name in ("CONTROL", "FIELD", "CONFIG"):
            text = (source / name).read_text(encoding="utf-8")
            (Path(folder) / name).write_text(re.sub(r" (power|conductivity)( -?[0-9.]+){4}", "", text))
        return load(folder)


def solution(y: FloatArray, time: float) -> FloatArray:
    """Temperatures at the places y (n,) after so long with the two sources, from T = 1."""
    diffusivity = 2.0 * math.pi * DENSITY * CONDUCTIVITY * RANGE**5 / 315.0 + SELF_DIFFUSION
    total = np.zeros_like(y)
    for n in range(1, 200, 2):
        height = 4.0 * RATE * HALF**2 / (diffusivity * (n * math.pi) ** 3)
        grown = -math.expm1(-((n * math.pi / HALF) ** 2) * diffusivity * time)
        total += height * grown * np.sin(n * math.pi * y / HALF)
    return 1.0 + total


def profiles() -> list[FloatArray]:
    """Temperatures of the layers around the times, means over five looks each."""
    simulation = Simulation(scene(), seed=1)
    found = []
    for time in TIMES:
        sums, beads = np.zeros(LAYERS), np.zeros(LAYERS)
        for look in (-0.1, -0.05, 0.0, 0.05, 0.1):
            simulation.run(round((time + look - simulation.time) / 0.01))
            layer = np.floor((simulation.positions[:, 1] + HALF) * LAYERS / (2.0 * HALF)).astype(int) % LAYERS
            sums += np.bincount(layer, weights=simulation._engine.system.bead_temperatures, minlength=LAYERS)
            beads += np.bincount(layer, minlength=LAYERS)
        found.append(sums / beads)
    return found


def main() -> None:
    """Run and draw; print the largest difference."""
    centres = (np.arange(LAYERS) + 0.5) * 2.0 * HALF / LAYERS - HALF
    fine = np.linspace(-HALF, HALF, 400)
    figure, axes = plt.subplots(figsize=(7.0, 4.2), layout="constrained")
    for number, (time, found) in enumerate(zip(TIMES, profiles(), strict=True)):
        axes.plot(fine, solution(fine, time), f"C{number}-", label=f"time {time:g}")
        axes.plot(centres, found, f"C{number}o", markersize=4)
        difference = np.abs(found - solution(centres, time)).max()
        print(f"time {time:g}: largest difference {difference:.4f} of {np.ptp(found):.3f}")
    axes.set(xlabel="y", ylabel="temperature", title="Heat conduction: beads (points) and the heat equation (lines)")
    axes.legend(title="after")
    path = Path(__file__).parent / "images" / "heat.png"
    figure.savefig(path, dpi=110)
    print(path)


if __name__ == "__main__":
    main()
