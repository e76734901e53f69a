"""A candidate at work: turns of limited time, each with samples; runs that fail are marked."""

from __future__ import annotations

import time as clock
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import RunError, SceneError
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Scene
from pydlpoly.simulation import Simulation
from pydlpoly.tradeoff.candidates import Candidate, variant
from pydlpoly.tradeoff.samples import SHELLS, Plan, Samples
from pydlpoly.tradeoff.statistics import Deviation

_WARM_UP = 50  # steps of the scene's own length that every run discards
TOO_HOT = 0.2  # a temperature so far off is no longer an error but a failure


class Running:
    """A candidate at work, or the reference."""

    def __init__(self, candidate: Candidate, scene: Scene, plan: Plan, number: int) -> None:
        self.candidate, self.plan, self.number = candidate, plan, number
        output = replace(scene.output, rdf_every=plan.stride + 1, rdf_bin_width=scene.cutoff / SHELLS)
        self.scene = variant(replace(scene, output=output), candidate)
        self.samples = Samples((plan.stride + 1) * candidate.timestep)
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
        if abs(off) <= TOO_HOT * self.plan.usual + noise:
            return False
        self._fail(f"the temperature is {100.0 * off / self.plan.usual:+.0f} % off")
        return True

    def _fail(self, why: str) -> None:
        self.why, self.unstable, self.done = why, True, True
        self._simulation = None
