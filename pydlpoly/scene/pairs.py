"""The pair table: what acts between every two species, mixed and filled by rule, with the origin of every number."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pydlpoly import _core
from pydlpoly.errors import SceneError, suggest
from pydlpoly.formats.records import Field, PairLine, PairTable
from pydlpoly.scene.cell import LONGEST
from pydlpoly.scene.laws import PairEntry, read_entry
from pydlpoly.scene.model import Origin, PairTerm
from pydlpoly.scene.settings import Notes, place

Pair = tuple[int, int]


@dataclass(frozen=True)
class PairRules:
    """What CONTROL says about pairs; lengths in Å, drags in Da/ps.

    Attributes:
        mixing: the mixing rule, or None.
        thermostat: whether the ensemble has a pair thermostat.
        fill_drag: drag of pairs that have none, or None.
        override_drag: whether ``fill_drag`` replaces every drag.
        fill_where: where CONTROL gives ``fill_drag``.
        thermal_energy: k_B T.
        vdw_cutoff: where laws without a range of their own end.
        global_drag_cutoff: one range for all drags, or None for the pairs' own ranges.
        conservative: whether pair laws act at all (``vdw_method`` is not off).
        force_shift: ``vdw_force_shift``.
    """

    mixing: str | None
    thermostat: bool
    fill_drag: float | None
    override_drag: bool
    fill_where: str
    thermal_energy: float
    vdw_cutoff: float
    global_drag_cutoff: float | None
    conservative: bool
    force_shift: bool


@dataclass(frozen=True)
class _Law:
    entry: PairEntry | None = None
    origin: Origin = "none"
    text: str = "none"


@dataclass(frozen=True)
class _Drag:
    value: float
    origin: Origin
    text: str
    cutoff: float | None = None


class PairTableBuilder:
    """Builds the pair terms of one scene."""

    def __init__(
        self,
        field: Field,
        factor: float,
        species: tuple[str, ...],
        counts: tuple[int, ...],
        mobile: tuple[int, ...],
        rules: PairRules,
        tables: Mapping[tuple[str, ...], PairTable],
        notes: Notes,
    ) -> None:
        """Read FIELD's records.

        Args:
            field: FIELD with its ``vdw`` records.
            factor: FIELD's energy unit in internal units.
            species: names of the species in their order.
            counts: number of beads of each species.
            mobile: number of beads of each species that can move.
            rules: what CONTROL says.
            tables: tabulated laws by sorted pair of species names.
            notes: receives choices and oddities.

        Raises:
            SceneError: a record that cannot be understood, or a pair given twice.
        """
        self._field, self._factor, self._species = field, factor, species
        self._counts, self._mobile, self._rules, self._tables, self._notes = counts, mobile, rules, tables, notes
        self._given = self._read_lines()

    def build(self) -> tuple[PairTerm, ...]:
        """Return one term for every pair, ordered (0,0), (0,1), (1,1), (0,2), …

        Raises:
            SceneError: records that contradict each other or cannot be understood; under a pair thermostat, pairs
                whose drag is not defined (all of them named) and a table of drags that are all zero.
        """
        pairs = [(a, b) for b in range(len(self._species)) for a in range(b + 1)]
        laws = {pair: self._law(pair) for pair in pairs}
        self._say_what_does_not_interact(laws)
        drags = self._drags(pairs) if self._rules.thermostat else {}
        return tuple(self._term(pair, laws[pair], drags.get(pair)) for pair in pairs)

    def _read_lines(self) -> dict[Pair, PairEntry]:
        number = {name: k for k, name in enumerate(self._species)}
        given: dict[Pair, PairEntry] = {}
        first: dict[Pair, PairLine] = {}
        for line in self._field.pairs:
            for name in line.species:
                if name not in number:
                    message = f"no molecule has a bead of this name{suggest(name, self._species)}"
                    raise SceneError(message, path=self._field.path, line=line.line or None, word=name)
            a, b = sorted(number[name] for name in line.species)
            if (a, b) in given:
                message = f"the pair {' '.join(line.species)} is already given on line {first[a, b].line}"
                raise SceneError(message, path=self._field.path, line=line.line or None, word=line.key)
            first[a, b] = line
            given[a, b] = read_entry(line, self._field, self._factor, self._notes)
        return given

    # -- laws ---------------------------------------------------------------------------------------------------------

    def _law(self, pair: Pair) -> _Law:
        entry = self._given.get(pair)
        if entry is not None:
            return _Law(entry, "given", entry.where)
        like = self._like_entries(pair)
        if self._rules.mixing is None or pair[0] == pair[1] or like is None:
            return _Law()
        first, second = like
        if first.law.key != second.law.key or not first.law.mixable:
            return _Law()
        parameters, _ = self._mix(f"the pair law of {self._name(pair)}", first, second, 0.0, 0.0)
        text = self._mixed_text(pair)
        mixed = replace(first, parameters=parameters, drag=None, drag_cutoff=None, where=text)
        try:
            end = float(_core.pair_range(first.law.key, list(parameters)))
        except ValueError as error:
            message = f"the pair law of {self._name(pair)} cannot be mixed: {error}; give this pair its own line"
            raise SceneError(message, path=self._field.path) from None
        return _Law(replace(mixed, range=end), "mixed", text)

    def _like_entries(self, pair: Pair) -> tuple[PairEntry, PairEntry] | None:
        first, second = (self._given.get((k, k)) for k in pair)
        return (first, second) if first is not None and second is not None else None

    def _mix(
        self, what: str, first: PairEntry, second: PairEntry, drag: float, other_drag: float
    ) -> tuple[tuple[float, ...], float]:
        """Mix parameters and drags of two entries of the same mixable law."""
        rule = self._rules.mixing
        assert rule is not None
        try:
            parameters, mixed = _core.mix(
                rule, first.law.key, list(first.parameters), list(second.parameters), drag, other_drag
            )
        except ValueError as error:
            raise SceneError(f"{what} cannot be mixed: {error}", path=self._field.path) from None
        return tuple(float(x) for x in parameters), float(mixed)

    def _say_what_does_not_interact(self, laws: Mapping[Pair, _Law]) -> None:
        missing = [self._name(p) for p, law in laws.items() if law.entry is None and self._can_meet(p)]
        if not missing or not self._rules.conservative:
            return
        text = f"no pair law for {', '.join(missing)}: these beads do not feel each other (DL_POLY's warning 120)"
        if self._rules.mixing is not None:
            text += f"; {self._rules.mixing} mixes only like pairs of the same mixable law"
        self._notes.warning(text, place(self._field.path, None))

    # -- drags --------------------------------------------------------------------------------------------------------

    def _drags(self, pairs: list[Pair]) -> dict[Pair, _Drag]:
        """Return the drag of every pair: overridden, given, mixed or filled, in this order."""
        found = {pair: self._drag(pair) for pair in pairs}
        undefined = [pair for pair, drag in found.items() if drag is None and self._can_meet(pair)]
        if undefined:
            raise self._undefined(undefined)
        defined = {pair: drag for pair, drag in found.items() if drag is not None}
        if not any(drag.value > 0.0 for drag in defined.values()):
            message = "every drag is 0 under a DPD ensemble, which would be plain NVE without saying so: "
            message += "give drags in FIELD or ensemble_dpd_drag, or choose ensemble nve"
            raise SceneError(message, path=self._field.path)
        free = [self._name(pair) for pair, drag in defined.items() if drag.value == 0.0 and self._can_meet(pair)]
        if free:
            self._notes.warning(f"the drag of {', '.join(free)} is 0: no pair thermostat acts there")
        return defined

    def _drag(self, pair: Pair) -> _Drag | None:
        rules, entry = self._rules, self._given.get(pair)
        if rules.override_drag and rules.fill_drag is not None:
            return _Drag(rules.fill_drag, "overridden", f"overridden by ensemble_dpd_drag ({rules.fill_where})")
        if entry is not None and entry.drag is not None:
            return _Drag(entry.drag, "given", entry.where, entry.drag_cutoff)
        mixed = self._mixed_drag(pair)
        if mixed is not None:
            return mixed
        if rules.fill_drag is not None:
            return _Drag(rules.fill_drag, "filled", f"filled from ensemble_dpd_drag ({rules.fill_where})")
        return None

    def _mixed_drag(self, pair: Pair) -> _Drag | None:
        like = self._like_entries(pair)
        if self._rules.mixing is None or pair[0] == pair[1] or like is None:
            return None
        first, second = like
        if first.drag is None or second.drag is None:
            return None
        if first.drag_cutoff is not None or second.drag_cutoff is not None:
            self._notes.warning(
                f"the drag of {self._name(pair)} is mixed, but the drag cutoffs of the like pairs are not: it ends "
                "where the pair's law does, or at the van der Waals cutoff"
            )
        text = self._mixed_text(pair)
        if first.drag == 0.0 and second.drag == 0.0:
            return _Drag(0.0, "mixed", text)
        if first.law.key != second.law.key or not first.law.mixable:
            # Without a common ε and σ a rule's drag part is taken for equal ones; any mixable law shows it.
            unit = replace(first, law=replace(first.law, key="lj"), parameters=(1.0, 1.0))
            first, second, text = replace(unit, drag=first.drag), replace(unit, drag=second.drag), f"{text} (drag only)"
        what = f"the drag of {self._name(pair)}"
        _, drag = self._mix(what, first, second, first.drag or 0.0, second.drag or 0.0)
        return _Drag(drag, "mixed", text)

    def _undefined(self, pairs: list[Pair]) -> SceneError:
        names = ", ".join(self._name(pair) for pair in pairs)
        cures = [
            "write it after the law's numbers on the pair's vdw line",
            "ensemble_dpd_drag for all pairs without one",
        ]
        if self._rules.mixing is None and any(a != b for a, b in pairs):
            cures.insert(1, "a vdw_mix_method, when both like pairs have a drag")
        message = f"the DPD ensemble needs a drag for every pair, and none is defined for {names}; cures: "
        return SceneError(message + "; ".join(cures), path=self._field.path)

    # -- terms --------------------------------------------------------------------------------------------------------

    def _term(self, pair: Pair, law: _Law, drag: _Drag | None) -> PairTerm:
        rules, entry = self._rules, law.entry
        term = PairTerm(pair, None)
        if entry is not None and rules.conservative:
            term = self._conservative(pair, entry)
            term = replace(term, law_origin=law.origin)
        text = f"law {law.text}"
        if entry is not None and not rules.conservative:
            text = f"law {law.text}, left out by vdw_method off"
        if not self._can_meet(pair):
            text += "; no two beads of this kind"
        if drag is None:
            return replace(term, explanation=text)
        noise = math.sqrt(2.0 * drag.value * rules.thermal_energy)
        if not math.isfinite(noise):
            message = f"the drag {drag.value:g} of {self._name(pair)} is too large: its noise is not finite"
            raise SceneError(message, path=self._field.path)
        cutoff = rules.global_drag_cutoff or drag.cutoff or self._law_end(pair, entry)
        return replace(
            term,
            drag=drag.value,
            drag_cutoff=cutoff if drag.value > 0.0 else 0.0,
            noise=noise,
            drag_origin=drag.origin,
            explanation=f"{text}; drag {drag.text}",
        )

    def _conservative(self, pair: Pair, entry: PairEntry) -> PairTerm:
        shift = self._rules.force_shift and entry.law.shiftable
        if entry.law.key != "tab":
            return PairTerm(pair, entry.law.key, entry.parameters, self._law_end(pair, entry), shift)
        names = tuple(sorted(self._species[k] for k in pair))
        table = self._tables.get(names)
        if table is None:
            message = f"{self._name(pair)} is a tab pair, but the TABLE file has no entry for it"
            raise SceneError(message, path=self._field.path)
        cutoff = min(self._rules.vdw_cutoff, table.cutoff)
        if table.cutoff != self._rules.vdw_cutoff:
            reason = "where its table ends" if cutoff == table.cutoff else "at the van der Waals cutoff"
            text = (
                f"{self._name(pair)}: table up to {table.cutoff:g}, van der Waals cutoff {self._rules.vdw_cutoff:g}: "
            )
            self._notes.choice(f"{text}the pair ends at {cutoff:g} ang, {reason}", place(table.path, None))
        values = np.array([table.energy, table.virial]) * self._factor
        return PairTerm(pair, "tab", (), cutoff, shift, table=values, table_spacing=table.spacing)

    def _law_end(self, pair: Pair, entry: PairEntry | None) -> float:
        end = entry.range if entry is not None and entry.range > 0.0 else self._rules.vdw_cutoff
        if not end <= LONGEST:
            message = f"{self._name(pair)}: the law's range {end:g} ang is longer than {LONGEST:g} ang"
            raise SceneError(message, path=self._field.path)
        return end

    # -- words --------------------------------------------------------------------------------------------------------

    def _name(self, pair: Pair) -> str:
        return f"{self._species[pair[0]]}-{self._species[pair[1]]}"

    def _mixed_text(self, pair: Pair) -> str:
        a, b = (self._species[k] for k in pair)
        return f"mixed from {a}-{a} and {b}-{b} by {self._rules.mixing}"

    def _can_meet(self, pair: Pair) -> bool:
        """Whether two beads of these species, at least one of them mobile, exist."""
        a, b = pair
        if a == b:
            return self._counts[a] > 1 and self._mobile[a] > 0
        return min(self._counts[a], self._counts[b]) > 0 and self._mobile[a] + self._mobile[b] > 0
