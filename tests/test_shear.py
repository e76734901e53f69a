"""Lees–Edwards boundaries: free flight, forces and drag against a sum over images, energy balance, continuation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from pydlpoly import Scene, Simulation, single_point
from pydlpoly.errors import InputError
from pydlpoly.formats.records import FloatArray
from pydlpoly.reporters import configuration_of
from pydlpoly.tradeoff.candidates import candidates_for
from tests.molecule_builder import molecule_scene
from tests.scene_builder import NVE, make_scene, random_positions

SPLIT = ["zeroth", "first", "second", "peters", "peters-first", "lowe-andersen", "stoyanov-groot", "ou", "ou-middle"]
CHOOSING = ["lowe-andersen", "stoyanov-groot"]  # pairs get new velocities by chance
REPULSION = ("A A dpd 25.0 1.0",)


def sheared(rate: float, **more: str | None) -> dict[str, str | None]:
    return {"shear_rate": f"{rate} dpd_t^-1", **more}


def tilted(edges: ArrayLike, offset: float) -> FloatArray:
    cell = np.diag(np.asarray(edges, dtype=np.float64))
    cell[1, 0] = offset
    return cell


@pytest.mark.parametrize("rate", [0.7, -0.4])
def test_free_beads_fly_straight_through_moving_images(rate: float) -> None:
    """Unwrapped places go on along straight lines, over many crossings and jumps of the offset by an edge."""
    rng = np.random.default_rng(1)
    velocities = rng.normal(0.0, 2.0, (20, 3))
    edges = np.array([4.0, 5.0, 6.0])
    positions = random_positions(20, edges, 3)
    scene = make_scene(
        {"A": 20}, ("A A dpd 0.0 1.0",), cell=edges, positions=positions, velocities=velocities,
        control=NVE | sheared(rate, fixed_com="off"),
    )  # fmt: skip
    simulation = Simulation(scene, seed=1, threads=1)
    start = simulation.state.velocities
    for _ in range(6):
        simulation.run(357)
        state = simulation.state
        np.testing.assert_allclose(simulation.displacements(), start * simulation.time, rtol=0, atol=1e-9)
        moved = start[:, 0] - state.images[:, 1] * rate * edges[1]
        np.testing.assert_allclose(state.velocities[:, 0], moved, rtol=0, atol=1e-11)
        np.testing.assert_array_equal(state.velocities[:, 1:], start[:, 1:])
        offset = rate * edges[1] * simulation.time
        assert simulation.cell[1, 0] == pytest.approx(offset - 4.0 * np.round(offset / 4.0), abs=1e-9)
        assert np.all(np.abs(state.positions @ np.linalg.inv(simulation.cell)) <= 0.5 + 1e-12)
    assert np.abs(state.images[:, 1]).max() > 4


def image_sum(
    positions: FloatArray, velocities: FloatArray, cell: FloatArray, rate: float, exponent: float
) -> FloatArray:
    """Soft repulsion 25 and drag 4.5 of all images within 1: those n cells up move by n · rate · L_y along x."""
    forces = np.zeros_like(positions)
    for a in (-2, -1, 0, 1, 2):
        for b in (-1, 0, 1):
            for c in (-1, 0, 1):
                d = positions[:, None] - positions[None] - (a * cell[0] + b * cell[1] + c * cell[2])
                v = velocities[:, None] - velocities[None]
                v = v - np.array([b * rate * cell[1, 1], 0.0, 0.0])
                r = np.linalg.norm(d, axis=2)
                near = (r < 1.0) & (r > 0.0)
                weight = np.where(near, 1.0 - r, 0.0)
                unit = d / np.where(near, r, 1.0)[..., None]
                along = np.sum(unit * v, axis=2)
                forces += np.sum((25.0 * weight - 4.5 * weight**exponent * along)[..., None] * unit, axis=1)
    return forces


@pytest.mark.parametrize("offset", [0.0, 1.3, -2.0])
@pytest.mark.parametrize("exponent", [2.0, 1.0])
def test_forces_and_drag_are_those_of_moving_images(offset: float, exponent: float) -> None:
    cell = tilted([4.0, 3.5, 3.0], offset)
    rng = np.random.default_rng(8)
    positions, velocities = random_positions(100, cell, 5), rng.normal(0.0, 1.0, (100, 3))
    control = sheared(0.6, temperature="0.0 K", fixed_com="off")
    if exponent != 2.0:
        control["ensemble_dpd_exponent"] = f"{exponent}"
    scene = make_scene({"A": 100}, cell=cell, positions=positions, velocities=velocities, control=control)
    simulation = Simulation(scene, seed=1, threads=1)
    state = simulation.state
    expected = image_sum(state.positions, state.velocities, cell, 0.6, exponent)
    np.testing.assert_allclose(state.forces, expected, rtol=0, atol=1e-10)
    # A faster flow, seen in the stress of the drag alone.
    other = Simulation(make_scene({"A": 100}, cell=cell, positions=positions, velocities=velocities,
                                  control=control | sheared(0.7)), seed=1, threads=1)  # fmt: skip
    change = other.observe().stress_parts["drag"] - simulation.observe().stress_parts["drag"]
    assert change[0, 1] < 0.0
    assert (
        np.abs(other.observe().stress_parts["conservative"] - simulation.observe().stress_parts["conservative"]).max()
        == 0
    )


def test_conservative_forces_are_those_of_the_tilted_cell() -> None:
    scene = make_scene({"A": 200}, REPULSION, cell=[4.0, 4.2, 4.4], control=NVE | sheared(0.5))
    simulation = Simulation(scene, seed=2, threads=1)
    for steps in (37, 150, 211):
        simulation.run(steps)
        state = simulation.state
        static = make_scene({"A": 200}, REPULSION, cell=state.cell, positions=state.positions, control=NVE)
        assert np.abs(state.cell[1, 0]) > 0.01
        np.testing.assert_allclose(state.forces, single_point(static).forces, rtol=0, atol=1e-9)


@pytest.mark.parametrize("molecules", [False, True])
def test_without_a_thermostat_the_stress_does_the_work(molecules: bool) -> None:
    """dE/dt = −rate V P_xy, with E of the velocities relative to the flow: by quadrature over 4 time units."""
    rate, edges = 0.8, [4.0, 4.5, 5.0]
    control = NVE | sheared(rate, timestep="0.002 internal_t")
    if molecules:
        ends = random_positions(90, edges, 4)
        positions = np.stack([ends, ends + 0.4], axis=1).reshape(-1, 3)
        scene = molecule_scene(
            ["A", "A"], {"bonds": ["harm 1 2 40.0 0.6"]}, positions, copies=90, pairs=REPULSION, cell=edges,
            control=control,
        )  # fmt: skip
    else:
        scene = make_scene({"A": 200}, REPULSION, cell=edges, control=control)
    simulation = Simulation(scene, seed=4, threads=1)
    simulation.run(300)
    before = simulation.observe().energy["total"]
    stress = [simulation.observe().stress[0, 1]]
    for _ in range(1000):
        simulation.run(2)
        stress.append(simulation.observe().stress[0, 1])
    gained = simulation.observe().energy["total"] - before
    work = -rate * np.prod(edges) * 0.004 * (np.sum(stress) - 0.5 * (stress[0] + stress[-1]))
    assert gained > 10.0
    assert gained == pytest.approx(work, rel=2e-3)


@pytest.mark.parametrize("order", [order for order in SPLIT if order not in CHOOSING])
def test_sweeps_see_the_velocity_of_the_image(order: str) -> None:
    """Two beads across a face across y, nothing but the drag at 0 K: their velocity along the line decays."""
    cell, rate = tilted([6.0, 6.0, 6.0], 0.0), 0.5
    positions = np.array([[0.3, 2.9, 0.1], [0.0, -2.9, 0.0]])
    velocities = np.array([[0.4, -0.1, 0.3], [-0.2, 0.2, 0.0]])
    step = 1e-4

    def after(wanted: str) -> FloatArray:
        control = sheared(rate, temperature="0.0 K", fixed_com="off", timestep=f"{step} internal_t")
        scene = make_scene({"A": 2}, ("A A dpd 0.0 1.0 4.5",), cell=cell, positions=positions, velocities=velocities,
                           control=control | {"ensemble_dpd_order": wanted})  # fmt: skip
        simulation = Simulation(scene, seed=11, threads=1)
        simulation.run(1)
        return simulation.state.velocities

    line = positions[0] - (positions[1] + cell[1])
    distance = float(np.linalg.norm(line))
    unit = line / distance
    relative = velocities[0] - velocities[1] - np.array([rate * 6.0, 0.0, 0.0])
    force = -4.5 * (1.0 - distance) ** 2 * float(unit @ relative) * unit
    for wanted in (order, "mdvv"):
        change = (after(wanted) - velocities) / step
        np.testing.assert_allclose(change[0], force, rtol=2e-3)
        np.testing.assert_allclose(change[1], -force, rtol=2e-3)


@pytest.mark.parametrize("order", CHOOSING)
def test_chosen_pairs_stop_relative_to_the_image(order: str) -> None:
    """At 0 K, with every pair chosen, two beads across a face do not move along their line any more."""
    control = sheared(0.5, temperature="0.0 K", fixed_com="off", ensemble_dpd_order=order)
    scene = make_scene(
        {"A": 2}, ("A A dpd 0.0 1.0 4.5",), cell=6.0, positions=[[0.3, 2.9, 0.1], [0.0, -2.9, 0.0]],
        velocities=[[0.4, -0.1, 0.3], [-0.2, 0.2, 0.0]], control=control | {"ensemble_dpd_rate": "100 dpd_t^-1"},
    )  # fmt: skip
    simulation = Simulation(scene, seed=11, threads=1)
    simulation.run(1)
    state = simulation.state
    line = state.positions[0] - (state.positions[1] + simulation.cell[1])
    relative = state.velocities[0] - state.velocities[1] - [0.5 * 6.0, 0.0, 0.0]
    assert float(line @ relative) == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(relative) > 0.1


@pytest.mark.parametrize("order", ["mdvv", "middle", *SPLIT])
def test_threads_cells_and_checkpoints_change_nothing(order: str, tmp_path: Path) -> None:
    """Over a jump of the offset by an edge, with velocities drawn and scaled on the way."""

    def scene() -> Scene:
        control = sheared(2.5, ensemble_dpd_order=order, time_equilibration="15 steps", rescale_frequency="4 steps")
        return make_scene({"A": 1100}, cell=[7.0, 7.5, 8.0], control=control)

    one = Simulation(scene(), seed=3, threads=1, cell_width=1.7)
    two = Simulation(scene(), seed=3, threads=2)
    one.run(30)
    two.run(17)
    two.observe()
    two.configurational()
    two.save(tmp_path / "REVIVE")
    two = Simulation.resume(tmp_path / "REVIVE", threads=2)
    two.run(13)
    assert one.cell[1, 0] < 0.0 < 2.5 * 7.5 * one.time
    np.testing.assert_array_equal(one.cell, two.cell)
    for name in ("positions", "velocities", "images"):
        np.testing.assert_array_equal(getattr(one.state, name), getattr(two.state, name))
    np.testing.assert_array_equal(one.observe().stress, two.observe().stress)


@pytest.mark.parametrize("order", ["mdvv", "middle", "second", "lowe-andersen", "stoyanov-groot"])
def test_momentum_relative_to_the_flow_is_conserved(order: str) -> None:
    scene = make_scene({"A": 400}, cell=5.0, control=sheared(0.3, ensemble_dpd_order=order))
    simulation = Simulation(scene, seed=5, threads=1)
    assert simulation.temperature == pytest.approx(1.0)
    simulation.run(200)
    np.testing.assert_allclose(simulation.observe().momentum, 0.0, atol=1e-10)


def test_the_start_has_the_flow_and_its_temperature() -> None:
    scene = make_scene({"A": 3000}, cell=10.0, control=sheared(1.5))
    simulation = Simulation(scene, seed=5, threads=1)
    state = simulation.state
    slope = np.polyfit(state.positions[:, 1], state.velocities[:, 0], 1)[0]
    assert slope == pytest.approx(1.5, abs=4 * np.sqrt(12.0 / 3000) / 10.0)
    assert simulation.temperature == pytest.approx(1.0)
    assert scene.imcon == 3
    assert scene.degrees_of_freedom == 8997


def test_a_run_goes_on_from_its_last_configuration(tmp_path: Path) -> None:
    control = sheared(1.0, time_run="60 steps", random_seed="[ 1 2 3 ]")
    scene = make_scene({"A": 120}, cell=[4.0, 4.0, 4.0], control=control)
    simulation = Simulation(scene, threads=1)
    simulation.run(60)
    simulation.save(tmp_path / "REVIVE")
    resumed = Simulation.resume(tmp_path / "REVIVE", scene=scene, threads=1)
    np.testing.assert_array_equal(resumed.cell, simulation.cell)
    last = configuration_of(simulation)
    assert last.imcon == 3
    again = make_scene(
        {"A": 120}, cell=last.cell, positions=last.positions, velocities=last.velocities, control=control
    )
    np.testing.assert_array_equal(again.cell, simulation.cell)
    np.testing.assert_allclose(Simulation(again, threads=1).state.velocities, last.velocities, atol=1e-12)


@pytest.mark.parametrize(
    ("control", "settings", "message"),
    [
        (
            {"ensemble_dpd_order": "scvv"},
            {},
            "'shear_rate': scvv is not modelled in a sheared cell; these are: nve, mdvv",
        ),
        ({"ensemble_dpd_order": "dpdvv"}, {}, "dpdvv is not modelled in a sheared cell"),
        ({"ensemble_dpd_order": "nose-hoover-langevin"}, {}, "nose-hoover-langevin is not modelled in a sheared cell"),
        ({"ensemble_method": "langevin", "ensemble_thermostat_friction": "1.0 ps^-1"}, {}, "langevin is not modelled"),
        ({"ensemble_dpd_lambda": "0.65"}, {}, "'ensemble_dpd_lambda': a sheared cell goes with lambda 0.5 only"),
        ({"ensemble_dpd_kinetic": "half"}, {}, "'ensemble_dpd_kinetic': half is not modelled in a sheared cell"),
        ({}, {"imcon": 6}, "'shear_rate': a sheared cell: periodicity key imcon 6 is not modelled with it"),
        ({}, {"extern": "grav 0 0 1"}, "a sheared cell: external fields are not modelled with it"),
        ({}, {"frozen": ("A",)}, "a sheared cell: frozen beads are not modelled with it"),
        ({"wall_method": "reflecting"}, {}, "a sheared cell: walls are not modelled with it"),
        ({}, {"cell": [[5, 0, 0], [0, 5, 0], [1, 0, 5]]}, "tilted along x in its second vector alone"),
    ],
)
def test_what_a_sheared_cell_does_not_go_with_is_refused(control: dict, settings: dict, message: str) -> None:
    with pytest.raises(InputError) as error:
        make_scene({"A": 60}, **({"cell": 5.0, "control": sheared(0.1) | control} | settings))
    assert message in str(error.value)


def test_it_is_explained() -> None:
    scene = make_scene({"A": 60}, cell=5.0, control=sheared(0.1))
    assert "Lees-Edwards boundaries: flow along x, gradient along y, shear rate 0.1" in scene.explain()
    assert "general path: the cell is sheared" in scene.explain()


def test_the_tradeoff_leaves_out_what_does_not_fit() -> None:
    def refused(**settings: object) -> dict[str, set[bool]]:
        scene = make_scene({"A": 60}, cell=5.0, **settings)  # type: ignore[arg-type]
        found: dict[str, set[bool]] = {}
        for candidate in candidates_for(scene, integrators=["mdvv", "middle", "scvv", "ou-middle"]):
            found.setdefault(candidate.integrator, set()).add(bool(candidate.refused))
        return found

    for settings in ({"control": sheared(0.1)}, {"control": {"wall_method": "reflecting"}}):
        found = refused(**settings)
        assert (found["mdvv"], found["scvv"], found["ou-middle"]) == ({True, False}, {True}, {False})
    assert refused()["scvv"] == {False}
