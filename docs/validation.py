"""Published numbers beside ours: the table of docs/validation.md between ``<!-- measured: published -->`` and its end.

``python docs/validation.py`` writes the table from docs/validation.json, ``--check`` only says whether it is current.
``--measure`` first measures everything anew (some minutes on one core), ``--measure GROUP …`` only those groups of
docs/validation_runs.py.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAGE, RESULTS = HERE / "validation.md", HERE / "validation.json"
_PART = re.compile(r"(<!-- measured: published -->\n).*?(<!-- end: published -->\n)", re.DOTALL)


@dataclass(frozen=True)
class Row:
    """A published number.

    Attributes:
        key: its name in the results.
        quantity: what it is.
        value, error: the number and its standard error as published; 0 when it has none or is exact.
        source: who says so.
        test: the test that asserts it, as ``file::function``, where there is one.
        digits: digits after the point that are shown.
    """

    key: str
    quantity: str
    value: float
    error: float
    source: str
    test: str
    digits: int = 3


PYHNC = "P. B. Warren, pyHNC (Monte Carlo)"
ALLEN = "M. P. Allen and D. J. Tildesley (2017), example `dpd`"
HARNESS = "an independent program"
LAMMPS = "LAMMPS"
DL_MESO = "DL_MESO, exercise on lipids (± fluctuation)"
WIJMANS = "C. M. Wijmans, B. Smit and R. D. Groot (2001), data with pyHNC"
HENDRIKSE = "Hendrikse (2025), data with pyHNC"
GONZALEZ = "values for the electrolyte of González-Melchor et al. (2006)"

_WATER = "tests/physics/test_dpd_water.py"
_STATE = "tests/physics/test_equation_of_state.py::test_pressures_of_allen_and_tildesley"
_LIPIDS = "tests/physics/test_dl_meso.py::test_lipids_have_dl_mesos_averages"
_SMEARED = "tests/test_charge_laws.py::test_table_of_values"
_MANY_BODY = "tests/physics/test_many_body.py"
_HEAT = "tests/physics/test_heat.py::test_profile_is_the_printed_one_with_lammpss_options"
_SPECIES = "tests/physics/test_transport.py::test_profiles_of_lammps_example"
EXAMPLE = "printed with LAMMPS's example"

FLUID = "A = 25, ρ = 3"
ROWS = (
    Row("pressure", f"pressure, {FLUID}", 23.65, 0.02, PYHNC, f"{_WATER}::test_pressure"),
    Row("energy", f"pair energy of a bead, {FLUID}", 4.551, 0.01, LAMMPS, f"{_WATER}::test_energy"),
    Row("energy-density", f"excess energy density, {FLUID}", 13.645, 0.02, PYHNC, f"{_WATER}::test_energy"),
    Row("rdf-peak", f"highest g(r), {FLUID}", 1.158, 0.003, HARNESS, f"{_WATER}::test_radial_distribution"),
    Row("rdf-place", "its place, middle of a bin of 0.05", 0.875, 0.0, HARNESS, f"{_WATER}::test_radial_distribution"),
    Row("mu-25", f"excess chemical potential, {FLUID}", 12.195, 0.10, PYHNC, ""),
    Row("mu-10", "of a bead with A = 10 in it", 5.65, 0.0, HENDRIKSE, "", digits=2),
    Row("mu-15", "with A = 15", 8.07, 0.0, HENDRIKSE, "", digits=2),
    Row("mu-20", "with A = 20", 10.24, 0.0, HENDRIKSE, "", digits=2),
    Row("mu-40", "with A = 40", 16.72, 0.0, HENDRIKSE, "", digits=2),
    Row("transfer-2", "free energy of transfer, ΔA = 2", 0.6997, 0.0, WIJMANS, ""),
    Row("transfer-4", "ΔA = 4", 1.3703, 0.0, WIJMANS, ""),
    Row("transfer-6", "ΔA = 6", 2.0263, 0.0, WIJMANS, ""),
    Row("transfer-10", "ΔA = 10", 3.236, 0.0, WIJMANS, ""),
    *(
        Row(key, f"pressure, A ρ/T = 75, T = {t}, ρ = {d}", value, 0.004, ALLEN, _STATE)
        for key, t, d, value in (
            ("at-0.5-3", 0.5, 3, 11.817),
            ("at-1-3", 1, 3, 23.636),
            ("at-1.5-3", 1.5, 3, 35.452),
            ("at-2-3", 2, 3, 47.261),
            ("at-1-2", 1, 2, 14.318),
            ("at-1-4", 1, 4, 32.625),
            ("at-1-5", 1, 5, 41.536),
        )
    ),
    Row("pressure-15", "pressure, A = 15, ρ = 3", 15.36, 0.01, HARNESS, ""),
    Row("pressure-78", "pressure, A = 78, ρ = 3", 69.47, 0.02, HARNESS, ""),
    Row("diffusion-25", f"self-diffusion, {FLUID}, γ = 4.5", 0.293, 0.004, HARNESS,
        "tests/physics/test_water_analysis.py::test_diffusion_and_structure_of_water", digits=4),
    Row("diffusion-15", "A = 15", 0.376, 0.004, HARNESS, "", digits=4),
    Row("diffusion-78", "A = 78", 0.139, 0.004, HARNESS, "", digits=4),
    Row("diffusion-lowe", "A = 25 with Lowe's thermostat, rate 4.4", 0.116, 0.002, HARNESS, "", digits=4),
    Row("diffusion-bare", "A = 0, γ = 6.75", 0.5203, 0.0, "tests of OpenMM and LAMMPS",
        "tests/physics/test_thermostat.py::test_self_diffusion_of_the_bare_thermostat", digits=4),
    Row("viscosity-shear", f"viscosity, {FLUID}, γ = 4.5: by shear", 0.840, 0.005, HARNESS,
        "tests/physics/test_flow.py::test_viscosity_by_shear"),
    Row("viscosity-poiseuille", "by periodic Poiseuille flow", 0.840, 0.005, HARNESS,
        "tests/physics/test_flow.py::test_viscosity_by_periodic_poiseuille_flow"),
    Row("chi", "χ/ΔA of two fluids that part, ρ = 3", 0.286, 0.002, "R. D. Groot and P. B. Warren (1997)",
        "tests/physics/test_phase_separation.py::test_flory_huggins_parameter"),
    Row("tension", "surface tension of two such fluids", 0.99, 0.0, "fit of R. D. Groot and P. B. Warren (1997)",
        "tests/test_stress_profile.py::test_two_phases_have_one_normal_pressure_and_one_tension"),
    Row("madelung", "Madelung constant of rock salt", 1.7475645946331822, 0.0, "closed form",
        "tests/test_charges.py::test_madelung_constant_of_rock_salt", digits=10),
    Row("slater-0", "energy of smeared like charges, β = 0.929, r = 0", 1.0254, 0.0, GONZALEZ, _SMEARED, digits=5),
    Row("slater-1", "r = 1", 0.77163, 0.0, GONZALEZ, _SMEARED, digits=5),
    Row("slater-exact-0", "exact form, r = 0", 0.6409, 0.0, GONZALEZ, _SMEARED, digits=5),
    Row("slater-exact-1", "exact form, r = 1", 0.57721, 0.0, GONZALEZ, _SMEARED, digits=5),
    Row("ion-energy", "electrostatic energy of an ion, 0.6 mol/L in water", -0.318, 0.004, LAMMPS,
        "tests/physics/test_electrolyte.py::test_electrostatic_energy", digits=4),
    Row("ion-peak", "highest g(r) of opposite ions", 1.39, 0.03, LAMMPS,
        "tests/physics/test_electrolyte.py::test_no_spike_of_ion_pairs"),
    Row("lipid-temperature", "lipids in water, Δt = 0.03: temperature", 1.0182, 0.036, DL_MESO, _LIPIDS, digits=4),
    Row("lipid-kinetic", "kinetic energy of a bead", 1.5272, 0.054, DL_MESO, _LIPIDS, digits=4),
    Row("lipid-potential", "potential energy of a bead", 5.0782, 0.081, DL_MESO, _LIPIDS, digits=4),
    Row("lipid-bond", "bond energy", 0.16570, 0.0045, DL_MESO, _LIPIDS, digits=4),
    Row("lipid-angle", "angle energy", 0.20947, 0.025, DL_MESO, _LIPIDS, digits=4),
    Row("lipid-pressure", "pressure", 23.340, 0.323, DL_MESO, _LIPIDS),
    *(
        Row(f"{name}-{kernel}", text, value, error, HARNESS, f"{_MANY_BODY}::test_slab")
        for name, kernel, text, value, error in (
            ("slab", "warren", "many-body liquid (A = −40, B = 25, r_d = 3/4): density of a slab", 6.08, 0.02),
            ("tension", "warren", "its surface tension", 7.3, 0.3),
            ("slab", "lucy", "with Lucy's kernel: density of a slab", 6.71, 0.02),
            ("tension", "lucy", "its surface tension", 9.3, 0.3),
        )
    ),
    *(
        Row(f"{kernel}-{density}", f"pressure of many-body bulk at ρ = {density}, kernel {kernel}", value, 0.0, source,
            f"{_MANY_BODY}::test_bulk_pressure")
        for kernel, source, values in (
            ("warren", HARNESS, {6: -3.4, 7: 61.3, 8: 167.0}),
            ("lucy", LAMMPS, {7: 16.9, 8: 107.1}),  # at 6 a bubble opens, whose pressure depends on the box
        )
        for density, value in values.items()
    ),
    Row("edpd-max", "beads with heat between a source and a sink: highest temperature", 1.06003, 0.0, EXAMPLE, _HEAT),
    Row("edpd-min", "lowest", 0.940968, 0.0, EXAMPLE, _HEAT),
    Row("tdpd-1-max", "dissolved species between a source and a sink: highest, first", 1.05139, 0.0, EXAMPLE, _SPECIES),
    Row("tdpd-1-min", "lowest, first", 0.948624, 0.0, EXAMPLE, _SPECIES),
    Row("tdpd-2-max", "highest, second", 1.03746, 0.0, EXAMPLE, _SPECIES),
    Row("tdpd-2-min", "lowest, second", 0.962527, 0.0, EXAMPLE, _SPECIES),
)  # fmt: skip
"""All numbers, in the order of the table."""


def plain(value: float) -> str:
    """Return a published number in the digits it is published with, at most ten after the point."""
    return f"{value:.10f}".rstrip("0").rstrip(".")


def with_error(value: float, error: float, digits: int) -> str:
    """Return a number of ours with its standard error, both with two digits of the error where it has one."""
    if error <= 0.0:
        return f"{value:.{digits}f}"
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{digits}f} ± {error:.{digits}f}"


def cells(row: Row, found: dict[str, tuple[float, float]]) -> list[str]:
    """Return a row's cells: quantity, published, source, ours, their difference, test."""
    value, error = found[row.key]
    published = plain(row.value) + (f" ± {plain(row.error)}" if row.error else "")
    return [
        row.quantity,
        published,
        row.source,
        with_error(value, error, row.digits),
        difference(row, value, error),
        f"`{row.test}`" if row.test else "",
    ]


def difference(row: Row, value: float, error: float) -> str:
    """Return ours less theirs in combined standard errors; in per cent where theirs has no error, blank if exact."""
    apart = value - row.value
    if row.error:
        return f"{apart / math.hypot(error, row.error):+.1f}"
    return f"{100.0 * apart / row.value:+.1f} %" if error else ""


def table(found: dict[str, tuple[float, float]]) -> str:
    """Return the Markdown table. Raises KeyError for a row that has not been measured."""
    headers = ["quantity", "published", "source", "here", "apart", "test"]
    rows = [headers, ["---"] * len(headers), *(cells(row, found) for row in ROWS)]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def results() -> dict[str, tuple[float, float]]:
    """Return what has been measured, value and error by key."""
    stored = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.is_file() else {}
    return {key: (float(value), float(error)) for key, (value, error) in stored.items()}


def measure(groups: list[str]) -> None:
    """Measure these groups, or all, and keep the results."""
    from validation_runs import GROUPS

    unknown = set(groups) - set(GROUPS)
    if unknown:
        raise SystemExit(f"no such group: {', '.join(sorted(unknown))}; there are {', '.join(GROUPS)}")
    for name in groups or GROUPS:
        found = {**results(), **GROUPS[name]()}
        known = {row.key for row in ROWS}
        lines = (f'  "{key}": [{found[key][0]:.12g}, {found[key][1]:.4g}]' for key in sorted(known & found.keys()))
        RESULTS.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
        print(f"{name}: measured", file=sys.stderr)


def main() -> int:
    """Write or check the page; the return value is the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--measure", nargs="*", metavar="GROUP")
    options = parser.parse_args()
    if options.measure is not None:
        measure(options.measure)
    text = PAGE.read_text(encoding="utf-8")
    fresh = _PART.sub(lambda found: f"{found[1]}\n{table(results())}\n{found[2]}", text)
    if fresh != text:
        print(f"{PAGE.name}: {'out of date' if options.check else 'written'}")
        if options.check:
            return 1
        PAGE.write_text(fresh, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
