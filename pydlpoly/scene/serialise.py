"""A scene as plain arrays and JSON, so that a checkpoint can go on without the files the scene came from."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly import units
from pydlpoly.errors import InputError
from pydlpoly.scene import model, transport_terms

_CLASSES: dict[str, type[Any]] = {
    cls.__name__: cls
    for cls in (
        model.Note,
        model.Beads,
        model.PairTerm,
        model.DensityTerm,
        model.ManyBody,
        model.ExternalTerm,
        model.Walls,
        model.BondedTerm,
        model.Bonded,
        model.Constraints,
        model.Electrostatics,
        model.HeatTerm,
        model.HeatSource,
        model.Heat,
        model.Schedule,
        model.Barostat,
        model.Dynamics,
        model.RunPlan,
        model.ProfilePlan,
        model.CorrelationTerm,
        model.CorrelationPlan,
        model.BinPlan,
        model.OutputPlan,
        model.Scene,
        transport_terms.Region,
        transport_terms.SpeciesFlux,
        transport_terms.SpeciesValue,
        transport_terms.Reaction,
        transport_terms.Transport,
        units.EnergyUnit,
    )
}


def scene_to_arrays(scene: model.Scene) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Return the scene's arrays by path (``"beads.mass"``) and the rest as JSON-able data."""
    arrays: dict[str, NDArray[Any]] = {}
    return arrays, _encode(scene, "scene", arrays)


def scene_from_arrays(arrays: dict[str, NDArray[Any]], data: dict[str, Any]) -> model.Scene:
    """Return the scene that ``scene_to_arrays`` took apart. Raises InputError when the data are not a scene."""
    try:
        scene = _decode(data, arrays)
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputError(f"the checkpoint holds a scene of another version of pydlpoly ({error})") from error
    if not isinstance(scene, model.Scene):
        raise InputError("the checkpoint holds no scene")
    return scene


def _encode(value: Any, path: str, arrays: dict[str, NDArray[Any]]) -> Any:
    if isinstance(value, np.ndarray):
        arrays[path] = value
        return {"array": path}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {
            f.name: _encode(getattr(value, f.name), f"{path}.{f.name}", arrays) for f in dataclasses.fields(value)
        }
        return {"class": type(value).__name__, "fields": fields}
    if isinstance(value, (tuple, list)):
        return [_encode(item, f"{path}.{k}", arrays) for k, item in enumerate(value)]
    if isinstance(value, np.generic):
        return value.item()
    return value


def _decode(data: Any, arrays: dict[str, NDArray[Any]]) -> Any:
    if isinstance(data, list):
        return tuple(_decode(item, arrays) for item in data)
    if isinstance(data, dict):
        if "array" in data:
            return arrays[data["array"]]
        return _CLASSES[data["class"]](**{name: _decode(v, arrays) for name, v in data["fields"].items()})
    return data
