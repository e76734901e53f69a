"""What checks and figures need to know of a run beside its series: averages by name, scales, numbers with errors."""

from __future__ import annotations

import math
import shlex

import numpy as np

from pydlpoly.formats.blocks import three_of
from pydlpoly.report.collect import Run
from pydlpoly.report.series import LEAST_SAMPLES, Average, Series, all_series


class Evidence:
    """A run with its quantities and averages, computed once for all checks."""

    def __init__(self, run: Run) -> None:
        self.run, self.units = run, run.units
        self.series: dict[str, Series] = all_series(run)

    def average(self, name: str) -> Average | None:
        """Return the average of a quantity; None when there is none, or no sample counts yet."""
        if name not in self.series:
            return None
        average = self.series[name].average()
        return average if average.samples else None

    def configurational(self) -> Average | None:
        """Return the configurational temperature: of DIAGNOSTICS, or else the one at the end of OUTPUT."""
        return self.average("configurational_temperature") or self._of_output("configurational")

    def kinetic(self) -> Average | None:
        """Return the kinetic temperature: of STATIS, DIAGNOSTICS or the end of OUTPUT."""
        found = self.average("temperature") or self.average("kinetic_temperature")
        return found or self._of_output("kinetic")

    def _of_output(self, name: str) -> Average | None:
        log = self.run.log
        if log is None or name not in log.temperatures:
            return None
        value, error = log.temperatures[name]
        return Average(value, error, LEAST_SAMPLES, three_of(LEAST_SAMPLES - 1) * error)  # from 8 blocks or more

    @property
    def folder(self) -> str:
        """The folder's name for a command line."""
        return shlex.quote(str(self.run.folder))

    def number(self, value: float, kind: str) -> str:
        """Return a value with its unit."""
        return f"{value:.5g} {self.units.of(kind)}".rstrip()


def with_error(average: Average) -> str:
    """Return a mean with its error, as many digits as that allows."""
    if not math.isfinite(average.value):
        return "not known"
    if not average.known:
        return f"{average.value:.5g}"
    if average.error == 0.0:
        return f"{average.value:.6g} ± 0"
    digits = 1 - math.floor(math.log10(average.error))
    if -6 <= digits < 0:
        return f"{round(average.value, digits):.0f} ± {round(average.error, digits):.0f}"
    if 0 <= digits <= 8:
        return f"{average.value:.{digits}f} ± {average.error:.{digits}f}"
    return f"{average.value:.6g} ± {average.error:.2g}"


def independent_samples(series: Series) -> float:
    """Return how many independent samples those that count are worth: their variance over the mean's squared error."""
    average = series.average()
    if not average.samples:
        return 0.0
    variance = float(np.nanvar(series.values[series.counted]))
    return min(float(average.samples), variance / average.error**2) if average.error > 0.0 else float(average.samples)


def thermal_momentum(run: Run) -> float:
    """Return √(3 M k_B T) in Da Å/ps, M being the mass of all mobile beads; 0 without a scene."""
    scene = run.scene
    if scene is None:
        return 0.0
    mass = float(scene.beads.mass[~scene.beads.frozen].sum())
    return math.sqrt(3.0 * mass * scene.dynamics.thermal_energy)


def momentum_goes_to(run: Run) -> str | None:
    """Return what takes up momentum in this scene, in words; None when it is conserved."""
    scene = run.scene
    if scene is None:
        return None
    if scene.external:
        return "an external field acts"
    if scene.walls is not None:
        return "there are walls"
    if scene.dynamics.shear_rate != 0.0:
        return "beads that leave the sheared cell come back with another velocity"
    if bool(scene.beads.frozen.any()):
        return "there are frozen beads"
    if scene.dynamics.integrator == "langevin":
        return "a Langevin thermostat acts on each bead"
    if scene.bonded is not None and scene.bonded.anchors is not None:
        return "beads are tethered"
    return None


def largest_fluctuation(run: Run) -> float:
    """Return four standard deviations of a single kinetic temperature, T √(2/g); infinite where g is not known."""
    scene, target = run.scene, run.target_temperature
    if scene is None or target is None or scene.degrees_of_freedom <= 0:
        return math.inf
    return 4.0 * target * math.sqrt(2.0 / scene.degrees_of_freedom)


def kinetic_pressure(evidence: Evidence) -> float:
    """Return ρ k_B T in the unit of pressure: the scale of a pressure that happens to be near 0."""
    scene = evidence.run.scene
    if scene is None:
        return 0.0
    volume = abs(float(np.linalg.det(scene.cell)))
    return scene.bead_count * scene.dynamics.thermal_energy / volume * scene.units.pressure_factor if volume else 0.0
