"""Per-actuator inertial (sky-hook) feedback: each mount holds its own foot still in space.

The decentralised sibling of `ehamj.control.architectures.modal`: the same blended measurement and the same loop at
each mount, but four loops on three motions, or eight on six. Above the blending corner the rigid machine keeps the
patterns that move nothing at zero; below it those of the strokes would build pressure, which ``balance`` leaves to the
pressures.
"""

from typing import Literal

import numpy as np
from pydantic import Field

from ehamj.control.balance import WarpBalance
from ehamj.control.blocks import Block, added, beside, joined
from ehamj.control.channels import MountChannels
from ehamj.control.inertial import Blend, MotionLoop
from ehamj.control.inverse import creeps_of, instrument_poles, lag, lost, volts
from ehamj.control.law import Controller
from ehamj.control.preview import followed
from ehamj.control.sensors import Sensors
from ehamj.control.settings import ISOLATE_FROM, DigitalSettings
from ehamj.control.windup import AntiWindup
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative


class SkyhookSettings(DigitalSettings):
    """Inertial feedback at each mount."""

    kind: Literal["skyhook"] = "skyhook"
    loop: MotionLoop = MotionLoop.stated(
        crossing=46.0, integral=14.4, lead=184.0, notch=543.0, notch_depth=0.95, notch_width=0.36, rolloff=5580.0
    )
    blend: Blend = Blend.stated()
    isolate_from: NotNegative = Field(0.0, description=ISOLATE_FROM)
    balance: WarpBalance = WarpBalance.stated()

    def controller(self, plant: Plant, sensors: Sensors) -> Controller:
        at, mounts = MountChannels.of(plant), len(plant.obeying.mounts)
        foot = sensors.of(at.feet[0])
        late = self.hold + lag(instrument_poles(foot)[1])
        upstream = sensors.upstream if self.isolate_from else None
        measured = self.blend.seeing(foot, sensors.of(at.ground[0]), self.isolate_from, upstream is not None)
        measured = measured.sampled(self.period)
        each = []
        for actuator, slow in zip(plant.obeying.actuators, creeps_of(plant), strict=True):
            owed = lost(actuator, late, self.recovery, self.period).times(-1.0)
            loop = self.loop.block(slow).sampled(self.period)
            each.append(joined([measured, owed]).then(loop))
        # The mounts' inputs come as foot, stroke, ground (what it follows) and loss of each; the law's as all feet, ….
        groups = measured.B.shape[1] + 1
        size = groups * mounts
        order = np.eye(size).reshape(groups, mounts, size).transpose(1, 0, 2).reshape(size, size)
        law = beside(each).between(order, volts(plant) @ self.balance.spared(plant))
        names = at.feet + at.strokes + at.ground
        balance = self.balance.block(plant).padded(len(names), size - len(names))
        total, names = added([law.inserted(len(names), mounts), balance]), names + at.pressures
        if upstream is not None:
            weights = np.zeros((mounts, len(plant.mounts), len(AXES)))
            weights[range(mounts), list(plant.layout.active)] = np.array(plant.obeying.directions)
            ahead, block = followed(plant, upstream, self.isolate_from, weights)
            whole = [Block.gain(np.eye(len(names))), block.sampled(self.period), Block.gain(np.eye(mounts))]
            names, total = names + ahead, beside(whole).then(total)
        return self.digital(total, names, plant, sensors=sensors, anti_windup=AntiWindup.INPUTS)
