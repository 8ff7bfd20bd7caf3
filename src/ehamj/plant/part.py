"""Rigid parts that stand on the machine and add up with it: a workpiece, a rotary table, a magazine."""

from collections.abc import Sequence
from typing import Self

from pydantic import Field, model_validator

from ehamj.plant.bodies import Body, Inertia, check_inertia
from ehamj.plant.machine import Machine
from ehamj.plant.points import check_place, check_unique
from ehamj.settings import Settings, Vector3


class Part(Settings):
    """A rigid part that is fixed to the machine; its mass adds to ``machine.mass``."""

    name: str = Field(description="short name", min_length=1)
    mass: float = Field(gt=0, description="mass [kg]")
    inertia: Inertia = Field(
        (0.0, 0.0, 0.0),
        description="about its own CG: three moments, or the tensor, row by row; without: that of a point [kg m²]",
    )
    position: Vector3 = Field(description="of its centre of gravity, from the mount plane's centre: x, y, z [m]")

    @model_validator(mode="after")
    def _physical(self) -> Self:
        check_inertia("inertia", self.inertia, point=True)
        return self

    @property
    def body(self) -> Body:
        """What it adds."""
        return Body.of(self.mass, self.position, self.inertia)


def check_parts(parts: Sequence[Part], machine: Machine) -> None:
    """Refuse names that are there twice, and parts far from the machine.

    Raises:
        ValueError: naming the key, the value and what is allowed.
    """
    check_unique("part", parts)
    for part in parts:
        check_place(f"part {part.name}: position", part.position, machine)
