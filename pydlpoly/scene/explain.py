"""Scene.explain(): the whole scene in words and plain tables, with the origin of every number."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from pydlpoly import _core
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene import explain_bonded, explain_heat, explain_transport
from pydlpoly.scene.beads_state import carried_names
from pydlpoly.scene.bins import quantities_of
from pydlpoly.scene.cell import widths
from pydlpoly.scene.integrators import INTEGRATORS, THERMOSTATS, is_pairwise
from pydlpoly.scene.laws import pair_laws
from pydlpoly.scene.model import CorrelationPlan, Heat, Note, PairTerm, ProfilePlan, Scene
from pydlpoly.scene.transport_terms import Transport
from pydlpoly.trajectories import FORMATS
from pydlpoly.units import BOLTZMANN

_WIDTH = 100
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
        ("Integrator and thermostat", _dynamics(scene)),
        ("Pair table", _pairs(scene)),
        ("Bonded terms", _bonded(scene)),
        ("Electrostatics", _electrostatics(scene)),
        *([("Heat", _heat(scene, scene.heat))] if scene.heat is not None else []),
        *([] if scene.transport is None else [("Dissolved species", _transport(scene, scene.transport))]),
        ("Cutoffs and link cells", _cutoffs(scene)),
        ("Plan", [*(_plan(scene) if plan is None else plan), *notes]),
        ("Long-range correction", _long_range(scene)),
        ("External fields", _external(scene)),
        ("Run", _run(scene)),
        ("Output", _output(scene)),
        ("Not modelled or without effect", _absent(scene)),
        ("Choices", _notes(scene, "choice")),
        ("Warnings", _notes(scene, "warning")),
    ]
    return "\n\n".join("\n".join([title, "-" * len(title), *lines]) for title, lines in sections) + "\n"


def _plan(scene: Scene) -> list[str]:
    return [line for plan in PLANS for line in plan(scene)] or ["no engine is loaded"]


class _Words:
    """Unit words for numbers in internal units; empty in a scene in reduced units."""

    def __init__(self, scene: Scene) -> None:
        reduced = scene.units.reduced
        self.length, self.time, self.mass = ("", "", "") if reduced else (" ang", " ps", " Da")
        self.drag, self.volume, self.density = ("", "", "") if reduced else (" Da/ps", " ang^3", " ang^-3")
        self.force, self.velocity = ("", "") if reduced else (" Da ang/ps^2", " ang/ps")


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
    word, beads = _Words(scene), scene.beads
    volume = float(abs(np.linalg.det(scene.cell)))
    rows = []
    for number, name in enumerate(scene.species):
        chosen = beads.species == number
        frozen = int(np.count_nonzero(beads.frozen[chosen]))
        values = (_spread(beads.mass[chosen]), _spread(beads.charge[chosen]))
        rows.append([name, str(int(chosen.sum())), *values, str(frozen)])
    molecules = [
        f"{count} {name or '(no name)'}"
        for name, count in zip(scene.molecule_names, scene.molecule_counts, strict=True)
    ]
    cell = ["  " + " ".join(f"{x:12.6g}" for x in row) for row in scene.cell]
    return [
        *_table(["species", "beads", "mass", "charge", "frozen"], rows),
        *_wrap(f"molecules: {', '.join(molecules)}"),
        f"cell: imcon {scene.imcon}, {_IMCON[scene.imcon]}",
        *cell,
        f"volume {volume:.6g}{word.volume}, {len(beads)} beads, {len(beads) / volume:.6g} beads per unit volume"
        f"{word.density and ' (' + word.density.strip() + ')'}",
    ]


def _dynamics(scene: Scene) -> list[str]:
    word, dynamics = _Words(scene), scene.dynamics
    kelvin = dynamics.thermal_energy / BOLTZMANN
    temperature = f"k_B T = {dynamics.thermal_energy:.9g}"
    if not scene.units.reduced:
        temperature = f"temperature {kelvin:.9g} K, {temperature} (10 J/mol)"
    if dynamics.integrator == "nve":
        lines = ["nve: velocity Verlet, no thermostat", f"{temperature}, for drawn or scaled velocities only"]
    elif dynamics.integrator in THERMOSTATS:
        lines = [f"{dynamics.integrator}: {THERMOSTATS[dynamics.integrator].about}", temperature]
        if dynamics.integrator == "langevin":
            lines.append(
                f"friction {dynamics.thermostat_friction:g}" + (f" 1/{word.time.strip()}" if word.time else "")
            )
        else:
            lines.append(f"relaxation time {dynamics.relaxation:g}{word.time}")
        if dynamics.schedule is not None:
            lines += _wrap(_schedule_text(scene))
    else:
        exponent = dynamics.weight_exponent
        lines = [
            f"{dynamics.integrator}: {INTEGRATORS[dynamics.integrator].about}",
            temperature,
            *_parameters_of(scene),
            f"weight of the drag (1 - r/rc)^{exponent:g}, of the noise (1 - r/rc)^{exponent / 2:g}; "
            "noise^2 = 2 drag k_B T",
        ]
    drift = "is removed in every step" if dynamics.remove_drift else "is not removed"
    return [
        *lines,
        *_barostat(scene),
        f"timestep {dynamics.timestep:g}{word.time}",
        f"degrees of freedom {scene.degrees_of_freedom}; drift of the centre of mass {drift}",
    ]


_CELL_MOTION = {
    "isotropic": "the edges of the cell change by one factor",
    "height": "z changes, the area of x and y stays as it is",
    "square": "the edges x and y change by one factor, z by another",
    "edges": "each edge of the cell changes by its own factor, the angles stay 90 degrees",
}


def _barostat(scene: Scene) -> list[str]:
    """What moves the cell."""
    barostat, word, units = scene.dynamics.barostat, _Words(scene), scene.units
    if barostat is None:
        return []
    pressures = [f"{x * units.pressure_factor:.9g}" for x in barostat.pressure]
    faces = pressures[0] if len(set(pressures)) == 1 else f"{' '.join(pressures)} on the faces across x y z"
    unit = units.pressure_label and f" {units.pressure_label}"
    lines = [
        f"barostat: Langevin piston; {_CELL_MOTION[barostat.motion]}",
        f"target pressure {faces}{unit}, of conservative forces and velocities, without drag and noise",
        f"piston of mass g k_B T t^2, g degrees of freedom, t = {barostat.relaxation:g}{word.time}; friction "
        f"{barostat.friction:g}" + (f" 1/{word.time.strip()}" if word.time else ""),
    ]
    if barostat.semi in ("tension", "orthorhombic"):
        tension = barostat.tension * units.tension_factor
        lines.append(f"surface tension of the xy plane {tension:.9g}{'' if units.reduced else ' dyn/cm'}")
    return lines


def _parameters_of(scene: Scene) -> list[str]:
    """What the integrator takes beside drags and timestep, and how the temperature varies."""
    dynamics, word = scene.dynamics, _Words(scene)
    rate = f" 1/{word.time.strip()}" if word.time else ""
    texts = {
        "ensemble_dpd_lambda": f"prediction of the velocities lambda = {dynamics.prediction:g}",
        "ensemble_dpd_tolerance": f"iterated until the kinetic energy changes by less than {dynamics.tolerance:g}",
        "ensemble_dpd_passes": f"passes over the pairs in the middle of the drift: {dynamics.passes}",
    }
    if dynamics.half_step_kinetic:
        texts["ensemble_dpd_kinetic"] = "kinetic temperature and stress are of the half-step velocities"
    if dynamics.interval > 1:
        texts["ensemble_dpd_interval"] = f"thermostat {_every(dynamics.interval)}, for as many steps at once"
    if dynamics.transverse_drag:
        text = f"drag across the line of a pair: {dynamics.transverse_drag:g} times that along it"
        texts["ensemble_dpd_transverse_drag"] = text
    if dynamics.collision_rate:
        texts["ensemble_dpd_rate"] = f"a pair is chosen {dynamics.collision_rate:g}{rate}"
    elif "ensemble_dpd_rate" in INTEGRATORS[dynamics.integrator].keywords:
        texts["ensemble_dpd_rate"] = "a pair is chosen at the rate drag/(2 reduced mass)"
    texts["ensemble_dpd_coupling"] = f"drag of the pairs not chosen: {dynamics.coupling:g} (1 - T/T_pairs)"
    texts["ensemble_dpd_thermostat_mass"] = (
        f"inertia of the common drag {dynamics.thermostat_mass:g} degrees of freedom kT/drag^2, its friction "
        f"{dynamics.thermostat_friction:g}{rate}"
    )
    taken = INTEGRATORS[dynamics.integrator].keywords
    lines = [text for keyword, text in texts.items() if keyword in taken]
    if dynamics.schedule is not None:
        lines += _wrap(_schedule_text(scene))
    return lines


def _schedule_text(scene: Scene) -> str:
    schedule, word = scene.dynamics.schedule, _Words(scene)
    assert schedule is not None
    unit = 1.0 if scene.units.reduced else BOLTZMANN
    kind = "" if scene.units.reduced else " K"
    if schedule.amplitude:
        return (
            f"the temperature follows a sine of amplitude {schedule.amplitude / unit:.6g}{kind} and period "
            f"{schedule.period:g}{word.time}"
        )
    points = [
        f"{energy / unit:.6g}{kind} at {time:g}{word.time}"
        for time, energy in zip(schedule.times, schedule.energies, strict=True)
    ]
    return "the temperature follows straight lines between " + ", ".join(points)


def _pairs(scene: Scene) -> list[str]:
    units, word = scene.field_units or scene.units, _Words(scene)
    thermostat = is_pairwise(scene.dynamics.integrator)
    headers = ["pair", "law", "parameters", "ends at", *(["drag", "noise", "drag ends at"] if thermostat else [])]
    rows, texts = [], []
    for term in scene.pairs:
        row = [_pair_name(scene, term), term.law or "-", _parameters(term, 1.0 / units.factor), "-"]
        if term.law is not None:
            row[3] = f"{term.cutoff:g}" + (" shifted" if term.force_shift else "")
        if thermostat:
            end = f"{term.drag_cutoff:g}" if term.drag else "-"
            row += [f"{term.drag:.6g}", f"{term.noise:.6g}", end]
        rows.append(row)
        text = f"{_pair_name(scene, term)}: {term.explanation}"
        if term.law is not None and units.factor != 1.0 and term.parameters:
            text += f"; in internal units {_parameters(term, 1.0)}"
        texts.extend(_wrap(text, "  "))
    energy = units.label or "reduced units"
    lengths = f", lengths in{word.length}, drags in{word.drag}" if word.length else ""
    laws = {term.law: pair_laws()[term.law].description for term in scene.pairs if term.law is not None}
    return [
        f"energies in {energy}{lengths}, as in FIELD",
        *_table(headers, rows),
        "where the numbers come from:",
        *texts,
        *(f"{key}: {description}" for key, description in laws.items()),
        *_many_body(scene),
    ]


def _many_body(scene: Scene) -> list[str]:
    """Local densities and what they do to the pairs of the law mdpd."""
    given, units, word = scene.many_body, scene.field_units or scene.units, _Words(scene)
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
    return [line for text in texts for line in _wrap(text)]


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
    units, word = scene.field_units or scene.units, _Words(scene)
    lengths = f", lengths in{word.length}" if word.length else ""
    texts = [line for text in explain_bonded.sentences(scene, scene.bonded) for line in _wrap(text)]
    return [
        f"energies in {units.label or 'reduced units'}{lengths}, angles in degrees, as in FIELD",
        *_table(*explain_bonded.headers_and_rows(scene, scene.bonded)),
        *texts,
        *_constraints(scene),
    ]


def _constraints(scene: Scene) -> list[str]:
    """The fixed distances, and what becomes of the pair forces where there is nothing else."""
    if scene.constraints is None:
        return []
    word, fixed = _Words(scene), scene.constraints
    lines = [
        f"constraints: {scene.constraint_count} fixed at {_spread(fixed.lengths)}{word.length} "
        f"({fixed.explanation}), by SHAKE and RATTLE",
        f"constraints are met to {fixed.tolerance:g}{word.length} in at most {fixed.most_iterations} iterations",
    ]
    if scene.bonded is not None and not scene.bonded.terms:
        lines.append(f"pairs without pair forces, drag and noise: {len(scene.bonded.excluded)}")
    return [line for text in lines for line in _wrap(text)]


def _electrostatics(scene: Scene) -> list[str]:
    given, word, charges = scene.electrostatics, _Words(scene), scene.beads.charge
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
    return [line for text in texts for line in _wrap(text)]


def _heat(scene: Scene, heat: Heat) -> list[str]:
    table = _table(*explain_heat.headers_and_rows(scene, heat)) if heat.terms else []
    return [*table, *(line for text in explain_heat.sentences(scene, heat) for line in _wrap(text))]


def _transport(scene: Scene, transport: Transport) -> list[str]:
    table = _table(*explain_transport.headers_and_rows(scene, transport)) if transport.fluxes else []
    texts = explain_transport.sentences(scene, transport)
    return [
        "C is an amount a bead; dC = -kappa w^2 (Ci - Cj) dt between beads, w^2 = (1 - r/range)^exponent",
        *table,
        *(line for text in texts for line in _wrap(text)),
    ]


def _cutoffs(scene: Scene) -> list[str]:
    word = _Words(scene)
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


def _external(scene: Scene) -> list[str]:
    word, lines = _Words(scene), []
    for term in scene.external:
        lines += _wrap(f"{term.key}: {_FIELDS[term.key](word, term.parameters)}, from {term.explanation}")
    return [*lines, *_walls(scene), *_shear(scene)] or ["none"]


def _vector(numbers: Sequence[float]) -> str:
    return "(" + " ".join(f"{x:g}" for x in numbers[:3]) + ")"


_FIELDS: dict[str, Callable[[_Words, tuple[float, ...]], str]] = {
    "grav": lambda _, p: f"F = m G with G = {_vector(p)} in internal units",
    "oshr": lambda word, p: f"Fx = A cos(2 pi n z/Lz) with A = {p[0]:g}{word.force}, n = {p[1]:g}",
    "elec": lambda _, p: f"F = q E with E = {_vector(p)} in internal units",
    "osel": lambda word, p: (
        f"F = q E sin(2 pi f t) with E = {_vector(p)} in internal units, f = {p[3]:g}{word.time and ' 1/ps'}"
    ),
    "magn": lambda _, p: f"F = q v x H with H = {_vector(p)} in internal units, along exact helices",
    "shrx": lambda word, p: (
        f"vx = sign(z) A/2 for |z| > z0 with A = {p[0]:g}{word.velocity}, z0 = {p[1]:g}{word.length}"
    ),
    "sphr": lambda word, p: (
        f"U = A (R0 - r)^-n for r > Rcut with A = {p[0]:g} in internal units, R0 = {p[1]:g}{word.length}, "
        f"n = {p[2]:g}, Rcut = {p[3]:g}{word.length}"
    ),
    "zbnd": lambda word, p: (
        f"U = A (z - z0)^2/2 {'above' if math.copysign(1.0, p[2]) > 0.0 else 'below'} z0 with A = {p[0]:g} in internal "
        f"units, z0 = {p[1]:g}{word.length}"
    ),
    "pois": lambda word, p: f"Fx = m g sign(y) with g = {p[0]:g}{word.velocity and ' ang/ps^2'}",
}


def _walls(scene: Scene) -> list[str]:
    walls, word = scene.walls, _Words(scene)
    if walls is None:
        return []
    places = ", ".join(
        f"{axis} = -{d:g} and {d:g}{word.length}"
        for axis, wall, d in zip("xyz", walls.walled, walls.distance, strict=True)
        if wall
    )
    turns = {"reflecting": "the velocity across the wall is", "bounce-back": "the whole velocity of a bead is"}
    lines = _wrap(f"walls at {places}: {turns[walls.method]} reversed there, from {walls.explanation}")
    if walls.strengths:
        named = ", ".join(f"{name} {a:g}" for name, a in zip(scene.species, walls.strengths, strict=True))
        lines += _wrap(
            f"before them U = A rc (1 - d/rc)^2/2 at the distance d, rc = {walls.range:g}{word.length}, A in internal "
            f"units: {named}"
        )
    return lines


def _shear(scene: Scene) -> list[str]:
    rate, word = scene.dynamics.shear_rate, _Words(scene)
    if rate == 0.0:
        return []
    return [f"Lees-Edwards boundaries: flow along x, gradient along y, shear rate {rate:g}{word.time and ' 1/ps'}"]


def _run(scene: Scene) -> list[str]:
    run, word = scene.run, _Words(scene)
    length = f"{run.steps * scene.dynamics.timestep:g}"
    length = f"{length}{word.time}" if word.time else f"time {length}"
    lines = [f"{run.steps} {'step' if run.steps == 1 else 'steps'}, {length} in all"]
    if run.equilibration_steps:
        averages = "from step 1 on" if run.record_equilibration else "after it"
        lines.append(f"equilibration: the first {run.equilibration_steps} steps; averages are taken {averages}")
        for every, what in ((run.rescale_every, "scaled to the temperature"), (run.regauss_every, "drawn anew")):
            if every:
                lines.append(f"  velocities are {what} {_every(every)} of it")
        if run.force_cap:
            lines.append(f"  forces are capped at {run.force_cap:g}{word.force} in it")
    else:
        lines.append("no equilibration")
    source = f" {run.checkpoint_file}" if run.start == "continue" else ""
    seed = "drawn anew for each run, and printed" if run.seed is None else str(run.seed)
    threads = "all threads there are" if run.threads == 0 else f"{run.threads} threads"
    return [*lines, f"start ({run.start}): {_START[run.start]}{source}", f"seed: {seed}", threads]


def _output(scene: Scene) -> list[str]:
    plan, word = scene.output, _Words(scene)
    level = ("positions", "positions and velocities", "positions, velocities and forces", "compressed positions")
    trajectory = f"{level[plan.trajectory_level]} from step {plan.trajectory_start}"
    yaml = " as YAML" if plan.statistics_yaml else ""
    pairs = ", ".join("-".join(scene.species[k] for k in pair) for pair in plan.rdf_pairs)
    beads_file = plan.beads_file if carried_names(scene) else None
    last = [name for name in (plan.configuration_file, beads_file, plan.checkpoint_file) if name]
    dump = f" and {_every(plan.checkpoint_every)}" if plan.checkpoint_every else ""
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
    lines = [_wrap(f"{name}: {_every(every)}, {what}") for name, every, what in files if name and every]
    usual = (plan.statistics_file, plan.trajectory_file, plan.rdf_file)
    silent = [name for name, every, _ in files if name in usual and name and not every]
    flat = [line for block in lines for line in block]
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
    return [*_wrap(f"not in this scene, at no cost: {', '.join(absent)}"), *_note_lines(scene, "ignored")]


def _notes(scene: Scene, kind: str) -> list[str]:
    return _note_lines(scene, kind) or ["none"]


def _note_lines(scene: Scene, kind: str) -> list[str]:
    return [line for note in scene.notes if note.kind == kind for line in _wrap(_note_text(note), "* ")]


def _note_text(note: Note) -> str:
    return f"{note.text} [{note.where}]" if note.where else note.text


# -- plain text -------------------------------------------------------------------------------------------------------


def _pair_name(scene: Scene, term: PairTerm) -> str:
    return "-".join(scene.species[k] for k in term.species)


def _every(steps: int) -> str:
    return "every step" if steps == 1 else f"every {steps} steps"


def _spread(values: FloatArray) -> str:
    if len(values) == 0:
        return "-"
    low, high = float(np.min(values)), float(np.max(values))
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _wrap(text: str, start: str = "") -> list[str]:
    """Fold a sentence; words are never cut, so that names of files can be copied."""
    return textwrap.wrap(
        text,
        _WIDTH,
        initial_indent=start,
        subsequent_indent="  " if start in ("", "* ") else " " * (len(start) + 2),
        break_long_words=False,
        break_on_hyphens=False,
    )


def _table(headers: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Align columns: words to the left, numbers to the right."""
    rows = [list(row) for row in rows]
    sizes = [max(len(cell) for cell in column) for column in zip(headers, *rows, strict=True)]
    right = [all(_is_number(row[k]) for row in rows) for k in range(len(headers))]

    def line(cells: Sequence[str]) -> str:
        padded = [c.rjust(n) if r else c.ljust(n) for c, n, r in zip(cells, sizes, right, strict=True)]
        return "  ".join(padded).rstrip()

    return [line(headers), *(line(row) for row in rows)]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return text == "-"
    return True
