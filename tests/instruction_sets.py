"""A program run once for every instruction set of the processor: the set is chosen when the core is loaded."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def printed_by_set(program: str, folder: Path) -> dict[str, str]:
    """Return what the program prints, by the name of the set; its first argument is where ``tests`` lies."""
    root = str(Path(__file__).parents[1])
    printed = {}
    for name in ("plain", "avx2", "avx512"):
        run = subprocess.run(
            [sys.executable, *(["-S"] if sys.flags.no_site else []), "-c", program, root],
            env={**os.environ, "PYDLPOLY_SIMD": name},
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
            cwd=folder,
        )
        if run.returncode == 0:
            printed[name] = run.stdout.strip()
        else:  # a set that the processor lacks
            assert "PYDLPOLY_SIMD" in run.stderr, run.stderr
    assert "plain" in printed
    return printed
