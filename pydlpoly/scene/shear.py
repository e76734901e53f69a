"""Steady shear by Lees–Edwards boundaries: the flow u_x = rate · y of a cell that is periodic along all axes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pydlpoly.formats.records import Configuration, Field, FloatArray
from pydlpoly.scene.beads import Layout, has_tethers
from pydlpoly.scene.model import Dynamics, ExternalTerm, Walls
from pydlpoly.scene.settings import Notes, Settings

WITH_SHEAR = ("nve", "mdvv", "zeroth", "first", "second", "peters", "peters-first", "lowe-andersen", "stoyanov-groot",
              "ou", "ou-middle", "middle")  # fmt: skip
"""Integrators that are modelled with ``shear_rate``."""

SHEARED_SHAPE = 3
"""The cell of a sheared scene tilts: its files have imcon 3."""


def unfit_for_shear(dynamics: Dynamics) -> tuple[str, str] | None:
    """Return the keyword and the reason where a sheared cell does not fit the integrator, else None."""
    if dynamics.integrator not in WITH_SHEAR:
        message = f"{dynamics.integrator} is not modelled in a sheared cell; these are: {', '.join(WITH_SHEAR)}"
        return "shear_rate", message
    if dynamics.integrator == "mdvv" and dynamics.prediction != 0.5:
        return "ensemble_dpd_lambda", "a sheared cell goes with lambda 0.5 only"
    if dynamics.half_step_kinetic:
        message = "half is not modelled in a sheared cell: the flow at a bead belongs to the whole step"
        return "ensemble_dpd_kinetic", message
    return None


def resolve_shear(settings: Settings, dynamics: Dynamics, notes: Notes) -> Dynamics:
    """Return the dynamics with the shear rate of CONTROL (1/ps).

    Raises:
        SceneError: an integrator that is not modelled in a sheared cell, or settings that do not go with one.
    """
    rate = settings.number("shear_rate")
    if rate == 0.0:
        return dynamics
    if not math.isfinite(rate):
        raise settings.refusal("shear_rate", "the shear rate must be finite")
    unfit = unfit_for_shear(dynamics)
    if unfit is not None:
        raise settings.refusal(*unfit)
    if dynamics.barostat is not None:
        raise settings.refusal("shear_rate", "a cell that follows the pressure cannot be sheared")
    if settings.word("coul_method") != "off":
        raise settings.refusal("shear_rate", "electrostatics are not modelled in a sheared cell")
    if dynamics.integrator == "nve":
        notes.warning("a sheared fluid without a thermostat heats up", settings.where("shear_rate"))
    return replace(dynamics, shear_rate=rate)


def check_shear(
    dynamics: Dynamics,
    settings: Settings,
    config: Configuration,
    cell: FloatArray,
    field: Field,
    layout: Layout,
    external: tuple[ExternalTerm, ...],
    walls: Walls | None,
) -> None:
    """Raise SceneError where something in the scene does not go with a sheared cell."""
    if dynamics.shear_rate == 0.0:
        return
    tilted = np.array(cell)
    tilted[1, 0] = 0.0
    reasons = {
        f"periodicity key imcon {config.imcon} is not modelled with it; 1, 2 and 3 are": config.imcon not in (1, 2, 3),
        "the cell must be orthorhombic, or tilted along x in its second vector alone": bool(
            np.any(tilted != np.diag(np.diag(tilted))) or np.any(np.diag(tilted) <= 0.0)
        ),
        "frozen beads are not modelled with it": bool(layout.frozen.any()),
        "external fields are not modelled with it": bool(external),
        "walls are not modelled with it": walls is not None,
        "tethers are not modelled with it": has_tethers(field),
    }
    for reason, met in reasons.items():
        if met:
            raise settings.refusal("shear_rate", f"a sheared cell: {reason}")
