"""A scene in the compiled core's own objects; every number has been decided before, all are in internal units.

What the core refuses is raised as SceneError: scenes may have been changed since they were resolved.
"""

from __future__ import annotations

import math

import numpy as np

from pydlpoly import _core
from pydlpoly.errors import SceneError
from pydlpoly.scene.heat import unfit_for_heat
from pydlpoly.scene.integrators import INTEGRATORS, THERMOSTATS, is_pairwise
from pydlpoly.scene.model import Barostat, Bonded, BondedTerm, Electrostatics, Heat, ManyBody, PairTerm, Scene, Walls

_PRECISIONS = {
    "double": _core.Precision.double_precision,
    "mixed": _core.Precision.mixed,
    "reference": _core.Precision.reference,
}
_ORDERS = {
    name: getattr(_core.Order, name.replace("-", "_")) for name in (*INTEGRATORS, *THERMOSTATS) if name != "mdvv"
}
_ORDERS |= dict.fromkeys(("nve", "mdvv"), _core.Order.velocity_verlet)


def pair_table(scene: Scene) -> _core.PairTable:
    """Return what acts between every two species."""
    table = _core.PairTable(len(scene.species))
    for term in scene.pairs:
        a, b = term.species
        try:
            if term.table is not None:
                energy, virial = term.table
                table.set_table(
                    a, b, energy.tolist(), virial.tolist(), term.table_spacing, term.cutoff, term.force_shift
                )
            elif term.law is not None:
                table.set_law(a, b, term.law, list(term.parameters), term.cutoff, term.force_shift)
            if term.drag > 0.0 and is_pairwise(scene.dynamics.integrator):
                table.set_drag(a, b, term.drag, term.noise, term.drag_cutoff)
        except ValueError as error:
            names = f"{scene.species[a]} {scene.species[b]}"
            raise SceneError(f"pair {names}: {error}") from error
    return table


def set_many_body(system: _core.System, given: ManyBody) -> None:
    """Add many-body DPD to a system."""
    pairs = [(*term.species, (term.height, term.exponent, term.range, term.push)) for term in given.terms]
    kernel = "lucy" if given.kernel == "lucy" else "power"
    try:
        system.set_many_body(kernel, given.strength, list(given.powers), pairs)
    except ValueError as error:
        raise SceneError(str(error)) from error


def bonded_terms(scene: Scene, bonded: Bonded) -> _core.BondedTerms:
    """Return the bonded terms, and the pairs that feel a part of their pair law."""
    terms = _core.BondedTerms(scene.beads.frozen.tolist(), scene.dynamics.thermal_energy)
    if bonded.anchors is not None:
        terms.set_anchors(bonded.anchors)
    try:
        for term in bonded.terms:
            terms.add(term.kind, term.law, _numbers(term), term.beads)
    except ValueError as error:
        raise SceneError(str(error)) from error
    for (i, j), scale in zip(bonded.scaled.tolist(), bonded.scales.tolist(), strict=True):
        terms.add_scaled_pair(i, j, scale)
    return terms


def _numbers(term: BondedTerm) -> list[float]:
    if term.table is None:
        return list(term.parameters)
    return [term.table_start, term.table_spacing, *term.table.ravel().tolist()]


def add_walls(system: _core.System, walls: Walls) -> None:
    """Add walls to a system."""
    walled, distance = list(walls.walled), np.array(walls.distance)
    system.set_walls(walled, distance, walls.method == "bounce-back")
    if walls.strengths:
        system.add_soft_walls(walled, distance, list(walls.strengths), walls.range)


def step_settings(scene: Scene, seed: int) -> _core.StepSettings:
    """Return how steps are taken."""
    dynamics, run = scene.dynamics, scene.run
    settings = _core.StepSettings()
    settings.precision = _PRECISIONS[dynamics.precision]
    settings.timestep = dynamics.timestep
    settings.thermal_energy = dynamics.thermal_energy
    settings.weight_exponent = dynamics.weight_exponent
    settings.prediction = dynamics.prediction
    settings.drag = is_pairwise(dynamics.integrator)
    settings.order = _ORDERS[dynamics.integrator]
    settings.half_step_kinetic = dynamics.half_step_kinetic
    settings.relaxation = dynamics.relaxation
    settings.transverse_drag = dynamics.transverse_drag
    settings.collision_rate = dynamics.collision_rate
    settings.thermostat_coupling = dynamics.coupling
    settings.thermostat_mass = dynamics.thermostat_mass
    settings.thermostat_friction = dynamics.thermostat_friction
    settings.tolerance = dynamics.tolerance
    settings.passes = dynamics.passes
    settings.thermostat_every = dynamics.interval
    if dynamics.schedule is not None:
        schedule = _core.TemperatureSchedule()
        schedule.times, schedule.energies = list(dynamics.schedule.times), list(dynamics.schedule.energies)
        schedule.amplitude, schedule.period = dynamics.schedule.amplitude, dynamics.schedule.period
        settings.schedule = schedule
    if dynamics.barostat is not None:
        settings.barostat = _barostat(scene, dynamics.barostat)
    settings.remove_drift = dynamics.remove_drift
    settings.shear_rate = dynamics.shear_rate
    settings.seed = seed
    settings.degrees_of_freedom = scene.degrees_of_freedom
    settings.force_cap = run.force_cap
    settings.equilibration_steps = run.equilibration_steps
    settings.rescale_every = run.rescale_every
    settings.regauss_every = run.regauss_every
    return settings


def _barostat(scene: Scene, given: Barostat) -> _core.Barostat:
    barostat = _core.Barostat()
    barostat.motion = getattr(_core.CellMotion, given.motion)
    barostat.pressure, barostat.tension = list(given.pressure), given.tension
    barostat.relaxation, barostat.friction = given.relaxation, given.friction
    barostat.tail = long_range_tail(scene)[1]
    return barostat


def long_range_tail(scene: Scene) -> tuple[float, float]:
    """Return the long-range corrections (energy, virial) of the scene's uncut laws times the volume, internal units.

    Energy 2π N_a N_b ∫_rc^∞ U r² dr for each ordered pair of species and the virial with r³ dU/dr, as DL_POLY has
    them; pairs of frozen beads count nothing. Both are zero where the scene switches corrections off.
    """
    if not scene.long_range_correction:
        return 0.0, 0.0
    beads = scene.beads
    count = len(scene.species)
    total = np.bincount(beads.species, minlength=count)
    frozen = np.bincount(beads.species[beads.frozen], minlength=count)
    energy = virial = 0.0
    for term in scene.pairs:
        a, b = term.species
        tail = _tail_of(term)
        pairs = float(total[a] * total[b] - frozen[a] * frozen[b]) * (1.0 if a == b else 2.0)
        energy += 2.0 * math.pi * pairs * tail[0]
        virial += 2.0 * math.pi * pairs * tail[1]
    return energy, virial


def _tail_of(term: PairTerm) -> tuple[float, float]:
    if term.law is None or term.force_shift or term.table is not None:
        return 0.0, 0.0
    energy, virial = _core.pair_tail(term.law, list(term.parameters), term.cutoff)
    return float(energy), float(virial)


def set_charges(system: _core.System, scene: Scene, given: Electrostatics) -> None:
    """Add electrostatics to a system."""
    numbers, settings = _core.ChargeNumbers(), _core.ChargeSettings()
    numbers.cutoff, numbers.alpha, numbers.permittivity = given.cutoff, given.alpha, given.permittivity
    settings.method, settings.shape, settings.length = given.method, given.shape, given.length
    settings.strength, settings.counts, settings.order = given.strength, list(given.counts), given.order
    settings.numbers = numbers
    bonded = scene.bonded
    excluded = bonded.excluded.tolist() if bonded is not None else []
    scaled, scales = [], []
    if bonded is not None and bonded.coulomb_scaled is not None and bonded.coulomb_scales is not None:
        scaled, scales = bonded.coulomb_scaled.tolist(), bonded.coulomb_scales.tolist()
    try:
        system.set_charges(scene.beads.charge.tolist(), settings, excluded, scaled, scales)
    except ValueError as error:
        raise SceneError(str(error)) from error


def set_heat(system: _core.System, scene: Scene, heat: Heat) -> None:
    """Give the beads of a system heat."""
    unfit = unfit_for_heat(scene.dynamics)  # scenes may have been changed since they were resolved
    if unfit is not None:
        raise SceneError(unfit[1])
    pairs = _core.HeatPairs(len(scene.species), heat.reference, scene.dynamics.weight_exponent)
    for term in heat.terms:
        a, b = term.species
        polynomials = (list(term.weight), list(term.conduction), list(term.drag))
        pairs.set(a, b, term.conductivity, term.range, term.exponent, *polynomials)
    pairs.held = np.isin(scene.beads.species, heat.held).tolist()
    pairs.scaled_repulsion = heat.scaled_repulsion
    sources = [(source.kind, list(source.numbers), source.rate) for source in heat.sources]
    _core.set_heat(system, pairs, heat.viscous_heating == "conserving", sources)
