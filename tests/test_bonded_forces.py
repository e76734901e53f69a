"""Bonded terms in whole scenes: exclusions, 1-4 pairs, frozen beads, anchors, stops, threads, restarts, reports."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import RunError, Scene, SceneError, Simulation, single_point
from pydlpoly.formats.records import FloatArray
from pydlpoly.reporters import OutputReporter, statistics_record

from .molecule_builder import Blocks, chains, molecule_scene

CELL = (6.0, 5.0, 7.0)
DPD = {"ensemble": "nvt", "ensemble_method": "dpd", "ensemble_dpd_order": "mdvv"}
PAIRS = ("A A dpd 25.0 1.0 4.5", "A B dpd 40.0 1.0 9.0", "B B dpd 30.0 1.0 4.5")
NAMES = "AABBA"
BONDS = [f"harm {k} {k + 1} 50.0 0.6" for k in range(1, 5)]
ANGLES = [f"harm {k} {k + 1} {k + 2} 4.0 120.0" for k in range(1, 4)]
DIHEDRALS = [f"cos {k} {k + 1} {k + 2} {k + 3} 2.0 0.0 1" for k in range(1, 3)]


def melt(
    blocks: Blocks, copies: int = 60, control: dict[str, str | None] | None = None, cell: tuple[float, ...] = CELL
) -> Scene:
    positions = chains(copies, len(NAMES), cell, seed=2)
    return molecule_scene(NAMES, blocks, positions, copies=copies, pairs=PAIRS, cell=cell, control=control)


def pair_sums(scene: Scene, weight: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Energy, forces and Σ F r of the pair laws by brute force, every pair times its weight, (N, N)."""
    positions, edges = scene.beads.positions, np.diag(scene.cell)
    d = positions[:, None, :] - positions[None, :, :]
    d -= edges * np.rint(d / edges)
    r = np.linalg.norm(d, axis=2)
    strength = np.zeros((len(scene.species),) * 2)
    for term in scene.pairs:
        a, b = term.species
        strength[a, b] = strength[b, a] = term.parameters[0]
    a = strength[scene.beads.species[:, None], scene.beads.species[None, :]]
    closeness = np.where(np.eye(len(r), dtype=bool), 0.0, np.clip(1.0 - r, 0.0, None))
    factor = weight * a * closeness / np.where(r > 0.0, r, 1.0)
    forces = (factor[:, :, None] * d).sum(axis=1)
    virial = 0.5 * np.einsum("ij,ija,ijb->ab", factor, d, d)
    return float((0.25 * weight * a * closeness**2).sum()), forces, virial


def bonded_alone(scene: Scene) -> FloatArray:
    """Forces of the bonded terms without pair laws and 1-4 pairs."""
    pairs = tuple(replace(term, law=None, parameters=()) for term in scene.pairs)
    return single_point(replace(scene, pairs=pairs)).forces


def weights(scene: Scene, excluded: list[tuple[int, int]], scaled: dict[tuple[int, int], float]) -> FloatArray:
    """1 for every pair of beads, 0 for the excluded pairs of each molecule, the factor for scaled ones."""
    size = len(NAMES)
    weight = np.ones((scene.bead_count,) * 2)
    for first in range(0, scene.bead_count, size):
        for (i, j), value in [*((pair, 0.0) for pair in excluded), *scaled.items()]:
            weight[first + i, first + j] = weight[first + j, first + i] = value
    return weight


def restraints(lines: list[str]) -> list[str]:
    words = {"harm": "-hrm", "cos": "-cos"}
    return [words[line.split()[0]] + line[len(line.split()[0]) :] for line in lines]


NEAR = [(0, 1), (1, 2), (2, 3), (3, 4)]
NEXT = [(0, 2), (1, 3), (2, 4)]
FAR = [(0, 3), (1, 4)]
SCALED = [f"{line} 0.0 0.5" for line in DIHEDRALS]


@pytest.mark.parametrize(
    ("blocks", "excluded", "scaled"),
    [
        ({"bonds": BONDS}, NEAR, {}),
        ({"bonds": restraints(BONDS)}, [], {}),
        ({"bonds": [BONDS[0], *restraints(BONDS[1:])]}, NEAR[:1], {}),
        ({"bonds": restraints(BONDS), "angles": ANGLES}, NEAR + NEXT, {}),
        ({"bonds": BONDS, "angles": restraints(ANGLES)}, NEAR, {}),
        ({"bonds": BONDS, "angles": ANGLES}, NEAR + NEXT, {}),
        ({"dihedrals": DIHEDRALS}, NEAR + NEXT + FAR, {}),
        ({"dihedrals": SCALED}, NEAR + NEXT, dict.fromkeys(FAR, 0.5)),
        ({"dihedrals": restraints(DIHEDRALS)}, [], {}),
        ({"inversions": ["plan 2 1 3 4 2.0"]}, list(itertools.combinations(range(4), 2)), {}),
        ({"teth": ["harm 1 10.0"]}, [], {}),
    ],
    ids=["bonds", "-bonds", "one", "angles", "-angles", "both", "dihedrals", "1-4", "-dihedrals", "inversions", "teth"],
)
def test_pair_forces_that_bonded_terms_replace(
    blocks: Blocks, excluded: list[tuple[int, int]], scaled: dict[tuple[int, int], float]
) -> None:
    scene = melt(blocks)
    assert scene.bonded is not None
    assert len(scene.bonded.excluded) == 60 * len(excluded + list(scaled))
    energy, forces, virial = pair_sums(scene, weights(scene, excluded, scaled))
    point = single_point(scene)
    assert point.energy["pair"] == pytest.approx(energy, rel=1e-12)
    assert point.forces - bonded_alone(scene) == pytest.approx(forces, abs=1e-11 * np.abs(point.forces).max())
    observed = Simulation(scene, seed=1, threads=1).observe()
    conservative = observed.stress_parts["conservative"] * observed.volume
    assert conservative == pytest.approx(virial, abs=1e-11 * np.abs(virial).max())
    assert observed.pair_virial == pytest.approx(-virial.trace(), rel=1e-10)


def test_factors_that_share_a_pair() -> None:
    """As in DL_POLY: ends of an angle have no 1-4 pair, and of several dihedrals the first one counts."""
    dihedrals = [f"{DIHEDRALS[0]} 0.0 0.5", "cos 1 3 2 4 1.0 0.0 2 0.0 0.7", f"{DIHEDRALS[1]} 0.0 0.4"]
    scene = melt({"angles": ["harm 2 3 5 4.0 120.0"], "dihedrals": dihedrals}, copies=2)
    assert scene.bonded is not None
    assert scene.bonded.scaled.tolist() == [[0, 3], [5, 8]]
    assert scene.bonded.scales.tolist() == [0.5, 0.5]
    texts = [note.text for note in scene.notes if note.text.startswith("the 1-4 factor")]
    assert texts == [
        "the 1-4 factor 0.7 is dropped, as in DL_POLY: an earlier dihedral has the same ends",
        "the 1-4 factor 0.4 is dropped, as in DL_POLY: an angle has the same ends",
    ]


def test_excluded_pairs_have_no_drag_and_no_noise() -> None:
    positions = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]]
    velocities = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]
    parts = {}
    for key in ("harm", "-hrm"):
        scene = molecule_scene(
            "AA", {"bonds": [f"{key} 1 2 10.0 0.5"]}, positions, pairs=PAIRS[:1], control=DPD, velocities=velocities
        )
        observed = Simulation(scene, seed=1, threads=1).observe()
        parts[key] = {name: float(observed.stress_parts[name].trace()) for name in ("conservative", "drag", "noise")}
    assert parts["harm"] == {"conservative": 0.0, "drag": 0.0, "noise": 0.0}
    assert all(parts["-hrm"].values())


FULL: Blocks = {
    "bonds": BONDS,
    "angles": [f"-hrm {line[5:10]} 20.0 110.0" for line in ANGLES],
    "dihedrals": SCALED,
    "inversions": ["harm 3 2 4 5 1.0 10.0"],
    "teth": ["harm 1 5.0"],
}


def test_energies_and_stress_add_up() -> None:
    scene = melt(FULL, control=DPD)
    simulation = Simulation(scene, seed=3, threads=1)
    simulation.run(20)
    seen = simulation.observe()
    kinds = ("bond", "angle", "dihedral", "inversion", "tether")
    assert all(seen.energy[kind] > 0.0 for kind in kinds)
    assert seen.energy["potential"] == pytest.approx(seen.energy["pair"] + sum(seen.energy[kind] for kind in kinds))
    assert seen.energy["total"] == seen.energy["potential"] + seen.energy["kinetic"]
    assert list(seen.stress_parts) == ["kinetic", "conservative", "drag", "noise", "bonded", "charge"]
    assert seen.stress == pytest.approx(np.sum(list(seen.stress_parts.values()), axis=0))
    bonded = -seen.stress_parts["bonded"].trace() * seen.volume
    assert sum(seen.bonded_virial.values()) == pytest.approx(bonded)
    assert seen.bonded_virial["dihedral"] == pytest.approx(0.0, abs=1e-9)
    row = statistics_record(simulation)
    assert (row.bond_energy, row.angle_energy, row.tether_energy) == tuple(
        seen.energy[kind] for kind in ("bond", "angle", "tether")
    )
    assert row.dihedral_energy == seen.energy["dihedral"] + seen.energy["inversion"]
    assert (row.bond_virial, row.angle_virial, row.tether_virial) == tuple(
        seen.bonded_virial[kind] for kind in ("bond", "angle", "tether")
    )
    assert row.configurational_energy == seen.energy["potential"]


def test_output_has_the_bonded_pressure(tmp_path: Path) -> None:
    for blocks, expected in ((FULL, True), ({}, False)):
        simulation = Simulation(
            melt(blocks, copies=10, control={**DPD, "stats_frequency": "1 steps"}), seed=3, threads=1
        )
        reporter = OutputReporter(simulation, tmp_path / "OUTPUT")
        simulation.reporters.append(reporter)
        simulation.run(2)
        summary = reporter.finish(simulation, [], {})
        reporter.close()
        assert ("bonded" in summary.pressure_parts) == expected
        assert ("of which bonded" in (tmp_path / "OUTPUT").read_text()) == expected


def test_energy_is_conserved_to_second_order_and_so_is_momentum() -> None:
    """Without dihedrals and inversions: forces of these jump where beads pass through a line or a plane."""
    errors = []
    for steps in (500, 1000):
        control = {"timestep": f"{1.0 / steps} internal_t"}
        scene = melt({name: FULL[name] for name in ("bonds", "angles")}, control=control, cell=(9.0, 9.0, 9.0))
        simulation = Simulation(scene, seed=3, threads=1)
        before = simulation.observe()
        simulation.run(steps)
        after = simulation.observe()
        errors.append(abs(after.energy["total"] - before.energy["total"]) / before.energy["total"])
        assert after.energy["bond"] > 1.0 + before.energy["bond"], "the start is no standstill"
        assert np.abs(after.momentum).max() <= 1e-11
    assert errors[0] < 2e-4
    assert errors[1] < 0.35 * errors[0]


def test_same_bits_for_any_threads_and_after_a_restart(tmp_path: Path) -> None:
    scene = melt(FULL, copies=700, control=DPD)  # enough terms for several threads
    assert scene.bead_count == 3500
    first = Simulation(scene, seed=3, threads=1)
    second = Simulation(scene, seed=3, threads=4)
    first.run(6)
    second.run(4)
    second.observe()
    second.save(tmp_path / "REVIVE")
    third = Simulation.resume(tmp_path / "REVIVE", threads=3)
    assert third.observe().energy == second.observe().energy
    assert np.array_equal(third.observe().stress_parts["bonded"], second.observe().stress_parts["bonded"])
    for simulation in (second, third):
        simulation.run(2)
        for name in ("positions", "velocities", "forces"):
            assert np.array_equal(getattr(simulation.state, name), getattr(first.state, name))
        assert simulation.observe().energy == first.observe().energy
        assert np.array_equal(simulation.observe().stress, first.observe().stress)


def test_total_force_is_zero_to_the_bit() -> None:
    """Whole multiples of one grid: their sum in 80-bit numbers has no rounding."""
    blocks = {name: rows for name, rows in FULL.items() if name != "teth"}
    forces = bonded_alone(melt(blocks, copies=200))
    assert not forces.astype(np.longdouble).sum(axis=0).any()


def test_tethers_hold_where_the_run_began(tmp_path: Path) -> None:
    scene = melt(FULL, copies=5)
    simulation = Simulation(scene, seed=3, threads=1)
    simulation.run(5)
    simulation.save(tmp_path / "REVIVE")
    elsewhere = replace(scene, beads=replace(scene.beads, positions=simulation.state.positions))
    assert elsewhere.bonded is not None
    anew = replace(elsewhere, bonded=replace(elsewhere.bonded, anchors=simulation.state.positions))
    resumed = Simulation.resume(tmp_path / "REVIVE", scene=anew, threads=1)
    simulation.run(3)
    resumed.run(3)
    assert np.array_equal(resumed.state.positions, simulation.state.positions)
    assert resumed.observe().energy["tether"] == simulation.observe().energy["tether"] > 0.0


def test_tethers_pull_through_the_faces_of_the_cell() -> None:
    scene = molecule_scene("A", {"teth": ["harm 1 8.0"]}, [[2.9, 0.0, 0.0]], cell=CELL)
    assert scene.bonded is not None
    moved = replace(scene, beads=replace(scene.beads, positions=np.array([[-2.8, 0.0, 0.0]])))
    point = single_point(moved)
    assert point.energy["tether"] == pytest.approx(4.0 * 0.3**2)
    assert point.forces[0] == pytest.approx([-2.4, 0.0, 0.0])
    assert point.virial == pytest.approx(2.4 * 0.3)


def test_frozen_beads_feel_nothing_but_pull_others() -> None:
    positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.2, 0.0, 0.0]]
    bonds = {"bonds": ["harm 1 2 10.0 0.5", "harm 2 3 10.0 0.5"]}
    point = single_point(molecule_scene("AAA", bonds, positions, frozen=[0, 1]))
    assert point.forces == pytest.approx(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-7.0, 0.0, 0.0]]))
    assert point.energy["bond"] == pytest.approx(5.0 * 0.7**2), "the bond between frozen beads does not count"


@pytest.mark.parametrize(
    ("block", "line", "positions", "message"),
    [
        (
            "bonds",
            "fene 1 2 10.0 1.5",
            [[0.0, 0.0, 0.0], [1.5, 0.0, 0.0]],
            "step 0: the bond fene of beads 1 and 2 is not finite at a length of 1.5: it is stretched to R0 or beyond",
        ),
        (
            "bonds",
            "lj 1 2 1.0 1.0",
            [[0.5, 0.0, 0.0], [0.5, 0.0, 0.0]],
            "step 0: the bond lj of beads 1 and 2 is not finite at a length of 0: the beads coincide",
        ),
        (
            "angles",
            "bvs2 1 2 3 1.0 120.0 -2.0 1.0",
            [[0.5, 0.0, 0.0], [0.0, 0.0, 0.0], [0.5, 0.0, 0.0]],
            "step 0: the angle bvs2 of beads 1, 2 and 3 is not finite: the beads fold back on each other, where th^a "
            "has no bound",
        ),
    ],
    ids=["fene", "coincide", "fold"],
)
def test_terms_that_are_not_finite(block: str, line: str, positions: list[list[float]], message: str) -> None:
    scene = molecule_scene("A" * len(positions), {block: [line]}, positions, cell=CELL)
    with pytest.raises(RunError) as caught:
        single_point(scene)
    assert str(caught.value) == message


def test_a_bond_that_breaks_in_a_run() -> None:
    velocities = [[3.0, 0.0, 0.0], [-3.0, 0.0, 0.0]] * 2
    positions = [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 2.0, 0.0], [0.0, 2.0, 0.0]]
    blocks = {"bonds": ["fene 1 2 0.1 1.5"]}
    scene = molecule_scene("AA", blocks, positions, copies=2, cell=CELL, velocities=velocities)
    with pytest.raises(RunError, match=r"^step 9: the bond fene of beads 1 and 2 is not finite at a length of 1\.5"):
        Simulation(scene, seed=1, threads=1).run(50)


def test_a_bond_longer_than_half_the_box() -> None:
    blocks = {"bonds": ["harm 2 1 0.0 0.5"]}
    scene = molecule_scene(
        "AA", blocks, [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], cell=CELL, velocities=[[9.0, 0.0, 0.0], [-9.0, 0.0, 0.0]]
    )
    message = (
        r"^step 9: the bond harm of beads 2 and 1 has beads 2\.62 apart, more than half the cell's width \(2\.5\): "
        r"which image is meant is not certain$"
    )
    with pytest.raises(RunError, match=message):
        Simulation(scene, seed=1, threads=1).run(50)
    with pytest.raises(SceneError) as caught:
        molecule_scene("AA", {"bonds": ["harm 1 2 1.0 0.5"]}, [[0.0, 0.0, 0.0], [0.0, 2.4, 1.0]], cell=CELL)
    assert caught.value.message == (
        "beads 1 and 2 of a bond (FIELD:10) are 2.6 apart, more than half the cell's width (2.5): which image is meant "
        "is not certain"
    )


def test_open_axes_have_no_shortest_image() -> None:
    blocks = {"bonds": ["harm 1 2 1.0 0.5"]}
    point = single_point(molecule_scene("AA", blocks, [[0.0, 0.0, 0.0], [0.0, 0.0, 6.5]], cell=CELL, imcon=6))
    assert point.energy["bond"] == pytest.approx(18.0)


@pytest.mark.parametrize("vectors", [[[6.0, 0, 0], [2.9, 5.0, 0], [-2.0, 1.5, 7.0]]], ids=["triclinic"])
def test_images_in_a_skewed_cell(vectors: list[list[float]]) -> None:
    """The same molecules, wrapped into the cell and not: terms see the same shape."""
    positions = chains(40, 5, vectors, seed=5)
    whole = molecule_scene(
        NAMES, {"bonds": BONDS, "angles": ANGLES, "dihedrals": DIHEDRALS}, positions, copies=40, cell=50.0
    )
    cut = molecule_scene(
        NAMES, {"bonds": BONDS, "angles": ANGLES, "dihedrals": DIHEDRALS}, positions, copies=40, cell=vectors
    )
    assert not np.allclose(cut.beads.positions, positions)
    a, b = single_point(whole), single_point(cut)
    assert b.forces == pytest.approx(a.forces, abs=1e-11 * np.abs(a.forces).max())
    for kind in ("bond", "angle", "dihedral"):
        assert b.energy[kind] == pytest.approx(a.energy[kind], rel=1e-12)


def test_plan_names_the_reason() -> None:
    """Excluded pairs need the general path; restraint forms, whose beads keep their pair forces, do not."""
    assert "general path: bonded beads have no pair forces" in melt({"bonds": BONDS}, control=DPD).explain()
    restraints = [bond.replace("harm", "-hrm") for bond in BONDS]
    assert "fast path" in melt({"bonds": restraints}, control=DPD).explain()
