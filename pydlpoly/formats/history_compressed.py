"""HISTORY in DL_POLY's compressed form (level 3): fixed columns, beads in the order of the file, no indices.

A frame is ``timestep``, step, timestep and time as (a8,i6,f8.5,f12.5), the cell as three lines (3f10.3), and a line a
bead (a6,4f7.1): name, displacement and position. Numbers may touch, hence the columns.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from pydlpoly.errors import InputError, InputWarning
from pydlpoly.formats.fortran import parse_real
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.history_beads import Lines

_LEVEL = 3


def compressed_frames(lines: Lines, beads: int, imcon: int) -> Iterator[Frame]:
    """Read frame by frame; masses and charges are NaN.

    Raises:
        InputError: a frame begins with another word, or holds words where numbers should be.
    """
    if beads < 1:
        raise InputError("expected the number of beads, at least one, after level and imcon", path=lines.path, line=2)
    while (first := lines.next()) is not None:
        if not first.strip():
            continue
        start = lines.number
        if not first.startswith("timestep"):
            raise InputError("expected 'timestep'", path=lines.path, line=start, word=first.strip()[:20])
        block = lines.block(3 + beads)
        torn = next((i for i, line in enumerate(block) if line.startswith("timestep")), len(block))
        if torn < 3 + beads or not block[-1].endswith("\n"):
            lines.give_back(block[torn:])
            warnings.warn(InputWarning(f"{lines.path}:{lines.number}: a frame is cut short and left out"), stacklevel=3)
            continue
        step, timestep, time = _columns(first, (8, 14, 22, 34), lines.path, start)
        cell = [_columns(line, (0, 10, 20, 30), lines.path, start + k) for k, line in enumerate(block[:3], 1)]
        rows = [_columns(line, (6, 13, 20, 27, 34), lines.path, start + k) for k, line in enumerate(block[3:], 4)]
        numbers = np.array(rows)
        unknown = np.full(beads, np.nan)
        names = tuple(line[:6].strip() for line in block[3:])
        indices = np.arange(1, beads + 1)
        positions = np.ascontiguousarray(numbers[:, 1:])
        yield Frame(
            *(names, indices, unknown, unknown, numbers[:, 0], positions),
            step=int(step),
            time=time,
            timestep=timestep,
            level=_LEVEL,
            imcon=imcon,
            cell=np.array(cell),
        )


def _columns(line: str, edges: tuple[int, ...], path: str, number: int) -> list[float]:
    words = [line[low:high].strip() for low, high in pairwise(edges)]
    try:
        return [parse_real(word) for word in words]
    except ValueError:
        message = f"expected {len(words)} numbers in fixed columns, as in a compressed HISTORY"
        raise InputError(message, path=path, line=number, word=line.strip()) from None
