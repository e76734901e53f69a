"""The Python interface: single points, runs in pieces, reporters, states, checkpoints, very long runs."""

from __future__ import annotations

import copy
import os
import pickle
import signal
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pydlpoly
from pydlpoly import Simulation, single_point
from pydlpoly.errors import InputError, RunError, SceneError
from pydlpoly.formats.records import FloatArray
from pydlpoly.pace import Pace

from .run_folders import EDGE, run_folder
from .scene_builder import NVE, make_scene


@pytest.fixture
def scene(tmp_path: Path) -> pydlpoly.Scene:
    return pydlpoly.load(run_folder(tmp_path))


def bits(simulation: Simulation) -> tuple[bytes, ...]:
    state = simulation.state
    return tuple(a.tobytes() for a in (state.positions, state.velocities, state.forces, state.images))


def by_hand(scene: pydlpoly.Scene) -> tuple[float, FloatArray, FloatArray]:
    """Energy, forces and Σ F_a r_b of DPD's soft repulsion, pair by pair in numpy."""
    places, kinds = scene.beads.positions, scene.beads.species
    strength = np.array([[25.0, 30.0], [30.0, 25.0]])[kinds[:, None], kinds[None, :]]
    apart = places[:, None, :] - places[None, :, :]
    apart -= EDGE * np.round(apart / EDGE)
    r = np.linalg.norm(apart, axis=-1)
    np.fill_diagonal(r, np.inf)
    near = np.clip(1.0 - r, 0.0, None)
    force = (strength * near / r)[..., None] * apart
    energy = 0.25 * float(np.sum(strength * near**2))
    return energy, force.sum(axis=1), 0.5 * np.einsum("ija,ijb->ab", force, apart)


def test_single_point(scene: pydlpoly.Scene) -> None:
    point = single_point(scene, threads=1)
    energy, forces, virial = by_hand(scene)
    assert set(point.energy) == {"pair", "bond", "angle", "dihedral", "inversion", "tether", "charge", "field", "total"}
    assert point.energy["pair"] == pytest.approx(energy, rel=1e-12)
    assert point.energy["total"] == sum(point.energy[k] for k in point.energy if k != "total")
    np.testing.assert_allclose(point.forces, forces, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(point.stress, virial / EDGE**3, rtol=1e-10, atol=1e-10)
    assert point.virial == pytest.approx(-np.trace(virial), rel=1e-12)


@pytest.mark.parametrize("threads", [-1, 1_000_000])
def test_threads_that_no_process_can_have(scene: pydlpoly.Scene, threads: int) -> None:
    told = rf"^the number of threads must (be at least 1|lie between 1 and 1024), not {threads}$"
    for start in (Simulation, single_point):
        with pytest.raises(SceneError, match=told):
            start(scene, threads=threads)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, pickle.dumps])
def test_a_copy_never_shares_the_engine(scene: pydlpoly.Scene, copied: Callable[[Simulation], object]) -> None:
    with pytest.raises(TypeError, match=r"save\(\) and Simulation\.resume\(\) do that$"):
        copied(Simulation(scene, threads=1, seed=1))


def test_single_point_is_not_changed_by_seed_or_threads(scene: pydlpoly.Scene) -> None:
    one, two = single_point(scene, threads=1), single_point(scene, threads=2)
    assert one.forces.tobytes() == two.forces.tobytes()
    assert one.energy == two.energy


def test_observation_adds_up(scene: pydlpoly.Scene) -> None:
    simulation = Simulation(scene, threads=1, seed=1)
    simulation.run(20)
    seen = simulation.observe()
    assert seen.step == simulation.step == 20
    assert simulation.time == pytest.approx(0.2)
    assert seen.energy["total"] == seen.energy["potential"] + seen.energy["kinetic"]
    assert simulation.energy == seen.energy
    np.testing.assert_allclose(sum(seen.stress_parts.values()), seen.stress, rtol=1e-13)
    assert simulation.pressure == pytest.approx(np.trace(seen.stress) / 3.0)
    velocities = simulation.state.velocities
    assert seen.energy["kinetic"] == pytest.approx(0.5 * np.sum(velocities**2), rel=1e-12)
    assert simulation.temperature == pytest.approx(np.sum(velocities**2) / (3 * 160 - 3), rel=1e-12)
    np.testing.assert_allclose(seen.momentum, velocities.sum(axis=0), atol=1e-10)


def test_reduced_scene_starts_at_temperature_one(scene: pydlpoly.Scene) -> None:
    assert Simulation(scene, threads=1, seed=3).temperature == pytest.approx(1.0, rel=1e-12)


def test_pieces_threads_and_looking_change_nothing(scene: pydlpoly.Scene) -> None:
    whole = Simulation(scene, threads=1, seed=5)
    whole.run(60)
    pieces = Simulation(scene, threads=2, seed=5)
    for steps in (1, 0, 7, 30, 22):
        pieces.run(steps)
        pieces.observe()
        assert isinstance(pieces.state.positions, np.ndarray)
    assert bits(pieces) == bits(whole)
    assert pieces.observe().stress.tobytes() == whole.observe().stress.tobytes()


def test_chunks_of_any_length_change_nothing(scene: pydlpoly.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    reference = Simulation(scene, threads=1, seed=5)
    reference.run(50)
    lengths = iter(np.random.default_rng(0).integers(1, 9, 1000).tolist())
    monkeypatch.setattr(Pace, "chunk", lambda _self: next(lengths))
    chunked = Simulation(scene, threads=1, seed=5)
    chunked.run(50)
    assert bits(chunked) == bits(reference)


def test_chunks_follow_the_machine_but_not_a_single_held_up_step(
    scene: pydlpoly.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    simulation = Simulation(scene, threads=1, seed=5)
    now, step = [0.0], [0.001]
    monkeypatch.setattr("pydlpoly.simulation.clock.perf_counter", lambda: now[0])
    monkeypatch.setattr(simulation._engine, "run", lambda steps: now.__setitem__(0, now[0] + steps * step[0]))

    def advance(chunks: int) -> float:
        for _ in range(chunks):
            simulation._advance(simulation._pace.chunk())
        return simulation.steps_per_second

    assert advance(20) == pytest.approx(1000.0)
    assert simulation._pace.chunk() == 200, "0.2 s"
    step[0] = 0.02
    simulation._advance(1)
    assert simulation._pace.chunk() > 150
    assert advance(20) == pytest.approx(50.0, rel=0.01)
    step[0] = 0.0001
    assert advance(40) == pytest.approx(10_000.0, rel=0.01)


def test_displacements_are_followed_across_the_cell(scene: pydlpoly.Scene) -> None:
    simulation = Simulation(scene, threads=1, seed=5)
    start = simulation.state.unwrapped
    simulation.run(50)
    assert np.any(simulation.state.images)
    np.testing.assert_array_equal(simulation.displacements(), simulation.state.unwrapped - start)


def test_an_instruction_set_that_is_not_there(scene: pydlpoly.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYDLPOLY_SIMD", "sse")
    with pytest.raises(SceneError, match="PYDLPOLY_SIMD is 'sse'; expected plain, avx2 or avx512"):
        Simulation(scene, threads=1, seed=5)
    assert "none: PYDLPOLY_SIMD is 'sse'" in scene.explain()


def test_negative_steps_and_bad_arguments(scene: pydlpoly.Scene) -> None:
    simulation = Simulation(scene, threads=1, seed=5)
    with pytest.raises(RunError, match="must not be negative"):
        simulation.run(-1)
    with pytest.raises(SceneError, match="seed must lie between"):
        Simulation(scene, seed=2**64)
    with pytest.raises(SceneError, match="seed must lie between"):
        Simulation(scene, seed=-1)
    with pytest.raises(SceneError, match="threads must be at least 1"):
        Simulation(scene, threads=-1)


def test_seed_is_drawn_when_none_is_given_and_repeats_the_run(tmp_path: Path) -> None:
    scene = pydlpoly.load(run_folder(tmp_path, {"random_seed": None}))
    first, second = Simulation(scene, threads=1), Simulation(scene, threads=1)
    assert first.seed != second.seed
    again = Simulation(scene, threads=1, seed=first.seed)
    first.run(5)
    again.run(5)
    assert bits(first) == bits(again)


def test_state_is_a_copy(scene: pydlpoly.Scene) -> None:
    simulation = Simulation(scene, threads=1, seed=5)
    state = simulation.state
    before = bits(simulation)
    for array in (state.positions, state.velocities, state.forces, state.images):
        array[:] = 9
    assert bits(simulation) == before


# -- set_state --------------------------------------------------------------------------------------------------------


def test_set_state_wraps_positions_and_recomputes_forces(tmp_path: Path) -> None:
    scene = pydlpoly.load(run_folder(tmp_path))
    inside, outside = Simulation(scene, threads=1, seed=5), Simulation(scene, threads=1, seed=5)
    places = scene.beads.positions
    shift = EDGE * np.random.default_rng(1).integers(-3, 4, places.shape)
    inside.set_state(positions=places)
    outside.set_state(positions=places + shift)
    assert outside.energy["pair"] == pytest.approx(inside.energy["pair"], rel=1e-12)
    np.testing.assert_allclose(outside.state.positions, places, atol=1e-13)
    np.testing.assert_allclose(outside.state.unwrapped, places + shift, atol=1e-13)
    assert np.abs(outside.state.positions).max() <= EDGE / 2


def test_set_state_with_the_present_state_goes_on_alike(scene: pydlpoly.Scene) -> None:
    simulation = Simulation(scene, threads=1, seed=5)
    simulation.run(30)
    state = simulation.state
    simulation.set_state(positions=state.positions, velocities=state.velocities)
    after = simulation.state
    assert after.positions.tobytes() == state.positions.tobytes()
    assert after.velocities.tobytes() == state.velocities.tobytes()
    assert after.images.tobytes() == state.images.tobytes()


def test_set_state_leaves_frozen_beads_at_rest() -> None:
    scene = make_scene({"A": 20, "F": 5}, ("A A dpd 25.0 1.0 4.5", "A F dpd 25.0 1.0 4.5"), cell=4.0, frozen=("F",))
    simulation = Simulation(scene, threads=1, seed=1)
    simulation.set_state(velocities=np.ones((25, 3)))
    assert not simulation.state.velocities[20:].any()
    places = simulation.state.positions[20:]
    simulation.run(20)
    assert simulation.state.positions[20:].tobytes() == places.tobytes()


@pytest.mark.parametrize("name", ["positions", "velocities"])
@pytest.mark.parametrize("array", [np.zeros(3), np.zeros((159, 3)), np.full((160, 3), np.nan), np.zeros((160, 2))])
def test_set_state_refuses(scene: pydlpoly.Scene, name: str, array: FloatArray) -> None:
    simulation = Simulation(scene, threads=1, seed=5)
    before = bits(simulation)
    with pytest.raises(ValueError, match=rf"{name} must be finite and of shape \(160, 3\)"):
        simulation.set_state(**{name: array})
    assert bits(simulation) == before


# -- reporters --------------------------------------------------------------------------------------------------------


class Recorder:
    """Is due ``interval`` steps after the last time, whenever that was."""

    def __init__(self, interval: int, limit: int = 2**60) -> None:
        self.interval, self.limit, self.steps = interval, limit, list[int]()

    def next_step(self, step: int) -> int | None:
        return step + self.interval if step + self.interval <= self.limit else None

    def report(self, simulation: Simulation) -> None:
        self.steps.append(simulation.step)
        assert simulation.observe().step == simulation.step


@pytest.mark.parametrize("chunk", [1, 3, 1000])
def test_reporters_are_called_in_their_steps_whatever_the_chunks(
    scene: pydlpoly.Scene, monkeypatch: pytest.MonkeyPatch, chunk: int
) -> None:
    monkeypatch.setattr(Pace, "chunk", lambda _self: chunk)
    simulation = Simulation(scene, threads=1, seed=5)
    often, seldom, done = Recorder(7), Recorder(10), Recorder(5, limit=10)
    simulation.reporters += [often, seldom, done]
    simulation.run(43)
    assert often.steps == [7, 14, 21, 28, 35, 42]
    assert seldom.steps == [10, 20, 30, 40]
    assert done.steps == [5, 10]


def test_seconds_of_steps_and_reporters(scene: pydlpoly.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Three chunks that take 20 ms longer, and as many reports of 10 ms, over two runs."""

    class Slow(Recorder):
        def report(self, simulation: Simulation) -> None:
            time.sleep(0.01)
            super().report(simulation)

    simulation = Simulation(scene, threads=1)
    run = simulation._engine.run
    monkeypatch.setattr(simulation._engine, "run", lambda steps: (time.sleep(0.02), run(steps)))
    simulation.reporters.append(Slow(10))
    simulation.run(20)
    simulation.run(10)
    assert set(simulation.seconds) == {"engine", "Slow"}
    assert 0.06 <= simulation.seconds["engine"] < 1.0
    assert 0.03 <= simulation.seconds["Slow"] < 1.0


def test_reporter_that_raises_stops_the_run_at_its_step(scene: pydlpoly.Scene) -> None:
    class Picky(Recorder):
        def report(self, simulation: Simulation) -> None:
            raise LookupError(f"no more at {simulation.step}")

    simulation = Simulation(scene, threads=1, seed=5)
    simulation.reporters.append(Picky(12))
    with pytest.raises(LookupError, match="no more at 12"):
        simulation.run(100)
    assert simulation.step == 12
    simulation.reporters.clear()
    simulation.run(8)
    reference = Simulation(scene, threads=1, seed=5)
    reference.run(20)
    assert bits(simulation) == bits(reference)


def test_reporter_that_looks_back_is_refused(scene: pydlpoly.Scene) -> None:
    simulation = Simulation(scene, threads=1, seed=5)
    simulation.reporters.append(Recorder(0))
    with pytest.raises(ValueError, match="asks for step 0, but the run is at step 0 already"):
        simulation.run(10)


def test_reporter_may_end_the_run(scene: pydlpoly.Scene) -> None:
    class Enough(Recorder):
        def report(self, simulation: Simulation) -> None:
            simulation.interrupt()

    simulation = Simulation(scene, threads=1, seed=5)
    after = Recorder(10)
    simulation.reporters += [Enough(10), after]
    with pytest.raises(KeyboardInterrupt):
        simulation.run(100)
    assert after.steps == [10]
    simulation.reporters.clear()
    simulation.run(5)
    assert simulation.step == 15


def test_ctrl_c_leaves_a_simulation_that_goes_on_with_the_same_bits(scene: pydlpoly.Scene) -> None:
    class CtrlC(Recorder):
        def report(self, _simulation: Simulation) -> None:
            os.kill(os.getpid(), signal.SIGINT)

    simulation = Simulation(scene, threads=1, seed=5)
    simulation.reporters.append(CtrlC(13, limit=13))
    with pytest.raises(KeyboardInterrupt):
        simulation.run(100)
    assert simulation.step == 13
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    simulation.run(7)
    reference = Simulation(scene, threads=1, seed=5)
    reference.run(20)
    assert bits(simulation) == bits(reference)


def test_reporters_that_sleep_cost_no_calls(scene: pydlpoly.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between two reports the reporters are not asked again, however many chunks there are."""
    monkeypatch.setattr(Pace, "chunk", lambda _self: 1)
    asked: list[int] = []

    class Counting(Recorder):
        def next_step(self, step: int) -> int | None:
            asked.append(step)
            return super().next_step(step)

    simulation = Simulation(scene, threads=1, seed=5)
    simulation.reporters.append(Counting(40))
    simulation.run(80)
    assert asked == [0, 40, 80]


# -- checkpoints ------------------------------------------------------------------------------------------------------


def test_save_and_resume(scene: pydlpoly.Scene, tmp_path: Path) -> None:
    whole = Simulation(scene, threads=1, seed=9)
    whole.run(50)
    part = Simulation(scene, threads=1, seed=9)
    part.run(20)
    part.save(tmp_path / "saved")
    resumed = Simulation.resume(tmp_path / "saved", threads=2)
    assert (resumed.step, resumed.seed) == (20, 9)
    assert resumed.time == part.time
    assert bits(resumed) == bits(part)
    assert resumed.energy == part.energy
    assert resumed.observe().stress.tobytes() == part.observe().stress.tobytes()
    resumed.save(tmp_path / "saved again")
    assert (tmp_path / "saved again").read_bytes() == (tmp_path / "saved").read_bytes()
    resumed.run(30)
    assert bits(resumed) == bits(whole)
    assert resumed.distance_counts()[0].tobytes() == whole.distance_counts()[0].tobytes()
    assert resumed.scene.explain() == scene.explain()


def test_checkpoints_of_equal_states_are_equal_files(scene: pydlpoly.Scene, tmp_path: Path) -> None:
    for name, threads in (("a", 1), ("b", 2)):
        simulation = Simulation(scene, threads=threads, seed=9)
        simulation.run(20)
        simulation.save(tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_memory_of_a_custom_reporter_goes_through_the_checkpoint(scene: pydlpoly.Scene, tmp_path: Path) -> None:
    class Remembering(Recorder):
        name = "mine"

        def state(self) -> dict[str, FloatArray]:
            return {"steps": np.array(self.steps, dtype=np.float64)}

    simulation = Simulation(scene, threads=1, seed=9)
    simulation.reporters.append(Remembering(5))
    simulation.run(20)
    simulation.save(tmp_path / "saved")
    resumed = Simulation.resume(tmp_path / "saved", threads=1)
    assert resumed.restored_state("mine")["steps"].tolist() == [5, 10, 15, 20]
    assert resumed.restored_state("yours") == {}


def test_resume_of_nothing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read: No such file"):
        Simulation.resume(tmp_path / "nowhere")
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        Simulation.resume(tmp_path)


def test_another_temperature_may_go_on(tmp_path: Path) -> None:
    scene = pydlpoly.load(run_folder(tmp_path))
    simulation = Simulation(scene, threads=1, seed=9)
    simulation.run(10)
    simulation.save(tmp_path / "saved")
    hot = pydlpoly.load(run_folder(tmp_path, {"temperature": "2.0 dpd_temp"}))
    resumed = Simulation.resume(tmp_path / "saved", scene=hot, threads=1)
    assert resumed.scene.dynamics.thermal_energy == pytest.approx(2.0)
    resumed.run(400)
    assert resumed.temperature > 1.5


@pytest.mark.parametrize("start", [2**31 - 15, 2**32 - 15, 2**53 - 15])
def test_step_counters_beyond_32_bits(scene: pydlpoly.Scene, tmp_path: Path, start: int) -> None:
    simulation = Simulation(scene, threads=1, seed=9)
    simulation._engine.system.step = start
    recorder = Recorder(10)
    simulation.reporters.append(recorder)
    simulation.run(10)
    simulation.save(tmp_path / "saved")
    simulation.run(20)
    assert simulation.step == start + 30
    assert recorder.steps == [start + 10, start + 20, start + 30]
    resumed = Simulation.resume(tmp_path / "saved", threads=1)
    assert resumed.step == start + 10
    resumed.run(20)
    assert bits(resumed) == bits(simulation)


def test_noise_beyond_32_bits_is_new_noise(scene: pydlpoly.Scene) -> None:
    """A counter that forgot its upper half would repeat the noise of step 1."""
    early, late = Simulation(scene, threads=1, seed=9), Simulation(scene, threads=1, seed=9)
    late._engine.system.step = 2**32
    early.run(1)
    late.run(1)
    assert np.abs(early.state.forces - late.state.forces).max() > 1.0


def test_nve_conserves_energy_through_the_interface() -> None:
    scene = make_scene({"A": 81}, cell=3.0, control={**NVE, "timestep": "0.001 internal_t"})
    simulation = Simulation(scene, threads=1, seed=4)
    before = simulation.energy["total"]
    simulation.run(500)
    assert simulation.energy["total"] == pytest.approx(before, rel=1e-4)
