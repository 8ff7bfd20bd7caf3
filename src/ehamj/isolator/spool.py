"""The servo valve's spool: a second-order response whose drive saturates."""

import math
from typing import NamedTuple

from ehamj.compiled import kernel
from ehamj.isolator.component import Component
from ehamj.settings import Unlimited, quantity


class Spool(Component):
    """The valve from the command to its spool."""

    valve_gain: float = quantity(2.0, "mA/V", "K_v", "spool position per command", "paper", gt=0)
    valve_frequency: float = quantity(1571.0, "rad/s", "ω_v", "natural frequency of the valve at ±5 %", "paper", gt=0)
    valve_damping: float = quantity(0.65, "-", "ζ", "damping ratio of the valve", "paper", gt=0)
    spool_drive_limit: Unlimited = quantity(
        5.42e6, "mA/s²", "a_max", "limit of the solenoid's drive ω_v²(c − x) (inf: none)", "identified", gt=0
    )
    spool_stroke: float = quantity(
        20.0, "mA", "x_max", "spool position at which the edges are fully open", "assumed", gt=0
    )
    voltage_limit: float = quantity(10.0, "V", "v_max", "range of the command", "assumed", gt=0)


class Command(NamedTuple):
    """What a valve is commanded [V]."""

    voltage: float
    """That the valve limits to its range."""
    switching: float = 0.0
    """What is added after that at a stage of the integrator, for a command that switches within the step."""


@kernel
def spool_target(command: Command, own: "Spool") -> float:
    """Spool position that a command v [V] asks for, c = K_v·sat(v) [mA] (paper eq. 1, static part)."""
    return own.valve_gain * (min(max(command.voltage, -own.voltage_limit), own.voltage_limit) + command.switching)


@kernel
def spool_acceleration(error: float, rate: float, own: "Spool") -> float:
    """Acceleration of the spool [mA/s²]: ẍ = clip(ω_v²(c − x), ±a_max) − 2ζω_v ẋ.

    ``error`` c − x [mA], ``rate`` ẋ [mA/s]. The solenoid's force saturates, the damping does not. Unclipped it is the
    paper's eq. 1.
    """
    drive = own.valve_frequency * own.valve_frequency * error
    drive = min(max(drive, -own.spool_drive_limit), own.spool_drive_limit)
    return drive - 2.0 * own.valve_damping * own.valve_frequency * rate


@kernel
def full_stroke(position: float, stroke: float) -> float:
    """An opening [mA] no further than ±``stroke``."""
    return min(max(position, -stroke), stroke)


@kernel
def limits_reached(command: float, position: float, own: "Spool") -> tuple[bool, bool, bool]:
    """Whether command [V], spool [mA] and the spool's drive are at their limits."""
    drive = own.valve_frequency**2 * (spool_target(Command(command, 0.0), own) - position)
    return (
        math.fabs(command) >= own.voltage_limit,
        math.fabs(position) >= own.spool_stroke,
        math.fabs(drive) >= own.spool_drive_limit,
    )
