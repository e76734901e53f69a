"""Writes the files of a run anew: in DL_POLY's newest form, also from files in DL_MESO's dialect, or for LAMMPS."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from pydlpoly.engines.lammps_translate import noise_seed, translate
from pydlpoly.engines.native import NativeEngine
from pydlpoly.engines.native_scene import long_range_tail
from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.atomic import atomic_file, replace_file
from pydlpoly.formats.beads_file import write_beads
from pydlpoly.formats.config import write_config
from pydlpoly.formats.control import write_control
from pydlpoly.formats.field import write_field
from pydlpoly.scene.load import load, read_records

_FILE_NAMES = ("io_file_config", "io_file_field", "io_file_control", "io_file_beads")
_DATA_FILE = "beads.data"
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


def convert_to_lammps(source: Path, target: Path, *, lenient: bool = False) -> tuple[str, ...]:
    """Write ``in.lammps`` and ``beads.data`` of the run in ``source`` into ``target``, which is made if need be.

    Velocities that the run would draw are in the data file.

    Returns:
        What a user of LAMMPS should know beside the script.

    Raises:
        InputError: the source cannot be read or resolved, or the target cannot be written.
        SceneError: the scene cannot be translated; the text names file and line.
    """
    scene = load(source, lenient=lenient)
    seed = scene.run.seed if scene.run.seed is not None else 1
    translation = translate(scene, noise_seed(seed, 0))
    start = NativeEngine(scene, seed=seed, threads=1)
    start.prepare(scene)
    energy, virial = (x / float(start.system.volume) for x in long_range_tail(scene))
    try:
        target.mkdir(parents=True, exist_ok=True)
        with atomic_file(target / _DATA_FILE) as file:
            carried = translation.carried
            pieces = translation.data.pieces(
                start.system.positions,
                start.system.velocities,
                np.asarray(start.system.bead_temperatures) if carried.heat else None,
                np.asarray(start.system.concentrations) if carried.dissolved else None,
            )
            file.writelines(piece.encode("utf-8") for piece in pieces)
        replace_file(target / "in.lammps", "\n".join([*translation.script(scene, _DATA_FILE, scene.run.steps), ""]))
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", path=str(target)) from error
    except RunError as error:
        raise InputError(str(error)) from error
    warnings = [note.text for note in scene.notes if note.kind == "warning"]
    if translation.first_half:
        warnings.append("LAMMPS leaves sources out of the first half of the first step")
    if translation.observed.many_body:
        warnings.append("LAMMPS's energy has a many-body part to which no forces belong; see docs/many-body.md")
    if energy or virial:
        warnings.append(f"long-range corrections are not in LAMMPS's numbers: energy {energy:.9g}, virial {virial:.9g}")
    return tuple(warnings)
