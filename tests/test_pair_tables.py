"""Tabulated pair laws: the curve through a table, its force, its ends, and tables that cannot be used."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pydlpoly import _core

Floats = NDArray[np.float64]
CUTOFF = 4.0
SPACING = 0.01
PARAMETERS = {"lj": [59.1, 1.5], "mors": [101.9, 1.86, 1.2], "dpd": [11.55, 3.74], "tab": []}


def evaluate(key: str, distances: Floats | list[float], **more: object) -> tuple[Floats, Floats]:
    energy, force = _core.evaluate_pair(key, PARAMETERS[key], CUTOFF, np.asarray(distances, float), **more)
    return energy, force


def tabulate(key: str, spacing: float = SPACING, end: float = 4.1) -> Floats:
    r = spacing * np.arange(1, round(end / spacing) + 1)
    energy, force = _core.evaluate_pair(key, PARAMETERS[key], 9.0, r)
    return np.stack([energy, force * r], axis=1)


def test_table_reproduces_the_law_it_was_made_from() -> None:
    r = np.linspace(1.3, 3.99, 500)
    energy, force = evaluate("lj", r)
    error = []
    for spacing in (0.02, 0.01):
        u, f = evaluate("tab", r, table=tabulate("lj", spacing), spacing=spacing)
        assert np.abs(f - force).max() < 1e-3 * np.abs(force).max()
        error.append(np.abs(u - energy).max())
    assert error[1] < 1e-6 * np.abs(energy).max()
    assert error[0] / error[1] > 12  # fourth order in the spacing


def test_table_is_exact_at_its_nodes() -> None:
    table = tabulate("mors")
    nodes = SPACING * np.arange(1, 400)
    energy, force = evaluate("tab", nodes, table=table, spacing=SPACING)
    np.testing.assert_allclose(energy, table[:399, 0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(force * nodes, table[:399, 1], rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("force_shift", [False, True])
def test_table_force_is_minus_the_slope(force_shift: bool) -> None:
    """To rounding even for a coarse table: the steps of the differences stay within one interval."""
    table = tabulate("lj", 0.1)
    table[:9] = table[9]  # nothing below 1 Å is needed, and it would drown the rest
    r = 0.1 * (np.arange(10, 40) + 0.37)

    def energy(x: Floats) -> Floats:
        return evaluate("tab", x, table=table, spacing=0.1, force_shift=force_shift)[0]

    _, force = evaluate("tab", r, table=table, spacing=0.1, force_shift=force_shift)
    step = 1e-3
    coarse, fine = ((energy(r - h) - energy(r + h)) / (2 * h) for h in (step, step / 2))
    slope = (4 * fine - coarse) / 3  # exact for a cubic
    assert np.abs(force - slope).max() < 1e-8 * np.abs(force).max()


def test_table_goes_on_along_its_tangent_below_the_first_node() -> None:
    table = tabulate("dpd", 0.1)
    energy, force = evaluate("tab", [0.1, 0.05, 1e-9, 0.0], table=table, spacing=0.1)
    slope = table[0, 1] / 0.1
    assert force[:3] == pytest.approx(slope, rel=1e-9)
    assert force[3] == 0
    assert energy[3] == pytest.approx(table[0, 0] + 0.1 * slope, rel=1e-12)


@pytest.mark.parametrize(
    ("table", "spacing", "message"),
    [
        (None, 0.0, "values of its table are missing"),
        (np.zeros((500, 2)), 0.0, "spacing must be a positive number"),
        (np.zeros((1, 2)), 5.0, "at least two points"),
        (np.zeros((399, 2)), 0.01, "within the table, which ends at 3.99"),
        (np.full((500, 2), np.nan), 0.01, "entry 1 is not"),
        (np.zeros((500, 3)), 0.01, r"shape \(points, 2\)"),
    ],
)
def test_bad_table(table: Floats | None, spacing: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        evaluate("tab", [1.0], table=table, spacing=spacing)


def test_only_tab_takes_a_table() -> None:
    with pytest.raises(ValueError, match="lj takes no table"):
        evaluate("lj", [1.0], table=np.zeros((500, 2)), spacing=0.01)
    with pytest.raises(ValueError, match="TABLE file gives the long-range correction"):
        _core.pair_tail("tab", [], 2.5)
