"""Constant pressure: which edges of the cell move, at which pressure, and what the piston cannot do."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import cast

import numpy as np

from pydlpoly.formats.records import Configuration, Field
from pydlpoly.scene.beads import Layout, has_tethers
from pydlpoly.scene.integrators import WITH_BAROSTAT
from pydlpoly.scene.model import Barostat, CellMotion, Dynamics, ExternalTerm, SemiIsotropic
from pydlpoly.scene.settings import Notes, Settings

_PRESSURES = ("pressure_hydrostatic", "pressure_tensor", "pressure_perpendicular")
_MOTIONS: dict[tuple[SemiIsotropic, bool], CellMotion] = {
    ("off", False): "edges",
    ("area", False): "height",
    ("tension", False): "edges",
    ("tension", True): "square",
    ("orthorhombic", False): "edges",
    ("orthorhombic", True): "square",
}


def resolve_barostat(settings: Settings, dynamics: Dynamics, notes: Notes) -> Dynamics:
    """Return the dynamics with the piston that ``ensemble npt`` or ``nst`` asks for; without one as they are.

    Raises:
        SceneError: an integrator without a barostat, no temperature, or numbers that make no piston.
    """
    ensemble = settings.word("ensemble")
    if ensemble not in ("npt", "nst"):
        return dynamics
    if dynamics.integrator not in WITH_BAROSTAT:
        names = ", ".join(WITH_BAROSTAT)
        message = f"ensemble {ensemble} is not modelled with {dynamics.integrator}; it is with {names}"
        raise settings.refusal("ensemble_dpd_order", message)
    if not dynamics.thermal_energy > 0.0:
        raise settings.refusal("ensemble", f"ensemble {ensemble} needs a temperature above 0: the piston's mass has it")
    semi = cast(SemiIsotropic, settings.word("ensemble_semi_isotropic") if ensemble == "nst" else "off")
    tied = semi in ("tension", "orthorhombic") and settings.switch("ensemble_semi_orthorhombic")
    motion: CellMotion = "isotropic" if ensemble == "npt" else _MOTIONS[semi, tied]
    if motion == "edges":
        text = "each edge of the cell moves by its own: solids hold their shape, liquids do not"
        notes.choice(text, settings.where("ensemble"))
    friction = settings.number("ensemble_barostat_friction")
    if not friction > 0.0:
        keyword = "ensemble_barostat_friction" if settings.given("ensemble_barostat_friction") else "ensemble"
        raise settings.refusal(keyword, "the piston needs an ensemble_barostat_friction above 0")
    barostat = Barostat(
        motion=motion,
        semi=semi,
        pressure=_pressure(settings, motion, notes),
        tension=settings.number("ensemble_tension") if semi == "tension" else 0.0,
        relaxation=_relaxation(settings, friction, notes),
        friction=friction,
    )
    return replace(dynamics, barostat=barostat)


def _relaxation(settings: Settings, friction: float, notes: Notes) -> float:
    relaxation = settings.number("ensemble_barostat_coupling")
    if not settings.given("ensemble_barostat_coupling"):
        relaxation = 1.0 / (2.0 * math.pi * friction)
        where = settings.where("ensemble_barostat_friction")
        notes.choice(f"no ensemble_barostat_coupling: {relaxation:.6g} ps, which is 1/(2 pi friction)", where)
    elif not relaxation > 0.0:
        message = f"the piston's relaxation time must be above 0, not {relaxation:g}"
        raise settings.refusal("ensemble_barostat_coupling", message)
    return relaxation


def _pressure(settings: Settings, motion: CellMotion, notes: Notes) -> tuple[float, float, float]:
    """Return the target pressures on the faces across x, y and z."""
    settings.consumed.update(_PRESSURES)
    given = [keyword for keyword in _PRESSURES if settings.given(keyword)]
    if len(given) > 1:
        raise settings.refusal(given[1], f"the target pressure is given already, by {given[0]}")
    if not given:
        notes.choice("no target pressure is given: 0", settings.where("pressure_hydrostatic"))
        return (0.0, 0.0, 0.0)
    keyword = given[0]
    values = settings.vector(keyword)
    faces = np.array(values[:3]) if len(values) >= 3 else np.full(3, values[0])
    if motion == "isotropic" and np.ptp(faces) > 0.0:
        notes.choice(f"{keyword}: the cell keeps its shape, so the mean {faces.mean():.6g} counts (internal units)")
        faces[:] = faces.mean()
    elif any(values[3:]):
        raise settings.refusal(keyword, "the cell's angles stay 90 degrees: xy, xz and yz must be 0")
    if motion == "square" and faces[0] != faces[1]:
        raise settings.refusal(keyword, "x and y change by one factor: their pressures must be the same")
    return float(faces[0]), float(faces[1]), float(faces[2])


def check_barostat(
    dynamics: Dynamics,
    settings: Settings,
    config: Configuration,
    field: Field,
    layout: Layout,
    external: tuple[ExternalTerm, ...],
) -> None:
    """Raise SceneError where something in the scene does not go with a cell that moves."""
    if dynamics.barostat is None:
        return
    ensemble = settings.word("ensemble")
    reasons = {
        f"periodicity key imcon {config.imcon} is not modelled with it; 1 and 2 are": config.imcon not in (1, 2),
        "frozen beads are not modelled with it": bool(layout.frozen.any()),
        "external fields are not modelled with it": bool(external),
        "tethers are not modelled with it": has_tethers(field),
    }
    for reason, met in reasons.items():
        if met:
            raise settings.refusal("ensemble", f"ensemble {ensemble}: {reason}")


def shape_of(dynamics: Dynamics, imcon: int, settings: Settings, notes: Notes) -> int:
    """Return the scene's ``imcon``: a cube whose edges move apart is an orthorhombic cell (DL_POLY's warning 110)."""
    if imcon == 1 and dynamics.barostat is not None and dynamics.barostat.motion != "isotropic":
        notes.choice("ensemble nst: the cubic cell becomes an orthorhombic one (imcon 2)", settings.where("ensemble"))
        return 2
    return imcon
