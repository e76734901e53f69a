"""What the benchmarks found: records, their JSON form, and their text.

The JSON form is the records as objects, with ``"format": 1``; docs/performance.md lists the members.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

FORMAT = 1


@dataclass(frozen=True)
class Spread:
    """Median and quartiles of repeated measurements."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread:
        """Return those of some values."""
        low, median, high = np.quantile(values, (0.25, 0.5, 0.75)).tolist()
        return cls(median, low, high)

    def text(self, digits: int = 3) -> str:
        """Return ``median (low to high)``."""
        median, low, high = (significant(value, digits) for value in (self.median, self.low, self.high))
        return f"{median} ({low} to {high})"


def significant(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits, without an exponent."""
    if value == 0.0 or not np.isfinite(value):
        return f"{value:g}"
    return f"{value:.{max(0, digits - 1 - int(np.floor(np.log10(abs(value)))))}f}"


@dataclass(frozen=True)
class Contender:
    """One way in which a scene was run.

    Attributes:
        label: its name within the scene.
        program: "pydlpoly", "other" (another build of it) or "lammps".
        threads, precision, simd: what it was asked for; simd None is the best the processor has.
        plan: how it computes: what ``System.plan`` says, or LAMMPS's pair style and neighbour list.
        version, package: which program that was, and where it lies.
        steps: steps in one repetition.
        seconds: of every repetition, in order; the repetitions of all contenders alternate.
        rate: bead-steps a second.
        bytes_per_bead: by how much the memory of the process grew with the simulation; None when not measured.
        temperature: at the start of the repetitions, a sign that the programs computed the same.
    """

    label: str
    program: str
    threads: int
    precision: str
    simd: str | None
    plan: str
    version: str
    package: str
    steps: int
    seconds: tuple[float, ...]
    rate: Spread
    bytes_per_bead: float | None
    temperature: float


@dataclass(frozen=True)
class Comparison:
    """How many times faster one contender is than another: median and quartiles of the ratios of paired repetitions."""

    of: str
    to: str
    ratio: Spread


@dataclass(frozen=True)
class SceneResult:
    """What was found for one scene.

    ``unavailable`` says why it was not run; ``notes`` says what could not be compared.
    """

    name: str
    about: str
    beads: int
    contenders: tuple[Contender, ...] = ()
    comparisons: tuple[Comparison, ...] = ()
    notes: tuple[str, ...] = ()
    unavailable: str | None = None
    failed: bool = False

    def text(self) -> str:
        """Return the result in lines."""
        lines = [f"{self.name}: {self.about}; {self.beads} beads"]
        if self.unavailable is not None:
            word = "failed" if self.failed else "not available"
            return "\n".join([*lines, f"  {word}: {self.unavailable}"])
        for one in self.contenders:
            rate = Spread(*(value / 1e6 for value in (one.rate.median, one.rate.low, one.rate.high)))
            memory = "" if one.bytes_per_bead is None else f"; {one.bytes_per_bead:.0f} bytes a bead"
            lines.append(f"  {one.label}: {rate.text()} million bead-steps a second{memory}; {one.plan}")
        lines += [f"  {one.of} / {one.to}: {one.ratio.text()} times as fast" for one in self.comparisons]
        lines += [f"  note: {note}" for note in self.notes]
        return "\n".join(lines)


@dataclass(frozen=True)
class Machine:
    """Where it was measured.

    Attributes:
        processor: model.
        instruction_sets: those of interest here that it has.
        processors: how many this process may use.
        system: operating system and architecture.
        load: load average over a minute before the first run: more than 0 is other work.
    """

    processor: str
    instruction_sets: tuple[str, ...]
    processors: int
    system: str
    load: float | None

    def text(self) -> str:
        """Return the machine in one line."""
        sets = ", ".join(self.instruction_sets) or "instruction sets not known"
        load = "" if self.load is None else f", load {self.load:.1f} before the start"
        return f"{self.processor} ({sets}), {self.processors} processors, {self.system}{load}"


def this_machine() -> Machine:
    """Return what can be known about this machine."""
    model, flags = platform.processor() or platform.machine(), set[str]()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            name, _, value = line.partition(":")
            if name.strip() == "model name":
                model = value.strip()
            elif name.strip() in ("flags", "Features"):
                flags = set(value.split())
    except OSError:
        pass  # no Linux
    known = ("avx2", "fma", "avx512f", "avx512bw", "avx512vbmi", "asimd", "sve")
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    system = f"{platform.system()} {platform.machine()}"
    return Machine(model, tuple(name for name in known if name in flags), processors, system, load)


@dataclass
class Report:
    """All results of one call of the benchmarks."""

    machine: Machine
    repetitions: int
    scenes: list[SceneResult] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Return the report as JSON objects."""
        return {"format": FORMAT, **asdict(self)}
