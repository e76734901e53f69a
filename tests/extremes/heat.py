"""Beads that carry heat: temperatures and heat capacities near 0 and far from it, empty neighbourhoods, long steps."""

from __future__ import annotations

from functools import partial

import numpy as np

from pydlpoly import Simulation

from ..heat_scenes import fluid, heat, set_temperatures, temperatures
from .framework import SEED, Cases, Seen, check_finite, require, stopped

CASES = Cases("heat")
_STEPS = 50
_IDEAL = ("A A dpd 0.0 1.0 4.5",)


def balance(
    order: str,
    capacity: float = 60.0,
    kappa: float = 0.1,
    *,
    cold: int = 0,
    temperature: float = 1e-12,
    timestep: float = 0.01,
    beads: int = 375,
    cell: float = 5.0,
) -> Seen:
    """Change of the conserved energy in 50 steps; the first ``cold`` beads start at ``temperature``, others at 1."""
    block = heat(f"capacity A {capacity!r}", f"pair A A kappa {kappa!r} range 1.2")
    scene = fluid(block, order=order, beads=beads, cell=cell, timestep=timestep, laws=_IDEAL)
    simulation = Simulation(scene, seed=SEED, threads=2)
    if cold:
        values = np.ones(beads)
        values[:cold] = temperature
        set_temperatures(simulation, values)
    start = simulation.observe().energy["conserved"]
    simulation.run(_STEPS)
    check_finite(simulation)
    found = temperatures(simulation)
    require(np.isfinite(found).all() and (found > 0.0).all(), "a temperature is not above 0")
    change = abs(simulation.observe().energy["conserved"] / start - 1.0)
    return Seen("change of the conserved energy, relative:", float(change), 0.0, 1e-12)


def alone() -> Seen:
    """Beads without neighbours keep their temperatures to the bit."""
    block = heat("capacity A 7.3", "pair A A kappa 0.1 range 0.5")
    places = 2.0 * np.stack(np.meshgrid(*[np.arange(3)] * 3), axis=-1).reshape(-1, 3) - 2.0
    scene = fluid(block, beads=27, cell=6.0, positions=places, velocities=np.zeros((27, 3)), laws=_IDEAL)
    simulation = Simulation(scene, seed=SEED)
    values = np.random.default_rng(SEED).uniform(0.1, 3.0, 27)
    set_temperatures(simulation, values)
    simulation.run(_STEPS)
    return Seen("largest change of a temperature", float(np.abs(temperatures(simulation) - values).max()), 0.0, 0.0)


def coincident() -> Seen:
    """Coincident beads have no line along which drag could act, and exchange no heat."""
    block = heat("capacity A 60", "pair A A kappa 0.1 range 1.2")
    scene = fluid(block, beads=40, positions=np.zeros((40, 3)), velocities=np.zeros((40, 3)), laws=_IDEAL)
    simulation = Simulation(scene, seed=SEED)
    set_temperatures(simulation, np.linspace(0.5, 1.5, 40))
    simulation.run(_STEPS)
    check_finite(simulation)
    change = np.abs(temperatures(simulation) - np.linspace(0.5, 1.5, 40)).max()
    return Seen("largest change of a temperature", float(change), 0.0, 0.0)


def too_little(order: str) -> Simulation:
    return Simulation(fluid(heat("capacity A 1e-3"), order=order, timestep=0.05), seed=SEED)


for _order in ("nve", "ou", "ou-middle", "mdvv"):
    CASES.add(f"one bead at T = 1e-12, {_order}", partial(balance, _order, cold=1))
    CASES.add(f"all beads at T = 1e-200, {_order}", partial(balance, _order, cold=375, temperature=1e-200))
    CASES.add(f"one bead at T = 1000, {_order}", partial(balance, _order, cold=1, temperature=1e3))
    CASES.add(f"heat capacity 1e12, {_order}", partial(balance, _order, 1e12, 1e-13))
    CASES.add(f"cell of 0.9 ranges: several images, {_order}", partial(balance, _order, beads=5, cell=1.08))
for _order in ("nve", "ou", "ou-middle"):
    CASES.add(f"heat capacity 1e-6, {_order}", partial(balance, _order, 1e-6))
    CASES.add(f"conduction of 1e9 per timestep, {_order}", partial(balance, _order, 60.0, 1e11))
    CASES.add(f"timestep 0.1, half of the beads cold, {_order}", partial(balance, _order, cold=187, timestep=0.1))
CASES.add("beads without neighbours", alone)
CASES.add("coincident beads at rest", coincident)
CASES.add("heat capacity 1e-3, mdvv", lambda: stopped(partial(too_little, "mdvv"), 50, "more heat from bead", latest=5))
