"""Molecules of a scene as arrays of bead ids, made whole across cell boundaries, and their centres."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pydlpoly.analysis.frames import Source, frames_of, masses_of, minimum_image
from pydlpoly.errors import InputError
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Scene


@dataclass(frozen=True, eq=False)
class Molecules:
    """All copies of one molecule type.

    Attributes:
        name: of the type.
        beads: (copies, length) bead ids from 0, in FIELD's order.
        parents: (length,) for each bead the earlier one it is placed next to when the molecule is made whole, itself
            for the first; by default the bead before. Neighbours must be closer than half the cell.
        order: in which order the beads are placed.
    """

    name: str
    beads: NDArray[np.int64]
    parents: NDArray[np.int64] | None = None
    order: NDArray[np.int64] | None = None

    def whole(self, frame: Frame) -> FloatArray:
        """Return positions of the beads, (copies, length, 3), followed across cell boundaries from the first bead."""
        if self.beads.size and int(self.beads.max()) >= len(frame.positions):
            raise InputError(f"the frames have {len(frame.positions)} beads, too few for the molecules {self.name}")
        places = frame.positions[self.beads]
        length = self.beads.shape[1]
        parents = np.maximum(np.arange(length) - 1, 0) if self.parents is None else self.parents
        order = np.arange(length) if self.order is None else self.order
        result = places.copy()
        for bead in order.tolist():
            parent = int(parents[bead])
            if parent != bead:
                step = minimum_image(places[:, bead] - places[:, parent], frame)
                result[:, bead] = result[:, parent] + step
        return result


def molecules_of(scene: Scene) -> dict[str, Molecules]:
    """Return the molecule types of a scene that have copies, by name; bonds say which beads are neighbours."""
    found: dict[str, Molecules] = {}
    first, start = 0, 0
    sizes = np.bincount(scene.beads.molecule)
    for kind, (name, copies) in enumerate(zip(scene.molecule_names, scene.molecule_counts, strict=True)):
        if copies == 0:
            continue
        length = int(sizes[first])
        beads = start + np.arange(copies * length, dtype=np.int64).reshape(copies, length)
        parents, order = _tree(length, _bonds_of_first(scene, kind, start, length))
        label = name if name not in found else f"{name} {kind + 1}"
        found[label] = Molecules(label, beads, parents, order)
        first, start = first + copies, start + copies * length
    return found


def _bonds_of_first(scene: Scene, kind: int, start: int, length: int) -> NDArray[np.int64]:
    terms = () if scene.bonded is None else scene.bonded.terms
    pairs = [term.beads for term in terms if term.kind == "bond" and term.molecule == kind]
    bonds = np.concatenate(pairs).astype(np.int64) - start if pairs else np.zeros((0, 2), dtype=np.int64)
    inside: NDArray[np.int64] = bonds[((bonds >= 0) & (bonds < length)).all(axis=1)]
    return inside


def _tree(length: int, bonds: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Parents along bonds, and an order in which parents come first; beads without bonds follow the one before."""
    neighbours: list[list[int]] = [[] for _ in range(length)]
    for a, b in bonds.tolist():
        neighbours[a].append(b)
        neighbours[b].append(a)
    parents, order = np.full(length, -1, dtype=np.int64), []
    for root in range(length):
        if parents[root] >= 0:
            continue
        parents[root] = max(root - 1, 0)
        waiting = [root]
        while waiting:
            bead = waiting.pop(0)
            order.append(bead)
            for other in neighbours[bead]:
                if parents[other] < 0:
                    parents[other] = bead
                    waiting.append(other)
    return parents, np.array(order, dtype=np.int64)


def molecule_numbers(molecules: Sequence[Molecules], beads: int) -> NDArray[np.int64]:
    """Return for every bead which molecule it is part of, (N,); beads of none have numbers of their own."""
    numbers = np.arange(beads, dtype=np.int64) + sum(len(one.beads) for one in molecules)
    start = 0
    for one in molecules:
        numbers[one.beads] = start + np.arange(len(one.beads))[:, None]
        start += len(one.beads)
    return numbers


def molecule_centres(source: Source, molecules: Sequence[Molecules]) -> Iterator[Frame]:
    """Return frames of which every bead is the centre of mass of a molecule, named after its type.

    Masses are the molecules', velocities those of the centres where the frames have them.
    """
    names = tuple(one.name for one in molecules for _ in range(len(one.beads)))
    for frame in frames_of(source):
        masses = masses_of(frame)
        total = np.concatenate([masses[one.beads].sum(axis=1) for one in molecules])
        weights = [masses[one.beads] / masses[one.beads].sum(axis=1)[:, None] for one in molecules]
        centres = [np.einsum("mk,mkx->mx", w, one.whole(frame)) for w, one in zip(weights, molecules, strict=True)]
        moving = None
        if frame.velocities is not None:
            parts = [frame.velocities[one.beads] for one in molecules]
            moving = np.concatenate([np.einsum("mk,mkx->mx", w, v) for w, v in zip(weights, parts, strict=True)])
        unknown = np.full(len(names), np.nan)
        yield replace(
            frame,
            level=0 if moving is None else 1,
            names=names,
            indices=np.arange(1, len(names) + 1),
            masses=total,
            charges=unknown,
            displacements=unknown,
            positions=np.concatenate(centres),
            velocities=moving,
            forces=None,
        )
