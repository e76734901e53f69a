"""Electrostatics in whole scenes: lattice sums, slopes, mesh against plain sum, exclusions, frozen beads, paths."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import RunError, Scene, Simulation, load, single_point
from pydlpoly.formats.records import FloatArray
from pydlpoly.reporters import statistics_record
from pydlpoly.scene.model import Electrostatics

from .molecule_builder import chains, molecule_scene
from .scene_builder import NVE, make_scene

EWALD = {"coul_method": "ewald_direct", "spme_alpha": "1.2 ang^-1", "spme_kvec": "[ 24 24 24 ]", "cutoff": "2.5 ang"}
MESH = {**EWALD, "coul_method": "spme", "spme_kvec": "[ 24 24 24 ]", "spme_nsplines": "10"}
STRENGTH = {"coul_bjerrum_length": "1.3 ang"}
SMEARED = {"charge_smearing_method": "slater", "charge_smearing_length": "0.7 ang"}
TRICLINIC = np.array([[5.0, 0.0, 0.0], [1.2, 5.4, 0.0], [-0.9, 0.7, 5.8]])
SALT = {"A": 1.0, "B": -1.0, "W": 0.0}
BEADS = {"A": 10, "W": 6, "B": 10}


def salt(control: dict[str, str | None], cell: object = 6.0, **options: object) -> Scene:
    """Point or smeared ions and neutral beads at random places, without pair laws."""
    settings = {**NVE, **STRENGTH, **control}
    return make_scene(BEADS, (), cell=cell, charges=SALT, control=settings, start_seed=3, **options)  # type: ignore[arg-type]


def moved(scene: Scene, positions: FloatArray) -> Scene:
    return replace(scene, beads=replace(scene.beads, positions=positions))


def charges_of(scene: Scene) -> Electrostatics:
    assert scene.electrostatics is not None
    return scene.electrostatics


def rock_salt(method: dict[str, str]) -> Scene:
    grid = np.array(list(itertools.product(range(4), repeat=3)))
    odd = grid.sum(axis=1) % 2
    order = np.argsort(odd, kind="stable")
    return make_scene(
        {"A": 32, "B": 32},
        (),
        cell=4.0,
        positions=(grid - 1.5)[order],
        charges=SALT,
        control={**NVE, "coul_bjerrum_length": "1.0 ang", "cutoff": "2.4 ang", "spme_alpha": "3.0 ang^-1", **method},
    )


@pytest.mark.parametrize(
    "method",
    [
        {"coul_method": "ewald_direct", "spme_kvec": "[ 44 44 44 ]"},
        {"coul_method": "spme", "spme_kvec": "[ 48 48 48 ]", "spme_nsplines": "12"},
    ],
    ids=["plain", "mesh"],
)
def test_madelung_constant_of_rock_salt(method: dict[str, str]) -> None:
    point = single_point(rock_salt(method))
    assert -point.energy["charge"] / 32 == pytest.approx(1.7475645946331822, abs=2e-9)
    assert point.virial == pytest.approx(-point.energy["charge"], rel=1e-8)
    assert np.abs(point.forces).max() < 1e-9


VARIANTS: dict[str, dict[str, str | None]] = {
    "plain": EWALD,
    "mesh": MESH,
    "mesh of smeared charges": {**MESH, **SMEARED},
    "exact slater": {**EWALD, **SMEARED, "charge_smearing_method": "slater-exact"},
    "gaussian": {**EWALD, **SMEARED, "charge_smearing_method": "gaussian"},
    "linear": {**EWALD, **SMEARED, "charge_smearing_method": "linear"},
    "pairwise": {"coul_method": "pairwise", "cutoff": "4.9 ang"},
    "dddp": {"coul_method": "dddp", "cutoff": "4.9 ang"},
    "shifted": {"coul_method": "force_shifted", "cutoff": "2.5 ang"},
    "damped": {"coul_method": "force_shifted", "cutoff": "2.5 ang", "coul_damping": "0.4 ang^-1"},
    "reaction field": {
        "coul_method": "reaction_field",
        "cutoff": "2.5 ang",
        "coul_precision": "1e-3",
        "coul_dielectric_constant": "20.0",
    },
}


@pytest.mark.parametrize("cell", [6.0, TRICLINIC], ids=["cubic", "triclinic"])
@pytest.mark.parametrize("name", VARIANTS)
def test_forces_are_slopes_of_the_energy(name: str, cell: object) -> None:
    """Each ion's force; steps so short that no pair crosses the cutoff, where truncated energies jump."""
    scene = salt(VARIANTS[name], cell)
    positions, forces = scene.beads.positions, single_point(scene).forces
    step = 2e-5
    for bead, axis in ((0, 0), (3, 1), (17, 2), (25, 0)):
        energies = []
        for sign in (1.0, -1.0):
            places = positions.copy()
            places[bead, axis] += sign * step
            energies.append(single_point(moved(scene, places)).energy["charge"])
        slope = -(energies[0] - energies[1]) / (2.0 * step)
        assert slope == pytest.approx(forces[bead, axis], rel=1e-7, abs=2e-7 * np.abs(forces).max())
    assert (forces[10:16] == 0.0).all()  # neutral beads
    assert np.abs(forces.sum(axis=0)).max() <= 1e-13 * np.abs(forces).max()


@pytest.mark.parametrize("name", ["plain", "mesh", "mesh of smeared charges", "shifted", "reaction field"])
def test_stress_is_the_slope_of_the_energy(name: str) -> None:
    """All nine components, by straining cell and beads; DL_POLY's sign of the stress is that of a pressure."""
    scene = salt(VARIANTS[name], TRICLINIC)
    point = single_point(scene)
    step = 1e-6
    for a, b in itertools.product(range(3), repeat=2):
        energies = []
        for sign in (1.0, -1.0):
            strain = np.eye(3)
            strain[b, a] += sign * step
            energies.append(
                single_point(replace(moved(scene, scene.beads.positions @ strain), cell=scene.cell @ strain)).energy
            )
        slope = -(energies[0]["charge"] - energies[1]["charge"]) / (2.0 * step * abs(np.linalg.det(scene.cell)))
        assert slope == pytest.approx(point.stress[a, b], rel=1e-6, abs=1e-6 * np.abs(point.stress).max()), (a, b)


@pytest.mark.parametrize("cell", [6.0, TRICLINIC], ids=["cubic", "triclinic"])
@pytest.mark.parametrize("precision", ["1e-3", "1e-5", "1e-7"])
def test_mesh_and_plain_sum_agree_to_the_precision(precision: str, cell: object) -> None:
    control = {"cutoff": "2.5 ang", "spme_precision": precision}
    mesh = single_point(salt({"coul_method": "spme", **control}, cell))
    plain = salt({"coul_method": "ewald_direct", **control}, cell)
    exact = salt({**EWALD, "spme_alpha": "2.0 ang^-1", "spme_kvec": "[ 60 60 60 ]"}, cell)
    forces = single_point(exact).forces
    largest = np.abs(forces).max()
    for found in (mesh.forces, single_point(plain).forces):
        assert np.sqrt(np.mean((found - forces) ** 2)) <= 2.0 * float(precision) * largest + 1e-9 * largest


@pytest.mark.parametrize("shape", ["none", "slater", "slater-exact", "gaussian", "linear"])
def test_result_does_not_depend_on_alpha(shape: str) -> None:
    """What the pairs give away the reciprocal vectors take up, whatever the shape; so the shapes' 1/r is theirs."""
    results = []
    for alpha, vectors in (("1.6", 40), ("2.4", 64)):
        control = {"spme_alpha": f"{alpha} ang^-1", "spme_kvec": f"[ {vectors} {vectors} {vectors} ]"}
        smearing = {} if shape == "none" else {"charge_smearing_method": shape, "charge_smearing_length": "0.35 ang"}
        results.append(single_point(salt({**EWALD, **smearing, "cutoff": "4.8 ang", **control})))
    first, second = results
    assert first.energy["charge"] == pytest.approx(second.energy["charge"], rel=1e-9)
    assert np.abs(first.forces - second.forces).max() <= 1e-8 * np.abs(first.forces).max()


def test_one_charge_alone_is_a_wigner_crystal() -> None:
    """A charge, its images and the background: −2.837297 q²/(2 L) (cubic lattice)."""
    scene = make_scene(
        {"A": 1},
        (),
        cell=4.0,
        charges=SALT,
        control={**NVE, **STRENGTH, **EWALD, "spme_alpha": "2.4 ang^-1", "spme_kvec": "[ 40 40 40 ]"},
    )
    point = single_point(scene)
    assert point.energy["charge"] == pytest.approx(-0.5 * 2.837297479480620 * 1.3 / 4.0, rel=1e-9)
    assert point.virial == pytest.approx(-point.energy["charge"], rel=1e-8)
    assert (point.forces == 0.0).all()
    assert any("add up to 1 e: a uniform background" in note.text for note in scene.notes)


def test_charged_cell_does_not_depend_on_alpha() -> None:
    energies = []
    for alpha in ("1.6 ang^-1", "2.2 ang^-1"):
        control = {**NVE, **STRENGTH, **EWALD, "cutoff": "3.9 ang", "spme_kvec": "[ 60 60 60 ]", "spme_alpha": alpha}
        scene = make_scene({"A": 7, "B": 2}, (), cell=5.0, charges=SALT, control=control)
        point = single_point(scene)
        energies.append((point.energy["charge"], point.virial))
    assert energies[0] == pytest.approx(energies[1], rel=1e-9)


def test_cells_smaller_than_the_cutoff_count_every_image() -> None:
    small = make_scene({"A": 2, "B": 2}, (), cell=1.6, charges=SALT, control={**NVE, **STRENGTH, **EWALD})
    shifts = np.array(list(itertools.product(range(3), repeat=3))) * 1.6
    places = (small.beads.positions[:, None] + shifts[None] + 0.8 - 2.4).reshape(4, 27, 3)
    large = make_scene(
        {"A": 54, "B": 54},
        (),
        cell=4.8,
        positions=places.reshape(-1, 3),
        charges=SALT,
        control={**NVE, **STRENGTH, **EWALD, "spme_kvec": "[ 72 72 72 ]"},
    )
    one, many = single_point(small), single_point(large)
    assert 27 * one.energy["charge"] == pytest.approx(many.energy["charge"], rel=1e-10)
    assert many.forces.reshape(4, 27, 3)[:, 5] == pytest.approx(one.forces, rel=1e-8, abs=1e-9)
    assert many.stress == pytest.approx(one.stress, rel=1e-8, abs=1e-10)


# -- molecules --------------------------------------------------------------------------------------------------------


def chain_scene(blocks: dict[str, list[str]], control: dict[str, str | None], frozen: tuple[int, ...] = ()) -> Scene:
    positions = chains(12, 4, 6.0, seed=4, step=0.9)
    return molecule_scene(
        "ABAB",
        blocks,
        positions,
        copies=12,
        cell=6.0,
        charges=(1.0, -1.0, 0.5, -0.5),
        control={**STRENGTH, **control},
        frozen=frozen,
    )


def pair_energy(scene: Scene, pairs: list[tuple[int, int]]) -> float:
    """Σ λ q_i q_j/r of the nearest images."""
    d = np.array([scene.beads.positions[i] - scene.beads.positions[j] for i, j in pairs])
    d -= 6.0 * np.rint(d / 6.0)
    q = scene.beads.charge
    products = np.array([q[i] * q[j] for i, j in pairs])
    return float(1.3 * np.sum(products / np.linalg.norm(d, axis=1)))


@pytest.mark.parametrize("control", [EWALD, MESH], ids=["plain", "mesh"])
def test_excluded_pairs_lose_all_of_their_interaction(control: dict[str, str | None]) -> None:
    precise = {**control, "spme_kvec": "[ 40 40 40 ]", "spme_nsplines": "14"}
    bonds = {"bonds": ["harm 1 2 50.0 0.9", "harm 3 4 50.0 0.9"]}
    kept = {"bonds": [line.replace("harm", "-hrm") for line in bonds["bonds"]]}
    without, whole = chain_scene(bonds, precise), chain_scene(kept, precise)
    pairs = [(4 * k + a, 4 * k + a + 1) for k in range(12) for a in (0, 2)]
    difference = single_point(whole).energy["charge"] - single_point(without).energy["charge"]
    assert difference == pytest.approx(pair_energy(whole, pairs), rel=1e-6)


def test_scaled_ends_of_dihedrals() -> None:
    plain = ["cos 1 2 3 4 2.0 0.0 1", "cos 1 2 3 4 2.0 0.0 1 0.4 0.0"]
    scenes = [chain_scene({"dihedrals": [line]}, EWALD) for line in plain]
    difference = single_point(scenes[1]).energy["charge"] - single_point(scenes[0]).energy["charge"]
    assert difference == pytest.approx(0.4 * pair_energy(scenes[0], [(4 * k, 4 * k + 3) for k in range(12)]), rel=1e-9)
    off = chain_scene({"dihedrals": plain[1:]}, {"coul_method": "off"})
    assert any("electrostatic 1-4 factors" in note.text for note in off.notes)


@pytest.mark.parametrize("control", [EWALD, MESH, VARIANTS["shifted"]], ids=["plain", "mesh", "shifted"])
def test_forces_with_exclusions_and_scaled_pairs(control: dict[str, str | None]) -> None:
    scene = chain_scene({"bonds": ["harm 1 2 50.0 0.9"], "dihedrals": ["cos 1 2 3 4 2.0 0.0 1 0.4 0.0"]}, control)
    forces, step = single_point(scene).forces, 2e-5
    for bead, axis in ((0, 0), (3, 1), (18, 2)):
        energies = []
        for sign in (1.0, -1.0):
            places = scene.beads.positions.copy()
            places[bead, axis] += sign * step
            energies.append(single_point(moved(scene, places)).energy["total"])
        slope = -(energies[0] - energies[1]) / (2.0 * step)
        assert slope == pytest.approx(forces[bead, axis], rel=1e-6, abs=1e-6 * np.abs(forces).max())


def test_coulomb_bonds() -> None:
    """k q_i q_j/(4 pi eps r), with electrostatics off; in kJ and Å the strength is DL_POLY's constant."""
    scene = molecule_scene(
        "AB",
        {"bonds": ["coul 1 2 0.5"]},
        [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        units="kj",
        charges=(1.0, -2.0),
        control={"temperature": "300 K", "cutoff": "4.0 ang", "coul_dielectric_constant": "4.0"},
    )
    point = single_point(scene)
    assert point.energy["bond"] == pytest.approx(-0.5 * 2.0 * 138935.4835 / 4.0 / 2.0, rel=1e-14)
    assert point.forces[0, 0] == pytest.approx(0.5 * 2.0 * 138935.4835 / 4.0 / 4.0, rel=1e-12)
    assert point.energy["charge"] == 0.0


def test_frozen_beads_have_no_energy_among_themselves() -> None:
    """The energy of frozen and mobile charges is that of all without that of the frozen ones alone."""
    positions = np.asarray(salt(EWALD).beads.positions)
    control = {**NVE, **STRENGTH, **MESH}

    def energy(beads: dict[str, int], places: FloatArray, frozen: tuple[str, ...] = ()) -> tuple[float, float]:
        scene = make_scene(beads, (), cell=6.0, charges=SALT, control=control, positions=places, frozen=frozen)
        point = single_point(scene)
        assert (point.forces[scene.beads.frozen] == 0.0).all()
        return point.energy["charge"], point.virial

    whole, alone = energy(BEADS, positions), energy({"A": 10}, positions[:10])
    mixed = energy(BEADS, positions, ("A",))
    assert mixed == pytest.approx((whole[0] - alone[0], whole[1] - alone[1]), rel=1e-9)


# -- runs -------------------------------------------------------------------------------------------------------------

LAWS = [f"{a} {b} dpd 25.0 1.0 4.5" for a, b in itertools.combinations_with_replacement("WAB", 2)]
ELECTROLYTE = {
    "coul_method": "spme",
    "cutoff": "3.0 ang",
    "coul_coupling": "13.87",
    "charge_smearing_method": "slater",
    "charge_smearing_length": "1.076 ang",
    "spme_precision": "1e-4",
}


def electrolyte(
    control: dict[str, str | None] | None = None, edge: float = 6.0, ions: int = 40, seed: int = 1
) -> Scene:
    count = round(3.0 * edge**3) - 2 * ions
    return make_scene(
        {"W": count, "A": ions, "B": ions},
        LAWS,
        cell=edge,
        charges=SALT,
        control={**ELECTROLYTE, **(control or {})},
        start_seed=seed,
    )


def bits(simulation: Simulation) -> tuple[bytes, ...]:
    state, seen = simulation.state, simulation.observe()
    arrays = (state.positions, state.velocities, state.forces, seen.stress)
    return (*(a.tobytes() for a in arrays), repr(sorted(seen.energy.items())).encode())


PATHS = {
    "fast": ({}, "double"),
    "mixed": ({}, "mixed"),
    "general": ({"ensemble_dpd_order": "second"}, "double"),
    "reference": ({}, "reference"),
    "plain sum": ({"coul_method": "ewald_direct"}, "double"),
}


@pytest.mark.parametrize("path", PATHS)
def test_same_bits_for_any_number_of_threads(path: str) -> None:
    control, precision = PATHS[path]
    results = set()
    for threads in (1, 2, 3):
        simulation = Simulation(electrolyte(control, ions=300), seed=4, threads=threads, precision=precision)  # type: ignore[arg-type]
        simulation.run(3)
        results.add(bits(simulation))
    assert len(results) == 1


@pytest.mark.parametrize("path", PATHS)
def test_checkpoint_continues_with_the_same_bits(path: str, tmp_path: Path) -> None:
    control, precision = PATHS[path]
    straight = Simulation(electrolyte(control), seed=4, threads=1, precision=precision)  # type: ignore[arg-type]
    straight.run(4)
    straight.save(tmp_path / "REVIVE")
    resumed = Simulation.resume(tmp_path / "REVIVE", threads=2)
    assert resumed.observe().energy == straight.observe().energy
    for simulation in (straight, resumed):
        simulation.run(5)
    assert bits(straight) == bits(resumed)


def test_fast_and_general_path_have_the_same_forces() -> None:
    scene = electrolyte({**NVE}, ions=100)
    fast = Simulation(scene, seed=1, threads=2)
    assert "fast path" in scene.explain()
    general = single_point(replace(scene, dynamics=replace(scene.dynamics, precision="reference")))
    assert fast.state.forces == pytest.approx(general.forces, abs=1e-8 * np.abs(general.forces).max())
    assert fast.observe().energy["charge"] == pytest.approx(general.energy["charge"], rel=1e-10)
    assert fast.observe().energy["charge"] < -1.0


def test_fast_path_with_bonds_and_charges() -> None:
    positions = chains(150, 4, 6.0, seed=4, step=0.9)
    pairs = [f"{a} {b} dpd 25.0 1.0 4.5" for a, b in ("AA", "AB", "BB")]
    scene = molecule_scene(
        "ABAB",
        {"bonds": [f"-hrm {k} {k + 1} 50.0 0.9" for k in (1, 2, 3)]},
        positions,
        copies=150,
        pairs=pairs,
        cell=6.0,
        charges=(1.0, -1.0, 0.0, 0.0),
        control=ELECTROLYTE,
    )
    assert "fast path" in scene.explain()
    general = single_point(replace(scene, dynamics=replace(scene.dynamics, precision="reference")))
    fast = Simulation(scene, seed=1, threads=2)
    assert fast.state.forces == pytest.approx(general.forces, abs=1e-8 * np.abs(general.forces).max())
    fast.run(20)
    assert np.abs(fast.observe().momentum).max() < 1e-9


def test_energy_is_conserved() -> None:
    """Point charges with a hard repulsion, on the mesh: the total energy keeps to 4e-4 of the potential's changes."""
    pairs = [f"{a} {b} 12-6 1.0 0.0" for a, b in ("AA", "AB", "BB")]
    grid = np.array(list(itertools.product(range(4), repeat=3)))
    order = np.argsort(grid.sum(axis=1) % 2, kind="stable")
    velocities = np.random.default_rng(1).normal(size=(64, 3))
    scene = make_scene(
        {"A": 32, "B": 32},
        pairs,
        cell=6.0,
        positions=((grid - 1.5) * 1.5)[order],
        velocities=velocities - velocities.mean(axis=0),
        charges=SALT,
        control={
            **NVE,
            **STRENGTH,
            **MESH,
            "spme_alpha": "1.6 ang^-1",
            "spme_kvec": "[ 36 36 36 ]",
            "timestep": "0.001 internal_t",
        },
    )
    simulation = Simulation(scene, seed=1, threads=1)
    seen = []
    for _ in range(20):
        simulation.run(20)
        seen.append((simulation.energy["total"], simulation.energy["charge"]))
    total, charge = np.array(seen).T
    assert np.ptp(total) < 4e-4 * np.ptp(charge)
    assert np.abs(simulation.observe().momentum).max() < 1e-10


@pytest.mark.parametrize("name", ["plain", "mesh", "mesh of smeared charges", "shifted", "damped", "reaction field"])
def test_curvature_is_the_second_derivative(name: str) -> None:
    """Σ∇²U by differences of forces; the configurational temperature needs it."""
    scene = salt(VARIANTS[name])
    _, curvature = Simulation(scene, seed=1, threads=1).configurational()
    total, size, step = 0.0, 0.0, 1e-5
    for bead in np.nonzero(scene.beads.charge)[0]:
        for axis in range(3):
            slopes = []
            for sign in (1.0, -1.0):
                places = scene.beads.positions.copy()
                places[bead, axis] += sign * step
                slopes.append(single_point(moved(scene, places)).forces[bead, axis])
            second = -(slopes[0] - slopes[1]) / (2.0 * step)
            total, size = total + second, size + abs(second)
    assert curvature == pytest.approx(total, abs=2e-5 * size)


def test_opposite_smeared_charges_at_one_place_feel_nothing() -> None:
    scene = make_scene(
        {"A": 1, "B": 1},
        (),
        cell=8.0,
        positions=np.zeros((2, 3)),
        charges=SALT,
        control={**NVE, **ELECTROLYTE},
    )
    point = single_point(scene)
    assert np.abs(point.forces).max() < 1e-12
    assert math.isfinite(point.energy["charge"])
    for method in ("pairwise", "force_shifted", "reaction_field"):
        assert (
            single_point(replace(scene, electrostatics=replace(charges_of(scene), method=method))).forces == 0
        ).all()


@pytest.mark.parametrize("method", ["ewald_direct", "spme", "pairwise", "dddp", "force_shifted", "reaction_field"])
def test_coincident_point_charges_stop_the_run(method: str) -> None:
    positions = [[1.0, 1.0, 1.0], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]
    numbers = EWALD if method in ("ewald_direct", "spme") else {"cutoff": "2.5 ang"}
    scene = make_scene(
        {"A": 2, "B": 1},
        (),
        cell=6.0,
        positions=positions,
        charges=SALT,
        control={**NVE, **STRENGTH, **numbers, "coul_method": method},
    )
    with pytest.raises(RunError, match=r"step 0: the Coulomb force between beads 1 and 3 is not finite .* of 0; point"):
        Simulation(scene, seed=1)


def test_coincident_point_charges_stop_the_fast_path() -> None:
    scene = electrolyte({"charge_smearing_method": "none"})
    positions = scene.beads.positions.copy()
    positions[-1] = positions[-3]
    count = scene.bead_count
    with pytest.raises(RunError, match=f"the Coulomb force between beads {count - 2} and {count} is not finite"):
        Simulation(moved(scene, positions), seed=1, threads=2)


def test_cell_that_follows_the_pressure() -> None:
    control = {
        "ensemble": "npt",
        "ensemble_method": "langevin",
        "ensemble_dpd_order": None,
        "ensemble_thermostat_friction": "1.0 ps^-1",
        "ensemble_barostat_friction": "1.0 ps^-1",
        "pressure_hydrostatic": "20.0 dpd_p",
    }
    scene = electrolyte(control)
    simulation = Simulation(scene, seed=2, threads=1)
    simulation.run(30)
    state, seen = simulation.state, simulation.observe()
    assert not np.array_equal(state.cell, scene.cell)
    point = single_point(replace(moved(scene, state.positions), cell=state.cell))
    assert seen.energy["charge"] == pytest.approx(point.energy["charge"], rel=1e-12)
    assert seen.stress_parts["charge"].trace() * seen.volume == pytest.approx(-seen.charge_virial, rel=1e-12)


def test_energy_with_a_piston_is_conserved() -> None:
    """The piston feels the pressure of the charges: energy and P V are kept to second order in the timestep.

    Short-ranged smeared charges, so that nothing is left at the cutoff, in a lattice with room to breathe.
    """
    still = dict.fromkeys(("ensemble_thermostat_friction", "ensemble_barostat_friction"), "1e-12 internal_t^-1")
    grid = np.array(list(itertools.product(range(4), repeat=3)))
    order = np.argsort(grid.sum(axis=1) % 2, kind="stable")
    spread = []
    for timestep in (0.008, 0.004):
        scene = make_scene(
            {"A": 32, "B": 32},
            [f"{pair} dpd 25.0 1.0" for pair in ("A A", "A B", "B B")],
            cell=3.0,
            positions=((grid - 1.5) * 0.75)[order],
            charges=SALT,
            control={
                **MESH,
                **still,
                "ensemble": "npt",
                "ensemble_method": "langevin",
                "ensemble_dpd_order": None,
                "ensemble_barostat_coupling": "0.5 internal_t",
                "pressure_hydrostatic": "10.0 dpd_p",
                "timestep": f"{timestep} internal_t",
                "coul_bjerrum_length": "8.0 ang",
                "charge_smearing_method": "gaussian",
                "charge_smearing_length": "0.2 ang",
                "spme_alpha": "2.0 ang^-1",
            },
        )
        simulation = Simulation(scene, seed=3, threads=1)
        energies = []
        for _ in range(round(1.0 / timestep)):
            simulation.run(1)
            seen = simulation.observe()
            kinetic = 0.5 * float((simulation.state.velocities**2).sum())
            energies.append(seen.energy["potential"] + kinetic + seen.energy["thermostat"])
        spread.append(float(np.ptp(energies)))
    assert spread[0] / spread[1] == pytest.approx(4.0, rel=0.25)
    assert abs(seen.volume / 27.0 - 1.0) > 0.01


def test_statistics_have_the_electrostatic_columns() -> None:
    simulation = Simulation(electrolyte(), seed=1, threads=1)
    record, seen = statistics_record(simulation), simulation.observe()
    assert record.electrostatic_energy == seen.energy["charge"] != 0.0
    assert record.electrostatic_virial == seen.charge_virial != 0.0
    assert record.configurational_energy == pytest.approx(seen.energy["pair"] + seen.energy["charge"], rel=1e-14)
    parts = sum(tensor for tensor in seen.stress_parts.values())
    assert np.asarray(parts) == pytest.approx(seen.stress, rel=1e-12)


def test_explain_says_what_acts() -> None:
    text = " ".join(electrolyte().explain().split())
    for words in (
        "80 charged beads (A, B), total charge 0 e",
        "Bjerrum length 1.10373953 from coul_coupling 13.87",
        "approximate Slater charges",
        "L = 1.076",
        "alpha = 0.886006811, for a precision of 0.0001",
        "splines of order 8",
    ):
        assert words in text, words


@pytest.mark.parametrize("edge", [1e-6, 1.0, 1e6])
def test_scales_of_length(edge: float) -> None:
    """The same salt in any unit of length: energies go as 1/length, forces as 1/length²."""
    factor = edge / 6.0
    control = {
        **EWALD,
        "cutoff": f"{2.5 * factor!r} ang",
        "spme_alpha": f"{1.2 / factor!r} ang^-1",
        "coul_bjerrum_length": f"{1.3 * factor!r} ang",
    }
    base = salt(EWALD)
    scene = salt(control, edge, positions=base.beads.positions * factor)
    one, other = single_point(base), single_point(scene)
    assert other.energy["charge"] == pytest.approx(one.energy["charge"], rel=1e-9)
    assert other.forces * factor == pytest.approx(one.forces, rel=1e-9, abs=1e-9 * np.abs(one.forces).max())


def test_uncharged_scene_takes_no_part(shared: Path) -> None:
    scene = load(shared / "golden" / "pair-dpd")
    assert scene.electrostatics is None
    assert single_point(scene).energy["charge"] == 0.0
