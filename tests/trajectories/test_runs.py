"""Trajectories of whole runs: CONTROL's words, continuing, kills, conversion, and runs that start from a trajectory."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pydlpoly
from pydlpoly.analysis import MeanSquareDisplacement, universe
from pydlpoly.cli import example_folder, main
from pydlpoly.errors import InputError, SceneError
from pydlpoly.formats.config import read_config
from pydlpoly.formats.history import read_history_header
from pydlpoly.runner import run_scene
from pydlpoly.trajectories import FORMATS, open_reader, read, read_frame
from pydlpoly.trajectories.convert import TARGETS, convert_trajectory

from ..run_folders import listing, run_folder

ALL = "[extxyz gsd h5md dcd]"
FILES = {name: one.files("TRAJECTORY")[0] for name, one in FORMATS.items() if name != "history"}
COMMAND = [str(Path(sys.executable).with_name("python")), "-m", "pydlpoly"]


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of 40 steps with a frame every 10."""
    folder = run_folder(tmp_path_factory.mktemp("run") / "in", {"traj_format": ALL, "traj_key": "pos-vel-force"})
    run_scene(pydlpoly.load(folder), folder.parent / "out", threads=1)
    return folder.parent / "out"


def steps_in(file: Path) -> list[int]:
    return [frame.step for frame in read(file)]


def test_every_format_is_written_beside_history(out: Path) -> None:
    assert {*FILES.values(), "TRAJECTORY.psf", "HISTORY"} <= set(listing(out))
    for file in (*FILES.values(), "HISTORY"):
        assert steps_in(out / file) == [0, 10, 20, 30, 40]


@pytest.mark.parametrize("name", FILES)
def test_frames_are_those_of_history(out: Path, name: str) -> None:
    single = name in ("gsd", "dcd")
    for found, expected in zip(read(out / FILES[name]), read(out / "HISTORY"), strict=True):
        assert found.names == expected.names
        np.testing.assert_allclose(found.positions, expected.positions, atol=2.0**-23 if single else 1e-9)
        np.testing.assert_array_equal(found.masses, expected.masses)
        np.testing.assert_allclose(found.cell, expected.cell)
        assert found.imcon == expected.imcon
        if name != "dcd":
            assert found.time == pytest.approx(expected.time, abs=1e-6)
            for ours, theirs in ((found.velocities, expected.velocities), (found.forces, expected.forces)):
                np.testing.assert_allclose(ours, theirs, rtol=1e-6 if single else 1e-8, atol=1e-8)


def test_images_follow_beads(out: Path) -> None:
    """Unwrapped positions move by less than half a cell between frames; HISTORY's displacements agree."""
    frames_read = list(read(out / "TRAJECTORY.h5md"))
    assert all(frame.images is not None for frame in frames_read)
    unwrapped = [frame.positions + frame.images @ frame.cell for frame in frames_read]
    moved = np.linalg.norm(unwrapped[-1] - unwrapped[0], axis=1)
    np.testing.assert_allclose(moved, read_frame(out / "HISTORY").displacements, atol=2e-6)
    assert open_reader(out / "TRAJECTORY.h5md").topology.reduced


def test_analyses_take_any_format(out: Path) -> None:
    found = [MeanSquareDisplacement().of(out / file).msd for file in ("HISTORY", "TRAJECTORY.h5md", "TRAJECTORY.gsd")]
    for one in found[1:]:
        np.testing.assert_allclose(one, found[0], rtol=1e-5, atol=1e-7)


def test_names_none_and_earlier_files(tmp_path: Path) -> None:
    settings = {"traj_format": "gsd, dcd", "io_file_trajectory": "beads", "io_file_history": "NONE"}
    folder = run_folder(tmp_path, {**settings, "time_run": "10 steps"})
    scene = pydlpoly.load(folder)
    run_scene(scene, folder, threads=1)
    made = set(listing(folder))
    assert {"beads.gsd", "beads.dcd", "beads.psf"} <= made
    assert not {"HISTORY", "TRAJECTORY.gsd"} & made
    before = (folder / "beads.gsd").read_bytes()
    run_scene(scene, folder, threads=1)
    assert (folder / "beads.gsd.bak").read_bytes() == before
    assert (folder / "beads.psf.bak").is_file()
    assert "beads.gsd: every 10 steps" in scene.explain()


@pytest.mark.parametrize("calculate", ["off", "on"])
def test_nothing_is_written_without_a_trajectory(tmp_path: Path, calculate: str) -> None:
    folder = run_folder(tmp_path, {"traj_calculate": calculate, "traj_format": "gsd", "traj_interval": "0 steps"})
    scene = pydlpoly.load(folder)
    assert scene.output.trajectory_every == 0
    run_scene(scene, tmp_path / "out", steps=5, threads=1)
    assert not [name for name in listing(tmp_path / "out") if name.startswith("TRAJECTORY")]


def test_words_that_are_no_format(tmp_path: Path) -> None:
    folder = run_folder(tmp_path, {"traj_format": "[gsd h5mb]"})
    with pytest.raises(SceneError, match=r"CONTROL:\d+: 'traj_format': 'h5mb' is no format.*did you mean h5md"):
        pydlpoly.load(folder)


def test_a_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = run_folder(tmp_path, {"traj_format": "gsd"})
    monkeypatch.setattr("pydlpoly.trajectories.find_spec", lambda _: None)
    with pytest.raises(SceneError, match=r"CONTROL:\d+: 'traj_format': gsd needs the package gsd: pip install"):
        pydlpoly.load(folder)


def test_a_left_handed_cell_is_refused_by_name(tmp_path: Path) -> None:
    folder = run_folder(tmp_path, {"traj_format": "dcd"})
    text = (folder / "CONFIG").read_text().replace("0 1 160", "0 3 160").replace("0 0 4.0", "0 0 -4.0")
    (folder / "CONFIG").write_text(text)
    with pytest.raises(SceneError, match=r"'traj_format': dcd cannot hold the left-handed cell"):
        pydlpoly.load(folder)


def test_two_files_of_one_name_are_refused(tmp_path: Path) -> None:
    folder = run_folder(tmp_path, {"traj_format": "gsd", "io_file_statis": "TRAJECTORY.gsd"})
    with pytest.raises(InputError, match="two output files of this run have this name"):
        run_scene(pydlpoly.load(folder), tmp_path / "out", threads=1)


def test_arrays_of_beads_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def arrays(simulation: pydlpoly.Simulation) -> dict[str, np.ndarray]:
        return {"temperature": 300.0 + simulation.step + np.arange(160) / 7.0, "concentration_A": np.arange(160) / 160}

    monkeypatch.setattr(pydlpoly.Simulation, "bead_arrays", arrays, raising=False)
    folder = run_folder(tmp_path, {"traj_format": ALL, "time_run": "10 steps"})
    run_scene(pydlpoly.load(folder), folder, threads=1)
    for name in ("extxyz", "gsd", "h5md"):
        found = read_frame(folder / FILES[name])
        assert sorted(found.arrays) == ["concentration_A", "temperature"]
        np.testing.assert_array_equal(found.arrays["temperature"], 310.0 + np.arange(160) / 7.0)


# -- Continuing -------------------------------------------------------------------------------------------------------


def test_continued_runs_have_every_step_once(tmp_path: Path) -> None:
    """The checkpoint is of step 20, the frames go on to 30; the same bits as in one run."""
    settings = {"traj_format": ALL, "traj_key": "pos-vel", "data_dump_frequency": "20 steps"}
    scene = pydlpoly.load(run_folder(tmp_path / "in", settings))
    run_scene(scene, tmp_path / "whole", threads=1)
    run_scene(scene, tmp_path / "parts", steps=20, threads=1)
    checkpoint = (tmp_path / "parts" / "REVIVE").read_bytes()
    run_scene(scene, tmp_path / "parts", steps=30, threads=1, checkpoint=tmp_path / "parts" / "REVIVE")
    (tmp_path / "parts" / "REVIVE").write_bytes(checkpoint)
    run_scene(scene, tmp_path / "parts", threads=1, checkpoint=tmp_path / "parts" / "REVIVE")
    for file in FILES.values():
        whole, parts = list(read(tmp_path / "whole" / file)), list(read(tmp_path / "parts" / file))
        assert [frame.step for frame in parts] == [0, 10, 20, 30, 40]
        for one, other in zip(whole, parts, strict=True):
            np.testing.assert_array_equal(one.positions, other.positions)
            np.testing.assert_array_equal(one.velocities, other.velocities)
            assert one.time == other.time


def test_a_killed_run_continues(tmp_path: Path) -> None:
    settings = {
        "traj_format": ALL,
        "traj_interval": "5 steps",
        "time_run": "100000 steps",
        "data_dump_frequency": "50 steps",
    }
    folder = run_folder(tmp_path / "in", settings)
    out = tmp_path / "out"
    line = [*COMMAND, "run", str(folder), "--output", str(out), "--quiet"]
    with subprocess.Popen(line, cwd=tmp_path) as process:
        end = time.monotonic() + 60
        while not (out / "REVIVE").exists() and time.monotonic() < end:
            time.sleep(0.05)
        time.sleep(0.3)
        process.send_signal(signal.SIGKILL)
    there = pydlpoly.Simulation.resume(out / "REVIVE").step
    for file in FILES.values():
        steps = steps_in(out / file)
        assert steps == list(range(0, 5 * len(steps), 5))
        assert steps[-1] >= there
    subprocess.run([*line, "--resume", "--steps", str(there + 20)], check=True, cwd=tmp_path)
    for file in (*FILES.values(), "HISTORY"):
        assert steps_in(out / file) == list(range(0, there + 21, 5))


def test_another_interval_goes_on_where_a_format_allows_it(tmp_path: Path) -> None:
    for name, ends in (("gsd", None), ("dcd", "equal intervals")):
        folder = run_folder(tmp_path / name, {"traj_format": name, "time_run": "20 steps"})
        run_scene(pydlpoly.load(folder), folder, threads=1)
        scene = pydlpoly.load(run_folder(folder, {"traj_format": name, "traj_interval": "4 steps"}))
        if ends is None:
            run_scene(scene, folder, threads=1, checkpoint=folder / "REVIVE")
            assert steps_in(folder / FILES[name]) == [0, 10, 20, 24, 28, 32, 36, 40]
        else:
            with pytest.raises(InputError, match=ends):
                run_scene(scene, folder, threads=1, checkpoint=folder / "REVIVE")
            assert steps_in(folder / FILES[name]) == [0, 10, 20]
            assert read_history_header(folder / "HISTORY").frames == 3  # refused before the first step


# -- Conversion, and starts from trajectories -------------------------------------------------------------------------


@pytest.fixture
def cli(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[object, str]]:
    def call(*words: object) -> tuple[object, str]:
        monkeypatch.setattr(sys, "argv", ["pydlpoly", *(str(word) for word in words)])
        with pytest.raises(SystemExit) as stop:
            main()
        captured = capsys.readouterr()
        return stop.value.code, captured.out + captured.err

    return call


@pytest.mark.parametrize("source", ["HISTORY", *FILES.values()])
@pytest.mark.parametrize("to", FORMATS)
def test_every_format_becomes_every_other(tmp_path: Path, out: Path, source: str, to: str) -> None:
    target = convert_trajectory(out / source, to, tmp_path / f"made{FORMATS[to].extension}")
    made = set(listing(tmp_path))
    assert made == {target.name, "made.psf"} if to == "dcd" else made == {target.name}
    single = {"gsd", "dcd"} & {to, source.rsplit(".")[-1]}
    before, after = list(read(out / source)), list(read(target))
    assert len(before) == len(after) == 5
    for old, new in zip(before, after, strict=True):
        assert (old.names, old.step, old.imcon) == (new.names, new.step, new.imcon)
        np.testing.assert_array_equal(new.masses, old.masses)
        np.testing.assert_allclose(new.positions, old.positions, atol=5e-7 if single else 1e-9)
        if old.velocities is not None and to != "dcd":
            np.testing.assert_allclose(new.velocities, old.velocities, atol=5e-6 if single else 1e-8)


def test_convert_on_the_command_line(tmp_path: Path, out: Path, cli: Callable[..., tuple[object, str]]) -> None:
    folder = tmp_path / "here"
    folder.mkdir()
    for file in ("HISTORY", "TRAJECTORY.gsd"):
        (folder / file).write_bytes((out / file).read_bytes())
    assert cli("convert", folder / "HISTORY", "--to", "extxyz") == (0, f"written: {folder / 'HISTORY.extxyz'}\n")
    code, text = cli("convert", folder / "HISTORY", "--to", "extxyz")
    assert (code, "is there already" in text) == (1, True)
    assert cli("convert", folder / "TRAJECTORY.gsd", "--to", "config", "--frame", 2)[0] == 0
    config = read_config(folder / "CONFIG")
    assert (config.step, config.level, config.imcon) == (20, 1, 1)
    frame = read_frame(folder / "TRAJECTORY.gsd", 2)
    np.testing.assert_array_equal(config.positions, frame.positions)
    np.testing.assert_array_equal(config.velocities, frame.velocities)
    np.testing.assert_array_equal(config.cell, frame.cell)
    assert config.names == frame.names
    assert cli("convert", folder / "HISTORY", "--to", "gsd", "--frame", 1, "-o", folder / "one.gsd")[0] == 0
    assert steps_in(folder / "one.gsd") == [10]
    for words, found in (
        (["--to", "xtc"], "xtc"),
        (["--frame", "1"], "belongs to trajectories"),
    ):
        code, text = cli("convert", folder / "HISTORY", *words)
        assert (code, found in text) == (2, True)
    code, text = cli("convert", folder / "HISTORY", "--to", "history", "-o", folder / "HISTORY")
    assert (code, "is the file to be read" in text) == (1, True)
    code, text = cli("convert", folder / "HISTORY", "--to", "config", "--frame", 9, "-o", folder / "C")
    assert (code, "no such frame" in text) == (1, True)
    assert set(TARGETS) >= {"history", "config", "gsd"}


def test_a_failed_conversion_leaves_the_target(tmp_path: Path, out: Path) -> None:
    text = (out / "HISTORY").read_text()
    (tmp_path / "HISTORY").write_text(text + "this is no frame\n")
    (tmp_path / "old.gsd").write_bytes(b"what was there")
    with pytest.raises(InputError, match="expected 'timestep'"):
        convert_trajectory(tmp_path / "HISTORY", "gsd", tmp_path / "old.gsd")
    assert (tmp_path / "old.gsd").read_bytes() == b"what was there"
    assert set(listing(tmp_path)) == {"HISTORY", "old.gsd"}


@pytest.mark.parametrize("name", FILES)
def test_a_run_starts_from_a_trajectory(tmp_path: Path, out: Path, name: str) -> None:
    folder = run_folder(tmp_path / "in", {"restart": "noscale" if name != "dcd" else "clean"})
    scene = pydlpoly.load(folder, config=out / FILES[name])
    last = read_frame(out / FILES[name])
    np.testing.assert_array_equal(scene.beads.positions, last.positions)
    if name != "dcd":
        assert last.velocities is not None
        np.testing.assert_allclose(scene.beads.velocities, last.velocities, atol=1e-6)  # less the sum's rounding
    assert scene.sources[2] == str(out / FILES[name])
    run_scene(scene, tmp_path / "out", steps=5, threads=1)


def test_control_can_name_a_trajectory_as_start(tmp_path: Path, out: Path) -> None:
    folder = run_folder(tmp_path, {"io_file_config": "TRAJECTORY.h5md", "restart": "noscale", "traj_format": "h5md"})
    (folder / "CONFIG").unlink()
    (folder / "TRAJECTORY.h5md").write_bytes((out / "TRAJECTORY.h5md").read_bytes())
    scene = pydlpoly.load(folder)
    assert scene.bead_count == 160
    with pytest.raises(InputError, match="is an input file of this run"):
        run_scene(scene, folder, threads=1)


def test_the_same_forces_from_h5md(out: Path, tmp_path: Path) -> None:
    """H5MD keeps every bit: the state goes on as if it had come from the checkpoint's own positions."""
    folder = run_folder(tmp_path, {"restart": "noscale"})
    scene = pydlpoly.load(folder, config=out / "TRAJECTORY.h5md")
    resumed = pydlpoly.Simulation.resume(out / "REVIVE")
    np.testing.assert_array_equal(scene.beads.positions, resumed.positions)
    np.testing.assert_array_equal(scene.beads.velocities, resumed.velocities)


def test_molecules_are_seen_by_other_programs(tmp_path: Path) -> None:
    from dataclasses import replace

    scene = pydlpoly.load(example_folder("lipid"))
    output = replace(scene.output, trajectory_every=10, trajectory_formats=("gsd", "h5md", "dcd"))
    run_scene(replace(scene, output=output), tmp_path, steps=10, threads=1)
    for name in ("gsd", "h5md", "dcd"):
        found = open_reader(tmp_path / FILES[name]).topology
        np.testing.assert_array_equal(found.molecules, scene.beads.molecule)
        bonds = found.links["bond"]
        assert bonds.names == ("H-T", "T-T")
        expected = np.concatenate([term.beads for term in scene.bonded.terms if term.kind == "bond"])
        np.testing.assert_array_equal(bonds.beads, expected)


@pytest.mark.parametrize("name", ["gsd", "h5md", "dcd"])
def test_universe_of_a_scene_and_its_trajectory(out: Path, name: str) -> None:
    scene = pydlpoly.load(out.parent / "in")
    made = universe(scene, out / FILES[name])
    assert len(made.trajectory) == 5
    made.trajectory[-1]
    np.testing.assert_allclose(made.atoms.positions, read_frame(out / "HISTORY").positions, atol=1e-6)


def test_analyse_on_the_command_line(out: Path, cli: Callable[..., tuple[object, str]]) -> None:
    texts = [cli("analyse", out / file, "--rdf") for file in ("HISTORY", "TRAJECTORY.h5md")]
    assert texts[0][0] == texts[1][0] == 0
    assert texts[1][1].replace("TRAJECTORY.h5md", "HISTORY") == texts[0][1]


# -- Memory -----------------------------------------------------------------------------------------------------------

MEASURE = f"""
import resource, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from dataclasses import replace
from frames import frames
from pydlpoly.trajectories import open_writer, read
from pydlpoly.trajectories.convert import convert_trajectory
name, folder, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
frame = replace(frames(1, beads=1_000_000, level=1)[0], images=None, arrays={{}})
from pydlpoly.trajectories import FORMATS
from pathlib import Path
file = Path(folder) / f"file{{FORMATS[name].extension}}"
with open_writer(name, file, frame) as writer:
    for k in range(count):
        writer.write(replace(frame, step=k, time=0.1 * k))
del frame, writer
read_frames = sum(1 for _ in read(file))
assert read_frames == count
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] if name in ("extxyz", "history") else []) for name in FORMATS]
)
def test_a_million_beads_in_bounded_memory(tmp_path: Path, name: str) -> None:
    """Frames of 10⁶ beads (60 MB of arrays, text of 160 MB): two more of them take less memory than one does."""

    def peak(count: int) -> int:
        line = [sys.executable, "-c", MEASURE, name, str(tmp_path), str(count)]
        done = subprocess.run(line, capture_output=True, text=True, check=True, cwd=tmp_path)
        return int(done.stdout)

    two, four = peak(2), peak(4)
    assert four - two < 120
    assert four < 1500
