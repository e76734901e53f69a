"""Broken CONFIG files and the exact message each one gets."""

from __future__ import annotations

import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.config import parse_config

CELL = "10.0 0.0 0.0\n0.0 10.0 0.0\n0.0 0.0 10.0\n"
TWO = "OW 1\n1.0 2.0 3.0\nHW 2\n4.0 5.0 6.0\n"
MOVING = "OW 1\n1.0 2.0 3.0\n0.1 0.2 0.3\nHW 2\n4.0 5.0 6.0\n0.4 0.5 0.6\n"


def beads(indices: list[int]) -> str:
    """Return a CONFIG whose beads have these indices."""
    return "t\n0 0\n" + "".join(f"A {index}\n0.0 0.0 0.0\n" for index in indices)


CASES = [
    pytest.param(
        "",
        "CONFIG: not a DL_POLY CONFIG: the file is empty",
        id="empty file",
    ),
    pytest.param(
        "water\n",
        "CONFIG:2: not a DL_POLY CONFIG: line 2 is ''; expected a title, then a line with levcfg and imcon "
        "(two whole numbers)",
        id="only a title",
    ),
    pytest.param(
        "0 1 2\n" + CELL + TWO,
        "CONFIG:1: line 1 must be a title, but looks like levcfg and imcon; expected a title, then a line "
        "with levcfg and imcon (two whole numbers)",
        id="title line missing",
    ),
    pytest.param(
        "water\nlevcfg imcon\n" + CELL + TWO,
        "CONFIG:2: not a DL_POLY CONFIG: line 2 is 'levcfg imcon'; expected a title, then a line with levcfg "
        "and imcon (two whole numbers)",
        id="line 2 is text",
    ),
    pytest.param(
        "water\n0\n" + CELL + TWO,
        "CONFIG:2: not a DL_POLY CONFIG: line 2 is '0'; expected a title, then a line with levcfg and imcon "
        "(two whole numbers)",
        id="line 2 has one number",
    ),
    pytest.param(
        "water\n0.0 1.0\n" + CELL + TWO,
        "CONFIG:2: not a DL_POLY CONFIG: line 2 is '0.0 1.0'; expected a title, then a line with levcfg and "
        "imcon (two whole numbers)",
        id="line 2 has reals",
    ),
    pytest.param(
        "Title\ntimestep         1      1         0         3    0.001000\n" + CELL + "CA 1 40.08 2.0\n1.00 1.00 1.00",
        "CONFIG:2: not a DL_POLY CONFIG: line 2 is 'timestep 1 1 0 3 0.001000', as in a HISTORY trajectory",
        id="HISTORY without a header",
    ),
    pytest.param(
        "Title\n         0         1         2\n"
        "timestep         1         2         0         1    0.001000\n" + CELL + TWO,
        "CONFIG:3: not a DL_POLY CONFIG: line 3 is 'timestep 1 2 0 1 0.001000', as in a HISTORY trajectory",
        id="HISTORY",
    ),
    pytest.param(
        "LLZO surface\nPOTE 1 2 3\nCELL 12.97 12.97 12.97 90 90 90\nFRAC\nLi CORE 0.1 0.2 0.3\n",
        "CONFIG:2: not a DL_POLY CONFIG: line 2 is 'POTE 1 2 3'; expected a title, then a line with levcfg "
        "and imcon (two whole numbers)",
        id="METADISE output",
    ),
    pytest.param(
        "&allocation\n  nelements=2,\n  natoms=8,\n&end\n",
        "CONFIG:2: not a DL_POLY CONFIG: line 2 is 'nelements=2,'; expected a title, then a line with levcfg "
        "and imcon (two whole numbers)",
        id="ShengBTE control",
    ),
    pytest.param(
        "water\nunits kJ\nmolecules 1\nWATER\n",
        "CONFIG:2: not a DL_POLY CONFIG: line 2 is 'units kJ'; expected a title, then a line with levcfg and "
        "imcon (two whole numbers)",
        id="FIELD",
    ),
    pytest.param(
        "water\n3 1\n" + CELL + TWO,
        "CONFIG:2: '3': levcfg must be 0 (positions), 1 (and velocities) or 2 (and forces)",
        id="levcfg 3",
    ),
    pytest.param(
        "water\n-1 1\n" + CELL + TWO,
        "CONFIG:2: '-1': levcfg must be 0 (positions), 1 (and velocities) or 2 (and forces)",
        id="levcfg negative",
    ),
    pytest.param(
        "water\n0 4\n" + CELL + TWO,
        "CONFIG:2: imcon 4 (truncated octahedron) is not supported by DL_POLY 4 and later; expected 0, 1, 2, 3 or 6",
        id="imcon 4",
    ),
    pytest.param(
        "water\n0 5\n" + CELL + TWO,
        "CONFIG:2: imcon 5 (rhombic dodecahedron) is not supported by DL_POLY 4 and later; expected 0, 1, 2, 3 or 6",
        id="imcon 5",
    ),
    pytest.param(
        "water\n0 7\n" + CELL + TWO,
        "CONFIG:2: imcon 7 (hexagonal prism) is not supported by DL_POLY 4 and later; expected 0, 1, 2, 3 or 6",
        id="imcon 7",
    ),
    pytest.param(
        "water\n0 8\n" + CELL + TWO,
        "CONFIG:2: '8': imcon must be 0 (none), 1 (cubic), 2 (orthorhombic), 3 (parallelepiped) or 6 (slab)",
        id="imcon 8",
    ),
    pytest.param(
        "water\n0 1\n" + TWO,
        "CONFIG:3: 'OW': expected x of the cell vector a (imcon 1), a finite number",
        id="cell missing",
    ),
    pytest.param(
        "water\n0 3\n10.0 0.0 0.0\n0.0 10.0 0.0\n",
        "CONFIG:4: the file ends here; expected cell vector c (imcon 3)",
        id="cell cut short",
    ),
    pytest.param(
        "water\n0 3\n10.0 0.0 0.0\n0.0 10.0\n0.0 0.0 10.0\n" + TWO,
        "CONFIG:4: expected three numbers, the cell vector b (imcon 3); found 2",
        id="cell vector of two numbers",
    ),
    pytest.param(
        "water\n0 3\n10.0 0.0 0.0\n0.0 nan 0.0\n0.0 0.0 10.0\n" + TWO,
        "CONFIG:4: 'nan': expected y of the cell vector b (imcon 3), a finite number",
        id="cell with NaN",
    ),
    pytest.param(
        "water\n0 1\n" + CELL,
        "CONFIG:5: the file ends here; expected the first bead's name",
        id="no beads",
    ),
    pytest.param(
        "water\n0 0\n\n\n",
        "CONFIG:4: the file ends here; expected the first bead's name",
        id="no beads but blank lines",
    ),
    pytest.param(
        "water\n0 0\nOW 1\n1.0 2.0 3.0\nHW 2\n4.0 5.O 6.0\n",
        "CONFIG:6: '5.O': expected y of the position of bead 2 (HW), a finite number",
        id="position damaged",
    ),
    pytest.param(
        "water\n0 0\nOW 1\n1.0 2.0\nHW 2\n4.0 5.0 6.0\n",
        "CONFIG:4: expected three numbers, the position of bead 1 (OW); found 2",
        id="position of two numbers",
    ),
    pytest.param(
        "water\n0 0\nOW 1\n1.0 2.0 NaN\n",
        "CONFIG:4: 'NaN': expected z of the position of bead 1 (OW), a finite number",
        id="position NaN",
    ),
    pytest.param(
        "water\n0 0\nOW 1\nInfinity 2.0 3.0\n",
        "CONFIG:4: 'Infinity': expected x of the position of bead 1 (OW), a finite number",
        id="position infinite",
    ),
    pytest.param(
        "water\n0 0\nOW 1\n1.0 2e999 3.0\n",
        "CONFIG:4: '2e999': expected y of the position of bead 1 (OW), a finite number",
        id="position too large",
    ),
    pytest.param(
        "water\n0 0\nOW 1\n1.0 2_0.0 3.0\n",
        "CONFIG:4: '2_0.0': expected y of the position of bead 1 (OW), a finite number",
        id="position with an underscore",
    ),
    pytest.param(
        "water\n0 0\nOW 1\n-101.25-102.25 3.0 4.0\n",
        "CONFIG:4: '-101.25-102.25': expected x of the position of bead 1 (OW), a finite number",
        id="numbers run together",
    ),
    pytest.param(
        "water\n1 0\nOW 1\n1.0 2.0 3.0\n0.0 ******** 0.0\n",
        "CONFIG:5: '********': expected y of the velocity of bead 1 (OW), a finite number (levcfg 1 means 3 "
        "lines a bead)",
        id="stars in a number",
    ),
    pytest.param(
        "water\n1 1\n" + CELL + TWO,
        "CONFIG:8: 'HW': expected x of the velocity of bead 1 (OW), a finite number (levcfg 1 means 3 lines a bead)",
        id="velocities announced, none there",
    ),
    pytest.param(
        "water\n0 1\n" + CELL + MOVING,
        "CONFIG:8: '0.1': expected the name of bead 2, found three numbers (levcfg 0 means 2 lines a bead)",
        id="velocities there, none announced",
    ),
    pytest.param(
        "water\n2 1\n" + CELL + MOVING,
        "CONFIG:9: 'HW': expected x of the force of bead 1 (OW), a finite number (levcfg 2 means 4 lines a bead)",
        id="forces announced, none there",
    ),
    pytest.param(
        "water\n0 0\n" + TWO + "HW 3\n",
        "CONFIG:7: the file ends inside bead 3 (HW); expected its position (levcfg 0 means 2 lines a bead)",
        id="ends after a name",
    ),
    pytest.param(
        "water\n1 0\n" + MOVING + "HW 3\n1.0 2.0 3.0\n",
        "CONFIG:10: the file ends inside bead 3 (HW); expected its velocity (levcfg 1 means 3 lines a bead)",
        id="ends before a velocity",
    ),
    pytest.param(
        "water\n2 0\nOW 1\n1.0 2.0 3.0\n0.1 0.2 0.3\n",
        "CONFIG:5: the file ends inside bead 1 (OW); expected its force (levcfg 2 means 4 lines a bead)",
        id="ends before a force",
    ),
    pytest.param(
        "water\n0 0\n" + TWO + "HW 3\n1.0 2.0\n",
        "CONFIG:8: expected three numbers, the position of bead 3 (HW); found 2",
        id="ends within a position",
    ),
    pytest.param(
        "water\n0 0\nOW 1\n1.0 2.0 3.0\n\nHW 2\n4.0 5.0 6.0\n",
        "CONFIG:5: blank line among the beads (bead 2); expected a name or three numbers",
        id="blank line between beads",
    ),
    pytest.param(
        "water\n0 0\nOW 1\n\n1.0 2.0 3.0\n",
        "CONFIG:4: blank line among the beads (bead 1); expected a name or three numbers",
        id="blank line within a bead",
    ),
    pytest.param(
        "water\n0 0\n" + TWO + "\nwritten by hand\n",
        "CONFIG:7: blank line among the beads (bead 3); expected a name or three numbers",
        id="remark after the last bead",
    ),
    pytest.param(
        beads([1, 2, 2]),
        "CONFIG:7: bead index 2 is also on line 5; expected 1 to 3 once each (or ignore the indices, which "
        "takes the order of the file)",
        id="index twice",
    ),
    pytest.param(
        beads([1, 1, 1]),
        "CONFIG:5: bead index 1 is also on line 3; expected 1 to 3 once each (or ignore the indices, which "
        "takes the order of the file)",
        id="index 1 for all",
    ),
    pytest.param(
        beads([1, 2, 4]),
        "CONFIG:7: this bead index is larger than the number of beads; expected 1 to 3 once each (or ignore "
        "the indices, which takes the order of the file)",
        id="index gap",
    ),
    pytest.param(
        beads([2, 0, 3]),
        "CONFIG:5: bead index 2 is also on line 3; expected 1 to 3 once each (or ignore the indices, which "
        "takes the order of the file)",
        id="index 0 among others",
    ),
    pytest.param(
        beads([1, 99999999999999999999]),
        "CONFIG:5: this bead index is larger than the number of beads; expected 1 to 2 once each (or ignore "
        "the indices, which takes the order of the file)",
        id="index huge",
    ),
    pytest.param(
        "t\n0 0\nSolventAB 1\n0.0 0.0 0.0\nSolventAC 2\n0.0 0.0 0.0\n",
        "CONFIG:5: 'SolventAC': only 8 characters of a name count, and 'SolventAB' has the same ones",
        id="long names with the same beginning",
    ),
]


@pytest.mark.parametrize(("text", "message"), CASES)
def test_broken_file_gets_this_message(text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_config(text)
    assert str(caught.value) == message
