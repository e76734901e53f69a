"""Single points of LAMMPS through the translation, on ranks that stay from test to test."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pydlpoly import Scene, single_point
from pydlpoly.engines.lammps_team import ProcessTeam
from pydlpoly.engines.lammps_translate import translate
from pydlpoly.formats.records import FloatArray

EXACT = 1e-10  # of the largest force


def lammps_point(team: ProcessTeam, scene: Scene) -> tuple[dict[str, Any], FloatArray]:
    """Return energies and virials by part, and forces (N, 3), of the scene's configuration."""
    translation = translate(scene, 5)
    velocities = np.zeros((scene.bead_count, 3)) if scene.beads.velocities is None else scene.beads.velocities
    path = team.folder / "point.data"
    with path.open("w") as file:
        beads = scene.beads
        file.writelines(translation.data.pieces(beads.positions, velocities, beads.temperature, beads.concentrations))
    carried = translation.carried
    commands = [*translation.commands(str(path)), *translation.carried_computes()]
    answers = team.ask("load", commands, (carried.heat, carried.density, carried.dissolved))
    parts = team.ask("beads")
    ids = np.concatenate([part["id"] for part in parts])
    assert len(ids) == scene.bead_count
    return translation.observed.parts(answers[0]), np.concatenate([part["f"] for part in parts])[np.argsort(ids)]


def assert_same_point(team: ProcessTeam, scene: Scene, error: float = EXACT) -> None:
    """Compare forces, energies and stress of LAMMPS with those of the native core."""
    seen, forces = lammps_point(team, scene)
    point = single_point(scene)
    largest = np.abs(point.forces).max()
    assert largest > 0.1
    assert np.abs(point.forces - forces).max() <= error * largest
    size = sum(abs(value) for value in point.energy.values())
    assert point.energy["pair"] == pytest.approx(seen["pair_energy"], abs=error * size)
    assert point.energy["charge"] == pytest.approx(seen["charge_energy"], abs=error * size)
    for kind, value in zip(("bond", "angle", "dihedral"), seen["bonded_energies"], strict=False):
        assert point.energy[kind] == pytest.approx(value, abs=error * size), kind
    stress = (seen["conservative"] + seen["charge"] + np.sum(seen["bonded"], axis=0)) / seen["volume"]
    # The virial is a sum over many pairs, in which terms of both signs cancel.
    assert np.abs(point.stress - stress).max() <= 10.0 * error * max(np.abs(stress).max(), largest)
