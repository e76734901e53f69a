"""Figures of structure and motion: g(r), density and stress profiles, displacements, velocity autocorrelation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pydlpoly.analysis import DensityProfile, RadialDistribution, analyse
from pydlpoly.analysis.frames import widths
from pydlpoly.drawing import HEIGHT, STYLES, axis_label, banded, legend, new_axes
from pydlpoly.errors import InputError
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.records import FloatArray
from pydlpoly.report.collect import Run
from pydlpoly.report.series import all_series
from pydlpoly.report.style import Drawing, table_of

_IN_ONE = STYLES  # curves in one axes
_MOST_CURVES = 12
_BEADS_COUNTED = 200_000  # in all frames together, when g(r) has to be computed here
_Curves = list[tuple[str, FloatArray, FloatArray]]


def distribution(run: Run) -> Drawing | None:
    """g(r) of RDFDAT, or else of the frames of the trajectory."""
    if run.rdf is not None and run.rdf.pairs:
        curves = [(f"{a}–{b}", run.rdf.r, g) for (a, b), g in zip(run.rdf.pairs, run.rdf.g, strict=True)]
        source = "RDFDAT"
    else:
        curves, source = _distribution_of_frames(run)
    if not curves:
        return None
    peaks = [f"{name} {np.nanmax(g):.3g} at {r[int(np.nanargmax(g))]:.3g}" for name, r, g in curves[:_MOST_CURVES]]
    unit = run.units.of("length")
    words = f"Radial distribution functions from {source}. Highest points: {', '.join(peaks)}{unit and ' ' + unit}."
    return _curves("rdf", "Radial distribution", curves, words, axis_label("r", unit), "g(r)", reference=1.0)


def density(run: Run) -> Drawing | None:
    """Number densities across the cell: ZDNDAT, STRPRF, or the frames of the trajectory."""
    axis, unit = "z", run.units.of("length")
    if run.density is not None and len(run.density.species):
        found = zip(run.density.species, run.density.density, strict=True)
        curves, source = [(name, run.density.z, values) for name, values in found], "ZDNDAT"
    elif run.profile is not None and run.profile.densities:
        curves = [(name, run.profile.heights, values) for name, values in run.profile.densities.items()]
        source, axis = "STRPRF", run.profile.axis
    elif run.bead_profile is None or "number_density" not in run.bead_profile.values:  # a figure of its own
        curves, source = _density_of_frames(run)
    else:
        return None
    if not curves:
        return None
    told = [f"{name} {values.min():.3g} to {values.max():.3g}" for name, _, values in curves[:_MOST_CURVES]]
    kind = run.units.of("density")
    words = f"Number density of each species along {axis}, from {source}: {', '.join(told)}{kind and ' ' + kind}."
    return _curves("density", "Density profiles", curves, words, axis_label(axis, unit), axis_label("density", kind))


def stress_profile(run: Run) -> Drawing | None:
    """Normal and lateral stress in layers, of STRPRF."""
    profile = run.profile
    if profile is None or not len(profile.heights):
        return None
    curves = [("normal", profile.heights, profile.normal), ("lateral", profile.heights, profile.lateral)]
    unit = "" if profile.tension_unit == "reduced" else f" {profile.tension_unit}"
    words = (
        f"Stress normal and lateral to the layers along {profile.axis}, {profile.samples} samples. Surface tension "
        f"{profile.tension.value:.4g} ± {profile.tension.error:.2g}{unit}; bands: standard errors."
    )
    x, y = axis_label(profile.axis, run.units.of("length")), axis_label("stress", run.units.of("pressure"))
    errors = [profile.normal_error, profile.lateral_error]
    return _curves("stress-profile", "Stress in layers", curves, words, x, y, errors=errors)


def displacement(run: Run) -> Drawing | None:
    """Mean-square displacements since the start: of STATIS, or of the frames of the trajectory."""
    found = {name[4:]: one for name, one in all_series(run).items() if name.startswith("msd_")}
    curves = [(name, one.times, one.values) for name, one in found.items() if len(one.times) > 2]
    source, since = "STATIS", "the start"
    if not curves:
        curves, since = _displacement_of_frames(run)
        source = run.history_file
    curves = [curve for curve in curves if np.any(curve[2] > 0.0)]
    if not curves:
        return None
    slopes = [f"{name} {_diffusion(times, values):.3g}" for name, times, values in curves[:_MOST_CURVES]]
    unit = run.units.of("diffusion")
    words = (
        f"Mean-square displacement since {since}, from {source}. A sixth of the slope of the second half, which for "
        f"beads that diffuse is D: {', '.join(slopes)}{unit and ' ' + unit}. One start only: no error is known."
    )
    if run.scene is not None and (run.scene.external or run.scene.dynamics.shear_rate != 0.0):
        words += " Where the fluid flows, its flow is in it."
    x, y = axis_label("time", run.units.of("time")), axis_label("MSD", run.units.of("area"))
    return _curves("msd", "Mean-square displacement", curves, words, x, y)


def velocity(run: Run) -> Drawing | None:
    """Velocity autocorrelation of each species, of VAFDAT."""
    curves = [(one.species, one.times, one.values) for one in run.velocities]
    if not curves:
        return None
    words = "Velocity autocorrelation of each species, 1 at time 0, from VAFDAT."
    x = axis_label("time", run.units.of("time"))
    return _curves("vaf", "Velocity autocorrelation", curves, words, x, "⟨v(t)·v(0)⟩ / ⟨v²⟩", reference=0.0)


def _curves(
    name: str,
    title: str,
    curves: _Curves,
    words: str,
    x_label: str,
    y_label: str,
    *,
    reference: float | None = None,
    errors: Sequence[FloatArray] = (),
) -> Drawing:
    """Curves against one x, at most six in one axes."""
    if len(curves) > _MOST_CURVES:
        words += f" The first {_MOST_CURVES} of {len(curves)} are drawn."
        curves = curves[:_MOST_CURVES]
    panels = [curves[k : k + _IN_ONE] for k in range(0, len(curves), _IN_ONE)]
    figure, rows = new_axes(HEIGHT if len(panels) == 1 else 0.4 + 2.3 * len(panels), len(panels))
    for axes, panel in zip(rows, panels, strict=True):
        for k, (label, x, y) in enumerate(panel):
            banded(axes, k, x, y, errors[k] if errors else None, label)
        if reference is not None:
            axes.axhline(reference, color="black", linewidth=0.6, zorder=1)
        axes.set_ylabel(y_label)
        legend(axes)
    rows[-1].set_xlabel(x_label)
    same = all(np.array_equal(x, curves[0][1]) for _, x, _ in curves)
    head = (x_label, *(label for label, _, _ in curves))
    table = table_of(head, [curves[0][1], *(y for _, _, y in curves)], 16) if same and len(curves) <= 6 else None
    return Drawing(name, title, figure, words, table)


def _diffusion(times: FloatArray, values: FloatArray) -> float:
    half = len(times) // 2
    if len(times) - half < 2 or not np.ptp(times[half:]) > 0.0:
        return float("nan")
    return float(np.polyfit(times[half:], values[half:], 1)[0]) / 6.0


def _distribution_of_frames(run: Run) -> tuple[_Curves, str]:
    frames = _sampled(run)
    count = _BEADS_COUNTED // len(frames[0].names) if frames else 0
    frames = frames[-count:] if count else []
    if not frames or frames[-1].imcon in (0, 6):
        return [], ""
    half = 0.5 * float(widths(frames[-1].cell).min())
    reach = min(half, 3.0 * run.scene.cutoff) if run.scene is not None else half
    try:
        one = RadialDistribution(bin_width=reach / 80.0, reach=0.999 * reach)
        analyse(frames, one)
        result = one.result()
    except (InputError, np.linalg.LinAlgError):
        return [], ""
    curves = [(f"{a}–{b}", result.r, g) for (a, b), g in zip(result.pairs, result.g, strict=True)]
    return curves, _frames_of(run, len(frames))


def _density_of_frames(run: Run) -> tuple[_Curves, str]:
    frames = _sampled(run)
    if not frames or not all(np.linalg.det(frame.cell) for frame in frames):
        return [], ""
    try:
        one = DensityProfile("z", bins=40)
        analyse(frames, one)
        result = one.result()
    except (InputError, np.linalg.LinAlgError):
        return [], ""
    curves = [(name, result.z, values) for name, values in zip(result.species, result.density, strict=True)]
    return curves, _frames_of(run, len(frames))


def _sampled(run: Run) -> list[Frame]:
    """Frames after the equilibration, or where there are none yet those after the start, which is no sample."""
    frames = [frame for frame in (run.history.frames if run.history is not None else ()) if frame.step > 0]
    return [frame for frame in frames if frame.step > run.equilibration] or frames


def _frames_of(run: Run, count: int) -> str:
    return f"{count} {'frame' if count == 1 else 'frames'} of {run.history_file}"


def _displacement_of_frames(run: Run) -> tuple[_Curves, str]:
    """Mean squares by species, and since when: HISTORY has displacements from the start, others cells crossed."""
    frames = [frame for frame in (run.history.frames if run.history is not None else ()) if frame.time is not None]
    if len(frames) < 3 or any(frame.names != frames[0].names for frame in frames):
        return [], ""
    squares, since = _squares(run, frames)
    if squares is None:
        return [], ""
    times = np.array([frame.time for frame in frames], dtype=np.float64)
    names = np.array(frames[0].names, dtype=object)
    return [(name, times, squares[:, names == name].mean(axis=1)) for name in dict.fromkeys(frames[0].names)], since


def _squares(run: Run, frames: Sequence[Frame]) -> tuple[FloatArray | None, str]:
    """Squared displacements, (frames, N); None where frames do not tell them, as in a cell that moves."""
    if all(np.isfinite(frame.displacements).all() for frame in frames):
        return np.array([frame.displacements**2 for frame in frames]), "the start"
    sheared = run.scene is not None and run.scene.dynamics.shear_rate != 0.0
    if sheared or any(frame.images is None or not np.array_equal(frame.cell, frames[0].cell) for frame in frames):
        return None, ""
    places = np.array([frame.positions + frame.images @ frame.cell for frame in frames if frame.images is not None])
    return np.sum((places - places[0]) ** 2, axis=2), f"step {frames[0].step}, the first frame looked at"
