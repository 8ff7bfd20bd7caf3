"""Feedforward of ground velocity at each mount, by inversion of actuator and valve.

With the machine at rest the oil moves each plate by −x_g when

    x_v = −(A_p/K_Q)·[(1 + K_L/K_h + K_C C/A_p²) + (K_C K_L/A_p²)/s]·ẋ_g

(eqs. 3, 6, 7 with M s² x_p = 0; the term C s/K_h, 4e-4 at 100 Hz, is left out). The valve's inverse
(1 + 2ζs/ω_v + s²/ω_v²)/K_v is rolled off by a third-order Butterworth, the delay of roll-off, computation and hold
is led by 1 + T s, and the integrator leaks, 1/(s + ω_l), so that its gain is bounded. The leak alone costs
ω_l c/(ω |jω + c|), c = (K_C K_L/A_p²)/(1 + K_L/K_h): −50 dB at 5 Hz for 0.02 Hz.
"""

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy import signal

from ehamj.commands import Passive
from ehamj.controllers.law import Controller, stack
from ehamj.layout import MOUNTS
from ehamj.parameters import Actuator, Plant, Settings
from ehamj.signals import Signal

Array = NDArray[np.float64]
Positive = Annotated[float, Field(gt=0)]


class DigitalSettings(Settings):
    """What every digital controller has; it alone commands the valves."""

    rate: Positive = Field(10_000.0, description="sampling rate [Hz]")
    delay: Annotated[float, Field(ge=0)] | None = Field(None, description="computation delay [s]; without: one sample")
    bits: Annotated[int, Field(ge=2, le=52)] = Field(16, description="resolution of the command converter [bit]")

    def commands(self) -> tuple[Signal, ...]:
        """No open-loop command beside the controller's."""
        return Passive().commands()


class FeedforwardSettings(DigitalSettings):
    """Per-actuator ground-velocity feedforward with valve inversion."""

    kind: Literal["feedforward"]
    gain: float = Field(1.0, description="factor on the exact inverse")
    rolloff: Positive = Field(3000.0, description="corner of the third-order roll-off [Hz]")
    leak: Positive = Field(0.02, description="corner below which the integrator's gain is bounded [Hz]")
    lead: Annotated[float, Field(ge=0)] | Literal["auto"] = Field(
        "auto", description="time that the command is led by, 1 + lead·s [s]; auto: all delay of sampling and roll-off"
    )

    @property
    def lag(self) -> float:
        """Delay at low frequency of computation, hold (half a sample) and roll-off together [s]."""
        period = 1.0 / self.rate
        return (period if self.delay is None else self.delay) + 0.5 * period + 1.0 / (np.pi * self.rolloff)

    def controller(self, plant: Plant) -> Controller:
        """The law for a plant."""
        return stack([_one_mount(self, actuator, name) for name, actuator in zip(MOUNTS, plant.actuators, strict=True)])


def _one_mount(settings: FeedforwardSettings, actuator: Actuator, mount: str) -> Controller:
    lead = settings.lag if settings.lead == "auto" else settings.lead
    discrete = signal.bilinear_zpk(*inverse(actuator, settings.rolloff, settings.leak, lead), settings.rate)
    A, B, c, d = signal.tf2ss(*signal.zpk2tf(*discrete))
    C, D = np.zeros((len(MOUNTS), A.shape[0])), np.zeros((len(MOUNTS), 1))
    C[MOUNTS.index(mount)], D[MOUNTS.index(mount)] = settings.gain * c[0], settings.gain * d[0]
    A, B, C = _balanced(A, B, C)
    name = (f"ground_velocity {mount} z",)
    return Controller(A, B, C, D, name, 1.0 / settings.rate, settings.delay, actuator.voltage_limit, settings.bits)


def inverse(actuator: Actuator, rolloff: float, leak: float, lead: float) -> tuple[Array, Array, float]:
    """Zeros, poles [rad/s] and gain of command [V] over ground velocity [m/s].

    ``rolloff`` [Hz] is the corner of a third-order Butterworth low-pass, ``leak`` [Hz] that of the integrator,
    ``lead`` [s] the time of the lead.
    """
    a = actuator
    speed = 1.0 + a.membrane_stiffness / a.hydraulic_stiffness + a.flow_pressure * a.membrane_damping / a.piston_area**2
    creep = a.flow_pressure * a.membrane_stiffness / a.piston_area**2
    low, omega = 2 * np.pi * leak, a.valve_frequency
    valve = np.roots([1.0, 2.0 * a.valve_damping * omega, omega**2])
    _, poles, gain = signal.butter(3, 2 * np.pi * rolloff, analog=True, output="zpk")
    zeros = np.concatenate([valve, [-creep / speed - low], [-1.0 / lead] if lead > 0 else []])
    gain *= -a.piston_area / (a.flow_gain * a.valve_gain) * speed / omega**2 * (lead if lead > 0 else 1.0)
    return zeros, np.append(poles, -low), float(gain)


def _balanced(A: Array, B: Array, C: Array) -> tuple[Array, Array, Array]:
    """The same law with states of like size: companion forms of slow and fast poles together lose digits."""
    values, vectors = np.linalg.eig(A)
    order = np.argsort(np.abs(values))
    values, vectors = values[order], vectors[:, order]
    basis, k = [], 0
    while k < values.size:
        if abs(values[k].imag) > 1e-12:
            basis += [vectors[:, k].real, vectors[:, k].imag]
            k += 2
        else:
            basis.append(vectors[:, k].real)
            k += 1
    T = np.array(basis).T
    return np.linalg.solve(T, A @ T), np.linalg.solve(T, B), C @ T
