"""Averages over blocks: what is kept, and whether the errors are true for samples that are correlated."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from pydlpoly.formats.blocks import (
    BlockSums,
    beyond_chance,
    line_through,
    standard_error,
    standard_errors,
    three_of,
)


@pytest.mark.parametrize("count", [1, 31, 32, 33, 64, 65, 1000])
def test_means_and_blocks(count: int) -> None:
    samples = np.random.default_rng(1).normal(5.0, 1.0, (count, 2))
    sums = BlockSums(2)
    for sample in samples:
        sums.add(sample)
    np.testing.assert_allclose(sums.mean(), samples.mean(axis=0), rtol=1e-13)
    blocks = sums.means()
    length = max(1, 2 ** max(0, math.ceil(math.log2(count / 32))))
    assert len(blocks) == count // length <= 32
    expected = samples[: len(blocks) * length].reshape(-1, length, 2).mean(axis=1)
    np.testing.assert_allclose(blocks, expected, rtol=1e-13)
    assert sums.estimate(1).samples == count


@pytest.mark.parametrize("cut", [0, 5, 32, 70])
def test_a_state_goes_on_with_the_same_bits(cut: int) -> None:
    samples = np.random.default_rng(2).normal(size=(150, 3))
    whole, first = BlockSums(3), BlockSums(3)
    for sample in samples[:cut]:
        first.add(sample)
    rest = BlockSums(3)
    rest.restore(first.state())
    for k, sample in enumerate(samples):
        whole.add(sample)
        if k >= cut:
            rest.add(sample)
    assert (whole.means() == rest.means()).all()
    assert (whole.mean() == rest.mean()).all()
    with pytest.raises(ValueError, match="expected 2 quantities"):
        BlockSums(2).restore(first.state())


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("count", [25, 400])
def test_errors_are_those_of_repeated_runs(memory: float, count: int) -> None:
    """A series in which each value remembers the last one: the spread of the means against the errors given."""
    rng = np.random.default_rng(3)
    means, errors = [], []
    for _ in range(400):
        noise = rng.normal(size=count + 200)
        value, series = 0.0, []
        for x in noise:
            value = memory * value + math.sqrt(1.0 - memory**2) * x
            series.append(value)
        sums = BlockSums(1)
        for x in series[200:]:
            sums.add([x])
        means.append(sums.mean()[0])
        errors.append(sums.estimate(0).error)
    ratio = math.sqrt(np.mean(np.square(errors))) / np.std(means)
    # 25 samples that remember 20 of them hold hardly more than one independent value; the error is then too small.
    assert (0.5 if (memory, count) == (0.9, 25) else 0.85) < ratio < 1.35


def test_slope_and_its_error() -> None:
    rng = np.random.default_rng(4)
    times = np.arange(20.0)
    found = np.array([line_through(times, 0.3 * times + rng.normal(size=20)) for _ in range(1000)])
    assert np.mean(found[:, 0]) == pytest.approx(0.3, abs=0.004)
    assert np.std(found[:, 0]) == pytest.approx(math.sqrt(np.mean(found[:, 1] ** 2)), rel=0.25)
    slope, error = line_through(times, 2.0 * times)
    assert (slope, error) == (pytest.approx(2.0), pytest.approx(0.0, abs=1e-12))


def test_few_blocks_have_no_error() -> None:
    assert math.isnan(standard_error(np.arange(3.0)))
    assert all(math.isnan(x) for x in line_through(np.arange(3.0), np.arange(3.0)))
    assert standard_error(np.ones(5)) == 0.0
    assert BlockSums(1).mean().tolist() == [0.0]


@pytest.mark.parametrize("freedom", [3, 5, 9, 19, 31])
def test_three_errors_are_student_s(freedom: int) -> None:
    assert three_of(freedom) == pytest.approx(stats.t.isf(stats.norm.sf(3.0), freedom), rel=0.1)


def test_chance() -> None:
    """Of series without a mean hardly any seems to have one; three times their scatter is always seen."""
    rng = np.random.default_rng(6)
    series = rng.normal(size=(1000, 24))
    assert sum(abs(np.mean(x)) > beyond_chance(x) for x in series) <= 5
    assert all(np.mean(x + 3.0) > beyond_chance(x) for x in series[:100])
    assert math.isnan(beyond_chance(np.arange(3.0)))


@pytest.mark.parametrize("count", [0, 3, 4, 7, 8, 9, 15, 16, 31, 32])
def test_errors_of_many_series_are_those_of_each(count: int) -> None:
    blocks = np.cumsum(np.random.default_rng(3).normal(size=(count, 40)), axis=0)  # strongly correlated
    blocks[:, :20] = np.random.default_rng(4).normal(size=(count, 20))
    blocks[:, 5] = 2.5
    blocks[:, 6] = np.nan
    expected = [standard_error(series) for series in blocks.T]
    np.testing.assert_allclose(standard_errors(blocks), expected, rtol=1e-12)
