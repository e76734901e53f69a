"""Writes the files of a run anew in DL_POLY's newest form, also from files in DL_MESO's dialect."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.atomic import replace_file
from pydlpoly.formats.beads_file import write_beads
from pydlpoly.formats.config import write_config
from pydlpoly.formats.control import write_control
from pydlpoly.formats.field import write_field
from pydlpoly.scene.load import read_records

_FILE_NAMES = ("io_file_config", "io_file_field", "io_file_control", "io_file_beads")
_DIGITS = 17  # these read back to the last bit


def convert_folder(source: Path, target: Path, *, lenient: bool = False) -> tuple[str, ...]:
    """Write CONTROL (new style), FIELD, CONFIG, and BEADS where it is used, of the run in ``source`` into ``target``.

    The files load as the same scene: the same forces, and with the same seed the same trajectory, to the last bit.

    Returns:
        What the readers warned of.

    Raises:
        InputError: the source cannot be read or resolved, needs a table beside its FIELD, is the target itself, or the
            target cannot be written.
    """
    if target.exists() and target.resolve() == source.resolve():
        raise InputError("the files would overwrite those they come from; choose another folder", path=str(target))
    read = read_records(source, lenient=lenient)
    if read.tables or read.bonded_tables:
        raise InputError("tabulated laws have files of their own, which are not converted", path=str(source))
    settings = tuple(setting for setting in read.control if setting.keyword not in _FILE_NAMES)
    texts = {
        "CONTROL": write_control(replace(read.control, style="new", settings=settings)),
        "FIELD": write_field(read.field),
        "CONFIG": write_config(read.config, digits=_DIGITS),
    }
    try:
        target.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            replace_file(target / name, text)
        if read.bead_table is not None:
            table = read.bead_table
            write_beads(target / "BEADS", table.title, table.names, list(table.values.T))
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", path=str(target)) from error
    except RunError as error:
        raise InputError(str(error)) from error
    return (*read.control.warnings, *read.field.warnings, *read.config.warnings)
