"""One scene in both engines, and what tests compare of them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pydlpoly import Scene, Simulation
from pydlpoly.formats.records import FloatArray
from pydlpoly.simulation import Observation


def in_both(scene: Scene, ranks: int = 1, seed: int = 1) -> tuple[Simulation, Simulation]:
    """The native engine's simulation and LAMMPS's."""
    return Simulation(scene, seed=seed, threads=1), Simulation(scene, seed=seed, engine="lammps", ranks=ranks)


def assert_same_frame(ours: Simulation, theirs: Simulation, *, forces: float, energy: float = 1e-10) -> None:
    """Compare places, velocities, forces, energies and stress; errors are of the largest force and energy."""
    a, b = ours.state, theirs.state
    assert np.abs(a.positions - b.positions).max() < 1e-9
    assert np.array_equal(a.images, b.images)
    assert np.abs(a.velocities - b.velocities).max() < 1e-9 * max(1.0, np.abs(a.velocities).max())
    assert np.abs(a.forces - b.forces).max() <= forces * np.abs(a.forces).max()
    one, other = ours.observe(), theirs.observe()
    size = sum(abs(one.energy[name]) for name in ("pair", "bond", "angle", "kinetic"))
    for name in ("pair", "bond", "angle", "potential", "kinetic", "total"):
        assert other.energy[name] == pytest.approx(one.energy[name], abs=energy * size), name
    assert np.abs(other.stress - one.stress).max() <= 10.0 * energy * np.abs(one.stress).max()
    assert other.pressure == pytest.approx(one.pressure, abs=10.0 * energy * np.abs(one.stress).max())


def assert_same_parts(one: Observation, other: Observation, error: float = 1e-9) -> None:
    """Compare the stress of pair laws and that of drag, which is LAMMPS's of drag and noise."""
    size = np.abs(one.stress).max()
    motion = one.stress_parts["drag"] + one.stress_parts["noise"]
    for name, tensor in {"conservative": one.stress_parts["conservative"], "drag": motion}.items():
        assert np.abs(other.stress_parts[name] - tensor).max() <= error * size, name


def cold(scene: Scene) -> Scene:
    """The scene without noise; drag stays."""
    pairs = tuple(dataclasses.replace(pair, noise=0.0) for pair in scene.pairs)
    return dataclasses.replace(scene, pairs=pairs, dynamics=dataclasses.replace(scene.dynamics, thermal_energy=0.0))


def block_errors(rows: list[list[float]], blocks: int = 12) -> tuple[FloatArray, FloatArray]:
    """Means and standard errors of columns from averages over blocks."""
    table = np.array(rows)
    means = np.array([block.mean(axis=0) for block in np.array_split(table, blocks)])
    return table.mean(axis=0), means.std(axis=0, ddof=1) / np.sqrt(blocks)
