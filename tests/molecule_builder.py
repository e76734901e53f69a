"""Builds small scenes with molecules for tests: FIELD from blocks of lines, a configuration from arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import ArrayLike

from pydlpoly import Scene, load
from pydlpoly.formats.records import Configuration, FloatArray

from .scene_builder import cell_of

_CONTROL = {
    "title": "test molecules",
    "temperature": "1.0 dpd_temp",
    "ensemble": "nve",
    "time_run": "100 steps",
    "timestep": "0.01 internal_t",
    "cutoff": "1.0 ang",
    "vdw_method": "direct",
    "coul_method": "off",
}
Blocks = Mapping[str, Sequence[str]]


def molecule_text(
    names: Sequence[str],
    blocks: Blocks,
    copies: int = 1,
    frozen: Sequence[int] = (),
    masses: Mapping[str, float] | None = None,
    charges: Sequence[float] = (),
) -> str:
    """One molecule type of FIELD: beads by name, of mass 1 unless given, and the lines of its blocks."""
    lines = ["chain", f"nummols {copies}", f"atoms {len(names)}"]
    for k, name in enumerate(names):
        charge = charges[k] if charges else 0.0
        lines.append(f"{name} {(masses or {}).get(name, 1.0)!r} {charge} 1 {int(k in frozen)}")
    for directive, rows in blocks.items():
        lines += [f"{directive} {len(rows)}", *rows]
    return "\n".join([*lines, "finish"])


def molecule_scene(
    names: Sequence[str],
    blocks: Blocks,
    positions: ArrayLike,
    *,
    copies: int = 1,
    pairs: Sequence[str] = (),
    cell: ArrayLike = 20.0,
    imcon: int | None = None,
    control: Mapping[str, str | None] | None = None,
    units: str = "dpd",
    frozen: Sequence[int] = (),
    charges: Sequence[float] = (),
    velocities: ArrayLike | None = None,
    files: Mapping[str, str] | None = None,
    masses: Mapping[str, float] | None = None,
    extern: str = "",
    extensions: str = "",
) -> Scene:
    """Return the scene of ``copies`` molecules, by default in reduced units, nve, without pair laws.

    Args:
        names: species of the beads of one molecule.
        blocks: lines by directive ("bonds", "angles", …).
        positions: (copies · len(names), 3).
        copies, pairs, cell, imcon, control, units: as in ``make_scene``.
        frozen: beads of a molecule, counted from 0, that never move.
        charges: of the beads of a molecule, by default none.
        velocities: (N, 3); given ones are kept as they are.
        files: further files by name, for tables.
        masses: by species, 1 unless given.
        extern: line of an external field.
        extensions: text after ``close``.
    """
    vdw = [f"vdw {len(pairs)}", *pairs] if pairs else []
    field = ["extern", extern] if extern else []
    molecule = molecule_text(names, blocks, copies, frozen, masses, charges)
    text = "\n".join(["test field", f"units {units}", "molecules 1", molecule, *vdw, *field, "close", extensions, ""])
    places: FloatArray = np.asarray(positions, dtype=np.float64)
    configuration = Configuration(
        names=tuple(names) * copies,
        positions=places,
        title="test configuration",
        imcon=imcon if imcon is not None else 3 if np.ndim(cell) == 2 else 2,
        cell=cell_of(cell),
        velocities=None if velocities is None else np.asarray(velocities, dtype=np.float64),
    )
    start = {} if velocities is None else {"restart": "noscale"}
    settings: dict[str, str | None] = {**_CONTROL, **start, **(control or {})}
    lines = [f"{keyword} {value}" for keyword, value in settings.items() if value is not None]
    with TemporaryDirectory() as folder:
        (Path(folder) / "CONTROL").write_text("\n".join([*lines, ""]))
        for name, content in {"FIELD": text, **(files or {})}.items():
            (Path(folder) / name).write_text(content)
        return load(folder, config=configuration)


def chains(copies: int, length: int, cell: ArrayLike, seed: int, step: float = 0.6) -> FloatArray:
    """(copies · length, 3) random walks with random starts in a cell around the origin, not wrapped."""
    rng = np.random.default_rng(seed)
    starts = (rng.random((copies, 1, 3)) - 0.5) @ cell_of(cell)
    steps = rng.normal(size=(copies, length, 3))
    steps *= step / np.linalg.norm(steps, axis=2, keepdims=True)
    return np.asarray((starts + np.cumsum(steps, axis=1)).reshape(-1, 3))
