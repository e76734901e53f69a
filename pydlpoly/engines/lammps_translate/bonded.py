"""Bonded laws as styles of LAMMPS: its own where it has the law, a formula of its package LEPTON otherwise.

Refused are tables, which LAMMPS interpolates otherwise, angles whose energy depends on the distances, inversions and
tethers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pydlpoly.engines.lammps_translate.formulas import fill, number
from pydlpoly.engines.lammps_translate.refusal import Places, refusal
from pydlpoly.scene.bonded_laws import bonded_laws
from pydlpoly.scene.model import Bonded, BondedKind, BondedTerm, Scene

Numbers = tuple[float, ...]


@dataclass(frozen=True)
class BondedStyle:
    """What a bonded law becomes.

    Attributes:
        formula: in the law's parameters by name, and r, theta or phi (radians).
        style: LAMMPS's own style of the law, empty where there is none.
        coefficients: its words from the law's numbers, or None where these numbers are none of the style's.
    """

    formula: str
    style: str = ""
    coefficients: Callable[[Numbers], str | None] | None = None


def _words(*values: float | str) -> str:
    return " ".join(value if isinstance(value, str) else number(value) for value in values)


def _cosine_angle(given: Numbers) -> str | None:
    amplitude, phase, waves = given
    return _words(amplitude) if phase == 0.0 and waves == 1.0 else None


def _cosine_dihedral(given: Numbers) -> str | None:
    amplitude, phase, waves = given
    return _words("1", amplitude, str(int(waves)), math.degrees(phase)) if waves.is_integer() and waves >= 0 else None


def _opls(given: Numbers) -> str | None:
    constant, first, second, third, phase = given
    return _words(first, second, third, 0.0) if constant == 0.0 and phase == 0.0 else None


_MM3 = (1.0, -2.55, 7.0 / 12.0 * 2.55 * 2.55)
_RYCKAERT = (1.116, -1.462, -1.578, 0.368, 3.156, 3.788)
_OPLS = "{A0}+{A1}/2*(1+cos(phi-{phi0}))+{A2}/2*(1-cos(2*(phi-{phi0})))+{A3}/2*(1+cos(3*(phi-{phi0})))"

BONDED_STYLES: dict[tuple[BondedKind, str], BondedStyle | None] = {
    ("bond", "harm"): BondedStyle("{k}/2*(r-{r0})^2", "harmonic", lambda p: _words(0.5 * p[0], p[1])),
    ("bond", "mors"): BondedStyle("{E0}*((1-exp(-{k}*(r-{r0})))^2-1)"),
    ("bond", "12-6"): BondedStyle("{A}/r^12-{B}/r^6"),
    ("bond", "lj"): BondedStyle("4*{eps}*(({sig}/r)^12-({sig}/r)^6)"),
    ("bond", "rhrm"): BondedStyle(
        "{k}/2*min(abs(r-{r0}),{rc})^2+{k}*{rc}*max(0,abs(r-{r0})-{rc})",
    ),
    ("bond", "quar"): BondedStyle(
        "{k}/2*(r-{r0})^2+{k'}/3*(r-{r0})^3+{k''}/4*(r-{r0})^4",
        "class2",
        lambda p: _words(p[1], p[0] / 2.0, p[2] / 3.0, p[3] / 4.0),
    ),
    ("bond", "buck"): BondedStyle("{A}*exp(-r/{rho})-{C}/r^6"),
    ("bond", "coul"): BondedStyle("{k}/r"),
    ("bond", "fene"): BondedStyle("-{k}*{R0}^2/2*log(1-((r-{D})/{R0})^2)"),
    ("bond", "mmst"): BondedStyle(
        "{k}*(r-{r0})^2*(1-2.55*(r-{r0})+7/12*2.55^2*(r-{r0})^2)",
        "class2",
        lambda p: _words(p[1], *(p[0] * factor for factor in _MM3)),
    ),
    ("angle", "harm"): BondedStyle(
        "{k}/2*(theta-{th0})^2", "harmonic", lambda p: _words(0.5 * p[0], math.degrees(p[1]))
    ),
    ("angle", "quar"): BondedStyle(
        "{k}/2*(theta-{th0})^2+{k'}/3*(theta-{th0})^3+{k''}/4*(theta-{th0})^4",
        "quartic",
        lambda p: _words(math.degrees(p[1]), p[0] / 2.0, p[2] / 3.0, p[3] / 4.0),
    ),
    ("angle", "hcos"): BondedStyle(
        "{k}/2*(cos(theta)-cos({th0}))^2", "cosine/squared", lambda p: _words(0.5 * p[0], math.degrees(p[1]))
    ),
    ("angle", "cos"): BondedStyle("{A}*(1+cos({m}*theta-{delta}))", "cosine", _cosine_angle),
    ("angle", "mmbd"): BondedStyle(
        "{k}*(theta-{th0})^2*(1-0.014*(theta-{th0})+5.6e-5*(theta-{th0})^2-7e-7*(theta-{th0})^3+2.2e-8*(theta-{th0})^4)"
    ),
    ("dihedral", "cos"): BondedStyle(
        "{A}*(1+cos({m}*(phi-2*{pi}*step(phi-{pi}))-{delta}))",  # LAMMPS counts phi from 0 to 2 pi
        "fourier",
        _cosine_dihedral,
    ),
    ("dihedral", "harm"): BondedStyle(
        "{k}/2*acos(cos(phi-{phi0}))^2", "quadratic", lambda p: _words(0.5 * p[0], math.degrees(p[1]))
    ),
    ("dihedral", "hcos"): BondedStyle("{k}/2*(cos(phi)-cos({phi0}))^2"),
    ("dihedral", "cos3"): BondedStyle(
        "{A1}/2*(1+cos(phi))+{A2}/2*(1-cos(2*phi))+{A3}/2*(1+cos(3*phi))", "opls", lambda p: _words(*p, 0.0)
    ),
    ("dihedral", "ryck"): BondedStyle(
        "{A}*(1.116-1.462*cos(phi)-1.578*cos(phi)^2+0.368*cos(phi)^3+3.156*cos(phi)^4+3.788*cos(phi)^5)",
        "nharmonic",
        lambda p: _words("6", *(p[0] * factor for factor in _RYCKAERT)),
    ),
    ("dihedral", "rbf"): BondedStyle(
        "{A}*(3.55-2.78*cos(phi)-3.56*cos(phi)^2-1.64*cos(phi)^3+7.13*cos(phi)^4+12.84*cos(phi)^5"
        "+9.67*exp(-56*(abs(phi)-{pi})^2))"
    ),
    ("dihedral", "opls"): BondedStyle(_OPLS, "opls", _opls),
}
"""The laws that are translated; ``REFUSED_BECAUSE`` has the others."""

REFUSED_BECAUSE: dict[str, str] = {
    "tab": "LAMMPS interpolates tables otherwise, and forces would differ",
    "angle": "its energy depends on distances, too",
    "inversion": "LAMMPS defines its impropers otherwise",
    "tether": "tethers are not translated",
}

SOMETIMES: frozenset[tuple[BondedKind, str]] = frozenset({("angle", "cos"), ("dihedral", "cos"), ("dihedral", "opls")})
"""Laws whose style takes some of their numbers only."""

SECTIONS: dict[BondedKind, str] = {"bond": "Bonds", "angle": "Angles", "dihedral": "Dihedrals"}
_LEPTON = {"bond": "lepton no_offset", "angle": "lepton no_offset", "dihedral": "lepton"}
_NO_OFFSET = {"bond": "0.0", "angle": "0.0", "dihedral": ""}
DUMMY = "zero"


@dataclass(frozen=True)
class BondedPart:
    """The bonded terms in LAMMPS's words.

    Attributes:
        styles: commands before the data file is read; ``coefficients``: after it.
        rows: (n, 1 + k) types and ids, both counted from 1, by section of the data file.
        types: number of types by section.
    """

    styles: tuple[str, ...]
    coefficients: tuple[str, ...]
    rows: dict[str, NDArray[np.int64]]
    types: dict[str, int]


def bonded_part(scene: Scene, bonded: Bonded, dummies: NDArray[np.int64], places: Places) -> BondedPart:
    """Return styles, numbers and terms.

    Args:
        scene: for messages and the beads that are frozen.
        bonded: the terms.
        dummies: (n, 2) ids of pairs that get a bond without a force, which excludes their pair forces.
        places: where lines stand.

    Raises:
        SceneError: a law that is refused, or a term of frozen beads alone.
    """
    used: dict[BondedKind, list[str]] = {}
    coefficients: list[str] = []
    rows: dict[str, list[NDArray[np.int64]]] = {}
    types: dict[str, int] = {}
    chosen = [(term, *_style_of(term, places)) for term in bonded.terms]
    for term, style, numbers in chosen:
        if scene.beads.frozen[term.beads].all(axis=1).any():
            raise refusal(f"a {term.kind} of frozen beads alone cannot be run", places.of_text(term.explanation))
        section = SECTIONS[term.kind]
        types[section] = types.get(section, 0) + 1
        if style not in used.setdefault(term.kind, []):
            used[term.kind].append(style)
        coefficients.append(f"{term.kind}_coeff {types[section]} {style} {numbers}")
        rows.setdefault(section, []).append(_rows(types[section], term.beads))
    if len(dummies):
        types["Bonds"] = types.get("Bonds", 0) + 1
        used.setdefault("bond", []).append(DUMMY)
        coefficients.append(f"bond_coeff {types['Bonds']} {DUMMY}")
        rows.setdefault("Bonds", []).append(_rows(types["Bonds"], dummies))
    styles = []
    for kind, names in used.items():
        words = [_LEPTON[kind] if name == "lepton" else name for name in names]
        styles.append(f"{kind}_style hybrid {' '.join(words)}")
    stacked = {section: np.concatenate(parts) for section, parts in rows.items()}
    return BondedPart(tuple(styles), tuple(coefficients), stacked, types)


def formula_of(term: BondedTerm) -> str:
    """Return U of a term's law in the words of LEPTON."""
    entry = BONDED_STYLES[term.kind, term.law]
    assert entry is not None
    given = dict(zip(bonded_laws()[term.kind, term.law].parameter_names, term.parameters, strict=True))
    if given.get("rho") == 0.0:  # dispersion alone
        given["rho"] = 1.0
    return fill(entry.formula, pi=math.pi, **given)


def why_refused(kind: str, law: str) -> str:
    """Return in words why a law is not translated."""
    return REFUSED_BECAUSE["tab"] if law == "tab" else REFUSED_BECAUSE.get(kind, "it is not translated")


def _style_of(term: BondedTerm, places: Places) -> tuple[str, str]:
    entry = BONDED_STYLES.get((term.kind, term.law))
    if entry is None:
        where = places.of_text(term.explanation)
        raise refusal(f"the {term.kind} law {term.law} cannot be run", where, why_refused(term.kind, term.law))
    if entry.coefficients is not None:
        words = entry.coefficients(term.parameters)
        if words is not None:
            return entry.style, words
    start = _NO_OFFSET[term.kind]
    return "lepton", f'{start} "{formula_of(term)}"'.strip()


def _rows(number_of_type: int, beads: NDArray[np.integer]) -> NDArray[np.int64]:
    ids = np.asarray(beads, dtype=np.int64) + 1
    return np.column_stack([np.full(len(ids), number_of_type, dtype=np.int64), ids])
