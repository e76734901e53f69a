"""Figures of PROFILE, MAP, COR and of what beads carry, against the files themselves by arithmetic of their own."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import Simulation
from pydlpoly.drawing import by_lightness
from pydlpoly.formats.config import read_config
from pydlpoly.formats.statis import read_statistics
from pydlpoly.report import collect_run, judge_run
from pydlpoly.report.collect import Run
from pydlpoly.report.figures import draw, figures_of
from pydlpoly.report.picture import _axes_of_view
from pydlpoly.report.style import Drawing

from .test_report import figures

EVERY = [
    *("last", "start", "last-temperature", "last-concentration_sugar", "last-concentration_salt"),
    *("temperature", "pressure", "energy", "internal-temperature", "conserved", "species", "momentum", "rdf"),
    *("profile-density", "profile-velocity", "profile-temperature", "profile-concentration"),
    *("map-number_density", "map-number_density_A", "map-number_density_B"),
    *("map-velocity_x", "map-velocity_y", "map-velocity_z", "map-kinetic_temperature", "map-temperature"),
    *("map-concentration_sugar", "map-concentration_salt"),
    *("stress-relaxation", "viscosity", "correlations", "msd", "speed", "time"),
]


@pytest.fixture(scope="module")
def folder(reports) -> Path:
    return reports("carried").folder


@pytest.fixture(scope="module")
def run(folder: Path) -> Run:
    return collect_run(folder)


def drawing(run: Run, name: str) -> Drawing:
    found = draw(run, name)
    assert found is not None, name
    return found


def columns(path: Path, head: int) -> dict[str, np.ndarray]:
    """Columns by the names in header line ``head``, counted from 0."""
    names = path.read_text().splitlines()[head].lstrip("#").split()
    return dict(zip((name.split("[")[0] for name in names), np.loadtxt(path).T, strict=True))


def curves(found: Drawing, panel: int = 0) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    lines = found.figure.axes[panel].get_lines()
    return {str(one.get_label()): (np.asarray(one.get_xdata()), np.asarray(one.get_ydata())) for one in lines}


def bands(found: Drawing) -> list[np.ndarray]:
    """Corners of the bands, (n, 2) each."""
    return [one.get_paths()[0].vertices for one in found.figure.axes[0].collections]


def test_every_figure_is_on_the_page_and_the_page_is_small(reports) -> None:
    report = reports("carried")
    assert figures(report.html) == EVERY
    assert len(report.html) < 2_000_000
    # Masses are all alike: the mass density would be the number density once more.
    assert "profile-mass-density" not in report.html


def test_profiles_are_those_of_the_file(folder: Path, run: Run) -> None:
    table = columns(folder / "PROFILE", 3)
    density = drawing(run, "profile-density")
    found = curves(density)
    for label, name in (("all beads", "number_density"), ("A", "number_density_A"), ("B", "number_density_B")):
        np.testing.assert_array_equal(found[label][0], table["x"])
        np.testing.assert_array_equal(found[label][1], table[name])
    assert len(bands(density)) == 3
    for band, name in zip(bands(density), ("number_density", "number_density_A", "number_density_B"), strict=True):
        edges = table[name] + table[name + "_error"], table[name] - table[name + "_error"]
        assert band[:, 1].max() == pytest.approx(edges[0].max())
        assert band[:, 1].min() == pytest.approx(edges[1].min())
    low, high = table["number_density_B"].min(), table["number_density_B"].max()
    assert f"B {low:.4g} to {high:.4g}" in density.caption
    assert "30 samples" in density.caption
    # 160 beads in 64 volumes, and a bin is an eighth of the cell.
    assert found["all beads"][1].mean() == pytest.approx(160 / 64)
    assert density.table is not None
    assert float(density.table.rows[0][1]) == pytest.approx(table["number_density"][0], rel=1e-4)
    warm = curves(drawing(run, "profile-temperature"))
    np.testing.assert_array_equal(warm["kinetic"][1], table["kinetic_temperature"])
    np.testing.assert_array_equal(warm["internal"][1], table["temperature"])
    flow = curves(drawing(run, "profile-velocity"))
    for axis in "xyz":
        np.testing.assert_array_equal(flow[axis][1], table[f"velocity_{axis}"])
    amounts = curves(drawing(run, "profile-concentration"))
    np.testing.assert_array_equal(amounts["sugar"][1], table["concentration_sugar"])
    assert amounts["sugar"][1][:4].mean() > amounts["sugar"][1][4:].mean()  # it started in one half


@pytest.mark.parametrize("name", [one.removeprefix("map-") for one in EVERY if one.startswith("map-")])
def test_maps_are_those_of_the_file(folder: Path, run: Run, name: str) -> None:
    table = columns(folder / "MAP", 3)
    found = drawing(run, f"map-{name}")
    axes = found.figure.axes[0]
    (mesh,) = [one for one in axes.collections if one.get_rasterized()]
    np.testing.assert_array_equal(np.asarray(mesh.get_array()), table[name].reshape(6, 5).T)
    corners = mesh.get_coordinates()
    np.testing.assert_allclose(corners[0, :, 0], np.linspace(-2.0, 2.0, 7), atol=1e-9)  # x to the right
    np.testing.assert_allclose(corners[:, 0, 1], np.linspace(-2.0, 2.0, 6), atol=1e-9)  # z upwards
    assert f"{table[name].min():.4g} to {table[name].max():.4g}" in found.caption
    where = int(np.argmax(table[name]))
    assert found.table is not None
    told = f"{table[name][where]:.5g} at ({table['x'][where]:.3g}, {table['z'][where]:.3g})"
    assert found.table.rows[0][-1] == told
    # A contour's value lies between lowest and highest; labels say it without colours.
    levels = [float(one.get_text().replace("−", "-")) for one in axes.texts]
    assert all(table[name].min() < level < table[name].max() for level in levels)
    assert ("Lines are contours" in found.caption) == any(len(c.get_paths()) for c in axes.collections if c is not mesh)
    bar = found.figure.axes[1]
    assert bar.get_xlim() == pytest.approx((table[name].min(), table[name].max()))


def test_shades_get_darker_with_the_value() -> None:
    shades = np.asarray(by_lightness()(np.linspace(0.0, 1.0, 64)))[:, :3]
    lightness = shades @ [0.2126, 0.7152, 0.0722]
    assert np.all(np.diff(lightness) < 0.0)
    assert lightness[0] - lightness[-1] > 0.6


def cor(folder: Path) -> tuple[dict[str, dict[str, np.ndarray]], str]:
    text = (folder / "COR").read_text()
    found = {}
    for name, block in re.findall(r"^      (stress_\S+):\n((?: {12}.*\n)+)", text, re.MULTILINE):
        lists = re.findall(r"^ {12}(lags|value): (\[.*\])$", block, re.MULTILINE)
        found[name] = {key: np.array(json.loads(numbers)) for key, numbers in lists}
    return found, text


def test_correlations_are_those_of_the_file(folder: Path, run: Run) -> None:
    found, text = cor(folder)
    relaxation = drawing(run, "stress-relaxation")
    axes = relaxation.figure.axes[0]
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    below = 0
    for name in ("xy", "xz"):
        lags, values = curves(relaxation)[f"σ_{name}"]
        expected = found[f"stress_{name}-stress_{name}"]
        np.testing.assert_array_equal(lags, expected["lags"][1:])
        positive = expected["value"][1:] > 0.0
        np.testing.assert_array_equal(values[positive], expected["value"][1:][positive])
        assert np.isnan(values[~positive]).all()  # a gap in the line
        below += int((~positive).sum())
        assert f"σ_{name} {expected['value'][0]:.4g}" in relaxation.caption
    assert (f"{below} values that are not above 0" in relaxation.caption) == (below > 0)
    viscosity = drawing(run, "viscosity")
    value = float(re.search(r" {6}viscosity:\n {12}value: (\S+)", text)[1])
    # V/(k_B T) with the kinetic temperature that OUTPUT's samples had: DIAGNOSTICS has every fourth of them.
    diagnostics = columns(folder / "DIAGNOSTICS", 0)
    temperature = diagnostics["kinetic_temperature"][diagnostics["step"] > 40].mean()
    mean = curves(viscosity)["mean"][1]
    own = []
    for name in ("xy", "xz"):
        one = found[f"stress_{name}-stress_{name}"]
        own.append(64.0 / temperature * np.cumsum(0.5 * (one["value"][1:] + one["value"][:-1]) * np.diff(one["lags"])))
    np.testing.assert_allclose(mean, np.mean(own, axis=0), rtol=0.03, atol=0.02)
    assert mean[-1] == pytest.approx(value, rel=1e-6)
    other = curves(drawing(run, "correlations"))["σ_xx with σ_yy"]
    np.testing.assert_array_equal(other[1], found["stress_xx-stress_yy"]["value"][1:])


def test_balance_of_energy_is_that_of_the_records(folder: Path, run: Run) -> None:
    table = columns(folder / "DIAGNOSTICS", 0)
    thermal = table["kinetic_temperature"][table["step"] > 40].mean()
    found = drawing(run, "conserved")
    above, below = curves(found, 0), curves(found, 1)
    for label, name in (("internal", "internal_energy"), ("kinetic and potential", "energy")):
        expected = (table[name] - table[name][0]) / thermal
        np.testing.assert_allclose(above[label][1], expected, rtol=2e-2, atol=1e-6)
    shape = table["conserved_energy"] - table["conserved_energy"][0]
    ratio = below["conserved"][1][1:] / shape[1:]
    assert ratio.min() == pytest.approx(ratio.max(), rel=1e-5)
    assert ratio.mean() == pytest.approx(1.0 / thermal, rel=0.02)
    assert f"conserved {below['conserved'][1][-1]:+.2g}" in found.caption
    internal = drawing(run, "internal-temperature")
    after = table["internal_temperature"][table["step"] > 40]
    assert f"Internal temperature {after.mean():.3f}"[:24] in internal.caption
    mean = curves(internal)["mean so far ± error"][1]
    assert mean[-1] == pytest.approx(after.mean(), rel=1e-9)


def test_output_alone_has_the_energies_too(folder: Path, tmp_path: Path) -> None:
    for name in ("OUTPUT", "STATIS", "CONTROL", "FIELD", "CONFIG"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    run = collect_run(tmp_path)
    text = (folder / "OUTPUT").read_text()
    printed = np.array([float(x) for x in re.findall(r"^ +conserved energy +(\S+)$", text, re.MULTILINE)])
    assert len(printed) == 9
    found = curves(drawing(run, "conserved"), 1)["conserved"]
    np.testing.assert_allclose(found[0], 0.2 * np.arange(9), atol=1e-9)
    shape = (printed - printed[0]) / 160
    ratio = found[1][1:] / shape[1:]
    assert ratio.min() == pytest.approx(ratio.max(), rel=1e-5)
    statistics = read_statistics(folder / "STATIS")
    assert ratio.mean() == pytest.approx(1.0 / statistics["temperature"][statistics.step > 40].mean(), rel=1e-6)
    assert draw(run, "species") is not None


def test_amounts_are_those_that_output_ends_with(folder: Path, run: Run) -> None:
    text = (folder / "OUTPUT").read_text()
    found = drawing(run, "species")
    for axes, name in zip(found.figure.axes, ("sugar", "salt"), strict=True):
        numbers = [float(x) for x in re.search(rf"^  {name} +(.*)$", text, re.MULTILINE)[1].split()]
        widths = [bar.get_width() for bar in axes.patches]
        np.testing.assert_allclose(widths, numbers[:5], rtol=2e-8, atol=1e-12)
        assert axes.get_title(loc="left") == name
        assert [one.get_text() for one in axes.texts] == [f"{x:.5g}" for x in widths]
    assert run.balance_file == "OUTPUT"
    sugar = next(one for one in run.balance if one.name == "sugar")
    assert sugar.start + sugar.sources + sugar.reactions == pytest.approx(sugar.now, rel=1e-12)
    assert {one.subject: one.level for one in judge_run(run)}["Dissolved species"] == "fine"
    assert {one.subject: one.level for one in judge_run(run)}["Conserved energy"] != "unknown"


def test_balance_of_a_run_without_an_end_is_that_of_its_checkpoint(folder: Path, run: Run, tmp_path: Path) -> None:
    for path in folder.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    text = (folder / "OUTPUT").read_text()
    (tmp_path / "OUTPUT").write_text(text[: text.index("run terminated")])
    found = collect_run(tmp_path)
    assert found.balance_file == "REVIVE"
    assert found.balance == Simulation.resume(tmp_path / "REVIVE").species_balance()
    for one, other in zip(found.balance, run.balance, strict=True):
        assert (one.start, one.sources, one.reactions, one.now) == pytest.approx(
            (other.start, other.sources, other.reactions, other.now), rel=1e-7
        )


@pytest.mark.parametrize("name", ["temperature", "concentration_sugar"])
@pytest.mark.parametrize("checkpoint", [True, False])
def test_beads_are_as_dark_as_what_they_carry(folder: Path, tmp_path: Path, name: str, checkpoint: bool) -> None:
    """Of REVIVE, or of REVCON with REVBEADS; each disc is looked up by its place."""
    for path in folder.iterdir():
        if checkpoint or path.name in ("REVCON", "REVBEADS", "CONTROL", "FIELD", "CONFIG", "STATIS"):
            (tmp_path / path.name).write_bytes(path.read_bytes())
    found = drawing(collect_run(tmp_path), f"last-{name}")
    assert ("from REVIVE" if checkpoint else "from REVCON") in found.caption
    heads = (folder / "REVBEADS").read_text().splitlines()[1].split()[1:]
    values = np.loadtxt(folder / "REVBEADS", skiprows=2)[:, 1 + heads.index(name)]
    places = read_config(folder / "REVCON").positions
    places -= 4.0 * np.floor(places / 4.0 + 0.5)
    right, up, _ = _axes_of_view()
    seen = np.stack([places @ right, places @ up], axis=1)
    (discs,) = [one for one in found.figure.axes[1].collections if one.get_rasterized()]
    offsets = np.asarray(discs.get_offsets())
    nearest = np.argmin(np.linalg.norm(offsets[:, None] - seen[None], axis=2), axis=1)
    assert sorted(nearest.tolist()) == list(range(160))
    share = (values[nearest] - values.min()) / np.ptp(values)
    np.testing.assert_allclose(discs.get_facecolors()[:, :3], np.asarray(by_lightness()(share))[:, :3], atol=0.03)
    assert f"{values.min():.5g} to {values.max():.5g}, mean {values.mean():.5g}" in found.caption
    assert found.figure.axes[0].get_xlim() == pytest.approx((values.min(), values.max()))


def test_figures_have_names_that_plot_knows(run: Run) -> None:
    assert [name for name in figures_of(run) if draw(run, name) is not None] == EVERY
