"""Scenes from Atoms and back: round trips, absolute units, and the sentence of every refusal."""

from __future__ import annotations

import re
from pathlib import Path

import ase.io
import numpy as np
import pytest
from ase import Atoms, units
from ase.build import bulk
from ase.constraints import FixAtoms
from ase.geometry import wrap_positions

import pydlpoly
from pydlpoly.ase import ENERGY, VELOCITY, Calculator, atoms_from_state, bead_names, scene_from_atoms
from pydlpoly.errors import InputError, SceneError
from pydlpoly.formats.config_writer import write_config
from pydlpoly.formats.field import parse_field
from pydlpoly.formats.records import Configuration
from pydlpoly.scene.serialise import scene_from_arrays, scene_to_arrays

SOFT = {("A", "A"): ("dpd", 25.0, 3.0), ("A", "B"): ("dpd", 40.0, 3.0), ("B", "B"): ("dpd", 30.0, 2.5)}
NVE = {"ensemble": "nve", "timestep": "1 fs", "temperature": "300 K", "cutoff": "3 ang"}
RESTING = {**NVE, "restart": "noscale", "fixed_com": "off"}
TRICLINIC = np.array([[9.0, 1.0, -0.5], [-2.0, 8.5, 0.7], [1.5, -1.0, 10.0]])
TURNED = TRICLINIC @ np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])

DIMER = """chains
units kJ
molecular types 2
Chain
nummols 2
atoms 2
A 10.0 0.5
B 12.0 -0.5
finish
Solvent
nummols 1
atoms 1
A 10.0 0.0
finish
vdw 1
A A dpd 25.0 3.0
close
"""
SINGLE = """singles
units kJ
molecular types 2
Bees
nummols 2
atoms 1
B 12.0 -0.5
finish
Ays
nummols 2
atoms 1
A 10.0 0.5
finish
vdw 1
A A dpd 25.0 3.0
close
"""


def soft_fluid(cell=(9.0, 9.0, 9.0), pbc=True, beads=60, velocities=True, seed=3):
    random = np.random.default_rng(seed)
    atoms = Atoms(numbers=np.zeros(beads, int), cell=cell, pbc=pbc, masses=np.where(np.arange(beads) % 3, 10.0, 12.0))
    atoms.set_scaled_positions(random.random((beads, 3)))
    atoms.set_array("bead_types", np.where(np.arange(beads) % 3, "A", "B"))
    if velocities:
        atoms.set_velocities(random.normal(size=(beads, 3)) * VELOCITY)
    return atoms


def named(names, **more):
    atoms = Atoms(numbers=np.zeros(len(names), int), positions=np.arange(3.0 * len(names)).reshape(-1, 3), **more)
    atoms.set_array("bead_types", np.array(names))
    return atoms


def soft_scene(atoms, control=NVE):
    return scene_from_atoms(atoms, pairs=SOFT, units="kj", control=control)


# -- Round trips ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("cell", "pbc", "imcon"),
    [
        (np.diag([9.0, 9.0, 9.0]), True, 1),
        (np.diag([9.0, 8.0, 11.0]), True, 2),
        (TRICLINIC, True, 3),
        (TURNED, True, 3),
        (TURNED[[1, 0, 2]], True, 3),  # left-handed
        (np.diag([9.0, -8.0, 11.0]), True, 3),
        (np.diag([9.0, 8.0, 11.0]), False, 0),
        (TURNED, False, 0),
        (np.diag([9.0, 8.0, 40.0]), (True, True, False), 6),
        (np.array([[9.0, 0.0, 0.0], [-3.0, 8.0, 0.0], [0.0, 0.0, 0.0]]), (True, True, False), 6),
    ],
)
def test_atoms_to_scene_to_atoms_is_the_identity(cell, pbc, imcon):
    atoms = soft_fluid(cell, pbc)
    if not cell[2].any():
        atoms.positions[:, 2] = np.linspace(-50.0, 20.0, len(atoms))  # far outside of any box
    scene = soft_scene(atoms, RESTING)
    back = atoms_from_state(scene)
    assert scene.imcon == imcon
    assert np.abs(back.positions - atoms.positions).max() <= 1e-12
    assert np.abs(back.get_velocities() - atoms.get_velocities()).max() <= 1e-14
    assert np.array_equal(back.cell.array, atoms.cell.array)
    assert np.array_equal(back.pbc, atoms.pbc)
    assert np.array_equal(back.arrays["bead_types"], atoms.arrays["bead_types"])
    assert np.array_equal(back.get_masses(), atoms.get_masses())
    assert back.get_chemical_symbols() == ["X"] * len(atoms)
    again = soft_scene(back, RESTING)
    assert np.abs(again.beads.positions - scene.beads.positions).max() <= 1e-12


def test_beads_in_a_scene_lie_around_the_origin_and_come_back_around_the_middle_of_the_cell():
    atoms = soft_fluid(TURNED, velocities=False)
    outside = atoms.copy()
    outside.positions += np.random.default_rng(1).integers(-2, 3, (len(atoms), 3)) @ TURNED
    scene = soft_scene(outside)
    fractions = scene.beads.positions @ np.linalg.inv(TURNED)
    assert fractions.min() < -0.45
    assert fractions.max() > 0.45
    assert np.all((fractions >= -0.5) & (fractions < 0.5))
    back = atoms_from_state(scene).positions
    assert np.abs(back - atoms.positions).max() <= 1e-12
    assert np.abs(back - wrap_positions(outside.positions, TURNED, eps=0.0)).max() <= 1e-12


def test_beads_on_faces_edges_and_corners_of_a_turned_cell_stay_there():
    fractions = np.array([[0, 0, 0], [0, 0.3, 0.4], [0.5, 0.0, 0.0], [0.5, 0.5, 0.5], [0.0, 0.0, 0.7]])
    atoms = named(["A"] * 5, cell=TURNED, pbc=True, masses=[10.0] * 5)
    atoms.set_scaled_positions(fractions)
    back = atoms_from_state(scene_from_atoms(atoms, pairs={("A", "A"): SOFT["A", "A"]}, units="kj", control=NVE))
    assert np.abs(back.positions - atoms.positions).max() <= 1e-12


def test_a_state_of_a_run_comes_back_with_the_order_velocities_and_forces_of_the_structure():
    atoms = soft_fluid()
    scene = soft_scene(atoms, RESTING)
    simulation = pydlpoly.Simulation(scene)
    simulation.run(5)
    state = simulation.state
    back = atoms_from_state(scene, state, forces=True)
    order = scene.source_order
    assert order is not None
    assert np.any(np.diff(order) < 0)
    assert np.array_equal(back.arrays["bead_types"], atoms.arrays["bead_types"])
    moved = back.positions[order] - state.positions
    assert np.abs(moved - 9.0 * np.round(moved / 9.0)).max() < 1e-12
    assert np.allclose(back.get_velocities()[order], state.velocities * VELOCITY, rtol=1e-13)
    assert np.array_equal(back.get_forces()[order], state.forces * ENERGY)
    assert np.all((back.positions >= 0.0) & (back.positions < 9.0))
    kinetic = simulation.energy["kinetic"] * ENERGY
    assert back.get_kinetic_energy() == pytest.approx(kinetic, rel=1e-12)


def test_forces_of_the_start_come_with_the_energy_and_agree_with_the_calculator():
    atoms = soft_fluid()
    start = atoms_from_state(soft_scene(atoms), forces=True)
    atoms.calc = Calculator(soft_scene(atoms))
    assert np.array_equal(start.get_forces(), atoms.get_forces())
    assert start.get_potential_energy() == atoms.get_potential_energy()


def test_the_order_survives_a_checkpoint():
    scene = soft_scene(soft_fluid())
    arrays, data = scene_to_arrays(scene)
    assert np.array_equal(
        atoms_from_state(scene_from_arrays(arrays, data)).positions, atoms_from_state(scene).positions
    )


def test_a_scene_from_files_has_no_cell_vector_where_it_is_not_periodic(tmp_path):
    (tmp_path / "FIELD").write_text(SINGLE)
    (tmp_path / "CONTROL").write_text(
        "title t\nensemble nve\ntimestep 1 fs\ntemperature 0 K\ncutoff 3 ang\ntime_run 0 steps\n"
    )
    config = Configuration(("B", "B", "A", "A"), np.arange(12.0).reshape(4, 3), imcon=6, cell=np.diag([20.0] * 3))
    (tmp_path / "CONFIG").write_text(write_config(config))
    atoms = atoms_from_state(pydlpoly.load(tmp_path))
    assert np.array_equal(atoms.cell.array, np.diag([20.0, 20.0, 0.0]))
    assert np.allclose(atoms.positions, config.positions)
    assert atoms.pbc.tolist() == [True, True, False]
    assert atoms.get_initial_charges().tolist() == [-0.5, -0.5, 0.5, 0.5]
    assert not atoms.has("momenta")


# -- Names, order, masses ---------------------------------------------------------------------------------------------


def test_names_are_taken_from_bead_types_then_names_then_symbols_and_never_read_as_elements():
    odd = ["Ni+", "PLE1", "o1", "Ni+"]
    atoms = Atoms("ArKrArKr", positions=np.arange(12.0).reshape(4, 3), masses=[1.0, 2.0, 3.0, 1.0])
    assert bead_names(atoms).tolist() == ["Ar", "Kr", "Ar", "Kr"]
    atoms.set_array("names", np.array(["a", "b", "a", "b"]))
    assert bead_names(atoms).tolist() == ["a", "b", "a", "b"]
    atoms.set_array("bead_types", np.array(odd, dtype=object))
    pairs = {("Ni+", "PLE1"): ("dpd", 25, 3), ("o1", "o1"): ("lj", 1.0, 2.0)}
    scene = scene_from_atoms(atoms, pairs=pairs, units="kcal", control=NVE)
    assert scene.species == ("Ni+", "PLE1", "o1")
    assert scene.molecule_counts == (2, 1, 1)
    back = atoms_from_state(scene)
    assert back.arrays["bead_types"].tolist() == odd
    assert back.get_masses().tolist() == [1.0, 2.0, 3.0, 1.0]


def test_chemical_symbols_bring_their_masses():
    atoms = bulk("Ar", cubic=True) * 2
    scene = scene_from_atoms(atoms, pairs={("Ar", "Ar"): ("lj", 0.01, 3.4)}, units="ev", control=NVE)
    assert scene.beads.mass[0] == pytest.approx(39.95, abs=0.01)
    assert scene.source_order is None


def test_single_beads_are_sorted_into_the_order_of_field_and_back():
    atoms = named(["A", "B", "A", "B"])
    scene = scene_from_atoms(atoms, field=parse_field(SINGLE), control=NVE)
    assert scene.source_order.tolist() == [1, 3, 0, 2]
    assert np.array_equal(scene.beads.positions, atoms.positions[[1, 3, 0, 2]])
    assert np.array_equal(atoms_from_state(scene).positions, atoms.positions)
    assert atoms_from_state(scene).get_initial_charges().tolist() == [0.5, -0.5, 0.5, -0.5]
    assert scene_from_atoms(named(["B", "B", "A", "A"]), field=parse_field(SINGLE), control=NVE).source_order is None


def test_files_are_read_from_paths(tmp_path):
    (tmp_path / "FIELD").write_text(DIMER)
    (tmp_path / "CONTROL").write_text(
        "title t\nensemble nve\ntimestep 1 fs\ntemperature 0 K\ncutoff 3 ang\ntime_run 7 steps\n"
    )
    atoms = named(["A", "B", "A", "B", "A"])
    scene = scene_from_atoms(atoms, field=str(tmp_path / "FIELD"), control=tmp_path / "CONTROL")
    assert scene.run.steps == 7
    assert scene.beads.molecule.tolist() == [0, 0, 1, 1, 2]
    assert scene.sources == (str(tmp_path / "CONTROL"), str(tmp_path / "FIELD"), "atoms")


# -- Units ------------------------------------------------------------------------------------------------------------


def test_one_dalton_at_one_angstrom_per_picosecond_has_the_kinetic_energy_it_should():
    atoms = named(["A", "A"], masses=[1.0, 1.0])
    atoms.set_velocities([[1.0 / (1000.0 * units.fs), 0.0, 0.0], [0.0, 0.0, 0.0]])
    scene = scene_from_atoms(atoms, pairs={("A", "A"): ("dpd", 1.0, 1.0)}, units="internal", control=RESTING)
    assert np.allclose(scene.beads.velocities, [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], rtol=1e-15)
    back = atoms_from_state(scene)
    assert back.get_kinetic_energy() == pytest.approx(0.5 * 1.0364269e-4, rel=1e-7)
    # 10 J/mol in eV, by ASE's mole and joule; mass unit and mole of CODATA 2014 agree to 1e-8.
    assert pytest.approx(0.01 * units.kJ / units.mol, rel=1e-8) == ENERGY
    assert pydlpoly.Simulation(scene).energy["kinetic"] == pytest.approx(0.5, rel=1e-14)


def test_temperatures_agree():
    scene = soft_scene(soft_fluid(beads=600), RESTING)
    back = atoms_from_state(scene)
    # DL_POLY's k_B is 6e-6 above ASE's; without fixed_com all 3 N momenta count on both sides.
    ratio = units.kB / (0.831451115 * ENERGY)
    assert ratio == pytest.approx(1.0, abs=1e-5)
    assert pydlpoly.Simulation(scene).temperature == pytest.approx(back.get_temperature() * ratio, rel=1e-12)


def test_ases_own_reader_of_revcon_is_wrong_by_known_factors_and_this_module_is_not(tmp_path):
    config = Configuration(
        names=("Ar", "Kr"),
        positions=np.array([[1.0, 2.0, 3.0], [-2.0, 1.0, 0.5]]),
        imcon=1,
        cell=np.eye(3) * 10.0,
        velocities=np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]),
        forces=np.array([[7.0, 8.0, 9.0], [1.0, 2.0, 3.0]]),
    )
    (tmp_path / "REVCON").write_text(write_config(config))
    theirs = ase.io.read(tmp_path / "REVCON", format="dlp4")
    # One Å/ps is 1/(1000 fs) in ASE and one Da Å/ps² is 1.0364269e-4 eV/Å.
    assert np.allclose(config.velocities * VELOCITY / theirs.get_velocities(), 222.718, rtol=1e-5)
    assert np.allclose(config.forces * ENERGY / theirs.get_forces(), 51.4221, rtol=1e-5)
    field = SINGLE.replace("Bees\nnummols 2\natoms 1\nB 12.0", "Bees\nnummols 1\natoms 1\nAr 39.95").replace(
        "Ays\nnummols 2\natoms 1\nA 10.0", "Ays\nnummols 1\natoms 1\nKr 83.8"
    )
    control = "title t\nensemble nve\ntimestep 1 fs\ntemperature 9 K\ncutoff 3 ang\ntime_run 0 steps\n"
    (tmp_path / "FIELD").write_text(field.replace("A A dpd", "Ar Kr dpd"))
    (tmp_path / "CONTROL").write_text(control + "restart noscale\nfixed_com off\n")
    ours = atoms_from_state(pydlpoly.load(tmp_path, config="REVCON"))
    assert np.allclose(ours.get_velocities() * 1000.0 * units.fs, config.velocities, rtol=1e-12)


def test_dpd_water_made_from_atoms_runs_at_its_temperature():
    random = np.random.default_rng(2)
    atoms = Atoms("X648", positions=6.0 * random.random((648, 3)), cell=[6.0] * 3, pbc=True)
    atoms.set_array("bead_types", np.array(["W"] * 648))
    control = {
        **{"ensemble": "nvt", "ensemble_method": "dpd", "ensemble_dpd_order": "mdvv", "cutoff": "1 dpd_l"},
        **{"temperature": "1 dpd_temp", "timestep": "0.02 dpd_t", "random_seed": [1, 2, 3], "title": "water"},
    }
    scene = scene_from_atoms(atoms, pairs={("W", "W"): ("dpd", 25.0, 1.0, 4.5)}, units="dpd", control=control)
    assert scene.title == "water"
    simulation = pydlpoly.Simulation(scene, threads=1)
    simulation.run(200)
    temperatures = []
    for _ in range(60):
        simulation.run(10)
        temperatures.append(simulation.temperature)
    assert np.mean(temperatures) == pytest.approx(1.0, abs=0.03)
    # ρ = 3, a = 25: Groot and Warren's equation of state gives ρ + 0.101 a ρ² = 25.7, measured 23.7 at this density.
    assert simulation.pressure == pytest.approx(23.7, abs=2.5)


def refused(expected, kind, act):
    with pytest.raises(kind) as caught:
        act()
    assert str(caught.value) == expected


# -- Refusals and notes -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("cell", "pbc", "message"),
    [
        (
            [9, 9, 9],
            (True, False, True),
            "atoms: 'pbc T F T': periodicity along a and c alone is not modelled; only none, all three, or a and b "
            "(a slab)",
        ),
        (
            [9, 9, 9],
            (False, False, True),
            "atoms: 'pbc F F T': periodicity along c alone is not modelled; only none, all three, or a and b (a slab)",
        ),
        (
            [[9, 0, 1], [0, 9, 0], [0, 0, 9]],
            (True, True, False),
            "atoms: a slab needs its first two cell vectors in the xy plane and the third along z, not "
            "9 0 1; 0 9 0; 0 0 9",
        ),
        (
            [[9, 0, 0], [0, 9, 0], [2, 0, 9]],
            (True, True, False),
            "atoms: a slab needs its first two cell vectors in the xy plane and the third along z, not "
            "9 0 0; 0 9 0; 2 0 9",
        ),
        ([9, 9, 0], True, "atoms: the cell vectors (9 0 0; 0 9 0; 0 0 0) span no volume (imcon 3)"),
    ],
)
def test_cells_that_are_refused(cell, pbc, message):
    atoms = named(["A", "B"], cell=cell, pbc=pbc)
    refused(message, SceneError, lambda: soft_scene(atoms))


def test_orders_that_are_refused():
    dimers, singles = parse_field(DIMER), parse_field(SINGLE)

    def act(names, field):
        return lambda: scene_from_atoms(named(names), field=field, control=NVE)

    expected = "atoms: 'A': bead 2 is A, but FIELD expects B there (bead 2 of copy 1 of molecule Chain, FIELD:4)"
    refused(expected, SceneError, act(["A", "A", "A", "B", "B"], dimers))
    expected = "atoms: the beads are not those of FIELD: 1 A instead of 2, 1 C instead of 0"
    refused(expected, SceneError, act(["A", "B", "C", "B"], singles))
    refused("atoms: 3 beads, but the molecules of FIELD add up to 4", SceneError, act(["B", "B", "A"], singles))


def test_masses_and_charges_that_contradict_field_are_refused():
    field = parse_field(SINGLE)
    atoms = named(["A", "B", "A", "B"], masses=[10.0, 12.0, 10.5, 12.0])
    message = "atoms: 'A': the mass of bead 3 is 10.5 Da, but FIELD gives 10 Da; correct one of them, or delete "
    act = lambda: scene_from_atoms(atoms, field=field, control=NVE)  # noqa: E731
    refused(message + "atoms.arrays['masses']", SceneError, act)
    del atoms.arrays["masses"]
    atoms.set_initial_charges([0.5, 0.0, 0.5, -0.5])
    message = "atoms: 'B': the charge of bead 2 is 0 e, but FIELD gives -0.5 e; correct one of them, or delete "
    refused(message + "atoms.arrays['initial_charges']", SceneError, act)
    atoms.set_initial_charges([0.5, -0.5, 0.5, -0.5])
    assert act().beads.mass.tolist() == [12.0, 12.0, 10.0, 10.0]


def test_arguments_that_are_refused():
    atoms, field = named(["A", "B", "A", "B"]), parse_field(SINGLE)
    for more, message in (
        ({}, "a force field is needed: the argument field, or pairs with units"),
        (
            {"field": field, "units": "kj"},
            "'kj': the argument units belongs to pairs; a FIELD has units of its own",
        ),
        (
            {"field": field, "pairs": SOFT, "units": "kj"},
            "the arguments field and pairs exclude each other: pair laws belong to FIELD's vdw block",
        ),
        ({"pairs": SOFT}, "pairs need the argument units: ev, kcal, kj, k, internal or dpd"),
    ):
        refused(message, SceneError, lambda more=more: scene_from_atoms(atoms, control=NVE, **more))
    unknown = {("A", "D"): ("dpd", 25.0, 3.0)}
    with pytest.raises(SceneError, match=r"^pairs: 'D': no molecule has a bead of this name"):
        scene_from_atoms(atoms, pairs=unknown, units="kj", control=NVE)
    with pytest.raises(InputError, match=r"^control: 'timestpe': is no keyword of CONTROL.*timestep"):
        soft_scene(atoms, {**NVE, "timestpe": "1 fs"})
    atoms.arrays["bead_types"] = np.array([1, 2, 1, 2])
    refused(
        "atoms: 'bead_types': must hold the species names as strings, not int64", SceneError, lambda: soft_scene(atoms)
    )
    nowhere = named(["A", "B"])
    nowhere.positions[1, 2] = np.nan
    refused("atoms: the position of bead 2 (B) is not finite", SceneError, lambda: soft_scene(nowhere))


def test_what_is_not_taken_is_said():
    def notes(scene):
        return {(note.kind, note.text) for note in scene.notes if note.where == "atoms"}

    atoms = soft_fluid(velocities=False)
    assert notes(soft_scene(atoms)) == set()
    atoms.set_constraint(FixAtoms([0]))
    text = "the constraints of atoms have no effect on the scene; beads that never move are those frozen in FIELD"
    assert ("ignored", text) in notes(soft_scene(atoms))
    moving = soft_fluid()
    text = "no restart is given: the velocities of atoms are taken (noscale)"
    scene = soft_scene(moving)
    assert ("choice", text) in notes(scene)
    assert scene.run.start == "noscale"
    scene = soft_scene(moving, {**NVE, "restart": "clean"})
    assert ("ignored", "restart clean: the velocities of atoms are replaced by drawn ones") in notes(scene)
    assert scene.beads.velocities is None
    resting = soft_fluid(velocities=False)
    resting.set_velocities(np.zeros((60, 3)))
    assert soft_scene(resting).run.start == "clean"
    scene = soft_scene(resting, RESTING)
    assert scene.run.start == "noscale"
    assert not scene.beads.velocities.any()
    light = named(["B", "B", "A", "A"])
    light.set_velocities(np.ones((4, 3)))
    text = "ASE's masses of the elements are not those of FIELD: velocities, not momenta, are taken"
    assert ("warning", text) in notes(scene_from_atoms(light, field=parse_field(SINGLE), control=RESTING))


def test_the_example_of_the_documentation_runs(capsys):
    page = Path(__file__).resolve().parents[1] / "docs" / "ase.md"
    example = re.search(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    assert example is not None
    exec(compile(example.group(1), str(page), "exec"), {})
    temperature, energy, unit = capsys.readouterr().out.split()
    assert unit == "eV"
    assert float(temperature) == pytest.approx(1.0, abs=0.3)
    # (3 N - 3)/2 k_B T with N = 375, in Da Å²/ps².
    assert float(energy) == pytest.approx(561.0 * float(temperature) * 1.0364269e-4, rel=1e-6)
