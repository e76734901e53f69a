"""Dissipative particle dynamics from DL_POLY-format files, ASE structures and Python."""

from __future__ import annotations

import os

# Threads wait for each other in every step. GNU's OpenMP would spin for long before it sleeps, which starves the very
# thread that is waited for when the processors are shared; it reads this variable when the core is loaded.
os.environ.setdefault("GOMP_SPINCOUNT", "20000")

try:
    from pydlpoly._core import __version__
except ImportError as error:  # the source folder shadows the installed package, or the install is broken
    raise ImportError(
        "pydlpoly's compiled core is missing. If you are in a checkout of pydlpoly, its source folder hides the "
        "installed package: install with `pip install -e .`, or run Python from another folder. Otherwise reinstall "
        f"with `pip install pydlpoly`. ({error})"
    ) from error

from pydlpoly.errors import InputError, InputWarning, PydlpolyError, RunError, SceneError
from pydlpoly.observation import Observation, SinglePoint, single_point
from pydlpoly.scene import Scene, load
from pydlpoly.simulation import Simulation
from pydlpoly.state import State

__all__ = [
    "InputError",
    "InputWarning",
    "Observation",
    "PydlpolyError",
    "RunError",
    "Scene",
    "SceneError",
    "Simulation",
    "SinglePoint",
    "State",
    "__version__",
    "load",
    "single_point",
]
