"""Electrostatics in the scene: strengths, shapes, Ewald's numbers, what is refused by name, what is noted."""

from __future__ import annotations

import math

import pytest

from pydlpoly import SceneError
from pydlpoly.units import (
    bjerrum_length_of_coupling,
    coupling_of_bjerrum_length,
    galamost_charge,
    valence_of_galamost_charge,
)

IONS = ("A 1.0 1.0", "B 2.0 -2.0")
GIVEN = {"coul_bjerrum_length": "1.1 dpd_l"}
EWALD = {"coul_method": "spme", **GIVEN, "cutoff": "1.5 dpd_l"}


def texts(scene, kind):
    return [note.text for note in scene.notes if note.kind == kind]


def electrostatics(make, control, **options):
    return make(control=control, atoms=IONS, **options).scene().electrostatics


def test_strength_from_a_bjerrum_length_or_a_coupling(make):
    one = electrostatics(make, {"coul_method": "pairwise", **GIVEN, "temperature": "2.0 dpd_temp"})
    assert one.strength == pytest.approx(2.2, rel=1e-14)
    other = electrostatics(make, {"coul_method": "pairwise", "coul_coupling": "13.87"})
    assert other.strength == pytest.approx(13.87 / (4.0 * math.pi), rel=1e-14)
    assert coupling_of_bjerrum_length(bjerrum_length_of_coupling(13.87)) == pytest.approx(13.87)


def test_strength_in_real_units(make):
    control = {"coul_method": "pairwise", "temperature": "300 K", "coul_dielectric_constant": "78.0"}
    assert electrostatics(make, control, units="kJ").strength == pytest.approx(138935.4835 / 78.0, rel=1e-14)
    bjerrum = {"coul_method": "pairwise", "temperature": "300 K", "coul_bjerrum_length": "7.14 ang"}
    assert electrostatics(make, bjerrum, units="kJ").strength == pytest.approx(7.14 * 300 * 0.831451115, rel=1e-14)


def test_charges_of_galamost():
    """q* of water at 300 K with three molecules a bead: its manual's 1.0514 in units of 0.646 nm and k_B T."""
    bjerrum = 138.935 / (78.0 * 0.646 * 300 * 0.00831446)
    assert galamost_charge(1.0, bjerrum) == pytest.approx(1.0514, abs=1e-3)
    assert galamost_charge(-2.0, 1.1, thermal_energy=2.0) == pytest.approx(-2.0 * math.sqrt(2.2))
    assert valence_of_galamost_charge(galamost_charge(3.0, 0.7), 0.7) == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("smearing", "shape", "length"),
    [
        ({}, "point", 1.0),
        ({"charge_smearing_method": "none"}, "point", 1.0),
        ({"charge_smearing_method": "Slater", "charge_smearing_length": "0.5 dpd_l"}, "slater", 0.5),
        ({"charge_smearing_method": "slater_approximate", "charge_smearing_beta": "2.5"}, "slater", 0.4),
        (
            {
                "charge_smearing_method": "slater",
                "charge_smearing_beta": "overlap",
                "charge_smearing_length": "0.5 dpd_l",
            },
            "slater",
            0.8,
        ),
        ({"charge_smearing_method": "slater-exact", "charge_smearing_length": "0.5 dpd_l"}, "slater-exact", 0.5),
        ({"charge_smearing_method": "gaussian", "charge_smearing_length": "0.5 dpd_l"}, "gaussian", 0.5),
        ({"charge_smearing_method": "linear", "charge_smearing_length": "0.5 dpd_l"}, "linear", 0.5),
    ],
)
def test_shapes(make, smearing, shape, length):
    given = electrostatics(make, {**EWALD, **smearing})
    assert (given.shape, given.length) == (shape, pytest.approx(length, rel=1e-14))


def test_ewalds_numbers(make):
    by_hand = {**EWALD, "spme_alpha": "2.0 dpd_l^-1", "spme_kvec": "[ 14 9 7 ]", "spme_nsplines": "5"}
    given = electrostatics(make, by_hand)
    assert (given.alpha, given.counts, given.order) == (2.0, (15, 9, 8), 6)
    plain = electrostatics(make, {**by_hand, "coul_method": "ewald_direct"})
    assert (plain.alpha, plain.counts, plain.order) == (2.0, (7, 4, 3), 0)
    notes = texts(make(control=by_hand, atoms=IONS).scene(), "choice")
    assert any(text.startswith("the mesh of 14 x 9 x 7 points becomes 15 x 9 x 8") for text in notes)
    assert any(text.startswith("splines of order 5 become 6") for text in notes)
    chosen = electrostatics(make, {**EWALD, "spme_precision": "1e-5"})
    product = 1e-5 * 1.5
    assert chosen.alpha == pytest.approx(math.sqrt(-math.log(product * math.sqrt(-math.log(product)))) / 1.5)


def test_damping_from_a_precision_is_that_of_dl_poly(make):
    given = electrostatics(
        make, {"coul_method": "force_shifted", **GIVEN, "coul_precision": "1e-4", "cutoff": "1.5 dpd_l"}
    )
    product = 1e-4 * 1.5
    assert given.alpha == pytest.approx(math.sqrt(-math.log(product * math.sqrt(-math.log(product)))) / 1.5)


def test_notes(make):
    scene = make(control={**EWALD, "charge_smearing_method": "gaussian", "charge_smearing_length": "0.9 dpd_l"},
                 atoms=IONS).scene()  # fmt: skip
    assert any(
        text.startswith("at the cutoff 1.5 the interaction of smeared charges is") for text in texts(scene, "choice")
    )
    off = make(control={"coul_method": "off", "spme_precision": "1e-5"}, atoms=IONS).scene()
    assert "the charges of A, B are ignored because coul_method is off" in texts(off, "warning")
    assert "spme_precision 1e-05: nothing in this scene uses it" in texts(off, "ignored")
    charged = make(control=EWALD, atoms=("A 1.0 1.0", "B 2.0 0.0")).scene()
    assert any("a uniform background makes the cell neutral" in text for text in texts(charged, "warning"))


REFUSALS = {
    "no strength": ({"coul_method": "spme"}, "coul_method", "in units dpd charges are in e"),
    "two strengths": ({**EWALD, "coul_coupling": "3.0"}, "coul_coupling", "says the same as coul_bjerrum_length"),
    "permittivity beside it": (
        {**EWALD, "coul_dielectric_constant": "2.0"},
        "coul_dielectric_constant",
        "the permittivity is already in coul_bjerrum_length",
    ),
    "negative strength": (
        {"coul_method": "pairwise", "coul_bjerrum_length": "-1 dpd_l"},
        "coul_bjerrum_length",
        "must be larger than 0, not -1",
    ),
    "zero coupling": ({"coul_method": "pairwise", "coul_coupling": "0"}, "coul_coupling", "must be larger than 0"),
    "permittivity of nothing": (
        {"coul_method": "reaction_field", **GIVEN, "coul_dielectric_constant": "0"},
        "coul_dielectric_constant",
        "must be larger than 0, not 0",
    ),
    "unknown shape": ({**EWALD, "charge_smearing_method": "cubic"}, "charge_smearing_method", "'cubic' is no shape"),
    "no length": (
        {**EWALD, "charge_smearing_method": "linear"},
        "charge_smearing_method",
        "need a charge_smearing_length",
    ),
    "negative length": (
        {**EWALD, "charge_smearing_method": "linear", "charge_smearing_length": "-1 dpd_l"},
        "charge_smearing_length",
        "need a charge_smearing_length above 0, not -1",
    ),
    "beta of nothing": (
        {**EWALD, "charge_smearing_method": "slater", "charge_smearing_beta": "wide"},
        "charge_smearing_beta",
        "'wide' is neither a number above 0",
    ),
    "beta and length": (
        {
            **EWALD,
            "charge_smearing_method": "slater",
            "charge_smearing_beta": "0.929",
            "charge_smearing_length": "1 dpd_l",
        },
        "charge_smearing_beta",
        "give one of them",
    ),
    "dddp with smeared charges": (
        {
            "coul_method": "dddp",
            **GIVEN,
            "charge_smearing_method": "slater",
            "charge_smearing_length": "1 dpd_l",
        },
        "charge_smearing_method",
        "cannot be combined with coul_method dddp",
    ),
    "two dampings": (
        {"coul_method": "force_shifted", **GIVEN, "coul_damping": "0.2 dpd_l^-1", "coul_precision": "1e-3"},
        "coul_precision",
        "says the same as coul_damping",
    ),
    "negative damping": (
        {"coul_method": "force_shifted", **GIVEN, "coul_damping": "-0.2 dpd_l^-1"},
        "coul_damping",
        "must not be negative",
    ),
    "alpha alone": ({**EWALD, "spme_alpha": "2 dpd_l^-1"}, "spme_alpha", "needs spme_kvec beside it"),
    "vectors alone": ({**EWALD, "spme_kvec": "[ 8 8 8 ]"}, "spme_kvec", "needs spme_alpha beside it"),
    "precision beside them": (
        {**EWALD, "spme_alpha": "2 dpd_l^-1", "spme_kvec": "[ 8 8 8 ]", "spme_precision": "1e-4"},
        "spme_precision",
        "chooses what spme_alpha and spme_kvec give by hand",
    ),
    "no vectors": ({**EWALD, "spme_alpha": "2 dpd_l^-1", "spme_kvec": "[ 8 0 8 ]"}, "spme_kvec", "three whole numbers"),
    "alpha of nothing": (
        {**EWALD, "spme_alpha": "0 dpd_l^-1", "spme_kvec": "[ 8 8 8 ]"},
        "spme_alpha",
        "larger than 0",
    ),
    "coarse precision": ({**EWALD, "spme_precision": "0.7"}, "spme_precision", "gives no alpha"),
    "negative precision": ({**EWALD, "spme_precision": "-1e-5"}, "spme_precision", "gives no alpha"),
    "no splines": ({**EWALD, "spme_nsplines": "22"}, "spme_nsplines", "must lie between 1 and 20"),
    "too many vectors": (
        {**EWALD, "spme_alpha": "2 dpd_l^-1", "spme_kvec": "[ 9000 9000 9000 ]"},
        "spme_kvec",
        "more reciprocal vectors than fit into memory",
    ),
    "cutoff of many cells": ({**EWALD, "cutoff": "500 dpd_l"}, "cutoff", "images of each charge lie within the cutoff"),
    "spacing": ({**EWALD, "spme_kvec_spacing": "0.1 dpd_l^-1"}, "spme_kvec_spacing", "give spme_kvec"),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_refusals(make, case):
    control, word, message = REFUSALS[case]
    with pytest.raises(SceneError) as caught:
        make(control=control, atoms=IONS).scene()
    assert (caught.value.word, message in caught.value.message) == (word, True), caught.value


@pytest.mark.parametrize("imcon", [0, 6])
@pytest.mark.parametrize("method", ["spme", "ewald_direct"])
def test_ewalds_sums_need_a_periodic_cell(make, imcon, method):
    with pytest.raises(SceneError, match=f"periodic along all three axes .* not imcon {imcon}") as caught:
        make(control={**EWALD, "coul_method": method}, atoms=IONS, imcon=imcon).scene()
    assert caught.value.word == "coul_method"
    assert electrostatics(make, {"coul_method": "force_shifted", **GIVEN}, imcon=imcon).method == "force_shifted"


def test_coupling_is_for_reduced_units(make):
    with pytest.raises(SceneError, match="belongs to units dpd"):
        electrostatics(make, {"coul_method": "pairwise", "coul_coupling": "13.87"}, units="kJ")


def test_bjerrum_length_needs_a_temperature(make):
    control = {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None, "temperature": "0 dpd_temp"}
    with pytest.raises(SceneError, match="the scene needs a temperature above 0"):
        electrostatics(make, {**control, "coul_method": "pairwise", **GIVEN})


def test_ewalds_sums_do_not_go_with_walls(make):
    walls = {"wall_method": "reflecting"}
    with pytest.raises(SceneError, match="'coul_method': spme sums over all images, but walls end the periodicity"):
        make(control={**EWALD, **walls}, atoms=IONS).scene()
    assert electrostatics(make, {"coul_method": "force_shifted", **GIVEN, **walls}).method == "force_shifted"


def test_charges_in_a_field_are_not_said_to_be_ignored(make):
    scene = make(atoms=IONS, after="extern\nelec 1.0 0.0 0.0").scene()
    assert "the charges of A, B act in the external field alone because coul_method is off" in texts(scene, "warning")
