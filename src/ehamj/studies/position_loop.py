"""A position loop of all valves, and the limit of a loop's gain."""

from dataclasses import replace
from typing import Final

import numpy as np

from ehamj.control import Controller
from ehamj.control.channels import MountChannels
from ehamj.errors import InputError
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel
from ehamj.linear.sampled import STABLE, spectral_radius
from ehamj.linear.unstable import unstable_pole
from ehamj.plant.plant import Plant

PERIOD: Final = 1e-4
"""Sampling period of the study's own law [s]."""
LEAK: Final = 0.05
"""Corner below which its integrators forget [Hz]."""
UNLIMITED: Final = 1e4
"""Factor on the gain beyond which no limit is looked for."""


def inertial_position(plant: Plant, crossover: float) -> Controller:
    """Feedback of each foot's absolute velocity along its mount, integrated, to its own valve:
    u = −2πf_c A_p/(K_Q K_v) ∫v dt. Passive mounts have none.

    The valve integrates its command into stroke, K_Q K_v/A_p, so each loop crosses at f_c = ``crossover`` [Hz].

    Raises:
        InputError: if all mounts are passive.
    """
    pole = float(np.exp(-2 * np.pi * LEAK * PERIOD))
    inputs, own = MountChannels.of(plant).feet, plant.obeying.actuators
    gains = [-2 * np.pi * crossover * a.piston_area / (a.flow_gain * a.valve_gain) for a in own]
    identity = np.eye(len(gains))
    half = 0.5 * PERIOD  # trapezoidal rule
    gain = np.eye(len(plant.mounts))[:, list(plant.layout.active)] * gains
    law = (pole * identity, PERIOD * identity, 0.5 * (1.0 + pole) * gain, half * gain)
    return Controller(*law, inputs, PERIOD, mounts=plant.mounts)


def scaled(loop: Loop, factor: float) -> Loop:
    """The loop with all gains of its law multiplied."""
    return replace(loop, law=loop.law.scaled(factor))


def highest_factor(model: LinearModel, loop: Loop) -> float:
    """Factor on the law's gain at which the loop becomes unstable, to 1e-3; infinite beyond `UNLIMITED`.

    Raises:
        InputError: if even a thousandth of the gain is unstable.
    """
    low = 1e-3
    if pole := unstable_pole(model, scaled(loop, low)):
        raise InputError(f"control: the loop is unstable even with a thousandth of its gain: {pole}")
    high = low
    while spectral_radius(model, scaled(loop, high)) <= STABLE:
        low, high = high, 3.0 * high
        if high > UNLIMITED:
            return float("inf")
    while high / low > 1.0 + 1e-3:
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if spectral_radius(model, scaled(loop, middle)) <= STABLE else (low, middle)
    return float(np.sqrt(low * high))
