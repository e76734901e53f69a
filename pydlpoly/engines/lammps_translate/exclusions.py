"""Pairs without pair forces, as LAMMPS knows them: by how many bonds they are apart.

A scene lists its excluded pairs. Where they are the pairs of one, two or three bonds between them, as usual, the
weights of ``special_bonds`` say so; otherwise every excluded pair that has no bond gets one without a force.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from pydlpoly.engines.lammps_translate.refusal import Places, refusal
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Bonded, Scene

Keys = NDArray[np.int64]
Weights = tuple[float, float, float]
_FREE: Weights = (1.0, 1.0, 1.0)


class Exclusions(NamedTuple):
    """Weights of pairs one, two and three bonds apart, and the bonds without a force that are to be added.

    Attributes:
        pair: of pair laws; ``charge``: of electrostatics; ``drag``: of drag and noise.
        dummies: (n, 2) ids.
    """

    pair: Weights
    charge: Weights
    drag: Weights
    dummies: NDArray[np.int64]

    @property
    def any(self) -> bool:
        """Whether some pairs lack a part of their forces."""
        return any(weight != 1.0 for weight in (*self.pair, *self.charge))

    @property
    def leave_lists(self) -> bool:
        """Whether LAMMPS's lists of pairs lack every pair that these weights are about, or have it as any other."""
        pairs = zip(self.pair, self.charge, strict=True)
        return all((lj, coul) in ((0.0, 0.0), (1.0, 1.0)) for lj, coul in pairs)


def exclusions_of(scene: Scene, places: Places) -> Exclusions:
    """Return what the scene's excluded and scaled pairs become.

    Raises:
        SceneError: weights of bonds cannot tell the excluded pairs from the others.
    """
    nothing = np.zeros((0, 2), dtype=np.int64)
    bonded = scene.bonded
    if bonded is None or not len(bonded.excluded):
        return Exclusions(_FREE, _FREE, _FREE, nothing)
    count = scene.bead_count
    excluded = _keys(bonded.excluded, count)
    bonds = _bonds(bonded, count)
    classes = _classes(bonds, count)
    scaled = _Scaled(bonded, count)
    natural = _weights(classes, excluded, scaled)
    if natural is not None:
        return Exclusions(*natural, nothing)
    if scaled.used:
        message = "1-4 factors that are not the same for all pairs of beads three bonds apart cannot be run"
        raise refusal(message, _place_of(bonded, "dihedral", places))
    if len(np.setdiff1d(bonds, excluded)):
        message = "bonds that leave their beads the pair forces beside bonds that do not cannot be run"
        raise refusal(message, _place_of(bonded, "bond", places))
    missing = np.setdiff1d(excluded, bonds)
    dummies = np.column_stack([missing // count, missing % count])
    weights = (0.0, 1.0, 1.0)
    return Exclusions(weights, weights, weights, dummies)


class _Scaled:
    """The excluded pairs that feel a part of their forces all the same."""

    def __init__(self, bonded: Bonded, count: int) -> None:
        self.pair = _by_key(bonded.scaled, bonded.scales, count)
        charge = bonded.coulomb_scaled is not None and bonded.coulomb_scales is not None
        self.charge = _by_key(bonded.coulomb_scaled, bonded.coulomb_scales, count) if charge else None
        self.used = bool(len(self.pair[0])) or (self.charge is not None and bool(len(self.charge[0])))


def _weights(
    classes: tuple[Keys, Keys, Keys], excluded: Keys, scaled: _Scaled
) -> tuple[Weights, Weights, Weights] | None:
    if len(np.setdiff1d(excluded, np.concatenate(classes))):
        return None
    pair, charge, drag = [], [], []
    for keys in classes:
        inside = np.isin(keys, excluded)
        if not inside.any():
            pair.append(1.0)
            charge.append(1.0)
            drag.append(1.0)
            continue
        factors = [_common(keys, table) for table in (scaled.pair, scaled.charge)]
        if not inside.all() or any(factor is None for factor in factors):
            return None
        pair.append(float(factors[0] or 0.0))
        charge.append(float(factors[1] or 0.0))
        drag.append(0.0)
    return (pair[0], pair[1], pair[2]), (charge[0], charge[1], charge[2]), (drag[0], drag[1], drag[2])


def _common(keys: Keys, table: tuple[Keys, FloatArray] | None) -> float | None:
    """Return the factor that all these pairs share, 0 where none has one, None where they differ."""
    if table is None or not len(table[0]):
        return 0.0
    inside = np.isin(keys, table[0])
    if not inside.any():
        return 0.0
    factors = np.unique(table[1][np.searchsorted(table[0], keys[inside])])
    return float(factors[0]) if inside.all() and len(factors) == 1 else None


def _classes(bonds: Keys, count: int) -> tuple[Keys, Keys, Keys]:
    """Return the pairs that are one, two and three bonds apart and not fewer."""
    i, j = bonds // count, bonds % count
    ones = np.ones(len(bonds), dtype=np.int32)
    half = sparse.coo_matrix((ones, (i, j)), shape=(count, count)).tocsr()
    graph = half + half.T
    second = graph @ graph
    third = second @ graph
    two = np.setdiff1d(_upper(second, count), bonds)
    three = np.setdiff1d(_upper(third, count), np.concatenate([bonds, two]))
    return bonds, two, three


def _upper(matrix: sparse.spmatrix, count: int) -> Keys:
    upper = sparse.triu(matrix, k=1).tocoo()
    return np.unique(upper.row.astype(np.int64) * count + upper.col)


def _bonds(bonded: Bonded, count: int) -> Keys:
    pairs = [term.beads for term in bonded.terms if term.kind == "bond"]
    return _keys(np.concatenate(pairs), count) if pairs else np.zeros(0, dtype=np.int64)


def _keys(pairs: NDArray[np.integer], count: int) -> Keys:
    ordered = np.sort(np.asarray(pairs, dtype=np.int64).reshape(-1, 2), axis=1)
    return np.unique(ordered[:, 0] * count + ordered[:, 1])


def _by_key(pairs: NDArray[np.integer] | None, factors: FloatArray | None, count: int) -> tuple[Keys, FloatArray]:
    if pairs is None or factors is None or not len(factors):
        return np.zeros(0, dtype=np.int64), np.zeros(0)
    ordered = np.sort(np.asarray(pairs, dtype=np.int64).reshape(-1, 2), axis=1)
    keys, first = np.unique(ordered[:, 0] * count + ordered[:, 1], return_index=True)
    return keys, np.asarray(factors, dtype=np.float64)[first]


def _place_of(bonded: Bonded, kind: str, places: Places) -> dict[str, object]:
    text = next((term.explanation for term in bonded.terms if term.kind == kind), "")
    return places.of_text(text)
