"""Recipes: every table is read, errors name file, table and key, and the shipped recipes run."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import InputError, Simulation, load
from pydlpoly.build import Built, recipe
from pydlpoly.build.recipe import build_recipe, example_recipe, example_recipes
from pydlpoly.cli import main
from pydlpoly.formats.control import effect_of
from pydlpoly.formats.records import Setting

WATER = """\
[box]
edge = 5.0
density = 3.0

[species]
W = {}
A = { mass = 2.0, charge = -1.0 }
B = { charge = 1.0, frozen = true }

[[molecules]]
species = "W"
fill = true

[pairs]
"*" = { a = 25.0, cutoff = 1.0, drag = 4.5 }

[bonds]
"*" = ["harm", 50.0, 0.6]
"""


def made(tmp_path: Path, text: str, **options) -> Built:
    path = tmp_path / "recipe.toml"
    path.write_text(text)
    return build_recipe(path, **options)


def with_molecule(lines: str) -> str:
    return WATER + f"\n[[molecules]]\n{lines}\n"


def uncharged(built: Built) -> Built:
    """Without electrostatics where this version does not model them."""
    if effect_of(Setting("coul_method", "spme")).kind != "refused" or built.control.get("coul_method") is None:
        return built
    charges = ("coul", "charge", "spme")
    kept = tuple(s for s in built.control.settings if not s.keyword.startswith(charges))
    return replace(built, control=replace(built.control, settings=kept))


def test_a_recipe_is_what_build_is_given(tmp_path: Path) -> None:
    text = WATER.replace("edge = 5.0", "edges = [5.0, 6.0, 4.0]\nlength = 0.7")
    text = f'title = "trial"\nseed = 3\nminimum_distance = 0.3\nneutralise = ["B"]\n{text}'
    text += """
[[molecules]]
name = "star"
star = { core = "A", arm = "W2", arms = 3 }
count = 2
shape = "rigid"

[[molecules]]
name = "comb"
comb = { backbone = "W4", side = "A", spacing = 2 }
count = 1
turn = 90.0
region = { cylinder = 1.5, axis = "x", centre = [0.0, 0.5, 0.0] }

[[molecules]]
name = "ring"
ring = "W5"
fraction = 0.05
region = { slab = [-1.5, 1.5], axis = "y" }

[[molecules]]
name = "triangle"
graph = { beads = "W,W,W", bonds = "0-1,1-2,0-2", places = [[0, 0, 0], [0.6, 0, 0], [0.3, 0.5, 0]] }
concentration = 0.1
region = { sphere = 1.9, outside = true }

[[molecules]]
salt = { cation = "B", anion = "A", number = 9 }

[angles]
"W W W" = ["cos", 5.0, 0.0, 1.0]

[run]
time_run = "10 steps"
timestep = "0.02 dpd_t"
"""
    built = made(tmp_path, text)
    volume = 120.0 - 4.0 / 3.0 * np.pi * 1.9**3
    dissolved = round(0.1 * 6.02214076e23 * volume * 0.7**3 * 1e-24)
    assert {**built.counts, "W": 0} == {
        "W": 0, "star": 2, "comb": 1, "ring": round(0.05 * 360 / 5), "triangle": dissolved, "B": 9 + 4, "A": 9,
    }  # fmt: skip
    assert built.charge == 0.0


def test_the_tables_of_a_recipe_reach_the_records(tmp_path: Path) -> None:
    text = WATER.replace('"*" = { a', 'mixing = "hogervorst"\n"W W" = { a').replace(
        "[bonds]", "[bonds]\nexclude = true"
    )
    built = made(tmp_path, with_molecule('name = "pair"\nsequence = "AB"\ncount = 3'))
    kinds = {atom.name: atom for molecule in built.field.molecules for atom in molecule.atoms}
    assert (kinds["A"].mass, kinds["A"].charge, kinds["B"].frozen) == (2.0, -1.0, 1)
    mixed = made(tmp_path, text + '\n[[molecules]]\nname = "pair"\nsequence = "AB"\ncount = 3\n')
    assert mixed.control.get("vdw_mix_method").value == "hogervorst"
    assert [line.species for line in mixed.field.pairs] == [("W", "W")]
    assert mixed.field.molecules[1].block("bonds").lines[0].key == "harm"
    assert built.field.molecules[1].block("bonds").lines[0].key == "-hrm"


def test_the_seed_of_the_caller_counts(tmp_path: Path) -> None:
    same = [made(tmp_path, text, seed=5).config.positions for text in (WATER, f"seed = 9\n{WATER}")]
    assert np.array_equal(*same)
    assert not np.array_equal(same[0], made(tmp_path, WATER).config.positions)


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("[box\n", "", r"is no TOML file: .*line 1"),
        ("", ": 'box'", "this table is missing"),
        (WATER.replace("[species]", "[spezies]"), ": 'spezies'", "is unknown; expected .*did you mean species"),
        (WATER.replace("edge = 5.0\n", ""), ": 'box'", "give exactly one of edge, edges and cell"),
        (WATER.replace("edge = 5.0", 'edge = "big"'), ": 'box.edge'", "expected a number, not 'big'"),
        (WATER.replace("edge = 5.0", "edge = true"), ": 'box.edge'", "expected a number, not True"),
        (WATER.replace("density = 3.0", "densty = 3.0"), ": 'box.densty'", "is unknown; .*did you mean density"),
        (WATER.replace("mass = 2.0", "mas = 2.0"), ": 'species.A.mas'", "is unknown; .*did you mean mass"),
        (WATER.replace("W = {}", "W = 1"), ": 'species.W'", "expected a table"),
        (WATER.replace("fill = true", "fill = 1"), r": 'molecules\[1\].fill'", "expected true or false, not 1"),
        (WATER.replace("fill = true", "fil = 1"), r": 'molecules\[1\].fil'", "is unknown; .*did you mean fill"),
        (WATER.replace('species = "W"', ""), r": 'molecules\[1\]'", "give exactly one of species, sequence, ring"),
        (WATER.replace("fill = true", 'sequence = "W"'), r": 'molecules\[1\]'", "give exactly one of species"),
        (with_molecule('sequence = "A2"\ncount = 1'), r": 'molecules\[2\].name'", "the molecule needs a name"),
        (with_molecule('name = "x"\nstar = { core = "A" }'), r": 'molecules\[2\].star.arm'", "is missing"),
        (with_molecule('name = "x"\nlipid = { heads = "A" }'), r": 'molecules\[2\].lipid.heads'", "did you mean head"),
        (with_molecule('salt = { cation = "B" }'), r": 'molecules\[2\].salt.anion'", "is missing"),
        (
            with_molecule('salt = { cation = "B", anion = "A", number = 1 }\ncount = 3'),
            r": 'molecules\[2\].count'",
            "has no meaning beside salt",
        ),
        (
            with_molecule('name = "x"\nlipid = { head = "A", tail = "W4" }\nbilayer = { area = 1.0 }\ncount = 3'),
            r": 'molecules\[2\].count'",
            "has no meaning beside bilayer",
        ),
        (
            with_molecule('species = "A"\ncount = 1\nregion = { radius = 1.0 }'),
            r": 'molecules\[2\].region.radius'",
            "is unknown",
        ),
        (
            with_molecule('species = "A"\ncount = 1\nregion = { sphere = 1.0, axis = "x" }'),
            r": 'molecules\[2\].region.axis'",
            "has no meaning beside sphere",
        ),
        (
            with_molecule('species = "A"\ncount = 1\nregion = { sphere = 1.0, centre = [1.0] }'),
            r": 'molecules\[2\].region.centre'",
            "expected three numbers",
        ),
        (
            with_molecule('species = "A"\ncount = 1\nregion = { slab = [1.0] }'),
            r": 'molecules\[2\].region.slab'",
            "expected two heights",
        ),
        (with_molecule('species = "A"\ncount = 1\nregion = {}'), r": 'molecules\[2\].region'", "exactly one of slab"),
        (with_molecule('species = "Q"\ncount = 1'), r": 'molecules\[2\].species.Q'", "is no species"),
        (with_molecule('name = "x"\nsequence = "A("\ncount = 1'), r": 'molecules\[2\].sequence'", "is empty"),
        (with_molecule('species = "A"'), r": 'molecules\[2\]'", "molecule A: give exactly one of count, fraction"),
        (with_molecule('species = "A"\ncount = 999'), r": 'molecules\[1\]'", "molecule W: nothing is left to fill"),
        (WATER.replace('["harm", 50.0, 0.6]', "4.0"), r": 'bonds.\*'", "expected a law and its numbers"),
        (WATER.replace("[bonds]", "[bonds]\nexclude = 1"), ": 'bonds.exclude'", "expected true or false"),
        (WATER.replace("[pairs]", "[pairs]\nmixing = 1"), ": 'pairs.mixing'", "expected text"),
        (WATER.replace('"*" = { a', '"W W" = { b = 1.0, a'), ": 'pairs.W W'", "b is not known"),
        (f'minimum_distance = "far"\n{WATER}', r": 'minimum_distance.\*'", "expected a number, not 'far'"),
        (f"neutralise = [1]\n{WATER}", ": 'neutralise'", "expected text, not 1"),
        (f'{WATER}\n[run]\ntimestp = "1 ps"\n', ": 'run.timestp'", "is no keyword of CONTROL; did you mean timestep"),
        (f'{WATER}\n[run]\ntimestep = "1 pony"\n', ": ", "pony"),
        (f'units = "stone"\n{WATER}', ": 'units", "stone|unit"),
        (WATER.replace("density = 3.0", "density = -3.0"), ": 'density'", "the density must lie above 0"),
    ],
)  # fmt: skip
def test_errors_name_file_table_and_key(tmp_path: Path, text: str, place: str, message: str) -> None:
    with pytest.raises(InputError, match=rf"^{tmp_path}/recipe\.toml{place}.*({message})"):
        made(tmp_path, text)


def test_a_recipe_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        build_recipe(tmp_path / "none.toml")
    with pytest.raises(InputError, match=r"no such recipe; there are diblock, .*did you mean droplet"):
        example_recipe("droplets")


# -- Shipped recipes ---------------------------------------------------------------------------------------------------


def test_there_are_recipes() -> None:
    assert {"diblock", "droplet", "lipid-bilayer", "polyelectrolyte"} <= set(example_recipes())


@pytest.mark.parametrize("name", example_recipes())
def test_a_shipped_recipe_runs(name: str) -> None:
    """200 steps without a stop; k_B T is then near 1, while overlaps of the start still give off heat."""
    built = uncharged(build_recipe(example_recipe(name)))
    assert built.density == pytest.approx(3.0, rel=0.01)
    assert abs(built.charge) < 1e-9
    assert not built.warnings
    simulation = Simulation(built.scene(), seed=1, threads=1)
    simulation.run(200)
    assert simulation.temperature == pytest.approx(1.0, abs=0.15)


def test_the_polyelectrolyte_is_that_of_the_literature() -> None:
    """Counts of the published set-up: 50 beads of charge 1/2, 75 + 75 salt, 25 counter-ions, 9900 water in 15³."""
    built = build_recipe(example_recipe("polyelectrolyte"))
    assert built.counts == {"polymer": 1, "C": 75, "A": 75 + 25, "water": 9900}
    assert len(built.config.names) == 10_125
    strengths = {line.species: line.parameters for line in built.field.pairs}
    assert strengths["P", "W"] == (80.42, 1.0, 4.5)
    assert {p for species, p in strengths.items() if species != ("P", "W")} == {(78.3, 1.0, 4.5)}
    settings = {setting.keyword: setting.value for setting in built.control}
    assert settings["coul_method"] == "spme"
    assert settings["charge_smearing_method"] == "slater"
    assert 1.0 / settings["charge_smearing_length"] == pytest.approx(0.929, abs=1e-3)


# -- The command -------------------------------------------------------------------------------------------------------


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    def call(*words: object) -> tuple[object, str]:
        monkeypatch.setattr(sys, "argv", ["pydlpoly", "build", *(str(word) for word in words)])
        with pytest.raises(SystemExit) as stop:
            main()
        captured = capsys.readouterr()
        return stop.value.code, captured.out + captured.err

    return call


def test_the_command_writes_a_folder_that_loads(command, tmp_path: Path) -> None:
    (tmp_path / "water.toml").write_text(WATER)
    code, text = command(tmp_path / "water.toml", "-o", tmp_path / "out", "--seed", 4)
    assert code == 0, text
    assert "375 beads, density 3, charge +0" in text
    scene = load(tmp_path / "out")
    assert np.array_equal(scene.beads.positions, build_recipe(tmp_path / "water.toml", seed=4).scene().beads.positions)


def test_the_command_replaces_nothing_unless_told_to(command, tmp_path: Path) -> None:
    (tmp_path / "water.toml").write_text(WATER)
    (tmp_path / "FIELD").write_text("mine")
    code, text = command(tmp_path / "water.toml", "-o", tmp_path)
    assert code == 1
    assert "FIELD would be replaced; choose another folder with -o, or say --force" in text
    assert (tmp_path / "FIELD").read_text() == "mine"
    assert not (tmp_path / "CONTROL").exists()
    assert command(tmp_path / "water.toml", "-o", tmp_path, "--force")[0] == 0
    assert load(tmp_path).bead_count == 375


def test_what_is_not_modelled_is_refused_before_anything_is_written(command, tmp_path: Path) -> None:
    (tmp_path / "water.toml").write_text(f'{WATER}\n[run]\nplumed = "on"\n')
    code, text = command(tmp_path / "water.toml", "-o", tmp_path / "out")
    assert code == 1
    assert "plumed on is not modelled" in text
    assert not (tmp_path / "out").exists()


def test_the_command_writes_an_example_with_its_recipe(command, tmp_path: Path) -> None:
    code, text = command("--example", "droplet", "-o", tmp_path)
    assert code == 0, text
    assert sorted(path.name for path in tmp_path.iterdir()) == ["CONFIG", "CONTROL", "FIELD", "droplet.toml"]
    assert load(tmp_path).bead_count == 5184
    assert command("--list")[1].count("\n") == len(example_recipes())
    assert command()[0] == 2
    assert command("x.toml", "--example", "droplet")[0] == 2


def test_every_key_is_documented() -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "build.md").read_text(encoding="utf-8")
    tables = [getattr(recipe, name) for name in dir(recipe) if name.startswith("_") and name[1:].isupper()]
    keys = {key for table in tables if isinstance(table, dict) for key in table}
    assert {"title", "density", "mass", "spacing", "periods", "outside", "anion"} <= keys
    assert [key for key in sorted(keys) if key not in page] == []
