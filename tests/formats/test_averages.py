"""Rolling and running averages, and their exact continuation."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly.formats.averages import RollingAverages, RunningAverages

RECORDS = np.random.default_rng(5).normal(size=(25, 4)) + 1e6


def test_rolling_averages_hold_the_last_records() -> None:
    rolling = RollingAverages(10, 4)
    np.testing.assert_array_equal(rolling.mean(), np.zeros(4))
    for taken, record in enumerate(RECORDS, 1):
        rolling.add(record)
        np.testing.assert_allclose(rolling.mean(), RECORDS[max(0, taken - 10) : taken].mean(axis=0), rtol=1e-14)


def test_running_averages_equal_the_textbook_on_numbers_far_from_zero() -> None:
    running = RunningAverages(4)
    np.testing.assert_array_equal(running.fluctuations(), np.zeros(4))
    for record in RECORDS:
        running.add(record)
    assert running.taken == 25
    np.testing.assert_allclose(running.mean(), RECORDS.mean(axis=0), rtol=1e-14)
    np.testing.assert_allclose(running.fluctuations(), RECORDS.std(axis=0), rtol=1e-9)


@pytest.mark.parametrize("kind", ["rolling", "running"])
@pytest.mark.parametrize("split", [0, 3, 10, 17])
def test_a_continued_average_has_the_same_bits(kind: str, split: int) -> None:
    whole = RollingAverages(10, 4) if kind == "rolling" else RunningAverages(4)
    for record in RECORDS[:split]:
        whole.add(record)
    state = whole.state()
    part = RollingAverages.from_state(state) if kind == "rolling" else RunningAverages.from_state(state)
    for record in RECORDS[split:]:
        whole.add(record)
        part.add(record)
    assert whole.mean().tobytes() == part.mean().tobytes()
    if isinstance(whole, RunningAverages) and isinstance(part, RunningAverages):
        assert whole.fluctuations().tobytes() == part.fluctuations().tobytes()


def test_nothing_to_average_is_refused() -> None:
    with pytest.raises(ValueError, match="must be positive, not 0 and 4"):
        RollingAverages(0, 4)
    with pytest.raises(ValueError, match="must be positive, not 0"):
        RunningAverages(0)
