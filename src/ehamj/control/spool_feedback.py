"""Valves with a position sensor, whose spool a loop of its own makes follow: the table [control.spool_feedback].

What is known is read off the valves of the machine that the law is held for (`designed_for`; without, the scenario's
own); the compiled part is `ehamj.control.compiled.spools`.
"""

import math
from typing import Annotated, Literal

from pydantic import Field

from ehamj.control.inverse import instrument_poles, lag
from ehamj.control.sensors import Sensors
from ehamj.control.spools import MOST_DELAY, KnownSpool, opened, runs_away
from ehamj.errors import InputError
from ehamj.isolator.component import HUGE
from ehamj.plant.plant import Plant
from ehamj.settings import Positive, Settings


class SpoolFeedback(Settings):
    """A loop about the spool of each valve, so that it stands where the law and the stage want it."""

    rate: Positive = Field(20_000.0, description="sampling rate [Hz]")
    delay: Annotated[float, Field(ge=0, le=MOST_DELAY)] | None = Field(
        None, description="computation delay [s]; without: one of its samples"
    )
    crossing: Positive = Field(300.0, description="frequency up to which errors of the spool are taken back [Hz]")
    rolloff: Positive = Field(
        8e-5, description="time constant, twice, to which the lead over the valve's lag is rolled off [s]"
    )
    limit: Positive = Field(1.0, description="most that it adds to the command [V]")
    position: Literal["edges", "spool"] = Field(
        "edges",
        description="what the sensor shows: edges, the lands that meter; or spool, the driven end before the play of "
        "hysteresis, which is then not taken back",
    )

    def known(self, plant: Plant, sensors: Sensors) -> tuple[KnownSpool, ...]:
        """What is known of the spools of a plant's valves, one per mount.

        Raises:
            InputError: if a loop is unstable with the valve as it is known and the sensor.
        """
        late = lag(instrument_poles(sensors.spool)[1])
        period = 1.0 / self.rate
        found = tuple(
            KnownSpool(
                valve_gain=one.valve_gain,
                valve_frequency=one.valve_frequency,
                valve_damping=one.valve_damping,
                drive_limit=min(one.spool_drive_limit, HUGE),
                crossing=0.0 if one.passive else 2.0 * math.pi * self.crossing,
                rolloff=self.rolloff,
                lag=late,
                limit=self.limit,
                period=period,
                delay=period if self.delay is None else self.delay,
                edges=float(self.position == "edges"),
            )
            for one in plant.actuators
        )
        for own in dict.fromkeys(found):
            radius = runs_away(opened(own, sensors.spool))
            if own.crossing and radius >= 1.0:
                raise InputError(
                    f"control.spool_feedback.crossing = {self.crossing:g} Hz: the loop about the spool is unstable "
                    f"with its delay of {own.delay:g} s and its sensor, from one sample to the next by a factor "
                    f"{radius:.6g}; lower it, shorten rolloff or delay, or raise rate"
                )
        return found
