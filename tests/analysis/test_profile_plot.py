"""Pictures of averages in bins: what is one picture, contours where there is something to follow, empty bins."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from pydlpoly.analysis.profile_plot import draw_map, draw_profiles, grouped, map_height, to_scale
from pydlpoly.errors import InputError
from pydlpoly.formats.binned_table import BinnedTable


def plane(values: np.ndarray, wide: float = 6.0, high: float = 6.0) -> BinnedTable:
    centres = tuple(
        (np.arange(n) + 0.5) * edge / n - 0.5 * edge for n, edge in zip(values.shape, (wide, high), strict=True)
    )
    return BinnedTable("made", ("x", "z"), centres, 10, 0.0, {"temperature": values}, units={"x": "ang"})


def drawn(table: BinnedTable):
    figure = Figure()
    axes = figure.subplots()
    return figure, axes, draw_map(figure, axes, table, "temperature")


def test_contours_stand_where_the_map_has_their_value() -> None:
    """T = 1 + x/10 with noise of a bin as large as a fifth of the whole range."""
    rng = np.random.default_rng(1)
    table = plane(np.zeros((48, 48)))
    values = 1.0 + 0.1 * table.centres[0][:, None] + 0.12 * rng.standard_normal((48, 48))
    figure, axes, levels = drawn(plane(values))
    assert len(levels) >= 3
    (lines,) = [one for one in axes.collections if not one.get_rasterized()]
    for level, path in zip(levels, lines.get_paths(), strict=True):
        assert np.median(path.vertices[:, 0]) == pytest.approx(10.0 * (level - 1.0), abs=0.35)
    assert {float(one.get_text()) for one in axes.texts} == {float(f"{level:.4g}") for level in levels}
    assert axes.get_xlabel() == "x (Å)"
    assert figure.axes[1].get_xlim() == pytest.approx((values.min(), values.max()))


def test_noise_has_no_contours() -> None:
    rng = np.random.default_rng(2)
    found = [len(drawn(plane(1.0 + 0.1 * rng.standard_normal((48, 48))))[2]) for _ in range(20)]
    assert found == [0] * 20
    assert len(drawn(plane(np.full((48, 48), 2.0)))[2]) == 0
    assert len(drawn(plane(np.array([[1.0]])))[2]) == 0


def test_bins_without_beads_are_left_open() -> None:
    values = np.linspace(1.0, 2.0, 30)[:, None] * np.ones((30, 30))
    values[:10, :10] = np.nan
    _, axes, levels = drawn(plane(values))
    assert len(levels) > 0
    mesh = next(one for one in axes.collections if one.get_rasterized())
    np.testing.assert_array_equal(np.ma.getmaskarray(mesh.get_array()), np.isnan(values).T)
    assert axes.patch.get_hatch()


def test_long_maps_are_stretched() -> None:
    for wide, high, same in ((6.0, 6.0, True), (60.0, 6.0, False), (6.0, 60.0, False), (10.0, 6.0, True)):
        table = plane(np.ones((12, 12)), wide, high)
        assert to_scale(table) == same
        assert 2.5 < map_height(table) < 7.5
        assert drawn(table)[1].get_aspect() == (1.0 if same else "auto")


def test_what_belongs_together_is_one_picture() -> None:
    names = ("velocity_z", "temperature", "number_density", "concentration_a", "kinetic_temperature", "mass_density")
    more = ("number_density_A", "velocity_x", "concentration_b", "local_density", "charge")
    table = BinnedTable("made", ("x",), (np.arange(3.0),), 1, 0.0, {name: np.arange(3.0) for name in (*names, *more)})
    assert grouped(table) == {
        "density": ("number_density", "number_density_A"),
        "mass-density": ("mass_density",),
        "velocity": ("velocity_z", "velocity_x"),
        "temperature": ("temperature", "kinetic_temperature"),
        "concentration": ("concentration_a", "concentration_b"),
        "local-density": ("local_density",),
        "other": ("charge",),
    }
    assert grouped(table, ("velocity_x",)) == {"velocity": ("velocity_x",)}
    with pytest.raises(InputError, match="is not in the table"):
        grouped(table, ("velocity_y",))


def test_curves_are_told_apart_without_colours() -> None:
    names = [f"concentration_{k}" for k in "abcdef"]
    table = BinnedTable("made", ("x",), (np.arange(9.0),), 1, 0.0, {name: np.arange(9.0) for name in names})
    axes = Figure().subplots()
    draw_profiles(axes, table, names)
    looks = {(one.get_linestyle(), str(one._dash_pattern), one.get_marker()) for one in axes.get_lines()}
    assert len(looks) == 6
    assert [one.get_text() for one in axes.get_legend().get_texts()] == list("abcdef")
