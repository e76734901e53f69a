"""Configurations of a run: beads, species and cell, from whatever file has them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import InputError
from pydlpoly.formats.checkpoint import read_checkpoint
from pydlpoly.formats.config import read_config
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import BeadTable, FloatArray
from pydlpoly.formats.species_balance import SpeciesBalance
from pydlpoly.scene import Scene
from pydlpoly.scene.beads_state import CONCENTRATION, TEMPERATURE, carried_arrays, start_arrays
from pydlpoly.scene.serialise import scene_from_arrays


@dataclass(frozen=True, eq=False)
class Snapshot:
    """One configuration.

    Attributes:
        file: the file it is from; step: None where that does not say it.
        species: names; kinds: (N,) index of each bead's.
        positions: (N, 3) in Å.
        cell: (3, 3) by row, zeros without one; periodic: along which of its vectors.
        values: (N,) each, what beads carry by name: "temperature", "concentration_NAME".
    """

    file: str
    step: int | None
    species: tuple[str, ...]
    kinds: NDArray[np.int64]
    positions: FloatArray
    cell: FloatArray
    periodic: tuple[bool, bool, bool]
    values: Mapping[str, FloatArray] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class States:
    """What a checkpoint holds: the run's scene, its first and its present configuration, momentum, and balances."""

    file: str
    scene: Scene
    start: Snapshot
    last: Snapshot
    momentum: FloatArray
    balance: tuple[SpeciesBalance, ...] = ()
    callbacks: tuple[str, ...] = ()

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
            last = _of_beads(scene, path.name, step, arrays["positions"], cell)
            carried = carried_arrays(scene, arrays.get("bead_temperatures"), arrays.get("concentrations"))
            start, last = replace(start, values=start_arrays(scene)), replace(last, values=carried)
            callbacks = tuple(str(name) for name, _ in meta.get("callbacks", []))
            return cls(path.name, scene, start, last, momentum, _balance(scene, arrays), callbacks)
        except KeyError as error:
            raise InputError(f"the checkpoint lacks {error}", path=str(path)) from error


def of_scene(scene: Scene) -> Snapshot:
    """Return the start configuration of a scene."""
    snapshot = _of_beads(scene, "CONFIG", 0, scene.beads.positions, scene.cell)
    return replace(snapshot, values=start_arrays(scene))


def of_configuration_file(path: Path) -> Snapshot:
    """Read a CONFIG or REVCON. Raises InputError when it is none."""
    read = read_config(path)
    cell = np.zeros((3, 3)) if read.cell is None else read.cell
    return Snapshot(path.name, read.step, *_kinds(read.names), read.positions, cell, periodic_of(read.imcon))


def with_beads(snapshot: Snapshot, table: BeadTable | None) -> Snapshot:
    """Return the configuration with what a BEADS file says of its beads, where it is of as many."""
    if table is None or len(table.values) != len(snapshot.kinds):
        return snapshot
    return replace(snapshot, values=dict(zip(table.names, table.values.T, strict=True)))


def of_frame(frame: Frame, file: str) -> Snapshot:
    """Return a frame of a trajectory."""
    carried = {name: values for name, values in frame.arrays.items() if name == TEMPERATURE or CONCENTRATION in name}
    kinds = _kinds(frame.names)
    return Snapshot(file, frame.step, *kinds, frame.positions, frame.cell, periodic_of(frame.imcon), carried)


def periodic_of(imcon: int) -> tuple[bool, bool, bool]:
    """Return along which cell vectors a configuration with this key is periodic."""
    return imcon != 0, imcon != 0, imcon not in (0, 6)


def _balance(scene: Scene, arrays: Mapping[str, NDArray[Any]]) -> tuple[SpeciesBalance, ...]:
    """As ``Simulation.species_balance``, of a checkpoint."""
    if scene.transport is None or "transport_tally" not in arrays:
        return ()
    tally = arrays["transport_tally"]
    rows = zip(
        scene.transport.species, arrays["start_amounts"], (tally[:3] + tally[3:]).T, arrays["concentrations"].T,
        strict=True,
    )  # fmt: skip
    return tuple(
        SpeciesBalance(
            name, float(start), float(given[0]), float(given[1]), float(given[2]), math.fsum(column.tolist())
        )
        for name, start, given, column in rows
    )


def _of_beads(scene: Scene, file: str, step: int, positions: FloatArray, cell: FloatArray) -> Snapshot:
    return Snapshot(file, step, scene.species, scene.beads.species.astype(np.int64), positions, cell, scene.periodic)


def _kinds(names: Sequence[str]) -> tuple[tuple[str, ...], NDArray[np.int64]]:
    species = tuple(dict.fromkeys(names))
    number = {name: k for k, name in enumerate(species)}
    return species, np.array([number[name] for name in names], dtype=np.int64)
