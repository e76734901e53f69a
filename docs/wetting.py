"""Contact angles of the droplet of the example ``wetting`` against the attraction of the wall, A_sw.

Writes the table of docs/many-body.md to the terminal and draws docs/images/wetting.png: the density of three droplets,
averaged around their axis, with the cap through their surface, and cos θ against A_sw. Takes about ten minutes.
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
import tempfile
from pathlib import Path
from types import ModuleType

import numpy as np

from pydlpoly import Simulation, load
from pydlpoly.analysis import ContactAngle, frames_of_arrays
from pydlpoly.analysis.contact_angle import SphericalCap

DOCS = Path(__file__).resolve().parent
ATTRACTIONS = (-15.0, -20.0, -25.0, -30.0, -35.0)
SPREADING, FRAMES, INTERVAL = 6000, 120, 100  # steps until frames are taken, frames, steps between them


def examples() -> ModuleType:
    """Return docs/make_mdpd_examples.py as a module."""
    spec = importlib.util.spec_from_file_location("make_mdpd_examples", DOCS / "make_mdpd_examples.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def contact_angle(attraction: float, spreading: int = SPREADING, frames: int = FRAMES, seed: int = 1) -> SphericalCap:
    """Return the cap of the droplet on a wall with this A_sw."""
    maker = examples()
    with tempfile.TemporaryDirectory() as folder:
        for name, text in maker.wetting(attraction).items():
            (Path(folder) / name).write_text(text)
        scene = load(folder)
    names = [scene.species[k] for k in scene.beads.species]
    walls = scene.beads.positions[scene.beads.frozen, 2]
    # The wall ends half the distance of its layers above the last one.
    angle = ContactAngle("L", float(walls.max()) + 0.25 * maker.EDGE, bin_width=0.4, skip=1.2)
    simulation = Simulation(scene, seed=seed)
    simulation.run(spreading)
    for _ in range(frames):
        simulation.run(INTERVAL)
        angle.add(next(frames_of_arrays(simulation.state.positions, scene.cell, species=names)))
    return angle.result()


def draw(caps: dict[float, SphericalCap], path: Path) -> None:
    """Draw droplets and the cosines of their angles."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    shown = [list(caps)[k] for k in (0, len(caps) // 2, -1)]
    figure, axes = plt.subplots(1, 4, figsize=(12.0, 3.2), layout="constrained")
    for attraction, axis in zip(shown, axes[:3], strict=True):
        cap = caps[attraction]
        axis.pcolormesh(
            np.concatenate([-cap.r[::-1], cap.r]),
            cap.z,
            np.hstack([cap.density[:, ::-1], cap.density]),
            cmap="Blues",
            vmin=0.0,
            vmax=1.3 * cap.liquid,
            shading="nearest",
        )
        along = np.linspace(0.0, 2.0 * np.pi, 400)
        x, z = cap.radius * np.cos(along), cap.height + cap.radius * np.sin(along)
        axis.plot(x[z >= 0.0], z[z >= 0.0], "k.", markersize=1.0)
        axis.axhline(0.0, color="0.4", linewidth=2.0)
        axis.set(title=f"A_sw = {attraction:g}: {cap.angle:.0f}°", xlim=(-8.5, 8.5), ylim=(-0.3, 11.0), aspect="equal")
        axis.set(xlabel="distance from the axis", ylabel="height")
    cosines = [np.cos(np.radians(cap.angle)) for cap in caps.values()]
    axes[3].plot(list(caps), cosines, "o-")
    axes[3].axhline(0.0, color="0.7", linewidth=0.8)
    axes[3].set(xlabel="A_sw", ylabel="cos θ")
    figure.savefig(path, dpi=120)


def main() -> None:
    """Print the table and draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--picture", type=Path, default=DOCS / "images" / "wetting.png")
    caps: dict[float, SphericalCap] = {}
    print("| A_sw | θ (degrees) | R | density inside |")
    print("| ---: | ---: | ---: | ---: |")
    arguments = parser.parse_args()
    for attraction in ATTRACTIONS:
        cap = caps[attraction] = contact_angle(attraction)
        print(
            f"| {attraction:g} | {cap.angle:.1f} ± {cap.error:.1f} | {cap.radius:.2f} | {cap.liquid:.2f} |", flush=True
        )
    draw(caps, arguments.picture)


if __name__ == "__main__":
    main()
