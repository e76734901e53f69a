"""Dissolved species as ``tdpd``: their exchange alone, beside the forces that every scene has; sources and held beads.

A pair whose dissolved species have several ranges is in several instances of the style.
"""

from __future__ import annotations

from collections.abc import Sequence

from pydlpoly.engines.lammps_translate import regions
from pydlpoly.engines.lammps_translate.carried import (
    SourceParts,
    Sources,
    carried_of,
    first_half,
    kind_groups,
    mean_field_rate,
    source_part,
    supply_commands,
)
from pydlpoly.engines.lammps_translate.formulas import number
from pydlpoly.engines.lammps_translate.pairs import SubStyle, types_of
from pydlpoly.engines.lammps_translate.refusal import Places, refusal
from pydlpoly.scene.model import Scene
from pydlpoly.scene.transport_terms import SpeciesFlux, SpeciesValue, Transport

STYLE = "tdpd"
_SEEDS = 900_000_000

SPECIES: tuple[tuple[str, str, str], ...] = (
    (
        "`pair … kappa`, `range`, `exponent`",
        "instances of `tdpd` without forces, one for each range that a pair has",
        "the flux of a frame. The step is explicit: equal to the order of the timestep, and refused where κ Σ w² Δt "
        "reaches 1",
    ),
    (
        "`noise lammps`, ε",
        "`tdpd`",
        "the same law with other random numbers; amounts may fall below 0 in LAMMPS, which stops the run",
    ),
    ("`noise sqrt`", "refused", "LAMMPS's noise grows as the concentrations"),
    ("`start`, BEADS", "columns of the data file", "equal"),
    (
        "`source`",
        "`fix tdpd/source` in a `region` with its images",
        "equal but for sinks, which here take no more than there is. Refused: boxes across a tilted axis",
    ),
    (
        "`hold`",
        "beads moved by `nve` alone",
        "equal where all dissolved species of these beads are held, else refused; what they gave is what is missing in "
        "the sum",
    ),
    ("`reaction`", "refused", "LAMMPS has none"),
    ("forces, drag, integrators", "as in every scene", "as in every scene; `hoover` is refused"),
    ("the balance", "ΣC by the ranks, sources by `fix ave/time`", "equal"),
)
"""What a scene says, what it becomes, and what is equal: rows of docs/lammps.md."""


def species_styles(scene: Scene, seed: int, places: Places) -> list[SubStyle]:
    """Return the instances of tdpd. Raises SceneError for what is refused."""
    transport = scene.transport
    if transport is None:
        return []
    _refuse(scene, transport, places)
    nothing = SpeciesFlux((0, 0), 0, 0.0, scene.cutoff)  # the fix that moves the beads asks for the style
    groups = flux_groups(transport.fluxes or (nothing,))
    styles = []
    for k, group in enumerate(groups, 1):
        instance = k if len(groups) > 1 else 0
        label = f"{STYLE} {instance}" if instance else STYLE
        reach = max(fluxes[0].range for fluxes in group.values())
        lines = []
        for pair, fluxes in group.items():
            edge = number(fluxes[0].range)
            numbers = flux_numbers(fluxes, len(transport.species))
            lines.append(f"pair_coeff {types_of(pair)} {label} 0.0 0.0 2.0 {edge} {edge} {numbers}")
        own = (seed + 104_729 * k) % (_SEEDS - 1) + 1
        styles.append(SubStyle(STYLE, f"0.0 {number(reach)} {own}", tuple(lines), instance=instance))
    return styles


def flux_groups(fluxes: Sequence[SpeciesFlux]) -> list[dict[tuple[int, int], list[SpeciesFlux]]]:
    """Share the fluxes out to instances of the style, in each of which a pair has one range."""
    by_range: dict[tuple[int, int], dict[float, list[SpeciesFlux]]] = {}
    for flux in fluxes:
        by_range.setdefault(flux.species, {}).setdefault(flux.range, []).append(flux)
    groups: list[dict[tuple[int, int], list[SpeciesFlux]]] = []
    for pair, ranges in by_range.items():
        for k, same in enumerate(ranges.values()):
            if k == len(groups):
                groups.append({})
            groups[k][pair] = same
    return groups


def flux_numbers(fluxes: Sequence[SpeciesFlux], dissolved: int) -> str:
    """Return κ, ε and exponent of every dissolved species in a ``pair_coeff``; zero for those that do not flow."""
    found = {flux.dissolved: flux for flux in fluxes}
    rows = []
    for k in range(dissolved):
        flux = found.get(k)
        rows.append("0.0 0.0 2.0" if flux is None else " ".join(map(number, (flux.rate, flux.noise, flux.exponent))))
    return " ".join(rows)


def species_sources(scene: Scene, margin: float, places: Places) -> Sources:
    """Return the sources of dissolved species. Raises SceneError for regions that are refused."""
    transport = scene.transport
    if transport is None or not transport.sources:
        return Sources()
    held = carried_of(scene).held
    lines = [regions.everywhere_command(), *kind_groups(scene)]
    totals: dict[str, list[str]] = {}
    acting: dict[int, list[SourceParts]] = {}
    for order, source in enumerate(transport.sources):
        region, kinds, commands = _region(order, source, scene, margin, places)
        if region is None:
            continue
        of = f"kind{kinds[0] + 1}" if source.region.kind == "species" else ("exchanging" if held else "all")
        # Beads that are held get their share of sources, too, and give it back at once.
        part = source_part(kinds, of, region, [1.0] * len(kinds), source.value)
        lines += commands
        totals.setdefault(supply_name(source.dissolved), []).append(part.total)
        if set(kinds) - set(held):
            lines.append(
                f"fix source{order} {of} tdpd/source {source.dissolved + 1} region {region} {number(source.value)}"
            )
            acting.setdefault(source.dissolved, []).append(part)
    half = []
    for dissolved, parts in acting.items():
        half += first_half(f"cc {dissolved + 1}", f"carried_{dissolved + 1}", parts, scene.dynamics.timestep)
    return Sources((*lines, *supply_commands(totals)), tuple(totals), tuple(half))


def supply_name(dissolved: int) -> str:
    """Return the name of the variable of what sources give of a dissolved species."""
    return f"supply{dissolved + 1}"


def _refuse(scene: Scene, transport: Transport, places: Places) -> None:
    for reaction in transport.reactions:
        message = f"the reaction {reaction.equation} cannot be run".replace("  ", " ")
        raise refusal(message, places.of_text(reaction.explanation), "LAMMPS has no reactions of dissolved species")
    if transport.noise == "sqrt":
        words = next((flux.explanation for flux in transport.fluxes if flux.noise > 0.0), "")
        raise refusal("noise sqrt cannot be run", places.of_text(words), "LAMMPS's noise grows as the concentrations")
    _refuse_holds(scene, transport, places)
    if scene.dynamics.integrator == "hoover":
        where = places.of_setting("ensemble_method")
        raise refusal("dissolved species cannot be run with hoover", where, "LAMMPS moves them with steps of nve alone")
    for dissolved, name in enumerate(transport.species):
        fluxes = [flux for flux in transport.fluxes if flux.dissolved == dissolved]
        rates = [(flux.species, flux.rate, flux.range, flux.exponent) for flux in fluxes]
        part = mean_field_rate(scene, rates) * scene.dynamics.timestep
        if part >= 1.0:
            message = f"an exchange that would move {part:.3g} of the differences of {name} in a step cannot be run"
            raise refusal(message, places.of_text(fluxes[0].explanation), "LAMMPS's step is explicit")


def _refuse_holds(scene: Scene, transport: Transport, places: Places) -> None:
    held: dict[int, set[int]] = {}
    for hold in transport.holds:
        held.setdefault(int(hold.region.numbers[0]), set()).add(hold.dissolved)
    for kind, which in held.items():
        if len(which) < len(transport.species):
            words = next(h.explanation for h in transport.holds if int(h.region.numbers[0]) == kind)
            message = f"beads {scene.species[kind]} that hold some dissolved species and exchange others cannot be run"
            raise refusal(message, places.of_text(words))


def _region(
    order: int, source: SpeciesValue, scene: Scene, margin: float, places: Places
) -> tuple[str | None, list[int], list[str]]:
    """Return the region of a source, the species it acts on, and the commands that make it; no region without any."""
    every, region = list(range(len(scene.species))), source.region
    if region.kind == "everywhere":
        return regions.EVERYWHERE, every, []
    if region.kind == "species":
        return regions.EVERYWHERE, [int(region.numbers[0])], []
    name = f"source{order}_region"
    if region.kind == "sphere":
        return name, every, regions.sphere_commands(name, region.numbers[:3], region.numbers[3], scene.cell, margin)
    commands = regions.box_commands(name, region.numbers, scene.cell, margin)
    if commands is None:
        where = places.of_text(source.explanation)
        raise refusal("a source in a box across a tilted axis of the cell cannot be run", where)
    return (name if commands else None), every, commands
