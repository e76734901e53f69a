"""A gallery of broken CONTROL files: each with the whole message that its author gets to read."""

from __future__ import annotations

from pathlib import Path

import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.control import looks_like_dl_meso, parse_control, read_control

NEW_STYLE = [
    (
        "cutof 1.0 ang",
        "CONTROL:2: 'cutof': is no keyword of CONTROL; did you mean cutoff, vdw_cutoff?",
    ),
    (
        "presure_hydrostatic 1 katm",
        "CONTROL:2: 'presure_hydrostatic': is no keyword of CONTROL; did you mean pressure_hydrostatic?",
    ),
    (
        "steps 100",
        "CONTROL:2: 'steps': is no keyword of CONTROL; it is an old-style directive, and the file is in the new style",
    ),
    (
        "banana 3",
        "CONTROL:2: 'banana': is no keyword of CONTROL",
    ),
    (
        "cutoff 1.0 ang\ncutoff 2.0 ang",
        "CONTROL:3: 'cutoff': is given twice, first in line 2",
    ),
    (
        "title again",
        "CONTROL:2: 'title': is given twice",
    ),
    (
        "cutoff 1.0 ang or so",
        "CONTROL:2: 'or so': is left over after 'cutoff 1.0 ang'; one keyword, one value and one unit make a line",
    ),
    (
        "vdw_method direct fast",
        "CONTROL:2: 'fast': is left over after 'vdw_method direct'; one keyword, one value and one unit make a line",
    ),
    (
        "fixed_com on off",
        "CONTROL:2: 'off': is left over after 'fixed_com on'; one keyword, one value and one unit make a line",
    ),
    (
        "cutoff",
        "CONTROL:2: 'cutoff': a value is expected: cutoff <number> <unit: ang, nm, internal_l, dpd_l>",
    ),
    (
        "cutoff 1.0",
        "CONTROL:2: 'cutoff': a unit is needed after the number: cutoff <number> <unit: ang, nm, internal_l, dpd_l>",
    ),
    (
        "cutoff ten ang",
        "CONTROL:2: 'ten': a number is expected: cutoff <number> <unit: ang, nm, internal_l, dpd_l>",
    ),
    (
        "cutoff 1.0 K",
        "CONTROL:2: 'K': is no unit of length; examples: ang, nm, internal_l, dpd_l",
    ),
    (
        "cutoff 1.0 angs",
        "CONTROL:2: 'angs': is no unit word; did you mean ang, ns?",
    ),
    (
        "timestep 1 FS",
        "CONTROL:2: 'FS': is no unit word; did you mean fs? (prefixes are case-sensitive)",
    ),
    (
        "timestep 1 ang/",
        "CONTROL:2: 'ang/': is no unit: write words joined by '.' and '/', each with an optional whole power "
        "such as ^-1",
    ),
    (
        "temperature 1e999 K",
        "CONTROL:2: '1e999': a number is expected: temperature <number> <unit: K, dpd_temp>",
    ),
    (
        "impact_energy 1 keV",
        "CONTROL:2: 'keV': is no unit word; the electron-volt is e.V, with a prefix ke.V",
    ),
    (
        "timestep 1 s^99",
        "CONTROL:2: 's^99': has a power beyond 9",
    ),
    (
        "timestep 1 Ymol^9.Ymol^9",
        "CONTROL:2: 'Ymol^9.Ymol^9': is a unit beyond the range of numbers",
    ),
    (
        "time_run 1000",
        "CONTROL:2: 'time_run': a unit is needed after the number: time_run <number> <unit: steps, ps, fs>",
    ),
    (
        "time_run 10.5 steps",
        "CONTROL:2: '10.5': a whole number is expected",
    ),
    (
        "time_run 10 ang",
        "CONTROL:2: 'ang': is no unit of a number of steps; examples: steps, ps, fs",
    ),
    (
        "vdw_force_shift 1",
        "CONTROL:2: '1': vdw_force_shift is a switch and takes on or off (also y, n, yes, no, true, false)",
    ),
    (
        "vdw_force_shift maybe",
        "CONTROL:2: 'maybe': vdw_force_shift is a switch and takes on or off (also y, n, yes, no, true, false)",
    ),
    (
        "ensemble nvp",
        "CONTROL:2: 'nvp': is no option of ensemble, which takes nve, nvt, npt, nst, pmf; did you mean nvt, nve, npt?",
    ),
    (
        "ensemble_method hover",
        "CONTROL:2: 'hover': is no option of ensemble_method, which takes dpd, evans, langevin, andersen, "
        "berendsen, hoover, gentle, ttm, mtk; did you mean hoover, nose-hoover?",
    ),
    (
        "vdw_mix_method lorenz",
        "CONTROL:2: 'lorenz': is no option of vdw_mix_method, which takes off, lorentz-berthelot, "
        "fender-halsey, hogervorst, halgren, waldman-hagler, tang-toennies, functional; did you mean "
        "lorentz-berthelot?",
    ),
    (
        "random_seed 1 2 3",
        "CONTROL:2: 'random_seed': numbers in brackets are expected: random_seed [ <3 numbers> ]",
    ),
    (
        "random_seed [ 1 2 ]",
        "CONTROL:2: 'random_seed': 3 numbers are expected in the brackets, not 2",
    ),
    (
        "random_seed [ 1 2 3",
        "CONTROL:2: 'random_seed': numbers in brackets are expected: random_seed [ <3 numbers> ]",
    ),
    (
        "random_seed -1",
        "CONTROL:2: '-1': a seed is three whole numbers in brackets or one whole number from 0 to 18446744073709551615",
    ),
    (
        "random_seed [ 1 2 x ]",
        "CONTROL:2: 'x': a number is expected: random_seed [ <3 numbers> ]",
    ),
    (
        "pressure_tensor [ 1 2 3 4 5 6 ]",
        "CONTROL:2: 'pressure_tensor': a unit is needed after the number: pressure_tensor [ <6 numbers> ] "
        "<unit: katm, atm, GPa, internal_p, dpd_p>",
    ),
    (
        "random_seed [ 1 2 &",
        "CONTROL:2: '&': the file ends after a line that is to be continued",
    ),
    (
        "print_level 1.5",
        "CONTROL:2: '1.5': a whole number is expected",
    ),
    (
        "io_file_field",
        "CONTROL:2: 'io_file_field': a value is expected: io_file_field <text>",
    ),
    (
        "ensemble_method dpds1\nensemble_dpd_order first",
        "CONTROL:3: 'ensemble_dpd_order': is given twice, first in line 2",
    ),
]

OLD_STYLE = [
    (
        "steps ten",
        "CONTROL:2: 'ten': a number is expected (length of the run, equilibration included)",
    ),
    (
        "tmep 300",
        "CONTROL:2: 'tmep': is no directive of an old-style CONTROL; did you mean timestep, steps, mxstep?",
    ),
    (
        "steps",
        "CONTROL:2: 'steps': a number is expected after this directive (length of the run, equilibration included)",
    ),
    (
        "steps 10.5",
        "CONTROL:2: '10.5': a whole number is expected",
    ),
    (
        "timestep 1 fs",
        "CONTROL:2: 'fs': the old style takes this number in ps whatever unit follows it; convert the number",
    ),
    (
        "cutoff 10 and more",
        "CONTROL:2: 'and more': is left over after an old-style directive; a remark must begin with # or !",
    ),
    (
        "dump 10\ndump 20",
        "CONTROL:3: 'dump': gives data_dump_frequency a second time, first in line 2",
    ),
    (
        "time_run 10 steps",
        "CONTROL:2: 'time_run': is a new-style keyword in an old-style file; a new-style file begins with the "
        "word title",
    ),
    (
        "ensemble nvd",
        "CONTROL:2: 'nvd': is no ensemble; known are nve, nvt, npt, nst, pmf; did you mean nvt, nve?",
    ),
    (
        "ensemble nvt",
        "CONTROL:2: 'ensemble': a word is missing: method of nvt takes evans, lang, ander, ber, hoover, nose, "
        "gst, gentle, dpds1, dpds2, mdvv",
    ),
    (
        "ensemble nvt hover 1",
        "CONTROL:2: 'hover': is no method of nvt; known are evans, lang, ander, ber, hoover, nose, gst, gentle, "
        "dpds1, dpds2, mdvv; did you mean hoover?",
    ),
    (
        "ensemble nvt dpds10 4.5",
        "CONTROL:2: 'dpds10': is no method of nvt; known are evans, lang, ander, ber, hoover, nose, gst, gentle, "
        "dpds1, dpds2, mdvv; did you mean dpds1, dpds2?",
    ),
    (
        "ensemble nvt dpd s3",
        "CONTROL:2: 's3': dpd must be followed by s1, s2, mdvv or another name of ensemble_dpd_order",
    ),
    (
        "ensemble nvt hoover",
        "CONTROL:2: 'ensemble': a number is expected after this directive (relaxation time of berendsen and hoover)",
    ),
    (
        "ensemble nvt ttm 1 2 3",
        "CONTROL:2: 'ensemble': asks for the two-temperature model, which is not modelled",
    ),
    (
        "vdw mix arithmetic",
        "CONTROL:2: 'arithmetic': is no mixing rule; known are lore, fend, hoge, halg, wald, tang, func",
    ),
    (
        "no banana",
        "CONTROL:2: 'banana': is no word after no; known are vdw, elec, index, stric, topol, vafav, vom",
    ),
    (
        "vdw",
        "CONTROL:2: 'vdw': a word is missing: vdw option takes direct, shift, ewald, spme, mix",
    ),
    (
        "trajectory 0 1 7",
        "CONTROL:2: '7': is beyond the levels 0 to 3",
    ),
    (
        "tad\nunits kJ\nendtad",
        "CONTROL:2: 'tad': opens a block that ends with endtad; blocks of DL_POLY Classic are not modelled",
    ),
    (
        "&control\n&end",
        "CONTROL:2: '&control': is a Fortran namelist, which no DL_POLY 4 or 5 CONTROL has",
    ),
    (
        "pimd nhc nbeads=10",
        "CONTROL:2: 'pimd nhc nbeads=10': has the form key=value, which no DL_POLY 4 or 5 CONTROL has",
    ),
    (
        "ttm ncit 5",
        "CONTROL:2: 'ttm': asks for the two-temperature model, which is not modelled",
    ),
    (
        "io felid X",
        "CONTROL:2: 'felid': is no file of CONTROL's io directive; did you mean field, field_3, field_2?",
    ),
    (
        "integrator leapfrog",
        "CONTROL:2: 'integrator': asks for leapfrog, which is not modelled; DL_POLY 5 has velocity Verlet only",
    ),
    (
        "variable 3",
        "CONTROL:2: 'variable': must be followed by timestep",
    ),
    (
        "io field",
        "CONTROL:2: 'io': a text is expected after io field",
    ),
    (
        "qtip4pf",
        "CONTROL:2: 'qtip4pf': is no directive of an old-style CONTROL",
    ),
    (
        "pseudo thing 1 1",
        "CONTROL:2: 'thing': is no pseudo thermostat; known are langevin, gauss, direct",
    ),
    (
        "l_org 1 2 3",
        "CONTROL:2: 'l_org': asks for a shift of CONFIG's origin, which is not modelled",
    ),
    (
        "restart now",
        "CONTROL:2: 'now': is no restart; known are noscale, unscale, scale",
    ),
]


def _message(text: str, lenient: bool = False) -> str:
    with pytest.raises(InputError) as caught:
        parse_control(text, lenient=lenient)
    return str(caught.value)


@pytest.mark.parametrize(("lines", "message"), NEW_STYLE)
def test_new_style(lines: str, message: str) -> None:
    assert _message(f"title t\n{lines}\n") == message


@pytest.mark.parametrize(("lines", "message"), OLD_STYLE)
def test_old_style(lines: str, message: str) -> None:
    assert _message(f"a title\n{lines}\nfinish\n") == message


@pytest.mark.parametrize("text", ["", "  \n\n\t\n"])
def test_empty_file(text: str) -> None:
    assert _message(text) == "CONTROL: the file is empty; a CONTROL file begins with a title"


def test_old_style_without_its_end() -> None:
    assert _message("a title\nsteps 10\n\n") == "CONTROL:2: 'finish': is missing at the end of this old-style file"


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_control(tmp_path / "CONTROL")
    assert str(caught.value) == f"{tmp_path / 'CONTROL'}: cannot be read: No such file or directory"


def test_folder_instead_of_a_file(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_control(tmp_path)
    assert str(caught.value) == f"{tmp_path}: cannot be read: Is a directory"


def test_the_file_is_named_as_the_user_gave_it(tmp_path: Path) -> None:
    (tmp_path / "run.control").write_text("title t\n\ncutof 1.0 ang\n")
    with pytest.raises(InputError) as caught:
        read_control(str(tmp_path / "run.control"))
    error = caught.value
    assert (error.path, error.line, error.word) == (str(tmp_path / "run.control"), 3, "cutof")


@pytest.mark.parametrize("folder", ["amphiphile-1", "lipid", "mixing", "phase-separation"])
def test_dl_mesos_files_are_known_by_their_content(shared: Path, folder: str) -> None:
    text = (shared / "inputs" / "dl_meso" / folder / "CONTROL").read_text()
    assert looks_like_dl_meso(text)
    assert parse_control(text).meso is not None


def test_dl_polys_files_are_not_taken_for_dl_mesos() -> None:
    assert not looks_like_dl_meso("title volume\ntemperature 1 K\n")
    assert not looks_like_dl_meso("volume of a sphere\ntemp 1\nensemble nvt mdvv\nfinish\nvolume 10\n")


@pytest.mark.parametrize(
    ("text", "warning"),
    [
        ("title t\nbanana 3\n", "CONTROL:2: 'banana': is no keyword of CONTROL"),
        ("title t\ntitle again\n", "CONTROL:2: 'title': is given twice"),
        ("title t\npadding 1 ang\npadding 2 ang\n", "CONTROL:3: 'padding': is given twice, first in line 2"),
        (
            "title t\npadding 1 ang too\n",
            "CONTROL:2: 'too': is left over after 'padding 1.0 ang'; one keyword, one value and one unit make a line",
        ),
        ("a title\nensemble nve\nqtip4pf\nfinish\n", "CONTROL:3: 'qtip4pf': is no directive of an old-style CONTROL"),
        ("a title\nensemble nve\n", "CONTROL:2: 'finish': is missing at the end of this old-style file"),
        (
            "a title\nensemble nve\ndump 10\ndump 20\nfinish\n",
            "CONTROL:4: 'dump': gives data_dump_frequency a second time, first in line 3",
        ),
        (
            "a title\nensemble nve remark\nfinish\n",
            "CONTROL:2: 'remark': is left over after an old-style directive; a remark must begin with # or !",
        ),
    ],
)
def test_lenient_reading_warns_instead(text: str, warning: str) -> None:
    assert _message(text) == warning
    assert parse_control(text, lenient=True).warnings == (warning,)


def test_lenient_reading_takes_the_last_of_two() -> None:
    control = parse_control("title t\npadding 1 ang\npadding 2 ang\n", lenient=True)
    assert [(s.keyword, s.value) for s in control] == [("padding", 2.0)]


@pytest.mark.parametrize("text", ["title t\ncutoff ten ang\n", "a title\ntad\nendtad\nfinish\n", ""])
def test_lenient_reading_does_not_guess(text: str) -> None:
    assert _message(text, lenient=True) == _message(text)


def test_new_style_without_its_title_line_is_told_so() -> None:
    """The first line is then taken for an old-style title, and the second makes no sense as a directive."""
    hint = "; a file in the new style, which this one seems to be, begins with a line title <text>"
    without = "temperature 1.0 dpd_temp\nensemble nvt\nensemble_method dpd\ntime_run 10 steps\n"
    assert _message(without).endswith(hint)
    assert hint not in _message(without + "finish\n")
