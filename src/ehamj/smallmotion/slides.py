"""How a machine's matrices follow its slides: exact, since masses go with the square of a place, weights with it.

A slide's drive is stiff: place x, speed ẋ and acceleration ẍ are given, counted from where the slide stands at the
start. Slides do not act on each other but through the machine, so that their shares add up.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ehamj.arrays import Array
from ehamj.mujoco.slides import paced
from ehamj.plant.plant import Plant
from ehamj.smallmotion.probe import Probe


@dataclass(frozen=True)
class SlideTables:
    """Shares of slides in the machine's matrices, the slide first, per power of x, ẋ and ẍ [SI]."""

    mass: Array
    """Per x (slide, n, n)."""
    mass_2: Array
    """Per x²."""
    stiffness: Array
    """Per x (slide, n, n): the weight where the slide went."""
    stiffness_driven: Array
    """Per ẍ: the drive's reaction turns with the machine."""
    damping: Array
    """Per ẋ (slide, n, n): the rate of the mass matrix, and what turns a moving slide."""
    damping_off: Array
    """Per x·ẋ."""
    weight: Array
    """Force per x (slide, n): of the weight."""
    reaction: Array
    """Force per ẍ (slide, n): of the drive."""

    @classmethod
    def of(cls, probe: Probe) -> Self:
        """From the engine's forces with each slide at three places."""
        stiffness, damping, force, found = probe.stiffness, probe.damping, probe.force, []
        for one in np.eye(probe.slides):
            ahead, here, behind = (probe.mass(place=sign * one) for sign in (1.0, 0.0, -1.0))
            far = [damping(place=sign * one, speed=one) for sign in (1.0, -1.0)]
            found.append(
                (
                    0.5 * (ahead - behind),
                    0.5 * (ahead + behind) - here,
                    0.5 * (stiffness(place=one) - stiffness(place=-one)),
                    0.5 * (stiffness(acceleration=one) - stiffness(acceleration=-one)),
                    0.5 * (damping(speed=one) - damping(speed=-one)),
                    0.5 * (far[0] - far[1]),
                    0.5 * (force(place=one) - force(place=-one)),
                    0.5 * (force(acceleration=one) - force(acceleration=-one)),
                )
            )
        return cls(*(np.array(part) for part in zip(*found, strict=True)))

    def added(self, x: Array, v: Array, a: Array) -> tuple[Array, Array, Array, Array]:
        """What slides at places x, speeds v and accelerations a (time, slide) add to the matrices of those at rest.

        Returns:
            Mass, stiffness and damping (time, n, n), and the weight's force (time, n); the drives' reaction is apart.
        """

        def share(*terms: tuple[Array, Array]) -> Array:
            return np.asarray(sum(np.tensordot(factor, table, 1) for factor, table in terms))

        return (
            share((x, self.mass), (x**2, self.mass_2)),
            share((x, self.stiffness), (a, self.stiffness_driven)),
            share((v, self.damping), (x * v, self.damping_off)),
            share((x, self.weight)),
        )


def along_courses(plant: Plant, first: int, steps: int, timestep: float) -> Array:
    """Where slides are at the start and in the middle of some steps, and at the end of the last: coordinate from where
    they begin [m], speed [m/s] and acceleration [m/s²], (3, 2 steps + 1, slide)."""
    times = (first + 0.5 * np.arange(2 * steps + 1, dtype=np.float64)) * timestep
    found = np.stack([np.array(slide.course().sample(times)) for slide in plant.slides], axis=-1)
    found[0] -= [slide.begins for slide in plant.slides]
    return found


def driven_by(plant: Plant, first: int, steps: int, timestep: float) -> Array:
    """`paced` accelerations of the slides at start, middle and end of some steps, (step, 3, slide) [m/s²]."""
    times = np.arange(first, first + steps + 1, dtype=np.float64) * timestep
    return np.stack([paced(slide.course(), times, timestep).accelerations for slide in plant.slides], axis=-1)
