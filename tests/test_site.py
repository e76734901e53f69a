"""The site: every page has its place, links hold, nothing comes from elsewhere. What is shipped: wheels and sources."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

needs_mkdocs = pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("mkdocs", "material")),
    reason="the site's tools are not installed: pip install '.[docs]'",
)


def mkdocs(folder: Path, output: Path) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-m", "mkdocs", "build", "--strict"]  # --quiet would hide warnings from --strict
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    return subprocess.run(
        [*line, "--site-dir", str(output)], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    output = tmp_path_factory.mktemp("site")
    done = mkdocs(ROOT, output)
    assert done.returncode == 0, done.stdout + done.stderr
    return output


@needs_mkdocs
def test_every_page_is_built(site: Path) -> None:
    pages = {page.stem for page in (ROOT / "docs").glob("*.md")}
    assert pages <= {page.stem for page in site.glob("*.html")}
    assert {"install", "first-run", "from-dl-poly", "dl-meso", "from-lammps", "ase", "validation"} <= pages
    assert not [path for path in site.rglob("*") if path.suffix == ".py" or path.name == "validation.json"]


@needs_mkdocs
def test_nothing_is_fetched_from_elsewhere(site: Path) -> None:
    """Links may lead anywhere; scripts, styles, fonts and pictures are of the site."""
    fetched = re.compile(
        r"<(?:script|img|iframe|source)\b[^>]*\bsrc=[\"']?(?:https?:)?//|<link\b[^>]*\bhref=[\"']?https?:"
    )
    for page in site.rglob("*.html"):
        assert not fetched.search(page.read_text(encoding="utf-8")), page.name
    for style in site.rglob("*.css"):
        assert not re.search(r"(?:url\(|@import\s*)[\"']?(?:https?:)?//", style.read_text(encoding="utf-8")), style.name


@needs_mkdocs
@pytest.mark.parametrize("slip", ["[dead](no-page.md)", "[dead](index.md#no-anchor)"])
def test_a_dead_link_stops_the_build(slip: str, tmp_path: Path) -> None:
    shutil.copy(ROOT / "mkdocs.yml", tmp_path)
    shutil.copytree(ROOT / "docs", tmp_path / "docs")
    with (tmp_path / "docs" / "noise.md").open("a", encoding="utf-8") as page:
        page.write(f"\n{slip}\n")
    done = mkdocs(tmp_path, tmp_path / "site")
    assert done.returncode != 0
    assert "noise.md" in done.stdout + done.stderr


@needs_mkdocs
def test_a_page_without_a_place_stops_the_build(tmp_path: Path) -> None:
    shutil.copy(ROOT / "mkdocs.yml", tmp_path)
    shutil.copytree(ROOT / "docs", tmp_path / "docs")
    (tmp_path / "docs" / "lost.md").write_text("# Lost\n", encoding="utf-8")
    assert mkdocs(tmp_path, tmp_path / "site").returncode != 0


def test_pictures_are_small() -> None:
    pictures = sorted((ROOT / "docs" / "images").glob("*.png"))
    assert pictures
    assert not [path.name for path in pictures if path.stat().st_size > 150_000]


# -- What is shipped --------------------------------------------------------------------------------------------------


def test_the_source_distribution_holds_what_a_build_needs(tmp_path: Path) -> None:
    """Made by the build backend itself, from a folder with leftovers of a build."""
    pytest.importorskip("scikit_build_core.build", reason="scikit-build-core is not installed")
    source = tmp_path / "source"
    for folder in ("cpp", "pydlpoly", "tests", "docs", ".github"):
        shutil.copytree(ROOT / folder, source / folder, ignore=shutil.ignore_patterns("*.so", "__pycache__"))
    for path in ROOT.iterdir():
        if path.is_file() and path.name != ".git":
            shutil.copy(path, source)
    for leftover in ("pydlpoly/_core.cpython-311-x86_64-linux-gnu.so", "build/CMakeCache.txt", "dist/old.whl"):
        (source / leftover).parent.mkdir(exist_ok=True)
        (source / leftover).write_text("leftover", encoding="utf-8")
    code = f"import scikit_build_core.build as b; print(b.build_sdist({str(tmp_path)!r}))"
    done = subprocess.run([sys.executable, "-c", code], cwd=source, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    version = PROJECT["project"]["version"]
    with tarfile.open(tmp_path / f"pydlpoly-{version}.tar.gz") as archive:
        names = {name.removeprefix(f"pydlpoly-{version}/") for name in archive.getnames()}
    assert {"LICENSE", "README.md", "CMakeLists.txt", "pyproject.toml", "PKG-INFO", "pydlpoly/py.typed"} <= names
    files = [path for folder in ("cpp", "pydlpoly") for path in (ROOT / folder).rglob("*") if path.is_file()]
    made = (".so", ".pyc")
    assert {path.relative_to(ROOT).as_posix() for path in files if path.suffix not in made} <= names
    allowed = ("cpp/", "pydlpoly/", "LICENSE", "README.md", "CMakeLists.txt", "pyproject.toml", "PKG-INFO")
    assert not [name for name in names if not name.startswith(allowed)]
    assert not [name for name in names if name.endswith((".so", ".pyc", ".o"))]


def test_wheels_are_built_and_tested_for_every_python() -> None:
    wheels = PROJECT["tool"]["cibuildwheel"]
    assert wheels["build"] == "cp3{10,11,12,13}-manylinux_*"
    commands = " ".join(wheels["test-command"])
    assert "pydlpoly run --example water" in commands
    named = re.findall(r"\{project\}/(tests/\w+\.py)", commands)
    assert named
    assert all((ROOT / name).is_file() for name in named)
    workflow = (ROOT / ".github" / "workflows" / "wheels.yml").read_text(encoding="utf-8")
    assert "pypa/cibuildwheel@" in workflow
    assert "ubuntu-24.04-arm" in workflow


def test_cibuildwheel_understands_the_configuration() -> None:
    pytest.importorskip("cibuildwheel", reason="cibuildwheel is not installed")
    line = [sys.executable, "-m", "cibuildwheel", "--print-build-identifiers", "--platform", "linux"]
    done = subprocess.run([*line, "--archs", "x86_64,aarch64"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    expected = {f"cp3{k}-manylinux_{machine}" for k in (10, 11, 12, 13) for machine in ("x86_64", "aarch64")}
    assert set(done.stdout.split()) == expected
