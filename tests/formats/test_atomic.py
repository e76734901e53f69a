"""Whole-file replacement and frame files under failures and kills."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import IO

import pytest

from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.atomic import FrameFile, atomic_file, read_text, replace_file

FRAME = b"0123456789ABCDEF\n"


def whole_frames(handle: IO[bytes]) -> int:
    size = len(handle.read())
    return 5 + (size - 5) // len(FRAME) * len(FRAME) if size >= 5 else 0


def test_a_replaced_file_has_the_new_content_and_leaves_nothing_else(tmp_path: Path) -> None:
    target = tmp_path / "REVCON"
    target.write_text("old")
    target.chmod(0o640)
    replace_file(target, "new\n")
    assert target.read_bytes() == b"new\n"
    assert target.stat().st_mode & 0o777 == 0o640
    assert os.listdir(tmp_path) == ["REVCON"]  # noqa: PTH208


def test_a_new_file_has_the_permissions_of_an_ordinary_one(tmp_path: Path) -> None:
    replace_file(tmp_path / "a", b"")
    (tmp_path / "b").touch()
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode


def test_an_error_while_writing_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "REVCON"
    target.write_text("old")

    def fail() -> None:
        with atomic_file(target) as handle:
            handle.write(b"half of the n")
            assert target.read_text() == "old"
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert target.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["REVCON"]


def test_a_symbolic_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    replace_file(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"


def test_the_null_device_is_written_and_not_replaced() -> None:
    replace_file("/dev/null", "gone")
    assert Path("/dev/null").is_char_device()


def test_a_missing_folder_is_a_run_error_that_names_the_file(tmp_path: Path) -> None:
    with pytest.raises(RunError, match=r"nowhere/REVCON: cannot be written: No such file"):
        replace_file(tmp_path / "nowhere" / "REVCON", "")
    with pytest.raises(RunError, match=r"nowhere/HISTORY: cannot be opened for writing"):
        FrameFile(tmp_path / "nowhere" / "HISTORY", b"")
    with pytest.raises(InputError, match="missing: cannot be read: No such file"):
        read_text(tmp_path / "missing")


def test_appending_cuts_a_torn_last_frame(tmp_path: Path) -> None:
    target = tmp_path / "frames"
    with FrameFile(target, b"HEAD\n") as file:
        file.write(FRAME)
        file.write(FRAME)
    for _ in range(2):  # cut on opening, whether or not a frame follows
        with target.open("ab") as handle:
            handle.write(FRAME[:7])
        FrameFile(target, b"HEAD\n", append=True, whole_length=whole_frames).close()
        assert target.read_bytes() == b"HEAD\n" + 2 * FRAME
    with target.open("ab") as handle:
        handle.write(FRAME[:7])
    with FrameFile(target, b"HEAD\n", append=True, whole_length=whole_frames) as file:
        assert file.resumed
        assert file.length == 5 + 2 * len(FRAME)
        file.write(FRAME)
        file.patch(0, b"tail")
        file.write(FRAME)
    assert target.read_bytes() == b"tail\n" + 4 * FRAME


def test_without_append_or_with_nothing_whole_a_file_starts_anew(tmp_path: Path) -> None:
    target = tmp_path / "frames"
    target.write_bytes(b"HEAD\n" + FRAME)
    FrameFile(target, b"NEW!\n").close()
    assert target.read_bytes() == b"NEW!\n"
    target.write_bytes(b"HE")
    with FrameFile(target, b"HEAD\n", append=True, whole_length=whole_frames) as file:
        assert not file.resumed
    assert target.read_bytes() == b"HEAD\n"


def test_a_frame_that_fails_half_way_is_taken_back(tmp_path: Path) -> None:
    """A file-size limit stands in for a full disk: the write is cut, then refused."""
    program = textwrap.dedent("""
        import resource, signal, sys
        from pydlpoly.errors import RunError
        from pydlpoly.formats.atomic import FrameFile
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        file = FrameFile(sys.argv[1], b"HEAD\\n")
        file.write(b"x" * 1000)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1500, resource.RLIM_INFINITY))
        try:
            file.write(b"y" * 1000)
        except RunError as error:
            print(error)
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        file.write(b"z" * 10)
    """)
    target = tmp_path / "frames"
    done = subprocess.run(
        [sys.executable, "-c", program, target], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert done.stdout.strip().endswith("cannot be written: File too large")
    assert target.read_bytes() == b"HEAD\n" + b"x" * 1000 + b"z" * 10


class Interrupted(io.RawIOBase):
    """Stands for a file in whose write the keyboard's interrupt arrives after half of the bytes."""

    def __init__(self, real: IO[bytes]) -> None:
        self.real, self.armed = real, True

    def write(self, content: bytes) -> int:  # type: ignore[override]
        if self.armed:
            self.armed = False
            self.real.write(content[: len(content) // 2])
            raise KeyboardInterrupt
        return self.real.write(content)

    def truncate(self, size: int | None = None) -> int:
        return self.real.truncate(size)

    def seek(self, offset: int, whence: int = 0) -> int:
        return self.real.seek(offset, whence)


def test_an_interrupt_in_the_middle_of_a_frame_takes_the_frame_back(tmp_path: Path) -> None:
    file = FrameFile(tmp_path / "frames", b"HEAD\n")
    real = file._handle
    file._handle = Interrupted(real)  # type: ignore[assignment]
    with pytest.raises(KeyboardInterrupt):
        file.write(FRAME)
    file.write(FRAME)
    real.close()
    assert (tmp_path / "frames").read_bytes() == b"HEAD\n" + FRAME


def test_appending_needs_a_way_to_find_whole_frames(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="which bytes of the existing file are whole frames"):
        FrameFile(tmp_path / "frames", b"", append=True)


def test_a_killed_program_leaves_whole_frames(tmp_path: Path) -> None:
    program = textwrap.dedent("""
        import sys
        from pydlpoly.formats.atomic import FrameFile
        file = FrameFile(sys.argv[1], b"HEAD\\n")
        for _ in range(100):
            file.write(b"0123456789ABCDEF\\n")
        print("ready", flush=True)
        while True:
            file.write(b"0123456789ABCDEF\\n")
    """)
    target = tmp_path / "frames"
    with subprocess.Popen([sys.executable, "-c", program, target], stdout=subprocess.PIPE, cwd=tmp_path) as running:
        assert running.stdout is not None
        assert running.stdout.readline() == b"ready\n"
        running.send_signal(signal.SIGKILL)
    content = target.read_bytes()
    assert len(content) >= 5 + 100 * len(FRAME)
    assert content == b"HEAD\n" + FRAME * ((len(content) - 5) // len(FRAME))
