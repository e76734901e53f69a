"""The pair table: laws, mixing, drags, ranges, and where each number comes from."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pydlpoly.formats.records import PairTable

LB = {"vdw_mix_method": "lorentz-berthelot"}
NVE = {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None}
LIKE = ("A A dpd 25.0 1.0 4.5", "B B dpd 36.0 2.0 18.0")


def pair(scene, a, b):
    wanted = tuple(sorted((scene.species.index(a), scene.species.index(b))))
    return next(term for term in scene.pairs if term.species == wanted)


def texts(scene, kind):
    return [note.text for note in scene.notes if note.kind == kind]


def test_pairs_are_ordered_as_the_lower_triangle(make):
    names = ("A 1.0", "B 1.0", "C 1.0")
    vdw = [f"{a} {b} dpd 25.0 1.0 4.5" for a, b in ("CC", "BC", "AA", "AB", "CA", "BB")]
    scene = make(atoms=names, counts=(2, 2, 2), vdw=vdw).scene()
    assert [term.species for term in scene.pairs] == [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)]


def test_given_numbers_and_their_origin(make):
    term = pair(make().scene(), "A", "B")
    assert (term.law, term.parameters, term.cutoff) == ("dpd", (30.0, 1.0), 1.0)
    assert (term.drag, term.drag_cutoff, term.noise) == (4.5, 1.0, 3.0)
    assert (term.law_origin, term.drag_origin) == ("given", "given")
    assert term.explanation == "law FIELD:16; drag FIELD:16"


def test_only_energies_are_scaled_by_the_unit(make):
    term = pair(make(units="kJ", vdw=("A A ndpd 3.0 15.0 4 1.5 4.5",), control=NVE).scene(), "A", "A")
    assert term.parameters == (300.0, 15.0, 4.0, 1.5)


def test_drag_is_never_scaled_by_the_unit(make):
    scene = make(units="kcal", vdw=[line.replace("4.5", "2.0") for line in make().vdw]).scene()
    assert [term.drag for term in scene.pairs] == [2.0, 2.0, 2.0]


@pytest.mark.parametrize(
    ("rule", "drag"),
    [
        ("lorentz-berthelot", 9.0),
        ("fender-halsey", 7.2),
        ("hogervorst", 9.0),
        ("halgren", 8.0),
        ("waldman-hagler", 9.0 * 8.0 / 32.5),
    ],
)
def test_law_and_drag_are_mixed_by_the_rule(make, rule, drag):
    # A: ε = 25, σ = 1, γ = 4.5 and B: ε = 36, σ = 2, γ = 18; 4·4.5·18/(√4.5+√18)² = 8
    term = pair(make(vdw=LIKE, control={"vdw_mix_method": rule}).scene(), "A", "B")
    assert term.drag == pytest.approx(drag, rel=1e-12)
    assert (term.law_origin, term.drag_origin) == ("mixed", "mixed")
    assert term.explanation == f"law mixed from A-A and B-B by {rule}; drag mixed from A-A and B-B by {rule}"
    assert term.cutoff == term.parameters[1] == term.drag_cutoff
    assert term.noise == pytest.approx(math.sqrt(2 * drag), rel=1e-12)


def test_lorentz_berthelot_parameters(make):
    term = pair(make(vdw=LIKE, control=LB).scene(), "A", "B")
    assert term.parameters == pytest.approx((30.0, 1.5), rel=1e-14)


@pytest.mark.parametrize("rule", ["tang-toennies", "functional"])
def test_drag_of_rules_that_weigh_by_energy(make, rule):
    term = pair(make(vdw=LIKE, control={"vdw_mix_method": rule}).scene(), "A", "B")
    assert term.drag == pytest.approx(0.5 * term.parameters[0] * (4.5 / 25.0 + 18.0 / 36.0), rel=1e-12)


def test_given_pair_is_never_mixed_over(make):
    term = pair(make(vdw=(*LIKE, "A B dpd 7.0 1.25 2.0"), control=LB).scene(), "A", "B")
    assert (term.parameters, term.drag, term.drag_cutoff) == ((7.0, 1.25), 2.0, 1.25)


def test_given_law_without_drag_takes_the_mixed_drag(make):
    term = pair(make(vdw=(*LIKE, "A B dpd 7.0 1.25"), control=LB).scene(), "A", "B")
    assert (term.parameters, term.law_origin, term.drag_origin) == ((7.0, 1.25), "given", "mixed")
    assert term.drag == pytest.approx(9.0, rel=1e-12)
    assert term.drag_cutoff == 1.25


@pytest.mark.parametrize(("rule", "drag"), [("waldman-hagler", 9.0), ("tang-toennies", 11.25), ("functional", 11.25)])
def test_pairs_of_different_laws_mix_only_the_drag(make, rule, drag):
    vdw = ("A A dpd 25.0 1.0 4.5", "B B lj 1.0 0.4 18.0")
    scene = make(vdw=vdw, control={"vdw_mix_method": rule, "vdw_cutoff": "0.9 ang"}).scene()
    term = pair(scene, "A", "B")
    assert (term.law, term.law_origin, term.drag_origin) == (None, "none", "mixed")
    assert term.drag == pytest.approx(drag, rel=1e-12)
    assert term.drag_cutoff == 0.9
    assert term.explanation == f"law none; drag mixed from A-A and B-B by {rule} (drag only)"


def test_laws_that_cannot_be_mixed_stay_without_a_law(make):
    vdw = ("A A ndpd 25.0 3.0 2 1.0 4.5", "B B ndpd 30.0 3.0 2 1.0 4.5")
    scene = make(vdw=vdw, control=LB).scene()
    assert pair(scene, "A", "B").law is None
    assert pair(scene, "A", "B").drag == pytest.approx(4.5)
    note = "no pair law for A-B: these beads do not feel each other (DL_POLY's warning 120)"
    assert f"{note}; lorentz-berthelot mixes only like pairs of the same mixable law" in texts(scene, "warning")


def test_two_like_drags_of_zero_mix_to_zero(make):
    vdw = ("A A dpd 25.0 1.0 0.0", "B B dpd 36.0 2.0 0.0", "C C dpd 25.0 1.0 1.0")
    control = {"vdw_mix_method": "fender-halsey"}
    scene = make(atoms=("A 1.0", "B 1.0", "C 1.0"), counts=(2, 2, 2), vdw=vdw, control=control).scene()
    assert pair(scene, "A", "B").drag == 0.0
    assert pair(scene, "A", "B").drag_cutoff == 0.0


def test_ensemble_drag_fills_only_pairs_without_one(make):
    scene = make(vdw=("A A dpd 25.0 1.0 4.5", "A B dpd 30.0 1.0"), control={"ensemble_dpd_drag": "2.0 Da/ps"}).scene()
    assert [term.drag for term in scene.pairs] == [4.5, 2.0, 2.0]
    assert [term.drag_origin for term in scene.pairs] == ["given", "filled", "filled"]
    bare = pair(scene, "B", "B")
    assert (bare.law, bare.drag_cutoff) == (None, 1.0)
    assert bare.explanation == "law none; drag filled from ensemble_dpd_drag (CONTROL:10)"


def test_mixing_comes_before_filling(make):
    control = {**LB, "ensemble_dpd_drag": "2.0 Da/ps"}
    assert pair(make(vdw=LIKE, control=control).scene(), "A", "B").drag == pytest.approx(9.0)


def test_override_replaces_every_drag(make):
    control = {"ensemble_dpd_drag": "2.0 Da/ps", "ensemble_dpd_drag_override": "on"}
    scene = make(control=control).scene()
    assert [(term.drag, term.drag_origin) for term in scene.pairs] == [(2.0, "overridden")] * 3
    assert scene.pairs[0].explanation == "law FIELD:15; drag overridden by ensemble_dpd_drag (CONTROL:10)"


def test_negative_drags_lose_their_sign_and_say_so(make):
    scene = make(vdw=("A A dpd 25.0 1.0 -4.5",), control={"ensemble_dpd_drag": "-2.0 Da/ps"}).scene()
    assert [term.drag for term in scene.pairs] == [4.5, 2.0, 2.0]
    assert "negative drag -4.5 of A A: the absolute value is taken, as DL_POLY does" in texts(scene, "warning")
    assert "negative ensemble_dpd_drag -2: the absolute value is taken, as DL_POLY does" in texts(scene, "warning")


def test_drag_of_zero_that_is_written_counts_as_given(make):
    vdw = ("A A dpd 25.0 1.0 4.5", "A B dpd 30.0 1.0 0.0", "B B dpd 25.0 1.0 4.5")
    scene = make(vdw=vdw, control={"ensemble_dpd_drag": "2.0 Da/ps"}).scene()
    assert (pair(scene, "A", "B").drag, pair(scene, "A", "B").drag_origin) == (0.0, "given")
    assert "the drag of A-B is 0: no pair thermostat acts there" in texts(scene, "warning")


def test_pairs_that_cannot_meet_need_no_drag(make):
    vdw = ("A A dpd 25.0 1.0 4.5", "A B dpd 30.0 1.0 4.5")
    scene = make(counts=(5, 1), vdw=vdw).scene()
    assert pair(scene, "B", "B").explanation == "law none; no two beads of this kind"
    frozen = make(atoms=("A 1.0 0.0", "B 2.0 0.0 1 1"), vdw=vdw).scene()
    assert pair(frozen, "B", "B").drag_origin == "none"


def test_drag_under_nve_has_no_effect_and_is_noted(make):
    scene = make(control=NVE).scene()
    assert all(term.drag == term.noise == term.drag_cutoff == 0.0 for term in scene.pairs)
    assert "the drag 4.5 of A-B has no effect under nve" in texts(scene, "ignored")


def test_a_number_after_the_drag_is_its_own_cutoff(make):
    scene = make(vdw=("A A dpd 25.0 1.0 4.5 1.75", "A B dpd 30.0 1.0 4.5", "B B dpd 25.0 1.0 4.5")).scene()
    assert [term.drag_cutoff for term in scene.pairs] == [1.75, 1.0, 1.0]
    assert [term.cutoff for term in scene.pairs] == [1.0, 1.0, 1.0]


def test_global_drag_cutoff(make):
    control = {"ensemble_dpd_cutoff": "global", "cutoff": "1.5 ang"}
    scene = make(control=control, vdw=("A A dpd 25.0 1.0 4.5 1.75", *make().vdw[1:])).scene()
    assert [term.drag_cutoff for term in scene.pairs] == [1.5, 1.5, 1.5]


def test_mixed_drag_does_not_inherit_drag_cutoffs(make):
    vdw = ("A A dpd 25.0 1.0 4.5 1.75", "B B dpd 25.0 1.0 4.5 1.75")
    scene = make(vdw=vdw, control=LB).scene()
    assert pair(scene, "A", "B").drag_cutoff == 1.0
    assert any("drag cutoffs of the like pairs are not" in text for text in texts(scene, "warning"))


def test_rules_without_anything_to_do_are_noted(make):
    scene = make(control={**LB, "ensemble_dpd_drag": "2.0 Da/ps"}).scene()
    assert "vdw_mix_method lorentz-berthelot has nothing to mix" in texts(scene, "ignored")
    assert "ensemble_dpd_drag has no pair to fill: every pair has a drag of its own" in texts(scene, "ignored")
    assert not [n for n in texts(make(vdw=LIKE, control=LB).scene(), "ignored") if "nothing to mix" in n]


def test_padding_zeros_are_harmless(make):
    scene = make(vdw=[f"{line} 0.0 0.0" for line in make().vdw]).scene()
    assert [term.drag_cutoff for term in scene.pairs] == [1.0, 1.0, 1.0]
    assert "zeros after the numbers of the dpd record of A A have no meaning" in texts(scene, "ignored")


def test_wca_takes_its_drag_from_slot_4_and_its_shift_may_be_left_out(make):
    scene = make(vdw=("A A wca 1.0 0.8 0.1 4.5", "A B wca 1.0 0.8", "B B dpd 1 1 1"), control=fill(1.0)).scene()
    first, second = scene.pairs[:2]
    assert (first.parameters, first.drag) == ((1.0, 0.8, 0.1), 4.5)
    assert first.cutoff == first.drag_cutoff == pytest.approx(0.1 + 2 ** (1 / 6) * 0.8)
    assert (second.parameters, second.drag) == ((1.0, 0.8, 0.0), 1.0)
    assert [n.where for n in scene.notes if n.text.startswith("number 4 of the wca record")] == ["FIELD:15"]


def test_zbl_takes_its_drag_from_slot_5(make):
    scene = make(vdw=("A A zbl 6 8 0 0 4.5",), control=fill(1.0)).scene()
    assert (scene.pairs[0].parameters, scene.pairs[0].drag) == ((6.0, 8.0), 4.5)
    assert any(text.startswith("number 5 of the zbl record is its drag") for text in texts(scene, "choice"))


def test_m126_gets_its_drag_by_filling(make):
    scene = make(vdw=("A A m126 1.0 1.0 0.8",), control=fill(3.0)).scene()
    assert (scene.pairs[0].drag, scene.pairs[0].drag_origin) == (3.0, "filled")


def fill(drag):
    return {"ensemble_dpd_drag": f"{drag} Da/ps"}


def test_soft_law_keeps_its_range_beyond_the_cutoff(make):
    vdw = ("A A dpd 25.0 1.8 4.5", "A B lj 1.0 0.3 4.5", "B B dpd 25.0 0.7 4.5")
    scene = make(vdw=vdw, control={"vdw_cutoff": "0.9 ang"}).scene()
    assert [term.cutoff for term in scene.pairs] == [1.8, 0.9, 0.7]
    assert [term.drag_cutoff for term in scene.pairs] == [1.8, 0.9, 0.7]
    note = "A-A keep the range of their law, beyond the global cutoff 1 ang; DL_POLY truncates them there"
    assert note in texts(scene, "choice")


def test_dl_poly_would_cut_other_laws_at_the_longest_range(make):
    vdw = ("A A dpd 25.0 0.7 4.5", "A B lj 1.0 0.3 4.5", "B B dpd 25.0 0.7 4.5")
    note = "A-B end at the van der Waals cutoff 1 ang; DL_POLY cuts them at 0.7 ang, the longest range that FIELD gives"
    assert note in texts(make(vdw=vdw).scene(), "choice")


def test_force_shift_acts_on_laws_that_do_not_end_by_themselves(make):
    vdw = ("A A dpd 25.0 1.0", "A B lj 1.0 0.3", "B B wca 1.0 0.3 0.0")
    scene = make(vdw=vdw, control={**NVE, "vdw_force_shift": "on"}).scene()
    assert [term.force_shift for term in scene.pairs] == [False, True, False]


def test_vdw_method_off_leaves_drag_and_noise(make):
    scene = make(control={"vdw_method": "off"}).scene()
    assert [(term.law, term.drag, term.drag_cutoff) for term in scene.pairs] == [(None, 4.5, 1.0)] * 3
    assert scene.pairs[0].explanation == "law FIELD:15, left out by vdw_method off; drag FIELD:15"
    assert "vdw_method off: no conservative pair forces" in texts(scene, "warning")


def test_tabulated_law_is_scaled_and_ends_with_its_table(make):
    r = 0.01 * np.arange(1, 81)
    table = PairTable(("B", "A"), 0.01, 0.8, 3.0 * (1 - r), 3.0 * r)
    vdw = ("A A dpd 25.0 1.0 4.5", "A B tab 4.5", "B B dpd 25.0 1.0 4.5")
    scene = make(units="kJ", vdw=vdw, tables=(table,)).scene()
    term = pair(scene, "A", "B")
    assert (term.law, term.parameters, term.cutoff, term.drag, term.table_spacing) == ("tab", (), 0.8, 4.5, 0.01)
    np.testing.assert_allclose(term.table, [300.0 * (1 - r), 300.0 * r])
    shorter = make(units="kJ", vdw=vdw, tables=(table,), control={"vdw_cutoff": "0.5 ang"}).scene()
    assert pair(shorter, "A", "B").cutoff == 0.5


def test_noise_follows_the_temperature(make):
    scene = make(control={"temperature": "4.0 dpd_temp"}).scene()
    assert scene.pairs[0].noise == pytest.approx(math.sqrt(2 * 4.5 * 4.0), rel=1e-15)
