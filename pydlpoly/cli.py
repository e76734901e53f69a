"""The command line: ``pydlpoly run | check | explain | convert | build | bench | tradeoff | analyse | report | plot |
plan | examples``.

Exit codes: 0 done, 1 the input was refused, 2 wrong usage, 3 the run stopped being physical, 130 interrupted by Ctrl-C
or SIGTERM (after writing the checkpoint). ``tradeoff`` has two more: 4 its budget was too short to recommend anything,
5 nothing is as accurate as asked for.
"""

from __future__ import annotations

import io
import shlex
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, NoReturn, cast, get_args

import typer

from pydlpoly import __version__
from pydlpoly.analysis.cli import analyse_command
from pydlpoly.bench.cli import bench
from pydlpoly.build.cli import build
from pydlpoly.conversion import convert_folder, convert_to_lammps
from pydlpoly.engines.cli import choose_engine
from pydlpoly.engines.native import NativeEngine
from pydlpoly.errors import InputError, PydlpolyError, RunError
from pydlpoly.formats.atomic import replace_file
from pydlpoly.formats.control import read_control, write_control
from pydlpoly.gallery import example_folder as example_folder
from pydlpoly.gallery import example_names as example_names
from pydlpoly.gallery import examples
from pydlpoly.planning.cli import plan
from pydlpoly.report.cli import plot_command, report_command
from pydlpoly.runner import RunResult, run_scene
from pydlpoly.scene import Scene, load
from pydlpoly.scene.model import MOST_THREADS, Precision
from pydlpoly.trajectories.convert import TARGETS, convert_trajectory

EXIT_REFUSED, EXIT_USAGE, EXIT_STOPPED, EXIT_INTERRUPTED = 1, 2, 3, 130

app = typer.Typer(
    add_completion=False, no_args_is_help=True, help="Dissipative particle dynamics from DL_POLY-format files."
)

Directory = Annotated[Path | None, typer.Argument(help="Folder with CONTROL, FIELD and CONFIG.", show_default=False)]
Example = Annotated[str | None, typer.Option(help="Use a shipped example instead of a folder.")]
ControlFile = Annotated[Path | None, typer.Option("--control", help="CONTROL file in place of DIRECTORY's.")]
FieldFile = Annotated[Path | None, typer.Option("--field", help="FIELD file in place of DIRECTORY's.")]
ConfigFile = Annotated[Path | None, typer.Option("--config", help="CONFIG file in place of DIRECTORY's.")]
Lenient = Annotated[bool, typer.Option("--lenient", help="Unknown or misspelt words are warnings, not errors.")]


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"pydlpoly {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Dissipative particle dynamics from DL_POLY-format files."""


@app.command()
def run(
    directory: Directory = None,
    *,
    example: Example = None,
    control: ControlFile = None,
    field: FieldFile = None,
    config: ConfigFile = None,
    steps: Annotated[int | None, typer.Option(min=0, help="Total number of steps in place of CONTROL's.")] = None,
    threads: Annotated[
        int | None, typer.Option(min=1, max=MOST_THREADS, help="Threads; results do not depend on it.")
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, max=2**64 - 1, help="Seed of noise and start velocities.")] = None,
    precision: Annotated[
        str | None, typer.Option(help="double, mixed or reference in place of CONTROL's precision.")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(help="Folder for the output files (default: DIRECTORY; for examples the current one)."),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue from the checkpoint in the output folder.")
    ] = False,
    engine: Annotated[str, typer.Option(help="native or lammps (docs/lammps.md).")] = "native",
    ranks: Annotated[
        int | None, typer.Option(min=1, help="Processes of the engine lammps; inside an MPI job its ranks are used.")
    ] = None,
    gpu: Annotated[str, typer.Option(help="LAMMPS's own accelerator switches, for example '-sf gpu -pk gpu 1'.")] = "",
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress bar and no closing words.")] = False,
    lenient: Lenient = False,
) -> None:
    """Run a simulation and write OUTPUT, STATIS, HISTORY, averages, REVCON and the checkpoint, as CONTROL asks."""
    if resume and seed is not None:
        raise typer.BadParameter("a run that continues keeps the seed of its checkpoint", param_hint="--seed")
    choose_engine(engine, ranks, gpu)
    try:
        scene, folder = _scene(directory, example, control, field, config, lenient=lenient)
        scene = _with_precision(scene, precision)
        target = output if output is not None else folder if example is None else Path()
        checkpoint = _checkpoint(scene, folder, target, resume=resume)
        result = run_scene(
            scene,
            target,
            steps=steps,
            threads=threads,
            seed=seed,
            checkpoint=checkpoint,
            progress=not quiet,
            engine=engine,
            ranks=ranks,
            accelerator=gpu,
        )
    except KeyboardInterrupt:  # before the first step, or for the second time
        typer.echo("pydlpoly: interrupted at once; files keep what was written before", err=True)
        raise typer.Exit(EXIT_INTERRUPTED) from None
    if not quiet:
        _closing_words(result)
    if result.interrupted:
        files = {"--control": control, "--field": field, "--config": config}
        options = {**files, "--steps": steps, "--threads": threads, "--precision": precision}
        if engine != "native":
            options |= {"--engine": engine, "--ranks": ranks, "--gpu": gpu or None}
        again = _command_line(directory, {"--example": example, **options, "--output": output}, lenient=lenient)
        _words_of_interrupted(result, again)
        raise typer.Exit(EXIT_INTERRUPTED)


@app.command()
def check(
    directory: Directory = None,
    *,
    example: Example = None,
    control: ControlFile = None,
    field: FieldFile = None,
    config: ConfigFile = None,
    lenient: Lenient = False,
) -> None:
    """Read and resolve the input, say what is odd about it, and stop there."""
    scene, _ = _scene(directory, example, control, field, config, lenient=lenient)
    for note in scene.notes:
        place = f"{note.where}: " if note.where else ""
        typer.echo(f"{note.kind}: {place}{note.text}")
    NativeEngine(scene, seed=0, threads=1)  # the core judges the laws' parameters once more
    unit = "" if scene.units.reduced else " ps"
    typer.echo(
        f"ok: {scene.bead_count} beads of {len(scene.species)} species, {scene.run.steps} steps of "
        f"{scene.dynamics.timestep:g}{unit}"
    )


@app.command()
def explain(
    directory: Directory = None,
    *,
    example: Example = None,
    control: ControlFile = None,
    field: FieldFile = None,
    config: ConfigFile = None,
    lenient: Lenient = False,
) -> None:
    """Print what will be modelled, what will not, and where every number comes from."""
    scene, _ = _scene(directory, example, control, field, config, lenient=lenient)
    typer.echo(scene.explain())


@app.command()
def convert(
    source: Annotated[
        Path,
        typer.Argument(help="A folder; or its CONTROL, with new and old; or a trajectory."),
    ],
    *,
    to: Annotated[
        str,
        typer.Option(
            help="new | old: the style of CONTROL to write; dl_poly: CONTROL, FIELD and CONFIG; lammps: a script; "
            "history | extxyz | gsd | h5md | dcd: a trajectory; config: one of its frames."
        ),
    ] = "new",
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="File or folder to write; default: standard output, of trajectories beside SOURCE.",
        ),
    ] = None,
    frame: Annotated[
        int | None, typer.Option(help="Number of a trajectory's frame, from 0 on; -1 is the last, CONFIG's default.")
    ] = None,
    lenient: Lenient = False,
) -> None:
    """Rewrite CONTROL in the other style, a folder in DL_MESO's dialect or for LAMMPS, or a trajectory."""
    if to in TARGETS:
        source = source / "HISTORY" if source.is_dir() else source
        typer.echo(f"written: {convert_trajectory(source, to, output, frame=frame)}")
        return
    if frame is not None:
        raise typer.BadParameter("belongs to trajectories", param_hint="--frame")
    if to in ("dl_poly", "lammps"):
        _convert_folder(source, output, to, lenient=lenient)
        return
    if to not in ("new", "old"):
        expected = ", ".join(("new", "old", "dl_poly", "lammps", *TARGETS))
        raise typer.BadParameter(f"'{to}' is nothing to write; expected one of {expected}", param_hint="--to")
    source = source / "CONTROL" if source.is_dir() else source
    record = read_control(source, lenient=lenient)
    if record.meso is not None:
        message = (
            "this CONTROL is in DL_MESO's dialect, and FIELD and box belong to it; convert its folder --to dl_poly"
        )
        raise InputError(message, path=str(source))
    for warning in record.warnings:
        typer.echo(f"warning: {warning}", err=True)
    text = write_control(replace(record, style="new" if to == "new" else "old"))
    if output is None:
        typer.echo(text, nl=False)
    elif output.resolve() == source.resolve():
        raise InputError("is the file to be read; say with --output what to write", path=str(output))
    else:
        try:
            replace_file(output, text)
        except RunError as error:
            raise InputError(str(error)) from error


def _convert_folder(source: Path, output: Path | None, to: str, *, lenient: bool) -> None:
    if output is None:
        raise typer.BadParameter(f"--to {to} writes several files; name a folder for them", param_hint="--output")
    if not source.is_dir():
        raise InputError(f"--to {to} takes the folder of a run", path=str(source))
    write = convert_folder if to == "dl_poly" else convert_to_lammps
    for warning in write(source, output, lenient=lenient):
        typer.echo(f"warning: {warning}", err=True)


@app.command()
def tradeoff(
    directory: Directory = None,
    *,
    example: Example = None,
    control: ControlFile = None,
    field: FieldFile = None,
    config: ConfigFile = None,
    budget: Annotated[str, typer.Option(help="Wall time to spend: 90s, 2min, 1h.")] = "2min",
    target: Annotated[str, typer.Option(help="Largest error that is aimed at: 1% or 0.01.")] = "1%",
    integrators: Annotated[
        str | None, typer.Option(help="Names of ensemble_dpd_order, with commas (default: those in common use).")
    ] = None,
    timesteps: Annotated[
        str | None, typer.Option(help="Timesteps with commas, ps or reduced (default: 1/2 to 6 times CONTROL's).")
    ] = None,
    precision: Annotated[
        str | None, typer.Option(help="double, mixed, reference: one or several, with commas (default: double,mixed).")
    ] = None,
    diffusion: Annotated[bool, typer.Option("--diffusion", help="Also compare diffusion coefficients.")] = False,
    threads: Annotated[int | None, typer.Option(min=1, max=MOST_THREADS, help="Threads of every run.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, max=2**64 - 1, help="Seed of all runs.")] = None,
    everything: Annotated[bool, typer.Option("--all", help="Print the candidates that were given up, too.")] = False,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the results as JSON.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw error against speed (.png, .svg, .pdf).")] = None,
    lenient: Lenient = False,
) -> None:
    """Measure speed against accuracy of integrators, timesteps and precisions on this scene."""
    from pydlpoly.tradeoff.cli import measure_and_tell

    scene, folder = _scene(directory, example, control, field, config, lenient=lenient)
    record = read_control(folder / "CONTROL" if control is None else control, lenient=lenient)
    code = measure_and_tell(
        scene,
        record,
        budget=budget,
        target=target,
        integrators=integrators,
        timesteps=timesteps,
        precisions=precision,
        threads=threads,
        seed=seed,
        diffusion=diffusion,
        everything=everything,
        json_file=json_file,
        plot=plot,
    )
    raise typer.Exit(code)


app.command()(build)
app.command()(plan)
app.command()(bench)
app.command("analyse")(analyse_command)
app.command("report")(report_command)
app.command("plot")(plot_command)
app.command()(examples)


def _scene(
    directory: Path | None,
    example: str | None,
    control: Path | None,
    field: Path | None,
    config: Path | None,
    *,
    lenient: bool,
) -> tuple[Scene, Path]:
    if example is not None and directory is not None:
        raise typer.BadParameter("give either a DIRECTORY or --example, not both")
    if example is not None:
        folder = example_folder(example)
    elif directory is not None:
        folder = directory
        if folder.is_file():
            raise InputError("it is a file; expected a folder with CONTROL, FIELD and CONFIG", path=str(folder))
    elif control is not None:
        folder = control.parent
    else:
        raise typer.BadParameter("give a DIRECTORY with CONTROL, FIELD and CONFIG, or --example NAME")
    resolved = [None if path is None else path.resolve() for path in (control, field, config)]
    return load(folder, control=resolved[0], field=resolved[1], config=resolved[2], lenient=lenient), folder


def _with_precision(scene: Scene, precision: str | None) -> Scene:
    if precision is None:
        return scene
    if precision not in get_args(Precision):
        expected = ", ".join(get_args(Precision))
        raise typer.BadParameter(f"'{precision}' is no precision; expected {expected}", param_hint="--precision")
    return replace(scene, dynamics=replace(scene.dynamics, precision=cast(Precision, precision)))


def _checkpoint(scene: Scene, folder: Path, target: Path, *, resume: bool) -> Path | None:
    if resume:
        path = target / (scene.output.checkpoint_file or "REVIVE")
        if not path.is_file():
            raise InputError("there is no checkpoint to resume from", path=str(path))
        return path
    if scene.run.start == "continue":
        for path in (folder / scene.run.checkpoint_file, target / (scene.output.checkpoint_file or "REVIVE")):
            if path.is_file():
                return path
        raise InputError(
            "CONTROL asks to continue, but there is no such checkpoint", path=str(folder / scene.run.checkpoint_file)
        )
    return None


def _closing_words(result: RunResult) -> None:
    simulation = result.simulation
    seen = simulation.observe()
    units = simulation.scene.units
    summary = result.summary
    steps = summary.steps if summary.loop_steps is None else summary.loop_steps
    rate = simulation.scene.bead_count * steps / max(summary.loop_seconds, 1e-9) / 1e6
    temperature = f"{seen.temperature:.5g} {units.temperature_label}".rstrip()
    pressure = f"{seen.pressure:.5g} {units.pressure_label}".rstrip()
    typer.echo(
        f"step {simulation.step}: T = {temperature}, P = {pressure}, {rate:.2f} million bead-steps a second; "
        f"seed {simulation.seed}; files in {result.folder}"
    )
    for doubt in summary.doubts:
        typer.echo(f"warning: {doubt}", err=True)


def _words_of_interrupted(result: RunResult, again: str) -> None:
    if result.checkpoint is None:
        cure = "CONTROL switches the checkpoint off (io_file_revive NONE): it cannot be continued"
    else:
        cure = f"continue with: {again}"
    typer.echo(f"pydlpoly: interrupted at step {result.simulation.step}, everything is written; {cure}", err=True)


def _command_line(directory: Path | None, options: Mapping[str, object], *, lenient: bool) -> str:
    words = ["pydlpoly", "run", *([str(directory)] if directory is not None else [])]
    words += [text for name, value in options.items() if value is not None for text in (name, str(value))]
    return shlex.join([*words, *(["--lenient"] if lenient else []), "--resume"])


def main() -> NoReturn:
    """Entry point of the ``pydlpoly`` command."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a title with letters the terminal lacks must not end in a traceback
            stream.reconfigure(errors="backslashreplace")
    try:
        app(standalone_mode=True)
    except RunError as error:
        typer.echo(f"pydlpoly: stopped: {error}", err=True)
        sys.exit(EXIT_STOPPED)
    except PydlpolyError as error:
        typer.echo(f"pydlpoly: {error}", err=True)
        sys.exit(EXIT_REFUSED)
    except MemoryError as error:
        typer.echo(f"pydlpoly: there is not enough memory for this: {error}", err=True)
        sys.exit(EXIT_REFUSED)
    except OSError as error:  # the system refuses even to look, as in a folder without permission
        place = f"{error.filename}: " if error.filename is not None else ""
        typer.echo(f"pydlpoly: {place}{error.strerror or error}", err=True)
        sys.exit(EXIT_REFUSED)
    sys.exit(0)
