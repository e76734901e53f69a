"""Averages over a running simulation, shared by the physics tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pydlpoly import Scene, Simulation
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True)
class Averages:
    """Means over the samples of a run; reduced units.

    Attributes:
        temperature, pressure: of all samples.
        energy: pair energy per bead.
        species_temperature: kinetic temperature of each species.
        largest_momentum: largest component of the total momentum met.
        series: (samples, 2) temperatures and pressures.
    """

    temperature: float
    pressure: float
    energy: float
    species_temperature: tuple[float, ...]
    largest_momentum: float
    series: FloatArray

    def error(self, column: int, blocks: int = 8) -> float:
        """Standard error of the mean of temperature (0) or pressure (1), from block averages."""
        means = [block.mean() for block in np.array_split(self.series[:, column], blocks)]
        return float(np.std(means, ddof=1) / np.sqrt(blocks))


def sample(simulation: Simulation, steps: int, every: int) -> Averages:
    """Run ``steps`` steps and average over every ``every``-th of them."""
    scene = simulation.scene
    rows, species, momentum = [], [], 0.0
    for _ in range(steps // every):
        simulation.run(every)
        seen = simulation.observe()
        rows.append((seen.temperature, seen.pressure, seen.energy["pair"] / scene.bead_count))
        species.append(species_temperatures(scene, simulation.state.velocities))
        momentum = max(momentum, float(np.abs(seen.momentum).max()))
    table = np.array(rows)
    temperature, pressure, energy = table.mean(axis=0)
    by_species = tuple(float(t) for t in np.mean(species, axis=0))
    return Averages(temperature, pressure, energy, by_species, momentum, table[:, :2])


def species_temperatures(scene: Scene, velocities: FloatArray) -> list[float]:
    """Kinetic temperature of every species of mobile beads, from three degrees of freedom a bead."""
    twice_kinetic = scene.beads.mass * np.sum(velocities**2, axis=1)
    kinds: Sequence[int] = range(len(scene.species))
    mobile = ~scene.beads.frozen
    return [
        float(np.mean(twice_kinetic[mobile & (scene.beads.species == kind)])) / 3.0
        for kind in kinds
        if np.any(mobile & (scene.beads.species == kind))
    ]


def equilibrated(scene: Scene, *, seed: int, steps: int) -> Simulation:
    """Return the simulation after its first ``steps`` steps."""
    simulation = Simulation(scene, seed=seed, threads=1)
    simulation.run(steps)
    return simulation
