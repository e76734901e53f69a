"""The ASE calculator: against ASE's own, slopes of its energy, optimisers and dynamics, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from ase import Atoms, units
from ase.build import bulk
from ase.calculators.calculator import PropertyNotImplementedError
from ase.calculators.lj import LennardJones
from ase.md.verlet import VelocityVerlet
from ase.neighborlist import neighbor_list
from ase.optimize import BFGS, FIRE

import pydlpoly
from pydlpoly.ase import ENERGY, VELOCITY, Calculator, atoms_from_state, scene_from_atoms
from pydlpoly.errors import SceneError

SOFT = {("A", "A"): ("dpd", 25.0, 3.0), ("A", "B"): ("dpd", 40.0, 3.0), ("B", "B"): ("dpd", 30.0, 2.5)}
NVE = {"ensemble": "nve", "timestep": "1 fs", "temperature": "300 K", "cutoff": "3 ang"}
RESTING = {**NVE, "restart": "noscale", "fixed_com": "off"}
TRICLINIC = np.array([[9.0, 1.0, -0.5], [-2.0, 8.5, 0.7], [1.5, -1.0, 10.0]])
TURNED = TRICLINIC @ np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


def soft_fluid(cell=(9.0, 9.0, 9.0), pbc=True, beads=60, velocities=True, seed=3):
    random = np.random.default_rng(seed)
    atoms = Atoms(numbers=np.zeros(beads, int), cell=cell, pbc=pbc, masses=np.where(np.arange(beads) % 3, 10.0, 12.0))
    atoms.set_scaled_positions(random.random((beads, 3)))
    atoms.set_array("bead_types", np.where(np.arange(beads) % 3, "A", "B"))
    if velocities:
        atoms.set_velocities(random.normal(size=(beads, 3)) * VELOCITY)
    return atoms


def soft_scene(atoms, control=NVE):
    return scene_from_atoms(atoms, pairs=SOFT, units="kj", control=control)


def refused(expected, kind, act):
    with pytest.raises(kind) as caught:
        act()
    assert str(caught.value) == expected


# -- Judges in ASE ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("strain", [np.eye(3), np.array([[1.0, 0.08, 0.0], [0.0, 0.95, -0.06], [0.04, 0.0, 1.03]])])
def test_lennard_jones_agrees_with_ases(strain):
    cutoff, sigma, epsilon = 7.0, 3.4, 0.0104
    atoms = bulk("Ar", "fcc", a=5.3, cubic=True) * (3, 3, 3)
    atoms.rattle(0.15, seed=5)
    atoms.set_cell(atoms.cell.array @ strain, scale_atoms=True)
    theirs = atoms.copy()
    theirs.calc = LennardJones(sigma=sigma, epsilon=epsilon, rc=cutoff, smooth=False)
    atoms.calc = Calculator(
        pairs={("Ar", "Ar"): ("lj", epsilon / ENERGY, sigma)},
        units="internal",
        control={"cutoff": f"{cutoff} ang", "vdw_long_range_correction": False},
    )
    pairs = len(neighbor_list("i", atoms, cutoff)) // 2
    at_cutoff = 4.0 * epsilon * ((sigma / cutoff) ** 12 - (sigma / cutoff) ** 6)
    energy = atoms.get_potential_energy()
    assert energy - pairs * at_cutoff == pytest.approx(theirs.get_potential_energy(), rel=1e-8)
    largest = np.abs(theirs.get_forces()).max()
    assert np.abs(atoms.get_forces() - theirs.get_forces()).max() < 1e-8 * largest
    stress = theirs.get_stress()
    assert np.abs(stress).min() > 1e-7  # all six components say something
    assert np.abs(atoms.get_stress() - stress).max() < 1e-8 * np.abs(stress).max()
    assert atoms.get_potential_energy(force_consistent=True) == energy


@pytest.mark.parametrize("cell", [np.diag([9.0, 8.0, 10.0]), TURNED])
def test_forces_and_stress_are_slopes_of_the_energy(cell):
    atoms = soft_fluid(cell)
    atoms.calc = Calculator(pairs=SOFT, units="kj", control={"cutoff": "3 ang"})
    forces, stress, volume = atoms.get_forces(), atoms.get_stress(voigt=False), atoms.get_volume()
    step = 1e-4
    for bead, axis in [(0, 0), (1, 1), (17, 2)]:
        energies = []
        for sign in (1.0, -1.0):
            moved = atoms.copy()
            moved.calc = atoms.calc
            moved.positions[bead, axis] += sign * step
            energies.append(moved.get_potential_energy())
        slope = -(energies[0] - energies[1]) / (2.0 * step)
        assert slope == pytest.approx(forces[bead, axis], abs=1e-6 * np.abs(forces).max())
    for row, column in [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]:
        energies = []
        for sign in (1.0, -1.0):
            strain = np.eye(3)
            strain[row, column] += 0.5 * sign * 1e-5
            strain[column, row] += 0.5 * sign * 1e-5
            strained = atoms.copy()
            strained.calc = atoms.calc
            strained.set_cell(atoms.cell.array @ strain, scale_atoms=True)
            energies.append(strained.get_potential_energy())
        slope = (energies[0] - energies[1]) / (2.0e-5 * volume)
        assert slope == pytest.approx(stress[row, column], abs=1e-6 * np.abs(stress).max())
    assert np.trace(stress) < 0.0  # a repulsion presses outwards: compression is negative in ASE


def test_optimisers_lower_the_energy():
    for optimiser, steps in ((FIRE, 30), (BFGS, 8)):
        atoms = soft_fluid(beads=30, velocities=False)
        atoms.calc = Calculator(pairs=SOFT, units="kj", control={"cutoff": "3 ang"})
        before, force = atoms.get_potential_energy(), np.abs(atoms.get_forces()).max()
        optimiser(atoms, logfile=None).run(steps=steps)
        assert atoms.get_potential_energy() < 0.8 * before
        assert np.abs(atoms.get_forces()).max() < force


def test_ases_dynamics_conserve_energy_and_agree_with_the_engine():
    atoms = soft_fluid()
    atoms.set_velocities(atoms.get_velocities() * 5.0)
    scene = soft_scene(atoms, {**RESTING, "timestep": "0.2 fs"})
    atoms.calc = Calculator(scene)
    before, kinetic = atoms.get_total_energy(), atoms.get_kinetic_energy()
    VelocityVerlet(atoms, timestep=0.2 * units.fs).run(150)
    simulation = pydlpoly.Simulation(scene, threads=1)
    simulation.run(150)
    ours = atoms_from_state(scene, simulation.state)
    assert abs(atoms.get_kinetic_energy() - kinetic) > 0.01 * kinetic
    assert atoms.get_total_energy() == pytest.approx(before, rel=5e-6)
    assert np.abs(ours.positions - atoms.get_positions(wrap=True)).max() < 1e-9
    assert np.allclose(ours.get_velocities(), atoms.get_velocities(), rtol=0.0, atol=1e-9)


# -- Calculator -------------------------------------------------------------------------------------------------------


def test_a_calculator_follows_beads_cell_names_and_periodicity():
    atoms = soft_fluid(velocities=False)
    atoms.calc = Calculator(pairs=SOFT, units="kj", control={"cutoff": "3 ang"})

    def fresh():
        other = atoms.copy()
        other.calc = Calculator(pairs=SOFT, units="kj", control={"cutoff": "3 ang"})
        return other.get_potential_energy()

    seen = [atoms.get_potential_energy()]
    for change in (
        lambda: atoms.positions.__setitem__(0, [1.0, 1.0, 1.0]),
        lambda: atoms.set_cell([8.5, 9.0, 9.0], scale_atoms=True),
        lambda: atoms.arrays.__setitem__("bead_types", np.roll(atoms.arrays["bead_types"], 1)),
        lambda: atoms.set_pbc(False),
        lambda: atoms.__delitem__(slice(10)),
    ):
        change()
        if len(seen) == 3:
            del atoms.arrays["masses"]  # the new names have other masses
        seen.append(atoms.get_potential_energy())
        assert seen[-1] == pytest.approx(fresh(), rel=1e-12)
    assert len(set(seen)) == 6


def test_stress_without_full_periodicity_is_refused_as_ase_expects():
    for pbc in (False, (True, True, False)):
        atoms = soft_fluid(pbc=pbc)
        atoms.calc = Calculator(pairs=SOFT, units="kj", control={"cutoff": "3 ang"})
        assert atoms.get_potential_energy() > 0.0
        with pytest.raises(PropertyNotImplementedError, match="stress needs a system that is periodic along all three"):
            atoms.get_stress()


def test_what_a_calculator_refuses(shared):
    needs = "a calculator needs either a scene, or control with field or pairs"
    atoms = soft_fluid(velocities=False)
    scene = soft_scene(atoms)
    refused(needs, SceneError, Calculator)
    refused(needs, SceneError, lambda: Calculator(scene, control=NVE))
    refused(needs, SceneError, lambda: Calculator(scene, units="kj"))
    refused(needs, SceneError, lambda: Calculator(pairs=SOFT, units="kj"))
    calculator = Calculator(scene)
    for change, message in (
        (lambda a: a.set_pbc(False), "atoms: 'pbc': the calculator's scene has periodicity T T T, not F F F"),
        (lambda a: a.__delitem__(3), "atoms: the calculator's scene has 60 beads, not 59"),
        (lambda a: a.arrays["bead_types"].__setitem__(4, "C"), "atoms: 'C': bead 5 is A in the calculator's scene"),
        (
            lambda a: a.arrays["masses"].__setitem__(4, 3.0),
            "atoms: 'A': the mass of bead 5 is 3 Da, but pairs gives 10 Da; correct one of them, or delete "
            "atoms.arrays['masses']",
        ),
    ):
        other = atoms.copy()
        change(other)
        other.calc = calculator
        refused(message, SceneError, other.get_potential_energy)
        calculator.reset()
    gravity = atoms_from_state(pydlpoly.load(shared / "golden" / "run-extern-gravity"))
    gravity.calc = Calculator(pydlpoly.load(shared / "golden" / "run-extern-gravity"))
    message = "a calculator cannot have external fields (grav): their forces have no energy"
    refused(message, SceneError, gravity.get_potential_energy)
