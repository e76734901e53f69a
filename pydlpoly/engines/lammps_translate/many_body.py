"""Many-body DPD with Lucy's kernel as ``mdpd/rhosum`` and ``mdpd``.

The attraction is ``harmonic/cut`` and drag and noise are those of every scene, so that energy and virial come apart;
``mdpd`` has the force of the densities alone, whose energy is none.
"""

from __future__ import annotations

from pydlpoly.engines.lammps_translate.carried import frozen_species
from pydlpoly.engines.lammps_translate.exclusions import Exclusions
from pydlpoly.engines.lammps_translate.formulas import number
from pydlpoly.engines.lammps_translate.pairs import SubStyle, types_of
from pydlpoly.engines.lammps_translate.refusal import Places, refusal
from pydlpoly.scene.model import ManyBody, Scene

DENSITY_STYLE, FORCE_STYLE = "mdpd/rhosum", "mdpd"

MANY_BODY: tuple[tuple[str, str, str], ...] = (
    (
        "`mdpd_kernel lucy`: B, r_d",
        "`mdpd/rhosum` and `mdpd` with A = γ = 0",
        "forces and virial to 1e-10, densities to 1e-12; as in the native engine the energy has no many-body part",
    ),
    ("A, r_c", "`harmonic/cut`", "energy, forces and virial to 1e-10"),
    ("γ, r_γ; integrators", "as in every scene", "as in every scene"),
    ("masses", "B and ρ̄ over the mass: LAMMPS weighs densities with masses", "equal for one mass, others are refused"),
    ("molecules", "`atom_style hybrid`", "as in every scene; refused where LAMMPS keeps excluded pairs in its lists"),
    ("frozen beads", "without forces among themselves", "densities, forces and virial; species wholly frozen or not"),
    ("`mdpd_kernel warren`, the generalised form", "refused", "LAMMPS has Lucy's kernel and no other"),
)
"""What a scene says, what it becomes, and what is equal: rows of docs/lammps.md."""


def refuse_many_body(scene: Scene, given: ManyBody, exclusions: Exclusions, places: Places) -> None:
    """Raise SceneError for what LAMMPS's many-body DPD cannot do."""
    if given.kernel != "lucy":
        message = f"mdpd with the kernel {given.kernel} cannot be run"
        where = next((pair.explanation for pair in scene.pairs if pair.law == "mdpd"), given.explanation)
        raise refusal(message, places.of_text(where), "LAMMPS has the kernel of mdpd_kernel lucy")
    bead_mass(scene, places)
    long_range = scene.electrostatics is not None and scene.electrostatics.method == "ewald"
    if exclusions.any and (long_range or not exclusions.leave_lists):
        message = "mdpd beside pairs that bonds exclude but that feel something else cannot be run"
        where = next((term.explanation for term in scene.bonded.terms), "") if scene.bonded is not None else ""
        raise refusal(message, places.of_text(where), "LAMMPS would count them in the local densities")


def bead_mass(scene: Scene, places: Places) -> float:
    """Return the mass of all beads, which LAMMPS's densities are multiplied by; raises SceneError for several."""
    assert scene.many_body is not None
    kinds = sorted({k for term in scene.many_body.terms for k in term.species})
    masses = sorted({float(m) for k in kinds for m in scene.beads.mass[scene.beads.species == k]})
    if len(masses) > 1:
        where = next((pair.explanation for pair in scene.pairs if pair.law == "mdpd"), "")
        message = f"mdpd between beads of the masses {', '.join(f'{m:g}' for m in masses)} cannot be run"
        raise refusal(message, places.of_text(where), "LAMMPS weighs local densities with masses")
    return masses[0] if masses else 1.0


def density_coefficients(given: ManyBody) -> list[str]:
    """Return the ``pair_coeff`` lines of the densities."""
    return [f"pair_coeff {types_of(t.species)} {DENSITY_STYLE} {number(t.range)}" for t in given.terms]


def force_coefficients(scene: Scene, given: ManyBody, mass: float) -> list[str]:
    """Return the ``pair_coeff`` lines of the force of the densities alone, A and γ being 0."""
    still = set(frozen_species(scene))
    return [
        f"pair_coeff {types_of(t.species)} {FORCE_STYLE} 0.0 {number(t.push / mass)} 0.0 {number(t.range)} "
        f"{number(t.range)}"
        for t in given.terms
        if not still.issuperset(t.species)
    ]


def many_body_styles(scene: Scene, seed: int, exclusions: Exclusions, places: Places) -> list[SubStyle]:
    """Return the sub-styles of densities and their force, densities first. Raises SceneError for what is refused."""
    given = scene.many_body
    if given is None:
        return []
    refuse_many_body(scene, given, exclusions, places)
    mass = bead_mass(scene, places)
    reach = max(term.range for term in given.terms)
    densities = SubStyle(DENSITY_STYLE, "", tuple(density_coefficients(given)))
    forces = force_coefficients(scene, given, mass)
    styles = [densities]
    if forces:
        styles.append(SubStyle(FORCE_STYLE, f"0.0 {number(reach)} {seed}", tuple(forces)))
    return styles
