"""The package's own exceptions: every failure a user can cause is one of these, with its place and its cure."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class PydlpolyError(Exception):
    """Base of every error that pydlpoly raises on purpose."""


class InputError(PydlpolyError):
    """A file cannot be read as what it claims to be.

    The text is ``file:line: 'word': message`` (line and word left out where they have no meaning).

    Args:
        message: what is wrong and what was expected.
        path: the file's name as the user gave it.
        line: line number counted from 1, or None when the whole file is meant.
        word: the offending word exactly as written, or None.
    """

    def __init__(self, message: str, *, path: str = "", line: int | None = None, word: str | None = None) -> None:
        self.message, self.path, self.line, self.word = message, path, line, word
        place = path + (f":{line}" if line is not None else "")
        parts = [place] if place else []
        if word is not None:
            parts.append(repr(word))
        super().__init__(": ".join([*parts, message]))


class SceneError(InputError):
    """The files can be read, but what they ask for is contradictory, incomplete or not modelled."""


class RunError(PydlpolyError):
    """A running simulation had to stop; the text names the step, the beads and the cause."""


class InputWarning(UserWarning):
    """Something in an input file is odd, was understood, and deserves to be known."""


def suggest(word: str, valid: Iterable[str]) -> str:
    """Return ``"; did you mean a, b?"`` with the nearest valid words, or an empty string when none is near."""
    # Compared without regard to case, given back as written: species names are case-sensitive.
    words = [str(v) for v in valid]
    close = difflib.get_close_matches(word.lower(), [w.lower() for w in words], n=3, cutoff=0.6)
    nearest = dict.fromkeys(w for c in close for w in words if w.lower() == c)
    return f"; did you mean {', '.join(nearest)}?" if nearest else ""
