"""Finding the files of a run."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.config import read_config
from pydlpoly.formats.control import read_control
from pydlpoly.formats.field import read_field
from pydlpoly.scene import load


@pytest.fixture
def folder(tmp_path, make):
    case = make()
    (tmp_path / "CONTROL").write_text(case.control_text())
    (tmp_path / "FIELD").write_text(case.field_text())
    (tmp_path / "CONFIG").write_text(case.config_text())
    return tmp_path


def test_folder(folder):
    scene = load(folder)
    assert scene.bead_count == 6
    assert scene.title == "test"
    assert scene.sources == tuple(str(folder / name) for name in ("CONTROL", "FIELD", "CONFIG"))


def test_current_folder(folder, monkeypatch):
    monkeypatch.chdir(folder)
    assert load().sources == ("CONTROL", "FIELD", "CONFIG")


def test_control_alone_says_where_the_others_are(folder):
    assert load(control=folder / "CONTROL").bead_count == 6
    assert load(control=str(folder / "CONTROL")).bead_count == 6


def test_files_by_name(folder, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    for old, new in (("CONTROL", "a.control"), ("FIELD", "a.field"), ("CONFIG", "a.config")):
        (folder / old).rename(elsewhere / new)
    scene = load(elsewhere, control="a.control", field="a.field", config=elsewhere / "a.config")
    assert scene.sources == tuple(str(elsewhere / name) for name in ("a.control", "a.field", "a.config"))


def test_names_in_control_are_respected(folder, make):
    control = {"io_file_field": "water.field", "io_file_config": "start/water.config"}
    (folder / "CONTROL").write_text(make(control=control).control_text())
    (folder / "start").mkdir()
    (folder / "FIELD").rename(folder / "water.field")
    (folder / "CONFIG").rename(folder / "start" / "water.config")
    assert load(folder).sources[1:] == (str(folder / "water.field"), str(folder / "start" / "water.config"))


def test_records_in_place_of_files(folder):
    control, field, config = (
        read_control(folder / "CONTROL"),
        read_field(folder / "FIELD"),
        read_config(folder / "CONFIG"),
    )
    (folder / "FIELD").unlink()
    assert load(folder, field=field, config=config).bead_count == 6
    assert load(control=control, field=field).bead_count == 6


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("CONTROL", "expected the run's settings here (the argument control can name another)"),
        ("FIELD", "expected the force field here (io_file_field or the argument field can name another)"),
        ("CONFIG", "expected the start configuration here (io_file_config or the argument config can name another)"),
    ],
)
def test_missing_file(folder, name, text):
    (folder / name).unlink()
    with pytest.raises(InputError) as caught:
        load(folder)
    assert str(caught.value) == f"{folder / name}: there is no such file; {text}"
    (folder / name).mkdir()
    with pytest.raises(InputError) as caught:
        load(folder)
    assert str(caught.value) == f"{folder / name}: it is a folder; {text}"


def write_table(path, values):
    lines = [f"table\n0.01 {0.01 * len(values)} {len(values)}\nA B"]
    for block in (values, values):
        lines += [" ".join(f"{x:.8e}" for x in block[k : k + 4]) for k in range(0, len(block), 4)]
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("name", ["TABLE", "TABVDW", "my.table"])
def test_table_of_tabulated_pairs(folder, make, name):
    control = {"io_file_tabvdw": name} if name == "my.table" else {}
    case = make(control=control, vdw=("A A dpd 25.0 1.0 4.5", "A B tab 4.5", "B B dpd 25.0 1.0 4.5"))
    (folder / "CONTROL").write_text(case.control_text())
    (folder / "FIELD").write_text(case.field_text())
    values = np.linspace(2.0, 0.0, 100)
    write_table(folder / name, values)
    scene = load(folder)
    np.testing.assert_allclose(scene.pairs[1].table, [values, values], atol=1e-8)
    assert scene.sources[3] == str(folder / name)


def test_missing_table(folder, make):
    (folder / "FIELD").write_text(make(vdw=("A B tab 4.5",)).field_text())
    with pytest.raises(InputError) as caught:
        load(folder)
    text = "there is no such file; expected the table of the tab pairs here (io_file_tabvdw can name another)"
    assert str(caught.value) == f"{folder / 'TABVDW'}: {text}"


def test_indices_of_the_configuration(folder, make):
    case = make(positions=[(0.1 * k, 0, 0) for k in range(6)])
    lines = case.config_text().splitlines()
    swapped = [*lines[:5], lines[7], lines[8], lines[5], lines[6], *lines[9:]]
    (folder / "CONFIG").write_text("\n".join(swapped) + "\n")
    assert load(folder).beads.positions[:2, 0].tolist() == [0.0, 0.1]
    (folder / "CONTROL").write_text(make(control={"ignore_config_indices": "on"}).control_text())
    assert load(folder).beads.positions[:2, 0].tolist() == [0.1, 0.0]


def test_lenient_reading_turns_slips_into_warnings(folder, make):
    (folder / "FIELD").write_text(make().field_text().replace("close\n", ""))
    with pytest.raises(InputError):
        load(folder)
    assert any(note.kind == "warning" and "close" in note.text for note in load(folder, lenient=True).notes)


PAIR_CASES = ["pair-dpd", "pair-lj", "pair-wca", "pair-m126", "pair-zblb", "units-K", "pair-lj-shift"]


@pytest.mark.parametrize("case", [*PAIR_CASES, "run-soft-imcon3", "run-soft-frozen", "run-extern-oscshear"])
def test_golden_inputs_make_scenes(shared, case):
    scene = load(shared / "golden" / case)
    assert scene.dynamics.integrator == "nve"
    assert all(term.law is not None for term in scene.pairs)
    assert scene.bead_count == len(scene.beads.positions)
    assert [note for note in scene.notes if note.kind == "warning"] == []


@pytest.mark.parametrize(
    ("case", "degrees"), [("run-soft-imcon1", 1800), ("run-soft-frozen", 900), ("run-extern-gravity", 1800)]
)
def test_degrees_of_freedom_reproduce_the_judge_s_temperature(shared, case, degrees):
    # fixed_com off: the reference temperature at step 0 counts three momenta a mobile bead.
    scene = load(shared / "golden" / case)
    assert scene.degrees_of_freedom == degrees
