"""Closed-loop gains: the root locus of the whole machine, all valves at once, and the limit of its gain."""

from typing import Final

import numpy as np
import xarray as xr
from pydantic import Field
from scipy.optimize import linear_sum_assignment

from ehamj.arrays import Array, ComplexArray
from ehamj.control.sensors import IDEAL
from ehamj.labels import table
from ehamj.linear.loop import Loop, feeds_back, linear_under
from ehamj.linear.machine import LinearModel
from ehamj.linear.modes import FORGOTTEN, modes
from ehamj.linear.sampled import pattern_period, sampled_loop
from ehamj.plots import Branch, Figure, View, lines_chart, locus_chart, style, view_of
from ehamj.plots.charts import COLORS
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress, curves, silent
from ehamj.studies.position_loop import highest_factor, inertial_position, scaled
from ehamj.studies.study import Positive, study

GONE: Final = 1e-12
"""Magnitude below which a sampled eigenvalue is a delay's zero [-]."""
NEAR: Final = 30.0
"""Distance over which two poles count as one when branches are followed [1/s]."""
APART: Final = 2.5
"""Ratio of two neighbouring frequencies from which the slower modes get a view of their own [-]."""
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


def root_locus(model: LinearModel, loop: Loop, factors: Array, progress: Progress = silent) -> ComplexArray:
    """Poles [1/s] of the sampled loop in continuous time, (factor, pole), each column one branch.

    A branch goes on where the last two steps point, so that poles that pass each other keep their columns. NaN for
    delays, gone after a sample. Only eigenvalues are taken, and of laws of several rates their right vectors.
    """
    found: list[ComplexArray] = []
    for k, factor in enumerate(factors):
        progress(f"root locus, {k + 1} of {len(factors)} gains")
        closed = sampled_loop(model, scaled(loop, float(factor)))
        values, vectors = np.linalg.eig(closed.A)
        poles = closed.exponents(np.where(np.abs(values) < GONE, GONE, values), vectors)
        if found:
            ahead = 2.0 * found[-1] - found[max(0, len(found) - 2)]
            away = np.abs(ahead[:, None] - poles) / (NEAR + np.abs(found[-1])[:, None])
            poles = poles[linear_sum_assignment(away)[1]]
        found.append(poles)
    branches = np.array(found)
    gone = np.exp(branches.real * pattern_period(loop.law)) <= FORGOTTEN
    return np.where(gone, np.nan + 0j, branches)


@study(
    "gains",
    GainSettings,
    "root locus of the whole machine over the gain of its law, and its limit",
    small={"points": 3, "highest": 1.0},
)
def loop_gains(scenario: Scenario, settings: GainSettings, progress: Progress) -> Outcome:
    """A loop that is unstable even with a thousandth of its gain is refused."""
    progress("limit of stability")
    law = scenario.controller()
    model, own = linear_under(scenario.plant, law), Loop.of(scenario, law)
    ours = own is None or not feeds_back(own.law)
    loop = Loop(inertial_position(scenario.plant, settings.crossover), IDEAL, 0) if own is None or ours else own
    limit = highest_factor(model, loop)
    bounded = bool(np.isfinite(limit))
    highest = settings.highest or (1.25 * limit if bounded else 3.0)
    exact = [factor for factor in (1.0, limit) if factor < highest]
    factors = np.unique([*np.linspace(0.0, highest, settings.points), *exact])
    poles = root_locus(model, loop, factors, progress)
    modes_over = modes_over_gain(model, factors, poles)
    which = "the scenario's law"
    if ours:
        which = f"feedback of each foot's absolute position, crossing {settings.crossover:g} Hz"
    words = "stays stable at any gain."
    if bounded:
        words = f"becomes unstable at {limit:.2f} times its gain: a gain margin of {20 * np.log10(limit):.1f} dB "
        words += "for all valves."
    shown = f"Poles of the closed loop as its gain rises from 0 to {highest:.3g} times the designed one"
    views = _views(modes_over, poles)
    return Outcome(
        title="Closed-loop gains",
        question=f"Where do the machine's poles go as the gain of all valves rises? Law: {which}.",
        answers=(f"The loop {words}", _damping_answer(modes_over)),
        tables={"modes": modes_over, "poles": _poles_table(factors, poles)},
        drawings={
            "locus": Drawing(
                f"{shown}; right of the red line the machine is unstable. Coloured: the machine's own modes."
                + (" Below: the slowest of them." if len(views) > 1 else ""),
                lambda: locus_chart("Root locus", _branches(modes_over, poles), _marks(factors, limit), views),
            ),
            "damping": Drawing(
                "Damping ratio of the machine's modes over the gain, each followed from its passive pole.",
                lambda: _damping_chart(modes_over, limit),
            ),
        },
        notes=(
            "The loop is sampled: hold, computation delay, the law's and the sensors' states are in it; the machine is "
            "linear about its equilibrium.",
            *((OWN_LAW,) if ours else ()),
        ),
        numbers={"highest_factor": limit if bounded else None, "own_law": ours},
    )


def modes_over_gain(model: LinearModel, factors: Array, poles: ComplexArray) -> xr.Dataset:
    """Frequency [Hz] and damping of the machine's own modes over the factor: the branches that begin at their poles.

    A pole that has come to rest on the real axis oscillates no more: frequency |λ|/2π and damping 1.
    """
    own = [mode for mode in modes(model) if mode.machine_moves]
    begin = np.array([mode.eigenvalue for mode in own])
    branch = linear_sum_assignment(np.abs(begin[:, None] - np.nan_to_num(poles[0], nan=np.inf)))[1]
    followed = poles[:, branch]
    return table(
        "modes over the gain",
        {"factor": (factors, "1", "factor on the gain"), "mode": ([mode.name for mode in own], "", "mode")},
        frequency=(np.abs(followed) / (2.0 * np.pi), "Hz", "natural frequency"),
        damping=(-followed.real / np.abs(followed), "1", "damping ratio"),
        branch=(("mode",), branch + 1, "1", "number of its pole"),
    )


def _branches(modes_over: xr.Dataset, poles: ComplexArray) -> list[Branch]:
    """Every pole, those of the machine's modes on top and in the colours of the other chart."""
    named = dict(zip((modes_over["branch"].values - 1).tolist(), modes_over["mode"].values.tolist(), strict=True))
    others = [Branch("", poles[:, k], style.GREY) for k in range(poles.shape[1]) if k not in named]
    return [*others, *(Branch(name, poles[:, k], COLORS[n % len(COLORS)]) for n, (k, name) in enumerate(named.items()))]


def _marks(factors: Array, limit: float) -> dict[str, int]:
    """Gains at which the poles are marked."""
    marks = {"gain 0 (passive)": 0}
    if factors[-1] >= 1.0:
        marks["gain as designed"] = int(np.argmin(np.abs(factors - 1.0)))
    if limit <= factors[-1]:
        marks["limit of stability"] = int(np.argmin(np.abs(factors - limit)))
    return marks


def _views(modes_over: xr.Dataset, poles: ComplexArray) -> list[View]:
    """Around the machine's modes and what turns unstable; and, where some modes are far below others, around those."""
    upper = np.where(poles.imag >= 0.0, poles, np.nan)
    own = poles[:, modes_over["branch"].values - 1]
    crossing = upper[:, (upper.real > 0.0).any(axis=0) & (upper.real < 0.0).any(axis=0)]
    near = crossing[crossing.real > 2.0 * np.nanmin(own.real)]
    views = [view_of(np.append(own.ravel(), near))]
    frequency = np.sort(modes_over["frequency"].isel(factor=0).values)
    gaps = frequency[1:] / frequency[:-1]
    if gaps.size and gaps.max() > APART:
        slow = modes_over["frequency"].isel(factor=0).values <= frequency[int(gaps.argmax())]
        views.append(view_of(own[:, slow]))
    return views


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
        moved.append(f"{mode} {before:.1f} → {after:.1f} %")
    return f"Damping ratios, valves held → as designed: {', '.join(moved)}."


def _damping_chart(modes_over: xr.Dataset, limit: float) -> Figure:
    marks = {"as designed": 1.0} | ({"unstable": limit} if limit <= float(modes_over["factor"].max()) else {})
    panels = {"damping ratio [%]": curves(100 * modes_over["damping"], "mode", 2)}
    return lines_chart("Damping over the gain", "factor on the gain", panels, marks=marks)
