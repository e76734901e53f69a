"""Beads that touch: coincident ones, and every pair law at r -> 0."""

from __future__ import annotations

from functools import partial

import numpy as np

from pydlpoly import Simulation, _core
from pydlpoly.errors import RunError

from ..scene_builder import NVE, make_scene
from ..test_pair_laws import CUTOFF, FORMULAS, INFO, ROWS
from .framework import MOMENTUM, PATHS, Cases, Seen, check_finite, momentum, on_path, require, stopped

CASES = Cases("contact")


def coincident(path: str, count: int) -> Seen:
    """All beads at one place and at rest, T = 0: energy A rc/2 a pair, no force, and no step moves them."""
    scene = make_scene(
        {"A": count},
        cell=6.0,
        positions=np.full((count, 3), 0.375),
        velocities=np.zeros((count, 3)),
        control={"temperature": "0.0 K"},
    )
    simulation = on_path(scene, path)
    energies = [simulation.energy["pair"]]
    simulation.run(10)
    energies.append(simulation.energy["pair"])
    check_finite(simulation)
    assert not simulation.state.forces.any()
    assert not simulation.state.velocities.any()
    assert energies[0] == energies[1]
    exact = 12.5 * count * (count - 1) / 2
    return Seen("pair energy", energies[0], exact, exact * (1e-12 if path != "fast, mixed" else 1e-6))


def explosion(path: str, count: int) -> Seen:
    """Coincident beads with thermal velocities under nve: the energy of contact turns into motion."""
    control = {**NVE, "timestep": "0.0002 internal_t"}
    scene = make_scene({"A": count}, cell=6.0, positions=np.full((count, 3), 0.375), control=control)
    simulation = on_path(scene, path)
    before = simulation.energy["total"]
    simulation.run(1000)
    check_finite(simulation)
    assert simulation.energy["pair"] < 0.8 * 12.5 * count * (count - 1) / 2
    assert momentum(simulation) < MOMENTUM[path]
    return Seen("total energy over that at the start", simulation.energy["total"] / before, 1.0, 1e-3)


def thermostat_at_contact(path: str) -> Seen:
    """Coincident beads with drag and noise and no force to part them: drag and noise have no direction there."""
    scene = make_scene(
        {"A": 2}, ["A A dpd 25.0 1.0 1e4"], cell=6.0, positions=np.zeros((2, 3)), velocities=np.zeros((2, 3))
    )
    simulation = on_path(scene, path)
    simulation.run(100)
    check_finite(simulation)
    return Seen("largest velocity", float(np.abs(simulation.state.velocities).max()), 0.0, 0.0)


for _path in PATHS:
    CASES.add(f"two coincident beads at rest, {_path}", partial(coincident, _path, 2))
    CASES.add(f"200 coincident beads at rest, {_path}", partial(coincident, _path, 200))
    CASES.add(f"drag and noise of two coincident beads, {_path}", partial(thermostat_at_contact, _path))
    if _path != "general":
        CASES.add(f"200 coincident beads fly apart, {_path}", partial(explosion, _path, 200))

# n of the r^-n that a law becomes at small r, from its formula; laws that stay finite have none. In zblb a part of the
# dispersion reaches r = 0 and wins there.
POWERS = {
    "12-6": 12, "lj": 12, "ljc": 12, "ljf": 6, "nm": 9.5, "snm": 10, "buck": 6, "bhm": 8, "hbnd": 12, "mstw": 12,
    "zbl": 1, "zbls": 1, "zblb": 6, "mlj": 12, "mbuc": 6, "m126": 12, "sw": 4,
}  # fmt: skip


def law_scene(key: str, distance: float) -> Simulation:
    numbers = " ".join(repr(float(x)) for x in ROWS[key].parameters)
    positions = np.array([[0.0, 0.0, 0.0], [distance, 0.0, 0.0]])
    control = {**NVE, "cutoff": f"{CUTOFF} ang"}
    pairs = [f"A A {key} {numbers}"]
    velocities = np.zeros((2, 3))
    scene = make_scene({"A": 2}, pairs, cell=40.0, positions=positions, velocities=velocities, control=control)
    return Simulation(scene, seed=1, threads=1, precision="reference")


def diverging_law(key: str) -> Seen:
    """The force follows r^-n-1 as far as numbers go, then the run is refused with the beads and their distance."""
    simulation = law_scene(key, 1.0)
    worst, forces, messages = 0.0, {}, 0
    for exponent in range(0, -1075, -3):
        r = 2.0**exponent
        try:
            simulation.set_state(positions=np.array([[0.0, 0.0, 0.0], [r, 0.0, 0.0]]))
        except RunError as error:
            cause = "the pair force between beads 1 and 2 is not finite at a distance of"
            require(cause in str(error), str(error))
            messages += 1
            continue
        assert messages == 0, "a nearer pair is finite again"
        found = simulation.state.forces
        check_finite(simulation)
        energy, force = (float(x[0]) for x in _core.evaluate_pair(key, ROWS[key].parameters, CUTOFF, [r]))
        assert abs(simulation._engine.system.pair_energy - energy) <= 1e-12 * abs(energy), r
        assert abs(found[1, 0] - force) <= 1e-12 * abs(force), r
        assert found[0, 0] == -found[1, 0]
        forces[exponent] = abs(force)
    reached = min(forces)
    assert messages > 5
    assert reached < -20
    # A sum of powers has its leading one alone only far inside.
    for exponent in range(reached, min(reached + 16, -14), 3):
        slope = np.log2(forces[exponent] / forces[exponent + 3]) / 3 - 1.0
        worst = max(worst, abs(slope - POWERS[key]))
    return Seen(f"exponent of U less {POWERS[key]:g}, down to r = {2.0**reached:.1g}:", worst, 0.0, 2e-3)


def finite_law(key: str) -> Seen:
    """Coincident beads have the law's energy and no force, and the energy goes there without a jump."""
    simulation = law_scene(key, 0.0)
    check_finite(simulation)
    assert not simulation.state.forces.any()
    contact = simulation.energy["pair"]
    steepest = abs(float(_core.evaluate_pair(key, ROWS[key].parameters, CUTOFF, [1e-9])[1][0]))
    worst = 0.0
    for exponent in range(-3, -1075, -3):
        r = 2.0**exponent
        simulation.set_state(positions=np.array([[0.0, 0.0, 0.0], [r, 0.0, 0.0]]))
        check_finite(simulation)
        force = simulation.state.forces[1, 0]
        law = float(_core.evaluate_pair(key, ROWS[key].parameters, CUTOFF, [r])[1][0])
        assert abs(force - law) <= 1e-12 * abs(law), (r, force, law)
        if exponent < -30:
            step = abs(simulation.energy["pair"] - contact)
            worst = max(worst, (step - 1.01 * steepest * r) / abs(contact))
    return Seen("largest step of U on the way to r = 0, relative:", max(worst, 0.0), 0.0, 1e-12)


# Local densities add to the law mdpd: they have cases of their own.
for _key in (key for key in FORMULAS if key != "mdpd"):
    if INFO[_key]["soft"]:
        CASES.add(f"law {_key}: r to 0", partial(finite_law, _key))
    elif _key in POWERS:
        CASES.add(f"law {_key}: r to 0", partial(diverging_law, _key))
        CASES.add(
            f"law {_key}: coincident beads",
            partial(
                stopped, partial(law_scene, _key, 0.0), 1, r"beads 1 and 2 is not finite at a distance of 0", latest=0
            ),
        )


def inside_the_core(fraction: float) -> Seen:
    """WCA with D = 0.07 diverges at r = D; nothing is defined inside."""
    return stopped(partial(law_scene, "wca", fraction * 0.07), 1, "beads 1 and 2", latest=0)


CASES.add("law wca: at its core, r = D", partial(inside_the_core, 1.0))
CASES.add("law wca: inside its core, r = D/2", partial(inside_the_core, 0.5))
CASES.add("law wca: coincident beads inside its core", partial(inside_the_core, 0.0))
