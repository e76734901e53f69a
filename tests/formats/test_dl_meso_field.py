"""FIELD in DL_MESO's dialect: the records it becomes, and what is refused, with exact messages."""

from __future__ import annotations

from pathlib import Path

import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.field import parse_field, read_field, write_field
from pydlpoly.formats.records import (
    AtomLine,
    BondedLine,
    ExternalLine,
    Field,
    Molecule,
    MoleculeBlock,
    PairLine,
    Remark,
)

SPECIES = "a fluid\n\nSPECIES 2\nA 1.0 0.0 0\nW 2.0 -0.5 10\n\n"
MOLECULE = "MOLECULES 1\nAA\nnummols 3\nbeads 2\nA 0.0 0.0 -0.25\nA 0.0 0.0 0.25\n"
PAIRS = "INTERACTIONS 3\nA A dpd 25.0 1.0 4.5\nA W dpd 30.0 1.0 4.5\nW W dpd 25.0 1.0 4.5\nclose\n"


def field(inside: str = "bonds 1\nharm 1 2 100.0 0.5\n", after: str = PAIRS) -> Field:
    """The molecule's blocks start on line 13."""
    return parse_field(f"{SPECIES}{MOLECULE}{inside}finish\n{after}")


def message(text: str, lenient: bool = False) -> str:
    with pytest.raises(InputError) as caught:
        parse_field(text, lenient=lenient)
    return str(caught.value)


def test_a_file_as_records() -> None:
    found = field()
    assert (found.title, found.units, found.bead_count) == ("a fluid", "dpd", 16)
    assert found.molecules == (
        Molecule("W", 10, (AtomLine("W", 2.0, -0.5),)),
        Molecule(
            "AA",
            3,
            (AtomLine("A", 1.0), AtomLine("A", 1.0)),
            (MoleculeBlock("bonds", (BondedLine("-hrm", (1, 2), (100.0, 0.5)),)),),
        ),
    )
    assert found.pairs[1] == PairLine(("A", "W"), "dpd", (30.0, 1.0, 4.5))
    assert [line.line for line in found.pairs] == [17, 18, 19]
    assert found.meso is not None
    assert found.meso.coordinates == (((0.0, 0.0, 0.0),), ((0.0, 0.0, -0.25), (0.0, 0.0, 0.25)))
    assert (found.meso.mirrored, found.meso.loose) == ((False, True), 10)
    assert (found.warnings, found.remarks) == ((), ())


def test_public_inputs(shared: Path) -> None:
    """Counted by hand: 12000 beads at every composition, 49152 of the lipids."""
    counts = {path.parent.name: read_field(path) for path in shared.glob("inputs/dl_meso/*/FIELD")}
    assert {name: one.bead_count for name, one in counts.items()} == {
        **dict.fromkeys((f"amphiphile-{k}" for k in (1, 2, 3, 4)), 12000),
        "lipid": 49152,
        "mixing": 1000,
        "phase-separation": 3000,
    }
    lipid = counts["lipid"]
    assert not any(one.warnings or one.remarks for one in counts.values())
    assert [(molecule.name, molecule.count) for molecule in lipid.molecules] == [("W", 35152), ("HC6", 2000)]
    bonds, angles = lipid.molecules[1].blocks
    assert bonds.lines[5] == BondedLine("-hrm", (6, 7), (128.0, 0.5))
    assert angles.lines[0] == BondedLine("-cos", (1, 2, 3), (20.0, 0.0, 1.0))
    assert lipid.pairs[5] == PairLine(("C", "W"), "dpd", (75.0, 1.0, 20.0))
    assert [pair.species for pair in counts["mixing"].pairs] == [(f"PLE{k}", f"PLE{k}") for k in (1, 2, 3)]


def test_written_as_dl_polys_file(shared: Path) -> None:
    """What is written has nothing of DL_MESO left and reads back as the same molecules and pairs."""
    for path in shared.glob("inputs/dl_meso/*/FIELD"):
        found = read_field(path)
        again = parse_field(write_field(found))
        assert again.meso is None
        assert (again.molecules, again.pairs, again.units) == (found.molecules, found.pairs, "dpd")


def test_blocks_in_any_order_and_case() -> None:
    """Molecules before the species that their beads are of, a name with blanks, a lower-case close."""
    text = f"t\nmolecules 1\nAA   \nBEADS 1\nA 1 2 3\nNumMols 2\nFINISH\n{PAIRS.replace('close', 'CLOSE')}"
    text = text.replace("CLOSE\n", "") + "species 2\nA 1.0\nW 1.0 0.0 4 1\nclose\nwhatever comes after\n"
    found = parse_field(text)
    assert [(one.name, one.count) for one in found.molecules] == [("W", 4), ("AA", 2)]
    assert found.molecules[0].atoms == (AtomLine("W", 1.0, 0.0, 1, 1),)


def test_no_isomer_forbids_mirror_images() -> None:
    meso = field("no isomer\n").meso
    assert meso is not None
    assert meso.mirrored == (False, False)


def test_a_species_without_beads_has_its_pairs() -> None:
    text = SPECIES.replace("SPECIES 2", "SPECIES 3").replace("W 2.0", "N 1.0 0.0 0\nW 2.0")
    found = parse_field(f"{text}{MOLECULE}finish\n{PAIRS}")
    assert [(one.name, one.count) for one in found.molecules] == [("N", 0), ("W", 10), ("AA", 3)]


def test_species_by_number() -> None:
    assert field(after=PAIRS.replace("A W dpd", "1 2 dpd")).pairs[1].species == ("A", "W")


@pytest.mark.parametrize(
    ("block", "expected"),
    [
        ("bonds 1\nharm 1 2 4.0\n", ("bonds", "-hrm", (4.0, 0.0))),
        ("bonds 1\nfene 1 2 30.0 1.5\n", ("bonds", "-fne", (30.0, 1.5))),
        ("bonds 1\nfene 1 2 30.0 1.5 0.0\n", ("bonds", "-fne", (30.0, 1.5))),
        ("angles 1\nharm 1 2 3 5.0 120.0\n", ("angles", "-hrm", (5.0, 120.0))),
        ("angles 1\nhcos 1 2 3 5.0 120.0\n", ("angles", "-hcs", (5.0, 120.0))),
        ("dihedrals 1\ncos 1 2 3 4 2.0 180.0 1.0\n", ("dihedrals", "-cos", (2.0, 180.0, 1.0))),
        ("dihedrals 1\nharm 1 2 3 4 2.0 180.0\n", ("dihedrals", "-hrm", (2.0, 180.0))),
        ("constraints 1\n1 2 0.5\n", ("constraints", "", (0.5,))),
    ],
)
def test_bonded_laws(block: str, expected: tuple[str, str, tuple[float, ...]]) -> None:
    beads = "".join(f"A 0 0 {k}\n" for k in range(4))
    molecule = MOLECULE.replace("beads 2\nA 0.0 0.0 -0.25\nA 0.0 0.0 0.25\n", f"beads 4\n{beads}")
    found = parse_field(f"{SPECIES}{molecule}{block}finish\n{PAIRS}")
    (block_found,) = found.molecules[1].blocks
    (line,) = block_found.lines
    assert (block_found.directive, line.key, line.parameters) == expected
    if block == "bonds 1\nharm 1 2 4.0\n":
        assert found.remarks == (Remark("choice", "harm without r0: 0, as in DL_MESO", 16),)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("A A lj 1.0 0.9 4.5", PairLine(("A", "A"), "lj", (1.0, 0.9, 4.5))),
        ("A A wca 1.0 0.9 4.5", PairLine(("A", "A"), "wca", (1.0, 0.9, 0.0, 4.5))),
        ("A A DPD 25.0 1.0", PairLine(("A", "A"), "dpd", (25.0, 1.0, 0.0))),
    ],
)
def test_pair_laws(line: str, expected: PairLine) -> None:
    assert field(after=PAIRS.replace("A A dpd 25.0 1.0 4.5", line)).pairs[0] == expected


def test_negative_numbers_lose_their_sign_and_that_is_told() -> None:
    found = field(after=PAIRS.replace("A A dpd 25.0", "A A dpd -25.0"))
    assert found.pairs[0].parameters == (25.0, 1.0, 4.5)
    assert found.warnings == ("FIELD:17: dpd -25.0 1.0 4.5: negative numbers lose their sign, as in DL_MESO",)


def test_external_fields() -> None:
    fields = "EXTERNAL\ngrav 0.0 0.0 -0.1\nEXTERNAL\nelec 0.0 0.5 0.0\n"
    found = field(after=fields + PAIRS)
    assert found.externals == (ExternalLine("grav", (0.0, 0.0, -0.1)), ExternalLine("elec", (0.0, 0.5, 0.0)))


def test_energies_in_units_of_the_temperature() -> None:
    meso = parse_field(SPECIES + "UNITS kT\n" + PAIRS).meso
    assert meso is not None
    assert (meso.thermal, meso.units_line) == (True, 7)


# -- public files that are broken, and those of another program -------------------------------------------------------

CYCLIC = """DL_MESO molecule cyclic example

SPECIES 3
B        1.0 0.0 4
W        1.0 0.0 2990
A        1.0 0.0 6

MOLECULES 1

nummols 2
beads 4
{beads}bonds 2
harm  (0, 1) 128.000 0.500000
harm  (0, 3) 128.000 0.500000
finish

INTERACTIONS 1
B B dpd 25.000000 1.000000 4.500000

close
"""


def test_a_script_wrote_no_beads_and_pythons_tuples() -> None:
    """A molecule without a name is told, one without its beads is refused, and so are bond indices as tuples."""
    expected = "FIELD:12: 'bonds': expected a bead line (beads on line 11 says 4, 0 so far)"
    assert message(CYCLIC.format(beads="")) == expected
    text = CYCLIC.format(beads="B 0 0 0\nB 0 0 1\nA 0 1 0\nA 1 0 0\n")
    assert (
        message(text) == "FIELD:17: '(0,': expected a bead number (a whole number, counted from 1 within the molecule)"
    )


def test_bead_numbers_count_from_one() -> None:
    text = CYCLIC.format(beads="B 0 0 0\nB 0 0 1\nA 0 1 0\nA 1 0 0\n").replace("(0, ", "0 ").replace(")", "")
    assert message(text) == "FIELD:17: '0': the molecule has beads 1 to 4"
    found = parse_field(text.replace("0 1 128", "1 2 128").replace("0 3 128", "3 4 128"))
    assert found.warnings == ("FIELD:10: a molecule has no name",)
    assert found.molecules[-1].name == ""


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "num_types 3\n25.0 30.0 50.0\n30.0 25.0 35.0\n50.0 35.0 25.0\n",
            "FIELD:1: not a DL_POLY or DL_MESO FIELD: line 1 is 'num_types 3'; expected a title, then units and "
            "molecules",
        ),
        (
            "a polymer melt\n3 10 25.0 4.5\n1 2 0.5\n",
            "FIELD:2: not a DL_POLY or DL_MESO FIELD: line 2 is '3 10 25.0 4.5'; expected a title, then units and "
            "molecules",
        ),
    ],
)
def test_files_of_other_programs(text: str, expected: str) -> None:
    assert message(text) == expected


# -- refusals ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            SPECIES + "close\n",
            "FIELD:1: 'interactions': a FIELD of DL_MESO needs a block interactions, which is missing",
        ),
        ("t\n" + PAIRS, "FIELD:3: 'A': unknown species; the molecules have none"),
        (
            SPECIES.replace("SPECIES 2", "SPECIES 3") + PAIRS,
            "FIELD:7: 'INTERACTIONS': SPECIES on line 3 says 3, but only 2 came before this; correct the number or add "
            "the missing ones",
        ),
        (
            SPECIES.replace("SPECIES 2", "SPECIES 1") + PAIRS,
            "FIELD:5: 'W': species on line 3 says 1, but here is one more; correct the number or remove the line",
        ),
        (SPECIES.replace("W 2.0", "A 2.0") + PAIRS, "FIELD:5: 'A': this species is already given on line 4"),
        (SPECIES.replace("2.0", "heavy") + PAIRS, "FIELD:5: 'heavy': expected the mass, a number"),
        (
            SPECIES.replace("-0.5 10", "-0.5 1.5") + PAIRS,
            "FIELD:5: '1.5': expected the number of beads outside molecules, a whole number of at least 0",
        ),
        (
            SPECIES.replace("-0.5 10", "-0.5 10 0 7") + PAIRS,
            "FIELD:5: '7': takes mass, charge, number and frozen flag; this is left over",
        ),
        (
            SPECIES + MOLECULE.replace("A 0.0 0.0 0.25", "B 0.0 0.0 0.25") + "finish\n" + PAIRS,
            "FIELD:12: 'B': unknown species; there are A, W",
        ),
        (
            SPECIES + MOLECULE.replace("A 0.0 0.0 0.25", "A 0.0 0.0") + "finish\n" + PAIRS,
            "FIELD:12: the line is too short; expected the coordinate z",
        ),
        (
            SPECIES + MOLECULE + "shells 1\nfinish\n" + PAIRS,
            "FIELD:13: 'shells': unknown directive inside molecule 'AA'; expected beads or finish",
        ),
        (
            SPECIES + MOLECULE + "nummols 4\nfinish\n" + PAIRS,
            "FIELD:13: 'nummols': nummols is given twice (first on line 9)",
        ),
        (
            SPECIES + MOLECULE.replace("nummols 3\n", "") + "finish\n" + PAIRS,
            "FIELD:12: 'finish': molecule 'AA' has no nummols",
        ),
        (
            SPECIES + MOLECULE + "bonds 2\nharm 1 2 100.0 0.5\nfinish\n" + PAIRS,
            "FIELD:15: 'finish': bonds on line 13 says 2, but only 1 came before this; correct the number or add the "
            "missing ones",
        ),
        (
            SPECIES + MOLECULE + "bonds 1\nwlc 1 2 1.0 0.5\nfinish\n" + PAIRS,
            "FIELD:14: 'wlc': this law is not modelled in bonds of DL_MESO's dialect; modelled are harm, fene",
        ),
        (
            SPECIES + MOLECULE + "bonds 1\nmors 1 2 1.0 0.5 2.0\nfinish\n" + PAIRS,
            "FIELD:14: 'mors': this law is not modelled in bonds of DL_MESO's dialect; modelled are harm, fene",
        ),
        (
            SPECIES + MOLECULE + "bonds 1\nfene 1 2 30.0 1.5 0.5\nfinish\n" + PAIRS,
            "FIELD:14: 'fene': takes 2 numbers (k rmax), found 3",
        ),
        (
            SPECIES + MOLECULE + "bonds 1\nharm 1 1 30.0 1.5\nfinish\n" + PAIRS,
            "FIELD:14: bead 1 appears twice in one entry of bonds",
        ),
        (
            SPECIES + PAIRS.replace("A W dpd 30.0 1.0 4.5", "A W mdpd 30.0 1.0 4.5"),
            "FIELD:9: 'mdpd': many-body DPD is read from a FIELD of DL_POLY only; here dpd, lj, wca are",
        ),
        (SPECIES + PAIRS.replace("A W dpd", "A W dpt"), "FIELD:9: 'dpt': unknown interaction; did you mean dpd?"),
        (
            SPECIES + PAIRS.replace("A W dpd 30.0", "W A dpd 30.0").replace("W W dpd", "A W dpd"),
            "FIELD:10: the pair A W is already given on line 9; remove one of the two",
        ),
        (
            SPECIES + PAIRS.replace("INTERACTIONS 3", "INTERACTIONS 4"),
            "FIELD:11: 'close': INTERACTIONS on line 7 says 4, but only 3 came before this; correct the number or add "
            "the missing ones",
        ),
        (
            SPECIES + "FROZEN\nA 1.0\n" + PAIRS,
            "FIELD:7: 'FROZEN': walls of frozen beads are not read here; a new-style CONTROL has wall_method",
        ),
        (
            SPECIES + "SURFACE 1\nA dpd 1.0\n" + PAIRS,
            "FIELD:7: 'SURFACE': walls at the faces of the box are not read here; a new-style CONTROL has wall_method",
        ),
        (SPECIES + "EXTERNAL\nshear 0.2 0 0\n" + PAIRS, "FIELD:8: 'shear': shear by sliding faces is not modelled"),
        (SPECIES + "UNITS kJ\n" + PAIRS, "FIELD:7: 'kJ': unknown energy unit; known are internal, kT"),
        (
            SPECIES + PAIRS.replace("close\n", ""),
            "FIELD:10: the file ends here; expected a further block (species, molecules, interactions, external) or "
            "close",
        ),
    ],
)
def test_refusals(text: str, expected: str) -> None:
    assert message(text) == expected


def test_lenient_takes_a_file_without_close() -> None:
    found = parse_field(SPECIES + PAIRS.replace("close\n", ""), lenient=True)
    assert found.warnings == ("FIELD:10: the file ends without close",)
