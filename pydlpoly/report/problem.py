"""A file that is there and cannot be used."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Problem:
    """A file that is there, and why it could not be used, or not to its end."""

    file: str
    text: str


def problem_of(path: Path, error: Exception) -> Problem:
    """Return what an error of a reader says, without the file's name in front."""
    text = str(error).removeprefix(f"{path}: ")
    if text.startswith(f"{path}:"):
        text = f"line {text.removeprefix(f'{path}:')}"
    return Problem(path.name, f"cannot be read: {text.removeprefix('cannot be read: ')}")
