"""The pair laws as the scene sees them, and the meaning of the numbers of one FIELD ``vdw`` record."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

from pydlpoly import _core
from pydlpoly.errors import SceneError, suggest
from pydlpoly.formats.records import Field, PairLine
from pydlpoly.scene import many_body_records
from pydlpoly.scene.cell import LONGEST
from pydlpoly.scene.settings import Notes, place


@dataclass(frozen=True)
class PairLaw:
    """One pair law of the compiled core's registry.

    Attributes:
        key: DL_POLY's key, at most four letters.
        parameter_names: the law's own numbers in the order of the FIELD record.
        energy_mask: bit k set: parameter k is an energy and is scaled by FIELD's unit.
        drag_slot: 1-based position of the drag in the record; 0: the record has no room for it.
        soft: finite at r = 0. has_tail: DL_POLY adds a long-range correction.
        mixable: the mixing rules know it. shiftable: ``vdw_force_shift`` applies to it.
    """

    key: str
    description: str
    parameter_names: tuple[str, ...]
    energy_mask: int
    drag_slot: int
    soft: bool
    has_tail: bool
    mixable: bool
    shiftable: bool

    def scaled(self, numbers: tuple[float, ...], factor: float) -> tuple[float, ...]:
        """Return the law's numbers with its energies multiplied by ``factor``."""
        return tuple(x * factor if self.energy_mask >> k & 1 else x for k, x in enumerate(numbers))


@lru_cache(maxsize=1)
def pair_laws() -> dict[str, PairLaw]:
    """Return all pair laws of the compiled core by key."""
    laws = {}
    for row in _core.pair_laws():
        laws[row["key"]] = PairLaw(
            key=row["key"],
            description=row["description"],
            parameter_names=tuple(row["parameter_names"]),
            energy_mask=row["energy_mask"],
            drag_slot=row["drag_slot"],
            soft=row["soft"],
            has_tail=row["has_tail"],
            mixable=row["mixable"],
            shiftable=row["shiftable"],
        )
    return laws


# Laws whose drag slot is not simply the next number, and what a user of DL_POLY should know about it.
_ODD_DRAG_SLOTS = {
    "wca": "number 4 of the wca record is its drag, as documented; DL_POLY's code puts the law's range in its place",
    "zbl": "number 5 of the zbl record is its drag, as in DL_POLY; numbers 3 and 4 have no meaning",
}


@dataclass(frozen=True)
class PairEntry:
    """One understood ``vdw`` record: parameters in internal units, the drag and its own cutoff where they were written.

    ``range`` is where the law itself ends, 0 when it ends at the run's cutoff.
    """

    law: PairLaw
    parameters: tuple[float, ...]
    range: float
    drag: float | None
    drag_cutoff: float | None
    where: str


def read_entry(line: PairLine, field: Field, factor: float, notes: Notes) -> PairEntry:
    """Tell apart a record's law parameters, drag and drag cutoff.

    Args:
        line: the record as FIELD has it.
        field: the file, for messages.
        factor: FIELD's energy unit in internal units.
        notes: receives what is odd but understood.

    Raises:
        SceneError: unknown law, too few or too many numbers, or numbers that the law refuses.
    """
    law = pair_laws().get(line.key)
    if law is None:
        known = ", ".join(sorted(pair_laws()))
        raise _refusal(
            line, field, f"is not a pair law that is modelled{suggest(line.key, pair_laws())} (known: {known})"
        )
    numbers = line.parameters
    if law.key == "wca" and len(numbers) == 2:
        numbers = (*numbers, 0.0)  # the manual gives the shift D a default of 0
    if law.key == many_body_records.KEY:
        numbers = many_body_records.in_full(numbers)
    count = len(law.parameter_names)
    if len(numbers) < count:
        names = " ".join(law.parameter_names)
        hint = many_body_records.HINT if law.key == many_body_records.KEY else ""
        raise _refusal(line, field, f"needs {count} numbers ({names}{hint}), found {len(line.parameters)}")
    where = place(field.path, line.line)
    drag, drag_cutoff = _read_drag(law, numbers, line, field, where, notes)
    parameters = law.scaled(numbers[:count], factor)
    return PairEntry(law, parameters, law_range(law, parameters, line, field), drag, drag_cutoff, where)


def law_range(law: PairLaw, parameters: tuple[float, ...], line: PairLine, field: Field) -> float:
    """Return where the law itself ends (Å), 0 when it ends at the run's cutoff; SceneError for impossible numbers."""
    if law.key == "tab":  # a table ends where its file does
        return 0.0
    try:
        return float(_core.pair_range(law.key, list(parameters)))
    except ValueError as error:
        raise _refusal(line, field, str(error)) from None


def _read_drag(
    law: PairLaw, numbers: tuple[float, ...], line: PairLine, field: Field, where: str, notes: Notes
) -> tuple[float | None, float | None]:
    """Return the drag and its own cutoff, each None when the record does not give it."""
    count, slot = len(law.parameter_names), law.drag_slot
    if slot == 0:
        _refuse_extra(numbers, count, line, field, "its record has no room for a drag", where, notes)
        return None, None
    _refuse_extra(numbers[: slot - 1], count, line, field, f"its drag is number {slot} of the record", where, notes)
    if len(numbers) < slot:
        return None, None
    drag = numbers[slot - 1]
    if not math.isfinite(drag):
        raise _refusal(line, field, f"the drag must be a finite number, not {drag:g}")
    if drag != 0.0 and law.key in _ODD_DRAG_SLOTS:
        notes.choice(_ODD_DRAG_SLOTS[law.key], where)
    if drag < 0.0:
        notes.warning(f"negative drag {drag:g} of {_pair(line)}: the absolute value is taken, as DL_POLY does", where)
    cutoff = numbers[slot] if len(numbers) > slot else 0.0
    if not 0.0 <= cutoff <= LONGEST:
        text = f"the drag's own cutoff (number {slot + 1}) lies above 0 and up to {LONGEST:g} ang, not at {cutoff:g}"
        raise _refusal(line, field, text)
    _refuse_extra(numbers, slot + 1, line, field, "after the drag and its cutoff the record ends", where, notes)
    return abs(drag), cutoff or None


def _refuse_extra(
    numbers: tuple[float, ...], count: int, line: PairLine, field: Field, reason: str, where: str, notes: Notes
) -> None:
    """Refuse numbers without meaning from position ``count`` on; zeros are the padding of old fixed-width files."""
    for position, number in enumerate(numbers[count:], start=count + 1):
        if number != 0.0:
            names = " ".join(pair_laws()[line.key].parameter_names)
            message = f"number {position} of the {line.key} record of {_pair(line)} has no meaning: "
            message += f"the law takes {names or 'no numbers'}, and {reason}"
            raise SceneError(message, path=field.path, line=line.line or None, word=f"{number:g}")
    if len(numbers) > count:
        notes.ignored(f"zeros after the numbers of the {line.key} record of {_pair(line)} have no meaning", where)


def _pair(line: PairLine) -> str:
    return f"{line.species[0]} {line.species[1]}"


def _refusal(line: PairLine, field: Field, message: str) -> SceneError:
    return SceneError(f"{_pair(line)}: {message}", path=field.path, line=line.line or None, word=line.key)
