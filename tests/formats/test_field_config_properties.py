"""Random FIELD and CONFIG records survive writing and reading; random damage never escapes as a foreign error."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pydlpoly.errors import PydlpolyError
from pydlpoly.formats.config import parse_config, read_config, write_config
from pydlpoly.formats.field import parse_field, write_field
from pydlpoly.formats.field_keys import BONDED, EXTERNAL_KEYS, PAIR_KEYS
from pydlpoly.formats.fortran import fortran_g
from pydlpoly.formats.lexing import parse_number
from pydlpoly.formats.records import (
    AtomLine,
    BondedLine,
    Configuration,
    ExternalLine,
    Field,
    Molecule,
    MoleculeBlock,
    PairLine,
)

Made = TypeVar("Made")

ROUND_TRIP = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
FUZZ = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])

# Ten digits of a number nearer to the largest double than this can round up to infinity.
finite = st.floats(min_value=-1e308, max_value=1e308)
numbers = st.lists(finite, max_size=8).map(tuple)
letters = st.characters(min_codepoint=33, max_codepoint=126)
names = st.text(letters, min_size=1, max_size=8).filter(lambda name: name[0] not in "#!")
titles = st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=72).map(str.rstrip)


# --- FIELD ------------------------------------------------------------------------------------------------------------


def beads_of(total: int, count: int) -> st.SearchStrategy[tuple[int, ...]]:
    """Different bead numbers of a molecule."""
    return st.lists(st.integers(1, total), min_size=count, max_size=count, unique=True).map(tuple)


def same_entry(directive: str, beads: tuple[int, ...]) -> Any:
    return (beads[0], frozenset(beads[1:])) if directive == "inversions" else min(beads, beads[::-1])


@st.composite
def bonded_blocks(draw: st.DrawFn, directive: str, total: int) -> MoleculeBlock:
    kind = BONDED[directive]
    least = 1 if directive in ("constraints", "shells") else 0
    rows = st.builds(
        BondedLine,
        key=st.sampled_from(sorted(kind.keys)) if kind.keys else st.just(""),
        beads=beads_of(total, kind.beads),
        parameters=st.lists(finite, min_size=least, max_size=7).map(tuple),
    )
    lines = draw(st.lists(rows, max_size=4, unique_by=lambda row: same_entry(directive, row.beads)))
    return MoleculeBlock(directive, tuple(lines))  # type: ignore[arg-type]


@st.composite
def rigid_blocks(draw: st.DrawFn, total: int) -> MoleculeBlock:
    order = draw(st.permutations(range(1, total + 1)))
    cut = draw(st.integers(2, total - 2))
    units = [order[:cut], order[cut:]] if draw(st.booleans()) else [order]
    return MoleculeBlock("rigid", tuple(BondedLine("", tuple(unit)) for unit in units))


@st.composite
def pmf_blocks(draw: st.DrawFn, total: int) -> MoleculeBlock:
    order = draw(st.permutations(range(1, total + 1)))
    cut = draw(st.integers(1, total - 1))
    length = draw(st.floats(min_value=1e-3, max_value=1e3))
    rows = [BondedLine("length", (), (length,))]
    for unit in (order[:cut], order[cut:]):
        weights = draw(st.lists(finite, min_size=len(unit), max_size=len(unit)))
        rows.append(BondedLine("unit", tuple(unit), tuple(weights)))
    return MoleculeBlock("pmf", tuple(rows))


@st.composite
def molecules(draw: st.DrawFn, species: list[str]) -> Molecule:
    atom_lines = st.builds(
        AtomLine,
        name=st.sampled_from(species),
        mass=st.floats(min_value=0.0, max_value=1e6),
        charge=finite,
        repeat=st.integers(1, 30),
        frozen=st.integers(0, 2),
    )
    atoms = tuple(draw(st.lists(atom_lines, min_size=1, max_size=4)))
    total = sum(atom.repeat for atom in atoms)
    kinds = [d for d, kind in BONDED.items() if kind.beads <= total] + (["rigid", "pmf"] if total >= 4 else [])
    chosen = draw(st.lists(st.sampled_from(kinds), unique=True, max_size=4))
    makers = {"rigid": rigid_blocks(total), "pmf": pmf_blocks(total)} if total >= 4 else {}
    blocks = tuple(draw(makers[d] if d in makers else bonded_blocks(d, total)) for d in chosen)
    name = draw(st.sampled_from(["", "Water", "H2O model 3", "lipid-1", "(α)"]))
    return Molecule(name, draw(st.integers(0, 10**6)), atoms, blocks)


@st.composite
def fields(draw: st.DrawFn) -> Field:
    species = draw(st.lists(names, min_size=1, max_size=4, unique=True))
    made = tuple(draw(st.lists(molecules(species), min_size=1, max_size=3)))
    known = sorted({atom.name for molecule in made for atom in molecule.atoms})
    pairs = st.tuples(st.sampled_from(known), st.sampled_from(known))
    laws = st.builds(PairLine, species=pairs, key=st.sampled_from(sorted(PAIR_KEYS)), parameters=numbers)
    externals = st.builds(ExternalLine, key=st.sampled_from(sorted(EXTERNAL_KEYS)), parameters=numbers)
    return Field(
        title=draw(titles),
        units=draw(st.sampled_from(["ev", "kcal", "kj", "k", "internal", "dpd"])),
        molecules=made,
        pairs=tuple(draw(st.lists(laws, max_size=4, unique_by=lambda pair: frozenset(pair.species)))),
        externals=tuple(draw(st.lists(externals, max_size=1))),
        rdf_pairs=tuple(draw(st.lists(pairs, max_size=3, unique_by=frozenset))),
    )


@ROUND_TRIP
@given(fields())
def test_field_survives_writing_and_reading(field: Field) -> None:
    text = write_field(field)
    read = parse_field(text)
    assert read == field
    assert write_field(read) == text


# --- CONFIG -----------------------------------------------------------------------------------------------------------


@st.composite
def configurations(draw: st.DrawFn) -> Configuration:
    count = draw(st.integers(1, 6))
    species = draw(st.lists(names, min_size=1, max_size=3, unique=True))
    vectors = arrays(np.float64, (count, 3), elements=finite)
    level, imcon = draw(st.integers(0, 2)), draw(st.sampled_from([0, 1, 2, 3, 6]))
    step, timestep = draw(st.integers(0, 10**12)), draw(st.floats(0.0, 10.0, allow_subnormal=False))
    cells = arrays(np.float64, (3, 3), elements=st.floats(-1e6, 1e6))
    return Configuration(
        names=tuple(draw(st.lists(st.sampled_from(species), min_size=count, max_size=count))),
        positions=draw(vectors),
        title=draw(titles),
        imcon=imcon,
        cell=draw(cells) if imcon else np.zeros((3, 3)),
        velocities=draw(vectors) if level > 0 else None,
        forces=draw(vectors) if level > 1 else None,
        step=step,
        timestep=timestep,
        time=step * timestep if level == 0 else draw(st.floats(0.0, 1e12)),
    )


@ROUND_TRIP
@given(configurations())
def test_configuration_survives_writing_with_all_digits(configuration: Configuration) -> None:
    assert parse_config(write_config(configuration, digits=17)) == configuration


@ROUND_TRIP
@given(configurations())
def test_dl_poly_s_layout_keeps_ten_digits(configuration: Configuration) -> None:
    text = write_config(configuration)
    lines = text.split("\n")
    assert {len(line) for line in lines[:-1]} == {72}
    read = parse_config(text)
    assert (read.names, read.title, read.imcon) == (configuration.names, configuration.title, configuration.imcon)
    assert (read.level, read.step) == (configuration.level, configuration.step)
    for kind in ("positions", "velocities", "forces"):
        given_array, read_array = getattr(configuration, kind), getattr(read, kind)
        if given_array is not None:
            np.testing.assert_allclose(read_array, given_array, rtol=5.1e-10, atol=1e-300)
            # The fast formatting of columns gives the same digits as the exact one of single numbers.
            expected = [fortran_g(value) for value in given_array.ravel()]
            assert [parse_number(word.strip()) for word in expected] == read_array.ravel().tolist()
    np.testing.assert_allclose(read.cell, configuration.cell, rtol=1e-15, atol=5.1e-11)


# --- damage -----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def real_fields(shared: Path) -> list[str]:
    cases = ("run-lipid", "dihedral-opls", "run-extern-gravity", "coul-ewald-imcon3")
    return [(shared / "golden" / case / "FIELD").read_text() for case in cases] + [EVERY_BLOCK]


@pytest.fixture(scope="session")
def real_configs(shared: Path) -> list[str]:
    return [
        "\n".join((shared / "golden" / case / "CONFIG").read_text().split("\n")[:40])
        for case in ("run-lipid", "pair-dpd", "coul-ewald-imcon3")
    ]


EVERY_BLOCK = (
    "all\nunits eV\nmolecules 1\nM\nnummols 3\natoms 6\nA 1 0 4\nB 2 1 2\nshell 1\n1 2 100\nconstraints 1\n1 3 1.5\n"
    "pmf 2.0\npmf unit 1\n1 1.0\npmf unit 2\n5 1\n6 2\nrigid 1\n3 1 2 3\nteth 1\nharm 1 5.0\nbonds 1\nharm 1 2 3 4\n"
    "angles 1\ncos 1 2 3 4 5 6\ndihedrals 1\ncos 1 2 3 4 5 6 1\ninversions 1\nharm 1 2 3 4 5 6\nfinish\nrdf 1\nA B\n"
    "vdw 2\nA A dpd 1 2\nA B tab\nmetal 1\nA A gupt 1 2 3 4 5\nextern\ngrav 0 0 1\nclose\n"
)
WORDS = ["finish", "close", "vdw 3", "units", "molecules 2", "atoms 3", "bonds 1", "rigid 1", "pmf 1", "-1", "1e400"]
WORDS += ["999999999999999999999", "nan", "1/0", "\x00", "٣", "#", "!", "\ufeff", "\u2028", "\x1c", "1_0", "((", "tab"]


def unless_refused(make: Callable[[], Made]) -> Made | None:
    """Return what is made, or None when it is refused in the package's own way."""
    try:
        return make()
    except PydlpolyError:
        return None


def damaged(data: st.DataObject, text: str) -> str:
    """Return a text after some of: a line removed, doubled or moved, a word replaced, characters put in or cut."""
    for _ in range(data.draw(st.integers(1, 4))):
        lines = text.split("\n")
        at = data.draw(st.integers(0, len(lines) - 1))
        match data.draw(st.integers(0, 5)):
            case 0:
                del lines[at]
            case 1:
                lines.insert(at, lines[data.draw(st.integers(0, len(lines) - 1))])
            case 2:
                words = lines[at].split() or [""]
                words[data.draw(st.integers(0, len(words) - 1))] = data.draw(st.sampled_from(WORDS))
                lines[at] = " ".join(words)
            case 3:
                del lines[at:]
            case 4:
                place = data.draw(st.integers(0, len(lines[at])))
                lines[at] = lines[at][:place] + data.draw(st.text(max_size=4)) + lines[at][place:]
            case _:
                lines[at] = data.draw(st.sampled_from(WORDS))
        text = "\n".join(lines)
    return text


@FUZZ
@given(st.data(), st.booleans())
def test_damaged_field_raises_nothing_else(real_fields: list[str], data: st.DataObject, lenient: bool) -> None:
    text = damaged(data, data.draw(st.sampled_from(real_fields)))
    field = unless_refused(lambda: parse_field(text, lenient=lenient))
    written = unless_refused(lambda: write_field(field)) if field else None
    if written is not None:  # what was accepted is a FIELD, and reads back as the same one
        assert parse_field(written, lenient=lenient) == field


@FUZZ
@given(st.data(), st.booleans())
def test_damaged_config_raises_nothing_else(real_configs: list[str], data: st.DataObject, ignore: bool) -> None:
    text = damaged(data, data.draw(st.sampled_from(real_configs)))
    read = unless_refused(lambda: parse_config(text, ignore_indices=ignore))
    if read is None:
        return
    assert np.isfinite(read.positions).all()
    written = unless_refused(lambda: write_config(read, digits=17))
    if written is not None and read.title.isascii() and read.title.isprintable():
        assert parse_config(written) == without_open_cell(read)


def without_open_cell(read: Configuration) -> Configuration:
    """Files without periodicity are written without a cell."""
    if read.imcon:
        return read
    kept = {name: getattr(read, name) for name in ("names", "positions", "title", "velocities", "forces")}
    return Configuration(**kept, step=read.step, timestep=read.timestep, time=read.time)


@FUZZ
@given(st.text())
@example("\n0 0\n\n")
@example("t\n0 0\n\x1f\n0 0 0")
@example("t\nunits\nmolecules\n")
def test_any_text_raises_nothing_else(text: str) -> None:
    for parse in (parse_field, parse_config):
        with suppress(PydlpolyError):
            parse(text)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(content=st.binary(max_size=60))
def test_any_bytes_raise_nothing_else(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "CONFIG"
    path.write_bytes(b"t\n0 0\nA\n" + content)
    with suppress(PydlpolyError):
        assert len(read_config(path).names) >= 1
