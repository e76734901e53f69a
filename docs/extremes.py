"""Runs the cases of tests/extremes and writes docs/extremes.md: what happens at each limit, and the number measured.

``python docs/extremes.py`` takes some ten minutes; with words after it only the topics of these names are run, and the
page is printed instead of written.
"""

from __future__ import annotations

import importlib
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tests.extremes.framework import Case

DOCS = Path(__file__).resolve().parent
_INTRODUCTION = """\
# Extremes

What happens at limits. `python docs/extremes.py` wrote this page by running the cases of `tests/extremes`, which
`tests/extremes/test_extremes.py` runs as tests. Reduced units: k_B T = 1, cutoff 1 and mass 1 where nothing else is
said.

*right*: the number measured is what it should be, within the error stated; so are momentum and the finiteness of
positions, velocities, forces, energies and stress. *refused*: before any step. *stopped*: in the step named.
**Wrong**: the test of the case fails.
"""


def cases() -> list[Case]:
    """Return the cases of the tests, which are a package without an installed name."""
    package = ModuleType("tests")
    package.__path__ = [str(DOCS.parent / "tests")]
    sys.modules["tests"] = package
    found: list[Case] = importlib.import_module("tests.extremes.cases").CASES
    return found


def row(case: Case) -> tuple[bool, str]:
    """Run a case; return whether it is as the tests expect it, and its line of the table."""
    try:
        seen = case.run()
        happens, measured, holds = seen.happens, seen.text(), seen.holds
    except Exception as error:  # a case may fail in any way, and the page says how
        happens, measured, holds = (
            f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}",
            "",
            False,
        )
    if not holds:
        happens = "**Wrong**" + (f" ({happens})" if happens != "right" else "")
    elif happens != "right":
        measured = measured if happens.startswith("stopped") else ""
        measured = measured.split(",")[0]
    cells = [cell.replace("|", "\\|").replace("\n", " ") for cell in (case.name, happens, measured)]
    return holds, "| " + " | ".join(cells) + " |"


def page(chosen: Sequence[Case]) -> tuple[list[str], str]:
    """Return the names of the cases that are not as expected, and the text of the page."""
    lines, unexpected, topic = [_INTRODUCTION], [], ""
    for case in chosen:
        if case.topic != topic:
            topic = case.topic
            lines.append(f"## {topic}\n\n| case | what happens | measured |\n| --- | --- | --- |")
        sys.stderr.write(f"{topic}: {case.name}\n")
        expected, line = row(case)
        if not expected:
            unexpected.append(f"{case.topic}: {case.name}")
        end = "\n" if case is chosen[-1] or chosen[chosen.index(case) + 1].topic != topic else ""
        lines.append(line + end)
    return unexpected, "\n".join(lines).rstrip("\n") + "\n"


def main(topics: Sequence[str]) -> int:
    """Write or print the page; return 1 when a case is not as expected."""
    warnings.simplefilter("ignore")  # the readers' remarks on what the cases ask for
    unexpected, text = page([case for case in cases() if not topics or case.topic in topics])
    if topics:
        sys.stdout.write(text)
    else:
        (DOCS / "extremes.md").write_text(text, encoding="utf-8")
    for name in unexpected:
        sys.stderr.write(f"not as expected: {name}\n")
    return 1 if unexpected else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
