"""What 100 000 steps bring about: momentum, energy, temperature, in each precision."""

from __future__ import annotations

from functools import partial

import numpy as np

from pydlpoly import Simulation

from ..scene_builder import NVE, make_scene
from .framework import MOMENTUM, PRECISIONS, SEED, Cases, Seen, check_finite, momentum

CASES = Cases("100 000 steps")
_STEPS = 100_000


def _water(precision: str, control: dict[str, str | None]) -> Simulation:
    scene = make_scene({"A": 192}, cell=4.0, control={**control, "precision": precision})
    return Simulation(scene, seed=SEED, threads=1)


def energy(precision: str) -> Seen:
    """The total energy of water without a thermostat, as a straight line through 1000 samples.

    The energy fluctuates by the square of the timestep; its drift must be a small part of k_B T a bead.
    """
    warm = _water("double", {"timestep": "0.01 internal_t"})
    warm.run(1000)
    simulation = _water(precision, {**NVE, "timestep": "0.005 internal_t"})
    state = warm.state
    simulation.set_state(positions=state.positions, velocities=state.velocities)
    seen = []
    for _ in range(1000):
        simulation.run(_STEPS // 1000)
        seen.append(simulation.energy["total"] / 192)
    check_finite(simulation)
    assert momentum(simulation) < 1e-6
    slope = np.polyfit(np.linspace(0.0, 1.0, 1000), seen, 1)[0]
    return Seen("drift of the energy a bead, k_B T:", float(slope), 0.0, 5e-3)


def total_momentum(precision: str, order: str) -> Seen:
    """The total momentum over the sum of the sizes of all momenta."""
    simulation = _water(precision, {"ensemble_dpd_order": order})
    simulation.run(_STEPS)
    check_finite(simulation)
    path = "fast, mixed" if order == "mdvv" and precision == "mixed" else "reference"
    return Seen("total momentum, relative:", momentum(simulation), 0.0, 10 * MOMENTUM[path])


def temperature(precision: str) -> Seen:
    """First and last quarter have the same temperature: 2500 samples of 192 beads each, error sqrt(2/573/800) = 0.002.

    The timestep of 0.01 itself brings 0.1 to 0.5 %.
    """
    simulation = _water(precision, {"timestep": "0.01 internal_t"})
    seen = []
    for _ in range(_STEPS // 10):
        simulation.run(10)
        seen.append(simulation.temperature)
    check_finite(simulation)
    first, last = np.mean(seen[:2500]), np.mean(seen[-2500:])
    assert abs(last - first) < 0.012
    return Seen("mean temperature of the last quarter", float(last), 1.003, 0.01)


for _precision in PRECISIONS:
    CASES.add(f"energy, nve, {_precision}", partial(energy, _precision), slow=True)
    CASES.add(f"momentum, mdvv, {_precision}", partial(total_momentum, _precision, "mdvv"), slow=True)
    CASES.add(f"temperature, mdvv, {_precision}", partial(temperature, _precision), slow=True)
for _order in ("ou", "ou-middle", "middle"):
    CASES.add(f"momentum, {_order}", partial(total_momentum, "double", _order), slow=True)
