"""OUTPUT: the run's log for people, in the blocks that DL_POLY users know.

Every piece (a text, a block, the summary) is one write that ends with a rule of dashes; a killed run leaves whole
pieces, and continuing cuts what follows the last rule. Energies are in FIELD's unit for the whole system.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import IO

import numpy as np
from numpy.typing import ArrayLike

from pydlpoly.errors import RunError
from pydlpoly.formats.atomic import Closing, FrameFile, PathLike
from pydlpoly.formats.averages import RollingAverages, RunningAverages
from pydlpoly.formats.blocks import Estimate
from pydlpoly.formats.fortran import fortran_e, fortran_f, fortran_i
from pydlpoly.formats.records import FloatArray
from pydlpoly.formats.species_balance import SpeciesBalance, balance_text

__all__ = ["OutputWriter", "RollingAverages", "RunSummary", "RunningAverages"]

RULE = "-" * 130 + "\n"
HEADER_EVERY = 8
QUANTITIES = 27
_LABELS = (
    ("eng_tot", "temp_tot", "eng_cfg", "eng_src", "eng_cou", "eng_bnd", "eng_ang", "eng_dih", "eng_tet"),
    ("eng_pv", "temp_rot", "vir_cfg", "vir_src", "vir_cou", "vir_bnd", "vir_ang", "vir_con", "vir_tet"),
    ("volume", "temp_shl", "eng_shl", "vir_shl", "alpha[o]", "beta[o]", "gamma[o]", "vir_pmf", "press"),
)


@dataclass(frozen=True, eq=False)
class RunSummary:
    """What the end of a run reports.

    Attributes:
        steps, time: where the run ended; time in ps.
        averaged_steps, averaged_time: how many steps, over how long, the averages cover.
        samples: how many records the averages are made of, 0 when that is not known.
        loop_steps: how many steps were taken in ``loop_seconds``; None for all of ``steps``.
        elapsed: wall-clock seconds of the whole run; loop_seconds: of the steps alone.
        averages, fluctuations: at least 37 numbers in the order of ``STATISTICS_NAMES``; fluctuations are r.m.s.
        pressure_parts: average (3, 3) tensors in katm by name (kinetic, conservative, drag, noise, …), which add up to
            the pressure tensor.
        diffusion: for each species the self-diffusion coefficient (10⁻⁹ m²/s) and the root of its mean-square
            displacement (Å).
        warnings: everything the run wants remembered.
        timings: seconds by part of the program.
        doubts: those of the warnings that say that the run's results may be wrong.
        kinetic_temperature, configurational_temperature: averages over the same samples, the second sum over sum; None
            when there are no samples, or nothing acts.
        thermostat_temperature: None without a thermostat, or when it varies.
        energy_drift: of the total energy per bead and unit of time, in nve runs.
        stress_estimates: what was made of samples of the stress: name, estimate and unit.
        species_balance: amounts of dissolved species, and where they came from.
    """

    steps: int
    time: float
    averaged_steps: int
    averaged_time: float
    elapsed: float
    loop_seconds: float
    averages: FloatArray
    fluctuations: FloatArray
    pressure_parts: Mapping[str, FloatArray] = field(default_factory=dict)
    diffusion: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    warnings: Sequence[str] = ()
    timings: Mapping[str, float] = field(default_factory=dict)
    samples: int = 0
    loop_steps: int | None = None
    doubts: Sequence[str] = ()
    kinetic_temperature: Estimate | None = None
    configurational_temperature: Estimate | None = None
    thermostat_temperature: float | None = None
    energy_drift: Estimate | None = None
    stress_estimates: Sequence[tuple[str, Estimate, str]] = ()
    species_balance: Sequence[SpeciesBalance] = ()


class OutputWriter(Closing):
    """Writes OUTPUT piece by piece.

    Args:
        path: the file; the name alone, for messages, when there is a ``stream``.
        version: version of pydlpoly, for the banner.
        title: the run's title.
        append: go on with an existing file after its last whole piece.
        temperature_unit, pressure_unit, time_unit, energy_unit: as printed; an empty text prints none (reduced units).
        stream: write here, for example to the standard output, instead of to a file; it stays open.

    Raises:
        RunError: the file cannot be written.
    """

    def __init__(
        self,
        path: PathLike,
        version: str,
        title: str = "",
        *,
        append: bool = False,
        temperature_unit: str = "K",
        pressure_unit: str = "katm",
        time_unit: str = "ps",
        energy_unit: str = "",
        stream: IO[str] | None = None,
    ) -> None:
        """Open the file and write the banner; see the class."""
        self.path = os.fspath(path)
        self._temperature, self._pressure, self._time = temperature_unit, pressure_unit, time_unit
        self._energy = energy_unit
        self._prints = 0
        self._stream = stream
        self._file: FrameFile | None = None
        banner = _banner(version, title)
        if stream is None:
            self._file = FrameFile(path, banner.encode("utf-8"), append=append, whole_length=_whole_pieces)
        else:
            self._write(banner)
        self.resumed = self._file is not None and self._file.resumed

    def text(self, text: str) -> None:
        """Write a section of free text, for example the explanation of the scene."""
        self._write(text.rstrip("\n") + "\n" + RULE)

    def resume(self, step: int, version: str) -> None:
        """Say that the run continues from a checkpoint, and with which version."""
        self.text(f"continues from step {step} with pydlpoly {version}")

    def block(
        self,
        step: int,
        time: float,
        elapsed: float,
        values: ArrayLike,
        averages: ArrayLike,
        more: Sequence[tuple[str, float]] = (),
    ) -> None:
        """Write one print-out: instantaneous values and rolling averages, under a header every 8 print-outs.

        Args:
            step, time: of the step; time in ps.
            elapsed: seconds since the start.
            values, averages: at least 27 numbers in the order of ``STATISTICS_NAMES``.
            more: words and numbers of this step that follow, as scenes have them that model more.
        """
        starts = (fortran_i(step, 13), fortran_f(time, 13, 5), fortran_f(elapsed, 13, 3))
        header = self._header() if self._prints % HEADER_EVERY == 0 else ""
        body = _lines(starts, values) + "\n" + _lines(_labels("rolling", "averages", ""), averages)
        body += "".join(f"{name:>30}{fortran_e(value, 24, 16)}\n" for name, value in more)
        self._write(header + body + RULE)
        self._prints += 1

    def summary(self, summary: RunSummary) -> None:
        """Write the end of a run: termination, averages and fluctuations, pressure tensor, diffusion, timings."""
        pieces = [self._termination(summary)]
        if summary.averaged_steps > 0:
            pieces += [self._final_averages(summary), self._pressure_tensor(summary)]
            if summary.diffusion:
                pieces.append(_diffusion(summary.diffusion, reduced=not self._time))
        pieces += [self._temperatures(summary), self._energy_drift(summary), _stress_estimates(summary)]
        pieces.append(balance_text(summary.species_balance))
        if summary.warnings:
            pieces.append("Warnings of this run:\n" + "".join(f"  {_one_line(w)}\n" for w in summary.warnings) + "\n")
        pieces.append(_timings(summary))
        self._write("".join(pieces) + RULE)

    def sync(self) -> None:
        """Wait until everything written is on the disk."""
        if self._file is not None:
            self._file.sync()

    def close(self) -> None:
        """Close the file; a stream stays open."""
        if self._file is not None:
            self._file.close()

    def _write(self, text: str) -> None:
        if self._file is not None:
            self._file.write(text.encode("utf-8"))
        elif self._stream is not None:
            try:
                self._stream.write(text)
                self._stream.flush()
            except OSError as error:
                raise RunError(f"{self.path}: cannot be written: {error.strerror or error}") from error

    def _header(self) -> str:
        starts = ("step".rjust(13), _with_unit("time", self._time).rjust(13), "cpu  [s]".rjust(13))
        rows = [list(row) for row in _LABELS]
        for row in rows:
            row[1] = _with_unit(row[1], self._temperature)
        lines = [start + "".join(label.rjust(12) for label in row) for start, row in zip(starts, rows, strict=True)]
        return RULE + "\n".join(lines) + "\n" + RULE

    def _termination(self, summary: RunSummary) -> str:
        unit = f" {self._time}" if self._time else ""
        if summary.averaged_steps == 0:
            return f"run terminated after {summary.steps} steps ( {summary.time:.3f}{unit}), no averages were taken\n\n"
        return (
            f"run terminated after {summary.steps} steps ( {summary.time:.3f}{unit}), final averages calculated over "
            f"{summary.averaged_steps} steps ( {summary.averaged_time:.3f}{unit})"
            + (f" from {summary.samples} samples\n" if summary.samples else "\n")
        )

    def _final_averages(self, summary: RunSummary) -> str:
        starts = (
            fortran_i(summary.averaged_steps, 13),
            fortran_f(summary.averaged_time, 13, 5),
            fortran_f(summary.elapsed, 13, 3),
        )
        averages = _lines(starts, summary.averages)
        fluctuations = _lines(_labels("r.m.s.", "fluctu-", "ations"), summary.fluctuations)
        return self._header() + averages + "\n" + fluctuations + RULE + "\n"

    def _pressure_tensor(self, summary: RunSummary) -> str:
        unit = f"  ({self._pressure})" if self._pressure else ""
        mean = np.asarray(summary.averages)[28:37].reshape(3, 3)
        spread = np.asarray(summary.fluctuations)[28:37].reshape(3, 3)
        text = "Pressure tensor:\n" + f"Average pressure tensor{unit}".rjust(38) + "r.m.s. fluctuations".rjust(41)
        for row, width in zip(mean, spread, strict=True):
            text += "\n" + _row(row) + "   " + _row(width)
        text += "\n" + _trace(mean) + "\n"
        for name, part in summary.pressure_parts.items():
            tensor = np.asarray(part, dtype=np.float64).reshape(3, 3)
            rows = "\n".join(_row(row) for row in tensor)
            text += f"of which {name}{unit}\n{rows}\n{_trace(tensor)}\n"
        return text

    def _temperatures(self, summary: RunSummary) -> str:
        kinetic, configurational = summary.kinetic_temperature, summary.configurational_temperature
        if kinetic is None:
            return ""
        text = f"Temperatures, with standard errors{_samples_of(kinetic)}:\n"
        text += _estimate("kinetic", kinetic, self._temperature)
        if configurational is not None:
            text += _estimate("configurational", configurational, self._temperature)
        if summary.thermostat_temperature is not None:
            text += _estimate("thermostat", summary.thermostat_temperature, self._temperature)
        return text + "\n"

    def _energy_drift(self, summary: RunSummary) -> str:
        if summary.energy_drift is None:
            return ""
        units = [unit for unit in (self._energy, self._time) if unit]
        text = f"Drift of the total energy per bead and time, a straight line{_samples_of(summary.energy_drift)}:\n"
        return text + _estimate("drift", summary.energy_drift, "/".join(units)) + "\n"


def _stress_estimates(summary: RunSummary) -> str:
    if not summary.stress_estimates:
        return ""
    lines = [
        _estimate(name, estimate, unit).rstrip("\n") + f"{_samples_of(estimate)}\n"
        for name, estimate, unit in summary.stress_estimates
    ]
    return "From the stress, with standard errors:\n" + "".join(lines) + "\n"


def _samples_of(estimate: Estimate) -> str:
    return f" from {estimate.samples} samples in {estimate.blocks} blocks"


def _estimate(name: str, estimate: Estimate | float, unit: str) -> str:
    value, error = (estimate.value, estimate.error) if isinstance(estimate, Estimate) else (estimate, None)
    text = f"  {name:<16}{fortran_e(value, 13, 5)}"
    if error is not None:
        text += "  (too few samples for an error)" if np.isnan(error) else f" +-{fortran_e(error, 11, 2)}"
    return f"{text} {unit}".rstrip() + "\n"


def _banner(version: str, title: str) -> str:
    lines = (
        f"pydlpoly {version}",
        "Dissipative particle dynamics from DL_POLY-format files. An independent program: not DL_POLY itself,",
        "nor made by its authors; the layout of this file follows theirs so that its readers feel at home.",
        f"title: {_one_line(title)}",
    )
    return RULE + "\n".join(lines) + "\n" + RULE


def _whole_pieces(handle: IO[bytes]) -> int:
    """Length up to and including the last rule that stands on a line of its own."""
    content = handle.read()
    ends = [match.end() for match in re.finditer(rb"(?m)^-{130}\n", content)]
    return ends[-1] if ends else 0


def _lines(starts: Sequence[str], values: ArrayLike) -> str:
    """Three lines of nine numbers, ``1p,9e12.4`` each, after 13 columns of text."""
    numbers = np.asarray(values, dtype=np.float64)
    if len(numbers) < QUANTITIES:
        raise ValueError(f"a print-out needs {QUANTITIES} quantities, not {len(numbers)}")
    lines = []
    for row, start in enumerate(starts):
        lines.append(start + "".join(fortran_e(v, 12, 4) for v in numbers[9 * row : 9 * row + 9].tolist()) + "\n")
    return "".join(lines)


def _labels(*words: str) -> tuple[str, ...]:
    return tuple(" " * 5 + word.ljust(8) for word in words)


def _with_unit(label: str, unit: str) -> str:
    return f"{label}[{unit}]" if unit else label


def _row(numbers: FloatArray) -> str:
    return "  " + "".join(fortran_e(v, 12, 4) for v in numbers.tolist())


def _trace(tensor: FloatArray) -> str:
    return "  trace/3  " + fortran_e(float(np.trace(tensor)) / 3.0, 12, 4) + "\n"


def _diffusion(diffusion: Mapping[str, tuple[float, float]], *, reduced: bool) -> str:
    text = "Approximate 3D Diffusion Coefficients and square root of MSDs:\n"
    columns = ("DC (reduced)", "Sqrt[MSD]") if reduced else ("DC (10^-9 m^2 s^-1)", "Sqrt[MSD] (Ang)")
    text += f"      atom  {columns[0]:<19}      {columns[1]}\n"
    for species, (coefficient, distance) in diffusion.items():
        numbers = "".join(" " * 8 + fortran_e(v, 13, 4) for v in (coefficient, distance))
        text += f"  {species:<8}{numbers}\n"
    return text + "\n"


def _timings(summary: RunSummary) -> str:
    steps = summary.steps if summary.loop_steps is None else summary.loop_steps
    per_step = summary.loop_seconds / steps if steps else 0.0
    text = "".join(f"{name:<30}{fortran_f(seconds, 12, 3)} sec\n" for name, seconds in summary.timings.items())
    # The sentence has the word order that readers of DL_POLY's OUTPUT look for.
    text += f"Loop time for all the steps: {summary.loop_seconds:.3f} s, time per step: {per_step:.6f} s\n"
    return text + f"time elapsed since job start: {fortran_f(summary.elapsed, 12, 3)} sec\n"


def _one_line(text: str) -> str:
    return " ".join(text.split())
