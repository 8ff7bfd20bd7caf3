"""Nodes of a universal file on the machine: their coordinates there, and how its axes lie."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.arrays import Array
from ehamj.errors import InputError, did_you_mean
from ehamj.measured.sensors import Place
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant
from ehamj.plant.points import Points
from ehamj.records.files import existing, reading
from ehamj.records.uff import LENGTHS, opened
from ehamj.settings import Settings, Vector3

NODES: Final = (15, 2411)
"""Datasets that hold nodes."""
GLOBAL: Final = (0, 1)
"""Numbers that the global coordinate system has."""
UNITS: Final = 164

Axis = Literal["x", "-x", "y", "-y", "z", "-z"]


class Frame(Settings):
    """How the coordinates of a universal file lie in the machine."""

    origin: Vector3 = Field((0.0, 0.0, 0.0), description="where its origin is, from the mount plane's centre [m]")
    axes: tuple[Axis, Axis, Axis] = Field(
        ("x", "y", "z"), description="along which of the machine's axes its x, y and z point, such as '-y'"
    )

    @model_validator(mode="after")
    def _right_handed(self) -> Self:
        if np.linalg.det(self.matrix) < 0.5:
            raise ValueError("axes: must be three different ones, and right-handed, such as ['y', '-x', 'z']")
        return self

    @property
    def matrix(self) -> Array:
        """Directions of the file's axes in the machine's, (3, 3), one in each column."""
        columns = [np.eye(3)[AXES.index(axis[-1])] * (-1.0 if axis[0] == "-" else 1.0) for axis in self.axes]
        return np.array(columns).T


Nodes = dict[str, str | Vector3]
"""By number: a foot, a point of the scenario, or a place from the mount plane's centre [m]."""


def coordinates_of(path: Path) -> dict[str, Vector3]:
    """Coordinates of a universal file's nodes whose axes are the global ones, by number [m].

    Raises:
        ValueError: where they cannot be read, or nothing says of what length they are.
    """
    existing(path)
    found: dict[str, Vector3] = {}
    with opened(path) as file, reading(path, " as a universal file"):
        length = 1.0
        for n, kind in enumerate(file.get_set_types()):
            if int(kind) == UNITS:
                length = _length(file.read_sets(n))
            if int(kind) in NODES:
                found |= _nodes(file.read_sets(n), length)
    return found


def _length(content: Mapping[str, Any]) -> float:
    """Unit of length [m]; the dataset says by what lengths are divided to be SI."""
    factor, stated = float(content["length"]), LENGTHS.get(int(content["units_code"]))
    if not 0.0 < factor < np.inf or (stated is not None and abs(stated * factor - 1.0) > 1e-3):
        raise ValueError(
            f"its dataset 164 contradicts itself: units code {int(content['units_code'])}, length factor {factor:g}"
        )
    return 1.0 / factor


def _nodes(content: Mapping[str, Any], length: float) -> dict[str, Vector3]:
    columns = (content[name] for name in ("node_nums", "def_cs", "disp_cs", "x", "y", "z"))
    return {
        str(int(number)): (length * float(x), length * float(y), length * float(z))
        for number, defined, displaced, x, y, z in zip(*columns, strict=True)
        if int(defined) in GLOBAL and int(displaced) in GLOBAL
    }


def places_of(
    components: Iterable[str],
    stood: Mapping[str, Vector3],
    frame: Frame,
    told: Nodes,
    plant: Plant,
    points: Points,
) -> dict[str, Place]:
    """Where components of a universal file, ``12:+Z``, measured; those whose node has no place are left out.

    Args:
        components: by node and direction.
        stood: nodes as the file has them [m], in ``frame``.
        frame: of the file.
        told: what the user says of nodes, which goes before.
        plant: whose feet nodes may be at.
        points: of the scenario.

    Raises:
        InputError: where the user's table names a node that the file has not, or a place that there is not.
    """
    sides = {name: name.partition(":")[::2] for name in components}
    numbers = list(dict.fromkeys(node for node, _ in sides.values()))
    for node in told:
        if node not in numbers:
            near = did_you_mean(node, numbers)
            raise InputError(f"nodes.{node}: {near}the file has {', '.join(numbers)}")
    found = {}
    for name, (node, side) in sides.items():
        if side[-1:].lower() not in AXES:
            continue
        along = frame.matrix[:, AXES.index(side[-1].lower())]
        direction = (float(along[0]), float(along[1]), float(along[2]))
        if node in told:
            point = _told(node, told[node], plant, points)
        elif node in stood:
            at = frame.matrix @ np.array(stood[node]) + np.array(frame.origin)
            point = (float(at[0]), float(at[1]), float(at[2]))
        else:
            continue
        found[name] = Place(point=point, direction=direction)
    return found


def _told(node: str, place: str | Vector3, plant: Plant, points: Points) -> Vector3:
    if not isinstance(place, str):
        return place
    if place in plant.mounts:
        x, y, z = plant.positions[plant.mounts.index(place)]
        return float(x), float(y), float(z)
    if place in points:
        return points[place]
    known = (*plant.mounts, *points)
    raise InputError(f"nodes.{node} = {place!r}: {did_you_mean(place, known)}must be one of {', '.join(known)}")
