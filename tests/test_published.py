"""docs/validation.py: the table of published numbers is that of the stored results, and these agree with it."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[1]


def load_script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("docs_validation", ROOT / "docs" / "validation.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # its dataclasses look themselves up there
    spec.loader.exec_module(module)
    return module


SCRIPT = load_script()
FOUND = SCRIPT.results()
ROUGH = {"tension": 0.12}  # a fit that is good to a tenth


def test_the_table_is_current() -> None:
    page = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    assert SCRIPT.table(FOUND) in page, "run `python docs/validation.py`"


def test_results_and_rows_belong_together() -> None:
    keys = [row.key for row in SCRIPT.ROWS]
    assert len(keys) == len(set(keys))
    assert set(keys) == set(FOUND)


@pytest.mark.parametrize("row", SCRIPT.ROWS, ids=lambda row: row.key)
def test_ours_agrees(row: object) -> None:
    """Within four standard errors of both; within 2 % where theirs has none; to the last digit where ours has none."""
    value, error = FOUND[row.key]  # type: ignore[attr-defined]
    published, theirs = row.value, row.error  # type: ignore[attr-defined]
    if theirs:
        assert abs(value - published) < 4.0 * (error**2 + theirs**2) ** 0.5
    elif error:
        assert value == pytest.approx(published, rel=ROUGH.get(row.key, 0.02))  # type: ignore[attr-defined]
    else:
        digits = len(SCRIPT.plain(published).split(".")[1])
        assert abs(value - published) <= 0.6 * 10.0**-digits


def test_an_old_page_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "validation.md"
    page.write_text("before\n<!-- measured: published -->\nold\n<!-- end: published -->\nafter\n", encoding="utf-8")
    monkeypatch.setattr(SCRIPT, "PAGE", page)
    monkeypatch.setattr(sys, "argv", ["validation.py", "--check"])
    assert SCRIPT.main() == 1
    assert "out of date" in capsys.readouterr().out
    monkeypatch.setattr(sys, "argv", ["validation.py"])
    assert SCRIPT.main() == 0
    text = page.read_text(encoding="utf-8")
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "old" not in text
    assert "| pressure, A = 25, ρ = 3 | 23.65 ± 0.02 |" in text
    monkeypatch.setattr(sys, "argv", ["validation.py", "--check"])
    assert SCRIPT.main() == 0


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (23.6514, 0.0026, "23.6514 ± 0.0026"),
        (0.823, 0.012, "0.823 ± 0.012"),
        (1.5, 0.0, "1.500"),
        (100.0, 12.0, "100 ± 12"),
    ],
)
def test_numbers_have_the_digits_of_their_error(value: float, error: float, text: str) -> None:
    assert SCRIPT.with_error(value, error, 3) == text
