"""ZDNDAT: number density along z of every species, in DL_POLY's layout.

record 1   title
record 2   (2i10)        species points
species    (a8)          name
           (1p,2e14.6)   z, middle of the bin, and the number density
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import PathLike, read_text, replace_file
from pydlpoly.formats.fortran import fortran_e, fortran_i, parse_reals
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class DensityTable:
    """A ZDNDAT file.

    Attributes:
        species: names, in the file's order.
        z: (points,) middle of each bin in Å; the cell's middle is 0.
        density: (species, points) beads per Å³.
    """

    title: str
    species: tuple[str, ...]
    z: FloatArray
    density: FloatArray

    def __getitem__(self, species: str) -> FloatArray:
        """Return the profile of a species, (points,). Raises KeyError when the file has no such species."""
        if species not in self.species:
            raise KeyError(species)
        profile: FloatArray = self.density[self.species.index(species)]
        return profile


def write_density(path: PathLike, title: str, species: Sequence[str], z: ArrayLike, density: ArrayLike) -> None:
    """Write ZDNDAT in one instant.

    Args:
        path: the file.
        title: the run's title (72 characters are kept).
        species: names of at most 8 characters.
        z: (points,) in Å.
        density: (species, points) per Å³.

    Raises:
        InputError: a name is longer than its column.
        RunError: the file cannot be written.
        ValueError: the shapes do not belong together.
    """
    places = np.asarray(z, dtype=np.float64)
    profiles = np.asarray(density, dtype=np.float64).reshape(len(species), len(places))
    lines = [" ".join(title.splitlines())[:72], fortran_i(len(species), 10) + fortran_i(len(places), 10)]
    for name, profile in zip(species, profiles, strict=True):
        if len(name) > 8:
            raise InputError("a name in a DL_POLY file has at most 8 characters", path=os.fspath(path), word=name)
        lines.append(f"{name:<8}")
        rows = zip(places.tolist(), profile.tolist(), strict=True)
        lines.extend(fortran_e(place, 14, 6) + fortran_e(value, 14, 6) for place, value in rows)
    replace_file(path, "\n".join([*lines, ""]))


def read_density(path: PathLike) -> DensityTable:
    """Read a ZDNDAT file; a third column, the running number that newer releases write, is left out.

    Raises:
        InputError: the file is missing or not a ZDNDAT file.
    """
    name = os.fspath(path)
    lines = read_text(path).splitlines()
    head = lines[1].split() if len(lines) > 1 else []
    if len(head) != 2 or not all(word.isdigit() for word in head):
        message = "is not a ZDNDAT file: expected numbers of species and of points"
        raise InputError(message, path=name, line=2, word=" ".join(head))
    count, points = int(head[0]), int(head[1])
    if len(lines) < 2 + count * (points + 1):
        raise InputError(f"expected {count} profiles of {points} points; the file is cut short", path=name)
    species, table = [], np.zeros((count, points, 2))
    for k in range(count):
        start = 2 + k * (points + 1)
        species.append(lines[start].strip())
        for row in range(points):
            number = start + 1 + row
            try:
                table[k, row] = parse_reals(lines[number].split()[:2])
            except ValueError:
                message = "expected z and a density"
                raise InputError(message, path=name, line=number + 1, word=lines[number].strip()) from None
    z = table[0, :, 0] if count else np.zeros(points)
    return DensityTable(lines[0].strip(), tuple(species), z, table[:, :, 1])
