"""The background writer: order, bounded memory, errors that surface, nothing lost at the end, whole after a kill."""

from __future__ import annotations

import gc
import resource
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import pydlpoly
from pydlpoly.background import BackgroundWriter
from pydlpoly.errors import RunError
from pydlpoly.formats.history import HistoryWriter, read_history
from pydlpoly.runner import run_scene

from .run_folders import run_folder


class Recorder:
    """Keeps what it is given; waits for ``go`` before each frame and fails at the frame ``bad``."""

    def __init__(self, bad: object = None) -> None:
        self.frames: list[object] = []
        self.calls: list[str] = []
        self.threads: set[int] = set()
        self.go = threading.Semaphore(0)
        self.bad = bad

    def write(self, frame: object, *, part: object = None) -> None:
        self.go.acquire()
        self.threads.add(threading.get_ident())
        if frame == self.bad:
            raise RunError(f"frame {frame} cannot be written")
        self.frames.append((frame, part))

    def sync(self) -> None:
        self.calls.append("sync")

    def close(self) -> None:
        self.calls.append("close")


def released(recorder: Recorder, count: int = 100) -> Recorder:
    recorder.go.release(count)
    return recorder


def test_frames_come_in_order_from_another_thread() -> None:
    recorder = released(Recorder())
    writer = BackgroundWriter(recorder)
    for k in range(20):
        writer.write(k, part=-k)
    writer.close()
    writer.close()
    assert recorder.frames == [(k, -k) for k in range(20)]
    assert recorder.threads.isdisjoint({threading.get_ident()})
    with pytest.raises(ValueError, match="the file is closed"):
        writer.write(0)


def test_a_full_queue_makes_the_caller_wait() -> None:
    recorder = Recorder()
    writer = BackgroundWriter(recorder, waiting=2)
    handed: list[int] = []

    def produce() -> None:
        for k in range(6):
            writer.write(k)
            handed.append(k)

    producer = threading.Thread(target=produce)
    producer.start()
    time.sleep(0.2)
    assert handed == [0, 1, 2], "one is being written and two wait"
    recorder.go.release(1)
    time.sleep(0.2)
    assert handed == [0, 1, 2, 3]
    released(recorder)
    producer.join()
    writer.close()
    assert [frame for frame, _ in recorder.frames] == list(range(6))


def test_sync_waits_for_the_frames() -> None:
    recorder = Recorder()
    writer = BackgroundWriter(recorder, waiting=3)
    for k in range(3):
        writer.write(k)
    threading.Timer(0.1, released, [recorder]).start()
    writer.sync()
    assert len(recorder.frames) == 3
    assert recorder.calls == ["sync"]
    writer.close()
    assert recorder.calls == ["sync", "close"]


@pytest.mark.parametrize("call", ["write", "sync", "close"])
def test_an_error_is_raised_by_the_next_call(call: str) -> None:
    recorder = released(Recorder(bad=1))
    writer = BackgroundWriter(recorder, waiting=4)
    for k in range(4):
        writer.write(k)
        if k == 0:
            recorder.go.release()
    while writer._queue.unfinished_tasks:
        time.sleep(0.001)
    with pytest.raises(RunError, match="frame 1 cannot be written"):
        getattr(writer, call)(*([9] if call == "write" else []))
    assert recorder.frames == [(0, None)], "no frame follows the one that failed"
    writer.close()
    assert recorder.calls[-1] == "close"


def test_a_forgotten_writer_writes_what_it_was_given() -> None:
    recorder = Recorder()
    writer = BackgroundWriter(recorder)
    queue = writer._queue
    writer.write(1)
    del writer
    gc.collect()
    recorder.go.release()
    queue.join()
    assert recorder.frames == [(1, None)]


PROGRAM = """
import sys, time
import numpy as np
from pydlpoly.background import BackgroundWriter
from pydlpoly.formats.history import HistoryWriter

n = 20000
inner = HistoryWriter(sys.argv[1], "beads", 0, 1, ["W"] * n, np.ones(n), np.zeros(n))
writer = BackgroundWriter(inner)
rng = np.random.default_rng(1)
for step in range(int(sys.argv[2])):
    writer.write(step, 0.0, 0.01, np.eye(3), rng.random((n, 3)))
    if step == 2:
        print("begun", flush=True)
"""


def test_a_program_that_ends_without_close_loses_nothing(tmp_path: Path) -> None:
    subprocess.run([sys.executable, "-c", PROGRAM, str(tmp_path / "HISTORY"), "5"], check=True, cwd=tmp_path)
    assert [frame.step for frame in read_history(tmp_path / "HISTORY")] == [0, 1, 2, 3, 4]


def test_a_kill_leaves_whole_frames(tmp_path: Path) -> None:
    path = tmp_path / "HISTORY"
    command = [sys.executable, "-c", PROGRAM, str(path), "100000"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=tmp_path) as program:
        assert program.stdout is not None
        program.stdout.readline()
        time.sleep(0.3)
        program.send_signal(signal.SIGKILL)
    n = 20000
    with HistoryWriter(path, "beads", 0, 1, ["W"] * n, [1.0] * n, [0.0] * n, append=True) as writer:
        kept = writer.frames
    steps = [frame.step for frame in read_history(path)]
    assert steps == list(range(kept))
    assert kept >= 1


def test_a_full_disk_stops_the_run_before_the_checkpoint(tmp_path: Path) -> None:
    """A file-size limit stands in for a full disk; the checkpoint must not count on frames that are not there."""
    run_folder(tmp_path, {"traj_interval": "1 steps", "data_dump_frequency": "20 steps"})
    scene = pydlpoly.load(tmp_path)
    frame = (4 + 2 * scene.bead_count) * 73
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    previous = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(5.5 * frame), hard))
    try:
        with pytest.raises(RunError, match=r"HISTORY: cannot be written: File too large"):
            run_scene(scene, tmp_path / "out", threads=1)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, previous)
    frames = list(read_history(tmp_path / "out" / "HISTORY"))
    assert [f.step for f in frames] == list(range(len(frames)))
    assert 0 < len(frames) <= 5
    assert not (tmp_path / "out" / "REVIVE").exists()
