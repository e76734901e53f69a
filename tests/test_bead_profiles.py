"""PROFILE and MAP of runs: against other files of the same run, flows, restarts, files, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import pydlpoly
from pydlpoly import Scene, Simulation
from pydlpoly.analysis import Profile
from pydlpoly.callbacks import Moment
from pydlpoly.errors import InputError, SceneError
from pydlpoly.formats.binned_table import BinnedTable, is_binned, read_binned, write_binned
from pydlpoly.formats.zdndat import read_density
from pydlpoly.reporters import BinReporter
from pydlpoly.runner import run_scene
from pydlpoly.scene import bins
from pydlpoly.scene.bins import VELOCITIES, available_quantities, quantities_of, unit_of

from .carrying import carrying
from .run_folders import run_folder
from .scene_builder import make_scene

MIXED = {"vdw_mix_method": "lorentz-berthelot"}
PROFILES = {
    "profile_frequency": "10 steps",
    "profile_bins": "8",
    "map_frequency": "10 steps",
    "map_plane": "xz",
    "map_bins": "[ 4 6 ]",
    "traj_key": "pos-vel",
}


def loaded(folder: Path, settings: dict[str, str | None]) -> Scene:
    return pydlpoly.load(run_folder(folder, {**PROFILES, **settings}))


def test_profile_and_map_agree_with_the_trajectory_and_with_zdndat(tmp_path: Path) -> None:
    """HISTORY of the same steps, read and binned anew, and DL_POLY's own way of counting beads by height."""
    settings = {"zden_calculate": "on", "zden_frequency": "10 steps", "zden_binsize": "0.125 dpd_l"}
    run_scene(loaded(tmp_path / "in", settings), tmp_path / "out", threads=1)
    out = tmp_path / "out"
    profile, plane = read_binned(out / "PROFILE"), read_binned(out / "MAP")
    assert (profile.axes, profile.samples, profile.outside) == (("z",), 4, 0.0)
    assert (plane.axes, plane.samples) == (("x", "z"), 4)
    assert plane["velocity_y"].shape == (4, 6)
    assert not plane.errors
    expected = Profile("z", bins=8, reduced=True).of(out / "HISTORY", start=1)
    over = Profile("xz", bins=(4, 6), reduced=True).of(out / "HISTORY", start=1)
    for name in ("number_density", "mass_density", "velocity_x", "velocity_y", "velocity_z", "kinetic_temperature"):
        np.testing.assert_allclose(profile[name], expected[name], rtol=1e-6, atol=1e-7)
        np.testing.assert_allclose(profile.errors[name], expected.table.errors[name], rtol=1e-5, atol=1e-7)
        np.testing.assert_allclose(plane[name], over[name], rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(profile.centres[0], np.arange(-1.75, 2.0, 0.5))
    density = read_density(out / "ZDNDAT")
    for name in ("A", "B"):
        np.testing.assert_allclose(profile[f"number_density_{name}"], density[name], rtol=1e-5)


def linear(moment: Moment) -> dict[str, np.ndarray]:
    return {"temperature": 2.0 + 0.5 * moment.positions[:, 2], "concentration_1": np.abs(moment.positions[:, 0])}


def test_what_beads_carry_is_averaged(tmp_path: Path) -> None:
    """A temperature that a callback keeps at 2 + z/2, and a concentration |x|: bins have them at their middles."""
    scene = carrying(loaded(tmp_path / "in", {}))
    plan = replace(scene.output.bead_profile, quantities=("temperature", "concentration"))
    scene = replace(scene, output=replace(scene.output, bead_profile=plan))
    run_scene(scene, tmp_path / "out", threads=1, callbacks=[(linear, 1)])
    profile, plane = read_binned(tmp_path / "out" / "PROFILE"), read_binned(tmp_path / "out" / "MAP")
    assert list(profile.values) == ["temperature", "concentration_1", "concentration_2"]
    np.testing.assert_allclose(profile["temperature"], 2.0 + 0.5 * profile.centres[0], atol=0.06)
    assert np.abs((profile["temperature"] - 2.0 - 0.5 * profile.centres[0]) / profile.errors["temperature"]).max() < 8.0
    expected = np.broadcast_to(np.abs(plane.centres[0])[:, None], (4, 6))
    np.testing.assert_allclose(plane["concentration_1"], expected, atol=0.26)
    assert np.abs(plane["concentration_1"] - expected).mean() < 0.1


@pytest.mark.parametrize("cut", [20, 25])
def test_a_run_that_continues_has_the_same_files(tmp_path: Path, cut: int) -> None:
    scene = carrying(loaded(tmp_path / "in", {"profile_frequency": "4 steps", "time_equilibration": "8 steps"}))
    run_scene(scene, tmp_path / "whole", threads=1)
    run_scene(scene, tmp_path / "parts", threads=2, steps=cut)
    run_scene(scene, tmp_path / "parts", threads=1, checkpoint=tmp_path / "parts" / "REVIVE")
    for name in ("PROFILE", "MAP", "REVBEADS"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parts" / name).read_bytes(), name
    assert read_binned(tmp_path / "whole" / "PROFILE").samples == 8  # steps 12, 16, … 40: after equilibration
    other = replace(scene, output=replace(scene.output, bead_profile=replace(scene.output.bead_profile, bins=(9,))))
    with pytest.raises(InputError, match="holds a profile that cannot go on: it has other axes, bins or quantities"):
        run_scene(other, tmp_path / "parts", steps=60, checkpoint=tmp_path / "parts" / "REVIVE")


def test_names_of_files(tmp_path: Path) -> None:
    scene = loaded(tmp_path / "in", {"io_file_profile": "layers", "io_file_map": "NONE"})
    run_scene(scene, tmp_path / "out", threads=1)
    assert is_binned(tmp_path / "out" / "layers")
    assert not (tmp_path / "out" / "MAP").exists()
    text = " ".join(scene.explain().split())
    assert "layers: every 10 steps, profiles along z in 8 bins: number_density, number_density_A" in text
    assert "maps along" not in text
    clash = loaded(tmp_path / "in", {"io_file_profile": "STATIS"})
    with pytest.raises(InputError, match="two output files of this run have this name"):
        run_scene(clash, tmp_path / "clash")


def test_a_file_comes_back_as_it_was_written(tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    for shape, axes in (((4,), ("y",)), ((3, 2), ("x", "z"))):
        values = {name: random.normal(size=shape) for name in ("number_density", "concentration_error", "error_error")}
        values["number_density"].flat[1] = np.nan
        errors = {name: random.random(shape) for name in values} if len(shape) == 1 else {}
        centres = tuple(np.arange(count) - 1.5 for count in shape)
        units = {axes[0]: "ang", "number_density": "1/ang^3"}
        table = BinnedTable("a title", axes, centres, 17, 2.5, values, errors, units)
        write_binned(tmp_path / "PROFILE", table)
        again = read_binned(tmp_path / "PROFILE")
        assert (again.title, again.axes, again.samples, again.outside) == ("a title", axes, 17, 2.5)
        assert dict(again.units) == units
        assert list(again.values) == list(values)
        for name in values:
            np.testing.assert_allclose(again[name], values[name], rtol=1e-9)
            if errors:
                np.testing.assert_allclose(again.errors[name], errors[name], rtol=1e-9)
        for k in range(len(shape)):
            np.testing.assert_allclose(again.centres[k], centres[k], rtol=1e-9)
        columns = np.loadtxt(tmp_path / "PROFILE")
        assert columns.shape == (int(np.prod(shape)), len(shape) + 3 * (1 + bool(errors)))


def test_files_that_are_no_profiles(tmp_path: Path) -> None:
    path = tmp_path / "PROFILE"
    write_binned(path, BinnedTable("t", ("z",), (np.arange(3.0),), 1, 0.0, {"q": np.arange(3.0)}))
    lines = path.read_text().splitlines()
    for text, message in (
        ("1 2\n3 4\n", "is no profile or map"),
        ("\n".join(lines[:-1]), "is cut short or damaged: expected 3 lines of 2 numbers"),
        ("\n".join([*lines[:-1], "hot"]), "expected 3 lines of 2 numbers, found 2"),
        ("\n".join([*lines[:-1], "1 hot"]), "cannot be read"),
    ):
        path.write_text(text)
        with pytest.raises(InputError, match=message):
            read_binned(path)
    with pytest.raises(InputError, match="cannot be read"):
        read_binned(tmp_path / "MAP")
    assert not is_binned(tmp_path / "MAP")


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"profile_bins": "0"}, "'profile_bins': expected at least one bin, found 0"),
        ({"profile_bins": "20000"}, "'profile_bins': 20000 bins in all; at most 10000 are kept"),
        ({"map_bins": "[ 2000 2000 ]"}, "'map_bins': 4000000 bins in all; at most 1000000 are kept"),
        ({"map_bins": "[ 0 5 ]"}, "'map_bins': expected at least one bin, found 0"),
        ({"profile_frequency": "-1 steps"}, "'profile_frequency': the interval must not be negative, found -1 steps"),
        ({"profile_quantities": "velocty_x"}, "'profile_quantities': 'velocty_x': is not averaged in bins; expected "
         "some of velocity, number_density, number_density_A, number_density_B, mass_density, velocity_x, velocity_y, "
         "velocity_z, kinetic_temperature; did you mean velocity_x, velocity_z, velocity_y?"),
        ({"map_quantities": "[ temperature ]"}, "'map_quantities': 'temperature': beads carry no internal temperature; "
         "did you mean kinetic_temperature?"),
        ({"map_quantities": "concentration"}, "'map_quantities': 'concentration': beads carry no dissolved species"),
        ({"map_quantities": "local_density"}, "'map_quantities': 'local_density': no pair law depends on a local"),
    ],
)  # fmt: skip
def test_refusals(tmp_path: Path, settings: dict[str, str | None], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        loaded(tmp_path, settings)
    assert message in str(caught.value)
    assert "CONTROL:" in str(caught.value)


def test_quantities_and_groups(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = carrying(make_scene({"A": 30}, cell=2.5))
    assert available_quantities(scene) == (
        "number_density", "mass_density", "velocity_x", "velocity_y", "velocity_z", "kinetic_temperature",
        "temperature", "concentration_1", "concentration_2",
    )  # fmt: skip
    asked = ["concentration", "velocity", "velocity_x"]
    assert quantities_of(scene, asked) == ("concentration_1", "concentration_2", *VELOCITIES)
    monkeypatch.setattr(bins, "has_local_density", lambda _: True)
    assert available_quantities(scene)[-1] == "local_density"
    assert unit_of("number_density", scene) == ""
    bonded = replace(scene, constraints=SimpleNamespace())
    assert "kinetic_temperature" not in available_quantities(bonded)
    with pytest.raises(InputError, match="constraints take degrees of freedom that belong to no bin"):
        quantities_of(bonded, ["kinetic_temperature"])


def test_local_densities_are_averaged(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a scene with a local density gives as "density" is in the table as "local_density"."""
    simulation = Simulation(make_scene({"A": 30}, cell=2.5), seed=1, threads=1)
    arrays = simulation.bead_arrays()
    monkeypatch.setattr(bins, "has_local_density", lambda _: True)
    monkeypatch.setattr(simulation, "bead_arrays", lambda: {**arrays, "density": np.arange(30.0)})
    reporter = BinReporter(simulation, axes="z", bins=(1,), every=1)
    reporter.report(simulation)
    assert reporter.table()["local_density"][0] == pytest.approx(14.5)


def test_units_of_a_scene_in_kelvin() -> None:
    scene = make_scene({"A": 30}, cell=2.5, units="kj", control={"temperature": "300 K", "timestep": "0.001 ps"})
    simulation = Simulation(carrying(scene), seed=1, threads=1)
    reporter = BinReporter(simulation, axes=("x",), bins=(1,), every=1)
    reporter.report(simulation)
    table = reporter.table()
    assert table.units["kinetic_temperature"] == table.units["temperature"] == "K"
    assert (table.units["x"], table.units["velocity_x"], table.units["mass_density"]) == ("ang", "ang/ps", "Da/ang^3")
    assert table["kinetic_temperature"][0] == pytest.approx(simulation.temperature * 29 / 30, rel=1e-9)
    assert table["temperature"][0] == pytest.approx(simulation.state.temperature.mean(), rel=1e-12)


@pytest.mark.parametrize("walls", [False, True])
def test_open_axes(walls: bool) -> None:
    """A slab that is open along z, without walls and with: all beads are in its bins, or are counted apart."""
    control = {"wall_method": "reflecting"} if walls else {}
    places = (np.random.default_rng(2).random((40, 3)) - 0.5) * [4.0, 4.0, 5.9]
    scene = make_scene({"A": 40}, cell=[4.0, 4.0, 6.0], imcon=2 if walls else 6, positions=places, control=control)
    simulation = Simulation(scene, seed=1, threads=1)
    reporter = BinReporter(simulation, axes=("z",), bins=(10,), quantities=("number_density",), every=1)
    simulation.reporters.append(reporter)
    simulation.run(100)
    table = reporter.table()
    height = simulation.cell[2, 2]
    assert (table.outside == 0.0) == (walls or bool((np.abs(simulation.positions[:, 2]) < height / 2).all()))
    slice_volume = 16.0 * height / 10
    assert table["number_density"].sum() * slice_volume == pytest.approx(40 - table.outside, rel=1e-12)


def test_a_uniform_fluid_is_flat_within_its_errors() -> None:
    """Density, flow and temperature of DPD water, with the weak form of Student's bounds for 16 bins."""
    scene = make_scene({"A": 375}, cell=5.0)
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(200)
    reporter = BinReporter(simulation, axes=("x",), bins=(16,), every=5)
    simulation.reporters.append(reporter)
    simulation.run(4000)
    table = reporter.table()
    for name, expected in (("number_density", 3.0), ("velocity_x", 0.0), ("velocity_y", 0.0)):
        assert np.abs((table[name] - expected) / table.errors[name]).max() < 5.0, name
    assert table["number_density"].mean() == pytest.approx(3.0, rel=1e-12)
    spread = table["kinetic_temperature"] - table["kinetic_temperature"].mean()
    assert np.abs(spread / table.errors["kinetic_temperature"]).max() < 5.0
    assert table["kinetic_temperature"].mean() == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
def test_periodic_poiseuille_flow_is_a_parabola() -> None:
    """u = ρ g |y| (D − |y|) sign(y)/(2 η) with Groot and Warren's η = 0.84 ± 0.03 (as tests/physics/test_flow.py).

    6000 samples of 24 beads a bin, correlated over about two time units: an error of 0.02 of the velocities.
    """
    push, half = 0.03, 5.0
    control = {"ensemble_dpd_order": "middle", "timestep": "0.04 internal_t"}
    scene = make_scene({"A": 960}, cell=[4.0, 2.0 * half, 8.0], control=control, extern=f"pois {push}")
    simulation = Simulation(scene, seed=7, threads=1)
    simulation.run(2500)
    reporter = BinReporter(simulation, axes=("y",), bins=(40,), every=5)
    simulation.reporters.append(reporter)
    simulation.run(30000)
    table = reporter.table()
    place = table.centres[0]
    shape = 3.0 * push * np.abs(place) * (half - np.abs(place)) * np.sign(place) / 2.0
    viscosity = float(shape @ shape / (shape @ table["velocity_x"]))
    assert viscosity == pytest.approx(0.84, abs=0.06)
    assert np.abs(table["velocity_x"] - shape / viscosity).max() < 0.03
    assert shape.max() / viscosity > 0.3
    np.testing.assert_allclose(table["kinetic_temperature"], 1.0, atol=0.03)
