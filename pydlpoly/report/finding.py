"""What one check found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Level = Literal["warning", "note", "fine", "unknown"]


@dataclass(frozen=True)
class Finding:
    """What one check found.

    Attributes:
        level: "warning" (the results may be wrong or incomplete), "note", "fine", or "unknown" (could not be judged).
        subject: two or three words.
        text: one sentence with numbers.
        advice: what to do about it, with commands in backticks; empty when there is nothing to do.
    """

    level: Level
    subject: str
    text: str
    advice: str = ""


def unknown(subject: str, text: str, keyword: str = "") -> Finding:
    """Return that something could not be judged, and which keyword would have it recorded."""
    return Finding("unknown", subject, text, f"{keyword} in CONTROL switches it on" if keyword else "")
