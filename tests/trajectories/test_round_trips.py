"""What is written comes back: names and masses exactly, the rest to the precision of the format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.frame import Frame
from pydlpoly.trajectories import FORMATS, open_reader, open_writer, read, read_frame

from .frames import CELLS, TURNED, frames, topology

SINGLE = 2.0**-23
# Relative to the largest number: what a format keeps of positions, velocities, forces, and of the cell.
POSITIONS = {"history": 1e-9, "extxyz": 0.0, "gsd": SINGLE, "h5md": 0.0, "dcd": SINGLE}
DERIVED = {"history": 1e-9, "extxyz": 4e-16, "gsd": SINGLE, "h5md": 4e-16}  # momenta, and forces in other units
CELL = {"history": 1e-10, "extxyz": 0.0, "gsd": 0.0, "h5md": 0.0, "dcd": 1e-15}
OTHERS = ("extxyz", "gsd", "h5md", "dcd")


def written(path: Path, name: str, made: list[Frame], **options: object) -> Path:
    file = path / f"file{FORMATS[name].extension}"
    with open_writer(name, file, made[0], topology(len(made[0].names)), **options) as writer:
        for frame in made:
            writer.write(frame)
        writer.sync()
    return file


def near(found: np.ndarray | None, expected: np.ndarray | None, relative: float) -> None:
    assert (found is None) == (expected is None)
    if found is not None and expected is not None:
        assert found.dtype == np.float64
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=relative * np.abs(expected).max())


def check(found: Frame, expected: Frame, name: str) -> None:
    assert found.names == expected.names
    assert (found.step, found.imcon, found.timestep) == (expected.step, expected.imcon, expected.timestep)
    assert found.time == pytest.approx(expected.time, rel=0.0 if name != "dcd" else 1e-15)
    np.testing.assert_array_equal(found.indices, expected.indices)
    near(found.positions, expected.positions, POSITIONS[name])
    if name == "history":
        near(found.masses, expected.masses, 1e-8)
        near(found.charges, expected.charges, 1e-6)
    else:
        np.testing.assert_array_equal(found.masses, expected.masses)
        near(found.charges, expected.charges, SINGLE if name == "dcd" else 0.0)
    if name == "dcd":
        assert (found.velocities, found.forces, found.level) == (None, None, 0)
    else:
        assert found.level == expected.level
        near(found.velocities, expected.velocities, DERIVED[name])
        near(found.forces, expected.forces, DERIVED[name])
    cell = expected.cell if expected.imcon or name not in ("dcd",) else np.zeros((3, 3))
    near(found.cell, cell, CELL[name])
    if name in ("history", "dcd"):
        assert found.images is None
        assert not found.arrays
    else:
        np.testing.assert_array_equal(found.images, expected.images)
        assert sorted(found.arrays) == sorted(expected.arrays)
        for key, values in expected.arrays.items():
            np.testing.assert_array_equal(found.arrays[key], values)


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("imcon", CELLS)
@pytest.mark.parametrize("level", [0, 1, 2])
def test_frames_come_back(tmp_path: Path, name: str, imcon: int, level: int) -> None:
    made = frames(imcon=imcon, level=level)
    found = list(read(written(tmp_path, name, made)))
    assert len(found) == len(made)
    for one, expected in zip(found, made, strict=True):
        check(one, expected, name)


@pytest.mark.parametrize("name", FORMATS)
def test_cells_of_any_orientation_come_back(tmp_path: Path, name: str) -> None:
    """GSD and DCD turn the cell, and turn it back."""
    made = frames(cell=TURNED)
    for one, expected in zip(read(written(tmp_path, name, made)), made, strict=True):
        near(one.positions, expected.positions, 4 * POSITIONS[name])
        near(one.cell, expected.cell, 4 * CELL[name])
        if name != "dcd":
            near(one.velocities, expected.velocities, 4 * DERIVED[name])
            near(one.forces, expected.forces, 4 * DERIVED[name])


@pytest.mark.parametrize("name", ["gsd", "dcd"])
def test_left_handed_cells_are_refused_before_there_is_a_file(tmp_path: Path, name: str) -> None:
    (like,) = frames(1, cell=np.diag([4.0, -5.0, 6.0]))
    with pytest.raises(InputError, match="left-handed"):
        open_writer(name, tmp_path / "file", like)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["extxyz", "h5md"])
def test_left_handed_cells_need_no_turning(tmp_path: Path, name: str) -> None:
    made = frames(1, cell=np.diag([4.0, -5.0, 6.0]))
    (found,) = read(written(tmp_path, name, made))
    check(found, made[0], name)


@pytest.mark.parametrize("name", ["gsd", "h5md", "dcd"])
def test_what_is_said_once_comes_back(tmp_path: Path, name: str) -> None:
    expected = topology()
    found = open_reader(written(tmp_path, name, frames())).topology
    assert found.title == expected.title
    assert not found.reduced
    np.testing.assert_array_equal(found.molecules, expected.molecules)
    assert sorted(found.links) == sorted(expected.links)
    for kind, links in expected.links.items():
        np.testing.assert_array_equal(found.links[kind].beads, links.beads)
        if name != "dcd":  # a PSF has no names of them
            assert found.links[kind].names == links.names
            np.testing.assert_array_equal(found.links[kind].kinds, links.kinds)


def test_title_of_extxyz(tmp_path: Path) -> None:
    assert open_reader(written(tmp_path, "extxyz", frames())).topology.title == "frames of a test"


@pytest.mark.parametrize("name", FORMATS)
def test_single_frames(tmp_path: Path, name: str) -> None:
    file = written(tmp_path, name, frames(4))
    steps = [read_frame(file, index).step for index in (0, 2, -1, -4)]
    assert steps == [0, 20, 30, 0]
    for index in (4, -5):
        with pytest.raises(InputError, match="no such frame"):
            read_frame(file, index)


@pytest.mark.parametrize("name", FORMATS)
def test_appending(tmp_path: Path, name: str) -> None:
    written(tmp_path, name, frames(3))
    file = written(tmp_path, name, frames(2, first=3), append=True)
    assert [frame.step for frame in read(file)] == [0, 10, 20, 30, 40]
    check(read_frame(file, 3), frames(1, first=3)[0], name)


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("kept", [0, 1, 2, 3])
def test_frames_after_a_checkpoint_are_dropped(tmp_path: Path, name: str, kept: int) -> None:
    written(tmp_path, name, frames(3))
    file = written(tmp_path, name, frames(1, first=kept), append=True, keep_until=10 * kept - 5)
    assert [frame.step for frame in read(file)] == [10 * k for k in range(kept + 1)]
    check(read_frame(file, -1), frames(1, first=kept)[0], name)
    assert not [path for path in tmp_path.iterdir() if path.suffix == ".tmp"]


@pytest.mark.parametrize("name", OTHERS)
def test_appending_to_a_file_that_is_not_there_begins_one(tmp_path: Path, name: str) -> None:
    file = written(tmp_path, name, frames(1, first=7), append=True, keep_until=60)
    assert [frame.step for frame in read(file)] == [70]


@pytest.mark.parametrize("name", FORMATS)
def test_other_beads_are_refused(tmp_path: Path, name: str) -> None:
    file = written(tmp_path, name, frames(2))
    before = file.read_bytes()
    with pytest.raises(InputError, match="cannot be continued"):
        open_writer(name, file, frames(1, beads=24)[0], topology(24), append=True)
    assert file.read_bytes() == before
    with (
        open_writer(name, file, frames(1)[0], topology(), append=True) as writer,
        pytest.raises(InputError, match="other beads"),
    ):
        writer.write(frames(1, beads=24, first=2)[0])


@pytest.mark.parametrize("name", OTHERS)
def test_frames_that_hold_something_else_are_refused(tmp_path: Path, name: str) -> None:
    made = frames(1)
    file = written(tmp_path, name, made)
    with (
        open_writer(name, file, made[0], topology(), append=True) as writer,
        pytest.raises(InputError, match=r"holds .*density"),
    ):
        writer.write(frames(1, level=0, first=1)[0])


def test_unequal_intervals_are_refused_by_dcd(tmp_path: Path) -> None:
    with open_writer("dcd", tmp_path / "file.dcd", frames(1)[0], topology()) as writer:
        for frame in frames(2):
            writer.write(frame)
        with pytest.raises(InputError, match="frame 3 is of step 20, not 30"):
            writer.write(frames(1, first=3)[0])


def test_steps_and_times_are_exact_where_there_is_room(tmp_path: Path) -> None:
    from dataclasses import replace

    made = [replace(frames(1)[0], step=10**12 + k, time=0.1 + 0.2 * k, timestep=1.0 / 3.0) for k in range(2)]
    for name in ("extxyz", "gsd", "h5md"):
        found = list(read(written(tmp_path, name, made)))
        assert [(one.step, one.time, one.timestep) for one in found] == [(f.step, f.time, f.timestep) for f in made]
    with pytest.raises(InputError, match="no room for step"):
        written(tmp_path, "dcd", made)


@pytest.mark.parametrize("name", OTHERS)
def test_files_that_are_something_else(tmp_path: Path, name: str) -> None:
    file = tmp_path / f"file{FORMATS[name].extension}"
    file.write_text("no trajectory\n")
    (tmp_path / "file.psf").write_text("no PSF\n")
    with pytest.raises(InputError, match=r"file\.\w+"):
        list(read(file))
    with pytest.raises(InputError, match="there is no such file"):
        open_reader(tmp_path / "nothing.gsd")


def test_dcd_without_its_psf(tmp_path: Path) -> None:
    file = written(tmp_path, "dcd", frames())
    file.with_suffix(".psf").unlink()
    with pytest.raises(InputError, match=r"file\.psf: there is no such file; a DCD has no names"):
        open_reader(file)


def test_missing_packages_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    file = written(tmp_path, "gsd", frames(1))
    monkeypatch.setitem(sys.modules, "gsd.hoomd", None)
    with pytest.raises(InputError, match=r"GSD needs the package gsd: pip install 'pydlpoly\[trajectories\]'"):
        open_reader(file)
