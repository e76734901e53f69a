"""Ranks of LAMMPS that the tests of a session share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from pydlpoly.engines.lammps_team import ProcessTeam


@pytest.fixture(scope="session")
def team() -> Iterator[ProcessTeam]:
    """One rank, for what does not depend on their number."""
    ranks = ProcessTeam(1, [])
    yield ranks
    ranks.close()


@pytest.fixture(scope="session")
def two_ranks() -> Iterator[ProcessTeam]:
    """Two ranks, so that forces cross the border between them."""
    ranks = ProcessTeam(2, [])
    yield ranks
    ranks.close()
