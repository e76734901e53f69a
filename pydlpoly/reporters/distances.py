"""Radial distribution functions of the pair distances that the engine counts, written as RDFDAT."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pydlpoly.formats.rdfdat import normalise_rdf, write_rdf
from pydlpoly.formats.records import FloatArray
from pydlpoly.simulation import Simulation


def radial_distributions(
    simulation: Simulation,
) -> tuple[FloatArray, dict[tuple[str, str], tuple[FloatArray, FloatArray]]]:
    """Return r (bins,) in Å and, for each collected pair of species, g(r) and the running coordination number.

    A pair with no beads on one side, or a single bead with itself, has no g(r) and is left out, as in DL_POLY.
    """
    counts, samples = simulation.distance_counts()
    scene = simulation.scene
    beads = np.bincount(scene.beads.species, minlength=len(scene.species)).tolist()
    width = scene.cutoff / simulation.rdf_bins
    r: FloatArray = (np.arange(simulation.rdf_bins, dtype=np.float64) + 0.5) * np.float64(width)
    result = {}
    for pair in scene.output.rdf_pairs:
        a, b = sorted(pair)
        if samples == 0 or min(beads[a], beads[b]) < (2 if a == b else 1):
            continue
        _, g, n = normalise_rdf(
            counts[a, b],
            like=a == b,
            volume=simulation.distance_volume,
            beads=(beads[a], beads[b]),
            configurations=samples,
            bin_width=width,
        )
        result[scene.species[a], scene.species[b]] = (g, n)
    return r, result


def write_distances(simulation: Simulation, path: Path) -> None:
    """Write RDFDAT when anything has been sampled."""
    r, table = radial_distributions(simulation)
    if table:
        write_rdf(
            path, simulation.scene.title, list(table), r, [g for g, _ in table.values()], [n for _, n in table.values()]
        )
