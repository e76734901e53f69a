"""Integrators, external fields and frozen beads as fixes of LAMMPS."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pydlpoly.engines.lammps_translate.carried import carried_of, motion_fixes
from pydlpoly.engines.lammps_translate.formulas import number
from pydlpoly.engines.lammps_translate.refusal import Places, refusal
from pydlpoly.scene.model import ExternalTerm, Scene

MOTION = "motion"


@dataclass(frozen=True)
class IntegratorStyle:
    """What an integrator becomes: the fixes in words, what is equal and what differs."""

    fixes: str
    equal: str
    differs: str


INTEGRATOR_STYLES: dict[str, IntegratorStyle] = {
    "nve": IntegratorStyle("`nve`", "the same velocity Verlet: the same trajectory to rounding", "nothing"),
    "mdvv": IntegratorStyle(
        "`nve` (`mvv/dpd` for λ other than ½) and `pair_style dpd/tstat` (`dpd/ext/tstat` for other exponents than 2)",
        "the same step, drag of the velocities that λ predicts",
        "another stream of random numbers",
    ),
    "langevin": IntegratorStyle(
        "`nve` and `langevin`",
        "friction and temperature",
        "drag and noise are forces of the whole step, not a move in the middle of the drift, and uniform numbers: "
        "averages agree to the order of the timestep squared; the forces hold drag and noise",
    ),
    "berendsen": IntegratorStyle("`nve` and `temp/berendsen`", "the same trajectory to rounding", "nothing"),
    "hoover": IntegratorStyle(
        "`nvt` with a chain of one",
        "the same trajectory and conserved energy to rounding",
        "a run that continues begins with a thermostat at rest",
    ),
}
"""The integrators that are translated; all others are refused."""

FIELD_STYLES: dict[str, str] = {"grav": "`fix gravity`", "elec": "`fix efield`"}
"""The external fields that are translated; all others are refused."""


@dataclass(frozen=True)
class Fixes:
    """Commands after the pair styles, and the fix whose scalar is the thermostat's energy, if any."""

    commands: tuple[str, ...]
    thermostat: str = ""


def refuse_integrator(scene: Scene, places: Places) -> None:
    """Raise SceneError for an integrator that is not translated."""
    name = scene.dynamics.integrator
    if name not in INTEGRATOR_STYLES:
        place = places.of_setting("ensemble_dpd_order", "ensemble_method", "ensemble")
        raise refusal(f"the integrator {name} cannot be run", place)


def fixes_of(scene: Scene, seed: int, places: Places) -> Fixes:
    """Return the fixes that move the beads. Raises SceneError for what is refused."""
    refuse_integrator(scene, places)
    dynamics = scene.dynamics
    name = dynamics.integrator
    carried = carried_of(scene)
    frozen = bool(scene.beads.frozen.any())
    commands = [f"timestep {number(dynamics.timestep)}"]
    group = "all"
    if frozen:
        group = "mobile"
        commands += _groups(scene)
        if not carried.any:
            commands.append("neigh_modify exclude group frozen frozen")
    energy = number(dynamics.thermal_energy)
    mobile = int(np.count_nonzero(~scene.beads.frozen))
    commands += [f"compute moving {group} temp", *_degrees(scene, mobile)]
    if name == "hoover":
        commands.append(f"fix {MOTION} {group} nvt temp {energy} {energy} {number(dynamics.relaxation)} tchain 1")
        commands.append(f"fix_modify {MOTION} temp moving")
    else:
        commands += motion_fixes(carried, dynamics.prediction, group, MOTION)
    if name == "berendsen":
        commands.append(f"fix bath {group} temp/berendsen {energy} {energy} {number(dynamics.relaxation)}")
        commands.append("fix_modify bath temp moving")
    elif name == "langevin":
        damping = number(1.0 / dynamics.thermostat_friction)
        commands.append(f"fix bath {group} langevin {energy} {energy} {damping} {seed}")
    for order, field in enumerate(scene.external):
        commands.append(_field(order, field, group, places))
    if frozen:
        commands.append("fix held frozen setforce 0.0 0.0 0.0")
    if dynamics.remove_drift:
        commands.append(f"fix drift {group} momentum 1 linear 1 1 1")
    return Fixes(tuple(commands), MOTION if name == "hoover" else "")


def _degrees(scene: Scene, mobile: int) -> list[str]:
    """Commands that make LAMMPS's temperature count the scene's degrees of freedom."""
    return [f"compute_modify moving extra/dof {3 * mobile - scene.degrees_of_freedom} dynamic/dof no"]


def _groups(scene: Scene) -> list[str]:
    """Groups of the beads that move and of those that do not, by runs of ids."""
    flags = np.concatenate([[False], scene.beads.frozen, [False]])
    edges = np.flatnonzero(flags[1:] != flags[:-1]).reshape(-1, 2)
    runs = [f"{a + 1}:{b}" for a, b in edges.tolist()]
    return [*(f"group frozen id {run}" for run in runs), "group mobile subtract all frozen"]


def _field(order: int, field: ExternalTerm, group: str, places: Places) -> str:
    if field.key not in FIELD_STYLES:
        raise refusal(f"the external field {field.key} cannot be run", places.of_text(field.explanation))
    x, y, z = field.parameters[:3]
    if field.key == "elec":
        return f"fix field{order} {group} efield {number(x)} {number(y)} {number(z)}"
    size = float(np.sqrt(x * x + y * y + z * z))
    direction = f"{number(x)} {number(y)} {number(z)}" if size > 0.0 else "0.0 0.0 1.0"
    return f"fix field{order} {group} gravity {number(size)} vector {direction}"
