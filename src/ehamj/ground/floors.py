"""A small library of floors: what shakes in a workshop, a metrology room, beside presses or a forklift's way.

Each floor is a sum of the other kinds of ground. The frequencies are those that the field reports; the levels are
*assumed* unless a norm or a model is named, within the ranges that its source states.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from ehamj.ground.broadband import BroadbandGround, BurstGround, ShapedGround
from ehamj.ground.motion import Combined, GroundSettings, Motion, Start
from ehamj.ground.synthetic import Dof, MultisineGround, ShockGround
from ehamj.ground.targets import PetersonTarget
from ehamj.ground.waves import Coherence, Wave
from ehamj.settings import Positive

Part = BroadbandGround | BurstGround | ShapedGround | MultisineGround | ShockGround

LINES = (16.7, 24.5, 29.0, 49.0, 59.0)
"""Motors and fans [Hz]: 1000, 1470, 1740, 2940 and 3540 rpm, that is 6-, 4- and 2-pole machines on 50 and 60 Hz mains,
less slip."""


@dataclass(frozen=True)
class Floor:
    """An entry of the library."""

    description: str
    """What it is, with the source of its numbers."""
    parts: tuple[Part, ...]


def _broadband(
    level: float, first: float, last: float, axes: tuple[Literal["x", "y", "z"], ...] = ("z",)
) -> BroadbandGround:
    return BroadbandGround.stated(kind="broadband", level=level, first=first, last=last, axes=axes)


def _lines(dof: Dof, velocity: float, frequencies: tuple[float, ...] = LINES) -> MultisineGround:
    return MultisineGround.stated(
        kind="multisine", dof=dof, frequencies=frequencies, velocities=(velocity,), fade_in=0.5
    )


def _peterson(model: Literal["low", "high"]) -> ShapedGround:
    target = PetersonTarget.stated(kind="peterson", model=model)
    # Microseisms last 5 s: fading in faster would throw the floor about more than it moves.
    return ShapedGround.stated(kind="shaped", target=target, first=0.1, axes=("x", "y", "z"), fade_in=5.0)


FLOORS: Mapping[str, Floor] = {
    "workshop": Floor(
        "vertical 40 µm/s per third octave from 5 to 31.5 Hz, horizontal 30 µm/s from 0.5 to 10 Hz, 12 dB/octave less "
        "above, up to 500 Hz (bands: reported for machine shops; levels: assumed, between VC-A and IEST-RP-CC012's "
        "operating theatre), and lines of motors and fans at 12 µm/s RMS vertical (assumed)",
        (_broadband(40e-6, 5.0, 31.5), _broadband(30e-6, 0.5, 10.0, ("x", "y")), _lines("z", 12e-6)),
    ),
    "metrology-room": Floor(
        "8 µm/s per third octave vertical and 5 µm/s horizontal from 1 to 80 Hz: meets VC-C, 12.5 µm/s, which "
        "IEST-RP-CC012 asks for in inspection to 1 µm (margin: assumed), and ventilation at 24.5 and 49 Hz at 1.5 µm/s "
        "RMS vertical (assumed)",
        (_broadband(8e-6, 1.0, 80.0), _broadband(5e-6, 1.0, 80.0, ("x", "y")), _lines("z", 1.5e-6, (24.5, 49.0))),
    ),
    "press-shop": Floor(
        "a floor twice as loud as the workshop's, without its lines, and two presses: a heavy one, half-sines of 20 ms "
        "and 2 mm/s every 4 s, and a light one, 8 ms and 0.5 mm/s every 0.9 s (ranges reported for stamping presses: 5 "
        "to 30 ms, 0.1 to 5 mm/s; the values in them and the rates: assumed)",
        (
            _broadband(80e-6, 5.0, 31.5),
            _broadband(60e-6, 0.5, 10.0, ("x", "y")),
            ShockGround.stated(kind="shock", velocity=2e-3, pulse_time=0.02, begin=1.0, repeat=4.0),
            ShockGround.stated(kind="shock", velocity=0.5e-3, pulse_time=0.008, begin=0.7, repeat=0.9),
        ),
    ),
    "forklift": Floor(
        "a forklift passes every 15 s: a burst of 5 to 20 Hz that swells for 1.5 s to 200 µm/s per third octave and "
        "decays (band and course: as reported; level and times: assumed), on half of the workshop's broadband floor",
        (
            _broadband(20e-6, 5.0, 31.5),
            _broadband(15e-6, 0.5, 10.0, ("x", "y")),
            BurstGround.stated(kind="burst", level=200e-6, begin=2.0, swell_time=1.5, repeat=15.0),
            BurstGround.stated(kind="burst", level=100e-6, begin=2.0, swell_time=1.5, repeat=15.0, axes=("x", "y")),
        ),
    ),
    "motors": Floor(
        "lines of motors and fans alone, at 16.7, 24.5, 29, 49 and 59 Hz (6-, 4- and 2-pole machines on 50 and 60 Hz "
        "less slip), 12 µm/s RMS each vertical and 6 µm/s horizontal (levels: assumed)",
        (_lines("z", 12e-6), _lines("x", 6e-6), _lines("y", 6e-6)),
    ),
    "nlnm": Floor(
        "Peterson's new low noise model (USGS 93-322, 1993) from 0.1 to 10 Hz in all axes: the quietest sites on earth",
        (_peterson("low"),),
    ),
    "nhnm": Floor(
        "Peterson's new high noise model (USGS 93-322, 1993) from 0.1 to 10 Hz in all axes: loud seismic sites, still "
        "quieter than a workshop",
        (_peterson("high"),),
    ),
}


if TYPE_CHECKING:
    FloorName = str
else:
    FloorName = Literal[tuple(FLOORS)]


class FloorGround(GroundSettings):
    """A floor of the library, scaled."""

    kind: Literal["floor"]
    floor: FloorName = Field(
        description="; ".join(f"{name}: {entry.description}" for name, entry in FLOORS.items()),
    )
    scale: Positive = Field(1.0, description="factor on the motion [-]")
    wave: Wave | None = Field(
        None, description="all of it passes below the machine as a plane wave; without: everywhere at once"
    )
    coherence: Coherence | None = Field(
        None, description="partial coherence between the mounts of its random parts; without: they move alike"
    )

    def motion(self, start: Start) -> Motion:
        entry = FLOORS[self.floor]
        moving = []
        for k, part in enumerate(entry.parts):
            passing: dict[str, Wave | Coherence | None] = {"wave": self.wave}
            if "coherence" in type(part).model_fields:
                passing["coherence"] = self.coherence
            moving.append(part.model_copy(update=passing).motion(replace(start, part=(*start.part, k))))
        times = "" if self.scale == 1 else f", {self.scale:g} times as strong"
        return Combined(tuple(moving), self.scale, f"floor {self.floor}{times}: {entry.description}")
