"""Tabulated bonded laws: against the laws they are made from, forces against energies, ends, files, checkpoints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import RunError, Scene, Simulation, _core, single_point
from pydlpoly.formats.bonded_table import TABLE_KINDS, write_bonded_tables
from pydlpoly.formats.records import BondedTable, FloatArray

from .molecule_builder import molecule_scene

DIRECTIVES = {"bond": "bonds", "angle": "angles", "dihedral": "dihedrals", "inversion": "inversions"}
BEADS = {"bond": 2, "angle": 3, "dihedral": 4, "inversion": 4}
NUMBERS = {  # of FIELD: key, numbers, and a bound of |d⁴U/dx⁴|, per degree⁴ for angles
    ("bond", "harm"): ((12.0, 0.9), 0.0),
    ("bond", "mors"): ((5.0, 0.9, 1.7), 2400.0),
    ("angle", "harm"): ((5.0, 110.0), 0.0),
    ("angle", "cos"): ((5.0, 40.0, 3.0), 5.0 * 81.0 * np.radians(1.0) ** 4),
    ("dihedral", "cos"): ((3.0, 40.0, 2.0), 3.0 * 16.0 * np.radians(1.0) ** 4),
    ("inversion", "harm"): ((3.0, 20.0), 0.0),
    ("inversion", "hcos"): ((3.0, 20.0), 3.0 * 9.0 * np.radians(1.0) ** 4),
}
POINTS = {"bond": 400, "angle": 360, "dihedral": 360, "inversion": 360}
LAWS = pytest.mark.parametrize(("kind", "key"), list(NUMBERS), ids=[f"{kind}-{key}" for kind, key in NUMBERS])
PLACES = np.array([[0.1, 0.2, -0.1], [1.0, 0.5, 0.3], [1.3, 1.4, -0.2], [2.2, 1.3, 0.6]])


def analytic(kind: str, key: str) -> Callable[[FloatArray], tuple[FloatArray, FloatArray]]:
    """U and dU/dx of a law at Å or degrees, slopes per Å or degree, in FIELD's units."""
    row = next(law for law in _core.bonded_laws() if (law["kind"], law["key"]) == (kind, key))
    mask = row["degree_mask"]
    numbers = [np.radians(x) if mask >> k & 1 else x for k, x in enumerate(NUMBERS[kind, key][0])]
    unit = 1.0 if kind == "bond" else np.radians(1.0)

    def law(at: FloatArray) -> tuple[FloatArray, FloatArray]:
        columns = [unit * at] if kind != "angle" else [unit * at, np.ones_like(at), np.ones_like(at)]
        energy, slope = _core.evaluate_bonded(kind, key, numbers, np.column_stack(columns))
        return energy, slope[:, 0] * unit

    return law


def table_of(kind: str, key: str, points: int, cutoff: float = 2.0) -> BondedTable:
    spec = TABLE_KINDS[kind]
    spacing = ((cutoff if spec.end is None else spec.end) - spec.start) / points
    energy, slope = analytic(kind, key)(spec.start + spacing * np.arange(points + 1))
    return BondedTable(kind, tuple("ABCD"[: BEADS[kind]]), spec.start, spacing, energy, slope)


def line_of(kind: str, key: str, numbers: tuple[float, ...] = ()) -> str:
    written = [repr(x) for x in numbers]
    if kind == "dihedral" and written:
        written = [*written[:3], *["0"] * (3 - len(written))]
    return " ".join([key, *(str(k + 1) for k in range(BEADS[kind])), *written])


def scene_with(kind: str, line: str, files: dict[str, str] | None = None, **changes: object) -> Scene:
    return molecule_scene(
        "ABCD",
        {DIRECTIVES[kind]: [line]},
        PLACES,
        cell=[8.0, 7.0, 9.0],
        files=files,
        **changes,  # type: ignore[arg-type]
    )


def tabulated(kind: str, key: str, word: str = "tab", points: int | None = None, **changes: object) -> Scene:
    text = write_bonded_tables([table_of(kind, key, points or POINTS[kind])], "made from a formula")
    return scene_with(kind, line_of(kind, word), {TABLE_KINDS[kind].name: text}, **changes)


def moved(scene: Scene, positions: FloatArray) -> Scene:
    return replace(scene, beads=replace(scene.beads, positions=positions))


@LAWS
def test_a_table_is_the_law_it_is_made_from(kind: str, key: str) -> None:
    """Cubic Hermite curves: U is off by at most h⁴/384 max|U''''|, the slope by h³ √3/216 max|U''''|."""
    table = table_of(kind, key, POINTS[kind])
    low, high = {"bond": (0.6, 2.0), "angle": (1.0, 180.0), "dihedral": (-180.0, 180.0), "inversion": (1.0, 90.0)}[kind]
    at = np.random.default_rng(5).uniform(low, high, 2000)
    numbers = [table.start, table.spacing, *table.energy, *table.slope]
    coordinates = np.column_stack([at] if kind != "angle" else [at, np.ones_like(at), np.ones_like(at)])
    energy, slope = _core.evaluate_bonded(kind, "tab", numbers, coordinates)
    wanted, wanted_slope = analytic(kind, key)(at)
    bound, h = NUMBERS[kind, key][1], table.spacing
    assert np.abs(energy - wanted).max() <= bound * h**4 / 384.0 + 1e-12
    assert np.abs(slope[:, 0] - wanted_slope).max() <= bound * h**3 * np.sqrt(3.0) / 216.0 + 1e-11
    if bound:  # the bounds are no more than a few times the errors
        assert np.abs(energy - wanted).max() >= 0.2 * bound * h**4 / 384.0


@LAWS
@pytest.mark.parametrize("units", ["dpd", "kj"])
def test_scenes_with_a_table(kind: str, key: str, units: str) -> None:
    numbers, bound = NUMBERS[kind, key]
    point = single_point(tabulated(kind, key, units=units))
    wanted = single_point(scene_with(kind, line_of(kind, key, numbers), units=units))
    h = table_of(kind, key, POINTS[kind]).spacing
    factor = 100.0 if units == "kj" else 1.0
    assert point.energy[kind] == pytest.approx(wanted.energy[kind], abs=factor * (bound * h**4 / 384.0 + 1e-11))
    per_radian = 1.0 if kind == "bond" else np.degrees(1.0)
    # Beads are half a length or farther from each other, so that angles turn by at most 2 for each length.
    largest = factor * (4.0 * per_radian * bound * h**3 * np.sqrt(3.0) / 216.0 + 1e-10)
    assert np.abs(point.forces - wanted.forces).max() <= largest
    assert np.abs(wanted.forces).max() > 1e-3 * factor


@LAWS
def test_force_is_the_slope_of_the_energy_of_a_coarse_table(kind: str, key: str) -> None:
    scene = tabulated(kind, key, points=20)
    point, h = single_point(scene), 1e-4
    start = scene.beads.positions
    for bead in range(BEADS[kind]):
        for axis in range(3):
            energy = []
            for n in (-1, 1):
                places = start.copy()
                places[bead, axis] += n * h
                energy.append(single_point(moved(scene, places)).energy[kind])
            slope = (energy[1] - energy[0]) / (2.0 * h)
            assert point.forces[bead, axis] == pytest.approx(-slope, abs=1e-6 * max(1.0, np.abs(point.forces).max()))


@LAWS
def test_restraint_form(kind: str, key: str) -> None:
    plain, restraint = tabulated(kind, key), tabulated(kind, key, "-tab")
    assert plain.bonded is not None
    assert restraint.bonded is not None
    assert len(plain.bonded.excluded) == BEADS[kind] * (BEADS[kind] - 1) // 2
    assert len(restraint.bonded.excluded) == 0
    assert single_point(plain).energy == single_point(restraint).energy


def test_either_end_of_a_molecule_may_come_first() -> None:
    table = replace(table_of("angle", "cos", 60), species=("C", "B", "A"))
    scene = scene_with("angle", "tab 1 2 3", {"TABANG": write_bonded_tables([table])})
    assert single_point(scene).energy["angle"] == single_point(tabulated("angle", "cos", points=60)).energy["angle"]


def test_each_species_has_its_table() -> None:
    one = table_of("bond", "harm", 40)
    tables = [one, replace(one, species=("B", "C"), energy=2.0 * one.energy, slope=2.0 * one.slope)]
    scene = molecule_scene(
        "ABCD", {"bonds": ["tab 1 2", "-tab 3 2"]}, PLACES, files={"TABBND": write_bonded_tables(tables)}
    )
    assert scene.bonded is not None
    assert [term.explanation for term in scene.bonded.terms] == ["FIELD:12, TABBND:4", "FIELD:13, TABBND:46"]
    r = np.linalg.norm(np.diff(PLACES, axis=0), axis=1)
    assert single_point(scene).energy["bond"] == pytest.approx(6.0 * (r[0] - 0.9) ** 2 + 12.0 * (r[1] - 0.9) ** 2)
    assert "table of 41 points" in scene.explain()


def test_beyond_the_end_of_a_table_the_run_stops() -> None:
    """DL_POLY's error 660."""
    table = write_bonded_tables([replace(table_of("bond", "harm", 40, cutoff=1.2), species=("A", "A"))])
    positions, velocities = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]]
    scene = molecule_scene("AA", {"bonds": ["tab 1 2"]}, positions, velocities=velocities, files={"TABBND": table})
    with pytest.raises(RunError) as caught:
        Simulation(scene, seed=1, threads=1).run(50)
    assert str(caught.value) == (
        "step 6: the bond tab of beads 1 and 2 is not finite at a length of 1.23236: it lies outside its table"
    )


def test_energy_is_conserved_and_bits_are_kept(tmp_path: Path) -> None:
    scene = tabulated("bond", "mors", points=100, velocities=np.zeros((4, 3)), control={"timestep": "0.001 internal_t"})
    simulation = Simulation(scene, seed=1, threads=1)
    before = simulation.observe().energy["total"]
    simulation.run(500)
    simulation.save(tmp_path / "REVIVE")
    again = Simulation.resume(tmp_path / "REVIVE", threads=2)
    for one in (simulation, again):
        one.run(500)
        assert one.observe().energy["total"] == pytest.approx(before, abs=1e-5)
    assert np.array_equal(again.state.positions, simulation.state.positions)


def test_files_by_other_names_and_their_absence() -> None:
    text = write_bonded_tables([table_of("bond", "harm", 40)])
    scene = scene_with("bond", "tab 1 2", {"springs.dat": text}, control={"io_file_tabbnd": "springs.dat"})
    assert [Path(source).name for source in scene.sources[3:]] == ["springs.dat"]
    with pytest.raises(
        Exception,
        match=r"TABBND: there is no such file; expected the tables of the tab bonds here \(io_file_tabbnd can",
    ):
        scene_with("bond", "tab 1 2")


def test_a_column_that_is_no_slope_is_noticed() -> None:
    table = table_of("bond", "harm", 40)
    good = scene_with("bond", "tab 1 2", {"TABBND": write_bonded_tables([table])})
    assert not any("is not the slope" in note.text for note in good.notes)
    # The force in place of -r dU/dr.
    r = np.maximum(np.arange(41) * table.spacing, 1e-3)
    bad = scene_with("bond", "tab 1 2", {"TABBND": write_bonded_tables([replace(table, slope=table.slope / r)])})
    assert [note.kind for note in bad.notes if "is not the slope" in note.text] == ["warning"]


def test_numbers_that_make_no_table() -> None:
    for numbers, message in (
        ([0.0, 1.0, 1.0, 1.0], "bond law tab: a table has a start, a spacing and at least two nodes with U and slope"),
        (
            [0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
            "bond law tab: the numbers of a table must be finite and its spacing positive",
        ),
        (
            [0.0, 1.0, np.nan, 1.0, 1.0, 1.0],
            "bond law tab: the numbers of a table must be finite and its spacing positive",
        ),
    ):
        with pytest.raises(ValueError, match=message):
            _core.evaluate_bonded("bond", "tab", numbers, np.ones((1, 1)))
