"""The scenes of the benchmarks, built in memory from records; beads are placed with a fixed seed.

All are in reduced units (k_B T = 1, mass 1). This file is also run by other builds of pydlpoly that are compared with
this one: it uses the readers' records and ``pydlpoly.scene.resolve`` only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import partial
from typing import Any

import numpy as np

from pydlpoly.errors import InputError, SceneError, suggest
from pydlpoly.formats.from_python import control_from_mapping, pair_lines
from pydlpoly.formats.records import (
    AtomLine,
    BondedLine,
    Configuration,
    Field,
    FloatArray,
    Molecule,
    MoleculeBlock,
)
from pydlpoly.scene.model import Scene
from pydlpoly.scene.resolve import resolve

_SEED = 20240229
_CONTROL = {
    "ensemble": "nvt",
    "ensemble_method": "dpd",
    "ensemble_dpd_order": "mdvv",
    "temperature": "1 dpd_temp",
    "timestep": "0.01 dpd_t",
    "time_run": "1000000 steps",
    "vdw_method": "direct",
}
_NVE = {"ensemble": "nve"}
_WATER = {("W", "W"): ("dpd", 25.0, 1.0, 4.5)}


@dataclass(frozen=True)
class BenchScene:
    """A scene by name.

    Attributes:
        about: what it is, in one line.
        build: makes it; raises SceneError when pydlpoly does not model a part of it.
        equilibration: number of steps to take before anything is timed.
        beads: number of beads.
        large: left out unless it is asked for by name or with ``--large``.
    """

    name: str
    about: str
    build: Callable[[], Scene]
    equilibration: int
    beads: int
    large: bool = False


def single_beads(
    name: str,
    counts: Mapping[str, int],
    pairs: Mapping[tuple[str, str], Any],
    cell: FloatArray,
    *,
    cutoff: float = 1.0,
    positions: FloatArray | None = None,
    control: Mapping[str, str | None] | None = None,
    extensions: Any = (),
) -> Scene:
    """Return a fluid of beads that are not bound to each other, at random places when ``positions`` is None."""
    molecules = tuple(Molecule(kind, count, (AtomLine(kind, 1.0),)) for kind, count in counts.items())
    names = tuple(kind for kind, count in counts.items() for _ in range(count))
    places = random_places(len(names), cell) if positions is None else positions
    return make(name, molecules, names, places, pairs, cell, cutoff=cutoff, control=control, extensions=extensions)


def make(
    name: str,
    molecules: tuple[Molecule, ...],
    names: tuple[str, ...],
    positions: FloatArray,
    pairs: Mapping[tuple[str, str], Any],
    cell: FloatArray,
    *,
    cutoff: float = 1.0,
    control: Mapping[str, str | None] | None = None,
    extensions: Any = (),
) -> Scene:
    """Return the scene of these molecules and places. Raises SceneError for what is not modelled."""
    settings = {"title": name, **_CONTROL, "cutoff": f"{cutoff} dpd_l", **(control or {})}
    if settings["ensemble"] == "nve":
        settings.update(ensemble_method=None, ensemble_dpd_order=None)
    record = control_from_mapping({keyword: value for keyword, value in settings.items() if value is not None})
    more = {"extensions": extensions} if extensions else {}  # other builds' records have no such field
    field = Field(name, "dpd", molecules, pair_lines(pairs), **more)
    imcon = 3 if np.any(cell != np.diag(np.diag(cell))) else 2
    return resolve(record, field, Configuration(names, positions, title=name, imcon=imcon, cell=cell))


def cube(beads: int, density: float) -> FloatArray:
    """(3, 3) cubic cell of this number density."""
    return np.asarray((beads / density) ** (1.0 / 3.0) * np.eye(3))


def random_places(count: int, cell: FloatArray) -> FloatArray:
    """(count, 3) uniform places in the cell around the origin; soft beads may overlap."""
    return np.asarray((np.random.default_rng(_SEED).random((count, 3)) - 0.5) @ cell)


def water(beads: int) -> Scene:
    """DPD water of Groot and Warren: ρ = 3, a = 25, γ = 4.5."""
    return single_beads("DPD water", {"W": beads}, _WATER, cube(beads, 3.0))


def tilted_water(beads: int) -> Scene:
    """The same in a triclinic cell."""
    cell = np.array([[1.0, 0.0, 0.0], [0.3, 1.0, 0.0], [-0.2, 0.25, 1.0]])
    return single_beads("DPD water, triclinic", {"W": beads}, _WATER, cube(beads, 3.0)[0, 0] * cell)


def gas(beads: int) -> Scene:
    """Water's beads at a thirtieth of the density: few pairs, many empty cells."""
    return single_beads("DPD gas", {"W": beads}, _WATER, cube(beads, 0.1))


def mixture(beads: int) -> Scene:
    """Two species with repulsions and drags of their own."""
    pairs = {
        ("A", "A"): ("dpd", 25.0, 1.0, 4.5),
        ("A", "B"): ("dpd", 35.0, 1.0, 9.0),
        ("B", "B"): ("dpd", 25.0, 1.0, 18.0),
    }
    return single_beads("binary DPD mixture", {"A": beads // 2, "B": beads - beads // 2}, pairs, cube(beads, 3.0))


def cutoffs(beads: int) -> Scene:
    """Two species with ranges of their own."""
    pairs = {
        ("A", "A"): ("dpd", 25.0, 1.0, 4.5),
        ("A", "B"): ("dpd", 25.0, 0.85, 4.5),
        ("B", "B"): ("dpd", 25.0, 0.7, 4.5),
    }
    return single_beads("DPD with unequal cutoffs", {"A": beads // 2, "B": beads - beads // 2}, pairs, cube(beads, 3.0))


_SPECIES = """\
species a b
pair W W a kappa 1.0 range 1.58 exponent 2.0 noise 1e-5
pair W W b kappa 3.0 range 1.58 exponent 2.0 noise 1e-5
noise lammps
start a 1.0
start b 1.0
source a 0.01 box * * 0 * * *
source a -0.01 box * * * 0 * *
source b -0.01 box * * 0 * * *
source b 0.01 box * * * 0 * *
"""


def dissolved_species() -> Scene:
    """LAMMPS's example of transport DPD (examples/PACKAGES/dpd-meso/tdpd): two species, fed in one half of the box."""
    from pydlpoly.formats.records import Extension  # other builds have none

    lines = tuple(enumerate(_SPECIES.splitlines(), 1))
    control = {"ensemble_dpd_exponent": "0.41"}
    return single_beads(
        "transport DPD",
        {"W": 16_000},
        {("W", "W"): ("dpd", 18.75, 1.58, 4.5)},
        np.diag([20.0, 20.0, 10.0]),
        cutoff=1.58,
        control=control,
        extensions=(Extension("transport", lines),),
    )


def lennard_jones(cells: int) -> Scene:
    """The usual Lennard-Jones liquid (r_c = 2.5 σ, ρ* = 0.8442, start at T* = 1.44) from a face-centred lattice."""
    edge = (4 * cells**3 / 0.8442) ** (1.0 / 3.0)
    corners = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    basis = np.array([[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]])
    positions = ((corners + basis).reshape(-1, 3) / cells - 0.5) * edge
    control = {**_NVE, "temperature": "1.44 dpd_temp", "timestep": "0.005 dpd_t", "vdw_long_range_correction": "off"}
    pairs = {("A", "A"): ("lj", 1.0, 1.0)}
    counts, cell = {"A": len(positions)}, edge * np.eye(3)
    return single_beads("Lennard-Jones liquid", counts, pairs, cell, cutoff=2.5, positions=positions, control=control)


def film() -> Scene:
    """LAMMPS's own example of many-body DPD: a film that contracts, with Lucy's kernel and λ = 1/2."""
    edges, extent, spacing = np.array([50.0, 20.0, 20.0]), np.array([20.0, 7.5, 2.0]), 0.5 * (4.0 / 6.0) ** (1.0 / 3.0)
    counts = (extent / spacing).astype(int)
    sites = np.stack(np.meshgrid(*(np.arange(-n, n + 1) for n in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    positions = spacing * sites[sites.sum(axis=1) % 2 == 0]  # a face-centred lattice of density 6
    pairs = {("L", "L"): ("mdpd", -40.0, 25.0, 1.0, 0.75, 18.0)}
    control = {"mdpd_kernel": "lucy"}
    return single_beads("film", {"L": len(positions)}, pairs, np.diag(edges), positions=positions, control=control)


def polymer_melt(chains: int, length: int = 20) -> Scene:
    """A melt of bead-spring chains at ρ = 3, placed as random walks."""
    bonds = MoleculeBlock("bonds", tuple(BondedLine("-hrm", (k, k + 1), (100.0, 0.7)) for k in range(1, length)))
    melt = Molecule("chain", chains, (AtomLine("P", 1.0, repeat=length),), (bonds,))
    cell = cube(chains * length, 3.0)
    rng = np.random.default_rng(_SEED)
    steps = rng.normal(size=(chains, length, 3))
    steps *= 0.7 / np.linalg.norm(steps, axis=2, keepdims=True)
    positions = (random_places(chains, cell)[:, None, :] + np.cumsum(steps, axis=1)).reshape(-1, 3)
    return make(
        "polymer melt", (melt,), ("P",) * len(positions), positions, {("P", "P"): ("dpd", 25.0, 1.0, 4.5)}, cell
    )


def lipids(side: int) -> Scene:
    """A bilayer of lipids with three head beads and two tails of four, in water, ρ = 3."""
    heads, tail = 3, 4
    length = heads + 2 * tail
    tails = [(heads + k * tail + 1, heads + (k + 1) * tail) for k in (0, 1)]
    links = [(k, k + 1) for k in range(1, heads)] + [(heads, first) for first, _ in tails]
    links += [(k, k + 1) for first, last in tails for k in range(first, last)]
    bends = [(a - 1 if a > first else heads, a, a + 1) for first, last in tails for a in range(first, last)]
    blocks = (
        MoleculeBlock("bonds", tuple(BondedLine("-hrm", pair, (128.0, 0.5)) for pair in links)),
        MoleculeBlock("angles", tuple(BondedLine("-hcs", three, (15.0, 180.0)) for three in bends)),
    )
    count = 2 * side * side
    edge = side * 0.75  # area of a lipid: 0.56
    water_beads = 3 * count * length
    height = (count * length + water_beads) / (3.0 * edge * edge)
    places = _bilayer(side, edge, heads, tail)
    cell = np.diag([edge, edge, height])
    free = random_places(water_beads, np.diag([edge, edge, height - 10.0]))
    free[:, 2] += np.where(free[:, 2] >= 0.0, 5.0, -5.0)
    atoms = (AtomLine("H", 1.0, repeat=heads), AtomLine("T", 1.0, repeat=2 * tail))
    molecules = (Molecule("lipid", count, atoms, blocks), Molecule("water", water_beads, (AtomLine("W", 1.0),)))
    names = (("H",) * heads + ("T",) * 2 * tail) * count + ("W",) * water_beads
    strength = {
        ("H", "H"): 30.0,
        ("H", "T"): 50.0,
        ("H", "W"): 30.0,
        ("T", "T"): 10.0,
        ("T", "W"): 75.0,
        ("W", "W"): 25.0,
    }
    pairs = {species: ("dpd", a, 1.0, 4.5) for species, a in strength.items()}
    return make("lipid bilayer in water", molecules, names, np.concatenate([places, free]), pairs, cell)


def _bilayer(side: int, edge: float, heads: int, tail: int) -> FloatArray:
    """Two leaves on a square lattice, heads outwards, beads 0.5 apart."""
    grid = (np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2) + 0.5) / side - 0.5
    depth = [0.5 * (tail + heads - 1 - k) + 0.25 for k in range(heads)]
    depth += [0.5 * (tail - 1 - k) + 0.25 for _ in (0, 1) for k in range(tail)]
    aside = [0.0] * heads + [-0.15] * tail + [0.15] * tail
    leaf = np.zeros((side * side, len(depth), 3))
    leaf[:, :, :2] = edge * grid[:, None, :]
    leaf[:, :, 0] += aside
    leaf[:, :, 2] = depth
    return np.concatenate([leaf, leaf * [1.0, 1.0, -1.0]]).reshape(-1, 3)


def _waters() -> list[BenchScene]:
    about = "DPD water, density 3, a = 25, drag 4.5"
    sizes = {"3k": 3000, "24k": 24_000, "192k": 192_000, "786k": 786_432, "10m": 10_000_000}
    return [
        BenchScene(f"water-{size}", about, partial(water, n), 500 if n < 500_000 else 200, n, n > 1_000_000)
        for size, n in sizes.items()
    ]


SCENES: dict[str, BenchScene] = {
    scene.name: scene
    for scene in (
        *_waters(),
        BenchScene("mixture", "two species of DPD beads with unlike drags", lambda: mixture(24_000), 500, 24_000),
        BenchScene("cutoffs", "two species of DPD beads with unlike cutoffs", lambda: cutoffs(24_000), 500, 24_000),
        BenchScene("triclinic", "DPD water in a triclinic cell", lambda: tilted_water(24_000), 300, 24_000),
        BenchScene("gas", "DPD beads at density 0.1", lambda: gas(24_000), 300, 24_000),
        BenchScene("lj", "Lennard-Jones liquid, cutoff 2.5, density 0.8442", lambda: lennard_jones(20), 500, 32_000),
        BenchScene("film", "LAMMPS's film of a many-body DPD liquid", film, 200, 14_333),
        BenchScene("species", "LAMMPS's example of transport DPD, two species", dissolved_species, 300, 16_000),
        BenchScene("polymer", "DPD chains of 20 beads", lambda: polymer_melt(1200), 500, 24_000),
        BenchScene("lipids", "bilayer of DPD lipids of 11 beads in water", lambda: lipids(20), 500, 35_200),
    )
}
"""Every scene by name, in the order in which they are run."""


def chosen(patterns: list[str], *, large: bool = False) -> list[BenchScene]:
    """Return the scenes that the names or patterns (``water*``) mean; all but the large ones when there are none.

    Raises:
        InputError: a name that is none.
    """
    if not patterns:
        return [scene for scene in SCENES.values() if large or not scene.large]
    found: dict[str, BenchScene] = {}
    for pattern in patterns:
        exact = pattern in SCENES
        fitting = [s for s in SCENES.values() if fnmatchcase(s.name, pattern) and (large or exact or not s.large)]
        if not fitting:
            known = ", ".join(SCENES)
            raise InputError(
                f"is no scene of the benchmarks; there are {known}{suggest(pattern, SCENES)}", word=pattern
            )
        found |= {scene.name: scene for scene in fitting}
    return list(found.values())


def build(scene: BenchScene) -> Scene | str:
    """Return the scene, or in words why pydlpoly cannot run it."""
    try:
        return scene.build()
    except SceneError as error:
        if "not modelled" not in error.message:
            raise
        return error.message
