"""CONTROL in DL_MESO's dialect: what each directive becomes, and what is refused, with exact messages."""

from __future__ import annotations

from pathlib import Path

import pytest

from pydlpoly.errors import InputError
from pydlpoly.formats.control import looks_like_dl_meso, parse_control, read_control, value_in, write_control
from pydlpoly.formats.dl_meso_control import _DIRECTIVES
from pydlpoly.formats.records import Control, Remark, Setting

HEAD = "a run\nvolume 1000.0\ntemperature 1.0\ntimestep 0.01\nsteps 100\nensemble nvt mdvv\n"
FOLDERS = [*(f"amphiphile-{k}" for k in (1, 2, 3, 4)), "lipid", "mixing", "phase-separation"]


def parsed(lines: str = "", lenient: bool = False) -> Control:
    return parse_control(f"{HEAD}{lines}\nfinish\n", lenient=lenient)


def setting(lines: str, keyword: str) -> Setting:
    found = parsed(lines).get(keyword)
    assert found is not None
    return found


def message(lines: str, lenient: bool = False) -> str:
    with pytest.raises(InputError) as caught:
        parsed(lines, lenient)
    return str(caught.value)


@pytest.mark.parametrize("folder", FOLDERS)
def test_public_inputs_use_every_line(shared: Path, folder: str) -> None:
    """Every directive of the file has become a setting, a field or a remark on its line."""
    path = shared / "inputs" / "dl_meso" / folder / "CONTROL"
    control = read_control(path)
    assert control.meso is not None
    lines = path.read_text().split("\n")
    written = {n for n, line in enumerate(lines, 1) if n > 1 and line.split() and line.split()[0] != "finish"}
    used = {one.line for one in control.settings} | {one.line for one in control.remarks}
    assert used | {control.meso.volume_line} == written
    assert not control.warnings


def test_a_file_as_settings(shared: Path) -> None:
    control = read_control(shared / "inputs/dl_meso/amphiphile-1/CONTROL")
    assert control.title == "DL_MESO amphiphile mesophase example"
    assert {s.keyword: (s.value, s.unit, s.line) for s in control} == {
        "temperature": (1.0, "dpd_temp", 4),
        "cutoff": (1.0, "dpd_l", 5),
        "timestep": (0.02, "dpd_t", 8),
        "time_run": (50000, "steps", 9),
        "time_equilibration": (10000, "steps", 10),
        "rescale_frequency": (1000, "steps", 11),
        "traj_start": (10000, "steps", 12),
        "traj_calculate": (True, None, 12),
        "traj_interval": (1000, "steps", 12),
        "traj_key": ("pos", None, 12),
        "stats_frequency": (1000, "steps", 13),
        "stack_size": (100, "steps", 14),
        "print_frequency": (100, "steps", 15),
        "time_job": (7200.0, "s", 16),
        "time_close": (10.0, "s", 17),
        "ensemble": ("nvt", None, 19),
        "ensemble_method": ("dpd", None, 19),
        "ensemble_dpd_order": ("mdvv", None, 19),
        "io_file_output": ("SCREEN", None, 21),
    }
    assert control.meso is not None
    assert control.meso.edges == (10.0, 10.0, 20.0)
    assert control.remarks == (Remark("ignored", "boundary halo 2.0: pydlpoly sizes its link cells itself", 6),)


def test_the_settings_are_a_new_style_file(shared: Path) -> None:
    """Written in the new style, they read back as the same settings."""
    for folder in FOLDERS:
        control = read_control(shared / "inputs/dl_meso" / folder / "CONTROL")
        again = parse_control(write_control(control))
        assert again.settings == control.settings
        assert value_in(again, "temperature") == pytest.approx(1 / 0.831451115, rel=1e-15)


@pytest.mark.parametrize(
    ("line", "edges"),
    [
        ("volume 1000.0", (10.0, 10.0, 10.0)),
        ("volume 1000.0 0.0 0.0", None),
        ("volume 10 8 6.5", (10.0, 8.0, 6.5)),
        ("vol 1.0d3", (10.0, 10.0, 10.0)),
        ("volume 16384.0", (16384.0 ** (1 / 3),) * 3),
    ],
)
def test_volume(line: str, edges: tuple[float, float, float] | None) -> None:
    """One number is the volume of a cube, three are edges; 1000 has the edge 10 to the last bit."""
    text = HEAD.replace("volume 1000.0", line) + "finish\n"
    if edges is None:
        with pytest.raises(InputError, match="the box must have a volume above 0"):
            parse_control(text, dl_meso=True)
        return
    meso = parse_control(text, dl_meso=True).meso
    assert meso is not None
    assert meso.edges == edges


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("nvt mdvv", {"ensemble_dpd_order": "mdvv"}),
        ("nvt dpdvv", {"ensemble_dpd_order": "dpdvv"}),
        ("nvt dpds0", {"ensemble_dpd_order": "zeroth"}),
        ("nvt dpds1", {"ensemble_dpd_order": "first"}),
        ("nvt dpds2", {"ensemble_dpd_order": "second"}),
        ("nvt lowe", {"ensemble_dpd_order": "lowe-andersen"}),
        ("nvt peters", {"ensemble_dpd_order": "peters"}),
        ("nvt stoyanov 0.25", {"ensemble_dpd_order": "stoyanov-groot", "ensemble_dpd_coupling": 0.25}),
        (
            "npt mdvv langevin 2.0 0.5",
            {"ensemble": "npt", "ensemble_barostat_coupling": 2.0, "ensemble_barostat_friction": 0.5},
        ),
        (
            "nst stoyanov 0.3 langevin 2.0 0.5 tension 1.5 semi",
            {
                "ensemble": "nst",
                "ensemble_dpd_coupling": 0.3,
                "ensemble_semi_isotropic": "tension",
                "ensemble_tension": 1.5,
                "ensemble_semi_orthorhombic": True,
            },
        ),
    ],
)
def test_ensembles(words: str, expected: dict[str, object]) -> None:
    control = parse_control(HEAD.replace("nvt mdvv", words) + "finish\n")
    found = {one.keyword: one.value for one in control}
    assert found["ensemble_method"] == "dpd"
    assert expected.items() <= found.items()


@pytest.mark.parametrize(
    ("line", "keyword", "value", "unit"),
    [
        ("rcut 1.5", "cutoff", 1.5, "dpd_l"),
        ("equilibration 5", "time_equilibration", 5, "steps"),
        ("scale every 7", "rescale_frequency", 7, "steps"),
        ("scale 7", "rescale_frequency", 7, "steps"),
        ("stats 4", "stats_frequency", 4, "steps"),
        ("ndump 500", "data_dump_frequency", 500, "steps"),
        ("seed 12345", "random_seed", (12345,), None),
        ("densvar 20.0", "density_variance", 20.0, "%"),
        ("nfold 2 1 1", "nfold", (2, 1, 1), None),
        ("no index", "ignore_config_indices", True, None),
        ("no electrostatics", "coul_method", "off", None),
        ("pressure 23.7", "pressure_hydrostatic", 23.7, "dpd_p"),
        ("trajectory 5 10 1", "traj_key", "pos-vel", None),
        ("trajectory 5 10 7", "traj_key", "pos-vel-force", None),
        ("trajectory 5", "traj_calculate", False, None),
        ("restart", "restart", "continue", None),
        ("ewald sum 0.5 4 5 6", "spme_kvec", (4, 5, 6), None),
        ("spme precision 1e-5", "spme_precision", 1e-5, None),
        ("bjerrum length 1.1", "coul_bjerrum_length", 1.1, "dpd_l"),
        ("mxshak 300", "shake_max_iter", 300, None),
        ("shake tolerance 1e-7", "shake_tolerance", 1e-7, "dpd_l"),
        ("TEMPERATURE 2.0", "temperature", 2.0, "dpd_temp"),
    ],
)
def test_directives(line: str, keyword: str, value: object, unit: str | None) -> None:
    found = setting(line, keyword)
    assert (found.value, found.unit, found.line) == (value, unit, 7)


def test_the_last_of_two_lines_counts_and_is_told() -> None:
    control = parsed("temperature 1.5\n")
    assert value_in(control, "temperature") == pytest.approx(1.5 / 0.831451115)
    told = "CONTROL:7: temperature was given on line 3 already; the last line counts, as in DL_MESO"
    assert control.warnings == (told,)


def test_a_trajectory_from_0_begins_after_the_equilibration() -> None:
    control = parsed("trajectory 0 10\nequilibration steps 40\n")
    assert control.get("traj_start") == Setting("traj_start", 40, "steps")
    assert control.remarks == (
        Remark("choice", "trajectory 0: HISTORY begins after the equilibration, as in DL_MESO", 7),
    )


def test_fields_that_no_keyword_holds() -> None:
    meso = parsed("no config\nconf origin\ncutoff 1.25\nthermostat cutoff 1.0\nelectrostatic cutoff 3.0\n").meso
    assert meso is not None
    assert (meso.without_config, meso.corner_origin) == (True, True)
    assert (meso.cutoff, meso.drag_cutoff, meso.charge_cutoff) == (1.25, 1.0, 3.0)


def test_what_has_no_effect_is_told() -> None:
    lines = "rhalo 2.0\nglobal bonds\nio write mpiio\nl_init\nopenmp critical\nprint partial\nmanybody cutoff 0.75\n"
    remarks = parsed(lines).remarks
    assert [one.line for one in remarks] == [*range(7, 14)]
    assert all(one.kind == "ignored" for one in remarks)


def test_no_ensemble_is_nvt_mdvv() -> None:
    control = parse_control(HEAD.replace("ensemble nvt mdvv\n", "") + "finish\n")
    assert [one.value for one in control if one.keyword.startswith("ensemble")] == ["nvt", "dpd", "mdvv"]
    assert control.remarks[-1].text == "no ensemble is given: nvt mdvv, as in DL_MESO"


def test_remarks_behind_a_comment_sign() -> None:
    assert setting("ndump 5 # often", "data_dump_frequency").value == 5


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        (
            "surface hard z",
            "CONTROL:7: 'surface': asks for walls or sheared faces, which is not read in DL_MESO's dialect; "
            "a new-style CONTROL has wall_method and shear_rate",
        ),
        (
            "frozen walls x",
            "CONTROL:7: 'frozen': asks for walls of frozen beads, which is not read in DL_MESO's dialect; "
            "a new-style CONTROL has wall_method",
        ),
        ("vacuum 2.0", "CONTROL:7: 'vacuum': asks for a vacuum gap, which is not read in DL_MESO's dialect"),
        (
            "permittivity constant 13.87",
            "CONTROL:7: 'permittivity': asks for a permittivity, which is not read in DL_MESO's dialect; "
            "give a bjerrum length",
        ),
        (
            "ensemble npt mdvv berendsen 1.0",
            "CONTROL:7: 'berendsen': the Berendsen barostat is not modelled; langevin is",
        ),
        (
            "ensemble nvt hoover 1.0",
            "CONTROL:7: 'hoover': is no method of nvt; known are mdvv, dpdvv, dpds0, dpds1, dpds2, lowe, "
            "peters, stoyanov",
        ),
        (
            "restart scale",
            "CONTROL:7: 'restart': scale asks to start from DL_MESO's export file, which cannot be read; use a CONFIG",
        ),
        ("seed -5", "CONTROL:7: '-5': the seed must not be negative"),
        ("volume 10 10", "CONTROL:7: 'volume': takes one number, the volume of a cube, or three, the edges of the box"),
        ("volume 0.0", "CONTROL:7: '0.0': the box must have a volume above 0"),
        ("volume cube", "CONTROL:7: 'cube': a number is expected (global cutoff and range of the radial distribution)"),
        (
            "scale temperature every often",
            "CONTROL:7: 'often': a number is expected (interval of velocity scaling in equilibration; 0 or less = "
            "never)",
        ),
        ("no surface", "CONTROL:7: 'surface': is no word after no; known are conf, elec, ind"),
        ("config corner", "CONTROL:7: 'corner': is no word after config; known are orig, zero"),
        ("thermostat range 1.0", "CONTROL:7: 'thermostat': must be followed by cutoff and the range of all drags"),
        ("stacks 100 deep", "CONTROL:7: 'deep': is left over after stack size; a remark must begin with # or !"),
        (
            "tmperature 1.0",
            "CONTROL:7: 'tmperature': is no directive of DL_MESO's CONTROL; did you mean "
            "temperature, scale temperature every?",
        ),
        ("padding 0.3", "CONTROL:7: 'padding': is no directive of DL_MESO's CONTROL"),
    ],
)
def test_refusals(lines: str, expected: str) -> None:
    assert message(lines) == expected


@pytest.mark.parametrize("directive", ["temperature", "timestep", "steps"])
def test_required_directives(directive: str) -> None:
    text = "\n".join(line for line in HEAD.split("\n") if not line.startswith(directive)) + "finish\n"
    with pytest.raises(InputError) as caught:
        parse_control(text)
    assert str(caught.value).startswith(f"CONTROL:1: '{directive}': is missing: a CONTROL of DL_MESO must give it")


def test_finish_is_required_unless_lenient() -> None:
    with pytest.raises(InputError, match="'finish': is missing at the end of this CONTROL of DL_MESO"):
        parse_control(HEAD)
    assert parse_control(HEAD, lenient=True).warnings[0].startswith("CONTROL:6: 'finish'")


def test_lenient_keeps_unknown_directives_as_warnings() -> None:
    control = parsed("tmperature 1.0\nstack size 100 deep", lenient=True)
    assert [warning.split(":")[1] for warning in control.warnings] == ["7", "8"]


def test_a_file_without_telling_directives_needs_to_be_told() -> None:
    text = HEAD.replace("volume 1000.0\n", "") + "finish\n"
    assert not looks_like_dl_meso(text)
    assert parse_control(text).meso is None
    assert parse_control(text, dl_meso=True).meso is not None


def test_a_new_style_file_stays_one() -> None:
    text = "title t\ntemperature 1.0 K\n"
    assert parse_control(text, dl_meso=True).meso is None


def test_the_page_has_every_directive() -> None:
    page = (Path(__file__).parents[2] / "docs" / "dl-meso.md").read_text(encoding="utf-8")
    table = page.split("## CONTROL")[1].split("\n\n")[2]
    words = {"io": "io write", "no": "no config", "ensemble": "ensemble nvt", "print every": "print every"}
    for name, _ in _DIRECTIVES.values():
        assert f"`{words.get(name, name)}" in table, name
