"""CONTROL files in DL_MESO's dialect, read as new-style settings; what no keyword can hold goes into ``MesoControl``.

A directive is known by its leading letters, as DL_MESO compares them. All numbers are in units of DPD (k_B = 1). The
last of several lines with the same directive counts, and numbers left out of a sequence are 0, both as in DL_MESO.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pydlpoly.errors import suggest
from pydlpoly.formats.control_old_ensemble import read_cell_constraint
from pydlpoly.formats.control_old_line import Line
from pydlpoly.formats.control_old_tables import LEVELS, old_unit
from pydlpoly.formats.control_values import Parsed, Reading
from pydlpoly.formats.keywords import KEYWORDS
from pydlpoly.formats.records import Control, MesoControl, Remark, Setting, SettingValue

MESO_ONLY = (
    *("volume", "boundary", "surface", "bjerrum", "permittivity", "electrostatic", "smear", "manybody", "thermostat"),
    *("vacuum", "frozen", "openmp", "rhalo", "ndump", "l_init"),
)
"""Directives by which the dialect is known: no DL_POLY has them."""

_UNITS = {
    "time": "dpd_t",
    "length": "dpd_l",
    "temperature": "dpd_temp",
    "pressure": "dpd_p",
    "drag": "dpd_m/dpd_t",
    "rate": "dpd_t^-1",
    "inverse length": "dpd_l^-1",
    "tension": "dpd_f/dpd_l",
}
_SECONDS = ("time_job", "time_close")


@dataclass
class _Rest:
    """What has been read that no keyword can hold."""

    values: dict[str, Any] = field(default_factory=dict)
    remarks: list[Remark] = field(default_factory=list)


class _MesoLine(Line):
    """One directive's words; numbers have no unit words, settings get DPD's units."""

    def __init__(self, reading: Reading, number: int, words: list[str], rest: _Rest) -> None:
        super().__init__(reading, number, words)
        self.rest_ = rest

    def _unit(self, keyword: str) -> None:
        """Numbers stand alone."""

    def put(self, keyword: str, value: SettingValue) -> None:
        """Make a setting in DPD's unit."""
        plain = isinstance(value, (bool, str)) or KEYWORDS[keyword].dimension == "integers"
        own = "s" if keyword in _SECONDS else _UNITS.get(KEYWORDS[keyword].dimension, old_unit(keyword))
        self.made.append((keyword, value, None if plain else own))

    def keep(self, name: str, value: Any) -> None:
        """Keep a value for a field of ``MesoControl``."""
        self.rest_.values[name] = value

    def remark(self, kind: str, text: str) -> None:
        """Note something about this line."""
        self.rest_.remarks.append(Remark(kind, text, self.number))  # type: ignore[arg-type]  # one of three words

    def numbers(self, keyword: str, most: int) -> list[float]:
        """Take up to ``most`` numbers, at least one; ``keyword`` is one of their kind."""
        found = [float(self.value(keyword))]
        while self.peek() and len(found) < most:
            found.append(float(self.value(keyword)))
        return found


Handler = Callable[[_MesoLine], None]


def parse_meso(lines: list[str], path: str, lenient: bool) -> Control:
    """Read the lines of a CONTROL in DL_MESO's dialect; see ``read_control`` for the arguments and errors."""
    reading, rest = Reading(path, lenient), _Rest()
    finished = False
    for number, raw in enumerate(lines[1:], start=2):
        words = re.sub(r"(^|\s)[#!].*", "", raw).split()
        if not words:
            continue
        if words[0].lower().startswith("finish"):
            finished = True
            break
        _read_directive(_MesoLine(reading, number, words, rest))
    if not finished:
        last = max((number for number, raw in enumerate(lines, start=1) if raw.strip()), default=1)
        reading.complain("is missing at the end of this CONTROL of DL_MESO", last, "finish")
    _complete(reading, rest)
    settings, warnings = tuple(reading.settings.values()), tuple(reading.warnings)
    title = lines[0].strip()
    return Control(title, settings, "new", path, warnings, tuple(rest.remarks), MesoControl(**rest.values))


def _read_directive(line: _MesoLine) -> None:
    first = line.words[0].lower()
    name = next((prefix for prefix in _DIRECTIVES if _begins(first, prefix)), None)
    if name is None:
        near = suggest(first, [words for words, _ in _DIRECTIVES.values()])
        line.reading.complain(f"is no directive of DL_MESO's CONTROL{near}", line.number, line.words[0])
        return
    _DIRECTIVES[name][1](line)
    for keyword, value, unit in line.made:
        before = line.reading.settings.pop(keyword, None)
        if before is not None:
            line.warn(f"{keyword} was given on line {before.line} already; the last line counts, as in DL_MESO")
        line.reading.add(Parsed(Setting(keyword, value, unit, line.number)), line.words[0])
    leftover = line.rest()
    if leftover:
        message = f"is left over after {_DIRECTIVES[name][0]}; a remark must begin with # or !"
        line.reading.complain(message, line.number, leftover)


def _begins(word: str, prefix: str) -> bool:
    """Whether a word is this directive; two letters alone would let any word pass."""
    return word == prefix if len(prefix) < 3 else word.startswith(prefix)


def _complete(reading: Reading, rest: _Rest) -> None:
    """Refuse a file without its required directives, and write out what the others' absence means."""
    given = reading.settings
    for keyword, directive in (("temperature", "temperature"), ("timestep", "timestep"), ("time_run", "steps")):
        if keyword not in given:
            reading.complain(f"is missing: a CONTROL of DL_MESO must give it ({keyword})", 1, directive)
    if "ensemble" not in given:
        rest.remarks.append(Remark("choice", "no ensemble is given: nvt mdvv, as in DL_MESO"))
        for keyword, value in (("ensemble", "nvt"), ("ensemble_method", "dpd"), ("ensemble_dpd_order", "mdvv")):
            given[keyword] = Setting(keyword, value)
    start, equilibration = given.get("traj_start"), given.get("time_equilibration")
    if start is not None and start.value == 0 and equilibration is not None and equilibration.value != 0:
        given["traj_start"] = Setting("traj_start", equilibration.value, "steps", start.line)
        text = "trajectory 0: HISTORY begins after the equilibration, as in DL_MESO"
        rest.remarks.append(Remark("choice", text, start.line))


# -- Directives -------------------------------------------------------------------------------------------------------


def _number(keyword: str, *fillers: str) -> Handler:
    def read(line: _MesoLine) -> None:
        line.take(*fillers) if fillers else None
        line.put_number(keyword)

    return read


def _without_effect(reason: str) -> Handler:
    def read(line: _MesoLine) -> None:
        line.remark("ignored", f"{' '.join(line.words)}: {reason}")
        line.rest()

    return read


def _refused(what: str, cure: str = "") -> Handler:
    def read(line: _MesoLine) -> None:
        raise line.error(f"asks for {what}, which is not read in DL_MESO's dialect{cure and f'; {cure}'}")

    return read


def _volume(line: _MesoLine) -> None:
    found = line.numbers("cutoff", 3)
    if len(found) == 1:
        found = [_cube_edge(found[0])] * 3
    elif len(found) == 2:
        raise line.error("takes one number, the volume of a cube, or three, the edges of the box")
    if not all(edge > 0.0 for edge in found):
        raise line.error("the box must have a volume above 0", line.words[1])
    line.keep("edges", tuple(found))
    line.keep("volume_line", line.number)


def _cube_edge(volume: float) -> float:
    """Return the cube root, whole where it is meant to be: 1000^(1/3) is 9.999… in floating point."""
    edge = abs(volume) ** (1.0 / 3.0)
    rounded = round(edge, 9)
    return (rounded if rounded**3 == abs(volume) else edge) if volume > 0.0 else 0.0


def _cutoff(line: _MesoLine) -> None:
    line.put_number("cutoff")
    line.keep("cutoff", float(line.made[-1][1]))  # type: ignore[arg-type]  # a number


def _other_cutoff(name: str, what: str) -> Handler:
    def read(line: _MesoLine) -> None:
        if not line.take("cut"):
            raise line.error(f"must be followed by cutoff and {what}")
        value = float(line.value("cutoff"))
        if not value > 0.0:
            raise line.error("a cutoff must be above 0")
        line.keep(name, value)

    return read


def _manybody(line: _MesoLine) -> None:
    line.remark("ignored", f"{' '.join(line.words)}: it acts only with mdpd, which FIELD would be refused for")
    line.rest()


def _print(line: _MesoLine) -> None:
    if line.take("part"):
        line.remark("ignored", "print partial: temperatures along x, y and z are not printed apart")
        return
    line.put_number("print_frequency")


def _trajectory(line: _MesoLine) -> None:
    line.put("traj_start", line.value("traj_start", 0))
    interval = line.value("traj_interval", 0)
    level = int(line.value("print_level", 0))
    if not 0 <= level <= 2:
        line.warn(f"the level {level} of trajectory is taken as {min(max(level, 0), 2)}, as in DL_MESO")
    line.put("traj_calculate", interval > 0)
    if interval > 0:
        line.put("traj_interval", interval)
    line.put("traj_key", LEVELS["traj_key"][min(max(level, 0), 2)])


def _seed(line: _MesoLine) -> None:
    seed = int(line.value("random_seed"))
    if seed < 0:
        raise line.error("the seed must not be negative", line.words[1])
    line.put("random_seed", (seed,))


def _no(line: _MesoLine) -> None:
    what = line.choose("word after no", {name: name for name in ("conf", "elec", "ind")})
    if what == "conf":
        line.keep("without_config", True)
    elif what == "elec":
        line.put("coul_method", "off")
    else:
        line.put("ignore_config_indices", True)


def _config(line: _MesoLine) -> None:
    line.choose("word after config", {"orig": "origin", "zero": "origin"})
    line.keep("corner_origin", True)


def _restart(line: _MesoLine) -> None:
    if line.peek():
        raise line.error(f"{line.raw()} asks to start from DL_MESO's export file, which cannot be read; use a CONFIG")
    line.put("restart", "continue")


def _ewald(line: _MesoLine) -> None:
    line.put("coul_method", "spme")
    if line.take("prec"):
        line.put_number("spme_precision")
        return
    line.take("sum")
    line.put_number("spme_alpha")
    line.put_vector("spme_kvec", 3)
    if line.peek():
        line.put_number("spme_nsplines")


def _bjerrum(line: _MesoLine) -> None:
    line.take("length")
    line.put_number("coul_bjerrum_length")


_ORDERS = {
    "mdvv": "mdvv",
    "dpdvv": "dpdvv",
    "dpds0": "zeroth",
    "dpds1": "first",
    "dpds2": "second",
    "lowe": "lowe-andersen",
    "peters": "peters",
    "stoyanov": "stoyanov-groot",
}


def _ensemble(line: _MesoLine) -> None:
    ensemble = line.choose("ensemble", {name: name for name in ("nvt", "npt", "nst")})
    line.put("ensemble", ensemble)
    line.put("ensemble_method", "dpd")
    order = line.choose(f"method of {ensemble}", _ORDERS)
    line.put("ensemble_dpd_order", order)
    if order == "stoyanov-groot" and line.peek() and not line.peek().isalpha():
        line.put_number("ensemble_dpd_coupling")
        text = "the coupling of stoyanov is taken as the drag of the pairs not chosen; integrators.md has the formula"
        line.remark("choice", text)
    if ensemble == "nvt":
        return
    if line.take("ber"):
        raise line.error("the Berendsen barostat is not modelled; langevin is", line.words[line.position - 1])
    line.choose("barostat", {"lang": "langevin"})
    line.put_number("ensemble_barostat_coupling")
    line.put_number("ensemble_barostat_friction")
    if ensemble == "nst":
        read_cell_constraint(line)


_DIRECTIVES: dict[str, tuple[str, Handler]] = {
    "bjer": ("bjerrum length", _bjerrum),
    "bound": ("boundary halo", _without_effect("pydlpoly sizes its link cells itself")),
    "rhalo": ("rhalo", _without_effect("pydlpoly sizes its link cells itself")),
    "conf": ("config", _config),
    "close": ("close time", _number("time_close")),
    "cut": ("cutoff", _cutoff),
    "rcut": ("rcut", _cutoff),
    "densvar": ("densvar", _number("density_variance")),
    "elec": ("electrostatic cutoff", _other_cutoff("charge_cutoff", "the range of the real-space sum")),
    "ensemble": ("ensemble", _ensemble),
    "equil": ("equilibration steps", _number("time_equilibration")),
    "ewald": ("ewald", _ewald),
    "froz": ("frozen", _refused("walls of frozen beads", "a new-style CONTROL has wall_method")),
    "global": ("global bonds", _without_effect("it says how DL_MESO shares out bonds among processors")),
    "io": ("io write", _without_effect("pydlpoly writes files in one way only")),
    "job": ("job time", _number("time_job")),
    "l_init": ("l_init", _without_effect("CFGINI is not written; pydlpoly convert writes the start as a CONFIG")),
    "l_scr": ("l_scr", lambda line: line.put("io_file_output", "SCREEN")),
    "many": ("manybody cutoff", _manybody),
    "mxshak": ("mxshak", _number("shake_max_iter")),
    "ndump": ("ndump", _number("data_dump_frequency")),
    "nfold": ("nfold", lambda line: line.put_vector("nfold", 3)),
    "no": ("no", _no),
    "openmp": ("openmp", _without_effect("it says how DL_MESO's threads add up forces")),
    "perm": ("permittivity", _refused("a permittivity", "give a bjerrum length")),
    "pres": ("pressure", _number("pressure_hydrostatic")),
    "print": ("print every", _print),
    "restart": ("restart", _restart),
    "scale": ("scale temperature every", _number("rescale_frequency")),
    "seed": ("seed", _seed),
    "shake": ("shake tolerance", _number("shake_tolerance")),
    "smear": ("smear", _refused("smeared charges", "a new-style CONTROL has charge_smearing_method")),
    "spme": ("spme", _ewald),
    "stack": ("stack size", _number("stack_size")),
    "stats": ("stats every", _number("stats_frequency")),
    "steps": ("steps", _number("time_run")),
    "stres": ("stress", _refused("a file of stresses", "STATIS and DIAGNOSTICS hold them")),
    "surf": ("surface", _refused("walls or sheared faces", "a new-style CONTROL has wall_method and shear_rate")),
    "temp": ("temperature", _number("temperature")),
    "therm": ("thermostat cutoff", _other_cutoff("drag_cutoff", "the range of all drags")),
    "timestep": ("timestep", _number("timestep")),
    "traj": ("trajectory", _trajectory),
    "vacu": ("vacuum", _refused("a vacuum gap")),
    "vol": ("volume", _volume),
}
"""Leading letters, the directive in full, and what reads it; the first match counts."""
