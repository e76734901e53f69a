"""The block ``extension transport`` of FIELD: dissolved species, what moves them between beads, and what makes them.

::

    extension transport
    species sugar salt
    pair W W sugar kappa 1.0 range 1.58 exponent 2.0 noise 1e-5
    noise sqrt
    start sugar 1.0
    start sugar 2.0 in W
    source sugar 0.01 box -5.0 5.0 0.0 * * *
    hold sugar 1.0 in WALL
    reaction 0.5 sugar -> salt
    reaction 2.0 sugar + salt -> 2 salt
    end extension
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal, NoReturn

from pydlpoly.errors import InputError, suggest
from pydlpoly.formats.lexing import parse_number
from pydlpoly.formats.records import Extension

Noise = Literal["sqrt", "lammps", "off"]
RegionKind = Literal["everywhere", "in", "box", "sphere"]

NOISES: tuple[Noise, ...] = ("sqrt", "lammps", "off")
"""How the random flux depends on the concentrations: √(C_i + C_j), C_i + C_j as in LAMMPS, or not at all."""

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_RESERVED = ("none", "in", "box", "sphere")
_MOST_ORDER = 2
_FLUX_NUMBERS = {"kappa": None, "range": None, "exponent": 2.0, "noise": 0.0}


@dataclass(frozen=True)
class RegionWords:
    """Where something is.

    Attributes:
        kind: "everywhere", "in" (the beads of ``species``), "box" or "sphere".
        numbers: x0 x1 y0 y1 z0 z1, infinite where the file has ``*``, or x y z radius; Å.
    """

    kind: RegionKind = "everywhere"
    species: str = ""
    numbers: tuple[float, ...] = ()


@dataclass(frozen=True)
class FluxLine:
    """``pair A B SPECIES kappa … range … exponent … noise …``; both bead species ``*``: every pair not named."""

    species: tuple[str, str]
    dissolved: str
    kappa: float
    range: float
    exponent: float
    noise: float
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class ValueLine:
    """``start``, ``source`` or ``hold``: a dissolved species, a number, and where."""

    dissolved: str
    value: float
    region: RegionWords
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class ReactionLine:
    """``reaction K 2 a + b -> c in W``: (count, name) on both sides, and the bead species or an empty name."""

    rate: float
    left: tuple[tuple[int, str], ...]
    right: tuple[tuple[int, str], ...]
    species: str = ""
    line: int = field(default=0, compare=False)

    @property
    def equation(self) -> str:
        """The two sides in words."""

        def side(terms: tuple[tuple[int, str], ...]) -> str:
            return " + ".join(name if count == 1 else f"{count} {name}" for count, name in terms) or "none"

        return f"{side(self.left)} -> {side(self.right)}"


@dataclass(frozen=True)
class TransportBlock:
    """The whole block, in the file's words; lengths in Å, rates in 1/ps, amounts in a unit of the user's."""

    species: tuple[str, ...]
    fluxes: tuple[FluxLine, ...] = ()
    starts: tuple[ValueLine, ...] = ()
    sources: tuple[ValueLine, ...] = ()
    holds: tuple[ValueLine, ...] = ()
    reactions: tuple[ReactionLine, ...] = ()
    noise: Noise = "sqrt"
    noise_line: int = field(default=0, compare=False)
    line: int = field(default=0, compare=False)


def read_transport(extension: Extension, path: str) -> TransportBlock:
    """Return the records of a block ``extension transport``.

    Raises:
        InputError: a line that cannot be read; the text gives file, line, word and what was expected.
    """
    return _Parser(extension, path).block()


class _Parser:
    def __init__(self, extension: Extension, path: str) -> None:
        self.path, self.extension = path, extension
        self.line, self.words = extension.line, ["extension"]
        self.species: tuple[str, ...] = ()
        self.fluxes: list[FluxLine] = []
        self.values: dict[str, list[ValueLine]] = {"start": [], "source": [], "hold": []}
        self.reactions: list[ReactionLine] = []
        self.noise: tuple[Noise, int] | None = None

    def block(self) -> TransportBlock:
        readers: dict[str, Callable[[], None]] = {
            "species": self._species,
            "pair": self._pair,
            "noise": self._noise,
            "start": self._value,
            "source": self._value,
            "hold": self._value,
            "reaction": self._reaction,
        }
        for number, text in self.extension.lines:
            self.line, self.words = number, text.split()
            word = self.words[0]
            reader = readers.get(word.lower())
            if reader is None:
                self._fail(f"unknown line; expected {', '.join(readers)}{suggest(word, readers)}", word)
            if not self.species and word.lower() != "species":
                self._fail("the line 'species' with the names of the dissolved species must come first", word)
            reader()
        if not self.species:
            self.line = self.extension.line
            self._fail("the block names no dissolved species; expected a line 'species NAME …'", "transport")
        noise, noise_line = self.noise or ("sqrt", 0)
        return TransportBlock(
            species=self.species,
            fluxes=tuple(self.fluxes),
            starts=tuple(self.values["start"]),
            sources=tuple(self.values["source"]),
            holds=tuple(self.values["hold"]),
            reactions=tuple(self.reactions),
            noise=noise,
            noise_line=noise_line,
            line=self.extension.line,
        )

    # Lines

    def _species(self) -> None:
        if self.species:
            self._fail("the dissolved species are named twice", self.words[0])
        names = self.words[1:]
        if not names:
            self._fail("expected the names of the dissolved species after this", self.words[0])
        for k, name in enumerate(names):
            if not _NAME.fullmatch(name) or name.lower() in _RESERVED:
                expected = f"letters, digits and _, beginning with a letter, and none of {', '.join(_RESERVED)}"
                self._fail(f"is no name for a dissolved species; expected {expected}", name)
            if name in names[:k]:
                self._fail("this dissolved species is named twice", name)
        self.species = tuple(names)

    def _pair(self) -> None:
        a, b = self._word(1, "a bead species or *"), self._word(2, "a bead species or *")
        if (a == "*") != (b == "*"):
            self._fail("expected two bead species, or * twice for all pairs that are not named", "*")
        dissolved = self._dissolved(3)
        numbers = self._named_numbers(4)
        kappa, reach = numbers["kappa"], numbers["range"]
        for name in ("kappa", "noise"):
            if numbers[name] < 0.0:
                self._fail(f"{name} must not be negative", f"{numbers[name]:g}")
        for name in ("range", "exponent"):
            if numbers[name] <= 0.0:
                self._fail(f"{name} must be larger than 0", f"{numbers[name]:g}")
        line = FluxLine((a, b), dissolved, kappa, reach, numbers["exponent"], numbers["noise"], self.line)
        for other in self.fluxes:
            if sorted(other.species) == sorted(line.species) and other.dissolved == dissolved:
                self._fail(f"{dissolved} between {a} and {b} is given already on line {other.line}", dissolved)
        self.fluxes.append(line)

    def _named_numbers(self, start: int) -> dict[str, float]:
        found: dict[str, float] = {}
        position = start
        while position < len(self.words):
            name = self.words[position].lower()
            if name not in _FLUX_NUMBERS:
                expected = f"expected {', '.join(_FLUX_NUMBERS)}, each with its number"
                self._fail(f"{expected}{suggest(name, _FLUX_NUMBERS)}", self.words[position])
            if name in found:
                self._fail("is given twice on this line", self.words[position])
            found[name] = self._number(position + 1, f"the number of {name}")
            position += 2
        for name, default in _FLUX_NUMBERS.items():
            if name not in found:
                if default is None:
                    self._fail(f"the line lacks {name} and its number", self.words[0])
                found[name] = default
        return found

    def _noise(self) -> None:
        word = self._word(1, f"one of {', '.join(NOISES)}")
        if self.noise is not None:
            self._fail(f"the noise is chosen already on line {self.noise[1]}", word)
        chosen: Noise | None = next((name for name in NOISES if name == word.lower()), None)
        if chosen is None:
            self._fail(f"is no noise; expected {', '.join(NOISES)}{suggest(word, NOISES)}", word)
        self._end(2)
        self.noise = (chosen, self.line)

    def _value(self) -> None:
        kind = self.words[0].lower()
        dissolved = self._dissolved(1)
        value = self._number(2, "the rate" if kind == "source" else "the concentration")
        if kind != "source" and value < 0.0:
            self._fail("a concentration must not be negative", self.words[2])
        region = self._region(3)
        if kind == "hold" and region.kind != "in":
            self._fail("expected 'in' and a bead species: beads of a species keep a concentration", self.words[0])
        if kind == "hold":
            for other in self.values["hold"]:
                if other.dissolved == dissolved and other.region == region:
                    self._fail(f"{dissolved} is held there already on line {other.line}", dissolved)
        self.values[kind].append(ValueLine(dissolved, value, region, self.line))

    def _region(self, start: int) -> RegionWords:
        if start >= len(self.words):
            return RegionWords()
        word = self.words[start].lower()
        if word == "in":
            name = self._word(start + 1, "a bead species")
            self._end(start + 2)
            return RegionWords("in", name)
        if word == "sphere":
            numbers = tuple(self._number(start + k, "x y z radius") for k in range(1, 5))
            if numbers[3] <= 0.0:
                self._fail("the radius of a sphere must be larger than 0", self.words[start + 4])
            self._end(start + 5)
            return RegionWords("sphere", "", numbers)
        if word == "box":
            bounds = tuple(self._bound(start + k, -math.inf if k % 2 else math.inf) for k in range(1, 7))
            for axis in range(3):
                if not bounds[2 * axis] < bounds[2 * axis + 1]:
                    self._fail(f"the box ends along {'xyz'[axis]} where it begins or before", self.words[start])
            self._end(start + 7)
            return RegionWords("box", "", bounds)
        if word != "everywhere":
            expected = "expected nothing, everywhere, in BEADSPECIES, box x0 x1 y0 y1 z0 z1 or sphere x y z radius"
            self._fail(expected, self.words[start])
        self._end(start + 1)
        return RegionWords()

    def _bound(self, position: int, otherwise: float) -> float:
        what = "x0 x1 y0 y1 z0 z1, each a number or * for no bound"
        return otherwise if self._word(position, what) == "*" else self._number(position, what)

    def _reaction(self) -> None:
        rate = self._number(1, "the rate constant")
        if rate < 0.0:
            self._fail("a rate constant must not be negative", self.words[1])
        words = self.words[2:]
        where = ""
        if len(words) >= 2 and words[-2].lower() == "in":
            where, words = words[-1], words[:-2]
        if words.count("->") != 1:
            self._fail("expected one '->' between what reacts and what is made", self.words[0])
        arrow = words.index("->")
        left, right = self._side(words[:arrow]), self._side(words[arrow + 1 :])
        order = sum(count for count, _ in left)
        if not 1 <= order <= _MOST_ORDER:
            self._fail("expected one or two species on the left (first or second order)", self.words[0])
        line = ReactionLine(rate, left, right, where, self.line)
        made = {name: sum(n for n, other in right if other == name) for _, name in left}
        used = {name: sum(n for n, other in left if other == name) for _, name in left}
        if order == _MOST_ORDER and all(made[name] > used[name] for name in used):
            message = f"{line.equation} makes more of all that reacts and runs away in finite time"
            self._fail(f"{message}; expected a reaction that takes one of its species", "->")
        self.reactions.append(line)

    def _side(self, words: Sequence[str]) -> tuple[tuple[int, str], ...]:
        if [word.lower() for word in words] == ["none"]:
            return ()
        terms: dict[str, int] = {}
        for term in " ".join(words).split("+"):
            parts = term.split()
            count = 1
            if len(parts) == 2:
                number = parse_number(parts[0])
                if number is None or number < 1.0 or number != int(number):
                    self._fail("expected a whole number from 1 on before a dissolved species", parts[0])
                count, parts = int(number), parts[1:]
            if len(parts) != 1:
                self._fail("expected dissolved species with + between them, or none", " ".join(parts) or "+")
            self._known(parts[0])
            terms[parts[0]] = terms.get(parts[0], 0) + count
        return tuple((count, name) for name, count in terms.items())

    # Words

    def _word(self, position: int, expected: str) -> str:
        if position >= len(self.words):
            self._fail(f"the line is too short; expected {expected}", self.words[0])
        return self.words[position]

    def _number(self, position: int, expected: str) -> float:
        word = self._word(position, expected)
        value = parse_number(word)
        if value is None:
            self._fail(f"expected {expected}, a number", word)
        return value

    def _dissolved(self, position: int) -> str:
        return self._known(self._word(position, "a dissolved species"))

    def _known(self, name: str) -> str:
        if name not in self.species:
            near = suggest(name, self.species) or f"; there are {', '.join(self.species)}"
            self._fail(f"is no dissolved species{near}", name)
        return name

    def _end(self, position: int) -> None:
        if position < len(self.words):
            self._fail("expected the end of the line", self.words[position])

    def _fail(self, message: str, word: str) -> NoReturn:
        raise InputError(message, path=self.path, line=self.line or None, word=word)
