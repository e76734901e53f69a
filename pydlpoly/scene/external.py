"""External fields: the line after FIELD's ``extern`` in internal units, and where each field makes sense."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pydlpoly.errors import SceneError
from pydlpoly.formats.records import ExternalLine, Field
from pydlpoly.scene.beads import Layout
from pydlpoly.scene.model import Dynamics, ExternalTerm
from pydlpoly.scene.settings import Notes, Settings, place
from pydlpoly.units import EnergyUnit

VOLT_PER_ANGSTROM = 1.0 / 1.037837512e-4
"""Da Å/(ps² e): DL_POLY's constant, 0.14 % below the 9648.53 that an electron volt is elsewhere."""

TESLA = 1.0 / 1.037837512e4
"""Da/(ps e), from the same constant of DL_POLY."""

ON_CHARGES = ("elec", "magn", "osel")
"""Fields that act on charges alone."""

WITH_FLIGHTS = ("nve", "mdvv", "zeroth", "first", "second", "peters", "peters-first", "lowe-andersen",
                "stoyanov-groot", "ou", "ou-middle", "middle", "langevin")  # fmt: skip
"""Integrators whose drift follows any path between two kicks: helices in a magnetic field, or up to a wall and back."""


def unfit_for_flight(dynamics: Dynamics, what: str) -> tuple[str, str] | None:
    """Return the keyword and the reason where a drift along such paths does not fit the integrator, else None."""
    if dynamics.integrator not in WITH_FLIGHTS:
        names = ", ".join(WITH_FLIGHTS)
        return "ensemble_dpd_order", f"{dynamics.integrator} is not modelled with {what}; these are: {names}"
    if dynamics.integrator == "mdvv" and dynamics.prediction != 0.5:
        return "ensemble_dpd_lambda", f"{what}: lambda 0.5 only, because velocities turn within the drift"
    return None


@dataclass(frozen=True)
class _Kind:
    """One field: names of its numbers, how many of the first are scaled, by what, and the cells it goes with."""

    names: str
    scaled: int
    factor: Callable[[EnergyUnit], float]
    shapes: tuple[int, ...] = ()  # of imcon; empty: all
    cell: str = ""


def _energy(unit: EnergyUnit) -> float:
    return unit.factor


def _volt(unit: EnergyUnit) -> float:
    return 1.0 if unit.reduced else VOLT_PER_ANGSTROM


def _tesla(unit: EnergyUnit) -> float:
    return 1.0 if unit.reduced else TESLA


_ORTHORHOMBIC = "a cubic or orthorhombic cell (imcon 1 or 2)"
_KINDS = {
    "grav": _Kind("Gx Gy Gz", 3, _energy),
    "oshr": _Kind("A n", 1, _energy, (1, 2), f"oscillating shear needs {_ORTHORHOMBIC}"),
    "elec": _Kind("Ex Ey Ez", 3, _volt),
    "osel": _Kind("Ex Ey Ez f", 3, _volt),
    "magn": _Kind("Hx Hy Hz", 3, _tesla),
    "shrx": _Kind("A z0", 0, _energy, (6,), "shear by moving slabs needs a slab (imcon 6)"),
    "sphr": _Kind("A R0 n Rcut", 1, _energy),
    "zbnd": _Kind("A z0 f", 1, _energy),
    "pois": _Kind("g", 1, _energy, (1, 2), f"periodic Poiseuille flow needs {_ORTHORHOMBIC}"),
}


def resolve_external(
    field: Field,
    units: EnergyUnit,
    imcon: int,
    layout: Layout,
    dynamics: Dynamics,
    settings: Settings,
    notes: Notes,
) -> tuple[ExternalTerm, ...]:
    """Return the external fields in internal units.

    Args:
        field: FIELD with its ``extern`` line.
        units: FIELD's energy unit; with reduced units electric and magnetic fields are reduced, too: F = q E, q v × H.
        imcon: shape of the cell.
        layout: the beads, for their charges.
        dynamics: the integrator, which a magnetic field has to fit.
        settings: CONTROL, for the place of messages about the integrator.
        notes: receives oddities and fields without effect.

    Raises:
        SceneError: a field that is not modelled, wrong numbers, or another cell or integrator than it needs.
    """
    terms = []
    for line in field.externals:
        term = _term(line, field, units, imcon, notes)
        if term.key == "magn":
            _check_integrator(dynamics, settings)
        if term.key in ON_CHARGES and not np.any(layout.charge[~layout.frozen]):
            notes.ignored(f"{term.key} has no effect: no bead that moves is charged", place(field.path, line.line))
            continue
        terms.append(term)
    return tuple(terms)


def _term(line: ExternalLine, field: Field, units: EnergyUnit, imcon: int, notes: Notes) -> ExternalTerm:
    def refusal(message: str) -> SceneError:
        return SceneError(message, path=field.path, line=line.line or None, word=line.key)

    kind = _KINDS.get(line.key)
    if kind is None:
        raise refusal(f"this external field is not modelled; {', '.join(sorted(_KINDS))} are")
    count, numbers = len(kind.names.split()), line.parameters
    if len(numbers) < count or any(numbers[count:]):
        found = "number" if count == 1 else "numbers"
        raise refusal(f"takes {count} {found} ({kind.names}), found {len(numbers)}")
    numbers = numbers[:count]
    if not all(math.isfinite(x) for x in numbers):
        raise refusal("all numbers of an external field must be finite")
    if kind.shapes and imcon not in kind.shapes:
        raise refusal(f"{kind.cell}, not imcon {imcon}")
    where = place(field.path, line.line)
    if line.key == "oshr" and not numbers[1].is_integer():
        notes.warning(
            f"oshr with n = {numbers[1]:g}: the force jumps at the cell's face unless n is a whole number", where
        )
    if line.key == "zbnd" and imcon not in (0, 6):
        text = (
            "zbnd in a cell that is periodic along z: a bead that crosses the face is far beyond z0 on the other side"
        )
        notes.warning(text, where)
    if line.key == "sphr":
        if not (numbers[2] > 0.0 and 0.0 <= numbers[3] < numbers[1]):
            raise refusal("needs n above 0 and Rcut from 0 to below R0")
        text = "sphr: the force is the slope of the energy A (R0 - r)^-n; DL_POLY 5.2 has a force that is not"
        notes.choice(text, where)
    factor = kind.factor(units)
    scaled = (*(factor * x for x in numbers[: kind.scaled]), *numbers[kind.scaled :])
    return ExternalTerm(line.key, scaled, where)


def _check_integrator(dynamics: Dynamics, settings: Settings) -> None:
    unfit = unfit_for_flight(dynamics, "the field magn")
    if unfit is not None:
        keyword = unfit[0] if settings.given(unfit[0]) else "ensemble_method"
        raise settings.refusal(keyword, unfit[1])
