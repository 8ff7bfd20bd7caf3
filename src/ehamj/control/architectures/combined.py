"""Several architectures at once; feedforward and modal feedback by default."""

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ehamj.control.architectures.feedforward import FeedforwardSettings
from ehamj.control.architectures.modal import ModalSettings
from ehamj.control.architectures.resonant import ResonantSettings
from ehamj.control.architectures.servo import StrokeServoSettings
from ehamj.control.architectures.skyhook import SkyhookSettings
from ehamj.control.law import Controller, stack
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.control.settings import DigitalSettings
from ehamj.plant.plant import Plant

Architecture = Annotated[
    FeedforwardSettings | ModalSettings | SkyhookSettings | StrokeServoSettings | ResonantSettings,
    Field(discriminator="kind"),
]
SHARED = ("rate", "delay", "bits", "switch_on", "fade", "recovery")
"""Settings that all parts have from the whole."""


class CombinedSettings(DigitalSettings):
    """The sum of several laws, sampled together."""

    kind: Literal["combined"] = "combined"
    parts: tuple[Architecture, ...] = Field(
        (FeedforwardSettings(), ModalSettings()), description="laws that add up", min_length=1
    )

    @model_validator(mode="after")
    def _one_clock(self) -> Self:
        for number, part in enumerate(self.parts):
            for name in part.model_fields_set.intersection(SHARED):
                ours, theirs = getattr(self, name), getattr(part, name)
                if theirs != ours:
                    raise ValueError(f"parts.{number}.{name} = {theirs}: must be that of the whole, {name} = {ours}")
        shared = {name: getattr(self, name) for name in SHARED}
        object.__setattr__(self, "parts", tuple(part.model_copy(update=shared) for part in self.parts))
        return self

    def controller(self, plant: Plant, sensors: Sensors = IDEAL) -> Controller:
        """The law for a plant that is measured by ``sensors``."""
        modal = next((part for part in self.parts if isinstance(part, ModalSettings)), None)
        return stack([self._one(part, modal, plant, sensors) for part in self.parts])

    def _one(self, part: "Architecture", modal: ModalSettings | None, plant: Plant, sensors: Sensors) -> Controller:
        if isinstance(part, ResonantSettings):
            return part.controller(plant, sensors, modal)
        return part.controller(plant, sensors)


def architectures() -> Sequence[type[DigitalSettings]]:
    """The settings of every architecture."""
    return (
        FeedforwardSettings, StrokeServoSettings, SkyhookSettings, ModalSettings, ResonantSettings, CombinedSettings,
    )  # fmt: skip
