"""Control, Field and Configuration records -> Scene: units, consistency, cutoffs; every refusal happens below here."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from pydlpoly import _core
from pydlpoly.errors import SceneError
from pydlpoly.formats.records import Configuration, Control, ExternalLine, Field, FloatArray, PairTable
from pydlpoly.scene.beads import check_charges, check_configuration, lay_out
from pydlpoly.scene.cell import resolve_cell, widths, wrap
from pydlpoly.scene.dynamics import resolve_dynamics, resolve_run, settle_momentum, start_velocities
from pydlpoly.scene.laws import pair_laws
from pydlpoly.scene.model import Beads, Dynamics, ExternalTerm, PairTerm, Scene
from pydlpoly.scene.output import resolve_output
from pydlpoly.scene.pairs import PairRules, PairTableBuilder
from pydlpoly.scene.settings import Notes, Settings, place
from pydlpoly.units import ENERGY_UNITS, EnergyUnit, energy_unit

# These say which files to read and how: whoever made the records has followed them.
_FOLLOWED_BY_READERS = ("io_file_config", "io_file_field", "io_file_tabvdw", "ignore_config_indices")
# Beyond this many cells from the origin a coordinate in double precision says nothing about the place in the cell.
_FARTHEST = 1e9
# DL_POLY takes no cutoff below this (Å).
_LEAST_CUTOFF = 1.0


def resolve(
    control: Control,
    field: Field,
    config: Configuration,
    *,
    tables: Iterable[PairTable] = (),
    sources: Iterable[str] = (),
) -> Scene:
    """Return the complete scene that the three records describe.

    Args:
        control: the run's settings.
        field: molecules, pair laws and external fields.
        config: periodicity, cell, positions and, by level, velocities.
        tables: tabulated pair laws, for the ``tab`` pairs of ``field``.
        sources: names for the scene's list of sources; by default the records' own paths.

    Raises:
        SceneError: the records contradict each other, leave something undefined, or ask for what is not modelled; the
            text gives file, line, word and the cure.
    """
    notes, settings = Notes(), Settings(control)
    for record in (control, field, config):
        _keep_warnings(record.path, record.warnings, notes)
    settings.refuse_unmodelled()
    settings.consumed.update(_FOLLOWED_BY_READERS)
    _refuse_unmodelled_blocks(field)

    units, field_units = _units(settings, field, notes)
    dynamics = resolve_dynamics(settings, units.reduced, notes)
    layout = lay_out(field, notes)
    check_configuration(layout, field, config)
    check_charges(layout, settings, field, notes)
    external = _external(field, field_units.factor, config.imcon, notes)

    cutoff, vdw_cutoff = _cutoffs(settings, notes)
    cell, periodic = resolve_cell(config, cutoff, notes)
    rules = _pair_rules(settings, dynamics, cutoff, vdw_cutoff, notes)
    by_names = {tuple(sorted(table.species)): table for table in tables}
    pairs = PairTableBuilder(
        field, field_units.factor, layout.species_names, layout.counts(), layout.mobile_counts(), rules, by_names, notes
    ).build()
    _note_drags_without_thermostat(field, dynamics, notes)
    _note_ranges(
        pairs, layout.species_names, rules, cutoff, float(min([math.inf, *widths(cell)[list(periodic)]])), notes
    )

    dynamics, degrees = settle_momentum(dynamics, layout, external, settings, notes)
    run = resolve_run(settings, rules.thermostat, config, notes)
    fixed = dynamics.remove_drift or degrees == 3 * sum(layout.mobile_counts()) - 3
    beads = Beads(
        species=layout.species,
        mass=layout.mass,
        charge=layout.charge,
        frozen=layout.frozen,
        molecule=layout.molecule,
        positions=_wrapped(config, cell, periodic),
        velocities=start_velocities(config, layout, run, fixed, notes),
    )
    output = resolve_output(settings, field, layout.species_names, pairs, cutoff, notes)
    long_range = _long_range(settings, pairs, rules, periodic, notes)
    settings.finish(notes)
    return Scene(
        title=control.title or field.title,
        units=units,
        species=layout.species_names,
        beads=beads,
        cell=cell,
        imcon=config.imcon,
        periodic=periodic,
        pairs=pairs,
        external=external,
        cutoff=cutoff,
        vdw_cutoff=vdw_cutoff,
        dynamics=dynamics,
        run=run,
        output=output,
        degrees_of_freedom=degrees,
        long_range_correction=long_range,
        molecule_names=tuple(molecule.name for molecule in field.molecules),
        molecule_counts=tuple(molecule.count for molecule in field.molecules),
        field_units=field_units,
        notes=notes.all(),
        sources=tuple(sources) or (control.path, field.path, config.path),
    )


def _keep_warnings(path: str, warnings: Iterable[str], notes: Notes) -> None:
    """Take over what a reader noticed; its texts begin with the place, which a note has apart."""
    for warning in warnings:
        line, _, text = warning.removeprefix(f"{path}:").partition(": ")
        if warning.startswith(f"{path}:") and line.isdigit():
            notes.warning(text, place(path, int(line)))
        else:
            notes.warning(warning.removeprefix(f"{path}: "), place(path, None))


def _wrapped(config: Configuration, cell: FloatArray, periodic: tuple[bool, bool, bool]) -> FloatArray:
    shifts = np.abs(config.positions @ np.linalg.inv(cell))[:, list(periodic)]
    if (shifts > _FARTHEST).any():
        bead = int(np.nonzero((shifts > _FARTHEST).any(axis=1))[0][0])
        message = f"bead {bead + 1} ({config.names[bead]}) lies more than a thousand million cells away from the origin"
        raise SceneError(message, path=config.path)
    return wrap(config.positions, cell, periodic)


def _refuse_unmodelled_blocks(field: Field) -> None:
    for molecule in field.molecules:
        for block in molecule.blocks:
            if block.lines and molecule.count:
                message = f"the block {block.directive} of molecule {molecule.name} is not modelled yet"
                raise SceneError(message, path=field.path, line=block.line or None, word=block.directive)
    for other in field.others:
        message = f"the block {other.directive} is not modelled yet"
        raise SceneError(message, path=field.path, line=other.line or None, word=other.directive)


def _units(settings: Settings, field: Field, notes: Notes) -> tuple[EnergyUnit, EnergyUnit]:
    """Return the unit of reports and the unit of FIELD's numbers."""
    field_units = energy_unit(field.units, path=field.path)
    if settings.word("io_units_scheme") == "dpd" and not field_units.reduced:
        where = settings.where("io_units_scheme")
        notes.choice(
            f"io_units_scheme dpd: FIELD's numbers are in {field_units.label}, but all reports are in reduced units "
            "(energy 10 J/mol, k_B = 1, no katm)",
            where,
        )
        return ENERGY_UNITS["dpd"], field_units
    return field_units, field_units


def _external(field: Field, factor: float, imcon: int, notes: Notes) -> tuple[ExternalTerm, ...]:
    return tuple(_external_term(line, field, factor, imcon, notes) for line in field.externals)


def _external_term(line: ExternalLine, field: Field, factor: float, imcon: int, notes: Notes) -> ExternalTerm:
    def refusal(message: str) -> SceneError:
        return SceneError(message, path=field.path, line=line.line or None, word=line.key)

    if line.key not in ("grav", "oshr"):
        raise refusal("this external field is not modelled yet; grav and oshr are")
    names = {"grav": "Gx Gy Gz", "oshr": "A n"}[line.key]
    count, numbers = len(names.split()), line.parameters
    if len(numbers) < count or any(numbers[count:]):
        raise refusal(f"takes {count} numbers ({names}), found {len(numbers)}")
    numbers = numbers[:count]
    if not all(math.isfinite(x) for x in numbers):
        raise refusal("all numbers of an external field must be finite")
    where = place(field.path, line.line)
    if line.key == "grav":
        return ExternalTerm("grav", tuple(factor * x for x in numbers), where)
    if imcon not in (1, 2):
        raise refusal(f"oscillating shear needs a cubic or orthorhombic cell (imcon 1 or 2), not imcon {imcon}")
    if not numbers[1].is_integer():
        notes.warning(
            f"oshr with n = {numbers[1]:g}: the force jumps at the cell's face unless n is a whole number", where
        )
    return ExternalTerm("oshr", (factor * numbers[0], numbers[1]), where)


def _cutoffs(settings: Settings, notes: Notes) -> tuple[float, float]:
    """Return the global cutoff and the van der Waals cutoff (Å)."""
    cutoff, vdw = settings.number("cutoff"), settings.number("vdw_cutoff")
    for keyword, value in (("cutoff", cutoff), ("vdw_cutoff", vdw)):
        if not math.isfinite(value) or value == 0.0 or (keyword == "cutoff" and value < 0.0):
            raise settings.refusal(keyword, f"the cutoff must be above 0 ang, not {value:g}")
    if cutoff < _LEAST_CUTOFF:
        notes.choice(
            f"cutoff {cutoff:g} ang is used as it is; DL_POLY would take 1 ang instead", settings.where("cutoff")
        )
    if vdw < 0.0:
        return cutoff, cutoff
    where = settings.where("vdw_cutoff")
    if vdw < _LEAST_CUTOFF:
        notes.choice(f"vdw_cutoff {vdw:g} ang is used as it is; DL_POLY would take the global cutoff instead", where)
    if vdw > cutoff:
        notes.choice(f"the global cutoff is raised from {cutoff:g} to vdw_cutoff, {vdw:g} ang", where)
    return max(cutoff, vdw), vdw


def _pair_rules(settings: Settings, dynamics: Dynamics, cutoff: float, vdw_cutoff: float, notes: Notes) -> PairRules:
    method, mixing = settings.word("vdw_method"), settings.word("vdw_mix_method")
    if method == "tabulated" and settings.given("vdw_method"):
        text = "vdw_method tabulated: pair laws are computed from their formulas, as with direct"
        notes.choice(f"{text}, which has no table's interpolation error", settings.where("vdw_method"))
    if method == "off":
        notes.warning("vdw_method off: no conservative pair forces", settings.where("vdw_method"))
    rules = PairRules(
        mixing=None if mixing == "off" else mixing,
        thermostat=dynamics.integrator != "nve",
        fill_drag=None,
        override_drag=False,
        fill_where=settings.where("ensemble_dpd_drag"),
        thermal_energy=dynamics.thermal_energy,
        vdw_cutoff=vdw_cutoff,
        global_drag_cutoff=None,
        conservative=method != "off",
        force_shift=settings.switch("vdw_force_shift"),
    )
    return _with_thermostat(rules, settings, cutoff, notes) if rules.thermostat else rules


def _with_thermostat(rules: PairRules, settings: Settings, cutoff: float, notes: Notes) -> PairRules:
    """Return the rules with what CONTROL says about drags."""
    drag, where = settings.number("ensemble_dpd_drag"), settings.where("ensemble_dpd_drag")
    if drag < 0.0:
        notes.warning(f"negative ensemble_dpd_drag {drag:g}: the absolute value is taken, as DL_POLY does", where)
    override = settings.switch("ensemble_dpd_drag_override")
    if override and drag == 0.0:
        message = "needs ensemble_dpd_drag, the drag that is to replace those of FIELD"
        raise settings.refusal("ensemble_dpd_drag_override", message)
    if drag != 0.0 and not override:
        notes.choice(
            "ensemble_dpd_drag fills pairs that have no drag; DL_POLY up to 5.2 lets it replace FIELD's drags, as here "
            "with ensemble_dpd_drag_override on",
            where,
        )
    return replace(
        rules,
        fill_drag=abs(drag) or None,
        override_drag=override,
        global_drag_cutoff=cutoff if settings.word("ensemble_dpd_cutoff") == "global" else None,
    )


def _note_drags_without_thermostat(field: Field, dynamics: Dynamics, notes: Notes) -> None:
    if dynamics.integrator != "nve":
        return
    for line in field.pairs:
        slot = pair_laws()[line.key].drag_slot
        if slot and len(line.parameters) >= slot and line.parameters[slot - 1] != 0.0:
            text = f"the drag {line.parameters[slot - 1]:g} of {'-'.join(line.species)} has no effect under nve"
            notes.ignored(text, place(field.path, line.line))


def _note_ranges(
    pairs: tuple[PairTerm, ...],
    species: tuple[str, ...],
    rules: PairRules,
    cutoff: float,
    width: float,
    notes: Notes,
) -> None:
    """Say where cutoffs differ from what DL_POLY would do; ``width`` is the least one of the periodic cell."""

    def named(terms: Iterable[PairTerm]) -> str:
        return ", ".join("-".join(species[k] for k in term.species) for term in terms)

    own = [t for t in pairs if t.law not in (None, "tab") and _core.pair_range(t.law, list(t.parameters)) > 0.0]
    longer = [t for t in own if t.cutoff > cutoff]
    if longer:
        text = f"{named(longer)} keep the range of their law, beyond the global cutoff {cutoff:g} ang"
        notes.choice(f"{text}; DL_POLY truncates them there")
    others = [t for t in pairs if t.law is not None and t not in own]
    longest = max((t.cutoff for t in own), default=math.inf)
    if others and longest < rules.vdw_cutoff:
        text = f"{named(others)} end at the van der Waals cutoff {rules.vdw_cutoff:g} ang"
        notes.choice(f"{text}; DL_POLY cuts them at {longest:g} ang, the longest range that FIELD gives")
    reach = max((max(t.cutoff, t.drag_cutoff) for t in pairs), default=0.0)
    if reach >= 0.5 * width:
        text = (
            f"the longest range {reach:g} ang is at least half the cell's width, {width:g} ang: a bead may meet several"
        )
        notes.choice(f"{text} images of another, and all count; DL_POLY would stop (error 95)")


def _long_range(
    settings: Settings,
    pairs: tuple[PairTerm, ...],
    rules: PairRules,
    periodic: tuple[bool, bool, bool],
    notes: Notes,
) -> bool:
    """Return whether analytic tails are added: asked for, periodic along all axes, not force-shifted."""
    wanted = settings.switch("vdw_long_range_correction")
    where = settings.where("vdw_long_range_correction")
    has_tail = any(t.law is not None and pair_laws()[t.law].has_tail for t in pairs)
    if not wanted and has_tail:
        notes.choice("vdw_long_range_correction off: energy and pressure lack the tails beyond the cutoff", where)
    if not wanted or not has_tail:
        return wanted and all(periodic) and not rules.force_shift
    if not all(periodic):
        notes.choice("no long-range correction: the system is not periodic along every axis", where)
    if rules.force_shift:
        notes.choice("no long-range correction: forces are shifted to vanish at the cutoff", where)
    return all(periodic) and not rules.force_shift
