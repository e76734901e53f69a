"""Frames with everything a trajectory can hold, for round trips."""

from __future__ import annotations

import numpy as np

from pydlpoly.formats.frame import Frame
from pydlpoly.trajectories.base import Links, Topology

NAMES = ("HEAD", "W", "Tail1234", "C+2")
MASSES = np.array([1.0 / 3.0, 72.1, 18.015400000000001, 1e-3])
CHARGES = np.array([-1.0, 0.1, 0.30000000000000004, 2.0])
CELLS = {
    0: np.diag([9.0, 8.0, 7.0]),
    1: np.diag([4.4, 4.4, 4.4]),
    2: np.diag([4.1, 5.2, 6.3]),
    3: np.array([[4.0, 0.0, 0.0], [0.7, 5.0, 0.0], [-0.5, 0.9, 6.0]]),
    6: np.array([[4.0, 0.0, 0.0], [0.5, 5.0, 0.0], [0.0, 0.0, 6.0]]),
}
TURNED = np.array([[4.0, 0.3, 0.1], [0.2, 5.0, 0.4], [0.5, 0.1, 6.0]])


def frames(
    count: int = 3, beads: int = 23, *, imcon: int = 3, level: int = 2, cell: np.ndarray | None = None, first: int = 0
) -> list[Frame]:
    """Frames of steps 10 first, 10 (first + 1), … of the same beads."""
    kinds = np.arange(beads) % len(NAMES)
    names = tuple(NAMES[k] for k in kinds)
    box = CELLS[imcon] if cell is None else cell
    return [_frame(10 * k, names, kinds, imcon, level, box) for k in range(first, first + count)]


def _frame(step: int, names: tuple[str, ...], kinds: np.ndarray, imcon: int, level: int, box: np.ndarray) -> Frame:
    beads = len(names)
    random = np.random.default_rng(5 + step)
    return Frame(
        names,
        np.arange(1, beads + 1),
        MASSES[kinds],
        CHARGES[kinds],
        np.full(beads, np.nan),
        (random.random((beads, 3)) - 0.5) @ box,
        random.normal(size=(beads, 3)) if level >= 1 else None,
        100.0 * random.normal(size=(beads, 3)) if level >= 2 else None,
        step=step,
        time=0.01 * step,
        timestep=0.01,
        level=level,
        imcon=imcon,
        cell=box,
        images=random.integers(-3, 4, (beads, 3)),
        arrays={"density": random.random(beads), "concentration_A": random.random(beads)},
    )


def topology(beads: int = 23) -> Topology:
    """Two beads a molecule, with a bond each, and one angle."""
    pairs = np.arange(beads // 2 * 2).reshape(-1, 2)
    return Topology(
        "frames of a test",
        molecules=np.arange(beads) // 2,
        links={
            "bond": Links(("HEAD-W", "Tail1234-C+2"), np.arange(len(pairs)) % 2, pairs),
            "angle": Links(("HEAD-W-Tail1234",), np.array([0]), np.array([[0, 1, 2]])),
        },
    )
