"""Feedforward of ground velocity at each mount, by inversion of actuator, valve, instrument and delay.

With the machine at rest the oil moves each plate by −x_g when the command is

    v = −b·(1 + c/s)·ẋ_g / valve(s)

(`ehamj.control.inverse`). The valve's inverse is rolled off by a Butterworth low-pass; the delay T of roll-off,
instrument, computation and hold is led by 1 + T s + T²s²/2 (or 1 + T s). The integrator leaks, 1/(s + ω_l), so that its
gain is bounded: the leak alone costs ω_l c/(ω |jω + c|), −50 dB at 5 Hz for 0.02 Hz. The high-pass of the instrument is
moved down to ``restore``.

On floors for which 10 V do not suffice, ``isolate_from`` saves voltage (`ehamj.control.lowend`).
"""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from scipy import signal

from ehamj.arrays import Array
from ehamj.control.blocks import TWO_PI, Block, beside, joined
from ehamj.control.channels import MountChannels
from ehamj.control.instruments import Instrument
from ehamj.control.inverse import Inverse, held, instrument_poles, lag, restoring, valve_poles
from ehamj.control.law import Controller
from ehamj.control.lowend import isolating
from ehamj.control.sensors import Sensors
from ehamj.control.settings import ISOLATE_FROM, DigitalSettings
from ehamj.control.windup import AntiWindup
from ehamj.isolator.actuator import Actuator
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative, Positive


class FeedforwardSettings(DigitalSettings):
    """Per-actuator ground-velocity feedforward with valve inversion."""

    kind: Literal["feedforward"] = "feedforward"
    gain: float = Field(1.0, description="factor on the exact inverse")
    rolloff: Positive = Field(
        1000.0, description="corner of the roll-off, a compromise between bandwidth and the instrument's noise [Hz]"
    )
    leak: Positive = Field(0.02, description="corner below which the integrator's gain is bounded [Hz]")
    restore: Positive = Field(0.05, description="corner to which the instrument's high-pass is moved down [Hz]")
    isolate_from: NotNegative = Field(0.0, description=ISOLATE_FROM)
    lead: NotNegative | Literal["auto"] = Field(
        "auto",
        description="time T that the command is led by [s]; auto: all delay of instrument, sampling and roll-off",
    )
    lead_order: Annotated[int, Field(ge=1, le=2)] = Field(2, description="1: 1 + T s, 2: 1 + T s + T²s²/2")

    def lag(self, sensor: Instrument | None = None) -> float:
        """Delay at low frequency of instrument, computation, hold and roll-off together [s]."""
        return self.hold + lag(self._rolloff()[1]) + lag(instrument_poles(sensor)[1])

    def controller(self, plant: Plant, sensors: Sensors) -> Controller:
        """The law for a plant, whose ground velocities are measured by ``sensors``."""
        inputs = MountChannels.of(plant.mounts).ground
        sensor = sensors.of(inputs[0])
        mounts = beside([self.block(actuator, sensor) for actuator in plant.actuators]).sampled(self.period)
        back = beside([held(actuator, self.recovery, self.period) for actuator in plant.actuators])
        return self.digital(joined([mounts, back]), inputs, plant, anti_windup=AntiWindup.INPUTS)

    def block(self, actuator: Actuator, sensor: Instrument | None = None) -> Block:
        """Command [V] over measured ground velocity [m/s] of one mount."""
        inverse, low = Inverse.of(actuator), TWO_PI * self.leak
        lead = self.lag(sensor) if self.lead == "auto" else self.lead
        slow, moved = restoring(instrument_poles(sensor)[0], self.restore)
        _, poles, gain = self._rolloff()
        polynomial = [0.5 * lead**2, lead, 1.0][2 - self.lead_order :] if lead > 0 else [1.0]
        zeros = np.concatenate([valve_poles(actuator), [-inverse.creep - low], np.roots(polynomial), slow])
        poles = np.concatenate([poles, [-low], moved])
        total = -self.gain * inverse.volts / actuator.valve_frequency**2 * polynomial[0] * gain
        inverted = Block.filter(zeros, poles, float(total))
        return inverted.then(isolating(self.isolate_from)) if self.isolate_from else inverted

    def _rolloff(self) -> tuple[Array, Array, float]:
        """Zeros, poles [rad/s] and gain of the roll-off: as steep as valve and lead together are."""
        order = 2 + (0 if self.lead == 0.0 else self.lead_order)
        return signal.butter(order, TWO_PI * self.rolloff, analog=True, output="zpk")
