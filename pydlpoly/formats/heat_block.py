"""The FIELD block ``extension heat``: beads that carry heat (energy-conserving DPD), in the file's own units.

Lines, in any order, keywords in any case; [ ] can be left out::

    capacity SPECIES C_V [temperature T]
    pair SPECIES SPECIES kappa K range R [exponent S] [power c1 … c4] [conductivity d1 … d4] [drag e1 … e4]
    viscous_heating conserving | lammps
    repulsion constant | scaled
    region NAME box x0 x1 y0 y1 z0 z1 | sphere x y z R | layer x|y|z LOW HIGH
    source box … RATE | sphere … RATE | layer … RATE | region NAME RATE | species SPECIES RATE
    wall SPECIES T

docs/heat.md says what they mean.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal, NoReturn

from pydlpoly.errors import InputError, suggest
from pydlpoly.formats.lexing import parse_number
from pydlpoly.formats.records import Extension

Polynomial = tuple[float, float, float, float]
ViscousHeating = Literal["conserving", "lammps"]
Repulsion = Literal["constant", "scaled"]
RegionKind = Literal["box", "sphere", "species"]
NO_TERMS: Polynomial = (0.0, 0.0, 0.0, 0.0)
OPEN = 1e30
"""Bounds of a layer where it has none, Å."""


@dataclass(frozen=True)
class CapacityLine:
    """Heat capacity of a species in k_B, and the internal temperature its beads start with (None: not given)."""

    species: str
    capacity: float
    temperature: float | None = None
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class HeatPairLine:
    """Coefficients of two species; ``range`` is 0 where the line gives no conduction."""

    species: tuple[str, str]
    kappa: float = 0.0
    range: float = 0.0
    exponent: float = 2.0
    power: Polynomial = NO_TERMS
    conductivity: Polynomial = NO_TERMS
    drag: Polynomial = NO_TERMS
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class SourceLine:
    """Temperature per time for the beads of a species or in a region.

    ``numbers`` are x0 x1 y0 y1 z0 z1 of a box (a layer is one that is open on four sides), x y z R of a sphere, and
    none of a species, whose name is ``species``.
    """

    kind: RegionKind
    numbers: tuple[float, ...]
    rate: float
    species: str = ""
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class HeatWallLine:
    """A species whose beads are held at a temperature."""

    species: str
    temperature: float
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class HeatBlock:
    """The whole block; ``lines`` has the places of the words that appear once."""

    capacities: tuple[CapacityLine, ...] = ()
    pairs: tuple[HeatPairLine, ...] = ()
    sources: tuple[SourceLine, ...] = ()
    walls: tuple[HeatWallLine, ...] = ()
    viscous_heating: ViscousHeating = "conserving"
    repulsion: Repulsion = "constant"
    line: int = field(default=0, compare=False)
    lines: dict[str, int] = field(default_factory=dict, compare=False, hash=False)


def read_heat(extension: Extension, path: str, species: Iterable[str]) -> HeatBlock:
    """Return what the block says.

    Args:
        extension: the block of FIELD.
        path: FIELD's name, for messages.
        species: the species there are.

    Raises:
        InputError: a line that is none of the block's, a wrong number of words, or a species that is not there.
    """
    return _Reader(extension, path, tuple(species)).read()


class _Words:
    """The words of one line, taken from left to right."""

    def __init__(self, number: int, text: str, path: str) -> None:
        self.number, self.path = number, path
        self._words, self._taken = text.split(), 0

    def fail(self, message: str, word: str | None = None) -> NoReturn:
        raise InputError(message, path=self.path, line=self.number, word=word)

    def left(self) -> bool:
        return self._taken < len(self._words)

    def word(self, expected: str) -> str:
        if not self.left():
            self.fail(f"the line is too short; expected {expected}")
        self._taken += 1
        return self._words[self._taken - 1]

    def number_of(self, what: str) -> float:
        word = self.word(what)
        value = parse_number(word)
        if value is None:
            self.fail(f"expected {what}, a number", word)
        return value

    def numbers(self, names: str) -> tuple[float, ...]:
        return tuple(self.number_of(f"{name} of {names}") for name in names.split())

    def choice(self, words: tuple[str, ...], what: str) -> str:
        word = self.word(f"{what}: {', '.join(words)}")
        if word.lower() not in words:
            self.fail(f"expected {what}: {', '.join(words)}{suggest(word, words)}", word)
        return word.lower()

    def end(self) -> None:
        if self.left():
            self.fail("this is more than the line takes", self._words[self._taken])


class _Reader:
    def __init__(self, extension: Extension, path: str, species: tuple[str, ...]) -> None:
        self._extension, self._path, self._species = extension, path, species
        self._regions: dict[str, tuple[RegionKind, tuple[float, ...]]] = {}
        self._once: dict[str, int] = {}

    def read(self) -> HeatBlock:
        capacities, pairs, sources, walls = [], [], [], []
        words = {"viscous_heating": "conserving", "repulsion": "constant"}
        kinds = ("capacity", "pair", "region", "source", "wall", *words)
        given = [_Words(number, text, self._path) for number, text in self._extension.lines]
        for line in given:
            kind = line.choice(kinds, "a line of extension heat")
            if kind == "capacity":
                capacities.append(self._capacity(line))
            elif kind == "pair":
                pairs.append(self._pair(line))
            elif kind == "region":
                self._region(line)
            elif kind == "source":
                sources.append(self._source(line))
            elif kind == "wall":
                walls.append(HeatWallLine(self._name(line, "wall"), line.number_of("a temperature"), line.number))
            else:
                self._first(kind, line)
                allowed = ("conserving", "lammps") if kind == "viscous_heating" else ("constant", "scaled")
                words[kind] = line.choice(allowed, kind)
            line.end()
        return HeatBlock(
            capacities=tuple(capacities),
            pairs=tuple(pairs),
            sources=tuple(sources),
            walls=tuple(walls),
            viscous_heating="lammps" if words["viscous_heating"] == "lammps" else "conserving",
            repulsion="scaled" if words["repulsion"] == "scaled" else "constant",
            line=self._extension.line,
            lines=self._once,
        )

    def _first(self, what: str, line: _Words) -> None:
        if what in self._once:
            line.fail(f"{what} is given twice (first on line {self._once[what]})")
        self._once[what] = line.number

    def _one_species(self, line: _Words) -> str:
        name = line.word("a species")
        if name not in self._species:
            line.fail(f"unknown species; there are {', '.join(self._species)}{suggest(name, self._species)}", name)
        return name

    def _name(self, line: _Words, what: str) -> str:
        name = self._one_species(line)
        self._first(f"{what} {name}", line)
        return name

    def _capacity(self, line: _Words) -> CapacityLine:
        name = self._name(line, "capacity")
        value = line.number_of("a heat capacity")
        start = None
        if line.left():
            line.choice(("temperature",), "a word")
            start = line.number_of("a temperature")
        return CapacityLine(name, value, start, line.number)

    def _pair(self, line: _Words) -> HeatPairLine:
        a, b = self._one_species(line), self._one_species(line)
        self._first("pair " + " ".join(sorted((a, b))), line)
        numbers: dict[str, float] = {}
        terms: dict[str, Polynomial] = {}
        while line.left():
            word = line.choice(
                ("kappa", "range", "exponent", "power", "conductivity", "drag"), "a coefficient of the pair"
            )
            if word in numbers or word in terms:
                line.fail(f"{word} is given twice on one line", word)
            if word in ("kappa", "range", "exponent"):
                numbers[word] = line.number_of(word)
            else:
                c1, c2, c3, c4 = (line.number_of(f"coefficient {k} of 4 of {word}") for k in range(1, 5))
                terms[word] = (c1, c2, c3, c4)
        return HeatPairLine(
            (a, b),
            numbers.get("kappa", 0.0),
            numbers.get("range", 0.0),
            numbers.get("exponent", 2.0),
            terms.get("power", NO_TERMS),
            terms.get("conductivity", NO_TERMS),
            terms.get("drag", NO_TERMS),
            line.number,
        )

    def _shape(self, line: _Words, kind: str) -> tuple[RegionKind, tuple[float, ...]]:
        if kind == "box":
            return "box", line.numbers("x0 x1 y0 y1 z0 z1")
        if kind == "sphere":
            return "sphere", line.numbers("x y z R")
        axis = "xyz".index(line.choice(("x", "y", "z"), "an axis"))
        bounds = [-OPEN, OPEN] * 3
        bounds[2 * axis : 2 * axis + 2] = line.numbers("LOW HIGH")
        return "box", tuple(bounds)

    def _region(self, line: _Words) -> None:
        name = line.word("the name of a region")
        self._first(f"region {name}", line)
        self._regions[name] = self._shape(line, line.choice(("box", "sphere", "layer"), "a shape"))

    def _source(self, line: _Words) -> SourceLine:
        kind = line.choice(("box", "sphere", "layer", "region", "species"), "where the source acts")
        if kind == "species":
            name = self._one_species(line)
            return SourceLine("species", (), line.number_of("a rate"), name, line.number)
        if kind == "region":
            name = line.word("the name of a region")
            if name not in self._regions:
                known = f"known are {', '.join(self._regions)}" if self._regions else "there are none"
                line.fail(f"no such region on a line above; {known}{suggest(name, self._regions)}", name)
            shape = self._regions[name]
        else:
            shape = self._shape(line, kind)
        return SourceLine(*shape, line.number_of("a rate"), line=line.number)
