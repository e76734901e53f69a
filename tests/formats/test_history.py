"""HISTORY: the 73-byte layout, kills and restarts, odd files, and what MDAnalysis makes of what we write."""

from __future__ import annotations

from pathlib import Path

import MDAnalysis
import numpy as np
import pytest
from MDAnalysis.coordinates.DLPoly import HistoryReader

from pydlpoly.errors import InputError, InputWarning
from pydlpoly.formats.history import Frame, HistoryWriter, frame_records, read_history, read_history_header

SPECIES = ("W", "W", "HEADBEAD", "T+")
MASSES = (54.04584, 54.04584, 1.0, 22.9898)
CHARGES = (0.0, 0.0, -1.0, 1.0)
CELL = np.array([[10.0, 0.0, 0.0], [1.5, 12.0, 0.0], [-0.25, 0.5, 15.0]])
POSITIONS = np.array([[1.524566588, 2.25, -4.75], [0.0, -0.001, 3.0], [12.5, 1e-12, -7.5], [0.5, 0.25, 0.125]])
VELOCITIES = POSITIONS * 0.1 - 0.25
FORCES = POSITIONS * 1234.5 + 1e5
MOVED = np.array([0.0, 0.5, 1.25, 99.999999])


def write(path: Path, steps: range, level: int = 2, imcon: int = 3, **options: object) -> None:
    writer = HistoryWriter(path, "soft beads", level, imcon, SPECIES, MASSES, CHARGES, **options)  # type: ignore[arg-type]
    with writer:
        for step in steps:
            vectors = (POSITIONS + step, VELOCITIES, FORCES)[: level + 1]
            writer.write(step, 0.01 * step, 0.01, CELL, *vectors, displacements=MOVED)


@pytest.mark.parametrize(("level", "per_bead"), [(0, 2), (1, 3), (2, 4)])
def test_every_record_has_73_bytes_and_the_counters_are_right(tmp_path: Path, level: int, per_bead: int) -> None:
    write(tmp_path / "HISTORY", range(0, 30, 10), level=level)
    content = (tmp_path / "HISTORY").read_bytes()
    records = content.split(b"\n")
    assert records.pop() == b""
    assert {len(record) for record in records} == {72}
    assert len(records) == 2 + 3 * (4 + per_bead * 4) == 2 + 3 * frame_records(4, level)
    assert records[1].decode() == f"{level:10d}{3:10d}{4:10d}{3:21d}{len(records):21d}"


def test_the_frame_layout_is_dl_poly_s(tmp_path: Path) -> None:
    write(tmp_path / "HISTORY", range(1000, 1001))
    lines = (tmp_path / "HISTORY").read_text().split("\n")
    assert lines[0] == "soft beads".ljust(72)
    assert lines[2] == "timestep      1000         4 2 3            0.010000           10.000000"
    assert lines[3] == "       10.0000000000        0.0000000000        0.0000000000".ljust(72)
    assert lines[5] == "       -0.2500000000        0.5000000000       15.0000000000".ljust(72)
    assert lines[6] == "W                1   54.045840    0.000000    0.000000".ljust(72)
    assert lines[7] == "     1001.524567         1002.250000         995.2500000    ".ljust(72)
    assert lines[14] == "HEADBEAD         3    1.000000   -1.000000    1.250000".ljust(72)
    assert lines[16] == "     1.000000000       -0.2500000000        -1.000000000    ".ljust(72)


def test_a_cell_is_written_also_without_periodicity(tmp_path: Path) -> None:
    write(tmp_path / "HISTORY", range(1), imcon=0)
    frame = next(read_history(tmp_path / "HISTORY"))
    assert frame.imcon == 0
    np.testing.assert_array_equal(frame.cell, CELL)


@pytest.mark.parametrize("level", [0, 1, 2])
def test_what_is_written_is_read_back(tmp_path: Path, level: int) -> None:
    write(tmp_path / "HISTORY", range(0, 30, 10), level=level)
    header = read_history_header(tmp_path / "HISTORY")
    assert (header.title, header.level, header.imcon, header.beads, header.frames) == ("soft beads", level, 3, 4, 3)
    frames = list(read_history(tmp_path / "HISTORY"))
    assert [(f.step, f.time, f.timestep, f.level) for f in frames] == [
        (0, 0.0, 0.01, level),
        (10, 0.1, 0.01, level),
        (20, 0.2, 0.01, level),
    ]
    last = frames[2]
    assert last.names == SPECIES
    np.testing.assert_array_equal(last.indices, [1, 2, 3, 4])
    np.testing.assert_array_equal(last.masses, MASSES)
    np.testing.assert_array_equal(last.charges, CHARGES)
    np.testing.assert_array_equal(last.displacements, MOVED)
    np.testing.assert_array_equal(last.cell, CELL)
    np.testing.assert_allclose(last.positions, POSITIONS + 20, rtol=5e-10)
    assert (last.velocities is None, last.forces is None) == (level < 1, level < 2)
    if last.velocities is not None:
        np.testing.assert_allclose(last.velocities, VELOCITIES, rtol=5e-10)
    if last.forces is not None:
        np.testing.assert_allclose(last.forces, FORCES, rtol=5e-10)


@pytest.mark.parametrize("level", [0, 2])
def test_mdanalysis_reads_the_same_numbers(tmp_path: Path, level: int) -> None:
    path = tmp_path / "HISTORY"
    write(path, range(0, 30, 10), level=level)
    universe = MDAnalysis.Universe(str(path), topology_format="HISTORY", format="HISTORY", to_guess=())
    assert list(universe.atoms.names) == list(SPECIES)
    assert len(universe.trajectory) == 3
    for number, frame in enumerate(universe.trajectory):
        np.testing.assert_allclose(frame.positions, POSITIONS + 10 * number, rtol=1e-6, atol=1e-6)
    universe.trajectory[1]
    frame = universe.trajectory.ts
    lengths = np.linalg.norm(CELL, axis=1)
    np.testing.assert_allclose(frame.dimensions[:3], lengths, rtol=1e-6)
    alpha = np.degrees(np.arccos(CELL[1] @ CELL[2] / lengths[1] / lengths[2]))
    np.testing.assert_allclose(frame.dimensions[3], alpha, rtol=1e-6)
    if level == 2:
        np.testing.assert_allclose(frame.velocities, VELOCITIES, rtol=1e-6)
        np.testing.assert_allclose(frame.forces, FORCES, rtol=1e-6)
    universe.trajectory.close()


@pytest.mark.parametrize("lost", [1, 60, 73, 500, 1000, 1400])
def test_a_kill_in_the_middle_of_a_frame(tmp_path: Path, lost: int) -> None:
    """The torn frame is left out with a warning, cut on append, and MDAnalysis reads the continued file whole."""
    path = tmp_path / "HISTORY"
    write(path, range(0, 30, 10))
    whole = path.read_bytes()
    frame_bytes = 73 * frame_records(4, 2)
    assert frame_bytes == 1460
    path.write_bytes(whole[: 2 * 73 + 2 * frame_bytes] + whole[-frame_bytes:-lost])
    if lost > 1:
        with pytest.warns(InputWarning, match="a frame is cut short and left out"):
            assert [frame.step for frame in read_history(path)] == [0, 10]
    write(path, range(20, 30, 10), append=True)
    assert path.read_bytes() == whole
    with HistoryReader(str(path)) as judge:
        assert judge.n_frames == 3


def test_counters_left_behind_by_a_kill_are_mended(tmp_path: Path) -> None:
    path = tmp_path / "HISTORY"
    write(path, range(0, 30, 10))
    content = bytearray(path.read_bytes())
    content[73 + 30 : 73 + 51] = b"2".rjust(21)
    path.write_bytes(content)
    with HistoryWriter(path, "", 2, 3, SPECIES, MASSES, CHARGES, append=True) as writer:
        assert writer.frames == 3
    header = read_history_header(path)
    assert (header.frames, header.records, header.title) == (3, 62, "soft beads")


def test_continuing_from_an_older_checkpoint_leaves_no_step_twice(tmp_path: Path) -> None:
    write(tmp_path / "ONE", range(0, 50, 10))
    write(tmp_path / "TWO", range(0, 40, 10))
    write(tmp_path / "TWO", range(20, 50, 10), append=True, keep_until=10)
    assert (tmp_path / "ONE").read_bytes() == (tmp_path / "TWO").read_bytes()


def test_append_without_a_file_starts_one(tmp_path: Path) -> None:
    write(tmp_path / "HISTORY", range(0, 30, 10), append=True)
    assert read_history_header(tmp_path / "HISTORY").frames == 3


def test_appending_to_another_kind_of_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "HISTORY"
    write(path, range(1), level=1)
    before = path.read_bytes()
    with pytest.raises(InputError, match=r"HISTORY:2: cannot be continued: level, imcon and number of beads must be"):
        write(path, range(1), level=2, append=True)
    assert path.read_bytes() == before
    path.write_text("title\n 2 3 4\n" + "timestep 1 4 2 3 0.1\n" * 20)
    with pytest.raises(InputError, match="records of 73 bytes"):
        write(path, range(1), append=True)


def test_what_does_not_fit_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="'NINECHARS'"):
        HistoryWriter(tmp_path / "H", "", 0, 1, ["NINECHARS"], [1.0], [0.0])
    with pytest.raises(ValueError, match="level is 0, 1 or 2, not 3"):
        HistoryWriter(tmp_path / "H", "", 3, 1, ["W"], [1.0], [0.0])
    with (
        HistoryWriter(tmp_path / "H", "", 1, 1, ["W"], [1.0], [0.0]) as writer,
        pytest.raises(ValueError, match="level 1 needs velocities"),
    ):
        writer.write(0, 0.0, 0.1, CELL, [[0.0, 0.0, 0.0]])


def test_large_masses_and_displacements_keep_their_size(tmp_path: Path) -> None:
    with HistoryWriter(tmp_path / "H", "", 0, 1, ["COLLOID"], [2.5e6], [-1e5]) as writer:
        writer.write(0, 0.0, 0.1, CELL, [[0.0, 0.0, 0.0]], displacements=[123456.75])
    frame = next(read_history(tmp_path / "H"))
    assert (frame.masses[0], frame.charges[0], frame.displacements[0]) == (2.5e6, -1e5, 123456.75)


CLASSIC = """DL_POLY Classic, four fields a bead line, three in the header
         1         1         2
timestep      1000         2         1         1    0.001000
       18.620000        0.000000        0.000000
        0.000000       18.620000        0.000000
        0.000000        0.000000       18.620000
K+               2   39.100000    1.000000
  1.0000E+00  2.0000d+00  -3.5000E+00
  0.1 .2 -0.3
CL-              1   35.453000   -1.000000
 -1. 5 6
  4 5 6
timestep      2000         2         1         1    0.001000
       18.620000        0.000000        0.000000
        0.000000       18.620000        0.000000
        0.000000        0.000000       18.620000
CL-              1   35.453000   -1.000000
 -1. 5 7
  4 5 6
K+               2   39.100000    1.000000
  1.0000E+00  2.0000d+00  -3.5000E+00
  0.1 .2 -0.3"""


def test_a_classic_file_with_shuffled_indices_and_no_final_newline(tmp_path: Path) -> None:
    (tmp_path / "HISTORY").write_text(CLASSIC)
    header = read_history_header(tmp_path / "HISTORY")
    assert (header.level, header.imcon, header.beads, header.frames) == (1, 1, 2, 0)
    first, second = read_history(tmp_path / "HISTORY")
    assert (first.step, second.step, first.timestep, first.time) == (1000, 2000, 0.001, None)
    assert first.names == second.names == ("CL-", "K+")
    np.testing.assert_array_equal(first.positions, [[-1.0, 5.0, 6.0], [1.0, 2.0, -3.5]])
    assert first.velocities is not None
    np.testing.assert_array_equal(first.velocities, [[4.0, 5.0, 6.0], [0.1, 0.2, -0.3]])
    np.testing.assert_array_equal(first.masses, [35.453, 39.1])
    np.testing.assert_array_equal(first.charges, [-1.0, 1.0])
    assert np.isnan(first.displacements).all()
    assert first.cell[2, 2] == 18.62


MINIMAL = """no cell, no periodicity in line 2, another level and imcon in the frame
 0 0 3 1
timestep 5 3 0 0 0.5 2.5
C 1 12.0 0.0 0.25
 1 2 3
B 2 10.8 0.0 0.0
 4 5 6
A 7 1.0 0.0 0.0
 7 8 9
timestep 6 3 2 3 0.5 3.0
 1 0 0
 0 1 0
 0 0 1
C 1
 1 2 3
 4 5 6
 7 8 9
B 2
 1 2 3
 4 5 6
 7 8 9
A 3
 1 2 3
 4 5 6
 7 8 9.5

"""


def test_frames_say_themselves_what_they_hold(tmp_path: Path) -> None:
    (tmp_path / "HISTORY").write_text(MINIMAL)
    assert read_history_header(tmp_path / "HISTORY").frames == 1
    first, second = read_history(tmp_path / "HISTORY")
    assert (first.level, first.imcon, first.time) == (0, 0, 2.5)
    np.testing.assert_array_equal(first.cell, np.zeros((3, 3)))
    np.testing.assert_array_equal(first.indices, [1, 2, 7])  # not 1 … N: kept in the file's order
    assert first.names == ("C", "B", "A")
    assert first.displacements[0] == 0.25
    assert (second.level, second.imcon, second.time) == (2, 3, 3.0)
    assert second.forces is not None
    assert second.forces[2, 2] == 9.5
    assert np.isnan(second.masses).all()


def test_a_frame_torn_in_the_middle_of_a_file_is_left_out(tmp_path: Path) -> None:
    lines = CLASSIC.split("\n")
    (tmp_path / "HISTORY").write_text("\n".join(lines[:9] + lines[12:]))
    with pytest.warns(InputWarning, match=r"HISTORY:9: a frame is cut short"):
        frames: list[Frame] = list(read_history(tmp_path / "HISTORY"))
    assert [frame.step for frame in frames] == [2000]
    (tmp_path / "HISTORY").write_text("\n".join(lines[:4] + lines[12:]))
    with pytest.warns(InputWarning, match=r"HISTORY:4: a frame is cut short"):
        assert [frame.step for frame in read_history(tmp_path / "HISTORY")] == [2000]


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("  0.1 .2 -0.3\nCL", "  0.1 .2\nCL", 9, "expected three numbers"),
        ("39.100000    1.0", "39.100000    one", 7, "'one00000': expected a number"),
        ("K+               2", "K+               x", 7, "expected name, index"),
        ("         1         1         2\n", " 1.5 what\n", 2, "is not a formatted HISTORY file"),
        ("         1         1         2\n", " 4 1 2\n", 2, "level \\(0, 1 or 2\\)"),
        ("timestep      2000", "tinestep      2000", 13, "expected 'timestep'"),
        ("timestep      1000         2", "timestep      1000         x", 3, "expected step, number of beads"),
        ("        0.000000       18.620000", "        0.000000       side", 4, "expected three cell vectors"),
    ],
)
def test_damage_is_refused_with_its_place(tmp_path: Path, old: str, new: str, line: int, message: str) -> None:
    assert old in CLASSIC
    (tmp_path / "HISTORY").write_text(CLASSIC.replace(old, new, 1))
    with pytest.raises(InputError, match=message) as caught:
        list(read_history(tmp_path / "HISTORY"))
    assert caught.value.line == line


def test_a_missing_file_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="HISTORY: cannot be read: No such file"):
        next(read_history(tmp_path / "HISTORY"))


def test_overflowed_fields_are_not_numbers_but_do_not_stop_the_reader(tmp_path: Path) -> None:
    text = CLASSIC.replace("K+               2   39.100000    1.000000", "K+               2************    1.000000")
    (tmp_path / "HISTORY").write_text(text)
    with pytest.raises(InputError, match="expected name, index"):
        next(read_history(tmp_path / "HISTORY"))
    (tmp_path / "HISTORY").write_text(CLASSIC.replace("   39.100000", " ***********"))
    assert np.isnan(next(read_history(tmp_path / "HISTORY")).masses[1])
