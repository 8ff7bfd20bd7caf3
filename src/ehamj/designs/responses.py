"""What a floor makes of the passive machine, for many designs at once: compiled, each design by itself.

As `ehamj.designs.floor.floor_response`, many times faster.
"""

from functools import cache
from typing import Any

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.designs.stack import Stack
from ehamj.plant.axes import AXES


def slab_in_frames(frames: Array) -> ComplexArray:
    """A slab that moves by 1 m along x, y or z, in each mount's frame, (1, mount, 3, 3)."""
    return np.asarray(frames, complex)[None].copy()


def passive_answers(stack: Stack, hertz: Array) -> ComplexArray:
    """Displacement of the centre of gravity along x, y and z over that of a slab along the same axis.

    Args:
        stack: designs.
        hertz: positive frequencies of each design, or of the first ones alone, (design, f) [Hz].

    Returns:
        (design, f, 3) [m/m]; NaN where a design has no rest in its cylinders.
    """
    designs, n, mounts = len(hertz), stack.mass.shape[1], stack.oil.shape[1]
    found = np.empty((*hertz.shape, len(AXES), len(AXES)), complex)
    nothing = np.zeros((0, mounts, 0), complex)
    sensors = np.zeros((designs, 0, n)), np.zeros(0, np.int64), np.zeros((0, mounts, 3)), np.zeros(0, bool)
    seen, commands = np.zeros((1, 0, len(AXES)), complex), np.zeros((designs, 0, 0, 0), complex)
    compiled_answers()(
        arrays(stack), hertz, nothing, np.zeros(hertz.shape[1], np.int64), sensors, slab_in_frames(stack.frames),
        seen, found, commands,
    )  # fmt: skip
    found[stack.empty[:designs]] = np.nan
    return np.einsum("dfaa->dfa", found)


def arrays(stack: Stack) -> tuple[Array, ...]:
    """What the compiled closed forms take of a stack."""
    return stack.mass, stack.damping, stack.stiffness, stack.motions, stack.supports, stack.oil, stack.cg


@cache
def compiled_answers() -> Any:
    """`ehamj.designs.compiled.loops.floor_answers`, compiled or taken from where that is kept."""
    from ehamj.compiled.kept import compiled
    from ehamj.designs.compiled.loops import floor_answers

    return compiled(floor_answers)
