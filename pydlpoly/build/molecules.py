"""Species, and molecules as beads with bonds: from a list of bonds, from a sequence, or of one of the usual shapes."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from pydlpoly.errors import SceneError

_COMPACT = re.compile(r"([A-Za-z][a-z_]*)(\d*)|([(])|([)])(\d*)")
_LISTED = re.compile(r"\s*(?:([^\s,*()]+)(?:\*(\d+))?|([(])|([)])(?:\*?(\d+))?)\s*,?\s*")
# No sequence of a coarse-grained molecule is longer; larger numbers are slips.
_MOST_BEADS = 1_000_000


@dataclass(frozen=True)
class Species:
    """One kind of bead.

    Attributes:
        name: at most 8 characters.
        mass: in Da, 1 in reduced units.
        charge: in elementary charges.
        frozen: it never moves.
    """

    name: str
    mass: float = 1.0
    charge: float = 0.0
    frozen: bool = False


@dataclass(frozen=True)
class MoleculeType:
    """A molecule: its beads, what is bonded, and the paths along which angles are taken.

    Attributes:
        name: of the molecule, as in FIELD.
        beads: species of each bead.
        bonds: pairs of bead numbers, counted from 0.
        runs: paths of bonded beads; each three successive beads make an angle.
        places: one place a bead, for molecules that are placed as they are; None for those that can be grown.
        closed: the bonds make a single ring.
    """

    name: str
    beads: tuple[str, ...]
    bonds: tuple[tuple[int, int], ...] = ()
    runs: tuple[tuple[int, ...], ...] = ()
    places: tuple[tuple[float, float, float], ...] | None = None
    closed: bool = False

    def __post_init__(self) -> None:
        """Check that bonds and places are those of these beads.

        Raises:
            SceneError: no beads, a bond with a bead that is not there or given twice, or another number of places.
        """
        if not self.beads:
            raise SceneError("a molecule needs at least one bead", word=self.name)
        seen = set()
        for bond in self.bonds:
            ends = tuple(sorted(bond))
            if len(ends) != 2 or ends[0] == ends[1] or ends[0] < 0 or ends[1] >= len(self.beads):
                message = f"the bond {bond} is no pair of bead numbers from 0 to {len(self.beads) - 1}"
                raise SceneError(message, word=self.name)
            if ends in seen:
                raise SceneError(f"the bond {bond} is given twice", word=self.name)
            seen.add(ends)
        if self.places is not None and len(self.places) != len(self.beads):
            message = f"{len(self.places)} places for {len(self.beads)} beads"
            raise SceneError(message, word=self.name)

    @property
    def angles(self) -> tuple[tuple[int, int, int], ...]:
        """Return the three bead numbers of each angle along the runs, each once."""
        threes = [three for run in self.runs for three in zip(run, run[1:], run[2:], strict=False)]
        unique = {(min(a, c), b, max(a, c)): (a, b, c) for a, b, c in reversed(threes)}
        return tuple(reversed(unique.values()))

    def tree(self) -> tuple[tuple[int, int], ...]:
        """Return (bead, bead it hangs on) in an order in which each bead comes after the one it hangs on; first: -1.

        Raises:
            SceneError: the bonds have a cycle, or do not connect all beads.
        """
        around: list[list[int]] = [[] for _ in self.beads]
        for a, b in self.bonds:
            around[a].append(b)
            around[b].append(a)
        parents = {0: -1}
        queue = [0]
        for bead in queue:
            for other in sorted(around[bead]):
                if other not in parents:
                    parents[other] = bead
                    queue.append(other)
        if len(parents) < len(self.beads):
            lost = next(k for k in range(len(self.beads)) if k not in parents)
            raise SceneError(f"bead {lost} is not connected to bead 0; give the molecule places", word=self.name)
        if len(self.bonds) != len(self.beads) - 1:
            raise SceneError("the bonds have a cycle: give the molecule places, or use ring", word=self.name)
        return tuple((bead, parents[bead]) for bead in queue)


def bead(species: str, name: str = "") -> MoleculeType:
    """Return a molecule of one bead; it is called like its species unless ``name`` says otherwise."""
    return MoleculeType(name or species, (species,))


def chain(name: str, sequence: str) -> MoleculeType:
    """Return a linear or branched chain from its sequence.

    ``"A5B5"``: names of one capital and small letters, each with a number. ``"A,B,A"`` or ``"Poly*50, End"``: any
    names, with commas, blanks or stars. ``"H3(T6)2"``: a group in brackets hangs on the bead before it, as often as the
    number says; what follows goes on from that bead.

    Raises:
        SceneError: the text is no such sequence.
    """
    beads, bonds, runs = _Parser(sequence, name).parse()
    return MoleculeType(name, beads, bonds, runs)


def ring(name: str, sequence: str) -> MoleculeType:
    """Return a ring; it is placed as a circle.

    Raises:
        SceneError: fewer than three beads, or a sequence with branches.
    """
    open_chain = chain(name, sequence)
    count = len(open_chain.beads)
    if count < 3 or len(open_chain.runs) != 1:
        raise SceneError("a ring needs a sequence of at least three beads without branches", word=sequence)
    run = (*range(count), 0, 1)
    return replace(open_chain, bonds=(*open_chain.bonds, (0, count - 1)), runs=(run,), closed=True)


def star(name: str, core: str, arm: str, arms: int) -> MoleculeType:
    """Return ``arms`` chains that hang on the last bead of ``core``.

    Raises:
        SceneError: no arms, or sequences that cannot be read.
    """
    if arms < 1:
        raise SceneError(f"a star needs at least one arm, not {arms}", word=name)
    middle = chain(name, core)
    return _hang(middle, chain(name, arm), [len(middle.beads) - 1] * arms)


def comb(name: str, backbone: str, side: str, spacing: int = 1, first: int = 0) -> MoleculeType:
    """Return a backbone with side chains on every ``spacing``-th bead, from bead ``first`` (counted from 0) on.

    Raises:
        SceneError: numbers that leave no side chain, or sequences that cannot be read.
    """
    base = chain(name, backbone)
    if spacing < 1 or not 0 <= first < len(base.beads):
        message = f"side chains every {spacing} beads from bead {first} on do not fit a backbone of {len(base.beads)}"
        raise SceneError(message, word=name)
    return _hang(base, chain(name, side), list(range(first, len(base.beads), spacing)))


def lipid(name: str, head: str, tail: str, tails: int = 1, *, spread: bool = False) -> MoleculeType:
    """Return a lipid, its outermost head bead first.

    Args:
        name: of the molecule.
        head, tail: sequences, the tail from the head on.
        tails: how many there are.
        spread: the tails hang on the last beads of the head, one each; without it all hang on the last bead.

    Raises:
        SceneError: more tails than head beads to spread them on, no tails, or sequences that cannot be read.
    """
    base = chain(name, head)
    last = len(base.beads) - 1
    if tails < 1 or (spread and tails > len(base.beads)):
        raise SceneError(f"{tails} tails do not fit a head of {len(base.beads)} beads", word=name)
    return _hang(base, chain(name, tail), [last - k for k in range(tails)] if spread else [last] * tails)


def graph(
    name: str,
    beads: str | Sequence[str],
    bonds: str | Sequence[tuple[int, int]] = (),
    places: Sequence[Sequence[float]] | None = None,
) -> MoleculeType:
    """Return a molecule with these bonds: ``graph("water", "O,H,H", "0-1,0-2")``.

    Angles are taken at every bead between every two of its bonds.

    Args:
        name: of the molecule.
        beads: species, as a sequence without brackets or a list of names.
        bonds: pairs of bead numbers counted from 0, as text or tuples.
        places: (beads, 3) places, to place the molecule as it is; needed when the bonds have a cycle.

    Raises:
        SceneError: the text cannot be read, or bonds and places are not those of the beads.
    """
    names = _Parser(beads, name).parse()[0] if isinstance(beads, str) else tuple(beads)
    pairs = _read_bonds(bonds, name) if isinstance(bonds, str) else tuple((int(a), int(b)) for a, b in bonds)
    around: dict[int, list[int]] = {}
    for a, b in pairs:
        around.setdefault(a, []).append(b)
        around.setdefault(b, []).append(a)
    runs = tuple(
        (near[i], middle, near[j])
        for middle, near in sorted(around.items())
        for i in range(len(near))
        for j in range(i + 1, len(near))
    )
    shape = None if places is None else tuple((float(x), float(y), float(z)) for x, y, z in places)
    return MoleculeType(name, names, pairs, runs, shape)


def circle(count: int, length: float) -> tuple[tuple[float, float, float], ...]:
    """Return ``count`` places on a circle in the xy plane, neighbours ``length`` apart."""
    radius = 0.5 * length / math.sin(math.pi / count)
    turns = [2.0 * math.pi * k / count for k in range(count)]
    return tuple((radius * math.cos(turn), radius * math.sin(turn), 0.0) for turn in turns)


def _read_bonds(text: str, name: str) -> tuple[tuple[int, int], ...]:
    pairs = []
    for word in re.split(r"[\s,]+", text.strip()):
        found = re.fullmatch(r"(\d+)-(\d+)", word)
        if found is None:
            raise SceneError(f"expected bonds as in 0-1,1-2, not {word!r}", word=name)
        pairs.append((int(found[1]), int(found[2])))
    return tuple(pairs)


def _hang(base: MoleculeType, branch: MoleculeType, at: Sequence[int]) -> MoleculeType:
    """Return ``base`` with copies of ``branch`` on the beads ``at``; angles go from the base into each branch."""
    beads, bonds, runs = list(base.beads), list(base.bonds), list(base.runs)
    before = {run[k]: run[k - 1] for run in base.runs for k in range(1, len(run))}
    for place in at:
        start = len(beads)
        beads += branch.beads
        bonds += [(place, start), *((a + start, b + start) for a, b in branch.bonds)]
        into = (before[place], place) if place in before else (place,)
        first, *others = (tuple(k + start for k in run) for run in branch.runs)
        runs += [(*into, *first), *others]
    return MoleculeType(base.name, tuple(beads), tuple(bonds), tuple(runs))


class _Parser:
    """Reads a sequence: beads, bonds and runs in the order of the text."""

    def __init__(self, text: str, name: str) -> None:
        self._text, self._name = text, name
        self._beads: list[str] = []
        self._bonds: list[tuple[int, int]] = []
        self._runs: list[tuple[int, ...]] = []
        self._tokens = self._split()

    def parse(self) -> tuple[tuple[str, ...], tuple[tuple[int, int], ...], tuple[tuple[int, ...], ...]]:
        end = self._chain(0, ())
        if end < len(self._tokens):
            raise self._error("a bracket is closed that was not opened")
        self._runs.sort(key=lambda run: run[-1] if run else -1)
        return tuple(self._beads), tuple(self._bonds), tuple(self._runs)

    def _split(self) -> list[tuple[str, int]]:
        """Return (name, count), ("(", 1) and (")", count)."""
        text = self._text.strip()
        pattern = _LISTED if re.search(r"[\s,*]", text) else _COMPACT
        tokens, place = [], 0
        while place < len(text):
            found = pattern.match(text, place)
            if found is None or found.end() == place:
                message = f"cannot be read from {text[place:]!r} on; expected a sequence such as A5B5, A,B,A, P*50 or "
                raise self._error(f"{message}H3(T6)2")
            word, times, opened, _, copies = found.groups()
            count = int((times if word else copies) or 1)
            if not 1 <= count <= _MOST_BEADS:
                raise self._error(f"a number in a sequence lies between 1 and {_MOST_BEADS}, not at {count}")
            tokens.append((word or ("(" if opened else ")"), count))
            place = found.end()
        if not tokens:
            raise self._error("is an empty sequence")
        return tokens

    def _chain(self, token: int, into: tuple[int, ...]) -> int:
        """Read a chain that hangs on the last bead of ``into`` up to its end; return the token there."""
        run = list(into)
        start = len(self._beads)
        while token < len(self._tokens) and self._tokens[token][0] != ")":
            word, count = self._tokens[token]
            if word == "(":
                if len(self._beads) == start:
                    raise self._error("a group in brackets needs a bead before it to hang on")
                token = self._group(token + 1, tuple(run[-2:])) + 1
                continue
            for _ in range(count):
                if len(self._beads) >= _MOST_BEADS:
                    raise self._error(f"has more than {_MOST_BEADS} beads")
                if run:
                    self._bonds.append((run[-1], len(self._beads)))
                run.append(len(self._beads))
                self._beads.append(word)
            token += 1
        if len(self._beads) == start:
            raise self._error("a group in brackets is empty")
        self._runs.append(tuple(run))
        return token

    def _group(self, token: int, into: tuple[int, ...]) -> int:
        end = self._chain(token, into)
        if end >= len(self._tokens):
            raise self._error("a bracket is not closed")
        for _ in range(self._tokens[end][1] - 1):
            self._chain(token, into)
        return end

    def _error(self, message: str) -> SceneError:
        return SceneError(f"molecule {self._name}: the sequence {message}", word=self._text)
