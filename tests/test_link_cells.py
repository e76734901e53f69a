"""Link cells against a plain sum over all periodic images, in boxes that are awkward for cells.

The brute-force sum writes the pair laws out again, counts every image within the cutoff by distance alone and knows no
cells; ``ase.neighborlist`` is a second list of pairs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import product

import numpy as np
import pytest
from ase.neighborlist import primitive_neighbor_list
from numpy.typing import ArrayLike

from pydlpoly import RunError, Scene, Simulation, single_point
from pydlpoly.formats.records import FloatArray

from .scene_builder import NVE, cell_of, make_scene, random_positions

PERIODIC = {0: (0, 0, 0), 1: (1, 1, 1), 2: (1, 1, 1), 3: (1, 1, 1), 6: (1, 1, 0)}
# Strength of the soft law for every pair of species; the cutoff differs by pair too.
SOFT = {("A", "A"): (25.0, 1.0), ("A", "B"): (40.0, 0.8), ("B", "B"): (10.0, 1.2)}
SOFT_LINES = [f"{a} {b} dpd {strength} {cutoff} 4.5" for (a, b), (strength, cutoff) in SOFT.items()]


@dataclass(frozen=True)
class Box:
    """A cell that makes link cells think: its shape, its beads and its periodicity."""

    cell: ArrayLike
    beads: int
    imcon: int = 3
    positions: ArrayLike | None = field(default=None)
    cutoff: float = 1.2

    def scene(self) -> Scene:
        half = self.beads // 2
        return make_scene(
            {"A": self.beads - half, "B": half} if half else {"A": self.beads},
            SOFT_LINES if half else SOFT_LINES[:1],
            cell=cell_of(self.cell),
            imcon=self.imcon,
            positions=self.positions,
            control={**NVE, "cutoff": f"{self.cutoff} ang"},
        )


EDGE = 3.7
FACES = [[x, y, z] for x, y, z in product((-EDGE / 2, 0.0, EDGE / 2 - 1e-15), repeat=3)]
FAR = np.array([50.0, -9.0, 3.0])
BOXES = {
    "ordinary": Box(5.3, 300),
    "smaller than a cutoff": Box(0.7, 4),
    "much smaller than a cutoff": Box(0.3, 2),
    "one bead with its own images": Box(0.5, 1),
    "one bead alone": Box(5.0, 1),
    "exactly one cutoff wide": Box(1.2, 6),
    "exactly three cutoffs wide": Box(3.6, 120),
    "just below three cutoffs": Box(3.6 - 1e-9, 120),
    "thin slab": Box([9.0, 8.0, 0.4], 80),
    "thin rod": Box([0.4, 0.5, 20.0], 12),
    "skewed": Box([[4.0, 0.0, 0.0], [1.9, 3.5, 0.0], [-1.3, 1.1, 4.2]], 180),
    "strongly skewed": Box([[3.0, 0.0, 0.0], [5.5, 2.5, 0.0], [-4.0, 3.0, 2.0]], 60),
    "skewed and smaller than a cutoff": Box([[0.9, 0.0, 0.0], [0.8, 0.6, 0.0], [0.3, -0.5, 0.7]], 4),
    "not lower triangular": Box([[2.0, 2.0, 0.3], [-2.2, 1.8, 0.1], [0.4, -0.5, 3.0]], 90),
    "left-handed": Box([[0.0, 3.0, 0.0], [3.1, 0.0, 0.0], [0.4, 0.2, 3.2]], 100),
    "cubic": Box(3.3, 110, imcon=1),
    "orthorhombic": Box([3.3, 4.1, 2.7], 110, imcon=2),
    "not periodic": Box(4.0, 120, imcon=0),
    "not periodic, far from the origin": Box(4.0, 60, imcon=0, positions=random_positions(60, 3.0, 8) + FAR),
    "slab": Box([3.4, 4.3, 3.0], 130, imcon=6),
    "skewed slab": Box([[3.4, 0.0, 0.0], [1.5, 3.1, 0.0], [0.0, 0.0, 4.0]], 130, imcon=6),
    "beads on the faces": Box(EDGE, len(FACES), positions=FACES),
    "beads outside the cell": Box(4.0, 100, positions=random_positions(100, 30.0, 4)),
    "two beads in a cell of a million": Box(1e6, 2, positions=[[5e5 - 0.2, 0.0, 1.0], [-5e5 + 0.3, 0.1, 1.2]]),
    "many empty cells": Box(60.0, 40, positions=random_positions(40, 2.0, 3) + 29.0),
    "everything in one corner": Box(12.0, 200, positions=random_positions(200, 1.0, 6)),
}


def images(cell: FloatArray, periodic: tuple[int, ...], reach: float) -> FloatArray:
    """(n, 3) lattice vectors that can bring two beads of the cell within reach."""
    widths = 1.0 / np.linalg.norm(np.linalg.inv(cell), axis=0)
    most = [int(np.ceil(reach / width)) + 1 if axis else 0 for width, axis in zip(widths, periodic, strict=True)]
    numbers = np.array(list(product(*[range(-n, n + 1) for n in most])), dtype=np.float64)
    return np.asarray(numbers @ cell)


def soft(scene: Scene, a: int, b: int) -> tuple[float, float]:
    return SOFT[tuple(sorted((scene.species[a], scene.species[b])))]  # type: ignore[index]  # two names


def brute_force(
    scene: Scene, law: Callable[[Scene, int, int], tuple[float, float]]
) -> tuple[float, FloatArray, FloatArray]:
    """Energy, forces and Σ F r over all ordered pairs and images, half of each; a bead meets its own images too."""
    positions, species = scene.beads.positions, scene.beads.species
    energy, forces, virial = 0.0, np.zeros_like(positions), np.zeros((3, 3))
    for shift in images(scene.cell, PERIODIC[scene.imcon], scene.cutoff):
        own = not shift.any()
        for i in range(len(positions)):
            separation = positions[i] - positions - shift
            distance = np.linalg.norm(separation, axis=1)
            for j in np.nonzero(distance < scene.cutoff)[0]:
                strength, cutoff = law(scene, species[i], species[j])
                if (own and i == j) or distance[j] >= cutoff:
                    continue
                weight = 1.0 - distance[j] / cutoff
                energy += 0.25 * strength * cutoff * weight**2
                if distance[j] > 0.0:
                    force = strength * weight * separation[j] / distance[j]
                    forces[i] += force
                    virial += 0.5 * np.outer(force, separation[j])
    return energy, forces, virial


@pytest.mark.parametrize("name", BOXES)
def test_forces_are_those_of_all_images(name: str) -> None:
    scene = BOXES[name].scene()
    energy, forces, virial = brute_force(scene, soft)
    point = single_point(scene, threads=2)
    scale = max(np.abs(forces).max(), 1.0)
    assert point.energy["pair"] == pytest.approx(energy, rel=1e-11, abs=1e-11)
    assert np.abs(point.forces - forces).max() <= 1e-11 * scale
    volume = abs(np.linalg.det(scene.cell))
    assert np.abs(point.stress * volume - virial).max() <= 1e-11 * max(np.abs(virial).max(), scale)
    assert np.abs(point.forces.sum(axis=0)).max() <= 1e-12 * scale * len(forces)
    if name not in ("one bead alone", "two beads in a cell of a million"):
        assert energy > 0.0
    if name == "two beads in a cell of a million":
        # 0.5 apart along x through the face; the coordinates carry 1e-10 of it.
        assert energy == pytest.approx(0.4 * 40.0 * (1 - np.sqrt(0.3) / 0.8) ** 2, rel=1e-8)


@pytest.mark.parametrize("width", [0.2, 0.4, 1.2, 1.7, 3.0, 50.0])
@pytest.mark.parametrize("name", ["ordinary", "strongly skewed", "thin slab", "slab", "smaller than a cutoff"])
def test_cell_width_changes_no_bit(name: str, width: float) -> None:
    scene = BOXES[name].scene()
    usual = Simulation(scene, seed=1, threads=1)
    other = Simulation(scene, seed=1, threads=1, cell_width=width)
    assert np.array_equal(usual.state.forces, other.state.forces)
    assert usual.energy == other.energy
    assert np.array_equal(usual.observe().stress, other.observe().stress)


@pytest.mark.parametrize(
    "name", ["cubic", "smaller than a cutoff", "strongly skewed", "skewed slab", "not periodic", "thin rod"]
)
def test_energy_is_that_of_the_pairs_of_ase(name: str) -> None:
    scene = BOXES[name].scene()
    periodic = [bool(axis) for axis in PERIODIC[scene.imcon]]
    i, j, distance = primitive_neighbor_list(  # type: ignore[no-untyped-call]  # ase ships no types
        "ijd", periodic, scene.cell, scene.beads.positions, scene.cutoff, self_interaction=False
    )
    # ASE leaves out a bead's own image only at distance 0; half, for every pair comes twice.
    energy = 0.0
    for a, b, r in zip(i, j, distance, strict=True):
        strength, cutoff = soft(scene, scene.beads.species[a], scene.beads.species[b])
        energy += 0.25 * strength * cutoff * max(0.0, 1.0 - r / cutoff) ** 2
    assert single_point(scene).energy["pair"] == pytest.approx(energy, rel=1e-12)


def test_coincident_soft_beads_feel_nothing_and_have_a_finite_energy() -> None:
    scene = make_scene({"A": 3}, cell=6.0, positions=[[1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [-2.0, -2.0, 0.0]])
    point = single_point(scene)
    assert not point.forces.any()
    assert point.energy["pair"] == 12.5  # a rc / 2
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(20)
    assert np.isfinite(simulation.state.positions).all()
    assert simulation.step == 20


@pytest.mark.parametrize("law", ["lj 1.0 1.0", "12-6 4.0 4.0", "buck 1000.0 0.3 5.0"])
def test_coincident_hard_beads_stop_and_are_named(law: str) -> None:
    positions = random_positions(40, 20.0, 2)
    positions[31] = positions[6]
    scene = make_scene({"A": 40}, [f"A A {law}"], cell=20.0, positions=positions, control={**NVE, "cutoff": "2.5 ang"})
    with pytest.raises(RunError, match=r"beads 7 and 32\b"):
        single_point(scene)
    with pytest.raises(RunError, match=r"beads 7 and 32\b"):
        Simulation(scene, seed=1)


@pytest.mark.parametrize("temperature", ["0.0", "0.001", "1.0"])
@pytest.mark.parametrize("law", ["lj 1.0 1.0", "12-6 4.0 4.0", "buck 300.0 0.25 5.0"])
def test_hard_laws_keep_their_precision_at_any_temperature(law: str, temperature: str) -> None:
    """The integer grid of the sums must suit the forces that occur, not those of an overlap that never happens."""
    control = {**NVE, "cutoff": "2.5 ang", "temperature": f"{temperature} dpd_temp", "vdw_long_range_correction": "off"}
    positions = LATTICE + 0.1 * (np.random.default_rng(3).random(LATTICE.shape) - 0.5)
    scene = make_scene({"A": len(positions)}, [f"A A {law}"], cell=4.4, positions=positions, control=control)
    key, *words = law.split()
    energy, forces = hard_pairs(scene, key, [float(word) for word in words])
    point = single_point(scene)
    assert point.energy["pair"] == pytest.approx(energy, rel=1e-9)
    assert np.abs(point.forces - forces).max() <= 1e-9 * np.abs(forces).max()


LATTICE = 1.1 * (np.array(list(product(range(4), repeat=3)), dtype=np.float64) - 1.5)


def hard_pairs(scene: Scene, key: str, p: list[float]) -> tuple[float, FloatArray]:
    """Energy and forces of one hard law over all images within the cutoff."""
    laws: dict[str, Callable[[FloatArray], tuple[FloatArray, FloatArray]]] = {
        "lj": lambda r: (
            4 * p[0] * ((p[1] / r) ** 12 - (p[1] / r) ** 6),
            24 * p[0] * (2 * (p[1] / r) ** 12 - (p[1] / r) ** 6) / r,
        ),
        "12-6": lambda r: (p[0] / r**12 - p[1] / r**6, 12 * p[0] / r**13 - 6 * p[1] / r**7),
        "buck": lambda r: (p[0] * np.exp(-r / p[1]) - p[2] / r**6, p[0] / p[1] * np.exp(-r / p[1]) - 6 * p[2] / r**7),
    }
    positions = scene.beads.positions
    energy, forces = 0.0, np.zeros_like(positions)
    for shift in images(scene.cell, PERIODIC[scene.imcon], scene.cutoff):
        separation = positions[:, None, :] - positions[None, :, :] - shift
        distance = np.linalg.norm(separation, axis=2)
        i, j = np.nonzero((distance < scene.cutoff) & (distance > 0.0))
        r = distance[i, j]
        potential, force = laws[key](r)
        energy += 0.5 * float(potential.sum())
        np.add.at(forces, i, force[:, None] * separation[i, j] / r[:, None])
    return energy, forces


def test_a_hard_bead_does_not_meet_itself_at_distance_0() -> None:
    """One bead a cell is a cubic lattice: the forces of its images cancel."""
    control = {**NVE, "cutoff": "2.5 ang", "vdw_long_range_correction": "off"}
    scene = make_scene({"A": 1}, ["A A lj 1.0 1.0"], cell=1.2, control=control)
    point = single_point(scene)
    energy, _ = hard_pairs(scene, "lj", [1.0, 1.0])
    assert energy < 0.0
    assert point.energy["pair"] == pytest.approx(energy, rel=1e-11)
    assert not point.forces.any()


def test_frozen_beads_feel_nothing_and_do_not_meet_each_other() -> None:
    positions = random_positions(60, 2.5, 9)
    scene = make_scene(
        {"A": 20, "B": 40},
        SOFT_LINES,
        cell=2.5,
        positions=positions,
        frozen=["B"],
        control={**NVE, "cutoff": "1.2 ang"},
    )
    both_frozen = scene.species.index("B")

    def mobile(some: Scene, a: int, b: int) -> tuple[float, float]:
        return (0.0, 0.0) if a == b == both_frozen else soft(some, a, b)

    energy, forces, _ = brute_force(scene, mobile)
    point = single_point(scene)
    assert point.energy["pair"] == pytest.approx(energy, rel=1e-12)
    assert np.abs(point.forces[:20] - forces[:20]).max() <= 1e-11 * np.abs(forces).max()
    assert not point.forces[20:].any()
