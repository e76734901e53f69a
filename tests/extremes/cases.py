"""The list of all cases, which the tests and docs/extremes.py share."""

from __future__ import annotations

from . import contacts, counts, geometry, heat, integrators, long_runs, magnitudes, noise
from .framework import Case, Seen

__all__ = ["CASES", "Case", "Seen"]

CASES: list[Case] = [
    *contacts.CASES,
    *magnitudes.CASES,
    *geometry.CASES,
    *counts.CASES,
    *long_runs.CASES,
    *noise.CASES,
    *integrators.CASES,
    *heat.CASES,
]
