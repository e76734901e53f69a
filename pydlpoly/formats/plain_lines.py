"""Many bead lines at once, for CONFIG and HISTORY files of millions; what is not plain is left to slower readers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pydlpoly.formats.records import FloatArray


def plain_vectors(lines: Sequence[str]) -> FloatArray | None:
    """Return the first three numbers of every line, (lines, 3), or None when any line needs a careful look.

    Plain are finite numbers in C's form, at least three and equally many a line.
    """
    if not lines or not lines[0].strip():
        return None
    try:
        # Skips blank lines and never guesses: other words, and lines of other lengths, are a ValueError.
        values = np.loadtxt(lines, dtype=np.float64, comments=None, ndmin=2)
    except ValueError:
        return None
    if values.shape[0] != len(lines) or values.shape[1] < 3:
        return None
    vectors: FloatArray = values if values.shape[1] == 3 else np.ascontiguousarray(values[:, :3])
    return vectors if bool(np.isfinite(vectors).all()) else None


def plain_heads(lines: Sequence[str]) -> list[list[str]] | None:
    """Return the words of bead lines by column, names first, or None when any line needs a careful look.

    Plain are lines that begin with the name in their first column and have equally many words.
    """
    words = "\n".join(lines).split()
    if not lines or not words or len(words) % len(lines):
        return None
    columns = len(words) // len(lines)
    names = words[::columns]
    # A line of fewer words would shift those of the next: its name would not begin its line.
    if not all(map(str.startswith, lines, names)):
        return None
    return [names, *(words[column::columns] for column in range(1, columns))]
