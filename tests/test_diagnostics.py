"""Diagnostics of whole runs: DIAGNOSTICS, temperatures and drifts at the end of OUTPUT, warnings, the progress bar."""

from __future__ import annotations

import io
import math
import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from rich.progress import Progress, TextColumn

import pydlpoly
from pydlpoly import progress
from pydlpoly.cli import example_folder
from pydlpoly.errors import InputError
from pydlpoly.formats.checkpoint import read_checkpoint
from pydlpoly.formats.control import parse_control, write_control
from pydlpoly.formats.diagnostics import read_diagnostics
from pydlpoly.formats.output import RunSummary
from pydlpoly.formats.statis import read_statistics
from pydlpoly.runner import RunResult, run_scene
from pydlpoly.temperatures import TemperatureSamples

from .run_folders import COUNTS, listing, run_folder
from .scene_builder import make_scene

EVERY_TEN: dict[str, str | None] = {"diagnostics_frequency": "10 steps"}
NVE: dict[str, str | None] = {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None}
RESULTS = ("REVCON", "STATIS", "HISTORY", "RDFDAT")


def run(folder: Path, settings: dict[str, str | None] | None = None, **options: object) -> RunResult:
    scene = pydlpoly.load(run_folder(folder / "in", settings))
    return run_scene(scene, folder / "out", threads=1, **options)  # type: ignore[arg-type]


# -- the file ---------------------------------------------------------------------------------------------------------


def test_records_are_those_of_the_run(tmp_path: Path) -> None:
    result = run(tmp_path, {**EVERY_TEN, "time_run": "45 steps"})
    columns, table = read_diagnostics(tmp_path / "out" / "DIAGNOSTICS"), read_statistics(tmp_path / "out" / "STATIS")
    assert columns["step"].tolist() == table.step.tolist() == [0, 10, 20, 30, 40]
    np.testing.assert_allclose(columns["time"], table.time, rtol=1e-6)
    np.testing.assert_allclose(columns["kinetic_temperature"], table["temperature"], rtol=1e-6)
    parts = sum(columns[f"pressure_{name}"] for name in ("kinetic", "conservative", "drag", "noise", "bonded"))
    np.testing.assert_allclose(parts, table["pressure"], rtol=1e-6)
    np.testing.assert_allclose(columns["energy"] * sum(COUNTS.values()), table["extended_energy"], rtol=1e-6)
    np.testing.assert_allclose(
        columns["configurational_temperature"], columns["squared_force"] / columns["laplacian"], rtol=1e-8
    )
    assert np.abs([columns[f"momentum_{axis}"] for axis in "xyz"]).max() < 1e-10
    assert "DIAGNOSTICS: every 10 steps" in result.simulation.scene.explain()


def test_last_record_is_the_state(tmp_path: Path) -> None:
    result = run(tmp_path, EVERY_TEN)
    columns = read_diagnostics(tmp_path / "out" / "DIAGNOSTICS")
    seen = pydlpoly.Simulation.resume(result.checkpoint, threads=1)  # type: ignore[arg-type]  # there is one
    assert columns["configurational_temperature"][-1] == pytest.approx(seen.configurational_temperature, rel=1e-9)
    found = columns["squared_force"][-1], columns["laplacian"][-1]
    np.testing.assert_allclose(found, seen.configurational(), rtol=1e-9)


def test_units_of_the_field_file(tmp_path: Path) -> None:
    scene = pydlpoly.load(example_folder("argon"))
    scene = replace(scene, output=replace(scene.output, diagnostics_every=2))
    run_scene(scene, tmp_path, steps=4, threads=1)
    columns, table = read_diagnostics(tmp_path / "DIAGNOSTICS"), read_statistics(tmp_path / "STATIS")
    assert "energy[K]" in (tmp_path / "DIAGNOSTICS").read_text().split()
    assert columns["energy"][0] * scene.bead_count == pytest.approx(table["extended_energy"][0], rel=1e-6)
    ratio = columns["squared_force"] / columns["laplacian"] / 0.831451115
    np.testing.assert_allclose(columns["configurational_temperature"], ratio, rtol=1e-8)


def test_off_by_default_and_by_name(tmp_path: Path) -> None:
    run(tmp_path / "usual")
    assert "DIAGNOSTICS" not in listing(tmp_path / "usual" / "out")
    run(tmp_path / "none", {**EVERY_TEN, "io_file_diagnostics": "NONE"})
    assert "DIAGNOSTICS" not in listing(tmp_path / "none" / "out")
    run(tmp_path / "named", {**EVERY_TEN, "io_file_diagnostics": "health"})
    run(tmp_path / "named", {**EVERY_TEN, "io_file_diagnostics": "health"})
    assert {"health", "health.bak"} < set(listing(tmp_path / "named" / "out"))
    with pytest.raises(InputError, match="STATIS: two output files"):
        run(tmp_path / "clash", {**EVERY_TEN, "io_file_diagnostics": "STATIS"})


def test_old_style_has_no_word_for_it() -> None:
    control = parse_control("title t\ndiagnostics_frequency 10 steps\n")
    with pytest.raises(InputError, match=r"diagnostics_frequency 10.* has no form in the old style"):
        write_control(replace(control, style="old"))


@pytest.mark.parametrize("name", ["argon", "lipid", "water"])
def test_looking_changes_nothing(tmp_path: Path, name: str) -> None:
    """Fast and general path, bonded terms, with and without thermostat; sums do not depend on the threads."""
    scene = pydlpoly.load(example_folder(name))
    quiet = replace(scene, output=replace(scene.output, print_every=0, checkpoint_every=0))
    curious = replace(quiet, output=replace(quiet.output, print_every=5, diagnostics_every=3))
    run_scene(quiet, tmp_path / "quiet", steps=40, seed=1, threads=1)
    run_scene(curious, tmp_path / "curious", steps=40, seed=1, threads=1)
    run_scene(curious, tmp_path / "two", steps=40, seed=1, threads=2)
    for file in ("REVCON", "STATIS"):
        assert (tmp_path / "quiet" / file).read_bytes() == (tmp_path / "curious" / file).read_bytes(), file
    assert (tmp_path / "two" / "DIAGNOSTICS").read_bytes() == (tmp_path / "curious" / "DIAGNOSTICS").read_bytes()


# -- continuing -------------------------------------------------------------------------------------------------------


def averages(path: Path) -> dict[str, bytes]:
    arrays, _ = read_checkpoint(path)
    return {name: array.tobytes() for name, array in arrays.items() if name.startswith("reporter.")}


@pytest.mark.parametrize("settings", [{}, NVE], ids=["dpd", "nve"])
@pytest.mark.parametrize("first", [1, 10, 23, 39])
def test_continued_run_has_the_same_file_and_averages(
    tmp_path: Path, first: int, settings: dict[str, str | None]
) -> None:
    settings = {
        **settings,
        "time_equilibration": "4 steps",
        "diagnostics_frequency": "3 steps",
        "stats_frequency": "1 steps",
        "print_frequency": "2 steps",
    }
    whole = run(tmp_path / "whole", settings).summary
    run(tmp_path / "parts", settings, steps=first)
    parts = run(tmp_path / "parts", settings, checkpoint=tmp_path / "parts" / "out" / "REVIVE").summary
    for name in (*RESULTS, "DIAGNOSTICS"):
        one, other = tmp_path / "whole" / "out" / name, tmp_path / "parts" / "out" / name
        assert one.read_bytes() == other.read_bytes(), name
    assert averages(tmp_path / "whole" / "out" / "REVIVE") == averages(tmp_path / "parts" / "out" / "REVIVE")
    for name in ("kinetic_temperature", "configurational_temperature", "energy_drift", "doubts"):
        assert getattr(whole, name) == getattr(parts, name), name
    assert (whole.energy_drift is None) == (settings.get("ensemble") != "nve")


def test_records_after_an_older_checkpoint_are_not_doubled(tmp_path: Path) -> None:
    run(tmp_path, EVERY_TEN, steps=20)
    early = (tmp_path / "out" / "REVIVE").read_bytes()
    run(tmp_path, EVERY_TEN, checkpoint=tmp_path / "out" / "REVIVE")
    whole = (tmp_path / "out" / "DIAGNOSTICS").read_bytes()
    (tmp_path / "out" / "REVIVE").write_bytes(early)
    run(tmp_path, EVERY_TEN, checkpoint=tmp_path / "out" / "REVIVE")
    assert (tmp_path / "out" / "DIAGNOSTICS").read_bytes() == whole


# -- the end of OUTPUT ------------------------------------------------------------------------------------------------


def test_means_are_sums_over_sums_of_the_records(tmp_path: Path) -> None:
    result = run(tmp_path, {**EVERY_TEN, "time_equilibration": "10 steps", "time_run": "200 steps"})
    columns, summary = read_diagnostics(tmp_path / "out" / "DIAGNOSTICS"), result.summary
    after = columns["step"] > 10
    expected = columns["squared_force"][after].sum() / columns["laplacian"][after].sum()
    configurational, kinetic = summary.configurational_temperature, summary.kinetic_temperature
    assert configurational is not None
    assert kinetic is not None
    assert configurational.value == pytest.approx(expected, rel=1e-8)
    assert kinetic.value == pytest.approx(columns["kinetic_temperature"][after].mean(), rel=1e-8)
    assert (kinetic.samples, configurational.samples) == (19, 19)
    assert 0.0 < configurational.error < 0.5
    text = (tmp_path / "out" / "OUTPUT").read_text()
    block = re.search(
        r"Temperatures, with standard errors from 19 samples in 19 blocks:\n"
        r"  kinetic +(\S+) \+- +(\S+)\n  configurational +(\S+) \+- +(\S+)\n  thermostat +(\S+)\n\n",
        text,
    )
    assert block is not None
    numbers = [float(word) for word in block.groups()]
    given = [kinetic.value, kinetic.error, configurational.value, configurational.error, 1.0]
    np.testing.assert_allclose(numbers, given, rtol=5e-3)


def test_samples_without_the_file_are_those_that_are_printed(tmp_path: Path) -> None:
    summary = run(tmp_path / "two").summary
    assert summary.kinetic_temperature is not None
    assert summary.kinetic_temperature.samples == 2
    assert math.isnan(summary.kinetic_temperature.error)
    assert "(too few samples for an error)" in (tmp_path / "two" / "out" / "OUTPUT").read_text()
    assert run(tmp_path / "none", {"print_frequency": "0 steps"}).summary.kinetic_temperature is None
    assert "Temperatures" not in (tmp_path / "none" / "out" / "OUTPUT").read_text()
    both = run(tmp_path / "both", {"diagnostics_frequency": "15 steps"}).summary.kinetic_temperature
    assert both is not None
    assert both.samples == 4, "steps 15, 20, 30, 40"


def test_temperatures_without_other_averages(tmp_path: Path) -> None:
    run(tmp_path, {**EVERY_TEN, "print_frequency": "0 steps", "stats_frequency": "0 steps"})
    text = (tmp_path / "out" / "OUTPUT").read_text()
    assert "no averages were taken\n\nTemperatures, with standard errors from 4 samples in 4 blocks:\n" in text


def test_dlpoly_py_still_reads_output(tmp_path: Path) -> None:
    scene = pydlpoly.load(example_folder("argon"))
    scene = replace(scene, run=replace(scene.run, equilibration_steps=0))
    result = run_scene(scene, tmp_path, steps=400, seed=1, threads=1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from dlpoly.output import Output

        judge = Output(str(tmp_path / "OUTPUT"))
    text = (tmp_path / "OUTPUT").read_text()
    assert re.search(r"\n  configurational .* K\n\nDrift of the total energy .*:\n  drift .* K/ps\n", text)
    assert judge.steps == 400
    assert judge.pressure == pytest.approx(result.summary.averages[26], rel=1e-3)
    assert set(judge.diffusion) == {"Ar"}
    assert judge.run_time is not None


WATER: dict[str, str | None] = {
    "time_run": "2500 steps",
    "time_equilibration": "500 steps",
    "print_frequency": "20 steps",
    "traj_calculate": "off",
    "rdf_calculate": "off",
}


def test_a_good_timestep_gives_no_warning(tmp_path: Path) -> None:
    result = run(tmp_path, WATER)
    assert list(result.summary.doubts) == list(result.summary.warnings) == []
    assert "disagree" not in (tmp_path / "out" / "OUTPUT").read_text()
    kinetic, configurational = result.summary.kinetic_temperature, result.summary.configurational_temperature
    assert kinetic is not None
    assert configurational is not None
    assert kinetic.value == pytest.approx(1.0, abs=0.04)
    assert configurational.value == pytest.approx(1.0, abs=0.05)


def test_a_long_timestep_gives_a_warning(tmp_path: Path) -> None:
    """At Δt = 0.08 the configurational temperature is a third too high, the kinetic one an eighth."""
    summary = run(tmp_path, {**WATER, "timestep": "0.08 dpd_t"}).summary
    (doubt,) = summary.doubts
    assert summary.warnings == [doubt]
    found = re.search(r"configurational (\S+) \+- \S+, kinetic (\S+) \+- \S+, thermostat 1; ", doubt)
    assert found is not None
    assert float(found[1]) > float(found[2]) + 0.1 > 1.1
    assert re.search(r"configurational \d\d\.\d % above kinetic, configurational \d\d\.\d % above thermostat", doubt)
    assert "the timestep of 0.08 is probably too long" in doubt
    assert f"  {doubt}\n" in (tmp_path / "out" / "OUTPUT").read_text()


def test_a_run_that_is_not_equilibrated_gives_another_warning(tmp_path: Path) -> None:
    """Random positions heat the fluid to twice the temperature; it cools during all of this short run."""
    settings = {**WATER, "timestep": "0.002 dpd_t", "time_run": "700 steps", "time_equilibration": "100 steps"}
    (doubt,) = run(tmp_path, settings).summary.doubts
    assert re.search(r"kinetic \d\d\.\d % above thermostat; the \w+ one still changes, by about -\d", doubt)
    assert "probably not equilibrated" in doubt


def test_the_command_line_repeats_the_warning(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from pydlpoly.cli import app

    folder = run_folder(tmp_path, {**WATER, "timestep": "0.08 dpd_t", "time_run": "1200 steps"})
    app(["run", str(folder), "--threads", "1"], standalone_mode=False)
    assert "warning: temperatures disagree: configurational " in capsys.readouterr().err


def samples(scene: pydlpoly.Scene, sums: list[tuple[float, float, float]]) -> TemperatureSamples:
    """Averages of invented samples of Σ|∇U|², Σ∇²U and the kinetic temperature."""
    taken = TemperatureSamples(scene)
    for number, sample in enumerate(sums):
        taken._sums.add([*sample, 100.0 * number])
    return taken


def invented(configurational: float, kinetic: float, noise: float, count: int = 64) -> list[tuple[float, float, float]]:
    rng = np.random.default_rng(5)
    laplacian = 1000.0 * (1.0 + 0.1 * rng.normal(size=count))
    force = configurational * laplacian * (1.0 + noise * rng.normal(size=count))
    velocities = kinetic * (1.0 + noise * rng.normal(size=count))
    return [(float(f), float(c), float(t)) for f, c, t in zip(force, laplacian, velocities, strict=True)]


@pytest.mark.parametrize(
    ("configurational", "kinetic", "noise", "words"),
    [
        (1.0, 1.0, 0.01, ""),
        (1.015, 1.0, 0.001, ""),  # beyond all errors, but of no consequence
        (1.04, 1.0, 0.2, ""),  # within its error
        (1.04, 1.0, 0.01, "configurational 4.0 % above kinetic, configurational 4.0 % above thermostat;"),
        (1.015, 0.99, 0.01, "configurational 2.5 % above kinetic;"),
        (0.97, 0.97, 0.01, "configurational 3.0 % below thermostat, kinetic 3.0 % below thermostat;"),
    ],
)
def test_what_counts_as_disagreement(configurational: float, kinetic: float, noise: float, words: str) -> None:
    scene = make_scene({"A": 10}, cell=4.0)
    doubt = samples(scene, invented(configurational, kinetic, noise)).doubt()
    if not words:
        assert doubt is None
    else:
        assert doubt is not None
        plain = re.sub(r"\d\.\d %", "# %", doubt)
        assert re.sub(r"\d\.\d %", "# %", words) in plain


def test_the_correlation_with_the_curvature_makes_the_error_small() -> None:
    """The curvature varies by 10 %, but so does the force; the ratio is exact to 1 %/√64."""
    estimate = samples(make_scene({"A": 10}, cell=4.0), invented(1.0, 1.0, 0.01)).configurational()
    assert estimate is not None
    assert estimate.error == pytest.approx(0.01 / 8.0, rel=0.5)


def test_nothing_to_compare_with() -> None:
    """Without conservative forces there is no configurational temperature, without a thermostat no target."""
    scene = make_scene({"A": 10}, cell=4.0)
    bare = samples(scene, [(0.0, 0.0, 1.1)] * 8)
    assert bare.configurational() is None
    assert "kinetic 10.0 % above thermostat" in str(bare.doubt())
    lost = samples(scene, [(1.0, float("nan"), 1.0)] * 8)
    assert (lost.configurational(), lost.doubt()) == (None, None)
    assert samples(scene, [(2.0, 1.0, 1.0)] * 8).doubt() is not None
    assert samples(scene, [(2.0, 1.0, 1.0)] * 7).doubt() is None
    assert samples(scene, []).doubt() is None
    alone = make_scene({"A": 10}, cell=4.0, control=NVE)
    assert samples(alone, invented(0.5, 0.5, 0.01)).doubt() is None
    assert "configurational" in str(samples(alone, invented(0.6, 0.5, 0.01)).doubt())


def test_few_steps_say_nothing() -> None:
    """A temperature that is off by chance stays so for a while, in however many samples."""
    for spacing, judged in ((10.0, True), (7.0, False)):
        taken = TemperatureSamples(make_scene({"A": 10}, cell=4.0))
        for number, sample in enumerate(invented(1.2, 1.2, 0.01)):
            taken._sums.add([*sample, spacing * number])
        assert (taken.doubt() is not None) == judged


def test_a_trend_is_told_from_an_offset() -> None:
    scene = make_scene({"A": 1000}, cell=8.0)
    falling = [(f * (1.5 - k / 128), c, t * (1.5 - k / 128)) for k, (f, c, t) in enumerate(invented(1.0, 1.0, 0.01))]
    doubt = str(samples(scene, falling).doubt())
    assert "one still changes, by about -0.5" in doubt
    little = [(f * (1.5 - k / 3200), c, t) for k, (f, c, t) in enumerate(invented(1.0, 1.0, 0.001))]
    assert "timestep of 0.01 is probably too long" in str(samples(scene, little).doubt())


def test_causes_that_are_known() -> None:
    driven = make_scene({"A": 10}, cell=4.0, extern="oshr 1.0 1")
    assert "an external field heats" in str(samples(driven, invented(1.2, 1.2, 0.01)).doubt())
    points = {"temperature_times": "[ 0.0 10.0 ] internal_t", "temperature_values": "[ 1.0 2.0 ] dpd_temp"}
    varied = make_scene({"A": 10}, cell=4.0, control=points)
    assert samples(varied, []).target is None
    assert "changes faster than the beads follow" in str(samples(varied, invented(1.5, 1.7, 0.01)).doubt())


# -- drift of the energy ----------------------------------------------------------------------------------------------


def drift_of(summary: RunSummary) -> tuple[float, float]:
    assert summary.energy_drift is not None
    return summary.energy_drift.value, summary.energy_drift.error


def test_energy_drift_is_the_slope_of_statis(tmp_path: Path) -> None:
    settings = {**NVE, "time_run": "300 steps", "time_equilibration": "20 steps", "rescale_frequency": "5 steps"}
    summary = run(tmp_path, settings).summary
    table = read_statistics(tmp_path / "out" / "STATIS")
    after = table.step > 20
    slope = np.polyfit(table.time[after], table["extended_energy"][after] / sum(COUNTS.values()), 1)[0]
    value, error = drift_of(summary)
    assert summary.energy_drift is not None
    assert summary.energy_drift.samples == 28
    assert value == pytest.approx(slope, abs=1e-5)
    assert 0.0 < error < 0.01
    text = (tmp_path / "out" / "OUTPUT").read_text()
    found = re.search(r"Drift of the total energy per bead and time, .*:\n  drift +(\S+) \+- +(\S+)\n", text)
    assert found is not None
    assert float(found[1]) == pytest.approx(value, rel=1e-4)


def test_a_driven_fluid_drifts(tmp_path: Path) -> None:
    """An oscillating shear heats by more than 1 per bead and time; without it there is no drift beyond the error."""
    control: dict[str, str | None] = {**NVE, "stats_frequency": "10 steps", "time_equilibration": "100 steps"}
    found = []
    for extern in ("", "oshr 3.0 1"):
        scene = make_scene({"A": 192}, cell=4.0, extern=extern, control=control)
        found.append(drift_of(run_scene(scene, tmp_path, steps=1000, seed=3, threads=1).summary))
    (still, error), (heated, error_heated) = found
    assert abs(still) < 5.0 * error < 1e-3
    assert heated > max(1.0, 5.0 * error_heated)


# -- progress bar -----------------------------------------------------------------------------------------------------


def test_progress_bar_computes_the_configurational_temperature_seldom(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr("pydlpoly.progress.clock.perf_counter", lambda: now[0])
    simulation = pydlpoly.Simulation(make_scene({"A": 192}, cell=4.0), seed=1, threads=1)
    untouched = pydlpoly.Simulation(simulation.scene, seed=1, threads=1)
    computed: list[int] = []
    compute = pydlpoly.Simulation.configurational

    def counted(self: pydlpoly.Simulation) -> tuple[float, float]:
        if self._configurational is None or self._configurational[0] != self.step:
            computed.append(self.step)
        return compute(self)

    monkeypatch.setattr(pydlpoly.Simulation, "configurational", counted)
    console = Console(file=io.StringIO())
    with Progress(TextColumn("{task.fields[note]}"), console=console, disable=True) as shown:
        task = shown.add_task("steps", total=100, note="")
        bar = progress.ProgressBar(simulation, shown, task)

        def note_after(seconds: float) -> str:
            simulation.run(1)
            untouched.run(1)
            now[0] += seconds
            bar()
            return str(shown.tasks[0].fields["note"])

        assert all("Tconf" not in note_after(1.0) for _ in range(4))
        assert computed == []
        first = note_after(1.0)
        assert computed == [5]
        assert f"Tconf {simulation.configurational_temperature:.4g}" in first
        notes = [note_after(1.0) for _ in range(4)]
        assert {note.split("Tconf")[1] for note in notes} == {first.split("Tconf")[1]}
        assert computed == [5]
        note_after(1.0)
        assert computed == [5, 10]
        simulation.run(1)
        untouched.run(1)
        known = simulation.configurational_temperature  # as a reporter computes it
        assert computed == [5, 10, 11]
        assert all(f"Tconf {known:.4g}" in note_after(1.0) for _ in range(5))
        assert computed == [5, 10, 11], "a value from elsewhere is used for as long"
        note_after(1.0)
        assert computed == [5, 10, 11, 17]
    assert (simulation.state.positions == untouched.state.positions).all()
    assert (simulation.state.velocities == untouched.state.velocities).all()
