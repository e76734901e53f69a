"""Ensemble, start, momentum, run and output: what CONTROL becomes."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly.errors import SceneError
from pydlpoly.formats.config import parse_config
from pydlpoly.formats.control import parse_control
from pydlpoly.formats.field import parse_field
from pydlpoly.scene import resolve
from pydlpoly.scene.dynamics import combine_seed
from pydlpoly.units import KATM_PER_INTERNAL_PRESSURE, TENSION_IN_DYN_PER_CM

NVE = {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None}
FROZEN = ("A 1.0 0.0", "B 2.0 0.0 1 1")
GRAVITY = "extern\ngrav 0.0 0.0 -0.5"


def texts(scene, kind):
    return [note.text for note in scene.notes if note.kind == kind]


def test_dpd_with_defaults(make):
    dynamics = make().scene().dynamics
    assert (dynamics.integrator, dynamics.timestep, dynamics.thermal_energy) == ("mdvv", 0.01, 1.0)
    assert (dynamics.prediction, dynamics.weight_exponent) == (0.5, 2.0)


def test_dpd_with_its_own_numbers(make):
    control = {"ensemble_dpd_lambda": "0.65", "ensemble_dpd_exponent": "4.0", "timestep": "20.0 fs"}
    dynamics = make(control=control).scene().dynamics
    assert (dynamics.prediction, dynamics.weight_exponent) == (0.65, 4.0)
    assert dynamics.timestep == pytest.approx(0.02, rel=1e-15)


def test_temperature_zero_is_drag_without_noise(make):
    scene = make(control={"temperature": "0.0 K"}).scene()
    assert [(term.drag, term.noise) for term in scene.pairs] == [(4.5, 0.0)] * 3
    assert "the DPD thermostat has temperature 0: drag only, no noise" in texts(scene, "choice")


def test_temperature_left_out_is_zero_and_noted(make):
    scene = make(control={**NVE, "temperature": None}).scene()
    assert scene.dynamics.thermal_energy == 0.0
    assert "no temperature is given: 0 K" in texts(scene, "choice")


@pytest.mark.parametrize(
    ("changes", "degrees", "remove_drift"),
    [
        ({}, 15, False),
        ({"control": NVE}, 15, False),
        ({"control": {"fixed_com": "off"}}, 18, False),
        ({"control": {**NVE, "fixed_com": "off"}}, 18, False),
        ({"atoms": FROZEN}, 12, False),
        ({"atoms": FROZEN, "control": NVE}, 9, True),
        ({"after": GRAVITY}, 18, False),
        ({"after": GRAVITY, "control": NVE}, 15, True),
        ({"after": GRAVITY, "control": {**NVE, "fixed_com": "off"}}, 18, False),
    ],
)
def test_degrees_of_freedom_and_drift(make, changes, degrees, remove_drift):
    scene = make(**changes).scene()
    assert (scene.degrees_of_freedom, scene.dynamics.remove_drift) == (degrees, remove_drift)


def test_dpd_keeps_the_drift_that_frozen_beads_bring_about_and_says_so(make):
    note = (
        "fixed_com: the DPD thermostat does not remove the drift that frozen beads bring about, so all 12 momenta count"
    )
    assert f"{note} as degrees of freedom" in texts(make(atoms=FROZEN).scene(), "choice")


@pytest.mark.parametrize("counts", [(1, 0), (0, 2)])
def test_no_degree_of_freedom_left(make, counts):
    scene = make(atoms=FROZEN, counts=counts, control=NVE).scene()
    assert scene.degrees_of_freedom == 0
    assert "no degree of freedom is left: the temperature is reported as 0" in texts(scene, "warning")


@pytest.mark.parametrize("start", ["rescale", "noscale", "continue"])
def test_velocities_are_taken_from_the_file(make, start, drifting):
    control = {"restart": start, "fixed_com": "off"}
    scene = make(control=control, velocities=drifting).scene()
    assert scene.run.start == start
    assert scene.beads.velocities.tolist() == drifting


def test_clean_start_draws_velocities(make, drifting):
    scene = make(velocities=drifting).scene()
    assert scene.run.start == "clean"
    assert scene.beads.velocities is None


@pytest.mark.parametrize("start", ["rescale", "noscale"])
def test_start_without_velocities_becomes_clean(make, start):
    scene = make(control={"restart": start}).scene()
    assert scene.run.start == "clean"
    note = f"restart {start} needs velocities, and CONFIG has none (levcfg 0): they are drawn, as for restart clean"
    assert f"{note} (DL_POLY's warning 200)" in texts(scene, "warning")


def test_rescaling_of_beads_at_rest_becomes_clean(make):
    scene = make(control={"restart": "rescale"}, velocities=[[0, 0, 0]] * 6).scene()
    assert scene.run.start == "clean"
    assert any("cannot scale velocities that are all 0" in text for text in texts(scene, "warning"))


def test_beads_at_rest_may_start_at_rest(make):
    scene = make(control={"restart": "noscale"}, velocities=[[0, 0, 0]] * 6).scene()
    assert scene.run.start == "noscale"
    assert not scene.beads.velocities.any()
    note = "restart noscale from velocities that are all 0: the beads start at rest; DL_POLY draws them"
    assert note in texts(scene, "choice")


def test_continuing_needs_no_velocities_in_the_file(make):
    scene = make(control={"restart": "continue", "io_file_revold": "OLD"}).scene()
    assert (scene.run.start, scene.run.checkpoint_file, scene.beads.velocities) == ("continue", "OLD", None)


def test_drift_is_taken_out_at_the_start_when_its_momenta_do_not_count(make, drifting):
    scene = make(control={"restart": "noscale"}, velocities=drifting).scene()
    np.testing.assert_allclose(scene.beads.velocities, np.array(drifting) - [0.5, 0, 0.0], atol=1e-15)
    np.testing.assert_allclose(scene.beads.mass @ scene.beads.velocities, 0.0, atol=1e-14)
    note = "fixed_com: the centre of mass drifts with 0.5 0 0 ang/ps, which is taken out at the start"
    assert any(text.startswith(note[:40]) for text in texts(scene, "choice"))


def test_velocities_of_frozen_beads_are_set_to_zero(make, drifting):
    control = {"restart": "noscale", "fixed_com": "off"}
    scene = make(atoms=FROZEN, control=control, velocities=drifting).scene()
    assert scene.beads.velocities[:4].tolist() == drifting[:4]
    assert not scene.beads.velocities[4:].any()
    assert "the velocities that the file gives to frozen beads are set to 0" in texts(scene, "choice")


@pytest.mark.parametrize("ensemble", ["nvt evans", "nvt andersen 1.0 0.5", "npt hoover 1.0 1.0"])
def test_old_style_files_are_told_what_is_available_in_their_own_words(make, ensemble):
    case = make()
    control = parse_control(f"old\ntemperature 1.0\ntimestep 0.01\nsteps 10\ncutoff 1.0\nensemble {ensemble}\nfinish\n")
    available = (
        "ensemble nve, ensemble nvt langevin, berendsen, hoover, mdvv and the other orders of DPD, and ensemble npt "
        "and nst langevin"
    )
    with pytest.raises(SceneError, match=rf"^CONTROL:6: .*; available are {available}$"):
        resolve(control, parse_field(case.field_text()), parse_config(case.config_text()))


@pytest.mark.parametrize(
    ("ensemble", "integrator"),
    [("nvt dpds1 4.5", "first"), ("nvt dpd s2", "second"), ("nvt dpds0", "zeroth"), ("nvt lowe", "lowe-andersen"),
     ("nvt ou-middle", "ou-middle"), ("nvt dpdvv", "dpdvv")],
)  # fmt: skip
def test_old_style_orders(make, ensemble, integrator):
    case = make()
    control = parse_control(f"old\ntemperature 1.0\ntimestep 0.01\nsteps 10\ncutoff 1.0\nensemble {ensemble}\nfinish\n")
    scene = resolve(control, parse_field(case.field_text()), parse_config(case.config_text()))
    assert scene.dynamics.integrator == integrator


@pytest.mark.parametrize(
    ("ensemble", "motion", "tension"),
    [("npt lang 1 2", "isotropic", 0.0), ("nst lang 1 2", "edges", 0.0), ("nst lang 1 2 area", "height", 0.0),
     ("nst lang 1 2 tens 10", "edges", 10.0), ("nst lang 1 2 tens 10 semi", "square", 10.0),
     ("nst lang 1 2 orth", "edges", 0.0), ("nst lang 1 2 orth semi", "square", 0.0)],
)  # fmt: skip
def test_old_style_barostats(make, ensemble, motion, tension):
    case = make()
    head = "old\ntemperature 1.0\ntimestep 0.01\nsteps 10\ncutoff 1.0\npressure 0.5\n"
    control = parse_control(f"{head}ensemble {ensemble}\nfinish\n")
    scene = resolve(control, parse_field(case.field_text()), parse_config(case.config_text()))
    barostat = scene.dynamics.barostat
    assert (scene.dynamics.integrator, scene.dynamics.thermostat_friction) == ("langevin", 1.0)
    assert (barostat.motion, barostat.friction) == (motion, 2.0)
    assert barostat.relaxation == pytest.approx(1 / (4 * np.pi))
    assert barostat.pressure == pytest.approx([0.5 / KATM_PER_INTERNAL_PRESSURE] * 3)
    assert barostat.tension == pytest.approx(tension / TENSION_IN_DYN_PER_CM, rel=5e-4)
    assert scene.imcon == (1 if motion == "isotropic" else 2)


def test_old_style_drag_fills_pairs(make):
    case = make(vdw=("A A dpd 25.0 1.0 4.5", "A B dpd 25.0 1.0"))
    control = parse_control(
        "old\ntemperature 1.0\ntimestep 0.01\nsteps 10\ncutoff 1.0\nensemble nvt mdvv 2.0\nfinish\n"
    )
    scene = resolve(control, parse_field(case.field_text()), parse_config(case.config_text()))
    assert [(term.drag, term.drag_origin) for term in scene.pairs] == [
        (4.5, "given"),
        (2.0, "filled"),
        (2.0, "filled"),
    ]
    assert any("DL_POLY up to 5.2 lets it replace FIELD's drags" in text for text in texts(scene, "choice"))
    assert any(text.startswith("units dpd, but the temperature is in K: 1 K is") for text in texts(scene, "warning"))


def test_arrays_of_a_scene_cannot_be_changed(make, drifting):
    beads = make(control={"restart": "noscale"}, velocities=drifting).scene().beads
    for array in (beads.species, beads.mass, beads.charge, beads.frozen, beads.molecule, beads.positions):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        beads.velocities[0, 0] = 0.0


def test_seed(make):
    assert make(control={"random_seed": None}).scene().run.seed is None
    assert make(control={"random_seed": "18446744073709551615"}).scene().run.seed == 2**64 - 1
    assert make(control={"random_seed": "[ 1 2 3 ]"}).scene().run.seed == combine_seed((1, 2, 3))


def test_combined_seeds_are_64_bits_and_differ():
    seeds = [combine_seed((a, b, c)) for a in range(6) for b in range(6) for c in range(6)]
    assert len(set(seeds)) == 216
    assert all(0 <= seed < 2**64 for seed in seeds)
    bits = [sum(seed >> k & 1 for seed in seeds) for k in range(64)]
    assert min(bits) > 70  # each bit is set in about half of them
    assert max(bits) < 146
    # Two steps of SplitMix64 by hand: the finalizer of its first output for state 0 is a published number.
    assert combine_seed((0,)) == 0xE220A8397B1DCDAF


def test_missing_seed_is_noted_only_where_it_is_needed(make, drifting):
    note = "no random_seed: a seed is drawn anew for each run and printed"
    assert note in texts(make(control={"random_seed": None}).scene(), "choice")
    control = {**NVE, "random_seed": None, "restart": "noscale"}
    assert note not in texts(make(control=control, velocities=drifting).scene(), "choice")


def test_run_plan(make):
    control = {
        "time_run": "5.0 ps",
        "time_equilibration": "20 steps",
        "record_equilibration": "on",
        "rescale_frequency": "5 steps",
        "regauss_frequency": "-1 steps",
        "equilibration_force_cap": "100.0 k_b.temp/ang",
        "temperature": "2.0 dpd_temp",
        "threads": "2",
    }
    run = make(control=control).scene().run
    assert (run.steps, run.equilibration_steps, run.record_equilibration) == (500, 20, True)
    assert (run.rescale_every, run.regauss_every, run.threads) == (5, 0, 2)
    assert run.force_cap == pytest.approx(200.0)


def test_equilibration_measures_without_equilibration_are_noted(make):
    control = {"rescale_frequency": "5 steps", "regauss_frequency": "7 steps", "equilibration_force_cap": "1.0 dpd_f"}
    scene = make(control=control).scene()
    for keyword in control:
        assert f"{keyword} never acts: there is no equilibration (time_equilibration)" in texts(scene, "ignored")


def test_equilibration_longer_than_the_run_is_noted(make):
    scene = make(control={"time_equilibration": "200 steps"}).scene()
    assert "equilibration (200 steps) is longer than the run (100 steps)" in texts(scene, "warning")


def test_output_by_default(make):
    plan = make().scene().output
    assert (plan.print_every, plan.statistics_every, plan.trajectory_every, plan.rdf_every) == (0, 0, 0, 0)
    assert (plan.stack_size, plan.checkpoint_every, plan.rdf_pairs) == (100, 1000, ())
    assert (plan.output_file, plan.configuration_file, plan.checkpoint_file) == ("OUTPUT", "REVCON", "REVIVE")


def test_output_as_asked_for(make):
    control = {
        "print_frequency": "10 steps",
        "stats_frequency": "0.05 ps",
        "stack_size": "50 steps",
        "io_statis_yaml": "on",
        "traj_calculate": "on",
        "traj_key": "pos-vel",
        "traj_start": "30 steps",
        "traj_interval": "20 steps",
        "rdf_calculate": "on",
        "rdf_frequency": "4 steps",
        "rdf_binsize": "0.02 ang",
        "io_file_output": "screen",
        "io_file_revive": "none",
        "io_file_rdf": "g.dat",
    }
    scene = make(control=control).scene()
    plan = scene.output
    assert (plan.print_every, plan.statistics_every, plan.stack_size, plan.statistics_yaml) == (10, 5, 100, True)
    assert (plan.trajectory_start, plan.trajectory_every, plan.trajectory_level) == (30, 20, 1)
    assert (plan.rdf_every, plan.rdf_bin_width, plan.rdf_pairs) == (4, 0.02, ((0, 0), (0, 1), (1, 1)))
    assert (plan.output_file, plan.checkpoint_file, plan.rdf_file) == ("SCREEN", None, "g.dat")
    assert any("rolling averages are taken over 100 steps" in text for text in texts(scene, "choice"))


def test_rdf_pairs_of_the_field_file(make):
    scene = make(control={"rdf_calculate": "on"}, after="rdf 1\nB A").scene()
    assert scene.output.rdf_pairs == ((0, 1),)


def test_rdf_bins_that_make_no_sense_are_reset(make):
    scene = make(control={"rdf_calculate": "on", "rdf_binsize": "0.5 ang"}).scene()
    assert scene.output.rdf_bin_width == 0.05
    assert any("rdf_binsize 0.5 lies outside" in text for text in texts(scene, "warning"))


def test_files_that_are_not_wanted(make):
    control = {
        "stats_frequency": "5 steps",
        "io_file_statis": "NONE",
        "traj_calculate": "on",
        "io_file_history": "NONE",
        "rdf_calculate": "on",
        "rdf_print": "off",
    }
    plan = make(control=control).scene().output
    assert (plan.statistics_every, plan.trajectory_every, plan.rdf_file) == (0, 0, None)


def test_external_fields(make):
    scene = make(units="kJ", after=GRAVITY).scene()
    assert [(term.key, term.parameters) for term in scene.external] == [("grav", (0.0, 0.0, -50.0))]
    scene = make(units="kJ", after="extern\noshr 0.8 2").scene()
    assert [(term.key, term.parameters) for term in scene.external] == [("oshr", (80.0, 2.0))]
    assert scene.external[0].explanation == "FIELD:19"


def test_oscillating_shear_with_a_broken_wave_is_noted(make):
    scene = make(after="extern\noshr 0.8 1.5").scene()
    assert any("unless n is a whole number" in text for text in texts(scene, "warning"))


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, True),
        ({"imcon": 0}, False),
        ({"imcon": 6}, False),
        ({"control": {"vdw_force_shift": "on"}}, False),
        ({"control": {"vdw_long_range_correction": "off"}}, False),
    ],
)
def test_long_range_correction(make, changes, expected):
    vdw = ("A A lj 1.0 0.3", "A B lj 1.0 0.3", "B B lj 1.0 0.3")
    changes = {**changes, "control": {**NVE, **changes.get("control", {})}}
    scene = make(vdw=vdw, **changes).scene()
    assert scene.long_range_correction is expected
    assert any("long" in text for text in texts(scene, "choice")) is not expected
