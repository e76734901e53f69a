"""Fortran's edit descriptors against known outputs and against exact decimal arithmetic."""

from __future__ import annotations

from decimal import ROUND_HALF_EVEN, Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pydlpoly.errors import InputError
from pydlpoly.formats.fortran import (
    fortran_e,
    fortran_f,
    fortran_f_columns,
    fortran_g,
    fortran_g20_10,
    fortran_i,
    integer_columns,
    parse_real,
    parse_reals,
    record,
    text_columns,
)

# What (g20.10) prints in Fortran 2003 with correct rounding.
G20_10 = [
    (0.0, "     0.000000000    "),
    (-0.0, "    -0.000000000    "),
    (0.5, "    0.5000000000    "),
    (1.524566588, "     1.524566588    "),
    (-12.34, "    -12.34000000    "),
    (123456789.0, "     123456789.0    "),
    (1234567890.1, "     1234567890.    "),
    (-9999999999.0, "    -9999999999.    "),
    (9999999999.5, "    0.1000000000E+11"),
    (1e10, "    0.1000000000E+11"),
    (0.1, "    0.1000000000    "),
    (0.09999999999999, "    0.1000000000    "),
    (0.0999999999, "    0.9999999990E-01"),
    (1.23456789e-6, "    0.1234567890E-05"),
    (-1.23456789e-6, "   -0.1234567890E-05"),
    (1e-100, "    0.1000000000E-99"),
    (1e-101, "    0.1000000000-100"),
    (-1e300, "   -0.1000000000+301"),
    (float("nan"), "                 NaN"),
    (float("inf"), "            Infinity"),
    (float("-inf"), "           -Infinity"),
]


def text(columns: np.ndarray) -> str:
    return columns.tobytes().decode("ascii")


@pytest.mark.parametrize(("value", "expected"), G20_10)
def test_g20_10_prints_what_fortran_prints(value: float, expected: str) -> None:
    assert len(expected) == 20
    assert fortran_g(value) == expected
    assert text(fortran_g20_10(value)) == expected


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_g20_10_keeps_ten_correctly_rounded_digits(value: float) -> None:
    printed = text(fortran_g20_10(value))
    assert len(printed) == 20
    if value == 0.0:
        assert float(printed) == 0.0
        return
    exact = Decimal(value)  # every double is a finite decimal
    unit = Decimal(1).scaleb(exact.adjusted() - 9)
    rounded = (exact / unit).quantize(Decimal(1), ROUND_HALF_EVEN) * unit
    word = printed.strip()
    if "E" not in word and ("+" in word or "-" in word[1:]):
        word = word[:-4] + "E" + word[-4:]  # three digits of exponent take the letter's place
    assert Decimal(word) == rounded
    fixed = printed.endswith("    ")
    assert fixed == (Decimal("0.1") <= abs(rounded) < Decimal(10) ** 10)


@given(st.lists(st.floats(), min_size=1, max_size=30))
def test_the_columns_equal_the_single_numbers(values: list[float]) -> None:
    assert text(fortran_g20_10(values)) == "".join(fortran_g(v) for v in values)
    assert text(fortran_f_columns(values, 20, 10)) == "".join(fortran_f(v, 20, 10) for v in values)
    assert text(fortran_f_columns(values, 12, 6)) == "".join(fortran_f(v, 12, 6) for v in values)


def test_a_large_random_sample_in_columns_equals_python_s_exact_conversion() -> None:
    generator = np.random.default_rng(7)
    values = generator.normal(size=20000) * 10.0 ** generator.uniform(-14, 14, 20000)
    columns = fortran_g20_10(values)
    assert [text(row) for row in columns] == [fortran_g(v) for v in values.tolist()]


def test_numbers_next_to_a_decimal_tie_or_a_power_of_ten_in_columns() -> None:
    """Where one rounding of the fast path could tip the last digit, or log10 the number of digits."""
    generator = np.random.default_rng(9)
    ties = [
        float(f"{n}5e{k}") for n, k in zip(generator.integers(10**9, 10**10, 4000), [*range(-20, 5)] * 160, strict=True)
    ]
    powers = 10.0 ** np.arange(-12, 13)
    near = [*powers, *np.nextafter(powers, 0.0), *np.nextafter(powers, np.inf), *(powers * (1.0 - 4e-11))]
    values = np.array([*ties, *near])
    assert [text(row) for row in fortran_g20_10(values)] == [fortran_g(v) for v in values.tolist()]
    halves = np.array([float(f"{n}5e-7") for n in generator.integers(0, 10**7, 4000)])
    assert [text(row) for row in fortran_f_columns(halves, 12, 6)] == [fortran_f(v, 12, 6) for v in halves.tolist()]


def test_ties_in_decimal_round_to_even_as_fortran_does() -> None:
    # Halves are exact doubles, so these are true ties.
    assert [text(fortran_f_columns(v, 12, 6)) for v in (0.0000005, 0.5 / 2**7, 1.5)] == [
        "    0.000000",  # the nearest double is just below the tie
        "    0.003906",  # 0.00390625 exactly
        "    1.500000",
    ]
    assert text(fortran_f_columns(0.5, 4, 0)) == "  0."
    assert text(fortran_f_columns(1.5, 4, 0)) == "  2."


def test_the_other_descriptors() -> None:
    assert fortran_i(-42, 6) == "   -42"
    assert fortran_i(12345, 4) == "****"
    assert fortran_f(-0.25, 8, 3) == "  -0.250"
    assert fortran_f(0.25, 4, 3) == ".250"
    assert fortran_f(12345.0, 8, 3) == "********"
    assert fortran_e(1234.5678, 14, 6) == "  1.234568E+03"
    assert fortran_e(-1.5e-120, 14, 6) == " -1.500000-120"
    assert fortran_e(1234.5678, 14, 6, scale=0) == "  0.123457E+04"
    assert fortran_e(0.0, 12, 4) == "  0.0000E+00"
    assert fortran_e(0.0, 12, 4, scale=0) == "  0.0000E+00"
    with pytest.raises(ValueError, match="scale factor"):
        fortran_e(1.0, 12, 4, scale=2)


def test_a_field_that_would_overflow_shrinks_on_request_and_keeps_its_blank() -> None:
    values = [99999.999999, 123456.75, -123456.75, 1e9, 1e13]
    assert text(fortran_f_columns(values[1], 12, 6)) == "*" * 12
    words = text(fortran_f_columns(values, 12, 6, shrink=True))
    assert [len(words), words[12:24]] == [60, " 123456.7500"]
    np.testing.assert_allclose([float(w) for w in words[12:].split()], values[1:], rtol=1e-3)


def test_text_integer_and_record_columns() -> None:
    assert text(text_columns(["W", "HEADBEAD"], 8)) == "W       HEADBEAD"
    assert text(integer_columns([1, 100000], 6)) == "     1100000"
    assert record("a title") == b"a title".ljust(72) + b"\n"
    assert len(record("x" * 100 + "\n")) == 73
    assert record("Å") == b"?".ljust(72) + b"\n"
    with pytest.raises(InputError, match="'NINECHARS': a name in a DL_POLY file has at most 8"):
        text_columns(["NINECHARS"], 8)
    with pytest.raises(InputError, match="8 ASCII"):
        text_columns(["β"], 8)


def test_fortran_numbers_are_read() -> None:
    words = ["1d-6", "5.d-4", "1.5+100", "-1.5-100", ".5", "10000.", "-2E3"]
    np.testing.assert_array_equal(parse_reals(words), [1e-6, 5e-4, 1.5e100, -1.5e-100, 0.5, 1e4, -2e3])
    assert np.isnan(parse_real("****"))
    with pytest.raises(ValueError, match="could not convert"):
        parse_real("abc")
