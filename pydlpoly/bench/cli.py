"""``pydlpoly bench``: options, progress and output of the benchmarks."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, get_args

import typer

from pydlpoly.errors import suggest
from pydlpoly.scene.model import MOST_THREADS, Precision

_SIMDS = ("plain", "avx2", "avx512")
_EXIT_FAILED = 3

Names = Annotated[list[str] | None, typer.Argument(help="Scenes, by name or pattern (default: all but the large).")]


def bench(
    names: Names = None,
    *,
    list_scenes: Annotated[bool, typer.Option("--list", help="Print the scenes and stop.")] = False,
    large: Annotated[bool, typer.Option("--large", help="Also the scene of ten million beads.")] = False,
    steps: Annotated[int | None, typer.Option(min=1, help="Steps of a repetition in place of --seconds.")] = None,
    seconds: Annotated[float, typer.Option(min=0.001, help="Length of a repetition.")] = 0.5,
    repetitions: Annotated[int, typer.Option(min=1, help="How often each contender runs, in turns.")] = 9,
    threads: Annotated[str, typer.Option(help="Numbers of threads, with commas.")] = "1",
    precision: Annotated[str, typer.Option(help="double, mixed, reference: one or several, with commas.")] = "double",
    simd: Annotated[str, typer.Option(help="plain, avx2, avx512: one or several (default: the best).")] = "",
    versus: Annotated[str | None, typer.Option(help="lammps: compare with LAMMPS on one core.")] = None,
    versus_python: Annotated[
        str | None, typer.Option(help="Compare with the pydlpoly of this Python interpreter.", metavar="PYTHON")
    ] = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the results as JSON.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the rates (.png, .svg, .pdf); needs matplotlib.")] = None,
) -> None:
    """Time named scenes, and compare settings, builds and LAMMPS by runs that take turns."""
    from pydlpoly.bench.measure import Options, measure
    from pydlpoly.bench.processes import lammps_environment
    from pydlpoly.bench.scenes import chosen
    from pydlpoly.formats.atomic import replace_file

    scenes = chosen(names or [], large=large or list_scenes)
    if list_scenes:
        for scene in scenes:
            typer.echo(f"{scene.name:12} {scene.beads:9} beads  {scene.about}{' (large)' if scene.large else ''}")
        return
    if versus not in (None, "lammps"):
        raise typer.BadParameter(f"'{versus}' is nothing to compare with; expected lammps", param_hint="--versus")
    options = Options(
        threads=tuple(_counts(threads)),
        precisions=tuple(_words(precision, get_args(Precision), "--precision")),
        simds=tuple(_words(simd, _SIMDS, "--simd")) or (None,),
        steps=steps,
        seconds=seconds,
        repetitions=repetitions,
        lammps=versus == "lammps",
        python=versus_python,
    )
    if options.lammps:
        lammps_environment()  # refused before hours have gone by
    with _shown_progress(len(scenes)) as (progress, echo):
        report = measure(scenes, options, done=lambda result: echo(result.text()), progress=progress)
    typer.echo(f"measured on {report.machine.text()}; another machine or hour gives other rates")
    if json_file is not None:
        replace_file(json_file, json.dumps(report.as_json(), indent=1) + "\n")
    if plot is not None:
        from pydlpoly.bench.plot import write_plot

        write_plot(report, plot)
    if any(scene.failed for scene in report.scenes):
        raise typer.Exit(_EXIT_FAILED)


def _counts(text: str) -> list[int]:
    words = [word.strip() for word in text.split(",")]
    if not all(word.isdigit() and 1 <= int(word) <= MOST_THREADS for word in words):
        message = f"'{text}': expected numbers from 1 to {MOST_THREADS} with commas"
        raise typer.BadParameter(message, param_hint="--threads")
    return list(dict.fromkeys(int(word) for word in words))


def _words(text: str, valid: tuple[str, ...], option: str) -> list[str]:
    words = [word.strip() for word in text.split(",") if word.strip()]
    for word in words:
        if word not in valid:
            message = f"'{word}': expected {', '.join(valid)}{suggest(word, valid)}"
            raise typer.BadParameter(message, param_hint=option)
    return list(dict.fromkeys(words))


@contextmanager
def _shown_progress(scenes: int) -> Iterator[tuple[Callable[[str, int, int], None], Callable[[str], None]]]:
    """Give a function to call with the progress and one to print with; a bar only when a terminal listens."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda *_: None, typer.echo
        return
    columns = (TextColumn("{task.description}"), BarColumn(bar_width=20), MofNCompleteColumn())
    with Progress(*columns, console=console, transient=True, redirect_stdout=sys.stdout.isatty()) as bar:
        total = bar.add_task("scenes", total=scenes)
        one = bar.add_task("", total=1)
        names: list[str] = []

        def show(name: str, done: int, of: int) -> None:
            if name not in names:
                names.append(name)
            bar.update(total, completed=len(names) - 1)
            bar.update(one, description=name, completed=done, total=of)

        yield show, typer.echo
