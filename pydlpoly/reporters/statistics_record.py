"""The present step as DL_POLY's row of statistics, the one of STATIS and OUTPUT."""

from __future__ import annotations

from functools import lru_cache
from weakref import WeakKeyDictionary

import numpy as np

from pydlpoly.formats.records import FloatArray
from pydlpoly.formats.statis import StatisticsRecord
from pydlpoly.observation import Observation
from pydlpoly.scene.model import Scene
from pydlpoly.simulation import Simulation


def square_displacements(simulation: Simulation) -> tuple[float, ...]:
    """Return the mean-square displacement of each species since the start, Å²; 0 for species without beads."""
    moved = np.sum(simulation.displacements() ** 2, axis=1)
    species = simulation.scene.beads.species
    count = len(simulation.scene.species)
    total = np.bincount(species, weights=moved, minlength=count)
    return tuple((total / np.maximum(np.bincount(species, minlength=count), 1)).tolist())


_records: WeakKeyDictionary[Observation, StatisticsRecord] = WeakKeyDictionary()  # several reporters ask for the same


def statistics_record(simulation: Simulation) -> StatisticsRecord:
    """Return the present step as DL_POLY's row of statistics."""
    seen = simulation.observe()
    if seen not in _records:
        _records[seen] = _statistics_record(simulation, seen)
    return _records[seen]


def _statistics_record(simulation: Simulation, seen: Observation) -> StatisticsRecord:
    units = simulation.scene.units
    alpha, beta, gamma = _cell_angles(tuple(simulation.cell.ravel().tolist()))
    barostat = simulation.scene.dynamics.barostat
    target = seen.pressure / units.pressure_factor if barostat is None else sum(barostat.pressure) / 3.0
    return StatisticsRecord(
        step=seen.step,
        time=seen.time,
        extended_energy=(seen.energy["total"] + seen.energy["thermostat"]) / units.factor,
        conserved_term=seen.energy["thermostat"] / units.factor,
        temperature=seen.temperature,
        configurational_energy=seen.energy["potential"] / units.factor,
        short_range_energy=seen.energy["pair"] / units.factor,
        electrostatic_energy=seen.energy["charge"] / units.factor,
        bond_energy=seen.energy["bond"] / units.factor,
        angle_energy=seen.energy["angle"] / units.factor,
        dihedral_energy=(seen.energy["dihedral"] + seen.energy["inversion"]) / units.factor,
        tether_energy=seen.energy["tether"] / units.factor,
        enthalpy=(seen.energy["total"] + target * seen.volume) / units.factor,
        virial=seen.virial / units.factor,
        short_range_virial=seen.pair_virial / units.factor,
        electrostatic_virial=seen.charge_virial / units.factor,
        bond_virial=seen.bonded_virial["bond"] / units.factor,
        angle_virial=seen.bonded_virial["angle"] / units.factor,
        constraint_virial=seen.constraint_virial / units.factor,
        tether_virial=seen.bonded_virial["tether"] / units.factor,
        volume=seen.volume,
        cell_alpha=alpha,
        cell_beta=beta,
        cell_gamma=gamma,
        pressure=seen.pressure,
        stress=seen.stress,
        square_displacements=square_displacements(simulation),
        variable_cell=_variable_cell(simulation, seen),
    )


def variable_cell_columns(scene: Scene) -> int:
    """Return how many columns of STATIS say what a cell that moves is like: 0, 10, 12 or 14, as in DL_POLY."""
    barostat = scene.dynamics.barostat
    return 0 if barostat is None else {"off": 10, "area": 12}.get(barostat.semi, 14)


def _variable_cell(simulation: Simulation, seen: Observation) -> tuple[float, ...]:
    barostat, units, cell = simulation.scene.dynamics.barostat, simulation.scene.units, simulation.cell
    if barostat is None:
        return ()
    height = float(cell[2, 2])
    stress = np.diag(seen.stress)[:2] / units.pressure_factor
    tensions = height * (barostat.pressure[2] - stress) * units.tension_factor
    pressure_volume = seen.pressure / units.pressure_factor * seen.volume / units.factor
    values = [*cell.ravel().tolist(), pressure_volume, height, seen.volume / height, *tensions.tolist()]
    return tuple(values[: variable_cell_columns(simulation.scene)])


@lru_cache(maxsize=8)
def _cell_angles(cell: tuple[float, ...]) -> tuple[float, float, float]:
    a, b, c = np.reshape(cell, (3, 3))

    def angle(u: FloatArray, v: FloatArray) -> float:
        cosine = float(u @ v / (np.linalg.norm(u) * np.linalg.norm(v)))
        return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))

    return angle(b, c), angle(a, c), angle(a, b)
