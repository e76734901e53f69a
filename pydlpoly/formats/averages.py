"""Averages of a run's statistics: over the last records (rolling) and over all of them, with r.m.s. fluctuations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pydlpoly.formats.records import FloatArray


class RollingAverages:
    """Averages over the last ``stack_size`` records, over all while there are fewer.

    The sum is taken anew for each average: a running sum would drift, and differ after a restart.

    Args:
        stack_size: DL_POLY's ``stack_size``.
        count: how many quantities a record has.
    """

    def __init__(self, stack_size: int, count: int) -> None:
        """Start with an empty stack; see the class."""
        if stack_size < 1 or count < 1:
            raise ValueError(f"stack size and number of quantities must be positive, not {stack_size} and {count}")
        self._stack = np.zeros((stack_size, count))
        self._taken = 0

    def add(self, values: ArrayLike) -> None:
        """Take one record, shape (count,); the oldest leaves a full stack."""
        self._stack[self._taken % len(self._stack)] = np.asarray(values, dtype=np.float64)
        self._taken += 1

    def mean(self) -> FloatArray:
        """Return the averages, shape (count,); zeros before the first record."""
        filled = min(self._taken, len(self._stack))
        if filled == 0:
            return np.zeros(self._stack.shape[1])
        average: FloatArray = self._stack[:filled].mean(axis=0)
        return average

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything a checkpoint needs, as arrays by name."""
        return {"stack": self._stack.copy(), "taken": np.array(self._taken, dtype=np.int64)}

    @classmethod
    def from_state(cls, state: Mapping[str, NDArray[Any]]) -> RollingAverages:
        """Return averages that go on exactly where ``state`` was taken."""
        stack = np.asarray(state["stack"], dtype=np.float64)
        averages = cls(*stack.shape)
        averages._stack, averages._taken = stack.copy(), int(state["taken"])
        return averages


class RunningAverages:
    """Averages and r.m.s. fluctuations over all records, by Welford's update, which keeps its digits in long runs.

    Args:
        count: how many quantities a record has.
    """

    def __init__(self, count: int) -> None:
        """Start without records; see the class."""
        if count < 1:
            raise ValueError(f"the number of quantities must be positive, not {count}")
        self.taken = 0
        self._mean = np.zeros(count)
        self._squares = np.zeros(count)

    def add(self, values: ArrayLike) -> None:
        """Take one record, shape (count,)."""
        record = np.asarray(values, dtype=np.float64)
        self.taken += 1
        off = record - self._mean
        self._mean = self._mean + off / self.taken
        self._squares = self._squares + off * (record - self._mean)

    def mean(self) -> FloatArray:
        """Return the averages, shape (count,)."""
        return self._mean.copy()

    def fluctuations(self) -> FloatArray:
        """Return the root mean square deviations from the averages, √⟨(x − ⟨x⟩)²⟩, shape (count,)."""
        spread: FloatArray = np.sqrt(self._squares / max(self.taken, 1))
        return spread

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything a checkpoint needs, as arrays by name."""
        taken = np.array(self.taken, dtype=np.int64)
        return {"taken": taken, "mean": self._mean.copy(), "squares": self._squares.copy()}

    @classmethod
    def from_state(cls, state: Mapping[str, NDArray[Any]]) -> RunningAverages:
        """Return averages that go on exactly where ``state`` was taken."""
        averages = cls(len(state["mean"]))
        averages.taken = int(state["taken"])
        averages._mean = np.array(state["mean"], dtype=np.float64)
        averages._squares = np.array(state["squares"], dtype=np.float64)
        return averages
