"""``python -m pydlpoly``."""

from pydlpoly.cli import main

main()
