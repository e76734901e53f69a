"""Random places: distances, bond lengths, regions, seeds, and what is said when there is no room."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import SceneError
from pydlpoly.build import Component, Cylinder, Outside, Slab, Sphere, build, chain, comb, graph, ring, star

from .geometry import PAIRS, bond_lengths, bonds, closest

HARMONIC = {"*": ("harm", 50.0, 0.6)}


@pytest.mark.parametrize("box", [6.0, [[6.0, 0.0, 0.0], [2.0, 6.0, 0.0], [-1.0, 1.5, 6.0]], [9.0, 9.0, 2.0]])
def test_least_distances_are_kept_pair_by_pair(box) -> None:
    """Also in a tilted cell, and in one that is three link cells high."""
    built = build(
        box=box,
        species=["A", "B", "W"],
        molecules=[Component(chain("c", "A4B2"), count=20), "W"],
        density=3.0,
        pairs=PAIRS,
        bonds=HARMONIC,
        minimum_distance={"*": 0.35, "A A": 0.55, "B-W": 0.0},
    )
    assert closest(built, "A", "A") >= 0.55
    assert closest(built, "A", "A") < 0.6, "the walls of the search, not luck"
    for pair in ("AB", "AW", "BB", "WW"):
        assert closest(built, *pair) >= 0.35
    assert closest(built, "W", "W") < 0.38
    assert closest(built, "B", "W") < 0.3, "not asked for"


@pytest.mark.parametrize(
    "molecule",
    [
        chain("c", "A10"),
        star("s", "C", "A4", 5),
        comb("b", "A8", "C2", 2),
        ring("r", "A9"),
        chain("t", "C2(A3)2"),
    ],
    ids=lambda molecule: molecule.name,
)
@pytest.mark.parametrize("shape", [None, "rigid"])
def test_bonds_have_their_length(molecule, shape) -> None:
    built = build(
        box=7.0,
        species=["A", "C"],
        molecules=[Component(molecule, count=12, shape=shape)],
        pairs=PAIRS,
        bonds=HARMONIC,
        minimum_distance=0.3,
    )
    assert len(bonds(built)) == 12 * len(molecule.bonds)
    assert bond_lengths(built) == pytest.approx(np.full(12 * len(molecule.bonds), 0.6), abs=2e-6)
    names = sorted({*built.config.names})
    assert min(closest(built, a, b) for a in names for b in names) >= 0.3


def test_lengths_of_bonds_come_from_their_laws() -> None:
    """r0; the mean distance of beads for r0 = 0; half the largest length of FENE."""
    built = build(
        box=6.0,
        species=["A", "B", "C"],
        molecules=[Component(chain("c", "A2B2C2"), count=1)],
        pairs=PAIRS,
        density=8.0,
        bonds={
            "A A": ("-hrm", 4.0, 0.0),
            ("B", "A"): ("mors", 1.0, 0.8, 2.0),
            "C C": ("fene", 30.0, 0.9),
            "*": ("harm", 9.0, 0.3),
        },
    )
    assert bond_lengths(built) == pytest.approx([0.5, 0.8, 0.3, 0.3, 0.45], abs=3e-6)


def test_rigid_molecules_are_copies_of_one_shape() -> None:
    places = [[0.0, 0.0, 0.0], [0.7, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 1.1]]
    molecule = graph("g", "A,A,A,A", "0-1,0-2,0-3", places)
    built = build(
        box=5.0,
        species=["A"],
        molecules=[Component(molecule, count=30)],
        pairs=PAIRS,
        bonds=HARMONIC,
        minimum_distance=0.4,
    )
    whole = built.config.positions.reshape(30, 4, 3)
    apart = whole - whole[:, :1]
    apart -= 5.0 * np.rint(apart / 5.0)
    assert np.linalg.norm(apart[:, 1:], axis=2) == pytest.approx(np.tile([0.7, 0.9, 1.1], (30, 1)), abs=3e-6)
    handed = np.einsum("ni,ni->n", np.cross(apart[:, 1], apart[:, 2]), apart[:, 3])
    assert handed == pytest.approx(np.full(30, 0.7 * 0.9 * 1.1), abs=1e-5), "turned, not mirrored"
    mean = apart[:, 1].mean(axis=0)
    assert np.linalg.norm(mean) < 0.7 * 3.0 / np.sqrt(30), "all orientations: three standard errors"


def test_turn_bounds_the_angle_between_bonds() -> None:
    bends = {}
    for turn in (20.0, None):
        component = Component(chain("c", "A30"), count=10, turn=turn)
        built = build(box=12.0, species=["A"], molecules=[component], pairs=PAIRS, bonds=HARMONIC)
        steps = np.diff(built.config.positions.reshape(10, 30, 3), axis=1)
        steps -= 12.0 * np.rint(steps / 12.0)
        steps /= np.linalg.norm(steps, axis=2, keepdims=True)
        bends[turn] = np.rad2deg(np.arccos(np.clip((steps[:, 1:] * steps[:, :-1]).sum(axis=2), -1, 1)))
    assert bends[20.0].max() <= 20.001
    assert bends[20.0].max() > 19.0
    assert bends[None].max() > 150.0


@pytest.mark.parametrize(
    ("region", "inside"),
    [
        (Slab(-1.0, 2.0, "y"), lambda r: (r[:, 1] > -1.001) & (r[:, 1] < 2.001)),
        (Slab(3.0, 5.0), lambda r: (r[:, 2] > 2.999) | (r[:, 2] < -2.999)),
        (Sphere(2.5, (1.0, 0.0, 0.0)), lambda r: np.linalg.norm(r - [1.0, 0.0, 0.0], axis=1) < 2.501),
        (Cylinder(2.0, "x"), lambda r: np.linalg.norm(r[:, 1:], axis=1) < 2.001),
        (Outside((Sphere(3.0),)), lambda r: np.linalg.norm(r, axis=1) > 2.999),
    ],
    ids=["slab", "slab across a face", "sphere", "cylinder", "outside"],
)
def test_regions_hold_all_beads(region, inside) -> None:
    parts = [Component(chain("c", "A5"), count=10, region=region), Component("W", fill=True, region=region)]
    built = build(box=8.0, species=["A", "W"], molecules=parts, density=3.0, pairs=PAIRS, bonds=HARMONIC)
    assert inside(built.config.positions).all()
    assert built.counts["W"] == round(3.0 * region.volume(built.config.cell))


def test_a_seed_gives_the_same_places_and_another_one_others() -> None:
    def places(seed: int) -> np.ndarray:
        parts = [Component(chain("c", "A5"), count=10), "W"]
        built = build(
            box=5.0,
            species=["A", "W"],
            molecules=parts,
            density=3.0,
            pairs=PAIRS,
            bonds=HARMONIC,
            minimum_distance=0.4,
            seed=seed,
        )
        return built.config.positions

    assert np.array_equal(places(3), places(3))
    assert not np.array_equal(places(3), places(4))


def test_places_are_uniform() -> None:
    """Counts in eight parts of the cell: each within 4 standard deviations of 1000."""
    built = build(box=20.0, species=["W"], molecules=[Component("W", count=8000)], pairs=PAIRS)
    octant = (built.config.positions > 0.0) @ [1, 2, 4]
    assert np.abs(np.bincount(octant, minlength=8) - 1000).max() < 4.0 * np.sqrt(1000 * 7 / 8)


def test_no_room_says_how_close_it_got() -> None:
    with pytest.raises(
        SceneError, match=r"'W': \d+ of 192 molecules found no room: the best place .* 0\.6\d* away"
    ) as error:
        build(box=4.0, species=["W"], molecules=["W"], density=3.0, pairs=PAIRS, minimum_distance=0.66)
    assert "the least distance asked for is 0.66; lower it or the density" in str(error.value)


def test_no_room_in_a_region() -> None:
    long = Component(graph("rod", "A,A", "0-1", [[0, 0, 0], [3, 0, 0]]), count=1, region=Sphere(1.0))
    with pytest.raises(SceneError, match=r"1 of 1 molecules found no room in the region Sphere\(.*too small"):
        build(box=8.0, species=["A"], molecules=[long], pairs=PAIRS, bonds=HARMONIC)


@pytest.mark.slow
def test_a_hundred_thousand_beads() -> None:
    parts = [Component(chain("c", "A10"), count=1000), "W"]
    built = build(
        box=(1e5 / 3.0) ** (1.0 / 3.0),
        species=["A", "W"],
        molecules=parts,
        density=3.0,
        pairs=PAIRS,
        bonds=HARMONIC,
        minimum_distance=0.4,
    )
    assert len(built.config.names) == 100_000
