"""Beads that carry something in LAMMPS's words for the benchmark: whole simple scenes in one pair style each.

The numbers of ``pair_coeff`` are those of the engine lammps (``pydlpoly.engines.lammps_translate``); where that engine
has a style for each part of the forces, here one style has them all, which is how LAMMPS is fastest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pydlpoly.engines.lammps_translate.formulas import number
from pydlpoly.engines.lammps_translate.heat import EdpdRow
from pydlpoly.engines.lammps_translate.many_body import density_coefficients
from pydlpoly.engines.lammps_translate.pairs import types_of
from pydlpoly.engines.lammps_translate.species import flux_groups, flux_numbers
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Heat, ManyBody, Scene
from pydlpoly.scene.transport_terms import SpeciesValue, Transport

SEED = 34387


@dataclass(frozen=True)
class CarriedCommands:
    """What a scene needs whose beads carry something.

    Attributes:
        atom_style: with its arguments.
        pairs: the commands of the pair style.
        states: what beads have, and sources, after the beads.
        motion: the fix that moves them.
    """

    atom_style: str
    pairs: list[str]
    states: list[str]
    motion: str


def heat_commands(scene: Scene, heat: Heat) -> CarriedCommands | str:
    """Return the commands of pair style edpd, or in words why the scene is not translated; sources in boxes only."""
    if scene.dynamics.integrator != "mdvv" or len(scene.pairs) != 1 or len(heat.terms) != 1 or heat.held:
        return "beads that carry heat are translated for one species and mdvv"
    if heat.viscous_heating != "lammps" or not heat.scaled_repulsion:
        return "LAMMPS has no conserving heat of drag and noise, and its repulsion grows with the temperature"
    pair, term, beads = scene.pairs[0], heat.terms[0], scene.beads
    unfit = pair.law != "dpd" or term.range != pair.cutoff or heat.reference != 1.0 or any(term.drag)
    if unfit or any(source.kind != "box" for source in heat.sources):
        return "LAMMPS's pair style edpd has not all that this scene asks for"
    if beads.temperature is None or beads.heat_capacity is None:
        return "beads without temperatures"
    row = EdpdRow(
        pair.species, pair.parameters[0], pair.drag, scene.dynamics.weight_exponent, pair.cutoff, term.conductivity,
        term.exponent, term.weight, term.conduction,
    )  # fmt: skip
    states = [
        f"set atom * edpd/temp {number(beads.temperature[0])}",
        f"set atom * edpd/cv {number(beads.heat_capacity[0])}",
    ]
    for k, source in enumerate(heat.sources):
        states.append(
            f"fix source{k} all edpd/source cuboid {_cuboid(source.numbers, scene.cell)} {number(source.rate)}"
        )
    pairs = [f"pair_style edpd {pair.cutoff} {SEED}", row.line("")]
    return CarriedCommands("edpd", pairs, states, "mvv/edpd 0.5")


def many_body_commands(scene: Scene, given: ManyBody | None) -> CarriedCommands | str:
    """Return the commands of densities by one pair style and forces by another, or why the scene is not translated."""
    if given is None or given.kernel != "lucy" or scene.bonded is not None:
        return "many-body DPD is only translated with Lucy's kernel, which LAMMPS has, and without bonds"
    if scene.dynamics.integrator != "mdvv":
        return "only the integrator mdvv is translated for mdpd"
    if any(term.drag_cutoff != term.cutoff for term in scene.pairs if term.drag > 0.0):
        return "drags of other ranges than the pair law are not translated"
    largest = max(term.cutoff for term in scene.pairs)
    pairs = [f"pair_style hybrid/overlay mdpd/rhosum mdpd {scene.dynamics.thermal_energy} {largest} {SEED}"]
    pairs += density_coefficients(given)
    for term in scene.pairs:
        a, b, _, _, cutoff, reach = term.parameters
        pairs.append(f"pair_coeff {types_of(term.species)} mdpd {a} {b} {term.drag} {cutoff} {reach}")
    return CarriedCommands("mdpd", pairs, [], f"mvv/dpd {scene.dynamics.prediction}")


def species_commands(scene: Scene, transport: Transport) -> CarriedCommands | str:
    """Return the commands of pair style tdpd, or in words why the scene is not translated."""
    if scene.bonded is not None:
        return "dissolved species in molecules are not translated"
    if transport.reactions or transport.holds:
        return "reactions and held concentrations are not translated"
    if transport.noise == "sqrt":
        return "noise sqrt is not translated: LAMMPS has random fluxes that grow as the concentrations"
    start = scene.beads.concentrations
    if start is None or not (start == start[0]).all():
        return "start concentrations that differ between beads are not translated"
    sources = [_species_source(k, source, scene.cell) for k, source in enumerate(transport.sources)]
    if None in sources:
        return "sources other than boxes and everywhere are not translated"
    groups = flux_groups(transport.fluxes)
    largest = max(term.cutoff for term in scene.pairs)
    pairs = [f"pair_style tdpd {scene.dynamics.thermal_energy} {largest} {SEED}"]
    for term in scene.pairs:
        fluxes = groups[0].get(term.species, []) if groups else []
        reach = fluxes[0].range if fluxes else term.cutoff
        if reach > term.cutoff or any(term.species in group for group in groups[1:]):
            return "exchange farther than the pair law, or with several ranges of one pair, is not translated"
        law = f"{term.parameters[0]} {term.drag} {scene.dynamics.weight_exponent} {term.cutoff} {reach}"
        pairs.append(f"pair_coeff {types_of(term.species)} {law} {flux_numbers(fluxes, len(transport.species))}")
    states = [f"set atom * cc {k + 1} {number(value)}" for k, value in enumerate(start[0].tolist())]
    states += [source for source in sources if source]
    return CarriedCommands(f"tdpd {len(transport.species)}", pairs, states, "mvv/tdpd 0.5")


def _species_source(order: int, source: SpeciesValue, cell: FloatArray) -> str | None:
    if source.region.kind not in ("everywhere", "box"):
        return None  # LAMMPS's spheres compare r^2 with R^3
    region = _cuboid(source.region.numbers or (-np.inf, np.inf) * 3, cell)
    return f"fix source{order} all tdpd/source {source.dissolved + 1} cuboid {region} {source.value}"


def _cuboid(bounds: Sequence[float], cell: FloatArray) -> str:
    """Return LAMMPS's centre and edges of the part of a box that is in the cell around the origin."""
    half = 0.5 * np.repeat(np.diag(cell), 2)
    inside = np.clip(bounds, -half, half)
    low, high = inside[::2], inside[1::2]
    return " ".join(map(number, (*(0.5 * (low + high)), *(high - low))))
