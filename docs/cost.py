"""What a bead and step costs against the size, the density, the cutoffs and the number of species of a fluid.

``python docs/cost.py`` prints the tables of docs/performance.md's part "cost". All fluids of a table exist at once and
run in turns, so that a machine that is slow for a while is slow for all of them.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping, Sequence

import numpy as np

from pydlpoly import Simulation
from pydlpoly.bench.results import Spread
from pydlpoly.bench.scenes import cube, single_beads, water
from pydlpoly.scene.model import Scene

_ROUNDS = 7  # 3 where a fluid is very large
_BEAD_STEPS = 2_000_000  # of one turn, at least
_LAW = ("dpd", 25.0, 1.0, 4.5)


def fluid(beads: int, density: float = 3.0, species: int = 1, shortest: float = 1.0) -> Scene:
    """Return a fluid of equal shares of the species; the last one's beads meet each other at the shortest cutoff."""
    names = [f"S{k}" for k in range(species)]
    counts = {name: beads // species + (1 if k < beads % species else 0) for k, name in enumerate(names)}
    pairs = {(a, b): _LAW for i, a in enumerate(names) for b in names[i:]}
    pairs[names[-1], names[-1]] = ("dpd", 25.0, shortest, 4.5)
    return single_beads("fluid", counts, pairs, cube(beads, density))


def stepped(order: str, **settings: str) -> Scene:
    """Return DPD water of 24 000 beads under another integrator, at one timestep for all."""
    control = {"ensemble_dpd_order": order, "timestep": "0.02 dpd_t", **settings}
    return single_beads("water", {"W": 24_000}, {("W", "W"): _LAW}, cube(24_000, 3.0), control=control)


def compare(fluids: Mapping[str, Scene], precision: str, reference: str) -> dict[str, str]:
    """Return the time of a bead and step relative to the reference's, median and quartiles, for each fluid."""
    running = {}
    for name, scene in fluids.items():
        simulation = Simulation(scene, seed=1, threads=1, precision=precision)
        simulation.run(500 if scene.bead_count < 200_000 else 30)
        running[name] = simulation
    seconds: dict[str, list[float]] = {name: [] for name in fluids}
    for turn in range(_ROUNDS if max(scene.bead_count for scene in fluids.values()) < 2_000_000 else 3):
        for name in list(fluids)[:: 1 if turn % 2 else -1]:
            beads = fluids[name].bead_count
            steps = max(20, -(-_BEAD_STEPS // beads))
            begin = time.perf_counter()
            running[name].run(steps)
            seconds[name].append((time.perf_counter() - begin) / (steps * beads))
    return {name: Spread.of(np.divide(seconds[name], seconds[reference]).tolist()).text() for name in fluids}


def table(heading: str, fluids: Mapping[str, Scene], reference: str) -> str:
    """Return a Markdown table of one comparison in both precisions."""
    found = {precision: compare(fluids, precision, reference) for precision in ("double", "mixed")}
    lines = [f"| {heading} | double | mixed |", "| --- | --- | --- |"]
    lines += [f"| {name} | {found['double'][name]} | {found['mixed'][name]} |" for name in fluids]
    return "\n".join(lines) + "\n"


def cost(sizes: Sequence[int] = (1000, 10_000, 100_000, 1_000_000, 10_000_000)) -> str:
    """Return all tables: against beads, density, cutoffs and species."""
    beads = 24_000
    tables = [
        table("beads", {f"{n:,}".replace(",", " "): water(n) for n in sizes}, "10 000"),
        table("density", {f"{d:g}": fluid(beads, density=d) for d in (0.1, 0.5, 1.0, 3.0, 5.0, 7.0, 12.0)}, "3"),
        table(
            "longest over shortest cutoff, two species",
            {f"{r:g}": fluid(beads, species=2, shortest=1.0 / r) for r in (1.0, 2.0, 5.0, 10.0)},
            "1",
        ),
        table(
            "a step of",
            {
                "mdvv": stepped("mdvv"),
                "mdvv, λ = 0.9": stepped("mdvv", ensemble_dpd_lambda="0.9", ensemble_dpd_kinetic="half"),
                "middle, 2 passes": stepped("middle", ensemble_dpd_passes="2"),
                "middle": stepped("middle"),
                "middle, every 2": stepped("middle", ensemble_dpd_interval="2"),
                "middle, every 4": stepped("middle", ensemble_dpd_interval="4"),
                "first": stepped("first"),
                "ou-middle": stepped("ou-middle"),
                "dpdvv": stepped("dpdvv"),
            },
            "mdvv",
        ),
        table("species", {f"{k}": fluid(beads, species=k) for k in (1, 2, 4, 8, 16, 32)}, "1"),
    ]
    return "\n".join(tables)


if __name__ == "__main__":
    sys.stdout.write(cost())
