"""The reporters of averages that a scene asks for."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pydlpoly.reporters.bins import BinReporter
from pydlpoly.reporters.density import DensityReporter
from pydlpoly.reporters.displacements import DisplacementReporter
from pydlpoly.reporters.stress_correlations import StressCorrelations
from pydlpoly.reporters.stress_profile import StressProfile
from pydlpoly.reporters.velocities import VelocityReporter
from pydlpoly.scene.model import BinPlan
from pydlpoly.simulation import Simulation

Sampler = DensityReporter | VelocityReporter | DisplacementReporter | BinReporter
StressReporter = StressProfile | StressCorrelations


def samplers(simulation: Simulation, folder: Path, *, append: bool) -> Iterator[Sampler]:
    """Make the reporters of ZDNDAT, VAFDAT, MSDTMP, PROFILE and MAP that the scene asks for, one by one."""
    output = simulation.scene.output
    if output.zden_every > 0:
        yield DensityReporter(simulation, folder / "ZDNDAT")
    if output.vaf_every > 0:
        yield VelocityReporter(simulation, folder, append=append)
    if output.msd_every > 0:
        yield DisplacementReporter(simulation, folder / output.msd_file, append=append)
    for plan in (output.bead_profile, output.bead_map):
        if plan.every > 0:
            yield _bin_reporter(simulation, folder, plan)


def _bin_reporter(simulation: Simulation, folder: Path, plan: BinPlan) -> BinReporter:
    return BinReporter(
        simulation,
        axes=plan.axes,
        bins=plan.bins,
        quantities=plan.quantities,
        every=plan.every,
        after=simulation.scene.run.averages_after,
        path=folder / plan.file if plan.file is not None else None,
    )


def stress_reporters(simulation: Simulation, folder: Path) -> list[StressReporter]:
    """Return the reporters of STRPRF and COR that the scene asks for."""
    scene = simulation.scene
    profile, correlations = scene.output.profile, scene.output.correlations
    reporters: list[StressReporter] = []
    if profile.every > 0:
        path = folder / profile.file if profile.file is not None else None
        reporters.append(
            StressProfile(
                simulation,
                axis=profile.axis,
                layers=profile.layers,
                every=profile.every,
                after=scene.run.averages_after,
                interfaces=profile.interfaces,
                path=path,
            )
        )
    if correlations.terms:
        path = folder / correlations.file if correlations.file is not None else None
        reporters.append(
            StressCorrelations(
                simulation,
                correlations.terms,
                every=correlations.every,
                after=scene.run.averages_after,
                path=path,
                dump=correlations.dump_every,
            )
        )
    return reporters
