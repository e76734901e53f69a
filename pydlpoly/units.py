"""DL_POLY's internal units and constants, the energy units of FIELD, and the unit words of CONTROL.

Internal units: length Å, time ps, mass Da, charge e, energy 10 J/mol = 1 Da Å²/ps². The constants are DL_POLY's own, to
the last digit, although they mix several CODATA editions: its files can only agree to print precision when these do.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace

from pydlpoly.errors import InputError, suggest

BOLTZMANN = 0.831451115
"""k_B in internal energy per kelvin."""
AVOGADRO = 6.022140857e23
COULOMB_CONSTANT = 138935.4835
"""1/(4πε₀) in internal energy Å/e²."""
KATM_PER_INTERNAL_PRESSURE = 0.163882576
TENSION_IN_DYN_PER_CM = 1.660540200
"""One internal surface tension (Da/ps²) in dyn/cm."""
ELECTRIC_FIELD_UNIT = 1.0 / 1.037837512e-4
"""Force on one e in a field of 1 V/Å; 0.14 % below the eV factor, as in DL_POLY."""
MAGNETIC_FIELD_UNIT = 1.0 / 1.037837512e4
"""Force on one e that moves with 1 Å/ps in a field of 1 T."""


@dataclass(frozen=True)
class EnergyUnit:
    """The energy unit of a FIELD file and with it the units of everything that is reported.

    Attributes:
        name: canonical word: ``ev``, ``kcal``, ``kj``, ``k``, ``internal`` or ``dpd``.
        factor: internal energy units in one of this unit.
        reduced: whether all numbers are reduced DPD units, so that reports use k_B = 1 and no katm.
        label: the unit as people write it, for tables.
        statis_label: the name that DL_POLY puts into the header of STATIS.
    """

    name: str
    factor: float
    reduced: bool = False
    label: str = ""
    statis_label: str = ""

    @property
    def boltzmann(self) -> float:
        """k_B that turns an internal thermal energy into the reported temperature."""
        return 1.0 if self.reduced else BOLTZMANN

    @property
    def pressure_factor(self) -> float:
        """Reported pressure per internal pressure."""
        return 1.0 if self.reduced else KATM_PER_INTERNAL_PRESSURE

    @property
    def tension_factor(self) -> float:
        """Reported surface tension per internal surface tension."""
        return 1.0 if self.reduced else TENSION_IN_DYN_PER_CM

    @property
    def temperature_label(self) -> str:
        """Unit word for temperatures in reports."""
        return "" if self.reduced else "K"

    @property
    def pressure_label(self) -> str:
        """Unit word for pressures in reports."""
        return "" if self.reduced else "katm"


ENERGY_UNITS: dict[str, EnergyUnit] = {
    unit.name: unit
    for unit in (
        EnergyUnit("ev", 9648.530821, label="eV", statis_label="electron Volts"),
        EnergyUnit("kcal", 418.4, label="kcal/mol", statis_label="kcal/mol"),
        EnergyUnit("kj", 100.0, label="kJ/mol", statis_label="kjoule/mol"),
        EnergyUnit("k", BOLTZMANN, label="K", statis_label="kelvin/Boltzmann"),
        EnergyUnit("internal", 1.0, label="10 J/mol", statis_label="DL_POLY Internal UNITS (10 J/mol)"),
        EnergyUnit("dpd", 1.0, reduced=True, label="", statis_label="DPD"),
    )
}


def energy_unit(word: str, *, path: str = "", line: int | None = None) -> EnergyUnit:
    """Return the energy unit that the word after FIELD's ``units`` means.

    DL_POLY compares leading letters only: ``kj…``, ``kcal…``, then any other ``k…`` is kelvin; nothing means internal.

    Raises:
        InputError: the word is none of FIELD's units.
    """
    lower = word.lower()
    if not lower:
        return ENERGY_UNITS["internal"]
    for prefix in ("ev", "kcal", "kj", "k", "internal", "dpd"):
        if lower.startswith(prefix):
            return ENERGY_UNITS[prefix]
    message = f"is no energy unit; FIELD knows eV, kcal, kJ, K, internal and dpd{suggest(word, ENERGY_UNITS)}"
    raise InputError(message, path=path, line=line, word=word)


# -- Unit words of CONTROL --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Unit:
    """A unit as a factor to internal units and whole powers of the base dimensions.

    ``powers`` are those of mass, length, time, temperature, amount, current and angle; ``system_temperature`` is the
    power of the word ``temp``, which means the run's own temperature, and ``steps`` that of the timestep.
    """

    factor: float = 1.0
    powers: tuple[int, int, int, int, int, int, int] = (0, 0, 0, 0, 0, 0, 0)
    system_temperature: int = 0
    steps: int = 0

    def times(self, other: Unit, power: int = 1) -> Unit:
        """Return this unit multiplied by a power of another one."""
        powers = tuple(a + power * b for a, b in zip(self.powers, other.powers, strict=True))
        return Unit(
            self.factor * other.factor**power,
            powers,  # type: ignore[arg-type]  # zip keeps the length, which mypy cannot see
            self.system_temperature + power * other.system_temperature,
            self.steps + power * other.steps,
        )


_METRE, _SECOND, _JOULE = 1e10, 1e12, 0.1 * AVOGADRO
_KILOGRAM = 6.0229552894949e26  # DL_POLY's; not 1000 × Avogadro's number, hence the odd newton and pascal
_COULOMB, _HARTREE, _POUND, _BOHR = 6.241509074460763e18, 4.359744722e-18 * _JOULE, 0.45359237 * _KILOGRAM, 0.52918
_AUT = 2.4188843265857e-17 * _SECOND
_NEWTON = _KILOGRAM * _METRE / _SECOND**2

_MASS, _LENGTH, _TIME = (1, 0, 0, 0, 0, 0, 0), (0, 1, 0, 0, 0, 0, 0), (0, 0, 1, 0, 0, 0, 0)
_TEMPERATURE, _AMOUNT, _ANGLE = (0, 0, 0, 1, 0, 0, 0), (0, 0, 0, 0, 1, 0, 0), (0, 0, 0, 0, 0, 0, 1)
_CHARGE, _CURRENT, _NUMBER = (0, 0, 1, 0, 0, 1, 0), (0, 0, 0, 0, 0, 1, 0), (0, 0, 0, 0, 0, 0, 0)
_ENERGY, _POWER, _VOLTAGE = (1, 2, -2, 0, 0, 0, 0), (1, 2, -3, 0, 0, 0, 0), (1, 2, -3, 0, 0, -1, 0)
_PRESSURE, _FORCE, _VELOCITY = (1, -1, -2, 0, 0, 0, 0), (1, 1, -2, 0, 0, 0, 0), (0, 1, -1, 0, 0, 0, 0)

_WORDS: dict[str, Unit] = {
    # time
    **dict.fromkeys(("internal_t", "dpd_t"), Unit(1.0, _TIME)),
    "s": Unit(_SECOND, _TIME),
    "min": Unit(60.0 * _SECOND, _TIME),
    "hr": Unit(3600.0 * _SECOND, _TIME),
    "aut": Unit(_AUT, _TIME),
    "steps": Unit(1.0, _TIME, steps=1),
    # length
    **dict.fromkeys(("internal_l", "ang", "dpd_l"), Unit(1.0, _LENGTH)),
    "bohr": Unit(_BOHR, _LENGTH),
    "m": Unit(_METRE, _LENGTH),
    "in": Unit(0.0254 * _METRE, _LENGTH),
    "ft": Unit(12 * 0.0254 * _METRE, _LENGTH),
    # mass
    **dict.fromkeys(("internal_m", "da", "amu", "dpd_m"), Unit(1.0, _MASS)),
    "m_e": Unit(9.1093837015e-31 * _KILOGRAM, _MASS),
    "g": Unit(1e-3 * _KILOGRAM, _MASS),
    "lb": Unit(_POUND, _MASS),
    "oz": Unit(_POUND / 16.0, _MASS),
    # charge and current
    **dict.fromkeys(("internal_q", "q_e", "e"), Unit(1.0, _CHARGE)),
    "c": Unit(_COULOMB, _CHARGE),
    "a": Unit(_COULOMB / _SECOND, _CURRENT),
    # energy
    **dict.fromkeys(("internal_e", "dpd_e"), Unit(1.0, _ENERGY)),
    "j": Unit(_JOULE, _ENERGY),
    "cal": Unit(4.1842 * _JOULE, _ENERGY),  # DL_POLY's calorie here; FIELD's kcal is 4.184 kJ
    **dict.fromkeys(("ha", "e_h"), Unit(_HARTREE, _ENERGY)),
    "ry": Unit(0.5 * _HARTREE, _ENERGY),
    "k_b": Unit(BOLTZMANN, (1, 2, -2, -1, 0, 0, 0)),
    # temperature
    "k": Unit(1.0, _TEMPERATURE),
    "dpd_temp": Unit(1.0 / BOLTZMANN, _TEMPERATURE),
    "temp": Unit(1.0, _TEMPERATURE, system_temperature=1),
    # pressure, force, velocity and others
    **dict.fromkeys(("internal_p", "dpd_p"), Unit(1.0, _PRESSURE)),
    "atm": Unit(1.0 / (1000.0 * KATM_PER_INTERNAL_PRESSURE), _PRESSURE),
    "pa": Unit(_NEWTON / _METRE**2, _PRESSURE),
    **dict.fromkeys(("internal_f", "dpd_f"), Unit(1.0, _FORCE)),
    "n": Unit(_NEWTON, _FORCE),
    "dyn": Unit(1e-5 * _NEWTON, _FORCE),
    **dict.fromkeys(("internal_v", "dpd_v"), Unit(1.0, _VELOCITY)),
    "auv": Unit(_BOHR / _AUT, _VELOCITY),
    "grav": Unit(9.81 * _METRE / _SECOND**2, (0, 1, -2, 0, 0, 0, 0)),
    "v": Unit(_JOULE / _COULOMB, _VOLTAGE),
    "w": Unit(_JOULE / _SECOND, _POWER),
    "rad": Unit(1.0, _ANGLE),
    "deg": Unit(math.pi / 180.0, _ANGLE),
    "grad": Unit(math.pi / 200.0, _ANGLE),
    "mol": Unit(AVOGADRO, _AMOUNT),
    "%": Unit(0.01, _NUMBER),
}

_PREFIXES = {
    **{"Y": 1e24, "Z": 1e21, "E": 1e18, "P": 1e15, "T": 1e12, "G": 1e9, "M": 1e6, "k": 1e3},
    **{"d": 1e-1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9, "p": 1e-12, "f": 1e-15, "a": 1e-18},
    **{"z": 1e-21, "y": 1e-24},
}
_PREFIX_NAMES = {"Y": "yotta", "Z": "zetta", "E": "exa", "P": "peta", "T": "tera", "M": "mega"}

DIMENSIONS: dict[str, tuple[str, str]] = {
    # name of a dimension: its internal unit as a unit word, and examples for messages
    "time": ("internal_t", "ps, fs, ns, internal_t, dpd_t"),
    "steps": ("internal_t", "steps, ps, fs"),
    "length": ("internal_l", "ang, nm, internal_l, dpd_l"),
    "inverse length": ("internal_l^-1", "ang^-1, nm^-1"),
    "mass": ("internal_m", "Da, amu, dpd_m"),
    "charge": ("internal_q", "e, q_e"),
    "energy": ("internal_e", "kJ/mol, kcal/mol, e.V, k_b.K, dpd_e"),
    "temperature": ("k", "K, dpd_temp"),
    "pressure": ("internal_p", "katm, atm, GPa, internal_p, dpd_p"),
    "force": ("internal_f", "k_b.temp/ang, internal_f, dpd_f"),
    "velocity": ("internal_v", "ang/ps, m/s, dpd_v"),
    "drag": ("internal_m/internal_t", "Da/ps, dpd_m/dpd_t"),
    "rate": ("internal_t^-1", "ps^-1, dpd_t^-1"),
    "tension": ("internal_f/internal_l", "N/m, dyn/cm, dpd_f/dpd_l"),
    "density": ("internal_l^-3", "ang^-3, nm^-3"),
    "inverse temperature": ("k^-1", "K^-1"),
    "heat capacity": ("k_b", "k_b"),
    "conductivity": ("w/m/k", "W/m/K"),
    "diffusivity": ("internal_l^2/internal_t", "m^2/s, ang^2/ps"),
    "number": ("", "none, %"),
}

_FACTOR = re.compile(r"([./]?)([^./^]+)(?:\^([+-]?\d+))?")


def parse_unit(text: str, *, path: str = "", line: int | None = None) -> Unit:
    """Read a unit string: words joined by ``.`` (times) and ``/`` (per), each with an optional whole power ``^n``.

    Words are case-insensitive and may be bare whole numbers. An SI prefix is case-sensitive and is tried only when the
    whole word is no unit, so that ``min`` is a minute and ``Pa`` a pascal.

    Raises:
        InputError: the string is malformed, or a word in it is no unit.
    """
    result, position = Unit(), 0
    while position < len(text):
        match = _FACTOR.match(text, position)
        if match is None or (position > 0) != bool(match[1]):
            raise InputError(
                "is no unit: write words joined by '.' and '/', each with an optional whole power such as ^-1",
                path=path,
                line=line,
                word=text,
            )
        power = int(match[3] or 1)
        if abs(power) > 9:
            raise InputError("has a power beyond 9", path=path, line=line, word=text)
        try:
            result = result.times(_word(match[2], path, line), -power if match[1] == "/" else power)
        except (OverflowError, ZeroDivisionError):
            result = Unit(math.inf)
        if not 0.0 < result.factor < math.inf:
            raise InputError("is a unit beyond the range of numbers", path=path, line=line, word=text)
        position = match.end()
    return result


def _word(word: str, path: str, line: int | None) -> Unit:
    unit = _WORDS.get(word.lower())
    if unit is not None:
        return unit
    if re.fullmatch(r"[0-9]{1,15}", word) and int(word) > 0:
        return Unit(float(word))
    if word[0] in _PREFIXES and word[1:].lower() in _WORDS:
        unit = _WORDS[word[1:].lower()]
        return replace(unit, factor=unit.factor * _PREFIXES[word[0]])
    if word.lower() == "ev" or word[1:].lower() == "ev":
        hint = "; the electron-volt is e.V, with a prefix ke.V"
    elif word[0].swapcase() in _PREFIXES and word[1:].lower() in _WORDS:
        right = word.lower() if word[0].lower() in _PREFIXES else word[0].upper() + word[1:]
        hint = f"; did you mean {right}? (prefixes are case-sensitive)"
    else:
        hint = suggest(word, [*_WORDS, "ps", "fs", "ns", "nm", "katm", "kj", "kcal"])
    raise InputError(f"is no unit word{hint}", path=path, line=line, word=word)


def unit_warning(text: str) -> str | None:
    """Return a sentence when the unit has a prefix that is legal but hardly meant, such as PS for peta-seconds."""
    for match in _FACTOR.finditer(text):
        word = match[2]
        if word.lower() in _WORDS or word[0] not in _PREFIX_NAMES or word[0].lower() not in _PREFIXES:
            continue
        rest = _WORDS.get(word[1:].lower())
        if rest is not None and rest.powers in (_TIME, _LENGTH):
            factor = _PREFIXES[word[0]]
            return (
                f"{word!r} is read as {_PREFIX_NAMES[word[0]]}-{word[1:].lower()} (factor {factor:g}); "
                f"if that is not meant, write {word.lower()}"
            )
    return None


def convert(
    value: float,
    unit: str,
    dimension: str,
    *,
    timestep: float | None = None,
    temperature: float | None = None,
    path: str = "",
    line: int | None = None,
) -> float:
    """Return a value in internal units.

    Args:
        value: the number as written.
        unit: the unit string as written; empty for a plain number.
        dimension: a key of ``DIMENSIONS``; ``steps`` yields a (fractional) number of steps.
        timestep: Δt in ps; needed when a time meets the unit ``steps``.
        temperature: the run's temperature in K for the word ``temp``; without it ``temp`` is 1 K, as in DL_POLY.
        path: the file to name in an error.
        line: the line to name in an error.

    Raises:
        InputError: the unit is none, has another dimension, or needs a timestep that is not known.
    """
    read = parse_unit(unit, path=path, line=line)
    target, examples = DIMENSIONS[dimension]
    goal = parse_unit(target)
    if not _same_dimension(read, goal):
        what = "a number of steps" if dimension == "steps" else dimension
        problem = f"is no unit of {what}" if unit else f"a unit of {what} is needed"
        raise InputError(f"{problem}; examples: {examples}", path=path, line=line, word=unit or None)
    power = read.steps - (1 if dimension == "steps" else 0)
    if power and not timestep:
        raise InputError("steps can be converted only with a timestep above 0", path=path, line=line, word=unit)
    factor = read.factor / goal.factor
    if power:
        factor *= float(timestep or 1.0) ** power
    if read.system_temperature and temperature is not None:
        factor *= temperature**read.system_temperature
    return value * factor


def _same_dimension(read: Unit, goal: Unit) -> bool:
    """Compare dimensions; energies may be given per mole (``kJ/mol``) because internal energy is a molar one."""
    if read.powers[4] not in (0, -1) or (read.powers[4] == -1 and goal.powers[0] != 1):
        return False
    return read.powers[:4] + read.powers[5:] == goal.powers[:4] + goal.powers[5:]


def time_to_steps(time: float, timestep: float) -> int:
    """Return the whole number of steps nearest to a time (both in ps); halves are rounded away from zero."""
    ratio = time / timestep
    return int(math.copysign(math.floor(abs(ratio) + 0.5), ratio))


def steps_to_time(steps: float, timestep: float) -> float:
    """Return the time in ps that a number of steps takes."""
    return steps * timestep


def galamost_charge(valence: float, bjerrum_length: float, *, thermal_energy: float = 1.0) -> float:
    """Return the reduced charge q* = z √(λ_B k_B T) that GALAMOST, PyGAMD and LAMMPS (units lj) take.

    They set 1/(4π ε₀ ε_r) to 1, so that two charges at distance r have the energy q*_i q*_j/r.

    Args:
        valence: charge z in e.
        bjerrum_length: λ_B = e²/(4π ε₀ ε_r k_B T), in the unit of length.
        thermal_energy: k_B T in the unit of energy.
    """
    return valence * math.sqrt(bjerrum_length * thermal_energy)


def valence_of_galamost_charge(charge: float, bjerrum_length: float, *, thermal_energy: float = 1.0) -> float:
    """Return z in e for a reduced charge q*, the inverse of ``galamost_charge``."""
    return charge / math.sqrt(bjerrum_length * thermal_energy)


def bjerrum_length_of_coupling(coupling: float) -> float:
    """Return λ_B in units of r_c for Γ = e²/(k_B T ε₀ ε_r r_c) = 4π λ_B/r_c (Groot, J. Chem. Phys. 118 (2003))."""
    return coupling / (4.0 * math.pi)


def coupling_of_bjerrum_length(bjerrum_length: float) -> float:
    """Return Γ = 4π λ_B/r_c for λ_B in units of r_c."""
    return 4.0 * math.pi * bjerrum_length
