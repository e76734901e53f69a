"""Simulations: a scene, an engine that steps it, and reporters that are shown its state in the steps they ask for.

The simulation owns no physics. It steps in chunks that end where a reporter is due, which is also what lets Ctrl-C act
between steps and keeps the cost of observing to the steps that are reported. An interrupt takes effect after the
reporters of its step: whatever is saved then can be continued without a record missing or written twice.
"""

from __future__ import annotations

import math
import secrets
import time as clock
import warnings
from collections import defaultdict
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from operator import methodcaller
from pathlib import Path
from typing import Any, NoReturn, Protocol, get_args, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pydlpoly.callbacks import Callback, CallbackFunction
from pydlpoly.engines.native import NativeEngine, Totals, default_threads
from pydlpoly.engines.protocol import ENGINES, Engine, EngineOptions
from pydlpoly.errors import InputError, InputWarning, RunError, SceneError
from pydlpoly.formats.checkpoint import read_checkpoint, write_checkpoint
from pydlpoly.formats.records import FloatArray
from pydlpoly.formats.species_balance import SpeciesBalance
from pydlpoly.interrupts import deferred_signals
from pydlpoly.scene.beads_state import (
    CONCENTRATION,
    DENSITY,
    TEMPERATURE,
    carried_arrays,
    dissolved_species,
    has_local_density,
    why_not,
)
from pydlpoly.scene.continuation import check_continues
from pydlpoly.scene.model import BondedKind, Precision, Scene
from pydlpoly.scene.serialise import scene_from_arrays, scene_to_arrays

_SECONDS_PER_CHUNK = 0.2  # how long Ctrl-C may wait in scenes of usual size
_STEPS_PER_CHUNK = 20  # at least, unless they take longer than
_LONGEST_CHUNK = 20.0  # seconds
_MOST_CELLS = 2.0**30  # that a bead may be away from the cell


@dataclass(frozen=True, eq=False)
class State:
    """A copy of what a simulation's beads do now; changing it changes nothing in the simulation.

    Attributes:
        positions: (N, 3) wrapped into the cell, Å.
        velocities: (N, 3), Å/ps.
        forces: (N, 3) total force including drag and noise, Da Å/ps².
        images: (N, 3) cells crossed since the start; unwrapped = positions + images @ cell.
        step: number of steps taken since the scene's start; time: ps.
        temperature: (N,) internal temperatures, K (reduced with ``units dpd``); None where beads carry no heat.
        concentrations: (N, species) of dissolved species; None where there are none.
        density: (N,) local densities at the last evaluation of the forces; None where no pair law depends on them.
    """

    positions: FloatArray
    velocities: FloatArray
    forces: FloatArray
    images: NDArray[np.int32]
    cell: FloatArray
    step: int
    time: float
    temperature: FloatArray | None = None
    concentrations: FloatArray | None = None
    density: FloatArray | None = None

    @property
    def unwrapped(self) -> FloatArray:
        """(N, 3) positions followed across cell boundaries since the start."""
        return self.positions + self.images @ self.cell


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


class Reporter(Protocol):
    """Something that is shown the simulation every now and then; it never changes it."""

    def next_step(self, step: int) -> int | None:
        """Return the first step after ``step`` at which this reporter is due, or None for never."""

    def report(self, simulation: Simulation) -> None:
        """Look at the simulation at a due step."""


@runtime_checkable
class StatefulReporter(Reporter, Protocol):
    """A reporter whose memory goes into the checkpoint."""

    name: str

    def state(self) -> dict[str, NDArray[Any]]:
        """Return what the reporter remembers, as arrays by name."""


class Simulation:
    """A scene in motion.

    Args:
        scene: what to model.
        threads: number of threads (default: the scene's, else all processors). Results do not depend on it.
        seed: seed of noise and start velocities, 0 … 2^64 − 1 (default: the scene's, else drawn anew; see ``seed``).
        cell_width: link cells of at least this width (Å) instead of one cutoff. Results do not depend on it.
        precision: "double", "mixed" or "reference" in place of the scene's.
        engine: "native" or "lammps", see docs/lammps.md.
        ranks: number of processes of the engine lammps (default: those of the MPI job around this process, else 1).
        accelerator: LAMMPS's own switches for accelerators, such as ``-sf gpu -pk gpu 1``.

    Attributes:
        seconds: wall-clock seconds that ``run`` has spent so far: "engine" for the steps themselves, and those of each
            reporter under the name of its class.

    Raises:
        SceneError: the scene cannot be run, or not by this engine.
        InputError: what the engine needs is missing.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        threads: int | None = None,
        seed: int | None = None,
        cell_width: float = 0.0,
        precision: Precision | None = None,
        engine: str = "native",
        ranks: int | None = None,
        accelerator: str = "",
    ) -> None:
        if precision is not None:
            if precision not in get_args(Precision):
                raise SceneError(f"is no precision; expected {', '.join(get_args(Precision))}", word=precision)
            scene = replace(scene, dynamics=replace(scene.dynamics, precision=precision))
        chosen = scene.run.seed if seed is None else seed
        self.scene = scene
        self.seed: int = secrets.randbits(64) if chosen is None else int(chosen)
        if not 0 <= self.seed < 2**64:
            raise SceneError(f"the seed must lie between 0 and 2^64 - 1, not {self.seed}")
        self.threads: int = threads or scene.run.threads or default_threads()
        if self.threads < 1:
            raise SceneError(f"the number of threads must be at least 1, not {threads}")
        self.reporters: list[Reporter] = []
        self.engine = engine
        self._engine = _engine(
            engine, scene, self.seed, self.threads, cell_width, EngineOptions(ranks=ranks, accelerator=accelerator)
        )
        self._observation: Observation | None = None
        self._stored_totals: Totals | None = None  # of a checkpoint, until the first step
        self._engine.start(scene)
        self.start_cell: FloatArray = self.cell
        self.start_positions: FloatArray = np.asarray(self._engine.system.positions)
        self._start_amounts = self._amounts()
        self._configurational: tuple[int, tuple[float, float]] | None = None  # with its step
        self._rate = 0.0
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._interrupted = False
        self._reporter_state: dict[str, NDArray[Any]] = {}
        self._callbacks: list[Callback] = []
        self._missed_callbacks: set[tuple[str, int]] = set()  # of the checkpoint, until they are added
        output = scene.output
        if output.rdf_every > 0:
            after = 0 if scene.run.record_equilibration else scene.run.equilibration_steps
            self._engine.system.enable_distances(scene.cutoff, self.rdf_bins, output.rdf_every, after)

    # Running

    def run(self, steps: int, progress: bool = False) -> None:
        """Take ``steps`` steps, calling the reporters in the steps they are due.

        Args:
            steps: number of steps, 0 or more.
            progress: show a progress bar on the terminal.

        The reporters are asked for their first steps here, and then for the next one after each report.

        Raises:
            RunError: a force or position stopped being finite; the state is that of the failing step.
            KeyboardInterrupt: Ctrl-C, or ``interrupt`` was called; the running chunk (some tenths of a second) is
                finished and its reporters are called first. A second Ctrl-C a second later does not wait.
            ValueError: a reporter asks for a step that is not later than the present one.
        """
        if steps < 0:
            raise RunError(f"the number of steps must not be negative, not {steps}")
        last = self.step + steps
        self._warn_of_missed_callbacks()
        try:
            with deferred_signals(self.interrupt):
                if progress:
                    from pydlpoly.progress import progress_bar  # only a terminal needs it

                    with progress_bar(self, last) as show:
                        self._run_to(last, show)
                else:
                    self._run_to(last, None)
        finally:
            interrupted, self._interrupted = self._interrupted, False
        if interrupted:
            raise KeyboardInterrupt

    def interrupt(self) -> None:
        """Have the run under way end with KeyboardInterrupt after its present chunk and the reporters due there.

        May be called by a reporter, a signal handler or another thread.
        """
        self._interrupted = True

    def _run_to(self, last: int, show: Callable[[], None] | None) -> None:
        due = [(reporter, self._next_step(reporter)) for reporter in self.reporters]
        while self.step < last:
            calls = [callback.next_step(self.step) for callback in self._callbacks]
            stop = min([last, *calls, *(step for _, step in due if step is not None)])
            self._advance(min(stop - self.step, self._chunk()))
            self._call_back()
            for k, (reporter, step) in enumerate(due):
                if step == self.step:
                    begin = clock.perf_counter()
                    reporter.report(self)
                    self.seconds[type(reporter).__name__] += clock.perf_counter() - begin
                    due[k] = reporter, self._next_step(reporter)
            if show is not None:
                show()
            if self._interrupted:
                return

    def add_callback(self, function: CallbackFunction, every: int = 1) -> None:
        """Have a function called every so many steps, to change what beads carry: a source or a reaction.

        It is called after each step whose number is a multiple of ``every``, before the reporters of that step, and in
        the order in which callbacks were added. A checkpoint does not hold functions: add them again after ``resume``.

        Args:
            function: takes a ``pydlpoly.callbacks.Moment`` (positions, velocities, species, temperature, density,
                concentrations, step, time, …) and returns None, or new values by name: "temperature", (N,),
                "concentration_<name>", (N,), or "concentrations", (N, species). ``pydlpoly.callbacks.Source`` makes
                such a function of one that returns rates.
            every: interval in steps, counted from the scene's start.

        Raises:
            ValueError: the interval is not a positive whole number. The run raises RunError, with the function's name,
                when it fails or returns arrays of another shape or with impossible numbers.
        """
        callback = Callback(function, every)
        self._callbacks.append(callback)
        self._missed_callbacks.discard((callback.name, callback.every))

    def _call_back(self) -> None:
        for callback in self._callbacks:
            if self.step % callback.every == 0:
                self._take_over(callback.values(self))

    def _take_over(self, given: dict[str, FloatArray]) -> None:
        """Replace what beads carry by new values, by name, without a new evaluation of the forces."""
        if not given:
            return
        temperatures = given[TEMPERATURE] * self.scene.units.boltzmann if TEMPERATURE in given else None
        concentrations = np.array(self._engine.system.concentrations)
        for k, name in enumerate(dissolved_species(self.scene)):
            if CONCENTRATION + name in given:
                concentrations[:, k] = given[CONCENTRATION + name]
        self._engine.exchange(temperatures, concentrations)
        self._observation = None

    def _warn_of_missed_callbacks(self) -> None:
        if self._missed_callbacks:
            told = ", ".join(f"{name} every {every} steps" for name, every in sorted(self._missed_callbacks))
            text = f"the checkpoint is of a run with callbacks that were not added again: {told}"
            warnings.warn(InputWarning(text), stacklevel=3)
            self._missed_callbacks = set()

    def _next_step(self, reporter: Reporter) -> int | None:
        step = reporter.next_step(self.step)
        if step is not None and step <= self.step:
            raise ValueError(f"{reporter!r} asks for step {step}, but the run is at step {self.step} already")
        return step

    def _chunk(self) -> int:
        # A chunk's ends cost as much as a step or two. Large scenes take several steps all the same, while an interrupt
        # still waits no longer than twenty seconds, and a second one does not wait.
        several = min(_STEPS_PER_CHUNK, int(self._rate * _LONGEST_CHUNK))
        return max(1, int(self._rate * _SECONDS_PER_CHUNK), several)

    def _advance(self, steps: int) -> None:
        self._observation = self._stored_totals = None
        begin = clock.perf_counter()
        self._engine.run(steps)
        elapsed = max(clock.perf_counter() - begin, 1e-9)
        self.seconds["engine"] += elapsed
        # A chunk that a report cut short, or that the machine held up, says little about the next one.
        weight = 1.0 if self._rate == 0.0 else elapsed / (elapsed + _SECONDS_PER_CHUNK)
        self._rate += weight * (steps / elapsed - self._rate)

    # Looking

    def explain(self) -> str:
        """Return the scene in words and tables, with the plan of this simulation's engine."""
        from pydlpoly.scene.explain import explain  # as in Scene.explain

        return explain(self.scene, plan=self._engine.plan(), notes=self._engine.notes())

    @property
    def step(self) -> int:
        """Number of steps taken since the scene's start."""
        return int(self._engine.system.step)

    @property
    def steps_per_second(self) -> float:
        """Rate of the last tenths of a second in which steps were taken, 0 before the first step."""
        return self._rate

    @property
    def time(self) -> float:
        """Simulated time in ps."""
        return float(self._engine.system.time)

    @property
    def cell(self) -> FloatArray:
        """(3, 3) present cell vectors by row, Å."""
        return np.ascontiguousarray(self._engine.system.cell)

    @property
    def state(self) -> State:
        """A copy of positions, velocities, forces, step and time, and of what beads carry."""
        system, carried = self._engine.system, self.bead_arrays()
        return State(
            positions=np.asarray(system.positions),
            velocities=np.asarray(system.velocities),
            forces=np.asarray(system.forces),
            images=np.asarray(system.images),
            cell=self.cell,
            step=self.step,
            time=self.time,
            temperature=carried.get(TEMPERATURE),
            concentrations=None if self.scene.beads.concentrations is None else np.array(system.concentrations),
            density=carried.get(DENSITY),
        )

    def bead_arrays(self) -> dict[str, FloatArray]:
        """Return copies of what beads carry, (N,) each, by name; empty in scenes whose beads carry nothing.

        "temperature": internal, K (reduced with ``units dpd``). "concentration_<name>": of each dissolved species.
        "density": local, at the last evaluation of the forces, where pair laws depend on it.
        """
        system, beads = self._engine.system, self.scene.beads
        temperatures = None if beads.temperature is None else np.asarray(system.bead_temperatures, dtype=np.float64)
        concentrations = None if beads.concentrations is None else np.asarray(system.concentrations)
        arrays = carried_arrays(self.scene, temperatures, concentrations)
        if has_local_density(self.scene):
            arrays[DENSITY] = np.array(methodcaller("local_densities")(system), dtype=np.float64)
        return arrays

    @property
    def positions(self) -> FloatArray:
        """(N, 3) a copy of the positions, wrapped into the cell, Å."""
        return np.asarray(self._engine.system.positions)

    @property
    def velocities(self) -> FloatArray:
        """(N, 3) a copy of the velocities, Å/ps."""
        return np.asarray(self._engine.system.velocities)

    def displacements(self) -> FloatArray:
        """Return how far every bead is from where it started, (N, 3) in Å, followed across cell boundaries.

        Where the cell has changed, the places of the start are scaled with it, as in DL_POLY. In a sheared cell the
        flow is part of the displacement along x.
        """
        system, cell, start = self._engine.system, self.cell, self.start_positions
        if self.scene.dynamics.shear_rate == 0.0 and not np.array_equal(cell, self.start_cell):
            start = start @ np.linalg.inv(self.start_cell) @ cell
        return np.asarray(system.positions + system.images @ cell - start)

    def set_state(
        self,
        *,
        positions: FloatArray | None = None,
        velocities: FloatArray | None = None,
        temperature: FloatArray | None = None,
        concentrations: FloatArray | None = None,
    ) -> None:
        """Replace positions, velocities or what beads carry, and recompute the forces.

        Positions outside the cell are wrapped into it, and the crossed cells are counted in ``State.images``. Beads are
        moved to the lengths of constraints.

        Args:
            positions: (N, 3), Å; velocities: (N, 3), Å/ps.
            temperature: (N,) internal temperatures, K (reduced with ``units dpd``), where beads carry heat.
            concentrations: (N, species) of the dissolved species, where there are any.

        Raises:
            ValueError: an array has another shape, is not finite, impossible or too far away, or the beads do not carry
                this; the state is the one before.
        """
        system = self._engine.system
        shape = (self.scene.bead_count, 3)
        for name, array in (("positions", positions), ("velocities", velocities)):
            if array is not None and (np.shape(array) != shape or not np.isfinite(array).all()):
                raise ValueError(f"{name} must be finite and of shape {shape}")
        energies = self._checked_carried(temperature, concentrations)
        if positions is not None:
            cells = np.abs(np.asarray(positions) @ np.linalg.inv(self.scene.cell)).max(axis=1)
            if cells.size and not cells.max() < _MOST_CELLS:
                raise ValueError(
                    f"the position of bead {int(np.argmax(cells)) + 1} is {cells.max():.4g} cells away; at most "
                    f"{_MOST_CELLS:.4g} can be counted"
                )
            system.positions = positions
            system.wrap()
        if velocities is not None:
            system.velocities = np.where(self.scene.beads.frozen[:, None], 0.0, velocities)
        if energies is not None:
            system.bead_temperatures = energies.tolist()
        if concentrations is not None:
            system.concentrations = np.asarray(concentrations, dtype=np.float64)
        self._observation = self._stored_totals = self._configurational = None
        if self.scene.constraints is not None:
            self._engine.meet_constraints()
        self._engine.initialise()

    def _checked_carried(self, temperature: FloatArray | None, concentrations: FloatArray | None) -> FloatArray | None:
        """Check what beads are to carry, and return the temperatures as k_B T; ValueError as ``set_state``."""
        beads = self.scene.beads
        for what, array, carried in (
            ("temperature", temperature, beads.temperature),
            ("concentrations", concentrations, beads.concentrations),
        ):
            if array is None:
                continue
            if carried is None:
                raise ValueError(f"beads of this scene carry no {what}")
            if np.shape(array) != carried.shape:
                raise ValueError(f"{what} must be of shape {carried.shape}, not {np.shape(array)}")
            columns = np.asarray(array, dtype=np.float64).reshape(len(beads), -1)
            for column in columns.T:
                wrong = why_not(what, column)
                if wrong is not None:
                    raise ValueError(f"{what} of bead {wrong[0] + 1} is {column[wrong[0]]:g}; {wrong[1]}")
        return None if temperature is None else np.asarray(temperature) * self.scene.units.boltzmann

    def observe(self) -> Observation:
        """Return energies, temperature, pressure and stress of the present step."""
        if self._observation is None:
            self._observation = observation_of(self.scene, self._totals(), self.step, self.time)
        return self._observation

    def _totals(self) -> Totals:
        return self._engine.totals() if self._stored_totals is None else self._stored_totals

    @property
    def temperature(self) -> float:
        """Kinetic temperature, K (reduced with ``units dpd``)."""
        return self.observe().temperature

    @property
    def configurational_temperature(self) -> float:
        """Temperature of the positions, K (reduced with ``units dpd``): Σ|∇U|²/(k_B Σ∇²U) over the mobile beads.

        Of this step alone; averages over steps are best made of ``configurational()``, sum over sum. Costs a few steps
        the first time it is asked for in a step. Not a number where nothing acts or where it cannot be computed.
        Rugh, Phys. Rev. Lett. 78, 772 (1997).
        """
        return self._temperature_of(*self.configurational())

    @property
    def last_configurational_temperature(self) -> tuple[int, float] | None:
        """Step and value of the configurational temperature that was computed last; None when none was."""
        if self._configurational is None:
            return None
        step, sums = self._configurational
        return step, self._temperature_of(*sums)

    def _temperature_of(self, squared_force: float, curvature: float) -> float:
        return squared_force / (curvature * self.scene.units.boltzmann) if curvature > 0.0 else float("nan")

    def configurational(self) -> tuple[float, float]:
        """Return Σ|∇U|² and Σ∇²U over the mobile beads at the present positions, internal units.

        The ratio of their averages over a run is k_B times the configurational temperature, which shows the error of a
        timestep that the kinetic temperature hides. ∇U is of all conservative forces; the second
        derivatives are differences of forces, exact to about 1e-9.
        """
        if self._configurational is None or self._configurational[0] != self.step:
            self._configurational = (self.step, self._engine.configurational())
        return self._configurational[1]

    @property
    def internal_temperature(self) -> float:
        """Mean internal temperature of the beads, K (reduced with ``units dpd``); not a number where they carry none.

        Weighted by heat capacity: the temperature that the beads would have in common with the heat they carry.
        """
        capacity = self.scene.beads.heat_capacity
        if capacity is None:
            return float("nan")
        return self.observe().energy["internal"] / (float(capacity.sum()) * self.scene.units.boltzmann)

    @property
    def pressure(self) -> float:
        """Pressure of all parts together, katm (reduced with ``units dpd``)."""
        return self.observe().pressure

    @property
    def energy(self) -> dict[str, float]:
        """Energy by component in internal units, as in ``Observation``."""
        return self.observe().energy

    def local_densities(self) -> FloatArray:
        """Return the local density of every bead in many-body DPD, (N,), at the last evaluation of forces.

        In Å⁻³ in the two-density form of ``mdpd``, without a unit (times r_c³) in the generalised one. A bead is not
        its own neighbour: a lone bead has 0. Warren, Phys. Rev. E 68, 066702 (2003).

        Raises:
            ValueError: no pair of the scene has the law mdpd.
        """
        return self._engine.local_densities()

    @property
    def rdf_bins(self) -> int:
        """Number of bins of the pair distance histogram."""
        return max(1, round(self.scene.cutoff / self.scene.output.rdf_bin_width))

    def distance_counts(self) -> tuple[NDArray[np.int64], int]:
        """Return pair distance counts, (species, species, bins) with a ≤ b, and the number of samples."""
        counts = self._engine.distance_counts(self.rdf_bins, len(self.scene.species))
        return counts, int(self._engine.system.distance_samples)

    @property
    def distance_volume(self) -> float:
        """Volume that pair distances are normalised with: the mean over their samples where the cell varies."""
        system = self._engine.system
        samples = int(system.distance_samples)
        if samples == 0 or np.array_equal(self.cell, self.start_cell):
            return float(system.volume)
        return float(system.distance_volumes) / samples

    def _amounts(self) -> FloatArray:
        """Return how much of each dissolved species all beads have, (species,)."""
        columns = np.asarray(self._engine.system.concentrations).T
        return np.array([math.fsum(column.tolist()) for column in columns])

    def species_balance(self) -> tuple[SpeciesBalance, ...]:
        """Return what became of the amount of each dissolved species since the scene's start; empty without any."""
        if self.scene.transport is None or self._engine.transport is None:
            return ()
        tally = np.asarray(self._engine.transport.tally)
        gains = (tally[:3] + tally[3:]).T
        rows = zip(self.scene.transport.species, self._start_amounts, gains, self._amounts(), strict=True)
        return tuple(
            SpeciesBalance(
                name,
                start=float(start),
                sources=float(given[0]),
                reactions=float(given[1]),
                held=float(given[2]),
                now=float(now),
            )
            for name, start, given, now in rows
        )

    def layer_sums(self, axis: int, layers: int) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.int64]]:
        """Return Σ m v_a v_b, and Σ F_a r_b of pair laws and of bonded terms, in layers of the cell at this step.

        Args:
            axis: 0, 1 or 2; the cell must be periodic along it, with a vector along it perpendicular to the other two.
            layers: number of layers of equal thickness.

        Returns:
            Three arrays (layers, 6) of the components xx yy zz xy xz yz in internal energy units, and the number of
            beads, (layers, species). Drag, noise and the long-range correction are not in them.

        Raises:
            ValueError: the cell has another shape.
        """
        return self._engine.layer_sums(axis, layers)

    # Checkpoints

    def __reduce__(self) -> NoReturn:
        """Refuse to be copied or pickled: the copy would share the engine."""
        raise TypeError("a simulation is not copied or pickled as it is; save() and Simulation.resume() do that")

    def save(self, path: str | Path) -> None:
        """Write a checkpoint from which ``resume`` continues with the same bits; the file is replaced as a whole."""
        arrays, scene = scene_to_arrays(self.scene)
        system, totals = self._engine.system, self._totals()
        arrays |= {f"totals.{name}": np.asarray(value) for name, value in asdict(totals).items()}
        arrays |= {
            "positions": np.asarray(system.positions),
            "velocities": np.asarray(system.velocities),
            "forces": np.asarray(system.forces),
            "images": np.asarray(system.images),
            "start_positions": self.start_positions,
            "cell": self.cell,
            "start_cell": self.start_cell,
            "thermostat": np.asarray(system.thermostat, dtype=np.float64),
        }
        if self.scene.beads.temperature is not None:
            arrays["bead_temperatures"] = np.asarray(system.bead_temperatures)
        if self.scene.heat is not None:
            arrays["heat_account"] = np.asarray(self._engine.heat_account)
        if self.scene.beads.concentrations is not None:
            arrays["concentrations"] = np.asarray(system.concentrations)
        if self._engine.transport is not None:
            arrays["start_amounts"] = self._start_amounts
            arrays["transport_tally"] = np.asarray(self._engine.transport.tally)
        if self.scene.output.rdf_every > 0:
            arrays["distance_counts"] = np.asarray(system.distance_counts())
        for reporter in self.reporters:
            if isinstance(reporter, StatefulReporter):
                arrays |= {f"reporter.{reporter.name}.{key}": value for key, value in reporter.state().items()}
        meta: dict[str, Any] = {
            "scene": scene,
            "seed": self.seed,
            "step": self.step,
            "time": self.time,
            "distance_samples": int(system.distance_samples),
            "distance_volumes": float(system.distance_volumes),
            "callbacks": [[callback.name, callback.every] for callback in self._callbacks],
        }
        write_checkpoint(path, arrays, meta)

    @classmethod
    def resume(
        cls,
        path: str | Path,
        *,
        scene: Scene | None = None,
        threads: int | None = None,
        engine: str = "native",
        ranks: int | None = None,
        accelerator: str = "",
    ) -> Simulation:
        """Return the simulation that a checkpoint holds, at the step it was saved.

        Args:
            path: a file written by ``save``.
            scene: go on with this scene (its run length, outputs, temperature, …) in place of the stored one; its cell
                and its beads (species, masses, charges, which are frozen) must be the stored ones.
            threads: number of threads; results do not depend on it.
            engine, ranks, accelerator: as for ``Simulation``; the engine need not be that of the checkpoint.

        Raises:
            InputError: the file is not a whole checkpoint of this program, or of other beads than the scene's.
        """
        arrays, meta = read_checkpoint(path)
        try:
            stored = scene_from_arrays(arrays, meta["scene"])
            chosen = stored if scene is None else scene
            cell = arrays.get("cell", stored.cell)  # checkpoints of before there were barostats have none
            check_continues(stored, chosen, str(path), (cell, arrays.get("start_cell", cell)))
            # A cell that went through REVCON has lost its last digits; tethers still hold where the run began.
            bonded = chosen.bonded
            if bonded is not None and stored.bonded is not None and stored.bonded.anchors is not None:
                bonded = replace(bonded, anchors=stored.bonded.anchors)
            imcon = 2 if chosen.imcon == 1 and len(set(np.diag(cell).tolist())) > 1 else chosen.imcon
            chosen = replace(chosen, cell=cell, imcon=imcon, bonded=bonded)
            simulation = cls(
                chosen,
                threads=threads,
                seed=int(meta["seed"]),
                engine=engine,
                ranks=ranks,
                accelerator=accelerator,
            )
            simulation._restore(arrays, meta)
        except InputError as error:
            raise InputError(error.message, path=error.path or str(path), line=error.line, word=error.word) from error
        except KeyError as error:
            raise InputError(f"the checkpoint lacks {error}", path=str(path)) from error
        except (TypeError, ValueError) as error:
            raise InputError(f"the checkpoint does not fit this version or scene: {error}", path=str(path)) from error
        return simulation

    def _restore(self, arrays: dict[str, NDArray[Any]], meta: dict[str, Any]) -> None:
        system = self._engine.system
        system.step, system.time = int(meta["step"]), float(meta["time"])
        system.cell = arrays.get("cell", self.scene.cell)
        system.positions = arrays["positions"]
        system.velocities = arrays["velocities"]
        system.thermostat = arrays["thermostat"].tolist()
        if self.scene.beads.temperature is not None:
            system.bead_temperatures = arrays["bead_temperatures"].tolist()
        if self.scene.beads.concentrations is not None:
            system.concentrations = arrays["concentrations"]
        if self._engine.transport is not None:
            self._start_amounts = arrays["start_amounts"]
            self._engine.transport.tally = arrays["transport_tally"]
        self._engine.initialise()
        system.velocities = arrays["velocities"]  # of the whole step; some fields prescribe others between its kicks
        # The stored forces and totals hold the drag of the half-step velocities, which are gone.
        self._stored_totals = Totals(
            **{name: np.asarray(arrays[f"totals.{name}"]) for name in ("conservative", "drag", "noise", "kinetic")},
            pair_energy=float(arrays["totals.pair_energy"]),
            momentum=arrays["totals.momentum"],
            volume=float(arrays["totals.volume"]),
            bonded_energies=arrays["totals.bonded_energies"],
            bonded=arrays["totals.bonded"],
            charge_energy=float(arrays.get("totals.charge_energy", 0.0)),  # checkpoints of before charges have none
            charge=arrays.get("totals.charge", np.zeros((3, 3))),
            thermostat_energy=float(arrays["totals.thermostat_energy"]),
            constraint=arrays.get("totals.constraint", np.zeros((3, 3))),
            field_energy=float(arrays.get("totals.field_energy", 0.0)),
            internal_energy=float(arrays.get("totals.internal_energy", 0.0)),
            heat_balance=float(arrays.get("totals.heat_balance", 0.0)),
        )
        if self.scene.heat is not None:
            self._engine.heat_account = tuple(arrays["heat_account"].tolist())
        system.forces = arrays["forces"]
        system.images = arrays["images"]
        self.start_positions = arrays["start_positions"]
        self.start_cell = arrays.get("start_cell", self.start_cell)
        prefix = "reporter."
        self._missed_callbacks = {(str(name), int(every)) for name, every in meta.get("callbacks", [])}
        self._reporter_state = {k[len(prefix) :]: v for k, v in arrays.items() if k.startswith(prefix)}
        if self.scene.output.rdf_every > 0 and "distance_counts" in arrays:
            samples = int(meta["distance_samples"])
            volumes = float(meta.get("distance_volumes", samples * system.volume))
            system.restore_distances(arrays["distance_counts"].tolist(), samples, volumes)
        self._observation = None

    def restored_state(self, name: str) -> dict[str, NDArray[Any]]:
        """Return what the reporter of this name had saved in the checkpoint; empty when there is nothing."""
        prefix = f"{name}."
        return {k[len(prefix) :]: v for k, v in self._reporter_state.items() if k.startswith(prefix)}


def _engine(name: str, scene: Scene, seed: int, threads: int, cell_width: float, options: EngineOptions) -> Engine:
    if name not in ENGINES:
        raise SceneError(f"is no engine; expected {', '.join(ENGINES)}", word=name)
    if name == "native":
        if options != EngineOptions():
            raise SceneError("ranks and accelerator switches are for the engine lammps; the native one has threads")
        return NativeEngine(scene, seed=seed, threads=threads, cell_width=cell_width)
    from pydlpoly.engines.lammps import LammpsEngine  # only this engine needs it

    if cell_width > 0.0:
        raise SceneError("a width of link cells has no meaning with the engine lammps")
    return LammpsEngine(scene, seed=seed, threads=threads, options=options)


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
    bonded = dict(zip(get_args(BondedKind), totals.bonded_energies.tolist(), strict=True))
    potential = totals.pair_energy + sum(bonded.values()) + totals.charge_energy + totals.field_energy
    factor = scene.units.pressure_factor / totals.volume
    stress_parts = {name: tensor * factor for name, tensor in parts.items()}
    stress = np.sum(list(stress_parts.values()), axis=0)
    freedom = scene.degrees_of_freedom
    temperature = 2.0 * kinetic / (freedom * scene.units.boltzmann) if freedom > 0 else 0.0
    energy = {
        "pair": totals.pair_energy,
        **bonded,
        "charge": totals.charge_energy,
        "field": totals.field_energy,
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
    bonded = dict(zip(get_args(BondedKind), totals.bonded_energies.tolist(), strict=True))
    virial = totals.conservative + np.sum(totals.bonded, axis=0) + totals.charge
    return SinglePoint(
        energy={
            "pair": totals.pair_energy,
            **bonded,
            "charge": totals.charge_energy,
            "field": totals.field_energy,
            "total": totals.pair_energy + sum(bonded.values()) + totals.charge_energy + totals.field_energy,
        },
        forces=np.asarray(engine.system.forces),
        stress=virial / totals.volume,
        virial=-float(np.trace(virial)),
    )
