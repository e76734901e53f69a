"""``pydlpoly report`` and ``pydlpoly plot``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pydlpoly.bench.plot import save_figure
from pydlpoly.drawing import look
from pydlpoly.errors import InputError, RunError, suggest
from pydlpoly.report.against_time import one_quantity
from pydlpoly.report.collect import collect_run
from pydlpoly.report.figures import FIGURES, draw, figures_of
from pydlpoly.report.page import write_report
from pydlpoly.report.series import all_series
from pydlpoly.report.style import check_packages

_DOTS_PER_INCH = 200
_ENDINGS = (".png", ".svg", ".pdf")

Folder = Annotated[Path, typer.Argument(help="Folder with the output files of a run.", show_default=False)]
Inputs = Annotated[Path | None, typer.Option(help="Folder with CONTROL, FIELD and CONFIG when they are elsewhere.")]


def report_command(
    folder: Folder,
    *,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="HTML file to write (default: report.html in the folder).")
    ] = None,
    inputs: Inputs = None,
) -> None:
    """Write one HTML file with figures, pictures and warnings from the output files of a run, also a partial one."""
    try:
        path, findings = write_report(folder, output, inputs=inputs)
    except RunError as error:  # no simulation has stopped: the page cannot be written
        raise InputError(str(error)) from error
    for finding in findings:
        if finding.level == "warning":
            advice = f"; {finding.advice}" if finding.advice else ""
            typer.echo(f"warning: {finding.text}{advice}")
    typer.echo(f"{path}: {path.stat().st_size / 1e6:.2g} MB")


def plot_command(
    folder: Folder,
    quantity: Annotated[
        str | None, typer.Argument(help="What to draw; without it, what there is is listed.", show_default=False)
    ] = None,
    *,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Picture: .png, .svg or .pdf (default: QUANTITY.png)."),
    ] = None,
    inputs: Inputs = None,
) -> None:
    """Draw one quantity of a run: a figure of the report, or any column of STATIS or DIAGNOSTICS against time."""
    check_packages()
    run = collect_run(folder, inputs)
    if quantity is None:
        names = [name for name in figures_of(run) if draw(run, name) is not None]
        typer.echo("figures: " + ", ".join(names or ["none"]))
        typer.echo("columns: " + ", ".join(list(all_series(run)) or ["none"]))
        return
    path = output if output is not None else Path(f"{quantity}.png")
    if path.suffix not in _ENDINGS:
        raise InputError(f"expected a name that ends with {', '.join(_ENDINGS)}", path=str(path))
    drawing = draw(run, quantity) if quantity in figures_of(run) else None
    if drawing is None:  # a volume that does not vary, for one, is no figure of the report
        with look():
            drawing = one_quantity(run, quantity)
    if drawing is None:
        if quantity in FIGURES:
            raise InputError("the files of this folder do not hold it", path=str(folder), word=quantity)
        near = suggest(quantity, [*figures_of(run), *all_series(run)])
        raise InputError(f"is nothing that can be drawn here{near}", path=str(folder), word=quantity)
    drawing.figure.set_dpi(_DOTS_PER_INCH)
    with look():
        save_figure(drawing.figure, path)
    typer.echo(drawing.caption)
