"""Many designs as plain arrays, one row each, as the compiled closed forms take them."""

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.linear.elements import Elements, solve
from ehamj.linear.oil import Oil
from ehamj.linear.values import Values
from ehamj.plant.axes import DOF_OF_JOINT

OIL: Final = (
    "area_1", "area_2", "compliance_1", "compliance_2", "stretch", "edge", "cross", "flow_gain",
    "valve_gain", "valve_frequency", "valve_damping",
)  # fmt: skip
"""What the oil and the valve of one isolator are made of, in the order of the last axis of ``Stack.oil``."""


@dataclass(frozen=True)
class Stack:
    """Designs along one axis; n coordinates (`ehamj.linear.elements`), the first six those of the machine."""

    elements: Elements
    rest: Oil
    mass: Array
    """(design, n, n), and so damping and stiffness, without oil."""
    damping: Array
    stiffness: Array
    motions: Array
    """Of each foot across, across and along its mount (its plate), (design, 3, mount, n)."""
    supports: Array
    """Stiffness and damping of what the ground moves in these directions, (design, 2, 3, mount)."""
    oil: Array
    """`OIL` (design, mount, 11)."""
    cg: Array
    """Motion of the centre of gravity and rotation, (design, 6, n), of small rotations from level."""
    empty: NDArray[np.bool_]
    """Designs (design,) without a rest in their cylinders."""
    frames: Array
    """Axes of each mount in rows (mount, 3, 3)."""

    @classmethod
    def of(cls, values: Values) -> Self:
        """A stack of the designs of a `Designs` with one dimension, or one design of a plant's `Values`."""
        elements = Elements.at_rest(values)
        shape = elements.mass.shape[:-2] or (1,)
        oil = Oil.of(values, elements.stroke)
        at, n, mounts = values.mounts, elements.mass.shape[-1], len(values.frames)
        gain = at["flow_gain"] / (1.0 + at["laminar_ratio"] ** 2) ** 0.25  # at rest edges have the rated drop
        parts = (
            *oil.areas, *oil.compliances, oil.stretch, oil.edge, oil.cross, gain,
            at["valve_gain"], at["valve_frequency"], at["valve_damping"],
        )  # fmt: skip
        directions = (elements.along, elements.across, elements.plate)
        supports = [
            [np.broadcast_to(own, (*shape, mounts)) for _, _, own in elements.supports(kind)[: len(directions)]]
            for kind in ("stiffness", "damping")
        ]
        return cls(
            elements,
            oil,
            _whole(elements.mass, shape, (n, n)),
            _whole(elements.damping, shape, (n, n)),
            _whole(elements.stiffness, shape, (n, n)),
            np.stack([_whole(one, shape, (mounts, n)) for one in directions], axis=1),
            np.moveaxis(np.array(supports), 2, 0).copy(),
            np.stack([np.broadcast_to(part, (*shape, mounts)) for part in parts], axis=-1).copy(),
            _whole(Elements.of(values).cg, shape, (6, n)),
            np.broadcast_to(oil.empty, shape),
            values.frames,
        )

    @property
    def plates(self) -> Array:
        """Motion of each plate along its mount, (design, mount, n)."""
        return self.motions[:, 2]

    @property
    def compliance(self) -> Array:
        """Displacement of the centre of gravity along x, y, z per force there that stays, (design, 3) [m/N]: membranes
        and feet, gravity's toppling, and oil only where nothing leaks; NaN where that is singular or there is no
        rest."""
        at = self.elements.values.mounts
        held = np.where(at["flow_pressure"] == 0.0, self.rest.stretch, 0.0) * sum(
            area**2 / compliance for area, compliance in zip(self.rest.areas, self.rest.compliances, strict=True)
        )
        stiffness = self.stiffness + np.einsum("...in,...i,...im->...nm", self.plates, held, self.plates)
        force = np.swapaxes(self.cg[:, :3], -1, -2)
        moved = np.einsum("...kn,...nk->...k", self.cg[:, :3], solve(stiffness, force))
        return np.where(self.empty[:, None], np.nan, moved)


def dofs_of(row: Array) -> Array:
    """A row over x, y, z, rx, ry, rz as one over the model's joints."""
    found = np.empty_like(row)
    found[..., list(DOF_OF_JOINT)] = row
    return found


def _whole(part: Array, shape: tuple[int, ...], last: tuple[int, ...]) -> Array:
    return np.ascontiguousarray(np.broadcast_to(part, (*shape, *last)))
