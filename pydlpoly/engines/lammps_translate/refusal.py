"""Where a scene's numbers stand in its files, for refusals, and the parts of a scene that are known at all.

What is not listed here is refused as soon as it differs from its default: a part that is added to the scene is not
translated until someone adds it here and says what it becomes.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydlpoly.errors import InputError, SceneError
from pydlpoly.formats.control import read_control
from pydlpoly.scene.model import (
    Beads,
    Bonded,
    BondedTerm,
    DensityTerm,
    Dynamics,
    Electrostatics,
    Heat,
    HeatSource,
    HeatTerm,
    ManyBody,
    PairTerm,
    RunPlan,
    Scene,
)
from pydlpoly.scene.transport_terms import Reaction, Region, SpeciesFlux, SpeciesValue, Transport

_PLACE = re.compile(r"(?P<name>[^\s:;,]+):(?P<line>\d+)")


def _names(words: str) -> frozenset[str]:
    return frozenset(words.split())


KNOWN: dict[type, frozenset[str]] = {
    Scene: _names(
        "title units species beads cell imcon periodic pairs external cutoff vdw_cutoff dynamics run output "
        "degrees_of_freedom long_range_correction molecule_names molecule_counts field_units notes sources "
        "source_order source_cell bonded electrostatics many_body heat transport"
    ),
    Beads: _names("species mass charge frozen molecule positions velocities temperature heat_capacity concentrations"),
    Dynamics: _names(
        "integrator timestep thermal_energy prediction weight_exponent tolerance passes thermostat_mass "
        "thermostat_friction relaxation remove_drift"
    ),
    RunPlan: _names("steps equilibration_steps record_equilibration seed start checkpoint_file threads"),
    PairTerm: _names(
        "species law parameters cutoff force_shift drag drag_cutoff noise law_origin drag_origin explanation"
    ),
    Bonded: _names("terms excluded scaled scales coulomb_scaled coulomb_scales"),
    BondedTerm: _names("kind law parameters beads restraint molecule explanation"),
    Electrostatics: _names("method keyword shape length strength cutoff alpha permittivity counts order origins"),
    ManyBody: _names("kernel form repulsion strength powers terms explanation"),
    DensityTerm: _names("species height exponent range push"),
    Heat: _names("terms sources held reference viscous_heating scaled_repulsion explanation"),
    HeatTerm: _names("species conductivity range exponent weight conduction drag explanation"),
    HeatSource: _names("kind numbers rate explanation"),
    Transport: _names("species fluxes noise starts sources holds reactions"),
    SpeciesFlux: _names("species dissolved rate range exponent noise explanation"),
    SpeciesValue: _names("dissolved value region explanation"),
    Reaction: _names("rate reactants change species equation explanation"),
    Region: _names("kind numbers"),
}
"""The fields that are translated, or that say nothing about the motion."""

# The keyword of CONTROL behind a field, where it has another name.
_KEYWORDS = {
    "schedule": ("temperature_times", "temperature_amplitude", "temperature"),
    "barostat": ("ensemble",),
    "shear_rate": ("shear_rate",),
    "half_step_kinetic": ("ensemble_dpd_kinetic",),
    "prediction": ("ensemble_dpd_lambda",),
    "interval": ("ensemble_dpd_interval",),
    "transverse_drag": ("ensemble_dpd_transverse_drag",),
    "collision_rate": ("ensemble_dpd_rate",),
    "coupling": ("ensemble_dpd_coupling",),
    "precision": ("precision",),
    "rescale_every": ("rescale_frequency",),
    "regauss_every": ("regauss_frequency",),
    "force_cap": ("equilibration_force_cap",),
}


class Places:
    """Finds in the scene's files what is refused.

    Args:
        scene: as read from files, or made by a program; then refusals name no file.
    """

    def __init__(self, scene: Scene) -> None:
        self._sources = scene.sources

    def of_setting(self, *keywords: str) -> dict[str, Any]:
        """Return ``path``, ``line`` and ``word`` of the first of these keywords that CONTROL gives."""
        path = self._sources[0] if self._sources else ""
        if not path:
            return {}
        try:
            control = read_control(path, lenient=True)
        except InputError:
            return {"path": path}
        for keyword in keywords:
            setting = control.get(keyword)
            if setting is not None:
                return {"path": path, "line": setting.line or None, "word": keyword}
        return {"path": path}

    def of_text(self, explanation: str) -> dict[str, Any]:
        """Return ``path`` and ``line`` of the first place that a term's explanation names, as ``FIELD:12``."""
        found = _PLACE.search(explanation)
        if found is None:
            return {}
        name = found["name"]
        path = next((source for source in self._sources if Path(source).name == name), name)
        return {"path": path, "line": int(found["line"])}


def refusal(what: str, place: dict[str, Any], because: str = "") -> SceneError:
    """Return the error that says what LAMMPS is not given, and where it stands."""
    reason = f" ({because})" if because else ""
    return SceneError(f"{what} with the engine lammps{reason}; the native engine runs it", **place)


def refuse_unknown(scene: Scene, places: Places) -> None:
    """Raise SceneError for the first part of the scene that is not known here and is in use."""
    _refuse(scene, lambda name: places.of_text(_explanation(getattr(scene, name))))
    _refuse(scene.beads, lambda _name: {"path": scene.sources[1]} if len(scene.sources) > 1 else {})
    for part in (scene.dynamics, scene.run):
        _refuse(part, lambda name: places.of_setting(*_KEYWORDS.get(name, (name,))))
    for term in scene.pairs:
        if term.law != "tab":
            _refuse(term, lambda _name, text=term.explanation: places.of_text(text))  # type: ignore[misc]
    if scene.electrostatics is not None:
        _refuse(scene.electrostatics, lambda _name: places.of_setting("coul_method"))
    for model in (scene.many_body, scene.heat, scene.transport):
        _refuse_inside(model, places)


def _explanation(value: Any) -> str:
    """Return the first explanation in a part of the scene, its own or that of something in it."""
    text = getattr(value, "explanation", "")
    if text:
        return str(text)
    if dataclasses.is_dataclass(value):
        inside = tuple(getattr(value, field.name) for field in dataclasses.fields(value))
    else:
        inside = value if isinstance(value, tuple) else ()
    return next((found for one in inside if (found := _explanation(one))), "")


def _refuse_inside(part: Any, places: Places) -> None:
    """Refuse what is not known of a part of the scene and of the parts in it."""
    if type(part) not in KNOWN:
        return
    _refuse(part, lambda _name: places.of_text(_explanation(part)))
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        for one in value if isinstance(value, tuple) else (value,):
            _refuse_inside(one, places)


def _refuse(part: Any, place: Callable[[str], dict[str, Any]]) -> None:
    known = KNOWN[type(part)]
    for field in dataclasses.fields(part):
        if field.name in known:
            continue
        value = getattr(part, field.name)
        if field.default is not dataclasses.MISSING:
            default: Any = field.default
        elif field.default_factory is not dataclasses.MISSING:
            default = field.default_factory()
        else:
            default = None
        if value is default or (isinstance(value, (bool, int, float, str, tuple)) and value == default):
            continue
        shown = f" {value}" if isinstance(value, (int, float, str)) and not isinstance(value, bool) else ""
        raise refusal(f"{field.name.replace('_', ' ')}{shown} cannot be run", place(field.name))
