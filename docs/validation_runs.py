"""The runs behind docs/validation.py: each function measures some rows and returns their values with standard errors.

Scenes and measuring functions are those of the tests where these have them, with longer runs where that makes the error
smaller than the published one.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from pydlpoly import Simulation, load, single_point
from pydlpoly.analysis import MeanSquareDisplacement, RadialDistribution, analyse, frames_of_arrays
from pydlpoly.bench.scenes import cube, dissolved_species, single_beads
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray
from pydlpoly.reporters import StressProfile
from pydlpoly.scene.model import Scene

ROOT = Path(__file__).resolve().parents[1]
sys.path.append(str(ROOT))  # last: an installed pydlpoly goes before the source folder

from tests.physics import (  # noqa: E402
    test_dl_meso,
    test_electrolyte,
    test_flow,
    test_heat,
    test_many_body,
    test_phase_separation,
    test_transport,
)
from tests.test_charge_laws import BETA, BJERRUM, TABLE_R, evaluate  # noqa: E402
from tests.test_charges import rock_salt  # noqa: E402

Found = dict[str, tuple[float, float]]
"""Value and standard error by the key of a row."""


def fluid(
    strength: float,
    *,
    beads: int = 3000,
    density: float = 3.0,
    thermal_energy: float = 1.0,
    drag: float = 4.5,
    timestep: float = 0.01,
    order: str = "middle",
) -> Scene:
    """Return a DPD fluid of one species with r_c = 1."""
    control = {
        "ensemble_dpd_order": order,
        "timestep": f"{timestep} dpd_t",
        "temperature": f"{thermal_energy!r} dpd_temp",
    }
    pairs = {("W", "W"): ("dpd", strength, 1.0, drag)}
    return single_beads("fluid", {"W": beads}, pairs, cube(beads, density), control=control)


def block_mean(values: list[float] | FloatArray, blocks: int = 20) -> tuple[float, float]:
    """Return the mean of a series and its standard error from the means of blocks."""
    means = np.array([block.mean() for block in np.array_split(np.asarray(values, dtype=np.float64), blocks)])
    return float(np.mean(values)), float(means.std(ddof=1) / np.sqrt(blocks))


def pressure_of(simulation: Simulation, thermal_energy: float) -> float:
    """Return ρ k_B T of the thermostat's T and the conservative virial."""
    seen = simulation.observe()
    conservative = float(np.trace(seen.stress_parts["conservative"])) / 3.0
    return simulation.scene.bead_count / seen.volume * thermal_energy + conservative


def frames(simulation: Simulation, steps: int, every: int) -> Iterator[Frame]:
    """Run, and return a frame every so many steps."""
    scene = simulation.scene
    names = [scene.species[k] for k in scene.beads.species]
    for _ in range(steps // every):
        simulation.run(every)
        state = simulation.state
        yield from frames_of_arrays(state.unwrapped, scene.cell, species=names, times=[simulation.time])


# -- Water ------------------------------------------------------------------------------------------------------------

GHOSTS = (10.0, 15.0, 20.0, 25.0, 27.0, 29.0, 31.0, 35.0, 40.0)
INSERTIONS = 20000


def water() -> Found:
    """Pressure, energy, g(r) and, by Widom's insertions, chemical potentials: 400 τ of 3000 beads."""
    simulation = Simulation(fluid(25.0), seed=41, threads=1)
    simulation.run(2000)
    generator = np.random.default_rng(42)
    rdf = RadialDistribution(bin_width=0.05, reach=1.5)
    pressure, energy, weights = [], [], []
    for frame in frames(simulation, 40000, 100):
        pressure.append(pressure_of(simulation, 1.0))
        energy.append(simulation.energy["pair"] / simulation.scene.bead_count)
        analyse([frame], rdf)
        weights.append(insertion_weights(frame.positions, simulation.scene.cell[0, 0], generator))
    peak = int(np.argmax(rdf.result().g[0]))
    found = {
        "pressure": block_mean(pressure),
        "energy": block_mean(energy),
        "energy-density": tuple(3.0 * number for number in block_mean(energy)),
        "rdf-peak": (float(rdf.result().g[0, peak]), float(rdf.result().error[0, peak])),
        "rdf-place": (float(rdf.result().r[peak]), 0.025),
    }
    return found | chemical_potentials(np.array(weights))  # type: ignore[return-value]  # tuple of two


def insertion_weights(positions: FloatArray, edge: float, generator: np.random.Generator) -> FloatArray:
    """Return ⟨exp(−ΔU)⟩ over random places for ghosts of every strength in ``GHOSTS``."""
    places = generator.random((INSERTIONS, 3)) * edge
    trees = cKDTree(places, boxsize=edge), cKDTree(np.mod(positions, edge) % edge, boxsize=edge)
    near = trees[0].sparse_distance_matrix(trees[1], 1.0, output_type="ndarray")
    overlap = np.bincount(near["i"], weights=0.5 * (1.0 - near["v"]) ** 2, minlength=INSERTIONS)
    return np.array([np.exp(-strength * overlap).mean() for strength in GHOSTS])


def chemical_potentials(weights: FloatArray) -> Found:
    """Return μ_ex of every ghost and the differences to that of the fluid's own beads; errors by jackknife."""
    blocks = np.array([block.mean(axis=0) for block in np.array_split(weights, 20)])
    count = len(blocks)
    left_out = -np.log((blocks.sum(axis=0) - blocks) / (count - 1))
    whole = -np.log(blocks.mean(axis=0))
    own = GHOSTS.index(25.0)
    found: Found = {}
    for k, strength in enumerate(GHOSTS):
        spread = np.sqrt((count - 1) * left_out[:, k].var())
        found[f"mu-{strength:g}"] = (float(whole[k]), float(spread))
        apart = left_out[:, k] - left_out[:, own]
        found[f"transfer-{strength - 25:g}"] = (float(whole[k] - whole[own]), float(np.sqrt((count - 1) * apart.var())))
    return found


POINTS = {
    "at-0.5-3": (0.5, 3.0),
    "at-1-3": (1.0, 3.0),
    "at-1.5-3": (1.5, 3.0),
    "at-2-3": (2.0, 3.0),
    "at-1-2": (1.0, 2.0),
    "at-1-4": (1.0, 4.0),
    "at-1-5": (1.0, 5.0),
}


def equation_of_state() -> Found:
    """Pressures at A ρ/k_B T = 75, 50 τ of 3000 beads each, and at two other strengths."""
    found = {}
    for key, (thermal_energy, density) in POINTS.items():
        scene = fluid(75.0 * thermal_energy / density, density=density, thermal_energy=thermal_energy)
        found[key] = mean_pressure(scene, thermal_energy)
    found["pressure-15"] = mean_pressure(fluid(15.0), 1.0)
    found["pressure-78"] = mean_pressure(fluid(78.0), 1.0)
    return found


def mean_pressure(scene: Scene, thermal_energy: float) -> tuple[float, float]:
    """Return the pressure after 10 τ to equilibrate."""
    simulation = Simulation(scene, seed=43, threads=1)
    simulation.run(1000)
    values = []
    for _ in range(500):
        simulation.run(10)
        values.append(pressure_of(simulation, thermal_energy))
    return block_mean(values)


# -- Motion -----------------------------------------------------------------------------------------------------------


def diffusion() -> Found:
    """Self-diffusion from the slope of the mean-square displacement between 5 and 10 τ, 100 τ of 3000 beads each."""
    scenes = {
        "diffusion-25": fluid(25.0, timestep=0.02),
        "diffusion-15": fluid(15.0, timestep=0.02),
        "diffusion-78": fluid(78.0, timestep=0.01),
        "diffusion-lowe": fluid(25.0, drag=4.4, timestep=0.02, order="lowe-andersen"),
        "diffusion-bare": fluid(0.0, drag=6.75, timestep=0.02),
    }
    return {key: self_diffusion(scene) for key, scene in scenes.items()}


def self_diffusion(scene: Scene) -> tuple[float, float]:
    """Return the diffusion coefficient after 10 τ to equilibrate."""
    simulation = Simulation(scene, seed=44, threads=1)
    every = round(0.2 / scene.dynamics.timestep)
    simulation.run(50 * every)
    result = MeanSquareDisplacement(longest=10.0, fit=(5.0, 10.0)).of(frames(simulation, 500 * every, every))
    return float(result.diffusion[0]), float(result.diffusion_error[0])


def viscosity() -> Found:
    """Viscosity of DPD water by steady shear and by periodic Poiseuille flow, as in the tests."""
    shear = test_flow.by_shear()
    return {"viscosity-shear": shear[:2], "viscosity-poiseuille": test_flow.by_poiseuille_flow()}


def demixing() -> Found:
    """χ/Δa from two phases at three Δa, as in the test; the error is that of their mean."""
    found = []
    for excess in test_phase_separation.EXCESS:
        phi = test_phase_separation.coexisting(excess)
        found.append(float(np.log((1.0 - phi) / phi) / (1.0 - 2.0 * phi) / excess))
    chi = float(np.mean(found)), float(np.std(found, ddof=1) / np.sqrt(len(found)))
    return {"chi": chi, "tension": tension()}


def tension() -> tuple[float, float]:
    """Return the surface tension at a_AB = 40 from the stress in layers, 800 τ of 2400 beads."""
    edges = np.array([7.0, 7.0, 16.4])
    places = (np.random.default_rng(8).random((2400, 3)) - 0.5) * edges
    places = places[np.argsort(np.abs(places[:, 2]))]  # one species in the middle
    pairs = {
        pair: ("dpd", 40.0 if pair == ("A", "B") else 25.0, 1.0, 4.5) for pair in (("A", "A"), ("A", "B"), ("B", "B"))
    }
    control = {"ensemble_dpd_order": "middle", "timestep": "0.04 dpd_t"}
    scene = single_beads("two", {"A": 1200, "B": 1200}, pairs, np.diag(edges), positions=places, control=control)
    simulation = Simulation(scene, seed=9, threads=1)
    simulation.run(1000)
    profile = StressProfile(simulation, layers=41, every=10)
    simulation.reporters.append(profile)
    simulation.run(20000)
    found = profile.surface_tension()
    return float(found.value), float(found.error)


# -- Charges ----------------------------------------------------------------------------------------------------------


def charges() -> Found:
    """Lattice sums and energies of two smeared charges: no errors but those of rounding."""
    method = {"coul_method": "spme", "spme_kvec": "[ 48 48 48 ]", "spme_nsplines": "12"}
    found = {"madelung": (-single_point(rock_salt(method)).energy["charge"] / 32, 0.0)}
    for shape in ("slater", "slater-exact"):
        energy, _ = evaluate("pairwise", shape, TABLE_R, length=1 / BETA)
        for place in (0.0, 1.0):
            found[f"{shape}-{place:g}"] = (float(BJERRUM * energy[TABLE_R.index(place)]), 0.0)
    return found


def electrolyte() -> Found:
    """Electrostatic energy of an ion and g(r) of opposite ions, 240 τ of 3000 beads."""
    simulation = Simulation(test_electrolyte.electrolyte(), seed=45, threads=1)
    simulation.run(500)
    energy, rdf = [], RadialDistribution([("P", "M")], bin_width=0.1, reach=1.5)
    for frame in frames(simulation, 12000, 20):
        energy.append(simulation.energy["charge"] / (2 * test_electrolyte.IONS))
        analyse([frame], rdf)
    result = rdf.result()
    peak = int(np.argmax(result.g[0]))
    return {"ion-energy": block_mean(energy), "ion-peak": (float(result.g[0, peak]), float(result.error[0, peak]))}


# -- Lipids -----------------------------------------------------------------------------------------------------------


def lipids() -> Found:
    """Averages over steps 4000 to 6000 of DL_MESO's lipids, as in the test; DL_MESO gives fluctuations, not errors."""
    simulation = Simulation(load(ROOT.parent / "shared" / "inputs" / "dl_meso" / "lipid"), seed=11, threads=1)
    simulation.run(4000)
    found, _, _ = test_dl_meso.averages(simulation, 80, 25)
    return {f"lipid-{name}": (found[name], 0.0) for name in test_dl_meso.PUBLISHED}


# -- What beads carry -------------------------------------------------------------------------------------------------


SEEDS = (3, 4, 5, 6)


SEEDS = (3, 4, 5, 6)


def many_body() -> Found:
    """Slabs and bulk of the many-body liquid with both kernels, as in the tests; slabs are four runs of other noise."""
    found: Found = {}
    for kernel in ("warren", "lucy"):
        slabs = [test_many_body.slab(kernel, seed=seed) for seed in SEEDS]
        found[f"slab-{kernel}"] = block_mean([slab.density for slab in slabs], len(SEEDS))
        found[f"tension-{kernel}"] = block_mean([slab.tension for slab in slabs], len(SEEDS))
        for density in (6, 7, 8) if kernel == "warren" else (7, 8):
            found[f"{kernel}-{density}"] = test_many_body.bulk_pressure(kernel, density)
    return found


def carried() -> Found:
    """The hottest and coldest layers of LAMMPS's examples of pair styles edpd and tdpd, as in the tests.

    The exact profiles are odd about their middle; what the measured ones are not is their error.
    """
    options = "viscous_heating lammps", "repulsion scaled"
    layers, _ = test_heat.profile(test_heat.example("mdvv", *options, polynomials=test_heat.POLYNOMIALS))
    species, _ = test_transport.profiles(dissolved_species())
    found: Found = {}
    for name, row in {"edpd": layers, "tdpd-1": species[0], "tdpd-2": species[1]}.items():
        error = float(np.sqrt(np.mean((row + row[::-1] - 2.0) ** 2) / 2.0))
        found |= {f"{name}-max": (float(row.max()), error), f"{name}-min": (float(row.min()), error)}
    return found


GROUPS: dict[str, Callable[[], Found]] = {
    "water": water,
    "equation-of-state": equation_of_state,
    "diffusion": diffusion,
    "viscosity": viscosity,
    "demixing": demixing,
    "charges": charges,
    "electrolyte": electrolyte,
    "lipids": lipids,
    "many-body": many_body,
    "carried": carried,
}
"""What can be measured, by name."""
