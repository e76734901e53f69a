"""STATIS: layout to the column, both forms read back, by us and by dlpoly-py."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from ruamel.yaml import YAML

from pydlpoly.errors import InputError
from pydlpoly.formats.statis import (
    STATISTICS_NAMES,
    StatisticsRecord,
    StatisticsWriter,
    read_statistics,
)

with warnings.catch_warnings():  # dlpoly-py asks for NumPy's version in a way that is deprecated
    warnings.simplefilter("ignore", DeprecationWarning)
    from dlpoly.statis import Statis

SPECIES = ("W", "HEAD")


def a_record(step: int) -> StatisticsRecord:
    stress = np.array([[1.5, 0.25, -0.5], [0.25, 2.5, 0.75], [-0.5, 0.75, 3.5]]) + step
    return StatisticsRecord(
        step=step,
        time=0.01 * step,
        extended_energy=7639.491 + step,
        temperature=1.228947,
        configurational_energy=6719.863,
        short_range_energy=6719.863,
        virial=-20365.54,
        volume=1000.0,
        cell_alpha=90.0,
        pressure=1.212993,
        conserved_term=-3.25,
        stress=stress,
        square_displacements=(0.125, 4.5e-7),
    )


def write(path: Path, steps: range, **options: object) -> None:
    with StatisticsWriter(path, "soft 'beads'", "kJ/mol", SPECIES, **options) as writer:  # type: ignore[arg-type]
        for step in steps:
            writer.write(a_record(step))


def test_the_names_are_dl_poly_s_37_columns_in_order() -> None:
    assert [q.index for q in STATISTICS_NAMES] == list(range(1, 38))
    assert len({q.name for q in STATISTICS_NAMES}) == 37
    places = {q.name: q.index for q in STATISTICS_NAMES}
    assert (places["temperature"], places["enthalpy"], places["virial"], places["volume"]) == (2, 10, 12, 19)
    assert (places["pressure"], places["conserved_term"], places["stress_xx"], places["stress_zz"]) == (27, 28, 29, 37)


def test_the_layout_is_dl_poly_s(tmp_path: Path) -> None:
    write(tmp_path / "STATIS", range(20, 21))
    lines = (tmp_path / "STATIS").read_text().split("\n")
    assert lines[:3] == ["title: 'soft ''beads'''", "energy unitS: kJ/mol", "        20  2.000000E-01        39"]
    assert lines[3] == "  7.659491E+03  1.228947E+00  6.719863E+03  6.719863E+03  0.000000E+00"
    assert [len(line) for line in lines[3:10]] == [70] * 7
    assert lines[10] == "  2.075000E+01  2.350000E+01  1.250000E-01  4.500000E-07"
    assert len(lines) == 12
    assert lines[11] == ""


@pytest.mark.parametrize("yaml", [False, True])
def test_what_is_written_is_read_back_by_name(tmp_path: Path, yaml: bool) -> None:
    write(tmp_path / "STATIS", range(0, 60, 20), yaml=yaml)
    table = read_statistics(tmp_path / "STATIS", species=SPECIES)
    assert (table.title, table.energy_label, len(table), table.warnings) == ("soft 'beads'", "kJ/mol", 3, ())
    np.testing.assert_array_equal(table.step, [0, 20, 40])
    np.testing.assert_allclose(table.time, [0.0, 0.2, 0.4])
    assert table.columns == (*(q.name for q in STATISTICS_NAMES), "msd_W", "msd_HEAD")
    np.testing.assert_array_equal(table["extended_energy"], [7639.491, 7659.491, 7679.491])
    np.testing.assert_array_equal(table["pressure"], [1.212993] * 3)
    np.testing.assert_array_equal(table["conserved_term"], [-3.25] * 3)
    np.testing.assert_array_equal(table.stress[1], a_record(20).stress)
    np.testing.assert_array_equal(table["msd_HEAD"], [4.5e-7] * 3)
    with pytest.raises(KeyError, match="did you mean pressure"):
        table["presure"]


def test_dlpoly_py_reads_the_classic_file(tmp_path: Path) -> None:
    write(tmp_path / "STATIS", range(0, 60, 20))
    judge = Statis(str(tmp_path / "STATIS"))
    assert (judge.rows, judge.columns) == (3, 41)
    np.testing.assert_allclose(judge.data[2, :5], [40, 0.4, 39, 7679.491, 1.228947])
    np.testing.assert_allclose(judge.data[2, 3:], a_record(40).values(), rtol=1e-6)
    assert judge.labels[3 + 26] == "6-2 Pressure"
    assert judge.data[0, 3 + 26] == 1.212993


def test_the_yaml_file_is_valid_yaml_1_2_and_dlpoly_py_reads_it(tmp_path: Path) -> None:
    write(tmp_path / "STATIS", range(0, 40, 20), yaml=True)
    content = YAML(typ="safe").load((tmp_path / "STATIS").read_text(encoding="utf-8"))
    assert content["title"] == "soft 'beads'"
    assert content["energy unitS"] == "kJ/mol"
    labels = content["labels"][0]
    assert labels[:3] == ["step", "time", "Total Extended System Energy"]
    assert labels[-2:] == ["amsd W", "amsd HEAD"]
    row = content["timesteps"][1]
    assert len(row) == len(labels) == 41
    assert (row[0], row[1], row[2]) == (20, 0.2, 7659.491)
    assert all(isinstance(number, int | float) for number in row)
    judge = Statis(str(tmp_path / "STATIS"))
    assert judge.is_yaml
    assert judge.data[1, labels.index("Pressure")] == 1.212993


def test_not_a_number_and_infinity_stay_valid_yaml(tmp_path: Path) -> None:
    with StatisticsWriter(tmp_path / "STATIS", "t", "eV", (), yaml=True) as writer:
        writer.write(StatisticsRecord(1, 0.5, temperature=float("nan"), enthalpy=float("-inf"), virial=float("inf")))
    row = YAML(typ="safe").load((tmp_path / "STATIS").read_text(encoding="utf-8"))["timesteps"][0]
    assert np.isnan(row[3])
    assert (row[11], row[13]) == (float("-inf"), float("inf"))
    table = read_statistics(tmp_path / "STATIS")
    assert np.isnan(table["temperature"][0])
    assert table["virial"][0] == float("inf")


@pytest.mark.parametrize("yaml", [False, True])
@pytest.mark.parametrize("lost", [1, 5, 20, 100, 400])
def test_a_torn_record_is_reported_and_cut_on_append(tmp_path: Path, yaml: bool, lost: int) -> None:
    path = tmp_path / "STATIS"
    write(path, range(0, 60, 20), yaml=yaml)
    whole = path.read_bytes()
    path.write_bytes(whole[:-lost])
    if lost > 1:
        torn = read_statistics(path, species=SPECIES)
        np.testing.assert_array_equal(torn.step, [0, 20])
        assert torn.warnings == ("the last record is cut short and was left out",)
    write(path, range(40, 60, 20), yaml=yaml, append=True)
    assert path.read_bytes() == whole


@pytest.mark.parametrize("yaml", [False, True])
def test_continuing_from_an_older_checkpoint_leaves_no_step_twice(tmp_path: Path, yaml: bool) -> None:
    write(tmp_path / "ONE", range(0, 100, 20), yaml=yaml)
    write(tmp_path / "TWO", range(0, 80, 20), yaml=yaml)
    write(tmp_path / "TWO", range(40, 100, 20), yaml=yaml, append=True, keep_until=20)
    assert (tmp_path / "ONE").read_bytes() == (tmp_path / "TWO").read_bytes()


def test_appending_to_another_form_or_another_system_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "STATIS", range(1))
    with pytest.raises(InputError, match="one of the files is YAML"):
        StatisticsWriter(tmp_path / "STATIS", "t", "eV", SPECIES, yaml=True, append=True)
    with pytest.raises(InputError, match="its records do not hold 38 values"):
        StatisticsWriter(tmp_path / "STATIS", "t", "eV", ("W",), append=True)
    with (
        StatisticsWriter(tmp_path / "OTHER", "t", "eV", ("W",)) as writer,
        pytest.raises(ValueError, match="2 displacements for 1 species"),
    ):
        writer.write(a_record(0))


def older_file(body: str) -> str:
    return "DL_POLY Classic run\n ENERGY UNITS=KILOJOULES/MOL\n" + body


def test_plain_header_lines_and_foreign_numbers_are_read(tmp_path: Path) -> None:
    path = tmp_path / "STATIS"
    path.write_text(older_file("  10  0.1  3\n 1.0d+2 -1.5-100 ******\n\n  20  0.2  3\n 1 2 3"))
    table = read_statistics(path)
    assert (table.title, table.energy_label) == ("DL_POLY Classic run", "ENERGY UNITS=KILOJOULES/MOL")
    assert table.columns == ("extended_energy", "temperature", "configurational_energy")
    np.testing.assert_array_equal(table["temperature"][:1], [-1.5e-100])
    assert np.isnan(table["configurational_energy"][0])


def test_columns_that_only_the_caller_can_name(tmp_path: Path) -> None:
    numbers = "\n".join(" 1.0" for _ in range(50))
    (tmp_path / "STATIS").write_text(older_file(f" 1 0.1 50\n{numbers}\n"))
    assert read_statistics(tmp_path / "STATIS").columns[36:39] == ("stress_zz", "column_38", "column_39")
    named = read_statistics(tmp_path / "STATIS", species=("A", "B", "C"))
    assert named.columns[37:] == (
        *("msd_A", "msd_B", "msd_C"),
        *(f"cell_{v}{c}" for v in "abc" for c in "xyz"),
        "pressure_volume",
    )
    with pytest.raises(InputError, match="its records hold 50 values; with 2 species"):
        read_statistics(tmp_path / "STATIS", species=("A", "B"))


def test_the_order_of_dl_poly_classic(tmp_path: Path) -> None:
    numbers = "\n".join(f" {index}.0" for index in range(1, 40))
    (tmp_path / "STATIS").write_text(older_file(f" 1 0.1 39\n{numbers}\n"))
    table = read_statistics(tmp_path / "STATIS", species=("A", "B"), classic=True)
    assert (table["pressure"][0], table["msd_A"][0], table["msd_B"][0], table["column_39"][0]) == (27, 28, 29, 39)
    np.testing.assert_array_equal(table.stress[0], np.arange(30.0, 39.0).reshape(3, 3))
    assert read_statistics(tmp_path / "STATIS", classic=True).columns[26:28] == ("pressure", "column_28")
    with pytest.raises(InputError, match="Classic writes at least 40"):
        read_statistics(tmp_path / "STATIS", species=("A", "B", "C", "D"), classic=True)


def test_dl_poly_s_own_yaml_quirks_are_understood(tmp_path: Path) -> None:
    labels = ", ".join(["step", "time", *(q.label for q in STATISTICS_NAMES), "amsd Na"])
    cell = "cell A1, cell A2, cell A3, cell B1, cell B2, cell B3, cell C1, cell C2, cell C3pV"
    row = ", ".join(["7", "0.7", *("2.5" for _ in range(37)), "0.5", *("1.0" for _ in range(9)), "9.0"])
    text = f"%YAML 1.2\n---\ntitle: 'x'\nenergy unitS: eV\nlabels: \n  - [ {labels}, {cell}]\ntimesteps:\n  - [{row}]\n"
    (tmp_path / "STATIS").write_text(text, encoding="utf-8")
    table = read_statistics(tmp_path / "STATIS")
    assert table["msd_Na"][0] == 0.5
    assert table["pressure_volume"][0] == 9.0
    assert table["cell_gamma"][0] == 2.5


@pytest.mark.parametrize(
    ("body", "line", "message"),
    [
        ("  10 0.1 2\n 1.0 x2\n", 4, "'x2': expected a number"),
        (" what is this\n", 3, "not a STATIS file"),
        ("  10 0.1 2\n 1.0 2.0\n 20 0.2 2\n 1.0\n 30 0.3 2\n 1.0 2.0\n 1.0\n", 7, "an earlier record is cut short"),
    ],
)
def test_damage_is_refused_with_its_place(tmp_path: Path, body: str, line: int, message: str) -> None:
    (tmp_path / "STATIS").write_text(older_file(body))
    with pytest.raises(InputError, match=message) as caught:
        read_statistics(tmp_path / "STATIS")
    assert caught.value.line == line


def test_a_file_with_only_its_header_is_an_empty_table(tmp_path: Path) -> None:
    write(tmp_path / "STATIS", range(0))
    assert len(read_statistics(tmp_path / "STATIS")) == 0
    write(tmp_path / "YAML", range(0), yaml=True)
    assert len(read_statistics(tmp_path / "YAML")) == 0
