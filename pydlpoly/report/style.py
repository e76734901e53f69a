"""What a figure of a report is: with its caption and its table of numbers, and as SVG."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pydlpoly.drawing import look
from pydlpoly.errors import InputError
from pydlpoly.formats.records import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = 96  # of a picture of beads
_EXACT = 256  # colours of a picture that keeps all of them


@dataclass(frozen=True)
class Table:
    """Numbers behind a figure, as texts."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure with what a reader needs who does not see it.

    Attributes:
        name: one word, as ``pydlpoly plot`` knows it.
        title: a heading.
        caption: what there is to see, in words and numbers.
        table: numbers, or None.
    """

    name: str
    title: str
    figure: Figure
    caption: str
    table: Table | None = None


def check_packages(template: bool = False) -> None:
    """Raise InputError, which says what to install, when a package that reports need is missing."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise InputError("figures need matplotlib: pip install 'pydlpoly[report]'") from None
    if template:
        try:
            import jinja2  # noqa: F401
        except ImportError:
            raise InputError("a report needs Jinja2: pip install 'pydlpoly[report]'") from None


def table_of(head: Sequence[str], columns: Sequence[FloatArray], most: int = 12) -> Table:
    """Return columns of numbers as a table of at most so many rows, the first and the last among them."""
    count = len(columns[0])
    chosen = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int)).tolist() if count else []
    rows = tuple(tuple(f"{column[k]:.5g}" if np.isfinite(column[k]) else "–" for column in columns) for k in chosen)
    return Table(tuple(head), rows)


def svg(figure: Figure, prefix: str) -> str:
    """Return a figure as an ``<svg>`` element whose ids begin with ``prefix``; pictures in it are compressed."""
    stream = io.StringIO()
    with look():
        nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        figure.savefig(stream, format="svg", dpi=200, metadata=nothing, transparent=True)
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r"<style[^>]*>.*?</style>", "", text, flags=re.DOTALL)
    text = re.sub(r"<!--.*?-->\n?", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="', f'id="{prefix}-', text)
    text = text.replace("url(#", f"url(#{prefix}-").replace('href="#', f'href="#{prefix}-')
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    return re.sub(r"data:image/png;base64,\s*([A-Za-z0-9+/=\s]+)", lambda found: _smaller(found[1]), text)


def _smaller(encoded: str) -> str:
    """The same PNG with fewer colours, as a data URI."""
    from PIL import Image

    with Image.open(io.BytesIO(base64.b64decode(encoded))) as image:
        whole = image.convert("RGBA")
    stream = io.BytesIO()
    colours, numbers = np.unique(np.asarray(whole).reshape(-1, 4), axis=0, return_inverse=True)
    if len(colours) <= _EXACT:  # as in maps, whose shades are to be what their scales say
        reduced = Image.fromarray(numbers.reshape(whole.height, whole.width).astype(np.uint8))
        reduced.putpalette(colours[:, :3].tobytes())
        reduced.save(stream, "PNG", optimize=True, transparency=colours[:, 3].tobytes())
    else:
        reduced = whole.quantize(colors=_COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        reduced.save(stream, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")
