"""What CONTROL asks for about the stress: its profile in layers and its correlation functions."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from pydlpoly.errors import SceneError
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Axis, CorrelationPlan, CorrelationTerm, ProfilePlan, Scene
from pydlpoly.scene.settings import Notes, Settings

AXES: tuple[Axis, ...] = ("x", "y", "z")
_COMPONENT = re.compile(r"(?:s|stress)_([xyz])([xyz])")
_OBSERVABLE = "correlation_observable"
_MOST_LAYERS = 1_000_000


def resolve_profile(
    settings: Settings, cell: FloatArray, periodic: tuple[bool, bool, bool], notes: Notes
) -> ProfilePlan:
    """Return what is sampled of the stress in layers.

    Raises:
        SceneError: the interval, the thickness or the number of interfaces is out of range, or the cell has no layers
            along the axis.
    """
    every = settings.steps("stress_profile_frequency")
    k = "xyz".index(settings.word("stress_profile_axis"))
    axis, width = AXES[k], settings.number("stress_profile_binsize")
    interfaces, name = settings.integer("stress_profile_interfaces"), settings.file_name("io_file_stress_profile")
    if every < 0:
        message = f"the interval must not be negative, found {every} steps"
        raise settings.refusal("stress_profile_frequency", message)
    if interfaces < 1:
        raise settings.refusal("stress_profile_interfaces", f"expected at least one interface, found {interfaces}")
    if not width > 0.0:
        raise settings.refusal("stress_profile_binsize", f"expected a thickness larger than 0, found {width:g}")
    if every == 0:
        return ProfilePlan(0, axis, 1, interfaces, name)
    message = why_no_layers(cell, periodic, axis)
    if message:
        raise settings.refusal("stress_profile_axis", message)
    height = float(cell[k, k])
    layers = max(1, round(height / width))
    if layers > _MOST_LAYERS:
        message = f"{width:g} makes {layers} layers; at most {_MOST_LAYERS} are kept"
        raise settings.refusal("stress_profile_binsize", message)
    if abs(layers * width - height) > 1e-9 * height:
        where = settings.where("stress_profile_binsize")
        notes.choice(f"the stress along {axis} is sampled in {layers} layers of {height / layers:.6g}", where)
    return ProfilePlan(every, axis, layers, interfaces, name)


def why_no_layers(cell: FloatArray, periodic: Sequence[bool], axis: str) -> str:
    """Return why a cell has no layers along an axis that fill it, empty when it has."""
    k = "xyz".index(axis)
    others = [other for other in range(3) if other != k]
    if not periodic[k]:
        return f"the stress along {axis} needs a cell that is periodic along {axis}"
    if np.any(cell[k, others]) or np.any(cell[others, k]):
        return f"the stress along {axis} needs a cell vector along {axis} that is perpendicular to the other two"
    return ""


def check_profile(scene: Scene, settings: Settings) -> None:
    """Refuse a stress profile of a scene that has forces or momenta which belong to no layer.

    Raises:
        SceneError: CONTROL asks for one.
    """
    message = why_not_in_layers(scene)
    if scene.output.profile.every > 0 and message:
        raise settings.refusal("stress_profile_frequency", message)


def why_not_in_layers(scene: Scene) -> str:
    """Return what of a scene's stress cannot be given in layers, empty when all can."""
    if scene.electrostatics is not None:
        return "the stress of charges is not resolved in layers; switch coul_method or the profile off"
    if scene.constraints is not None:
        return "the stress in layers is not modelled with constraints"
    if scene.dynamics.shear_rate != 0.0:
        return "in a sheared cell momenta belong to the flow as well; they are not resolved in layers"
    return ""


def resolve_correlations(settings: Settings, notes: Notes) -> CorrelationPlan:
    """Return which components of the stress are correlated.

    Raises:
        SceneError: another observable, a shape that is out of range, or intervals that differ.
    """
    text = settings.text(_OBSERVABLE).strip()
    words = text.removeprefix("[").removesuffix("]").replace(",", " ").split()
    shapes = [_numbers(settings, name, max(len(words), 1)) for name in ("block_points", "blocks", "window")]
    intervals = _numbers(settings, "update_frequency", max(len(words), 1))
    dump = settings.steps("correlation_dump_frequency")
    name = settings.file_name("io_file_cor")
    if dump < 0:
        message = f"the interval must not be negative, found {dump} steps"
        raise settings.refusal("correlation_dump_frequency", message)
    if len(set(intervals)) > 1:
        message = "the stress is sampled for all correlations in the same steps; expected equal intervals"
        raise settings.refusal("correlation_update_frequency", message)
    terms = []
    for word, points, blocks, window in zip(words, *shapes, strict=False):
        if points < 2:
            raise settings.refusal("correlation_block_points", f"expected at least 2 points, found {points}")
        if blocks > 1 and not 2 <= window <= points:
            message = f"several blocks need a window between 2 and the {points} points, found {window}"
            raise settings.refusal("correlation_window", message)
        terms.append(CorrelationTerm(*_components(settings, word), points, blocks, window))
    if len(set(terms)) < len(terms):
        raise settings.refusal(_OBSERVABLE, "the same correlation is given twice")
    if terms and intervals[0] > 1:
        notes.choice(
            f"the stress is correlated every {intervals[0]} steps: with noise of pairs no viscosity follows from it",
            settings.where("correlation_update_frequency"),
        )
    return CorrelationPlan(tuple(terms), intervals[0], dump, name)


def _numbers(settings: Settings, name: str, count: int) -> list[int]:
    """The numbers of a vector, one a correlation; the last one counts for all that follow."""
    keyword = f"correlation_{name}"
    numbers = [int(number) for number in settings.vector(keyword)]
    if not numbers or min(numbers) < 1:
        raise settings.refusal(keyword, "expected whole numbers larger than 0")
    return (numbers + numbers[-1:] * count)[:count]


def _components(settings: Settings, word: str) -> tuple[tuple[int, int], tuple[int, int]]:
    places = []
    for side in word.lower().split("-"):
        found = _COMPONENT.fullmatch(side)
        if found:
            places.append(("xyz".index(found[1]), "xyz".index(found[2])))
    if len(places) != 2 or word.count("-") != 1:
        raise _no_stress(settings, word)
    return places[0], places[1]


def _no_stress(settings: Settings, word: str) -> SceneError:
    known = "expected two components of the stress, such as s_xy-s_xy or stress_xx-stress_yy"
    return settings.refusal(_OBSERVABLE, f"{word!r} is not correlated: {known}")
