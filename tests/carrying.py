"""Scenes whose beads carry internal temperatures and dissolved species, made of scenes that do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pydlpoly import Scene


def carrying(scene: Scene, *, heat: bool = True, species: int = 2, seed: int = 5) -> Scene:
    """Return the scene with random temperatures (k_B T from 0.5 to 1.5), C_v/k_B = 100, and concentrations."""
    random, count = np.random.default_rng(seed), scene.bead_count
    beads = scene.beads
    if heat:
        beads = replace(beads, temperature=random.random(count) + 0.5, heat_capacity=np.full(count, 100.0))
    if species:
        beads = replace(beads, concentrations=random.random((count, species)))
    return replace(scene, beads=beads)
