"""Every bonded law: its record, its slope, forces against the slope of the energy, units, places without a direction.

``ROWS`` is the reference table: a law that is not in it fails a test.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from pydlpoly import Scene, _core, single_point
from pydlpoly.formats.records import FloatArray

from .molecule_builder import molecule_scene


class Row(NamedTuple):
    """FIELD's numbers of a law, and which of them are energies and degrees."""

    numbers: tuple[float, ...]
    energies: str
    degrees: str = ""


ROWS: dict[tuple[str, str], Row] = {
    ("bond", "harm"): Row((12.0, 0.9), "k"),
    ("bond", "mors"): Row((5.0, 0.9, 1.7), "E0"),
    ("bond", "12-6"): Row((2.0, 3.0), "A B"),
    ("bond", "lj"): Row((2.0, 0.9), "eps"),
    ("bond", "rhrm"): Row((12.0, 0.8, 0.2), "k"),
    ("bond", "quar"): Row((12.0, 0.9, -5.0, 7.0), "k k' k''"),
    ("bond", "buck"): Row((40.0, 0.4, 1.5), "A C"),
    ("bond", "coul"): Row((2.0,), ""),
    ("bond", "fene"): Row((12.0, 2.4, 0.2), "k"),
    ("bond", "mmst"): Row((12.0, 0.9), "k"),
    ("angle", "harm"): Row((5.0, 110.0), "k", "th0"),
    ("angle", "quar"): Row((5.0, 110.0, -2.0, 1.5), "k k' k''", "th0"),
    ("angle", "thrm"): Row((5.0, 110.0, 1.3), "k", "th0"),
    ("angle", "shrm"): Row((5.0, 110.0, 1.3, 0.8), "k", "th0"),
    ("angle", "bvs1"): Row((5.0, 110.0, 1.3, 0.8), "k", "th0"),
    ("angle", "bvs2"): Row((0.5, 110.0, 1.6, 1.3), "k", "th0"),
    ("angle", "hcos"): Row((5.0, 110.0), "k", "th0"),
    ("angle", "cos"): Row((5.0, 40.0, 3.0), "A", "delta"),
    ("angle", "mmsb"): Row((5.0, 110.0, 0.9, 1.2), "A", "th0"),
    ("angle", "stst"): Row((5.0, 0.9, 1.2), "A"),
    ("angle", "stbe"): Row((5.0, 110.0, 0.9), "A", "th0"),
    ("angle", "cmps"): Row((5.0, 3.0, -2.0, 110.0, 0.9, 1.2), "A B C", "th0"),
    ("angle", "mmbd"): Row((5.0, 110.0), "k", "th0"),
    ("angle", "kky"): Row((5.0, 110.0, 2.5, 1.1), "fk", "th0"),
    ("dihedral", "cos"): Row((3.0, 40.0, 2.0), "A", "delta"),
    ("dihedral", "harm"): Row((3.0, 150.0), "k", "phi0"),
    ("dihedral", "hcos"): Row((3.0, 150.0), "k", "phi0"),
    ("dihedral", "cos3"): Row((3.0, -1.0, 2.0), "A1 A2 A3"),
    ("dihedral", "ryck"): Row((3.0,), "A"),
    ("dihedral", "rbf"): Row((3.0,), "A"),
    ("dihedral", "opls"): Row((1.0, 3.0, -1.0, 2.0, 25.0), "A0 A1 A2 A3", "phi0"),
    ("inversion", "harm"): Row((3.0, 20.0), "k", "phi0"),
    ("inversion", "hcos"): Row((3.0, 20.0), "k", "phi0"),
    ("inversion", "plan"): Row((3.0,), "A"),
    ("inversion", "xpln"): Row((3.0, 2.0, 20.0), "k", "phi0"),
    ("inversion", "calc"): Row((3.0, -1.5), "A B"),
    ("tether", "harm"): Row((12.0,), "k"),
    ("tether", "rhrm"): Row((12.0, 0.2), "k"),
    ("tether", "quar"): Row((12.0, -5.0, 7.0), "k k' k''"),
}
LAWS = {(law["kind"], law["key"]): law for law in _core.bonded_laws() if not law["table"]}
DIRECTIVES = {"bond": "bonds", "angle": "angles", "dihedral": "dihedrals", "inversion": "inversions", "tether": "teth"}
BEADS = {"bond": 2, "angle": 3, "dihedral": 4, "inversion": 4, "tether": 1}
EVERY = pytest.mark.parametrize(("kind", "key"), sorted(ROWS), ids=[f"{kind}-{key}" for kind, key in sorted(ROWS)])


def test_the_table_is_complete() -> None:
    assert set(ROWS) == set(LAWS)
    tables = [law for law in _core.bonded_laws() if law["table"]]  # tests/test_bonded_tables.py has these
    assert [(law["kind"], law["key"], law["restraint_key"]) for law in tables] == [
        (kind, "tab", "-tab") for kind in ("bond", "angle", "dihedral", "inversion")
    ]
    keys = [(law["kind"], key) for law in _core.bonded_laws() for key in (law["key"], law["restraint_key"]) if key]
    assert len(keys) == len(set(keys))


@EVERY
def test_records(kind: str, key: str) -> None:
    law, row = LAWS[kind, key], ROWS[kind, key]
    names = law["parameter_names"]
    assert len(names) == len(row.numbers)
    assert [n for k, n in enumerate(names) if law["energy_mask"] >> k & 1] == row.energies.split()
    assert [n for k, n in enumerate(names) if law["degree_mask"] >> k & 1] == row.degrees.split()
    assert (law["restraint_key"] == "") == (kind == "tether")
    with pytest.raises(
        ValueError, match=rf"^{kind} law {key} takes {len(names)} numbers \(.*\), not {len(names) + 1}$"
    ):
        evaluate(kind, key, (*row.numbers, 1.0), np.ones((1, 3 if kind == "angle" else 1)))
    for k in range(len(names)):
        bad = [*row.numbers]
        bad[k] = np.nan
        with pytest.raises(ValueError, match=rf"\(number {k + 1}\) must be a finite number, not nan$"):
            evaluate(kind, key, bad, np.ones((1, 3 if kind == "angle" else 1)))


def evaluate(kind: str, key: str, numbers: object, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    return _core.evaluate_bonded(kind, key, list(numbers), at)  # type: ignore[call-overload, no-any-return]


def internal(kind: str, key: str) -> list[float]:
    """The law's numbers with angles in radians."""
    mask = LAWS[kind, key]["degree_mask"]
    return [np.radians(x) if mask >> k & 1 else x for k, x in enumerate(ROWS[kind, key].numbers)]


@EVERY
def test_slopes(kind: str, key: str) -> None:
    """All derivatives of U against a difference of fourth order, over the whole range of the coordinate."""
    rng = np.random.default_rng(4)
    if kind == "angle":
        at = np.column_stack([rng.uniform(0.3, 3.0, 60), rng.uniform(0.6, 1.8, (60, 2))])
    else:
        low, high = {"dihedral": (-3.1, 3.1), "inversion": (0.05, 1.5)}.get(kind, (0.7, 1.9))
        at = rng.uniform(low, high, (60, 1))
    numbers, h = internal(kind, key), 1e-3
    _, slopes = evaluate(kind, key, numbers, at)
    for k in range(at.shape[1]):
        step = np.zeros(at.shape[1])
        step[k] = h
        energy = [evaluate(kind, key, numbers, at + n * step)[0] for n in (-2, -1, 1, 2)]
        wanted = (energy[0] - 8.0 * energy[1] + 8.0 * energy[2] - energy[3]) / (12.0 * h)
        smooth = ~np.isclose(at[:, 0], ROWS[kind, key].numbers[-1], atol=0.01)
        if key == "rhrm":  # its third derivative jumps where the spring turns into a constant pull
            smooth = np.abs(np.abs(at[:, 0] - (0.8 if kind == "bond" else 0.0)) - 0.2) > 3 * h
        assert np.abs(slopes[smooth, k] - wanted[smooth]).max() <= 1e-7 * max(1.0, np.abs(slopes).max())


PLACES = np.array([[0.1, 0.2, -0.1], [1.0, 0.5, 0.3], [1.3, 1.4, -0.2], [2.2, 1.3, 0.6]])


def scene_of(
    kind: str, key: str, *, restraint: bool = False, positions: FloatArray = PLACES, units: str = "dpd"
) -> Scene:
    """Four beads with one term of the law (bonds: three) and no pair laws; the box splits them."""
    law, numbers = LAWS[kind, key], [f"{x!r}" for x in ROWS[kind, key].numbers]
    if kind == "dihedral":
        numbers = [*numbers[:3], *["0"] * (3 - len(numbers[:3])), "0", "0", *numbers[3:]]
    word = law["restraint_key"] if restraint else key
    starts = (1, 2, 3) if kind == "bond" else (1,)
    lines = [" ".join([word, *(str(i + k) for k in range(BEADS[kind])), *numbers]) for i in starts]
    charged = key == "coul"
    return molecule_scene(
        "ABCD",
        {DIRECTIVES[kind]: lines},
        positions,
        cell=[8.0, 7.0, 9.0],
        units=units,
        charges=(1.0, -0.5, 2.0, 1.0) if charged else (),
        control={"coul_bjerrum_length": "1.0 dpd_l"} if charged else {},
    )


def moved(scene: Scene, positions: FloatArray) -> Scene:
    """The same terms, tethers' anchors included, with the beads elsewhere."""
    return replace(scene, beads=replace(scene.beads, positions=positions))


@EVERY
@pytest.mark.parametrize("shift", [0.0, 3.6], ids=["inside", "across"])
def test_force_is_the_slope_of_the_energy(kind: str, key: str, shift: float) -> None:
    rng = np.random.default_rng(6)
    scene = scene_of(kind, key, positions=PLACES + shift)
    start = scene.beads.positions + (rng.uniform(0.1, 0.4, (4, 3)) if kind == "tether" else 0.0)
    if shift == 0.0 and kind == "inversion":  # both sides of the plane
        start = start * np.array([1.0, 1.0, -1.0])
    point, h = single_point(moved(scene, start)), 1e-3
    assert np.abs(point.forces).max() > 1e-3
    for bead in range(4):
        for axis in range(3):
            energy = []
            for n in (-2, -1, 1, 2):
                places = start.copy()
                places[bead, axis] += n * h
                energy.append(single_point(moved(scene, places)).energy[kind])
            slope = (energy[0] - 8.0 * energy[1] + 8.0 * energy[2] - energy[3]) / (12.0 * h)
            assert point.forces[bead, axis] == pytest.approx(-slope, abs=1e-7 * np.abs(point.forces).max())


@EVERY
def test_momentum_torque_and_virial(kind: str, key: str) -> None:
    if kind == "tether":
        pytest.skip("a tether holds a bead to a place")
    scene = scene_of(kind, key)
    point = single_point(scene)
    assert np.abs(point.forces.sum(axis=0)).max() <= 1e-13
    largest = max(1.0, np.abs(point.forces).max())
    # The box splits the beads; their places relative to each other are those they were made from.
    assert np.abs(np.cross(PLACES, point.forces).sum(axis=0)).max() <= 1e-11 * largest
    volume = abs(np.linalg.det(scene.cell))
    wanted = PLACES.T @ point.forces
    assert point.stress * volume == pytest.approx(wanted, abs=1e-11 * largest)
    assert point.virial == pytest.approx(-wanted.trace(), abs=1e-11 * largest)
    if kind in ("dihedral", "inversion") and key != "calc":
        assert point.virial == pytest.approx(0.0, abs=1e-11 * largest)


@EVERY
def test_energy_units_and_restraint_form(kind: str, key: str) -> None:
    point, in_kj = single_point(scene_of(kind, key)), single_point(scene_of(kind, key, units="kj"))
    unit = 100.0 if ROWS[kind, key].energies else 1.0  # a Coulomb bond's strength is k_B T times a length
    assert in_kj.energy[kind] == pytest.approx(unit * point.energy[kind], rel=1e-12)
    assert in_kj.forces == pytest.approx(unit * point.forces, rel=1e-10, abs=1e-10)
    if kind != "tether":
        scene = scene_of(kind, key, restraint=True)
        assert scene.bonded is not None
        assert len(scene.bonded.excluded) == 0
        restrained = single_point(scene)
        assert restrained.energy == point.energy
        assert np.array_equal(restrained.forces, point.forces)


def test_values_by_hand() -> None:
    """Numbers from pocket arithmetic, one of each kind of expression."""

    def value(kind: str, key: str, numbers: list[float], *at: float) -> float:
        return float(evaluate(kind, key, numbers, np.array([at]))[0][0])

    half = np.pi / 2.0
    assert value("bond", "harm", [128.0, 0.5], 0.75) == 4.0
    assert value("bond", "rhrm", [2.0, 1.0, 0.5], 2.0) == pytest.approx(0.25 + 0.5)
    assert value("bond", "fene", [2.0, 2.0, 0.0], 1.0) == pytest.approx(-4.0 * np.log(0.75))
    assert value("bond", "mmst", [1.0, 1.0], 1.5) == pytest.approx(0.25 * (1 - 1.275 + 7 / 12 * 6.5025 * 0.25))
    assert value("angle", "cos", [20.0, 0.0, 1.0], np.pi, 1.0, 1.0) == pytest.approx(0.0, abs=1e-14)
    assert value("angle", "thrm", [2.0, 0.0, 1.0], 1.0, 1.0, 0.0) == pytest.approx(np.exp(-1.0))
    assert value("angle", "kky", [1.0, 0.0, 3.0, 1.0], half, 1.0, 1.0) == pytest.approx(1.0)
    assert value("angle", "cmps", [1.0, 2.0, 3.0, 0.0, 1.0, 1.0], 0.5, 2.0, 3.0) == pytest.approx(2.0 + 0.5 * 8.0)
    assert value("dihedral", "harm", [2.0, 3.0], -3.0) == pytest.approx((2.0 * np.pi - 6.0) ** 2)
    assert value("dihedral", "ryck", [1.0], np.pi) == pytest.approx(1.116 + 1.462 - 1.578 - 0.368 + 3.156 - 3.788)
    assert value("dihedral", "rbf", [1.0], np.pi) == pytest.approx(3.55 + 2.78 - 3.56 + 1.64 + 7.13 - 12.84 + 9.67)
    assert value("dihedral", "rbf", [1.0], -3.1) == pytest.approx(value("dihedral", "rbf", [1.0], 3.1), rel=1e-13)
    assert value("dihedral", "opls", [1.0, 2.0, 3.0, 4.0, 0.0], half) == pytest.approx(1.0 + 1.0 + 3.0 + 2.0)
    assert value("inversion", "xpln", [2.0, 2.0, 0.0], half) == pytest.approx(2.0)
    assert value("inversion", "calc", [2.0, 3.0], 0.5) == pytest.approx(0.5 + 3.0 / 16.0)


def test_angle_of_an_inversion() -> None:
    """A regular pyramid: the three bonds rise out of the planes of the other two by the same angle."""
    corners = np.array([[np.cos(t), np.sin(t), 0.4] for t in 2.0 * np.pi * np.arange(3) / 3.0])
    scene = molecule_scene("ABBB", {"inversions": ["harm 1 2 3 4 2.0 0.0"]}, np.vstack([np.zeros(3), corners]))
    normal = np.cross(corners[1], corners[2])
    sine = corners[0] @ normal / np.linalg.norm(normal) / np.linalg.norm(corners[0])
    assert single_point(scene).energy["inversion"] == pytest.approx(np.arcsin(sine) ** 2, rel=1e-12)
    flat = np.vstack([np.zeros(3), corners * np.array([1.0, 1.0, 0.0])])
    point = single_point(moved(scene, flat))
    assert point.energy["inversion"] == 0.0
    assert not point.forces.any()


STRAIGHT = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.9], [0.0, 0.0, 1.8], [0.0, 0.0, 2.9]])
FOLDED = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.9], [0.0, 0.0, 0.0], [0.5, 0.0, 0.9]])


@EVERY
@pytest.mark.parametrize("positions", [STRAIGHT, FOLDED], ids=["straight", "folded"])
def test_without_a_direction_there_is_no_force_and_no_nan(kind: str, key: str, positions: FloatArray) -> None:
    point = single_point(scene_of(kind, key, positions=positions))
    assert np.isfinite(point.forces).all()
    assert np.isfinite(list(point.energy.values())).all()
    if kind in ("dihedral", "inversion"):
        assert not point.forces.any()
    if kind == "angle" and positions is STRAIGHT:
        assert not point.forces[:, :2].any()


@pytest.mark.parametrize(
    "key", [key for kind, key in ROWS if kind == "bond" and key not in ("12-6", "lj", "buck", "coul")]
)
def test_beads_of_a_bond_may_coincide(key: str) -> None:
    point = single_point(scene_of("bond", key, positions=np.zeros((4, 3))))
    assert not point.forces.any()
    assert np.isfinite(point.energy["bond"])


def test_almost_straight_cosine_angles_are_smooth() -> None:
    """Lipids' law near 180 degrees: U → ½ A δ², force → A δ / r, down to angles of 1e-9."""
    for bend in (1e-3, 1e-6, 1e-9):
        positions = [[0.0, 0.0, -0.5], [0.0, 0.0, 0.0], [0.0, 0.5 * np.sin(bend), 0.5 * np.cos(bend)]]
        scene = molecule_scene("HTT", {"angles": ["-cos 1 2 3 20.0 0.0 1"]}, positions)
        forces = single_point(scene).forces
        assert forces[2, 1] == pytest.approx(-20.0 * np.sin(bend) * np.cos(bend) / 0.5, rel=1e-6)
        assert np.abs(forces.sum(axis=0)).max() <= 1e-13
