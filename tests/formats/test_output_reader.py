"""OUTPUT, STRPRF and single frames of HISTORY read back: what was written, also when it was cut anywhere."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.blocks import Estimate
from pydlpoly.formats.history import HistoryWriter, read_history
from pydlpoly.formats.history_sample import chosen, sample_history
from pydlpoly.formats.output import OutputWriter, RunSummary
from pydlpoly.formats.output_reader import read_output
from pydlpoly.formats.species_balance import SpeciesBalance
from pydlpoly.formats.strprf import ProfileTable, read_profile, write_profile

SUMMARY = RunSummary(
    steps=40,
    time=0.4,
    averaged_steps=30,
    averaged_time=0.3,
    elapsed=12.5,
    loop_seconds=12.0,
    averages=np.arange(37.0),
    fluctuations=np.ones(37),
    warnings=["first", "second, with (brackets)"],
    timings={"set-up": 0.25, "steps": 12.0, "of which motion and forces": 11.5},
    kinetic_temperature=Estimate(301.5, 0.25, 30, 15),
    configurational_temperature=Estimate(299.0, float("nan"), 3, 3),
    thermostat_temperature=300.0,
    energy_drift=Estimate(-1e-4, 2e-5, 30, 15),
    diffusion={"A": (1.5, 2.0)},
)


def write(path: Path, units: bool = True) -> None:
    words = {} if units else dict.fromkeys(("temperature_unit", "pressure_unit", "time_unit"), "")
    with OutputWriter(path, "1.2.3", "a title", **words) as output:
        output.text("Scene\n-----\na title\n\nRun\n---\n40 steps, 0.4 ps in all\n")
        output.text("seed 7, 3 threads (results do not depend on these)")
        for step in (0, 20, 40):
            output.block(step, 0.01 * step, 0.1 + step / 4, np.ones(37), np.ones(37))
        output.summary(SUMMARY)


@pytest.mark.parametrize("units", [True, False])
def test_output_says_what_was_written(tmp_path: Path, units: bool) -> None:
    write(tmp_path / "OUTPUT", units)
    log = read_output(tmp_path / "OUTPUT")
    assert (log.version, log.title, log.seed, log.threads, log.starts) == ("1.2.3", "a title", 7, 3, (0,))
    assert log.explanation.startswith("Scene\n-----\na title")
    assert log.steps.tolist() == [0, 20, 40]
    assert log.times.tolist() == [0.0, 0.2, 0.4]
    assert log.elapsed.tolist() == [0.1, 5.1, 10.1]
    assert (log.ended, log.last_step, log.averaged_steps, log.loop_seconds) == (True, 40, 30, 12.0)
    assert log.timings == dict(SUMMARY.timings)
    assert log.warnings == ("first", "second, with (brackets)")
    assert log.temperatures["kinetic"] == (301.5, 0.25)
    assert log.temperatures["configurational"][0] == 299.0
    assert np.isnan(log.temperatures["configurational"][1])
    assert log.temperatures["thermostat"][0] == 300.0
    assert log.energy_drift == (-1e-4, 2e-5)


def test_output_of_a_continued_run(tmp_path: Path) -> None:
    write(tmp_path / "OUTPUT")
    with OutputWriter(tmp_path / "OUTPUT", "1.3.0", "a title", append=True) as output:
        output.resume(40, "1.3.0")
        output.text("Scene\n-----\nanother\n")
        output.block(60, 0.6, 1.5, np.ones(37), np.ones(37))
    log = read_output(tmp_path / "OUTPUT")
    assert log.starts == (0, 40)
    assert log.version == "1.3.0"
    assert log.explanation == "Scene\n-----\nanother\n"
    assert log.steps.tolist() == [60]
    assert not log.ended
    assert log.last_step is None


def test_output_cut_anywhere_is_read_or_refused(tmp_path: Path) -> None:
    write(tmp_path / "OUTPUT")
    content = (tmp_path / "OUTPUT").read_bytes()
    for length in range(0, len(content), 97):
        (tmp_path / "cut").write_bytes(content[:length])
        if b"pydlpoly 1.2.3\n" not in content[:length]:
            with pytest.raises(InputError, match="is no OUTPUT of pydlpoly"):
                read_output(tmp_path / "cut")
            continue
        log = read_output(tmp_path / "cut")
        assert not log.ended
        assert log.steps.tolist() == [0, 20, 40][: len(log.steps)]


def test_profile_says_what_was_written(tmp_path: Path) -> None:
    columns = np.random.default_rng(1).random((5, 6))
    written = ProfileTable(
        title="a: title",
        axis="y",
        samples=12,
        pressure_unit="katm",
        length_unit="ang",
        tension_unit="dyn/cm",
        tension=Estimate(1.5, 0.25, 12, 8),
        cell_tension=Estimate(-2.0, float("nan"), 12, 8),
        heights=columns[0],
        normal=columns[1],
        lateral=columns[2],
        normal_error=columns[3],
        lateral_error=columns[4],
        parts={"kinetic": np.ones((6, 6)), "bonded": np.arange(36.0).reshape(6, 6)},
        densities={"A": columns[0], "B_2": columns[1]},
    )
    write_profile(tmp_path / "STRPRF", written)
    read = read_profile(tmp_path / "STRPRF")
    for name in ("title", "axis", "samples", "pressure_unit", "length_unit", "tension_unit"):
        assert getattr(read, name) == getattr(written, name), name
    for name in ("heights", "normal", "lateral", "normal_error", "lateral_error"):
        np.testing.assert_allclose(getattr(read, name), getattr(written, name), rtol=1e-8)
    for name, part in {**written.parts, **written.densities}.items():
        np.testing.assert_allclose({**read.parts, **read.densities}[name], part, rtol=1e-8)
    assert (read.tension.value, read.tension.error, read.cell_tension.value) == (1.5, 0.25, -2.0)
    (tmp_path / "STRPRF").write_text("# something else\n1 2 3\n")
    with pytest.raises(InputError, match="is no STRPRF"):
        read_profile(tmp_path / "STRPRF")


def history(path: Path, frames: int, level: int = 1) -> None:
    rng = np.random.default_rng(2)
    with HistoryWriter(path, "made", level, 1, ["A", "B", "A"], np.ones(3), np.zeros(3)) as writer:
        for k in range(frames):
            writer.write(10 * k, 0.1 * k, 0.01, 5.0 * np.eye(3), rng.random((3, 3)), rng.random((3, 3)))


@pytest.mark.parametrize("plain", [True, False])
@pytest.mark.parametrize(("count", "most"), [(1, 5), (7, 3), (7, 7), (20, 6), (100, 1)])
def test_frames_are_spread_over_the_file(tmp_path: Path, count: int, most: int, plain: bool) -> None:
    """Those that are skipped to, and those of a file of other record lengths, which is read through."""
    path = tmp_path / "HISTORY"
    history(path, count)
    every = list(read_history(path))
    if not plain:
        path.write_text("\n".join(line.rstrip() for line in path.read_text().split("\n")))
    sample = sample_history(path, most)
    assert (sample.count, sample.cut) == (count, "")
    assert 1 <= len(sample.frames) <= most
    assert sample.frames[-1].step == 10 * (count - 1)
    for frame in sample.frames:
        same = every[frame.step // 10]
        np.testing.assert_array_equal(frame.positions, same.positions)
        assert frame.names == same.names
    if plain:
        assert [frame.step // 10 for frame in sample.frames] == chosen(count, most)


@pytest.mark.parametrize("plain", [True, False])
def test_a_frame_that_is_cut_is_left_out_and_said(tmp_path: Path, plain: bool) -> None:
    path = tmp_path / "HISTORY"
    history(path, 6)
    if not plain:
        path.write_text("\n".join(line.rstrip() for line in path.read_text().split("\n")))
    path.write_bytes(path.read_bytes()[:-200])
    sample = sample_history(path, 3)
    assert sample.count == 5
    assert sample.frames[-1].step == 40
    assert "cut short" in sample.cut


def test_no_frame_yet(tmp_path: Path) -> None:
    history(tmp_path / "HISTORY", 0)
    assert sample_history(tmp_path / "HISTORY", 3).frames == ()
    with pytest.raises(ValueError, match="at least one frame"):
        sample_history(tmp_path / "HISTORY", 0)


def test_heat_and_balances_are_read(tmp_path: Path) -> None:
    """Print-outs with further lines, and the table of dissolved species at the end."""
    balances = (
        SpeciesBalance("sugar", 10.0, 1.5, -2.25, 0.125, 9.375 + 3e-12),
        SpeciesBalance("b", 0.0, 0.0, 2.25, 0.0, 2.25),
    )
    path = tmp_path / "OUTPUT"
    with OutputWriter(path, "1.2.3", "a title") as output:
        for step in (0, 20, 40):
            more = [("internal temperature [K]", 300.0 + step), ("conserved energy", -1.5e-3 * step)]
            output.block(step, 0.01 * step, 0.1, np.ones(37), np.ones(37), more)
        output.summary(replace(SUMMARY, species_balance=balances))
    log = read_output(path)
    assert log.steps.tolist() == [0, 20, 40]
    assert {name: values.tolist() for name, values in log.printed.items()} == {
        "internal temperature": [300.0, 320.0, 340.0],
        "conserved energy": [0.0, -0.03, -0.06],
    }
    for one, other in zip(log.species_balance, balances, strict=True):
        assert (one.name, one.start, one.sources, one.reactions, one.held) == (
            other.name, other.start, other.sources, other.reactions, other.held
        )  # fmt: skip
        assert one.remainder == pytest.approx(other.remainder, abs=4e-15)
    write(path)
    assert read_output(path).printed == {}
    assert read_output(path).species_balance == ()
