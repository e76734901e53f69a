"""Candidates: variants of a scene that differ in integrator, timestep and precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import get_args

from pydlpoly.engines.native import NativeEngine
from pydlpoly.errors import SceneError, suggest
from pydlpoly.scene.dynamics import limit_exceeded
from pydlpoly.scene.external import unfit_for_flight
from pydlpoly.scene.integrators import INTEGRATORS
from pydlpoly.scene.model import Dynamics, Precision, Scene
from pydlpoly.scene.shear import unfit_for_shear

MULTIPLES = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0)
"""Timesteps that are tried, in units of the scene's."""

DEFAULTS = ("mdvv", "dpdvv", "first", "second", "peters", "lowe-andersen", "ou-middle", "middle")
"""Integrators that are tried in scenes with a thermostat."""

LAMBDAS = ((0.5, False), (0.65, False), (0.9, True))
"""Groot and Warren's λ that are tried with mdvv, and whether the kinetic temperature is that of half steps."""

INTERVALS = (1, 4)
"""Steps from one thermostat step to the next that are tried with middle."""

OTHER_DYNAMICS = frozenset({"lowe-andersen", "stoyanov-groot", "nose-hoover-langevin"})
"""Integrators with the same averages but other drag, and so another viscosity and diffusion, than the rest."""

_COUPLING = 0.3  # of stoyanov-groot where the scene has none: CONTROL's default


@dataclass(frozen=True)
class Candidate:
    """One way of taking steps.

    Attributes:
        integrator, timestep, precision: as in ``Dynamics``.
        prediction: λ of mdvv, else None; ``half``: whether its kinetic temperature is that of half steps.
        interval: steps from one thermostat step of middle and ou-middle to the next.
        path: "fast" or "general"; "" when that could not be found out.
        own: whether these are the scene's settings.
        refused: why it cannot be run, else "".
    """

    integrator: str
    timestep: float
    precision: Precision
    prediction: float | None = None
    path: str = ""
    own: bool = False
    refused: str = ""
    half: bool = False
    interval: int = 1

    @property
    def name(self) -> str:
        """Integrator and what it is tried with."""
        return full_name(self.integrator, self.prediction, self.half, self.interval)

    @property
    def label(self) -> str:
        """Everything that tells it from the others."""
        return f"{self.name}, {self.timestep:g}, {self.precision}"


def full_name(integrator: str, prediction: float | None, half: bool, interval: int) -> str:
    """Return for example ``mdvv 0.9 half`` or ``middle every 4``."""
    words = [integrator, *([] if prediction is None else [f"{prediction:g}"]), *(["half"] if half else [])]
    return " ".join([*words, *([f"every {interval}"] if interval > 1 else [])])


def variant(scene: Scene, candidate: Candidate) -> Scene:
    """Return the scene with the candidate's settings; what only the integrator takes keeps the scene's value."""
    dynamics = replace(
        scene.dynamics,
        integrator=candidate.integrator,
        timestep=candidate.timestep,
        precision=candidate.precision,
        schedule=None,
    )
    if candidate.prediction is not None:
        dynamics = replace(dynamics, prediction=candidate.prediction, half_step_kinetic=candidate.half)
    if candidate.integrator in ("middle", "ou-middle"):
        dynamics = replace(dynamics, interval=candidate.interval)
    if candidate.integrator == "stoyanov-groot" and scene.dynamics.integrator != "stoyanov-groot":
        dynamics = replace(dynamics, coupling=_COUPLING)
    return replace(scene, dynamics=dynamics)


def candidates_for(
    scene: Scene,
    integrators: Sequence[str] | None = None,
    timesteps: Sequence[float] | None = None,
    precisions: Sequence[str] | None = None,
) -> list[Candidate]:
    """Return every candidate; a precision that makes no difference on a candidate's path is left out.

    Args:
        scene: what is modelled.
        integrators: names of ``INTEGRATORS`` (default: ``DEFAULTS``), for scenes without thermostat "nve" alone.
        timesteps: in internal units (default: ``MULTIPLES`` of the scene's).
        precisions: default: double and mixed.

    Raises:
        SceneError: a name that is none, an integrator that does not fit the scene, a timestep that is not positive.
    """
    names = _names(scene, integrators)
    steps = [m * scene.dynamics.timestep for m in MULTIPLES] if timesteps is None else list(timesteps)
    for step in steps:
        if not 0.0 < step < float("inf"):
            raise SceneError(f"a timestep must be above 0, not {step:g}")
    arithmetics = _precisions(precisions)
    found: list[Candidate] = []
    for name in names:
        for one in _settings(scene, name):
            paths = {precision: _path(scene, replace(one, precision=precision)) for precision in arithmetics}
            kept = arithmetics
            if paths.get("double") == paths.get("mixed") == "general":  # the same bits
                idle = "double" if scene.dynamics.precision == "mixed" else "mixed"
                kept = [precision for precision in arithmetics if precision != idle]
            for precision, step in product(kept, dict.fromkeys(sorted(steps))):
                path = paths[precision]
                found.append(_judged(scene, replace(one, timestep=step, precision=precision, path=path)))
    return found


def reference_for(scene: Scene, candidates: Sequence[Candidate]) -> Candidate:
    """Return what the candidates are compared with: an accurate integrator at half the scene's timestep or less."""
    step = min([0.5 * scene.dynamics.timestep, *(one.timestep for one in candidates)])
    if scene.dynamics.integrator == "nve":
        return Candidate("nve", step, "double")
    return Candidate("ou-middle" if scene.dynamics.transverse_drag > 0.0 else "middle", step, "double")


def _names(scene: Scene, integrators: Sequence[str] | None) -> list[str]:
    nve = scene.dynamics.integrator == "nve"
    if integrators is None:
        own = scene.dynamics.integrator
        return ["nve"] if nve else [*DEFAULTS, *([] if own in DEFAULTS else [own])]
    valid = ["nve"] if nve else list(INTEGRATORS)
    for name in integrators:
        if name not in valid:
            kind = "without" if nve else "with"
            message = f"is no integrator for a scene {kind} thermostat; expected {', '.join(valid)}"
            raise SceneError(f"{message}{suggest(name, valid)}", word=name)
    if not integrators:
        raise SceneError("no integrator is named")
    return list(dict.fromkeys(integrators))


def _precisions(precisions: Sequence[str] | None) -> list[Precision]:
    valid: dict[str, Precision] = {word: word for word in get_args(Precision)}
    chosen = ["double", "mixed"] if precisions is None else list(precisions)
    for word in chosen:
        if word not in valid:
            raise SceneError(f"is no precision; expected {', '.join(valid)}{suggest(word, valid)}", word=word)
    return [valid[word] for word in dict.fromkeys(chosen)]


def _settings(scene: Scene, integrator: str) -> list[Candidate]:
    """What an integrator is tried with; timestep and precision are the scene's."""
    dynamics = scene.dynamics
    plain = Candidate(integrator, dynamics.timestep, dynamics.precision)
    own = dynamics.integrator == integrator
    if integrator == "mdvv":
        pairs = [*LAMBDAS, *([(dynamics.prediction, dynamics.half_step_kinetic)] if own else [])]
        return [replace(plain, prediction=prediction, half=half) for prediction, half in dict.fromkeys(pairs)]
    intervals = {"middle": INTERVALS, "ou-middle": (1,)}.get(integrator, ())
    if not intervals:
        return [plain]
    every = [*intervals, *([dynamics.interval] if own else [])]
    return [replace(plain, interval=interval) for interval in dict.fromkeys(every)]


def _path(scene: Scene, candidate: Candidate) -> str:
    try:
        return str(NativeEngine(variant(scene, candidate), seed=0, threads=1).system.plan()).split(":")[0]
    except ValueError:  # PYDLPOLY_SIMD names what is not there; the run says so
        return ""


def _judged(scene: Scene, candidate: Candidate) -> Candidate:
    dynamics = variant(scene, candidate).dynamics
    beads = scene.beads
    limit = limit_exceeded(dynamics, scene.pairs, scene.species, beads.mass, beads.species, beads.frozen)
    return replace(candidate, own=_same(dynamics, scene.dynamics), refused=limit or _unfit(scene, dynamics))


def _unfit(scene: Scene, dynamics: Dynamics) -> str:
    """Why the integrator does not go with shear, walls or a magnetic field of the scene, else an empty string."""
    reasons = []
    if dynamics.shear_rate != 0.0:
        reasons.append(unfit_for_shear(dynamics))
    if scene.walls is not None or any(term.key == "magn" for term in scene.external):
        reasons.append(unfit_for_flight(dynamics, "walls or the field magn"))
    return next((reason[1] for reason in reasons if reason is not None), "")


def _same(one: Dynamics, other: Dynamics) -> bool:
    keys = ["integrator", "timestep", "precision"]
    keys += ["prediction", "half_step_kinetic"] if one.integrator == "mdvv" else []
    keys += ["interval"] if one.integrator in ("middle", "ou-middle") else []
    return all(getattr(one, key) == getattr(other, key) for key in keys)
