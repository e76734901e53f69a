"""Beads that carry heat in the scene: numbers in internal units, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import Scene
from pydlpoly.errors import InputError
from pydlpoly.scene.serialise import scene_from_arrays, scene_to_arrays
from pydlpoly.units import BOLTZMANN

from ..heat_scenes import fluid, heat
from ..scene_builder import NVE, make_scene


def test_numbers_are_in_internal_units() -> None:
    block = heat("capacity A 50 temperature 310", "source species A 2.0", "pair A A kappa 0.1 range 1.0")
    control = {**NVE, "temperature": "300 K", "timestep": "0.01 ps"}
    scene = make_scene({"A": 10}, ("A A dpd 25.0 1.0",), cell=5.0, units="internal", control=control, extensions=block)
    assert scene.heat is not None
    assert scene.beads.temperature is not None
    np.testing.assert_allclose(scene.beads.temperature, 310 * BOLTZMANN)
    assert scene.heat.reference == pytest.approx(300 * BOLTZMANN)
    assert scene.heat.sources[0].rate == pytest.approx(2 * BOLTZMANN)
    assert scene.heat.terms[0].conductivity == 0.1
    text = scene.explain()
    assert "A: heat capacity 50 k_B, starts at 310 K" in text
    assert "all beads A, 2 K/ps, from FIELD:" in text


def test_beads_start_at_the_temperature_of_control_and_walls_at_theirs() -> None:
    block = heat("capacity A 5", "capacity W 7", "wall W 1.5")
    laws = ("A A dpd 25.0 1.0 4.5", "A W dpd 25.0 1.0 4.5", "W W dpd 25.0 1.0 4.5")
    scene = make_scene({"A": 2, "W": 1}, laws, cell=5.0, extensions=block)
    assert scene.beads.temperature is not None
    assert scene.beads.heat_capacity is not None
    assert scene.beads.temperature.tolist() == pytest.approx([BOLTZMANN * (1 / BOLTZMANN)] * 2 + [1.5])
    assert scene.beads.heat_capacity.tolist() == [5, 5, 7]
    assert scene.heat is not None
    assert scene.heat.held == (1,)
    assert any("no heat flows between A A, A W, W W" in note.text for note in scene.notes)


def test_a_scene_with_heat_survives_being_stored() -> None:
    scene = fluid(heat("capacity A 5", "pair A A kappa 1 range 1 power 1 2 3 4", "source layer x 0 1 2"))
    again = scene_from_arrays(*scene_to_arrays(scene))
    assert again.heat == scene.heat


def refused(*block: str, **changes: object) -> str:
    with pytest.raises(InputError) as refusal:
        fluid(heat(*block), **changes)  # type: ignore[arg-type]
    assert refusal.value.path.endswith(("FIELD", "CONTROL"))
    return str(refusal.value)


CAPACITY = "capacity A 50"


@pytest.mark.parametrize(
    ("block", "message"),
    [
        ((), "species A has no heat capacity; give it a line 'capacity A C_V'"),
        (("capacity A 0",), "a heat capacity must be above 0, not 0"),
        (("capacity A 1 temperature 0",), "an internal temperature must be above 0, not 0"),
        ((CAPACITY, "wall A -1"), "an internal temperature must be above 0, not -1"),
        ((CAPACITY, "pair A A kappa -1 range 1"), "kappa must not be negative"),
        ((CAPACITY, "pair A A kappa 1"), "the range of a conduction must be given and above 0"),
        ((CAPACITY, "pair A A kappa 1 range 1 exponent 0"), "the exponent must be above 0"),
        ((CAPACITY, "source sphere 0 0 0 0 1"), "the radius of a sphere must be above 0"),
        ((CAPACITY, "source layer x 1 1 1"), "the bounds of a region must ascend"),
        ((CAPACITY, "viscous_heating lammps"), "goes with the integrator mdvv only, not with ou"),
    ],
)
def test_numbers_without_meaning_are_refused(block: tuple[str, ...], message: str) -> None:
    text = refused(*block)
    assert message in text
    assert "FIELD:" in text


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"order": "middle"}, "middle is not modelled with beads that carry heat; these are: nve, mdvv"),
        ({"order": "scvv"}, "scvv is not modelled"),
        ({"order": "nose-hoover-langevin"}, "nose-hoover-langevin is not modelled"),
        ({"order": "mdvv", "control": {"ensemble_dpd_lambda": "0.65"}}, "lambda 0.5 only"),
        ({"order": "mdvv", "control": {"ensemble_dpd_kinetic": "half"}}, "their balance is that of the whole step"),
        ({"control": {"temperature": "0.0 dpd_temp"}}, "need a temperature above 0"),
        ({"control": {"shear_rate": "0.1 internal_t^-1"}}, "a sheared cell is not modelled"),
        ({"control": {"temperature_amplitude": "0.1 dpd_temp", "temperature_period": "5 internal_t"}},
         "a temperature that varies is not modelled"),
        ({"control": {"rescale_frequency": "5 steps", "time_equilibration": "50 steps"}}, "rescaling of velocities"),
        ({"control": {"regauss_frequency": "5 steps", "time_equilibration": "50 steps"}}, "redrawing of velocities"),
        ({"control": {"equilibration_force_cap": "50 internal_f", "time_equilibration": "50 steps"}}, "cap on forces"),
        ({"control": {"ensemble": "npt", "pressure_hydrostatic": "20 dpd_p",
                      "ensemble_barostat_coupling": "1 internal_t", "ensemble_barostat_friction": "1 internal_t^-1"}},
         "a cell that follows the pressure is not modelled"),
    ],
)  # fmt: skip
def test_what_was_not_checked_together_is_refused(changes: dict[str, object], message: str) -> None:
    assert message in refused(CAPACITY, **changes)


@pytest.mark.parametrize("order", ["peters-first", "lowe-andersen"])
def test_a_drag_that_may_pass_the_limit_of_its_integrator_is_refused(order: str) -> None:
    message = refused(CAPACITY, "pair A A drag 0 1 0 0", order=order)
    assert f"a drag that depends on temperature is not modelled with {order}" in message
    assert "FIELD:" in message


def test_a_scaled_repulsion_is_for_soft_beads() -> None:
    message = refused(CAPACITY, "repulsion scaled", laws=("A A lj 1.0 0.4 4.5",))
    assert "repulsion scaled is for the law dpd; the pair A A has lj" in message


def test_scenes_without_heat_have_none() -> None:
    scene: Scene = make_scene({"A": 4}, cell=5.0)
    assert scene.heat is None
    assert "carry heat" not in scene.explain()
