"""Weights of drag and noise with any exponent, on batches of pairs."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly.simulation import Simulation

from .scene_builder import make_scene


@pytest.mark.parametrize("exponent", [0.01, 0.41, 1.0, 1.9, 3.0, 4.0, 12.5])
@pytest.mark.parametrize("distance", [1e-3, 0.25, 0.5, 0.9, 0.999, 1.0 - 1e-5])
def test_drag_and_noise_of_two_beads(exponent: float, distance: float) -> None:
    """Virials −γ w^D u r and σ √w^D ζ r/√Δt with w^D = (1 − r/r_c)^s, u = v·e; ζ is the same for every exponent."""
    virials = {}
    for s in (2.0, exponent):
        scene = make_scene(
            {"A": 2},
            ["A A dpd 0.0 1.0 4.5"],
            cell=10.0,
            positions=np.array([[0.0, 0.0, 0.0], [distance, 0.0, 0.0]]),
            velocities=np.array([[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]]),
            control={"ensemble_dpd_exponent": f"{s}"},
        )
        seen = Simulation(scene, seed=3, threads=1).observe()
        parts = seen.stress_parts
        virials[s] = (parts["drag"][0, 0] * seen.volume, parts["noise"][0, 0] * seen.volume)
    closeness = 1.0 - distance
    assert virials[exponent][0] == pytest.approx(4.5 * closeness**exponent * distance, rel=1e-9)
    assert virials[exponent][1] == pytest.approx(virials[2.0][1] * closeness ** (0.5 * exponent - 1.0), rel=1e-6)
