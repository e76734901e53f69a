"""Engines by name."""

from __future__ import annotations

from pydlpoly.engines.native import NativeEngine
from pydlpoly.engines.protocol import ENGINES, Engine, EngineOptions
from pydlpoly.errors import SceneError
from pydlpoly.scene.model import Scene


def make_engine(
    name: str, scene: Scene, *, seed: int, threads: int, cell_width: float, options: EngineOptions
) -> Engine:
    """Return a scene in an engine, not yet started; the arguments are those of ``Simulation``.

    Raises:
        SceneError: there is no such engine, or it cannot run the scene or does not know an argument.
        InputError: what the engine needs is missing.
    """
    if name not in ENGINES:
        raise SceneError(f"is no engine; expected {', '.join(ENGINES)}", word=name)
    if name == "native":
        if options != EngineOptions():
            raise SceneError("ranks and accelerator switches are for the engine lammps; the native one has threads")
        return NativeEngine(scene, seed=seed, threads=threads, cell_width=cell_width)
    from pydlpoly.engines.lammps import LammpsEngine  # only this engine needs it

    if cell_width > 0.0:
        raise SceneError("a width of link cells has no meaning with the engine lammps")
    return LammpsEngine(scene, seed=seed, threads=threads, options=options)
