"""The processes that run a scene, and the conversation with them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.bench.lammps_input import LammpsInput
from pydlpoly.engines.lammps_package import lammps_environment
from pydlpoly.errors import InputError, RunError

__all__ = ["Process", "RefusedError", "isolation", "lammps_environment", "start_lammps", "start_pydlpoly"]

_HERE = Path(__file__).resolve().parent


class RefusedError(RunError):
    """The program is there, but it does not take the command."""


class Process:
    """A program that takes commands and gives answers as JSON lines.

    Args:
        command: the program and its arguments.
        environment: of the program.
        name: what error messages call it.

    Raises:
        RunError: the program ends before it has answered; the text holds what it said.
    """

    def __init__(self, command: list[str], environment: Mapping[str, str], name: str) -> None:
        self._name = name
        self._said = tempfile.TemporaryFile()  # noqa: SIM115  # closed with the process
        pipe = subprocess.PIPE
        try:
            self._process = subprocess.Popen(
                command, env=dict(environment), stdin=pipe, stdout=pipe, stderr=self._said, text=True
            )
        except BaseException:
            self._said.close()
            raise
        try:
            self.description: dict[str, Any] = self._answer()
        except BaseException:
            self.close()
            raise

    def ask(self, **command: Any) -> dict[str, Any]:
        """Send a command and wait for the answer. Raises RunError when there is none."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(command) + "\n")
            self._process.stdin.flush()
        except OSError:
            raise RunError(self._obituary()) from None
        return self._answer()

    def seconds(self, steps: int) -> float:
        """Have steps taken; return how long the program says they took."""
        return float(self.ask(steps=steps)["seconds"])

    def close(self) -> None:
        """End the program."""
        if self._process.stdin is not None and not self._process.stdin.closed:
            self._process.stdin.close()
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._said.close()

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RunError(self._obituary())
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise RefusedError(f"{self._name}: {answer['error']}")
        return answer

    def _obituary(self) -> str:
        self._process.wait()
        self._said.seek(0)
        lines = self._said.read().decode("utf-8", "replace").split("\n")
        words = next((line.strip() for line in reversed(lines) if line.strip()), "it said nothing")
        return f"{self._name} ended with exit code {self._process.returncode}: {words}"

    def __enter__(self) -> Process:
        """Return the running program."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the program, whatever happened."""
        self.close()


def start_pydlpoly(
    scene: str, *, threads: int, precision: str, simd: str | None, state: Path | None, python: str | None = None
) -> Process:
    """Return a process with this scene, ready to be timed.

    Args:
        scene: name in ``scenes``.
        threads, precision: as for ``Simulation``.
        simd: value of PYDLPOLY_SIMD, None for the best the processor has.
        state: file to start from, None to equilibrate.
        python: interpreter with another build of pydlpoly, None for this one.
    """
    environment = {**os.environ, "OMP_NUM_THREADS": str(threads)}
    environment.pop("PYDLPOLY_SIMD", None)
    if simd is not None:
        environment["PYDLPOLY_SIMD"] = simd
    if python is None:  # the same packages, however this interpreter came to them
        environment["PYTHONPATH"] = os.pathsep.join(entry for entry in sys.path if entry)
    else:
        environment.pop("PYTHONPATH", None)
    config = {
        "scene": scene,
        "threads": threads,
        "precision": precision,
        "state": None if state is None else str(state),
        "scenes_file": str(_HERE / "scenes.py"),
    }
    command = [python or sys.executable, *([] if python else isolation()), str(_HERE / "worker.py"), json.dumps(config)]
    try:
        return Process(command, environment, python or "pydlpoly")
    except OSError as error:
        raise InputError(f"cannot be run: {error.strerror}", path=str(python)) from error


def isolation() -> list[str]:
    """The option that keeps a child from packages that this interpreter does not see either."""
    return ["-S"] if sys.flags.no_site else []


def start_lammps(given: LammpsInput, folder: Path, species: NDArray[np.int32], state: Path) -> Process:
    """Return a process with LAMMPS holding the beads of a saved state.

    Raises:
        InputError: LAMMPS is not installed.
        RunError: LAMMPS does not start.
    """
    openmp = any(name.endswith("/omp") for name in given.pairs)
    config: dict[str, object] = {"box": given.box, "dynamics": given.dynamics, "openmp": openmp}
    with np.load(state) as saved:
        positions, velocities = saved["positions"], saved["velocities"]
    types = species.astype(np.int32) + 1
    if given.data is None:
        beads = folder / "beads.npz"
        np.savez(beads, positions=positions, velocities=velocities, types=types)
        config["beads"] = str(beads)
    else:
        data = folder / "beads.data"
        data.write_text(given.data.text(positions, velocities, types), encoding="ascii")
        config["data"] = str(data)
    command = [sys.executable, *isolation(), str(_HERE / "lammps_worker.py"), json.dumps(config)]
    return Process(command, lammps_environment(), "LAMMPS")
