"""The files of a real run, judged by numpy, MDAnalysis and dlpoly-py, and their physics."""

from __future__ import annotations

import warnings
from pathlib import Path

import MDAnalysis
import numpy as np
import pytest

import pydlpoly
from pydlpoly.formats.config import read_config
from pydlpoly.formats.history import read_history, read_history_header
from pydlpoly.formats.rdfdat import read_rdf
from pydlpoly.formats.statis import read_statistics
from pydlpoly.reporters import every
from pydlpoly.runner import RunResult, run_scene

from .run_folders import COUNTS, EDGE, run_folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_folder(
        tmp_path_factory.mktemp("run"),
        {
            "traj_key": "pos-vel-force",
            "rdf_binsize": "0.05 dpd_l",
            "traj_interval": "5 steps",
            "rdf_frequency": "5 steps",
        },
    )


@pytest.fixture(scope="module")
def result(folder: Path) -> RunResult:
    return run_scene(pydlpoly.load(folder), folder, threads=1)


@pytest.mark.parametrize(
    ("step", "interval", "start", "expected"),
    [
        (0, 5, 0, 5),
        (5, 5, 0, 10),
        (4, 5, 0, 5),
        (0, 0, 0, None),
        (0, 5, 3, 3),
        (3, 5, 3, 8),
        (7, 5, 8, 8),
        (9, 1, 0, 10),
    ],
)
def test_every(step: int, interval: int, start: int, expected: int | None) -> None:
    assert every(step, interval, start) == expected


def test_revcon_is_the_state(result: RunResult, folder: Path) -> None:
    written, state = read_config(folder / "REVCON"), result.simulation.state
    assert (written.step, written.timestep, written.time) == (40, 0.01, pytest.approx(0.4))
    assert written.names == tuple(name for name, count in COUNTS.items() for _ in range(count))
    for array, expected in (
        (written.positions, state.positions),
        (written.velocities, state.velocities),
        (written.forces, state.forces),
    ):
        np.testing.assert_allclose(array, expected, rtol=1e-9, atol=1e-10)
    np.testing.assert_array_equal(written.cell, EDGE * np.eye(3))


def test_last_frame_of_history_is_the_state(result: RunResult, folder: Path) -> None:
    frames, state = list(read_history(folder / "HISTORY")), result.simulation.state
    assert [frame.step for frame in frames] == list(range(0, 41, 5))
    last = frames[-1]
    np.testing.assert_allclose(last.positions, state.positions, rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(last.velocities, state.velocities, rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(last.forces, state.forces, rtol=1e-9, atol=1e-10)
    moved = np.linalg.norm(state.unwrapped - frames[0].positions, axis=1)
    np.testing.assert_allclose(last.displacements, moved, atol=2e-6)


@pytest.mark.parametrize(("key", "level"), [("pos", 0), ("pos-vel", 1), ("pos-vel-force", 2)])
def test_trajectory_levels(tmp_path: Path, key: str, level: int) -> None:
    run_folder(tmp_path, {"traj_key": key})
    run_scene(pydlpoly.load(tmp_path), tmp_path, steps=10, threads=1)
    assert read_history_header(tmp_path / "HISTORY").level == level
    frame = list(read_history(tmp_path / "HISTORY"))[-1]
    assert (frame.velocities is not None, frame.forces is not None) == (level >= 1, level >= 2)


def test_compressed_trajectory_is_refused_by_name(tmp_path: Path) -> None:
    run_folder(tmp_path, {"traj_key": "compressed"})
    with pytest.raises(pydlpoly.SceneError, match=r"CONTROL:\d+: 'traj_key': .*compressed"):
        pydlpoly.load(tmp_path)


def test_rdfdat_is_the_pair_distribution_of_the_frames(result: RunResult, folder: Path) -> None:
    """g(r) counted anew from the printed frames; step 0 is not sampled."""
    table = read_rdf(folder / "RDFDAT")
    frames = list(read_history(folder / "HISTORY"))[1:]
    assert result.simulation.distance_counts()[1] == len(frames) == 8
    edges = np.linspace(0.0, 1.0, 21)
    shells = 4.0 / 3.0 * np.pi * np.diff(edges**3)
    kinds = np.repeat(np.arange(2), list(COUNTS.values()))
    for (a, b), like in (((0, 0), True), ((0, 1), False), ((1, 1), True)):
        counted = np.zeros(20)
        for frame in frames:
            apart = frame.positions[kinds == a][:, None] - frame.positions[kinds == b][None, :]
            apart -= EDGE * np.round(apart / EDGE)
            r = np.linalg.norm(apart, axis=-1)
            r = r[np.triu_indices(len(r), 1)] if like else r.ravel()
            counted += np.histogram(r, edges)[0]
        n = [int(np.sum(kinds == k)) for k in (a, b)]
        pairs = n[0] * (n[0] - 1) / 2 if like else n[0] * n[1]
        expected = counted / (len(frames) * pairs * shells / EDGE**3)
        np.testing.assert_allclose(table["AB"[a], "AB"[b]], expected, rtol=2e-6, atol=1e-9)
        assert expected.max() > 0.5


def test_statis_agrees_with_the_run(result: RunResult, folder: Path) -> None:
    table, seen = read_statistics(folder / "STATIS"), result.simulation.observe()
    assert table.step.tolist() == [0, 10, 20, 30, 40]
    last = {name: table[name][-1] for name in ("temperature", "pressure", "short_range_energy", "volume")}
    assert last["temperature"] == pytest.approx(seen.temperature, rel=1e-6)
    assert last["pressure"] == pytest.approx(seen.pressure, rel=1e-6)
    assert last["short_range_energy"] == pytest.approx(seen.energy["pair"], rel=1e-6)
    assert last["volume"] == EDGE**3
    np.testing.assert_allclose(np.reshape(table.stress[-1], (3, 3)), seen.stress, rtol=1e-5, atol=1e-5)
    state = result.simulation.state
    first = next(read_history(folder / "HISTORY"))
    square = np.sum((state.unwrapped - first.positions) ** 2, axis=1)
    msd = table.values[-1, -2:]
    np.testing.assert_allclose(msd, [square[: COUNTS["A"]].mean(), square[COUNTS["A"] :].mean()], rtol=1e-6)


def test_mdanalysis_reads_history_and_revcon(result: RunResult, folder: Path) -> None:
    state = result.simulation.state
    history = str(folder / "HISTORY")
    universe = MDAnalysis.Universe(history, topology_format="HISTORY", format="HISTORY", to_guess=())
    assert len(universe.trajectory) == 9
    universe.trajectory[-1]
    np.testing.assert_allclose(universe.trajectory.ts.positions, state.positions, atol=1e-5)
    np.testing.assert_allclose(universe.trajectory.ts.velocities, state.velocities, atol=1e-5)
    revcon = str(folder / "REVCON")
    single = MDAnalysis.Universe(revcon, topology_format="CONFIG", format="CONFIG", to_guess=())
    np.testing.assert_allclose(single.atoms.positions, state.positions, atol=1e-5)
    assert list(single.atoms.names[:2]) == ["A", "A"]


def test_dlpoly_py_reads_statis(result: RunResult, folder: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from dlpoly.statis import Statis

        judge = Statis(str(folder / "STATIS"))
    assert judge.rows == 5
    rows = np.asarray(judge.data)
    np.testing.assert_allclose(rows[:, 0], [0, 10, 20, 30, 40])
    np.testing.assert_allclose(rows[-1, 4], result.simulation.temperature, rtol=1e-6)
