"""Units, beads and cell: what FIELD and CONFIG become."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly.formats.records import AtomLine, Field, Molecule
from pydlpoly.scene import Note
from pydlpoly.scene.beads import lay_out
from pydlpoly.scene.settings import Notes
from pydlpoly.units import BOLTZMANN

NVE = {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None}
LJ = ("A A lj 1.0 0.5", "A B lj 2.0 0.5", "B B lj 3.0 0.5")


def texts(scene, kind):
    return [note.text for note in scene.notes if note.kind == kind]


@pytest.mark.parametrize(
    ("word", "factor"),
    [("eV", 9648.530821), ("kcal", 418.4), ("kJ", 100.0), ("K", BOLTZMANN), ("internal", 1.0), ("dpd", 1.0)],
)
def test_energies_are_scaled_to_internal_units(make, word, factor):
    scene = make(units=word, vdw=LJ, control=NVE).scene()
    assert [term.parameters for term in scene.pairs] == [(factor * n, 0.5) for n in (1.0, 2.0, 3.0)]
    assert scene.units.reduced == (word == "dpd")


@pytest.mark.parametrize(
    ("temperature", "thermal_energy", "noted"),
    [("1.0 dpd_temp", 1.0, False), ("298.15 K", 298.15 * BOLTZMANN, True), ("1.0 K", BOLTZMANN, True)],
)
def test_thermal_energy_under_units_dpd(make, temperature, thermal_energy, noted):
    scene = make(control={"temperature": temperature}).scene()
    assert scene.dynamics.thermal_energy == pytest.approx(thermal_energy, rel=1e-15)
    assert any("but the temperature is in K" in text for text in texts(scene, "warning")) == noted


def test_note_on_a_temperature_in_kelvin_says_what_it_is(make):
    scene = make(control={"temperature": "1.0 K"}).scene()
    note = (
        "units dpd, but the temperature is in K: 1 K is k_B T = 0.831451; for k_B T = 1 write it as 1 dpd_temp, or as "
    )
    assert f"{note}1.2027165 K" in texts(scene, "warning")


def test_no_such_note_for_other_units(make):
    scene = make(units="kJ", control={"temperature": "300.0 K"}).scene()
    assert not [text for text in texts(scene, "warning") if "temperature" in text]


def test_reduced_reports_for_fields_in_other_units(make):
    scene = make(units="kJ", vdw=LJ, control={**NVE, "io_units_scheme": "dpd"}).scene()
    assert (scene.units.name, scene.units.reduced, scene.field_units.name) == ("dpd", True, "kj")
    assert scene.pairs[0].parameters == (100.0, 0.5)
    assert any(text.startswith("io_units_scheme dpd: FIELD's numbers are in kJ/mol") for text in texts(scene, "choice"))


def test_reduced_reports_alone_do_not_make_kelvin_odd(make):
    control = {"io_units_scheme": "dpd", "temperature": "300.0 K"}
    assert not [n for n in texts(make(units="kJ", control=control).scene(), "warning") if "temperature" in n]


def test_species_are_numbered_by_first_appearance_even_without_beads(make):
    vdw = ("A A dpd 25.0 1.0 4.5",)
    scene = make(atoms=("C 1.0", "A 1.0", "B 1.0"), counts=(0, 5, 0), vdw=vdw).scene()
    assert scene.species == ("C", "A", "B")
    assert scene.beads.species.tolist() == [1] * 5
    assert (scene.molecule_names, scene.molecule_counts) == (("mol1", "mol2", "mol3"), (0, 5, 0))


def test_molecules_are_laid_out_copy_by_copy(make):
    scene = make(atoms=("A 1.0 0.0 2", "B 3.0 0.0 1 1"), counts=(2, 3)).scene()
    beads = scene.beads
    assert beads.species.tolist() == [0, 0, 0, 0, 1, 1, 1]
    assert beads.molecule.tolist() == [0, 0, 1, 1, 2, 3, 4]
    assert beads.mass.tolist() == [1.0] * 4 + [3.0] * 3
    assert beads.frozen.tolist() == [False] * 4 + [True] * 3
    assert len(beads) == scene.bead_count == 7


def test_negative_mass_and_massless_frozen_beads(make):
    scene = make(atoms=("A -1.5 0.0", "B 0.0 0.0 1 1")).scene()
    assert scene.beads.mass.tolist() == [1.5] * 4 + [0.0] * 2
    note = "the negative mass -1.5 is taken without its sign, as DL_POLY does"
    assert Note("warning", note, "FIELD:7") in scene.notes


def test_negative_mass_in_a_record_made_by_a_program():
    notes = Notes()
    molecule = Molecule("m", 2, (AtomLine("A", -1.5, line=3),))
    assert lay_out(Field(molecules=(molecule,)), notes).mass.tolist() == [1.5, 1.5]
    text = "negative mass -1.5 of A: its absolute value is taken, as in DL_POLY"
    assert notes.all() == (Note("warning", text, "FIELD:3"),)


def test_charges_without_electrostatics_are_noted(make):
    scene = make(atoms=("A 1.0 0.5", "B 2.0 -1.0")).scene()
    assert scene.beads.charge.tolist() == [0.5] * 4 + [-1.0] * 2
    assert "the charges of A, B are ignored because coul_method is off" in texts(scene, "warning")


def test_electrostatics_without_charges_is_noted(make):
    scene = make(atoms=("A 1.0 9e-6", "B 2.0 0.0"), control={"coul_method": "spme"}).scene()
    assert "coul_method spme has no effect: no bead is charged" in texts(scene, "ignored")


@pytest.mark.parametrize(("imcon", "periodic"), [(0, "nnn"), (1, "yyy"), (2, "yyy"), (3, "yyy"), (6, "yyn")])
def test_positions_are_wrapped_along_periodic_axes_only(make, imcon, periodic):
    places = [(2.0, 2.0, 2.0), (-2.0, -2.0, -2.0), (9.5, -6.5, 30.5), (1.9, 0.3, -1.1), (0, 0, 0), (2.1, 2.1, 2.1)]
    scene = make(imcon=imcon, positions=places).scene()
    assert scene.periodic == tuple(letter == "y" for letter in periodic)
    wrapped = np.array([(-2, -2, -2), (-2, -2, -2), (1.5, 1.5, -1.5), (1.9, 0.3, -1.1), (0, 0, 0), (-1.9, -1.9, -1.9)])
    expected = np.where(scene.periodic, wrapped, np.array(places))
    np.testing.assert_allclose(scene.beads.positions, expected, atol=1e-12)


def test_beads_inside_keep_their_coordinates_to_the_last_bit(make):
    places = np.random.default_rng(5).uniform(-1.9, 1.9, (6, 3))
    cell = ((4.1, 0, 0), (1.3, 4.3, 0), (-0.7, 0.9, 4.7))
    scene = make(imcon=3, cell=cell, positions=places).scene()
    fractional = places @ np.linalg.inv(np.array(cell))
    inside = np.all((fractional >= -0.5) & (fractional < 0.5), axis=1)
    assert inside.any()
    assert np.array_equal(scene.beads.positions[inside], places[inside])
    wrapped = scene.beads.positions @ np.linalg.inv(np.array(cell))
    assert wrapped.min() >= -0.5 - 1e-12
    assert wrapped.max() < 0.5 + 1e-12


def test_cubic_cell_uses_only_its_first_number(make):
    scene = make(imcon=1, cell=((4, 0.1, 0), (0, 5, 0), (0, 0, 4))).scene()
    assert scene.cell.tolist() == np.diag([4.0] * 3).tolist()
    assert "imcon 1 uses only the first edge 4; 5 on the diagonal has no effect" in texts(scene, "warning")
    note = "imcon 1 uses only the diagonal of the cell; the other numbers have no effect"
    assert note in texts(scene, "warning")


def test_orthorhombic_cell_uses_only_its_diagonal(make):
    scene = make(imcon=2, cell=((4, 0, 0), (0, 5, 0), (0.5, 0, 6))).scene()
    assert scene.cell.tolist() == np.diag([4.0, 5.0, 6.0]).tolist()
    assert any("imcon 2 uses only the diagonal" in text for text in texts(scene, "warning"))


def test_left_handed_cell_is_a_cell(make):
    cell = ((0, 4, 0), (4, 0, 0), (0, 0, 4))
    scene = make(imcon=3, cell=cell, positions=[(3, 0, 0)] * 6).scene()
    assert scene.cell.tolist() == [[float(x) for x in row] for row in cell]
    np.testing.assert_allclose(scene.beads.positions, [(-1, 0, 0)] * 6)


def test_open_system_gets_the_box_of_dl_poly(make):
    reach = 1.0 + 1e-6
    places = [(5, 0, 0), (-6, 0.2, 0), (0, 1.5, 0), (0, 0, 0), (1, 0, 0), (2, 0, 0)]
    scene = make(imcon=0, positions=places).scene()
    np.testing.assert_allclose(np.diag(scene.cell), [12 + reach, 3 + reach, 3 * reach], rtol=1e-14)
    assert np.count_nonzero(scene.cell) == 3


def test_slab_keeps_its_periodic_vectors_and_extends_along_z(make):
    cell = ((4, 1, 0), (0, 5, 0), (0.5, 0, 20))
    scene = make(imcon=6, cell=cell).scene()
    assert scene.cell.tolist() == [[4.0, 1.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 20.0]]
    assert "imcon 6: only the z component of the third cell vector is used" in texts(scene, "warning")
    flat = make(imcon=6, cell=((4, 0, 0), (0, 4, 0), (0, 0, 1)), control={"cutoff": "1.5 ang"}).scene()
    assert flat.cell[2, 2] == pytest.approx(3 * (1.5 + 1e-6), rel=1e-14)


def test_cutoff_beyond_half_the_cell_is_legal_and_noted(make):
    scene = make(cell=((1.9, 0, 0), (0, 1.9, 0), (0, 0, 1.9))).scene()
    note = (
        "the longest range 1 ang is at least half the cell's width, 1.9 ang: a bead may meet several images of another"
    )
    assert f"{note}, and all count; DL_POLY would stop (error 95)" in texts(scene, "choice")


def test_skew_cell_is_judged_by_its_width_not_by_its_edges(make):
    cell = ((4, 0, 0), (3.9, 1.9, 0), (0, 0, 4))
    assert any("half the cell's width, 1.75188 ang" in n for n in texts(make(imcon=3, cell=cell).scene(), "choice"))


def test_vdw_cutoff_defaults_to_the_cutoff_and_raises_it(make):
    scene = make(control={"cutoff": "1.5 ang"}).scene()
    assert (scene.cutoff, scene.vdw_cutoff) == (1.5, 1.5)
    scene = make(control={"cutoff": "1.5 ang", "vdw_cutoff": "1.25 ang"}).scene()
    assert (scene.cutoff, scene.vdw_cutoff) == (1.5, 1.25)
    scene = make(control={"cutoff": "1.5 ang", "vdw_cutoff": "1.75 ang"}).scene()
    assert (scene.cutoff, scene.vdw_cutoff) == (1.75, 1.75)
    assert "the global cutoff is raised from 1.5 to vdw_cutoff, 1.75 ang" in texts(scene, "choice")


def test_short_cutoffs_are_legal_and_noted(make):
    scene = make(control={"cutoff": "0.5 ang", "vdw_cutoff": "0.4 ang"}).scene()
    assert (scene.cutoff, scene.vdw_cutoff) == (0.5, 0.4)
    assert "cutoff 0.5 ang is used as it is; DL_POLY would take 1 ang instead" in texts(scene, "choice")
    note = "vdw_cutoff 0.4 ang is used as it is; DL_POLY would take the global cutoff instead"
    assert note in texts(scene, "choice")


def test_warnings_of_the_readers_are_kept(make):
    scene = make(control={"ensemble_method": "dpd", "fixed_com": "yes"}).scene()
    assert any("DL_POLY reads 'yes' as off" in text for text in texts(scene, "warning"))
