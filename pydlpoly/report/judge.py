"""Whether a run can be trusted, in words: one small function for each thing that is looked at.

A deviation counts only when it is larger than its threshold and than what chance explains as seldom as three standard
errors (``pydlpoly.formats.blocks.beyond_chance``). Each function's text says where its threshold comes from.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable

import numpy as np

from pydlpoly.formats.blocks import block_means
from pydlpoly.report.collect import Run
from pydlpoly.report.drift import drift_of
from pydlpoly.report.evidence import (
    Evidence,
    independent_samples,
    kinetic_pressure,
    largest_fluctuation,
    momentum_goes_to,
    thermal_momentum,
    with_error,
)
from pydlpoly.report.finding import Finding, unknown
from pydlpoly.report.judge_carried import conserved_energy, species_balance
from pydlpoly.report.series import LEAST_SAMPLES, Average, change_and_chance, trend_and_chance
from pydlpoly.temperatures import TOLERATED, change_over

KINETIC = 0.01
PRESSURE_ERROR, PRESSURE_CHANGE = 0.05, 0.02
MOMENTUM = 1e-3
REPORTERS, LEAST_SECONDS = 0.25, 10.0
LEAST_INDEPENDENT = 4.0
EQUILIBRATION = 0.05


def judge_run(run: Run) -> list[Finding]:
    """Return what all checks find, warnings first."""
    evidence = Evidence(run)
    found = [finding for check in CHECKS for finding in check(evidence)]
    order = ("warning", "note", "unknown", "fine")
    return sorted(found, key=lambda finding: order.index(finding.level))


def anything_there(evidence: Evidence) -> list[Finding]:
    """A folder without output, or without STATIS, from which most numbers come. No threshold."""
    run = evidence.run
    if not run.has_output:
        text = "there are no output files of a run in this folder"
        advice = f"run it first: `pydlpoly run {evidence.folder}`"
        if "CONTROL" not in run.files:
            advice = "name the folder that `pydlpoly run` wrote into (its `--output`)"
        return [Finding("warning", "Nothing was run", text, advice)]
    if run.statistics is None and not any(problem.file == "STATIS" for problem in run.problems):
        return [unknown("Statistics", "there is no STATIS: no averages of pressure and energies", "`stats_frequency`")]
    if run.statistics is not None and not len(run.statistics):
        return [Finding("warning", "Statistics", "STATIS holds no record: the run was killed at its start")]
    return []


def whole_run(evidence: Evidence) -> list[Finding]:
    """Steps done against steps asked for, and how the run ended. No threshold: any step that is missing counts."""
    run, log = evidence.run, evidence.run.log
    asked, done = run.asked_steps, run.done_steps
    if not run.has_output:
        return []
    stopped = next((text for text in (log.warnings if log else ()) if text.startswith("the run stopped:")), None)
    again = f"continue with `pydlpoly run {evidence.folder} --resume`"
    if "REVIVE" not in run.files:
        again = "there is no checkpoint to continue from: `data_dump_frequency` says how often one is written"
    if stopped is not None:
        advice = "a shorter `timestep`, or forces capped at the start (`equilibration_force_cap`), may help"
        return [Finding("warning", "Run stopped", f"{stopped}; {done} of {asked} steps were taken", advice)]
    if log is not None and not log.ended:
        text = f"the run did not end in good order{_of(done, asked)}: it was killed, or is still running"
        return [Finding("warning", "Run incomplete", text, again)]
    if asked is not None and done is not None and done < asked:
        text = f"the run ended early{_of(done, asked)}"
        return [Finding("warning", "Run incomplete", text, again)]
    if asked == 0 or done == 0:
        return [Finding("warning", "No steps", "the run took no step: there is nothing to average", "set `time_run`")]
    if done is None or asked is None:
        return [unknown("Length of the run", "the files do not say how many steps were asked for")]
    return [Finding("fine", "Length of the run", f"all {asked} steps were taken")]


def kinetic_temperature(evidence: Evidence) -> list[Finding]:
    """More than 1 % and more than the error from the thermostat's temperature.

    Groot and Warren (J. Chem. Phys. 107, 4423 (1997)) judge timesteps by this rise; 1 % is the error that ``pydlpoly
    tradeoff`` aims at unless told otherwise. A mean that is off by four standard deviations of a single step is no
    chance, however few samples there are.
    """
    target, average = evidence.run.target_temperature, evidence.kinetic()
    if target is None:
        return [unknown("Kinetic temperature", "there is no thermostat with a fixed temperature to compare with")]
    if average is None:
        return [unknown("Kinetic temperature", "there are no samples after the equilibration")]
    off = average.value / target - 1.0
    numbers = f"{_mean(evidence, average, 'temperature')}, thermostat {evidence.number(target, 'temperature')}"
    chance = min(average.chance, largest_fluctuation(evidence.run))
    if abs(off) <= KINETIC or abs(average.value - target) <= chance:
        return [Finding("fine", "Kinetic temperature", f"kinetic temperature within 1 % or its error ({numbers})")]
    text = f"kinetic temperature {_percent(off)} ({numbers})"
    cause, advice = _cause(evidence, "temperature", average.value - target)
    return [Finding("warning", "Temperature", f"{text}: {cause}", advice)]


def configurational_temperature(evidence: Evidence) -> list[Finding]:
    """More than 2 % and more than the error from thermostat or kinetic temperature.

    The threshold is that of the run's own warning (``pydlpoly.temperatures.TOLERATED``). Allen (J. Phys. Chem. B 110,
    3823 (2006)) shows that too long a timestep of DPD shows in this temperature while the kinetic one is right.
    """
    average, kinetic = evidence.configurational(), evidence.kinetic()
    reference, name = evidence.run.target_temperature, "the thermostat"
    if reference is None and kinetic is not None:
        reference, name = kinetic.value, "the kinetic one"
    if average is None:
        return [unknown("Configurational temperature", "it was not recorded", "`diagnostics_frequency`")]
    if reference is None or not reference > 0.0 or not math.isfinite(average.chance):
        return [unknown("Configurational temperature", "there are too few samples after the equilibration")]
    off = average.value / reference - 1.0
    numbers = f"{_mean(evidence, average, 'temperature')}, {name} {evidence.number(reference, 'temperature')}"
    chance = average.chance
    if evidence.run.target_temperature is None and kinetic is not None:
        chance = math.hypot(chance, kinetic.chance)
    if abs(off) <= TOLERATED or abs(average.value - reference) <= chance:
        text = f"configurational temperature within 2 % or its error ({numbers})"
        return [Finding("fine", "Configurational temperature", text)]
    cause, advice = _cause(evidence, "configurational_temperature", average.value - reference)
    text = f"configurational temperature {_percent(off)} ({numbers}), and structure and pressure with it: {cause}"
    return [Finding("warning", "Configurational temperature", text, advice)]


def equilibrated(evidence: Evidence) -> list[Finding]:
    """A straight line through temperature or potential energy that changes by 2 % of T, or 5 % of k_B T a bead.

    2 % is what the run's own warning tolerates (``pydlpoly.temperatures.TOLERATED``); 5 % of k_B T a bead is about as
    much: 2 % of T is 3 % of k_B T in kinetic energy.
    """
    run, scene = evidence.run, evidence.run.scene
    if scene is None or scene.dynamics.schedule is not None or scene.dynamics.thermal_energy <= 0.0:
        return []
    target = scene.dynamics.thermal_energy / scene.units.boltzmann
    energy = scene.dynamics.thermal_energy / scene.units.factor
    found = []
    for name, label, kind, limit in (
        ("temperature", "the kinetic temperature", "temperature", TOLERATED * target),
        ("configurational_energy", "the potential energy per bead", "energy", EQUILIBRATION * energy),
    ):
        series = evidence.series.get(name)
        change, chance = trend_and_chance(series) if series is not None and run.beads else (0.0, math.inf)
        if abs(change) > max(limit, chance):
            way, unit = "rises" if change > 0.0 else "falls", f" {evidence.units.of(kind)}".rstrip()
            found.append(f"{label} still {way}, by about {abs(change):.2g}{unit} over the samples")
    if not found:
        return []
    return [Finding("warning", "Not equilibrated", " and ".join(found), "a longer `time_equilibration`")]


def momentum(evidence: Evidence) -> list[Finding]:
    """A total momentum that grows to more than 1/1000 of √(3 M k_B T), what it would be if nothing conserved it.

    Pair forces, drag and noise of DPD conserve it to rounding; M is the mass of all beads. Where walls, fields, frozen
    beads, tethers or a thermostat of single beads take it up, nothing is said.
    """
    run, scene = evidence.run, evidence.run.scene
    if scene is None:
        return [unknown("Momentum", "without CONTROL and FIELD it is not known whether it is conserved")]
    if (taken := momentum_goes_to(run)) is not None:
        return [unknown("Momentum", f"it is not conserved here: {taken}")]
    drift = evidence.series.get("momentum_drift")
    thermal = thermal_momentum(run)
    if not thermal > 0.0:
        return [unknown("Momentum", "at temperature 0 there is nothing to compare with")]
    if drift is not None and np.isfinite(drift.values).any():
        largest = float(np.nanmax(drift.values)) / thermal
    elif run.momentum is not None and scene.run.start == "clean":
        largest = float(np.linalg.norm(run.momentum)) / thermal
    else:
        return [unknown("Momentum", "it was not recorded", "`diagnostics_frequency`")]
    if largest > MOMENTUM or not math.isfinite(largest):
        text = f"the total momentum has drifted to {largest:.2g} of its thermal size √(3 M k_B T)"
        return [
            Finding("warning", "Momentum", f"{text}, though pair forces conserve it: something else moves the beads")
        ]
    return [Finding("fine", "Momentum", f"conserved: it drifts by at most {largest:.1g} of √(3 M k_B T)")]


def energy_drift(evidence: Evidence) -> list[Finding]:
    """With nve, a drift of the total energy by more than 1 % of k_B T per bead over the run, and than its error.

    1 % of k_B T is a change of the temperature by at most as much: where it all went into motion, 2/3 of a per cent.
    """
    scene = evidence.run.scene
    if scene is None or scene.dynamics.integrator != "nve" or scene.heat is not None:
        return []
    if scene.dynamics.shear_rate != 0.0:
        return [unknown("Energy drift", "it is not conserved here: shear does work")]
    advice = "a shorter `timestep`, or laws that end smoothly (`vdw_force_shift`)"
    return drift_of(evidence, "extended_energy", "Energy drift", "the total energy", advice)


def pressure(evidence: Evidence) -> list[Finding]:
    """A pressure whose halves differ by more than 2 % and than chance, or whose error is above 5 %.

    2 % of the pressure of DPD water (23.7, κ⁻¹ ≈ 16, Groot and Warren 1997) is what 1 % of its density makes; 5 % is
    where a mean hardly has two digits.
    """
    series, average = evidence.series.get("pressure"), evidence.average("pressure")
    if series is None or average is None or not average.known:
        return [unknown("Pressure", "there are too few samples after the equilibration")]
    size = max(abs(average.value), kinetic_pressure(evidence))
    mean = _mean(evidence, average, "pressure")
    change, chance = change_and_chance(series)
    if abs(change) > max(chance, PRESSURE_CHANGE * size):
        text = f"the pressure still changes, by {evidence.number(change, 'pressure')} between the halves ({mean})"
        return [Finding("warning", "Pressure", text, "a longer `time_equilibration`")]
    if average.error > PRESSURE_ERROR * size:
        text = f"the pressure is not converged: its error is {100.0 * average.error / size:.0f} % ({mean})"
        return [Finding("warning", "Pressure", text, "a longer `time_run`")]
    return [Finding("fine", "Pressure", f"steady over the samples, {mean}")]


def enough_samples(evidence: Evidence) -> list[Finding]:
    """Fewer than 8 samples, or samples so much alike that fewer than 4 independent ones remain: errors mean little.

    8 is the number of blocks that an error is made of where there are enough (``pydlpoly.formats.blocks``).
    """
    run = evidence.run
    if run.statistics is None or not run.has_output or not run.done_steps:
        return []
    series = evidence.series.get("pressure")
    count = int(series.counted.sum()) if series is not None else 0
    more = "a longer `time_run`, or a smaller `stats_frequency`"
    if count == 0 and run.equilibration:
        text = f"STATIS has no record after the equilibration ({run.equilibration} steps): there are no averages"
        return [Finding("warning", "Too short", text, more)]
    if count < LEAST_SAMPLES:
        text = f"{count} samples after the equilibration are too few for errors"
        return [Finding("warning", "Too short", text, more)]
    assert series is not None
    independent = independent_samples(series)
    if independent < LEAST_INDEPENDENT:
        text = f"{count} samples of the pressure are worth about {max(independent, 1.0):.0f} independent ones: too few"
        return [Finding("warning", "Too short", text, "a longer `time_run`")]
    text = f"{count} samples, worth about {independent:.0f} independent ones of the pressure"
    return [Finding("fine", "Samples", text)]


def finite(evidence: Evidence) -> list[Finding]:
    """Numbers in STATIS or DIAGNOSTICS that are not finite. No threshold."""
    bad = [one.label for one in evidence.series.values() if not np.isfinite(one.values).all()]
    # Where nothing acts there is no configurational temperature, and that is no fault.
    bad = [label for label in bad if label != "configurational temperature"]
    if not bad:
        return []
    text = f"not finite at some time: {', '.join(bad[:4])}{' and others' if len(bad) > 4 else ''}"
    return [Finding("warning", "Not a number", text, "a shorter `timestep`; look at the start configuration")]


def files(evidence: Evidence) -> list[Finding]:
    """Files that cannot be read, or not to their end, and a trajectory that is cut. No threshold."""
    run = evidence.run
    found = [Finding("warning", f"File {problem.file}", problem.text) for problem in run.problems]
    if run.history is not None and run.history.cut:
        found.append(Finding("warning", f"File {run.history_file}", f"{run.history.cut}; the whole frames are used"))
    return found


def own_words(evidence: Evidence) -> list[Finding]:
    """What the run said of itself: the warnings at the end of OUTPUT, or of the scene where it did not get so far."""
    run = evidence.run
    texts: list[str] = []
    if run.log is not None and run.log.ended:
        texts = list(run.log.warnings)
    elif run.scene is not None:
        texts = [note.text for note in run.scene.notes if note.kind == "warning"]
    said = ("the run stopped:", "the run was interrupted", "temperatures disagree")  # said by other checks
    return [Finding("note", "The run says", text) for text in texts if not text.startswith(said)]


def time_of_reporters(evidence: Evidence) -> list[Finding]:
    """More than a quarter of the loop's time in observing and writing instead of steps.

    A choice of ours: below that, longer intervals would gain less than a better timestep does. Runs of less than ten
    seconds are over before it matters.
    """
    log = evidence.run.log
    if log is None or (log.loop_seconds or 0.0) < LEAST_SECONDS or "of which motion and forces" not in log.timings:
        return []
    assert log.loop_seconds is not None
    parts = {name.removeprefix("of which "): t for name, t in log.timings.items() if name.startswith("of which ")}
    steps = parts.pop("motion and forces")
    share = 1.0 - steps / log.loop_seconds
    if share <= REPORTERS or not parts:
        return []
    name = max(parts, key=lambda part: parts[part])
    text = f"{100.0 * share:.0f} % of the time went into observing and writing, most of it into {name}"
    return [Finding("note", "Speed", text, "longer intervals between records")]


CHECKS: tuple[Callable[[Evidence], list[Finding]], ...] = (
    anything_there,
    whole_run,
    finite,
    kinetic_temperature,
    configurational_temperature,
    equilibrated,
    energy_drift,
    conserved_energy,
    species_balance,
    momentum,
    pressure,
    enough_samples,
    files,
    own_words,
    time_of_reporters,
)
"""All checks, in the order in which their warnings are listed."""


def _cause(evidence: Evidence, name: str, off: float) -> tuple[str, str]:
    """The likely cause of a temperature that is off, and what to do."""
    run, scene = evidence.run, evidence.run.scene
    series = evidence.series.get(name)
    values = series.values[series.counted] if series is not None else np.zeros(0)
    values = block_means(values[np.isfinite(values)])
    change = change_over(values) if len(values) >= 4 else 0.0
    if abs(change) > 0.5 * abs(off):  # as the run's own warning has it
        return "it still changes, the run is not equilibrated", "a longer `time_equilibration`"
    heat = "heats the beads faster than they lose heat, or the timestep is too long"
    if scene is not None and scene.external:
        return f"an external field {heat}", _shorter(run)
    if scene is not None and scene.dynamics.shear_rate != 0.0:
        return f"shear {heat}", _shorter(run)
    step = f" ({evidence.number(run.timestep, 'time')})" if run.timestep else ""
    if run.equilibration == 0 or series is None or independent_samples(series) < LEAST_INDEPENDENT:
        step += ", or the run is not equilibrated"
    return f"timestep too long{step}", _shorter(run)


def _shorter(run: Run) -> str:
    folder = shlex.quote(str(run.folder))
    return f"`pydlpoly tradeoff {folder}` finds integrator and timestep that are accurate enough"


def _percent(off: float) -> str:
    size = 100.0 * abs(off)
    return f"{size:.{1 if size < 10.0 else 0}f} % {'high' if off > 0.0 else 'low'}"


def _mean(evidence: Evidence, average: Average, kind: str) -> str:
    return f"{with_error(average)} {evidence.units.of(kind)}".rstrip()


def _of(done: int | None, asked: int | None) -> str:
    if done is None:
        return ""
    return f", at step {done}" + (f" of {asked}" if asked is not None else "")
