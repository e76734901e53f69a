"""STRPRF: the stress in layers as plain columns that ``numpy.loadtxt`` reads. A file of pydlpoly, not of DL_POLY."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import PathLike, read_text, replace_file
from pydlpoly.formats.blocks import Estimate
from pydlpoly.formats.records import FloatArray

_PLACES = ("xx", "yy", "zz", "xy", "xz", "yz")


@dataclass(frozen=True, eq=False)
class ProfileTable:
    """What the file holds.

    Attributes:
        axis: "x", "y" or "z"; samples: number of samples.
        tension: ∫(p_N − p_T) for each interface; cell_tension: the same of the whole stress of the cell.
        heights, normal, lateral: (layers,), with standard errors of the last two.
        parts: (layers, 6) by part, xx yy zz xy xz yz; densities: (layers,) by species.
    """

    title: str
    axis: str
    samples: int
    pressure_unit: str
    length_unit: str
    tension_unit: str
    tension: Estimate
    cell_tension: Estimate
    heights: FloatArray
    normal: FloatArray
    lateral: FloatArray
    normal_error: FloatArray
    lateral_error: FloatArray
    parts: Mapping[str, FloatArray] = field(default_factory=dict)
    densities: Mapping[str, FloatArray] = field(default_factory=dict)


def write_profile(path: PathLike, table: ProfileTable) -> None:
    """Replace the file: four header lines that begin with #, then one line a layer.

    Raises:
        RunError: the file cannot be written.
    """
    names = [table.axis, "p_normal", "error", "p_lateral", "error"]
    columns = [table.heights, table.normal, table.normal_error, table.lateral, table.lateral_error]
    for part, tensor in table.parts.items():
        names += [f"{part}_{place}" for place in _PLACES]
        columns += list(tensor.T)
    for species, density in table.densities.items():
        names.append(f"density_{species}")
        columns.append(density)
    rows = np.stack(columns, axis=1)
    title = " ".join(table.title.split())
    lines = [
        f"# {title}: stress in {len(rows)} layers along {table.axis}, {table.samples} samples",
        f"# pressure in {table.pressure_unit}, length in {table.length_unit}",
        f"# surface tension in {table.tension_unit}: {_estimate(table.tension)} from the layers, "
        f"{_estimate(table.cell_tension)} from the whole stress",
        "# " + " ".join(names),
    ]
    lines += [" ".join(f"{value:16.9E}" for value in row) for row in rows.tolist()]
    replace_file(Path(path), "\n".join(lines) + "\n")


def _estimate(estimate: Estimate) -> str:
    return f"{estimate.value:.6g} +- {estimate.error:.2g}"


_HEAD = re.compile(r"^# (?P<title>.*): stress in \d+ layers along (?P<axis>[xyz]), (?P<samples>\d+) samples$")
_TENSION = re.compile(r"^# surface tension in (\S+): (\S+) \+- (\S+) from the layers, (\S+) \+- (\S+) from the whole")


def read_profile(path: PathLike) -> ProfileTable:
    """Read a STRPRF file; its estimates do not say from how many blocks they are.

    Raises:
        InputError: the file is missing or is no STRPRF.
    """
    name = os.fspath(path)
    lines = read_text(path).splitlines()
    head = _HEAD.match(lines[0]) if lines else None
    tension = _TENSION.match(lines[2]) if len(lines) > 3 else None
    if head is None or tension is None:
        raise InputError("is no STRPRF of pydlpoly: expected its four header lines", path=name, line=1)
    columns = lines[3].removeprefix("# ").split()
    units = lines[1].replace(",", "").split()
    try:
        table = np.array([[float(word) for word in line.split()] for line in lines[4:]]).reshape(-1, len(columns))
    except ValueError:
        raise InputError(f"expected rows of {len(columns)} numbers", path=name, line=5) from None
    samples = int(head["samples"])
    numbers = [float(word) for word in tension.groups()[1:]]
    of_layers, of_cell = (Estimate(value, error, samples, 0) for value, error in (numbers[:2], numbers[2:]))
    parts = list(dict.fromkeys(word[: -len("_xx")] for word in columns if word.endswith("_xx")))
    return ProfileTable(
        title=head["title"],
        axis=head["axis"],
        samples=samples,
        pressure_unit=units[3],
        length_unit=units[6],
        tension_unit=tension[1],
        tension=of_layers,
        cell_tension=of_cell,
        heights=table[:, 0],
        normal=table[:, 1],
        normal_error=table[:, 2],
        lateral=table[:, 3],
        lateral_error=table[:, 4],
        parts={part: table[:, [columns.index(f"{part}_{place}") for place in _PLACES]] for part in parts},
        densities={
            word.removeprefix("density_"): table[:, k] for k, word in enumerate(columns) if word.startswith("density_")
        },
    )
