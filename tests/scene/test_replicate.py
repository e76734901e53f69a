"""nfold: a repeated configuration has the energy, pressure and forces per bead of the one it is made of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pydlpoly import InputError, SceneError, load, single_point
from pydlpoly.build import Component, build, chain, lipid
from pydlpoly.formats.control import parse_control, write_control
from pydlpoly.formats.records import Setting
from pydlpoly.scene import replicate, resolve

PAIRS = {"*": {"a": 25.0, "cutoff": 1.0, "drag": 4.5}, "A B": 40.0}
BONDS = {"*": ("harm", 50.0, 0.6)}
ANGLES = {"*": ("cos", 5.0, 0.0, 1.0)}
ORTHORHOMBIC, TILTED = (4.0, 5.0, 6.0), [[4.0, 0.0, 0.0], [1.0, 4.5, 0.0], [-0.5, 1.0, 5.0]]


def built(box=ORTHORHOMBIC, length: int = 12):
    """Chains that are longer than half of the cell, cut by its faces."""
    parts = [
        Component(chain("c", f"A{length // 2}B{length - length // 2}"), count=8),
        Component(lipid("l", "A", "B2", 2), count=6),
        "W",
    ]
    return build(box=box, species="ABW", molecules=parts, density=3.0, pairs=PAIRS, bonds=BONDS, angles=ANGLES, seed=5)


def point_of(made, field, config):
    return single_point(resolve(made.control, field, config), threads=1)


@pytest.mark.parametrize("counts", [(2, 1, 1), (1, 3, 2), (2, 2, 2)])
@pytest.mark.parametrize("box", [ORTHORHOMBIC, TILTED, 5.0], ids=["orthorhombic", "tilted", "cubic"])
def test_energy_and_stress_per_bead_are_the_same(box, counts) -> None:
    made = built(box)
    copies = int(np.prod(counts))
    one = point_of(made, made.field, made.config)
    field, config = replicate(made.field, made.config, counts)
    many = point_of(made, field, config)
    assert config.cell == pytest.approx(made.config.cell * np.array(counts)[:, None])
    for part, value in one.energy.items():
        assert many.energy[part] == pytest.approx(copies * value, rel=1e-12, abs=1e-12), part
    assert many.energy["bond"] > 0.0
    assert many.energy["angle"] > 0.0
    assert many.stress == pytest.approx(one.stress, rel=1e-12, abs=1e-11)


def test_forces_and_names_repeat_in_the_order_of_field() -> None:
    made = built()
    one = point_of(made, made.field, made.config)
    field, config = replicate(made.field, made.config, (1, 2, 2))
    many = point_of(made, field, config)
    start = 0
    for molecule in made.field.molecules:
        beads = molecule.count * molecule.beads_per_molecule
        block = slice(4 * start, 4 * (start + beads))
        assert many.forces[block] == pytest.approx(np.tile(one.forces[start : start + beads], (4, 1)), abs=1e-9)
        assert config.names[block] == made.config.names[start : start + beads] * 4
        start += beads


def test_molecules_are_whole() -> None:
    """Chains of 12 bonds of 0.6 in a cell of 4: wrapped ones would have bonds of the length of the cell."""
    made = built()
    _, config = replicate(made.field, made.config, (2, 1, 1))
    chains = config.positions[: 2 * 8 * 12].reshape(16, 12, 3)
    assert np.linalg.norm(np.diff(chains, axis=1), axis=2) == pytest.approx(np.full((16, 11), 0.6), abs=1e-5)
    shift = config.positions[8 * 12 : 2 * 8 * 12] - config.positions[: 8 * 12]
    assert shift == pytest.approx(np.tile([4.0, 0.0, 0.0], (96, 1)), abs=1e-12)
    assert np.abs(config.positions.mean(axis=0)).max() < 0.5, "around the origin"


def test_velocities_are_repeated() -> None:
    made = built()
    velocities = np.random.default_rng(1).normal(size=made.config.positions.shape)
    field, config = replicate(made.field, replace(made.config, velocities=velocities), (1, 1, 2))
    assert config.velocities[:96] == pytest.approx(velocities[:96], abs=0.0)
    assert config.velocities[96:192] == pytest.approx(velocities[:96], abs=0.0)
    assert field.bead_count == len(config.velocities)


def test_nothing_to_repeat() -> None:
    made = built()
    assert replicate(made.field, made.config, (1, 1, 1)) == (made.field, made.config)


def test_a_cubic_cell_becomes_orthorhombic_when_repeated_unevenly() -> None:
    made = built(5.0)
    assert made.config.imcon == 1
    assert replicate(made.field, made.config, (2, 2, 2))[1].imcon == 1
    assert replicate(made.field, made.config, (2, 1, 1))[1].imcon == 2


@pytest.mark.parametrize("style", ["new", "old"])
def test_control_asks_for_it(style: str, tmp_path) -> None:
    made = built()
    control = replace(made.control, settings=(*made.control.settings, Setting("nfold", (2, 1, 2))))
    folder = made.write(tmp_path)
    (folder / "CONTROL").write_text(write_control(replace(control, style=style)))
    scene = load(folder)
    assert scene.bead_count == 4 * len(made.config.names)
    assert scene.molecule_counts == tuple(4 * molecule.count for molecule in made.field.molecules)
    (note,) = [note for note in scene.notes if "nfold" in note.text]
    assert note.text.endswith(f"repeated 2 x 1 x 2 times, {len(made.config.names)} beads become {scene.bead_count}")
    assert note.where.startswith("CONTROL:")
    once = single_point(made.scene(), threads=1).energy["total"]
    assert single_point(scene, threads=1).energy["total"] == pytest.approx(4.0 * once, rel=1e-12)


@pytest.mark.parametrize(
    ("imcon", "counts", "message"),
    [
        (2, "0 1 1", "expected three whole numbers from 1 on, not 0 1 1"),
        (2, "-1 1 1", "expected three whole numbers from 1 on"),
        (0, "2 1 1", r"not periodic \(imcon 0\) cannot be repeated 2 1 1 times"),
        (6, "1 1 2", r"a slab \(imcon 6\) is not periodic along its third vector"),
        (2, "9999 9999 999", "beads repeated 9999 9999 999 times are more than 2147483647"),
    ],
)
def test_what_cannot_be_repeated(imcon: int, counts: str, message: str) -> None:
    made = built()
    text = write_control(made.control) + f"nfold [ {counts} ]\n"
    with pytest.raises(SceneError, match=rf"CONTROL:\d+: 'nfold': .*{message}"):
        resolve(parse_control(text), made.field, replace(made.config, imcon=imcon))


def test_a_slab_is_repeated_sideways() -> None:
    made = built((4.0, 5.0, 6.0))
    flat = replace(made.config, imcon=6)
    field, config = replicate(made.field, flat, (2, 2, 1))
    assert config.imcon == 6
    one, many = point_of(made, made.field, flat), point_of(made, field, config)
    assert many.energy["pair"] == pytest.approx(4.0 * one.energy["pair"], rel=1e-12)


def test_a_molecule_without_ends_is_refused() -> None:
    """Four beads in a row through the whole cell, the last one bonded to the image of the first."""
    made = build(box=4.0, species="AB", molecules=[Component(chain("c", "A4"), count=1)], pairs=PAIRS, bonds=BONDS)
    (molecule,) = made.field.molecules
    (block,) = molecule.blocks
    closing = replace(block.lines[0], beads=(4, 1))
    field = replace(made.field, molecules=(replace(molecule, blocks=(replace(block, lines=(*block.lines, closing)),)),))
    places = np.column_stack([np.arange(4.0) - 1.5, np.zeros(4), np.zeros(4)])
    config = replace(made.config, positions=places)
    with pytest.raises(SceneError, match="copy 1 of molecule c is bonded to its own image in the next cell"):
        replicate(field, config, (2, 1, 1))
    replicate(field, replace(config, positions=places * 0.4), (2, 1, 1))


def test_records_that_contradict_each_other() -> None:
    made = built()
    with pytest.raises(InputError, match="beads, but the molecules of FIELD add up to"):
        replicate(made.field, replace(made.config, names=made.config.names[1:]), (2, 1, 1))
