"""Per-actuator stroke servo: each piston follows its reference, with dynamic pressure feedback and balance.

    ẋ_p = −2π f_c·(1 + c/s)·(1 + 2π f_i/s)·notch(s)·lead(s)·(stroke − reference)

A servo does not isolate by itself: at rest in its cylinder, the plate goes with the floor. It isolates if its reference
is the ground's displacement, taken negative. Merritt (1967): a position loop is stable for 2π f_c < 2 δ_h ω_h, which
the dynamic feedback of load pressure raises; it is a high-pass, so that static stiffness is kept.

Servos that are more than the motions which they drive, as four on three, are too many. Where their sensors disagree
they press against each other through the machine; ``balance`` gives the patterns that move nothing to the pressures.
"""

from typing import Literal

import numpy as np
from pydantic import Field

from ehamj.control.balance import WarpBalance
from ehamj.control.blocks import TWO_PI, Block, added, beside, joined
from ehamj.control.channels import MountChannels
from ehamj.control.inertial import Blend, MotionLoop
from ehamj.control.inverse import creeps_of, instrument_poles, lag, lost, volts
from ehamj.control.law import Controller
from ehamj.control.sensors import Sensors
from ehamj.control.settings import DigitalSettings
from ehamj.control.windup import AntiWindup
from ehamj.isolator.actuator import Actuator
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative, Positive, Settings


class PressureFeedback(Settings):
    """Dynamic feedback of load pressure: it damps as a larger K_C would, but not statically.

    That holds below the valve's own frequency. With the default valve, 250 Hz, a gain of 3 doubles the damping of
    sway-rocking (70 Hz), and takes damping from the oil's resonances (456 to 554 Hz), where the valve turns the sign.
    """

    gain: NotNegative = Field(0.0, description="flow per load pressure, in multiples of K_C [-]; 0: none")
    corner: Positive = Field(20.0, description="corner of its high-pass [Hz]")

    def block(self, actuator: Actuator) -> Block:
        """Command [V] over load pressure [Pa]."""
        volts = self.gain * actuator.flow_pressure / (actuator.flow_gain * actuator.valve_gain)
        return Block.filter([0.0], [-TWO_PI * self.corner], -volts)


class StrokeServoSettings(DigitalSettings):
    """Stroke servo at each mount."""

    kind: Literal["stroke-servo"] = "stroke-servo"
    loop: MotionLoop = MotionLoop.stated(crossing=40.0, integral=2.0, notch_depth=1.0)
    reference: Literal["rest", "ground"] = Field(
        "rest", description="rest: the plate stays in its cylinder; ground: it moves against the measured ground"
    )
    blend: Blend = Blend.stated()
    pressure: PressureFeedback = PressureFeedback.stated()
    balance: WarpBalance = WarpBalance.stated()

    def controller(self, plant: Plant, sensors: Sensors) -> Controller:
        at, own = MountChannels.of(plant), plant.obeying.actuators
        mounts, creeps = len(own), creeps_of(plant)
        late = self.hold + lag(instrument_poles(sensors.of(at.strokes[0]))[1])
        parts, names = [Block.gain(np.eye(mounts))], at.strokes
        if self.reference == "ground":
            moved = self.blend.ground(sensors.of(at.ground[0])).sampled(self.period)
            parts.append(beside([moved] * mounts))
            names += at.ground
        parts.append(beside([lost(one, late, self.recovery, self.period).times(-1.0) for one in own]))
        loops = beside([self.loop.block(one).sampled(self.period) for one in creeps])
        # What the servos would do in the warp pattern is left to the balance.
        total = joined(parts).then(loops.between(self.balance.spared(plant), volts(plant)))
        damping = beside([self.pressure.block(actuator) for actuator in own]).sampled(self.period)
        pressures = added([damping, self.balance.block(plant)])
        law = added([total.inserted(len(names), mounts), pressures.padded(len(names), mounts)])
        return self.digital(law, names + at.pressures, plant, sensors=sensors, anti_windup=AntiWindup.INPUTS)
