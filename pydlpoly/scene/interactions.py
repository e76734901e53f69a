"""What acts between beads: cutoffs, the rules of the pair table, tails."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

from pydlpoly import _core
from pydlpoly.errors import SceneError
from pydlpoly.formats.records import Field, PairTable
from pydlpoly.scene.beads import Layout
from pydlpoly.scene.cell import LONGEST, MOST_IMAGES, images_within
from pydlpoly.scene.integrators import is_pairwise
from pydlpoly.scene.laws import pair_laws
from pydlpoly.scene.many_body_records import KEY, in_full
from pydlpoly.scene.model import Dynamics, PairTerm
from pydlpoly.scene.pairs import PairRules, PairTableBuilder
from pydlpoly.scene.settings import Notes, Settings, place

# DL_POLY takes no cutoff below this (Å).
_LEAST_CUTOFF = 1.0


def resolve_pairs(
    settings: Settings,
    field: Field,
    factor: float,
    layout: Layout,
    dynamics: Dynamics,
    cutoffs: tuple[float, float],
    tables: Iterable[PairTable],
    notes: Notes,
) -> tuple[PairTerm, ...]:
    """Return the pair table.

    Args:
        settings: CONTROL.
        field: FIELD with its ``vdw`` records.
        factor: FIELD's energy unit in internal units.
        layout: the beads, for which species can meet.
        dynamics: whether there is a thermostat, and k_B T.
        cutoffs: the global and the van der Waals cutoff (Å).
        tables: tabulated pair laws.
        notes: receives choices, oddities and what has no effect.

    Raises:
        SceneError: see ``PairTableBuilder``.
    """
    rules = _pair_rules(settings, dynamics, *cutoffs, notes)
    by_names = {tuple(sorted(table.species)): table for table in tables}
    pairs = PairTableBuilder(
        field, factor, layout.species_names, layout.counts(), layout.mobile_counts(), rules, by_names, notes
    ).build()
    if not rules.thermostat:
        _note_drags_without_thermostat(field, notes)
    if rules.mixing and not any("mixed" in (term.law_origin, term.drag_origin) for term in pairs):
        notes.ignored(f"vdw_mix_method {rules.mixing} has nothing to mix", settings.where("vdw_mix_method"))
    if rules.fill_drag and not any(term.drag_origin in ("filled", "overridden") for term in pairs):
        notes.ignored("ensemble_dpd_drag has no pair to fill: every pair has a drag of its own", rules.fill_where)
    _note_ranges(pairs, layout.species_names, cutoffs, notes)
    return pairs


def resolve_cutoffs(settings: Settings, notes: Notes) -> tuple[float, float]:
    """Return the global cutoff and the van der Waals cutoff (Å)."""
    cutoff, vdw = settings.number("cutoff"), settings.number("vdw_cutoff")
    for keyword, value in (("cutoff", cutoff), ("vdw_cutoff", vdw)):
        if not abs(value) <= LONGEST or value == 0.0 or (keyword == "cutoff" and value < 0.0):
            raise settings.refusal(keyword, f"a cutoff lies above 0 and up to {LONGEST:g} ang, not at {value:g}")
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
        thermostat=is_pairwise(dynamics.integrator),
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


def _note_drags_without_thermostat(field: Field, notes: Notes) -> None:
    for line in field.pairs:
        slot = pair_laws()[line.key].drag_slot
        numbers = in_full(line.parameters) if line.key == KEY else line.parameters
        if slot and len(numbers) >= slot and numbers[slot - 1] != 0.0:
            text = f"the drag {numbers[slot - 1]:g} of {'-'.join(line.species)} has no effect under nve"
            notes.ignored(text, place(field.path, line.line))


def _note_ranges(
    pairs: tuple[PairTerm, ...], species: tuple[str, ...], cutoffs: tuple[float, float], notes: Notes
) -> None:
    """Say where ranges differ from what DL_POLY would make of the global and the van der Waals cutoff."""
    cutoff, vdw_cutoff = cutoffs

    def named(terms: Iterable[PairTerm]) -> str:
        return ", ".join("-".join(species[k] for k in term.species) for term in terms)

    own = [t for t in pairs if t.law not in (None, "tab") and _core.pair_range(t.law, list(t.parameters)) > 0.0]
    longer = [t for t in own if t.cutoff > cutoff]
    if longer:
        text = f"{named(longer)} keep the range of their law, beyond the global cutoff {cutoff:g} ang"
        notes.choice(f"{text}; DL_POLY truncates them there")
    ended = {id(t) for t in own}  # terms compare by value, which would take long for hundreds of species
    others = [t for t in pairs if t.law is not None and id(t) not in ended]
    longest = max((t.cutoff for t in own), default=math.inf)
    if others and longest < vdw_cutoff:
        text = f"{named(others)} end at the van der Waals cutoff {vdw_cutoff:g} ang"
        notes.choice(f"{text}; DL_POLY cuts them at {longest:g} ang, the longest range that FIELD gives")


def note_small_cell(pairs: tuple[PairTerm, ...], cell_widths: Sequence[float], notes: Notes) -> None:
    """Say when a bead can meet several images of another; ``cell_widths`` are those along the periodic axes (Å)."""
    reach = max((max(t.cutoff, t.drag_cutoff) for t in pairs), default=0.0)
    width = min(cell_widths, default=math.inf)
    if reach >= 0.5 * width:
        text = f"the longest range {reach:g} ang is at least half the cell's width, {width:g} ang: a bead may meet"
        notes.choice(f"{text} several images of another, and all count; DL_POLY would stop (error 95)")


def check_images(pairs: tuple[PairTerm, ...], cell_widths: Sequence[float], path: str) -> None:
    """Raise SceneError where a law's range holds more images of a cell than can be computed; widths as above."""
    reach = max((t.cutoff for t in pairs), default=0.0)
    images = images_within(reach, cell_widths)
    if images > MOST_IMAGES:
        message = f"{images:.3g} images of the cell lie within the longest range {reach:g} ang, more than {MOST_IMAGES}"
        raise SceneError(f"{message}: the cell is too small for it", path=path)


def check_image_noise(pairs: tuple[PairTerm, ...], cell_widths: Sequence[float], path: str) -> None:
    """Raise SceneError where two images of a pair would have the same noise; widths as for ``note_small_cell``."""
    reach = max((t.drag_cutoff for t in pairs if t.drag > 0.0), default=0.0)
    width = min(cell_widths, default=math.inf)
    if reach > 2.5 * width:
        message = (
            f"the cell is {width:g} ang wide, less than 2/5 of the drag's range {reach:g} ang: more images of a pair "
            "would act on a bead than have noise of their own"
        )
        raise SceneError(message, path=path)


def long_range_correction(
    settings: Settings, pairs: tuple[PairTerm, ...], periodic: tuple[bool, bool, bool], notes: Notes
) -> bool:
    """Return whether analytic tails are added: asked for, periodic along all axes, not force-shifted."""
    wanted, force_shift = settings.switch("vdw_long_range_correction"), settings.switch("vdw_force_shift")
    where = settings.where("vdw_long_range_correction")
    has_tail = any(t.law is not None and pair_laws()[t.law].has_tail for t in pairs)
    if not wanted and has_tail:
        notes.choice("vdw_long_range_correction off: energy and pressure lack the tails beyond the cutoff", where)
    if not wanted or not has_tail:
        return wanted and all(periodic) and not force_shift
    if not all(periodic):
        notes.choice("no long-range correction: the system is not periodic along every axis", where)
    if force_shift:
        notes.choice("no long-range correction: forces are shifted to vanish at the cutoff", where)
    return all(periodic) and not force_shift
