"""Closed-loop gains: the root locus of the whole machine, all four valves at once, and the limit of its gain."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.control import Controller
from ehamj.control.sensors import IDEAL
from ehamj.errors import InputError
from ehamj.linear.loop import Loop, feeds_back
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.modes import eigen_of, modes
from ehamj.linear.sampled import STABLE, spectral_radius
from ehamj.plant.mounts import MOUNTS, N_MOUNTS
from ehamj.plant.plant import Plant
from ehamj.plots.charts import Line, lines_chart, locus_chart
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Drawing, Outcome, Progress, labelled, silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

PERIOD: Final = 1e-4
"""Sampling period of the study's own law [s]."""
LEAK: Final = 0.05
"""Corner below which its integrators forget [Hz]."""
UNLIMITED: Final = 1e4
"""Factor on the gain beyond which no limit is looked for."""
OWN_LAW: Final = (
    "The scenario's control measures nothing of the machine and moves no pole; a law of the study's own is looked at."
)


@dataclass(frozen=True)
class GainStudy:
    """A machine, and factors on the gain of its law.

    The law is the scenario's where that measures the machine; otherwise (no control, or feedforward, which moves no
    pole) it is `inertial_position` at ``crossover`` Hz.

    Raises:
        InputError: if the factors or the crossover are not positive.
    """

    scenario: Scenario
    crossover: float = 40.0
    highest: float | None = None
    """Largest factor; without, a quarter beyond the limit of stability (3 where there is none)."""
    points: int = 121

    def __post_init__(self) -> None:
        for name in ("crossover", "highest"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < np.inf:
                raise InputError(f"{name} = {getattr(self, name)!r}: must be positive and finite")


def inertial_position(plant: Plant, crossover: float) -> Controller:
    """Feedback of each foot's absolute velocity, integrated, to its own valve: u = −2πf_c A_p/(K_Q K_v) ∫v dt.

    The valve integrates its command into stroke, K_Q K_v/A_p, so each loop crosses at f_c = ``crossover`` [Hz].
    """
    pole = float(np.exp(-2 * np.pi * LEAK * PERIOD))
    gains = [-2 * np.pi * crossover * a.piston_area / (a.flow_gain * a.valve_gain) for a in plant.actuators]
    identity = np.eye(N_MOUNTS)
    inputs = tuple(f"foot_velocity {mount} z" for mount in MOUNTS)
    half = 0.5 * PERIOD  # trapezoidal rule
    gain = np.diag(gains)
    return Controller(pole * identity, PERIOD * identity, 0.5 * (1.0 + pole) * gain, half * gain, inputs, PERIOD)


def scaled(loop: Loop, factor: float) -> Loop:
    """The loop with all gains of its law multiplied."""
    return replace(loop, law=loop.law.scaled(factor))


def highest_factor(model: LinearModel, loop: Loop) -> float:
    """Factor on the law's gain at which the loop becomes unstable, to 1e-3; infinite beyond `UNLIMITED`.

    Raises:
        InputError: if even a thousandth of the gain is unstable.
    """
    low = 1e-3
    if spectral_radius(model, scaled(loop, low)) > STABLE:
        raise InputError("control: the loop is unstable even with a thousandth of its gain")
    high = low
    while spectral_radius(model, scaled(loop, high)) <= STABLE:
        low, high = high, 3.0 * high
        if high > UNLIMITED:
            return float("inf")
    while high / low > 1.0 + 1e-3:
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if spectral_radius(model, scaled(loop, middle)) <= STABLE else (low, middle)
    return float(np.sqrt(low * high))


def root_locus(model: LinearModel, loop: Loop, factors: Array) -> ComplexArray:
    """Poles [1/s] of the sampled loop in continuous time, (factor, pole); NaN for delays, gone after a sample."""
    found = []
    for factor in factors:
        found.append(eigen_of(model, scaled(loop, float(factor)))[0].values)
    most = max(map(len, found))
    return np.array([np.append(poles, np.full(most - len(poles), np.nan + 0j)) for poles in found])


def loop_gains(study: GainStudy, progress: Progress = silent) -> Outcome:
    """Run the study.

    Raises:
        InputError: if the loop is unstable even with a thousandth of its gain.
    """
    progress("root locus")
    model, own = linear_model(study.scenario.plant), Loop.of(study.scenario, study.scenario.controller())
    ours = own is None or not feeds_back(own.law)
    loop = Loop(inertial_position(study.scenario.plant, study.crossover), IDEAL, 0) if own is None or ours else own
    limit = highest_factor(model, loop)
    highest = study.highest or (1.25 * limit if np.isfinite(limit) else 3.0)
    factors = np.linspace(0.0, highest, study.points)
    poles = root_locus(model, loop, factors)
    table = _modes_over_gain(model, loop, factors[:: max(1, study.points // 20)])
    span = 1.2 * max(mode.frequency for mode in modes(model) if mode.machine_moves)
    which = (
        f"feedback of each foot's absolute position, crossing {study.crossover:g} Hz" if ours else "the scenario's law"
    )
    words = f"becomes unstable at {limit:.2f} times its gain" if np.isfinite(limit) else "stays stable at any gain"
    return Outcome(
        title="Closed-loop gains",
        question=f"Where do the machine's poles go as the gain of all valves rises? Law: {which}.",
        answers=(
            f"The loop {words}"
            + (f": a gain margin of {20 * np.log10(limit):.1f} dB for all valves." if np.isfinite(limit) else "."),
            *_gain_answers(table),
        ),
        tables={"modes": table, "poles": _poles_table(factors, poles)},
        drawings={
            "locus": Drawing(
                "Poles of the closed loop as its gain rises from 0 to "
                f"{highest:.3g} times the designed one; right of the red line the machine is unstable.",
                lambda: locus_chart("Root locus", factors, poles, span),
            ),
            "damping": Drawing(
                "Damping ratio of the machine's modes over the gain.", lambda: _damping_chart(table, limit)
            ),
        },
        notes=(
            "The loop is sampled: hold, computation delay, the law's and the sensors' states are in it; the machine is "
            "linear about its equilibrium.",
            *((OWN_LAW,) if ours else ()),
        ),
        numbers={"highest_factor": limit if np.isfinite(limit) else None, "own_law": ours},
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
        for j, name in enumerate(names):
            if name in step:
                frequency[i, j], damping[i, j] = step[name].frequency, step[name].damping_ratio
    over = ("factor", "mode")
    return xr.Dataset(
        {
            "frequency": labelled(over, frequency, "Hz", "natural frequency"),
            "damping": labelled(over, damping, "1", "damping ratio"),
        },
        {
            "factor": labelled(("factor",), factors, "1", "factor on the gain"),
            "mode": labelled(("mode",), names, "", "mode"),
        },
        {"title": "modes over the gain"},
    )


def _poles_table(factors: Array, poles: ComplexArray) -> xr.Dataset:
    over = ("factor", "pole")
    return xr.Dataset(
        {
            "real": labelled(over, poles.real, "1/s", "real part"),
            "imaginary": labelled(over, poles.imag, "rad/s", "imaginary part"),
        },
        {
            "factor": labelled(("factor",), factors, "1", "factor on the gain"),
            "pole": labelled(("pole",), np.arange(1, poles.shape[1] + 1), "1", "pole"),
        },
        {"title": "poles over the gain"},
    )


def _gain_answers(table: xr.Dataset) -> list[str]:
    """What happens to each mode between no gain and the designed one."""
    passive, designed = table.isel(factor=0), table.sel(factor=1.0, method="nearest")
    moved = []
    for mode in table["mode"].values:
        before, after = (100 * float(one["damping"].sel(mode=mode)) for one in (passive, designed))
        if np.isfinite(before) and np.isfinite(after):
            moved.append(f"{mode} {before:.1f} → {after:.1f} %")
    return [f"Damping ratios, valves held → as designed: {', '.join(moved)}."]


def _damping_chart(table: xr.Dataset, limit: float) -> "Figure":
    f = table["factor"].values
    lines = [
        Line(str(mode), f, 100 * table["damping"].sel(mode=mode).values, color=k, dash=k % 2)
        for k, mode in enumerate(table["mode"].values)
    ]
    marks = {"unstable": limit} if limit <= f.max() else {}
    return lines_chart("Damping over the gain", "factor on the gain", {"damping ratio [%]": lines}, marks=marks)
