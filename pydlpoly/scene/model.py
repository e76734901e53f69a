"""The scene: everything that is to be modelled, complete, in internal units, immutable.

Internal units are DL_POLY's: Å, ps, Da, e, energy 10 J/mol = 1 Da Å²/ps². In a scene with ``units dpd`` the same
numbers are read as reduced ones (k_B = 1). ``thermal_energy`` is always k_B T in the internal energy unit, so that
nothing below the scene needs to know a Boltzmann constant.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.transport_terms import Transport

if TYPE_CHECKING:
    from pydlpoly.units import EnergyUnit

Start = Literal["clean", "rescale", "noscale", "continue"]
Precision = Literal["double", "mixed", "reference"]
MOST_THREADS = 1024  # systems give a process so many at most; the run-time library ends the process where they do not
BondedKind = Literal["bond", "angle", "dihedral", "inversion", "tether"]
CellMotion = Literal["isotropic", "height", "square", "edges"]
SemiIsotropic = Literal["off", "area", "tension", "orthorhombic"]
Axis = Literal["x", "y", "z"]
Origin = Literal["given", "mixed", "filled", "overridden", "default", "none"]


@dataclass(frozen=True)
class Note:
    """Something the user should know: a warning, or a piece of input that has no effect and why.

    ``kind`` is "warning" (could change results), "ignored" (read, without effect here) or "choice" (a default taken).
    """

    kind: Literal["warning", "ignored", "choice"]
    text: str
    where: str = ""


@dataclass(frozen=True, eq=False)
class Beads:
    """Per-bead arrays in file order (bead id = index, files count from 1).

    Attributes:
        species: (N,) index into ``Scene.species``.
        mass: (N,) in Da.
        charge: (N,) in e.
        frozen: (N,) True for beads that never move.
        molecule: (N,) running number of the molecule each bead belongs to.
        positions: (N, 3) in Å, wrapped into the cell around the origin along periodic axes.
        velocities: (N, 3) in Å/ps, or None when they are to be drawn.
        temperature: (N,) internal temperature as k_B T, internal energy units; None where beads carry no heat.
        heat_capacity: (N,) C_v/k_B; None where beads carry no heat.
        concentrations: (N, s) of dissolved species; None where beads carry none.
    """

    species: NDArray[np.int32]
    mass: FloatArray
    charge: FloatArray
    frozen: NDArray[np.bool_]
    molecule: NDArray[np.int64]
    positions: FloatArray
    velocities: FloatArray | None
    temperature: FloatArray | None = None
    heat_capacity: FloatArray | None = None
    concentrations: FloatArray | None = None

    def __len__(self) -> int:
        """Return the number of beads."""
        return len(self.mass)


@dataclass(frozen=True, eq=False)
class PairTerm:
    """What acts between two species, with the origin of every number.

    Attributes:
        species: indices a ≤ b into ``Scene.species``.
        law: the pair law's key ("dpd", "lj", …), or None when the pair has no conservative interaction.
        parameters: the law's own parameters, in internal units, in the order of the law's registry entry.
        cutoff: where the conservative law ends (Å).
        force_shift: whether U and F are shifted to vanish at the cutoff.
        drag: γ_ij (Da/ps), 0 without a pair thermostat.
        drag_cutoff: range of the drag and noise (Å).
        noise: σ_ij = √(2 γ_ij k_B T).
        law_origin, drag_origin: where the numbers come from.
        explanation: the same in words, for the printed table ("FIELD line 18", "mixed from A A and B B by …").
        table: (2, n) energy and −r dU/dr of a tabulated law at r = spacing·(1…n), else None.
        table_spacing: grid spacing of ``table`` (Å).
    """

    species: tuple[int, int]
    law: str | None
    parameters: tuple[float, ...] = ()
    cutoff: float = 0.0
    force_shift: bool = False
    drag: float = 0.0
    drag_cutoff: float = 0.0
    noise: float = 0.0
    law_origin: Origin = "none"
    drag_origin: Origin = "none"
    explanation: str = ""
    table: FloatArray | None = None
    table_spacing: float = 0.0


@dataclass(frozen=True)
class DensityTerm:
    """What two species are to each other's local densities in many-body DPD.

    Attributes:
        species: indices a ≤ b into ``Scene.species``.
        height: W(0) of the kernel.
        exponent: n of W(0) (1 − r/r_d)^n; 2 with Lucy's kernel, whose shape it does not tell.
        range: r_d (Å).
        push: k of the force k (φ_i + φ_j)(1 − r/r_d)^(n − 1), where φ is ψ'(ρ̄), or ρ̄ with Lucy's kernel.
    """

    species: tuple[int, int]
    height: float
    exponent: float
    range: float
    push: float


@dataclass(frozen=True)
class ManyBody:
    """Many-body DPD: the energy Σ ψ(ρ̄_i) of local densities ρ̄_i = Σ W(r_ij) over all neighbours.

    Attributes:
        kernel: "warren" (ψ = C ρ̄^m/m, W = W(0)(1 − r/r_d)^n) or "lucy" (forces only, no energy).
        form: "two-density" (densities per volume, Å⁻³) or "generalised" (times r_c³ of the pair, without unit).
        repulsion: B as FIELD gives it, internal units.
        strength: C, internal units; 0 with Lucy's kernel.
        powers: m by species.
        terms: by pair of species that has the law mdpd.
        explanation: where the kernel comes from.
    """

    kernel: Literal["warren", "lucy"]
    form: Literal["two-density", "generalised"]
    repulsion: float
    strength: float
    powers: tuple[float, ...]
    terms: tuple[DensityTerm, ...]
    explanation: str = ""


@dataclass(frozen=True)
class ExternalTerm:
    """An external field: its key ("grav", "elec", …), its parameters in internal units, and where they come from."""

    key: str
    parameters: tuple[float, ...]
    explanation: str = ""


@dataclass(frozen=True)
class Walls:
    """Walls across axes of the cell, at the same distance from its centre on both sides.

    Attributes:
        method: what a bead does that meets a wall: "reflecting" (its velocity across is reversed) or "bounce-back" (its
            whole velocity is).
        walled: which axes have walls; they are not periodic.
        distance: of the walls from the centre along x, y, z, Å.
        strengths: A of the soft repulsion ½ A r_c (1 − d/r_c)² by species, Da Å/ps²; empty without one.
        range: its r_c, Å.
        explanation: where it comes from ("CONTROL:12").
    """

    method: Literal["reflecting", "bounce-back"]
    walled: tuple[bool, bool, bool]
    distance: tuple[float, float, float]
    strengths: tuple[float, ...] = ()
    range: float = 0.0
    explanation: str = ""


@dataclass(frozen=True, eq=False)
class BondedTerm:
    """Terms of one law with one set of numbers, in all copies of one molecule type.

    Attributes:
        kind: "bond", "angle", "dihedral", "inversion" or "tether".
        law: the law's key without the sign of the restraint form ("harm", "cos", …).
        parameters: the law's numbers in internal units, angles in radians.
        beads: (n, k) ids, one term a row, in FIELD's order: k is 2 for bonds, 3 for angles (the vertex in the middle),
            4 for dihedrals and inversions (the centre first), 1 for tethers.
        restraint: whether the beads keep their pair forces.
        molecule: index into ``Scene.molecule_names``.
        explanation: where the numbers come from ("FIELD:12, FIELD:13").
        table: (2, n) U and dU/dx of a law "tab" at x = table_start + table_spacing (0 … n − 1), internal units and
            radians, else None.
    """

    kind: BondedKind
    law: str
    parameters: tuple[float, ...]
    beads: NDArray[np.int32]
    restraint: bool
    molecule: int
    explanation: str = ""
    table: FloatArray | None = None
    table_start: float = 0.0
    table_spacing: float = 0.0


@dataclass(frozen=True, eq=False)
class Constraints:
    """Distances that stay fixed.

    Attributes:
        beads: (n, 2) ids; at least one of the two can move.
        lengths: (n,) in Å.
        tolerance: by how much a distance may differ from its length, Å.
        most_iterations: of SHAKE and RATTLE in one step.
        explanation: where they come from ("FIELD:12-14").
    """

    beads: NDArray[np.int32]
    lengths: FloatArray
    tolerance: float
    most_iterations: int
    explanation: str = ""


@dataclass(frozen=True, eq=False)
class Bonded:
    """All bonded terms and what they do to the pair forces.

    Attributes:
        terms: by molecule type and kind.
        excluded: (m, 2) ids i < j of pairs without pair forces, drag and noise.
        scaled: (s, 2) ids of excluded pairs that feel their pair law times a factor, as the ends of dihedrals may.
        scales: (s,) those factors.
        anchors: (N, 3) where tethers hold their beads (Å), None without tethers.
        coulomb_scaled: (c, 2) ids of excluded pairs that feel electrostatics times a factor; ``coulomb_scales``: (c,)
            those factors. None without electrostatics.
    """

    terms: tuple[BondedTerm, ...]
    excluded: NDArray[np.int32]
    scaled: NDArray[np.int32]
    scales: FloatArray
    anchors: FloatArray | None = None
    coulomb_scaled: NDArray[np.int32] | None = None
    coulomb_scales: FloatArray | None = None


@dataclass(frozen=True)
class Electrostatics:
    """How the charges of ``Beads`` act.

    Attributes:
        method: the core's name, "pairwise", "force_shifted", "reaction_field", "dddp" or "ewald"; ``keyword``:
            CONTROL's.
        shape: "point", "slater", "slater-exact", "gaussian" or "linear"; ``length``: λ = 1/β, λ, σ or R (Å).
        strength: energy times length of two unit charges, internal units.
        cutoff: of the part between pairs (Å).
        alpha: of Ewald's sum or of the damping (1/Å), 0 for none.
        permittivity: relative, of the reaction field.
        counts: points of the mesh, or reciprocal vectors along each axis in the plain sum.
        order: of the mesh's splines, 0 for the plain sum.
        origins: where the numbers come from, in words.
    """

    method: str
    keyword: str
    shape: str
    length: float
    strength: float
    cutoff: float
    alpha: float = 0.0
    permittivity: float = 1.0
    counts: tuple[int, int, int] = (0, 0, 0)
    order: int = 0
    origins: tuple[str, ...] = ()


@dataclass(frozen=True)
class HeatTerm:
    """What internal temperatures do between two species; x = T̄/T_ref − 1 of the pair's mean temperature.

    Attributes:
        species: indices a ≤ b into ``Scene.species``.
        conductivity: κ₀, 1/ps; ``range``: r_cT, Å (0 without conduction); ``exponent``: of w_T² = (1 − r/r_cT)^s.
        weight, conduction, drag: c₁ … c₄ of the factors 1 + Σ c_k x^k of the exponent of w^D, of κ and of γ.
        explanation: where the numbers come from ("FIELD:12").
    """

    species: tuple[int, int]
    conductivity: float
    range: float
    exponent: float
    weight: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    conduction: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    drag: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    explanation: str = ""


@dataclass(frozen=True)
class HeatSource:
    """A source (or sink) of heat.

    ``numbers`` are x0 x1 y0 y1 z0 z1 of a "box", x y z R of a "sphere" (Å from the cell's centre) and the index of a
    "species"; ``rate`` is d(k_B T)/dt of the beads there, internal energy per ps.
    """

    kind: Literal["box", "sphere", "species"]
    numbers: tuple[float, ...]
    rate: float
    explanation: str = ""


@dataclass(frozen=True)
class Heat:
    """Beads carry heat: C_v T each, with the start values and capacities of ``Beads``.

    Attributes:
        terms: of the pairs that FIELD's block gives; others neither conduct nor depend on temperature.
        sources: what brings heat from outside.
        held: species whose beads keep their temperature.
        reference: k_B T_ref, internal energy.
        viscous_heating: "conserving", or "lammps" for that program's formula (mdvv only).
        scaled_repulsion: conservative forces are multiplied by T̄/T_ref.
        explanation: where it comes from ("FIELD:10").
    """

    terms: tuple[HeatTerm, ...]
    sources: tuple[HeatSource, ...] = ()
    held: tuple[int, ...] = ()
    reference: float = 1.0
    viscous_heating: Literal["conserving", "lammps"] = "conserving"
    scaled_repulsion: bool = False
    explanation: str = ""


@dataclass(frozen=True)
class Schedule:
    """A temperature that varies: straight lines between points, or a sine about ``Dynamics.thermal_energy``.

    Attributes:
        times: ps, ascending; ``energies``: k_B T at those times. Constant before the first and after the last.
        amplitude: of the sine, in k_B T; ``period``: ps.
    """

    times: tuple[float, ...] = ()
    energies: tuple[float, ...] = ()
    amplitude: float = 0.0
    period: float = 0.0


@dataclass(frozen=True)
class Barostat:
    """A Langevin piston that moves the edges of an orthorhombic cell.

    Attributes:
        motion: "isotropic" (all edges by one factor), "height" (z alone), "square" (x and y by one factor, z by
            another) or "edges" (each by its own).
        semi: CONTROL's ``ensemble_semi_isotropic``; it says which columns STATIS has.
        pressure: targets on the faces across x, y, z, internal units.
        relaxation: τ of the mass g k_B T τ², ps; ``friction``: 1/ps.
        tension: surface tension of the plane of x and y, internal units.
    """

    motion: CellMotion
    pressure: tuple[float, float, float]
    relaxation: float
    friction: float
    semi: SemiIsotropic = "off"
    tension: float = 0.0


@dataclass(frozen=True)
class Dynamics:
    """How a step is taken.

    Attributes:
        integrator: "nve", or a name of ``INTEGRATORS`` or ``THERMOSTATS`` of ``pydlpoly.scene.integrators``.
        timestep: Δt in ps.
        thermal_energy: k_B T in internal energy units.
        prediction: Groot–Warren's λ (mdvv).
        half_step_kinetic: the kinetic temperature and stress of mdvv are of the half-step velocities.
        weight_exponent: s of w^D = (1 − r/r_c)^s.
        transverse_drag: drag across the line of a pair as a multiple of its drag (sweeps).
        collision_rate: Γ of lowe-andersen and stoyanov-groot, 1/ps; 0 = ½γ/μ.
        coupling: α of stoyanov-groot, Da/ps.
        tolerance: of scvv's iteration, relative change of the kinetic energy.
        passes: over the pairs in the middle step; ``interval``: steps between thermostat steps of the middle schemes.
        relaxation: of berendsen and hoover, ps.
        thermostat_mass: in units of degrees of freedom times k_B T/γ²; ``thermostat_friction``: 1/ps
            (nose-hoover-langevin, langevin).
        schedule: the temperature where it varies with time.
        barostat: what moves the cell, None where it is fixed.
        shear_rate: ∂u_x/∂y of the flow in a cell with Lees–Edwards boundaries, 1/ps; 0 without them.
        remove_drift: whether the centre-of-mass velocity of the mobile beads is removed in every step.
        precision: arithmetic of the pair forces, "double", "mixed" or "reference".
    """

    integrator: str
    timestep: float
    thermal_energy: float
    prediction: float = 0.5
    weight_exponent: float = 2.0
    half_step_kinetic: bool = False
    transverse_drag: float = 0.0
    collision_rate: float = 0.0
    coupling: float = 0.0
    tolerance: float = 1e-6
    passes: int = 3
    interval: int = 1
    relaxation: float = 0.0
    thermostat_mass: float = 1.0
    thermostat_friction: float = 1.0
    schedule: Schedule | None = None
    barostat: Barostat | None = None
    shear_rate: float = 0.0
    remove_drift: bool = False
    precision: Precision = "double"


@dataclass(frozen=True)
class RunPlan:
    """How long, from what start, with what equilibration.

    Attributes:
        steps: total number of steps, equilibration included.
        equilibration_steps: number of first steps during which equilibration measures act and averages are not taken.
        record_equilibration: take averages from step 1 on.
        rescale_every, regauss_every: intervals in equilibration steps, 0 = never.
        force_cap: largest force on a bead during equilibration (Da Å/ps²), 0 = none.
        seed: seed of all noise and of the start velocities; None = drawn anew and printed.
        start: "clean" draws velocities, "rescale" scales the file's, "noscale" takes them, "continue" goes on from a
            checkpoint.
        checkpoint_file: the checkpoint that "continue" goes on from.
        threads: number of threads, 0 = all that are there.
    """

    steps: int
    equilibration_steps: int = 0
    record_equilibration: bool = False
    rescale_every: int = 0
    regauss_every: int = 0
    force_cap: float = 0.0
    seed: int | None = None
    start: Start = "clean"
    checkpoint_file: str = "REVOLD"
    threads: int = 0

    @property
    def averages_after(self) -> int:
        """Step after which averages are taken."""
        return 0 if self.record_equilibration else self.equilibration_steps


@dataclass(frozen=True)
class ProfilePlan:
    """The stress in layers: along which axis ("x", "y" or "z"), in how many layers, every how many steps (0 = never).

    ``interfaces`` divides the surface tension.
    """

    every: int = 0
    axis: Axis = "z"
    layers: int = 1
    interfaces: int = 2
    file: str | None = "STRPRF"


@dataclass(frozen=True)
class CorrelationTerm:
    """A correlation ⟨σ_A(t) σ_B(t + τ)⟩ of two components of the stress, and the shape of its correlator.

    ``left`` and ``right`` are places in the tensor. Level k of ``blocks`` has lags up to ``points`` − 1 in units of
    ``window``^k samples.
    """

    left: tuple[int, int]
    right: tuple[int, int]
    points: int = 100
    blocks: int = 1
    window: int = 1

    @property
    def name(self) -> str:
        """As in COR."""
        return "-".join("stress_" + "".join("xyz"[k] for k in place) for place in (self.left, self.right))

    @property
    def is_shear(self) -> bool:
        """Whether it is a shear component with itself, as the viscosity needs it."""
        return self.left == self.right and self.left[0] != self.left[1]


@dataclass(frozen=True)
class CorrelationPlan:
    """What is correlated, every how many steps, and how often COR is written beside checkpoints (0 = not)."""

    terms: tuple[CorrelationTerm, ...] = ()
    every: int = 1
    dump_every: int = 0
    file: str | None = "COR"


@dataclass(frozen=True)
class BinPlan:
    """Averages of what beads do and carry in bins along one axis, or along two: every how many steps (0 = never).

    ``quantities`` are names of ``pydlpoly.scene.bins``; empty: all that the scene has.
    """

    every: int = 0
    axes: tuple[Axis, ...] = ("z",)
    bins: tuple[int, ...] = (100,)
    quantities: tuple[str, ...] = ()
    file: str | None = "PROFILE"


@dataclass(frozen=True)
class OutputPlan:
    """What is written, how often (in steps, 0 = never) and under what name (None = not written).

    ``output_file`` "SCREEN" is the standard output. ``trajectory_level`` is DL_POLY's: 0 positions, 1 and velocities,
    2 and forces, 3 compressed. ``rdf_pairs`` holds the pairs of species to be collected, empty when ``rdf_every`` is 0.
    ``trajectory_formats`` are written beside HISTORY, named ``trajectory_stem`` with the format's ending.
    ``zden_bins`` lie over the height of the cell. ``vaf_every`` is the interval between samples of ``vaf_steps`` steps.
    """

    print_every: int = 0
    statistics_every: int = 0
    diagnostics_every: int = 0
    stack_size: int = 100
    statistics_yaml: bool = False
    trajectory_start: int = 0
    trajectory_every: int = 0
    trajectory_level: int = 0
    trajectory_formats: tuple[str, ...] = ()
    rdf_every: int = 0
    rdf_bin_width: float = 0.05
    rdf_pairs: tuple[tuple[int, int], ...] = ()
    checkpoint_every: int = 1000
    output_file: str | None = "OUTPUT"
    statistics_file: str = "STATIS"
    diagnostics_file: str = "DIAGNOSTICS"
    trajectory_file: str | None = "HISTORY"
    trajectory_stem: str = "TRAJECTORY"
    rdf_file: str | None = "RDFDAT"
    configuration_file: str | None = "REVCON"
    checkpoint_file: str | None = "REVIVE"
    profile: ProfilePlan = ProfilePlan()
    correlations: CorrelationPlan = CorrelationPlan()
    zden_every: int = 0
    zden_bins: int = 1
    vaf_every: int = 0
    vaf_steps: int = 1
    vaf_averaging: bool = True
    msd_every: int = 0
    msd_start: int = 0
    msd_file: str = "MSDTMP"
    beads_file: str | None = "REVBEADS"
    bead_profile: BinPlan = BinPlan()
    bead_map: BinPlan = BinPlan(axes=("x", "y"), bins=(50, 50), file="MAP")


@dataclass(frozen=True, eq=False)
class Scene:
    """A complete description of what is to be modelled; see the module's text for the units.

    Attributes:
        units: the energy unit of reports; its ``reduced`` says whether they are in reduced units (k_B = 1).
        cell: (3, 3) cell vectors by row; for axes that are not periodic, the extent DL_POLY would report.
        periodic: periodicity along the three cell vectors.
        pairs: one term for every unordered pair of species, ordered (0,0), (0,1), (1,1), (0,2), …
        cutoff: the global cutoff (RDF range); ``vdw_cutoff``: where laws without a range of their own end.
        degrees_of_freedom: number of momenta that share the kinetic energy.
        long_range_correction: whether energies and pressures include the analytic tails beyond the cutoff.
        molecule_names, molecule_counts: FIELD's molecule types in order, and how many copies of each there are.
        field_units: the energy unit of FIELD's numbers; not ``units`` when CONTROL alone asks for reduced reports.
        notes: everything that was chosen, ignored or is worth a warning, in the order it was met.
        sources: the files the scene was read from.
        source_order: (N,) for scenes made from a structure whose beads had to be sorted: where each bead stood there.
        source_cell: (3, 3) the cell of that structure, when ``cell`` differs from it along axes that are not periodic.
        bonded: bonds, angles, dihedrals, inversions and tethers, and the pairs without pair forces; None when there are
            none.
        constraints: fixed distances; None when there are none.
        walls: walls across axes of the cell; None when there are none.
        electrostatics: how charges act; None when they do not.
        many_body: local densities and what they do to pairs of the law mdpd; None without such pairs.
        transport: dissolved species and what happens to them; None when beads carry none.
        heat: what beads do with the heat they carry; None where they carry none.
    """

    title: str
    units: EnergyUnit
    species: tuple[str, ...]
    beads: Beads
    cell: FloatArray
    imcon: int
    periodic: tuple[bool, bool, bool]
    pairs: tuple[PairTerm, ...]
    external: tuple[ExternalTerm, ...]
    cutoff: float
    vdw_cutoff: float
    dynamics: Dynamics
    run: RunPlan
    output: OutputPlan
    degrees_of_freedom: int
    long_range_correction: bool = True
    molecule_names: tuple[str, ...] = ()
    molecule_counts: tuple[int, ...] = ()
    field_units: EnergyUnit | None = None
    notes: tuple[Note, ...] = ()
    sources: tuple[str, ...] = field(default=())
    source_order: NDArray[np.int64] | None = None
    source_cell: FloatArray | None = None
    bonded: Bonded | None = None
    constraints: Constraints | None = None
    walls: Walls | None = None
    electrostatics: Electrostatics | None = None
    many_body: ManyBody | None = None
    transport: Transport | None = None
    heat: Heat | None = None

    @property
    def constraint_count(self) -> int:
        """Number of fixed distances."""
        return 0 if self.constraints is None else len(self.constraints.lengths)

    @property
    def bead_count(self) -> int:
        """Number of beads."""
        return len(self.beads)

    def explain(self) -> str:
        """Return the scene in words and tables: what is modelled, what is not, and where each number came from."""
        from pydlpoly.scene.explain import explain  # explain imports this module

        return explain(self)
