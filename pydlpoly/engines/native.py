"""The native engine: hands a scene to the compiled core and reads the core's state back.

Everything here is in internal units (Å, ps, Da, 10 J/mol); the scene has already decided every number.
"""

from __future__ import annotations

import math
import os

import numpy as np
from numpy.typing import NDArray

from pydlpoly import _core
from pydlpoly.engines.native_scene import (
    add_walls,
    bonded_terms,
    long_range_tail,
    pair_table,
    set_charges,
    set_heat,
    set_many_body,
    step_settings,
)
from pydlpoly.engines.native_transport import make_transport
from pydlpoly.engines.totals import Totals
from pydlpoly.errors import SceneError
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.explain import PLANS
from pydlpoly.scene.external import ON_CHARGES
from pydlpoly.scene.integrators import INTEGRATORS
from pydlpoly.scene.model import MOST_THREADS, Scene


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
                pairs=pair_table(scene),
                settings=step_settings(scene, seed),
            )
        except ValueError as error:
            raise SceneError(str(error)) from error
        if beads.temperature is not None and beads.heat_capacity is not None:
            self.system.bead_temperatures = beads.temperature.tolist()
            self.system.heat_capacities = beads.heat_capacity.tolist()
        if beads.concentrations is not None:
            self.system.concentrations = beads.concentrations
        if scene.many_body is not None:
            set_many_body(self.system, scene.many_body)
        self.transport = None if scene.transport is None else make_transport(scene, scene.transport)
        if self.transport is not None:
            self.transport.join(self.system)
        self._heat = scene.heat is not None
        if scene.heat is not None:
            set_heat(self.system, scene, scene.heat)
        if scene.bonded is not None:
            self.system.set_bonded(bonded_terms(scene, scene.bonded), scene.bonded.excluded.tolist())
        if scene.electrostatics is not None:
            set_charges(self.system, scene, scene.electrostatics)
        for term in scene.external:
            charges = beads.charge.tolist() if term.key in ON_CHARGES else []
            self.system.add_external_field(term.key, list(term.parameters), charges)
        if scene.walls is not None:
            add_walls(self.system, scene.walls)
        self._constrained = scene.constraints is not None
        if scene.constraints is not None:
            fixed = scene.constraints
            self.system.set_constraints(
                fixed.beads.tolist(), fixed.lengths.tolist(), fixed.tolerance, fixed.most_iterations
            )
        if cell_width > 0.0:
            self.system.set_cell_width(cell_width)

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
