"""What a user says of a component that was measured: a table ``[test.measurement]`` holds one for each."""

from typing import Literal, Self

from pydantic import Field, model_validator

from ehamj.measured.measured import Role
from ehamj.records.inputs import Hold
from ehamj.settings import Direction, Positive, Settings, Vector3

Free = Literal["free"]
Accepted = Literal["dead", "clipped", "coarse"]


class MeasuredForce(Settings):
    """A force that was measured."""

    point: str | Vector3 = Field(
        "cg", description="where it acts: a name in [points], 'cg', or a place from the mount plane's centre [m]"
    )
    direction: Direction = Field((0.0, 0.0, 1.0), description="along which it acts (any length)")


class Accelerometer(Settings):
    """An accelerometer anywhere on the machine."""

    point: str | Vector3 = Field(description="where it stands: a name in [points], or a place from the mount plane's "
                                             "centre [m]")  # fmt: skip
    direction: Direction = Field((0.0, 0.0, 1.0), description="along which it measures (any length)")


class MeasuredComponent(Settings):
    """What a component of the file is; its key in the table is its name in the file, unless ``component`` says it."""

    channel: str | None = Field(
        None,
        description="channel of ehamj that it measured, such as 'stroke front-left', or 'valve_command front-left'",
    )
    force: MeasuredForce | None = Field(None, description="instead of a channel: a force on the machine, and its place")
    accelerometer: Accelerometer | None = Field(
        None,
        description="instead of a channel: an accelerometer on the machine, and its place (of kind = 'hammer')",
    )
    component: str | None = Field(None, description="name in the file, or number from 1; without: the table's key")
    role: Role | None = Field(
        None,
        description="input: it drives the model; output: it is compared; without: commands, ground and forces drive, "
        "all else is compared",
    )
    unit: str | None = Field(
        None,
        description="unit of the samples where the file states none, or what 1 V or one count of them stands for; "
        "'SI': they are SI",
    )
    scale: float = Field(1.0, description="factor on the samples; negative turns their sign [-]")
    full_scale: Positive | None = Field(None, description="what the largest sample of a WAV file stands for [unit]")
    offset: Free | None = Field(None, description="'free': the sensor adds an unknown constant, which is found")
    gain: Free | None = Field(None, description="'free': the sensor's gain is not known, and is found")
    delay: Free | None = Field(None, description="'free': the channel comes late by an unknown time, which is found")
    hold: Hold | None = Field(
        None,
        description="of a command or a force that drives, between its samples: smooth, a spline; straight lines; or "
        "held, as a converter holds what it gives; without: smooth",
    )
    accept: tuple[Accepted, ...] = Field(
        (), description="faults that are known and let pass: dead (never changes), clipped, coarse (few steps)"
    )

    @model_validator(mode="after")
    def _is_something(self) -> Self:
        if [self.channel, self.force, self.accelerometer].count(None) != 2:
            raise ValueError("channel, force or accelerometer: one of them must say what it is")
        if self.scale == 0.0:
            raise ValueError("scale = 0 must not be zero")
        return self


Measurement = dict[str, MeasuredComponent]
"""By the component's name in the file."""
