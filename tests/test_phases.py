"""docs/dl_meso_phases.py tells shapes apart: spheres, rods, slabs and what fills a periodic cell."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest


@pytest.fixture(scope="module")
def phases() -> ModuleType:
    path = Path(__file__).parents[1] / "docs" / "dl_meso_phases.py"
    spec = importlib.util.spec_from_file_location("dl_meso_phases", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["dl_meso_phases"] = module  # its dataclass looks itself up there
    spec.loader.exec_module(module)
    return module


def test_directions_and_pieces(phases: ModuleType) -> None:
    """Across the faces of the cell, too: each shape is moved so that it lies on one."""
    x, y, z = np.meshgrid(*(np.arange(n) - n // 2 for n in (12, 16, 20)), indexing="ij")
    shapes = [x**2 + y**2 + z**2 < 16, x**2 + y**2 < 9, np.abs(x) < 3, np.ones(x.shape, dtype=bool)]
    for expected, shape in enumerate(shapes):
        moved = np.roll(shape, (6, 8, 10), axis=(0, 1, 2))
        assert phases.directions(moved) == expected
        assert len(phases.pieces(moved)) == 1
    # A rod along the diagonal of two axes reaches itself along one direction only.
    assert phases.directions(((x - np.floor(y * 12 / 16)) % 12) + 12 * ((z % 20) > 2) < 3) == 1
    two = (x**2 + y**2 + z**2 < 9) | ((np.abs(x) > 4) & (np.abs(y) > 5) & (np.abs(z) > 7))
    assert len(phases.pieces(two)) == 2


def test_local_directions(phases: ModuleType) -> None:
    """Waves along one, two and three axes have 1 0 0, 1/2 1/2 0 and 1/3 1/3 1/3; two grains of layers nearly 1 0 0."""
    x, y, z = (2.0 * np.pi * axis / 6.0 for axis in np.meshgrid(*([np.arange(48)] * 3), indexing="ij"))
    wave = 6 * 0.5  # lattice spacing 1/2
    for count in (1, 2, 3):
        share = sum(np.sin(axis) for axis in (x, y, z)[:count])
        assert phases.local_directions(share, wave) == pytest.approx([1 / count] * count + [0] * (3 - count), abs=0.005)
    grains = np.where(z < 2.0 * np.pi * 4, np.sin(x), np.sin(y))
    assert phases.local_directions(grains, wave)[0] > 0.8
