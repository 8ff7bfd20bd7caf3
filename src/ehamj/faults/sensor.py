"""Sensors that fail: which readings are struck, and what they then say."""

from collections.abc import Iterator, Sequence
from typing import Self

from pydantic import Field, model_validator

from ehamj.control.channels import channel_names, check_channel, is_upstream
from ehamj.control.sensors import Sensors, class_of
from ehamj.errors import did_you_mean
from ehamj.faults.fault import FaultSettings
from ehamj.plant.mounts import MOUNTS

CLASSES = tuple(Sensors.model_fields)
"""Classes of sensors, as the tables in [sensors]."""


class SensorFault(FaultSettings):
    """A fault of the sensors of one class at a mount, or of one channel."""

    mount: str | None = Field(None, description="mount at which the sensors of the class stand")
    sensor: str = Field(
        "inertial",
        description=f"class of the sensors that fail ({', '.join(CLASSES)}), or one channel as laws name it, such as "
        "'foot_velocity front-left z'",
    )

    @model_validator(mode="after")
    def _placed(self) -> Self:
        if self.sensor in CLASSES and self.mount is None:
            raise ValueError(f"mount is missing: the sensors of the class {self.sensor!r} at one mount fail")
        return self

    @property
    def where(self) -> str:
        return self.sensor if self.mount is None else self.mount

    @property
    def whose(self) -> str:
        """Which sensors, as the beginning of a sentence."""
        return f"{self.sensor} sensors" if self.sensor in CLASSES else "sensor"

    def struck(self, channels: Sequence[str]) -> tuple[str, ...]:
        if self.sensor not in CLASSES:
            return tuple(name for name in channels if name == self.sensor)
        found = [name for name in channels if self.mount in name.split(" ")]
        return tuple(name for name in found if class_of(name.partition(" ")[0]) == self.sensor)

    def named_mounts(self) -> Iterator[tuple[str, str]]:
        yield from super().named_mounts()
        variable, *labels = self.sensor.split(" ")
        if labels and is_upstream(self.sensor):
            return
        # Only where a name of a mount is missing for a channel: else what is wrong is the channel.
        if labels and " ".join((variable, MOUNTS[0], *labels[1:])) in channel_names():
            yield "sensor", labels[0]

    def check(self, mounts: Sequence[str]) -> None:
        super().check(mounts)
        if self.sensor in CLASSES:
            return
        if " " not in self.sensor:
            near = did_you_mean(self.sensor, CLASSES)
            raise ValueError(
                f"sensor = {self.sensor!r}: {near}must be one of {', '.join(CLASSES)}, or a channel's name"
            )
        try:
            check_channel(self.sensor, tuple(mounts))
        except ValueError as error:
            raise ValueError(f"sensor: {error}") from None
        if self.mount is not None and self.mount not in self.sensor.split(" "):
            raise ValueError(f"mount = {self.mount!r} is not that of sensor = {self.sensor!r}; leave mount out")
