"""Averages in bins against closed forms: uniform gases, imposed profiles, flows, triclinic and open cells, errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from pydlpoly.binned import BinnedMeans, Sample, bin_numbers
from pydlpoly.formats.binned_table import BinnedTable

CELL = np.diag([4.0, 6.0, 10.0])


def gas(frame: int, count: int = 400, cell: np.ndarray = CELL) -> np.ndarray:
    """(count, 3) independent places, uniform in a cell around the origin."""
    return (np.random.default_rng(frame).random((count, 3)) - 0.5) @ cell


def means_of(samples: Sequence[Sample], axes: Sequence[int], bins: Sequence[int], *names: str, **more: object):
    means = BinnedMeans(axes, bins, names, **more)  # type: ignore[arg-type]
    for sample in samples:
        means.add(sample)
    return means.table()


def test_bins_by_hand() -> None:
    places = np.array([[-2.0, 0.0, -5.0], [1.999, 0.0, 4.999], [2.0, 0.0, 5.0], [0.0, 0.0, 0.0], [7.0, 0.0, 16.0]])
    assert bin_numbers(Sample(places, CELL), (2,), (4,)).tolist() == [0, 3, 0, 2, 0]
    assert bin_numbers(Sample(places, CELL), (0, 2), (2, 4)).tolist() == [0, 7, 0, 6, 0]
    open_z = Sample(places, CELL, (True, True, False))
    assert bin_numbers(open_z, (2,), (4,)).tolist() == [0, 3, 3, 2, -1]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_uniform_gas_is_flat_within_the_stated_error(axis: int) -> None:
    """Of 40 bins, two standard errors should hold for 95 % and four for all; the mean deviation is that of the error.

    Counts of independent frames are binomial, so the error of a bin's density is known in closed form.
    """
    bins, frames, count = 40, 400, 400
    table = means_of([Sample(gas(k), CELL) for k in range(frames)], (axis,), (bins,), "number_density", "mass_density")
    density, error = table["number_density"], table.errors["number_density"]
    assert density.mean() == pytest.approx(count / 240.0, rel=1e-12)
    exact = np.sqrt(count / bins * (1 - 1 / bins) / frames) / (240.0 / bins)
    assert error.mean() == pytest.approx(exact, rel=0.5)
    pulls = (density - count / 240.0) / exact
    assert np.abs(pulls).max() < 4.0
    assert 0.6 < pulls.std() < 1.4
    assert np.abs((density - count / 240.0) / error).max() < 4.5
    np.testing.assert_array_equal(table["mass_density"], density)
    width = np.diag(CELL)[axis]
    np.testing.assert_allclose(table.centres[0], (np.arange(bins) + 0.5) * width / bins - width / 2, atol=1e-13)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_an_imposed_linear_temperature(axis: int) -> None:
    """T = 2 + s z: a bin's mean is T at its middle, with the spread of places in the bin over √n as its error."""
    samples = []
    for k in range(100):
        places = gas(k)
        samples.append(Sample(places, CELL, values={"temperature": 2.0 + 0.1 * places[:, axis]}))
    table = means_of(samples, (axis,), (20,), "temperature")
    middle = 2.0 + 0.1 * table.centres[0]
    width = np.diag(CELL)[axis] / 20
    exact = 0.1 * width / np.sqrt(12.0) / np.sqrt(100 * 400 / 20)
    assert np.abs(table["temperature"] - middle).max() < 4.0 * exact
    assert table.errors["temperature"].mean() == pytest.approx(exact, rel=0.5)


def test_axes_may_be_turned_and_exchanged() -> None:
    """Turning the axes of a configuration turns its profiles and transposes its maps."""
    places, speeds = gas(1), gas(2)
    turn = [2, 0, 1]  # new x is the old z
    one = Sample(places, CELL, velocities=speeds)
    other = Sample(places[:, turn], np.diag(np.diag(CELL)[turn]), velocities=speeds[:, turn])
    for axis in range(3):
        before = means_of([one], (turn[axis],), (10,), "number_density", "kinetic_temperature")
        after = means_of([other], (axis,), (10,), "number_density", "kinetic_temperature")
        np.testing.assert_allclose(before["number_density"], after["number_density"], rtol=1e-13)
        np.testing.assert_allclose(before["kinetic_temperature"], after["kinetic_temperature"], rtol=1e-13)
    a = means_of([one], (0, 2), (4, 5), "velocity_y", errors=False)["velocity_y"]
    b = means_of([one], (2, 0), (5, 4), "velocity_y", errors=False)["velocity_y"]
    np.testing.assert_allclose(a, b.T, rtol=1e-13)


def test_a_triclinic_cell_is_divided_along_its_vectors() -> None:
    """A turned parallelepiped: bins follow fractional places; middles are distances between faces."""
    cell = np.array([[5.0, 0.0, 0.0], [2.0, 4.0, 0.0], [1.0, -1.0, 6.0]])
    angle = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    fractions = np.random.default_rng(3).random((200_000, 3)) - 0.5
    fractions = fractions[fractions[:, 1] > 0.25]  # a slab across the second vector
    for vectors in (cell, cell @ angle):
        table = means_of([Sample(fractions @ vectors, vectors)], (1,), (8,), "number_density")
        density = table["number_density"]
        assert not density[:6].any()
        np.testing.assert_allclose(density[6:], len(fractions) / (120.0 / 4), rtol=0.02)
        width = 120.0 / np.linalg.norm(np.cross(cell[2], cell[0]))
        assert table.centres[0][-1] == pytest.approx(width * 7 / 16, rel=1e-12)


def test_beads_beyond_an_open_axis_are_counted_apart() -> None:
    places = np.array([[0.0, 0.0, 4.9], [0.0, 0.0, 5.1], [0.0, 0.0, -5.5]])
    table = means_of([Sample(places, CELL, (True, True, False))] * 2, (2,), (2,), "number_density", "mass_density")
    assert table.outside == 2.0
    assert table["number_density"].tolist() == [0.0, pytest.approx(1 / 120.0)]


def flow(place: np.ndarray) -> np.ndarray:
    """A parabola between walls at ±5."""
    return 0.3 * (25.0 - place**2)


def test_a_parabolic_flow_with_heat_on_top() -> None:
    """Two species of masses 1 and 3 at k_B T = 0.7 in a flow along x: flow and temperature, each within four errors.

    The mean of the parabola over a bin of width h is the parabola at its middle less 0.3 h²/12. The temperature of
    velocities relative to the mean flow of a bin has the flow's variance in the bin on top; both closed forms.
    """
    samples = []
    for k in range(200):
        places, random = gas(k), np.random.default_rng(1000 + k)
        masses = np.where(np.arange(400) < 150, 1.0, 3.0)
        speeds = random.normal(size=(400, 3)) * np.sqrt(0.7 / masses)[:, None]
        speeds[:, 0] += flow(places[:, 2])
        samples.append(Sample(places, CELL, masses=masses, velocities=speeds))
    names = ("velocity_x", "velocity_y", "velocity_z", "kinetic_temperature", "mass_density")
    table = means_of(samples, (2,), (40,), *names)
    place, h = table.centres[0], 10.0 / 40
    deviation = np.abs(table["velocity_x"] - (flow(place) - 0.3 * h**2 / 12))
    spread = np.sqrt((0.6 * place) ** 2 * h**2 / 12 + 0.7 / 2.25)
    assert (deviation < 4.0 * spread / np.sqrt(200 * 10 * 0.9)).all()
    assert (deviation < 6.0 * table.errors["velocity_x"]).all()
    for name in ("velocity_y", "velocity_z"):
        assert (np.abs(table[name]) < 6.0 * table.errors[name]).all()
    within = 2.25 * ((0.6 * place) ** 2 * h**2 / 12 + (0.3 * h**2) ** 2 / 180) / 3.0  # of the mean mass
    expected = 0.7 + within
    assert (np.abs(table["kinetic_temperature"] - expected) < 6.0 * table.errors["kinetic_temperature"]).all()
    assert np.abs(table["kinetic_temperature"] - expected).mean() < 0.02
    exact = 0.7 * np.sqrt(2.0 / (3 * 200 * 10))
    assert table.errors["kinetic_temperature"].mean() == pytest.approx(exact, rel=0.5)
    assert table["mass_density"].mean() == pytest.approx((150 + 250 * 3) / 240, rel=1e-12)


def test_bins_weigh_samples_by_their_beads() -> None:
    """Three beads at 1 and then one bead at 5 in the same bin: the mean is 2, not 3, whatever the masses."""
    first = Sample(np.tile([0.0, 0.0, 1.0], (3, 1)), CELL, masses=np.full(3, 2.0), values={"q": np.ones(3)})
    second = Sample(np.array([[0.0, 0.0, 1.0]]), CELL, masses=np.array([9.0]), values={"q": np.array([5.0])})
    table = means_of([first, second], (2,), (2,), "q", "number_density")
    assert np.isnan(table["q"][0])
    assert table["q"][1] == 2.0
    assert table["number_density"].tolist() == [0.0, pytest.approx(2 / 120.0)]


def test_frozen_beads_have_density_but_no_flow() -> None:
    mobile = np.array([True, False, False])
    speeds = np.array([[2.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    sample = Sample(np.zeros((3, 3)), CELL, velocities=speeds, mobile=mobile, species=np.array([0, 1, 1]))
    names = ("velocity_x", "number_density_A", "number_density_B", "kinetic_temperature")
    table = means_of([sample], (2,), (1,), *names, species=("A", "B"))
    assert [float(table[name][0]) for name in names] == pytest.approx([2.0, 1 / 240.0, 2 / 240.0, 0.0])


def test_a_cell_that_varies() -> None:
    """Beads at a quarter of the height stay in their bin, and the density is beads over the mean volume."""
    samples = [Sample(np.array([[0.0, 0.0, 0.25 * size]]), np.eye(3) * size) for size in (2.0, 4.0)]
    table = means_of(samples, (2,), (2,), "number_density")
    assert table["number_density"].tolist() == [0.0, pytest.approx(2 * 2.0 / (8.0 + 64.0))]
    assert table.centres[0].tolist() == [-0.75, 0.75]


@pytest.mark.parametrize("errors", [True, False])
def test_going_on_from_a_state(errors: bool) -> None:
    samples = [Sample(gas(k), CELL, values={"q": gas(k + 500)[:, 0]}) for k in range(70)]
    whole = means_of(samples, (0,), (6,), "q", errors=errors)
    first = BinnedMeans((0,), (6,), ("q",), errors=errors)
    for sample in samples[:33]:
        first.add(sample)
    second = BinnedMeans((0,), (6,), ("q",), errors=errors)
    second.restore(first.state())
    for sample in samples[33:]:
        second.add(sample)
    table = second.table()
    assert table["q"].tobytes() == whole["q"].tobytes()
    assert bool(table.errors) == errors
    if errors:
        assert table.errors["q"].tobytes() == whole.errors["q"].tobytes()
    other = BinnedMeans((0,), (7,), ("q",), errors=errors)
    with pytest.raises(ValueError, match="other axes, bins or quantities"):
        other.restore(first.state())


@pytest.mark.parametrize(
    ("axes", "bins"), [((), ()), ((0, 0), (2, 2)), ((0,), (0,)), ((0,), (2, 2)), ((0, 1, 2), (2, 2, 2))]
)
def test_bins_that_are_none(axes: tuple[int, ...], bins: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="one or two different axes"):
        BinnedMeans(axes, bins, ("number_density",))


def test_samples_that_lack_something() -> None:
    plain = Sample(gas(1), CELL)
    for name, what in (("velocity_x", "velocities are needed"), ("q", "'q'"), ("number_density_A", "species")):
        with pytest.raises(ValueError, match=what):
            means_of([plain], (0,), (2,), name)


def test_an_error_covers_correlated_samples() -> None:
    """Each place is seen ten times in a row: errors are √10 times those of independent samples."""
    places = [gas(k) for k in range(60)]
    alone = means_of([Sample(p, CELL) for p in places], (2,), (10,), "number_density")
    repeated = means_of([Sample(p, CELL) for p in places for _ in range(10)], (2,), (10,), "number_density")
    np.testing.assert_allclose(repeated["number_density"], alone["number_density"], rtol=1e-12)
    ratio = repeated.errors["number_density"].mean() / alone.errors["number_density"].mean()
    assert 0.7 < ratio < 1.5


def test_the_table_is_a_record() -> None:
    table = means_of([Sample(gas(1), CELL)], (0, 1), (2, 3), "number_density", errors=False)
    assert isinstance(table, BinnedTable)
    assert table.axes == ("x", "y")
    assert table["number_density"].shape == (2, 3)
    assert not table.errors
