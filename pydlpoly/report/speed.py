"""How fast the run was, and where its time went, as far as OUTPUT says."""

from __future__ import annotations

import numpy as np

from pydlpoly.drawing import axis_label, line, new_axes
from pydlpoly.report.collect import Run
from pydlpoly.report.style import Drawing, Table, table_of

_BAR, _EDGE = "#56B4E9", "#0b3c5d"


def speed(run: Run) -> Drawing | None:
    """Steps a second between print-outs."""
    rates = rates_of(run)
    if rates is None:
        return None
    times, rate = rates
    figure, (axes,) = new_axes()
    line(axes, 0, times, rate, "steps a second")
    axes.set_ylim(0.0, 1.15 * float(rate.max()))
    axes.set_xlabel(axis_label("time", run.units.of("time")))
    axes.set_ylabel("steps a second")
    words = f"Between print-outs {_plain(rate.min())} to {_plain(rate.max())} steps a second."
    if run.beads:
        words += f" At {run.beads} beads the mean is {_mean(run) * run.beads / 1e6:.3g} million bead-steps a second."
    head = (axis_label("time", run.units.of("time")), "steps a second")
    return Drawing("speed", "Steps a second", figure, words, table_of(head, [times, rate]))


def time_spent(run: Run) -> Drawing | None:
    """Seconds by part of the program."""
    parts = seconds_by_part(run)
    if len(parts) < 2:
        return None
    names, seconds = list(parts), np.array(list(parts.values()))
    total = float(seconds.sum())
    figure, (axes,) = new_axes(max(1.6, 0.55 + 0.27 * len(names)))
    places = np.arange(len(names))
    axes.barh(places, seconds, color=_BAR, edgecolor=_EDGE, linewidth=0.8, height=0.7)
    texts = [f"{value:.3g} s, {100.0 * value / total:.0f} %" for value in seconds.tolist()]
    for place, value, text in zip(places.tolist(), seconds.tolist(), texts, strict=True):
        axes.annotate(text, (value, place), xytext=(4, 0), textcoords="offset points", va="center", fontsize=9)
    axes.set_xlim(0.0, 1.45 * float(seconds.max()))
    axes.set_yticks(places, names)
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("seconds")
    most = names[int(np.argmax(seconds))]
    words = f"{total:.3g} s in all, most of it for {most}. What several files look at counts for the first that asks."
    rows = tuple((name, text) for name, text in zip(names, texts, strict=True))
    return Drawing("time", "Where the time went", figure, words, Table(("part", "time"), rows))


def rates_of(run: Run) -> tuple[np.ndarray, np.ndarray] | None:
    """Middle times and steps a second between the print-outs of OUTPUT's last start; None with fewer than three."""
    log = run.log
    if log is None or len(log.steps) < 3:
        return None
    steps, seconds = np.diff(log.steps), np.diff(log.elapsed)
    known = (seconds > 0.0) & (steps > 0)
    if not known.any():
        return None
    middles = 0.5 * (log.times[1:] + log.times[:-1])
    return middles[known], steps[known] / seconds[known]


def steps_a_second(run: Run) -> float | None:
    """Steps a second of the whole loop, or as far as a run that was killed says; None when nothing does."""
    log = run.log
    if log is None:
        return None
    if log.loop_seconds and log.last_step is not None:
        return (log.last_step - log.starts[-1]) / log.loop_seconds
    return _mean(run) if rates_of(run) is not None else None


def seconds_by_part(run: Run) -> dict[str, float]:
    """Seconds by part, longest first; the loop over steps only where its parts are not known."""
    if run.log is None:
        return {}
    timings = dict(run.log.timings)
    inside = {name.removeprefix("of which "): value for name, value in timings.items() if name.startswith("of which ")}
    outside = {name: value for name, value in timings.items() if not name.startswith("of which ")}
    if inside:
        outside["rest of the loop"] = max(0.0, outside.pop("steps", 0.0) - sum(inside.values()))
    parts = {**inside, **outside}
    return dict(sorted(parts.items(), key=lambda part: -part[1]))


def _plain(rate: float) -> str:
    return f"{rate:.0f}" if rate >= 100.0 else f"{rate:.3g}"


def _mean(run: Run) -> float:
    log = run.log
    assert log is not None
    if log.loop_seconds and log.last_step is not None:
        return (log.last_step - log.starts[-1]) / log.loop_seconds
    return float((log.steps[-1] - log.steps[0]) / max(log.elapsed[-1] - log.elapsed[0], 1e-9))
