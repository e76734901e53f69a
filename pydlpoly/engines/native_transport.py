"""Dissolved species of a scene in the compiled core."""

from __future__ import annotations

from pydlpoly import _core
from pydlpoly.errors import SceneError
from pydlpoly.scene.model import Scene
from pydlpoly.scene.transport_terms import Region, Transport


def make_transport(scene: Scene, transport: Transport) -> _core.Transport:
    """Return the core's form of what happens to dissolved species. Raises SceneError for numbers it does not take."""
    made = _core.Transport(len(scene.species), len(transport.species))
    made.set_noise(transport.noise)
    try:
        for flux in transport.fluxes:
            a, b = flux.species
            made.set_flux(a, b, flux.dissolved, flux.rate, flux.range, flux.exponent, flux.noise)
        for source in transport.sources:
            made.add_source(source.dissolved, source.value, source.region.kind, list(source.region.numbers))
        for hold in transport.holds:
            made.add_hold(_species_of(hold.region), hold.dissolved, hold.value)
        for reaction in transport.reactions:
            made.add_reaction(reaction.rate, list(reaction.reactants), list(reaction.change), reaction.species)
    except ValueError as error:
        raise SceneError(f"extension transport: {error}") from error
    return made


def _species_of(region: Region) -> int:
    return int(region.numbers[0])
