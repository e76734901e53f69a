"""A writer that works while the simulation goes on: frames wait in a short queue for a thread that writes them."""

from __future__ import annotations

import atexit
import threading
from collections.abc import Callable
from functools import partial
from queue import Queue
from typing import Any, Protocol


class FrameWriter(Protocol):
    """What writes frames to a file, one after the other."""

    def write(self, *frame: Any, **parts: Any) -> None:
        """Append one frame."""

    def sync(self) -> None:
        """Wait until all frames are on the disk."""

    def close(self) -> None:
        """Close the file."""


class BackgroundWriter:
    """Hands frames to a writer in a thread of its own, in order.

    ``write`` returns when the frame has a place in the queue; when the queue is full it waits, so that at most
    ``waiting`` frames and the one being written are held in memory. What the writer raises is raised by the next call
    of ``write`` or ``sync``, or by ``close``; no frame is written after it. Frames that were handed over are
    written even when the program ends without ``close``; a kill leaves the frames that the writer had finished.

    Args:
        writer: used by the thread only, until ``close``.
        waiting: number of frames that may wait, at least 1.
    """

    def __init__(self, writer: FrameWriter, waiting: int = 1) -> None:
        self._writer = writer
        self._errors: list[BaseException] = []
        self._raised = False
        self._queue: Queue[Callable[[], None] | None] = Queue(waiting)
        arguments = (self._queue, self._errors)
        self._thread = threading.Thread(target=_work, args=arguments, name="frame writer", daemon=True)
        self._thread.start()
        self._open = True
        # Not when the object is forgotten: the garbage collector may call in the middle of the queue's own code.
        self._at_exit = partial(_stop, self._queue, self._thread)
        atexit.register(self._at_exit)

    def write(self, *frame: Any, **parts: Any) -> None:
        """Have one frame written. The arguments are the writer's; their arrays must not be changed afterwards."""
        self._raise()
        if not self._open:
            raise ValueError("the file is closed")
        write = self._writer.write
        self._queue.put(lambda: write(*frame, **parts))

    def sync(self) -> None:
        """Wait until all frames are on the disk."""
        self._queue.join()
        self._raise()
        self._writer.sync()

    def close(self) -> None:
        """Write what waits and close the file; closing twice is harmless.

        Raises what the writer raised, unless an earlier call has done so.
        """
        if self._open:
            self._open = False
            self._at_exit()
            atexit.unregister(self._at_exit)
        self._writer.close()
        if not self._raised:
            self._raise()

    def _raise(self) -> None:
        if self._errors:
            self._raised = True
            raise self._errors[0]


def _work(queue: Queue[Callable[[], None] | None], errors: list[BaseException]) -> None:
    while (task := queue.get()) is not None:
        if not errors:
            _attempt(task, errors)
        del task  # its arrays are not held while the queue is empty
        queue.task_done()
    queue.task_done()


def _attempt(task: Callable[[], None], errors: list[BaseException]) -> None:
    try:
        task()
    except BaseException as error:  # kept for the thread that asked for the frame
        errors.append(error)


def _stop(queue: Queue[Callable[[], None] | None], thread: threading.Thread) -> None:
    queue.put(None)
    thread.join()
