"""Temperatures against the timestep: every integrator against an independent program's averages of the same fluid.

DPD water, 1536 beads in 8³, γ = 4.5, k_B T = 1. The reference ran for 40 units of time; its standard errors are about
0.004, ours about the same. Two means of the same scheme differ by more than 0.02 once in 2000 pairs. At Δt = 0.06 the
bounds of the configurational temperature are wider: it changes by a per cent there when Δt changes by 0.3 %.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

TOLERANCE = 0.02

# Rows of docs/timesteps.py; kinetic and configurational temperature at Δt = 0.04 and 0.06, A = 25.
WATER = {
    "mdvv": ((1.029, 1.058), (1.057, 1.136)),
    "mdvv, λ 0.65": ((1.003, 1.030), (1.016, 1.097)),
    "dpdvv": ((1.007, 1.054), (1.019, 1.130)),
    "scvv": ((0.981, 1.041), (0.995, 1.124)),
    "first": ((1.008, 1.045), (1.028, 1.121)),
    "second": ((1.013, 1.050), (1.026, 1.121)),
    "ou": ((1.012, 1.056), (1.025, 1.126)),
    "peters": ((1.005, 1.044), (1.021, 1.123)),
    "peters-first": ((1.005, 1.043), (1.023, 1.121)),
    "lowe-andersen": ((1.003, 1.059), (1.008, 1.152)),
    "ou-middle": ((0.998, 1.008), (0.992, 1.029)),
    # The same averages for schemes without a reference of their own: those of the scheme they approximate.
    "middle": ((0.998, 1.008), (0.992, 1.029)),
    "middle, 2 passes": ((0.998, 1.012), (0.995, 1.029)),
    "zeroth": ((1.008, 1.045), (1.028, 1.121)),
}
# Kinetic temperature of the ideal gas at Δt = 0.04 and 0.10.
GAS = {
    "mdvv": (1.037, 1.115),
    "mdvv, λ 0.65": (1.014, 1.085),
    "dpdvv": (0.994, 0.993),
    "scvv": (0.963, 0.924),
    **dict.fromkeys(
        ("zeroth", "first", "second", "ou", "peters", "peters-first", "lowe-andersen", "stoyanov-groot", "ou-middle"),
        (1.0, 1.0),
    ),
}


def script() -> ModuleType:
    """``docs/timesteps.py`` as a module."""
    path = Path(__file__).resolve().parents[2] / "docs" / "timesteps.py"
    spec = importlib.util.spec_from_file_location("docs_timesteps", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["docs_timesteps"] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.parametrize("row", WATER)
@pytest.mark.parametrize("column", [0, 1], ids=["0.04", "0.06"])
def test_temperatures_of_water(row: str, column: int) -> None:
    cell = script().measure(row, (0.04, 0.06)[column], 25.0, seed=11)
    kinetic, configurational = WATER[row][column]
    assert cell.kinetic == pytest.approx(kinetic, abs=TOLERANCE)
    assert cell.configurational == pytest.approx(configurational, abs=TOLERANCE * (1.0 + column))
    # Long simulations on two machines give 4.546 ± 0.001 and 23.654 ± 0.002 at short steps.
    assert cell.pressure == pytest.approx(23.65, abs=0.1)


@pytest.mark.slow
def test_a_thermostat_step_every_fourth_step() -> None:
    cell = script().measure("middle, every 4", 0.04, 25.0, seed=11)
    assert cell.kinetic == pytest.approx(0.998, abs=TOLERANCE)
    assert cell.configurational == pytest.approx(1.012, abs=TOLERANCE)


@pytest.mark.slow
@pytest.mark.parametrize("row", GAS)
@pytest.mark.parametrize("column", [0, 1], ids=["0.04", "0.10"])
def test_temperature_of_the_ideal_gas(row: str, column: int) -> None:
    cell = script().measure(row, (0.04, 0.10)[column], 0.0, seed=12)
    assert cell.kinetic == pytest.approx(GAS[row][column], abs=TOLERANCE)
