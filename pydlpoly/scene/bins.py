"""Averages in bins over the cell: what CONTROL asks for, and of what a scene has them."""

from __future__ import annotations

from collections.abc import Sequence

from pydlpoly.errors import InputError, suggest
from pydlpoly.scene.beads_state import CONCENTRATION, TEMPERATURE, carried_names, has_local_density
from pydlpoly.scene.model import BinPlan, Scene
from pydlpoly.scene.settings import Settings
from pydlpoly.scene.stress import AXES

NUMBER, MASS, KINETIC, LOCAL_DENSITY = "number_density", "mass_density", "kinetic_temperature", "local_density"
VELOCITIES = tuple(f"velocity_{axis}" for axis in AXES)
_MOST_BINS = {1: 10_000, 2: 1_000_000}


def resolve_profile_bins(settings: Settings) -> BinPlan:
    """Return what is averaged along an axis. Raises SceneError for numbers that are out of range."""
    axis, bins = AXES["xyz".index(settings.word("profile_axis"))], settings.integer("profile_bins")
    return _plan(settings, "profile", (axis,), (bins,))


def resolve_map(settings: Settings) -> BinPlan:
    """Return what is averaged over a plane. Raises SceneError for numbers that are out of range."""
    axes = tuple(AXES["xyz".index(letter)] for letter in settings.word("map_plane"))
    numbers = settings.vector("map_bins")
    if len(numbers) != len(axes):
        raise settings.refusal("map_bins", f"expected two whole numbers, found {len(numbers)}")
    return _plan(settings, "map", axes, tuple(int(number) for number in numbers))


def _plan(settings: Settings, kind: str, axes: tuple[str, ...], bins: tuple[int, ...]) -> BinPlan:
    every = settings.steps(f"{kind}_frequency")
    if every < 0:
        raise settings.refusal(f"{kind}_frequency", f"the interval must not be negative, found {every} steps")
    total = 1
    for count in bins:
        if count < 1:
            raise settings.refusal(f"{kind}_bins", f"expected at least one bin, found {count}")
        total *= count
    most = _MOST_BINS[len(bins)]
    if total > most:
        raise settings.refusal(f"{kind}_bins", f"{total} bins in all; at most {most} are kept")
    words = settings.text(f"{kind}_quantities").strip().removeprefix("[").removesuffix("]").replace(",", " ").split()
    file = settings.file_name(f"io_file_{kind}")
    return BinPlan(every, axes, bins, tuple(words), file)  # type: ignore[arg-type]  # letters of AXES


def check_bins(scene: Scene, settings: Settings) -> None:
    """Refuse averages of what the scene does not have.

    Raises:
        SceneError: CONTROL asks for one.
    """
    for kind, plan in (("profile", scene.output.bead_profile), ("map", scene.output.bead_map)):
        _check_plan(scene, settings, kind, plan)


def _check_plan(scene: Scene, settings: Settings, kind: str, plan: BinPlan) -> None:
    try:
        quantities_of(scene, plan.quantities)
    except InputError as error:
        raise settings.refusal(f"{kind}_quantities", f"{error.word!r}: {error.message}") from None


def available_quantities(scene: Scene) -> tuple[str, ...]:
    """Return the names of everything that can be averaged in bins of this scene."""
    several = len(scene.species) > 1
    by_species = tuple(f"{NUMBER}_{name}" for name in scene.species) if several else ()
    kinetic = (KINETIC,) if scene.constraints is None else ()
    local = (LOCAL_DENSITY,) if has_local_density(scene) else ()
    return (NUMBER, *by_species, MASS, *VELOCITIES, *kinetic, *carried_names(scene), *local)


def quantities_of(scene: Scene, asked: Sequence[str]) -> tuple[str, ...]:
    """Return the names of quantities with groups written out, each once; all that there are when none is asked for.

    "velocity" stands for its components, "number_density" also for that of each species, "concentration" for all.

    Raises:
        InputError: one that the scene does not have, with its name as the error's word.
    """
    known = available_quantities(scene)
    groups = {
        "velocity": VELOCITIES,
        "concentration": tuple(name for name in known if name.startswith(CONCENTRATION)),
        NUMBER: tuple(name for name in known if name.startswith(NUMBER)),
    }
    found: dict[str, None] = {}
    for word in asked:
        names = groups.get(word, (word,))
        if not names or not set(names) <= set(known):
            raise InputError(_why_not(word, known), word=word)
        found |= dict.fromkeys(names)
    return tuple(found) if asked else known


def _why_not(word: str, known: Sequence[str]) -> str:
    if word == KINETIC:
        return "constraints take degrees of freedom that belong to no bin; leave the kinetic temperature out"
    if word == TEMPERATURE:
        return f"beads carry no internal temperature; did you mean {KINETIC}?"
    if word == LOCAL_DENSITY:
        return "no pair law depends on a local density"
    if word == "concentration":
        return "beads carry no dissolved species"
    choice = ", ".join(dict.fromkeys(["velocity", *known]))
    return f"is not averaged in bins; expected some of {choice}{suggest(word, known)}"


def unit_of(quantity: str, scene: Scene) -> str:
    """Return the unit of a quantity, empty for reduced ones and for concentrations."""
    if scene.units.reduced:
        return ""
    if quantity.startswith((NUMBER, LOCAL_DENSITY)):
        return "1/ang^3"
    words = {MASS: "Da/ang^3", KINETIC: "K", TEMPERATURE: "K", **dict.fromkeys(VELOCITIES, "ang/ps")}
    return words.get(quantity, "")
