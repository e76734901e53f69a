"""Reporter of profiles and maps: averages in bins of the cell during a run, written as PROFILE and MAP."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from pydlpoly.binned import BinnedMeans, Sample
from pydlpoly.errors import InputError
from pydlpoly.formats.binned_table import BinnedTable, write_binned
from pydlpoly.reporters.schedule import every
from pydlpoly.scene.beads_state import DENSITY
from pydlpoly.scene.bins import LOCAL_DENSITY, quantities_of, unit_of
from pydlpoly.scene.model import Axis
from pydlpoly.simulation import Simulation


class BinReporter:
    """Averages in bins along one axis or over two; append it to ``Simulation.reporters``.

    Args:
        simulation: the run.
        axes: one or two of "x", "y", "z": the first, second and third cell vector.
        bins: number of bins along each. Where the cell varies they vary with it.
        quantities: names of ``pydlpoly.scene.bins``; by default all that the scene has.
        every: interval of the samples in steps.
        after: samples are taken in later steps than this.
        path: the file, written at each checkpoint; None writes none.

    Raises:
        InputError: a quantity that the scene does not have, or the checkpoint holds averages of other bins.
        ValueError: axes, bins or interval are none.
    """

    def __init__(
        self,
        simulation: Simulation,
        *,
        axes: Sequence[Axis] = ("z",),
        bins: Sequence[int] = (100,),
        quantities: Sequence[str] = (),
        every: int = 10,
        after: int = 0,
        path: Path | None = None,
    ) -> None:
        """Start without samples, or with those of the checkpoint that the simulation comes from; see the class."""
        if every < 1:
            raise ValueError("the interval must be 1 step or more")
        scene = simulation.scene
        self.name = "bead_profile" if len(axes) == 1 else "bead_map"
        self._scene, self._every, self._after, self._path = scene, every, after, path
        self._means = BinnedMeans(
            ["xyz".index(axis) for axis in axes],
            bins,
            quantities_of(scene, quantities),
            species=scene.species,
            boltzmann=scene.units.boltzmann,
            errors=len(axes) == 1,
        )
        self._mobile = None if not scene.beads.frozen.any() else ~scene.beads.frozen
        stored = simulation.restored_state(self.name)
        if stored:
            try:
                self._means.restore(stored)
            except (KeyError, ValueError) as error:
                kind = self.name.removeprefix("bead_")
                told = f"keep the keywords {kind}_…, or leave {kind}_frequency out"
                raise InputError(f"the checkpoint holds a {kind} that cannot go on: {error}; {told}") from error

    def next_step(self, step: int) -> int | None:
        """Return the next multiple of the interval after equilibration."""
        return every(max(step, self._after), self._every)

    def report(self, simulation: Simulation) -> None:
        """Take a sample."""
        scene, carried = self._scene, simulation.bead_arrays()
        if DENSITY in carried:
            carried[LOCAL_DENSITY] = carried.pop(DENSITY)
        sample = Sample(
            positions=simulation.positions,
            cell=simulation.cell,
            periodic=scene.periodic,
            masses=scene.beads.mass,
            velocities=simulation.velocities,
            species=scene.beads.species,
            mobile=self._mobile,
            values=carried,
        )
        self._means.add(sample)

    @property
    def samples(self) -> int:
        """Number of samples so far."""
        return self._means.samples

    def table(self) -> BinnedTable:
        """Return the averages so far, with errors where the bins are along one axis."""
        units = {name: unit_of(name, self._scene) for name in self._means.quantities}
        length = "" if self._scene.units.reduced else "ang"
        axes = {"xyz"[axis]: length for axis in self._means.axes}
        return self._means.table(self._scene.title, {**axes, **units})

    def sync(self) -> None:
        """Write the file, when anything has been sampled. Raises RunError when it cannot be written."""
        if self._path is not None and self.samples:
            write_binned(self._path, self.table())

    def close(self) -> None:
        """Nothing is open between writes."""

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the sums for the checkpoint."""
        return self._means.state()
