"""The two forms of an ``mdpd`` record: the generalised one of DL_POLY's manual, and the older one of two densities."""

from __future__ import annotations

KEY = "mdpd"
"""Key of the pair law of many-body DPD."""

HINT = "; or four, A B rc rd, of the two-density form"
"""What a message about too few numbers adds."""


def is_two_density(numbers: tuple[float, ...]) -> bool:
    """Whether a record's numbers are A B r_c r_d and maybe γ, and not A B n m r_c r_d and maybe γ."""
    return len(numbers) in (4, 5)


def in_full(numbers: tuple[float, ...]) -> tuple[float, ...]:
    """Return a record's numbers in the order A B n m r_c r_d γ; n = m = 2 in the two-density form.

    B stays as it is written: it has another meaning, and unit, in each form.
    """
    if not is_two_density(numbers):
        return numbers
    strength, repulsion, *others = numbers
    cutoff, density_cutoff, *drag = others
    return (strength, repulsion, 2.0, 2.0, cutoff, density_cutoff, *drag)
