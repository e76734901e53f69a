"""Scene.explain(): every section, the origin of every number, and lines that fit a terminal."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly.formats.records import PairTable

NVE = {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None}
TITLES = [
    "Scene",
    "System",
    "Integrator and thermostat",
    "Pair table",
    "Bonded terms",
    "Electrostatics",
    "Cutoffs and link cells",
    "Plan",
    "Long-range correction",
    "External fields",
    "Run",
    "Output",
    "Not modelled or without effect",
    "Choices",
    "Warnings",
]


def sections(scene):
    """Split the text at the underlined titles."""
    result, title = {}, None
    lines = scene.explain().splitlines()
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        if line and following == "-" * len(line):
            title, result[line] = line, []
        elif title is not None and line and set(line) != {"-"}:
            result[title].append(line)
    return result


def test_sections_in_order(make):
    assert list(sections(make().scene())) == TITLES


@pytest.mark.parametrize("units", ["dpd", "kJ"])
def test_lines_fit(make, units):
    control = {"rdf_calculate": "on", "temperature": "1.0 K", "replay": "off"}
    text = make(units=units, control=control, atoms=("A 1.0 1.0", "B 2.0 0.0 1 1")).scene().explain()
    assert max(len(line) for line in text.splitlines()) <= 100
    assert text.isascii()
    assert text.endswith("\n")


def test_title_and_sources(make):
    lines = sections(make(units="kJ", control=NVE).scene())["Scene"]
    assert lines[:4] == ["test", "from CONTROL", "from FIELD", "from CONFIG"]
    assert lines[4] == "reports: energy in kJ/mol, temperature in K, pressure in katm"
    assert sections(make().scene())["Scene"][-1] == "all numbers below are reduced"
    mixed = sections(make(units="kJ", control={"io_units_scheme": "dpd"}).scene())["Scene"]
    assert mixed[4:] == [
        "reports in reduced units: k_B = 1, pressure in energy per volume",
        "lengths in ang, times in ps, masses in Da; internal energy 10 J/mol",
    ]


def test_system(make):
    scene = make(atoms=("A 1.0 0.5", "B 2.0 0.0 1 1", "C 3.0"), counts=(4, 2, 0), control=NVE).scene()
    assert sections(scene)["System"] == [
        "species  beads  mass  charge  frozen",
        "A            4     1     0.5       0",
        "B            2     2       0       2",
        "C            0     -       -       0",
        "molecules: 4 mol1, 2 mol2, 0 mol3",
        "cell: imcon 1, cubic",
        "             4            0            0",
        "             0            4            0",
        "             0            0            4",
        "volume 64, 6 beads, 0.09375 beads per unit volume",
    ]


def test_species_with_several_masses(make):
    scene = make(atoms=("A 1.0 0.0", "A 2.0 0.0"), vdw=("A A dpd 25.0 1.0 4.5",)).scene()
    assert sections(scene)["System"][1].split() == ["A", "6", "1", "to", "2", "0", "0"]


def test_thermostat(make):
    scene = make(units="kJ", control={"temperature": "300.0 K", "ensemble_dpd_exponent": "1.0"}).scene()
    assert sections(scene)["Integrator and thermostat"] == [
        "mdvv: velocity Verlet with pairwise drag and noise (Groot and Warren)",
        "temperature 300 K, k_B T = 249.435335 (10 J/mol)",
        "prediction of the velocities lambda = 0.5",
        "weight of the drag (1 - r/rc)^1, of the noise (1 - r/rc)^0.5; noise^2 = 2 drag k_B T",
        "timestep 0.01 ps",
        "degrees of freedom 15; drift of the centre of mass is not removed",
    ]


def test_no_thermostat(make):
    scene = make(control=NVE, atoms=("A 1.0 0.0", "B 2.0 0.0 1 1")).scene()
    assert sections(scene)["Integrator and thermostat"] == [
        "nve: velocity Verlet, no thermostat",
        "k_B T = 1, for drawn or scaled velocities only",
        "timestep 0.01",
        "degrees of freedom 9; drift of the centre of mass is removed in every step",
    ]


def test_pair_table_shows_the_numbers_as_written_and_where_they_come_from(make):
    vdw = ("A A dpd 0.25 1.0 4.5", "B B dpd 0.36 2.0 18.0")
    control = {"vdw_mix_method": "lorentz-berthelot", "temperature": "1.0 k"}
    assert sections(make(units="kJ", vdw=vdw, control=control).scene())["Pair table"] == [
        "energies in kJ/mol, lengths in ang, drags in Da/ps, as in FIELD",
        "pair  law  parameters    ends at  drag    noise  drag ends at",
        "A-A   dpd  A=0.25 rc=1         1   4.5  2.73552             1",
        "A-B   dpd  A=0.3 rc=1.5      1.5     9  3.86861           1.5",
        "B-B   dpd  A=0.36 rc=2         2    18  5.47104             2",
        "where the numbers come from:",
        "  A-A: law FIELD:15; drag FIELD:15; in internal units A=25 rc=1",
        "  A-B: law mixed from A-A and B-B by lorentz-berthelot; drag mixed from A-A and B-B by",
        "    lorentz-berthelot; in internal units A=30 rc=1.5",
        "  B-B: law FIELD:16; drag FIELD:16; in internal units A=36 rc=2",
        "dpd: soft repulsion of DPD, A rc/2 (1 - r/rc)^2",
    ]


def test_pair_table_without_a_thermostat_has_no_drags(make):
    vdw = ("A A lj 1.0 0.3", "A B tab")
    r = 0.01 * np.arange(1, 101)
    table = PairTable(("A", "B"), 0.01, 1.0, 1 - r, r)
    control = {**NVE, "vdw_force_shift": "on"}
    lines = sections(make(vdw=vdw, tables=(table,), control=control).scene())["Pair table"]
    assert lines[:8] == [
        "energies in reduced units, as in FIELD",
        "pair  law  parameters                         ends at",
        "A-A   lj   eps=1 sig=0.3                      1 shifted",
        "A-B   tab  table of 100 points, spacing 0.01  1 shifted",
        "B-B   -    no conservative force              -",
        "where the numbers come from:",
        "  A-A: law FIELD:15",
        "  A-B: law FIELD:16",
    ]


def test_bonded_terms(make):
    assert sections(make().scene())["Bonded terms"] == ["none"]
    positions = [[0.3 * k, 0.1 * k * k, 0.0] for k in range(10)]
    inside = (
        "bonds 3\nharm 1 2 2.0 0.5\n-hrm 2 3 4.0 0.5\nharm 3 4 2.0 0.5\n"
        "dihedrals 1\nharm 1 2 3 4 1.0 120.0 0.0 0.0 0.5\nteth 1\nharm 4 7.0"
    )
    scene = make(
        atoms=("A 1.0 0.0 4", "B 2.0 0.0"), counts=(2, 2), units="kJ", inside=inside, positions=positions
    ).scene()
    assert sections(scene)["Bonded terms"] == [
        "energies in kJ/mol, lengths in ang, angles in degrees, as in FIELD",
        "molecule  kind      law   numbers       terms",
        "mol1      bond      harm  k=2 r0=0.5        4",
        "mol1      bond      -hrm  k=4 r0=0.5        2",
        "mol1      dihedral  harm  k=1 phi0=120      2",
        "mol1      tether    harm  k=7               2",
        "  mol1 bond harm: FIELD:9, FIELD:11",
        "  mol1 bond -hrm: FIELD:10",
        "  mol1 dihedral harm: FIELD:13",
        "  mol1 tether harm: FIELD:15",
        "bond harm: spring, k/2 (r - r0)^2",
        "dihedral harm: spring, k/2 (phi - phi0)^2, the short way round",
        "tether harm: spring, k/2 d^2",
        "pairs without pair forces, drag and noise: 12",
        "of these, 1-4 pairs that feel their pair law times a factor: 2",
        "keys with a minus sign leave their beads the pair forces",
    ]
    assert "not in this scene, at no cost: electrostatics, external fields" in scene.explain()


def test_many_sets_of_bonded_numbers_are_counted(make):
    bonds = "\n".join(f"harm {k} {k + 1} {k}.0 0.5" for k in range(1, 51))
    positions = [[0.02 * k, 0.0, 0.0] for k in range(53)]
    scene = make(
        atoms=("A 1.0 0.0 51", "B 2.0 0.0"), counts=(1, 2), inside=f"bonds 50\n{bonds}", positions=positions
    ).scene()
    assert sections(scene)["Bonded terms"][1:3] == [
        "molecule  kind  law   numbers  terms",
        "mol1      bond  harm  50 sets     50",
    ]


def test_cutoffs_and_cost(make):
    positions = np.random.default_rng(3).uniform(-2, 2, (192, 3))
    scene = make(counts=(100, 92), positions=positions).scene()  # three beads a unit volume
    assert sections(scene)["Cutoffs and link cells"] == [
        "global cutoff 1: range of the radial distribution",
        "van der Waals cutoff 1: where laws without a range of their own end",
        "longest range 1: about 4 x 4 x 4 link cells",
        "about 6.28 pairs a bead within it, 1.21e+03 pair evaluations a step",
        "memory: about 1 MB",
    ]


def test_cutoffs_in_a_small_cell_and_without_pairs(make):
    small = make(cell=((2, 0, 0), (0, 2, 0), (0, 0, 2))).scene()
    assert "2 x 2 x 2 link cells (fewer than 3 along an axis" in sections(small)["Cutoffs and link cells"][2]
    nothing = sections(make(vdw=(), control=NVE).scene())
    assert nothing["Cutoffs and link cells"][2] == "no pair forces: no link cells"
    assert nothing["Not modelled or without effect"][0] == (
        "not in this scene, at no cost: bonded terms, electrostatics, conservative pair forces, drag and"
    )


def test_long_range_correction(make):
    vdw = ("A A lj 1.0 0.3", "A B dpd 1.0 1.0")
    none = sections(make().scene())["Long-range correction"]
    assert none == ["none: no law of this scene reaches beyond its cutoff"]
    tails = sections(make(vdw=vdw, control=NVE).scene())["Long-range correction"]
    assert tails == ["energy and pressure include the tails of lj beyond their cutoffs"]
    off = sections(make(vdw=vdw, control={**NVE, "vdw_force_shift": "on"}).scene())["Long-range correction"]
    assert off == ["none, although lj would reach beyond the cutoff"]


def test_external_fields(make):
    assert sections(make().scene())["External fields"] == ["none"]
    gravity = sections(make(units="kJ", after="extern\ngrav 0 0 -0.5").scene())["External fields"]
    assert gravity == ["grav: F = m G with G = (0 0 -50) in internal units, from FIELD:19"]
    shear = sections(make(units="kJ", after="extern\noshr 0.8 2").scene())["External fields"]
    assert shear == ["oshr: Fx = A cos(2 pi n z/Lz) with A = 80 Da ang/ps^2, n = 2, from FIELD:19"]


def test_run(make):
    control = {
        "time_equilibration": "20 steps",
        "rescale_frequency": "1 steps",
        "regauss_frequency": "5 steps",
        "equilibration_force_cap": "7.5 dpd_f",
        "random_seed": "42",
        "threads": "2",
    }
    assert sections(make(control=control).scene())["Run"] == [
        "100 steps, time 1 in all",
        "equilibration: the first 20 steps; averages are taken after it",
        "  velocities are scaled to the temperature every step of it",
        "  velocities are drawn anew every 5 steps of it",
        "  forces are capped at 7.5 in it",
        "start (clean): velocities drawn from the Maxwell distribution at the temperature",
        "seed: 42",
        "2 threads",
    ]
    plain = sections(make(units="kJ", control={"random_seed": None, "restart": "continue"}).scene())["Run"]
    assert plain == [
        "100 steps, 1 ps in all",
        "no equilibration",
        "start (continue): goes on from the checkpoint REVOLD",
        "seed: drawn anew for each run, and printed",
        "all threads there are",
    ]


def test_output(make):
    control = {
        "print_frequency": "10 steps",
        "stats_frequency": "1 steps",
        "traj_calculate": "on",
        "traj_key": "pos-vel",
        "rdf_calculate": "on",
        "rdf_frequency": "4 steps",
        "io_statis_yaml": "on",
    }
    assert sections(make(control=control).scene())["Output"] == [
        "OUTPUT: every 10 steps, report, rolling averages over 100 steps",
        "STATIS: every step, statistics as YAML",
        "HISTORY: every step, positions and velocities from step 0",
        "RDFDAT: every 4 steps, radial distribution in bins of 0.05 for A-A, A-B, B-B",
        "REVCON and REVIVE: at the end and every 1000 steps",
    ]
    names = {f"io_file_{name}": "NONE" for name in ("output", "revive", "revcon")}
    quiet = {**names, "data_dump_frequency": "0 steps"}
    assert sections(make(control=quiet).scene())["Output"] == ["not written: STATIS, HISTORY, RDFDAT"]


def test_what_has_no_effect_what_was_chosen_and_what_to_beware_of(make):
    control = {"padding": "0.3 ang", "cutoff": "0.5 ang", "vdw_method": "off"}
    found = sections(make(control=control).scene())
    absent = found["Not modelled or without effect"]
    assert absent == [
        "not in this scene, at no cost: bonded terms, electrostatics, conservative pair forces, external",
        "  fields",
        "* padding 0.3 ang: pydlpoly chooses the skin; results do not depend on it [CONTROL:10]",
    ]
    assert "* cutoff 0.5 ang is used as it is; DL_POLY would take 1 ang instead [CONTROL:7]" in found["Choices"]
    assert found["Warnings"] == ["* vdw_method off: no conservative pair forces [CONTROL:11]"]
    assert sections(make().scene())["Warnings"] == ["none"]
