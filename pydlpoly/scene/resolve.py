"""Control, Field and Configuration records -> Scene: every refusal happens here or in what is called from here."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from pydlpoly.errors import SceneError
from pydlpoly.formats.records import BeadTable, BondedTable, Configuration, Control, Field, FloatArray, PairTable
from pydlpoly.scene.barostat import check_barostat, resolve_barostat, shape_of
from pydlpoly.scene.beads import Layout, check_configuration, lay_out
from pydlpoly.scene.beads_state import repeated_table, with_bead_table
from pydlpoly.scene.bins import check_bins
from pydlpoly.scene.bonded import resolve_bonded
from pydlpoly.scene.bonded_laws import KINDS
from pydlpoly.scene.cell import resolve_cell, widths, wrap
from pydlpoly.scene.charges import Strength, resolve_charges
from pydlpoly.scene.constraints import left_by, resolve_constraints
from pydlpoly.scene.dynamics import check_limits, resolve_dynamics, resolve_run, settle_momentum, start_velocities
from pydlpoly.scene.external import ON_CHARGES, resolve_external
from pydlpoly.scene.heat import resolve_heat
from pydlpoly.scene.interactions import (
    check_image_noise,
    check_images,
    long_range_correction,
    note_small_cell,
    resolve_cutoffs,
    resolve_pairs,
)
from pydlpoly.scene.many_body import check_many_body, resolve_many_body
from pydlpoly.scene.model import Beads, Scene
from pydlpoly.scene.output import resolve_output
from pydlpoly.scene.replicate import replicate_as_asked
from pydlpoly.scene.settings import Notes, Settings, place
from pydlpoly.scene.shear import SHEARED_SHAPE, check_shear, resolve_shear
from pydlpoly.scene.stress import check_profile
from pydlpoly.scene.transport import resolve_transport, start_concentrations
from pydlpoly.scene.walls import check_beads_inside, open_axes, resolve_walls
from pydlpoly.units import ENERGY_UNITS, EnergyUnit, energy_unit

# These say which files to read and how: whoever made the records has followed them.
_FOLLOWED_BY_READERS = (
    "io_file_config",
    "io_file_field",
    "io_file_beads",
    *(f"io_file_{name}" for name in ("tabvdw", "tabbnd", "tabang", "tabdih", "tabinv")),
    "ignore_config_indices",
)
# Beyond this many cells from the origin a coordinate in double precision says nothing about the place in the cell.
_FARTHEST = 1e9


def resolve(
    control: Control,
    field: Field,
    config: Configuration,
    *,
    tables: Iterable[PairTable] = (),
    bonded_tables: Iterable[BondedTable] = (),
    bead_table: BeadTable | None = None,
    sources: Iterable[str] = (),
) -> Scene:
    """Return the complete scene that the three records describe.

    Args:
        control: the run's settings.
        field: molecules, pair laws and external fields.
        config: periodicity, cell, positions and, by level, velocities.
        tables: tabulated pair laws, for the ``tab`` pairs of ``field``.
        bonded_tables: tabulated bonded laws, for the ``tab`` terms of ``field``.
        bead_table: internal temperatures and concentrations of the beads at the start, in place of those that FIELD's
            extensions give.
        sources: names for the scene's list of sources; by default the records' own paths.

    Raises:
        SceneError: the records contradict each other, leave something undefined, or ask for what is not modelled; the
            text gives file, line, word and the cure.
    """
    notes, settings = Notes(), Settings(control)
    for record in (control, field, config):
        _keep_warnings(record.path, record.warnings, notes)
        for remark in record.remarks:
            getattr(notes, remark.kind)(remark.text, place(record.path, remark.line))
    settings.refuse_unmodelled()
    settings.consumed.update(_FOLLOWED_BY_READERS)
    _refuse_unmodelled_blocks(field)
    single = field
    field, config = replicate_as_asked(settings, field, config, notes)
    bead_table = repeated_table(bead_table, single, field)

    units, field_units = _units(settings, field, notes)
    dynamics = resolve_dynamics(settings, field_units.reduced, notes)
    dynamics = resolve_barostat(settings, dynamics, notes)
    dynamics = resolve_shear(settings, dynamics, notes)
    layout = lay_out(field, notes)
    check_configuration(layout, field, config)
    external = resolve_external(field, field_units, config.imcon, layout, dynamics, settings, notes)
    check_barostat(dynamics, settings, config, field, layout, external)
    cutoffs = resolve_cutoffs(settings, notes)
    cell, periodic = resolve_cell(config, cutoffs[0], notes)
    walls = resolve_walls(settings, dynamics, external, config, cell, layout.species_names, cutoffs[1], notes)
    periodic = open_axes(periodic, walls)
    check_beads_inside(walls, config.positions, layout, config.path)
    check_shear(dynamics, settings, config, cell, field, layout, external, walls)
    imcon = shape_of(dynamics, config.imcon, settings, notes)
    if dynamics.shear_rate != 0.0:
        imcon = SHEARED_SHAPE
    strength = Strength(settings, field_units.reduced, dynamics)
    fields = any(term.key in ON_CHARGES for term in external)
    electrostatics = resolve_charges(
        settings, field, layout, strength, cutoffs[0], cell, imcon, periodic, fields, notes
    )
    pairs = resolve_pairs(settings, field, field_units.factor, layout, dynamics, cutoffs, tables, notes)
    many_body = resolve_many_body(settings, field, pairs, layout.species_names, notes)
    check_limits(dynamics, pairs, layout, settings, notes)
    note_small_cell(pairs, widths(cell)[list(periodic)].tolist(), notes)
    check_images(pairs, widths(cell)[list(periodic)].tolist(), config.path)
    check_image_noise(pairs, widths(cell)[list(periodic)].tolist(), config.path)
    dynamics, degrees = settle_momentum(dynamics, layout, external, walls, settings, notes)
    run = resolve_run(settings, dynamics.integrator != "nve", config, notes)
    fixed = dynamics.remove_drift or degrees == 3 * sum(layout.mobile_counts()) - 3
    output = resolve_output(settings, field, layout.species_names, pairs, cutoffs[0], notes, cell, periodic)
    velocities = start_velocities(config, layout, run, fixed and dynamics.shear_rate == 0.0, notes)
    beads = _beads(layout, _wrapped(config, cell, periodic), velocities)
    transport = resolve_transport(field, layout.species_names, cell, periodic, dynamics.timestep, notes)
    if transport is not None:
        beads = replace(beads, concentrations=_frozen(start_concentrations(transport, beads, cell, periodic)))
    charged = electrostatics is not None
    bonded = resolve_bonded(
        field, field_units.factor, beads, cell, periodic, config.path, notes, strength, charged, bonded_tables
    )
    constraints = resolve_constraints(
        settings,
        field,
        layout,
        dynamics,
        beads.positions,
        cell,
        periodic,
        cutoffs[0],
        config.path,
        notes,
        external,
        walls,
    )
    tails = long_range_correction(settings, pairs, periodic, notes)
    scene = Scene(
        title=control.title or field.title,
        units=units,
        species=layout.species_names,
        beads=beads,
        cell=cell,
        imcon=imcon,
        periodic=periodic,
        pairs=pairs,
        external=external,
        cutoff=cutoffs[0],
        vdw_cutoff=cutoffs[1],
        dynamics=dynamics,
        run=run,
        output=output,
        degrees_of_freedom=left_by(constraints, degrees, notes),
        long_range_correction=tails,
        molecule_names=tuple(molecule.name for molecule in field.molecules),
        molecule_counts=tuple(molecule.count for molecule in field.molecules),
        field_units=field_units,
        sources=tuple(sources) or (control.path, field.path, config.path),
        bonded=bonded,
        constraints=constraints,
        walls=walls,
        electrostatics=electrostatics,
        many_body=many_body,
        transport=transport,
    )
    check_many_body(scene, field, settings)
    scene = resolve_heat(field, scene, settings, notes)
    check_profile(scene, settings)
    check_bins(scene, settings)
    settings.finish(notes)
    return with_bead_table(replace(scene, notes=notes.all()), bead_table)


def _beads(layout: Layout, positions: FloatArray, velocities: FloatArray | None) -> Beads:
    arrays = (layout.species, layout.mass, layout.charge, layout.frozen, layout.molecule, positions)
    for array in (*arrays, velocities):
        if array is not None:
            array.setflags(write=False)  # a scene is immutable
    return Beads(*arrays, velocities)


def _frozen(array: FloatArray) -> FloatArray:
    array.setflags(write=False)  # a scene is immutable
    return array


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
            if block.lines and molecule.count and block.directive not in (*KINDS, "constraints"):
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
