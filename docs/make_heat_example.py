"""Writes pydlpoly/examples/heat: a fluid of beads that carry heat, warmed in one half and cooled in the other."""

from __future__ import annotations

from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parents[1] / "pydlpoly" / "examples" / "heat"
EDGES = np.array([5.0, 12.0, 5.0])
BEADS = 1200

CONTROL = """title Heat conduction in a DPD fluid, warmed for y > 0 and cooled for y < 0 (Li et al. 2014)

temperature            1.0 dpd_temp
ensemble               nvt
ensemble_method        dpd
ensemble_dpd_order     ou
ensemble_dpd_exponent  0.41
cutoff                 1.58 dpd_l
vdw_method             direct

timestep               0.01 dpd_t
time_run               1000 steps
time_equilibration     500 steps
random_seed            [ 3 14 15 ]

print_frequency        100 steps
stats_frequency        10 steps
"""

FIELD = f"""fluid that conducts heat
units dpd
molecules 1
fluid
nummols {BEADS}
atoms 1
A 1.0 0.0
finish
vdw 1
# species  law  a      r_c   drag
A A        dpd  18.75  1.58  4.5
close

extension heat
capacity A 1e5
pair A A kappa 1.41e-5 range 1.58 exponent 2.0 conductivity -0.44 -3.21 5.04 0.0 power 10.54 -3.66 3.44 -4.10
source layer y  0 6  0.02
source layer y -6 0 -0.02
end extension
"""


def config() -> str:
    """Return CONFIG: beads at random places."""
    places = EDGES * (np.random.default_rng(1822).random((BEADS, 3)) - 0.5)
    cell = [" ".join(f"{x:.6f}" for x in row) for row in np.diag(EDGES)]
    lines = [f"{BEADS} beads placed at random", f"0 2 {BEADS}", *cell]
    for number, place in enumerate(places, 1):
        lines += [f"A {number}", " ".join(f"{x:.4f}" for x in place)]
    return "\n".join([*lines, ""])


def files() -> dict[str, str]:
    """Return the example's files by name."""
    return {"CONTROL": CONTROL, "FIELD": FIELD, "CONFIG": config()}


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, text in files().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
