"""Reports of a healthy, a too hot, a killed and an empty run: figures, numbers, warnings, one small file."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.output_reader import read_output
from pydlpoly.formats.rdfdat import read_rdf
from pydlpoly.formats.statis import read_statistics
from pydlpoly.report import collect_run, judge_run, write_report
from pydlpoly.runner import run_scene
from pydlpoly.scene import load

from ..run_folders import run_folder
from .runs import MAKERS

EVERY = [
    *("last", "start", "temperature", "pressure", "energy", "momentum"),
    *("rdf", "density", "stress-profile", "msd", "vaf", "speed", "time"),
]


def figures(html: str) -> list[str]:
    return re.findall(r'<figure id="([\w-]+)">', html)


def words(html: str) -> str:
    """What a reader sees, without tags."""
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", html)).replace("&#39;", "'")


@pytest.mark.parametrize("name", MAKERS)
def test_page_is_one_small_file_that_needs_nothing(reports, name: str) -> None:
    html = reports(name).html
    assert len(html) < 5_000_000
    assert "<script" not in html
    outside = [word for word in re.findall(r'(?:src|href)="([^"]*)"', html) if not word.startswith(("#", "data:"))]
    assert outside == []
    assert set(re.findall(r'"(https?://[^"]*)"', html)) <= {
        "http://www.w3.org/2000/svg",
        "http://www.w3.org/1999/xlink",
    }
    assert "url(" not in re.sub(r"url\(#", "", html)


@pytest.mark.parametrize("name", MAKERS)
def test_page_is_well_formed(reports, name: str) -> None:
    html = reports(name).html
    stack: list[str] = []
    void = {"meta", "link", "br", "input"}

    class Checker(HTMLParser):
        def handle_starttag(self, tag: str, attrs: object) -> None:  # noqa: ARG002 # the parser's name for it
            if tag not in void:
                stack.append(tag)

        def handle_endtag(self, tag: str) -> None:
            assert stack.pop() == tag

    Checker().feed(html)
    assert stack == []
    ids = re.findall(r'\bid="([^"]*)"', html)
    assert len(ids) == len(set(ids))
    for target in re.findall(r'href="#([^"]*)"|url\(#([^)]*)\)', html):
        assert "".join(target) in ids
    for svg in re.findall(r"<svg.*?</svg>", html, re.DOTALL):
        ET.fromstring(svg)
        assert 'role="img"' in svg.split(">", 1)[0]
        assert len(re.search(r'aria-label="([^"]*)"', svg)[1]) > 40  # a text alternative that says something


def test_healthy_run_has_every_figure_and_no_warning(reports) -> None:
    report = reports("healthy")
    assert figures(report.html) == EVERY
    assert report.level("warning") == {}
    assert "No warnings." in report.html
    fine = report.level("fine")
    assert {"Length of the run", "Kinetic temperature", "Configurational temperature", "Momentum", "Pressure"} <= set(
        fine
    )


def test_numbers_are_those_of_the_run(reports) -> None:
    """Against OUTPUT, which the run computed while it went, and RDFDAT."""
    report = reports("healthy")
    text, log = words(report.html), read_output(report.folder / "OUTPUT")
    table = read_statistics(report.folder / "STATIS", species=["A", "B"])
    after = table.step > 600
    for name, label in (("pressure", "pressure"), ("temperature", "kinetic temperature"), ("stress_zz", "stress zz")):
        found = re.search(rf"{label} (-?[\d.]+) ± ([\d.]+) {after.sum()}\b", text)
        assert found is not None, label
        # As many digits are shown as the error allows: two of it.
        assert float(found[1]) == pytest.approx(table[name][after].mean(), abs=0.06 * float(found[2]))
    energy = re.search(r"total energy \(per bead\) ([\d.]+) ±", text)
    assert float(energy[1]) == pytest.approx(table["extended_energy"][after].mean() / 160, rel=1e-3)
    for name in ("kinetic", "configurational"):
        found = re.search(rf"{name} temperature ([\d.]+) ± ([\d.]+)", text)
        value, error = log.temperatures[name]
        assert float(found[1]) == pytest.approx(value, abs=0.1 * error)
        assert float(found[2]) == pytest.approx(error, rel=0.05)
    rdf = read_rdf(report.folder / "RDFDAT")
    highest = rdf["A", "A"].max()
    assert f"A–A {highest:.3g} at {rdf.r[rdf['A', 'A'].argmax()]:.3g}" in text
    assert "1200 of 1200" in text
    assert "160 (120 A, 40 B)" in text
    assert f"{1200 / log.loop_seconds:.4g} steps a second" in text


def test_explanation_is_that_of_the_run(reports) -> None:
    text = reports("healthy").html
    for title in ("System", "Pair table", "Run", "Output", "Choices"):
        assert f"<summary>{title}</summary>" in text
    assert "1200 steps, time 12 in all" in text


def test_pictures_hide_the_solvent_and_say_so(reports) -> None:
    text = words(reports("healthy").html)
    assert "A, the most abundant species of single beads, is not drawn." in text
    assert "160 beads: 120 A, 40 B; from REVIVE" in text


def test_too_hot_run_is_called_so(reports) -> None:
    report = reports("hot")
    warnings = report.level("warning")
    found = re.match(
        r"kinetic temperature ([\d.]+) % high \(([\d.]+) ± [\d.]+, thermostat 1\): timestep too long",
        warnings["Temperature"],
    )
    assert found is not None, warnings
    table = read_statistics(report.folder / "STATIS", species=["A", "B"])
    mean = table["temperature"][table.step > 200].mean()
    assert float(found[1]) == pytest.approx(100 * (mean - 1), rel=0.06)
    assert f"pydlpoly tradeoff {report.folder}" in warnings["Temperature"]
    assert "configurational temperature" in warnings["Configurational temperature"]
    at = [report.html.index(word) for word in ("Warning – Temperature", "At a glance", "What was modelled</h2>")]
    assert at == sorted(at)  # the warnings stand at the top


def test_killed_run_says_how_far_it_got(reports) -> None:
    report = reports("killed")
    warnings = report.level("warning")
    found = re.search(r"did not end in good order, at step (\d+) of 1000000: it was killed", warnings["Run incomplete"])
    table = read_statistics(report.folder / "STATIS")
    assert int(found[1]) >= table.step[-1] > 0
    assert "no checkpoint to continue from" in warnings["Run incomplete"]
    assert "a frame is cut short" in warnings["File HISTORY"]
    names = figures(report.html)
    assert {"last", "start", "temperature", "pressure", "energy", "rdf", "density", "msd"} <= set(names)
    assert "of HISTORY" in report.html
    assert "from HISTORY" in words(report.html)


def test_empty_folder_and_run_of_no_steps(reports) -> None:
    report = reports("empty")
    assert set(report.level("warning")) == {"Nothing was run"}
    assert figures(report.html) == []
    report = reports("no-steps")
    assert set(report.level("warning")) == {"No steps"}
    assert {"last", "start", "temperature"} <= set(figures(report.html))


@pytest.mark.parametrize("name", ["healthy", "carried"])
def test_any_file_may_be_missing_or_garbage(reports, tmp_path: Path, name: str) -> None:
    """A report is made of what is left, and names the file that cannot be read."""
    source = reports(name).folder
    files = [path for path in source.iterdir() if path.name != "report.html"]
    for victim in files:
        for content in (
            None,
            b"",
            b"\x00\xff garbage\n1 2 x\n3 y\n",
            victim.read_bytes()[: victim.stat().st_size // 2],
        ):
            folder = tmp_path / "victim"
            folder.mkdir(exist_ok=True)
            for path in files:
                (folder / path.name).write_bytes(path.read_bytes())
            if content is None:
                (folder / victim.name).unlink()
            else:
                (folder / victim.name).write_bytes(content)
            run = collect_run(folder)
            findings = judge_run(run)
            if content is not None and b"garbage" in content and victim.name in run.files:
                inputs = ("CONTROL", "FIELD", "CONFIG", "REVCON", "REVBEADS")  # not needed beside a checkpoint
                assert f"File {victim.name}" in [one.subject for one in findings] or victim.name in inputs


def test_output_alone_makes_a_page(reports, tmp_path: Path) -> None:
    folder = tmp_path / "alone"
    for name in ("OUTPUT", "STATIS"):
        folder.mkdir(exist_ok=True)
        (folder / name).write_bytes((reports("healthy").folder / name).read_bytes())
        path, findings = write_report(folder)
        assert "System" in path.read_text(encoding="utf-8")
        assert "Run incomplete" not in [one.subject for one in findings]


def test_folders_apart(tmp_path: Path) -> None:
    """Output files in one folder, input files in another."""
    source = run_folder(tmp_path / "inputs", {"data_dump_frequency": "0 steps", "io_file_revive": "NONE"})
    run_scene(load(source), tmp_path / "outputs")
    assert collect_run(tmp_path / "outputs").scene is None
    run = collect_run(tmp_path / "outputs", source)
    assert run.scene is not None
    assert run.asked_steps == run.done_steps == 40


def test_continued_run_counts_all_steps(tmp_path: Path) -> None:
    scene = load(run_folder(tmp_path))
    run_scene(scene, tmp_path, steps=20)
    run_scene(scene, tmp_path, steps=60, checkpoint=tmp_path / "REVIVE")
    run = collect_run(tmp_path)
    assert run.log is not None
    assert run.log.starts == (0, 20)
    assert run.asked_steps == run.done_steps == 60


def test_text_of_files_is_no_markup(tmp_path: Path) -> None:
    title = "<script>alert('x')</script> & <b>"
    scene = load(run_folder(tmp_path, {"title": title}))
    run_scene(scene, tmp_path)
    path, _ = write_report(tmp_path)
    html = path.read_text(encoding="utf-8")
    assert "<script" not in html
    assert "<b>" not in html
    assert "&lt;script&gt;" in html


def test_folder_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such folder"):
        collect_run(tmp_path / "nowhere")


def test_missing_packages_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "jinja2", None)
    with pytest.raises(InputError, match=r"pip install 'pydlpoly\[report\]'"):
        write_report(tmp_path)


def test_report_is_the_same_each_time(reports, tmp_path: Path) -> None:
    texts = []
    for k in range(2):
        path, _ = write_report(reports("healthy").folder, tmp_path / f"{k}.html")
        texts.append(re.sub(r"written [\d-]+ [\d:]+", "", path.read_text(encoding="utf-8")))
    assert texts[0] == texts[1]


def test_energies_that_are_not_numbers_are_said(reports, tmp_path: Path) -> None:
    text = (reports("healthy").folder / "STATIS").read_text()
    value = f"{read_statistics(reports('healthy').folder / 'STATIS')['pressure'][-1]:.6E}"
    assert value in text
    (tmp_path / "STATIS").write_text(text.replace(value, "NaN".rjust(len(value))))
    path, findings = write_report(tmp_path)
    assert "Not a number" in [one.subject for one in findings]
    assert np.isfinite(path.stat().st_size)


def test_any_name_of_a_species_makes_a_page(tmp_path: Path) -> None:
    """Names of figures hold those of species, which may hold signs that no id can."""
    scene = load(run_folder(tmp_path, {"map_frequency": "10 steps", "map_bins": "[ 3 3 ]"}))
    run_scene(scene, tmp_path)
    text = (tmp_path / "MAP").read_text()
    (tmp_path / "MAP").write_text(text.replace("density_A", 'density_A"+(1)').replace("density_B", "density_<b>"))
    html = write_report(tmp_path)[0].read_text(encoding="utf-8")
    assert "map-number_density_A_22_2b_281_29" in figures(html)
    assert "<b>" not in html
    ids = re.findall(r'\bid="([^"]*)"', html)
    assert len(ids) == len(set(ids))
