"""RDFDAT: radial distribution functions in DL_POLY's layout, and the normalisation that turns counts into g(r)."""

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
class RdfTable:
    """A RDFDAT file.

    Attributes:
        pairs: the two species of each function.
        r: (points,) middle of each bin in Å.
        g: (pairs, points) radial distribution functions.
        n: (pairs, points) running number of beads of the second species around one of the first.
        warnings: what was odd and how it was understood.
    """

    title: str
    pairs: tuple[tuple[str, str], ...]
    r: FloatArray
    g: FloatArray
    n: FloatArray
    path: str = "RDFDAT"
    warnings: tuple[str, ...] = ()

    def __getitem__(self, pair: tuple[str, str]) -> FloatArray:
        """Return g(r) of a pair, shape (points,), its species in either order.

        Raises:
            KeyError: the file has no such pair.
        """
        for index, names in enumerate(self.pairs):
            if pair in (names, names[::-1]):
                function: FloatArray = self.g[index]
                return function
        raise KeyError(f"{self.path} has no pair {pair[0]} {pair[1]}")


def normalise_rdf(
    counts: ArrayLike,
    *,
    like: bool,
    volume: float,
    beads: tuple[int, int],
    configurations: int,
    bin_width: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Turn counts of pairs by distance into r, g(r) and n(r), as DL_POLY does.

    g = count / [V ρ_a ρ_b n_conf · 4πΔ(r² + Δ²/12)] with the bracket multiplied by ½(1 − 1/N) for like pairs: the shell
    is the exact volume between the bin's edges, and a like pair counts once and never a bead with itself.
    n = Σ ρ_b count / (the same bracket without the shell).

    Args:
        counts: (points,) pairs found in bin i, (i−1)Δ ≤ r < iΔ, each pair once, summed over the configurations.
        like: whether both species are the same.
        volume: of the cell in Å³ (the mean one where it varies).
        beads: number of beads of the first and of the second species.
        configurations: how many configurations were counted.
        bin_width: Δ in Å.

    Returns:
        r (middle of each bin), g and n, each (points,).

    Raises:
        ValueError: a quantity that must be positive is not, or a like pair has fewer than two beads.
    """
    first, second = beads
    if like and (first != second or first < 2):
        raise ValueError(f"a like pair needs at least two beads of one species, not {first} and {second}")
    if min(first, second, configurations) < 1 or not (volume > 0.0 and bin_width > 0.0):
        raise ValueError("volume, numbers of beads, configurations and bin width must be positive")
    number = np.asarray(counts, dtype=np.float64)
    r = np.arange(0.5, len(number)) * np.float64(bin_width)
    density = second / volume
    pairs = volume * (first / volume) * density * configurations
    if like:
        pairs *= 0.5 * (1.0 - 1.0 / first)
    shell: FloatArray = 4.0 * np.pi * bin_width * (r**2 + bin_width**2 / 12.0)
    g: FloatArray = number / (pairs * shell)
    n: FloatArray = np.cumsum(number) * (density / pairs)
    return r, g, n


def write_rdf(
    path: PathLike, title: str, pairs: Sequence[tuple[str, str]], r: ArrayLike, g: ArrayLike, n: ArrayLike
) -> None:
    """Write RDFDAT in one instant: title, ``(2i10)``, then for each pair ``(2a8)`` and rows of ``(1p,3e14.6)``.

    Args:
        path: the file.
        title: the run's title (72 characters are kept).
        pairs: the two species of each function, at most 8 characters each.
        r: (points,) in Å.
        g, n: (pairs, points) the functions and the running numbers.

    Raises:
        InputError: a species name is longer than its column.
        RunError: the file cannot be written.
        ValueError: the shapes do not belong together.
    """
    distance = np.asarray(r, dtype=np.float64)
    functions = np.asarray(g, dtype=np.float64).reshape(len(pairs), len(distance))
    numbers = np.asarray(n, dtype=np.float64).reshape(len(pairs), len(distance))
    lines = [" ".join(title.splitlines())[:72], fortran_i(len(pairs), 10) + fortran_i(len(distance), 10)]
    for pair, g_pair, n_pair in zip(pairs, functions, numbers, strict=True):
        for name in pair:
            if len(name) > 8:
                raise InputError("a name in a DL_POLY file has at most 8 characters", path=os.fspath(path), word=name)
        lines.append(f"{pair[0]:<8}{pair[1]:<8}")
        rows = np.column_stack([distance, g_pair, n_pair]).tolist()
        lines.extend("".join(fortran_e(value, 14, 6) for value in row) for row in rows)
    replace_file(path, "\n".join([*lines, ""]))


def read_rdf(path: PathLike) -> RdfTable:
    """Read a classic RDFDAT file.

    Files with fewer pairs than their header says are accepted with a warning: DL_POLY counts a like pair of a species
    with a single bead but does not write it. Where a file has only r and g, n is NaN.

    Raises:
        InputError: the file is missing, is the YAML form, has error columns, or is not a RDFDAT file.
    """
    name = os.fspath(path)
    lines = read_text(path).splitlines()
    if lines and lines[0].startswith("%YAML"):
        raise InputError("the YAML form of RDFDAT is not read; expected a title and '(2i10)'", path=name, line=1)
    head = lines[1].split() if len(lines) > 1 else []
    if len(head) != 2 or not all(word.isdigit() for word in head):
        message = "is not a RDFDAT file: expected numbers of pairs and of points"
        raise InputError(message, path=name, line=2, word=" ".join(head))
    declared, points = int(head[0]), int(head[1])
    body = [(number, line) for number, line in enumerate(lines[2:], 3) if line.strip()]
    pairs: list[tuple[str, str]] = []
    blocks: list[FloatArray] = []
    for start in range(0, len(body), points + 1):
        pairs.append(_pair_names(body[start], name))
        blocks.append(_block(body[start + 1 : start + points + 1], points, name, body[start][0]))
    warnings: tuple[str, ...] = ()
    if len(pairs) != declared:
        warnings = (f"the header says {declared} pairs, the file has {len(pairs)}",)
    table = np.array(blocks).reshape(len(pairs), points, 3)
    r = table[0, :, 0] if pairs else np.zeros(points)
    return RdfTable(lines[0].strip(), tuple(pairs), r, table[:, :, 1], table[:, :, 2], name, warnings)


def _pair_names(numbered: tuple[int, str], path: str) -> tuple[str, str]:
    number, line = numbered
    words = line.split()
    if len(words) != 2 and len(line.rstrip()) > 8:
        words = [line[:8].strip(), line[8:16].strip()]
    if len(words) != 2 or not all(words):
        raise InputError("expected the names of two species", path=path, line=number, word=line.strip())
    return words[0], words[1]


def _block(rows: list[tuple[int, str]], points: int, path: str, line: int) -> FloatArray:
    """One pair's rows as (points, 3); n is NaN where the file has no such column."""
    if len(rows) != points:
        raise InputError(f"expected {points} rows for this pair, found {len(rows)}", path=path, line=line)
    table = np.full((points, 3), np.nan)
    for index, (number, text) in enumerate(rows):
        words = text.split()
        if len(words) not in (2, 3):
            message = "expected r, g and n (columns of error estimates are not read)"
            raise InputError(message, path=path, line=number, word=text.strip())
        try:
            table[index, : len(words)] = parse_reals(words)
        except ValueError:
            raise InputError("expected numbers", path=path, line=number, word=text.strip()) from None
    return table
