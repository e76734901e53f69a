"""What a scene says about dissolved species: complete, in internal units, immutable.

A concentration C is an amount a bead, in a unit of the user's; C times the number density is the amount per volume.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Literal

NO_BOUND = sys.float_info.max
"""Where a box does not end; infinity has no place in a checkpoint's JSON."""


@dataclass(frozen=True)
class Region:
    """Where something is.

    Attributes:
        kind: "everywhere", "species" (the beads of one), "box" or "sphere".
        numbers: the bead species; x0 x1 y0 y1 z0 z1 (−NO_BOUND or NO_BOUND for none); x y z radius. Å from the centre
            of the cell.
    """

    kind: Literal["everywhere", "species", "box", "sphere"] = "everywhere"
    numbers: tuple[float, ...] = ()


@dataclass(frozen=True)
class SpeciesFlux:
    """What moves one dissolved species between beads of two species.

    dC_i = −κ w² (C_i − C_j) dt + ε w f(C_i + C_j) dW with w² = (1 − r/range)^exponent; the opposite for j.

    Attributes:
        species: indices a ≤ b of the bead species.
        dissolved: index into ``Transport.species``.
        rate: κ, 1/ps; ``noise``: ε.
        range: in Å.
        explanation: where the numbers come from ("FIELD:12").
    """

    species: tuple[int, int]
    dissolved: int
    rate: float
    range: float
    exponent: float = 2.0
    noise: float = 0.0
    explanation: str = ""


@dataclass(frozen=True)
class SpeciesValue:
    """A start value, a source's rate (amount a bead and ps) or a value that is held, of a dissolved species."""

    dissolved: int
    value: float
    region: Region = Region()
    explanation: str = ""


@dataclass(frozen=True)
class Reaction:
    """A reaction of first or second order: rate · Π C of the reactants, once for each time a reactant takes part.

    Attributes:
        rate: 1/ps, or 1/(ps amount a bead).
        reactants: one or two indices of dissolved species; the same twice when a species meets itself.
        change: of every dissolved species in one reaction.
        species: the bead species it happens in, −1 for all.
        equation: in words.
    """

    rate: float
    reactants: tuple[int, ...]
    change: tuple[float, ...]
    species: int = -1
    equation: str = ""
    explanation: str = ""


@dataclass(frozen=True)
class Transport:
    """Dissolved species that beads carry, exchange, gain and change into each other.

    Attributes:
        species: their names.
        noise: the random flux: "sqrt" (f(S) = √S), "lammps" (f(S) = S) or "off".
        starts: start values, later ones over earlier ones; 0 elsewhere.
        holds: concentrations that the beads of a species keep.
    """

    species: tuple[str, ...]
    fluxes: tuple[SpeciesFlux, ...] = ()
    noise: Literal["sqrt", "lammps", "off"] = "off"
    starts: tuple[SpeciesValue, ...] = ()
    sources: tuple[SpeciesValue, ...] = ()
    holds: tuple[SpeciesValue, ...] = ()
    reactions: tuple[Reaction, ...] = ()
