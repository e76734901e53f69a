"""``build``: from a description in Python objects to records, and from them to files, a scene or ``Atoms``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pydlpoly.build.amounts import (
    Component,
    Salt,
    as_molecule,
    charge_of,
    count_of,
    counter_ions,
    ions_of,
)
from pydlpoly.build.arrange import Arranger, Entry, needed_density
from pydlpoly.build.assembly import Bilayer, Lamella
from pydlpoly.build.molecules import MoleculeType, Species
from pydlpoly.build.regions import Everywhere
from pydlpoly.build.topology import (
    Kind,
    Laws,
    least_distances,
    molecule_record,
    pair_records,
    species_named,
)
from pydlpoly.errors import SceneError
from pydlpoly.formats.atomic import replace_file
from pydlpoly.formats.config_writer import write_config
from pydlpoly.formats.control import write_control
from pydlpoly.formats.field_writer import write_field
from pydlpoly.formats.from_python import control_from_mapping
from pydlpoly.formats.lexing import WORD_LIMIT
from pydlpoly.formats.records import Configuration, Control, Field, FloatArray
from pydlpoly.units import energy_unit

if TYPE_CHECKING:
    from ase import Atoms

    from pydlpoly.scene.model import Scene

Part = Component | Bilayer | Lamella | Salt | MoleculeType | str

# What CONTROL says unless ``run`` says otherwise; the units are those of ``units dpd``.
_RUN = {"ensemble": "nvt", "ensemble_method": "dpd", "ensemble_dpd_order": "mdvv", "vdw_method": "direct"}
_REDUCED = {"temperature": "1.0 dpd_temp", "timestep": "0.01 dpd_t"}
_LENGTH = {"time_run": "2000 steps", "print_frequency": "200 steps", "stats_frequency": "20 steps"}
# CONFIG has ten digits of each number; places are rounded to what it holds, so that files and records agree.
_DIGITS, _DECIMALS = 10, 6
_NEUTRAL = 1e-6


@dataclass(frozen=True, eq=False)
class Built:
    """What ``build`` returns: the three records, and what they make.

    Attributes:
        control, field, config: as read from files.
        counts: molecules by name.
        density: number density of beads.
        charge: total charge in e.
    """

    control: Control
    field: Field
    config: Configuration
    counts: Mapping[str, int]
    density: float
    charge: float
    warnings: tuple[str, ...] = ()

    def scene(self) -> Scene:
        """Return the scene. Raises SceneError where a file with the same content would be refused."""
        from pydlpoly.scene.resolve import resolve  # the scene imports parts of this package

        return resolve(self.control, self.field, self.config)

    def write(self, folder: str | PathLike[str]) -> Path:
        """Write CONTROL, FIELD and CONFIG into a folder, which is made, and return it."""
        target = Path(folder)
        target.mkdir(parents=True, exist_ok=True)
        texts = {
            "CONTROL": write_control(self.control),
            "FIELD": write_field(self.field),
            "CONFIG": write_config(self.config),
        }
        for name, text in texts.items():
            replace_file(target / name, text)
        return target

    def to_atoms(self) -> Atoms:
        """Return the beads as ``ase.Atoms``: species in the array bead_types, molecules (from 0) in molecules, and the
        bonds, (bonds, 2) bead numbers from 0, in ``info["bonds"]``.
        """
        from pydlpoly.ase import atoms_from_state

        scene = self.scene()
        atoms = atoms_from_state(scene)
        atoms.arrays["molecules"] = np.array(scene.beads.molecule)
        terms = scene.bonded.terms if scene.bonded is not None else ()
        bonds = [np.asarray(term.beads, dtype=np.int64) for term in terms if term.kind == "bond"]
        atoms.info["bonds"] = np.concatenate(bonds) if bonds else np.zeros((0, 2), dtype=np.int64)
        return atoms

    def report(self) -> str:
        """Return counts, density and charge as text."""
        lines = [f"{len(self.config.names)} beads, density {self.density:.6g}, charge {self.charge:+.6g}"]
        lines += [
            f"{molecule.count:8d} {molecule.name} of {molecule.beads_per_molecule} beads"
            for molecule in self.field.molecules
        ]
        return "\n".join([*lines, *(f"warning: {text}" for text in self.warnings)])


def build(
    *,
    box: float | Sequence[float] | Sequence[Sequence[float]] | FloatArray,
    species: Iterable[Species | str],
    molecules: Sequence[Part],
    pairs: Mapping[Any, Any],
    bonds: Laws | None = None,
    angles: Laws | None = None,
    density: float | None = None,
    length: float | None = None,
    mixing: str | None = None,
    exclude_bonded: bool = False,
    minimum_distance: float | Mapping[Any, float] = 0.0,
    neutralise: Sequence[MoleculeType | str] = (),
    run: Mapping[str, Any] | None = None,
    units: str = "dpd",
    title: str = "built by pydlpoly",
    seed: int = 1,
) -> Built:
    """Return the records of molecules placed in a periodic cell.

    Args:
        box: an edge, three edges, or the cell vectors by row; the origin is the centre.
        species: names alone stand for mass 1 and no charge.
        molecules: what to place, in FIELD's order; a molecule or species alone fills what is left of the cell.
        pairs: pair laws by species; see ``pydlpoly.build.topology.pair_records``.
        bonds, angles: laws by species, ``{("A", "B"): ("harm", 128.0, 0.5), "*": (…)}``; every bond needs one.
        density: number density of beads, for what is given as a fraction or fills the cell.
        length: the unit of length in nm, for concentrations in mol/L.
        mixing: ``vdw_mix_method`` of CONTROL, for pairs that are not given.
        exclude_bonded: bonded beads do not feel their pair laws, as DL_POLY's plain keys mean. Without it, all keys
            become the restraint form (``-hrm`` for ``harm``), as is usual in DPD.
        minimum_distance: least distance of beads, one number or by species with ``"*"`` for the others. Beads that are
            bonded to each other, and beads of one rigid or laid out molecule, may be closer.
        neutralise: ions to balance the charge of everything else with; the first of the right sign is taken.
        run: CONTROL's settings by keyword, in addition to nvt with ``mdvv``, k_B T = 1, a timestep of 0.01 and 2000
            steps (values other than the method only with units dpd).
        units: FIELD's energy unit.
        title: for all files.
        seed: of all places, and the first of the three numbers of CONTROL's ``random_seed``.

    Raises:
        InputError: a setting of ``run`` or a unit cannot be read.
        SceneError: the description contradicts itself, leaves something undefined, or there is no room; the text says
            which molecule, and how close the last try came.
    """
    table = _species_table(species)
    if seed < 0:
        raise SceneError(f"a seed must not be negative, not {seed}", word="seed")
    return _Builder(
        cell=_cell(box),
        species=table,
        laws={"bonds": bonds or {}, "angles": angles or {}},
        density=density,
        length=length,
        rng=np.random.default_rng(seed),
        exclude=exclude_bonded,
    ).build(molecules, pairs, neutralise, minimum_distance, _Header(title, units, mixing, seed, dict(run or {})))


@dataclass(frozen=True)
class _Header:
    title: str
    units: str
    mixing: str | None
    seed: int
    run: Mapping[str, Any]


@dataclass
class _Builder:
    cell: FloatArray
    species: Mapping[str, Species]
    laws: Mapping[Kind, Laws]
    density: float | None
    length: float | None
    rng: np.random.Generator
    exclude: bool

    def __post_init__(self) -> None:
        self.volume = Everywhere().volume(self.cell)
        if self.density is not None and not self.density > 0.0:
            raise SceneError(f"the density must lie above 0, not at {self.density:g}", word="density")
        self.total = None if self.density is None else round(self.density * self.volume)

    def build(
        self,
        parts: Sequence[Part],
        pairs: Mapping[Any, Any],
        neutralise: Sequence[MoleculeType | str],
        minimum_distance: float | Mapping[Any, float],
        header: _Header,
    ) -> Built:
        entries = self._entries(parts, neutralise)
        names = tuple(dict.fromkeys(name for entry in entries for name in entry.molecule.beads))
        for entry in entries:
            for name in entry.molecule.beads:
                species_named(name, self.species, entry.molecule.name)
        mixing = header.mixing is not None or "vdw_mix_method" in header.run
        vdw, cutoff = pair_records(pairs, names, self.species, mixing=mixing)
        least = least_distances(minimum_distance, names, self.species)
        # Rounding moves beads a little towards each other.
        margin = 2.0 * 10.0 ** -self._decimals()
        Arranger(self.cell, names, self.laws, self.density, self.rng).place(
            entries, np.where(least > 0.0, least + margin, 0.0)
        )
        return self._records(entries, vdw, cutoff, header)

    # -- How many -----------------------------------------------------------------------------------------------------

    def _entries(self, parts: Sequence[Part], neutralise: Sequence[MoleculeType | str]) -> list[Entry]:
        if not parts:
            raise SceneError("there are no molecules", path="molecules")
        entries: list[Entry] = []
        rest: Entry | None = None
        for part in parts:
            for component in self._expanded(part):
                entry = self._entry(component)
                if entry.count < 0:
                    if rest is not None:
                        message = f"both {rest.molecule.name} and {entry.molecule.name} fill what is left of the cell"
                        raise SceneError(message, path="molecules")
                    rest = entry
                entries.append(entry)
        if neutralise:
            if rest is not None and charge_of(rest.molecule, self.species):
                raise SceneError("what fills the cell is charged; give its count", word=rest.molecule.name)
            charge = sum(e.count * charge_of(e.molecule, self.species) for e in entries if e is not rest)
            ions = counter_ions(charge, neutralise, self.species)
            if ions is not None:
                entries.append(self._entry(ions))
        if rest is not None:
            self._fill(rest, entries)
        self._check_names(entries)
        return entries

    def _expanded(self, part: Part) -> Sequence[Component | Bilayer | Lamella]:
        if isinstance(part, Salt):
            return ions_of(part, self.species, self.volume, self.length)
        if isinstance(part, (MoleculeType, str)):
            return (Component(part, fill=True),)
        return (part,)

    def _entry(self, how: Component | Bilayer | Lamella) -> Entry:
        """Return the entry with its count, -1 for what fills the cell."""
        molecule = as_molecule(how.molecule)
        if isinstance(how, Bilayer):
            return Entry(molecule, 2 * how.leaflet(self.cell), how)
        if isinstance(how, Lamella):
            return Entry(
                molecule, 2 * how.periods * how.per_layer(self.cell, needed_density(self.density, molecule)), how
            )
        volume = self.volume if how.region is None else how.region.volume(self.cell)
        count = count_of(how, self.total, self.density, volume, self.length)
        return Entry(molecule, -1 if count is None else count, how)

    def _fill(self, rest: Entry, entries: Sequence[Entry]) -> None:
        beads = sum(entry.count * len(entry.molecule.beads) for entry in entries if entry is not rest)
        left = (self.total or 0) - beads
        if left < 0:
            message = f"nothing is left to fill: the cell has {self.total} beads at density {self.density:g}, and "
            raise SceneError(f"{message}{beads} are taken", word=rest.molecule.name)
        rest.count = left // len(rest.molecule.beads)

    def _decimals(self) -> int:
        whole = len(str(int(np.abs(self.cell).sum(axis=0).max())))
        return max(0, min(_DECIMALS, _DIGITS - whole))

    def _check_names(self, entries: Sequence[Entry]) -> None:
        known: dict[str, MoleculeType] = {}
        for entry in entries:
            if known.setdefault(entry.molecule.name, entry.molecule) != entry.molecule:
                raise SceneError("two unlike molecules have this name", path="molecules", word=entry.molecule.name)

    # -- Records ------------------------------------------------------------------------------------------------------

    def _records(self, entries: Sequence[Entry], vdw: Any, cutoff: float, header: _Header) -> Built:
        grouped: dict[str, list[Entry]] = {}
        for entry in entries:
            grouped.setdefault(entry.molecule.name, []).append(entry)
        molecules, names, places = [], [], []
        for group in grouped.values():
            count = sum(entry.count for entry in group)
            molecules.append(molecule_record(group[0].molecule, count, self.species, self.laws, exclude=self.exclude))
            names += list(group[0].molecule.beads) * count
            places += [entry.places.reshape(-1, 3) for entry in group]
        positions = np.concatenate(places)
        if not len(positions):
            raise SceneError("there are no beads: every count is 0", path="molecules")
        charge = sum(m.count * sum(a.charge * a.repeat for a in m.atoms) for m in molecules)
        warnings: tuple[str, ...] = ()
        if abs(charge) > _NEUTRAL:
            warnings = (f"the charges add up to {charge:+g}; neutralise names ions to balance them",)
        units = energy_unit(header.units, path="units")
        return Built(
            control=_control(header, cutoff, reduced=units.reduced),
            field=Field(header.title, units.name, tuple(molecules), vdw, warnings=warnings),
            config=Configuration(
                names=tuple(names),
                positions=_inside(positions, self.cell).round(self._decimals()),
                title=header.title,
                imcon=_imcon(self.cell),
                cell=self.cell,
            ),
            counts={molecule.name: molecule.count for molecule in molecules},
            density=len(positions) / self.volume,
            charge=charge,
            warnings=warnings,
        )


def _species_table(species: Iterable[Species | str]) -> dict[str, Species]:
    table: dict[str, Species] = {}
    for given in species:
        kind = Species(given) if isinstance(given, str) else given
        if not 1 <= len(kind.name) <= WORD_LIMIT or kind.name.split() != [kind.name] or kind.name == "*":
            message = f"a species name has 1 to {WORD_LIMIT} characters and no blanks, and is not *"
            raise SceneError(message, path="species", word=kind.name)
        if kind.name in table:
            raise SceneError("this species is given twice", path="species", word=kind.name)
        table[kind.name] = kind
    return table


def _cell(box: Any) -> FloatArray:
    try:
        given = np.array(box, dtype=np.float64)
    except (TypeError, ValueError):
        given = np.zeros(0)
    if given.shape in ((), (3,)):
        given = np.diag(np.broadcast_to(given, 3))
    if given.shape != (3, 3) or not np.isfinite(given).all():
        raise SceneError("expected an edge, three edges or three cell vectors", path="box", word=str(box))
    cell = np.round(given, _DIGITS)
    if not abs(np.linalg.det(cell)) > 1e-12 * float(np.prod(np.linalg.norm(cell, axis=1))):
        raise SceneError("the cell has no volume", path="box", word=str(box))
    if _imcon(cell) < 3 and not np.all(np.diag(cell) > 0.0):
        raise SceneError("the edges must lie above 0", path="box", word=str(box))
    return cell


def _imcon(cell: FloatArray) -> int:
    edges = np.diag(cell)
    if np.any(cell != np.diag(edges)):
        return 3
    return 1 if edges[0] == edges[1] == edges[2] else 2


def _inside(positions: FloatArray, cell: FloatArray) -> FloatArray:
    fractions = positions @ np.linalg.inv(cell)
    wrapped: FloatArray = (fractions - np.floor(fractions + 0.5)) @ cell
    return wrapped


def _control(header: _Header, cutoff: float, *, reduced: bool) -> Control:
    settings: dict[str, Any] = {"title": header.title, **_RUN, **_LENGTH, **(_REDUCED if reduced else {})}
    settings["random_seed"] = (header.seed, 0, 0)
    if cutoff > 0.0:
        settings["cutoff"] = f"{cutoff!r} {'dpd_l' if reduced else 'ang'}"
    if header.mixing is not None:
        settings["vdw_mix_method"] = header.mixing
    if "ensemble" in header.run or "ensemble_method" in header.run:
        # The thermostat is not the usual one: only what is said counts.
        for keyword in ("ensemble_method", "ensemble_dpd_order"):
            del settings[keyword]
    settings.update({keyword.lower(): value for keyword, value in header.run.items()})
    settings = {keyword: value for keyword, value in settings.items() if value is not None}
    return replace(control_from_mapping(settings, path="run"), path="CONTROL")
