"""The electrolyte of González-Melchor and others (J. Chem. Phys. 125, 224107 (2006)): 0.6 molar salt in DPD water.

Targets are those of a LAMMPS run of the same state (dpd/coul/slater/long, 3000 beads, 2500 steps): an electrostatic
energy of −0.318 k_B T an ion and g(r) of opposite ions; its noise is ± 0.03.
"""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import Scene
from pydlpoly.formats.rdfdat import normalise_rdf
from pydlpoly.formats.records import FloatArray

from ..scene_builder import make_scene
from .averages import Averages, equilibrated, sample

EDGE, BIN, IONS = 10.0, 0.1, 98
PAIRS = [f"{a} {b} dpd 25.0 1.0 4.5" for k, a in enumerate("WPM") for b in "WPM"[k:]]
OPPOSITE = {1: 0.028, 2: 0.136, 3: 0.325, 4: 0.598, 5: 0.99, 6: 1.18, 7: 1.39, 8: 1.38, 9: 1.34, 11: 1.16, 20: 1.02}


def electrolyte() -> Scene:
    return make_scene(
        {"W": 3000 - 2 * IONS, "P": IONS, "M": IONS},
        PAIRS,
        cell=EDGE,
        charges={"P": 1.0, "M": -1.0},
        control={
            "timestep": "0.02 internal_t",
            "cutoff": "3.0 ang",
            "coul_method": "spme",
            "coul_coupling": "13.87",
            "spme_precision": "1e-4",
            "charge_smearing_method": "slater",
            "charge_smearing_beta": "0.929",
            "rdf_calculate": "on",
            "rdf_frequency": "10 steps",
            "rdf_binsize": f"{BIN} ang",
        },
    )


def opposite(counts: FloatArray, samples: int) -> FloatArray:
    _, g, _ = normalise_rdf(
        counts,
        like=False,
        volume=EDGE**3,
        beads=(IONS, IONS),
        configurations=samples,
        bin_width=BIN,
    )
    return np.asarray(g)


@pytest.fixture(scope="module")
def run() -> tuple[Averages, FloatArray, FloatArray]:
    """500 steps to equilibrate and 6000 (120 τ) to average."""
    simulation = equilibrated(electrolyte(), seed=3, steps=500)
    before, samples_before = simulation.distance_counts()
    charge = []
    for _ in range(300):
        simulation.run(20)
        charge.append(simulation.energy["charge"])
    after, samples = simulation.distance_counts()
    g = opposite(after[1, 2] - before[1, 2], samples - samples_before)
    return sample(simulation, 200, 10), np.array(charge), g


@pytest.mark.slow
def test_electrostatic_energy(run: tuple[Averages, FloatArray, FloatArray]) -> None:
    # A sample scatters by 0.03 an ion; 120 τ hold about 100 independent ones: ± 0.004, and LAMMPS's as much.
    energy = run[1] / (2 * IONS)
    assert energy.mean() == pytest.approx(-0.318, abs=0.02)
    assert run[0].temperature == pytest.approx(1.01, abs=0.02)


@pytest.mark.slow
def test_no_spike_of_ion_pairs(run: tuple[Averages, FloatArray, FloatArray]) -> None:
    g = run[2]
    for place, expected in OPPOSITE.items():
        assert g[place] == pytest.approx(expected, abs=0.12), place
    assert g[:6].max() < 1.1  # nothing gathers at contact
