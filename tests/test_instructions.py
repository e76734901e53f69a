"""A scene pays for what it has: instructions of a bead and step, which no noise of a machine changes, by valgrind.

Ratios of counts, because compilers differ. Where a change of the code moves a ratio out of its bounds, either a scene
pays for what it does not have, or the bounds belong to another compiler: docs/performance.md says how they are counted.
"""

from __future__ import annotations

import importlib.util
import shutil
from functools import cache
from pathlib import Path
from types import ModuleType

import pytest

from pydlpoly import Simulation
from pydlpoly.bench import scenes
from pydlpoly.errors import PydlpolyError

BEADS = 3000
SCENES = {
    "water": f"scenes.water({BEADS})",
    "mixture": f"scenes.mixture({BEADS})",
    "chains": f"scenes.polymer_melt({BEADS // 20})",
}


@cache
def script() -> ModuleType:
    """``docs/callgrind.py`` as a module."""
    path = Path(__file__).resolve().parents[1] / "docs" / "callgrind.py"
    spec = importlib.util.spec_from_file_location("docs_callgrind", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def count(name: str) -> float:
    return float(script().instructions_of(SCENES[name], BEADS))


@pytest.fixture(autouse=True)
def _tools(monkeypatch: pytest.MonkeyPatch) -> None:
    if shutil.which("valgrind") is None:
        pytest.skip("valgrind is not installed")
    monkeypatch.setenv("PYDLPOLY_SIMD", "avx2")
    try:
        Simulation(scenes.water(500), seed=1)
    except (PydlpolyError, ValueError):
        pytest.skip("this processor or this build has no avx2")


@pytest.mark.slow
def test_one_species_looks_nothing_up() -> None:
    """Two species cost their look-ups: about a tenth; without any difference one species would be paying for them."""
    assert 1.04 < count("mixture") / count("water") < 1.25


@pytest.mark.slow
def test_bonds_are_paid_for_by_scenes_that_have_them() -> None:
    """Each bead of a chain has a bond."""
    assert 1.05 < count("chains") / count("water") < 1.6
