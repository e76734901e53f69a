"""The block ``extension transport`` of FIELD: what is read, what is refused and with which words."""

from __future__ import annotations

import math

import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.records import Extension
from pydlpoly.formats.transport_block import (
    FluxLine,
    ReactionLine,
    RegionWords,
    TransportBlock,
    ValueLine,
    read_transport,
)


def read(*lines: str) -> TransportBlock:
    numbered = tuple((number, line) for number, line in enumerate(lines, 11))
    return read_transport(Extension("transport", numbered, 10), "FIELD")


def test_every_kind_of_line() -> None:
    block = read(
        "species sugar salt",
        "pair W W sugar kappa 1.0 range 1.58 exponent 2.0 noise 1e-5",
        "pair * * salt range 1.2 kappa 3",
        "noise lammps",
        "start sugar 1.0",
        "start sugar 2.0 in W",
        "start salt 0.5 box -1 1 * 0.0 * *",
        "source sugar -0.01 sphere 1 2 3 4",
        "hold salt 1.5 in WALL",
        "reaction 0.5 sugar -> salt",
        "reaction 2.0 sugar + salt -> 2 salt in W",
        "reaction 0.1 2 salt -> none",
    )
    free = math.inf
    assert block == TransportBlock(
        species=("sugar", "salt"),
        fluxes=(
            FluxLine(("W", "W"), "sugar", 1.0, 1.58, 2.0, 1e-5),
            FluxLine(("*", "*"), "salt", 3.0, 1.2, 2.0, 0.0),
        ),
        starts=(
            ValueLine("sugar", 1.0, RegionWords()),
            ValueLine("sugar", 2.0, RegionWords("in", "W")),
            ValueLine("salt", 0.5, RegionWords("box", "", (-1.0, 1.0, -free, 0.0, -free, free))),
        ),
        sources=(ValueLine("sugar", -0.01, RegionWords("sphere", "", (1.0, 2.0, 3.0, 4.0))),),
        holds=(ValueLine("salt", 1.5, RegionWords("in", "WALL")),),
        reactions=(
            ReactionLine(0.5, ((1, "sugar"),), ((1, "salt"),)),
            ReactionLine(2.0, ((1, "sugar"), (1, "salt")), ((2, "salt"),), "W"),
            ReactionLine(0.1, ((2, "salt"),), ()),
        ),
        noise="lammps",
    )
    assert [reaction.equation for reaction in block.reactions] == [
        "sugar -> salt",
        "sugar + salt -> 2 salt",
        "2 salt -> none",
    ]
    assert block.fluxes[1].line == 13


@pytest.mark.parametrize(
    ("line", "word", "says"),
    [
        ("species", "species", "expected the names"),
        ("species 2a", "2a", "is no name for a dissolved species"),
        ("species none", "none", "is no name"),
        ("species a a", "a", "named twice"),
        ("pairs W W a kappa 1 range 1", "pairs", "did you mean pair?"),
        ("pair W * a kappa 1 range 1", "*", "* twice"),
        ("pair W W", "pair", "too short; expected a dissolved species"),
        ("pair W W c kappa 1 range 1", "c", "is no dissolved species; there are a, b"),
        ("pair W W a kapa 1 range 1", "kapa", "did you mean kappa?"),
        ("pair W W a kappa one range 1", "one", "expected the number of kappa, a number"),
        ("pair W W a kappa 1", "pair", "lacks range"),
        ("pair W W a kappa 1 kappa 2 range 1", "kappa", "twice on this line"),
        ("pair W W a kappa -1 range 1", "-1", "must not be negative"),
        ("pair W W a kappa 1 range 0", "0", "must be larger than 0"),
        ("pair V U a kappa 1 range 1 exponent 0", "0", "must be larger than 0"),
        ("pair V U a kappa 1 range 1 noise -1", "-1", "must not be negative"),
        ("noise root", "root", "expected sqrt, lammps, off"),
        ("noise sqrt 1.0", "1.0", "end of the line"),
        ("start a", "start", "expected the concentration"),
        ("start a -1.0", "-1.0", "must not be negative"),
        ("start a 1.0 in", "start", "expected a bead species"),
        ("start a 1.0 at W", "at", "expected nothing, everywhere, in BEADSPECIES"),
        ("start a 1.0 everywhere else", "else", "end of the line"),
        ("source a 1.0 box 0 1 0 1 0", "source", "too short"),
        ("source a 1.0 box 0 1 0 1 1 1", "box", "along z"),
        ("source a 1.0 sphere 0 0 0 0", "0", "larger than 0"),
        ("hold a 1.0", "hold", "expected 'in' and a bead species"),
        ("reaction -1 a -> b", "-1", "must not be negative"),
        ("reaction 1 a b", "reaction", "expected one '->'"),
        ("reaction 1 none -> b", "reaction", "one or two species on the left"),
        ("reaction 1 2 a + b -> b", "reaction", "one or two species on the left"),
        ("reaction 1 a -> 0.5 b", "0.5", "whole number from 1 on"),
        ("reaction 1 a -> c", "c", "is no dissolved species"),
        ("reaction 1 a + -> b", "+", "expected dissolved species"),
        ("reaction 1 a a a -> b", "a a a", "expected dissolved species"),
        ("reaction 1 2 a -> 3 a", "->", "runs away in finite time"),
        ("reaction 1 a + b -> 2 a + 2 b", "->", "runs away in finite time"),
    ],
)
def test_refusals_name_line_and_word(line: str, word: str, says: str) -> None:
    with pytest.raises(InputError) as refused:
        read(*([] if line.startswith("species") else ["species a b"]), line)
    error = refused.value
    assert (error.path, error.word) == ("FIELD", word)
    assert error.line in (11, 12)
    assert says in error.message


def test_what_is_given_twice_is_refused_with_the_first_line() -> None:
    pair = "pair W V a kappa 1 range 1"
    with pytest.raises(InputError, match="given already on line 12"):
        read("species a", pair, "pair V W a kappa 2 range 1")
    with pytest.raises(InputError, match="held there already on line 12"):
        read("species a", "hold a 1.0 in W", "hold a 2.0 in W")
    with pytest.raises(InputError, match="'species': the dissolved species are named twice"):
        read("species a", "species b")
    with pytest.raises(InputError, match="chosen already on line 12"):
        read("species a", "noise off", "noise sqrt")


def test_species_come_first_and_are_needed() -> None:
    with pytest.raises(InputError, match="must come first"):
        read("start a 1.0")
    with pytest.raises(InputError, match="FIELD:10: 'transport': the block names no dissolved species"):
        read()
