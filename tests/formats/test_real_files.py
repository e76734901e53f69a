"""What public projects keep under the names CONFIG and HISTORY: twins of each oddity, and the real files if there."""

from __future__ import annotations

import tracemalloc
import warnings
from pathlib import Path

import numpy as np
import pytest

from pydlpoly.errors import InputError, InputWarning
from pydlpoly.formats.config import parse_config, read_config
from pydlpoly.formats.history import Frame, read_history, read_history_header
from pydlpoly.formats.plain_lines import plain_heads

TWINS = Path(__file__).resolve().parents[1] / "data" / "real"


def frames(path: Path) -> tuple[list[Frame], list[str]]:
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        return list(read_history(path)), [str(warning.message).removeprefix(f"{path}") for warning in said]


# --- CONFIG -----------------------------------------------------------------------------------------------------------


def test_no_indices_and_no_cell() -> None:
    read = read_config(TWINS / "CONFIG_no_ids")
    assert (read.names, read.imcon, read.level) == (("C", "B", "A"), 0, 0)
    assert not read.cell.any()
    assert len(read.warnings) == 1
    assert read.warnings[0].endswith(":2: line 2 says 2000 where the number of beads may stand; the file has 3")


def test_indices_that_are_not_1_to_n_are_refused_or_ignored() -> None:
    with pytest.raises(InputError, match="CONFIG_offset_ids:10: this bead index is larger than the number of beads"):
        read_config(TWINS / "CONFIG_offset_ids")
    assert read_config(TWINS / "CONFIG_offset_ids", ignore_indices=True).names == ("A", "B", "C")


def test_atomic_numbers_and_fortran_exponents() -> None:
    read = read_config(TWINS / "CONFIG_three_columns")
    assert (read.names, read.imcon) == (("HW", "OW"), 2)
    np.testing.assert_array_equal(np.diag(read.cell), [20.0, 20.0, 20.0])
    np.testing.assert_array_equal(read.positions, [[0.5, 0.25, 10.0], [0.5, -0.25, 1e-6]])
    assert read.velocities is not None
    np.testing.assert_array_equal(read.velocities, [[1.0, 2.0, 3.0], [5e-4, 1e-4, -1e-5]])


def test_an_energy_on_line_two_and_blank_lines_at_the_end() -> None:
    read = read_config(TWINS / "CONFIG_energy")
    assert (read.names, read.step, read.warnings) == (("A+", "A-"), 0, ())


def test_a_slab_and_names_of_signs() -> None:
    read = read_config(TWINS / "CONFIG_slab")
    assert (read.names, read.imcon) == (("O_2-*#+", "K_+"), 6)
    assert read.positions[1, 2] == -30.0


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("CONFIG_prism", ":2: imcon 7 .hexagonal prism. is not supported by DL_POLY 4"),
        ("HISTORY_named_CONFIG", ":2: not a DL_POLY CONFIG: line 2 is '10.0 0.0 0.0'"),
        ("HISTORY_classic", ":3: not a DL_POLY CONFIG: line 3 is 'timestep .*as in a HISTORY"),
        ("METADISE", ":2: not a DL_POLY CONFIG: line 2 is 'SPACE GROUP 1 P1'"),
    ],
)
def test_what_is_no_config_is_refused_by_its_line(name: str, told: str) -> None:
    with pytest.raises(InputError, match=name + told):
        read_config(TWINS / name)


@pytest.mark.parametrize("name", ["METADISE", "CONFIG_energy", "HISTORY_named_CONFIG"])
def test_what_is_no_history_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=name + r":[23]: "):
        list(read_history(TWINS / name))


# --- HISTORY ----------------------------------------------------------------------------------------------------------


def test_classic_has_three_numbers_on_line_two_and_four_words_a_bead() -> None:
    read, said = frames(TWINS / "HISTORY_classic")
    assert said == []
    assert [(f.step, f.time, f.timestep, f.names) for f in read] == [
        (1, None, 0.0005, ("Ni+", "o1", "A")),
        (2, None, 0.0005, ("Ni+", "o1", "A")),
    ]
    assert np.isnan(read[0].displacements).all()
    np.testing.assert_array_equal(read[1].positions[:, 2], [-16.0, -16.0, -16.5])


def test_frames_that_hold_less_than_they_say() -> None:
    read, said = frames(TWINS / "HISTORY_no_cell")
    assert said == [
        ":3: frames say imcon 3, line 2 says 0, and there is no cell: nothing is periodic",
        ":7: frames say level 2, but hold as many lines as line 2's 0",
    ]
    assert [(f.step, f.level, f.imcon, f.velocities) for f in read] == [(1, 0, 0, None), (11, 0, 0, None)]
    np.testing.assert_array_equal(read[1].positions, [[-7.0, -7.25, -7.0], [-4.25, -4.25, -7.25]])


def test_a_cell_although_line_two_says_imcon_0() -> None:
    read, said = frames(TWINS / "HISTORY_cell")
    assert len(said) == 1
    assert [(f.level, f.imcon, f.names) for f in read] == [(0, 3, ("B", "C"))] * 2
    assert read[1].cell.tolist()[1] == [-0.0044205826, 17.25, 0.0019439244]
    np.testing.assert_array_equal(read[1].positions[0], [-4.25, -4.25, -7.25])


def test_a_bead_without_mass() -> None:
    read, said = frames(TWINS / "HISTORY_massless")
    assert said == []
    assert read[0].masses.tolist() == [1.00784, 0.0]
    assert read[0].velocities is not None
    assert read[0].velocities[1].tolist() == [55.5, -10.0, 92.25]


def test_the_compressed_form_reads_by_column() -> None:
    read, said = frames(TWINS / "HISTORY_compressed")
    assert said == []
    assert [(f.step, f.time, f.timestep, f.level, f.imcon) for f in read] == [
        (5, 0.05, 0.01, 3, 1),
        (10, 0.1, 0.01, 3, 1),
    ]
    assert read[0].names == ("WATER", "HEADBE")
    np.testing.assert_array_equal(read[0].positions, [[-1234.5, 3.2, -9.9], [9.9, -1000.1, -2000.2]])
    assert read[0].displacements.tolist() == [0.1, 2.0]
    assert read[0].velocities is None
    assert read_history_header(TWINS / "HISTORY_compressed").level == 3


def test_a_compressed_frame_that_a_kill_cut_short(tmp_path: Path) -> None:
    text = (TWINS / "HISTORY_compressed").read_text()
    (tmp_path / "H").write_text(text[:-10])
    read, said = frames(tmp_path / "H")
    assert ([f.step for f in read], len(said)) == ([5], 1)
    (tmp_path / "H").write_text(text.replace("    2.5", "    two"))
    with pytest.raises(InputError, match=r"H:14: 'HEADBE .*expected 4 numbers in fixed columns"):
        list(read_history(tmp_path / "H"))


def test_a_last_frame_that_a_kill_cut_short(tmp_path: Path) -> None:
    text = (TWINS / "HISTORY_classic").read_text()
    for lost in (2, 3, 4, 5, 9, 30, 60, 200, 300):
        (tmp_path / "H").write_text(text[:-lost])
        read, said = frames(tmp_path / "H")
        assert ([f.step for f in read], len(said)) == ([1], 1), lost
        assert "a frame is cut short and left out" in said[0]


# --- large files ------------------------------------------------------------------------------------------------------


def config_text(beads: int, *, level: int = 1) -> str:
    lines = ["large", f"{level} 1 {beads}", "90 0 0", "0 90 0", "0 0 90"]
    for k in range(beads):
        lines += [f"{'AB'[k % 2]}{beads - k:10d}"] + [
            f"{k % 89 + d:20.10f}{0.5:20.10f}{-k:20.10f}" for d in range(level + 1)
        ]
    return "\n".join(lines) + "\n"


def history_text(beads: int, frames_held: int = 2) -> str:
    head = ["large", f"{0:10d}{1:10d}{beads:10d}"]
    body: list[str] = []
    for step in range(frames_held):
        body += [f"timestep{step:10d}{beads:10d}{0:10d}{1:10d}{0.01:12.6f}", "90 0 0", "0 90 0", "0 0 90"]
        for k in range(beads):
            body += [
                f"{'AB'[k % 2]:8s}{k + 1:10d}{1.0:12.6f}{0.0:12.6f}",
                f"{k % 89 + step:20.10f}{0.5:20.10f}{-k:20.10f}",
            ]
    return "\n".join(head + body) + "\n"


def test_a_large_config_needs_little_more_memory_than_its_arrays(tmp_path: Path) -> None:
    beads = 40_000
    (tmp_path / "CONFIG").write_text(config_text(beads))
    tracemalloc.start()
    try:
        read = read_config(tmp_path / "CONFIG")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert read.velocities is not None
    arrays = read.positions.nbytes + read.velocities.nbytes + 8 * beads  # a name is one reference
    assert peak < 4 * arrays
    assert read.names[:2] == ("B", "A")
    assert read.positions[0].tolist() == [(beads - 1) % 89, 0.5, -(beads - 1)]


def test_a_large_history_needs_little_more_memory_than_a_frame(tmp_path: Path) -> None:
    beads = 40_000
    (tmp_path / "HISTORY").write_text(history_text(beads))
    tracemalloc.start()
    try:
        count, largest = 0, 0
        for frame in read_history(tmp_path / "HISTORY"):
            count += 1
            assert frame.positions[7].tolist() == [7.0 + frame.step, 0.5, -7.0]
            largest = frame.positions.nbytes + 3 * frame.masses.nbytes + frame.indices.nbytes + 8 * beads
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert count == 2
    assert peak < 4 * largest  # of which one is the frame before


@pytest.mark.parametrize(
    "change",
    [
        ("A      2995", "A      2995 7.5 0.25"),
        ("A      2995", "A  "),
        ("A      2995", "  A     2995"),
        ("A      2995", "A 2995 8 extra words"),
        ("        0.5000000000", "        0.5d0       "),
        ("        0.5000000000", "  0.5 0.5"),
        ("        0.5000000000", "         0.5+0      "),
    ],
)
def test_one_odd_line_in_a_large_config_changes_nothing_but_itself(change: tuple[str, str]) -> None:
    """The quick way and the careful one read the same numbers, also in one file."""
    beads = 3001
    text = config_text(beads)
    old, new = change
    place = text.index(old, len(text) // 3) if old.startswith(" ") else text.index(old)
    odd = text[:place] + new + text[place + len(old) :]
    plain, read = parse_config(text, ignore_indices=True), parse_config(odd, ignore_indices=True)
    assert read.names == plain.names
    different = np.flatnonzero((read.positions != plain.positions).any(axis=1))
    assert len(different) <= 1  # a fourth number shifts z
    if "0.5 0.5" not in new:
        assert read == plain


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("        0.5000000000", "        O.5000000000", "expected y of the position of bead 1501 .* a finite number"),
        ("        0.5000000000", "                 nan", "expected y of the position of bead 1501 .* a finite number"),
        ("        0.5000000000", "                 1_0", "expected y of the position of bead 1501 .* a finite number"),
        ("        0.5000000000", "                    ", "expected three numbers, the position of bead 1501"),
    ],
)
def test_damage_in_a_large_config_has_its_line(old: str, new: str, told: str) -> None:
    lines = config_text(3001, level=0).split("\n")
    number = 5 + 2 * 1500 + 1
    lines[number] = lines[number].replace(old, new)
    with pytest.raises(InputError, match=told) as caught:
        parse_config("\n".join(lines))
    assert caught.value.line == number + 1


def test_damage_in_a_large_history_has_its_line(tmp_path: Path) -> None:
    lines = history_text(5000).split("\n")
    number = 6 + 2 * 4500 + 1
    lines[number] = lines[number].replace("0.5000000000", "O.5000000000")
    (tmp_path / "HISTORY").write_text("\n".join(lines))
    with pytest.raises(InputError, match="expected three numbers") as caught:
        list(read_history(tmp_path / "HISTORY"))
    assert caught.value.line == number + 1


def test_an_odd_line_in_a_large_history_changes_nothing(tmp_path: Path) -> None:
    text = history_text(5000)
    (tmp_path / "ONE").write_text(text)
    (tmp_path / "TWO").write_text(
        text.replace("B             4500", "  B 4500", 1).replace("    0.5000000000", "    0.5d0", 1)
    )
    for one, two in zip(read_history(tmp_path / "ONE"), read_history(tmp_path / "TWO"), strict=True):
        assert one.names == two.names
        np.testing.assert_array_equal(one.indices, two.indices)
        np.testing.assert_array_equal(one.positions, two.positions)
        np.testing.assert_array_equal(one.masses, two.masses)


# --- the files themselves ---------------------------------------------------------------------------------------------


def test_mdanalysis_s_own_files() -> None:
    """Only where the package MDAnalysisTests is installed, which brings 60 MB of files."""
    package = pytest.importorskip("MDAnalysisTests")
    folder = Path(next(iter(package.__path__))) / "data" / "dlpoly"
    assert len(read_config(folder / "CONFIG").names) == 216
    assert read_config(folder / "CONFIG_minimal").names == ("C", "B", "A")
    with pytest.raises(InputError, match="this bead index is larger than the number of beads"):
        read_config(folder / "CONFIG_order")
    for name, beads in (("", 216), ("_classic", 3), ("_minimal", 3), ("_minimal_cell", 3), ("_order", 3)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)
            read = list(read_history(folder / f"HISTORY{name}"))
        assert [len(frame.names) for frame in read] == [beads] * 3
    order = next(read_history(folder / "HISTORY_order"))
    assert order.names == ("C", "B", "A")
    assert order.positions[0, 0] == -7.595541651


def test_ase_s_own_strings(tmp_path: Path) -> None:
    """Absolute numbers, which ASE's tests do not look at."""
    strings = pytest.importorskip("ase.test.fio.test_dlp")
    (tmp_path / "ONE").write_text(strings.fd.getvalue())
    (tmp_path / "THREE").write_text(strings.fd3.getvalue())
    one, said = frames(tmp_path / "ONE")
    assert ([f.names for f in one], said) == ([("o1", "Ni+")] * 3, [])
    assert one[2].velocities is not None
    assert one[2].forces is not None
    assert (one[2].velocities[0, 0], one[2].forces[1, 2], one[2].cell[1, 2]) == (-2.4898, 3.0655e5, 0.4497)
    three, said = frames(tmp_path / "THREE")
    assert ([f.step for f in three], said) == ([20, 25, 30], [])
    assert three[0].velocities is not None
    assert (three[0].names, three[0].velocities[3, 2], three[0].masses[3]) == (("O", "H", "H", "X"), 92.19090576, 0.0)


@pytest.mark.parametrize("lines", [["A\n", "5 B 7\n"], ["A 1\n", "B\n"], [" A 1\n", "B 2\n"], ["A 1\n", "\n"], []])
def test_lines_that_only_look_alike_are_not_plain(lines: list[str]) -> None:
    assert plain_heads(lines) is None


def test_plain_lines_are_columns() -> None:
    assert plain_heads(["A 1 x\n", "B  2\ty \n"]) == [["A", "B"], ["1", "2"], ["x", "y"]]
