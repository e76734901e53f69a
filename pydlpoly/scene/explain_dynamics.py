"""The section on integrator, thermostat and barostat of Scene.explain()."""

from __future__ import annotations

from pydlpoly.scene.explain_text import Words, every, wrap
from pydlpoly.scene.integrators import INTEGRATORS, THERMOSTATS
from pydlpoly.scene.model import Scene
from pydlpoly.units import BOLTZMANN

_CELL_MOTION = {
    "isotropic": "the edges of the cell change by one factor",
    "height": "z changes, the area of x and y stays as it is",
    "square": "the edges x and y change by one factor, z by another",
    "edges": "each edge of the cell changes by its own factor, the angles stay 90 degrees",
}


def lines(scene: Scene) -> list[str]:
    """Return integrator, thermostat, barostat and timestep in words."""
    word, dynamics = Words(scene), scene.dynamics
    kelvin = dynamics.thermal_energy / BOLTZMANN
    temperature = f"k_B T = {dynamics.thermal_energy:.9g}"
    if not scene.units.reduced:
        temperature = f"temperature {kelvin:.9g} K, {temperature} (10 J/mol)"
    if dynamics.integrator == "nve":
        told = ["nve: velocity Verlet, no thermostat", f"{temperature}, for drawn or scaled velocities only"]
    elif dynamics.integrator in THERMOSTATS:
        told = [f"{dynamics.integrator}: {THERMOSTATS[dynamics.integrator].about}", temperature]
        if dynamics.integrator == "langevin":
            told.append(f"friction {dynamics.thermostat_friction:g}" + (f" 1/{word.time.strip()}" if word.time else ""))
        else:
            told.append(f"relaxation time {dynamics.relaxation:g}{word.time}")
        if dynamics.schedule is not None:
            told += wrap(_schedule_text(scene))
    else:
        exponent = dynamics.weight_exponent
        told = [
            f"{dynamics.integrator}: {INTEGRATORS[dynamics.integrator].about}",
            temperature,
            *_parameters_of(scene),
            f"weight of the drag (1 - r/rc)^{exponent:g}, of the noise (1 - r/rc)^{exponent / 2:g}; "
            "noise^2 = 2 drag k_B T",
        ]
    drift = "is removed in every step" if dynamics.remove_drift else "is not removed"
    return [
        *told,
        *_barostat(scene),
        f"timestep {dynamics.timestep:g}{word.time}",
        f"degrees of freedom {scene.degrees_of_freedom}; drift of the centre of mass {drift}",
    ]


def _barostat(scene: Scene) -> list[str]:
    """What moves the cell."""
    barostat, word, units = scene.dynamics.barostat, Words(scene), scene.units
    if barostat is None:
        return []
    pressures = [f"{x * units.pressure_factor:.9g}" for x in barostat.pressure]
    faces = pressures[0] if len(set(pressures)) == 1 else f"{' '.join(pressures)} on the faces across x y z"
    unit = units.pressure_label and f" {units.pressure_label}"
    told = [
        f"barostat: Langevin piston; {_CELL_MOTION[barostat.motion]}",
        f"target pressure {faces}{unit}, of conservative forces and velocities, without drag and noise",
        f"piston of mass g k_B T t^2, g degrees of freedom, t = {barostat.relaxation:g}{word.time}; friction "
        f"{barostat.friction:g}" + (f" 1/{word.time.strip()}" if word.time else ""),
    ]
    if barostat.semi in ("tension", "orthorhombic"):
        tension = barostat.tension * units.tension_factor
        told.append(f"surface tension of the xy plane {tension:.9g}{'' if units.reduced else ' dyn/cm'}")
    return told


def _parameters_of(scene: Scene) -> list[str]:
    """What the integrator takes beside drags and timestep, and how the temperature varies."""
    dynamics, word = scene.dynamics, Words(scene)
    rate = f" 1/{word.time.strip()}" if word.time else ""
    texts = {
        "ensemble_dpd_lambda": f"prediction of the velocities lambda = {dynamics.prediction:g}",
        "ensemble_dpd_tolerance": f"iterated until the kinetic energy changes by less than {dynamics.tolerance:g}",
        "ensemble_dpd_passes": f"passes over the pairs in the middle of the drift: {dynamics.passes}",
    }
    if dynamics.half_step_kinetic:
        texts["ensemble_dpd_kinetic"] = "kinetic temperature and stress are of the half-step velocities"
    if dynamics.interval > 1:
        texts["ensemble_dpd_interval"] = f"thermostat {every(dynamics.interval)}, for as many steps at once"
    if dynamics.transverse_drag:
        text = f"drag across the line of a pair: {dynamics.transverse_drag:g} times that along it"
        texts["ensemble_dpd_transverse_drag"] = text
    if dynamics.collision_rate:
        texts["ensemble_dpd_rate"] = f"a pair is chosen {dynamics.collision_rate:g}{rate}"
    elif "ensemble_dpd_rate" in INTEGRATORS[dynamics.integrator].keywords:
        texts["ensemble_dpd_rate"] = "a pair is chosen at the rate drag/(2 reduced mass)"
    texts["ensemble_dpd_coupling"] = f"drag of the pairs not chosen: {dynamics.coupling:g} (1 - T/T_pairs)"
    texts["ensemble_dpd_thermostat_mass"] = (
        f"inertia of the common drag {dynamics.thermostat_mass:g} degrees of freedom kT/drag^2, its friction "
        f"{dynamics.thermostat_friction:g}{rate}"
    )
    taken = INTEGRATORS[dynamics.integrator].keywords
    told = [text for keyword, text in texts.items() if keyword in taken]
    if dynamics.schedule is not None:
        told += wrap(_schedule_text(scene))
    return told


def _schedule_text(scene: Scene) -> str:
    schedule, word = scene.dynamics.schedule, Words(scene)
    assert schedule is not None
    unit = 1.0 if scene.units.reduced else BOLTZMANN
    kind = "" if scene.units.reduced else " K"
    if schedule.amplitude:
        return (
            f"the temperature follows a sine of amplitude {schedule.amplitude / unit:.6g}{kind} and period "
            f"{schedule.period:g}{word.time}"
        )
    points = [
        f"{energy / unit:.6g}{kind} at {time:g}{word.time}"
        for time, energy in zip(schedule.times, schedule.energies, strict=True)
    ]
    return "the temperature follows straight lines between " + ", ".join(points)
