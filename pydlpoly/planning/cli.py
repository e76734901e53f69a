"""``pydlpoly plan``: what a model says about a scene made larger, on many ranks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from pydlpoly.planning.model import Estimate, Fluid, Network
    from pydlpoly.scene import Scene

_MEASURED_SECONDS = 3.0
_WARM_UP = 20


def plan(
    directory: Annotated[Path, typer.Argument(help="Folder with CONTROL, FIELD and CONFIG.")],
    *,
    beads: Annotated[float | None, typer.Option(min=1.0, help="Beads of the planned run (default: CONFIG's).")] = None,
    ranks: Annotated[int, typer.Option(min=1, help="Largest number of ranks.")] = 64,
    steps: Annotated[int | None, typer.Option(min=1, help="Steps of the planned run (default: CONTROL's).")] = None,
    rate: Annotated[
        float | None, typer.Option(help="Million bead-steps a second of one core (default: measured here).")
    ] = None,
    latency: Annotated[float, typer.Option(min=0.0, help="Of a message, microseconds.")] = 2.0,
    bandwidth: Annotated[float, typer.Option(help="Of a node's network, GB/s.")] = 12.5,
    ranks_per_node: Annotated[int, typer.Option(min=1, help="Ranks that share a node's network.")] = 64,
    rebuild: Annotated[int, typer.Option(min=1, help="Steps between two lists of pairs.")] = 10,
    halo_bytes: Annotated[float, typer.Option(min=0.0, help="Sent in a step for each bead of a halo.")] = 72.0,
    plot: Annotated[Path | None, typer.Option(help="Draw times and shares (.png, .svg, .pdf).")] = None,
    lenient: Annotated[bool, typer.Option("--lenient", help="Misspelt words are warnings, not errors.")] = False,
) -> None:
    """Estimate time, memory and halos of the engine lammps on many ranks, from a model and one core's rate."""
    from pydlpoly.planning.model import Network, estimate, rank_counts
    from pydlpoly.scene import load

    for name, value in (("--bandwidth", bandwidth), ("--rate", rate if rate is not None else 1.0)):
        if not value > 0.0:
            raise typer.BadParameter(f"must be larger than 0, not {value:g}", param_hint=name)
    scene = load(directory, lenient=lenient)
    count = float(scene.bead_count) if beads is None else beads
    length = scene.run.steps if steps is None else steps
    fluid, origin = _fluid(scene, rate)
    network = Network(latency * 1e-6, bandwidth * 1e9, ranks_per_node, rebuild, halo_bytes)
    rows = [estimate(count, number, fluid, network) for number in rank_counts(ranks)]
    typer.echo("\n".join(_text(scene, count, length, fluid, origin, network, rows)))
    if plot is not None:
        from pydlpoly.planning.plot import write_plan_plot

        write_plan_plot(rows, plot)


def _fluid(scene: Scene, rate: float | None) -> tuple[Fluid, str]:
    """Return density, reach and rate, and where the rate comes from."""
    import numpy as np

    from pydlpoly.engines.lammps_translate.translation import SKIN, reach_of, translate
    from pydlpoly.planning.model import Fluid

    translate(scene, 1)  # a scene that LAMMPS does not run is refused
    reach = (1.0 + SKIN) * reach_of(scene)
    density = scene.bead_count / abs(float(np.linalg.det(scene.cell)))
    lists = 1 + len({pair.law for pair in scene.pairs if pair.law}) + any(pair.drag > 0.0 for pair in scene.pairs)
    # Densities take a list with every pair twice and their force another; exchange takes one more.
    lists += 3 * (scene.many_body is not None) + (scene.heat is not None) + (scene.transport is not None)
    if rate is not None:
        return Fluid(density, reach, rate * 1e6, lists), "given by --rate"
    return Fluid(density, reach, _measured(scene), lists), "measured here, LAMMPS on one rank"


def _measured(scene: Scene) -> float:
    """Return bead-steps a second of LAMMPS on one rank of this machine."""
    import time as clock

    from pydlpoly.simulation import Simulation

    simulation = Simulation(scene, seed=1, engine="lammps", ranks=1)
    simulation.run(_WARM_UP)
    begin, first = clock.perf_counter(), simulation.step
    while clock.perf_counter() - begin < _MEASURED_SECONDS:
        simulation.run(_WARM_UP)
    return scene.bead_count * (simulation.step - first) / (clock.perf_counter() - begin)


def _text(
    scene: Scene, beads: float, steps: int, fluid: Fluid, origin: str, network: Network, rows: list[Estimate]
) -> list[str]:
    lines = [
        "This is a model, not a measurement of the machine that is planned for; docs/plan.md has its formulas.",
        f"{beads:.4g} beads at a density of {fluid.density:.4g}, reach {fluid.reach:.4g} with the list's skin, "
        f"{steps} steps",
        f"one core: {fluid.rate / 1e6:.3g} million bead-steps a second ({origin})",
        f"network: latency {network.latency * 1e6:g} us, {network.bandwidth / 1e9:g} GB/s for the "
        f"{network.ranks_per_node} ranks of a node",
        f"sent: {network.bytes_per_bead:g} bytes a bead of the halo, a new list every {network.rebuild} steps",
        "",
        f"{'ranks':>8} {'beads/rank':>11} {'halo/bead':>9} {'ms/step':>10} {'compute':>8} {'halo':>7} {'sums':>7} "
        f"{'hours':>10} {'MB/rank':>9}",
    ]
    lines += [
        f"{row.ranks:>8} {row.beads:>11.4g} {row.halo / row.beads:>9.3g} {row.step * 1e3:>10.4g} "
        f"{row.efficiency:>8.1%} {row.halo_share:>7.1%} {row.collective / row.step:>7.1%} "
        f"{row.step * steps / 3600.0:>10.4g} {row.rank_memory / 1e6:>9.4g}"
        for row in rows
    ]
    front = rows[-1].front_memory / 1e9
    lines += ["", f"the process in front keeps a copy of all beads: {front:.3g} GB beside the ranks"]
    if front > 100.0:
        lines.append("that is more than most nodes have: pydlpoly convert --to lammps writes a script that needs none")
    if scene.electrostatics is not None and scene.electrostatics.method == "ewald":
        lines.append("the sum over reciprocal vectors is not in the model; its transforms add messages among all ranks")
    return lines
