"""RDFDAT: normalisation against counts done by hand, layout, reading by us and by dlpoly-py."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.rdfdat import normalise_rdf, read_rdf, write_rdf

with warnings.catch_warnings():  # dlpoly-py asks for NumPy's version in a way that is deprecated
    warnings.simplefilter("ignore", DeprecationWarning)
    from dlpoly.rdf import RDF

R = np.array([0.025, 0.075, 0.125])
G = np.array([[0.0, 0.5, 1.25], [0.125, 1.0, 2.0], [0.0, 0.0, 3.5]])
N = np.array([[0.0, 0.25, 1.5], [0.5, 1.5, 4.0], [0.0, 0.0, 2.0]])
PAIRS = [("W", "W"), ("W", "HEADBEAD"), ("HEADBEAD", "HEADBEAD")]


def test_one_unlike_pair_by_hand() -> None:
    # 4 a-beads, 6 b-beads in 100 Å3, 2 configurations, 12 pairs in 1 Å ≤ r < 2 Å.
    r, g, n = normalise_rdf([0, 12], like=False, volume=100.0, beads=(4, 6), configurations=2, bin_width=1.0)
    np.testing.assert_allclose(r, [0.5, 1.5])
    shell = 4.0 / 3.0 * np.pi * (2.0**3 - 1.0**3)
    np.testing.assert_allclose(g, [0.0, 12 / (2 * 4 * (6 / 100.0) * shell)])
    np.testing.assert_allclose(n, [0.0, 12 / (2 * 4)])


def test_one_like_pair_by_hand() -> None:
    # 5 beads make 10 pairs; all of them within the first bin of one configuration.
    r, g, n = normalise_rdf([10], like=True, volume=50.0, beads=(5, 5), configurations=1, bin_width=2.0)
    np.testing.assert_allclose(r, [1.0])
    shell = 4.0 / 3.0 * np.pi * 2.0**3
    # Each bead has 4 neighbours; DL_POLY's factor ½(1 − 1/N) makes n the 5 of an infinite system of this density.
    np.testing.assert_allclose(n, [5.0])
    np.testing.assert_allclose(g, [5.0 / (5 / 50.0 * shell)])


def test_an_ideal_gas_has_g_equal_to_one() -> None:
    generator = np.random.default_rng(11)
    edge, beads, configurations = 10.0, 60, 200
    counts = {True: np.zeros(80), False: np.zeros(80)}
    kinds = np.arange(beads) % 2
    first, second = np.triu_indices(beads, 1)
    same = kinds[first] + kinds[second] == 0
    unlike = kinds[first] != kinds[second]
    for _ in range(configurations):
        x = generator.uniform(0.0, edge, (beads, 3))
        apart = x[first] - x[second]
        apart -= edge * np.round(apart / edge)
        distance = np.linalg.norm(apart, axis=1)
        for like, chosen in ((True, same), (False, unlike)):
            counts[like] += np.histogram(distance[chosen], bins=80, range=(0.0, 4.0))[0]
    for like, number in counts.items():
        _, g, n = normalise_rdf(
            number, like=like, volume=edge**3, beads=(30, 30), configurations=configurations, bin_width=0.05
        )
        around = 30 / edge**3 * 4.0 / 3.0 * np.pi * 4.0**3  # beads of the second kind within 4 Å
        assert g[40:].mean() == pytest.approx(1.0, abs=0.03)
        assert n[-1] == pytest.approx(around, rel=0.03)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"beads": (1, 1), "like": True}, "at least two beads"),
        ({"beads": (4, 5), "like": True}, "at least two beads of one species, not 4 and 5"),
        ({"beads": (0, 5)}, "must be positive"),
        ({"configurations": 0}, "must be positive"),
        ({"volume": 0.0}, "must be positive"),
        ({"bin_width": float("nan")}, "must be positive"),
    ],
)
def test_what_cannot_be_normalised_is_refused(change: dict[str, object], message: str) -> None:
    good: dict[str, object] = {"like": False, "volume": 1.0, "beads": (2, 2), "configurations": 1, "bin_width": 0.1}
    with pytest.raises(ValueError, match=message):
        normalise_rdf([1.0], **{**good, **change})  # type: ignore[arg-type]


def test_the_layout_is_dl_poly_s(tmp_path: Path) -> None:
    write_rdf(tmp_path / "RDFDAT", "soft beads", PAIRS, R, G, N)
    lines = (tmp_path / "RDFDAT").read_text().split("\n")
    assert lines[:4] == [
        "soft beads",
        "         3         3",
        "W       W       ",
        "  2.500000E-02  0.000000E+00  0.000000E+00",
    ]
    assert lines[6] == "W       HEADBEAD"
    assert lines[9] == "  1.250000E-01  2.000000E+00  4.000000E+00"
    assert len(lines) == 2 + 3 * 4 + 1


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    write_rdf(tmp_path / "RDFDAT", "soft beads", PAIRS, R, G, N)
    table = read_rdf(tmp_path / "RDFDAT")
    assert (table.title, table.pairs, table.warnings) == ("soft beads", tuple(PAIRS), ())
    np.testing.assert_array_equal(table.r, R)
    np.testing.assert_array_equal(table.g, G)
    np.testing.assert_array_equal(table.n, N)
    np.testing.assert_array_equal(table["HEADBEAD", "W"], G[1])
    with pytest.raises(KeyError, match="no pair W X"):
        table["W", "X"]


def test_names_of_eight_letters_on_both_sides_are_told_apart(tmp_path: Path) -> None:
    pair = [("HEADBEAD", "TAILBEAD")]
    write_rdf(tmp_path / "RDFDAT", "", pair, R, G[:1], N[:1])
    assert read_rdf(tmp_path / "RDFDAT").pairs == tuple(pair)


def test_dlpoly_py_reads_the_same_numbers(tmp_path: Path) -> None:
    write_rdf(tmp_path / "RDFDAT", "soft beads", PAIRS, R, G, N)
    judge = RDF(str(tmp_path / "RDFDAT"))
    assert (judge.n_rdf, judge.n_points) == (3, 3)
    np.testing.assert_array_equal(judge.x, R)
    np.testing.assert_array_equal(judge.data[:, :, 0], G)
    np.testing.assert_array_equal(judge.data[:, :, 1], N)
    assert judge.labels[:1] == [["W", "W"]]


def test_a_pair_that_dl_poly_counts_but_does_not_write_is_a_warning(tmp_path: Path) -> None:
    (tmp_path / "RDFDAT").write_text("title\n 2 1\nA B\n 0.1 1.0\n")
    table = read_rdf(tmp_path / "RDFDAT")
    assert table.warnings == ("the header says 2 pairs, the file has 1",)
    assert table.g[0, 0] == 1.0
    assert np.isnan(table.n[0, 0])


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("title\nnot numbers\n", 2, "is not a RDFDAT file"),
        ("title\n 1 2\nA B\n 0.1 1 1\n", 3, "expected 2 rows for this pair, found 1"),
        ("title\n 1 1\nA B\n 0.1 one 1\n", 4, "expected numbers"),
        ("title\n 1 1\nA B\n 0.1 1 1 0.5\n", 4, "columns of error estimates are not read"),
        ("title\n 1 1\nA\n 0.1 1 1\n", 3, "expected the names of two species"),
        ("%YAML 1.2\n---\n", 1, "YAML form"),
    ],
)
def test_damage_is_refused_with_its_place(tmp_path: Path, text: str, line: int, message: str) -> None:
    (tmp_path / "RDFDAT").write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        read_rdf(tmp_path / "RDFDAT")
    assert caught.value.line == line


def test_a_name_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="'NINECHARS': a name in a DL_POLY file"):
        write_rdf(tmp_path / "RDFDAT", "", [("NINECHARS", "W")], R, G[:1], N[:1])
    assert not (tmp_path / "RDFDAT").exists()
