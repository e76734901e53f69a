"""Layers: membranes with their heads outside, lamellae, and what keeps out of them."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import SceneError, Simulation
from pydlpoly.build import Bilayer, Component, Lamella, Sphere, build, chain, graph, lipid

from .geometry import PAIRS, bond_lengths, bonds, closest

HARMONIC = {"*": ("harm", 128.0, 0.5)}
STIFF = {"*": ("cos", 20.0, 0.0, 1.0)}
LIPIDS = {
    "HT6": lipid("lipid", "H", "T6"),
    "H3(T4)2": lipid("lipid", "H3", "T4", 2),
    "spread": lipid("lipid", "H3", "T5", 2, spread=True),
}
LIPID_PAIRS = {**PAIRS, "H T": 50.0, "H W": 35.0, "T W": 75.0}


def membrane(molecule, *, seed: int = 1, **options):
    return build(
        box=(8.0, 9.0, 14.0),
        species=["H", "T", "W"],
        molecules=[Bilayer(molecule, **(options or {"area": 1.25})), "W"],
        density=3.0,
        pairs=LIPID_PAIRS,
        bonds=HARMONIC,
        angles=STIFF,
        seed=seed,
    )


@pytest.mark.parametrize("name", LIPIDS)
def test_a_bilayer_has_its_heads_outside(name: str) -> None:
    molecule = LIPIDS[name]
    built = membrane(molecule)
    number = round(72.0 / 1.25)
    assert built.counts["lipid"] == 2 * number
    assert built.density == pytest.approx(3.0, abs=0.001)
    size = len(molecule.beads)
    places = built.config.positions[: 2 * number * size].reshape(2, number, size, 3)
    names = np.array(molecule.beads)
    for side, leaf in zip((1.0, -1.0), places, strict=True):
        heights = side * leaf[:, :, 2]
        assert (heights > 0.0).all()
        assert (heights[:, 0] == heights.max(axis=1)).all(), "the first bead is the outermost"
        assert heights[:, names == "H"].mean() > heights[:, names == "T"].mean()
    top = places[..., 2].max()
    water = np.abs(built.config.positions[2 * number * size :, 2])
    assert water.min() > top, "no water in the membrane"
    assert bond_lengths(built) == pytest.approx(np.full(len(bonds(built)), 0.5), abs=2e-6)


def test_a_membrane_has_the_density_of_the_water() -> None:
    built = membrane(LIPIDS["HT6"])
    heights = np.abs(built.config.positions[:, 2])
    thickness = 7.0 / (3.0 * 72.0 / 58.0)  # beads of a lipid / (density area)
    inside = heights < thickness
    assert inside.sum() == pytest.approx(3.0 * 72.0 * 2.0 * thickness, rel=0.01)
    assert inside.sum() == 58 * 14


def test_a_bilayer_by_number_and_off_the_centre() -> None:
    built = membrane(LIPIDS["HT6"], count=100, centre=2.5)
    assert built.counts["lipid"] == 100
    tails = built.config.positions[np.array(built.config.names) == "T", 2]
    assert tails.mean() == pytest.approx(2.5, abs=1e-3)


@pytest.mark.parametrize("name", LIPIDS)
def test_a_bilayer_stays_one(name: str) -> None:
    """After 2 time units heads still lie between tails and water, at a temperature near 1."""
    scene = membrane(LIPIDS[name]).scene()
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(150)
    temperatures = []
    for _ in range(5):
        simulation.run(10)
        temperatures.append(simulation.temperature)
    assert np.mean(temperatures) == pytest.approx(1.0, abs=0.15)
    heights = np.abs(simulation.state.positions[:, 2])
    tail, head, water = (heights[scene.beads.species == scene.species.index(k)].mean() for k in "THW")
    assert tail < head < water


def lamellar(periods: int, **options):
    return build(
        box=(6.0, 6.0, 8.0),
        species=["A", "B"],
        molecules=[Lamella(chain("ab", "A3B5"), periods)],
        density=3.0,
        pairs={**PAIRS, "A B": 40.0},
        bonds={"*": ("harm", 4.0, 0.0)},
        **options,
    )


@pytest.mark.parametrize("periods", [1, 2])
def test_lamellae_put_like_ends_together(periods: int) -> None:
    built = lamellar(periods)
    assert built.density == pytest.approx(3.0, rel=0.02)
    period = 8.0 / periods
    along = (built.config.positions[:, 2] + 4.0) % period
    is_a = np.array(built.config.names) == "A"
    thickness = period / 2
    in_a = (along < thickness * 3 / 8) | (along > period - thickness * 3 / 8)
    assert (in_a == is_a).all()
    layers = np.bincount(((built.config.positions[:, 2] + 4.0) / thickness).astype(int))
    assert (layers == layers[0]).all(), "every layer is filled"
    assert len(layers) == 2 * periods
    assert bond_lengths(built) == pytest.approx(np.full(len(bonds(built)), 3.0 ** (-1 / 3)), abs=2e-6)


def test_layers_keep_least_distances_or_say_so() -> None:
    assert closest(lamellar(1, minimum_distance=0.2), "A", "A") >= 0.2
    with pytest.raises(
        SceneError, match=r"'ab': in this layer beads . and . come as close as 0\.\d+, and the least dis"
    ):
        lamellar(1, minimum_distance=0.6)


@pytest.mark.parametrize(
    ("part", "message"),
    [
        (Bilayer(LIPIDS["HT6"]), "needs either the area per lipid or the number of lipids"),
        (Bilayer(LIPIDS["HT6"], area=1.0, count=4), "needs either"),
        (Bilayer(LIPIDS["HT6"], count=7), "an even number of lipids, not 7"),
        (Bilayer(LIPIDS["HT6"], area=-1.0), "the area per lipid must lie above 0"),
        (Bilayer(lipid("long", "H", "T30"), area=1.0), r"a slab from -.* does not fit a cell of height 10"),
        (Lamella(LIPIDS["HT6"], 0), "at least one period, not 0"),
        (Lamella(chain("t", "T2"), 1), "do not reach through layers of 5: at least 5 periods are needed"),
        (Bilayer(graph("g", "T", (), [[0, 0, 0]]), count=2), "cannot be laid out"),
    ],
)
def test_layers_that_are_refused(part, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        build(box=10.0, species=["H", "T"], molecules=[part], density=3.0, pairs=PAIRS, bonds={"*": ("harm", 9.0, 0.5)})


def test_layers_need_an_upright_cell_and_a_density() -> None:
    tilted = [[10.0, 0.0, 0.0], [1.0, 10.0, 0.0], [0.0, 0.0, 10.0]]
    part = Bilayer(LIPIDS["HT6"], count=10)
    with pytest.raises(SceneError, match="a bilayer needs an orthorhombic cell"):
        build(box=tilted, species=["H", "T"], molecules=[part], density=3.0, pairs=PAIRS, bonds=HARMONIC)
    with pytest.raises(SceneError, match="a layer needs the number density"):
        build(box=10.0, species=["H", "T"], molecules=[part], pairs=PAIRS, bonds=HARMONIC)


def test_a_droplet_keeps_the_solvent_out() -> None:
    parts = [Component("O", fill=True, region=Sphere(2.0)), "W"]
    built = build(box=6.0, species=["O", "W"], molecules=parts, density=3.0, pairs=PAIRS)
    far = np.linalg.norm(built.config.positions, axis=1)
    oil = np.array(built.config.names) == "O"
    assert far[oil].max() < 2.001
    assert far[~oil].min() > 1.999
    assert built.counts == {"O": round(3.0 * 4.0 / 3.0 * np.pi * 8.0), "W": 648 - 101}
