"""Reports of runs: one HTML file with figures, pictures and warnings in words, from the files that a run has left.

``collect`` reads what is there, ``judge`` says what is to be thought of it, ``write_report`` makes the page.
"""

from pydlpoly.report.collect import Run, collect
from pydlpoly.report.judge import Finding, judge
from pydlpoly.report.page import write_report

__all__ = ["Finding", "Run", "collect", "judge", "write_report"]
