"""Electrostatics as styles of LAMMPS.

LAMMPS's ``dielectric`` is one over the strength of two unit charges, so that charges stay in e. Sums without a part in
reciprocal space are formulas (``lepton/coul``) or ``coul/cut``, equal to rounding; Ewald's sums are LAMMPS's own, with
the scene's α and cutoff, and equal to the precision of both sums.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pydlpoly import _core
from pydlpoly.engines.lammps_translate.formulas import fill, number, term
from pydlpoly.engines.lammps_translate.pairs import SubStyle
from pydlpoly.engines.lammps_translate.refusal import Places, refusal
from pydlpoly.scene.model import Electrostatics, Scene

SHAPES: dict[str, str] = {
    "point": "1/r",
    "slater": "(1-(1+r/{L})*exp(-2*r/{L}))/r",
    "slater-exact": "(1-exp(-2*r/{L})*(1+11/8*r/{L}+3/4*(r/{L})^2+(r/{L})^3/6))/r",
    "gaussian": "erf(r/(2*{L}))/r",
    "linear": "",
}
"""u(r) of two unit charges by shape; L is the shape's length. None of ``linear``, which is refused."""

METHODS: dict[str, str] = {
    "pairwise": "`coul/cut` (points) or `lepton/coul`",
    "force_shifted": "`lepton/coul`",
    "reaction_field": "`lepton/coul`",
    "dddp": "`lepton/coul`",
    "ewald": "`coul/long` (points) or `coul/slater/long` (slater), with `kspace_style pppm` or `ewald`",
}
"""What each method becomes."""

EWALD_STYLES = {"point": "coul/long", "slater": "coul/slater/long"}
# Below this LAMMPS's polynomial for erfc says nothing more; above that forces mean little.
_PRECISIONS = 1e-8, 1e-3
_NEUTRAL = 1e-5


@dataclass(frozen=True)
class ChargePart:
    """The electrostatics in LAMMPS's words: the pair sub-style, and commands before and after the pair styles."""

    style: SubStyle
    before: tuple[str, ...]
    after: tuple[str, ...] = ()
    reciprocal: bool = False


def charge_part(scene: Scene, given: Electrostatics, places: Places) -> ChargePart:
    """Return the electrostatics. Raises SceneError for shapes and cells that are refused."""
    before = (f"dielectric {number(1.0 / given.strength)}",)
    where = places.of_setting("charge_smearing_method", "coul_method")
    if given.shape not in SHAPES or not SHAPES[given.shape]:
        raise refusal(f"charges of the shape {given.shape} cannot be run", where)
    if given.method not in METHODS:
        raise refusal(f"coul_method {given.keyword} cannot be run", places.of_setting("coul_method"))
    if given.method == "ewald":
        return _ewald(scene, given, before, places)
    if given.method == "pairwise" and given.shape == "point":
        reach = number(given.cutoff)
        return ChargePart(SubStyle("coul/cut", reach, ("pair_coeff * * coul/cut",)), before)
    reach = number(given.cutoff)
    line = f'pair_coeff * * lepton/coul "qi*qj*({formula_of(given)})" {reach}'
    return ChargePart(SubStyle("lepton/coul", reach, (line,)), before)


def formula_of(given: Electrostatics) -> str:
    """Return the energy of two unit charges of strength 1 in the words of LEPTON."""
    if given.method == "dddp":
        return "1/r^2"
    base = fill(SHAPES[given.shape], L=given.length)
    if given.alpha > 0.0:
        damped = f"erf({term(given.alpha)}*r)/r"
        base = f"erfc({term(given.alpha)}*r)/r" if given.shape == "point" else f"{base}-{damped}"
    if given.method == "pairwise":
        return base
    reach, energy, force = given.cutoff, *_end(given)
    if given.method == "force_shifted":
        return f"{base}-{term(energy)}+{term(force)}*(r-{term(reach)})"
    field = 2.0 * (given.permittivity - 1.0) / (2.0 * given.permittivity + 1.0) / reach**3
    slope = force if given.alpha > 0.0 else 0.0
    return f"{base}-{term(energy)}+{term(slope)}*(r-{term(reach)})+{term(0.5 * field)}*(r^2-{term(reach * reach)})"


def _end(given: Electrostatics) -> tuple[float, float]:
    """Return energy and force of two unit charges, damped, at the cutoff."""
    numbers = _core.ChargeNumbers()
    numbers.cutoff, numbers.alpha, numbers.permittivity = 2.0 * given.cutoff, given.alpha, 1.0
    method = "ewald" if given.alpha > 0.0 else "pairwise"
    energies, factors = _core.evaluate_charge(method, given.shape, given.length, numbers, [given.cutoff])
    return float(energies[0]), float(factors[0]) * given.cutoff


def _ewald(scene: Scene, given: Electrostatics, before: tuple[str, ...], places: Places) -> ChargePart:
    where = places.of_setting("coul_method")
    style = EWALD_STYLES.get(given.shape)
    if style is None:
        message = f"Ewald's sum of charges of the shape {given.shape} cannot be run"
        raise refusal(message, places.of_setting("charge_smearing_method"))
    if abs(math.fsum(scene.beads.charge.tolist())) > _NEUTRAL:
        raise refusal("Ewald's sum of charges that do not add up to zero cannot be run", where)
    if scene.beads.frozen.any():
        raise refusal("Ewald's sum with frozen beads cannot be run", where)
    if given.shape == "slater" and scene.bonded is not None and len(scene.bonded.excluded):
        raise refusal("Ewald's sum of smeared charges with pairs that bonds exclude cannot be run", where)
    # What the part between pairs loses at its end; the part over vectors need not be better.
    lost = math.exp(-((given.alpha * given.cutoff) ** 2))
    precision = float(np.clip(lost, *_PRECISIONS))
    arguments = f"{number(given.length)} {number(given.cutoff)}" if given.shape == "slater" else number(given.cutoff)
    coefficient = f"pair_coeff * * {style}"
    modify = (f"pair_modify pair {style} table 0",)
    kspace = "pppm" if given.order else "ewald"
    after = (f"kspace_style {kspace} {number(precision)}", f"kspace_modify gewald {number(given.alpha)}")
    return ChargePart(SubStyle(style, arguments, (coefficient,), modify), before, after, reciprocal=True)
