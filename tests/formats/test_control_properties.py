"""CONTROL by generated examples: what is written reads back as the same record, and no text breaks the reader."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import replace
from random import Random

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pydlpoly.errors import InputError, PydlpolyError
from pydlpoly.formats.control import effect_of, looks_like_dl_meso, parse_control, value_in, write_control
from pydlpoly.formats.control_old_directives import HANDLERS, NAMES
from pydlpoly.formats.keywords import KEYWORDS, SYNONYMS, Keyword
from pydlpoly.formats.records import Control, Setting
from pydlpoly.units import DIMENSIONS

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
WHOLE = st.integers(-(10**18), 10**18)
TEXT = st.text(st.characters(exclude_characters="#!\r\n", exclude_categories=("Cs",)), max_size=60).map(str.strip)


def _units(row: Keyword) -> st.SearchStrategy[str | None]:
    if row.dimension == "any":
        return st.sampled_from([None, "ang", "K"])
    if row.dimension == "number":
        return st.sampled_from([None, "%"])
    return st.sampled_from(DIMENSIONS[row.dimension][1].split(", "))


@st.composite
def _setting(draw: st.DrawFn, row: Keyword) -> Setting:
    if row.kind == "bool":
        return Setting(row.keyword, draw(st.booleans()))
    if row.kind == "option":
        return Setting(row.keyword, draw(st.sampled_from(row.options)))
    if row.kind == "string":
        return Setting(row.keyword, draw(TEXT.filter(bool)))
    if row.kind == "int":
        return Setting(row.keyword, draw(WHOLE))
    if row.kind == "vector":
        sizes = {"min_size": row.length or 1, "max_size": row.length or 5}
        if row.keyword == "random_seed" and draw(st.booleans()):
            return Setting(row.keyword, (draw(st.integers(0, 2**64 - 1)),))
        if row.dimension == "integers":
            return Setting(row.keyword, tuple(draw(st.lists(WHOLE, **sizes))))
        return Setting(row.keyword, tuple(draw(st.lists(NUMBERS, **sizes))), draw(_units(row)))
    unit = draw(_units(row))
    return Setting(row.keyword, draw(WHOLE if unit == "steps" else NUMBERS), unit)


@st.composite
def _control(draw: st.DrawFn) -> Control:
    rows = draw(st.lists(st.sampled_from(list(KEYWORDS.values())), max_size=12, unique_by=lambda row: row.keyword))
    return Control(draw(TEXT), tuple(draw(_setting(row)) for row in rows))


@pytest.mark.parametrize("keyword", KEYWORDS)
@settings(max_examples=5, deadline=None)
@given(data=st.data())
def test_each_keyword_reads_back(keyword: str, data: st.DataObject) -> None:
    control = Control("t", (data.draw(_setting(KEYWORDS[keyword])),))
    assert parse_control(write_control(control)) == control


@settings(max_examples=150, deadline=None)
@given(_control())
def test_whole_files_read_back(control: Control) -> None:
    text = write_control(control)
    again = parse_control(text)
    assert again == control
    assert write_control(again) == text


@settings(max_examples=150, deadline=None)
@given(_control(), st.randoms(use_true_random=False))
def test_letter_case_blanks_and_remarks_do_not_matter(control: Control, random: Random) -> None:
    title, *lines = write_control(control).rstrip("\n").split("\n")
    random.shuffle(lines)
    spaced = [f"\t {line.partition(' ')[0].upper()}   {line.partition(' ')[2]} \t# remark\n" for line in lines]
    assert parse_control(f"\n{title} ! remark\n" + "\n".join(spaced)) == parse_control("\n".join([title, *lines]))


OLD_LINES = [
    "temp 300 K",
    "timestep 0.01 ps",
    "steps 100",
    "ensemble nvt dpds1 4.5",
    "cutoff 2.5",
    "rvdw 2.5",
    "vdw direct",
    "cap 500",
    "trajectory 5 10 2",
    "rdf errors block 5 every 10",
    "seed 1 2 3",
    "pres 0.001",
    "pres tensor 1 2 3 4 5 6",
    "variable timestep 0.1",
    "equil steps 10",
    "ensemble nvt mdvv",
    "ensemble nst hoover 0.5 1 tens 10 semi",
    "ensemble npt lang 1 2",
    "pad 0.2",
    "densvar 5",
    "vdw shift",
    "vdw mixing halgren",
    "no vdw",
    "no elec",
    "no index",
    "no strict",
    "no vom",
    "ewald precision 1d-6",
    "ewald sum 0.3 8 8 8 10",
    "shift damp 0.2",
    "reaction",
    "coul",
    "eps 2",
    "exclude",
    "print 50",
    "stats 20",
    "stack 50",
    "rdf every 10",
    "print rdf",
    "zden 5",
    "vaf 5 20",
    "print vaf",
    "binsize 0.1",
    "msdtmp 5 10",
    "defects 1 2 0.5",
    "coord 1 2 3",
    "adf 10 0.1",
    "analyse all every 5 nbins 10 rmax 2",
    "analyse bonds every 5 nbins 7",
    "collect",
    "zero every 5",
    "scale every 5",
    "regauss every 5",
    "restart",
    "restart noscale",
    "dump 100",
    "job time 10",
    "close time 1",
    "nfold 2 2 2",
    "shake 1d-6",
    "minimise force 10 1",
    "optimise energy 0.1 0.2",
    "pseudo 2 300",
    "impact 1 2 3 4 5 6",
    "io field a/b",
    "io output NONE",
    "io write direct 4",
    "l_scr",
    "l_tor",
    "l_eng",
    "l_print 2",
    "replay",
    "plumed on",
    "plumed log x y",
    "metal direct",
]


@settings(max_examples=200, deadline=None)
@given(TEXT, st.lists(st.sampled_from(OLD_LINES), max_size=8, unique=True))
def test_old_files_read_back_and_convert(title: str, lines: list[str]) -> None:
    try:
        control = parse_control("\n".join([title, *lines, "finish"]))
    except InputError as error:
        assume(not re.search("a second time|is given twice", str(error)))
        raise
    assert parse_control(write_control(control)) == control
    new = parse_control(write_control(replace(control, style="new")))
    assert new.settings == control.settings


# -- Whatever the text, the reader returns a record or raises one of our own errors ------------------------------------


def _read(text: str) -> None:
    looks_like_dl_meso(text)
    for lenient in (False, True):
        with suppress(PydlpolyError):
            _use(parse_control(text, lenient=lenient))


def _use(control: Control) -> None:
    for setting in control:
        effect_of(setting)
        with suppress(PydlpolyError):
            value_in(control, setting.keyword)
    for style in ("new", "old"):
        with suppress(PydlpolyError):
            write_control(replace(control, style=style))


WORDS = st.one_of(
    st.sampled_from([*KEYWORDS, *SYNONYMS, *HANDLERS, *NAMES]),
    st.sampled_from(["title", "finish", "[", "]", "&", "steps", "ps", "ang", "K", "temp", "dpd", "nvt", "every", "%"]),
    st.sampled_from(["1", "-1", "1e308", "1d-308", "1/3", "1e308/1e-300", "0", "nan", "on", "yes", "9" * 30]),
    st.sampled_from(["Ys", "s^9", "mol^-9", "1.1", "/", ".", "^2", "99999999999999.", "k_b.temp"]),
    st.text(max_size=6),
)
LINES = st.lists(WORDS, max_size=7).map(" ".join)


@settings(max_examples=300, deadline=None)
@given(st.sampled_from([("title t", ""), ("a title", "finish"), ("", "")]), st.lists(LINES, max_size=6))
def test_words_of_the_language_in_any_order(ends: tuple[str, str], lines: list[str]) -> None:
    _read("\n".join([ends[0], *lines, ends[1]]))


@settings(max_examples=300, deadline=None)
@given(st.sampled_from([*KEYWORDS, *NAMES]), st.lists(WORDS, min_size=1, max_size=3), st.booleans())
def test_one_keyword_with_any_words(keyword: str, words: list[str], new: bool) -> None:
    line = " ".join([keyword, *words])
    _read(f"title t\n{line}" if new else f"a title\n{line}\nfinish")


@settings(max_examples=150, deadline=None)
@given(st.text(max_size=200))
def test_any_text(text: str) -> None:
    _read(text)
    _read("title t\n" + text)


MODEL_NEW = """\
title DL_POLY_4 CONTROL DIRECTIVES
random_seed [  100  200  300 ]
temperature  298.15 K
cutoff  13.8756 ang
subcelling_threshold_density   50.0 %
ensemble nvt
ensemble_method dpds1
time_run  500000 steps
timestep 2 fs
equilibration_force_cap 1000 k_b.temp/ang
pressure_tensor [ 1 2 3 4 5 6 ] katm
traj_calculate ON
coul_method spme
spme_kvec [ 14 14 14 ]
"""
MODEL_OLD = "\n".join(["DL_POLY: an old file", *OLD_LINES[:11], "finish\n"])


@settings(max_examples=400, deadline=None)
@given(
    st.sampled_from([MODEL_NEW, MODEL_OLD]),
    st.lists(st.tuples(st.integers(0, 400), st.integers(0, 5), st.text(max_size=3)), min_size=1, max_size=4),
)
def test_real_files_with_damage(text: str, cuts: list[tuple[int, int, str]]) -> None:
    for start, length, new in cuts:
        text = text[:start] + new + text[start + length :]
    _read(text)


def test_the_models_are_whole_before_the_damage() -> None:
    assert len(parse_control(MODEL_NEW).settings) == 14
    assert len(parse_control(MODEL_OLD).settings) == 23
