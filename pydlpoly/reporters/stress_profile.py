"""The stress in layers of the cell during a run, and the surface tension that follows from it.

The tensor of each layer has the momenta of its beads, and of pairs and bonded terms the share of the line between their
beads that lies in the layer (cpp/observe/stress_profile.hpp). Drag and noise are left out: their mean is zero at rest.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import InputError, SceneError
from pydlpoly.formats.blocks import BlockSums, Estimate, standard_error
from pydlpoly.formats.records import FloatArray
from pydlpoly.formats.strprf import ProfileTable, write_profile
from pydlpoly.reporters.schedule import every
from pydlpoly.scene.model import Axis
from pydlpoly.scene.stress import why_no_layers, why_not_in_layers
from pydlpoly.simulation import Simulation

PARTS = ("kinetic", "conservative", "bonded")
_PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # of the six numbers of a tensor
_PARTS = len(PARTS) * len(_PLACES)


class StressProfile:
    """A reporter that samples the stress in layers; append it to ``Simulation.reporters``.

    Args:
        simulation: the run.
        axis: the layers are perpendicular to it; the cell must be periodic along it, with a vector along it that is
            perpendicular to the other two.
        layers: number of layers. Where the cell changes they change with it.
        every: interval of the samples in steps.
        after: samples are taken in later steps than this.
        interfaces: by how many the surface tension is divided; two for a slab in a periodic cell.
        path: STRPRF, written at each checkpoint; None writes none.

    Raises:
        SceneError: the cell does not allow it.
        InputError: the checkpoint holds a profile of another shape.
    """

    name = "stress_profile"

    def __init__(
        self,
        simulation: Simulation,
        *,
        axis: Axis = "z",
        layers: int = 50,
        every: int = 10,
        after: int = 0,
        interfaces: int = 2,
        path: Path | None = None,
    ) -> None:
        """Start without samples, or with those of the checkpoint that the simulation comes from; see the class."""
        if layers < 1 or every < 1 or interfaces < 1:
            raise ValueError("layers, every and interfaces must be 1 or more")
        scene = simulation.scene
        message = why_no_layers(scene.cell, scene.periodic, axis) or why_not_in_layers(scene)
        if message:
            raise SceneError(message)
        self.axis, self.layers = "xyz".index(axis), layers
        self._every, self._after, self._interfaces, self._path = every, after, interfaces, path
        self._scene = simulation.scene
        self._species = len(self._scene.species)
        # By layer: the tensors by part and the densities; then the tension of the whole stress, and the cell's height.
        self._blocks = BlockSums(layers * (_PARTS + self._species) + 2)
        stored = simulation.restored_state(self.name)
        if stored:
            self._restore(stored)

    def next_step(self, step: int) -> int | None:
        """Return the next multiple of the interval after equilibration."""
        return every(max(step, self._after), self._every)

    def report(self, simulation: Simulation) -> None:
        """Take a sample."""
        kinetic, conservative, bonded, beads = simulation.layer_sums(self.axis, self.layers)
        seen = simulation.observe()
        per_layer = self.layers / seen.volume
        tensors = np.stack([kinetic, conservative, bonded], axis=1) * (self._scene.units.pressure_factor * per_layer)
        height = float(simulation.cell[self.axis, self.axis])
        diagonal = np.diag(seen.stress)
        normal = float(diagonal[self.axis])
        tension = height * (1.5 * normal - 0.5 * float(diagonal.sum()))
        layers = np.concatenate([tensors.reshape(self.layers, _PARTS), beads * per_layer], axis=1)
        self._blocks.add(np.concatenate([layers.ravel(), [tension, height]]))

    @property
    def samples(self) -> int:
        """Number of samples so far."""
        return self._blocks.taken

    def heights(self) -> FloatArray:
        """Return the middles of the layers, (layers,) in Å from the middle of the cell."""
        height = float(self._blocks.mean()[-1])
        middles = (np.arange(self.layers, dtype=np.float64) + 0.5) * np.float64(height / self.layers)
        return np.asarray(middles - 0.5 * height, dtype=np.float64)

    def stress(self, part: str | None = None) -> FloatArray:
        """Return the pressure tensor of each layer, (layers, 3, 3) in the pressure unit, of one part or of all.

        Args:
            part: "kinetic", "conservative" (pairs) or "bonded". Off the diagonal both places have the mean of both.
        """
        return np.asarray(self._tensors(self._by_layer(self._blocks.mean()[None]), part)[0], dtype=np.float64)

    def stress_errors(self, part: str | None = None) -> FloatArray:
        """Return standard errors of ``stress``, not a number with fewer than 4 samples."""
        blocks = self._tensors(self._by_layer(self._blocks.means()), part)
        flat = blocks.reshape(len(blocks), -1)
        errors: FloatArray = np.array([standard_error(series) for series in flat.T]).reshape(self.layers, 3, 3)
        return errors

    def densities(self) -> FloatArray:
        """Return the number of beads per volume, (layers, species) in 1/Å³."""
        densities: FloatArray = self._by_layer(self._blocks.mean()[None])[0, :, _PARTS:]
        return densities

    def normal_and_lateral(self) -> tuple[FloatArray, FloatArray]:
        """Return p_N and p_T, (layers,) each: the stress along the axis, and the mean of the other two."""
        diagonal = np.diagonal(self.stress(), axis1=1, axis2=2)
        normal: FloatArray = diagonal[:, self.axis]
        lateral: FloatArray = 0.5 * (diagonal.sum(axis=1) - normal)
        return normal, lateral

    def surface_tension(self) -> Estimate:
        """Return ∫(p_N − p_T) dz over the cell for each interface: dyn/cm, or reduced."""
        tensors = self._tensors(self._by_layer(self._blocks.means()), None)
        series = self._tension_of(tensors, self._blocks.means()[:, -1])
        mean = self._tension_of(self.stress()[None], self._blocks.mean()[None, -1])
        return Estimate(float(mean[0]), standard_error(series), self.samples, len(series))

    def surface_tension_of_the_cell(self) -> Estimate:
        """Return L (P_N − P_T) of the whole pressure tensor, drag and noise included, for each interface."""
        factor = self._tension_factor()
        series = self._blocks.means()[:, -2] * factor
        return Estimate(float(self._blocks.mean()[-2] * factor), standard_error(series), self.samples, len(series))

    def estimates(self) -> list[tuple[str, Estimate, str]]:
        """Return what the end of OUTPUT says: name, value and unit."""
        unit = "" if self._scene.units.reduced else "dyn/cm"
        if self.samples == 0:
            return []
        return [
            ("tension, layers", self.surface_tension(), unit),
            ("tension, cell", self.surface_tension_of_the_cell(), unit),
        ]

    def sync(self) -> None:
        """Write STRPRF. Raises RunError when it cannot be written."""
        if self._path is None or self.samples == 0:
            return
        errors = self.stress_errors()
        normal, lateral = self.normal_and_lateral()
        diagonal = np.diagonal(errors, axis1=1, axis2=2)
        rest = [axis for axis in range(3) if axis != self.axis]
        write_profile(
            self._path,
            ProfileTable(
                title=self._scene.title,
                axis="xyz"[self.axis],
                samples=self.samples,
                pressure_unit=self._scene.units.pressure_label or "reduced",
                length_unit="reduced" if self._scene.units.reduced else "ang",
                tension_unit="reduced" if self._scene.units.reduced else "dyn/cm",
                tension=self.surface_tension(),
                cell_tension=self.surface_tension_of_the_cell(),
                heights=self.heights(),
                normal=normal,
                lateral=lateral,
                normal_error=diagonal[:, self.axis],
                lateral_error=0.5 * np.hypot(diagonal[:, rest[0]], diagonal[:, rest[1]]),
                parts={part: self._six(self.stress(part)) for part in PARTS},
                densities=dict(zip(self._scene.species, self.densities().T, strict=True)),
            ),
        )

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the sums for the checkpoint."""
        return {**self._blocks.state(), "shape": self._shape()}

    def _restore(self, stored: dict[str, NDArray[Any]]) -> None:
        try:
            if not np.array_equal(stored["shape"], self._shape()):
                raise ValueError("it has another axis, or other layers or species")
            self._blocks.restore(stored)
        except (KeyError, ValueError) as error:
            told = "keep stress_profile_axis and _binsize, or leave stress_profile_frequency out"
            raise InputError(f"the checkpoint holds a stress profile that cannot go on: {error}; {told}") from error

    def _shape(self) -> NDArray[np.int64]:
        return np.array([self.axis, self.layers, self._species], dtype=np.int64)

    def _by_layer(self, rows: FloatArray) -> FloatArray:
        return rows[:, :-2].reshape(len(rows), self.layers, _PARTS + self._species)

    def _tensors(self, layers: FloatArray, part: str | None) -> FloatArray:
        """(samples, layers, 3, 3) of one part or of all, from rows by layer."""
        six = layers[..., :_PARTS].reshape(*layers.shape[:2], len(PARTS), len(_PLACES))
        chosen = six.sum(axis=2) if part is None else six[:, :, PARTS.index(part)]
        tensors = np.zeros((*chosen.shape[:2], 3, 3))
        for k, (a, b) in enumerate(_PLACES):
            tensors[..., a, b] = tensors[..., b, a] = chosen[..., k]
        return tensors

    @staticmethod
    def _six(tensors: FloatArray) -> FloatArray:
        return np.stack([tensors[:, a, b] for a, b in _PLACES], axis=1)

    def _tension_of(self, tensors: FloatArray, heights: FloatArray) -> FloatArray:
        """Of (samples, layers, 3, 3) and the cell's heights (samples,)."""
        diagonal = np.diagonal(tensors, axis1=2, axis2=3)
        difference = 1.5 * diagonal[..., self.axis] - 0.5 * diagonal.sum(axis=-1)
        tension: FloatArray = difference.mean(axis=1) * heights * self._tension_factor()
        return tension

    def _tension_factor(self) -> float:
        units = self._scene.units
        return units.tension_factor / (units.pressure_factor * self._interfaces)
