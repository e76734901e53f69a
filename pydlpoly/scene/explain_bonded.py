"""The section on bonded terms of Scene.explain(): counts by law and molecule, numbers, exclusions."""

from __future__ import annotations

from collections import Counter

from pydlpoly.scene.bonded_laws import bonded_laws
from pydlpoly.scene.model import Bonded, BondedTerm, Scene

_MOST_SETS = 40  # more sets of numbers are counted, not listed


def headers_and_rows(scene: Scene, bonded: Bonded) -> tuple[list[str], list[list[str]]]:
    """Return a table of the terms: each set of numbers by itself, or by law and molecule when there are many."""
    factor = (scene.field_units or scene.units).factor
    headers = ["molecule", "kind", "law", "numbers", "terms"]
    if len(bonded.terms) <= _MOST_SETS:
        rows = [[*_what(scene, t), _numbers(t, factor), str(len(t.beads))] for t in bonded.terms]
        return headers, rows
    sets: Counter[tuple[str, ...]] = Counter()
    terms: Counter[tuple[str, ...]] = Counter()
    for term in bonded.terms:
        sets[_what(scene, term)] += 1
        terms[_what(scene, term)] += len(term.beads)
    return headers, [[*what, f"{sets[what]} sets", str(terms[what])] for what in sets]


def sentences(scene: Scene, bonded: Bonded) -> list[str]:
    """Return where the numbers come from, what the laws are, and what becomes of the pair forces."""
    lines = []
    if len(bonded.terms) <= _MOST_SETS:
        lines += [f"  {' '.join(_what(scene, t))}: {t.explanation}" for t in bonded.terms]
    seen = dict.fromkeys((t.kind, t.law) for t in bonded.terms)
    lines += [f"{kind} {key}: {bonded_laws()[kind, key].description}" for kind, key in seen]
    if any(t.kind == "inversion" for t in bonded.terms):
        lines.append("inversion angles are averaged over the three choices of the bond that leaves the plane")
    lines.append(f"pairs without pair forces, drag and noise: {len(bonded.excluded)}")
    if len(bonded.scaled):
        lines.append(f"of these, 1-4 pairs that feel their pair law times a factor: {len(bonded.scaled)}")
    if bonded.coulomb_scaled is not None and len(bonded.coulomb_scaled):
        lines.append(f"of these, 1-4 pairs that feel electrostatics times a factor: {len(bonded.coulomb_scaled)}")
    if any(t.restraint and t.kind != "tether" for t in bonded.terms):
        lines.append("keys with a minus sign leave their beads the pair forces")
    return lines


def _what(scene: Scene, term: BondedTerm) -> tuple[str, str, str]:
    law = bonded_laws()[term.kind, term.law]
    key = law.restraint_key if term.restraint and law.restraint_key else term.law
    return scene.molecule_names[term.molecule] or "(no name)", term.kind, key


def _numbers(term: BondedTerm, factor: float) -> str:
    if term.table is not None:
        return f"table of {term.table.shape[1]} points"
    if term.law == "coul":
        return f"k q_i q_j/(4 pi eps0 eps)={term.parameters[0] / factor:.6g}"
    law = bonded_laws()[term.kind, term.law]
    numbers = law.as_in_field(term.parameters, factor)
    return " ".join(f"{name}={number:.6g}" for name, number in zip(law.parameter_names, numbers, strict=True))
