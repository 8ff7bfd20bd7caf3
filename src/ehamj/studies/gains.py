"""Closed-loop gains: the root locus of the whole machine, all four valves at once, and the limit of its gain."""

from typing import Final

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.arrays import Array, ComplexArray
from ehamj.control.sensors import IDEAL
from ehamj.labels import table
from ehamj.linear.loop import Loop, feeds_back
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.modes import eigen_of, modes
from ehamj.plots import Figure, lines_chart, locus_chart
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress, curves
from ehamj.studies.position_loop import highest_factor, inertial_position, scaled
from ehamj.studies.study import Positive, study

OWN_LAW: Final = (
    "The scenario's control measures nothing of the machine and moves no pole; a law of the study's own is looked at."
)


class GainSettings(Settings):
    """Factors on the gain of a machine's law.

    The law is the scenario's where that measures the machine; otherwise (no control, or feedforward, which moves no
    pole) it is `inertial_position` at ``crossover`` Hz.
    """

    crossover: float = Field(40.0, gt=0, description="crossover of the study's own law [Hz]")
    highest: Positive | None = Field(
        None,
        description="largest factor; without, a quarter beyond the limit of stability (3 where there is none)",
    )
    points: int = Field(121, ge=2, description="factors of the root locus")


def root_locus(model: LinearModel, loop: Loop, factors: Array) -> ComplexArray:
    """Poles [1/s] of the sampled loop in continuous time, (factor, pole); NaN for delays, gone after a sample."""
    found = []
    for factor in factors:
        found.append(eigen_of(model, scaled(loop, float(factor)))[0].values)
    most = max(map(len, found))
    return np.array([np.append(poles, np.full(most - len(poles), np.nan + 0j)) for poles in found])


@study(
    "gains",
    GainSettings,
    "root locus of the whole machine over the gain of its law, and its limit",
    small={"points": 3, "highest": 1.0},
)
def loop_gains(scenario: Scenario, settings: GainSettings, progress: Progress) -> Outcome:
    """A loop that is unstable even with a thousandth of its gain is refused."""
    progress("root locus")
    model, own = linear_model(scenario.plant), Loop.of(scenario, scenario.controller())
    ours = own is None or not feeds_back(own.law)
    loop = Loop(inertial_position(scenario.plant, settings.crossover), IDEAL, 0) if own is None or ours else own
    limit = highest_factor(model, loop)
    bounded = bool(np.isfinite(limit))
    highest = settings.highest or (1.25 * limit if bounded else 3.0)
    factors = np.linspace(0.0, highest, settings.points)
    poles = root_locus(model, loop, factors)
    modes_over = _modes_over_gain(model, loop, factors[:: max(1, settings.points // 20)])
    span = 1.2 * max(mode.frequency for mode in modes(model) if mode.machine_moves)
    which = "the scenario's law"
    if ours:
        which = f"feedback of each foot's absolute position, crossing {settings.crossover:g} Hz"
    words = "stays stable at any gain."
    if bounded:
        words = f"becomes unstable at {limit:.2f} times its gain: a gain margin of {20 * np.log10(limit):.1f} dB "
        words += "for all valves."
    return Outcome(
        title="Closed-loop gains",
        question=f"Where do the machine's poles go as the gain of all valves rises? Law: {which}.",
        answers=(f"The loop {words}", _damping_answer(modes_over)),
        tables={"modes": modes_over, "poles": _poles_table(factors, poles)},
        drawings={
            "locus": Drawing(
                "Poles of the closed loop as its gain rises from 0 to "
                f"{highest:.3g} times the designed one; right of the red line the machine is unstable.",
                lambda: locus_chart("Root locus", factors, poles, span),
            ),
            "damping": Drawing(
                "Damping ratio of the machine's modes over the gain.", lambda: _damping_chart(modes_over, limit)
            ),
        },
        notes=(
            "The loop is sampled: hold, computation delay, the law's and the sensors' states are in it; the machine is "
            "linear about its equilibrium.",
            *((OWN_LAW,) if ours else ()),
        ),
        numbers={"highest_factor": limit if bounded else None, "own_law": ours},
    )


def _modes_over_gain(model: LinearModel, loop: Loop, factors: Array) -> xr.Dataset:
    """Frequency [Hz] and damping of the machine's own modes over the factor, by name."""
    steps = []
    for factor in factors:
        found = modes(model, scaled(loop, float(factor)))
        steps.append({mode.name: mode for mode in found if mode.machine_moves})
    names = list(dict.fromkeys(name for step in steps for name in step))
    frequency, damping = np.full((2, len(factors), len(names)), np.nan)
    for i, step in enumerate(steps):
        for name, mode in step.items():
            frequency[i, names.index(name)], damping[i, names.index(name)] = mode.frequency, mode.damping_ratio
    return table(
        "modes over the gain",
        {"factor": (factors, "1", "factor on the gain"), "mode": (names, "", "mode")},
        frequency=(frequency, "Hz", "natural frequency"),
        damping=(damping, "1", "damping ratio"),
    )


def _poles_table(factors: Array, poles: ComplexArray) -> xr.Dataset:
    numbers = np.arange(1, poles.shape[1] + 1)
    return table(
        "poles over the gain",
        {"factor": (factors, "1", "factor on the gain"), "pole": (numbers, "1", "pole")},
        real=(poles.real, "1/s", "real part"),
        imaginary=(poles.imag, "rad/s", "imaginary part"),
    )


def _damping_answer(modes_over: xr.Dataset) -> str:
    """What happens to each mode between no gain and the designed one."""
    passive, designed = modes_over.isel(factor=0), modes_over.sel(factor=1.0, method="nearest")
    moved = []
    for mode in modes_over["mode"].values:
        before, after = (100 * float(one["damping"].sel(mode=mode)) for one in (passive, designed))
        if np.isfinite(before) and np.isfinite(after):
            moved.append(f"{mode} {before:.1f} → {after:.1f} %")
    return f"Damping ratios, valves held → as designed: {', '.join(moved)}."


def _damping_chart(modes_over: xr.Dataset, limit: float) -> Figure:
    marks = {"unstable": limit} if limit <= float(modes_over["factor"].max()) else {}
    panels = {"damping ratio [%]": curves(100 * modes_over["damping"], "mode", 2)}
    return lines_chart("Damping over the gain", "factor on the gain", panels, marks=marks)
