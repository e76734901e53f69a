"""COR read back: what was written, and what is wrong with a file that was cut or is another one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.cor import Correlation, Derived, read_cor, write_correlations

LAGS = np.array([0.0, 0.1, 0.25])
SHEAR = Correlation("stress_xy-stress_xy", 3, 2, 2, LAGS, np.array([2.0, -1e-30, 3.5e-3]), np.array([0.1, 0.2, np.nan]))
OTHER = Correlation("stress_xx-stress_yy", 2, 1, 1, LAGS[:2], np.array([5.0, 4.0]))
DERIVED = [
    Derived("viscosity", 0.5, [0.4, 0.6], "katm ps", float("nan")),
    Derived("kinematic-viscosity", 0.25, [0.2, 0.3], "reduced", 0.01),
]


def test_what_was_written_is_read(tmp_path: Path) -> None:
    write_correlations(tmp_path / "COR", "it's 5: a title", [SHEAR, OTHER], DERIVED)
    read = read_cor(tmp_path / "COR")
    assert read.title == "it's 5: a title"
    for one, other in zip(read.correlations, (SHEAR, OTHER), strict=True):
        assert (one.name, one.points, one.blocks, one.window) == (other.name, other.points, other.blocks, other.window)
        np.testing.assert_array_equal(one.lags, other.lags)
        np.testing.assert_array_equal(one.values, other.values)
    assert SHEAR.errors is not None
    np.testing.assert_array_equal(read.correlations[0].errors, SHEAR.errors)
    assert read.correlations[1].errors is None
    assert list(read.derived) == ["viscosity", "kinematic-viscosity"]
    assert np.isnan(read.derived["viscosity"].error)
    assert read.derived["viscosity"].components == [0.4, 0.6]
    assert read.derived["kinematic-viscosity"] == DERIVED[1]


def test_a_file_without_our_entries_is_read(tmp_path: Path) -> None:
    """DL_POLY has no errors, and observables only where it derives some."""
    write_correlations(tmp_path / "COR", "title", [OTHER])
    read = read_cor(tmp_path / "COR")
    assert read.derived == {}
    assert [one.name for one in read.correlations] == ["stress_xx-stress_yy"]


def test_a_file_that_is_cut_is_told(tmp_path: Path) -> None:
    """Wherever it is cut, it is refused or what is read is a beginning of it."""
    write_correlations(tmp_path / "COR", "title", [SHEAR, OTHER], DERIVED)
    text = (tmp_path / "COR").read_text()
    refused = []
    for end in range(0, len(text) - 2, 3):
        (tmp_path / "CUT").write_text(text[:end])
        try:
            read = read_cor(tmp_path / "CUT")
        except InputError as error:
            refused.append(str(error))
        else:
            np.testing.assert_array_equal(read.correlations[0].values, SHEAR.values)
    assert len(refused) > 0.7 * len(text) / 3
    assert all(told.startswith(str(tmp_path / "CUT")) for told in refused)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("correlations:", "other:", "is no COR: it has no correlations"),
        ("2.00000000E+00", "two", "'two': expected a number"),
        ("2.00000000E+00, ", "", "has 3 lags and 2 values"),
        ("            lags: [ 0.00000000E+00, 1.00000000E-01, 2.50000000E-01 ]\n", "", "has no lags"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path: Path, old: str, new: str, told: str) -> None:
    write_correlations(tmp_path / "COR", "title", [SHEAR])
    text = (tmp_path / "COR").read_text()
    assert old in text
    (tmp_path / "COR").write_text(text.replace(old, new))
    with pytest.raises(InputError, match=told):
        read_cor(tmp_path / "COR")
