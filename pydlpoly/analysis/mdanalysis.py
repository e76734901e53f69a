"""A scene and its trajectory as an MDAnalysis Universe, for everything that MDAnalysis does well."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import PathLike
from pydlpoly.scene.model import Scene
from pydlpoly.trajectories import FORMATS, format_of


def universe(scene: Scene, history: PathLike | None = None) -> Any:
    """Return ``MDAnalysis.Universe`` with the scene's beads, molecules and bonds, and the frames of a trajectory.

    Bead names and types are species, residues are molecules (numbered from 1, named after their type), masses and
    charges are the scene's, bonds those of FIELD. ``history`` is a HISTORY file, or one whose ending MDAnalysis knows,
    as .gsd, .h5md and .dcd; without it the positions are the scene's. MDAnalysis holds coordinates in single precision,
    in Å, with the cell's corner at the origin or not as the file has them.

    Raises:
        InputError: MDAnalysis is missing (``pip install MDAnalysis``), or HISTORY has other beads.
    """
    try:
        import MDAnalysis  # the package's own name
    except ImportError:
        raise InputError("this needs MDAnalysis: pip install MDAnalysis") from None
    beads = scene.beads
    made = MDAnalysis.Universe.empty(
        len(beads),
        n_residues=int(beads.molecule.max()) + 1,
        atom_resindex=beads.molecule,
        trajectory=history is None,
    )
    names = np.array(scene.species, dtype=object)[beads.species]
    kinds = np.repeat(np.array(scene.molecule_names, dtype=object), scene.molecule_counts)
    made.add_TopologyAttr("names", names)
    made.add_TopologyAttr("types", names)
    made.add_TopologyAttr("masses", beads.mass)
    made.add_TopologyAttr("charges", beads.charge)
    made.add_TopologyAttr("resids", np.arange(1, len(kinds) + 1))
    made.add_TopologyAttr("resnames", kinds)
    terms = () if scene.bonded is None else scene.bonded.terms
    bonds = [term.beads for term in terms if term.kind == "bond"]
    made.add_TopologyAttr("bonds", np.concatenate(bonds) if bonds else np.zeros((0, 2), dtype=int))
    if history is None:
        made.atoms.positions = beads.positions
        from MDAnalysis.lib.mdamath import triclinic_box

        made.dimensions = triclinic_box(*scene.cell)
        return made
    try:
        found = format_of(history)
        units = {"convert_units": False} if found is FORMATS["h5md"] and scene.units.reduced else {}
        made.load_new(os.fspath(history), format="HISTORY" if found is None else None, **units)
    except (OSError, ValueError, IndexError) as error:
        raise InputError(f"MDAnalysis cannot read it for this scene: {error}", path=os.fspath(history)) from error
    return made
