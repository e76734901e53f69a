"""Walls across axes of the cell: hard ones that reflect beads, and a soft repulsion before them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import SceneError
from pydlpoly.formats.records import Configuration, FloatArray
from pydlpoly.scene.beads import Layout
from pydlpoly.scene.external import unfit_for_flight
from pydlpoly.scene.model import Dynamics, ExternalTerm, Walls
from pydlpoly.scene.settings import Notes, Settings

_KEYWORDS = ("wall_axes", "wall_position", "wall_strength", "wall_range")


def resolve_walls(
    settings: Settings,
    dynamics: Dynamics,
    external: tuple[ExternalTerm, ...],
    config: Configuration,
    cell: FloatArray,
    species: tuple[str, ...],
    vdw_cutoff: float,
    notes: Notes,
) -> Walls | None:
    """Return the walls that CONTROL asks for, None without.

    Args:
        settings: CONTROL.
        dynamics: the integrator, which has to fit.
        external: the external fields; a magnetic one cannot act between walls.
        config: the configuration, for the shape of its cell.
        cell: (3, 3) cell vectors by row, Å.
        species: names, in the order of ``wall_strength``.
        vdw_cutoff: where soft walls end unless ``wall_range`` says otherwise, Å.
        notes: receives defaults.

    Raises:
        SceneError: another cell or integrator than walls go with, or numbers that make no wall.
    """
    method = settings.word("wall_method")
    if method == "off":
        return None
    settings.consumed.update(_KEYWORDS)
    if config.imcon not in (1, 2):
        raise settings.refusal("wall_method", f"walls need a cubic or orthorhombic cell (imcon 1 or 2), not imcon "
                               f"{config.imcon}")  # fmt: skip
    unfit = unfit_for_flight(dynamics, "walls")
    if unfit is not None:
        raise settings.refusal("wall_method", unfit[1])
    if dynamics.barostat is not None:
        raise settings.refusal("wall_method", "walls are not modelled in a cell that follows the pressure")
    if any(term.key == "magn" for term in external):
        raise settings.refusal("wall_method", "walls and the field magn are not modelled together")
    walled = tuple(axis in settings.word("wall_axes") for axis in "xyz")
    strengths, reach = _softness(settings, method, species, vdw_cutoff, notes)
    return Walls(
        method="bounce-back" if method == "bounce-back" else "reflecting",
        walled=(walled[0], walled[1], walled[2]),
        distance=_distances(settings, walled, cell),
        strengths=strengths,
        range=reach,
        explanation=settings.where("wall_method"),
    )


def _distances(settings: Settings, walled: tuple[bool, ...], cell: FloatArray) -> tuple[float, float, float]:
    """Return how far from the origin the walls are along each axis."""
    halves = [0.5 * float(cell[k, k]) for k in range(3)]
    given = settings.number("wall_position")
    if not settings.given("wall_position"):
        return halves[0], halves[1], halves[2]
    nearest = min(half for half, wall in zip(halves, walled, strict=True) if wall)
    if not 0.0 < given <= nearest * (1.0 + 1e-9):
        message = f"walls stand above 0 and up to half the cell's edge ({nearest:g} ang) from its centre, not at "
        raise settings.refusal("wall_position", f"{message}{given:g}")
    x, y, z = (given if wall else half for half, wall in zip(halves, walled, strict=True))
    return x, y, z


def _softness(
    settings: Settings, method: str, species: tuple[str, ...], vdw_cutoff: float, notes: Notes
) -> tuple[tuple[float, ...], float]:
    """Return the strengths by species and the range of soft walls; none for hard walls."""
    if method != "soft":
        for keyword in ("wall_strength", "wall_range"):
            if settings.given(keyword):
                notes.ignored(f"{keyword}: only soft walls have it, not {method} ones", settings.where(keyword))
        return (), 0.0
    if not settings.given("wall_strength"):
        raise settings.refusal("wall_method", "soft walls need wall_strength: one number, or one for each species")
    strengths = settings.vector("wall_strength")
    if len(strengths) not in (1, len(species)):
        message = (
            f"{len(strengths)} numbers for {len(species)} species ({', '.join(species)}); expected one, or one each"
        )
        raise settings.refusal("wall_strength", message)
    if not all(math.isfinite(x) and x >= 0.0 for x in strengths):
        raise settings.refusal("wall_strength", "the strength of a soft wall must be finite and not negative")
    reach = settings.number("wall_range") if settings.given("wall_range") else vdw_cutoff
    if not (reach > 0.0 and math.isfinite(reach)):
        raise settings.refusal("wall_range", f"the range of a soft wall must be above 0, not {reach:g}")
    if not settings.given("wall_range"):
        notes.choice(f"no wall_range: soft walls end at the van der Waals cutoff, {reach:g} ang",
                     settings.where("wall_method"))  # fmt: skip
    return (strengths * len(species) if len(strengths) == 1 else strengths), reach


def open_axes(periodic: tuple[bool, bool, bool], walls: Walls | None) -> tuple[bool, bool, bool]:
    """Return the periodicity with walls: none along the axes they close."""
    if walls is None:
        return periodic
    x, y, z = (p and not w for p, w in zip(periodic, walls.walled, strict=True))
    return x, y, z


def check_beads_inside(walls: Walls | None, positions: FloatArray, layout: Layout, path: str) -> None:
    """Raise SceneError when a bead that moves is beyond a wall, naming it."""
    if walls is None:
        return
    limits = np.where(walls.walled, walls.distance, np.inf)
    outside: NDArray[np.bool_] = (np.abs(positions) > limits).any(axis=1) & ~layout.frozen
    if outside.any():
        bead = int(np.nonzero(outside)[0][0])
        place = " ".join(f"{x:g}" for x in positions[bead])
        name = layout.species_names[layout.species[bead]]
        raise SceneError(f"bead {bead + 1} ({name}) at {place} is beyond a wall (wall_method)", path=path)
