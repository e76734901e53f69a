"""Some frames of a HISTORY file, spread over it, without reading those in between."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pydlpoly.errors import InputWarning
from pydlpoly.formats.atomic import PathLike
from pydlpoly.formats.history import RECORD_BYTES, frame_records
from pydlpoly.formats.history_reader import Frame, read_history, read_history_header, read_history_lines
from pydlpoly.formats.records import IntArray


@dataclass(frozen=True, eq=False)
class HistorySample:
    """Frames of a HISTORY file.

    Attributes:
        frames: those taken, the last one of the file among them.
        count: number of whole frames in the file.
        cut: what was wrong with the file in words, such as a last frame that a kill cut short; empty when nothing was.
    """

    frames: tuple[Frame, ...]
    count: int
    cut: str = ""


def sample_history(path: PathLike, most: int) -> HistorySample:
    """Return at most so many frames of a HISTORY file at equal distances, the last one among them.

    In files of DL_POLY's fixed records the frames in between are skipped; other files are read from end to end.

    Raises:
        InputError: the file is missing, is not a HISTORY file, or is damaged; ValueError: ``most`` is below 1.
    """
    if most < 1:
        raise ValueError(f"at least one frame must be taken, not {most}")
    places = _places(Path(path))
    if places is None:
        return _all_through(path, most)
    starts, cut = places
    frames = []
    with Path(path).open("rb") as handle:
        head = handle.read(2 * RECORD_BYTES)
        for start, end in starts[chosen(len(starts), most)].tolist():
            handle.seek(start)
            text = (head + handle.read(end - start)).decode("latin-1")
            frames += list(read_history_lines(io.StringIO(text), str(path)))
    return HistorySample(tuple(frames), len(starts), cut)


def chosen(count: int, most: int) -> list[int]:
    """Return at most ``most`` of the numbers 0 … count − 1 at equal distances, the last among them."""
    every = -(-count // most)
    return list(range(count - 1, -1, -every))[::-1] if count else []


def _places(path: Path) -> tuple[IntArray, str] | None:
    """Beginning and end of each frame of a file of fixed records, and what is wrong; None when it is no such file."""
    header = read_history_header(path)
    size = path.stat().st_size
    if header.level not in (0, 1, 2) or header.beads < 1:
        return None
    frame = RECORD_BYTES * frame_records(header.beads, header.level)
    count, rest = divmod(size - 2 * RECORD_BYTES, frame)
    with path.open("rb") as handle:
        for number in range(count):
            handle.seek(2 * RECORD_BYTES + number * frame)
            first = handle.read(RECORD_BYTES)
            if not first.startswith(b"timestep") or first[18:28].strip() != str(header.beads).encode():
                return None
        handle.seek(0)
        lines = handle.read(2 * RECORD_BYTES).split(b"\n")
    if [len(line) for line in lines] != [RECORD_BYTES - 1, RECORD_BYTES - 1, 0] or count < 0:
        return None
    starts = 2 * RECORD_BYTES + frame * np.arange(count)
    cut = f"a frame is cut short after the first {count}" if rest else ""
    return np.stack([starts, starts + frame], axis=1), cut


def _all_through(path: PathLike, most: int) -> HistorySample:
    """Read every frame, and keep fewer and fewer as there are more."""
    kept: list[tuple[int, Frame]] = []
    every, count, last = 1, 0, None
    with _warnings() as seen:
        for frame in read_history(path):
            last = frame
            if count % every == 0:
                kept.append((count, frame))
            count += 1
            if len(kept) > 2 * most:
                every *= 2
                kept = [(number, frame) for number, frame in kept if number % every == 0]
    if last is not None and kept[-1][0] != count - 1:
        kept.append((count - 1, last))
    frames = tuple(kept[k][1] for k in chosen(len(kept), most))
    told = (text.replace(f"{path}:", "line ", 1) for text in seen)
    return HistorySample(frames, count, "; ".join(told))


@contextmanager
def _warnings() -> Iterator[list[str]]:
    """Collect the reader's warnings as texts."""
    texts: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield texts
    texts += [str(one.message) for one in caught if issubclass(one.category, InputWarning)]
