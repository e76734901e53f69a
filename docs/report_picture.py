"""Makes docs/images/report.png, the report of the lipid example in Chromium: ``python docs/report_picture.py``."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from PIL import Image

from pydlpoly.cli import example_folder
from pydlpoly.report import write_report
from pydlpoly.runner import run_scene
from pydlpoly.scene import load

PICTURE = Path(__file__).resolve().parent / "images" / "report.png"
WIDTH, HEIGHT = 1100, 2590
_FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run", "--disable-sync")


def main() -> None:
    """Run the example, write its report, and take the picture."""
    browser = shutil.which("chromium")
    if browser is None:
        sys.exit("this needs Chromium: apt-get install chromium")
    scene = load(example_folder("lipid"))
    scene = replace(
        scene, output=replace(scene.output, diagnostics_every=20, rdf_every=20, zden_every=20, zden_bins=40)
    )
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)  # the page names the folder as it was given
        run_scene(scene, "lipid-run", steps=2000, seed=1)
        page, _ = write_report("lipid-run")
        shot = Path(name) / "shot.png"
        words = [browser, *_FLAGS, f"--user-data-dir={name}/profile", f"--screenshot={shot}"]
        subprocess.run(
            [*words, f"--window-size={WIDTH},{HEIGHT}", page.resolve().as_uri()], check=True, capture_output=True
        )
        with Image.open(shot) as image:
            image.convert("RGB").quantize(128, dither=Image.Dither.NONE).save(PICTURE, optimize=True)


if __name__ == "__main__":
    main()
