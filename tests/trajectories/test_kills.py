"""A kill at any moment leaves every finished frame, and a writer that goes on continues after the last of them."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

from pydlpoly.formats.atomic import FrameFile
from pydlpoly.trajectories import FORMATS, h5md, open_writer, read
from pydlpoly.trajectories.hdf5_flags import clear_open_flags, lookup3

from .frames import frames, topology

BEADS = 4000
PROGRAM = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
import itertools
from frames import frames, topology
from pydlpoly.trajectories import open_writer
name, path, first = sys.argv[1], sys.argv[2], int(sys.argv[3])
made = frames(1, beads={BEADS})[0]
keep = 10 * first - 10 if first else None
with open_writer(name, path, made, topology({BEADS}), append=first > 0, keep_until=keep) as writer:
    for k in itertools.count(first):
        (frame,) = frames(1, beads={BEADS}, first=k)
        writer.write(frame)
        print(k, flush=True)
"""


def killed_writer(name: str, path: Path, first: int, delay: float) -> int:
    """Write frames from number ``first`` on in another process, kill it, and return how many it said are finished."""
    line = [sys.executable, "-c", PROGRAM, name, str(path), str(first)]
    with subprocess.Popen(line, stdout=subprocess.PIPE, text=True, cwd=path.parent) as process:
        assert process.stdout is not None
        said = [process.stdout.readline()]  # begin to count when the first frame is there
        time.sleep(delay)
        os.kill(process.pid, signal.SIGKILL)
        said += process.stdout.readlines()
        assert process.wait() == -signal.SIGKILL
    return max(int(word) for word in said if word.endswith("\n")) + 1


@pytest.mark.parametrize("name", FORMATS)
def test_killed_and_continued(tmp_path: Path, name: str) -> None:
    file = tmp_path / f"file{FORMATS[name].extension}"
    moments = random.Random(3)
    finished = 0
    for _ in range(4):
        finished = killed_writer(name, file, finished, moments.uniform(0.0, 0.2))
        with pytest.warns() if name == "history" and cut_short(file) else nothing():
            steps = [frame.step for frame in read(file)]
        assert steps[:finished] == [10 * k for k in range(finished)]
        assert len(steps) <= finished + 1  # the last one may not have been announced any more
    like = frames(1, beads=BEADS)[0]
    with open_writer(name, file, like, topology(BEADS), append=True, keep_until=10 * finished - 10) as writer:
        (last,) = frames(1, beads=BEADS, first=finished)
        writer.write(last)
    found = list(read(file))
    assert [frame.step for frame in found] == [10 * k for k in range(finished + 1)]
    for frame in (found[0], found[finished // 2], found[-1]):
        (expected,) = frames(1, beads=BEADS, first=frame.step // 10)
        np.testing.assert_allclose(frame.positions, expected.positions, atol=1e-6)


def cut_short(file: Path) -> bool:
    return (file.stat().st_size - 146) % (73 * (4 + 4 * BEADS)) != 0


class nothing:  # noqa: N801  # a context
    def __enter__(self) -> None: ...

    def __exit__(self, *_: object) -> None: ...


@pytest.mark.parametrize("name", ["extxyz", "dcd"])
@pytest.mark.parametrize("left", [1, 7, 200, 600])
def test_a_frame_that_is_cut_short(tmp_path: Path, name: str, left: int) -> None:
    """Bytes of the third frame are there, as when a kill meets one long write."""
    file = tmp_path / f"file{FORMATS[name].extension}"
    sizes = []
    with open_writer(name, file, frames(1)[0], topology()) as writer:
        for frame in frames(3):
            writer.write(frame)
            sizes.append(file.stat().st_size)
    if name == "dcd" and left == 600:
        left = sizes[2] - sizes[1] - 1
    with file.open("r+b") as handle:
        handle.truncate(sizes[1] + left)
    assert [frame.step for frame in read(file)] == [0, 10]
    with open_writer(name, file, frames(1)[0], topology(), append=True) as writer:
        writer.write(frames(1, first=2)[0])
    assert file.stat().st_size == sizes[2]
    assert [frame.step for frame in read(file)] == [0, 10, 20]


def test_dcd_counts_frames_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A kill between the frame and the header leaves a number that is one behind."""
    file = tmp_path / "file.dcd"
    with open_writer("dcd", file, frames(1)[0], topology()) as writer:
        for frame in frames(3):
            writer.write(frame)
        monkeypatch.setattr(FrameFile, "patch", lambda *_: None)
        writer.write(frames(1, first=3)[0])
    monkeypatch.undo()
    assert int.from_bytes(file.read_bytes()[8:12], "little") == 3
    with open_writer("dcd", file, frames(1)[0], topology(), append=True):
        pass
    assert int.from_bytes(file.read_bytes()[8:12], "little") == 4
    assert [frame.step for frame in read(file)] == [0, 10, 20, 30]


@pytest.mark.parametrize("calls", range(10))
def test_hdf5_at_every_point_of_a_frame(tmp_path: Path, calls: int) -> None:
    """The writer ends without closing the file, after so many of the parts of its third frame; HDF5 says it is open."""
    file = tmp_path / "file.h5md"
    with open_writer("h5md", file, frames(1)[0], topology()) as writer:
        for frame in frames(2):
            writer.write(frame)
    child = os.fork()
    if child == 0:
        try:
            die_in_frame(file, calls)
        finally:
            os._exit(1)
    assert os.waitpid(child, 0)[1] == 7 << 8
    whole = 3 if calls == 9 else 2
    with pytest.raises(OSError, match="already open"):
        h5py.File(file)
    assert [frame.step for frame in read(file)] == [0, 10, 20][:whole]
    with open_writer("h5md", file, frames(1)[0], topology(), append=True) as writer:
        with h5py.File(file) as there:  # the mark is gone, and so is the unfinished frame
            assert len(there["particles/trajectory/position/value"]) == whole
        writer.write(frames(1, first=3)[0])
    found = list(read(file))
    assert [frame.step for frame in found] == [*[0, 10, 20][:whole], 30]
    for frame in found:
        (expected,) = frames(1, first=frame.step // 10)
        np.testing.assert_array_equal(frame.positions, expected.positions)
        np.testing.assert_array_equal(frame.arrays["density"], expected.arrays["density"])


def die_in_frame(file: Path, calls: int) -> None:
    """Write the third frame and leave at once after so many datasets (9 of them: the last is the step)."""
    real, done = h5md._put, 0

    def put(*arguments: object) -> None:
        nonlocal done
        if done == calls:
            arguments[0].file.flush()  # type: ignore[attr-defined]
            os._exit(7)
        real(*arguments)
        done += 1
        assert done < 10, "a frame has more datasets than the test knows"

    h5md._put = put  # type: ignore[assignment]
    writer = open_writer("h5md", file, frames(1)[0], topology(), append=True)
    (frame,) = frames(1, first=2)
    if calls == 9:  # after the step, before the file is closed
        h5py.File.close = lambda *_: os._exit(7)
    writer.write(frame)


@pytest.mark.parametrize("calls", range(9))
def test_hdf5_while_frames_are_dropped(tmp_path: Path, calls: int) -> None:
    """The writer ends while it makes datasets shorter, after so many of the nine; the kept frame stays."""
    file = tmp_path / "file.h5md"
    with open_writer("h5md", file, frames(1)[0], topology()) as writer:
        for frame in frames(3):
            writer.write(frame)
    child = os.fork()
    if child == 0:
        try:
            die_while_dropping(file, calls)
        finally:
            os._exit(1)
    assert os.waitpid(child, 0)[1] == 7 << 8
    steps = [frame.step for frame in read(file)]
    assert steps == ([0, 10, 20] if calls == 0 else [0])
    with open_writer("h5md", file, frames(1)[0], topology(), append=True, keep_until=5) as writer:
        writer.write(frames(1, first=1)[0])
    found = list(read(file))
    assert [frame.step for frame in found] == [0, 10]
    np.testing.assert_array_equal(found[1].positions, frames(2)[1].positions)


def die_while_dropping(file: Path, calls: int) -> None:
    real, done = h5py.Dataset.resize, 0

    def resize(dataset: h5py.Dataset, *arguments: object, **words: object) -> None:
        nonlocal done
        if done == calls:
            dataset.file.flush()
            os._exit(7)
        real(dataset, *arguments, **words)
        done += 1

    h5py.Dataset.resize = resize
    open_writer("h5md", file, frames(1)[0], topology(), append=True, keep_until=5)


def test_flags_of_an_hdf5_file(tmp_path: Path) -> None:
    """The checksum is the library's own, and a file that is closed is left alone."""
    with h5py.File(tmp_path / "file", "w", libver=("v110", "v110")) as file:
        file["x"] = 1
    content = (tmp_path / "file").read_bytes()
    assert lookup3(content[:44]) == int.from_bytes(content[44:48], "little")
    assert not clear_open_flags(tmp_path / "file")
    (tmp_path / "other").write_bytes(b"something else" * 20)
    assert not clear_open_flags(tmp_path / "other")
    assert (tmp_path / "file").read_bytes() == content
