"""What the command line does about engines before it reads a scene."""

from __future__ import annotations

import typer

from pydlpoly.engines.protocol import ENGINES


def choose_engine(engine: str, ranks: int | None, accelerator: str) -> None:
    """Check the options of engines; inside an MPI job, ranks other than the first serve it and end here.

    Raises:
        typer.BadParameter: no such engine, or options that it does not have.
    """
    if engine not in ENGINES:
        raise typer.BadParameter(f"'{engine}' is no engine; expected {', '.join(ENGINES)}", param_hint="--engine")
    if engine == "native":
        for name, given in (("--ranks", ranks is not None), ("--gpu", bool(accelerator))):
            if given:
                raise typer.BadParameter("is for --engine lammps; the native engine has --threads", param_hint=name)
        return
    from pydlpoly.engines.lammps_team import enter_job, switches_of  # only this engine needs it

    enter_job(switches_of(accelerator))
