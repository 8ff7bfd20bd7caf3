"""Where the sensors of a modal test stood: at feet or at points of the machine, and along what each measured."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.arrays import Array
from ehamj.control.channels import axis_of
from ehamj.errors import InputError, did_you_mean
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.plant import Plant
from ehamj.plant.points import Points, check_place
from ehamj.settings import Direction, Settings, Vector3, unit

KINDS: Final = ("displacement", "velocity", "acceleration")


class Place(Settings):
    """Where a sensor stood and along what it measured: a channel of a foot, or a point and a direction."""

    channel: str | None = Field(None, description="of a foot or a point, such as 'foot_acceleration front-left x'")
    point: Vector3 | None = Field(None, description="instead: x, y, z from the mount plane's centre [m]")
    direction: Direction | None = Field(None, description="along which it measures: x, y, z, of any length")
    scale: float = Field(1.0, description="by which its part of each shape is multiplied; -1 turns its sign")

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if (self.channel is None) == (self.point is None) or (self.point is None) != (self.direction is None):
            raise ValueError("must have channel, or point and direction")
        if self.scale == 0.0:
            raise ValueError("scale = 0: must not be zero; leave the sensor out")
        return self


@dataclass(frozen=True)
class Sensors:
    """Sensors of a modal test.

    ``mounts`` (n,) are numbers of the mounts at whose feet they stand, −1 elsewhere, at ``points`` (n, 3) [m] from the
    mount plane's centre; each measures along one of ``directions`` (n, 3), or, where it ``turns`` (n,), the rotation
    about it.
    """

    names: tuple[str, ...]
    mounts: Array
    points: Array
    directions: Array
    turns: Array
    scales: Array

    def at(self, positions: Array) -> Array:
        """Where each stands from the mount plane's centre [m], (n, 3), with feet at ``positions`` (mount, 3) [m]."""
        return np.where((self.mounts < 0)[:, None], self.points, positions[np.maximum(self.mounts, 0)])

    def rows(self, positions: Array) -> Array:
        """Reading of each sensor per motion of the mount plane's centre [m, rad], (n, 6), with feet at ``positions``
        (mount, 3) [m]."""
        at = self.at(positions)
        turned = self.turns[:, None]
        # d·(u + θ × p) = d·u + (p × d)·θ
        moved = np.where(turned, 0.0, self.directions)
        return np.concatenate([moved, np.where(turned, self.directions, np.cross(at, self.directions))], axis=1)


def sensors_of(components: Sequence[str], places: Mapping[str, Place], plant: Plant, points: Points) -> Sensors:
    """The sensors of some components of a file.

    Args:
        components: as the file names them; one without a place must itself be called as a channel: ``foot_… MOUNT x``,
            ``machine_… rx``, or ``POINT x`` of a point of the scenario.
        places: where they stood, by component.
        plant: whose feet they stand at.
        points: of the scenario.

    Raises:
        InputError: naming the component, and what is allowed.
    """
    for name in places:
        if name not in components:
            near = did_you_mean(name, components)
            raise InputError(f"measurement.{name}: {near}the file has {', '.join(components) or 'no shapes'}")
    found = [_one(name, places.get(name), plant, points) for name in components]
    columns = [np.array(column) for column in zip(*found, strict=True)] if found else [np.zeros(0)] * 5
    mounts, at, along, turns, scales = columns
    return Sensors(
        tuple(components), mounts.astype(int), at.reshape(-1, 3), along.reshape(-1, 3), turns.astype(bool), scales
    )


def _one(
    component: str, place: Place | None, plant: Plant, points: Points
) -> tuple[int, Vector3, Vector3, bool, float]:
    """Mount, point, direction, whether it turns, scale."""
    key = f"measurement.{component}"
    scale = 1.0 if place is None else place.scale
    if place is not None and place.point is not None and place.direction is not None:
        try:
            check_place(f"{key}.point", place.point, plant.machine)
        except ValueError as error:
            raise InputError(str(error)) from None
        return -1, place.point, unit(place.direction), False, scale
    name = component if place is None or place.channel is None else place.channel
    what, *labels = name.split(" ")
    body, _, motion = what.rpartition("_")
    if motion in KINDS and body == "foot" and len(labels) == 2 and labels[0] in plant.mounts:
        mount = plant.mounts.index(labels[0])
        if labels[1] in (*AXES, "along"):
            along = axis_of(labels[1], np.array(plant.directions[mount]))
            return mount, (0.0, 0.0, 0.0), (float(along[0]), float(along[1]), float(along[2])), False, scale
    if motion in KINDS and body == "machine" and len(labels) == 1 and labels[0] in DOFS:
        axis = DOFS.index(labels[0])
        x, y, z = np.eye(3)[axis % 3].tolist()
        return -1, (0.0, 0.0, 0.0), (x, y, z), axis >= len(AXES), scale
    if what in points and len(labels) == 1 and labels[0] in AXES:
        x, y, z = np.eye(3)[AXES.index(labels[0])].tolist()
        return -1, points[what], (x, y, z), False, scale
    raise InputError(
        f"{key}: {name!r} is no place of a sensor: must be 'foot_acceleration MOUNT AXIS' (of "
        f"{', '.join(plant.mounts)}; x, y, z or along), 'machine_acceleration DOF', 'POINT AXIS' of a point of the "
        f"scenario ({', '.join(points)}), or have point = [x, y, z] and direction = [x, y, z]"
    )
