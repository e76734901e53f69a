"""The columns of STATIS: their names, numbers, labels and what they measure, in DL_POLY 5's order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

UnitKind = Literal["energy", "temperature", "virial", "volume", "angle", "pressure"]


@dataclass(frozen=True)
class Quantity:
    """One column of STATIS: its attribute name, its number counted from 1, DL_POLY's label, and what it measures."""

    name: str
    index: int
    label: str
    unit: UnitKind


_COLUMNS: tuple[tuple[str, str, UnitKind], ...] = (
    ("extended_energy", "Total Extended System Energy", "energy"),
    ("temperature", "System Temperature", "temperature"),
    ("configurational_energy", "Configurational Energy", "energy"),
    ("short_range_energy", "Short Range Potential Energy", "energy"),
    ("electrostatic_energy", "Electrostatic Energy", "energy"),
    ("bond_energy", "Chemical Bond Energy", "energy"),
    ("angle_energy", "Valence Angle And 3-Body Potential Energy", "energy"),
    ("dihedral_energy", "Dihedral Inversion And 4-Body Potential Energy", "energy"),
    ("tether_energy", "Tethering Energy", "energy"),
    ("enthalpy", "Enthalpy (Total Energy + Pv)", "energy"),
    ("rotational_temperature", "Rotational Temperature", "temperature"),
    ("virial", "Total Virial", "virial"),
    ("short_range_virial", "Short-Range Virial", "virial"),
    ("electrostatic_virial", "Electrostatic Virial", "virial"),
    ("bond_virial", "Bond Virial", "virial"),
    ("angle_virial", "Valence Angle And 3-Body Virial", "virial"),
    ("constraint_virial", "Constraint Bond Virial", "virial"),
    ("tether_virial", "Tethering Virial", "virial"),
    ("volume", "Volume", "volume"),
    ("shell_temperature", "Core-Shell Temperature", "temperature"),
    ("shell_energy", "Core-Shell Potential Energy", "energy"),
    ("shell_virial", "Core-Shell Virial", "virial"),
    ("cell_alpha", "Md Cell Angle Α", "angle"),
    ("cell_beta", "Md Cell Angle Β", "angle"),
    ("cell_gamma", "Md Cell Angle Gamma", "angle"),
    ("pmf_virial", "Pmf Constraint Virial", "virial"),
    ("pressure", "Pressure", "pressure"),
    ("conserved_term", "External Degree Of Freedom", "energy"),
    ("stress_xx", "stress xx", "pressure"),
    ("stress_xy", "stress xy", "pressure"),
    ("stress_xz", "stress xz", "pressure"),
    ("stress_yx", "stress yx", "pressure"),
    ("stress_yy", "stress yy", "pressure"),
    ("stress_yz", "stress yz", "pressure"),
    ("stress_zx", "stress zx", "pressure"),
    ("stress_zy", "stress zy", "pressure"),
    ("stress_zz", "stress zz", "pressure"),
)

STATISTICS_NAMES: tuple[Quantity, ...] = tuple(
    Quantity(name, index, label, unit) for index, (name, label, unit) in enumerate(_COLUMNS, 1)
)
"""The 37 columns that every STATIS file of DL_POLY 5 begins with, in order."""

SCALAR_NAMES: tuple[str, ...] = tuple(q.name for q in STATISTICS_NAMES[:28])
"""The first 28 columns: everything before the stress tensor."""
_CELL = (*(f"cell_{vector}{axis}" for vector in "abc" for axis in "xyz"), "pressure_volume")
_AREA = ("cell_height", "cell_area")
_TENSION = ("tension_x", "tension_y")
VARIABLE_CELL_NAMES: dict[int, tuple[str, ...]] = {
    0: (),
    10: _CELL,
    12: (*_CELL, *_AREA),
    14: (*_CELL, *_AREA, *_TENSION),
}
"""Names of the columns that follow the species when the cell varies, by how many there are."""

VARIABLE_CELL_LABELS: dict[str, str] = {
    **{f"cell_{vector}{axis}": f"cell {vector.upper()}{k}" for vector in "abc" for k, axis in enumerate("xyz", 1)},
    "pressure_volume": "pV",
    "cell_height": "h_z",
    "cell_area": "A_z",
    "tension_x": "gamma_x",
    "tension_y": "gamma_y",
}
"""DL_POLY's labels of these columns in the YAML form, by name."""
