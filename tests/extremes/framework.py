"""What a case is: a scene at a limit, run once, with the number that shows whether the answer is right.

A case returns what it saw. Tests (test_extremes.py) require that it holds; docs/extremes.py writes it into a table.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from pydlpoly import Scene, Simulation
from pydlpoly.errors import PydlpolyError, RunError
from pydlpoly.formats.records import FloatArray

SEED = 20240607
PATHS = ("fast, double", "fast, mixed", "general", "reference")
# What the total momentum may be of the sum of all sizes: on the fast path each start velocity is rounded once, to a
# fraction of the range of momenta, and from then on the total never changes.
MOMENTUM = {"fast, double": 1e-13, "fast, mixed": 1e-6, "general": 1e-12, "reference": 1e-12}
PRECISIONS = ("double", "mixed", "reference")


@dataclass(frozen=True)
class Seen:
    """What a case saw.

    Attributes:
        quantity: what ``value`` is, with its unit where it has one.
        value: the number measured; ``expected`` and ``error``: what it should be, and how far off it may be.
        happens: "right", or how the scene was refused or the run stopped, in the words of the program.
    """

    quantity: str
    value: float
    expected: float
    error: float
    happens: str = "right"

    @property
    def holds(self) -> bool:
        """Whether the number is what it should be."""
        return abs(self.value - self.expected) <= self.error

    def text(self) -> str:
        """Return the measured number and the expected one."""
        if self.expected == 0.0:
            return f"{self.quantity} {self.value:.2g}, at most {self.error:.2g}"
        allowed = f" ± {self.error:.2g}" if self.error else ""
        return f"{self.quantity} {self.value:.7g}, expected {self.expected:.7g}{allowed}"


@dataclass(frozen=True)
class Case:
    """A case: ``run`` makes it and returns what it saw."""

    topic: str
    name: str
    run: Callable[[], Seen]
    slow: bool = False


class Cases(list[Case]):
    """The cases of one topic."""

    def __init__(self, topic: str) -> None:
        super().__init__()
        self.topic = topic

    def add(self, name: str, run: Callable[[], Seen], *, slow: bool = False) -> None:
        """Add a case."""
        self.append(Case(self.topic, name, run, slow))


def plan(simulation: Simulation) -> str:
    """Return "fast: ..." or "general: ..."."""
    return simulation._engine.system.plan()


def on_path(scene: Scene, path: str, *, threads: int = 1, seed: int = SEED) -> Simulation:
    """Return the simulation on one of PATHS; an exponent that is 2 but for one bit asks for the general path."""
    precision = {"fast, mixed": "mixed", "reference": "reference"}.get(path, "double")
    dynamics = replace(scene.dynamics, precision=precision)
    if path == "general":
        dynamics = replace(dynamics, weight_exponent=math.nextafter(2.0, 3.0))
    simulation = Simulation(replace(scene, dynamics=dynamics), seed=seed, threads=threads)
    assert plan(simulation).startswith("fast" if path.startswith("fast") else "general"), plan(simulation)
    return simulation


def check_finite(simulation: Simulation) -> None:
    """Nothing that can be asked of a simulation is other than a finite number."""
    state = simulation.state
    for name in ("positions", "velocities", "forces"):
        assert np.isfinite(getattr(state, name)).all(), f"{name} are not finite"
    seen = simulation.observe()
    for name, value in seen.energy.items():
        assert np.isfinite(value), f"the energy {name} is not finite"
    assert np.isfinite(seen.stress).all(), "the stress is not finite"
    assert np.isfinite(seen.temperature), "the temperature is not finite"


def plain(message: str) -> str:
    """Return a message without the folder of the input files."""
    return re.sub(r"\S*/(?=\w+:\d)", "", re.sub(r"\S*/(?=(CONTROL|FIELD|CONFIG)\b)", "", message))


def require(holds: object, message: str) -> None:
    """Raise AssertionError unless the condition holds."""
    if not holds:
        raise AssertionError(message)


def refused(action: Callable[[], object], words: str) -> Seen:
    """Return that the action was refused before any step, with a message in which ``words`` (a pattern) are found."""
    try:
        action()
    except (PydlpolyError, ValueError) as error:
        require(not isinstance(error, RunError), str(error))
        message = plain(str(error))
        found = re.search(words, message) is not None
        return Seen("message names the cause:", float(found), 1.0, 0.0, f"refused: {message}")
    return Seen("refused:", 0.0, 1.0, 0.0, "accepted")


def stopped(action: Callable[[], Simulation], steps: int, words: str, *, latest: int) -> Seen:
    """Return in which step the run stopped, with a message in which ``words`` are found.

    It must have stopped by the step ``latest``, and the state must hold numbers.
    """
    simulation: Simulation | None = None
    try:
        simulation = action()
        simulation.run(steps)
    except RunError as error:
        require(re.search(words, str(error)) is not None, str(error))
        if simulation is not None:
            state = simulation.state
            for name in ("positions", "velocities", "forces"):
                require(np.isfinite(getattr(state, name)).all(), f"{name} are not finite after {error}")
        step = int(re.search(r"step (\d+)", str(error))[1])  # type: ignore[index]
        return Seen("stopped in step", step, 0.5 * latest, 0.5 * latest, f"stopped: {plain(str(error))}")
    happens = f"ran {steps} steps, temperature {simulation.temperature:.4g}"
    return Seen("stopped:", 0.0, 1.0, 0.0, happens)


def momentum(simulation: Simulation) -> float:
    """Return the largest component of the total momentum over the sum of the sizes of all momenta."""
    each = simulation.state.velocities * simulation.scene.beads.mass[:, None]
    return float(np.abs(each.sum(axis=0)).max() / max(np.abs(each).sum(), 1e-300))


def images(cell: FloatArray, reach: float) -> FloatArray:
    """(n, 3) shifts of all images of the cell that a pair in the cell could be within reach of."""
    widths = 1.0 / np.linalg.norm(np.linalg.inv(cell), axis=0)
    most = [ceil(reach / width) + 1 for width in widths]
    counts = [np.arange(-n, n + 1) for n in most]
    return np.asarray(np.stack(np.meshgrid(*counts, indexing="ij"), axis=-1).reshape(-1, 3) @ cell)


def soft_forces(
    places: FloatArray, cell: FloatArray, strength: FloatArray, cutoff: FloatArray
) -> tuple[float, FloatArray]:
    """Energy and forces of DPD's repulsion by brute force over all images; (N, N) strengths and cutoffs."""
    count = len(places)
    energy, forces = 0.0, np.zeros((count, 3))
    itself = np.eye(count, dtype=bool)
    edges = np.diag(cell)
    nearest_only = np.array_equal(cell, np.diag(edges)) and edges.min() >= 2.0 * cutoff.max()
    for shift in np.zeros((1, 3)) if nearest_only else images(cell, float(cutoff.max())):
        apart = places[:, None, :] - places[None, :, :] - shift
        if nearest_only:
            apart -= edges * np.round(apart / edges)
        r = np.linalg.norm(apart, axis=-1)
        near = np.clip(1.0 - r / cutoff, 0.0, None)
        if not shift.any():
            near[itself] = 0.0
        energy += 0.25 * float(np.sum(strength * cutoff * near**2))
        r[r == 0.0] = np.inf
        forces += ((strength * near / r)[..., None] * apart).sum(axis=1)
    return energy, forces
