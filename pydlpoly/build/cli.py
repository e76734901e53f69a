"""``pydlpoly build``: from a recipe to CONTROL, FIELD and CONFIG."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

_FILES = ("CONTROL", "FIELD", "CONFIG")

Recipe = Annotated[Path | None, typer.Argument(help="A TOML file; docs/build.md has its tables.", show_default=False)]


def build(
    recipe: Recipe = None,
    *,
    example: Annotated[str | None, typer.Option(help="Use a shipped recipe; its file is written, too.")] = None,
    list_recipes: Annotated[bool, typer.Option("--list", help="Print the shipped recipes and stop.")] = False,
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the files.")] = Path(),
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of all places in place of the recipe's.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace files that are there.")] = False,
) -> None:
    """Build a configuration with its force field: CONTROL, FIELD and CONFIG from a small recipe."""
    from pydlpoly.build.recipe import build_recipe, example_recipe, example_recipes
    from pydlpoly.errors import InputError
    from pydlpoly.formats.atomic import read_text, replace_file

    if list_recipes:
        for name in example_recipes():
            title = read_text(example_recipe(name)).split("\n", 1)[0].removeprefix("#").strip()
            typer.echo(f"{name:16} {title}")
        return
    if (recipe is None) == (example is None):
        raise typer.BadParameter("give either a recipe, or --example NAME")
    path = recipe if recipe is not None else example_recipe(str(example))
    files = _FILES if example is None else (*_FILES, path.name)
    there = [name for name in files if (output / name).exists()]
    if there and not force:
        message = f"{', '.join(there)} would be replaced; choose another folder with -o, or say --force"
        raise InputError(message, path=str(output))
    built = build_recipe(path, seed=seed)
    scene = built.scene()  # every refusal comes before anything is written
    folder = built.write(output)
    if example is not None:
        replace_file(folder / path.name, read_text(path))
    typer.echo(built.report())
    for note in scene.notes:
        if note.kind == "warning" and note.text not in built.warnings:
            typer.echo(f"warning: {note.text}")
    typer.echo(f"files in {folder}; run them with: pydlpoly run {folder}")
