"""BEADS, callbacks, ASE and profiles of scenes whose beads carry dissolved species by FIELD's extension."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from ase import Atoms

import pydlpoly
from pydlpoly import Simulation
from pydlpoly.ase import atoms_from_state, scene_from_atoms
from pydlpoly.callbacks import Moment, Source
from pydlpoly.errors import SceneError
from pydlpoly.formats.beads_file import read_beads, write_beads
from pydlpoly.formats.binned_table import read_binned
from pydlpoly.formats.field import parse_field
from pydlpoly.runner import run_scene

from .run_folders import run_folder

BLOCK = """extension transport
species salt sugar
pair * * salt kappa 0.5 range 1.0 noise 1e-6
pair * * sugar kappa 0.1 range 1.0
noise sqrt
start salt 0.25
start sugar 1.0 in B
reaction 0.1 sugar -> salt
end extension
"""
PROFILES = {"profile_frequency": "10 steps", "profile_bins": "6", "profile_quantities": "concentration"}


def folder_of(folder: Path, settings: dict[str, str | None] | None = None) -> Path:
    """The usual run, with two dissolved species."""
    run_folder(folder, settings)
    field = folder / "FIELD"
    field.write_text(field.read_text() + BLOCK)
    return folder


def test_columns_replace_the_block_s_start_values(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "in")
    salt = np.random.default_rng(1).random(160)
    write_beads(folder / "BEADS", "t", ["concentration_salt"], [salt])
    scene = pydlpoly.load(folder)
    np.testing.assert_array_equal(scene.beads.concentrations[:, 0], salt)
    np.testing.assert_array_equal(scene.beads.concentrations[:, 1], scene.beads.species == 1)
    assert any("concentration_sugar: it has no such column" in note.text for note in scene.notes)
    write_beads(folder / "BEADS", "t", ["concentration_suger"], [salt])
    with pytest.raises(
        SceneError, match=r"BEADS:2: 'concentration_suger': beads do not.*; did you mean concentration_sug"
    ):
        pydlpoly.load(folder)


def salting(moment: Moment) -> dict[str, np.ndarray]:
    """A source that depends on place and on what is there."""
    return {"concentration_salt": 0.5 * np.exp(-moment["concentration_sugar"]) * (moment.positions[:, 2] > 0.0)}


@pytest.mark.parametrize("cut", [21, 24])
def test_runs_with_sources_in_python_continue_with_the_same_bits(tmp_path: Path, cut: int) -> None:
    scene = pydlpoly.load(folder_of(tmp_path / "in", PROFILES))
    calls: list[tuple[Callable[..., object], int]] = [(Source(salting), 6)]
    run_scene(scene, tmp_path / "whole", threads=1, callbacks=calls)  # type: ignore[arg-type]
    run_scene(scene, tmp_path / "parts", threads=2, callbacks=calls, steps=cut)  # type: ignore[arg-type]
    revive = tmp_path / "parts" / "REVIVE"
    run_scene(scene, tmp_path / "parts", threads=1, callbacks=calls, checkpoint=revive)  # type: ignore[arg-type]
    for name in ("REVCON", "REVBEADS", "PROFILE", "HISTORY", "STATIS"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parts" / name).read_bytes(), name
    profile = read_binned(tmp_path / "whole" / "PROFILE")["concentration_salt"]
    assert profile[3:].mean() > profile[:3].mean()


def test_a_reaction_in_python_is_that_of_field(tmp_path: Path) -> None:
    """Sugar turns into salt at the rate 0.1 in both; Euler's rule over one step has an error of (k Δt)²/2 a step."""
    folder = folder_of(tmp_path / "in")
    own = Simulation(pydlpoly.load(folder), seed=1, threads=1)
    field = folder / "FIELD"
    field.write_text(field.read_text().replace("reaction 0.1 sugar -> salt\n", ""))
    python = Simulation(pydlpoly.load(folder), seed=1, threads=1)

    def reaction(moment: Moment) -> dict[str, np.ndarray]:
        rate = 0.1 * moment["concentration_sugar"]
        return {"concentration_sugar": -rate, "concentration_salt": rate}

    python.add_callback(Source(reaction), every=1)
    for simulation in (own, python):
        simulation.run(50)
    one, other = own.state.concentrations, python.state.concentrations
    assert one[:, 1].sum() < 39.0
    assert np.abs(one.sum(axis=0) - other.sum(axis=0)).max() < 50 * 0.001**2 * 40
    np.testing.assert_allclose(one.sum(), other.sum(), rtol=1e-12)


def test_restart_from_revcon_and_revbeads(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "in")
    result = run_scene(pydlpoly.load(folder), tmp_path / "out", threads=1)
    table = read_beads(tmp_path / "out" / "REVBEADS")
    assert table.names == ("concentration_salt", "concentration_sugar")
    (tmp_path / "out" / "REVCON").rename(folder / "CONFIG")
    (tmp_path / "out" / "REVBEADS").rename(folder / "BEADS")
    again = pydlpoly.load(folder)
    assert again.beads.concentrations.tobytes() == result.simulation.state.concentrations.tobytes()


def test_ase_arrays() -> None:
    places = 4.0 * np.random.default_rng(1).random((40, 3))
    atoms = Atoms("X40", positions=places, cell=[4, 4, 4], pbc=True)
    atoms.set_array("bead_types", np.array(["B", "A"] * 20))
    sugar = np.random.default_rng(2).random(40)
    atoms.set_array("concentration_sugar", sugar)
    molecules = "".join(f"{n}s\nnummols 20\natoms 1\n{n} 1.0 0.0\nfinish\n" for n in "AB")
    field = parse_field(f"t\nunits dpd\nmolecules 2\n{molecules}vdw 1\nA A dpd 25.0 1.0 4.5\nclose\n{BLOCK}")
    control = {"ensemble": "nve", "timestep": "0.01 dpd_t", "temperature": "1 dpd_temp", "cutoff": "1 dpd_l"}
    scene = scene_from_atoms(atoms, field=field, control=control)
    found = atoms_from_state(scene)
    np.testing.assert_array_equal(found.arrays["concentration_sugar"], sugar)
    np.testing.assert_array_equal(found.arrays["concentration_salt"], 0.25)
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(5)
    after = atoms_from_state(scene, simulation.state)
    total = after.arrays["concentration_sugar"].sum() + after.arrays["concentration_salt"].sum()
    assert total == pytest.approx(sugar.sum() + 10.0, rel=1e-12)
