"""Every golden case of a real DL_POLY: forces, energies, virials, pressures and short runs, or a refusal by name.

DL_POLY printed forces with 10 digits and the rows of STATIS with 7; the tolerances are those digits.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pydlpoly import Scene, SceneError, Simulation, load, single_point
from pydlpoly.formats.records import FloatArray

GOLDEN = Path(__file__).resolve().parents[2] / "shared" / "golden"
CASES = sorted(folder.name for folder in GOLDEN.iterdir() if folder.is_dir()) if GOLDEN.is_dir() else []
NUMBER_OF_CASES = 68

# Cases with terms that are not modelled: a refusal names the first of these words in this file.
REFUSED = {"coul-": ("CONTROL", ("coul_method",))}

PRINTED = 1e-6  # 7 significant digits
FOLLOWED = 2e-6  # 7 digits of a row, and the drift of a trajectory that starts from 12 decimals


def test_all_cases_are_there(shared: Path) -> None:
    assert (shared / "golden").resolve() == GOLDEN.resolve()
    assert len(CASES) == NUMBER_OF_CASES


@pytest.mark.parametrize("case", CASES)
def test_golden_case(case: str) -> None:
    folder = GOLDEN / case
    for start, (file, words) in REFUSED.items():
        if case.startswith(start):
            assert_refused(folder / file, words)
            return
    expected = json.loads((folder / "expected.json").read_text())
    scene = load(folder)
    if case.startswith("run-"):
        assert_follows(scene, expected)
    elif case.startswith(("pair-", "units-", "bond-", "angle-", "dihedral-")):
        assert_single_point(scene, expected)
    else:
        pytest.fail(f"{case} belongs to no known kind of case")


def assert_refused(file: Path, words: tuple[str, ...]) -> None:
    """The refusal names the file, the word that first asks for what is not modelled, and its line."""
    lines = [line.split() for line in file.read_text().splitlines()]
    number, word = next((k, line[0]) for k, line in enumerate(lines, 1) if line and line[0] in words)
    with pytest.raises(SceneError) as caught:
        load(file.parent)
    assert (caught.value.word, caught.value.line) == (word, number)
    assert Path(caught.value.path) == file
    assert "not modelled" in caught.value.message


def assert_single_point(scene: Scene, expected: dict[str, Any]) -> None:
    assert scene.field_units is not None
    unit, row = scene.field_units.factor, expected["statis"]
    point = single_point(scene)
    forces = np.array(expected["forces"])
    assert forces.shape == point.forces.shape
    assert largest_error(point.forces, forces) <= 1e-8
    assert point.energy["pair"] / unit == pytest.approx(row["engsrp"], rel=PRINTED)
    assert point.energy["total"] / unit == pytest.approx(row["engcfg"], rel=PRINTED)
    assert point.energy["bond"] / unit == pytest.approx(row["engbnd"], rel=PRINTED)
    assert point.energy["angle"] / unit == pytest.approx(row["engang"], rel=PRINTED)
    assert (point.energy["dihedral"] + point.energy["inversion"]) / unit == pytest.approx(row["engdih"], rel=PRINTED)
    # DL_POLY adds up these three, printed with 7 digits each, and nothing of dihedrals, whose virial is 0.
    virials = [row[name] for name in ("virsrp", "virbnd", "virang")]
    assert sum(virials) == pytest.approx(row["vir"], abs=PRINTED * sum(map(abs, virials)))
    assert point.virial / unit == pytest.approx(row["vir"], abs=PRINTED * sum(map(abs, virials)))
    assert abs(np.linalg.det(scene.cell)) == pytest.approx(row["volume"], rel=PRINTED)
    assert -point.stress.trace() * row["volume"] == pytest.approx(point.virial, rel=PRINTED)
    # The start velocities are drawn, but their temperature is set exactly: the whole row is determined.
    observed = Simulation(scene, seed=1, threads=1).observe()
    assert observed.temperature == pytest.approx(row["temp"], rel=PRINTED)
    assert observed.pair_virial / unit == pytest.approx(row["virsrp"], rel=PRINTED)
    for kind, name in (("bond", "virbnd"), ("angle", "virang"), ("dihedral", "virtet")):
        printed = pytest.approx(row[name], rel=PRINTED, abs=PRINTED * 1e-3 * abs(row["vir"]))
        assert observed.bonded_virial[kind] / unit == printed
    total_error = PRINTED * (abs(row["engcns"]) + abs(row["engcfg"]))
    assert observed.energy["total"] / unit == pytest.approx(row["engcns"], abs=total_error)
    kinetic = observed.stress_parts["kinetic"].trace() / 3.0
    assert observed.pressure == pytest.approx(row["press"], abs=PRINTED * (abs(row["press"]) + kinetic))


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
