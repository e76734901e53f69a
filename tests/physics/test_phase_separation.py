"""Liquids that do not mix: Flory and Huggins's χ of monomers, and lamellae of diblock copolymers.

Groot and Warren (J. Chem. Phys. 107, 4423 (1997)) give χ = (0.286 ± 0.002) Δa at density 3, from the composition φ of
two coexisting phases: χ = ln[(1 − φ)/φ]/(1 − 2φ). Groot and Madden (J. Chem. Phys. 108, 8713 (1998)) find lamellae of
symmetric blocks at a_AB = 40.
"""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import Simulation
from pydlpoly.analysis import LamellarOrder, frames_of_arrays
from pydlpoly.build import Component, build, chain

from ..scene_builder import make_scene

EDGES = (20.0, 8.0, 8.0)
EXCESS = (11.0, 13.0, 15.0)
STEP = {"timestep": "0.04 internal_t", "ensemble_dpd_lambda": "0.65", "precision": "mixed"}


def coexisting(excess: float) -> float:
    """φ of the minority species in the middles of two slabs, averaged over 480 τ after 120 τ."""
    generator = np.random.default_rng(2)
    positions = (generator.random((3840, 3)) - 0.5) * EDGES
    positions = positions[np.argsort(positions[:, 0])]  # one species on either side
    unlike = f"A B dpd {25.0 + excess} 1.0 4.5"
    pairs = ("A A dpd 25.0 1.0 4.5", unlike, "B B dpd 25.0 1.0 4.5")
    scene = make_scene({"A": 1920, "B": 1920}, pairs, cell=EDGES, positions=positions, control=STEP)
    simulation = Simulation(scene, seed=31)
    simulation.run(3000)
    first = scene.beads.species == 0
    strangers = beads = 0
    for _ in range(600):
        simulation.run(20)
        x = simulation.state.positions[:, 0]
        # The slabs wander: their middles are where the first wave of the composition says.
        wave = np.sum(np.where(first, 1.0, -1.0) * np.exp(2j * np.pi * x / EDGES[0]))
        apart = x / EDGES[0] - np.angle(wave) / (2.0 * np.pi)
        apart -= np.round(apart)
        own, other = np.abs(apart) < 0.125, np.abs(apart) > 0.375
        strangers += np.count_nonzero(own & ~first) + np.count_nonzero(other & first)
        beads += np.count_nonzero(own) + np.count_nonzero(other)
    return strangers / beads


@pytest.mark.long
def test_flory_huggins_parameter() -> None:
    """χ/Δa of three fluids; φ has errors of 2 to 4 %, χ of 1 to 2 %."""
    found = []
    for excess in EXCESS:
        phi = coexisting(excess)
        found.append(np.log((1.0 - phi) / phi) / (1.0 - 2.0 * phi) / excess)
    print("chi / excess:", np.round(found, 4))
    assert np.mean(found) == pytest.approx(0.286, rel=0.10)


@pytest.mark.long
def test_symmetric_diblocks_form_lamellae() -> None:
    """24 000 beads of A5B5, from a mixed start, for 2400 τ: one density wave outgrows the order of a mixed melt."""
    built = build(
        box=20.0,
        species=["A", "B"],
        molecules=[Component(chain("A5B5", "A5B5"), count=2400)],
        pairs={"*": {"a": 25.0, "cutoff": 1.0, "drag": 4.5}, "A B": 40.0},
        bonds={"*": ("harm", 4.0, 0.0)},
        run={"timestep": "0.04 dpd_t", "ensemble_dpd_lambda": "0.65", "precision": "mixed"},
        seed=5,
    )
    simulation = Simulation(built.scene(), seed=6)

    def order() -> tuple[float, float]:
        analysis = LamellarOrder("A", shortest=3.0)
        for _ in range(5):
            simulation.run(200)
            state = simulation.state
            names = [simulation.scene.species[k] for k in simulation.scene.beads.species]
            (frame,) = frames_of_arrays(state.positions, simulation.scene.cell, species=names)
            analysis.add(frame)
        found = analysis.result()
        return found.squared_order[0], found.period

    early, _ = order()
    simulation.run(58_000)
    late, period = order()
    print("order squared:", early, late, "period:", period)
    # Of 12 000 beads without order, the strongest of some hundred waves has about 5e-4.
    assert early < 0.02
    assert late > 0.2
    assert 4.0 < period < 8.0
