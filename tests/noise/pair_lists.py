"""Writes pair lists for ``stream``: ``python tests/noise/pair_lists.py fluid|cycles FILE``; docs/noise.md says why.

``fluid``: the pairs in range of a DPD fluid of 3000 beads at density 3, in 200 consecutive steps, each bead with its
partners in the order of the cells. ``cycles``: 20 000 closed walks i-j-k-l-i over random beads, whose four sums of bead
words are tied together: the first and third sum make the second and fourth.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pydlpoly import Simulation
from pydlpoly.formats.from_python import control_from_mapping, single_bead_field
from pydlpoly.formats.records import Configuration
from pydlpoly.scene.resolve import resolve

BEADS, EDGE, STEPS, CYCLES = 3000, 10.0, 200, 20_000


def fluid() -> list[NDArray[np.uint32]]:
    """Pair lists, (pairs, 2) each, of consecutive steps of a fluid."""
    settings = {
        "ensemble": "nvt",
        "ensemble_method": "dpd",
        "ensemble_dpd_order": "mdvv",
        "temperature": "1 dpd_temp",
        "time_run": "1000 steps",
        "timestep": "0.02 dpd_t",
        "cutoff": "1 dpd_l",
    }
    positions = EDGE * (np.random.default_rng(1).random((BEADS, 3)) - 0.5)
    pairs = {("W", "W"): ("dpd", 25.0, 1.0, 4.5)}
    field = single_bead_field(np.full(BEADS, "W"), np.ones(BEADS), np.zeros(BEADS), pairs, "dpd")
    config = Configuration(("W",) * BEADS, positions, imcon=1, cell=EDGE * np.eye(3))
    simulation = Simulation(resolve(control_from_mapping(settings), field, config), seed=1)
    simulation.run(500)
    lists = []
    for _ in range(STEPS):
        simulation.run(1)
        lists.append(in_range(simulation.state.positions))
    return lists


def in_range(positions: NDArray[np.float64]) -> NDArray[np.uint32]:
    """(pairs, 2) ids of the beads closer than 1, ordered by the cell of the first and then of the second."""
    cell = np.floor(positions + 0.5 * EDGE).astype(int) % int(EDGE)
    order = np.lexsort(cell.T)
    placed = positions[order]
    found = []
    for k in range(len(order) - 1):
        apart = placed[k + 1 :] - placed[k]
        apart -= EDGE * np.round(apart / EDGE)
        near = np.nonzero(np.einsum("ij,ij->i", apart, apart) < 1.0)[0] + k + 1
        found.append(np.column_stack([np.full(len(near), order[k]), order[near]]))
    return np.concatenate(found).astype(np.uint32)


def cycles() -> list[NDArray[np.uint32]]:
    """One list of the pairs of closed walks over four beads."""
    beads = np.array([np.random.default_rng(k).permutation(BEADS)[:4] for k in range(CYCLES)])
    walks = np.stack([beads, np.roll(beads, -1, axis=1)], axis=2)
    return [walks.reshape(-1, 2).astype(np.uint32)]


def main() -> int:
    """Write the file that the command line names; the return value is the exit code."""
    makers = {"fluid": fluid, "cycles": cycles}
    if len(sys.argv) != 3 or sys.argv[1] not in makers:
        print(__doc__, file=sys.stderr)
        return 2
    with Path(sys.argv[2]).open("wb") as file:
        for pairs in makers[sys.argv[1]]():
            file.write(np.uint64(len(pairs)).tobytes() + pairs.tobytes())
    return 0


if __name__ == "__main__":
    sys.exit(main())
