"""Records made from plain Python values equal those that are read from text, and refuse what a file could not say."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.control import parse_control
from pydlpoly.formats.field import parse_field
from pydlpoly.formats.from_python import control_from_mapping, pair_lines, single_bead_field


def test_a_mapping_is_read_as_the_same_words_in_a_file_are():
    control = control_from_mapping(
        {
            "timestep": "0.5 fs",
            "title": "from a mapping",
            "vdw_force_shift": True,
            "fixed_com": np.False_,
            "ensemble_dpd_lambda": np.float64(0.65),
            "random_seed": (11, np.int64(12), 13),
            "threads": 2,
            "io_file_output": "SCREEN",
        }
    )
    text = """title from a mapping
timestep 0.5 fs
vdw_force_shift on
fixed_com off
ensemble_dpd_lambda 0.65
random_seed [ 11 12 13 ]
threads 2
io_file_output SCREEN
"""
    assert control == parse_control(text)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"timestpe": "1 fs"}, r"control: 'timestpe': is no keyword of CONTROL; did you mean timestep.*"),
        ({"steps": 10}, r"control: 'steps': is no keyword of CONTROL.*"),  # an old directive, legal in old files only
        ({"timestep": "1 fs # short"}, r"control: 'timestep': a value is one line without comments"),
        ({"title": "a\nthreads 1"}, r"control: 'title': a value is one line without comments"),
        ({"timestep": None}, r"control: 'timestep': expected a string or a number, not NoneType"),
        ({"threads": {2: 1}}, r"control: 'threads': expected a string or a number, not dict"),
        ({"timestep": 0.001}, r"control.*timestep.*unit.*"),
    ],
)
def test_settings_that_are_refused(settings, message):
    with pytest.raises(InputError, match=rf"^{message}$"):
        control_from_mapping(settings)


def test_pair_laws_by_species_make_the_field_a_file_would():
    names = np.array(["Ni+", "o1", "Ni+"])
    pairs = {("Ni+", "Ni+"): ("DPD", 25, 1.0, 4.5), ("o1", "Ni+"): ["lj", "0.5", np.float64(2.0)]}
    field = single_bead_field(names, np.array([2.0, 3.0, 2.0]), np.array([1.0, -2.0, 1.0]), pairs, "kJ")
    text = """
units kJ
molecular types 2
Ni+
nummols 2
atoms 1
Ni+ 2.0 1.0
finish
o1
nummols 1
atoms 1
o1 3.0 -2.0
finish
vdw 2
Ni+ Ni+ dpd 25 1 4.5
o1 Ni+ lj 0.5 2
close
"""
    assert field == parse_field(text)


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        ({"AB": ("dpd", 25.0, 1.0)}, "pairs: 'AB': the key of a pair is a tuple of two species names"),
        ({("A",): ("dpd", 25.0, 1.0)}, "pairs: \"('A',)\": the key of a pair is a tuple of two species names"),
        ({("A", 1): ("dpd", 25.0, 1.0)}, "pairs: \"('A', 1)\": the key of a pair is a tuple of two species names"),
        ({("A", "B"): ("dpd", 1, 1), ("B", "A"): ("dpd", 2, 1)}, "pairs: 'B A': this pair is given twice"),
        ({("A", "B"): "dpd"}, "pairs: 'A B': expected a law's key and its numbers, as in ('dpd', 25.0, 1.0)"),
        ({("A", "B"): (25.0, 1.0)}, "pairs: 'A B': expected a law's key and its numbers, as in ('dpd', 25.0, 1.0)"),
        ({("A", "B"): ()}, "pairs: 'A B': expected a law's key and its numbers, as in ('dpd', 25.0, 1.0)"),
        (
            {("A", "B"): ("dpd", "x", 1.0)},
            "pairs: 'A B': after the key 'dpd' only numbers can follow, not ('x', 1.0)",
        ),
    ],
)
def test_pairs_that_are_refused(pairs, message):
    with pytest.raises(InputError) as caught:
        pair_lines(pairs)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("names", "masses", "charges", "message"),
    [
        (
            ["A", "A"],
            [1.0, 2.0],
            [0.0, 0.0],
            "atoms: 'A': beads of one species differ in their mass: 1 and 2; give them names of their own",
        ),
        (
            ["A", "A"],
            [1.0, 1.0],
            [0.5, -0.5],
            "atoms: 'A': beads of one species differ in their charge: 0.5 and -0.5; give them names of their own",
        ),
        (["A b"], [1.0], [0.0], "atoms: 'A b': a species name has 1 to 8 characters and no blanks"),
        (["ABCDEFGHI"], [1.0], [0.0], "atoms: 'ABCDEFGHI': a species name has 1 to 8 characters and no blanks"),
        ([""], [1.0], [0.0], "atoms: '': a species name has 1 to 8 characters and no blanks"),
    ],
)
def test_beads_that_are_refused(names, masses, charges, message):
    with pytest.raises(InputError) as caught:
        single_bead_field(np.array(names), np.array(masses), np.array(charges), {}, "kj", names_from="atoms")
    assert str(caught.value) == message


def test_an_unknown_unit_is_refused():
    with pytest.raises(InputError, match=r"^units: 'hartree': is no energy unit; FIELD knows eV"):
        single_bead_field(np.array(["A"]), np.ones(1), np.zeros(1), {}, "hartree")
