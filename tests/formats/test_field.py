"""FIELD files as people write them: dialects of spelling, odd layouts, every block, and what DL_POLY itself ran."""

from __future__ import annotations

from pathlib import Path

import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.field import looks_like_dl_meso_field, parse_field, read_field, write_field
from pydlpoly.formats.lexing import parse_integer, parse_number
from pydlpoly.formats.records import (
    AtomLine,
    BondedLine,
    Field,
    Molecule,
    MoleculeBlock,
    PairLine,
)

HEAD = "water\nunits kJ\nmolecules 1\nWATER\nnummols 2\n"
MOLECULE = HEAD + "atoms 3\nOW 16.0 -0.8\nHW 1.0 0.4 2\n"
WATER_ATOMS = (AtomLine("OW", 16.0, -0.8), AtomLine("HW", 1.0, 0.4, 2))


def bonded(block: str) -> Molecule:
    return parse_field(MOLECULE + block + "finish\nvdw 0\nclose\n").molecules[0]


def after(block: str) -> Field:
    return parse_field(MOLECULE + "finish\n" + block + "close\n")


def atoms(lines: str, count: int) -> Field:
    return parse_field(HEAD + f"atoms {count}\n" + lines + "finish\nclose\n")


# --- files of others ------------------------------------------------------------------------------------------------


def test_every_golden_field_reads_without_warning_and_survives_writing(shared: Path) -> None:
    paths = [*sorted(shared.glob("golden/*/FIELD")), *sorted(shared.glob("inputs/dl_poly/*/FIELD"))]
    assert len(paths) >= 69
    for path in paths:
        field = read_field(path)
        assert field.warnings == (), path
        assert field.bead_count > 0
        assert field.pairs, path
        assert parse_field(write_field(field)) == field, path


def test_lipid_run_is_read_completely(shared: Path) -> None:
    field = read_field(shared / "golden/run-lipid/FIELD")
    assert (field.title, field.units, field.bead_count) == ("lipid", "internal", 280)
    (lipid,) = field.molecules
    assert (lipid.name, lipid.count, lipid.beads_per_molecule) == ("HT6", 40, 7)
    assert [b.directive for b in lipid.blocks] == ["bonds", "angles"]
    bonds, angles = lipid.blocks
    assert bonds.lines[5] == BondedLine("-hrm", (6, 7), (128.0, 0.5))
    assert angles.lines[0] == BondedLine("-cos", (1, 2, 3), (20.0, 180.0, 1.0))
    assert field.pairs[1] == PairLine(("H", "T"), "dpd", (50.0, 1.0))
    assert field.pairs[1].line == 30


def test_water_beads_with_a_drag_after_the_law(shared: Path) -> None:
    field = read_field(shared / "inputs/dl_poly/water-ndpd/FIELD")
    assert field.units == "kj"
    assert field.molecules[0].atoms == (AtomLine("WT", 90.076),)
    assert field.pairs == (PairLine(("WT", "WT"), "ndpd", (3.00581, 15.0, 4.0, 13.8756, 4.310805)),)


def test_dl_meso_files_are_known_by_their_content(shared: Path) -> None:
    paths = sorted(shared.glob("inputs/dl_meso/*/FIELD"))
    assert len(paths) == 7
    for path in paths:
        assert looks_like_dl_meso_field(path.read_text())
        assert read_field(path).meso is not None


def test_dl_poly_files_are_not_taken_for_dl_meso(shared: Path) -> None:
    assert not any(looks_like_dl_meso_field(p.read_text()) for p in shared.glob("golden/*/FIELD"))
    odd_names = HEAD + "atoms 2\nspecies 1.0 0.0\ninteract 2 0\nfinish\nclose\n"
    assert not looks_like_dl_meso_field(odd_names)
    assert [a.name for a in parse_field(odd_names).molecules[0].atoms] == ["species", "interact"]


# --- item 9, 10: spelling of directives and units -------------------------------------------------------------------


@pytest.mark.parametrize("word", ["molecules 1", "MOLECULES 1", "molecular types 1", "Molecule 1", "  molecules   1"])
def test_molecules_directive_in_all_its_spellings(word: str) -> None:
    text = f"t\nUNITS internal\n{word}\nW\nNumMols 3\nATOMS 1\nW 1 0\nFINISH\nCLOSE\n"
    assert parse_field(text).molecules == (Molecule("W", 3, (AtomLine("W", 1.0),)),)


@pytest.mark.parametrize(
    ("word", "unit"),
    [
        ("kJ", "kj"),
        ("KJ/mol", "kj"),
        ("kcal", "kcal"),
        ("eV", "ev"),
        ("k", "k"),
        ("kelvin", "k"),
        ("K", "k"),
        ("kB", "k"),
        ("kT", "k"),
        ("internal", "internal"),
        ("", "internal"),
        ("dpd", "dpd"),
        ("DPD", "dpd"),
        ("# nothing said", "internal"),
    ],
)
def test_energy_units(word: str, unit: str) -> None:
    assert parse_field(f"t\nunits {word}\nmolecules 0\nclose\n").units == unit


def test_words_may_stand_between_a_directive_and_its_number() -> None:
    text = MOLECULE + "bonds units 1\nharm 1 2 450 1\nfinish\nvdw potentials 1\nOW OW lj 0.6 3.2\nclose\n"
    field = parse_field(text)
    assert field.molecules[0].block("bonds") == MoleculeBlock("bonds", (BondedLine("harm", (1, 2), (450.0, 1.0)),))
    assert len(field.pairs) == 1


# --- item 5, 12, 13: numbers, comments, blank lines, molecules ------------------------------------------------------


@pytest.mark.parametrize(
    ("word", "value"),
    [
        ("1", 1.0),
        (".000", 0.0),
        ("1d-6", 1e-6),
        ("5.d-4", 5e-4),
        ("1.e-5", 1e-5),
        (".0001", 1e-4),
        ("10000.", 1e4),
        ("1.0117e+4", 10117.0),
        ("-2D+3", -2000.0),
        ("1/4", 0.25),
        ("-3./2", -1.5),
        ("0.1234567890-100", 0.123456789e-100),
        ("0.5+101", 0.5e101),
        ("1q2", 100.0),
    ],
)
def test_fortran_numbers(word: str, value: float) -> None:
    assert parse_number(word) == value
    assert after(f"vdw 1\nOW HW lj {word} 3.16\n").pairs[0].parameters[0] == value


@pytest.mark.parametrize("word", ["", ".", "-", "e5", "1e", "1_0", "0x10", "nan", "inf", "1e999", "1/0", "1/2/3", "١"])
def test_not_numbers(word: str) -> None:
    assert parse_number(word) is None


def test_whole_numbers() -> None:
    assert [parse_integer(w) for w in ("3", "+3", "3.0", "3.5", "x", "9007199254740993")] == [
        3,
        3,
        3,
        None,
        None,
        9007199254740993,
    ]


def test_comments_and_blank_lines_anywhere() -> None:
    text = (
        "a title ! not a comment\n\n# remark\nunits kJ ! per mole\n   \nmolecules 1 # one\n\n# next its name\nWATER\n"
        "!x\nnummols 2\n\natoms 3\n\nOW 16.0 -0.8 # oxygen\n   # hydrogen\nHW 1.0 0.4 2\n\nbonds 1\n\n"
        "harm 1 2 450.0 1.0 ! stiff\nfinish\n\nvdw 1\n#\nOW OW lj 0.65 3.16 # end\n\nclose\n"
        "after close: vdw 7, finish\n"
    )
    field = parse_field(text)
    assert field.title == "a title ! not a comment"
    assert field.molecules[0].atoms == WATER_ATOMS
    assert field.molecules[0].blocks == (MoleculeBlock("bonds", (BondedLine("harm", (1, 2), (450.0, 1.0)),)),)
    assert field.pairs == (PairLine(("OW", "OW"), "lj", (0.65, 3.16)),)
    assert field.warnings == ()
    assert (field.molecules[0].line, field.pairs[0].line) == (9, 26)


def test_windows_line_ends_tabs_byte_order_mark_and_no_final_newline(tmp_path: Path) -> None:
    text = "\ufeff" + MOLECULE.replace("\n", "\r\n").replace(" ", "\t") + "finish\r\nvdw 0\r\nclose"
    path = tmp_path / "FIELD"
    path.write_bytes(text.encode())
    field = read_field(path)
    assert field.title == "water"
    assert field.molecules[0].atoms == WATER_ATOMS
    path.write_bytes("Bead für Bead\n".encode("latin-1") + b"molecules 0\nclose\n")
    assert read_field(path).title == "Bead für Bead"


def test_molecule_without_copies_and_molecule_of_one_bead() -> None:
    text = "t\nunits kJ\nmolecules 2\nGone\nnummols 0\natoms 1\nG 1 0\nfinish\nOne\nnummols 5\natoms 1\nO 1 0\nfinish\n"
    field = parse_field(text + "vdw 1\nG O lj 1 1\nclose\n")
    assert [m.count for m in field.molecules] == [0, 5]
    assert field.bead_count == 5


def test_molecule_without_a_name_is_told() -> None:
    field = parse_field("t\nunits kJ\nmolecules 1\n\nnummols 2\natoms 1\nW 1 0\nfinish\nclose\n")
    assert field.molecules[0].name == ""
    assert field.warnings == ("FIELD:5: a molecule has no name",)
    assert parse_field(write_field(field)) == field


@pytest.mark.parametrize("name", ["close", "vdw 3", "finish", "atoms 3", "nummols", "bonds and more", "units kJ"])
def test_molecule_may_be_called_like_a_directive(name: str) -> None:
    field = parse_field(f"t\nunits kJ\nmolecules 1\n{name}\nnummols 2\natoms 1\nW 1 0\nfinish\nclose\n")
    assert (field.molecules[0].name, field.molecules[0].count) == (name, 2)
    assert parse_field(write_field(field)) == field


# --- item 11: atom lines --------------------------------------------------------------------------------------------


def test_atom_line_with_repeat_frozen_and_group() -> None:
    field = atoms("A 1.0 0.5 2 1 1\nB 2.0 0.0 0\nC 3 1d-1 1 0 0\n", 4)
    expected = (AtomLine("A", 1.0, 0.5, 2, 1), AtomLine("B", 2.0), AtomLine("C", 3.0, 0.1))
    assert field.molecules[0].atoms == expected
    assert field.warnings == (
        "FIELD:7: the sixth number of an atom line (the charge group) has no effect, as in DL_POLY",
    )


def test_atom_line_without_a_charge_is_told() -> None:
    field = atoms("A 1.0\nB 2.0\n", 2)
    assert field.molecules[0].atoms == (AtomLine("A", 1.0), AtomLine("B", 2.0))
    assert field.warnings == ("FIELD:7: atom lines without a charge; it is taken as 0 (on 2 lines)",)


def test_text_after_an_atom_line_is_told() -> None:
    field = atoms("A 1.0 0.0 carbon, sp3\nB 2.0 0.0 1 0 0d.a\n", 2)
    assert field.molecules[0].atoms == (AtomLine("A", 1.0), AtomLine("B", 2.0))
    assert field.warnings == ("FIELD:7: 'carbon,': text after the numbers is not used (text on 2 lines)",)


def test_negative_mass_loses_its_sign_and_is_told() -> None:
    field = atoms("A -1.5 0.0\n", 1)
    assert field.molecules[0].atoms[0].mass == 1.5
    assert field.warnings == ("FIELD:7: the negative mass -1.5 is taken without its sign, as DL_POLY does",)


def test_names_keep_their_case_and_eight_characters() -> None:
    field = parse_field(
        "t\nunits kJ\nmolecules 1\nM\nnummols 1\natoms 4\nwt 1 0\nWT 1 0\nO_2-*#+ 1 0\nVeryLongName 1 0\nfinish\n"
        "vdw 2\nwt WT lj 1 1\nVeryLong VeryLongName lj 1 1\nclose\n"
    )
    assert [a.name for a in field.molecules[0].atoms] == ["wt", "WT", "O_2-*#+", "VeryLong"]
    assert [p.species for p in field.pairs] == [("wt", "WT"), ("VeryLong", "VeryLong")]
    assert field.warnings == ("FIELD:10: species name 'VeryLongName' is cut to 'VeryLong' (on 2 lines)",)


def test_species_may_be_called_like_directives() -> None:
    field = parse_field(
        "t\nunits kJ\nmolecules 1\nM\nnummols 1\natoms 2\nbonds 12.0 0.0\nclose 1 0\nfinish\n"
        "vdw 1\nclose bonds lj 1 1\nmetal 1\nclose close gupt 1 2 3 4 5\nclose\n"
    )
    assert [a.name for a in field.molecules[0].atoms] == ["bonds", "close"]
    assert field.pairs[0].species == ("close", "bonds")


# --- lenient reading (item 16) --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "warning"),
    [
        (MOLECULE + "finish\nvdw 1\nOW OW lj 1 2\n", "FIELD:11: the file ends without close"),
        (
            MOLECULE + "finish\nvdw 2\nOW HW lj 1 2\nHW OW lj 1 2\nclose\n",
            "FIELD:12: the pair HW OW is already given on line 11; remove one of the two",
        ),
        (
            MOLECULE.replace("units kJ\n", "") + "finish\nvdw 1\nOW OW lj 1 2\nclose\n",
            "FIELD:9: 'vdw': expected a units line before the first energies",
        ),
        (
            MOLECULE.replace("-0.8", "-0.8 1 0 1 7") + "finish\nvdw 1\nOW OW lj 1 2\nclose\n",
            "FIELD:7: '7': an atom line has at most five numbers (mass, charge, repeat, frozen, group)",
        ),
    ],
)
def test_lenient_reading_tells_what_strict_reading_refuses(text: str, warning: str) -> None:
    with pytest.raises(InputError):
        parse_field(text)
    field = parse_field(text, lenient=True)
    assert warning in field.warnings
    assert len(field.pairs) == 1


def test_lenient_reading_never_chooses_between_two_laws() -> None:
    with pytest.raises(InputError, match="already given on line 11"):
        parse_field(MOLECULE + "finish\nvdw 2\nOW HW lj 1 2\nHW OW lj 1 3\nclose\n", lenient=True)


# --- files and writing ----------------------------------------------------------------------------------------------


def test_missing_file_and_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the file cannot be read: No such file or directory"):
        read_field(tmp_path / "FIELD")
    with pytest.raises(InputError, match="the file cannot be read: Is a directory"):
        read_field(tmp_path)


def test_empty_record_is_written_and_read() -> None:
    assert write_field(Field()) == "\nunits internal\nmolecules 0\nclose\n"
    assert parse_field(write_field(Field())) == Field()


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (Field(title="two\nlines"), "the title must be one line"),
        (Field(units="joule"), "unknown energy unit"),
        (Field(molecules=(Molecule("M", 1, (AtomLine("two words", 1.0),)),)), "this species name cannot be written"),
        (Field(molecules=(Molecule("M", 1, (AtomLine("#A", 1.0),)),)), "this species name cannot be written"),
        (Field(molecules=(Molecule("M", 1, (AtomLine("NineChars", 1.0),)),)), "this species name cannot be written"),
        (Field(molecules=(Molecule("# M", 1, (AtomLine("A", 1.0),)),)), "must not begin with #"),
        (Field(molecules=(Molecule(" M", 1, (AtomLine("A", 1.0),)),)), "must not begin with #"),
        (Field(pairs=(PairLine(("A", "A"), "lj", (float("nan"),)),)), "not finite cannot be written"),
    ],
)
def test_what_could_not_be_read_back_is_not_written(field: Field, message: str) -> None:
    with pytest.raises(InputError, match=message):
        write_field(field)
