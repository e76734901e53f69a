"""The section on heat of Scene.explain(): capacities, coefficients of pairs, sources, what is held."""

from __future__ import annotations

import numpy as np

from pydlpoly.formats.heat_block import OPEN
from pydlpoly.scene.model import Heat, HeatSource, Scene


def headers_and_rows(scene: Scene, heat: Heat) -> tuple[list[str], list[list[str]]]:
    """Return a table of the pairs that FIELD's block gives."""
    rows = [
        ["-".join(scene.species[k] for k in term.species), f"{term.conductivity:g}", f"{term.range:g}",
         f"{term.exponent:g}", _series(term.weight), _series(term.conduction), _series(term.drag)]
        for term in heat.terms
    ]  # fmt: skip
    return ["pair", "kappa", "range", "exponent", "power", "conductivity", "drag"], rows


def sentences(scene: Scene, heat: Heat) -> list[str]:
    """Return what the beads start with, how heat comes about, and what comes from outside."""
    units, beads = scene.units, scene.beads
    kelvin = f" {units.temperature_label}".rstrip()
    lines = [f"beads carry heat, from {heat.explanation}; reference temperature "
             f"{heat.reference / units.boltzmann:g}{kelvin}"]  # fmt: skip
    if beads.temperature is None or beads.heat_capacity is None:
        return lines
    for number, name in enumerate(scene.species):
        chosen = beads.species == number
        if chosen.any():
            start = _spread(beads.temperature[chosen] / units.boltzmann)
            held = " and keeps it" if number in heat.held else ""
            capacity = _spread(beads.heat_capacity[chosen])
            lines.append(f"{name}: heat capacity {capacity} k_B, starts at {start}{kelvin}{held}")
    lines.append(
        "heat from drag and noise: what they take from the kinetic energy of a pair, half to each bead"
        if heat.viscous_heating == "conserving"
        else "heat from drag and noise: LAMMPS's formula, which does not conserve energy"
    )
    if heat.scaled_repulsion:
        lines.append("conservative pair forces grow with the mean temperature of a pair: energy is not conserved")
    rate = f"{kelvin}/ps" if kelvin else ""
    lines += [
        f"source: {_place(scene, source)}, {source.rate / units.boltzmann:g}{rate}, from {source.explanation}"
        for source in heat.sources
    ]
    return lines


def _series(terms: tuple[float, ...]) -> str:
    return " ".join(f"{c:g}" for c in terms) if any(terms) else "-"


def _spread(values: np.ndarray) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _place(scene: Scene, source: HeatSource) -> str:
    numbers = source.numbers
    if source.kind == "species":
        return f"all beads {scene.species[int(numbers[0])]}"
    if source.kind == "sphere":
        return f"within {numbers[3]:g} of ({numbers[0]:g} {numbers[1]:g} {numbers[2]:g})"
    bounds = [
        f"{low:g} <= {axis} < {high:g}"
        for axis, low, high in zip("xyz", numbers[::2], numbers[1::2], strict=True)
        if low > -OPEN or high < OPEN
    ]
    return ", ".join(bounds)
