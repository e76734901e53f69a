"""Blocks after FIELD's ``close``, where DL_POLY and DL_MESO stop reading: what pydlpoly models beyond them.

A block is a line ``extension NAME``, lines of its own, and a line ``end extension``. Each kind of block has a reader of
its own; this module only finds the blocks. Other text after ``close`` is left alone, as the other programs do.
"""

from __future__ import annotations

from pydlpoly.errors import suggest
from pydlpoly.formats.field_lines import FieldLines
from pydlpoly.formats.lexing import Line
from pydlpoly.formats.records import Extension

EXTENSIONS: dict[str, str] = {
    "heat": "beads that carry heat: internal temperatures, conduction, viscous heating, sources (heat.md)",
    "transport": "dissolved species that beads carry: exchange between neighbours, sources, reactions",
}
"""Name of every kind of block, and what it describes."""


def read_extensions(lines: FieldLines) -> tuple[Extension, ...]:
    """Return the blocks in what is left of a FIELD file after ``close``.

    Raises:
        InputError: a block of an unknown name, given twice, or without its end.
    """
    found: dict[str, Extension] = {}
    while (line := lines.peek()) is not None:
        lines.next("")
        if line.words[0].lower() != "extension":
            continue
        name = line.words[1].lower() if len(line.words) > 1 else ""
        if name not in EXTENSIONS:
            known = f"known are {', '.join(sorted(EXTENSIONS))}" if EXTENSIONS else "there are none"
            word = line.words[1] if name else line.words[0]
            lines.fail(f"unknown extension; {known}{suggest(name, EXTENSIONS)}", line, word)
        if name in found:
            lines.fail(f"extension {name} is given twice (first on line {found[name].line})", line, line.words[1])
        found[name] = Extension(name, tuple(_content(lines, line)), line.number)
    return tuple(found.values())


def _content(lines: FieldLines, head: Line) -> list[tuple[int, str]]:
    content: list[tuple[int, str]] = []
    while True:
        line = lines.next(f"end extension ({' '.join(head.words[:2])} on line {head.number})")
        words = [word.lower() for word in line.words[:2]]
        if words == ["end", "extension"]:
            return content
        if words[0] == "extension":
            lines.fail(f"the extension that begins on line {head.number} has no line 'end extension'", line)
        content.append((line.number, " ".join(line.words)))
