"""The engine lammps: a scene in LAMMPS, on one rank or many, behind the same simulation, reporters and files.

The process in front keeps a copy of all beads as they were last asked for. What LAMMPS does not compute as this package
does (pair distances, layers of stress, the configurational temperature) is computed there by the native core.
"""

from __future__ import annotations

import weakref
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.engines.lammps_ledger import Ledger
from pydlpoly.engines.lammps_state import LammpsState
from pydlpoly.engines.lammps_team import JobTeam, ProcessTeam, Team, enter_job, switches_of
from pydlpoly.engines.lammps_translate import Translation, noise_seed, translate
from pydlpoly.engines.lammps_translate.carried import carried_of
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


LUMPED_NOTE = "engine lammps: one virial of pair laws, drag and noise is known; it stands under conservative"


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
        _check_accelerator(scene, options)
        self._scene, self._seed = scene, seed
        self._ledger = Ledger(scene)
        self._tail = long_range_tail(scene)
        self._native = NativeEngine(scene, seed=seed, threads=threads)
        self.system = LammpsState(self, self._native.system, carried_of(scene))
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
        carried = translation.carried
        beads = (
            system.positions,
            system.velocities,
            np.asarray(system.bead_temperatures) if carried.heat else None,
            system.concentrations if carried.dissolved else None,
        )
        path = self._team.folder / "beads.data"
        try:
            with path.open("w", encoding="utf-8") as file:
                file.writelines(translation.data.pieces(*beads))
        except OSError as error:
            raise RunError(f"the beads cannot be handed to LAMMPS: {path}: {error.strerror or error}") from error
        images = system.images.astype(np.int64)
        commands = [*translation.commands(str(path)), *translation.carried_computes()]
        answers = self._ask("load", commands, (carried.heat, carried.density, carried.dissolved))
        path.unlink()
        self._starting = True
        self._ledger.begin(carried, answers)
        self._observe(answers)
        self._raw_images, self._images = None, images
        system.store(self.fetch())

    def run(self, steps: int) -> None:
        """Take ``steps`` steps and observe the last one.

        Raises:
            RunError: LAMMPS stopped, a rank is gone, or something is not finite any more; the state is then the last
                one whose beads had been asked for.
        """
        system = self.system
        if steps > 0 and self._starting:
            self._begin_sources()
        self._starting = self._starting and steps <= 0
        while steps > 0:
            now = min(steps, system.until_sample())
            answers = self._ask("run", now)
            system.advance(now, self._scene.dynamics.timestep)
            self._observe(answers)
            system.sample_if_due()
            steps -= now

    def _begin_sources(self) -> None:
        """Have sources act in the first half of the first step."""
        if not self._translation.first_half:
            return
        try:
            self._ask("do", list(self._translation.first_half))
        except RunError as error:
            if "Invalid" not in str(error):
                raise
            message = "a sink takes more than a bead has in the first step, to which LAMMPS sets no limit"
            raise RunError(f"{message}; the native engine runs it ({error})") from None

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
        carried = [name for name in ("temperature", "concentrations", "density") if name in parts[0]]
        beads = {
            "positions": ordered("x"),
            "velocities": ordered("v"),
            "forces": ordered("f"),
            "images": self._images.copy(),
            **{name: ordered(name) for name in carried},
        }
        if "density" in beads:
            beads["density"] /= self._translation.density_mass
        return beads

    def totals(self) -> Totals:
        """Return what was observed at the last observed step; drag holds drag and noise together."""
        seen: dict[str, Any] = dict(self._seen)
        energy, virial = (x / seen["volume"] for x in self._tail)
        seen["pair_energy"] += energy
        seen["conservative"] = seen["conservative"] - np.eye(3) * (virial / 3.0)
        if self._scene.heat is not None:
            supplied, ahead = self._ledger.account
            seen |= {"internal_energy": self._ledger.internal, "heat_balance": ahead - supplied}
        return Totals(**seen, noise=np.zeros((3, 3)))

    # What beads carry

    @property
    def transport(self) -> Any:
        """What became of dissolved species, in its ``tally``; None without them."""
        return None if self._scene.transport is None else self._ledger

    @property
    def heat_account(self) -> tuple[float, float]:
        """As the native engine's."""
        return self._ledger.account

    @heat_account.setter
    def heat_account(self, account: tuple[float, float]) -> None:
        self._ledger.account = account

    def local_densities(self) -> FloatArray:
        """Return the local densities (N,) at the last evaluation of forces. Raises ValueError without ``mdpd``."""
        return self.system.local_densities()

    def exchange(self, temperatures: FloatArray | None, concentrations: FloatArray | None) -> None:
        """Replace what beads carry between two steps; the forces stay those of the last one.

        Args:
            temperatures: (N,) as k_B T; concentrations: (N, species). None keeps them.
        """
        if self._starting:  # nothing depends yet on the forces
            self.system.replace_carried(temperatures, concentrations if self._translation.carried.dissolved else None)
            self.initialise()
            return
        columns = [("edpd/temp", temperatures)] if temperatures is not None else []
        if concentrations is not None and self._translation.carried.dissolved:
            columns += [(f"cc {k + 1}", column) for k, column in enumerate(concentrations.T)]
        path = self._team.folder / "values"
        for words, column in columns:
            rows = "".join(f"{k} {value:.17g}\n" for k, value in enumerate(column.tolist(), 1))
            path.write_text(f"{len(column)}\n{rows}", encoding="utf-8")
            lines = [f'variable given atomfile "{path}"', f"set group all {words} v_given", "variable given delete"]
            self._ask("do", lines)
            path.unlink()
        self.system.replace_carried(temperatures, concentrations if self._translation.carried.dissolved else None)
        self._ledger.replaced(temperatures, concentrations)

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
        notes = [] if self._translation.observed.lumped else [DRAG_NOTE] if _has_drag(self._scene) else []
        notes += [LUMPED_NOTE] if self._translation.observed.lumped else []
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
        self._ledger.observe(self._translation.observed, answers, self.system.step)
        seen = self._translation.observed.parts(answers[0])
        for name, value in seen.items():
            if not np.isfinite(value).all():
                raise RunError(f"{name.replace('_', ' ')} is not finite at step {self.system.step}")
        self._seen = seen

    def _hand_to_native(self) -> None:
        native, system = self._native.system, self.system
        native.positions, native.velocities = system.positions, system.velocities
        native.step, native.time = system.step, system.time
        if self._translation.carried.heat:
            native.bead_temperatures = np.asarray(system.bead_temperatures).tolist()
        if self._translation.carried.dissolved:
            native.concentrations = system.concentrations
        self._native.initialise()


def _has_drag(scene: Scene) -> bool:
    return any(pair.drag > 0.0 for pair in scene.pairs)


def _check_accelerator(scene: Scene, options: EngineOptions) -> None:
    """Refuse packages with which LAMMPS gets wrong what beads carry."""
    if options.accelerator and (scene.heat is not None or scene.transport is not None):
        message = "accelerator switches do not go with beads that carry heat or dissolved species"
        raise InputError(f"{message}: with LAMMPS's package OPENMP their fluxes are wrong, and no other was checked")


def _ranks(options: EngineOptions, job: tuple[int, int] | None) -> int:
    if options.ranks is not None and options.ranks < 1:
        raise InputError(f"the number of ranks must be at least 1, not {options.ranks}")
    if job is None:
        return options.ranks or 1
    if options.ranks not in (None, job[1]):
        raise InputError(f"this MPI job has {job[1]} ranks, which are all used; leave --ranks {options.ranks} out")
    return job[1]
