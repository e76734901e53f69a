"""Reading STATIS back as columns: the classic form of every DL_POLY version with its two header lines, and YAML."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pydlpoly.errors import InputError, suggest
from pydlpoly.formats.atomic import PathLike, read_text
from pydlpoly.formats.fortran import is_real, parse_reals
from pydlpoly.formats.records import FloatArray, IntArray
from pydlpoly.formats.statis_columns import STATISTICS_NAMES, VARIABLE_CELL_LABELS, VARIABLE_CELL_NAMES

_FIELD_WIDTH = 14  # of the classic form's numbers


@dataclass(frozen=True, eq=False)
class StatisticsTable:
    """A STATIS file as columns.

    Attributes:
        title, energy_label: the two header lines without their keywords and quotes.
        step: (n,) step numbers; time: (n,) in ps.
        columns: name of each column of ``values``: those of ``STATISTICS_NAMES``, then ``msd_<species>`` where the
            species are known (given by the caller or by a YAML file), else ``column_<number>``.
        values: (n, number of columns) in the units of the file.
        warnings: what was odd and how it was understood.
    """

    title: str
    energy_label: str
    step: IntArray
    time: FloatArray
    columns: tuple[str, ...]
    values: FloatArray
    path: str = "STATIS"
    warnings: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of records."""
        return len(self.step)

    def __getitem__(self, name: str) -> FloatArray:
        """Return one column by name, shape (n,).

        Raises:
            KeyError: there is no column of this name; the text suggests the nearest.
        """
        if name not in self.columns:
            raise KeyError(f"{self.path} has no column {name!r}{suggest(name, self.columns)}")
        return self.values[:, self.columns.index(name)]

    @property
    def stress(self) -> FloatArray:
        """The stress tensor of every record, shape (n, 3, 3), in katm."""
        first = self.columns.index("stress_xx")
        return self.values[:, first : first + 9].reshape(-1, 3, 3)


def read_statistics(path: PathLike, *, species: Sequence[str] | None = None, classic: bool = False) -> StatisticsTable:
    """Read a STATIS file in the classic or the YAML form.

    Any two header lines are accepted in plain files. Their columns are named as DL_POLY 4 and 5 order them; those after
    the stress only where that is no guess: from the labels of the YAML form, or from ``species``, whose number must
    then leave 0, 10, 12 or 14 columns of a variable cell. A last record that a kill cut short is left out, with a
    warning in the table.

    Args:
        path: the file.
        species: species names in FIELD's order.
        classic: the file is from DL_POLY Classic or 2, which have no conserved term and put the displacements before
            the stress; such files do not say so themselves. Without ``species`` only 27 columns are then named.

    Raises:
        InputError: the file is missing, not a STATIS file, or damaged in the middle.
    """
    name = os.fspath(path)
    text = read_text(path)
    if text.lstrip().startswith("%YAML"):
        return _read_yaml(text, name)
    return _read_plain(text, name, species, classic=classic)


def _read_plain(text: str, path: str, species: Sequence[str] | None, *, classic: bool) -> StatisticsTable:
    lines = text.split("\n")
    if len(lines) < 2:
        raise InputError("is not a STATIS file: expected two header lines", path=path)
    title, label = _after_colon(lines[0], "title"), _after_colon(lines[1], "energy")
    body = lines[2:]
    warnings: list[str] = []
    if body and body[-1].strip() and len(body[-1].rstrip("\r")) % _FIELD_WIDTH:
        body = body[:-1]  # no line feed and not a whole number of fields: the last number itself may be cut
        warnings.append("the last record is cut short and was left out")
    filled = [line.split() for line in body if line.strip()]
    words = [word for line in filled for word in line]
    if not filled or not words:
        columns = tuple(q.name for q in STATISTICS_NAMES)
        empty = np.zeros((0, len(columns)))
        return StatisticsTable(title, label, np.zeros(0, int), np.zeros(0), columns, empty, path, tuple(warnings))
    count = _values_in_record(filled[0], path)
    whole = len(words) // (count + 3)
    if len(words) % (count + 3) and not warnings:
        warnings.append("the last record is cut short and was left out")
    try:
        numbers = parse_reals(words[: whole * (count + 3)]).reshape(whole, count + 3)
    except ValueError:
        raise _first_bad_word(lines, path) from None
    if np.any(numbers[:, 2] != count):
        raise _first_bad_record(lines, count, path)
    columns = (_classic_names if classic else _column_names)(count, species, path)
    step = numbers[:, 0].astype(np.int64)
    return StatisticsTable(title, label, step, numbers[:, 1], columns, numbers[:, 3:], path, tuple(warnings))


def _after_colon(line: str, keyword: str) -> str:
    """A header line without DL_POLY 5's keyword and quotes; a plain line (older versions) as it is."""
    head, colon, rest = line.partition(":")
    text = (rest if colon and head.strip().lower().startswith(keyword) else line).strip()
    if len(text) >= 2 and text[0] == text[-1] == "'":
        return text[1:-1].replace("''", "'").strip()
    return text


def _values_in_record(head: list[str], path: str) -> int:
    if len(head) == 3 and head[0].isdigit() and head[2].isdigit() and int(head[2]) > 0:
        return int(head[2])
    message = "is not a STATIS file: expected step, time and number of values"
    raise InputError(message, path=path, line=3, word=" ".join(head[:3]))


def _first_bad_word(lines: list[str], path: str) -> InputError:
    for number, line in enumerate(lines[2:], 3):
        for word in line.split():
            if not is_real(word):
                return InputError("expected a number", path=path, line=number, word=word)
    return InputError("expected numbers", path=path)


def _first_bad_record(lines: list[str], count: int, path: str) -> InputError:
    """Name the record after which the steps of ``count`` values get out of step with the lines."""
    numbered = [(number, line.split()) for number, line in enumerate(lines[2:], 3) if line.strip()]
    seen = 0
    for number, words in numbered:
        head_is_wrong = seen == 0 and (len(words) != 3 or words[2] != str(count))
        if head_is_wrong or seen + len(words) > count + 3:
            message = f"expected a record's head with {count} values here: an earlier record is cut short or longer"
            return InputError(message, path=path, line=number, word=" ".join(words[:3]))
        seen = (seen + len(words)) % (count + 3)
    return InputError(f"the records do not all hold {count} values", path=path)


def _column_names(count: int, species: Sequence[str] | None, path: str) -> tuple[str, ...]:
    known = [q.name for q in STATISTICS_NAMES[:count]]
    if species is None:
        return (*known, *(f"column_{index}" for index in range(len(known) + 1, count + 1)))
    rest = count - len(STATISTICS_NAMES) - len(species)
    if rest not in VARIABLE_CELL_NAMES:
        message = f"its records hold {count} values; with {len(species)} species DL_POLY 5 writes "
        raise InputError(message + f"{len(STATISTICS_NAMES) + len(species)}, or 10, 12 or 14 more", path=path)
    return (*known, *(f"msd_{s}" for s in species), *VARIABLE_CELL_NAMES[rest])


def _classic_names(count: int, species: Sequence[str] | None, path: str) -> tuple[str, ...]:
    known = [q.name for q in STATISTICS_NAMES[:27]]
    if species is not None:
        known += [*(f"msd_{s}" for s in species), *(q.name for q in STATISTICS_NAMES[28:])]
    if count < len(known):
        message = f"its records hold {count} values; DL_POLY Classic writes at least {len(known)} here"
        raise InputError(message, path=path)
    return (*known, *(f"column_{index}" for index in range(len(known) + 1, count + 1)))


def _read_yaml(text: str, path: str) -> StatisticsTable:
    title = label = ""
    labels: list[str] = []
    rows: list[FloatArray] = []
    warnings: list[str] = []
    section = ""
    lines = text.split("\n")
    for number, line in enumerate(lines, 1):
        if match := re.match(r"([A-Za-z][A-Za-z ]*?)\s*:(.*)$", line):
            section = match[1].lower()
            if section == "title":
                title = _after_colon(line, "title")
            elif section.startswith("energy unit"):
                label = _after_colon(line, "energy")
        elif item := re.match(r"\s*-\s*\[(.*)\]\s*$", line):
            if section == "labels":
                labels = _flow_words(item[1])
            elif section == "timesteps":
                rows.append(_yaml_numbers(item[1], path, number))
        elif line.lstrip().startswith("- [") and not any(rest.strip() for rest in lines[number:]):
            warnings.append("the last record is cut short and was left out")
    width = len(rows[0]) if rows else len(labels)
    if any(len(row) != width for row in rows):
        raise InputError("the rows of 'timesteps' have different lengths", path=path)
    columns = _columns_of_labels(labels, width, path)
    table = np.array(rows).reshape(len(rows), width)
    step = table[:, 0].astype(np.int64)
    return StatisticsTable(title, label, step, table[:, 1], columns[2:], table[:, 2:], path, tuple(warnings))


def _flow_words(text: str) -> list[str]:
    """Split the inside of a YAML flow sequence at the commas outside quotes."""
    words = re.findall(r"""\s*('(?:[^']|'')*'|"[^"]*"|[^,]*)\s*(?:,|$)""", text)
    cleaned = [word.strip() for word in words]
    while cleaned and not cleaned[-1]:
        cleaned.pop()
    return [w[1:-1].replace("''", "'") if len(w) > 1 and w[0] in "'\"" and w[-1] == w[0] else w for w in cleaned]


def _yaml_numbers(text: str, path: str, line: int) -> FloatArray:
    words = [word.strip().replace(".nan", "nan").replace(".inf", "inf") for word in text.split(",") if word.strip()]
    try:
        return parse_reals(words)
    except ValueError:
        bad = next(word for word in words if not is_real(word))
        raise InputError("expected a number", path=path, line=line, word=bad) from None


def _columns_of_labels(labels: list[str], width: int, path: str) -> tuple[str, ...]:
    # DL_POLY leaves out the comma between two labels of its variable-cell columns.
    split = [part for word in labels for part in (("cell C3", "pV") if word == "cell C3pV" else (word,))]
    if len(split) != width or [word.lower() for word in split[:2]] != ["step", "time"]:
        raise InputError(f"{len(split)} labels for rows of {width} values, or no 'step' and 'time' first", path=path)
    known = {_plain(q.label): q.name for q in STATISTICS_NAMES}
    known |= {_plain(label): name for name, label in VARIABLE_CELL_LABELS.items()}
    return tuple(known.get(_plain(word), _extra_name(word)) for word in split)


def _plain(label: str) -> str:
    """A label without what versions of DL_POLY write differently: case, commas, Greek letters."""
    text = label.replace("Α", "Alpha").replace("Β", "Beta").replace("Γ", "Gamma")
    return text.replace(",", "").lower()


def _extra_name(label: str) -> str:
    if label.startswith("amsd "):
        return "msd_" + label[5:].strip()
    return label.strip()
