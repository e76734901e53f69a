"""A gallery of scenes that are refused, each with the whole message the user sees."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pydlpoly.errors import SceneError
from pydlpoly.formats.config import parse_config
from pydlpoly.formats.control import parse_control
from pydlpoly.formats.field import parse_field
from pydlpoly.formats.records import PairLine
from pydlpoly.scene import resolve

AVAILABLE = (
    "available are ensemble nve, ensemble nvt with ensemble_method langevin, berendsen, hoover, or dpd and an "
    "ensemble_dpd_order, and ensemble npt and nst with ensemble_method langevin or dpd"
)

PISTON = {"ensemble": "npt", "ensemble_barostat_friction": "1 dpd_t^-1"}

CASES = {
    "ensemble_pmf": (
        {"control": {"ensemble": "pmf", "ensemble_method": None}},
        f"CONTROL:2: 'ensemble': ensemble pmf is not modelled; {AVAILABLE}",
    ),
    "npt_hoover": (
        {"control": {"ensemble": "npt", "ensemble_method": "hoover"}},
        f"CONTROL:3: 'ensemble_method': ensemble npt hoover is not modelled; {AVAILABLE}",
    ),
    "npt_by_another_order": (
        {"control": {**PISTON, "ensemble_dpd_order": "scvv"}},
        (
            "CONTROL:4: 'ensemble_dpd_order': ensemble npt is not modelled with scvv; it is with mdvv, zeroth, first, "
            "second, peters, peters-first, lowe-andersen, stoyanov-groot, ou, ou-middle, middle, langevin"
        ),
    ),
    "npt_without_friction": (
        {"control": {"ensemble": "npt"}},
        "CONTROL:2: 'ensemble': the piston needs an ensemble_barostat_friction above 0",
    ),
    "npt_without_relaxation": (
        {"control": {**PISTON, "ensemble_barostat_coupling": "0 dpd_t"}},
        "CONTROL:11: 'ensemble_barostat_coupling': the piston's relaxation time must be above 0, not 0",
    ),
    "npt_at_rest": (
        {"control": {**PISTON, "temperature": "0 dpd_temp"}},
        "CONTROL:2: 'ensemble': ensemble npt needs a temperature above 0: the piston's mass has it",
    ),
    "npt_in_a_slab": (
        {"control": PISTON, "imcon": 6},
        "CONTROL:2: 'ensemble': ensemble npt: periodicity key imcon 6 is not modelled with it; 1 and 2 are",
    ),
    "npt_in_a_skewed_cell": (
        {"control": PISTON, "imcon": 3},
        "CONTROL:2: 'ensemble': ensemble npt: periodicity key imcon 3 is not modelled with it; 1 and 2 are",
    ),
    "npt_with_frozen_beads": (
        {"control": PISTON, "atoms": ("A 1.0 0.0 1 1", "B 2.0 0.0")},
        "CONTROL:2: 'ensemble': ensemble npt: frozen beads are not modelled with it",
    ),
    "npt_with_a_field": (
        {"control": PISTON, "after": "extern\ngrav 0 0 -1"},
        "CONTROL:2: 'ensemble': ensemble npt: external fields are not modelled with it",
    ),
    "npt_with_tethers": (
        {"control": PISTON, "inside": "teth 1\nharm 1 5.0"},
        "CONTROL:2: 'ensemble': ensemble npt: tethers are not modelled with it",
    ),
    "two_pressures": (
        {"control": {**PISTON, "pressure_hydrostatic": "1 dpd_p", "pressure_tensor": "[ 1 1 1 0 0 0 ] dpd_p"}},
        "CONTROL:12: 'pressure_tensor': the target pressure is given already, by pressure_hydrostatic",
    ),
    "shear_stress": (
        {"control": {**PISTON, "ensemble": "nst", "pressure_tensor": "[ 1 1 1 0.1 0 0 ] dpd_p"}},
        "CONTROL:11: 'pressure_tensor': the cell's angles stay 90 degrees: xy, xz and yz must be 0",
    ),
    "sides_of_a_square": (
        {
            "control": {
                **PISTON,
                "ensemble": "nst",
                "ensemble_semi_isotropic": "orthorhombic",
                "ensemble_semi_orthorhombic": "on",
                "pressure_perpendicular": "[ 1 2 3 ] dpd_p",
            }
        },
        "CONTROL:13: 'pressure_perpendicular': x and y change by one factor: their pressures must be the same",
    ),
    "ensemble_andersen": (
        {"control": {"ensemble_method": "andersen"}},
        f"CONTROL:3: 'ensemble_method': ensemble nvt andersen is not modelled; {AVAILABLE}",
    ),
    "ensemble_nvt_alone": (
        {"control": {"ensemble_method": None, "ensemble_dpd_order": None}},
        f"CONTROL:2: 'ensemble': ensemble nvt needs a thermostat; {AVAILABLE}",
    ),
    "peters_first_of_a_strong_drag": (
        {"control": {"ensemble_dpd_order": "peters-first", "timestep": "0.5 dpd_t"}},
        (
            "CONTROL:4: 'ensemble_dpd_order': pair A A: peters-first needs drag x timestep / reduced mass below 2; "
            "peters has no such limit; here it is 4.5"
        ),
    ),
    "lowe_with_a_rate_too_high": (
        {"control": {"ensemble_dpd_order": "lowe", "ensemble_dpd_rate": "200 dpd_t^-1"}},
        (
            "CONTROL:4: 'ensemble_dpd_order': pair A A: the probability that a pair is chosen in one step would be "
            "above 1; here it is 2"
        ),
    ),
    "transverse_drag_of_forces": (
        {"control": {"ensemble_dpd_transverse_drag": "0.5"}},
        (
            "CONTROL:10: 'ensemble_dpd_transverse_drag': mdvv has no drag across a pair's line; those that have: "
            "zeroth, first, second, peters, peters-first, lowe-andersen, stoyanov-groot, ou, ou-middle"
        ),
    ),
    "no_pass": (
        {"control": {"ensemble_dpd_order": "middle", "ensemble_dpd_passes": "0"}},
        "CONTROL:10: 'ensemble_dpd_passes': the number of passes lies in 1 to 3, not 0",
    ),
    "times_without_temperatures": (
        {"control": {"temperature_times": "[ 0 1 ] dpd_t"}},
        "CONTROL:10: 'temperature_times': temperature_times and temperature_values belong together",
    ),
    "times_that_do_not_ascend": (
        {"control": {"temperature_times": "[ 1 1 ] dpd_t", "temperature_values": "[ 1 2 ] dpd_temp"}},
        "CONTROL:10: 'temperature_times': the times must ascend",
    ),
    "more_times_than_temperatures": (
        {"control": {"temperature_times": "[ 0 1 ] dpd_t", "temperature_values": "[ 1 ] dpd_temp"}},
        "CONTROL:11: 'temperature_values': there are 2 times and 1 temperatures",
    ),
    "sine_below_zero": (
        {"control": {"temperature_amplitude": "2 dpd_temp", "temperature_period": "1 dpd_t"}},
        "CONTROL:10: 'temperature_amplitude': the temperature would become negative",
    ),
    "sine_without_period": (
        {"control": {"temperature_amplitude": "0.5 dpd_temp"}},
        "CONTROL:10: 'temperature_amplitude': the sine needs a temperature_period above 0",
    ),
    "order_missing": (
        {"control": {"ensemble_dpd_order": None}},
        f"CONTROL:3: 'ensemble_method': the DPD thermostat needs ensemble_dpd_order; {AVAILABLE}",
    ),
    "timestep_zero": (
        {"control": {"timestep": "0.0 ps"}},
        "CONTROL:6: 'timestep': the timestep must be above 0 ps, not 0",
    ),
    "temperature_negative": (
        {"control": {"temperature": "-1.0 K"}},
        "CONTROL:5: 'temperature': the temperature must not be negative, found -1 K",
    ),
    "prediction": (
        {"control": {"ensemble_dpd_lambda": "1.5"}},
        "CONTROL:10: 'ensemble_dpd_lambda': Groot and Warren's lambda lies in 0 to 1, not 1.5",
    ),
    "weight_exponent": (
        {"control": {"ensemble_dpd_exponent": "0.0"}},
        "CONTROL:10: 'ensemble_dpd_exponent': the exponent of the drag's weight must be above 0, not 0",
    ),
    "replay": ({"control": {"replay": "on"}}, "CONTROL:10: 'replay': replay on is not modelled: replay of a HISTORY"),
    "replication": (
        {"control": {"nfold": "[ 2 0 2 ]"}},
        "CONTROL:10: 'nfold': expected three whole numbers from 1 on, not 2 0 2",
    ),
    "plumed": ({"control": {"plumed": "on"}}, "CONTROL:10: 'plumed': plumed on is not modelled: PLUMED"),
    "vdw_by_ewald": (
        {"control": {"vdw_method": "spme"}},
        "CONTROL:10: 'vdw_method': vdw_method spme is not modelled: pair laws by Ewald summation",
    ),
    "cutoff_zero": (
        {"control": {"cutoff": "0.0 ang"}},
        "CONTROL:7: 'cutoff': a cutoff lies above 0 and up to 1e+09 ang, not at 0",
    ),
    "vdw_cutoff_zero": (
        {"control": {"vdw_cutoff": "0.0 ang"}},
        "CONTROL:10: 'vdw_cutoff': a cutoff lies above 0 and up to 1e+09 ang, not at 0",
    ),
    "steps_negative": (
        {"control": {"time_run": "-5 steps"}},
        "CONTROL:8: 'time_run': the number of steps must not be negative, found -5",
    ),
    "interval_negative": (
        {"control": {"print_frequency": "-5 steps"}},
        "CONTROL:10: 'print_frequency': the interval must not be negative, found -5 steps",
    ),
    "override_no_drag": (
        {"control": {"ensemble_dpd_drag_override": "on"}},
        (
            "CONTROL:10: 'ensemble_dpd_drag_override': needs ensemble_dpd_drag, the drag that is to "
            "replace those of FIELD"
        ),
    ),
    "force_cap_negative": (
        {"control": {"equilibration_force_cap": "-1.0 dpd_f"}},
        "CONTROL:10: 'equilibration_force_cap': the largest force must not be negative, found -1",
    ),
    "threads": (
        {"control": {"threads": "-1"}},
        "CONTROL:10: 'threads': the number of threads must not be negative, found -1",
    ),
    "rigid": (
        {"atoms": ("A 1.0 0.0 2", "B 2.0 0.0"), "inside": "rigid 1\n2 1 2"},
        "FIELD:8: 'rigid': the block rigid of molecule mol1 is not modelled yet",
    ),
    "shells": (
        {"atoms": ("A 1.0 0.0 2", "B 2.0 0.0"), "inside": "shell 1\n1 2 10.0"},
        "FIELD:8: 'shells': the block shells of molecule mol1 is not modelled yet",
    ),
    "metal": ({"after": "metal 1\nA A stch 1 2 3 4 5"}, "FIELD:18: 'metal': the block metal is not modelled yet"),
    "piston_field": (
        {"after": "extern\nxpis 1 2 3"},
        "FIELD:19: 'xpis': this external field is not modelled; elec, grav, magn, osel, oshr, pois, shrx, sphr, zbnd "
        "are",
    ),
    "grav_with_two_numbers": ({"after": "extern\ngrav 0 1"}, "FIELD:19: 'grav': takes 3 numbers (Gx Gy Gz), found 2"),
    "oshr_in_a_parallelepiped": (
        {"after": "extern\noshr 1 1", "imcon": 3},
        ("FIELD:19: 'oshr': oscillating shear needs a cubic or orthorhombic cell (imcon 1 or 2), not imcon 3"),
    ),
    "charges": (
        {"control": {"coul_method": "reaction_field"}, "atoms": ("A 1.0 1.0", "B 2.0 -2.0")},
        (
            "CONTROL:10: 'coul_method': in units dpd charges are in e and their strength is that of "
            "coul_bjerrum_length, or of coul_coupling = 4 pi times it: CONTROL gives neither"
        ),
    ),
    "massless": (
        {"atoms": ("A 0.0 0.0", "B 2.0 0.0")},
        (
            "FIELD:7: 'A': bead A of molecule mol1 has no mass (0) and is not frozen: massless beads "
            "cannot be integrated yet; give it a mass or freeze it"
        ),
    ),
    "too_few_beads": ({"names": ["A", "A", "A", "A", "B"]}, "CONFIG: 5 beads, but the molecules of FIELD add up to 6"),
    "wrong_order": (
        {"names": ["A", "A", "B", "A", "A", "B"]},
        ("CONFIG: 'B': bead 3 is B, but FIELD expects A there (bead 1 of copy 3 of molecule mol1, FIELD:4)"),
    ),
    "too_few_beads_and_wrong_names": (
        {"names": ["A", "B"]},
        (
            "CONFIG: 2 beads, but the molecules of FIELD add up to 6; bead 2 is B, but FIELD expects "
            "A there (bead 1 of copy 2 of molecule mol1, FIELD:4)"
        ),
    ),
    "cubic_edge_negative": (
        {"cell": ((-4, 0, 0), (0, 4, 0), (0, 0, 4))},
        "CONFIG: the cubic cell's edge must be positive, not -4",
    ),
    "orthorhombic_edge_zero": (
        {"cell": ((4, 0, 0), (0, 0, 0), (0, 0, 4)), "imcon": 2},
        "CONFIG: the orthorhombic cell's edges must be positive, not 4 0 4",
    ),
    "singular_cell": (
        {"cell": ((4, 0, 0), (8, 0, 0), (0, 0, 4)), "imcon": 3},
        "CONFIG: the cell vectors (4 0 0; 8 0 0; 0 0 4) span no volume (imcon 3)",
    ),
    "slab_out_of_plane": (
        {"cell": ((4, 0, 1), (0, 4, 0), (0, 0, 4)), "imcon": 6},
        "CONFIG: a slab (imcon 6) needs its first two cell vectors in the xy plane",
    ),
    "bead_far_away": (
        {"positions": [(5000000000.0, 0, 0), (0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0), (4, 0, 0)]},
        "CONFIG: bead 1 (A) lies more than a thousand million cells away from the origin",
    ),
    "too_few_parameters": ({"vdw": ("A A dpd 25.0",)}, "FIELD:15: 'dpd': A A: needs 2 numbers (A rc), found 1"),
    "impossible_parameter": (
        {"vdw": ("A A dpd 25.0 -1.0 4.5",)},
        "FIELD:15: 'dpd': A A: pair law dpd: rc (number 2) must be a positive number, not -1",
    ),
    "extra_number": (
        {"vdw": ("A A dpd 25.0 1.0 4.5 1.0 7.5",)},
        (
            "FIELD:15: '7.5': number 5 of the dpd record of A A has no meaning: the law takes A rc, "
            "and after the drag and its cutoff the record ends"
        ),
    ),
    "m126_has_no_room_for_a_drag": (
        {"vdw": ("A A m126 1.0 1.0 0.8 4.5",)},
        (
            "FIELD:15: '4.5': number 4 of the m126 record of A A has no meaning: the law takes A B "
            "ri, and its record has no room for a drag"
        ),
    ),
    "zbl_drag_in_the_wrong_slot": (
        {"vdw": ("A A zbl 6 8 4.5",)},
        (
            "FIELD:15: '4.5': number 3 of the zbl record of A A has no meaning: the law takes Z1 Z2, "
            "and its drag is number 5 of the record"
        ),
    ),
    "drag_cutoff_negative": (
        {"vdw": ("A A dpd 25.0 1.0 4.5 -1.0",)},
        "FIELD:15: 'dpd': A A: the drag's own cutoff (number 4) lies above 0 and up to 1e+09 ang, not at -1",
    ),
    "undefined_drags": (
        {"vdw": ("A A dpd 25.0 1.0 4.5", "B B dpd 25.0 1.0")},
        (
            "FIELD: the DPD ensemble needs a drag for every pair, and none is defined for A-B, B-B; "
            "cures: write it after the law's numbers on the pair's vdw line; a vdw_mix_method, when "
            "both like pairs have a drag; ensemble_dpd_drag for all pairs without one"
        ),
    ),
    "undefined_drags_with_mixing": (
        {"control": {"vdw_mix_method": "lorentz-berthelot"}, "vdw": ("A A dpd 25.0 1.0 4.5", "B B dpd 25.0 1.0")},
        (
            "FIELD: the DPD ensemble needs a drag for every pair, and none is defined for A-B, B-B; "
            "cures: write it after the law's numbers on the pair's vdw line; ensemble_dpd_drag for "
            "all pairs without one"
        ),
    ),
    "all_drags_zero": (
        {"vdw": ("A A dpd 25.0 1.0 0.0", "A B dpd 25.0 1.0 0", "B B dpd 25.0 1.0 0")},
        (
            "FIELD: every drag is 0 under a DPD ensemble, which would be plain NVE without saying so:"
            " give drags in FIELD or ensemble_dpd_drag, or choose ensemble nve"
        ),
    ),
    "law_cannot_be_mixed": (
        {"control": {"vdw_mix_method": "tang-toennies"}, "vdw": ("A A dpd 0.0 1.0 4.5", "B B dpd 25.0 1.0 4.5")},
        (
            "FIELD: the pair law of A-B cannot be mixed: mixing rule tang-toennies for pair law dpd: "
            "the rule divides by both energies and both lengths, so all must be above zero; give this"
            " pair its own line"
        ),
    ),
    "drag_cannot_be_mixed": (
        {
            "control": {"vdw_mix_method": "functional"},
            "vdw": ("A A dpd 0.0 1.0 4.5", "A B dpd 1.0 1.0", "B B dpd 25.0 1.0 4.5"),
        },
        (
            "FIELD: the drag of A-B cannot be mixed: mixing rule functional for pair law dpd: the "
            "drag divides by both energies, so a species with drag needs an energy above zero; give "
            "this pair its own line"
        ),
    ),
    "mixed_parameter_vanishes": (
        {
            "control": {"vdw_mix_method": "hogervorst"},
            "vdw": ("A A dpd 1.0 1e-300 1.0", "B B dpd 1.0 1e-300 1.0"),
        },
        "FIELD: the pair law of A-B cannot be mixed: pair law dpd: rc (number 2) must be a positive number, not 0; give"
        " this pair its own line",
    ),
    "law_reaches_too_far": (
        {"control": {"ensemble_dpd_drag": "1.0 Da/ps"}, "vdw": ("A A dpd 1.0 1e10 1.0",)},
        "FIELD: A-A: the law's range 1e+10 ang is longer than 1e+09 ang",
    ),
    "noise_overflows": (
        {
            "control": {"ensemble_dpd_drag": "1.0 Da/ps", "temperature": "1e10 K"},
            "vdw": ("A A dpd 1.0 1.0 1e300",),
        },
        "FIELD: the drag 1e+300 of A-A is too large: its noise is not finite",
    ),
    "cell_too_large": (
        {"imcon": 3, "cell": ((4, 0, 0), (0, 1e10, 0), (0, 0, 4))},
        "CONFIG: the cell vectors contain a number that is not finite or beyond 1e+09 ang",
    ),
    "more_threads_than_a_process_may_have": (
        {"control": {"threads": "1000000"}},
        "CONTROL:10: 'threads': at most 1024 threads can be used, found 1000000",
    ),
    "rolling_averages_beyond_memory": (
        {"control": {"stack_size": "100000000000 steps"}},
        "CONTROL:10: 'stack_size': rolling averages over 100000000000 steps; at most 1000000 are kept",
    ),
    "name_that_output_files_cannot_hold": (
        {
            "atoms": ("Ä 1.0 0.0", "B 2.0 0.0"),
            "names": ("Ä", "Ä", "Ä", "Ä", "B", "B"),
            "vdw": ("Ä Ä dpd 25.0 1.0 4.5", "Ä B dpd 30.0 1.0 4.5", "B B dpd 25.0 1.0 4.5"),
        },
        "FIELD:7: 'Ä': a species name has a letter outside ASCII, and DL_POLY's files have no room for it",
    ),
    "distances_over_a_million_cells": (
        {"control": {"cutoff": "1e6 dpd_l", "rdf_calculate": "on"}},
        "CONTROL:10: 'rdf_calculate': 1.25e+17 images of the cell lie within the cutoff 1e+06 ang, to which distances "
        "are counted, more than 30000: the cell is too small for it",
    ),
    "law_over_a_million_cells": (
        {
            "control": {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None, "cutoff": "1e6 dpd_l"},
            "vdw": ("A A lj 1.0 1.0", "A B dpd 1.0 1.0", "B B dpd 1.0 1.0"),
        },
        "CONFIG: 1.25e+17 images of the cell lie within the longest range 1e+06 ang, more than 30000: the cell is too "
        "small for it",
    ),
    "table_missing": (
        {"vdw": ("A A tab 4.5", "A B dpd 1.0 1.0 4.5", "B B dpd 25.0 1.0 4.5")},
        "FIELD: A-A is a tab pair, but the TABLE file has no entry for it",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_scene_is_refused_with_this_message(make, name):
    changes, message = CASES[name]
    with pytest.raises(SceneError) as caught:
        make(**changes).scene()
    assert str(caught.value) == message


def records(make):
    case = make()
    return parse_control(case.control_text()), parse_field(case.field_text()), parse_config(case.config_text())


def test_unknown_species_in_a_record_made_by_a_program(make):
    control, field, config = records(make)
    field = replace(field, pairs=(*field.pairs, PairLine(("A", "b"), "dpd", (1.0, 1.0, 1.0))))
    with pytest.raises(SceneError) as caught:
        resolve(control, field, config)
    assert str(caught.value) == "FIELD: 'b': no molecule has a bead of this name; did you mean B?"


def test_unknown_law_in_a_record_made_by_a_program(make):
    control, field, config = records(make)
    field = replace(field, pairs=(PairLine(("A", "A"), "gaus", (1.0, 1.0)), *field.pairs[1:]))
    with pytest.raises(SceneError) as caught:
        resolve(control, field, config)
    assert str(caught.value) == (
        "FIELD: 'gaus': A A: is not a pair law that is modelled "
        "(known: 12-6, 14-7, bhm, buck, dpd, hbnd, lj, ljc, ljf, m126, mbuc, mdpd, mlj, mors, mstw, "
        "ndpd, nm, ryd, sand, snm, sw, tab, wca, zbl, zblb, zbls)"
    )


def test_pair_twice_in_a_record_made_by_a_program(make):
    control, field, config = records(make)
    field = replace(field, pairs=(*field.pairs, PairLine(("B", "A"), "dpd", (1.0, 1.0, 1.0), line=40)))
    with pytest.raises(SceneError) as caught:
        resolve(control, field, config)
    assert str(caught.value) == "FIELD:40: 'dpd': the pair B A is already given on line 16"


def test_unknown_species_of_an_rdf_pair_in_a_record_made_by_a_program(make):
    case = make(control={"rdf_calculate": "on"})
    control, field, config = (
        parse_control(case.control_text()),
        parse_field(case.field_text()),
        parse_config(case.config_text()),
    )
    with pytest.raises(SceneError) as caught:
        resolve(control, replace(field, rdf_pairs=(("A", "X"),)), config)
    assert str(caught.value) == "FIELD: 'X': the rdf block names a species that no molecule has"


def test_more_beads_than_can_be_numbered(make):
    control, field, config = records(make)
    many = replace(field, molecules=(replace(field.molecules[0], count=10**17), *field.molecules[1:]))
    with pytest.raises(SceneError) as caught:
        resolve(control, many, config)
    assert str(caught.value) == "FIELD: the molecules add up to 100000000000000002 beads, more than 2147483647"


def test_no_beads_at_all(make):
    control, field, config = records(make)
    none = replace(field, molecules=tuple(replace(m, count=0) for m in field.molecules))
    with pytest.raises(SceneError) as caught:
        resolve(control, none, replace(config, names=(), positions=config.positions[:0]))
    assert str(caught.value) == "FIELD: there are no beads: all molecules together have none"


@pytest.mark.parametrize("imcon", [4, 5, 7, 8])
def test_cell_shape_that_is_not_modelled(make, imcon):
    control, field, config = records(make)
    with pytest.raises(SceneError, match=rf"^CONFIG: periodicity key imcon {imcon}.*0, 1, 2, 3 and 6 are$"):
        resolve(control, field, replace(config, imcon=imcon))


@pytest.mark.parametrize("what", ["positions", "velocities"])
def test_coordinate_that_is_not_finite(make, what):
    control, field, config = records(make)
    broken = config.positions.copy()
    broken[2, 1] = float("nan")
    with pytest.raises(SceneError) as caught:
        resolve(control, field, replace(config, **{what: broken}))
    word = {"positions": "position", "velocities": "velocity"}[what]
    assert str(caught.value) == f"CONFIG: the {word} of bead 3 (A) is not finite"
