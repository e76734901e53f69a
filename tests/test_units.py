"""Units: DL_POLY's constants to the digit, the energy units of FIELD, and the unit words of CONTROL."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from pydlpoly.errors import InputError
from pydlpoly.units import (
    BOLTZMANN,
    COULOMB_CONSTANT,
    DIMENSIONS,
    ELECTRIC_FIELD_UNIT,
    ENERGY_UNITS,
    KATM_PER_INTERNAL_PRESSURE,
    MAGNETIC_FIELD_UNIT,
    TENSION_IN_DYN_PER_CM,
    convert,
    energy_unit,
    parse_unit,
    steps_to_time,
    time_to_steps,
    unit_warning,
)


def test_constants_are_dl_polys_to_the_last_digit() -> None:
    assert BOLTZMANN == 0.831451115
    assert COULOMB_CONSTANT == 138935.4835
    assert KATM_PER_INTERNAL_PRESSURE == 0.163882576
    assert TENSION_IN_DYN_PER_CM == 1.6605402
    assert pytest.approx(9635.42, abs=0.01) == ELECTRIC_FIELD_UNIT
    assert pytest.approx(9.63542e-5, rel=1e-6) == MAGNETIC_FIELD_UNIT
    factors = {name: unit.factor for name, unit in ENERGY_UNITS.items()}
    assert factors == {"ev": 9648.530821, "kcal": 418.4, "kj": 100.0, "k": 0.831451115, "internal": 1.0, "dpd": 1.0}


@pytest.mark.parametrize(
    ("word", "name"),
    [
        *[("eV", "ev"), ("ev", "ev"), ("kcal", "kcal"), ("KCAL/mol", "kcal"), ("kJ", "kj"), ("kJ/mol", "kj")],
        *[("K", "k"), ("kelvin", "k"), ("kT", "k"), ("kb", "k"), ("internal", "internal"), ("", "internal")],
        *[("dpd", "dpd"), ("DPD", "dpd")],
    ],
)
def test_words_of_field_are_known_by_their_leading_letters(word: str, name: str) -> None:
    assert energy_unit(word).name == name


def test_another_word_of_field_is_refused_by_name() -> None:
    with pytest.raises(InputError) as caught:
        energy_unit("intrenal", path="FIELD", line=2)
    expected = (
        "FIELD:2: 'intrenal': is no energy unit; FIELD knows eV, kcal, kJ, K, internal and dpd; did you mean internal?"
    )
    assert str(caught.value) == expected


def test_reduced_units_report_without_boltzmann_and_katm() -> None:
    dpd, kelvin = energy_unit("dpd"), energy_unit("K")
    assert (dpd.reduced, dpd.boltzmann, dpd.pressure_factor, dpd.tension_factor) == (True, 1.0, 1.0, 1.0)
    assert (dpd.temperature_label, dpd.pressure_label) == ("", "")
    assert (kelvin.reduced, kelvin.boltzmann, kelvin.pressure_factor) == (False, 0.831451115, 0.163882576)
    assert (kelvin.temperature_label, kelvin.pressure_label, kelvin.label) == ("K", "katm", "K")


@pytest.mark.parametrize("name", ["units-K", "units-eV", "units-kJ", "units-kcal"])
def test_factors_agree_with_runs_of_dl_poly(shared: Path, name: str) -> None:
    """The kinetic energy of 297 momenta and the pressure from the virial are what DL_POLY printed."""
    row = json.loads((shared / "golden" / name / "expected.json").read_text())["statis"]
    unit = energy_unit(name.partition("-")[2])
    kinetic = (row["engcns"] - row["engcfg"]) * unit.factor
    assert kinetic == pytest.approx(0.5 * 297 * unit.boltzmann * row["temp"], rel=2e-6)
    internal_pressure = (2.0 * kinetic - row["vir"] * unit.factor) / (3.0 * row["volume"])
    assert internal_pressure * unit.pressure_factor == pytest.approx(row["press"], rel=2e-6)


@pytest.mark.parametrize(
    ("value", "unit", "dimension", "internal"),
    [
        (1.0, "internal_t", "time", 1.0),
        (2.0, "ps", "time", 2.0),
        (2.0, "fs", "time", 0.002),
        (1.0, "hr", "time", 3.6e15),
        (1.0, "min", "time", 6e13),  # a minute, not milli-inches
        (1.0, "dpd_t", "time", 1.0),
        (1.5, "nm", "length", 15.0),
        (1.0, "ANG", "length", 1.0),
        (1.0, "bohr", "length", 0.52918),
        (1.0, "in", "length", 2.54e8),
        (3.0, "nm^-1", "inverse length", 0.3),
        (1.0, "1/ang", "inverse length", 1.0),
        (1.0, "e.V", "energy", 9648.533367742135),
        (1.0, "ke.V", "energy", 9648533.367742135),
        (1.0, "kJ/mol", "energy", 100.0),
        (1.0, "kcal/mol", "energy", 418.42),
        (2.0, "k_B.K", "energy", 1.66290223),
        (1.0, "dpd_e", "energy", 1.0),
        (1.0, "ha", "energy", 262549.96),
        (1.0, "dpd_temp", "temperature", 1.2027165301233615),
        (300.0, "K", "temperature", 300.0),
        (1.0, "katm", "pressure", 1000.0 / 163.882576),
        (1.0, "GPa", "pressure", 60.229552894949),
        (1.0, "Pa", "pressure", 6.0229552894949e-8),  # a pascal, not pico-amperes
        (1.0, "N/m", "tension", 602.29552894949),
        (1.0, "dyn/cm", "tension", 0.60229552894949),
        (4.5, "Da/ps", "drag", 4.5),
        (4.5, "dpd_m/dpd_t", "drag", 4.5),
        (1.0, "m/s", "velocity", 0.01),
        (1.0, "ps^-1", "rate", 1.0),
        (50.0, "%", "number", 0.5),
        (50.0, "", "number", 50.0),
        (1.0, "60.s", "time", 6e13),  # a bare number is a factor
        (1.0, "m.s^-2.Da", "force", 1e10 / 1e24),
    ],
)
def test_values_in_internal_units(value: float, unit: str, dimension: str, internal: float) -> None:
    assert convert(value, unit, dimension) == pytest.approx(internal, rel=1e-7)


def test_internal_and_dpd_units_do_not_round() -> None:
    for unit, dimension in (("ps", "time"), ("ang", "length"), ("dpd_e", "energy"), ("Da/ps", "drag")):
        assert convert(0.1234567890123456, unit, dimension) == 0.1234567890123456


def test_every_dimension_names_units_that_have_it() -> None:
    for dimension, (target, examples) in DIMENSIONS.items():
        assert convert(1.0, target, dimension, timestep=1.0) == 1.0
        for example in examples.split(", "):
            unit = "" if example == "none" else example
            assert convert(1.0, unit, dimension, timestep=0.5) > 0.0, (dimension, example)


def test_temp_is_the_temperature_of_the_run() -> None:
    assert convert(1000.0, "k_b.temp/ang", "force", temperature=300.0) == pytest.approx(0.831451115 * 3e5)
    assert convert(1000.0, "k_b.temp/ang", "force") == pytest.approx(831.451115)  # 1 K, as DL_POLY has it


def test_steps_and_times() -> None:
    assert convert(100.0, "steps", "time", timestep=0.02) == 2.0
    assert convert(100.0, "steps", "steps", timestep=0.02) == 100.0
    assert convert(10.0, "ps", "steps", timestep=0.02) == 500.0
    assert [time_to_steps(t, 0.5) for t in (0.0, 0.2, 0.25, 0.7, 0.75, -0.25, -0.2)] == [0, 0, 1, 1, 2, -1, 0]
    assert time_to_steps(0.3, 0.1) == 3
    assert steps_to_time(300, 0.01) == 3.0


@pytest.mark.parametrize(
    ("unit", "dimension", "message"),
    [
        ("K", "length", "'K': is no unit of length; examples: ang, nm, internal_l, dpd_l"),
        ("", "energy", "a unit of energy is needed; examples: kJ/mol, kcal/mol, e.V, k_b.K, dpd_e"),
        ("K/mol", "temperature", "'K/mol': is no unit of temperature; examples: K, dpd_temp"),
        ("K.mol", "temperature", "'K.mol': is no unit of temperature; examples: K, dpd_temp"),
        ("steps", "time", "'steps': steps can be converted only with a timestep above 0"),
        ("ps", "steps", "'ps': steps can be converted only with a timestep above 0"),
        ("eV", "energy", "'eV': is no unit word; the electron-volt is e.V, with a prefix ke.V"),
        ("keV", "energy", "'keV': is no unit word; the electron-volt is e.V, with a prefix ke.V"),
        ("FS", "time", "'FS': is no unit word; did you mean fs? (prefixes are case-sensitive)"),
        ("gpa", "pressure", "'gpa': is no unit word; did you mean Gpa? (prefixes are case-sensitive)"),
        ("angstrm", "length", "'angstrm': is no unit word; did you mean atm, ang?"),
        ("ang//ps", "velocity", "'ang//ps': is no unit: write words joined by '.' and '/', each with an optional whole "
         "power such as ^-1"),
        ("ang^x", "length", "'ang^x': is no unit: write words joined by '.' and '/', each with an optional whole power "
         "such as ^-1"),
        ("ang^12", "length", "'ang^12': has a power beyond 9"),
        ("0.ang", "length", "'0': is no unit word"),
        ("Ymol^9.ang", "length", "'Ymol^9.ang': is a unit beyond the range of numbers"),
    ],
)  # fmt: skip
def test_units_that_are_refused(unit: str, dimension: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        convert(1.0, unit, dimension)
    assert str(caught.value) == message


def test_legal_but_hardly_meant_prefixes_are_noticed() -> None:
    assert convert(1.0, "PS", "time") == pytest.approx(1e27)
    expected = "'PS' is read as peta-s (factor 1e+15); if that is not meant, write ps"
    assert unit_warning("PS") == expected
    assert unit_warning("Da/PS") == expected
    for usual in ("ps", "fs", "nm", "MPa", "GPa", "katm", "steps", "m", "ang", "k_b.temp/ang", "", "Mohm", "PATM"):
        assert unit_warning(usual) is None, usual


def test_a_unit_knows_its_powers() -> None:
    unit = parse_unit("kJ/mol/nm^2")
    assert unit.powers == (1, 0, -2, 0, -1, 0, 0)
    assert math.isclose(unit.factor, 1.0, rel_tol=1e-12)
