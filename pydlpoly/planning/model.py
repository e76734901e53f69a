"""The model behind ``pydlpoly plan``. It is arithmetic, not a measurement of the machine that is planned for.

A rank holds n = N/R beads in a cube of edge e = (n/ρ)^(1/3) and copies of its neighbours' beads up to the reach h (the
longest range and the skin of the list): the halo, ρ [(e + 2h)³ − e³] beads. In every step it

* computes, for n/k seconds, k being the rate of one core;
* exchanges the halo: positions and velocities forwards (48 bytes a bead), forces back (24), in 2 · 6 messages, or
  ceil(h/e) times as many where the halo reaches beyond the next rank;
* takes part in one sum over all ranks, whether the list of pairs is still good: 2 ⌈log₂ R⌉ messages;
* every ``rebuild`` steps builds the list anew: halos once more with all that a bead has (88 bytes), 18 messages.

A message of b bytes takes latency + b/bandwidth, and the ranks of a node share its bandwidth. Not in the model: load
that differs between ranks, sums over reciprocal vectors, reports and files, the network's topology, caches.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

FORWARD, BACK, WHOLE = 48.0, 24.0, 88.0  # bytes of a bead
# Measured: DPD water with 375 000 beads in LAMMPS of July 2025 (525 bytes a bead with lists and halo), and the growth
# of the process in front with 600 000.
RANK_BYTES = 300.0  # of a bead in LAMMPS: arrays, bins and buffers
FRONT_BYTES = 700.0  # of a bead in the process in front: the scene, the state, the native core's copy
LIST_BYTES = 4.0  # of a pair in one list


@dataclass(frozen=True)
class Fluid:
    """What is to be run, as far as the model cares.

    Attributes:
        density: beads per volume; ``reach``: longest range and skin, same length unit.
        rate: bead-steps a second of one core.
        lists: lists of pairs that LAMMPS keeps.
    """

    density: float
    reach: float
    rate: float
    lists: int = 1


@dataclass(frozen=True)
class Network:
    """The network and what is sent.

    Attributes:
        latency: of a message, s; ``bandwidth``: of a node, bytes/s, shared by ``ranks_per_node``.
        rebuild: steps between two lists of pairs.
        bytes_per_bead: sent in every step for each bead of a halo.
    """

    latency: float = 2e-6
    bandwidth: float = 12.5e9
    ranks_per_node: int = 64
    rebuild: int = 10
    bytes_per_bead: float = FORWARD + BACK


@dataclass(frozen=True)
class Estimate:
    """What the model says of one number of ranks; times in s a step, memory in bytes.

    Attributes:
        beads, halo: on one rank.
        compute, exchange, collective, rebuild: parts of a step.
        rank_memory: of one rank; ``front_memory``: of the process in front, which has a copy of all beads.
    """

    ranks: int
    beads: float
    halo: float
    compute: float
    exchange: float
    collective: float
    rebuild: float
    rank_memory: float
    front_memory: float

    @property
    def step(self) -> float:
        """Seconds of a step."""
        return self.compute + self.exchange + self.collective + self.rebuild

    @property
    def halo_share(self) -> float:
        """Part of a step in which halos are exchanged."""
        return (self.exchange + self.rebuild) / self.step

    @property
    def efficiency(self) -> float:
        """Part of a step in which something is computed."""
        return self.compute / self.step


def estimate(beads: float, ranks: int, fluid: Fluid, network: Network) -> Estimate:
    """Return what the model says. Raises ValueError for numbers that are not positive."""
    if not (beads >= 1.0 and ranks >= 1 and fluid.rate > 0.0 and fluid.density > 0.0):
        raise ValueError("beads, ranks, density and rate must be positive")
    own = beads / ranks
    edge = (own / fluid.density) ** (1.0 / 3.0)
    halo = fluid.density * ((edge + 2.0 * fluid.reach) ** 3 - edge**3)
    shared = network.bandwidth / min(ranks, network.ranks_per_node)
    swaps = 6 * max(1, math.ceil(fluid.reach / edge))
    alone = ranks == 1  # copies of a rank's own beads cost no messages
    exchange = 0.0 if alone else 2 * swaps * network.latency + halo * network.bytes_per_bead / shared
    rebuild = 0.0 if alone else (3 * swaps * network.latency + halo * WHOLE / shared) / network.rebuild
    neighbours = 0.5 * fluid.density * 4.0 / 3.0 * math.pi * fluid.reach**3
    return Estimate(
        ranks=ranks,
        beads=own,
        halo=halo,
        compute=own / fluid.rate,
        exchange=exchange,
        collective=2.0 * math.ceil(math.log2(ranks)) * network.latency,
        rebuild=rebuild,
        rank_memory=(own + halo) * RANK_BYTES + own * neighbours * LIST_BYTES * fluid.lists,
        front_memory=beads * FRONT_BYTES,
    )


def rank_counts(largest: int) -> list[int]:
    """Return powers of two below the largest number of ranks, at most twelve of them, and that number."""
    powers = [2**k for k in range(largest.bit_length()) if 2**k < largest]
    return [*powers[-12:], largest]
