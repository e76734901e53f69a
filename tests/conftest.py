"""Fixtures every test may use: where the golden cases and the public inputs are."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SHARED = ROOT.parent / "shared"


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder beside the repository that holds golden/ and inputs/."""
    if not (SHARED / "golden").is_dir():
        pytest.fail(f"the golden cases are expected at {SHARED}/golden")
    return SHARED
