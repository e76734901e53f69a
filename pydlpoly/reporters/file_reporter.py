"""What reporters with one open file have in common."""

from __future__ import annotations

from typing import Generic, Protocol, TypeVar


class _Writer(Protocol):
    def sync(self) -> None: ...

    def close(self) -> None: ...


_W = TypeVar("_W", bound=_Writer)


class FileReporter(Generic[_W]):
    """A reporter that hands what it reports to ``_writer``. Both methods raise RunError when that cannot be written."""

    _writer: _W

    def sync(self) -> None:
        """Wait until everything written so far is on the disk."""
        self._writer.sync()

    def close(self) -> None:
        """Write what waits and close the file."""
        self._writer.close()
