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
from dataclasses import replace
from itertools import groupby

import numpy as np

from pydlpoly.bench.results import Spread, this_machine
from pydlpoly.errors import InputError, RunError, SceneError
from pydlpoly.formats.rdfdat import normalise_rdf
from pydlpoly.scene.model import Scene
from pydlpoly.simulation import Simulation
from pydlpoly.tradeoff.candidates import OTHER_DYNAMICS, Candidate, candidates_for, reference_for, variant
from pydlpoly.tradeoff.deviations import configurational, deviations
from pydlpoly.tradeoff.report import (
    Measured,
    Reference,
    TradeoffReport,
    on_front,
    overall,
    scalar_error,
)
from pydlpoly.tradeoff.running import TOO_HOT, Running
from pydlpoly.tradeoff.samples import FEWEST_SAMPLES, SHELLS, Plan, settled
from pydlpoly.tradeoff.statistics import REACH, Deviation, mean_and_error

Progress = Callable[[str, float, float], None]

_EQUILIBRATION = 0.2  # of the budget, at most
_FIRST_LOOK = 0.4  # of the budget, at most, until every candidate has been seen
_SINGLE_OUT = 0.5  # of the budget, after which only the fastest of those that may win go on
_FOCUS = 6  # so many of them at a time
_LOOK_EVERY = 0.06  # of the budget, between decisions
_TURN_SECONDS = 0.5
_LAG = 200  # steps of the scene's own length between the positions that give the diffusion
_SHORTEST_RUN, _LONGEST_RUN = 1000, 10_000  # steps of the scene's own length that the energy's drift is told for
_BEADS_ALIVE = 4_000_000  # of all candidates together; beyond that each is only in memory while it runs
_LONGEST_STRIDE, _STRIDE = 60, 25


def _silent(_name: str, _done: float, _of: float) -> None:
    pass


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
    if scene.heat is not None:
        raise SceneError("beads that carry heat have no temperature that is the same for all integrators to compare at")
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
        self.reference = Running(best, common, plan, 0)
        self.running = [Running(one, common, plan, 1 + k) for k, one in enumerate(candidates)]
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
            if len(energies) >= 30 and len(energies) % 10 == 0 and settled(np.array(energies)):
                break
            if clock.perf_counter() >= end:
                if len(energies) < 30 or not settled(np.array(energies)):
                    self.notes.append("the budget did not let the start settle for certain: the energy may still drift")
                break
        return simulation, float(np.mean(temperatures[-15:])), (step, look)

    def _in_equilibrium(self, temperature: float) -> bool:
        """Whether the start has about the temperature that it should have; if not, nobody could be judged."""
        noise = 4.0 * np.sqrt(2.0 / max(1, self.scene.degrees_of_freedom))
        return self.plan.wanted is None or abs(temperature / self.plan.wanted - 1.0) <= 0.5 * TOO_HOT + float(noise)

    def _plan(
        self,
        start: Simulation,
        temperature: float,
        costs: tuple[float, float],
        candidates: int,
        seed: int,
        diffusion: bool,
    ) -> Plan:
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
        shells = np.zeros((len(first), SHELLS))
        for k, (a, b) in enumerate(zip(first.tolist(), second.tolist(), strict=True)):
            if min(number[a], number[b]) > (1 if a == b else 0):
                shells[k] = normalise_rdf(
                    np.ones(shells.shape[1]),
                    like=a == b,
                    volume=volume,
                    beads=(int(number[a]), int(number[b])),
                    configurations=1,
                    bin_width=scene.cutoff / SHELLS,
                )[1]
        run_steps = min(max(_SHORTEST_RUN, scene.run.steps - scene.run.equilibration_steps), _LONGEST_RUN)
        thermal = usual * units.boltzmann
        return Plan(
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

    def _limit_of(self, one: Running) -> float | None:
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

    def _reference_turns(self, alive: list[Running]) -> int:
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

    def _candidate_turn(self, one: Running, seconds: float) -> None:
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

    def _given_up(self, one: Running, known: list[Running], best: float) -> str:
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

    def _speed(self, one: Running) -> float:
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
        if len(energies) >= 3 * FEWEST_SAMPLES and not settled(energies, 2):
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

    def _measured(self, one: Running) -> Measured:
        found = Measured(**vars(one.candidate), why=one.why)
        if one.unstable:
            return replace(found, status="unstable")
        if not one.deviations or not one.ratios:
            return replace(found, why=one.why or "too few samples")
        pace = float(np.median(self.reference.rates))
        error, whose, noise = scalar_error(one.deviations)
        return replace(
            found,
            status="measured",
            speed=Spread.of([ratio * pace * one.candidate.timestep for ratio in one.ratios]),
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
        ratio = configurational(samples)
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
