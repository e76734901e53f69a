"""What beads carry beside position and velocity: internal temperature and concentrations of dissolved species.

The scene holds temperatures as k_B T in internal units. Files, arrays and callbacks have them in K (reduced with
``units dpd``), under the names given here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pydlpoly.errors import SceneError, suggest
from pydlpoly.formats.records import BeadTable, Field, FloatArray
from pydlpoly.scene.model import Note, Scene
from pydlpoly.scene.settings import place

TEMPERATURE = "temperature"
CONCENTRATION = "concentration_"
DENSITY = "density"
STATE_EXTENSIONS = ("heat", "transport")
"""FIELD's extensions that give beads a state of their own."""


def dissolved_species(scene: Scene) -> tuple[str, ...]:
    """Return the names of the dissolved species, in the order of the columns of ``Beads.concentrations``."""
    concentrations = scene.beads.concentrations
    if concentrations is None:
        return ()
    names = _names_of_species(scene)
    return names or tuple(str(k + 1) for k in range(concentrations.shape[1]))


def _names_of_species(scene: Scene) -> tuple[str, ...]:
    """Names that FIELD gives; none in scenes whose concentrations were put in by hand."""
    transport = getattr(scene, "transport", None)
    return () if transport is None else tuple(transport.species)


def carried_names(scene: Scene) -> tuple[str, ...]:
    """Return the names of what beads carry: "temperature", then "concentration_" and the name of each species."""
    heat = () if scene.beads.temperature is None else (TEMPERATURE,)
    return (*heat, *(CONCENTRATION + name for name in dissolved_species(scene)))


def has_local_density(scene: Scene) -> bool:
    """Return whether the pair forces depend on a local density."""
    return getattr(scene, "many_body", None) is not None


def carried_arrays(
    scene: Scene, thermal_energies: FloatArray | None, concentrations: FloatArray | None
) -> dict[str, FloatArray]:
    """Return arrays by the names of ``carried_names``.

    Args:
        scene: whose beads.
        thermal_energies: (N,) as k_B T, internal units; concentrations: (N, species). None where there are none.
    """
    arrays: dict[str, FloatArray] = {}
    if thermal_energies is not None:
        arrays[TEMPERATURE] = np.asarray(thermal_energies, dtype=np.float64) / scene.units.boltzmann
    if concentrations is not None:
        for name, column in zip(dissolved_species(scene), np.asarray(concentrations).T, strict=True):
            arrays[CONCENTRATION + name] = np.ascontiguousarray(column)
    return arrays


def start_arrays(scene: Scene) -> dict[str, FloatArray]:
    """Return what the beads carry at the scene's start, (N,) each, by name."""
    return carried_arrays(scene, scene.beads.temperature, scene.beads.concentrations)


def why_not(name: str, values: FloatArray) -> tuple[int, str] | None:
    """Return the first bead whose value is impossible and what is expected, None when all are possible."""
    if name == TEMPERATURE:
        wrong, told = ~(np.isfinite(values) & (values > 0.0)), "expected a finite temperature above 0"
    else:
        wrong, told = ~(np.isfinite(values) & (values >= 0.0)), "expected a finite concentration, not below 0"
    found = np.flatnonzero(wrong)
    return (int(found[0]), told) if len(found) else None


def with_bead_table(scene: Scene, table: BeadTable | None) -> Scene:
    """Return the scene whose beads start from a table; columns that it lacks keep their values.

    Raises:
        SceneError: another number of beads, a column of something that the beads do not carry, or an impossible value.
    """
    if table is None:
        return scene
    known = carried_names(scene)
    where = place(table.path, None)
    if not known:
        text = f"{where} is not used: beads carry neither internal temperatures nor dissolved species"
        return replace(scene, notes=(*scene.notes, Note("ignored", text, where)))
    head = 2 if table.first_line else None
    if len(table.values) != scene.bead_count:
        message = f"holds {len(table.values)} beads, but the scene has {scene.bead_count}"
        raise SceneError(message, path=table.path, line=head)
    for name, column in zip(table.names, table.values.T, strict=True):
        if name not in known:
            message = f"beads do not carry this; expected {', '.join(known)}{suggest(name, known)}"
            raise SceneError(message, path=table.path, line=head, word=name)
        wrong = why_not(name, column)
        if wrong is not None:
            bead, told = wrong
            number, line = table.place_of(bead)
            raise SceneError(f"{name} of bead {number}: {told}", path=table.path, line=line, word=f"{column[bead]:g}")
    given = dict(zip(table.names, table.values.T, strict=True))
    text = f"{', '.join(table.names)} of the beads: from {where}"
    missing = [name for name in known if name not in given]
    if missing:
        text += f"; {', '.join(missing)}: it has no such column, the values of FIELD's extension are kept"
    return replace(_with_values(scene, given), notes=(*scene.notes, Note("choice", text, where)))


def _with_values(scene: Scene, given: Mapping[str, FloatArray]) -> Scene:
    beads = scene.beads
    if TEMPERATURE in given:
        energies = np.asarray(given[TEMPERATURE] * scene.units.boltzmann, dtype=np.float64)
        energies.setflags(write=False)
        beads = replace(beads, temperature=energies)
    if beads.concentrations is not None:
        concentrations = beads.concentrations.copy()
        for k, name in enumerate(dissolved_species(scene)):
            if CONCENTRATION + name in given:
                concentrations[:, k] = given[CONCENTRATION + name]
        concentrations.setflags(write=False)
        beads = replace(beads, concentrations=concentrations)
    return replace(scene, beads=beads)


def repeated_table(table: BeadTable | None, before: Field, after: Field) -> BeadTable | None:
    """Return the table of a configuration that ``nfold`` has repeated: copies of a molecule type stay together.

    Raises:
        SceneError: the table has another number of beads than the configuration before.
    """
    if table is None or before.bead_count == after.bead_count:
        return table
    if len(table.values) != before.bead_count:
        message = f"holds {len(table.values)} beads, but {before.path} has {before.bead_count} before they are repeated"
        raise SceneError(message, path=table.path, line=2 if table.first_line else None)
    copies = after.bead_count // before.bead_count
    ends = np.cumsum([0, *(m.count * m.beads_per_molecule for m in before.molecules)]).tolist()
    order = np.concatenate([np.tile(np.arange(start, end), copies) for start, end in pairwise(ends)])
    return replace(table, values=table.values[order], rows=order if table.rows is None else table.rows[order])
