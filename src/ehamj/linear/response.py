"""Floor → machine: the full linear transmissibility, passive and under a digital controller.

The floor is a rigid slab with six degrees of freedom at the mount plane's centre, or moves each mount by itself; the
machine answers with the translation of a named point and its rotation, and with its feet.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.control import Controller, LinearController
from ehamj.control.law import OUTPUTS as COMMANDS
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.errors import InputError
from ehamj.estimate.third_octave import Band
from ehamj.linear.machine import GROUND_INPUTS, LinearModel
from ehamj.linear.sampled import measured_machine, sampled_machine
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.levers import levers
from ehamj.plant.mounts import MOUNTS, N_MOUNTS
from ehamj.plant.plant import Plant

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Reference = Literal["cg", "mounts"]

TURNS: Final = ("rx", "ry", "rz")
GROUNDS: Final = tuple(f"{mount} {axis}" for mount in MOUNTS for axis in AXES)
"""The ground's own degrees of freedom: each mount and axis."""

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


def foot_channels() -> tuple[str, ...]:
    """Displacement of the machine above each mount."""
    return tuple(f"foot_displacement {name}" for name in GROUNDS)


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
    controller: LinearController | None = None,
    outputs: Sequence[str] = machine_channels(),
    dofs: Sequence[str] = DOFS,
    sensors: Sensors = IDEAL,
    seed: int = 0,
) -> Transfer:
    """Answer to a rigid floor, for the six degrees of freedom of floor and machine the full 6 × 6.

    Args:
        model: linearised machine.
        hertz: frequencies [Hz].
        controller: closes the loop; without, the valves are held (passive).
        outputs: channels (`ehamj.control.channels`) but for the ground's.
        dofs: of the floor.
        sensors: instruments of the controller.
        seed: of the scenario, which draws the directions of misalignments.
    """
    f = np.atleast_1d(np.asarray(hertz, float))
    response = ground_response(model, f, outputs, controller, sensors, seed) @ slab_pattern(model.plant, dofs)
    return Transfer(f, tuple(outputs), tuple(dofs), response)


def single_mounts(
    model: LinearModel,
    hertz: ArrayLike,
    controller: LinearController | None = None,
    outputs: Sequence[str] = (*machine_channels(), *foot_channels()),
    sensors: Sensors = IDEAL,
    seed: int = 0,
) -> Transfer:
    """Answer to the ground below each mount by itself, in each axis (`GROUNDS`); arguments as `rigid_floor`."""
    f = np.atleast_1d(np.asarray(hertz, float))
    return Transfer(f, tuple(outputs), GROUNDS, ground_response(model, f, outputs, controller, sensors, seed))


def ground_response(
    model: LinearModel,
    hertz: Array,
    outputs: Sequence[str],
    controller: LinearController | None = None,
    sensors: Sensors = IDEAL,
    seed: int = 0,
) -> ComplexArray:
    """Response to the displacement of the ground at each mount and axis, (f, output, mount·axis).

    Under a digital controller of one rate the sampled loop is closed exactly: what the sensors give is sampled, the
    discrete machine with sensors, delay and hold G(z) answers at the samples, z = e^{jωT}, and of the commands
    u = (1 − C G)⁻¹ C y_ground the held and delayed wave's part at ω acts on the machine,
    (1 − e^{−jωT})/(jωT) e^{−jωτ}. Its images around the multiples of the sampling rate are another frequency's. Under
    laws of several rates the images are left out of the loop too. Noise, range and resolution play no part.

    Raises:
        ValueError: if a measured channel answers a command at once.
    """
    plain = _from_ground(model, hertz, outputs)
    if controller is None:
        return plain
    names, shares = sensors.mixtures(controller.inputs, seed)
    seen = sensors.response(controller.inputs, hertz)[:, :, None] * (shares @ _from_ground(model, hertz, names))
    driven = model.response(hertz, outputs, COMMANDS)
    held = controller.response(hertz)
    if not isinstance(controller, Controller):
        machine = measured_machine(model, controller.inputs, sensors, seed)
        answer = _over(np.asarray(2j * np.pi * hertz, complex), machine.A, machine.B, machine.C)
        return plain + driven @ np.linalg.solve(np.eye(N_MOUNTS) - held @ answer, held @ seen)
    period, omega = controller.period, 2 * np.pi * hertz
    z = np.exp(1j * omega * period)
    law = _over(z, controller.A, controller.B, controller.C) + controller.D
    commands = np.linalg.solve(np.eye(N_MOUNTS) - law @ sampled_plant(model, controller, z, sensors, seed), law @ seen)
    hold = np.exp(-1j * omega * (0.5 * period + controller.latency)) * np.sinc(hertz * period)
    return plain + driven @ (hold[:, None, None] * commands)


def sampled_plant(
    model: LinearModel, controller: Controller, z: ComplexArray, sensors: Sensors = IDEAL, seed: int = 0
) -> ComplexArray:
    """The readings over the commands from sample to sample, delay and hold included, (f, input, valve)."""
    machine = sampled_machine(model, controller, sensors, seed)
    return _over(z, machine.A, machine.B, machine.C)


def _over(s: ComplexArray, A: Array, B: Array, C: Array) -> ComplexArray:
    """C (s − A)⁻¹ B at each s, (s, output, input)."""
    if not A.size:
        return np.zeros((s.size, C.shape[0], B.shape[1]), complex)
    return C @ np.linalg.solve(s[:, None, None] * np.eye(A.shape[0]) - A, np.broadcast_to(B, (s.size, *B.shape)))


def _from_ground(model: LinearModel, hertz: Array, channels: Sequence[str]) -> ComplexArray:
    """Passive response of channels to the ground's displacement; the ground's own channels among them."""
    found = np.zeros((hertz.size, len(channels), len(GROUNDS)), complex)
    s = 2j * np.pi * hertz
    own = [k for k, name in enumerate(channels) if not name.startswith("ground_")]
    if own:
        both = model.response(hertz, [channels[k] for k in own], GROUND_INPUTS)
        found[:, own] = both[:, :, : len(GROUNDS)] + s[:, None, None] * both[:, :, len(GROUNDS) :]
    for k, name in enumerate(channels):
        if k not in own:
            variable, _, where = name.partition(" ")
            order = ("displacement", "velocity", "acceleration").index(variable.removeprefix("ground_"))
            found[:, k, GROUNDS.index(where)] = s**order
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


def band_attenuation(frequency: Array, response: ComplexArray, chosen: Sequence[Band]) -> Array:
    """Attenuation per third-octave [dB], positive: quieter than the floor, NaN in bands without a frequency.

    Of a floor that moves with the same velocity at each of the given frequencies: −10 lg of the mean of |T|².

    Args:
        frequency: [Hz], (f,).
        response: one element over frequency, (f,); NaN is left out.
        chosen: bands.
    """
    found = np.full(len(chosen), np.nan)
    for k, band in enumerate(chosen):
        low, high = band.edges
        inside = np.abs(response[(frequency >= low) & (frequency < high)]) ** 2
        inside = inside[np.isfinite(inside)]
        if inside.size and inside.mean() > 0:
            found[k] = -10.0 * np.log10(inside.mean())
    return found
