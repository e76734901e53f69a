"""Reporter of OUTPUT, which also keeps the averages of the run."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly import __version__
from pydlpoly.errors import InputError
from pydlpoly.formats.output import OutputWriter, RollingAverages, RunningAverages, RunSummary
from pydlpoly.formats.statis import STATISTICS_NAMES
from pydlpoly.observation import stress_parts
from pydlpoly.reporters.schedule import every
from pydlpoly.reporters.statistics_record import square_displacements, statistics_record, variable_cell_columns
from pydlpoly.reporters.stress_correlations import StressCorrelations
from pydlpoly.reporters.stress_profile import StressProfile
from pydlpoly.simulation import Simulation
from pydlpoly.temperatures import EnergyDrift, TemperatureSamples


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
        self._after = scene.run.averages_after
        self._columns = len(STATISTICS_NAMES) + len(scene.species) + variable_cell_columns(scene)
        self._rolling = RollingAverages(output.stack_size, self._columns)
        self._averages = RunningAverages(self._columns + 9 * len(stress_parts(scene)))
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
                name: tensor for name, tensor in zip(stress_parts(scene), tensors, strict=True) if name not in absent
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
                np.concatenate([values, *(parts[name].reshape(9) for name in stress_parts(simulation.scene))])
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
