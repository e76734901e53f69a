"""The figures of a report: by name, each made from a run when it holds what the figure shows."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from pydlpoly.analysis.profile_plot import GROUPS
from pydlpoly.drawing import look
from pydlpoly.report import binned, carried, cell, coloured, correlated
from pydlpoly.report.against_time import energy, energy_terms, momentum, pressure, temperature
from pydlpoly.report.collect import Run
from pydlpoly.report.picture import last_frame, start_frame
from pydlpoly.report.speed import speed, time_spent
from pydlpoly.report.structure import density, displacement, distribution, stress_profile, velocity
from pydlpoly.report.style import Drawing

FIGURES: dict[str, Callable[[Run], Drawing | None]] = {
    "last": last_frame,
    "start": start_frame,
    "temperature": temperature,
    "pressure": pressure,
    "energy": energy,
    "energy-terms": energy_terms,
    "internal-temperature": carried.internal_temperature,
    "conserved": carried.conserved,
    "species": carried.species,
    "momentum": momentum,
    "volume": cell.volume,
    "cell": cell.cell,
    "rdf": distribution,
    "density": density,
    **{f"profile-{group}": partial(binned.profile, group=group) for group in GROUPS},
    "stress-profile": stress_profile,
    "stress-relaxation": correlated.relaxation,
    "viscosity": correlated.viscosity,
    "correlations": correlated.others,
    "msd": displacement,
    "vaf": velocity,
    "speed": speed,
    "time": time_spent,
}
"""What can be drawn of any run; a function returns None when the run lacks what it needs."""


def figures_of(run: Run) -> dict[str, Callable[[Run], Drawing | None]]:
    """Return ``FIGURES`` and, in their places, those that only this run has: what its beads carry, maps."""
    found: dict[str, Callable[[Run], Drawing | None]] = {}
    for name, figure in FIGURES.items():
        if name == "temperature":
            carries = coloured.carried_by(run)[: coloured.MOST_SPECIES]
            found |= {f"last-{one}": partial(coloured.by_value, quantity=one) for one in carries}
        if name == "stress-profile":
            maps = binned.maps_of(run)[: binned.MOST_MAPS]
            found |= {f"map-{one}": partial(binned.averages_in_plane, quantity=one) for one in maps}
        found[name] = figure
    return found


def draw(run: Run, name: str) -> Drawing | None:
    """Return one of ``figures_of``, None when the run lacks what it needs."""
    with look():
        return figures_of(run)[name](run)
