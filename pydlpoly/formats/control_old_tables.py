"""The directives of old-style CONTROL files that fit into tables, for the reader and the writer."""

from __future__ import annotations

from pydlpoly.formats.keywords import KEYWORDS
from pydlpoly.formats.records import SettingValue

NUMBERS: dict[str, tuple[str, str, float | None]] = {
    "temperature": ("temp", "temperature", None),
    "timestep": ("timestep", "timestep", None),
    "mindis": ("mindis", "timestep_variable_min_dist", None),
    "maxdis": ("maxdis", "timestep_variable_max_dist", None),
    "mxstep": ("mxstep", "timestep_variable_max_delta", None),
    "steps": ("steps", "time_run", None),
    "equilibration": ("equil", "time_equilibration", None),
    "cutoff": ("cut", "cutoff", None),
    "padding": ("pad", "padding", None),
    "rvdw": ("rvdw", "vdw_cutoff", None),
    "densvar": ("densvar", "density_variance", None),
    "eps": ("eps", "coul_dielectric_constant", None),
    "stats": ("stats", "stats_frequency", None),
    "stack": ("stack", "stack_size", None),
    "cap": ("cap", "equilibration_force_cap", 1000.0),
    "scale": ("scale", "rescale_frequency", 1),
    "regauss": ("regaus", "regauss_frequency", 1),
    "zero": ("zero", "reset_temperature_interval", 1),
    "dump": ("dump", "data_dump_frequency", None),
    "job": ("job", "time_job", None),
    "close": ("close", "time_close", None),
    "shake": ("shake", "shake_tolerance", None),
    "mxshak": ("mxshak", "shake_max_iter", None),
    "subcell": ("subcell", "subcell_threshold", None),
    "l_dis": ("l_dis", "initial_minimum_separation", 0.5),
    "l_print": ("l_print", "print_level", None),
}
"""Directives of one number: leading letters, keyword, and the number that is meant when there is none."""

SWITCHES: dict[str, tuple[tuple[str, SettingValue], ...]] = {
    "collect": (("record_equilibration", True),),
    "exclude": (("coul_extended_exclusion", True),),
    "coul": (("coul_method", "pairwise"),),
    "distan": (("coul_method", "dddp"),),
    "yml_statis": (("io_statis_yaml", True),),
    "yml_rdf": (("io_rdf_yaml", True),),
    "heat_flux": (("heat_flux", True),),
    "pp_dump": (("write_per_particle", True),),
    "l_scr": (("io_file_output", "SCREEN"),),
    "l_tor": (("io_file_revcon", "NONE"), ("io_file_revive", "NONE")),
    "l_eng": (("output_energy", True),),
    "l_rout": (("io_write_ascii_revive", True),),
    "l_rin": (("io_read_ascii_revold", True),),
    "l_fast": (("unsafe_comms", True),),
}
"""Directives without a number and the settings they stand for."""

SEQUENCES: dict[str, tuple[str | None, tuple[tuple[str, float], ...]]] = {
    "trajectory": ("traj_calculate", (("traj_start", 0), ("traj_interval", 1), ("traj_key", 0))),
    "msdtmp": ("msd_calculate", (("msd_start", 0), ("msd_frequency", 1))),
    "defects": ("defects_calculate", (("defects_start", 0), ("defects_interval", 1), ("defects_distance", 0.75))),
    "displacements": (
        "displacements_calculate",
        (("displacements_start", 0), ("displacements_interval", 1), ("displacements_distance", 0.75)),
    ),
    "coord": ("coord_calculate", (("coord_ops", 0), ("coord_start", 0), ("coord_interval", 100))),
    "adf": ("adf_calculate", (("adf_frequency", 100), ("adf_precision", 0.0))),
    "zden": ("zden_calculate", (("zden_frequency", 1),)),
    "vaf": ("vaf_calculate", (("vaf_frequency", 1), ("vaf_binsize", 0))),
    "binsize": (None, (("rdf_binsize", 0.05), ("zden_binsize", 0.05))),
    "rlxtol": (None, (("rlx_tol", 1.0), ("rlx_cgm_step", -1.0))),
}
"""Directives that switch a keyword on (or none) and are followed by numbers in this order, each with its default."""

LEVELS = {"traj_key": ("pos", "pos-vel", "pos-vel-force", "compressed"), "coord_ops": ("icoord", "ccoord", "full")}
"""Options that the old style numbers from 0."""

NEGATIONS: dict[str, tuple[str, SettingValue]] = {
    "vdw": ("vdw_method", "off"),
    "elec": ("coul_method", "off"),
    "index": ("ignore_config_indices", True),
    "strict": ("strict_checks", False),
    "topology": ("print_topology_info", False),
    "vafav": ("vaf_averaging", False),
    "vom": ("fixed_com", False),
}
"""What may follow ``no``; ``no vom`` lets the centre of mass drift."""

MIX_RULES = (
    "lorentz-berthelot",
    "fender-halsey",
    "hogervorst",
    "halgren",
    "waldman-hagler",
    "tang-toennies",
    "functional",
)

_UNITS = {
    "time": "ps",
    "length": "ang",
    "steps": "steps",
    "temperature": "K",
    "inverse length": "ang^-1",
    "rate": "ps^-1",
}
_OWN_UNITS = {
    "time_job": "s",
    "time_close": "s",
    "density_variance": "%",
    "equilibration_force_cap": "k_b.temp/ang",
    "rlx_tol": "internal_f",
    "impact_energy": "ke.V",
    "ensemble_tension": "dyn/cm",
    "ensemble_dpd_drag": "Da/ps",
    "pressure_hydrostatic": "katm",
    "pressure_tensor": "katm",
}

UNIT_NAMES = {
    **dict.fromkeys(("a", "angs", "angstrom", "angstroms"), "ang"),
    **dict.fromkeys(("kelvin", "kelvins"), "K"),
    **dict.fromkeys(("picosecond", "picoseconds"), "ps"),
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("katms", "kiloatmospheres"), "katm"),
    "step": "steps",
}
FILLERS = frozenset(
    (
        *("every", "step", "steps", "size", "width", "cutoff", "cut", "tolerance", "tol", "force", "forces", "temp"),
        *("temperature", "time", "times", "sampling", "threshold", "density", "sum", "bin", "fire", "frequency"),
        *("interval", "nbins", "rmax"),
    )
)
"""Words that may stand before a number and mean nothing."""

WITHOUT_EFFECT = {
    "slab": "it shapes DL_POLY's domains",
    "mult": "DL_POLY Classic's multiple timestep",
    "primary": "DL_POLY Classic's primary cutoff",
    "all": "DL_POLY Classic's all-pairs switch",
    "quater": "DL_POLY Classic's quaternion tolerance",
    "l_tim": "it times DL_POLY",
}
NOT_MODELLED = {
    "ttm": "the two-temperature model",
    "evb": "empirical valence bonds",
    "ffs": "forward flux sampling",
    "l_his": "a HISTORY made from a HISTORY",
    "l_org": "a shift of CONFIG's origin",
    "l_scl": "a CONFIG scaled to another cell",
}


def old_unit(keyword: str) -> str | None:
    """Return the unit that the old style implies for a keyword, or None for plain numbers."""
    row = KEYWORDS[keyword]
    return _OWN_UNITS.get(keyword) or (_UNITS.get(row.dimension) if row.kind != "int" else None)
