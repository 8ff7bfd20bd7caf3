"""Levelling: what tilts a machine for good, such as a slide that went, is taken back within a stated time.

The strokes of the active mounts are turned into the motions that they drive (`ehamj.plant.layout`), and each is
brought back to what it was when the law was switched on:

    ẋ_p = −(3/T)·(1 + c/s)/(1 + s/ω_r)²·stroke,   ω_r = 4·3/T

where (1 + c/s) inverts leakage and membrane (`ehamj.control.inverse`), so that the loop gain is 3/(T s) and e⁻³ = 5 %
are left after T, unless the leak lets the machine sink more slowly than that (c < 3/T). Without leakage (c = 0) the
cylinder is an integrator by itself. To level is to follow the floor: about f_c = 3/(2π T) that makes the floor up to
3 dB stronger, and above the roll-off it adds f_c/f·(4 f_c/f)² to what comes through: −42 dB at 2 Hz for T = 3 s,
−22 dB at 5 Hz for T = 0.5 s. Laws that hold the machine against its loads by themselves, as modal control does, need
none of it.
"""

from typing import Final, Literal

from pydantic import Field

from ehamj.control.blocks import Block, beside
from ehamj.control.channels import MountChannels
from ehamj.control.inverse import creep, volts
from ehamj.control.law import Controller
from ehamj.control.sensors import Sensors
from ehamj.control.settings import DigitalSettings
from ehamj.control.windup import AntiWindup
from ehamj.plant.plant import Plant
from ehamj.settings import Positive

GONE: Final = 3.0
"""Time constants after which 5 % are left."""

ROLLOFF: Final = 4.0
"""Corner of the roll-off over the crossing."""

LEAK: Final = 1e-3
"""Corner at which the integral ends, over the crossing: what stays of a tilt."""


class LevellingSettings(DigitalSettings):
    """Slow return of heave, roll and pitch, or of what else the mounts drive, to where they were."""

    kind: Literal["levelling"] = "levelling"
    time: Positive = Field(3.0, description="T: time after which 5 % are left of a tilt [s]")

    def loop(self, slow: float) -> Block:
        """Piston velocity over stroke of a motion whose leakage corner is ``slow`` [rad/s]."""
        crossing = GONE / self.time
        end = ROLLOFF * crossing
        zeros, poles = ([-slow], [-LEAK * crossing]) if slow > 0.0 else ([], [])
        return Block.filter(zeros, [*poles, -end, -end], -crossing * end**2)

    def controller(self, plant: Plant, sensors: Sensors) -> Controller:
        layout, names = plant.obeying.central, MountChannels.of(plant).strokes
        loops = [self.loop(creep(plant, layout.spread[:, k])).sampled(self.period) for k in range(len(layout.motions))]
        law = beside(loops).between(layout.fit, volts(plant) @ layout.spread)
        return self.digital(law, names, plant, sensors=sensors, anti_windup=AntiWindup.DUAL_LQ)
