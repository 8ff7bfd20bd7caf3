"""What acts on the reference model: ground and commands as quintics, and the sampled law."""

import math
from collections.abc import Callable
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.control import Controller
from ehamj.control.channels import is_upstream
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant
from ehamj.scenario.model import Scenario

GRID: Final = 5e-5
"""Spacing at which ground and commands are taken from the scenario [s]; between, quintics with both derivatives."""


def quintics_of(scenario: Scenario) -> tuple[Array, Array]:
    """Ground (three per mount) and commands (one per mount) as quintics on the grid, (pieces, 4·mounts, 6); and the
    times at which one jumps."""
    n = math.ceil(scenario.duration / GRID - 1e-9) + 1
    times: Array = np.arange(n + 1, dtype=np.float64) * GRID
    mounts = len(scenario.plant.mounts)
    left, right = np.zeros((2, n + 1, 4 * mounts, 3))
    for order, part in enumerate(scenario.motion().sample(times).below(mounts)):
        left[:, : 3 * mounts, order] = right[:, : 3 * mounts, order] = part.reshape(len(times), -1)
    for i, signal in enumerate(scenario.commands()):
        left[:, 3 * mounts + i] = np.array(signal.sample(times, left=True)).T
        right[:, 3 * mounts + i] = np.array(signal.sample(times)).T
    steps = GRID ** np.arange(3)
    (p0, v0, a0), (p1, v1, a1) = ((part * steps).transpose(2, 0, 1) for part in (right[:-1], left[1:]))
    rise, slope, bend = p1 - p0 - v0 - a0 / 2, v1 - v0 - a0, a1 - a0
    quintics = [
        p0, v0, a0 / 2, 10 * rise - 4 * slope + bend / 2, -15 * rise + 7 * slope - bend, 6 * rise - 3 * slope + bend / 2
    ]  # fmt: skip
    jumps = times[np.abs(left - right)[:, :, 0].max(axis=1) > 0.0]
    return np.ascontiguousarray(np.stack(quintics, axis=2)), jumps


class SampledLaw:
    """The sampled law: what its commands are at a time, [V]; measured are velocities of the ground.

    Raises:
        ValueError: if it reads anything else.
    """

    def __init__(self, controller: Controller, plant: Plant) -> None:
        self.controller = controller
        self.state = np.zeros(controller.A.shape[0])
        self.waiting: list[tuple[float, Array]] = []
        self.command, self.count = np.zeros(len(plant.mounts)), 0
        self.seen: list[tuple[int, Array]] = []
        for name in controller.inputs:
            what, mount, axis = name.split(" ")
            if what != "ground_velocity" or is_upstream(name):
                raise ValueError(f"the reference model measures ground_velocity at mounts, not {name!r}")
            at = plant.mounts.index(mount)
            self.seen.append((at, np.array(plant.directions[at]) if axis == "along" else np.eye(3)[AXES.index(axis)]))

    def at(self, t: float, ground_velocity: Callable[[float], Array]) -> Array:
        """Take a sample if its time has come, and release what has waited long enough."""
        law = self.controller
        if t > self.count * law.period - 1e-10:
            velocity = ground_velocity(t)
            u = np.array([way @ velocity[at] for at, way in self.seen])
            wanted = law.C @ self.state + law.D @ u
            volts = np.clip(_share(law, t) * wanted, -law.voltage_limit, law.voltage_limit)
            missing = volts - wanted
            if law.bits is not None:
                lsb = 2.0 * law.voltage_limit / 2**law.bits
                volts = lsb * np.floor(volts / lsb + 0.5)
            self.state = law.A @ self.state + law.B @ u
            if law.anti_windup is not None:
                self.state = self.state + law.anti_windup @ missing
            self.waiting.append((t + law.latency, volts))
            self.count += 1
        while self.waiting and self.waiting[0][0] < t + 1e-10:
            self.command = self.waiting.pop(0)[1]
        return self.command


def _share(law: Controller, t: float) -> float:
    """Share of the law's output that reaches the valves: none before switch-on, then along 3s² − 2s³."""
    if t < law.switch_on - 1e-10:
        return 0.0
    s = min((t - law.switch_on) / law.fade, 1.0) if law.fade > 0.0 else 1.0
    return 3.0 * s**2 - 2.0 * s**3
