"""The engine lammps: a scene in LAMMPS, on one rank or many, behind the same simulation, reporters and files.

The process in front keeps a copy of all beads as they were last asked for. What LAMMPS does not compute as this package
does (pair distances, layers of stress, the configurational temperature) is computed there by the native core.
"""

from __future__ import annotations

import weakref
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.engines.lammps_team import JobTeam, ProcessTeam, Team, enter_job, switches_of
from pydlpoly.engines.lammps_translate import Translation, noise_seed, translate
from pydlpoly.engines.native import NativeEngine
from pydlpoly.engines.native_scene import long_range_tail
from pydlpoly.engines.protocol import EngineOptions
from pydlpoly.engines.totals import Totals
from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Scene

DRAG_NOTE = (
    "engine lammps: LAMMPS knows the virial of drag and noise together; both stand under drag, and noise is zero"
)


class LammpsState:
    """The state of the beads in LAMMPS, fetched when it is looked at; see ``Engine`` for the attributes.

    Args:
        engine: the engine.
        native: the same scene in the compiled core, whose pair distances it lends.
    """

    def __init__(self, engine: LammpsEngine, native: Any) -> None:
        self._engine, self._native = engine, native
        self.step: int = 0
        self.time: float = 0.0
        self.cell: FloatArray = np.ascontiguousarray(native.cell)
        self.thermostat: list[float] = list(native.thermostat)
        self.distances_every = self.distances_after = 0
        self._arrays: dict[str, NDArray[Any]] = {
            "positions": np.asarray(native.positions),
            "velocities": np.asarray(native.velocities),
            "forces": np.asarray(native.forces),
            "images": np.asarray(native.images, dtype=np.int64),
        }
        self._clock = (0, 0.0)  # step and time of the arrays
        self.fresh = True

    def __getattr__(self, name: str) -> Any:
        """What beads in LAMMPS never carry, because such scenes are refused, is as empty as in the native core."""
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._native, name)

    @property
    def positions(self) -> FloatArray:
        """(N, 3) a copy of the positions, wrapped into the cell."""
        return self._fetched("positions")

    @positions.setter
    def positions(self, value: FloatArray) -> None:
        self._set("positions", value)

    @property
    def velocities(self) -> FloatArray:
        """(N, 3) a copy of the velocities."""
        return self._fetched("velocities")

    @velocities.setter
    def velocities(self, value: FloatArray) -> None:
        self._set("velocities", value)

    @property
    def forces(self) -> FloatArray:
        """(N, 3) a copy of the total forces."""
        return self._fetched("forces")

    @forces.setter
    def forces(self, value: FloatArray) -> None:
        self._set("forces", value)

    @property
    def images(self) -> NDArray[np.int32]:
        """(N, 3) cells crossed since the start."""
        return self._fetched("images").astype(np.int32)

    @images.setter
    def images(self, value: NDArray[np.int32]) -> None:
        self._set("images", np.asarray(value, dtype=np.int64))

    @property
    def volume(self) -> float:
        """Of the cell."""
        return abs(float(np.linalg.det(self.cell)))

    def wrap(self) -> None:
        """Bring positions back into the cell, counting the cells they cross."""
        positions = self._fetched("positions")
        shifts = np.floor(positions @ np.linalg.inv(self.cell) + 0.5)
        self._arrays["positions"] = positions - shifts @ self.cell
        self._arrays["images"] = self._arrays["images"] + shifts.astype(np.int64)

    def store(self, beads: dict[str, NDArray[Any]]) -> None:
        """Take what LAMMPS says of the present step."""
        self._arrays, self.fresh, self._clock = beads, True, (self.step, self.time)
        self.wrap()

    def advance(self, steps: int, timestep: float) -> None:
        """Count steps that LAMMPS has taken."""
        self.step += steps
        self.time += steps * timestep
        self.fresh = False

    def fall_back(self) -> None:
        """Go back to the last step whose beads are here; LAMMPS is gone."""
        self.step, self.time = self._clock
        self.fresh = True

    # Pair distances

    def enable_distances(self, reach: float, bins: int, every: int, after: int = 0) -> None:
        """Sample pair distances in steps divisible by ``every`` and later than ``after``."""
        self._native.enable_distances(reach, bins, every, after)
        self.distances_every, self.distances_after = every, after

    def until_sample(self) -> int:
        """Return how many steps there are to the next sample; a large number without samples."""
        if self.distances_every <= 0:
            return 2**31
        return self.distances_every - self.step % self.distances_every

    def sample_if_due(self) -> None:
        """Count the distances of this step if it is to be sampled."""
        every = self.distances_every
        if every > 0 and self.step > self.distances_after and self.step % every == 0:
            self._native.positions = self.positions
            self._native.sample_distances()

    def distance_counts(self) -> NDArray[np.int64]:
        """As the core's."""
        return np.asarray(self._native.distance_counts())

    def restore_distances(self, counts: list[int], samples: int, volumes: float) -> None:
        """As the core's."""
        self._native.restore_distances(counts, samples, volumes)

    @property
    def distance_samples(self) -> int:
        """Number of samples."""
        return int(self._native.distance_samples)

    @property
    def distance_volumes(self) -> float:
        """Sum of the cell's volumes over the samples."""
        return float(self._native.distance_volumes)

    def _fetched(self, name: str) -> NDArray[Any]:
        if not self.fresh:
            self.store(self._engine.fetch())
        return self._arrays[name].copy()

    def _set(self, name: str, value: NDArray[Any]) -> None:
        self._fetched(name)  # the others stay as they are now
        self._arrays[name] = np.array(value, dtype=np.int64 if name == "images" else np.float64)


class LammpsEngine:
    """One simulation in LAMMPS.

    Args:
        scene: what to model.
        seed: seed of start velocities and, mixed with the step, of LAMMPS's noise.
        threads: of the native core in this process.
        options: number of ranks and accelerator switches. Inside an MPI job its ranks are used; on all but the first
            the process serves the first one here, and ends.

    Raises:
        SceneError: the scene is not translated; the text names the file and the line.
        InputError: LAMMPS, mpiexec or mpi4py is missing, or the options contradict the job.
    """

    def __init__(self, scene: Scene, *, seed: int, threads: int, options: EngineOptions) -> None:
        switches = switches_of(options.accelerator)
        self._job = job = enter_job(switches)
        ranks = _ranks(options, job)
        translate(scene, 1)  # refuses before anything is started
        self._scene, self._seed = scene, seed
        self._tail = long_range_tail(scene)
        self._native = NativeEngine(scene, seed=seed, threads=threads)
        self.system = LammpsState(self, self._native.system)
        self._seen: dict[str, FloatArray | float] = {}
        self._raw_images: NDArray[np.int64] | None = None
        self._range = 0  # of LAMMPS's counts of cells
        self._team: Team = JobTeam.front(switches) if job is not None else ProcessTeam(ranks, switches)
        if job is None:
            weakref.finalize(self, self._team.close)

    def __getattr__(self, name: str) -> Any:
        """What scenes that LAMMPS runs have nothing of is as in the native engine: absent, or refused there."""
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._native, name)

    def start(self, scene: Scene) -> None:
        """Give the beads the velocities that the scene's start asks for, and compute the first forces."""
        self._native.prepare(scene)
        self.system.velocities = np.asarray(self._native.system.velocities)
        self.initialise()

    def meet_constraints(self) -> None:
        """Nothing: scenes with constraints are refused."""

    def initialise(self) -> None:
        """Hand the present state to LAMMPS and compute its forces."""
        system, scene = self.system, self._scene
        translation = translate(scene, noise_seed(self._seed, system.step))
        self._translation: Translation = translation
        positions, velocities = system.positions, system.velocities
        path = self._team.folder / "beads.data"
        try:
            with path.open("w", encoding="utf-8") as file:
                file.writelines(translation.data.pieces(positions, velocities))
        except OSError as error:
            raise RunError(f"the beads cannot be handed to LAMMPS: {path}: {error.strerror or error}") from error
        images = system.images.astype(np.int64)
        self._observe(self._ask("load", translation.commands(str(path))))
        path.unlink()
        self._raw_images, self._images = None, images
        system.store(self.fetch())

    def run(self, steps: int) -> None:
        """Take ``steps`` steps and observe the last one.

        Raises:
            RunError: LAMMPS stopped, a rank is gone, or something is not finite any more; the state is then the last
                one whose beads had been asked for.
        """
        system = self.system
        while steps > 0:
            now = min(steps, system.until_sample())
            answers = self._ask("run", now)
            system.advance(now, self._scene.dynamics.timestep)
            self._observe(answers)
            system.sample_if_due()
            steps -= now

    def fetch(self) -> dict[str, NDArray[Any]]:
        """Return the beads of all ranks in the order of their ids."""
        parts = self._ask("beads")
        ids = np.concatenate([part["id"] for part in parts])
        count = self._scene.bead_count
        if len(ids) != count:
            self._end()
            raise RunError(f"LAMMPS has lost {count - len(ids)} of {count} beads")
        order = np.empty(count, dtype=np.int64)
        order[ids - 1] = np.arange(count)

        def ordered(name: str) -> NDArray[Any]:
            return np.asarray(np.concatenate([part[name] for part in parts])[order])

        raw = ordered("image")
        before = np.zeros_like(raw) if self._raw_images is None else self._raw_images
        crossed = (raw - before + 512) % 1024 - 512  # LAMMPS counts in ten bits
        self._raw_images, self._images = raw, self._images + crossed
        return {
            "positions": ordered("x"),
            "velocities": ordered("v"),
            "forces": ordered("f"),
            "images": self._images.copy(),
        }

    def totals(self) -> Totals:
        """Return what was observed at the last observed step; drag holds drag and noise together."""
        seen: dict[str, Any] = dict(self._seen)
        energy, virial = (x / seen["volume"] for x in self._tail)
        seen["pair_energy"] += energy
        seen["conservative"] = seen["conservative"] - np.eye(3) * (virial / 3.0)
        return Totals(**seen, noise=np.zeros((3, 3)))

    def configurational(self) -> tuple[float, float]:
        """Return Σ|∇U|² and Σ∇²U over the mobile beads, internal units, from the native core."""
        self._hand_to_native()
        return self._native.configurational()

    def layer_sums(self, axis: int, layers: int) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.int64]]:
        """Return kinetic, pair and bonded sums (layers, 6) and beads (layers, species), from the native core."""
        self._hand_to_native()
        return self._native.layer_sums(axis, layers)

    def distance_counts(self, bins: int, species: int) -> NDArray[np.int64]:
        """Return pair distance counts, (species, species, bins), pairs counted once under a ≤ b."""
        return self._native.distance_counts(bins, species)

    def plan(self) -> list[str]:
        """Return in words how steps are computed."""
        where = "the ranks of the MPI job" if self._job is not None else "ranks started for this run"
        styles = [line for line in self._translation.after if line.startswith(("pair_style", "kspace_style", "fix "))]
        return [
            f"engine lammps: LAMMPS {self._team.version} on {self._team.ranks} rank(s), {where}",
            *styles,
            "noise: LAMMPS's own; runs that continue have the same statistics, not the same bits",
        ]

    def notes(self) -> list[str]:
        """Return what a user should know about results of this engine."""
        notes = [DRAG_NOTE] if any(pair.drag > 0.0 for pair in self._scene.pairs) else []
        if self._scene.dynamics.integrator == "hoover":
            notes.append("engine lammps: a run that continues begins with the thermostat of hoover at rest")
        return notes

    def _ask(self, *command: Any) -> list[Any]:
        try:
            return self._team.ask(*command)
        except RunError as error:
            step = self.system.step
            self.system.fall_back()
            doing = f"in steps {step + 1} to {step + command[1]}" if command[0] == "run" else f"at step {step}"
            raise RunError(f"{error}, {doing}; the state here is that of step {self.system.step}") from None

    def _end(self) -> None:
        self.system.fall_back()
        if self._job is None:
            self._team.close()

    def _observe(self, answers: list[Any]) -> None:
        seen = self._translation.observed.parts(answers[0])
        for name, value in seen.items():
            if not np.isfinite(value).all():
                raise RunError(f"{name.replace('_', ' ')} is not finite at step {self.system.step}")
        self._seen = seen

    def _hand_to_native(self) -> None:
        native, system = self._native.system, self.system
        native.positions, native.velocities = system.positions, system.velocities
        native.step, native.time = system.step, system.time
        self._native.initialise()


def _ranks(options: EngineOptions, job: tuple[int, int] | None) -> int:
    if options.ranks is not None and options.ranks < 1:
        raise InputError(f"the number of ranks must be at least 1, not {options.ranks}")
    if job is None:
        return options.ranks or 1
    if options.ranks not in (None, job[1]):
        raise InputError(f"this MPI job has {job[1]} ranks, which are all used; leave --ranks {options.ranks} out")
    return job[1]
