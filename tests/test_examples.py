"""The shipped examples: installed with the package, understood without surprises, and they run."""

from __future__ import annotations

import runpy
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import InputError, load
from pydlpoly.cli import example_folder, example_names
from pydlpoly.formats.config import read_config
from pydlpoly.formats.statis import read_statistics
from pydlpoly.runner import run_scene

SOURCE = Path(__file__).resolve().parents[1] / "pydlpoly" / "examples"
NAMES = sorted(folder.name for folder in SOURCE.iterdir() if (folder / "CONTROL").is_file())


def test_there_are_examples() -> None:
    assert {"argon", "lipid", "mixture", "water"} <= set(NAMES)


def test_the_lipid_example_is_what_its_script_writes() -> None:
    script = runpy.run_path(str(SOURCE.parents[1] / "docs" / "make_lipid_example.py"))
    for name, text in script["files"]().items():
        assert (SOURCE / "lipid" / name).read_text(encoding="utf-8") == text


def test_the_lipid_example_has_a_bilayer(tmp_path: Path) -> None:
    """After 2 time units the heads still lie between tails and water, and the bonds have their length."""
    scene = load(example_folder("lipid"))
    simulation = run_scene(scene, tmp_path, steps=200, seed=1, threads=1).simulation
    heights = np.abs(simulation.state.positions[:, 2])
    head, tail, water = (heights[scene.beads.species == k].mean() for k in range(3))
    assert tail < head < water
    energy = simulation.energy["bond"] / 960
    assert 0.3 < energy < 0.9, "near k_B T / 2 and what the pair forces add"


def test_installed_examples_are_those_of_the_sources() -> None:
    assert example_names() == NAMES
    for name in NAMES:
        installed = resources.files("pydlpoly") / "examples" / name
        files = {path.name: path.read_bytes() for path in (SOURCE / name).iterdir()}
        assert {"CONTROL", "FIELD", "CONFIG"} <= set(files)
        assert {entry.name: entry.read_bytes() for entry in installed.iterdir()} == files


def test_the_heat_example_is_what_its_script_writes() -> None:
    script = runpy.run_path(str(SOURCE.parents[1] / "docs" / "make_heat_example.py"))
    for name, text in script["files"]().items():
        assert (SOURCE / "heat" / name).read_text(encoding="utf-8") == text


@pytest.mark.parametrize("name", NAMES)
def test_example_is_understood(name: str) -> None:
    scene = load(example_folder(name))
    assert scene.bead_count >= 500, "enough beads for an average"
    assert scene.title
    text = scene.explain()
    assert scene.title in text
    assert all(species in text for species in scene.species)
    assert not [note for note in scene.notes if note.kind != "choice"], "an example is no place for warnings"


@pytest.mark.parametrize("name", NAMES)
def test_example_runs(name: str, tmp_path: Path) -> None:
    scene = load(example_folder(name))
    result = run_scene(scene, tmp_path, steps=20, seed=1, threads=1)
    assert not result.interrupted
    assert result.simulation.step == result.summary.steps == 20
    seen = result.simulation.observe()
    assert np.isfinite([seen.temperature, seen.pressure, *seen.energy.values()]).all()
    assert seen.temperature > 0.0
    last = read_config(tmp_path / "REVCON")
    assert last.level == 2
    assert last.step == 20
    assert len(last.names) == scene.bead_count
    table = read_statistics(tmp_path / "STATIS")
    assert table.step[0] == 0
    assert table.step[-1] == 20
    assert all((tmp_path / file).stat().st_size for file in ("OUTPUT", "REVIVE"))


def test_an_unknown_example_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(InputError, match=r"there are argon, .*did you mean water\?"):
        example_folder("watter")
