"""Old-style CONTROL: every directive in the shapes that real files have, and its way back into text."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.control import parse_control, read_control, value_in, write_control
from pydlpoly.formats.control_old_directives import HANDLERS, NAMES, find_directive
from pydlpoly.formats.control_old_tables import NEGATIONS, NUMBERS, SEQUENCES, SWITCHES
from pydlpoly.formats.keywords import KEYWORDS
from pydlpoly.formats.records import Control, Setting

IMPLIED = ("ensemble", "print_frequency", "stats_frequency", "rdf_print", "zden_print", "vaf_print")


def _settings(lines: str) -> dict[str, object]:
    """Return what the lines give, without the defaults that the reader writes out."""
    control = parse_control(f"a title\n{lines}\nfinish\n")
    assert control.style == "old"
    return {s.keyword: s.value if s.unit is None else (s.value, s.unit) for s in control if s.line}


TYPICAL = """\
DL_POLY: 400 DPD beads, as people write it
# a remark

temperature           1.2027165 Kelvin
ens nvt dpds1 4.5
steps     20000 steps
equil     steps 1000
timestep  0.01 ps
cutoff    10.0 angstrom
rvdw cutoff 9.0 Angstroms
pad 0.5
vdw direct
scale every 10 steps
regaus every 5
cap forces 500.
collect
traj 100 50 1
stats every 10
print every 100 ! how often
stack size 50
rdf sampling every 20
binsize 0.02
print rdf
no elec
no vom
job time 1d5
close time 1.d2 s
seed 17 18 19
dump 500
finish
anything after it is not read: tad &end x=1
"""


def test_a_typical_file() -> None:
    control = parse_control(TYPICAL)
    assert (control.title, control.style) == ("DL_POLY: 400 DPD beads, as people write it", "old")
    assert control.warnings == ()
    assert {s.keyword: s.value if s.unit is None else (s.value, s.unit) for s in control} == {
        "temperature": (1.2027165, "K"),
        "ensemble": "nvt",
        "ensemble_method": "dpd",
        "ensemble_dpd_order": "first",
        "ensemble_dpd_drag": (4.5, "Da/ps"),
        "time_run": (20000, "steps"),
        "time_equilibration": (1000, "steps"),
        "timestep": (0.01, "ps"),
        "cutoff": (10.0, "ang"),
        "vdw_cutoff": (9.0, "ang"),
        "padding": (0.5, "ang"),
        "vdw_method": "direct",
        "rescale_frequency": (10, "steps"),
        "regauss_frequency": (5, "steps"),
        "equilibration_force_cap": (500.0, "k_b.temp/ang"),
        "record_equilibration": True,
        "traj_calculate": True,
        "traj_start": (100, "steps"),
        "traj_interval": (50, "steps"),
        "traj_key": "pos-vel",
        "stats_frequency": (10, "steps"),
        "print_frequency": (100, "steps"),
        "stack_size": (50, "steps"),
        "rdf_calculate": True,
        "rdf_frequency": (20, "steps"),
        "rdf_binsize": (0.02, "ang"),
        "zden_binsize": (0.02, "ang"),
        "rdf_print": True,
        "coul_method": "off",
        "fixed_com": False,
        "time_job": (100000.0, "s"),
        "time_close": (100.0, "s"),
        "random_seed": (17, 18, 19),
        "data_dump_frequency": (500, "steps"),
    }
    assert [s.line for s in control][:5] == [4, 5, 5, 5, 5]
    assert value_in(control, "equilibration_force_cap") == pytest.approx(500.0)


def test_the_two_styles_of_one_input_are_equal() -> None:
    """Converting is writing under the other style; the values, and what is printed how often, stay the same."""
    old = parse_control(TYPICAL)
    new = parse_control(write_control(replace(old, style="new")))
    assert new.style == "new"
    assert new.settings == old.settings
    again = parse_control(write_control(replace(new, style="old")))
    assert again == old


CASES = [
    ("temp 300", {"temperature": (300.0, "K")}),
    ("pres 0.001 katm", {"pressure_hydrostatic": (0.001, "katm")}),
    ("presure 0.001", {"pressure_hydrostatic": (0.001, "katm")}),  # only the leading letters count
    ("pressure tensor 1 2 3 4 5 6", {"pressure_tensor": ((1.0, 2.0, 3.0, 4.0, 5.0, 6.0), "katm")}),
    ("variable timestep 0.001 ps", {"timestep": (0.001, "ps"), "timestep_variable": True}),
    ("mindis 0.03", {"timestep_variable_min_dist": (0.03, "ang")}),
    ("maxdis .1", {"timestep_variable_max_dist": (0.1, "ang")}),
    ("mxstep 0.005", {"timestep_variable_max_delta": (0.005, "ps")}),
    ("equilibration 10.0", {"time_equilibration": (10, "steps")}),
    ("rcut 8", {"cutoff": (8.0, "ang")}),
    ("rpad 0.2", {"padding": (0.2, "ang")}),
    ("rvdw 7.5", {"vdw_cutoff": (7.5, "ang")}),
    ("densvar 10 %", {"density_variance": (10.0, "%")}),
    ("vdw shift", {"vdw_force_shift": True}),
    ("vdw ewald", {"vdw_method": "spme"}),
    ("vdw mix hogervorst", {"vdw_mix_method": "hogervorst"}),
    ("vdw mixing fender-hasley", {"vdw_mix_method": "fender-halsey"}),
    ("vdw mixing TANG", {"vdw_mix_method": "tang-toennies"}),
    ("no vdw", {"vdw_method": "off"}),
    ("no electrostatics", {"coul_method": "off"}),
    ("no index", {"ignore_config_indices": True}),
    ("no strict", {"strict_checks": False}),
    ("no topology", {"print_topology_info": False}),
    ("no vafaveraging", {"vaf_averaging": False}),
    ("ewald precision 1d-6", {"coul_method": "spme", "spme_precision": 1e-6}),
    ("spme precision 1d-6 8", {"coul_method": "spme", "spme_precision": 1e-6, "spme_nsplines": 8}),
    ("ewald sum 0.3 8 9 10", {"coul_method": "spme", "spme_alpha": (0.3, "ang^-1"), "spme_kvec": (8, 9, 10)}),
    ("coul", {"coul_method": "pairwise"}),
    ("distan", {"coul_method": "dddp"}),
    ("shift", {"coul_method": "force_shifted"}),
    ("shift damp 0.2", {"coul_method": "force_shifted", "coul_damping": (0.2, "ang^-1")}),
    ("reaction field precision 1e-5", {"coul_method": "reaction_field", "coul_precision": 1e-5}),
    ("eps 78.5", {"coul_dielectric_constant": 78.5}),
    ("exclu", {"coul_extended_exclusion": True}),
    ("print zden", {"zden_print": True}),
    ("zdensity every 5", {"zden_calculate": True, "zden_frequency": (5, "steps")}),
    ("vaf sampling every 5 bin size 50", {"vaf_calculate": True, "vaf_frequency": (5, "steps"), "vaf_binsize": 50}),
    ("rdf", {"rdf_calculate": True, "rdf_frequency": (1, "steps")}),
    (
        "rdf errors jack 10 every 5",
        {"rdf_calculate": True, "rdf_error_analysis": "jackknife", "rdf_error_analysis_blocks": 10,
         "rdf_frequency": (5, "steps")},
    ),
    (
        "trajectory",
        {"traj_calculate": True, "traj_start": (0, "steps"), "traj_interval": (1, "steps"), "traj_key": "pos"},
    ),
    ("msdtmp 10 20", {"msd_calculate": True, "msd_start": (10, "steps"), "msd_frequency": (20, "steps")}),
    (
        "defects 0 10 0.7",
        {"defects_calculate": True, "defects_start": (0, "steps"), "defects_interval": (10, "steps"),
         "defects_distance": (0.7, "ang")},
    ),
    (
        "displacements 0 10",
        {"displacements_calculate": True, "displacements_start": (0, "steps"),
         "displacements_interval": (10, "steps"), "displacements_distance": (0.75, "ang")},
    ),
    (
        "coord 2 0 50",
        {"coord_calculate": True, "coord_ops": "full", "coord_start": (0, "steps"), "coord_interval": (50, "steps")},
    ),
    ("adf 10 0.1", {"adf_calculate": True, "adf_frequency": (10, "steps"), "adf_precision": 0.1}),
    (
        "analyse all sampling every 5 nbins 100 rmax 3.0",
        {"analyse_all": True, "analyse_frequency": (5, "steps"), "analyse_num_bins": 100,
         "analyse_max_dist": (3.0, "ang")},
    ),
    (
        "ana bonds every 5 nbins 100",
        {"analyse_bonds": True, "analyse_frequency_bonds": (5, "steps"), "analyse_num_bins_bonds": 100},
    ),
    ("zero fire every 10", {"reset_temperature_interval": (10, "steps")}),
    ("cap", {"equilibration_force_cap": (1000.0, "k_b.temp/ang")}),
    ("restart", {"restart": "continue"}),
    ("restart unscale", {"restart": "noscale"}),
    ("restart scale", {"restart": "rescale"}),
    ("seed 1 2", {"random_seed": (1, 2, 0)}),
    ("nfold 2 2 2", {"nfold": (2, 2, 2)}),
    ("shake tolerance 1d-6", {"shake_tolerance": (1e-6, "ang")}),
    ("mxshak 500", {"shake_max_iter": 500}),
    ("rlxtol force 1.0", {"rlx_tol": (1.0, "internal_f"), "rlx_cgm_step": (-1.0, "ang")}),
    ("subcell threshold density 30", {"subcell_threshold": 30.0}),
    ("metal sqrtrho", {"metal_sqrtrho": True}),
    (
        "minimise force every 10 1.0",
        {"minimisation_criterion": "force", "minimisation_frequency": (10, "steps"), "minimisation_tolerance": 1.0,
         "minimisation_step_length": (-1.0, "ang")},
    ),
    (
        "optim energy 0.01",
        {"minimisation_criterion": "energy", "minimisation_tolerance": 0.01, "minimisation_step_length": (-1.0, "ang")},
    ),
    (
        "impact 5 100 2.5 1 0 0",
        {"impact_part_index": 5, "impact_time": (100, "steps"), "impact_energy": (2.5, "ke.V"),
         "impact_direction": (1.0, 0.0, 0.0)},
    ),
    (
        "pseudo gauss 3.0 300.0",
        {"pseudo_thermostat_method": "gaussian", "pseudo_thermostat_width": (3.0, "ang"),
         "pseudo_thermostat_temperature": (300.0, "K")},
    ),
    ("polar charmm thole 1.3", {"polarisation_model": "charmm", "polarisation_thole": 1.3}),
    ("plumed on", {"plumed": True}),
    ("plumed input my.dat", {"plumed_input": "my.dat"}),
    ("plumed restart no", {"plumed_restart": False}),
    ("io config a/My.CONFIG", {"io_file_config": "a/My.CONFIG"}),
    ("io tabvdw my.table", {"io_file_tabvdw": "my.table"}),
    ("io read direct 4", {"io_read_method": "direct", "io_read_readers": 4}),
    ("yml_statis", {"io_statis_yaml": True}),
    ("l_scr", {"io_file_output": "SCREEN"}),
    ("l_tor", {"io_file_revcon": "NONE", "io_file_revive": "NONE"}),
    ("l_dis", {"initial_minimum_separation": (0.5, "ang")}),
    ("l_print 2", {"print_level": 2}),
    ("replay history force", {"replay": True, "replay_calculate_forces": True}),
    ("replay", {"replay": True, "replay_calculate_forces": False}),
    ("integrator velocity verlet", {}),
    ("ensemble nve", {"ensemble": "nve"}),
    ("ensemble nvt dpds2", {"ensemble": "nvt", "ensemble_method": "dpd", "ensemble_dpd_order": "second"}),
    (
        "ensemble nvt dpd s2 4.5",
        {"ensemble": "nvt", "ensemble_method": "dpd", "ensemble_dpd_order": "second",
         "ensemble_dpd_drag": (4.5, "Da/ps")},
    ),
    (
        "ensemble nvt mdvv 4.5 Da/ps",
        {"ensemble": "nvt", "ensemble_method": "dpd", "ensemble_dpd_order": "mdvv",
         "ensemble_dpd_drag": (4.5, "Da/ps")},
    ),
    ("ensemble nvt dpdvv", {"ensemble": "nvt", "ensemble_method": "dpd", "ensemble_dpd_order": "dpdvv"}),
    ("ensemble nvt evans", {"ensemble": "nvt", "ensemble_method": "evans"}),
    (
        "ensemble nvt langevin 1.0",
        {"ensemble": "nvt", "ensemble_method": "langevin", "ensemble_thermostat_friction": (1.0, "ps^-1")},
    ),
    (
        "ensemble nvt andersen 0.5 0.7",
        {"ensemble": "nvt", "ensemble_method": "andersen", "ensemble_thermostat_coupling": (0.5, "ps"),
         "ensemble_thermostat_softness": 0.7},
    ),
    (
        "ensemble npt ber 0.1 1.0",
        {"ensemble": "npt", "ensemble_method": "berendsen", "ensemble_thermostat_coupling": (0.1, "ps"),
         "ensemble_barostat_coupling": (1.0, "ps")},
    ),
    (
        "ensemble nst hoover 0.5 1.0 tens 10 semi",
        {"ensemble": "nst", "ensemble_method": "hoover", "ensemble_thermostat_coupling": (0.5, "ps"),
         "ensemble_barostat_coupling": (1.0, "ps"), "ensemble_semi_isotropic": "tension",
         "ensemble_tension": (10.0, "dyn/cm"), "ensemble_semi_orthorhombic": True},
    ),
]  # fmt: skip


@pytest.mark.parametrize(("line", "settings"), CASES, ids=[line for line, _ in CASES])
def test_directives(line: str, settings: dict[str, object]) -> None:
    assert _settings(line) == settings
    assert _settings(f"  {line.upper()}   # remark") == settings or line.startswith(("io", "plumed input"))


@pytest.mark.parametrize("line", [line for line, _ in CASES], ids=[line for line, _ in CASES])
def test_directives_survive_writing(line: str) -> None:
    control = parse_control(f"a title\n{line}\nfinish\n")
    assert parse_control(write_control(control)) == control


@pytest.mark.parametrize(
    ("line", "warning"),
    [
        ("delr 2.0", "delr 2 is a padding of 0.5 ang, as in DL_POLY 4"),
        ("no link", "'no link' has no effect: link cells are always used"),
        ("multiple step 6", "'multiple' has no effect: DL_POLY Classic's multiple timestep"),
        ("primary 7.5", "'primary' has no effect: DL_POLY Classic's primary cutoff"),
        ("slab", "'slab' has no effect: it shapes DL_POLY's domains"),
        ("print analysis", "'print analysis' has no effect: it was removed from DL_POLY"),
        ("ewald evaluate every 4", "'ewald evaluate' has no effect: it is a directive of DL_POLY Classic"),
    ],
)
def test_directives_without_effect_are_reported(line: str, warning: str) -> None:
    control = parse_control(f"a title\nensemble nve\n{line}\nfinish\n")
    assert control.warnings == (f"CONTROL:3: {warning}",)


def test_a_negative_drag_loses_its_sign_as_in_dl_poly() -> None:
    control = parse_control("a title\nensemble nvt dpds1 -4.5\nfinish\n")
    assert value_in(control, "ensemble_dpd_drag") == 4.5
    assert control.warnings == ("CONTROL:2: the drag -4.5 is taken without its sign, as in DL_POLY",)


def test_defaults_that_differ_between_the_styles_are_written_out() -> None:
    control = parse_control("a title\nrdf every 5\nfinish\n", path="old.control")
    assert [(s.keyword, s.value) for s in control if s.line == 0] == [
        ("ensemble", "nve"), ("print_frequency", 100), ("stats_frequency", 100), ("rdf_print", False)]  # fmt: skip
    assert control.warnings == (
        "old.control: no ensemble is given; nve is taken, as in DL_POLY",
        "old.control: rdf is collected but not written, because 'print rdf' is missing",
    )
    assert "print_frequency 100 steps\n" in write_control(replace(control, style="new"))


def test_defaults_of_the_new_style_are_written_into_the_old_one() -> None:
    control = parse_control("title t\nensemble nve\nrdf_calculate on\nrdf_frequency 5 steps\n")
    old = parse_control(write_control(replace(control, style="old")))
    for keyword in ("print_frequency", "stats_frequency", "rdf_print", "rdf_frequency"):
        assert value_in(old, keyword) == value_in(control, keyword), keyword


def test_units_are_converted_into_the_ones_that_the_old_style_implies() -> None:
    new = "title t\ntimestep 2 fs\ntime_run 1 ps\ncutoff 1.2 nm\ntemperature 1 dpd_temp\ntime_job 2 hr\nensemble nve\n"
    old = parse_control(write_control(replace(parse_control(new), style="old")))
    assert value_in(old, "timestep") == pytest.approx(0.002)
    assert value_in(old, "time_run") == 500
    assert value_in(old, "cutoff") == pytest.approx(12.0)
    assert value_in(old, "temperature") == pytest.approx(1.2027165)
    assert value_in(old, "time_job") == pytest.approx(7.2e15)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        (Setting("ensemble_dpd_lambda", 0.65), "ensemble_dpd_lambda 0.65 has no form in the old style"),
        (Setting("vdw_long_range_correction", False), "vdw_long_range_correction False has no form in the old style"),
        (Setting("random_seed", (5,)), "a single seed has no form in the old style, which takes three"),
    ],
)
def test_what_has_no_old_form_is_not_written(setting: Setting, message: str) -> None:
    with pytest.raises(InputError, match=message):
        write_control(Control("t", (setting,), style="old"))


def test_what_changes_nothing_may_be_left_out() -> None:
    settings = (
        Setting("vdw_long_range_correction", True),
        Setting("timer_depth", 3),
        Setting("traj_interval", 9, "steps"),
    )
    assert write_control(Control("t", settings, style="old")) == "t\nprint 0\nstats 0\nfinish\n"


def test_two_bin_sizes_do_not_fit_into_one() -> None:
    settings = (Setting("rdf_binsize", 0.1, "ang"), Setting("zden_binsize", 0.2, "ang"))
    with pytest.raises(InputError, match="rdf_binsize and zden_binsize differ"):
        write_control(Control("t", settings, style="old"))


# -- Which style a file is in -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "style"),
    [
        ("title\ncutoff 1 ang\n", "new"),
        ("Title page of a run\ntime_run 5 steps\n", "new"),
        ("# title\nTITLE x\n", "new"),
        ("title page of a run\ntemperature 300\nsteps 10\nfinish\n", "old"),
        ("title page of a run\nfinish\n", "old"),
        ("a title page\nfinish\n", "old"),
        ("\ntemp 1\nfinish\n", "old"),
        ("# my run\ntemp 1\nfinish\n", "old"),
    ],
)
def test_styles(text: str, style: str) -> None:
    assert parse_control(text).style == style


def test_a_new_keyword_decides_for_the_new_style() -> None:
    with pytest.raises(InputError) as caught:
        parse_control("title t\ntime_run 5 steps\nfinish\n")
    text = "is no keyword of CONTROL; it is an old-style directive, and the file is in the new style"
    assert str(caught.value) == f"CONTROL:3: 'finish': {text}"


# -- Twins of files that public projects have --------------------------------------------------------------------------


def test_abbreviations_and_fillers_of_classic_files() -> None:
    """Commented directives, tabs, capitals, a missing digit before the point, units after numbers."""
    text = (
        "glass\n\n#restart noscale\nTEMP\t1000.0\nPRESSURE .0001\nSTEPS 100000\nEQUIL 50000\nMULTIPLE STEP 6\n"
        "PRINT EVERY 1000\nSTACK SIZE 100\nSTATS EVERY 100\nRDF EVERY 10\nINTEGRATOR VELOCITY VERLET\n"
        "timestep  0.001 ps\nrvdw cutoff 7.6\ncutoff  10.0 angstrom\ndelr width 0.5\nensemble nvt berendsen 0.4\n"
        "ewald precision 1d-6\nquaternion tolerance 1.d-5\nshake tolerance 1d-6\nno electrostatics   ! none\nfinish\n"
    )
    with pytest.raises(InputError, match="'no': gives coul_method a second time, first in line 19"):
        parse_control(text)
    control = parse_control(text, lenient=True)
    assert value_in(control, "coul_method") == "off"
    assert (value_in(control, "temperature"), value_in(control, "padding")) == (1000.0, 0.125)
    assert value_in(control, "shake_tolerance") == 1e-6
    assert len(control.warnings) == 5


def test_benchmark_style_numbers() -> None:
    text = "t\npresure .0001\ntimestep 5.d-4\nensemble nvt hoover 1.0\ncap forces 10000.\nfinish\n"
    control = parse_control(text)
    assert value_in(control, "timestep") == 5e-4
    assert control.get("pressure_hydrostatic") == Setting("pressure_hydrostatic", 1e-4, "katm")
    assert control.get("equilibration_force_cap") == Setting("equilibration_force_cap", 1e4, "k_b.temp/ang")


BLOCK = "opens a block that ends with endtad; blocks of DL_POLY Classic are not modelled"
PAIRS = "has the form key=value, which no DL_POLY 4 or 5 CONTROL has"


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("tad\n units kJ\n endtad", f"CONTROL:2: 'tad': {BLOCK}"),
        (" &bpd\n &end", "CONTROL:2: '&bpd': is a Fortran namelist, which no DL_POLY 4 or 5 CONTROL has"),
        ("pimd nhc nbeads=10 nchain=4", f"CONTROL:2: 'pimd nhc nbeads=10 nchain=4': {PAIRS}"),
    ],
)  # fmt: skip
def test_extensions_of_other_programs_are_refused_by_name(lines: str, message: str) -> None:
    for lenient in (False, True):
        with pytest.raises(InputError) as caught:
            parse_control(f"a title\n{lines}\nfinish\n", lenient=lenient)
        assert str(caught.value) == message


def test_a_file_is_read_from_disk(tmp_path: Path) -> None:
    path = tmp_path / "CONTROL"
    path.write_text(TYPICAL)
    assert read_control(path) == replace(parse_control(TYPICAL), path=str(path))


# -- The tables -------------------------------------------------------------------------------------------------------


def test_every_directive_is_known_under_its_full_name() -> None:
    for name in NAMES:
        assert name == "finish" or find_directive(name) in HANDLERS, name
    for name in NUMBERS:
        assert find_directive(name) == NUMBERS[name][0]
    for word in (
        "cutof",
        "vdw_method",
        "ensemble_method",
        "timestep_variable",
        "rdf_calculate",
        "title",
        "allow",
        "ionic",
    ):
        assert (find_directive(word) is None) == (word != "cutof"), word


def test_tables_name_keywords_only() -> None:
    named = [keyword for _, keyword, _ in NUMBERS.values()]
    named += [keyword for made in SWITCHES.values() for keyword, _ in made]
    named += [keyword for keyword, _ in NEGATIONS.values()]
    for switch, members in SEQUENCES.values():
        named += [keyword for keyword, _ in members] + ([switch] if switch else [])
    assert set(named) <= set(KEYWORDS)
