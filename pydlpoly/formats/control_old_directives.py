"""What each directive of an old-style CONTROL file means in new-style settings."""

from __future__ import annotations

from collections.abc import Callable

from pydlpoly.errors import suggest
from pydlpoly.formats.control_old_ensemble import read_ensemble
from pydlpoly.formats.control_old_line import Line
from pydlpoly.formats.control_old_tables import (
    LEVELS,
    MIX_RULES,
    NEGATIONS,
    NUMBERS,
    SEQUENCES,
    SWITCHES,
    WITHOUT_EFFECT,
)
from pydlpoly.formats.keywords import KEYWORDS, lookup

Handler = Callable[[Line], None]


# -- Directives that fit into no table --------------------------------------------------------------------------------


def _pressure(line: Line) -> None:
    if line.take("tensor"):
        line.put_vector("pressure_tensor", 6)
    else:
        line.put_number("pressure_hydrostatic")


def _variable(line: Line) -> None:
    if not line.take("timestep"):
        raise line.error("must be followed by timestep")
    line.put_number("timestep")
    line.put("timestep_variable", True)


def _old_padding(line: Line) -> None:
    width = float(line.value("padding"))
    line.put("padding", width / 4.0)
    line.warn(f"delr {width:g} is a padding of {width / 4.0:g} ang, as in DL_POLY 4")


def _no(line: Line) -> None:
    if line.take("link"):
        line.warn("'no link' has no effect: link cells are always used")
        return
    name = line.choose("word after no", {name[:5]: name for name in NEGATIONS})
    line.put(*NEGATIONS[name])


def _vdw(line: Line) -> None:
    what = line.choose(
        "vdw option", {"direct": "direct", "shift": "shift", "ewald": "spme", "spme": "spme", "mix": "mix"}
    )
    if what == "shift":
        line.put("vdw_force_shift", True)
    elif what == "mix":
        line.put("vdw_mix_method", line.choose("mixing rule", {rule[:4]: rule for rule in MIX_RULES}))
    else:
        line.put("vdw_method", what)


def _ewald(line: Line) -> None:
    if line.take("eval"):
        line.value("print_frequency")
        line.warn("'ewald evaluate' has no effect: it is a directive of DL_POLY Classic")
        return
    line.put("coul_method", "spme")
    if line.take("prec"):
        line.put_number("spme_precision")
    else:
        line.put_number("spme_alpha")
        line.put_vector("spme_kvec", 3)
    if line.peek():
        line.put_number("spme_nsplines")


def _truncated(method: str) -> Handler:
    def read(line: Line) -> None:
        line.take("field", "force")
        line.put("coul_method", method)
        if line.take("damp"):
            line.put_number("coul_damping")
        elif line.take("prec"):
            line.put_number("coul_precision")

    return read


def _print(line: Line) -> None:
    for name in ("rdf", "zden", "vaf"):
        if line.take(name):
            line.put(f"{name}_print", True)
            return
    if line.take("ana"):
        line.warn("'print analysis' has no effect: it was removed from DL_POLY")
        return
    line.put_number("print_frequency")


def _rdf(line: Line) -> None:
    line.put("rdf_calculate", True)
    if line.take("error"):
        line.put("rdf_error_analysis", line.choose("error analysis", {"jack": "jackknife", "block": "block"}))
        line.put_number("rdf_error_analysis_blocks", 1)
    line.put_number("rdf_frequency", 1)


def _analyse(line: Line) -> None:
    kinds = {"all": "", "bon": "_bonds", "ang": "_angles", "dih": "_dihedrals", "inv": "_inversions"}
    kind = line.choose("bonded term", kinds)
    line.put(f"analyse{kind or '_all'}", True)
    line.put_number(f"analyse_frequency{kind}", 1)
    if line.peek():
        line.put_number(f"analyse_num_bins{kind}")
    if line.peek() and not kind:
        line.put_number("analyse_max_dist")


def _restart(line: Line) -> None:
    if not line.peek():
        line.put("restart", "continue")
        return
    line.put("restart", line.choose("restart", {"noscale": "noscale", "unscale": "noscale", "scale": "rescale"}))


def _seed(line: Line) -> None:
    line.put("random_seed", (line.value("random_seed"), line.value("random_seed"), line.value("random_seed", 0)))


def _minimise(line: Line) -> None:
    criteria = {name: name for name in ("force", "energy", "distance")}
    line.put("minimisation_criterion", line.choose("minimisation criterion", criteria))
    if line.words[0].lower().startswith("minim"):
        line.put_number("minimisation_frequency", 1)
    line.put_number("minimisation_tolerance", 0.0)
    line.put_number("minimisation_step_length", -1.0)


def _impact(line: Line) -> None:
    line.put_number("impact_part_index")
    line.put_number("impact_time")
    line.put_number("impact_energy")
    line.put_vector("impact_direction", 3)


def _pseudo(line: Line) -> None:
    method = "langevin-direct"
    if line.peek().isalpha():
        words = {"langevin": "langevin", "gauss": "gaussian", "direct": "direct"}
        method = line.choose("pseudo thermostat", words)
    line.put("pseudo_thermostat_method", method)
    line.put_number("pseudo_thermostat_width", 2.0)
    line.put_number("pseudo_thermostat_temperature", 0.0)


def _polarisation(line: Line) -> None:
    line.take("scheme", "type")
    line.put("polarisation_model", line.choose("polarisation", {"charmm": "charmm", "default": "default"}))
    if line.take("thole"):
        line.put_number("polarisation_thole")


def _plumed(line: Line) -> None:
    for name in ("input", "log"):
        if line.take(name):
            line.put(f"plumed_{name}", line.text(f"plumed {name}"))
            return
    if line.take("prec"):
        line.put_number("plumed_precision")
    elif line.take("restart"):
        line.put("plumed_restart", line.choose("plumed restart", {"yes": "y", "no": ""}) == "y")
    else:
        line.put("plumed", line.choose("plumed", {"on": "y", "off": ""}) == "y")


def _metal(line: Line) -> None:
    line.put(f"metal_{line.choose('metal option', {'direct': 'direct', 'sqrtrho': 'sqrtrho'})}", True)


def _integrator(line: Line) -> None:
    if line.take("leap"):
        raise line.error("asks for leapfrog, which is not modelled; DL_POLY 5 has velocity Verlet only")
    line.choose("integrator", {"vel": "velocity", "vv": "velocity"})
    line.take("verlet")


def _replay(line: Line) -> None:
    line.put("replay", True)
    line.take("hist")
    line.put("replay_calculate_forces", line.take("force"))


def _io(line: Line) -> None:
    verb = line.peek()
    if verb in ("read", "write"):
        line.position += 1
        methods = {"mpiio": "mpiio", "direct": "direct", "master": "master", "netcdf": "netcdf"}
        line.put(f"io_{verb}_method", line.choose(f"io {verb} method", methods))
        sizes = ("readers" if verb == "read" else "writers", "batch_size", "buffer_size")
        for name in sizes:
            if line.peek():
                line.put_number(f"io_{verb}_{name}")
        return
    keyword = lookup(f"io_file_{verb}")
    if keyword is None or not verb:
        raise line.error(f"is no file of CONTROL's io directive{suggest(verb, FILES)}", line.raw() or None)
    line.position += 1
    line.put(keyword.keyword, line.text(f"io {verb}"))


FILES = tuple(word.removeprefix("io_file_") for word in KEYWORDS if word.startswith("io_file_"))


def _number(name: str) -> Handler:
    _, keyword, default = NUMBERS[name]
    return lambda line: line.put_number(keyword, default)


def _switch(name: str) -> Handler:
    def read(line: Line) -> None:
        for keyword, value in SWITCHES[name]:
            line.put(keyword, value)

    return read


def _sequence(name: str) -> Handler:
    switch, members = SEQUENCES[name]

    def read(line: Line) -> None:
        if switch is not None:
            line.put(switch, True)
        for position, (keyword, default) in enumerate(members):
            if name == "binsize" and position:  # one number stands for both kinds of bins
                line.put(keyword, line.made[0][1])
                continue
            number = line.value(keyword, default if switch is not None or position else None)
            if keyword not in LEVELS:
                line.put(keyword, number)
            elif 0 <= number < len(LEVELS[keyword]):
                line.put(keyword, LEVELS[keyword][int(number)])
            else:
                raise line.error(f"is beyond the levels 0 to {len(LEVELS[keyword]) - 1}", line.words[line.position - 1])

    return read


def _without_effect(name: str) -> Handler:
    def read(line: Line) -> None:
        line.warn(f"{line.words[0]!r} has no effect: {WITHOUT_EFFECT[name]}")
        line.rest()

    return read


HANDLERS: dict[str, Handler] = {
    **{letters: _number(name) for name, (letters, _, _) in NUMBERS.items()},
    **{name if "_" in name else name[:5]: _switch(name) for name in SWITCHES},
    **{name if len(name) < 5 else name[:4]: _sequence(name) for name in SEQUENCES},
    **{name: _without_effect(name) for name in WITHOUT_EFFECT},
    **{"pres": _pressure, "variable": _variable, "delr": _old_padding, "rcut": _number("cutoff")},
    **{"rpad": _number("padding"), "no": _no, "vdw": _vdw, "ewald": _ewald, "spme": _ewald, "print": _print},
    **{"shift": _truncated("force_shifted"), "reaction": _truncated("reaction_field"), "rdf": _rdf, "ana": _analyse},
    **{"restart": _restart, "seed": _seed, "nfold": lambda line: line.put_vector("nfold", 3), "minim": _minimise},
    **{"optim": _minimise, "impact": _impact, "pseudo": _pseudo, "polar": _polarisation, "plumed": _plumed},
    **{"metal": _metal, "integr": _integrator, "replay": _replay, "io": _io, "ens": read_ensemble},
}
"""Reader of each directive by its leading letters; two-letter ones must stand alone."""


def find_directive(word: str) -> str | None:
    """Return the leading letters under which a word is a directive, or None.

    New-style names, which have underscores, are directives only when they are one letter by letter (``l_scr``).
    """
    if word in HANDLERS:
        return word
    if "_" in word:
        return None
    return next((letters for letters in _BY_LENGTH if word.startswith(letters)), None)


_BY_LENGTH = sorted((letters for letters in HANDLERS if len(letters) > 2 and letters != "all"), key=len, reverse=True)


NAMES = (
    *(*NUMBERS, *SWITCHES, *SEQUENCES, *WITHOUT_EFFECT, "pressure", "variable", "delr", "rcut", "rpad", "no", "vdw"),
    *("ewald", "spme", "print", "shift", "reaction", "rdf", "analyse", "restart", "seed", "nfold", "minimise"),
    *("optimise", "replay", "impact", "pseudo", "polarisation", "plumed", "metal", "integrator", "io", "ensemble"),
    "finish",
)
"""All directives in full, for suggestions."""


def is_directive(word: str) -> bool:
    """Return whether a word begins an old-style line."""
    return word.lower() == "finish" or find_directive(word.lower()) is not None
