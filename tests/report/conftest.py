"""Reports of the runs, each made once for all tests."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from pydlpoly.report import Finding, write_report

from .runs import MAKERS


@dataclass(frozen=True)
class Report:
    folder: Path
    path: Path
    findings: list[Finding]

    @property
    def html(self) -> str:
        return self.path.read_text(encoding="utf-8")

    def level(self, level: str) -> dict[str, str]:
        """Texts of the findings of a level, by subject."""
        return {one.subject: f"{one.text}; {one.advice}" for one in self.findings if one.level == level}


@pytest.fixture(scope="session")
def reports(tmp_path_factory: pytest.TempPathFactory):
    """reports("healthy") -> Report."""
    made: dict[str, Report] = {}

    def report(name: str) -> Report:
        if name not in made:
            folder = MAKERS[name](tmp_path_factory.mktemp("report") / name)
            made[name] = Report(folder, *write_report(folder))
        return made[name]

    return report
