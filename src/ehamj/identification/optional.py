"""Which options a file asks about, and where in the scenario their values stand."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from pydantic import Field, model_validator

from ehamj.campaign.keys import own_value, unit_at
from ehamj.errors import InputError, did_you_mean
from ehamj.identification.option import ValveOption
from ehamj.identification.options import OPTIONS
from ehamj.identification.unknowns import Unknown
from ehamj.isolator.actuator import Actuator
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings

Criterion = Literal["bic", "aicc"]


class ChoiceSettings(Settings):
    """Options of the valve that the data may justify."""

    options: tuple[str, ...] = Field(description=f"which: {', '.join(OPTIONS)}", min_length=1)
    actuators: tuple[str, ...] | None = Field(
        None,
        description="isolators that may have them, by the names of their tables; without: all that obey",
        min_length=1,
    )
    criterion: Criterion = Field(
        "bic",
        description="what decides: bic (rarely believes in what is not there) or aicc (rarely misses what is there); "
        "both are told",
    )

    @model_validator(mode="after")
    def _known(self) -> "ChoiceSettings":
        for name in self.options:
            OPTIONS.find(name)
        twice = next((name for name in self.options if self.options.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"choice.options: {twice!r} stands there twice")
        return self


@dataclass(frozen=True)
class Place:
    """An option's value in the table of one isolator."""

    name: str
    """Of the option."""
    key: str
    """Of the scenario."""
    unit: str
    actuator: Actuator

    @property
    def option(self) -> ValveOption:
        """What it is."""
        return OPTIONS[self.name]

    def value(self, size: float) -> float:
        """Of an option of this size."""
        return self.option.value(size, self.actuator)

    def size(self, value: float) -> float:
        """Back."""
        return (value - self.option.neutral) / self.option.scale(self.actuator)

    @property
    def unknown(self) -> Unknown:
        """Its value, as a fit looks for it."""
        low, high = (self.value(size) for size in self.option.bounds)
        step = 10.0 * self.option.matters * self.option.scale(self.actuator)
        return Unknown(self.key, self.unit, self.value(0.0), low, high, size=step)


def places_of(
    settings: ChoiceSettings, machine: Scenario, looked_for: Sequence[str]
) -> Mapping[str, tuple[Place, ...]]:
    """Where the options' values stand, by option, in a machine that `with_neutral` gave.

    Raises:
        InputError: if there is no such isolator, an option's value is looked for already, or the machine has one.
    """
    found = {}
    for name in settings.options:
        option, places = OPTIONS[name], []
        for actuator in _actuators(settings, machine):
            key = f"actuators.{actuator}.{option.key}"
            own = own_value(machine, key)
            if key in looked_for:
                raise InputError(
                    f"choice.options: {name!r}: {key} is looked for in [parameters]; leave it out of one of them"
                )
            if any(value != option.neutral for value in (own if isinstance(own, list) else [own])):
                raise InputError(
                    f"choice.options: {name!r}: the scenario has {key} = {own} already; set it to {option.neutral:g}, "
                    "or look for it in [parameters]"
                )
            places.append(Place(name, key, unit_at(machine, key), machine.actuators[actuator]))
        found[name] = tuple(places)
    return found


def neutral_of(places: Mapping[str, Sequence[Place]]) -> dict[str, float]:
    """Values of all options that are not there, by key."""
    return {place.key: place.value(0.0) for own in places.values() for place in own}


def with_neutral(settings: ChoiceSettings, machine: Scenario) -> Scenario:
    """The machine with what the options' tables need, with which it does what it did."""
    needed = {
        f"actuators.{actuator}.{key}": value
        for name in settings.options
        for actuator in _actuators(settings, machine)
        for key, value in OPTIONS[name].set.items()
        if not own_value(machine, f"actuators.{actuator}.{key}")
    }
    return changed(machine, needed) if needed else machine


def _actuators(settings: ChoiceSettings, machine: Scenario) -> tuple[str, ...]:
    """Names of the isolators that may have options."""
    for name in settings.actuators or ():
        if name not in machine.actuators:
            near = did_you_mean(name, machine.actuators)
            raise InputError(f"choice.actuators: {name!r}: {near}must be one of {', '.join(machine.actuators)}")
    if settings.actuators is not None:
        return settings.actuators
    obeying = tuple(name for name, own in machine.actuators.items() if not own.passive)
    if not obeying:
        raise InputError("choice: no isolator obeys commands, so that no option of a valve can be chosen")
    return obeying
