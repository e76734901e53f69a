"""The list of all cases, which the tests and docs/extremes.py share."""

from __future__ import annotations

from . import contacts, counts, densities, geometry, integrators, long_runs, magnitudes, noise, species
from .framework import Case, Seen

__all__ = ["CASES", "Case", "Seen"]

CASES: list[Case] = [
    *contacts.CASES,
    *magnitudes.CASES,
    *geometry.CASES,
    *counts.CASES,
    *long_runs.CASES,
    *noise.CASES,
    *densities.CASES,
    *integrators.CASES,
    *species.CASES,
]
