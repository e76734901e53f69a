"""Every golden case of a real DL_POLY: forces, energies, virials, pressures and short runs.

DL_POLY printed forces with 10 digits and the rows of STATIS with 7; the tolerances are those digits.
"""

from __future__ import annotations

import json
import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pydlpoly import Scene, Simulation, _core, load, single_point
from pydlpoly.formats.records import FloatArray
from pydlpoly.reporters import statistics_record

GOLDEN = Path(__file__).resolve().parents[2] / "shared" / "golden"
CASES = sorted(folder.name for folder in GOLDEN.iterdir() if folder.is_dir()) if GOLDEN.is_dir() else []
NUMBER_OF_CASES = 68

PRINTED = 1e-6  # 7 significant digits
FOLLOWED = 2e-6  # 7 digits of a row, and the drift of a trajectory that starts from 12 decimals


def test_all_cases_are_there(shared: Path) -> None:
    assert (shared / "golden").resolve() == GOLDEN.resolve()
    assert len(CASES) == NUMBER_OF_CASES


@pytest.mark.parametrize("case", CASES)
def test_golden_case(case: str) -> None:
    folder = GOLDEN / case
    expected = json.loads((folder / "expected.json").read_text())
    scene = load(folder)
    if case.startswith("run-"):
        assert_follows(scene, expected)
    elif case.startswith(("pair-", "units-", "bond-", "angle-", "dihedral-")):
        assert_single_point(scene, expected)
    elif case.startswith("coul-ewald-"):
        assert_mesh(scene, expected)
    elif case.startswith("coul-"):
        assert_single_point(scene, expected)
    else:
        pytest.fail(f"{case} belongs to no known kind of case")


@pytest.mark.parametrize("case", [case for case in CASES if not case.startswith(("run-", "coul-ewald-"))])
def test_row_of_statis(case: str) -> None:
    """All 27 columns that DL_POLY wrote, enthalpy and cell angles among them, as exact as the largest part of a sum."""
    row = json.loads((GOLDEN / case / "expected.json").read_text())["statis"]
    found = statistics_record(Simulation(load(GOLDEN / case), seed=1, threads=1))
    columns = [column.name for column in fields(found)][2:29]  # after step and time
    printed = max(abs(row["engcns"]), abs(row["engcfg"])) * PRINTED * 1e-3
    assert len(row) == len(columns)
    for column, (name, value) in zip(columns, row.items(), strict=True):
        assert getattr(found, column) == pytest.approx(value, rel=2.0 * PRINTED, abs=printed), name


def assert_mesh(scene: Scene, expected: dict[str, Any]) -> None:
    """Energy and forces within the error that DL_POLY's mesh of 14 points leaves, and its virial within ten times that.

    In the triclinic cell DL_POLY's forces are no slopes of its energy: of the cell's inverse, which turns slopes along
    the cell vectors into forces, only a diagonal is left. That this is all that differs is what the comparison shows.
    """
    assert scene.field_units is not None
    unit, row = scene.field_units.factor, expected["statis"]
    point, forces = single_point(scene), np.array(expected["forces"])
    observed = Simulation(scene, seed=1, threads=1).observe()
    triclinic = scene.imcon == 3
    assert point.energy["pair"] / unit == pytest.approx(row["engsrp"], rel=PRINTED)
    assert point.energy["charge"] / unit == pytest.approx(row["engcpe"], rel=1e-3 if triclinic else 1e-4)
    assert observed.charge_virial / unit == pytest.approx(row["vircpe"], rel=1e-2 if triclinic else 1e-3)
    assert observed.pressure == pytest.approx(row["press"], rel=1e-2 if triclinic else 1e-3)
    if not triclinic:
        assert largest_error(point.forces, forces) <= 1e-4
        return
    given = scene.electrostatics
    assert given is not None
    between_pairs = real_forces(scene, given.strength, given.alpha, given.cutoff)
    slopes = (point.forces - between_pairs) @ scene.cell.T
    theirs = forces - between_pairs
    for axis in range(3):
        diagonal = float(slopes[:, axis] @ theirs[:, axis]) / float(slopes[:, axis] @ slopes[:, axis])
        assert diagonal == pytest.approx(1.0 / scene.cell[axis, axis], rel=0.2)
        assert largest_error(diagonal * slopes[:, axis], theirs[:, axis]) <= 2e-3


def real_forces(scene: Scene, strength: float, alpha: float, cutoff: float) -> FloatArray:
    """Forces of the pair laws and of erfc(αr)/r within the cutoff, (N, 3), by numpy."""
    positions, charge = scene.beads.positions, scene.beads.charge
    d = positions[:, None] - positions[None, :]
    d -= np.rint(d @ np.linalg.inv(scene.cell)) @ scene.cell
    r = np.linalg.norm(d, axis=2)
    np.fill_diagonal(r, 1e9)  # a bead and itself
    fade = np.vectorize(math.erfc)(alpha * r) + 2.0 * alpha * r * np.exp(-np.square(alpha * r)) / math.sqrt(math.pi)
    factor = np.where(r < cutoff, strength * np.outer(charge, charge) * fade / r**3, 0.0)
    pairs = single_point(replace(scene, electrostatics=None)).forces
    return np.asarray(pairs + (factor[:, :, None] * d).sum(axis=1))


def assert_single_point(scene: Scene, expected: dict[str, Any]) -> None:
    assert scene.field_units is not None
    unit, row = scene.field_units.factor, expected["statis"]
    point = single_point(scene)
    forces = np.array(expected["forces"])
    assert forces.shape == point.forces.shape
    if scene.bonded is not None and any(term.law == "bvs1" for term in scene.bonded.terms):
        forces = forces + 2.0 * turning_forces(scene)
    assert largest_error(point.forces, forces) <= 1e-8
    assert point.energy["pair"] / unit == pytest.approx(row["engsrp"], rel=PRINTED)
    assert point.energy["total"] / unit == pytest.approx(row["engcfg"], rel=PRINTED)
    assert point.energy["charge"] / unit == pytest.approx(row["engcpe"], rel=PRINTED)
    assert point.energy["bond"] / unit == pytest.approx(row["engbnd"], rel=PRINTED)
    assert point.energy["angle"] / unit == pytest.approx(row["engang"], rel=PRINTED)
    assert (point.energy["dihedral"] + point.energy["inversion"]) / unit == pytest.approx(row["engdih"], rel=PRINTED)
    # DL_POLY adds up these four, printed with 7 digits each, and nothing of dihedrals, whose virial is 0.
    virials = [row[name] for name in ("virsrp", "vircpe", "virbnd", "virang")]
    assert sum(virials) == pytest.approx(row["vir"], abs=PRINTED * sum(map(abs, virials)))
    assert point.virial / unit == pytest.approx(row["vir"], abs=PRINTED * sum(map(abs, virials)))
    assert abs(np.linalg.det(scene.cell)) == pytest.approx(row["volume"], rel=PRINTED)
    assert -point.stress.trace() * row["volume"] == pytest.approx(point.virial, rel=PRINTED)
    # The start velocities are drawn, but their temperature is set exactly: the whole row is determined.
    observed = Simulation(scene, seed=1, threads=1).observe()
    assert observed.temperature == pytest.approx(row["temp"], rel=PRINTED)
    assert observed.pair_virial / unit == pytest.approx(row["virsrp"], rel=PRINTED)
    assert observed.charge_virial / unit == pytest.approx(row["vircpe"], rel=PRINTED)
    for kind, name in (("bond", "virbnd"), ("angle", "virang"), ("dihedral", "virtet")):
        printed = pytest.approx(row[name], rel=PRINTED, abs=PRINTED * 1e-3 * abs(row["vir"]))
        assert observed.bonded_virial[kind] / unit == printed
    total_error = PRINTED * (abs(row["engcns"]) + abs(row["engcfg"]))
    assert observed.energy["total"] / unit == pytest.approx(row["engcns"], abs=total_error)
    kinetic = observed.stress_parts["kinetic"].trace() / 3.0
    assert observed.pressure == pytest.approx(row["press"], abs=PRINTED * (abs(row["press"]) + kinetic))


def turning_forces(scene: Scene) -> FloatArray:
    """The part of the angles' forces that changes the angle, (N, 3): DL_POLY's bvs1 has it with the wrong sign.

    Its energy and virial are right. That the sign is all that differs is what the comparison then shows.
    """
    assert scene.bonded is not None
    term = next(term for term in scene.bonded.terms if term.kind == "angle")
    i, j, k = term.beads.T
    arms = [scene.beads.positions[end] - scene.beads.positions[j] for end in (i, k)]
    arms = [arm - np.rint(arm @ np.linalg.inv(scene.cell)) @ scene.cell for arm in arms]
    lengths = [np.linalg.norm(arm, axis=1, keepdims=True) for arm in arms]
    first, second = (arm / length for arm, length in zip(arms, lengths, strict=True))
    cosine = (first * second).sum(axis=1, keepdims=True)
    angle = np.arccos(cosine)
    _, slopes = _core.evaluate_bonded("angle", term.law, list(term.parameters), np.hstack([angle, *lengths]))
    forces = np.zeros_like(scene.beads.positions)
    for end, arm, other, length in ((i, first, second, lengths[0]), (k, second, first, lengths[1])):
        force = slopes[:, :1] * (other - cosine * arm) / (np.sin(angle) * length)
        np.add.at(forces, end, force)
        np.add.at(forces, j, -force)
    return forces


def assert_follows(scene: Scene, expected: dict[str, Any]) -> None:
    """Take the run of CONTROL, comparing the rows of STATIS on the way and the whole state at the end."""
    simulation = Simulation(scene, threads=1)
    components = {"engbnd": "bond", "engang": "angle"}
    assert len(expected["statis"]) == 11
    for row in expected["statis"]:
        simulation.run(row["step"] - simulation.step)
        observed = simulation.observe()
        found = {
            "time": observed.time,
            "engcns": observed.energy["total"],
            "engcfg": observed.energy["potential"],
            "engsrp": observed.energy["pair"],
            "temp": observed.temperature,
            "vir": observed.virial,
            "press": observed.pressure,
        }
        found |= {name: observed.energy[kind] for name, kind in components.items() if name in row}
        assert found == pytest.approx({name: row[name] for name in found}, rel=FOLLOWED, abs=1e-12)
    assert simulation.step == scene.run.steps
    state = simulation.state
    difference = np.linalg.solve(scene.cell.T, (state.positions - np.array(expected["positions"])).T).T
    difference -= np.round(difference)
    assert np.abs(difference @ scene.cell).max() <= 1e-7
    for array, name in ((state.velocities, "velocities"), (state.forces, "forces")):
        assert largest_error(array, np.array(expected[name])) <= 1e-7, name


def largest_error(found: FloatArray, expected: FloatArray) -> float:
    """Largest difference, in units of the largest expected number."""
    return float(np.abs(found - expected).max() / np.abs(expected).max())
