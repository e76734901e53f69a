"""What an engine observed in one step, in internal units."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True)
class Totals:
    """What the core observed in one step.

    Attributes:
        pair_energy: pair energy with the long-range correction, internal energy.
        conservative, drag, noise, kinetic: (3, 3) sums Σ F_a r_b over pairs (long-range correction in the first) and
            Σ m v_a v_b over beads, internal energy; the stress of each part is this over the volume.
        momentum: (3,) total momentum, Da Å/ps.
        constraint: (3, 3) Σ F_a r_b of the forces that keep the lengths of constraints.
        field_energy: of external fields that have one, internal energy.
        charge_energy: of the electrostatics; ``charge``: (3, 3) its Σ F_a r_b.
        internal_energy: Σ C_v T of beads that carry heat. ``heat_balance``: what makes its sum with potential and
            kinetic energy a constant: less what sources and beads of held temperature gave, and what drag and noise
            do in half kicks that internal energies were already charged for.
        bonded_energies: (5,) of bonds, angles, dihedrals, inversions, tethers; ``bonded``: (5, 3, 3) their Σ F_a r_b.
    """

    pair_energy: float
    conservative: FloatArray
    drag: FloatArray
    noise: FloatArray
    kinetic: FloatArray
    momentum: FloatArray
    volume: float
    bonded_energies: FloatArray
    bonded: FloatArray
    charge_energy: float
    charge: FloatArray
    thermostat_energy: float = 0.0
    constraint: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))
    field_energy: float = 0.0
    internal_energy: float = 0.0
    heat_balance: float = 0.0
