"""Files that survive a kill: whole-file replacement in one instant, and files that grow by whole frames."""

from __future__ import annotations

import os
import secrets
import stat
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import IO, TypeVar

from pydlpoly.errors import InputError, RunError

try:
    import fcntl
except ImportError:  # systems that are not POSIX
    fcntl = None  # type: ignore[assignment]

PathLike = str | os.PathLike[str]
_Self = TypeVar("_Self")


@contextmanager
def atomic_file(path: PathLike) -> Iterator[IO[bytes]]:
    """Open a binary file for writing that takes the place of ``path`` only when the block ends without an error.

    The bytes go to a temporary file in the same folder, are flushed to the disk and moved over the old file in one
    step; until then, and after any error, the old file is untouched. A symbolic link stays a link. A target that is
    not a regular file (a pipe, a terminal, the null device) cannot be replaced and is written directly.

    Raises:
        RunError: the file or its folder cannot be written.
    """
    target = Path(os.path.realpath(path))
    try:
        if target.exists() and not stat.S_ISREG(target.stat().st_mode):
            with target.open("wb") as handle:
                yield handle
            return
        temporary = target.with_name(f".{target.name}.{secrets.token_hex(6)}.tmp")
        mode = stat.S_IMODE(target.stat().st_mode) if target.exists() else None
        try:
            with temporary.open("xb") as handle:
                if mode is not None:
                    temporary.chmod(mode)
                yield handle
                handle.flush()
                os.fsync(handle.fileno())
            temporary.replace(target)
        except BaseException:
            with suppress(OSError):
                temporary.unlink()
            raise
        _sync_folder(target.parent)
    except OSError as error:
        raise RunError(f"{os.fspath(path)}: cannot be written: {error.strerror or error}") from error


def replace_file(path: PathLike, content: bytes | str) -> None:
    """Replace a whole file in one instant (see ``atomic_file``); text is encoded as UTF-8 with the given line ends.

    Raises:
        RunError: the file or its folder cannot be written.
    """
    with atomic_file(path) as handle:
        handle.write(content.encode("utf-8") if isinstance(content, str) else content)


class Closing(ABC):
    """Something that is closed at the end of a ``with`` block, whatever happens in it."""

    @abstractmethod
    def close(self) -> None:
        """Close it; closing twice is harmless."""

    def __enter__(self: _Self) -> _Self:
        """Return what is open."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()


class FrameFile(Closing):
    """A file that grows by whole frames: each frame is one write, so that a killed run leaves whole frames behind.

    Args:
        path: the file.
        header: bytes at the start of a new file.
        append: go on with an existing file (a missing or empty one is started anew).
        whole_length: for ``append``: given the open file, how many of its bytes to keep, which excludes a frame that a
            kill cut short. Returning 0 starts the file anew.

    Raises:
        RunError: the file cannot be opened or written; a frame that fails half-way (disk full) is taken back first.
        InputError: raised by ``whole_length`` when the existing file is not what it should be.
    """

    def __init__(
        self,
        path: PathLike,
        header: bytes,
        *,
        append: bool = False,
        whole_length: Callable[[IO[bytes]], int] | None = None,
    ) -> None:
        """Open the file; see the class."""
        if append and whole_length is None:
            raise ValueError("appending needs to know which bytes of the existing file are whole frames")
        self.path = os.fspath(path)
        target = Path(path)
        try:
            kept = 0
            if append and whole_length is not None and target.exists():
                with target.open("rb") as existing:
                    kept = whole_length(existing)
            # Unbuffered: a frame is either handed to the operating system or it is not.
            self._handle = target.open("r+b" if kept else "wb", buffering=0)
            self._length = kept
            if kept:
                self._handle.truncate(kept)
                self._handle.seek(kept)
        except OSError as error:
            raise RunError(f"{self.path}: cannot be opened for writing: {error.strerror or error}") from error
        self.resumed = kept > 0
        if not kept:
            self.write(header)

    @property
    def length(self) -> int:
        """Number of bytes in whole frames, header included."""
        return self._length

    def write(self, frame: bytes) -> None:
        """Append one whole frame."""
        try:
            _write_all(self._handle, frame)
            self._length += len(frame)
        except BaseException as error:  # an interrupt from the keyboard can cut a long frame, too
            with suppress(OSError):
                self._handle.truncate(self._length)
                self._handle.seek(self._length)
            if isinstance(error, OSError):
                raise RunError(f"{self.path}: cannot be written: {error.strerror or error}") from error
            raise

    def patch(self, offset: int, content: bytes) -> None:
        """Overwrite bytes in the middle of the file, for counters in a header."""
        try:
            try:
                self._handle.seek(offset)
                _write_all(self._handle, content)
            finally:
                self._handle.seek(self._length)
        except OSError as error:
            raise RunError(f"{self.path}: cannot be written: {error.strerror or error}") from error

    def sync(self) -> None:
        """Wait until everything written is on the disk, as before a checkpoint that counts on it."""
        with suppress(OSError):  # pipes and terminals cannot be synchronised
            os.fsync(self._handle.fileno())

    def close(self) -> None:
        """Close the file; closing twice is harmless."""
        self._handle.close()


class RecordWriter(Closing):
    """A writer of a file of records or frames, ``_file``."""

    _file: FrameFile

    def sync(self) -> None:
        """Wait until everything written is on the disk."""
        self._file.sync()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def read_text(path: PathLike) -> str:
    """Return a text file's content; bytes that are not UTF-8 are kept as Latin-1, since only titles can hold them.

    Raises:
        InputError: the file is missing or cannot be read.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", path=os.fspath(path)) from error
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _write_all(handle: IO[bytes], content: bytes) -> None:
    view = memoryview(content)
    while view:
        written = handle.write(view)
        view = view[written:]


def _sync_folder(folder: Path) -> None:
    """Make the new name itself durable, where the system can do so."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


@contextmanager
def sole_writer(folder: PathLike) -> Iterator[None]:
    """Keep other runs from writing into a folder until the block, or the process, ends.

    The lock is the system's, on the folder itself: no file stays behind, not even after a kill. File systems without
    such locks hold nobody off.

    Raises:
        InputError: another run holds the folder.
    """
    if fcntl is None:
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            told = "another run is writing into this folder; wait for its end, or give this one a folder of its own"
            raise InputError(told, path=os.fspath(folder)) from None
        except OSError:
            pass
        yield
    finally:
        os.close(handle)
