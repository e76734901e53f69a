"""The engine lammps: electrostatics against the native core; to 1e-10 but for Ewald's sums, which are two meshes."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import Scene, SceneError, _core
from pydlpoly.engines.lammps_team import ProcessTeam
from pydlpoly.engines.lammps_translate import translate
from pydlpoly.engines.lammps_translate.charges import METHODS, SHAPES

from ..molecule_builder import chains, molecule_scene
from ..scene_builder import NVE, make_scene
from .lammps_points import EXACT, assert_same_point

BEADS = {"P": 60, "M": 60, "W": 100}
CHARGES = {"P": 1.0, "M": -1.0, "W": 0.0}
CELL = np.array([[6.0, 0, 0], [1.7, 5.5, 0], [-1.2, 2.1, 6.3]])
BASE = {**NVE, "coul_bjerrum_length": "1.1 ang", "cutoff": "2.5 ang"}


def charged(method: str, shape: str = "none", *, beads: dict[str, int] | None = None, **control: str) -> Scene:
    given = BEADS if beads is None else beads
    names = list(given)
    pairs = [f"{a} {b} dpd 25.0 1.0" for k, a in enumerate(names) for b in names[k:]]
    smeared = {"charge_smearing_method": shape, "charge_smearing_length": "0.5 ang"} if shape != "none" else {}
    return make_scene(
        given, pairs, cell=CELL, charges=CHARGES, control={**BASE, "coul_method": method, **smeared, **control}
    )


def test_only_methods_and_shapes_of_the_registry_are_translated() -> None:
    assert set(METHODS) <= {row["name"] for row in _core.charge_methods()}
    assert set(SHAPES) <= {row["name"] for row in _core.charge_shapes()}


def test_a_method_that_is_not_known_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(METHODS, "reaction_field")
    with pytest.raises(SceneError, match=r"CONTROL.*coul_method reaction_field cannot be run with the engine lammps"):
        translate(charged("reaction_field"), 1)


@pytest.mark.parametrize("method", ["pairwise", "dddp"])
def test_truncated_points(team: ProcessTeam, method: str) -> None:
    assert_same_point(team, charged(method))


@pytest.mark.parametrize("damping", ["0.0", "0.7"], ids=["not damped", "damped"])
@pytest.mark.parametrize("shape", ["none", "slater", "slater-exact", "gaussian"])
@pytest.mark.parametrize("method", ["pairwise", "force_shifted", "reaction_field"])
def test_sums_between_pairs(team: ProcessTeam, method: str, shape: str, damping: str) -> None:
    more = {"coul_damping": f"{damping} ang^-1"} if method != "pairwise" else {}
    more |= {"coul_dielectric_constant": "5.0"} if method == "reaction_field" else {}
    assert_same_point(team, charged(method, shape, **more))


@pytest.mark.parametrize(("method", "shape"), [("spme", "none"), ("ewald_direct", "none"), ("spme", "slater")])
def test_ewald_sums(team: ProcessTeam, method: str, shape: str) -> None:
    more = {"spme_precision": "1e-7", "spme_nsplines": "10"}
    assert_same_point(team, charged(method, shape, **more), 3e-5)


def test_ewald_sums_on_two_ranks(two_ranks: ProcessTeam) -> None:
    assert_same_point(two_ranks, charged("spme", "slater", spme_precision="1e-7", spme_nsplines="10"), 3e-5)


@pytest.mark.parametrize("method", ["force_shifted", "spme"])
def test_pairs_that_bonds_exclude(team: ProcessTeam, method: str) -> None:
    scene = molecule_scene(
        "PM",
        {"bonds": ["harm 1 2 5.0 0.8"]},
        chains(60, 2, CELL, seed=5, step=0.8),
        copies=60,
        cell=CELL,
        charges=(1.0, -1.0),
        pairs=("P P dpd 25.0 1.0", "P M dpd 25.0 1.0", "M M dpd 25.0 1.0"),
        control={"coul_method": method, "coul_bjerrum_length": "1.1 ang", "cutoff": "2.5 ang", "spme_nsplines": "10"},
    )
    assert_same_point(team, scene, EXACT if method == "force_shifted" else 1e-4)


REFUSED = {
    "linear": (lambda: charged("pairwise", "linear"), "charges of the shape linear"),
    "gaussian": (lambda: charged("spme", "gaussian"), "Ewald's sum of charges of the shape gaussian"),
    "not neutral": (lambda: charged("spme", beads={"P": 3, "W": 10}), "do not add up to zero"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refusals(name: str) -> None:
    make, words = REFUSED[name]
    with pytest.raises(SceneError, match=words):
        translate(make(), 1)
