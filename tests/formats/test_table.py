"""TABLE files: what they hold, their grid, and the exact message for each way they can be broken."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pydlpoly.errors import InputError, PydlpolyError
from pydlpoly.formats.field import parse_field
from pydlpoly.formats.records import PairTable
from pydlpoly.formats.table import parse_table, read_table, write_table

FIELD = parse_field(
    "t\nunits kJ\nmolecules 1\nM\nnummols 1\natoms 3\nA 1 0\nB 1 0\nC 1 0\nfinish\n"
    "vdw 3\nA A tab\nA B tab 4.5\nA C lj 1 1\nclose\n"
)
GRID = "tables\n0.5 2.0 6\n"
ONE = "A A\n1 2 3 4\n5 6\n-1 -2d0 -3. -.4e1\n-5 -6\n"
TWO = "B A 0.0 0.0\n10 20 30 40\n50 60\n1 1 1 1\n1 1\n"


def test_tables_come_in_the_order_of_field_and_keep_their_numbers() -> None:
    first, second = parse_table(GRID + TWO + ONE, FIELD)
    assert (first.species, first.spacing, first.cutoff, first.line) == (("A", "A"), 0.5, 2.0, 8)
    assert first.energy.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert first.virial.tolist() == [-1.0, -2.0, -3.0, -4.0, -5.0, -6.0]
    assert (second.species, second.line) == (("B", "A"), 3)
    assert second.energy.tolist() == [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]


def test_blank_lines_comments_and_fewer_numbers_a_line() -> None:
    text = "t\n\n# grid\n0.5 2.0 6 remark\nA A\n1 2 3\n\n4 5 6\n-1\n-2 -3 -4 -5 -6\n" + TWO
    assert parse_table(text, FIELD)[0].virial.tolist() == [-1.0, -2.0, -3.0, -4.0, -5.0, -6.0]


def test_field_without_tables_needs_none() -> None:
    assert parse_table(GRID, replace(FIELD, pairs=FIELD.pairs[2:])) == ()


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the file cannot be read"):
        read_table(tmp_path / "TABLE", FIELD)


def test_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "TABLE"
    path.write_text(GRID + ONE + TWO)
    assert [t.path for t in read_table(path, FIELD)] == [str(path)] * 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "TABLE:1: the file ends here; expected the grid: spacing, cutoff and number of points"),
        ("t\n0.5 2.0\n", "TABLE:2: the line is too short; expected the grid: spacing, cutoff and number of points"),
        ("t\n0.0 2.0 6\n", "TABLE:2: '0.0': expected the grid's spacing, a positive number"),
        ("t\n0.5 -2 6\n", "TABLE:2: '-2': expected the grid's cutoff, a positive number"),
        ("t\n0.5 nan 6\n", "TABLE:2: 'nan': expected the grid's cutoff, a positive number"),
        ("t\n0.5 2.0 3\n", "TABLE:2: '3': expected the number of grid points, at least 4"),
        ("t\n0.5 2.0 6.5\n", "TABLE:2: '6.5': expected the number of grid points, at least 4"),
        (
            "t\n0.5 4.0 6\n",
            "TABLE:2: '4.0': 6 points of spacing 0.5 end at 3, before the cutoff; expected a grid that reaches it",
        ),
        (
            GRID + ONE,
            "TABLE:7: the file ends here; expected the table of A B, which FIELD declares tab",
        ),
        (GRID + ONE + ONE, "TABLE:8: the table of A A is already given on line 3"),
        (GRID + ONE + "A C\n", "TABLE:8: FIELD does not declare the pair A C tab; it declares A A, A B"),
        (GRID + ONE + "A a\n", "TABLE:8: 'a': unknown species; did you mean A?"),
        (GRID + ONE + "A\n", "TABLE:8: 'A': expected two species, which head the next table"),
        (GRID + "A A\n1 2 3 4\n5 6\n-1 -2\n", "TABLE:6: the file ends here; expected value 3 of 6 of -r dU/dr of A A "
         "(table on line 3)"),
        (GRID + "A A\n1 2 3 4\n5 6 7\n", "TABLE:5: '7': U of A A has 6 values on 2 lines, but the line goes on; "
         "expected its end"),
        (GRID + "A A\n1 2 3 4\n5 6\n1 2 3 4\n5 6\n7 8\n", "TABLE:8: '7': expected two species, which head the next "
         "table (the numbers before make up the 6 points of line 2)"),
        (GRID + "A A\n1 2 3 4\n5 inf\n", "TABLE:5: 'inf': expected value 6 of 6 of U of A A, a finite number"),
        (GRID + "A A\n1 2 3 4\nB A\n", "TABLE:5: 'B': expected value 5 of 6 of U of A A, a finite number"),
    ],
)  # fmt: skip
def test_broken_table_gets_this_message(text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_table(text, FIELD)
    assert str(caught.value) == message


finite = st.floats(allow_nan=False, allow_infinity=False)


@settings(max_examples=60, deadline=None)
@given(st.data(), st.integers(4, 13), st.floats(1e-3, 10.0))
def test_written_tables_read_back_exactly(data: st.DataObject, points: int, spacing: float) -> None:
    def column() -> np.ndarray:
        return np.array(data.draw(st.lists(finite, min_size=points, max_size=points)))

    tables = [PairTable(("A", b), spacing, spacing * (points - 1), column(), column()) for b in "AB"]
    read = parse_table(write_table(tables, "a title"), FIELD)
    for table, again in zip(tables, read, strict=True):
        assert (again.species, again.spacing, again.cutoff) == (table.species, table.spacing, table.cutoff)
        np.testing.assert_array_equal(again.energy, table.energy)
        np.testing.assert_array_equal(again.virial, table.virial)


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_damaged_tables_raise_nothing_else(data: st.DataObject) -> None:
    text = GRID + ONE + TWO
    cut = data.draw(st.integers(0, len(text)))
    length = data.draw(st.integers(0, 5))
    inserted = data.draw(st.text(alphabet="0123456789.-+eEdDAB \n\t/#naif", max_size=8))
    with suppress(PydlpolyError):
        parse_table(text[:cut] + inserted + text[cut + length :], FIELD)


def test_what_could_not_be_read_back_is_not_written() -> None:
    good = PairTable(("A", "A"), 0.5, 2.0, np.ones(6), np.ones(6))
    for tables, title, message in [
        ([], "", "at least one pair"),
        ([good], "a\nb", "the title must be one line"),
        ([good, replace(good, spacing=0.4)], "", "another spacing or cutoff"),
        ([good, replace(good, energy=np.ones(5))], "", r"the energy of A A must have 6 values, not \(5,\)"),
        ([replace(good, virial=np.full(6, np.nan))], "", "the virial of A A has a number that is not finite"),
        ([replace(good, species=("A B", "A"))], "", "this species name cannot be written"),
    ]:
        with pytest.raises(InputError, match=message):
            write_table(tables, title)
