"""Figures of what beads carry: internal temperature, the balance of energy, amounts of dissolved species."""

from __future__ import annotations

import numpy as np

from pydlpoly.drawing import HEIGHT, WIDTH, axis_label, banded, legend, new_axes
from pydlpoly.formats.records import FloatArray
from pydlpoly.report.against_time import one_quantity
from pydlpoly.report.collect import Run
from pydlpoly.report.evidence import Evidence
from pydlpoly.report.style import Drawing, Table, table_of

_GAINS = ("at start", "sources", "reactions", "held beads", "now")
_BARS = ("#BFC7CE", "#56B4E9", "#F0C45A", "#7FD1B0", "#0072B2")
_MOST = 6  # species


def internal_temperature(run: Run) -> Drawing | None:
    """The internal temperature of all beads together."""
    drawn = one_quantity(run, "internal_temperature", "Internal temperature")
    if drawn is None:
        return None
    return Drawing("internal-temperature", drawn.title, drawn.figure, drawn.caption, drawn.table)


def conserved(run: Run) -> Drawing | None:
    """Changes of internal and mechanical energy since the first record, and below them that of what is conserved."""
    evidence = Evidence(run)
    found = {name: evidence.series.get(name) for name in ("internal_energy", "conserved_energy")}
    internal, whole = found["internal_energy"], found["conserved_energy"]
    kinetic, scene = evidence.kinetic(), run.scene
    if internal is None or whole is None or kinetic is None or scene is None or not kinetic.value > 0.0:
        return None
    thermal = kinetic.value * scene.units.boltzmann / scene.units.factor
    mechanical = evidence.series.get("energy") or evidence.series.get("extended_energy")
    curves = [("internal", internal.times, (internal.values - internal.values[0]) / thermal)]
    if mechanical is not None:
        change = (mechanical.values - mechanical.values[0]) / thermal
        curves.append(("kinetic and potential", mechanical.times, change))
    drift = (whole.values - whole.values[0]) / thermal
    figure, (above, below) = new_axes(HEIGHT + 0.9, 2)
    for k, (label, times, values) in enumerate(curves):
        banded(above, k, times, values, None, label)
    legend(above)
    above.set_ylabel("change")
    banded(below, 3, whole.times, drift, None, "conserved")
    below.axhline(0.0, color="black", linewidth=0.6, zorder=1)
    below.set_ylabel("conserved")
    below.set_xlabel(axis_label("time", run.units.of("time")))
    figure.supylabel("change (k_B T per bead)", fontsize=10)
    words = (
        f"Energies per bead in k_B T, less those of the first record. At the end internal {curves[0][2][-1]:+.3g}, "
        + (f"kinetic and potential {curves[1][2][-1]:+.3g}, " if len(curves) > 1 else "")
        + f"conserved {drift[-1]:+.2g}; the conserved one differs by at most {np.nanmax(np.abs(drift)):.2g}. "
        "It is the sum of all, less what sources and walls gave."
    )
    head, columns = _common(run, whole.times, [*curves, ("conserved", whole.times, drift)])
    return Drawing("conserved", "Balance of energy", figure, words, table_of(head, columns, 16))


def species(run: Run) -> Drawing | None:
    """What became of the amount of each dissolved species, as bars."""
    if not run.balance:
        return None
    from matplotlib.figure import Figure

    shown = run.balance[:_MOST]
    figure = Figure(figsize=(WIDTH, 0.5 + 1.45 * len(shown)), layout="constrained")
    grid = figure.subplots(len(shown), 1, squeeze=False)[:, 0]
    rows = []
    for axes, one in zip(grid, shown, strict=True):
        amounts = (one.start, one.sources, one.reactions, one.held, one.now)
        places = np.arange(len(amounts))
        axes.barh(places, amounts, color=_BARS, edgecolor="#1d2731", linewidth=0.8, height=0.72)
        low, high = min(0.0, *amounts), max(0.0, *amounts)
        room = max(high - low, 1e-300)
        axes.set_xlim(low - (0.34 * room if low < 0.0 else 0.0), high + 0.34 * room)
        for place, amount in zip(places.tolist(), amounts, strict=True):
            side = -1 if amount < 0.0 else 1
            text = f"{amount:.5g}"
            axes.annotate(
                text,
                (amount, place),
                xytext=(4 * side, 0),
                textcoords="offset points",
                va="center",
                ha="left" if side > 0 else "right",
                fontsize=9,
            )
        axes.axvline(0.0, color="black", linewidth=0.7)
        axes.set_yticks(places, _GAINS)
        axes.invert_yaxis()
        axes.grid(axis="y", visible=False)
        axes.set_title(one.name, fontsize=10, loc="left")
        rows.append((one.name, *(f"{amount:.9g}" for amount in amounts), f"{one.remainder:.2g}"))
    grid[-1].set_xlabel("amount in all beads")
    told = "; ".join(f"{one.name} {one.start:.5g} at start, {one.now:.5g} now" for one in shown)
    words = (
        f"Amounts of dissolved species in all beads, from {run.balance_file}: {told}. What sources, reactions and "
        "beads with held concentrations gave stands between; what is missing in the sum is the remainder of the table."
    )
    if len(shown) < len(run.balance):
        words += f" The first {len(shown)} of {len(run.balance)} are drawn."
    return Drawing("species", "Dissolved species", figure, words, Table(("species", *_GAINS, "remainder"), tuple(rows)))


def _common(
    run: Run, times: FloatArray, curves: list[tuple[str, FloatArray, FloatArray]]
) -> tuple[list[str], list[FloatArray]]:
    """Columns of a table at common times."""
    columns = [np.interp(times, x, y) if not np.array_equal(times, x) else y for _, x, y in curves]
    return [axis_label("time", run.units.of("time")), *(label for label, _, _ in curves)], [times, *columns]
