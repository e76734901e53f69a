"""The ensemble directive of old-style CONTROL files, both ways."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from pydlpoly.formats.control_old_line import Line
from pydlpoly.formats.keywords import KEYWORDS
from pydlpoly.formats.records import Setting

_PAIRS = {
    # thermostat: its new-style name and the keywords of the numbers after it, without and with a barostat
    "evans": ("evans", (), ()),
    "lang": ("langevin", ("ensemble_thermostat_friction",), ("ensemble_barostat_friction",)),
    "ander": ("andersen", ("ensemble_thermostat_coupling", "ensemble_thermostat_softness"), ()),
    "ber": ("berendsen", ("ensemble_thermostat_coupling",), ("ensemble_barostat_coupling",)),
    "hoover": ("hoover", ("ensemble_thermostat_coupling",), ("ensemble_barostat_coupling",)),
    "nose": ("hoover", ("ensemble_thermostat_coupling",), ("ensemble_barostat_coupling",)),
    "mtk": ("mtk", ("ensemble_thermostat_coupling",), ("ensemble_barostat_coupling",)),
    "gst": ("gentle", ("ensemble_thermostat_coupling", "ensemble_thermostat_friction"), ()),
    "gentle": ("gentle", ("ensemble_thermostat_coupling", "ensemble_thermostat_friction"), ()),
}
_ORDERS = tuple(name for name in KEYWORDS["ensemble_dpd_order"].options if name != "off")
_DPD_ORDERS = {
    **{"dpds0": "zeroth", "dpds1": "first", "dpds2": "second", "s0": "zeroth", "s1": "first", "s2": "second"},
    **{"lowe": "lowe-andersen", "stoyanov": "stoyanov-groot"},
    **{name: name for name in _ORDERS},
}
_WITH_BAROSTAT = ("langevin", "berendsen", "hoover", "mtk")


def read_ensemble(line: Line) -> None:
    """Read ``ensemble nve``, ``ensemble nvt dpds1 [drag]``, ``ensemble npt hoover f f`` and so on."""
    ensemble = line.choose("ensemble", {name: name for name in ("nve", "nvt", "npt", "nst", "pmf")})
    line.put("ensemble", ensemble)
    if ensemble in ("nve", "pmf"):
        return
    if ensemble == "nvt" and _read_dpd(line):
        return
    if line.take("ttm", "inhomo"):
        raise line.error("asks for the two-temperature model, which is not modelled")
    barostat = ensemble != "nvt"
    known = {
        key: key for key, (name, _, _) in _PAIRS.items() if (name in _WITH_BAROSTAT if barostat else name != "mtk")
    }
    dpd = () if barostat else ("dpds1", "dpds2", "mdvv")
    method, alone, with_barostat = _PAIRS[line.choose(f"method of {ensemble}", known, dpd)]
    line.put("ensemble_method", method)
    for keyword in alone + (with_barostat if barostat else ()):
        line.put_number(keyword)
    if ensemble == "nst":
        read_cell_constraint(line)


def _read_dpd(line: Line) -> bool:
    separate = line.peek() == "dpd"
    if separate:
        line.position += 1
    order = _DPD_ORDERS.get(line.peek())
    if order is None:
        if separate:
            raise line.error(
                "dpd must be followed by s1, s2, mdvv or another name of ensemble_dpd_order", line.raw() or None
            )
        return False
    line.position += 1
    line.put("ensemble_method", "dpd")
    line.put("ensemble_dpd_order", order)
    if line.peek():
        drag = float(line.value("ensemble_dpd_drag"))
        if drag < 0.0:
            line.warn(f"the drag {drag:g} is taken without its sign, as in DL_POLY")
        line.put("ensemble_dpd_drag", abs(drag))
    return True


def read_cell_constraint(line: Line) -> None:
    """Read what the edges of an nst cell do: area, tension f, orthorhombic, each perhaps with semi."""
    if line.take("area"):
        line.put("ensemble_semi_isotropic", "area")
    elif line.take("tens"):
        line.put("ensemble_semi_isotropic", "tension")
        line.put_number("ensemble_tension")
        if line.take("semi"):
            line.put("ensemble_semi_orthorhombic", True)
    elif line.take("orth"):
        line.put("ensemble_semi_isotropic", "orthorhombic")
        if line.take("semi"):
            line.put("ensemble_semi_orthorhombic", True)


_WRITTEN = {name: (key, alone, more) for key, (name, alone, more) in reversed(_PAIRS.items())}
_DPD_WORDS = {name: name for name in _ORDERS} | {"zeroth": "dpds0", "first": "dpds1", "second": "dpds2"}


def write_ensemble(settings: Mapping[str, Setting], number: Callable[[str], str]) -> tuple[str, tuple[str, ...]]:
    """Return the ensemble directive and the keywords it stands for.

    Args:
        settings: all settings by keyword.
        number: returns a keyword's number in the old style's unit, 0 when it is not given.
    """
    values = {keyword: setting.value for keyword, setting in settings.items()}
    ensemble, method = str(values["ensemble"]), str(values.get("ensemble_method", ""))
    used = ["ensemble"]
    words = ["ensemble", ensemble]
    order = str(values.get("ensemble_dpd_order", ""))
    if ensemble == "nvt" and method == "dpd" and order in _DPD_WORDS:
        used += ["ensemble_method", "ensemble_dpd_order"]
        words.append(_DPD_WORDS[order])
        if "ensemble_dpd_drag" in values:
            words.append(number("ensemble_dpd_drag"))
    elif ensemble in ("nvt", "npt", "nst") and method in _WRITTEN:
        used.append("ensemble_method")
        key, alone, more = _WRITTEN[method]
        words += [key, *(number(keyword) for keyword in alone + (more if ensemble != "nvt" else ()))]
    constraint = str(values.get("ensemble_semi_isotropic", "off"))
    if ensemble == "nst" and constraint != "off":
        used += ["ensemble_semi_isotropic", "ensemble_semi_orthorhombic"]
        words.append(constraint)
        if constraint == "tension":
            words.append(number("ensemble_tension"))
        if values.get("ensemble_semi_orthorhombic") and constraint != "area":
            words.append("semi")
    return " ".join(words), tuple(used)
