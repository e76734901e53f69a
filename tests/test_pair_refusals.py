"""Pair laws refuse numbers outside their range, naming the law, the number and what it should be."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import _core

CUTOFF = 4.0
BAD = [
    ("lj", [1.0], r"lj takes 2 numbers \(eps sig\), not 1"),
    ("lj", [1.0, 1.0, 4.5], r"lj takes 2 numbers \(eps sig\), not 3"),
    ("lj", [np.nan, 1.0], r"lj: eps \(number 1\) must be a finite number, not nan"),
    ("lj", [1.0, np.inf], r"lj: sig \(number 2\) must be a finite number, not inf"),
    ("lj", [1.0, -1.0], r"lj: sig \(number 2\) must be zero or a positive number, not -1"),
    ("ljf", [1.0, 1.5, 1.5], r"rc \(number 3\) must be greater than sig"),
    ("dpd", [25.0, 0.0], r"dpd: rc \(number 2\) must be a positive number, not 0"),
    ("ndpd", [25.0, 3.0, 1.0, 1.0], r"ndpd: n \(number 3\) must be greater than 1"),
    ("ndpd", [25.0, 3.0, 2.0, -1.0], r"ndpd: rc \(number 4\) must be a positive number"),
    ("nm", [1.0, 6.0, 6.0, 1.0], r"nm: n \(number 2\) must be greater than m, not 6"),
    ("nm", [1.0, 6.0, 0.0, 1.0], r"nm: m \(number 3\) must be a positive number"),
    ("snm", [1.0, 5.0, 6.0, 1.0, 2.0], r"snm: n \(number 2\) must be greater than m"),
    ("snm", [1.0, 12.0, 6.0, 2.0, 1.5], r"snm: rc \(number 5\) must be greater than r0"),
    ("buck", [1.0, -0.3, 1.0], r"buck: rho \(number 2\) must be zero or a positive number"),
    ("buck", [1.0, 0.0, 1.0], r"buck: rho \(number 2\) must be a positive number when A is not zero"),
    ("bhm", [1.0, -2.0, 1.0, 1.0, 1.0], r"bhm: B \(number 2\)"),
    ("mors", [1.0, 1.0, 0.0], r"mors: k \(number 3\) must be a positive number"),
    ("wca", [1.0, 0.0, 0.0], r"wca: sig \(number 2\) must be other than zero"),
    ("wca", [1.0, 1.0, -2.0], r"wca: D \(number 3\) must be greater than -2\^\(1/6\) sig"),
    ("14-7", [1.0, 0.0], r"14-7: r0 \(number 2\) must be a positive number"),
    ("ryd", [1.0, 1.0, -1.0], r"ryd: rho \(number 3\) must be a positive number"),
    ("zbl", [0.0, 8.0], r"zbl: Z1 \(number 1\) must be a positive number"),
    ("zbls", [6.0, 8.0, 1.4, 0.0, 1.0, 1.0, 1.0], r"zbls: xi \(number 4\) must be a positive number"),
    ("mlj", [1.0, 1.0, 4.0], r"mlj: ri \(number 3\) must be less than the cutoff, not 4"),
    ("mbuc", [1.0, 1.0, 1.0, -1.0], r"mbuc: ri \(number 4\) must be zero or a positive number"),
    ("sand", [1.0, 1.0, 0.0], r"sand: d \(number 3\) must be other than zero"),
    ("sw", [1.0, 7.0, 0.6, 0.0, 4, 0, 1.8], r"sw: sig \(number 4\) must be a positive number"),
    ("mdpd", [-40.0, 25.0, 1.0, 0.75], r"mdpd takes 6 numbers \(A B n m rc rd\), not 4"),
    ("mdpd", [-40.0, -1.0, 2.0, 2.0, 1.0, 0.75], r"mdpd: B \(number 2\) must be zero or a positive number"),
    ("mdpd", [-40.0, 25.0, 1.0, 2.0, 1.0, 0.75], r"mdpd: n \(number 3\) must be 2 or more, not 1"),
    ("mdpd", [-40.0, 25.0, 2.0, 0.5, 1.0, 0.75], r"mdpd: m \(number 4\) must be 1 or more"),
    ("mdpd", [-40.0, 25.0, 2.0, 2.0, 1.0, 1.25], r"mdpd: rd \(number 6\) must be at most rc, not 1.25"),
    ("mpdp", [1.0, 1.0], "unknown pair law 'mpdp'"),
    ("LJ", [1.0, 1.0], "unknown pair law 'LJ'"),
]


@pytest.mark.parametrize(("key", "parameters", "message"), BAD)
def test_bad_parameters(key: str, parameters: list[float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        _core.evaluate_pair(key, parameters, CUTOFF, [1.0])


@pytest.mark.parametrize("cutoff", [0.0, -1.0, np.nan, np.inf])
def test_bad_cutoff(cutoff: float) -> None:
    with pytest.raises(ValueError, match="the cutoff must be a positive number"):
        _core.evaluate_pair("lj", [1, 1], cutoff, [1.0])


@pytest.mark.parametrize("distance", [-1.0, np.nan])
def test_bad_distance(distance: float) -> None:
    with pytest.raises(ValueError, match="distances must be finite and not negative"):
        _core.evaluate_pair("lj", [1, 1], CUTOFF, [distance])
