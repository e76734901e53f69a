"""A picture of a plan: the parts of a step against the number of ranks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pydlpoly.bench.plot import new_figure, save_figure
from pydlpoly.planning.model import Estimate


def write_plan_plot(rows: Sequence[Estimate], path: Path) -> None:
    """Draw times of a step and the halo's share; the name's ending says the format (.png, .svg, .pdf).

    Raises:
        InputError: matplotlib is missing, it does not know the format, or the file cannot be written.
    """
    figure = new_figure(path, 8.0, 3.6)
    times, shares = figure.subplots(1, 2)
    ranks = [row.ranks for row in rows]
    times.loglog(ranks, [row.step for row in rows], "k-", label="step")
    times.loglog(ranks, [row.compute for row in rows], label="compute")
    for label, values in (
        ("halo", [row.exchange + row.rebuild for row in rows]),
        ("sums", [row.collective for row in rows]),
    ):
        shown = [(number, value) for number, value in zip(ranks, values, strict=True) if value > 0.0]
        if shown:
            times.loglog(*zip(*shown, strict=True), label=label)
    times.set_xlabel("ranks")
    times.set_ylabel("seconds a step")
    times.legend(fontsize=7)
    shares.semilogx(ranks, [100.0 * row.halo_share for row in rows], label="halo")
    shares.semilogx(ranks, [100.0 * row.efficiency for row in rows], label="compute")
    shares.set_xlabel("ranks")
    shares.set_ylabel("% of a step")
    shares.legend(fontsize=7)
    figure.suptitle("a model, not a measurement", fontsize=9)
    save_figure(figure, path)
