"""Beads that carry heat in the engine lammps: forces, drag, conduction, sources, accounts and runs.

The noise of edpd cannot be switched off: points of one seed and other velocities differ by the drag alone, and heat
capacities of 1e20 leave conduction without visible noise.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import InputError, Scene, SceneError, Simulation, load
from pydlpoly.engines.lammps_team import ProcessTeam
from pydlpoly.engines.lammps_translate import translate
from pydlpoly.engines.lammps_translate.heat import about_one
from pydlpoly.errors import RunError
from pydlpoly.formats.beads_file import read_beads
from pydlpoly.formats.records import FloatArray
from pydlpoly.runner import run_scene

from ..heat_scenes import heat
from ..molecule_builder import chains, molecule_scene
from ..run_folders import run_folder
from ..scene_builder import NVE, make_scene
from .engine_pairs import assert_same_frame, assert_same_parts, block_errors, in_both
from .lammps_points import lammps_point

STILL = {**NVE, "fixed_com": "off"}
POLYNOMIALS = "power 0.9 -0.4 0.3 -0.1", "power -0.5 0.2 0.1 0.4"
CONDUCTIVITIES = "conductivity -0.44 -0.21 0.5 0.1", "conductivity 0.3 0.2 -0.1 0.2"
CAPACITY = 1e20


def mixture(
    *lines: str,
    control: dict[str, str | None] | None = None,
    capacity: float = CAPACITY,
    laws: tuple[str, ...] = ("A A dpd 25 1.0 4.5", "A B dpd 30 1.1 9.0", "B B dpd 25 1.0 2.0 0.8"),
    velocities: FloatArray | None = None,
    timestep: float = 1e-4,
    **more: object,
) -> Scene:
    """500 beads of two species at T_ref = 1.3, with temperatures between 0.9 and 1.5."""
    settings = {
        "cutoff": "1.2 ang",
        "temperature": "1.3 dpd_temp",
        "timestep": f"{timestep} internal_t",
        "ensemble_dpd_exponent": "0.8",
        **(control or {}),
    }
    if settings.get("ensemble") == "nve":
        del settings["ensemble_dpd_exponent"]
    block = heat(f"capacity A {capacity}", f"capacity B {2.0 * capacity}", *lines)
    scene = make_scene(
        {"A": 300, "B": 200}, laws, cell=[5.5, 6.0, 5.2], control=settings, extensions=block, velocities=velocities,
        start_seed=4, **more,  # type: ignore[arg-type]
    )  # fmt: skip
    warm = np.random.default_rng(6).uniform(0.9, 1.5, scene.bead_count)
    assert scene.heat is not None
    for kind in scene.heat.held:
        assert scene.beads.temperature is not None
        warm[scene.beads.species == kind] = scene.beads.temperature[scene.beads.species == kind]
    return dataclasses.replace(scene, beads=dataclasses.replace(scene.beads, temperature=warm))


def flux_lines(capacity: float = CAPACITY) -> tuple[str, ...]:
    """Conduction with other ranges than the forces', longer and shorter, and other polynomials for each pair."""
    kappa = 1.0 / capacity
    return (
        f"pair A A kappa {0.9 * kappa} range 1.4 exponent 2.0 {POLYNOMIALS[0]} {CONDUCTIVITIES[0]}",
        f"pair A B kappa {1.1 * kappa} range 0.8 exponent 1.5 {POLYNOMIALS[1]} {CONDUCTIVITIES[1]}",
        f"pair B B kappa {0.7 * kappa} range 1.2",
    )


@pytest.mark.parametrize("reference", [0.4, 1.0, 2.5, 249.4])
def test_polynomials_about_another_temperature(reference: float) -> None:
    """LAMMPS's are about 1; 249.4 is 300 K in DL_POLY's units."""
    factors = (0.9, -0.4, 0.3, -0.1)
    found = about_one(factors, reference)
    assert found is not None
    for temperature in (0.7 * reference, reference, 1.4 * reference):
        x, y = temperature / reference - 1.0, temperature - 1.0
        ours = 1.0 + sum(c * x**k for k, c in enumerate(factors, 1))
        theirs = found[0] * (1.0 + sum(c * y**k for k, c in enumerate(found[1], 1)))
        assert theirs == pytest.approx(ours, rel=1e-12)
    assert about_one((-1.0, 0.0, 0.0, 0.0), 0.5) is None  # 0 at a temperature of 1


@pytest.mark.parametrize("repulsion", ["constant", "scaled"])
def test_repulsion(repulsion: str) -> None:
    scene = mixture(f"repulsion {repulsion}", *flux_lines(), control=STILL)
    ours, theirs = in_both(scene, ranks=2)
    assert_same_frame(ours, theirs, forces=1e-10)
    assert np.array_equal(ours.bead_arrays()["temperature"], theirs.bead_arrays()["temperature"])
    assert theirs.energy["internal"] == pytest.approx(ours.energy["internal"], rel=1e-14)
    assert_same_parts(ours.observe(), theirs.observe())
    if repulsion == "constant":  # forces do not depend on temperatures
        for simulation in (ours, theirs):
            simulation.run(20)
        assert_same_frame(ours, theirs, forces=1e-10)
        assert_same_parts(ours.observe(), theirs.observe())


@pytest.mark.parametrize("repulsion", ["constant", "scaled"])
def test_drag_of_warm_beads(team: ProcessTeam, repulsion: str) -> None:
    """The same noise in both points of LAMMPS; the virials of drag differ as those of the native engine do."""
    rng = np.random.default_rng(3)
    velocities = rng.normal(size=(500, 3))
    lines = ("viscous_heating lammps", f"repulsion {repulsion}", *flux_lines())
    moving, resting = (mixture(*lines, velocities=v) for v in (velocities, np.zeros((500, 3))))
    points = [lammps_point(team, scene) for scene in (moving, resting)]
    theirs = points[0][1] - points[1][1]
    simulations = [Simulation(scene, seed=1, threads=1) for scene in (moving, resting)]
    ours = simulations[0].state.forces - simulations[1].state.forces
    assert np.abs(ours).max() > 5.0
    assert np.abs(ours - theirs).max() <= 1e-10 * np.abs(points[0][1]).max()
    if repulsion == "constant":  # of which drag and noise are the rest
        laws, law = points[0][0]["conservative"], simulations[0].observe().stress_parts["conservative"]
        assert np.abs(laws / points[0][0]["volume"] - law).max() <= 1e-9 * np.abs(law).max()
    part = "drag" if repulsion == "constant" else "conservative"
    seen = (points[0][0][part] - points[1][0][part]) / points[0][0]["volume"]
    parts = [simulation.observe().stress_parts["drag"] for simulation in simulations]
    assert np.abs(seen - (parts[0] - parts[1])).max() <= 1e-9 * np.abs(points[0][0]["drag"]).max() + 1e-9


def test_heat_of_drag_and_noise() -> None:
    """Of beads so fast that noise does not matter, in so short a step that they do not move."""
    velocities = 1e4 * np.random.default_rng(3).normal(size=(500, 3))
    scene = mixture("viscous_heating lammps", capacity=1e4, velocities=velocities, timestep=1e-9)
    ours, theirs = (changes(simulation, 1) for simulation in in_both(scene))
    assert np.abs(ours).max() > 3e-8
    assert np.abs(ours - theirs).max() <= 2e-3 * np.abs(ours).max()


def changes(simulation: Simulation, steps: int) -> FloatArray:
    """What internal temperatures change by in so many steps."""
    before = simulation.bead_arrays()["temperature"]
    simulation.run(steps)
    return simulation.bead_arrays()["temperature"] - before


@pytest.mark.parametrize("ranks", [1, 2])
def test_conduction(ranks: int) -> None:
    """Changes of temperature in one short step; the noise is 1e-9 of them, the step's error 1e-4."""
    scene = mixture(*flux_lines(), control=STILL, velocities=np.zeros((500, 3)))
    ours, theirs = (changes(simulation, 1) for simulation in in_both(scene, ranks=ranks))
    assert np.abs(ours).max() > 1e-4
    assert np.abs(ours - theirs).max() <= 5e-4 * np.abs(ours).max()


def test_conduction_between_bonded_and_frozen_beads() -> None:
    """It flows between beads that have no pair forces, and to frozen ones."""
    pairs = ("H H dpd 25 1.0", "H T dpd 30 1.0", "T T dpd 25 1.0")
    block = heat(
        f"capacity H {CAPACITY}", f"capacity T {CAPACITY}", f"pair H T kappa {1 / CAPACITY} range 1.2",
        f"pair T T kappa {1 / CAPACITY} range 1.0",
    )  # fmt: skip
    scene = molecule_scene(
        "HTTTT", {"bonds": [f"harm {k} {k + 1} 64.0 0.5" for k in range(1, 5)]}, chains(100, 5, 6.0, seed=11),
        copies=100, pairs=pairs, cell=6.0, extensions=block, frozen=(0,),
        control={**STILL, "timestep": "1e-4 internal_t"},
    )  # fmt: skip
    warm = np.random.default_rng(6).uniform(0.9, 1.5, scene.bead_count)
    scene = dataclasses.replace(scene, beads=dataclasses.replace(scene.beads, temperature=warm))
    ours, theirs = in_both(scene)
    assert_same_frame(ours, theirs, forces=1e-10)
    assert_same_parts(ours.observe(), theirs.observe())
    a, b = changes(ours, 1), changes(theirs, 1)
    frozen = scene.beads.frozen
    assert np.abs(a[frozen]).max() > 1e-5
    assert np.abs(a - b).max() <= 5e-4 * np.abs(a).max()
    assert np.all(theirs.velocities[frozen] == 0.0)


def test_sources_and_their_account() -> None:
    """Boxes, spheres and species where beads cross borders; the account is exact, and so is the conserved energy."""
    lines = (
        "source box 0 3 -3 3 -1 1 0.5", "source sphere 0.5 1 -1 1.2 0.4", "source species B -0.1",
        "source layer z 1.0 2.6 0.3", *flux_lines(1e4),
    )  # fmt: skip
    scene = mixture(*lines, control=STILL, capacity=1e4, timestep=0.002)
    ours, theirs = in_both(scene, ranks=2)
    assert theirs.energy["conserved"] == pytest.approx(ours.energy["conserved"], rel=1e-14)
    for simulation in (ours, theirs):
        simulation.run(37)
        simulation.observe()
        simulation.run(63)
    supplied = [simulation._engine.heat_account[0] for simulation in (ours, theirs)]
    # Here sources act at the ends of steps, there in halves: half a step differs, of 100.
    assert supplied[1] == pytest.approx(supplied[0], rel=0.02)
    assert abs(supplied[1]) > 1e3
    gained = theirs.energy["internal"] - float(np.sum(scene.beads.temperature * scene.beads.heat_capacity))  # type: ignore[operator]
    assert gained == pytest.approx(supplied[1], rel=1e-9)
    # Both have velocity Verlet's error in what is conserved; forces do not know the temperatures.
    assert theirs.energy["conserved"] == pytest.approx(ours.energy["conserved"], abs=1e-6)
    theirs.set_state(velocities=theirs.velocities)  # beads are handed over anew: no half step is lost
    theirs.run(20)
    gained = theirs.energy["internal"] - float(np.sum(scene.beads.temperature * scene.beads.heat_capacity))  # type: ignore[operator]
    assert gained == pytest.approx(theirs._engine.heat_account[0], rel=1e-9)


def test_sources_are_those_of_wrapped_places() -> None:
    """Fast beads without forces, which are beyond the border before LAMMPS wraps them; compared bead by bead."""
    rng = np.random.default_rng(2)
    lines = ("source box 1.0 9 -9 9 -9 9 0.5", "source sphere -1.5 0 0 1.2 0.25")
    scene = mixture(*lines, control=STILL, velocities=rng.normal(size=(500, 3)), timestep=0.01, laws=())
    ours, theirs = (changes(simulation, 50) for simulation in in_both(scene, ranks=2))
    assert np.abs(ours).max() > 0.2
    assert np.abs(ours - theirs).max() <= 0.5 * 0.01 * 0.75 + 1e-12  # half a step at a border that is crossed


@pytest.mark.parametrize("frozen", [(), ("B",)])
def test_walls_keep_their_temperature(frozen: tuple[str, ...]) -> None:
    scene = mixture("wall B 0.7", *flux_lines(1e4), control=STILL, capacity=1e4, timestep=0.002, frozen=frozen)
    ours, theirs = in_both(scene, ranks=2)
    start = theirs.energy["conserved"]
    for simulation in (ours, theirs):
        simulation.run(50)
    held = scene.beads.species == 1
    assert np.all(theirs.bead_arrays()["temperature"][held] == 0.7)
    a, b = (simulation._engine.heat_account[0] for simulation in (ours, theirs))
    assert a < -1e3
    assert b == pytest.approx(a, rel=0.02)
    assert theirs.energy["conserved"] == pytest.approx(start, abs=1e-6 * abs(start))
    assert np.abs(theirs.velocities[held]).max() > 0.0 or frozen


def test_values_that_are_exchanged_and_set() -> None:
    """Callbacks change temperatures between steps; the forces stay, and the noise with them."""
    scene = mixture(*flux_lines(), control=STILL)
    ours, theirs = in_both(scene)
    for simulation in (ours, theirs):
        simulation.add_callback(lambda moment: {"temperature": 0.5 * moment.temperature + 0.5}, 5)
        simulation.run(12)
        simulation.set_state(temperature=simulation.bead_arrays()["temperature"] + 0.125)
        simulation.run(3)
    a, b = (simulation.bead_arrays()["temperature"] for simulation in (ours, theirs))
    assert np.abs(a - b).max() < 1e-4
    assert_same_frame(ours, theirs, forces=1e-6, energy=1e-6)
    again = Simulation(mixture(*flux_lines(), control=STILL), seed=1, engine="lammps")
    before, forces = again.state, again.state.forces
    again._engine.exchange(before.temperature + 1.0, None)  # type: ignore[operator]
    assert np.array_equal(again.state.forces, forces)
    again.run(2)
    again._engine.exchange(again.state.temperature + 1.0, None)  # type: ignore[operator]
    again.run(1)
    assert np.abs(again.state.temperature - before.temperature - 2.0).max() < 0.01  # type: ignore[operator]


FIELD_BLOCK = "\n".join([
    "extension heat", "capacity A 1e4 temperature 1.1", "capacity B 1e4", "viscous_heating lammps",
    "pair A A kappa 1e-4 range 1.0 power 0.9 -0.4 0.3 -0.1", "pair A B kappa 1e-4 range 1.2",
    "source box -1 1 -1 1 -1 1 0.1", "end extension", "",
])  # fmt: skip


def heat_folder(path: Path, block: str = FIELD_BLOCK, **settings: str | None) -> Path:
    folder = run_folder(path, settings)
    (folder / "FIELD").write_text((folder / "FIELD").read_text() + block)
    return folder


def test_whole_runs_and_checkpoints(tmp_path: Path) -> None:
    """REVBEADS, DIAGNOSTICS and OUTPUT are there; either engine goes on from the other's checkpoint."""
    folder = heat_folder(tmp_path / "run", diagnostics_frequency="20 steps")
    scene = load(folder)
    for engine in ("native", "lammps"):
        run_scene(scene, tmp_path / engine, engine=engine, seed=5)
    ours, theirs = tmp_path / "native", tmp_path / "lammps"
    assert sorted(path.name for path in ours.iterdir()) == sorted(path.name for path in theirs.iterdir())
    a, b = (read_beads(path / "REVBEADS") for path in (ours, theirs))
    assert a.names == b.names == ("temperature",)
    assert np.abs(a.values - b.values).max() < 0.05
    (folder / "BEADS").write_bytes((theirs / "REVBEADS").read_bytes())
    start = Simulation(load(folder), engine="lammps", seed=1)
    assert np.array_equal(start.bead_arrays()["temperature"], b.values[:, 0])
    for first, second in (("native", "lammps"), ("lammps", "native")):
        simulation = Simulation(scene, seed=5, engine=first)
        simulation.run(20)
        simulation.save(tmp_path / "REVIVE")
        again = Simulation.resume(tmp_path / "REVIVE", scene=scene, engine=second)
        assert np.array_equal(again.state.temperature, simulation.state.temperature)  # type: ignore[arg-type]
        assert np.array_equal(again.state.forces, simulation.state.forces)
        assert again._engine.heat_account == simulation._engine.heat_account
        assert again.energy == simulation.energy
        again.run(10)
        gained = again.energy["internal"] - simulation.energy["internal"]
        supplied = again._engine.heat_account[0] - simulation._engine.heat_account[0]
        assert supplied == pytest.approx(gained, abs=0.05 * abs(gained))  # the heat of drag is of order 1/C_v


def test_temperatures_that_become_impossible_stop_the_run() -> None:
    """A sink takes more than there is; the native engine limits it to half of a bead's heat."""
    scene = mixture("source species A -40.0", control=STILL, capacity=1e4, timestep=0.002)
    simulation = Simulation(scene, seed=1, engine="lammps")
    with pytest.raises(RunError, match=r"an internal temperature has become -.* by step \d+: LAMMPS's steps"):
        simulation.run(20)


REFUSED = {
    "conserving": ((), {}, r"FIELD:\d+: viscous_heating conserving cannot be run with the engine lammps"),
    "drag": (
        ("viscous_heating lammps", "pair A B kappa 1e-22 range 1.0 drag 0.1 0 0 0"), {},
        r"FIELD:\d+: 'drag': a drag of A B that depends on temperature cannot be run",
    ),
    "explicit": (
        ("viscous_heating lammps", "pair A A kappa 1e-15 range 1.0"), {},
        r"FIELD:\d+: a conduction that would change temperatures by .* of their differences in a step cannot be run",
    ),
    "sphere": (
        ("viscous_heating lammps", "source sphere 2 0 0 1.0 0.1"), {},
        r"FIELD:\d+: a source in a sphere that reaches across the cell's border cannot be run",
    ),
    "masses": (
        ("viscous_heating lammps",), {"masses": {"A": 1.0, "B": 2.0}},
        r"FIELD:\d+: drag and noise of A B, which differ in mass and carry heat, cannot be run",
    ),
    "integrator": ((), {"control": {"ensemble_dpd_order": "ou"}}, r"the integrator ou cannot be run"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(name: str) -> None:
    lines, more, words = REFUSED[name]
    with pytest.raises(SceneError, match=words):
        translate(mixture(*lines, **more), 1)  # type: ignore[arg-type]


def test_boxes_of_tilted_cells() -> None:
    """A layer along z has images in any cell, one along x has not where other vectors lean over it."""
    cell = np.array([[6.0, 0, 0], [1.7, 5.5, 0], [0.4, 0, 6.3]])
    for axis, fits in (("x", False), ("y", True), ("z", True)):
        block = heat("capacity A 1e4", f"source layer {axis} 0 1 0.1")
        scene = make_scene({"A": 50}, ("A A dpd 25 1.0",), cell=cell, control=STILL, extensions=block)
        if fits:
            assert "edpd/source" in " ".join(translate(scene, 1).after)
            continue
        with pytest.raises(SceneError, match=r"FIELD:\d+: a source in a box across a tilted axis"):
            translate(scene, 1)


def test_accelerators_are_refused() -> None:
    scene = mixture(*flux_lines(), control=STILL)
    with pytest.raises(InputError, match="accelerator switches do not go with beads that carry heat or"):
        Simulation(scene, engine="lammps", accelerator="-sf omp -pk omp 1")


@pytest.mark.slow
def test_profiles_on_two_ranks() -> None:
    """A fluid that is warmed above and cooled below: T, P and the temperatures of eight layers."""
    block = heat(
        "capacity A 1e5", "viscous_heating lammps", "repulsion scaled",
        "pair A A kappa 1.41e-5 range 1.58 power 10.54 -3.66 3.44 -4.10 conductivity -0.44 -3.21 5.04 0.0",
        "source layer y 0 3 0.1", "source layer y -3 0 -0.1",
    )  # fmt: skip
    control = {"cutoff": "1.58 ang", "ensemble_dpd_exponent": "0.41"}
    scene = make_scene({"A": 864}, ("A A dpd 18.75 1.58 4.5",), cell=6.0, control=control, extensions=block)
    found = []
    for number, (engine, ranks) in enumerate((("native", None), ("lammps", 2))):
        simulation = Simulation(scene, seed=31 + number, engine=engine, ranks=ranks)
        simulation.run(400)
        rows = []
        for _ in range(120):
            simulation.run(5)
            seen, state = simulation.observe(), simulation.state
            layers = np.floor((state.positions[:, 1] / 6.0 + 0.5) * 8).astype(int) % 8
            warm = state.temperature
            assert warm is not None
            # The mean wanders with the numbers of beads in both halves; the account has it.
            profile = [float(warm[layers == k].mean() - warm.mean()) for k in range(8)]
            rows.append([seen.temperature, seen.pressure, *profile])
        found.append(block_errors(rows))
    (ours, error), (theirs, other) = found
    both = np.hypot(error, other)
    assert both[0] < 0.02
    assert both[1] < 2.0  # of 100; drag and noise are in it
    assert np.all(both[2:] < 0.003)
    assert ours[2:].max() - ours[2:].min() > 0.05
    assert np.all(np.abs(ours - theirs) <= 4.0 * both), (ours, theirs, both)
