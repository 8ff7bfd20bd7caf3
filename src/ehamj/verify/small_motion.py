"""Cases of the small-motion engine: those of the whole machine once more, and both engines side by side."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario
from ehamj.verify.case import CASES, Finding, Subject, case

AGAIN: Final = (
    "oil is conserved",
    "energy is conserved",
    "whole machine, smooth options",
    "whole machine, a stuck spool",
    "whole machine, six skew isolators",
    "benchmark case",
    "order of the benchmark",
)
"""Cases that hold for the small-motion engine as they do for the other one, to the same tolerance."""

FLOORS: Final[Mapping[str, float]] = {
    "displacement": 1e-6,
    "velocity": 1e-4,
    "acceleration": 1e-2,
    "stroke": 1e-6,
    "spool": 0.1,
    "valve_command": 0.1,
    "actuator_force": 10.0,
    "chamber_pressure": 1e3,
    "supply_pressure": 1e3,
    "chamber_flow": 1e-8,
    "chamber_void": 1e-9,
}
"""What a channel's difference is held against at least, by the last word of its name or by all of it: 1 µm, 0.1 mm/s,
10 mm/s² (the same of radians), and 1e-3 to 1e-2 of a valve's or chamber's range."""


def on_small_motions(scenario: Scenario) -> Scenario:
    """The same on the small-motion engine."""
    return scenario.model_copy(update={"engine": "small-motion"})


def apart(one: xr.Dataset, other: xr.Dataset) -> dict[str, tuple[float, float]]:
    """How far two runs are apart in each variable that has a floor.

    The largest difference of a channel over its own peak, and over the peak of all channels of its variable, or over
    the floor where that is larger.
    """
    found = {}
    for name in map(str, one.data_vars):
        floor = FLOORS.get(name, FLOORS.get(name.rpartition("_")[2]))
        if floor is None or not one[name].size:
            continue
        values: Array = one[name].values
        peak, difference = np.abs(values).max(axis=0), np.abs(other[name].values - values).max(axis=0)
        most = float(np.max(difference)) / max(float(np.max(peak)), floor)
        found[name] = float(np.max(difference / np.maximum(peak, floor))), most
    return found


def _again(name: str) -> None:
    """Register a case once more, for the small-motion engine."""
    known = CASES[name]

    def measure(subject: Subject) -> Finding:
        return known.measure(replace(subject, simulate=lambda scenario: subject.simulate(on_small_motions(scenario))))

    own = f"{name}, small motions"
    CASES.add(own, replace(known, name=own, compares=f"{known.compares}, small-motion engine", measure=measure))


for _name in AGAIN:
    _again(_name)


def _both(subject: Subject, name: str, **values: object) -> Finding:
    """A shipped scenario on both engines: the worst channel, and which."""
    scenario = load_scenario(name).varied({"plates": "tied", "compare": [], "control.bits": 52, **values})
    one, other = (subject.simulate(each).dataset for each in (scenario, on_small_motions(scenario)))
    found = apart(one, other)
    worst = max(found, key=lambda name: found[name][0])
    turn = np.abs(one["machine_displacement"].values[:, 3:]).max()
    return Finding(found[worst][0], f"worst in {worst}; turns to {1e6 * turn:.2f} µrad")


@case(
    "both engines under control",
    "1 s of vc-c-floor with its law, instruments and noise on both engines, plates tied, 52 bits",
    "ehamj on MuJoCo, of which the small-motion engine keeps the first order",
    "of each channel's peak",
    1e-6,
    "turns of 2e-8, and what is left out is of second order",
)
def engines_under_control(subject: Subject) -> Finding:
    """The law, instruments and noise on both engines."""
    return _both(subject, "vc-c-floor", duration=1.0)


@case(
    "both engines with a slide",
    "1 s of moving-slide, whose slide starts at 0.2 s, on both engines, plates tied, 52 bits",
    "as above",
    "of each channel's peak",
    1e-5,
    "turns of 1e-6 times what drives the slide",
)
def engines_with_a_slide(subject: Subject) -> Finding:
    """A slide of a tonne on both engines."""
    return _both(subject, "moving-slide", duration=1.0, **{"slide.table.profile.moves.0.time": 0.2})
