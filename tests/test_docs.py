"""The documentation is current: generated parts, links, names of files and tests, and every example runs."""

from __future__ import annotations

import doctest
import importlib.util
import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

import pytest

from pydlpoly.formats.control import read_control
from pydlpoly.formats.field import read_field

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
NAMES = [page.relative_to(ROOT).as_posix() for page in PAGES]

_FENCE = re.compile(
    r"^(?:<!-- (?P<mark>[^\n]*) -->\n)?```(?P<language>\w+)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL
)
_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")
_LINK = re.compile(r"\[[^\]]*\]\((?P<target>[^)\s]+)\)")
_PATH = re.compile(r"`(?P<path>(?:tests|cpp|docs|pydlpoly|\.ci)/[\w./-]+)(?:::(?P<test>\w+))?`")


@dataclass(frozen=True)
class Command:
    """One command line of a console block and what it is said to print."""

    words: list[str]
    expected: str


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, and the words of the comment above it (``run``, ``file: NAME``, …)."""

    language: str
    text: str
    mark: str
    line: int

    @property
    def runs(self) -> bool:
        return self.mark.split(",")[0] == "run"

    @property
    def exit_code(self) -> int:
        found = re.search(r"exit (\d+)", self.mark)
        return int(found[1]) if found else 0

    def commands(self) -> list[Command]:
        """Commands begin with ``$ ``; the lines up to the next one are their output."""
        parts = re.split(r"^\$ ", self.text, flags=re.MULTILINE)
        assert parts[0] == "", "a console block begins with a command"
        return [Command(shlex.split(part.split("\n", 1)[0]), part.split("\n", 1)[1]) for part in parts[1:]]


@dataclass
class Page:
    """A page and its blocks, in order."""

    path: Path
    blocks: list[Block] = field(default_factory=list)


def read_page(path: Path) -> Page:
    text = path.read_text(encoding="utf-8")
    blocks = [
        Block(found["language"], found["text"], found["mark"] or "", text.count("\n", 0, found.start()) + 1)
        for found in _FENCE.finditer(text)
    ]
    assert text.count("\n```") == 2 * len(blocks), f"{path.name}: a block without a language or without an end"
    return Page(path, blocks)


def generator() -> ModuleType:
    """``docs/generate.py`` as a module."""
    spec = importlib.util.spec_from_file_location("docs_generate", ROOT / "docs" / "generate.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", NAMES)
def test_generated_parts_are_current(name: str) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    assert text == generator().regenerate(text), "run `python docs/generate.py`"


def test_every_generated_part_is_on_a_page() -> None:
    pages = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for name in generator().PARTS:
        assert pages.count(f"<!-- generated: {name} -->") == pages.count(f"<!-- end: {name} -->") == 1, name


def test_generator_replaces_only_what_is_between_the_marks() -> None:
    module = generator()
    stale = "before\n<!-- generated: constants -->\nold\n<!-- end: constants -->\nafter\n"
    fresh = module.regenerate(stale)
    assert fresh.startswith("before\n<!-- generated: constants -->\n")
    assert fresh.endswith("<!-- end: constants -->\nafter\n")
    assert "old" not in fresh
    assert "0.831451115" in fresh
    assert module.regenerate(fresh) == fresh


@pytest.mark.parametrize("name", NAMES)
def test_links_lead_to_files(name: str) -> None:
    page = ROOT / name
    for found in _LINK.finditer(page.read_text(encoding="utf-8")):
        target = found["target"].split("#")[0]
        if not target.startswith(("http:", "https:")):
            assert (page.parent / target).is_file(), target


@pytest.mark.parametrize("name", NAMES)
def test_files_and_tests_that_are_named_exist(name: str) -> None:
    for found in _PATH.finditer((ROOT / name).read_text(encoding="utf-8")):
        path = ROOT / found["path"]
        assert path.exists(), found["path"]
        if found["test"]:
            assert f"def {found['test']}(" in path.read_text(encoding="utf-8"), found[0]


def test_every_page_is_in_the_index() -> None:
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    linked = {found["target"] for found in _LINK.finditer(index)}
    assert linked >= {page.name for page in PAGES[1:]} - {"index.md"}


@pytest.mark.parametrize("name", NAMES)
def test_every_example_is_run_or_is_no_example(name: str) -> None:
    """Console blocks are pydlpoly's and marked; a shell block is for installing, which the other tests cannot do."""
    for block in read_page(ROOT / name).blocks:
        assert block.language in ("python", "console", "sh", "text"), f"{name}:{block.line}"
        if block.language == "console":
            assert block.runs, f"{name}:{block.line}"
            assert all(command.words[0] == "pydlpoly" for command in block.commands()), f"{name}:{block.line}"


@pytest.mark.parametrize("name", NAMES)
def test_examples_run(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The blocks of a page in order, in one folder; Python blocks share their names, as a reader would type them."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    names: dict[str, object] = {"__name__": "example"}
    for block in read_page(ROOT / name).blocks:
        if block.mark.startswith("file: "):
            (tmp_path / block.mark.removeprefix("file: ")).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            # Empty lines in front make the line numbers of errors those of the page.
            exec(compile("\n" * block.line + block.text, name, "exec"), names)
        elif block.runs:
            for command in block.commands():
                check_command(command, block)


def check_command(command: Command, block: Block) -> None:
    line = [sys.executable, "-m", "pydlpoly", *command.words[1:]]
    done = subprocess.run(line, capture_output=True, text=True, encoding="utf-8", check=False, env=os.environ.copy())
    said = done.stdout + done.stderr
    assert done.returncode == block.exit_code, said
    expected = command.expected
    if "numbers vary" in block.mark:
        said, expected = (_NUMBER.sub("#", text) for text in (said, expected))
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    assert matches(expected, said, flags), f"expected\n{expected}\nfound\n{said}"


def matches(expected: str, found: str, flags: int) -> bool:
    """As in doctests: a line of three dots stands for any lines."""
    return doctest.OutputChecker().check_output(expected, found, flags)


def test_a_wrong_output_is_noticed() -> None:
    assert matches("a\n...\nd\n", "a\nb\nc\nd\n", doctest.ELLIPSIS)
    assert not matches("a\n...\ne\n", "a\nb\nc\nd\n", doctest.ELLIPSIS)
    assert not matches("", "a\n", doctest.ELLIPSIS)


def test_recipe_for_a_pair_law_is_true() -> None:
    """docs/extending.md counts three places; the names it uses are there."""
    assert "using Laws = TypeList<" in (ROOT / "cpp/pair/registry.hpp").read_text(encoding="utf-8")
    table = (ROOT / "tests/test_pair_laws.py").read_text(encoding="utf-8")
    assert re.search(r"^ROWS = \{", table, re.MULTILINE)
    assert re.search(r"^VALUES(: .*)? = \{", table, re.MULTILINE)
    assert "PAIR_KEYS = " in (ROOT / "pydlpoly/formats/field_keys.py").read_text(encoding="utf-8")
    headers = {path.name for path in (ROOT / "cpp/pair").glob("*.hpp")}
    included = set(re.findall(r'#include "pair/(\w+\.hpp)"', (ROOT / "cpp/pair/registry.hpp").read_text("utf-8")))
    assert included <= headers
    record = (ROOT / "cpp/pair/law.hpp").read_text(encoding="utf-8")
    page = (ROOT / "docs/extending.md").read_text(encoding="utf-8")
    members = re.findall(r"^    (?:std::\S+(?: \S+>)?|unsigned|int|bool) (\w+)(?: = \w+)?;", record, re.MULTILINE)
    assert len(members) == 9
    assert set(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE)) == set(members)


@pytest.mark.parametrize("file", ["CONTROL", "FIELD"])
def test_the_other_dialect_is_known_by_its_content(file: str, shared: Path) -> None:
    """As docs/inputs.md says."""
    reader = {"CONTROL": read_control, "FIELD": read_field}[file]
    assert reader(shared / "inputs" / "dl_meso" / "lipid" / file).meso is not None
