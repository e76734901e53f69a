"""Electrostatics: which beads are charged, the method, its strength, the shape of the charges, Ewald's numbers."""

from __future__ import annotations

import math

import numpy as np

from pydlpoly import _core
from pydlpoly.formats.records import Field, FloatArray
from pydlpoly.scene.beads import Layout
from pydlpoly.scene.cell import MOST_IMAGES, images_within, widths
from pydlpoly.scene.model import Dynamics, Electrostatics
from pydlpoly.scene.settings import Notes, Settings, place
from pydlpoly.units import COULOMB_CONSTANT

# DL_POLY switches electrostatics off when no charge reaches this.
_UNCHARGED = 1e-5
# Images within the cutoff, of each charge with each other, beyond which a box is a slip.
# Points of a mesh, or half of the plain sum's vectors, that fit into memory.
_MOST_POINTS = 2**27
_MOST_ON_AXIS = 2**21
_MOST_SPLINES = 20
# Precisions above this mean nothing.
_COARSEST = 0.1
# Where smeared charges differ so much from 1/r at the cutoff, a note says so.
_SEEN = 1e-3

_METHODS = {"spme": "ewald", "ewald_direct": "ewald"}
_SHAPES = {
    **dict.fromkeys(("", "none", "off", "point"), "point"),
    **dict.fromkeys(("slater", "slater-approximate"), "slater"),
    **{name: name for name in ("slater-exact", "gaussian", "linear")},
}
_SHAPE_WORDS = "none, slater (also slater-approximate), slater-exact, gaussian or linear"
# β of approximate Slater charges times the smearing length.
_BETAS = {"original": 1.0, "overlap": 0.625}


class Strength:
    """The energy times length of two unit charges, asked for by whatever needs it first.

    Args:
        settings: CONTROL.
        reduced: whether FIELD is in reduced units.
        dynamics: its k_B T belongs to a Bjerrum length.
    """

    def __init__(self, settings: Settings, reduced: bool, dynamics: Dynamics) -> None:
        self._settings, self._reduced, self._thermal = settings, reduced, dynamics.thermal_energy

    def value(self) -> tuple[float, str]:
        """Return the strength in internal units and where it comes from.

        Raises:
            SceneError: it is not given in a scene in reduced units, given twice, or needs a temperature.
        """
        settings = self._settings
        bjerrum, coupling = settings.number("coul_bjerrum_length"), settings.number("coul_coupling")
        given = [name for name in ("coul_bjerrum_length", "coul_coupling") if settings.given(name)]
        if not given:
            if self._reduced:
                message = "in units dpd charges are in e and their strength is that of coul_bjerrum_length, or of "
                message += "coul_coupling = 4 pi times it: CONTROL gives neither"
                raise settings.refusal("coul_method", message)
            permittivity = permittivity_of(settings)
            where = settings.where("coul_dielectric_constant")
            return COULOMB_CONSTANT / permittivity, f"1/(4 pi eps0 eps) with eps = {permittivity:g} [{where}]"
        if len(given) > 1:
            raise settings.refusal(given[1], "says the same as coul_bjerrum_length: give one of them")
        if given[0] == "coul_coupling" and not self._reduced:
            message = "is 4 pi times the Bjerrum length in the cutoff's unit, and belongs to units dpd; give "
            raise settings.refusal("coul_coupling", message + "coul_bjerrum_length or coul_dielectric_constant")
        if settings.given("coul_dielectric_constant") and settings.word("coul_method") != "reaction_field":
            message = f"the permittivity is already in {given[0]}: give one of them"
            raise settings.refusal("coul_dielectric_constant", message)
        length = bjerrum if given[0] == "coul_bjerrum_length" else coupling / (4.0 * math.pi)
        if not (length > 0.0 and math.isfinite(length)):
            raise settings.refusal(given[0], f"must be larger than 0, not {settings.number(given[0]):g}")
        if not self._thermal > 0.0:
            raise settings.refusal(given[0], "is a strength in units of k_B T: the scene needs a temperature above 0")
        text = f"k_B T times the Bjerrum length {length:.9g} from {given[0]} {settings.number(given[0]):g}"
        return length * self._thermal, f"{text} [{settings.where(given[0])}]"


def permittivity_of(settings: Settings) -> float:
    """Return the relative permittivity; SceneError when it is not larger than 0."""
    value = settings.number("coul_dielectric_constant")
    if not (value > 0.0 and math.isfinite(value)):
        raise settings.refusal("coul_dielectric_constant", f"must be larger than 0, not {value:g}")
    return value


def is_charged(layout: Layout) -> bool:
    """Return whether any charge reaches what DL_POLY takes for one (1e-5 e)."""
    return bool((np.abs(layout.charge) >= _UNCHARGED).any())


def charged_names(layout: Layout) -> str:
    """Return the species that have charged beads, as ``Na, Cl``."""
    return ", ".join(layout.species_names[k] for k in np.unique(layout.species[layout.charge != 0.0]))


def resolve_charges(
    settings: Settings,
    field: Field,
    layout: Layout,
    strength: Strength,
    cutoff: float,
    cell: FloatArray,
    imcon: int,
    periodic: tuple[bool, bool, bool],
    fields: bool,
    notes: Notes,
) -> Electrostatics | None:
    """Return the electrostatics, or None when there are no charges or no method.

    Args:
        settings: CONTROL.
        field: FIELD, for messages.
        layout: the beads with their charges.
        strength: of two unit charges.
        cutoff: the global cutoff (Å), where the part between pairs ends.
        cell: (3, 3) cell vectors by row.
        imcon: the shape of the cell; Ewald's sums need 1, 2 or 3.
        periodic: along which cell vectors; walls end periodicity.
        fields: whether an external field acts on charges.
        notes: receives choices and what has no effect.

    Raises:
        SceneError: a method that the cell does not allow, numbers that make no sense, or no strength in reduced units.
    """
    method = settings.word("coul_method")
    if not is_charged(layout):
        if method != "off":
            notes.ignored(f"coul_method {method} has no effect: no bead is charged", settings.where("coul_method"))
        return None
    if method == "off":
        what = "act in the external field alone" if fields else "are ignored"
        notes.warning(
            f"the charges of {charged_names(layout)} {what} because coul_method is off", place(field.path, None)
        )
        return None
    _check_images(settings, cell, cutoff, periodic)
    amount, origin = strength.value()
    shape, length, shape_text = _shape(settings, method, cutoff, notes)
    alpha, counts, order = 0.0, (0, 0, 0), 0
    texts: list[str] = []
    if method in _METHODS:
        if imcon not in (1, 2, 3):
            message = f"{method} sums over reciprocal vectors and needs a cell that is periodic along all three axes "
            message += f"(imcon 1, 2 or 3), not imcon {imcon}; pairwise, dddp, reaction_field and force_shifted do not"
            raise settings.refusal("coul_method", message)
        if not all(periodic):
            message = f"{method} sums over all images, but walls end the periodicity of an axis; "
            raise settings.refusal(
                "coul_method", f"{message}pairwise, dddp, reaction_field and force_shifted end there"
            )
        alpha, counts, order, texts = _ewald(settings, method, cutoff, cell, notes)
    elif method in ("force_shifted", "reaction_field"):
        alpha, texts = _damping(settings, cutoff)
    permittivity = permittivity_of(settings) if method == "reaction_field" else 1.0
    if method == "reaction_field":
        texts.append(f"permittivity around the cutoff's sphere {permittivity:g}")
    _note_total(layout, method, field, notes)
    return Electrostatics(
        method=_METHODS.get(method, method),
        keyword=method,
        shape=shape,
        length=length,
        strength=amount,
        cutoff=cutoff,
        alpha=alpha,
        permittivity=permittivity,
        counts=counts,
        order=order,
        origins=(f"strength {amount:.9g}: {origin}", shape_text, *texts),
    )


def _check_images(settings: Settings, cell: FloatArray, cutoff: float, periodic: tuple[bool, bool, bool]) -> None:
    images = images_within(cutoff, widths(cell)[list(periodic)].tolist())
    if images > MOST_IMAGES:
        message = f"{images:.3g} images of each charge lie within the cutoff {cutoff:g} ang, more than {MOST_IMAGES}: "
        raise settings.refusal("cutoff", message + "the cell is too small for it")


def _note_total(layout: Layout, method: str, field: Field, notes: Notes) -> None:
    total = math.fsum(layout.charge.tolist())
    if abs(total) > _UNCHARGED:
        text = f"the beads' charges add up to {total:.6g} e"
        if method in _METHODS:
            text += ": a uniform background makes the cell neutral, and its energy is included"
        notes.warning(text, place(field.path, None))


def _shape(settings: Settings, method: str, cutoff: float, notes: Notes) -> tuple[str, float, str]:
    """Return the core's shape, its length, and both in words."""
    word = settings.text("charge_smearing_method").strip().lower().replace("_", "-")
    where = settings.where("charge_smearing_method")
    if word not in _SHAPES:
        raise settings.refusal("charge_smearing_method", f"{word!r} is no shape of charges; expected {_SHAPE_WORDS}")
    shape = _SHAPES[word]
    if shape == "point":
        return shape, 1.0, "point charges"
    if method == "dddp":
        message = f"{word} charges cannot be combined with coul_method dddp, whose permittivity grows with the distance"
        raise settings.refusal("charge_smearing_method", message)
    length = _smearing_length(settings, shape)
    description = next(row["description"] for row in _core.charge_shapes() if row["name"] == shape)
    numbers = _core.ChargeNumbers()
    numbers.cutoff = cutoff
    energies, _ = _core.evaluate_charge("pairwise", shape, length, numbers, [cutoff])
    missing = abs(1.0 - float(energies[0]) * cutoff)
    if missing > _SEEN:
        text = f"at the cutoff {cutoff:g} the interaction of smeared charges is still {missing:.2g} of itself away "
        notes.choice(f"{text}from that of points: the force jumps there; a longer cutoff makes the jump smaller", where)
    return shape, length, f"{description}, L = {length:.9g} [{where}]"


def _smearing_length(settings: Settings, shape: str) -> float:
    """Return λ = 1/β, σ or R."""
    length = settings.number("charge_smearing_length")
    beta = settings.text("charge_smearing_beta").strip().lower() if shape == "slater" else ""
    if beta and beta not in _BETAS:
        try:
            value = float(beta)
        except ValueError:
            value = math.nan
        if not (value > 0.0 and math.isfinite(value)):
            message = f"{beta!r} is neither a number above 0 (beta itself, in 1/ang) nor original (beta = 1/length) "
            raise settings.refusal("charge_smearing_beta", message + "nor overlap (beta = 5/(8 length))")
        if settings.given("charge_smearing_length"):
            message = "a number is beta itself, and charge_smearing_length says it again: give one of them"
            raise settings.refusal("charge_smearing_beta", message)
        return 1.0 / value
    if not (length > 0.0 and math.isfinite(length)):
        word = "charge_smearing_length" if settings.given("charge_smearing_length") else "charge_smearing_method"
        raise settings.refusal(word, f"{shape} charges need a charge_smearing_length above 0, not {length:g}")
    return length / _BETAS.get(beta, 1.0)


def _damping(settings: Settings, cutoff: float) -> tuple[float, list[str]]:
    damping, precision = settings.number("coul_damping"), settings.number("coul_precision")
    if damping and precision:
        raise settings.refusal("coul_precision", "says the same as coul_damping: give one of them")
    if damping:
        if not (damping > 0.0 and math.isfinite(damping)):
            raise settings.refusal("coul_damping", f"must not be negative, but is {damping:g}")
        return damping, [f"damping alpha = {damping:.9g} [{settings.where('coul_damping')}]"]
    if precision:
        alpha = _alpha_of(settings, "coul_precision", precision, cutoff)
        where = settings.where("coul_precision")
        return alpha, [f"damping alpha = {alpha:.9g}, for a precision of {precision:g} [{where}]"]
    return 0.0, ["not damped"]


def _alpha_of(settings: Settings, keyword: str, precision: float, cutoff: float) -> float:
    """Return DL_POLY's α for a precision."""
    product = precision * cutoff
    if 0.0 < product < 1.0 and precision <= _COARSEST:
        argument = product * math.sqrt(-math.log(product))
        if argument < 1.0:
            return math.sqrt(-math.log(argument)) / cutoff
    message = f"the precision {precision:g} gives no alpha with the cutoff {cutoff:g}: it must lie above 0 and up to "
    message += f"{_COARSEST:g}, and its product with the cutoff well below 1"
    raise settings.refusal(keyword, message)


def _vectors(length: float, alpha: float, precision: float) -> int:
    """Return how many vectors along an axis reach to where e^(−k²/4α²) is the precision."""
    return max(1, math.ceil(length * alpha / math.pi * math.sqrt(-math.log(precision))))


def _mesh_points(length: float, alpha: float, precision: float, order: int) -> int:
    """Return the points along an axis for which neither the mesh's end nor its splines lose more than the precision.

    Splines of order p take the wave of n periods on K points for that of n − K with a weight of about (n/(K − n))^p.
    """
    points = _good_size(max(order, 2 * _vectors(length, alpha, precision)))
    while points < _MOST_ON_AXIS:
        waves = np.arange(1, points // 2 + 1)
        fade = np.exp(-((math.pi / (alpha * length) * waves) ** 2))
        if float((2.0 * fade * (waves / (points - waves)) ** order).max()) <= precision:
            break
        points = _good_size(points + 1)
    return points


def _ewald(
    settings: Settings, method: str, cutoff: float, cell: FloatArray, notes: Notes
) -> tuple[float, tuple[int, int, int], int, list[str]]:
    """Return α, the counts of vectors or points, the splines' order (0: no mesh), and all of it in words."""
    by_hand = [name for name in ("spme_alpha", "spme_kvec") if settings.given(name)]
    if by_hand:
        alpha, numbers = settings.number("spme_alpha"), [float(x) for x in settings.vector("spme_kvec")]
        if len(by_hand) < 2:
            other = "spme_kvec" if by_hand == ["spme_alpha"] else "spme_alpha"
            raise settings.refusal(by_hand[0], f"needs {other} beside it; or leave both to spme_precision")
        if settings.given("spme_precision"):
            message = "chooses what spme_alpha and spme_kvec give by hand: leave it or them out"
            raise settings.refusal("spme_precision", message)
        if not (alpha > 0.0 and math.isfinite(alpha)):
            raise settings.refusal("spme_alpha", f"must be larger than 0, not {alpha:g}")
        if any(not x.is_integer() or not 1.0 <= x <= _MOST_POINTS for x in numbers):
            raise settings.refusal("spme_kvec", "needs three whole numbers from 1 on")
        wanted = tuple(int(x) for x in numbers)
        origin = f"alpha = {alpha:.9g} [{settings.where('spme_alpha')}]"
        where = f"[{settings.where('spme_kvec')}]"
    else:
        precision = settings.number("spme_precision")
        alpha = _alpha_of(settings, "spme_precision", precision, cutoff)
        lengths = np.linalg.norm(cell, axis=1).tolist()
        if method == "ewald_direct":
            wanted = tuple(2 * _vectors(length, alpha, precision) for length in lengths)
        else:
            order = _order(settings, notes)
            wanted = tuple(_mesh_points(length, alpha, precision, order) for length in lengths)
        origin = f"alpha = {alpha:.9g}, for a precision of {precision:g} [{settings.where('spme_precision')}]"
        where = "for the same precision"
    if math.prod(wanted) > _MOST_POINTS:
        word = "spme_kvec" if by_hand else "spme_precision"
        raise settings.refusal(word, f"{wanted} are more reciprocal vectors than fit into memory")
    if method == "ewald_direct":
        counts = tuple(max(1, n // 2) for n in wanted)
        return alpha, _three(counts), 0, [origin, f"plain sum, vectors up to {_times(counts)} {where}"]
    order = _order(settings, notes)
    points = tuple(_good_size(max(n, order)) for n in wanted)
    if points != wanted:
        text = f"the mesh of {_times(wanted)} points becomes {_times(points)}: products of 2, 3 and 5, at least the "
        notes.choice(f"{text}splines' order", settings.where("spme_kvec"))
    return alpha, _three(points), order, [origin, f"mesh of {_times(points)} points {where}, splines of order {order}"]


def _order(settings: Settings, notes: Notes) -> int:
    given = settings.integer("spme_nsplines")
    order = max(4, given + given % 2)
    if order > _MOST_SPLINES or given < 1:
        raise settings.refusal("spme_nsplines", f"must lie between 1 and {_MOST_SPLINES}, not at {given}")
    if order != given:
        notes.choice(f"splines of order {given} become {order}: even, and at least 4", settings.where("spme_nsplines"))
    return order


def _good_size(least: int) -> int:
    """Return the smallest product of 2, 3 and 5 that is not smaller."""
    size = least
    while True:
        rest = size
        for prime in (2, 3, 5):
            while rest % prime == 0:
                rest //= prime
        if rest == 1:
            return size
        size += 1


def _three(numbers: tuple[int, ...]) -> tuple[int, int, int]:
    return numbers[0], numbers[1], numbers[2]


def _times(numbers: tuple[int, ...]) -> str:
    return " x ".join(str(n) for n in numbers)
