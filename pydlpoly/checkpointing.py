"""A run in a checkpoint: the arrays of an engine and of what it observed, and the way back.

A checkpoint is of no engine: any can go on from it. ``formats.checkpoint`` has the file, ``scene.serialise`` the scene
in it, ``Simulation.save`` and ``Simulation.resume`` put all parts together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.engines.protocol import Engine
from pydlpoly.engines.totals import Totals
from pydlpoly.scene.continuation import check_continues
from pydlpoly.scene.model import Scene
from pydlpoly.scene.serialise import scene_from_arrays

Arrays = dict[str, NDArray[Any]]


def engine_to_arrays(engine: Engine, scene: Scene) -> Arrays:
    """Return the state of an engine as arrays by name."""
    system = engine.system
    arrays = {
        "positions": np.asarray(system.positions),
        "velocities": np.asarray(system.velocities),
        "forces": np.asarray(system.forces),
        "images": np.asarray(system.images),
        "cell": np.ascontiguousarray(system.cell),
        "thermostat": np.asarray(system.thermostat, dtype=np.float64),
    }
    if scene.beads.temperature is not None:
        arrays["bead_temperatures"] = np.asarray(system.bead_temperatures)
    if scene.heat is not None:
        arrays["heat_account"] = np.asarray(engine.heat_account)
    if scene.beads.concentrations is not None:
        arrays["concentrations"] = np.asarray(system.concentrations)
    if engine.transport is not None:
        arrays["transport_tally"] = np.asarray(engine.transport.tally)
    if scene.output.rdf_every > 0:
        arrays["distance_counts"] = np.asarray(system.distance_counts())
    return arrays


def engine_numbers(engine: Engine) -> dict[str, int | float]:
    """Return the numbers that belong to ``engine_to_arrays``, by name."""
    system = engine.system
    return {
        "step": int(system.step),
        "time": float(system.time),
        "distance_samples": int(system.distance_samples),
        "distance_volumes": float(system.distance_volumes),
    }


def restore_engine(engine: Engine, scene: Scene, arrays: Arrays, numbers: Mapping[str, Any]) -> None:
    """Bring an engine of the scene to where the arrays and numbers were taken.

    Raises:
        KeyError, TypeError, ValueError: something is missing or has another type or shape.
    """
    system = engine.system
    system.step, system.time = int(numbers["step"]), float(numbers["time"])
    system.cell = arrays.get("cell", scene.cell)
    system.positions = arrays["positions"]
    system.velocities = arrays["velocities"]
    system.thermostat = arrays["thermostat"].tolist()
    if scene.beads.temperature is not None:
        system.bead_temperatures = arrays["bead_temperatures"].tolist()
    if scene.beads.concentrations is not None:
        system.concentrations = arrays["concentrations"]
    if engine.transport is not None:
        engine.transport.tally = arrays["transport_tally"]
    engine.initialise()
    system.velocities = arrays["velocities"]  # of the whole step; some fields prescribe others between its kicks
    if scene.heat is not None:
        engine.heat_account = tuple(arrays["heat_account"].tolist())
    system.forces = arrays["forces"]
    system.images = arrays["images"]
    if scene.output.rdf_every > 0 and "distance_counts" in arrays:
        samples = int(numbers["distance_samples"])
        volumes = float(numbers.get("distance_volumes", samples * system.volume))
        system.restore_distances(arrays["distance_counts"].tolist(), samples, volumes)


def totals_to_arrays(totals: Totals) -> Arrays:
    """Return what an engine observed as arrays by name."""
    return {f"totals.{name}": np.asarray(value) for name, value in asdict(totals).items()}


def totals_from_arrays(arrays: Arrays) -> Totals:
    """Return what ``totals_to_arrays`` was given. Raises KeyError when something is missing."""
    return Totals(
        **{name: np.asarray(arrays[f"totals.{name}"]) for name in ("conservative", "drag", "noise", "kinetic")},
        pair_energy=float(arrays["totals.pair_energy"]),
        momentum=arrays["totals.momentum"],
        volume=float(arrays["totals.volume"]),
        bonded_energies=arrays["totals.bonded_energies"],
        bonded=arrays["totals.bonded"],
        charge_energy=float(arrays.get("totals.charge_energy", 0.0)),  # checkpoints of before charges have none
        charge=arrays.get("totals.charge", np.zeros((3, 3))),
        thermostat_energy=float(arrays["totals.thermostat_energy"]),
        constraint=arrays.get("totals.constraint", np.zeros((3, 3))),
        field_energy=float(arrays.get("totals.field_energy", 0.0)),
        internal_energy=float(arrays.get("totals.internal_energy", 0.0)),
        heat_balance=float(arrays.get("totals.heat_balance", 0.0)),
    )


def scene_to_continue(arrays: Arrays, meta: Mapping[str, Any], scene: Scene | None, path: str) -> Scene:
    """Return the scene of a checkpoint, or ``scene`` in its place, with the cell that the run has by now.

    Raises:
        InputError: the checkpoint, named ``path``, cannot go on as ``scene``.
        KeyError, TypeError, ValueError: something is missing or has another type or shape.
    """
    stored = scene_from_arrays(arrays, meta["scene"])
    chosen = stored if scene is None else scene
    cell = arrays.get("cell", stored.cell)  # checkpoints of before there were barostats have none
    check_continues(stored, chosen, path, (cell, arrays.get("start_cell", cell)))
    # A cell that went through REVCON has lost its last digits; tethers still hold where the run began.
    bonded = chosen.bonded
    if bonded is not None and stored.bonded is not None and stored.bonded.anchors is not None:
        bonded = replace(bonded, anchors=stored.bonded.anchors)
    imcon = 2 if chosen.imcon == 1 and len(set(np.diag(cell).tolist())) > 1 else chosen.imcon
    return replace(chosen, cell=cell, imcon=imcon, bonded=bonded)
