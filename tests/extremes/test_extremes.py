"""Every case at a limit: right, refused with the cause, or stopped with the cause; never a number that is wrong."""

from __future__ import annotations

import pytest

from .cases import CASES, Case


def parameters(case: Case) -> object:
    marks = [pytest.mark.slow, pytest.mark.long] if case.slow else []
    return pytest.param(case, id=f"{case.topic}: {case.name}", marks=marks)


@pytest.mark.parametrize("case", [parameters(case) for case in CASES])
def test_case(case: Case) -> None:
    seen = case.run()
    assert seen.holds, f"{seen.happens}: {seen.text()}"


def test_cases_have_different_names() -> None:
    names = [(case.topic, case.name) for case in CASES]
    assert len(set(names)) == len(names)
