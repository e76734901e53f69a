"""The FIELD block ``extension heat``: what is read, and how wrong lines are refused."""

from __future__ import annotations

import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.heat_block import OPEN, CapacityLine, HeatBlock, HeatPairLine, SourceLine, read_heat
from pydlpoly.formats.records import Extension


def read(*lines: str) -> HeatBlock:
    return read_heat(Extension("heat", tuple(enumerate(lines, 11)), 10), "FIELD", ("A", "wall"))


def test_every_line_is_read() -> None:
    block = read(
        "capacity A 1d5 temperature 300",
        "CAPACITY wall 10",
        "pair wall A kappa 1.5 range 2.0 exponent 1.5 power 1 2 3 4 conductivity 5 6 7 8 drag 9 10 11 12",
        "region middle layer y -1 1",
        "source region middle 0.5",
        "source box 0 1 0 2 0 3 -0.5",
        "source sphere 0 0 1 2.5 0.25",
        "source species A 7",
        "wall wall 350",
        "viscous_heating lammps",
        "repulsion scaled",
    )
    assert block == HeatBlock(
        capacities=(CapacityLine("A", 1e5, 300.0), CapacityLine("wall", 10.0)),
        pairs=(HeatPairLine(("wall", "A"), 1.5, 2.0, 1.5, (1, 2, 3, 4), (5, 6, 7, 8), (9, 10, 11, 12)),),
        sources=(
            SourceLine("box", (-OPEN, OPEN, -1.0, 1.0, -OPEN, OPEN), 0.5),
            SourceLine("box", (0.0, 1.0, 0.0, 2.0, 0.0, 3.0), -0.5),
            SourceLine("sphere", (0.0, 0.0, 1.0, 2.5), 0.25),
            SourceLine("species", (), 7.0, "A"),
        ),
        walls=block.walls,
        viscous_heating="lammps",
        repulsion="scaled",
    )
    assert [(wall.species, wall.temperature, wall.line) for wall in block.walls] == [("wall", 350.0, 19)]
    assert block.lines["repulsion"] == 21


@pytest.mark.parametrize(
    ("line", "word", "message"),
    [
        ("capacitance A 1", "capacitance", "did you mean capacity?"),
        ("capacity", None, "expected a species"),
        ("capacity B 1", "B", "there are A, wall"),
        ("capacity A", None, "expected a heat capacity"),
        ("capacity A 1e", "1e", "expected a heat capacity, a number"),
        ("capacity A 1 300", "300", "expected a word: temperature"),
        ("capacity A 1 temperature 300 K", "K", "more than the line takes"),
        ("pair A A kappa 1 kappa 2", "kappa", "given twice on one line"),
        ("pair A A power 1 2 3", None, "coefficient 4 of 4 of power"),
        ("pair A A cutoff 1", "cutoff", "kappa, range, exponent"),
        ("source region hot 1", "hot", "there are none"),
        ("source layer w 0 1 1", "w", "an axis: x, y, z"),
        ("source sphere 0 0 0 1", None, "expected a rate"),
        ("viscous_heating none", "none", "conserving, lammps"),
        ("repulsion", None, "constant, scaled"),
        ("wall A hot", "hot", "expected a temperature, a number"),
    ],
)
def test_wrong_lines_are_refused_with_their_place(line: str, word: str | None, message: str) -> None:
    with pytest.raises(InputError) as refusal:
        read("capacity wall 1", line)
    assert refusal.value.path == "FIELD"
    assert refusal.value.line == 12
    assert refusal.value.word == word
    assert message in str(refusal.value)


@pytest.mark.parametrize("line", ["capacity A 1", "wall A 2", "pair A wall kappa 1", "repulsion constant"])
def test_nothing_is_given_twice(line: str) -> None:
    with pytest.raises(InputError, match=r"FIELD:12: .* is given twice \(first on line 11\)"):
        read(line, line)
