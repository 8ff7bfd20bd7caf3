"""What the linear machine with its faults does on the floor that a run had, beside what the run did.

Floor and machine are cut into segments, each with a Hann window (Welch's method); the linear response takes every line
of the floor at each mount and axis to the CG's heave, and both are summed over the lines of third-octave bands.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
import xarray as xr
from scipy.signal import detrend

from ehamj.arrays import Array
from ehamj.columns import of_each
from ehamj.control import Controller, ControllerBank, LinearController
from ehamj.errors import InputError
from ehamj.faults import FaultSettings
from ehamj.judge.faults import Expectation
from ehamj.judge.levels import BANDS, ByBand
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.machine import LinearModel
from ehamj.linear.response import ground_response
from ehamj.linear.unstable import unstable_pole
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant
from ehamj.scenario.model import Scenario

SEGMENT: Final = 2.0
"""Longest segment [s]."""
LEAST_LINES: Final = 3
"""Lines that a band must have."""
FAINT: Final = 1e-2
"""Level of the floor in a band, over its strongest, below which nothing is said: there it shows leakage."""


def law_after(law: LinearController, faults: Sequence[FaultSettings]) -> LinearController:
    """The law with the gains of the readings that have failed; what stays constant moves nothing."""
    gains = dict.fromkeys(law.inputs, 1.0)
    for fault in faults:
        for name in fault.struck(law.inputs):
            gains[name] *= fault.reading(0.0)[0]

    def scaled(part: Controller) -> Controller:
        own = np.array([gains[name] for name in part.inputs])
        return replace(part, B=part.B * own, D=part.D * own)

    if isinstance(law, ControllerBank):
        return replace(law, parts=tuple(map(scaled, law.parts)))
    return scaled(law)


def expectation(
    scenario: Scenario, plant: Plant, law: LinearController | None, faults: Sequence[FaultSettings], part: xr.Dataset,
    usable: tuple[float, float],
) -> Expectation:  # fmt: skip
    """The linear machine on the floor of a part of a run.

    Args:
        scenario: what ran.
        plant: the machine with its faults, settled.
        law: that ran; None without.
        faults: that struck so far, for what the law reads.
        part: rows of the run, after the faults have settled.
        usable: from where to where the ground is known [Hz].

    Raises:
        InputError: if the machine has no operating point under the commands of that part.
    """
    model = linear_under(plant, law, np.clip(of_each(part["valve_command"].variable, np.mean), *_range(plant)))
    loop = Loop.of(scenario, None if law is None else law_after(law, faults))
    pole = None if loop is None else unstable_pole(model, loop)
    if pole is not None:
        return Expectation(stable=False, pole=str(pole), attenuation_db={}, run_db={})
    return Expectation(stable=True, **_attenuations(model, loop, part, scenario.record_rate, usable))


def _range(plant: Plant) -> tuple[Array, Array]:
    limit = np.array([actuator.voltage_limit for actuator in plant.actuators])
    return -limit, limit


def _attenuations(
    model: LinearModel, loop: Loop | None, part: xr.Dataset, rate: float, usable: tuple[float, float]
) -> dict[str, ByBand]:
    """Vertical attenuation of the linear machine and of the run."""
    rows = part.time.size
    size = min(round(SEGMENT * rate), rows // 2)
    starts = range(0, rows - size + 1, max(size // 2, 1))
    window = np.hanning(size + 1)[:-1, None]
    ground, heave = part["ground_velocity"].variable, part["cg_velocity"].variable[:, [AXES.index("z")]]
    frequency = np.asarray(np.fft.rfftfreq(size, 1.0 / rate), np.float64)
    bands = [band for band in BANDS if usable[0] <= band.edges[0] and band.edges[1] <= min(usable[1], 0.4 * rate)]
    inside = (frequency >= BANDS[0].edges[0]) & (frequency <= min(BANDS[-1].edges[1], 0.4 * rate))
    through = ground_response(model, frequency[inside], ["cg_displacement z"], loop)[:, 0]
    power = np.zeros((3, int(inside.sum())))
    for start in starts:
        own = slice(start, start + size)
        parts = (detrend(signal[own].values.reshape(size, -1), axis=0) for signal in (ground, heave))
        floor, machine = (np.fft.rfft(window * part, axis=0)[inside] for part in parts)
        mean = floor.reshape(len(floor), -1, len(AXES))[:, :, AXES.index("z")].mean(axis=1)
        power += np.abs([mean, (through * floor).sum(axis=1), machine[:, 0]]) ** 2
    level = np.sqrt(power)  # their ratios count
    found: dict[str, ByBand] = {"attenuation_db": {}, "run_db": {}}
    lines = {band.name: (frequency[inside] >= band.edges[0]) & (frequency[inside] < band.edges[1]) for band in bands}
    found_levels = {name: np.sqrt((level[:, own] ** 2).sum(axis=1)) for name, own in lines.items()}
    strongest = max((own[0] for own in found_levels.values()), default=0.0)
    for name, (floor_level, *levels) in found_levels.items():
        if lines[name].sum() < LEAST_LINES or floor_level <= FAINT * strongest or min(levels) <= 0.0:
            continue
        for which, one in zip(found, levels, strict=True):
            found[which][name] = float(20.0 * np.log10(floor_level / one))
    return found


def expected(
    scenario: Scenario, plant: Plant, law: LinearController | None, faults: Sequence[FaultSettings], part: xr.Dataset,
    usable: tuple[float, float],
) -> tuple[Expectation | None, str]:  # fmt: skip
    """As `expectation`, and in words why there is none."""
    try:
        return expectation(scenario, plant, law, faults, part, usable), ""
    except InputError as error:
        return None, f"no linear expectation: {error}"
