"""Trajectories from one format into another, frame by frame, and single frames into CONFIG."""

from __future__ import annotations

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.atomic import atomic_file
from pydlpoly.formats.beads_file import write_beads
from pydlpoly.formats.config_writer import write_config_to
from pydlpoly.trajectories import FORMATS, bead_table_of, configuration_of, open_reader, open_writer

TARGETS = (*FORMATS, "config")
"""What a trajectory can be converted to."""

_BEADS = "BEADS"
_DIGITS = 17  # these read back to the last bit


def convert_trajectory(source: Path, to: str, target: Path | None = None, *, frame: int | None = None) -> Path:
    """Write a trajectory in another format, or one frame of it as a CONFIG, and return the file.

    Temperatures and concentrations of the frame's beads go into BEADS beside CONFIG.

    Frames are read and written one after the other, so that no more than a few are in memory. The files appear under
    their names when they are whole.

    Args:
        source: a trajectory of any format.
        to: one of ``TARGETS``.
        target: the file to write; by default beside the source, CONFIG or HISTORY, or the source's name with the
            format's ending, where there is none of that name yet.
        frame: with ``config`` the number of the frame, by default −1, the last; with others this frame alone.

    Raises:
        InputError: the source cannot be read, the format cannot hold its frames, or the target cannot be written.
    """
    path = target if target is not None else _usual(source, to)
    second = [path.with_suffix(FORMATS[to].companion)] if to in FORMATS and FORMATS[to].companion else []
    for one in (path, *second):
        _refuse_file_that_is_there(one, source, given=target is not None)
    try:
        if to == "config":
            reader = open_reader(source)
            found = reader.frame(-1 if frame is None else frame)
            title = reader.topology.title
            table = bead_table_of(found, title=title)
            if table is not None:
                _refuse_file_that_is_there(path.with_name(_BEADS), source, given=target is not None)
                write_beads(path.with_name(_BEADS), title, table.names, list(table.values.T))
            with atomic_file(path) as file:
                write_config_to(file, configuration_of(found, title=title), _DIGITS)
        else:
            _stream(source, to, path, frame)
    except RunError as error:
        raise InputError(str(error)) from error
    return path


def _refuse_file_that_is_there(path: Path, source: Path, *, given: bool) -> None:
    """Never write over the source, and over other files only where the user has named them."""
    same = path.resolve() == source.resolve()
    if path.exists() and (same or not given):
        what = "is the file to be read" if same else "is there already"
        raise InputError(f"{what}; say with --output what to write", path=str(path))


def _usual(source: Path, to: str) -> Path:
    if to in ("config", "history"):
        return source.with_name(to.upper())
    return source.with_name((source.stem if source.suffix else source.name) + FORMATS[to].extension)


def _stream(source: Path, to: str, path: Path, index: int | None) -> None:
    reader = open_reader(source)
    frames = iter(reader) if index is None else iter([reader.frame(index)])
    first = next(frames, None)
    if first is None:
        raise InputError("there are no frames in it", path=str(source))
    try:
        with TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
            with open_writer(to, Path(folder) / path.name, first, reader.topology) as writer:
                writer.write(first)
                del first
                for frame in frames:
                    writer.write(frame)
                writer.sync()
            for made in Path(folder).iterdir():
                shutil.move(made, path.with_name(made.name))
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", path=str(path)) from error
