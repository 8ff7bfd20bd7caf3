"""Where the isolators stand, and along what they act."""

from typing import Final, Self

from pydantic import Field, field_validator, model_validator

from ehamj.plant.points import NAME, RESERVED
from ehamj.settings import Direction, Settings, Vector3, unit

MOUNTS: Final = ("front-left", "front-right", "rear-left", "rear-right")
"""Mounts of the default machine, in order; +x is front, +y is left."""

UP: Final = (0.0, 0.0, 1.0)

FEWEST: Final = 3
MOST: Final = 32
"""How many mounts a machine may stand on."""

UPRIGHT: Final = 1e-12
"""How far from one the z of a direction may be that is upright."""


class Mount(Settings):
    """Where one isolator stands at the machine, and along what it acts."""

    name: str = Field(description="short name: at most 32 letters, digits, - and _")
    position: tuple[float, ...] = Field(
        min_length=2, max_length=3, description="of the foot from the mount plane's centre: x and y, or x, y and z [m]"
    )
    direction: Direction = Field(UP, description="along which it acts, towards the machine: x, y, z (any length); up")
    height: float = Field(0.0, description="shim below the isolator, along its direction [m]")
    actuator: str = Field("isolator", description="name of a table [actuators.NAME]")

    @field_validator("name")
    @classmethod
    def _callable(cls, name: str) -> str:
        if name in RESERVED or not NAME.fullmatch(name):
            raise ValueError(
                f"must consist of at most 32 letters, digits, - and _, and not be one of {', '.join(RESERVED)}"
            )
        return name

    @model_validator(mode="after")
    def _reachable(self) -> Self:
        if abs(self.height) > HIGHEST:
            raise ValueError(f"height = {self.height:g} m must be a shim of at most {HIGHEST:g} m")
        return self

    @property
    def place(self) -> Vector3:
        """x, y, z [m]."""
        x, y, *z = self.position
        return (x, y, *z) if z else (x, y, 0.0)  # type: ignore[return-value]

    @property
    def along(self) -> Vector3:
        """The direction at length one."""
        return unit(self.direction)


HIGHEST: Final = 0.05
"""The thickest shim [m]."""

DEFAULT_MOUNTS: tuple[Mount, ...] = tuple(
    Mount.stated(name=name, position=position)
    for name, position in zip(MOUNTS, ((0.9, 0.6), (0.9, -0.6), (-0.9, 0.6), (-0.9, -0.6)), strict=True)
)
