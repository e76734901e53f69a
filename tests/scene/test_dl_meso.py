"""Folders in DL_MESO's dialect as scenes: its rules as settings, starts with and without CONFIG, conversion, runs."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import InputError, SceneError, Simulation, load, single_point
from pydlpoly.cli import main
from pydlpoly.conversion import convert_folder
from pydlpoly.formats.config import write_config
from pydlpoly.formats.control import read_control
from pydlpoly.formats.field import read_field
from pydlpoly.formats.records import BeadTable, Configuration
from pydlpoly.scene.model import Scene

FOLDERS = [*(f"amphiphile-{k}" for k in (1, 2, 3, 4)), "lipid", "mixing", "phase-separation"]
CONTROL = {
    "volume": "64.0",
    "temperature": "1.0",
    "cutoff": "1.0",
    "timestep": "0.01",
    "steps": "20",
    "seed": "7",
    "ensemble": "nvt mdvv",
}
FIELD = """a fluid
SPECIES 2
A 1.0 0.0 60
B 1.0 0.0 40
MOLECULES 1
AB
nummols 20
beads 2
A 0.0 0.0 -0.25
B 0.0 0.0 0.25
bonds 1
harm 1 2 100.0 0.5
finish
INTERACTIONS 3
A A dpd 25.0 1.0 4.5
A B dpd 35.0 1.0 4.5
B B dpd 25.0 1.0 4.5
CLOSE
"""


def folder(path: Path, settings: dict[str, str | None] | None = None, field: str = FIELD) -> Path:
    path.mkdir(parents=True, exist_ok=True)
    merged = {**CONTROL, **(settings or {})}
    lines = [f"{directive} {value}" for directive, value in merged.items() if value is not None]
    (path / "CONTROL").write_text("\n".join(["a fluid", *lines, "finish", ""]))
    (path / "FIELD").write_text(field)
    return path


def notes(scene: Scene, kind: str = "choice") -> list[str]:
    return [note.text for note in scene.notes if note.kind == kind]


def refusal(path: Path) -> str:
    with pytest.raises(SceneError) as caught:
        load(path)
    return str(caught.value).replace(f"{path}/", "")


def numbers(scene: Scene) -> list[tuple[object, ...]]:
    """The pair table without the places that its numbers come from."""
    return [(t.species, t.law, t.parameters, t.cutoff, t.drag, t.drag_cutoff) for t in scene.pairs]


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    def call(*words: object) -> tuple[object, str, str]:
        monkeypatch.setattr(sys, "argv", ["pydlpoly", *(str(word) for word in words)])
        with pytest.raises(SystemExit) as stop:
            main()
        captured = capsys.readouterr()
        return stop.value.code, captured.out, captured.err

    return call


# -- the public inputs ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FOLDERS)
def test_public_inputs_run_as_they_are(shared: Path, name: str) -> None:
    """All seven load without a warning and take steps from overlapping beads; the momentum stays 0."""
    scene = load(shared / "inputs" / "dl_meso" / name)
    assert not notes(scene, "warning")
    assert scene.units.reduced
    simulation = Simulation(scene, seed=1, threads=2)
    simulation.run(20)
    seen = simulation.observe()
    assert np.isfinite(seen.pressure)
    assert 0.5 < seen.temperature < 20.0
    assert np.abs(seen.momentum).max() < 1e-9


@pytest.mark.parametrize("name", FOLDERS)
def test_converted_files_are_the_same_scene(shared: Path, tmp_path: Path, name: str) -> None:
    """The same forces and the same first ten steps, to the bit."""
    source = shared / "inputs" / "dl_meso" / name
    convert_folder(source, tmp_path / "new")
    assert read_control(tmp_path / "new" / "CONTROL").meso is None
    assert read_field(tmp_path / "new" / "FIELD").meso is None
    first, second = load(source), load(tmp_path / "new")
    assert numbers(first) == numbers(second)
    assert (first.dynamics, first.run.steps, first.output) == (second.dynamics, second.run.steps, second.output)
    one, other = single_point(first), single_point(second)
    assert one.energy == other.energy
    assert np.array_equal(one.forces, other.forces)
    runs = [Simulation(scene, seed=3, threads=2) for scene in (first, second)]
    for simulation in runs:
        simulation.run(10)
    assert np.array_equal(runs[0].state.positions, runs[1].state.positions)
    assert np.array_equal(runs[0].state.velocities, runs[1].state.velocities)


def test_a_zero_repulsion_keeps_its_drag(shared: Path) -> None:
    scene = load(shared / "inputs/dl_meso/amphiphile-1")
    term = next(t for t in scene.pairs if {scene.species[k] for k in t.species} == {"A", "S"})
    assert (term.parameters, term.drag, term.noise) == ((0.0, 1.0), 5.625, pytest.approx(np.sqrt(2 * 5.625)))


def test_pairs_of_the_mixture_are_mixed(shared: Path) -> None:
    """a = sqrt(a_i a_j), r_c the mean, drag sqrt(g_i g_j); all drags end at CONTROL's cutoff 1.25."""
    scene = load(shared / "inputs/dl_meso/mixing")
    expected = {"PLE1": 2.0, "PLE2": 1.0, "PLE3": 0.5}
    for term in scene.pairs:
        a, b = (expected[scene.species[k]] for k in term.species)
        assert term.parameters == pytest.approx((np.sqrt(a * b), 1.0))
        assert (term.drag, term.cutoff, term.drag_cutoff) == (pytest.approx(1.0), 1.0, 1.25)
    assert "all drags end at 1.25, wherever the laws end, as in DL_MESO" in notes(scene)
    assert "PLE1-PLE2: law mixed from PLE1-PLE1 and PLE2-PLE2 by lorentz-berthelot" in scene.explain()


# -- rules ------------------------------------------------------------------------------------------------------------


def test_drags_that_end_where_their_laws_do_need_no_setting(tmp_path: Path) -> None:
    scene = load(folder(tmp_path))
    assert {term.drag_cutoff for term in scene.pairs} == {1.0}
    assert not any("drags end" in text for text in notes(scene))


def test_the_cutoff_is_the_range_of_all_drags(tmp_path: Path) -> None:
    field = FIELD.replace("A B dpd 35.0 1.0", "A B dpd 35.0 0.8")
    scene = load(folder(tmp_path, field=field))
    assert [(term.cutoff, term.drag_cutoff) for term in scene.pairs] == [(1.0, 1.0), (0.8, 1.0), (1.0, 1.0)]


def test_without_a_cutoff_it_is_the_longest_range(tmp_path: Path) -> None:
    scene = load(folder(tmp_path, {"cutoff": None}, FIELD.replace("B B dpd 25.0 1.0", "B B dpd 25.0 1.2")))
    assert scene.cutoff == 1.2
    assert {term.drag_cutoff for term in scene.pairs} == {1.2}
    assert "no cutoff is given: 1.2, the longest range in FIELD, as in DL_MESO" in notes(scene)


def test_a_thermostat_cutoff_of_its_own(tmp_path: Path) -> None:
    scene = load(folder(tmp_path, {"cutoff": "1.3", "thermostat cutoff": "0.9"}))
    assert (scene.cutoff, {(term.cutoff, term.drag_cutoff) for term in scene.pairs}) == (1.3, {(1.0, 0.9)})
    convert_folder(tmp_path, tmp_path / "new")
    assert numbers(load(tmp_path / "new")) == numbers(scene)


def test_lennard_jones_ends_at_the_cutoff(tmp_path: Path) -> None:
    field = FIELD.replace("dpd 25.0 1.0 4.5", "lj 0.5 0.4 4.5").replace("dpd 35.0 1.0 4.5", "wca 0.5 0.4 4.5")
    scene = load(folder(tmp_path, {"cutoff": "1.5"}, field))
    assert [(term.law, term.drag, term.drag_cutoff) for term in scene.pairs] == [
        ("lj", 4.5, 1.5),
        ("wca", 4.5, 1.5),
        ("lj", 4.5, 1.5),
    ]
    assert scene.pairs[0].cutoff == 1.5


@pytest.mark.parametrize("order", ["lowe", "stoyanov 0.3"])
def test_rates_do_not_depend_on_masses(tmp_path: Path, order: str) -> None:
    """FIELD's third number is the rate itself; with masses of 1 the engine's default is the same."""
    settings = {"ensemble": f"nvt {order}"}
    assert load(folder(tmp_path, settings)).dynamics.collision_rate == 0.0
    heavy = FIELD.replace("B 1.0", "B 3.0")
    assert load(folder(tmp_path, settings, heavy)).dynamics.collision_rate == 4.5
    uneven = heavy.replace("35.0 1.0 4.5", "35.0 1.0 9.0")
    expected = (
        "CONTROL:8: 'ensemble': {} with masses other than 1 can be modelled only with one rate for all pairs, and "
        "FIELD has several"
    ).format({"lowe": "lowe-andersen"}.get(order, "stoyanov-groot"))
    assert refusal(folder(tmp_path, settings, uneven)) == expected


def test_constant_pressure(tmp_path: Path) -> None:
    scene = load(folder(tmp_path, {"ensemble": "npt mdvv langevin 2.0 0.5", "pressure": "23.7"}))
    barostat = scene.dynamics.barostat
    assert barostat is not None
    assert (barostat.relaxation, barostat.friction, barostat.pressure) == (2.0, 0.5, (23.7, 23.7, 23.7))
    simulation = Simulation(scene, threads=1)
    simulation.run(5)
    assert np.isfinite(simulation.observe().pressure)


def test_scaling_acts_in_the_equilibration_only(tmp_path: Path) -> None:
    scene = load(folder(tmp_path, {"equilibration": "steps 10", "scale": "temperature every 5"}))
    assert (scene.run.equilibration_steps, scene.run.rescale_every) == (10, 5)
    told = "scale temperature acts during the equilibration only, as in DL_MESO; after it the thermostat is left alone"
    assert told in notes(scene)


@pytest.mark.parametrize(
    ("settings", "field", "expected"),
    [
        (
            {},
            FIELD.replace("3\nA A", "2\nA A").replace("A B dpd 35.0 1.0 4.5\n", "").replace("B B dpd", "B B lj"),
            "FIELD: the pair A B is not given, and the laws of its like pairs differ; give it a line",
        ),
        (
            {},
            FIELD.replace("3\nA A", "1\nA A").replace("A B dpd 35.0 1.0 4.5\nB B dpd 25.0 1.0 4.5\n", ""),
            "FIELD: the pair A B is not given and cannot be mixed: there is no interaction B B",
        ),
        (
            {"thermostat cutoff": "0.9"},
            FIELD.replace("3\nA A", "2\nA A").replace("A B dpd 35.0 1.0 4.5\n", ""),
            "CONTROL: drags that end at 0.9 cannot be given to pairs that are mixed; give every pair a line",
        ),
        (
            {"temperature": "2.0"},
            FIELD.replace("INTER", "UNITS kT\nINTER"),
            "FIELD:14: 'units': energies in k_B T can be taken only at temperature 1, not at 2; write them as numbers",
        ),
        (
            {"volume": None, "boundary": "halo 2"},
            FIELD,
            "CONTROL: 'volume': there is no CONFIG, and no volume in a CONTROL of DL_MESO's dialect to place the beads "
            "in",
        ),
    ],
)
def test_refusals(tmp_path: Path, settings: dict[str, str | None], field: str, expected: str) -> None:
    assert refusal(folder(tmp_path, settings, field)) == expected


def test_energies_in_units_of_a_temperature_of_one(tmp_path: Path) -> None:
    thermal = load(folder(tmp_path, field=FIELD.replace("INTER", "UNITS kT\nINTER")))
    assert thermal.pairs[1].parameters == (35.0, 1.0)


def test_a_dl_poly_field_goes_with_a_dl_meso_control(tmp_path: Path) -> None:
    """Single beads can be placed; other units and molecules without places cannot."""
    field = "t\nunits dpd\nmolecules 1\nA\nnummols 50\natoms 1\nA 1.0 0.0\nfinish\nvdw 1\nA A dpd 25.0 1.0 4.5\nclose\n"
    assert load(folder(tmp_path, field=field)).bead_count == 50
    expected = "CONTROL: this CONTROL is in DL_MESO's dialect, whose numbers are reduced, but FIELD has units kj"
    assert refusal(folder(tmp_path, field=field.replace("dpd\nmol", "kJ\nmol"))) == expected
    pair = field.replace("atoms 1\nA 1.0 0.0", "atoms 2\nA 1.0 0.0 2")
    expected = "FIELD:4: there is no CONFIG, and molecule A has no places for its beads in this FIELD"
    assert refusal(folder(tmp_path, field=pair)) == expected


def test_a_control_without_telling_directives_follows_its_field(tmp_path: Path) -> None:
    """DL_POLY's and DL_MESO's files share these directives: FIELD says that the temperature is not in K."""
    folder(tmp_path, {"volume": None, "seed": None})
    cell = np.eye(3) * 4.0
    names = ("A",) * 60 + ("B",) * 40 + ("A", "B") * 20
    places = np.random.default_rng(1).random((140, 3)) * 4.0 - 2.0
    places[101::2] = places[100::2]
    (tmp_path / "CONFIG").write_text(write_config(Configuration(names, places, "t", 1, cell)))
    assert load(tmp_path).dynamics.thermal_energy == pytest.approx(1.0)


def test_a_new_style_control_goes_with_a_dl_meso_field(tmp_path: Path) -> None:
    convert_folder(folder(tmp_path / "meso"), tmp_path / "new")
    shutil.copy(tmp_path / "meso" / "FIELD", tmp_path / "new" / "FIELD")
    scene = load(tmp_path / "new")
    assert np.array_equal(single_point(scene).forces, single_point(load(tmp_path / "meso")).forces)
    (tmp_path / "new" / "CONFIG").unlink()
    with pytest.raises(InputError, match="there is no such file; expected the start configuration"):
        load(tmp_path / "new")


# -- starts -----------------------------------------------------------------------------------------------------------


def test_a_start_without_config(tmp_path: Path) -> None:
    scene = load(folder(tmp_path, {"volume": "8.0 4.0 2.0"}))
    assert scene.imcon == 2
    assert np.array_equal(scene.cell, np.diag([8.0, 4.0, 2.0]))
    assert np.abs(scene.beads.positions / [8.0, 4.0, 2.0]).max() <= 0.5
    bonds = scene.beads.positions[100::2] - scene.beads.positions[101::2]
    bonds -= np.rint(bonds / [8.0, 4.0, 2.0]) * [8.0, 4.0, 2.0]
    assert np.allclose(np.linalg.norm(bonds, axis=1), 0.5)
    told = (
        "no CONFIG: 60 A placed at random, 40 B placed at random, 20 AB turned or mirrored and placed at random, from "
        "seed 7; 2.1875 beads per unit volume"
    )
    assert told in notes(scene)
    assert scene.sources == (str(tmp_path / "CONTROL"), str(tmp_path / "FIELD"))


def test_the_start_follows_the_seed(tmp_path: Path) -> None:
    places = [load(folder(tmp_path, {"seed": seed})).beads.positions for seed in ("7", "7", "8", None, None)]
    assert np.array_equal(places[0], places[1])
    assert not np.array_equal(places[0], places[2])
    assert np.array_equal(places[3], places[4])


def test_no_isomer_turns_only(tmp_path: Path) -> None:
    scene = load(folder(tmp_path, field=FIELD.replace("finish", "no isomer\nfinish")))
    assert any("20 AB turned and placed" in text for text in notes(scene))


def config(path: Path, names: list[str], edges: tuple[float, ...], imcon: int = 1, **more: np.ndarray) -> np.ndarray:
    rng = np.random.default_rng(5)
    places = (rng.random((len(names), 3)) - 0.5) * edges
    places[101::2] = places[100::2] + np.array([0.0, 0.0, 0.5])
    record = Configuration(tuple(names), places, "t", imcon, np.diag(edges), **more)
    (path / "CONFIG").write_text(write_config(record, digits=17))
    return places


NAMES = ["A"] * 60 + ["B"] * 40 + ["A", "B"] * 20


def test_config_takes_the_place_of_the_volume(tmp_path: Path) -> None:
    """DL_MESO writes imcon 1 for every orthorhombic box; its own box counts, and a difference is told."""
    places = config(folder(tmp_path), NAMES, (8.0, 4.0, 4.0))
    scene = load(tmp_path)
    assert scene.imcon == 2
    assert np.array_equal(np.diag(scene.cell), [8.0, 4.0, 4.0])
    assert np.allclose(scene.beads.positions[:100], places[:100])
    assert notes(scene, "warning") == ["CONFIG's box 8 x 4 x 4 is used, not CONTROL's volume"]
    assert "imcon 1 with unequal edges: an orthorhombic box, as in DL_MESO" in notes(scene)


def test_beads_outside_molecules_come_in_any_order(tmp_path: Path) -> None:
    mixed = ["B", "A"] * 40 + ["A"] * 20 + ["A", "B"] * 20
    places = config(folder(tmp_path), mixed, (4.0, 4.0, 4.0))
    scene = load(tmp_path)
    first = np.array([places[k] for k in range(100) if mixed[k] == "A"])
    assert np.allclose(scene.beads.positions[:60], first)
    assert any("the 100 beads outside molecules are numbered anew" in text for text in notes(scene))


def test_beads_of_another_number_are_refused(tmp_path: Path) -> None:
    config(folder(tmp_path), ["A"] * 61 + ["B"] * 39 + ["A", "B"] * 20, (4.0, 4.0, 4.0))
    assert refusal(tmp_path).startswith("CONFIG: 'A': bead 61 is A, but FIELD expects B there")


def test_coordinates_from_the_corner(tmp_path: Path) -> None:
    places = config(folder(tmp_path, {"conf": "origin"}), NAMES, (4.0, 4.0, 4.0))
    moved = load(tmp_path).beads.positions
    assert np.allclose((moved - places + 2.0 + 2.0) % 4.0 - 2.0, 0.0, atol=1e-12)
    assert np.abs(moved).max() <= 2.0


def test_no_config_places_the_beads_although_there_is_one(tmp_path: Path) -> None:
    folder(tmp_path, {"no": "config"})
    expected = load(tmp_path).beads.positions
    config(tmp_path, NAMES, (4.0, 4.0, 4.0))
    assert np.array_equal(load(tmp_path).beads.positions, expected)


def test_velocities_of_config_are_used(tmp_path: Path) -> None:
    velocities = np.random.default_rng(2).normal(size=(140, 3))
    velocities -= velocities.mean(axis=0)
    config(folder(tmp_path), NAMES, (4.0, 4.0, 4.0), velocities=velocities)
    scene = load(tmp_path)
    assert scene.run.start == "noscale"
    assert np.allclose(scene.beads.velocities, velocities, atol=1e-12)


def test_a_box_without_right_angles_is_refused(tmp_path: Path) -> None:
    config(folder(tmp_path), NAMES, (4.0, 4.0, 4.0), imcon=3)
    text = (tmp_path / "CONFIG").read_text().split("\n")
    text[3] = "  1.0  4.0  0.0"
    (tmp_path / "CONFIG").write_text("\n".join(text))
    assert refusal(tmp_path) == "CONFIG: boxes of DL_MESO are orthorhombic, and this cell is not"


# -- the command ------------------------------------------------------------------------------------------------------


def test_run_check_explain_and_resume(command, tmp_path: Path) -> None:
    folder(tmp_path, {"stats": "every 5", "trajectory": "0 10", "print": "every 10", "ndump": "10"})
    code, out, _ = command("check", tmp_path)
    assert (code, out.split("\n")[-2]) == (0, "ok: 140 beads of 2 species, 20 steps of 0.01")
    code, out, _ = command("explain", tmp_path)
    assert (code, "volume 64, 140 beads, 2.1875 beads per unit volume" in out) == (0, True)
    assert command("run", tmp_path, "--quiet", "--threads", 1, "--output", tmp_path / "whole")[0] == 0
    files = {path.name for path in (tmp_path / "whole").iterdir()}
    assert {"OUTPUT", "STATIS", "HISTORY", "REVCON", "REVIVE"} <= files
    part = ["run", tmp_path, "--quiet", "--threads", 1, "--output", tmp_path / "part"]
    assert command(*part, "--steps", 10)[0] == 0
    assert command(*part, "--resume")[0] == 0
    assert (tmp_path / "part" / "REVCON").read_bytes() == (tmp_path / "whole" / "REVCON").read_bytes()


def test_l_scr_writes_the_report_to_the_screen(command, tmp_path: Path) -> None:
    folder(tmp_path, {"l_scr": "", "print": "every 10"})
    code, out, _ = command("run", tmp_path, "--quiet", "--output", tmp_path / "out")
    assert code == 0
    assert "a fluid" in out
    assert not (tmp_path / "out" / "OUTPUT").exists()


def test_convert_command(command, tmp_path: Path) -> None:
    source = folder(tmp_path / "meso")
    assert command("convert", source, "--to", "dl_poly", "-o", tmp_path / "new") == (0, "", "")
    assert "-hrm     1     2 100.0 0.5" in (tmp_path / "new" / "FIELD").read_text()
    assert command("convert", source, "--to", "dl_poly")[0] == 2
    code, _, told = command("convert", source, "--to", "dl_poly", "-o", source)
    assert (code, told.split(": ")[-1]) == (
        1,
        "the files would overwrite those they come from; choose another folder\n",
    )
    code, _, told = command("convert", source / "CONTROL", "--to", "dl_poly", "-o", tmp_path / "new")
    assert (code, told.split(": ")[-1]) == (1, "--to dl_poly takes the folder of a run\n")
    code, _, told = command("convert", source / "CONTROL")
    assert code == 1
    assert "convert its folder --to dl_poly" in told


def test_nfold_repeats_the_cell(tmp_path: Path) -> None:
    once = load(folder(tmp_path / "once", {}, FIELD))
    twice = load(folder(tmp_path / "twice", {"nfold": "2 1 1"}, FIELD))
    assert twice.bead_count == 2 * once.bead_count
    assert twice.cell.diagonal() == pytest.approx(once.cell.diagonal() * (2.0, 1.0, 1.0))


def test_a_table_of_beads_needs_their_order(tmp_path: Path) -> None:
    """BEADS counts the beads as CONFIG does, so it cannot be used where they are numbered anew."""
    mixed = ["B", "A"] * 40 + ["A"] * 20 + ["A", "B"] * 20
    config(folder(tmp_path), mixed, (4.0, 4.0, 4.0))
    table = BeadTable(("temperature",), np.ones((140, 1)))
    with pytest.raises(InputError, match="outside molecules must stand species after species, as in"):
        load(tmp_path, beads=table)
    config(folder(tmp_path), NAMES, (4.0, 4.0, 4.0))
    assert any("BEADS is not used" in text for text in notes(load(tmp_path, beads=table), "ignored"))
