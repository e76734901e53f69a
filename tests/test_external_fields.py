"""External fields: motion in closed form, forces against slopes, energies, units, refusals, continuation."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import Scene, Simulation, single_point
from pydlpoly.errors import SceneError
from tests.scene_builder import NVE, make_scene

FIELD_UNIT = 1.0 / 1.037837512e-4  # Da Å/(ps² e) for 1 V/Å, DL_POLY's
TESLA = 1.0 / 1.037837512e4


def one_bead(
    extern: str,
    *,
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    position: tuple[float, float, float] = (0.0, 0.0, 0.0),
    units: str = "dpd",
    order: str | None = None,
    timestep: float = 0.01,
    imcon: int = 2,
    more: dict[str, str | None] | None = None,
) -> Scene:
    control: dict[str, str | None] = dict(NVE) if order is None else {"ensemble_dpd_order": order}
    return make_scene(
        {"A": 1},
        () if order is None else ("A A dpd 25 1.0 0.5",),
        cell=50.0,
        imcon=imcon,
        positions=[position],
        velocities=[velocity],
        control=control | {"timestep": f"{timestep} internal_t", "fixed_com": "off", **(more or {})},
        masses={"A": 2.0},
        charges={"A": -1.5},
        extern=extern,
        units=units,
    )


@pytest.mark.parametrize(("units", "factor"), [("dpd", 1.0), ("kJ", FIELD_UNIT), ("K", FIELD_UNIT)])
def test_elec_is_free_fall_of_the_charge(units: str, factor: float) -> None:
    field = np.array([0.1, 0.2, -0.3]) / factor
    scene = one_bead("elec " + " ".join(f"{x:.17g}" for x in field), velocity=(1.0, 0.0, 0.5), units=units)
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(300)
    acceleration = -1.5 / 2.0 * field * factor
    expected = 3.0 * np.array([1.0, 0.0, 0.5]) + 0.5 * acceleration * 9.0
    np.testing.assert_allclose(simulation.displacements()[0], expected, rtol=0, atol=1e-12)
    assert simulation.energy["field"] == 0.0


def test_osel_follows_its_sine() -> None:
    frequency = 0.4
    simulation = Simulation(one_bead(f"osel 0 2.0 0 {frequency}", timestep=0.001), seed=1, threads=1)
    simulation.run(2000)
    omega, acceleration = 2.0 * math.pi * frequency, -1.5 * 2.0 / 2.0
    expected = acceleration * (2.0 / omega - math.sin(2.0 * omega) / omega**2)
    assert simulation.displacements()[0, 1] == pytest.approx(expected, abs=2e-6)
    assert np.all(simulation.displacements()[0, [0, 2]] == 0.0)


@pytest.mark.parametrize("order", [None, "mdvv", "middle", "ou-middle", "first"])
@pytest.mark.parametrize("timestep", [0.01, 0.5])
def test_magn_turns_a_bead_on_its_helix_for_any_timestep(order: str | None, timestep: float) -> None:
    field, velocity = np.array([0.6, -0.8, 2.4]), np.array([0.5, 0.3, -0.2])
    scene = one_bead("magn 0.6 -0.8 2.4", velocity=tuple(velocity), order=order, timestep=timestep)
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(40)
    time = 40 * timestep
    axis = field / np.linalg.norm(field)
    rate = 1.5 / 2.0 * np.linalg.norm(field)  # a negative charge turns about the field
    along = axis * (axis @ velocity)
    across, turned = velocity - along, np.cross(axis, velocity)
    expected = along * time + across * math.sin(rate * time) / rate + turned * (1.0 - math.cos(rate * time)) / rate
    np.testing.assert_allclose(simulation.displacements()[0], expected, rtol=0, atol=1e-12)
    now = along + across * math.cos(rate * time) + turned * math.sin(rate * time)
    np.testing.assert_allclose(simulation.state.velocities[0], now, rtol=0, atol=1e-13)


def test_magn_is_in_tesla_outside_reduced_units() -> None:
    scene = one_bead("magn 0 0 20.0", units="kJ")
    assert scene.external[0].parameters == pytest.approx((0.0, 0.0, 20.0 * TESLA))
    # q = −1.5 e, m = 2 Da: the angle in 40 ps; 1 T turns a proton by 9.58e-5 rad/ps.
    simulation = Simulation(one_bead("magn 0 0 20.0", units="kJ", velocity=(1.0, 0.0, 0.0)), seed=1, threads=1)
    simulation.run(4000)
    angle = 0.75 * 20.0 * TESLA * 40.0
    np.testing.assert_allclose(simulation.state.velocities[0], [math.cos(angle), math.sin(angle), 0.0], atol=1e-12)


def test_magn_does_no_work_in_a_fluid() -> None:
    """Energy of a soft fluid: as well kept with the field as without; its error falls with the timestep squared."""
    errors = []
    for timestep in (0.01, 0.005):
        control = NVE | {"timestep": f"{timestep} internal_t", "fixed_com": "off", "random_seed": "[ 5 5 5 ]"}
        scene = make_scene(
            {"A": 81, "B": 81}, ("A A dpd 25 1.0", "A B dpd 25 1.0", "B B dpd 25 1.0"), cell=[3.0, 4.0, 4.5],
            control=control, charges={"A": 1.0, "B": -1.0}, extern="magn 1 2 3",
        )  # fmt: skip
        simulation = Simulation(scene, seed=3, threads=1)
        simulation.run(round(1.0 / timestep))
        before = simulation.observe().energy["total"]
        worst = 0.0
        for _ in range(50):
            simulation.run(round(0.05 / timestep))
            worst = max(worst, abs(simulation.observe().energy["total"] - before))
        errors.append(worst)
    assert errors[0] < 0.01 * before
    assert errors[1] < 0.45 * errors[0]


def test_pois_pushes_the_halves_apart() -> None:
    scene = make_scene(
        {"A": 2}, (), cell=6.0, positions=[[0, 1, 2], [0, -1, 2]], masses={"A": 2.0}, control=NVE, extern="pois 0.3"
    )
    np.testing.assert_array_equal(single_point(scene).forces, [[0.6, 0, 0], [-0.6, 0, 0]])


def test_sphr_has_the_slope_of_its_energy() -> None:
    rng = np.random.default_rng(4)
    positions = rng.uniform(-2.5, 2.5, (40, 3))
    distance = np.linalg.norm(positions, axis=1)

    def point(places: np.ndarray):
        return single_point(make_scene({"A": 40}, (), cell=20.0, positions=places, control=NVE,
                                       extern="sphr 3.0 5.0 3.5 1.0"))  # fmt: skip

    here = point(positions)
    assert here.energy["field"] == pytest.approx(np.sum(np.where(distance > 1.0, 3.0 * (5.0 - distance) ** -3.5, 0.0)))
    assert here.energy["total"] == here.energy["field"]
    assert np.all(here.forces[distance <= 1.0] == 0.0)
    for bead in (int(np.argmax(distance)), 3, 11):
        for axis in range(3):
            step = np.zeros_like(positions)
            step[bead, axis] = 1e-5
            slope = (point(positions + step).energy["field"] - point(positions - step).energy["field"]) / 2e-5
            assert here.forces[bead, axis] == pytest.approx(-slope, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize(("side", "acts"), [(1, [0.0, 0.5, 2.0]), (-3, [0.0, -0.5, -1.0])])
def test_zbnd_is_a_spring_beyond_its_height(side: int, acts: list[float]) -> None:
    scene = make_scene(
        {"A": 3}, (), cell=20.0, positions=[[0, 0, 1.0 - np.sign(side)], [1, 0, 1.0 + acts[1]], [2, 0, 1.0 + acts[2]]],
        control=NVE, extern=f"zbnd 6.0 1.0 {side}",
    )  # fmt: skip
    point = single_point(scene)
    np.testing.assert_allclose(point.forces[:, 2], [-6.0 * x for x in acts], atol=1e-13)
    assert np.all(point.forces[:, :2] == 0.0)
    assert point.energy["field"] == pytest.approx(3.0 * sum(x * x for x in acts))


@pytest.mark.parametrize("extern", ["sphr 3.0 5.0 2.0 0.0", "zbnd 6.0 0.2 1"])
def test_energy_of_beads_in_the_field_is_conserved(extern: str) -> None:
    rng = np.random.default_rng(2)
    scene = make_scene(
        {"A": 30}, ("A A dpd 25 1.0",), cell=40.0, positions=rng.uniform(-1.5, 1.5, (30, 3)),
        velocities=rng.normal(0, 1, (30, 3)), control=NVE | {"fixed_com": "off", "timestep": "0.001 internal_t"},
        extern=extern,
    )  # fmt: skip
    simulation = Simulation(scene, seed=1, threads=1)
    before = simulation.energy
    simulation.run(3000)
    after = simulation.energy
    assert before["field"] != pytest.approx(after["field"], rel=1e-3)
    assert before["potential"] == pytest.approx(before["pair"] + before["field"])
    assert after["total"] == pytest.approx(before["total"], rel=2e-5)


@pytest.mark.parametrize("extern", ["sphr 3.0 5.0 2.0 0.0", "zbnd 6.0 0.2 1"])
def test_curvature_is_the_derivative_of_the_force(extern: str) -> None:
    position = np.array([[0.4, 0.7, 0.9]])

    def scene(places: np.ndarray) -> Scene:
        return make_scene({"A": 1}, (), cell=14.0, positions=places, velocities=[[0, 0, 0]], control=NVE, extern=extern)

    curvature = Simulation(scene(position), seed=1, threads=1).configurational()[1]
    total = 0.0
    for axis in range(3):
        step = 1e-5 * np.eye(3)[axis]
        ends = [single_point(scene(position + s)).forces[0, axis] for s in (step, -step)]
        total -= (ends[0] - ends[1]) / 2e-5
    assert curvature == pytest.approx(total, rel=1e-6)


def slabs() -> Scene:
    return make_scene(
        {"A": 200}, cell=[5.0, 5.0, 5.0], imcon=6, extern="shrx 1.2 2.0", control={"timestep": "0.005 internal_t"}
    )


def test_shrx_moves_the_slabs_and_drags_the_fluid_between(tmp_path: Path) -> None:
    simulation = Simulation(slabs(), seed=3, threads=1)
    simulation.run(200)
    state = simulation.state
    z, vx = state.positions[:, 2], state.velocities[:, 0]
    kick = 0.5 * 0.005 * state.forces[:, 0]  # after the velocities were set
    outside = np.abs(z) > 2.0
    assert 20 < outside.sum() < 200
    np.testing.assert_allclose((vx - kick)[outside], 0.6 * np.sign(z[outside]), atol=1e-13)
    simulation.save(tmp_path / "REVIVE")
    resumed = Simulation.resume(tmp_path / "REVIVE")
    np.testing.assert_array_equal(resumed.state.velocities, state.velocities)
    for each in (simulation, resumed):
        each.configurational()  # looking changes nothing
        each.run(50)
    np.testing.assert_array_equal(resumed.state.positions, simulation.state.positions)
    np.testing.assert_array_equal(resumed.state.velocities, simulation.state.velocities)


@pytest.mark.parametrize("extern", ["elec 1 0 0.5", "osel 1 0 0 0.7", "magn 1 2 3", "zbnd 5 0.5 1", "pois 0.2"])
@pytest.mark.parametrize("order", ["mdvv", "second"])
def test_threads_and_checkpoints_change_nothing(extern: str, order: str, tmp_path: Path) -> None:
    def scene() -> Scene:
        return make_scene({"A": 1200}, cell=[7.0, 7.5, 8.0], charges={"A": 0.5}, extern=extern,
                          control={"ensemble_dpd_order": order})  # fmt: skip

    one, two = Simulation(scene(), seed=3, threads=1), Simulation(scene(), seed=3, threads=2)
    one.run(20)
    two.run(11)
    two.save(tmp_path / "REVIVE")
    two = Simulation.resume(tmp_path / "REVIVE", threads=2)
    two.run(9)
    np.testing.assert_array_equal(one.state.positions, two.state.positions)
    np.testing.assert_array_equal(one.state.velocities, two.state.velocities)


def test_charges_without_a_field_cost_and_do_nothing() -> None:
    scene = make_scene({"A": 30}, cell=4.0, extern="elec 1 1 1")
    assert scene.external == ()
    assert any("elec has no effect: no bead that moves is charged" in note.text for note in scene.notes)


@pytest.mark.parametrize(
    ("extern", "imcon", "message"),
    [
        (
            "xpis 1 2 3",
            2,
            "this external field is not modelled; elec, grav, magn, osel, oshr, pois, shrx, sphr, zbnd are",
        ),
        ("zres 1 2 3 4 5", 2, "this external field is not modelled"),
        ("zrs- 1 2 3 4 5", 2, "this external field is not modelled"),
        ("zrs+ 1 2 3 4 5", 2, "this external field is not modelled"),
        ("ushr 1 2 3 4 5 6", 2, "this external field is not modelled"),
        ("elec 1 0", 2, "takes 3 numbers (Ex Ey Ez), found 2"),
        ("pois 1 2", 2, "takes 1 number (g), found 2"),
        ("shrx 1 2", 2, "shear by moving slabs needs a slab (imcon 6), not imcon 2"),
        ("pois 1", 6, "periodic Poiseuille flow needs a cubic or orthorhombic cell (imcon 1 or 2), not imcon 6"),
        ("sphr 1 2 3 2.5", 2, "needs n above 0 and Rcut from 0 to below R0"),
    ],
)
def test_refusals_name_the_field(extern: str, imcon: int, message: str) -> None:
    with pytest.raises(SceneError) as error:
        make_scene({"A": 3}, cell=6.0, imcon=imcon, extern=extern)
    assert message in str(error.value)
    assert extern.split()[0] in str(error.value)


@pytest.mark.parametrize(
    ("control", "message"),
    [
        ({"ensemble_dpd_order": "scvv"}, "scvv is not modelled with the field magn"),
        ({"ensemble_dpd_order": "dpdvv"}, "dpdvv is not modelled with the field magn"),
        ({"ensemble_dpd_lambda": "0.65"}, "'ensemble_dpd_lambda': the field magn: lambda 0.5 only"),
    ],
)
def test_integrators_that_magn_does_not_fit_are_refused(control: dict[str, str | None], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        make_scene({"A": 30}, cell=4.0, extern="magn 0 0 1", charges={"A": 1.0}, control=control)


def test_a_bead_outside_the_sphere_stops_the_run() -> None:
    from pydlpoly.errors import RunError

    scene = make_scene({"A": 1}, (), cell=20.0, positions=[[3.0, 0, 0]], control=NVE, extern="sphr 1 2 3 1")
    with pytest.raises(RunError, match="bead 1 is outside the sphere"):
        single_point(scene)
