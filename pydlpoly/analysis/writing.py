"""Results as a table on the terminal, as a file of numbers, and as a picture."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pydlpoly.analysis.report import Curve, Number
from pydlpoly.bench.plot import new_figure, save_figure
from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import atomic_file, replace_file
from pydlpoly.formats.binned_table import BinnedTable

_FILES = (".csv", ".npz")


def table_text(numbers: Sequence[Number]) -> str:
    """Return one line a number: name, value, standard error and unit."""
    rows = [(one.name, f"{one.value:.5g}", _error(one.error), one.unit) for one in numbers]
    size = [max((len(row[k]) for row in rows), default=0) for k in range(3)]
    padded = (f"{name:<{size[0]}}  {value:>{size[1]}}  {error:<{size[2]}}  {unit}" for name, value, error, unit in rows)
    return "\n".join(line.rstrip() for line in padded)


def _error(error: float) -> str:
    return f"+- {error:.2g}" if np.isfinite(error) else ""


def check_output(path: Path) -> None:
    """Raise InputError when results cannot be written under this name."""
    if path.suffix not in _FILES:
        raise InputError(f"expected a name that ends with {' or '.join(_FILES)}", path=str(path))


def write_results(path: Path, numbers: Sequence[Number], curves: Sequence[Curve]) -> None:
    """Write results in one instant.

    A .csv file has the columns quantity, name, x, y, error: numbers have no x, and errors that are not known are empty.
    A .npz file has, for each curve, arrays ``<quantity>.<name>.x``, ``.y`` and ``.error``, and the numbers' ``names``,
    ``values`` and ``errors``.

    Raises:
        InputError: the name ends with something else.
        RunError: the file cannot be written.
    """
    check_output(path)
    if path.suffix == ".csv":
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(["quantity", "name", "x", "y", "error"])
        rows.writerows(["number", one.name, "", repr(one.value), _cell(one.error)] for one in numbers)
        for curve in curves:
            points = zip(curve.x.tolist(), curve.y.tolist(), curve.error.tolist(), strict=True)
            rows.writerows([curve.group, curve.name, repr(x), repr(y), _cell(error)] for x, y, error in points)
        replace_file(path, text.getvalue())
        return
    arrays = {
        "numbers.names": np.array([one.name for one in numbers]),
        "numbers.values": np.array([one.value for one in numbers]),
        "numbers.errors": np.array([one.error for one in numbers]),
    }
    for curve in curves:
        stem = f"{_word(curve.group)}.{_word(curve.name)}"
        arrays |= {f"{stem}.x": curve.x, f"{stem}.y": curve.y, f"{stem}.error": curve.error}
    with atomic_file(path) as file:
        np.savez(file, **arrays)  # type: ignore[arg-type] # the names are ours, none is allow_pickle


def write_map(path: Path, table: BinnedTable) -> None:
    """Write averages over two axes in one instant: .npz, with the middles of the bins by axis and arrays by quantity.

    Raises:
        InputError: the name ends with something else.
        RunError: the file cannot be written.
    """
    if path.suffix != ".npz":
        raise InputError("a map has no columns; expected a name that ends with .npz", path=str(path))
    arrays = {**dict(zip(table.axes, table.centres, strict=True)), **table.values}
    with atomic_file(path) as file:
        np.savez(file, **arrays)  # type: ignore[arg-type] # the names are ours, none is allow_pickle


def _word(text: str) -> str:
    return re.sub(r"[^\w-]+", "_", text)


def _cell(error: float) -> str:
    return repr(error) if np.isfinite(error) else ""


def draw(path: Path, curves: Sequence[Curve]) -> None:
    """Draw the curves, one panel a quantity; bands are two standard errors wide. The name's ending says the format.

    Raises:
        InputError: there is nothing to draw, matplotlib is missing, it does not know the format, or the file cannot be
            written.
    """
    groups = list(dict.fromkeys(curve.group for curve in curves))
    if not groups:
        raise InputError("there is no curve to draw, only numbers", path=str(path))
    figure = new_figure(path, 7.0, 4.0 * len(groups))
    for place, group in enumerate(groups, 1):
        axes = figure.add_subplot(len(groups), 1, place)
        for curve in curves:
            if curve.group == group:
                (line,) = axes.plot(curve.x, curve.y, label=curve.name, linewidth=1.2)
                known = np.isfinite(curve.error)
                low, high = (curve.y + sign * np.where(known, curve.error, 0.0) for sign in (-1.0, 1.0))
                axes.fill_between(curve.x, low, high, color=line.get_color(), alpha=0.3, linewidth=0.0)
                axes.set_xlabel(curve.x_label)
                axes.set_ylabel(curve.y_label)
        axes.legend(frameon=False)
    save_figure(figure, path)
