"""What beads carry: BEADS files onto scenes, arrays between runs, REVBEADS, checkpoints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pydlpoly
from pydlpoly import Scene, Simulation
from pydlpoly.conversion import convert_folder
from pydlpoly.errors import InputError, SceneError
from pydlpoly.formats.beads_file import parse_beads, read_beads, write_beads
from pydlpoly.formats.config import read_config
from pydlpoly.formats.extensions import EXTENSIONS
from pydlpoly.formats.records import BeadTable
from pydlpoly.runner import run_scene
from pydlpoly.scene import beads_state, resolve
from pydlpoly.scene.beads_state import carried_names, start_arrays, with_bead_table
from pydlpoly.scene.serialise import scene_from_arrays, scene_to_arrays

from .carrying import carrying
from .run_folders import listing, run_folder
from .scene_builder import make_scene


def fluid(count: int = 60, **more: object) -> Scene:
    return make_scene({"A": count}, cell=3.0, **more)  # type: ignore[arg-type]


def table_of(scene: Scene, *names: str, seed: int = 11) -> BeadTable:
    values = np.random.default_rng(seed).random((scene.bead_count, len(names))) + 0.1
    return BeadTable(names, values)


# -- From a table to a scene -------------------------------------------------------------------------------------------


def test_columns_that_are_given_replace_the_start_values() -> None:
    scene = carrying(fluid())
    table = table_of(scene, "concentration_2", "temperature")
    found = with_bead_table(scene, table)
    np.testing.assert_array_equal(found.beads.concentrations[:, 1], table.values[:, 0])
    np.testing.assert_array_equal(found.beads.concentrations[:, 0], scene.beads.concentrations[:, 0])
    np.testing.assert_array_equal(found.beads.temperature, table.values[:, 1])
    assert not found.beads.temperature.flags.writeable
    assert not found.beads.concentrations.flags.writeable
    note = found.notes[-1]
    assert (note.kind, note.where) == ("choice", "BEADS")
    assert note.text == (
        "concentration_2, temperature of the beads: from BEADS; concentration_1: it has no such column, the values of "
        "FIELD's extension are kept"
    )


def test_species_have_the_names_of_the_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beads_state, "_names_of_species", lambda _: ("salt", "sugar"))
    scene = carrying(fluid())
    assert carried_names(scene) == ("temperature", "concentration_salt", "concentration_sugar")
    found = with_bead_table(scene, table_of(scene, "concentration_sugar"))
    np.testing.assert_array_equal(start_arrays(found)["concentration_sugar"], found.beads.concentrations[:, 1])


def test_temperatures_are_in_kelvin_where_reports_are() -> None:
    scene = fluid(units="kj", control={"temperature": "300 K", "timestep": "0.001 ps"})
    table = replace(table_of(scene, "temperature"), values=np.full((60, 1), 298.15))
    found = with_bead_table(carrying(scene, species=0), table)
    np.testing.assert_allclose(found.beads.temperature, 298.15 * 0.831451115, rtol=1e-15)
    np.testing.assert_allclose(Simulation(found, seed=1).bead_arrays()["temperature"], 298.15, rtol=1e-15)


def test_without_anything_carried_the_table_is_noted() -> None:
    scene = fluid()
    found = with_bead_table(scene, table_of(scene, "temperature"))
    assert found.beads is scene.beads
    assert found.notes[-1].kind == "ignored"
    assert "carry neither internal temperatures nor dissolved species" in found.notes[-1].text
    assert carried_names(scene) == ()
    assert Simulation(scene, seed=1).bead_arrays() == {}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t\n2 temprature\n1 1\n2 1\n", "BEADS:2: 'temprature': beads do not carry this; expected temperature, "
         "concentration_1, concentration_2; did you mean temperature?"),
        ("t\n2 concentration_3\n1 1\n2 1\n", "BEADS:2: 'concentration_3': beads do not carry this"),
        ("t\n2 temperature\n2 0\n1 1\n", "BEADS:3: '0': temperature of bead 2: expected a finite temperature above 0"),
        ("t\n2 concentration_1\n1 0\n2 -1e-9\n", "BEADS:4: '-1e-09': concentration_1 of bead 2: expected a finite "
         "concentration, not below 0"),
        ("t\n3 temperature\n1 1\n2 1\n3 1\n", "BEADS:2: holds 3 beads, but the scene has 2"),
    ],
)  # fmt: skip
def test_tables_that_do_not_fit(text: str, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        with_bead_table(carrying(fluid(2)), parse_beads(text))
    assert str(caught.value).startswith(message)


# -- From files --------------------------------------------------------------------------------------------------------


@pytest.fixture
def hot(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Scene]:
    """Load a folder as if an extension "carried" gave every bead k_B T = 2 and one dissolved species of 0.25."""
    known = resolve.__globals__
    make_beads = known["_beads"]

    def beads(layout, positions, velocities):
        made = make_beads(layout, positions, velocities)
        count = len(made)
        carried = {"temperature": np.full(count, 2.0), "heat_capacity": np.full(count, 9.0)}
        return replace(made, **carried, concentrations=np.full((count, 1), 0.25))

    monkeypatch.setitem(EXTENSIONS, "carried", "for a test")
    monkeypatch.setitem(pydlpoly.load.__globals__, "STATE_EXTENSIONS", ("carried",))
    monkeypatch.setitem(known, "_beads", beads)
    return pydlpoly.load


def with_extension(folder: Path, settings: dict[str, str | None] | None = None) -> Path:
    """The usual folder of a run, whose FIELD has an extension of a state."""
    run_folder(folder, settings)
    field = folder / "FIELD"
    field.write_text(field.read_text() + "extension carried\nend extension\n")
    return folder


def test_beads_beside_config_are_read(tmp_path: Path, hot: Callable[..., Scene]) -> None:
    folder = with_extension(tmp_path / "in")
    assert set(hot(folder).beads.temperature.tolist()) == {2.0}
    values = np.random.default_rng(1).random(160) + 1.0
    write_beads(folder / "BEADS", "t", ["temperature"], [values])
    scene = hot(folder)
    np.testing.assert_array_equal(scene.beads.temperature, values)
    np.testing.assert_array_equal(scene.beads.concentrations, 0.25)
    assert str(folder / "BEADS") in scene.sources
    (folder / "BEADS").rename(folder / "warm")
    control = folder / "CONTROL"
    control.write_text(control.read_text() + "io_file_beads warm\n")
    np.testing.assert_array_equal(hot(folder).beads.temperature, values)
    (folder / "warm").unlink()
    with pytest.raises(InputError, match=r"warm: there is no such file; expected what beads carry here \(io_file_bead"):
        hot(folder)


def test_a_configuration_from_elsewhere_has_no_file_beside_it(tmp_path: Path, hot: Callable[..., Scene]) -> None:
    folder = with_extension(tmp_path / "in")
    write_beads(folder / "BEADS", "t", ["temperature"], [np.full(160, 3.0)])
    config = read_config(folder / "CONFIG")
    assert set(hot(folder, config=config).beads.temperature.tolist()) == {2.0}
    table = read_beads(folder / "BEADS")
    assert set(hot(folder, config=config, beads=table).beads.temperature.tolist()) == {3.0}


def test_a_file_that_nothing_uses_is_noted_and_not_read(tmp_path: Path) -> None:
    folder = run_folder(tmp_path / "in")
    (folder / "BEADS").write_text("not a table")
    scene = pydlpoly.load(folder)
    found = [note for note in scene.notes if "BEADS" in note.text]
    assert [note.kind for note in found] == ["ignored"]
    assert "FIELD has no extension by which beads carry" in found[0].text


def test_nfold_repeats_the_table_as_it_does_the_beads(tmp_path: Path, hot: Callable[..., Scene]) -> None:
    """Each copy of a bead has its temperature: it is found again by the place in the small cell."""
    folder = with_extension(tmp_path / "in")
    write_beads(folder / "BEADS", "t", ["temperature"], [1.0 + np.arange(160.0)])
    single = hot(folder)
    control = folder / "CONTROL"
    control.write_text(control.read_text() + "nfold [ 3 1 3 ]\n")  # odd, so that images lie on the old cells
    scene = hot(folder)
    assert scene.bead_count == 1440
    apart = scene.beads.positions[:, None] - single.beads.positions
    apart -= np.rint(apart @ np.linalg.inv(single.cell)) @ single.cell
    distances = np.linalg.norm(apart, axis=2)
    assert distances.min(axis=1).max() < 1e-9
    partners = distances.argmin(axis=1)
    np.testing.assert_array_equal(scene.beads.temperature, single.beads.temperature[partners])
    write_beads(folder / "BEADS", "t", ["temperature"], [np.ones(1440)])
    with pytest.raises(SceneError, match=r"holds 1440 beads, but .* has 160 before they are repeated"):
        hot(folder)


def test_converted_folders_keep_the_table(tmp_path: Path, hot: Callable[..., Scene]) -> None:
    folder = with_extension(tmp_path / "in", {"io_file_beads": "warm"})
    write_beads(folder / "warm", "t", ["temperature"], [1.0 + np.arange(160.0)])
    convert_folder(folder, tmp_path / "new")
    np.testing.assert_array_equal(hot(tmp_path / "new").beads.temperature, hot(folder).beads.temperature)


def test_a_restart_from_revcon_and_revbeads_loses_nothing_of_what_is_carried(
    tmp_path: Path, hot: Callable[..., Scene]
) -> None:
    folder = with_extension(tmp_path / "in")
    random = np.random.default_rng(3)
    columns = [random.random(160) + 0.5, random.random(160)]
    write_beads(folder / "BEADS", "t", ["temperature", "concentration_1"], columns)
    result = run_scene(hot(folder), tmp_path / "out", steps=20, threads=1)
    out = tmp_path / "out"
    assert "REVBEADS" in listing(out)
    (out / "REVCON").rename(folder / "CONFIG")
    (out / "REVBEADS").rename(folder / "BEADS")
    again = Simulation(hot(folder), seed=1, threads=1)
    for name, values in result.simulation.bead_arrays().items():
        assert values.tobytes() == again.bead_arrays()[name].tobytes()


# -- Files of a run ----------------------------------------------------------------------------------------------------


def test_revbeads_is_written_with_revcon(tmp_path: Path) -> None:
    scene = carrying(pydlpoly.load(run_folder(tmp_path / "in")))
    result = run_scene(scene, tmp_path / "out", threads=1)
    table = read_beads(tmp_path / "out" / "REVBEADS")
    assert table.names == ("temperature", "concentration_1", "concentration_2")
    assert table.title == "test run"
    arrays = result.simulation.bead_arrays()
    for name, column in zip(table.names, table.values.T, strict=True):
        np.testing.assert_array_equal(column, arrays[name])
    assert "REVCON and REVBEADS and REVIVE" in scene.explain()


def test_revbeads_can_be_named_or_left_out(tmp_path: Path) -> None:
    for name, files in (("last_beads", {"last_beads"}), ("NONE", set())):
        scene = carrying(pydlpoly.load(run_folder(tmp_path / "in", {"io_file_revbeads": name})))
        run_scene(scene, tmp_path / name, steps=2, threads=1)
        usual = {"OUTPUT", "STATIS", "HISTORY", "RDFDAT", "REVCON", "REVIVE"}
        assert set(listing(tmp_path / name)) - usual == files
    clash = carrying(pydlpoly.load(run_folder(tmp_path / "in", {"io_file_revbeads": "REVCON"})))
    with pytest.raises(InputError, match="two output files of this run have this name"):
        run_scene(clash, tmp_path / "clash", steps=2)
    assert not (tmp_path / "clash").exists()


def test_a_plain_scene_has_no_revbeads(tmp_path: Path) -> None:
    run_scene(pydlpoly.load(run_folder(tmp_path / "in")), tmp_path / "out", steps=2, threads=1)
    assert "REVBEADS" not in listing(tmp_path / "out")


# -- Arrays and checkpoints ------------------------------------------------------------------------------------------


def test_arrays_are_copies_and_can_be_set() -> None:
    simulation = Simulation(carrying(fluid()), seed=1, threads=1)
    simulation.run(2)
    arrays = simulation.bead_arrays()
    assert list(arrays) == ["temperature", "concentration_1", "concentration_2"]
    arrays["temperature"][:] = -1.0
    state = simulation.state
    assert (state.temperature > 0.0).all()
    np.testing.assert_array_equal(state.concentrations[:, 1], arrays["concentration_2"])
    assert state.density is None
    temperature, concentrations = state.temperature * 2.0, state.concentrations + 1.0
    before = simulation.state
    simulation.set_state(temperature=temperature, concentrations=concentrations)
    after = simulation.state
    np.testing.assert_array_equal(after.temperature, temperature)
    np.testing.assert_array_equal(after.concentrations, concentrations)
    np.testing.assert_array_equal(after.positions, before.positions)
    np.testing.assert_array_equal(after.velocities, before.velocities)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"temperature": np.ones(59)}, r"temperature must be of shape \(60,\), not \(59,\)"),
        ({"temperature": np.zeros(60)}, "temperature of bead 1 is 0; expected a finite temperature above 0"),
        ({"concentrations": np.ones((60, 1))}, r"concentrations must be of shape \(60, 2\), not \(60, 1\)"),
        ({"concentrations": np.full((60, 2), np.nan)}, "concentrations of bead 1 is nan; expected a finite conc"),
        ({"concentrations": -np.ones((60, 2))}, "concentrations of bead 1 is -1; expected a finite concentration, not"),
    ],
)
def test_arrays_that_cannot_be_set(given: dict[str, np.ndarray], message: str) -> None:
    simulation = Simulation(carrying(fluid()), seed=1, threads=1)
    before = simulation.state
    with pytest.raises(ValueError, match=message):
        simulation.set_state(positions=np.zeros((60, 3)), **given)
    np.testing.assert_array_equal(simulation.positions, before.positions)
    np.testing.assert_array_equal(simulation.state.temperature, before.temperature)


def test_what_beads_do_not_carry_cannot_be_set() -> None:
    simulation = Simulation(carrying(fluid(), species=0), seed=1, threads=1)
    with pytest.raises(ValueError, match="beads of this scene carry no concentrations"):
        simulation.set_state(concentrations=np.ones((60, 1)))
    with pytest.raises(ValueError, match="beads of this scene carry no temperature"):
        Simulation(fluid(), seed=1, threads=1).set_state(temperature=np.ones(60))


def test_a_checkpoint_keeps_every_bit(tmp_path: Path) -> None:
    scene = carrying(fluid())
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(3)
    simulation.set_state(temperature=simulation.state.temperature / 3.0)
    simulation.save(tmp_path / "REVIVE")
    again = Simulation.resume(tmp_path / "REVIVE", threads=1)
    for one in (simulation, again):
        one.run(5)
    for name, values in simulation.bead_arrays().items():
        assert values.tobytes() == again.bead_arrays()[name].tobytes()
    assert simulation.positions.tobytes() == again.positions.tobytes()


@pytest.mark.parametrize(
    ("was", "now", "message"),
    [
        ({"species": 0}, None, r"holds (internal temperatures, and|other heat capacities than) the"),
        (None, {"species": 0}, r"holds (no internal temperatures, and|other heat capacities than) the"),
    ],
)
def test_what_beads_carry_is_not_lost_on_the_way(
    tmp_path: Path, was: dict[str, object] | None, now: dict[str, object] | None, message: str
) -> None:
    first, second = (fluid() if more is None else carrying(fluid(), **more) for more in (was, now))  # type: ignore[arg-type]
    Simulation(first, seed=1, threads=1).save(tmp_path / "REVIVE")
    with pytest.raises(InputError, match=message):
        Simulation.resume(tmp_path / "REVIVE", scene=second)


def test_plans_of_averages_go_through_a_checkpoint() -> None:
    scene = carrying(fluid(control={"profile_frequency": "5 steps", "map_frequency": "7 steps", "map_plane": "xz"}))
    again = scene_from_arrays(*scene_to_arrays(scene))
    assert again.output == scene.output
    assert again.output.bead_map.axes == ("x", "z")
