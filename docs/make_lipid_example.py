"""Writes the files of the shipped example ``lipid``; the same bytes every time.

A flat bilayer of 160 lipids H T6 in water, 3600 beads at density 3. The beads of each lipid stand above each other,
closer than the length of a bond, so that the density is the same everywhere; the first steps stretch them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parents[1] / "pydlpoly" / "examples" / "lipid"
EDGES = np.array([10.0, 10.0, 12.0])
ROWS, COLUMNS = 8, 10  # lipids of one leaflet
TAIL = 6
WATER = 2480
HALF_BILAYER = 1.87

CONTROL = """\
title A bilayer of lipids H T6 in water, DPD (Shillcock and Lipowsky 2002)

temperature            1.0 dpd_temp
ensemble               nvt
ensemble_method        dpd
ensemble_dpd_order     mdvv
cutoff                 1.0 dpd_l
vdw_method             direct

timestep               0.01 dpd_t
time_run               2000 steps
time_equilibration     500 steps
random_seed            [ 31 12 22 ]

print_frequency        200 steps
stats_frequency        20 steps
traj_calculate         on
traj_interval          500 steps
data_dump_frequency    1000 steps
"""


def field() -> str:
    """Return FIELD; the keys with a minus sign leave bonded beads their pair forces, as is usual in DPD."""
    lines = ["lipids and water", "units dpd", "molecules 2", "lipid", f"nummols {2 * ROWS * COLUMNS}"]
    lines += [f"atoms {TAIL + 1}", "H 1.0 0.0", f"T 1.0 0.0 {TAIL}", f"bonds {TAIL}"]
    lines += [f"-hrm {k} {k + 1} 128.0 0.5" for k in range(1, TAIL + 1)]
    lines += ["# A (1 + cos theta): straight lipids", f"angles {TAIL - 1}"]
    lines += [f"-cos {k} {k + 1} {k + 2} 20.0 0.0 1" for k in range(1, TAIL)]
    lines += ["finish", "water", f"nummols {WATER}", "atoms 1", "W 1.0 0.0", "finish", "vdw 6"]
    lines += ["# species  law  a     r_c  drag"]
    pairs = (
        ("H H", 25, 4.5),
        ("T T", 25, 4.5),
        ("W W", 25, 4.5),
        ("H W", 35, 4.5),
        ("H T", 50, 9.0),
        ("T W", 75, 20.0),
    )
    lines += [f"{names}        dpd  {a:.1f}  1.0  {drag:.1f}" for names, a, drag in pairs]
    return "\n".join([*lines, "close", ""])


def positions() -> np.ndarray:
    """Return (3600, 3) places: two leaflets with their heads outwards, then water on both sides of them."""
    rng = np.random.default_rng(42)
    places = []
    for side in (1.0, -1.0):
        for row in range(ROWS):
            for column in range(COLUMNS):
                cell = np.array([(column + 0.5) / COLUMNS, (row + 0.5) / ROWS]) - 0.5
                spread = 0.1 * rng.standard_normal((TAIL + 1, 2))
                heights = side * HALF_BILAYER * (1.0 - (np.arange(TAIL + 1) + 0.5) / (TAIL + 1))
                places.append(np.column_stack([cell * EDGES[:2] + spread, heights]))
    water = rng.random((WATER, 3)) - 0.5
    water[:, :2] *= EDGES[:2]
    room = 0.5 * EDGES[2] - HALF_BILAYER
    water[:, 2] = np.sign(water[:, 2]) * HALF_BILAYER + 2.0 * room * water[:, 2]
    everything = np.vstack([*places, water])
    return everything - EDGES * np.rint(everything / EDGES)


def config() -> str:
    """Return CONFIG."""
    names = ["H", *"T" * TAIL] * (2 * ROWS * COLUMNS) + ["W"] * WATER
    lines = [
        "a flat bilayer in water",
        f"0 2 {len(names)}",
        *(" ".join(f"{x:.6f}" for x in row) for row in np.diag(EDGES)),
    ]
    for number, (name, place) in enumerate(zip(names, positions(), strict=True), 1):
        lines += [f"{name} {number}", " ".join(f"{x:.4f}" for x in place)]
    return "\n".join([*lines, ""])


def files() -> dict[str, str]:
    """Return the example's files by name."""
    return {"CONTROL": CONTROL, "FIELD": field(), "CONFIG": config()}


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, text in files().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
