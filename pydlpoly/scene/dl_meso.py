"""What DL_MESO's files mean in pydlpoly's settings: its mixing rule, the range of its drags, its start without CONFIG.

DL_MESO's rules are those of its reader and of its pair loop, as in the port of its serial version at
https://github.com/stfc/RegentParticleDSL (src/io_modules/dl_meso, src/interactions/dl_meso).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from pydlpoly.build.placement import place_random, place_rigid
from pydlpoly.errors import SceneError
from pydlpoly.formats.control import value_in
from pydlpoly.formats.records import (
    Configuration,
    Control,
    Field,
    FloatArray,
    MesoControl,
    Molecule,
    PairLine,
    Remark,
    Setting,
    SettingValue,
)
from pydlpoly.scene.cell import wrap
from pydlpoly.scene.dynamics import combine_seed
from pydlpoly.units import BOLTZMANN

_RULE = "lorentz-berthelot"
# Without a seed the noise differs from run to run, but the same files always have the same start.
_SEED = 0
_WCA_END: float = 2.0 ** (1.0 / 6.0)  # times sigma
_CHOSEN_PAIRS = ("lowe-andersen", "stoyanov-groot")


def adapt(control: Control, field: Field) -> tuple[Control, Field]:
    """Return the records with DL_MESO's rules written out as settings; records without its dialect as they are.

    Raises:
        SceneError: the two files do not go together, or a rule of DL_MESO's cannot be followed.
    """
    if control.meso is None and field.meso is None:
        return control, field
    if field.units != "dpd":
        message = f"this CONTROL is in DL_MESO's dialect, whose numbers are reduced, but FIELD has units {field.units}"
        raise SceneError(message, path=control.path)
    _check_energy_unit(control, field)
    control = _with_mixing(control, field)
    if control.meso is not None:
        control, field = _with_ranges(control, control.meso, field)
        control = _with_rate(control, field)
        control = _with_scaling_noted(control)
    return control, field


def _with(control: Control, text: str, *settings: tuple[str, SettingValue, str | None, int]) -> Control:
    """Return CONTROL with further settings, each (keyword, value, unit, line), and the choice that made them."""
    line = settings[0][3] if settings else 0
    made = tuple(Setting(*setting) for setting in settings)
    kept = tuple(one for one in control.settings if one.keyword not in {new.keyword for new in made})
    remarks = (*control.remarks, Remark("choice", text, line))
    return replace(control, settings=(*kept, *made), remarks=remarks)


def _check_energy_unit(control: Control, field: Field) -> None:
    if field.meso is None or not field.meso.thermal:
        return
    thermal = BOLTZMANN * float(value_in(control, "temperature"))  # type: ignore[arg-type]  # a float keyword
    if abs(thermal - 1.0) > 1e-12:
        message = f"energies in k_B T can be taken only at temperature 1, not at {thermal:g}; write them as numbers"
        raise SceneError(message, path=field.path, line=field.meso.units_line, word="units")


# -- pairs ------------------------------------------------------------------------------------------------------------


def _with_mixing(control: Control, field: Field) -> Control:
    """Choose DL_MESO's rule for unlike pairs that FIELD does not give."""
    if control.get("vdw_mix_method") is not None:
        return control
    laws = {tuple(sorted(line.species)): line for line in field.pairs}
    mixed = []
    for first, second in _unlike(field):
        if tuple(sorted((first, second))) in laws:
            continue
        like = [laws.get((name, name)) for name in (first, second)]
        if any(line is None for line in like):
            missing = next(name for name, line in zip((first, second), like, strict=True) if line is None)
            message = f"the pair {first} {second} is not given and cannot be mixed: there is no interaction {missing} "
            raise SceneError(f"{message}{missing}", path=field.path)
        if len({line.key for line in like if line}) > 1:
            message = f"the pair {first} {second} is not given, and the laws of its like pairs differ; give it a line"
            raise SceneError(message, path=field.path)
        mixed.append(f"{first}-{second}")
    if not mixed:
        return control
    text = f"{', '.join(mixed)}: mixed by DL_MESO's rule, geometric means of energies and drags, arithmetic of lengths"
    return _with(control, text, ("vdw_mix_method", _RULE, None, 0))


def _unlike(field: Field) -> Iterator[tuple[str, str]]:
    """Give the pairs of different species that both have beads."""
    names = list(dict.fromkeys(atom.name for molecule in field.molecules if molecule.count for atom in molecule.atoms))
    for number, first in enumerate(names):
        for second in names[number + 1 :]:
            yield first, second


def _with_ranges(control: Control, meso: MesoControl, field: Field) -> tuple[Control, Field]:
    """Give all drags the one range they have in DL_MESO: the thermostat cutoff, or else the cutoff."""
    longest = max((line.parameters[1] for line in field.pairs if len(line.parameters) > 1), default=0.0)
    cutoff = meso.cutoff
    if cutoff is None:
        if not longest > 0.0:
            raise SceneError("neither CONTROL nor FIELD gives a cutoff", path=control.path, word="cutoff")
        cutoff = longest
        text = f"no cutoff is given: {cutoff:g}, the longest range in FIELD, as in DL_MESO"
        control = _with(control, text, ("cutoff", cutoff, "dpd_l", 0))
    drag_range, whole = meso.drag_cutoff or cutoff, cutoff
    line = next((setting.line for setting in control if setting.keyword == "cutoff"), 0)
    if meso.charge_cutoff is not None and control.get("coul_method") is not None:
        whole = max(cutoff, meso.charge_cutoff)
        text = (
            f"electrostatic cutoff {meso.charge_cutoff:g} is the global cutoff; laws without a range end at {cutoff:g}"
        )
        control = _with(control, text, ("cutoff", whole, "dpd_l", line), ("vdw_cutoff", cutoff, "dpd_l", line))
    ends = {_end(line, cutoff) for line in field.pairs}
    if ends == {drag_range}:
        return control, field
    text = f"all drags end at {drag_range:g}, wherever the laws end, as in DL_MESO"
    if drag_range == whole:
        return _with(control, text, ("ensemble_dpd_cutoff", "global", None, line)), field
    if control.get("vdw_mix_method") is not None:
        message = f"drags that end at {drag_range:g} cannot be given to pairs that are mixed; give every pair a line"
        raise SceneError(message, path=control.path)
    pairs = tuple(replace(line, parameters=(*line.parameters, drag_range)) for line in field.pairs)
    return _with(control, text), replace(field, pairs=pairs)


def _end(line: PairLine, cutoff: float) -> float:
    """Return where a law ends, and with it its drag unless another range is given."""
    lengths = {"dpd": 1.0, "wca": _WCA_END}
    return lengths[line.key] * line.parameters[1] if line.key in lengths else cutoff


def _with_rate(control: Control, field: Field) -> Control:
    """Lowe's and Stoyanov's thermostats: FIELD's third number is the rate itself, whatever the masses are."""
    order = control.get("ensemble_dpd_order")
    if order is None or order.value not in _CHOSEN_PAIRS:
        return control
    if all(atom.mass == 1.0 for molecule in field.molecules if molecule.count for atom in molecule.atoms):
        return control
    rates = {_drag(line) for line in field.pairs}
    if len(rates) != 1:
        message = f"{order.value} with masses other than 1 can be modelled only with one rate for all pairs, and FIELD "
        raise SceneError(f"{message}has several", path=control.path, line=order.line or None, word="ensemble")
    rate = rates.pop()
    text = f"all pairs are chosen at the rate {rate:g}, FIELD's third number, whatever their masses, as in DL_MESO"
    return _with(control, text, ("ensemble_dpd_rate", rate, "dpd_t^-1", order.line))


def _drag(line: PairLine) -> float:
    return line.parameters[3 if line.key == "wca" else 2]


def _with_scaling_noted(control: Control) -> Control:
    scaling, equilibration = control.get("rescale_frequency"), control.get("time_equilibration")
    if scaling is None or not scaling.value or equilibration is None or not equilibration.value:
        return control
    text = "scale temperature acts during the equilibration only, as in DL_MESO; after it the thermostat is left alone"
    return replace(control, remarks=(*control.remarks, Remark("choice", text, scaling.line)))


# -- configurations ---------------------------------------------------------------------------------------------------


def start_configuration(control: Control, field: Field) -> Configuration:
    """Return the start that DL_MESO would have without CONFIG: molecules turned at random, everything placed uniformly.

    DL_MESO itself puts beads outside molecules on a lattice; a soft fluid forgets either within some time units.

    Raises:
        SceneError: CONTROL gives no box, or a molecule has no places for its beads.
    """
    meso = control.meso
    if meso is None or meso.edges is None:
        message = "there is no CONFIG, and no volume in a CONTROL of DL_MESO's dialect to place the beads in"
        raise SceneError(message, path=control.path, word="volume")
    seed = control.get("random_seed")
    number = combine_seed(tuple(int(x) for x in seed.value)) if seed and isinstance(seed.value, tuple) else _SEED
    rng = np.random.Generator(np.random.PCG64(number))
    cell = np.diag(meso.edges)
    parts, names, words = [], [], []
    for k, molecule in enumerate(field.molecules):
        template = _template(field, k, molecule)
        mirrored = field.meso.mirrored[k] if field.meso is not None else False
        centres = place_random(molecule.count, cell, rng)
        parts.append(place_rigid(template, centres, rng, mirrored=mirrored) if len(template) > 1 else centres)
        names += [atom.name for atom in molecule.atoms for _ in range(atom.repeat)] * molecule.count
        if molecule.count:
            turned = f"turned{' or mirrored' if mirrored else ''} and " if len(template) > 1 else ""
            words.append(f"{molecule.count} {molecule.name or '(no name)'} {turned}placed at random")
    density = len(names) / float(np.prod(meso.edges))
    origin = f"seed {int(seed.value[0])}" if seed and isinstance(seed.value, tuple) else "a fixed seed"
    text = f"no CONFIG: {', '.join(words)}, from {origin}; {density:g} beads per unit volume"
    return Configuration(
        names=tuple(names),
        positions=wrap(np.concatenate([np.zeros((0, 3)), *parts]), cell, (True, True, True)),
        title=control.title,
        imcon=_imcon(meso.edges),
        cell=cell,
        path=control.path,
        remarks=(Remark("choice", text, meso.volume_line),),
    )


def _template(field: Field, number: int, molecule: Molecule) -> FloatArray:
    if molecule.beads_per_molecule == 1:
        return np.zeros((1, 3))
    if field.meso is None:
        message = f"there is no CONFIG, and molecule {molecule.name} has no places for its beads in this FIELD"
        raise SceneError(message, path=field.path, line=molecule.line or None)
    return np.array(field.meso.coordinates[number])


def _imcon(edges: tuple[float, float, float]) -> int:
    return 1 if len(set(edges)) == 1 else 2


def adapt_configuration(control: Control, field: Field, config: Configuration) -> tuple[Control, Configuration]:
    """Return the records with CONFIG as DL_MESO would read it; without its dialect as they are.

    Boxes are orthorhombic whatever ``imcon`` says, beads outside molecules come in any order, velocities are used when
    the file has them, and coordinates count from the box's corner where CONTROL says so.

    Raises:
        SceneError: a cell that is not orthorhombic.
    """
    if control.meso is None and field.meso is None:
        return control, config
    config = _with_box(control, config)
    if control.meso is not None and control.meso.corner_origin:
        config = replace(config, positions=config.positions - 0.5 * np.diag(config.cell))
    config = _in_field_order(field, config)
    if control.meso is not None and config.velocities is not None and control.get("restart") is None:
        text = f"the velocities of {config.path} are used as they are, as in DL_MESO"
        control = _with(control, text, ("restart", "noscale", None, 0))
    return control, config


def _with_box(control: Control, config: Configuration) -> Configuration:
    edges = None if control.meso is None else control.meso.edges
    if np.any(config.cell[~np.eye(3, dtype=bool)] != 0.0):
        raise SceneError("boxes of DL_MESO are orthorhombic, and this cell is not", path=config.path)
    if config.imcon == 0:
        if edges is None:
            return config
        text = "imcon 0: the box is that of CONTROL's volume"
        remark = Remark("choice", text)
        return replace(config, imcon=_imcon(edges), cell=np.diag(edges), remarks=(*config.remarks, remark))
    found = (float(config.cell[0, 0]), float(config.cell[1, 1]), float(config.cell[2, 2]))
    remarks = config.remarks
    if edges is not None and not np.allclose(edges, found, rtol=1e-6):
        text = f"CONFIG's box {found[0]:g} x {found[1]:g} x {found[2]:g} is used, not CONTROL's volume"
        remarks = (*remarks, Remark("warning", text, 3))
    imcon = config.imcon
    if imcon in (1, 3) and imcon != _imcon(found):
        remarks = (
            *remarks,
            Remark("choice", f"imcon {imcon} with unequal edges: an orthorhombic box, as in DL_MESO", 2),
        )
        imcon = _imcon(found)
    return replace(config, imcon=imcon, remarks=remarks)


def _in_field_order(field: Field, config: Configuration) -> Configuration:
    """Sort the beads outside molecules, the first in the file, by species; each keeps its place among its like."""
    loose = 0 if field.meso is None else field.meso.loose
    expected = [molecule.atoms[0].name for molecule in field.molecules for _ in range(molecule.count)][:loose]
    found = list(config.names[:loose])
    if found == expected or sorted(found) != sorted(expected):
        return config
    rank = {name: k for k, name in enumerate(dict.fromkeys(expected))}
    order = np.argsort(np.array([rank[name] for name in found]), kind="stable")
    order = np.concatenate([order, np.arange(loose, len(config.names))])
    text = (
        f"the {loose} beads outside molecules are numbered anew, species after species; their order is free in DL_MESO"
    )
    return replace(
        config,
        names=tuple(config.names[k] for k in order),
        positions=config.positions[order],
        velocities=None if config.velocities is None else config.velocities[order],
        forces=None if config.forces is None else config.forces[order],
        remarks=(*config.remarks, Remark("choice", text)),
    )
