"""Feedforward of ground velocity at each mount, by inversion of actuator, valve, instrument and delay.

With the machine at rest the oil moves each plate by −x_g when the command is

    v = −b·(1 + c/s)·ẋ_g / valve(s)

(`ehamj.control.inverse`), x_g along its mount. The valve's inverse is rolled off by a Butterworth low-pass; the delay T
of roll-off, instrument, computation and hold is led by 1 + T s + T²s²/2 (or 1 + T s). The integrator leaks,
1/(s + ω_l), so that its gain is bounded: the leak alone costs ω_l c/(ω |jω + c|), −50 dB at 5 Hz for 0.02 Hz. The
high-pass of the instrument is moved down to ``restore``.

The ground moves the machine through the lateral membranes of all mounts too, and through passive mounts: the wrench W
that it exerts so on a machine at rest is shared by the actuators, P_L = [K_L s − (Jᵀ)⁺ W]/A_p. With that the law is a
matrix from the ground's motion in all axes to the mounts; upright mounts in one plane bear none of W, and each reads
its own ground alone.

On floors for which 10 V do not suffice, ``isolate_from`` saves voltage (`ehamj.control.lowend`), the more with a
sensor upstream (`ehamj.control.preview`).
"""

from typing import Annotated, Literal

import numpy as np
import scipy
from pydantic import Field

from ehamj.arrays import Array
from ehamj.control.blocks import TWO_PI, Block, beside, joined
from ehamj.control.channels import MountChannels
from ehamj.control.instruments import Instrument
from ehamj.control.inverse import Inverse, held, instrument_poles, lag, others, restoring, shares, valve_poles
from ehamj.control.law import Controller
from ehamj.control.lowend import isolating
from ehamj.control.preview import less_followed
from ehamj.control.sensors import Sensors
from ehamj.control.settings import ISOLATE_FROM, DigitalSettings
from ehamj.control.windup import AntiWindup
from ehamj.isolator.actuator import Actuator
from ehamj.plant.axes import AXES
from ehamj.plant.levers import lever
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative, Positive


class FeedforwardSettings(DigitalSettings):
    """Ground-velocity feedforward with valve inversion, of each mount and of what all share."""

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
        inputs, own = MountChannels.of(plant).ground, plant.obeying.actuators
        sensor = sensors.of(inputs[0])
        upstream = sensors.upstream if self.isolate_from else None
        alone = self if upstream is None else self.isolating_from(0.0)
        mounts = beside([alone.block(actuator, sensor) for actuator in own])
        back = beside([held(actuator, self.recovery, self.period) for actuator in own])
        sideways, wrench = self._borne(plant)
        if sideways:
            inputs, mounts = inputs + sideways, wrench.then(mounts)
        if upstream is not None:
            ahead, kept = less_followed(inputs, plant, upstream, self.isolate_from)
            inputs, mounts = inputs + ahead, kept.then(mounts)
        mounts = mounts.sampled(self.period)
        return self.digital(joined([mounts, back]), inputs, plant, sensors=sensors, anti_windup=AntiWindup.INPUTS)

    def _borne(self, plant: Plant) -> tuple[tuple[str, ...], Block]:
        """Ground velocities that move the machine through other membranes, and the velocities along the active mounts
        that ask for the same commands, over their own and these [m/s].

        Of P_L's two paths, oil that is compressed and oil that leaks, each has a gain per velocity, K_L's as `Inverse`
        has it; of that damping which compresses the oil, C s/K_h, is left out as there.
        """
        own, low, by = plant.obeying.actuators, TWO_PI * self.leak, shares(plant)
        names = [f"ground_velocity {mount} {axis}" for mount in plant.mounts for axis in AXES]
        feet = [lever(position).T for position in plant.positions]
        stiff, damped = (
            by @ np.hstack([foot @ part for foot, part in zip(feet, parts, strict=True)])
            for parts in zip(*others(plant), strict=True)
        )
        inverses = [Inverse.of(actuator) for actuator in own]
        leaks = np.array([a.flow_pressure / (a.piston_area * a.flow_gain * a.valve_gain) for a in own])[:, None]
        oil = np.array([a.chamber_volume / (4.0 * a.bulk_modulus * a.flow_pressure) for a in own])[:, None]
        speed = np.array([inverse.volts for inverse in inverses])[:, None]
        fast, slow = leaks * (oil * stiff + damped) / speed, leaks * stiff / speed
        creep = np.array([inverse.creep for inverse in inverses])
        read = np.flatnonzero(np.abs(stiff).max(axis=0) > 1e-9 * max(a.membrane_stiffness for a in own))
        fast, slow = fast[:, read], slow[:, read]
        return tuple(names[k] for k in read), Block(
            -np.diag(low + creep), np.pad(slow - creep[:, None] * fast, ((0, 0), (len(own), 0))), np.eye(len(own)),
            np.hstack([np.eye(len(own)), fast]),
        )  # fmt: skip

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
        return scipy.signal.butter(order, TWO_PI * self.rolloff, analog=True, output="zpk")
