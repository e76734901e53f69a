"""The native engine: hands a scene to the compiled core and reads the core's state back.

Everything here is in internal units (Å, ps, Da, 10 J/mol); the scene has already decided every number.
"""

from __future__ import annotations

import math
import os

import numpy as np
from numpy.typing import NDArray

from pydlpoly import _core
from pydlpoly.engines.native_transport import make_transport
from pydlpoly.engines.totals import Totals
from pydlpoly.errors import SceneError
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.explain import PLANS
from pydlpoly.scene.external import ON_CHARGES
from pydlpoly.scene.heat import unfit_for_heat
from pydlpoly.scene.integrators import INTEGRATORS, THERMOSTATS, is_pairwise
from pydlpoly.scene.model import (
    MOST_THREADS,
    Barostat,
    Bonded,
    BondedTerm,
    Electrostatics,
    Heat,
    ManyBody,
    PairTerm,
    Scene,
    Walls,
)

_PRECISIONS = {
    "double": _core.Precision.double_precision,
    "mixed": _core.Precision.mixed,
    "reference": _core.Precision.reference,
}
_ORDERS = {
    name: getattr(_core.Order, name.replace("-", "_")) for name in (*INTEGRATORS, *THERMOSTATS) if name != "mdvv"
}
_ORDERS |= dict.fromkeys(("nve", "mdvv"), _core.Order.velocity_verlet)


def default_threads() -> int:
    """Number of threads when none is asked for: OMP_NUM_THREADS, else the processors this process may use."""
    words = os.environ.get("OMP_NUM_THREADS", "").split(",")
    if words[0].isdigit() and int(words[0]) > 0:
        return int(words[0])
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class NativeEngine:
    """One simulation in the compiled core.

    Args:
        scene: what to model.
        seed: seed of noise and start velocities, 0 … 2^64 − 1.
        threads: number of threads; results do not depend on it.
        cell_width: link cells of at least this width (Å) instead of one cutoff; 0 = one cutoff. Never changes results.
    """

    def __init__(self, scene: Scene, *, seed: int, threads: int, cell_width: float = 0.0) -> None:
        if not 1 <= threads <= MOST_THREADS:
            raise SceneError(f"the number of threads must lie between 1 and {MOST_THREADS}, not {threads}")
        self.threads, self._scene = threads, scene
        self._tail = long_range_tail(scene)
        beads = scene.beads
        velocities = np.zeros((len(beads), 3)) if beads.velocities is None else beads.velocities
        try:
            self.system = _core.System(
                cell=scene.cell,
                periodic=list(scene.periodic),
                positions=beads.positions,
                velocities=velocities,
                mass=beads.mass.tolist(),
                species=beads.species.tolist(),
                frozen=beads.frozen.tolist(),
                pairs=_pair_table(scene),
                settings=_step_settings(scene, seed),
            )
        except ValueError as error:
            raise SceneError(str(error)) from error
        if beads.temperature is not None and beads.heat_capacity is not None:
            self.system.bead_temperatures = beads.temperature.tolist()
            self.system.heat_capacities = beads.heat_capacity.tolist()
        if beads.concentrations is not None:
            self.system.concentrations = beads.concentrations
        if scene.many_body is not None:
            _set_many_body(self.system, scene.many_body)
        self.transport = None if scene.transport is None else make_transport(scene, scene.transport)
        if self.transport is not None:
            self.transport.join(self.system)
        self._heat = scene.heat is not None
        if scene.heat is not None:
            self._set_heat(scene, scene.heat)
        if scene.bonded is not None:
            self.system.set_bonded(_bonded_terms(scene, scene.bonded), scene.bonded.excluded.tolist())
        if scene.electrostatics is not None:
            self._set_charges(scene, scene.electrostatics)
        for term in scene.external:
            charges = beads.charge.tolist() if term.key in ON_CHARGES else []
            self.system.add_external_field(term.key, list(term.parameters), charges)
        if scene.walls is not None:
            _add_walls(self.system, scene.walls)
        self._constrained = scene.constraints is not None
        if scene.constraints is not None:
            fixed = scene.constraints
            self.system.set_constraints(
                fixed.beads.tolist(), fixed.lengths.tolist(), fixed.tolerance, fixed.most_iterations
            )
        if cell_width > 0.0:
            self.system.set_cell_width(cell_width)

    def _set_charges(self, scene: Scene, given: Electrostatics) -> None:
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
            self.system.set_charges(scene.beads.charge.tolist(), settings, excluded, scaled, scales)
        except ValueError as error:
            raise SceneError(str(error)) from error

    def _set_heat(self, scene: Scene, heat: Heat) -> None:
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
        _core.set_heat(self.system, pairs, heat.viscous_heating == "conserving", sources)

    def start(self, scene: Scene) -> None:
        """Give the beads the velocities that the scene's start asks for, and compute the first forces."""
        self.prepare(scene)
        self.initialise()

    def prepare(self, scene: Scene) -> None:
        """Give the beads the velocities that the scene's start asks for."""
        if self._constrained:
            self.system.meet_constraints()
            self.system.images = np.zeros((scene.bead_count, 3), dtype=np.int32)  # displacements count from here
        if scene.run.start == "clean" or scene.beads.velocities is None:
            self.system.draw_velocities(True)
        else:
            mobile = int(np.count_nonzero(~scene.beads.frozen))
            if scene.dynamics.remove_drift or scene.degrees_of_freedom == 3 * mobile - 3 - scene.constraint_count:
                self.system.remove_drift()
            if scene.run.start == "rescale":
                self.system.rescale_velocities()

    @property
    def heat_account(self) -> tuple[float, float]:
        """What sources and held beads gave since the start, and work that beads were charged for ahead (energy)."""
        return _core.heat_account(self.system)

    @heat_account.setter
    def heat_account(self, account: tuple[float, float]) -> None:
        _core.set_heat_account(self.system, *account)

    def meet_constraints(self) -> None:
        """Bring positions to the lengths of constraints, and take out of velocities what would change them."""
        self.system.meet_constraints()

    def initialise(self) -> None:
        """Compute and observe the forces of the present state. Raises SceneError when PYDLPOLY_SIMD cannot be had."""
        _core.set_threads(self.threads)
        try:
            self.system.initialise()
        except ValueError as error:
            raise SceneError(str(error)) from error

    def run(self, steps: int) -> None:
        """Take ``steps`` steps and observe the last one. Raises RunError when a force or position is not finite."""
        _core.set_threads(self.threads)
        self.system.run(steps)

    def exchange(self, temperatures: FloatArray | None, concentrations: FloatArray | None) -> None:
        """Replace what beads carry between two steps; the forces stay those of the last one.

        Args:
            temperatures: (N,) as k_B T; concentrations: (N, species). None keeps them.
        """
        system = self.system
        system.exchange(
            system.bead_temperatures if temperatures is None else temperatures.tolist(),
            system.concentrations if concentrations is None else concentrations,
        )

    def totals(self) -> Totals:
        """Return what was observed at the last observed step."""
        system = self.system
        energy, virial = (x / system.volume for x in self._tail)
        kinetic = np.asarray(system.kinetic_tensor)
        internal = balance = 0.0
        if self._heat:
            supplied, ahead = _core.heat_account(system)
            internal = float(_core.internal_energy(system))
            # Some integrators report the velocities in the middle of the step; the balance is that of its end.
            balance = ahead - supplied + _core.present_kinetic_energy(system) - 0.5 * float(np.trace(kinetic))
        return Totals(
            pair_energy=system.pair_energy + energy,
            conservative=system.conservative_virial_tensor - np.eye(3) * (virial / 3.0),
            drag=system.drag_virial_tensor,
            noise=system.noise_virial_tensor,
            kinetic=kinetic,
            momentum=system.momentum,
            volume=system.volume,
            bonded_energies=np.array(system.bonded_energies),
            bonded=np.array(system.bonded_virial_tensors),
            charge_energy=float(system.charge_energy),
            charge=np.asarray(system.charge_virial_tensor),
            thermostat_energy=float(system.thermostat_energy),
            constraint=np.asarray(system.constraint_virial_tensor),
            field_energy=float(system.field_energy),
            internal_energy=internal,
            heat_balance=balance,
        )

    def configurational(self) -> tuple[float, float]:
        """Return Σ|∇U|² and Σ∇²U over the mobile beads, internal units; not numbers where there are constraints."""
        if self._constrained:
            return math.nan, math.nan
        _core.set_threads(self.threads)
        squared_force, curvature = self.system.configurational()
        return float(squared_force), float(curvature)

    def layer_sums(self, axis: int, layers: int) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.int64]]:
        """Return kinetic, pair and bonded sums (layers, 6) and beads (layers, species), see cpp/observe."""
        _core.set_threads(self.threads)
        kinetic, conservative, bonded, beads = self.system.stress_profile(axis, layers)
        return np.asarray(kinetic), np.asarray(conservative), np.asarray(bonded), np.asarray(beads)

    def local_densities(self) -> FloatArray:
        """Return the local densities (N,) at the last evaluation of forces. Raises ValueError without ``mdpd``."""
        return np.asarray(self.system.local_densities())

    def distance_counts(self, bins: int, species: int) -> NDArray[np.int64]:
        """Return pair distance counts, (species, species, bins), pairs counted once under a ≤ b."""
        return np.asarray(self.system.distance_counts()).reshape(species, species, bins)

    def plan(self) -> list[str]:
        """Return in words how steps are computed."""
        return _plan_of(self.system.plan(), self._scene)

    def notes(self) -> list[str]:
        """Return what a user should know about results of this engine: nothing, the scene's notes say it all."""
        return []


def _pair_table(scene: Scene) -> _core.PairTable:
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


def _set_many_body(system: _core.System, given: ManyBody) -> None:
    pairs = [(*term.species, (term.height, term.exponent, term.range, term.push)) for term in given.terms]
    kernel = "lucy" if given.kernel == "lucy" else "power"
    try:
        system.set_many_body(kernel, given.strength, list(given.powers), pairs)
    except ValueError as error:
        raise SceneError(str(error)) from error


def _bonded_terms(scene: Scene, bonded: Bonded) -> _core.BondedTerms:
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


def _add_walls(system: _core.System, walls: Walls) -> None:
    walled, distance = list(walls.walled), np.array(walls.distance)
    system.set_walls(walled, distance, walls.method == "bounce-back")
    if walls.strengths:
        system.add_soft_walls(walled, distance, list(walls.strengths), walls.range)


def _step_settings(scene: Scene, seed: int) -> _core.StepSettings:
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


def plan(scene: Scene) -> list[str]:
    """Return in words how the scene's steps will be computed: path, instruction set, precision."""
    try:
        return NativeEngine(scene, seed=0, threads=1).plan()
    except (SceneError, ValueError) as error:  # the second when PYDLPOLY_SIMD names what is not there
        return [f"none: {error}"]


def _plan_of(words: str, scene: Scene) -> list[str]:
    path, reason = words.split(": ", 1)
    precision = scene.dynamics.precision
    if path == "fast":
        arithmetic = "single" if precision == "mixed" else "double"
        return [
            f"fast path ({reason}): fixed-point positions and momenta, records sorted in every step",
            f"pair arithmetic in {arithmetic} precision, exact integer sums: momentum is conserved to the bit",
            "noise: uniform, mixed from one random word a bead and step",
        ]
    gaussian = "Gaussian, Philox4x32-10 for every pair"
    info = INTEGRATORS.get(scene.dynamics.integrator)
    if info is None:
        noise = "of single beads, Philox4x32-10" if scene.dynamics.integrator == "langevin" else "none"
    elif info.kind == "sweep":
        noise = gaussian if precision == "reference" else "Gaussian, from beads' random words"
    else:
        noise = gaussian if precision == "reference" else "uniform, from beads' random words"
    return [
        f"general path: {reason}",
        "pair list of link cells, kept while no bead has crossed half its skin; the skin follows measured times",
        "pair arithmetic in double precision, exact integer sums",
        f"noise: {noise}",
    ]


PLANS.append(plan)
