"""The one table of CONTROL keywords: what each is called, what it takes, what it means and what pydlpoly does with it.

The readers, the writers, the scene and the documentation all read this table; a keyword exists if and only if it has a
row here. ``effect`` says what a setting does: ``used``, ``ignored: why`` (read and reported, no influence on the
physics) or ``refused: what is not modelled`` (any value but the default, which switches it off, stops the run).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from pydlpoly.errors import suggest

Kind = Literal["int", "float", "steps", "bool", "option", "string", "vector"]


@dataclass(frozen=True)
class Keyword:
    """One keyword of CONTROL.

    Attributes:
        keyword: canonical new-style name.
        kind: what kind of value it takes; ``vector`` is numbers in brackets.
        default: the value without the keyword, as new-style text with its unit; empty when there is none.
        meaning: one phrase for the documentation.
        effect: ``used``, ``ignored: why`` or ``refused: what is not modelled``.
        dimension: key of ``pydlpoly.units.DIMENSIONS``, ``any`` (unit depends on another keyword) or ``integers``.
        options: the words an option takes.
        option_effects: effect of single options where it differs from ``effect``.
        length: how many numbers a vector has; 0 means any.
        required: DL_POLY and pydlpoly stop without it.
        old: the old-style form, for the documentation; empty when there is none.
    """

    keyword: str
    kind: Kind
    default: str
    meaning: str
    effect: str = "used"
    dimension: str = "number"
    options: tuple[str, ...] = ()
    option_effects: Mapping[str, str] = field(default_factory=dict)
    length: int = 0
    required: bool = False
    old: str = ""


def _bool(keyword: str, default: str, meaning: str, effect: str = "used", old: str = "") -> Keyword:
    return Keyword(keyword, "bool", default, meaning, effect, old=old)


def _steps(
    keyword: str, default: str, meaning: str, effect: str = "used", old: str = "", *, req: bool = False
) -> Keyword:
    return Keyword(keyword, "steps", default, meaning, effect, "steps", old=old, required=req)


def _float(
    keyword: str, dimension: str, default: str, meaning: str, effect: str = "used", old: str = "", *, req: bool = False
) -> Keyword:
    return Keyword(keyword, "float", default, meaning, effect, dimension, old=old, required=req)


def _int(keyword: str, default: str, meaning: str, effect: str = "used", old: str = "") -> Keyword:
    return Keyword(keyword, "int", default, meaning, effect, "integers", old=old)


def _string(keyword: str, default: str, meaning: str, effect: str = "used", old: str = "") -> Keyword:
    return Keyword(keyword, "string", default, meaning, effect, old=old)


def _vector(
    keyword: str, dimension: str, length: int, default: str, meaning: str, effect: str = "used", old: str = ""
) -> Keyword:
    return Keyword(keyword, "vector", default, meaning, effect, dimension, length=length, old=old)


def _option(
    keyword: str,
    options: str,
    default: str,
    meaning: str,
    effect: str = "used",
    old: str = "",
    effects: Mapping[str, str] | None = None,
    *,
    req: bool = False,
) -> Keyword:
    words = tuple(options.split())
    return Keyword(keyword, "option", default, meaning, effect, "number", words, effects or {}, required=req, old=old)


_NOT_WRITTEN = "ignored: pydlpoly does not compute it; HISTORY holds what is needed to do so afterwards"
_PARALLEL = "ignored: pydlpoly reads and writes files in one way only"
_THERMOSTAT = "ignored: it acts only with thermostats that are refused"
_MINIMISER = "ignored: it acts only with a minimisation_criterion, which is refused"
_PSEUDO = "ignored: it acts only with a pseudo_thermostat_method, which is refused"
_IMPACT = "refused: an impact on one particle"
_TTM = "ignored: it acts only with the two-temperature model, which is refused"
_VARIABLE = "ignored: it acts only with timestep_variable, which is refused"
_PLUMED = "ignored: it acts only with plumed, which is refused"
_EVB = "ignored: it acts only with simulation_method evb, which is refused"
_UNUSED_UNITS = "ignored: reports follow FIELD's units; DL_POLY does not use it either"
_SHELLS = "ignored: a FIELD with core-shell units is refused"
_CHECKPOINT = "ignored: the checkpoint has pydlpoly's own format"
_METAL = "ignored: a FIELD with a metal block is refused"
_OTHER_NVT = "refused: NVT by this thermostat"

_RUN = (
    _option("simulation_method", "md evb ffs", "md", "what kind of simulation", "ignored: pydlpoly does md only",
            effects={"evb": "refused: empirical valence bonds", "ffs": "refused: forward flux sampling"}),
    _float("timestep", "time", "", "length of a step", old="timestep f", req=True),
    _bool("timestep_variable", "off", "let the timestep vary", "refused: a variable timestep", "variable timestep f"),
    _float("timestep_variable_min_dist", "length", "0.03 ang", "shorter largest displacement: longer step",
           _VARIABLE, "mindis f"),
    _float("timestep_variable_max_dist", "length", "0.1 ang", "longer largest displacement: shorter step",
           _VARIABLE, "maxdis f"),
    _float("timestep_variable_max_delta", "time", "0.0 ps", "largest variable timestep", _VARIABLE, "mxstep f"),
    _steps("time_run", "", "length of the run, equilibration included", old="steps n", req=True),
    _steps("time_equilibration", "0 steps", "how many of the first steps equilibrate", old="equilibration [steps] n"),
    _bool("record_equilibration", "off", "take averages during equilibration too", old="collect"),
    _float("time_job", "time", "-1.0 hr", "wall-clock limit", "ignored: the run has no wall-clock limit", "job time f"),
    _float("time_close", "time", "-1.0 min", "time reserved to close down", "ignored: the run has no wall-clock limit",
           "close time f"),
    _option("restart", "clean continue rescale noscale", "clean", "where velocities and counters come from",
            old="restart [noscale|unscale|scale]"),
    _steps("data_dump_frequency", "1000 steps", "interval of REVCON and the checkpoint", old="dump n"),
    _vector("random_seed", "integers", 3, "[ 1 2 3 ]", "seed of all noise: three whole numbers, or one of 64 bits",
            old="seed a b c"),
    _int("threads", "0", "number of threads, 0 = all that are there"),
    _option("precision", "double mixed reference", "double",
            "arithmetic of soft pair forces: double, mixed (single, exact sums), reference (double, slow noise)"),
    _vector("nfold", "integers", 3, "[ 1 1 1 ]", "repeat CONFIG along its vectors and run that", old="nfold x y z"),
    _bool("strict_checks", "on", "stop where DL_POLY would only warn", "ignored: pydlpoly's checks are always on",
          "no strict"),
    _bool("fixed_com", "on", "remove the motion of the centre of mass", old="no vom"),
    _float("density_variance", "number", "0.0 %", "margin of array sizes", "ignored: arrays grow as needed",
           "densvar f"),
    _float("subcell_threshold", "number", "50.0", "beads per link cell before it is divided",
           "ignored: link cells are sized by pydlpoly", "subcell [threshold] f"),
    _bool("unsafe_comms", "off", "skip safety checks of communication", "ignored: there is no such communication",
          "l_fast"),
)  # fmt: skip

_ENSEMBLE = (
    _option("ensemble", "nve nvt npt nst pmf", "", "ensemble", old="ensemble nve|nvt|npt|nst …", req=True,
            effects={"pmf": "refused: the ensemble pmf"}),
    _option("ensemble_method", "dpd evans langevin andersen berendsen hoover gentle ttm mtk", "",
            "thermostat of nvt, npt and nst", old="ensemble nvt dpds1|dpds2|mdvv|…",
            effects={**dict.fromkeys(("evans", "andersen", "gentle"), _OTHER_NVT),
                     "ttm": "refused: the two-temperature model", "mtk": "refused: this barostat"}),
    _option("ensemble_dpd_order",
            "mdvv zeroth first second dpdvv scvv peters peters-first lowe-andersen stoyanov-groot ou ou-middle middle "
            "nose-hoover-langevin off",
            "off", "how a DPD step is taken; integrators.md", old="ensemble nvt mdvv|dpds0|dpds1|dpds2|... [drag]"),
    _float("ensemble_dpd_drag", "drag", "0.0 Da/ps", "drag of pairs that have none in FIELD",
           old="ensemble nvt dpds1 f"),
    _bool("ensemble_dpd_drag_override", "off", "let ensemble_dpd_drag replace the drags of FIELD"),
    _option("ensemble_dpd_cutoff", "pair global", "pair",
            "range of the drag: each pair's own cutoff or the global one"),
    _float("ensemble_dpd_lambda", "number", "0.5", "Groot-Warren's prediction λ of the velocities"),
    _option("ensemble_dpd_kinetic", "whole half", "whole",
            "velocities that mdvv's kinetic temperature and stress are of: of the whole step or of the half step"),
    _float("ensemble_dpd_exponent", "number", "2.0", "exponent s of the drag's weight (1 - r/rc)^s"),
    _float("ensemble_dpd_transverse_drag", "number", "0.0", "drag across a pair's line, as a multiple of its drag"),
    _float("ensemble_dpd_rate", "rate", "0.0 ps^-1", "rate at which lowe-andersen and stoyanov-groot choose a pair; 0: "
           "drag/(2 reduced mass), which is the drag for beads of mass 1"),
    _float("ensemble_dpd_coupling", "drag", "0.3 Da/ps", "strength of stoyanov-groot's drag"),
    _float("ensemble_dpd_tolerance", "number", "1.0e-6",
           "relative change of the kinetic energy at which scvv stops iterating"),
    _int("ensemble_dpd_passes", "3", "passes over the pairs in the middle step, 1 to 3"),
    _int("ensemble_dpd_interval", "1", "steps from one thermostat step of middle and ou-middle to the next"),
    _float("ensemble_dpd_thermostat_mass", "number", "1.0",
           "inertia of nose-hoover-langevin's drag, in units of degrees of freedom times kT/drag^2"),
    _float("ensemble_dpd_thermostat_friction", "rate", "1.0 ps^-1", "friction of nose-hoover-langevin's drag"),
    _vector("temperature_times", "time", 0, "", "times between which the temperature changes along straight lines"),
    _vector("temperature_values", "temperature", 0, "", "temperatures at temperature_times"),
    _float("temperature_amplitude", "temperature", "0.0 K", "half the height of a sine added to the temperature"),
    _float("temperature_period", "time", "0.0 ps", "period of that sine"),
    _float("ensemble_thermostat_coupling", "time", "0.0 ps", "relaxation time of berendsen and hoover"),
    _float("ensemble_thermostat_friction", "rate", "0.0 ps^-1", "friction of langevin"),
    _float("ensemble_thermostat_softness", "number", "0.0", "softness of Andersen's thermostat", _THERMOSTAT),
    _float("ensemble_barostat_coupling", "time", "0.0 ps", "relaxation time of the piston of npt and nst; not given: "
           "1/(2 pi friction)"),
    _float("ensemble_barostat_friction", "rate", "0.0 ps^-1", "friction of the piston of npt and nst"),
    _option("ensemble_semi_isotropic", "off area tension orthorhombic", "off",
            "what the edges of nst's cell do: each by its own, z alone, a surface tension of x and y, a tension of 0"),
    _bool("ensemble_semi_orthorhombic", "off", "with tension and orthorhombic: x and y change by one factor"),
    _float("ensemble_tension", "tension", "0.0 N/m", "surface tension to hold"),
    _float("temperature", "temperature", "0.0 K", "temperature", old="temperature f"),
    _float("pressure_hydrostatic", "pressure", "0.0 katm", "target pressure", old="pressure f"),
    _vector("pressure_tensor", "pressure", 6, "[ 0.0 0.0 0.0 0.0 0.0 0.0 ] katm", "target pressures xx yy zz of "
            "nst; xy xz yz are 0", old="pressure tensor xx yy zz xy xz yz"),
    _vector("pressure_perpendicular", "pressure", 3, "[ 0.0 0.0 0.0 ] katm", "target pressures on the faces"),
    _option("pseudo_thermostat_method", "off langevin-direct langevin gaussian direct", "off", "thermostatted walls",
            "refused: a thermostat at the cell boundary", "pseudo method f f"),
    _float("pseudo_thermostat_width", "length", "2.0 ang", "thickness of the walls", _PSEUDO),
    _float("pseudo_thermostat_temperature", "temperature", "0.0 K", "temperature of the walls", _PSEUDO),
    _float("equilibration_force_cap", "force", "0.0 k_b.temp/ang", "largest force during equilibration; 0 = none",
           old="cap [forces] f"),
    _steps("rescale_frequency", "-1 steps", "interval of velocity scaling in equilibration; 0 or less = never",
           old="scale [temperature] [every] n"),
    _steps("regauss_frequency", "-1 steps", "interval of new random velocities in equilibration; 0 or less = never",
           old="regauss [every] n"),
    _steps("reset_temperature_interval", "-1 steps", "interval of quenching in equilibration; 0 or less = never",
           "refused: quenching to zero temperature", "zero [fire] [every] n"),
    _option("minimisation_criterion", "off force energy distance", "off", "minimise first", "refused: minimisation",
            "minimise|optimise criterion …"),
    _float("minimisation_tolerance", "any", "0.0", "when the minimiser stops", _MINIMISER),
    _steps("minimisation_frequency", "0 steps", "interval of minimisation", _MINIMISER),
    _float("minimisation_step_length", "length", "-1.0 ang", "step of the minimiser", _MINIMISER),
    _float("initial_minimum_separation", "length", "-1.0 ang", "report pairs that start closer than this",
           "ignored: pairs that start too close are not listed", "l_dis f"),
    _int("impact_part_index", "0", "particle that is struck", _IMPACT, "impact i n E x y z"),
    _steps("impact_time", "0 steps", "when it is struck", "ignored: it acts only with impact_part_index"),
    _float("impact_energy", "energy", "0.0 ke.V", "energy of the blow", "ignored: it acts only with impact_part_index"),
    _vector("impact_direction", "number", 3, "[ 1.0 1.0 1.0 ]", "direction of the blow",
            "ignored: it acts only with impact_part_index"),
)  # fmt: skip

_FORCES = (
    _option("wall_method", "off reflecting bounce-back soft", "off",
            "walls across axes of the cell; external-fields.md"),
    _option("wall_axes", "x y z xy xz yz xyz", "z", "axes that the walls are across"),
    _float("wall_position", "length", "0.0 ang",
           "distance of the walls from the cell's centre; not given: they are the cell's faces"),
    _vector("wall_strength", "force", 0, "", "repulsion of soft walls: one number, or one for each species"),
    _float("wall_range", "length", "0.0 ang", "range of soft walls; not given: vdw_cutoff"),
    _float("shear_rate", "rate", "0.0 ps^-1", "shear rate of Lees-Edwards boundaries: flow along x, gradient along y"),
    _float("cutoff", "length", "", "global cutoff and range of the radial distribution", old="cutoff f", req=True),
    _float("padding", "length", "0.0 ang", "skin of the neighbour list",
           "ignored: pydlpoly chooses the skin; results do not depend on it", "padding f"),
    _option("vdw_method", "tabulated direct off spme", "tabulated",
            "how pair forces are computed; tabulated is also computed directly", old="vdw direct, no vdw",
            effects={"spme": "refused: pair laws by Ewald summation"}),
    _float("vdw_cutoff", "length", "-1.0 ang", "where pair laws without a range of their own end; negative = cutoff",
           old="rvdw [cutoff] f"),
    _option("vdw_mix_method", "off lorentz-berthelot fender-halsey hogervorst halgren waldman-hagler tang-toennies "
            "functional", "off", "rule for pairs that FIELD does not give", old="vdw mixing rule"),
    _option("mdpd_kernel", "warren lucy", "warren",
            "kernel of local densities in many-body DPD; lucy is that of LAMMPS, without a potential; many-body.md"),
    _bool("vdw_force_shift", "off", "shift pair energies and forces to vanish at the cutoff", old="vdw shift"),
    _bool("vdw_long_range_correction", "on", "add the tails beyond the cutoff to energy and pressure"),
    _option("coul_method", "off spme ewald_direct dddp pairwise reaction_field force_shifted", "off",
            "electrostatics; ewald_direct is Ewald's sum without a mesh",
            old="ewald …, coul, distan, shift, reaction, no elec"),
    _float("coul_damping", "inverse length", "0.0 ang^-1", "Fennell's damping of reaction_field and force_shifted",
           old="shift damp f"),
    _float("coul_precision", "number", "0.0", "precision that sets the damping", old="shift precision f"),
    _float("coul_dielectric_constant", "number", "1.0", "relative permittivity", old="eps f"),
    _float("coul_bjerrum_length", "length", "0.0 ang", "Bjerrum length: strength of the electrostatics over k_B T"),
    _float("coul_coupling", "number", "0.0", "4 pi times the Bjerrum length, with units dpd"),
    _bool("coul_extended_exclusion", "off", "exclude core-shell pairs further", _SHELLS, "exclude"),
    _float("spme_precision", "number", "1e-6", "precision of the Ewald sum", old="ewald precision f [n]"),
    _float("spme_alpha", "inverse length", "0.0 ang^-1", "width of the Ewald sum", old="ewald [sum] f i j k"),
    _vector("spme_kvec", "integers", 3, "[ 0 0 0 ]", "points of the mesh along each axis"),
    _float("spme_kvec_spacing", "inverse length", "0.0 ang^-1", "spacing of reciprocal vectors",
           "refused: DL_POLY's manual and code mean different numbers by it; give spme_kvec"),
    _int("spme_nsplines", "8", "order of the splines"),
    _string("charge_smearing_method", "", "shape of smeared charges"),
    _float("charge_smearing_length", "length", "0.0 ang", "width of smeared charges"),
    _string("charge_smearing_beta", "", "how the smearing length is meant: original, overlap, or beta itself"),
    _option("polarisation_model", "default charmm", "default", "polarisation", _SHELLS, "polarisation …"),
    _float("polarisation_thole", "number", "1.3", "Thole's damping", _SHELLS),
    _bool("metal_direct", "off", "metal forces without tables", _METAL, "metal direct"),
    _bool("metal_sqrtrho", "off", "tabulate the root of the density", _METAL, "metal sqrtrho"),
    _float("rlx_tol", "force", "1.0 internal_f", "force tolerance of relaxed shells", _SHELLS, "rlxtol f [f]"),
    _float("rlx_cgm_step", "length", "-1.0 ang", "step of the shell relaxation", _SHELLS),
    _int("shake_max_iter", "250", "most iterations for constraints in one step", old="mxshak n"),
    _float("shake_tolerance", "length", "1e-6 ang", "largest error of a constrained distance", old="shake f"),
    _bool("dftb", "off", "forces from DFTB+", "refused: forces from DFTB+"),
    _bool("plumed", "off", "bias by PLUMED", "refused: PLUMED", "plumed on"),
    _string("plumed_input", "", "PLUMED's input", _PLUMED, "plumed input name"),
    _string("plumed_log", "", "PLUMED's log", _PLUMED, "plumed log name"),
    _int("plumed_precision", "1", "PLUMED's precision", _PLUMED, "plumed precision n"),
    _bool("plumed_restart", "on", "whether PLUMED restarts", _PLUMED, "plumed restart yes|no"),
    _int("evb_num_ff", "1", "number of coupled force fields", _EVB),
)  # fmt: skip

_REPORTS = (
    _steps("print_frequency", "0 steps", "interval of OUTPUT's lines; 0 = none", old="print [every] n"),
    _steps("stats_frequency", "0 steps", "interval of STATIS; 0 = none", old="stats [every] n"),
    _steps("diagnostics_frequency", "0 steps", "interval of DIAGNOSTICS; 0 = none"),
    _steps("stack_size", "0 steps", "length of rolling averages, at least 100", old="stack [size] n"),
    _bool("traj_calculate", "off", "write HISTORY", old="trajectory start interval level"),
    _option("traj_key", "pos pos-vel pos-vel-force compressed", "pos", "what HISTORY holds",
            effects={"compressed": "refused: HISTORY in the compressed form"}),
    _steps("traj_start", "0 steps", "first step of HISTORY"),
    _steps("traj_interval", "1 steps", "interval of HISTORY"),
    _string("traj_format", "", "formats written beside HISTORY: extxyz gsd h5md dcd, or several in brackets"),
    _bool("rdf_calculate", "off", "collect radial distributions", old="rdf [every] n"),
    _bool("rdf_print", "on", "write RDFDAT", old="print rdf"),
    _steps("rdf_frequency", "1 steps", "interval of the collection"),
    _float("rdf_binsize", "length", "0.05 ang", "width of a bin", old="binsize f"),
    _option("rdf_error_analysis", "off jackknife block", "off", "errors of radial distributions",
            "ignored: RDFDAT is written without errors", "rdf errors jack|block n"),
    _int("rdf_error_analysis_blocks", "1", "number of blocks", "ignored: RDFDAT is written without errors"),
    _steps("stress_profile_frequency", "0 steps", "interval of the stress in layers; 0 = none"),
    _option("stress_profile_axis", "x y z", "z", "the layers are perpendicular to it"),
    _float("stress_profile_binsize", "length", "0.1 ang", "thickness of a layer, rounded to a whole number of them"),
    _int("stress_profile_interfaces", "2", "how many interfaces share the surface tension"),
    _steps("profile_frequency", "0 steps", "interval of the samples of profiles along an axis; 0 = none"),
    _option("profile_axis", "x y z", "z", "cell vector that the profiles are along"),
    _int("profile_bins", "100", "number of bins along it"),
    _string("profile_quantities", "", "what the profiles are of, such as [number_density velocity]; all by default"),
    _steps("map_frequency", "0 steps", "interval of the samples of maps over a plane; 0 = none"),
    _option("map_plane", "xy xz yz", "xy", "cell vectors that the maps are over"),
    _vector("map_bins", "integers", 2, "[ 50 50 ]", "numbers of bins along them"),
    _string("map_quantities", "", "what the maps are of; all by default"),
    _bool("zden_calculate", "off", "collect density profiles along z", old="zden [every] n"),
    _bool("zden_print", "on", "write ZDNDAT", old="print zden"),
    _steps("zden_frequency", "1 steps", "interval of the collection"),
    _float("zden_binsize", "length", "0.05 ang", "width of the bins that fill the cutoff; as many fill the cell",
           old="binsize f"),
    _bool("vaf_calculate", "off", "collect velocity autocorrelations", old="vaf [every] n [binsize] n"),
    _bool("vaf_print", "on", "print the result in OUTPUT", "ignored: it is in VAFDAT_<species>", "print vaf"),
    _steps("vaf_frequency", "1 steps", "interval between samples; 0 = 50"),
    _int("vaf_binsize", "0", "steps in a sample; 0 = 100, or twice a vaf_frequency of 100 or more"),
    _bool("vaf_averaging", "on", "average over the samples instead of writing each", old="no vafav"),
    _bool("msd_calculate", "off", "write MSDTMP", old="msdtmp start interval"),
    _bool("msd_print", "off", "print mean-square displacements", "ignored: OUTPUT and STATIS always have them"),
    _steps("msd_start", "0 steps", "first step of MSDTMP"),
    _steps("msd_frequency", "1 steps", "interval of MSDTMP"),
    _option("io_units_scheme", "internal dpd si atomic hartree kj kcal boltzmann", "internal", "units of reports",
            effects=dict.fromkeys(("si", "atomic", "hartree", "kj", "kcal", "boltzmann"),
                                  "ignored: reports follow FIELD's units")),
    *(_string(f"io_units_{name}", default, "unit of reports", _UNUSED_UNITS) for name, default in (
        ("length", "internal_l"), ("time", "internal_t"), ("mass", "internal_m"), ("charge", "internal_q"),
        ("energy", "internal_e"), ("pressure", "internal_p"), ("force", "internal_f"), ("velocity", "internal_v"),
        ("power", "internal_e/internal_t"), ("surface_tension", "internal_f/internal_l"),
        ("emf", "internal_e/internal_q"))),
    _string("io_file_output", "OUTPUT", "report; SCREEN and NONE are special", old="io output name, l_scr"),
    _string("io_file_config", "CONFIG", "start configuration", old="io config name"),
    _string("io_file_field", "FIELD", "force field", old="io field name"),
    _string("io_file_beads", "BEADS", "internal temperatures and concentrations at the start, where beads carry them"),
    _string("io_file_statis", "STATIS", "statistics; NONE is special", old="io statis name"),
    _string("io_file_diagnostics", "DIAGNOSTICS", "temperatures, drifts, pressure by part; NONE is special"),
    _string("io_file_history", "HISTORY", "trajectory; NONE is special", old="io history name"),
    _string("io_file_trajectory", "TRAJECTORY", "trajectory in the formats of traj_format, without the ending"),
    _string("io_file_revive", "REVIVE", "checkpoint; NONE is special", old="io revive name, l_tor"),
    _string("io_file_revold", "REVOLD", "checkpoint to continue from", old="io revold name"),
    _string("io_file_revcon", "REVCON", "last configuration; NONE is special", old="io revcon name, l_tor"),
    _string("io_file_revbeads", "REVBEADS", "last temperatures and concentrations; NONE is special"),
    _string("io_file_profile", "PROFILE", "profiles along an axis; NONE is special"),
    _string("io_file_map", "MAP", "maps over a plane; NONE is special"),
    _string("io_file_rdf", "RDFDAT", "radial distributions; NONE is special", old="io rdf name"),
    _string("io_file_stress_profile", "STRPRF", "stress in layers; NONE is special"),
    _string("io_file_cor", "COR", "correlation functions; NONE is special", old="io cor name"),
    _string("io_file_msd", "MSDTMP", "displacements of beads; NONE is special", old="io msd name"),
    _string("io_file_tabvdw", "TABVDW", "table of pair laws (TABLE with an old-style CONTROL)", old="io tabvdw name"),
    _string("io_file_control", "CONTROL", "this file", "ignored: it is already being read", "io control name"),
    *(_string(f"io_file_{name}", name.upper(), f"table of {what}", old=f"io {name} name") for name, what in (
        ("tabbnd", "bond laws"), ("tabang", "angle laws"), ("tabdih", "dihedral laws"), ("tabinv", "inversion laws"))),
    _string("io_file_tabeam", "TABEAM", "table of metal laws", _METAL, "io tabeam name"),
    *(_string(f"io_file_{name}", default, "a file pydlpoly does not write or read",
              "ignored: pydlpoly does not write or read this file", f"io {name} name") for name, default in (
        ("historf", "HISTORF"), ("currents", "CURRENTS"), ("heatflux", "HEATFLUX"),
        ("setevb", "SETEVB"), ("popevb", "POPEVB"), ("field_2", "FIELD2"), ("field_3", "FIELD3"),
        ("config_2", "CONFIG2"), ("config_3", "CONFIG3"), ("revcon_2", "REVCON2"), ("revcon_3", "REVCON3"))),
    _bool("io_statis_yaml", "off", "STATIS as YAML", old="yml_statis"),
    _bool("io_rdf_yaml", "off", "RDFDAT as YAML", "ignored: RDFDAT is written as plain columns", "yml_rdf"),
    *(_option(f"io_{verb}_method", "mpiio direct master netcdf", "mpiio", f"how files are {verb[:4]}", _PARALLEL,
              f"io {verb} method") for verb in ("read", "write")),
    *(_int(f"io_{verb}_{name}", "0", "parallel input and output", _PARALLEL) for verb, name in (
        ("read", "readers"), ("read", "batch_size"), ("read", "buffer_size"),
        ("write", "writers"), ("write", "batch_size"), ("write", "buffer_size"))),
    *(_bool(f"io_{verb}_error_check", "off", "check transfers", _PARALLEL) for verb in ("read", "write")),
    _string("io_write_netcdf_format", "", "kind of netCDF", _PARALLEL),
    _bool("io_write_sorted", "on", "write beads in the order of their indices",
          "ignored: beads are always written sorted"),
    _bool("io_write_ascii_revive", "off", "REVIVE as text", _CHECKPOINT, "l_rout"),
    _bool("io_read_ascii_revold", "off", "REVOLD as text", _CHECKPOINT, "l_rin"),
    _bool("output_energy", "off", "print the last energy", "ignored: it is always printed", "l_eng"),
    _bool("output_std_dev", "off", "print standard deviations", "ignored: they are always printed"),
    _bool("ignore_config_indices", "off", "take the beads of CONFIG in file order", old="no index"),
    _bool("print_topology_info", "off", "print FIELD's molecules", "ignored: `pydlpoly` explains a scene on request",
          "no topology"),
    _int("print_level", "1", "how much OUTPUT says", "ignored: OUTPUT has one level", "l_print n"),
    _int("timer_depth", "4", "detail of timings", "ignored: timings have one level"),
    _bool("timer_per_mpi", "off", "timings of each process", "ignored: there is one process"),
    _bool("timer_yaml_file", "off", "timings as YAML", "ignored: timings are printed"),
    _bool("replay", "off", "replay HISTORY instead of running", "refused: replay of a HISTORY", "replay"),
    _bool("replay_calculate_forces", "on", "forces in a replay", "ignored: it acts only with replay, which is refused"),
    _bool("unit_test", "off", "DL_POLY's own tests", "refused: DL_POLY's own tests"),
    _bool("dftb_test", "off", "DL_POLY's own tests", "refused: DL_POLY's own tests"),
)  # fmt: skip

_ANALYSES = (
    *(_bool(name, "off", meaning, _NOT_WRITTEN, old) for name, meaning, old in (
        ("defects_calculate", "defects", "defects start interval f"), ("defects_backup", "defects of a backup", ""),
        ("displacements_calculate", "large displacements", "displacements start interval f"),
        ("coord_calculate", "coordination numbers", "coord i start interval"),
        ("adf_calculate", "angular distributions", "adf interval f"),
        ("currents_calculate", "currents", ""), ("energy_stress_currents", "energy and stress currents", ""),
        ("heat_flux", "heat flux", "heat_flux"), ("elastic_constants", "elastic constants", ""),
        ("write_per_particle", "energies and stresses of each bead", "pp_dump"),
        ("print_probability_distribution", "probability distributions", ""),
        ("analyse_all", "distributions of all bonded terms", "analyse all every n nbins n rmax f"),
        ("analyse_bonds", "distributions of bonds", "analyse bonds every n nbins n"),
        ("analyse_angles", "distributions of angles", "analyse angles every n nbins n"),
        ("analyse_dihedrals", "distributions of dihedrals", "analyse dihedrals every n nbins n"),
        ("analyse_inversions", "distributions of inversions", "analyse inversions every n nbins n"))),
    *(_steps(name, default, "interval of an analysis", _NOT_WRITTEN) for name, default in (
        ("defects_interval", "1 steps"), ("displacements_interval", "1 steps"), ("coord_interval", "100 steps"),
        ("adf_frequency", "100 steps"), ("analyse_frequency", "1 steps"),
        ("analyse_frequency_bonds", "1 steps"), ("analyse_frequency_angles", "1 steps"),
        ("analyse_frequency_dihedrals", "1 steps"), ("analyse_frequency_inversions", "1 steps"))),
    *(_steps(f"{name}_start", "0 steps", "first step of an analysis", _NOT_WRITTEN) for name in
      ("defects", "displacements", "coord")),
    *(_float(name, "length", default, "length of an analysis", _NOT_WRITTEN) for name, default in (
        ("defects_distance", "0.75 ang"), ("displacements_distance", "0.75 ang"),
        ("analyse_max_dist", "2.0 ang"))),
    *(_int(name, default, "number of bins", _NOT_WRITTEN) for name, default in (
        ("analyse_num_bins", "-1"), ("analyse_num_bins_bonds", "0"),
        ("analyse_num_bins_angles", "0"), ("analyse_num_bins_dihedrals", "0"), ("analyse_num_bins_inversions", "0"))),
    _option("coord_ops", "icoord ccoord full", "icoord", "kind of coordination list", _NOT_WRITTEN),
    _float("adf_precision", "number", "0.0", "precision of angular distributions", _NOT_WRITTEN),
    _string("momentum_density", "", "what is correlated", _NOT_WRITTEN),
    _string("correlation_observable", "", "components of the stress to correlate, such as [s_xy-s_xy s_xz-s_xz]"),
    *(_vector(f"correlation_{name}", "integers", 0, default, meaning) for name, default, meaning in (
        ("blocks", "[ 1 ]", "levels of each correlator"), ("block_points", "[ 100 ]", "lags of a level"),
        ("window", "[ 1 ]", "values of a level that make one of the next"),
        ("update_frequency", "[ 1 ]", "interval of the samples, one for all"))),
    _steps("correlation_dump_frequency", "0 steps", "interval of COR; 0 = with checkpoints alone"),
)  # fmt: skip

_TWO_TEMPERATURE = (
    _bool("ttm_calculate", "off", "two-temperature model", "refused: the two-temperature model"),
    *(_bool(f"ttm_{name}", "off", "two-temperature model", _TTM) for name in
      ("metal", "boundary_xy", "oneway", "redistribute")),
    *(_string(f"ttm_{name}", "", "two-temperature model", _TTM) for name in (
        "heat_cap_model", "elec_cond_model", "diff_model", "dens_model", "spatial_dist", "laser_type", "temporal_dist",
        "variable_ep", "boundary_condition", "com_correction", "boundary_heat_flux")),
    *(_int(f"ttm_{name}", "0", "two-temperature model", _TTM) for name in ("num_ion_cells", "min_atoms")),
    _vector("ttm_num_elec_cells", "integers", 3, "[ 50 50 50 ]", "two-temperature model", _TTM),
    *(_float(f"ttm_{name}", dimension, default, "two-temperature model", _TTM) for name, dimension, default in (
        ("heat_cap", "any", "0.0"), ("temp_term", "inverse temperature", "0.0 K^-1"),
        ("fermi_temp", "temperature", "0.0 K"), ("elec_cond", "conductivity", "0.0 W/m/K"),
        ("diff", "diffusivity", "0.0 m^2/s"), ("dens", "density", "0.0 ang^-3"),
        ("stopping_power", "force", "0.0 e.V/nm"), ("spatial_sigma", "length", "1.0 nm"),
        ("spatial_cutoff", "any", "5.0"), ("fluence", "tension", "0.0 mJ/cm^2"),
        ("penetration_depth", "length", "0.0 nm"),
        ("temporal_duration", "time", "0.001 ps"), ("temporal_cutoff", "any", "5.0"), ("time_offset", "time", "0.0 ps"),
        ("e-phonon_friction", "rate", "0.0 ps^-1"), ("e-stopping_friction", "rate", "0.0 ps^-1"),
        ("e-stopping_velocity", "velocity", "0.0 ang/ps"), ("e-phonon_cutoff_velocity", "velocity", "0.0 ang/ps"))),
    *(_steps(f"ttm_{name}_frequency", "0 steps", "two-temperature model", _TTM) for name in ("stats", "traj")),
)  # fmt: skip

KEYWORDS: dict[str, Keyword] = {
    row.keyword: row for row in (*_RUN, *_ENSEMBLE, *_FORCES, *_REPORTS, *_ANALYSES, *_TWO_TEMPERATURE)
}
"""Every keyword by its canonical name, in the order of the documentation."""

SYNONYMS: dict[str, str] = {
    "subcelling_threshold_density": "subcell_threshold",
    **{f"ewald_{name}": f"spme_{name}" for name in ("precision", "alpha", "kvec", "kvec_spacing", "nsplines")},
    "io_unit_scheme": "io_units_scheme",
    "print_per_particle_contrib": "write_per_particle",
    "time_depth": "timer_depth",
    "polarisation": "polarisation_thole",
    "ttm_statis_frequency": "ttm_stats_frequency",
    "msd_interval": "msd_frequency",
    "io_read_ascii_revive": "io_read_ascii_revold",
}
"""Other spellings in manuals, examples and older releases, by the canonical keyword."""

OPTION_SYNONYMS: dict[str, dict[str, str]] = {
    "vdw_mix_method": {"tang-tonnies": "tang-toennies", "fender-hasley": "fender-halsey"},
    "vdw_method": {"ewald": "spme"},
    "coul_method": {"ewald": "spme"},
    "ensemble_method": {"nose": "hoover", "nose-hoover": "hoover", "gst": "gentle"},
    "ensemble_dpd_order": {
        **{"0": "zeroth", "1": "first", "2": "second", "s0": "zeroth", "s1": "first", "s2": "second"},
        **{"lowe": "lowe-andersen", "stoyanov": "stoyanov-groot", "pnhl": "nose-hoover-langevin"},
    },
    "pseudo_thermostat_method": {"gauss": "gaussian"},
    "io_units_scheme": {"boltzman": "boltzmann"},
}
"""Other spellings of options, by keyword."""


def lookup(word: str) -> Keyword | None:
    """Return the row of a keyword in any letter case and any known spelling, or None."""
    lower = word.lower()
    return KEYWORDS.get(SYNONYMS.get(lower, lower))


def nearest(word: str) -> str:
    """Return ``"; did you mean …?"`` for a word that is no keyword, or an empty string."""
    return suggest(word, [*KEYWORDS, *SYNONYMS])
