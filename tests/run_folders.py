"""Folders with CONTROL, FIELD and CONFIG of a small two-component DPD fluid, for tests of whole runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

_SETTINGS = {
    "title": "test run",
    "temperature": "1.0 dpd_temp",
    "ensemble": "nvt",
    "ensemble_method": "dpd",
    "ensemble_dpd_order": "mdvv",
    "cutoff": "1.0 dpd_l",
    "vdw_method": "direct",
    "timestep": "0.01 dpd_t",
    "time_run": "40 steps",
    "time_equilibration": "0 steps",
    "random_seed": "[ 1 2 3 ]",
    "print_frequency": "20 steps",
    "stats_frequency": "10 steps",
    "traj_calculate": "on",
    "traj_interval": "10 steps",
    "rdf_calculate": "on",
    "rdf_frequency": "10 steps",
    "data_dump_frequency": "20 steps",
}
EDGE = 4.0
COUNTS = {"A": 120, "B": 40}


def control_text(settings: Mapping[str, str | None] | None = None) -> str:
    """CONTROL with the given settings in place of, or (None) without, the usual ones."""
    merged = {**_SETTINGS, **(settings or {})}
    return "".join(f"{keyword} {value}\n" for keyword, value in merged.items() if value is not None)


def run_folder(folder: Path, settings: Mapping[str, str | None] | None = None) -> Path:
    """Write the three files into ``folder``, which is made, and return it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "CONTROL").write_text(control_text(settings))
    molecules = "".join(f"{n}s\nnummols {count}\natoms 1\n{n} 1.0 0.0\nfinish\n" for n, count in COUNTS.items())
    pairs = "A A dpd 25.0 1.0 4.5\nA B dpd 30.0 1.0 4.5\nB B dpd 25.0 1.0 9.0\n"
    (folder / "FIELD").write_text(f"test fluid\nunits dpd\nmolecules 2\n{molecules}vdw 3\n{pairs}close\n")
    names = [name for name, count in COUNTS.items() for _ in range(count)]
    places = (np.random.default_rng(7).random((len(names), 3)) - 0.5) * EDGE
    lines = ["test fluid", f"0 1 {len(names)}", f"{EDGE} 0 0", f"0 {EDGE} 0", f"0 0 {EDGE}"]
    for number, (name, place) in enumerate(zip(names, places, strict=True), 1):
        lines += [f"{name} {number}", " ".join(f"{x:.12f}" for x in place)]
    (folder / "CONFIG").write_text("\n".join([*lines, ""]))
    return folder


def listing(folder: Path) -> dict[str, bytes]:
    """Every file under ``folder`` with its content."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}
