"""Laws for the bonds, angles and pairs of what is built: tables by species become FIELD's records."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations_with_replacement
from typing import Any, Literal, get_args

import numpy as np

from pydlpoly.build.molecules import MoleculeType, Species
from pydlpoly.errors import SceneError, suggest
from pydlpoly.formats.field_keys import BONDED
from pydlpoly.formats.from_python import pair_lines
from pydlpoly.formats.records import AtomLine, BondedLine, FloatArray, Molecule, MoleculeBlock, PairLine

Kind = Literal["bonds", "angles"]
Key = str | tuple[str, ...]
Laws = Mapping[Any, Sequence[str | float]]

_KINDS: tuple[Kind, ...] = get_args(Kind)
_MEMBERS = {"bonds": 2, "angles": 3}
# Parameters of the dpd law in FIELD's order, under the names that tables use.
_DPD = ("a", "cutoff", "drag")
# FENE bonds are built at most so far stretched.
_OF_FENE = 0.5


def names_of(key: Key, count: int, what: str) -> tuple[str, ...]:
    """Return the species of a table's key: ``("A", "B")``, ``"A B"`` or ``"A-B"``; ``"*"`` is ``()``: all others.

    Raises:
        SceneError: another number of names.
    """
    if key == "*":
        return ()
    if isinstance(key, str):
        # Names can hold a minus sign: it separates only where there are no blanks.
        names = tuple(key.split() if len(key.split()) > 1 else key.strip().split("-"))
    else:
        names = tuple(key)
    if len(names) != count:
        raise SceneError(f"expected {count} species (as in {' '.join('ABC'[:count])!r}) or *", path=what, word=str(key))
    return names


def molecule_record(
    molecule: MoleculeType,
    count: int,
    species: Mapping[str, Species],
    laws: Mapping[Kind, Laws],
    *,
    exclude: bool = False,
) -> Molecule:
    """Return FIELD's record of a molecule: equal beads in a row on one line, one bonded line a bond and an angle.

    Args:
        molecule: beads, bonds and angles.
        count: number of copies.
        species: by name.
        laws: for ``bonds`` and ``angles`` by species; ``"*"`` for all others. Angles without a law have no line.
        exclude: keep plain keys as they are, which takes bonded beads out of each other's pair forces; without it
            they become the restraint form.

    Raises:
        SceneError: a species or a bond's law that is not there.
    """
    atoms: list[AtomLine] = []
    for name in molecule.beads:
        kind = species_named(name, species, molecule.name)
        if atoms and atoms[-1].name == name:
            last = atoms.pop()
            atoms.append(AtomLine(name, last.mass, last.charge, last.repeat + 1, last.frozen))
        else:
            atoms.append(AtomLine(name, kind.mass, kind.charge, 1, int(kind.frozen)))
    blocks = []
    for block in _KINDS:
        lines = []
        for beads in molecule.bonds if block == "bonds" else molecule.angles:
            law = law_of(block, tuple(molecule.beads[k] for k in beads), laws.get(block, {}), molecule.name)
            if law is not None:
                key, numbers = law
                lines.append(
                    BondedLine(key if exclude else _restraint(block, key), tuple(k + 1 for k in beads), numbers)
                )
        if lines:
            blocks.append(MoleculeBlock(block, tuple(lines)))
    return Molecule(molecule.name, count, tuple(atoms), tuple(blocks))


def species_named(name: str, species: Mapping[str, Species], where: str) -> Species:
    """Return a species. Raises SceneError for a name that is not there."""
    if name not in species:
        cure = suggest(name, species)
        if not cure and len(name) == 1:
            cure = f"; in a sequence, names of several capitals or with digits need commas or stars: '{name}…*10'"
        raise SceneError(f"is no species{cure}; there are {', '.join(species)}", path=where, word=name)
    return species[name]


def law_of(block: Kind, names: tuple[str, ...], laws: Laws, molecule: str) -> tuple[str, tuple[float, ...]] | None:
    """Return key and numbers for beads of these species, or None for an angle without a law.

    Raises:
        SceneError: a bond without a law, an unknown law, or numbers that are none.
    """
    found = None
    for key, law in laws.items():
        wanted = names_of(key, _MEMBERS[block], block)
        if wanted in (names, names[::-1]):
            found = law
            break
        if not wanted:
            found = law
    if found is None:
        if block == "angles":
            return None
        message = f"molecule {molecule}: no law for a bond between {names[0]} and {names[1]}; give one, or one for *"
        raise SceneError(message, path=block, word=" ".join(names))
    return _read_law(block, names, found)


def _read_law(block: Kind, names: tuple[str, ...], law: Sequence[str | float]) -> tuple[str, tuple[float, ...]]:
    word = " ".join(names)
    if isinstance(law, str) or not law or not isinstance(law[0], str):
        raise SceneError("expected a law's key and its numbers, as in ('harm', 128.0, 0.5)", path=block, word=word)
    key = law[0].lower()
    if key not in BONDED[block].keys:
        raise SceneError(f"{key} is no key of FIELD's {block}{suggest(key, BONDED[block].keys)}", path=block, word=word)
    try:
        return key, tuple(float(x) for x in law[1:])
    except (TypeError, ValueError):
        raise SceneError(f"after the key {key} only numbers can follow", path=block, word=word) from None


def _law_record(block: Kind, key: str) -> Any:
    # The scene imports parts of this package.
    from pydlpoly.scene.bonded_laws import KINDS, bonded_laws

    return bonded_laws().get((KINDS[block], key))


def _restraint(block: Kind, key: str) -> str:
    law = _law_record(block, key)
    return law.restraint_key if law is not None and law.restraint_key else key


def bond_lengths(molecule: MoleculeType, laws: Laws, spacing: float) -> FloatArray:
    """Return (beads,) how far each bead is placed from the one it hangs on, in the order of ``molecule.tree()``.

    It is the law's r0 where that is above 0, otherwise ``spacing``, for FENE at most half the largest length.
    """
    lengths = np.full(len(molecule.beads), spacing)
    for order, (bead, parent) in enumerate(molecule.tree()):
        if parent >= 0:
            lengths[order] = built_length((molecule.beads[parent], molecule.beads[bead]), laws, molecule.name, spacing)
    return lengths


def built_length(names: tuple[str, ...], laws: Laws, molecule: str, spacing: float) -> float:
    """Return the length a bond between these species is built with; see ``bond_lengths``."""
    law = law_of("bonds", names, laws, molecule)
    record = None if law is None else _law_record("bonds", law[0])
    if law is None or record is None:
        return spacing
    numbers: dict[str, float] = dict(zip(record.parameter_names, law[1], strict=False))
    if numbers.get("r0", 0.0) > 0.0:
        return numbers["r0"]
    if numbers.get("R0", 0.0) > 0.0:
        return min(spacing, numbers.get("D", 0.0) + _OF_FENE * numbers["R0"])
    return spacing


def pair_records(
    pairs: Mapping[Any, Any], used: Iterable[str], species: Iterable[str], *, mixing: bool = False
) -> tuple[tuple[PairLine, ...], float]:
    """Return FIELD's ``vdw`` records for a table of pairs, and the longest cutoff of the dpd laws in it (0: none).

    Args:
        pairs: by species, a law with its numbers ``("dpd", 25.0, 1.0, 4.5)``, or a mapping with a, cutoff and drag of
            the dpd law, or a alone; ``"*"`` for all pairs not given, and for the numbers that a mapping leaves out.
        used: names of the species that the molecules have, in FIELD's order.
        species: names of all species; laws for those that are not used are left out.
        mixing: pairs that are not given are left to a mixing rule.

    Raises:
        SceneError: a pair without a law, an unknown species or word, or numbers that are missing.
    """
    names, known = list(used), list(species)
    default = pairs.get("*")
    given: dict[tuple[str, str], Sequence[str | float]] = {}
    for key, value in pairs.items():
        pair = names_of(key, 2, "pairs")
        for name in pair:
            if name not in known:
                raise SceneError(f"{name} is no species{suggest(name, known)}", path="pairs", word=str(key))
        if pair and all(name in names for name in pair):
            first, second = sorted(pair, key=names.index)
            if (first, second) in given:
                raise SceneError("this pair is given twice", path="pairs", word=f"{first} {second}")
            given[first, second] = _pair_law(value, default, f"{first} {second}")
    missing = [pair for pair in combinations_with_replacement(names, 2) if pair not in given]
    if missing and default is not None:
        given |= {pair: _pair_law({} if isinstance(default, Mapping) else default, default, "*") for pair in missing}
    elif missing and not mixing:
        texts = ", ".join(" ".join(pair) for pair in missing)
        raise SceneError(f"no law for {texts}; give one for *, or a mixing rule", path="pairs")
    ordered = {pair: given[pair] for pair in combinations_with_replacement(names, 2) if pair in given}
    cutoffs = [float(law[2]) for law in ordered.values() if law[0] == "dpd" and len(law) > 2]
    return pair_lines(ordered), max(cutoffs, default=0.0)


def _pair_law(value: Any, default: Any, word: str) -> Sequence[str | float]:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        value = {"a": value}
    if not isinstance(value, Mapping):
        if isinstance(value, str) or not isinstance(value, Sequence):
            raise SceneError("expected a law with its numbers, or a, cutoff and drag", path="pairs", word=word)
        return value
    unknown = next((name for name in value if name not in _DPD), None)
    if unknown is not None:
        message = f"{unknown} is not known; expected {', '.join(_DPD)}{suggest(str(unknown), _DPD)}"
        raise SceneError(message, path="pairs", word=word)
    merged = {**(default if isinstance(default, Mapping) else {}), **value}
    # The drag can come from elsewhere (CONTROL's ensemble_dpd_drag), the other two cannot.
    absent = next((name for name in _DPD[:2] if name not in merged), None)
    if absent is not None:
        raise SceneError(f"{absent} is missing here and in *", path="pairs", word=word)
    return ("dpd", *(merged[name] for name in _DPD if name in merged))


def least_distances(given: float | Mapping[Any, float], used: Sequence[str], species: Iterable[str]) -> FloatArray:
    """Return (used, used) least distances from one number, or from a table by pairs with ``"*"`` for the others.

    Raises:
        SceneError: an unknown species or a negative distance.
    """
    table = given if isinstance(given, Mapping) else {"*": given}
    numbers, known, where = {name: k for k, name in enumerate(used)}, list(species), "minimum_distance"
    result = np.full((len(numbers), len(numbers)), float(table.get("*", 0.0)))
    for key, value in table.items():
        if not float(value) >= 0.0:
            raise SceneError(f"a least distance must not be negative, not {value}", path=where, word=str(key))
        pair = names_of(key, 2, where)
        for name in pair:
            if name not in known:
                raise SceneError(f"{name} is no species{suggest(name, known)}", path=where, word=str(key))
        if pair and all(name in numbers for name in pair):
            i, j = (numbers[name] for name in pair)
            result[i, j] = result[j, i] = float(value)
    return result
