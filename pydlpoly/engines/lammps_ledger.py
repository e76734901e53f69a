"""What beads in LAMMPS carry in sum, and what brought it: sources, and beads that keep what they carry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pydlpoly.engines.lammps_translate.carried import Carried
from pydlpoly.engines.lammps_translate.heat import SUPPLY, capacity_of
from pydlpoly.engines.lammps_translate.observed import Observed
from pydlpoly.engines.lammps_translate.species import supply_name
from pydlpoly.engines.lammps_worker import SUMS
from pydlpoly.errors import RunError
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.beads_state import dissolved_species
from pydlpoly.scene.model import Scene

_TALLY_ROWS = 6  # of the core's: sources, reactions, held beads, and the small parts of the three


class Ledger:
    """Accounts of heat and of dissolved species since the scene's start.

    LAMMPS's exchange changes no sum, so that beads that keep what they carry gave what is missing otherwise.

    Args:
        scene: whose beads.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._names = dissolved_species(scene)
        kinds = range(len(scene.species))
        self._capacities = np.array([capacity_of(scene, k) for k in kinds]) if scene.heat is not None else None
        self._supplied, self._ahead = 0.0, 0.0
        self._tally = np.zeros((_TALLY_ROWS, len(self._names)))
        self._account_before, self._tally_before = self._supplied, self._tally
        self._held: tuple[int, ...] = ()
        self.internal = 0.0
        self._amounts = np.zeros(len(self._names))

    @property
    def account(self) -> tuple[float, float]:
        """As the core's: what sources and held beads gave, and work that beads were charged for ahead."""
        return self._supplied, self._ahead

    @account.setter
    def account(self, given: tuple[float, float]) -> None:
        self._account_before += given[0] - self._supplied
        self._supplied, self._ahead = given

    @property
    def tally(self) -> FloatArray:
        """(6, species) as the core's: what sources, reactions and held beads gave of each dissolved species."""
        return self._tally.copy()

    @tally.setter
    def tally(self, given: FloatArray) -> None:
        self._tally_before = self._tally_before + np.asarray(given) - self._tally
        self._tally = np.array(given, dtype=np.float64)

    def begin(self, carried: Carried, answers: Sequence[Mapping[str, Any]]) -> None:
        """Start from beads that LAMMPS was given anew; what was booked before stays."""
        self._held = carried.held
        self._first = answers[0]
        self._account_before, self._tally_before = self._supplied, self._tally
        self._sum_up(answers)
        self._internal_start, self._amounts_start = self.internal, self._amounts.copy()

    def observe(self, observed: Observed, answers: Sequence[Mapping[str, Any]], step: int) -> None:
        """Book what happened up to this step.

        Raises:
            RunError: something that beads carry is impossible now.
        """
        self._check(answers, step)
        self._sum_up(answers)
        given = observed.supplied(self._first, answers[0], self._scene.dynamics.timestep)
        if self._capacities is not None:
            gained = self.internal - self._internal_start
            self._supplied = self._account_before + (gained if self._held else given.get(SUPPLY, 0.0))
        if self._names:
            sources = np.array([given.get(supply_name(k), 0.0) for k in range(len(self._names))])
            tally = self._tally_before.copy()
            tally[0] += sources
            if self._held:
                tally[2] += self._amounts - self._amounts_start - sources
            self._tally = tally

    def replaced(self, temperatures: FloatArray | None, concentrations: FloatArray | None) -> None:
        """Beads were given other values between two steps, which is in no balance."""
        if temperatures is not None and self._capacities is not None:
            internal = float(np.sum(self._capacities[self._scene.beads.species] * temperatures))
            self._internal_start += internal - self.internal
            self.internal = internal
        if concentrations is not None and self._names:
            amounts = np.sum(concentrations, axis=0)
            self._amounts_start += amounts - self._amounts
            self._amounts = amounts

    def _sum_up(self, answers: Sequence[Mapping[str, Any]]) -> None:
        kinds = len(self._scene.species)
        for name, width in (("temperature", 1), ("concentrations", len(self._names))):
            if name not in answers[0].get(SUMS, {}):
                continue
            total = np.zeros((kinds, width))
            for answer in answers:
                part = answer[SUMS][name][0]
                total[: len(part)] += part
            if name == "temperature":
                assert self._capacities is not None
                self.internal = float(np.sum(self._capacities * total[:, 0]))
            else:
                self._amounts = total.sum(axis=0)

    def _check(self, answers: Sequence[Mapping[str, Any]], step: int) -> None:
        for answer in answers:
            for name, (_, least) in answer.get(SUMS, {}).items():
                words = "an internal temperature" if name == "temperature" else "a concentration"
                if np.isnan(least):
                    raise RunError(f"{words} is not finite at step {step}")
                if least < 0.0 or (least == 0.0 and name == "temperature"):
                    why = "LAMMPS's steps of what beads carry are explicit"
                    raise RunError(f"{words} has become {least:.6g} by step {step}: {why}; the native engine runs it")
