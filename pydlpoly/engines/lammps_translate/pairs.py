"""Pair laws as styles of LAMMPS, and drag and noise as ``dpd/tstat``.

Every law has a formula for ``pair_style lepton``, which LAMMPS differentiates and evaluates in double precision; where
LAMMPS has a style of the same law, that is faster and is taken. A table is refused: LAMMPS interpolates it otherwise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pydlpoly import _core
from pydlpoly.engines.lammps_translate.formulas import fill, number, term
from pydlpoly.engines.lammps_translate.refusal import Places, refusal
from pydlpoly.scene.laws import pair_laws
from pydlpoly.scene.model import PairTerm, Scene

LEPTON = "lepton"
DRAG_STYLES = ("dpd/tstat", "dpd/ext/tstat")

Numbers = tuple[float, ...]
# A style's own numbers, or None where this law with these numbers is none of the style's.
Coefficients = Callable[[Numbers, float], "Numbers | None"]


@dataclass(frozen=True)
class PairStyle:
    """What a pair law becomes.

    Attributes:
        formula: of U(r) in the law's parameters by name, ``rc`` being the cutoff; other words stand for themselves.
        style: LAMMPS's own style of the law, empty where there is none.
        coefficients: its numbers from the law's and the cutoff.
        modify: words of ``pair_modify`` that the style needs.
        sometimes: the style takes some of the law's numbers only.
    """

    formula: str
    style: str = ""
    coefficients: Coefficients | None = None
    modify: str = ""
    sometimes: bool = False


def _twelve_six(repulsion: float, attraction: float, cutoff: float) -> Numbers | None:
    if repulsion <= 0.0 or attraction <= 0.0:
        return None
    return attraction * attraction / (4.0 * repulsion), (repulsion / attraction) ** (1.0 / 6.0), cutoff


def _dpd(given: Numbers, _cutoff: float) -> Numbers:
    return 0.5 * given[0] / given[1], given[1]


def _wca(given: Numbers, _cutoff: float) -> Numbers | None:
    # With an offset the style shifts the energy by its value at another distance than the law's end.
    sigma = abs(given[1])
    return (given[0], sigma, 0.0, _ROOT * sigma) if given[2] == 0.0 else None


def _wca_offset(given: Numbers) -> float:
    return min(given[2], 0.5 * abs(given[1]))


_ROOT = 1.12246204830937298143  # 2^(1/6)
_TAPER = "(1-max(0,(r-{ri})/({rc}-{ri})))^3*(1+3*max(0,(r-{ri})/({rc}-{ri}))+6*max(0,(r-{ri})/({rc}-{ri}))^2)"
_ZBL = (
    "{strength}/r*(0.18175*exp(-3.1998*r/{a})+0.50986*exp(-0.94229*r/{a})+0.28022*exp(-0.40290*r/{a})"
    "+0.02817*exp(-0.20162*r/{a}))"
)
_FADE = "0.5*exp(-abs(r-{rm})/{xi})"
_CORE = f"(step({{rm}}-r)*(1-{_FADE})+(1-step({{rm}}-r))*{_FADE})"
_MORSE = "{E0}*exp({k}*({r0}-r))*(exp({k}*({r0}-r))-2)"
_BUCKINGHAM = "{A}*exp(-r/{rho})-{C}/r^6"
_SNM = "{E1}/{n}*({r0}/r)^{n}-{E2}/{m}*({r0}/r)^{m}+{slope}*r-{offset}"

PAIR_STYLES: dict[str, PairStyle | None] = {
    "dpd": PairStyle("{A}*{rc}/2*(1-r/{rc})^2", "harmonic/cut", _dpd),
    "lj": PairStyle("4*{eps}*(({sig}/r)^12-({sig}/r)^6)", "lj/cut", lambda p, rc: (p[0], p[1], rc)),
    "12-6": PairStyle("{A}/r^12-{B}/r^6", "lj/cut", lambda p, rc: _twelve_six(p[0], p[1], rc), sometimes=True),
    "ljc": PairStyle(
        "4*{eps}*(({sig}/r)^12-{c}*({sig}/r)^6)",
        "lj/cut",
        lambda p, rc: _twelve_six(4.0 * p[0] * p[1] ** 12, 4.0 * p[0] * p[1] ** 6 * p[2], rc),
        sometimes=True,
    ),
    "ljf": PairStyle(
        "{eps}*{ratio}/4*(3/({ratio}-1))^3*(({sig}/r)^2-1)*(({rc}/r)^2-1)^2",
        "wf/cut",
        lambda p, _rc: (p[0], p[1], 1, 1, p[2]),
    ),
    "nm": PairStyle(
        "{E0}/({n}-{m})*({m}*({r0}/r)^{n}-{n}*({r0}/r)^{m})",
        "nm/cut",
        lambda p, rc: (p[0], p[3], p[1], p[2], rc),
    ),
    "snm": PairStyle(_SNM),
    "buck": PairStyle(
        _BUCKINGHAM, "buck", lambda p, rc: (p[0], p[1], p[2], rc) if p[1] > 0.0 else (0.0, 1.0, p[2], rc)
    ),
    "bhm": PairStyle(
        "{A}*exp({B}*({sig}-r))-{C}/r^6-{D}/r^8",
        "born",
        lambda p, rc: (p[0], 1.0 / p[1], p[2], p[3], -p[4], rc) if p[1] > 0.0 else None,
        sometimes=True,
    ),
    "hbnd": PairStyle("{A}/r^12-{B}/r^10"),
    "mors": PairStyle(_MORSE, "morse", lambda p, rc: (p[0], p[2], p[1], rc)),
    "mstw": PairStyle(f"{_MORSE}+{{c}}/r^12"),
    "wca": PairStyle(
        "4*{eps}*(({sig}/(r-{D}))^12-({sig}/(r-{D}))^6)+{eps}", "lj/expand", _wca, modify="shift yes", sometimes=True
    ),
    "ndpd": PairStyle("{A}*{b}*{rc}/({n}+1)*(1-r/{rc})^({n}+1)-{A}*{rc}/2*(1-r/{rc})^2"),
    "14-7": PairStyle("{eps}*(1.07/(r/{r0}+0.07))^7*(1.12/((r/{r0})^7+0.12)-2)"),
    "ryd": PairStyle("({a}+{b}*r)*exp(-r/{rho})"),
    "zbl": PairStyle(_ZBL),
    "zbls": PairStyle(f"{_CORE}*({_ZBL})+(1-{_CORE})*({_MORSE})"),
    "zblb": PairStyle(f"{_CORE}*({_ZBL})+(1-{_CORE})*({_BUCKINGHAM})"),
    "mlj": PairStyle(
        f"4*{{eps}}*(({{sig}}/r)^12-({{sig}}/r)^6)*{_TAPER}", "lj/mdf", lambda p, rc: (p[0], p[1], p[2], rc)
    ),
    "mbuc": PairStyle(
        f"({_BUCKINGHAM})*{_TAPER}",
        "buck/mdf",
        lambda p, rc: (p[0], p[1], p[2], p[3], rc) if p[1] > 0.0 else None,
        sometimes=True,
    ),
    "m126": PairStyle(f"({{A}}/r^12-{{B}}/r^6)*{_TAPER}", "lennard/mdf", lambda p, rc: (*p, rc)),
    "sand": PairStyle("-{A}*exp(-((r-{L})/{d})^2)"),
    "sw": PairStyle("{eps}*{A}*({B}*({sig}/r)^{p}-({sig}/r)^{q})*exp({sig}/(r-{a}*{sig}))"),
    "tab": None,
}
"""Every pair law of the registry; None for those that are refused."""

REFUSED_BECAUSE = {"tab": "LAMMPS interpolates tables otherwise, and forces would differ"}


@dataclass(frozen=True)
class SubStyle:
    """One sub-style of ``pair_style hybrid/overlay``: its arguments, its ``pair_coeff`` lines and modifications.

    ``instance`` counts sub-styles of one name from 1, and is 0 where there is one of it.
    """

    name: str
    arguments: str
    coefficients: tuple[str, ...]
    modify: tuple[str, ...] = ()
    instance: int = 0

    @property
    def label(self) -> str:
        """Its name in ``pair_coeff`` and ``pair_modify``, with its number where there are several of it."""
        return f"{self.name} {self.instance}" if self.instance else self.name


def conservative_styles(scene: Scene, places: Places) -> list[SubStyle]:
    """Return the sub-styles of the pair laws. Raises SceneError for a law that is refused."""
    lines: dict[str, list[str]] = {}
    for pair in scene.pairs:
        if pair.law is None:
            continue
        style, numbers = _style_of(pair, scene, places)
        lines.setdefault(style, []).append(f"pair_coeff {types_of(pair.species)} {style} {numbers}")
    reach = max((pair.cutoff for pair in scene.pairs if pair.law is not None), default=scene.cutoff)
    modified = {entry.style: entry.modify for entry in PAIR_STYLES.values() if entry is not None and entry.modify}
    styles = []
    for name, rows in lines.items():
        given = "" if name == "harmonic/cut" else number(reach)
        if name.endswith("/mdf"):  # where the taper begins comes first; every pair says it for itself
            given = f"{number(0.5 * reach)} {given}"
        modify = (f"pair_modify pair {name} {modified[name]}",) if name in modified else ()
        styles.append(SubStyle(name, given, tuple(rows), modify))
    return styles


def drag_styles(scene: Scene, seed: int) -> list[SubStyle]:
    """Return the sub-style of drag and noise, if any pair has a drag.

    LAMMPS's w_R is (1 − r/rc)^s with its own s, half of the exponent of w_D.
    """
    dragged = [pair for pair in scene.pairs if pair.drag > 0.0]
    if not dragged:
        return []
    dynamics = scene.dynamics
    reach = max(pair.drag_cutoff for pair in dragged)
    energy = number(dynamics.thermal_energy)
    usual = dynamics.weight_exponent == 2.0
    name = DRAG_STYLES[0] if usual else DRAG_STYLES[1]
    power = number(0.5 * dynamics.weight_exponent)
    rows = []
    for pair in dragged:
        across = "" if usual else f" 0.0 {power} {power}"
        types = types_of(pair.species)
        rows.append(f"pair_coeff {types} {name} {number(pair.drag)}{across} {number(pair.drag_cutoff)}")
    return [SubStyle(name, f"{energy} {energy} {number(reach)} {seed}", tuple(rows))]


def formula_of(pair: PairTerm) -> str:
    """Return U(r) of a pair's law, force shift included, in the words of LEPTON."""
    assert pair.law is not None
    entry = PAIR_STYLES[pair.law]
    assert entry is not None
    text = fill(entry.formula, **_numbers(pair))
    law = pair_laws()[pair.law]
    # A taper leads energy and force to zero by itself.
    if pair.force_shift and law.shiftable and "ri" not in law.parameter_names:
        # The law is asked beyond its cutoff: at the cutoff itself it is over.
        energy, force = _core.evaluate_pair(pair.law, list(pair.parameters), 2.0 * pair.cutoff, [pair.cutoff])
        text += f"-{term(float(energy[0]))}+{term(float(force[0]))}*(r-{term(pair.cutoff)})"
    return text


def why_refused(law: str) -> str:
    """Return in words why a law is not translated."""
    return REFUSED_BECAUSE.get(law, "it is not translated")


def _style_of(pair: PairTerm, scene: Scene, places: Places) -> tuple[str, str]:
    """Return the style of a pair and its numbers."""
    assert pair.law is not None
    if pair.law == "mdpd":  # its attraction; densities and their force are of many_body
        return "harmonic/cut", " ".join(map(number, _attraction(pair)))
    entry = PAIR_STYLES.get(pair.law)
    names = "-".join(scene.species[k] for k in pair.species)
    if entry is None:
        where = places.of_text(pair.explanation)
        raise refusal(f"the pair law {pair.law} of {names} cannot be run", where, why_refused(pair.law))
    shifted = pair.force_shift and pair_laws()[pair.law].shiftable
    if shifted and pair.law == "lj":
        return "lj/smooth/linear", " ".join(map(number, (*pair.parameters, pair.cutoff)))
    if not shifted and entry.coefficients is not None:
        numbers = entry.coefficients(pair.parameters, pair.cutoff)
        if numbers is not None:
            return entry.style, " ".join(map(number, numbers))
    return LEPTON, f'"{formula_of(pair)}" {number(pair.cutoff)}'


def _attraction(pair: PairTerm) -> Numbers:
    """Return the numbers of ½ A r_c (1 − r/r_c)² of a pair of the law mdpd."""
    return 0.5 * pair.parameters[0] / pair.cutoff, pair.cutoff


def _numbers(pair: PairTerm) -> dict[str, float]:
    """Return the numbers that the law's formula names."""
    assert pair.law is not None
    given = dict(zip(pair_laws()[pair.law].parameter_names, pair.parameters, strict=True))
    given.setdefault("rc", pair.cutoff)
    if pair.law == "wca":
        given["D"], given["sig"] = _wca_offset(pair.parameters), abs(given["sig"])
    elif pair.law == "ljf":
        given["ratio"] = (given["rc"] / given["sig"]) ** 2
    elif pair.law == "snm":
        given |= _shifted_n_m(given)
    elif pair.law in ("zbl", "zbls", "zblb"):
        first, second = given["Z1"], given["Z2"]
        given["a"] = 0.88534 * 0.52917721067 / (first**0.23 + second**0.23)
        given["strength"] = 138935.4835 * first * second
    if given.get("rho") == 0.0:  # dispersion alone
        given["rho"] = 1.0
    return given


def _shifted_n_m(given: dict[str, float]) -> dict[str, float]:
    """Return the strengths, the slope and the offset of snm; see cpp/pair/n_m_shifted.hpp."""
    n, m, reach = given["n"], given["m"], given["rc"]
    g = reach / given["r0"]
    beta = g * ((g ** (m + 1.0) - 1.0) / (g ** (n + 1.0) - 1.0)) ** (1.0 / (n - m))
    alpha = (m - n) / (m * beta**n * (1.0 + (n / g - n - 1.0) / g**n) - n * beta**m * (1.0 + (m / g - m - 1.0) / g**m))
    strength = alpha * given["E0"] / (n - m) * n * m
    inner, outer = strength * beta**n, strength * beta**m
    slope = (inner / g**n - outer / g**m) / reach
    offset = inner / g**n / n - outer / g**m / m + slope * reach
    return {"E1": inner, "E2": outer, "slope": slope, "offset": offset}


def types_of(species: tuple[int, int]) -> str:
    """Return the types of a pair of species, as ``pair_coeff`` has them."""
    a, b = sorted(species)
    return f"{a + 1} {b + 1}"
