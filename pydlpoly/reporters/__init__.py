"""Reporters: each writes or collects something every so many steps, and never changes the simulation.

One reporter a file. Energies and virials go out in FIELD's energy unit, temperatures and pressures in K and katm
(reduced with ``units dpd``). Trajectories in formats of other programs have theirs in ``pydlpoly.trajectories``.
"""

from pydlpoly.reporters.asked import samplers, stress_reporters
from pydlpoly.reporters.bins import BinReporter
from pydlpoly.reporters.checkpoint import CheckpointReporter
from pydlpoly.reporters.configuration import bead_names, configuration_of
from pydlpoly.reporters.density import DensityReporter
from pydlpoly.reporters.diagnostics import DiagnosticsReporter
from pydlpoly.reporters.displacements import DisplacementReporter
from pydlpoly.reporters.distances import radial_distributions, write_distances
from pydlpoly.reporters.output import OutputReporter
from pydlpoly.reporters.schedule import every
from pydlpoly.reporters.statistics import StatisticsReporter
from pydlpoly.reporters.statistics_record import square_displacements, statistics_record, variable_cell_columns
from pydlpoly.reporters.stress_correlations import StressCorrelations
from pydlpoly.reporters.stress_profile import StressProfile
from pydlpoly.reporters.trajectory import TrajectoryReporter
from pydlpoly.reporters.velocities import VelocityReporter

__all__ = [
    "BinReporter",
    "CheckpointReporter",
    "DensityReporter",
    "DiagnosticsReporter",
    "DisplacementReporter",
    "OutputReporter",
    "StatisticsReporter",
    "StressCorrelations",
    "StressProfile",
    "TrajectoryReporter",
    "VelocityReporter",
    "bead_names",
    "configuration_of",
    "every",
    "radial_distributions",
    "samplers",
    "square_displacements",
    "statistics_record",
    "stress_reporters",
    "variable_cell_columns",
    "write_distances",
]
