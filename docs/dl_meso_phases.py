"""Runs DL_MESO's four amphiphile inputs in full and writes their phases into docs/dl-meso.md.

``python docs/dl_meso_phases.py`` does so between ``<!-- measured: phases -->`` and ``<!-- end: phases -->``; pictures
go into docs/images. With ``--keep FOLDER`` the last frames of each run stay there and are used again. Needs scipy and
matplotlib, and minutes.

The hydrophobic beads B tell phases apart by the shape of their domain and by directions. Q is the sum of S(k) k k^T/k^2
over the sum of S(k), over the waves around the peak of the structure factor; it has the eigenvalues 1/3 1/3 1/3 in a
phase without direction, 1/2 1/2 0 for parallel cylinders, 1 0 0 for layers. G says the same of the surroundings of each
place, so that grains do not mix, see ``local_directions``. Micelles are pieces that reach themselves along no direction
of the cell.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, label
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from pydlpoly import Scene, Simulation, load

DOCS = Path(__file__).parent
PAGE = DOCS / "dl-meso.md"
INPUTS = DOCS.parents[1] / "shared" / "inputs" / "dl_meso"
NAMES = ("amphiphile-1", "amphiphile-2", "amphiphile-3", "amphiphile-4")
_SPACING = 0.5  # of the grid
_WIDTH = 0.4  # of the Gaussian that smooths densities
_FRAMES, _BETWEEN = 20, 50
_LAYERS, _CYLINDERS = 0.75, 0.1  # layers: the largest eigenvalue of G is above; cylinders: the smallest is below

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Phase:
    """What is measured of one system.

    Attributes:
        share: fraction of amphiphiles among the beads.
        temperature, pressure: means over the last frames.
        directions: independent directions along which the domain of B reaches itself.
        pieces: number of separate domains of B larger than 20 voxels.
        outside: the same directions of everything else.
        wave: length of the wave at the peak of the structure factor, in units of length.
        eigenvalues: of Q, largest first. local: of G, largest first, see ``local_directions``.
    """

    share: float
    temperature: float
    pressure: float
    directions: int
    pieces: int
    outside: int
    wave: float
    eigenvalues: tuple[float, float, float]
    local: tuple[float, float, float]

    @property
    def words(self) -> str:
        """The phase, from G where it has a direction, else from the shape of the domain of B."""
        high, _, low = self.local
        if high > _LAYERS:
            return "layers"
        if low < _CYLINDERS:
            return "cylinders side by side"
        return "micelles" if self.directions == 0 else "a network without direction"


def run(name: str, steps: int | None, keep: Path | None) -> tuple[Scene, FloatArray, float, float]:
    """Return the scene, the positions of the last frames (frames, N, 3), and mean temperature and pressure."""
    scene = load(INPUTS / name)
    kept = None if keep is None else keep / f"{name}-{steps or scene.run.steps}.npz"
    if kept is not None and kept.is_file():
        with np.load(kept) as data:
            return scene, data["frames"], float(data["temperature"]), float(data["pressure"])
    simulation = Simulation(scene, seed=1)
    simulation.run((steps or scene.run.steps) - _FRAMES * _BETWEEN)
    frames, seen = [], []
    for _ in range(_FRAMES):
        simulation.run(_BETWEEN)
        observation = simulation.observe()
        frames.append(simulation.state.positions)
        seen.append((observation.temperature, observation.pressure))
    temperature, pressure = (float(x) for x in np.mean(seen, axis=0))
    positions = np.array(frames)
    if kept is not None:
        kept.parent.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(kept, frames=positions, temperature=temperature, pressure=pressure)
    return scene, positions, temperature, pressure


def share_of(scene: Scene, frames: FloatArray, species: str) -> FloatArray:
    """Return the local share of a species on the grid, averaged over frames and smoothed."""
    edges = np.diag(scene.cell)
    shape = np.rint(edges / _SPACING).astype(int)
    chosen = np.nonzero(scene.beads.species == scene.species.index(species))[0]
    counts = [_counts(frames[:, members], edges, shape) for members in (chosen, slice(None))]
    one, every = (gaussian_filter(count, _WIDTH / _SPACING, mode="wrap") for count in counts)
    return np.asarray(one / np.maximum(every, 1e-9))


def _counts(positions: FloatArray, edges: FloatArray, shape: NDArray[np.int64]) -> FloatArray:
    cells = np.floor((positions.reshape(-1, 3) / edges + 0.5) * shape).astype(int) % shape
    flat = np.ravel_multi_index(tuple(cells.T), tuple(shape))
    return np.bincount(flat, minlength=int(shape.prod())).reshape(tuple(shape)).astype(np.float64)


def pieces(domain: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the sizes of the connected pieces of a domain in a periodic cell, largest first."""
    labels = _labels(domain)
    return np.sort(np.bincount(labels[domain]))[::-1]


def directions(domain: NDArray[np.bool_]) -> int:
    """Return along how many independent directions the largest piece of a periodic domain reaches itself.

    In a cell of 3 x 3 x 3 copies that is periodic, too, a piece that reaches itself along d directions has become
    27/3^d pieces.
    """
    labels = _labels(domain)
    largest = labels == np.bincount(labels[domain]).argmax()
    copies = _labels(np.tile(largest & domain, (3, 3, 3)))
    found = len(np.unique(copies[copies >= 0]))
    return round(3 - math.log(found, 3))


def _labels(domain: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Number the pieces of a domain from 0, across the faces; -1 outside."""
    numbered, count = label(domain)
    pairs = []
    for axis in range(3):
        low, high = np.take(numbered, 0, axis), np.take(numbered, -1, axis)
        both = (low > 0) & (high > 0)
        pairs.append(np.stack([low[both], high[both]]))
    a, b = np.concatenate(pairs, axis=1) - 1
    graph = coo_matrix((np.ones(len(a)), (a, b)), shape=(count, count))
    _, merged = connected_components(graph, directed=False)
    return np.concatenate([[-1], merged])[numbered]


def structure(scene: Scene, frames: FloatArray, species: str) -> tuple[float, tuple[float, float, float]]:
    """Return the wave length at the peak of S(k) of a species, and the eigenvalues of Q around it, largest first."""
    edges = np.diag(scene.cell)
    shape = np.rint(edges / _SPACING).astype(int)
    chosen = scene.beads.species == scene.species.index(species)
    power = np.mean([np.abs(np.fft.fftn(_counts(frame[chosen], edges, shape))) ** 2 for frame in frames], axis=0)
    waves = [2.0 * np.pi * np.fft.fftfreq(n, edge / n) for n, edge in zip(shape.tolist(), edges.tolist(), strict=True)]
    k = np.stack(np.meshgrid(*waves, indexing="ij"), axis=-1).reshape(-1, 3)
    length = np.linalg.norm(k, axis=1)
    inside = (length > 0.0) & (length < 4.0)
    k, length, weight = k[inside], length[inside], power.reshape(-1)[inside]
    bins = np.round(length / 0.2).astype(int)
    mean = np.bincount(bins, weights=weight) / np.maximum(np.bincount(bins), 1)
    peak = int(mean.argmax())
    near = np.abs(bins - peak) <= 1
    unit = k[near] / length[near, None]
    tensor = np.einsum("n,ni,nj->ij", weight[near], unit, unit) / weight[near].sum()
    low, middle, high = np.linalg.eigvalsh(tensor).tolist()
    at_peak = np.average(length[near], weights=weight[near])
    return float(2.0 * np.pi / at_peak), (high, middle, low)


def local_directions(share: FloatArray, wave: float) -> tuple[float, float, float]:
    """Return the mean eigenvalues, largest first, of G = <grad s grad s^T> / trace, s the share, <> over half a wave.

    As Q, but of the surroundings of each place, so that grains of other orientations do not mix: 1 0 0 for layers,
    1/2 1/2 0 for cylinders, 1/3 1/3 1/3 for micelles. The mean is weighted by the trace.
    """
    slope = np.stack([np.roll(share, -1, axis) - np.roll(share, 1, axis) for axis in range(3)], axis=-1)
    products = slope[..., :, None] * slope[..., None, :]
    width = 0.5 * wave / _SPACING
    tensor = np.stack(
        [gaussian_filter(products[..., i, j], width, mode="wrap") for i in range(3) for j in range(3)], -1
    )
    values = np.linalg.eigvalsh(tensor.reshape(-1, 3, 3))
    low, middle, high = (values.sum(axis=0) / values.sum()).tolist()
    return high, middle, low


def phase(scene: Scene, frames: FloatArray, temperature: float, pressure: float) -> tuple[Phase, FloatArray]:
    """Return what is measured of one system, and the local share of B."""
    share = share_of(scene, frames, "B")
    low, high = np.percentile(share, [2, 98])
    domain = share > 0.5 * (low + high)
    wave, eigenvalues = structure(scene, frames, "B")
    amphiphiles = float(np.mean(scene.beads.species != scene.species.index("S")))
    sizes = pieces(domain)
    found = Phase(
        share=amphiphiles,
        temperature=temperature,
        pressure=pressure,
        directions=directions(domain),
        pieces=int((sizes > 20).sum()),
        outside=directions(~domain),
        wave=wave,
        eigenvalues=eigenvalues,
        local=local_directions(share, wave),
    )
    return found, share


def draw(name: str, scene: Scene, share: FloatArray) -> Path:
    """Draw the share of B in two planes through the middle of the cell and return the picture's path."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    x, y, z = np.diag(scene.cell)
    figure, (left, right) = plt.subplots(1, 2, figsize=(5.0, 2.2), width_ratios=(2, 1), layout="constrained")
    middle = [n // 2 for n in share.shape]
    limits = {"vmin": 0.0, "vmax": float(share.max()), "cmap": "viridis", "origin": "lower"}
    left.imshow(share[:, middle[1], :], extent=(0.0, z, 0.0, x), **limits)
    left.set(xlabel="z", ylabel="x")
    right.imshow(share[:, :, middle[2]], extent=(0.0, y, 0.0, x), **limits)
    right.set(xlabel="y", ylabel="x")
    path = DOCS / "images" / f"{name}.png"
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=90)
    plt.close(figure)
    return path


def page(found: dict[str, Phase], steps: int) -> str:
    """Return the measured part of the page."""
    heads = [
        "input",
        "amphiphiles",
        "T",
        "P",
        "B reaches itself along",
        "pieces of B",
        "wave length",
        "Q",
        "G",
        "phase",
    ]
    lines = [" | ".join(heads), " | ".join("---" for _ in heads)]
    for name, one in found.items():
        q, g = (" ".join(f"{x:.2f}" for x in values) for values in (one.eigenvalues, one.local))
        cells = [f"`{name}`", f"{one.share:.0%}", f"{one.temperature:.4f}", f"{one.pressure:.2f}"]
        cells += [f"{one.directions} directions", str(one.pieces), f"{one.wave:.2f}", q, g, one.words]
        lines.append(" | ".join(cells))
    table = "".join(f"| {line} |\n" for line in lines)
    pictures = "".join(f"\n![share of B in {name}](images/{name}.png)\n" for name in found)
    return f"After {steps} steps, seed 1, averages over the last {_FRAMES * _BETWEEN}:\n\n{table}{pictures}"


def _between(fresh: str, marks: re.Match[str]) -> str:
    return f"{marks[1]}\n{fresh}\n{marks[2]}"


def main() -> int:
    """Run, measure, draw, and rewrite the page; the return value is the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, help="in place of CONTROL's")
    parser.add_argument("--keep", type=Path, help="folder for the last frames of each run")
    parser.add_argument("--only", action="append", choices=NAMES, help="leave the others out of table and pictures")
    options = parser.parse_args()
    found = {}
    steps = 0
    for name in options.only or NAMES:
        scene, frames, temperature, pressure = run(name, options.steps, options.keep)
        steps = options.steps or scene.run.steps
        found[name], share = phase(scene, frames, temperature, pressure)
        path = draw(name, scene, share)
        print(f"{name}: {found[name]}, {path.stat().st_size} bytes", flush=True)
    mark = re.compile(r"(<!-- measured: phases -->\n).*?(<!-- end: phases -->\n)", re.DOTALL)
    text = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(mark.sub(partial(_between, page(found, steps)), text), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
