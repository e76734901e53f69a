"""Small inputs for the scene's tests: a CONTROL by keyword, a FIELD by its vdw lines, a CONFIG by its names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest

from pydlpoly.formats.config import parse_config
from pydlpoly.formats.control import parse_control
from pydlpoly.formats.field import parse_field
from pydlpoly.formats.records import PairTable
from pydlpoly.scene import Scene, resolve

_CONTROL = {
    "ensemble": "nvt",
    "ensemble_method": "dpd",
    "ensemble_dpd_order": "mdvv",
    "temperature": "1.0 dpd_temp",
    "timestep": "0.01 dpd_t",
    "cutoff": "1.0 dpd_l",
    "time_run": "100 steps",
    "random_seed": "[ 1 2 3 ]",
}


@dataclass
class Input:
    """One input; the defaults are four A and two B beads in a cubic cell with a complete table of dpd pairs."""

    control: dict[str, str | None] = field(default_factory=dict)
    vdw: Sequence[str] = ("A A dpd 25.0 1.0 4.5", "A B dpd 30.0 1.0 4.5", "B B dpd 25.0 1.0 4.5")
    units: str = "dpd"
    atoms: Sequence[str] = ("A 1.0 0.0", "B 2.0 0.0")
    counts: Sequence[int] = (4, 2)
    inside: str = ""
    after: str = ""
    names: Sequence[str] | None = None
    cell: Sequence[Sequence[float]] = ((4, 0, 0), (0, 4, 0), (0, 0, 4))
    imcon: int = 1
    positions: Sequence[Sequence[float]] | None = None
    velocities: Sequence[Sequence[float]] | None = None
    tables: Sequence[PairTable] = ()

    def control_text(self) -> str:
        """Return CONTROL: the usual settings, changed or removed (None), then the further ones."""
        settings = {**_CONTROL, **self.control}
        return "\n".join(["title test", *(f"{k} {v}" for k, v in settings.items() if v is not None)]) + "\n"

    def field_text(self) -> str:
        """Return FIELD: one molecule an atom line; ``inside`` goes into the first one, ``after`` behind vdw."""
        lines = ["test", f"units {self.units}", f"molecules {len(self.atoms)}"]
        for k, (atom, count) in enumerate(zip(self.atoms, self.counts, strict=True)):
            lines += [f"mol{k + 1}", f"nummols {count}", f"atoms {_sites(atom)}", atom]
            lines += [self.inside] if self.inside and k == 0 else []
            lines += ["finish"]
        lines += [f"vdw {len(self.vdw)}", *self.vdw] if self.vdw else []
        return "\n".join([*lines, *([self.after] if self.after else []), "close"]) + "\n"

    def config_text(self) -> str:
        """Return CONFIG with positions on a coarse grid unless they are given."""
        names = self.names
        if names is None:
            names = [a.split()[0] for a, n in zip(self.atoms, self.counts, strict=True) for _ in range(n * _sites(a))]
        lines = ["test", f"{0 if self.velocities is None else 1} {self.imcon} {len(names)}"]
        lines += [" ".join(str(x) for x in row) for row in self.cell] if self.imcon else []
        for k, name in enumerate(names):
            place = self.positions[k] if self.positions is not None else (k % 4 - 1.5, k // 4 % 4 - 1.5, 0.0)
            lines += [f"{name} {k + 1}", " ".join(repr(float(x)) for x in place)]
            lines += [" ".join(str(x) for x in self.velocities[k])] if self.velocities is not None else []
        return "\n".join(lines) + "\n"

    def scene(self) -> Scene:
        """Return the scene of the three texts."""
        records = (
            parse_control(self.control_text()),
            parse_field(self.field_text()),
            parse_config(self.config_text()),
        )
        return resolve(*records, tables=self.tables)


def _sites(atom: str) -> int:
    words = atom.split()
    return int(words[3]) if len(words) > 3 else 1


@pytest.fixture
def make() -> type[Input]:
    """Return the builder of small inputs."""
    return Input


@pytest.fixture
def drifting() -> list[list[float]]:
    """Return velocities of six beads (four of mass 1, two of mass 2) whose centre of mass drifts with (0.5, 0, 0)."""
    velocities = np.array([[1, 0, 0], [-1, 0, 0], [0, 2, 0], [0, -2, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
    velocities[:, 0] += 0.5
    return velocities.tolist()
