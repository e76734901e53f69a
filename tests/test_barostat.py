"""Constant pressure: volumes and pressures against the ensemble, the splitting against its energy, files, restarts.

Bounds are at least four standard errors of the run in question; the seeds are fixed.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import Scene, Simulation
from pydlpoly.ase import atoms_from_state
from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.config import read_config
from pydlpoly.formats.history_reader import read_history
from pydlpoly.formats.records import FloatArray
from pydlpoly.formats.statis import read_statistics
from pydlpoly.reporters import radial_distributions
from pydlpoly.runner import run_scene

from .molecule_builder import chains, molecule_scene
from .scene_builder import make_scene

WATER = 23.65  # pressure of DPD water at the density 3
PISTON: dict[str, str | None] = {
    "ensemble": "npt",
    "pressure_hydrostatic": f"{WATER} dpd_p",
    "ensemble_barostat_coupling": "1.0 internal_t",
    "ensemble_barostat_friction": "1.0 internal_t^-1",
}
LANGEVIN: dict[str, str | None] = {
    "ensemble_method": "langevin",
    "ensemble_dpd_order": None,
    "ensemble_thermostat_friction": "1 internal_t^-1",
}


def water(beads: int = 648, **control: str | None) -> Scene:
    return make_scene({"A": beads}, cell=(beads / 3.1) ** (1 / 3), control={**PISTON, **control})


def crystal(**control: str | None) -> Scene:
    """A Lennard-Jones crystal, fcc, three cells an edge, cold."""
    corners = np.stack(np.meshgrid(*[np.arange(3)] * 3), axis=-1).reshape(-1, 1, 3)
    basis = 0.5 * np.array([[0, 0, 0], [1, 1, 0], [1, 0, 1], [0, 1, 1]])
    settings = {"cutoff": "2 ang", "timestep": "0.008 internal_t", "temperature": "0.3 dpd_temp"}
    return make_scene(
        {"A": 108},
        ["A A lj 1.0 1.0"],
        cell=3 * 1.57,
        positions=1.57 * (corners + basis).reshape(-1, 3),
        control={**PISTON, **LANGEVIN, **settings, "pressure_hydrostatic": "1 dpd_p", **control},
    )


class Sampled:
    """A run and what it showed: pressures without drag and noise, volumes, edges, temperatures."""

    def __init__(self, scene: Scene, *, skip: int, samples: int, every: int) -> None:
        self.simulation = Simulation(scene, seed=5, threads=1)
        self.simulation.run(skip)
        rows = []
        for _ in range(samples):
            self.simulation.run(every)
            seen = self.simulation.observe()
            parts = seen.stress_parts["conservative"] + seen.stress_parts["kinetic"]
            rows.append([seen.volume, seen.temperature, *np.diag(parts), *np.diag(self.simulation.cell)])
        table = np.array(rows)
        self.volume, self.temperature, self.pressure, self.edges = table[:, 0], table[:, 1], table[:, 2:5], table[:, 5:]
        self.momentum = np.abs(self.simulation.observe().momentum).max()


# -- Volumes and pressures --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("control", "expected"),
    [({**LANGEVIN, "fixed_com": "off"}, 41), (LANGEVIN, 40), ({"ensemble_dpd_order": "ou"}, 40)],
    ids=["langevin", "langevin with a fixed centre", "ou"],
)
def test_volumes_of_an_ideal_gas(control: dict[str, str | None], expected: int) -> None:
    """V has the weight V^(n-1) exp(-PV/kT), n = N + 1, or N where the centre of mass rests: mean n, variance n.

    20000 samples, correlated over about 10 of them: errors 0.16 of the mean, 1.3 of the variance.
    """
    settings = {"timestep": "0.05 internal_t", "pressure_hydrostatic": "1 dpd_p", **control}
    friction = {"ensemble_barostat_friction": "2 internal_t^-1"}
    scene = make_scene(
        {"A": 40}, ["A A dpd 0.0 1.0 4.5"], cell=40 ** (1 / 3), control={**PISTON, **settings, **friction}
    )
    found = Sampled(scene, skip=500, samples=20000, every=4)
    assert found.volume.mean() == pytest.approx(expected, abs=0.65)
    assert found.volume.var() == pytest.approx(expected, abs=5.5)
    assert found.pressure.mean() == pytest.approx(1.0, abs=0.015)
    assert found.temperature.mean() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    "control",
    [
        {"timestep": "0.01 internal_t"},
        {"ensemble_dpd_order": "middle", "timestep": "0.03 internal_t"},
        {"ensemble_dpd_order": "middle", "ensemble_dpd_interval": "2", "timestep": "0.02 internal_t"},
        {"ensemble_dpd_lambda": "0.9", "ensemble_dpd_kinetic": "half", "timestep": "0.03 internal_t"},
        {"ensemble_dpd_order": "second", "timestep": "0.01 internal_t"},
        {**LANGEVIN, "timestep": "0.03 internal_t"},
    ],
    ids=["mdvv", "middle", "middle every 2", "mdvv half", "second", "langevin"],
)
def test_density_and_pressure_of_water(control: dict[str, str | None]) -> None:
    """Errors 0.0015 of the density, 0.016 of the pressure, 0.0025 of the temperature."""
    found = Sampled(water(**control), skip=500, samples=1000, every=5)
    assert (648 / found.volume).mean() == pytest.approx(3.0, abs=0.01)
    assert found.pressure.mean() == pytest.approx(WATER, abs=0.08)
    assert found.temperature.mean() == pytest.approx(1.0, abs=0.01)
    assert found.momentum < 1e-11


@pytest.mark.parametrize(
    ("control", "moving", "equal"),
    [
        ({}, (True, True, True), False),
        ({"ensemble_semi_isotropic": "area"}, (False, False, True), False),
        ({"ensemble_semi_isotropic": "orthorhombic", "ensemble_semi_orthorhombic": "on"}, (True, True, True), True),
    ],
    ids=["edges", "height", "square"],
)
def test_pressures_along_each_axis(control: dict[str, str | None], moving: tuple[bool, ...], equal: bool) -> None:
    """Errors of a component 0.025."""
    settings = {"ensemble": "nst", "ensemble_dpd_order": "middle", "timestep": "0.03 internal_t", **control}
    found = Sampled(water(**settings), skip=300, samples=600, every=5)
    start = np.diag(found.simulation.start_cell)
    for axis in range(3):
        assert found.pressure[:, axis].mean() == pytest.approx(WATER, abs=0.12), axis
        assert bool(np.ptp(found.edges[:, axis]) > 0.01) == moving[axis]
        if not moving[axis]:
            assert (found.edges[:, axis] == start[axis]).all()
    ratio = found.edges[:, 0] / found.edges[:, 1]
    assert bool(np.ptp(ratio) < 1e-10) == (equal or not moving[0])
    assert found.momentum < 1e-11


def test_a_crystal_under_tension() -> None:
    """P_xx = P - tension/L_z, P_zz = P; STATIS' tensions are the target. Errors of a component 0.015."""
    tension = {"ensemble_semi_isotropic": "tension", "ensemble_tension": "3 dpd_f/dpd_l"}
    scene = crystal(ensemble="nst", **tension)
    found = Sampled(scene, skip=500, samples=1000, every=5)
    for axis in range(2):
        pull = 3.0 / found.edges[:, 2]
        assert (found.pressure[:, axis] + pull).mean() == pytest.approx(1.0, abs=0.08)
    assert found.pressure[:, 2].mean() == pytest.approx(1.0, abs=0.08)
    assert found.edges[:, 0].mean() > found.edges[:, 2].mean() + 0.01
    assert (found.edges[:, 0] != found.edges[:, 1]).any()


def test_pressures_that_differ_by_face() -> None:
    scene = crystal(ensemble="nst", pressure_hydrostatic=None, pressure_perpendicular="[ 1.0 2.0 0.5 ] dpd_p")
    found = Sampled(scene, skip=500, samples=1000, every=5)
    assert found.pressure.mean(axis=0) == pytest.approx([1.0, 2.0, 0.5], abs=0.08)


def dimers(copies: int, **control: str | None) -> Scene:
    """Pairs of beads on springs that feel nothing else."""
    settings = {**PISTON, **LANGEVIN, "timestep": "0.03 internal_t", "pressure_hydrostatic": "0.1 dpd_p", **control}
    cell = (10.0 * copies) ** (1 / 3)
    places = chains(copies, 2, cell, seed=1)
    return molecule_scene(
        ["A", "A"], {"bonds": ["harm 1 2 50.0 0.5"]}, places, copies=copies, cell=cell, control=settings
    )


def test_volumes_of_a_gas_of_dimers() -> None:
    """Springs pull as much as their beads push: the mean volume counts molecules. Error 1.5."""
    found = Sampled(dimers(30), skip=500, samples=8000, every=6)
    assert found.volume.mean() == pytest.approx(300, abs=8)
    assert found.volume.std() == pytest.approx(300 / np.sqrt(30), rel=0.15)


def test_dimers_continue_with_the_same_bits(tmp_path: Path) -> None:
    first = Simulation(dimers(700, ensemble="nst"), seed=3, threads=1)
    first.run(20)
    second = Simulation(dimers(700, ensemble="nst"), seed=3, threads=3)
    second.run(11)
    second.save(tmp_path / "REVIVE")
    third = Simulation.resume(tmp_path / "REVIVE", threads=2)
    third.run(9)
    for name in ("positions", "velocities", "forces", "cell"):
        assert getattr(third.state, name).tobytes() == getattr(first.state, name).tobytes(), name


@pytest.mark.parametrize("motion", ["npt", "nst"])
def test_energy_of_the_splitting(motion: str) -> None:
    """Without noise the energy with the piston's is conserved, with an error of second order in the timestep."""
    spread = []
    for timestep in (0.01, 0.005):
        still = dict.fromkeys(("ensemble_thermostat_friction", "ensemble_barostat_friction"), "1e-12 internal_t^-1")
        control = {**LANGEVIN, **still, "ensemble": motion, "timestep": f"{timestep} internal_t"}
        places = (np.stack(np.meshgrid(*[np.arange(5)] * 3), axis=-1).reshape(-1, 3) - 2.0) * 0.68
        scene = make_scene({"A": 125}, cell=3.4, positions=places, control={**PISTON, **control})
        simulation = Simulation(scene, seed=3, threads=1)
        energies = []
        for _ in range(round(2.0 / timestep)):
            simulation.run(1)
            seen = simulation.observe()
            # The kinetic energy reported is that of the middle of the step; the conserved one is that of its end.
            kinetic = 0.5 * float((simulation.state.velocities**2).sum())
            energies.append(seen.energy["potential"] + kinetic + seen.energy["thermostat"])
        spread.append(float(np.ptp(energies)))
        assert np.ptp(energies) < 3e-4 * energies[0]
    assert spread[0] / spread[1] == pytest.approx(4.0, rel=0.2)


def test_a_cell_that_collapses_is_reported() -> None:
    control = {"pressure_hydrostatic": "1e9 dpd_p", "ensemble_barostat_coupling": "0.01 internal_t"}
    with pytest.raises(RunError, match="step 1: the cell would change by more than a quarter in one step"):
        Simulation(water(**control), seed=1).run(10)


# -- State, files, restarts -------------------------------------------------------------------------------------------


def test_displacements_are_followed_in_scaled_coordinates() -> None:
    scene = water(200, pressure_hydrostatic="60 dpd_p", timestep="0.02 internal_t")
    simulation = Simulation(scene, seed=1)

    def places() -> FloatArray:
        return np.asarray(simulation.state.positions @ np.linalg.inv(simulation.cell))

    last, total = places(), np.zeros((200, 3))
    for _ in range(300):
        simulation.run(1)
        now = places()
        total += now - last - np.rint(now - last)
        last = now
    assert simulation.observe().volume < 0.85 * abs(np.linalg.det(scene.cell))
    assert simulation.displacements() == pytest.approx(total @ simulation.cell, abs=1e-9)
    assert np.abs(simulation.displacements()).max() > 1.0
    cell = simulation.cell
    assert simulation.state.cell.tolist() == cell.tolist()
    assert simulation.observe().volume == pytest.approx(np.linalg.det(cell), rel=1e-14)
    assert atoms_from_state(scene, simulation.state).cell[:].tolist() == cell.tolist()
    assert np.abs(last).max() <= 0.5


def test_a_cube_may_continue_with_edges_of_their_own(tmp_path: Path) -> None:
    """And the other way round; long-range corrections take part in the piston's bits."""
    cube, box = (replace(crystal(ensemble=name), imcon=imcon) for name, imcon in (("npt", 1), ("nst", 2)))
    first = Simulation(cube, seed=1, threads=1)
    first.run(30)
    first.save(tmp_path / "REVIVE")
    assert first.scene.imcon == 1
    second = Simulation.resume(tmp_path / "REVIVE", scene=box)
    second.run(30)
    second.save(tmp_path / "REVIVE")
    assert len(set(np.diag(second.cell).tolist())) == 3
    third = Simulation.resume(tmp_path / "REVIVE", threads=2)
    second.run(30)
    third.run(30)
    assert third.cell.tobytes() == second.cell.tobytes()
    assert third.state.positions.tobytes() == second.state.positions.tobytes()
    assert third.energy == second.energy
    assert Simulation.resume(tmp_path / "REVIVE", scene=cube).scene.imcon == 2


@pytest.mark.parametrize("units", ["dpd", "kJ"])
def test_energy_and_stress_belong_to_the_present_cell(units: str) -> None:
    """Against a scene made from the present state: pair sums, long-range corrections, units."""
    scene = crystal(pressure_hydrostatic="20 dpd_p") if units == "dpd" else crystal_in_kilojoules()
    simulation = Simulation(scene, seed=1)
    simulation.run(200)
    state = simulation.state
    start = simulation.start_cell[0, 0]
    assert state.cell[0, 0] < start - 0.01
    assert scene.long_range_correction
    beads = replace(scene.beads, positions=state.positions, velocities=state.velocities)
    run = replace(scene.run, start="noscale")
    fixed = replace(scene.dynamics, barostat=None)
    other = Simulation(replace(scene, cell=state.cell, beads=beads, run=run, dynamics=fixed), seed=1)
    seen, expected = simulation.observe(), other.observe()
    assert seen.energy["pair"] == pytest.approx(expected.energy["pair"], rel=1e-12)
    assert seen.stress_parts["conservative"] == pytest.approx(
        expected.stress_parts["conservative"], rel=1e-10, abs=1e-9
    )


def crystal_in_kilojoules() -> Scene:
    kelvin = {"temperature": "30 K", "pressure_hydrostatic": "3 katm", "timestep": "0.004 ps", "cutoff": "6.8 ang"}
    times = {"ensemble_barostat_coupling": "0.5 ps", "ensemble_barostat_friction": "2 ps^-1"}
    cold = crystal()
    return make_scene(
        {"A": 108},
        ["A A lj 1.0 3.4"],
        cell=3 * 1.57 * 3.4,
        positions=3.4 * cold.beads.positions,
        masses={"A": 40.0},
        units="kJ",
        control={**PISTON, **LANGEVIN, **kelvin, **times},
    )


def test_explain_says_what_the_barostat_does() -> None:
    text = crystal_in_kilojoules().explain()
    assert "barostat: Langevin piston; the edges of the cell change by one factor" in text
    assert "target pressure 3 katm, of conservative forces and velocities, without drag and noise" in text
    assert "t = 0.5 ps; friction 2 1/ps" in text
    assert "general path: the cell follows the pressure" in text
    tension = crystal(ensemble="nst", ensemble_semi_isotropic="tension", ensemble_tension="3 dpd_f/dpd_l").explain()
    assert "surface tension of the xy plane 3" in tension
    assert "each edge of the cell changes by its own factor" in tension


def test_relaxation_time_from_the_friction() -> None:
    scene = water(ensemble_barostat_coupling=None, ensemble_barostat_friction="2 internal_t^-1")
    assert scene.dynamics.barostat is not None
    assert scene.dynamics.barostat.relaxation == pytest.approx(1 / (4 * np.pi))
    assert any("no ensemble_barostat_coupling" in note.text for note in scene.notes)


FILES: dict[str, str | None] = {
    "time_run": "40 steps",
    "timestep": "0.02 internal_t",
    "pressure_hydrostatic": "40 dpd_p",
    "stats_frequency": "10 steps",
    "print_frequency": "10 steps",
    "traj_calculate": "on",
    "traj_interval": "20 steps",
    "rdf_calculate": "on",
    "rdf_frequency": "1 steps",
}


@pytest.mark.parametrize(("semi", "columns"), [("off", 10), ("area", 12), ("tension", 14), ("orthorhombic", 14)])
@pytest.mark.parametrize("yaml", ["on", "off"])
def test_files(tmp_path: Path, semi: str, columns: int, yaml: str) -> None:
    control = {**FILES, "ensemble": "nst", "ensemble_semi_isotropic": semi, "io_statis_yaml": yaml}
    scene = water(300, **control)
    simulation = run_scene(scene, tmp_path, seed=1).simulation
    seen, cell = simulation.observe(), simulation.cell
    table = read_statistics(tmp_path / "STATIS", species=("A",))
    assert len(table.columns) == 38 + columns
    names = [f"cell_{vector}{axis}" for vector in "abc" for axis in "xyz"]
    assert np.array([table[name][-1] for name in names]) == pytest.approx(cell.ravel(), rel=1e-6)
    assert table["volume"][-1] == pytest.approx(seen.volume, rel=1e-6)
    assert table["pressure_volume"][-1] == pytest.approx(seen.pressure * seen.volume, rel=1e-6)
    assert table["enthalpy"][-1] == pytest.approx(seen.energy["total"] + 40.0 * seen.volume, rel=1e-6)
    if columns > 10:
        assert table["cell_height"][-1] * table["cell_area"][-1] == pytest.approx(seen.volume, rel=1e-6)
    if columns > 12:
        assert table["tension_x"][-1] == pytest.approx(cell[2, 2] * (40.0 - seen.stress[0, 0]), rel=1e-5)
    frames = list(read_history(tmp_path / "HISTORY"))
    assert frames[0].cell[2, 2] == pytest.approx(scene.cell[2, 2], rel=1e-9)
    assert frames[-1].cell == pytest.approx(cell, abs=1e-9)
    config = read_config(tmp_path / "REVCON")
    assert (config.imcon, config.cell.tolist()) == (2, pytest.approx(cell, abs=1e-9))
    assert "Langevin piston" in (tmp_path / "OUTPUT").read_text()


def test_a_radial_distribution_is_normalised_with_the_mean_volume() -> None:
    scene = water(300, rdf_calculate="on", rdf_frequency="1 steps", timestep="0.02 internal_t")
    simulation = Simulation(scene, seed=1)
    volumes = []
    for _ in range(30):
        simulation.run(1)
        volumes.append(simulation.observe().volume)
    assert simulation.distance_volume == pytest.approx(np.mean(volumes), rel=1e-12)
    r, table = radial_distributions(simulation)
    counts, samples = simulation.distance_counts()
    inside = 4 / 3 * np.pi * (r[-1] + 0.5 * (r[1] - r[0])) ** 3
    expected = counts[0, 0].sum() * np.mean(volumes) / (samples * 0.5 * 300 * 299) / inside
    shells = r**2 + (r[1] - r[0]) ** 2 / 12
    assert (table["A", "A"][0] * shells).sum() / shells.sum() == pytest.approx(expected, rel=1e-9)


def test_a_run_continues_from_its_files_in_either_ensemble(tmp_path: Path) -> None:
    """With the cell it had at its start, with that of REVCON, and at the volume found."""
    scene = water(300, **FILES)
    whole = run_scene(scene, tmp_path / "whole", steps=80, seed=1).simulation
    run_scene(scene, tmp_path / "half", seed=1)
    config = read_config(tmp_path / "half" / "REVCON")
    later = replace(scene, cell=np.array(config.cell), beads=replace(scene.beads, positions=np.array(config.positions)))
    for start in (scene, later):
        resumed = Simulation.resume(tmp_path / "half" / "REVIVE", scene=start)
        resumed.run(40)
        assert resumed.state.positions.tobytes() == whole.state.positions.tobytes()
        assert resumed.cell.tobytes() == whole.cell.tobytes()
        assert resumed.displacements().tobytes() == whole.displacements().tobytes()
        assert resumed.distance_volume == whole.distance_volume
    run_scene(later, tmp_path / "half", steps=80, checkpoint=tmp_path / "half" / "REVIVE")
    for name in ("STATIS", "HISTORY", "RDFDAT", "REVCON"):
        assert (tmp_path / "half" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name
    fixed = replace(later, dynamics=replace(later.dynamics, barostat=None))
    simulation = Simulation.resume(tmp_path / "half" / "REVIVE", scene=fixed)
    volume, moved = simulation.observe().volume, simulation.displacements()
    assert moved.tobytes() == whole.displacements().tobytes()
    simulation.run(20)
    assert simulation.observe().volume == volume == pytest.approx(whole.observe().volume, rel=1e-14)
    assert simulation.scene.imcon == 2
    foreign = replace(scene, cell=1.01 * scene.cell)
    with pytest.raises(InputError, match="holds another cell"):
        Simulation.resume(tmp_path / "half" / "REVIVE", scene=foreign)
