"""A picture of the trade: error against speed, with the Pareto front."""

from __future__ import annotations

from pathlib import Path

from pydlpoly.bench.plot import new_figure, save_figure
from pydlpoly.errors import InputError
from pydlpoly.tradeoff.report import QUANTITIES, Measured, TradeoffReport
from pydlpoly.tradeoff.statistics import REACH

_MARKS = "osD^vPX*<>phd8"
_LEAST = 1e-4  # smallest error that is drawn, as a fraction: less is within the noise of every run


def check_plot(path: Path) -> None:
    """Raise InputError when a plot of this name could not be drawn: no matplotlib, or a format it does not know."""
    known = new_figure(path, 1.0, 1.0).canvas.get_supported_filetypes()
    ending = path.suffix.removeprefix(".")
    if ending not in known:
        raise InputError(f"cannot be drawn: expected a name that ends with one of {', '.join(known)}", path=str(path))


def write_plot(report: TradeoffReport, path: Path) -> None:
    """Draw the largest error of every candidate against its speed; the name's ending says the format.

    Raises:
        InputError: matplotlib is missing, it does not know the format, or the file cannot be written.
    """
    figure = new_figure(path, 9.0, 6.0)
    axes = figure.subplots()
    drawn = [one for one in report.candidates if one.speed is not None and one.error is not None]
    names = list(dict.fromkeys(f"{one.name}, {one.precision}" for one in drawn))
    for one in drawn:
        place = names.index(f"{one.name}, {one.precision}")
        x, y, low, high = _place(one)
        assert one.speed is not None
        axes.errorbar(
            x,
            y,
            xerr=[[x - one.speed.low], [one.speed.high - x]],
            yerr=[[y - low], [high - y]],
            fmt=_MARKS[place % len(_MARKS)],
            color=f"C{place % 10}",
            markersize=6.0,
            alpha=0.3 if one.given_up and not one.front else 1.0,
            elinewidth=0.8,
        )
    for place, name in enumerate(names):
        axes.plot([], [], _MARKS[place % len(_MARKS)], color=f"C{place % 10}", label=name)
    front = sorted((_place(one)[:2] for one in drawn if one.front), key=lambda point: point[0])
    if front:
        axes.plot(*zip(*front, strict=True), "k-", linewidth=1.0, zorder=0, label="Pareto front")
    for one in drawn:
        if one.front or one.own:
            text = f"{one.name}, {one.timestep:g}" + (" (CONTROL)" if one.own else "")
            axes.annotate(text, _place(one)[:2], xytext=(6, 6), textcoords="offset points", fontsize=8)
    axes.axhline(100.0 * report.target, color="grey", linestyle="--", linewidth=0.8, label="target")
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("{x:g}")
        axis.set_tick_params(which="both", labelsize=7)
    axes.set_xlabel(f"simulated time{f' ({report.time_unit})' if report.time_unit else ''} a second of wall time")
    words = ", ".join(QUANTITIES[name] for name in QUANTITIES if any(name in (one.deviations or {}) for one in drawn))
    axes.set_ylabel(f"largest error of {words} (%), bars: 95 % confidence")
    axes.set_title(f"{report.title}\nwith their timesteps; faint: given up early", fontsize=9)
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    save_figure(figure, path)


def _place(one: Measured) -> tuple[float, float, float, float]:
    """Speed, error in per cent, and the ends of the error's bar."""
    assert one.speed is not None
    assert one.error is not None
    reach = REACH * (one.error_noise or 0.0)
    low, middle, high = (100.0 * max(_LEAST, value) for value in (one.error - reach, one.error, one.error + reach))
    return one.speed.median, middle, low, high
