"""Reports of runs: one HTML file with figures, pictures and warnings in words, from the files that a run has left.

``collect_run`` reads what is there, ``judge_run`` says what is to be thought of it, ``write_report`` makes the page.
"""

from pydlpoly.report.collect import Run, collect_run
from pydlpoly.report.finding import Finding
from pydlpoly.report.judge import judge_run
from pydlpoly.report.page import write_report

__all__ = ["Finding", "Run", "collect_run", "judge_run", "write_report"]
