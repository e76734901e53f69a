"""Boxes of every shape and size, and where beads are in them."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from pydlpoly import Simulation
from pydlpoly.formats.records import FloatArray

from ..scene_builder import NVE, cell_of, make_scene, random_positions
from .framework import (
    MOMENTUM,
    PATHS,
    PRECISIONS,
    SEED,
    Cases,
    Seen,
    check_finite,
    images,
    momentum,
    on_path,
    refused,
    soft_forces,
    stopped,
)

CASES = Cases("geometry")

# Shapes: pair forces against sums over all images -----------------------------------------------------------------

SKEW = np.array([[4.0, 0.0, 0.0], [2.0, 3.5, 0.0], [-1.9, 1.7, 3.0]])
NEEDLE = np.array([[3.0, 0.0, 0.0], [2.9, 0.6, 0.0], [2.9, 0.55, 0.5]])
SHAPES: dict[str, tuple[ArrayLike, int]] = {
    "box of 1.5 cutoffs": (1.5, 30),
    "box of 0.7 cutoffs": (0.7, 10),
    "box of 0.3 cutoffs": (0.3, 4),
    "box of 0.1 cutoffs": (0.1, 2),
    "rod, 0.4 x 0.4 x 30": ((0.4, 0.4, 30.0), 40),
    "slab, 20 x 20 x 0.5": ((20.0, 20.0, 0.5), 200),
    "slab, 20 x 20 x 0.05": ((20.0, 20.0, 0.05), 60),
    "cell skewed by 60 degrees": (SKEW, 100),
    "cell of vectors 10 degrees apart": (NEEDLE, 20),
    "cell of left-handed vectors": (SKEW[[1, 0, 2]], 100),
}


def brute_force(shape: str, precision: str) -> Seen:
    """Energy and forces of a = 25 at nve, and nothing wrong after 20 steps."""
    cell, count = SHAPES[shape]
    box = cell_of(cell)
    positions = random_positions(count, box, 3)
    control = {**NVE, "precision": precision, "timestep": "0.001 internal_t"}
    scene = make_scene({"A": count}, cell=cell, positions=positions, control=control)
    simulation = Simulation(scene, seed=SEED, threads=2)
    energy, forces = soft_forces(positions, box, np.full((count, count), 25.0), np.ones((count, count)))
    assert abs(simulation.energy["pair"] - energy) < 1e-10 * energy
    error = np.abs(simulation.state.forces - forces).max() / np.abs(forces).max()
    before = simulation.energy["total"]
    simulation.run(20)
    check_finite(simulation)
    assert momentum(simulation) < 1e-9
    assert abs(simulation.energy["total"] - before) < 1e-2 * abs(before)
    return Seen("largest error of a force over the largest force:", float(error), 0.0, 1e-11)


for _shape in SHAPES:
    for _precision in PRECISIONS:
        CASES.add(f"{_shape}, {_precision}", partial(brute_force, _shape, _precision))


def noise_of_images(edge: float, precision: str) -> Seen:
    """The noise of one pair in a small box is that of independent images: its variance along an axis.

    From 4000 steps the standard error of a variance is below sqrt(2/4000) = 2.3 %.
    """
    positions = np.array([[0.31, 0.1, -0.2], [-0.13, 0.35, 0.3]]) * min(edge, 0.7)
    control = {"precision": precision, "timestep": "1.0 internal_t"}
    scene = make_scene(
        {"A": 2}, ["A A dpd 0.0 1.0 0.5"], cell=edge, positions=positions, velocities=np.zeros((2, 3)), control=control
    )
    simulation = Simulation(scene, seed=SEED, threads=1)
    system = simulation._engine.system
    found = []
    for step in range(4000):
        system.step = step
        system.initialise()
        found.append(system.forces[0])
    apart = positions[0] - positions[1] - images(cell_of(edge), 1.0)
    r = np.linalg.norm(apart, axis=1)
    weight = np.clip(1.0 - r, 0.0, None)
    expected = np.sum((weight / r)[:, None] ** 2 * apart**2, axis=0)  # 2 gamma k_B T = 1
    ratio = np.mean(np.square(found), axis=0) / expected
    return Seen("variance over that of independent images", float(ratio[np.argmax(np.abs(ratio - 1))]), 1.0, 0.1)


def narrow(edge: float) -> Simulation:
    return Simulation(make_scene({"A": 2}, ["A A dpd 0.0 1.0 0.5"], cell=edge, positions=np.zeros((2, 3))), seed=1)


for _edge in (1.5, 0.7, 0.45):
    for _precision in ("double", "reference"):
        CASES.add(
            f"noise of a pair in a box of {_edge:g} cutoffs, {_precision}",
            partial(noise_of_images, _edge, _precision),
        )
for _edge in (0.3, 0.15):
    CASES.add(
        f"noise of a pair in a box of {_edge:g} cutoffs", partial(refused, partial(narrow, _edge), "noise of their own")
    )


def without_volume(cell: ArrayLike) -> Simulation:
    return Simulation(make_scene({"A": 2}, cell=np.array(cell), positions=np.zeros((2, 3))), seed=1)


for _name, _cell, _words in (
    ("two equal cell vectors", [[4, 0, 0], [4, 0, 0], [0, 0, 4]], "the cell vectors .* span no volume"),
    ("an edge of 0", [4.0, 4.0, 0.0], "edges must be positive, not 4 4 0"),
    ("an edge of 1e10", [4.0, 4.0, 1e10], "beyond 1e.09"),
    ("cell vectors 1e-7 degrees apart", [[4, 0, 0], [4, 1e-13, 0], [0, 0, 4]], "span no volume"),
):
    CASES.add(_name, partial(refused, partial(without_volume, _cell), _words))

# Large boxes ------------------------------------------------------------------------------------------------------


def far_pair(edge: float, precision: str, drag: bool) -> Seen:
    """Two beads in a corner of a large box, and the same two at its middle: the same relative motion, and momentum 0.

    A corner at 5e5 leaves 1e-10 of a coordinate's digits; the difference of the velocities is compared with that.
    """
    apart = np.array([0.25, -0.125, 0.0625])
    corner = np.array([0.4375, -0.4375, 0.46875]) * edge
    found = []
    for centre in (np.zeros(3), corner):
        control = {"precision": precision, **({} if drag else NVE)}
        scene = make_scene(
            {"A": 2},
            cell=edge,
            positions=[centre + apart, centre - apart],
            velocities=[[-0.5, 0.25, 0.125], [0.5, -0.25, -0.125]],
            control=control,
        )
        simulation = Simulation(scene, seed=SEED, threads=1)
        forces = simulation.state.forces
        assert np.array_equal(forces[0], -forces[1])
        simulation.run(20)
        check_finite(simulation)
        assert momentum(simulation) < 1e-12
        found.append(np.concatenate([forces, simulation.state.velocities]))
    difference = np.abs(found[1] - found[0]).max() / np.abs(found[0]).max()
    return Seen("largest difference of forces and velocities:", float(difference), 0.0, 1e-6 if edge < 1e9 else 1e-4)


for _edge in (500.0, 2000.0, 1e6, 1e9):
    for _precision in PRECISIONS:
        for _drag in (False, True):
            CASES.add(
                f"two beads in the corner of a box of {_edge:g} cutoffs, {_precision}, {'mdvv' if _drag else 'nve'}",
                partial(far_pair, _edge, _precision, _drag),
            )


def across_a_large_box(precision: str) -> Seen:
    """Two beads on both sides of a face of a box of 1e6 cutoffs feel each other."""
    edge = 2.0**20
    positions = [[edge / 2 - 0.25, 0.0, 0.0], [-edge / 2 + 0.25, 0.0, 0.0]]
    control = {**NVE, "precision": precision}
    scene = make_scene({"A": 2}, cell=edge, positions=positions, velocities=np.zeros((2, 3)), control=control)
    simulation = Simulation(scene, seed=SEED, threads=1)
    return Seen("force", float(simulation.state.forces[1, 0]), 12.5, 1e-12)


def slow_in_a_long_box(precision: str) -> Seen:
    """A bead at 0.05 in a box of 500 cutoffs moves 5e-8 in a step of 1e-6: less than half a unit of 32 bits."""
    control = {**NVE, "precision": precision, "timestep": "1e-6 internal_t"}
    positions = [[10.0, 0.0, 0.0], [-10.0, 0.0, 0.0]]
    velocities = [[0.05, 0.0, 0.0], [-0.05, 0.0, 0.0]]
    scene = make_scene({"A": 2}, cell=500.0, positions=positions, velocities=velocities, control=control)
    simulation = Simulation(scene, seed=SEED, threads=1)
    simulation.run(1000)
    return Seen("distance over v t", float(simulation.displacements()[0, 0] / 5e-5), 1.0, 1e-3)


for _precision in PRECISIONS:
    CASES.add(f"a pair across the face of a box of 1e6 cutoffs, {_precision}", partial(across_a_large_box, _precision))
    CASES.add(
        f"velocity 0.05, timestep 1e-6, box of 500 cutoffs, {_precision}",
        partial(slow_in_a_long_box, _precision),
    )

# Outside of the box -----------------------------------------------------------------------------------------------


def outside(path: str, boxes: int, by_hand: bool) -> Seen:
    """Beads a number of boxes away are the same beads."""
    edge, count = 6.0, 375
    # Multiples of 2^-20 of the edge are exact also far outside.
    steps = np.random.default_rng(8).integers(-(2**19), 2**19, size=(count, 3))
    inside: FloatArray = steps * (edge / 2.0**20)
    shift = boxes * edge * np.random.default_rng(9).integers(-1, 2, size=(count, 3))
    scenes = [make_scene({"A": count}, cell=edge, positions=places) for places in (inside, inside + shift)]
    home = on_path(scenes[0], path)
    if by_hand:
        away = on_path(scenes[0], path)
        away.set_state(positions=inside + shift)
    else:
        away = on_path(scenes[1], path)
    error = np.abs(away.state.forces - home.state.forces).max() / np.abs(home.state.forces).max()
    if by_hand:
        assert np.abs(away.state.unwrapped - inside - shift).max() < 1e-9 * max(boxes, 1) * edge
    away.run(10)
    check_finite(away)
    assert np.abs(away.state.positions).max() <= edge / 2
    assert momentum(away) < MOMENTUM[path]
    return Seen("largest difference of a force over the largest force:", float(error), 0.0, 1e-12)


for _path in PATHS:
    CASES.add(f"beads 1000 boxes outside in the file, {_path}", partial(outside, _path, 1000, False))
    CASES.add(f"beads 1000 boxes outside by set_state, {_path}", partial(outside, _path, 1000, True))


def far_outside(distance: float) -> Simulation:
    scene = make_scene({"A": 2}, cell=6.0, positions=[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    simulation = Simulation(scene, seed=1, threads=1)
    try:
        simulation.set_state(positions=np.array([[0.0, 0.0, 0.0], [distance, 0.0, 0.0]]))
    finally:
        assert np.array_equal(simulation.state.positions, scene.beads.positions)
    return simulation


for _distance in (1e11, 1e300):
    CASES.add(
        f"set_state with a bead at {_distance:g}",
        partial(refused, partial(far_outside, _distance), r"bead 2 is 1e.* cells away|bead 2 is 1\.6.* cells away"),
    )
CASES.add("set_state with a bead at nan", partial(refused, partial(far_outside, np.nan), "positions must be finite"))


def far_in_file(distance: float) -> Simulation:
    scene = make_scene({"A": 2}, cell=6.0, positions=[[0.0, 0.0, 0.0], [distance, 0.0, 0.0]])
    return Simulation(scene, seed=1, threads=1)


for _distance in (1e18, 1e300):
    CASES.add(
        f"a bead at {_distance:g} in the file", partial(refused, partial(far_in_file, _distance), "bead 2|position")
    )


def open_box() -> Simulation:
    """Without periodic images beads may fly away for ever: 1e9 boxes are followed, and more is said."""
    scene = make_scene(
        {"A": 2},
        cell=6.0,
        imcon=0,
        positions=[[0.0, 2.0, 0.0], [0.0, -2.0, 0.0]],
        velocities=[[1e12, 0.0, 0.0], [-1e12, 0.0, 0.0]],
        control=NVE,
    )
    return Simulation(scene, seed=1, threads=1)


CASES.add(
    "open box, velocities 1e12",
    partial(stopped, open_box, 100, "bead 1 would move by 1e.10", latest=100),
)
