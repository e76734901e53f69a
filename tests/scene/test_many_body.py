"""FIELD's ``mdpd`` records: both forms, what must be one number, mixing, and every refusal."""

from __future__ import annotations

import math

import pytest

from pydlpoly.errors import SceneError

NVE = {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None}
TWO = ("A A mdpd -40 25 1 0.75 4.5", "A B mdpd -30 25 1 0.75 4.5", "B B mdpd -10 25 1 0.75 4.5")
GENERAL = ("A A mdpd -40 1.5 2 2 1 0.75 4.5", "A B mdpd -30 1.5 3 0 1 0.8 4.5", "B B mdpd -10 1.5 2 3 1 0.75 4.5")


def test_two_density_form(make):
    scene = make(vdw=TWO).scene()
    given = scene.many_body
    assert (given.kernel, given.form, given.repulsion, given.powers) == ("warren", "two-density", 25.0, (2.0, 2.0))
    assert given.strength == pytest.approx(math.pi * 0.75**4 * 25.0 / 15.0, rel=1e-15)
    assert {term.species for term in given.terms} == {(0, 0), (0, 1), (1, 1)}
    height = 15.0 / (2.0 * math.pi * 0.75**3)
    assert all(term.height == pytest.approx(height, rel=1e-15) for term in given.terms)
    # C (rho_i + rho_j) 2 W(0)/rd is B (rho_i + rho_j).
    assert given.strength * given.terms[0].push == pytest.approx(25.0, rel=1e-14)
    term = scene.pairs[0]
    assert (term.parameters, term.drag, term.drag_cutoff, term.cutoff) == ((-40, 25, 2, 2, 1, 0.75), 4.5, 1.0, 1.0)
    text = scene.explain()
    assert "two-density form, B = 25 for all pairs" in text
    assert "mdpd: many-body DPD" in text


def test_generalised_form(make):
    given = make(vdw=GENERAL).scene().many_body
    assert (given.form, given.strength, given.powers) == ("generalised", 1.5, (2.0, 3.0))
    heights = {term.species: (term.height, term.exponent, term.range) for term in given.terms}
    assert heights[0, 0][0] == pytest.approx(60.0 / (8.0 * math.pi * 0.75**3))
    assert heights[0, 1] == (pytest.approx(120.0 / (8.0 * math.pi * 0.8**3)), 3.0, 0.8)
    text = make(vdw=GENERAL).scene().explain()
    assert "m = 2 for A, 3 for B" in text
    assert "A-B: W(0) =" in text


def test_energies_have_fields_unit(make):
    """A and B are energies: kJ/mol are 100 internal units."""
    plain = make(vdw=("A A mdpd -40 25 1 0.75",), units="kJ", atoms=("A 1.0 0.0",), counts=(6,), control=NVE).scene()
    assert plain.pairs[0].parameters[:2] == (-4000.0, 2500.0)
    assert plain.many_body.repulsion == 2500.0


def test_a_scene_without_it_has_none(make):
    assert make().scene().many_body is None
    off = make(vdw=TWO, control={"vdw_method": "off"}).scene()
    assert off.many_body is None


def test_mixing(make):
    """A by the rule of energies with its sign, rc and a different rd as lengths; B, n stay, m is the species' own."""
    vdw = ("A A mdpd -40 1.5 2 2 1.0 0.6", "B B mdpd -10 1.5 2 3 1.2 0.8")
    scene = make(vdw=vdw, control=NVE | {"vdw_mix_method": "lorentz-berthelot", "cutoff": "1.2 ang"}).scene()
    term = next(t for t in scene.pairs if t.species == (0, 1))
    assert term.law_origin == "mixed"
    assert term.parameters == pytest.approx((-20.0, 1.5, 2.0, 0.0, 1.1, 0.7))
    assert scene.many_body.powers == (2.0, 3.0)
    same = ("A A mdpd -40 25 1.0 0.6", "B B mdpd -10 25 1.2 0.6")
    for rule in ("halgren", "tang-toennies", "functional", "waldman-hagler"):
        mixed = make(vdw=same, control=NVE | {"vdw_mix_method": rule, "cutoff": "1.2 ang"}).scene()
        assert {t.range for t in mixed.many_body.terms} == {0.6}, "an rd that both have stays, whatever rc does"


@pytest.mark.parametrize(
    ("like", "reason"),
    [
        ("B B mdpd 10 25 1 0.75", "no mean of an attraction and a repulsion"),
        ("B B mdpd -10 24 1 0.75", "B is one number for all pairs"),
    ],
)
def test_what_is_not_mixed(make, like, reason):
    vdw = ("A A mdpd -40 25 1 0.75", like)
    with pytest.raises(SceneError, match=reason):
        make(vdw=vdw, control=NVE | {"vdw_mix_method": "hogervorst"}).scene()


def test_kernel_of_lammps(make):
    scene = make(vdw=TWO, control={"mdpd_kernel": "lucy"}).scene()
    given = scene.many_body
    assert (given.kernel, given.strength) == ("lucy", 0.0)
    assert {(t.height, t.push) for t in given.terms} == {(105.0 / (16.0 * math.pi * 0.75**3), 25.0)}
    assert any(note.kind == "warning" and "no potential belongs" in note.text for note in scene.notes)
    ignored = make(control={"mdpd_kernel": "lucy"}).scene()
    assert any(note.kind == "ignored" and "mdpd_kernel lucy" in note.text for note in ignored.notes)


@pytest.mark.parametrize(
    ("vdw", "control", "message"),
    [
        (
            (TWO[0], "A B mdpd -30 24 1 0.75 4.5", TWO[2]),
            {},
            r"FIELD:16: 'mdpd': B of A-B is 24, that of A-A 25: B must be one number for all pairs.*no-go theorem, "
            r"Warren",
        ),
        (
            (TWO[0], "A B mdpd -30 24 1 0.75 4.5", TWO[2]),
            {"mdpd_kernel": "lucy"},
            "B must be one number for all pairs",
        ),
        (
            (GENERAL[0], "A B mdpd -30 1.6 2 0 1 0.75 4.5", GENERAL[2]),
            {},
            "B of A-B is 1.6, that of A-A 1.5",
        ),
        (
            (TWO[0], "A B mdpd -30 25 1 0.7 4.5", TWO[2]),
            {},
            r"FIELD:16: 'mdpd': r_d of A-B is 0.7, that of A-A 0.75.*generalised form, A B n m rc rd, with B times pi",
        ),
        ((TWO[0], GENERAL[1], TWO[2]), {}, "FIELD:16: .*A-B has the generalised form, A-A the two-density one"),
        (GENERAL, {"mdpd_kernel": "lucy"}, "CONTROL:.*lucy goes with the two-density form"),
        (
            (GENERAL[0], "A B mdpd -30 1.5 3 4 1 0.8 4.5", GENERAL[2]),
            {},
            r"FIELD:16: .*m \(number 4\) belongs to the species, and their lines say 2 for A and 3 for B",
        ),
        (("A A mdpd -40 1.5 2 0 1 0.75 4.5", *GENERAL[1:]), {}, r"FIELD:15: .*m of A \(number 4\) must be 1 or more"),
        (
            ("A A dpd 25 1 4.5", "A B mdpd -30 1.5 3 0 1 0.8 4.5", "B B dpd 25 1 4.5"),
            {},
            "FIELD:16: .*no line says what m of A is",
        ),
        (("A A mdpd -40 25 1", *TWO[1:]), {}, r"FIELD:15: .*needs 6 numbers \(A B n m rc rd; or four, A B rc rd"),
        (("A A mdpd -40 25 1 0.75 4.5 0 0", *GENERAL[1:]), {}, r"n \(number 3\) must be 2 or more, not 1"),
        (("A A mdpd -40 25 1 1.1 4.5", *TWO[1:]), {}, r"rd \(number 6\) must be at most rc, not 1.1"),
        (("A A mdpd -40 -25 1 0.75 4.5", *TWO[1:]), {}, r"B \(number 2\) must be zero or a positive number"),
        (
            TWO,
            {"mdpd_kernel": "lucy", "ensemble": "npt", "ensemble_barostat_friction": "1 dpd_t^-1"},
            "lucy has no energy that a barostat could act on",
        ),
        (TWO, {"mdpd_kernel": "wendland"}, "wendland.*is no option of mdpd_kernel"),
    ],
)
def test_refusals(make, vdw, control, message):
    with pytest.raises(Exception, match=message) as caught:
        make(vdw=vdw, control=control).scene()
    assert type(caught.value).__name__ in ("SceneError", "InputError")


def test_m_of_a_species_without_a_line_of_its_own(make):
    """Of the lines in which it takes part, which must agree."""
    vdw = ("A A mdpd -40 1.5 2 2 1 0.75", "A B mdpd -30 1.5 2 2.5 1 0.75")
    scene = make(vdw=vdw, control=NVE).scene()
    assert scene.many_body.powers == (2.0, 2.5)


def test_drag_of_the_two_density_form_under_nve(make):
    scene = make(vdw=TWO, control=NVE).scene()
    assert any("the drag 4.5 of A-A has no effect under nve" in note.text for note in scene.notes)
