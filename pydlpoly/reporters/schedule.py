"""In which steps a reporter is due."""

from __future__ import annotations


def every(step: int, interval: int, start: int = 0) -> int | None:
    """Return the first step after ``step`` of the form start + k·interval, or None when the interval is 0."""
    if interval <= 0:
        return None
    if step < start:
        return start
    return start + ((step - start) // interval + 1) * interval
