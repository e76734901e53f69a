"""The stress in layers: sums, lines shared out by hand, an independent count in NumPy, gases, restarts and files."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import Scene, Simulation, load
from pydlpoly.cli import example_folder
from pydlpoly.engines.native_scene import long_range_tail
from pydlpoly.errors import InputError, SceneError
from pydlpoly.reporters import StressCorrelations, StressProfile
from pydlpoly.runner import run_scene
from pydlpoly.scene.model import ProfilePlan

from .run_folders import run_folder
from .scene_builder import NVE, make_scene

PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
WATER = ("A A dpd 25.0 1.0 4.5",)


def tensor(six: np.ndarray) -> np.ndarray:
    full = np.zeros((*six.shape[:-1], 3, 3))
    for k, (a, b) in enumerate(PLACES):
        full[..., a, b] = full[..., b, a] = six[..., k]
    return full


def symmetric(matrix: np.ndarray) -> np.ndarray:
    return 0.5 * (matrix + matrix.T)


def prism() -> Scene:
    """A cell whose vectors a and b are not perpendicular, but both to c."""
    return make_scene({"A": 300}, WATER, cell=[[5.0, 0.0, 0.0], [1.5, 4.5, 0.0], [0.0, 0.0, 4.0]])


def small_cell() -> Scene:
    """Pairs see several images of each other."""
    return make_scene({"A": 20}, WATER, cell=[1.8, 2.0, 1.6], control={"precision": "reference"})


CASES = {
    "water": lambda: load(example_folder("water")),
    "mixture": lambda: load(example_folder("mixture")),
    "lipid": lambda: load(example_folder("lipid")),
    "argon": lambda: load(example_folder("argon")),
    "prism": prism,
    "small": small_cell,
    "frozen": lambda: make_scene({"A": 200, "W": 100}, (*WATER, "A W dpd 40.0 1.0 4.5"), cell=4.5, frozen=["W"]),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("layers", [1, 7, 61])
def test_layers_add_up_to_the_stress_of_the_cell(name: str, layers: int) -> None:
    simulation = Simulation(CASES[name](), seed=3, threads=2)
    simulation.run(3)
    seen = simulation.observe()
    scene = simulation.scene
    unit = seen.volume / scene.units.pressure_factor
    tail = np.eye(3) * long_range_tail(scene)[1] / seen.volume / 3.0
    for axis in (2,) if name == "prism" else (0, 1, 2):
        *sums, beads = simulation.layer_sums(axis, layers)
        parts = seen.stress_parts
        wanted = parts["kinetic"] * unit, parts["conservative"] * unit + tail, parts["bonded"] * unit
        for six, whole in zip(sums, wanted, strict=True):
            assert six.shape == (layers, 6)
            scale = max(float(np.abs(whole).max()), 1e-300)
            np.testing.assert_allclose(tensor(six).sum(axis=0) / scale, symmetric(whole) / scale, rtol=0, atol=1e-10)
        assert beads.sum(axis=0).tolist() == np.bincount(scene.beads.species, minlength=len(scene.species)).tolist()


@pytest.mark.parametrize("name", ["lipid", "mixture", "argon"])
def test_any_number_of_threads_has_the_same_bits(name: str) -> None:
    found = []
    for threads in (1, 2, 3):
        simulation = Simulation(CASES[name](), seed=3, threads=threads)
        simulation.run(4)
        found.append([array.tobytes() for array in simulation.layer_sums(2, 29)])
    assert found[0] == found[1] == found[2]


def two_beads(low: float, high: float) -> Simulation:
    """Two beads at x = ±0.1 with these heights in a cell of height 4, at rest."""
    places = [[0.1, 0.0, low], [-0.1, 0.0, high]]
    control = {"restart_mode": None, **NVE, "timestep": "1e-9 internal_t"}
    scene = make_scene({"A": 2}, ("A A dpd 25.0 1.0",), cell=[3.0, 3.0, 4.0], positions=places, control=control,
                       velocities=np.zeros((2, 3)))  # fmt: skip
    return Simulation(scene, seed=1)


@pytest.mark.parametrize(
    ("low", "high", "shares"),
    [
        (-1.75, -1.25, {0: 0.5, 1: 0.5}),
        (-1.9, -1.6, {0: 1.0}),
        (-1.6, -0.9, {0: 1 / 7, 1: 5 / 7, 2: 1 / 7}),
        (1.9, -1.8, {7: 1 / 3, 0: 2 / 3}),  # across the cell's face
        (0.25, 0.25, {4: 1.0}),  # along the layer
    ],
)
def test_a_pair_s_line_is_shared_out_by_length(low: float, high: float, shares: dict[int, float]) -> None:
    """Eight layers of 0.5; both beads' order."""
    for first, second in ((low, high), (high, low)):
        simulation = two_beads(first, second)
        _, pairs, bonded, beads = simulation.layer_sums(2, 8)
        rise = (second - first + 2.0) % 4.0 - 2.0
        arm = np.array([0.2, 0.0, -rise])
        distance = np.linalg.norm(arm)
        whole = 25.0 * (1.0 - distance) / distance * np.outer(arm, arm)
        expected = np.zeros((8, 3, 3))
        for layer, share in shares.items():
            expected[layer] = share * whole
        np.testing.assert_allclose(tensor(pairs), expected, rtol=1e-9, atol=1e-12)
        assert not bonded.any()
        assert beads.sum() == 2


def share_line(profile: np.ndarray, height: float, rise: float, whole: np.ndarray) -> None:
    """Brute force: a thousand points of the line, each with a thousandth of it."""
    points = (height - rise * (np.arange(1000) + 0.5) / 1000.0) * len(profile)
    np.add.at(profile, np.floor(points).astype(int) % len(profile), whole / 1000.0)


def test_pairs_against_an_independent_count() -> None:
    scene = make_scene(
        {"A": 150, "B": 50}, (*WATER, "A B dpd 40.0 0.9 4.5", "B B dpd 15.0 0.8 4.5"), cell=[4.0, 3.0, 5.0]
    )
    simulation = Simulation(scene, seed=2)
    simulation.run(5)
    positions, cell = simulation.state.positions, np.array([4.0, 3.0, 5.0])
    laws = {(0, 0): (25.0, 1.0), (0, 1): (40.0, 0.9), (1, 1): (15.0, 0.8)}
    expected = np.zeros((9, 3, 3))
    for i, j in itertools.combinations(range(200), 2):
        d = positions[i] - positions[j]
        d -= cell * np.rint(d / cell)
        r = float(np.linalg.norm(d))
        a, cutoff = laws[tuple(sorted((int(scene.beads.species[i]), int(scene.beads.species[j]))))]
        if r < cutoff:
            force = a * (1.0 - r / cutoff) / r * d
            share_line(expected, positions[i, 2] / 5.0 + 0.5, d[2] / 5.0, np.outer(force, d))
    found = tensor(simulation.layer_sums(2, 9)[1])
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-3 * np.abs(expected).max())  # points of a line


MOLECULE = """chain
units dpd
molecules 1
T
nummols 1
atoms 4
A 1.0 0.0 4
bonds 1
harm 1 2 100.0 0.5
angles 1
harm 1 2 3 40.0 120.0
dihedrals 1
cos 1 2 3 4 7.0 30.0 1 0 0
finish
close
"""


def one_molecule(tmp_path: Path) -> Simulation:
    text = (
        "title t\ntimestep 1e-9 internal_t\ntime_run 1 steps\nensemble nve\ncutoff 1.0 ang\ntemperature 1.0 dpd_temp\n"
    )
    (tmp_path / "CONTROL").write_text(text)
    (tmp_path / "FIELD").write_text(MOLECULE)
    places = [[-0.6, 0.1, -1.3], [0.0, 0.0, -0.7], [0.3, 0.5, 0.1], [0.1, 1.2, 0.3]]
    body = "".join(f"A {k}\n{x} {y} {z}\n" for k, (x, y, z) in enumerate(places, 1))
    (tmp_path / "CONFIG").write_text(f"t\n0 1\n8 0 0\n0 8 0\n0 0 8\n{body}")
    return Simulation(load(tmp_path), seed=1)


def term_energy(p: np.ndarray, kind: str) -> float:
    if kind == "bond":
        return 50.0 * (np.linalg.norm(p[0] - p[1]) - 0.5) ** 2
    if kind == "angle":
        a, b = p[0] - p[1], p[2] - p[1]
        return 20.0 * (np.arccos(a @ b / np.linalg.norm(a) / np.linalg.norm(b)) - np.radians(120.0)) ** 2
    f, g, h = p[0] - p[1], p[1] - p[2], p[3] - p[2]
    a, b = np.cross(f, g), np.cross(h, g)
    angle = np.arctan2(-np.linalg.norm(g) * (f @ b), a @ b)
    return 7.0 * (1.0 + np.cos(angle - np.radians(30.0)))


def slopes(p: np.ndarray, kind: str) -> np.ndarray:
    forces = np.zeros_like(p)
    for place in np.ndindex(p.shape):
        up, down = p.copy(), p.copy()
        up[place] += 1e-6
        down[place] -= 1e-6
        forces[place] = (term_energy(down, kind) - term_energy(up, kind)) / 2e-6
    return forces


def test_bonded_terms_are_pairs_of_half_of_thirds_of_quarters(tmp_path: Path) -> None:
    """F_ij = (F_i − F_j)/n of every term, from slopes of its energy."""
    simulation = one_molecule(tmp_path)
    positions = simulation.state.positions
    expected = np.zeros((16, 3, 3))
    for beads, kind in (((0, 1), "bond"), ((0, 1, 2), "angle"), ((0, 1, 2, 3), "dihedral")):
        forces = slopes(positions[list(beads)], kind)
        for a, b in itertools.combinations(range(len(beads)), 2):
            d = positions[beads[a]] - positions[beads[b]]
            whole = symmetric(np.outer((forces[a] - forces[b]) / len(beads), d))
            share_line(expected, positions[beads[a], 2] / 8.0 + 0.5, d[2] / 8.0, whole)
    found = tensor(simulation.layer_sums(2, 16)[2])
    np.testing.assert_allclose(found, expected, rtol=0, atol=3e-3 * np.abs(expected).max())
    whole = simulation.observe().stress_parts["bonded"] * simulation.observe().volume
    np.testing.assert_allclose(found.sum(axis=0), symmetric(whole), atol=1e-10 * np.abs(whole).max())


def test_an_ideal_gas_is_flat() -> None:
    """p = ρ k_B T in every layer and along every axis: 4000 beads in 8 layers of 40 independent draws, error 1.0 %."""
    scene = make_scene(
        {"A": 4000}, (), cell=10.0, control={**NVE, "temperature": "1.5 dpd_temp", "timestep": "0.5 internal_t"}
    )
    simulation = Simulation(scene, seed=4)
    profile = StressProfile(simulation, layers=8, every=5)
    simulation.reporters.append(profile)
    simulation.run(200)
    assert profile.samples == 40
    # Each velocity is conserved: along one axis a layer's beads change all the time, their number's spread is 4.5 %.
    diagonal = np.diagonal(profile.stress(), axis1=1, axis2=2)
    np.testing.assert_allclose(diagonal.mean(axis=0), np.trace(simulation.observe().stress) / 3.0, rtol=0.04)
    per_bead = diagonal / profile.densities()
    np.testing.assert_allclose(per_bead, 1.5, rtol=0.08)
    normal, lateral = profile.normal_and_lateral()
    np.testing.assert_allclose(normal, diagonal[:, 2])
    np.testing.assert_allclose(lateral, diagonal[:, :2].mean(axis=1))
    layers, cell = profile.surface_tension().value, profile.surface_tension_of_the_cell().value
    assert layers == pytest.approx(cell, rel=1e-9)  # the momenta of the beads never change
    assert abs(layers) < 3.5 * 5.0 * 4.5 * np.sqrt(3.0 / 4000.0)  # L/2 times the spread of p_N − p_T
    np.testing.assert_allclose(profile.heights(), np.arange(8) * 1.25 - 4.375)


@pytest.mark.slow
def test_water_has_the_bulk_pressure_in_every_layer() -> None:
    """ρ = 3, A = 25: P = 23.65 (less drag and noise, which average 0) in all 12 layers and along all axes."""
    scene = make_scene({"A": 1536}, WATER, cell=8.0, control={"timestep": "0.02 internal_t"})
    simulation = Simulation(scene, seed=6)
    simulation.run(500)
    profile = StressProfile(simulation, layers=12, every=10)
    simulation.reporters.append(profile)
    simulation.run(6000)
    diagonal = np.diagonal(profile.stress(), axis1=1, axis2=2)
    errors = np.diagonal(profile.stress_errors(), axis1=1, axis2=2)
    assert errors.max() < 0.25
    assert np.abs((diagonal - 23.65) / errors).max() < 4.5  # of 36 numbers, with errors from few blocks
    off = profile.stress()[:, [0, 0, 1], [1, 2, 2]]
    assert np.abs(off).max() < 4.5 * profile.stress_errors()[:, [0, 0, 1], [1, 2, 2]].max()


@pytest.mark.slow
def test_two_phases_have_one_normal_pressure_and_one_tension() -> None:
    """A | B with a_AB = 40: p_N is the same in all layers (mechanical equilibrium), γ agrees by both ways."""
    rng = np.random.default_rng(8)
    places = (rng.random((2400, 3)) - 0.5) * np.array([7.0, 7.0, 16.4])
    places = places[np.argsort(np.abs(places[:, 2]))]
    pairs = (*WATER, "A B dpd 40.0 1.0 4.5", "B B dpd 25.0 1.0 4.5")
    scene = make_scene({"A": 1200, "B": 1200}, pairs, cell=[7.0, 7.0, 16.4], positions=places,
                       control={"timestep": "0.04 internal_t"})  # fmt: skip
    simulation = Simulation(scene, seed=9)
    simulation.run(1000)
    profile = StressProfile(simulation, layers=41, every=10)
    simulation.reporters.append(profile)
    simulation.run(12_000)
    layers, cell = profile.surface_tension(), profile.surface_tension_of_the_cell()
    # Groot and Warren (1997): 0.75 ρ χ^0.26 (1 − 2.36/χ)^1.5 = 0.99 with χ = 0.286 · 15; their fit is good to a tenth.
    assert layers.value == pytest.approx(0.99, abs=0.12)
    assert max(layers.error, cell.error) < 0.1
    assert abs(layers.value - cell.value) < 4.0 * np.hypot(layers.error, cell.error)
    normal, lateral = profile.normal_and_lateral()
    error = profile.stress_errors()[:, 2, 2]
    assert np.abs((normal - normal.mean()) / error).max() < 4.5
    assert np.ptp(normal) < 0.6
    dip = int(np.argmin(lateral))  # at one of the interfaces, which are at ±4.1 as half of the beads are inside
    assert np.ptp(lateral) > 0.6
    assert abs(abs(profile.heights()[dip]) - 4.1) < 0.8
    densities = profile.densities()
    assert densities[20, 0] > 2.5 > 0.5 > densities[20, 1]


# --- runs, files, refusals --------------------------------------------------------------------------------------------

PROFILED = {"stress_profile_frequency": "4 steps", "stress_profile_binsize": "0.5 dpd_l", "time_run": "40 steps"}


def test_a_run_writes_columns_that_numpy_reads(tmp_path: Path) -> None:
    scene = load(run_folder(tmp_path / "in", PROFILED))
    assert scene.output.profile == ProfilePlan(4, "z", 8, 2, "STRPRF")
    assert "STRPRF: every 4 steps, stress in 8 layers along z" in " ".join(scene.explain().split())
    result = run_scene(scene, tmp_path / "out", seed=1)
    text = (tmp_path / "out" / "STRPRF").read_text()
    table = np.loadtxt(tmp_path / "out" / "STRPRF")
    names = text.splitlines()[3].split()[1:]
    assert table.shape == (8, len(names)) == (8, 5 + 18 + 2)
    np.testing.assert_allclose(table[:, 0], np.arange(8) * 0.5 - 1.75)
    profile = next(r for r in result.simulation.reporters if isinstance(r, StressProfile))
    np.testing.assert_allclose(
        table[:, names.index("conservative_zz")], profile.stress("conservative")[:, 2, 2], rtol=1e-9
    )
    assert profile.samples == 10
    assert "surface tension in reduced" in text
    assert "tension, layers" in (tmp_path / "out" / "OUTPUT").read_text()


def test_a_run_that_continues_has_the_same_profile(tmp_path: Path) -> None:
    scene = load(run_folder(tmp_path / "in", PROFILED))
    run_scene(scene, tmp_path / "one", seed=1, threads=2)
    run_scene(scene, tmp_path / "two", seed=1, steps=22, threads=1)
    run_scene(scene, tmp_path / "two", checkpoint=tmp_path / "two" / "REVIVE", threads=2)
    assert (tmp_path / "one" / "STRPRF").read_bytes() == (tmp_path / "two" / "STRPRF").read_bytes()
    other = load(
        run_folder(tmp_path / "other", {**PROFILED, "stress_profile_binsize": "1 dpd_l", "time_run": "60 steps"})
    )
    with pytest.raises(InputError, match="the checkpoint holds a stress profile that cannot go on"):
        run_scene(other, tmp_path / "two", checkpoint=tmp_path / "two" / "REVIVE")


def test_sampling_changes_nothing_in_the_run() -> None:
    plain, watched = (Simulation(load(example_folder("lipid")), seed=5, threads=2) for _ in range(2))
    watched.reporters.append(StressProfile(watched, every=3))
    plain.run(20)
    watched.run(20)
    for name in ("positions", "velocities", "forces"):
        np.testing.assert_array_equal(getattr(plain.state, name), getattr(watched.state, name))


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"stress_profile_interfaces": "0"}, "stress_profile_interfaces.*at least one interface"),
        ({"stress_profile_binsize": "0 dpd_l"}, "stress_profile_binsize.*a thickness larger than 0"),
        ({"stress_profile_binsize": "1e-9 dpd_l"}, "stress_profile_binsize.*at most 1000000 are kept"),
        ({"stress_profile_axis": "w"}, "stress_profile_axis"),
    ],
)
def test_what_cannot_be_sampled_is_refused_by_name(tmp_path: Path, settings: dict[str, str], told: str) -> None:
    with pytest.raises((SceneError, InputError), match=told):
        load(run_folder(tmp_path / "in", {**PROFILED, **settings}))


def test_cells_without_layers_are_refused() -> None:
    control = {"stress_profile_frequency": "1 steps"}
    tilted = [[5.0, 0.0, 0.0], [0.0, 5.0, 0.0], [1.0, 0.0, 5.0]]
    with pytest.raises(SceneError, match=r"stress_profile_axis.*needs a cell vector along z that is perpendicular"):
        make_scene({"A": 10}, WATER, cell=tilted, control=control)
    with pytest.raises(SceneError, match="needs a cell that is periodic along z"):
        make_scene({"A": 10}, WATER, cell=5.0, imcon=6, control=control)
    simulation = Simulation(make_scene({"A": 10}, WATER, cell=tilted), seed=1)
    with pytest.raises(ValueError, match="perpendicular to the other two"):
        simulation.layer_sums(2, 4)
    with pytest.raises(SceneError, match="perpendicular to the other two"):
        StressProfile(simulation)
    StressProfile(Simulation(replace(prism()), seed=1), axis="z")
    with pytest.raises(ValueError, match="1 or more"):
        StressProfile(simulation, layers=0)


OTHERS = {
    "charges": (
        {"A": 4, "B": 4},
        {"charges": {"A": 1.0, "B": -1.0}},
        {"coul_method": "pairwise", "cutoff": "2.0 ang", "coul_bjerrum_length": "1.3 ang"},
        "the stress of charges is not resolved in layers",
    ),
    "shear": ({"A": 20}, {}, {"shear_rate": "0.1 dpd_t^-1"}, "in a sheared cell momenta belong to the flow"),
}


@pytest.mark.parametrize("name", OTHERS)
def test_stress_that_belongs_to_no_layer_is_refused(name: str) -> None:
    beads, options, control, told = OTHERS[name]
    pairs = (*WATER, "A B dpd 25.0 1.0 4.5", "B B dpd 25.0 1.0 4.5")[: 1 if len(beads) == 1 else 3]
    with pytest.raises(SceneError, match=f"stress_profile_frequency.*{told}"):
        make_scene(beads, pairs, cell=5.0, control={**control, "stress_profile_frequency": "5 steps"}, **options)  # type: ignore[arg-type]
    simulation = Simulation(make_scene(beads, pairs, cell=5.0, control=control, **options), seed=1)  # type: ignore[arg-type]
    with pytest.raises(SceneError, match=told):
        StressProfile(simulation)
    if name == "shear":
        correlations = StressCorrelations(simulation)
        simulation.reporters.append(correlations)
        simulation.run(5)
        assert (correlations.samples, correlations.viscosity()) == (5, None)


def test_fixed_distances_are_refused(tmp_path: Path) -> None:
    (tmp_path / "CONTROL").write_text(
        "title t\ntimestep 0.01 internal_t\ntime_run 1 steps\nensemble nve\ncutoff 1.0 ang\ntemperature 1.0 dpd_temp\n"
        "stress_profile_frequency 2 steps\n"
    )
    molecule = (
        "chain\nunits dpd\nmolecules 1\nT\nnummols 1\natoms 2\nA 1.0 0.0 2\nconstraints 1\n1 2 0.5\nfinish\nclose\n"
    )
    (tmp_path / "FIELD").write_text(molecule)
    (tmp_path / "CONFIG").write_text("t\n0 1\n8 0 0\n0 8 0\n0 0 8\nA 1\n0 0 0\nA 2\n0.5 0 0\n")
    with pytest.raises(SceneError, match=r"stress_profile_frequency.*not modelled with constraints"):
        load(tmp_path)
