"""TABBND, TABANG, TABDIH, TABINV: what they hold, their grids, and the exact message for each way to break them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.bonded_table import (
    canonical_species,
    parse_bonded_tables,
    read_bonded_tables,
    wanted_tables,
    write_bonded_tables,
)
from pydlpoly.formats.field import parse_field
from pydlpoly.formats.records import BondedTable

FIELD = parse_field(
    "t\nunits kJ\nmolecules 2\nM\nnummols 1\natoms 4\nA 1 0 2\nB 1 0\nC 1 0\n"
    "bonds 3\ntab 1 2\n-tab 3 2\nharm 3 4 1 1\nangles 1\ntab 1 2 3\ndihedrals 1\n-tab 4 3 2 1\n"
    "inversions 1\ntab 4 3 1 2\nfinish\nN\nnummols 0\natoms 2\nC 1 0 2\nbonds 1\ntab 1 2\nfinish\nclose\n"
)
BONDS = (
    "# pairs\n# 2.0 4\n\n# A A\n0.5 1 -1\n1.0 2 -2\n1.5 3 -3\n2.0 4 -4\n\n# A B\n0.5 4 2\n1.0 3 4\n1.5 2 6\n2.0 1 8\n"
)
ANGLES = "t\n3\n\n# B A A\n60 1 -0.01\n120 2 -0.02\n180 4 -0.03\n"
DIHEDRALS = "t\n4\n\n# A A B C\n-90 1 .1\n0 2 .2\n90 3 .3\n180 4 .4\n"


def test_tables_come_in_the_order_of_field_with_slopes() -> None:
    assert wanted_tables("bond", FIELD) == (("A", "A"), ("A", "B"))
    first, second = parse_bonded_tables(BONDS, "bond", FIELD)
    assert (first.species, first.start, first.spacing, first.line) == (("A", "A"), 0.0, 0.5, 4)
    assert first.energy.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert first.slope.tolist() == [2.0, 2.0, 2.0, 2.0, 2.0]
    assert (second.species, second.slope.tolist()) == (("A", "B"), [-4.0, -4.0, -4.0, -4.0, -4.0])
    assert second.energy[0] == 6.0


def test_the_start_goes_on_with_a_slope_that_changes_linearly() -> None:
    (table,) = parse_bonded_tables(ANGLES, "angle", FIELD)
    assert table.slope.tolist() == pytest.approx([0.0, 0.01, 0.02, 0.03])
    assert table.energy.tolist() == pytest.approx([1.0 - 30.0 * 0.01, 1.0, 2.0, 4.0])


def test_a_line_for_the_start() -> None:
    first, _ = parse_bonded_tables(BONDS.replace("0.5 1 -1", "0.0 7 -9\n0.5 1 -1"), "bond", FIELD)
    assert (first.energy[0], first.slope[0], first.slope[1]) == (7.0, 9.0, 2.0)
    (angle,) = parse_bonded_tables(ANGLES.replace("60 1", "0 0.5 0.25\n60 1"), "angle", FIELD)
    assert (angle.energy[0], angle.slope[0]) == (0.5, -0.25)


def test_dihedrals_are_periodic() -> None:
    for text in (DIHEDRALS, DIHEDRALS.replace("-90 1 .1", "-180 4 .4\n-90 1 .1")):
        (table,) = parse_bonded_tables(text, "dihedral", FIELD)
        assert (table.start, table.spacing) == (-180.0, 90.0)
        assert table.energy.tolist() == [4.0, 1.0, 2.0, 3.0, 4.0]
        assert table.slope.tolist() == [-0.4, -0.1, -0.2, -0.3, -0.4]


def test_orders_of_species_with_the_same_table() -> None:
    assert canonical_species("bond", "BA") == ("A", "B")
    assert canonical_species("angle", "CAB") == ("B", "A", "C")
    assert canonical_species("dihedral", "CABA") == ("A", "B", "A", "C")
    assert canonical_species("inversion", "CBAA") == ("C", "A", "A", "B")
    text = "t\n3\n\nC A B A\n60 1 0\n120 1 0\n180 1 0\n"
    assert parse_bonded_tables(text, "inversion", FIELD)[0].species == ("C", "A", "B", "A")


@pytest.mark.parametrize("kind", ["bond", "angle", "dihedral", "inversion"])
def test_written_and_read_again(kind: str) -> None:
    rng = np.random.default_rng(3)
    tables = []
    for species in wanted_tables(kind, FIELD):
        start, spacing = (0.0, 0.1) if kind == "bond" else (-180.0, 36.0) if kind == "dihedral" else (0.0, 18.0)
        energy, slope = rng.normal(size=(2, 11))
        if kind == "dihedral":
            energy[0], slope[0] = energy[-1], slope[-1]
        tables.append(BondedTable(kind, species, start, spacing, energy, slope))
    for table, again in zip(tables, parse_bonded_tables(write_bonded_tables(tables), kind, FIELD), strict=True):
        assert again.species == table.species
        assert again.spacing == pytest.approx(table.spacing, rel=1e-15)
        assert again.energy[1:].tolist() == table.energy[1:].tolist()
        assert again.slope[1:] == pytest.approx(table.slope[1:], rel=1e-14)


def test_what_cannot_be_written() -> None:
    (table,) = parse_bonded_tables(ANGLES, "angle", FIELD)
    with pytest.raises(InputError, match="needs at least one"):
        write_bonded_tables([])
    with pytest.raises(InputError, match="must be one line"):
        write_bonded_tables([table], "a\nb")
    with pytest.raises(InputError, match="another kind or grid than the first one"):
        write_bonded_tables([table, replace(table, spacing=1.0)])
    with pytest.raises(InputError, match="the slope of B A A must be 4 finite numbers"):
        write_bonded_tables([replace(table, slope=table.slope * np.nan)])


def test_files(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the file cannot be read"):
        read_bonded_tables(tmp_path / "TABBND", "bond", FIELD)
    (tmp_path / "TABBND").write_text(BONDS)
    assert [t.path for t in read_bonded_tables(tmp_path / "TABBND", "bond", FIELD)] == [str(tmp_path / "TABBND")] * 2


def bonds(before: str, after: str) -> str:
    assert before in BONDS
    return BONDS.replace(before, after, 1)


@pytest.mark.parametrize(
    ("kind", "text", "message"),
    [
        ("bond", "", "T:1: the file ends here; expected the cutoff and the number of grid points"),
        ("angle", "t\n", "T:1: the file ends here; expected the number of grid points"),
        ("bond", "t\n# zero 4", "T:2: 'zero': expected the cutoff of the bonds, a positive number"),
        ("bond", "t\n# -2.0 4", "T:2: '-2.0': expected the cutoff of the bonds, a positive number"),
        ("bond", "t\n2.0", "T:2: the line is too short; expected the cutoff and the number of grid points"),
        ("bond", "t\n2.0 2", "T:2: '2': expected the number of grid points, at least 3"),
        ("angle", "t\n9.5", "T:2: '9.5': expected the number of grid points, at least 3"),
        (
            "bond",
            "t\n2.0 4\n",
            "T:2: the file ends here; expected the table of A A, which FIELD declares tab",
        ),
        (
            "bond",
            BONDS[: BONDS.index("# A B")],
            "T:9: the file ends here; expected the table of A B, which FIELD declares tab",
        ),
        ("bond", bonds("# A B", "# A D"), "T:10: 'D': unknown species"),
        (
            "bond",
            bonds("# A B", "# A"),
            "T:10: 'A': expected 2 species, which head the next table (the lines before make up the 4 points of line "
            "2)",
        ),
        (
            "bond",
            bonds("2.0 4 -4\n", "2.0 4 -4\n2.5 5 -5\n"),
            "T:9: '2.5': expected 2 species, which head the next table (the lines before make up the 4 points of line "
            "2)",
        ),
        (
            "bond",
            bonds("# A B", "# A C"),
            "T:10: FIELD does not declare the bond A C tab; it declares A A, A B",
        ),
        ("bond", bonds("# A B", "# A A"), "T:10: the table of A A is already given on line 4"),
        (
            "bond",
            bonds("1.0 2 -2", "1.1 2 -2"),
            "T:6: '1.1': expected point 2 of 4 of the table of A A (line 4) at 1 ang, as the grid of line 2 has it",
        ),
        (
            "angle",
            ANGLES.replace("120 2", "121 2"),
            "T:6: '121': expected point 2 of 3 of the table of B A A (line 4) at 120 degrees, as the grid of line 2 "
            "has it",
        ),
        (
            "bond",
            bonds("1.0 2 -2", "1.0 x -2"),
            "T:6: 'x': expected a finite number, point 2 of 4 of the table of A A (line 4)",
        ),
        (
            "bond",
            bonds("1.0 2 -2", "1.0 nan -2"),
            "T:6: 'nan': expected a finite number, point 2 of 4 of the table of A A (line 4)",
        ),
        (
            "bond",
            bonds("1.0 2 -2", "1.0 2"),
            "T:6: the line is too short; expected three numbers, point 2 of 4 of the table of A A (line 4)",
        ),
        (
            "bond",
            BONDS[: BONDS.index("2.0 1 8")],
            "T:13: the file ends here; expected point 4 of 4 of the table of A B (line 10)",
        ),
        (
            "dihedral",
            DIHEDRALS.replace("-90 1 .1", "-180 3 .4\n-90 1 .1"),
            "T:4: U of A A B C is 3 at -180 degrees and 4 at 180",
        ),
    ],
)
def test_broken_files(kind: str, text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_bonded_tables(text, kind, FIELD, path="T")
    assert str(caught.value) == message
