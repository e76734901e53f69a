"""New-style CONTROL: what real files look like, values in internal units, and the keyword table itself."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.control import effect_of, parse_control, read_control, value_in, write_control
from pydlpoly.formats.control_values import default_setting
from pydlpoly.formats.keywords import KEYWORDS, OPTION_SYNONYMS, SYNONYMS, lookup
from pydlpoly.formats.records import Control, Setting
from pydlpoly.units import DIMENSIONS

MODERN_DPD = """\
title DPD water, as the newest manual writes it
io_units_scheme dpd
ensemble nvt
ensemble_method dpd
ensemble_dpd_order mdvv      # Groot and Warren
ensemble_dpd_drag 4.5 dpd_m/dpd_t
temperature 1.0 dpd_temp
timestep 0.01 dpd_t
time_run 2000 steps
time_equilibration 1.0 dpd_t ! a time, not a number of steps
cutoff 1.0 dpd_l
vdw_method direct
VDW_MIX_METHOD Tang-Toennies
random_seed [ 2017 &
              2018 &
              2019 ]
print_frequency 100 steps
"""


def test_modern_dpd_input() -> None:
    control = parse_control(MODERN_DPD)
    assert (control.title, control.style, control.warnings) == ("DPD water, as the newest manual writes it", "new", ())
    assert control.get("ensemble_dpd_drag") == Setting("ensemble_dpd_drag", 4.5, "dpd_m/dpd_t")
    assert control.get("random_seed") == Setting("random_seed", (2017, 2018, 2019))
    assert control.get("vdw_mix_method") == Setting("vdw_mix_method", "tang-toennies")
    assert [s.line for s in control][:3] == [2, 3, 4]
    assert control.settings[-1].line == 17
    assert value_in(control, "temperature") == pytest.approx(1.2027165)
    assert (value_in(control, "timestep"), value_in(control, "cutoff")) == (0.01, 1.0)
    assert (value_in(control, "time_run"), value_in(control, "time_equilibration")) == (2000, 100)


def test_water_ndpd_from_the_inputs(shared: Path) -> None:
    path = shared / "inputs" / "dl_poly" / "water-ndpd" / "CONTROL"
    control = read_control(path)
    assert control.title == "DL_POLY_4 CONTROL DIRECTIVES"
    assert control.style == "new"
    values = {s.keyword: (s.value, s.unit) for s in control}
    assert values == {
        "random_seed": ((100, 200, 300), None),
        "temperature": (298.15, "K"),
        "vdw_cutoff": (13.8756, "ang"),
        "padding": (0.35, "ang"),
        "cutoff": (13.8756, "ang"),
        "subcell_threshold": (50.0, "%"),
        "ensemble": ("nvt", None),
        "ensemble_method": ("dpd", None),
        "ensemble_dpd_order": ("first", None),
        "time_run": (500000, "steps"),
        "time_equilibration": (400000, "steps"),
        "rescale_frequency": (5000, "steps"),
        "record_equilibration": (True, None),
        "stack_size": (50, "steps"),
        "stats_frequency": (10, "steps"),
        "print_frequency": (100, "steps"),
        "traj_calculate": (True, None),
        "traj_start": (400000, "steps"),
        "traj_interval": (100, "steps"),
        "traj_key": ("pos-vel", None),
    }
    text = "dpds1 is an old name; it is read as ensemble_method dpd with ensemble_dpd_order first"
    assert control.warnings == (f"{path}:29: {text}",)
    with pytest.raises(InputError, match=r"CONTROL does not give timestep \(length of a step\)"):
        value_in(control, "timestep")  # the file has none, and there is no default


def test_all_golden_files_read_and_survive_writing(shared: Path) -> None:
    paths = sorted((shared / "golden").glob("*/CONTROL"))
    assert len(paths) == 68
    for path in paths:
        control = read_control(path)
        assert control.title == path.parent.name
        assert control.warnings == ()
        assert value_in(control, "ensemble") == "nve"
        assert float(value_in(control, "timestep")) in (1e-13, 0.001, 0.002, 0.005, 0.01)  # type: ignore[arg-type]
        assert parse_control(write_control(control)) == control


def test_golden_ewald_settings(shared: Path) -> None:
    control = read_control(shared / "golden" / "coul-ewald-imcon3" / "CONTROL")
    assert value_in(control, "coul_method") == "spme"
    assert value_in(control, "spme_alpha") == 0.6
    assert control.get("spme_kvec") == Setting("spme_kvec", (14, 14, 14))
    assert value_in(control, "spme_nsplines") == 12


def test_writing_is_plain() -> None:
    control = Control(
        "water # 3",
        (Setting("timestep", 0.01, "ps"), Setting("time_run", 100, "steps"), Setting("random_seed", (2**64 - 1,)),
         Setting("fixed_com", False), Setting("pressure_tensor", (1.0, 2.0, 3.0, 0.0, 0.0, 0.0), "katm")),
    )  # fmt: skip
    assert write_control(control) == (
        "title water   3\n"
        "timestep 0.01 ps\n"
        "time_run 100 steps\n"
        "random_seed 18446744073709551615\n"
        "fixed_com off\n"
        "pressure_tensor [ 1.0 2.0 3.0 0.0 0.0 0.0 ] katm\n"
    )


@pytest.mark.parametrize("name", ["", "my#file", "my!file", "two\nlines", " padded"])
def test_texts_that_would_not_read_back_are_not_written(name: str) -> None:
    with pytest.raises(InputError, match="this text cannot be written into CONTROL"):
        write_control(Control("t", (Setting("io_file_field", name),)))


@pytest.mark.parametrize(
    ("word", "value", "warns"),
    [
        *[("on", True, False), ("ON", True, False), ("y", True, False), ("Y", True, False)],
        *[("off", False, False), ("n", False, False), ("no", False, False), ("False", False, False)],
        *[("yes", True, True), ("true", True, True), ("TRUE", True, True)],
    ],
)
def test_switches(word: str, value: bool, warns: bool) -> None:
    control = parse_control(f"title t\nfixed_com {word}\n")
    assert value_in(control, "fixed_com") is value
    expected = f"CONTROL:2: fixed_com: DL_POLY reads {word!r} as off; pydlpoly takes it as on; write on"
    assert control.warnings == ((expected,) if warns else ())


@pytest.mark.parametrize(
    ("word", "value"),
    [("1d-6", 1e-6), ("5.d-4", 5e-4), (".5", 0.5), ("1.", 1.0), ("10000.", 1e4), ("1.0117E+4", 10117.0), ("-1", -1.0),
     ("+.0001D0", 1e-4), ("1e5", 1e5)],
)  # fmt: skip
def test_numbers_in_fortran_forms(word: str, value: float) -> None:
    assert value_in(parse_control(f"title t\npadding {word} ang\n"), "padding") == value


@pytest.mark.parametrize("word", ["1e", "e5", "1,5", "0x10", "nan", "inf", "1_000", "--1", "١"])
def test_other_forms_are_no_numbers(word: str) -> None:
    with pytest.raises(InputError, match="a number is expected"):
        parse_control(f"title t\npadding {word} ang\n")


@pytest.mark.parametrize(
    ("line", "keyword", "value"),
    [
        ("subcelling_threshold_density 50.0", "subcell_threshold", 50.0),
        ("ewald_precision 1e-6", "spme_precision", 1e-6),
        ("ewald_kvec [ 1 2 3 ]", "spme_kvec", (1, 2, 3)),
        ("io_unit_scheme dpd", "io_units_scheme", "dpd"),
        ("vdw_mix_method tang-tonnies", "vdw_mix_method", "tang-toennies"),
        ("vdw_mix_method Tang-Toennies", "vdw_mix_method", "tang-toennies"),
        ("vdw_mix_method fender-hasley", "vdw_mix_method", "fender-halsey"),
        ("vdw_mix_method functional", "vdw_mix_method", "functional"),
        ("vdw_method ewald", "vdw_method", "spme"),
        ("coul_method ewald", "coul_method", "spme"),
        ("ensemble_method nose-hoover", "ensemble_method", "hoover"),
        ("ensemble_dpd_order 0", "ensemble_dpd_order", "zeroth"),
        ("ensemble_dpd_order 1", "ensemble_dpd_order", "first"),
        ("ensemble_dpd_order 2", "ensemble_dpd_order", "second"),
        ("random_seed 12345678901234567890", "random_seed", (12345678901234567890,)),
        ("random_seed [1 2 3]", "random_seed", (1, 2, 3)),
        ("correlation_blocks [ 5 ]", "correlation_blocks", (5,)),
        ("correlation_observable [v_x-v_x v_y-v_y]", "correlation_observable", "[v_x-v_x v_y-v_y]"),
        ("print_level 2.0", "print_level", 2),
        ("minimisation_tolerance 0.5", "minimisation_tolerance", 0.5),
        ("io_file_config start/my CONFIG", "io_file_config", "start/my CONFIG"),
    ],
)
def test_other_spellings(line: str, keyword: str, value: object) -> None:
    control = parse_control(f"title t\n{line}\n")
    assert [(s.keyword, s.value) for s in control] == [(keyword, value)]
    assert control.warnings == ()


def test_dpds2_is_second_order() -> None:
    control = parse_control("title t\nensemble_method DPDS2\n")
    assert [(s.keyword, s.value) for s in control] == [("ensemble_method", "dpd"), ("ensemble_dpd_order", "second")]


def test_peta_seconds_are_noticed() -> None:
    control = parse_control("title t\ntimestep 1 PS\n")
    text = "timestep: 'PS' is read as peta-s (factor 1e+15); if that is not meant, write ps"
    assert control.warnings == (f"CONTROL:2: {text}",)


def test_windows_line_ends_byte_order_marks_and_latin_letters(tmp_path: Path) -> None:
    path = tmp_path / "CONTROL"
    path.write_bytes(b"\xef\xbb\xbftitle t\r\ncutoff 2.0 ang\r\n")
    assert value_in(read_control(path), "cutoff") == 2.0
    path.write_bytes("title Größe\ncutoff 2.0 ang\n".encode("latin-1"))
    assert read_control(path).title == "Größe"


def test_comments_and_blank_lines_before_the_title() -> None:
    control = parse_control("# made by hand\n\n! more\n  TITLE  two  words # note\n\ncutoff 1 ang!\n")
    assert (control.title, value_in(control, "cutoff")) == ("two  words", 1.0)


# -- Values in internal units -----------------------------------------------------------------------------------------


def test_values_default_to_the_table() -> None:
    control = parse_control("title t\ntimestep 2 fs\n")
    assert value_in(control, "timestep") == 0.002
    assert value_in(control, "rdf_binsize") == 0.05
    assert value_in(control, "data_dump_frequency") == 1000
    assert value_in(control, "random_seed") == (1, 2, 3)
    assert value_in(control, "fixed_com") is True
    assert value_in(control, "io_file_output") == "OUTPUT"
    assert value_in(control, "ensemble_dpd_lambda") == 0.5
    assert value_in(control, "plumed_input") == ""
    with pytest.raises(InputError, match="CONTROL does not give rdf_binsize"):
        value_in(control, "rdf_binsize", default_from_table=False)


def test_steps_and_times_meet_the_timestep() -> None:
    control = parse_control("title t\ntimestep 2 fs\ntime_run 1 ns\ntime_job 1000 steps\ntime_equilibration 3.1 fs\n")
    assert value_in(control, "time_run") == 500000
    assert value_in(control, "time_run", timestep=0.001) == 1000000
    assert value_in(control, "time_job") == 2.0
    assert value_in(control, "time_equilibration") == 2  # 1.55 steps
    bare = parse_control("title t\ntime_run 1 ns\ntime_equilibration 5 steps\n")
    assert value_in(bare, "time_equilibration") == 5
    with pytest.raises(InputError) as caught:
        value_in(bare, "time_run")
    assert str(caught.value) == "CONTROL:2: 'ns': steps can be converted only with a timestep above 0"
    with pytest.raises(InputError) as caught:
        value_in(parse_control("title t\ntimestep 1 steps\n"), "timestep")
    assert str(caught.value) == "CONTROL:2: 'steps': a timestep cannot be given in steps"


def test_the_force_cap_is_in_units_of_the_runs_temperature() -> None:
    control = parse_control("title t\ntemperature 1.0 dpd_temp\nequilibration_force_cap 1000 k_b.temp/ang\n")
    assert value_in(control, "equilibration_force_cap") == pytest.approx(1000.0)
    cold = parse_control("title t\nequilibration_force_cap 1000 k_b.temp/ang\n")
    with pytest.raises(InputError) as caught:
        value_in(cold, "equilibration_force_cap")
    text = "equilibration_force_cap in this unit needs a temperature, which CONTROL does not give"
    assert str(caught.value) == f"CONTROL:2: 'k_b.temp/ang': {text}"


def test_vectors_are_converted_number_by_number() -> None:
    control = parse_control("title t\npressure_tensor [ 1 2 3 4 5 6 ] atm\n")
    expected = [n / 163.882576 for n in range(1, 7)]
    assert value_in(control, "pressure_tensor") == pytest.approx(expected)


def test_numbers_out_of_range_are_refused() -> None:
    control = parse_control("title t\ntimestep 1 fs\ntime_run 1e300 Ys\n")
    with pytest.raises(InputError, match="this number is out of range"):
        value_in(control, "time_run")


# -- The table --------------------------------------------------------------------------------------------------------


def test_every_row_is_complete() -> None:
    for keyword, row in KEYWORDS.items():
        assert keyword == keyword.lower()
        assert row.meaning, keyword
        assert row.dimension in (*DIMENSIONS, "any", "integers"), keyword
        for text in (row.effect, *row.option_effects.values()):
            kind, _, reason = text.partition(": ")
            assert kind in ("used", "ignored", "refused"), keyword
            assert bool(reason) == (kind != "used"), keyword
        assert (row.kind == "option") == bool(row.options), keyword
        assert set(row.option_effects) <= set(row.options), keyword
        assert row.required <= (row.default == ""), keyword
        default = default_setting(keyword)
        assert default is None or default.keyword == keyword
        assert default is None or effect_of(default).kind != "refused", keyword


def test_synonyms_lead_to_rows_and_hide_none() -> None:
    for word, keyword in SYNONYMS.items():
        assert keyword in KEYWORDS
        assert word not in KEYWORDS
        assert lookup(word.upper()) is KEYWORDS[keyword]
    for keyword, words in OPTION_SYNONYMS.items():
        assert set(words.values()) <= set(KEYWORDS[keyword].options)
        assert not set(words) & set(KEYWORDS[keyword].options)


def test_dl_polys_own_python_tools_know_no_other_keyword() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from dlpoly.new_control import NewControl
    assert [key for key in NewControl().keys if key != "title" and lookup(key) is None] == []


@pytest.mark.parametrize(
    ("line", "kind", "reason"),
    [
        ("timestep 1 fs", "used", ""),
        ("ensemble nve", "used", ""),
        ("ensemble npt", "used", ""),
        ("ensemble pmf", "refused", "the ensemble pmf"),
        ("ensemble_method mtk", "refused", "this barostat"),
        ("ensemble_method hoover", "used", ""),
        ("ensemble_method evans", "refused", "NVT by this thermostat"),
        ("ensemble_dpd_order mdvv", "used", ""),
        ("ensemble_dpd_order second", "used", ""),
        ("coul_method off", "used", ""),
        ("coul_method reaction_field", "used", ""),
        (
            "spme_kvec_spacing 0.1 ang^-1",
            "refused",
            "DL_POLY's manual and code mean different numbers by it; give spme_kvec",
        ),
        ("vdw_method spme", "refused", "pair laws by Ewald summation"),
        ("timestep_variable on", "refused", "a variable timestep"),
        ("timestep_variable off", "ignored", "it is switched off"),
        ("plumed on", "refused", "PLUMED"),
        ("nfold [ 2 1 1 ]", "used", ""),
        ("reset_temperature_interval 10 steps", "refused", "quenching to zero temperature"),
        ("reset_temperature_interval -1 steps", "ignored", "it is switched off"),
        ("minimisation_criterion force", "refused", "minimisation"),
        ("pseudo_thermostat_method direct", "refused", "a thermostat at the cell boundary"),
        ("density_variance 10 %", "ignored", "arrays grow as needed"),
        ("io_read_method mpiio", "ignored", "pydlpoly reads and writes files in one way only"),
        ("precision mixed", "used", ""),
    ],
)
def test_effects(line: str, kind: str, reason: str) -> None:
    (setting,) = parse_control(f"title t\n{line}\n").settings
    effect = effect_of(setting)
    assert (effect.kind, effect.reason) == (kind, reason)


def test_both_styles_write_the_same_settings() -> None:
    control = parse_control(MODERN_DPD)
    old = parse_control(write_control(replace(control, settings=tuple(s for s in control if s.keyword in (
        "ensemble", "ensemble_method", "ensemble_dpd_order", "ensemble_dpd_drag", "timestep", "time_run", "cutoff",
        "temperature", "vdw_method", "vdw_mix_method", "random_seed", "print_frequency")), style="old")))  # fmt: skip
    for keyword in ("temperature", "ensemble_dpd_drag", "timestep", "time_run", "cutoff", "vdw_mix_method"):
        assert value_in(old, keyword) == value_in(control, keyword), keyword
