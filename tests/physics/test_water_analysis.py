"""DPD water (a = 25, γ = 4.5, ρ = 3) through HISTORY and the analyses: diffusion and g(r) of independent programs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pydlpoly.analysis import MeanSquareDisplacement, RadialDistribution, VelocityAutocorrelation, analyse
from pydlpoly.runner import run_scene

from ..scene_builder import make_scene
from .test_dpd_water import G

EDGE, BEADS = 8.0, 1536


@pytest.fixture(scope="module", params=["middle", "ou-middle"])
def history(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """3000 steps of 0.02 after 250 to equilibrate, a frame every 10."""
    control = {
        "ensemble_dpd_order": request.param,
        "timestep": "0.02 internal_t",
        "traj_calculate": "on",
        "traj_key": "pos-vel",
        "traj_start": "250 steps",
        "traj_interval": "10 steps",
    }
    folder = tmp_path_factory.mktemp(request.param)
    run_scene(make_scene({"A": BEADS}, cell=EDGE, control=control), folder, steps=3250, seed=21, threads=1)
    return folder / "HISTORY"


@pytest.mark.slow
def test_diffusion_and_structure_of_water(history: Path) -> None:
    """0.293 ± 0.004 from MSD between 5 and 10; the error here is about 0.004, and 0.003 for a bin of g(r)."""
    moved = MeanSquareDisplacement(longest=10.0, fit=(5.0, 10.0))
    pairs = RadialDistribution(bin_width=0.05, reach=1.0)
    velocities = VelocityAutocorrelation(longest=10.0)
    assert analyse(history, moved, pairs, velocities) == 301
    msd, rdf, vaf = moved.result(), pairs.result(), velocities.result()
    assert msd.diffusion[0] == pytest.approx(0.293, abs=0.015)
    assert 0.001 < msd.diffusion_error[0] < 0.01
    assert np.abs(rdf.g[0] - np.array(G)).max() < 0.02
    assert rdf.error.max() < 0.01
    assert vaf.at_origin[0] == pytest.approx(3.0, rel=0.02)
