"""Sources and reactions as Python functions: when they are called, what they may change, exact restarts, errors."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pydlpoly
from pydlpoly import InputWarning, RunError, Scene, Simulation
from pydlpoly.callbacks import Moment, Source
from pydlpoly.formats.beads_file import read_beads
from pydlpoly.runner import run_scene

from .carrying import carrying
from .run_folders import run_folder
from .scene_builder import make_scene


def fluid(**more: object) -> Scene:
    return carrying(make_scene({"A": 40, "B": 20}, ("A A dpd 25.0 1.0 4.5", "B B dpd 25.0 1.0 4.5"), cell=3.0, **more))  # type: ignore[arg-type]


def mixed(**more: object) -> Scene:
    return fluid(control={"vdw_mix_method": "lorentz-berthelot", "precision": "mixed"}, **more)


def plain(**more: object) -> Scene:
    return fluid(control={"vdw_mix_method": "lorentz-berthelot", "precision": "reference"}, **more)


def test_steps_are_counted_from_the_start() -> None:
    simulation = Simulation(plain(), seed=1, threads=1)
    simulation.run(2)
    seen: list[tuple[str, int]] = []
    simulation.add_callback(lambda moment: seen.append(("five", moment.step)), every=5)
    simulation.add_callback(lambda moment: seen.append(("three", moment.step)), every=3)
    simulation.run(6)
    simulation.run(0)
    simulation.run(7)
    assert seen == [("three", 3), ("five", 5), ("three", 6), ("three", 9), ("five", 10), ("three", 12), ("five", 15),
                    ("three", 15)]  # fmt: skip


def test_what_a_callback_sees() -> None:
    simulation = Simulation(plain(), seed=1, threads=1)
    found: list[Moment] = []
    simulation.add_callback(found.append, every=4)
    simulation.run(4)
    moment, state, beads = found[0], simulation.state, simulation.scene.beads
    assert (moment.step, moment.time, moment.timestep, moment.interval) == (4, simulation.time, 0.01, 0.04)
    assert moment.species_names == ("A", "B")
    for values, expected in (
        (moment.positions, state.positions), (moment.velocities, state.velocities), (moment.cell, state.cell),
        (moment.species, beads.species), (moment.masses, beads.mass), (moment.temperature, state.temperature),
        (moment.concentrations, state.concentrations), (moment["concentration_2"], state.concentrations[:, 1]),
    ):  # fmt: skip
        np.testing.assert_array_equal(values, expected)
    assert moment.density is None
    with pytest.raises(KeyError, match="salt: expected temperature, concentration_1, concentration_2"):
        moment["salt"]


def test_new_values_are_taken_and_the_motion_is_not_disturbed() -> None:
    """Concentrations act on nothing here: a run with a reaction has the bits of one without."""
    for scene in (plain(), mixed()):
        alone, reacting = (Simulation(scene, seed=1, threads=1) for _ in range(2))

        def reaction(moment: Moment) -> dict[str, np.ndarray]:
            turned = 0.1 * moment["concentration_1"]
            return {
                "concentration_1": moment["concentration_1"] - turned,
                "concentration_2": moment["concentration_2"] + turned,
                "temperature": moment["temperature"] + 0.01 * turned,
            }

        reacting.add_callback(reaction, every=2)
        for simulation in (alone, reacting):
            simulation.run(10)
        np.testing.assert_allclose(reacting.state.concentrations[:, 0], 0.9**5 * scene.beads.concentrations[:, 0])
        total = reacting.state.concentrations.sum(axis=1)
        np.testing.assert_allclose(total, scene.beads.concentrations.sum(axis=1), rtol=1e-14)
        assert (reacting.state.temperature > alone.state.temperature).all()
        assert reacting.positions.tobytes() == alone.positions.tobytes()
        assert reacting.velocities.tobytes() == alone.velocities.tobytes()


def test_one_number_and_all_species_at_once() -> None:
    simulation = Simulation(plain(), seed=1, threads=1)
    simulation.add_callback(lambda moment: {"temperature": 3.0, "concentrations": 2.0 * moment.concentrations})
    before = simulation.state.concentrations
    simulation.run(2)
    np.testing.assert_array_equal(simulation.state.temperature, 3.0)
    np.testing.assert_array_equal(simulation.state.concentrations, 4.0 * before)


def test_rates_become_changes_over_the_interval() -> None:
    """First-order decay by Euler's rule: C (1 − k n Δt)^calls, and a source in half of the cell."""
    simulation = Simulation(plain(), seed=1, threads=1)
    start = simulation.state

    def rates(moment: Moment) -> dict[str, object]:
        assert moment.interval == pytest.approx(0.05)
        return {"concentration_1": -2.0 * moment["concentration_1"], "temperature": 0.5}

    simulation.add_callback(Source(rates), every=5)
    simulation.run(20)
    np.testing.assert_allclose(simulation.state.concentrations[:, 0], start.concentrations[:, 0] * 0.9**4, rtol=1e-14)
    np.testing.assert_allclose(simulation.state.temperature, start.temperature + 0.1, rtol=1e-13)
    np.testing.assert_array_equal(simulation.state.concentrations[:, 1], start.concentrations[:, 1])


def test_reporters_see_what_callbacks_changed() -> None:
    simulation = Simulation(plain(), seed=1, threads=1)

    class Seen:
        temperatures: list[float] = []  # noqa: RUF012

        def next_step(self, step: int) -> int:
            return step + 1

        def report(self, simulation: Simulation) -> None:
            self.temperatures.append(float(simulation.state.temperature[0]))

    simulation.reporters.append(Seen())
    simulation.add_callback(lambda moment: {"temperature": float(moment.step)}, every=2)
    simulation.run(4)
    assert Seen.temperatures[1:] == [2.0, 2.0, 4.0]


def heating(moment: Moment) -> dict[str, np.ndarray]:
    """Depends on place, speed and what is there, so that any difference shows."""
    squares = np.sum(moment.velocities**2, axis=1)
    warm = moment["temperature"] * (1.0 + 0.01 * np.tanh(moment.positions[:, 0]) + 1e-3 * squares)
    return {"temperature": warm, "concentration_1": moment["concentration_1"] * np.exp(-0.1 * warm)}


@pytest.mark.parametrize("make", [plain, mixed])
@pytest.mark.parametrize("cut", [3, 4, 6])
def test_a_restart_is_exact(tmp_path: Path, make: Callable[[], Scene], cut: int) -> None:
    """Whether the checkpoint is of a step with a call or of one between two calls."""
    whole = Simulation(make(), seed=1, threads=1)
    whole.add_callback(heating, every=3)
    first = Simulation(make(), seed=1, threads=2)
    first.add_callback(heating, every=3)
    first.run(cut)
    first.save(tmp_path / "REVIVE")
    second = Simulation.resume(tmp_path / "REVIVE", threads=1)
    second.add_callback(heating, every=3)
    whole.run(11)
    second.run(11 - cut)
    for name in ("positions", "velocities", "forces", "temperature", "concentrations"):
        assert getattr(whole.state, name).tobytes() == getattr(second.state, name).tobytes(), name


def test_a_run_with_files_and_callbacks_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    scene = carrying(pydlpoly.load(run_folder(tmp_path / "in")))
    calls = [(heating, 7)]
    run_scene(scene, tmp_path / "whole", threads=1, callbacks=calls)
    run_scene(scene, tmp_path / "parts", threads=1, callbacks=calls, steps=25)
    run_scene(scene, tmp_path / "parts", threads=1, callbacks=calls, checkpoint=tmp_path / "parts" / "REVIVE")
    for name in ("REVCON", "REVBEADS", "HISTORY", "STATIS"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parts" / name).read_bytes(), name
    start = scene.beads.concentrations[:, 0]
    assert (read_beads(tmp_path / "whole" / "REVBEADS").values[:, 1] < start).all()


def test_callbacks_that_are_missing_after_a_restart_are_named(tmp_path: Path) -> None:
    simulation = Simulation(plain(), seed=1, threads=1)
    simulation.add_callback(heating, every=3)
    simulation.save(tmp_path / "REVIVE")
    again = Simulation.resume(tmp_path / "REVIVE", threads=1)
    with pytest.warns(InputWarning, match="a run with callbacks that were not added again: heating every 3 steps"):
        again.run(1)
    again.run(1)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda _: {"tempreature": 1.0}, "'tempreature' is not carried by beads; expected temperature, "
         r"concentration_1, concentration_2; did you mean temperature\?"),
        (lambda _: {"temperature": np.ones(3)}, r"temperature must be of shape \(60,\), not \(3,\)"),
        (lambda _: {"concentrations": np.ones((60, 3))}, r"concentrations must be of shape \(60, 2\), not"),
        (lambda _: {"temperature": 0.0}, "temperature of bead 1 is 0; expected a finite temperature above 0"),
        (lambda moment: {"concentration_2": -moment["concentration_2"]}, "concentration_2 of bead 1 is -0.*; expected a"
         " finite concentration, not below 0"),
        (lambda _: {"temperature": np.inf}, "temperature of bead 1 is inf; expected a finite"),
        (lambda _: {"temperature": "warm"}, "temperature is no array of numbers"),
        (lambda _: {"concentration_1": 1.0, "concentrations": np.ones((60, 2))}, "concentration_1 is given twice"),
        (lambda _: np.ones(60), "expected None or new values by name, not <class 'numpy.ndarray'>"),
        (lambda moment: moment["salt"], "KeyError: 'salt: expected temperature"),
        (lambda _: 1 / 0, "ZeroDivisionError: division by zero"),
    ],
)  # fmt: skip
def test_errors_name_the_callback_and_the_step(function: Callable[[Moment], object], message: str) -> None:
    function.__name__ = "my_source"
    simulation = Simulation(plain(), seed=1, threads=1)
    simulation.add_callback(function, every=2)  # type: ignore[arg-type]
    before = simulation.state
    with pytest.raises(RunError, match="callback my_source at step 2: " + message):
        simulation.run(3)
    assert simulation.step == 2
    np.testing.assert_array_equal(simulation.state.temperature, before.temperature)


def test_a_scene_that_carries_nothing_has_nothing_to_change() -> None:
    simulation = Simulation(make_scene({"A": 20}, cell=3.0), seed=1, threads=1)
    simulation.add_callback(lambda _: {"temperature": 1.0})
    with pytest.raises(RunError, match="'temperature' is not carried by beads; beads carry nothing that could"):
        simulation.run(1)


@pytest.mark.parametrize("every", [0, -1, 1.5, True, "3"])
def test_intervals_that_are_none(every: object) -> None:
    with pytest.raises(ValueError, match="the interval of a callback must be 1 step or more"):
        Simulation(plain(), seed=1, threads=1).add_callback(heating, every=every)  # type: ignore[arg-type]


def test_what_is_no_function() -> None:
    with pytest.raises(ValueError, match="expected a function, not 3"):
        Simulation(plain(), seed=1, threads=1).add_callback(3)  # type: ignore[arg-type]
