"""FIELD's ``constraints``: distances that stay fixed, which integrators keep them, and what they take from a scene."""

from __future__ import annotations

import math

import numpy as np

from pydlpoly.errors import SceneError
from pydlpoly.formats.records import BondedLine, Field, FloatArray, Molecule
from pydlpoly.scene.beads import Layout
from pydlpoly.scene.cell import widths
from pydlpoly.scene.integrators import INTEGRATORS, WITH_CONSTRAINTS
from pydlpoly.scene.model import Constraints, Dynamics, ExternalTerm, Walls
from pydlpoly.scene.settings import Notes, Settings, place, places

_INDEPENDENT = 1e-6  # least singular value of the constraints' directions, relative to the largest
_TURNING_FIELDS = ("magn", "shrx")
_LARGEST_CHECKED = 2000  # constraints of a molecule


def resolve_constraints(
    settings: Settings,
    field: Field,
    layout: Layout,
    dynamics: Dynamics,
    positions: FloatArray,
    cell: FloatArray,
    periodic: tuple[bool, bool, bool],
    cutoff: float,
    config_path: str,
    notes: Notes,
    external: tuple[ExternalTerm, ...] = (),
    walls: Walls | None = None,
) -> Constraints | None:
    """Return the fixed distances of all molecules, or None when there are none.

    Constraints between two frozen beads hold by themselves and are left out, as in DL_POLY.

    Raises:
        SceneError: an integrator, a cell, walls or a field that do not go with fixed lengths, a length that is not
            positive, not below the cutoff or not below half the cell's width, and constraints of one molecule that
            depend on each other.
    """
    found = []
    first = 0
    for molecule in field.molecules:
        size, count = molecule.beads_per_molecule, molecule.count
        block = molecule.block("constraints")
        if block is not None and block.lines and count:
            kept = [line for line in block.lines if _is_kept(line, layout.frozen[first : first + size], field, notes)]
            lengths = np.array([_length(line, field, cutoff) for line in kept])
            local = np.array([line.beads for line in kept], dtype=np.int64).reshape(-1, 2) - 1
            offsets = first + size * np.arange(count)
            found.append((molecule, kept, (offsets[:, None, None] + local).reshape(-1, 2), np.tile(lengths, count)))
        first += size * count
    if not any(len(lengths) for *_, lengths in found):
        return None
    _check_integrator(settings, dynamics)
    _check_motion(settings, field, dynamics, external, walls)
    axes = list(periodic)
    limit = 0.5 * float(widths(cell)[axes].min()) if any(axes) else math.inf
    arms = [_arms(beads, positions, cell, periodic) for _, _, beads, _ in found]
    for (molecule, kept, beads, lengths), arm in zip(found, arms, strict=True):
        _check_cell(kept, field, limit)
        _check_start(beads, arm, lengths, limit, config_path, notes)
        _check_independent(molecule, kept, beads, arm, layout, field)
        _note_bonds(molecule, kept, field, notes)
    beads = np.concatenate([beads for _, _, beads, _ in found]).astype(np.int32)
    lengths = np.concatenate([lengths for *_, lengths in found])
    for array in (beads, lengths):
        array.setflags(write=False)  # a scene is immutable
    tolerance, most = settings.number("shake_tolerance"), settings.integer("shake_max_iter")
    if not 0.0 < tolerance < float(lengths.min()):
        expected = f"above 0 and below all lengths, the shortest of which is {lengths.min():g}"
        raise settings.refusal("shake_tolerance", f"the tolerance of constraints must be {expected}, not {tolerance:g}")
    if most < 1:
        raise settings.refusal("shake_max_iter", f"constraints need at least one iteration, not {most}")
    where = places(field.path, [line.line for _, kept, *_ in found for line in kept])
    return Constraints(beads, lengths, tolerance, most, where)


def left_by(constraints: Constraints | None, degrees: int, notes: Notes) -> int:
    """Return the degrees of freedom that constraints leave of ``degrees``."""
    if constraints is None:
        return degrees
    left = max(0, degrees - len(constraints.lengths))
    if left < 1:
        notes.warning("constraints leave no degree of freedom: the temperature is reported as 0")
    return left


def _refusal(line: BondedLine, field: Field, message: str, word: str | None = None) -> SceneError:
    return SceneError(message, path=field.path, line=line.line or None, word=word)


def _is_kept(line: BondedLine, frozen: np.ndarray, field: Field, notes: Notes) -> bool:
    if not frozen[[bead - 1 for bead in line.beads]].all():
        return True
    text = f"the constraint of beads {line.beads[0]} and {line.beads[1]} is left out: both are frozen"
    notes.ignored(text, place(field.path, line.line))
    return False


def _length(line: BondedLine, field: Field, cutoff: float) -> float:
    length, rest = line.parameters[0], line.parameters[1:]
    word = f"{length:g}"
    if not (length > 0.0 and math.isfinite(length)):
        raise _refusal(line, field, "the length of a constraint must be a positive number", word)
    if any(rest):
        extra = next(x for x in rest if x)
        raise _refusal(line, field, f"the number {extra:g} has no meaning: a constraint takes two beads and a length")
    if length >= cutoff:
        text = f"the constraint is not shorter than the cutoff, {cutoff:g} ang (DL_POLY's error 34)"
        raise _refusal(line, field, text, word)
    return length


def _check_integrator(settings: Settings, dynamics: Dynamics) -> None:
    if dynamics.barostat is not None:
        message = "constraints are not modelled in a cell that follows the pressure; take ensemble nve or nvt"
        raise settings.refusal("ensemble", message)
    if dynamics.integrator not in WITH_CONSTRAINTS:
        names = ", ".join(WITH_CONSTRAINTS)
        message = f"constraints are not modelled with {dynamics.integrator}; they are with {names}"
        raise settings.refusal("ensemble_dpd_order", message)
    if settings.steps("diagnostics_frequency"):
        message = "DIAGNOSTICS holds the configurational temperature, which is not modelled with constraints"
        raise settings.refusal("diagnostics_frequency", message)


def _check_motion(
    settings: Settings, field: Field, dynamics: Dynamics, external: tuple[ExternalTerm, ...], walls: Walls | None
) -> None:
    """Refuse what moves beads one by one, and correlations of a stress that knows nothing of fixed lengths."""
    if dynamics.shear_rate != 0.0:
        raise settings.refusal("shear_rate", "constraints are not modelled in a sheared cell")
    if walls is not None:
        raise settings.refusal("wall_method", "constraints are not modelled between walls")
    for line, term in zip(field.externals, external, strict=True):
        if term.key in _TURNING_FIELDS:
            message = "constraints are not modelled with a field that sets or turns velocities"
            raise SceneError(message, path=field.path, line=line.line or None, word=term.key)
    kind = INTEGRATORS[dynamics.integrator].kind if dynamics.integrator in INTEGRATORS else "none"
    if settings.given("correlation_observable") and kind in ("sweep", "simultaneous"):
        message = f"with constraints and {dynamics.integrator} the stress lacks what lengths do to drag and noise; "
        raise settings.refusal("correlation_observable", f"{message}mdvv has all of it")


def _arms(beads: np.ndarray, positions: FloatArray, cell: FloatArray, periodic: tuple[bool, bool, bool]) -> FloatArray:
    """Return the vectors from the second bead of each pair to the first, shortest images, (n, 3)."""
    apart = positions[beads[:, 0]] - positions[beads[:, 1]]
    fractions = apart @ np.linalg.inv(cell)
    return np.asarray((fractions - np.rint(fractions) * np.array(periodic)) @ cell)


def _check_cell(kept: list[BondedLine], field: Field, limit: float) -> None:
    for line in kept:
        if line.parameters[0] >= limit:
            text = f"the constraint is not shorter than half the cell's width, {limit:g} ang"
            raise _refusal(line, field, text, f"{line.parameters[0]:g}")


def _check_start(
    beads: np.ndarray, arms: FloatArray, lengths: FloatArray, limit: float, config_path: str, notes: Notes
) -> None:
    apart = np.linalg.norm(arms, axis=1)
    wrong = np.abs(apart - lengths)
    worst = int(wrong.argmax())
    i, j = sorted(int(bead) + 1 for bead in beads[worst])
    text = f"beads {i} and {j} are {apart[worst]:.6g} apart at the start, their constraint is {lengths[worst]:.6g}"
    if apart.max() > limit or wrong[worst] > 0.5 * lengths[worst]:
        raise SceneError(f"{text}: too far off to be mended", path=config_path)
    if wrong[worst] > 1e-6 * lengths[worst]:
        notes.choice(f"{text}; beads are moved to the lengths of constraints", place(config_path, None))


def _check_independent(
    molecule: Molecule, kept: list[BondedLine], beads: np.ndarray, arms: FloatArray, layout: Layout, field: Field
) -> None:
    """Refuse constraints of which some follow from the others: each would take a degree of freedom away."""
    count = len(kept)
    if not 0 < count <= _LARGEST_CHECKED:
        return
    first = int(beads[:count].min())
    rows = np.zeros((count, int(beads[:count].max()) - first + 1, 3))
    mobile = ~layout.frozen
    for k, ((i, j), arm) in enumerate(zip(beads[:count].tolist(), arms[:count], strict=True)):
        rows[k, i - first] = arm * mobile[i]
        rows[k, j - first] = -arm * mobile[j]
    rows /= np.linalg.norm(rows, axis=(1, 2), keepdims=True)
    values = np.linalg.svd(rows.reshape(count, -1), compute_uv=False)
    rank = int(np.count_nonzero(values > _INDEPENDENT * values[0]))
    # More constraints than coordinates have fewer singular values than rows.
    if rank < count:
        text = f"the {count} constraints of molecule {molecule.name} depend on each other at the start: {rank} fix the "
        raise _refusal(kept[0], field, f"{text}same shape; leave the others out", "constraints")


def _note_bonds(molecule: Molecule, kept: list[BondedLine], field: Field, notes: Notes) -> None:
    bonds = molecule.block("bonds")
    bonded = {tuple(sorted(line.beads)): line.line for line in bonds.lines} if bonds else {}
    for line in kept:
        pair = tuple(sorted(line.beads))
        if pair in bonded:
            text = f"beads {pair[0]} and {pair[1]} have a bond, too, on line {bonded[pair]}: its energy stays the same"
            notes.warning(text, place(field.path, line.line))
