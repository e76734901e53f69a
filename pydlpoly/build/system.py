"""``build``: from a description in Python objects to records, and from them to files, a scene or ``Atoms``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
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
from pydlpoly.build.assembly import Bilayer, Lamella
from pydlpoly.build.crowd import Crowd
from pydlpoly.build.molecules import MoleculeType, Species, circle
from pydlpoly.build.packing import Job, Packer
from pydlpoly.build.regions import Everywhere, Outside, Region
from pydlpoly.build.topology import (
    Kind,
    Laws,
    bond_lengths,
    built_length,
    law_of,
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
_TURN_OF_STIFF = 60.0
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
    warnings: tuple[str, ...] = field(default=())

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
        atoms.set_array("molecules", np.array(scene.beads.molecule))
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
        seed: of all places.

    Raises:
        InputError: a setting of ``run`` or a unit cannot be read.
        SceneError: the description contradicts itself, leaves something undefined, or there is no room; the text says
            which molecule, and how close the last try came.
    """
    table = _species_table(species)
    return _Builder(
        cell=_cell(box),
        species=table,
        laws={"bonds": bonds or {}, "angles": angles or {}},
        density=density,
        length=length,
        rng=np.random.default_rng(seed),
        exclude=exclude_bonded,
    ).build(molecules, pairs, neutralise, minimum_distance, _Header(title, units, mixing, dict(run or {})))


@dataclass(frozen=True)
class _Header:
    title: str
    units: str
    mixing: str | None
    run: Mapping[str, Any]


@dataclass
class _Entry:
    """A kind of molecules with their number, and how they are placed."""

    molecule: MoleculeType
    count: int
    how: Component | Bilayer | Lamella
    places: FloatArray = field(default_factory=lambda: np.zeros((0, 0, 3)))


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
        vdw, cutoff = pair_records(pairs, names, mixing=mixing)
        self._place(entries, names, least_distances(minimum_distance, names))
        return self._records(entries, vdw, cutoff, header)

    # -- How many -----------------------------------------------------------------------------------------------------

    def _entries(self, parts: Sequence[Part], neutralise: Sequence[MoleculeType | str]) -> list[_Entry]:
        if not parts:
            raise SceneError("there are no molecules", path="molecules")
        entries: list[_Entry] = []
        rest: _Entry | None = None
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

    def _entry(self, how: Component | Bilayer | Lamella) -> _Entry:
        """Return the entry with its count, -1 for what fills the cell."""
        molecule = as_molecule(how.molecule)
        if isinstance(how, Bilayer):
            return _Entry(molecule, 2 * how.leaflet(self.cell), how)
        if isinstance(how, Lamella):
            return _Entry(molecule, 2 * how.periods * how.per_layer(self.cell, self._dense(molecule)), how)
        volume = self.volume if how.region is None else how.region.volume(self.cell)
        count = count_of(how, self.total, self.density, volume, self.length)
        return _Entry(molecule, -1 if count is None else count, how)

    def _dense(self, molecule: MoleculeType) -> float:
        if self.density is None:
            raise SceneError("a layer needs the number density", word=molecule.name)
        return self.density

    def _fill(self, rest: _Entry, entries: Sequence[_Entry]) -> None:
        beads = sum(entry.count * len(entry.molecule.beads) for entry in entries if entry is not rest)
        left = (self.total or 0) - beads
        if left < 0:
            message = f"nothing is left to fill: the cell has {self.total} beads at density {self.density:g}, and "
            raise SceneError(f"{message}{beads} are taken", word=rest.molecule.name)
        rest.count = left // len(rest.molecule.beads)

    def _check_names(self, entries: Sequence[_Entry]) -> None:
        known: dict[str, MoleculeType] = {}
        for entry in entries:
            if known.setdefault(entry.molecule.name, entry.molecule) != entry.molecule:
                raise SceneError("two unlike molecules have this name", path="molecules", word=entry.molecule.name)

    # -- Where --------------------------------------------------------------------------------------------------------

    def _place(self, entries: Sequence[_Entry], names: tuple[str, ...], least: FloatArray) -> None:
        """Give every entry its places: what is laid out, then what has a region or a number, then what fills."""
        # Rounding moves beads a little towards each other.
        margin = 2.0 * 10.0 ** -self._decimals()
        crowd = Crowd(self.cell, np.where(least > 0.0, least + margin, 0.0))
        packer = Packer(crowd, names, self.rng)
        numbers = {name: k for k, name in enumerate(names)}
        taken: list[Region] = []
        for entry in entries:
            if not isinstance(entry.how, Component):
                taken += self._lay_out(entry, crowd, numbers, names)
            elif entry.how.fill and entry.how.region is not None:
                taken.append(entry.how.region)
        drawn = [entry for entry in entries if isinstance(entry.how, Component)]
        drawn.sort(key=lambda entry: isinstance(entry.how, Component) and entry.how.fill and entry.how.region is None)
        for entry in drawn:
            entry.places = packer.place(self._job(entry, numbers, taken, least, names))

    def _lay_out(self, entry: _Entry, crowd: Crowd, numbers: Mapping[str, int], names: tuple[str, ...]) -> list[Region]:
        """Place the molecules of layers; return the region that they keep for themselves."""
        lengths = bond_lengths(entry.molecule, self.laws["bonds"], self._spacing())
        regions: list[Region] = []
        if isinstance(entry.how, Bilayer):
            longest = float(lengths[1:].min(initial=self._spacing()))
            pitch = entry.how.pitch(self.cell, self._dense(entry.molecule), longest)
            regions.append(entry.how.region(self.cell, pitch))
            entry.places = entry.how.place(self.cell, pitch, lengths, self.rng)
        elif isinstance(entry.how, Lamella):
            entry.places = entry.how.place(self.cell, self._dense(entry.molecule), lengths, self.rng)
        kinds = np.tile(np.array([numbers[name] for name in entry.molecule.beads], dtype=np.int64), entry.count)
        beads = entry.places.reshape(-1, 3)
        rows, others, ratios = crowd.conflicts(beads, kinds)
        self._check_layer(entry, rows, others, ratios, crowd, kinds, names)
        first = crowd.add(beads, kinds)[0] if crowd.matters else 0
        rows, others, ratios = crowd.conflicts(beads, kinds)
        size = len(entry.molecule.beads)
        apart = rows // size != (others - first) // size
        self._check_layer(entry, rows[apart], others[apart], ratios[apart], crowd, kinds, names)
        return regions

    def _check_layer(
        self, entry: _Entry, rows: Any, others: Any, ratios: FloatArray, crowd: Crowd, kinds: Any, names: Sequence[str]
    ) -> None:
        if not len(ratios):
            return
        worst = int(ratios.argmin())
        first, second = int(kinds[rows[worst]]), int(crowd.kinds(others[worst : worst + 1])[0])
        least = float(crowd.least[first, second])
        message = (
            f"in this layer beads {names[first]} and {names[second]} come as close as {ratios[worst] * least:.3g}, "
        )
        raise SceneError(f"{message}and the least distance asked for is {least:.5g}", word=entry.molecule.name)

    def _job(
        self, entry: _Entry, numbers: Mapping[str, int], taken: Sequence[Region], least: FloatArray, names: Any
    ) -> Job:
        how, molecule = entry.how, entry.molecule
        assert isinstance(how, Component)
        kinds = np.array([numbers[name] for name in molecule.beads], dtype=np.int64)
        region = how.region
        if region is None:
            region = Outside(tuple(taken)) if how.fill and taken else Everywhere()
        molecule = self._shaped(how, molecule)
        if molecule.places is None or how.shape == "rigid":
            lengths = (
                np.zeros(0)
                if entry.molecule.closed or entry.molecule.places is not None
                else (bond_lengths(entry.molecule, self.laws["bonds"], self._spacing()))
            )
        else:
            lengths = np.zeros(0)
        job = Job(molecule, entry.count, kinds, lengths, region, self._turn(how, molecule))
        if how.shape == "rigid" and molecule.places is None:
            walk = Packer(Crowd(self.cell, least), names, self.rng).place(replace(job, count=1, region=Everywhere()))[0]
            job = replace(job, molecule=replace(molecule, places=tuple((x, y, z) for x, y, z in walk.tolist())))
        return job

    def _shaped(self, how: Component, molecule: MoleculeType) -> MoleculeType:
        """Return the molecule with the places of a circle when it is a ring."""
        if how.shape not in (None, "grown", "rigid"):
            raise SceneError("a shape is grown or rigid", path=molecule.name, word=str(how.shape))
        if molecule.places is not None or molecule.closed:
            if how.shape == "grown":
                message = "rings and molecules with places of their own cannot be grown; they are rigid"
                raise SceneError(message, word=molecule.name)
            if molecule.places is None:
                laws, spacing = self.laws["bonds"], self._spacing()
                ends = [tuple(molecule.beads[k] for k in bond) for bond in molecule.bonds]
                lengths = {built_length(pair, laws, molecule.name, spacing) for pair in ends}
                if len(lengths) > 1:
                    raise SceneError("a ring of bonds of unlike lengths needs places", word=molecule.name)
                return replace(molecule, places=circle(len(molecule.beads), lengths.pop()))
        return molecule

    def _turn(self, how: Component, molecule: MoleculeType) -> float:
        turn = how.turn
        if turn is None:
            threes = {tuple(molecule.beads[k] for k in beads) for beads in molecule.angles}
            stiff = any(law_of("angles", three, self.laws["angles"], molecule.name) for three in threes)
            turn = _TURN_OF_STIFF if stiff else 180.0
        if not 0.0 <= turn <= 180.0:
            raise SceneError(f"a turn lies between 0 and 180 degrees, not at {turn:g}", word=molecule.name)
        return float(np.deg2rad(turn))

    def _spacing(self) -> float:
        """Return the mean distance of beads, the length of bonds without one of their own."""
        return float((1.0 / (self.density or 3.0)) ** (1.0 / 3.0))

    def _decimals(self) -> int:
        whole = len(str(int(np.abs(self.cell).sum(axis=0).max())))
        return max(0, min(_DECIMALS, _DIGITS - whole))

    # -- Records ------------------------------------------------------------------------------------------------------

    def _records(self, entries: Sequence[_Entry], vdw: Any, cutoff: float, header: _Header) -> Built:
        grouped: dict[str, list[_Entry]] = {}
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
        warnings = ()
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
