"""Averages, running averages and their errors against closed forms and against the scatter of many runs."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly.drawing import columns_of, thinned
from pydlpoly.formats.blocks import BlockSums, block_means
from pydlpoly.report.series import Average, Series, average_of, change_and_chance, trend_and_chance


def series(values: np.ndarray, counted: np.ndarray | None = None) -> Series:
    times = 0.5 * np.arange(len(values))
    chosen = np.ones(len(values), dtype=bool) if counted is None else counted
    return Series("x", "x", "energy", "", times, np.asarray(values, dtype=float), chosen)


@pytest.mark.parametrize("count", [1, 7, 32, 33, 64, 65, 1000])
def test_blocks_are_those_of_the_run(count: int) -> None:
    values = np.random.default_rng(count).random((count, 2))
    sums = BlockSums(2)
    for row in values:
        sums.add(row)
    np.testing.assert_allclose(block_means(values), sums.means(), rtol=1e-12)


def test_error_of_correlated_samples() -> None:
    """x' = c x + noise: the variance of the mean is that of the samples times (1 + c)/(1 − c)/n."""
    rng, c, n, runs = np.random.default_rng(1), 0.8, 2000, 60
    noise = rng.standard_normal((runs, n))
    x = np.zeros((runs, n))
    for k in range(1, n):
        x[:, k] = c * x[:, k - 1] + noise[:, k]
    exact = np.sqrt(1.0 / (1.0 - c**2) * (1.0 + c) / (1.0 - c) / n)
    found = [average_of(row) for row in x]
    # The largest of several errors is taken, so that on the whole it is too large rather than too small.
    assert exact < np.mean([one.error for one in found]) < 1.6 * exact
    assert sum(abs(one.value) > one.chance for one in found) <= 1  # as seldom as three standard errors
    assert all(one.samples == n for one in found)


def test_ratio_and_its_error() -> None:
    """Σ values·weights/Σ weights with weights that vary by a factor of ten and go with the values."""
    rng, runs = np.random.default_rng(2), 200
    found: list[Average] = []
    for _ in range(runs):
        weights = rng.uniform(0.2, 2.0, 400)
        sums = 3.0 * weights + 0.5 * rng.standard_normal(400)
        found.append(average_of(sums / weights, weights))
    scatter = float(np.std([one.value for one in found]))
    assert np.mean([one.value for one in found]) == pytest.approx(3.0, abs=4.0 * scatter / np.sqrt(runs))
    # 0.5/(mean weight √400), and 1.2 times as much because the largest of several errors counts.
    assert scatter == pytest.approx(0.5 / 1.1 / 20.0, rel=0.2)
    assert scatter < np.mean([one.error for one in found]) < 1.5 * scatter


def test_running_average_ends_at_the_average_and_leaves_out_the_equilibration() -> None:
    values = np.random.default_rng(3).random(300) + np.where(np.arange(300) < 100, 50.0, 0.0)
    one = series(values, np.arange(300) >= 100)
    times, means, errors = one.running()
    assert len(times) == 60
    assert times[0] == 50.0
    assert (means[-1], errors[-1]) == (one.average().value, one.average().error)
    assert means[0] == values[100]
    assert np.isnan(errors[0])
    assert one.average().value == pytest.approx(values[100:].mean())
    nothing = series(values, np.zeros(300, dtype=bool))
    assert nothing.average().samples == 0
    assert len(nothing.running()[0]) == 0


def test_few_samples_and_what_is_not_finite() -> None:
    assert np.isnan(average_of(np.array([1.0, 2.0, 3.0])).error)
    assert average_of(np.array([1.0, 2.0, 3.0])).chance == np.inf
    assert average_of(np.array([1.0, np.nan, 3.0])).value == 2.0
    assert np.isfinite(average_of(np.arange(4.0)).error)


def test_changes() -> None:
    noise = 0.01 * np.random.default_rng(4).standard_normal(400)
    change, chance = change_and_chance(series(np.where(np.arange(400) < 200, 1.0, 2.0) + noise))
    assert change == pytest.approx(1.0, abs=0.005)
    assert chance < 0.01
    change, chance = trend_and_chance(series(0.5 * np.arange(400) / 400 + noise))
    assert change == pytest.approx(0.5, rel=0.06)  # between the middles of the first and the last block
    assert chance < 0.02
    assert trend_and_chance(series(noise[:5])) == (0.0, np.inf)


def test_thinned_curves_keep_their_peaks() -> None:
    x, y = np.arange(100_000.0), np.zeros(100_000)
    y[31_234], y[70_001] = 5.0, -3.0
    few, values = thinned(x, y)
    assert len(few) <= 402
    assert 5.0 in values
    assert -3.0 in values
    assert (few[0], few[-1]) == (0.0, 99_999.0)
    assert np.all(np.diff(few) > 0.0)


def test_columns_of_a_legend() -> None:
    assert columns_of(["A"], 9) == 1
    assert columns_of(["A", "B", "C"], 9) == 3
    assert columns_of(["a label of thirty letters or so"] * 3, 9) == 1
    assert columns_of(["x" * 200], 9) == 1
