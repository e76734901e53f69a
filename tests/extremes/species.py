"""Dissolved species at limits: nothing there, nobody near, beads in one place, timesteps without measure."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from pydlpoly import Scene, Simulation
from pydlpoly.formats.records import FloatArray

from ..scene_builder import NVE, make_scene
from .framework import SEED, Cases, Seen, check_finite, refused, stopped

CASES = Cases("species")


def still(places: FloatArray, *lines: str, timestep: float = 0.01, cell: float = 10.0) -> Scene:
    """Beads that feel nothing and stand still."""
    text = "\n".join(["extension transport", "species a b", *lines, "end extension", ""])
    return make_scene(
        {"A": len(places)},
        ["A A dpd 0.0 1.0 0.0"],
        cell=cell,
        positions=places,
        velocities=np.zeros_like(places),
        control={**NVE, "timestep": f"{timestep!r} internal_t"},
        extensions=text,
    )


def amounts(scene: Scene, steps: int) -> FloatArray:
    simulation = Simulation(scene, seed=SEED, threads=2)
    simulation.run(steps)
    check_finite(simulation)
    return np.asarray(simulation._engine.system.concentrations)


def random_places(count: int, edge: float) -> FloatArray:
    return np.asarray((np.random.default_rng(SEED).random((count, 3)) - 0.5) * edge)


PAIR = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]])


def nothing_there(noise: str, start: float) -> Seen:
    """Strong noise on next to nothing."""
    lines = ("pair A A a kappa 0.5 range 1.5 noise 50.0", f"noise {noise}", f"start a {start!r} box 0 * * * * *")
    now = amounts(still(random_places(600, 6.0), *lines, cell=6.0), 50)[:, 0]
    full = start * float((random_places(600, 6.0)[:, 0] >= 0.0).sum())
    lost = abs(math.fsum(now.tolist()) - full) / full if full else float(np.abs(now).max())
    return Seen("loss of the sum, and amounts below 0:", lost + float((now < 0.0).sum()), 0.0, 1e-13)


for _noise in ("sqrt", "lammps"):
    for _start in (0.0, 5e-324, 1e-300, 1e-12, 1e300):
        CASES.add(f"noise on the amount {_start:g}, {_noise}", partial(nothing_there, _noise, _start))


def nobody_near() -> Seen:
    """A bead without neighbours, beside ones that have some."""
    places = np.concatenate([PAIR, [[4.0, 4.0, 4.0]]])
    lines = ("pair A A a kappa 1.0 range 1.0 noise 1.0", "start a 0.7", "start b 0.3")
    return Seen("amount", float(amounts(still(places, *lines), 100)[2, 0]), 0.7, 0.0)


def one_place() -> Seen:
    """Two beads in one place exchange nothing, as they exert no force."""
    lines = ("pair A A a kappa 1.0 range 1.0 noise 1.0", "start a 0.7")
    return Seen("change", float(np.abs(amounts(still(PAIR * 0.0, *lines), 100)[:, 0] - 0.7).max()), 0.0, 0.0)


def crowded(distance: float) -> Seen:
    """200 beads next to one place, some of which have everything, with an exchange beyond any timestep."""
    places = random_places(200, distance)
    lines = ("pair A A a kappa 1e6 range 1.0", f"start a 1.0 box {float(places[0, 0])!r} * * * * *")
    now = amounts(still(places, *lines), 40)[:, 0]
    given = float((places[:, 0] >= places[0, 0]).sum())
    beyond = float(((now < 0.0) | (now > 1.0)).sum())
    return Seen("loss of the sum, and amounts beyond those given:", abs(now.sum() - given) / given + beyond, 0.0, 1e-13)


def without_measure(rate: float) -> Seen:
    """A pair that shares all it has in one step."""
    lines = (f"pair A A a kappa {rate!r} range 1.0", "start a 1.0 box * 0.1 * * * *")
    now = amounts(still(PAIR, *lines, timestep=1.0), 1)[:, 0]
    return Seen("amount of the second bead", float(now[1]), 0.5, 1e-15)


def reaction(equation: str, rate: float, start: tuple[float, float], wanted: float) -> Seen:
    """One bead, one step of one time unit."""
    lines = (f"reaction {rate!r} {equation}", f"start a {start[0]!r}", f"start b {start[1]!r}")
    now = amounts(still(PAIR[:1], *lines, timestep=1.0), 1)[0]
    assert (now >= 0.0).all()
    return Seen("amount of a", float(now[0]), wanted, 1e-14 * max(start))


def drained() -> Seen:
    """A sink takes what there is and no more."""
    now = amounts(still(PAIR, "start a 1e-9", "source a -1e6 everywhere"), 5)
    return Seen("amount", float(np.abs(now).max()), 0.0, 0.0)


CASES.add("a bead without neighbours", nobody_near)
CASES.add("two coincident beads", one_place)
for _distance in (1e-12, 0.1):
    CASES.add(f"200 beads within {_distance:g}", partial(crowded, _distance))
for _rate in (1e2, 1e12, 1e300):
    CASES.add(f"2 kappa dt of a pair = {2 * _rate:g}", partial(without_measure, _rate))
for _equation, _rate, _start, _wanted in (
    ("a -> b", 1e300, (1.0, 0.0), 0.0),
    ("a + b -> none", 1e300, (1.0, 0.25), 0.75),
    ("a + b -> none", 1.0, (1.0, 5e-324), 1.0),
    ("a + b -> 2 b", 1e300, (1.0, 5e-324), 0.0),
    ("a + b -> 2 b", 1e300, (1.0, 0.0), 1.0),
    ("2 a -> b", 1e300, (1e150, 0.0), 0.0),
):
    CASES.add(
        f"{_equation} at the rate {_rate:g} from {_start[0]:g} and {_start[1]:g}",
        partial(reaction, _equation, _rate, _start, _wanted),
    )
CASES.add("a sink in beads that are almost empty", drained)
CASES.add(
    "growth without bound",
    lambda: stopped(
        lambda: Simulation(still(PAIR, "start a 1.0", "reaction 1e4 a -> 2 a"), seed=SEED),
        100,
        "dissolved species 1 in bead 1",
        latest=8,
    ),
)
CASES.add(
    "a reaction that runs away in finite time",
    partial(refused, lambda: still(PAIR, "reaction 1.0 2 a -> 3 a"), "finite time"),
)
