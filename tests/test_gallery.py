"""``pydlpoly examples``: what is listed is there, copies run, nothing is replaced unasked, and pictures are drawn."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from pydlpoly import InputError, load
from pydlpoly.cli import main
from pydlpoly.gallery import Example, _example, example_folder, gallery, listing
from pydlpoly.runner import run_scene

ROOT = Path(__file__).resolve().parents[1]
EVERY = gallery()
Command = Callable[..., tuple[int, str]]


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    def run(*words: object) -> tuple[int, str]:
        monkeypatch.setattr(sys, "argv", ["pydlpoly", "examples", *(str(word) for word in words)])
        with pytest.raises(SystemExit) as caught:
            main()
        said = capsys.readouterr()
        return int(caught.value.code or 0), said.out + said.err

    return run


def test_what_the_gallery_promises_is_there() -> None:
    names = {one.name for one in EVERY}
    assert {"water", "demixing", "lamellae", "lipid", "polyelectrolyte", "poiseuille"} <= names
    folders = {folder.name for folder in (ROOT / "pydlpoly" / "examples").iterdir() if folder.is_dir()}
    assert names == folders - {"__pycache__"}


@pytest.mark.parametrize("example", EVERY, ids=lambda one: one.name)
def test_a_copy_runs(example: Example, tmp_path: Path, command: Command) -> None:
    """Few steps of every example, from files that the command wrote."""
    code, said = command(example.name, "-o", tmp_path / "in")
    assert code == 0, said
    assert said.strip() == f"{example.name}: files in {tmp_path / 'in'}; run them with: pydlpoly run {tmp_path / 'in'}"
    scene = load(tmp_path / "in")
    assert scene.bead_count == example.beads
    assert not [note for note in scene.notes if note.kind in ("warning", "ignored")]
    result = run_scene(scene, tmp_path / "out", steps=5, seed=1, threads=1)
    seen = result.simulation.observe()
    assert np.isfinite([seen.temperature, seen.pressure, *seen.energy.values()]).all()


@pytest.mark.parametrize("example", EVERY, ids=lambda one: one.name)
def test_the_table_of_an_example_is_whole(example: Example) -> None:
    assert example.shows
    assert "\n" not in example.shows
    assert example.cost is None or example.cost > 0.0
    species = {name for line in example.texts()["CONFIG"].splitlines() if (name := line.split(maxsplit=1)[0]).isalpha()}
    assert set(example.picture) <= {"steps", "along", "hide", "colour", "diameter"}
    assert example.picture.get("along", "y") in ("x", "y", "z")
    colours = ("species", "vx", "temperature", "concentration_first", "concentration_b")
    assert example.picture.get("colour", "species") in colours
    assert set(example.picture.get("hide", [])) <= species
    assert (ROOT / "docs" / "images" / f"example-{example.name}.png").is_file(), "run `python docs/gallery.py`"


def test_the_list(command: Command) -> None:
    code, said = command()
    assert code == 0
    assert said.splitlines() == listing(EVERY)
    assert len(said.splitlines()) == len(EVERY) + 2


def test_a_folder_is_enough(tmp_path: Path) -> None:
    """CONTROL, FIELD and CONFIG without a table: the title says what there is to see, the cost is unknown."""
    folder = tmp_path / "plain"
    folder.mkdir()
    for name in ("CONTROL", "FIELD", "CONFIG"):
        (folder / name).write_text((example_folder("water") / name).read_text())
    found = _example(folder)
    assert (found.name, found.beads, found.cost, found.recipe) == ("plain", 3000, None, "")
    assert found.shows.startswith("DPD water")
    assert "-  DPD water" in listing([found])[1]


def test_all_are_copied_and_nothing_is_replaced(tmp_path: Path, command: Command) -> None:
    (tmp_path / "water").mkdir()
    (tmp_path / "water" / "FIELD").write_text("mine")
    code, said = command("--all", "-o", tmp_path)
    assert code == 1
    assert "water: FIELD would be replaced" in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["water"], "nothing was written before the refusal"
    assert command("--all", "-o", tmp_path, "--force")[0] == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(one.name for one in EVERY)
    assert (tmp_path / "water" / "FIELD").read_text() == (example_folder("water") / "FIELD").read_text()
    assert not list(tmp_path.rglob("example.toml")), "the gallery's own table is no input"
    assert (tmp_path / "lamellae" / "diblock.toml").is_file(), "the recipe is beside what it made"


def test_wrong_use(tmp_path: Path, command: Command) -> None:
    code, said = command("watter")
    assert code == 1
    assert "there is no such example; there are argon, " in said
    assert "did you mean water?" in said
    assert command("water", "--all")[0] == 2
    assert command("-o", tmp_path)[0] == 2
    with pytest.raises(InputError, match="pydlpoly examples lamellae"):
        example_folder("lamellae")


def drawing() -> ModuleType:
    spec = importlib.util.spec_from_file_location("docs_gallery", ROOT / "docs" / "gallery.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("picture", [{"hide": ["W"], "along": "y"}, {"colour": "vx", "along": "z"}])
def test_a_picture_is_drawn(picture: dict[str, object]) -> None:
    pytest.importorskip("matplotlib", reason="matplotlib is not installed: pip install '.[docs]'")
    script = drawing()
    lipid = next(one for one in EVERY if one.name == "lipid")
    example = Example("lipid", lipid.folder, lipid.shows, lipid.beads, picture={**picture, "steps": 2})
    content = script.draw(example, script.run(example))
    assert content.startswith(b"\x89PNG")
    assert 5_000 < len(content) < 150_000
