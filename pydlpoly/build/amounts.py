"""How many molecules of each kind: counts, fractions, concentrations, salt, counter-ions, and what fills the rest."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from pydlpoly.build.molecules import MoleculeType, Species
from pydlpoly.build.regions import Region
from pydlpoly.build.topology import species_named
from pydlpoly.errors import SceneError
from pydlpoly.units import AVOGADRO

# A charge this small is that of rounding, not of an ion.
_NEUTRAL = 1e-9
_LITRE = 1e24  # cubic nanometres


@dataclass(frozen=True)
class Component:
    """Molecules of one kind that are placed at random; exactly one of count, fraction, concentration and fill is given.

    Attributes:
        molecule: what to place; a species by name is a molecule of one bead.
        count: number of molecules.
        fraction: share of all beads, for beads of equal volume the volume fraction.
        concentration: in mol/L; needs the length unit in nm.
        fill: bring the region to the number density; without a region, what is left of the cell.
        region: where all beads lie. A filling component without one keeps out of regions that others fill.
        shape: ``grown`` (each molecule a random walk of its own) or ``rigid`` (copies of one shape: of the molecule's
            places, of a circle for rings, of one random walk for others); None: grown where that is possible.
        turn: largest angle in degrees between successive bonds of a grown molecule; None: any, or 60 when angles
            along it have a law.
    """

    molecule: MoleculeType | str
    count: int | None = None
    fraction: float | None = None
    concentration: float | None = None
    fill: bool = False
    region: Region | None = None
    shape: str | None = None
    turn: float | None = None


@dataclass(frozen=True)
class Salt:
    """Anions and cations in the proportion that makes them neutral; ``number`` or ``concentration`` counts formulas.

    Attributes:
        cation, anion: molecules or species names.
        number: of formula units.
        concentration: of formula units, in mol/L; needs the length unit in nm.
    """

    cation: MoleculeType | str
    anion: MoleculeType | str
    number: int | None = None
    concentration: float | None = None


def molecules_of(concentration: float, volume: float, length: float | None) -> int:
    """Return the number of molecules of a concentration in mol/L in a volume whose length unit is ``length`` nm.

    Raises:
        SceneError: there is no length unit, or the concentration is negative.
    """
    if length is None or not length > 0.0:
        raise SceneError("a concentration needs the length unit in nm", word="length")
    if not concentration >= 0.0:
        raise SceneError(f"a concentration must not be negative, not {concentration:g}")
    return round(concentration * AVOGADRO * volume * length**3 / _LITRE)


def charge_of(molecule: MoleculeType, species: Mapping[str, Species]) -> float:
    """Return a molecule's charge in e."""
    return sum(species_named(name, species, molecule.name).charge for name in molecule.beads)


def formula(cation: float, anion: float) -> tuple[int, int]:
    """Return how many cations and anions of these charges make a neutral formula unit.

    Raises:
        SceneError: charges of wrong sign, or without a small common multiple.
    """
    if not cation > 0.0 > anion:
        raise SceneError(f"a salt needs a positive and a negative ion, not charges {cation:g} and {anion:g}")
    ratio = Fraction(-anion / cation).limit_denominator(100)
    if abs(ratio.numerator * cation + ratio.denominator * anion) > _NEUTRAL * max(1.0, cation):
        raise SceneError(f"charges {cation:g} and {anion:g} have no small whole numbers that make them neutral")
    return ratio.numerator, ratio.denominator


def ions_of(salt: Salt, species: Mapping[str, Species], volume: float, length: float | None) -> tuple[Component, ...]:
    """Return the salt's two components. Raises SceneError for amounts or charges that make no salt."""
    cation, anion = as_molecule(salt.cation), as_molecule(salt.anion)
    if (salt.number is None) == (salt.concentration is None):
        raise SceneError("a salt needs either number or concentration", word=f"{cation.name} {anion.name}")
    units = salt.number if salt.number is not None else molecules_of(float(salt.concentration or 0.0), volume, length)
    if units < 0:
        raise SceneError(f"a number of formula units must not be negative, not {units}", word=cation.name)
    positive, negative = formula(charge_of(cation, species), charge_of(anion, species))
    return Component(cation, count=units * positive), Component(anion, count=units * negative)


def counter_ions(charge: float, ions: Iterable[MoleculeType | str], species: Mapping[str, Species]) -> Component | None:
    """Return the ions that balance a charge, or None when there is none to balance.

    Raises:
        SceneError: no ion has the opposite sign, or no whole number of them balances the charge.
    """
    if abs(charge) < _NEUTRAL:
        return None
    molecules = [as_molecule(ion) for ion in ions]
    for molecule in molecules:
        one = charge_of(molecule, species)
        if one * charge < 0.0:
            number = round(-charge / one)
            if abs(number * one + charge) > 1e-6:
                raise SceneError(f"a charge of {charge:g} is no multiple of its {one:g}", word=molecule.name)
            return Component(molecule, count=number)
    names = ", ".join(molecule.name for molecule in molecules)
    raise SceneError(f"none of the counter-ions {names} can balance a charge of {charge:g}")


def as_molecule(given: MoleculeType | str) -> MoleculeType:
    """Return a molecule; a name is a species whose beads are single."""
    return MoleculeType(given, (given,)) if isinstance(given, str) else given


def count_of(
    component: Component, total: int | None, density: float | None, volume: float, length: float | None
) -> int | None:
    """Return the number of molecules, or None for the one that fills what is left of the cell.

    Args:
        component: what is asked for.
        total: number of beads that the cell has at the density.
        density: number density of beads.
        volume: of the component's region, or of the cell.
        length: the length unit in nm.

    Raises:
        SceneError: none or several amounts are given, or one that needs a density or a length unit that is not there.
    """
    molecule = as_molecule(component.molecule)
    given = [component.count, component.fraction, component.concentration, True if component.fill else None]
    if sum(amount is not None for amount in given) != 1:
        raise SceneError("give exactly one of count, fraction, concentration and fill", word=molecule.name)
    size = len(molecule.beads)
    if component.count is not None:
        if component.count != int(component.count) or component.count < 0:
            message = f"a count is a whole number and not negative, not {component.count}"
            raise SceneError(message, word=molecule.name)
        return int(component.count)
    if component.concentration is not None:
        return molecules_of(component.concentration, volume, length)
    if density is None or total is None:
        raise SceneError("a fraction or fill needs the number density", word=molecule.name)
    if component.fraction is not None:
        if not 0.0 <= component.fraction <= 1.0:
            raise SceneError(f"a fraction lies between 0 and 1, not at {component.fraction:g}", word=molecule.name)
        return round(component.fraction * total / size)
    return None if component.region is None else round(density * volume / size)
