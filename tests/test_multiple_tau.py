"""The multiple-tau correlator against direct sums, a series whose correlation is known, and itself after a restart."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly.reporters.multiple_tau import MultipleTau, running_integral


def filled(left: np.ndarray, right: np.ndarray | None = None, **shape: int) -> MultipleTau:
    correlator = MultipleTau(left.shape[1], **shape)
    for a, b in zip(left, left if right is None else right, strict=True):
        correlator.add(a, b)
    return correlator


def direct(left: np.ndarray, right: np.ndarray, lag: int) -> np.ndarray:
    return np.mean(left[: len(left) - lag] * right[lag:], axis=0)


def autoregressive(count: int, memory: float, seed: int = 5) -> np.ndarray:
    """x_t = φ x_{t−1} + √(1 − φ²) ξ: variance 1, autocorrelation φ^|lag|."""
    noise = np.random.default_rng(seed).normal(size=count)
    series = np.empty(count)
    series[0] = noise[0]
    for t in range(1, count):
        series[t] = memory * series[t - 1] + np.sqrt(1.0 - memory**2) * noise[t]
    return series


@pytest.mark.parametrize("count", [3, 255, 256, 257, 1000])
def test_one_level_is_the_direct_sum(count: int) -> None:
    rng = np.random.default_rng(1)
    left, right = rng.normal(size=(count, 3)), rng.normal(size=(count, 3))
    correlator = filled(left, right, points=20, levels=1, window=1)
    lags = correlator.lags()
    assert lags.tolist() == list(range(min(20, count)))
    for lag, value in zip(lags, correlator.values(), strict=True):
        np.testing.assert_allclose(value, direct(left, right, int(lag)), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize(("points", "window"), [(16, 2), (12, 3), (10, 4), (5, 5)])
def test_higher_levels_are_direct_sums_of_averages(points: int, window: int) -> None:
    series = np.random.default_rng(2).normal(size=(3001, 2))
    correlator = filled(series, points=points, levels=3, window=window)
    expected = {lag: direct(series, series, lag) for lag in range(points)}
    means = series
    for level in (1, 2):
        means = means[: len(means) // window * window].reshape(-1, window, 2).mean(axis=1)
        first = -(-points // window)
        expected |= {lag * window**level: direct(means, means, lag) for lag in range(first, points)}
    lags = correlator.lags().tolist()
    assert lags == sorted(expected)
    for lag, value in zip(lags, correlator.values(), strict=True):
        np.testing.assert_allclose(value, expected[lag], rtol=1e-12, atol=1e-13)


def test_a_constant_is_a_constant_at_all_lags() -> None:
    correlator = filled(np.full((5000, 1), 3.0), points=8, levels=6, window=2)
    np.testing.assert_allclose(correlator.values(), 9.0, rtol=1e-14)
    assert correlator.lags()[-1] == 7 * 2**5


def test_which_of_two_comes_later() -> None:
    """⟨A(t) B(t + τ)⟩ of B that follows A by three samples is 1 at a lag of 3."""
    a = np.random.default_rng(3).normal(size=(20_000, 1))
    correlator = filled(a, np.roll(a, 3, axis=0), points=8, levels=1, window=1)
    values = correlator.values()[:, 0]
    assert values[3] == pytest.approx(1.0, abs=0.05)
    assert np.abs(np.delete(values, 3)).max() < 0.05


def test_a_series_of_known_correlation() -> None:
    """AR(1) with φ = 0.9: φ^lag at level 0, its average over the window at higher ones, and the integral of both."""
    memory, count = 0.9, 60_000
    correlator = filled(autoregressive(count, memory)[:, None], points=16, levels=4, window=2)
    lags, values = correlator.lags(), correlator.values()[:, 0]
    # Standard error of a correlation of a series with itself: √(2 τ/T) at most, with Σ φ^2|k| ≈ 9.5 samples: 0.02.
    np.testing.assert_allclose(values[lags < 16], memory ** lags[lags < 16], atol=0.07)
    integral, error = correlator.integrals(1.0)
    exact = 0.5 + memory / (1.0 - memory)  # trapezoidal: half of the first, all others
    assert 0.4 < error[-1, 0] < 2.0  # 9.5 √(4·120/60 000) = 0.85
    assert abs(integral[-1, 0] - exact) < 3.5 * error[-1, 0]


def test_errors_are_as_large_as_the_scatter_of_independent_runs() -> None:
    found, errors = [], []
    for seed in range(40):
        correlator = filled(autoregressive(12_000, 0.8, seed)[:, None], points=8, levels=3, window=2)
        integral, error = correlator.integrals(1.0)
        found.append(integral[-1, 0])
        errors.append(error[-1, 0])
    assert 0.6 < np.median(errors) / np.std(found) < 1.7


def test_white_noise_integrates_to_half_a_sample() -> None:
    correlator = filled(np.random.default_rng(7).normal(size=(40_000, 4)), points=8, levels=1, window=1)
    integral, _ = correlator.integrals(0.04)
    assert integral[-1].mean() == pytest.approx(0.02, abs=0.001)


@pytest.mark.parametrize("stop", [0, 1, 255, 256, 400, 9000])
def test_a_restart_has_the_same_bits(stop: int) -> None:
    series = autoregressive(9001, 0.7)[:, None] * np.array([1.0, -2.0])
    whole = filled(series, points=6, levels=4, window=2)
    first = filled(series[:stop], points=6, levels=4, window=2)
    first.values()  # looking changes nothing
    second = MultipleTau(2, points=6, levels=4, window=2)
    second.restore(first.state())
    for sample in series[stop:]:
        second.add(sample, sample)
    for ours, theirs in zip(second.state().values(), whole.state().values(), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    np.testing.assert_array_equal(second.values(), whole.values())


def test_other_shapes_are_refused() -> None:
    with pytest.raises(ValueError, match="several levels need a window between 2 and the 8 points, not 1"):
        MultipleTau(1, points=8, levels=2, window=1)
    with pytest.raises(ValueError, match="expected at least one pair"):
        MultipleTau(1, points=1)
    with pytest.raises(ValueError, match="another shape"):
        MultipleTau(1, points=8).restore(MultipleTau(1, points=9).state())


def test_the_trapezoidal_rule() -> None:
    times = np.array([0.0, 1.0, 3.0])
    np.testing.assert_allclose(running_integral(times, np.array([[2.0], [4.0], [0.0]]))[:, 0], [0.0, 3.0, 7.0])
