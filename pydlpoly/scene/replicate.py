"""``nfold``: a configuration repeated along its cell vectors, with as many times the molecules."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pydlpoly.errors import SceneError
from pydlpoly.formats.records import Configuration, Field, FloatArray, Molecule
from pydlpoly.scene.beads import MOST_BEADS, check_configuration, lay_out
from pydlpoly.scene.cell import resolve_cell
from pydlpoly.scene.settings import Notes, Settings


def replicate(field: Field, config: Configuration, counts: Sequence[int]) -> tuple[Field, Configuration]:
    """Return FIELD with counts times as many molecules, and CONFIG repeated so often along its cell vectors.

    Molecules that a face of the cell cuts are made whole first, so that each copy's beads belong together in the larger
    cell. The origin stays the centre of the cell. Velocities and forces are repeated, too. The copies of a molecule
    type stay together: image after image, each in the order of CONFIG.

    Args:
        field: the molecules.
        config: a periodic configuration of theirs.
        counts: how often along each cell vector; 1 along a direction that is not periodic.

    Raises:
        SceneError: counts that are not whole numbers from 1 on, a direction that is not periodic, records that
            contradict each other, or molecules that are bonded to their own image and so cannot be made whole.
    """
    check_configuration(lay_out(field, Notes()), field, config)
    numbers = _checked(counts, config, field.bead_count)
    cell = np.array(config.cell) if config.imcon in (0, 6) else resolve_cell(config, 1.0, Notes())[0]
    if numbers == (1, 1, 1):
        return field, config
    images = np.stack(np.meshgrid(*(np.arange(n) - 0.5 * (n - 1) for n in numbers), indexing="ij"), axis=-1)
    shifts = images.reshape(-1, 3) @ cell
    whole = _whole(field, config, cell)
    copies = len(shifts)

    def repeated(values: FloatArray, moves: FloatArray) -> FloatArray:
        blocks = [(values[start:end][None, :, :] + moves[:, None, :]).reshape(-1, 3) for start, end in _ranges(field)]
        return np.concatenate(blocks)

    still = np.zeros_like(shifts)
    molecules = tuple(replace(molecule, count=molecule.count * copies) for molecule in field.molecules)
    imcon = 2 if config.imcon == 1 and len(set(numbers)) > 1 else config.imcon
    larger = replace(
        config,
        names=tuple(name for start, end in _ranges(field) for name in config.names[start:end] * copies),
        positions=repeated(whole, shifts),
        imcon=imcon,
        cell=cell * np.array(numbers)[:, None],
        velocities=None if config.velocities is None else repeated(config.velocities, still),
        forces=None if config.forces is None else repeated(config.forces, still),
    )
    return replace(field, molecules=molecules), larger


def replicate_as_asked(
    settings: Settings, field: Field, config: Configuration, notes: Notes
) -> tuple[Field, Configuration]:
    """Return the records after CONTROL's ``nfold``. Raises SceneError as ``replicate``, naming the keyword's place."""
    asked = settings.vector("nfold")
    if asked == (1, 1, 1):
        return field, config
    where = settings.where("nfold")
    try:
        numbers = _checked(asked, config, field.bead_count)
    except SceneError as error:
        raise settings.refusal("nfold", error.message) from None
    larger, configuration = replicate(field, config, numbers)
    times = " x ".join(str(n) for n in numbers)
    notes.choice(
        f"nfold: the configuration is repeated {times} times, {field.bead_count} beads become {larger.bead_count}",
        where,
    )
    for term in field.externals:
        text = f"the external field {term.key} acts on the repeated configuration as on any other; it is not repeated"
        notes.choice(text, where)
    return larger, configuration


def _checked(counts: Sequence[float], config: Configuration, beads: int) -> tuple[int, int, int]:
    """Return the three whole numbers."""
    text = " ".join(f"{n:g}" for n in counts)
    if len(counts) != 3 or not all(n >= 1 and float(n).is_integer() for n in counts):
        raise SceneError(f"expected three whole numbers from 1 on, not {text}")
    a, b, c = (int(n) for n in counts)
    if config.imcon == 0 and (a, b, c) != (1, 1, 1):
        raise SceneError(f"a configuration that is not periodic (imcon 0) cannot be repeated {text} times")
    if config.imcon == 6 and c != 1:
        raise SceneError(
            f"a slab (imcon 6) is not periodic along its third vector and cannot be repeated {c} times there"
        )
    if a * b * c * beads > MOST_BEADS:
        raise SceneError(f"{beads} beads repeated {text} times are more than {MOST_BEADS}")
    return a, b, c


def _ranges(field: Field) -> list[tuple[int, int]]:
    """Return first bead and end of each molecule type."""
    ends = np.cumsum([0, *(m.count * m.beads_per_molecule for m in field.molecules)]).tolist()
    return list(pairwise(ends))


def _whole(field: Field, config: Configuration, cell: FloatArray) -> FloatArray:
    """Return the positions with the beads of each molecule at the images that its bonded terms connect."""
    positions = np.array(config.positions, dtype=np.float64)
    periodic = np.array([True, True, config.imcon != 6])
    inverse = np.zeros((3, 3))
    axes = np.flatnonzero(periodic)
    inverse[:, axes] = np.linalg.pinv(cell[axes])
    for molecule, (start, end) in zip(field.molecules, _ranges(field), strict=True):
        links = _links(molecule)
        if not links or start == end:
            continue
        beads = positions[start:end].reshape(molecule.count, -1, 3)
        for bead, parent in _tree(links):
            apart = beads[:, bead] - beads[:, parent]
            beads[:, bead] -= np.rint(apart @ inverse) @ cell
        a, b = np.array(sorted(links), dtype=np.int64).T
        torn = np.rint((beads[:, a] - beads[:, b]) @ inverse).any(axis=(1, 2))
        if torn.any():
            copy = int(np.flatnonzero(torn)[0]) + 1
            message = f"copy {copy} of molecule {molecule.name} is bonded to its own image in the next cell: it has no "
            raise SceneError(f"{message}ends and cannot be repeated", path=config.path)
        positions[start:end] = beads.reshape(-1, 3)
    return positions


def _links(molecule: Molecule) -> set[tuple[int, int]]:
    """Return pairs of local bead numbers, from 0, that a bonded line names one after the other."""
    return {
        (min(a, b) - 1, max(a, b) - 1)
        for block in molecule.blocks
        for line in block.lines
        for a, b in pairwise(line.beads)
    }


def _tree(links: set[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return (bead, bead it hangs on), each after the one it hangs on; the first bead of each part hangs on none."""
    around: dict[int, list[int]] = {}
    for a, b in sorted(links):
        around.setdefault(a, []).append(b)
        around.setdefault(b, []).append(a)
    order: list[tuple[int, int]] = []
    seen: set[int] = set()
    for root in sorted(around):
        queue = [] if root in seen else [root]
        seen.add(root)
        for bead in queue:
            for other in around[bead]:
                if other not in seen:
                    seen.add(other)
                    queue.append(other)
                    order.append((other, bead))
    return order
