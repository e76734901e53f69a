"""Displacements and velocity autocorrelations against closed forms and against sums written out."""

from __future__ import annotations

from collections.abc import Iterator
from weakref import WeakSet

import numpy as np
import pytest

from pydlpoly import InputError
from pydlpoly.analysis import (
    MeanSquareDisplacement,
    RadialDistribution,
    StructureFactor,
    VelocityAutocorrelation,
    analyse,
    frames_of_arrays,
)
from pydlpoly.analysis.windows import Spool, correlate
from pydlpoly.formats.history import Frame

CELL = np.array([[9.0, 0.0, 0.0], [2.0, 8.0, 0.0], [-1.5, 1.0, 7.0]])


def folded(places: np.ndarray, cell: np.ndarray) -> np.ndarray:
    inside = places @ np.linalg.inv(cell)
    return (inside - np.floor(inside + 0.5)) @ cell


def walk(frames: int, beads: int, step: float, seed: int) -> np.ndarray:
    return np.cumsum(np.random.default_rng(seed).normal(0.0, step, (frames, beads, 3)), axis=0)


@pytest.mark.parametrize("squared_differences", [True, False])
@pytest.mark.parametrize(("frames", "lags"), [(40, 10), (40, 39), (7, 3), (64, 60), (3, 1)])
def test_windows_are_the_sums_written_out(frames: int, lags: int, squared_differences: bool) -> None:
    vectors = walk(frames, 5, 1.0, 3) + 100.0
    spool = Spool()
    for one in vectors:
        spool.append(one)
    chosen = np.array([0, 2, 3])
    found = correlate(spool, chosen, lags, squared_differences=squared_differences)
    x = vectors[:, chosen]
    for lag in range(lags + 1):
        first, later = x[: frames - lag], x[lag:]
        product = (later - first) ** 2 if squared_differences else first * later
        expected = product.sum(axis=2).mean()
        assert found.value[lag] == pytest.approx(expected, rel=1e-9, abs=1e-8)
    assert found.deviations.mean(axis=0) == pytest.approx(np.zeros(lags + 1), abs=1e-8)


def test_random_walk_has_its_diffusion_coefficient() -> None:
    """Steps of variance 2 D Δt along each axis: MSD = 6 D t, followed across the faces of a triclinic cell."""
    spacing, exact = 0.5, 0.3
    places = walk(800, 200, np.sqrt(2 * exact * spacing), 7)
    frames = frames_of_arrays(folded(places, CELL), CELL, times=spacing * np.arange(800))
    found = MeanSquareDisplacement(longest=20.0, fit=(2.0, 10.0)).of(frames)
    assert (found.times[1], found.times[-1], found.fit) == (0.5, 20.0, (2.0, 10.0))
    assert found.msd[0, 1] == pytest.approx(6 * exact * spacing, rel=0.01)
    assert abs(found.diffusion[0] - exact) < 3.5 * found.diffusion_error[0]
    # One bead's slope over windows of 10 out of 400 is good to about √(2/3 · 10/400): ± 0.003 with 200 beads.
    assert 0.0005 < found.diffusion_error[0] < 0.01
    pull = (found.msd[0, 1:] - 6 * exact * found.times[1:]) / found.error[0, 1:]
    assert np.abs(pull).max() < 4.0


def test_error_of_the_diffusion_coefficient_is_honest() -> None:
    """Spread over 24 independent walks against the mean error stated."""
    values, errors = [], []
    for seed in range(24):
        frames = frames_of_arrays(walk(256, 30, 1.0, 100 + seed), times=np.arange(256.0))
        found = MeanSquareDisplacement(longest=16.0).of(frames)
        values.append(found.diffusion[0])
        errors.append(found.diffusion_error[0])
    assert np.mean(values) == pytest.approx(0.5, abs=4 * np.std(values) / np.sqrt(24))
    assert 0.6 < np.mean(errors) / np.std(values, ddof=1) < 1.7


def test_ballistic_motion() -> None:
    """MSD = v² t² exactly, by species; D of a line through part of it is the line's."""
    rng = np.random.default_rng(2)
    velocities = rng.normal(size=(50, 3))
    velocities[20:] *= 2.0
    times = 0.1 * np.arange(60)
    places = rng.random((50, 3)) + times[:, None, None] * velocities
    names = ["A"] * 20 + ["B"] * 30
    moving = np.broadcast_to(velocities, places.shape)
    frames = list(
        frames_of_arrays(folded(places, CELL), CELL, species=names, times=times, velocities=moving),
    )
    found = MeanSquareDisplacement().of(frames)
    assert found.species == ("A", "B")
    for k, part in enumerate((velocities[:20], velocities[20:])):
        square = np.mean(np.sum(part**2, axis=1))
        np.testing.assert_allclose(found.msd[k], square * found.times**2, rtol=1e-9, atol=1e-9)
    correlation = VelocityAutocorrelation().of(frames)
    np.testing.assert_allclose(correlation.values, 1.0, rtol=1e-12)
    np.testing.assert_allclose(correlation.diffusion[0], correlation.at_origin[0] * found.times / 3.0, rtol=1e-12)


def test_displacements_in_a_cell_that_breathes() -> None:
    """Beads that keep their fractions of the cell have not moved, however often the cell pulses."""
    cells = CELL * (1.0 + 0.2 * np.sin(np.arange(50)))[:, None, None]
    inside = np.random.default_rng(1).random((30, 3)) - 0.5
    places = np.einsum("nx,fxy->fny", inside, cells)
    found = MeanSquareDisplacement().of(frames_of_arrays(places, cells))
    assert np.abs(found.msd).max() < 1e-20


def test_velocities_of_langevin_beads() -> None:
    """An Ornstein-Uhlenbeck process with rate γ: Z = exp(−γ t), D = k_B T/(m γ) (1 − exp(−γ t))."""
    rate, spacing, frames, beads = 2.0, 0.05, 2000, 150
    keep = np.exp(-rate * spacing)
    rng = np.random.default_rng(5)
    velocities = np.empty((frames, beads, 3))
    velocities[0] = rng.normal(size=(beads, 3))
    for k in range(1, frames):
        velocities[k] = keep * velocities[k - 1] + np.sqrt(1 - keep**2) * rng.normal(size=(beads, 3))
    made = frames_of_arrays(np.zeros((frames, beads, 3)), velocities=velocities, times=spacing * np.arange(frames))
    found = VelocityAutocorrelation(longest=2.0).of(made)
    pull = (found.values[0, 1:] - np.exp(-rate * found.times[1:])) / found.error[0, 1:]
    assert np.abs(pull).max() < 4.0
    assert found.error[0].max() < 0.01
    assert found.at_origin[0] == pytest.approx(3.0, rel=0.02)
    whole = 0.5 * spacing * (1 + keep) / (1 - keep) * (1 - np.exp(-rate * 2.0))  # the sum, for the trapezoidal rule
    assert abs(found.diffusion[0, -1] - whole) < 3.5 * found.diffusion_error[0, -1]
    assert found.diffusion_error[0, -1] < 0.02


def test_frames_are_not_kept() -> None:
    """Of 60 frames that pass by, an analysis holds the first at most."""
    alive: WeakSet[Frame] = WeakSet()
    most = 0

    def watched() -> Iterator[Frame]:
        nonlocal most
        moving = np.ones((60, 20, 3))
        places = np.random.default_rng(1).random((60, 20, 3))
        for frame in frames_of_arrays(places, 3.0, velocities=moving):
            alive.add(frame)
            most = max(most, len(alive))
            yield frame

    analyses = [
        MeanSquareDisplacement(),
        VelocityAutocorrelation(),
        RadialDistribution(bin_width=0.5),
        StructureFactor(),
    ]
    assert analyse(watched(), *analyses) == 60
    assert most <= 4
    assert analyses[0].result().msd.shape == (1, 16)


def test_what_cannot_be_analysed_is_refused() -> None:
    places = np.zeros((6, 4, 3))
    with pytest.raises(InputError, match="even intervals"):
        MeanSquareDisplacement().of(frames_of_arrays(places, times=[0, 1, 2, 3, 4, 6]))
    with pytest.raises(InputError, match="at least two frames"):
        MeanSquareDisplacement().of(frames_of_arrays(places[:1]))
    with pytest.raises(InputError, match="no velocities; traj_key pos-vel"):
        VelocityAutocorrelation().of(frames_of_arrays(places))
    with pytest.raises(InputError, match="fewer than two of the times"):
        MeanSquareDisplacement(longest=4.0, fit=(3.6, 3.9)).of(frames_of_arrays(places))
    with pytest.raises(InputError, match="4 beads after 3"):
        MeanSquareDisplacement().of([*frames_of_arrays(places[:1, :3]), *frames_of_arrays(places)])
