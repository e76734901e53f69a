"""ASE in and out: scenes from ``ase.Atoms``, ``Atoms`` from scenes and states, and a calculator of conservative forces.

Units on the ASE side are ASE's: Å, eV, Da, and Å√(Da/eV) for times. An Å/ps is 1/(1000 fs) of ASE's velocity unit, and
a Da Å²/ps² (10 J/mol) is the square of that in eV, 1.0364269e-4: kinetic energies computed on either side agree to the
last digits. The numbers of a scene in reduced units (``units dpd``) are taken as Å, ps and Da.

Coordinates keep ASE's frame, in which a cell reaches from its corner at 0 to the sum of its vectors. A scene holds the
images around the origin, as DL_POLY does; ``atoms_from_state`` gives back the images inside ASE's cell.
"""

# mypy: allow-untyped-calls
# Most of ase's functions have no annotations.

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from ase import Atoms
from ase import units as ase_units
from ase.calculators.calculator import Calculator as AseCalculator
from ase.calculators.calculator import PropertyNotImplementedError, all_changes
from ase.calculators.singlepoint import SinglePointCalculator
from ase.stress import full_3x3_to_voigt_6_stress
from numpy.typing import NDArray

from pydlpoly.errors import SceneError
from pydlpoly.formats.control import read_control
from pydlpoly.formats.field import read_field
from pydlpoly.formats.from_python import Pairs, control_from_mapping, single_bead_field
from pydlpoly.formats.records import (
    BeadTable,
    Configuration,
    Control,
    Field,
    FloatArray,
    IntArray,
    Setting,
)
from pydlpoly.observation import single_point
from pydlpoly.scene.beads_state import CONCENTRATION, DENSITY, TEMPERATURE, dissolved_species, start_arrays
from pydlpoly.scene.cell import resolve_cell, wrap
from pydlpoly.scene.load import load
from pydlpoly.scene.model import Note, Scene
from pydlpoly.scene.settings import Notes
from pydlpoly.state import State

Path_ = str | PathLike[str]
ControlLike = Path_ | Control | Mapping[str, Any]

VELOCITY = 1.0 / (1000.0 * float(ase_units.fs))
"""One Å/ps in ASE's velocity unit."""
ENERGY = VELOCITY**2
"""One Da Å²/ps² (10 J/mol) in eV; also one Da Å/ps² in eV/Å."""

# Masses and charges of FIELD and of Atoms are the same when they agree to what text files usually hold.
_AGREEMENT = 1e-6
# A bead on a face of the cell that rounding puts just outside of it stays where it is (fraction of a cell vector).
_ON_FACE = 1e-12
# Below this, waiting for a second thread costs more than it saves in one evaluation of the forces.
_FEW_BEADS = 1000
# What a mapping may leave out: ``Simulation.run`` is told the length of a run, and a calculator moves nothing.
_SETTINGS = {"time_run": "0 steps"}
_CALCULATOR_SETTINGS = {"ensemble": "nve", "timestep": "1 fs", "temperature": "0 K"}


# -- From Atoms -------------------------------------------------------------------------------------------------------


def scene_from_atoms(
    atoms: Atoms,
    *,
    field: Path_ | Field | None = None,
    control: ControlLike,
    pairs: Pairs | None = None,
    units: str | None = None,
) -> Scene:
    """Return the scene that ``atoms`` as the start configuration makes with a force field and the run's settings.

    Species names are ``atoms.arrays["bead_types"]``, else ``atoms.arrays["names"]``, else the chemical symbols. The
    beads must come in FIELD's order, molecule by molecule; when all molecules are single beads, they are sorted by
    themselves (stable within a species) and ``Scene.source_order`` remembers where each bead stood. Masses and charges
    are FIELD's. Velocities of ``atoms`` that are not all zero are taken, unless ``control`` has a ``restart`` that says
    otherwise. Where beads carry heat or dissolved species, the arrays "temperature" (K, reduced with ``units dpd``) and
    "concentration_<name>" of ``atoms`` are their start.

    Args:
        atoms: positions (Å), cell, periodicity and velocities.
        field: a FIELD file or its record; the table of ``tab`` pairs is looked for beside the file.
        control: a CONTROL file, its record, or a mapping of keywords to values, with units in strings:
            ``{"ensemble": "nve", "timestep": "10 fs", "cutoff": "8 ang"}``; it needs no ``time_run``.
        pairs: in place of ``field``, pair laws by species: ``{("A", "B"): ("dpd", 25.0, 1.0, 4.5)}`` with the numbers
            of FIELD's vdw records. Every bead is a molecule of its own; its mass and charge are those of ``atoms``.
        units: FIELD's energy unit for the numbers of ``pairs``: ev, kcal, kj, k, internal or dpd.

    Raises:
        InputError: a file or a setting cannot be read.
        SceneError: the pieces contradict each other, or ask for what is not modelled.
    """
    names = bead_names(atoms)
    force_field = _field(atoms, names, field, pairs, units)
    order = _order(names, force_field)
    config = _configuration(atoms, names, order)
    settings, notes = _start(_control(control), config)
    table = _bead_table(atoms, order)
    scene = load(Path(force_field.path).parent, control=settings, field=force_field, config=config, beads=table)
    _check_beads(scene, atoms, order)
    return replace(
        scene,
        notes=(*scene.notes, *notes, *_oddities(atoms, scene, order)),
        source_order=order,
        source_cell=None if all(scene.periodic) else np.array(atoms.cell.array),
    )


def bead_names(atoms: Atoms) -> NDArray[np.str_]:
    """Return the species names of ``atoms``, (N,): its arrays bead_types or names, else the chemical symbols.

    Raises:
        SceneError: the array does not hold strings.
    """
    for key in ("bead_types", "names"):
        if key in atoms.arrays:
            array = atoms.arrays[key]
            if array.dtype.kind != "U" and not (array.dtype.kind == "O" and all(isinstance(x, str) for x in array)):
                message = f"must hold the species names as strings, not {array.dtype}"
                raise SceneError(message, path="atoms", word=key)
            return np.asarray(array, dtype=np.str_)
    return np.array(atoms.get_chemical_symbols(), dtype=np.str_)


def _field(
    atoms: Atoms, names: NDArray[np.str_], field: Path_ | Field | None, pairs: Pairs | None, units: str | None
) -> Field:
    if pairs is None:
        if field is None:
            raise SceneError("a force field is needed: the argument field, or pairs with units")
        if units is not None:
            raise SceneError("the argument units belongs to pairs; a FIELD has units of its own", word=units)
        return field if isinstance(field, Field) else read_field(Path(field))
    if field is not None:
        raise SceneError("the arguments field and pairs exclude each other: pair laws belong to FIELD's vdw block")
    if units is None:
        raise SceneError("pairs need the argument units: ev, kcal, kj, k, internal or dpd")
    masses, charges = atoms.get_masses(), atoms.get_initial_charges()
    return single_bead_field(names, masses, charges, pairs, units, names_from="atoms")


def _order(names: NDArray[np.str_], field: Field) -> IntArray | None:
    """Return where each bead of FIELD stands in ``atoms``, or None when it is the same place.

    Beads that cannot be sorted keep their places, and the scene names the first that does not match.
    """
    single = all(molecule.beads_per_molecule == 1 for molecule in field.molecules if molecule.count)
    expected = np.repeat(
        np.array([atom.name for m in field.molecules for atom in m.atoms], dtype=np.str_),
        [atom.repeat * m.count for m in field.molecules for atom in m.atoms],
    )
    if not single or len(expected) != len(names) or np.array_equal(expected, names):
        return None
    by_name, found = np.argsort(expected, kind="stable"), np.argsort(names, kind="stable")
    if not np.array_equal(expected[by_name], names[found]):
        kinds = sorted({*expected.tolist(), *names.tolist()})
        counts = [(kind, int((expected == kind).sum()), int((names == kind).sum())) for kind in kinds]
        text = ", ".join(f"{have} {kind} instead of {need}" for kind, need, have in counts if need != have)
        raise SceneError(f"the beads are not those of {field.path}: {text}", path="atoms")
    order = np.empty(len(names), dtype=np.int64)
    order[by_name] = found
    return order


def _control(control: ControlLike) -> Control:
    if isinstance(control, Control):
        return control
    if isinstance(control, Mapping):
        return control_from_mapping({**_SETTINGS, **control})
    return read_control(Path(control))


def _start(control: Control, config: Configuration) -> tuple[Control, tuple[Note, ...]]:
    """Let velocities that are there be taken where CONTROL does not say otherwise."""
    given = control.get("restart")
    if config.velocities is None or not config.velocities.any():  # ASE's way of saying that there are none
        return control, ()
    if given is None:
        note = Note("choice", "no restart is given: the velocities of atoms are taken (noscale)", "atoms")
        return replace(control, settings=(*control.settings, Setting("restart", "noscale"))), (note,)
    if given.value == "clean":
        return control, (Note("ignored", "restart clean: the velocities of atoms are replaced by drawn ones", "atoms"),)
    return control, ()


def _oddities(atoms: Atoms, scene: Scene, order: IntArray | None) -> list[Note]:
    """Return notes about what ``atoms`` holds and the scene does not take."""
    notes = []
    if atoms.constraints:
        text = "the constraints of atoms have no effect on the scene; beads that never move are those frozen in FIELD"
        notes.append(Note("ignored", text, "atoms"))
    masses = _sorted(atoms.get_masses(), order)
    if scene.beads.velocities is not None and not np.allclose(masses, scene.beads.mass, rtol=_AGREEMENT, atol=0.0):
        text = f"ASE's masses of the elements are not those of {scene.sources[1]}: velocities, not momenta, are taken"
        notes.append(Note("warning", text, "atoms"))
    return notes


def _configuration(atoms: Atoms, names: NDArray[np.str_], order: IntArray | None) -> Configuration:
    """Return the record of what ``atoms`` holds, in the scene's order."""
    velocities = None
    if atoms.has("momenta"):
        velocities = _sorted(np.asarray(atoms.get_velocities(), dtype=np.float64), order) / VELOCITY
    cell = np.array(atoms.cell.array, dtype=np.float64)
    imcon = _imcon(cell, tuple(bool(x) for x in atoms.pbc))
    return Configuration(
        names=tuple(_sorted(names, order).tolist()),
        positions=_sorted(np.array(atoms.positions, dtype=np.float64), order),
        title="from ASE",
        imcon=imcon,
        cell=cell if imcon > 0 else np.zeros((3, 3)),  # an open system has a box around its beads, not ASE's
        velocities=velocities,
        path="atoms",
    )


def _bead_table(atoms: Atoms, order: IntArray | None) -> BeadTable | None:
    """Return what the arrays of ``atoms`` say that beads carry, in the scene's order; None when they say nothing."""
    names = [key for key in atoms.arrays if key == TEMPERATURE or key.startswith(CONCENTRATION)]
    columns = []
    for name in names:
        column = np.asarray(atoms.arrays[name])
        if column.shape != (len(atoms),) or column.dtype.kind not in "fiu":
            message = f"must hold one number an atom, not {column.dtype} of shape {column.shape}"
            raise SceneError(message, path="atoms", word=name)
        columns.append(_sorted(column.astype(np.float64), order))
    return BeadTable(tuple(names), np.column_stack(columns), rows=order, path="atoms") if names else None


def _sorted(values: NDArray[Any], order: IntArray | None) -> NDArray[Any]:
    return values if order is None else values[order]


def _imcon(cell: FloatArray, periodic: tuple[bool, ...]) -> int:
    """Return DL_POLY's periodicity key; SceneError for what it has no key for."""
    if not any(periodic):
        return 0
    if periodic == (True, True, False):
        if np.any(cell[:2, 2] != 0.0) or np.any(cell[2, :2] != 0.0):
            rows = "; ".join(" ".join(f"{x:g}" for x in row) for row in cell)
            message = f"a slab needs its first two cell vectors in the xy plane and the third along z, not {rows}"
            raise SceneError(message, path="atoms")
        return 6
    if not all(periodic):
        axes = " and ".join(axis for axis, on in zip("abc", periodic, strict=True) if on)
        message = f"periodicity along {axes} alone is not modelled; only none, all three, or a and b (a slab)"
        raise SceneError(message, path="atoms", word=f"pbc {' '.join('FT'[on] for on in periodic)}")
    edges = np.diag(cell)
    if np.any(cell != np.diag(edges)) or not np.all(edges > 0.0):
        return 3
    return 1 if edges[0] == edges[1] == edges[2] else 2


def _check_beads(scene: Scene, atoms: Atoms, order: IntArray | None) -> None:
    """Refuse masses and charges that were set on ``atoms`` and are not the scene's."""
    for key, what, unit, values in (
        ("masses", "mass", "Da", scene.beads.mass),
        ("initial_charges", "charge", "e", scene.beads.charge),
    ):
        if not atoms.has(key):
            continue
        found = _sorted(atoms.arrays[key], order)
        different = np.nonzero(~np.isclose(found, values, rtol=_AGREEMENT, atol=0.0))[0]
        if len(different):
            k = int(different[0])
            bead = k if order is None else int(order[k])
            message = f"the {what} of bead {bead + 1} is {found[k]:.10g} {unit}, but {scene.sources[1]} gives "
            message += f"{values[k]:.10g} {unit}; correct one of them, or delete atoms.arrays[{key!r}]"
            raise SceneError(message, path="atoms", word=scene.species[scene.beads.species[k]])


# -- To Atoms ---------------------------------------------------------------------------------------------------------


def atoms_from_state(scene: Scene, state: State | None = None, *, forces: bool = False) -> Atoms:
    """Return a state of a scene, or the scene's own start, as ``Atoms``.

    All symbols are X, because a bead is no element: the species names are in ``arrays["bead_types"]``. Masses and
    charges are the scene's, velocities and cell the state's. Positions are wrapped into the cell from its corner at 0
    along periodic axes; along other axes they are left alone, and the cell vector there is that of the ``Atoms`` the
    scene was made from, zero when it was made from files. Beads come in the order of those ``Atoms``. What they carry
    is in the arrays "temperature" (K, reduced with ``units dpd``), "concentration_<name>" and "density" (local).

    Args:
        scene: what is simulated.
        state: ``Simulation.state``; without it the scene's start, without velocities when they are to be drawn.
        forces: attach a ``SinglePointCalculator`` with the forces in eV/Å: the state's (drag and noise included), or
            energy and conservative forces of the scene's start.
    """
    beads = scene.beads
    cell = scene.cell if state is None else state.cell
    positions = beads.positions if state is None else state.positions
    velocities = beads.velocities if state is None else state.velocities
    names = np.array(scene.species, dtype=np.str_)[beads.species]
    atoms = Atoms(
        numbers=np.zeros(len(beads), dtype=np.int64),
        positions=_in_source_order(scene, _wrap_from_corner(positions, cell, scene.periodic)),
        cell=_source_cell(scene, cell),
        pbc=scene.periodic,
        masses=_in_source_order(scene, beads.mass),
        charges=_in_source_order(scene, beads.charge),
    )
    atoms.set_array("bead_types", _in_source_order(scene, names))
    for name, values in (start_arrays(scene) if state is None else _carried(scene, state)).items():
        atoms.set_array(name, _in_source_order(scene, values))
    if velocities is not None:
        atoms.set_velocities(_in_source_order(scene, velocities) * VELOCITY)
    if forces:
        results: dict[str, Any] = {}
        if state is None:
            point = single_point(scene)
            results["energy"] = point.energy["total"] * ENERGY
        values = point.forces if state is None else state.forces
        atoms.calc = SinglePointCalculator(atoms, forces=_in_source_order(scene, values) * ENERGY, **results)
    return atoms


def _carried(scene: Scene, state: State) -> dict[str, FloatArray]:
    arrays = {TEMPERATURE: state.temperature, DENSITY: state.density}
    if state.concentrations is not None:
        columns = state.concentrations.T
        arrays |= {CONCENTRATION + name: one for name, one in zip(dissolved_species(scene), columns, strict=True)}
    return {name: values for name, values in arrays.items() if values is not None}


def _in_source_order(scene: Scene, values: NDArray[Any]) -> NDArray[Any]:
    if scene.source_order is None:
        return values
    result = np.empty_like(values)
    result[scene.source_order] = values
    return result


def _wrap_from_corner(positions: FloatArray, cell: FloatArray, periodic: tuple[bool, bool, bool]) -> FloatArray:
    """Return positions with fractional coordinates in [0, 1) along periodic axes; those inside keep every bit."""
    cells = np.where(periodic, np.floor(positions @ np.linalg.inv(cell) + _ON_FACE), 0.0)
    return np.where(cells.any(axis=1, keepdims=True), positions - cells @ cell, positions)


def _source_cell(scene: Scene, cell: FloatArray) -> FloatArray:
    source = np.zeros((3, 3)) if scene.source_cell is None else scene.source_cell
    return np.where(np.array(scene.periodic)[:, None], cell, source)


# -- Calculator -------------------------------------------------------------------------------------------------------


class Calculator(AseCalculator):
    """ASE calculator of the conservative part of a scene: no drag, no noise.

    Energy (eV), forces (eV/Å) and, for systems periodic along all axes, stress (eV/Å³; xx, yy, zz, yz, xz, xy;
    compression negative) of ``pydlpoly.single_point``.

    Args:
        scene: what is modelled; ``atoms`` may then change positions and cell, but not beads and periodicity.
        field, control, pairs, units: in place of ``scene``, what ``scene_from_atoms`` needs to make it from the atoms.
            A ``control`` that is a mapping needs only a ``cutoff``: nothing moves.
        threads: number of threads (default: the scene's, else one for few beads, else all processors).

    Raises:
        SceneError: both or neither of ``scene`` and ``control`` are given; later, when the atoms make no scene, or the
            scene has external fields, whose forces have no energy in DL_POLY.
    """

    implemented_properties: list[str] = ["energy", "free_energy", "forces", "stress"]  # noqa: RUF012  # ASE's own type

    def __init__(
        self,
        scene: Scene | None = None,
        *,
        field: Path_ | Field | None = None,
        control: ControlLike | None = None,
        pairs: Pairs | None = None,
        units: str | None = None,
        threads: int | None = None,
    ) -> None:
        super().__init__()
        given = [x for x in (field, control, pairs, units) if x is not None]
        if (scene is None) != (control is not None) or (scene is not None and given):
            raise SceneError("a calculator needs either a scene, or control with field or pairs")
        if isinstance(control, Mapping):
            control = {**_CALCULATOR_SETTINGS, **control}
        self._recipe: dict[str, Any] = {"field": field, "control": control, "pairs": pairs, "units": units}
        self._fixed = scene is not None
        self._scene, self._threads = scene, threads

    def check_state(self, atoms: Atoms, tol: float = 1e-15) -> list[str]:
        """Return what has changed since the last calculation; other species names count as other numbers."""
        changes: list[str] = super().check_state(atoms, tol)
        if self.atoms is not None and not np.array_equal(bead_names(atoms), bead_names(self.atoms)):
            changes = list(dict.fromkeys([*changes, "numbers"]))
        return changes

    def calculate(
        self,
        atoms: Atoms | None = None,
        properties: Sequence[str] = ("energy",),
        system_changes: Sequence[str] = tuple(all_changes),
    ) -> None:
        """Compute all properties; called by ASE."""
        super().calculate(atoms, properties, system_changes)
        if self.atoms is None:
            raise SceneError("a calculator needs atoms to compute anything")
        if "stress" in properties and not all(self.atoms.pbc):
            message = "stress needs a system that is periodic along all three axes: without that it has no volume"
            raise PropertyNotImplementedError(message)
        scene = self._scene_of(self.atoms, system_changes)
        few = 1 if scene.bead_count < _FEW_BEADS else None
        point = single_point(scene, threads=self._threads or scene.run.threads or few)
        energy = point.energy["total"] * ENERGY
        self.results = {
            "energy": energy,
            "free_energy": energy,
            "forces": _in_source_order(scene, point.forces) * ENERGY,
        }
        if all(scene.periodic):
            self.results["stress"] = -full_3x3_to_voigt_6_stress(point.stress) * ENERGY

    def _scene_of(self, atoms: Atoms, changes: Sequence[str]) -> Scene:
        """Return the scene of these atoms: the last one moved, or a new one when more than that changed."""
        same = self._scene is not None and not {"numbers", "pbc", "initial_charges"} & {*changes}
        if self._scene is None or not (same or self._fixed):
            self._scene = scene_from_atoms(atoms, **self._recipe)
        else:
            self._scene = _moved(self._scene, atoms, check=not same)
        if self._scene.external:
            keys = ", ".join(term.key for term in self._scene.external)
            raise SceneError(f"a calculator cannot have external fields ({keys}): their forces have no energy")
        if self._scene.walls is not None or self._scene.dynamics.shear_rate != 0.0:
            raise SceneError("a calculator cannot have walls or a sheared cell: ASE moves the beads itself")
        return self._scene


def _moved(scene: Scene, atoms: Atoms, *, check: bool) -> Scene:
    """Return the scene with the positions and the cell of ``atoms``."""
    names = bead_names(atoms)
    if check:
        _check_same(scene, atoms, names)
    config = _configuration(atoms, names, scene.source_order)
    cell, periodic = resolve_cell(config, scene.cutoff, Notes())
    beads = replace(scene.beads, positions=wrap(config.positions, cell, periodic))
    return replace(scene, beads=beads, cell=cell, imcon=config.imcon)


def _check_same(scene: Scene, atoms: Atoms, names: NDArray[np.str_]) -> None:
    if tuple(atoms.pbc) != scene.periodic:
        expected, found = (" ".join("FT"[bool(on)] for on in pbc) for pbc in (scene.periodic, atoms.pbc))
        raise SceneError(f"the calculator's scene has periodicity {expected}, not {found}", path="atoms", word="pbc")
    if len(names) != len(scene.beads):
        raise SceneError(f"the calculator's scene has {len(scene.beads)} beads, not {len(names)}", path="atoms")
    species = _in_source_order(scene, np.array(scene.species, dtype=np.str_)[scene.beads.species])
    for bead in np.nonzero(species != names)[0].tolist():
        raise SceneError(
            f"bead {bead + 1} is {species[bead]} in the calculator's scene", path="atoms", word=str(names[bead])
        )
    _check_beads(scene, atoms, scene.source_order)
