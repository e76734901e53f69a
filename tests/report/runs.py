"""Runs whose reports are looked at: a healthy one with all files, too hot, killed, empty, and of no steps."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from pydlpoly.runner import run_scene
from pydlpoly.scene import load

from ..run_folders import run_folder

# The installed script: from the repository root, -m would find the source folder without the compiled core.
COMMAND = str(Path(sys.executable).with_name("pydlpoly"))
ALL_FILES = {
    "time_run": "1200 steps",
    "time_equilibration": "600 steps",
    "stats_frequency": "5 steps",
    "diagnostics_frequency": "5 steps",
    "print_frequency": "50 steps",
    "traj_interval": "100 steps",
    "zden_calculate": "on",
    "zden_frequency": "10 steps",
    "zden_binsize": "0.2 dpd_l",
    "stress_profile_frequency": "10 steps",
    "vaf_calculate": "on",
    "vaf_frequency": "20 steps",
    "vaf_binsize": "20",
}
HOT = {
    "timestep": "0.09 dpd_t",
    "time_run": "800 steps",
    "time_equilibration": "200 steps",
    "stats_frequency": "5 steps",
    "diagnostics_frequency": "5 steps",
}
LONG = {"time_run": "1000000 steps", "data_dump_frequency": "200000 steps", "traj_interval": "50 steps"}


def healthy(folder: Path) -> Path:
    run_scene(load(run_folder(folder, ALL_FILES)), folder)
    return folder


def hot(folder: Path) -> Path:
    run_scene(load(run_folder(folder, HOT)), folder)
    return folder


def killed(folder: Path) -> Path:
    """A run that SIGKILL ends in the middle, with some frames in HISTORY, the last of which is then cut short."""
    run_folder(folder, LONG)
    history = folder / "HISTORY"
    process = subprocess.Popen([COMMAND, "run", str(folder), "--quiet"])
    try:
        until = time.monotonic() + 120.0
        while time.monotonic() < until and (not history.is_file() or history.stat().st_size < 150_000):
            assert process.poll() is None
            time.sleep(0.05)
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
    with history.open("r+b") as file:
        file.truncate(history.stat().st_size - 1000)
    return folder


def empty(folder: Path) -> Path:
    folder.mkdir(parents=True)
    return folder


def no_steps(folder: Path) -> Path:
    run_scene(load(run_folder(folder)), folder, steps=0)
    return folder


CARRIED = {
    "time_run": "160 steps",
    "time_equilibration": "40 steps",
    "stats_frequency": "4 steps",
    "diagnostics_frequency": "4 steps",
    "print_frequency": "20 steps",
    "traj_interval": "20 steps",
    "traj_format": "[h5md]",
    "io_file_history": "NONE",
    "profile_frequency": "4 steps",
    "profile_axis": "x",
    "profile_bins": "8",
    "map_frequency": "4 steps",
    "map_plane": "xz",
    "map_bins": "[ 6 5 ]",
    "correlation_observable": "[ s_xy-s_xy s_xz-s_xz s_xx-s_yy ]",
    "correlation_block_points": "[ 12 ]",
}
BLOCKS = """
extension heat
capacity A 60
capacity B 80
pair A A kappa 0.02 range 1.2
pair A B kappa 0.02 range 1.2
source layer x 0 1 0.5
end extension
extension transport
species sugar salt
pair * * sugar kappa 2.0 range 1.2
start sugar 1.0 box -2 0 * * * *
start salt 0.5
source sugar 0.3 box * * * * -1 1
reaction 0.2 sugar -> salt
end extension
"""


def carried_inputs(folder: Path, settings: dict[str, str] | None = None) -> Path:
    """Beads that carry heat and dissolved species."""
    run_folder(folder, {**CARRIED, **(settings or {})})
    with (folder / "FIELD").open("a", encoding="utf-8") as file:
        file.write(BLOCKS)
    return folder


def carried(folder: Path) -> Path:
    """All averages, heat and dissolved species, and a trajectory that is no HISTORY."""
    run_scene(load(carried_inputs(folder)), folder)
    return folder


MAKERS = {"healthy": healthy, "hot": hot, "killed": killed, "empty": empty, "no-steps": no_steps, "carried": carried}
