"""Architectures, and their sums. One more is a file in `architectures/` and an entry here."""

import re
from typing import TYPE_CHECKING, Any, Final, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, field_serializer, model_validator

from ehamj.control.architectures.adaptive import AdaptiveSettings
from ehamj.control.architectures.feedforward import FeedforwardSettings
from ehamj.control.architectures.levelling import LevellingSettings
from ehamj.control.architectures.modal import ModalSettings
from ehamj.control.architectures.resonant import ResonantSettings
from ehamj.control.architectures.servo import StrokeServoSettings
from ehamj.control.architectures.skyhook import SkyhookSettings
from ehamj.control.law import Controller, stack
from ehamj.control.sensors import Sensors
from ehamj.control.settings import SHARED, DigitalSettings
from ehamj.errors import InputError
from ehamj.plant.plant import Plant
from ehamj.registry import Registry
from ehamj.settings import one_of

ARCHITECTURES: Final[Registry[type[DigitalSettings]]] = Registry("architecture")
"""Digital laws, which run alone or as parts of `CombinedSettings`."""

_LAWS: tuple[type[DigitalSettings], ...] = (
    FeedforwardSettings,
    StrokeServoSettings,
    SkyhookSettings,
    ModalSettings,
    ResonantSettings,
    AdaptiveSettings,
    LevellingSettings,
)
for _law in _LAWS:
    ARCHITECTURES.add(_law.name(), _law)

if TYPE_CHECKING:
    Part = DigitalSettings
else:
    Part = one_of(ARCHITECTURES.values())


class CombinedSettings(DigitalSettings):
    """The sum of several laws, sampled together."""

    kind: Literal["combined"] = "combined"
    parts: tuple[Part, ...] = Field(
        (FeedforwardSettings.stated(), ModalSettings.stated()), description="laws that add up", min_length=1
    )

    @model_validator(mode="after")
    def _one_clock(self) -> Self:
        for number, part in enumerate(self.parts):
            for name in part.model_fields_set.intersection(SHARED):
                ours, theirs = getattr(self, name), getattr(part, name)
                if theirs != ours and name == "designed_for":
                    raise ValueError(f"parts.{number}.{name}: is stated once, for all parts: control.{name}")
                if theirs != ours:
                    raise ValueError(f"parts.{number}.{name} = {theirs}: must be that of the whole, {name} = {ours}")
        object.__setattr__(self, "parts", tuple(map(_without_shared, self.parts)))
        return self

    @field_serializer("parts", mode="wrap")
    def _said_once(self, parts: Any, handler: SerializerFunctionWrapHandler) -> list[dict[str, Any]]:
        return [{key: value for key, value in part.items() if key not in SHARED} for part in handler(parts)]

    @property
    def members(self) -> tuple[DigitalSettings, ...]:
        """The parts, with clock, converter, recovery and held machine of the whole."""
        return tuple(part.model_copy(update=self.shared) for part in self.parts)

    def with_member(self, number: int, member: DigitalSettings) -> Self:
        """The sum with another law in place of a part."""
        parts = (*self.parts[:number], _without_shared(member), *self.parts[number + 1 :])
        return self.model_copy(update={"parts": parts})

    def isolating_from(self, hertz: float) -> Self:
        """Every part that can leaves what is slower to the floor."""
        return self.model_copy(update={"parts": tuple(part.isolating_from(hertz) for part in self.parts)})

    def controller(self, plant: Plant, sensors: Sensors) -> Controller:
        laws, found = self.members, []
        for k, law in enumerate(laws):
            try:
                found.append(law.beside(laws[:k] + laws[k + 1 :], plant, sensors))
            except InputError as error:
                raise InputError(_of_part(str(error), law, k)) from error
        return stack(found)


def _of_part(message: str, part: DigitalSettings, number: int) -> str:
    """A message in which keys of a part stand as if it were alone, with the keys that they have in the sum."""
    own = "|".join(re.escape(name) for name in type(part).model_fields if name not in SHARED)
    return re.sub(rf"\bcontrol\.(?=(?:{own})\b)", f"control.parts.{number}.", message)


def _without_shared(part: DigitalSettings) -> DigitalSettings:
    """A part that states nothing of what is the whole's."""
    own = {name: getattr(part, name) for name in type(part).model_fields if name not in SHARED}
    return part.model_construct(_fields_set=part.model_fields_set.difference(SHARED), **own)
