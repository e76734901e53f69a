"""The blocks of FIELD files: bonded interactions inside molecules, pairs, and the rest."""

from __future__ import annotations

import pytest

from pydlpoly.formats.field import parse_field, write_field
from pydlpoly.formats.field_keys import BONDED, EXTERNAL_KEYS, PAIR_KEYS
from pydlpoly.formats.records import BondedLine, ExternalLine, Field, Molecule, MoleculeBlock, OtherBlock, PairLine

HEAD = "water\nunits kJ\nmolecules 1\nWATER\nnummols 2\n"
MOLECULE = HEAD + "atoms 3\nOW 16.0 -0.8\nHW 1.0 0.4 2\n"


def bonded(block: str) -> Molecule:
    return parse_field(MOLECULE + block + "finish\nvdw 0\nclose\n").molecules[0]


def after(block: str) -> Field:
    return parse_field(MOLECULE + "finish\n" + block + "close\n")


# --- bonded blocks --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("directive", ["bonds", "angles", "dihedrals", "inversions", "tethers"])
def test_every_key_of_every_block(directive: str) -> None:
    kind = BONDED[directive]
    beads = tuple(range(1, kind.beads + 1))
    word = {"tethers": "teth", "dihedrals": "DIHEDRALS"}.get(directive, directive)
    for key in sorted(kind.keys):
        line = f"{key.upper()} {' '.join(map(str, beads))} 1.5 2.5 3.5"
        text = HEAD + f"atoms 4\nC 12.0 0.0 4\n{word} 1\n{line}\nfinish\nclose\n"
        field = parse_field(text)
        expected = BondedLine(key, beads, (1.5, 2.5, 3.5))
        assert field.molecules[0].blocks[0].lines == (expected,)
        assert field.molecules[0].blocks[0].directive == directive
        assert parse_field(write_field(field)) == field


def test_restraint_forms_are_complete() -> None:
    counts = {name: (len(kind.keys), sum(k.startswith("-") for k in kind.keys)) for name, kind in BONDED.items()}
    assert counts == {
        "shells": (0, 0),
        "constraints": (0, 0),
        "tethers": (3, 0),
        "bonds": (22, 11),
        "angles": (30, 15),
        "dihedrals": (16, 8),
        "inversions": (12, 6),
    }


def test_shells_and_constraints() -> None:
    molecule = bonded("shell 1\n1 2 1000.0 2.5\nconstraints 2\n1 2 1.0\n1 3 1.0d0 remark\n")
    assert molecule.blocks == (
        MoleculeBlock("shells", (BondedLine("", (1, 2), (1000.0, 2.5)),)),
        MoleculeBlock("constraints", (BondedLine("", (1, 2), (1.0,)), BondedLine("", (1, 3), (1.0,)))),
    )


def test_rigid_units_over_several_lines() -> None:
    first = " ".join(str(i) for i in range(1, 16))
    rest = " ".join(str(i) for i in range(16, 21))
    text = HEAD + f"atoms 40\nC 12.0 0.0 40\nrigid units 2\n20 {first}\n{rest}\n3 21\n22 23 a triangle\nfinish\nclose\n"
    field = parse_field(text)
    expected = (BondedLine("", tuple(range(1, 21))), BondedLine("", (21, 22, 23)))
    assert field.molecules[0].blocks == (MoleculeBlock("rigid", expected),)
    written = write_field(field)
    assert parse_field(written) == field
    rows = written.splitlines()
    start = rows.index("rigid 2")
    assert [len(row.split()) for row in rows[start + 1 : start + 4]] == [16, 5, 4]


def test_mean_force_constraint() -> None:
    text = MOLECULE + "pmf 2.5\npmf unit 2\n1 16.0\n2\npmf unit 1\n3 1.0\nfinish\nclose\n"
    field = parse_field(text)
    expected = (
        BondedLine("length", (), (2.5,)),
        BondedLine("unit", (1, 2), (16.0, 0.0)),
        BondedLine("unit", (3,), (1.0,)),
    )
    assert field.molecules[0].blocks == (MoleculeBlock("pmf", expected),)
    assert parse_field(write_field(field)) == field


def test_dihedrals_for_the_same_beads_add_up_and_are_told() -> None:
    text = HEAD + "atoms 4\nC 12.0 0.0 4\ndihedrals 2\ncos 1 2 3 4 1 0 1\ncos 4 3 2 1 2 0 2\nfinish\nclose\n"
    field = parse_field(text)
    assert len(field.molecules[0].blocks[0].lines) == 2
    assert field.warnings == ("FIELD:10: dihedrals given more than once for the same beads; they add up",)


# --- pairs and the other blocks (items 14, 15) ----------------------------------------------------------------------


def test_every_pair_key() -> None:
    for key in sorted(PAIR_KEYS):
        field = after(f"vdw 1\nHW OW {key.upper()} 1 2 3\n")
        assert field.pairs == (PairLine(("HW", "OW"), key, (1.0, 2.0, 3.0)),)
    assert len(PAIR_KEYS) == 26


@pytest.mark.parametrize("word", ["VDW 1", " Vdw   1", "vdw potentials 1", "\tvdw\t1 pair"])
def test_spellings_of_vdw(word: str) -> None:
    assert after(f"{word}\nOW HW lj 0.0 1.0\n").pairs == (PairLine(("OW", "HW"), "lj", (0.0, 1.0)),)


def test_blocks_without_energies_need_no_unit() -> None:
    text = MOLECULE.replace("units kJ\n", "") + "constraints 1\n1 2 1.0\nrigid 1\n2 1 3\nfinish\nclose\n"
    assert parse_field(text).units == "internal"


@pytest.mark.parametrize(
    ("line", "key", "numbers"),
    [
        ("dpd 25.0 1.0", "dpd", (25.0, 1.0)),
        ("dpd 25.0 1.0 4.5", "dpd", (25.0, 1.0, 4.5)),
        ("dpd 0.0 1.0 4.5 1.2", "dpd", (0.0, 1.0, 4.5, 1.2)),
        ("ndpd 3.0 15. 4 13.9 4.3 14", "ndpd", (3.0, 15.0, 4.0, 13.9, 4.3, 14.0)),
        ("mdpd -40 25 1 0.75 18 2 1", "mdpd", (-40.0, 25.0, 1.0, 0.75, 18.0, 2.0, 1.0)),
        ("tab", "tab", ()),
        ("tab 4.5", "tab", (4.5,)),
        ("buckingham 1 2 3", "buck", (1.0, 2.0, 3.0)),
    ],
)
def test_pair_lines_keep_every_number(line: str, key: str, numbers: tuple[float, ...]) -> None:
    assert after(f"vdw 1\nOW HW {line}\n").pairs == (PairLine(("OW", "HW"), key, numbers),)


def test_text_after_a_pair_is_told_because_it_could_be_a_damaged_number() -> None:
    field = after("vdw 1\nOW HW dpd 25.0 1.0 O.5\n")
    assert field.pairs[0].parameters == (25.0, 1.0)
    assert field.warnings == ("FIELD:11: 'O.5': text after the numbers is not used",)


def test_rdf_pairs_and_external_field() -> None:
    field = after("rdf 2\nOW OW\nHW OW\nvdw 0\nextern\nGRAV 0 0 -9.8 down\n")
    assert field.rdf_pairs == (("OW", "OW"), ("HW", "OW"))
    assert field.externals == (ExternalLine("grav", (0.0, 0.0, -9.8)),)
    assert parse_field(write_field(field)) == field


def test_every_external_field() -> None:
    for key in sorted(EXTERNAL_KEYS):
        assert after(f"external\n{key} 1 2 3\n").externals == (ExternalLine(key, (1.0, 2.0, 3.0)),)
    assert len(EXTERNAL_KEYS) == 14


def test_blocks_without_records_are_kept_line_by_line() -> None:
    field = after("metal 1\nOW OW gupt  1.0 2 3 4 5\ntbp 1\nHW OW HW harm 1 2\nvdw 1\nOW OW lj 1 2\nkim_init LJ_612\n")
    assert field.others == (
        OtherBlock("metal", ("metal 1", "OW OW gupt  1.0 2 3 4 5")),
        OtherBlock("tbp", ("tbp 1", "HW OW HW harm 1 2")),
        OtherBlock("kim_init", ("kim_init LJ_612",)),
    )
    assert len(field.pairs) == 1
    assert parse_field(write_field(field)) == field


def test_line_numbers_and_paths_do_not_make_records_different() -> None:
    assert parse_field(MOLECULE + "finish\nclose\n", path="a") == parse_field(
        MOLECULE.replace("atoms", "\n\natoms") + "finish\nclose\n", path="b"
    )
