"""The bonded laws as the scene sees them, and the meaning of the numbers of one line of a bonded block."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pydlpoly import _core
from pydlpoly.errors import SceneError
from pydlpoly.formats.records import BondedLine, Field
from pydlpoly.scene.model import BondedKind

KINDS: dict[str, BondedKind] = {
    "bonds": "bond",
    "angles": "angle",
    "dihedrals": "dihedral",
    "inversions": "inversion",
    "tethers": "tether",
}
"""The kind of terms that each block of a molecule holds."""

# Numbers 4 and 5 of a dihedral's line are the 1-4 factors, wherever its law's own numbers end.
_FACTORS = slice(3, 5)


@dataclass(frozen=True)
class BondedLaw:
    """One bonded law of the compiled core's registry.

    Attributes:
        kind: what it acts on.
        key, restraint_key: DL_POLY's keys; terms with the second one leave the beads their pair forces.
        parameter_names: the law's own numbers in the order of the line.
        energy_mask: bit k set: parameter k is an energy and is scaled by FIELD's unit.
        degree_mask: bit k set: parameter k is an angle, in degrees in FIELD.
        optional: so many of the last numbers may be left out; they are then 0.
        table: its numbers come from a file of tables, none from FIELD.
    """

    kind: BondedKind
    key: str
    restraint_key: str
    description: str
    parameter_names: tuple[str, ...]
    energy_mask: int
    degree_mask: int
    optional: int
    table: bool = False

    def internal(self, numbers: tuple[float, ...], factor: float) -> tuple[float, ...]:
        """Return FIELD's numbers in internal units: energies times ``factor``, angles in radians."""
        return self._converted(numbers, factor, math.pi / 180.0)

    def as_in_field(self, numbers: tuple[float, ...], factor: float) -> tuple[float, ...]:
        """Return numbers in internal units as FIELD has them."""
        return self._converted(numbers, 1.0 / factor, 180.0 / math.pi)

    def _converted(self, numbers: tuple[float, ...], energy: float, angle: float) -> tuple[float, ...]:
        scales = (
            energy if self.energy_mask >> k & 1 else angle if self.degree_mask >> k & 1 else 1.0
            for k in range(len(numbers))
        )
        return tuple(x * scale for x, scale in zip(numbers, scales, strict=True))


@lru_cache(maxsize=1)
def bonded_laws() -> dict[tuple[BondedKind, str], BondedLaw]:
    """Return all bonded laws of the compiled core by kind and key; a restraint key has its own entry."""
    laws = {}
    for row in _core.bonded_laws():
        law = BondedLaw(
            kind=row["kind"],
            key=row["key"],
            restraint_key=row["restraint_key"],
            description=row["description"],
            parameter_names=tuple(row["parameter_names"]),
            energy_mask=row["energy_mask"],
            degree_mask=row["degree_mask"],
            optional=row["optional"],
            table=row["table"],
        )
        laws[law.kind, law.key] = law
        if law.restraint_key:
            laws[law.kind, law.restraint_key] = law
    return laws


@dataclass(frozen=True)
class BondedEntry:
    """One understood line: its law, its numbers in internal units, and a dihedral's 1-4 factors.

    ``restraint``: the beads keep their pair forces. ``factors``: of the 1-4 pair's electrostatics and pair law.
    """

    law: BondedLaw
    parameters: tuple[float, ...]
    restraint: bool
    factors: tuple[float, float] = (0.0, 0.0)


def read_bonded(kind: BondedKind, line: BondedLine, field: Field, factor: float) -> BondedEntry:
    """Tell a line's law, numbers and 1-4 factors.

    Args:
        kind: what the line's block holds.
        line: the line as FIELD has it.
        field: the file, for messages.
        factor: FIELD's energy unit in internal units.

    Raises:
        SceneError: too few or too many numbers, or numbers that the law refuses.
    """
    law = bonded_laws()[kind, line.key]  # the reader knows no other keys
    numbers, factors = line.parameters, (0.0, 0.0)
    if kind == "dihedral":
        given = (*numbers[_FACTORS], 0.0, 0.0)
        numbers, factors = numbers[: _FACTORS.start] + numbers[_FACTORS.stop :], (given[0], given[1])
    names, count = " ".join(law.parameter_names), len(law.parameter_names)
    if len(numbers) < count - law.optional:
        where = ", with the two 1-4 factors as numbers 4 and 5" if kind == "dihedral" and count > 3 else ""
        message = f"the {kind} law {law.key} needs {count} numbers ({names}){where}, found {len(line.parameters)}"
        raise refusal(line, field, message)
    if any(numbers[count:]) or not all(math.isfinite(x) for x in factors):
        extra = next((x for x in numbers[count:] if x), math.nan)
        takes = names or "its numbers from a file of tables"
        message = f"the number {extra:g} has no meaning: the {kind} law {law.key} takes {takes}"
        raise refusal(line, field, message if any(numbers[count:]) else "the 1-4 factors must be finite")
    numbers = (*numbers, *(0.0,) * law.optional)[:count]
    parameters = law.internal(numbers, factor)
    try:
        if not law.table:
            check_parameters(kind, law.key, parameters)
    except ValueError as error:
        raise refusal(line, field, str(error)) from None
    return BondedEntry(law, parameters, line.key != law.key or kind == "tether", factors)


@lru_cache(maxsize=4096)
def check_parameters(kind: BondedKind, key: str, parameters: tuple[float, ...]) -> None:
    """Raise ValueError, naming the number, when the law cannot take these."""
    _core.evaluate_bonded(kind, key, list(parameters), np.empty((0, 3 if kind == "angle" else 1)))


def refusal(line: BondedLine, field: Field, message: str) -> SceneError:
    """Return the error that names the file, the line and the key."""
    return SceneError(message, path=field.path, line=line.line or None, word=line.key)
