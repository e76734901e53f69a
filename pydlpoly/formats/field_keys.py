"""The words a DL_POLY FIELD file may use: directives by their significant prefix, and the keys of every law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

TOP_DIRECTIVES: Mapping[str, str] = {
    "units": "units",
    "molecul": "molecules",
    "vdw": "vdw",
    "rdf": "rdf",
    "extern": "external",
    "metal": "metal",
    "tersoff": "tersoff",
    "tbp": "tbp",
    "fbp": "fbp",
    "crd": "crd",
    "kim": "kim_init",
    "neut": "neutral",
    "close": "close",
}
"""Directives outside molecules: the letters DL_POLY compares, and the full word."""

KEPT_WHOLE = ("metal", "tersoff", "tbp", "fbp", "crd", "kim_init")
"""Blocks without records of their own; their lines are kept as they stand."""

MOLECULE_DIRECTIVES: Mapping[str, str] = {
    "nummol": "nummols",
    "atoms": "atoms",
    "shell": "shells",
    "constr": "constraints",
    "pmf": "pmf",
    "rigid": "rigid",
    "teth": "tethers",
    "bonds": "bonds",
    "angles": "angles",
    "dihedr": "dihedrals",
    "invers": "inversions",
    "neut": "neutral",
    "finish": "finish",
}
"""Directives inside a molecule, in the same form."""

WRITTEN = {
    "shells": "shell",
    "constraints": "constraints",
    "rigid": "rigid",
    "tethers": "teth",
    "bonds": "bonds",
    "angles": "angles",
    "dihedrals": "dihedrals",
    "inversions": "inversions",
}
"""The word that heads a counted bonded block when a file is written."""


class BondedKind(NamedTuple):
    """What a line of a bonded block looks like: how many bead numbers, and the keys (empty: lines have no key)."""

    beads: int
    keys: frozenset[str] = frozenset()


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


def _with_restraints(pairs: str) -> frozenset[str]:
    """Both forms of each key: plain, and the restraint form that leaves the beads in each other's pair sums."""
    return _words(pairs.replace(",", " "))


BONDED: Mapping[str, BondedKind] = {
    "shells": BondedKind(2),
    "constraints": BondedKind(2),
    "tethers": BondedKind(1, frozenset(("harm", "rhrm", "quar"))),
    "bonds": BondedKind(
        2,
        _with_restraints(
            "harm,-hrm mors,-mrs 12-6,-126 lj,-lj rhrm,-rhm quar,-qur buck,-bck coul,-cul fene,-fne mmst,-mst tab,-tab"
        ),
    ),
    "angles": BondedKind(
        3,
        _with_restraints(
            "harm,-hrm quar,-qur thrm,-thm shrm,-shm bvs1,-bv1 bvs2,-bv2 hcos,-hcs cos,-cos mmsb,-msb stst,-sts "
            "stbe,-stb cmps,-cmp mmbd,-mbd kky,-kky tab,-tab"
        ),
    ),
    "dihedrals": BondedKind(
        4, _with_restraints("cos,-cos harm,-hrm hcos,-hcs cos3,-cs3 ryck,-rck rbf,-rbf opls,-opl tab,-tab")
    ),
    "inversions": BondedKind(4, _with_restraints("harm,-hrm hcos,-hcs plan,-pln xpln,-xpl calc,-clc tab,-tab")),
}
"""Blocks whose lines are ``[key] bead numbers, parameters``."""

PAIR_KEYS = frozenset(
    [
        "12-6",
        "lj",
        "ljc",
        "ljf",
        "nm",
        "snm",
        "buck",
        "bhm",
        "hbnd",
        "mors",
        "mstw",
        "wca",
        "dpd",
        "ndpd",
        "mdpd",
        "14-7",
        "ryd",
        "zbl",
        "zbls",
        "zblb",
        "mlj",
        "mbuc",
        "m126",
        "sand",
        "sw",
        "tab",
    ]
)
"""Pair laws by their first four letters; DL_POLY has ``mdpd`` since its manual of 2024."""

EXTERNAL_KEYS = frozenset(
    ["elec", "oshr", "shrx", "grav", "magn", "sphr", "zbnd", "xpis", "zres", "zrs-", "zrs+", "osel", "ushr", "pois"]
)
"""External fields by their first four letters; pois is pydlpoly's own."""

UNIT_WORDS = ("eV", "kcal", "kJ", "K", "kelvin", "kB", "kT", "internal", "dpd")
"""Spellings of the energy units that messages offer."""


def canonical_unit(word: str) -> str | None:
    """Return the canonical energy unit of a word after ``units``, or None when it is none.

    DL_POLY itself takes every other word that begins with k as kelvin; a mis-spelt kcal would then be wrong by a factor
    of 500, so only the known spellings pass.
    """
    lower = word.lower()
    for prefix, unit in (("ev", "ev"), ("kcal", "kcal"), ("kj", "kj"), ("internal", "internal"), ("dpd", "dpd")):
        if lower.startswith(prefix):
            return unit
    return "k" if lower in ("k", "kb", "kt") or lower.startswith(("kelvin", "boltz", "kboltz")) else None


def canonical_directive(word: str, directives: Mapping[str, str]) -> str | None:
    """Return the full directive that a word begins like, whatever its case, or None."""
    lower = word.lower()
    return next((full for prefix, full in directives.items() if lower.startswith(prefix)), None)
