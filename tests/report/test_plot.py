"""``pydlpoly report`` and ``pydlpoly plot`` as commands."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from .runs import COMMAND

SIGNATURES = {".png": b"\x89PNG\r\n", ".svg": b"<?xml", ".pdf": b"%PDF"}


def command(*words: object, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    line = [COMMAND, *(str(word) for word in words)]
    return subprocess.run(line, capture_output=True, text=True, check=False, cwd=folder)


def test_report_prints_its_warnings_and_where_it_is(reports, tmp_path: Path) -> None:
    done = command("report", reports("hot").folder, "--output", tmp_path / "page.html")
    assert done.returncode == 0, done.stderr
    assert "warning: kinetic temperature" in done.stdout
    assert f"{tmp_path / 'page.html'}: 0." in done.stdout
    done = command("report", tmp_path / "nowhere")
    assert done.returncode == 1
    assert "there is no such folder" in done.stderr


@pytest.mark.parametrize("ending", SIGNATURES)
def test_single_quantities_as_pictures(reports, tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"picture{ending}"
    for quantity in ("temperature", "rdf", "last", "volume", "laplacian", "msd_A"):
        done = command("plot", reports("healthy").folder, quantity, "--output", path)
        assert done.returncode == 0, done.stderr
        assert path.read_bytes().startswith(SIGNATURES[ending])
        assert len(done.stdout) > 30  # the caption
        path.unlink()


@pytest.mark.parametrize(
    ("quantity", "told"),
    [
        ("profile-temperature", "Temperature along x in 8 bins, from PROFILE, 30 samples"),
        ("map-velocity_x", "(velocity x) in the plane of x and z in 6 x 5 bins, from MAP"),
        ("stress-relaxation", "both axes logarithmic"),
        ("viscosity", "Viscosity "),
        ("last-temperature", "160 beads in shades of what they carry, from REVIVE"),
        ("last-concentration_sugar", "concentration of sugar"),
        ("species", "Amounts of dissolved species in all beads, from OUTPUT"),
        ("conserved", "Energies per bead in k_B T"),
        ("internal_energy", "Internal energy per bead"),
    ],
)
def test_averages_and_what_beads_carry_as_pictures(reports, tmp_path: Path, quantity: str, told: str) -> None:
    path = tmp_path / "picture.png"
    done = command("plot", reports("carried").folder, quantity, "--output", path)
    assert done.returncode == 0, done.stderr
    assert path.read_bytes().startswith(SIGNATURES[".png"])
    assert told in done.stdout
    done = command("plot", reports("carried").folder, "map-velocity_w")
    assert "did you mean map-velocity_" in done.stderr


def test_a_picture_that_cannot_be_written_is_no_stopped_run(reports, tmp_path: Path) -> None:
    path = tmp_path / "no" / "such.png"
    done = command("plot", reports("healthy").folder, "temperature", "--output", path)
    assert done.returncode == 1
    assert done.stderr == f"pydlpoly: {path}: cannot be written: No such file or directory\n"


def test_what_there_is_is_listed(reports) -> None:
    done = command("plot", reports("healthy").folder)
    assert "figures: last, start, temperature, pressure" in done.stdout
    assert "stress_xy" in done.stdout
    done = command("plot", reports("empty").folder)
    assert done.stdout == "figures: none\ncolumns: none\n"


def test_the_usual_name_and_what_is_refused(reports, tmp_path: Path) -> None:
    folder = reports("healthy").folder
    assert command("plot", folder, "pressure", folder=tmp_path).returncode == 0
    assert (tmp_path / "pressure.png").is_file()
    done = command("plot", folder, "presure")
    assert done.returncode == 1
    assert "did you mean pressure" in done.stderr
    done = command("plot", reports("hot").folder, "vaf")
    assert "the files of this folder do not hold it" in done.stderr
    done = command("plot", folder, "pressure", "--output", "pressure.txt")
    assert "expected a name that ends with .png, .svg, .pdf" in done.stderr
