"""Averages of the kinetic and the configurational temperature, and what it means when they disagree.

The kinetic temperature is what a thermostat holds, and it can be right while the positions are not: too long a timestep
shows in the configurational temperature first, and so in structure and pressure.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.formats.blocks import BlockSums, Estimate, beyond_chance, line_through, standard_error
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Scene
from pydlpoly.simulation import Simulation

TOLERATED = 0.02
"""Relative difference of two temperatures that is not worth a warning."""
_THERMOSTAT = "thermostat"
_LEAST_SAMPLES = 8
_LEAST_STEPS = 500  # a temperature that is off by chance stays so for a hundred steps


@dataclass(frozen=True)
class _Difference:
    """Two temperatures that differ by more than is tolerated and than chance explains."""

    one: str
    other: str
    apart: float
    relative: float

    def __str__(self) -> str:
        where = "above" if self.apart > 0.0 else "below"
        return f"{self.one} {100.0 * abs(self.relative):.1f} % {where} {self.other}"


class TemperatureSamples:
    """Samples of both temperatures from the same steps.

    The configurational one is a ratio of averages, Σ|∇U|² over Σ∇²U, with the error of that ratio.
    """

    def __init__(self, scene: Scene) -> None:
        """Start without samples."""
        self._scene = scene
        self._sums = BlockSums(4)

    def add(self, simulation: Simulation) -> None:
        """Take the present step."""
        self._sums.add([*simulation.configurational(), simulation.temperature, float(simulation.step)])

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything a checkpoint needs, as arrays by name."""
        return self._sums.state()

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on exactly where ``state`` was taken."""
        self._sums.restore(state)

    @property
    def target(self) -> float | None:
        """The thermostat's temperature; None without a thermostat, or when it varies."""
        dynamics = self._scene.dynamics
        if dynamics.integrator == "nve" or dynamics.schedule is not None or dynamics.thermal_energy <= 0.0:
            return None
        return dynamics.thermal_energy / self._scene.units.boltzmann

    def kinetic(self) -> Estimate | None:
        """Return the mean kinetic temperature; None without samples."""
        return self._sums.estimate(2) if self._sums.taken > 0 else None

    def configurational(self) -> Estimate | None:
        """Return the mean configurational temperature; None where nothing acts or it could not be computed."""
        squared_force, curvature = self._sums.mean()[:2].tolist()
        if not (math.isfinite(squared_force) and curvature > 0.0):
            return None
        value = squared_force / (curvature * self._scene.units.boltzmann)
        blocks = self._sums.means()
        return Estimate(value, standard_error(self._linear(blocks)), self._sums.taken, len(blocks))

    def _linear(self, blocks: FloatArray) -> FloatArray:
        """Configurational temperature of each block, linear in its sums: this series has the error of the ratio."""
        squared_force, curvature = self._sums.mean()[:2].tolist()
        ratio = squared_force / curvature
        scale = curvature * self._scene.units.boltzmann
        series: FloatArray = (blocks[:, 0] - ratio * (blocks[:, 1] - curvature)) / scale
        return series

    def doubt(self) -> str | None:
        """Return in words, with numbers and the likely cause, how the temperatures disagree; None when they agree.

        They do when each two are within 2 %, or within what three standard errors of their difference allow. Nothing is
        said of fewer than 8 samples, or samples over fewer than 500 steps.
        """
        steps = self._sums.means()[:, 3]
        if self._sums.taken < _LEAST_SAMPLES or (steps[-1] - steps[0]) * len(steps) < _LEAST_STEPS * (len(steps) - 1):
            return None
        series, values = self._series()
        found = []
        names = list(values)
        for k, other in enumerate(names):  # from the one that is right by definition to the one that is most telling
            for one in names[k + 1 :]:
                apart = values[one] - values[other]
                chance = beyond_chance(series[one] - series[other])
                if (one, other) == ("kinetic", _THERMOSTAT):
                    chance = min(chance, self._largest_fluctuation())
                if values[other] > 0.0 and abs(apart) > max(TOLERATED * values[other], chance):
                    found.append(_Difference(one, other, apart, apart / values[other]))
        if not found:
            return None
        numbers = ", ".join(self._number(name) for name in reversed(names))
        where = ", ".join(str(difference) for difference in reversed(found))
        return f"temperatures disagree: {numbers}; {where}; {self._cause(found, series)}"

    def _largest_fluctuation(self) -> float:
        """Four standard deviations of a single kinetic temperature: a mean so far off is no chance, however few count.

        A run that still cools has samples so much alike that their scatter says nothing.
        """
        freedom = self._scene.degrees_of_freedom
        if self.target is None or freedom <= 0:
            return math.inf
        return 4.0 * self.target * math.sqrt(2.0 / freedom)

    def _series(self) -> tuple[dict[str, FloatArray], dict[str, float]]:
        """Averages over blocks, and over all samples, of the temperatures that can be compared."""
        blocks, kinetic, configurational = self._sums.means(), self.kinetic(), self.configurational()
        series: dict[str, FloatArray] = {}
        values = {}
        if self.target is not None:
            series[_THERMOSTAT], values[_THERMOSTAT] = np.full(len(blocks), self.target), self.target
        if kinetic is not None:
            series["kinetic"], values["kinetic"] = blocks[:, 2], kinetic.value
        if configurational is not None:
            series["configurational"], values["configurational"] = self._linear(blocks), configurational.value
        return series, values

    def _number(self, name: str) -> str:
        if name == _THERMOSTAT:
            return f"thermostat {self.target:.5g}{self._unit}"
        estimate = self.kinetic() if name == "kinetic" else self.configurational()
        assert estimate is not None
        return f"{name} {estimate.value:.5g} +- {estimate.error:.2g}{self._unit}"

    @property
    def _unit(self) -> str:
        label = self._scene.units.temperature_label
        return f" {label}" if label else ""

    def _cause(self, found: list[_Difference], series: Mapping[str, FloatArray]) -> str:
        dynamics = self._scene.dynamics
        for difference in found:
            for name in (difference.one, difference.other):
                change = change_over(series[name])
                if abs(change) > 0.5 * abs(difference.apart):
                    return (
                        f"the {name} one still changes, by about {change:.3g}{self._unit} over the samples: the run is "
                        "probably not equilibrated (time_equilibration)"
                    )
        if self._scene.external:
            return "an external field heats the beads faster than they lose heat, or the timestep is too long"
        if dynamics.shear_rate != 0.0:
            return "shear heats the beads faster than they lose heat, or the timestep is too long"
        if dynamics.schedule is not None:
            return "the temperature changes faster than the beads follow, or the timestep is too long"
        unit = "" if self._scene.units.reduced else " ps"
        return (
            f"the timestep of {dynamics.timestep:g}{unit} is probably too long, or else the run is not equilibrated; "
            "structure and pressure are those of the configurational temperature"
        )


def change_over(series: FloatArray) -> float:
    """By how much a series changes from end to end, from the means of its halves; 0 when these may be equal."""
    half = len(series) // 2
    early, late = series[:half], series[-half:]
    scatter = math.sqrt((float(np.var(early)) + float(np.var(late))) / half)
    apart = float(np.mean(late) - np.mean(early))
    return 2.0 * apart if abs(apart) > 2.0 * scatter else 0.0


class EnergyDrift:
    """The drift of the total energy of an nve run: a straight line through the samples after equilibration."""

    def __init__(self, scene: Scene) -> None:
        """Start without samples."""
        self._scene = scene
        self._acts = scene.dynamics.integrator == "nve"
        self._sums = BlockSums(2)

    def add(self, simulation: Simulation) -> None:
        """Take the present step, unless a thermostat acts or velocities may be scaled still."""
        scene = self._scene
        if self._acts and simulation.step > scene.run.equilibration_steps:
            energy = simulation.observe().energy["total"] / scene.units.factor / scene.bead_count
            self._sums.add([simulation.time, energy])

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything a checkpoint needs, as arrays by name."""
        return self._sums.state()

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on exactly where ``state`` was taken."""
        self._sums.restore(state)

    def estimate(self) -> Estimate | None:
        """Return the drift in FIELD's energy unit per bead and ps; None when there are too few samples."""
        times, energies = self._sums.means().T
        slope, error = line_through(times, energies)
        return None if math.isnan(slope) else Estimate(slope, error, self._sums.taken, len(times))
