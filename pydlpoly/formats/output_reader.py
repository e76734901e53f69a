"""Reading OUTPUT back: how far a run got, how fast, how it ended, and what it said of itself.

A run that was continued appends to its OUTPUT; what is returned is of the part after the last start, except ``starts``.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import PathLike, read_text
from pydlpoly.formats.fortran import parse_real
from pydlpoly.formats.output import RULE
from pydlpoly.formats.records import FloatArray, IntArray
from pydlpoly.formats.species_balance import SpeciesBalance

_BANNER = re.compile(r"^pydlpoly (\S+)\n", re.MULTILINE)
_RESUMED = re.compile(r"^continues from step (\d+) with pydlpoly \S+$")
_END = re.compile(r"^run terminated after (\d+) steps \(\s*(\S+?)(?: ps)?\)", re.MULTILINE)
_AVERAGED = re.compile(r"final averages calculated over (\d+) steps")
_ESTIMATE = re.compile(
    r"^  (?P<name>\S.{0,15}?) *(?P<value>\S+)(?:  ?\+-\s*(?P<error>\S+))?(?:  \(too few.*\))?(?: \S+)?$"
)
_SECONDS = re.compile(r"^(?P<name>\S.*?)\s+(?P<seconds>\S+) sec$")
_LOOP = re.compile(r"^Loop time for all the steps: (\S+) s, time per step: (\S+) s$", re.MULTILINE)
_MORE = re.compile(r"^(?P<name>.{30})(?P<value>[ \d.E+-]{24})$")
_BALANCE = "Amounts of dissolved species, all beads together:"
_SEED = re.compile(r"^seed (\d+), (\d+) threads")


@dataclass(frozen=True, eq=False)
class OutputLog:
    """What OUTPUT says.

    Attributes:
        version, title: of the banner; the version is that of the last start.
        starts: steps from which the run was started and continued, 0 first.
        explanation: the resolved scene in words, as ``Scene.explain`` wrote it; empty when the file does not reach it.
        seed, threads: None when the file does not reach them.
        steps: (n,) steps of the print-outs; times: (n,) simulated time; elapsed: (n,) wall-clock seconds.
        printed: (n,) of further quantities by name, as scenes print them whose beads carry heat.
        species_balance: what became of the amounts of dissolved species, as the end has it.
        ended: whether the end of the run was written: it was not killed and is not running.
        last_step: the step it ended at, None without an end.
        averaged_steps: how many steps the averages at the end cover, 0 without.
        temperatures: "kinetic", "configurational" and "thermostat" with their errors, not a number where unknown.
        energy_drift: drift per bead and time with its error, of nve runs.
        warnings: as listed at the end.
        timings: seconds by part of the program; loop_seconds: of all steps, None without an end.
    """

    version: str
    title: str
    starts: tuple[int, ...] = (0,)
    explanation: str = ""
    seed: int | None = None
    threads: int | None = None
    steps: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    times: FloatArray = field(default_factory=lambda: np.zeros(0))
    elapsed: FloatArray = field(default_factory=lambda: np.zeros(0))
    printed: Mapping[str, FloatArray] = field(default_factory=dict)
    species_balance: tuple[SpeciesBalance, ...] = ()
    ended: bool = False
    last_step: int | None = None
    averaged_steps: int = 0
    temperatures: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    energy_drift: tuple[float, float] | None = None
    warnings: tuple[str, ...] = ()
    timings: Mapping[str, float] = field(default_factory=dict)
    loop_seconds: float | None = None


def read_output(path: PathLike) -> OutputLog:
    """Read an OUTPUT file of pydlpoly; a piece that a kill cut short is left out.

    Raises:
        InputError: the file is missing, or is not an OUTPUT of pydlpoly.
    """
    name = os.fspath(path)
    text = read_text(path)
    banner = _BANNER.search(text)
    if banner is None:
        raise InputError("is no OUTPUT of pydlpoly: it does not begin with its name and version", path=name)
    pieces = text.split(RULE)[:-1]  # what follows the last rule is torn
    starts, first = [0], 0
    for place, piece in enumerate(pieces):
        if resumed := _RESUMED.match(piece.strip()):
            starts, first = [*starts, int(resumed[1])], place
    part = pieces[first:]
    title = next((line[7:] for line in text.split("\n", 8)[:8] if line.startswith("title: ")), "")
    version = part[0].split()[-1] if first else banner[1]
    blocks = [piece for piece in part if _print_out(piece) is not None]
    end = next((place for place, piece in enumerate(part) if _END.match(piece)), None)
    # The averages at the end look like a print-out.
    blocks = blocks[:-1] if end is not None and len(part) > end + 2 and _AVERAGED.search(part[end]) else blocks
    prints = np.array([_print_out(piece) for piece in blocks], dtype=np.float64).reshape(-1, 3)
    seed = next((found for piece in part if (found := _SEED.match(piece))), None)
    log = OutputLog(
        version,
        title,
        tuple(starts),
        next((piece for piece in part if piece.startswith("Scene\n-----")), ""),
        int(seed[1]) if seed else None,
        int(seed[2]) if seed else None,
        prints[:, 0].astype(np.int64),
        prints[:, 1],
        prints[:, 2],
        _printed(blocks),
    )
    return log if end is None else replace(log, **_summary("\n".join(part[end:])))


def _print_out(piece: str) -> tuple[float, float, float] | None:
    """Step, time and seconds of a print-out: the first numbers of its first three lines."""
    lines = piece.split("\n")
    if len(lines) < 7 or any(len(line) != 121 for line in lines[:3]):
        return None
    try:
        step, time, elapsed = (parse_real(line[:13]) for line in lines[:3])
    except ValueError:
        return None
    return step, time, elapsed


def _printed(blocks: Sequence[str]) -> dict[str, FloatArray]:
    """What print-outs say beside the columns, by name without unit; only what each of them says."""
    rows = [
        {found["name"].split("[")[0].strip(): parse_real(found["value"]) for found in map(_MORE.match, lines) if found}
        for lines in (block.split("\n") for block in blocks)
    ]
    names = [name for name in (rows[0] if rows else ()) if all(name in row for row in rows)]
    return {name: np.array([row[name] for row in rows]) for name in names}


def _balance(text: str) -> tuple[SpeciesBalance, ...]:
    """The table of ``species_balance.balance_text``."""
    found = []
    for line in _section(text, _BALANCE)[1:]:
        name, *words = line.split()
        start, sources, reactions, held, _, remainder = (parse_real(word) for word in words)
        # The printed remainder has more digits than what the rounded numbers would leave.
        found.append(
            SpeciesBalance(name, start, sources, reactions, held, start + sources + reactions + held + remainder)
        )
    return tuple(found)


def _summary(text: str) -> dict[str, Any]:
    """What the end of a run holds, by attribute of ``OutputLog``."""
    end, averaged, loop = _END.search(text), _AVERAGED.search(text), _LOOP.search(text)
    assert end is not None
    drift = _estimates(text, "Drift of the total energy")
    timings = {found["name"]: parse_real(found["seconds"]) for found in map(_SECONDS.match, text.split("\n")) if found}
    return {
        "ended": loop is not None,
        "last_step": int(end[1]),
        "averaged_steps": int(averaged[1]) if averaged else 0,
        "temperatures": _estimates(text, "Temperatures, with standard errors"),
        "energy_drift": drift.get("drift"),
        "species_balance": _balance(text),
        "warnings": tuple(line.strip() for line in _section(text, "Warnings of this run:")),
        "timings": {name: seconds for name, seconds in timings.items() if not name.endswith(":")},
        "loop_seconds": parse_real(loop[1]) if loop else None,
    }


def _section(text: str, begin: str) -> list[str]:
    """The indented lines below the line that begins so."""
    found = re.search(rf"^{re.escape(begin)}.*\n((?:  .*\n)*)", text, re.MULTILINE)
    return found[1].splitlines() if found else []


def _estimates(text: str, begin: str) -> dict[str, tuple[float, float]]:
    found = {}
    for line in _section(text, begin):
        if match := _ESTIMATE.match(line):
            error = parse_real(match["error"]) if match["error"] else float("nan")
            found[match["name"]] = parse_real(match["value"]), error
    return found
