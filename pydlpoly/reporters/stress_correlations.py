"""Correlation functions of the stress during a run, and the viscosity that follows from them.

Green and Kubo: η = V/(k_B T) ∫⟨σ_xy(0) σ_xy(t)⟩ dt, with the stress of all parts: momenta, pair laws, bonded terms,
drag and noise. The noise of one step is correlated with itself alone, as a delta function would be; the trapezoidal
rule gives that sample half its weight, which makes the integral the one of Einstein and Helfand, of the momentum that
was carried in the run (Jung and Schmid, J. Chem. Phys. 144, 204104 (2016)). It holds when every step is sampled.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import InputError
from pydlpoly.formats.blocks import Estimate, standard_error, standard_errors
from pydlpoly.formats.cor import Correlation, Derived, write_correlations
from pydlpoly.formats.records import FloatArray
from pydlpoly.reporters.multiple_tau import MultipleTau, running_integral
from pydlpoly.reporters.schedule import every
from pydlpoly.scene.integrators import is_pairwise
from pydlpoly.scene.model import CorrelationTerm, Scene
from pydlpoly.simulation import Simulation

_AXES = "xyz"


class StressCorrelations:
    """A reporter that correlates components of the stress; append it to ``Simulation.reporters``.

    Args:
        simulation: the run.
        terms: what is correlated; default: xy, xz and yz with themselves.
        every: interval of the samples in steps.
        after: samples are taken in later steps than this.
        path: COR, written at each checkpoint and in the steps of ``dump``; None writes none.
        dump: interval of COR in steps, 0 for checkpoints alone.

    Raises:
        InputError: the checkpoint holds correlators of another shape.
    """

    name = "correlations"

    def __init__(
        self,
        simulation: Simulation,
        terms: Sequence[CorrelationTerm] = (),
        *,
        every: int = 1,
        after: int = 0,
        path: Path | None = None,
        dump: int = 0,
    ) -> None:
        """Start without samples, or with those of the checkpoint that the simulation comes from; see the class."""
        if every < 1:
            raise ValueError(f"samples are taken every 1 or more steps, not every {every}")
        self.terms = tuple(terms) or tuple(CorrelationTerm((a, b), (a, b)) for a, b in ((0, 1), (0, 2), (1, 2)))
        self._scene, self._every, self._after = simulation.scene, every, after
        self._path, self._dump = path, dump
        shapes = dict.fromkeys((term.points, term.blocks, term.window) for term in self.terms)
        self._groups = {shape: [t for t in self.terms if (t.points, t.blocks, t.window) == shape] for shape in shapes}
        self._correlators = {
            (points, blocks, window): MultipleTau(len(group), points=points, levels=blocks, window=window)
            for (points, blocks, window), group in self._groups.items()
        }
        self._sums = np.zeros(3)  # of volume, k_B T V as the kinetic tensor has it, number of samples
        self._restore(simulation.restored_state(self.name))

    def next_step(self, step: int) -> int | None:
        """Return the next multiple of the interval after equilibration."""
        return every(max(step, self._after), self._every)

    def report(self, simulation: Simulation) -> None:
        """Take a sample."""
        seen = simulation.observe()
        for shape, group in self._groups.items():
            left = [seen.stress[term.left] for term in group]
            right = [seen.stress[term.right] for term in group]
            self._correlators[shape].add(left, right)
        self._sums += (seen.volume, seen.temperature, 1.0)
        if self._dump and simulation.step % self._dump == 0:
            self.sync()

    @property
    def samples(self) -> int:
        """Number of samples so far."""
        return int(self._sums[2])

    def correlation(self, term: int = 0) -> tuple[FloatArray, FloatArray]:
        """Return the lag times (n,) in ps and ⟨σ_A(t) σ_B(t + τ)⟩ (n,) of a term, in the pressure unit squared."""
        correlator, column = self._place(self.terms[term])
        return np.asarray(correlator.lags() * self.spacing, dtype=np.float64), correlator.values()[:, column]

    def correlation_error(self, term: int = 0) -> FloatArray:
        """Return the standard errors (n,) of ``correlation``; not a number where there are too few blocks of time."""
        correlator, column = self._place(self.terms[term])
        return standard_errors(correlator.block_values()[:, :, column])

    @property
    def spacing(self) -> float:
        """Time between samples, ps."""
        return self._every * self._scene.dynamics.timestep

    def green_kubo(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return times (n,), the running integral (n,) that tends to the viscosity, and its standard error (n,).

        It is the mean of the shear components that are correlated with themselves, in the unit of pressure times time.
        See ``viscosity`` for when it is one.

        Raises:
            ValueError: no shear component is correlated with itself.
        """
        shears = [term for term in self.terms if term.is_shear]
        if not shears:
            raise ValueError("the viscosity needs a shear component that is correlated with itself")
        correlator, _ = self._place(shears[0])
        columns = [self._place(term)[1] for term in shears if self._place(term)[0] is correlator]
        times = np.asarray(correlator.lags() * self.spacing, dtype=np.float64)
        factor = self._factor()
        integral: FloatArray = factor * running_integral(times, correlator.values())[:, columns].mean(axis=1)
        blocks = factor * running_integral(times, correlator.block_values())[:, :, columns].mean(axis=2)
        errors = np.array([standard_error(series) for series in blocks.T], dtype=np.float64)
        return times, integral, errors

    def viscosity(self) -> Estimate | None:
        """Return the integral over all lags, pressure times time; None where it would be wrong or there is nothing.

        With noise of pairs every step must be sampled: at a longer interval the noise's own correlation would be
        integrated over that interval, and not over the step it belongs to. A Langevin thermostat takes momentum out of
        the fluid, so that there is no viscosity; in a sheared cell the mean stress says what it is.
        """
        if not any(term.is_shear for term in self.terms) or self.samples < 2:
            return None
        dynamics = self._scene.dynamics
        if dynamics.integrator == "langevin" or dynamics.shear_rate != 0.0:
            return None
        if self._every > 1 and has_pair_noise(self._scene):
            return None
        _, integral, errors = self.green_kubo()
        correlator, _ = self._place(next(term for term in self.terms if term.is_shear))
        return Estimate(float(integral[-1]), float(errors[-1]), self.samples, len(correlator.block_values()))

    def estimates(self) -> list[tuple[str, Estimate, str]]:
        """Return what the end of OUTPUT says: name, value and unit."""
        found = self.viscosity()
        units = self._scene.units
        return [] if found is None else [("viscosity", found, "" if units.reduced else f"{units.pressure_label} ps")]

    def sync(self) -> None:
        """Write COR. Raises RunError when it cannot be written."""
        if self._path is None or self.samples == 0:
            return
        found = []
        for k, term in enumerate(self.terms):
            lags, values = self.correlation(k)
            errors = self.correlation_error(k)
            known = errors if np.isfinite(errors).any() else None
            found.append(Correlation(term.name, term.points, term.blocks, term.window, lags, values, known))
        write_correlations(self._path, self._scene.title, found, self._derived())

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the correlators for the checkpoint."""
        arrays: dict[str, NDArray[Any]] = {"sums": self._sums.copy(), "terms": self._identity()}
        for number, correlator in enumerate(self._correlators.values()):
            arrays |= {f"{number}.{key}": value for key, value in correlator.state().items()}
        return arrays

    def _restore(self, stored: dict[str, NDArray[Any]]) -> None:
        if not stored:
            return
        try:
            if not np.array_equal(stored["terms"], self._identity()):
                raise ValueError("other components, shapes or intervals")
            for number, correlator in enumerate(self._correlators.values()):
                prefix = f"{number}."
                correlator.restore({k.removeprefix(prefix): v for k, v in stored.items() if k.startswith(prefix)})
            self._sums = np.array(stored["sums"])
        except (KeyError, ValueError) as error:
            told = "keep the correlation_ settings, or leave correlation_observable out"
            raise InputError(f"the checkpoint holds correlations that cannot go on ({error}); {told}") from error

    def _identity(self) -> NDArray[np.int64]:
        rows = [(*t.left, *t.right, t.points, t.blocks, t.window, self._every) for t in self.terms]
        return np.array(rows, dtype=np.int64)

    def _place(self, term: CorrelationTerm) -> tuple[MultipleTau, int]:
        shape = (term.points, term.blocks, term.window)
        return self._correlators[shape], self._groups[shape].index(term)

    def _factor(self) -> float:
        """V/(k_B T) per pressure factor, so that pressure² times time becomes pressure times time."""
        volume, temperature = self._sums[:2] / max(self._sums[2], 1.0)
        units = self._scene.units
        return float(volume / (units.boltzmann * temperature * units.pressure_factor)) if temperature > 0.0 else 0.0

    def _derived(self) -> list[Derived]:
        found = self.viscosity()
        if found is None:
            return []
        units = self._scene.units
        values = []
        for k, term in enumerate(self.terms):
            if term.is_shear:
                times, correlation = self.correlation(k)
                values.append(self._factor() * float(running_integral(times, correlation[:, None])[-1, 0]))
        density = float(np.sum(self._scene.beads.mass)) / (self._sums[0] / self._sums[2])
        unit = f"{units.pressure_label} ps" if not units.reduced else "reduced"
        by_density = f"{unit} / (amu / Ang^3)" if not units.reduced else "reduced"
        return [
            Derived("viscosity", found.value, values, unit, found.error),
            Derived("kinematic-viscosity", found.value / density, [v / density for v in values], by_density,
                    found.error / density),
        ]  # fmt: skip


def has_pair_noise(scene: Scene) -> bool:
    """Return whether drag and noise act between pairs, so that the stress has a part that is white noise."""
    return is_pairwise(scene.dynamics.integrator) and any(term.drag > 0.0 for term in scene.pairs)
