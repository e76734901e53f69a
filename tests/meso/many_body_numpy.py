"""Many-body DPD by plain sums over all beads and images: an independent judge of densities, energies and forces."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True)
class Numbers:
    """What acts between two species: A, r_c of the law; W(0) and its shape, its range and the force's shape."""

    attraction: float
    cutoff: float
    kernel: Callable[[FloatArray], FloatArray]  # W(r)
    slope: Callable[[FloatArray], FloatArray]  # the factor of φ_i + φ_j in the force along r_i − r_j
    reach: float


def warren(a: float, cutoff: float, reach: float) -> Numbers:
    """Two-density form: force B (ρ̄_i + ρ̄_j)(1 − r/r_d), φ = π r_d⁴ B ρ̄/15 of the energy π r_d⁴ B ρ̄²/30."""
    return Numbers(
        a,
        cutoff,
        lambda r: 15.0 / (2.0 * np.pi * reach**3) * np.clip(1.0 - r / reach, 0.0, None) ** 2,
        lambda r: 15.0 / (np.pi * reach**4) * np.clip(1.0 - r / reach, 0.0, None),
        reach,
    )


def lucy(a: float, b: float, cutoff: float, reach: float) -> Numbers:
    """LAMMPS's: φ = ρ̄, force B (ρ̄_i + ρ̄_j)(1 − r/r_d)."""
    return Numbers(
        a,
        cutoff,
        lambda r: (
            105.0 / (16.0 * np.pi * reach**3) * (1.0 + 3.0 * r / reach) * np.clip(1.0 - r / reach, 0.0, None) ** 3
        ),
        lambda r: b * np.clip(1.0 - r / reach, 0.0, None),
        reach,
    )


def generalised(a: float, n: float, cutoff: float, reach: float) -> Numbers:
    """DL_POLY's manual: w = (n+1)(n+2)(n+3) r_c³/(8π r_d³) (1 − r/r_d)^n, φ = B ρ̃^(m−1)."""
    height = (n + 1.0) * (n + 2.0) * (n + 3.0) * cutoff**3 / (8.0 * np.pi * reach**3)
    return Numbers(
        a,
        cutoff,
        lambda r: height * np.clip(1.0 - r / reach, 0.0, None) ** n,
        lambda r: n * height / reach * np.clip(1.0 - r / reach, 0.0, None) ** (n - 1.0),
        reach,
    )


@dataclass(frozen=True)
class Judged:
    densities: FloatArray
    forces: FloatArray
    energy: float  # Σ ψ and the pair law's
    virial: FloatArray  # Σ F_a r_b


def judge(
    positions: FloatArray,
    cell: FloatArray,
    species: FloatArray,
    pairs: dict[tuple[int, int], Numbers],
    energy: Callable[[FloatArray], FloatArray],
    response: Callable[[FloatArray], FloatArray],
    images: int = 1,
) -> Judged:
    """Sum over all pairs; ``energy`` and ``response`` are ψ and φ of all beads' densities."""
    count = len(positions)
    shifts = [np.array(k) @ cell for k in itertools.product(range(-images, images + 1), repeat=3)]
    density = np.zeros(count)
    found = []
    for shift in shifts:
        vectors = positions[:, None, :] - positions[None, :, :] - shift
        distance = np.linalg.norm(vectors, axis=2)
        for i in range(count):
            for (a, b), numbers in pairs.items():
                partner = (species == b) if species[i] == a else (species == a) if species[i] == b else None
                if partner is None:
                    continue
                near = partner & (distance[i] < numbers.cutoff)
                if not shift.any():
                    near[i] = False
                r = distance[i][near]
                if len(r) == 0:
                    continue
                inside = r < numbers.reach
                density[i] += numbers.kernel(r[inside]).sum()
                found.append((i, np.nonzero(near)[0], r, vectors[i][near], numbers))
    phi = response(density)
    forces, virial, total = np.zeros((count, 3)), np.zeros((3, 3)), float(np.sum(energy(density)))
    for i, j, r, vectors, numbers in found:
        weight = 1.0 - r / numbers.cutoff
        factor = numbers.attraction * weight + np.where(r < numbers.reach, numbers.slope(r) * (phi[i] + phi[j]), 0.0)
        force = (factor / np.where(r > 0.0, r, 1.0))[:, None] * vectors
        forces[i] += force.sum(axis=0)
        virial += 0.5 * force.T @ vectors
        total += 0.25 * float(np.sum(numbers.attraction * numbers.cutoff * weight**2))
    return Judged(density, forces, total, virial)
