"""Text for LAMMPS: numbers with all their digits, and laws as formulas for the styles of its package LEPTON."""

from __future__ import annotations


def number(value: float) -> str:
    """Return a number that reads back to the last bit."""
    return f"{value:.17g}"


def term(value: float) -> str:
    """Return a number that can stand anywhere in a formula."""
    return f"({number(value)})"


def fill(formula: str, **numbers: float) -> str:
    """Put numbers into a formula, ``{name}`` by ``{name}``, and take its blanks out."""
    return formula.format(**{name: term(value) for name, value in numbers.items()}).replace(" ", "")
