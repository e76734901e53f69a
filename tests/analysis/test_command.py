"""``pydlpoly analyse``: what it prints and writes, and that it refuses what it cannot do."""

from __future__ import annotations

import csv
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pydlpoly
from pydlpoly.analysis import ChainDimensions, MeanSquareDisplacement, RadialDistribution, molecules_of
from pydlpoly.cli import example_folder, main
from pydlpoly.runner import run_scene

LIPID = example_folder("lipid")


@pytest.fixture(scope="module")
def history(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scene = pydlpoly.load(LIPID)
    scene = replace(scene, output=replace(scene.output, trajectory_every=10, trajectory_level=1))
    folder = tmp_path_factory.mktemp("command")
    run_scene(scene, folder, steps=100, seed=1)
    return folder / "HISTORY"


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    def call(*words: object) -> tuple[object, str, str]:
        monkeypatch.setattr(sys, "argv", ["pydlpoly", "analyse", *(str(word) for word in words)])
        with pytest.raises(SystemExit) as stop:
            main()
        said = capsys.readouterr()
        return stop.value.code, said.out, said.err

    return call


EVERYTHING = (
    *("--rdf", "--between", "--reach", "2", "--bin-width", "0.1", "--density", "z", "--centre", "T", "--msd", "--fit"),
    *("0.1:0.2", "--vaf", "--chains", "--bonds", "--structure-factor", "--clusters", "0.9", "--species", "H,T"),
    *("--order", "--lamellae", "T", "--bilayer", "H,T"),
)


def test_everything_in_one_pass(history: Path, tmp_path: Path, command) -> None:
    table, arrays, picture = (tmp_path / name for name in ("a.csv", "a.npz", "a.png"))
    code, out, err = command(history, "--scene", LIPID, *EVERYTHING, "--output", table, "--plot", picture)
    assert (code, err) == (0, "")
    assert out.startswith(f"11 frames of {history}\n")
    for word in ("g(r) H W", "density T", "D of W (MSD)", "D of W (VAF)", "lipid: radius of gyration", "bond length"):
        assert word in out
    for word in ("angle T-T-T", "S(q): highest", "clusters: largest", "director z", "lamellar period", "bilayer area"):
        assert word in out
    assert "Å" not in out  # FIELD's units are reduced
    assert picture.read_bytes().startswith(b"\x89PNG")
    rows = list(csv.DictReader(table.read_text().splitlines()))
    rdf = RadialDistribution([("W", "W")], bin_width=0.1, reach=2.0).of(history)
    found = [row for row in rows if (row["quantity"], row["name"]) == ("rdf", "W W")]
    assert [float(row["x"]) for row in found] == pytest.approx(rdf.r)
    assert [float(row["y"]) for row in found] == pytest.approx(rdf.g[0])
    sizes = ChainDimensions([one for one in molecules_of(pydlpoly.load(LIPID)).values() if one.beads.shape[1] > 1])
    (gyration,) = [row for row in rows if row["name"] == "lipid: radius of gyration squared"]
    assert float(gyration["y"]) == pytest.approx(sizes.of(history).gyration_squared[0])
    assert command(history, "--msd", "--start", 1, "--every", 2, "--output", arrays)[0] == 0
    stored = np.load(arrays)
    msd = MeanSquareDisplacement().of(history, start=1, every=2)
    np.testing.assert_array_equal(stored["msd.W.y"], msd.msd[2])
    assert stored["numbers.names"].tolist() == ["D of H (MSD)", "D of T (MSD)", "D of W (MSD)"]


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        ((), 2, "say what to compute"),
        (("--chains",), 1, "molecules are needed: give the folder"),
        (("--msd", "--fit", "1"), 2, "expected FROM:TO"),
        (("--bilayer", "H"), 2, "expected HEAD,TAIL"),
        (("--lamellae", "X"), 1, "'X': there are no beads of this species"),
        (("--msd", "--output", "results.txt"), 1, "ends with .csv or .npz"),
        (("--msd", "--start", "20"), 1, "no frames to analyse"),
        (("--rdf", "--reach", "50"), 1, "half its width"),
        (("--density", "w"), 1, "expected axis x, y or z"),
    ],
)
def test_what_cannot_be_done_is_refused(
    history: Path, command, words: tuple[str, ...], code: int, message: str
) -> None:
    found, _, err = command(history, *words)
    assert found == code
    assert message in " ".join(err.replace("│", " ").split())
    assert "Traceback" not in err


def test_a_missing_file_is_refused(tmp_path: Path, command) -> None:
    code, _, err = command(tmp_path, "--msd")
    assert code == 1
    assert "HISTORY: cannot be read" in err
