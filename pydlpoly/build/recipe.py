"""Recipes: the description that ``build`` takes, as a TOML file."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import Any

from pydlpoly.build.amounts import Component, Salt, as_molecule
from pydlpoly.build.assembly import Bilayer, Lamella
from pydlpoly.build.molecules import MoleculeType, Species, chain, comb, graph, lipid, ring, star
from pydlpoly.build.regions import Cylinder, Outside, Region, Slab, Sphere
from pydlpoly.build.system import Built, Part, build
from pydlpoly.build.topology import species_named
from pydlpoly.errors import InputError, SceneError, suggest
from pydlpoly.formats.atomic import read_text

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_NUMBER, _LIST, _TEXT, _WHOLE, _SWITCH, _TABLE = (
    "a number",
    "a list",
    "text",
    "a whole number",
    "true or false",
    "a table",
)

_TOP = {
    "title": _TEXT,
    "seed": _WHOLE,
    "units": _TEXT,
    "box": _TABLE,
    "species": _TABLE,
    "molecules": _LIST,
    "pairs": _TABLE,
    "bonds": _TABLE,
    "angles": _TABLE,
    "minimum_distance": "",
    "neutralise": _LIST,
    "run": _TABLE,
}
_BOX = {"edge": _NUMBER, "edges": _LIST, "cell": _LIST, "density": _NUMBER, "length": _NUMBER}
_SPECIES = {"mass": _NUMBER, "charge": _NUMBER, "frozen": _SWITCH}
_AMOUNT = {"count": _WHOLE, "fraction": _NUMBER, "concentration": _NUMBER, "fill": _SWITCH}
_WHAT = {"species": _TEXT, "sequence": _TEXT, "ring": _TEXT, "star": _TABLE, "comb": _TABLE, "lipid": _TABLE}
_WHAT |= {"graph": _TABLE, "salt": _TABLE}
_HOW = {"region": _TABLE, "shape": _TEXT, "turn": _NUMBER, "bilayer": _TABLE, "lamella": _TABLE}
_STAR = {"core": _TEXT, "arm": _TEXT, "arms": _WHOLE}
_COMB = {"backbone": _TEXT, "side": _TEXT, "spacing": _WHOLE, "first": _WHOLE}
_LIPID = {"head": _TEXT, "tail": _TEXT, "tails": _WHOLE, "spread": _SWITCH}
_GRAPH = {"beads": _TEXT, "bonds": _TEXT, "places": _LIST}
_SALT = {"cation": _TEXT, "anion": _TEXT, "number": _WHOLE, "concentration": _NUMBER}
_BILAYER = {"area": _NUMBER, "count": _WHOLE, "centre": _NUMBER}
_LAMELLA = {"periods": _WHOLE}
_REGION = {"slab": _LIST, "sphere": _NUMBER, "cylinder": _NUMBER, "axis": _TEXT, "centre": _LIST, "outside": _SWITCH}


def example_recipes() -> list[str]:
    """Return the names of the shipped recipes."""
    folder = resources.files("pydlpoly") / "build" / "recipes"
    return sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml"))


def example_recipe(name: str) -> Path:
    """Return the file of a shipped recipe. Raises InputError for an unknown name, with the names there are."""
    names = example_recipes()
    if name not in names:
        raise InputError(f"there is no such recipe; there are {', '.join(names)}{suggest(name, names)}", word=name)
    return Path(str(resources.files("pydlpoly") / "build" / "recipes" / f"{name}.toml"))


def build_recipe(path: str | Path, *, seed: int | None = None) -> Built:
    """Return what a recipe describes; see docs/build.md for its tables.

    Args:
        path: a TOML file.
        seed: of all places, in place of the recipe's.

    Raises:
        InputError: the file cannot be read, or has a table or key that is unknown or of the wrong kind.
        SceneError: what it describes cannot be built. Both name the file and, where there is one, table and key.
    """
    name = str(path)
    try:
        text = read_text(path)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", path=name) from error
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"is no TOML file: {error}", path=name) from error
    with _in_file(name):
        return _build(table, seed)


@contextmanager
def _in_file(name: str) -> Iterator[None]:
    """Put the file's name in front of the place that an error names."""
    try:
        yield
    except InputError as error:
        place = ".".join(part for part in (error.path, error.word) if part)
        raise type(error)(error.message, path=name, line=None, word=place or None) from None


def _build(table: Mapping[str, Any], seed: int | None) -> Built:
    _check(table, _TOP, "")
    box = _check(table.get("box", {}), _BOX, "box")
    for required in ("box", "species", "molecules"):
        if required not in table:
            raise InputError("this table is missing", word=required)
    shapes = [key for key in ("edge", "edges", "cell") if key in box]
    if len(shapes) != 1:
        raise InputError("give exactly one of edge, edges and cell", word="box")
    species = [_species(name, values) for name, values in table["species"].items()]
    parts = [_part(entry, f"molecules[{k}]", species) for k, entry in enumerate(table["molecules"], 1)]
    with _in_molecules(parts):
        return _made(table, box, box[shapes[0]], species, parts, seed)


@contextmanager
def _in_molecules(parts: Sequence[Part]) -> Iterator[None]:
    """Name the table of a molecule where an error names the molecule alone."""
    try:
        yield
    except InputError as error:
        names = [as_molecule(part.molecule).name if hasattr(part, "molecule") else "" for part in parts]
        if error.path or error.word not in names:
            raise
        place = f"molecules[{names.index(error.word) + 1}]"
        raise type(error)(f"molecule {error.word}: {error.message}", word=place) from None


def _made(
    table: Mapping[str, Any],
    box: Mapping[str, Any],
    shape: Any,
    species: list[Species],
    parts: list[Part],
    seed: int | None,
) -> Built:
    bonds, exclude = _laws(table.get("bonds", {}), "bonds")
    pairs = dict(table.get("pairs", {}))
    mixing = pairs.pop("mixing", None)
    if mixing is not None and not isinstance(mixing, str):
        raise InputError("expected text", path="pairs", word="mixing")
    return build(
        box=shape,
        species=species,
        molecules=parts,
        pairs=pairs,
        bonds=bonds,
        angles=_laws(table.get("angles", {}), "angles")[0],
        density=box.get("density"),
        length=box.get("length"),
        mixing=mixing,
        exclude_bonded=exclude,
        minimum_distance=_distances(table.get("minimum_distance", 0.0)),
        neutralise=[_text(ion, "neutralise") for ion in table.get("neutralise", [])],
        run=table.get("run", {}),
        units=table.get("units", "dpd"),
        title=table.get("title", "built by pydlpoly"),
        seed=seed if seed is not None else int(table.get("seed", 1)),
    )


def _check(table: Any, keys: Mapping[str, str], where: str) -> Mapping[str, Any]:
    """Return the table when its keys are known and their values of the right kind."""
    if not isinstance(table, Mapping):
        raise InputError("expected a table", word=where)
    kinds: dict[str, tuple[type, ...]] = {
        _NUMBER: (int, float),
        _WHOLE: (int,),
        _TEXT: (str,),
        _LIST: (list,),
        _SWITCH: (bool,),
        _TABLE: (dict,),
    }
    for key, value in table.items():
        if key not in keys:
            raise InputError(f"is unknown; expected {', '.join(keys)}{suggest(key, keys)}", path=where, word=key)
        kind = keys[key]
        wrong = kind and not isinstance(value, kinds[kind])
        if wrong or (isinstance(value, bool) and kind in (_NUMBER, _WHOLE)):
            raise InputError(f"expected {kind}, not {value!r}", path=where, word=key)
    return table


def _species(name: str, values: Any) -> Species:
    return Species(name, **_check(values, _SPECIES, f"species.{name}"))


def _laws(table: Mapping[str, Any], where: str) -> tuple[dict[str, Sequence[str | float]], bool]:
    """Return the laws by species, and whether bonded beads are to be excluded from pair forces."""
    laws = dict(table)
    exclude = laws.pop("exclude", False) if where == "bonds" else False
    if not isinstance(exclude, bool):
        raise InputError("expected true or false", path=where, word="exclude")
    for key, law in laws.items():
        if not isinstance(law, list):
            raise InputError(
                f'expected a law and its numbers, as in ["harm", 128.0, 0.5], not {law!r}', path=where, word=key
            )
    return laws, exclude


def _distances(given: Any) -> float | Mapping[str, float]:
    table = given if isinstance(given, Mapping) else {"*": given}
    for key, value in table.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(f"expected a number, not {value!r}", path="minimum_distance", word=key)
    return table


def _part(entry: Any, where: str, species: Sequence[Species]) -> Part:
    table = _check(entry, {"name": _TEXT, **_WHAT, **_AMOUNT, **_HOW}, where)
    what = [key for key in _WHAT if key in table]
    if len(what) != 1:
        raise InputError(f"give exactly one of {', '.join(_WHAT)}", word=where)
    if what == ["salt"]:
        _only(table, ("salt",), where)
        salt = _required(table["salt"], _SALT, ("cation", "anion"), f"{where}.salt")
        _known((salt["cation"], salt["anion"]), species, f"{where}.salt")
        return Salt(**salt)
    molecule = _molecule(table, what[0], where)
    _known(molecule.beads, species, f"{where}.{what[0]}")
    for layer, keys, make in (("bilayer", _BILAYER, Bilayer), ("lamella", _LAMELLA, Lamella)):
        if layer in table:
            _only(table, ("name", what[0], layer), where)
            return make(molecule, **_check(table[layer], keys, f"{where}.{layer}"))
    region = _region(table["region"], f"{where}.region") if "region" in table else None
    amount = {key: table[key] for key in _AMOUNT if key in table}
    return Component(molecule, region=region, shape=table.get("shape"), turn=table.get("turn"), **amount)


def _molecule(table: Mapping[str, Any], what: str, where: str) -> MoleculeType:
    if what == "species":
        return MoleculeType(table.get("name", table["species"]), (table["species"],))
    if "name" not in table:
        raise InputError("the molecule needs a name", path=where, word="name")
    name, value, place = table["name"], table[what], f"{where}.{what}"
    readers: dict[str, Callable[[], MoleculeType]] = {
        "sequence": lambda: chain(name, value),
        "ring": lambda: ring(name, value),
        "star": lambda: star(name, **_required(value, _STAR, tuple(_STAR), place)),
        "comb": lambda: comb(name, **_required(value, _COMB, ("backbone", "side"), place)),
        "lipid": lambda: lipid(name, **_required(value, _LIPID, ("head", "tail"), place)),
        "graph": lambda: graph(name, **_required(value, _GRAPH, ("beads",), place)),
    }
    try:
        return readers[what]()
    except SceneError as error:
        raise SceneError(error.message, word=place) from None


def _known(names: Sequence[str], species: Sequence[Species], where: str) -> None:
    for name in names:
        species_named(name, {kind.name: kind for kind in species}, where)


def _required(table: Any, keys: Mapping[str, str], required: Sequence[str], where: str) -> Mapping[str, Any]:
    checked = _check(table, keys, where)
    for key in required:
        if key not in checked:
            raise InputError("is missing", path=where, word=key)
    return checked


def _only(table: Mapping[str, Any], allowed: Sequence[str], where: str) -> None:
    for key in table:
        if key not in allowed:
            raise InputError(f"has no meaning beside {allowed[-1]}", path=where, word=key)


def _region(given: Any, where: str) -> Region:
    table = _check(given, _REGION, where)
    shapes = [key for key in ("slab", "sphere", "cylinder") if key in table]
    if len(shapes) != 1:
        raise InputError("give exactly one of slab, sphere and cylinder", word=where)
    shape = shapes[0]
    unused = {"slab": ("centre",), "sphere": ("axis",), "cylinder": ()}[shape]
    _only(table, [key for key in _REGION if key not in unused and key not in shapes] + [shape], where)
    centre = _three(table["centre"], f"{where}.centre") if "centre" in table else (0.0, 0.0, 0.0)
    axis = table.get("axis", "z")
    region: Region
    if shape == "slab":
        if len(table["slab"]) != 2 or not all(_is_number(x) for x in table["slab"]):
            raise InputError("expected two heights, as in [-2.0, 2.0]", path=where, word="slab")
        region = Slab(float(table["slab"][0]), float(table["slab"][1]), axis)
    elif shape == "sphere":
        region = Sphere(float(table["sphere"]), centre)
    else:
        region = Cylinder(float(table["cylinder"]), axis, centre)
    return Outside((region,)) if table.get("outside", False) else region


def _three(given: Sequence[Any], where: str) -> tuple[float, float, float]:
    if len(given) != 3 or not all(_is_number(x) for x in given):
        raise InputError("expected three numbers", word=where)
    x, y, z = given
    return float(x), float(y), float(z)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise InputError(f"expected text, not {value!r}", word=where)
    return value
