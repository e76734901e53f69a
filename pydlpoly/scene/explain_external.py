"""The section on external fields of Scene.explain(), with walls and the flow of a sheared cell."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from pydlpoly.scene.explain_text import Words, wrap
from pydlpoly.scene.model import Scene


def lines(scene: Scene) -> list[str]:
    """Return external fields, walls and shear in words."""
    word, told = Words(scene), []
    for term in scene.external:
        told += wrap(f"{term.key}: {_FIELDS[term.key](word, term.parameters)}, from {term.explanation}")
    return [*told, *_walls(scene), *_shear(scene)] or ["none"]


def _vector(numbers: Sequence[float]) -> str:
    return "(" + " ".join(f"{x:g}" for x in numbers[:3]) + ")"


_FIELDS: dict[str, Callable[[Words, tuple[float, ...]], str]] = {
    "grav": lambda _, p: f"F = m G with G = {_vector(p)} in internal units",
    "oshr": lambda word, p: f"Fx = A cos(2 pi n z/Lz) with A = {p[0]:g}{word.force}, n = {p[1]:g}",
    "elec": lambda _, p: f"F = q E with E = {_vector(p)} in internal units",
    "osel": lambda word, p: (
        f"F = q E sin(2 pi f t) with E = {_vector(p)} in internal units, f = {p[3]:g}{word.time and ' 1/ps'}"
    ),
    "magn": lambda _, p: f"F = q v x H with H = {_vector(p)} in internal units, along exact helices",
    "shrx": lambda word, p: (
        f"vx = sign(z) A/2 for |z| > z0 with A = {p[0]:g}{word.velocity}, z0 = {p[1]:g}{word.length}"
    ),
    "sphr": lambda word, p: (
        f"U = A (R0 - r)^-n for r > Rcut with A = {p[0]:g} in internal units, R0 = {p[1]:g}{word.length}, "
        f"n = {p[2]:g}, Rcut = {p[3]:g}{word.length}"
    ),
    "zbnd": lambda word, p: (
        f"U = A (z - z0)^2/2 {'above' if math.copysign(1.0, p[2]) > 0.0 else 'below'} z0 with A = {p[0]:g} in internal "
        f"units, z0 = {p[1]:g}{word.length}"
    ),
    "pois": lambda word, p: f"Fx = m g sign(y) with g = {p[0]:g}{word.velocity and ' ang/ps^2'}",
}


def _walls(scene: Scene) -> list[str]:
    walls, word = scene.walls, Words(scene)
    if walls is None:
        return []
    places = ", ".join(
        f"{axis} = -{d:g} and {d:g}{word.length}"
        for axis, wall, d in zip("xyz", walls.walled, walls.distance, strict=True)
        if wall
    )
    turns = {"reflecting": "the velocity across the wall is", "bounce-back": "the whole velocity of a bead is"}
    told = wrap(f"walls at {places}: {turns[walls.method]} reversed there, from {walls.explanation}")
    if walls.strengths:
        named = ", ".join(f"{name} {a:g}" for name, a in zip(scene.species, walls.strengths, strict=True))
        told += wrap(
            f"before them U = A rc (1 - d/rc)^2/2 at the distance d, rc = {walls.range:g}{word.length}, A in internal "
            f"units: {named}"
        )
    return told


def _shear(scene: Scene) -> list[str]:
    rate, word = scene.dynamics.shear_rate, Words(scene)
    if rate == 0.0:
        return []
    return [f"Lees-Edwards boundaries: flow along x, gradient along y, shear rate {rate:g}{word.time and ' 1/ps'}"]
