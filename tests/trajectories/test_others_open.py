"""ASE, OVITO, MDAnalysis, gsd and h5py open what is written, and see the same beads in the same cell.

OVITO's package is large (some 200 MB) and in the extra ``judges``, not in ``test``; its tests run where it is
installed.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import ase.io
import gsd.hoomd
import h5py
import numpy as np
import pytest

from pydlpoly.ase import ENERGY, VELOCITY, scene_from_atoms
from pydlpoly.errors import InputError
from pydlpoly.formats.frame import Frame
from pydlpoly.trajectories import FORMATS, Topology, configuration_of, open_writer, read

from .frames import CELLS, TURNED, frames, topology

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import MDAnalysis

SINGLE = 2.0**-23
PERIODIC = {0: (False, False, False), 6: (True, True, False)} | dict.fromkeys((1, 2, 3), (True, True, True))


def written(path: Path, name: str, made: list[Frame], said: Topology | None = None) -> Path:
    file = path / f"file{FORMATS[name].extension}"
    with open_writer(name, file, made[0], said or topology(len(made[0].names))) as writer:
        for frame in made:
            writer.write(frame)
    return file


def distances(positions: np.ndarray, cell: np.ndarray, imcon: int) -> np.ndarray:
    """All distances by the nearest image; they do not depend on how the cell lies."""
    apart = (positions[:, None] - positions[None]) @ np.linalg.inv(cell)
    apart -= np.where(PERIODIC[imcon], np.round(apart), 0.0)
    return np.asarray(np.linalg.norm(apart @ cell, axis=-1))


# -- ASE --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("imcon", CELLS)
def test_ase_reads_extxyz(tmp_path: Path, imcon: int) -> None:
    made = frames(imcon=imcon)
    images = ase.io.read(written(tmp_path, "extxyz", made), index=":")
    assert len(images) == len(made)
    for atoms, frame in zip(images, made, strict=True):
        np.testing.assert_array_equal(atoms.positions, frame.positions)
        np.testing.assert_array_equal(atoms.cell.array, frame.cell)
        assert tuple(atoms.pbc) == PERIODIC[imcon]
        assert tuple(atoms.arrays["bead_types"]) == frame.names
        np.testing.assert_array_equal(atoms.get_masses(), frame.masses)
        np.testing.assert_array_equal(atoms.get_initial_charges(), frame.charges)
        assert frame.velocities is not None
        assert frame.forces is not None
        np.testing.assert_allclose(atoms.get_velocities(), frame.velocities * VELOCITY, rtol=1e-14)
        np.testing.assert_array_equal(atoms.get_forces(), frame.forces * ENERGY)
        np.testing.assert_array_equal(atoms.arrays["images"], frame.images)
        np.testing.assert_array_equal(atoms.arrays["density"], frame.arrays["density"])
        assert (atoms.info["step"], atoms.info["time"]) == (frame.step, frame.time)


def test_extxyz_makes_a_scene_through_ase(tmp_path: Path) -> None:
    """The names that ASE is given are those ``scene_from_atoms`` looks for."""
    (made,) = frames(1, imcon=1, level=1)
    atoms = ase.io.read(written(tmp_path, "extxyz", [made]))
    pairs = {("W", "W"): ("dpd", 1.0, 1.0, 1.0)}
    scene = scene_from_atoms(atoms, pairs=pairs, units="internal", control={"cutoff": "1 ang", **_SETTINGS})
    assert sorted(scene.species) == sorted(set(made.names))


_SETTINGS = {"ensemble": "nve", "timestep": "1 fs", "temperature": "0 K"}


def test_what_ase_writes_is_read(tmp_path: Path) -> None:
    atoms = ase.Atoms("OH2", [[0.1, 0.2, 0.3], [1, 0, 0], [0, 1, 0]], cell=[[5, 0, 0], [1, 6, 0], [0, 0, 7]], pbc=True)
    atoms.set_masses([16.0, 1.0, 1.0])
    atoms.set_velocities(np.full((3, 3), VELOCITY))
    ase.io.write(tmp_path / "water.xyz", atoms, format="extxyz")
    (tmp_path / "water.xyz").rename(tmp_path / "water.extxyz")
    (frame,) = read(tmp_path / "water.extxyz")
    assert frame.names == ("O", "H", "H")
    assert (frame.imcon, frame.step) == (3, 0)
    np.testing.assert_allclose(frame.positions, atoms.positions, atol=1e-8)
    np.testing.assert_array_equal(frame.cell, atoms.cell.array)
    assert frame.velocities is not None
    np.testing.assert_allclose(frame.velocities, 1.0, atol=1e-6)
    assert configuration_of(frame).level == 1


# -- OVITO ------------------------------------------------------------------------------------------------------------


def seen_by_ovito(file: Path, frame: int) -> Any:
    """The data of a frame; the rest of the system's memory of licences and windows stays silent."""
    reason = "OVITO's package is not installed, or a library of the system's that it draws with is missing"
    pytest.importorskip("ovito.io", reason=reason, exc_type=ImportError)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from ovito.io import import_file

        pipeline = import_file(str(file))
        assert pipeline.num_frames == 3
        return pipeline.compute(frame)


@pytest.mark.parametrize("imcon", CELLS)
@pytest.mark.parametrize("name", ["extxyz", "gsd"])
def test_ovito(tmp_path: Path, name: str, imcon: int) -> None:
    made = frames(imcon=imcon)
    data = seen_by_ovito(written(tmp_path, name, made), 1)
    frame, beads = made[1], data.particles
    largest = np.abs(frame.positions).max()
    np.testing.assert_allclose(beads.positions, frame.positions, rtol=0.0, atol=largest * SINGLE)
    types = {one.id: one.name for one in beads.particle_types.types}
    assert tuple(types[k] for k in beads.particle_types[...]) == frame.names
    masses = beads["Mass" if name == "gsd" else "masses"]
    np.testing.assert_allclose(masses, frame.masses, rtol=SINGLE if name == "gsd" else 0.0)
    np.testing.assert_allclose(data.cell[:, :3].T, frame.cell, rtol=2 * SINGLE, atol=1e-7)
    # The cell is drawn around the beads, not from the origin on.
    np.testing.assert_allclose(data.cell[:, 3], -0.5 * frame.cell.sum(axis=0), rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(beads["density"], frame.arrays["density"], rtol=1e-15)
    if name == "extxyz":
        assert tuple(data.cell.pbc) == PERIODIC[imcon]
    else:
        np.testing.assert_allclose(beads["Velocity"], frame.velocities, rtol=SINGLE)
        assert len(beads.bonds.topology[...]) == 11


def test_ovito_sees_turned_cells(tmp_path: Path) -> None:
    made = frames(cell=TURNED)
    data = seen_by_ovito(written(tmp_path, "gsd", made), 2)
    cell = np.asarray(data.cell[:, :3]).T
    expected = distances(made[2].positions, TURNED, 3)
    np.testing.assert_allclose(distances(np.asarray(data.particles.positions), cell, 3), expected, atol=1e-5)


# -- MDAnalysis -------------------------------------------------------------------------------------------------------


def universe(*files: Any, **options: Any) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return MDAnalysis.Universe(*map(str, files), **options)


@pytest.mark.parametrize("imcon", [1, 2, 3, 6])
@pytest.mark.parametrize("name", ["gsd", "h5md", "dcd"])
def test_mdanalysis(tmp_path: Path, name: str, imcon: int) -> None:
    made = frames(imcon=imcon)
    written(tmp_path, "dcd", made)
    file = written(tmp_path, name, made)
    there = universe(file) if name == "gsd" else universe(tmp_path / "file.psf", file)
    assert len(there.trajectory) == 3
    for moment, frame in zip(there.trajectory, made, strict=True):
        np.testing.assert_allclose(there.atoms.positions, frame.positions, atol=3 * SINGLE * 5)
        if not (name == "gsd" and imcon in (3, 6)):  # MDAnalysis takes HOOMD's tilts for angles
            cell = np.asarray(moment.triclinic_dimensions, dtype=float)
            found = distances(there.atoms.positions.astype(float), cell, imcon)
            np.testing.assert_allclose(found, distances(frame.positions, frame.cell, imcon), atol=1e-5)
            lengths = np.linalg.norm(frame.cell, axis=1)
            np.testing.assert_allclose(moment.dimensions[:3], lengths, rtol=1e-6)
        if name == "h5md":
            assert moment.time == frame.time
            assert moment.data["step"] == frame.step
            np.testing.assert_allclose(there.atoms.velocities, frame.velocities, rtol=SINGLE)
            np.testing.assert_allclose(there.atoms.forces, frame.forces * 0.01, rtol=3 * SINGLE)
        if name == "dcd":
            assert moment.time == pytest.approx(frame.time, rel=1e-6)
    names = there.atoms.types if name == "gsd" else there.atoms.names
    assert tuple(names) == made[0].names
    np.testing.assert_allclose(there.atoms.masses, made[0].masses, rtol=SINGLE if name == "gsd" else 0.0)
    np.testing.assert_allclose(there.atoms.charges, made[0].charges, rtol=SINGLE)
    assert len(there.bonds) == 11


def test_mdanalysis_without_a_cell(tmp_path: Path) -> None:
    made = frames(imcon=0)
    there = universe(tmp_path / "file.psf", written(tmp_path, "dcd", made))
    assert there.dimensions is None
    np.testing.assert_allclose(there.atoms.positions, made[0].positions, atol=1e-6)


def test_mdanalysis_takes_reduced_units_when_it_is_told_to(tmp_path: Path) -> None:
    made = frames(imcon=1)
    file = written(tmp_path, "h5md", made, replace(topology(), reduced=True))
    written(tmp_path, "dcd", made)
    with pytest.raises(ValueError, match="convert_units"):
        universe(tmp_path / "file.psf", file)
    there = universe(tmp_path / "file.psf", file, convert_units=False)
    np.testing.assert_allclose(there.atoms.positions, made[0].positions, atol=1e-6)


# -- The libraries of the formats -------------------------------------------------------------------------------------


def test_gsd_as_hoomd_reads_it(tmp_path: Path) -> None:
    made = frames(cell=TURNED)
    with gsd.hoomd.open(written(tmp_path, "gsd", made)) as there:
        assert there.file.schema == "hoomd"
        for found, frame in zip(there, made, strict=True):
            found.validate()
            assert found.configuration.step == frame.step
            lx, ly, lz, xy, xz, yz = (float(x) for x in found.configuration.box)
            cell = np.array([[lx, 0, 0], [xy * ly, ly, 0], [xz * lz, yz * lz, lz]])
            beads = found.particles
            assert tuple(beads.types[k] for k in beads.typeid) == frame.names
            expected = distances(frame.positions, frame.cell, 3)
            np.testing.assert_allclose(distances(beads.position.astype(float), cell, 3), expected, atol=2e-5)
            # Followed across the cell's faces, turned or not.
            assert frame.images is not None
            ours = np.linalg.norm(frame.positions + frame.images @ frame.cell, axis=1)
            theirs = np.linalg.norm(beads.position + beads.image @ cell, axis=1)
            np.testing.assert_allclose(theirs, ours, rtol=1e-5)
            inside = np.abs(beads.position.astype(float) @ np.linalg.inv(cell)).max()
            assert inside <= 0.5 + 1e-6
            assert tuple(found.bonds.types) == ("HEAD-W", "Tail1234-C+2")


def test_what_hoomd_writes_is_read(tmp_path: Path) -> None:
    with gsd.hoomd.open(tmp_path / "other.gsd", "w") as there:
        for k in range(2):
            made = gsd.hoomd.Frame()
            made.configuration.step, made.configuration.box = 5 * k, [4, 5, 6, 0.1, 0, 0]
            made.particles.N, made.particles.types, made.particles.typeid = 2, ["A", "B"], [0, 1]
            made.particles.position = [[0, 0, 0.5 * k], [1, 1, 1]]
            there.append(made)
    first, second = read(tmp_path / "other.gsd")
    assert (first.names, second.step, second.imcon, second.time) == (("A", "B"), 5, 3, None)
    np.testing.assert_allclose(second.cell, [[4, 0, 0], [0.5, 5, 0], [0, 0, 6]], rtol=1e-6)
    np.testing.assert_array_equal(second.masses, [1.0, 1.0])  # the schema's default
    assert second.positions[0, 2] == 0.5


def test_h5md_is_read_beside_other_packages(tmp_path: Path) -> None:
    """HDF5 does not open a file in two modes at the same time."""
    made = frames(2)
    file = written(tmp_path, "h5md", made)
    with h5py.File(file):
        assert len(list(read(file))) == 2
    frame = next(read(file))
    with h5py.File(file) as there:
        np.testing.assert_array_equal(there["particles/trajectory/position/value"][0], frame.positions)


def test_what_another_program_writes_as_h5md(tmp_path: Path) -> None:
    """Steps in equal intervals, an edge of three numbers, velocities of other steps; other units are refused."""
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file.create_group("h5md").attrs["version"] = [1, 1]
        beads = file.create_group("particles/all")
        box = beads.create_group("box")
        box.attrs["dimension"], box.attrs["boundary"] = 3, ["periodic"] * 3
        box["edges"] = [4.0, 5.0, 6.0]
        beads["position/value"] = np.arange(12.0).reshape(2, 2, 3)
        beads["position/step"], beads["position/time"] = 50, 0.5
        beads["position/step"].attrs["offset"] = 10
        beads["velocity/value"], beads["velocity/step"] = np.zeros((1, 2, 3)), [0]
        beads["species"] = [1, 4]
    first, second = read(tmp_path / "other.h5")
    assert (first.names, first.imcon, first.velocities) == (("1", "4"), 2, None)
    assert (first.step, second.step, second.time) == (10, 60, 0.5)
    np.testing.assert_array_equal(second.positions, [[6, 7, 8], [9, 10, 11]])
    np.testing.assert_array_equal(second.cell, np.diag([4.0, 5.0, 6.0]))
    with h5py.File(tmp_path / "other.h5", "r+") as file:
        file["particles/all/position/value"].attrs["unit"] = "nm"
    with pytest.raises(InputError, match=r"other\.h5: 'nm': the unit of position must be Angstrom or none"):
        read(tmp_path / "other.h5")


def test_h5md_is_laid_out_as_specified(tmp_path: Path) -> None:
    """H5MD 1.1: https://www.nongnu.org/h5md/h5md.html."""
    made = frames(imcon=6)
    with h5py.File(written(tmp_path, "h5md", made)) as file:
        assert file["h5md"].attrs["version"].tolist() == [1, 1]
        assert {"name"} <= set(file["h5md/author"].attrs)
        assert {"name", "version"} <= set(file["h5md/creator"].attrs)
        assert file["h5md/modules/units"].attrs["version"].tolist() == [1, 0]
        beads = file["particles/trajectory"]
        assert beads["box"].attrs["dimension"] == 3
        assert list(beads["box"].attrs["boundary"]) == ["periodic", "periodic", "none"]
        for name in ("position", "velocity", "force", "image", "density", "concentration_A", "box/edges"):
            element = beads[name]
            assert len(element["step"]) == len(element["time"]) == len(element["value"]) == 3
            assert element["step"] == beads["position/step"]
        kinds = h5py.check_enum_dtype(beads["species"].dtype)
        assert sorted(kinds) == sorted(set(made[0].names))
        assert beads["mass"].shape == beads["charge"].shape == (23,)
        assert beads["position/value"].attrs["unit"] == "Angstrom"
        bonds = file["connectivity/bonds"]
        assert file[bonds.attrs["particles_group"]] == beads
        assert bonds.shape == (11, 2)
