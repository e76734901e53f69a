"""Checks of runs whose beads carry heat or dissolved species: do their balances close?"""

from __future__ import annotations

from pydlpoly.formats.species_balance import SpeciesBalance
from pydlpoly.report.collect import Run
from pydlpoly.report.drift import drift_of
from pydlpoly.report.evidence import Evidence
from pydlpoly.report.finding import Finding, unknown
from pydlpoly.scene.model import Scene

REMAINDER = 1e-9


def conserved_energy(evidence: Evidence) -> list[Finding]:
    """Where beads carry heat, a drift of what is conserved (heat.md) by more than 1 % of k_B T per bead.

    As for the energy with nve. Nothing is concluded where something does work that is in no account.
    """
    scene = evidence.run.scene
    subject = "Conserved energy"
    if scene is None or scene.heat is None:
        return []
    if (why := _not_conserved(evidence.run, scene)) is not None:
        return [unknown(subject, f"it is not conserved here: {why}")]
    if "conserved_energy" not in evidence.series:
        return [unknown(subject, "it was not recorded", "`diagnostics_frequency`")]
    return drift_of(
        evidence,
        "conserved_energy",
        subject,
        "the conserved energy (kinetic, potential and internal, less what sources gave)",
        "a shorter `timestep`",
    )


def species_balance(evidence: Evidence) -> list[Finding]:
    """A dissolved species of which more is missing or too much than a billionth of what there is or was exchanged.

    Rounding makes about 1e-16 in each exchange between two beads, up and down by chance.
    """
    run = evidence.run
    subject = "Dissolved species"
    if run.scene is None or run.scene.transport is None:
        return []
    if not run.balance:
        return [unknown(subject, "no file says what became of them: OUTPUT has no end, and there is no REVIVE")]
    open_ones = [one for one in run.balance if abs(one.remainder) > REMAINDER * scale_of(one)]
    names = ", ".join(one.name for one in run.balance)
    if not open_ones:
        return [Finding("fine", subject, f"the balance of {names} closes to rounding (from {run.balance_file})")]
    told = "; ".join(
        f"of {one.name} there is {one.now:.6g}, {abs(one.remainder):.3g} {'more' if one.remainder > 0.0 else 'less'} "
        "than start, sources, reactions and held beads add up to"
        for one in open_ones
    )
    text = f"the balance does not close: {told} (from {run.balance_file})"
    if run.callbacks:
        return [Finding("note", subject, f"{text}; what {', '.join(run.callbacks)} brought is in no balance")]
    return [Finding("warning", subject, text, "what `set_state` brings is in no balance; nothing else may be missing")]


def scale_of(one: SpeciesBalance) -> float:
    """Return the largest amount in a balance, 1 where there is none."""
    return max(abs(x) for x in (one.start, one.sources, one.reactions, one.held, one.now)) or 1.0


def _not_conserved(run: Run, scene: Scene) -> str | None:
    heat = scene.heat
    assert heat is not None
    if run.callbacks:
        return f"{', '.join(run.callbacks)} may change what beads carry"
    if heat.scaled_repulsion:
        return "the repulsion grows with temperature (`repulsion scaled`)"
    if heat.viscous_heating != "conserving":
        return f"viscous heating is that of `viscous_heating {heat.viscous_heating}`"
    if scene.external:
        return "an external field does work"
    return None
