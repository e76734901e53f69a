"""ZDNDAT, VAFDAT and MSDTMP: layouts against lines made by hand, contents against frames, and exact continuation."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pydlpoly
from pydlpoly.formats.history import read_history
from pydlpoly.formats.msdtmp import DisplacementWriter, read_displacements
from pydlpoly.formats.vafdat import CorrelationWriter, VelocityCorrelation, read_correlations, write_correlation
from pydlpoly.formats.zdndat import read_density, write_density
from pydlpoly.runner import run_scene

from .run_folders import COUNTS, EDGE, run_folder

SAMPLING: dict[str, str | None] = {
    "zden_calculate": "on",
    "zden_frequency": "3 steps",
    "vaf_calculate": "on",
    "vaf_frequency": "4 steps",
    "vaf_binsize": "6",
    "msd_calculate": "on",
    "msd_start": "5 steps",
    "msd_frequency": "7 steps",
    "traj_key": "pos-vel",
    "traj_interval": "1 steps",
    "time_equilibration": "8 steps",
}
FILES = ("ZDNDAT", "VAFDAT_A", "VAFDAT_B", "MSDTMP")
KINDS = np.repeat([0, 1], list(COUNTS.values()))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = run_folder(tmp_path_factory.mktemp("sampled"), SAMPLING)
    run_scene(pydlpoly.load(path), path, threads=1)
    return path


def test_layout_of_zdndat(tmp_path: Path) -> None:
    write_density(tmp_path / "ZDNDAT", "title", ["W", "OIL"], [-0.5, 0.5], [[1.0, 2.5], [0.0, 1e-120]])
    assert (tmp_path / "ZDNDAT").read_text() == (
        "title\n"
        "         2         2\n"
        "W       \n"
        " -5.000000E-01  1.000000E+00\n"
        "  5.000000E-01  2.500000E+00\n"
        "OIL     \n"
        " -5.000000E-01  0.000000E+00\n"
        "  5.000000E-01  1.000000-120\n"
    )
    table = read_density(tmp_path / "ZDNDAT")
    assert (table.title, table.species) == ("title", ("W", "OIL"))
    assert table["W"].tolist() == [1.0, 2.5]


LINES = (
    "W                1  3.00000000E+00            0.250000\n"
    "  0.000000E+00  1.000000E+00\n"
    "  1.000000E-02 -5.000000E-01\n"
)


def test_layout_of_vafdat(tmp_path: Path) -> None:
    one = VelocityCorrelation("W", 3.0, 0.25, np.array([0.0, 0.01]), np.array([1.0, -0.5]))
    write_correlation(tmp_path / "VAFDAT_W", "title", one)
    assert (tmp_path / "VAFDAT_W").read_text() == "title\n" + LINES
    writer = CorrelationWriter(tmp_path / "sets", "title", 2)
    for _ in range(3):
        writer.write(one)
    writer.close()
    CorrelationWriter(tmp_path / "sets", "title", 2, keep=2).close()
    assert (tmp_path / "sets").read_text() == "title\n" + 2 * (LINES + "\n\n\n")
    found = read_correlations(tmp_path / "sets")
    assert [(s.species, s.at_origin, s.origin, s.values.tolist()) for s in found] == 2 * [("W", 3.0, 0.25, [1.0, -0.5])]
    with pytest.raises(pydlpoly.InputError, match="fewer data sets"):
        CorrelationWriter(tmp_path / "sets", "title", 2, keep=3)


def test_layout_of_msdtmp(tmp_path: Path) -> None:
    writer = DisplacementWriter(tmp_path / "MSDTMP", "title", ["W", "OIL"])
    writer.write(7, 0.07, 0.01, [0.5, 1.25], [1.0, 300.0])
    writer.close()
    lines = [
        "title",
        "         2                    1                    5",
        "timestep         7         2    0.010000    0.070000",
        "W                1   5.0000E-01   1.0000E+00",
        "OIL              2   1.2500E+00   3.0000E+02",
    ]
    assert (tmp_path / "MSDTMP").read_text() == "".join(f"{line:<52}\n" for line in lines)
    (frame,) = read_displacements(tmp_path / "MSDTMP")
    assert (frame.step, frame.time, frame.timestep, frame.names) == (7, 0.07, 0.01, ("W", "OIL"))
    assert frame.displacements.tolist() == [0.5, 1.25]
    assert frame.temperatures.tolist() == [1.0, 300.0]


@pytest.mark.parametrize("reader", [read_density, read_correlations, lambda path: list(read_displacements(path))])
def test_other_files_are_refused(tmp_path: Path, reader) -> None:
    (tmp_path / "file").write_text("title\nsomething else\nand more\n")
    with pytest.raises(pydlpoly.InputError, match=r"is not a (ZDNDAT|VAFDAT|MSDTMP) file"):
        reader(tmp_path / "file")
    with pytest.raises(pydlpoly.InputError, match="cannot be read"):
        reader(tmp_path / "missing")


def test_density_is_that_of_the_frames(folder: Path) -> None:
    """Steps that are multiples of 3 after the 8 of equilibration; round(1/0.05) bins over the height."""
    table = read_density(folder / "ZDNDAT")
    frames = [f for f in read_history(folder / "HISTORY") if f.step > 8 and f.step % 3 == 0]
    edges = np.linspace(-EDGE / 2, EDGE / 2, 21)
    np.testing.assert_allclose(table.z, 0.5 * (edges[1:] + edges[:-1]), rtol=1e-6)
    for kind, name in enumerate("AB"):
        counted = sum(np.histogram(f.positions[kind == KINDS][:, 2], edges)[0] for f in frames)
        np.testing.assert_allclose(table[name], counted / len(frames) / (EDGE**3 / 20), rtol=2e-6)
        assert table[name].mean() * EDGE**3 == pytest.approx(COUNTS[name], rel=1e-6)


def test_density_in_a_cell_that_varies(tmp_path: Path) -> None:
    """Bins are fractions of the height; height and volume are means over the samples."""
    barostat = {
        "ensemble": "npt",
        "ensemble_method": "langevin",
        "ensemble_dpd_order": None,
        "ensemble_thermostat_friction": "1 dpd_t^-1",
        "ensemble_barostat_friction": "2 dpd_t^-1",
        "ensemble_barostat_coupling": "0.2 dpd_t",
        "pressure_hydrostatic": "60 dpd_p",
    }
    run_folder(tmp_path, {**SAMPLING, **barostat})
    run_scene(pydlpoly.load(tmp_path), tmp_path, threads=1)
    frames = [f for f in read_history(tmp_path / "HISTORY") if f.step > 8 and f.step % 3 == 0]
    heights = np.array([f.cell[2, 2] for f in frames])
    assert np.ptp(heights) > 0.01
    table = read_density(tmp_path / "ZDNDAT")
    np.testing.assert_allclose(table.z, ((np.arange(20) + 0.5) / 20 - 0.5) * heights.mean(), rtol=1e-6)
    edges = np.linspace(-0.5, 0.5, 21)
    for kind, name in enumerate("AB"):
        places = [f.positions[kind == KINDS][:, 2] / f.cell[2, 2] for f in frames]
        counted = sum(np.histogram(one, edges)[0] for one in places)
        np.testing.assert_allclose(table[name], counted / len(frames) / (np.mean(heights**3) / 20), rtol=2e-6)


def correlations_of(frames, origins: list[int], length: int, kind: int) -> np.ndarray:
    at = {f.step: f.velocities[kind == KINDS] for f in frames}
    return np.array([[np.sum(at[o] * at[o + k]) for k in range(length + 1)] for o in origins])


def test_velocity_correlation_is_that_of_the_frames(folder: Path) -> None:
    """Two samples overlap: one begins at 8, the other at 12, and each anew where it ends, 6 steps later."""
    frames = list(read_history(folder / "HISTORY"))
    origins = sorted([*range(8, 35, 6), *range(12, 35, 6)])
    for kind, name in enumerate("AB"):
        (found,) = read_correlations(folder / f"VAFDAT_{name}")
        total = correlations_of(frames, origins, 6, kind).sum(axis=0)
        np.testing.assert_allclose(found.values, total / total[0], rtol=1e-6)
        assert found.at_origin == pytest.approx(total[0] / len(origins) / COUNTS[name], rel=1e-7)
        assert found.origin == pytest.approx(0.01 * max(origins))
        np.testing.assert_allclose(found.times, 0.01 * np.arange(7), rtol=1e-6)


@pytest.mark.parametrize(("interval", "length"), [(10, 3), (5, 5), (4, 8)])
def test_each_sample_is_written_without_averaging(tmp_path: Path, interval: int, length: int) -> None:
    more = {"vaf_averaging": "off", "vaf_frequency": f"{interval} steps", "vaf_binsize": f"{length}"}
    run_folder(tmp_path, {**SAMPLING, **more})
    run_scene(pydlpoly.load(tmp_path), tmp_path, threads=1)
    frames = list(read_history(tmp_path / "HISTORY"))
    origins = list(range(8, 41 - length, interval))
    found = read_correlations(tmp_path / "VAFDAT_B")
    assert [s.origin for s in found] == pytest.approx([0.01 * o for o in origins])
    expected = correlations_of(frames, origins, length, 1)
    for one, values in zip(found, expected, strict=True):
        np.testing.assert_allclose(one.values, values / values[0], rtol=1e-6, atol=1e-7)
        assert one.at_origin == pytest.approx(values[0] / COUNTS["B"], rel=1e-7)


def test_displacements_are_those_of_the_frames(folder: Path) -> None:
    frames = {f.step: f for f in read_history(folder / "HISTORY")}
    found = list(read_displacements(folder / "MSDTMP"))
    assert [f.step for f in found] == [5, 12, 19, 26, 33, 40]
    for one in found:
        frame = frames[one.step]
        assert one.names == frame.names
        np.testing.assert_allclose(one.displacements, frame.displacements, rtol=1e-4, atol=1e-6)
        np.testing.assert_allclose(one.temperatures, np.sum(frame.velocities**2, axis=1) / 3.0, rtol=1e-4)


@pytest.mark.parametrize("averaging", ["on", "off"])
def test_a_run_that_continues_ends_with_the_same_files(tmp_path: Path, averaging: str) -> None:
    settings = {**SAMPLING, "vaf_averaging": averaging, "time_equilibration": "4 steps"}
    whole, parts = (run_folder(tmp_path / name, settings) for name in ("whole", "parts"))
    run_scene(pydlpoly.load(whole), whole, threads=1)
    scene = pydlpoly.load(parts)
    run_scene(scene, parts, steps=17, threads=1)
    saved = (parts / "REVIVE").read_bytes()
    run_scene(scene, parts, steps=33, threads=1, checkpoint=parts / "REVIVE")
    (parts / "REVIVE").write_bytes(saved)  # as if killed after step 17: what was written since is dropped
    run_scene(scene, parts, threads=1, checkpoint=parts / "REVIVE")
    for name in FILES:
        assert (parts / name).read_bytes() == (whole / name).read_bytes(), name


def test_a_checkpoint_writes_what_there_is(tmp_path: Path) -> None:
    """After the checkpoint of step 20 a kill would leave these files."""
    run_folder(tmp_path, SAMPLING)
    simulations = []

    class Looker:
        def next_step(self, step: int) -> int | None:
            return 30 if step < 30 else None

        def report(self, _: pydlpoly.Simulation) -> None:
            simulations.append({name: (tmp_path / name).read_bytes() for name in FILES[:3]})

    scene = pydlpoly.load(tmp_path)
    other = tmp_path / "other"
    run_scene(scene, other, steps=20, threads=1)
    import pydlpoly.runner as runner

    original = runner.samplers

    def with_looker(simulation, folder, *, append):
        simulation.reporters.append(Looker())
        yield from original(simulation, folder, append=append)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runner, "samplers", with_looker)
        run_scene(scene, tmp_path, threads=1)
    for name in FILES[:3]:
        assert simulations[0][name] == (other / name).read_bytes(), name


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"zden_binsize": "0.1 ang"}, "density profiles in 20 bins"),
        ({"vaf_binsize": "7"}, "velocity autocorrelations with other samples"),
        ({"vaf_averaging": "off"}, "velocity autocorrelations with other samples"),
    ],
)
def test_other_samples_cannot_be_continued(tmp_path: Path, change: dict[str, str], message: str) -> None:
    run_folder(tmp_path, SAMPLING)
    run_scene(pydlpoly.load(tmp_path), tmp_path, steps=20, threads=1)
    before = (tmp_path / "ZDNDAT").read_bytes()
    scene = pydlpoly.load(run_folder(tmp_path / "changed", {**SAMPLING, **change}))
    with pytest.raises(pydlpoly.InputError, match=message):
        run_scene(scene, tmp_path, threads=1, checkpoint=tmp_path / "REVIVE")
    assert (tmp_path / "ZDNDAT").read_bytes() == before


def test_a_run_can_begin_to_sample_when_it_continues(tmp_path: Path) -> None:
    run_folder(tmp_path, {**SAMPLING, "zden_calculate": "off", "vaf_calculate": "off"})
    scene = pydlpoly.load(tmp_path)
    run_scene(scene, tmp_path, steps=20, threads=1)
    assert not (tmp_path / "ZDNDAT").exists()
    more = replace(scene.output, zden_every=5, zden_bins=4, vaf_every=5, vaf_steps=5)
    run_scene(replace(scene, output=more), tmp_path, threads=1, checkpoint=tmp_path / "REVIVE")
    frames = list(read_history(tmp_path / "HISTORY"))
    (found,) = read_correlations(tmp_path / "VAFDAT_A")
    total = correlations_of(frames, [20, 25, 30, 35], 5, 0).sum(axis=0)
    np.testing.assert_allclose(found.values, total / total[0], rtol=1e-6)


def test_defaults_of_velocity_samples(tmp_path: Path) -> None:
    for given, expected in (("0 steps", (50, 100)), ("30 steps", (30, 100)), ("150 steps", (150, 300))):
        run_folder(tmp_path, {"vaf_calculate": "on", "vaf_frequency": given})
        plan = pydlpoly.load(tmp_path).output
        assert (plan.vaf_every, plan.vaf_steps) == expected


def test_old_style_names(tmp_path: Path) -> None:
    run_folder(tmp_path)
    (tmp_path / "CONTROL").write_text(
        "test run\ntemperature 1.0\nsteps 20\nequilibration 0\nensemble nvt mdvv\ncutoff 1.0\ntimestep 0.01\n"
        "vdw direct\nno elec\nbinsize 0.1\nzden every 2\nprint zden\nvaf 5 10\nmsdtmp 4 8\njob time 10\nclose time 1\n"
        "finish\n"
    )
    plan = pydlpoly.load(tmp_path).output
    assert (plan.zden_every, plan.zden_bins) == (2, 10)
    assert (plan.vaf_every, plan.vaf_steps, plan.vaf_averaging) == (5, 10, True)
    assert (plan.msd_every, plan.msd_start) == (8, 4)


def test_nothing_is_written_unless_asked_for(tmp_path: Path) -> None:
    run_folder(tmp_path, {**SAMPLING, "zden_print": "off", "io_file_msd": "NONE", "vaf_calculate": "off"})
    scene = pydlpoly.load(tmp_path)
    assert (scene.output.zden_every, scene.output.vaf_every, scene.output.msd_every) == (0, 0, 0)
    run_scene(scene, tmp_path, steps=10, threads=1)
    assert not any((tmp_path / name).exists() for name in FILES)
