"""What beads carry goes into trajectories and comes back as the start of a run; the shipped example with heat."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pydlpoly
from pydlpoly.cli import example_folder
from pydlpoly.errors import InputError
from pydlpoly.formats.beads_file import read_beads
from pydlpoly.formats.config import read_config
from pydlpoly.runner import run_scene
from pydlpoly.trajectories import read_frame
from pydlpoly.trajectories.convert import convert_trajectory

FORMATS = ("extxyz", "gsd", "h5md")


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four steps of the example from uneven temperatures, with a frame every 2."""
    scene = pydlpoly.load(example_folder("heat"))
    assert scene.beads.temperature is not None
    uneven = scene.beads.temperature * np.random.default_rng(2).uniform(0.9, 1.1, scene.bead_count)
    output = replace(scene.output, trajectory_every=2, trajectory_level=1, trajectory_formats=FORMATS)
    scene = replace(scene, output=output, beads=replace(scene.beads, temperature=uneven))
    folder = tmp_path_factory.mktemp("heat")
    result = run_scene(scene, folder, steps=4, seed=1, threads=1)
    np.save(folder / "temperatures.npy", result.simulation.bead_arrays()["temperature"])
    return folder


@pytest.mark.parametrize("name", FORMATS)
def test_temperatures_start_a_run(out: Path, name: str) -> None:
    file = out / f"TRAJECTORY.{name}"
    expected = np.load(out / "temperatures.npy")
    assert np.ptp(expected) > 0.1
    np.testing.assert_array_equal(read_frame(file).arrays["temperature"], expected)
    scene = pydlpoly.load(example_folder("heat"), config=file)
    simulation = pydlpoly.Simulation(scene, seed=1, threads=1)
    np.testing.assert_allclose(simulation.bead_arrays()["temperature"], expected, rtol=1e-15)


def test_a_file_that_control_names_comes_first(out: Path, tmp_path: Path) -> None:
    folder = tmp_path / "in"
    shutil.copytree(example_folder("heat"), folder)
    convert_trajectory(out / "TRAJECTORY.h5md", "config", folder / "other", frame=0)
    (folder / "BEADS").rename(folder / "first")
    control = folder / "CONTROL"
    control.write_text(control.read_text() + "io_file_beads first\n")
    scene = pydlpoly.load(folder, config=out / "TRAJECTORY.h5md")
    first = read_frame(out / "TRAJECTORY.h5md", 0).arrays["temperature"]
    simulation = pydlpoly.Simulation(scene, seed=1, threads=1)
    np.testing.assert_allclose(simulation.bead_arrays()["temperature"], first, rtol=1e-15)


def test_a_frame_becomes_config_and_beads(out: Path, tmp_path: Path) -> None:
    shutil.copy(out / "TRAJECTORY.gsd", tmp_path)
    made = convert_trajectory(tmp_path / "TRAJECTORY.gsd", "config")
    assert made == tmp_path / "CONFIG"
    assert read_config(made).step == 4
    table = read_beads(tmp_path / "BEADS")
    assert table.names == ("temperature",)
    np.testing.assert_array_equal(table.values[:, 0], np.load(out / "temperatures.npy"))
    made.unlink()
    with pytest.raises(InputError, match="BEADS: is there already"):
        convert_trajectory(tmp_path / "TRAJECTORY.gsd", "config")
