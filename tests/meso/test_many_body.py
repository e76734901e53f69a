"""Many-body DPD: densities, energies and forces against plain sums and finite differences, and exact repetition."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from pydlpoly import Scene, Simulation, SinglePoint, single_point
from pydlpoly.engines.native import NativeEngine
from pydlpoly.formats.records import FloatArray

from ..molecule_builder import chains, molecule_scene
from ..scene_builder import NVE, make_scene, random_positions
from .many_body_numpy import Judged, generalised, judge, lucy, warren

TRICLINIC = [[5.1, 0.0, 0.0], [1.3, 4.7, 0.0], [-0.9, 1.6, 5.3]]
SLAB = "A A mdpd -40.0 25.0 1.0 0.75 4.5"
GENERAL = ("A A mdpd -31.0 1.9 3 2.5 1.0 0.8", "A B mdpd -22.0 1.9 2 0 1.1 0.7", "B B mdpd -12.0 1.9 4 2 1.2 0.95")


def densities(scene: Scene, threads: int = 1) -> FloatArray:
    engine = NativeEngine(scene, seed=0, threads=threads)
    engine.initialise()
    return engine.local_densities()


def assert_judged(scene: Scene, expected: Judged, *, energy: bool = True) -> None:
    found, point = densities(scene), single_point(scene)
    assert np.abs(found - expected.densities).max() <= 1e-12 * expected.densities.max()
    assert np.abs(point.forces - expected.forces).max() <= 1e-11 * np.abs(expected.forces).max()
    assert (
        np.abs(point.stress * abs(np.linalg.det(scene.cell)) - expected.virial).max()
        <= 1e-11 * np.abs(expected.virial).max()
    )
    if energy:
        assert point.energy["pair"] == pytest.approx(expected.energy, rel=1e-12)


@pytest.mark.parametrize("cell", [5.0, TRICLINIC], ids=["cube", "triclinic"])
def test_two_density_form(cell: ArrayLike) -> None:
    """F = A w(r/rc) + B (ρ_i + ρ_j) w(r/rd) with W = 15/(2π rd³)(1 − r/rd)², U = Σ π rd⁴ B ρ²/30 + …"""
    b, reach = 25.0, 0.75
    scene = make_scene({"A": 500}, [SLAB], cell=cell, control=NVE)
    strength = math.pi * reach**4 * b / 15.0
    expected = judge(
        scene.beads.positions,
        scene.cell,
        scene.beads.species,
        {(0, 0): warren(-40.0, 1.0, reach)},
        lambda rho: 0.5 * strength * rho**2,
        lambda rho: strength * rho,
    )
    assert 1.0 < expected.densities.mean() < 10.0
    assert_judged(scene, expected)


def test_two_beads_by_hand() -> None:
    """At r = rd/2: ρ = 15/(8π rd³) for both, force A (1 − rd/2rc) + B ρ along their line."""
    reach = 0.75
    scene = make_scene(
        {"A": 2}, ["A A mdpd -40 25 1 0.75"], cell=8.0, control=NVE, positions=[[0, 0, 0], [reach / 2, 0, 0]]
    )
    rho = 15.0 / (8.0 * math.pi * reach**3)
    force = -40.0 * (1.0 - reach / 2) + 25.0 * 2.0 * rho * 0.5
    point = single_point(scene)
    assert densities(scene) == pytest.approx([rho, rho], rel=1e-14)
    assert point.forces == pytest.approx(np.array([[-force, 0, 0], [force, 0, 0]]), rel=1e-12, abs=1e-14)
    energy = -20.0 * (1.0 - reach / 2) ** 2 + 2.0 * math.pi * reach**4 * 25.0 / 30.0 * rho**2
    assert point.energy["pair"] == pytest.approx(energy, rel=1e-13)


def test_generalised_form_of_two_species() -> None:
    """Unequal A, n, rc, rd by pair, m by species, one B; ψ = B ρ^m/m."""
    scene = make_scene({"A": 300, "B": 260}, GENERAL, cell=[5.0, 5.4, 4.8], control=NVE | {"cutoff": "1.2 ang"})
    species = scene.beads.species
    m = np.where(species == 0, 2.5, 2.0)
    expected = judge(
        scene.beads.positions,
        scene.cell,
        species,
        {
            (0, 0): generalised(-31.0, 3, 1.0, 0.8),
            (0, 1): generalised(-22.0, 2, 1.1, 0.7),
            (1, 1): generalised(-12.0, 4, 1.2, 0.95),
        },
        lambda rho: 1.9 * rho**m / m,
        lambda rho: 1.9 * rho ** (m - 1.0),
    )
    assert_judged(scene, expected)


def test_both_forms_are_one_model() -> None:
    """B of the generalised form is π rd⁴/(15 rc⁶) times B, and its densities are rc³ times as large."""
    cutoff, reach, b = 1.3, 0.9, 25.0
    positions = random_positions(400, 5.0, 3)
    control = NVE | {"cutoff": "1.3 ang"}
    general = math.pi * reach**4 / (15.0 * cutoff**6) * b
    two = make_scene({"A": 400}, [f"A A mdpd -40 {b} {cutoff} {reach}"], cell=5.0, control=control, positions=positions)
    one = make_scene(
        {"A": 400},
        [f"A A mdpd -40 {general!r} 2 2 {cutoff} {reach}"],
        cell=5.0,
        control=control,
        positions=positions,
    )
    assert densities(one) == pytest.approx(densities(two) * cutoff**3, rel=1e-13)
    assert single_point(one).forces == pytest.approx(single_point(two).forces, rel=1e-12, abs=1e-10)
    assert single_point(one).energy["pair"] == pytest.approx(single_point(two).energy["pair"], rel=1e-12)


def test_small_cell_counts_all_images() -> None:
    """A cell narrower than rd: a bead meets its own images too, and many images of the others."""
    scene = make_scene({"A": 5}, [SLAB], cell=[0.7, 0.8, 0.9], control=NVE)
    reach, strength = 0.75, math.pi * 0.75**4 * 25.0 / 15.0
    expected = judge(
        scene.beads.positions,
        scene.cell,
        scene.beads.species,
        {(0, 0): warren(-40.0, 1.0, reach)},
        lambda rho: 0.5 * strength * rho**2,
        lambda rho: strength * rho,
        images=2,
    )
    assert_judged(scene, expected)


def test_lucy_kernel() -> None:
    """W = 105/(16π rd³)(1 + 3s)(1 − s)³; the reported energy is that of the A part alone."""
    scene = make_scene({"A": 500}, [SLAB], cell=5.0, control=NVE | {"mdpd_kernel": "lucy"})
    expected = judge(
        scene.beads.positions,
        scene.cell,
        scene.beads.species,
        {(0, 0): lucy(-40.0, 25.0, 1.0, 0.75)},
        np.zeros_like,
        lambda rho: rho,
    )
    assert_judged(scene, expected)
    assert any("no potential belongs to these forces" in note.text for note in scene.notes if note.kind == "warning")
    assert math.isnan(Simulation(scene, seed=1).configurational_temperature)


@pytest.mark.parametrize("case", ["two-density", "generalised", "frozen"])
def test_forces_are_slopes_of_the_energy(case: str) -> None:
    """Central differences of the energy over every coordinate of some beads; frozen neighbours count in densities."""
    rng = np.random.default_rng(7)
    beads = {"A": 100, "B": 60}
    lines = {
        "two-density": [SLAB, "A B mdpd -30 25 0.9 0.75", "B B mdpd -10 25 1.0 0.75"],
        "generalised": list(GENERAL),
    }.get(case, ["A A mdpd -40 25 1 0.75", "A B mdpd -30 25 1 0.75", "B B mdpd 0 25 1 0.75"])
    places = random_positions(160, 3.0, 5)

    def scene_at(positions: FloatArray) -> Scene:
        return make_scene(
            beads,
            lines,
            cell=3.0,
            positions=positions,
            control=NVE | {"cutoff": "1.2 ang"},
            frozen=("B",) if case == "frozen" else (),
        )

    forces = single_point(scene_at(places)).forces
    step = 1e-5
    for bead in rng.choice(100, 6, replace=False):
        for axis in range(3):
            energies = []
            for sign in (1, -1):
                moved = places.copy()
                moved[bead, axis] += sign * step
                energies.append(single_point(scene_at(moved)).energy["total"])
            slope = -(energies[0] - energies[1]) / (2 * step)
            assert forces[bead, axis] == pytest.approx(slope, rel=1e-6, abs=1e-5 * np.abs(forces).max())


def test_bonded_beads_are_no_neighbours() -> None:
    """Pairs without pair forces do not count in densities either, so that forces stay slopes of the energy."""
    bonds = {"bonds": ["harm 1 2 80.0 0.5", "harm 2 3 80.0 0.5"]}
    places = chains(40, 3, 3.0, seed=2)

    def scene_at(positions: FloatArray) -> Scene:
        return molecule_scene(["A"] * 3, bonds, positions, copies=40, pairs=[SLAB[:-4]], cell=3.0)

    scene = scene_at(places)
    assert scene.bonded is not None
    assert len(scene.bonded.excluded) > 0
    forces, step = single_point(scene).forces, 1e-5
    for bead, axis in ((0, 0), (1, 1), (58, 2)):
        moved = [places.copy(), places.copy()]
        moved[0][bead, axis] += step
        moved[1][bead, axis] -= step
        energies = [single_point(scene_at(one)).energy["total"] for one in moved]
        assert forces[bead, axis] == pytest.approx((energies[1] - energies[0]) / (2 * step), rel=1e-5)


def test_virial_is_the_slope_over_the_cell() -> None:
    """−∂U/∂ε of a stretched cell is the virial Σ F_a r_a, axis by axis."""
    places, cell = random_positions(200, 3.4, 6), np.full(3, 3.4)

    def point(stretch: FloatArray) -> SinglePoint:
        scene = make_scene({"A": 200}, [SLAB], cell=cell * stretch, positions=places * stretch, control=NVE)
        return single_point(scene)

    stress = point(np.ones(3)).stress
    for axis in range(3):
        energies = []
        for sign in (1, -1):
            stretch = np.ones(3)
            stretch[axis] += sign * 1e-5
            energies.append(point(stretch).energy["pair"])
        assert stress[axis, axis] * np.prod(cell) == pytest.approx(-(energies[0] - energies[1]) / 2e-5, rel=1e-6)


@pytest.mark.parametrize("case", ["two-density", "generalised", "frozen", "small"])
def test_curvature_is_the_slope_of_the_forces(case: str) -> None:
    """Σ ∂²U/∂x² over the mobile beads, by differences of forces; near the ends of ranges they have corners."""
    small = case == "small"
    beads, edge = ({"A": 4, "B": 3}, 1.3) if small else ({"A": 60, "B": 40}, 3.0)
    lines = list(GENERAL) if case == "generalised" else [SLAB, "A B mdpd -30 25 1 0.75", "B B mdpd 0 25 1 0.75"]
    count = sum(beads.values())
    places = random_positions(count, edge, 11)
    frozen = ("B",) if case == "frozen" else ()

    def scene_at(positions: FloatArray) -> Scene:
        control = NVE | {"cutoff": "1.2 ang"}
        return make_scene(beads, lines, cell=edge, positions=positions, control=control, frozen=frozen)

    scene = scene_at(places)
    engine = NativeEngine(scene, seed=0, threads=1)
    engine.initialise()
    squared, curvature = engine.configurational()
    step, total = 1e-6, 0.0
    for bead in np.nonzero(~scene.beads.frozen)[0]:
        for axis in range(3):
            forces = []
            for sign in (1, -1):
                moved = places.copy()
                moved[bead, axis] += sign * step
                forces.append(single_point(scene_at(moved)).forces[bead, axis])
            total -= (forces[0] - forces[1]) / (2 * step)
    assert curvature == pytest.approx(total, rel=1e-4)
    assert squared == pytest.approx(float(np.sum(single_point(scene).forces ** 2)), rel=1e-12)


def test_frozen_beads_count_in_densities() -> None:
    """Of each other too; what acts among frozen beads alone is in no energy."""
    rng = np.random.default_rng(3)
    places = random_positions(300, 4.0, 9)
    lines = ["A A mdpd -40 25 1 0.75", "A W mdpd -30 25 1 0.75", "W W mdpd -10 25 1 0.75"]
    beads = {"A": 200, "W": 100}
    free = make_scene(beads, lines, cell=4.0, positions=places, control=NVE)
    held = make_scene(beads, lines, cell=4.0, positions=places, control=NVE, frozen=("W",))
    assert np.array_equal(densities(free), densities(held))
    assert np.array_equal(single_point(free).forces[:200], single_point(held).forces[:200])
    alone = make_scene({"W": 100}, ["W W mdpd -10 25 1 0.75"], cell=4.0, positions=places[200:], control=NVE)
    total, wall = single_point(free).energy["pair"], single_point(alone).energy["pair"]
    assert single_point(held).energy["pair"] == pytest.approx(total - wall, rel=1e-12)
    moved = Simulation(held, seed=2)
    moved.run(5)
    again = np.array(moved.state.positions)
    again[200:] += 0.1 * rng.random((100, 3))  # by hand: the sums of the frozen beads must follow
    moved.set_state(positions=again)
    fresh = make_scene(beads, lines, cell=4.0, positions=again, control=NVE, frozen=("W",))
    assert np.array_equal(moved.local_densities(), densities(fresh))


def test_layers_of_stress_add_up() -> None:
    scene = make_scene({"A": 300}, [SLAB], cell=4.0, control=NVE)
    simulation = Simulation(scene, seed=2)
    _, conservative, _, _ = simulation.layer_sums(2, 7)
    total = simulation.observe().stress_parts["conservative"] * 64.0
    assert conservative.sum(axis=0)[:3] == pytest.approx(np.diag(total), rel=1e-9)


@pytest.mark.parametrize("kernel", ["warren", "lucy"])
def test_same_bits_for_any_number_of_threads(kernel: str) -> None:
    results = []
    for threads in (1, 2, 5):
        scene = make_scene(
            {"A": 1500, "W": 1200},
            [SLAB, "A W mdpd -30 25 1 0.75 4.5", "W W mdpd -10 25 1 0.75 4.5"],
            cell=8.0,
            frozen=("W",),
            control={"mdpd_kernel": kernel, "equilibration_force_cap": None},
        )
        simulation = Simulation(scene, seed=5, threads=threads)
        simulation.run(20)
        results.append(
            (simulation.state.positions, simulation.local_densities(), simulation.observe().energy["total"])
            + ((simulation.configurational()[1],) if kernel == "warren" else ())
        )
    for other in results[1:]:
        for one, two in zip(results[0], other, strict=True):
            assert np.array_equal(one, two)


@pytest.mark.parametrize("order", ["mdvv", "second"])
def test_continues_with_the_same_bits(tmp_path: Path, order: str) -> None:
    scene = make_scene({"A": 400}, [SLAB], cell=5.0, control={"ensemble_dpd_order": order})
    whole = Simulation(scene, seed=5)
    whole.run(30)
    half = Simulation(scene, seed=5)
    half.run(14)
    half.save(tmp_path / "REVIVE")
    rest = Simulation.resume(tmp_path / "REVIVE")
    rest.run(16)
    assert np.array_equal(whole.state.positions, rest.state.positions)
    assert np.array_equal(whole.state.velocities, rest.state.velocities)
    assert np.array_equal(whole.local_densities(), rest.local_densities())
    assert rest.scene.many_body == scene.many_body


def test_energy_is_conserved() -> None:
    """nve of a liquid at Δt = 0.002: the total wanders by less than 1e-4 of k_B T a bead, ten times less at Δt/3."""
    wanders = []
    for timestep in (0.003, 0.001):
        scene = make_scene(
            {"A": 768},
            [SLAB],
            cell=5.04,
            positions=lattice(768, 5.04),
            control=NVE | {"timestep": f"{timestep} internal_t"},
        )
        simulation = Simulation(scene, seed=5)
        simulation.run(round(0.6 / timestep))
        energies = []
        for _ in range(20):
            simulation.run(round(0.03 / timestep))
            energies.append(simulation.energy["total"])
        wanders.append(np.std(energies) / 768)
    assert wanders[0] < 2e-4
    assert wanders[1] < wanders[0] / 5.0


def lattice(count: int, edge: float) -> FloatArray:
    """A slightly disturbed simple cubic lattice of about ``count`` sites, the first ``count`` of them."""
    side = math.ceil(count ** (1 / 3))
    sites = (np.stack(np.meshgrid(*[np.arange(side)] * 3), axis=-1).reshape(-1, 3) + 0.5) / side - 0.5
    return np.asarray(sites[:count] * edge + 0.02 * np.random.default_rng(1).standard_normal((count, 3)))


def test_general_path_says_why() -> None:
    plan = make_scene({"A": 400}, [SLAB], cell=5.0, control={"precision": "mixed"}).explain()
    assert "general path: pair forces depend on more than distances" in plan
    assert "precision mixed: forces of local densities are computed in double precision" in plan
