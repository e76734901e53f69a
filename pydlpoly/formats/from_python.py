"""Records from plain Python values: settings from a mapping, a FIELD of single beads from pair laws by species."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import InputError
from pydlpoly.formats.control import parse_control
from pydlpoly.formats.keywords import lookup, nearest
from pydlpoly.formats.lexing import WORD_LIMIT
from pydlpoly.formats.records import AtomLine, Control, Field, FloatArray, Molecule, PairLine
from pydlpoly.units import energy_unit

Pairs = Mapping[tuple[str, str], Sequence[str | float]]


def control_from_mapping(settings: Mapping[str, Any], path: str = "control") -> Control:
    """Return the record of settings by keyword, read by the same table as a CONTROL file.

    Args:
        settings: values by new-style keyword: numbers, booleans, strings (``"10 fs"``: a number and its unit),
            sequences of numbers for vectors. ``title`` is the title.
        path: the name that error messages give to the settings.

    Raises:
        InputError: there is no such keyword, or its value cannot be read.
    """
    lines = [f"title {_value_text('title', settings.get('title', ''), path)}"]
    for keyword, value in settings.items():
        if keyword == "title":
            continue
        # Looked up here too: one old directive among the keywords would turn the whole text into the old style.
        if lookup(keyword) is None:
            raise InputError(f"is no keyword of CONTROL{nearest(keyword)}", path=path, word=keyword)
        lines.append(f"{keyword} {_value_text(keyword, value, path)}")
    return parse_control("\n".join(lines) + "\n", path=path)


def _value_text(keyword: str, value: Any, path: str) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "on" if value else "off"
    if isinstance(value, str):
        if any(mark in value for mark in "\n\r#!"):
            raise InputError("a value is one line without comments", path=path, word=keyword)
        return value
    if isinstance(value, (int, float, np.integer, np.floating)):
        return str(value)
    if isinstance(value, (Sequence, np.ndarray)):
        return "[ " + " ".join(_value_text(keyword, x, path) for x in value) + " ]"
    raise InputError(f"expected a string or a number, not {type(value).__name__}", path=path, word=keyword)


def single_bead_field(
    names: NDArray[np.str_],
    masses: FloatArray,
    charges: FloatArray,
    pairs: Pairs,
    units: str,
    *,
    names_from: str = "names",
    path: str = "pairs",
) -> Field:
    """Return a FIELD in which every bead is a molecule of its own, one molecule type a species.

    Args:
        names: (N,) species of each bead; the molecule types come in the order in which the species first appear.
        masses, charges: (N,) in Da and e, equal within a species.
        pairs: pair laws by species, see ``pair_lines``.
        units: the energy unit of the laws' numbers: ev, kcal, kj, k, internal or dpd.
        names_from, path: the names that error messages give to the beads and to the pair laws.

    Raises:
        InputError: an unknown unit, a name that FIELD cannot hold, unlike beads of one species, or malformed pairs.
    """
    molecules = []
    for name in dict.fromkeys(names.tolist()):
        chosen = names == name
        if not 1 <= len(name) <= WORD_LIMIT or name.split() != [name]:
            message = f"a species name has 1 to {WORD_LIMIT} characters and no blanks"
            raise InputError(message, path=names_from, word=name)
        mass, charge = (
            _common(array[chosen], what, name, names_from) for array, what in ((masses, "mass"), (charges, "charge"))
        )
        molecules.append(Molecule(name, int(chosen.sum()), (AtomLine(name, mass, charge),)))
    return Field("", energy_unit(units, path="units").name, tuple(molecules), pair_lines(pairs, path), path=path)


def _common(values: FloatArray, what: str, name: str, path: str) -> float:
    first = float(values[0])
    others = values[values != first]
    if len(others):
        message = f"beads of one species differ in their {what}: {first:.10g} and {float(others[0]):.10g}"
        raise InputError(f"{message}; give them names of their own", path=path, word=name)
    return first


def pair_lines(pairs: Pairs, path: str = "pairs") -> tuple[PairLine, ...]:
    """Return the ``vdw`` records of pair laws by species: ``{("A", "B"): ("dpd", 25.0, 1.0, 4.5)}``.

    Raises:
        InputError: a key is no pair of names, a value is not a law's key with its numbers, or a pair is given twice.
    """
    lines: list[PairLine] = []
    seen: set[tuple[str, ...]] = set()
    for species, law in pairs.items():
        # A string of two letters would pass for two species.
        if not (isinstance(species, tuple) and len(species) == 2 and all(isinstance(name, str) for name in species)):
            raise InputError("the key of a pair is a tuple of two species names", path=path, word=str(species))
        names = f"{species[0]} {species[1]}"
        if tuple(sorted(species)) in seen:
            raise InputError("this pair is given twice", path=path, word=names)
        if isinstance(law, str) or not law or not isinstance(law[0], str):
            raise InputError("expected a law's key and its numbers, as in ('dpd', 25.0, 1.0)", path=path, word=names)
        try:
            numbers = tuple(float(number) for number in law[1:])
        except (TypeError, ValueError):
            message = f"after the key {law[0]!r} only numbers can follow, not {tuple(law[1:])}"
            raise InputError(message, path=path, word=names) from None
        seen.add(tuple(sorted(species)))
        lines.append(PairLine((species[0], species[1]), law[0].lower()[:4], numbers))
    return tuple(lines)
