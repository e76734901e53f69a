"""Whether a run may be continued with another scene: what a checkpoint fixes, and what may change."""

from __future__ import annotations

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Scene

_CELL_TOLERANCE = 1e-8  # relative; a cell that went through REVCON has ten decimals


def check_continues(stored: Scene, scene: Scene, path: str, cells: tuple[FloatArray, ...] = ()) -> None:
    """Check that a checkpoint of ``stored`` can go on as ``scene``; temperature, laws, timestep, outputs may differ.

    Args:
        stored: the scene in the checkpoint.
        scene: the scene to go on with.
        path: the checkpoint, for the message.
        cells: where a barostat moved the cell: the present one and that of the start; either may be the scene's.

    Raises:
        InputError: other beads (number, species, masses, charges, which are frozen, heat capacities), another cell, or
            other bins or samples of what both collect.
    """
    if stored.bead_count != scene.bead_count:
        raise InputError(
            f"holds {stored.bead_count} beads, but the scene to go on with has {scene.bead_count}", path=path
        )
    if stored.species != scene.species or not np.array_equal(stored.beads.species, scene.beads.species):
        raise InputError("holds other species than the scene to go on with", path=path)
    words = {"mass": "other masses", "charge": "other charges", "frozen": "other frozen beads"}
    for name, what in words.items():
        if not np.array_equal(getattr(stored.beads, name), getattr(scene.beads, name)):
            raise InputError(f"holds {what} than the scene to go on with", path=path)
    if (stored.heat is None) != (scene.heat is None):
        kinds = ["beads that carry heat", "beads that carry none"]
        was, now = kinds if scene.heat is None else reversed(kinds)
        raise InputError(f"holds {was}, but the scene to go on with has {now}", path=path)
    if not np.array_equal(_capacities(stored), _capacities(scene)):
        raise InputError("holds other heat capacities than the scene to go on with", path=path)
    # The extent of an open axis follows the beads; only periodic axes are part of the scene's identity.
    rows = list(stored.periodic)
    tolerance = _CELL_TOLERANCE * float(np.abs(stored.cell).max())
    same = [(np.abs(cell - scene.cell)[rows] <= tolerance).all() for cell in (stored.cell, *cells)]
    shapes = {stored.imcon, scene.imcon}  # a cube may become an orthorhombic cell, and a cell with equal edges a cube
    if not (len(shapes) == 1 or shapes == {1, 2}) or not any(same):
        raise InputError("holds another cell than the scene to go on with", path=path)
    dissolved = [None if one.transport is None else one.transport.species for one in (stored, scene)]
    if dissolved[0] != dissolved[1]:
        raise InputError("holds other dissolved species than the scene to go on with", path=path)
    _check_bins(stored, scene, path)
    _check_samples(stored, scene, path)


def _capacities(scene: Scene) -> FloatArray:
    return np.zeros(0) if scene.beads.heat_capacity is None else scene.beads.heat_capacity


def _check_samples(stored: Scene, scene: Scene, path: str) -> None:
    was, now = stored.output, scene.output
    if was.zden_every and now.zden_every and was.zden_bins != now.zden_bins:
        raise InputError(
            f"has collected density profiles in {was.zden_bins} bins, but the scene to go on with asks for "
            f"{now.zden_bins}; keep cutoff and zden_binsize, or switch zden_calculate off",
            path=path,
        )
    shapes = [(plan.vaf_every, plan.vaf_steps, plan.vaf_averaging) for plan in (was, now)]
    if was.vaf_every and now.vaf_every and shapes[0] != shapes[1]:
        raise InputError(
            "has collected velocity autocorrelations with other samples than the scene to go on with asks for; keep "
            "vaf_frequency, vaf_binsize and vaf_averaging, or switch vaf_calculate off",
            path=path,
        )


def _check_bins(stored: Scene, scene: Scene, path: str) -> None:
    if stored.output.rdf_every == 0 or scene.output.rdf_every == 0:
        return
    was, now = ((s.cutoff, s.output.rdf_bin_width) for s in (stored, scene))
    if was != now:
        raise InputError(
            f"has collected the radial distribution to {was[0]:g} ang in bins of {was[1]:g} ang, but the scene to go "
            f"on with asks for {now[0]:g} ang in bins of {now[1]:g} ang; keep both, or switch rdf_calculate off",
            path=path,
        )
