"""Simulations: a scene, an engine that steps it, and reporters that are shown its state in the steps they ask for.

The simulation owns no physics. It steps in chunks that end where a reporter is due, which is also what lets Ctrl-C act
between steps and keeps the cost of observing to the steps that are reported. An interrupt takes effect after the
reporters of its step: whatever is saved then can be continued without a record missing or written twice.
"""

from __future__ import annotations

import math
import secrets
import time as clock
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from operator import methodcaller
from pathlib import Path
from typing import Any, NoReturn, Protocol, get_args, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pydlpoly.callbacks import CallbackFunction, Callbacks
from pydlpoly.checkpointing import (
    engine_numbers,
    engine_to_arrays,
    restore_engine,
    scene_to_continue,
    totals_from_arrays,
    totals_to_arrays,
)
from pydlpoly.engines.choice import make_engine
from pydlpoly.engines.native import default_threads
from pydlpoly.engines.protocol import EngineOptions
from pydlpoly.engines.totals import Totals
from pydlpoly.errors import InputError, RunError, SceneError
from pydlpoly.formats.checkpoint import read_checkpoint, write_checkpoint
from pydlpoly.formats.records import FloatArray
from pydlpoly.formats.species_balance import SpeciesBalance
from pydlpoly.interrupts import deferred_signals
from pydlpoly.observation import Observation, observation_of
from pydlpoly.pace import Pace
from pydlpoly.scene.beads_state import (
    CONCENTRATION,
    DENSITY,
    TEMPERATURE,
    carried_arrays,
    dissolved_species,
    has_local_density,
)
from pydlpoly.scene.explain import explain
from pydlpoly.scene.model import Precision, Scene
from pydlpoly.scene.serialise import scene_to_arrays
from pydlpoly.state import State, check_carried, check_motion

_REPORTER = "reporter."  # names of arrays of reporters in a checkpoint begin with it


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
        self._engine = make_engine(
            engine,
            scene,
            seed=self.seed,
            threads=self.threads,
            cell_width=cell_width,
            options=EngineOptions(ranks=ranks, accelerator=accelerator),
        )
        self._observation: Observation | None = None
        self._stored_totals: Totals | None = None  # of a checkpoint, until the first step
        self._engine.start(scene)
        self.start_cell: FloatArray = self.cell
        self.start_positions: FloatArray = np.asarray(self._engine.system.positions)
        self._start_amounts = self._amounts()
        self._configurational: tuple[int, tuple[float, float]] | None = None  # with its step
        self._pace = Pace()
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._interrupted = False
        self._reporter_state: dict[str, NDArray[Any]] = {}
        self._callbacks = Callbacks()
        output = scene.output
        if output.rdf_every > 0:
            self._engine.system.enable_distances(
                scene.cutoff, self.rdf_bins, output.rdf_every, scene.run.averages_after
            )

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
        self._callbacks.warn_of_missed()
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
            stop = min([last, *self._callbacks.next_steps(self.step), *(step for _, step in due if step is not None)])
            self._advance(min(stop - self.step, self._pace.chunk()))
            for callback in self._callbacks.due(self.step):
                self._take_over(callback.values(self))
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
        self._callbacks.add(function, every)

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

    def _next_step(self, reporter: Reporter) -> int | None:
        step = reporter.next_step(self.step)
        if step is not None and step <= self.step:
            raise ValueError(f"{reporter!r} asks for step {step}, but the run is at step {self.step} already")
        return step

    def _advance(self, steps: int) -> None:
        self._observation = self._stored_totals = None
        begin = clock.perf_counter()
        self._engine.run(steps)
        elapsed = max(clock.perf_counter() - begin, 1e-9)
        self.seconds["engine"] += elapsed
        self._pace.took(steps, elapsed)

    # Looking

    def explain(self) -> str:
        """Return the scene in words and tables, with the plan of this simulation's engine."""
        return explain(self.scene, plan=self._engine.plan(), notes=self._engine.notes())

    @property
    def step(self) -> int:
        """Number of steps taken since the scene's start."""
        return int(self._engine.system.step)

    @property
    def steps_per_second(self) -> float:
        """Rate of the last tenths of a second in which steps were taken, 0 before the first step."""
        return self._pace.rate

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
        check_motion(self.scene, positions, velocities)
        check_carried(self.scene, temperature, concentrations)
        system = self._engine.system
        if positions is not None:
            system.positions = positions
            system.wrap()
        if velocities is not None:
            system.velocities = np.where(self.scene.beads.frozen[:, None], 0.0, velocities)
        if temperature is not None:
            system.bead_temperatures = (np.asarray(temperature) * self.scene.units.boltzmann).tolist()
        if concentrations is not None:
            system.concentrations = np.asarray(concentrations, dtype=np.float64)
        self._observation = self._stored_totals = self._configurational = None
        if self.scene.constraints is not None:
            self._engine.meet_constraints()
        self._engine.initialise()

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
        arrays |= totals_to_arrays(self._totals())
        arrays |= engine_to_arrays(self._engine, self.scene)
        arrays |= {"start_positions": self.start_positions, "start_cell": self.start_cell}
        if self._engine.transport is not None:
            arrays["start_amounts"] = self._start_amounts
        for reporter in self.reporters:
            if isinstance(reporter, StatefulReporter):
                arrays |= {f"{_REPORTER}{reporter.name}.{key}": value for key, value in reporter.state().items()}
        meta: dict[str, Any] = {
            "scene": scene,
            "seed": self.seed,
            "callbacks": self._callbacks.identities(),
            **engine_numbers(self._engine),
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
            chosen = scene_to_continue(arrays, meta, scene, str(path))
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
        restore_engine(self._engine, self.scene, arrays, meta)
        # The stored forces and totals hold the drag of the half-step velocities, which are gone.
        self._stored_totals = totals_from_arrays(arrays)
        self.start_positions = arrays["start_positions"]
        self.start_cell = arrays.get("start_cell", self.start_cell)
        if self._engine.transport is not None:
            self._start_amounts = arrays["start_amounts"]
        self._callbacks.expect(meta.get("callbacks", []))
        self._reporter_state = {k.removeprefix(_REPORTER): v for k, v in arrays.items() if k.startswith(_REPORTER)}
        self._observation = None

    def restored_state(self, name: str) -> dict[str, NDArray[Any]]:
        """Return what the reporter of this name had saved in the checkpoint; empty when there is nothing."""
        prefix = f"{name}."
        return {k[len(prefix) :]: v for k, v in self._reporter_state.items() if k.startswith(prefix)}
