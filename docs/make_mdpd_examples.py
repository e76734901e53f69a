"""Writes the files of the shipped examples ``droplet`` and ``wetting``; the same bytes every time.

Both are the many-body DPD liquid of Warren (A = −40, B = 25, r_d = 3/4). ``droplet`` is a film of 3456 beads that
becomes an oscillating droplet; ``wetting`` puts half a sphere of 1666 beads on a wall of 2400 frozen ones.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

EXAMPLES = Path(__file__).resolve().parents[1] / "pydlpoly" / "examples"
EDGE = 0.8736  # of a face-centred cubic lattice of density 6
BASIS = np.array([[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]])
WALL_CELLS = 20  # along x and y
WALL_LAYERS = 3  # half a lattice constant apart
WALL_HEIGHT = 16.0

CONTROL = """\
title {title}

temperature            1.0 dpd_temp
ensemble               nvt
ensemble_method        dpd
ensemble_dpd_order     mdvv
cutoff                 1.0 dpd_l
vdw_method             direct

timestep               0.01 dpd_t
time_run               {steps} steps
time_equilibration     {equilibration} steps
random_seed            [ 31 12 22 ]

print_frequency        200 steps
stats_frequency        20 steps
traj_calculate         on
traj_interval          {interval} steps
data_dump_frequency    5000 steps
"""


def lattice(cells: tuple[int, int, int]) -> NDArray[np.float64]:
    """(N, 3) sites of so many cells, around the origin."""
    corners = np.stack(np.meshgrid(*(np.arange(n) for n in cells), indexing="ij"), axis=-1).reshape(-1, 1, 3)
    sites = (corners + BASIS).reshape(-1, 3) + 0.25
    return np.asarray((sites - 0.5 * np.array(cells)) * EDGE)


def config(title: str, edges: tuple[float, float, float], beads: list[tuple[str, NDArray[np.float64]]]) -> str:
    """Return CONFIG of an orthorhombic cell; beads by species."""
    rows = [(name, place) for name, places in beads for place in places]
    lines = [title, f"0 2 {len(rows)}"]
    lines += [" ".join(f"{edges[k] if k == axis else 0.0:.4f}" for k in range(3)) for axis in range(3)]
    for k, (name, place) in enumerate(rows, 1):
        lines += [f"{name} {k}", " ".join(f"{x:.4f}" for x in place)]
    return "\n".join([*lines, ""])


def field(title: str, molecules: list[tuple[str, int, bool]], pairs: list[str]) -> str:
    """Return FIELD of single beads: species, number, whether frozen."""
    lines = [title, "units dpd", f"molecules {len(molecules)}"]
    for name, count, frozen in molecules:
        lines += [
            "wall" if frozen else "liquid",
            f"nummols {count}",
            "atoms 1",
            f"{name} 1.0 0.0 1 {int(frozen)}",
            "finish",
        ]
    return "\n".join([*lines, f"vdw {len(pairs)}", "# species  law  A  B  r_c  r_d  drag", *pairs, "close", ""])


def droplet() -> dict[str, str]:
    """Return the files of ``droplet``."""
    places = lattice((24, 12, 3))
    title = "A film of a many-body DPD liquid becomes an oscillating droplet"
    return {
        "CONTROL": CONTROL.format(title=title, steps=8000, equilibration=0, interval=100),
        "FIELD": field(title, [("L", len(places), False)], ["L L mdpd  -40.0  25.0  1.0  0.75  4.5"]),
        "CONFIG": config("a film on a face-centred cubic lattice", (26.0, 16.0, 16.0), [("L", places)]),
    }


def wetting(attraction: float = -30.0) -> dict[str, str]:
    """Return the files of ``wetting`` with this A between liquid and wall, A_sw."""
    edge = WALL_CELLS * EDGE
    bottom = -0.5 * WALL_HEIGHT
    wall = lattice((WALL_CELLS, WALL_CELLS, 2))
    wall[:, 2] += bottom - wall[:, 2].min() + 0.05
    wall = wall[wall[:, 2] < bottom + 0.05 + (WALL_LAYERS - 0.5) * EDGE / 2]
    top = wall[:, 2].max()
    drop = lattice((14, 14, 7))
    drop[:, 2] += top - drop[:, 2].min() + 0.6
    drop = drop[np.linalg.norm(drop - [0.0, 0.0, top + 0.6], axis=1) < 5.0]
    title = "A droplet of a many-body DPD liquid on a wall of frozen beads"
    pairs = [
        "L L mdpd  -40.0  25.0  1.0  0.75  4.5",
        f"L W mdpd  {attraction:.1f}  25.0  1.0  0.75  4.5",
        "W W mdpd  -40.0  25.0  1.0  0.75  4.5",
    ]
    return {
        "CONTROL": CONTROL.format(title=title, steps=20000, equilibration=0, interval=100),
        "FIELD": field(title, [("W", len(wall), True), ("L", len(drop), False)], pairs),
        "CONFIG": config(
            "half a sphere on three layers of a face-centred cubic lattice",
            (edge, edge, WALL_HEIGHT),
            [("W", wall), ("L", drop)],
        ),
    }


def main() -> None:
    """Write both examples."""
    for name, files in (("droplet", droplet()), ("wetting", wetting())):
        folder = EXAMPLES / name
        folder.mkdir(exist_ok=True)
        for file, text in files.items():
            (folder / file).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
