"""The figures of a report: by name, each made from a run when it holds what the figure shows."""

from __future__ import annotations

from collections.abc import Callable

from pydlpoly.drawing import look
from pydlpoly.report.against_time import energy, energy_terms, momentum, pressure, temperature, volume
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
    "momentum": momentum,
    "volume": volume,
    "rdf": distribution,
    "density": density,
    "stress-profile": stress_profile,
    "msd": displacement,
    "vaf": velocity,
    "speed": speed,
    "time": time_spent,
}
"""What can be drawn, in the order of the report; a function returns None when the run lacks what it needs."""


def draw(run: Run, name: str) -> Drawing | None:
    """Return one of ``FIGURES``, None when the run lacks what it needs."""
    with look():
        return FIGURES[name](run)
