"""Each check says what it should of runs made for it: on both sides of its threshold, and when nothing can be said."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pydlpoly.formats.output_reader import OutputLog
from pydlpoly.formats.species_balance import SpeciesBalance
from pydlpoly.formats.statis import STATISTICS_NAMES, StatisticsTable
from pydlpoly.report import judge as judging
from pydlpoly.report import judge_carried
from pydlpoly.report.collect import Problem, Run
from pydlpoly.report.evidence import Evidence, with_error
from pydlpoly.report.finding import Finding
from pydlpoly.report.series import Average
from pydlpoly.scene import load
from pydlpoly.scene.model import ExternalTerm, Scene

from ..run_folders import run_folder
from .runs import carried_inputs

NAMES = tuple(one.name for one in STATISTICS_NAMES)
EVERY = 10


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    folder = run_folder(
        tmp_path_factory.mktemp("judge"), {"time_run": "4000 steps", "time_equilibration": "1000 steps"}
    )
    return load(folder)


def table(records: int = 401, **columns: Any) -> StatisticsTable:
    """STATIS of a run without surprises: T = 1 and P = 20 with noise; columns are replaced by name."""
    noise = np.random.default_rng(5).standard_normal((2, records))
    values = np.zeros((records, len(NAMES)))
    usual = {"temperature": 1.0 + 0.01 * noise[0], "pressure": 20.0 + 0.3 * noise[1], "volume": np.full(records, 64.0)}
    for name, column in {**usual, **columns}.items():
        values[:, NAMES.index(name)] = column
    steps = EVERY * np.arange(records)
    return StatisticsTable("made", "DPD", steps, 0.01 * steps, NAMES, values)


def diagnostics(records: int = 401, configurational: float = 1.0, momentum: float = 0.0) -> dict[str, np.ndarray]:
    noise = 1.0 + 0.02 * np.random.default_rng(6).standard_normal(records)
    steps = EVERY * np.arange(records)
    return {
        "step": steps,
        "time": 0.01 * steps,
        "squared_force": 50.0 * configurational * noise,
        "laplacian": np.full(records, 50.0),
        "momentum_drift": np.linspace(0.0, momentum, records),
    }


def run_of(scene: Scene | None, **parts: Any) -> Run:
    log = OutputLog("0", "made", ended=True, last_step=4000, loop_seconds=10.0)
    usual = {"statistics": table(), "log": log, "files": {"STATIS": Path("STATIS"), "OUTPUT": Path("OUTPUT")}}
    return Run(Path("made"), scene=scene, **{**usual, **parts})


def only(check: Any, run: Run) -> Finding:
    (finding,) = check(Evidence(run))
    return finding


def test_a_run_without_surprises_has_no_warning(scene: Scene) -> None:
    found = judging.judge_run(run_of(scene, diagnostics=diagnostics()))
    assert [one.level for one in found] == ["fine"] * len(found)
    assert len(found) == 6


@pytest.mark.parametrize(
    ("off", "level"), [(0.0, "fine"), (0.008, "fine"), (-0.009, "fine"), (0.012, "warning"), (-0.03, "warning")]
)
def test_kinetic_temperature(scene: Scene, off: float, level: str) -> None:
    noise = 0.002 * np.random.default_rng(1).standard_normal(401)
    finding = only(judging.kinetic_temperature, run_of(scene, statistics=table(temperature=1.0 + off + noise)))
    assert finding.level == level
    if level == "warning":
        assert f"{100 * abs(off):.1f} % {'high' if off > 0 else 'low'}" in finding.text
        assert "timestep too long (0.01)" in finding.text
        assert "pydlpoly tradeoff made" in finding.advice


def test_a_temperature_off_by_chance_is_no_warning(scene: Scene) -> None:
    """2 % off, but from noise that makes it 3 % uncertain."""
    slow = 0.12 * np.sin(np.arange(401) / 60.0)
    finding = only(
        judging.kinetic_temperature, run_of(scene, statistics=table(temperature=1.02 + slow - slow[101:].mean()))
    )
    assert finding.level == "fine"


def test_the_cause_is_named(scene: Scene) -> None:
    falling = 1.0 + 0.3 * np.exp(-np.arange(401) / 150.0)
    large = replace(scene, degrees_of_freedom=30_000)  # in which a single temperature varies by 0.8 %
    finding = only(judging.kinetic_temperature, run_of(large, statistics=table(temperature=falling)))
    assert finding.level == "warning"
    assert "not equilibrated" in finding.text
    assert "time_equilibration" in finding.advice
    hot = table(temperature=1.05 + 0.001 * np.random.default_rng(1).standard_normal(401))
    driven = replace(scene, external=(ExternalTerm("grav", (0.0, 0.0, 1.0)),))
    assert "an external field heats" in only(judging.kinetic_temperature, run_of(driven, statistics=hot)).text
    nve = replace(scene, dynamics=replace(scene.dynamics, integrator="nve"))
    assert only(judging.kinetic_temperature, run_of(nve, statistics=hot)).level == "unknown"


def test_equilibration(scene: Scene) -> None:
    """A change of 2 % of T or of 5 % of k_B T per bead over the samples, three quarters of the run."""
    noise = 0.002 * np.random.default_rng(4).standard_normal(401)
    line = np.arange(401) / 300
    for change, warned in ((0.0, False), (0.015, False), (-0.03, True)):
        found = judging.equilibrated(Evidence(run_of(scene, statistics=table(temperature=1.0 + change * line + noise))))
        assert bool(found) == warned, change
    assert "the kinetic temperature still falls, by about 0.02" in found[0].text
    energy = table(configurational_energy=160 * (4.0 + 0.08 * line + noise))
    (finding,) = judging.equilibrated(Evidence(run_of(scene, statistics=energy)))
    assert "the potential energy per bead still rises, by about 0.07" in finding.text
    assert judging.equilibrated(Evidence(run_of(scene))) == []


@pytest.mark.parametrize(("value", "level"), [(1.0, "fine"), (1.015, "fine"), (1.03, "warning"), (0.96, "warning")])
def test_configurational_temperature(scene: Scene, value: float, level: str) -> None:
    finding = only(judging.configurational_temperature, run_of(scene, diagnostics=diagnostics(configurational=value)))
    assert finding.level == level
    assert only(judging.configurational_temperature, run_of(scene)).level == "unknown"
    log = OutputLog("0", "", ended=True, temperatures={"configurational": (value, 0.001)})
    assert only(judging.configurational_temperature, run_of(scene, log=log)).level == level


def test_momentum(scene: Scene) -> None:
    """√(3 M k_B T) of 160 beads of mass 1 at k_B T = 1 is √480."""
    size = np.sqrt(480.0)
    for drift, level in ((0.0, "fine"), (0.0005 * size, "fine"), (0.002 * size, "warning")):
        run = run_of(scene, diagnostics=diagnostics(momentum=drift))
        assert only(judging.momentum, run).level == level, drift
    assert only(judging.momentum, run_of(scene, momentum=np.array([0.0, 0.0, 0.03 * size]))).level == "warning"
    assert only(judging.momentum, run_of(scene, momentum=np.zeros(3))).level == "fine"
    driven = replace(scene, external=(ExternalTerm("grav", (0.0, 0.0, 1.0)),))
    run = run_of(driven, diagnostics=diagnostics(momentum=size))
    assert "external field" in only(judging.momentum, run).text
    assert only(judging.momentum, run_of(None)).level == "unknown"


@pytest.mark.parametrize(("drift", "level"), [(0.0, "fine"), (0.005, "fine"), (0.03, "warning"), (-0.03, "warning")])
def test_energy_drift(scene: Scene, drift: float, level: str) -> None:
    """In k_B T per bead over the samples after the equilibration, three quarters of the run."""
    nve = replace(scene, dynamics=replace(scene.dynamics, integrator="nve"))
    energy = 160 * (5.0 + drift * np.arange(401) / 300 + 1e-5 * np.random.default_rng(2).standard_normal(401))
    finding = only(judging.energy_drift, run_of(nve, statistics=table(extended_energy=energy)))
    assert finding.level == level
    hot = table(extended_energy=energy, temperature=2.0)  # against twice the thermal energy
    told = only(judging.energy_drift, run_of(nve, statistics=hot)).text.split()[5]
    assert float(told) == pytest.approx(drift / 2, abs=1e-4)
    assert judging.energy_drift(Evidence(run_of(scene))) == []
    if level == "warning":
        assert f"{drift:.2g} k_B T per bead" in finding.text


def test_pressure(scene: Scene) -> None:
    noise = 0.1 * np.random.default_rng(3).standard_normal(401)
    rising = np.where(np.arange(401) > 250, 21.0, 20.0) + noise
    assert "still changes" in only(judging.pressure, run_of(scene, statistics=table(pressure=rising))).text
    slow = 6.0 * np.sin(np.arange(401) / 40.0) + noise
    assert only(judging.pressure, run_of(scene, statistics=table(pressure=20.0 + slow))).level == "warning"
    finding = only(judging.pressure, run_of(scene))
    assert finding.level == "fine"
    mean = table()["pressure"][101:].mean()
    assert float(finding.text.split()[-3]) == pytest.approx(mean, abs=0.006)


def test_too_short(scene: Scene) -> None:
    short = table(106)
    assert "5 samples" in only(judging.enough_samples, run_of(scene, statistics=short)).text
    assert "no record after the equilibration" in only(judging.enough_samples, run_of(scene, statistics=table(50))).text
    slow = 20.0 + np.sin(np.arange(401) / 150.0)
    assert "independent" in only(judging.enough_samples, run_of(scene, statistics=table(pressure=slow))).text
    assert only(judging.enough_samples, run_of(scene)).level == "fine"


def test_whole_run(scene: Scene) -> None:
    def text(log: OutputLog | None, **parts: Any) -> str:
        return only(judging.whole_run, run_of(scene, log=log, **parts)).text

    ended = OutputLog("0", "", ended=True, last_step=4000)
    assert text(ended) == "all 4000 steps were taken"
    assert "at step 4000 of 4000: it was killed" in text(OutputLog("0", "", steps=np.array([4000]), ended=False))
    assert "ended early, at step 1050 of 4000" in text(replace(ended, last_step=1050), statistics=table(106))
    stopped = replace(ended, last_step=7, warnings=("the run stopped: bead 3 left the box",))
    assert text(stopped, statistics=table(1)) == "the run stopped: bead 3 left the box; 7 of 4000 steps were taken"
    finding = only(judging.whole_run, run_of(scene, log=None, statistics=table(106), files={"REVIVE": Path("REVIVE")}))
    assert "pydlpoly run made --resume" in finding.advice


def test_files_and_words_of_the_run(scene: Scene) -> None:
    run = run_of(scene, problems=(Problem("RDFDAT", "cannot be read: line 4"),))
    assert only(judging.files, run) == Finding("warning", "File RDFDAT", "cannot be read: line 4")
    words = ("a choice of the run", "temperatures disagree: kinetic 2", "the run stopped: bead 1")
    run = run_of(scene, log=OutputLog("0", "", ended=True, warnings=words))
    assert only(judging.own_words, run).text == "a choice of the run"


def test_not_finite(scene: Scene) -> None:
    broken = np.where(np.arange(401) == 300, np.nan, 20.0)
    finding = only(judging.finite, run_of(scene, statistics=table(pressure=broken)))
    assert finding.level == "warning"
    assert "pressure" in finding.text
    assert judging.finite(Evidence(run_of(scene))) == []


def test_time_of_reporters(scene: Scene) -> None:
    timings = {"steps": 10.0, "of which motion and forces": 6.0, "of which STATIS": 1.0, "of which HISTORY": 2.8}
    log = OutputLog("0", "", ended=True, last_step=4000, loop_seconds=10.0, timings=timings)
    finding = only(judging.time_of_reporters, run_of(scene, log=log))
    assert finding.text == "40 % of the time went into observing and writing, most of it into HISTORY"
    fast = replace(log, timings={**timings, "of which motion and forces": 8.0})
    assert judging.time_of_reporters(Evidence(run_of(scene, log=fast))) == []


def test_every_check_says_where_its_threshold_comes_from() -> None:
    for check in judging.CHECKS:
        assert check.__doc__ is not None
        assert len(check.__doc__) > 60


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (1.01219, 0.008, "1.0122 ± 0.0080"),
        (-0.08217, 0.0243, "-0.082 ± 0.024"),
        (-561.0034, 0.0512, "-561.003 ± 0.051"),
        (23.4, 1.26, "23.4 ± 1.3"),
        (1804.15, 662.0, "1800 ± 660"),
        (1.5e7, 3.2e4, "15000000 ± 32000"),
        (1.23456e-9, 2.5e-11, "1.23456e-09 ± 2.5e-11"),
        (64.0, 0.0, "64 ± 0"),
        (12.3456, float("nan"), "12.346"),
        (float("nan"), float("nan"), "not known"),
    ],
)
def test_digits_follow_the_error(value: float, error: float, text: str) -> None:
    assert with_error(Average(value, error, 10)) == text


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    return load(carried_inputs(tmp_path_factory.mktemp("warm"), {"time_run": "4000 steps"}))


def conserved(slope: float, noise: float = 1e-4) -> dict[str, np.ndarray]:
    """DIAGNOSTICS whose conserved energy per bead drifts by this much over the run."""
    found = diagnostics()
    values = 5.0 + noise * np.random.default_rng(8).standard_normal(401) + np.linspace(0.0, slope, 401)
    return {**found, "conserved_energy": values, "internal_energy": values, "internal_temperature": np.ones(401)}


@pytest.mark.parametrize(("slope", "level"), [(0.0, "fine"), (0.008, "fine"), (-0.02, "warning"), (0.02, "warning")])
def test_conserved_energy_where_beads_carry_heat(warm: Scene, slope: float, level: str) -> None:
    """In units of k_B T = 1 a bead: 1 % is tolerated."""
    finding = only(judge_carried.conserved_energy, run_of(warm, diagnostics=conserved(slope)))
    assert finding.level == level
    found = re.search(r"changes by (-?[\d.e-]+) k_B T per bead", finding.text)
    assert float(found[1]) == pytest.approx(slope, abs=4e-4)


def test_a_drift_within_its_noise_is_no_warning(warm: Scene) -> None:
    finding = only(judge_carried.conserved_energy, run_of(warm, diagnostics=conserved(0.02, noise=0.5)))
    assert finding.level == "fine"


def test_what_is_not_conserved_is_not_judged(scene: Scene, warm: Scene) -> None:
    assert judge_carried.conserved_energy(Evidence(run_of(scene, diagnostics=diagnostics()))) == []
    assert only(judge_carried.conserved_energy, run_of(warm, diagnostics=diagnostics())).text == "it was not recorded"
    assert warm.heat is not None
    for change, told in (
        ({"heat": replace(warm.heat, scaled_repulsion=True)}, "repulsion grows with temperature"),
        ({"heat": replace(warm.heat, viscous_heating="lammps")}, "viscous_heating lammps"),
        ({"external": (ExternalTerm("grav", (0.0, 0.0, 1.0)),)}, "external field does work"),
    ):
        other = replace(warm, **change)  # type: ignore[arg-type]
        finding = only(judge_carried.conserved_energy, run_of(other, diagnostics=conserved(0.5)))
        assert finding.level == "unknown"
        assert told in finding.text
    finding = only(judge_carried.conserved_energy, run_of(warm, diagnostics=conserved(0.5), callbacks=("heater",)))
    assert finding.level == "unknown"
    assert "heater" in finding.text


@pytest.mark.parametrize(("missing", "level"), [(0.0, "fine"), (5e-8, "fine"), (2e-7, "warning"), (-3.0, "warning")])
def test_balance_of_a_species(warm: Scene, missing: float, level: str) -> None:
    """A billionth of the 100 that were there at the start is tolerated."""
    balance = (SpeciesBalance("sugar", 100.0, 20.0, -50.0, 0.0, 70.0 + missing), SpeciesBalance("salt", 0, 0, 0, 0, 0))
    finding = only(judge_carried.species_balance, run_of(warm, balance=balance, balance_file="OUTPUT"))
    assert finding.level == level
    if level == "warning":
        word = "more" if missing > 0.0 else "less"
        assert f"of sugar there is {70.0 + missing:.6g}, {abs(missing):.3g} {word} than" in finding.text
        assert "salt" not in finding.text
        acted = run_of(warm, balance=balance, balance_file="OUTPUT", callbacks=("feeder",))
        assert only(judge_carried.species_balance, acted).level == "note"


def test_species_without_a_balance_are_not_judged(scene: Scene, warm: Scene) -> None:
    assert judge_carried.species_balance(Evidence(run_of(scene))) == []
    assert only(judge_carried.species_balance, run_of(warm)).level == "unknown"
