"""Configurations of a run: beads, species and cell, from whatever file has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import InputError
from pydlpoly.formats.checkpoint import read_checkpoint
from pydlpoly.formats.config import read_config
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene import Scene
from pydlpoly.scene.serialise import scene_from_arrays


@dataclass(frozen=True, eq=False)
class Snapshot:
    """One configuration.

    Attributes:
        file: the file it is from; step: None where that does not say it.
        species: names; kinds: (N,) index of each bead's.
        positions: (N, 3) in Å.
        cell: (3, 3) by row, zeros without one; periodic: along which of its vectors.
    """

    file: str
    step: int | None
    species: tuple[str, ...]
    kinds: NDArray[np.int64]
    positions: FloatArray
    cell: FloatArray
    periodic: tuple[bool, bool, bool]


@dataclass(frozen=True, eq=False)
class States:
    """What a checkpoint holds: the run's scene, its first and its present configuration, and the momentum."""

    file: str
    scene: Scene
    start: Snapshot
    last: Snapshot
    momentum: FloatArray

    @classmethod
    def of_checkpoint(cls, path: Path) -> States:
        """Read a checkpoint. Raises InputError when it is none, or one of another version."""
        arrays, meta = read_checkpoint(path)
        try:
            scene = scene_from_arrays(arrays, meta["scene"])
            cell, step = arrays.get("cell", scene.cell), int(meta["step"])
            start_cell = arrays.get("start_cell", cell)
            momentum = scene.beads.mass @ arrays["velocities"]
            start = _of_beads(scene, path.name, 0, arrays["start_positions"], start_cell)
            return cls(path.name, scene, start, _of_beads(scene, path.name, step, arrays["positions"], cell), momentum)
        except KeyError as error:
            raise InputError(f"the checkpoint lacks {error}", path=str(path)) from error


def of_scene(scene: Scene) -> Snapshot:
    """Return the start configuration of a scene."""
    return _of_beads(scene, "CONFIG", 0, scene.beads.positions, scene.cell)


def of_configuration_file(path: Path) -> Snapshot:
    """Read a CONFIG or REVCON. Raises InputError when it is none."""
    read = read_config(path)
    cell = np.zeros((3, 3)) if read.cell is None else read.cell
    return Snapshot(path.name, read.step, *_kinds(read.names), read.positions, cell, periodic_of(read.imcon))


def of_frame(frame: Frame, file: str) -> Snapshot:
    """Return a frame of a trajectory."""
    return Snapshot(file, frame.step, *_kinds(frame.names), frame.positions, frame.cell, periodic_of(frame.imcon))


def periodic_of(imcon: int) -> tuple[bool, bool, bool]:
    """Return along which cell vectors a configuration with this key is periodic."""
    return imcon != 0, imcon != 0, imcon not in (0, 6)


def _of_beads(scene: Scene, file: str, step: int, positions: FloatArray, cell: FloatArray) -> Snapshot:
    return Snapshot(file, step, scene.species, scene.beads.species.astype(np.int64), positions, cell, scene.periodic)


def _kinds(names: Sequence[str]) -> tuple[tuple[str, ...], NDArray[np.int64]]:
    species = tuple(dict.fromkeys(names))
    number = {name: k for k, name in enumerate(species)}
    return species, np.array([number[name] for name in names], dtype=np.int64)
