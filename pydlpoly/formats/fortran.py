"""Fortran's edit descriptors (i, f, e, g20.10) for one number and, by columns of bytes, for whole arrays at once.

A column is an array of ASCII codes with one more axis than the values: shape (..., width). Columns are joined along the
last axis and written with ``tobytes``, which formats 10⁶ numbers in a fraction of a second. The results equal those of
a Fortran run-time library that rounds correctly: what the fast path cannot decide (a decimal tie within the rounding
error of one product, a number outside its range) is formatted one by one from Python's exact conversion.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pydlpoly.errors import InputError

ByteColumns = NDArray[np.uint8]

_BLANK, _MINUS, _POINT, _ZERO, _STAR = (ord(c) for c in " -.0*")
_EXACT_POWERS = 10.0 ** np.arange(23)  # the powers of ten that a double holds exactly


def fortran_i(value: int, width: int) -> str:
    """Return ``i<width>``: right-justified, or stars when the number is too long."""
    text = str(int(value))
    return text.rjust(width) if len(text) <= width else "*" * width


def fortran_f(value: float, width: int, decimals: int) -> str:
    """Return ``f<width>.<decimals>``: right-justified, stars when too long; the zero before the point goes first."""
    if not np.isfinite(value):
        return _not_finite(value, width)
    text = f"{value:.{decimals}f}" + ("." if decimals == 0 else "")
    if len(text) == width + 1 and text.lstrip("-").startswith("0."):
        text = text.replace("0.", ".", 1)
    return text.rjust(width) if len(text) <= width else "*" * width


def fortran_e(value: float, width: int, decimals: int, *, scale: int = 1) -> str:
    """Return ``1p,e<width>.<decimals>``, or without the scale factor (0.ddd form) when ``scale`` is 0.

    An exponent of three digits takes the place of the letter: ``1.000000-100``.

    Raises:
        ValueError: ``scale`` is neither 0 nor 1.
    """
    if scale not in (0, 1):
        raise ValueError(f"the scale factor must be 0 or 1, not {scale}")
    if not math.isfinite(value):
        return _not_finite(value, width)
    if scale == 1:  # Python's own form but for long exponents
        text = f"{value:.{decimals}E}"
        text = text.replace("E", "") if text[-4] in "+-" else text
    else:
        sign, digits, exponent = _decimal(value, decimals)
        exponent += 1 if value != 0.0 else 0
        text = f"{sign}0.{digits}{_exponent(exponent)}"
        if len(text) == width + 1:
            text = text.replace("0.", ".", 1)
    return text.rjust(width) if len(text) <= width else "*" * width


def fortran_g(value: float) -> str:
    """Return ``g20.10``: ten digits, F form and four blanks for 0.1 ≤ |x| < 10¹⁰ (after rounding) and for 0, else E."""
    if not np.isfinite(value):
        return _not_finite(value, 20)
    sign, digits, exponent = _decimal(value, 10)
    whole = exponent + 1  # digits before the decimal point
    if value == 0.0:
        return (sign + "0.000000000").rjust(16) + 4 * " "
    if whole == 0:
        return (sign + "0." + digits).rjust(16) + 4 * " "
    if 0 < whole <= 10:
        return (sign + digits[:whole] + "." + digits[whole:]).rjust(16) + 4 * " "
    return (sign + "0." + digits + _exponent(whole)).rjust(20)


def fortran_g20_10(values: ArrayLike) -> ByteColumns:
    """Return ``g20.10`` of every value as bytes.

    Args:
        values: any shape (...).

    Returns:
        ASCII codes, shape (..., 20).
    """
    array = np.asarray(values, dtype=np.float64)
    flat = array.ravel()
    size = np.abs(flat)
    with np.errstate(divide="ignore", invalid="ignore"):
        whole = np.where(np.isfinite(size) & (size > 0.0), np.floor(np.log10(size)) + 1.0, 1.0).astype(np.int64)
    fast = np.isfinite(size) & (whole >= -12) & (whole <= 32)
    mantissa = _scale(np.where(fast, size, 0.0), 10 - np.where(fast, whole, 1))
    number = np.floor(mantissa + 0.5)
    undecided = np.abs(mantissa - np.floor(mantissa) - 0.5) < 1e-5
    undecided |= (number < 1e9) & (size != 0.0)  # log10 landed on the wrong side of a power of ten
    overflow = number >= 1e10
    number[overflow] = 1e9
    whole = whole + overflow
    columns = _g_columns(number.astype(np.int64), whole, np.signbit(flat))
    _one_by_one(columns, flat, ~fast | undecided, fortran_g)
    return np.ascontiguousarray(columns.T).reshape(*array.shape, 20)


def fortran_f_columns(values: ArrayLike, width: int, decimals: int, *, shrink: bool = False) -> ByteColumns:
    """Return ``f<width>.<decimals>`` of every value as bytes, shape (..., width).

    With ``shrink``, a number that Fortran would replace by stars gets fewer decimals, at last the E form, always after
    a blank, so that a reader that splits at blanks still finds it.
    """
    array = np.asarray(values, dtype=np.float64)
    flat = array.ravel()
    size = np.abs(flat)
    limit = 10.0 ** min(width - decimals - 2, 15 - decimals)  # room for a sign, and digits that a double can decide
    fast = size < limit - 1.0 if limit > 1.0 else np.zeros(len(flat), dtype=bool)
    mantissa = np.where(fast, size, 0.0) * _EXACT_POWERS[decimals]
    undecided = np.abs(mantissa - np.floor(mantissa) - 0.5) <= 1e-6 + mantissa * 2.0**-51
    columns = _f_columns(np.floor(mantissa + 0.5).astype(np.int64), np.signbit(flat), width, decimals)
    _one_by_one(columns, flat, ~fast | undecided, lambda v: _fitted_f(v, width, decimals, shrink=shrink))
    return np.ascontiguousarray(columns.T).reshape(*array.shape, width)


def integer_columns(values: ArrayLike, width: int) -> ByteColumns:
    """Return ``i<width>`` of every integer as bytes, shape (..., width)."""
    array = np.asarray(values, dtype=np.int64)
    texts = [fortran_i(v, width) for v in array.ravel().tolist()]
    return np.frombuffer("".join(texts).encode("ascii"), dtype=np.uint8).reshape(*array.shape, width)


def text_columns(texts: Sequence[str], width: int) -> ByteColumns:
    """Return ``a<width>`` of every text as bytes, left-justified, shape (n, width).

    Raises:
        InputError: a text is longer than the column or has a character outside ASCII.
    """
    for text in dict.fromkeys(texts):
        if len(text) > width or not text.isascii():
            raise InputError(f"a name in a DL_POLY file has at most {width} ASCII characters", word=text)
    joined = "".join(text.ljust(width) for text in texts)
    return np.frombuffer(joined.encode("ascii"), dtype=np.uint8).reshape(len(texts), width)


def record(text: str, width: int = 72) -> bytes:
    """Return one record of fixed length: the text cut or padded to ``width`` ASCII characters, and a line feed.

    Characters outside ASCII become ``?``: a byte count that depends on the encoding would break every later record.
    """
    cleaned = " ".join(text.splitlines())
    return cleaned.encode("ascii", "replace")[:width].ljust(width) + b"\n"


def parse_real(word: str) -> float:
    """Read a real number as Fortran does: ``1d-6``, ``1.5+100`` (no letter), ``.5``; a field of stars is NaN.

    Raises:
        ValueError: the word is not a number.
    """
    try:
        return float(word)
    except ValueError:
        pass
    if word and not word.strip("*"):
        return float("nan")
    text = word.lower().replace("d", "e")
    if "e" not in text:
        cut = max(text.rfind("+"), text.rfind("-"))
        if cut > 0:
            text = text[:cut] + "e" + text[cut:]
    return float(text)


def is_real(word: str) -> bool:
    """Return whether ``parse_real`` reads the word."""
    try:
        parse_real(word)
    except ValueError:
        return False
    return True


def parse_reals(words: Sequence[str]) -> NDArray[np.float64]:
    """Read many real numbers as ``parse_real`` does, at the speed of plain ones when all are plain.

    Raises:
        ValueError: a word is not a number.
    """
    try:
        return np.array(words, dtype=np.float64)
    except ValueError:
        return np.array([parse_real(word) for word in words], dtype=np.float64)


def _not_finite(value: float, width: int) -> str:
    if np.isnan(value):
        return "NaN".rjust(width) if width >= 3 else "*" * width
    text = "-Infinity" if value < 0 else "Infinity"
    if len(text) > width:
        text = "-Inf" if value < 0 else "Inf"
    return text.rjust(width) if len(text) <= width else "*" * width


def _decimal(value: float, digits: int) -> tuple[str, str, int]:
    """Sign, significant digits and decimal exponent (of d.ddd) of a number, correctly rounded."""
    text = f"{value:.{digits - 1}e}"
    mantissa, exponent = text.split("e")
    sign = "-" if mantissa.startswith("-") else ""
    return sign, mantissa.lstrip("-").replace(".", ""), int(exponent)


def _exponent(exponent: int) -> str:
    return f"E{exponent:+03d}" if abs(exponent) < 100 else f"{exponent:+04d}"


def _fitted_f(value: float, width: int, decimals: int, *, shrink: bool) -> str:
    text = fortran_f(value, width, decimals)
    if not shrink or "*" not in text:
        return text
    for fewer in range(decimals - 1, 0, -1):
        if len(shorter := f"{value:.{fewer}f}") < width:
            return shorter.rjust(width)
    return f"{value:.{width - 9}E}".rjust(width)


def _scale(size: NDArray[np.float64], power: NDArray[np.int64]) -> NDArray[np.float64]:
    """Multiply by 10**power with one rounding: the powers up to 22 are exact."""
    up = _EXACT_POWERS[np.clip(power, 0, 22)]
    down = _EXACT_POWERS[np.clip(-power, 0, 22)]
    return np.where(power >= 0, size * up, size / down)


def _digits(number: NDArray[np.int64], count: int) -> ByteColumns:
    """The last ``count`` decimal digits of each number as ASCII codes, shape (count, n)."""
    digits = np.empty((count, len(number)), dtype=np.uint8)
    rest = number
    for row in range(count - 1, -1, -1):
        rest, digit = rest // 10, rest % 10
        digits[row] = digit
    return digits + np.uint8(_ZERO)


def _g_columns(number: NDArray[np.int64], whole: NDArray[np.int64], negative: NDArray[np.bool_]) -> ByteColumns:
    """Lay out ten digits as g20.10, (20, n): the E form shares its columns with 0.ddd, then the point moves right."""
    digits = _digits(number, 10)
    scientific = (whole < 0) | (whole > 10)
    point = np.where(scientific, 0, whole)
    columns = np.full((20, len(number)), _BLANK, dtype=np.uint8)
    minus = np.where(negative, _MINUS, _BLANK)
    columns[3] = np.where(point == 0, minus, _BLANK)
    columns[4] = np.where(point == 0, _ZERO, minus)
    for place in range(11):
        before = digits[place] if place < 10 else digits[9]
        after = digits[place - 1] if place > 0 else digits[0]
        columns[5 + place] = np.where(place < point, before, np.where(place == point, _POINT, after))
    exponent = np.abs(whole)
    columns[16] = np.where(scientific, ord("E"), _BLANK)
    columns[17] = np.where(scientific, np.where(whole < 0, _MINUS, ord("+")), _BLANK)
    columns[18] = np.where(scientific, _ZERO + exponent // 10, _BLANK)
    columns[19] = np.where(scientific, _ZERO + exponent % 10, _BLANK)
    return columns


def _f_columns(number: NDArray[np.int64], negative: NDArray[np.bool_], width: int, decimals: int) -> ByteColumns:
    """Lay out integers of 10**-decimals as f<width>.<decimals>, shape (width, n)."""
    columns = np.full((width, len(number)), _BLANK, dtype=np.uint8)
    point = width - decimals - 1
    digits = _digits(number, width - 1)
    columns[point] = _POINT
    columns[point + 1 :] = digits[width - 1 - decimals :]
    whole = number // 10**decimals
    columns[point - 1] = digits[point - 1]
    length = np.ones(len(number), dtype=np.int64)  # digits before the point
    for place in range(point - 2, -1, -1):
        needed = whole >= 10 ** (point - 1 - place)
        columns[place] = np.where(needed, digits[place], _BLANK)
        length += needed
    rows = np.flatnonzero(negative)
    columns[point - 1 - length[rows], rows] = _MINUS
    return columns


def _one_by_one(
    columns: ByteColumns, values: NDArray[np.float64], which: NDArray[np.bool_], write: Callable[[float], str]
) -> None:
    """Overwrite the columns of the chosen values with exactly formatted text."""
    for index in np.flatnonzero(which):
        columns[:, index] = np.frombuffer(write(float(values[index])).encode("ascii"), dtype=np.uint8)
