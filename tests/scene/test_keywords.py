"""No keyword of CONTROL can be read and forgotten: each one is used, noted or refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pydlpoly.errors import SceneError
from pydlpoly.formats.config import parse_config
from pydlpoly.formats.control import parse_control
from pydlpoly.formats.control_values import parse_setting
from pydlpoly.formats.field import parse_field
from pydlpoly.formats.keywords import KEYWORDS
from pydlpoly.scene import resolve
from pydlpoly.scene.settings import Settings
from pydlpoly.units import DIMENSIONS

NVE = {"ensemble": "nve", "ensemble_method": None, "ensemble_dpd_order": None}
REPORTS = {f"{name}_calculate": "on" for name in ("rdf", "traj", "zden", "vaf", "msd")}


def is_used(row):
    return row.effect == "used" or "used" in row.option_effects.values()


@pytest.fixture
def readings(monkeypatch):
    """Every Settings object that resolve makes."""
    made = []

    class Watched(Settings):
        def __init__(self, control):
            super().__init__(control)
            made.append(self)

    monkeypatch.setitem(resolve.__globals__, "Settings", Watched)
    return made


def test_every_used_keyword_is_asked_for(make, readings):
    make(control=REPORTS).scene()
    make(control={**NVE, **REPORTS}).scene()
    orders = [name for name in KEYWORDS["ensemble_dpd_order"].options if name not in ("mdvv", "off")]
    for order in orders:
        make(control={"ensemble_dpd_order": order}).scene()
    for method, keyword in (("langevin", "friction"), ("berendsen", "coupling"), ("hoover", "coupling")):
        unit = "dpd_t^-1" if keyword == "friction" else "dpd_t"
        number = {f"ensemble_thermostat_{keyword}": f"1 {unit}"}
        make(control={"ensemble_method": method, "ensemble_dpd_order": None, **number}).scene()
    make(control={"temperature_times": "[ 0 1 ] dpd_t", "temperature_values": "[ 1 2 ] dpd_temp"}).scene()
    make(control={"temperature_amplitude": "0.5 dpd_temp", "temperature_period": "1 dpd_t"}).scene()
    piston = {"ensemble": "nst", "ensemble_barostat_friction": "1 dpd_t^-1"}
    make(control={**piston, "ensemble_semi_isotropic": "tension", "ensemble_tension": "1 dpd_f/dpd_l"}).scene()
    make(atoms=("A 1.0 0.0 2", "B 2.0 0.0"), counts=(2, 2), inside="constraints 1\n1 2 0.9").scene()
    make(control={"wall_method": "soft", "wall_strength": "[ 25 ] dpd_f"}).scene()
    charged = {"atoms": ("A 1.0 1.0", "B 1.0 -1.0")}
    bjerrum = {"coul_bjerrum_length": "1 dpd_l"}
    smearing = {"charge_smearing_method": "slater", "charge_smearing_length": "1 dpd_l"}
    make(control={"coul_method": "spme", **bjerrum, **smearing}, **charged).scene()
    make(
        control={"coul_method": "spme", **bjerrum, "spme_alpha": "1 dpd_l^-1", "spme_kvec": "[ 8 8 8 ]"}, **charged
    ).scene()
    make(control={"coul_method": "reaction_field", **bjerrum}, **charged).scene()
    make(control={**REPORTS, "traj_format": "[ extxyz ]"}).scene()
    make(vdw=[f"{pair} mdpd -40 25 1 0.75 4.5" for pair in ("A A", "A B", "B B")]).scene()
    consumed = set().union(*(settings.consumed for settings in readings))
    used = {row.keyword for row in KEYWORDS.values() if is_used(row)}
    assert len(readings) == 15 + len(orders)
    assert used - consumed == set()
    assert consumed - used == set()  # nothing that the table calls ignored or refused is read


def values_of(row):
    """Texts to try after a keyword: every option, a switch both ways, a number that is not the default."""
    if row.kind == "option":
        return row.options
    if row.kind == "bool":
        return ("on", "off")
    if row.kind == "string":
        return ("name",)
    unit = "" if row.dimension in ("number", "integers", "any") else DIMENSIONS[row.dimension][0]
    unit = "steps" if row.dimension == "steps" else unit
    number = "3" if row.kind in ("int", "steps") or row.dimension == "integers" else "0.75"
    return (f"[ {' '.join([number] * (row.length or 2))} ] {unit}" if row.kind == "vector" else f"{number} {unit}",)


ALL_VALUES = [(row.keyword, text) for row in KEYWORDS.values() for text in values_of(row)]


def is_accounted_for(scene, settings, keyword):
    noted = any(keyword in note.text and note.where == "CONTROL:77" for note in scene.notes)
    return noted or keyword == "coul_method" or (keyword in settings.consumed and is_used(KEYWORDS[keyword]))


PISTON = {"ensemble": "nst", "ensemble_semi_isotropic": "tension", "ensemble_barostat_friction": "1 dpd_t^-1"}


@pytest.mark.parametrize("ensemble", [{}, NVE, PISTON], ids=["dpd", "nve", "nst"])
def test_every_setting_is_used_noted_or_refused(make, readings, ensemble):
    case = make(control=ensemble)
    control = parse_control(case.control_text())
    field, config = parse_field(case.field_text()), parse_config(case.config_text())
    forgotten = []
    for keyword, text in ALL_VALUES:
        setting = parse_setting(KEYWORDS[keyword], text, line=77).setting
        others = tuple(s for s in control if s.keyword != keyword)
        try:
            scene = resolve(replace(control, settings=(*others, setting)), field, config)
        except SceneError as error:
            blamed = (error.word, error.line) == (keyword, 77)
        else:
            blamed = is_accounted_for(scene, readings[-1], keyword)
        if not blamed:
            forgotten.append(f"{keyword} {text}")
    assert forgotten == []
    assert len(readings) == len(ALL_VALUES) > 350


def test_refused_keyword_at_its_default_is_noted_as_switched_off(make):
    scene = make(control={"replay": "off"}).scene()
    assert ("ignored", "replay off: it is switched off", "CONTROL:10") in [
        (n.kind, n.text, n.where) for n in scene.notes
    ]


def test_setting_without_effect_in_this_scene_is_noted(make):
    scene = make(control={**NVE, "ensemble_dpd_drag": "2.0 dpd_m/dpd_t"}).scene()
    texts = [n.text for n in scene.notes if n.kind == "ignored"]
    assert "ensemble_dpd_drag 2 dpd_m/dpd_t: nothing in this scene uses it" in texts
