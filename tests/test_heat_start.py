"""BEADS, callbacks, profiles and restarts of scenes whose beads carry heat by FIELD's extension."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pydlpoly
from pydlpoly import Simulation
from pydlpoly.callbacks import Moment, Source
from pydlpoly.formats.beads_file import read_beads, write_beads
from pydlpoly.formats.binned_table import read_binned
from pydlpoly.runner import run_scene

from .run_folders import run_folder

BLOCK = """extension heat
capacity A 100 temperature 1.0
capacity B 50 temperature 1.5
pair A A kappa 0.001 range 1.0
pair A B kappa 0.001 range 1.0
pair B B kappa 0.001 range 1.0
{more}end extension
"""
PROFILES = {"profile_frequency": "10 steps", "profile_bins": "6", "profile_quantities": "[ temperature velocity ]"}


def folder_of(folder: Path, settings: dict[str, str | None] | None = None, more: str = "") -> Path:
    """The usual run, whose beads carry heat."""
    run_folder(folder, settings)
    field = folder / "FIELD"
    field.write_text(field.read_text() + BLOCK.format(more=more))
    return folder


def test_a_column_replaces_the_block_s_temperatures(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "in")
    warm = 1.0 + np.random.default_rng(1).random(160)
    write_beads(folder / "BEADS", "t", ["temperature"], [warm])
    simulation = Simulation(pydlpoly.load(folder), seed=1, threads=1)
    np.testing.assert_array_equal(simulation.bead_arrays()["temperature"], warm)


def heating(moment: Moment) -> dict[str, np.ndarray]:
    """A source that depends on place, flow and temperature."""
    return {"temperature": np.where(moment.positions[:, 2] > 0.0, 0.5, 0.1) / moment.temperature}


@pytest.mark.parametrize("cut", [21, 24])
def test_runs_with_sources_in_python_continue_with_the_same_bits(tmp_path: Path, cut: int) -> None:
    scene = pydlpoly.load(folder_of(tmp_path / "in", PROFILES))
    calls = [(Source(heating), 6)]
    run_scene(scene, tmp_path / "whole", threads=1, callbacks=calls)
    run_scene(scene, tmp_path / "parts", threads=2, callbacks=calls, steps=cut)
    run_scene(scene, tmp_path / "parts", threads=1, callbacks=calls, checkpoint=tmp_path / "parts" / "REVIVE")
    for name in ("REVCON", "REVBEADS", "PROFILE", "HISTORY", "STATIS"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parts" / name).read_bytes(), name
    profile = read_binned(tmp_path / "whole" / "PROFILE")
    assert profile["temperature"][3:].mean() > profile["temperature"][:3].mean() + 0.01


def test_a_source_in_python_brings_the_heat_it_says(tmp_path: Path) -> None:
    """Σ C_v ΔT of a constant rate, against the same run without; both conserve their energies but for round-off."""
    scene = pydlpoly.load(folder_of(tmp_path / "in"))
    alone, heated = (Simulation(scene, seed=1, threads=1) for _ in range(2))
    heated.add_callback(Source(lambda _: {"temperature": 0.02}), every=5)
    for simulation in (alone, heated):
        simulation.run(5)
    capacities = scene.beads.heat_capacity
    gained = capacities @ (heated.state.temperature - alone.state.temperature)
    assert gained == pytest.approx(0.02 * 0.05 * capacities.sum(), rel=1e-9)


def test_restart_from_revcon_and_revbeads(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "in")
    result = run_scene(pydlpoly.load(folder), tmp_path / "out", threads=1)
    assert read_beads(tmp_path / "out" / "REVBEADS").names == ("temperature",)
    (tmp_path / "out" / "REVCON").rename(folder / "CONFIG")
    (tmp_path / "out" / "REVBEADS").rename(folder / "BEADS")
    again = pydlpoly.load(folder)
    assert again.beads.temperature.tobytes() == result.simulation.state.temperature.tobytes()
