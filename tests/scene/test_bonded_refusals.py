"""Bad bonded blocks: every refusal with its exact text, and what is read but has no effect."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pydlpoly import InputError, SceneError

FOUR = {"atoms": ("A 1.0 0.0 4", "B 2.0 0.0"), "counts": (1, 2)}
NEAR = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.5, 0.5], [1.5, 0.0, 0.0], [0.0, 1.5, 0.0]]

REFUSALS = {
    "tabulated": ("bonds 1\ntab 1 2", "FIELD:9: 'tab': the bond of A A has no table (TABBND)"),
    "tabulated_restraint": ("angles 1\n-tab 1 2 3", "FIELD:9: '-tab': the angle of A A A has no table (TABANG)"),
    "tabulated_number": (
        "bonds 1\ntab 1 2 0.5",
        "FIELD:9: 'tab': the number 0.5 has no meaning: the bond law tab takes its numbers from a file of tables",
    ),
    "coulomb": ("bonds 1\ncoul 1 2 0.5", "FIELD:9: 'coul': Coulomb bonds are not modelled yet"),
    "coulomb_restraint": ("bonds 1\n-cul 1 2 0.5", "FIELD:9: '-cul': Coulomb bonds are not modelled yet"),
    "unknown_key": (
        "bonds 1\nharn 1 2 10.0 0.5",
        "FIELD:9: 'harn': unknown key in bonds; did you mean harm?",
    ),
    "too_few": (
        "bonds 1\nharm 1 2 10.0",
        "FIELD:9: 'harm': the bond law harm needs 2 numbers (k r0), found 1",
    ),
    "too_few_angle": (
        "angles 1\n-cos 1 2 3 20.0 0.0",
        "FIELD:9: '-cos': the angle law cos needs 3 numbers (A delta m), found 2",
    ),
    "too_few_opls": (
        "dihedrals 1\nopls 1 2 3 4 1.0 2.0 3.0 4.0 5.0",
        "FIELD:9: 'opls': the dihedral law opls needs 5 numbers (A0 A1 A2 A3 phi0), with the two 1-4 factors as "
        "numbers 4 and 5, found 5",
    ),
    "too_many": (
        "bonds 1\nharm 1 2 10.0 0.5 3.0",
        "FIELD:9: 'harm': the number 3 has no meaning: the bond law harm takes k r0",
    ),
    "too_many_dihedral": (
        "dihedrals 1\nharm 1 2 3 4 10.0 120.0 3.0",
        "FIELD:9: 'harm': the number 3 has no meaning: the dihedral law harm takes k phi0",
    ),
    "fene_without_length": (
        "bonds 1\nfene 1 2 10.0 0.0",
        "FIELD:9: 'fene': bond law fene: R0 (number 2) must be a positive number, not 0",
    ),
    "fene_far_off": (
        "bonds 1\nfene 1 2 10.0 1.0 0.6",
        "FIELD:9: 'fene': bond law fene: D (number 3) must be at most half of R0, not 0.6",
    ),
    "buckingham": (
        "bonds 1\nbuck 1 2 10.0 0.0 1.0",
        "FIELD:9: 'buck': bond law buck: rho (number 2) must be a positive number, not 0",
    ),
    "restraint_limit": (
        "bonds 1\nrhrm 1 2 10.0 0.5 -1.0",
        "FIELD:9: 'rhrm': bond law rhrm: rc (number 3) must be zero or a positive number, not -1",
    ),
    "vessal": (
        "angles 1\nbvs1 1 2 3 10.0 180.0 1.0 1.0",
        "FIELD:9: 'bvs1': angle law bvs1: th0 (number 2) must be another angle than 180 degrees, not 3.14159",
    ),
    "screening": (
        "angles 1\nshrm 1 2 3 10.0 120.0 1.0 0.0",
        "FIELD:9: 'shrm': angle law shrm: rho2 (number 4) must be a positive number, not 0",
    ),
    "double_count": (
        "dihedrals 1\n-cos 1 2 3 4 1.0 0.0 1 0.0 0.5",
        "FIELD:9: '-cos': the restraint form leaves the 1-4 pair its whole pair force, and the 1-4 factors (numbers "
        "4 and 5) would count it again; leave them out, or write cos",
    ),
    "outside": ("bonds 1\nharm 1 5 10.0 0.5", "FIELD:9: '5': the molecule has beads 1 to 4"),
    "itself": ("bonds 1\nharm 2 2 10.0 0.5", "FIELD:9: bead 2 appears twice in one entry of bonds"),
    "twice": (
        "bonds 2\nharm 1 2 10.0 0.5\nharm 2 1 10.0 0.5",
        "FIELD:10: the same beads are listed in bonds on line 9",
    ),
    "tether_key": (
        "teth 1\n-hrm 1 10.0",
        "FIELD:9: '-hrm': unknown key in tethers; did you mean rhrm, harm?",
    ),
    "tether_numbers": ("teth 1\nrhrm 1 10.0", "FIELD:9: 'rhrm': the tether law rhrm needs 2 numbers (k rc), found 1"),
    "rigid": ("rigid 1\n2 1 2", "FIELD:8: 'rigid': the block rigid of molecule mol1 is not modelled yet"),
    "constraint_of_no_length": (
        "constraints 1\n1 2 0.0",
        "FIELD:9: '0': the length of a constraint must be a positive number",
    ),
    "constraint_with_two_lengths": (
        "constraints 1\n1 2 0.5 0.6",
        "FIELD:9: the number 0.6 has no meaning: a constraint takes two beads and a length",
    ),
    "constraint_beyond_the_cutoff": (
        "constraints 2\n1 2 0.5\n2 3 1.0",
        "FIELD:10: '1': the constraint is not shorter than the cutoff, 1 ang (DL_POLY's error 34)",
    ),
    "constraint_outside": ("constraints 1\n1 5 0.5", "FIELD:9: '5': the molecule has beads 1 to 4"),
    "constraint_of_one_bead": ("constraints 1\n2 2 0.5", "FIELD:9: bead 2 appears twice in one entry of constraints"),
    "constraint_twice": (
        "constraints 2\n1 2 0.5\n2 1 0.5",
        "FIELD:10: the same beads are listed in constraints on line 9",
    ),
    "constraints_twice": (
        "constraints 1\n1 2 0.5\nconstraints 1\n2 3 0.5",
        "FIELD:10: 'constraints': molecule 'mol1' has constraints twice (first on line 8)",
    ),
    "constraint_far_from_its_length": (
        "constraints 1\n1 2 0.3",
        "CONFIG: beads 1 and 2 are 0.5 apart at the start, their constraint is 0.3: too far off to be mended",
    ),
    "shells": ("shell 1\n1 2 10.0", "FIELD:8: 'shells': the block shells of molecule mol1 is not modelled yet"),
    "pmf": (
        "pmf 1.5\npmf unit 1\n1 0.0\npmf unit 1\n2 0.0",
        "FIELD:8: 'pmf': the block pmf of molecule mol1 is not modelled yet",
    ),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_bad_blocks(make: Any, case: str) -> None:
    inside, message = REFUSALS[case]
    with pytest.raises(InputError) as caught:
        make(**FOUR, positions=NEAR, inside=inside).scene()
    assert str(caught.value) == message


def test_beads_too_far_apart_at_the_start(make: Any) -> None:
    positions = [[0.0, 0.0, 0.0], [1.9, 1.0, 0.0], *NEAR[2:]]
    with pytest.raises(SceneError) as caught:
        make(**FOUR, positions=positions, inside="bonds 1\nharm 1 2 10.0 0.5").scene()
    assert str(caught.value) == (
        "CONFIG: beads 1 and 2 of a bond (FIELD:9) are 2.14709 apart, more than half the cell's width (2): which image "
        "is meant is not certain"
    )


@pytest.mark.parametrize(
    ("inside", "kind"),
    [
        ("angles 1\nharm 1 3 2 10.0 120.0", "an angle"),
        ("dihedrals 1\ncos 1 2 3 4 1.0 0.0 1", "a dihedral"),
        ("inversions 1\nplan 2 1 3 4 1.0", "an inversion"),
    ],
)
def test_other_terms_too_far_apart_at_the_start(make: Any, inside: str, kind: str) -> None:
    positions = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [1.9, 1.9, 1.9], *NEAR[3:]]
    with pytest.raises(SceneError) as caught:
        make(**FOUR, positions=positions, inside=inside).scene()
    assert f"of {kind} (FIELD:9) are" in str(caught.value)
    assert "more than half the cell's width (2): which image is meant is not certain" in str(caught.value)


def test_constraints_that_depend_on_each_other(make: Any) -> None:
    """Three beads in a line: two of the three distances fix the third, to first order."""
    line = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.9, 0.0, 0.0], *NEAR[3:]]
    inside = "constraints 3\n1 2 0.5\n2 3 0.4\n1 3 0.9"
    with pytest.raises(SceneError) as caught:
        make(**FOUR, positions=line, inside=inside).scene()
    assert str(caught.value) == (
        "FIELD:9: 'constraints': the 3 constraints of molecule mol1 depend on each other at the start: 2 fix the same "
        "shape; leave the others out"
    )
    bent = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 0.4, 0.0], *NEAR[3:]]
    inside = inside.replace("1 3 0.9", f"1 3 {0.41**0.5!r}")
    scene = make(**FOUR, positions=bent, inside=inside).scene()
    assert (scene.constraint_count, scene.degrees_of_freedom) == (3, 3 * 6 - 3 - 3)


def test_constraints_as_long_as_half_the_cell(make: Any) -> None:
    positions = [[0.0, 0.0, 0.0], [1.9, 0.0, 0.0], *NEAR[2:]]
    with pytest.raises(SceneError) as caught:
        make(**FOUR, positions=positions, inside="constraints 1\n1 2 2.0", control={"cutoff": "3.0 ang"}).scene()
    assert str(caught.value) == "FIELD:9: '2': the constraint is not shorter than half the cell's width, 2 ang"


@pytest.mark.parametrize(
    ("control", "message"),
    [
        (
            {"ensemble_dpd_order": "scvv"},
            "CONTROL:4: 'ensemble_dpd_order': constraints are not modelled with scvv; they are with nve, mdvv, dpdvv, "
            "zeroth, first, second, peters, peters-first, lowe-andersen, stoyanov-groot, ou, ou-middle, middle, "
            "langevin, berendsen, hoover",
        ),
        (
            {"ensemble": "npt", "ensemble_barostat_friction": "1 dpd_t^-1"},
            "CONTROL:2: 'ensemble': constraints are not modelled in a cell that follows the pressure; take ensemble "
            "nve or nvt",
        ),
        (
            {"diagnostics_frequency": "10 steps"},
            "CONTROL:10: 'diagnostics_frequency': DIAGNOSTICS holds the configurational temperature, which is not "
            "modelled with constraints",
        ),
        (
            {"shake_tolerance": "0 ang"},
            "CONTROL:10: 'shake_tolerance': the tolerance of constraints must be above 0 and below all lengths, the "
            "shortest of which is 0.5, not 0",
        ),
        (
            {"shake_tolerance": "0.6 ang"},
            "CONTROL:10: 'shake_tolerance': the tolerance of constraints must be above 0 and below all lengths, the "
            "shortest of which is 0.5, not 0.6",
        ),
        (
            {"shear_rate": "0.1 dpd_t^-1"},
            "CONTROL:10: 'shear_rate': constraints are not modelled in a sheared cell",
        ),
        (
            {"wall_method": "reflecting", "wall_axes": "z"},
            "CONTROL:10: 'wall_method': constraints are not modelled between walls",
        ),
        (
            {"stress_profile_frequency": "10 steps"},
            "CONTROL:10: 'stress_profile_frequency': the stress in layers is not modelled with constraints",
        ),
        (
            {"ensemble_dpd_order": "middle", "correlation_observable": "[s_xy-s_xy]"},
            "CONTROL:10: 'correlation_observable': with constraints and middle the stress lacks what lengths do to "
            "drag and noise; mdvv has all of it",
        ),
        ({"shake_max_iter": "0"}, "CONTROL:10: 'shake_max_iter': constraints need at least one iteration, not 0"),
    ],
)
def test_settings_that_do_not_go_with_constraints(make: Any, control: dict[str, str], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        make(**FOUR, positions=NEAR, inside="constraints 1\n1 2 0.5", control=control).scene()
    assert str(caught.value) == message


@pytest.mark.parametrize("field", ["magn 1.0 0.0 0.0", "grav 1.0 0.0 0.0"])
def test_fields_that_turn_velocities_do_not_go_with_constraints(make: Any, field: str) -> None:
    atoms = {"atoms": ("A 1.0 0.5 4", "B 2.0 0.0"), "counts": (1, 2)}
    given = make(**atoms, positions=NEAR, inside="constraints 1\n1 2 0.5", after=f"extern\n{field}")
    if field.startswith("grav"):
        assert given.scene().constraint_count == 1
        return
    with pytest.raises(SceneError) as caught:
        given.scene()
    assert str(caught.value) == (
        "FIELD:21: 'magn': constraints are not modelled with a field that sets or turns velocities"
    )


def test_constraints_of_frozen_beads_are_left_out(make: Any) -> None:
    atoms = {"atoms": ("A 1.0 0.0 4 1", "B 2.0 0.0"), "counts": (1, 2)}
    scene = make(**atoms, positions=NEAR, inside="constraints 1\n1 2 0.5").scene()
    assert scene.constraints is None
    assert [(note.kind, note.text) for note in scene.notes if "constraint" in note.text] == [
        ("ignored", "the constraint of beads 1 and 2 is left out: both are frozen")
    ]


@pytest.mark.parametrize(
    ("inside", "kind", "text"),
    [
        (
            "constraints 1\n1 2 0.51",
            "choice",
            "beads 1 and 2 are 0.5 apart at the start, their constraint is 0.51; beads are moved",
        ),
        ("bonds 1\nharm 2 1 1.0 0.4\nconstraints 1\n1 2 0.5", "warning", "beads 1 and 2 have a bond, too, on line 9"),
    ],
)
def test_notes_on_constraints(make: Any, inside: str, kind: str, text: str) -> None:
    scene = make(**FOUR, positions=NEAR, inside=inside).scene()
    assert [note.kind for note in scene.notes if note.text.startswith(text)] == [kind]


def test_molecules_without_copies_may_hold_anything(make: Any) -> None:
    scene = make(atoms=("A 1.0 0.0 4", "B 2.0 0.0"), counts=(0, 2), inside="bonds 1\ntab 1 2").scene()
    assert scene.bonded is None


def test_optional_numbers(make: Any) -> None:
    inside = "bonds 1\nfene 1 2 10.0 1.5\ndihedrals 1\nopls 1 2 3 4 1.0 2.0 3.0 0.0 0.0 4.0"
    scene = make(**FOUR, positions=NEAR, inside=inside).scene()
    assert scene.bonded is not None
    assert [term.parameters for term in scene.bonded.terms] == [(10.0, 1.5, 0.0), (1.0, 2.0, 3.0, 4.0, 0.0)]


def test_units_and_angles(make: Any) -> None:
    inside = "bonds 1\nmors 1 2 3.0 0.5 2.0\nangles 1\ncmps 1 2 3 1.0 2.0 3.0 90.0 0.5 0.6"
    scene = make(**FOUR, positions=NEAR, inside=inside, units="kJ").scene()
    assert scene.bonded is not None
    bond, angle = scene.bonded.terms
    assert bond.parameters == (300.0, 0.5, 2.0)
    assert angle.parameters == pytest.approx((100.0, 200.0, 300.0, np.pi / 2.0, 0.5, 0.6))


@pytest.mark.parametrize(
    ("inside", "kind", "text"),
    [
        ("angles 1\nmmbd 1 2 3 1.0 120.0", "choice", "mmbd takes the deviation in radians"),
        ("angles 1\nkky 1 2 3 1.0 120.0 2.0 1.0", "choice", "kky fades with distance"),
        ("dihedrals 1\nrbf 1 2 3 4 1.0", "choice", "the hill of rbf at 180 degrees acts from both sides"),
        ("inversions 1\nxpln 1 2 3 4 1.0 2.0 30.0", "choice", "the numbers of xpln are k m phi0"),
        ("teth 1\nrhrm 1 1.0 0.5", "choice", "rc of a rhrm tether is a length"),
        ("dihedrals 1\ncos 1 2 3 4 1.0 0.0 1.5", "warning", "the energy jumps at 180 degrees because m = 1.5"),
        ("dihedrals 1\ncos 1 2 3 4 1.0 0.0 1 0.5 0.0", "ignored", "the electrostatic 1-4 factors of molecule mol1"),
    ],
)
def test_notes(make: Any, inside: str, kind: str, text: str) -> None:
    scene = make(**FOUR, positions=NEAR, inside=inside, units="kJ", control={"temperature": "1.0 K"}).scene()
    found = [note for note in scene.notes if note.text.startswith(text)]
    assert [note.kind for note in found] == [kind]
    assert found[0].where.startswith("FIELD")


def test_arrays_cannot_be_changed(make: Any) -> None:
    inside = "bonds 1\nharm 1 2 1.0 0.5\nteth 1\nharm 1 1.0\ndihedrals 1\ncos 1 2 3 4 1.0 0.0 1 0.0 0.5"
    bonded = make(**FOUR, positions=NEAR, inside=inside).scene().bonded
    assert bonded is not None
    arrays = [bonded.excluded, bonded.scaled, bonded.scales, bonded.anchors, *(term.beads for term in bonded.terms)]
    assert not any(array.flags.writeable for array in arrays)
