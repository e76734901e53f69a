"""Finds and reads the files of a run and resolves them into a scene."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from pydlpoly.errors import InputError
from pydlpoly.formats.beads_file import read_beads
from pydlpoly.formats.bonded_table import TABLE_KINDS, read_bonded_tables, wanted_tables
from pydlpoly.formats.config import read_config
from pydlpoly.formats.control import read_control, value_in
from pydlpoly.formats.field import looks_like_dl_meso_field, read_field
from pydlpoly.formats.lexing import read_text
from pydlpoly.formats.records import BeadTable, BondedTable, Configuration, Control, Field, PairTable, Remark
from pydlpoly.formats.table import read_table
from pydlpoly.scene.beads_state import STATE_EXTENSIONS
from pydlpoly.scene.dl_meso import adapt, adapt_configuration, start_configuration
from pydlpoly.scene.model import Scene
from pydlpoly.scene.resolve import resolve
from pydlpoly.trajectories import bead_table_of, configuration_of, format_of, open_reader

Path_ = str | PathLike[str]


class Records(NamedTuple):
    """What a folder holds, as ``resolve`` takes it; ``sources`` are the files that were read."""

    control: Control
    field: Field
    config: Configuration
    tables: tuple[PairTable, ...]
    bonded_tables: tuple[BondedTable, ...]
    sources: tuple[str, ...]
    bead_table: BeadTable | None = None


def load(
    directory: Path_ | None = None,
    *,
    control: Path_ | Control | None = None,
    field: Path_ | Field | None = None,
    config: Path_ | Configuration | None = None,
    beads: BeadTable | None = None,
    lenient: bool = False,
) -> Scene:
    """Read CONTROL, FIELD, CONFIG (and the tables of ``tab`` pairs and terms) and return the scene they describe.

    Files in DL_MESO's dialect are known by their content. Without a CONFIG their beads are placed at random.

    Args:
        directory: the folder of the files; without it CONTROL's folder, or the current one.
        control, field, config: a file in place of the usual one (relative to ``directory`` when that is given), or a
            record that is already there. Without ``field`` and ``config``, CONTROL's own ``io_file_field`` and
            ``io_file_config`` say what the files are called. The last frame of a trajectory whose name has the ending
            of its format, such as TRAJECTORY.gsd, can take CONFIG's place.
        lenient: slips that cannot change the physics become warnings, where the readers know such slips.

    Raises:
        InputError: a file is missing or cannot be read as what it claims to be.
        SceneError: the files can be read, but do not make a scene; see ``resolve``.
    """
    read = read_records(directory, control=control, field=field, config=config, beads=beads, lenient=lenient)
    return resolve(
        read.control,
        read.field,
        read.config,
        tables=read.tables,
        bonded_tables=read.bonded_tables,
        bead_table=read.bead_table,
        sources=read.sources,
    )


def read_records(
    directory: Path_ | None = None,
    *,
    control: Path_ | Control | None = None,
    field: Path_ | Field | None = None,
    config: Path_ | Configuration | None = None,
    beads: BeadTable | None = None,
    lenient: bool = False,
) -> Records:
    """Read the files of a run and return their records, DL_MESO's with its rules written out; as ``load``."""
    folder = Path(directory) if directory is not None else None
    if not isinstance(control, Control):
        path = _find(folder, control, "CONTROL", "the run's settings", "the argument control")
        folder = folder if folder is not None else path.parent
        control = read_control(path, lenient=lenient, dl_meso=_is_dl_meso(folder, field))
    elif folder is None:
        folder = Path(control.path).parent
    if not isinstance(field, Field):
        name = str(value_in(control, "io_file_field"))
        field = read_field(
            _find(folder, field, name, "the force field", "io_file_field or the argument field"), lenient
        )
    control, field = adapt(control, field)
    if config is None and _starts_without_config(folder, control):
        built = start_configuration(control, field)
        control, beads, paths = _beads(folder, control, field, beads, beside_config=True)
        tables = _with_tables(folder, control, field, (control.path, field.path, *paths))
        return Records(control, field, built, *tables, beads)
    beside_config = not isinstance(config, Configuration)
    if not isinstance(config, Configuration):
        name = str(value_in(control, "io_file_config"))
        path = _find(folder, config, name, "the start configuration", "io_file_config or the argument config")
        config, carried = _configuration(path, ignore_indices=bool(value_in(control, "ignore_config_indices")))
        if beads is None and control.get("io_file_beads") is None and _carries(field):
            beads = carried
    control, beads, paths = _beads(folder, control, field, beads, beside_config=beside_config)
    control, adapted = adapt_configuration(control, field, config)
    if beads is not None and adapted.names != config.names:
        message = f"the beads of {config.path} outside molecules must stand species after species, as in {field.path}"
        raise InputError(f"cannot be used: {message}", path=beads.path)
    sources = (control.path, field.path, config.path, *paths)
    return Records(control, field, adapted, *_with_tables(folder, control, field, sources), beads)


def _beads(
    folder: Path, control: Control, field: Field, given: BeadTable | None, *, beside_config: bool
) -> tuple[Control, BeadTable | None, tuple[str, ...]]:
    """Read BEADS where beads carry something, else note that it is there; a file that CONTROL names must be there."""
    named = control.get("io_file_beads")
    if given is not None or (named is None and not beside_config):
        return control, given, ()
    path = folder / str(value_in(control, "io_file_beads"))
    if named is None and not path.exists():
        return control, None, ()
    if not _carries(field):
        text = f"{path.name} is not used: FIELD has no extension by which beads carry temperatures or concentrations"
        remark = Remark("ignored", text, 0 if named is None else named.line)
        return replace(control, remarks=(*control.remarks, remark)), None, ()
    path = _find(folder, None, path.name if named is None else str(named.value), "what beads carry", "io_file_beads")
    return control, read_beads(path), (str(path),)


def _carries(field: Field) -> bool:
    """Whether beads have temperatures or concentrations."""
    return any(block.name in STATE_EXTENSIONS for block in field.extensions)


def _configuration(path: Path, *, ignore_indices: bool) -> tuple[Configuration, BeadTable | None]:
    """Read CONFIG, or the last frame of a trajectory, which may say what beads carry."""
    if format_of(path) is None:
        return read_config(path, ignore_indices=ignore_indices), None
    reader = open_reader(path)
    frame, title = reader.frame(-1), reader.topology.title
    return configuration_of(frame, title=title, path=str(path)), bead_table_of(frame, title=title, path=str(path))


def _is_dl_meso(folder: Path, field: Path_ | Field | None) -> bool:
    """Whether the FIELD beside a CONTROL is in DL_MESO's dialect, which a CONTROL by itself may leave open."""
    if isinstance(field, Field):
        return field.meso is not None
    path = folder / (field if field is not None else "FIELD")
    return path.is_file() and looks_like_dl_meso_field(read_text(path))


def _starts_without_config(folder: Path, control: Control) -> bool:
    """Whether DL_MESO's CONTROL leaves it to the program to place the beads."""
    if control.meso is None:
        return False
    return control.meso.without_config or not (folder / str(value_in(control, "io_file_config"))).exists()


def _with_tables(
    folder: Path, control: Control, field: Field, sources: tuple[str, ...]
) -> tuple[tuple[PairTable, ...], tuple[BondedTable, ...], tuple[str, ...]]:
    tables, table_path = _tables(folder, control, field)
    bonded_tables, bonded_paths = _bonded_tables(folder, control, field)
    return tables, tuple(bonded_tables), (*sources, *table_path, *bonded_paths)


def _find(folder: Path | None, given: Path_ | None, usual: str, what: str, cure: str) -> Path:
    """Return the path of an existing file; InputError when there is none."""
    path = Path(given) if given is not None else Path(usual)
    if folder is not None and (given is None or not path.is_absolute()):
        path = folder / path
    if path.is_file():
        return path
    found = "it is a folder" if path.is_dir() else "there is no such file"
    raise InputError(f"{found}; expected {what} here ({cure} can name another)", path=str(path))


def _tables(folder: Path, control: Control, field: Field) -> tuple[tuple[PairTable, ...], tuple[str, ...]]:
    """Read the table of the ``tab`` pairs: CONTROL's name for it, else TABLE or TABVDW (releases disagree)."""
    if not any(line.key == "tab" for line in field.pairs):
        return (), ()
    if control.get("io_file_tabvdw") is not None:
        names = [str(value_in(control, "io_file_tabvdw"))]
    else:
        names = ["TABLE", "TABVDW"] if control.style == "old" else ["TABVDW", "TABLE"]
    name = next((name for name in names if (folder / name).is_file()), names[0])
    path = _find(folder, None, name, "the table of the tab pairs", "io_file_tabvdw")
    return tuple(read_table(path, field)), (str(path),)


def _bonded_tables(folder: Path, control: Control, field: Field) -> tuple[list[BondedTable], list[str]]:
    """Read the tables of the bonded terms that FIELD declares ``tab``, each kind from a file of its own."""
    tables: list[BondedTable] = []
    paths: list[str] = []
    for kind, spec in TABLE_KINDS.items():
        if wanted_tables(kind, field):
            keyword = f"io_file_{spec.name.lower()}"
            path = _find(
                folder, None, str(value_in(control, keyword)), f"the tables of the tab {spec.directive}", keyword
            )
            tables += read_bonded_tables(path, kind, field)
            paths.append(str(path))
    return tables, paths
