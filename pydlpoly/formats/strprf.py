"""STRPRF: the stress in layers as plain columns that ``numpy.loadtxt`` reads. A file of pydlpoly, not of DL_POLY."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from pydlpoly.formats.atomic import PathLike, replace_file
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
