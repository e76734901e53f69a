"""The engine lammps in motion: deterministic integrators step by step, DPD by its averages on two ranks."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import RunError, Scene, SceneError, Simulation, load, single_point
from pydlpoly.cli import example_folder
from pydlpoly.engines.lammps_translate import translate
from pydlpoly.engines.lammps_translate.refusal import KNOWN, Places, refuse_unknown
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import ExternalTerm

from ..molecule_builder import chains, molecule_scene
from ..run_folders import run_folder
from ..scene_builder import NVE, make_scene

LJ = ("A A lj 1.0 1.0", "A B lj 0.7 1.1", "B B lj 1.4 0.9")
EDGE = 6.9


def mixture(**more: object) -> Scene:
    """216 Lennard-Jones beads of two masses with velocities of their own."""
    places = EDGE / 6.0 * (np.stack(np.meshgrid(*[np.arange(6)] * 3), axis=-1).reshape(-1, 3) - 2.5)
    rng = np.random.default_rng(8)
    control = {"timestep": "0.002 internal_t", "cutoff": "2.5 ang", **more.pop("control", {})}  # type: ignore[dict-item]
    return make_scene(
        {"A": 120, "B": 96},
        LJ,
        cell=EDGE,
        positions=rng.permutation(places) + 0.1 * (rng.random((216, 3)) - 0.5),
        velocities=rng.normal(size=(216, 3)),
        masses={"A": 1.0, "B": 2.5},
        control=control,
        **more,  # type: ignore[arg-type]
    )


def assert_same_motion(scene: Scene, steps: int = 150, ranks: int = 1) -> tuple[Simulation, Simulation]:
    """Run both engines; positions, velocities and what is observed must agree while chaos is still small."""
    pair = (Simulation(scene, seed=1, threads=1), Simulation(scene, seed=1, engine="lammps", ranks=ranks))
    for simulation in pair:
        simulation.run(steps)
    ours, theirs = (simulation.state for simulation in pair)
    assert theirs.step == steps
    assert theirs.time == pytest.approx(ours.time, rel=1e-12)
    assert np.abs(ours.positions - theirs.positions).max() < 1e-8
    assert np.array_equal(ours.images, theirs.images)
    assert np.abs(ours.velocities - theirs.velocities).max() < 1e-7
    assert np.abs(ours.forces - theirs.forces).max() < 1e-5
    seen, other = (simulation.observe() for simulation in pair)
    for name, value in seen.energy.items():
        assert other.energy[name] == pytest.approx(value, abs=1e-7 * max(1.0, abs(seen.energy["total"]))), name
    assert other.temperature == pytest.approx(seen.temperature, rel=1e-8)
    for name, tensor in seen.stress_parts.items():
        assert np.abs(other.stress_parts[name] - tensor).max() < 1e-6 * np.abs(seen.stress).max(), name
    assert np.abs(other.momentum - seen.momentum).max() < 1e-8
    return pair


@pytest.mark.parametrize("tails", ["on", "off"])
def test_constant_energy(tails: str) -> None:
    assert_same_motion(mixture(control={**NVE, "vdw_long_range_correction": tails}), ranks=2)


@pytest.mark.parametrize("method", ["berendsen", "hoover"])
def test_deterministic_thermostats(method: str) -> None:
    control = {
        "ensemble_method": method,
        "ensemble_dpd_order": None,
        "ensemble_thermostat_coupling": "0.05 ps",
        "temperature": "1.4 dpd_temp",
    }
    ours, theirs = assert_same_motion(mixture(control=control))
    assert abs(ours.temperature - 1.4) < 0.4
    if method == "hoover":
        assert abs(theirs.energy["thermostat"]) > 1.0


def test_frozen_beads_and_gravity() -> None:
    control = {**NVE, "vdw_long_range_correction": "off"}
    scene = mixture(control=control, frozen=("B",), extern="grav 0.3 -0.2 0.5")
    _, theirs = assert_same_motion(scene)
    assert np.all(theirs.velocities[scene.beads.frozen] == 0.0)
    assert np.all(theirs.state.forces[scene.beads.frozen] == 0.0)


@pytest.mark.parametrize("method", ["", "berendsen"])
def test_gravity_whose_drift_is_removed(method: str) -> None:
    thermostat = {"ensemble_method": method, "ensemble_dpd_order": None, "ensemble_thermostat_coupling": "0.05 ps"}
    scene = mixture(control=thermostat if method else NVE, extern="grav 0.3 -0.2 0.5")
    assert scene.dynamics.remove_drift
    assert_same_motion(scene)


def test_electric_field() -> None:
    charges = {"A": 0.8, "B": -1.0}
    scene = mixture(control={**NVE, "coul_method": "off"}, charges=charges, extern="elec 1.0 -2.0 3.0")
    ours, _ = assert_same_motion(scene)
    still = single_point(dataclasses.replace(scene, external=()))
    moved = single_point(scene)
    assert np.abs(moved.forces - still.forces).max() > 1.0
    assert ours.scene.external


def test_cells_that_are_crossed_are_counted() -> None:
    """Some 700 cells, in pieces: LAMMPS counts modulo 1024."""
    scene = make_scene(
        {"A": 4},
        (),
        cell=3.0,
        velocities=np.array([[50.0, 0, 0], [-50.0, 1.0, 0], [0, 30.0, 0], [0, 0, 1.0]]),
        control={**NVE, "coul_method": "off"},
    )
    pair = (Simulation(scene, seed=1), Simulation(scene, seed=1, engine="lammps"))
    for simulation in pair:
        for _ in range(3):
            simulation.run(1500)
            simulation.displacements()
    ours, theirs = (simulation.displacements() for simulation in pair)
    assert np.abs(ours).max() > 2000.0
    assert np.abs(ours - theirs).max() < 1e-6


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_seed_and_a_number_of_ranks_give_one_run(ranks: int) -> None:
    """However it is cut into pieces, and whatever is looked at in between."""
    scene = make_scene({"A": 375}, cell=5.0)
    whole, pieces = (Simulation(scene, seed=7, engine="lammps", ranks=ranks) for _ in range(2))
    whole.run(60)
    for steps in (1, 7, 22, 30):
        pieces.run(steps)
        pieces.state  # noqa: B018  # gathers the beads
        pieces.observe()
    assert np.array_equal(whole.positions, pieces.positions)
    assert np.array_equal(whole.velocities, pieces.velocities)


def test_state_that_is_set() -> None:
    scene = mixture(control={**NVE, "vdw_long_range_correction": "off"})
    pair = (Simulation(scene, seed=1), Simulation(scene, seed=1, engine="lammps"))
    for simulation in pair:
        simulation.run(20)
        simulation.set_state(positions=scene.beads.positions + 0.7 * EDGE, velocities=-scene.beads.velocities)  # type: ignore[operator]
        simulation.run(20)
    ours, theirs = (simulation.state for simulation in pair)
    assert np.abs(ours.positions - theirs.positions).max() < 1e-10
    assert np.array_equal(ours.images, theirs.images)


def test_what_the_native_core_lends() -> None:
    """Configurational temperature and layers of stress of the present beads are the native core's."""
    scene = mixture(control={**NVE, "vdw_long_range_correction": "off"})
    ours, theirs = Simulation(scene, seed=1), Simulation(scene, seed=1, engine="lammps")
    for simulation in (ours, theirs):
        simulation.run(10)
    assert theirs.configurational_temperature == pytest.approx(ours.configurational_temperature, rel=1e-8)
    for a, b in zip(ours.layer_sums(2, 5), theirs.layer_sums(2, 5), strict=True):
        assert np.allclose(a, b, rtol=1e-7, atol=1e-7)
    theirs.run(10)  # and LAMMPS goes on as before
    ours.run(10)
    assert np.abs(ours.positions - theirs.positions).max() < 1e-10


def test_accelerator_switches_are_passed_on() -> None:
    scene = mixture(control={**NVE, "vdw_long_range_correction": "off"})
    plain = Simulation(scene, seed=1, engine="lammps")
    fast = Simulation(scene, seed=1, engine="lammps", accelerator="-sf omp -pk omp 1")
    for simulation in (plain, fast):
        simulation.run(20)
    assert np.abs(plain.positions - fast.positions).max() < 1e-10


@pytest.mark.parametrize("ranks", [1, 2])
def test_beads_that_fly_away_stop_the_run(ranks: int) -> None:
    """Hard beads at random places; the state stays that of the last step whose beads were asked for."""
    control = {**NVE, "timestep": "0.01 internal_t", "cutoff": "2.5 ang"}
    scene = make_scene({"A": 400}, ("A A lj 1.0 1.0",), cell=9.0, control=control)
    simulation = Simulation(scene, seed=1, engine="lammps", ranks=ranks)
    before = simulation.positions
    with pytest.raises(RunError, match=r"LAMMPS stopped: .*in steps 1 to \d+; the state here is that of step 0"):
        simulation.run(50)
    assert simulation.step == 0
    assert np.array_equal(simulation.positions, before)
    with pytest.raises(RunError, match="LAMMPS has ended"):
        simulation.run(1)


# Averages of DPD


def averages(simulation: Simulation, equilibration: int, steps: int, every: int = 5) -> tuple[FloatArray, FloatArray]:
    """Return means and standard errors (of 12 blocks) of T, P and the energies by component a bead."""
    simulation.run(equilibration)
    rows = []
    for _ in range(steps // every):
        simulation.run(every)
        seen = simulation.observe()
        parts = [seen.energy[name] for name in ("pair", "bond", "angle", "charge")]
        rows.append([seen.temperature, seen.pressure, *(part / simulation.scene.bead_count for part in parts)])
    table = np.array(rows)
    blocks = np.array([block.mean(axis=0) for block in np.array_split(table, 12)])
    return table.mean(axis=0), blocks.std(axis=0, ddof=1) / np.sqrt(12)


def water() -> Scene:
    return make_scene({"A": 375}, cell=5.0, control={"timestep": "0.02 internal_t"})


def fluid_mixture() -> Scene:
    lines = ["A A dpd 25.0 1.0 1.0", "B B dpd 30.0 1.0 20.0"]
    return make_scene(
        {"A": 190, "B": 185},
        lines,
        cell=5.0,
        masses={"A": 1.0, "B": 3.0},
        control={"timestep": "0.02 internal_t", "vdw_mix_method": "lorentz-berthelot"},
    )


def lipid() -> Scene:
    scene = load(example_folder("lipid"))
    return dataclasses.replace(scene, output=dataclasses.replace(scene.output, rdf_every=0))


def electrolyte() -> Scene:
    pairs = [f"{a} {b} dpd 25.0 1.0 4.5" for k, a in enumerate("WPM") for b in "WPM"[k:]]
    return make_scene(
        {"W": 300, "P": 38, "M": 37 + 1},
        pairs,
        cell=5.0,
        charges={"P": 1.0, "M": -1.0},
        control={
            "timestep": "0.02 internal_t",
            "cutoff": "2.4 ang",
            "coul_method": "spme",
            "coul_coupling": "13.87",
            "spme_precision": "1e-4",
            "charge_smearing_method": "slater",
            "charge_smearing_beta": "0.929",
        },
    )


# (scene, equilibration, steps); the lipids start from a configuration that both engines relax alike.
AVERAGED = {
    "water": (water, 300, 2400),
    "mixture": (fluid_mixture, 300, 2400),
    "lipid": (lipid, 800, 1000),
    "charged": (electrolyte, 300, 1200),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", AVERAGED)
def test_averages_on_two_ranks(name: str) -> None:
    """Means differ by less than four standard errors of the difference, and not because the errors are large."""
    make, equilibration, steps = AVERAGED[name]
    scene = make()
    ours, error = averages(Simulation(scene, seed=11, threads=1), equilibration, steps)
    theirs, other = averages(Simulation(scene, seed=12, engine="lammps", ranks=2), equilibration, steps)
    both = np.hypot(error, other)
    assert both[0] < 0.02
    assert both[1] < 0.3
    assert np.all(np.abs(ours - theirs) <= 4.0 * both + 1e-12), (ours, theirs, both)


@pytest.mark.slow
def test_langevin_keeps_the_temperature() -> None:
    control = {
        "ensemble_method": "langevin",
        "ensemble_dpd_order": None,
        "ensemble_thermostat_friction": "2.0 ps^-1",
        "temperature": "1.2 dpd_temp",
    }
    mean, error = averages(Simulation(mixture(control=control), seed=3, engine="lammps"), 1000, 8000, 10)
    assert abs(mean[0] - 1.2) < 4.0 * error[0] + 0.005
    assert error[0] < 0.02


# Refusals

REFUSED = {
    "integrator": ({"ensemble_dpd_order": "second"}, "ensemble_dpd_order", "the integrator second"),
    "half-step kinetic": ({"ensemble_dpd_kinetic": "half"}, "ensemble_dpd_kinetic", "half step kinetic"),
    "mixed precision": ({"precision": "mixed"}, "precision", "precision mixed"),
    "shear": ({"shear_rate": "0.1 ps^-1"}, "shear_rate", "shear rate"),
    "force cap": (
        {"equilibration_force_cap": "100.0 k_b.temp/ang", "time_equilibration": "10 steps"},
        "equilibration_force_cap",
        "force cap",
    ),
    "schedule": (
        {"temperature_times": "[ 0.0 1.0 ] ps", "temperature_values": "[ 1.0 2.0 ] dpd_temp"},
        "temperature_times",
        "schedule",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_settings_that_are_refused(name: str, tmp_path: Path) -> None:
    """The message names CONTROL, the line and the keyword; the file is looked up again where the scene came from."""
    settings, keyword, words = REFUSED[name]
    path = run_folder(tmp_path / "run", settings)
    lines = (path / "CONTROL").read_text().splitlines()
    line = next(k for k, text in enumerate(lines, 1) if text.split()[0].startswith(keyword))
    scene = load(path)
    with pytest.raises(SceneError, match=words) as caught:
        translate(scene, 1)
    assert caught.value.line == line, str(caught.value)
    assert caught.value.path == str(path / "CONTROL")


def test_a_barostat_is_refused(tmp_path: Path) -> None:
    settings = {
        "ensemble": "npt",
        "pressure_hydrostatic": "23.0 dpd_p",
        "ensemble_barostat_coupling": "1.0 internal_t",
        "ensemble_barostat_friction": "1.0 internal_t^-1",
    }
    path = run_folder(tmp_path / "run", settings)
    line = (path / "CONTROL").read_text().splitlines().index("ensemble npt") + 1
    with pytest.raises(SceneError, match=rf"CONTROL:{line}: 'ensemble': barostat cannot be run"):
        translate(load(path), 1)


def test_constraints_are_refused() -> None:
    scene = molecule_scene("HT", {"constraints": ["1 2 0.5"]}, chains(5, 2, 6.0, seed=1, step=0.5), copies=5, cell=6.0)
    with pytest.raises(SceneError, match=r"FIELD:10: constraints cannot be run"):
        translate(scene, 1)


def test_walls_are_refused() -> None:
    positions = 4.0 * (np.random.default_rng(1).random((10, 3)) - 0.5)
    control = {**NVE, "fixed_com": "off", "wall_method": "reflecting", "wall_axes": "z"}
    scene = make_scene({"A": 10}, ("A A dpd 25.0 1.0",), cell=6.0, positions=positions, control=control)
    with pytest.raises(SceneError, match=r"CONTROL:\d+: walls cannot be run"):
        translate(scene, 1)


def test_an_external_field_that_is_refused() -> None:
    scene = make_scene(
        {"A": 10, "B": 10},
        cell=6.0,
        pairs=("A A dpd 25.0 1.0", "A B dpd 25.0 1.0", "B B dpd 25.0 1.0"),
        charges={"A": 1.0, "B": -1.0},
        control=NVE,
        extern="osel 1.0 0.0 0.0 2.0",
    )
    with pytest.raises(SceneError, match=r"FIELD:\d+: the external field osel cannot be run with the engine lammps"):
        translate(scene, 1)


@dataclasses.dataclass(frozen=True)
class Novelty:
    """Something that a scene may have one day, in parts that know their line."""

    parts: tuple[ExternalTerm, ...]


def test_unknown_parts_are_refused() -> None:
    """A part that someone adds to the scene is refused until it is translated."""
    novelty = ("novelty", object, dataclasses.field(default=None))
    field_type = dataclasses.make_dataclass("NewScene", [novelty], bases=(Scene,), frozen=True, eq=False)
    scene = water()
    values = {field.name: getattr(scene, field.name) for field in dataclasses.fields(scene)}
    KNOWN[field_type] = KNOWN[Scene]
    try:
        refuse_unknown(field_type(**values), Places(scene))
        with pytest.raises(SceneError, match="novelty 3 cannot be run with the engine lammps"):
            refuse_unknown(field_type(**values, novelty=3), Places(scene))
        given = Novelty((ExternalTerm("some", (), "FIELD:12"),))
        with pytest.raises(SceneError, match="FIELD:12: novelty cannot be run with the engine lammps"):
            refuse_unknown(field_type(**values, novelty=given), Places(scene))
    finally:
        del KNOWN[field_type]


def test_cells_that_are_refused() -> None:
    open_cell = make_scene({"A": 10}, ("A A dpd 25.0 1.0",), cell=6.0, imcon=6, control=NVE)
    with pytest.raises(SceneError, match="not periodic along all three axes"):
        translate(open_cell, 1)
    turned = [[0.0, 6.0, 0.0], [0.0, 0.0, 6.0], [6.0, 0.0, 0.0]]
    with pytest.raises(SceneError, match="a cell whose vectors are not"):
        translate(make_scene({"A": 10}, ("A A dpd 25.0 1.0",), cell=turned, control=NVE), 1)
