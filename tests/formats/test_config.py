"""CONFIG files as people and programs write them, and the writer's records byte by byte."""

from __future__ import annotations

import io
import time
from pathlib import Path

import numpy as np
import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.config import parse_config, read_config, write_config, write_config_to
from pydlpoly.formats.records import Configuration

CELL = "10.0 0.0 0.0\n0.0 10.0 0.0\n0.0 0.0 10.0\n"


def chain(names: str = "ABC", **more: object) -> Configuration:
    n = len(names)
    positions = np.arange(3.0 * n).reshape(n, 3) / 7.0
    return Configuration(tuple(names), positions, **more)  # type: ignore[arg-type]


# --- files of others --------------------------------------------------------------------------------------------------


def test_every_golden_config_reads_and_survives_writing(shared: Path) -> None:
    paths = [*sorted(shared.glob("golden/*/CONFIG")), *sorted(shared.glob("inputs/dl_poly/*/CONFIG"))]
    assert len(paths) >= 69
    for path in paths:
        read = read_config(path)
        assert read.warnings == (), path
        assert read.imcon in (1, 2, 3)
        assert parse_config(write_config(read, digits=17)) == read, path
        printed = parse_config(write_config(read))
        np.testing.assert_allclose(printed.positions, read.positions, rtol=5e-10, atol=0)
        np.testing.assert_allclose(printed.cell, read.cell, rtol=0, atol=5e-11)


def test_lipid_run_is_read_completely(shared: Path) -> None:
    read = read_config(shared / "golden/run-lipid/CONFIG")
    assert (read.title, read.level, read.imcon, len(read.names)) == ("run-lipid", 1, 2, 280)
    assert read.names[:3] == ("H", "T", "T")
    np.testing.assert_array_equal(np.diag(read.cell), [12.0, 14.4, 10.8])
    np.testing.assert_array_equal(read.positions[1], [0.868748114875, 7.057892919686, -1.538039128297])
    assert read.velocities is not None
    np.testing.assert_array_equal(read.velocities[0], [-1.880841991210, 1.962949861314, 1.365058813902])
    assert read.forces is None


# --- item 1: line 2 ---------------------------------------------------------------------------------------------------

UNUSED = "CONFIG:2: the last three numbers of line 2 are not step, timestep and time; they are not used"
COUNT = "CONFIG:2: line 2 says {} where the number of beads may stand; the file has 1"


@pytest.mark.parametrize(
    ("line", "run", "warnings"),
    [
        ("0 0", (0, 0.0, 0.0), ()),
        ("0 0 1", (0, 0.0, 0.0), ()),
        ("0 0 917", (0, 0.0, 0.0), (COUNT.format(917),)),
        ("0 0 2000 0.005", (0, 0.0, 0.0), (COUNT.format(2000),)),
        ("0 0 1 -332396.265264", (0, 0.0, 0.0), ()),
        ("0 0 1 .4000000000E-02", (0, 0.0, 0.0), ()),
        ("0 0 917 0.5000000000E-03 7", (0, 0.0, 0.0), (COUNT.format(917),)),
        ("0 0 1 200 0.01 2.0", (200, 0.01, 2.0), ()),
        ("0 0 1 57 -1234.5 -1250.1", (0, 0.0, 0.0), (UNUSED,)),
        ("0 0 1 57 1234.5 1250.1", (0, 0.0, 0.0), (UNUSED,)),
        ("0 0 1 5.5 0.01 0.055", (0, 0.0, 0.0), (UNUSED,)),
        ("0 0 written by hand", (0, 0.0, 0.0), ()),
    ],
)
def test_line_two(line: str, run: tuple[int, float, float], warnings: tuple[str, ...]) -> None:
    read = parse_config(f"t\n{line}\nA\n0 0 0\n")
    assert (read.step, read.timestep, read.time) == run
    assert read.warnings == warnings


def test_restart_header_at_level_two_needs_no_constant_timestep() -> None:
    read = parse_config("t\n2 0 1 200 0.01 17.5\nA\n0 0 0\n1 1 1\n2 2 2\n")
    assert (read.level, read.step, read.timestep, read.time) == (2, 200, 0.01, 17.5)
    assert read.forces is not None
    assert read.forces.tolist() == [[2.0, 2.0, 2.0]]


def test_title_keeps_72_characters() -> None:
    assert parse_config("  " + "x" * 80 + "\n0 0\nA\n0 0 0\n").title == "  " + "x" * 70


# --- items 2, 3: name lines -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lines", "names"),
    [
        (("C", "B", "A"), "CBA"),
        (("C 0", "B 0", "A 0"), "CBA"),
        (("C 3", "B 2", "A 1"), "ABC"),
        (("C -3", "B 1", "A 2"), "BAC"),
        (("C 3 6", "B 1 5", "A 2 7 extra words"), "BAC"),
        (("C 2", "B 1", "A"), "BCA"),
        (("C 0 12.0 0.5", "B 0 10.8 0.5", "A 0 1.0 0.0"), "CBA"),
    ],
)
def test_name_lines_and_order(lines: tuple[str, ...], names: str) -> None:
    text = "t\n1 0\n" + "".join(f"{line}\n{i}. 0 0\n0 {i}. 0\n" for i, line in enumerate(lines))
    read = parse_config(text)
    assert "".join(read.names) == names
    assert read.warnings == ()
    places = [[line[0] for line in lines].index(name) for name in names]
    assert read.positions[:, 0].tolist() == places
    assert read.velocities is not None
    assert read.velocities[:, 1].tolist() == places
    ignored = parse_config(text, ignore_indices=True)
    assert "".join(ignored.names) == "CBA"


def test_mass_behind_the_name_is_no_index() -> None:
    read = parse_config("t\n0 0\nA 1.5 0.0\n0 0 0\nB 2.5 0.0\n1 1 1\n")
    assert read.names == ("A", "B")
    told = "the second word of 2 name lines is not an index; these beads keep their place in the file"
    assert read.warnings == (f"CONFIG:3: {told}",)


def test_broken_indices_do_not_matter_when_ignored() -> None:
    assert parse_config("t\n0 0\nA 7\n0 0 0\nB 7\n1 1 1\n", ignore_indices=True).names == ("A", "B")


def test_names_of_any_letters_and_long_ones() -> None:
    read = parse_config("t\n0 0\nO_2-*#+\n0 0 0\n1H\n1 1 1\nVeryLongName 3\n2 2 2\n7 4 6\n3 3 3\n")
    assert read.names == ("O_2-*#+", "1H", "VeryLong", "7")
    assert read.warnings == ("CONFIG:7: name 'VeryLongName' is cut to 'VeryLong'",)


# --- items 4, 5, 8: cells, numbers, ends of files ---------------------------------------------------------------------


def test_general_cell_with_negative_and_tiny_components() -> None:
    cell = "8.0 0.0 1e-17\n-4.0 6.9 .0\n-.5 1d-1 10000.\n"
    read = parse_config("t\n0 3\n" + cell + "A\n12 -9 3\n")
    assert read.cell.tolist() == [[8.0, 0.0, 1e-17], [-4.0, 6.9, 0.0], [-0.5, 0.1, 10000.0]]
    assert read.positions.tolist() == [[12.0, -9.0, 3.0]]  # not wrapped


@pytest.mark.parametrize("imcon", [1, 2, 3, 6])
def test_periodic_cells(imcon: int) -> None:
    assert parse_config(f"t\n0 {imcon}\n{CELL}A\n0 0 0\n").cell.tolist() == (10.0 * np.eye(3)).tolist()


def test_open_system_has_no_cell() -> None:
    read = parse_config("t\n0 0\nA\n1 2 3\n")
    assert not read.cell.any()


def test_open_system_with_a_cell_anyway() -> None:
    read = parse_config("t\n0 0\n" + CELL + "A\n1 2 3\nB\n4 5 6\n")
    assert read.names == ("A", "B")
    assert read.cell.tolist() == (10.0 * np.eye(3)).tolist()
    assert read.warnings == ("CONFIG:3: imcon is 0, but the file has a cell; it is read and not used for periodicity",)


def test_beads_called_by_numbers_are_not_a_cell() -> None:
    read = parse_config("t\n0 0\n7 1 6\n1 2 3\n8 2 6\n4 5 6\n")
    assert read.names == ("7", "8")
    assert read.warnings == ()


@pytest.mark.parametrize("word", ["1d-6", "1.D-6", ".000001", "1.e-6", "1.0-6", "0.1-5"])
def test_numbers_that_only_fortran_reads(word: str) -> None:
    read = parse_config(f"t\n0 0\nA\n{word} 10000. .5\nB\n-{word} 1 2\n")
    assert read.positions.tolist() == [[1e-6, 10000.0, 0.5], [-1e-6, 1.0, 2.0]]


def test_words_after_the_three_numbers_are_ignored() -> None:
    read = parse_config("t\n0 0\nA\n1 2 3 4 five\nB\n4 5 6 !\n")
    assert read.positions.tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]


@pytest.mark.parametrize("end", ["", "\n", "\n\n   \n\n", "\r\n"])
def test_ends_of_files(end: str, tmp_path: Path) -> None:
    text = "  t  \n   0   1\n" + CELL + "  A   1\n\t1.0\t2.0\t3.0"
    path = tmp_path / "CONFIG"
    path.write_bytes((text + end).replace("\r\n", "\n").replace("\n", "\r\n").encode())
    for read in (parse_config(text + end), read_config(path)):
        assert read.names == ("A",)
        assert read.positions.tolist() == [[1.0, 2.0, 3.0]]


def test_accent_in_the_title_in_any_encoding(tmp_path: Path) -> None:
    path = tmp_path / "CONFIG"
    for encoding in ("utf-8", "utf-8-sig", "latin-1"):
        path.write_bytes("für\n0 0\nA\n1 2 3\n".encode(encoding))
        assert read_config(path).title == "für"


def test_missing_file_and_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the file cannot be read: No such file or directory"):
        read_config(tmp_path / "CONFIG")
    with pytest.raises(InputError, match="the file cannot be read: Is a directory"):
        read_config(tmp_path)


def test_errors_beyond_the_first_chunk_give_their_line(tmp_path: Path) -> None:
    beads = [f"A {i}\n{i}.5 0 0\n" for i in range(1, 2501)]
    beads[2400] = "A 2401\n1.0 x 0\n"
    path = tmp_path / "CONFIG"
    path.write_text("t\n0 0\n" + "".join(beads))
    with pytest.raises(InputError) as caught:
        read_config(path)
    expected = "expected y of the position of bead 2401 (A), a finite number (levcfg 0 means 2 lines a bead)"
    assert str(caught.value) == f"{path}:4804: 'x': {expected}"
    beads[2400] = "A 7\n1.0 1.0 0\n"
    with pytest.raises(InputError, match="4803: bead index 7 is also on line 15"):
        parse_config("t\n0 0\n" + "".join(beads))
    with pytest.raises(InputError, match="4803: blank line among the beads"):
        parse_config("t\n0 0\n" + "".join([*beads[:2400], "\n", *beads[2400:]]))


@pytest.mark.parametrize("count", [999, 1000, 1001, 2000])
def test_blank_lines_after_any_number_of_beads(count: int) -> None:
    text = "t\n0 0\n" + "".join(f"A {i + 1}\n{i} 0 0\n" for i in range(count))
    for end in ("", "\n", "\n" * 5000):
        assert len(parse_config(text + end).names) == count


# --- writing ----------------------------------------------------------------------------------------------------------


def test_records_are_dl_poly_s_own() -> None:
    written = write_config(
        Configuration(
            names=("WT", "Na+"),
            positions=np.array([[1.0, -0.01, 0.0], [123456.789, 0.1, -99999999999.0]]),
            velocities=np.array([[-1.25, 2.5e-101, 1.0 / 3.0], [1e10, 9999999999.4, -0.5]]),
            forces=np.array([[1.0, 2.0, 3.0], [1e-5, -2e300, 7.0]]),
            title="two beads",
            imcon=3,
            cell=np.array([[10.0, 0.0, 0.0], [-2.5, 9.0, 0.0], [1e-9, 1.0, 1234.5]]),
            step=1200,
            timestep=0.005,
            time=6.0,
        )
    )
    lines = written.split("\n")
    assert lines.pop() == ""
    assert {len(line) for line in lines} == {72}
    assert [line.rstrip() for line in lines] == [
        "two beads",
        "         2         3         2      1200   5.0000000E-03   6.0000000E+00",
        "       10.0000000000        0.0000000000        0.0000000000",
        "       -2.5000000000        9.0000000000        0.0000000000",
        "        0.0000000010        1.0000000000     1234.5000000000",
        "WT               1",
        "     1.000000000       -0.1000000000E-01     0.000000000",
        "    -1.250000000        0.2500000000-100    0.3333333333",
        "     1.000000000         2.000000000         3.000000000",
        "Na+              2",
        "     123456.7890        0.1000000000       -0.1000000000E+12",
        "    0.1000000000E+11     9999999999.       -0.5000000000",
        "    0.1000000000E-04   -0.2000000000+301     7.000000000",
    ]


def test_header_without_a_run_has_three_numbers() -> None:
    assert write_config(chain()).split("\n")[1] == "         0         0         3".ljust(72)


@pytest.mark.parametrize("step", [1, 999_999_999, 1_000_000_000, 123_456_789_012])
@pytest.mark.parametrize("digits", [None, 17])
def test_steps_of_any_length_stay_readable(step: int, digits: int | None) -> None:
    configuration = chain(step=step, timestep=0.25, time=0.25 * step, velocities=np.ones((3, 3)))
    read = parse_config(write_config(configuration, digits=digits))
    assert (read.step, read.timestep) == (step, 0.25)
    assert read.time == pytest.approx(0.25 * step, rel=1e-7)


def test_digits_decide_what_survives() -> None:
    configuration = chain("AB", velocities=np.full((2, 3), np.pi))
    assert parse_config(write_config(configuration, digits=17)) == configuration
    short = parse_config(write_config(configuration, digits=3))
    assert short.velocities is not None
    assert short.velocities[0, 0] == 3.14


def test_streaming_gives_the_same_bytes_across_chunks() -> None:
    n = 50_003
    positions = np.random.default_rng(1).normal(size=(n, 3))
    configuration = Configuration(("A",) * n, positions, imcon=1, cell=np.eye(3))
    buffer = io.BytesIO()
    write_config_to(buffer, configuration)
    lines = buffer.getvalue().decode().split("\n")
    assert len(lines) == 5 + 2 * n + 1
    assert lines[-3].split() == ["A", str(n)]
    np.testing.assert_allclose(parse_config(buffer.getvalue().decode()).positions, positions, rtol=5e-10, atol=0)


@pytest.mark.parametrize(
    ("configuration", "message"),
    [
        (Configuration((), np.zeros((0, 3))), "without beads"),
        (Configuration(("A",), np.zeros((2, 3))), r"the positions must have shape \(1, 3\), not \(2, 3\)"),
        (
            Configuration(("A",), np.array([[0.0, np.nan, 0.0]])),
            "the positions have .* not finite in row 1",
        ),
        (chain("AB", velocities=np.array([[0, 0, 0], [0, np.inf, 0]])), "the velocities have .* in row 2"),
        (chain("AB", forces=np.zeros((2, 3))), "forces without velocities"),
        (chain("AB", imcon=4), "imcon 4 cannot be written"),
        (chain("AB", step=-1), "must not be negative"),
        (chain("AB", time=np.inf), "finite"),
        (Configuration(("two words",), np.zeros((1, 3))), "no blanks"),
        (Configuration(("NineChars",), np.zeros((1, 3))), "1 to 8 characters"),
        (Configuration(("",), np.zeros((1, 3))), "1 to 8 characters"),
        (Configuration(("Ä",), np.zeros((1, 3))), "ASCII"),
    ],
)
def test_what_could_not_be_read_back_is_not_written(configuration: Configuration, message: str) -> None:
    with pytest.raises(InputError, match=message):
        write_config(configuration)


def test_digits_out_of_range() -> None:
    with pytest.raises(InputError, match="digits must be 1 to 40"):
        write_config(chain(), digits=0)


def test_a_hundred_thousand_beads_read_within_a_second_or_two(tmp_path: Path) -> None:
    n = 100_000
    positions = np.random.default_rng(2).normal(scale=50.0, size=(n, 3))
    path = tmp_path / "CONFIG"
    with path.open("wb") as file:
        write_config_to(file, Configuration(("WT",) * n, positions, imcon=1, cell=100.0 * np.eye(3)))
    start = time.perf_counter()
    read = read_config(path)
    # Ten times what an idle machine needs, so that only a fall to the careful path fails this.
    assert time.perf_counter() - start < 3.0
    np.testing.assert_allclose(read.positions, positions, rtol=5e-10, atol=0)
