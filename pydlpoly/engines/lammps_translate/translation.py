"""A whole scene in LAMMPS's words, or the refusal that names what cannot be translated."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pydlpoly.engines.lammps_translate.bonded import BondedPart, bonded_part
from pydlpoly.engines.lammps_translate.carried import NOTHING, Carried, carried_of, refuse_carried, without_frozen_pairs
from pydlpoly.engines.lammps_translate.charges import ChargePart, charge_part
from pydlpoly.engines.lammps_translate.data import DataFile
from pydlpoly.engines.lammps_translate.exclusions import Exclusions, exclusions_of
from pydlpoly.engines.lammps_translate.formulas import number
from pydlpoly.engines.lammps_translate.heat import has_drag, heat_sources, heat_styles
from pydlpoly.engines.lammps_translate.integrators import fixes_of, refuse_integrator
from pydlpoly.engines.lammps_translate.many_body import FORCE_STYLE, bead_mass, many_body_styles
from pydlpoly.engines.lammps_translate.observed import Observed
from pydlpoly.engines.lammps_translate.pairs import SubStyle, conservative_styles, drag_styles
from pydlpoly.engines.lammps_translate.refusal import Places, refusal, refuse_unknown
from pydlpoly.engines.lammps_translate.species import species_sources, species_styles
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.cell import widths
from pydlpoly.scene.model import Bonded, Scene

SKIN = 0.3  # of the list of pairs, in units of the longest range
_ROOM = 1.5  # by how much bonded terms may stretch beyond what they are at the start
_LISTED = 1e-300  # a weight of pair forces that lets LAMMPS keep the pair in its lists
_SEEDS = 900_000_000  # LAMMPS takes seeds from 1 up to this


@dataclass(frozen=True)
class Translation:
    """A scene for LAMMPS.

    Attributes:
        before: commands up to the data file; ``after``: those behind it, up to the first step.
        data: the data file but for the beads' places and velocities.
        observed: what is reported in a step.
        carried: what beads carry; ``density_mass``: by what LAMMPS's local densities are to be divided.
        first_half: commands before the first step, see ``carried.Sources``.
    """

    before: tuple[str, ...]
    data: DataFile
    after: tuple[str, ...]
    observed: Observed
    carried: Carried = NOTHING
    density_mass: float = 1.0
    first_half: tuple[str, ...] = ()

    def commands(self, data_file: str) -> list[str]:
        """Return all commands up to the first step."""
        return [*self.before, f'read_data "{data_file}"', *self.after, *self.observed.commands()]

    def carried_computes(self) -> list[str]:
        """Return the commands that let what beads carry be read."""
        lines = ["compute carried_density all property/atom rho"] if self.carried.density else []
        lines += ["compute carried_heat all edpd/temp/atom"] if self.carried.heat else []
        count = self.carried.dissolved
        return [*lines, *(f"compute carried_{k} all tdpd/cc/atom {k}" for k in range(1, count + 1))]

    def carried_columns(self) -> list[str]:
        """Return the columns of those commands."""
        return [f"c_{line.split()[1]}" for line in self.carried_computes()]

    def script(self, scene: Scene, data_file: str, steps: int) -> Iterator[str]:
        """Yield the lines of an input script that runs the scene."""
        yield f"# {scene.title or 'a scene'}: written by pydlpoly convert --to lammps"
        yield "# Numbers are in angstrom, picoseconds, dalton and 10 J/mol, or reduced ones; k_B = 1."
        yield "# Mixed laws and drags are written out. Long-range corrections are not included."
        yield from (*self.before, f'read_data "{data_file}"', *self.after)
        yield "thermo_style custom step temp pe ke press evdwl ecoul elong ebond eangle edihed"
        yield "thermo_modify norm no temp moving"
        yield f"thermo {scene.output.statistics_every or scene.output.print_every or 100}"
        if scene.output.trajectory_every > 0:
            yield from self.carried_computes()
            columns = " ".join(["id type x y z ix iy iz vx vy vz", *self.carried_columns()])
            yield f"dump trajectory all custom {scene.output.trajectory_every} trajectory.lammpstrj {columns}"
        yield f"run {steps}"
        yield "write_data final.data"


def translate(scene: Scene, seed: int) -> Translation:
    """Return the scene in LAMMPS's words.

    Args:
        scene: what to model.
        seed: of LAMMPS's noise, see ``noise_seed``.

    Raises:
        SceneError: something in the scene has no equal in LAMMPS or is not translated; file and line are named.
    """
    places = Places(scene)
    refuse_carried(scene, places)
    carried = carried_of(scene)
    acting = without_frozen_pairs(scene) if carried.any else scene
    warm_repulsion = scene.heat is not None and scene.heat.scaled_repulsion
    conservative = [] if warm_repulsion else conservative_styles(acting, places)  # refuses laws by their lines
    refuse_unknown(scene, places)
    _check_cell(scene)
    refuse_integrator(scene, places)
    bonded, charges = scene.bonded, scene.electrostatics
    exclusions = exclusions_of(scene, places)
    terms = bonded_part(scene, bonded, exclusions.dummies, places) if bonded is not None else None
    charge = charge_part(scene, charges, places) if charges is not None else None
    drags = drag_styles(acting, seed) if scene.heat is None else []
    densities = many_body_styles(scene, seed, exclusions, places)
    exchange = [*heat_styles(scene, seed, places), *species_styles(scene, seed, places)]
    if densities and exchange and exclusions.any:
        raise refusal("mdpd with heat or dissolved species in molecules cannot be run", _field_of(scene))
    if warm_repulsion and exclusions.pair != exclusions.drag:
        message = "repulsion scaled with 1-4 factors of pair forces cannot be run"
        raise refusal(message, places.of_text(scene.heat.explanation if scene.heat is not None else ""))
    styles = [*densities, *conservative, *([charge.style] if charge is not None else [])]
    reach = reach_of(scene)
    margin = SKIN * reach
    sources = heat_sources(scene, margin, places) if carried.heat else species_sources(scene, margin, places)
    carried = replace(carried, supplies=sources.supplies)
    fixes = fixes_of(scene, seed, places)
    observed = Observed(
        drag=drags[0].name if drags else "",
        charge=charge.style.name if charge is not None else "",
        reciprocal=charge is not None and charge.reciprocal,
        kinds=tuple(kind for kind in ("bond", "angle", "dihedral") if terms is not None and _has(terms, kind)),
        thermostat=fixes.thermostat,
        drag_is_rest=_laws(conservative) if not warm_repulsion and scene.heat is not None and has_drag(scene) else None,
        many_body=next((style.name for style in densities if style.name == FORCE_STYLE), ""),
        supplies=carried.supplies,
        lumped=warm_repulsion and has_drag(scene),
    )
    if bonded is not None and reach >= 0.5 * float(widths(scene.cell).min()):
        message = f"bonded terms in a cell less than twice as wide as the longest range {reach:g} cannot be run"
        raise refusal(message, {"path": scene.sources[2]} if len(scene.sources) > 2 else {})
    return Translation(
        before=tuple(_before(scene, carried, exclusions, terms, charge, reach)),
        data=_data(scene, carried, terms),
        after=(
            *_pair_commands(acting, styles, drags, exchange, exclusions),
            *(charge.after if charge is not None else ()),
            *(terms.coefficients if terms is not None else ()),
            f"neighbor {number(SKIN * reach)} bin",
            "neigh_modify delay 0 every 1 check yes",
            *fixes.commands,
            *sources.commands,
        ),
        observed=observed,
        carried=carried,
        density_mass=bead_mass(scene, places) if densities else 1.0,
        first_half=sources.first_half,
    )


def noise_seed(seed: int, step: int) -> int:
    """Return the seed of LAMMPS's noise for a run that starts at this step; another step, another noise."""
    return int(np.random.SeedSequence([seed, step]).generate_state(1)[0]) % _SEEDS + 1


def _check_cell(scene: Scene) -> None:
    place = {"path": scene.sources[2]} if len(scene.sources) > 2 else {}
    if not all(scene.periodic):
        raise refusal("a cell that is not periodic along all three axes cannot be run", place)
    if np.any(np.triu(scene.cell, 1) != 0.0) or np.any(np.diag(scene.cell) <= 0.0):
        message = "a cell whose vectors are not (x, 0, 0), (x, y, 0), (x, y, z) with positive lengths cannot be run"
        raise refusal(message, place)
    for kind, name in enumerate(scene.species):
        masses = np.unique(scene.beads.mass[scene.beads.species == kind])
        if len(masses) > 1:
            field = {"path": scene.sources[1]} if len(scene.sources) > 1 else {}
            raise refusal(f"beads {name} of different masses cannot be run", {**field, "word": name})


def _has(terms: BondedPart, kind: str) -> bool:
    return any(style.startswith(f"{kind}_style") for style in terms.styles)


def reach_of(scene: Scene) -> float:
    """Return the longest range of any pair force, drag or charge."""
    reach = max((max(pair.cutoff if pair.law else 0.0, pair.drag_cutoff) for pair in scene.pairs), default=0.0)
    if scene.electrostatics is not None:
        reach = max(reach, scene.electrostatics.cutoff)
    if scene.heat is not None:
        reach = max(reach, *(term.range for term in scene.heat.terms), 0.0)
    if scene.transport is not None:
        reach = max(reach, *(flux.range for flux in scene.transport.fluxes), 0.0)
    return reach or scene.cutoff


def _laws(conservative: list[SubStyle]) -> tuple[str, ...]:
    return tuple(style.name for style in conservative)


def _field_of(scene: Scene) -> dict[str, str]:
    return {"path": scene.sources[1]} if len(scene.sources) > 1 else {}


def _before(
    scene: Scene,
    carried: Carried,
    exclusions: Exclusions,
    terms: BondedPart | None,
    charge: ChargePart | None,
    reach: float,
) -> Iterator[str]:
    yield "units lj"
    yield f"atom_style {carried.atom_style('full' if _charged(scene) else 'molecular')}"
    yield "boundary p p p"
    yield "newton on"
    span = _longest_term(scene, scene.bonded) if scene.bonded is not None else 0.0
    yield f"comm_modify vel yes cutoff {number(max((1.0 + SKIN) * reach, _ROOM * span))}"
    yield "box tilt large"
    yield from charge.before if charge is not None else ()
    yield from terms.styles if terms is not None else ()
    pair = exclusions.pair
    if carried.heat or carried.dissolved:  # these flow between excluded pairs, too, which have to be in the lists
        pair = tuple(weight or _LISTED for weight in pair)  # type: ignore[assignment]
    weights = (" ".join(map(number, given)) for given in (pair, exclusions.charge))
    yield "special_bonds lj {} coul {}".format(*weights)


def _charged(scene: Scene) -> bool:
    return scene.electrostatics is not None or any(field.key == "elec" for field in scene.external)


def _pair_commands(
    scene: Scene, styles: list[SubStyle], drags: list[SubStyle], exchange: list[SubStyle], exclusions: Exclusions
) -> Iterator[str]:
    """Yield the styles and their numbers; ``exchange`` is of what beads carry, and may have forces with it."""
    both = [*styles, *drags, *exchange]
    if not both:
        yield f"pair_style zero {number(scene.cutoff)}"
        yield "pair_coeff * *"
        return
    yield f"pair_style hybrid/overlay {' '.join(f'{style.name} {style.arguments}'.strip() for style in both)}"
    if not any(line.startswith("pair_coeff * *") for style in both for line in style.coefficients):
        # Pairs without any force have to be named.
        yield from (
            f"pair_coeff {min(p.species) + 1} {max(p.species) + 1} none"
            for p in scene.pairs
            if p.law is None and p.drag <= 0.0
        )
    for style in both:
        yield from style.coefficients
        yield from style.modify
    for style in drags:
        yield _special(style, exclusions.drag)
    if exchange:
        for style in styles:
            yield _special(style, exclusions.pair)
        for style in exchange:
            yield _special(style, exclusions.drag)


def _special(style: SubStyle, weights: tuple[float, float, float]) -> str:
    """Return the command that gives a sub-style its own weights of pairs that bonds exclude."""
    return f"pair_modify pair {style.label} special lj {' '.join(map(number, weights))}"


def _data(scene: Scene, carried: Carried, terms: BondedPart | None) -> DataFile:
    beads = scene.beads
    masses = [beads.mass[beads.species == kind] for kind in range(len(scene.species))]
    return DataFile(
        title=scene.title,
        cell=scene.cell,
        masses=tuple(float(mass[0]) if len(mass) else 1.0 for mass in masses),
        types=beads.species.astype(np.int64) + 1,
        molecules=beads.molecule.astype(np.int64) + 1,
        charges=beads.charge if _charged(scene) else None,
        rows=terms.rows if terms is not None else {},
        term_types=terms.types if terms is not None else {},
        carried=carried,
        capacities=beads.heat_capacity if carried.heat else None,
    )


def _longest_term(scene: Scene, bonded: Bonded) -> float:
    """Return the longest distance of two beads of one term, or of an excluded pair, at the start."""
    places: FloatArray = scene.beads.positions
    inverse = np.linalg.inv(scene.cell)

    def longest(first: NDArray[np.integer], second: NDArray[np.integer]) -> float:
        apart = (places[first] - places[second]) @ inverse
        apart -= np.rint(apart)
        return float(np.linalg.norm(apart @ scene.cell, axis=1).max(initial=0.0))

    spans = [longest(bonded.excluded[:, 0], bonded.excluded[:, 1])] if len(bonded.excluded) else [0.0]
    for term in bonded.terms:
        width = term.beads.shape[1]
        spans += [longest(term.beads[:, a], term.beads[:, b]) for a in range(width) for b in range(a + 1, width)]
    return max(spans)
