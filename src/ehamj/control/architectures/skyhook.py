"""Per-actuator inertial (sky-hook) feedback: each mount holds its own foot still in space.

The decentralised sibling of `ehamj.control.architectures.modal`: the same blended measurement and the same loop at each
mount, but four loops on three motions. Above the blending corner the rigid machine keeps their warp pattern at zero;
below it the strokes' warp would build pressure, which ``balance`` leaves to the pressures.
"""

from typing import Literal

import numpy as np
from pydantic import Field

from ehamj.control.architectures.modal import PRESSURES, WarpBalance, warp
from ehamj.control.blocks import Block, added, beside, joined
from ehamj.control.inertial import FEET, GROUND, STROKES, Blend, MotionLoop
from ehamj.control.inverse import Inverse, instrument_poles, lag, lost
from ehamj.control.law import Controller
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.control.settings import ISOLATE_FROM, DigitalSettings, NotNegative
from ehamj.plant.mounts import N_MOUNTS
from ehamj.plant.plant import Plant


class SkyhookSettings(DigitalSettings):
    """Inertial feedback at each mount."""

    kind: Literal["skyhook"] = "skyhook"
    loop: MotionLoop = MotionLoop(
        crossing=46.0, integral=14.4, lead=184.0, notch=543.0, notch_depth=0.95, notch_width=0.36, rolloff=5580.0
    )
    blend: Blend = Blend()
    isolate_from: NotNegative = Field(0.0, description=ISOLATE_FROM)
    balance: WarpBalance = WarpBalance()

    def controller(self, plant: Plant, sensors: Sensors = IDEAL) -> Controller:
        """The law for a plant that is measured by ``sensors``."""
        inverses = [Inverse.of(actuator) for actuator in plant.actuators]
        volts = np.diag([inverse.volts for inverse in inverses])
        foot = sensors.of(FEET[0])
        blend = self.blend.block(foot, sensors.of(GROUND[0]), self.isolate_from)
        late = self.hold + lag(instrument_poles(foot)[1])
        measured = blend.sampled(self.period)
        owed = [lost(actuator, late, self.recovery, self.period).times(-1.0) for actuator in plant.actuators]
        loops = [self.loop.block(inverse.creep).sampled(self.period) for inverse in inverses]
        mounts = beside([joined([measured, one]).then(loop) for one, loop in zip(owed, loops, strict=True)])
        # The mounts' inputs come as foot, stroke, ground and loss of each; the law's as all feet, all strokes, ….
        order = np.eye(4 * N_MOUNTS).reshape(4, N_MOUNTS, 4 * N_MOUNTS).transpose(1, 0, 2)
        pattern = warp(plant)[:, None]
        shared = np.eye(N_MOUNTS)
        if self.balance.crossing:
            shared = shared - pattern @ pattern.T / N_MOUNTS
        law = mounts.between(order.reshape(4 * N_MOUNTS, 4 * N_MOUNTS), volts @ shared)
        names = FEET + STROKES + GROUND
        balance: Block = self.balance.block(plant).between(pattern.T / N_MOUNTS, pattern)
        total = added([law.inserted(len(names), N_MOUNTS), balance.padded(len(names), N_MOUNTS)])
        return self.digital(total, names + PRESSURES, plant)
