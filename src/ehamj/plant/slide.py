"""Slides: heavy parts that move along a rail of the machine, and stay where they went."""

from collections.abc import Mapping, Sequence
from typing import Self

from pydantic import Field, field_validator, model_validator

from ehamj.errors import InputError
from ehamj.plant.bodies import Body, Inertia, box_inertia, check_inertia
from ehamj.plant.machine import Machine
from ehamj.plant.points import NAME, check_place, check_unique
from ehamj.settings import Direction, Positive, Settings, Vector3, unit
from ehamj.signals import Signal
from ehamj.slides.kinds import AnyProfile
from ehamj.slides.rest import Rest


class Slide(Settings):
    """A rigid part on a rail, which adds to ``machine.mass``; its drive is stiff: it goes as its profile says."""

    name: str = Field(description="short name")
    mass: Positive = Field(description="mass [kg]")
    size: tuple[Positive, Positive, Positive] = Field(
        (0.6, 0.4, 0.3), description="of the box that is drawn: x, y, z [m]"
    )
    inertia: Inertia | None = Field(
        None,
        description="about its own CG: three moments, or the tensor, row by row; without: that of a homogeneous box of "
        "`size` [kg m²]",
    )
    position: Vector3 = Field(
        description="of its centre of gravity at coordinate 0, from the mount plane's centre: x, y, z [m]"
    )
    rail: Direction = Field(description="direction in which its coordinate grows: x, y, z (any length)")
    travel: tuple[float, float] = Field(description="where its coordinate must stay: from and to [m]")
    start: float | None = Field(
        None, description="coordinate at which it stands until its profile moves it [m]; without: the profile's, or 0"
    )
    profile: AnyProfile = Field(Rest.stated(), description="how it moves; without: it stands")

    @field_validator("name")
    @classmethod
    def _plain_name(cls, name: str) -> str:
        if not NAME.fullmatch(name):
            raise ValueError(f"{name!r} must consist of at most 32 letters, digits, - and _")
        return name

    @model_validator(mode="after")
    def _on_its_rail(self) -> Self:
        if self.inertia is not None:
            check_inertia("inertia", self.inertia)
        low, high = self.travel
        if not low < high:
            raise ValueError(f"travel = {list(self.travel)} must be from a coordinate to a larger one")
        told = self.profile.start
        if told is not None and self.start is not None and abs(told - self.start) > 1e-9:
            raise ValueError(
                f"start = {self.start:g} m: its profile begins at {told:g} m; leave start out, or let it stand "
                "there: profile.kind = 'rest'"
            )
        places = [("start", self.begins)]
        places += [(f"profile.{key}", place) for key, place in self.profile.farthest(self.begins)]
        for key, place in places:
            if not low - 1e-9 <= place <= high + 1e-9:
                raise ValueError(f"{key} takes it to {place:g} m, off its rail: travel = [{low:g}, {high:g}] m")
        try:
            self.course()
        except ValueError as error:  # it cannot be driven so
            raise ValueError(f"profile.{error}") from None
        return self

    @property
    def begins(self) -> float:
        """Coordinate at the start [m]."""
        told = self.profile.start if self.start is None else self.start
        return 0.0 if told is None else told

    @property
    def along(self) -> Vector3:
        """The rail's direction at length one."""
        return unit(self.rail)

    @property
    def moves(self) -> bool:
        """Whether it ever leaves its start."""
        return any(place != self.begins for _, place in self.profile.farthest(self.begins))

    @property
    def standing(self) -> Self:
        """The same slide, which stays where it starts."""
        return self.model_copy(update={"start": self.begins, "profile": Rest()})

    def place(self, coordinate: float) -> Vector3:
        """Its centre of gravity at a coordinate [m], from the mount plane's centre [m]."""
        x, y, z = (at + coordinate * d for at, d in zip(self.position, self.along, strict=True))
        return (x, y, z)

    def body(self, coordinate: float) -> Body:
        """What it adds to the machine while it stands there."""
        return Body.of(self.mass, self.place(coordinate), self.inertia or box_inertia(self.mass, self.size))

    def course(self) -> Signal:
        """Its coordinate [m] over time, with speed [m/s] and acceleration [m/s²]."""
        return self.profile.course(self.begins)


def check_slides(slides: Sequence[Slide], machine: Machine) -> None:
    """Refuse names that are there twice, and slides that leave the machine.

    Raises:
        ValueError: naming the key, the value and what is allowed.
    """
    check_unique("slide", slides)
    for slide in slides:
        for end, coordinate in zip(("begin", "end"), slide.travel, strict=True):
            check_place(f"slide {slide.name}: place at the {end} of its travel", slide.place(coordinate), machine)


def places_of(slides: Sequence[Slide], places: Mapping[str, float] | None) -> tuple[float, ...]:
    """Coordinate of each slide [m]: as ``places`` says by name, else at the start.

    Raises:
        InputError: if a name is unknown, or a place off its rail.
    """
    known = {slide.name: slide for slide in slides}
    for name, place in (places or {}).items():
        if name not in known:
            raise InputError(f"slide {name!r}: must be one of {', '.join(known) or 'none: the machine has no slides'}")
        low, high = known[name].travel
        if not low <= place <= high:
            raise InputError(f"slide {name}: {place:g} m is off its rail: travel = [{low:g}, {high:g}] m")
    return tuple((places or {}).get(slide.name, slide.begins) for slide in slides)
