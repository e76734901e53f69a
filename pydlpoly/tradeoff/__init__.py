"""Speed against accuracy: which integrator, timestep and precision suit a scene, measured on the scene itself."""

from __future__ import annotations

from pydlpoly.tradeoff.measure import tradeoff
from pydlpoly.tradeoff.report import Measured, Reference, TradeoffReport

__all__ = ["Measured", "Reference", "TradeoffReport", "tradeoff"]
