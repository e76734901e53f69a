"""Sequences and shapes: beads, bonds and angles."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import SceneError
from pydlpoly.build import MoleculeType, bead, chain, comb, graph, lipid, ring, star
from pydlpoly.build.molecules import circle


@pytest.mark.parametrize(
    ("sequence", "beads"),
    [
        ("A5B5", "AAAAABBBBB"),
        ("A,B,A", "ABA"),
        ("A B,A", "ABA"),
        ("P*4", "PPPP"),
        ("AB2A", "ABBA"),
        ("P * 2".replace(" ", ""), "PP"),
    ],
)
def test_linear_sequences(sequence: str, beads: str) -> None:
    molecule = chain("x", sequence)
    assert "".join(molecule.beads) == beads
    assert molecule.bonds == tuple((k, k + 1) for k in range(len(beads) - 1))
    assert molecule.angles == tuple((k, k + 1, k + 2) for k in range(len(beads) - 2))


def test_names_of_several_letters() -> None:
    assert chain("x", "Na2Cl").beads == ("Na", "Na", "Cl")
    assert chain("x", "PEO*2, W1, W1").beads == ("PEO", "PEO", "W1", "W1")
    assert chain("x", "W1,(Tail*2)*2").beads == ("W1", "Tail", "Tail", "Tail", "Tail")


def test_branches_hang_on_the_bead_before_them() -> None:
    molecule = chain("x", "A2(B2)2A")
    assert "".join(molecule.beads) == "AABBBBA"
    assert set(molecule.bonds) == {(0, 1), (1, 2), (2, 3), (1, 4), (4, 5), (1, 6)}
    assert set(molecule.angles) == {(0, 1, 2), (1, 2, 3), (0, 1, 4), (1, 4, 5), (0, 1, 6)}


def test_lipid() -> None:
    molecule = lipid("l", "H3", "T2", 2)
    assert molecule.beads == chain("l", "H3(T2)2").beads
    assert set(molecule.bonds) == set(chain("l", "H3(T2)2").bonds)
    assert set(molecule.angles) == {(0, 1, 2), (1, 2, 3), (2, 3, 4), (1, 2, 5), (2, 5, 6)}
    spread = lipid("l", "H3", "T2", 2, spread=True)
    assert {(2, 3), (1, 5)} < set(spread.bonds)
    assert lipid("l", "H", "T6").bonds == chain("l", "HT6").bonds


def test_ring_star_comb() -> None:
    circle_ = ring("r", "A5")
    assert len(circle_.bonds) == len(circle_.angles) == 5
    four = star("s", "C", "A3", 4)
    assert sum(0 in bond for bond in four.bonds) == 4
    assert len(four.beads) == 13
    assert len(four.angles) == 8, "none across the core"
    brush = comb("c", "A6", "B2", 2, 1)
    assert [a for a, b in brush.bonds if brush.beads[b] == "B" and brush.beads[a] == "A"] == [1, 3, 5]
    assert len(brush.bonds) == len(brush.beads) - 1 == 11


def test_graph_takes_angles_at_every_bead() -> None:
    water = graph("w", "O,H,H", "0-1,0-2", places=[[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    assert water.angles == ((1, 0, 2),)
    assert water.places is not None
    assert bead("W").beads == ("W",)


def test_tree_starts_at_the_first_bead() -> None:
    assert graph("g", "A,B,C", "2-1,0-2").tree() == ((0, -1), (2, 0), (1, 2))


def test_circle() -> None:
    places = np.array(circle(7, 0.6))
    assert np.linalg.norm(places - np.roll(places, 1, axis=0), axis=1) == pytest.approx(np.full(7, 0.6))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: chain("x", ""), "is an empty sequence"),
        (lambda: chain("x", "A5-B"), "cannot be read from '-B' on; expected a sequence such as A5B5"),
        (lambda: chain("x", "A(B"), "a bracket is not closed"),
        (lambda: chain("x", "A)B"), "a bracket is closed that was not opened"),
        (lambda: chain("x", "(B)2"), "needs a bead before it"),
        (lambda: chain("x", "A()2"), "a group in brackets is empty"),
        (lambda: chain("x", "A0"), "lies between 1 and 1000000, not at 0"),
        (lambda: chain("x", "A*99999999"), "lies between 1 and 1000000"),
        (lambda: ring("r", "A2"), "at least three beads without branches"),
        (lambda: star("s", "C", "A", 0), "at least one arm, not 0"),
        (lambda: comb("c", "A4", "B", 2, 4), "from bead 4 on do not fit a backbone of 4"),
        (lambda: lipid("l", "H", "T4", 2, spread=True), "2 tails do not fit a head of 1 beads"),
        (lambda: graph("g", "A,B", "0-2"), r"the bond \(0, 2\) is no pair of bead numbers from 0 to 1"),
        (lambda: graph("g", "A,B", "0-1,1-0"), "is given twice"),
        (lambda: graph("g", "A,B", "0:1"), "expected bonds as in 0-1,1-2, not '0:1'"),
        (lambda: graph("g", "A,B", "0-1", places=[[0, 0, 0]]), "1 places for 2 beads"),
        (lambda: graph("g", "A,B,C", "0-1").tree(), "bead 2 is not connected to bead 0"),
        (lambda: graph("g", "A,B,C", "0-1,1-2,0-2").tree(), "the bonds have a cycle"),
        (lambda: MoleculeType("m", ()), "needs at least one bead"),
    ],
)
def test_what_is_refused(make, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        make()
