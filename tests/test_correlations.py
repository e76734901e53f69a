"""Correlations of the stress: against direct sums of a run's own series, the viscosity of water, COR, restarts."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from pydlpoly import Simulation, load
from pydlpoly.errors import InputError, SceneError
from pydlpoly.formats.blocks import standard_error
from pydlpoly.formats.cor import Correlation, Derived, write_correlations
from pydlpoly.formats.cor import read_cor as read_cor_file
from pydlpoly.reporters import StressCorrelations
from pydlpoly.reporters.stress_correlations import has_pair_noise
from pydlpoly.runner import run_scene
from pydlpoly.scene.model import CorrelationPlan, CorrelationTerm

from .run_folders import run_folder
from .scene_builder import make_scene

WATER = ("A A dpd 25.0 1.0 4.5",)
CORRELATED = {
    "correlation_observable": "[ s_xy-s_xy stress_xx-s_yy s_yz-s_yz ]",
    "correlation_block_points": "[ 8 6 8 ]",
    "correlation_blocks": "[ 2 1 2 ]",
    "correlation_window": "[ 2 1 2 ]",
    "time_run": "40 steps",
}


class Series:
    """A reporter that keeps the stress of every step."""

    def __init__(self) -> None:
        self.stress: list[np.ndarray] = []
        self.temperatures: list[float] = []

    def next_step(self, step: int) -> int:
        return step + 1

    def report(self, simulation: Simulation) -> None:
        self.stress.append(simulation.observe().stress)
        self.temperatures.append(simulation.temperature)


def test_correlations_are_those_of_the_run_s_own_stress() -> None:
    simulation = Simulation(make_scene({"A": 200}, WATER, cell=4.0, control={"timestep": "0.03 internal_t"}), seed=3)
    terms = (
        CorrelationTerm((0, 1), (0, 1), 20),
        CorrelationTerm((0, 0), (1, 1), 20),
        CorrelationTerm((1, 2), (1, 2), 20),
    )
    correlations, series = StressCorrelations(simulation, terms), Series()
    simulation.reporters += [correlations, series]
    simulation.run(300)
    stress = np.array(series.stress)
    for k, term in enumerate(terms):
        times, values = correlations.correlation(k)
        np.testing.assert_allclose(times, 0.03 * np.arange(20))
        left, right = stress[(slice(None), *term.left)], stress[(slice(None), *term.right)]
        direct = [np.mean(left[: 300 - lag] * right[lag:]) for lag in range(20)]
        np.testing.assert_allclose(values, direct, rtol=1e-10)
    # η = V/(k_B T) Δt (½ C_0 + C_1 + … + ½ C_19), the mean of xy and yz.
    found = correlations.viscosity()
    assert found is not None
    shear = 0.5 * (correlations.correlation(0)[1] + correlations.correlation(2)[1])
    expected = 64.0 / np.mean(series.temperatures) * 0.03 * (shear.sum() - 0.5 * (shear[0] + shear[-1]))
    assert found.value == pytest.approx(expected, rel=1e-9)
    assert found.samples == 300


def test_the_einstein_sum_is_the_integral() -> None:
    """⟨(Σ σ)²⟩ of windows of n samples is the sum of C over ±lags with weights n − lag: momentum that was carried."""
    simulation = Simulation(make_scene({"A": 200}, WATER, cell=4.0, control={"timestep": "0.03 internal_t"}), seed=3)
    correlations, series = StressCorrelations(simulation, [CorrelationTerm((0, 1), (0, 1), 10)]), Series()
    simulation.reporters += [correlations, series]
    simulation.run(4000)
    xy = np.array(series.stress)[:, 0, 1]
    carried = np.convolve(xy, np.ones(10), mode="valid")
    weights = 10.0 - np.arange(10)
    values = correlations.correlation()[1]
    assert np.mean(carried**2) == pytest.approx(2.0 * (weights @ values) - 10.0 * values[0], rel=5e-3)


@pytest.mark.parametrize(
    "order", [pytest.param("mdvv", marks=pytest.mark.slow), pytest.param("first", marks=pytest.mark.long)]
)
def test_viscosity_of_dpd_water(order: str) -> None:
    """0.84 ± 0.05 at ρ = 3, A = 25, γ = 4.5, k_B T = 1 (0.80 to 0.88 in print).

    60 000 steps of 0.04 and lags up to 1.2, where the integral has levelled off: relative error
    √(2 · 1.2/(3 · 2400)) = 1.8 % of the three shears' mean, some more from the noise's own fluctuations.
    """
    control = {"timestep": "0.04 internal_t", "ensemble_dpd_order": order}
    simulation = Simulation(make_scene({"A": 648}, WATER, cell=6.0, control=control), seed=12)
    simulation.run(500)
    terms = [CorrelationTerm(place, place, 32) for place in ((0, 1), (0, 2), (1, 2))]
    correlations = StressCorrelations(simulation, terms)
    simulation.reporters.append(correlations)
    simulation.run(60_000)
    found = correlations.viscosity()
    assert found is not None
    assert 0.01 < found.error < 0.05
    assert abs(found.value - 0.84) < max(3.0 * found.error, 0.05)
    # The half step at t = 0, most of it the noise's own, is a third of the whole: neither none nor twice would do.
    _, values = correlations.correlation()
    assert 0.2 < 0.5 * 0.04 * values[0] * 216.0 < 0.35


def test_half_a_step_of_noise_is_the_viscosity_of_drag() -> None:
    """Without repulsion g(r) = 1, and V/(k_B T) ½ Δt ⟨σ_R²⟩ = 2πγρ²r_c⁵/1575 (Groot and Warren 1997), here 0.1616.

    1200 steps of three shears that are independent: error √(2/3600) = 2.4 %.
    """
    scene = make_scene({"A": 375}, ("A A dpd 0.0 1.0 4.5",), cell=5.0, control={"timestep": "0.02 internal_t"})
    simulation = Simulation(scene, seed=5)
    squares = []
    for _ in range(1200):
        simulation.run(1)
        noise = simulation.observe().stress_parts["noise"]
        squares.append([noise[0, 1] ** 2, noise[0, 2] ** 2, noise[1, 2] ** 2])
    found = 125.0 * 0.5 * 0.02 * np.mean(squares)
    assert found == pytest.approx(2.0 * np.pi * 4.5 * 9.0 / 1575.0, rel=0.08)


def test_noise_needs_every_step() -> None:
    scene = make_scene({"A": 100}, WATER, cell=3.5)
    simulation = Simulation(scene, seed=3)
    often, seldom = StressCorrelations(simulation), StressCorrelations(simulation, every=2)
    simulation.reporters += [often, seldom]
    simulation.run(50)
    assert often.viscosity() is not None
    assert (seldom.viscosity(), seldom.samples) == (None, 25)
    assert seldom.correlation()[0][1] == pytest.approx(2 * scene.dynamics.timestep)
    assert has_pair_noise(scene)
    assert not has_pair_noise(make_scene({"A": 10}, ("A A dpd 25.0 1.0",), cell=3.0, control={
        "ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None}))  # fmt: skip


def test_without_conserved_momentum_there_is_no_viscosity() -> None:
    control = {"ensemble_method": "langevin", "ensemble_dpd_order": None, "ensemble_thermostat_friction": "1 dpd_t^-1"}
    simulation = Simulation(make_scene({"A": 50}, ("A A dpd 25.0 1.0",), cell=3.0, control=control), seed=3)
    correlations = StressCorrelations(simulation)
    simulation.reporters.append(correlations)
    simulation.run(20)
    assert (correlations.viscosity(), correlations.samples, correlations.estimates()) == (None, 20, [])


def test_only_shears_give_a_viscosity() -> None:
    simulation = Simulation(make_scene({"A": 100}, WATER, cell=3.5), seed=3)
    correlations = StressCorrelations(simulation, [CorrelationTerm((0, 0), (1, 1), 5)])
    simulation.reporters.append(correlations)
    simulation.run(20)
    assert correlations.viscosity() is None
    with pytest.raises(ValueError, match="needs a shear component"):
        correlations.green_kubo()


# --- CONTROL, files, restarts -----------------------------------------------------------------------------------------


def read_cor(path: Path) -> dict[str, dict[str, list[float]]]:
    """The lists of COR by name, without a YAML reader."""
    text = path.read_text()
    assert text.startswith("%YAML 1.2\n---\ntitle: 'test run'\n")
    found = {}
    for name, block in re.findall(r"^      (stress_\S+):\n((?: {12}.*\n)+)", text, re.MULTILINE):
        lists = re.findall(r"^ {12}(lags|value): (\[.*\])$", block, re.MULTILINE)
        found[name] = {key: json.loads(numbers) for key, numbers in lists}
    return found


def test_control_says_what_is_correlated(tmp_path: Path) -> None:
    scene = load(run_folder(tmp_path / "in", CORRELATED))
    assert scene.output.correlations == CorrelationPlan(
        (
            CorrelationTerm((0, 1), (0, 1), 8, 2, 2),
            CorrelationTerm((0, 0), (1, 1), 6, 1, 1),
            CorrelationTerm((1, 2), (1, 2), 8, 2, 2),
        )
    )
    told = " ".join(scene.explain().split())
    assert "COR: every step, correlations of the stress (stress_xy-stress_xy, stress_xx-stress_yy, stress_yz" in told
    result = run_scene(scene, tmp_path / "out", seed=1)
    read = read_cor(tmp_path / "out" / "COR")
    assert list(read) == ["stress_xy-stress_xy", "stress_xx-stress_yy", "stress_yz-stress_yz"]
    assert read["stress_xy-stress_xy"]["lags"] == pytest.approx([*(0.01 * k for k in range(8)), 0.08, 0.1, 0.12, 0.14])
    correlations = next(r for r in result.simulation.reporters if isinstance(r, StressCorrelations))
    assert read["stress_xx-stress_yy"]["value"] == pytest.approx(correlations.correlation(1)[1].tolist(), rel=1e-8)
    text = (tmp_path / "out" / "COR").read_text()
    assert re.search(r"viscosity:\n {12}value: \S+\n {12}components: \[ \S+, \S+ \]\n {12}units: reduced\n", text)
    assert "kinematic-viscosity:" in text
    assert re.search(r"From the stress.*\n  viscosity ", (tmp_path / "out" / "OUTPUT").read_text())


def test_cor_reads_as_yaml(tmp_path: Path) -> None:
    one = Correlation("stress_xy-stress_xy", 3, 1, 1, np.array([0.0, 0.1]), np.array([2.0, -1e-30]))
    write_correlations(
        tmp_path / "COR", "it's", [one], [Derived("viscosity", 0.5, [0.4, 0.6], "katm ps", float("nan"))]
    )
    read = yaml.safe_load((tmp_path / "COR").read_text())
    assert read["title"] == "it's"
    assert read["correlations"]["stress_xy-stress_xy"]["parameters"]["points_per_block"] == 3
    assert [float(x) for x in read["correlations"]["stress_xy-stress_xy"]["value"]] == [2.0, -1e-30]
    assert float(read["observables"]["viscosity"]["value"]) == 0.5


def test_errors_are_those_of_blocks_of_time(tmp_path: Path) -> None:
    """COR has them as soon as there are four blocks, of 256 samples each."""
    simulation = Simulation(make_scene({"A": 100}, WATER, cell=3.5), seed=3)
    correlations = StressCorrelations(simulation, [CorrelationTerm((0, 1), (0, 1), 4)], path=tmp_path / "COR")
    simulation.reporters.append(correlations)
    simulation.run(600)
    correlations.sync()
    assert "error" not in (tmp_path / "COR").read_text().split("correlations:")[1]
    assert np.isnan(correlations.correlation_error()).all()
    simulation.run(500)
    correlations.sync()
    table = read_cor_file(tmp_path / "COR")
    np.testing.assert_allclose(table.correlations[0].errors, correlations.correlation_error(), rtol=1e-8)
    blocks = correlations._place(correlations.terms[0])[0].block_values()[:, :, 0]
    assert len(blocks) == 4
    expected = [standard_error(column) for column in blocks.T]
    np.testing.assert_allclose(correlations.correlation_error(), expected, rtol=1e-12)


def test_a_run_that_continues_has_the_same_correlations(tmp_path: Path) -> None:
    scene = load(run_folder(tmp_path / "in", CORRELATED))
    run_scene(scene, tmp_path / "one", seed=1, threads=2)
    run_scene(scene, tmp_path / "two", seed=1, steps=17, threads=1)
    run_scene(scene, tmp_path / "two", checkpoint=tmp_path / "two" / "REVIVE", threads=2)
    assert (tmp_path / "one" / "COR").read_bytes() == (tmp_path / "two" / "COR").read_bytes()
    changed = {**CORRELATED, "correlation_block_points": "[ 9 ]", "time_run": "60 steps"}
    with pytest.raises(InputError, match="the checkpoint holds correlations that cannot go on"):
        run_scene(load(run_folder(tmp_path / "new", changed)), tmp_path / "two", checkpoint=tmp_path / "two" / "REVIVE")


def test_equilibration_is_left_out(tmp_path: Path) -> None:
    settings = {**CORRELATED, "time_equilibration": "30 steps"}
    result = run_scene(load(run_folder(tmp_path / "in", settings)), tmp_path / "out", seed=1)
    assert next(r for r in result.simulation.reporters if isinstance(r, StressCorrelations)).samples == 10


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"correlation_observable": "[ v_x-v_x ]"}, "'v_x-v_x' is not correlated: expected two components of"),
        ({"correlation_observable": "[ s_xy ]"}, "'s_xy' is not correlated"),
        ({"correlation_observable": "[ s_xw-s_xy ]"}, "'s_xw-s_xy' is not correlated"),
        ({"correlation_observable": "[ s_xy-s_xy stress_xy-s_xy ]", "correlation_blocks": "[ 1 ]"}, "given twice"),
        ({"correlation_block_points": "[ 1 ]"}, "correlation_block_points.*at least 2 points, found 1"),
        ({"correlation_window": "[ 1 ]"}, "correlation_window.*several blocks need a window between 2 and the 8"),
        ({"correlation_blocks": "[ 0 ]"}, "correlation_blocks.*whole numbers larger than 0"),
        ({"correlation_update_frequency": "[ 1 2 ]"}, "correlation_update_frequency.*expected equal intervals"),
    ],
)  # fmt: skip
def test_what_cannot_be_correlated_is_refused_by_name(tmp_path: Path, settings: dict[str, str], told: str) -> None:
    if "given twice" in told:
        settings = {**settings, "correlation_block_points": "[ 8 ]", "correlation_window": "[ 1 ]"}
    with pytest.raises((SceneError, InputError), match=told):
        load(run_folder(tmp_path / "in", {**CORRELATED, **settings}))


def test_longer_intervals_are_noted(tmp_path: Path) -> None:
    scene = load(run_folder(tmp_path / "in", {**CORRELATED, "correlation_update_frequency": "[ 5 ]"}))
    assert any("with noise of pairs no viscosity follows" in note.text for note in scene.notes)
