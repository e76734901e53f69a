"""Amounts, salt, charges, laws by species, records, files and Atoms."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import InputError, SceneError, Simulation, load
from pydlpoly.build import Component, Cylinder, Salt, Slab, Species, Sphere, bead, build, chain, comb, ring, star
from pydlpoly.scene import replicate

from .geometry import PAIRS

HARMONIC = {"*": ("harm", 50.0, 0.6)}
IONS = [Species("C", charge=1.0), Species("A", charge=-1.0), Species("D", charge=2.0), "W", Species("P", charge=-0.5)]
OFF = {"coul_method": "off"}


def test_counts_fractions_and_what_fills_the_rest() -> None:
    parts = [
        Component(chain("c", "A5"), fraction=0.2),
        Component("B", count=17),
        Component("W", fill=True),
        Component("D", concentration=0.5),
    ]
    built = build(
        box=(6.0, 5.0, 4.0), species="ABDW", molecules=parts, density=3.0, length=0.7, pairs=PAIRS, bonds=HARMONIC
    )
    dissolved = round(0.5 * 6.02214076e23 * 120.0 * 0.7**3 * 1e-24)
    assert dissolved == 12
    assert built.counts == {"c": round(0.2 * 360 / 5), "B": 17, "D": 12, "W": 360 - 70 - 17 - 12}
    assert [molecule.name for molecule in built.field.molecules] == ["c", "B", "W", "D"], "in the order given"
    assert built.density == pytest.approx(3.0, rel=1e-14)
    assert built.field.bead_count == len(built.config.names) == 360


def test_salt_is_neutral_whatever_the_valencies() -> None:
    built = build(box=5.0, species=IONS, molecules=[Salt("D", "A", number=6), "W"], density=3.0, pairs=PAIRS, run=OFF)
    assert built.counts == {"D": 6, "A": 12, "W": 375 - 18}
    assert built.charge == 0.0
    assert not built.warnings
    salt = Salt("C", "P", concentration=0.1)
    built = build(box=5.0, species=IONS, molecules=[salt, "W"], density=3.0, length=0.646, pairs=PAIRS, run=OFF)
    units = round(0.1 * 6.02214076e23 * 125.0 * 0.646**3 * 1e-24)
    assert built.counts == {"C": units, "P": 2 * units, "W": 375 - 3 * units}


def test_counter_ions_balance_the_charge_and_join_the_salt() -> None:
    parts = [Component(chain("p", "P10"), count=4), Salt("C", "A", number=5), "W"]
    options = {"species": IONS, "density": 3.0, "pairs": PAIRS, "bonds": HARMONIC, "run": OFF}
    built = build(box=6.0, molecules=parts, neutralise=["A", "C"], **options)
    assert built.counts == {"p": 4, "C": 5 + 20, "A": 5, "W": 648 - 40 - 30}
    assert built.charge == 0.0
    charged = build(box=6.0, molecules=parts, **options)
    assert charged.charge == -20.0
    assert charged.warnings == ("the charges add up to -20; neutralise names ions to balance them",)
    assert "warning: the charges add up to -20" in charged.report()
    assert any("add up to -20" in note.text and note.kind == "warning" for note in charged.scene().notes)


@pytest.mark.parametrize(
    ("parts", "options", "message"),
    [
        ([Component("W")], {}, "'W': give exactly one of count, fraction, concentration and fill"),
        ([Component("W", count=1, fill=True)], {}, "give exactly one of"),
        ([Component("W", count=-1)], {}, "a count is a whole number and not negative, not -1"),
        ([Component("W", count=2.5)], {}, "a count is a whole number and not negative, not 2.5"),
        ([Component("W", fraction=1.5)], {}, "a fraction lies between 0 and 1, not at 1.5"),
        ([Component("W", fraction=0.5)], {"density": None}, "a fraction or fill needs the number density"),
        ([Component("W", concentration=1.0)], {}, "'length': a concentration needs the length unit in nm"),
        ([Component("W", count=400), "C"], {}, "nothing is left to fill: the cell has 375 beads .*, and 400 are taken"),
        (["W", "C"], {}, "molecules: both W and C fill what is left of the cell"),
        ([], {}, "molecules: there are no molecules"),
        ([Component("W", count=0)], {}, "molecules: there are no beads"),
        (["X"], {}, "X: 'X': is no species.*; there are C, A, D, W, P"),
        ([Component(chain("m", "W2"), count=1), bead("C", "m")], {}, "'m': two unlike molecules have this name"),
        ([Salt("C", "A")], {}, "'C A': a salt needs either number or concentration"),
        ([Salt("A", "C", number=1)], {}, "a positive and a negative ion, not charges -1 and 1"),
        ([Salt("C", "W", number=1)], {}, "a positive and a negative ion"),
        (
            [Component("A", count=3), "W"],
            {"neutralise": ["P"]},
            "none of the counter-ions P can balance a charge of -3",
        ),
        ([Component("A", count=3), "W"], {"neutralise": ["D"]}, "'D': a charge of -3 is no multiple of its 2"),
        (["C"], {"neutralise": ["A"]}, "'C': what fills the cell is charged; give its count"),
        ([Component(chain("m", "W2"), count=1)], {}, "bonds: 'W W': molecule m: no law for a bond between W and W"),
        (["W"], {"density": -1.0}, "'density': the density must lie above 0"),
        (["W"], {"seed": -1}, "'seed': a seed must not be negative, not -1"),
        (["W"], {"box": "big"}, "box: 'big': expected an edge, three edges or three cell vectors"),
        (["W"], {"box": [5.0, -5.0, 5.0]}, "box: .*: the edges must lie above 0"),
        (["W"], {"box": [[1, 0, 0], [2, 0, 0], [0, 0, 1]]}, "the cell has no volume"),
        (["W"], {"species": ["W", "solvent_1"]}, "species: 'solvent_1': a species name has 1 to 8 characters"),
        (["W"], {"species": ["W", "*"]}, "and is not \\*"),
        (["W"], {"species": ["W", "W"]}, "species: 'W': this species is given twice"),
        ([Component("W", count=1, shape="flat")], {}, "W: 'flat': a shape is grown or rigid"),
        ([Component("W", count=1, turn=200.0)], {}, "a turn lies between 0 and 180 degrees, not at 200"),
        ([Component(ring("r", "W5"), count=1, shape="grown")], {"bonds": HARMONIC}, "cannot be grown; they are rigid"),
        ([Component("W", fill=True, region=Sphere(4.0))], {}, "a sphere of radius 4 does not fit a cell of width 5"),
        ([Component("W", fill=True, region=Cylinder(4.0))], {}, "a cylinder of radius 4 does not fit"),
        ([Component("W", fill=True, region=Slab(1.0, 9.0))], {}, "a slab from 1 to 9 does not fit a cell of height 5"),
        ([Component("W", fill=True, region=Slab(1.0, 2.0, "u"))], {}, "'u': an axis is x, y or z"),
        (["W"], {"pairs": {}}, "pairs: no law for W W; give one for \\*, or a mixing rule"),
        (["W"], {"pairs": {"W": 1.0}}, "pairs: 'W': expected 2 species \\(as in 'A B'\\) or \\*"),
        (["W"], {"pairs": {"W Q": 1.0, **PAIRS}}, "pairs: 'W Q': Q is no species"),
        (["W"], {"pairs": {"W W": {"b": 1.0}}}, "b is not known; expected a, cutoff, drag"),
        (["W"], {"pairs": {"W W": {"a": 1.0}}}, "pairs: 'W W': cutoff is missing here and in \\*"),
        (["W"], {"pairs": {"W W": "dpd"}}, "expected a law with its numbers, or a, cutoff and drag"),
        (["W"], {"pairs": {"W W": 1, ("W", "W"): 2, **PAIRS}}, "pairs: 'W W': this pair is given twice"),
        (["W"], {"minimum_distance": {"W Q": 1.0}}, "minimum_distance: 'W Q': Q is no species"),
        (["W"], {"minimum_distance": -1.0}, "a least distance must not be negative, not -1.0"),
        (["W"], {"minimum_distance": 6.0}, "a least distance of 6.* is larger than the cell's width 5"),
    ],
)
def test_what_is_refused(parts, options, message: str) -> None:
    arguments = {"box": 5.0, "species": IONS, "density": 3.0, "pairs": PAIRS, **options}
    with pytest.raises(SceneError, match=message):
        build(molecules=parts, **arguments)


def test_settings_that_are_refused() -> None:
    with pytest.raises(InputError, match="run: 'timestp': is no keyword of CONTROL; did you mean timestep"):
        build(box=5.0, species=["W"], molecules=["W"], density=3.0, pairs=PAIRS, run={"timestp": "1 ps"})
    with pytest.raises(InputError, match="units"):
        build(box=5.0, species=["W"], molecules=["W"], density=3.0, pairs=PAIRS, units="joule")


@pytest.mark.parametrize("law", ["sine", "bonds"])
def test_bonded_laws_that_are_refused(law: str) -> None:
    bad = {"sine": ("sine", 1.0), "bonds": 5}[law]
    with pytest.raises(SceneError, match=r"bonds: 'A A': (sine is no key of FIELD's bonds|expected a law's key)"):
        build(
            box=5.0,
            species=["A"],
            molecules=[Component(chain("c", "A2"), count=1)],
            pairs=PAIRS,
            bonds={"*": bad if law == "sine" else ("5",)[:0]},
        )


def test_laws_by_species_and_the_restraint_form() -> None:
    laws = {"*": ("harm", 1.0, 0.5), ("B", "A"): ("-mrs", 2.0, 0.5, 1.0)}
    angles = {("B", "A", "A"): ("cos", 5.0, 0.0, 1.0)}
    part = Component(chain("c", "A3B2"), count=1)
    options = {"box": 5.0, "species": "AB", "molecules": [part], "pairs": PAIRS, "bonds": laws, "angles": angles}
    built = build(**options)
    bonds = built.field.molecules[0].block("bonds")
    assert [line.key for line in bonds.lines] == ["-hrm", "-hrm", "-mrs", "-hrm"]
    (angle,) = built.field.molecules[0].block("angles").lines
    assert (angle.key, angle.beads, angle.parameters) == ("-cos", (2, 3, 4), (5.0, 0.0, 1.0))
    plain = build(**options, exclude_bonded=True)
    assert [line.key for line in plain.field.molecules[0].block("bonds").lines] == ["harm", "harm", "-mrs", "harm"]
    assert len(plain.scene().bonded.excluded) > 0
    assert len(built.scene().bonded.excluded) == 0


def test_pairs_in_all_forms() -> None:
    pairs = {
        "*": {"a": 25.0, "cutoff": 1.2, "drag": 4.5},
        "A B": 40.0,
        ("B", "B"): {"drag": 9.0},
        "A-A": ("lj", 1.0, 0.5),
    }
    built = build(box=5.0, species="AB", molecules=[Component("A", count=9), Component("B", count=9)], pairs=pairs)
    assert {line.species: (line.key, *line.parameters) for line in built.field.pairs} == {
        ("A", "A"): ("lj", 1.0, 0.5),
        ("A", "B"): ("dpd", 40.0, 1.2, 4.5),
        ("B", "B"): ("dpd", 25.0, 1.2, 9.0),
    }
    assert built.control.get("cutoff").value == 1.2


def test_names_with_a_minus_sign() -> None:
    parts = [Component("Cl-", count=9), Component("W", count=9)]
    pairs = {"*": {"a": 25.0, "cutoff": 1.0, "drag": 4.5}, "Cl- W": 30.0}
    built = build(box=5.0, species=["Cl-", "W"], molecules=parts, pairs=pairs)
    assert next(line for line in built.field.pairs if line.species == ("Cl-", "W")).parameters[0] == 30.0


def test_a_mixing_rule_in_place_of_pairs() -> None:
    pairs = {"A A": ("dpd", 25.0, 1.0, 4.5), "B B": ("dpd", 36.0, 1.0, 4.5)}
    parts = [Component("A", count=50), Component("B", count=50)]
    scene = build(box=5.0, species="AB", molecules=parts, pairs=pairs, mixing="lorentz-berthelot").scene()
    mixed = next(term for term in scene.pairs if term.law_origin == "mixed")
    assert scene.units.reduced
    assert mixed.parameters[0] == pytest.approx(30.0)


@pytest.mark.parametrize("box", [5.0, (5.0, 6.0, 7.123456789), [[5.0, 0.0, 0.0], [1.0, 5.0, 0.0], [0.5, -1.0, 6.0]]])
def test_files_make_the_same_scene(box, tmp_path) -> None:
    parts = [Component(chain("c", "A3B2"), count=8), Component(comb("k", "A4", "B2"), count=3), "W"]
    built = build(
        box=box,
        species=["A", "B", Species("W", mass=2.0)],
        molecules=parts,
        density=3.0,
        pairs=PAIRS,
        bonds=HARMONIC,
        angles={"A A A": ("harm", 3.0, 120.0)},
    )
    written = load(built.write(tmp_path / "new" / "folder"))
    scene = built.scene()
    for name in ("positions", "mass", "charge", "species", "molecule", "frozen"):
        assert np.array_equal(getattr(written.beads, name), getattr(scene.beads, name)), name
    assert np.array_equal(written.cell, scene.cell)
    assert written.imcon == scene.imcon
    assert [t.parameters for t in written.pairs] == [t.parameters for t in scene.pairs]
    for a, b in zip(written.bonded.terms, scene.bonded.terms, strict=True):
        assert (a.kind, a.law, a.parameters) == (b.kind, b.law, b.parameters)
        assert np.array_equal(a.beads, b.beads)
    assert written.dynamics == scene.dynamics
    assert written.run == scene.run
    assert written.degrees_of_freedom == scene.degrees_of_freedom


def test_atoms_have_species_molecules_and_bonds() -> None:
    built = build(
        box=5.0,
        species=["A", "B", Species("W", 3.0)],
        molecules=[Component(chain("c", "A2B"), count=2), Component("W", count=3)],
        pairs=PAIRS,
        bonds=HARMONIC,
    )
    atoms = built.to_atoms()
    assert atoms.arrays["bead_types"].tolist() == ["A", "A", "B"] * 2 + ["W"] * 3
    assert atoms.arrays["molecules"].tolist() == [0, 0, 0, 1, 1, 1, 2, 3, 4]
    assert sorted(map(tuple, atoms.info["bonds"].tolist())) == [(0, 1), (1, 2), (3, 4), (4, 5)]
    assert atoms.get_masses()[-1] == 3.0
    apart = atoms.get_distances(0, [1], mic=True)
    assert apart == pytest.approx([0.6], abs=3e-6)


def test_other_units_take_all_settings_from_run() -> None:
    built = build(
        box=30.0,
        species=[Species("A", 40.0)],
        molecules=[Component("A", count=100)],
        pairs={"A A": ("dpd", 25.0, 6.5, 4.5)},
        units="kj",
        minimum_distance=2.0,
        run={"temperature": "300 K", "timestep": "20 fs"},
    )
    scene = built.scene()
    assert scene.cutoff == 6.5
    assert scene.dynamics.timestep == pytest.approx(0.02)
    nve = build(box=5.0, species=["W"], molecules=["W"], density=3.0, pairs=PAIRS, run={"ensemble": "nve"})
    assert nve.scene().dynamics.integrator == "nve"


def test_frozen_beads() -> None:
    wall = Component(bead("F"), count=50, region=Slab(-0.5, 0.5))
    scene = build(
        box=5.0, species=[Species("F", frozen=True), "W"], molecules=[wall, "W"], density=3.0, pairs=PAIRS
    ).scene()
    assert scene.beads.frozen.sum() == 50


@pytest.mark.parametrize("name", ["water", "chains", "rings and stars", "droplet", "film", "salt"])
def test_built_scenes_run_at_their_temperature(name: str) -> None:
    """200 steps without a stop; then k_B T is near 1, while overlaps of the start still give off heat."""
    mixture = [Component(ring("r", "A8"), count=10), Component(star("s", "B", "A4", 4), count=10), "W"]
    parts = {
        "water": ["W"],
        "chains": [Component(chain("c", "A5B5"), fraction=0.5), "W"],
        "rings and stars": mixture,
        "droplet": [Component("A", fill=True, region=Sphere(2.5)), "W"],
        "film": [Component("A", fill=True, region=Slab(-2.0, 2.0)), "W"],
        "salt": [Salt("C", "N", number=50), "W"],
    }
    built = build(
        box=7.0,
        species=["A", "B", "W", Species("C", charge=1.0), Species("N", charge=-1.0)],
        molecules=parts[name],
        density=3.0,
        pairs=PAIRS,
        bonds=HARMONIC,
        minimum_distance=0.35,
        run=OFF,
    )
    simulation = Simulation(built.scene(), seed=3, threads=1)
    simulation.run(200)
    temperatures = []
    for _ in range(10):
        simulation.run(5)
        temperatures.append(simulation.temperature)
    assert np.mean(temperatures) == pytest.approx(1.0, abs=0.15)


def test_a_built_scene_can_be_repeated() -> None:
    built = build(
        box=4.0, species=["A"], molecules=[Component(chain("c", "A4"), count=12)], pairs=PAIRS, bonds=HARMONIC
    )
    field, config = replicate(built.field, built.config, (1, 2, 1))
    assert field.molecules[0].count == 24
    assert config.cell[1, 1] == 8.0
