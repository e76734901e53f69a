"""Profiles and maps of trajectories and arrays, their files and pictures, and the command that makes them."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import pydlpoly
from pydlpoly.analysis import Profile, frames_of_arrays, plot_map, plot_profile, profile_of_arrays
from pydlpoly.cli import main
from pydlpoly.errors import InputError
from pydlpoly.formats.binned_table import read_binned
from pydlpoly.runner import run_scene
from tests.run_folders import run_folder

PNG = b"\x89PNG"
SETTINGS = {
    "traj_key": "pos-vel",
    "profile_frequency": "5 steps",
    "profile_bins": "6",
    "map_frequency": "5 steps",
    "map_bins": "[ 3 4 ]",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run with its inputs beside its outputs."""
    made = run_folder(tmp_path_factory.mktemp("profile"), SETTINGS)
    run_scene(pydlpoly.load(made), made, threads=1)
    return made


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    def call(*words: object) -> tuple[object, str, str]:
        monkeypatch.setattr(sys, "argv", ["pydlpoly", "analyse", *(str(word) for word in words)])
        with pytest.raises(SystemExit) as stop:
            main()
        said = capsys.readouterr()
        return stop.value.code, said.out, " ".join(said.err.replace("│", " ").split())

    return call


def test_arrays_and_frames_give_the_same() -> None:
    random = np.random.default_rng(1)
    places, speeds = 5.0 * random.random((8, 50, 3)), random.normal(size=(8, 50, 3))
    masses = 1.0 + random.random(50)
    warm = 300.0 + places[:, :, 1]
    found = profile_of_arrays(
        places, 5.0, axes="y", bins=4, masses=masses, velocities=speeds, values={"warm": warm}, boltzmann=0.831451115
    )
    frames = list(frames_of_arrays(places, 5.0, velocities=speeds, masses=masses))
    expected = Profile("y", bins=4).of(frames)
    for name in expected.table.values:
        np.testing.assert_array_equal(found[name], expected[name])
        np.testing.assert_array_equal(found.errors[name], expected.table.errors[name])
    numbers = np.clip(((places[:, :, 1] / 5.0 + 0.5) % 1.0 * 4).astype(int), 0, 3)
    np.testing.assert_allclose(found["warm"], [warm[numbers == k].mean() for k in range(4)], rtol=1e-13)
    momenta = masses[None, :, None] * speeds
    for k in range(4):
        inside = numbers == k
        weights = np.broadcast_to(masses, inside.shape)[inside]
        flow = momenta[inside].sum(axis=0) / weights.sum()
        squares = (weights[:, None] * (speeds[inside] - flow) ** 2).sum()
        assert found["velocity_z"][k] == pytest.approx(flow[2], rel=1e-12)
        assert found["kinetic_temperature"][k] == pytest.approx(squares / (3 * 0.831451115 * inside.sum()), rel=1e-12)
    one = profile_of_arrays(places[0], np.diag([5.0, 5.0, 5.0]), axes="xz", bins=(2, 3))
    assert one["number_density"].shape == (2, 3)
    assert one["number_density"].sum() * 125 / 6 == pytest.approx(50, rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"axes": "w"}, "one or two different axes"),
        ({"axes": "xx"}, "one or two different axes"),
        ({"axes": "xyz"}, "one or two different axes"),
        ({"bins": 0}, "a number of bins for each of 1 axes"),
        ({"bins": (2, 2)}, "a number of bins for each of 1 axes"),
        ({"velocities": np.ones((3, 3))}, r"velocities must be of shape \(1, 4, 3\)"),
        ({"values": {"q": np.ones(3)}}, r"q must be of shape \(1, 4\)"),
        ({"masses": np.ones(3)}, r"masses must be of shape \(4,\)"),
    ],
)
def test_arrays_that_do_not_fit(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        profile_of_arrays(np.zeros((4, 3)), 5.0, **arguments)  # type: ignore[arg-type]
    if set(arguments) <= {"axes", "bins"}:
        with pytest.raises(InputError, match=message):
            Profile(**arguments)  # type: ignore[arg-type]


def test_frames_that_lack_something() -> None:
    frames = list(frames_of_arrays(np.zeros((2, 3, 3)), 5.0))
    assert set(Profile().of(frames).table.values) == {"number_density", "mass_density"}
    with pytest.raises(InputError, match="no velocities"):
        Profile(quantities=("velocity_x",)).of(frames)
    with pytest.raises(InputError, match="'heat': frames do not hold this"):
        Profile(quantities=("heat",)).of(frames)
    with pytest.raises(InputError, match="no frames to analyse"):
        Profile().of([])


def test_pictures_are_written(folder: Path, tmp_path: Path) -> None:
    profile, plane = read_binned(folder / "PROFILE"), read_binned(folder / "MAP")
    plot_profile(profile, tmp_path / "a.png", ("number_density", "velocity_x"))
    plot_map(plane, tmp_path / "b.png")
    plot_map(plane, tmp_path / "c.svg", ("kinetic_temperature",))
    assert (tmp_path / "a.png").read_bytes().startswith(PNG)
    assert (tmp_path / "b.png").read_bytes().startswith(PNG)
    assert "<svg" in (tmp_path / "c.svg").read_text()
    for plot, table in ((plot_profile, plane), (plot_map, profile)):
        with pytest.raises(InputError, match=r"are a (map|profile), not a"):
            plot(table, tmp_path / "d.png")
    with pytest.raises(InputError, match="'heat': is not in the table; expected some of number_density"):
        plot_map(plane, tmp_path / "d.png", ("heat",))
    with pytest.raises(InputError, match="cannot be drawn"):
        plot_map(plane, tmp_path / "d.what")
    assert not (tmp_path / "d.png").exists()


def test_the_command_shows_files_of_a_run(folder: Path, tmp_path: Path, command) -> None:
    code, out, err = command(folder / "PROFILE", "--plot", tmp_path / "p.png", "--output", tmp_path / "p.csv")
    assert (code, err) == (0, "")
    assert "velocity_x: highest" in out
    assert (tmp_path / "p.png").read_bytes().startswith(PNG)
    rows = (tmp_path / "p.csv").read_text().splitlines()
    assert sum(row.startswith("number_density_A,") for row in rows) == 6
    code, out, _ = command(folder / "MAP", "--plot", tmp_path / "m.png", "--output", tmp_path / "m.npz")
    assert code == 0
    stored, table = np.load(tmp_path / "m.npz"), read_binned(folder / "MAP")
    np.testing.assert_array_equal(stored["velocity_x"], table["velocity_x"])
    np.testing.assert_array_equal(stored["y"], table.centres[1])
    code, _, err = command(folder / "MAP", "--output", tmp_path / "m.csv")
    assert code == 1
    assert "a map has no columns; expected a name that ends with .npz" in err
    code, _, err = command(folder / "PROFILE", "--profile", "z")
    assert code == 2
    assert "holds averages already" in err


def test_the_command_makes_profiles_of_a_trajectory(folder: Path, tmp_path: Path, command) -> None:
    code, out, err = command(folder, "--profile", "z", "--bins", 6, "--start", 1, "--output", tmp_path / "p.npz")
    assert (code, err) == (0, "")
    assert "kinetic_temperature: highest" in out
    assert "Å" not in out
    stored = np.load(tmp_path / "p.npz")
    expected = Profile("z", bins=6, reduced=True).of(folder / "HISTORY", start=1)
    np.testing.assert_array_equal(stored["kinetic_temperature.kinetic_temperature.y"], expected["kinetic_temperature"])
    code, out, err = command(folder, "--profile", "xz", "--bins", 4, "--plot", tmp_path / "m.png")
    assert (code, err) == (0, "")
    assert (tmp_path / "m.png").read_bytes().startswith(PNG)
    code, out, err = command(folder / "HISTORY", "--profile", "z", "--bins", 6)
    assert code == 0
    assert "kinetic_temperature" not in out
    assert "name the folder of FIELD with --scene" in err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--profile", "w"), "one or two different axes"),
        (("--profile", "xz", "--msd"), "a map is written and drawn alone"),
    ],
)
def test_what_cannot_be_done_is_refused(folder: Path, command, words: tuple[str, ...], message: str) -> None:
    code, _, err = command(folder, *words)
    assert code in (1, 2)
    assert message in err
