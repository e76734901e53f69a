"""Frames of a run's trajectory in whatever format: some of them, spread over it, so that the memory stays small."""

from __future__ import annotations

import warnings
from pathlib import Path

from pydlpoly.errors import InputError, InputWarning, PydlpolyError
from pydlpoly.formats.history_sample import HistorySample
from pydlpoly.report.problem import Problem, problem_of
from pydlpoly.scene.model import OutputPlan
from pydlpoly.trajectories import FORMATS, open_reader
from pydlpoly.trajectories.base import Reader

_FRAMES = 20  # that are looked at
_BEADS = 2_000_000  # in all of them: what fits into some hundred megabytes
_ORDER = ("h5md", "gsd", "extxyz", "dcd")  # those first that hold most and are read fastest


def find_trajectory(folder: Path, plan: OutputPlan) -> tuple[str, HistorySample | None, list[Problem]]:
    """Return the name of the trajectory, frames of it, and what could not be read.

    HISTORY is taken when it is there and has frames, else the first of the other formats that has some. A format whose
    package is missing is a problem only when no other file has frames.
    """
    problems: list[Problem] = []
    missing: list[Problem] = []
    empty: tuple[str, HistorySample | None] = ("", None)
    formats = [FORMATS[name].files(plan.trajectory_stem)[0] for name in _ORDER]
    for name in [*([plan.trajectory_file] if plan.trajectory_file else []), *formats]:
        path = folder / name
        if not path.is_file():
            continue
        try:
            found = _sample(path)
        except (PydlpolyError, OSError, ValueError) as error:
            package = isinstance(error, InputError) and not error.path
            (missing if package else problems).append(problem_of(path, error))
            empty = (name, None) if not empty[0] else empty
            continue
        if found.frames:
            return name, found, problems
        empty = (name, found)
    return *empty, [*problems, *missing]


def _sample(path: Path) -> HistorySample:
    """Frames of a file. Raises InputError also for what the packages that read it raise at damaged files."""
    try:
        reader = open_reader(path)
        return reader.sample(max(2, min(_FRAMES, _BEADS // max(_beads(reader), 1))))
    except (RuntimeError, KeyError, IndexError, EOFError, AttributeError) as error:
        if isinstance(error, PydlpolyError):
            raise
        raise InputError(f"damaged: {error}", path=str(path)) from error


def _beads(reader: Reader) -> int:
    """How many beads a frame has, 0 where there is no whole one."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)  # said by the sample
        try:
            return len(reader.frame(0).names)
        except InputError:
            return 0
