"""The measurement: who runs when, how long, what is compared with what, and who is given up.

All candidates start from one equilibrated state and take turns; the reference runs between them, again and again. A
rate is compared with that of the reference's last turn, so that a machine that slows down for a while slows down both.
Averages of a candidate and the reference are compared with statistical errors; whoever cannot win any more makes room
for the rest.
"""

from __future__ import annotations

import secrets
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from pydlpoly.bench.results import Spread, this_machine
from pydlpoly.errors import InputError, RunError, SceneError
from pydlpoly.formats.rdfdat import normalise_rdf
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Scene
from pydlpoly.simulation import Simulation
from pydlpoly.tradeoff.candidates import OTHER_DYNAMICS, Candidate, candidates_for, reference_for, variant
from pydlpoly.tradeoff.report import (
    Measured,
    Reference,
    TradeoffReport,
    on_front,
    overall,
    scalar_error,
)
from pydlpoly.tradeoff.statistics import (
    REACH,
    Deviation,
    block_error,
    combine,
    judge,
    judge_many,
    mean_and_error,
    ratio_and_error,
    slope_and_error,
    student,
)

Progress = Callable[[str, float, float], None]

_EQUILIBRATION = 0.2  # of the budget, at most
_FIRST_LOOK = 0.4  # of the budget, at most, until every candidate has been seen
_SINGLE_OUT = 0.5  # of the budget, after which only the fastest of those that may win go on
_FOCUS = 6  # so many of them at a time
_LOOK_EVERY = 0.06  # of the budget, between decisions
_TURN_SECONDS = 0.5
_SHELLS = 16  # of g(r), out to the cutoff
_FEWEST_PAIRS = 0.02  # in a shell, of those in the fullest one, for it to be compared
_FEWEST_SAMPLES = 8  # for a judgement
_WARM_UP = 50  # steps of the scene's own length that every run discards
_TOO_HOT = 0.2  # a temperature so far off is no longer an error but a failure
_LAG = 200  # steps of the scene's own length between the positions that give the diffusion
_SHORTEST_RUN, _LONGEST_RUN = 1000, 10_000  # steps of the scene's own length that the energy's drift is told for
_BEADS_ALIVE = 4_000_000  # of all candidates together; beyond that each is only in memory while it runs
_LONGEST_STRIDE, _STRIDE = 60, 25


def _silent(_name: str, _done: float, _of: float) -> None:
    pass


@dataclass
class _Samples:
    """What a run was seen to do, one row a sample; ``interval`` is the simulated time between them."""

    interval: float
    rows: list[tuple[float, ...]] = field(default_factory=list)
    shells: list[FloatArray] = field(default_factory=list)
    diffusion: list[float] = field(default_factory=list)

    @property
    def time(self) -> float:
        """Simulated time that the averages are over."""
        return len(self.rows) * self.interval

    def column(self, name: str) -> FloatArray:
        """Return one quantity of every sample."""
        return np.array([row[_COLUMNS.index(name)] for row in self.rows])


_Estimate = tuple[float, float, float]  # a mean, its statistical error, and the error's degrees of freedom
_COLUMNS = ("time", "temperature", "pressure", "energy", "total", "squared_force", "curvature")


class _Running:
    """A candidate at work, or the reference."""

    def __init__(self, candidate: Candidate, scene: Scene, plan: _Plan, number: int) -> None:
        self.candidate, self.plan, self.number = candidate, plan, number
        output = replace(scene.output, rdf_every=plan.stride + 1, rdf_bin_width=scene.cutoff / _SHELLS)
        self.scene = variant(replace(scene, output=output), candidate)
        self.samples = _Samples((plan.stride + 1) * candidate.timestep)
        self.why = candidate.refused
        self.unstable = bool(candidate.refused)
        self.ratios: list[float] = []  # rate over the reference's of the same time
        self.rates: list[float] = []  # steps a second
        self.done = self.unstable  # whether it gets no more turns
        self.deviations: dict[str, Deviation] = {}
        self._simulation: Simulation | None = None
        self._counts: NDArray[np.int64] | None = None
        self._starts = 0  # how often it was set up
        self._before = 0.0  # simulated time before the last time
        self._origins: list[tuple[int, FloatArray]] = []

    @property
    def begun(self) -> bool:
        """Whether there are averages of it."""
        return len(self.samples.rows) > 0

    def turn(self, seconds: float) -> float:
        """Run for about so long, at least one sample, and return the steps a second of the whole turn.

        The time that looking takes is not counted. A run that fails is marked as unstable, and its rate is 0.
        """
        end = clock.perf_counter() + seconds
        steps = spent = 0.0
        try:
            simulation = self._ready()
            while True:
                begin = clock.perf_counter()
                simulation.run(self.plan.stride)
                spent += clock.perf_counter() - begin
                steps += self.plan.stride
                simulation.run(1)  # the step in which the core counts pair distances, which takes time
                self._sample(simulation)
                if clock.perf_counter() >= end:
                    break
        except (RunError, SceneError) as error:
            self._fail(str(error))
            return 0.0
        if self._runs_away():
            return 0.0
        rate = steps / max(spent, 1e-9)
        self.rates.append(rate)
        return rate

    def release(self) -> None:
        """Give the simulation's memory back; a later turn goes on from where it was."""
        if self._simulation is not None:
            state = self._simulation.state
            beads = replace(self.scene.beads, positions=state.positions, velocities=state.velocities)
            self.scene = replace(self.scene, beads=beads)
            self._before += state.time
            self._simulation = None

    def _ready(self) -> Simulation:
        if self._simulation is None:
            seed = (self.plan.seed + 1 + self.number + 100_003 * self._starts) % 2**64
            self._simulation = Simulation(self.scene, seed=seed, threads=self.plan.threads)
            if self._starts == 0:
                period = self.plan.stride + 1
                steps = _WARM_UP * self.plan.timestep / self.candidate.timestep
                self._simulation.run(period * max(1, round(steps / period)))
            self._starts += 1
            self._counts, _ = self._simulation.distance_counts()
            self._origins = []
        return self._simulation

    def _sample(self, simulation: Simulation) -> None:
        seen = simulation.observe()
        squared_force, curvature = simulation.configurational()
        beads = simulation.scene.bead_count
        numbers = (seen.temperature, seen.pressure, seen.energy["potential"] / beads, seen.energy["total"] / beads)
        if not np.isfinite(numbers).all():
            raise RunError(f"step {simulation.step}: the energy is not finite")
        self.samples.rows.append((self._before + simulation.time, *numbers, squared_force, curvature))
        counts, _ = simulation.distance_counts()
        assert self._counts is not None
        self.samples.shells.append(self.plan.pairs_counted(counts - self._counts))
        self._counts = counts
        if self.plan.lag > 0.0:
            self._diffuse(simulation)

    def _diffuse(self, simulation: Simulation) -> None:
        """Add D from how much the square displacement grows between one and two lags."""
        strides = max(1, round(self.plan.lag / self.samples.interval))
        self._origins.append((simulation.step, simulation.displacements()[~simulation.scene.beads.frozen]))
        if len(self._origins) == 2 * strides + 1:
            start, middle, end = (self._origins[k][1] for k in (0, strides, 2 * strides))
            one, two = (float(np.mean(np.sum((x - start) ** 2, axis=1))) for x in (middle, end))
            self.samples.diffusion.append((two - one) / (6.0 * strides * self.samples.interval))
            self._origins = self._origins[-1:]

    def _runs_away(self) -> bool:
        temperatures = self.samples.column("temperature")
        recent = temperatures[-max(4, len(temperatures) // 2) :]
        noise = 4.0 * self.plan.usual * np.sqrt(2.0 / max(1, self.scene.degrees_of_freedom) / len(recent))
        off = float(recent.mean()) - self.plan.usual
        if abs(off) <= _TOO_HOT * self.plan.usual + noise:
            return False
        self._fail(f"the temperature is {100.0 * off / self.plan.usual:+.0f} % off")
        return True

    def _fail(self, why: str) -> None:
        self.why, self.unstable, self.done = why, True, True
        self._simulation = None


@dataclass
class _Plan:
    """What all runs have in common.

    Attributes:
        timestep: the scene's own; ``stride``: timed steps from one sample to the next, where one more is taken.
        usual: the temperature that is expected; ``wanted``: the thermostat's, None where it need not be met.
        lag: simulated time between the positions that give the diffusion, 0 for none.
    """

    seed: int
    threads: int | None
    target: float
    timestep: float
    stride: int
    usual: float
    wanted: float | None
    lag: float
    shells: FloatArray  # (pairs of species, shells): g for one pair counted in one sample; 0 where there are no beads
    first: NDArray[np.int64]
    second: NDArray[np.int64]
    run_time: float
    boltzmann: float
    ideal_pressure: float
    thermal: float
    thermostat: bool

    def pairs_counted(self, counts: NDArray[np.int64]) -> FloatArray:
        """Return the counts of the pairs of species one after the other."""
        return np.asarray(counts[self.first, self.second], dtype=np.float64).ravel()


def tradeoff(
    scene: Scene,
    *,
    budget: float = 120.0,
    target: float = 0.01,
    integrators: Sequence[str] | None = None,
    timesteps: Sequence[float] | None = None,
    precisions: Sequence[str] | None = None,
    threads: int | None = None,
    diffusion: bool = False,
    seed: int | None = None,
    progress: Progress | None = None,
) -> TradeoffReport:
    """Measure how fast and how accurate integrators, timesteps and precisions are for a scene.

    Args:
        scene: what is modelled. Its outputs are not written.
        budget: wall time in seconds.
        target: largest error that is aimed at, as a fraction (0.01 is 1 %).
        integrators: names of ``pydlpoly.scene.integrators.INTEGRATORS``; default: those in common use.
        timesteps: in internal units (ps, or reduced); default: 1/2, 1, 3/2, 2, 3, 4 and 6 times the scene's.
        precisions: "double", "mixed", "reference"; default: the first two, where they differ.
        threads: as for ``Simulation``.
        diffusion: also compare the diffusion coefficient, which takes long runs.
        seed: of all runs; default: the scene's, else drawn anew.
        progress: called with what is being done, the seconds gone by and the budget.

    Returns:
        what was found; Ctrl-C ends the measurement early with what is known by then.

    Raises:
        SceneError: an argument does not fit the scene.
        RunError: the scene cannot even be equilibrated.
    """
    if not budget > 0.0 or not 0.0 < target < 1.0:
        raise InputError(f"the budget must be above 0 and the target between 0 and 1, not {budget:g} and {target:g}")
    if scene.dynamics.integrator != "nve" and not scene.dynamics.thermal_energy > 0.0:
        raise SceneError("at temperature 0 nothing fluctuates, and there is nothing to compare")
    candidates = candidates_for(scene, integrators, timesteps, precisions)
    chosen = scene.run.seed if seed is None else seed
    base = secrets.randbits(64) if chosen is None else chosen
    work = _Measurement(scene, candidates, budget, target, threads, base, diffusion, progress or _silent)
    return work.report()


class _Measurement:
    """One call of ``tradeoff``."""

    def __init__(
        self,
        scene: Scene,
        candidates: list[Candidate],
        budget: float,
        target: float,
        threads: int | None,
        seed: int,
        diffusion: bool,
        progress: Progress,
    ) -> None:
        self.scene, self.budget, self.target, self.tell = scene, budget, target, progress
        self.begin = clock.perf_counter()
        self.machine = this_machine()
        self.notes: list[str] = []
        self.interrupted = False
        best = reference_for(scene, candidates)
        start, temperature, costs = self._equilibrate(best, threads, seed)
        self.threads = start.threads
        plan = self._plan(start, temperature, costs, len(candidates), seed, diffusion)
        state = start.state
        beads = replace(scene.beads, positions=state.positions, velocities=state.velocities)
        run = replace(
            scene.run, start="noscale", equilibration_steps=0, rescale_every=0, regauss_every=0, force_cap=0.0
        )
        common = replace(scene, beads=beads, run=run)
        self.plan = plan
        self.reference = _Running(best, common, plan, 0)
        self.running = [_Running(one, common, plan, 1 + k) for k, one in enumerate(candidates)]
        self.turn = self.running  # who runs until the next decision
        self.keep = scene.bead_count * (1 + len(candidates)) <= _BEADS_ALIVE
        self.pace = 0.0  # steps a second of the reference in its last turn
        if not self._in_equilibrium(temperature):
            for one in self.running:
                one.why, one.done = one.why or "the start was not in equilibrium yet", True
            return
        try:
            self._first_look()
            self._rounds()
        except KeyboardInterrupt:
            if not self.reference.begun:
                raise
            self.interrupted = True

    # Start

    def _equilibrate(
        self, best: Candidate, threads: int | None, seed: int
    ) -> tuple[Simulation, float, tuple[float, float]]:
        """Take the scene's own equilibration, then go on with the accurate integrator until the energy has settled.

        Returns the simulation, its last temperature, and how many seconds a step and a look take.
        """
        scene, end = self.scene, self.begin + _EQUILIBRATION * self.budget
        quiet = replace(scene.output, rdf_every=0)
        if scene.run.start == "continue":
            scene = replace(scene, run=replace(scene.run, start="noscale"))
        first = variant(replace(scene, output=quiet), _own(scene))
        simulation = Simulation(first, threads=threads, seed=seed)
        wanted = scene.run.equilibration_steps
        try:
            while simulation.step < wanted and clock.perf_counter() < end:
                simulation.run(min(20, wanted - simulation.step))
                self._show("equilibrating")
        except RunError:
            self.notes.append("the scene's own settings do not survive the equilibration; a smaller timestep took over")
            simulation = Simulation(variant(first, best), threads=threads, seed=seed)
        if simulation.step < wanted:
            self.notes.append(f"the budget left {simulation.step} of {wanted} steps of the scene's equilibration")
        state = simulation.state
        beads = replace(scene.beads, positions=state.positions, velocities=state.velocities)
        run = replace(scene.run, start="noscale", equilibration_steps=0)
        second = variant(replace(first, beads=beads, run=run), best)
        simulation = Simulation(second, threads=threads, seed=(seed + 1) % 2**64)
        energies: list[float] = []
        temperatures: list[float] = []
        step = look = float("inf")
        while True:
            begin = clock.perf_counter()
            simulation.run(20)
            middle = clock.perf_counter()
            seen = simulation.observe()
            energies.append(seen.energy["potential"])
            temperatures.append(seen.temperature)
            if len(energies) % 10 == 1:
                simulation.configurational()
                look = min(look, clock.perf_counter() - middle)
            step = min(step, (middle - begin) / 20)
            self._show("equilibrating")
            if len(energies) >= 30 and len(energies) % 10 == 0 and _settled(np.array(energies)):
                break
            if clock.perf_counter() >= end:
                if len(energies) < 30 or not _settled(np.array(energies)):
                    self.notes.append("the budget did not let the start settle for certain: the energy may still drift")
                break
        return simulation, float(np.mean(temperatures[-15:])), (step, look)

    def _in_equilibrium(self, temperature: float) -> bool:
        """Whether the start has about the temperature that it should have; if not, nobody could be judged."""
        noise = 4.0 * np.sqrt(2.0 / max(1, self.scene.degrees_of_freedom))
        return self.plan.wanted is None or abs(temperature / self.plan.wanted - 1.0) <= 0.5 * _TOO_HOT + float(noise)

    def _plan(
        self,
        start: Simulation,
        temperature: float,
        costs: tuple[float, float],
        candidates: int,
        seed: int,
        diffusion: bool,
    ) -> _Plan:
        scene, dynamics, units = self.scene, self.scene.dynamics, self.scene.units
        step, look = costs
        # Looking shall not take longer than running, and every candidate shall have its turn.
        affordable = int(_FIRST_LOOK * self.budget / (3.0 * candidates) / step)
        stride = max(2, min(max(_STRIDE, min(_LONGEST_STRIDE, round(look / step))), affordable))
        wanted: float | None = None
        usual = temperature
        if dynamics.integrator != "nve":
            usual = dynamics.thermal_energy / units.boltzmann
            driven = scene.external or dynamics.shear_rate != 0.0
            wanted = None if driven else usual
            if driven:
                cause = "external fields do" if scene.external else "shear does"
                self.notes.append(f"{cause} work: temperatures are compared with the reference's")
        if dynamics.schedule is not None:
            self.notes.append(f"the temperature is held at {usual:g}; its schedule is left out")
        first, second = np.triu_indices(len(scene.species))
        volume = abs(float(np.linalg.det(scene.cell)))
        number = np.bincount(scene.beads.species, minlength=len(scene.species))
        shells = np.zeros((len(first), _SHELLS))
        for k, (a, b) in enumerate(zip(first.tolist(), second.tolist(), strict=True)):
            if min(number[a], number[b]) > (1 if a == b else 0):
                shells[k] = normalise_rdf(
                    np.ones(shells.shape[1]),
                    like=a == b,
                    volume=volume,
                    beads=(int(number[a]), int(number[b])),
                    configurations=1,
                    bin_width=scene.cutoff / _SHELLS,
                )[1]
        run_steps = min(max(_SHORTEST_RUN, scene.run.steps - scene.run.equilibration_steps), _LONGEST_RUN)
        thermal = usual * units.boltzmann
        return _Plan(
            seed=seed,
            threads=start.threads,
            target=self.target,
            timestep=dynamics.timestep,
            stride=stride,
            usual=usual,
            wanted=wanted,
            lag=_LAG * dynamics.timestep if diffusion else 0.0,
            shells=shells,
            first=first,
            second=second,
            run_time=run_steps * dynamics.timestep,
            boltzmann=units.boltzmann,
            ideal_pressure=scene.bead_count * thermal / volume * units.pressure_factor,
            thermal=thermal,
            thermostat=dynamics.integrator != "nve",
        )

    # Turns

    @property
    def gone(self) -> float:
        """Seconds since the beginning."""
        return clock.perf_counter() - self.begin

    def _show(self, what: str) -> None:
        self.tell(what, min(self.gone, self.budget), self.budget)

    def _first_look(self) -> None:
        """Give each candidate a turn, small timesteps first: what an unstable one exceeds is not tried."""
        seconds = max(0.0, (_FIRST_LOOK * self.budget - self.gone) / (1.5 * len(self.running) + 1.0))
        self._reference_turn(seconds)
        if self.reference.unstable:
            raise RunError(f"the reference ({self.reference.candidate.label}) does not run: {self.reference.why}")
        groups = groupby(self.running, key=lambda one: (one.candidate.name, one.candidate.precision))
        queue = [list(group) for _, group in groups]
        # By timestep, so that a budget that ends leaves every integrator with a few; the scene's own one comes first.
        order = [one for one in self.running if one.candidate.own]
        order += [g[k] for k in range(max(map(len, queue))) for g in queue if k < len(g) and not g[k].candidate.own]
        for count, one in enumerate(order):
            limit = self._limit_of(one)
            if limit is not None and not one.done:
                one.why, one.unstable, one.done = f"so is timestep {limit:g}", True, True
            if one.done:
                continue
            if self.gone > 0.8 * self.budget:
                one.why, one.done = "the budget was over", True
                continue
            if count % 3 == 0:
                self._reference_turn(min(seconds, _TURN_SECONDS))
            self._candidate_turn(one, min(seconds, _TURN_SECONDS))
            self._show("first look")

    def _limit_of(self, one: _Running) -> float | None:
        """Return the smallest timestep that failed under the same settings, when it is below this one's."""
        mine = one.candidate
        failed = [
            other.candidate.timestep
            for other in self.running
            if other.unstable
            and (other.candidate.name, other.candidate.precision) == (mine.name, mine.precision)
            and other.candidate.timestep < mine.timestep
        ]
        return min(failed, default=None)

    def _rounds(self) -> None:
        looked = -1.0
        direction = 1
        while True:
            if self.gone - looked >= _LOOK_EVERY * self.budget or looked < 0.0:
                self._decide()
                looked = self.gone
            alive = [one for one in self.turn if not one.done]
            left = self.budget - self.gone
            if not alive or left <= 0.0:
                break
            turns = self._reference_turns(alive)
            seconds = min(_TURN_SECONDS, left / (len(alive) + turns) / 4.0)
            every = max(1, len(alive) // turns)
            extra = max(1, round(turns / (-(-len(alive) // every))))
            for k, one in enumerate(alive[::direction]):
                if k % every == 0:
                    for _ in range(extra):
                        self._reference_turn(seconds)
                if self.gone >= self.budget:
                    break
                self._candidate_turn(one, seconds)
                self._show(f"{len(alive)} candidates")
            direction = -direction
        self._judge()

    def _reference_turns(self, alive: list[_Running]) -> int:
        """How many turns of the reference go to one of each candidate, for the smallest errors of all differences."""
        speeds = [one.rates[-1] * one.candidate.timestep for one in alive if one.rates]
        pace = max(self.pace * self.reference.candidate.timestep, 1e-300)
        ratio = float(np.median(speeds)) / pace if speeds else 1.0
        return max(1, min(4 * len(alive), round(float(np.sqrt(len(alive) * max(ratio, 0.1))))))

    def _reference_turn(self, seconds: float) -> None:
        self.pace = self.reference.turn(seconds) or self.pace
        if self.reference.unstable and self.reference.begun:
            self.reference.unstable = False
            raise RunError(f"the reference ({self.reference.candidate.label}) failed: {self.reference.why}")

    def _candidate_turn(self, one: _Running, seconds: float) -> None:
        rate = one.turn(seconds)
        if rate > 0.0 and self.pace > 0.0:
            one.ratios.append(rate / self.pace)
        if not self.keep:
            one.release()

    # Judgement

    def _judge(self) -> None:
        for one in self.running:
            if not one.unstable:
                one.deviations = deviations(one.samples, self.reference.samples, self.plan)

    def _decide(self) -> None:
        """Choose who gets turns until the next decision: first all that are not clearly beaten, later the fastest."""
        self._judge()
        known = [one for one in self.running if one.deviations and not one.unstable]
        good = [self._speed(one) for one in known if overall(one.deviations) == "within"]
        for one in known:
            one.why, one.done = self._given_up(one, known, max(good, default=0.0)), False
            one.done = bool(one.why)
        alive = sorted((one for one in self.running if not one.done), key=self._speed, reverse=True)
        self.turn = alive[:_FOCUS] if self.gone > _SINGLE_OUT * self.budget else alive
        own = [one for one in self.running if one.candidate.own and not one.unstable]  # what the rest is measured by
        for one in own:
            one.why, one.done = "", False
        self.turn += [one for one in own if one not in self.turn]
        for one in self.running:
            if one.done:
                one.release()

    def _given_up(self, one: _Running, known: list[_Running], best: float) -> str:
        """Why a candidate gets no more turns, "" when it does."""
        error, _, noise = scalar_error(one.deviations)
        for other in known:
            above, _, more = scalar_error(other.deviations)
            if self._speed(other) > 1.1 * self._speed(one) and above + REACH * more < error - REACH * noise:
                return f"{other.candidate.label} is faster and more accurate"
        if self.gone <= _SINGLE_OUT * self.budget:
            return ""
        if self._speed(one) < 0.9 * best:
            return "slower than one that is within"
        return "outside for certain" if overall(one.deviations) == "outside" else ""

    def _speed(self, one: _Running) -> float:
        return float(np.median(one.ratios)) * one.candidate.timestep if one.ratios else 0.0

    # Report

    def report(self) -> TradeoffReport:
        """Return what is known."""
        self._judge()
        measured = [self._measured(one) for one in self.running]
        marked = [replace(one, front=front) for one, front in zip(measured, on_front(measured), strict=True)]
        marked.sort(key=lambda one: (one.status != "measured", -(one.speed.median if one.speed else 0.0)))
        best = next((k for k, one in enumerate(marked) if one.status == "measured" and one.verdict == "within"), None)
        unsure = [k for k, one in enumerate(marked) if one.status == "measured" and one.verdict == "cannot tell"]
        undecided = tuple(k for k in unsure if best is None or k < best)
        needed = [self._needed(marked[k]) for k in undecided]
        if best is None and not undecided and any(one.status == "not run" for one in marked):
            needed = [4.0 * self.budget]
        self._note_dynamics()
        energies = self.reference.samples.column("energy")
        if len(energies) >= 3 * _FEWEST_SAMPLES and not _settled(energies, 2):
            self.notes.append(
                "the energy of the reference changes with time: the scene is not in equilibrium, and its errors are "
                "those of unlike states; equilibrate it first"
            )
        return TradeoffReport(
            title=self.scene.title,
            beads=self.scene.bead_count,
            time_unit="" if self.scene.units.reduced else "ps",
            machine=self.machine,
            target=self.target,
            budget=self.budget,
            seconds=self.gone,
            seed=self.plan.seed,
            threads=self.threads,
            reference=self._reference(),
            candidates=tuple(marked),
            recommended=best,
            undecided=undecided,
            budget_needed=(max(needed) if best is not None else min(needed)) if needed else None,
            notes=tuple(self.notes),
            interrupted=self.interrupted,
        )

    def _measured(self, one: _Running) -> Measured:
        c = one.candidate
        found = Measured(
            c.integrator,
            c.timestep,
            c.precision,
            c.prediction,
            c.path,
            c.own,
            "not run",
            one.why,
            half=c.half,
            interval=c.interval,
        )
        if one.unstable:
            return replace(found, status="unstable")
        if not one.deviations or not one.ratios:
            return replace(found, why=one.why or "too few samples")
        pace = float(np.median(self.reference.rates))
        error, whose, noise = scalar_error(one.deviations)
        return replace(
            found,
            status="measured",
            speed=Spread.of([ratio * pace * c.timestep for ratio in one.ratios]),
            time=one.samples.time,
            deviations=one.deviations,
            error=error,
            error_of=whose,
            error_noise=noise,
            verdict=overall(one.deviations),
            given_up=one.done or one not in self.turn,
        )

    def _needed(self, one: Measured) -> float:
        """Budget after which the errors would be small enough to tell; never less than twice the present one."""
        factors = [2.0]
        for deviation in (one.deviations or {}).values():
            if deviation.verdict == "cannot tell":
                room = max(abs(self.target - abs(deviation.value)), 0.25 * self.target)
                noise = deviation.error if np.isfinite(deviation.error) else 2.0 * room
                factors.append((REACH * noise / room) ** 2)
        return self.budget * min(max(factors), 1e4)

    def _note_dynamics(self) -> None:
        other = sorted({one.candidate.integrator for one in self.running if one.begun} & OTHER_DYNAMICS)
        if other:
            self.notes.append(
                f"{', '.join(other)}: same averages, another drag than the rest, so another viscosity and diffusion"
            )

    def _reference(self) -> Reference:
        samples, one = self.reference.samples, self.reference.candidate
        if not samples.rows:
            return Reference(one.integrator, one.timestep, one.precision, 0.0, {}, {})
        averages = {name: mean_and_error(samples.column(name))[:2] for name in ("temperature", "pressure", "energy")}
        ratio = _configurational(samples)
        if ratio is not None:
            averages["configurational_temperature"] = ratio[0] / self.plan.boltzmann, ratio[1] / self.plan.boltzmann
        own: dict[str, Deviation] = {}
        if self.plan.wanted is not None:
            own = {k: d for k, d in deviations(samples, samples, self.plan).items() if "temperature" in k}
            for name, deviation in own.items():
                if deviation.verdict == "outside":
                    self.notes.append(
                        f"the reference itself is {100.0 * deviation.value:+.2g} % off in {name.replace('_', ' ')}: "
                        "give smaller timesteps"
                    )
        return Reference(one.integrator, one.timestep, one.precision, self.reference.samples.time, averages, own)


def _own(scene: Scene) -> Candidate:
    """The scene's settings as a candidate."""
    dynamics = scene.dynamics
    own = Candidate(dynamics.integrator, dynamics.timestep, dynamics.precision)
    if dynamics.integrator == "mdvv":
        return replace(own, prediction=dynamics.prediction, half=dynamics.half_step_kinetic)
    return replace(own, interval=dynamics.interval) if dynamics.integrator in ("middle", "ou-middle") else own


def _settled(energies: FloatArray, parts: int = 3) -> bool:
    """Whether the last part of a series has the mean of the part before it, with 99 % confidence that it has not."""
    size = len(energies) // parts
    (a, s, n), (b, u, m) = mean_and_error(energies[-2 * size : -size]), mean_and_error(energies[-size:])
    error, freedom = combine((s, n), (u, m))
    return abs(a - b) <= float(student(freedom, 0.99)) * error


def _configurational(samples: _Samples) -> tuple[float, float, float] | None:
    """k_B times the configurational temperature, its error and degrees of freedom; None where there is none."""
    squared_force, curvature = samples.column("squared_force"), samples.column("curvature")
    if not np.isfinite(squared_force).all() or not np.isfinite(curvature).all() or not curvature.mean() > 0.0:
        return None
    return ratio_and_error(squared_force, curvature)


def deviations(samples: _Samples, reference: _Samples, plan: _Plan) -> dict[str, Deviation]:
    """Return how far the averages of a run are off, each as a fraction of its scale."""
    found: dict[str, Deviation] = {}
    if min(len(samples.rows), len(reference.rows)) < _FEWEST_SAMPLES:
        return found

    longer = np.sqrt(reference.time / samples.time)
    wanted = plan.wanted

    def add(name: str, mine: _Estimate, theirs: _Estimate, least: float = 0.0, exact: float | None = None) -> None:
        """Compare with the reference, or with an exact value; the scale is the size of that, or at least ``least``."""
        error, freedom = _not_below(mine[1:], theirs[1:], float(longer))
        value = mine[0] - (theirs[0] if exact is None else exact)
        if exact is None:
            error, freedom = combine((error, freedom), theirs[1:])
        scale = max(abs(theirs[0] if exact is None else exact), least) or 1.0
        found[name] = judge(value / scale, error / scale, freedom, plan.target)

    def both(name: str) -> tuple[_Estimate, _Estimate]:
        return mean_and_error(samples.column(name)), mean_and_error(reference.column(name))

    mine, theirs = both("temperature")
    add("temperature", mine, theirs, exact=wanted)
    positions, other = _configurational(samples), _configurational(reference)
    if positions is not None and other is not None:
        add("configurational_temperature", positions, other, exact=None if wanted is None else wanted * plan.boltzmann)
    for name, least in (("pressure", plan.ideal_pressure), ("energy", plan.thermal)):
        mine, theirs = both(name)
        add(name, mine, theirs, least)
    structure = _structure(samples, reference, plan)
    if structure is not None:
        found["rdf"] = structure
    if not plan.thermostat:
        slope, error, freedom = slope_and_error(samples.column("time"), samples.column("total"))
        scale = 1.5 * plan.thermal / plan.run_time
        found["drift"] = judge(slope / scale, error / scale, freedom, plan.target)
    if plan.lag > 0.0:
        found["diffusion"] = Deviation(0.0, float("inf"), "cannot tell")
        if min(len(samples.diffusion), len(reference.diffusion)) >= 2:
            add("diffusion", mean_and_error(samples.diffusion), mean_and_error(reference.diffusion))
    return found


def _not_below(mine: tuple[float, float], theirs: tuple[float, float], longer: float) -> tuple[float, float]:
    """Return an error and its degrees of freedom, but no less than the reference's error says for so short a run.

    Fluctuations last as long in both. A run that is shorter than they last does not know its error.
    """
    return mine if mine[0] >= theirs[0] * longer else (theirs[0] * longer, theirs[1])


def _structure(samples: _Samples, reference: _Samples, plan: _Plan) -> Deviation | None:
    """Return the largest deviation of g(r) over shells in which enough pairs were counted."""
    mine, theirs = np.array(samples.shells), np.array(reference.shells)
    unit = plan.shells.ravel()
    seen = theirs.sum(axis=0).reshape(plan.shells.shape)
    enough = (seen >= np.maximum(1.0, _FEWEST_PAIRS * seen.max(axis=1, keepdims=True))).ravel()
    if not enough.any():
        return None
    a, b = (x[:, enough] * unit[enough] for x in (mine, theirs))
    (s, n), (u, m) = block_error(a), block_error(b)
    least = u * np.sqrt(reference.time / samples.time)
    s, n = np.maximum(s, least), np.where(s < least, m, n)
    errors = np.hypot(s, u)
    with np.errstate(invalid="ignore", divide="ignore"):
        freedom = np.where(errors > 0.0, errors**4 / (s**4 / n + u**4 / m), np.minimum(n, m))
    return judge_many(a.mean(axis=0) - b.mean(axis=0), errors, np.nan_to_num(freedom, nan=1.0), plan.target)
