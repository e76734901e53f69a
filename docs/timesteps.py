"""Measures the tables of docs/integrators.md: temperatures of every integrator against the timestep.

``python docs/timesteps.py`` runs all cells on all processors (some minutes to half an hour) and rewrites the part
between ``<!-- measured: timesteps -->`` and ``<!-- end: timesteps -->``. The fluid is that of the reference values in
tests/physics/test_timesteps.py: DPD water, 1536 beads in 8³, γ = 4.5, k_B T = 1.
"""

from __future__ import annotations

import re
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pydlpoly import Simulation
from pydlpoly.bench.scenes import cube, single_beads
from pydlpoly.errors import RunError, SceneError
from pydlpoly.scene.integrators import INTEGRATORS
from pydlpoly.scene.model import Scene

PAGE = Path(__file__).with_name("integrators.md")
TIMESTEPS = (0.01, 0.02, 0.04, 0.06, 0.10)
SETTINGS: dict[str, dict[str, str]] = {
    "mdvv": {},
    "mdvv, λ 0.65": {"ensemble_dpd_lambda": "0.65"},
    "mdvv, λ 0.9, half steps": {"ensemble_dpd_lambda": "0.9", "ensemble_dpd_kinetic": "half"},
    **{name: {} for name in INTEGRATORS if name != "mdvv"},
    "middle, 2 passes": {"ensemble_dpd_passes": "2"},
    "middle, every 4": {"ensemble_dpd_interval": "4"},
}
"""Rows of the tables: a name, whose first word is the integrator, and settings."""


@dataclass(frozen=True)
class Cell:
    """Averages of one run; errors are those of 20 blocks.

    Attributes:
        kinetic, configurational: temperatures over that of the thermostat; ``…_error``: their standard errors.
        pressure: ρ k_B T and the conservative virial; ``energy``: potential energy per bead.
    """

    kinetic: float
    kinetic_error: float
    configurational: float
    configurational_error: float
    pressure: float
    pressure_error: float
    energy: float
    energy_error: float


def scene(row: str, timestep: float, repulsion: float, beads: int = 1536) -> Scene:
    """Return the fluid stepped as the row says."""
    order = row.split(",")[0]
    control = {"ensemble_dpd_order": order, "timestep": f"{timestep} dpd_t", **SETTINGS[row]}
    pairs = {("W", "W"): ("dpd", repulsion, 1.0, 4.5)}
    return single_beads("water", {"W": beads}, pairs, cube(beads, 3.0), control=control)


def measure(row: str, timestep: float, repulsion: float, duration: float = 40.0, seed: int = 1) -> Cell | None:
    """Return the averages over ``duration`` after 10 units of time, None when the run did not last."""
    simulation = Simulation(scene(row, timestep, repulsion), seed=seed, threads=1)
    stride = max(1, round(0.08 / timestep))
    samples = []
    try:
        simulation.run(round(10.0 / timestep))
        for _ in range(round(duration / (stride * timestep))):
            simulation.run(stride)
            samples.append(sample(simulation))
    except RunError:
        return None
    blocks = np.array([block.mean(axis=0) for block in np.array_split(np.array(samples), 20)])
    mean, spread = blocks.mean(axis=0), blocks.std(axis=0, ddof=1) / np.sqrt(len(blocks))
    if repulsion == 0.0:
        ratio = ratio_error = 0.0
    else:
        ratio = mean[1] / mean[2]
        ratios = blocks[:, 1] / blocks[:, 2]
        ratio_error = float(ratios.std(ddof=1) / np.sqrt(len(blocks)))
    return Cell(mean[0], spread[0], ratio, ratio_error, mean[3], spread[3], mean[4], spread[4])


def sample(simulation: Simulation) -> list[float]:
    """Return kinetic temperature, Σ|∇U|², Σ∇²U, pressure with the ideal part ρ k_B T, and energy per bead."""
    seen = simulation.observe()
    squared, curvature = simulation.configurational()
    density = simulation.scene.bead_count / seen.volume
    pressure = density + float(np.trace(seen.stress_parts["conservative"])) / 3.0
    return [seen.temperature, squared, curvature, pressure, seen.energy["potential"] / simulation.scene.bead_count]


def _measure_or_refuse(row: str, timestep: float, repulsion: float) -> Cell | str | None:
    try:
        return measure(row, timestep, repulsion)
    except SceneError:
        return "refused"


def _text(cell: Cell | str | None, ideal: bool) -> str:
    if isinstance(cell, str):
        return cell
    if cell is None or not cell.kinetic < 10.0:
        return "unstable"
    return f"{cell.kinetic:.3f}" if ideal else f"{cell.kinetic:.3f} / {cell.configurational:.3f}"


def main() -> None:
    """Measure all cells and rewrite the page."""
    jobs = [(row, timestep, repulsion) for repulsion in (25.0, 0.0) for row in SETTINGS for timestep in TIMESTEPS]
    with ProcessPoolExecutor() as pool:
        cells = dict(zip(jobs, pool.map(_measure_or_refuse, *zip(*jobs, strict=True)), strict=True))
    parts = []
    for repulsion, title in ((25.0, "A = 25: kinetic / configurational temperature"), (0.0, "A = 0: kinetic")):
        lines = [f"{title}\n", "| integrator | " + " | ".join(f"Δt = {t:.2f}" for t in TIMESTEPS) + " |"]
        lines.append("| --- " * (len(TIMESTEPS) + 1) + "|")
        for row in SETTINGS:
            texts = [_text(cells[row, timestep, repulsion], repulsion == 0.0) for timestep in TIMESTEPS]
            lines.append(f"| {row} | " + " | ".join(texts) + " |")
        found = [cell for cell in cells.values() if isinstance(cell, Cell)]
        parts.append("\n".join(lines) + "\n")
    errors = [max(c.kinetic_error, c.configurational_error) for c in found if c.kinetic < 2.0]
    parts.append(f"Standard errors have the median {np.median(errors):.4f}.\n")
    mark = re.compile(r"(<!-- measured: timesteps -->\n).*?(<!-- end: timesteps -->\n)", re.DOTALL)
    text = PAGE.read_text(encoding="utf-8")
    body = "\n".join(parts)
    PAGE.write_text(mark.sub(lambda m: f"{m[1]}\n{body}\n{m[2]}", text), encoding="utf-8")


if __name__ == "__main__":
    main()
