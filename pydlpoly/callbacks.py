"""Sources and reactions of the user's own: functions of arrays that are called every n steps of a run.

A callback is due in the steps that are multiples of its interval, counted from the scene's start, after the step and
before the reporters of the step. What it changes happens between two steps, as a source of the core does: the forces of
the step before stay. A run that continues from a checkpoint so has the bits of one that never stopped, once the same
callbacks are added again.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pydlpoly.errors import InputWarning, RunError, suggest
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.beads_state import CONCENTRATION, DENSITY, TEMPERATURE, carried_names, dissolved_species, why_not

if TYPE_CHECKING:
    from pydlpoly.simulation import Simulation

Changes = Mapping[str, ArrayLike] | None
CallbackFunction = Callable[["Moment"], Changes]
_ALL_CONCENTRATIONS = "concentrations"


class Moment:
    """What a callback is shown of the present step. Arrays are copies, made when they are asked for.

    Attributes:
        step: steps taken since the scene's start; time: ps; timestep: ps.
        interval: time between two calls of this callback, ps.
        species_names: names of the species, in the order of the numbers in ``species``.
    """

    def __init__(self, simulation: Simulation, every: int) -> None:
        """Show a simulation's present step to a callback that is called every so many steps."""
        self._simulation = simulation
        self.step, self.time = simulation.step, simulation.time
        self.timestep = simulation.scene.dynamics.timestep
        self.interval = every * self.timestep
        self.species_names = simulation.scene.species

    @cached_property
    def positions(self) -> FloatArray:
        """(N, 3) wrapped into the cell, Å."""
        return self._simulation.positions

    @cached_property
    def velocities(self) -> FloatArray:
        """(N, 3), Å/ps."""
        return self._simulation.velocities

    @cached_property
    def cell(self) -> FloatArray:
        """(3, 3) cell vectors by row, Å."""
        return self._simulation.cell

    @property
    def species(self) -> NDArray[np.int32]:
        """(N,) numbers of the species."""
        return self._simulation.scene.beads.species

    @property
    def masses(self) -> FloatArray:
        """(N,), Da."""
        return self._simulation.scene.beads.mass

    @cached_property
    def arrays(self) -> dict[str, FloatArray]:
        """What the beads carry, (N,) each, as ``Simulation.bead_arrays()``."""
        return self._simulation.bead_arrays()

    @property
    def temperature(self) -> FloatArray | None:
        """(N,) internal temperatures, K (reduced with ``units dpd``); None where beads carry no heat."""
        return self.arrays.get(TEMPERATURE)

    @cached_property
    def concentrations(self) -> FloatArray | None:
        """(N, species) of the dissolved species; None where there are none."""
        names = dissolved_species(self._simulation.scene)
        return np.column_stack([self.arrays[CONCENTRATION + name] for name in names]) if names else None

    @property
    def density(self) -> FloatArray | None:
        """(N,) local densities at the last evaluation of the forces; None where no pair law depends on them."""
        return self.arrays.get(DENSITY)

    def __getitem__(self, name: str) -> FloatArray:
        """Return what beads carry: a name of ``arrays``, or "concentrations". Raises KeyError when there is none."""
        if name == _ALL_CONCENTRATIONS and self.concentrations is not None:
            return self.concentrations
        if name not in self.arrays:
            raise KeyError(f"{name}: expected {', '.join(self.arrays) or 'nothing, beads carry nothing'}")
        return self.arrays[name]


class Source:
    """A callback made of a function that returns rates: what beads carry changes by rate times interval.

    Explicit Euler over the interval between two calls, so the interval must be short for what the rates change.

    Args:
        rates: takes a ``Moment`` and returns rates per ps by name, (N,) each or one number for all beads, or None.
    """

    def __init__(self, rates: CallbackFunction) -> None:
        self._rates = rates
        self.__name__ = _name_of(rates)

    def __call__(self, moment: Moment) -> Changes:
        """Return the new values."""
        rates = self._rates(moment)
        if rates is None:
            return None
        changes = {name: moment.interval * np.asarray(rate, dtype=np.float64) for name, rate in rates.items()}
        return {name: moment[name] + change for name, change in changes.items()}


class Callback:
    """A function that is called every n steps.

    Args:
        function: takes a ``Moment``; returns None, or new values by name: "temperature" (N,), "concentration_<name>"
            (N,), or "concentrations" (N, species). One number counts for all beads.
        every: interval in steps.

    Raises:
        ValueError: the interval is not a positive whole number, or the function cannot be called.
    """

    def __init__(self, function: CallbackFunction, every: int) -> None:
        """Take the function; see the class."""
        if not callable(function):
            raise ValueError(f"expected a function, not {function!r}")
        if isinstance(every, bool) or not isinstance(every, (int, np.integer)) or every < 1:
            raise ValueError(f"the interval of a callback must be 1 step or more, not {every!r}")
        self.function, self.every, self.name = function, int(every), _name_of(function)

    def next_step(self, step: int) -> int:
        """Return the first step after ``step`` at which it is due."""
        return (step // self.every + 1) * self.every

    def values(self, simulation: Simulation) -> dict[str, FloatArray]:
        """Call the function at the present step and return the new values, checked; (N,) each, by name.

        Raises:
            RunError: the function failed or returned what cannot be taken; the text names it and the step.
        """
        try:
            given = self.function(Moment(simulation, self.every))
        except Exception as error:
            raise RunError(f"{self._place(simulation)}: {type(error).__name__}: {error}") from error
        if given is None:
            return {}
        if not isinstance(given, Mapping):
            raise RunError(f"{self._place(simulation)}: expected None or new values by name, not {type(given)}")
        return self._checked(simulation, given)

    def _place(self, simulation: Simulation) -> str:
        return f"callback {self.name} at step {simulation.step}"

    def _checked(self, simulation: Simulation, given: Mapping[str, Any]) -> dict[str, FloatArray]:
        scene, place = simulation.scene, self._place(simulation)
        known, count = carried_names(scene), scene.bead_count
        found: dict[str, FloatArray] = {}
        for name, array in given.items():
            species = dissolved_species(scene) if name == _ALL_CONCENTRATIONS else ()
            if name not in known and not species:
                told = f"expected {', '.join(known)}" if known else "beads carry nothing that could be changed"
                raise RunError(f"{place}: {name!r} is not carried by beads; {told}{suggest(str(name), known)}")
            try:
                values = np.asarray(array, dtype=np.float64)
                shape = (count, len(species)) if species else (count,)
                full = np.broadcast_to(values, shape) if values.ndim == 0 else values
            except (TypeError, ValueError) as error:
                raise RunError(f"{place}: {name} is no array of numbers ({error})") from error
            if full.shape != shape:
                raise RunError(f"{place}: {name} must be of shape {shape}, not {full.shape}")
            columns = {CONCENTRATION + one: full[:, k] for k, one in enumerate(species)} if species else {name: full}
            for key, column in columns.items():
                wrong = why_not(key, column)
                if wrong is not None:
                    bead, told = wrong
                    raise RunError(f"{place}: {key} of bead {bead + 1} is {column[bead]:g}; {told}")
                if key in found:
                    raise RunError(f"{place}: {key} is given twice")
                found[key] = column
        return found


class Callbacks:
    """The callbacks of a simulation, in the order in which they were added."""

    def __init__(self) -> None:
        self._all: list[Callback] = []
        self._missed: set[tuple[str, int]] = set()

    def add(self, function: CallbackFunction, every: int) -> None:
        """Add a function that is called every so many steps; see ``Callback``."""
        callback = Callback(function, every)
        self._all.append(callback)
        self._missed.discard((callback.name, callback.every))

    def next_steps(self, step: int) -> list[int]:
        """Return the first step after ``step`` at which each is due."""
        return [callback.next_step(step) for callback in self._all]

    def due(self, step: int) -> list[Callback]:
        """Return those that are due at this step."""
        return [callback for callback in self._all if step % callback.every == 0]

    def identities(self) -> list[list[str | int]]:
        """Return names and intervals, for the checkpoint."""
        return [[callback.name, callback.every] for callback in self._all]

    def expect(self, identities: Iterable[Sequence[Any]]) -> None:
        """Expect those of a checkpoint to be added again."""
        self._missed = {(str(name), int(every)) for name, every in identities}

    def warn_of_missed(self) -> None:
        """Warn the caller's caller, once, of expected ones that were not added."""
        if self._missed:
            told = ", ".join(f"{name} every {every} steps" for name, every in sorted(self._missed))
            text = f"the checkpoint is of a run with callbacks that were not added again: {told}"
            warnings.warn(InputWarning(text), stacklevel=3)
            self._missed = set()


def _name_of(function: object) -> str:
    return str(getattr(function, "__name__", type(function).__name__))
