"""OUTPUT: the blocks of DL_POLY, what dlpoly-py makes of them, kills and restarts."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from pydlpoly.formats.output import OutputWriter, RunSummary

with warnings.catch_warnings():  # dlpoly-py asks for NumPy's version in a way that is deprecated
    warnings.simplefilter("ignore", DeprecationWarning)
    from dlpoly.output import Output

VALUES = np.arange(1.0, 40.0) * 1.5
RULE = "-" * 130
HEADER = [
    "         step     eng_tot temp_tot[K]     eng_cfg     eng_src     eng_cou     eng_bnd     eng_ang     eng_dih"
    "     eng_tet",
    "     time[ps]      eng_pv temp_rot[K]     vir_cfg     vir_src     vir_cou     vir_bnd     vir_ang     vir_con"
    "     vir_tet",
    "     cpu  [s]      volume temp_shl[K]     eng_shl     vir_shl    alpha[o]     beta[o]    gamma[o]     vir_pmf"
    "       press",
]


def a_summary(**changes: object) -> RunSummary:
    given: dict[str, object] = {
        "steps": 2000,
        "time": 20.0,
        "averaged_steps": 1500,
        "averaged_time": 15.0,
        "elapsed": 12.5,
        "loop_seconds": 10.0,
        "averages": VALUES,
        "fluctuations": VALUES / 100.0,
        "pressure_parts": {"kinetic": np.diag([1.0, 2.0, 3.0]), "drag": np.zeros((3, 3))},
        "diffusion": {"W": (2.25, 4.5), "HEADBEAD": (0.5, 1.25)},
        "warnings": ("seed 17 was drawn",),
        "timings": {"forces": 8.0},
    }
    return RunSummary(**{**given, **changes})  # type: ignore[arg-type]


def test_the_banner_names_pydlpoly_and_says_it_is_not_dl_poly(tmp_path: Path) -> None:
    with OutputWriter(tmp_path / "OUTPUT", "0.1.0", "soft beads") as output:
        output.text("units kJ/mol\n")
    lines = (tmp_path / "OUTPUT").read_text().split("\n")
    assert lines[0] == lines[5] == lines[7] == RULE
    assert lines[1] == "pydlpoly 0.1.0"
    assert "An independent program: not DL_POLY itself" in lines[2]
    assert lines[4] == "title: soft beads"
    assert lines[6] == "units kJ/mol"


def test_a_block_has_dl_poly_s_columns(tmp_path: Path) -> None:
    with OutputWriter(tmp_path / "OUTPUT", "0.1.0") as output:
        output.block(20, 0.2, 1.25, VALUES, -VALUES)
    lines = (tmp_path / "OUTPUT").read_text().split("\n")[6:]
    assert lines[0] == lines[4] == lines[12] == RULE
    assert lines[1:4] == HEADER
    assert lines[5].startswith("           20  1.5000E+00  3.0000E+00")
    assert lines[6].startswith("      0.20000  1.5000E+01")
    assert lines[7].startswith("        1.250  2.8500E+01")
    assert lines[7].endswith("  4.0500E+01")
    assert lines[8] == ""
    assert lines[9].startswith("     rolling  -1.5000E+00")
    assert lines[10].startswith("     averages -1.5000E+01")
    assert lines[11].startswith(" " * 13 + " -2.8500E+01")
    assert {len(line) for line in lines[5:8] + lines[9:12]} == {13 + 9 * 12}


def test_the_header_comes_back_every_eight_print_outs(tmp_path: Path) -> None:
    with OutputWriter(tmp_path / "OUTPUT", "0.1.0") as output:
        for step in range(17):
            output.block(step, 0.0, 0.0, VALUES, VALUES)
    assert (tmp_path / "OUTPUT").read_text().count("eng_tot") == 3


def test_reduced_units_are_not_called_kelvin(tmp_path: Path) -> None:
    units = {"temperature_unit": "", "pressure_unit": "", "time_unit": ""}
    with OutputWriter(tmp_path / "OUTPUT", "0.1.0", **units) as output:
        output.block(0, 0.0, 0.0, VALUES, VALUES)
        output.summary(a_summary())
    text = (tmp_path / "OUTPUT").read_text()
    assert "temp_tot     eng_cfg" in text
    assert all(word not in text for word in ("[K]", "katm", "[ps]", " ps)"))


def test_too_few_numbers_are_refused(tmp_path: Path) -> None:
    with OutputWriter(tmp_path / "OUTPUT", "0.1.0") as output, pytest.raises(ValueError, match="27 quantities, not 5"):
        output.block(0, 0.0, 0.0, VALUES[:5], VALUES)


def test_dlpoly_py_reads_the_summary(tmp_path: Path) -> None:
    with OutputWriter(tmp_path / "OUTPUT", "0.1.0") as output:
        output.block(0, 0.0, 0.0, VALUES, VALUES)
        output.summary(a_summary())
    judge = Output(str(tmp_path / "OUTPUT"))
    assert (judge.steps, judge.time, judge.average_steps, judge.average_time) == (2000, 20.0, 1500, 15.0)
    means, spreads = np.array(list(judge.average.values())).T
    np.testing.assert_allclose(means, VALUES[:27], rtol=1e-4)
    np.testing.assert_allclose(spreads, VALUES[:27] / 100.0, rtol=1e-4)
    tensor = VALUES[28:37].reshape(3, 3)
    np.testing.assert_allclose(judge.pressure_tensor, tensor, rtol=1e-4)
    np.testing.assert_allclose(judge.pressure_tensor_rms, tensor / 100.0, rtol=1e-4)
    assert judge.pressure == pytest.approx(np.trace(tensor) / 3.0, rel=1e-4)
    assert judge.diffusion == {"W": (2.25, 4.5), "HEADBEAD": (0.5, 1.25)}
    assert (judge.run_time, judge.run_tps) == (10.0, 0.005)


def test_the_summary_says_everything_once(tmp_path: Path) -> None:
    with OutputWriter(tmp_path / "OUTPUT", "0.1.0") as output:
        output.summary(a_summary())
    text = (tmp_path / "OUTPUT").read_text()
    assert (
        "run terminated after 2000 steps ( 20.000 ps), final averages calculated over 1500 steps ( 15.000 ps)" in text
    )
    assert "of which kinetic  (katm)\n    1.0000E+00  0.0000E+00  0.0000E+00\n" in text
    assert "of which drag" in text
    assert text.count("  trace/3    2.0000E+00\n") == 1
    assert "Warnings of this run:\n  seed 17 was drawn\n" in text
    assert "time elapsed since job start:       12.500 sec" in text
    assert text.endswith(RULE + "\n")


def test_a_run_without_averages_says_so(tmp_path: Path) -> None:
    with OutputWriter(tmp_path / "OUTPUT", "0.1.0") as output:
        output.summary(a_summary(averaged_steps=0, steps=0, warnings=()))
    text = (tmp_path / "OUTPUT").read_text()
    assert "run terminated after 0 steps ( 20.000 ps), no averages were taken" in text
    assert "eng_tot" not in text
    assert "Warnings" not in text


@pytest.mark.parametrize("torn", ["", "           40  1.5", RULE[:50], RULE])
def test_continuing_goes_on_after_the_last_whole_piece(tmp_path: Path, torn: str) -> None:
    path = tmp_path / "OUTPUT"
    with OutputWriter(path, "0.1.0", "first") as output:
        output.block(20, 0.2, 1.0, VALUES, VALUES)
    whole = path.read_text()
    path.write_text(whole + torn)
    with OutputWriter(path, "0.1.0", "second", append=True) as output:
        assert output.resumed
        output.resume(20, "0.1.0")
        output.block(40, 0.4, 1.0, VALUES, VALUES)
    text = path.read_text()
    assert text.startswith(whole + "continues from step 20 with pydlpoly 0.1.0\n" + RULE + "\n" + RULE)
    assert text.count("title:") == 1
    assert text.count("eng_tot") == 2


def test_append_without_a_file_writes_the_banner(tmp_path: Path) -> None:
    with OutputWriter(tmp_path / "OUTPUT", "0.1.0", append=True) as output:
        assert not output.resumed
    assert (tmp_path / "OUTPUT").read_text().startswith(RULE + "\npydlpoly 0.1.0\n")
