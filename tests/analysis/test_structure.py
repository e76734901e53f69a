"""Analyses of structure against closed forms: ideal gas, lattices, ideal chains, lamellae, clusters of known size."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import InputError
from pydlpoly.analysis import (
    BilayerThickness,
    BondAngles,
    BondLengths,
    ChainDimensions,
    ClusterSizes,
    DensityProfile,
    LamellarOrder,
    Molecules,
    OrientationalOrder,
    RadialDistribution,
    StructureFactor,
    analyse,
    frames_of_arrays,
    molecule_centres,
)
from pydlpoly.analysis.structure_factor import density_waves, lattice_vectors, wave_vectors

TRICLINIC = np.array([[9.0, 0.0, 0.0], [2.0, 8.0, 0.0], [-1.5, 1.0, 7.0]])


def gas(frames: int, beads: int, cell, seed: int = 1) -> np.ndarray:
    box = np.diag(np.broadcast_to(cell, 3)) if np.ndim(cell) < 2 else np.asarray(cell)
    return (np.random.default_rng(seed).random((frames, beads, 3)) - 0.5) @ box


def test_ideal_gas_has_g_of_one_and_an_honest_error() -> None:
    """χ² of all bins against 1 with the errors given; a bin at r holds 2πr²Δ N²/V pairs a frame."""
    names = ["A"] * 200 + ["B"] * 100
    frames = list(frames_of_arrays(gas(64, 300, TRICLINIC), TRICLINIC, species=names))
    found = RadialDistribution(bin_width=0.25).of(frames)
    assert found.pairs == (("A", "A"), ("A", "B"), ("B", "B"))
    far = found.r > 0.75
    pull = (found.g[:, far] - 1.0) / found.error[:, far]
    assert np.abs(found.g[:, far] - 1.0).max() < 0.1
    assert 0.3 < np.mean(pull**2) < 2.0
    volume = abs(np.linalg.det(TRICLINIC))
    sphere = 4.0 / 3.0 * np.pi * (found.r[-1] + 0.125) ** 3 / volume
    assert found.n[:, -1] == pytest.approx([199 * sphere, 100 * sphere, 99 * sphere], rel=0.02)
    assert found["B", "A"] is not None
    with pytest.raises(KeyError):
        found["A", "C"]


def test_simple_cubic_lattice_has_its_shells() -> None:
    """6 neighbours at 1, 12 at √2, 8 at √3, also with beads exactly on the cell's faces."""
    grid = np.stack(np.meshgrid(*[np.arange(6.0) - 3.0] * 3), axis=-1).reshape(-1, 3)
    found = RadialDistribution(bin_width=0.1).of(frames_of_arrays(grid + 0.0, 6.0))
    steps = np.diff(np.concatenate([[0.0], found.n[0]]))
    assert steps[9] + steps[10] == pytest.approx(6.0)  # 1 is on an edge
    assert (steps[14], steps[17]) == (pytest.approx(12.0), pytest.approx(8.0))
    assert np.cumsum(steps)[18] == pytest.approx(26.0)
    shells = 4.0 / 3.0 * np.pi * np.diff(np.append(found.r - 0.05, 3.0) ** 3)
    np.testing.assert_allclose(found.g[0] * shells * 215 / 6.0**3, steps, atol=1e-12)  # of N − 1 others, no self


def test_pairs_within_molecules_can_be_left_out() -> None:
    """Dumbbells at random: without their own bond there is no order."""
    rng = np.random.default_rng(3)
    centres = gas(40, 150, 8.0)
    arms = rng.normal(size=centres.shape)
    arms *= 0.25 / np.linalg.norm(arms, axis=2, keepdims=True)
    places = np.stack([centres - arms, centres + arms], axis=2).reshape(40, 300, 3)
    molecules = [Molecules("dumbbell", np.arange(300).reshape(150, 2))]
    frames = list(frames_of_arrays(places, 8.0))
    everything = RadialDistribution(bin_width=0.2).of(frames)
    between = RadialDistribution(bin_width=0.2, between=molecules).of(frames)
    shell = 4.0 / 3.0 * np.pi * (0.6**3 - 0.4**3) / 8.0**3  # which the bonds of 0.5 fill once more
    assert everything.g[0, 2] == pytest.approx(1.0 + 1.0 / (299 * shell), rel=0.05)
    assert np.abs(between.g[0, 2:] - 1.0).max() < 0.1
    middles = RadialDistribution(bin_width=0.5).of(molecule_centres(frames, molecules))
    assert middles.pairs == (("dumbbell", "dumbbell"),)
    assert np.abs(middles.g[0, 1:] - 1.0).max() < 0.1
    (first, *_) = molecule_centres(frames, molecules)
    apart = first.positions - centres[0]
    np.testing.assert_allclose(apart - 8.0 * np.round(apart / 8.0), 0.0, atol=1e-12)


def test_reach_beyond_half_the_cell_is_refused() -> None:
    frames = list(frames_of_arrays(gas(1, 10, 4.0), 4.0))
    with pytest.raises(InputError, match=r"to 2\.5 is asked for; this cell allows 2"):
        RadialDistribution(reach=2.5).of(frames)
    with pytest.raises(InputError, match="periodic along all vectors"):
        RadialDistribution().of(frames_of_arrays(gas(1, 10, 4.0)))
    with pytest.raises(InputError, match=r"'B': there are no beads of this species; there are A"):
        RadialDistribution([("A", "B")]).of(frames)
    with pytest.raises(InputError, match="no frames"):
        RadialDistribution().of([])


def test_one_bead_has_no_distances() -> None:
    alone = frames_of_arrays(np.zeros((1, 1, 3)), 4.0)
    with pytest.raises(InputError, match=r"^g\(r\) needs two beads$"):
        RadialDistribution().of(alone)


def test_density_profile_of_a_slab() -> None:
    """All beads between −1 and 1 of a height of 10: density N/(V/5) there, none elsewhere; any axis, any centre."""
    places = gas(20, 500, [4.0, 5.0, 2.0])
    found = DensityProfile(bins=20).of(frames_of_arrays(places, [4.0, 5.0, 10.0]))
    inside = np.abs(found.z) < 1.0
    assert found.density[0, ~inside].max() == 0.0
    assert found.density[0, inside] == pytest.approx(500 / 40.0, rel=0.1)
    assert np.sum(found["A"]) * 0.5 * 20.0 == pytest.approx(500)
    moved = places + np.array([0.0, 0.0, 4.8])
    again = DensityProfile(bins=20, centre="A", weight="mass").of(
        frames_of_arrays(moved, [4.0, 5.0, 10.0], masses=np.full(500, 3.0))
    )
    assert again.density[0, np.abs(again.z) > 1.5].max() == 0.0
    assert np.sum(again.density) * 10.0 == pytest.approx(1500)
    turned = DensityProfile("x", bins=20).of(frames_of_arrays(places[:, :, ::-1], [10.0, 5.0, 4.0]))
    np.testing.assert_allclose(turned.density, found.density)


def chains(copies: int, bonds: int, frames: int, cell: float, seed: int = 5) -> np.ndarray:
    """Freely jointed chains with bonds of length 1, folded back into a cell."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(frames, copies, bonds, 3))
    steps /= np.linalg.norm(steps, axis=-1, keepdims=True)
    starts = rng.random((frames, copies, 1, 3)) * cell
    places = np.concatenate([starts, starts + np.cumsum(steps, axis=2)], axis=2)
    return (places - cell * np.round(places / cell)).reshape(frames, -1, 3)


def test_ideal_chain() -> None:
    """⟨R²⟩ = N b² and ⟨R_g²⟩ = N b²/6 · (N + 2)/(N + 1) with N bonds; through the cell's faces."""
    bonds, copies = 20, 250
    molecules = [Molecules("chain", np.arange(copies * (bonds + 1)).reshape(copies, bonds + 1))]
    frames = frames_of_arrays(chains(copies, bonds, 32, 6.0), 6.0)
    found = ChainDimensions(molecules).of(frames)
    gyration = bonds / 6.0 * (bonds + 2) / (bonds + 1)
    assert found.end_to_end_squared_error[0] == pytest.approx(bonds * np.sqrt(2 / 3 / copies / 32), rel=0.5)
    assert abs(found.end_to_end_squared[0] - bonds) < 4 * found.end_to_end_squared_error[0]
    assert abs(found.gyration_squared[0] - gyration) < 4 * found.gyration_squared_error[0]
    assert found.gyration_squared_error[0] < 0.03 * gyration
    np.testing.assert_allclose(found.tensor[0], gyration / 3.0 * np.eye(3), atol=0.1)
    assert found.principal[0].sum() == pytest.approx(found.gyration_squared[0])
    # Random walks are far from spheres: κ² of long ones is 0.39 (Šolc 1971), ⟨λ⟩ ratios about 12 : 2.7 : 1.
    assert 0.3 < found.anisotropy[0] < 0.45
    assert 9.0 < found.principal[0, 0] / found.principal[0, 2] < 14.0


def test_shapes_of_a_rod_a_ring_and_a_tetrahedron() -> None:
    rod = np.array([[k, 0.0, 0.0] for k in (0, 1, 2, 3)])
    angles = np.arange(4) * np.pi / 2
    ring = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    ball = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
    places = np.concatenate([rod, ring, ball])
    types = [Molecules(name, 4 * k + np.arange(4)[None, :]) for k, name in enumerate(("rod", "ring", "ball"))]
    found = ChainDimensions(types).of(frames_of_arrays(places))
    assert found.gyration_squared == pytest.approx([1.25, 1.0, 3.0])
    assert found.anisotropy == pytest.approx([1.0, 0.25, 0.0], abs=1e-12)
    assert found.asphericity == pytest.approx([1.25, 0.25, 0.0], abs=1e-12)
    assert found.acylindricity == pytest.approx([0.0, 0.5, 0.0], abs=1e-12)
    heavy = ChainDimensions(types[:1]).of(frames_of_arrays(places, masses=[3.0, 1.0, 1.0, 1.0] + [1.0] * 8))
    assert heavy.gyration_squared[0] == pytest.approx((1 + 4 + 9) / 6 - 1.0)  # about the centre of mass at 1


def test_a_molecule_is_made_whole_along_its_bonds() -> None:
    """A comb whose beads in order are far apart: without its bonds the nearest images would be wrong."""
    straight = np.array([[0.0, 0.0, 0.0], [0.9, 0.0, 0.0], [1.8, 0.0, 0.0], [2.7, 0.0, 0.0], [-0.9, 0.0, 0.0]])
    folded = straight - 5.0 * np.round(straight / 5.0)
    (frame,) = frames_of_arrays(folded, 5.0)
    ids = np.arange(5)[None, :]
    wrong = Molecules("comb", ids).whole(frame)[0]
    right = Molecules("comb", ids, np.array([0, 0, 1, 2, 0])).whole(frame)[0]
    np.testing.assert_allclose(right, straight, atol=1e-12)
    assert not np.allclose(wrong, straight)


def test_ideal_gas_has_s_of_one() -> None:
    frames = frames_of_arrays(gas(64, 100, TRICLINIC), TRICLINIC)
    found = StructureFactor().of(frames)
    pull = (found.values - 1.0) / found.error
    assert np.abs(found.values - 1.0).max() < 0.2
    assert np.mean(pull**2) < 3.0
    shortest = min(np.linalg.norm(2 * np.pi * np.linalg.inv(TRICLINIC).T[k]) for k in range(3))
    assert found.q[0] >= shortest * (1 - 1e-9)


def test_structure_factor_of_a_lattice() -> None:
    """N at the vectors of the reciprocal lattice of the sites, 0 at all others; ± pairs count once."""
    grid = np.stack(np.meshgrid(*[np.arange(4.0)] * 3), axis=-1).reshape(-1, 3)
    found = StructureFactor(largest=2 * np.pi * 1.01, width=0.01, most=0).of(frames_of_arrays(grid, 4.0))
    at = np.isclose(found.q, 2 * np.pi)
    # 4, 0, 0 and the like are peaks; of the vectors as long only these exist beside them: none.
    assert found.values[at] == pytest.approx([64.0])
    assert found.vectors[at] == [3]
    assert np.abs(found.values[~at]).max() < 1e-20


def test_wave_vectors_of_a_triclinic_cell() -> None:
    """q·r = 2π n·s; half of ± pairs; planes of constant phase stand across the lamellar normal."""
    numbers = lattice_vectors(TRICLINIC, 3.0)
    (frame,) = frames_of_arrays(gas(1, 50, TRICLINIC), TRICLINIC)
    inside = frame.positions @ np.linalg.inv(TRICLINIC)
    waves = wave_vectors(numbers, TRICLINIC)
    np.testing.assert_allclose(frame.positions @ waves.T, 2 * np.pi * inside @ numbers.T, atol=1e-10)
    grid = np.stack(np.meshgrid(*[np.arange(-8, 9)] * 3), axis=-1).reshape(-1, 3)
    short = np.linalg.norm(wave_vectors(grid, TRICLINIC), axis=1) <= 3.0
    assert len(numbers) == (short.sum() - 1) / 2
    np.testing.assert_allclose(
        np.abs(np.exp(-1j * frame.positions @ waves.T).sum(axis=0)) ** 2 / 50,
        np.abs(density_waves(inside, numbers)) ** 2 / 50,
        atol=1e-9,
    )
    rng = np.random.default_rng(11)
    places = np.column_stack([rng.random((200, 2)), rng.integers(0, 2, 200) / 2.0]) @ TRICLINIC
    found = LamellarOrder("A").of(frames_of_arrays(places, TRICLINIC))
    normal = np.cross(TRICLINIC[0], TRICLINIC[1])
    assert abs(found.normal @ normal) == pytest.approx(np.linalg.norm(normal))
    assert found.period == pytest.approx(TRICLINIC[2] @ normal / np.linalg.norm(normal) / 2)
    assert found.order == pytest.approx(1.0)


def test_clusters_across_the_cell_boundary() -> None:
    """Two drops of 30 and 20 beads, the second across a corner, and 5 lone beads."""
    rng = np.random.default_rng(2)
    drops = [rng.random((30, 3)) * 1.5 - 3.0, rng.random((20, 3)) * 1.5 + 4.3]
    lone = np.array([[0.0, 0.0, z] for z in (-2.0, 0.0, 2.0)] + [[2.5, 0.0, 0.0], [0.0, 2.5, 0.0]])
    places = np.concatenate([*drops, lone])
    folded = places - 10.0 * np.round(places / 10.0)
    frames = list(frames_of_arrays(np.array([folded] * 5), 10.0, species=["A"] * 50 + ["B"] * 5))
    found = ClusterSizes(1.2).of(frames)
    assert found.sizes.tolist() == [1, 20, 30]
    assert found.frequency.tolist() == [5.0, 1.0, 1.0]
    assert (found.count, found.largest) == ((7.0, 0.0), (30.0, 0.0))
    assert found.weight_mean_size[0] == pytest.approx((5 + 400 + 900) / 55)
    assert ClusterSizes(1.2, species=["A"]).of(frames).count[0] == 2.0
    pairs = [Molecules("pair", np.arange(50).reshape(25, 2))]
    assert ClusterSizes(1.2, species=["A"], molecules=pairs).of(frames).sizes.tolist() == [10, 15]


@pytest.mark.parametrize("cell", [10.0, TRICLINIC])
def test_clusters_are_those_of_all_pairs(cell) -> None:
    """Against a union of all pairs of a periodic gas, by the nearest of 27 images."""
    places = gas(1, 120, cell, seed=9)
    (frame,) = frames_of_arrays(places, cell)
    apart = places[0][:, None] - places[0][None, :]
    shifts = np.stack(np.meshgrid(*[np.arange(-1, 2)] * 3), axis=-1).reshape(-1, 3) @ frame.cell
    near = (np.linalg.norm(apart[:, :, None] + shifts, axis=-1).min(axis=2)) <= 1.1
    group = np.arange(120)
    for _ in range(120):
        group = np.array([group[row].min() for row in near])
    labels = ClusterSizes(1.1).labels(frame)
    assert len(set(labels)) == len(set(group)) < 120
    assert all(len(set(group[labels == k])) == 1 for k in set(labels))


def test_orientational_order() -> None:
    """1 for parallel rods, whichever way they point; without order 0 along an axis, 1/√N as an eigenvalue."""
    rng = np.random.default_rng(4)
    count = 400
    rods = [Molecules("rod", np.arange(2 * count).reshape(count, 2))]

    def of(directions: np.ndarray):
        centres = gas(len(directions), count, 8.0)
        places = np.stack([centres, centres + 0.5 * directions], axis=2).reshape(len(directions), -1, 3)
        return OrientationalOrder(rods, axis=[0.0, 0.0, 2.0]).of(frames_of_arrays(places, 8.0))

    signs = rng.choice([-1.0, 1.0], size=(16, count, 1))
    parallel = of(signs * np.array([0.6, 0.0, 0.8]))
    assert parallel.order[0] == pytest.approx(1.0)
    assert abs(parallel.director @ [0.6, 0.0, 0.8]) == pytest.approx(1.0)
    assert parallel.along is not None
    assert parallel.along[0] == pytest.approx(1.5 * 0.64 - 0.5)
    random = rng.normal(size=(64, count, 3))
    found = of(random / np.linalg.norm(random, axis=2, keepdims=True))
    assert found.along is not None
    assert abs(found.along[0]) < 4 * found.along[1]
    assert found.along[1] == pytest.approx(np.sqrt(0.2 / count / 64), rel=0.5)
    assert 0.0 < found.order[0] < 3.0 / np.sqrt(count)


def test_lamellar_order() -> None:
    """1 for two planes along (1, 0, 1) of a cubic cell; a sine of density has its amplitude squared; a gas has 0."""
    rng = np.random.default_rng(6)
    u, v, layer = rng.random((8, 300)), rng.random((8, 300)), rng.integers(0, 2, (8, 300))
    planes = np.stack([u, v, 1.0 - u + 0.5 * layer], axis=2) * 9.0  # x + z = 0 or 1/2 of the period of (1, 0, 1)
    found = LamellarOrder("A").of(frames_of_arrays(planes, 9.0))
    assert found.squared_order[0] == pytest.approx(1.0)
    assert found.order == pytest.approx(1.0)
    assert found.period == pytest.approx(9.0 / np.sqrt(2) / 2)
    assert np.abs(found.normal) == pytest.approx([np.sqrt(0.5), 0.0, np.sqrt(0.5)])
    nothing = LamellarOrder("A").of(frames_of_arrays(gas(64, 300, 9.0), 9.0))
    assert abs(nothing.squared_order[0]) < 0.002


def test_bilayer_thickness() -> None:
    """Heads at ±2 of a middle that drifts across the boundary, tails between; the area is that of the cell."""
    rng = np.random.default_rng(8)
    frames, copies = 10, 200
    drift = np.linspace(0.0, 12.0, frames)[:, None]
    sign = np.where(np.arange(copies) % 2, 1.0, -1.0)
    heads = rng.normal(2.0, 0.1, (frames, copies)) * sign + drift
    tails = rng.uniform(0.0, 1.5, (frames, copies)) * sign + drift
    z = np.concatenate([heads, tails], axis=1)
    places = np.stack([rng.random(z.shape) * 6.0, rng.random(z.shape) * 5.0, z - 12.0 * np.round(z / 12.0)], axis=2)
    names = ["H"] * copies + ["T"] * copies
    found = BilayerThickness("H", "T").of(frames_of_arrays(places, [6.0, 5.0, 12.0], species=names))
    assert found.thickness[0] == pytest.approx(4.0, abs=0.02)
    assert found.area == (pytest.approx(30.0), pytest.approx(0.0))


def test_bonds_and_angles() -> None:
    """Uniform lengths from 1 to 2 across the boundary; an isotropic second bond has a density of sin θ/2."""
    rng = np.random.default_rng(10)
    count = 16000
    directions = rng.normal(size=(count, 2, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    lengths = rng.uniform(1.0, 2.0, (count, 1))
    middle = rng.random((count, 3)) * 9.0
    places = np.stack([middle + lengths * directions[:, 0], middle, middle + directions[:, 1]], axis=1).reshape(-1, 3)
    folded = places - 9.0 * np.floor(places / 9.0)
    ids = np.arange(3 * count).reshape(count, 3)
    lengths_of, angles_of = BondLengths({"a": ids[:, :2]}, bins=6, reach=3.0), BondAngles({"b": ids}, bins=18)
    assert analyse(frames_of_arrays(folded, 9.0), lengths_of, angles_of) == 1
    bonds, angles = lengths_of.result(), angles_of.result()
    assert bonds.density[0] == pytest.approx([0, 0, 1, 1, 0, 0], abs=0.05)
    assert bonds.mean[0] == pytest.approx(1.5, abs=0.02)
    assert bonds.spread[0] == pytest.approx(np.sqrt(1 / 12), abs=0.01)
    expected = 0.5 * np.sin(np.radians(angles.x[0])) * np.pi / 180.0
    np.testing.assert_allclose(angles.density[0], expected, atol=0.0009)
    assert angles.mean[0] == pytest.approx(90.0, abs=2.0)


def test_frames_of_arrays_refuse_what_does_not_fit() -> None:
    for given in ({"positions": np.zeros((4, 2))}, {"positions": np.zeros((4, 3)), "species": ["A"]}):
        with pytest.raises(InputError):
            list(frames_of_arrays(**given))
    with pytest.raises(InputError, match="first two, or none"):
        list(frames_of_arrays(np.zeros((4, 3)), 3.0, periodic=(True, False, False)))
    with pytest.raises(InputError, match="every 1 or more"):
        RadialDistribution().of([], every=0)
