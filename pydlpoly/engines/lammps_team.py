"""The ranks of LAMMPS: processes started for a run, or those of the MPI job that this process belongs to."""

from __future__ import annotations

import atexit
import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time as clock
from collections.abc import Iterator, Mapping
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, NoReturn, Protocol

from pydlpoly.engines.lammps_package import lammps_environment, mpiexec, preload_mpi
from pydlpoly.engines.lammps_worker import Failure, Worker, answer_of
from pydlpoly.errors import InputError, RunError

_START_SECONDS = 300.0  # large jobs on slow file systems take their time to import
_END_SECONDS = 10.0
_EXIT = re.compile(r"EXIT STRING: (?P<words>[^\n]+?)\s*$", re.MULTILINE)
# What mpiexec and batch systems tell their processes; a run started inside must not take it for its own.
_JOB_VARIABLES = ("PMI", "PMIX", "OMPI", "HYDI", "HYDRA", "MPI_LOCAL", "MPIR")
_SWITCHES = ("-sf", "-suffix", "-pk", "-package", "-k", "-kokkos")


class Team(Protocol):
    """Ranks of LAMMPS.

    Attributes:
        folder: where the front and rank 0 both can read files.
        ranks: how many there are; ``version``: of LAMMPS.
    """

    folder: Path
    ranks: int
    version: int

    def ask(self, *command: Any) -> list[Any]:
        """Have every rank do a command; return the answers by rank.

        Raises:
            RunError: a rank is gone, or LAMMPS stopped.
        """

    def close(self) -> None:
        """End the ranks."""


def job_of(environment: dict[str, str] | None = None) -> tuple[int, int] | None:
    """Return this process's rank and the number of ranks of the MPI job around it, None outside of jobs."""
    given = dict(os.environ) if environment is None else environment
    names = [("PMI_RANK", "PMI_SIZE"), ("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE")]
    if "SLURM_STEP_ID" in given and "SLURM_STEP_NUM_TASKS" in given:  # of srun; a batch script itself is no rank
        names.append(("SLURM_PROCID", "SLURM_STEP_NUM_TASKS"))
    for rank, size in names:
        if given.get(rank, "").isdigit() and given.get(size, "").isdigit() and int(given[size]) > 1:
            return int(given[rank]), int(given[size])
    return None


def switches_of(accelerator: str) -> list[str]:
    """Return LAMMPS's accelerator switches as words. Raises InputError for words that are no such switches."""
    words = shlex.split(accelerator)
    if words and words[0] not in _SWITCHES:
        raise InputError(f"is no switch of LAMMPS for accelerators; expected {', '.join(_SWITCHES)}", word=words[0])
    return words


class ProcessTeam:
    """Ranks that mpiexec starts on this machine; a single one needs no mpiexec.

    Args:
        ranks: how many.
        switches: of LAMMPS's command line.

    Raises:
        InputError: LAMMPS or mpiexec is missing, or mpiexec belongs to another MPI.
        RunError: the ranks end before they are ready; the text holds what they said.
    """

    def __init__(self, ranks: int, switches: list[str]) -> None:
        environment = {k: v for k, v in lammps_environment().items() if not k.startswith(_JOB_VARIABLES)}
        starter = [mpiexec(), "-n", str(ranks)] if ranks > 1 else []
        self.ranks, self.version = ranks, 0
        self.folder = Path(tempfile.mkdtemp(prefix="pydlpoly-lammps-"))  # readable by this user alone
        self._said = (self.folder / "said").open("w+b")
        self._links: list[Connection] = []
        address = str(self.folder / "front")
        site = ["-S"] if sys.flags.no_site else []
        command = [*starter, sys.executable, *site, "-m", "pydlpoly.engines.lammps_worker", address, *switches]
        server = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            server.bind(address)
            server.listen(ranks)
            self._process = subprocess.Popen(
                command,
                cwd=self.folder,  # a source folder that this process runs in has no compiled core
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=self._said,
                stderr=self._said,
                start_new_session=True,  # Ctrl-C is for the process in front
            )
            self._welcome(server)
        except BaseException:
            self._kill()
            raise
        finally:
            server.close()
        atexit.register(self.close)

    def _welcome(self, server: socket.socket) -> None:
        server.settimeout(0.1)
        until = clock.monotonic() + _START_SECONDS
        links: list[Connection] = []
        while len(links) < self.ranks:
            with suppress(TimeoutError):
                accepted, _ = server.accept()
                accepted.setblocking(True)
                links.append(Connection(accepted.detach()))
                continue
            if self._process.poll() is not None or clock.monotonic() > until:
                raise RunError(self._obituary("LAMMPS did not start"))
        described = []
        for one in links:
            answer = self._received(one, "LAMMPS did not start")
            if isinstance(answer, Failure):
                raise InputError(answer.text)
            described.append((answer, one))
        found = described[0][0]
        if found["ranks"] != self.ranks:
            raise InputError(
                f"mpiexec ({mpiexec()}) belongs to another MPI than LAMMPS, which sees {found['ranks']} rank and not "
                f"{self.ranks}"
            )
        self.version = found["version"]
        self._links = [one for _, one in sorted(described, key=lambda pair: int(pair[0]["rank"]))]

    def ask(self, *command: Any) -> list[Any]:
        """Have every rank do a command; return the answers by rank."""
        if not self._links:
            raise RunError("LAMMPS has ended")
        try:
            for rank in range(self.ranks):
                self._send(rank, command)
            return self._answers()
        except BaseException:
            self._kill()
            raise

    def _answers(self) -> list[Any]:
        answers: list[Any] = [None] * self.ranks
        waiting = {id(link): rank for rank, link in enumerate(self._links)}
        while waiting:
            for link in wait([self._links[rank] for rank in waiting.values()]):
                rank = waiting.pop(id(link))
                answer = self._received(self._links[rank], f"rank {rank} of {self.ranks} of LAMMPS is gone")
                if isinstance(answer, Failure):
                    raise RunError(f"LAMMPS stopped: {answer.text}")
                answers[rank] = answer
        return answers

    def _send(self, rank: int, command: tuple[Any, ...]) -> None:
        try:
            self._links[rank].send(command)
        except OSError:
            raise RunError(self._obituary(f"rank {rank} of {self.ranks} of LAMMPS is gone")) from None

    def _received(self, link: Connection, words: str) -> Any:
        try:
            return link.recv()
        except (EOFError, OSError):
            raise RunError(self._obituary(words)) from None

    def close(self) -> None:
        """End the ranks."""
        if not self._links:
            return
        for link in self._links:
            with suppress(OSError):
                link.send(("end",))
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_END_SECONDS)
        self._kill()

    def _kill(self) -> None:
        for link in self._links:
            link.close()
        self._links = []
        atexit.unregister(self.close)
        process = getattr(self, "_process", None)
        if process is not None and process.poll() is None:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        self._said.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def _obituary(self, words: str) -> str:
        """Return the words and what mpiexec or LAMMPS said."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_END_SECONDS)
        self._said.seek(0)
        text = self._said.read().decode("utf-8", "replace")
        found = _EXIT.search(text)
        if found is not None:
            return f"{words}: {found['words']}"
        code = self._process.poll()
        if code is not None and code < 0:
            return f"{words}: {signal.strsignal(-code)} (signal {-code})"
        if "unsupported PMI version" in text:  # MPICH's library under Open MPI's mpiexec
            return f"{words}: {mpiexec()} belongs to another MPI than LAMMPS"
        last = next((line.strip() for line in reversed(text.splitlines()) if line.strip(" =-")), "it said nothing")
        return f"{words}: {last}"


class JobTeam:
    """The ranks of the MPI job around this process; rank 0 is in front, the others serve.

    One in a process. Whoever loads a scene last has the ranks.

    Raises:
        InputError: mpi4py is missing.
    """

    _only: JobTeam | None = None

    def __init__(self, switches: list[str]) -> None:
        self._comm = _communicator()
        self._switches = switches
        self.ranks = int(self._comm.size)
        self.folder = Path(tempfile.mkdtemp(prefix="pydlpoly-lammps-"))
        self._worker: Worker | None = None
        self._over = False
        self.version = 0
        atexit.register(self.close)

    @classmethod
    def front(cls, switches: list[str]) -> JobTeam:
        """Return the job's team for rank 0. Raises RunError when the job's ranks have been ended."""
        if cls._only is None:
            cls._only = JobTeam(switches)
        if cls._only._over:
            raise RunError("the ranks of this MPI job have ended")
        if cls._only._worker is None:
            cls._only._switches = switches
        return cls._only

    def ask(self, *command: Any) -> list[Any]:
        """Have every rank do a command; return the answers by rank."""
        if self._worker is None:
            self._comm.bcast(("switches", self._switches))
            try:
                self._worker = Worker(self._switches)
            except Failure as failure:
                raise InputError(failure.text) from None
            self.version = self._worker.description()["version"]
        self._comm.bcast(command)
        answers = [_answer(self._worker, command, self._comm)]
        answers += [self._comm.recv(source=rank) for rank in range(1, self.ranks)]
        for answer in answers:
            if isinstance(answer, Failure):
                raise RunError(f"LAMMPS stopped: {answer.text}")
        return answers

    def close(self) -> None:
        """End the other ranks."""
        if not self._over:
            self._over = True
            self._comm.bcast(("end",))
            shutil.rmtree(self.folder, ignore_errors=True)


def enter_job(switches: list[str]) -> tuple[int, int] | None:
    """Take this process's place in the MPI job around it: rank 0 returns, the others serve it and end here.

    Returns:
        Rank and number of ranks; None outside of jobs.
    """
    job = job_of()
    if job is not None and job[0] > 0:
        serve_job()
    if job is not None:
        JobTeam.front(switches)  # whatever happens now, the others are told when this process ends
    return job


def serve_job() -> NoReturn:
    """Serve rank 0 of the MPI job around this process until it ends; then end this process."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # rank 0 decides
    try:
        comm = _communicator()
    except InputError:  # rank 0 says it
        sys.exit(1)
    worker: Worker | None = None
    for command in _commands(comm):
        if command[0] == "switches":
            with suppress(Failure):  # rank 0 says it
                worker = Worker(command[1])
        elif worker is not None:
            comm.send(_answer(worker, command, comm), dest=0)
    sys.exit(0)


def _commands(comm: Any) -> Iterator[tuple[Any, ...]]:
    while True:
        command = comm.bcast(None)
        if command[0] == "end":
            return
        yield command


def _answer(worker: Worker, command: tuple[Any, ...], comm: Any) -> Any:
    answer = answer_of(worker, command)
    if isinstance(answer, Failure) and answer.alone:  # the others wait for this rank for ever
        print(f"pydlpoly: stopped: rank {comm.rank} of LAMMPS: {answer.text}", file=sys.stderr, flush=True)
        comm.Abort(3)
    return answer


def _communicator() -> Any:
    preload_mpi()
    try:
        import mpi4py
    except ImportError:
        message = (
            "a run inside an MPI job needs mpi4py; pip install 'pydlpoly[lammps]' brings it, or leave mpiexec out "
        )
        raise InputError(f"{message}and give --ranks") from None
    mpi4py.rc.initialize, mpi4py.rc.finalize = False, True  # MPI aborts where it cannot start, without a word of ours
    from mpi4py import MPI

    if not MPI.Is_initialized():
        if complaint := foreign_launcher(os.environ, MPI.Get_library_version()):
            raise InputError(complaint)
        MPI.Init_thread()
    return MPI.COMM_WORLD


def foreign_launcher(environment: Mapping[str, str], library: str) -> str:
    """Return in words why ranks of this MPI library cannot find each other in a job, nothing where they can.

    Args:
        environment: of a process of the job.
        library: what MPI says of its version; MPICH says how it was configured, too.
    """
    pmix = "PMIX_RANK" in environment and "PMI_RANK" not in environment
    if not (pmix and library.startswith("MPICH") and "pmix" not in library.lower()):
        return ""
    name = " ".join(library.split("\n")[0].replace("Version:", "").split())
    ways = f"{mpiexec()} or srun --mpi=pmi2"
    return f"{name}, the MPI library of LAMMPS, does not know PMIx, by which this job was started; start it with {ways}"
