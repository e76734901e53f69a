"""Scenes in LAMMPS's words. One module a subject; ``translation`` puts them together.

Units are ``lj`` with the scene's internal numbers: temperatures are k_B T, k_B is 1, and nothing is converted.
"""

from __future__ import annotations

from pydlpoly.engines.lammps_translate.translation import Translation, noise_seed, translate

__all__ = ["Translation", "noise_seed", "translate"]
