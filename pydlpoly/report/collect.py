"""Reads what a run has left in its folder, all of it or a part, and says of each file why it could not be read."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from numpy.typing import NDArray

from pydlpoly.errors import InputError, PydlpolyError
from pydlpoly.formats.beads_file import read_beads
from pydlpoly.formats.binned_table import BinnedTable, read_binned
from pydlpoly.formats.cor import CorrelationTable, read_cor
from pydlpoly.formats.diagnostics import read_diagnostics
from pydlpoly.formats.history_sample import HistorySample
from pydlpoly.formats.output_reader import OutputLog, read_output
from pydlpoly.formats.rdfdat import RdfTable, read_rdf
from pydlpoly.formats.records import FloatArray
from pydlpoly.formats.species_balance import SpeciesBalance
from pydlpoly.formats.statis import StatisticsTable, read_statistics
from pydlpoly.formats.strprf import ProfileTable, read_profile
from pydlpoly.formats.vafdat import VelocityCorrelation, read_correlations
from pydlpoly.formats.zdndat import DensityTable, read_density
from pydlpoly.report.frames import find_trajectory
from pydlpoly.report.problem import Problem, problem_of
from pydlpoly.report.snapshots import Snapshot, States, of_configuration_file, of_frame, of_scene, with_beads
from pydlpoly.scene import Scene, load
from pydlpoly.scene.model import OutputPlan
from pydlpoly.temperatures import TemperatureSamples
from pydlpoly.units import BOLTZMANN

_INPUTS = ("CONTROL", "FIELD", "CONFIG")
_Read = TypeVar("_Read")


@dataclass(frozen=True)
class Units:
    """Unit words of a run's files; all are empty in reduced units."""

    reduced: bool = False
    energy: str = ""

    def of(self, kind: str) -> str:
        """Return the word for "energy", "temperature", "pressure", "time", "length" and products of these."""
        if self.reduced:
            return ""
        words = {
            "energy": self.energy,
            "virial": self.energy,
            "temperature": "K",
            "pressure": "katm",
            "time": "ps",
            "length": "Å",
            "area": "Å²",
            "volume": "Å³",
            "density": "1/Å³",
            "diffusion": "Å²/ps",
            "momentum": "Da Å/ps",
        }
        return "°" if kind == "angle" else words.get(kind, "")

    @property
    def boltzmann(self) -> float:
        """k_B in units of Å, ps, Da and K."""
        return 1.0 if self.reduced else BOLTZMANN


@dataclass(frozen=True, eq=False)
class Run:
    """What a folder holds of a run. Everything that is not there is None or empty.

    Attributes:
        folder: where the files are.
        files: the files that were found, by name.
        problems: those that could not be read.
        scene: what was modelled; ``scene_source``: the file it is from.
        start, last: the configurations that pictures are drawn of.
        carried: the newest configuration whose file says what beads carry.
        momentum: (3,) of the newest checkpoint.
        history: frames of the trajectory, spread over it; ``history_file``: the file they are from.
        bead_profile, bead_map, correlations: of PROFILE, MAP and COR; ``…_file``: their names.
        balance: what became of the amounts of dissolved species; ``balance_file``: the file that says so.
        callbacks: names of functions that acted on the run.
    """

    folder: Path
    files: Mapping[str, Path] = field(default_factory=dict)
    problems: tuple[Problem, ...] = ()
    scene: Scene | None = None
    scene_source: str = ""
    log: OutputLog | None = None
    statistics: StatisticsTable | None = None
    diagnostics: Mapping[str, NDArray[Any]] | None = None
    rdf: RdfTable | None = None
    density: DensityTable | None = None
    profile: ProfileTable | None = None
    velocities: tuple[VelocityCorrelation, ...] = ()
    history: HistorySample | None = None
    history_file: str = ""
    bead_profile: BinnedTable | None = None
    profile_file: str = ""
    bead_map: BinnedTable | None = None
    map_file: str = ""
    correlations: CorrelationTable | None = None
    correlations_file: str = ""
    balance: tuple[SpeciesBalance, ...] = ()
    balance_file: str = ""
    callbacks: tuple[str, ...] = ()
    carried: Snapshot | None = None
    start: Snapshot | None = None
    last: Snapshot | None = None
    momentum: FloatArray | None = None

    @property
    def has_output(self) -> bool:
        """Whether there is any file that a run writes."""
        return any(name not in _INPUTS for name in self.files)

    @property
    def title(self) -> str:
        """The run's title, the folder's name where there is none."""
        known = (self.scene, self.log, self.statistics)
        return next((one.title for one in known if one is not None and one.title), "") or self.folder.resolve().name

    @property
    def explanation(self) -> str:
        """What was modelled, in words: OUTPUT's, which is that of the run, or the scene's."""
        if self.log is not None and self.log.explanation:
            return self.log.explanation
        return self.scene.explain() if self.scene is not None else ""

    @property
    def units(self) -> Units:
        """The units of the files."""
        if self.scene is not None:
            return Units(self.scene.units.reduced, self.scene.units.label)
        label = self.statistics.energy_label if self.statistics is not None else ""
        return Units(label.upper() == "DPD", label)

    @property
    def beads(self) -> int | None:
        """Number of beads."""
        if self.scene is not None:
            return self.scene.bead_count
        return len(self.last.kinds) if self.last is not None else None

    @property
    def asked_steps(self) -> int | None:
        """How many steps were asked for: as OUTPUT says, or else CONTROL."""
        lines = self.explanation.split("\nRun\n---\n")
        words = lines[1].split() if len(lines) > 1 else []
        if words and words[0].isdigit():
            return int(words[0])
        return self.scene.run.steps if self.scene is not None else None

    @property
    def done_steps(self) -> int | None:
        """The last step of which anything is known."""
        known: list[int] = []
        if self.log is not None:
            known += [*self.log.steps[-1:].tolist(), *([self.log.last_step] if self.log.last_step is not None else [])]
        if self.statistics is not None:
            known += self.statistics.step[-1:].tolist()
        if self.last is not None and self.last.step is not None and self.has_output:
            known.append(self.last.step)
        return max(known, default=None)

    @property
    def timestep(self) -> float | None:
        """Δt, from the scene or from STATIS."""
        if self.scene is not None:
            return self.scene.dynamics.timestep
        table = self.statistics
        if table is not None and len(table) and table.step[-1] > 0:
            return float(table.time[-1] / table.step[-1])
        return None

    @property
    def equilibration(self) -> int:
        """The step after which averages are taken."""
        if self.scene is not None:
            return self.scene.run.averages_after
        if self.log is not None and self.log.averaged_steps and self.log.last_step is not None:
            return self.log.last_step - self.log.averaged_steps
        return 0

    @property
    def target_temperature(self) -> float | None:
        """The thermostat's temperature; None without one, or when it varies."""
        if self.scene is not None:
            return TemperatureSamples(self.scene).target
        return self.log.temperatures["thermostat"][0] if self.log and "thermostat" in self.log.temperatures else None


def collect_run(folder: str | Path, inputs: str | Path | None = None) -> Run:
    """Read the files of a run.

    Args:
        folder: where the output files are.
        inputs: where CONTROL, FIELD and CONFIG are, when they are elsewhere.

    Raises:
        InputError: there is no such folder, or none of the inputs.
    """
    place = Path(folder)
    if not place.is_dir():
        found = "it is a file" if place.exists() else "there is no such folder"
        raise InputError(f"{found}; expected the folder with the output files of a run", path=str(place))
    if inputs is not None and not Path(inputs).is_dir():
        raise InputError("there is no such folder; expected the one with CONTROL, FIELD and CONFIG", path=str(inputs))
    return _Reader(place, Path(inputs) if inputs is not None else place).run()


class _Reader:
    """Reads one folder."""

    def __init__(self, folder: Path, inputs: Path) -> None:
        self._folder, self._inputs = folder, inputs
        self._problems: list[Problem] = []
        self._files: dict[str, Path] = {}

    def run(self) -> Run:
        states = self._read("REVIVE", States.of_checkpoint)
        scene, source = self._scene(states)
        plan = scene.output if scene is not None else OutputPlan()
        if states is None and plan.checkpoint_file not in (None, "REVIVE"):
            states = self._read(plan.checkpoint_file, States.of_checkpoint)
            scene, source = (states.scene, states.file) if states is not None else (scene, source)
        names = scene.species if scene is not None else None
        statistics = self._read(plan.statistics_file, lambda path: _statistics(path, names))
        for warning in statistics.warnings if statistics is not None else ():
            self._problems.append(Problem(plan.statistics_file, warning))
        history_file, history, problems = find_trajectory(self._folder, plan)
        if history_file:
            self._files[history_file] = self._folder / history_file
        self._problems += problems
        first, newest = self._snapshots(states, scene, plan, history, history_file)
        log = self._read(plan.output_file if plan.output_file != "SCREEN" else None, read_output)
        balance, balance_file = (log.species_balance, plan.output_file or "") if log is not None else ((), "")
        if not balance and states is not None:
            balance, balance_file = states.balance, states.file
        return Run(
            folder=self._folder,
            scene=scene,
            scene_source=source,
            log=log,
            statistics=statistics,
            diagnostics=self._read(plan.diagnostics_file, read_diagnostics),
            rdf=self._read(plan.rdf_file, read_rdf),
            density=self._read("ZDNDAT", read_density),
            profile=self._read(plan.profile.file, read_profile),
            velocities=tuple(
                found[-1]
                for path in sorted(self._folder.glob("VAFDAT_*"))
                if not path.name.endswith(".bak") and (found := self._read(path.name, read_correlations))
            ),
            history=history,
            history_file=history_file,
            bead_profile=self._read(plan.bead_profile.file, _profile_of_beads),
            profile_file=plan.bead_profile.file or "",
            bead_map=self._read(plan.bead_map.file, _map_of_beads),
            map_file=plan.bead_map.file or "",
            correlations=self._read(plan.correlations.file, read_cor),
            correlations_file=plan.correlations.file or "",
            balance=balance,
            balance_file=balance_file,
            callbacks=states.callbacks if states is not None else (),
            carried=_newest([one for one in (*newest, *first) if one.values]),
            start=first[0] if first else None,
            last=_newest(newest),
            momentum=states.momentum if states is not None else None,
            files=self._files,
            problems=tuple(self._problems),
        )

    def _read(self, name: str | None, reader: Callable[[Path], _Read]) -> _Read | None:
        """What the reader makes of a file; None when it is not there or cannot be read, which is then noted."""
        if name is None or not (self._folder / name).is_file():
            return None
        self._files[name] = self._folder / name
        try:
            return reader(self._folder / name)
        except (PydlpolyError, OSError, ValueError) as error:
            self._problems.append(problem_of(self._folder / name, error))
            return None

    def _scene(self, states: States | None) -> tuple[Scene | None, str]:
        """The checkpoint's scene, which is that of the run, or what the input files describe now."""
        for name in _INPUTS:
            if (self._inputs / name).is_file():
                self._files[name] = self._inputs / name
        if states is not None:
            return states.scene, states.file
        if not (self._inputs / "CONTROL").is_file():
            return None, ""
        try:
            return load(self._inputs), "CONTROL"
        except (PydlpolyError, OSError, ValueError) as error:
            self._problems.append(Problem("CONTROL", f"the input files make no scene: {error}"))
            return None, ""

    def _snapshots(
        self,
        states: States | None,
        scene: Scene | None,
        plan: OutputPlan,
        history: HistorySample | None,
        history_file: str,
    ) -> tuple[list[Snapshot], list[Snapshot]]:
        """Configurations that may be the first one, the best first, and those that may be the newest one."""
        first = [states.start] if states is not None else []
        newest = [states.last] if states is not None else []
        if not first and scene is not None:
            first.append(of_scene(scene))
        if not newest:
            found = self._read(plan.configuration_file, of_configuration_file)
            beads = self._read(plan.beads_file, read_beads)
            newest += [with_beads(found, beads)] if found is not None else []
        elif plan.configuration_file is not None and (self._folder / plan.configuration_file).is_file():
            self._files[plan.configuration_file] = self._folder / plan.configuration_file
        if history is not None and history.frames:
            first.append(of_frame(history.frames[0], history_file))
            newest.append(of_frame(history.frames[-1], history_file))
        return first, newest


def _newest(snapshots: Sequence[Snapshot]) -> Snapshot | None:
    return max(snapshots, key=lambda one: one.step if one.step is not None else -1, default=None)


def _profile_of_beads(path: Path) -> BinnedTable:
    return _of_axes(path, 1)


def _map_of_beads(path: Path) -> BinnedTable:
    return _of_axes(path, 2)


def _of_axes(path: Path, axes: int) -> BinnedTable:
    table = read_binned(path)
    if len(table.axes) != axes:
        raise InputError(f"expected averages along {axes} axes, found {len(table.axes)}", path=str(path))
    return table


def _statistics(path: Path, species: Sequence[str] | None) -> StatisticsTable:
    """STATIS with the columns of species named, where their number is that of the scene."""
    try:
        return read_statistics(path, species=species)
    except InputError:
        if species is None:
            raise
        return read_statistics(path)
