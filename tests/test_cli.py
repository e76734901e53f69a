"""The command line: what it prints, its exit codes, signals, and that no user error ends in a traceback."""

from __future__ import annotations

import os
import pty
import re
import select
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import pydlpoly
from pydlpoly.cli import example_names, main
from pydlpoly.formats.config import read_config
from pydlpoly.formats.control import read_control
from pydlpoly.formats.history import read_history, read_history_header
from pydlpoly.formats.statis import read_statistics

from .run_folders import listing, run_folder

# The installed script: from the repository root, -m would find the source folder without the compiled core.
COMMAND = [str(Path(sys.executable).with_name("pydlpoly"))]
LONG = {
    "time_run": "200000 steps",
    "stats_frequency": "100 steps",
    "diagnostics_frequency": "200 steps",
    "traj_interval": "500 steps",
    "print_frequency": "5000 steps",
    "rdf_frequency": "500 steps",
    "data_dump_frequency": "1000 steps",
}
RESULTS = ("REVCON", "STATIS", "HISTORY", "RDFDAT")


class Outcome:
    def __init__(self, code: object, out: str, err: str) -> None:
        self.code, self.out, self.err = code, out, err


@pytest.fixture
def cli(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """Call the command in this process: cli("run", folder) -> Outcome."""

    def call(*words: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["pydlpoly", *(str(word) for word in words)])
        with pytest.raises(SystemExit) as stop:
            main()
        captured = capsys.readouterr()
        return Outcome(stop.value.code, captured.out, captured.err)

    return call


def test_version_by_both_names(cli) -> None:
    assert cli("--version").out == f"pydlpoly {pydlpoly.__version__}\n"
    module = subprocess.run(
        [sys.executable, "-m", "pydlpoly", "--version"], capture_output=True, text=True, check=True, cwd="/"
    )
    assert module.stdout == f"pydlpoly {pydlpoly.__version__}\n"


def test_run_writes_the_files_and_says_how_it_went(cli, tmp_path: Path) -> None:
    run_folder(tmp_path)
    done = cli("run", tmp_path, "--threads", "1")
    assert done.code == 0
    assert done.err == ""
    words = r"step 40: T = [\d.]+, P = [\d.]+, [\d.]+ million bead-steps a second; seed \d+; files in \S+\n"
    assert re.fullmatch(words, done.out), done.out
    assert set(listing(tmp_path)) >= {"OUTPUT", "STATIS", "HISTORY", "RDFDAT", "REVCON", "REVIVE"}


def test_quiet_is_quiet(cli, tmp_path: Path) -> None:
    done = cli("run", run_folder(tmp_path), "--quiet")
    assert (done.code, done.out, done.err) == (0, "", "")


@pytest.mark.parametrize("example", example_names())
def test_examples_run_check_and_explain(cli, tmp_path: Path, example: str) -> None:
    done = cli("run", "--example", example, "--steps", "2", "--output", tmp_path / "new" / "out", "--threads", "1")
    assert done.code == 0
    assert (tmp_path / "new" / "out" / "REVIVE").is_file()
    checked = cli("check", "--example", example)
    assert checked.code == 0
    assert checked.out.splitlines()[-1].startswith("ok: ")
    explained = cli("explain", "--example", example)
    assert explained.code == 0
    assert "Pair table" in explained.out


def test_check_gives_the_timestep_in_the_scenes_unit(cli, tmp_path: Path) -> None:
    run_folder(tmp_path)
    assert cli("check", tmp_path).out.endswith("ok: 160 beads of 2 species, 40 steps of 0.01\n")
    assert cli("check", "--example", "argon").out.endswith("of 0.005 ps\n")


def test_check_and_explain_write_nothing(cli, tmp_path: Path) -> None:
    before = listing(run_folder(tmp_path))
    cli("check", tmp_path)
    cli("explain", tmp_path)
    assert listing(tmp_path) == before


@pytest.mark.parametrize("command", ["run", "check", "explain"])
@pytest.mark.parametrize(
    ("file", "old", "new", "expected"),
    [
        ("CONTROL", "timestep 0.01", "timstep 0.01", r"CONTROL:8: 'timstep': .*did you mean timestep"),
        ("CONTROL", "ensemble nvt", "ensemble pmf", r"CONTROL:3: 'ensemble': .*not modelled"),
        ("CONTROL", "timestep 0.01 dpd_t", "timestep -1 ps", r"CONTROL:8: 'timestep': "),
        ("FIELD", "A B dpd 30.0", "A C dpd 30.0", r"FIELD:16: 'C': "),
        ("FIELD", "A B dpd 30.0", "A B dpq 30.0", r"FIELD:16: 'dpq': "),
        ("FIELD", "nummols 120", "nummols 121", r"CONFIG"),
        ("CONFIG", "0 1 160", "0 9 160", r"CONFIG"),
        ("CONFIG", "A 1\n", "A 1\nwords\n", r"CONFIG:7"),
    ],
)
def test_refused_input(cli, tmp_path: Path, command: str, file: str, old: str, new: str, expected: str) -> None:
    run_folder(tmp_path)
    text = (tmp_path / file).read_text()
    assert old in text
    (tmp_path / file).write_text(text.replace(old, new, 1))
    before = listing(tmp_path)
    refused = cli(command, tmp_path)
    assert refused.code == 1
    assert refused.out == ""
    assert re.match(r"pydlpoly: .*" + expected, refused.err), refused.err
    assert refused.err.count("\n") == 1
    assert listing(tmp_path) == before


@pytest.mark.parametrize("file", ["CONTROL", "FIELD", "CONFIG"])
@pytest.mark.parametrize("damage", ["missing", "folder", "empty", "binary"])
def test_damaged_files(cli, tmp_path: Path, file: str, damage: str) -> None:
    path = run_folder(tmp_path) / file
    path.unlink()
    if damage == "folder":
        path.mkdir()
    elif damage != "missing":
        path.write_bytes(b"" if damage == "empty" else bytes(range(256)) * 40)
    before = listing(tmp_path)
    refused = cli("run", tmp_path)
    assert refused.code == 1
    assert re.match(rf"pydlpoly: .*{file}", refused.err), refused.err
    assert refused.err.count("\n") == 1
    assert listing(tmp_path) == before


def test_missing_folder_and_file_in_place_of_a_folder(cli, tmp_path: Path) -> None:
    refused = cli("run", tmp_path / "nowhere")
    assert refused.code == 1
    assert re.fullmatch(r"pydlpoly: \S+/nowhere/CONTROL: there is no such file; .*\n", refused.err)
    refused = cli("run", run_folder(tmp_path) / "CONFIG")
    assert refused.code == 1
    assert re.fullmatch(r"pydlpoly: \S+/CONFIG: it is a file; expected a folder with .*\n", refused.err)


def test_title_that_is_not_utf8(cli, tmp_path: Path) -> None:
    run_folder(tmp_path)
    text = (tmp_path / "CONTROL").read_bytes().replace(b"title test run", "title Lösung".encode("latin-1"))
    (tmp_path / "CONTROL").write_bytes(text)
    assert cli("run", tmp_path, "--quiet").code == 0


def test_terminal_without_the_letters_of_the_title(tmp_path: Path) -> None:
    run_folder(tmp_path, {"title": "γ = 4.5 Å"})
    plain = {**os.environ, "PYTHONIOENCODING": "latin-1", "PYTHONUTF8": "0"}
    done = subprocess.run([*COMMAND, "explain", str(tmp_path)], capture_output=True, env=plain, check=False)
    assert done.returncode == 0
    assert done.stderr == b""
    assert "\\u03b3 = 4.5 Å" in done.stdout.decode("latin-1")


@pytest.mark.parametrize(
    "words",
    [
        ["run"],
        ["run", "FOLDER", "--example", "water"],
        ["run", "FOLDER", "--steps", "-1"],
        ["run", "FOLDER", "--threads", "0"],
        ["run", "FOLDER", "--threads", "1000000"],
        ["run", "FOLDER", "--seed", str(2**64)],
        ["run", "FOLDER", "--resume", "--seed", "1"],
        ["run", "FOLDER", "--stepz", "1"],
        ["jog", "FOLDER"],
        ["convert", "FOLDER/CONTROL", "--to", "middle"],
    ],
)
def test_wrong_usage_is_2(cli, tmp_path: Path, words: list[str]) -> None:
    before = listing(run_folder(tmp_path))
    outcome = cli(*(word.replace("FOLDER", str(tmp_path)) for word in words))
    assert outcome.code == 2
    assert "Traceback" not in outcome.err
    assert listing(tmp_path) == before


def test_unknown_example_names_the_nearest(cli) -> None:
    refused = cli("run", "--example", "watter")
    assert refused.code == 1
    assert "'watter'" in refused.err
    assert "did you mean water?" in refused.err


def test_a_run_that_explodes_is_3_and_says_where_to_go_on(cli, tmp_path: Path) -> None:
    run_folder(tmp_path, {"timestep": "1e9 dpd_t", "time_run": "4000 steps"})
    stopped = cli("run", tmp_path, "--quiet")
    assert stopped.code == 3
    assert re.match(
        r"pydlpoly: stopped: step \d+: the momentum of bead \d+ .*; no checkpoint had been written yet\n", stopped.err
    )
    assert "the run stopped: step" in (tmp_path / "OUTPUT").read_text()
    assert not (tmp_path / "REVIVE").exists()


def test_convert_there_and_back(cli, tmp_path: Path) -> None:
    """What is converted loads as an equal scene, through the standard output and through --output."""
    run_folder(tmp_path, {"equilibration_force_cap": "1000.0 k_b.temp/ang", "rescale_frequency": "5 steps"})
    original = read_control(tmp_path / "CONTROL")
    old = cli("convert", tmp_path / "CONTROL", "--to", "old")
    assert old.code == 0, old.err
    (tmp_path / "OLD").write_text(old.out)
    assert read_control(tmp_path / "OLD").style == "old"
    assert cli("convert", tmp_path / "OLD", "--output", tmp_path / "NEW").out == ""
    assert read_control(tmp_path / "NEW").style == "new"
    scenes = [pydlpoly.load(tmp_path, control=name) for name in ("CONTROL", "OLD", "NEW")]
    for scene in scenes[1:]:
        assert scene.dynamics == scenes[0].dynamics
        assert scene.run == scenes[0].run
        assert scene.output == scenes[0].output
        assert [p.parameters for p in scene.pairs] == [p.parameters for p in scenes[0].pairs]
    assert {s.keyword for s in read_control(tmp_path / "NEW")} >= {s.keyword for s in original}


OLD_WITH_EVERYTHING = """a run with everything that has a meaning here
temperature 1.2027165301233615
ensemble nvt mdvv
cutoff 1.0
rvdw 1.0
vdw direct
vdw mixing hogervorst
vdw shift
timestep 0.01
steps 400
equilibration 100
collect
cap 500.0
scale every 10
regauss every 50
seed 4 5 6
no vom
print every 50
stats every 10
stack 200
trajectory 100 50 2
rdf every 10
binsize 0.1
print rdf
dump 200
yml_statis
io output MYOUT
io history MYTRAJ
no elec
job time 100000.0
close time 10.0
finish
"""


def test_convert_an_old_file_with_everything(cli, tmp_path: Path) -> None:
    run_folder(tmp_path)
    (tmp_path / "CONTROL").write_text(OLD_WITH_EVERYTHING)
    for style in ("new", "old"):
        done = cli("convert", tmp_path / "CONTROL", "--to", style, "--output", tmp_path / style)
        assert done.code == 0, done.err
        first, second = pydlpoly.load(tmp_path), pydlpoly.load(tmp_path, control=style)
        assert (first.dynamics, first.run, first.output) == (second.dynamics, second.run, second.output)
        assert first.run.regauss_every == 50
        assert first.output.trajectory_level == 2
        for one, other in zip(first.pairs, second.pairs, strict=True):
            assert (one.parameters, one.cutoff, one.drag) == (other.parameters, other.cutoff, other.drag)
            assert one.force_shift == other.force_shift


def test_convert_keeps_the_scene_of_public_inputs(cli, shared: Path, tmp_path: Path) -> None:
    """Each CONTROL that makes a scene makes the same one in the other style, and in its own style once more."""
    compared = 0
    for path in [shared / "inputs/dl_poly/water-ndpd/CONTROL", *sorted((shared / "golden").glob("*/CONTROL"))]:
        try:
            scene = pydlpoly.load(path.parent, lenient=True)
        except pydlpoly.InputError:
            continue
        source = path
        for style in ("new", "old", "new"):
            target = tmp_path / style
            outcome = cli("convert", source, "--to", style, "--output", target, "--lenient")
            assert outcome.code == 0, (path, outcome.err)
            again = pydlpoly.load(path.parent, control=target, lenient=True)
            assert (again.dynamics, again.run, again.output) == (scene.dynamics, scene.run, scene.output), path
            for one, other in zip(again.pairs, scene.pairs, strict=True):
                assert (one.parameters, one.cutoff, one.drag) == (other.parameters, other.cutoff, other.drag), path
            source = target
        compared += 1
    assert compared >= 30


@pytest.mark.parametrize("target", ["", "nowhere/CONTROL"])
def test_convert_that_cannot_write(cli, tmp_path: Path, target: str) -> None:
    refused = cli("convert", run_folder(tmp_path / "run") / "CONTROL", "--output", tmp_path / "run" / target)
    assert refused.code == 1
    assert refused.err.startswith("pydlpoly: ")
    assert refused.err.count("\n") == 1


def test_resume_without_a_checkpoint(cli, tmp_path: Path) -> None:
    before = listing(run_folder(tmp_path))
    refused = cli("run", tmp_path, "--resume")
    assert refused.code == 1
    assert "REVIVE: there is no checkpoint to resume from" in refused.err
    assert listing(tmp_path) == before


def test_resume_of_a_finished_run_and_more_steps(cli, tmp_path: Path) -> None:
    run_folder(tmp_path / "run")
    assert cli("run", tmp_path / "run", "--quiet").code == 0
    before = listing(tmp_path / "run")
    refused = cli("run", tmp_path / "run", "--resume")
    assert refused.code == 1
    assert "is at step 40 already" in refused.err
    assert listing(tmp_path / "run") == before
    assert cli("run", tmp_path / "run", "--resume", "--steps", "70", "--quiet", "--threads", "2").code == 0
    run_folder(tmp_path / "whole")
    assert cli("run", tmp_path / "whole", "--steps", "70", "--quiet").code == 0
    for name in RESULTS:
        assert (tmp_path / "run" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name


@pytest.mark.parametrize("name", ["REVOLD", "REVIVE"])
def test_restart_continue_in_control(cli, tmp_path: Path, name: str) -> None:
    run_folder(tmp_path)
    cli("run", tmp_path, "--quiet")
    (tmp_path / "REVIVE").rename(tmp_path / name)
    run_folder(tmp_path, {"restart": "continue", "time_run": "60 steps"})
    done = cli("run", tmp_path)
    assert done.code == 0, done.err
    assert done.out.startswith("step 60: ")
    assert read_statistics(tmp_path / "STATIS").step.tolist() == [0, 10, 20, 30, 40, 50, 60]


def test_restart_continue_without_a_checkpoint(cli, tmp_path: Path) -> None:
    before = listing(run_folder(tmp_path, {"restart": "continue"}))
    refused = cli("run", tmp_path)
    assert refused.code == 1
    assert "REVOLD: CONTROL asks to continue, but there is no such checkpoint" in refused.err
    assert listing(tmp_path) == before


def start(folder: Path, *words: str) -> subprocess.Popen[str]:
    """Start a long run and return once it has written some records."""
    process = subprocess.Popen(
        [*COMMAND, "run", str(folder), "--threads", "1", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    end = time.monotonic() + 60.0
    statis = folder / "STATIS"
    while not (statis.exists() and statis.stat().st_size > 6000 and (folder / "REVIVE").exists()):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.02)
    return process


def uninterrupted(folder: Path, steps: int) -> Path:
    subprocess.run([*COMMAND, "run", str(run_folder(folder, LONG)), "--quiet", "--steps", str(steps)], check=True)
    return folder


def compare(folder: Path, whole: Path) -> None:
    for name in (*RESULTS, "DIAGNOSTICS"):
        assert (folder / name).read_bytes() == (whole / name).read_bytes(), name


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_a_run_that_continues_with_the_same_bits(tmp_path: Path, number: signal.Signals) -> None:
    folder = run_folder(tmp_path / "with blank", LONG)
    process = start(folder)
    process.send_signal(number)
    process.send_signal(number)  # wrappers forward a signal twice; that must not cut the writing short
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    told = re.fullmatch(
        r"pydlpoly: interrupted at step (\d+), everything is written; continue with: pydlpoly (.*)\n", err
    )
    assert told, err
    step = int(told[1])
    assert read_config(folder / "REVCON").step == step
    output = (folder / "OUTPUT").read_text()
    assert f"run terminated after {step} steps" in output
    assert f"the run was interrupted at step {step} of 200000" in output
    steps = step + 1500
    words = shlex.split(told[2])
    assert words[1] == str(folder)
    subprocess.run([*COMMAND, *words, "--steps", str(steps), "--quiet"], check=True)
    compare(folder, uninterrupted(tmp_path / "whole", steps))


def test_kill_leaves_whole_records_and_a_whole_checkpoint(tmp_path: Path) -> None:
    folder = run_folder(tmp_path / "killed", LONG)
    process = start(folder)
    time.sleep(0.3)
    process.kill()
    process.communicate(timeout=30)
    with (folder / "STATIS").open("a") as statis:
        statis.write("    999999  1.0")  # a record that the kill cut
    with (folder / "HISTORY").open("ab") as history:
        history.write(b"timestep    999999")
    with (folder / "DIAGNOSTICS").open("a") as diagnostics:
        diagnostics.write("     999999  1.0")
    saved = pydlpoly.Simulation.resume(folder / "REVIVE", threads=1).step
    assert saved % 1000 == 0
    assert read_config(folder / "REVCON").step in (saved, saved + 1000)
    steps = saved + 2500
    subprocess.run([*COMMAND, "run", str(folder), "--resume", "--steps", str(steps), "--quiet"], check=True)
    compare(folder, uninterrupted(tmp_path / "whole", steps))
    assert read_history_header(folder / "HISTORY").frames == len(list(read_history(folder / "HISTORY")))
    assert read_statistics(folder / "STATIS").step.tolist() == list(range(0, steps + 1, 100))


def test_interrupted_without_a_checkpoint_says_so(tmp_path: Path) -> None:
    folder = run_folder(tmp_path, {**LONG, "io_file_revive": "NONE"})
    process = subprocess.Popen([*COMMAND, "run", str(folder)], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
    end = time.monotonic() + 60.0
    while not (folder / "REVCON").exists() and time.monotonic() < end:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert b"io_file_revive NONE" in err
    assert b"--resume" not in err


def test_command_to_continue_repeats_the_options(tmp_path: Path) -> None:
    folder = run_folder(tmp_path / "in", LONG)
    (folder / "CONTROL").rename(folder / "CONTROL.2")
    out = tmp_path / "out put"
    out.mkdir()
    process = start_in(folder, out)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=30)
    words = shlex.split(err.split("continue with: ")[1])
    assert words[:2] == ["pydlpoly", "run"]
    assert words[2:] == [
        *["--control", str(folder / "CONTROL.2"), "--steps", "150000", "--threads", "1", "--output", str(out)],
        "--resume",
    ]


def start_in(folder: Path, out: Path) -> subprocess.Popen[str]:
    words = ["--control", str(folder / "CONTROL.2"), "--output", str(out), "--steps", "150000", "--threads", "1"]
    process = subprocess.Popen([*COMMAND, "run", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + 60.0
    while not (out / "REVIVE").exists() and time.monotonic() < end:
        time.sleep(0.02)
    return process


def run_on_terminal(words: list[str], *, stdout_too: bool) -> str:
    """Run with standard error (and output) on a pseudo-terminal; return what the terminal showed."""
    leader, follower = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, *words],
        stdin=subprocess.DEVNULL,
        stdout=follower if stdout_too else subprocess.DEVNULL,
        stderr=follower,
        env={**os.environ, "COLUMNS": "140", "TERM": "xterm"},
    )
    os.close(follower)
    shown = b""
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        if select.select([leader], [], [], 0.1)[0]:
            try:
                piece = os.read(leader, 65536)
            except OSError:  # Linux says so when the other side is closed
                break
            if not piece:
                break
            shown += piece
    assert process.wait(timeout=30) == 0
    os.close(leader)
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown.decode())


def test_progress_bar_on_a_terminal(tmp_path: Path) -> None:
    run_folder(tmp_path, {**LONG, "time_run": "60000 steps"})
    shown = run_on_terminal(["run", str(tmp_path), "--threads", "1"], stdout_too=False)
    notes = re.findall(r"(\d+)/60000 \S* *(\d+:\d\d:\d\d|-:--:--) ([\d.]+) M bead-steps/s  T [\d.]+  P [\d.]+", shown)
    assert notes[-1][0] == "60000"
    assert len({note[0] for note in notes}) >= 2, "the bar moved between the start and the end"
    assert float(notes[-1][2]) > 0.0


def test_no_progress_bar_across_output_on_the_screen(tmp_path: Path) -> None:
    run_folder(tmp_path, {"io_file_output": "SCREEN", "time_run": "1000 steps"})
    shown = run_on_terminal(["run", str(tmp_path)], stdout_too=True)
    assert "bead-steps/s" not in shown
    assert "run terminated after 1000 steps" in shown


def test_no_progress_bar_in_a_file(cli, tmp_path: Path) -> None:
    assert cli("run", run_folder(tmp_path)).err == ""


def test_folder_that_may_not_be_looked_into(tmp_path: Path, cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def locked(path: Path) -> bool:
        raise PermissionError(13, "Permission denied", str(path))

    run_folder(tmp_path)
    monkeypatch.setattr(Path, "is_file", locked)
    refused = cli("run", tmp_path)
    monkeypatch.undo()
    assert refused.code == 1
    assert re.fullmatch(rf"pydlpoly: {tmp_path}(/CONTROL)?: .*Permission denied\n", refused.err)


def test_permission_denied(tmp_path: Path, cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """As root every file can be read, so the system's refusal is played."""
    run_folder(tmp_path)
    real = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK and real(path, mode))
    before = listing(tmp_path)
    refused = cli("run", tmp_path)
    assert refused.code == 1
    assert "cannot be written: no permission to write here" in refused.err
    assert listing(tmp_path) == before


def test_memory_that_is_not_there(tmp_path: Path, cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def exhausted(*_: object, **__: object) -> None:
        raise MemoryError("Unable to allocate 426. PiB")

    monkeypatch.setattr("pydlpoly.cli.load", exhausted)
    refused = cli("check", run_folder(tmp_path))
    assert (refused.code, refused.out) == (1, "")
    assert refused.err == "pydlpoly: there is not enough memory for this: Unable to allocate 426. PiB\n"


def test_converting_a_folder_means_its_control(tmp_path: Path, cli) -> None:
    run_folder(tmp_path)
    assert cli("convert", tmp_path, "--to", "old").out == cli("convert", tmp_path / "CONTROL", "--to", "old").out != ""


def test_converting_never_replaces_the_control_that_is_read(tmp_path: Path, cli) -> None:
    run_folder(tmp_path)
    before = listing(tmp_path)
    refused = cli("convert", tmp_path / "CONTROL", "--to", "old", "-o", tmp_path / "CONTROL")
    assert refused.code == 1
    assert "CONTROL: is the file to be read; say with --output what to write" in refused.err
    assert listing(tmp_path) == before


def test_the_trajectory_of_a_folder_is_its_history(tmp_path: Path, cli) -> None:
    cli("run", run_folder(tmp_path), "--steps", "10", "--quiet")
    assert cli("convert", tmp_path, "--to", "config", "-o", tmp_path / "last").code == 0
    assert len(read_config(tmp_path / "last").names) == 160


def test_a_file_where_a_folder_is_expected_is_called_a_file(tmp_path: Path, cli) -> None:
    refused = cli("check", run_folder(tmp_path) / "CONTROL")
    assert refused.code == 1
    assert refused.err.endswith("CONTROL: it is a file; expected a folder with CONTROL, FIELD and CONFIG\n")


@pytest.mark.parametrize(
    ("option", "told"),
    [("--output", "cannot be written: No such file or directory"), ("--inputs", "expected the one with CONTROL")],
)
def test_a_report_without_its_folders_is_refused(tmp_path: Path, cli, option: str, told: str) -> None:
    refused = cli("report", run_folder(tmp_path), option, tmp_path / "no" / "such.html")
    assert refused.code == 1
    assert told in refused.err
