"""What a run did to the amounts of dissolved species, and the table of it in OUTPUT."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pydlpoly.formats.fortran import fortran_e


@dataclass(frozen=True)
class SpeciesBalance:
    """Amounts of one dissolved species in all beads together.

    Attributes:
        name: of the dissolved species.
        start: what the beads had at the scene's start; ``now``: what they have.
        sources, reactions, held: what sources, reactions, and beads with held concentrations have given since.
    """

    name: str
    start: float
    sources: float
    reactions: float
    held: float
    now: float

    @property
    def remainder(self) -> float:
        """What the present amount is more than the rest adds up to: rounding, or what was set from outside."""
        return self.now - (self.start + self.sources + self.reactions + self.held)


def balance_text(balances: Sequence[SpeciesBalance]) -> str:
    """Return the table of OUTPUT, an empty text without dissolved species."""
    if not balances:
        return ""
    heads = ("at start", "sources", "reactions", "held", "now", "remainder")
    width = max(10, *(len(balance.name) for balance in balances))
    text = "Amounts of dissolved species, all beads together:\n"
    text += "  " + " " * width + "".join(head.rjust(16) for head in heads) + "\n"
    for one in balances:
        numbers = (one.start, one.sources, one.reactions, one.held, one.now, one.remainder)
        text += f"  {one.name.ljust(width)}" + "".join(fortran_e(x, 16, 8) for x in numbers) + "\n"
    return text + "\n"
