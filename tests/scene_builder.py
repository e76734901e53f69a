"""Builds small scenes for tests: a CONTROL and a FIELD text with a configuration from arrays, through the readers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import ArrayLike

from pydlpoly import Scene, load
from pydlpoly.formats.records import Configuration, FloatArray

DPD_WATER = ("A A dpd 25.0 1.0 4.5",)

_CONTROL = {
    "title": "test scene",
    "temperature": "1.0 dpd_temp",
    "ensemble": "nvt",
    "ensemble_method": "dpd",
    "ensemble_dpd_order": "mdvv",
    "time_run": "1000 steps",
    "timestep": "0.01 internal_t",
    "cutoff": "1.0 ang",
    "vdw_method": "direct",
    "coul_method": "off",
}
NVE = {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None}


def random_positions(count: int, cell: ArrayLike, seed: int) -> FloatArray:
    """(count, 3) independent uniform positions in a cell around the origin."""
    box = cell_of(cell)
    return np.asarray((np.random.default_rng(seed).random((count, 3)) - 0.5) @ box)


def cell_of(cell: ArrayLike) -> FloatArray:
    """(3, 3) cell vectors by row, from an edge, three edges or the vectors themselves."""
    given = np.asarray(cell, dtype=np.float64)
    return np.asarray(given if given.ndim == 2 else np.diag(np.broadcast_to(given, 3)))


def field_text(
    beads: Mapping[str, int],
    pairs: Sequence[str],
    *,
    masses: Mapping[str, float] | None = None,
    charges: Mapping[str, float] | None = None,
    frozen: Sequence[str] = (),
    extern: str = "",
    units: str = "dpd",
    extensions: str = "",
) -> str:
    """FIELD with one molecule type of single beads for every species."""
    lines = ["test field", f"units {units}", f"molecules {len(beads)}"]
    for name, count in beads.items():
        mass, charge = (masses or {}).get(name, 1.0), (charges or {}).get(name, 0.0)
        lines += [f"{name}_beads", f"nummols {count}", "atoms 1", f"{name} {mass!r} {charge!r} 1 {int(name in frozen)}"]
        lines += ["finish"]
    lines += [f"vdw {len(pairs)}", *pairs] if pairs else []
    lines += ["extern", extern] if extern else []
    return "\n".join([*lines, "close", extensions])


def make_scene(
    beads: Mapping[str, int],
    pairs: Sequence[str] = DPD_WATER,
    *,
    cell: ArrayLike,
    imcon: int | None = None,
    positions: ArrayLike | None = None,
    velocities: ArrayLike | None = None,
    control: Mapping[str, str | None] | None = None,
    masses: Mapping[str, float] | None = None,
    charges: Mapping[str, float] | None = None,
    frozen: Sequence[str] = (),
    extern: str = "",
    units: str = "dpd",
    extensions: str = "",
    start_seed: int = 1,
) -> Scene:
    """Return the scene of these inputs, by default DPD at k_B T = 1 in reduced units.

    Args:
        beads: number of beads of each species, in the order of the configuration.
        pairs: lines of FIELD's ``vdw`` block.
        cell: an edge, three edges or the (3, 3) cell vectors; ``imcon`` is 2 for edges and 3 for vectors.
        positions: (N, 3); by default independent uniform ones, from ``start_seed``.
        velocities: (N, 3); given ones are kept as they are (``restart noscale``).
        control: settings that replace or, with None, remove the default ones.
        masses, charges, frozen, extern, units, extensions: as in ``field_text``; the last is text after ``close``.
    """
    box = cell_of(cell)
    count = sum(beads.values())
    places = random_positions(count, box, start_seed) if positions is None else np.asarray(positions, dtype=np.float64)
    configuration = Configuration(
        names=tuple(name for name, number in beads.items() for _ in range(number)),
        positions=places.reshape(count, 3),
        title="test configuration",
        imcon=imcon if imcon is not None else 3 if np.ndim(cell) == 2 else 2,
        cell=box,
        velocities=None if velocities is None else np.asarray(velocities, dtype=np.float64).reshape(count, 3),
    )
    start = {} if velocities is None else {"restart": "noscale"}
    settings: dict[str, str | None] = {**_CONTROL, **start, **(control or {})}
    lines = [f"{keyword} {value}" for keyword, value in settings.items() if value is not None]
    with TemporaryDirectory() as folder:
        (Path(folder) / "CONTROL").write_text("\n".join([*lines, ""]))
        field = field_text(
            beads,
            pairs,
            masses=masses,
            charges=charges,
            frozen=frozen,
            extern=extern,
            units=units,
            extensions=extensions,
        )
        (Path(folder) / "FIELD").write_text(field)
        return load(folder, config=configuration)
