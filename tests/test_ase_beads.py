"""What beads carry in the arrays of Atoms: in as a scene's start, out from scenes and states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ase import Atoms

from pydlpoly import Simulation
from pydlpoly.ase import atoms_from_state, scene_from_atoms
from pydlpoly.errors import SceneError
from pydlpoly.scene import resolve

PAIRS = {("A", "A"): ("dpd", 25.0, 3.0), ("A", "B"): ("dpd", 40.0, 3.0), ("B", "B"): ("dpd", 30.0, 2.5)}
CONTROL = {"ensemble": "nve", "timestep": "1 fs", "temperature": "300 K", "cutoff": "3 ang"}


@pytest.fixture
def atoms() -> Atoms:
    """Twelve beads of two species in mixed order, so that the scene has to sort them."""
    made = Atoms("X12", positions=9.0 * np.random.default_rng(1).random((12, 3)), cell=[9, 9, 9], pbc=True)
    made.set_array("bead_types", np.array(["B", "A"] * 6))
    return made


@pytest.fixture
def hot(monkeypatch: pytest.MonkeyPatch) -> None:
    """Scenes as if FIELD's extensions gave every bead 310 K and a species "salt" of 0.5."""
    make_beads = resolve.__globals__["_beads"]

    def beads(*arguments):
        made = make_beads(*arguments)
        count = len(made)
        energies = np.full(count, 310.0 * 0.831451115)
        return replace(
            made, temperature=energies, heat_capacity=np.full(count, 50.0), concentrations=np.full((count, 1), 0.5)
        )

    monkeypatch.setitem(resolve.__globals__, "_beads", beads)
    monkeypatch.setattr("pydlpoly.scene.beads_state._names_of_species", lambda _: ("salt",))


@pytest.mark.usefixtures("hot")
def test_arrays_of_atoms_go_in_and_come_back_in_their_order(atoms: Atoms) -> None:
    warm, salty = 300.0 + np.arange(12.0), np.random.default_rng(2).random(12)
    atoms.set_array("temperature", warm)
    atoms.set_array("concentration_salt", salty)
    scene = scene_from_atoms(atoms, pairs=PAIRS, units="kj", control=CONTROL)
    assert scene.source_order is not None
    np.testing.assert_allclose(scene.beads.temperature, 0.831451115 * warm[scene.source_order], rtol=1e-15)
    np.testing.assert_array_equal(scene.beads.concentrations[:, 0], salty[scene.source_order])
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(3)
    for found in (atoms_from_state(scene), atoms_from_state(scene, simulation.state)):
        np.testing.assert_allclose(found.arrays["temperature"], warm, rtol=1e-15)
        np.testing.assert_array_equal(found.arrays["concentration_salt"], salty)
        assert "density" not in found.arrays
    state = replace(simulation.state, density=np.arange(12.0))
    assert atoms_from_state(scene, state).arrays["density"].tolist() == np.argsort(scene.source_order).tolist()


@pytest.mark.usefixtures("hot")
def test_what_atoms_do_not_say_is_the_extension_s(atoms: Atoms) -> None:
    atoms.set_array("temperature", np.arange(301, 313))  # whole numbers count, too
    scene = scene_from_atoms(atoms, pairs=PAIRS, units="kj", control=CONTROL)
    assert set(scene.beads.concentrations.ravel().tolist()) == {0.5}
    assert any(note.text.startswith("temperature of the beads: from atoms; concentration_salt") for note in scene.notes)
    plain = atoms.copy()
    del plain.arrays["temperature"]
    found = atoms_from_state(scene_from_atoms(plain, pairs=PAIRS, units="kj", control=CONTROL))
    np.testing.assert_allclose(found.arrays["temperature"], 310.0, rtol=1e-15)


def test_a_scene_that_carries_nothing_notes_the_arrays(atoms: Atoms) -> None:
    atoms.set_array("temperature", np.full(12, 300.0))
    scene = scene_from_atoms(atoms, pairs=PAIRS, units="kj", control=CONTROL)
    assert [note.kind for note in scene.notes if "atoms is not used" in note.text] == ["ignored"]
    assert "temperature" not in atoms_from_state(scene).arrays


@pytest.mark.usefixtures("hot")
@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        (
            "concentration_sugar",
            np.ones(12),
            "atoms: 'concentration_sugar': beads do not carry this; expected temperature, c",
        ),
        ("temperature", np.ones((12, 1)), "'temperature': must hold one number an atom, not float64 of shape"),
        ("temperature", np.array(["warm"] * 12), "'temperature': must hold one number an atom, not <U4"),
        ("temperature", np.abs(np.arange(-3.0, 9.0)), "atoms: '0': temperature of bead 4: expected a finite"),
    ],
)
def test_refusals(atoms: Atoms, name: str, values: np.ndarray, message: str) -> None:
    atoms.set_array(name, values)
    with pytest.raises(SceneError) as caught:
        scene_from_atoms(atoms, pairs=PAIRS, units="kj", control=CONTROL)
    assert message in str(caught.value)
