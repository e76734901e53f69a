"""Speed against accuracy: errors have the right size, verdicts respect noise, and the command tells what it found."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import InputError, Scene, SceneError, Simulation, load
from pydlpoly.bench.results import Spread, this_machine
from pydlpoly.cli import example_folder, main
from pydlpoly.formats.control import parse_control
from pydlpoly.scene.integrators import INTEGRATORS
from pydlpoly.tradeoff import Measured, Reference, TradeoffReport, measure, tradeoff
from pydlpoly.tradeoff.candidates import Candidate, candidates_for, reference_for, variant
from pydlpoly.tradeoff.cli import fraction_of, seconds_of
from pydlpoly.tradeoff.deviations import not_below
from pydlpoly.tradeoff.report import control_lines, duration, on_front, overall, scalar_error
from pydlpoly.tradeoff.samples import settled
from pydlpoly.tradeoff.statistics import (
    REACH,
    Deviation,
    block_error,
    combine,
    judge,
    judge_many,
    mean_and_error,
    ratio_and_error,
    slope_and_error,
    student,
)

from .run_folders import listing, run_folder
from .scene_builder import NVE, make_scene

DOUBLE = {"precisions": ["double"]}
ROOT = Path(__file__).resolve().parents[1]


class Outcome:
    def __init__(self, code: object, out: str, err: str) -> None:
        self.code, self.out, self.err = code, out, err


@pytest.fixture
def cli(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """Call the command in this process: cli("FOLDER") -> Outcome."""

    def call(*words: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["pydlpoly", "tradeoff", *(str(word) for word in words)])
        with pytest.raises(SystemExit) as stop:
            main()
        captured = capsys.readouterr()
        return Outcome(stop.value.code, captured.out, captured.err)

    return call


def water(**control: str | None) -> Scene:
    return make_scene({"A": 400}, cell=(400 / 3.0) ** (1.0 / 3.0), control={"random_seed": "5", **control})


def autoregressive(rng: np.random.Generator, count: int, length: int, memory: float) -> np.ndarray:
    """(length, count) series x_t = memory x_(t-1) + noise of variance 1, from its stationary distribution."""
    x = np.empty((length, count))
    x[0] = rng.normal(size=count) / np.sqrt(1.0 - memory**2)
    for t in range(1, length):
        x[t] = memory * x[t - 1] + rng.normal(size=count)
    return x


# -- statistics -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_block_error_of_a_known_process(memory: float) -> None:
    """The mean of n numbers of such a process has the variance 1/((1 - memory)^2 n)."""
    length = 4096
    series = autoregressive(np.random.default_rng(1), 200, length, memory)
    errors, freedom = block_error(series)
    exact = 1.0 / (1.0 - memory) / np.sqrt(length)
    assert 0.97 * exact < np.mean(errors) < 1.17 * exact
    assert np.std(series.mean(axis=0)) == pytest.approx(exact, rel=0.15)
    covered = np.mean(np.abs(series.mean(axis=0)) <= student(freedom) * errors)
    assert covered > 0.92


@pytest.mark.parametrize("memory", [0.0, 0.5])
def test_block_error_of_few_samples_does_not_claim_too_much(memory: float) -> None:
    series = autoregressive(np.random.default_rng(2), 1000, 64, memory)
    errors, freedom = block_error(series)
    assert np.mean(np.abs(series.mean(axis=0)) <= student(freedom) * errors) > 0.9


def test_block_error_of_short_series() -> None:
    assert block_error([1.0])[0][0] == np.inf
    errors, freedom = block_error([1.0, 2.0, 3.0])
    assert errors[0] == pytest.approx(1.0 / np.sqrt(3.0))
    assert freedom[0] == 2
    assert mean_and_error([1.0, 2.0, 3.0])[:2] == pytest.approx((2.0, 1.0 / np.sqrt(3.0)))


def test_student_reaches_as_far_as_in_tables() -> None:
    for freedom, value in ((4, 2.776), (10, 2.228), (30, 2.042), (1e9, 1.960)):
        assert float(student(freedom)) == pytest.approx(value, rel=0.01)
    assert float(student(20, 0.999)) == pytest.approx(3.850, rel=0.01)


def test_ratio_of_means() -> None:
    rng = np.random.default_rng(2)
    below = 2.0 + 0.5 * rng.normal(size=(400, 300))
    above = 3.0 * below + 0.3 * rng.normal(size=below.shape)
    found = np.array([ratio_and_error(a, b) for a, b in zip(above.T, below.T, strict=True)])
    assert found[:, 0].mean() == pytest.approx(3.0, abs=0.002)
    assert found[:, 1].mean() == pytest.approx(1.1 * found[:, 0].std(), rel=0.15)


def test_slope() -> None:
    """Of a random walk; of independent noise about a line, where the error is too large."""
    rng = np.random.default_rng(3)
    times = np.linspace(0.0, 10.0, 500)
    noise = rng.normal(size=(300, 500))
    walks = np.array([slope_and_error(times, 0.2 * times + np.cumsum(0.1 * one)) for one in noise])
    assert walks[:, 0].mean() == pytest.approx(0.2, abs=0.05)
    assert 0.8 < walks[:, 1].mean() / walks[:, 0].std() < 1.1
    lines = np.array([slope_and_error(times, 0.2 * times + one) for one in noise])
    assert lines[:, 0].mean() == pytest.approx(0.2, abs=0.003)
    assert lines[:, 1].mean() > lines[:, 0].std()
    assert slope_and_error(times[:2], times[:2])[1] == np.inf


def test_combined_error() -> None:
    assert combine((3.0, 10.0), (4.0, 10.0)) == pytest.approx((5.0, 625.0 / 33.7))
    assert combine((0.0, 5.0), (0.0, 7.0)) == (0.0, 5.0)


# -- verdicts ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "error", "verdict"),
    [
        (0.004, 0.002, "within"),
        (-0.004, 0.002, "within"),
        (0.004, 0.004, "cannot tell"),
        (0.012, 0.002, "cannot tell"),
        (0.012, 0.0005, "outside"),
        (-0.05, 0.004, "outside"),
        (0.0, np.inf, "cannot tell"),
        (np.nan, 0.001, "cannot tell"),
    ],
)
def test_verdict(value: float, error: float, verdict: str) -> None:
    assert judge(value, error, 1000.0, 0.01).verdict == verdict


def test_few_samples_make_the_error_larger() -> None:
    many, few = judge(0.005, 0.002, 1e6, 0.01), judge(0.005, 0.002, 4.0, 0.01)
    assert (many.verdict, few.verdict) == ("within", "cannot tell")
    assert many.error == pytest.approx(0.002, rel=1e-3)
    assert few.error == pytest.approx(0.002 * 2.776 / 1.96, rel=0.01)


def test_chance_does_not_make_one_of_many_outside() -> None:
    rng = np.random.default_rng(4)
    errors, freedom = np.full(50, 0.01), np.full(50, 1e6)
    outside = [judge_many(0.01 * rng.normal(size=50), errors, freedom, 1e-9).verdict for _ in range(400)]
    assert outside.count("outside") / 400 < 0.03
    values = np.zeros(50)
    values[7] = -0.1
    found = judge_many(values, errors, freedom, 0.02)
    assert (found.value, found.verdict) == (0.1, "outside")
    assert judge_many(np.zeros(50), errors, freedom, 0.02).verdict == "within"


def test_overall_and_largest() -> None:
    fine, bad = Deviation(0.001, 0.0001, "within"), Deviation(-0.05, 0.001, "outside")
    noisy = Deviation(0.06, 0.05, "cannot tell")
    assert overall({"a": fine}) == "within"
    assert overall({"a": fine, "b": noisy}) == "cannot tell"
    assert overall({"a": fine, "b": noisy, "c": bad}) == "outside"
    assert scalar_error({"a": fine, "b": noisy, "c": bad}) == (0.05, "c", 0.001)


def candidate(speed: float, error: float, noise: float = 0.0, **more: object) -> Measured:
    spread = Spread(speed, 0.99 * speed, 1.01 * speed)
    found = Measured("middle", 0.01, "double", None, "general", status="measured", speed=spread)
    return replace(found, error=error, error_noise=noise, error_of="energy", **more)  # type: ignore[arg-type]


def test_front() -> None:
    points = [candidate(4.0, 0.1), candidate(3.0, 0.2), candidate(2.0, 0.05), candidate(1.0, 0.05)]
    assert on_front(points) == [True, False, True, False]
    unstable = replace(candidate(9.0, 0.0), status="unstable", speed=None, error=None)
    assert on_front([*points, unstable]) == [True, False, True, False, False]


def test_noise_puts_nothing_on_the_front() -> None:
    assert on_front([candidate(4.0, 0.10, 0.03), candidate(2.0, 0.05, 0.03)]) == [True, False]
    assert on_front([candidate(4.0, 0.10, 0.01), candidate(2.0, 0.05, 0.01)]) == [True, True]
    # Rates that cannot be told apart: the more accurate one stands for both.
    assert on_front([candidate(4.0, 0.10, 0.01), candidate(3.99, 0.05, 0.01)]) == [False, True]


# -- candidates -------------------------------------------------------------------------------------------------------


def test_candidates_of_a_thermostat() -> None:
    scene = water()
    found = candidates_for(scene)
    assert {one.name for one in found} == {
        *("mdvv 0.5", "mdvv 0.65", "mdvv 0.9 half", "dpdvv", "first", "second", "peters", "lowe-andersen"),
        *("ou-middle", "middle", "middle every 4"),
    }
    assert sorted({one.timestep for one in found}) == pytest.approx([0.005, 0.01, 0.015, 0.02, 0.03, 0.04, 0.06])
    assert [one.label for one in found if one.own] == ["mdvv 0.5, 0.01, double"]
    mixed = {one.name for one in found if one.precision == "mixed"}
    assert mixed == {one.name for one in found if one.path == "fast"}, "elsewhere the bits are the same"
    for one in found:
        dynamics = variant(scene, one).dynamics
        assert (dynamics.integrator, dynamics.timestep) == (one.integrator, one.timestep)
        assert dynamics.thermal_energy == scene.dynamics.thermal_energy
    assert reference_for(scene, found) == Candidate("middle", 0.005, "double")


def test_every_integrator_may_be_asked_for() -> None:
    found = candidates_for(water(), list(INTEGRATORS), [0.01, 0.02, 0.01], ["double"])
    assert {one.integrator for one in found} == set(INTEGRATORS)
    assert {one.timestep for one in found} == {0.01, 0.02}
    coupled = next(one for one in found if one.integrator == "stoyanov-groot")
    assert variant(water(), coupled).dynamics.coupling == 0.3


def test_candidates_without_a_thermostat() -> None:
    scene = water(**NVE)
    found = candidates_for(scene)
    assert {one.integrator for one in found} == {"nve"}
    assert reference_for(scene, found).integrator == "nve"
    with pytest.raises(SceneError, match="'middle': is no integrator for a scene without thermostat"):
        candidates_for(scene, ["middle"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"integrators": ["midle"]}, "did you mean middle"),
        ({"precisions": ["dubble"]}, "did you mean double"),
        ({"timesteps": [0.0]}, "a timestep must be above 0"),
        ({"budget": 0.0}, "the budget must be above 0"),
        ({"target": 1.5}, "the target between 0 and 1"),
    ],
)
def test_refused_arguments(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        tradeoff(water(), **arguments)  # type: ignore[arg-type]


# -- whole measurements -----------------------------------------------------------------------------------------------


def test_water_end_to_end() -> None:
    told: list[tuple[str, float, float]] = []
    report = tradeoff(
        water(),
        budget=4.0,
        target=0.3,
        integrators=["mdvv", "middle"],
        timesteps=[0.01, 0.02],
        threads=1,
        progress=lambda *now: told.append(now),
    )
    assert {one.integrator for one in report.candidates} == {"mdvv", "middle"}
    assert report.seed == 5
    assert report.reference.averages["pressure"][0] == pytest.approx(23.6, abs=2.0)
    assert told[0][0] == "equilibrating"
    assert all(0.0 <= done <= of == 4.0 for _, done, of in told)
    measured = [one for one in report.candidates if one.status == "measured"]
    assert measured
    speeds = [one.speed.median for one in measured if one.speed is not None]
    assert speeds == sorted(speeds, reverse=True)
    for one in measured:
        assert one.deviations is not None
        names = {"temperature", "configurational_temperature", "pressure", "energy", "rdf"}
        assert set(one.deviations) == names
        assert abs(one.deviations["temperature"].value) < 0.3
    best = report.recommendation
    assert best is not None
    assert best.verdict == "within"
    assert any(one.front for one in measured)
    text = report.text()
    assert "fastest within 30 %" in text
    assert f"  ensemble_dpd_order {best.integrator}" in text
    json.dumps(report.as_json())


def test_unstable_candidates_are_told_not_raised() -> None:
    report = tradeoff(
        water(),
        budget=3.0,
        target=0.3,
        integrators=["mdvv"],
        timesteps=[0.01, 0.3, 1e6],
        precisions=["double"],
        threads=1,
    )
    status = {(one.prediction, one.timestep): one for one in report.candidates}
    for prediction in (0.5, 0.65):
        assert status[prediction, 0.3].status == "unstable"
        assert re.search("temperature is .* % off|step", status[prediction, 0.3].why)
        assert status[prediction, 1e6].why == "so is timestep 0.3"
        assert status[prediction, 0.01].status != "unstable"
    assert "unstable: " in report.text()
    assert "so is timestep" in report.text(everything=True)


def test_limits_of_pair_maps_are_told() -> None:
    found = candidates_for(water(), ["lowe-andersen", "peters-first"], [0.01, 1.0])
    assert [bool(one.refused) for one in found] == [False, True, False, True]


def test_scene_without_thermostat() -> None:
    control = {**NVE, "time_run": "2000 steps"}
    report = tradeoff(
        water(**control), budget=4.0, target=0.5, timesteps=[0.005, 0.01], precisions=["double"], threads=1
    )
    assert report.reference.integrator == "nve"
    assert report.reference.deviations == {}
    measured = [one for one in report.candidates if one.deviations]
    assert measured
    assert all("drift" in (one.deviations or {}) for one in measured)
    assert "ensemble nve" in control_lines(measured[0], report.time_unit)


def test_large_scenes_share_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run that was put aside between its turns goes on from where it was."""
    monkeypatch.setattr(measure, "_BEADS_ALIVE", 0)
    report = tradeoff(water(**NVE), budget=3.0, target=0.5, timesteps=[0.005], threads=1, **DOUBLE)
    drift = (report.candidates[0].deviations or {})["drift"]
    assert abs(drift.value) < 0.5
    assert 0.0 < drift.error < 0.5


def test_budget_that_is_too_short() -> None:
    report = tradeoff(water(), budget=0.05, target=1e-4, integrators=["middle"], timesteps=[0.01], threads=1)
    assert report.recommended is None
    assert report.too_short
    assert report.budget_needed is not None
    assert report.budget_needed > 0.05
    assert re.search(
        r"the budget of 1s is too short .*\nerrors shrink as 1/sqrt\(time\): about --budget \d+\w+ would", report.text()
    )


@pytest.mark.parametrize("after", [1, 12])
def test_interrupt_keeps_what_is_known(after: int) -> None:
    told: list[str] = []

    def interrupt(what: str, _done: float, _of: float) -> None:
        told.append(what)
        if sum(word != "equilibrating" for word in told) == after:
            raise KeyboardInterrupt

    report = tradeoff(
        water(), budget=30.0, target=0.3, integrators=["middle"], timesteps=[0.01, 0.02], threads=1, progress=interrupt
    )
    assert report.interrupted
    assert report.seconds < 29.0
    assert len(report.candidates) == 8


def test_error_of_a_short_run_isnot_below_what_the_reference_says() -> None:
    assert not_below((0.01, 7.0), (0.01, 99.0), 2.0) == (0.02, 99.0)
    assert not_below((0.03, 7.0), (0.01, 99.0), 2.0) == (0.03, 7.0)


def test_a_scene_that_still_changes_is_noticed() -> None:
    rng = np.random.default_rng(6)
    still, falling = rng.normal(size=(200, 60)), rng.normal(size=(200, 60)) - 0.1 * np.arange(60)
    assert np.mean([settled(one, 2) for one in still]) > 0.97
    assert np.mean([settled(one, 2) for one in falling]) < 0.05


def test_diffusion_is_compared_when_asked_for() -> None:
    report = tradeoff(
        water(), budget=5.0, target=0.5, integrators=["middle"], timesteps=[0.02], threads=1, diffusion=True
    )
    measured = [one for one in report.candidates if one.deviations]
    assert all("diffusion" in (one.deviations or {}) for one in measured)


def test_nothing_to_compare_at_temperature_0() -> None:
    with pytest.raises(SceneError, match="at temperature 0"):
        tradeoff(water(temperature="0.0 K"))


def test_what_is_said_when_nothing_is_within() -> None:
    bad = candidate(1.0, 0.05, 0.001, verdict="outside", deviations={"energy": Deviation(0.05, 0.001, "outside")})
    reference = Reference("middle", 0.005, "double", 1.0, {}, {})
    report = TradeoffReport(
        *("title", 10, "", this_machine(), 0.01, 60.0, 60.0, 1, 1, reference, (bad,), None, (), None)
    )
    assert not report.too_short
    assert "nothing is within 1 %; the most accurate is middle, 0.01, double with 5 % in U" in report.text()


# -- CONTROL ----------------------------------------------------------------------------------------------------------

_MIDDLE = Measured("middle", 0.02, "double", None, "general", status="measured")
_PREDICTED = Measured("mdvv", 0.03, "mixed", 0.65, "fast", status="measured")


def test_lines_for_control() -> None:
    assert control_lines(_MIDDLE, "") == [
        *("ensemble nvt", "ensemble_method dpd", "ensemble_dpd_order middle", "timestep 0.02 dpd_t")
    ]
    assert control_lines(_PREDICTED, "ps")[2:] == [
        *("ensemble_dpd_order mdvv", "ensemble_dpd_lambda 0.65", "timestep 0.03 ps", "precision mixed")
    ]


def test_lines_keep_the_style_and_unit_of_the_input() -> None:
    new = parse_control("title t\ntimestep 10.0 fs\nprecision mixed\n")
    assert control_lines(_MIDDLE, "ps", new)[3:] == ["timestep 20.0 fs", "precision double"]
    old = parse_control("t\nensemble nvt dpds1 4.5\ntimestep 0.01\nfinish\n")
    assert control_lines(_MIDDLE, "ps", old) == ["ensemble nvt middle 4.5", "timestep 0.02"]
    assert "convert" in control_lines(_PREDICTED, "ps", old)[0]
    meso = parse_control("t\nvolume 27\ntemperature 1\ntimestep 0.01\nsteps 10\nfinish\n")
    assert control_lines(_PREDICTED, "ps", meso)[0] == "# after: pydlpoly convert FOLDER --to dl_poly"


@pytest.mark.parametrize("style", ["new", "old"])
def test_pasted_lines_make_the_recommended_scene(cli, tmp_path: Path, style: str) -> None:
    run_folder(tmp_path)
    if style == "old":
        lines = ["t", "temperature 1.2027165301233615", "ensemble nvt mdvv", "cutoff 1.0", "vdw direct"]
        (tmp_path / "CONTROL").write_text("\n".join([*lines, "timestep 0.01", "steps 40", "no elec", "finish", ""]))
    before = listing(tmp_path)
    words = ["--target", "40%", "--integrators", "ou-middle", "--timesteps", "0.02", "--threads", 1]
    for budget in ("3s", "15s", "60s"):  # a busy machine needs more time to tell
        done = cli(tmp_path, "--budget", budget, *words)
        if done.code == 0:
            break
    assert done.code == 0, done.out
    assert listing(tmp_path) == before
    pasted = re.search(r"in CONTROL:\n((?:  .*\n)+)", done.out)
    assert pasted, done.out
    lines = [line.strip() for line in pasted[1].splitlines()]
    replaced = {line.split()[0] for line in lines}
    text = [line for line in (tmp_path / "CONTROL").read_text().splitlines() if line.split()[0] not in replaced]
    text[1:1] = lines
    (tmp_path / "CONTROL").write_text("\n".join([*text, ""]))
    dynamics = load(tmp_path).dynamics
    assert (dynamics.integrator, dynamics.timestep) == ("ou-middle", pytest.approx(0.02))


# -- the command ------------------------------------------------------------------------------------------------------

QUICK = ["--integrators", "middle", "--timesteps", "0.01,0.02", "--threads", 1, "--seed", 3]


def test_command_with_json_and_plot(cli, tmp_path: Path) -> None:
    (tmp_path / "t.json").write_text("precious")
    words = ["--budget", "6s", "--target", "0.4", "--json", tmp_path / "t.json", "--plot", tmp_path / "t.png"]
    done = cli("--example", "water", *QUICK, *words)
    assert done.code == 0, done.out
    assert "errors in per cent +- their statistical error, fastest first:" in done.out
    assert "fastest within 40 %: middle" in done.out
    assert (tmp_path / "t.json.bak").read_text() == "precious"
    assert "the earlier file is now" in done.err
    report = json.loads((tmp_path / "t.json").read_text())
    assert report["format"] == 1
    assert len(report["candidates"]) == 8
    assert (tmp_path / "t.png").read_bytes().startswith(b"\x89PNG")


def test_json_members_are_documented(cli, tmp_path: Path) -> None:
    run_folder(tmp_path)
    cli(tmp_path, *QUICK, "--budget", "3s", "--target", "0.5", "--diffusion", "--json", tmp_path / "t.json")
    page = (ROOT / "docs" / "accuracy-and-speed.md").read_text(encoding="utf-8")
    told = set(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE))

    def members(value: object) -> set[str]:
        if isinstance(value, dict):
            return set(value).union(*(members(part) for part in value.values()))
        return set().union(*(members(part) for part in value)) if isinstance(value, list) else set()

    assert members(json.loads((tmp_path / "t.json").read_text())) == told - {"drift"}, (
        "drift: only without a thermostat"
    )


def test_too_short_a_budget_has_an_exit_code(cli) -> None:
    done = cli("--example", "water", *QUICK, "--budget", "0.05s", "--target", "1e-5")
    assert done.code == 4
    assert "the budget of 1s is too short" in done.out


def test_missing_matplotlib_is_refused_at_once(cli, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == "matplotlib"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    done = cli("--example", "water", "--plot", tmp_path / "t.png")
    assert done.code == 1
    assert "a plot needs matplotlib: pip install matplotlib" in done.err
    assert done.out == ""


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["--budget", "soon"], 2, "'soon' is no time"),
        (["--budget", "0s"], 2, "'0s' is no time"),
        (["--target", "200%"], 2, "expected a fraction"),
        (["--timesteps", "0.01,x"], 2, "expected numbers above 0"),
        (["--integrators", "midle"], 1, "did you mean middle"),
        (["--precision", "dubble"], 1, "did you mean double"),
        (["--json", "nowhere/t.json"], 1, "there is no such folder"),
        (["--plot", "t.doc"], 1, "cannot be drawn"),
    ],
)
def test_refusals(cli, words: list[str], code: int, message: str) -> None:
    if "--plot" in words and importlib.util.find_spec("matplotlib") is None:
        pytest.skip("matplotlib is missing")
    done = cli("--example", "water", *words)
    assert done.code == code
    assert message in " ".join(done.err.replace("│", " ").split()), done.err


def test_times_and_fractions_as_typed() -> None:
    assert [seconds_of(text) for text in ("90s", "2min", "5m", "1h", "30", "1.5 min")] == [90, 120, 300, 3600, 30, 90]
    assert [fraction_of(text) for text in ("1%", "0.01", "2.5 %")] == pytest.approx([0.01, 0.01, 0.025])
    assert [duration(s) for s in (0.2, 90.0, 130.0, 3600.0, 90_000.0)] == ["1s", "90s", "2min", "60min", "25h"]
    assert pytest.approx(1.96, abs=0.001) == REACH


@pytest.mark.long
def test_the_recommendation_keeps_its_promise(tmp_path: Path) -> None:
    """The lines that 2 minutes recommend for 1 %, pasted into CONTROL, against averages of long runs at short steps.

    These are T = 1 for both temperatures, P = 23.652 ± 0.002 and 4.5465 ± 0.0005 a bead. The check runs for 200 τ of
    3000 beads: errors of 0.002, 0.002, 0.0002 and 0.0003 of these. One recommendation in 40 is wrong by more.
    """
    report = tradeoff(load(example_folder("water")), budget=120.0, target=0.01, threads=1, seed=3)
    best = report.recommendation
    assert best is not None
    pasted = control_lines(best, report.time_unit)
    replaced = {line.split()[0] for line in pasted}
    lines = (example_folder("water") / "CONTROL").read_text().splitlines()
    kept = [line for line in lines if line.split() and line.split()[0] not in replaced]
    control = tmp_path / "CONTROL"
    control.write_text("\n".join([*kept, *pasted, ""]))
    scene = load(example_folder("water"), control=control)
    simulation = Simulation(scene, seed=4, threads=1)
    stride = max(1, round(0.1 / scene.dynamics.timestep))
    simulation.run(round(10.0 / scene.dynamics.timestep))
    rows = []
    for _ in range(round(200.0 / (stride * scene.dynamics.timestep))):
        simulation.run(stride)
        seen = simulation.observe()
        squared, curvature = simulation.configurational()
        rows.append((seen.temperature, seen.pressure, seen.energy["pair"] / scene.bead_count, squared, curvature))
    temperature, pressure, energy, squared, curvature = np.mean(rows, axis=0)
    found = (temperature, squared / curvature, pressure / 23.652, energy / 4.5465)
    assert found == pytest.approx((1.0,) * 4, abs=0.0125), best.label
