"""The ensemble, the temperature and the start: how a step is taken, and which momenta share the kinetic energy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from pydlpoly.formats.keywords import KEYWORDS
from pydlpoly.formats.records import Configuration, FloatArray
from pydlpoly.scene.beads import Layout
from pydlpoly.scene.integrators import INTEGRATORS, THERMOSTATS, is_pairwise
from pydlpoly.scene.model import (
    MOST_THREADS,
    Dynamics,
    ExternalTerm,
    PairTerm,
    Precision,
    RunPlan,
    Schedule,
    Start,
    Walls,
)
from pydlpoly.scene.settings import Notes, Settings, place
from pydlpoly.units import BOLTZMANN

_AVAILABLE = {
    "new": "available are ensemble nve, ensemble nvt with ensemble_method langevin, berendsen, hoover, or dpd and an "
    "ensemble_dpd_order, and ensemble npt and nst with ensemble_method langevin or dpd",
    "old": "available are ensemble nve, ensemble nvt langevin, berendsen, hoover, mdvv and the other orders of DPD, "
    "and ensemble npt and nst langevin",
}
_METHODS = {
    "nvt": ("", "dpd", *THERMOSTATS),
    **dict.fromkeys(("npt", "nst"), ("", "dpd", "langevin")),
}


def resolve_dynamics(settings: Settings, reduced: bool, notes: Notes) -> Dynamics:
    """Return integrator, timestep, k_B T and the thermostat's numbers; ``remove_drift`` is settled later.

    Raises:
        SceneError: an ensemble that is not modelled, a timestep that is not positive, a negative temperature.
    """
    timestep = settings.number("timestep")
    if not timestep > 0.0:
        raise settings.refusal("timestep", f"the timestep must be above 0 ps, not {timestep:g}")
    temperature = _temperature(settings, reduced, notes)
    precision = cast(Precision, settings.word("precision"))
    order = _integrator(settings)
    dynamics = Dynamics(order, timestep, BOLTZMANN * temperature, precision=precision)
    if order == "nve":
        return dynamics
    if temperature == 0.0 and is_pairwise(order):
        notes.choice("the DPD thermostat has temperature 0: drag only, no noise", settings.where("temperature"))
    taken = (INTEGRATORS | THERMOSTATS)[order].keywords
    for keyword, (name, check, expected) in _PARAMETERS.items():
        if keyword not in taken:
            continue
        value = settings.integer(keyword) if KEYWORDS[keyword].kind == "int" else settings.number(keyword)
        if not check(value):
            if not settings.given(keyword):
                raise settings.refusal("ensemble_method", f"{order} needs {keyword}: {expected}")
            raise settings.refusal(keyword, f"{expected}, not {value:g}")
        changes: dict[str, Any] = {name: value}
        dynamics = replace(dynamics, **changes)
    across = "ensemble_dpd_transverse_drag"
    if across not in taken and settings.given(across) and settings.number(across) != 0.0:
        sweeps = ", ".join(name for name, info in INTEGRATORS.items() if across in info.keywords)
        raise settings.refusal(across, f"{order} has no drag across a pair's line; those that have: {sweeps}")
    if "ensemble_dpd_kinetic" in taken:
        dynamics = replace(dynamics, half_step_kinetic=settings.word("ensemble_dpd_kinetic") == "half")
    schedule, thermal_energy = _schedule(settings, BOLTZMANN * temperature)
    return replace(dynamics, schedule=schedule, thermal_energy=thermal_energy)


_PARAMETERS: dict[str, tuple[str, Callable[[float], bool], str]] = {
    "ensemble_dpd_lambda": ("prediction", lambda x: 0.0 <= x <= 1.0, "Groot and Warren's lambda lies in 0 to 1"),
    "ensemble_thermostat_friction": ("thermostat_friction", lambda x: x > 0.0, "the friction must be above 0"),
    "ensemble_thermostat_coupling": ("relaxation", lambda x: x > 0.0, "the relaxation time must be above 0"),
    "ensemble_dpd_exponent": (
        "weight_exponent",
        lambda x: x > 0.0,
        "the exponent of the drag's weight must be above 0",
    ),
    "ensemble_dpd_transverse_drag": (
        "transverse_drag",
        lambda x: x >= 0.0,
        "the drag across the line of a pair must not be negative",
    ),
    "ensemble_dpd_rate": ("collision_rate", lambda x: x >= 0.0, "the rate must not be negative"),
    "ensemble_dpd_coupling": ("coupling", lambda x: x >= 0.0, "the coupling must not be negative"),
    "ensemble_dpd_tolerance": ("tolerance", lambda x: 0.0 < x <= 0.1, "the tolerance lies above 0 and up to 0.1"),
    "ensemble_dpd_passes": ("passes", lambda x: 1 <= x <= 3, "the number of passes lies in 1 to 3"),
    "ensemble_dpd_interval": ("interval", lambda x: 1 <= x <= 100, "the interval lies in 1 to 100 steps"),
    "ensemble_dpd_thermostat_mass": ("thermostat_mass", lambda x: x > 0.0, "the thermostat's mass must be above 0"),
    "ensemble_dpd_thermostat_friction": (
        "thermostat_friction",
        lambda x: x >= 0.0,
        "the thermostat's friction must not be negative",
    ),
}
# keyword: attribute of Dynamics, what its value must fulfil, and the same in words


def _schedule(settings: Settings, thermal_energy: float) -> tuple[Schedule | None, float]:
    """Return how the temperature varies, and the k_B T that the noise amplitudes of the pairs belong to."""
    times, values = settings.given("temperature_times"), settings.given("temperature_values")
    settings.consumed.update(("temperature_times", "temperature_values"))
    amplitude = BOLTZMANN * settings.number("temperature_amplitude")
    if amplitude != 0.0:
        period = settings.number("temperature_period")
        if times or values:
            raise settings.refusal("temperature_amplitude", "the temperature follows points or a sine, not both")
        if not period > 0.0:
            raise settings.refusal("temperature_amplitude", "the sine needs a temperature_period above 0")
        if abs(amplitude) > thermal_energy:
            raise settings.refusal("temperature_amplitude", "the temperature would become negative")
        return Schedule(amplitude=amplitude, period=period), thermal_energy
    if not times and not values:
        return None, thermal_energy
    if not (times and values):
        keyword = "temperature_times" if times else "temperature_values"
        raise settings.refusal(keyword, "temperature_times and temperature_values belong together")
    at, temperatures = settings.vector("temperature_times"), settings.vector("temperature_values")
    if len(at) != len(temperatures):
        message = f"there are {len(at)} times and {len(temperatures)} temperatures"
        raise settings.refusal("temperature_values", message)
    if any(late <= early for early, late in pairwise(at)):
        raise settings.refusal("temperature_times", "the times must ascend")
    if min(temperatures) < 0.0:
        raise settings.refusal("temperature_values", "a temperature must not be negative")
    energies = tuple(BOLTZMANN * x for x in temperatures)
    # Noise is scaled from this temperature's; it must not be 0 while another one is not.
    return Schedule(times=at, energies=energies), thermal_energy if thermal_energy > 0.0 else max(energies)


def _temperature(settings: Settings, reduced: bool, notes: Notes) -> float:
    temperature = settings.number("temperature")
    if not temperature >= 0.0:
        raise settings.refusal("temperature", f"the temperature must not be negative, found {temperature:g} K")
    given = settings.setting("temperature")
    if given is None:
        notes.choice("no temperature is given: 0 K", place(settings.path, None))
    elif reduced and (given.unit is None or given.unit.lower() == "k"):
        notes.warning(
            f"units dpd, but the temperature is in K: {temperature:g} K is k_B T = {BOLTZMANN * temperature:.6g}; for "
            f"k_B T = 1 write it as 1 dpd_temp, or as {1 / BOLTZMANN:.7f} K",
            settings.where("temperature"),
        )
    return temperature


def _integrator(settings: Settings) -> str:
    """Return the name of the integrator; what is not modelled is refused by name."""
    ensemble = settings.word("ensemble")
    if ensemble == "nve":
        return "nve"
    available, method = _AVAILABLE[settings.style], settings.word("ensemble_method")
    if method not in _METHODS.get(ensemble, ()):
        keyword = "ensemble_method" if ensemble in _METHODS and settings.given("ensemble_method") else "ensemble"
        name = f"ensemble {ensemble} {method}".strip()
        raise settings.refusal(keyword, f"{name} is not modelled; {available}")
    if method == "":
        raise settings.refusal("ensemble", f"ensemble {ensemble} needs a thermostat; {available}")
    if method in THERMOSTATS:
        return method
    order = settings.word("ensemble_dpd_order")
    if order == "off":
        keyword = "ensemble_dpd_order" if settings.given("ensemble_dpd_order") else "ensemble_method"
        raise settings.refusal(keyword, f"the DPD thermostat needs ensemble_dpd_order; {available}")
    return order


_LIMITS = {
    "peters-first": (2.0, "peters-first needs drag x timestep / reduced mass below 2; peters has no such limit"),
    "lowe-andersen": (1.0, "the probability that a pair is chosen in one step would be above 1"),
    "stoyanov-groot": (1.0, "the probability that a pair is chosen in one step would be above 1"),
    "middle": (
        2.0,
        "middle is not stable unless drag x interval x timestep / reduced mass is below 2; ou-middle has no such limit",
    ),
}
_LONG = 1.5  # the same product from which middle gets per cents wrong


def limit_exceeded(
    dynamics: Dynamics,
    pairs: tuple[PairTerm, ...],
    names: tuple[str, ...],
    mass: FloatArray,
    species: NDArray[np.int32],
    frozen: NDArray[np.bool_],
) -> str | None:
    """Say where a pair map is not defined for the timestep, or return None: too strong a drag, or too high a rate."""
    if dynamics.integrator not in _LIMITS:
        return None
    limit, words = _LIMITS[dynamics.integrator]
    lightest = [float(mass[~frozen & (species == k)].min(initial=np.inf)) for k in range(len(names))]
    for term in pairs:
        a, b = term.species
        inverse = 1.0 / lightest[a] + 1.0 / lightest[b]
        if dynamics.integrator in ("peters-first", "middle"):
            found = term.drag * dynamics.interval * dynamics.timestep * inverse
        else:
            found = (dynamics.collision_rate or 0.5 * term.drag * inverse) * dynamics.timestep
        if found > limit or (found == limit and dynamics.integrator in ("peters-first", "middle")):
            return f"pair {names[a]} {names[b]}: {words}; here it is {found:.4g}"
    return None


def check_limits(
    dynamics: Dynamics, pairs: tuple[PairTerm, ...], layout: Layout, settings: Settings, notes: Notes
) -> None:
    """Raise SceneError where a pair map is not defined for the timestep: too strong a drag, or too high a rate."""
    names = tuple(layout.species_names)
    exceeded = limit_exceeded(dynamics, pairs, names, layout.mass, layout.species, layout.frozen)
    if exceeded is not None:
        raise settings.refusal("ensemble_dpd_order", exceeded)
    if dynamics.integrator == "nose-hoover-langevin" and not dynamics.thermal_energy > 0.0:
        raise settings.refusal("ensemble_dpd_order", "nose-hoover-langevin needs a temperature above 0")
    if dynamics.integrator == "middle":
        mobile = layout.mass[~layout.frozen]
        strongest = max((term.drag for term in pairs), default=0.0)
        product = strongest * dynamics.interval * dynamics.timestep * 2.0 / float(mobile.min(initial=np.inf))
        if product > _LONG:
            notes.warning(
                f"drag x interval x timestep / reduced mass reaches {product:.3g}; above {_LONG:g} middle may be "
                "some per cent too hot: take a smaller interval or timestep",
                settings.where("ensemble_dpd_order"),
            )


def resolve_run(settings: Settings, thermostat: bool, config: Configuration, notes: Notes) -> RunPlan:
    """Return length, equilibration, seed and start of the run; ``thermostat`` says whether noise needs a seed.

    Raises:
        SceneError: a negative number of steps or threads, or a seed that is not made of whole numbers.
    """
    steps, equilibration = settings.steps("time_run"), settings.steps("time_equilibration")
    for keyword, number in (("time_run", steps), ("time_equilibration", equilibration)):
        if number < 0:
            raise settings.refusal(keyword, f"the number of steps must not be negative, found {number}")
    if equilibration > steps > 0:
        notes.warning(
            f"equilibration ({equilibration} steps) is longer than the run ({steps} steps)",
            settings.where("time_equilibration"),
        )
    plan = RunPlan(
        steps=steps,
        equilibration_steps=equilibration,
        record_equilibration=settings.switch("record_equilibration"),
        rescale_every=max(0, settings.steps("rescale_frequency")),
        regauss_every=max(0, settings.steps("regauss_frequency")),
        force_cap=_force_cap(settings),
        seed=_seed(settings),
        start=_start(settings, config, notes),
        checkpoint_file=settings.text("io_file_revold"),
        threads=_threads(settings),
    )
    if plan.seed is None and (thermostat or plan.start == "clean" or plan.regauss_every):
        notes.choice("no random_seed: a seed is drawn anew for each run and printed", place(settings.path, None))
    measures = [("rescale_frequency", plan.rescale_every), ("regauss_frequency", plan.regauss_every)]
    for keyword, value in [*measures, ("equilibration_force_cap", plan.force_cap)]:
        if value and equilibration == 0:
            notes.ignored(
                f"{keyword} never acts: there is no equilibration (time_equilibration)", settings.where(keyword)
            )
    return plan


def _threads(settings: Settings) -> int:
    threads = settings.integer("threads")
    if threads < 0:
        raise settings.refusal("threads", f"the number of threads must not be negative, found {threads}")
    if threads > MOST_THREADS:
        raise settings.refusal("threads", f"at most {MOST_THREADS} threads can be used, found {threads}")
    return threads


def _force_cap(settings: Settings) -> float:
    cap = settings.number_if_given("equilibration_force_cap", 0.0)
    if cap < 0.0:
        raise settings.refusal("equilibration_force_cap", f"the largest force must not be negative, found {cap:g}")
    return cap


def _start(settings: Settings, config: Configuration, notes: Notes) -> Start:
    word = settings.word("restart")
    starts: dict[str, Start] = {s: s for s in ("clean", "rescale", "noscale", "continue")}
    if word not in starts:
        raise settings.refusal("restart", f"the start is one of {', '.join(starts)}, not {word}")
    start, where = starts[word], settings.where("restart")
    if start in ("rescale", "noscale") and config.velocities is None:
        notes.warning(
            f"restart {start} needs velocities, and {config.path} has none (levcfg 0): they are drawn, as for restart "
            "clean (DL_POLY's warning 200)",
            where,
        )
        return "clean"
    at_rest = config.velocities is not None and not config.velocities.any()
    if start == "noscale" and at_rest:
        notes.choice(
            "restart noscale from velocities that are all 0: the beads start at rest; DL_POLY draws them", where
        )
    if start == "rescale" and at_rest:
        notes.warning(
            "restart rescale cannot scale velocities that are all 0: they are drawn as for restart clean", where
        )
        return "clean"
    return start


def combine_seed(numbers: tuple[int, ...]) -> int:
    """Return one 64-bit seed from whole numbers of any size and count.

    Each number is added to the state together with 2⁶⁴/φ (9e3779b97f4a7c15 in hexadecimal), and the sum goes through
    the finalizer of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): neighbouring triples give unrelated seeds, and the
    order of the numbers matters.
    """
    mask, state = 2**64 - 1, 0
    for number in numbers:
        state = (state + number + 0x9E3779B97F4A7C15) & mask
        state = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & mask
        state = ((state ^ (state >> 27)) * 0x94D049BB133111EB) & mask
        state ^= state >> 31
    return state


def _seed(settings: Settings) -> int | None:
    """Return the seed, or None when the file has none; one number alone is the seed itself, three are combined."""
    numbers = settings.vector("random_seed")
    if not settings.given("random_seed"):
        return None
    if any(number != int(number) for number in numbers):
        raise settings.refusal("random_seed", "the seed is made of whole numbers")
    whole = tuple(int(number) for number in numbers)
    return whole[0] if len(whole) == 1 and 0 <= whole[0] < 2**64 else combine_seed(whole)


def settle_momentum(
    dynamics: Dynamics,
    layout: Layout,
    external: tuple[ExternalTerm, ...],
    walls: Walls | None,
    settings: Settings,
    notes: Notes,
) -> tuple[Dynamics, int]:
    """Return the dynamics with ``remove_drift`` settled, and the number of degrees of freedom.

    The three momenta of the centre of mass do not count when they are 0 and stay 0: under nve because the drift is
    removed, under the DPD thermostat, which conserves them by itself, unless frozen beads, walls or external fields
    feed them. Langevin dynamics feeds them in every step, so that there, too, the drift is removed.
    """
    mobile = int(np.count_nonzero(~layout.frozen))
    disturbed = bool(external) or walls is not None or mobile < len(layout.frozen)
    fixed = settings.switch("fixed_com")
    if fixed and is_pairwise(dynamics.integrator) and disturbed:
        cause = "external fields" if external else "walls" if walls is not None else "frozen beads"
        notes.choice(
            f"fixed_com: the DPD thermostat does not remove the drift that {cause} bring about, so all {3 * mobile} "
            "momenta count as degrees of freedom",
            settings.where("fixed_com"),
        )
        fixed = False
    degrees = max(0, 3 * mobile - (3 if fixed else 0))
    if degrees < 1:
        notes.warning("no degree of freedom is left: the temperature is reported as 0")
    fed = disturbed or dynamics.integrator == "langevin"
    return replace(dynamics, remove_drift=fixed and not is_pairwise(dynamics.integrator) and fed), degrees


def start_velocities(
    config: Configuration, layout: Layout, plan: RunPlan, fixed_com: bool, notes: Notes
) -> FloatArray | None:
    """Return the velocities to start from (Å/ps), or None when they are to be drawn.

    Frozen beads have none. The drift of the centre of mass is taken out when its momenta do not count.
    """
    if plan.start == "clean" or config.velocities is None:
        return None
    velocities = np.array(config.velocities, dtype=np.float64)
    if velocities[layout.frozen].any():
        notes.choice("the velocities that the file gives to frozen beads are set to 0", place(config.path, None))
        velocities[layout.frozen] = 0.0
    if not fixed_com or plan.start == "continue" or layout.frozen.all():
        return velocities
    mass = np.where(layout.frozen, 0.0, layout.mass)
    drift = mass @ velocities / mass.sum()
    if np.abs(drift).max() > 1e-12 * max(float(np.abs(velocities).max()), 1e-300):
        text = " ".join(f"{x:.4g}" for x in drift)
        notes.choice(
            f"fixed_com: the centre of mass drifts with {text} ang/ps, which is taken out at the start", config.path
        )
        velocities[~layout.frozen] -= drift
    return velocities
