"""Broken FIELD files and the exact message each one gets."""

from __future__ import annotations

import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.field import parse_field

HEAD = "water\nunits kJ\nmolecules 1\nWATER\nnummols 2\n"
MOLECULE = HEAD + "atoms 3\nOW 16.0 -0.8\nHW 1.0 0.4 2\n"


def bonded(block: str) -> str:
    """Return a FIELD whose molecule has this block, from line 9 on."""
    return MOLECULE + block + "finish\nvdw 0\nclose\n"


def after(block: str) -> str:
    """Return a FIELD with this block after its molecule, from line 10 on."""
    return MOLECULE + "finish\n" + block + "close\n"


CASES = [
    pytest.param(
        "",
        "FIELD: not a DL_POLY or DL_MESO FIELD: the file is empty; expected a title, then units and molecules",
        id="empty file",
    ),
    pytest.param(
        "   num_types 3\n   25.0   25.0   25.0\n   25.0   25.0   25.0\n",
        "FIELD:1: not a DL_POLY or DL_MESO FIELD: line 1 is 'num_types 3'; expected a title, then units and molecules",
        id="an unrelated code's num_types matrix",
    ),
    pytest.param(
        "LLZO surface\nPOTE 1 2 3\nCELL 12.97 12.97 12.97 90 90 90\nFRAC\nLi CORE 0.1 0.2 0.3\n",
        "FIELD:2: not a DL_POLY or DL_MESO FIELD: line 2 is 'POTE 1 2 3'; expected a title, then units and molecules",
        id="METADISE output",
    ),
    pytest.param(
        "Title\n         0         1         2\ntimestep         1         2         0         1    0.001000\n",
        "FIELD:2: not a DL_POLY or DL_MESO FIELD: line 2 is '0 1 2'; expected a title, then units and molecules",
        id="HISTORY",
    ),
    pytest.param(
        "&allocation\n  nelements=2,\n  natoms=8,\n&end\n",
        "FIELD:2: not a DL_POLY or DL_MESO FIELD: line 2 is 'nelements=2,'; expected a title, then units and molecules",
        id="ShengBTE control",
    ),
    pytest.param(
        "water\nunits kJ\nmolecuels 1\nWATER\nnummols 2\natoms 1\nOW 16.0 0.0\nfinish\nclose\n",
        "FIELD:3: 'molecuels': unknown directive; expected units, molecules, vdw, rdf, extern, close; did "
        "you mean molecules?",
        id="mis-spelt molecules",
    ),
    pytest.param(
        after("vwd 1\nOW OW lj 0.65 3.16\n"),
        "FIELD:10: 'vwd': unknown directive; expected units, molecules, vdw, rdf, extern, close; did you mean vdw?",
        id="mis-spelt vdw",
    ),
    pytest.param(
        bonded("bnods 1\nharm 1 2 450.0 1.0\n"),
        "FIELD:9: 'bnods': unknown directive inside molecule 'WATER'; expected a bonded block or finish; did "
        "you mean bonds?",
        id="mis-spelt bonds",
    ),
    pytest.param(
        "water\nunits kJ\nmolecules 1\nWATER\nnumols 2\natoms 1\nOW 16.0 0.0\nfinish\nclose\n",
        "FIELD:5: 'numols': unknown directive inside molecule 'WATER'; expected a bonded block or finish; "
        "did you mean nummols?",
        id="mis-spelt nummols",
    ),
    pytest.param(
        "water\nunits kcla\nmolecules 0\nclose\n",
        "FIELD:2: 'kcla': unknown energy unit; did you mean kcal?",
        id="unknown unit",
    ),
    pytest.param(
        "water\nmolecules 1\nWATER\nnummols 2\natoms 1\nOW 16.0 0.0\nfinish\nvdw 1\nOW OW lj 0.65 3.16\nclose\n",
        "FIELD:8: 'vdw': expected a units line before the first energies",
        id="units missing",
    ),
    pytest.param(
        "water\nunits kJ\nunits eV\nmolecules 0\nclose\n",
        "FIELD:3: 'units': units is given twice (first on line 2)",
        id="units after the energies",
    ),
    pytest.param(
        MOLECULE + "finish\nmolecules 1\nX\nnummols 1\natoms 1\nX 1 0\nfinish\nclose\n",
        "FIELD:10: 'molecules': molecules is given twice (first on line 3)",
        id="molecules twice",
    ),
    pytest.param(
        "water\nunits kJ\nclose\n",
        "FIELD:1: the file has no molecules; expected units, molecules, vdw, close",
        id="no molecules",
    ),
    pytest.param(
        "water\nunits kJ\nvdw 1\nOW OW lj 0.65 3.16\nclose\n",
        "FIELD:3: 'vdw': molecules must come before this block, because they name the species",
        id="vdw before molecules",
    ),
    pytest.param(
        "water\nunits kJ\nmolecules two\nclose\n",
        "FIELD:3: 'molecules': expected the number of molecule types after this",
        id="number of molecules is a word",
    ),
    pytest.param(
        "water\nunits kJ\nmolecules 1.5\nclose\n",
        "FIELD:3: '1.5': expected the number of molecule types, a whole number",
        id="number of molecules is broken",
    ),
    pytest.param(
        "water\nunits kJ\nmolecules 1\nWATER\nnummols -2\natoms 1\nOW 16.0 0.0\nfinish\nclose\n",
        "FIELD:5: '-2': expected the number of copies, at least 0",
        id="negative nummols",
    ),
    pytest.param(
        "water\nunits kJ\nmolecules 1\nWATER\natoms 1\nOW 16.0 0.0\nfinish\nclose\n",
        "FIELD:7: 'finish': molecule 'WATER' has no nummols line (the number of its copies)",
        id="nummols missing",
    ),
    pytest.param(
        "water\nunits kJ\nmolecules 1\nWATER\nnummols 1\natoms 1\nOW 16.0 0.0\nnummols 1\nfinish\nclose\n",
        "FIELD:8: 'nummols': molecule 'WATER' has nummols twice",
        id="nummols twice",
    ),
    pytest.param(
        "water\nunits kJ\nmolecules 1\nWATER\nnummols 1\nfinish\nclose\n",
        "FIELD:6: 'finish': molecule 'WATER' has no atoms",
        id="atoms missing",
    ),
    pytest.param(
        "water\nunits kJ\nmolecules 1\nWATER\nnummols 1\natoms 0\nfinish\nclose\n",
        "FIELD:6: '0': expected the number of beads in one molecule, at least 1",
        id="atoms 0",
    ),
    pytest.param(
        HEAD + "atoms 3\nOW 16.0 -0.8\nHW 1.0 0.4\nfinish\nclose\n",
        "FIELD:9: 'finish': expected an atom line (atoms on line 6 says 3 beads, 2 so far)",
        id="too few atom lines",
    ),
    pytest.param(
        HEAD + "atoms 1\nOW 16.0 -0.8\nHW 1.0 0.4\nfinish\nclose\n",
        "FIELD:8: 'HW': atoms on line 6 says 1, but here is one more; correct the number or remove the line",
        id="too many atom lines",
    ),
    pytest.param(
        HEAD + "atoms 2\nOW 16.0 -0.8\nHW 1.0 0.4 2\nfinish\nclose\n",
        "FIELD:8: the atom lines make up 3 beads, but atoms on line 6 says 2",
        id="repeats exceed atoms",
    ),
    pytest.param(
        HEAD + "atoms 1\nOW sixteen -0.8\nfinish\nclose\n",
        "FIELD:7: 'sixteen': expected the mass, a number",
        id="mass is no number",
    ),
    pytest.param(
        HEAD + "atoms 1\nOW\nfinish\nclose\n",
        "FIELD:7: the line is too short; expected the mass",
        id="mass missing",
    ),
    pytest.param(
        HEAD + "atoms 1\nOW 16.0 -0.8O\nfinish\nclose\n",
        "FIELD:7: '-0.8O': expected the charge, a number",
        id="charge with a letter O",
    ),
    pytest.param(
        HEAD + "atoms 1\nOW 16.0 -0.8 1.5\nfinish\nclose\n",
        "FIELD:7: '1.5': the repeat count must be a whole number, not negative",
        id="repeat is fractional",
    ),
    pytest.param(
        HEAD + "atoms 1\nOW 16.0 -0.8 1 0.5\nfinish\nclose\n",
        "FIELD:7: '0.5': the frozen flag must be a whole number (0 moves, 1 is frozen)",
        id="frozen is fractional",
    ),
    pytest.param(
        HEAD + "atoms 1\nOW 16.0 -0.8 1 0 1 7\nfinish\nclose\n",
        "FIELD:7: '7': an atom line has at most five numbers (mass, charge, repeat, frozen, group)",
        id="six numbers after the name",
    ),
    pytest.param(
        HEAD + "atoms 1\nOW NaN 0.0\nfinish\nclose\n",
        "FIELD:7: 'NaN': expected the mass, a number",
        id="mass NaN",
    ),
    pytest.param(
        HEAD + "atoms 2\nSolventAB 16.0 0.0\nSolventAC 16.0 0.0\nfinish\nclose\n",
        "FIELD:8: 'SolventAC': only 8 characters of a species name count, and 'SolventAB' has the same ones",
        id="long names with the same beginning",
    ),
    pytest.param(
        MOLECULE + "vdw 1\nOW OW lj 0.65 3.16\nclose\n",
        "FIELD:9: 'vdw': expected finish, which ends molecule 'WATER' (begun on line 4), before this",
        id="finish missing before vdw",
    ),
    pytest.param(
        MOLECULE,
        "FIELD:8: the file ends here; expected finish, which ends molecule 'WATER' (begun on line 4)",
        id="finish missing at the end",
    ),
    pytest.param(
        MOLECULE + "finish\nvdw 1\nOW OW lj 0.65 3.16\n",
        "FIELD:11: the file ends here; expected a further block (vdw, rdf, extern, …) or close",
        id="close missing",
    ),
    pytest.param(
        "water\nunits kJ\nmolecules 2\nWATER\nnummols 2\natoms 1\nOW 16.0 0.0\nfinish\nvdw 1\n"
        "OW OW lj 0.65 3.16\nclose\n",
        "FIELD:9: 'vdw': expected the name of molecule 2 of 2 (molecules on line 3)",
        id="fewer molecules than said",
    ),
    pytest.param(
        MOLECULE + "finish\nSALT\nnummols 2\natoms 1\nNA 23.0 1.0\nfinish\nclose\n",
        "FIELD:10: 'SALT': this looks like a molecule, but molecules on line 3 says 1, and so many have come before",
        id="more molecules than said",
    ),
    pytest.param(
        after("bonds 1\nharm 1 2 450.0 1.0\n"),
        "FIELD:10: 'bonds': this directive belongs inside a molecule, between its name and finish",
        id="bonds outside a molecule",
    ),
    pytest.param(
        MOLECULE + "neutral groups\nfinish\nclose\n",
        "FIELD:9: 'neutral': neutral (charge) groups are not known to DL_POLY 4 and later",
        id="charge groups",
    ),
    pytest.param(
        bonded("bonds 1\nharn 1 2 450.0 1.0\n"),
        "FIELD:10: 'harn': unknown key in bonds; did you mean harm?",
        id="unknown bond key",
    ),
    pytest.param(
        bonded("angles 1\n-fene 1 2 3 4.0\n"),
        "FIELD:10: '-fene': unknown key in angles; known are -bv1 -bv2 -cmp -cos -hcs -hrm -kky -mbd -msb "
        "-qur -shm -stb -sts -tab -thm bvs1 bvs2 cmps cos harm hcos kky mmbd mmsb quar shrm stbe stst tab "
        "thrm",
        id="unknown restraint key",
    ),
    pytest.param(
        bonded("bonds 1\nharm 1 4 450.0 1.0\n"),
        "FIELD:10: '4': the molecule has beads 1 to 3",
        id="bond to a bead outside",
    ),
    pytest.param(
        bonded("bonds 1\nharm 0 1 450.0 1.0\n"),
        "FIELD:10: '0': the molecule has beads 1 to 3",
        id="bond to bead 0",
    ),
    pytest.param(
        bonded("bonds 1\nharm 2 2 450.0 1.0\n"),
        "FIELD:10: bead 2 appears twice in one entry of bonds",
        id="bond of a bead with itself",
    ),
    pytest.param(
        bonded("bonds 2\nharm 1 2 450.0 1.0\nmors 2 1 4.0 1.0 2.0\n"),
        "FIELD:11: the same beads are listed in bonds on line 10",
        id="bond given twice",
    ),
    pytest.param(
        bonded("angles 1\nharm 1 2 1 450.0 1.0\n"),
        "FIELD:10: bead 1 appears twice in one entry of angles",
        id="angle with one bead twice",
    ),
    pytest.param(
        bonded("angles 2\nharm 1 2 3 450.0 1.0\nharm 3 2 1 450.0 1.0\n"),
        "FIELD:11: the same beads are listed in angles on line 10",
        id="angle given twice",
    ),
    pytest.param(
        HEAD + "atoms 4\nC 12.0 0.0 4\ninversions 2\nharm 1 2 3 4 1.0 0.0\nharm 1 4 2 3 1.0 0.0\nfinish\nclose\n",
        "FIELD:10: the same beads are listed in inversions on line 9",
        id="inversion given twice",
    ),
    pytest.param(
        bonded("bonds 1\nharm 1 2 450.0 1.0\nbonds 1\nharm 1 3 450.0 1.0\n"),
        "FIELD:11: 'bonds': molecule 'WATER' has bonds twice (first on line 9)",
        id="bonds twice",
    ),
    pytest.param(
        bonded("bonds 1\nharm (1, 2) 450.0 1.0\n"),
        "FIELD:10: '(1,': expected a bead number (a whole number, counted from 1 within the molecule)",
        id="Python tuples as bead numbers",
    ),
    pytest.param(
        bonded("bonds 1\nharm 1\n"),
        "FIELD:10: the line is too short; expected 2 bead numbers",
        id="bead number missing",
    ),
    pytest.param(
        bonded("bonds 1\nharm 1 2 45O.0 1.0\n"),
        "FIELD:10: '45O.0': expected a number",
        id="bond number damaged",
    ),
    pytest.param(
        bonded("bonds 2\nharm 1 2 450.0 1.0\n"),
        "FIELD:11: 'finish': bonds on line 9 says 2, but only 1 came before this; correct the number or add "
        "the missing ones",
        id="fewer bonds than said",
    ),
    pytest.param(
        bonded("bonds 1\nharm 1 2 450.0 1.0\nharm 1 3 450.0 1.0\n"),
        "FIELD:11: 'harm': bonds on line 9 says 1, but here is one more; correct the number or remove the line",
        id="more bonds than said",
    ),
    pytest.param(
        bonded("constraints 2\n1 2 1.0\n"),
        "FIELD:11: 'finish': constraints on line 9 says 2, but only 1 came before this; correct the number "
        "or add the missing ones",
        id="fewer constraints than said",
    ),
    pytest.param(
        bonded("constraints 1\n1 2 1.0\n1 3 1.0\n"),
        "FIELD:11: '1': constraints on line 9 says 1, but here is one more; correct the number or remove the line",
        id="more constraints than said",
    ),
    pytest.param(
        bonded("constraints 1\n1 2\n"),
        "FIELD:10: expected the length after the two bead numbers",
        id="constraint without a length",
    ),
    pytest.param(
        bonded("rigid 1\n1 2\n"),
        "FIELD:10: '1': a rigid unit has at least two beads",
        id="rigid unit of one bead",
    ),
    pytest.param(
        bonded("rigid 1\n3 1 2\n"),
        "FIELD:11: 'finish': expected bead number 3 of 3 of the rigid unit",
        id="rigid unit cut short",
    ),
    pytest.param(
        bonded("rigid 1\n2 1 2 3\n"),
        "FIELD:10: '3': the rigid unit says 2 beads, but more numbers follow",
        id="rigid unit with too many beads",
    ),
    pytest.param(
        bonded("rigid 2\n2 1 2\n2 2 3\n"),
        "FIELD:11: bead 2 is already in the rigid unit on line 10",
        id="bead in two rigid units",
    ),
    pytest.param(
        bonded("pmf\npmf unit 1\n1\npmf unit 1\n2\n"),
        "FIELD:9: 'pmf': expected the constraint's length, a positive number, after pmf",
        id="pmf without a length",
    ),
    pytest.param(
        bonded("pmf 1.5\npmf unit 1\n1 1.0\n"),
        "FIELD:12: 'finish': expected 'pmf unit' and its number of beads (unit 2 of 2)",
        id="pmf with one unit",
    ),
    pytest.param(
        bonded("pmf 1.5\npmf unit 2\n1\n2\npmf unit 1\n2\n"),
        "FIELD:9: the two pmf units share a bead",
        id="pmf units share a bead",
    ),
    pytest.param(
        bonded("teth 1\nfene 1 5.0\n"),
        "FIELD:10: 'fene': unknown key in tethers; known are harm quar rhrm",
        id="tether key",
    ),
    pytest.param(
        after("vdw 1\nOW HX lj 0.65 3.16\n"),
        "FIELD:11: 'HX': unknown species; the molecules have OW, HW",
        id="species unknown in vdw",
    ),
    pytest.param(
        after("vdw 1\nOW hw lj 0.65 3.16\n"),
        "FIELD:11: 'hw': unknown species; did you mean HW?",
        id="species in another case",
    ),
    pytest.param(
        after("vdw 1\nOW OW ljj 0.65 3.16\n"),
        "FIELD:11: 'ljj': unknown pair law; did you mean lj, mlj, ljf?",
        id="unknown pair law",
    ),
    pytest.param(
        after("vdw 2\nOW HW lj 0.65 3.16\nHW OW lj 0.70 3.16\n"),
        "FIELD:12: the pair HW OW is already given on line 11; remove one of the two",
        id="pair given twice",
    ),
    pytest.param(
        after("vdw 1\nOW HW\n"),
        "FIELD:11: the line is too short; expected two species, the pair law's key and its numbers",
        id="pair line too short",
    ),
    pytest.param(
        after("vdw 1\nOW HW lj 0.65 3.1.6\n"),
        "FIELD:11: '3.1.6': expected a number",
        id="pair number damaged",
    ),
    pytest.param(
        after("vdw 1\nOW HW lj 0.65 inf\n"),
        "FIELD:11: 'inf': expected a number",
        id="pair number infinite",
    ),
    pytest.param(
        after("vdw 1\nOW HW lj 0.65 1e999\n"),
        "FIELD:11: '1e999': expected a number",
        id="pair number too large",
    ),
    pytest.param(
        after("vdw 2\nOW HW lj 0.65 3.16\n"),
        "FIELD:12: 'close': vdw on line 10 says 2, but only 1 came before this; correct the number or add "
        "the missing ones",
        id="fewer pairs than said",
    ),
    pytest.param(
        after("vdw 1\nOW HW lj 0.65 3.16\nOW OW lj 0.65 3.16\n"),
        "FIELD:12: 'OW': vdw on line 10 says 1, but here is one more pair; correct the number or remove the line",
        id="more pairs than said",
    ),
    pytest.param(
        after("vdw 1\nOW HW lj 0.65 3.16\nvdw 1\nOW OW lj 0.65 3.16\n"),
        "FIELD:12: 'vdw': vdw is given twice (first on line 10)",
        id="vdw twice",
    ),
    pytest.param(
        after("rdf 2\nOW HW\nHW OW\n"),
        "FIELD:12: the pair HW OW is already given on line 11",
        id="rdf pair twice",
    ),
    pytest.param(
        after("rdf 1\nOW XX\n"),
        "FIELD:11: 'XX': unknown species; the molecules have OW, HW",
        id="rdf species unknown",
    ),
    pytest.param(
        after("extern\ngrvy 0 0 -1\n"),
        "FIELD:11: 'grvy': unknown external field; did you mean grav?",
        id="external field unknown",
    ),
    pytest.param(
        MOLECULE + "finish\nextern\n",
        "FIELD:10: the file ends here; expected the external field's key and numbers (extern on line 10)",
        id="external field without its line",
    ),
]


@pytest.mark.parametrize(("text", "message"), CASES)
def test_broken_file_gets_this_message(text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_field(text)
    assert str(caught.value) == message


BLOCKS = {
    "shell": ("1 2 10.0", "shells"),
    "constraints": ("1 2 1.0", "constraints"),
    "bonds": ("tab 1 2", "bonds"),
    "angles": ("-tab 1 2 3", "angles"),
    "dihedrals": ("tab 1 2 3 4", "dihedrals"),
    "inversions": ("-tab 1 2 3 4", "inversions"),
    "teth": ("harm 1 2.0", "tethers"),
}
FOUR = "t\nunits kJ\nmolecules 1\nM\nnummols 1\natoms 4\nA 1 0 3\nB 1 0\n"


def refused(text: str) -> str:
    with pytest.raises(InputError) as caught:
        parse_field(FOUR + text + "finish\nclose\n")
    return str(caught.value)


@pytest.mark.parametrize("word", BLOCKS)
def test_every_block_of_a_molecule(word: str) -> None:
    """Errors 27, 33, 66 to 68, 620, 36 and its likes, and wrong numbers of lines."""
    line, name = BLOCKS[word]
    for bead in ("0", "5"):
        outside = line.replace(" 1", f" {bead}", 1) if not line.startswith("1") else line.replace("1", bead, 1)
        assert refused(f"{word} 1\n{outside}\n") == f"FIELD:10: '{bead}': the molecule has beads 1 to 4"
    if name != "tethers":
        twice = line.replace("1 2", "2 2", 1)
        assert refused(f"{word} 1\n{twice}\n") == f"FIELD:10: bead 2 appears twice in one entry of {name}"
    if name == "dihedrals":
        warnings = parse_field(FOUR + f"{word} 2\n{line}\n{line}\nfinish\nclose\n").warnings
        assert [w for w in warnings if "they add up" in w]
    else:
        again = f"FIELD:11: the same beads are listed in {name} on line 10"
        assert refused(f"{word} 2\n{line}\n{line}\n") == again
    assert refused(f"{word} 1\n{line}\n{word} 1\n{line}\n") == (
        f"FIELD:11: '{word}': molecule 'M' has {name} twice (first on line 9)"
    )
    assert refused(f"{word} 2\n{line}\n") == (
        f"FIELD:11: 'finish': {name} on line 9 says 2, but only 1 came before this; correct the number or add the "
        "missing ones"
    )
    first = line.split()[0]
    assert refused(f"{word} 1\n{line}\n{line}\n") == (
        f"FIELD:11: '{first}': {name} on line 9 says 1, but here is one more; correct the number or remove the line"
    )
