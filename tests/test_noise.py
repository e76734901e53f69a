"""The noise of the core: Philox against published vectors, and the statistics that the DPD random force relies on.

Every sample is a pure function of its arguments, so these tests have no luck: they pass or fail once and for all. The
bounds are five standard errors of what is estimated.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray

from pydlpoly import Simulation, _core

from .scene_builder import make_scene

SAMPLES = 1_000_000
SIGMAS = 5.0
LAST_SEED = 2**64 - 1


# Known-answer vectors of the Random123 library that came with the paper of Salmon and others (2011), philox4x32-10.
@pytest.mark.parametrize(
    ("counter", "key", "words"),
    [
        ("00000000 00000000 00000000 00000000", "00000000 00000000", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
        ("ffffffff ffffffff ffffffff ffffffff", "ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
        ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0", "d16cfe09 94fdcceb 5001e420 24126ea1"),
    ],
)
def test_philox_gives_the_published_words(counter: str, key: str, words: str) -> None:
    low, high = (int(word, 16) for word in key.split())
    found = _core.philox([int(word, 16) for word in counter.split()], low | high << 32)
    assert list(found) == [int(word, 16) for word in words.split()]


def noise(
    seed: int = 1, step: int = 1, first: int = 0, count: int = SAMPLES, image: int = 0, shared: int | None = None
) -> NDArray[np.float64]:
    """ζ of ``count`` pairs: (2k, 2k+1) with k from ``first``, or (shared, k) when one bead is shared."""
    k = np.arange(first, first + count, dtype=np.uint32)
    i = np.full_like(k, shared) if shared is not None else 2 * k
    j = k if shared is not None else 2 * k + 1
    return np.asarray(_core.pair_noise(seed, step, i, j, image))


def correlation(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Mean product in standard errors of independent standard normal samples."""
    return float(np.mean(a * b) * np.sqrt(len(a)))


def test_noise_is_symmetric_in_the_two_beads() -> None:
    rng = np.random.default_rng(5)
    i, j = rng.integers(0, 2**32, size=(2, 10_000), dtype=np.uint32)
    assert np.array_equal(_core.pair_noise(9, 77, i, j), _core.pair_noise(9, 77, j, i))
    assert len(np.unique(_core.pair_noise(9, 77, i, j))) == len(i)


@pytest.mark.parametrize("seed", [0, 1, 42, 2**32, LAST_SEED])
@pytest.mark.parametrize("step", [0, 1, 2**32, 2**48 - 1])
def test_noise_has_the_moments_of_a_standard_normal(seed: int, step: int) -> None:
    sample = noise(seed, step)
    # Standard errors of the raw moments of a standard normal: sqrt(E z^2n - (E z^n)^2) for n = 1 to 4.
    for power, wanted, spread in ((1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)):
        error = (np.mean(sample**power) - wanted) * np.sqrt(SAMPLES / spread)
        assert abs(error) < SIGMAS, f"moment {power}"


def test_noise_has_the_tails_of_a_standard_normal() -> None:
    # Normal quantiles: 2 (1 - Phi(z)) of all samples lie beyond z; the count's error is its root.
    sample = np.abs(np.concatenate([noise(seed) for seed in range(5)]))
    for bound, fraction in ((1.0, 0.31731051), (2.0, 0.04550026), (3.0, 0.0026997961), (4.0, 6.3342484e-5)):
        expected = fraction * len(sample)
        assert abs(np.count_nonzero(sample > bound) - expected) < SIGMAS * np.sqrt(expected)
    assert 4.5 < sample.max() < 8.6  # Box-Muller with 52 bits ends at sqrt(2 ln 2^53) = 8.6


@pytest.mark.parametrize("bead", [0, 1, 1234, 2**32 - 1])
def test_pairs_that_share_a_bead_are_independent(bead: int) -> None:
    sample = noise(shared=bead, first=2000)
    assert abs(np.mean(sample)) * np.sqrt(SAMPLES) < SIGMAS
    for lag in range(1, 7):
        assert abs(correlation(sample[lag:], sample[:-lag])) < SIGMAS, lag
    assert abs(correlation(sample, noise(shared=bead - 1 if bead else 7, first=2000))) < SIGMAS


def test_all_pairs_of_a_cluster_are_independent() -> None:
    """The force on a bead is a sum over pairs: every two of them are uncorrelated over the steps."""
    pairs = np.array(list(combinations(range(5), 2)), dtype=np.uint32)
    steps = 20_000
    rows = np.array([_core.pair_noise(3, step, pairs[:, 0], pairs[:, 1]) for step in range(steps)])
    matrix = rows.T @ rows / steps
    off_diagonal = matrix[~np.eye(len(pairs), dtype=bool)]
    assert np.abs(off_diagonal).max() * np.sqrt(steps) < SIGMAS
    assert np.abs(np.diag(matrix) - 1.0).max() * np.sqrt(steps / 2.0) < SIGMAS


@pytest.mark.parametrize("lag", range(1, 7))
@pytest.mark.parametrize("step", [1, 1000, 2**32 - 3])
def test_steps_are_independent(step: int, lag: int) -> None:
    here, later = noise(step=step), noise(step=step + lag)
    assert abs(correlation(here, later)) < SIGMAS
    assert abs(correlation(here**2 - 1.0, later**2 - 1.0)) < 2.0 * SIGMAS  # the spread of z² - 1 is √2


@pytest.mark.parametrize(("seed", "other"), [(0, 1), (1, 2), (2**32 - 1, 2**32), (0, LAST_SEED), (5, 5 + 2**32)])
def test_neighbouring_seeds_are_independent(seed: int, other: int) -> None:
    a, b = noise(seed), noise(other)
    assert abs(correlation(a, b)) < SIGMAS
    assert abs(correlation(a[1:], b[:-1])) < SIGMAS
    # A seed must not be a shift of another one in the steps either.
    assert abs(correlation(a, noise(other, step=2))) < SIGMAS


def test_images_of_a_pair_are_independent() -> None:
    samples = [noise(image=image, count=200_000) for image in (0, 1, 2, 5, 43, 215, 255)]
    for a, b in combinations(samples, 2):
        assert abs(correlation(a, b)) < SIGMAS


def test_start_velocities_are_maxwellian_and_unlike_the_noise() -> None:
    """Components are standard normal (k_B T = m = 1) before drift and temperature are set, and uncorrelated."""
    beads = 100_000
    scene = make_scene({"A": beads}, cell=200.0)
    velocities = Simulation(scene, seed=7, threads=1).state.velocities
    other = Simulation(scene, seed=8, threads=1).state.velocities
    root = np.sqrt(beads)
    for a in range(3):
        component = velocities[:, a]
        assert abs(np.mean(component**2) - 1.0) * root < SIGMAS * np.sqrt(2.0)
        assert abs(np.mean(component**3)) * root < SIGMAS * np.sqrt(15.0)
        assert abs(np.mean(component**4) - 3.0) * root < SIGMAS * np.sqrt(96.0)
        assert abs(correlation(component[1:], component[:-1])) < SIGMAS
        assert abs(correlation(component, other[:, a])) < SIGMAS
        k = np.arange(beads, dtype=np.uint32)
        for partner in (0, 1):
            assert abs(correlation(component, _core.pair_noise(7, 0, k, np.full_like(k, partner)))) < SIGMAS
    for a, b in combinations(range(3), 2):
        assert abs(correlation(velocities[:, a], velocities[:, b])) < SIGMAS
