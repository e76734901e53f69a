"""The section on output of Scene.explain(): files and intervals."""

from __future__ import annotations

from pydlpoly.scene.beads_state import carried_names
from pydlpoly.scene.bins import quantities_of
from pydlpoly.scene.explain_text import Words, every, wrap
from pydlpoly.scene.model import CorrelationPlan, ProfilePlan, Scene
from pydlpoly.trajectories import FORMATS


def lines(scene: Scene) -> list[str]:
    """Return the files that a run writes, and in which steps."""
    plan, word = scene.output, Words(scene)
    level = ("positions", "positions and velocities", "positions, velocities and forces", "compressed positions")
    trajectory = f"{level[plan.trajectory_level]} from step {plan.trajectory_start}"
    yaml = " as YAML" if plan.statistics_yaml else ""
    pairs = ", ".join("-".join(scene.species[k] for k in pair) for pair in plan.rdf_pairs)
    beads_file = plan.beads_file if carried_names(scene) else None
    last = [name for name in (plan.configuration_file, beads_file, plan.checkpoint_file) if name]
    dump = f" and {every(plan.checkpoint_every)}" if plan.checkpoint_every else ""
    files = [
        (plan.output_file, plan.print_every, f"report, rolling averages over {plan.stack_size} steps"),
        (plan.statistics_file, plan.statistics_every, f"statistics{yaml}"),
        (plan.diagnostics_file, plan.diagnostics_every, "kinetic and configurational temperature, drifts, pressure"),
        (plan.trajectory_file, plan.trajectory_every, trajectory),
        *(
            (FORMATS[name].files(plan.trajectory_stem)[0], plan.trajectory_every, f"{trajectory} in {name}")
            for name in plan.trajectory_formats
        ),
        (
            plan.rdf_file,
            plan.rdf_every,
            f"radial distribution in bins of {plan.rdf_bin_width:g}{word.length} for {pairs}",
        ),
        ("ZDNDAT", plan.zden_every, f"density profile along z in {plan.zden_bins} bins"),
        (
            ", ".join(f"VAFDAT_{name}" for name in scene.species),
            plan.vaf_every,
            f"a sample over {plan.vaf_steps} steps begins, {'averaged' if plan.vaf_averaging else 'each written'}",
        ),
        *_bins(scene),
        (plan.msd_file, plan.msd_every, f"displacement and temperature of every bead from step {plan.msd_start}"),
    ]
    files += [_profile(plan.profile), _correlations(plan.correlations)]
    blocks = [wrap(f"{name}: {every(interval)}, {what}") for name, interval, what in files if name and interval]
    usual = (plan.statistics_file, plan.trajectory_file, plan.rdf_file)
    silent = [name for name, interval, _ in files if name in usual and name and not interval]
    flat = [line for block in blocks for line in block]
    if plan.output_file and not plan.print_every:
        flat.insert(0, f"{plan.output_file}: the report, without lines during the run")
    if last:
        flat.append(f"{' and '.join(last)}: at the end{dump}")
    if silent:
        flat.append(f"not written: {', '.join(silent)}")
    return flat or ["nothing is written"]


def _bins(scene: Scene) -> list[tuple[str | None, int, str]]:
    files = []
    for what, plan in (("profiles", scene.output.bead_profile), ("maps", scene.output.bead_map)):
        bins, axes = " x ".join(str(count) for count in plan.bins), " and ".join(plan.axes)
        names = ", ".join(quantities_of(scene, plan.quantities))
        files.append((plan.file, plan.every, f"{what} along {axes} in {bins} bins: {names}"))
    return files


def _profile(plan: ProfilePlan) -> tuple[str | None, int, str]:
    what = f"stress in {plan.layers} layers along {plan.axis}: momenta, pair laws and bonded terms"
    return plan.file, plan.every, what


def _correlations(plan: CorrelationPlan) -> tuple[str | None, int, str]:
    names = ", ".join(term.name for term in plan.terms)
    return plan.file, plan.every if plan.terms else 0, f"correlations of the stress ({names})"
