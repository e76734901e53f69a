"""Where beads and molecules are placed: shapes, cells, uniform directions, the same places for the same seed."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly.build.placement import place_lattice, place_random, place_rigid, random_rotations

CELL = np.array([[4.0, 0.0, 0.0], [1.0, 5.0, 0.0], [-0.5, 0.7, 6.0]])


def generator(seed: int = 1) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def test_random_points_fill_the_cell_uniformly() -> None:
    """Fractional coordinates in [-1/2, 1/2) with the moments of a uniform number: 0 and 1/12, to 5 standard errors."""
    n = 40000
    fractions = place_random(n, CELL, generator()) @ np.linalg.inv(CELL)
    assert fractions.shape == (n, 3)
    assert np.abs(fractions).max() <= 0.5 + 1e-12
    assert np.abs(fractions.mean(axis=0)).max() < 5 * np.sqrt(1 / 12 / n)
    assert np.abs((fractions**2).mean(axis=0) - 1 / 12).max() < 5 * np.sqrt(1 / 180 / n)


def test_rotations_are_proper_and_uniform() -> None:
    """R R^T = 1, det 1; images of a fixed vector have mean 0 and <x_i x_j> = δ_ij/3, to 5 standard errors."""
    n = 40000
    matrices = random_rotations(n, generator())
    assert np.allclose(matrices @ matrices.transpose(0, 2, 1), np.eye(3), atol=1e-14)
    assert np.allclose(np.linalg.det(matrices), 1.0, atol=1e-13)
    for axis in np.eye(3):
        turned = matrices @ axis
        assert np.abs(turned.mean(axis=0)).max() < 5 / np.sqrt(3 * n)
        assert np.abs(turned.T @ turned / n - np.eye(3) / 3).max() < 5 * np.sqrt(4 / 45 / n)
    # Uniform over rotations, not only over directions: the angle has <cos> = -1/2 and <cos^2> = 1/2.
    cosine = 0.5 * (np.trace(matrices, axis1=1, axis2=2) - 1.0)
    assert abs(cosine.mean() + 0.5) < 5 * 0.5 / np.sqrt(n)
    assert abs((cosine**2).mean() - 0.5) < 5 * 0.36 / np.sqrt(n)


def test_mirrored_copies_are_half_of_them() -> None:
    determinants = np.linalg.det(random_rotations(4000, generator(), mirrored=True))
    assert np.allclose(np.abs(determinants), 1.0)
    assert abs(determinants.mean()) < 5 / np.sqrt(4000)


def test_rigid_copies_keep_their_distances_and_their_centres() -> None:
    template = np.array([[1.0, 2.0, 3.0], [1.5, 2.0, 3.0], [1.5, 2.9, 3.3]])
    centres = place_random(50, CELL, generator())
    copies = place_rigid(template, centres, generator(2)).reshape(50, 3, 3)
    assert np.allclose(copies.mean(axis=1), centres, atol=1e-14)
    for a, b in ((0, 1), (0, 2), (1, 2)):
        expected = np.linalg.norm(template[a] - template[b])
        assert np.allclose(np.linalg.norm(copies[:, a] - copies[:, b], axis=1), expected)


@pytest.mark.parametrize("mirrored", [False, True])
def test_handedness(mirrored: bool) -> None:
    """The signed volume of a chiral molecule keeps its sign unless copies may be mirrored."""
    template = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    copies = place_rigid(template, np.zeros((200, 3)), generator(), mirrored=mirrored).reshape(200, 4, 3)
    volumes = np.linalg.det(copies[:, 1:] - copies[:, :1])
    assert np.allclose(np.abs(volumes), 1.0)
    assert (volumes.min() < 0.0) == mirrored


@pytest.mark.parametrize("count", [1, 7, 27, 64, 100, 999])
def test_lattice(count: int) -> None:
    """Inside the cell, no two points closer than the lattice's spacing, which is near (V/n)^(1/3)."""
    cell = np.diag([4.0, 5.0, 6.0])
    places = place_lattice(count, cell)
    assert places.shape == (count, 3)
    assert np.abs(places @ np.linalg.inv(cell)).max() < 0.5
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1)[np.triu_indices(count, 1)]
    assert count == 1 or apart.min() > 0.55 * (np.prod(np.diag(cell)) / count) ** (1 / 3)


def test_the_same_seed_gives_the_same_places() -> None:
    assert np.array_equal(place_random(10, CELL, generator(3)), place_random(10, CELL, generator(3)))
    assert not np.array_equal(place_random(10, CELL, generator(3)), place_random(10, CELL, generator(4)))
    # The first numbers of PCG64 with seed 3; they must not change with releases of numpy.
    assert place_random(1, np.eye(3), generator(3)).tolist() == [
        [-0.41435083285637564, -0.2631894934039003, 0.3012744652063969]
    ]


def test_none_at_all() -> None:
    assert place_random(0, CELL, generator()).shape == (0, 3)
    assert place_lattice(0, CELL).shape == (0, 3)
    assert place_rigid(np.zeros((2, 3)), np.zeros((0, 3)), generator()).shape == (0, 3)


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        (lambda: place_random(-1, CELL, generator()), "must not be negative, not -1"),
        (lambda: place_lattice(-1, CELL), "must not be negative, not -1"),
        (lambda: place_random(1, np.eye(2), generator()), r"must be \(3, 3\), not \(2, 2\)"),
        (lambda: place_lattice(1, np.zeros((3, 3))), "spans no volume"),
        (lambda: place_rigid(np.zeros((0, 3)), np.zeros((1, 3)), generator()), "at least one bead"),
        (lambda: place_rigid(np.zeros(3), np.zeros((1, 3)), generator()), "the template must be rows of three"),
        (lambda: place_rigid(np.zeros((1, 3)), [[0.0, np.nan, 0.0]], generator()), "the centres must be rows of three"),
    ],
)
def test_refusals(call, expected: str) -> None:
    with pytest.raises(ValueError, match=expected):
        call()
