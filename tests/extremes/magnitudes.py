"""Numbers far from 1: strengths, drags, timesteps, temperatures, velocities, masses."""

from __future__ import annotations

from functools import partial

import numpy as np

from pydlpoly import Simulation
from pydlpoly.scene.integrators import INTEGRATORS

from ..scene_builder import NVE, make_scene
from .framework import MOMENTUM, PATHS, SEED, Cases, Seen, check_finite, momentum, on_path, refused, stopped

CASES = Cases("magnitude")

# What ends a run that a timestep is too long for.
_TOO_LONG = "too long for the (forces|drag)|left its range|left all bounds"

# Strengths --------------------------------------------------------------------------------------------------------


def collision(path: str, strength: float) -> Seen:
    """Two beads at r = 1/2 at rest fly apart; their energy of motion is the energy of contact."""
    timestep = 0.02 / max(strength, 25.0) ** 0.5
    control = {**NVE, "timestep": f"{timestep!r} internal_t"}
    positions = np.array([[0.25, 0.0, 0.0], [-0.25, 0.0, 0.0]])
    velocities = np.array([[1e-3, 0.0, 0.0], [-1e-3, 0.0, 0.0]])
    scene = make_scene(
        {"A": 2}, [f"A A dpd {strength!r} 1.0"], cell=6.0, positions=positions, velocities=velocities, control=control
    )
    simulation = on_path(scene, path)
    before = simulation.energy["total"]
    assert abs(before - strength / 8 - 1e-6) <= 1e-7 * (strength / 8 + 1.0)
    simulation.run(150)
    check_finite(simulation)
    if strength > 1.0:
        assert simulation.energy["pair"] == 0.0
    kinetic = simulation.energy["total"]
    return Seen(
        "energy over a/8",
        kinetic / (strength / 8 + 1e-6),
        1.0,
        1e-2 if path == "fast, mixed" and strength < 1e-3 else 1e-3,
    )


def well(path: str) -> Seen:
    """a = -25 attracts: two beads swing through each other and keep their energy."""
    control = {**NVE, "timestep": "0.002 internal_t"}
    positions = np.array([[0.2, 0.0, 0.1], [-0.2, 0.0, -0.1]])
    velocities = np.array([[0.0, 0.5, 0.0], [0.0, -0.5, 0.0]])
    scene = make_scene(
        {"A": 2}, ["A A dpd -25.0 1.0"], cell=6.0, positions=positions, velocities=velocities, control=control
    )
    simulation = on_path(scene, path)
    before = simulation.energy["total"]
    nearest = 1.0
    for _step in range(200):
        simulation.run(5)
        apart = simulation.state.positions[0] - simulation.state.positions[1]
        nearest = min(nearest, float(np.linalg.norm(apart)))
    check_finite(simulation)
    assert nearest < 0.2, "they never met"
    return Seen("energy over that at the start", simulation.energy["total"] / before, 1.0, 2e-3)


def collapse(path: str) -> Seen:
    """375 beads that attract each other fall into clumps; the thermostat takes the heat, momentum stays."""
    control = {"timestep": "0.002 internal_t"}
    scene = make_scene({"A": 375}, ["A A dpd -2.0 1.0 20.0"], cell=5.0, control=control)
    simulation = on_path(scene, path)
    simulation.run(2000)
    check_finite(simulation)
    assert momentum(simulation) < MOMENTUM[path]
    assert simulation.energy["pair"] < -375.0
    return Seen("temperature", simulation.temperature, 1.0, 0.2)


for _path in PATHS:
    if _path != "general":
        for _a in (1e-6, 1.0, 25.0, 1e3, 1e6):
            CASES.add(f"collision with a = {_a:g}, {_path}", partial(collision, _path, _a))
        CASES.add(f"two beads with a = -25, {_path}", partial(well, _path))
    CASES.add(f"fluid with a = -2, {_path}", partial(collapse, _path))


def fluid(
    order: str, *, strength: float = 25.0, drag: float = 4.5, timestep: float = 0.01, beads: int = 375, **more: str
) -> Simulation:
    control: dict[str, str | None] = {
        "ensemble_dpd_order": order, "timestep": f"{timestep!r} internal_t", **more
    }  # fmt: skip
    if order == "nve":
        control |= NVE
    pairs = [f"A A dpd {strength!r} 1.0 {drag!r}"]
    scene = make_scene({"A": beads}, pairs, cell=(beads / 3.0) ** (1 / 3), control=control)
    return Simulation(scene, seed=SEED, threads=1)


def hard(order: str, more: dict[str, str]) -> Seen:
    """a = 1e6 at a timestep for a = 25: no integrator follows such forces."""
    return stopped(partial(fluid, order, strength=1e6, **more), 200, _TOO_LONG, latest=50)


for _order in INTEGRATORS:
    CASES.add(f"a = 1e6 at a timestep of 0.01, {_order}", partial(hard, _order, {}))
for _order in ("nve", "mdvv"):
    CASES.add(
        f"a = 1e6 at a timestep of 0.01, {_order}, reference",
        partial(hard, _order, {"precision": "reference"}),
    )

# Drags ------------------------------------------------------------------------------------------------------------

SWEEPS = [name for name, info in INTEGRATORS.items() if info.kind == "sweep" and name != "nose-hoover-langevin"]


def gas(order: str, drag: float, **more: str) -> Simulation:
    return fluid(order, strength=0.0, drag=drag, beads=1500, **more)


def gas_temperature(order: str, drag: float) -> Seen:
    """Mean temperature of 1500 beads without repulsion over 200 steps.

    One sample has a standard deviation of sqrt(2/4500) = 0.021; at least some ten of them are independent.
    """
    simulation = gas(order, drag)
    seen = []
    for _step in range(200):
        simulation.run(1)
        seen.append(simulation.temperature)
    check_finite(simulation)
    assert momentum(simulation) < 1e-13
    return Seen("mean temperature", float(np.mean(seen)), 1.0, _temperature_error(order, drag))


def _temperature_error(order: str, drag: float) -> float:
    """Return how far off T may be; at a drag of 100 drag x timestep/mu reaches 2, where drags as forces are off."""
    if drag < 1e-3:
        return 1e-3
    return 0.1 if drag == 100.0 and INTEGRATORS[order].kind == "forces" else 0.03


def gas_temperature_weakly_held(drag: float) -> Seen:
    """Stoyanov and Groot's second drag acts whatever the first: T is held, if not to 1e-3."""
    seen = gas_temperature("stoyanov-groot", drag)
    return Seen(seen.quantity, seen.value, 1.0, 0.03)


_REFUSED = {
    "middle": "middle is not stable unless drag x interval x timestep / reduced mass is below 2.*here it is",
    "peters-first": "needs drag x timestep / reduced mass below 2.*here it is",
    "lowe-andersen": "the probability that a pair is chosen in one step would be above 1; here it is",
    "stoyanov-groot": "the probability that a pair is chosen in one step would be above 1; here it is",
}
for _order in INTEGRATORS:
    for _drag in (1e-8, 1.0, 1e2, 1e4, 1e6):
        _name = f"drag {_drag:g} at a timestep of 0.01, {_order}"
        if _order in _REFUSED and _drag >= (1e2 if _order in ("peters-first", "middle") else 1e3):
            CASES.add(_name, partial(refused, partial(gas, _order, _drag), _REFUSED[_order]))
        elif _order == "stoyanov-groot" and _drag < 1e-3:
            CASES.add(_name, partial(gas_temperature_weakly_held, _drag))
        elif (_drag >= 1e4 and _order not in SWEEPS) or (_order == "scvv" and _drag >= 1e2):
            CASES.add(_name, partial(stopped, partial(gas, _order, _drag), 200, _TOO_LONG, latest=20))
        else:
            CASES.add(_name, partial(gas_temperature, _order, _drag))

CASES.add("drag 150 at a timestep of 0.01, middle", partial(refused, partial(gas, "middle", 150.0), _REFUSED["middle"]))

# Timesteps --------------------------------------------------------------------------------------------------------


def short_steps(path: str) -> Seen:
    """1000 steps of 1e-6: every bead has moved by its velocity times 1e-3, with the acceleration's part."""
    control = {**NVE, "timestep": "1e-6 internal_t"}
    scene = make_scene({"A": 375}, cell=5.0, control=control)
    simulation = on_path(scene, path)
    state = simulation.state
    simulation.run(1000)
    check_finite(simulation)
    time = 1e-3
    assert abs(simulation.time - time) < 1e-12
    moved = simulation.displacements()
    expected = state.velocities * time + 0.5 * state.forces * time**2
    error = np.abs(moved - expected).max() / np.abs(expected).max()
    # The way of a step is rounded: in mixed precision to half of 5/2^32, the same in every step.
    allowed = 3e-4 if path == "fast, mixed" else 1e-4
    return Seen("largest error of the displacements over the largest one:", float(error), 0.0, allowed)


def short_impulses(path: str, distance: float) -> Seen:
    """What a force does in 1000 steps of 1e-6 to a bead at rest: v = F t."""
    control = {**NVE, "timestep": "1e-6 internal_t"}
    positions = np.array([[distance / 2, 0.0, 0.0], [-distance / 2, 0.0, 0.0]])
    scene = make_scene({"A": 2}, cell=6.0, positions=positions, velocities=np.zeros((2, 3)), control=control)
    simulation = on_path(scene, path)
    simulation.run(1000)
    velocity = simulation.state.velocities[0, 0]
    return Seen("velocity over F t", float(velocity / (25.0 * (1.0 - distance) * 1e-3)), 1.0, 1e-3)


def short_step_temperature(order: str) -> Seen:
    """Water for 200 steps of 1e-6: noise of 1/sqrt(dt) = 1000 must not heat it."""
    simulation = fluid(order, timestep=1e-6)
    simulation.run(200)
    check_finite(simulation)
    assert momentum(simulation) < 1e-12
    return Seen("temperature", simulation.temperature, 1.0, 0.02)


def long_step(order: str) -> Seen:
    """A timestep of 1 for water."""
    return stopped(partial(fluid, order, timestep=1.0), 200, _TOO_LONG, latest=50)


# Numbers of 32 bits are too coarse for such steps: precision mixed takes the general path.
for _path in ("fast, double", "reference"):
    CASES.add(f"timestep 1e-6, nve, {_path}", partial(short_steps, _path))
    for _distance in (0.3, 0.98):
        CASES.add(f"timestep 1e-6, a pair at {_distance}, {_path}", partial(short_impulses, _path, _distance))
for _order in INTEGRATORS:
    CASES.add(f"timestep 1e-6, {_order}", partial(short_step_temperature, _order))
    if _order in _REFUSED:
        CASES.add(f"timestep 1, {_order}", partial(refused, partial(fluid, _order, timestep=1.0), _REFUSED[_order]))
    else:
        CASES.add(f"timestep 1, {_order}", partial(long_step, _order))
for _value in (0.0, -0.01):
    CASES.add(
        f"timestep {_value:g}",
        partial(refused, partial(fluid, "mdvv", timestep=_value), "CONTROL.*the timestep must be above 0"),
    )

# T = 0 ------------------------------------------------------------------------------------------------------------


def cold(order: str) -> Seen:
    """A gas at T = 0 loses its motion to the drag and never gains any."""
    rng = np.random.default_rng(5)
    velocities = rng.normal(size=(375, 3))
    velocities -= velocities.mean(axis=0)
    control = {"ensemble_dpd_order": order, "temperature": "0.0 K"}
    scene = make_scene({"A": 375}, ["A A dpd 0.0 1.0 4.5"], cell=5.0, velocities=velocities, control=control)
    simulation = Simulation(scene, seed=SEED, threads=1)
    kinetic = [simulation.energy["kinetic"]]
    for _step in range(100):
        simulation.run(5)
        kinetic.append(simulation.energy["kinetic"])
    check_finite(simulation)
    assert momentum(simulation) < 1e-10
    assert not simulation.observe().stress_parts["noise"].any()
    assert np.diff(kinetic).max() <= 1e-12 * kinetic[0], "the gas has gained energy"
    return Seen("kinetic energy over that at the start", kinetic[-1] / kinetic[0], 0.0, 0.1)


def start_at_zero(path: str) -> Seen:
    """Velocities that are drawn at T = 0 are 0, and water only takes up the energy of its repulsion."""
    scene = make_scene({"A": 375}, cell=5.0, control={"temperature": "0.0 K"})
    simulation = on_path(scene, path)
    assert simulation.temperature == 0.0
    before = simulation.energy["total"]
    simulation.run(500)
    check_finite(simulation)
    assert simulation.energy["total"] < before
    return Seen("temperature", simulation.temperature, 0.0, 0.1)


for _order in INTEGRATORS:
    if _order == "nose-hoover-langevin":
        _run = partial(refused, partial(fluid, _order, temperature="0.0 K"), "needs a temperature above 0")
        CASES.add(f"T = 0, {_order}", _run)
    else:
        CASES.add(f"T = 0, {_order}", partial(cold, _order))
for _path in PATHS:
    CASES.add(f"T = 0 from the start, {_path}", partial(start_at_zero, _path))
CASES.add(
    "T = -1",
    partial(refused, partial(fluid, "mdvv", temperature="-1.0 dpd_temp"), "the temperature must not be negative"),
)

# Velocities -------------------------------------------------------------------------------------------------------


def fast_beads(path: str, speed: float, steps: int = 10) -> Simulation:
    """Two beads that pass each other at a distance."""
    positions = np.array([[0.0, 2.0, 0.0], [0.0, -2.0, 0.0]])
    velocities = np.array([[speed, 0.0, 0.0], [-speed, 0.0, 0.0]])
    control = {**NVE, "timestep": "0.01 internal_t"}
    scene = make_scene({"A": 2}, cell=8.0, positions=positions, velocities=velocities, control=control)
    simulation = on_path(scene, path)
    simulation.run(steps)
    return simulation


def flight(path: str, speed: float) -> Seen:
    """x = v t, followed across a thousand boxes a step."""
    simulation = fast_beads(path, speed)
    check_finite(simulation)
    travelled = simulation.displacements()[0, 0]
    return Seen("distance over v t", float(travelled / (speed * 0.1)), 1.0, 1e-9)


CASES.add("velocities 100, reference", partial(flight, "reference", 1e2))
CASES.add("velocities 100, fast, double", partial(flight, "fast, double", 1e2))
for _path in ("fast, double", "fast, mixed"):
    CASES.add(f"velocities 1e6, {_path}", partial(stopped, partial(fast_beads, _path, 1e6, 0), 10, _TOO_LONG, latest=1))
for _speed in (1e6, 1e12):
    CASES.add(
        f"velocities {_speed:g}, reference",
        partial(stopped, partial(fast_beads, "reference", _speed, 0), 10, "bead 1 would move by 1e", latest=1),
    )

# Masses -----------------------------------------------------------------------------------------------------------

_MASSES = {f"M{k}": 10.0**k for k in range(-6, 7, 2)}


def mass_scene(order: str, beads: int, timestep: float, strength: float = 0.0, drag: float = 4.5) -> Simulation:
    names = list(_MASSES)
    names = [name.replace("-", "n") for name in names]
    masses = dict(zip(names, _MASSES.values(), strict=True))
    pairs = [f"{a} {b} dpd {strength!r} 1.0 {drag!r}" for k, a in enumerate(names) for b in names[k:]]
    control: dict[str, str | None] = {"ensemble_dpd_order": order, "timestep": f"{timestep!r} internal_t"}
    if order == "nve":
        control |= NVE
    edge = (len(names) * beads / 3.0) ** (1 / 3)
    scene = make_scene(dict.fromkeys(names, beads), pairs, cell=edge, masses=masses, control=control)
    return Simulation(scene, seed=SEED, threads=1)


def species_temperatures(simulation: Simulation) -> np.ndarray:
    scene = simulation.scene
    twice = scene.beads.mass * np.sum(simulation.state.velocities**2, axis=1) / 3.0
    return np.array([twice[scene.beads.species == k].mean() for k in range(len(scene.species))])


def equipartition(order: str) -> Seen:
    """Masses 1e-6 to 1e6 in one ideal gas: k_B T for each of the seven species.

    Light beads get their velocities anew in each step. From 200 beads of a species and 100 samples, each at least
    tenth of them independent, the standard error is below sqrt(2/600/10) = 0.018. The heavy ones keep their start.
    """
    simulation = mass_scene(order, 200, 1e-4)
    before = np.abs(simulation.state.velocities * simulation.scene.beads.mass[:, None]).max()
    seen = []
    for _step in range(100):
        simulation.run(2)
        seen.append(species_temperatures(simulation))
    check_finite(simulation)
    assert momentum(simulation) < 1e-9
    assert before > 0.0
    mean = np.mean(seen, axis=0)
    worst = mean[np.argmax(np.abs(mean - 1.0))]
    return Seen("temperature of the species that is farthest off", float(worst), 1.0, 0.15)


def mass_collision(path: str) -> Seen:
    """A bead of mass 1e-6 hits one of mass 1e6 head-on and comes back with its speed."""
    positions = np.array([[1.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    velocities = np.array([[-1000.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    control = {**NVE, "timestep": "1e-6 internal_t", "fixed_com": "off"}
    scene = make_scene(
        {"A": 1, "B": 1},
        ["A A dpd 25.0 1.0", "A B dpd 25.0 1.0", "B B dpd 25.0 1.0"],
        cell=8.0,
        positions=positions,
        velocities=velocities,
        masses={"A": 1e-6, "B": 1e6},
        control=control,
    )
    simulation = on_path(scene, path)
    simulation.run(1500)
    check_finite(simulation)
    # The heavy bead takes twice the light one's momentum, 2e-3, which makes 2e-9 of velocity.
    recoil = simulation.state.velocities[1, 0]
    assert abs(recoil + 2e-9) < 1e-3 * 2e-9, recoil
    return Seen("velocity after the hit", float(simulation.state.velocities[0, 0]), 1000.0, 1.0)


for _order in INTEGRATORS:
    if _order in SWEEPS and _order not in _REFUSED:
        CASES.add(f"masses 1e-6 to 1e6, {_order}", partial(equipartition, _order))
    elif _order in _REFUSED:
        CASES.add(
            f"masses 1e-6 to 1e6, {_order}", partial(refused, partial(mass_scene, _order, 10, 0.01), _REFUSED[_order])
        )
    else:
        CASES.add(
            f"masses 1e-6 to 1e6, {_order}",
            partial(stopped, partial(mass_scene, _order, 200, 0.01), 200, _TOO_LONG, latest=20),
        )
for _path in ("fast, double", "reference"):
    CASES.add(f"mass 1e-6 hits mass 1e6, {_path}", partial(mass_collision, _path))


def massless(frozen: tuple[str, ...]) -> Simulation:
    scene = make_scene(
        {"A": 100, "B": 3},
        ["A A dpd 25.0 1.0 4.5", "A B dpd 25.0 1.0 4.5", "B B dpd 25.0 1.0 4.5"],
        cell=5.0,
        masses={"B": 0.0},
        frozen=frozen,
    )
    simulation = Simulation(scene, seed=SEED, threads=1)
    simulation.run(50)
    return simulation


def massless_frozen() -> Seen:
    """Frozen beads need no mass."""
    simulation = massless(("B",))
    check_finite(simulation)
    return Seen("velocity of the frozen ones", float(np.abs(simulation.state.velocities[100:]).max()), 0.0, 0.0)


CASES.add(
    "massless beads", partial(refused, partial(massless, ()), "bead B .*has no mass.*give it a mass or freeze it")
)
CASES.add("massless frozen beads", massless_frozen)
