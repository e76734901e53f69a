"""Dissolved species in LAMMPS's words: ``atom_style`` and ``pair_style tdpd``, start values and sources."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pydlpoly.scene.model import Scene
from pydlpoly.scene.transport_terms import Region, SpeciesFlux, SpeciesValue, Transport


@dataclass(frozen=True)
class TransportCommands:
    """What a scene's dissolved species need.

    Attributes:
        atom_style: with its number of species.
        settings: of ``pair_style tdpd``; ``coefficients``: of ``pair_coeff``, one line a pair.
        dynamics: commands after the beads, in place of the integrator's.
    """

    atom_style: str
    settings: str
    coefficients: list[str]
    dynamics: list[str]


def transport_commands(scene: Scene, transport: Transport) -> TransportCommands | str:
    """Return the commands, or in words why the scene is not translated."""
    if transport.reactions or transport.holds:
        return "reactions and held concentrations are not translated"
    if transport.noise == "sqrt":
        return "noise sqrt is not translated: LAMMPS has random fluxes that grow as the concentrations"
    start = scene.beads.concentrations
    if start is None or not (start == start[0]).all():
        return "start concentrations that differ between beads are not translated"
    ends = np.diag(scene.cell) / 2.0
    sources = [_source(number, source, ends.tolist()) for number, source in enumerate(transport.sources)]
    if None in sources:
        return "sources other than boxes and everywhere are not translated"
    coefficients = []
    for term in scene.pairs:
        fluxes = [flux for flux in transport.fluxes if flux.species == term.species]
        ranges = {flux.range for flux in fluxes} or {term.cutoff}
        if len(ranges) > 1 or max(ranges) > term.cutoff:
            return "exchange farther than the pair law, or with several ranges of one pair, is not translated"
        low, high = (k + 1 for k in term.species)
        numbers = [_flux(fluxes, k) for k in range(len(transport.species))]
        weight = scene.dynamics.weight_exponent
        coefficients.append(
            f"{low} {high} {term.parameters[0]} {term.drag} {weight} {term.cutoff} {ranges.pop()} {' '.join(numbers)}"
        )
    largest = max(term.cutoff for term in scene.pairs)
    return TransportCommands(
        atom_style=f"tdpd {len(transport.species)}",
        settings=f"{scene.dynamics.thermal_energy} {largest} 34387",
        coefficients=coefficients,
        dynamics=[
            f"timestep {scene.dynamics.timestep}",
            *(f"set atom * cc {k + 1} {value:.17g}" for k, value in enumerate(start[0].tolist())),
            "fix motion all mvv/tdpd 0.5",
            *(source for source in sources if source),
            "thermo 100",
        ],
    )


def _flux(fluxes: list[SpeciesFlux], dissolved: int) -> str:
    for flux in fluxes:
        if flux.dissolved == dissolved:
            return f"{flux.rate} {flux.noise} {flux.exponent}"
    return "0.0 0.0 2.0"


def _source(number: int, source: SpeciesValue, ends: list[float]) -> str | None:
    region = _cuboid(source.region, ends)
    return (
        None if region is None else f"fix source{number} all tdpd/source {source.dissolved + 1} {region} {source.value}"
    )


def _cuboid(region: Region, ends: list[float]) -> str | None:
    """Return LAMMPS's centre and edges; its spheres compare r^2 with R^3 and are left out."""
    if region.kind not in ("everywhere", "box"):
        return None
    numbers = region.numbers or (-np.inf, np.inf) * 3
    low = [max(a, -end) for a, end in zip(numbers[::2], ends, strict=True)]
    high = [min(b, end) for b, end in zip(numbers[1::2], ends, strict=True)]
    centre = " ".join(f"{0.5 * (a + b):.17g}" for a, b in zip(low, high, strict=True))
    edges = " ".join(f"{b - a:.17g}" for a, b in zip(low, high, strict=True))
    return f"cuboid {centre} {edges}"
