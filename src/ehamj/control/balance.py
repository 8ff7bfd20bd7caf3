"""The balance of load pressures in the patterns of forces that move nothing (+ − − + of four on a rectangle).

Actuators that are more than the motions that they drive can press against each other through the machine: where their
sensors disagree, pressure builds up in such a pattern, unless a loop of its own keeps it balanced.
"""

import numpy as np
from pydantic import Field

from ehamj.arrays import Array
from ehamj.control.blocks import TWO_PI, Block
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative, Settings


class WarpBalance(Settings):
    """The balance of load pressures in every pattern that moves nothing (warp, + − − + on a rectangle)."""

    crossing: NotNegative = Field(20.0, description="frequency below which the pressures are balanced [Hz]; 0: off")

    def block(self, plant: Plant) -> Block:
        """Commands [V] over the active mounts' load pressures [Pa]: oil and valve together are an integrator, eq. 6."""
        own = plant.obeying
        rates = [4.0 * a.bulk_modulus / a.chamber_volume * a.flow_gain * a.valve_gain for a in own.actuators]
        patterns = own.layout.stresses
        gain = Block.gain(-TWO_PI * self.crossing / float(np.mean(rates)) * np.eye(patterns.shape[1]))
        return gain.between(patterns.T / len(own.mounts), patterns)

    def spared(self, plant: Plant) -> Array:
        """What is left of the active mounts' commands for other loops: all but these patterns, (active, active)."""
        patterns = plant.obeying.layout.stresses
        everything = np.eye(len(patterns))
        return everything - patterns @ patterns.T / len(patterns) if self.crossing else everything
