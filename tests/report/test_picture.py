"""Pictures: which beads are drawn, in which order, where, and how many at most."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pydlpoly.drawing import look
from pydlpoly.report import picture
from pydlpoly.report.collect import Run
from pydlpoly.report.snapshots import Snapshot, of_scene
from pydlpoly.report.style import svg
from pydlpoly.scene import Scene, load

from ..run_folders import run_folder


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    return load(run_folder(tmp_path_factory.mktemp("picture")))


def snapshot(positions: np.ndarray, kinds: list[int], cell: np.ndarray, periodic=(True, True, True)) -> Snapshot:
    names = tuple("ABCDEFGHIJ"[: max(kinds) + 1])
    return Snapshot("made", 3, names, np.array(kinds), np.asarray(positions, dtype=float), cell, periodic)


def run_with(one: Snapshot) -> Run:
    return Run(Path("made"), last=one, files={"STATIS": Path("STATIS")})


def drawn(one: Snapshot, scene: Scene | None = None) -> picture.Drawing:
    with look():
        drawing = picture.last_frame(replace(run_with(one), scene=scene))
    assert drawing is not None
    return drawing


def test_the_most_abundant_single_beads_are_hidden(scene: Scene) -> None:
    one = of_scene(scene)
    run = replace(run_with(one), scene=scene)
    assert picture.hidden_species(run, one) == "A"
    beads = scene.beads
    charged = replace(scene, beads=replace(beads, charge=np.where(beads.species == 0, 1.0, 0.0)))
    assert picture.hidden_species(replace(run, scene=charged), one) == "B"
    frozen = replace(scene, beads=replace(beads, frozen=np.ones(len(beads), dtype=bool)))
    assert picture.hidden_species(replace(run, scene=frozen), one) is None
    pairs = replace(scene, beads=replace(beads, molecule=beads.molecule // 2))
    assert picture.hidden_species(replace(run, scene=pairs), one) is None
    wall = replace(scene, beads=replace(beads, frozen=beads.species == 1))
    assert picture.hidden_species(replace(run, scene=wall), one) is None  # a liquid on it is all there is to see
    alone = replace(scene, beads=replace(beads, species=np.zeros_like(beads.species)))
    assert picture.hidden_species(replace(run, scene=alone), one) is None
    assert picture.hidden_species(run_with(one), one) is None  # without FIELD it is not known


def test_hidden_beads_are_not_painted(scene: Scene) -> None:
    drawing = drawn(of_scene(scene), scene)
    assert "A, the most abundant species of single beads, is not drawn" in drawing.caption
    (beads,) = [one for one in drawing.figure.axes[0].collections if one.get_rasterized()]
    assert len(np.unique(beads.get_offsets(), axis=0)) == 40  # those of B
    legend = drawing.figure.axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["B"]


def test_nearer_beads_are_painted_later_and_darker() -> None:
    right, up, towards = picture._axes_of_view()
    np.testing.assert_allclose(np.stack([right, up, towards]) @ np.stack([right, up, towards]).T, np.eye(3), atol=1e-12)
    assert np.linalg.det(np.stack([right, up, towards])) == pytest.approx(1.0)
    assert up[2] > 0.9  # z points up
    places = np.array([-1.0, 1.0, 0.0, 0.5])[:, None] * towards
    drawing = drawn(snapshot(places, [0, 0, 0, 0], 4.0 * np.eye(3)))
    (beads,) = [one for one in drawing.figure.axes[0].collections if one.get_rasterized()]
    faces = beads.get_facecolors()[:, :3]
    assert np.all(np.diff(faces[:, 0]) < 0.0)  # the last one is the darkest
    view = picture.view_of(places, np.array([0, 1, 2, 3]))
    assert view.kinds.tolist() == [0, 2, 3, 1]
    assert view.near.tolist() == pytest.approx([0.0, 0.5, 0.75, 1.0])
    beside = picture.view_of(np.stack([right, up]), np.array([0, 1]))
    np.testing.assert_allclose(beside.places[np.argsort(beside.kinds)], np.eye(2), atol=1e-12)


def test_beads_outside_come_back_into_a_triclinic_cell() -> None:
    cell = np.array([[4.0, 0.0, 0.0], [1.0, 5.0, 0.0], [0.5, 0.5, 6.0]])
    inside = np.array([[0.1, -0.2, 0.3], [-0.4, 0.4, -0.45]]) @ cell
    moved = inside + np.array([[2, -1, 3], [0, 1, -2]]) @ cell
    np.testing.assert_allclose(picture.wrapped(snapshot(moved, [0, 0], cell)), inside, atol=1e-9)
    slab = picture.wrapped(snapshot(moved, [0, 0], cell, (True, True, False)))
    np.testing.assert_allclose(
        slab @ np.linalg.inv(cell) - inside @ np.linalg.inv(cell), [[0, 0, 3], [0, 0, -2]], atol=1e-9
    )


@pytest.mark.parametrize(
    "cell", [np.zeros((3, 3)), np.diag([4.0, 4.0, 40.0]), np.array([[4, 0, 0], [2, 4, 0], [2, 2, 4.0]])]
)
def test_any_cell_and_up_to_ten_species_are_drawn(cell: np.ndarray) -> None:
    places = np.random.default_rng(1).standard_normal((60, 3))
    kinds = [k % 10 for k in range(60)]
    one = snapshot(places, kinds, cell, (bool(cell.any()),) * 3)
    drawing = drawn(one)
    text = svg(drawing.figure, "last")
    assert text.count("<image") == 1
    assert "data:image/png;base64," in text
    low, high = drawing.figure.axes[0].get_xlim()
    beads = picture.view_of(picture.wrapped(one), np.array(kinds))
    assert low < beads.places[:, 0].min() < beads.places[:, 0].max() < high


def test_at_most_so_many_beads_and_a_small_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(picture, "MOST_BEADS", 500)
    places = np.random.default_rng(1).random((2000, 3)) * 10.0 - 5.0
    drawing = drawn(snapshot(places, [0] * 2000, 10.0 * np.eye(3)))
    assert "Of 2000 beads the 500 nearest to the viewer are drawn" in drawing.caption
    assert len(svg(drawing.figure, "last")) < 600_000


def test_positions_that_are_not_finite() -> None:
    places = np.array([[0.0, 0.0, 0.0], [np.nan, 0.0, 0.0], [1.0, 1.0, 1.0]])
    assert "1 beads have no finite position" in drawn(snapshot(places, [0, 0, 0], 4.0 * np.eye(3))).caption
    with look():
        assert picture.last_frame(run_with(snapshot(places[1:2], [0], 4.0 * np.eye(3)))) is None
