"""CONTROL's settings as the scene reads them: in internal units, with defaults, and with a record of what was read.

No keyword can be read from a file and forgotten: ``Settings.finish`` looks at every setting that no one asked for and
refuses it, notes it as ignored with the reason, or notes that it has no effect in this scene.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydlpoly.errors import SceneError
from pydlpoly.formats.control import effect_of, value_in
from pydlpoly.formats.keywords import KEYWORDS
from pydlpoly.formats.records import Control, Setting, SettingValue
from pydlpoly.scene.model import Note

# The scene judges these itself, with the beads or the alternatives in sight.
_JUDGED_BY_SCENE = ("ensemble", "ensemble_method", "ensemble_dpd_order", "coul_method")


class Notes:
    """Collects what the user should know, in the order in which it is met."""

    def __init__(self) -> None:
        """Start without notes."""
        self._notes: dict[Note, None] = {}  # in order, each once

    def warning(self, text: str, where: str = "") -> None:
        """Add something that could change results."""
        self._add("warning", text, where)

    def ignored(self, text: str, where: str = "") -> None:
        """Add something that was read and has no effect here."""
        self._add("ignored", text, where)

    def choice(self, text: str, where: str = "") -> None:
        """Add a default that was taken or a decision that the files leave open."""
        self._add("choice", text, where)

    def _add(self, kind: Literal["warning", "ignored", "choice"], text: str, where: str) -> None:
        self._notes[Note(kind, text, where)] = None

    def all(self) -> tuple[Note, ...]:
        """Return the notes so far."""
        return tuple(self._notes)


class Settings:
    """A CONTROL file whose settings are asked for by name; remembers which were.

    ``consumed`` holds every keyword that was asked for, whether the file gives it or not.
    """

    def __init__(self, control: Control) -> None:
        """Take the record of a CONTROL file."""
        self._control = control
        self.path, self.style = control.path, control.style
        self.consumed: set[str] = set()

    def setting(self, keyword: str) -> Setting | None:
        """Return the setting as written, or None when the file does not give it; does not count as asking for it."""
        return self._control.get(keyword)

    def given(self, keyword: str) -> bool:
        """Return whether the file gives this keyword; does not count as asking for it."""
        return self._control.get(keyword) is not None

    def number(self, keyword: str) -> float:
        """Return a number in internal units."""
        return float(self._value(keyword))  # type: ignore[arg-type]  # the keyword table says it is a number

    def number_if_given(self, keyword: str, otherwise: float) -> float:
        """Return a number in internal units where the file gives it; the table's default may need what is not there."""
        self.consumed.add(keyword)
        return self.number(keyword) if self.given(keyword) else otherwise

    def steps(self, keyword: str) -> int:
        """Return a number of steps; times are divided by the timestep."""
        return int(self._value(keyword))  # type: ignore[arg-type]  # as above

    def integer(self, keyword: str) -> int:
        """Return a whole number."""
        return int(self._value(keyword))  # type: ignore[arg-type]  # as above

    def switch(self, keyword: str) -> bool:
        """Return whether a switch is on."""
        return bool(self._value(keyword))

    def word(self, keyword: str) -> str:
        """Return an option's word in lower case, empty when the file gives none and there is no default."""
        row = KEYWORDS[keyword]
        if not (self.given(keyword) or row.default or row.required):
            self.consumed.add(keyword)
            return ""
        return str(self._value(keyword)).lower()

    def text(self, keyword: str) -> str:
        """Return a string as written, for example a file's name."""
        return str(self._value(keyword))

    def vector(self, keyword: str) -> tuple[float, ...]:
        """Return the numbers of a vector."""
        value = self._value(keyword)
        return value if isinstance(value, tuple) else (float(value),)

    def file_name(self, keyword: str) -> str | None:
        """Return the name of an output file, None for NONE (not written), SCREEN in capitals however it is written."""
        name = self.text(keyword)
        if name.upper() in ("NONE", "SCREEN"):
            return None if name.upper() == "NONE" else "SCREEN"
        return name

    def where(self, keyword: str) -> str:
        """Return ``CONTROL:7``, or the file's name when the keyword has its default."""
        return place(self.path, self._line(keyword))

    def refusal(self, keyword: str, message: str) -> SceneError:
        """Return the error that names the file, the line and the keyword."""
        return SceneError(message, path=self.path, line=self._line(keyword), word=keyword)

    def refuse_unmodelled(self) -> None:
        """Raise SceneError for the first setting whose keyword or option is refused."""
        for setting in self._control:
            if setting.keyword in _JUDGED_BY_SCENE:
                continue
            effect = effect_of(setting)
            if effect.kind == "refused":
                message = f"{_as_written(setting)} is not modelled: {effect.reason}"
                raise self.refusal(setting.keyword, message)

    def finish(self, notes: Notes) -> None:
        """Note every setting that is ignored by rule, or that nothing in this scene asked for."""
        for setting in self._control:
            effect = effect_of(setting)
            where = self.where(setting.keyword)
            if effect.kind == "ignored":
                notes.ignored(f"{_as_written(setting)}: {effect.reason}", where)
            elif setting.keyword not in self.consumed:
                notes.ignored(f"{_as_written(setting)}: nothing in this scene uses it", where)

    def _value(self, keyword: str) -> SettingValue:
        self.consumed.add(keyword)
        return value_in(self._control, keyword)

    def _line(self, keyword: str) -> int | None:
        setting = self._control.get(keyword)
        return setting.line or None if setting is not None else None


def place(path: str, line: int | None) -> str:
    """Return ``FIELD:18`` for tables and notes: the file's name without its folder, and the line where there is one."""
    name = Path(path).name
    return f"{name}:{line}" if line else name


def places(path: str, lines: list[int]) -> str:
    """Return ``FIELD:12-16, FIELD:19`` for line numbers, runs of them in short."""
    runs: list[list[int]] = []
    for line in sorted(lines):
        if runs and line == runs[-1][1] + 1:
            runs[-1][1] = line
        else:
            runs.append([line, line])
    return ", ".join(place(path, a) + (f"-{b}" if b > a else "") for a, b in runs)


def _as_written(setting: Setting) -> str:
    value = setting.value
    if isinstance(value, bool):
        text = "on" if value else "off"
    elif isinstance(value, tuple):
        text = "[ " + " ".join(f"{x:g}" for x in value) + " ]"
    else:
        text = f"{value:g}" if isinstance(value, float) else str(value)
    return " ".join(part for part in (setting.keyword, text, setting.unit) if part)
