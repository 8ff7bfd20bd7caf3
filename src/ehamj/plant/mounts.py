"""Where the isolators stand."""

from typing import Final, Literal

from pydantic import Field

from ehamj.settings import Position2, Settings

MOUNTS: Final = ("front-left", "front-right", "rear-left", "rear-right")
"""Mounts in order; +x is front, +y is left."""

N_MOUNTS: Final = len(MOUNTS)


class Mount(Settings):
    """Where one actuator stands under the machine."""

    name: Literal["front-left", "front-right", "rear-left", "rear-right"]
    position: Position2 = Field(description="x and y from the mount plane's centre [m]")
    actuator: str = Field("isolator", description="name of a table [actuators.NAME]")


DEFAULT_MOUNTS: tuple[Mount, ...] = tuple(
    Mount(name=name, position=position)  # type: ignore[arg-type]
    for name, position in zip(MOUNTS, ((0.9, 0.6), (0.9, -0.6), (-0.9, 0.6), (-0.9, -0.6)), strict=True)
)
