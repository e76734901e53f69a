"""Many-body DPD: what the ``mdpd`` pairs of a scene are to each other's local densities, and what it cannot do.

Forces of local densities derive from an energy only where B is one number: with B_ij (ρ̄_i + ρ̄_j) between pairs of
different B there is none (Warren, Phys. Rev. E 87, 045303 (2013)). Formulas and their sources: docs/many-body.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from pydlpoly.errors import SceneError
from pydlpoly.formats.records import Field, PairLine
from pydlpoly.scene.many_body_records import KEY, is_two_density
from pydlpoly.scene.model import DensityTerm, ManyBody, PairTerm, Scene
from pydlpoly.scene.settings import Notes, Settings

_SAME = 1e-9  # relative; numbers of FIELD have fewer digits


def resolve_many_body(
    settings: Settings, field: Field, pairs: Iterable[PairTerm], species: tuple[str, ...], notes: Notes
) -> ManyBody | None:
    """Return what ``mdpd`` pairs add to pair forces, None where there are none.

    Args:
        settings: CONTROL, for ``mdpd_kernel``.
        field: FIELD, for the forms of its records and for messages.
        pairs: the pair table; parameters of ``mdpd`` are A B n m r_c r_d.
        species: names of the species.
        notes: receives choices and warnings.

    Raises:
        SceneError: records of both forms, numbers that must be one and are not, or what the kernel cannot take.
    """
    terms = [term for term in pairs if term.law == KEY]
    if not terms:
        return None
    builder = _Builder(settings, field, terms, species, notes)
    return builder.lucy() if builder.kernel == "lucy" else builder.warren()


class _Builder:
    """Reads the records of one scene."""

    def __init__(
        self, settings: Settings, field: Field, terms: list[PairTerm], species: tuple[str, ...], notes: Notes
    ) -> None:
        self._settings, self._field, self._terms = settings, field, terms
        self._species, self._notes = species, notes
        self.kernel = settings.word("mdpd_kernel")
        if settings.word("precision") == "mixed":
            text = "precision mixed: forces of local densities are computed in double precision, on the general path"
            notes.choice(text, settings.where("precision"))
        lines = [line for line in field.pairs if line.key == KEY]
        self._lines: Mapping[frozenset[str], PairLine] = {frozenset(line.species): line for line in lines}
        self._two_density = is_two_density(lines[0].parameters)
        for line in lines:
            if is_two_density(line.parameters) != self._two_density:
                message = (
                    f"{'-'.join(line.species)} has the {_form(not self._two_density)} form, "
                    f"{'-'.join(lines[0].species)} the {_form(self._two_density)} one (line {lines[0].line}): "
                    "one FIELD takes one form, for B has another meaning in each"
                )
                raise SceneError(message, path=field.path, line=line.line or None, word=KEY)
        self._check_repulsion()

    def warren(self) -> ManyBody:
        """Forces of the energy Σ C ρ̄^m/m with W = W(0)(1 − r/r_d)^n."""
        powers = self._powers()
        first = self._terms[0]
        repulsion, range_ = first.parameters[1], first.parameters[5]
        strength = math.pi * range_**4 * repulsion / 15.0 if self._two_density else repulsion
        return ManyBody(
            kernel="warren",
            form="two-density" if self._two_density else "generalised",
            repulsion=repulsion,
            strength=strength,
            powers=powers,
            terms=tuple(self._term(term) for term in self._terms),
            explanation=self._explanation(),
        )

    def lucy(self) -> ManyBody:
        """Forces B (ρ̄_i + ρ̄_j)(1 − r/r_d) with Lucy's kernel, as LAMMPS has them."""
        where = self._settings.where("mdpd_kernel")
        if not self._two_density:
            message = "lucy goes with the two-density form of mdpd alone: A B rc rd"
            raise self._settings.refusal("mdpd_kernel", message)
        self._notes.warning(
            "mdpd_kernel lucy: no potential belongs to these forces. The energy lacks the many-body part, nve does not "
            "conserve it, there is no configurational temperature, and densities and tensions differ from Warren's",
            where,
        )
        terms = []
        for term in self._terms:
            range_ = term.parameters[5]
            terms.append(
                DensityTerm(term.species, 105.0 / (16.0 * math.pi * range_**3), 2.0, range_, term.parameters[1])
            )
        return ManyBody(
            kernel="lucy",
            form="two-density",
            repulsion=self._terms[0].parameters[1],
            strength=0.0,
            powers=(2.0,) * len(self._species),
            terms=tuple(terms),
            explanation=self._explanation(),
        )

    def _term(self, term: PairTerm) -> DensityTerm:
        _, _, n, _, cutoff, range_ = term.parameters
        scale = 1.0 if self._two_density else cutoff**3
        height = (n + 1.0) * (n + 2.0) * (n + 3.0) * scale / (8.0 * math.pi * range_**3)
        return DensityTerm(term.species, height, n, range_, n * height / range_)

    def _check_repulsion(self) -> None:
        """Refuse what no energy belongs to: B that differ, and in the two-density form r_d that differ."""
        first = self._terms[0]
        for term in self._terms[1:]:
            if not math.isclose(term.parameters[1], first.parameters[1], rel_tol=_SAME):
                message = (
                    f"B of {self._name(term)} is {self._given(term, 1):g}, that of {self._name(first)} "
                    f"{self._given(first, 1):g}: B must be one number for all pairs, for no energy belongs to forces "
                    "of local densities with several (no-go theorem, Warren, Phys. Rev. E 87, 045303 (2013)); let A "
                    "differ, or r_d in the generalised form. DL_POLY takes the largest B for all"
                )
                raise self._refusal(term, message)
            if self.kernel == "lucy" or not self._two_density:
                continue
            if not math.isclose(term.parameters[5], first.parameters[5], rel_tol=_SAME):
                message = (
                    f"r_d of {self._name(term)} is {term.parameters[5]:g}, that of {self._name(first)} "
                    f"{first.parameters[5]:g}: with one B in the two-density form no energy belongs to these forces. "
                    "Write all mdpd lines in the generalised form, A B n m rc rd, with B times pi rd^4/(15 rc^6) of "
                    "one pair: there one B goes with any r_d"
                )
                raise self._refusal(term, message)

    def _powers(self) -> tuple[float, ...]:
        """Return m of every species: of the record of the like pair, else of all records in which it takes part."""
        powers = [0.0] * len(self._species)
        for term in self._terms:
            a, b = term.species
            if a == b:
                powers[a] = term.parameters[3]
                if powers[a] == 0.0:
                    raise self._refusal(term, f"m of {self._species[a]} (number 4) must be 1 or more, not 0")
        unlike = [term for term in self._terms if term.species[0] != term.species[1]]
        own = tuple(powers)
        for term in unlike:
            m = term.parameters[3]
            for k in term.species:
                if own[k] == 0.0 and m > 0.0:
                    if powers[k] not in (0.0, m):
                        message = f"m of {self._species[k]} is {powers[k]:g} on another line and {m:g} here; "
                        raise self._refusal(term, f"{message}m belongs to the species, not to the pair")
                    powers[k] = m
        for term in unlike:
            m, known = term.parameters[3], [powers[k] for k in term.species]
            if 0.0 in known:
                name = self._species[term.species[known.index(0.0)]]
                message = f"no line says what m of {name} is; m belongs to the species: give it on the line of "
                raise self._refusal(term, f"{message}{name}-{name}, or here")
            if m not in (0.0, *known):
                names = " and ".join(f"{powers[k]:g} for {self._species[k]}" for k in term.species)
                message = f"m (number 4) belongs to the species, and their lines say {names}: expected 0 or one of them"
                raise self._refusal(term, f"{message}, not {m:g}")
        return tuple(power or 2.0 for power in powers)  # species that take no part have densities of 0

    def _explanation(self) -> str:
        return self._settings.where("mdpd_kernel") if self._settings.given("mdpd_kernel") else "the default"

    def _given(self, term: PairTerm, k: int) -> float:
        """A number of a pair as FIELD has it, or in internal units for mixed pairs."""
        line = self._lines.get(frozenset(self._species[k] for k in term.species))
        return line.parameters[k] if line is not None else term.parameters[k]

    def _name(self, term: PairTerm) -> str:
        return "-".join(self._species[k] for k in term.species)

    def _refusal(self, term: PairTerm, message: str) -> SceneError:
        line = self._lines.get(frozenset(self._species[k] for k in term.species))
        return SceneError(message, path=self._field.path, line=(line.line or None) if line else None, word=KEY)


def check_many_body(scene: Scene, field: Field, settings: Settings) -> None:
    """Refuse what local densities were not worked out for.

    Raises:
        SceneError: pairs at the ends of dihedrals that feel a part of their pair law, or a barostat with a kernel that
            has no energy.
    """
    given = scene.many_body
    if given is None:
        return
    if scene.bonded is not None and len(scene.bonded.scaled):
        species = scene.beads.species[scene.bonded.scaled]
        of_mdpd = {term.species for term in given.terms}
        for a, b in species.tolist():
            if (min(a, b), max(a, b)) in of_mdpd:
                names = f"{scene.species[a]}-{scene.species[b]}"
                message = f"{names} has the law mdpd, which cannot be scaled at the ends of dihedrals"
                raise SceneError(f"{message}: set their factor to 0", path=field.path)
    if scene.dynamics.barostat is not None and given.kernel == "lucy":
        raise settings.refusal("mdpd_kernel", "lucy has no energy that a barostat could act on; take warren")


def _form(two_density: bool) -> str:
    return "two-density" if two_density else "generalised"
