"""The pair list between its builds: beads that cross faces, jump, race and rest, against lists made anew every time.

Positions that are set by hand go through the list that the running system has kept; a system made from the same state
has none. Both must agree to the bit.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from pydlpoly import Scene, Simulation, _core
from pydlpoly.formats.records import FloatArray

from .instruction_sets import printed_by_set
from .scene_builder import NVE, cell_of, make_scene

SKEWED = [[9.0, 0.0, 0.0], [3.1, 8.6, 0.0], [-2.4, 2.7, 9.2]]
LATTICE = 1.1 * (np.stack(np.meshgrid(*[np.arange(8)] * 3), axis=-1).reshape(-1, 3) - 3.5)
SHIFTED = LATTICE + np.array([2.2, -1.3, 0.4])  # so that beads lie on both sides of every face


def hard_table() -> _core.PairTable:
    """Two species, three laws of two kinds, and a drag that reaches less far than they do."""
    table = _core.PairTable(2)
    table.set_law(0, 0, "lj", [1.0, 1.0], 2.5)
    table.set_law(0, 1, "lj", [0.8, 0.95], 2.2)
    table.set_law(1, 1, "12-6", [3.0, 2.0], 2.0)
    for a, b in ((0, 0), (0, 1), (1, 1)):
        table.set_drag(a, b, 1.0, np.sqrt(2.0), 1.4)
    return table


def drag_only_table() -> _core.PairTable:
    """Species that do not act on each other at all beside some that only damp."""
    table = _core.PairTable(2)
    table.set_law(0, 0, "dpd", [25.0, 1.0], 1.0)
    table.set_drag(1, 1, 4.5, 3.0, 1.3)
    return table


def settings(**changes: float) -> _core.StepSettings:
    result = _core.StepSettings()
    result.timestep, result.thermal_energy, result.drag, result.seed = 0.004, 1.0, True, 5
    result.precision = _core.Precision.reference
    for name, value in changes.items():
        setattr(result, name, value)
    return result


def system(
    positions: FloatArray,
    velocities: FloatArray,
    cell: ArrayLike,
    table: Callable[[], _core.PairTable] = hard_table,
    periodic: tuple[bool, bool, bool] = (True, True, True),
    frozen: int = 0,
    **changes: float,
) -> _core.System:
    count = len(positions)
    return _core.System(
        cell_of(cell),
        periodic,
        positions,
        velocities,
        [1.0] * count,
        [k % 2 for k in range(count)],
        [k < frozen for k in range(count)],
        table(),
        settings(**changes),
    )


def forces_made_anew(
    kept: _core.System,
    cell: ArrayLike,
    table: Callable[[], _core.PairTable] = hard_table,
    periodic: tuple[bool, bool, bool] = (True, True, True),
    frozen: int = 0,
) -> tuple[FloatArray, float, FloatArray]:
    fresh = system(kept.positions, kept.velocities, cell, table, periodic, frozen)
    fresh.step = kept.step
    fresh.initialise()
    return fresh.forces, fresh.pair_energy, fresh.conservative_virial_tensor


CASES = {
    "cube": (10.0, hard_table, (True, True, True), 0),
    "skewed": (SKEWED, hard_table, (True, True, True), 0),
    "barely three ranges": (8.9, hard_table, (True, True, True), 0),
    "slab": (10.0, hard_table, (True, True, False), 0),
    "not periodic": (10.0, hard_table, (False, False, False), 0),
    "some frozen": (10.0, hard_table, (True, True, True), 200),
    "pairs that do nothing": (10.0, drag_only_table, (True, True, True), 0),
}


@pytest.mark.parametrize("name", CASES)
def test_a_kept_list_gives_the_forces_of_a_new_one(name: str) -> None:
    """Beads fast enough to cross faces in every few steps, and slow enough for lists to be kept for some."""
    cell, table, periodic, frozen = CASES[name]
    random = np.random.default_rng(11)
    velocities = 3.0 * random.standard_normal(LATTICE.shape)
    kept = system(SHIFTED, velocities, cell, table, periodic, frozen)
    kept.initialise()
    crossed = 0
    for _ in range(40):
        before = kept.images
        kept.run(1)
        crossed += int(np.abs(kept.images - before).sum())
        kept.initialise()  # with the velocities of the whole step, as the system made anew has them
        forces, energy, virial = forces_made_anew(kept, cell, table, periodic, frozen)
        assert kept.forces.tobytes() == forces.tobytes()
        assert kept.pair_energy == energy
        assert kept.conservative_virial_tensor.tobytes() == virial.tobytes()
    assert crossed > 20 or not any(periodic)


def test_positions_set_by_hand_go_through_the_list() -> None:
    """Small moves, moves by whole cells, exchanges of two beads and jumps across the cell."""
    random = np.random.default_rng(3)
    kept = system(LATTICE, np.zeros_like(LATTICE), SKEWED)
    kept.initialise()
    cell = cell_of(SKEWED)
    for attempt in range(30):
        places = LATTICE + 0.02 * random.standard_normal(LATTICE.shape)
        if attempt % 3 == 1:
            places[random.integers(len(places), size=40)] += random.integers(-2, 3, size=(40, 3)) @ cell
        if attempt % 3 == 2:
            a, b = random.choice(len(places), size=2, replace=False)
            places[[a, b]] = places[[b, a]]
        kept.positions = places
        kept.wrap()
        kept.initialise()
        forces, energy, _ = forces_made_anew(kept, SKEWED)
        assert kept.forces.tobytes() == forces.tobytes()
        assert kept.pair_energy == energy


def test_two_beads_that_meet_at_the_end_of_the_skin() -> None:
    """One pair on its way together and apart: no step may miss it, whichever skin was chosen."""
    for speed in (0.1, 1.0, 10.0, 30.0):
        places = np.array([[-6.0, 0.1, 0.2], [6.0, 0.0, 0.0]])
        velocities = np.array([[-speed, 0.0, 0.0], [speed, 0.0, 0.0]])
        kept = system(places, velocities, 20.0)
        kept.initialise()
        met = 0
        for _ in range(200):  # 1.6 times the speed: those of 10 and more cross the gap of 5.5
            kept.run(1)
            kept.initialise()
            forces, _, _ = forces_made_anew(kept, 20.0)
            assert kept.forces.tobytes() == forces.tobytes()
            met += int(bool(forces.any()))
        assert met > 0 or speed < 10.0


def test_excluded_pairs_stay_out_of_every_list() -> None:
    """Chains of a lattice row with and without their neighbours: a kept list and a new one leave out the same pairs."""
    velocities = 3.0 * np.random.default_rng(11).standard_normal(LATTICE.shape)
    chained = [(k, k + 1) for k in range(len(LATTICE) - 1) if (k + 1) % 8]

    def with_exclusions(positions: FloatArray, pairs: list[tuple[int, int]]) -> _core.System:
        made = system(positions, velocities, 10.0)
        made.set_bonded(_core.BondedTerms([False] * len(LATTICE), 1.0), pairs)
        made.initialise()
        return made

    kept, free = with_exclusions(SHIFTED, chained), with_exclusions(SHIFTED, [])
    assert kept.forces.tobytes() != free.forces.tobytes()
    for _ in range(20):
        kept.run(1)
        kept.initialise()
        fresh = system(kept.positions, kept.velocities, 10.0)
        fresh.set_bonded(_core.BondedTerms([False] * len(LATTICE), 1.0), chained)
        fresh.step = kept.step
        fresh.initialise()
        assert kept.forces.tobytes() == fresh.forces.tobytes()
        assert kept.pair_energy == fresh.pair_energy
    # A list that is there already is made anew.
    free.set_bonded(_core.BondedTerms([False] * len(LATTICE), 1.0), chained)
    free.initialise()
    assert free.forces.tobytes() == with_exclusions(SHIFTED, chained).forces.tobytes()


def test_skins_never_change_a_bit_over_a_long_run() -> None:
    """The skin follows the clock, so two runs of one scene choose differently; single steps are yet another rhythm."""

    def scene() -> Scene:
        lines = ["A A lj 1.0 1.0 1.0", "A B lj 0.7 1.1 1.0", "B B lj 1.2 0.95 2.0"]
        control: dict[str, str | None] = {"cutoff": "2.5 ang", "timestep": "0.004 internal_t"}
        return make_scene({"A": 300, "B": 212}, lines, cell=9.2, positions=LATTICE, control=control)

    first = Simulation(scene(), seed=9, threads=1)
    second = Simulation(scene(), seed=9, threads=2, cell_width=1.1)
    first.run(300)
    for _ in range(300):
        second.run(1)
    assert first.state.positions.tobytes() == second.state.positions.tobytes()
    assert first.state.velocities.tobytes() == second.state.velocities.tobytes()
    assert first.energy == second.energy


PROGRAM = """
import sys, hashlib, numpy as np
sys.path.append(sys.argv[1])  # the installed package comes first
from tests.test_verlet_list import CASES, LATTICE, SHIFTED, system
digest = hashlib.sha256()
for precision, exponent in (("reference", 2.0), ("double_precision", 2.0), ("double_precision", 0.41)):
    for cell, table, periodic, frozen in CASES.values():
        velocities = 3.0 * np.random.default_rng(11).standard_normal(LATTICE.shape)
        some = system(SHIFTED, velocities, cell, table, periodic, frozen)
        s = some.settings
        s.precision, s.weight_exponent = getattr(type(s.precision), precision), exponent
        some.settings = s
        if not some.plan().startswith("general"):
            continue
        some.run(25)
        for part in (some.positions, some.velocities, some.forces, some.drag_virial_tensor, some.noise_virial_tensor,
                     some.conservative_virial_tensor, np.array([some.pair_energy])):
            digest.update(part.tobytes())
print(digest.hexdigest())
"""


def test_every_instruction_set_gives_the_same_bits(tmp_path: Path) -> None:
    digests = printed_by_set(PROGRAM, tmp_path)
    assert len(set(digests.values())) == 1, digests


def test_constant_energy_is_kept_with_lists() -> None:
    """A list that missed pairs would show as a drift of the energy."""
    control = {**NVE, "cutoff": "2.5 ang", "timestep": "0.002 internal_t", "vdw_force_shift": "on"}
    scene = make_scene({"A": 512}, ["A A lj 1.0 1.0"], cell=9.2, positions=LATTICE, control=control)
    simulation = Simulation(scene, seed=4, threads=1)
    start = simulation.energy
    simulation.run(500)
    assert simulation.energy["pair"] != start["pair"]
    assert simulation.energy["total"] == pytest.approx(start["total"], abs=2e-3 * start["kinetic"])
