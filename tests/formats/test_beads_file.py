"""BEADS files: exact round trips, what is refused and where, and bounded memory for a million beads."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.beads_file import parse_beads, read_beads, write_beads
from pydlpoly.formats.records import BeadTable


def awkward_numbers(count: int, seed: int) -> np.ndarray:
    """Numbers of all magnitudes that use every bit."""
    random = np.random.default_rng(seed)
    return random.random(count) * 10.0 ** random.integers(-300, 300, count)


def test_every_bit_comes_back(tmp_path: Path) -> None:
    columns = [awkward_numbers(50_001, seed) for seed in (1, 2, 3)]
    columns[1][:3] = 0.0, 5e-324, np.finfo(np.float64).max
    names = ("temperature", "concentration_salt", "concentration_2")
    write_beads(tmp_path / "BEADS", "warm  and\nsalty", names, columns)
    table = read_beads(tmp_path / "BEADS")
    assert (table.title, table.names, table.rows) == ("warm and salty", names, None)
    assert table.values.tobytes() == np.column_stack(columns).tobytes()
    write_beads(tmp_path / "AGAIN", table.title, table.names, list(table.values.T))
    assert (tmp_path / "AGAIN").read_bytes() == (tmp_path / "BEADS").read_bytes()
    assert read_beads(tmp_path / "AGAIN") == table


def test_beads_in_any_order_and_fortran_numbers() -> None:
    table = parse_beads("title\n3 temperature\n3 1d2\n1 .5\n2 1.5-1\n\n\n")
    assert table.values.tolist() == [[0.5], [0.15], [100.0]]
    assert [table.place_of(bead) for bead in range(3)] == [(1, 4), (2, 5), (3, 3)]
    assert parse_beads("title\r\n1 temperature\r\n1 2\r\n") == BeadTable(("temperature",), np.array([[2.0]]), "title")


def test_an_accent_in_the_title(tmp_path: Path) -> None:
    (tmp_path / "BEADS").write_bytes("W\xe4rme\n1 temperature\n1 2.0\n".encode("latin-1"))
    assert read_beads(tmp_path / "BEADS").title == "Wärme"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "BEADS:2: '': not a BEADS file: expected the number of beads and the names of the columns"),
        ("t\nA B\n", "BEADS:2: 'A B': not a BEADS file"),
        ("t\n0 temperature\n", "BEADS:2: '0 temperature': not a BEADS file"),
        ("t\n2\n", "BEADS:2: '2': there is no column"),
        ("t\n1 temperature 5\n1 1 1\n", "BEADS:2: '5': a number is no name of a column"),
        ("t\n1 a a\n1 1 1\n", "BEADS:2: 'a': this column is given twice"),
        ("t\n2 a\n1 1\n", "BEADS:3: the file ends after 1 of the 2 beads that line 2 says"),
        ("t\n1 a\n1 1\n2 1\n", "BEADS:4: line 2 says 1 beads, but there are more lines"),
        ("t\n2 a\n1 1\n\n2 1\n", "BEADS:4: blank line among the beads"),
        ("t\n2 a\n1 1\n2 1 1\n", "BEADS:4: expected a bead's index and 1 number, found 3 words"),
        ("t\n2 a b\n1 1 1\n2 1\n", "BEADS:4: expected a bead's index and 2 numbers, found 2 words"),
        ("t\n2 a\n1 1\n2 nan\n", "BEADS:4: 'nan': expected a finite number"),
        ("t\n2 a\n1 1\n2 1e999\n", "BEADS:4: '1e999': expected a finite number"),
        ("t\n2 a\n1 1\n2 hot\n", "BEADS:4: 'hot': expected a finite number"),
        ("t\n2 a\n1 1\n1.5 1\n", "BEADS:4: '1.5': expected a bead's index"),
        ("t\n2 a\n-1 1\n2 1\n", "BEADS:3: '-1': no bead has this index; expected 1 to 2 once each"),
        ("t\n2 a\n1 1\n3 1\n", "BEADS:4: '3': no bead has this index; expected 1 to 2 once each"),
        ("t\n3 a\n2 1\n1 1\n2 1\n", "BEADS:5: '2': this bead is also on line 3; expected 1 to 3 once each"),
    ],
)
def test_refusals(text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_beads(text)
    assert str(caught.value).startswith(message)


def test_files_that_cannot_be_had(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read: No such file"):
        read_beads(tmp_path / "BEADS")
    with pytest.raises(RunError, match="cannot be written"):
        write_beads(tmp_path / "nowhere" / "BEADS", "t", ["a"], [np.ones(1)])


@pytest.mark.parametrize(
    ("names", "columns"),
    [((), []), (("a",), [np.ones(2), np.ones(2)]), (("a b",), [np.ones(2)]), (("a",), [np.array([1.0, np.nan])]),
     (("a", "b"), [np.ones(2), np.ones(3)])],
)  # fmt: skip
def test_what_cannot_be_written(tmp_path: Path, names: tuple[str, ...], columns: list[np.ndarray]) -> None:
    with pytest.raises(ValueError, match=r"expected one column|must be words"):
        write_beads(tmp_path / "BEADS", "t", names, columns)
    assert not (tmp_path / "BEADS").exists()


_LARGE = """
import resource, sys
import numpy as np
from pydlpoly.formats.beads_file import read_beads, write_beads
count = 1_000_000
column = np.random.default_rng(1).random(count)
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
before = peak()
write_beads(sys.argv[1], "large", ["temperature", "concentration_a"], [column, column])
written = peak()
table = read_beads(sys.argv[1])
assert (table.values == column[:, None]).all()
print(written - before, peak() - written)
"""


def test_a_million_beads_take_little_memory(tmp_path: Path) -> None:
    """The table has 16 MB; the text, 55 MB, is never held as a whole."""
    command = [sys.executable, "-c", _LARGE, str(tmp_path / "BEADS")]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    writing, reading = (float(word) for word in done.stdout.split())
    assert (tmp_path / "BEADS").stat().st_size > 50e6
    assert writing < 40.0
    assert reading < 120.0  # chunks and their joined copy, indices and their order
