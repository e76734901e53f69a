"""A program that runs one scene and times its own loop: ``python worker.py CONFIG``.

Commands and answers are JSON, one a line. CONFIG has ``scene`` (a name in ``scenes``), ``threads``, ``precision``,
``scenes_file`` (the scenes.py to take the scene from, so that another build runs the same one) and ``state`` (an .npz
file of positions and velocities to start from, or null to equilibrate). The first answer describes the simulation; then
``{"steps": n}`` is answered by ``{"seconds": t}`` and ``{"save": path}`` by ``{}``. The program ends with its input.

Whole steps are timed through ``Simulation.run``, with an observation every 100 steps as STATIS asks for it.
"""

from __future__ import annotations

import importlib.util
import json
import os
import resource
import sys
import time
from pathlib import Path
from types import ModuleType
from typing import Any

OBSERVE_EVERY = 100


class Observer:
    """A reporter that looks at energies, temperature and pressure every so many steps."""

    def next_step(self, step: int) -> int:
        """Return the next multiple of the interval."""
        return (step // OBSERVE_EVERY + 1) * OBSERVE_EVERY

    def report(self, simulation: Any) -> None:
        """Look."""
        simulation.observe()


def resident_bytes() -> int:
    """Memory of this process that is in use now; where the system does not say, the most there has been."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize()
    except OSError:
        scale = 1 if sys.platform == "darwin" else 1024
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * scale


def load_module(path: str) -> ModuleType:
    """Return a Python file as a module, whether or not it belongs to the installed package."""
    spec = importlib.util.spec_from_file_location("bench_scenes", path)
    if spec is None or spec.loader is None:
        raise ImportError(path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["bench_scenes"] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def prepare(config: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
    """Return the simulation at the state to time from, and its description."""
    import numpy as np

    import pydlpoly

    scenes = load_module(config["scenes_file"])
    bench_scene = scenes.SCENES[config["scene"]]
    scene = scenes.build(bench_scene)
    if isinstance(scene, str):
        return None, {"unavailable": scene}
    before = resident_bytes()
    wish = {} if config["precision"] == "double" else {"precision": config["precision"]}  # the default of every build
    simulation = pydlpoly.Simulation(scene, seed=1, threads=config["threads"], **wish)
    if config["state"] is None:
        simulation.run(bench_scene.equilibration)
    else:
        with np.load(config["state"]) as state:
            simulation.set_state(positions=state["positions"], velocities=state["velocities"])
    simulation.reporters.append(Observer())
    simulation.run(2)
    grown = resident_bytes() - before
    return simulation, {
        "beads": scene.bead_count,
        "plan": plan(simulation),
        "bytes_per_bead": grown / scene.bead_count,
        "version": pydlpoly.__version__,
        "package": str(Path(pydlpoly.__file__).parent),
        "threads": simulation.threads,
        "temperature": simulation.temperature,
    }


def plan(simulation: Any) -> str:
    """Return what the core says about how it computes; builds before that say nothing."""
    system: Any = getattr(getattr(simulation, "_engine", None), "system", None)
    return str(system.plan()) if hasattr(system, "plan") else "not known"


def main() -> int:
    """Answer commands until the input ends; the return value is the exit code."""
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what libraries print must not come between the answers
    simulation, description = prepare(json.loads(sys.argv[1]))
    print(json.dumps(description), file=answers)
    for line in sys.stdin:
        command = json.loads(line)
        answer = {}
        if "save" in command:
            import numpy as np

            state = simulation.state
            np.savez(command["save"], positions=state.positions, velocities=state.velocities)
        else:
            begin = time.perf_counter()
            simulation.run(command["steps"])
            answer["seconds"] = time.perf_counter() - begin
        print(json.dumps(answer), file=answers)
    return 0


if __name__ == "__main__":
    here = str(Path(__file__).resolve().parent)
    sys.path[:] = [entry for entry in sys.path if entry != here]  # the neighbours are no top-level modules
    sys.exit(main())
