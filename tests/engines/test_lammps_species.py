"""Dissolved species in the engine lammps: fluxes of a frame, sources, held beads, balances and runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pydlpoly import InputError, Scene, SceneError, Simulation, load
from pydlpoly.engines.lammps_translate import translate
from pydlpoly.errors import RunError
from pydlpoly.formats.beads_file import read_beads
from pydlpoly.formats.records import FloatArray
from pydlpoly.runner import run_scene

from ..molecule_builder import chains, molecule_scene
from ..run_folders import run_folder
from ..scene_builder import NVE, make_scene
from .engine_pairs import assert_same_frame, assert_same_parts, block_errors, cold, in_both

STILL = {**NVE, "fixed_com": "off"}
FLUXES = (
    "pair A A a kappa 1.0 range 1.3 exponent 2.0",
    "pair A B a kappa 2.0 range 0.8 exponent 0.7",
    "pair B B a kappa 0.5 range 1.0",
    "pair A A b kappa 3.0 range 1.0 exponent 1.0",  # a pair with two ranges
    "pair B B b kappa 1.0 range 1.4",
)
LAWS = ("A A dpd 25.0 1.0 4.5", "A B dpd 30.0 1.1 4.5", "B B dpd 20.0 1.2 9.0 0.9")


def block(*lines: str, species: str = "a b") -> str:
    return "\n".join(["extension transport", f"species {species}", *lines, "end extension", ""])


def mixture(
    *lines: str,
    laws: tuple[str, ...] = LAWS,
    control: dict[str, str | None] | None = None,
    timestep: float = 1e-4,
    fluxes: tuple[str, ...] = FLUXES,
    **more: object,
) -> Scene:
    """600 beads of two species that start with unequal amounts of two dissolved ones."""
    start = ("start a 1.0 box * 0 * * * *", "start b 2.0 in B", "start b 0.5 sphere 1 1 1 1.5")
    settings = {"cutoff": "1.4 ang", "timestep": f"{timestep!r} internal_t", **(control or {})}
    return make_scene(
        {"A": 400, "B": 200}, laws, cell=[6.0, 5.5, 6.3], control=settings, extensions=block(*start, *fluxes, *lines),
        start_seed=4, **more,  # type: ignore[arg-type]
    )  # fmt: skip


def changes(simulation: Simulation, steps: int) -> FloatArray:
    """What amounts change by in so many steps."""
    before = simulation.state.concentrations
    simulation.run(steps)
    after = simulation.state.concentrations
    assert before is not None
    assert after is not None
    return after - before


@pytest.mark.parametrize("ranks", [1, 2])
def test_fluxes(ranks: int) -> None:
    """Of one short step, whose error is of the order of its length; any pair law, any ranges."""
    scene = mixture(control=STILL, laws=("A A dpd 25.0 1.0", "B B dpd 20.0 1.2"), velocities=np.zeros((600, 3)))
    ours, theirs = in_both(scene, ranks=ranks)
    assert np.array_equal(ours.state.concentrations, theirs.state.concentrations)  # type: ignore[arg-type]
    assert_same_frame(ours, theirs, forces=1e-10)
    a, b = changes(ours, 1), changes(theirs, 1)
    assert (np.abs(a).max(axis=0) > 3e-4).all()
    assert np.abs(a - b).max() <= 2e-3 * np.abs(a).max()
    for amount in theirs.species_balance():
        assert abs(amount.remainder) < 1e-10


def test_forces_and_stress_are_those_of_every_scene() -> None:
    """Drag with and without λ = 1/2, parts of the stress, frozen beads."""
    for prediction in ("0.5", "0.65"):
        laws = ("A A dpd 25.0 1.0 4.5", "A B dpd 30.0 1.1 4.5", "B B dpd 20.0 1.2 9.0 0.9")
        scene = mixture(laws=laws, control={"ensemble_dpd_lambda": prediction}, timestep=0.01)
        ours, theirs = in_both(cold(scene), ranks=2)
        for simulation in (ours, theirs):
            simulation.run(15)
        assert_same_frame(ours, theirs, forces=1e-9, energy=1e-9)
        assert_same_parts(ours.observe(), theirs.observe())
        assert f"mvv/tdpd {float(prediction):.17g}" in theirs.explain()


def test_frozen_and_bonded_beads_exchange() -> None:
    pairs = ("H H dpd 25 1.0", "H T dpd 30 1.0", "T T dpd 25 1.0")
    scene = molecule_scene(
        "HTTTT", {"bonds": [f"harm {k} {k + 1} 64.0 0.5" for k in range(1, 5)]}, chains(100, 5, 6.0, seed=11),
        copies=100, pairs=pairs, cell=6.0, frozen=(0,), control={**STILL, "timestep": "1e-4 internal_t"},
        extensions=block("start a 1.0 in H", "pair * * a kappa 1.0 range 1.2", species="a"),
    )  # fmt: skip
    ours, theirs = in_both(scene, ranks=2)
    assert_same_frame(ours, theirs, forces=1e-10)
    a, b = changes(ours, 1), changes(theirs, 1)
    frozen = scene.beads.frozen
    assert a[frozen].min() < -3e-4
    assert np.abs(a - b).max() <= 2e-3 * np.abs(a).max()
    assert np.all(theirs.velocities[frozen] == 0.0)


def test_sources_and_their_balance() -> None:
    """Boxes, a sphere across the border, everywhere, of a species; the balance closes to rounding."""
    lines = (
        "source a 0.5 box 0 * -2 * * 3", "source a 0.25 sphere 2.9 0 3.0 1.0", "source b 0.125 everywhere",
        "source b -0.03125 in B", "source a 0.1 in B",
    )  # fmt: skip
    ours, theirs = in_both(mixture(*lines, control=STILL, timestep=0.002), ranks=2)
    for simulation in (ours, theirs):
        simulation.run(37)
        simulation.observe()
        simulation.run(63)
    for a, b in zip(ours.species_balance(), theirs.species_balance(), strict=True):
        assert b.sources == pytest.approx(a.sources, rel=0.02)
        assert abs(b.sources) > 1.0
        assert abs(b.remainder) < 1e-9
        assert b.now == pytest.approx(a.now, rel=2e-3)
    theirs.set_state(velocities=theirs.velocities)  # handed over anew: no half step is lost
    theirs.run(20)
    for amount in theirs.species_balance():
        assert abs(amount.remainder) < 1e-9


def test_sources_are_those_of_wrapped_places() -> None:
    """Fast beads without forces; what differs is half a step at each border that was crossed."""
    velocities = np.random.default_rng(2).normal(size=(600, 3))
    lines = ("source a 0.5 box 1.0 9 * * * *", "source a 0.25 sphere 2.9 0 3.0 1.0")
    scene = mixture(*lines, control=STILL, velocities=velocities, timestep=0.01, laws=(), fluxes=())
    ours, theirs = (changes(simulation, 100) for simulation in in_both(scene, ranks=2))
    assert ours.max() > 0.3
    assert np.abs(ours - theirs).max() <= 4 * 0.5 * 0.01 * 0.75


@pytest.mark.parametrize("frozen", [(), ("B",)])
def test_held_beads(frozen: tuple[str, ...]) -> None:
    lines = ("hold a 1.5 in B", "hold b 0.25 in B", "source a 0.1 everywhere")
    scene = mixture(*lines, control=STILL, timestep=0.002, frozen=frozen)
    ours, theirs = in_both(scene, ranks=2)
    for simulation in (ours, theirs):
        simulation.run(50)
    held = scene.beads.species == 1
    assert theirs.species_balance()[0].held > 10.0  # b does not flow between A and B
    assert np.all(theirs.state.concentrations[held] == [1.5, 0.25])  # type: ignore[index]
    for a, b in zip(ours.species_balance(), theirs.species_balance(), strict=True):
        assert b.held == pytest.approx(a.held, rel=0.02, abs=1e-9)
        assert abs(b.remainder) < 1e-9


def test_amounts_that_are_exchanged_and_set() -> None:
    scene = mixture(control=STILL, laws=("A A dpd 25.0 1.0", "B B dpd 20.0 1.2"))
    ours, theirs = in_both(scene)
    for simulation in (ours, theirs):
        simulation.add_callback(lambda moment: {"concentration_b": 0.5 * moment["concentration_b"] + 0.5}, 5)
        simulation.run(12)
        simulation.set_state(concentrations=simulation.state.concentrations + 0.125)  # type: ignore[operator]
        simulation.run(3)
    a, b = ours.state.concentrations, theirs.state.concentrations
    assert a is not None
    assert b is not None
    assert np.abs(a - b).max() < 2e-3
    assert_same_frame(ours, theirs, forces=1e-10)


def test_whole_runs_and_checkpoints(tmp_path: Path) -> None:
    """OUTPUT's amounts, REVBEADS and BEADS; either engine goes on from the other's checkpoint."""
    folder = run_folder(tmp_path / "run")
    lines = ("start a 1.0 box 0 * * * * *", "pair * * a kappa 2.0 range 1.0 noise 0.01", "noise lammps")
    text = block(*lines, "source a 0.1 box * 0 * * * *", species="a")
    (folder / "FIELD").write_text((folder / "FIELD").read_text() + text)
    scene = load(folder)
    for engine in ("native", "lammps"):
        run_scene(scene, tmp_path / engine, engine=engine, seed=5)
    ours, theirs = tmp_path / "native", tmp_path / "lammps"
    assert sorted(path.name for path in ours.iterdir()) == sorted(path.name for path in theirs.iterdir())
    assert "remainder" in (theirs / "OUTPUT").read_text()
    b = read_beads(theirs / "REVBEADS")
    assert b.names == ("concentration_a",)
    (folder / "BEADS").write_bytes((theirs / "REVBEADS").read_bytes())
    start = Simulation(load(folder), engine="lammps", seed=1)
    assert np.array_equal(start.bead_arrays()["concentration_a"], b.values[:, 0])
    for first, second in (("native", "lammps"), ("lammps", "native")):
        simulation = Simulation(scene, seed=5, engine=first)
        simulation.run(20)
        simulation.save(tmp_path / "REVIVE")
        again = Simulation.resume(tmp_path / "REVIVE", scene=scene, engine=second)
        assert np.array_equal(again.state.concentrations, simulation.state.concentrations)  # type: ignore[arg-type]
        assert np.array_equal(again.state.forces, simulation.state.forces)
        assert again.species_balance() == simulation.species_balance()
        again.run(10)
        (amount,) = again.species_balance()
        assert abs(amount.remainder) < 1e-10
        assert amount.sources > simulation.species_balance()[0].sources


def test_amounts_that_fall_below_nothing_stop_the_run() -> None:
    """Where there is nothing, and where there is something for a while."""
    scene = mixture("source a -1.0", control=STILL, timestep=0.002)
    with pytest.raises(RunError, match="a sink takes more than a bead has in the first step"):
        Simulation(scene, seed=1, engine="lammps").run(5)
    scene = mixture("start a 0.01", "source a -1.0 in B", control=STILL, timestep=0.002)
    with pytest.raises(RunError, match=r"a concentration has become -.* by step \d+: LAMMPS's steps"):
        Simulation(scene, seed=1, engine="lammps").run(50)


REFUSED = {
    "reaction": (("reaction 0.3 a -> b",), {}, r"FIELD:\d+: the reaction .* cannot be run with the engine lammps"),
    "sqrt": (
        ("pair A B b kappa 1.0 range 1.0 noise 0.1", "noise sqrt"), {},
        r"FIELD:\d+: noise sqrt cannot be run .*grows as the concentrations",
    ),
    "hold": (("hold a 1.0 in B",), {}, r"FIELD:\d+: beads B that hold some dissolved species and exchange others"),
    "explicit": (
        ("pair A B b kappa 100.0 range 1.0",), {"timestep": 0.02},
        r"FIELD:\d+: an exchange that would move .* of the differences of b in a step cannot be run",
    ),
    "hoover": (
        (), {"control": {"ensemble_method": "hoover", "ensemble_dpd_order": None,
                         "ensemble_thermostat_coupling": "0.5 ps"}},
        "dissolved species cannot be run with hoover",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(name: str) -> None:
    lines, more, words = REFUSED[name]
    with pytest.raises(SceneError, match=words):
        translate(mixture(*lines, **more), 1)  # type: ignore[arg-type]


def test_boxes_of_tilted_cells() -> None:
    cell = np.array([[6.0, 0, 0], [1.7, 5.5, 0], [0.4, 0, 6.3]])
    for region, fits in (("box 0 * * * * *", False), ("box * * * 1 0 1", True), ("sphere 2 2 2 1.5", True)):
        text = block("start a 1.0", f"source a 0.1 {region}", species="a")
        scene = make_scene({"A": 50}, ("A A dpd 25 1.0",), cell=cell, control=STILL, extensions=text)
        if fits:
            assert "tdpd/source" in " ".join(translate(scene, 1).after)
            continue
        with pytest.raises(SceneError, match=r"FIELD:\d+: a source in a box across a tilted axis"):
            translate(scene, 1)


def test_accelerators_are_refused() -> None:
    with pytest.raises(InputError, match="accelerator switches do not go with beads that carry heat"):
        Simulation(mixture(control=STILL), engine="lammps", accelerator="-sf omp -pk omp 1")


@pytest.mark.slow
def test_profiles_on_two_ranks() -> None:
    """A species that is fed in one half and drained in the other: T, P, eight layers and the spread between beads."""
    lines = (
        "start a 1.0", "pair A A a kappa 1.0 range 1.58 noise 0.02", "noise lammps", "source a 0.1 box * * 0 * * *",
        "source a -0.1 box * * * 0 * *",
    )  # fmt: skip
    control = {"cutoff": "1.58 ang", "ensemble_dpd_exponent": "0.41"}
    scene = make_scene(
        {"A": 864}, ("A A dpd 18.75 1.58 4.5",), cell=6.0, control=control, extensions=block(*lines, species="a")
    )
    found = []
    for number, (engine, ranks) in enumerate((("native", None), ("lammps", 2))):
        simulation = Simulation(scene, seed=41 + number, engine=engine, ranks=ranks)
        simulation.run(400)
        rows = []
        for _ in range(150):
            simulation.run(5)
            seen, state = simulation.observe(), simulation.state
            amounts = state.concentrations[:, 0]  # type: ignore[index]
            layers = np.floor((state.positions[:, 1] / 6.0 + 0.5) * 8).astype(int) % 8
            # The mean wanders with the numbers of beads in both halves; the balance has it.
            profile = [float(amounts[layers == k].mean() - amounts.mean()) for k in range(8)]
            spread = float(np.mean([amounts[layers == k].var() for k in range(8)]))
            rows.append([seen.temperature, seen.pressure, *profile, 100.0 * spread])
        found.append(block_errors(rows))
    (ours, error), (theirs, other) = found
    both = np.hypot(error, other)
    assert both[0] < 0.02
    assert both[1] < 0.8  # drag and noise are in it
    assert np.all(both[2:10] < 0.005)
    assert ours[2:10].max() - ours[2:10].min() > 0.05
    assert np.all(np.abs(ours - theirs) <= 4.0 * both), (ours, theirs, both)
