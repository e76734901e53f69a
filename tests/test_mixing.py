"""Mixing rules: hand-made arithmetic for each, what all have in common, odd inputs, spellings."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest

from pydlpoly import _core

RULES = _core.mixing_rules()
MIXABLE = {
    "lj": [5.0, 1.5],
    "12-6": [2000.0, 90.0],
    "ljc": [5.0, 1.5, 0.7],
    "wca": [5.0, 1.5, 0.2],
    "dpd": [25.0, 1.2],
    "14-7": [5.0, 1.5],
    "mlj": [5.0, 1.5, 2.1],
    "m126": [2000.0, 90.0, 2.1],
}


def mix(
    rule: str, first: list[float], second: list[float], drag: tuple[float, float] = (0, 0), key: str = "lj"
) -> tuple[list[float], float]:
    parameters, mixed_drag = _core.mix(rule, key, first, second, *drag)
    return parameters, mixed_drag


def test_the_rules() -> None:
    assert RULES == [
        "lorentz-berthelot",
        "fender-halsey",
        "hogervorst",
        "halgren",
        "waldman-hagler",
        "tang-toennies",
        "functional",
    ]


# ---- one hand-made case a rule: eps 4 and 9, sig 1 and 2, drag 4 and 16 ----------------------------------------------


@dataclass(frozen=True)
class Hand:
    eps: float
    sig: float
    drag: float
    spread: float  # D of wca, 0.1 and 0.2 (kept below sig/2)


# t_0 = (1 + 8)^2/4 = 81/4, t_1 = t_0/(1*2) = 81/8, t_2 = t_0/4 = 81/16; the lengths of the functional rule:
L0, L1, L2 = 20.25 ** (1 / 6), 10.125 ** (1 / 4), 5.0625 ** (1 / 2)  # 1.6510, 1.7838, 2.25
FUNCTIONAL_SIG = (L0 + L1 + L2) / 3
# eps = 3 sqrt(36) (1*2)^3 / (t_0 + t_1^(6/4) + t_2^3), and 5.0625^3 = 129.746337890625
FUNCTIONAL_EPS = 144 / (20.25 + 10.125**1.5 + 129.746337890625)

# Tang-Toennies: eps sig^6 = 4 and 576, eps sig^12 = 4 and 36864, P = 4 * 576 = 2304
TANG_EPS = 2304 / ((4 ** (1 / 13) + 36864 ** (1 / 13)) / 2) ** 13
TANG_SIG = (48 / TANG_EPS) ** (1 / 6)

HAND = {
    # sqrt(4*9); (1+2)/2; sqrt(4*16); (0.1+0.2)/2
    "lorentz-berthelot": Hand(6, 1.5, 8, 0.15),
    # 2*4*9/13; (1+2)/2; 2*4*16/20; (0.1+0.2)/2
    "fender-halsey": Hand(72 / 13, 1.5, 6.4, 0.15),
    # sqrt(4*9); sqrt(1*2); sqrt(4*16); sqrt(0.1*0.2)
    "hogervorst": Hand(6, math.sqrt(2), 8, math.sqrt(0.02)),
    # 4*4*9/(2+3)^2; (1+8)/(1+4); 4*4*16/(2+4)^2; (0.001+0.008)/(0.01+0.04)
    "halgren": Hand(144 / 25, 9 / 5, 64 / 9, 0.18),
    # S = (1+64)/2 = 32.5; sqrt(36)*2^3/S; S^(1/6); sqrt(64)*2^3/S; D: ((0.1^6+0.2^6)/2)^(1/6) = 0.1 S^(1/6)
    "waldman-hagler": Hand(48 / 32.5, 32.5 ** (1 / 6), 64 / 32.5, 0.1 * 32.5 ** (1 / 6)),
    # drag: eps/2 (4/4 + 16/9) = eps*25/18; D: sig/2 (0.1/1 + 0.2/2) = sig/10
    "tang-toennies": Hand(TANG_EPS, TANG_SIG, TANG_EPS * 25 / 18, TANG_SIG / 10),
    "functional": Hand(FUNCTIONAL_EPS, FUNCTIONAL_SIG, FUNCTIONAL_EPS * 25 / 18, FUNCTIONAL_SIG / 10),
}


def test_hand_numbers_have_the_right_size() -> None:
    """The two long expressions above, worked with four-figure logarithms."""
    # 144/(20.25 + 32.217 + 129.746) = 144/182.21; (1.6510 + 1.7838 + 2.25)/3
    assert pytest.approx((1.8949, 0.7903), abs=1e-4) == (FUNCTIONAL_SIG, FUNCTIONAL_EPS)
    # roots exp(1.38629/13) = 1.11253 and exp(10.5149/13) = 2.24530, mean 1.67892, exp(13 * 0.518148) = 842.1;
    # 2304/842.1 = 2.736, (48/2.736)^(1/6) = exp(2.8647/6)
    assert pytest.approx((1.6120, 2.736), abs=3e-4) == (TANG_SIG, TANG_EPS)


@pytest.mark.parametrize("rule", RULES)
def test_rule_by_hand(rule: str) -> None:
    hand = HAND[rule]
    parameters, drag = mix(rule, [4, 1], [9, 2], (4, 16))
    assert parameters == pytest.approx([hand.eps, hand.sig], rel=1e-13)
    assert drag == pytest.approx(hand.drag, rel=1e-13)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("key", ["dpd", "14-7"])
def test_laws_of_an_energy_and_a_length(rule: str, key: str) -> None:
    parameters, drag = mix(rule, [4, 1], [9, 2], (4, 16), key)
    assert [*parameters, drag] == pytest.approx([HAND[rule].eps, HAND[rule].sig, HAND[rule].drag], rel=1e-13)


@pytest.mark.parametrize("rule", RULES)
def test_twelve_six_is_converted(rule: str) -> None:
    """A = 4 eps sig^12 and B = 4 eps sig^6: (16, 16) and (36*4096, 36*64)."""
    (a, b), drag = mix(rule, [16, 16], [147456, 2304], (4, 16), "12-6")
    eps, sig = HAND[rule].eps, HAND[rule].sig
    assert (a, b) == pytest.approx((4 * eps * sig**12, 4 * eps * sig**6), rel=1e-12)
    assert drag == pytest.approx(HAND[rule].drag, rel=1e-12)


@pytest.mark.parametrize("rule", RULES)
def test_second_lengths(rule: str) -> None:
    """D of wca and ri of the tapered laws mix like sig."""
    hand = HAND[rule]
    assert mix(rule, [4, 1, 0.1], [9, 2, 0.2], key="wca")[0] == pytest.approx([hand.eps, hand.sig, hand.spread])
    assert mix(rule, [4, 1, 0.1], [9, 2, 0.2], key="mlj")[0] == pytest.approx([hand.eps, hand.sig, hand.spread])
    a, b, ri = mix(rule, [16, 16, 0.1], [147456, 2304, 0.2], key="m126")[0]
    assert ri == pytest.approx(hand.spread)
    assert (b * b / (4 * a), (a / b) ** (1 / 6)) == pytest.approx((hand.eps, hand.sig))


@pytest.mark.parametrize("rule", RULES)
def test_attraction_factor_mixes_geometrically(rule: str) -> None:
    eps, sig, c = mix(rule, [4, 1, 0.25], [9, 2, 1.0], key="ljc")[0]
    assert (eps, sig, c) == pytest.approx((HAND[rule].eps, HAND[rule].sig, 0.5))
    assert mix(rule, [4, 1, 0], [9, 2, 1.0], key="ljc")[0][2] == 0


def test_wca_numbers_are_read_as_the_law_reads_them() -> None:
    """sig without its sign, D at most sig/2."""
    assert mix("lorentz-berthelot", [4, -1, 0.9], [9, 2, 0.2], key="wca")[0] == pytest.approx([6, 1.5, 0.35])
    assert mix("fender-halsey", [4, 1, -0.3], [9, 2, 0.2], key="wca")[0][2] == pytest.approx(-0.05)
    with pytest.raises(ValueError, match="hogervorst for pair law wca: the rule has no mean of negative lengths"):
        mix("hogervorst", [4, 1, -0.3], [9, 2, 0.2], key="wca")


# ---- what all rules share -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("key", MIXABLE)
def test_equal_species_keep_their_numbers(rule: str, key: str) -> None:
    parameters, drag = mix(rule, MIXABLE[key], MIXABLE[key], (4.5, 4.5), key)
    assert parameters == pytest.approx(MIXABLE[key], rel=1e-12)
    assert drag == pytest.approx(4.5, rel=1e-12)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("key", MIXABLE)
def test_order_of_species_does_not_matter(rule: str, key: str) -> None:
    other = [1.7 * MIXABLE[key][0], 1.1 * MIXABLE[key][1], *(1.3 * x for x in MIXABLE[key][2:])]
    there = mix(rule, MIXABLE[key], other, (4.5, 3.0), key)
    back = mix(rule, other, MIXABLE[key], (3.0, 4.5), key)
    assert there[0] == pytest.approx(back[0], rel=1e-13)
    assert there[1] == pytest.approx(back[1], rel=1e-13)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("key", MIXABLE)
def test_mixed_numbers_are_accepted_by_the_law(rule: str, key: str) -> None:
    other = [1.7 * MIXABLE[key][0], 1.1 * MIXABLE[key][1], *(1.3 * x for x in MIXABLE[key][2:])]
    energy, force = _core.evaluate_pair(key, mix(rule, MIXABLE[key], other, key=key)[0], 4.0, [1.6])
    assert math.isfinite(energy[0])
    assert math.isfinite(force[0])


def test_mixable_laws() -> None:
    laws = _core.pair_laws()
    # mdpd has rules of its own, in tests/scene/test_many_body.py: some of its numbers must be equal already.
    assert {law["key"] for law in laws if law["mixable"]} == {*MIXABLE, "mdpd"}
    for law in laws:
        if not law["mixable"]:
            with pytest.raises(ValueError, match="cannot be mixed; give this pair its own line"):
                _core.mix("hogervorst", law["key"], [1.0, 1.0], [1.0, 1.0], 0, 0)


# ---- odd inputs -----------------------------------------------------------------------------------------------------

PLAIN = ["lorentz-berthelot", "fender-halsey", "hogervorst", "halgren", "waldman-hagler"]


@pytest.mark.parametrize("rule", PLAIN)
@pytest.mark.parametrize("first", [0.0, 9.0])
def test_a_species_without_energy_and_drag(rule: str, first: float) -> None:
    """A = 0 is an ideal DPD gas. The means of these rules are then zero, also 0/0 of two such species."""
    (energy, length), drag = mix(rule, [first, 1], [0, 2], (first, 0), "dpd")
    assert energy == 0
    assert drag == 0
    assert length == pytest.approx(HAND[rule].sig)


def test_tang_toennies_needs_both_energies() -> None:
    for pair in ([0.0, 1.0], [4.0, 1.0]), ([0.0, 1.0], [0.0, 1.0]), ([4.0, 0.0], [9.0, 1.0]):
        with pytest.raises(ValueError, match="tang-toennies for pair law lj: the rule divides by both energies"):
            mix("tang-toennies", *pair)


def test_functional_rule_without_energy() -> None:
    """sig needs no energy; the drag's limit is zero only if the species without energy has no drag either."""
    parameters, drag = mix("functional", [0, 1], [9, 2], (0, 16), "dpd")
    assert parameters == pytest.approx([0, FUNCTIONAL_SIG])
    assert drag == 0
    with pytest.raises(ValueError, match="a species with drag needs an energy above zero"):
        mix("functional", [0, 1], [9, 2], (4, 16), "dpd")
    with pytest.raises(ValueError, match="functional for pair law lj: the rule divides by both lengths"):
        mix("functional", [4, 0], [9, 2])


def test_zero_drag_with_energy() -> None:
    # Tang-Toennies and the functional rule take half of the other species' share: e/2 (0/4 + 16/9)
    assert mix("tang-toennies", [4, 1], [9, 2], (0, 16))[1] == pytest.approx(TANG_EPS * 8 / 9)
    assert mix("functional", [4, 1], [9, 2], (0, 16))[1] == pytest.approx(FUNCTIONAL_EPS * 8 / 9)
    for rule in PLAIN:
        assert mix(rule, [4, 1], [9, 2], (0, 16))[1] == 0
    for rule in RULES:
        assert mix(rule, [4, 1], [9, 2], (0, 0))[1] == 0


def test_ghost_species() -> None:
    """eps = sig = 0, as for the hydrogens of some water models; 12-6 with A = B = 0 is the same."""
    assert mix("lorentz-berthelot", [0, 0], [9, 2])[0] == [0, 1]
    assert mix("halgren", [0, 0], [0, 0])[0] == [0, 0]
    assert mix("lorentz-berthelot", [0, 0], [16, 16], key="12-6")[0] == [0, 0]
    with pytest.raises(ValueError, match="must not both be zero"):
        mix("waldman-hagler", [0, 0], [0, 0])


@pytest.mark.parametrize(
    ("key", "first", "drags", "message"),
    [
        ("lj", [-1.0, 1.0], (0, 0), "energies and lengths must not be negative"),
        ("dpd", [25.0, 1.0], (-1, 0), "drags must be finite and not negative"),
        ("dpd", [25.0, 1.0], (math.nan, 0), "drags must be finite and not negative"),
        ("dpd", [25.0, 0.0], (0, 0), r"dpd: rc \(number 2\) must be a positive number"),
        ("12-6", [16.0, 0.0], (0, 0), "A and B have an eps and a sig only when both are above zero"),
        ("ljc", [1.0, 1.0, -1.0], (0, 0), "c must not be negative"),
        ("lj", [1.0], (0, 0), r"lj takes 2 numbers \(eps sig\), not 1"),
        ("mist", [1.0, 1.0], (0, 0), "unknown pair law 'mist'"),
    ],
)
def test_numbers_that_cannot_be_mixed(key: str, first: list[float], drags: tuple[float, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        mix("lorentz-berthelot", first, MIXABLE.get(key, [1.0, 1.0]), drags, key)


# ---- spellings ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("word", "rule"),
    [
        ("lore", "lorentz-berthelot"),
        ("FEND", "fender-halsey"),
        ("hoge", "hogervorst"),
        ("halg", "halgren"),
        ("wald", "waldman-hagler"),
        ("tang", "tang-toennies"),
        ("func", "functional"),
        ("Lorentz-Berthelot", "lorentz-berthelot"),
        ("WALDMAN_HAGLER", "waldman-hagler"),
        ("fender halsey", "fender-halsey"),
        ("Fender-Hasley", "fender-halsey"),
        ("tang-tonnies", "tang-toennies"),
    ],
)
def test_spellings(word: str, rule: str) -> None:
    assert mix(word, [4, 1], [9, 2], (4, 16)) == mix(rule, [4, 1], [9, 2], (4, 16))


def test_unknown_rule() -> None:
    with pytest.raises(ValueError, match=r"unknown mixing rule 'kong'; known are lorentz-berthelot, .*, functional"):
        mix("kong", [4, 1], [9, 2])
