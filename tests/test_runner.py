"""run_scene: names of files, backups, what is refused before anything is touched, checkpoints, averages, interrupts."""

from __future__ import annotations

import os
import re
import signal
import threading
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pydlpoly
from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.atomic import sole_writer
from pydlpoly.formats.checkpoint import read_checkpoint, write_checkpoint
from pydlpoly.formats.history import read_history
from pydlpoly.formats.rdfdat import read_rdf
from pydlpoly.formats.statis import read_statistics
from pydlpoly.interrupts import deferred_signals
from pydlpoly.runner import RunResult, run_scene
from pydlpoly.scene import load

from .run_folders import listing, run_folder

RESULTS = ("REVCON", "STATIS", "HISTORY", "RDFDAT")
USUAL = {"OUTPUT", "STATIS", "HISTORY", "RDFDAT", "REVCON", "REVIVE"}


def run(folder: Path, settings: dict[str, str | None] | None = None, **options: object) -> RunResult:
    """Write the inputs into folder/in, run them into folder/out with one thread."""
    scene = pydlpoly.load(run_folder(folder / "in", settings))
    return run_scene(scene, folder / "out", threads=1, **options)  # type: ignore[arg-type]


def test_files_and_result(tmp_path: Path) -> None:
    result = run(tmp_path)
    assert set(listing(tmp_path / "out")) == USUAL
    assert not result.interrupted
    assert result.checkpoint == tmp_path / "out" / "REVIVE"
    assert result.summary.steps == result.simulation.step == 40


def test_records_of_every_file(tmp_path: Path) -> None:
    run(tmp_path, {"time_run": "45 steps", "traj_start": "5 steps", "traj_interval": "20 steps"})
    out = tmp_path / "out"
    assert read_statistics(out / "STATIS").step.tolist() == [0, 10, 20, 30, 40]
    assert [frame.step for frame in read_history(out / "HISTORY")] == [5, 25, 45]
    printed = re.findall(r"(?m)^ {8,}(\d+)  [-\d]", (out / "OUTPUT").read_text())
    assert [int(step) for step in printed[:3]] == [0, 20, 40]


def test_names_from_control_and_none(tmp_path: Path) -> None:
    names = {
        "io_file_output": "log",
        "io_file_statis": "stats",
        "io_file_history": "trajectory",
        "io_file_rdf": "rdf",
        "io_file_revcon": "last",
        "io_file_revive": "checkpoint",
    }
    run(tmp_path / "named", names)  # type: ignore[arg-type]
    assert set(listing(tmp_path / "named" / "out")) == set(names.values())
    run(tmp_path / "none", dict.fromkeys(names, "NONE"))
    assert listing(tmp_path / "none" / "out") == {}


def test_screen_goes_to_standard_output(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(tmp_path, {"io_file_output": "SCREEN"})
    shown = capsys.readouterr()
    assert "run terminated after 40 steps" in shown.out
    assert shown.err == ""
    assert set(listing(tmp_path / "out")) == USUAL - {"OUTPUT"}


def test_statistics_as_yaml(tmp_path: Path) -> None:
    run(tmp_path, {"io_statis_yaml": "on"})
    assert (tmp_path / "out" / "STATIS").read_text().startswith("%YAML")
    assert read_statistics(tmp_path / "out" / "STATIS").step.tolist() == [0, 10, 20, 30, 40]


def test_files_of_an_earlier_run_are_kept_once(tmp_path: Path) -> None:
    run(tmp_path, {"random_seed": "[ 1 1 1 ]"})
    first = listing(tmp_path / "out")
    run(tmp_path, {"random_seed": "[ 2 2 2 ]"})
    second = listing(tmp_path / "out")
    assert {name.removesuffix(".bak") for name in second} == USUAL
    for name in USUAL:
        assert second[name + ".bak"] == first[name]
    assert second["STATIS"] != first["STATIS"]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"io_file_revcon": "CONFIG"}, "CONFIG: is an input file of this run"),
        ({"io_file_output": "CONTROL"}, "CONTROL: is an input file of this run"),
        ({"io_file_history": "STATIS"}, "STATIS: two output files"),
        ({"io_file_revive": "nowhere/REVIVE"}, "nowhere/REVIVE: cannot be written: there is no such folder"),
        ({"io_file_history": "folder"}, "folder: is a folder"),
    ],
)
def test_refused_before_anything_is_touched(tmp_path: Path, settings: dict[str, str | None], message: str) -> None:
    run_folder(tmp_path)
    run_scene(pydlpoly.load(tmp_path), tmp_path, threads=1)
    (tmp_path / "folder").mkdir()
    run_folder(tmp_path, settings)
    before = listing(tmp_path)
    with pytest.raises(InputError, match=message):
        run_scene(pydlpoly.load(tmp_path), tmp_path, threads=1)
    assert listing(tmp_path) == before


def test_output_folder_that_is_a_file(tmp_path: Path) -> None:
    scene = pydlpoly.load(run_folder(tmp_path))
    with pytest.raises(InputError, match=r"CONFIG: the output folder cannot be used: File exists"):
        run_scene(scene, tmp_path / "CONFIG")


def test_two_runs_do_not_write_into_one_folder(tmp_path: Path) -> None:
    folder = run_folder(tmp_path)
    run_scene(load(folder), folder)
    before = listing(folder)
    with sole_writer(folder), pytest.raises(InputError, match="another run is writing into this folder"):
        run_scene(load(folder), folder)
    assert listing(folder) == before
    run_scene(load(folder), folder)  # the hold ends with its block


def test_run_of_no_steps(tmp_path: Path) -> None:
    result = run(tmp_path, steps=0)
    assert result.summary.steps == 0
    assert not result.interrupted
    assert read_statistics(tmp_path / "out" / "STATIS").step.tolist() == [0]
    assert "run terminated after 0 steps ( 0.000), no averages were taken" in (tmp_path / "out" / "OUTPUT").read_text()


@pytest.mark.parametrize(
    ("settings", "covered", "samples"),
    [
        ({}, 40, 4),
        ({"time_equilibration": "20 steps"}, 20, 2),
        ({"time_equilibration": "25 steps"}, 15, 2),
        ({"time_run": "47 steps"}, 40, 4),
        ({"time_equilibration": "20 steps", "record_equilibration": "on"}, 40, 4),
        ({"stats_frequency": "0 steps"}, 40, 2),
        ({"time_equilibration": "39 steps"}, 1, 1),
    ],
)
def test_averages_say_what_they_cover(
    tmp_path: Path, settings: dict[str, str | None], covered: int, samples: int
) -> None:
    result = run(tmp_path, settings)
    assert (result.summary.averaged_steps, result.summary.samples) == (covered, samples)
    words = f"averages calculated over {covered} steps ( {covered * 0.01:.3f}) from {samples} samples\n"
    assert words in (tmp_path / "out" / "OUTPUT").read_text()


def test_averages_are_those_of_statis(tmp_path: Path) -> None:
    result = run(tmp_path, {"time_equilibration": "20 steps", "stats_frequency": "1 steps"})
    table = read_statistics(tmp_path / "out" / "STATIS")
    after = table.values[table.step > 20]
    np.testing.assert_allclose(result.summary.averages, after.mean(axis=0), rtol=2e-6, atol=1e-9)
    np.testing.assert_allclose(result.summary.fluctuations, after.std(axis=0), rtol=1e-3, atol=1e-4)
    parts = sum(result.summary.pressure_parts.values())
    np.testing.assert_allclose(np.ravel(parts), result.summary.averages[28:37], rtol=1e-12, atol=1e-12)


def test_output_tells_the_run_as_it_is(tmp_path: Path) -> None:
    run(tmp_path, {"random_seed": None}, steps=30, seed=77)
    text = (tmp_path / "out" / "OUTPUT").read_text()
    assert "seed: 77" in text
    assert "\n30 steps, " in text
    assert not re.search(r"[ \t]$", text.split("Pressure tensor:")[1], re.MULTILINE), "no unit, no trailing blanks"
    assert "10^-9" not in text
    assert "katm" not in text


def test_output_of_a_scene_with_units(tmp_path: Path) -> None:
    from pydlpoly.cli import example_folder

    run_scene(pydlpoly.load(example_folder("argon")), tmp_path, steps=2, threads=1)
    text = (tmp_path / "OUTPUT").read_text()
    assert "( 0.010 ps)" in text
    assert "temp_tot[K]" in text


# -- continuing -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("first", [1, 10, 23, 39])
def test_continued_run_equals_an_uninterrupted_one(tmp_path: Path, first: int) -> None:
    settings: dict[str, str | None] = {"time_equilibration": "15 steps", "rescale_frequency": "4 steps"}
    run(tmp_path / "whole", settings)
    run(tmp_path / "parts", settings, steps=first)
    result = run(tmp_path / "parts", settings, checkpoint=tmp_path / "parts" / "out" / "REVIVE")
    whole, parts = tmp_path / "whole" / "out", tmp_path / "parts" / "out"
    for name in RESULTS:
        assert (whole / name).read_bytes() == (parts / name).read_bytes(), name
    assert (result.summary.averaged_steps, result.summary.samples) == (25, 3)
    end = "final averages calculated over 25 steps"
    assert end in (parts / "OUTPUT").read_text()
    assert result.summary.loop_steps == 40 - first


def test_continued_with_a_smaller_stack(tmp_path: Path) -> None:
    run(tmp_path, {"stack_size": "300 steps", "stats_frequency": "1 steps"}, steps=35)
    result = run(
        tmp_path,
        {"stack_size": "120 steps", "stats_frequency": "1 steps", "time_run": "150 steps"},
        checkpoint=tmp_path / "out" / "REVIVE",
    )
    rolling = result.simulation.reporters[0]._rolling.mean()  # type: ignore[attr-defined]
    table = read_statistics(tmp_path / "out" / "STATIS")
    np.testing.assert_allclose(rolling, table.values[-120:].mean(axis=0), rtol=2e-6, atol=1e-9)


def test_records_after_an_older_checkpoint_are_not_doubled(tmp_path: Path) -> None:
    run(tmp_path, steps=20)
    early = (tmp_path / "out" / "REVIVE").read_bytes()
    run(tmp_path, checkpoint=tmp_path / "out" / "REVIVE")
    whole = listing(tmp_path / "out")
    (tmp_path / "out" / "REVIVE").write_bytes(early)
    run(tmp_path, checkpoint=tmp_path / "out" / "REVIVE")
    for name in RESULTS:
        assert (tmp_path / "out" / name).read_bytes() == whole[name], name


def test_seed_of_a_continued_run_is_the_checkpoints(tmp_path: Path) -> None:
    run(tmp_path, steps=20, seed=11)
    with pytest.raises(InputError, match="keeps the seed of its checkpoint"):
        run(tmp_path, checkpoint=tmp_path / "out" / "REVIVE", seed=12)
    assert run(tmp_path, checkpoint=tmp_path / "out" / "REVIVE").simulation.seed == 11


def test_scene_that_wants_a_checkpoint_does_not_start_without(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="say which checkpoint"):
        run(tmp_path, {"restart": "continue"})
    assert not (tmp_path / "out").exists()


def test_finished_run_is_not_continued(tmp_path: Path) -> None:
    run(tmp_path)
    before = listing(tmp_path / "out")
    with pytest.raises(InputError, match="is at step 40 already"):
        run(tmp_path, checkpoint=tmp_path / "out" / "REVIVE")
    assert listing(tmp_path / "out") == before


def _other(scene: pydlpoly.Scene, what: str) -> pydlpoly.Scene:
    beads = scene.beads
    if what == "other masses":
        return replace(scene, beads=replace(beads, mass=beads.mass * 2.0))
    if what == "other charges":
        return replace(scene, beads=replace(beads, charge=beads.charge + 1.0))
    if what == "other frozen beads":
        return replace(scene, beads=replace(beads, frozen=np.arange(len(beads)) == 3))
    if what == "other species":
        return replace(scene, beads=replace(beads, species=beads.species[::-1].copy()))
    if what == "another cell":
        return replace(scene, cell=scene.cell * 1.001)
    output = replace(scene.output, rdf_bin_width=0.1)
    return replace(scene, output=output)


@pytest.mark.parametrize(
    "what",
    ["other masses", "other charges", "other frozen beads", "other species", "another cell", "radial distribution"],
)
def test_checkpoint_of_another_scene(tmp_path: Path, what: str) -> None:
    run(tmp_path, steps=20)
    before = listing(tmp_path / "out")
    scene = _other(pydlpoly.load(tmp_path / "in"), what)
    with pytest.raises(InputError, match=rf"REVIVE: .*{what}"):
        run_scene(scene, tmp_path / "out", checkpoint=tmp_path / "out" / "REVIVE", threads=1)
    assert listing(tmp_path / "out") == before


def test_checkpoint_of_another_number_of_beads(tmp_path: Path) -> None:
    from pydlpoly.cli import example_folder

    run(tmp_path, steps=20)
    with pytest.raises(InputError, match="holds 160 beads, but the scene to go on with has 3000"):
        run_scene(
            pydlpoly.load(example_folder("water")), tmp_path / "x", checkpoint=tmp_path / "out" / "REVIVE", threads=1
        )
    assert not (tmp_path / "x").exists()


def test_configuration_from_revcon_may_go_with_the_checkpoint(tmp_path: Path) -> None:
    """DL_POLY's users copy REVCON to CONFIG and REVIVE to REVOLD; the last digits come from the checkpoint."""
    run(tmp_path / "whole")
    run(tmp_path / "parts", steps=17)
    out = tmp_path / "parts" / "out"
    scene = pydlpoly.load(tmp_path / "parts" / "in", config=out / "REVCON")
    run_scene(scene, out, checkpoint=out / "REVIVE", threads=1)
    for name in RESULTS:
        assert (out / name).read_bytes() == (tmp_path / "whole" / "out" / name).read_bytes(), name


def _cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-3000])


def _flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        entry = archive.getinfo("velocities.npy")
    content[entry.header_offset + entry.compress_size // 2 + 100] ^= 1  # between its head and its end
    path.write_bytes(bytes(content))


def _fortran(path: Path) -> None:
    path.write_bytes(b"\x18\0\0\0" + bytes(200))


def _arrays(path: Path) -> None:
    np.savez(path.with_suffix(".npz"), positions=np.zeros((2, 3)))
    path.with_suffix(".npz").replace(path)


def _newer(path: Path) -> None:
    arrays, meta = read_checkpoint(path)
    meta["scene"]["fields"]["field_of_tomorrow"] = 1
    write_checkpoint(path, arrays, meta)


def _without_forces(path: Path) -> None:
    arrays, meta = read_checkpoint(path)
    del arrays["forces"]
    write_checkpoint(path, arrays, meta)


def _without_averages(path: Path) -> None:
    arrays, meta = read_checkpoint(path)
    write_checkpoint(path, {name: a for name, a in arrays.items() if name != "reporter.averages.span"}, meta)


def _short(path: Path) -> None:
    arrays, meta = read_checkpoint(path)
    write_checkpoint(path, {**arrays, "velocities": arrays["velocities"][:-1]}, meta)


def _scene_of_words(path: Path) -> None:
    arrays, meta = read_checkpoint(path)
    write_checkpoint(path, arrays, {**meta, "scene": {"class": "Scene", "fields": "none"}})


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (_cut, "cut short or damaged"),
        (_flip, "damaged"),
        (_fortran, "DL_POLY's own REVIVE and REVOLD cannot be read"),
        (_arrays, "not a checkpoint of pydlpoly"),
        (_newer, "scene of another version"),
        (_without_forces, "lacks 'forces'"),
        (_without_averages, "averages of another version"),
        (_short, "does not fit"),
        (_scene_of_words, "scene of another version"),
        (lambda path: path.write_bytes(b""), "is empty"),
    ],
)
def test_damaged_and_foreign_checkpoints(tmp_path: Path, damage: Callable[[Path], None], message: str) -> None:
    run(tmp_path, steps=20)
    damage(tmp_path / "out" / "REVIVE")
    before = listing(tmp_path / "out")
    with pytest.raises(InputError, match=message):
        run(tmp_path, checkpoint=tmp_path / "out" / "REVIVE")
    assert listing(tmp_path / "out") == before


def test_checkpoint_is_an_ordinary_archive(tmp_path: Path) -> None:
    run(tmp_path, steps=20)
    assert "positions.npy" in zipfile.ZipFile(tmp_path / "out" / "REVIVE").namelist()


# -- ending early -----------------------------------------------------------------------------------------------------


def test_failure_names_the_checkpoint_to_go_on_from(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A bead gets lost at step 25, after the checkpoint of step 20; what is on the disk stays as it was."""
    advance = pydlpoly.Simulation._advance

    def fail(self: pydlpoly.Simulation, steps: int) -> None:
        advance(self, min(steps, max(1, 25 - self.step)))
        if self.step >= 25:
            raise RunError("step 25: bead 1 left all bounds")

    monkeypatch.setattr(pydlpoly.Simulation, "_advance", fail)
    with pytest.raises(RunError, match="bead 1 left all bounds; the last checkpoint is that of step 20"):
        run(tmp_path)
    monkeypatch.undo()
    assert pydlpoly.Simulation.resume(tmp_path / "out" / "REVIVE").step == 20
    assert "the run stopped: step 25" in (tmp_path / "out" / "OUTPUT").read_text()
    run(tmp_path, checkpoint=tmp_path / "out" / "REVIVE")
    assert read_statistics(tmp_path / "out" / "STATIS").step.tolist() == [0, 10, 20, 30, 40]


class Killer:
    """Sends this process a signal at one step."""

    def __init__(self, step: int, number: int) -> None:
        self.step, self.number = step, number

    def next_step(self, step: int) -> int | None:
        return self.step if step < self.step else None

    def report(self, _simulation: pydlpoly.Simulation) -> None:
        os.kill(os.getpid(), self.number)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("step", [10, 23, 40])
def test_signal_among_the_reporters_loses_no_record(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, step: int
) -> None:
    """The signal comes before the reporters of its step have been called; all of them are, once."""
    run(tmp_path / "whole")
    begin = pydlpoly.Simulation.run

    def with_killer(self: pydlpoly.Simulation, *arguments: int, **options: bool) -> None:
        self.reporters.insert(0, Killer(step, number))
        begin(self, *arguments, **options)

    monkeypatch.setattr(pydlpoly.Simulation, "run", with_killer)
    result = run(tmp_path / "parts")
    monkeypatch.undo()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    assert result.interrupted == (step < 40)
    assert result.simulation.step == step
    out = tmp_path / "parts" / "out"
    if result.interrupted:
        assert f"interrupted at step {step} of 40" in (out / "OUTPUT").read_text()
        run(tmp_path / "parts", checkpoint=out / "REVIVE")
    for name in RESULTS:
        assert (out / name).read_bytes() == (tmp_path / "whole" / "out" / name).read_bytes(), name


def test_runs_in_another_thread(tmp_path: Path) -> None:
    results: list[RunResult] = []
    thread = threading.Thread(target=lambda: results.append(run(tmp_path)))
    thread.start()
    thread.join()
    assert results[0].simulation.step == 40


def test_a_second_interrupt_later_does_not_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("pydlpoly.interrupts.clock.monotonic", lambda: now[0])
    calls: list[int] = []
    with deferred_signals(lambda: calls.append(1)):
        signal.raise_signal(signal.SIGINT)
        now[0] = 0.5
        signal.raise_signal(signal.SIGINT)
        now[0] = 1.5
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert calls == [1, 1]


def test_ignored_signals_stay_ignored() -> None:
    previous = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with deferred_signals(lambda: pytest.fail("called")):
            signal.raise_signal(signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, previous)


def test_rdf_does_not_count_the_equilibration(tmp_path: Path) -> None:
    result = run(tmp_path / "after", {"time_equilibration": "20 steps"})
    assert result.simulation.distance_counts()[1] == 2
    both = run(tmp_path / "all", {"time_equilibration": "20 steps", "record_equilibration": "on"})
    assert both.simulation.distance_counts()[1] == 4
    assert read_rdf(tmp_path / "after" / "out" / "RDFDAT").pairs == (("A", "A"), ("A", "B"), ("B", "B"))


def test_output_says_where_the_time_of_the_loop_went(tmp_path: Path) -> None:
    result = run_scene(load(run_folder(tmp_path, {"diagnostics_frequency": "10 steps"})), tmp_path)
    timings = dict(result.summary.timings)
    parts = {name.removeprefix("of which "): t for name, t in timings.items() if name.startswith("of which ")}
    files = {"STATIS", "DIAGNOSTICS", "HISTORY", "checkpoints", "OUTPUT, averages"}
    assert set(parts) == {"motion and forces", *files}
    assert all(seconds > 0.0 for seconds in parts.values())
    assert 0.5 * timings["steps"] < sum(parts.values()) <= timings["steps"]
    assert "of which motion and forces" in (tmp_path / "OUTPUT").read_text()
    # A run whose last step is no step of a checkpoint writes one after the loop.
    result = run_scene(load(run_folder(tmp_path, {"data_dump_frequency": "0 steps"})), tmp_path)
    assert result.summary.timings["last checkpoint"] > 0.0
    assert "of which checkpoints" not in result.summary.timings
