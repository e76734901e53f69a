"""What was found: records, their JSON form, and their text.

The JSON form is the records as objects, with ``"format": 1``; docs/accuracy-and-speed.md lists the members.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from pydlpoly.bench.results import Machine, Spread, significant
from pydlpoly.errors import InputError
from pydlpoly.formats.control import write_control
from pydlpoly.formats.records import Control, Setting, SettingValue
from pydlpoly.tradeoff.candidates import Candidate
from pydlpoly.tradeoff.statistics import REACH, Deviation, Verdict

FORMAT = 1

Status = Literal["measured", "unstable", "not run"]

QUANTITIES = {
    "temperature": "T",
    "configurational_temperature": "T conf",
    "pressure": "P",
    "energy": "U",
    "rdf": "g(r)",
    "drift": "drift",
    "diffusion": "D",
}
"""Every quantity that errors are told of, with the head of its column."""


@dataclass(frozen=True)
class Measured(Candidate):
    """A candidate and what was found for it.

    Attributes:
        status: "measured", "unstable" or "not run".
        why: what happened when it is not "measured", or why it got no more time.
        speed: simulated time (ps, or reduced) a second of wall time, None unless measured.
        time: simulated time that was averaged over.
        deviations: by name of ``QUANTITIES``; without those that do not exist in this scene.
        error: the size of the largest deviation, ``error_of``: whose it is, ``error_noise``: its statistical error.
        verdict: "within" when all quantities are, "outside" when one is.
        front: whether it belongs to the Pareto front: no faster candidate is as accurate, as far as can be told.
        given_up: whether it got no more time, because it could not win any more.
    """

    status: Status = "not run"
    why: str = ""
    speed: Spread | None = None
    time: float = 0.0
    deviations: dict[str, Deviation] | None = None
    error: float | None = None
    error_of: str = ""
    error_noise: float | None = None
    verdict: Verdict = "cannot tell"
    front: bool = False
    given_up: bool = False


@dataclass(frozen=True)
class Reference:
    """What the candidates were compared with.

    Attributes:
        integrator, timestep, precision: how it was run.
        time: simulated time that was averaged over.
        averages: temperature, configurational temperature, pressure (units of reports) and potential energy a bead
            (internal units) with their statistical errors, as pairs.
        deviations: of its own temperatures from the thermostat's; empty without one.
    """

    integrator: str
    timestep: float
    precision: str
    time: float
    averages: dict[str, tuple[float, float]]
    deviations: dict[str, Deviation]


@dataclass(frozen=True)
class TradeoffReport:
    """Speed against accuracy of one scene.

    Attributes:
        title: of the scene; ``beads``: how many.
        time_unit: "ps", or "" in reduced units.
        target: largest error that is aimed at, as a fraction.
        budget, seconds: wall time that was granted and used.
        seed, threads: of all runs.
        candidates: fastest first, those that were not measured last.
        recommended: index of the fastest candidate that is within the target, None when there is none.
        undecided: indices of faster candidates that may be within, too.
        budget_needed: seconds that would do to tell, None when nothing is left to tell.
        notes: what else should be known.
        interrupted: whether it was ended before its time.
    """

    title: str
    beads: int
    time_unit: str
    machine: Machine
    target: float
    budget: float
    seconds: float
    seed: int
    threads: int
    reference: Reference
    candidates: tuple[Measured, ...]
    recommended: int | None
    undecided: tuple[int, ...]
    budget_needed: float | None
    notes: tuple[str, ...] = ()
    interrupted: bool = False

    @property
    def recommendation(self) -> Measured | None:
        """The fastest candidate that is within the target, None when there is none."""
        return None if self.recommended is None else self.candidates[self.recommended]

    @property
    def too_short(self) -> bool:
        """Whether the budget was too short to recommend anything."""
        return self.recommended is None and self.budget_needed is not None

    def as_json(self) -> dict[str, Any]:
        """Return the report as JSON objects."""
        return {"format": FORMAT, **asdict(self)}

    def text(self, control: Control | None = None, *, everything: bool = False) -> str:
        """Return the report in lines.

        Args:
            control: the scene's CONTROL, whose style and units the lines to paste shall have.
            everything: also the candidates that were given up early or not run, which the table else leaves out.
        """
        shown = self.candidates if everything else self.noteworthy()
        parts = [self._head(), self.table(shown), self._legend(len(self.candidates) - len(shown)), self._outcome()]
        best = self.recommendation
        if best is not None:
            parts.append("\n".join(f"  {line}" for line in control_lines(best, self.time_unit, control)))
        parts += [f"note: {note}" for note in self.notes]
        return "\n".join(part for part in parts if part)

    def noteworthy(self) -> list[Measured]:
        """Return the candidates without those that were given up early or not run."""
        return [one for one in self.candidates if self._matters(one)]

    def table(self, shown: Sequence[Measured] | None = None) -> str:
        """Return candidates (default: all) in columns, errors in per cent with their statistical errors."""
        rest = self.candidates if shown is None else shown
        measured = [one.deviations or {} for one in rest]
        columns = [name for name in QUANTITIES if any(name in one for one in measured)]
        unit = f"{self.time_unit}/s" if self.time_unit else "time/s"
        header = ["", "integrator", "timestep", "precision", unit, *(QUANTITIES[name] for name in columns), "verdict"]
        rows = [header]
        for one in rest:
            head = ["*" if one.front else "", one.name, f"{one.timestep:g}", one.precision]
            if one.status != "measured" or one.speed is None or one.deviations is None:
                rows.append([*head, "", *("" for _ in columns), f"{one.status}: {one.why}" if one.why else one.status])
                continue
            cells = [deviation_text(one.deviations[name]) if name in one.deviations else "" for name in columns]
            rows.append([*head, significant(one.speed.median), *cells, one.verdict + (" (CONTROL)" * one.own)])
        return "\n".join(_columns(rows))

    def _head(self) -> str:
        reference = self.reference
        unit = f" {self.time_unit}" if self.time_unit else ""
        return (
            f"{self.title}: {self.beads} beads, {self.threads} thread{'s' * (self.threads > 1)}, {self.seconds:.0f} s\n"
            f"compared with {reference.integrator}, timestep {reference.timestep:g}{unit}, over {reference.time:.4g}"
            f"{unit}; measured on {self.machine.text()}\n"
            "errors in per cent +- their statistical error, fastest first:"
        )

    def _matters(self, one: Measured) -> bool:
        if one.own or one.front:
            return True
        if one.status == "unstable":  # the first timestep that fails says it all
            return not one.why.startswith("so is")
        return one.status == "measured" and not one.given_up

    def _legend(self, left_out: int) -> str:
        words = ["* no faster candidate is as accurate"] if any(one.front for one in self.candidates) else []
        return "; ".join([*words, *([f"{left_out} more are not shown (--all)"] if left_out else [])])

    def _outcome(self) -> str:
        goal = f"{100.0 * self.target:.3g} %"
        best = self.recommendation
        budget = "" if self.budget_needed is None else f"--budget {duration(self.budget_needed)}"
        if best is not None and best.speed is not None:
            lines = [f"fastest within {goal}: {best.label}{self._against_own(best)}"]
            if self.undecided:
                names = "; ".join(self.candidates[k].label for k in self.undecided[:3])
                more = f" and {len(self.undecided) - 3} more" if len(self.undecided) > 3 else ""
                lines.append(f"faster, and within {goal} or not, which noise hides: {names}{more}")
                lines.append(f"errors shrink as 1/sqrt(time): about {budget} would tell")
            return "\n".join([*lines, "in CONTROL:"])
        if self.too_short:
            return (
                f"the budget of {duration(self.budget)} is too short to say what is within {goal}\n"
                f"errors shrink as 1/sqrt(time): about {budget} would tell"
            )
        errors = [(one.error, one) for one in self.candidates if one.error is not None]
        if not errors:
            return f"nothing is within {goal}: no candidate could be measured"
        least = min(errors, key=lambda pair: pair[0])
        return (
            f"nothing is within {goal}; the most accurate is {least[1].label} with {100.0 * least[0]:.2g} % in "
            f"{QUANTITIES[least[1].error_of]}: try smaller timesteps (--timesteps) or another --target"
        )

    def _against_own(self, best: Measured) -> str:
        own = next((one for one in self.candidates if one.own), None)
        if best.own:
            return ", as CONTROL has it"
        if own is None or own.speed is None or best.speed is None:
            return ""
        return f", {significant(best.speed.median / own.speed.median)} times as fast as CONTROL's settings"


def control_lines(one: Measured, time_unit: str, control: Control | None = None) -> list[str]:
    """Return the lines that give CONTROL a candidate's settings, in the style and the timestep's unit of ``control``.

    What the old style cannot say is said in the new one, with a line above that says how to convert the file.
    """
    given = None if control is None else control.get("timestep")
    unit, timestep = time_unit or "dpd_t", one.timestep
    if given is not None and control is not None and isinstance(given.value, (int, float)) and given.unit:
        in_internal = _timestep(control)
        if in_internal > 0.0 and given.value > 0:
            unit, timestep = given.unit, float(f"{one.timestep * float(given.value) / in_internal:.12g}")
    settings: list[tuple[str, SettingValue, str | None]] = []
    if one.integrator != "nve":
        settings += [("ensemble", "nvt", None), ("ensemble_method", "dpd", None)]
        settings += [("ensemble_dpd_order", one.integrator, None)]
        if one.prediction is not None and (one.prediction != 0.5 or _has(control, "ensemble_dpd_lambda")):
            settings.append(("ensemble_dpd_lambda", one.prediction, None))
        if one.half or _has(control, "ensemble_dpd_kinetic"):
            settings.append(("ensemble_dpd_kinetic", "half" if one.half else "whole", None))
        if one.interval > 1 or _has(control, "ensemble_dpd_interval"):
            settings.append(("ensemble_dpd_interval", one.interval, None))
    else:
        settings.append(("ensemble", "nve", None))
    settings.append(("timestep", timestep, unit))
    if one.precision != "double" or _has(control, "precision"):
        settings.append(("precision", one.precision, None))
    if one.integrator != "nve" and control is not None and control.style == "old":
        drag = control.get("ensemble_dpd_drag")  # stands on the line of the ensemble
        settings += [] if drag is None else [(drag.keyword, drag.value, drag.unit)]
    record = Control("", tuple(Setting(word, value, unit) for word, value, unit in settings), "new", "", ())
    if control is not None and control.style == "old":
        try:
            lines = write_control(replace(record, style="old")).splitlines()
            return [line for line in lines if line.split()[:1] and line.split()[0] in ("ensemble", "timestep")]
        except InputError:  # λ, an interval, or a precision
            return ["# after: pydlpoly convert CONTROL --to new", *write_control(record).splitlines()[1:]]
    lines = write_control(record).splitlines()[1:]
    if control is not None and control.meso is not None:
        return ["# after: pydlpoly convert FOLDER --to dl_poly", *lines]
    return lines


def _has(control: Control | None, keyword: str) -> bool:
    return control is not None and control.get(keyword) is not None


def _timestep(control: Control) -> float:
    from pydlpoly.formats.control import value_in

    value = value_in(control, "timestep")
    return float(value) if isinstance(value, (int, float)) else 0.0


def deviation_text(deviation: Deviation) -> str:
    """Return a deviation in per cent ``+-`` its statistical error."""
    noise = 100.0 * deviation.error
    if not noise < float("inf"):
        return f"{100.0 * deviation.value:+.1f}+-?"
    digits = 3 if noise < 0.01 else 2 if noise < 1.0 else 1 if noise < 10.0 else 0
    return f"{100.0 * deviation.value:+.{digits}f}+-{noise:.{digits}f}"


def _columns(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]) - 1)]
    left = (0, 1, 3)  # front, integrator, precision
    lines = []
    for row in rows:
        cells = [
            f"{cell:<{w}}" if k in left else f"{cell:>{w}}"
            for k, (cell, w) in enumerate(zip(row[:-1], widths, strict=True))
        ]
        lines.append("  ".join([*cells, row[-1]]).rstrip())
    return lines


def duration(seconds: float) -> str:
    """Return a time as ``--budget`` takes it: seconds up to two minutes, minutes up to three hours, then hours."""
    if seconds < 119.5:
        return f"{max(1, round(seconds))}s"
    if seconds < 3 * 3600:
        return f"{round(seconds / 60)}min"
    return f"{round(seconds / 3600)}h"


def scalar_error(deviations: dict[str, Deviation]) -> tuple[float, str, float]:
    """Return the deviation that is largest in spite of its noise: size, quantity, statistical error."""

    def sure(name: str) -> tuple[float, float]:
        one = deviations[name]
        return abs(one.value) - REACH * one.error, abs(one.value)

    worst = max(deviations, key=sure)
    return abs(deviations[worst].value), worst, deviations[worst].error


def overall(deviations: dict[str, Deviation]) -> Verdict:
    """Return "within" when all are, "outside" when one is."""
    verdicts = {one.verdict for one in deviations.values()}
    if "outside" in verdicts:
        return "outside"
    return "within" if verdicts == {"within"} else "cannot tell"


def on_front(candidates: Sequence[Measured]) -> list[bool]:
    """Say which candidates have no faster one that is as accurate, as far as noise lets tell.

    A slower candidate stands on the front only when it is more accurate than every faster one by more than the noise of
    both; of two whose rates cannot be told apart, the one that is less accurate beyond noise does not.
    """

    def beats(one: Measured, other: Measured) -> bool:
        if one.speed is None or other.speed is None or one.error is None or other.error is None:
            return False
        noise = REACH * float(((one.error_noise or 0.0) ** 2 + (other.error_noise or 0.0) ** 2) ** 0.5)
        if one.speed.low > other.speed.high:
            return one.error <= other.error + noise
        if one.speed.high < other.speed.low:
            return False
        faster = one.speed.median > other.speed.median
        return one.error < other.error - noise or (faster and one.error <= other.error + noise)

    return [
        one.status == "measured"
        and one.error is not None
        and not any(beats(o, one) for o in candidates if o is not one)
        for one in candidates
    ]
