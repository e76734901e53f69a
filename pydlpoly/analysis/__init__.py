"""Structure and dynamics from a HISTORY file or from arrays: one quantity, one file.

Each quantity is a class. ``RadialDistribution(bin_width=0.05).of("HISTORY")`` returns its result, a frozen dataclass of
arrays with standard errors from averages over blocks of frames. ``analyse("HISTORY", one, other)`` shows every frame to
several in one pass. Arrays become frames by ``frames_of_arrays``.
"""

from pydlpoly.analysis.bilayer import BilayerThickness
from pydlpoly.analysis.bonds import BondAngles, BondLengths, terms_of
from pydlpoly.analysis.chains import ChainDimensions
from pydlpoly.analysis.clusters import ClusterSizes
from pydlpoly.analysis.contact_angle import ContactAngle
from pydlpoly.analysis.density import DensityProfile
from pydlpoly.analysis.frames import Analysis, analyse, frames_of_arrays
from pydlpoly.analysis.lamellae import LamellarOrder
from pydlpoly.analysis.mdanalysis import universe
from pydlpoly.analysis.molecules import Molecules, molecule_centres, molecules_of
from pydlpoly.analysis.msd import MeanSquareDisplacement
from pydlpoly.analysis.order import OrientationalOrder
from pydlpoly.analysis.profile import Profile, profile_of_arrays
from pydlpoly.analysis.profile_plot import plot_map, plot_profile
from pydlpoly.analysis.rdf import RadialDistribution
from pydlpoly.analysis.structure_factor import StructureFactor
from pydlpoly.analysis.vaf import VelocityAutocorrelation

__all__ = [
    "Analysis",
    "BilayerThickness",
    "BondAngles",
    "BondLengths",
    "ChainDimensions",
    "ClusterSizes",
    "ContactAngle",
    "DensityProfile",
    "LamellarOrder",
    "MeanSquareDisplacement",
    "Molecules",
    "OrientationalOrder",
    "Profile",
    "RadialDistribution",
    "StructureFactor",
    "VelocityAutocorrelation",
    "analyse",
    "frames_of_arrays",
    "molecule_centres",
    "molecules_of",
    "plot_map",
    "plot_profile",
    "profile_of_arrays",
    "terms_of",
    "universe",
]
