"""What LAMMPS reports in a step, as columns of its thermodynamic output, and the totals they make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pydlpoly.formats.records import FloatArray

_COMPONENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # of LAMMPS's symmetric tensors
_KINDS = ("bond", "angle", "dihedral")
_ENERGIES = {"bond": "ebond", "angle": "eangle", "dihedral": "edihed"}
_NAMES = {"evdwl": "E_vdwl", "ecoul": "E_coul", "elong": "E_long", "vol": "Volume", "step": "Step"}
_NAMES |= {"ebond": "E_bond", "eangle": "E_angle", "edihed": "E_dihed"}


@dataclass(frozen=True)
class Observed:
    """Which parts of the virial there are.

    Attributes:
        drag: sub-style of drag and noise; ``charge``: of electrostatics; empty without them.
        reciprocal: whether there is a sum over reciprocal vectors.
        kinds: kinds of bonded terms.
        thermostat: fix whose scalar is the thermostat's energy, empty without one.
        drag_is_rest: sub-styles of the pair laws, of which the virial of drag and noise is the rest; LAMMPS has no
            virial of one of several sub-styles of a name.
        many_body: sub-style whose energy is none.
        supplies: variables of what sources give, see ``carried``.
        lumped: drag and noise are in the virial of the pair laws and cannot be told from them.
    """

    drag: str
    charge: str
    reciprocal: bool
    kinds: tuple[str, ...]
    thermostat: str
    drag_is_rest: tuple[str, ...] | None = None
    many_body: str = ""
    supplies: tuple[str, ...] = ()
    lumped: bool = False

    def commands(self) -> list[str]:
        """Return the commands that define what is reported and in which columns."""
        pressures = {"pair": "pair"}
        if self.drag:
            pressures["drag"] = f"pair/hybrid {self.drag}"
        if self.charge:
            pressures["charge"] = f"pair/hybrid {self.charge}"
        if self.reciprocal:
            pressures["long"] = "kspace"
        pressures |= {kind: kind for kind in self.kinds}
        pressures |= {f"law{k}": f"pair/hybrid {name}" for k, name in enumerate(self.drag_is_rest or ())}
        lines = [f"compute p_{name} all pressure NULL {words}" for name, words in pressures.items()]
        lines += [f"variable momentum_{axis} equal vcm(all,{axis})*mass(all)" for axis in "xyz"]
        if self.many_body:
            lines.append(f"compute many_body all pair {self.many_body} evdwl")
        columns = ["step", "vol", "pe", "evdwl", "ecoul", "elong", *(_ENERGIES[kind] for kind in self.kinds)]
        columns += [f"c_p_{name}[{k}]" for name in pressures for k in range(1, 7)]
        columns += [f"c_moving[{k}]" for k in range(1, 7)]
        columns += [f"v_momentum_{axis}" for axis in "xyz"]
        columns += [f"f_{self.thermostat}"] if self.thermostat else []
        columns += ["c_many_body"] if self.many_body else []
        columns += [f"v_{name}" for name in self.supplies] + self._means()
        return [*lines, f"thermo_style custom {' '.join(columns)}", "thermo_modify norm no"]

    def _means(self) -> list[str]:
        several = len(self.supplies) > 1
        return [f"f_supplied[{k}]" if several else "f_supplied" for k in range(1, len(self.supplies) + 1)]

    def supplied(self, first: Mapping[str, float], seen: Mapping[str, float], timestep: float) -> dict[str, float]:
        """Return what sources gave from the first row of thermodynamic output to another, by variable.

        LAMMPS's steps take half of a rate before and half after the forces: the sum is that of trapezia.
        """
        steps = seen[_NAMES["step"]] - first[_NAMES["step"]]
        totals = {}
        for name, mean in zip(self.supplies, self._means(), strict=True):
            ends = 0.5 * (first[f"v_{name}"] + seen[f"v_{name}"])
            totals[name] = timestep * (seen[mean] * (steps + 1.0) - ends)
        return totals

    def parts(self, seen: Mapping[str, float]) -> dict[str, FloatArray | float]:
        """Return energies and tensors Σ F_a r_b by part, internal units, from a row of thermodynamic output."""
        volume = seen[_NAMES["vol"]]
        charge = _tensor(seen, "c_p_charge") if self.charge else np.zeros((3, 3))
        long = _tensor(seen, "c_p_long") if self.reciprocal else np.zeros((3, 3))
        drag = _tensor(seen, "c_p_drag") if self.drag else np.zeros((3, 3))
        pair = _tensor(seen, "c_p_pair")
        if self.drag_is_rest is not None:
            laws = [_tensor(seen, f"c_p_law{k}") for k in range(len(self.drag_is_rest))]
            drag = pair - charge - np.sum([np.zeros((3, 3)), *laws], axis=0)
        bonded = [_tensor(seen, f"c_p_{kind}") if kind in self.kinds else np.zeros((3, 3)) for kind in _KINDS]
        energies = [seen[_NAMES[_ENERGIES[kind]]] if kind in self.kinds else 0.0 for kind in _KINDS]
        return {
            "pair_energy": seen[_NAMES["evdwl"]] - (seen["c_many_body"] if self.many_body else 0.0),
            "charge_energy": seen[_NAMES["ecoul"]] + seen[_NAMES["elong"]],
            "conservative": (pair - charge - drag) * volume,
            "drag": drag * volume,
            "charge": (charge + long) * volume,
            "bonded": np.array([*bonded, np.zeros((3, 3)), np.zeros((3, 3))]) * volume,
            "bonded_energies": np.array([*energies, 0.0, 0.0]),
            "kinetic": _tensor(seen, "c_moving"),
            "momentum": np.array([seen[f"v_momentum_{axis}"] for axis in "xyz"]),
            "thermostat_energy": seen[f"f_{self.thermostat}"] if self.thermostat else 0.0,
            "volume": volume,
        }


def _tensor(seen: Mapping[str, float], name: str) -> FloatArray:
    tensor = np.zeros((3, 3))
    for k, (a, b) in enumerate(_COMPONENTS, 1):
        tensor[a, b] = tensor[b, a] = seen[f"{name}[{k}]"]
    return tensor
