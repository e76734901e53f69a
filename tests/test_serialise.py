"""Scenes through the checkpoint: taking one apart and putting it together again is the identity."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pydlpoly
from pydlpoly.cli import example_folder, example_names
from pydlpoly.errors import InputError
from pydlpoly.formats.checkpoint import read_checkpoint, write_checkpoint
from pydlpoly.scene.serialise import scene_from_arrays, scene_to_arrays

from .run_folders import run_folder
from .scene_builder import make_scene


def same(one: Any, other: Any, where: str = "scene") -> None:
    """Compare field by field, arrays with their types, without the dataclasses' own idea of equality."""
    assert type(one) is type(other), where
    if isinstance(one, np.ndarray):
        assert one.dtype == other.dtype, where
        np.testing.assert_array_equal(one, other, err_msg=where)
    elif dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            same(getattr(one, field.name), getattr(other, field.name), f"{where}.{field.name}")
    elif isinstance(one, tuple):
        assert len(one) == len(other), where
        for k, (a, b) in enumerate(zip(one, other, strict=True)):
            same(a, b, f"{where}[{k}]")
    else:
        assert one == other, where


def through_the_disk(scene: pydlpoly.Scene, path: Path) -> pydlpoly.Scene:
    arrays, data = scene_to_arrays(scene)
    write_checkpoint(path, arrays, {"scene": data})
    arrays, meta = read_checkpoint(path)
    return scene_from_arrays(arrays, meta["scene"])


def rich_scene() -> pydlpoly.Scene:
    """Three species, frozen beads, an external field, mixing, a seed of 64 bits, notes, velocities and long floats."""
    scene = make_scene(
        {"A": 30, "BB": 20, "wall": 10},
        ("A A dpd 25.000000000000004 1.0 4.5", "BB BB dpd 20.0 1.1 3.0", "wall wall dpd 10.0 0.9 2.0"),
        cell=[[5.0, 0.0, 0.0], [0.3, 5.0, 0.0], [0.1, 0.2, 6.0]],
        velocities=np.random.default_rng(3).normal(size=(60, 3)),
        frozen=("wall",),
        extern="grav 0.1 0.2 0.3",
        control={
            "vdw_mix_method": "lorentz-berthelot",
            "random_seed": "[ 99999999 12345678 87654321 ]",
            "coul_precision": "1e-5",
            "rdf_calculate": "on",
            "traj_calculate": "on",
            "traj_key": "pos-vel-force",
            "io_file_revive": "NONE",
            "stack_size": "10 steps",
        },
    )
    assert scene.notes
    assert scene.external
    assert scene.run.seed is not None
    assert scene.run.seed > 2**53
    return scene


def test_rich_scene(tmp_path: Path) -> None:
    scene = rich_scene()
    again = through_the_disk(scene, tmp_path / "c")
    same(again, scene)
    assert again.explain() == scene.explain()


def test_table_law_source_order_and_cell(tmp_path: Path) -> None:
    scene = rich_scene()
    table = np.vstack([np.linspace(3.0, 0.0, 50), np.linspace(1.0, 0.0, 50)])
    term = replace(scene.pairs[0], law="tab", table=table, table_spacing=1.0 / 3.0)
    scene = replace(
        scene,
        pairs=(term, *scene.pairs[1:]),
        source_order=np.arange(60)[::-1].copy(),
        source_cell=np.diag([1.0, 2.0, np.pi]),
    )
    same(through_the_disk(scene, tmp_path / "c"), scene)


@pytest.mark.parametrize("example", example_names())
def test_examples(tmp_path: Path, example: str) -> None:
    scene = pydlpoly.load(example_folder(example))
    same(through_the_disk(scene, tmp_path / "c"), scene)


def test_golden_cases(tmp_path: Path, shared: Path) -> None:
    """Every golden case that makes a scene: all pair laws, units, cells and external fields."""
    count = 0
    for folder in sorted((shared / "golden").iterdir()):
        if not (folder / "CONTROL").is_file():
            continue
        try:
            scene = pydlpoly.load(folder)
        except InputError:
            continue
        same(through_the_disk(scene, tmp_path / "c"), scene)
        count += 1
    assert count >= 30


def test_encoded_scene_is_plain_json(tmp_path: Path) -> None:
    _, data = scene_to_arrays(pydlpoly.load(run_folder(tmp_path)))
    assert json.loads(json.dumps(data, allow_nan=False)) == data


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data["fields"].pop("cell"), "another version"),
        (lambda data: data["fields"].update(colour="blue"), "another version"),
        (lambda data: data.update({"class": "Universe"}), "another version"),
        (lambda data: data["fields"]["cell"].update(array="nowhere"), "another version"),
        (lambda data: data.update(fields=[1, 2]), "another version"),
        (lambda data: data.update({"class": "Note", "fields": {"kind": "choice", "text": ""}}), "holds no scene"),
    ],
)
def test_foreign_data_is_refused(tmp_path: Path, change: Any, message: str) -> None:
    arrays, data = scene_to_arrays(pydlpoly.load(run_folder(tmp_path)))
    change(data)
    with pytest.raises(InputError, match=message):
        scene_from_arrays(arrays, data)
