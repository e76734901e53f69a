"""Local densities at their limits: lone beads, coincident beads, wide ranges of numbers, and crowds."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from pydlpoly import Simulation

from ..scene_builder import NVE, make_scene
from .framework import Cases, Seen, check_finite, momentum, stopped

CASES = Cases("many-body DPD")
REACH, B = 0.75, 25.0
HEIGHT = 15.0 / (2.0 * math.pi * REACH**3)
STRENGTH = math.pi * REACH**4 * B / 15.0
COLD = NVE | {"temperature": "0.0 K"}


def lone(line: str) -> Seen:
    """Beads farther apart than every range have density 0, no force and no energy, also for m next to 1 and large m."""
    places = 3.0 * np.array([[x, y, 0.0] for x in (-1, 0, 1) for y in (-1, 0, 1)])
    scene = make_scene({"A": 9}, [line], cell=12.0, positions=places, control=NVE)
    simulation = Simulation(scene, seed=1)
    simulation.run(5)
    check_finite(simulation)
    assert not simulation.local_densities().any()
    assert not simulation.state.forces.any()
    return Seen("energy", simulation.energy["pair"], 0.0, 0.0)


def coincident(count: int) -> Seen:
    """All beads on one spot and at rest: ρ = (N − 1) W(0), the energy of contact, and no force."""
    scene = make_scene(
        {"A": count},
        [f"A A mdpd -40 {B} 1 {REACH} 4.5"],
        cell=6.0,
        positions=np.full((count, 3), 0.375),
        velocities=np.zeros((count, 3)),
        control=COLD,
    )
    simulation = Simulation(scene, seed=1)
    simulation.run(10)
    check_finite(simulation)
    assert not simulation.state.forces.any()
    assert np.ptp(simulation.local_densities()) == 0.0
    density = (count - 1) * HEIGHT
    assert abs(simulation.local_densities()[0] / density - 1.0) < 1e-13
    exact = -20.0 * count * (count - 1) / 2 + count * 0.5 * STRENGTH * density**2
    return Seen("energy", simulation.energy["pair"], exact, 1e-12 * abs(exact))


def size_of_numbers(factor: float) -> Seen:
    """A and B times a factor: forces times that factor, within the rounding of sums on a grid."""
    forces = []
    for scale in (1.0, factor):
        line = f"A A mdpd {-40.0 * scale!r} {B * scale!r} 1 {REACH}"
        simulation = Simulation(make_scene({"A": 300}, [line], cell=4.0, control=NVE), seed=1)
        check_finite(simulation)
        forces.append(simulation.state.forces / scale)
    largest = np.abs(forces[0]).max()
    return Seen("largest difference of forces", float(np.abs(forces[1] - forces[0]).max() / largest), 0.0, 1e-11)


def hugest() -> Simulation:
    """B for which two beads' force is no number any more."""
    places = [[0.0, 0.0, 0.0], [0.01, 0.0, 0.0]]
    return Simulation(
        make_scene({"A": 2}, ["A A mdpd -1 1e308 1 0.75"], cell=6.0, positions=places, control=NVE), seed=1
    )


def steep(repulsion: float, m: float) -> Seen:
    """Two beads just inside r_d: the force of formulas, with B or m so large that at contact it would be huge.

    Densities are sums on a grid of 6e-14, a 1e-8 of the density here.
    """
    r = 0.999 * REACH
    record = f"{repulsion!r} 1 {REACH}" if m == 2.0 else f"{repulsion!r} 2 {m!r} 1 {REACH}"
    places = [[0.0, 0.0, 0.0], [r, 0.0, 0.0]]
    simulation = Simulation(
        make_scene({"A": 2}, [f"A A mdpd -40 {record}"], cell=6.0, positions=places, control=NVE), seed=1
    )
    check_finite(simulation)
    density = HEIGHT * (1.0 - r / REACH) ** 2
    strength = math.pi * REACH**4 * repulsion / 15.0 if m == 2.0 else repulsion
    force = -40.0 * (1.0 - r) + strength * 2.0 * density ** (m - 1.0) * 2.0 * HEIGHT / REACH * (1.0 - r / REACH)
    found = float(simulation.state.forces[1, 0])
    return Seen("relative error of the force", abs(found / force - 1.0), 0.0, 1e-8)


def crowd() -> Seen:
    """400 beads in a box of r_d cubed, where everyone meets 27 images: against ρ_i = Σ over all of them."""
    rng = np.random.default_rng(3)
    places = REACH * (rng.random((400, 3)) - 0.5)
    line = f"A A mdpd -40 {B} 1 {REACH}"
    simulation = Simulation(
        make_scene({"A": 400}, [line], cell=REACH, positions=places, control=NVE), seed=1, threads=2
    )
    check_finite(simulation)
    expected = np.zeros(400)
    for shift in np.stack(np.meshgrid(*[np.arange(-1.0, 2.0) * REACH] * 3), axis=-1).reshape(-1, 3):
        r = np.linalg.norm(places[:, None] - places[None, :] - shift, axis=2)
        weight = HEIGHT * np.clip(1.0 - r / REACH, 0.0, None) ** 2
        if not shift.any():
            np.fill_diagonal(weight, 0.0)
        expected += weight.sum(axis=1)
    worst = float(np.abs(simulation.local_densities() / expected - 1.0).max())
    return Seen("largest error of a density, relative", worst, 0.0, 1e-12)


def evaporation() -> Seen:
    """A hot liquid boils off under nve: densities go through all values to 0, and the energy stays."""
    side = (np.arange(6) - 2.5) * 0.55
    places = np.stack(np.meshgrid(side, side, side), axis=-1).reshape(-1, 3)
    scene = make_scene(
        {"A": 216},
        [f"A A mdpd -40 {B} 1 {REACH}"],
        cell=40.0,
        positions=places,
        control=NVE | {"temperature": "40.0 dpd_temp", "timestep": "0.0005 internal_t"},
    )
    simulation = Simulation(scene, seed=2)
    before = simulation.energy["total"]
    kinetic = simulation.energy["kinetic"]
    simulation.run(4000)
    check_finite(simulation)
    assert (simulation.local_densities() == 0.0).sum() > 50
    assert momentum(simulation) < 1e-12
    return Seen(
        "change of the total over the kinetic energy", (simulation.energy["total"] - before) / kinetic, 0.0, 1e-3
    )


CASES.add("beads alone", partial(lone, f"A A mdpd -40 {B} 1 {REACH}"))
CASES.add("beads alone, m = 1.01", partial(lone, "A A mdpd -40 25 2 1.01 1 0.75"))
CASES.add("beads alone, n = m = 12", partial(lone, "A A mdpd -40 25 12 12 1 0.75"))
CASES.add("two coincident beads at rest", partial(coincident, 2))
CASES.add("200 coincident beads at rest", partial(coincident, 200))
for _exponent in (-40, 60, 900):
    CASES.add(f"A and B times 2^{_exponent}", partial(size_of_numbers, 2.0**_exponent))
CASES.add("B = 1e12 at r = 0.999 r_d", partial(steep, 1e12, 2.0))
CASES.add("B = 1e-9, m = 30 at r = 0.999 r_d", partial(steep, 1e-9, 30.0))
CASES.add("B = 1e308", partial(stopped, hugest, 1, "the pair force between beads 1 and 2 is not finite", latest=0))
CASES.add("400 beads in a box of r_d cubed", crowd)
CASES.add("a drop of k_B T = 40 evaporates under nve", evaporation)
