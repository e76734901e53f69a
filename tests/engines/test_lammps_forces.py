"""The engine lammps: forces, energies and stress of every translated law against the native core, to 1e-10.

A law of the registry without a style is refused by name.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pydlpoly import Scene, SceneError, _core
from pydlpoly.engines.lammps_team import ProcessTeam
from pydlpoly.engines.lammps_translate import translate
from pydlpoly.engines.lammps_translate.bonded import BONDED_STYLES, why_refused
from pydlpoly.engines.lammps_translate.bonded import formula_of as bonded_formula
from pydlpoly.engines.lammps_translate.pairs import PAIR_STYLES, PairStyle
from pydlpoly.engines.lammps_translate.pairs import formula_of as pair_formula

from ..molecule_builder import chains, molecule_scene
from ..scene_builder import NVE, make_scene
from ..test_bonded_laws import ROWS as BONDED_ROWS
from ..test_pair_laws import ROWS as PAIR_ROWS
from .lammps_points import EXACT, assert_same_point, lammps_point

CELLS = {
    "orthorhombic": np.diag([17.0, 16.0, 18.0]),
    "tilted": np.array([[17.0, 0, 0], [4.0, 16.0, 0], [-3.0, 5.0, 18.0]]),
}
LAWS = [key for key, style in PAIR_STYLES.items() if style is not None]
BLOCKS = {"bond": "bonds", "angle": "angles", "dihedral": "dihedrals"}


def lattice(cell: np.ndarray, seed: int = 8) -> np.ndarray:
    """A bead on each of 6³ places, moved a little: no two are close enough for hard laws to say nothing but one."""
    places = (np.stack(np.meshgrid(*[np.arange(6)] * 3), axis=-1).reshape(-1, 3) - 2.5) / 6.0
    rng = np.random.default_rng(seed)
    return np.asarray(rng.permutation(places @ cell + 0.6 * (rng.random((216, 3)) - 0.5)))


def law_scene(key: str, cell: str = "tilted", **control: str) -> Scene:
    """216 beads of a law in a cell, one species; velocities are zero."""
    numbers = " ".join(map(repr, PAIR_ROWS[key].parameters))
    vectors = CELLS[cell]
    settings = {**NVE, "cutoff": "4.0 ang", "vdw_long_range_correction": "off", **control}
    return make_scene(
        {"A": 216}, [f"A A {key} {numbers}"], cell=vectors, positions=lattice(vectors), control=settings, start_seed=5
    )


def test_only_laws_of_the_registry_have_styles() -> None:
    assert set(PAIR_STYLES) <= {law["key"] for law in _core.pair_laws()}


def test_a_law_without_a_style_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """As one that is added to the registry would be, until someone says what it becomes."""
    scene = law_scene("ryd")
    monkeypatch.delitem(PAIR_STYLES, "ryd")
    with pytest.raises(SceneError, match=r"FIELD:10: the pair law ryd of A-A cannot be run .*it is not translated"):
        translate(scene, 1)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("key", LAWS)
def test_pair_laws(team: ProcessTeam, key: str, cell: str) -> None:
    assert_same_point(team, law_scene(key, cell))


@pytest.mark.parametrize("key", [key for key in LAWS if PAIR_ROWS[key].shiftable])
def test_force_shifted_pair_laws(team: ProcessTeam, key: str) -> None:
    scene = law_scene(key, vdw_force_shift="on")
    assert scene.pairs[0].force_shift
    assert_same_point(team, scene)


@pytest.mark.parametrize("key", LAWS)
def test_formulas_of_laws_with_a_style_of_their_own(
    team: ProcessTeam, key: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where a style does not take a law's numbers, its formula is used; so formulas are checked, too."""
    scene = law_scene(key)
    entry = PAIR_STYLES[key]
    assert entry is not None
    monkeypatch.setitem(PAIR_STYLES, key, PairStyle(entry.formula))
    assert "lepton" in " ".join(translate(scene, 1).after)
    assert "r" in pair_formula(scene.pairs[0])
    assert_same_point(team, scene)


def test_numbers_that_no_style_takes(team: ProcessTeam) -> None:
    """Dispersion alone, repulsion alone: LAMMPS's styles have no such numbers."""
    lines = ["A A 12-6 20000.0 0.0", "A B buck 0.0 0.0 150.0", "B B bhm 0.0 0.0 2.0 170.0 -150.0"]
    vectors = CELLS["tilted"]
    settings = {**NVE, "cutoff": "4.0 ang", "vdw_long_range_correction": "off"}
    scene = make_scene({"A": 116, "B": 100}, lines, cell=vectors, positions=lattice(vectors), control=settings)
    assert_same_point(team, scene)


def test_a_mixture_of_laws_with_pairs_that_do_not_interact(team: ProcessTeam) -> None:
    lines = ["A A dpd 25.0 1.3", "A B lj 1.0 0.5", "B B wca 1.0 0.4 0.0"]
    scene = make_scene(
        {"A": 60, "B": 60, "C": 60},
        lines,
        cell=6.0,
        control={**NVE, "cutoff": "1.5 ang"},
        masses={"A": 1.0, "B": 2.0, "C": 3.0},
    )
    scene = dataclasses.replace(scene, long_range_correction=False)
    assert {pair.law for pair in scene.pairs} >= {None, "dpd", "lj", "wca"}
    assert_same_point(team, scene, 1e-9)  # beads at random places: forces of 1e20 hide the rest


@pytest.mark.parametrize("cell", CELLS)
def test_forces_across_the_border_of_ranks(two_ranks: ProcessTeam, cell: str) -> None:
    assert_same_point(two_ranks, law_scene("dpd", cell))
    assert_same_point(two_ranks, law_scene("snm", cell))


def test_mixed_numbers_are_written_out() -> None:
    lines = ["A A dpd 25.0 1.0 1.0", "B B dpd 30.0 1.0 20.0"]
    scene = make_scene({"A": 50, "B": 50}, lines, cell=5.0, control={"vdw_mix_method": "lorentz-berthelot"})
    text = "\n".join(translate(scene, 1).after)
    mixed = scene.pairs[1]
    assert f"pair_coeff 1 2 harmonic/cut {0.5 * mixed.parameters[0]:.17g} 1" in text
    assert f"pair_coeff 1 2 dpd/tstat {mixed.drag:.17g} 1" in text


@pytest.mark.parametrize("exponent", [2.0, 1.0, 0.5])
def test_drag(team: ProcessTeam, exponent: float) -> None:
    """At T = 0 there is no noise: what is left of drag must be −γ (1 − r/rc)^s (r̂·v) r̂."""
    rng = np.random.default_rng(3)
    positions, velocities = (rng.random((300, 3)) - 0.5) * 5.0, rng.normal(size=(300, 3))
    scene = make_scene(
        {"A": 300},
        ["A A dpd 25.0 1.0 4.5 1.2"],
        cell=5.0,
        positions=positions,
        velocities=velocities,
        control={"ensemble_dpd_exponent": f"{exponent}", "cutoff": "1.2 ang"},
    )
    pairs = tuple(dataclasses.replace(pair, noise=0.0) for pair in scene.pairs)
    cold = dataclasses.replace(scene, pairs=pairs, dynamics=dataclasses.replace(scene.dynamics, thermal_energy=0.0))
    seen, forces = lammps_point(team, cold)
    apart = positions[:, None] - positions[None, :]
    apart -= 5.0 * np.rint(apart / 5.0)
    r = np.linalg.norm(apart, axis=2) + 10.0 * np.eye(300)
    unit = apart / r[:, :, None]
    along = np.einsum("ijk,ijk->ij", unit, velocities[:, None] - velocities[None, :])
    reach = scene.pairs[0].drag_cutoff
    drag = -scene.pairs[0].drag * np.clip(1.0 - r / reach, 0.0, None) ** exponent * along
    soft = 25.0 * np.clip(1.0 - r, 0.0, None)
    expected = np.einsum("ij,ijk->ik", drag + soft, unit)
    assert np.abs(forces - expected).max() <= EXACT * np.abs(expected).max()
    for part, force in (("drag", drag), ("conservative", soft)):
        virial = 0.5 * np.einsum("ij,ija,ijb->ab", force, unit, apart)
        assert np.abs(seen[part] - virial).max() <= 1e-9 * np.abs(virial).max(), part


# Bonded laws

LENGTH, COPIES = 5, 50
PAIRS = ("H H dpd 25.0 1.0", "H T dpd 50.0 1.0", "T T dpd 25.0 1.0")
BOX = np.array([[6.0, 0, 0], [1.7, 5.5, 0], [-1.2, 2.1, 6.3]])


def bonded_scene(kind: str, key: str, numbers: tuple[float, ...], *, bonds: bool = True) -> Scene:
    """Short chains; dihedrals have their 1-4 factors as numbers 4 and 5."""
    width = {"bond": 2, "angle": 3, "dihedral": 4}[kind]
    values = [repr(x) for x in numbers]
    if kind == "dihedral" and len(values) > 3:
        values[3:3] = ["0.0", "0.0"]
    rows = [
        f"{key} {' '.join(str(k + a) for a in range(width))} {' '.join(values)}" for k in range(1, LENGTH - width + 2)
    ]
    blocks = {BLOCKS[kind]: rows}
    if kind != "bond" and bonds:
        blocks = {"bonds": [f"harm {k} {k + 1} 64.0 0.5" for k in range(1, LENGTH)], **blocks}
    charged = {"charges": (1.0, -1.0, 0.5, 0.5, -1.0), "control": {"coul_bjerrum_length": "1.1 ang"}}
    return molecule_scene(
        "HTTTT",
        blocks,
        chains(COPIES, LENGTH, BOX, seed=11),
        copies=COPIES,
        pairs=PAIRS,
        cell=BOX,
        **(charged if key == "coul" else {}),  # type: ignore[arg-type]
    )


TRANSLATED = sorted(BONDED_STYLES)


def test_only_laws_of_the_registry_are_translated() -> None:
    assert set(BONDED_STYLES) <= {(law["kind"], law["key"]) for law in _core.bonded_laws()}


@pytest.mark.parametrize(("kind", "key"), TRANSLATED, ids=[f"{kind}-{key}" for kind, key in TRANSLATED])
def test_bonded_laws(team: ProcessTeam, kind: str, key: str) -> None:
    assert_same_point(team, bonded_scene(kind, key, BONDED_ROWS[kind, key].numbers))


@pytest.mark.parametrize("kind", ["bond", "angle", "dihedral"])
def test_bonded_terms_across_the_border_of_ranks(two_ranks: ProcessTeam, kind: str) -> None:
    assert_same_point(two_ranks, bonded_scene(kind, "harm", BONDED_ROWS[kind, "harm"].numbers))


NATURAL = {
    ("angle", "cos"): (5.0, 0.0, 1.0),
    ("dihedral", "opls"): (0.0, 3.0, -1.0, 2.0, 0.0),
    ("dihedral", "cos"): (3.0, 40.0, 2.5),
}


@pytest.mark.parametrize(("kind", "key"), NATURAL, ids=[f"{kind}-{key}" for kind, key in NATURAL])
def test_laws_whose_style_depends_on_their_numbers(team: ProcessTeam, kind: str, key: str) -> None:
    scene = bonded_scene(kind, key, NATURAL[kind, key])
    assert scene.bonded is not None
    assert bonded_formula(scene.bonded.terms[-1])
    assert_same_point(team, scene)


def test_excluded_pairs_without_bonds_between_them(team: ProcessTeam) -> None:
    """Angles alone exclude their ends; LAMMPS gets bonds without a force."""
    scene = bonded_scene("angle", "harm", (5.0, 110.0), bonds=False)
    assert "zero" in " ".join(translate(scene, 1).before)
    assert_same_point(team, scene)


def test_restraints_keep_pair_forces(team: ProcessTeam) -> None:
    blocks = {"bonds": [f"-hrm {k} {k + 1} 64.0 0.5" for k in range(1, LENGTH)]}
    positions = chains(COPIES, LENGTH, BOX, seed=11)
    scene = molecule_scene("HTTTT", blocks, positions, copies=COPIES, pairs=PAIRS, cell=BOX)
    assert_same_point(team, scene)


def test_scaled_ends_of_dihedrals(team: ProcessTeam) -> None:
    blocks = {
        "bonds": [f"harm {k} {k + 1} 64.0 0.5" for k in range(1, LENGTH)],
        "angles": [f"harm {k} {k + 1} {k + 2} 12.0 140.0" for k in range(1, LENGTH - 1)],
        "dihedrals": [f"cos {k} {k + 1} {k + 2} {k + 3} 3.0 40.0 2.0 0.0 0.4" for k in range(1, LENGTH - 2)],
    }
    positions = chains(COPIES, LENGTH, BOX, seed=11)
    scene = molecule_scene("HTTTT", blocks, positions, copies=COPIES, pairs=PAIRS, cell=BOX)
    assert scene.bonded is not None
    assert len(scene.bonded.scaled)
    assert_same_point(team, scene)


def test_bonds_with_and_without_pair_forces_are_refused() -> None:
    blocks = {"bonds": ["harm 1 2 64.0 0.5", "-hrm 2 3 64.0 0.5"]}
    positions = chains(COPIES, 3, BOX, seed=11)
    scene = molecule_scene("HTT", blocks, positions, copies=COPIES, pairs=PAIRS, cell=BOX)
    with pytest.raises(SceneError, match=r"FIELD:\d+: bonds that leave their beads the pair forces"):
        translate(scene, 1)


UNTRANSLATED = sorted(
    key for key in BONDED_ROWS if key not in BONDED_STYLES and key[0] in ("angle", "inversion", "tether")
)


@pytest.mark.parametrize(("kind", "key"), UNTRANSLATED, ids=[f"{kind}-{key}" for kind, key in UNTRANSLATED])
def test_bonded_laws_that_are_refused(kind: str, key: str) -> None:
    """By name, with the line that asks for them."""
    width = {"angle": 3, "inversion": 4, "tether": 1}[kind]
    directive = {"angle": "angles", "inversion": "inversions", "tether": "teth"}[kind]
    numbers = " ".join(map(repr, BONDED_ROWS[kind, key].numbers))
    blocks = {directive: [f"{key} {' '.join(str(k) for k in range(1, width + 1))} {numbers}"]}
    scene = molecule_scene("HTTTT", blocks, chains(5, LENGTH, BOX, seed=1), copies=5, pairs=PAIRS, cell=BOX)
    with pytest.raises(SceneError, match=rf"FIELD:13: the {kind} law {key} cannot be run with the engine lammps"):
        translate(scene, 1)


def test_every_bonded_law_is_translated_or_refused_with_a_reason() -> None:
    for law in _core.bonded_laws():
        assert BONDED_STYLES.get((law["kind"], law["key"])) is not None or why_refused(law["kind"], law["key"])


def test_tables_are_refused() -> None:
    scene = law_scene("lj")
    table = dataclasses.replace(scene.pairs[0], law="tab", parameters=(), table=np.ones((2, 9)), table_spacing=0.1)
    with pytest.raises(SceneError, match=r"FIELD:10: the pair law tab of A-A cannot be run .*interpolates"):
        translate(dataclasses.replace(scene, pairs=(table,)), 1)
