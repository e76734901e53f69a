"""The shipped examples and ``pydlpoly examples``, which lists and copies them.

An example is a folder of ``pydlpoly/examples``. It holds CONTROL, FIELD and CONFIG, or an ``example.toml`` that names a
recipe of ``pydlpoly build``, from which the files are made. ``example.toml`` may also say more about the example:

* ``shows``: what there is to see, in one line (without it, the title of CONTROL);
* ``cost``: wall time of the whole run over that of ``water``;
* ``recipe`` and ``beads``: for an example without files;
* ``[picture]``: how ``docs/gallery.py`` draws it.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Annotated, Any

import typer

from pydlpoly.errors import InputError, suggest
from pydlpoly.formats.atomic import read_text, replace_file
from pydlpoly.formats.control import read_control
from pydlpoly.formats.field import read_field

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_FILES = ("CONTROL", "FIELD", "CONFIG")
_TABLE = "example.toml"


@dataclass(frozen=True)
class Example:
    """A shipped example.

    Attributes:
        name: what it is called on the command line.
        folder: where it is kept.
        shows: what there is to see, in one line.
        beads: number of beads.
        cost: wall time of the whole run over that of ``water``; None where nobody has measured it.
        recipe: the recipe of ``pydlpoly build`` that it is made from, empty when it is kept as files.
        picture: the table ``picture`` of its ``example.toml``.
    """

    name: str
    folder: Path
    shows: str
    beads: int
    cost: float | None = None
    recipe: str = ""
    picture: Mapping[str, Any] = field(default_factory=dict)

    def texts(self) -> dict[str, str]:
        """Return the files of the example by name: those that are kept, or those that its recipe makes."""
        if not self.recipe:
            return {path.name: read_text(path) for path in sorted(self.folder.iterdir()) if path.name != _TABLE}
        from tempfile import TemporaryDirectory

        from pydlpoly.build.recipe import build_recipe, example_recipe

        recipe = example_recipe(self.recipe)
        with TemporaryDirectory() as folder:
            written = build_recipe(recipe).write(folder)
            return {recipe.name: read_text(recipe), **{name: read_text(written / name) for name in _FILES}}


def gallery() -> list[Example]:
    """Return all shipped examples by name, those that are made from recipes among them."""
    entries = (resources.files("pydlpoly") / "examples").iterdir()
    folders = sorted(Path(str(entry)) for entry in entries if entry.is_dir())
    return [_example(folder) for folder in folders if (folder / "CONTROL").is_file() or (folder / _TABLE).is_file()]


def _example(folder: Path) -> Example:
    path = folder / _TABLE
    table = tomllib.loads(read_text(path)) if path.is_file() else {}
    recipe = table.get("recipe", "")
    return Example(
        folder.name,
        folder,
        table.get("shows") or read_control(folder / "CONTROL").title,
        table["beads"] if recipe else read_field(folder / "FIELD").bead_count,
        table.get("cost"),
        recipe,
        table.get("picture", {}),
    )


def example_names() -> list[str]:
    """Return the names of the examples that are kept as files and run where they are."""
    folder = resources.files("pydlpoly") / "examples"
    return sorted(entry.name for entry in folder.iterdir() if (entry / "CONTROL").is_file())


def example_folder(name: str) -> Path:
    """Return the folder of an example that is kept as files. Raises InputError for another name."""
    if name not in example_names():
        if any(one.name == name for one in gallery()):
            raise InputError(f"is made from a recipe; write its files with: pydlpoly examples {name}", word=name)
        known = ", ".join(example_names())
        raise InputError(f"there is no such example; there are {known}{suggest(name, example_names())}", word=name)
    return Path(str(resources.files("pydlpoly") / "examples" / name))


# -- The command ------------------------------------------------------------------------------------------------------


def examples(
    name: Annotated[str | None, typer.Argument(help="The example to copy; without it they are listed.")] = None,
    *,
    everything: Annotated[
        bool, typer.Option("--all", help="Copy every example, each to a folder of its name.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder for the files (default: NAME; with --all the current one)."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace files that are there.")] = False,
) -> None:
    """List the shipped examples, or copy one or all of them."""
    if name is not None and everything:
        raise typer.BadParameter("give either a NAME or --all, not both")
    every = gallery()
    if everything:
        folder = Path() if output is None else output
        _copy({folder / one.name: one for one in every}, force=force)
    elif name is not None:
        chosen = next((one for one in every if one.name == name), None)
        if chosen is None:
            names = [one.name for one in every]
            raise InputError(f"there is no such example; there are {', '.join(names)}{suggest(name, names)}", word=name)
        _copy({Path(name) if output is None else output: chosen}, force=force)
    elif output is not None:
        raise typer.BadParameter("name the example to copy, or say --all", param_hint="--output")
    else:
        for line in listing(every):
            typer.echo(line)


def listing(every: list[Example]) -> list[str]:
    """Return the lines that list examples: name, beads, time relative to water, and what there is to see."""
    width = max(len(one.name) for one in every)
    head = f"{'example':{width}}  {'beads':>6}  {'time':>5}  shows"
    rows = [f"{one.name:{width}}  {one.beads:6d}  {relative_cost(one):>5}  {one.shows}" for one in every]
    return [head, *rows, "time: of the whole run, water = 1. Copy one with: pydlpoly examples NAME -o FOLDER"]


def relative_cost(one: Example) -> str:
    """Return the cost as text, a dash where it is unknown."""
    return "-" if one.cost is None else f"{one.cost:g}"


def _copy(targets: Mapping[Path, Example], *, force: bool) -> None:
    """Write the examples; whatever is in the way is found before the first file is written."""
    texts = {folder: one.texts() for folder, one in targets.items()}
    for folder, files in texts.items():
        there = [name for name in files if (folder / name).exists()]
        if there and not force:
            message = f"{', '.join(there)} would be replaced; choose another folder with -o, or say --force"
            raise InputError(message, path=str(folder))
    for folder, files in texts.items():
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            replace_file(folder / name, text)
        typer.echo(f"{targets[folder].name}: files in {folder}; run them with: pydlpoly run {folder}")
