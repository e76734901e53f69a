"""DIAGNOSTICS: what numpy makes of it, drifts, restarts, kills, and files that are something else."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.diagnostics import COLUMNS, DiagnosticsWriter, read_diagnostics

UNITS = {"temperature": "K", "energy": "10 J/mol", "pressure": "katm"}
GIVEN = [column.name for column in COLUMNS if column.name not in ("step", "energy_drift", "momentum_drift")]


def record(step: int) -> dict[str, float]:
    numbers = np.random.default_rng(step).normal(size=len(GIVEN))
    return dict(zip(GIVEN, numbers.tolist(), strict=True))


def write(path: Path, steps: list[int], *, append: bool = False, keep_until: int | None = None) -> None:
    with DiagnosticsWriter(path, UNITS, append=append, keep_until=keep_until) as writer:
        for step in steps:
            writer.write(step, record(step))


def test_numpy_reads_it_and_so_does_the_reader(tmp_path: Path) -> None:
    write(tmp_path / "DIAGNOSTICS", [0, 5, 10])
    table, columns = np.loadtxt(tmp_path / "DIAGNOSTICS"), read_diagnostics(tmp_path / "DIAGNOSTICS")
    assert list(columns) == [column.name for column in COLUMNS]
    assert columns["step"].dtype == np.int64
    for k, name in enumerate(columns):
        np.testing.assert_array_equal(columns[name], table[:, k], err_msg=name)
    for name in GIVEN:
        np.testing.assert_allclose(columns[name], [record(step)[name] for step in (0, 5, 10)], rtol=1e-9)
    energies = np.array([record(step)["energy"] for step in (0, 5, 10)])
    np.testing.assert_array_equal(columns["energy"], energies)
    np.testing.assert_allclose(columns["energy_drift"], energies - energies[0], rtol=1e-9)
    momenta = np.column_stack([columns[f"momentum_{axis}"] for axis in "xyz"])
    np.testing.assert_allclose(columns["momentum_drift"], np.linalg.norm(momenta - momenta[0], axis=1), rtol=1e-9)


def test_header_names_columns_and_units(tmp_path: Path) -> None:
    write(tmp_path / "real", [0])
    head, line = (tmp_path / "real").read_text().splitlines()
    assert head.startswith("#")
    assert head.split()[:3] == ["#", "step", "time[ps]"]
    assert {"kinetic_temperature[K]", "energy[10_J/mol]", "laplacian[Da/ps^2]"} < set(head.split())
    assert len(head) == len(line)
    DiagnosticsWriter(tmp_path / "reduced").close()
    assert "[" not in (tmp_path / "reduced").read_text()
    assert all(len(column) == 0 for column in read_diagnostics(tmp_path / "reduced").values())


@pytest.mark.parametrize("tear", ["", "          99  1.0", "nonsense"])
def test_append_after_a_checkpoint(tmp_path: Path, tear: str) -> None:
    """Later lines and a torn one go; drifts are those from the first line of the file."""
    write(tmp_path / "whole", [0, 5, 10, 15])
    write(tmp_path / "parts", [0, 5, 10])
    with (tmp_path / "parts").open("a") as file:
        file.write(tear)
    write(tmp_path / "parts", [10, 15], append=True, keep_until=5)
    assert (tmp_path / "parts").read_bytes() == (tmp_path / "whole").read_bytes()


@pytest.mark.parametrize("content", ["", "#       st"])
def test_append_to_nothing_begins_anew(tmp_path: Path, content: str) -> None:
    write(tmp_path / "new", [5, 10])
    (tmp_path / "parts").write_text(content)
    write(tmp_path / "parts", [5, 10], append=True, keep_until=3)
    assert (tmp_path / "parts").read_bytes() == (tmp_path / "new").read_bytes()


def test_append_to_another_file_is_refused(tmp_path: Path) -> None:
    DiagnosticsWriter(tmp_path / "reduced").close()
    before = (tmp_path / "reduced").read_bytes()
    with pytest.raises(InputError, match="other columns or units"):
        DiagnosticsWriter(tmp_path / "reduced", UNITS, append=True)
    assert (tmp_path / "reduced").read_bytes() == before


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "does not name columns"),
        ("1 2 3\n", "does not name columns"),
        ("# a b\n1 2\n1\n", ":3: expected 2 numbers, found 1"),
        ("# a b\n1 x\n", ":2: expected numbers"),
    ],
)
def test_foreign_files(tmp_path: Path, content: str, message: str) -> None:
    (tmp_path / "DIAGNOSTICS").write_text(content)
    with pytest.raises(InputError, match=message):
        read_diagnostics(tmp_path / "DIAGNOSTICS")
    with pytest.raises(InputError, match="cannot be read"):
        read_diagnostics(tmp_path / "nowhere")


def test_what_is_not_a_number(tmp_path: Path) -> None:
    with DiagnosticsWriter(tmp_path / "DIAGNOSTICS") as writer:
        writer.write(0, {**record(0), "configurational_temperature": float("nan")})
    assert np.isnan(read_diagnostics(tmp_path / "DIAGNOSTICS")["configurational_temperature"][0])


PROGRAM = """
import sys
from pydlpoly.formats.diagnostics import COLUMNS, DiagnosticsWriter

writer = DiagnosticsWriter(sys.argv[1])
for step in range(10**7):
    writer.write(step, {column.name: float(step) for column in COLUMNS})
    if step == 100:
        print("begun", flush=True)
"""


def test_a_kill_leaves_whole_lines(tmp_path: Path) -> None:
    path = tmp_path / "DIAGNOSTICS"
    with subprocess.Popen([sys.executable, "-c", PROGRAM, str(path)], stdout=subprocess.PIPE, cwd=tmp_path) as program:
        assert program.stdout is not None
        program.stdout.readline()
        time.sleep(0.2)
        program.send_signal(signal.SIGKILL)
    assert path.read_bytes().endswith(b"\n")
    steps = read_diagnostics(path)["step"]
    assert len(steps) > 100
    assert (steps == np.arange(len(steps))).all()
