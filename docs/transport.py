"""Runs the examples of dissolved species and draws their pictures for docs/transport.md.

``python docs/transport.py`` needs matplotlib and a minute. ``python docs/transport.py configurations`` writes the
examples' CONFIG files instead: beads at random places, as in LAMMPS's example.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pydlpoly import Simulation, load
from pydlpoly.cli import example_folder

IMAGES = Path(__file__).parent / "images"
EDGES = {"transport": (6.0, 20.0, 6.0), "reaction_front": (56.25, 4.8, 4.8)}
BEADS = {"transport": 2880, "reaction_front": 3888}
_SEED = 20261127
_LAYERS = 20
_RATE = 0.01  # of the sources
_HALF = 10.0  # length of a half of the box that is fed or drained

Floats = NDArray[np.float64]


def configuration(name: str) -> str:
    """Return the CONFIG of an example."""
    edges = np.array(EDGES[name])
    places = (np.random.default_rng(_SEED).random((BEADS[name], 3)) - 0.5) * edges
    lines = [f"{BEADS[name]} beads placed at random", f"0 2 {BEADS[name]}"]
    lines += [" ".join(f"{x:.6f}" for x in row) for row in np.diag(edges)]
    for number, place in enumerate(places, 1):
        lines += [f"W {number}", " ".join(f"{x:.4f}" for x in place)]
    return "\n".join([*lines, ""])


def mean_field(density: float, kappa: float, reach: float) -> float:
    """Diffusivity of the exchange between neighbours without order, exponent 2."""
    return 2.0 * math.pi * density * kappa * reach**5 / 315.0


def carried(own: float, density: float, kappa: float, reach: float) -> float:
    """Diffusivity of what beads carry, from their own one at k_B T = mass = 1, exponent 2.

    A bead gives away what it has at the rate λ = ρκ ∫w² dV, while its velocity is forgotten in the time τ = m D/k_B T:
    of D_self = ∫⟨v v⟩ dt remains ∫⟨v v⟩ exp(−λt) dt = D_self/(1 + λτ).
    """
    return own / (1.0 + density * kappa * 4.0 * math.pi * reach**3 / 30.0 * own)


def transient(y: Floats, diffusivity: float, rate: float, time: float) -> Floats:
    """Concentration at y of sources ±rate in the halves of a periodic box of 20, from 1 on."""
    profile = np.ones_like(y)
    for n in range(1, 200, 2):
        wave = n * math.pi / _HALF
        size = 4.0 * rate / (diffusivity * wave**2 * n * math.pi)
        profile += size * (1.0 - math.exp(-(wave**2) * diffusivity * time)) * np.sign(y) * np.sin(wave * np.abs(y))
    return profile


def fisher(x: Floats, start: Floats, diffusivity: float, rate: float, time: float) -> Floats:
    """∂c/∂t = D ∂²c/∂x² + K c (1 − c) on a ring of evenly spaced x, by splitting with Fourier's exact diffusion."""
    steps = max(1, math.ceil(time / 0.02))
    step = time / steps
    wave = 2.0 * math.pi * np.fft.rfftfreq(len(x), x[1] - x[0])
    decay = np.exp(-diffusivity * wave**2 * step)

    def react(c: Floats, duration: float) -> Floats:
        growth = math.exp(rate * duration)
        return np.asarray(c * growth / (1.0 + c * (growth - 1.0)))

    c = start
    for _ in range(steps):
        c = react(c, 0.5 * step)
        c = react(np.clip(np.fft.irfft(decay * np.fft.rfft(c), len(x)), 0.0, None), 0.5 * step)
    return c


def layers(simulation: Simulation, axis: int, count: int, column: int) -> Floats:
    """Mean concentration of the beads in layers along an axis."""
    length = simulation.cell[axis, axis]
    layer = np.floor((simulation.positions[:, axis] / length + 0.5) * count).astype(int) % count
    values = np.asarray(simulation._engine.system.concentrations)[:, column]
    return np.bincount(layer, values, minlength=count) / np.bincount(layer, minlength=count)


def centres(length: float, count: int) -> Floats:
    """Middles of layers along an axis."""
    return (np.arange(count) + 0.5) * (length / count) - 0.5 * length


def own_diffusivity(simulation: Simulation, time: float) -> float:
    """D of the beads from their displacements since the start."""
    return float((simulation.displacements() ** 2).sum(axis=1).mean()) / (6.0 * time)


def draw_profiles() -> None:
    """Profiles of the example ``transport`` at three times."""
    import matplotlib.pyplot as plt

    simulation = Simulation(load(example_folder("transport")))
    y, fine = centres(20.0, _LAYERS), np.linspace(-10.0, 10.0, 400)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True)
    for time, colour in ((1.0, "C0"), (3.0, "C1"), (6.0, "C2")):
        simulation.run(round(time / simulation.scene.dynamics.timestep) - simulation.step)
        own = own_diffusivity(simulation, time)
        for column, (axis, kappa, rate) in enumerate(zip(axes, (1.0, 3.0), (_RATE, -_RATE), strict=True)):
            axis.plot(y, layers(simulation, 1, _LAYERS, column), "o", color=colour, ms=4, label=f"t = {time:g}")
            diffusivity = mean_field(4.0, kappa, 1.58) + carried(own, 4.0, kappa, 1.58)
            axis.plot(fine, transient(fine, diffusivity, rate, time), color=colour, lw=1)
    for axis, name in zip(axes, ("first, kappa = 1", "second, kappa = 3"), strict=True):
        axis.set(title=name, xlabel="y")
    axes[0].set_ylabel("amount a bead")
    axes[0].legend(frameon=False)
    _save(figure, "transport-profiles.png")


def draw_front() -> None:
    """The front of the example ``reaction_front`` at several times, and the equation of its continuum."""
    import matplotlib.pyplot as plt

    scene = load(example_folder("reaction_front"))
    simulation = Simulation(scene)
    count, length = 75, EDGES["reaction_front"][0]
    x, fine = centres(length, count), centres(length, 1500)
    start = np.where(np.abs(fine) < 3.0, 1.0, 0.0)
    figure, axis = plt.subplots(figsize=(9, 3.6))
    for number, time in enumerate((0.0, 5.0, 10.0, 15.0, 20.0)):
        simulation.run(round(time / scene.dynamics.timestep) - simulation.step)
        own = own_diffusivity(simulation, time) if time else 0.0
        diffusivity = mean_field(3.0, 1.0, 1.5) + carried(own, 3.0, 1.0, 1.5)
        axis.plot(x, layers(simulation, 0, count, 1), "o", color=f"C{number}", ms=3, label=f"t = {time:g}")
        axis.plot(fine, fisher(fine, start, diffusivity, 0.5, time), color=f"C{number}", lw=1)
    axis.set(xlabel="x", ylabel="b, amount a bead")
    axis.legend(frameon=False, ncols=5, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    _save(figure, "transport-front.png")


def _save(figure: object, name: str) -> None:
    IMAGES.mkdir(exist_ok=True)
    figure.savefig(IMAGES / name, dpi=110, bbox_inches="tight")  # type: ignore[attr-defined]


def main(words: list[str]) -> None:
    """Draw the pictures, or write the configurations."""
    if words == ["configurations"]:
        for name in EDGES:
            (example_folder(name) / "CONFIG").write_text(configuration(name), encoding="utf-8")
        return
    import matplotlib

    matplotlib.use("Agg")
    draw_profiles()
    draw_front()


if __name__ == "__main__":
    main(sys.argv[1:])
