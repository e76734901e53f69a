"""What can be said about one step of a simulation, or about a configuration without one: energies, stress, pressure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import numpy as np

from pydlpoly.engines.native import NativeEngine, default_threads
from pydlpoly.engines.totals import Totals
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import BondedKind, Scene

STRESS_PARTS = ("kinetic", "conservative", "drag", "noise", "bonded", "charge")
"""The parts that the stress of every scene has; see ``stress_parts``."""


@dataclass(frozen=True, eq=False)
class Observation:
    """What can be said about one step.

    Energies and virials are in internal units (10 J/mol); a virial is −Σ r·F, DL_POLY's sign. Temperature is in K and
    pressure in katm; in scenes with ``units dpd`` both are reduced (k_B = 1).

    Attributes:
        energy: by component: "pair", "bond", "angle", "dihedral", "inversion", "tether", "charge", "field" (of external
            fields and walls), "potential" (all of these), "kinetic", "total" (potential and kinetic) and "thermostat"
            (what hoover's variable holds; its sum with total is conserved. With npt and nst what the piston holds, and
            P V of the target). Where beads carry heat also "internal" (Σ C_v T) and "conserved": total and internal
            energy less what sources and beads of held temperature gave (see docs/heat.md).
        stress: (3, 3) pressure tensor in the pressure unit, all parts.
        stress_parts: the same by part: "kinetic", "conservative" (pairs), "drag", "noise", "bonded", "charge", and
            "constraint" where distances are fixed.
        virial: −Σ r·F of all forces; ``pair_virial``: of the conservative pair forces alone.
        momentum: (3,) total momentum in Da Å/ps; in a sheared cell it, the temperature and the kinetic stress are of
            velocities relative to the flow.
        bonded_virial: −Σ r·F by component: "bond", "angle", "dihedral", "inversion", "tether".
        constraint_virial: −Σ r·F of the forces that keep distances fixed.
        charge_virial: −Σ r·F of the electrostatics.
    """

    step: int
    time: float
    energy: dict[str, float]
    temperature: float
    pressure: float
    stress: FloatArray
    stress_parts: dict[str, FloatArray]
    virial: float
    pair_virial: float
    volume: float
    momentum: FloatArray
    bonded_virial: dict[str, float]
    charge_virial: float
    constraint_virial: float = 0.0


@dataclass(frozen=True, eq=False)
class SinglePoint:
    """Energy, forces and stress of a scene's configuration: pair laws, bonded terms, charges and external fields.

    The forces that keep distances fixed are not among them: they depend on velocities.

    Attributes:
        energy: by component, internal units: "pair" (with the long-range correction and scaled 1-4 pairs), "bond",
            "angle", "dihedral", "inversion", "tether", "charge", "field" (external fields and walls) and "total".
        forces: (N, 3), Da Å/ps²; frozen beads feel none.
        stress: (3, 3) configurational pressure tensor Σ F_a r_b / V, internal pressure (Da/(Å ps²)); a repulsion is
            positive.
        virial: −Σ r·F = −V · trace(stress), DL_POLY's sign.
    """

    energy: dict[str, float]
    forces: FloatArray
    stress: FloatArray
    virial: float


def stress_parts(scene: Scene) -> tuple[str, ...]:
    """Return the names in ``Observation.stress_parts``."""
    return STRESS_PARTS if scene.constraints is None else (*STRESS_PARTS, "constraint")


def _potential_energies(totals: Totals) -> tuple[dict[str, float], float]:
    """Return the potential energies by component, and their sum."""
    bonded = dict(zip(get_args(BondedKind), totals.bonded_energies.tolist(), strict=True))
    terms = {"pair": totals.pair_energy, **bonded, "charge": totals.charge_energy, "field": totals.field_energy}
    return terms, totals.pair_energy + sum(bonded.values()) + totals.charge_energy + totals.field_energy


def observation_of(scene: Scene, totals: Totals, step: int, time: float) -> Observation:
    """Turn the core's totals into an observation in the scene's units."""
    kinetic = 0.5 * float(np.trace(totals.kinetic))
    parts = {
        "kinetic": totals.kinetic,
        "conservative": totals.conservative,
        "drag": totals.drag,
        "noise": totals.noise,
        "bonded": np.sum(totals.bonded, axis=0),
        "charge": totals.charge,
    }
    if scene.constraints is not None:
        parts["constraint"] = totals.constraint
    terms, potential = _potential_energies(totals)
    factor = scene.units.pressure_factor / totals.volume
    stress_parts = {name: tensor * factor for name, tensor in parts.items()}
    stress = np.sum(list(stress_parts.values()), axis=0)
    freedom = scene.degrees_of_freedom
    temperature = 2.0 * kinetic / (freedom * scene.units.boltzmann) if freedom > 0 else 0.0
    energy = {
        **terms,
        "potential": potential,
        "kinetic": kinetic,
        "total": potential + kinetic,
        "thermostat": totals.thermostat_energy,
    }
    if scene.heat is not None:
        energy["internal"] = totals.internal_energy
        energy["conserved"] = potential + kinetic + totals.internal_energy + totals.heat_balance
    return Observation(
        step=step,
        time=time,
        energy=energy,
        temperature=temperature,
        pressure=float(np.trace(stress)) / 3.0,
        stress=stress,
        stress_parts=stress_parts,
        virial=-sum(float(np.trace(tensor)) for name, tensor in parts.items() if name != "kinetic"),
        pair_virial=-float(np.trace(totals.conservative)),
        volume=totals.volume,
        momentum=totals.momentum,
        bonded_virial={
            kind: -float(np.trace(tensor)) for kind, tensor in zip(get_args(BondedKind), totals.bonded, strict=True)
        },
        constraint_virial=-float(np.trace(totals.constraint)),
        charge_virial=-float(np.trace(totals.charge)),
    )


def single_point(scene: Scene, *, threads: int | None = None) -> SinglePoint:
    """Return energy, forces and stress of a scene's configuration without drag and noise.

    Raises:
        SceneError: the scene cannot be computed.
        RunError: a pair force or a bonded term is not finite, naming the beads.
    """
    engine = NativeEngine(scene, seed=0, threads=threads or scene.run.threads or default_threads())
    settings = engine.system.settings
    settings.drag = False
    settings.force_cap = 0.0
    engine.initialise()
    totals = engine.totals()
    terms, potential = _potential_energies(totals)
    virial = totals.conservative + np.sum(totals.bonded, axis=0) + totals.charge
    return SinglePoint(
        energy={**terms, "total": potential},
        forces=np.asarray(engine.system.forces),
        stress=virial / totals.volume,
        virial=-float(np.trace(virial)),
    )
