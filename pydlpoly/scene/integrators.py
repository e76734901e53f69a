"""The integrators by name: what each does in one line, and which settings it takes.

The names are those of ``ensemble_dpd_order``; docs/integrators.md has the formulas.
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class IntegratorInfo:
    """One integrator.

    Attributes:
        name: as in ``ensemble_dpd_order`` and ``Dynamics.integrator``.
        about: what a step does, in one line.
        kind: "forces" (drag and noise are forces), "sweep" (pairs one after the other, latest velocities) or
            "simultaneous" (all pairs at once, between two half-drifts).
        keywords: settings of CONTROL that it takes beside the drags.
    """

    name: str
    about: str
    kind: str
    keywords: frozenset[str] = field(default_factory=frozenset)


_EXPONENT = "ensemble_dpd_exponent"
_ACROSS = "ensemble_dpd_transverse_drag"
_EVERY = "ensemble_dpd_interval"


def _info(name: str, kind: str, about: str, *keywords: str) -> tuple[str, IntegratorInfo]:
    return name, IntegratorInfo(name, about, kind, frozenset({_EXPONENT, *keywords}))


INTEGRATORS: dict[str, IntegratorInfo] = dict(
    [
        _info("mdvv", "forces", "velocity Verlet with pairwise drag and noise (Groot and Warren)",
              "ensemble_dpd_lambda", "ensemble_dpd_kinetic"),
        _info("dpdvv", "forces", "the same, the drag computed once more from the whole step's velocities (DPD-VV)"),
        _info("scvv", "forces", "the same, velocities and drag iterated until they belong together (SC-VV)",
              "ensemble_dpd_tolerance"),
        _info("zeroth", "sweep", "one implicit step of every pair, then velocity Verlet", _ACROSS),
        _info("first", "sweep", "Shardlow's splitting S1: every pair, then velocity Verlet", _ACROSS),
        _info("second", "sweep", "Shardlow's splitting S2: half a step of every pair before and after velocity Verlet",
              _ACROSS),
        _info("peters", "sweep", "velocity Verlet, then the exact step of every pair (Peters, scheme II)", _ACROSS),
        _info("peters-first", "sweep", "velocity Verlet, then every pair (Peters, scheme I)", _ACROSS),
        _info("lowe-andersen", "sweep", "velocity Verlet, then chosen pairs get new relative velocities (Lowe)",
              _ACROSS, "ensemble_dpd_rate"),
        _info("stoyanov-groot", "sweep", "the same, and a drag of the other pairs towards the temperature",
              _ACROSS, "ensemble_dpd_rate", "ensemble_dpd_coupling"),
        _info("ou", "sweep", "the exact step of every pair, then velocity Verlet", _ACROSS),
        _info("ou-middle", "sweep", "velocity Verlet with the exact step of every pair in the middle of the drift",
              _ACROSS, _EVERY),
        _info("middle", "simultaneous", "velocity Verlet with drag and noise of all pairs at once in the middle of the "
              "drift", "ensemble_dpd_passes", _EVERY),
        _info("nose-hoover-langevin", "sweep", "velocity Verlet, then a drag that all pairs share and that follows "
              "their temperature", "ensemble_dpd_thermostat_mass", "ensemble_dpd_thermostat_friction"),
    ]
)  # fmt: skip
"""Every DPD integrator by name."""

THERMOSTATS: dict[str, IntegratorInfo] = {
    name: IntegratorInfo(name, about, "beads", frozenset({keyword}))
    for name, about, keyword in (
        ("langevin", "Langevin dynamics: friction and noise of single beads in the middle of the drift",
         "ensemble_thermostat_friction"),
        ("berendsen", "velocity Verlet with Berendsen's weak coupling", "ensemble_thermostat_coupling"),
        ("hoover", "velocity Verlet with a Nosé-Hoover thermostat", "ensemble_thermostat_coupling"),
    )
}  # fmt: skip
"""Thermostats of single beads, by ``ensemble_method``."""


def is_pairwise(integrator: str) -> bool:
    """Whether the integrator has drag and noise between pairs."""
    return integrator in INTEGRATORS


WITH_CONSTRAINTS = (
    "nve",
    *(name for name in INTEGRATORS if name not in ("scvv", "nose-hoover-langevin")),
    *THERMOSTATS,
)
"""Integrators that keep the lengths of constraints."""

WITH_BAROSTAT = (
    *(name for name in INTEGRATORS if name not in ("dpdvv", "scvv", "nose-hoover-langevin")),
    "langevin",
)
"""Integrators that go with ``ensemble npt`` and ``nst``."""
