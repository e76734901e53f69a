"""How many steps a simulation takes at once: as many as an interrupt may wait for."""

from __future__ import annotations

_SECONDS_PER_CHUNK = 0.2  # how long Ctrl-C may wait in scenes of usual size
_STEPS_PER_CHUNK = 20  # at least, unless they take longer than
_LONGEST_CHUNK = 20.0  # seconds


class Pace:
    """The rate of steps, from the chunks taken so far.

    Attributes:
        rate: steps per second of the last tenths of a second in which steps were taken, 0 before the first.
    """

    def __init__(self) -> None:
        self.rate = 0.0

    def took(self, steps: int, seconds: float) -> None:
        """Take note of a chunk."""
        # A chunk that a report cut short, or that the machine held up, says little about the next one.
        weight = 1.0 if self.rate == 0.0 else seconds / (seconds + _SECONDS_PER_CHUNK)
        self.rate += weight * (steps / seconds - self.rate)

    def chunk(self) -> int:
        """Return the number of steps to take next, 1 or more."""
        # A chunk's ends cost as much as a step or two. Large scenes take several steps all the same, while an interrupt
        # still waits no longer than twenty seconds, and a second one does not wait.
        several = min(_STEPS_PER_CHUNK, int(self.rate * _LONGEST_CHUNK))
        return max(1, int(self.rate * _SECONDS_PER_CHUNK), several)
