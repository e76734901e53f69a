"""``pydlpoly tradeoff``: its options, progress, files and exit code."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import replace_file
from pydlpoly.formats.records import Control
from pydlpoly.scene.model import Scene
from pydlpoly.tradeoff.measure import Progress, tradeoff
from pydlpoly.tradeoff.plot import check_plot, write_plot
from pydlpoly.tradeoff.report import TradeoffReport

EXIT_TOO_SHORT, EXIT_NOTHING, EXIT_INTERRUPTED = 4, 5, 130

_SECONDS = {"": 1.0, "s": 1.0, "sec": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0}


def seconds_of(text: str) -> float:
    """Return the seconds of ``90s``, ``2min``, ``5m``, ``1h`` or a number. Raises BadParameter for anything else."""
    found = re.fullmatch(r"(\d+(?:\.\d*)?|\.\d+)\s*([a-z]*)", text.strip().lower())
    if found is None or found[2] not in _SECONDS or float(found[1]) == 0.0:
        raise typer.BadParameter(f"'{text}' is no time; expected 90s, 2min, 1h, ...", param_hint="--budget")
    return float(found[1]) * _SECONDS[found[2]]


def fraction_of(text: str) -> float:
    """Return the fraction of ``1%`` or ``0.01``. Raises BadParameter for anything not between 0 and 1."""
    bare = text.strip().removesuffix("%")
    try:
        value = float(bare) * (0.01 if text.strip().endswith("%") else 1.0)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1.0:
        raise typer.BadParameter(f"'{text}': expected a fraction such as 0.01 or 1%", param_hint="--target")
    return value


def words_of(text: str | None) -> list[str] | None:
    """Return words with commas between them, None for none."""
    return None if text is None else [word.strip() for word in text.split(",") if word.strip()]


def timesteps_of(text: str | None) -> list[float] | None:
    """Return numbers above 0 with commas between them, None for none. Raises BadParameter for anything else."""
    try:
        numbers = None if text is None else [float(word) for word in words_of(text) or []]
    except ValueError:
        numbers = []
    if numbers is not None and (not numbers or not all(0.0 < number < float("inf") for number in numbers)):
        raise typer.BadParameter(f"'{text}': expected numbers above 0 with commas", param_hint="--timesteps")
    return numbers


def measure_and_tell(
    scene: Scene,
    control: Control,
    *,
    budget: str,
    target: str,
    integrators: str | None,
    timesteps: str | None,
    precisions: str | None,
    threads: int | None,
    seed: int | None,
    diffusion: bool,
    everything: bool,
    json_file: Path | None,
    plot: Path | None,
) -> int:
    """Measure, print, write the files, and return the exit code."""
    for path in (json_file, plot):
        _check_place(path)
    if plot is not None:
        check_plot(plot)  # refused before the budget is spent
    if json_file is not None and plot is not None and os.path.realpath(json_file) == os.path.realpath(plot):
        raise typer.BadParameter("the JSON file and the plot have the same name", param_hint="--plot")
    try:
        with _shown_progress() as progress:
            report = tradeoff(
                scene,
                budget=seconds_of(budget),
                target=fraction_of(target),
                integrators=words_of(integrators),
                timesteps=timesteps_of(timesteps),
                precisions=words_of(precisions),
                threads=threads,
                diffusion=diffusion,
                seed=seed,
                progress=progress,
            )
    except KeyboardInterrupt:
        typer.echo("pydlpoly: interrupted before anything was measured", err=True)
        return EXIT_INTERRUPTED
    typer.echo(report.text(control, everything=everything))
    if json_file is not None:
        _keep(json_file)
        replace_file(json_file, json.dumps(_finite(report.as_json()), indent=1) + "\n")
    if plot is not None:
        _keep(plot)
        write_plot(report, plot)
    return _exit_code(report)


def _exit_code(report: TradeoffReport) -> int:
    if report.interrupted:
        return EXIT_INTERRUPTED
    if report.recommended is not None:
        return 0
    return EXIT_TOO_SHORT if report.too_short else EXIT_NOTHING


def _check_place(path: Path | None) -> None:
    if path is None:
        return
    if path.is_dir():
        raise InputError("is a folder; expected a file that can be written", path=str(path))
    if not os.access(path.parent, os.W_OK):
        found = "no permission to write here" if path.parent.is_dir() else "there is no such folder"
        raise InputError(f"cannot be written: {found}", path=str(path))


def _keep(path: Path) -> None:
    """Move an earlier file aside, as runs do."""
    if path.is_file():
        kept = path.with_name(path.name + ".bak")
        path.replace(kept)
        typer.echo(f"{path}: the earlier file is now {kept}", err=True)


def _finite(value: object) -> object:
    """Numbers that JSON does not have become null."""
    if isinstance(value, dict):
        return {key: _finite(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(part) for part in value]
    return None if isinstance(value, float) and value - value != 0.0 else value


@contextmanager
def _shown_progress() -> Iterator[Progress | None]:
    """Give a function to call with the progress; None when no terminal listens."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    columns = (TextColumn("{task.description}"), BarColumn(bar_width=20), TimeElapsedColumn(), TextColumn("of"))
    with Progress(*columns, TextColumn("{task.fields[budget]}"), console=console, transient=True) as bar:
        task = bar.add_task("", total=1.0, budget="")

        def show(what: str, done: float, of: float) -> None:
            bar.update(task, description=what, completed=done, total=of, budget=f"{of:.0f} s")

        yield show
