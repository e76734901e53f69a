"""Beads that carry heat as ``edpd``: drag and noise of warm beads, conduction, sources.

One instance of the style has the drag, another the conduction, so that their ranges are free of each other and their
noises independent; ``pair_coeff`` forgets the polynomials of the lines before it, so that a pair with polynomials has
an instance of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from pydlpoly.engines.lammps_translate import regions
from pydlpoly.engines.lammps_translate.carried import (
    Sources,
    first_half,
    frozen_species,
    kind_groups,
    mean_field_rate,
    source_part,
    supply_commands,
)
from pydlpoly.engines.lammps_translate.formulas import number
from pydlpoly.engines.lammps_translate.pairs import SubStyle, types_of
from pydlpoly.engines.lammps_translate.refusal import Places, refusal
from pydlpoly.scene.integrators import is_pairwise
from pydlpoly.scene.model import Heat, HeatSource, HeatTerm, PairTerm, Scene

STYLE = "edpd"
SUPPLY = "heat_supply"
_SEEDS = 400_000_000  # the style also takes twice its seed, which must stay below 900 000 000
_NO_TERM = (0.0, 0.0, 0.0, 0.0)

HEAT: tuple[tuple[str, str, str], ...] = (
    (
        "`repulsion scaled`",
        "`edpd` with A over T_ref, drag and noise with it",
        "energy and forces to 1e-10. One virial of repulsion, drag and noise is known: it stands under conservative",
    ),
    ("`repulsion constant`", "as the pair laws of every scene", "energy, forces and virial to 1e-10"),
    (
        "drag and noise of `mdvv`, `power`",
        "`edpd`",
        "drag to 1e-10 for large C_v: LAMMPS lacks its part of order 1/C_v. Other random numbers",
    ),
    ("`drag e1 …`", "refused", "LAMMPS has no drag that depends on temperature"),
    (
        "`viscous_heating lammps`",
        "`edpd`",
        "the same formula. Refused between beads of unequal masses, because LAMMPS takes that of one of them. In "
        "molecules LAMMPS gives this heat to pairs that bonds exclude, too",
    ),
    ("`viscous_heating conserving`", "refused where there is drag", "LAMMPS divides that heat by C_v twice"),
    (
        "`kappa`, `range`, `exponent`, `conductivity`",
        "an instance of `edpd` without forces, with its own range and noise",
        "the flux of a frame. The step is explicit: equal to the order of the timestep, and refused where Σ k w² Δt/C "
        "reaches 1. For unequal C_v LAMMPS lacks the drift of order 1/C_v. A κ below 0 stops the run",
    ),
    (
        "`source box`, `layer`, `sphere`, `species`, `region`",
        "`fix edpd/source` in a `region` with its images",
        "equal but for the limit of sinks to half of a bead's heat. Refused: boxes across a tilted axis, and spheres "
        "that reach across the cell's border",
    ),
    ("`wall`", "beads moved by `nve` alone", "equal; what they gave is what the internal energy of all changed by"),
    (
        "the balance",
        "Σ C_v T by the ranks, sources by `fix ave/time`",
        "equal. With drag it is no constant, as in the native engine with `viscous_heating lammps`",
    ),
)
"""What a scene says, what it becomes, and what is equal: rows of docs/lammps.md."""


@dataclass(frozen=True)
class EdpdRow:
    """The numbers of one ``pair_coeff`` of edpd, and its polynomials where it has any."""

    species: tuple[int, int]
    repulsion: float
    drag: float
    exponent: float
    cutoff: float
    conductivity: float = 0.0
    heat_exponent: float = 2.0
    weight: tuple[float, ...] = _NO_TERM
    conduction: tuple[float, ...] = _NO_TERM

    @property
    def polynomials(self) -> bool:
        """Whether there is a polynomial, which no other line of the same instance may have."""
        return any(self.weight) or any(self.conduction)

    def line(self, label: str = STYLE, heat_range: float | None = None) -> str:
        """Return the ``pair_coeff`` of a sub-style, or of the style itself where the label is empty."""
        reach = self.cutoff if heat_range is None else heat_range
        numbers = (self.repulsion, self.drag, self.exponent, self.cutoff, self.conductivity, self.heat_exponent, reach)
        words = [f"pair_coeff {types_of(self.species)}", label, *map(number, numbers)]
        if any(self.weight):
            words += ["power", *map(number, self.weight)]
        if any(self.conduction):
            words += ["kappa", *map(number, self.conduction)]
        return " ".join(word for word in words if word)


def about_one(factors: tuple[float, ...], reference: float) -> tuple[float, tuple[float, ...]] | None:
    """Return P(1) and c'_k of P(T) = 1 + Σ c_k (T/T_ref − 1)^k = P(1) (1 + Σ c'_k (T − 1)^k); None where P(1) is 0.

    LAMMPS's polynomials are about a temperature of 1.
    """
    if not any(factors) or reference == 1.0:
        return 1.0, factors
    inner = Polynomial([1.0 / reference - 1.0, 1.0 / reference])
    found = np.zeros(5)
    expanded = Polynomial([1.0, *factors])(inner).coef
    found[: len(expanded)] = expanded
    if found[0] == 0.0:
        return None
    return float(found[0]), tuple((found[1:] / found[0]).tolist())


def heat_styles(scene: Scene, seed: int, places: Places) -> list[SubStyle]:
    """Return the instances of edpd. Raises SceneError for what is refused."""
    heat = scene.heat
    if heat is None:
        return []
    _refuse(scene, heat, places)
    rows = [*_force_rows(scene, heat, places), *_conduction_rows(heat, places)]
    nothing = EdpdRow((0, 0), 0.0, 0.0, 2.0, scene.cutoff)  # the fix that moves the beads asks for the style
    return _instances(rows or [nothing], seed)


def has_drag(scene: Scene) -> bool:
    """Return whether any pair has drag and noise in this scene's integrator."""
    return is_pairwise(scene.dynamics.integrator) and any(pair.drag > 0.0 for pair in scene.pairs)


def heat_sources(scene: Scene, margin: float, places: Places) -> Sources:
    """Return the sources of heat. Raises SceneError for regions that are refused."""
    heat = scene.heat
    if heat is None or not heat.sources:
        return Sources()
    group = "exchanging" if heat.held else "all"
    lines = [regions.everywhere_command(), *kind_groups(scene)]
    given = []
    for order, source in enumerate(heat.sources):
        region, kinds, commands = _region(order, source, scene, margin, places)
        if region is None:
            continue
        kinds = [k for k in kinds if k not in heat.held]
        if not kinds:
            continue
        of = f"kind{kinds[0] + 1}" if source.kind == "species" else group
        lines += [*commands, f"fix source{order} {of} edpd/source region {region} {number(source.rate)}"]
        given.append(source_part(kinds, of, region, [capacity_of(scene, k) for k in kinds], source.rate))
    if not given:
        return Sources()
    lines += supply_commands({SUPPLY: [part.total for part in given]})
    half = first_half("edpd/temp", "carried_heat", given, scene.dynamics.timestep)
    return Sources(tuple(lines), (SUPPLY,), tuple(half))


def capacity_of(scene: Scene, kind: int) -> float:
    """Return the heat capacity of the beads of a species."""
    assert scene.beads.heat_capacity is not None
    values = scene.beads.heat_capacity[scene.beads.species == kind]
    return float(values[0]) if len(values) else 0.0


def _refuse(scene: Scene, heat: Heat, places: Places) -> None:
    where = places.of_text(heat.explanation)
    for kind, name in enumerate(scene.species):
        assert scene.beads.heat_capacity is not None
        if len(np.unique(scene.beads.heat_capacity[scene.beads.species == kind])) > 1:
            raise refusal(f"beads {name} of different heat capacities cannot be run", {**where, "word": name})
    if has_drag(scene) and heat.viscous_heating != "lammps":
        message = f"viscous_heating {heat.viscous_heating} cannot be run"
        raise refusal(message, where, "LAMMPS has the formula of viscous_heating lammps")
    rates = []
    for term in heat.terms:
        if term.conductivity > 0.0:
            largest = max(capacity_of(scene, k) for k in term.species)
            factor = _largest(term, scene)
            rates.append((term.species, largest * term.conductivity * factor, term.range, term.exponent))
    part = mean_field_rate(scene, rates) * scene.dynamics.timestep
    if part >= 1.0:
        message = f"a conduction that would change temperatures by {part:.3g} of their differences in a step"
        raise refusal(f"{message} cannot be run", where, "LAMMPS's step is explicit")


def _largest(term: HeatTerm, scene: Scene) -> float:
    """Return the largest factor of κ at the temperatures of the start."""
    assert scene.heat is not None
    assert scene.beads.temperature is not None
    values = np.unique(scene.beads.temperature) / scene.heat.reference - 1.0
    return float(Polynomial([1.0, *term.conduction])(values).max(initial=0.0))


def _force_rows(scene: Scene, heat: Heat, places: Places) -> list[EdpdRow]:
    terms = {term.species: term for term in heat.terms}
    still, drags = set(frozen_species(scene)), is_pairwise(scene.dynamics.integrator)
    rows = []
    for pair in scene.pairs:
        if still.issuperset(pair.species):
            continue
        drag = pair.drag if drags else 0.0
        term = terms.get(pair.species)
        if drag > 0.0:
            _refuse_drag(scene, pair, term, places)
        exponent, weight = _weight(scene, heat, term, places)
        repulsion = pair.parameters[0] / heat.reference if heat.scaled_repulsion and pair.law is not None else 0.0
        if repulsion != 0.0 and drag > 0.0 and pair.cutoff == pair.drag_cutoff:
            rows.append(EdpdRow(pair.species, repulsion, drag, exponent, pair.cutoff, weight=weight))
            continue
        if repulsion != 0.0:
            rows.append(EdpdRow(pair.species, repulsion, 0.0, 2.0, pair.cutoff))
        if drag > 0.0:
            rows.append(EdpdRow(pair.species, 0.0, drag, exponent, pair.drag_cutoff, weight=weight))
    return rows


def _refuse_drag(scene: Scene, pair: PairTerm, term: HeatTerm | None, places: Places) -> None:
    names = " ".join(scene.species[k] for k in pair.species)
    if term is not None and any(term.drag):
        where = {**places.of_text(term.explanation), "word": "drag"}
        raise refusal(f"a drag of {names} that depends on temperature cannot be run", where, "LAMMPS has none")
    masses = [float(m) for k in pair.species for m in scene.beads.mass[scene.beads.species == k][:1]]
    if len(set(masses)) > 1:
        message = f"drag and noise of {names}, which differ in mass and carry heat, cannot be run"
        raise refusal(message, places.of_text(pair.explanation), "LAMMPS's heat takes the mass of one of them")


def _weight(scene: Scene, heat: Heat, term: HeatTerm | None, places: Places) -> tuple[float, tuple[float, ...]]:
    """Return the exponent of w^D at a temperature of 1 and its polynomial about it."""
    exponent = scene.dynamics.weight_exponent
    if term is None or not any(term.weight):
        return exponent, _NO_TERM
    factor, weight = _about_one(term.weight, heat, term, "power", places)
    return exponent * factor, weight


def _conduction_rows(heat: Heat, places: Places) -> list[EdpdRow]:
    rows = []
    for term in heat.terms:
        if term.conductivity <= 0.0:
            continue
        factor, conduction = _about_one(term.conduction, heat, term, "conductivity", places)
        numbers = (term.range, term.conductivity * factor, term.exponent)
        rows.append(EdpdRow(term.species, 0.0, 0.0, 2.0, *numbers, conduction=conduction))
    return rows


def _about_one(
    factors: tuple[float, ...], heat: Heat, term: HeatTerm, word: str, places: Places
) -> tuple[float, tuple[float, ...]]:
    found = about_one(factors, heat.reference)
    if found is None:
        where = {**places.of_text(term.explanation), "word": word}
        raise refusal(f"a {word} that is 0 at k_B T = 1 cannot be run", where, "LAMMPS's polynomials are about 1")
    return found


def _instances(rows: list[EdpdRow], seed: int) -> list[SubStyle]:
    """Share the rows out: polynomials alone, others together as long as no pair comes twice."""
    groups: list[list[EdpdRow]] = []
    for row in rows:
        open_to = (
            group
            for group in groups
            if not row.polynomials and not group[0].polynomials and all(one.species != row.species for one in group)
        )
        group = next(open_to, None)
        if group is None:
            groups.append([row])
        else:
            group.append(row)
    styles = []
    for k, group in enumerate(groups, 1):
        instance = k if len(groups) > 1 else 0
        label = f"{STYLE} {instance}" if instance else STYLE
        reach = max(row.cutoff for row in group)
        own = (seed + 104_729 * k) % (_SEEDS - 1) + 1
        lines = tuple(row.line(label) for row in group)
        styles.append(SubStyle(STYLE, f"{number(reach)} {own}", lines, instance=instance))
    return styles


def _region(
    order: int, source: HeatSource, scene: Scene, margin: float, places: Places
) -> tuple[str | None, list[int], list[str]]:
    """Return the region of a source, the species it acts on, and the commands that make it; no region without any."""
    every = list(range(len(scene.species)))
    if source.kind == "species":
        return regions.EVERYWHERE, [int(source.numbers[0])], []
    name = f"source{order}_region"
    where = places.of_text(source.explanation)
    if source.kind == "sphere":
        centre, radius = source.numbers[:3], source.numbers[3]
        if regions.sphere_crosses_border(centre, radius, scene.cell):
            message = "a source in a sphere that reaches across the cell's border cannot be run"
            raise refusal(message, where, "here it ends there, in LAMMPS's images it does not")
        return name, every, regions.sphere_commands(name, centre, radius, scene.cell, margin)
    commands = regions.box_commands(name, source.numbers, scene.cell, margin)
    if commands is None:
        raise refusal("a source in a box across a tilted axis of the cell cannot be run", where)
    return (name if commands else None), every, commands
