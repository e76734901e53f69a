"""Beads that carry heat: the block ``extension heat`` of FIELD in internal units, and what it goes with."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pydlpoly.errors import SceneError
from pydlpoly.formats.heat_block import HeatBlock, SourceLine, read_heat
from pydlpoly.formats.records import Field
from pydlpoly.scene.model import Dynamics, Heat, HeatSource, HeatTerm, Scene
from pydlpoly.scene.settings import Notes, Settings, place

WITH_HEAT = ("nve", "mdvv", "zeroth", "first", "second", "peters", "peters-first", "lowe-andersen", "ou", "ou-middle")
"""Integrators whose drag and noise give their energy to the internal energies of the beads, pair by pair."""

LIMITED = ("peters-first", "lowe-andersen")
"""Those of them that are defined up to a product of drag and timestep alone, which is checked for FIELD's drags."""

_EXTENSION = "heat"


def unfit_for_heat(dynamics: Dynamics) -> tuple[str, str] | None:
    """Return the keyword and the reason where beads that carry heat do not go with the integrator, else None."""
    if dynamics.integrator not in WITH_HEAT:
        names = ", ".join(WITH_HEAT)
        message = f"{dynamics.integrator} is not modelled with beads that carry heat; these are: {names}"
        return "ensemble_dpd_order", message
    if dynamics.integrator == "mdvv" and dynamics.prediction != 0.5:
        return "ensemble_dpd_lambda", "beads that carry heat go with lambda 0.5 only"
    if dynamics.integrator == "mdvv" and dynamics.half_step_kinetic:
        message = "half is not modelled with beads that carry heat: their balance is that of the whole step"
        return "ensemble_dpd_kinetic", message
    return None


def resolve_heat(field: Field, scene: Scene, settings: Settings, notes: Notes) -> Scene:
    """Return the scene with what ``extension heat`` says, or as it is where FIELD has no such block.

    Args:
        field: FIELD.
        scene: all the rest.
        settings: CONTROL, for the place of messages.
        notes: receives choices.

    Raises:
        SceneError: numbers that make no sense, species without a heat capacity, or something in the scene that is not
            modelled with beads that carry heat; file, line and word are named.
    """
    extension = next((e for e in field.extensions if e.name == _EXTENSION), None)
    if extension is None:
        return scene
    block = read_heat(extension, field.path, scene.species)
    _check_scene(block, field, scene, settings)
    return _Resolver(field.path, block, scene, notes).scene()


class _Resolver:
    def __init__(self, path: str, block: HeatBlock, scene: Scene, notes: Notes) -> None:
        self._path, self._block, self._scene, self._notes = path, block, scene, notes
        self._kelvin = scene.units.boltzmann  # internal energy in one unit of temperature

    def _refuse(self, message: str, line: int, word: str | None = None) -> SceneError:
        return SceneError(message, path=self._path, line=line or None, word=word)

    def scene(self) -> Scene:
        scene, names = self._scene, self._scene.species
        capacity, start = self._capacities()
        walls = {
            names.index(wall.species): self._temperature(wall.temperature, wall.line) for wall in self._block.walls
        }
        for number, temperature in walls.items():
            start[number] = temperature
        species = scene.beads.species
        terms = self._terms()
        heat = Heat(
            terms=terms,
            sources=tuple(self._source(source) for source in self._block.sources),
            held=tuple(sorted(walls)),
            reference=scene.dynamics.thermal_energy,
            viscous_heating=self._block.viscous_heating,
            scaled_repulsion=self._block.repulsion == "scaled",
            explanation=place(self._path, self._block.line),
        )
        arrays = {"temperature": np.array(start)[species], "heat_capacity": np.array(capacity)[species]}
        for array in arrays.values():
            array.setflags(write=False)  # a scene is immutable
        self._note_choices(heat)
        return replace(scene, heat=heat, beads=replace(scene.beads, **arrays))

    def _temperature(self, value: float, line: int) -> float:
        if not (value > 0.0 and math.isfinite(value)):
            raise self._refuse(f"an internal temperature must be above 0, not {value:g}", line)
        return value * self._kelvin

    def _capacities(self) -> tuple[list[float], list[float]]:
        """Return heat capacities and start temperatures by species."""
        given = {line.species: line for line in self._block.capacities}
        capacity, start = [], []
        for name in self._scene.species:
            line = given.get(name)
            if line is None:
                message = f"species {name} has no heat capacity; give it a line 'capacity {name} C_V'"
                raise self._refuse(message, self._block.line, name)
            if not (line.capacity > 0.0 and math.isfinite(line.capacity)):
                raise self._refuse(f"a heat capacity must be above 0, not {line.capacity:g}", line.line, name)
            capacity.append(line.capacity)
            if line.temperature is None:
                start.append(self._scene.dynamics.thermal_energy)
            else:
                start.append(self._temperature(line.temperature, line.line))
        return capacity, start

    def _terms(self) -> tuple[HeatTerm, ...]:
        names, terms = self._scene.species, []
        drags = {pair.species: pair.drag for pair in self._scene.pairs}
        for line in self._block.pairs:
            a, b = sorted(names.index(name) for name in line.species)
            words = " ".join(line.species)
            if not (line.kappa >= 0.0 and math.isfinite(line.kappa)):
                raise self._refuse(f"kappa must not be negative, found {line.kappa:g}", line.line, "kappa")
            if line.kappa > 0.0 and not line.range > 0.0:
                raise self._refuse("the range of a conduction must be given and above 0", line.line, "kappa")
            if not line.exponent > 0.0:
                raise self._refuse(f"the exponent must be above 0, not {line.exponent:g}", line.line, "exponent")
            where = place(self._path, line.line)
            if any(line.power + line.drag) and drags.get((a, b), 0.0) == 0.0:
                self._notes.ignored(f"power and drag of {words} have no effect: the pair has no drag", where)
            if line.kappa == 0.0 and any(line.conductivity):
                self._notes.ignored(f"conductivity of {words} has no effect: kappa is 0", where)
            terms.append(
                HeatTerm((a, b), line.kappa, line.range if line.kappa > 0.0 else 0.0, line.exponent, line.power,
                         line.conductivity, line.drag, where)
            )  # fmt: skip
        return tuple(terms)

    def _source(self, line: SourceLine) -> HeatSource:
        numbers = line.numbers
        if line.kind == "species":
            numbers = (float(self._scene.species.index(line.species)),)
        if line.kind == "box" and any(high <= low for low, high in zip(numbers[::2], numbers[1::2], strict=True)):
            raise self._refuse("the bounds of a region must ascend", line.line)
        if line.kind == "sphere" and not numbers[3] > 0.0:
            raise self._refuse(f"the radius of a sphere must be above 0, not {numbers[3]:g}", line.line)
        return HeatSource(line.kind, numbers, line.rate * self._kelvin, place(self._path, line.line))

    def _note_choices(self, heat: Heat) -> None:
        names = self._scene.species
        conducting = {term.species for term in heat.terms if term.conductivity > 0.0}
        missing = [
            f"{names[a]} {names[b]}" for b in range(len(names)) for a in range(b + 1) if (a, b) not in conducting
        ]
        if missing:
            self._notes.choice(f"no heat flows between {', '.join(missing)}: no kappa is given", heat.explanation)
        if self._scene.external:
            self._notes.choice("external fields do work: what is reported as conserved changes by it", heat.explanation)


def _check_scene(block: HeatBlock, field: Field, scene: Scene, settings: Settings) -> None:
    dynamics, run = scene.dynamics, scene.run
    at = {"path": field.path, "line": block.line or None, "word": "heat"}
    unfit = unfit_for_heat(dynamics)
    if unfit is not None:
        raise settings.refusal(unfit[0] if settings.given(unfit[0]) else "ensemble_method", unfit[1])
    if not dynamics.thermal_energy > 0.0:
        raise settings.refusal("temperature", "beads that carry heat need a temperature above 0: it is the reference")
    for given in block.pairs:
        if any(given.drag) and dynamics.integrator in LIMITED:
            message = f"a drag that depends on temperature is not modelled with {dynamics.integrator}, whose limit of "
            message += "drag x timestep it might pass; ou has none"
            raise SceneError(message, path=field.path, line=given.line or None, word="drag")
    if block.viscous_heating == "lammps" and dynamics.integrator != "mdvv":
        raise SceneError(
            f"viscous_heating lammps goes with the integrator mdvv only, not with {dynamics.integrator}",
            path=field.path,
            line=block.lines["viscous_heating"],
            word="lammps",
        )
    varies = "temperature_amplitude" if settings.given("temperature_amplitude") else "temperature_times"
    reasons = {
        "shear_rate": ("a sheared cell is", dynamics.shear_rate != 0.0),
        varies: ("a temperature that varies is", dynamics.schedule is not None),
        "equilibration_force_cap": ("a cap on forces is", run.force_cap > 0.0 and run.equilibration_steps > 0),
        "rescale_frequency": ("rescaling of velocities is", run.rescale_every > 0 and run.equilibration_steps > 0),
        "regauss_frequency": ("redrawing of velocities is", run.regauss_every > 0 and run.equilibration_steps > 0),
        "ensemble": ("a cell that follows the pressure is", dynamics.barostat is not None),
    }
    for keyword, (what, met) in reasons.items():
        if met:
            raise settings.refusal(keyword, f"{what} not modelled with beads that carry heat (extension heat)")
    if scene.constraints is not None:
        raise SceneError("constraints are not modelled with beads that carry heat", **at)  # type: ignore[arg-type]
    for term in scene.external:
        if term.key == "shrx":
            raise SceneError("the field shrx is not modelled with beads that carry heat", **at)  # type: ignore[arg-type]
    if block.repulsion == "scaled":
        for pair in scene.pairs:
            if pair.law not in (None, "dpd"):
                names = " ".join(scene.species[k] for k in pair.species)
                message = f"repulsion scaled is for the law dpd; the pair {names} has {pair.law}"
                raise SceneError(message, path=field.path, line=block.lines["repulsion"], word="scaled")
