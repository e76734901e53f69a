"""Reporters that write DL_POLY's files (OUTPUT, STATIS, HISTORY, RDFDAT, REVCON), DIAGNOSTICS and the checkpoint.

A reporter is shown the simulation in the steps it asks for and never changes it. Energies and virials go out in FIELD's
energy unit, temperatures and pressures in K and katm (reduced with ``units dpd``).
"""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import IO, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from pydlpoly import __version__
from pydlpoly.background import BackgroundWriter
from pydlpoly.correlations import StressCorrelations
from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import atomic_file
from pydlpoly.formats.beads_file import write_beads
from pydlpoly.formats.config_writer import write_config_to
from pydlpoly.formats.diagnostics import DiagnosticsWriter
from pydlpoly.formats.history import HistoryWriter
from pydlpoly.formats.output import OutputWriter, RollingAverages, RunningAverages, RunSummary
from pydlpoly.formats.rdfdat import normalise_rdf, write_rdf
from pydlpoly.formats.records import Configuration, FloatArray
from pydlpoly.formats.statis import STATISTICS_NAMES, StatisticsRecord, StatisticsWriter
from pydlpoly.scene.beads_state import carried_names
from pydlpoly.scene.model import Scene
from pydlpoly.simulation import Observation, Simulation
from pydlpoly.stress_profile import StressProfile
from pydlpoly.temperatures import EnergyDrift, TemperatureSamples

_TENSORS = ("kinetic", "conservative", "drag", "noise", "bonded", "charge")


def _parts_of(scene: Scene) -> tuple[str, ...]:
    """Return the parts of the stress that are averaged."""
    return _TENSORS if scene.constraints is None else (*_TENSORS, "constraint")


def every(step: int, interval: int, start: int = 0) -> int | None:
    """Return the first step after ``step`` of the form start + k·interval, or None when the interval is 0."""
    if interval <= 0:
        return None
    if step < start:
        return start
    return start + ((step - start) // interval + 1) * interval


def bead_names(scene: Scene) -> list[str]:
    """Return the species name of every bead."""
    names: list[str] = np.array(scene.species, dtype=object)[scene.beads.species].tolist()
    return names


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


class StatisticsReporter:
    """Writes STATIS."""

    def __init__(self, simulation: Simulation, path: Path, *, append: bool = False) -> None:
        scene = simulation.scene
        self._every = scene.output.statistics_every
        self._writer = StatisticsWriter(
            path,
            scene.title,
            scene.units.statis_label,
            scene.species,
            variable_cell=variable_cell_columns(scene),
            yaml=scene.output.statistics_yaml,
            append=append,
            keep_until=simulation.step if append else None,
        )
        if not append:
            self.report(simulation)

    def next_step(self, step: int) -> int | None:
        """Return the next multiple of ``stats_frequency``."""
        return every(step, self._every)

    def report(self, simulation: Simulation) -> None:
        """Write one record."""
        self._writer.write(statistics_record(simulation))

    def sync(self) -> None:
        """Force everything written so far to the disk."""
        self._writer.sync()

    def close(self) -> None:
        """Close the file."""
        self._writer.close()


class DiagnosticsReporter:
    """Writes DIAGNOSTICS."""

    def __init__(self, simulation: Simulation, path: Path, *, append: bool = False) -> None:
        units = simulation.scene.units
        self._every = simulation.scene.output.diagnostics_every
        words = {"temperature": units.temperature_label, "energy": units.label, "pressure": units.pressure_label}
        self._writer = DiagnosticsWriter(
            path,
            None if units.reduced else words,
            heat=simulation.scene.heat is not None,
            append=append,
            keep_until=simulation.step if append else None,
        )
        if not append:
            self.report(simulation)

    def next_step(self, step: int) -> int | None:
        """Return the next multiple of ``diagnostics_frequency``."""
        return every(step, self._every)

    def report(self, simulation: Simulation) -> None:
        """Write one record."""
        seen, scene = simulation.observe(), simulation.scene
        squared_force, laplacian = simulation.configurational()
        record = {
            "time": seen.time,
            "kinetic_temperature": seen.temperature,
            "configurational_temperature": simulation.configurational_temperature,
            "squared_force": squared_force,
            "laplacian": laplacian,
            "energy": seen.energy["total"] / scene.units.factor / scene.bead_count,
            **{f"pressure_{name}": float(np.trace(seen.stress_parts[name])) / 3.0 for name in _TENSORS},
            **{f"momentum_{axis}": float(value) for axis, value in zip("xyz", seen.momentum, strict=True)},
        }
        if scene.heat is not None:
            per_bead = scene.units.factor * scene.bead_count
            record |= {
                "internal_temperature": simulation.internal_temperature,
                "internal_energy": seen.energy["internal"] / per_bead,
                "conserved_energy": seen.energy["conserved"] / per_bead,
            }
        self._writer.write(seen.step, record)

    def sync(self) -> None:
        """Force everything written so far to the disk."""
        self._writer.sync()

    def close(self) -> None:
        """Close the file."""
        self._writer.close()


class TrajectoryReporter:
    """Writes HISTORY, while the simulation goes on: see ``BackgroundWriter`` for when errors are raised."""

    def __init__(self, simulation: Simulation, path: Path, *, append: bool = False) -> None:
        scene = simulation.scene
        self._start, self._every = scene.output.trajectory_start, scene.output.trajectory_every
        self._level = scene.output.trajectory_level
        writer = HistoryWriter(
            path,
            scene.title,
            self._level,
            scene.imcon,
            bead_names(scene),
            scene.beads.mass,
            scene.beads.charge,
            append=append,
            keep_until=simulation.step if append else None,
        )
        self._writer = BackgroundWriter(writer)
        if not append and self._start == 0:
            self.report(simulation)

    def next_step(self, step: int) -> int | None:
        """Return the next step of the form start + k·interval."""
        return every(step, self._every, self._start)

    def report(self, simulation: Simulation) -> None:
        """Have one frame written."""
        state = simulation.state
        self._writer.write(
            state.step,
            state.time,
            simulation.scene.dynamics.timestep,
            state.cell,
            state.positions,
            velocities=state.velocities if self._level >= 1 else None,
            forces=state.forces if self._level >= 2 else None,
            displacements=np.linalg.norm(simulation.displacements(), axis=1),
        )

    def sync(self) -> None:
        """Wait until all frames are on the disk. Raises RunError when one could not be written."""
        self._writer.sync()

    def close(self) -> None:
        """Write what waits and close the file. Raises RunError when a frame could not be written."""
        self._writer.close()


class OutputReporter:
    """Writes OUTPUT and keeps the averages: rolling over the stack, and over all samples after equilibration.

    Samples are taken in the steps of ``stats_frequency`` (``print_frequency`` when that is 0); those of the kinetic and
    the configurational temperature in the steps of ``print_frequency`` and ``diagnostics_frequency``.

    Args:
        simulation: the run.
        path: OUTPUT, or None to keep the averages only.
        append: the run continues from a checkpoint.
        stream: print here, for example to the standard output, instead of into ``path``.

    Raises:
        InputError: the checkpoint holds averages of other quantities.
        RunError: the file cannot be written.
    """

    name = "averages"

    def __init__(
        self, simulation: Simulation, path: Path | None, *, append: bool = False, stream: IO[str] | None = None
    ) -> None:
        scene = simulation.scene
        output = scene.output
        self._print_every = output.print_every
        self._sample_every = output.statistics_every or output.print_every
        self._after = 0 if scene.run.record_equilibration else scene.run.equilibration_steps
        self._columns = len(STATISTICS_NAMES) + len(scene.species) + variable_cell_columns(scene)
        self._rolling = RollingAverages(output.stack_size, self._columns)
        self._averages = RunningAverages(self._columns + 9 * len(_parts_of(scene)))
        self._diagnostics_every = output.diagnostics_every
        self._temperatures = TemperatureSamples(scene)
        self._drift = EnergyDrift(scene)
        self._span = (0, 0)  # the averages cover the steps after the first number, up to the second
        self._begin = clock.perf_counter()
        self._first_step = simulation.step
        self._restore(simulation.restored_state(self.name))
        self._writer: OutputWriter | None = None
        if path is not None or stream is not None:
            units = scene.units
            self._writer = OutputWriter(
                path or "standard output",
                __version__,
                scene.title,
                append=append,
                temperature_unit=units.temperature_label,
                pressure_unit=units.pressure_label,
                time_unit="" if units.reduced else "ps",
                energy_unit=units.label,
                stream=stream,
            )
            if append:
                self._writer.resume(simulation.step, __version__)
            self._writer.text(simulation.explain())
            self._writer.text(_seed_and_workers(simulation))
        if not append:
            self._sample(simulation)
            if self._print_every > 0:
                self._print(simulation)

    def next_step(self, step: int) -> int | None:
        """Return the next step that is printed or sampled."""
        intervals = (self._print_every, self._sample_every, self._diagnostics_every)
        return min((due for n in intervals if (due := every(step, n)) is not None), default=None)

    def report(self, simulation: Simulation) -> None:
        """Sample and print what is due in this step."""
        step = simulation.step
        prints = self._print_every > 0 and step % self._print_every == 0
        if self._sample_every > 0 and step % self._sample_every == 0:
            self._sample(simulation)
        diagnosed = self._diagnostics_every > 0 and step % self._diagnostics_every == 0
        if step > self._after and (prints or diagnosed):
            self._temperatures.add(simulation)
        if prints:
            self._print(simulation)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the averages for the checkpoint."""
        parts = {
            "rolling": self._rolling.state(),
            "running": self._averages.state(),
            "temperatures": self._temperatures.state(),
            "drift": self._drift.state(),
        }
        arrays = {f"{part}.{key}": value for part, state in parts.items() for key, value in state.items()}
        return {**arrays, "span": np.array(self._span, dtype=np.int64)}

    def finish(self, simulation: Simulation, warnings: Sequence[str], timings: Mapping[str, float]) -> RunSummary:
        """Write the summary and return it."""
        scene = simulation.scene
        mean, spread = self._averages.mean(), self._averages.fluctuations()
        columns = self._columns
        tensors = mean[columns:].reshape(-1, 3, 3)
        parts = {"bonded": scene.bonded, "charge": scene.electrostatics}
        absent = [name for name, part in parts.items() if part is None]
        elapsed = clock.perf_counter() - self._begin
        covered = self._span[1] - self._span[0]
        doubt = self._temperatures.doubt()
        doubts = [] if doubt is None else [doubt]
        summary = RunSummary(
            steps=simulation.step,
            time=simulation.time,
            averaged_steps=covered,
            averaged_time=covered * scene.dynamics.timestep,
            elapsed=elapsed,
            loop_seconds=timings.get("steps", elapsed),
            averages=mean[:columns],
            fluctuations=spread[:columns],
            pressure_parts={
                name: tensor for name, tensor in zip(_parts_of(scene), tensors, strict=True) if name not in absent
            },
            diffusion=_diffusion(simulation),
            warnings=[*warnings, *doubts],
            timings=timings,
            samples=self._averages.taken,
            doubts=doubts,
            kinetic_temperature=self._temperatures.kinetic(),
            configurational_temperature=self._temperatures.configurational(),
            thermostat_temperature=self._temperatures.target,
            energy_drift=self._drift.estimate(),
            loop_steps=simulation.step - self._first_step,
            stress_estimates=[
                estimate
                for reporter in simulation.reporters
                if isinstance(reporter, (StressProfile, StressCorrelations))
                for estimate in reporter.estimates()
            ],
            species_balance=simulation.species_balance(),
        )
        if self._writer is not None:
            self._writer.summary(summary)
        return summary

    def close(self) -> None:
        """Close the file."""
        if self._writer is not None:
            self._writer.close()

    def _restore(self, stored: dict[str, NDArray[Any]]) -> None:
        if not stored:
            return
        rolling, running, temperatures, drift = (
            {name.removeprefix(part): value for name, value in stored.items() if name.startswith(part)}
            for part in ("rolling.", "running.", "temperatures.", "drift.")
        )
        blocks = all({"counts", "sums"} <= state.keys() for state in (temperatures, drift))
        if not {"stack", "taken"} <= rolling.keys() or "mean" not in running or "span" not in stored or not blocks:
            raise InputError("the checkpoint holds averages of another version of pydlpoly")
        stack, taken = rolling["stack"], int(rolling["taken"])
        if stack.shape[1] != self._columns or len(running["mean"]) != len(self._averages.mean()):
            raise InputError("the checkpoint holds averages of other quantities than this version takes")
        # One by one, oldest first: CONTROL may ask for a stack of another size now.
        for k in range(max(0, taken - len(stack)), taken):
            self._rolling.add(stack[k % len(stack)])
        self._averages = RunningAverages.from_state(running)
        try:
            self._temperatures.restore(temperatures)
            self._drift.restore(drift)
        except ValueError as error:
            raise InputError(f"the checkpoint holds averages of another version of pydlpoly: {error}") from error
        self._span = int(stored["span"][0]), int(stored["span"][1])

    def _sample(self, simulation: Simulation) -> None:
        self._drift.add(simulation)
        values = statistics_record(simulation).values()
        self._rolling.add(values)
        if simulation.step > self._after:
            if self._averages.taken == 0:
                self._span = max(self._after, simulation.step - self._sample_every), simulation.step
            self._span = self._span[0], simulation.step
            parts = simulation.observe().stress_parts
            self._averages.add(
                np.concatenate([values, *(parts[name].reshape(9) for name in _parts_of(simulation.scene))])
            )

    def _print(self, simulation: Simulation) -> None:
        if self._writer is not None:
            values = statistics_record(simulation).values()
            elapsed = clock.perf_counter() - self._begin
            self._writer.block(
                simulation.step, simulation.time, elapsed, values, self._rolling.mean(), _heat(simulation)
            )


def _heat(simulation: Simulation) -> list[tuple[str, float]]:
    """Words and numbers of OUTPUT about the heat that beads carry; none where they carry none."""
    scene = simulation.scene
    if scene.heat is None:
        return []
    energy, unit = simulation.energy, scene.units.temperature_label
    return [
        (f"internal temperature{unit and f' [{unit}]'}", simulation.internal_temperature),
        ("internal energy", energy["internal"] / scene.units.factor),
        ("conserved energy", energy["conserved"] / scene.units.factor),
    ]


def _seed_and_workers(simulation: Simulation) -> str:
    if simulation.engine == "lammps":
        return f"seed {simulation.seed} (LAMMPS's noise follows from it and from the number of ranks)"
    return f"seed {simulation.seed}, {simulation.threads} threads (results do not depend on these)"


def _diffusion(simulation: Simulation) -> dict[str, tuple[float, float]]:
    """Self-diffusion from the mean-square displacement over the whole run, 10⁻⁹ m²/s (Å²/ps is ten of them)."""
    if simulation.time <= 0.0:
        return {}
    factor = 1.0 if simulation.scene.units.reduced else 10.0
    squares = square_displacements(simulation)
    return {
        name: (factor * square / (6.0 * simulation.time), float(np.sqrt(square)))
        for name, square in zip(simulation.scene.species, squares, strict=True)
    }


class CheckpointReporter:
    """Writes REVCON, REVBEADS and the checkpoint, each replaced as a whole; other files reach the disk first."""

    def __init__(self, simulation: Simulation, folder: Path, others: Sequence[object] = ()) -> None:
        output = simulation.scene.output
        self._every = output.checkpoint_every
        self._configuration = folder / output.configuration_file if output.configuration_file else None
        self._checkpoint = folder / output.checkpoint_file if output.checkpoint_file else None
        self._carried = carried_names(simulation.scene)
        self._beads = folder / output.beads_file if output.beads_file and self._carried else None
        self._rdf = folder / output.rdf_file if output.rdf_file and output.rdf_every > 0 else None
        self._others = others
        self.written_step: int | None = None

    def next_step(self, step: int) -> int | None:
        """Return the next multiple of ``data_dump_frequency``."""
        return every(step, self._every)

    def report(self, simulation: Simulation) -> None:
        """Write the files."""
        for other in self._others:
            sync = getattr(other, "sync", None)
            if sync is not None:
                sync()
        if self._configuration is not None:
            with atomic_file(self._configuration) as file:
                write_config_to(file, configuration_of(simulation))
        if self._beads is not None:
            arrays = simulation.bead_arrays()
            write_beads(self._beads, simulation.scene.title, self._carried, [arrays[name] for name in self._carried])
        if self._checkpoint is not None:
            simulation.save(self._checkpoint)
        if self._rdf is not None:
            write_distances(simulation, self._rdf)
        self.written_step = simulation.step


def stress_reporters(simulation: Simulation, folder: Path) -> list[StressProfile | StressCorrelations]:
    """Return the reporters of STRPRF and COR that the scene asks for."""
    scene = simulation.scene
    profile, correlations = scene.output.profile, scene.output.correlations
    after = 0 if scene.run.record_equilibration else scene.run.equilibration_steps
    reporters: list[StressProfile | StressCorrelations] = []
    if profile.every > 0:
        path = folder / profile.file if profile.file is not None else None
        reporters.append(
            StressProfile(
                simulation,
                axis=profile.axis,
                layers=profile.layers,
                every=profile.every,
                after=after,
                interfaces=profile.interfaces,
                path=path,
            )
        )
    if correlations.terms:
        path = folder / correlations.file if correlations.file is not None else None
        reporters.append(
            StressCorrelations(
                simulation,
                correlations.terms,
                every=correlations.every,
                after=after,
                path=path,
                dump=correlations.dump_every,
            )
        )
    return reporters


def configuration_of(simulation: Simulation) -> Configuration:
    """Return the present state as the record that REVCON is written from."""
    scene, state = simulation.scene, simulation.state
    return Configuration(
        names=tuple(bead_names(scene)),
        positions=state.positions,
        title=scene.title,
        imcon=scene.imcon,
        cell=state.cell,
        velocities=state.velocities,
        forces=state.forces,
        step=state.step,
        timestep=scene.dynamics.timestep,
        time=state.time,
    )


def radial_distributions(
    simulation: Simulation,
) -> tuple[FloatArray, dict[tuple[str, str], tuple[FloatArray, FloatArray]]]:
    """Return r (bins,) in Å and, for each collected pair of species, g(r) and the running coordination number.

    A pair with no beads on one side, or a single bead with itself, has no g(r) and is left out, as in DL_POLY.
    """
    counts, samples = simulation.distance_counts()
    scene = simulation.scene
    beads = np.bincount(scene.beads.species, minlength=len(scene.species)).tolist()
    width = scene.cutoff / simulation.rdf_bins
    r: FloatArray = (np.arange(simulation.rdf_bins, dtype=np.float64) + 0.5) * np.float64(width)
    result = {}
    for pair in scene.output.rdf_pairs:
        a, b = sorted(pair)
        if samples == 0 or min(beads[a], beads[b]) < (2 if a == b else 1):
            continue
        _, g, n = normalise_rdf(
            counts[a, b],
            like=a == b,
            volume=simulation.distance_volume,
            beads=(beads[a], beads[b]),
            configurations=samples,
            bin_width=width,
        )
        result[scene.species[a], scene.species[b]] = (g, n)
    return r, result


def write_distances(simulation: Simulation, path: Path) -> None:
    """Write RDFDAT when anything has been sampled."""
    r, table = radial_distributions(simulation)
    if table:
        write_rdf(
            path, simulation.scene.title, list(table), r, [g for g, _ in table.values()], [n for _, n in table.values()]
        )
