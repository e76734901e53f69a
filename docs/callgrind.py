"""Counts the instructions of a bead and step: ``python docs/callgrind.py SCENE [--simd plain|avx2] [--precision …]``.

A scene of ``pydlpoly bench`` is run under valgrind's callgrind twice, for few and for more steps; the difference holds
the steps alone. Valgrind lacks AVX-512, so the plain or the AVX2 version is counted. ``--lammps`` counts LAMMPS.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import pydlpoly
from pydlpoly import Simulation
from pydlpoly.bench import scenes
from pydlpoly.bench.lammps_input import lammps_input
from pydlpoly.bench.processes import isolation, lammps_environment
from pydlpoly.errors import InputError

FEW, MORE = 5, 65

# One call of the core for all steps, as in a chunk of a long run: under valgrind the clock would make chunks of one.
_OURS = """
import sys, numpy as np
from pydlpoly import Simulation
from pydlpoly.bench import scenes
name, precision, state, steps = sys.argv[1:]
simulation = Simulation(scenes.SCENES[name].build(), seed=1, threads=1, precision=precision)
with np.load(state) as saved:
    simulation.set_state(positions=saved["positions"], velocities=saved["velocities"])
simulation._engine.run(int(steps))
"""
# The same for a scene that an expression makes, from its random start.
_ANY = """
import sys
from pydlpoly import Simulation
from pydlpoly.bench import scenes
expression, precision, steps = sys.argv[1:]
simulation = Simulation(eval(expression), seed=1, threads=1, precision=precision)
simulation._engine.run(int(steps))
"""
_LAMMPS = """
import json, sys
from pydlpoly.bench.lammps_worker import answer_to, start
engine, _ = start(json.loads(sys.argv[1]))
answer_to(engine, {"commands": json.loads(sys.argv[2])})
answer_to(engine, {"steps": int(sys.argv[3])})
"""


def instructions(name: str, *, simd: str = "avx2", precision: str = "double", lammps: bool = False) -> float:
    """Return executed instructions for a bead and step.

    Args:
        name: a scene of the benchmarks.
        simd, precision: of pydlpoly.
        lammps: count LAMMPS instead, in the pair style and with the skin that are usual (plain, 0.3).

    Raises:
        InputError: valgrind is missing, the scene is not available, or the program ends with an error.
    """
    if shutil.which("valgrind") is None:
        raise InputError("counting instructions needs valgrind")
    bench = scenes.chosen([name])[0]
    scene = scenes.build(bench)
    if isinstance(scene, str):
        raise InputError(scene, word=name)
    simulation = Simulation(scene, seed=1)
    simulation.run(bench.equilibration)
    present = simulation.state
    with tempfile.TemporaryDirectory() as folder:
        state = Path(folder) / "state.npz"
        types = scene.beads.species + 1
        np.savez(state, positions=present.positions, velocities=present.velocities, types=types)
        environment = {**os.environ, "PYDLPOLY_SIMD": simd, "OMP_NUM_THREADS": "1"}
        environment["PYTHONPATH"] = os.pathsep.join(entry for entry in sys.path if entry)
        command = [_OURS, name, precision, str(state)]
        if lammps:
            given = lammps_input(scene)
            if isinstance(given, str):
                raise InputError(given, word=name)
            environment = lammps_environment()
            config = {"box": given.box, "dynamics": given.dynamics, "beads": str(state)}
            setup = [*next(iter(given.pairs.values())), *given.neighbours["skin 0.3"]]
            command = [_LAMMPS, json.dumps(config), json.dumps(setup)]
        few, more = (_count([*command, str(steps)], environment) for steps in (FEW, MORE))
    return (more - few) / (MORE - FEW) / scene.bead_count


def instructions_of(expression: str, beads: int, *, simd: str = "avx2", precision: str = "double") -> float:
    """Return executed instructions for a bead and step of a scene that a Python expression in ``scenes`` makes.

    Raises:
        InputError: valgrind is missing, or the program ends with an error.
    """
    if shutil.which("valgrind") is None:
        raise InputError("counting instructions needs valgrind")
    environment = {**os.environ, "PYDLPOLY_SIMD": simd, "OMP_NUM_THREADS": "1"}
    environment["PYTHONPATH"] = str(Path(pydlpoly.__file__).parents[1])  # this one, wherever the program starts
    few, more = (_count([_ANY, expression, precision, str(steps)], environment) for steps in (FEW, MORE))
    return (more - few) / (MORE - FEW) / beads


def _count(command: list[str], environment: dict[str, str]) -> int:
    """Instructions that a Python program executes."""
    tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", sys.executable, *isolation(), "-c"]
    # Elsewhere: a program from -c looks for packages in its folder first, and a checkout has one without a core.
    folder = tempfile.gettempdir()
    # Python starts alike each time: its dictionaries differ by millions of instructions between seeds of its hashes.
    alike = {**environment, "PYTHONHASHSEED": "0", "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([*tool, *command], env=alike, cwd=folder, capture_output=True, text=True, check=False)
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or found is None:
        raise InputError(f"valgrind ended with exit code {done.returncode}: {done.stderr.strip()[-500:]}")
    return int(found[1])


def main() -> int:
    """Count what the command line asks for; the return value is the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", choices=list(scenes.SCENES))
    parser.add_argument("--simd", default="avx2", choices=["plain", "avx2"])
    parser.add_argument("--precision", default="double", choices=["double", "mixed", "reference"])
    parser.add_argument("--lammps", action="store_true")
    options = parser.parse_args()
    count = instructions(options.scene, simd=options.simd, precision=options.precision, lammps=options.lammps)
    what = "LAMMPS" if options.lammps else f"{options.precision}, {options.simd}"
    print(f"{options.scene}, {what}: {count:.0f} instructions for a bead and step")
    return 0


if __name__ == "__main__":
    sys.exit(main())
