"""Scene.explain(): the whole scene in words and plain tables, with the origin of every number."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from pydlpoly import _core
from pydlpoly.scene import (
    explain_bonded,
    explain_dynamics,
    explain_external,
    explain_heat,
    explain_output,
    explain_transport,
)
from pydlpoly.scene.cell import widths
from pydlpoly.scene.explain_text import Words, every, pair_name, spread, table, wrap
from pydlpoly.scene.integrators import is_pairwise
from pydlpoly.scene.laws import pair_laws
from pydlpoly.scene.model import Heat, Note, PairTerm, Scene
from pydlpoly.scene.transport_terms import Transport

_IMCON = {
    0: "no periodicity",
    1: "cubic",
    2: "orthorhombic",
    3: "parallelepiped",
    6: "slab, periodic in x and y",
}
_START = {
    "clean": "velocities drawn from the Maxwell distribution at the temperature",
    "rescale": "the file's velocities, scaled to the temperature",
    "noscale": "the file's velocities as they are",
    "continue": "goes on from the checkpoint",
}
# Position, velocity, force, image, mass, species, and a sorted copy of what the pair loop reads.
_BYTES_PER_BEAD = 200


# Engines add how they would compute a scene; the scene itself knows none of them.
PLANS: list[Callable[[Scene], list[str]]] = []


def explain(scene: Scene, plan: Sequence[str] | None = None, notes: Sequence[str] = ()) -> str:
    """Return the scene as text of at most 100 columns (more only where a file's name is longer).

    Args:
        scene: what is explained.
        plan: how an engine computes it (default: as the native engine would).
        notes: what that engine says about its results.
    """
    sections = [
        ("Scene", _title(scene)),
        ("System", _system(scene)),
        ("Integrator and thermostat", explain_dynamics.lines(scene)),
        ("Pair table", _pairs(scene)),
        ("Bonded terms", _bonded(scene)),
        ("Electrostatics", _electrostatics(scene)),
        *([("Heat", _heat(scene, scene.heat))] if scene.heat is not None else []),
        *([] if scene.transport is None else [("Dissolved species", _transport(scene, scene.transport))]),
        ("Cutoffs and link cells", _cutoffs(scene)),
        ("Plan", [*(_plan(scene) if plan is None else plan), *notes]),
        ("Long-range correction", _long_range(scene)),
        ("External fields", explain_external.lines(scene)),
        ("Run", _run(scene)),
        ("Output", explain_output.lines(scene)),
        ("Not modelled or without effect", _absent(scene)),
        ("Choices", _notes(scene, "choice")),
        ("Warnings", _notes(scene, "warning")),
    ]
    return "\n\n".join("\n".join([title, "-" * len(title), *lines]) for title, lines in sections) + "\n"


def _plan(scene: Scene) -> list[str]:
    return [line for plan in PLANS for line in plan(scene)] or ["no engine is loaded"]


def _title(scene: Scene) -> list[str]:
    units, field_units = scene.units, scene.field_units or scene.units
    lines = [scene.title or "(no title)", *(f"from {source}" for source in scene.sources)]
    if units.reduced:
        lines.append("reports in reduced units: k_B = 1, pressure in energy per volume")
    else:
        lines.append(f"reports: energy in {units.label}, temperature in K, pressure in katm")
    if units.reduced and field_units.reduced:
        lines.append("all numbers below are reduced")
    else:
        lines.append("lengths in ang, times in ps, masses in Da; internal energy 10 J/mol")
    return lines


def _system(scene: Scene) -> list[str]:
    word, beads = Words(scene), scene.beads
    volume = float(abs(np.linalg.det(scene.cell)))
    rows = []
    for number, name in enumerate(scene.species):
        chosen = beads.species == number
        frozen = int(np.count_nonzero(beads.frozen[chosen]))
        values = (spread(beads.mass[chosen]), spread(beads.charge[chosen]))
        rows.append([name, str(int(chosen.sum())), *values, str(frozen)])
    molecules = [
        f"{count} {name or '(no name)'}"
        for name, count in zip(scene.molecule_names, scene.molecule_counts, strict=True)
    ]
    cell = ["  " + " ".join(f"{x:12.6g}" for x in row) for row in scene.cell]
    return [
        *table(["species", "beads", "mass", "charge", "frozen"], rows),
        *wrap(f"molecules: {', '.join(molecules)}"),
        f"cell: imcon {scene.imcon}, {_IMCON[scene.imcon]}",
        *cell,
        f"volume {volume:.6g}{word.volume}, {len(beads)} beads, {len(beads) / volume:.6g} beads per unit volume"
        f"{word.density and ' (' + word.density.strip() + ')'}",
    ]


def _pairs(scene: Scene) -> list[str]:
    units, word = scene.field_units or scene.units, Words(scene)
    thermostat = is_pairwise(scene.dynamics.integrator)
    headers = ["pair", "law", "parameters", "ends at", *(["drag", "noise", "drag ends at"] if thermostat else [])]
    rows, texts = [], []
    for term in scene.pairs:
        row = [pair_name(scene, term), term.law or "-", _parameters(term, 1.0 / units.factor), "-"]
        if term.law is not None:
            row[3] = f"{term.cutoff:g}" + (" shifted" if term.force_shift else "")
        if thermostat:
            end = f"{term.drag_cutoff:g}" if term.drag else "-"
            row += [f"{term.drag:.6g}", f"{term.noise:.6g}", end]
        rows.append(row)
        text = f"{pair_name(scene, term)}: {term.explanation}"
        if term.law is not None and units.factor != 1.0 and term.parameters:
            text += f"; in internal units {_parameters(term, 1.0)}"
        texts.extend(wrap(text, "  "))
    energy = units.label or "reduced units"
    lengths = f", lengths in{word.length}, drags in{word.drag}" if word.length else ""
    laws = {term.law: pair_laws()[term.law].description for term in scene.pairs if term.law is not None}
    return [
        f"energies in {energy}{lengths}, as in FIELD",
        *table(headers, rows),
        "where the numbers come from:",
        *texts,
        *(f"{key}: {description}" for key, description in laws.items()),
        *_many_body(scene),
    ]


def _many_body(scene: Scene) -> list[str]:
    """Local densities and what they do to the pairs of the law mdpd."""
    given, units, word = scene.many_body, scene.field_units or scene.units, Words(scene)
    if given is None:
        return []
    two = given.form == "two-density"
    names = [f"{scene.species[a]}-{scene.species[b]}" for a, b in (term.species for term in given.terms)]
    kernels = {
        "warren": "W(0) (1 - r/rd)^n, the energy of a bead C rho^m/m",
        "lucy": "W(0) (1 + 3r/rd)(1 - r/rd)^3, forces B (rho_i + rho_j)(1 - r/rd) without an energy",
    }
    energy = f" {units.label}" if units.label and not two else ""
    texts = [
        f"local densities over {', '.join(names)}: {kernels[given.kernel]} ({given.kernel}, {given.explanation}); "
        f"{given.form} form, B = {given.repulsion / units.factor:.6g}{energy} for all pairs",
    ]
    heights = {f"W(0) = {t.height:.6g}, n = {t.exponent:g}, rd = {t.range:g}{word.length}": None for t in given.terms}
    if len(heights) == 1:
        texts.append(next(iter(heights)))
    else:
        texts += [
            f"{name}: W(0) = {t.height:.6g}, n = {t.exponent:g}, rd = {t.range:g}{word.length}"
            for name, t in zip(names, given.terms, strict=True)
        ]
    if given.kernel == "warren":
        powers = dict.fromkeys(given.powers)
        of_species = ", ".join(f"{m:g} for {name}" for name, m in zip(scene.species, given.powers, strict=True))
        texts.append(
            f"C = {given.strength / units.factor:.6g}, m = "
            + (f"{given.powers[0]:g}" if len(powers) == 1 else of_species)
        )
    return [line for text in texts for line in wrap(text)]


def _parameters(term: PairTerm, factor: float) -> str:
    """Return ``A=25 rc=1`` with the energies multiplied by ``factor``."""
    if term.law is None:
        return "no conservative force"
    if term.table is not None:
        return f"table of {term.table.shape[1]} points, spacing {term.table_spacing:g}"
    law = pair_laws()[term.law]
    numbers = law.scaled(term.parameters, factor)
    return " ".join(f"{name}={number:.6g}" for name, number in zip(law.parameter_names, numbers, strict=True))


def _bonded(scene: Scene) -> list[str]:
    if scene.bonded is None and scene.constraints is None:
        return ["none"]
    if scene.bonded is None or not scene.bonded.terms:
        return _constraints(scene)
    units, word = scene.field_units or scene.units, Words(scene)
    lengths = f", lengths in{word.length}" if word.length else ""
    texts = [line for text in explain_bonded.sentences(scene, scene.bonded) for line in wrap(text)]
    return [
        f"energies in {units.label or 'reduced units'}{lengths}, angles in degrees, as in FIELD",
        *table(*explain_bonded.headers_and_rows(scene, scene.bonded)),
        *texts,
        *_constraints(scene),
    ]


def _constraints(scene: Scene) -> list[str]:
    """The fixed distances, and what becomes of the pair forces where there is nothing else."""
    if scene.constraints is None:
        return []
    word, fixed = Words(scene), scene.constraints
    lines = [
        f"constraints: {scene.constraint_count} fixed at {spread(fixed.lengths)}{word.length} "
        f"({fixed.explanation}), by SHAKE and RATTLE",
        f"constraints are met to {fixed.tolerance:g}{word.length} in at most {fixed.most_iterations} iterations",
    ]
    if scene.bonded is not None and not scene.bonded.terms:
        lines.append(f"pairs without pair forces, drag and noise: {len(scene.bonded.excluded)}")
    return [line for text in lines for line in wrap(text)]


def _electrostatics(scene: Scene) -> list[str]:
    given, word, charges = scene.electrostatics, Words(scene), scene.beads.charge
    if given is None:
        return ["none"]
    charged = charges != 0.0
    names = ", ".join(scene.species[k] for k in np.unique(scene.beads.species[charged]))
    method = next(row["description"] for row in _core.charge_methods() if row["name"] == given.method)
    frozen = int(np.count_nonzero(charged & scene.beads.frozen))
    texts = [
        f"{given.keyword}: {method}",
        f"{int(np.count_nonzero(charged))} charged beads ({names}), total charge {math.fsum(charges.tolist()):.6g} e",
        f"cutoff between pairs {given.cutoff:g}{word.length}, the global one",
        *given.origins,
    ]
    if frozen:
        texts.append(f"{frozen} of the charged beads are frozen; what acts between them is in no energy or pressure")
    return [line for text in texts for line in wrap(text)]


def _heat(scene: Scene, heat: Heat) -> list[str]:
    rows = table(*explain_heat.headers_and_rows(scene, heat)) if heat.terms else []
    return [*rows, *(line for text in explain_heat.sentences(scene, heat) for line in wrap(text))]


def _transport(scene: Scene, transport: Transport) -> list[str]:
    rows = table(*explain_transport.headers_and_rows(scene, transport)) if transport.fluxes else []
    texts = explain_transport.sentences(scene, transport)
    return [
        "C is an amount a bead; dC = -kappa w^2 (Ci - Cj) dt between beads, w^2 = (1 - r/range)^exponent",
        *rows,
        *(line for text in texts for line in wrap(text)),
    ]


def _cutoffs(scene: Scene) -> list[str]:
    word = Words(scene)
    reach = max((max(term.cutoff, term.drag_cutoff) for term in scene.pairs), default=0.0)
    lines = [
        f"global cutoff {scene.cutoff:g}{word.length}: range of the radial distribution",
        f"van der Waals cutoff {scene.vdw_cutoff:g}{word.length}: where laws without a range of their own end",
    ]
    if reach <= 0.0:
        return [*lines, "no pair forces: no link cells"]
    count = len(scene.beads)
    density = count / float(abs(np.linalg.det(scene.cell)))
    neighbours = min(density * 2.0 / 3.0 * math.pi * reach**3, 0.5 * (count - 1))
    cells = [max(1.0, width // reach) for width in widths(scene.cell).tolist()]
    while math.prod(cells) > max(64.0, 4.0 * count):  # more cells than beads are of no use; the core stops here too
        longest = cells.index(max(cells))
        cells[longest] = max(1.0, cells[longest] // 2.0)
    small = " (fewer than 3 along an axis: images are counted one by one)" if min(cells) < 3 else ""
    return [
        *lines,
        f"longest range {reach:g}{word.length}: about {' x '.join(f'{n:.0f}' for n in cells)} link cells{small}",
        f"about {neighbours:.3g} pairs a bead within it, {count * neighbours:.3g} pair evaluations a step",
        f"memory: about {max(1.0, count * _BYTES_PER_BEAD / 1e6):.0f} MB",
    ]


def _long_range(scene: Scene) -> list[str]:
    tails = sorted({term.law for term in scene.pairs if term.law is not None and pair_laws()[term.law].has_tail})
    if not tails:
        return ["none: no law of this scene reaches beyond its cutoff"]
    if not scene.long_range_correction:
        return [f"none, although {', '.join(tails)} would reach beyond the cutoff"]
    return [f"energy and pressure include the tails of {', '.join(tails)} beyond their cutoffs"]


def _run(scene: Scene) -> list[str]:
    run, word = scene.run, Words(scene)
    length = f"{run.steps * scene.dynamics.timestep:g}"
    length = f"{length}{word.time}" if word.time else f"time {length}"
    lines = [f"{run.steps} {'step' if run.steps == 1 else 'steps'}, {length} in all"]
    if run.equilibration_steps:
        averages = "from step 1 on" if run.record_equilibration else "after it"
        lines.append(f"equilibration: the first {run.equilibration_steps} steps; averages are taken {averages}")
        for interval, what in ((run.rescale_every, "scaled to the temperature"), (run.regauss_every, "drawn anew")):
            if interval:
                lines.append(f"  velocities are {what} {every(interval)} of it")
        if run.force_cap:
            lines.append(f"  forces are capped at {run.force_cap:g}{word.force} in it")
    else:
        lines.append("no equilibration")
    source = f" {run.checkpoint_file}" if run.start == "continue" else ""
    seed = "drawn anew for each run, and printed" if run.seed is None else str(run.seed)
    threads = "all threads there are" if run.threads == 0 else f"{run.threads} threads"
    return [*lines, f"start ({run.start}): {_START[run.start]}{source}", f"seed: {seed}", threads]


def _absent(scene: Scene) -> list[str]:
    has_bonded = scene.bonded is not None and bool(scene.bonded.terms)
    terms = {"bonded terms": has_bonded, "electrostatics": scene.electrostatics is not None}
    absent = [name for name, present in terms.items() if not present]
    if all(term.law is None for term in scene.pairs):
        absent.append("conservative pair forces")
    if not is_pairwise(scene.dynamics.integrator):
        absent.append("drag and noise")
    if not scene.external and scene.walls is None and scene.dynamics.shear_rate == 0.0:
        absent.append("external fields")
    return [*wrap(f"not in this scene, at no cost: {', '.join(absent)}"), *_note_lines(scene, "ignored")]


def _notes(scene: Scene, kind: str) -> list[str]:
    return _note_lines(scene, kind) or ["none"]


def _note_lines(scene: Scene, kind: str) -> list[str]:
    return [line for note in scene.notes if note.kind == kind for line in wrap(_note_text(note), "* ")]


def _note_text(note: Note) -> str:
    return f"{note.text} [{note.where}]" if note.where else note.text
