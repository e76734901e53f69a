"""What a run writes: the part of CONTROL that has no influence on the physics."""

from __future__ import annotations

import numpy as np

from pydlpoly.errors import SceneError, suggest
from pydlpoly.formats.records import Field, FloatArray
from pydlpoly.scene.bins import resolve_map, resolve_profile_bins
from pydlpoly.scene.cell import MOST_IMAGES, images_within, widths
from pydlpoly.scene.model import OutputPlan, PairTerm
from pydlpoly.scene.settings import Notes, Settings
from pydlpoly.scene.stress import resolve_correlations, resolve_profile
from pydlpoly.trajectories import FORMATS

_TRAJECTORY_LEVELS = {"pos": 0, "pos-vel": 1, "pos-vel-force": 2}
# DL_POLY keeps rolling averages over at least this many steps; of more than so many the stack does not fit in memory.
_LEAST_STACK, _MOST_STACK = 100, 1_000_000


def resolve_output(
    settings: Settings,
    field: Field,
    species: tuple[str, ...],
    pairs: tuple[PairTerm, ...],
    cutoff: float,
    notes: Notes,
    cell: FloatArray,
    periodic: tuple[bool, bool, bool],
) -> OutputPlan:
    """Return the intervals and names of everything that is written.

    Args:
        settings: CONTROL.
        field: FIELD, for the pairs of its ``rdf`` block.
        species: names of the species.
        pairs: the pair table; without an ``rdf`` block every pair with a law is collected.
        cutoff: the global cutoff (Å), the range of the radial distribution.
        notes: receives what was adjusted.
        cell, periodic: the cell, for the layers of the stress profile.

    Raises:
        SceneError: a negative interval, or an ``rdf`` pair of unknown species.
    """
    rdf_every = _interval(settings, "rdf_frequency") if settings.switch("rdf_calculate") else 0
    trajectory_file, statistics_file = settings.file_name("io_file_history"), settings.file_name("io_file_statis")
    trajectory_every = _interval(settings, "traj_interval") if settings.switch("traj_calculate") else 0
    formats = _trajectory_formats(settings, cell) if trajectory_every else ()
    statistics_every = _interval(settings, "stats_frequency")
    diagnostics_file = settings.file_name("io_file_diagnostics")
    diagnostics_every = _interval(settings, "diagnostics_frequency")
    zden_every = _interval(settings, "zden_frequency") if settings.switch("zden_calculate") else 0
    zden_written = settings.switch("zden_print") and zden_every > 0
    if rdf_every > 0:
        _check_images(settings, cutoff, widths(cell)[list(periodic)].tolist())
    bin_widths = {
        name: _bin_width(settings, f"{name}_binsize", cutoff, notes) if on else settings.number(f"{name}_binsize")
        for name, on in (("rdf", rdf_every > 0), ("zden", zden_written))
    }
    vaf_every, vaf_steps = _velocity_samples(settings, species)
    msd_file = settings.file_name("io_file_msd")
    msd_every = _interval(settings, "msd_frequency") if settings.switch("msd_calculate") else 0
    return OutputPlan(
        print_every=_interval(settings, "print_frequency"),
        statistics_every=statistics_every if statistics_file else 0,
        diagnostics_every=diagnostics_every if diagnostics_file else 0,
        stack_size=_stack_size(settings, notes),
        statistics_yaml=settings.switch("io_statis_yaml"),
        trajectory_start=_interval(settings, "traj_start"),
        trajectory_every=trajectory_every if trajectory_file or formats else 0,
        trajectory_level=_TRAJECTORY_LEVELS[settings.word("traj_key")],
        trajectory_formats=formats,
        rdf_every=rdf_every,
        rdf_bin_width=bin_widths["rdf"],
        rdf_pairs=_rdf_pairs(field, species, pairs) if rdf_every else (),
        checkpoint_every=_interval(settings, "data_dump_frequency"),
        output_file=settings.file_name("io_file_output"),
        statistics_file=statistics_file or "STATIS",
        diagnostics_file=diagnostics_file or "DIAGNOSTICS",
        trajectory_file=trajectory_file if trajectory_file or formats else "HISTORY",
        trajectory_stem=settings.text("io_file_trajectory") if formats else "TRAJECTORY",
        rdf_file=settings.file_name("io_file_rdf") if settings.switch("rdf_print") else None,
        configuration_file=settings.file_name("io_file_revcon"),
        checkpoint_file=settings.file_name("io_file_revive"),
        profile=resolve_profile(settings, cell, periodic, notes),
        correlations=resolve_correlations(settings, notes),
        zden_every=zden_every if zden_written else 0,
        zden_bins=max(1, round(cutoff / bin_widths["zden"])) if zden_written else 1,
        vaf_every=vaf_every,
        vaf_steps=vaf_steps,
        vaf_averaging=settings.switch("vaf_averaging") if vaf_every else True,
        msd_every=msd_every if msd_file else 0,
        msd_start=_interval(settings, "msd_start") if msd_every else 0,
        msd_file=msd_file or "MSDTMP",
        beads_file=settings.file_name("io_file_revbeads"),
        bead_profile=resolve_profile_bins(settings),
        bead_map=resolve_map(settings),
    )


def _trajectory_formats(settings: Settings, cell: FloatArray) -> tuple[str, ...]:
    """Return the formats that are written beside HISTORY.

    Raises:
        SceneError: a word that is no format, a format whose package is missing or that cannot hold the cell.
    """
    text = settings.text("traj_format").strip()
    words = text.removeprefix("[").removesuffix("]").replace(",", " ").lower().split()
    for word in words:
        if word not in FORMATS:
            message = f"{word!r} is no format of trajectories: known are {', '.join(FORMATS)}{suggest(word, FORMATS)}"
            raise settings.refusal("traj_format", message)
        if not FORMATS[word].can_write:
            message = f"{word} needs the package {FORMATS[word].needs}: pip install 'pydlpoly[trajectories]'"
            raise settings.refusal("traj_format", message)
        if FORMATS[word].upright and np.linalg.det(cell) < 0.0:
            message = f"{word} cannot hold the left-handed cell of CONFIG; exchange two of its vectors"
            raise settings.refusal("traj_format", message)
    return tuple(word for word in dict.fromkeys(words) if word != "history")


def _interval(settings: Settings, keyword: str) -> int:
    steps = settings.steps(keyword)
    if steps < 0:
        raise settings.refusal(keyword, f"the interval must not be negative, found {steps} steps")
    return steps


def _check_images(settings: Settings, cutoff: float, cell_widths: list[float]) -> None:
    images = images_within(cutoff, cell_widths)
    if images > MOST_IMAGES:
        message = (
            f"{images:.3g} images of the cell lie within the cutoff {cutoff:g} ang, to which distances are counted, "
        )
        raise settings.refusal("rdf_calculate", message + f"more than {MOST_IMAGES}: the cell is too small for it")


def _stack_size(settings: Settings, notes: Notes) -> int:
    size = _interval(settings, "stack_size")
    if size > _MOST_STACK:
        raise settings.refusal("stack_size", f"rolling averages over {size} steps; at most {_MOST_STACK} are kept")
    if 0 < size < _LEAST_STACK:
        notes.choice(
            f"rolling averages are taken over {_LEAST_STACK} steps, the least that DL_POLY uses, not {size}",
            settings.where("stack_size"),
        )
    return max(size, _LEAST_STACK)


def _velocity_samples(settings: Settings, species: tuple[str, ...]) -> tuple[int, int]:
    """Return the interval between samples of velocities and their length, with DL_POLY's defaults where they are 0."""
    if not settings.switch("vaf_calculate"):
        return 0, 1
    for name in species:
        if "/" in name:
            raise settings.refusal("vaf_calculate", f"a file VAFDAT_{name} cannot be named after this species")
    every = _interval(settings, "vaf_frequency") or 50
    length = settings.integer("vaf_binsize")
    if length < 0:
        raise settings.refusal("vaf_binsize", f"expected a number of steps, found {length}")
    return every, length or (2 * every if every >= 100 else 100)


def _bin_width(settings: Settings, keyword: str, cutoff: float, notes: Notes) -> float:
    width = settings.number(keyword)
    if 1e-5 <= width <= 0.25 * cutoff:
        return width
    reset = min(0.05, 0.25 * cutoff)
    notes.warning(
        f"{keyword} {width:g} lies outside 0.00001 to a quarter of the cutoff: {reset:g} ang is used (DL_POLY's "
        "warning 340)",
        settings.where(keyword),
    )
    return reset


def _rdf_pairs(field: Field, species: tuple[str, ...], pairs: tuple[PairTerm, ...]) -> tuple[tuple[int, int], ...]:
    if not field.rdf_pairs:
        return tuple(term.species for term in pairs if term.law is not None or term.drag > 0.0)
    for name in (name for pair in field.rdf_pairs for name in pair):
        if name not in species:
            message = f"the rdf block names a species that no molecule has{suggest(name, species)}"
            raise SceneError(message, path=field.path, word=name)
    numbered = [sorted(species.index(name) for name in pair) for pair in field.rdf_pairs]
    return tuple(dict.fromkeys((a, b) for a, b in numbered))
