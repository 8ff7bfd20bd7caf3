"""The balance of load pressures in the pattern of forces that moves nothing (+ − − + on a rectangle).

Four actuators on three motions can press against each other through the machine: where their sensors disagree, pressure
builds up in that pattern, unless a loop of its own keeps it balanced.
"""

import numpy as np
from pydantic import Field

from ehamj.arrays import Array
from ehamj.control.blocks import TWO_PI, Block
from ehamj.plant.levers import warp
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative, Settings


class WarpBalance(Settings):
    """The balance of load pressures in the warp pattern (+ − − + on a rectangle)."""

    crossing: NotNegative = Field(20.0, description="frequency below which the pressures are balanced [Hz]; 0: off")

    def block(self, plant: Plant) -> Block:
        """Commands [V] over the mounts' load pressures [Pa]: oil and valve together are an integrator, eq. 6."""
        rates = [4.0 * a.bulk_modulus / a.chamber_volume * a.flow_gain * a.valve_gain for a in plant.actuators]
        pattern = warp(plant.positions)[:, None]
        gain = Block.gain([[-TWO_PI * self.crossing / float(np.mean(rates))]])
        return gain.between(pattern.T / len(plant.mounts), pattern)

    def spared(self, plant: Plant) -> Array:
        """What is left of the mounts' commands for other loops: all but the warp pattern, (mount, mount)."""
        pattern = warp(plant.positions)
        everything = np.eye(len(plant.mounts))
        return everything - np.outer(pattern, pattern) / len(plant.mounts) if self.crossing else everything
