"""Dissolved species in words, for ``explain``."""

from __future__ import annotations

import math

import numpy as np

from pydlpoly.scene.model import Scene
from pydlpoly.scene.transport_terms import NO_BOUND, Region, Transport

_NOISES = {
    "off": "without a random part",
    "sqrt": "random fluxes grow as the root of the concentrations",
    "lammps": "random fluxes grow as the concentrations, normal numbers cut to 5, as in LAMMPS",
}


def headers_and_rows(scene: Scene, transport: Transport) -> tuple[list[str], list[list[str]]]:
    """Return the table of fluxes."""
    headers = ["pair", "dissolved", "kappa", "range", "exponent", "noise", "from"]
    rows = [
        [
            "-".join(scene.species[k] for k in flux.species),
            transport.species[flux.dissolved],
            f"{flux.rate:g}",
            f"{flux.range:g}",
            f"{flux.exponent:g}",
            f"{flux.noise:g}",
            flux.explanation,
        ]
        for flux in transport.fluxes
    ]
    return headers, rows


def sentences(scene: Scene, transport: Transport) -> list[str]:
    """Return what the table does not say, one sentence a line."""
    names, start = transport.species, scene.beads.concentrations
    lines = [_NOISES[transport.noise] + "; every pair by its exact solution, amounts stay from 0 on"]
    if start is not None:
        for number, name in enumerate(names):
            column = start[:, number]
            low, high = float(np.min(column)), float(np.max(column))
            spread = f"{low:g} in every bead" if low == high else f"{low:g} to {high:g} a bead"
            lines.append(f"start: {name} {spread}, {math.fsum(column.tolist()):.9g} in all")
    lines += [
        f"source: {names[s.dissolved]} {s.value:g} a bead and time {_where(scene, s.region)} [{s.explanation}]"
        for s in transport.sources
    ]
    lines += [
        f"held: {names[h.dissolved]} {h.value:g} {_where(scene, h.region)} [{h.explanation}]" for h in transport.holds
    ]
    for reaction in transport.reactions:
        place = "" if reaction.species < 0 else f" in {scene.species[reaction.species]}"
        factors = " ".join(f"C({names[k]})" for k in reaction.reactants)
        lines.append(f"reaction: {reaction.equation}{place}, rate {reaction.rate:g} {factors} [{reaction.explanation}]")
    return lines


def _side(axis: str, low: float, high: float) -> str:
    text = axis
    if high < NO_BOUND:
        text = f"{text} < {high:g}"
    if low > -NO_BOUND:
        text = f"{low:g} <= {text}"
    return "" if text == axis else text


def _where(scene: Scene, region: Region) -> str:
    numbers = region.numbers
    if region.kind == "species":
        return f"in {scene.species[int(numbers[0])]}"
    if region.kind == "box":
        sides = [_side(*side) for side in zip("xyz", numbers[::2], numbers[1::2], strict=True)]
        return "where " + " and ".join(side for side in sides if side) if any(sides) else "everywhere"
    if region.kind == "sphere":
        x, y, z, radius = numbers
        return f"within {radius:g} of ({x:g} {y:g} {z:g})"
    return "everywhere"
