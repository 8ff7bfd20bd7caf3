"""What drives a stretch of steps: ground, open-loop commands and forces, as values and slopes at each step's ends."""

import numpy as np
from numpy.typing import NDArray

from ehamj.forces import Load
from ehamj.ground import Motion
from ehamj.memory import COMMAND, inputs
from ehamj.signals import Signal

Array = NDArray[np.float64]


def sample_inputs(
    motion: Motion, commands: tuple[Signal, ...], first: int, steps: int, timestep: float
) -> tuple[Array, Array]:
    """Inputs of some steps at start and end: value, slope·timestep, second derivative, (steps, mount, input, 3) each.

    The inputs of a mount are the ground's x, y, z [m], then its command [V] (`ehamj.memory.INPUTS`).
    """
    times = np.arange(first, first + steps + 1, dtype=np.float64) * timestep
    points = inputs(steps + 1, len(commands))
    if not motion.at_rest:
        for order, part in enumerate(motion.sample(times)):
            points[:, :, :COMMAND, order] = part
    starts = points[:-1].copy()
    ends = points[1:]
    for mount, signal in enumerate(commands):
        now = signal.sample(times[:-1])
        then = signal.sample(times[1:], left=True)
        starts[:, mount, COMMAND, 0], starts[:, mount, COMMAND, 1] = now.value, now.slope
        ends[:, mount, COMMAND, 0], ends[:, mount, COMMAND, 1] = then.value, then.slope
    starts[..., 1] *= timestep
    ends[..., 1] *= timestep
    return starts, ends


def sample_load(load: Load, first: int, steps: int, timestep: float) -> tuple[Array, Array]:
    """Force on the machine in some steps: value and slope·timestep at start and end, (steps, 6, 2) each."""
    times = np.arange(first, first + steps + 1, dtype=np.float64) * timestep
    scale = np.array([1.0, timestep])
    starts, ends = load.sample(times[:-1]), load.sample(times[1:], left=True)
    return np.stack(starts, axis=2) * scale, np.stack(ends, axis=2) * scale
