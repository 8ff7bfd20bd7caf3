"""What a floor does to the machine, linear, with or without a law."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.analysis.linear import LinearModel
from ehamj.analysis.transmissibility import ground_response, slab_pattern
from ehamj.controllers import LinearController
from ehamj.layout import AXES, N_MOUNTS
from ehamj.parameters import Plant

ComplexArray = NDArray[np.complex128]


def floor_response(
    model: LinearModel, law: LinearController | None, hertz: ArrayLike, outputs: Sequence[str], motion: ComplexArray
) -> ComplexArray:
    """Response of channels to a ground displacement, (frequency, output); without a law, with held valves.

    Args:
        model: linearised machine.
        law: closes the sampled loop.
        hertz: frequencies (n,) [Hz].
        outputs: channels (`ehamj.channels`).
        motion: complex amplitude of the ground, (mount, axis) or (frequency, mount, axis) [m].
    """
    f = np.atleast_1d(np.asarray(hertz, float))
    ground = np.broadcast_to(motion, (f.size, N_MOUNTS, len(AXES))).reshape(f.size, -1)
    return np.asarray(np.einsum("fog,fg->fo", ground_response(model, f, outputs, law), ground))


def rigid_floor(plant: Plant, dof: str) -> ComplexArray:
    """Displacement of each mount's ground, (mount, axis), for one unit of a rigid slab's degree of freedom [m, rad].

    Raises:
        InputError: if there is no such degree of freedom.
    """
    return slab_pattern(plant, (dof,))[:, 0].reshape(N_MOUNTS, len(AXES)).astype(complex)
