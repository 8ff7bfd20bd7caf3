"""What the floor makes of many passive machines: responses as stacks of arrays.

    floor_response(Designs.of(scenario, {"machine.cg.2": heights}), hertz, "ry").sel(output="ry")

In closed form, as the modes of `ehamj.designs.many`.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ehamj.arrays import Array, ComplexArray
from ehamj.designs.designs import Designs
from ehamj.designs.many import assembled, without_rest
from ehamj.errors import InputError
from ehamj.linear.elements import Elements
from ehamj.linear.oil import Oil
from ehamj.plant.axes import AXES, DOF_OF_JOINT, DOFS
from ehamj.plant.levers import lever


def floor_response(
    designs: Designs, hertz: ArrayLike, motion: ArrayLike | str, points: Mapping[str, Sequence[float]] | None = None
) -> xr.DataArray:
    """Complex motion of the passive machine over the floor's: a slab that moves by one, or any motion of the mounts.

    Args:
        designs: what is computed.
        hertz: frequencies [Hz], positive, (frequency,).
        motion: one of `DOFS`, a rigid slab that moves or turns about the mount plane's centre by 1 (m or rad); or
            complex displacements [m] of each mount and axis, (…, frequency, mount, 3) with leading axes of the designs
            where they differ, such as a wave's, exp(−j2πf r·n/c).
        points: further points of the machine by name [m from the mount plane's centre].

    Returns:
        Over (…, ``frequency``, ``output``) [m or rad]: ``cg x`` to ``cg z``, ``rx``, ``ry``, ``rz``, and ``NAME x`` …
        of each point.

    Raises:
        InputError: if ``motion`` is none of these.
    """
    frequency = np.atleast_1d(np.asarray(hertz, float))
    elements, oil, _ = assembled(designs)
    ground = _floor(elements, motion, frequency.size)
    stiff, damp = (np.concatenate(_mount_loads(elements, kind), axis=-1) for kind in ("stiffness", "damping"))
    stiffness, damping = elements.stiffness, elements.damping
    # Motions of points are those of small rotations from level, as of `ehamj.control.channels`.
    rows = [Elements.of(designs.values).cg, *(_point(elements, point) for point in (points or {}).values())]
    to_outputs = np.concatenate(rows, axis=-2)
    plate = elements.plate
    found = np.empty((*designs.shape, frequency.size, to_outputs.shape[-2]), complex)
    for k, omega in enumerate(2 * np.pi * frequency):
        s = 1j * omega
        impedance = _oil_stiffness(oil, s)
        dynamic = s**2 * elements.mass + s * damping + stiffness
        dynamic = dynamic + np.einsum("...in,...i,...im->...nm", plate, impedance, plate)
        drive = stiff + s * damp
        drive[..., 2 * len(designs.mounts) :] += np.swapaxes(plate, -1, -2) * impedance[..., None, :]
        own = np.einsum("mkx,...mx->...km", designs.values.frames, ground[..., k, :, :])
        amplitude = own.reshape(*ground.shape[:-3], -1)
        force = np.einsum("...nk,...k->...n", drive, amplitude)
        found[..., k, :] = np.einsum("...on,...n->...o", to_outputs, np.linalg.solve(dynamic, force[..., None])[..., 0])
    found[without_rest(designs, oil)] = np.nan
    labels = [*(f"cg {axis}" for axis in AXES), "rx", "ry", "rz"]
    labels += [f"{name} {axis}" for name in points or {} for axis in AXES]
    coords = designs.coords | {"frequency": ("frequency", frequency, {"units": "Hz"}), "output": labels}
    attributes = {"units": "m or rad", "long_name": "motion of the machine"}
    return xr.DataArray(found, coords, (*designs.dims, "frequency", "output"), "floor_response", attributes)


def _mount_loads(elements: Elements, kind: str) -> list[Array]:
    """Generalised force (…, n, mount) of the ground at each mount, per axis of its frame; ``kind`` stiffness or
    damping."""
    return [np.swapaxes(motion, -1, -2) * own[..., None, :] for _, motion, own in elements.supports(kind)[: len(AXES)]]


def _oil_stiffness(oil: Oil, s: complex) -> ComplexArray:
    """Dynamic stiffness of the oil between plate and ground, (…, mount) [N/m]; valves held (eqs. 3 and 6).

    Q into chamber k: ±s w A_k x + s C_k p_k + 2 g₀ p_k ± c (p₁ − p₂) = 0, force −(A₁ p₁ − A₂ p₂).
    """
    first, second = (s * compliance + 2.0 * oil.edge + oil.cross for compliance in oil.compliances)
    a, b = oil.areas
    inverse = oil.stretch * s / (first * second - oil.cross**2)
    return np.asarray(inverse * (a * (second * a - oil.cross * b) + b * (first * b - oil.cross * a)))


def _point(elements: Elements, point: Sequence[float]) -> Array:
    """Motion of a point of the machine per coordinate, (…, 3, n)."""
    rows = np.zeros((3, elements.mass.shape[-1]))
    rows[:, list(DOF_OF_JOINT)] = lever(point)
    return np.broadcast_to(rows, (*elements.mass.shape[:-2], *rows.shape))


def _floor(elements: Elements, motion: ArrayLike | str, frequencies: int) -> ComplexArray:
    """Displacement of each mount and axis, (…, frequency, mount, 3)."""
    mounts = elements.plate.shape[-2]
    if isinstance(motion, str):
        if motion not in DOFS:
            raise InputError(f"motion = {motion!r}: must be one of {', '.join(DOFS)}, or displacements of the mounts")
        places = np.stack(np.broadcast_arrays(*(elements.values.mounts[axis] for axis in AXES)), axis=-1)
        shift, turn = np.split(np.eye(len(DOFS))[DOFS.index(motion)], 2)
        array = (shift + np.cross(turn, places)).astype(complex)[..., None, :, :]
    else:
        array = np.asarray(motion, complex)
        if array.ndim < 2 or array.shape[-2:] != (mounts, len(AXES)):
            raise InputError(f"motion: has shape {array.shape}; it must end in (frequency, {mounts}, {len(AXES)})")
        array = array[None] if array.ndim == 2 else array
    return np.broadcast_to(array, (*array.shape[:-3], frequencies, mounts, len(AXES)))
