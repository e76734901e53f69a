"""The same HISTORY through MDAnalysis: radial distribution, displacements and radius of gyration."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import pydlpoly
from pydlpoly.analysis import (
    BondLengths,
    ChainDimensions,
    MeanSquareDisplacement,
    RadialDistribution,
    molecules_of,
    terms_of,
    universe,
)
from pydlpoly.cli import example_folder
from pydlpoly.formats.history import read_history
from pydlpoly.runner import run_scene

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from MDAnalysis.analysis.msd import EinsteinMSD
    from MDAnalysis.analysis.rdf import InterRDF


@pytest.fixture(scope="module")
def lipids(tmp_path_factory: pytest.TempPathFactory) -> tuple[pydlpoly.Scene, Path]:
    """The shipped example with chains: 400 steps, a frame every 10."""
    from dataclasses import replace

    scene = pydlpoly.load(example_folder("lipid"))
    scene = replace(scene, output=replace(scene.output, trajectory_every=10, trajectory_start=0, trajectory_level=1))
    folder = tmp_path_factory.mktemp("lipids")
    run_scene(scene, folder, steps=400, seed=3)
    return scene, folder / "HISTORY"


def test_universe_has_the_scenes_beads_and_bonds(lipids: tuple[pydlpoly.Scene, Path]) -> None:
    scene, history = lipids
    made, still = universe(scene, history), universe(scene)
    assert len(made.trajectory) == 41
    for one in (made, still):
        assert len(one.atoms) == scene.bead_count
        assert list(one.atoms.names[:3]) == [scene.species[k] for k in scene.beads.species[:3]]
        assert one.atoms.masses == pytest.approx(scene.beads.mass)
        assert len(one.residues) == sum(scene.molecule_counts)
        assert set(one.residues.resnames) == set(scene.molecule_names)
        assert len(one.bonds) == sum(len(ids) for ids in terms_of(scene, "bond").values())
        assert one.dimensions[:3] == pytest.approx(np.diag(scene.cell), rel=1e-5)
    np.testing.assert_allclose(still.atoms.positions, scene.beads.positions, atol=1e-5)


def test_radial_distribution(lipids: tuple[pydlpoly.Scene, Path]) -> None:
    """Single precision moves a few pairs to the next bin; InterRDF takes N² pairs of like beads, we N (N − 1)."""
    scene, history = lipids
    first, second = scene.species[0], scene.species[-1]
    ours = RadialDistribution([(first, first), (first, second)], bin_width=0.05, reach=2.0).of(history)
    made = universe(scene, history)
    for k, other in enumerate((first, second)):
        groups = [made.select_atoms(f"name {name}") for name in (first, other)]
        exclusion = (1, 1) if other == first else None
        theirs = InterRDF(*groups, nbins=40, range=(0.0, 2.0), exclusion_block=exclusion).run().results
        count = len(groups[0])
        expected = theirs.rdf * (1.0 if other != first else count / (count - 1))
        far = ours.r > 0.2
        scale = 1.0 if other != first else (theirs.rdf[far] @ ours.g[k][far]) / (theirs.rdf[far] @ expected[far])
        assert scale == pytest.approx(1.0, abs=2.0 / count) or other != first
        np.testing.assert_allclose(ours.g[k][far], scale * expected[far], atol=0.02)


def test_square_displacements(lipids: tuple[pydlpoly.Scene, Path]) -> None:
    scene, history = lipids
    ours = MeanSquareDisplacement(longest=1e9).of(history)
    made = universe(scene, history)
    from MDAnalysis.transformations import NoJump

    made.trajectory.add_transformations(NoJump())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for k, name in enumerate(ours.species):
            theirs = EinsteinMSD(made, select=f"name {name}", fft=False).run().results.timeseries
            np.testing.assert_allclose(ours.msd[k], theirs, rtol=1e-3, atol=1e-5)


def test_radius_of_gyration(lipids: tuple[pydlpoly.Scene, Path]) -> None:
    scene, history = lipids
    molecules = [one for one in molecules_of(scene).values() if one.beads.shape[1] > 1]
    ours = ChainDimensions(molecules).of(history, every=10)
    made = universe(scene, history)
    for k, one in enumerate(molecules):
        squares = []
        for _ in made.trajectory[::10]:
            for ids in one.beads[:40]:
                group = made.atoms[ids]
                group.unwrap(reference=None)
                squares.append(group.radius_of_gyration() ** 2)
        few = ChainDimensions([type(one)(one.name, one.beads[:40], one.parents, one.order)]).of(history, every=10)
        assert few.gyration_squared[0] == pytest.approx(np.mean(squares), rel=1e-4)
        assert ours.gyration_squared[k] == pytest.approx(np.mean(squares), rel=0.1)


def test_bond_lengths_are_those_of_whole_molecules(lipids: tuple[pydlpoly.Scene, Path]) -> None:
    scene, history = lipids
    terms = terms_of(scene, "bond")
    found = BondLengths(terms).of(history)
    made = universe(scene, history)
    last = list(read_history(history))[-1]
    assert len(terms) == len(found.kinds) > 0
    made.trajectory[-1]
    values = made.bonds.values(pbc=True)
    (frame,) = [last]
    one = BondLengths({"all": np.concatenate(list(terms.values()))}).of([frame])
    assert one.mean[0] == pytest.approx(values.mean(), rel=1e-4)
