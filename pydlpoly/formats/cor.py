"""COR: correlation functions and what follows from them, in the YAML of DL_POLY 5."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pydlpoly.formats.atomic import PathLike, replace_file
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class Correlation:
    """One correlation function.

    Attributes:
        name: such as ``stress_xy-stress_xy``.
        points, blocks, window: shape of the correlator.
        lags: (n,) times; values: (n,).
    """

    name: str
    points: int
    blocks: int
    window: int
    lags: FloatArray
    values: FloatArray


@dataclass(frozen=True)
class Derived:
    """A number that follows from correlation functions: its mean, one value a function, unit, standard error."""

    name: str
    value: float
    components: Sequence[float]
    units: str
    error: float


def write_correlations(
    path: PathLike, title: str, correlations: Sequence[Correlation], derived: Sequence[Derived] = ()
) -> None:
    """Replace COR. The standard ``error`` is an entry of ours; everything else is DL_POLY's.

    Raises:
        RunError: the file cannot be written.
    """
    quoted = title.strip().replace("'", "''")
    lines = ["%YAML 1.2", "---", f"title: '{quoted}'"]
    if derived:
        lines.append("observables:")
        for number in derived:
            lines += [
                f"      {number.name}:",
                f"            value: {_number(number.value)}",
                f"            components: {_numbers(number.components)}",
                f"            units: {number.units}",
                f"            error: {_number(number.error)}",
            ]
    lines.append("correlations:")
    for one in correlations:
        lines += [
            f"      {one.name}:",
            "            parameters:",
            f"                  points_per_block: {one.points}",
            f"                  number_of_blocks: {one.blocks}",
            f"                  window_size: {one.window}",
            f"            lags: {_numbers(one.lags.tolist())}",
            f"            value: {_numbers(one.values.tolist())}",
        ]
    replace_file(Path(path), "\n".join(lines) + "\n")


def _number(value: float) -> str:
    return ".nan" if value != value else f"{value:.8E}"


def _numbers(values: Sequence[float]) -> str:
    return "[ " + ", ".join(map(_number, values)) + " ]"
