"""Places molecules at random: grown bead by bead as self-avoiding walks, or rigid with a random orientation.

All molecules of a kind are placed together, in rounds: each that still looks for a place makes one trial, those that
come too close to a bead or to each other try again in the next round. Random numbers come from ``Generator.random``
alone, so that a seed gives the same places with every release of numpy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pydlpoly.build.crowd import Crowd, losers
from pydlpoly.build.molecules import MoleculeType
from pydlpoly.build.regions import Region
from pydlpoly.errors import SceneError
from pydlpoly.formats.records import FloatArray, IntArray

# Trials for the first bead, or for a rigid molecule, and for each further bead before its molecule starts again.
_FIRST_TRIALS = 2000
_TRIALS = 100
_RESTARTS = 100


@dataclass(frozen=True, eq=False)
class Job:
    """What is to be placed.

    Attributes:
        molecule: the molecule, grown along its bonds when it has no places.
        count: how many.
        kinds: (beads,) number of the species of each bead.
        lengths: (beads,) length of the bond that each bead hangs on with, in the order of ``molecule.tree()``.
        region: where all beads must lie.
        turn: largest angle between successive bonds, in radians.
    """

    molecule: MoleculeType
    count: int
    kinds: IntArray
    lengths: FloatArray
    region: Region
    turn: float


@dataclass
class _Closest:
    """The best that was seen where there was no room: the largest distance/least distance, and the pair of species."""

    ratio: float = -1.0
    pair: tuple[int, int] = (-1, -1)


class _Step(NamedTuple):
    """One bead of a molecule that grows: the bead it hangs on, the one that hangs on, and its bond; -1 for none."""

    bead: int
    parent: int
    before: int
    length: float


def _steps(job: Job) -> list[_Step]:
    parents = {-1: -1, **dict(job.molecule.tree())}
    return [
        _Step(bead, parent, parents[parent], float(length))
        for (bead, parent), length in zip(job.molecule.tree(), job.lengths, strict=True)
    ]


class Packer:
    """Places molecules into a cell, one job after the other.

    Args:
        crowd: the beads that have a place; receives those that are placed.
        names: of the species, for messages.
        rng: where the random numbers come from.
    """

    def __init__(self, crowd: Crowd, names: tuple[str, ...], rng: np.random.Generator) -> None:
        self._crowd, self._names, self._rng = crowd, names, rng

    def place(self, job: Job) -> FloatArray:
        """Return (count, beads, 3) places of the job's molecules, each molecule whole.

        Raises:
            SceneError: there is no room for all of them; the text says how close it got.
        """
        if job.count == 0:
            return np.zeros((0, len(job.molecule.beads), 3))
        return self._rigid(job) if job.molecule.places is not None else self._grown(job)

    def _rigid(self, job: Job) -> FloatArray:
        """Try random places and orientations for molecules of fixed shape."""
        shape = np.array(job.molecule.places)
        shape = shape - shape.mean(axis=0)
        size = len(shape)
        result = np.zeros((job.count, size, 3))
        pending = np.arange(job.count)
        closest = _Closest()
        for _ in range(_FIRST_TRIALS):
            centres = job.region.sample(len(pending), self._crowd.cell, self._rng)
            trial = np.einsum("nij,bj->nbi", _rotations(len(pending), self._rng), shape) + centres[:, None, :]
            good = self._free(trial.reshape(-1, 3), np.tile(job.kinds, len(pending)), job.region, closest, size)
            chosen, places = pending[good], trial[good]
            keep = ~self._against_each_other(places, job.kinds)
            result[chosen[keep]] = places[keep]
            self._crowd.add(places[keep].reshape(-1, 3), np.tile(job.kinds, int(keep.sum())))
            pending = np.setdiff1d(pending, chosen[keep], assume_unique=True)
            if not len(pending):
                return result
        raise self._no_room(job, len(pending), closest)

    def _grown(self, job: Job) -> FloatArray:
        """Grow all molecules bead by bead; one that finds no place for a bead starts again with the next wave."""
        size = len(job.molecule.beads)
        result = np.zeros((job.count, size, 3))
        numbers = np.zeros((job.count, size), dtype=np.int64)
        pending = np.arange(job.count)
        closest = _Closest()
        steps = _steps(job)
        placed = np.array([step.bead for step in steps], dtype=np.int64)
        for _ in range(_RESTARTS if size > 1 else 1):
            growing = pending
            for order, step in enumerate(steps):
                done = self._grow(job, growing, step, result, numbers, closest)
                stuck = np.setdiff1d(growing, done, assume_unique=True)
                if len(stuck):
                    self._crowd.remove(numbers[np.ix_(stuck, placed[:order])].ravel())
                growing = done
            pending = np.setdiff1d(pending, growing, assume_unique=True)
            if not len(pending):
                return result
        raise self._no_room(job, len(pending), closest)

    def _grow(
        self, job: Job, growing: IntArray, step: _Step, result: FloatArray, numbers: IntArray, closest: _Closest
    ) -> IntArray:
        """Place one bead of each growing molecule; return the molecules that found a place."""
        pending, bead, parent = growing, step.bead, step.parent
        kind = job.kinds[bead : bead + 1]
        for _ in range(_FIRST_TRIALS if parent < 0 else _TRIALS):
            if parent < 0:
                trial = job.region.sample(len(pending), self._crowd.cell, self._rng)
            else:
                trial = result[pending, parent] + step.length * self._directions(job.turn, pending, step, result)
            bonded = numbers[pending, parent] if parent >= 0 else None
            kinds = np.repeat(kind, len(pending))
            good = self._free(trial, kinds, job.region, closest, 1, bonded)
            chosen, places = pending[good], trial[good]
            keep = ~self._against_each_other(places[:, None, :], kind)
            result[chosen[keep], bead] = places[keep]
            numbers[chosen[keep], bead] = self._crowd.add(places[keep], np.repeat(kind, int(keep.sum())))
            pending = np.setdiff1d(pending, chosen[keep], assume_unique=True)
            if not len(pending):
                break
        return np.setdiff1d(growing, pending, assume_unique=True)

    def _directions(self, turn: float, pending: IntArray, step: _Step, result: FloatArray) -> FloatArray:
        """Return (n, 3) unit vectors, uniform within ``turn`` of the bond before."""
        u = self._rng.random((len(pending), 2))
        if step.before < 0 or turn >= np.pi:
            return _spherical(1.0 - 2.0 * u[:, 0], 2.0 * np.pi * u[:, 1])
        along = result[pending, step.parent] - result[pending, step.before]
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        local = _spherical(1.0 - u[:, 0] * (1.0 - np.cos(turn)), 2.0 * np.pi * u[:, 1])
        # Any two vectors that complete the bond to a right-handed frame will do: the angle around it is random.
        helper = np.where(np.abs(along[:, :1]) < 0.5, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
        first = np.cross(along, helper)
        first = first / np.linalg.norm(first, axis=1, keepdims=True)
        second = np.cross(along, first)
        result_: FloatArray = local[:, :1] * first + local[:, 1:2] * second + local[:, 2:] * along
        return result_

    def _free(
        self,
        places: FloatArray,
        kinds: IntArray,
        region: Region,
        closest: _Closest,
        size: int,
        bonded: IntArray | None = None,
    ) -> NDArray[np.bool_]:
        """Return which candidates of ``size`` beads lie in the region and clear of the crowd (of ``bonded`` not)."""
        inside: NDArray[np.bool_] = np.all(region.contains(places, self._crowd.cell).reshape(-1, size), axis=1)
        rows, numbers, ratios = self._crowd.conflicts(places, kinds)
        if bonded is not None:
            other = numbers != bonded[rows]
            rows, numbers, ratios = rows[other], numbers[other], ratios[other]
        if len(rows):
            worst = np.full(len(inside), np.inf)
            np.minimum.at(worst, rows // size, ratios)
            failed = np.where(np.isfinite(worst) & inside, worst, -1.0)
            best = int(failed.argmax())
            if failed[best] > closest.ratio:
                k = int(np.flatnonzero((rows // size == best) & (ratios == failed[best]))[0])
                pair = int(kinds[rows[k]]), int(self._crowd.kinds(numbers[k : k + 1])[0])
                closest.ratio, closest.pair = float(failed[best]), pair
            inside &= ~np.isfinite(worst)
        return inside

    def _against_each_other(self, places: FloatArray, kinds: IntArray) -> NDArray[np.bool_]:
        """Return which of (n, beads, 3) candidates, each clear of the crowd, are too close to an earlier one."""
        count, size = places.shape[:2]
        if not self._crowd.matters or count < 2:
            return np.zeros(count, dtype=np.bool_)
        beads, every = places.reshape(-1, 3), np.tile(kinds, count)
        batch = Crowd(self._crowd.cell, self._crowd.least)
        batch.add(beads, every)
        rows, numbers, _ = batch.conflicts(beads, every)
        return losers(rows // size, numbers // size, count)

    def _no_room(self, job: Job, left: int, closest: _Closest) -> SceneError:
        message = f"{left} of {job.count} molecules found no room"
        if closest.ratio < 0.0:
            message += f" in the region {job.region}"
            return SceneError(f"{message}: it is too small for the molecule", word=job.molecule.name)
        first, second = closest.pair
        least = float(self._crowd.least[first, second])
        message += f": the best place for a bead {self._names[first]} was {closest.ratio * least:.5g} away from a bead "
        message += f"{self._names[second]}, and the least distance asked for is {least:.5g}; lower it or the density"
        return SceneError(message, word=job.molecule.name)


def _spherical(cosine: FloatArray, around: FloatArray) -> FloatArray:
    sine = np.sqrt(np.maximum(0.0, 1.0 - cosine**2))
    return np.stack([sine * np.cos(around), sine * np.sin(around), cosine], axis=1)


def _rotations(count: int, rng: np.random.Generator) -> FloatArray:
    """Return (count, 3, 3) rotations, uniform over all orientations: a random axis frame and a turn about it."""
    u = rng.random((count, 3))
    third = _spherical(1.0 - 2.0 * u[:, 0], 2.0 * np.pi * u[:, 1])
    helper = np.where(np.abs(third[:, :1]) < 0.5, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(third, helper)
    first = first / np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(third, first)
    cosine, sine = np.cos(2.0 * np.pi * u[:, 2:]), np.sin(2.0 * np.pi * u[:, 2:])
    return np.stack([cosine * first + sine * second, cosine * second - sine * first, third], axis=2)
