"""HISTORY as one of the trajectory formats; the file itself is the business of ``pydlpoly.formats``."""

from __future__ import annotations

from collections.abc import Iterator

from pydlpoly.errors import InputError
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.history import HistoryWriter, read_history, read_history_header
from pydlpoly.formats.history_sample import HistorySample, sample_history
from pydlpoly.trajectories import base


class Writer(base.Writer):
    """HISTORY of the level of the frames; images, links and arrays of beads have no place in it."""

    def __init__(
        self,
        path: str,
        like: Frame,
        topology: base.Topology,
        *,
        append: bool = False,
        keep_until: int | None = None,
    ) -> None:
        super().__init__(path, like)
        if not (base.known(like.masses) and base.known(like.charges)):
            raise InputError("HISTORY needs the masses and charges of all beads, which the frames do not give")
        self._level = 0 if like.velocities is None else 1 if like.forces is None else 2
        self._file = HistoryWriter(
            path,
            topology.title,
            self._level,
            like.imcon,
            like.names,
            like.masses,
            like.charges,
            append=append,
            keep_until=keep_until,
        )

    def write(self, frame: Frame) -> None:
        """Append one frame."""
        self.check(frame)
        time = frame.time if frame.time is not None else frame.step * (frame.timestep or 0.0)
        moved = frame.displacements if base.known(frame.displacements) else None
        self._file.write(
            frame.step,
            time,
            frame.timestep or 0.0,
            frame.cell,
            frame.positions,
            velocities=frame.velocities if self._level >= 1 else None,
            forces=frame.forces if self._level >= 2 else None,
            displacements=moved,
        )

    def sync(self) -> None:
        """Wait until all frames are on the disk."""
        self._file.sync()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class Reader(base.Reader):
    """HISTORY of any of its kinds, see ``read_history``."""

    def __init__(self, path: str) -> None:
        super().__init__(path)
        self.topology = base.Topology(title=read_history_header(path).title)

    def __iter__(self) -> Iterator[Frame]:
        """Iterate over the frames."""
        return read_history(self.path)

    def sample(self, most: int) -> HistorySample:
        """Return at most so many frames at equal distances, the last one among them."""
        return sample_history(self.path, most)
