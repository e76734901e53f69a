"""Many-body DPD with Lucy's kernel in the engine lammps: densities, forces and virial are the native engine's."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import Scene, SceneError, Simulation, load
from pydlpoly.engines.lammps_translate import translate
from pydlpoly.formats.binned_table import read_binned
from pydlpoly.formats.records import FloatArray
from pydlpoly.runner import run_scene
from pydlpoly.scene.model import Heat, HeatTerm

from ..molecule_builder import chains, molecule_scene
from ..run_folders import run_folder
from ..scene_builder import NVE, make_scene
from .engine_pairs import assert_same_frame, assert_same_parts, block_errors, cold, in_both

LUCY: dict[str, str | None] = {"mdpd_kernel": "lucy", "cutoff": "1.2 ang"}
CELLS = {
    "orthorhombic": np.diag([6.0, 5.5, 6.3]),
    "tilted": np.array([[6.0, 0, 0], [1.7, 5.5, 0], [-1.2, 2.1, 6.3]]),
}
LINES = ("A A mdpd -40 25 1 0.75 18", "A B mdpd -20 25 0.9 0.6 18", "B B mdpd -10 25 1.2 0.9 18")


def mixture(cell: str = "orthorhombic", lines: tuple[str, ...] = LINES, mass: float = 1.0, **more: object) -> Scene:
    """900 beads of two species at a density above that of the liquid."""
    control = {**NVE, **LUCY, **more.pop("control", {})}  # type: ignore[dict-item]
    return make_scene(
        {"A": 500, "B": 400}, lines, cell=CELLS[cell], masses={"A": mass, "B": mass}, control=control, start_seed=5,
        **more,  # type: ignore[arg-type]
    )  # fmt: skip


def assert_same_densities(ours: Simulation, theirs: Simulation) -> None:
    a, b = ours.bead_arrays()["density"], theirs.bead_arrays()["density"]
    assert a.max() > 3.0
    assert np.abs(a - b).max() <= 1e-12 * a.max()
    assert np.array_equal(b, theirs.local_densities())


@pytest.mark.parametrize("mass", [1.0, 2.5])
@pytest.mark.parametrize("cell", CELLS)
def test_frames_and_motion(cell: str, mass: float) -> None:
    """On two ranks, so that densities cross the border between them."""
    ours, theirs = in_both(mixture(cell, mass=mass), ranks=2)
    assert_same_frame(ours, theirs, forces=1e-10)
    assert_same_densities(ours, theirs)
    assert theirs.energy["pair"] == pytest.approx(ours.energy["pair"], rel=1e-12)  # without a many-body part
    for simulation in (ours, theirs):
        simulation.run(20)
    assert_same_frame(ours, theirs, forces=1e-10)
    assert_same_densities(ours, theirs)


def test_beside_another_law() -> None:
    """Pairs of another law and pairs without any are no neighbours."""
    lines = ("A A mdpd -40 25 1 0.75 18", "A B dpd 25 1.1", "B B mdpd -10 25 1.2 0.9 18")
    ours, theirs = in_both(mixture(lines=lines))
    assert_same_frame(ours, theirs, forces=1e-10)
    assert_same_densities(ours, theirs)
    ours, theirs = in_both(mixture(lines=lines[:2]))
    assert_same_frame(ours, theirs, forces=1e-10)
    a, b = ours.local_densities(), theirs.local_densities()
    assert np.abs(a - b).max() <= 1e-12 * a.max()


def test_frozen_beads_count_in_densities() -> None:
    scene = mixture(frozen=("B",))
    ours, theirs = in_both(scene, ranks=2)
    assert_same_frame(ours, theirs, forces=1e-10)
    assert_same_densities(ours, theirs)
    for simulation in (ours, theirs):
        simulation.run(10)
    assert_same_frame(ours, theirs, forces=1e-10)
    assert_same_densities(ours, theirs)
    assert np.all(theirs.velocities[scene.beads.frozen] == 0.0)


BOX = np.array([[6.0, 0, 0], [1.7, 5.5, 0], [-1.2, 2.1, 6.3]])


def molecules(key: str) -> Scene:
    """Chains of five beads whose bonds take away pair forces ("harm") or do not ("-hrm")."""
    pairs = ("H H mdpd -40 25 1 0.75 18", "H T mdpd -20 25 0.9 0.6 18", "T T mdpd -10 25 1.2 0.9 18")
    blocks = {"bonds": [f"{key} {k} {k + 1} 64.0 0.5" for k in range(1, 5)]}
    control = {**NVE, "mdpd_kernel": "lucy", "cutoff": "1.2 ang"}
    return molecule_scene("HTTTT", blocks, chains(180, 5, BOX, seed=11), copies=180, pairs=pairs, cell=BOX,
                          control=control)  # fmt: skip


@pytest.mark.parametrize("key", ["harm", "-hrm"])
def test_molecules(key: str) -> None:
    ours, theirs = in_both(molecules(key), ranks=2)
    assert_same_frame(ours, theirs, forces=1e-10)
    assert_same_densities(ours, theirs)
    for simulation in (ours, theirs):
        simulation.run(3)  # the start is violent
    assert_same_frame(ours, theirs, forces=1e-10)
    assert_same_densities(ours, theirs)


@pytest.mark.parametrize("prediction", ["0.5", "0.65"])
def test_drag_without_noise(prediction: str) -> None:
    """The same trajectory and the same parts of the stress; λ only matters to the drag."""
    control = {"ensemble_dpd_lambda": prediction, **LUCY}
    scene = make_scene({"A": 500}, ("A A mdpd -40 25 1 0.75 18",), cell=4.4, control=control, start_seed=5)
    ours, theirs = in_both(cold(scene), ranks=2)
    for simulation in (ours, theirs):
        simulation.run(15)
    assert_same_frame(ours, theirs, forces=1e-10)
    assert_same_parts(ours.observe(), theirs.observe())
    style = "mvv/dpd" if prediction != "0.5" else "nve"
    assert f"fix motion all {style}" in theirs.explain()


def test_lambda_of_any_scene() -> None:
    """Also without local densities."""
    scene = make_scene({"A": 375}, cell=5.0, control={"ensemble_dpd_lambda": "0.65"})
    half = make_scene({"A": 375}, cell=5.0)
    ours, theirs = in_both(cold(scene))
    other = Simulation(cold(half), seed=1, threads=1)
    for simulation in (ours, theirs, other):
        simulation.run(15)
    assert_same_frame(ours, theirs, forces=1e-10)
    assert np.abs(other.positions - theirs.positions).max() > 1e-4


def test_the_kernel_of_an_energy_is_refused() -> None:
    """With FIELD's line; LAMMPS has no other kernel than Lucy's."""
    scene = make_scene({"A": 50}, ("A A mdpd -40 25 1 0.75 18",), cell=6.0, control=NVE)
    with pytest.raises(SceneError, match=r"FIELD:10: mdpd with the kernel warren cannot be run with the engine lammps"):
        translate(scene, 1)


def test_unequal_masses_are_refused() -> None:
    scene = make_scene({"A": 50, "B": 50}, LINES, cell=6.0, masses={"A": 1.0, "B": 2.0}, control={**NVE, **LUCY})
    with pytest.raises(SceneError, match=r"FIELD:\d+: mdpd between beads of the masses 1, 2 cannot be run"):
        translate(scene, 1)


def test_beads_of_one_species_frozen_and_not_are_refused() -> None:
    """LAMMPS's types could not tell them apart."""
    blocks = {"bonds": ["harm 1 2 64.0 0.5"]}
    scene = molecule_scene(
        "AA", blocks, chains(20, 2, 6.0, seed=1), copies=20, pairs=("A A mdpd -40 25 1 0.75 18",), cell=6.0,
        control={**NVE, "mdpd_kernel": "lucy"}, frozen=(0,),
    )  # fmt: skip
    with pytest.raises(SceneError, match="'A': beads A that are frozen beside beads A that are not"):
        translate(scene, 1)


def test_mixed_scenes_in_molecules_are_refused() -> None:
    """Heat flows between bonded beads, which must be in the lists; the densities must not see them."""
    scene = molecules("harm")
    count = scene.bead_count
    beads = dataclasses.replace(scene.beads, temperature=np.ones(count), heat_capacity=np.full(count, 1e5))
    with pytest.raises(SceneError, match="mdpd with heat or dissolved species in molecules cannot be run"):
        translate(dataclasses.replace(scene, beads=beads, heat=Heat((HeatTerm((0, 0), 1e-6, 1.0, 2.0),))), 1)


def test_whole_runs_and_checkpoints(tmp_path: Path) -> None:
    """Densities in PROFILE; either engine goes on from the other's checkpoint."""
    folder = run_folder(tmp_path / "run", {"mdpd_kernel": "lucy", "profile_frequency": "10 steps"})
    field = folder / "FIELD"
    text = field.read_text()
    for law in ("A A dpd 25.0 1.0 4.5", "A B dpd 30.0 1.0 4.5", "B B dpd 25.0 1.0 9.0"):
        text = text.replace(law, f"{law[:3]} mdpd -40 25 1 0.75 18")
    field.write_text(text)
    scene = load(folder)
    run_scene(scene, tmp_path / "out", engine="lammps", ranks=2, seed=5)
    assert read_binned(tmp_path / "out" / "PROFILE")["local_density"].max() > 0.5
    for first, second in (("native", "lammps"), ("lammps", "native")):
        simulation = Simulation(scene, seed=5, engine=first)
        simulation.run(10)
        simulation.save(tmp_path / "REVIVE")
        again = Simulation.resume(tmp_path / "REVIVE", scene=scene, engine=second)
        assert np.array_equal(again.positions, simulation.positions)
        a, b = simulation.local_densities(), again.local_densities()
        assert np.abs(a - b).max() <= 1e-12 * a.max()
        again.run(5)
        assert again.step == 15


def test_accelerator_switches() -> None:
    """Which are refused where beads carry heat or dissolved species."""
    plain, fast = (Simulation(mixture(), seed=1, engine="lammps", accelerator=a) for a in ("", "-sf omp -pk omp 1"))
    for simulation in (plain, fast):
        simulation.run(20)
    assert_same_frame(plain, fast, forces=1e-10)
    assert_same_densities(plain, fast)


@pytest.mark.slow
def test_averages_of_a_liquid_on_two_ranks() -> None:
    """T, P, the attraction's energy and the mean density of the bulk differ by less than four standard errors."""
    control = {**LUCY, "cutoff": "1.0 ang"}
    scene = make_scene({"A": 750}, ("A A mdpd -40 25 1 0.75 4.5",), cell=4.8, control=control, start_seed=3)
    found = []
    for number, (engine, ranks) in enumerate((("native", None), ("lammps", 2))):
        simulation = Simulation(scene, seed=21 + number, engine=engine, ranks=ranks)
        simulation.run(400)
        rows = []
        for _ in range(300):
            simulation.run(5)
            seen = simulation.observe()
            rows.append(
                [seen.temperature, seen.pressure, seen.energy["pair"] / 750, float(simulation.local_densities().mean())]
            )
        found.append(block_errors(rows))
    (ours, error), (theirs, other) = found
    both: FloatArray = np.hypot(error, other)
    assert np.all(both < [0.01, 0.5, 0.1, 0.02]), both
    assert np.all(np.abs(ours - theirs) <= 4.0 * both), (ours, theirs, both)
