"""Frequency response of the machine under a digital law: hold and delay are in it, aliasing is not."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.analysis.linear import LinearModel
from ehamj.controllers import Controller
from ehamj.controllers.law import OUTPUTS as COMMANDS
from ehamj.layout import N_MOUNTS

ComplexArray = NDArray[np.complex128]


def law_response(law: Controller, hertz: ArrayLike) -> ComplexArray:
    """Commands [V] over the law's channels, (frequency, valve, channel): z = exp(jωT), delay, and zero-order hold."""
    omega = 2j * np.pi * np.atleast_1d(np.asarray(hertz, float))
    identity = np.eye(law.states)
    digital = np.array(
        [law.C @ np.linalg.solve(np.exp(s * law.period) * identity - law.A, law.B) + law.D for s in omega]
    )
    step = omega * law.period
    hold = -np.expm1(-step) / step * np.exp(-omega * law.latency)
    return np.asarray(hold[:, None, None] * digital)


def floor_response(
    model: LinearModel, law: Controller | None, hertz: ArrayLike, outputs: tuple[str, ...], motion: ComplexArray
) -> ComplexArray:
    """Response to a ground displacement with the loop closed, (frequency, output); without a law, with held valves.

    Args:
        model: linearised machine.
        law: what drives the valves.
        hertz: frequencies (n,) [Hz].
        outputs: channels (`ehamj.channels`).
        motion: complex amplitude of the ground, (mount, axis) or (frequency, mount, axis) [m].

    Raises:
        InputError: if the law reads the ground's acceleration, which the linear model has not.
    """
    f = np.atleast_1d(np.asarray(hertz, float))
    if law is None:
        return model.from_ground(f, outputs, motion)
    names = (*outputs, *law.inputs)
    free, driven = model.from_ground(f, names, motion), model.response(f, names, COMMANDS)
    count = len(outputs)
    gain = law_response(law, f)
    loop = np.eye(N_MOUNTS) - gain @ driven[:, count:]
    commands = np.linalg.solve(loop, gain @ free[:, count:, None])
    return np.asarray(free[:, :count] + (driven[:, :count] @ commands)[..., 0])


def rigid_floor(positions: ArrayLike, dof: str) -> ComplexArray:
    """Displacement of each mount's ground, (mount, axis), for one unit of a rigid slab's degree of freedom [m, rad]."""
    x, y = np.asarray(positions, float).T
    one, zero = np.ones(N_MOUNTS), np.zeros(N_MOUNTS)
    columns = {
        "x": (one, zero, zero),
        "y": (zero, one, zero),
        "z": (zero, zero, one),
        "rx": (zero, zero, y),
        "ry": (zero, zero, -x),
        "rz": (-y, x, zero),
    }
    return np.stack(columns[dof], axis=1).astype(complex)
