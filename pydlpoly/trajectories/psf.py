"""PSF: what a DCD does not say of its beads, in the variant with blanks between words that is marked NAMD.

The remarks hold what has no place elsewhere, as words after ``pydlpoly``; other programs pass them over.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import atomic_file
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.records import IntArray
from pydlpoly.trajectories import base

_ROWS = 50_000  # beads whose lines are held at the same time
_SECTIONS = {"bond": ("NBOND: bonds", 4), "angle": ("NTHETA: angles", 3), "dihedral": ("NPHI: dihedrals", 2)}
_SECTIONS["inversion"] = ("NIMPHI: impropers", 2)
_ATTRIBUTES = {"bond": "bonds", "angle": "angles", "dihedral": "dihedrals", "inversion": "impropers"}
_MARK = "REMARKS pydlpoly "


def write_psf(path: str, like: Frame, topology: base.Topology) -> None:
    """Write names, masses, charges, molecules and links; the file is replaced in one instant.

    Raises:
        InputError: the masses or charges of the beads are not known.
        RunError: the file cannot be written.
    """
    if not (base.known(like.masses) and base.known(like.charges)):
        raise InputError("PSF needs the masses and charges of all beads, which the frames do not give", path=path)
    count = len(like.names)
    remarks = [f"REMARKS {topology.title}", f"{_MARK}imcon {like.imcon} reduced {int(topology.reduced)}"]
    if like.timestep is not None:
        remarks.append(f"{_MARK}timestep {like.timestep!r}")
    if np.any(like.cell):
        remarks.append(f"{_MARK}cell {','.join(repr(value) for value in like.cell.ravel().tolist())}")
    head = "".join(f" {line}\n" for line in remarks)
    with atomic_file(path) as file:
        file.write(f"PSF NAMD\n\n{len(remarks):8d} !NTITLE\n{head}\n{count:8d} !NATOM\n".encode())
        molecules = np.zeros(count, dtype=np.int64) if topology.molecules is None else topology.molecules
        for start in range(0, count, _ROWS):
            part = slice(start, start + _ROWS)
            rows = zip(
                range(start + 1, count + 1),
                (molecules[part] + 1).tolist(),
                like.names[part],
                like.charges[part].tolist(),
                like.masses[part].tolist(),
                strict=False,
            )
            text = [f"{k:8d} SYSTEM {m} MOL {name} {name} {charge!r} {mass!r} 0\n" for k, m, name, charge, mass in rows]
            file.write("".join(text).encode())
        for kind, (name, a_line) in _SECTIONS.items():
            links = topology.links.get(kind)
            beads = np.zeros((0, 2), dtype=np.int64) if links is None else links.beads
            file.write(f"\n{len(beads):8d} !{name}\n".encode())
            file.writelines(_lines(beads + 1, a_line))
        file.write(b"\n")


def _lines(beads: IntArray, a_line: int) -> Iterator[bytes]:
    for start in range(0, len(beads), a_line):
        yield ("".join(f"{k:8d} " for k in beads[start : start + a_line].ravel().tolist()).rstrip() + "\n").encode()


def read_psf(path: str) -> tuple[dict[str, Any], base.Topology]:
    """Return what is the same in all frames of a DCD, as arguments of ``Frame``, and the topology.

    Raises:
        InputError: the file is missing or no PSF, or MDAnalysis is missing.
    """
    parsers = base.package("MDAnalysis.topology.PSFParser", "reading a DCD", "MDAnalysis")
    if not Path(path).is_file():
        message = "there is no such file; a DCD has no names and masses, and those of its beads are expected here"
        raise InputError(message, path=path)
    try:
        with parsers.PSFParser(path) as parser:
            found = parser.parse()
    except (ValueError, IndexError, StopIteration) as error:
        raise InputError(f"is not a PSF file that MDAnalysis reads: {error}", path=path) from error
    remarks = _remarks(path)
    words = dict(zip(remarks["words"][::2], remarks["words"][1::2], strict=False))
    fixed: dict[str, Any] = {
        "names": tuple(str(name) for name in found.types.values),
        "masses": np.array(found.masses.values, dtype=np.float64),
        "charges": np.array(found.charges.values, dtype=np.float64),
        "imcon": int(words["imcon"]) if "imcon" in words else None,
        "timestep": float(words["timestep"]) if "timestep" in words else None,
        "cell": np.array(words["cell"].split(","), dtype=np.float64).reshape(3, 3) if "cell" in words else None,
    }
    links = {}
    for kind, name in _ATTRIBUTES.items():
        beads = np.array(list(getattr(found, name).values), dtype=np.int64)
        if len(beads):
            links[kind] = _named(beads, fixed["names"])
    molecules = np.array(found.tt.atoms2residues(np.arange(found.n_atoms)), dtype=np.int64)
    return fixed, base.Topology(str(remarks["title"]), words.get("reduced") == "1", molecules, links)


def _remarks(path: str) -> dict[str, Any]:
    title, words = "", []
    with Path(path).open(encoding="latin-1") as file:
        for line in file:
            text = line.strip()
            if text.endswith("!NATOM"):
                break
            if text.startswith(_MARK):
                words += text.removeprefix(_MARK).split()
            elif text.startswith("REMARKS") and not title:
                title = text.removeprefix("REMARKS").strip()
    return {"title": title, "words": words}


def _named(beads: IntArray, names: tuple[str, ...]) -> base.Links:
    return base.named_links(beads, np.unique(np.array(names, dtype=object), return_inverse=True))
