"""Faults of a run: when each strikes, what it changes in the model that runs and in what the law reads.

A fault acts on what a run alone has: the records of the isolators and of the supply in its own model, and the gains of
its own sensors. Until it strikes nothing is touched, and the run is bit for bit the one without it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.control.loop import DigitalLoop
from ehamj.faults import FaultSettings, in_order
from ehamj.faults.sensor import SensorFault
from ehamj.memory import activations, rows
from ehamj.plant.plant import Plant
from ehamj.scenario.model import Scenario


@dataclass(frozen=True)
class Struck:
    """A fault that struck."""

    fault: FaultSettings
    time: float
    """Of the step at which it did [s]."""
    plant: Plant
    """The machine from then on."""
    spools: Array
    """Where the spools stood then (mount,) [mA]."""
    channels: tuple[str, ...]
    """Those of the law's readings that it changes."""


def step_of(fault: FaultSettings, timestep: float) -> int:
    """Number of the first step that is not before a fault."""
    return math.ceil(fault.time / timestep - 1e-6)


def plants(scenario: Scenario) -> tuple[Plant, ...]:
    """The machine as it is, and what each fault makes of it and lets it come to; valves that stick are centred."""
    plant, still = scenario.plant, np.zeros(len(scenario.plant.mounts))
    found = [plant]
    for fault in in_order(scenario.fault):
        comes_to = fault.settled(plant, still, scenario.duration - fault.time)
        plant = fault.after(plant, still)
        found += [one for one in (plant, comes_to) if one not in found]
    return tuple(found)


def strike(
    model: mujoco.MjModel, data: mujoco.MjData, loop: DigitalLoop, channels: Sequence[str], plant: Plant,
    fault: FaultSettings, time: float,
) -> Struck:  # fmt: skip
    """Let a fault strike a model in its present state.

    Args:
        model: whose records become those of the machine that has the fault.
        data: its state.
        loop: whose readings fail.
        channels: that the law reads.
        plant: the machine so far.
        fault: what strikes.
        time: of the present step [s].
    """
    states = activations(model, data.act).isolators
    spools = states["spool"].copy()
    after = fault.after(plant, spools)
    model.actuator_user[:] = [row.values for row in rows(after)]
    fault.strike(dict(zip(plant.mounts, states, strict=True)))
    struck = fault.struck(channels)
    for name in struck:
        _change_reading(loop, list(channels).index(name), fault)
    return Struck(fault, time, after, spools, struck)


def _change_reading(loop: DigitalLoop, channel: int, fault: FaultSettings) -> None:
    gain, offset = fault.reading(float(loop.readings.readings[channel]))
    gains, offsets = loop.sensing.gains, loop.sensing.offsets
    gains[channel] *= gain
    offsets[channel] = gain * offsets[channel] + offset


def unread(faults: Sequence[FaultSettings], channels: Sequence[str]) -> list[str]:
    """In words: sensors that fail and that nothing reads."""
    read = ", ".join(dict.fromkeys(name.partition(" ")[0] for name in channels))
    return [
        f"fault at {fault.time:g} s at {fault.where}, {fault.what}: the law does not read sensor = {fault.sensor!r} "
        f"there, so nothing changes; it reads {read or 'nothing'}"
        for fault in faults
        if isinstance(fault, SensorFault) and not fault.struck(channels)
    ]


def shorter_step(timestep: float, usual: float) -> str:
    """In words: a step [s] that faults made shorter than it would be without them."""
    return (
        f"the step is {1e6 * timestep:.4g} µs, for what is fastest in the machine with its faults; without them it "
        f"would be {1e6 * usual:.4g} µs, and the run until the first of them the same to within the step's error only"
    )
