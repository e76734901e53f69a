"""From records to a scene: what is to be modelled, complete, in internal units, with the origin of every number."""

from pydlpoly.scene.load import load
from pydlpoly.scene.model import (
    Beads,
    Dynamics,
    ExternalTerm,
    Note,
    OutputPlan,
    PairTerm,
    RunPlan,
    Scene,
)
from pydlpoly.scene.replicate import replicate
from pydlpoly.scene.resolve import resolve

__all__ = [
    "Beads",
    "Dynamics",
    "ExternalTerm",
    "Note",
    "OutputPlan",
    "PairTerm",
    "RunPlan",
    "Scene",
    "load",
    "replicate",
    "resolve",
]
