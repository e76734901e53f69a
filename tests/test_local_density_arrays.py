"""Local densities of many-body DPD as arrays: of the simulation, its state, ASE, callbacks and profiles."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import Simulation
from pydlpoly.ase import atoms_from_state
from pydlpoly.callbacks import Moment
from pydlpoly.reporters import BinReporter
from pydlpoly.scene.bins import available_quantities, unit_of

from .scene_builder import make_scene

WARREN = ("A A mdpd -40.0 25.0 1.0 0.75 4.5",)


def test_local_densities_by_hand_and_in_every_place() -> None:
    """W(r) = 15/(2π r_d³)(1 − r/r_d)², over all images, as Warren (2003) has it."""
    scene = make_scene({"A": 250}, WARREN, cell=3.5)
    simulation = Simulation(scene, seed=1, threads=1)
    found: list[Moment] = []
    simulation.add_callback(found.append, every=5)
    reporter = BinReporter(simulation, axes=("z",), bins=(1,), every=5, quantities=("local_density",))
    simulation.reporters.append(reporter)
    simulation.run(5)
    state = simulation.state
    apart = state.positions[:, None] - state.positions
    apart -= 3.5 * np.rint(apart / 3.5)
    r = np.linalg.norm(apart, axis=2)
    weights = np.where(r < 0.75, 15.0 / (2.0 * np.pi * 0.75**3) * (1.0 - r / 0.75) ** 2, 0.0)
    np.fill_diagonal(weights, 0.0)
    expected = weights.sum(axis=1)
    np.testing.assert_allclose(simulation.bead_arrays()["density"], expected, rtol=1e-9)
    moment = found[0]
    assert moment.density is not None
    for values in (state.density, moment.density, moment["density"], atoms_from_state(scene, state).arrays["density"]):
        np.testing.assert_allclose(values, expected, rtol=1e-9)
    assert reporter.table()["local_density"][0] == pytest.approx(expected.mean(), rel=1e-9)
    assert available_quantities(scene)[-1] == "local_density"


@pytest.mark.slow
def test_a_slab_has_the_density_of_the_liquid_in_its_middle() -> None:
    """Warren's liquid at A = −40, B = 25, r_d = 0.75 has the density 6.08 ± 0.06; a thin slab is near it.

    It starts as a lattice of this density: a random start would evaporate first, and condense anywhere.
    """
    steps = [(np.arange(count) + 0.5) / count - 0.5 for count in (8, 8, 10)]
    places = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3) * [4.0, 4.0, 6.5]
    places += 0.05 * np.random.default_rng(1).normal(size=places.shape)
    scene = make_scene({"A": 640}, WARREN, cell=[4.0, 4.0, 14.0], positions=places)
    simulation = Simulation(scene, seed=1, threads=2)
    simulation.run(500)
    reporter = BinReporter(simulation, axes=("z",), bins=(28,), every=10)
    simulation.reporters.append(reporter)
    simulation.run(1500)
    table = reporter.table()
    middle = np.abs(table.centres[0]) < 1.8
    assert table["number_density"][middle].mean() == pytest.approx(6.08, abs=0.3)
    assert table["number_density"][np.abs(table.centres[0]) > 5.0].max() < 0.02
    assert table["local_density"][middle].min() > 2.0  # beads keep apart: less than the density around them
    assert np.nanmean(table["kinetic_temperature"][middle]) == pytest.approx(1.0, abs=0.05)


def test_the_unit_is_that_of_the_form() -> None:
    control = {"temperature": "300 K", "timestep": "0.001 ps"}
    for law, unit in (("mdpd -40 25 1 0.75 4.5", "1/ang^3"), ("mdpd -40 1.6 2 2 1 0.75 4.5", "")):
        scene = make_scene({"A": 30}, (f"A A {law}",), cell=3.5, units="kj", control=control)
        assert unit_of("local_density", scene) == unit
