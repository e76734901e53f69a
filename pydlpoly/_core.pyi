"""
Compiled core of pydlpoly: pair laws, mixing, forces, integration. Use it through the Python package.
"""

from __future__ import annotations

import collections.abc
import typing

import numpy
import numpy.typing

__all__: list[str] = [
    "Barostat",
    "BondedTerms",
    "CellMotion",
    "ChargeNumbers",
    "ChargeSettings",
    "HeatPairs",
    "Order",
    "PairTable",
    "Precision",
    "StepSettings",
    "System",
    "TemperatureSchedule",
    "Transport",
    "bonded_laws",
    "charge_methods",
    "charge_shapes",
    "evaluate_bonded",
    "evaluate_charge",
    "evaluate_pair",
    "has_threads",
    "heat_account",
    "internal_energy",
    "mix",
    "mixing_rules",
    "pair_laws",
    "pair_noise",
    "pair_range",
    "pair_rounds",
    "pair_tail",
    "philox",
    "present_kinetic_energy",
    "set_heat",
    "set_heat_account",
    "set_threads",
    "thread_limit",
    "word_noise",
]

class BondedTerms:
    """
    The bonded terms of one System.
    """
    def __init__(
        self, frozen: collections.abc.Sequence[bool], thermal_energy: typing.SupportsFloat | typing.SupportsIndex
    ) -> None: ...
    def add(
        self,
        kind: str,
        key: str,
        parameters: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        beads: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32],
    ) -> None:
        """
        Adds terms of one law and one set of parameters; beads has one term a row, ids counted from 0.
        """
    def add_scaled_pair(
        self,
        i: typing.SupportsInt | typing.SupportsIndex,
        j: typing.SupportsInt | typing.SupportsIndex,
        scale: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        A pair that feels its pair law times a factor, without drag and noise.
        """
    def set_anchors(self, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 3]"]) -> None:
        """
        Where tethers hold their beads, (N, 3).
        """

class ChargeNumbers:
    """
    What Coulomb methods are made from; see cpp/charge.
    """
    def __init__(self) -> None: ...
    @property
    def alpha(self) -> float: ...
    @alpha.setter
    def alpha(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def cutoff(self) -> float: ...
    @cutoff.setter
    def cutoff(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def permittivity(self) -> float: ...
    @permittivity.setter
    def permittivity(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class ChargeSettings:
    """
    The electrostatics of a scene; see cpp/charge/charge_forces.hpp.
    """

    method: str
    numbers: ChargeNumbers
    shape: str
    def __init__(self) -> None: ...
    @property
    def counts(self) -> typing.Annotated[list[int], "FixedSize(3)"]: ...
    @counts.setter
    def counts(
        self,
        arg0: typing.Annotated[collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], "FixedSize(3)"],
    ) -> None: ...
    @property
    def length(self) -> float: ...
    @length.setter
    def length(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def order(self) -> int: ...
    @order.setter
    def order(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def strength(self) -> float: ...
    @strength.setter
    def strength(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class PairTable:
    """
    What acts between every two species; makes one System.
    """
    def __init__(self, species: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def set_drag(
        self,
        a: typing.SupportsInt | typing.SupportsIndex,
        b: typing.SupportsInt | typing.SupportsIndex,
        drag: typing.SupportsFloat | typing.SupportsIndex,
        noise: typing.SupportsFloat | typing.SupportsIndex,
        cutoff: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...
    def set_law(
        self,
        a: typing.SupportsInt | typing.SupportsIndex,
        b: typing.SupportsInt | typing.SupportsIndex,
        key: str,
        parameters: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        cutoff: typing.SupportsFloat | typing.SupportsIndex,
        force_shift: bool = False,
    ) -> None: ...
    def set_table(
        self,
        a: typing.SupportsInt | typing.SupportsIndex,
        b: typing.SupportsInt | typing.SupportsIndex,
        energy: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        virial: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        spacing: typing.SupportsFloat | typing.SupportsIndex,
        cutoff: typing.SupportsFloat | typing.SupportsIndex,
        force_shift: bool = False,
    ) -> None: ...

class Precision:
    """
    How pairs are computed; see cpp/integrate/step_settings.hpp.

    Members:

      reference

      double_precision

      mixed
    """

    __members__: typing.ClassVar[dict[str, Precision]]
    double_precision: typing.ClassVar[Precision]
    mixed: typing.ClassVar[Precision]
    reference: typing.ClassVar[Precision]
    @typing.overload
    def __eq__(self, other: Precision) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: Precision) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class Order:
    """
    The integrators; see cpp/integrate.

    Members:

      velocity_verlet

      dpdvv

      scvv

      zeroth

      first

      second

      peters

      peters_first

      lowe_andersen

      stoyanov_groot

      ou

      ou_middle

      middle

      nose_hoover_langevin

      langevin

      berendsen

      hoover
    """

    __members__: typing.ClassVar[dict[str, Order]]
    berendsen: typing.ClassVar[Order]
    dpdvv: typing.ClassVar[Order]
    first: typing.ClassVar[Order]
    hoover: typing.ClassVar[Order]
    langevin: typing.ClassVar[Order]
    lowe_andersen: typing.ClassVar[Order]
    middle: typing.ClassVar[Order]
    nose_hoover_langevin: typing.ClassVar[Order]
    ou: typing.ClassVar[Order]
    ou_middle: typing.ClassVar[Order]
    peters: typing.ClassVar[Order]
    peters_first: typing.ClassVar[Order]
    scvv: typing.ClassVar[Order]
    second: typing.ClassVar[Order]
    stoyanov_groot: typing.ClassVar[Order]
    velocity_verlet: typing.ClassVar[Order]
    zeroth: typing.ClassVar[Order]
    @typing.overload
    def __eq__(self, other: Order) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: Order) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class TemperatureSchedule:
    """
    k_B T against time; see step_settings.hpp.
    """
    def __init__(self) -> None: ...
    def at(
        self,
        time: typing.SupportsFloat | typing.SupportsIndex,
        thermal_energy: typing.SupportsFloat | typing.SupportsIndex,
    ) -> float: ...
    @property
    def amplitude(self) -> float: ...
    @amplitude.setter
    def amplitude(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def energies(self) -> list[float]: ...
    @energies.setter
    def energies(self, arg0: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...
    @property
    def period(self) -> float: ...
    @period.setter
    def period(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def phase(self) -> float: ...
    @phase.setter
    def phase(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def times(self) -> list[float]: ...
    @times.setter
    def times(self, arg0: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...

class CellMotion:
    """
    Which edges of the cell follow the pressure; see step_settings.hpp.

    Members:

      fixed

      isotropic

      height

      square

      edges
    """

    __members__: typing.ClassVar[dict[str, CellMotion]]
    edges: typing.ClassVar[CellMotion]
    fixed: typing.ClassVar[CellMotion]
    height: typing.ClassVar[CellMotion]
    isotropic: typing.ClassVar[CellMotion]
    square: typing.ClassVar[CellMotion]
    @typing.overload
    def __eq__(self, other: CellMotion) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: CellMotion) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class Barostat:
    """
    A Langevin piston; see cpp/integrate/piston.hpp.
    """

    motion: CellMotion
    def __init__(self) -> None: ...
    @property
    def friction(self) -> float: ...
    @friction.setter
    def friction(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def pressure(self) -> typing.Annotated[list[float], "FixedSize(3)"]: ...
    @pressure.setter
    def pressure(
        self,
        arg0: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"],
    ) -> None: ...
    @property
    def relaxation(self) -> float: ...
    @relaxation.setter
    def relaxation(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def tail(self) -> float: ...
    @tail.setter
    def tail(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def tension(self) -> float: ...
    @tension.setter
    def tension(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class StepSettings:
    """
    How a step is taken; see cpp/integrate/step_settings.hpp.
    """

    barostat: Barostat
    drag: bool
    half_step_kinetic: bool
    order: Order
    precision: Precision
    remove_drift: bool
    schedule: TemperatureSchedule
    def __init__(self) -> None: ...
    @property
    def collision_rate(self) -> float: ...
    @collision_rate.setter
    def collision_rate(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def degrees_of_freedom(self) -> int: ...
    @degrees_of_freedom.setter
    def degrees_of_freedom(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def equilibration_steps(self) -> int: ...
    @equilibration_steps.setter
    def equilibration_steps(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def force_cap(self) -> float: ...
    @force_cap.setter
    def force_cap(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def passes(self) -> int: ...
    @passes.setter
    def passes(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def prediction(self) -> float: ...
    @prediction.setter
    def prediction(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def regauss_every(self) -> int: ...
    @regauss_every.setter
    def regauss_every(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def relaxation(self) -> float: ...
    @relaxation.setter
    def relaxation(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def rescale_every(self) -> int: ...
    @rescale_every.setter
    def rescale_every(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def seed(self) -> int: ...
    @seed.setter
    def seed(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def shear_rate(self) -> float: ...
    @shear_rate.setter
    def shear_rate(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def thermal_energy(self) -> float: ...
    @thermal_energy.setter
    def thermal_energy(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def thermostat_coupling(self) -> float: ...
    @thermostat_coupling.setter
    def thermostat_coupling(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def thermostat_every(self) -> int: ...
    @thermostat_every.setter
    def thermostat_every(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def thermostat_friction(self) -> float: ...
    @thermostat_friction.setter
    def thermostat_friction(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def thermostat_mass(self) -> float: ...
    @thermostat_mass.setter
    def thermostat_mass(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def timestep(self) -> float: ...
    @timestep.setter
    def timestep(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def tolerance(self) -> float: ...
    @tolerance.setter
    def tolerance(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def transverse_drag(self) -> float: ...
    @transverse_drag.setter
    def transverse_drag(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def weight_exponent(self) -> float: ...
    @weight_exponent.setter
    def weight_exponent(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class System:
    """
    State, forces and integrator of one simulation.
    """

    settings: StepSettings
    def __init__(
        self,
        cell: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 3]"],
        periodic: typing.Annotated[collections.abc.Sequence[bool], "FixedSize(3)"],
        positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 3]"],
        velocities: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 3]"],
        mass: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        species: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
        frozen: collections.abc.Sequence[bool],
        pairs: PairTable,
        settings: StepSettings,
    ) -> None: ...
    def add_external_field(
        self,
        key: str,
        parameters: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        charges: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [],
    ) -> None: ...
    def add_soft_walls(
        self,
        walled: typing.Annotated[collections.abc.Sequence[bool], "FixedSize(3)"],
        distance: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        strengths: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        reach: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        A soft repulsion before the walls; see cpp/external/soft_walls.hpp.
        """
    def configurational(self) -> tuple[float, float]:
        """
        Σ|∇U|² and Σ∇²U over the mobile beads at the present positions.
        """
    def distance_counts(self) -> numpy.typing.NDArray[numpy.int64]: ...
    def draw_velocities(self, zero_momentum: bool) -> None: ...
    def enable_distances(
        self,
        reach: typing.SupportsFloat | typing.SupportsIndex,
        bins: typing.SupportsInt | typing.SupportsIndex,
        every: typing.SupportsInt | typing.SupportsIndex,
        after: typing.SupportsInt | typing.SupportsIndex = 0,
    ) -> None: ...
    def exchange(
        self,
        temperatures: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        concentrations: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, n]"],
    ) -> None:
        """
        Replace what beads carry between two steps, as a process does: forces stay those of the last step.
        """
    def initialise(self) -> None:
        """
        Computes and observes the forces of the present state.
        """
    def local_densities(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Local densities (N,) at the last evaluation of forces.
        """
    def meet_constraints(self) -> None:
        """
        Brings positions to the lengths of constraints, and takes out of velocities what would change them.
        """
    def plan(self) -> str:
        """
        How steps are computed: the fast path, or the general one and why.
        """
    def remove_drift(self) -> None: ...
    def rescale_velocities(self) -> None: ...
    def restore_distances(
        self,
        counts: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
        samples: typing.SupportsInt | typing.SupportsIndex,
        volumes: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...
    def run(self, steps: typing.SupportsInt | typing.SupportsIndex) -> None:
        """
        Takes steps and observes the last one.
        """
    def sample_distances(self) -> None:
        """
        Counts the pair distances of the present positions as one more sample, whatever the step.
        """
    def set_bonded(
        self,
        terms: BondedTerms,
        excluded: collections.abc.Sequence[
            tuple[typing.SupportsInt | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex]
        ],
    ) -> None:
        """
        Takes the bonded terms, which are then empty, and the pairs of beads that have no pair forces.
        """
    def set_cell_width(self, width: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Link cells of at least this width instead of one range; never changes results.
        """
    def set_charges(
        self,
        charges: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        settings: ChargeSettings,
        excluded: collections.abc.Sequence[
            tuple[typing.SupportsInt | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex]
        ],
        scaled: collections.abc.Sequence[
            tuple[typing.SupportsInt | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex]
        ],
        scales: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
    ) -> None:
        """
        Adds electrostatics: charges (N,) in e, pairs without it, and pairs that feel it times a factor.
        """
    def set_constraints(
        self,
        beads: collections.abc.Sequence[
            tuple[typing.SupportsInt | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex]
        ],
        lengths: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        tolerance: typing.SupportsFloat | typing.SupportsIndex,
        most_iterations: typing.SupportsInt | typing.SupportsIndex,
    ) -> None:
        """
        Takes pairs of beads whose distances stay fixed.
        """
    def set_many_body(
        self,
        kernel: str,
        strength: typing.SupportsFloat | typing.SupportsIndex,
        powers: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        pairs: collections.abc.Sequence[
            tuple[
                typing.SupportsInt | typing.SupportsIndex,
                typing.SupportsInt | typing.SupportsIndex,
                typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(4)"],
            ]
        ],
    ) -> None:
        """
        Adds many-body DPD: one power m a species, and (a, b, (W(0), n, r_d, push)) of pairs of species.
        """
    def set_walls(
        self,
        walled: typing.Annotated[collections.abc.Sequence[bool], "FixedSize(3)"],
        distance: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        bounce_back: bool,
    ) -> None:
        """
        Hard walls across these axes at these distances from the origin on both sides.
        """
    def stress_profile(
        self, axis: typing.SupportsInt | typing.SupportsIndex, layers: typing.SupportsInt | typing.SupportsIndex
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.int64],
    ]:
        """
        Σ m v_a v_b, Σ F_a r_b of pairs and of bonded terms, (layers, 6) each, and beads (layers, species).
        """
    def wrap(self) -> None:
        """
        Brings positions that were set back into the cell, counting the cells they cross.
        """
    @property
    def bead_temperatures(self) -> list[float]:
        """
        Internal temperatures (N,) as k_B T; empty: beads have none.
        """
    @bead_temperatures.setter
    def bead_temperatures(
        self, arg1: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]
    ) -> None: ...
    @property
    def bonded_energies(self) -> list[float]:
        """
        Energies of bonds, angles, dihedrals, inversions and tethers.
        """
    @property
    def bonded_virial_tensors(self) -> list[typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]]:
        """
        Σ F_a r_b of bonds, angles, dihedrals, inversions and tethers.
        """
    @property
    def cell(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]:
        """
        Cell vectors by row. Setting them leaves the positions as they are.
        """
    @cell.setter
    def cell(self, arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 3]"]) -> None: ...
    @property
    def cell_counts(self) -> typing.Annotated[list[int], "FixedSize(3)"]: ...
    @property
    def charge_energy(self) -> float: ...
    @property
    def charge_virial_tensor(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]:
        """
        Σ F_a r_b of the electrostatics.
        """
    @property
    def concentrations(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]"]:
        """
        Of dissolved species in the beads, (N, species); empty: beads carry none.
        """
    @concentrations.setter
    def concentrations(self, arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, n]"]) -> None: ...
    @property
    def conservative_virial_tensor(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]: ...
    @property
    def constraint_deviation(self) -> float:
        """
        Largest difference between a constrained distance and its length.
        """
    @property
    def constraint_virial_tensor(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]:
        """
        Σ F_a r_b of the forces that hold the lengths of constraints, at the present forces and velocities.
        """
    @property
    def distance_samples(self) -> int: ...
    @property
    def distance_volumes(self) -> float:
        """
        Sum of the cell's volumes over the samples.
        """
    @property
    def drag_virial_tensor(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]: ...
    @property
    def field_energy(self) -> float: ...
    @property
    def forces(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 3]"]: ...
    @forces.setter
    def forces(self, arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 3]"]) -> None: ...
    @property
    def heat_capacities(self) -> list[float]:
        """
        C_v/k_B of the beads (N,); empty: beads have none.
        """
    @heat_capacities.setter
    def heat_capacities(self, arg1: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...
    @property
    def images(self) -> typing.Annotated[numpy.typing.NDArray[numpy.int32], "[m, 3]"]: ...
    @images.setter
    def images(self, arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.int32, "[m, 3]"]) -> None: ...
    @property
    def kinetic_tensor(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]:
        """
        Σ m v_a v_b, of velocities relative to the flow in a sheared cell.
        """
    @property
    def momentum(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]: ...
    @property
    def noise_virial_tensor(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 3]"]: ...
    @property
    def pair_energy(self) -> float: ...
    @property
    def positions(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 3]"]: ...
    @positions.setter
    def positions(self, arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 3]"]) -> None: ...
    @property
    def ready(self) -> bool:
        """
        Whether the forces belong to the present positions.
        """
    @ready.setter
    def ready(self, arg0: bool) -> None: ...
    @property
    def step(self) -> int: ...
    @step.setter
    def step(self, arg1: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def thermostat(self) -> list[float]:
        """
        Variables that a thermostat or barostat keeps from step to step.
        """
    @thermostat.setter
    def thermostat(self, arg1: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...
    @property
    def thermostat_energy(self) -> float:
        """
        What a Nosé–Hoover thermostat adds to the conserved energy, or a piston to the energy: its own and P V.
        """
    @property
    def time(self) -> float: ...
    @time.setter
    def time(self, arg1: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def velocities(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 3]"]: ...
    @velocities.setter
    def velocities(self, arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 3]"]) -> None: ...
    @property
    def volume(self) -> float: ...

class HeatPairs:
    """
    Coefficients of beads that carry heat; see cpp/meso/heat_pairs.hpp.
    """

    scaled_repulsion: bool
    def __init__(
        self,
        species: typing.SupportsInt | typing.SupportsIndex,
        reference: typing.SupportsFloat | typing.SupportsIndex,
        weight_exponent: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...
    def set(
        self,
        a: typing.SupportsInt | typing.SupportsIndex,
        b: typing.SupportsInt | typing.SupportsIndex,
        conductivity: typing.SupportsFloat | typing.SupportsIndex,
        reach: typing.SupportsFloat | typing.SupportsIndex,
        exponent: typing.SupportsFloat | typing.SupportsIndex,
        weight: typing.Annotated[
            collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(4)"
        ] = [0.0, 0.0, 0.0, 0.0],
        conduction: typing.Annotated[
            collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(4)"
        ] = [0.0, 0.0, 0.0, 0.0],
        drag: typing.Annotated[
            collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(4)"
        ] = [0.0, 0.0, 0.0, 0.0],
    ) -> None: ...
    @property
    def held(self) -> list[bool]:
        """
        Beads whose temperature stays what it is, (N,).
        """
    @held.setter
    def held(self, arg1: collections.abc.Sequence[bool]) -> None: ...

class Transport:
    """
    Transport of dissolved species; see cpp/meso/species_transport.hpp.
    """
    def __init__(
        self,
        bead_species: typing.SupportsInt | typing.SupportsIndex,
        dissolved: typing.SupportsInt | typing.SupportsIndex,
    ) -> None: ...
    def add_hold(
        self,
        bead_species: typing.SupportsInt | typing.SupportsIndex,
        dissolved: typing.SupportsInt | typing.SupportsIndex,
        value: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        Beads of a species keep this concentration.
        """
    def add_reaction(
        self,
        rate: typing.SupportsFloat | typing.SupportsIndex,
        reactants: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
        change: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        bead_species: typing.SupportsInt | typing.SupportsIndex = -1,
    ) -> None:
        """
        Of one or two reactants; the change of every dissolved species in it; -1: in all beads.
        """
    def add_source(
        self,
        dissolved: typing.SupportsInt | typing.SupportsIndex,
        rate: typing.SupportsFloat | typing.SupportsIndex,
        region: str,
        numbers: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
    ) -> None:
        """
        Amount a bead and time, everywhere, in the beads of a species, a box (x0 x1 y0 y1 z0 z1) or a sphere
        (x y z radius).
        """
    def join(self, system: System) -> None:
        """
        Has the system take it in every step from now on.
        """
    def set_flux(
        self,
        a: typing.SupportsInt | typing.SupportsIndex,
        b: typing.SupportsInt | typing.SupportsIndex,
        dissolved: typing.SupportsInt | typing.SupportsIndex,
        rate: typing.SupportsFloat | typing.SupportsIndex,
        reach: typing.SupportsFloat | typing.SupportsIndex,
        exponent: typing.SupportsFloat | typing.SupportsIndex,
        noise: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None:
        """
        Exchange of a dissolved species between beads of two species.
        """
    def set_noise(self, noise: str) -> None:
        """
        off, sqrt or lammps.
        """
    @property
    def tally(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]"]:
        """
        What sources, reactions and held beads have given, and what these sums lost to rounding: (6, n).
        """
    @tally.setter
    def tally(self, arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, n]"]) -> None: ...

def bonded_laws() -> list[dict[str, typing.Any]]:
    """
    Every bonded law: kind, keys, parameter names and what the scene must know about it.
    """

def charge_methods() -> list[dict[str, typing.Any]]:
    """
    Every Coulomb method: name, description, whether it sums over reciprocal vectors and knows smeared charges.
    """

def charge_shapes() -> list[dict[str, typing.Any]]:
    """
    Every shape of charges: name, description, whether charges may coincide.
    """

def evaluate_bonded(
    kind: str,
    key: str,
    parameters: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
    coordinates: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    Energies (n,) and derivatives (n, k) of a law at the coordinates (n, k): a length or an angle, or for angles
    the angle and both distances from the vertex. Angles in radians. Raises ValueError naming a bad parameter.
    """

def evaluate_charge(
    method: str,
    shape: str,
    length: typing.SupportsFloat | typing.SupportsIndex,
    numbers: ChargeNumbers,
    distances: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    u(r) and -u'(r)/r, (n,) each, of two unit charges as they act within the cutoff; of Ewald's sum the part of
    the pairs. Raises ValueError for unknown names and numbers without meaning.
    """

def evaluate_pair(
    key: str,
    parameters: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
    cutoff: typing.SupportsFloat | typing.SupportsIndex,
    distances: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    force_shift: bool = False,
    table: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None,
    spacing: typing.SupportsFloat | typing.SupportsIndex = 0.0,
) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    U and -dU/dr (internal units, arrays shaped like distances in Å) of one pair law, zero from the cutoff on.

    table: (points, 2) array of U and G = -r dU/dr at r = spacing, 2 spacing, ...; only for tab.
    Raises ValueError for an unknown key and for parameters outside their range.
    """

def has_threads() -> bool:
    """
    Whether the core was built with OpenMP.
    """

def heat_account(system: System) -> tuple[float, float]:
    """
    What sources and held beads gave since the start, and the work charged ahead; see state.hpp.
    """

def internal_energy(system: System) -> float:
    """
    Sum of heat capacity times temperature of all beads.
    """

def mix(
    rule: str,
    key: str,
    parameters_i: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
    parameters_j: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
    drag_i: typing.SupportsFloat | typing.SupportsIndex,
    drag_j: typing.SupportsFloat | typing.SupportsIndex,
) -> tuple[list[float], float]:
    """
    Parameters and drag of the pair i-j from those of i-i and j-j, which follow the same pair law.

    Raises ValueError for laws that cannot be mixed and for numbers the rule cannot take.
    """

def mixing_rules() -> list[str]:
    """
    Names of the mixing rules; DL_POLY's spellings are accepted as well.
    """

def pair_laws() -> list[dict[str, typing.Any]]:
    """
    Every pair law: key, parameter names and what the scene must know about it.
    """

def pair_noise(
    seed: typing.SupportsInt | typing.SupportsIndex,
    step: typing.SupportsInt | typing.SupportsIndex,
    i: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32],
    j: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32],
    image: typing.SupportsInt | typing.SupportsIndex = 0,
) -> typing.Any:
    """
    Standard normal noise of the pairs (i, j) of bead ids (from 0) in a step; precision reference.
    """

def pair_range(key: str, parameters: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> float:
    """
    Distance in Å where the law itself ends; 0 when it ends at the run's cutoff.
    """

def pair_rounds(
    first: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
    second: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
) -> tuple[list[int], list[int]]:
    """
    Pairs of beads in rounds without common beads: each pair's place, and where the rounds start.
    """

def pair_tail(
    key: str,
    parameters: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
    cutoff: typing.SupportsFloat | typing.SupportsIndex,
) -> tuple[float, float]:
    """
    Integrals of U r^2 dr and of r^3 dU/dr dr beyond the cutoff; (0, 0) for laws that have no such tail.
    """

def philox(
    counter: typing.Annotated[collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], "FixedSize(4)"],
    key: typing.SupportsInt | typing.SupportsIndex,
) -> typing.Annotated[list[int], "FixedSize(4)"]:
    """
    The four words of Philox4x32-10 for one counter and key.
    """

def present_kinetic_energy(system: System) -> float:
    """
    Of the present velocities, which may not be those that the kinetic stress is made of.
    """

def set_heat(
    system: System,
    pairs: HeatPairs,
    conserving: bool,
    sources: collections.abc.Sequence[
        tuple[
            str,
            collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
            typing.SupportsFloat | typing.SupportsIndex,
        ]
    ],
) -> None:
    """
    Gives beads that carry heat their coefficients, once; sources: (box, sphere or species, numbers, rate).
    """

def set_heat_account(
    system: System,
    supplied: typing.SupportsFloat | typing.SupportsIndex,
    ahead: typing.SupportsFloat | typing.SupportsIndex,
) -> None: ...
def set_threads(threads: typing.SupportsInt | typing.SupportsIndex) -> None:
    """
    Number of threads of the next parallel regions.
    """

def thread_limit() -> int:
    """
    Number of threads that would be used now.
    """

def word_noise(
    seed: typing.SupportsInt | typing.SupportsIndex,
    step: typing.SupportsInt | typing.SupportsIndex,
    i: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32],
    j: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32],
    image: typing.SupportsInt | typing.SupportsIndex = 0,
) -> typing.Any:
    """
    Uniform noise of unit variance of the pairs (i, j) in a step, mixed from the beads' random words.
    """

__version__: str = "0.1.0"
