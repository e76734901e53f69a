"""Plain text of Scene.explain(): words of units and numbers, folded sentences, tables."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence

import numpy as np

from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import PairTerm, Scene

_WIDTH = 100


class Words:
    """Unit words for numbers in internal units; empty in a scene in reduced units."""

    def __init__(self, scene: Scene) -> None:
        reduced = scene.units.reduced
        self.length, self.time, self.mass = ("", "", "") if reduced else (" ang", " ps", " Da")
        self.drag, self.volume, self.density = ("", "", "") if reduced else (" Da/ps", " ang^3", " ang^-3")
        self.force, self.velocity = ("", "") if reduced else (" Da ang/ps^2", " ang/ps")


def pair_name(scene: Scene, term: PairTerm) -> str:
    """Return the names of a pair's species."""
    return "-".join(scene.species[k] for k in term.species)


def every(steps: int) -> str:
    """Return an interval in words."""
    return "every step" if steps == 1 else f"every {steps} steps"


def spread(values: FloatArray) -> str:
    """Return smallest and largest of some numbers, one when they are the same."""
    if len(values) == 0:
        return "-"
    low, high = float(np.min(values)), float(np.max(values))
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def wrap(text: str, start: str = "") -> list[str]:
    """Fold a sentence; words are never cut, so that names of files can be copied."""
    return textwrap.wrap(
        text,
        _WIDTH,
        initial_indent=start,
        subsequent_indent="  " if start in ("", "* ") else " " * (len(start) + 2),
        break_long_words=False,
        break_on_hyphens=False,
    )


def table(headers: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Align columns: words to the left, numbers to the right."""
    rows = [list(row) for row in rows]
    sizes = [max(len(cell) for cell in column) for column in zip(headers, *rows, strict=True)]
    right = [all(_is_number(row[k]) for row in rows) for k in range(len(headers))]

    def line(cells: Sequence[str]) -> str:
        padded = [c.rjust(n) if r else c.ljust(n) for c, n, r in zip(cells, sizes, right, strict=True)]
        return "  ".join(padded).rstrip()

    return [line(headers), *(line(row) for row in rows)]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return text == "-"
    return True
