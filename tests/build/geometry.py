"""Distances in built configurations, computed pair by pair: the judge of the builder's own search."""

from __future__ import annotations

from functools import lru_cache
from itertools import product

import numpy as np

from pydlpoly.build import Built

PAIRS = {"*": {"a": 25.0, "cutoff": 1.0, "drag": 4.5}}


@lru_cache(maxsize=2)
def distances(built: Built) -> np.ndarray:
    """(N, N) shortest distances between beads and all images, a bead and itself apart."""
    positions, cell = built.config.positions, built.config.cell
    apart = positions[:, None, :] - positions[None, :, :]
    result = np.full((len(positions), len(positions)), np.inf)
    for image in product((-1, 0, 1), repeat=3):
        lengths = np.linalg.norm(apart + np.array(image) @ cell, axis=2)
        if image == (0, 0, 0):
            np.fill_diagonal(lengths, np.inf)
        np.minimum(result, lengths, out=result)
    result.setflags(write=False)
    return result


def bonds(built: Built) -> list[tuple[int, int]]:
    """All bonds as bead numbers from 0, from the records alone."""
    found = []
    first = 0
    for molecule in built.field.molecules:
        block = molecule.block("bonds")
        for _ in range(molecule.count):
            found += [(first + line.beads[0] - 1, first + line.beads[1] - 1) for line in (block.lines if block else ())]
            first += molecule.beads_per_molecule
    return found


def bond_lengths(built: Built) -> np.ndarray:
    """The length of each bond, by the nearest of all images."""
    first, second = np.array(bonds(built)).T
    apart = built.config.positions[first] - built.config.positions[second]
    images = np.array(list(product((-1, 0, 1), repeat=3))) @ built.config.cell
    return np.linalg.norm(apart[:, None, :] + images, axis=2).min(axis=1)


def closest(built: Built, first: str, second: str, *, bonded: bool = False) -> float:
    """The shortest distance of beads of two species; without ``bonded``, of those that no bond connects."""
    apart = distances(built).copy()
    if not bonded:
        for a, b in bonds(built):
            apart[a, b] = apart[b, a] = np.inf
    names = np.array(built.config.names)
    return float(apart[np.ix_(names == first, names == second)].min())
