"""One line of an old-style CONTROL file, taken word by word."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from pydlpoly.errors import InputError, suggest
from pydlpoly.formats.control_old_tables import FILLERS, LEVELS, UNIT_NAMES, old_unit
from pydlpoly.formats.control_values import Reading, parse_number, whole
from pydlpoly.formats.keywords import KEYWORDS
from pydlpoly.formats.records import SettingValue
from pydlpoly.units import Unit, parse_unit


@dataclass
class Line:
    """One directive's words with a reading position, and the settings made of it so far."""

    reading: Reading
    number: int
    words: list[str]
    position: int = 1
    made: list[tuple[str, SettingValue, str | None]] = field(default_factory=list)

    def error(self, message: str, word: str | None = None) -> InputError:
        """Make an error that names this line."""
        return InputError(message, path=self.reading.path, line=self.number, word=word or self.words[0])

    def peek(self) -> str:
        """Return the next word in lower case, or an empty string at the end."""
        return self.words[self.position].lower() if self.position < len(self.words) else ""

    def take(self, *prefixes: str) -> bool:
        """Step over the next word if it begins with one of these."""
        if self.peek().startswith(prefixes) and self.peek():
            self.position += 1
            return True
        return False

    def rest(self) -> str:
        """Take all words that are left, as written."""
        text = " ".join(self.words[self.position :])
        self.position = len(self.words)
        return text

    def value(self, keyword: str, default: float | None = None) -> int | float:
        """Take a number for a keyword, with filler words before it and its own unit, which is optional, after it."""
        while self.peek() in FILLERS:
            self.position += 1
        if not self.peek():
            if default is None:
                raise self.error(f"a number is expected after this directive ({KEYWORDS[keyword].meaning})")
            return default
        word = self.words[self.position]
        number = _fraction(word)
        if number is None:
            raise self.error(f"a number is expected ({KEYWORDS[keyword].meaning})", word)
        self.position += 1
        self._unit(keyword)
        row = KEYWORDS[keyword]
        if row.kind in ("steps", "int") or row.dimension == "integers" or keyword in LEVELS:
            return whole(number, self.reading.path, self.number, word)
        return float(number)

    def _unit(self, keyword: str) -> None:
        """Step over the unit that the number has in any case; refuse another one, which DL_POLY would not honour."""
        implied = old_unit(keyword)
        word = UNIT_NAMES.get(self.peek(), self.words[self.position] if self.peek() else "")
        unit = parse_unit(implied) if implied and word.lower() == implied.lower() else _try_unit(word)
        if unit is None or implied is None or (self.peek() in FILLERS and self.peek() not in ("steps", "step")):
            return
        if unit != parse_unit(implied):
            message = f"the old style takes this number in {implied} whatever unit follows it; convert the number"
            raise self.error(message, self.words[self.position])
        self.position += 1

    def raw(self) -> str:
        """Return the next word as written, or an empty string at the end."""
        return self.words[self.position] if self.position < len(self.words) else ""

    def text(self, what: str) -> str:
        """Take all words that are left, of which there must be one."""
        if not self.peek():
            raise self.error(f"a text is expected after {what}")
        return self.rest()

    def put(self, keyword: str, value: SettingValue) -> None:
        """Make a setting in the unit that the old style implies."""
        plain = isinstance(value, (bool, str)) or KEYWORDS[keyword].dimension == "integers"
        self.made.append((keyword, value, None if plain else old_unit(keyword)))

    def put_number(self, keyword: str, default: float | None = None) -> None:
        """Take a number and make a setting of it."""
        self.put(keyword, self.value(keyword, default))

    def put_vector(self, keyword: str, length: int, default: float | None = None) -> None:
        """Take several numbers and make a vector setting of them."""
        self.put(keyword, tuple(self.value(keyword, default) for _ in range(length)))

    def warn(self, text: str) -> None:
        """Note something that the user should know."""
        self.reading.warnings.append(f"{self.reading.path}:{self.number}: {text}")

    def choose(self, what: str, words: dict[str, str], also: tuple[str, ...] = ()) -> str:
        """Take a word that begins with one of the keys and return the key's value; ``also`` is for the message."""
        word = self.peek()
        for prefix, value in words.items():
            if word.startswith(prefix):
                self.position += 1
                return value
        known = (*words, *also)
        if not word:
            raise self.error(f"a word is missing: {what} takes {', '.join(known)}")
        raise self.error(f"is no {what}; known are {', '.join(known)}{suggest(word, known)}", self.words[self.position])


def _fraction(word: str) -> int | float | None:
    """Read a number, which may be a simple fraction ``a/b``."""
    above, slash, below = word.partition("/")
    top = parse_number(above)
    if top is None or not slash:
        return top
    bottom = parse_number(below)
    value = top / bottom if bottom else math.inf
    return value if math.isfinite(value) else None


def _try_unit(word: str) -> Unit | None:
    try:
        return parse_unit(word) if word and parse_number(word) is None else None
    except InputError:
        return None
