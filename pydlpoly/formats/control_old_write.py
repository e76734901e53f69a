"""Writes a CONTROL record as an old-style file, by the tables the old-style reader uses."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

from pydlpoly.errors import InputError
from pydlpoly.formats.control_old_ensemble import write_ensemble
from pydlpoly.formats.control_old_tables import LEVELS, MIX_RULES, NEGATIONS, NUMBERS, SEQUENCES, SWITCHES, old_unit
from pydlpoly.formats.control_values import default_setting, effect_of, format_number
from pydlpoly.formats.keywords import KEYWORDS
from pydlpoly.formats.records import Control, Setting, SettingValue
from pydlpoly.units import convert, parse_unit

_NUMBER_OF = {keyword: name for name, (_, keyword, _) in NUMBERS.items()}
_SWITCH_OF = {made[0]: name for name, made in SWITCHES.items() if len(made) == 1 and not name.startswith("l_scr")}
_NEGATION_OF = {made: name for name, made in NEGATIONS.items()}
_SEQUENCE_OF = {switch or members[0][0]: name for name, (switch, members) in SEQUENCES.items()}


_ACTS_WITH = {
    **{member: switch for switch, members in SEQUENCES.values() for member, _ in members},
    "rdf_frequency": "rdf_calculate",
}


class _Writer:
    """Lines of the file, and the settings that no line stands for yet."""

    def __init__(self, control: Control) -> None:
        self.control = control
        self.left = {setting.keyword: setting for setting in control}
        self.lines: list[str] = []

    def number(self, keyword: str, default: float | None = None) -> str:
        """Use a setting up and return its number in the unit that the old style implies."""
        setting = self.left.pop(keyword, None)
        if setting is None:
            return format_number(default or 0)
        if keyword in LEVELS:
            return str(LEVELS[keyword].index(str(setting.value)))
        numbers = setting.value if isinstance(setting.value, tuple) else (setting.value,)
        return " ".join(self._in_old_unit(setting, number) for number in numbers if not isinstance(number, str))

    def _in_old_unit(self, setting: Setting, number: float) -> str:
        implied = old_unit(setting.keyword) or ""
        dimension = KEYWORDS[setting.keyword].dimension
        if dimension in ("integers", "any") or parse_unit(setting.unit or "") == parse_unit(implied):
            return format_number(number)
        timestep = self.control.get("timestep")
        step = None if timestep is None else convert(float(timestep.value), timestep.unit or "", "time", timestep=1.0)  # type: ignore[arg-type]  # a float keyword
        value = convert(number, setting.unit or "", dimension, timestep=step)
        value /= convert(1.0, implied, dimension, timestep=step)
        return str(round(value)) if dimension == "steps" else format_number(value)


def write_old(control: Control) -> str:
    """Return the text of an old-style file.

    Settings without an old-style form are left out when they have the table's default or act only together with a
    switch that is off; any other is an error, since the file would mean something else.

    Raises:
        InputError: a setting cannot be said in the old style.
    """
    control = _with_new_defaults(control)
    writer = _Writer(control)
    for setting in control:
        if setting.keyword in writer.left:
            line = _line(writer, setting)
            if line is not None:
                writer.lines.append(line)
    for setting in writer.left.values():
        _require_droppable(writer, setting)
    title = re.sub(r"[\r\n]", " ", control.title).strip()
    return "\n".join([title, *writer.lines, "finish"]) + "\n"


Special = Callable[[_Writer, SettingValue], str | None]


def _line(writer: _Writer, setting: Setting) -> str | None:
    """Return the line that begins with this setting, using up all settings it stands for, or None if there is none."""
    keyword, value = setting.keyword, setting.value
    if keyword == "timestep" and "timestep_variable" in writer.left and writer.left["timestep_variable"].value:
        del writer.left["timestep_variable"]
        return f"variable timestep {writer.number('timestep')}"
    if keyword in _NUMBER_OF:
        return (
            f"{_NUMBER_OF[keyword]} {'time ' if keyword in ('time_job', 'time_close') else ''}{writer.number(keyword)}"
        )
    if keyword in _SEQUENCE_OF and (value is not False):
        return _sequence(writer, keyword)
    for table, form in ((_SWITCH_OF, "{}"), (_NEGATION_OF, "no {}")):
        if not isinstance(value, tuple) and (keyword, value) in table and keyword != "coul_method":
            del writer.left[keyword]
            return form.format(table[keyword, value])
    special = _SPECIAL.get(keyword)
    if special is not None:
        return special(writer, value)
    if keyword.startswith("io_file_") and not re.search(r"(^|\s)[#!]|[\r\n]", str(value)):
        del writer.left[keyword]
        return f"io {keyword.removeprefix('io_file_')} {value}"
    return None


def _with_new_defaults(control: Control) -> Control:
    """Say in full where the defaults of the styles differ, so that the file means what the record means."""
    given = {setting.keyword for setting in control}
    more = [Setting(keyword, 0, "steps") for keyword in ("print_frequency", "stats_frequency") if keyword not in given]
    more += [
        Setting(f"{name}_print", True)
        for name in ("rdf", "zden", "vaf")
        if f"{name}_calculate" in given and f"{name}_print" not in given
    ]
    return replace(control, settings=(*control.settings, *more))


def _sequence(writer: _Writer, keyword: str) -> str:
    name = _SEQUENCE_OF[keyword]
    switch, members = SEQUENCES[name]
    if switch is not None:
        del writer.left[switch]
    if name == "binsize":
        return f"binsize {_bin_size(writer)}"
    return " ".join([name, *(writer.number(member, default) for member, default in members)])


def _bin_size(writer: _Writer) -> str:
    rdf = writer.number("rdf_binsize")
    other = writer.number("zden_binsize") if "zden_binsize" in writer.left else rdf
    if other != rdf:
        message = "rdf_binsize and zden_binsize differ; the old style has one binsize for both"
        raise InputError(message, path=writer.control.path)
    return rdf


def _pop_numbers(writer: _Writer, *keywords: str) -> str:
    return "".join(f" {writer.number(keyword)}" for keyword in keywords if keyword in writer.left)


def _print_rate(writer: _Writer, _: SettingValue) -> str:
    return f"print {writer.number('print_frequency')}"


def _coulomb(writer: _Writer, value: SettingValue) -> str | None:
    if value == "ewald_direct":
        return None  # the old style has no word for it
    del writer.left["coul_method"]
    if value == "off":
        return "no elec"
    if value in ("pairwise", "dddp"):
        return "coul" if value == "pairwise" else "distan"
    if value == "spme":
        if "spme_alpha" in writer.left:
            text = f"ewald sum{_pop_numbers(writer, 'spme_alpha', 'spme_kvec')}"
        else:
            text = f"ewald precision {writer.number('spme_precision', 1e-6)}"
        return text + _pop_numbers(writer, "spme_nsplines")
    text = "shift" if value == "force_shifted" else "reaction"
    for keyword, word in (("coul_damping", "damp"), ("coul_precision", "precision")):
        if keyword in writer.left:
            return f"{text} {word} {writer.number(keyword)}"
    return text


def _rdf(writer: _Writer, value: SettingValue) -> str | None:
    if not value:
        return None
    del writer.left["rdf_calculate"]
    errors = writer.left.pop("rdf_error_analysis", None)
    text = "rdf"
    if errors is not None and errors.value != "off":
        text += f" errors {errors.value} {writer.number('rdf_error_analysis_blocks', 1)}"
    return f"{text} every {writer.number('rdf_frequency', 1)}"


def _analyse(name: str, word: str) -> Special:
    def write(writer: _Writer, value: SettingValue) -> str | None:
        if not value:
            return None
        del writer.left[f"analyse{name or '_all'}"]
        text = f"analyse {word} every {writer.number(f'analyse_frequency{name}', 1)}"
        if f"analyse_num_bins{name}" in writer.left:
            text += f" nbins {writer.number(f'analyse_num_bins{name}')}"
            if not name and "analyse_max_dist" in writer.left:
                text += f" rmax {writer.number('analyse_max_dist')}"
        return text

    return write


def _minimise(writer: _Writer, value: SettingValue) -> str | None:
    if value == "off":
        return None
    del writer.left["minimisation_criterion"]
    text = f"optimise {value}"
    if "minimisation_frequency" in writer.left:
        text = f"minimise {value} every {writer.number('minimisation_frequency')}"
    return f"{text} {writer.number('minimisation_tolerance')} {writer.number('minimisation_step_length', -1.0)}"


def _impact(writer: _Writer, value: SettingValue) -> str | None:
    if not value:
        return None
    direction = writer.left.pop("impact_direction", None) or default_setting("impact_direction")
    assert direction is not None
    assert isinstance(direction.value, tuple)
    numbers = [writer.number(f"impact_{name}") for name in ("part_index", "time", "energy")]
    return " ".join(["impact", *numbers, *map(format_number, direction.value)])


def _pseudo(writer: _Writer, value: SettingValue) -> str | None:
    if value == "off":
        return None
    del writer.left["pseudo_thermostat_method"]
    width = writer.number("pseudo_thermostat_width", 2.0)
    word = "" if value == "langevin-direct" else f"{value} "
    return f"pseudo {word}{width} {writer.number('pseudo_thermostat_temperature', 0.0)}"


def _polarisation(writer: _Writer, value: SettingValue) -> str:
    del writer.left["polarisation_model"]
    thole = _pop_numbers(writer, "polarisation_thole")
    return f"polarisation {value}" + (f" thole{thole}" if thole else "")


def _io_method(verb: str) -> Special:
    def write(writer: _Writer, value: SettingValue) -> str:
        del writer.left[f"io_{verb}_method"]
        sizes = ("readers" if verb == "read" else "writers", "batch_size", "buffer_size")
        given = [f"io_{verb}_{name}" for name in sizes]
        last = max((i for i, keyword in enumerate(given, start=1) if keyword in writer.left), default=0)
        return " ".join([f"io {verb} {value}", *(writer.number(keyword) for keyword in given[:last])])

    return write


def _words(keyword: str, form: str, names: dict[SettingValue, str] | None = None) -> Special:
    """Make a writer of ``form`` with the value, or with its name in ``names``, where a missing name means no line."""

    def write(writer: _Writer, value: SettingValue) -> str | None:
        if names is not None and value not in names:
            return None
        del writer.left[keyword]
        return f"{form} {names[value] if names is not None else value}".strip()

    return write


def _numbers(keyword: str, form: str) -> Special:
    return lambda writer, _: f"{form} {writer.number(keyword)}"


def _print(name: str) -> Special:
    def write(writer: _Writer, value: SettingValue) -> str | None:
        del writer.left[f"{name}_print"]  # without a line the old style does not print
        return f"print {name}" if value else None

    return write


def _replay(writer: _Writer, value: SettingValue) -> str | None:
    if not value:
        return None
    del writer.left["replay"]
    forces = writer.left.pop("replay_calculate_forces", None)
    return "replay history" + (" force" if forces is None or forces.value else "")


def _seed(writer: _Writer, value: SettingValue) -> str:
    if isinstance(value, tuple) and len(value) != 3:
        raise InputError("a single seed has no form in the old style, which takes three", path=writer.control.path)
    return f"seed {writer.number('random_seed')}"


def _ensemble(writer: _Writer, _: SettingValue) -> str:
    text, used = write_ensemble(writer.left, writer.number)
    for keyword in used:
        writer.left.pop(keyword, None)
    return text


_SPECIAL: dict[str, Special] = {
    "print_frequency": _print_rate,
    "coul_method": _coulomb,
    "rdf_calculate": _rdf,
    **{f"{name}_print": _print(name) for name in ("rdf", "zden", "vaf")},
    **{
        f"analyse{name or '_all'}": _analyse(name, word)
        for name, word in (
            ("", "all"),
            ("_bonds", "bonds"),
            ("_angles", "angles"),
            ("_dihedrals", "dihedrals"),
            ("_inversions", "inversions"),
        )
    },
    "ensemble": _ensemble,
    "minimisation_criterion": _minimise,
    "impact_part_index": _impact,
    "pseudo_thermostat_method": _pseudo,
    "polarisation_model": _polarisation,
    "io_read_method": _io_method("read"),
    "io_write_method": _io_method("write"),
    "restart": _words("restart", "restart", {"continue": "", "noscale": "noscale", "rescale": "scale"}),
    "vdw_method": _words("vdw_method", "vdw", {"direct": "direct", "spme": "ewald"}),
    "vdw_mix_method": _words("vdw_mix_method", "vdw mixing", {rule: rule for rule in MIX_RULES}),
    "vdw_force_shift": _words("vdw_force_shift", "vdw", {True: "shift"}),
    "metal_direct": _words("metal_direct", "metal", {True: "direct"}),
    "metal_sqrtrho": _words("metal_sqrtrho", "metal", {True: "sqrtrho"}),
    "plumed": _words("plumed", "plumed", {True: "on", False: "off"}),
    "plumed_restart": _words("plumed_restart", "plumed restart", {True: "yes", False: "no"}),
    "plumed_input": _words("plumed_input", "plumed input"),
    "plumed_log": _words("plumed_log", "plumed log"),
    "plumed_precision": _numbers("plumed_precision", "plumed precision"),
    "pressure_hydrostatic": _numbers("pressure_hydrostatic", "pressure"),
    "pressure_tensor": _numbers("pressure_tensor", "pressure tensor"),
    "random_seed": _seed,
    "replay": _replay,
    "nfold": _numbers("nfold", "nfold"),
}
"""Writers of the lines that fit into no table, by the keyword they begin at."""


def _require_droppable(writer: _Writer, setting: Setting) -> None:
    """Raise an error when leaving a setting out would change what the file means."""
    default = default_setting(setting.keyword)
    if default is not None and default.value == setting.value and (default.unit or "") == (setting.unit or ""):
        return
    switch = _ACTS_WITH.get(setting.keyword)
    given = None if switch is None else writer.control.get(switch)
    if switch is not None and (given is None or not given.value):
        return
    if effect_of(setting).kind != "ignored":
        message = f"{setting.keyword} {setting.value} has no form in the old style; write the new style"
        raise InputError(message, path=writer.control.path, line=setting.line or None, word=setting.keyword)
