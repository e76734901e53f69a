"""Walls: flight between them in closed form, profiles of a gas, soft and frozen walls, what they do not go with."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from pydlpoly import Scene, Simulation, single_point
from pydlpoly.errors import InputError, SceneError
from tests.scene_builder import NVE, make_scene

START, VELOCITY = np.array([0.3, -0.4, 0.5]), np.array([1.0, -0.7, 3.1])
EDGES = np.array([6.0, 5.0, 4.0])


def flight(method: str, axes: str, *, order: str | None = None, **more: str) -> Simulation:
    control: dict[str, str | None] = dict(NVE) if order is None else {"ensemble_dpd_order": order}
    scene = make_scene(
        {"A": 1},
        () if order is None else ("A A dpd 25 1.0 4.5",),
        cell=EDGES,
        positions=[START],
        velocities=[VELOCITY],
        control=control | {"fixed_com": "off", "wall_method": method, "wall_axes": axes, **more},
    )
    return Simulation(scene, seed=1, threads=1)


def folded(x: ArrayLike, distance: ArrayLike) -> np.ndarray:
    """Mirror images of x at walls at ± distance."""
    phase = np.mod(np.asarray(x) + distance, 4.0 * np.asarray(distance))
    return np.minimum(phase, 4.0 * np.asarray(distance) - phase) - distance


@pytest.mark.parametrize("order", [None, "mdvv", "middle", "second"])
def test_a_reflected_bead_is_where_its_mirror_image_is(order: str | None) -> None:
    simulation = flight("reflecting", "yz", order=order)
    for _ in range(20):
        simulation.run(137)
        time, state = simulation.time, simulation.state
        straight = START + VELOCITY * time
        np.testing.assert_allclose(state.positions[0, 1:], folded(straight, 0.5 * EDGES)[1:], rtol=0, atol=1e-10)
        assert simulation.displacements()[0, 0] == pytest.approx(VELOCITY[0] * time, abs=1e-10)
    assert np.all(np.abs(state.velocities[0]) == np.abs(VELOCITY))


def test_a_bead_bounces_back_along_its_path() -> None:
    simulation = flight("bounce-back", "z", wall_position="1.5 ang")
    for _ in range(20):
        simulation.run(137)
        time = simulation.time
        height = float(folded(START[2] + VELOCITY[2] * time, 1.5))
        expected = VELOCITY * (height - START[2]) / VELOCITY[2]  # it never leaves the line between the walls
        np.testing.assert_allclose(simulation.displacements()[0], expected, rtol=0, atol=1e-10)
        assert np.abs(simulation.state.velocities[0]) == pytest.approx(np.abs(VELOCITY), abs=0)


def test_many_bounces_in_one_step_and_corners() -> None:
    scene = make_scene(
        {"A": 1}, (), cell=4.0, positions=[[1.5, 1.5, 0.0]], velocities=[[25.0, 25.0, 0.0]],
        control=NVE | {"fixed_com": "off", "wall_method": "reflecting", "wall_axes": "xyz", "timestep": "1 internal_t"},
    )  # fmt: skip
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(7)
    expected = folded(1.5 + 25.0 * 7.0, 2.0)
    np.testing.assert_allclose(simulation.state.positions[0], [expected, expected, 0.0], atol=1e-11)


def gas(method: str, seed: int, axes: str = "z") -> tuple[Simulation, float]:
    """A DPD gas without repulsion: drag and noise only."""
    control = {"wall_method": method, "wall_axes": axes, "timestep": "0.02 internal_t", "ensemble_dpd_order": "middle"}
    scene = make_scene({"A": 600}, ("A A dpd 0.0 1.0 4.5",), cell=[5.0, 5.0, 8.0], control=control)
    return Simulation(scene, seed=seed, threads=1), 4.0


@pytest.mark.slow
@pytest.mark.parametrize("method", ["reflecting", "bounce-back"])
def test_a_gas_between_walls_is_uniform_and_none_escapes(method: str) -> None:
    simulation, distance = gas(method, 5)
    simulation.run(500)
    temperatures, counts = [], np.zeros(16)
    for _ in range(600):
        simulation.run(25)
        z = simulation.state.positions[:, 2]
        assert np.all(np.abs(z) <= distance)
        counts += np.histogram(z, bins=16, range=(-distance, distance))[0]
        temperatures.append(simulation.temperature)
    # 360000 looks; a bead stays in a bin of 0.5 for about half a time unit, the interval: error of a bin about 1 %.
    np.testing.assert_allclose(counts / counts.mean(), 1.0, atol=0.05)
    # √(2/1800) of each look, which are 0.5 apart and hardly correlated: 0.0014
    assert np.mean(temperatures) == pytest.approx(1.0, abs=0.006)


def soft(positions: ArrayLike, **more: str) -> Scene:
    control = NVE | {
        "wall_method": "soft",
        "wall_axes": "xz",
        "wall_strength": "[ 20.0 35.0 ] dpd_f",
        "wall_range": "1.5 ang",
    }
    places = np.asarray(positions)
    return make_scene({"A": len(places) // 2, "B": len(places) - len(places) // 2}, (), cell=[5.0, 6.0, 7.0],
                      positions=places, control=control | more)  # fmt: skip


def test_soft_walls_have_the_slope_of_their_energy() -> None:
    positions = np.array([[2.1, 0, 0], [0, 0, -3.2], [-2.4, 2.9, 3.3], [0.2, 0.1, 0.1], [-1.1, 0, 2.1], [0.9, 0, 0]])
    strengths = np.repeat([20.0, 35.0], 3)
    point = single_point(soft(positions))
    energy = 0.0
    for bead, place in enumerate(positions):
        for axis, half in ((0, 2.5), (2, 3.5)):
            for gap in (half - place[axis], half + place[axis]):
                energy += 0.5 * strengths[bead] * 1.5 * max(0.0, 1.0 - gap / 1.5) ** 2
    assert point.energy["field"] == pytest.approx(energy)
    for bead in range(6):
        for axis in range(3):
            step = np.zeros_like(positions)
            step[bead, axis] = 1e-6
            ends = [single_point(soft(positions + s)).energy["field"] for s in (step, -step)]
            assert point.forces[bead, axis] == pytest.approx((ends[1] - ends[0]) / 2e-6, abs=1e-6)


@pytest.mark.parametrize(("speed", "error"), [(1.0, 2e-5), (6.0, 1e-2)])
def test_soft_walls_conserve_energy_and_hold_fast_beads(speed: float, error: float) -> None:
    """Fast beads come through the repulsion to the face, where the force jumps and the energy is kept less well."""
    rng = np.random.default_rng(3)
    scene = soft(rng.uniform(-1.0, 1.0, (40, 3)), wall_axes="xyz", timestep="0.002 internal_t", fixed_com="off")
    simulation = Simulation(scene, seed=3, threads=1)
    simulation.set_state(velocities=rng.normal(0.0, speed, (40, 3)))
    before, held = simulation.energy["total"], 0.0
    for _ in range(40):
        simulation.run(50)
        assert np.all(np.abs(simulation.state.positions) <= [2.5, 3.0, 3.5])
        held = max(held, simulation.energy["field"])
    assert held > 0.05 * before
    assert simulation.energy["total"] == pytest.approx(before, rel=error)


def test_one_strength_serves_all_species_and_the_range_has_a_default() -> None:
    scene = soft(np.zeros((4, 3)), wall_strength="[ 20.0 ] dpd_f", wall_range=None)  # type: ignore[arg-type]
    assert scene.walls is not None
    assert scene.walls.strengths == (20.0, 20.0)
    assert scene.walls.range == 1.0
    assert any("soft walls end at the van der Waals cutoff, 1 ang" in note.text for note in scene.notes)


def test_beads_do_not_meet_through_a_wall() -> None:
    def forces(**control: str) -> np.ndarray:
        scene = make_scene({"A": 2}, cell=5.0, positions=[[0, 0, 2.4], [0, 0, -2.4]], control=NVE | control)
        return single_point(scene).forces

    assert np.any(forces() != 0.0)
    assert np.all(forces(wall_method="reflecting") == 0.0)
    assert np.any(forces(wall_method="reflecting", wall_axes="x") != 0.0)


def test_threads_and_checkpoints_change_nothing(tmp_path: Path) -> None:
    def scene() -> Scene:
        control = {"wall_method": "soft", "wall_axes": "y", "wall_strength": "[ 25.0 ] dpd_f"}
        return make_scene({"A": 1200}, cell=[7.0, 7.5, 8.0], control=control, extern="grav 0.1 0 0")

    one, two = Simulation(scene(), seed=3, threads=1), Simulation(scene(), seed=3, threads=2)
    one.run(20)
    two.run(11)
    two.save(tmp_path / "REVIVE")
    two = Simulation.resume(tmp_path / "REVIVE", threads=2)
    two.run(9)
    np.testing.assert_array_equal(one.state.positions, two.state.positions)
    np.testing.assert_array_equal(one.state.velocities, two.state.velocities)
    assert one.energy["field"] == two.energy["field"] > 0.0


def frozen_walls() -> Scene:
    """Four layers of frozen beads at the faces, about as dense as the fluid between them."""
    rng = np.random.default_rng(6)
    grid = np.stack(np.meshgrid(*(np.linspace(-2.5, 2.5, 7, endpoint=False),) * 2), -1).reshape(-1, 2)
    layers = [np.column_stack([grid, np.full(len(grid), z)]) for z in (-3.85, -3.2, 3.2, 3.85)]
    fluid = rng.uniform([-2.5, -2.5, -2.9], [2.5, 2.5, 2.9], (435, 3))
    positions = np.concatenate([fluid, *layers])
    pairs = ("A A dpd 25 1.0 4.5", "A W dpd 25 1.0 4.5", "W W dpd 25 1.0 4.5")
    return make_scene({"A": 435, "W": 196}, pairs, cell=[5.0, 5.0, 8.4], positions=positions, frozen=("W",),
                      extern="grav 0.1 0 0", control={"timestep": "0.02 internal_t"})  # fmt: skip


@pytest.mark.slow
def test_frozen_walls_hold_the_fluid_and_its_flow() -> None:
    simulation = Simulation(frozen_walls(), seed=2, threads=1)
    wall = simulation.state.positions[435:]
    simulation.run(2000)
    flow, counts = np.zeros(3), np.zeros(3)
    for _ in range(300):
        simulation.run(10)
        state = simulation.state
        z = state.positions[:435, 2]
        counts += np.histogram(z, bins=[-3.5, -2.0, 2.0, 3.5])[0]
        flow += np.histogram(z, bins=[-3.5, -2.0, 2.0, 3.5], weights=state.velocities[:435, 0])[0]
    np.testing.assert_array_equal(state.positions[435:], wall)
    assert np.mean(np.abs(z) < 3.5) > 0.98  # dense frozen layers let hardly any bead in
    middle = flow[1] / counts[1]
    sides = (flow[0] + flow[2]) / (counts[0] + counts[2])
    # Poiseuille with slip: v − ρ g z²/(2η), with η = 0.85 and ⟨z²⟩ = 4/3 within 2 and 6.1 from there to 2.9
    assert middle - sides == pytest.approx(2.95 * 0.1 / 1.7 * (6.1 - 1.33), rel=0.25)
    assert sides > 0.5


@pytest.mark.parametrize(
    ("control", "settings", "message"),
    [
        ({}, {"imcon": 6}, "'wall_method': walls need a cubic or orthorhombic cell (imcon 1 or 2), not imcon 6"),
        ({"ensemble_dpd_order": "scvv"}, {}, "'wall_method': scvv is not modelled with walls"),
        ({"ensemble_dpd_lambda": "0.65"}, {}, "'wall_method': walls: lambda 0.5 only"),
        (
            {"wall_position": "2.6 ang"},
            {},
            "'wall_position': walls stand above 0 and up to half the cell's edge (2.5 ang)",
        ),
        ({"wall_position": "1.0 ang"}, {}, "is beyond a wall (wall_method)"),
        ({"wall_method": "soft"}, {}, "'wall_method': soft walls need wall_strength"),
        ({"wall_method": "soft", "wall_strength": "[ 1.0 2.0 ] dpd_f"}, {}, "2 numbers for 1 species (A)"),
        ({"wall_method": "soft", "wall_strength": "[ -1.0 ] dpd_f"}, {}, "must be finite and not negative"),
        ({"wall_method": "sticky"}, {}, "sticky"),
        ({}, {"extern": "magn 0 0 1", "charges": {"A": 1.0}}, "walls and the field magn are not modelled together"),
    ],
)
def test_what_walls_do_not_go_with_is_refused(control: dict, settings: dict, message: str) -> None:
    with pytest.raises(InputError) as error:
        make_scene({"A": 60}, cell=5.0, control={"wall_method": "reflecting"} | control, **settings)
    assert message in str(error.value)


def test_settings_of_other_walls_are_noted() -> None:
    scene = make_scene({"A": 9}, cell=5.0, control={"wall_method": "reflecting", "wall_range": "1.0 ang"})
    assert any("wall_range: only soft walls have it" in note.text for note in scene.notes)
    scene = make_scene({"A": 9}, cell=5.0, control={"wall_axes": "x"})
    assert any("wall_axes x: nothing in this scene uses it" in note.text for note in scene.notes)


def test_a_scene_without_walls_has_none() -> None:
    assert make_scene({"A": 9}, cell=5.0).walls is None
    with pytest.raises(SceneError):
        make_scene({"A": 9}, cell=5.0, control={"wall_method": "soft"})
