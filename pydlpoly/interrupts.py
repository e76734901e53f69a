"""Ctrl-C and SIGTERM that wait for a moment at which a run can be continued."""

from __future__ import annotations

import signal
import threading
import time as clock
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

# Wrappers forward the same Ctrl-C once more within milliseconds; only a person comes back after a second.
_SECONDS_UNTIL_IMPATIENT = 1.0


@contextmanager
def deferred_signals(action: Callable[[], None], signals: Sequence[int] = (signal.SIGINT,)) -> Iterator[None]:
    """Call ``action`` for the first of ``signals`` instead of interrupting whatever runs at that moment.

    A second SIGINT, a second or more after the first, raises KeyboardInterrupt at once: nothing that hangs may lock
    its user out. Signals that are ignored or have a handler of their own keep it; outside the main thread, where
    Python allows no handlers, nothing changes.

    Args:
        action: what to do; it runs between two instructions of the main thread.
        signals: numbers of the signals.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    first: list[float] = []

    def handle(number: int, _frame: FrameType | None) -> None:
        if first and number == signal.SIGINT and clock.monotonic() - first[0] >= _SECONDS_UNTIL_IMPATIENT:
            raise KeyboardInterrupt
        first.append(clock.monotonic())
        action()

    ours = (signal.default_int_handler, signal.SIG_DFL)
    previous = {number: signal.getsignal(number) for number in signals if signal.getsignal(number) in ours}
    for number in previous:
        signal.signal(number, handle)
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
