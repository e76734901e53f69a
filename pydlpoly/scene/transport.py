"""Dissolved species: FIELD's block ``extension transport`` as part of the scene, and what the beads start with."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from pydlpoly.errors import SceneError, suggest
from pydlpoly.formats.records import Field, FloatArray
from pydlpoly.formats.transport_block import (
    FluxLine,
    ReactionLine,
    RegionWords,
    TransportBlock,
    ValueLine,
    read_transport,
)
from pydlpoly.scene.cell import widths
from pydlpoly.scene.model import Beads
from pydlpoly.scene.settings import Notes, place
from pydlpoly.scene.transport_terms import NO_BOUND, Reaction, Region, SpeciesFlux, SpeciesValue, Transport

# Beyond this many cell widths several images of a pair would share their noise; as for the drag's.
_MOST_WIDTHS = 2.5


def resolve_transport(
    field: Field,
    bead_species: Sequence[str],
    cell: FloatArray,
    periodic: tuple[bool, bool, bool],
    timestep: float,
    notes: Notes,
) -> Transport | None:
    """Return what FIELD's block says, None when there is none.

    Args:
        field: FIELD with its extensions.
        bead_species: names of the species of beads.
        cell: (3, 3) cell vectors by row, Å.
        periodic: periodicity along them.
        timestep: Δt, ps.
        notes: receives choices and oddities.

    Raises:
        InputError: the block cannot be read.
        SceneError: a bead species that there is not, a region that the cell cannot have, or a range too long for it.
    """
    extension = next((one for one in field.extensions if one.name == "transport"), None)
    if extension is None:
        return None
    resolver = _Resolver(read_transport(extension, field.path), field.path, bead_species, cell, periodic, notes)
    return resolver.transport(timestep)


def start_concentrations(
    transport: Transport, beads: Beads, cell: FloatArray, periodic: tuple[bool, bool, bool]
) -> FloatArray:
    """Return what the beads start with, (N, species): the start values, and what is held where it is."""
    values = np.zeros((len(beads), len(transport.species)))
    for term in (*transport.starts, *transport.holds):
        values[inside(term.region, beads, cell, periodic), term.dissolved] = term.value
    return values


def inside(region: Region, beads: Beads, cell: FloatArray, periodic: tuple[bool, bool, bool]) -> np.ndarray:
    """Return which beads a region holds, (N,)."""
    if region.kind == "species":
        return np.asarray(beads.species == int(region.numbers[0]))
    if region.kind == "box":
        bounds = np.reshape(region.numbers, (3, 2))
        places = beads.positions
        return np.asarray(((places >= bounds[:, 0]) & (places < bounds[:, 1])).all(axis=1))
    if region.kind == "sphere":
        apart = beads.positions - np.array(region.numbers[:3])
        cells = np.floor(apart @ np.linalg.inv(cell) + 0.5) * np.array(periodic)
        return np.asarray(np.sum((apart - cells @ cell) ** 2, axis=1) <= region.numbers[3] ** 2)
    return np.ones(len(beads), dtype=bool)


class _Resolver:
    def __init__(
        self,
        block: TransportBlock,
        path: str,
        bead_species: Sequence[str],
        cell: FloatArray,
        periodic: tuple[bool, bool, bool],
        notes: Notes,
    ) -> None:
        self.block, self.path, self.beads, self.notes = block, path, tuple(bead_species), notes
        self.narrowest = min(widths(cell)[list(periodic)].tolist(), default=math.inf)

    def transport(self, timestep: float) -> Transport:
        block = self.block
        fluxes = tuple(self._fluxes())
        transport = Transport(
            species=block.species,
            fluxes=fluxes,
            noise=block.noise if any(flux.noise > 0.0 for flux in fluxes) else "off",
            starts=tuple(self._value(line) for line in block.starts),
            sources=tuple(self._value(line) for line in block.sources),
            holds=tuple(self._value(line) for line in block.holds),
            reactions=tuple(self._reaction(line) for line in block.reactions),
        )
        self._note(transport, timestep)
        return transport

    def _fluxes(self) -> Iterator[SpeciesFlux]:
        named = {(self._pair(line), line.dissolved) for line in self.block.fluxes if line.species[0] != "*"}
        count = len(self.beads)
        every = [(a, b) for b in range(count) for a in range(b + 1)]
        for line in self.block.fluxes:
            if line.species[0] == "*":
                pairs = [pair for pair in every if (pair, line.dissolved) not in named]
            else:
                pairs = [self._pair(line)]
            noisy = line.noise > 0.0 and self.block.noise != "off"
            if noisy and line.range > _MOST_WIDTHS * self.narrowest:
                raise self._refusal(
                    f"the cell is {self.narrowest:g} ang wide, less than 2/5 of this range: more images of a pair "
                    "would exchange than have noise of their own",
                    line.line,
                    f"{line.range:g}",
                )
            for pair in pairs:
                yield SpeciesFlux(
                    pair,
                    self.block.species.index(line.dissolved),
                    line.kappa,
                    line.range,
                    line.exponent,
                    line.noise if self.block.noise != "off" else 0.0,
                    place(self.path, line.line),
                )

    def _pair(self, line: FluxLine) -> tuple[int, int]:
        a, b = sorted(self._bead(name, line.line) for name in line.species)
        return a, b

    def _bead(self, name: str, line: int) -> int:
        if name not in self.beads:
            near = suggest(name, self.beads) or f"; there are {', '.join(self.beads)}"
            raise self._refusal(f"is no species of beads{near}", line, name)
        return self.beads.index(name)

    def _value(self, line: ValueLine) -> SpeciesValue:
        return SpeciesValue(
            self.block.species.index(line.dissolved),
            line.value,
            self._region(line.region, line.line),
            place(self.path, line.line),
        )

    def _region(self, words: RegionWords, line: int) -> Region:
        if words.kind == "in":
            return Region("species", (float(self._bead(words.species, line)),))
        if words.kind == "sphere" and 2.0 * words.numbers[3] > self.narrowest:
            raise self._refusal(
                f"the sphere is wider than the cell, {self.narrowest:g} ang", line, f"{words.numbers[3]:g}"
            )
        return Region(words.kind, tuple(max(-NO_BOUND, min(NO_BOUND, number)) for number in words.numbers))

    def _reaction(self, line: ReactionLine) -> Reaction:
        index = self.block.species.index
        change = [0.0] * len(self.block.species)
        for count, name in line.left:
            change[index(name)] -= count
        for count, name in line.right:
            change[index(name)] += count
        where = place(self.path, line.line)
        if not any(change):
            self.notes.ignored(f"the reaction {line.equation} changes nothing", where)
        return Reaction(
            line.rate,
            tuple(index(name) for count, name in line.left for _ in range(count)),
            tuple(change),
            self._bead(line.species, line.line) if line.species else -1,
            line.equation,
            where,
        )

    def _note(self, transport: Transport, timestep: float) -> None:
        block, notes = self.block, self.notes
        if any(line.noise > 0.0 for line in block.fluxes) and block.noise == "off":
            where = place(self.path, block.noise_line)
            notes.ignored("noise off: the noise of the lines 'pair' has no effect", where)
        if block.noise_line and block.noise != "off" and transport.noise == "off":
            where = place(self.path, block.noise_line)
            notes.ignored(f"noise {block.noise}: no line 'pair' has a noise above 0", where)
        if transport.noise == "sqrt" and not block.noise_line:
            notes.choice("random fluxes of dissolved species grow as the root of the concentrations (noise sqrt)")
        for flux in transport.fluxes:
            if 2.0 * flux.rate * timestep > 1.0:
                text = (
                    f"{block.species[flux.dissolved]}: two close beads share what they have within a step (2 kappa dt "
                    f"= {2.0 * flux.rate * timestep:.3g}); amounts stay right, how fast they spread does not"
                )
                notes.warning(text, flux.explanation)
        moving = {flux.dissolved for flux in transport.fluxes if flux.rate > 0.0 or flux.noise > 0.0}
        for number, name in enumerate(block.species):
            if number not in moving:
                notes.choice(f"{name} stays in its beads: no line 'pair' moves it", place(self.path, block.line))

    def _refusal(self, message: str, line: int, word: str) -> SceneError:
        return SceneError(message, path=self.path, line=line or None, word=word)
