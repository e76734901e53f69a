"""Pictures and displacements from trajectories that are no HISTORY; partial files; a cell that moves."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from pydlpoly.report import collect_run, frames, judge_run
from pydlpoly.report.figures import draw, figures_of
from pydlpoly.runner import run_scene
from pydlpoly.scene import load
from pydlpoly.trajectories import open_reader, read

from ..run_folders import run_folder
from .test_averages import curves, drawing

FILES = {one: f"TRAJECTORY.{one}" for one in ("extxyz", "gsd", "h5md", "dcd")}
PISTON = {
    "ensemble": "npt",
    "pressure_hydrostatic": "23.65 dpd_p",
    "ensemble_barostat_coupling": "1.0 internal_t",
    "ensemble_barostat_friction": "1.0 internal_t^-1",
}


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with its frames in every format, 41 of them."""
    folder = tmp_path_factory.mktemp("formats")
    settings = {"traj_format": f"[{' '.join(FILES)}]", "time_run": "400 steps", "stats_frequency": "0 steps"}
    run_scene(load(run_folder(folder, settings)), folder)
    return folder


def alone(written: Path, folder: Path, name: str) -> Path:
    """The input files and one trajectory."""
    folder.mkdir(exist_ok=True)
    companion = ("TRAJECTORY.psf",) if name == "dcd" else ()
    for file in ("CONTROL", "FIELD", "CONFIG", FILES[name], *companion):
        (folder / file).write_bytes((written / file).read_bytes())
    return folder


@pytest.mark.parametrize("name", FILES)
def test_pictures_and_displacements_of_any_format(written: Path, tmp_path: Path, name: str) -> None:
    run = collect_run(alone(written, tmp_path, name))
    assert run.problems == ()
    assert run.history_file == FILES[name]
    assert run.history is not None
    assert (run.history.count, run.history.cut) == (41, "")
    assert [frame.step for frame in run.history.frames] == list(range(10, 401, 30))  # every third, the last among them
    assert run.last is not None
    *_, last = read(written / "HISTORY")
    np.testing.assert_allclose(run.last.positions, last.positions, atol=1e-6)
    assert run.last.step == 400
    assert f"from {FILES[name]}" in drawing(run, "last").caption
    assert f"of {FILES[name]}" in drawing(run, "rdf").caption
    if name == "dcd":
        assert draw(run, "msd") is None  # it does not say which cells were crossed
        return
    # Own arithmetic: unwrapped places less those of the first frame looked at.
    every = [frame for frame in read(written / "TRAJECTORY.h5md") if frame.step in range(10, 401, 30)]
    places = np.array([frame.positions + frame.images @ frame.cell for frame in every])
    squares = np.sum((places - places[0]) ** 2, axis=2)
    found = curves(drawing(run, "msd"))
    np.testing.assert_allclose(found["A"][1], squares[:, :120].mean(axis=1), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(found["B"][1], squares[:, 120:].mean(axis=1), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(found["A"][0], 0.01 * np.arange(10, 401, 30), atol=1e-9)
    assert "since step 10, the first frame looked at" in drawing(run, "msd").caption


@pytest.mark.parametrize("name", FILES)
def test_samples_are_frames_of_the_file(written: Path, name: str) -> None:
    whole = list(read(written / FILES[name]))
    sample = open_reader(written / FILES[name]).sample(5)
    assert sample.count == len(whole) == 41
    assert len(sample.frames) == 5
    by_step = {frame.step: frame for frame in whole}
    for frame in sample.frames:
        np.testing.assert_array_equal(frame.positions, by_step[frame.step].positions)
        assert frame.names == by_step[frame.step].names


def test_no_more_beads_are_held_than_fit(written: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frames, "_BEADS", 160 * 6)
    for name in FILES:
        run = collect_run(alone(written, tmp_path / name, name))
        assert run.history is not None
        assert len(run.history.frames) == 6
        assert run.history.frames[-1].step == 400


@pytest.mark.parametrize("name", FILES)
def test_half_a_trajectory(written: Path, tmp_path: Path, name: str) -> None:
    """Whole frames are used where the format allows it, and what was left out is said; HDF5 must not wait for more."""
    folder = alone(written, tmp_path, name)
    content = (written / FILES[name]).read_bytes()
    (folder / FILES[name]).write_bytes(content[: len(content) // 2 + 17])
    run = collect_run(folder)
    told = {one.subject: one.text for one in judge_run(run) if one.level == "warning"}[f"File {FILES[name]}"]
    if name in ("extxyz", "dcd"):
        found = re.fullmatch(r"a frame is cut short after the first (\d+); the whole frames are used", told)
        assert found is not None, told
        assert run.history is not None
        assert run.history.count == int(found[1]) == 20
        assert draw(run, "last") is not None
    else:
        assert told.startswith("cannot be read: ")
        assert run.history is None
    for one in figures_of(run):
        draw(run, one)


def test_another_format_stands_in_for_a_damaged_one(written: Path, tmp_path: Path) -> None:
    folder = alone(written, tmp_path, "gsd")
    (folder / FILES["h5md"]).write_bytes(b"nothing of the kind")
    run = collect_run(folder)
    assert run.history_file == FILES["gsd"]
    assert [one.file for one in run.problems] == [FILES["h5md"]]
    (folder / "HISTORY").write_bytes((written / "HISTORY").read_bytes())
    assert collect_run(folder).history_file == "HISTORY"


def test_a_missing_package_is_said_only_where_it_matters(
    written: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "h5py", None)
    folder = alone(written, tmp_path, "h5md")
    control = (folder / "CONTROL").read_text()
    (folder / "CONTROL").write_text(re.sub(r"(?m)^traj_format.*$", "traj_format [extxyz]", control))
    (one,) = collect_run(folder).problems
    assert one.file == FILES["h5md"]
    assert "needs the package h5py: pip install 'pydlpoly[trajectories]'" in one.text
    (folder / FILES["gsd"]).write_bytes((written / FILES["gsd"]).read_bytes())
    assert collect_run(folder).problems == ()


@pytest.mark.parametrize("part", [0.3, 0.5, 0.8])
@pytest.mark.parametrize("name", ["PROFILE", "MAP", "COR", "REVBEADS", "TRAJECTORY.h5md", "DIAGNOSTICS"])
def test_files_of_averages_that_a_kill_cut(reports, tmp_path: Path, name: str, part: float) -> None:
    source = reports("carried").folder
    for path in source.iterdir():
        if path.name != "REVIVE":  # with it REVBEADS is not needed
            (tmp_path / path.name).write_bytes(path.read_bytes())
    whole = (source / name).read_bytes()
    (tmp_path / name).write_bytes(whole[: int(part * len(whole))])
    run = collect_run(tmp_path)
    told = {one.subject: one.text for one in judge_run(run) if one.level == "warning"}
    if name != "DIAGNOSTICS":  # of which whole lines are used
        assert "cannot be read" in told[f"File {name}"], told
        assert re.search("cut short|ends after|lost its end|found . words", told[f"File {name}"]), told
    made = [one for one in figures_of(run) if draw(run, one) is not None]
    lost = {"PROFILE": "profile-", "MAP": "map-", "COR": "stress-relaxation", "REVBEADS": "last-"}
    prefix = lost.get(name, "no such figure")
    if name == "REVBEADS":
        # The trajectory has arrays, too.
        assert "from TRAJECTORY.h5md" in drawing(run, "last-temperature").caption
    else:
        assert not [one for one in made if one.startswith(prefix)]
    assert {"last", "temperature", "pressure"} <= set(made)


def test_a_barostat_shows_in_volume_and_edges(tmp_path: Path) -> None:
    run_scene(load(run_folder(tmp_path, {**PISTON, "ensemble": "nst", "time_run": "100 steps"})), tmp_path)
    run = collect_run(tmp_path)
    lines = (tmp_path / "STATIS").read_text().splitlines()[2:]
    words = np.array(" ".join(lines).split(), dtype=float).reshape(11, -1)
    # Three numbers of the record's head, 37 columns, two species, then the cell by vector.
    cell = words[:, 3 + 37 + 2 :][:, :9].reshape(-1, 3, 3)
    found = curves(drawing(run, "cell"))
    for k, edge in enumerate("abc"):
        np.testing.assert_allclose(found[edge][1], np.linalg.norm(cell[:, k], axis=1), rtol=1e-6)
        np.testing.assert_allclose(found[edge][0], words[:, 1])
    volume = curves(drawing(run, "volume"))["each record"]
    np.testing.assert_allclose(volume[1], np.abs(np.linalg.det(cell)), rtol=1e-5)


def test_a_cell_that_stays_has_no_such_figure(reports) -> None:
    run = collect_run(reports("healthy").folder)
    assert draw(run, "cell") is None
    assert draw(run, "volume") is None


def test_a_flow_is_named_where_displacements_hold_it(tmp_path: Path) -> None:
    settings = {"shear_rate": "0.5 dpd_t^-1", "ensemble_dpd_order": "peters", "time_run": "60 steps"}
    run_scene(load(run_folder(tmp_path, settings)), tmp_path)
    run = collect_run(tmp_path)
    assert "its flow is in it" in drawing(run, "msd").caption
    # Beads that leave the cell across the flow come back with another velocity: no fault of the run.
    told = {one.subject: one for one in judge_run(run)}["Momentum"]
    assert told.level == "unknown"
    assert "sheared cell" in told.text
    angle = curves(drawing(run, "cell"))["γ"]
    # tan of the tilt is the rate times the time, as long as it is below half the cell.
    np.testing.assert_allclose(90.0 - angle[1], np.degrees(np.arctan(0.5 * angle[0])), atol=1e-3)
    (tmp_path / "STATIS").unlink()
    assert all(draw(collect_run(tmp_path), name) is not None for name in ("last", "rdf", "density"))
