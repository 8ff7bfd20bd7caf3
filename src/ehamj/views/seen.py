"""The plant as a digital controller meets it: valves, machine and instruments from sample to sample."""

import math
from collections.abc import Sequence
from typing import Any

from ehamj.control import Controller
from ehamj.control.channels import MountChannels
from ehamj.control.law import silent
from ehamj.control.settings import SampledSettings
from ehamj.errors import InputError
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.sampled import sampled_machine
from ehamj.scenario.load import Given, as_scenario
from ehamj.scenario.model import Scenario


def sampled_plant(
    scenario: Given,
    outputs: Sequence[str] | None = None,
    rate: float | None = None,
    delay: float | None = None,
    disturbances: Sequence[str] = (),
    closed: bool = False,
) -> Any:
    """What a law sees of a scenario's machine, as a ``control.StateSpace`` with ``dt``, states scaled as `linearise`'s.

    Inputs are the commands as they are computed at a sample [V]; they act ``delay`` later and are held for a period.
    Outputs are the readings at the samples in SI, through the scenario's instruments (``[sensors]``); noise, range and
    resolution play no part. A law closed around it (``control.feedback(plant, law, sign=1)``) has the poles of the
    machine under this law, and runs as ``simulate(scenario, controller=law)``.

    Args:
        scenario: whose machine and instruments; its own law gives the clock and the channels where they are not stated.
        outputs: channels that are read; without: those of its law, or without a law vertical velocity, stroke and load
            pressure of every mount.
        rate: of the samples [Hz]; without: that of its law, or without a law the default of `[control]`.
        delay: of the computation [s]; without: that of its law of this rate, or one sample.
        disturbances: further inputs, of `linearise`'s, held between samples (half a sample late in the mean):
            displacement [m] and velocity [m/s] of the ground, each an input of its own, or forces [N, N m].
        closed: the scenario's own law runs as well, and the plant is what a further one of ``rate`` sees of both; its
            period must be a multiple of all periods of the own law.

    Raises:
        InputError: if its law has several rates and none is stated; if a channel or input is unknown, or an instrument
            measures another quantity; if ``rate`` or ``delay`` are no times; if there is no law to close, or its
            period does not divide this one.
    """
    scenario = as_scenario(scenario)
    own = scenario.controller()
    model = linear_under(scenario.plant, own if closed else None)
    laws = () if own is None else own.parts
    rates = list(dict.fromkeys(1.0 / law.period for law in laws))
    if rate is None and len(rates) > 1:
        found = ", ".join(f"{value:g}" for value in rates)
        raise InputError(f"rate: the scenario's law has several, {found} Hz; state the one of the plant: rate = …")
    period, delay = _clock(rate if rate is not None else (*rates, None)[0], delay, laws)
    unknown = [name for name in disturbances if name not in model.inputs or name in model.commands]
    if unknown:
        raise InputError(f"disturbances: {unknown[0]!r} is none; there are {', '.join(model.ground_inputs)} and forces")
    names = tuple(outputs) if outputs is not None else _standard(scenario) if own is None else own.inputs
    seen = silent(names, scenario.plant.mounts, period, delay)
    if closed:
        _check_closed(laws, period)
    plant = sampled_machine(model, Loop.of(scenario, seen), disturbances, laws if closed else ())
    plant.name = f"{scenario.name.replace('.', '-')}-sampled"
    return plant


def _standard(scenario: Scenario) -> tuple[str, ...]:
    at = MountChannels.of(scenario.plant)
    return (*at.feet, *at.strokes, *at.pressures)


def _clock(rate: float | None, delay: float | None, laws: Sequence[Controller]) -> tuple[float, float]:
    """Period and delay [s] as stated, or of the law of this rate, or as `[control]` has them by default."""
    standard = SampledSettings.model_fields
    rate = float(standard["rate"].default if rate is None else rate)
    if not (math.isfinite(rate) and rate > 0.0):
        raise InputError(f"rate = {rate:g} Hz: must be positive")
    period = 1.0 / rate
    if delay is None:
        delay = next((law.latency for law in laws if math.isclose(law.period, period, rel_tol=1e-9)), period)
    if not (math.isfinite(delay) and delay >= 0.0):
        raise InputError(f"delay = {delay:g} s: must not be negative")
    return period, float(delay)


def _check_closed(laws: Sequence[Controller], period: float) -> None:
    if not laws:
        raise InputError("closed: the scenario's control has no digital law that could be closed")
    for law in laws:
        turns = period / law.period
        if round(turns) < 1 or abs(turns - round(turns)) > 1e-9 * turns:
            raise InputError(
                f"rate = {1.0 / period:g} Hz: the scenario's own law runs at {1.0 / law.period:g} Hz, of which it must "
                "be a whole part"
            )
