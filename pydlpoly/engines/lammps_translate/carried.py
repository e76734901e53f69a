"""What beads have in LAMMPS beside place and velocity: atom styles, and which beads keep what they have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pydlpoly.engines.lammps_translate.formulas import number
from pydlpoly.engines.lammps_translate.refusal import Places, refusal
from pydlpoly.scene.model import Scene


@dataclass(frozen=True)
class Carried:
    """What beads carry in a scene for LAMMPS.

    Attributes:
        heat: internal temperatures; ``density``: local densities; ``dissolved``: number of dissolved species.
        predicted: velocities are predicted by a λ other than 1/2, which needs room beside each bead.
        held: species whose beads keep what they carry.
        supplies: names of variables of what sources give a step's unit of time: of heat, or of dissolved species by
            number, in the order of the columns of the fix that averages them.
    """

    heat: bool = False
    density: bool = False
    dissolved: int = 0
    predicted: bool = False
    held: tuple[int, ...] = ()
    supplies: tuple[str, ...] = ()

    @property
    def any(self) -> bool:
        """Whether beads carry anything that depends on their neighbours."""
        return self.heat or self.density or self.dissolved > 0

    def atom_style(self, plain: str) -> str:
        """Return the atom style of beads that are otherwise of the style ``plain``."""
        more = ["edpd"] * self.heat + [f"tdpd {self.dissolved}"] * (self.dissolved > 0)
        more += ["mdpd"] * (self.density or (self.predicted and not more))
        return " ".join(["hybrid", plain, *more]) if more else plain


NOTHING = Carried()


def carried_of(scene: Scene) -> Carried:
    """Return what beads carry in a scene, without sources."""
    dynamics, transport = scene.dynamics, scene.transport
    held: tuple[int, ...] = ()
    if scene.heat is not None:
        held = scene.heat.held
    elif transport is not None:
        held = tuple(sorted({int(hold.region.numbers[0]) for hold in transport.holds}))
    return Carried(
        heat=scene.heat is not None,
        density=scene.many_body is not None,
        dissolved=0 if transport is None else len(transport.species),
        predicted=dynamics.integrator == "mdvv" and dynamics.prediction != 0.5,
        held=held,
    )


def refuse_carried(scene: Scene, places: Places) -> None:
    """Raise SceneError for what beads carry in ways that LAMMPS has no equal of, whatever it is."""
    where = {"path": scene.sources[1]} if len(scene.sources) > 1 else {}
    beads = scene.beads
    if beads.temperature is not None and scene.heat is None:
        raise refusal("internal temperatures without FIELD's extension heat cannot be run", where)
    if beads.concentrations is not None and scene.transport is None:
        raise refusal("concentrations without FIELD's extension transport cannot be run", where)
    if scene.heat is not None and scene.transport is not None:
        message = "heat and dissolved species in one scene cannot be run"
        raise refusal(message, places.of_text(scene.heat.explanation), "LAMMPS has no step for both")
    carried = carried_of(scene)
    if not carried.any:
        return
    if beads.frozen.any():
        for kind, name in enumerate(scene.species):
            flags = beads.frozen[beads.species == kind]
            if flags.any() and not flags.all():
                message = f"beads {name} that are frozen beside beads {name} that are not, which carry something,"
                raise refusal(f"{message} cannot be run", {**where, "word": name})
        if scene.electrostatics is not None:
            message = "frozen beads that carry something cannot be run with electrostatics"
            raise refusal(message, places.of_setting("coul_method"))


def without_frozen_pairs(scene: Scene) -> Scene:
    """Return the scene whose species of frozen beads have no forces among themselves.

    Beads that carry something need their frozen neighbours in LAMMPS's lists, so that pairs of frozen beads, which
    exert no forces here, are given none there.
    """
    frozen = set(frozen_species(scene))
    pairs = tuple(
        replace(pair, law=None, drag=0.0, noise=0.0, table=None) if frozen.issuperset(pair.species) else pair
        for pair in scene.pairs
    )
    return replace(scene, pairs=pairs) if frozen else scene


def frozen_species(scene: Scene) -> list[int]:
    """Return the species all of whose beads are frozen."""
    species, kinds = scene.beads.species, len(scene.species)
    total = np.bincount(species, minlength=kinds)
    frozen = np.bincount(species[scene.beads.frozen], minlength=kinds)
    return [k for k in range(kinds) if 0 < total[k] == frozen[k]]


def motion_fixes(carried: Carried, prediction: float, group: str, name: str) -> list[str]:
    """Return the fixes that move beads with constant energy and what they carry with them.

    Args:
        carried: what beads carry.
        prediction: λ of mdvv.
        group: of the beads that move.
        name: of the fix.
    """
    predicted = f"mvv/dpd {number(prediction)}" if carried.predicted else "nve"
    if not (carried.heat or carried.dissolved):
        return [f"fix {name} {group} {predicted}"]
    style = f"mvv/{'edpd' if carried.heat else 'tdpd'} {number(prediction)}"
    if not carried.held:
        return [f"fix {name} all {style}"]  # frozen beads also exchange; they have no force and no velocity
    return [
        f"group held type {' '.join(str(k + 1) for k in carried.held)}",
        "group exchanging subtract all held",
        f"fix {name} exchanging {style}",
        f"fix {name}_held held {predicted}",
    ]


def supply_commands(rates: Mapping[str, Sequence[str]]) -> list[str]:
    """Return the commands that add up what sources give: formulas by name of the variable."""
    if not rates:
        return []
    lines = [f'variable {name} equal "{"+".join(terms)}"' for name, terms in rates.items()]
    return [*lines, f"fix supplied all ave/time 1 1 1 {' '.join(f'v_{name}' for name in rates)} ave running"]


@dataclass(frozen=True)
class Sources:
    """Sources of what beads carry.

    Attributes:
        commands: those that make them; ``supplies``: the variables of what they give, see ``Carried``.
        first_half: commands for the first step after beads were read: LAMMPS's sources do not act in its first half.
    """

    commands: tuple[str, ...] = ()
    supplies: tuple[str, ...] = ()
    first_half: tuple[str, ...] = ()


@dataclass(frozen=True)
class SourceParts:
    """One source: the formulas of what it gives in a unit of time, to all beads and to each."""

    total: str
    each: str


def source_part(kinds: Sequence[int], group: str, region: str, weights: Sequence[float], rate: float) -> SourceParts:
    """Return a source of a rate in a region, for the beads of a group, which are those of the species.

    ``weights`` say how much a bead of each species counts in the total.
    """
    return SourceParts(counted(kinds, region, weights, rate), f"({number(rate)})*grmask({group},{region})")


def first_half(words: str, compute: str, parts: Sequence[SourceParts], timestep: float) -> list[str]:
    """Return the commands that have sources act for half a step on what beads carry.

    Args:
        words: of the command ``set``; ``compute``: of the present values.
        parts: of the sources.
        timestep: Δt, ps.
    """
    rate = "+".join(part.each for part in parts)
    return [
        f'variable first atom "c_{compute}+{number(0.5 * timestep)}*({rate})"',
        f"set group all {words} v_first",
        "variable first delete",
    ]


def counted(kinds: Sequence[int], region: str, weights: Sequence[float], rate: float) -> str:
    """Return the formula of rate Σ weight · beads of the species in a region."""
    terms = [f"{number(w)}*count(kind{k + 1},{region})" for k, w in zip(kinds, weights, strict=True)]
    return f"({number(rate)})*({'+'.join(terms) or '0.0'})"


def kind_groups(scene: Scene) -> list[str]:
    """Return the commands that make a group of each species, ``kind1`` and so on."""
    return [f"group kind{k + 1} type {k + 1}" for k in range(len(scene.species))]


def mean_field_rate(scene: Scene, rates: Sequence[tuple[tuple[int, int], float, float, float]]) -> float:
    """Return the largest Σ_j κ w² over species, 1/ps, for beads without order.

    Args:
        scene: whose densities.
        rates: (species, κ, range, exponent) of pairs, w² = (1 − r/range)^exponent.
    """
    volume = abs(float(np.linalg.det(scene.cell)))
    counts = np.bincount(scene.beads.species, minlength=len(scene.species))
    total = np.zeros(len(scene.species))
    for (a, b), rate, reach, s in rates:
        weight = 8.0 * np.pi * reach**3 / ((s + 1.0) * (s + 2.0) * (s + 3.0))  # ∫ w² dV
        for one, other in {(a, b), (b, a)}:
            total[one] += rate * weight * counts[other] / volume
    return float(total.max(initial=0.0))
