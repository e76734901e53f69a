"""Finds and reads the files of a run and resolves them into a scene."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from pydlpoly.errors import InputError
from pydlpoly.formats.bonded_table import TABLE_KINDS, read_bonded_tables, wanted_tables
from pydlpoly.formats.config import read_config
from pydlpoly.formats.control import read_control, value_in
from pydlpoly.formats.field import read_field
from pydlpoly.formats.records import BondedTable, Configuration, Control, Field, PairTable
from pydlpoly.formats.table import read_table
from pydlpoly.scene.model import Scene
from pydlpoly.scene.resolve import resolve

Path_ = str | PathLike[str]


def load(
    directory: Path_ | None = None,
    *,
    control: Path_ | Control | None = None,
    field: Path_ | Field | None = None,
    config: Path_ | Configuration | None = None,
    lenient: bool = False,
) -> Scene:
    """Read CONTROL, FIELD, CONFIG (and the tables of ``tab`` pairs and terms) and return the scene they describe.

    Args:
        directory: the folder of the files; without it CONTROL's folder, or the current one.
        control, field, config: a file in place of the usual one (relative to ``directory`` when that is given), or a
            record that is already there. Without ``field`` and ``config``, CONTROL's own ``io_file_field`` and
            ``io_file_config`` say what the files are called.
        lenient: slips that cannot change the physics become warnings, where the readers know such slips.

    Raises:
        InputError: a file is missing or cannot be read as what it claims to be.
        SceneError: the files can be read, but do not make a scene; see ``resolve``.
    """
    folder = Path(directory) if directory is not None else None
    if not isinstance(control, Control):
        path = _find(folder, control, "CONTROL", "the run's settings", "the argument control")
        control = read_control(path, lenient=lenient)
        folder = folder if folder is not None else path.parent
    elif folder is None:
        folder = Path(control.path).parent
    if not isinstance(field, Field):
        name = str(value_in(control, "io_file_field"))
        field = read_field(
            _find(folder, field, name, "the force field", "io_file_field or the argument field"), lenient
        )
    if not isinstance(config, Configuration):
        name = str(value_in(control, "io_file_config"))
        path = _find(folder, config, name, "the start configuration", "io_file_config or the argument config")
        config = read_config(path, ignore_indices=bool(value_in(control, "ignore_config_indices")))
    tables, table_path = _tables(folder, control, field)
    bonded_tables, bonded_paths = _bonded_tables(folder, control, field)
    sources = [control.path, field.path, config.path, *table_path, *bonded_paths]
    return resolve(control, field, config, tables=tables, bonded_tables=bonded_tables, sources=sources)


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
