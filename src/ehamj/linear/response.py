"""Floor → machine: the full linear transmissibility, passive and under a digital controller.

The floor is a rigid slab with six degrees of freedom at the mount plane's centre, or moves each mount by itself; the
machine answers with the translation of a named point and its rotation, and with its feet.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array, ComplexArray
from ehamj.control import Controller
from ehamj.control.channels import axis_of, is_upstream
from ehamj.control.upstream import Upstream
from ehamj.errors import InputError
from ehamj.linear.loop import Loop, opened
from ehamj.linear.machine import LinearModel, grounds
from ehamj.linear.sampled import opened_at_samples
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.levers import levers
from ehamj.plant.plant import Plant

Reference = Literal["cg", "mounts"]

TURNS: Final = DOFS[3:]

ZERO: Final = 1e-6
"""Share of its row below which an element is zero by symmetry, and rounding all that it shows."""
SMALL: Final = 1e-4
"""Share of its row below which an element is judged against this share: the linear response is differentiated
numerically, to about 1e-7 of its row."""


def machine_channels(reference: Reference = "cg") -> tuple[str, ...]:
    """The machine's six degrees of freedom as channels: translation of its centre of gravity or of the mount plane's
    centre (``mounts``), and rotation.

    Raises:
        InputError: if there is no such reference.
    """
    if reference == "cg":
        return (*(f"cg_displacement {axis}" for axis in AXES), *(f"machine_displacement {turn}" for turn in TURNS))
    if reference == "mounts":
        return tuple(f"machine_displacement {dof}" for dof in DOFS)
    raise InputError(f"reference = {reference!r}: must be 'cg' or 'mounts'")


def foot_channels(mounts: Sequence[str]) -> tuple[str, ...]:
    """Displacement of the machine above each mount."""
    return tuple(f"foot_displacement {name}" for name in grounds(mounts))


def slab_pattern(plant: Plant, dofs: Sequence[str] = DOFS) -> Array:
    """Displacement of each mount and axis per degree of freedom of a rigid floor, (mount·axis, dofs) [m/m, m/rad].

    Raises:
        InputError: if a degree of freedom is none.
    """
    unknown = [dof for dof in dofs if dof not in DOFS]
    if unknown or not dofs:
        raise InputError(f"dof = {unknown[0] if unknown else ''!r}: must be one of {', '.join(DOFS)}")
    return levers(plant.positions)[:, [DOFS.index(dof) for dof in dofs]]


@dataclass(frozen=True)
class Transfer:
    """Displacement of ``outputs`` over that of ``inputs``, (f, output, input), at each frequency [Hz]."""

    frequency: Array
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    response: ComplexArray


def rigid_floor(
    model: LinearModel,
    hertz: ArrayLike,
    loop: Loop | None = None,
    outputs: Sequence[str] = machine_channels(),
    dofs: Sequence[str] = DOFS,
) -> Transfer:
    """Answer to a rigid floor, for the six degrees of freedom of floor and machine the full 6 × 6.

    Args:
        model: linearised machine.
        hertz: frequencies [Hz].
        loop: law and instruments; without, the valves are held (passive).
        outputs: channels (`ehamj.control.channels`) but for the ground's.
        dofs: of the floor.
    """
    f = np.atleast_1d(np.asarray(hertz, float))
    response = ground_response(model, f, outputs, loop) @ slab_pattern(model.plant, dofs)
    return Transfer(f, tuple(outputs), tuple(dofs), response)


def single_mounts(
    model: LinearModel, hertz: ArrayLike, loop: Loop | None = None, outputs: Sequence[str] | None = None
) -> Transfer:
    """Answer of machine and feet to the ground below each mount by itself, in each axis; arguments as `rigid_floor`."""
    f, mounts = np.atleast_1d(np.asarray(hertz, float)), model.plant.mounts
    chosen = (*machine_channels(), *foot_channels(mounts)) if outputs is None else tuple(outputs)
    return Transfer(f, chosen, grounds(mounts), ground_response(model, f, chosen, loop))


def ground_response(model: LinearModel, hertz: Array, outputs: Sequence[str], loop: Loop | None = None) -> ComplexArray:
    """Response to the displacement of the ground at each mount and axis, (f, output, mount·axis).

    Under a digital controller of one rate the sampled loop is closed exactly: what the sensors give is sampled, the
    discrete machine with sensors, delay and hold G(z) answers at the samples, z = e^{jωT}, and of the commands
    u = (1 − C G)⁻¹ C y_ground the held and delayed wave's part at ω acts on the machine,
    (1 − e^{−jωT})/(jωT) e^{−jωτ}. Its images around the multiples of the sampling rate are another frequency's. Under
    laws of several rates the images are left out of the loop too. Noise, range and resolution play no part.

    Raises:
        ValueError: if a measured channel answers a command at once.
    """
    plain = _held(model, hertz, outputs)
    if loop is None:
        return plain
    commands = commanded(model, loop, hertz, readings_of_ground(model, loop, hertz))
    return plain + model.response(hertz, outputs, model.commands) @ commands


def commanded(model: LinearModel, loop: Loop, hertz: Array, readings: ComplexArray) -> ComplexArray:
    """Commands as they act on the valves of the closed loop, over what moves the readings with the valves held.

    Args:
        model: linearised machine.
        loop: law and instruments; how the loop is closed see `ground_response`.
        hertz: frequencies [Hz], (f,).
        readings: what the instruments give, (f, reading, input).

    Returns:
        (f, valve, input).

    Raises:
        ValueError: if a measured channel answers a command at once.
    """
    law = loop.law
    if not isinstance(law, Controller):
        return opened(model, loop, hertz).commands(readings)
    omega = 2 * np.pi * hertz
    commands = opened_at_samples(model, loop, np.exp(1j * omega * law.period)).commands(readings)
    hold = np.exp(-1j * omega * (0.5 * law.period + law.latency)) * np.sinc(hertz * law.period)
    return np.asarray(hold[:, None, None] * commands)


def readings_of_ground(model: LinearModel, loop: Loop, hertz: Array) -> ComplexArray:
    """Readings over the displacement of the ground at each mount and axis, valves held, (f, reading, mount·axis)."""
    names, shares = loop.mixtures()
    read = loop.sensors.response(loop.law.inputs, hertz)
    held = _held(model, hertz, names, loop.sensors.upstream)
    return np.asarray(read[:, :, None] * (shares @ held), complex)


def _held(model: LinearModel, hertz: Array, channels: Sequence[str], upstream: Upstream | None = None) -> ComplexArray:
    """Passive response of channels to the ground's displacement; the ground's own channels among them.

    A floor given by mounts says nothing of itself upstream. It is taken to have been there what it is at the mounts on
    average, as much earlier as is believed: exactly what a wave is that comes as believed.
    """
    places = grounds(model.plant.mounts)
    found = np.zeros((hertz.size, len(channels), len(places)), complex)
    s = 2j * np.pi * hertz
    moving = [k for k, name in enumerate(channels) if not name.startswith("ground_")]
    if moving:
        both = model.response(hertz, [channels[k] for k in moving], model.ground_inputs)
        found[:, moving] = both[:, :, : len(places)] + s[:, None, None] * both[:, :, len(places) :]
    for k, name in enumerate(channels):
        if k not in moving:
            variable, mount, label = name.split(" ")
            if is_upstream(name) and upstream is None:
                raise InputError(f"output {name!r}: there is no sensor upstream; state sensors.upstream")
            order = ("displacement", "velocity", "acceleration").index(variable.removeprefix("ground_"))
            if upstream is not None and is_upstream(name):
                led = np.exp(s[:, None] * upstream.times(model.plant.positions)) / len(model.plant.mounts)
                found[:, k, AXES.index(label) :: len(AXES)] = s[:, None] ** order * led
                continue
            axis = axis_of(label, np.array(model.plant.directions[model.plant.mounts.index(mount)]))
            for share, of in zip(axis, AXES, strict=True):
                found[:, k, places.index(f"{mount} {of}")] = share * s**order
    return found


# --- reading it ------------------------------------------------------------------------------------------------------


def lever_scale(plant: Plant) -> float:
    """Length by which rotations are judged beside translations: the mounts' RMS distance from their centre [m]."""
    return float(np.sqrt((np.array(plant.positions) ** 2).sum(axis=1).mean()))


def unit(output: str, source: str) -> str:
    """Unit of a response: 'm/m', 'rad/m', 'm/rad' or 'rad/rad'."""
    above, below = ("rad" if name.split(" ")[-1] in TURNS else "m" for name in (output, source))
    return f"{above}/{below}"


def as_lengths(outputs: Sequence[str], inputs: Sequence[str], length: float) -> Array:
    """Factors that make every element motion over motion, rotations taken at ``length`` [m], (output, input)."""
    lever = [
        np.array([length if name.split(" ")[-1] in TURNS else 1.0 for name in names]) for names in (outputs, inputs)
    ]
    return np.asarray(lever[0][:, None] / lever[1][None, :])


def deviations(
    measured: ComplexArray, linear: ComplexArray, outputs: Sequence[str], inputs: Sequence[str], length: float
) -> Array:
    """|measured − linear| over |linear|, (f, output, input).

    An element that is zero by symmetry (below `ZERO` of its row at every frequency, rotations taken as motion at
    ``length`` [m]) is judged against its row's largest, and one that nearly vanishes against `SMALL` of it. A row of
    zeros, below `ZERO` of the floor's motion, has nothing to judge against: NaN.
    """
    factor = as_lengths(outputs, inputs, length)
    size = np.abs(linear) * factor
    row = size.max(axis=2, keepdims=True)
    zero = (size < ZERO * row).all(axis=0)
    scale = np.where(zero, np.broadcast_to(row, size.shape), np.maximum(size, SMALL * row))
    scale[:, (size < ZERO).all(axis=(0, 2))] = np.nan
    return np.asarray(np.abs(measured - linear) * factor / scale)
