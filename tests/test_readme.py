"""README.md: its test command is the one that .ci/run takes, and its table of what is supported is true."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

import pydlpoly
from pydlpoly import SceneError, _core, load
from pydlpoly.cli import example_folder, example_names
from pydlpoly.formats.field_keys import BONDED
from pydlpoly.formats.keywords import KEYWORDS

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
SHELL = re.findall(r"^```sh\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)


def test_two_commands_for_a_fresh_machine() -> None:
    assert len(SHELL) == 2
    assert all(block.count("\n") == 1 and block.startswith("python3 -m venv .venv && ") for block in SHELL)
    example = re.search(r"pydlpoly run --example (\w+) ", SHELL[0])
    assert example is not None
    assert example[1] in example_names()


def test_the_checks_take_the_command_from_here() -> None:
    script = ROOT / ".ci" / "run"
    assert script.stat().st_mode & 0o111, "the script is executable"
    done = subprocess.run([str(script), "--print-command"], capture_output=True, text=True, check=True)
    assert done.stdout == SHELL[1]
    assert 'bash -euo pipefail -c "$command"' in script.read_text(encoding="utf-8")


def test_the_tests_see_a_package_with_its_core() -> None:
    """A source folder on Python's path would hide the installed package; then this import has failed already."""
    assert Path(pydlpoly.__file__).name == "__init__.py"
    assert Path(_core.__file__).suffix in (".so", ".pyd")
    assert not (ROOT / "pydlpoly" / Path(_core.__file__).name).exists(), "a compiled core in the source folder"


def row(subject: str) -> tuple[str, str]:
    """The cells supported and refused of a row of the table."""
    found = re.search(rf"^\| {re.escape(subject)} \|([^|]*)\|([^|]*)\|$", README, re.MULTILINE)
    assert found is not None, subject
    return found[1].strip(), found[2].strip()


def test_pair_laws_and_mixing_rules() -> None:
    supported, refused = row("pair laws")
    keys = {law["key"] for law in _core.pair_laws()}
    assert set(re.search(r"among them (.*?);", supported)[1].split(", ")) <= keys  # type: ignore[index]  # None fails
    assert not set(re.findall(r"`(\w+)`", refused)) & keys
    assert row("cross terms")[0].startswith("[seven mixing rules]")
    assert len(_core.mixing_rules()) == 7


def example_with(tmp_path: Path, **changes: tuple[str, str]) -> Path:
    """The example water with one text of a file replaced by another."""
    for name in ("CONTROL", "FIELD", "CONFIG"):
        text = (example_folder("water") / name).read_text(encoding="utf-8")
        if name in changes:
            before, after = changes[name]
            assert before in text
            text = text.replace(before, after, 1)
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


REFUSED_BLOCKS = {
    "rigid units": ("rigid 1\n2 1 2\n", "rigid"),
    "shells": ("shell 1\n1 2 10.0\n", "shells"),
    "mean-force constraints": ("pmf 1.0\npmf unit 1\n1 0.0\npmf unit 1\n2 0.0\n", "pmf"),
}


@pytest.mark.parametrize("words", REFUSED_BLOCKS)
def test_blocks_that_are_refused(words: str, tmp_path: Path) -> None:
    assert words in row("molecules")[1]
    block, word = REFUSED_BLOCKS[words]
    molecule = f"nummols 1500\natoms 2\nW 1.0 0.0 2\n{block}"
    folder = example_with(tmp_path, FIELD=("nummols 3000\natoms 1\nW 1.0 0.0\n", molecule))
    with pytest.raises(SceneError, match="not modelled") as caught:
        load(folder)
    assert caught.value.word == word


def test_bonded_terms() -> None:
    kinds = dict.fromkeys(law["kind"] for law in _core.bonded_laws())
    assert list(kinds) == ["bond", "angle", "dihedral", "inversion", "tether"]
    assert "bonds, angles, dihedrals, inversions, tethers" in row("molecules")[0]
    # Every law of the FIELD reader is there.
    for directive, kind in zip(("bonds", "angles", "dihedrals", "inversions", "tethers"), kinds, strict=True):
        laws = [law for law in _core.bonded_laws() if law["kind"] == kind]
        keys = {law["key"] for law in laws} | {law["restraint_key"] for law in laws} - {""}
        missing = BONDED[directive].keys - keys
        assert not missing
        assert keys <= BONDED[directive].keys


@pytest.mark.parametrize(
    ("subject", "file", "before", "after", "message"),
    [
        ("ensembles", "CONTROL", "dpd\n", "evans\n", "not modelled"),
        ("ensembles", "CONTROL", "nvt", "pmf", "not modelled"),
        ("pair laws", "FIELD", "dpd  25.0", "gaus 25.0", "unknown pair law"),
        ("cross terms", "FIELD", "  4.5\n", "\n", "needs a drag for every pair"),
        ("cells", "CONFIG", "\n0 1 3000", "\n0 4 3000", "imcon 4 .* is not supported"),
        ("external fields", "FIELD", "close", "extern\nxpis 1 2 3\nclose", "not modelled"),
        ("many-body terms", "FIELD", "close", "metal 1\nW W stch 1 1 1 1 1\nclose", "not modelled"),
        ("precision, threads", "CONTROL", "timestep ", "precision single\ntimestep ", "no option of precision"),
        (
            "files written",
            "CONTROL",
            "traj_calculate         on",
            "traj_calculate on\ntraj_key compressed",
            "not modelled",
        ),
    ],
)
def test_what_the_table_refuses(subject: str, file: str, before: str, after: str, message: str, tmp_path: Path) -> None:
    assert row(subject)[1]
    folder = example_with(tmp_path, **{file: (before, after)})
    with pytest.raises(pydlpoly.InputError, match=message):
        load(folder)


def test_charges(tmp_path: Path) -> None:
    charged = ("W 1.0 0.0", "W 1.0 0.5")
    scene = load(example_with(tmp_path, FIELD=charged))
    assert any(note.kind == "warning" and "charges" in note.text for note in scene.notes)
    methods = [word for word in KEYWORDS["coul_method"].options if word != "off"]
    for method in methods:
        folder = example_with(tmp_path, FIELD=charged, CONTROL=("vdw_method", f"coul_method {method}\nvdw_method"))
        with pytest.raises(SceneError, match="coul_bjerrum_length"):
            load(folder)
        given = f"coul_method {method}\ncoul_bjerrum_length 1 ang\nvdw_method"
        assert load(example_with(tmp_path, FIELD=charged, CONTROL=("vdw_method", given))).electrostatics is not None
