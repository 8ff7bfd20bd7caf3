"""What laws learn of their isolators while they run: the table [control.learning].

The compiled part, and what it does, is `ehamj.control.compiled.learning`. It begins with what is stated of the machine
that the law is held for (`designed_for`; without, the scenario's own).
"""

from collections.abc import Sequence
from typing import Self

from pydantic import Field, model_validator

from ehamj.control.inverse import Inverse, instrument_poles, lag
from ehamj.control.learners import Learner
from ehamj.control.sensors import Sensors
from ehamj.control.valves import EDGES, Known, KnownValve
from ehamj.isolator.actuator import Actuator
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative, Positive, Settings


class Learning(Settings):
    """What is learnt of each isolator from what its valve was told, its chambers' pressures and its stroke."""

    flow_gain: NotNegative = Field(
        0.5,
        le=4.0,
        description="share by which the flow gain may come out larger than stated, or the stated one larger [-]",
    )
    compliance: NotNegative = Field(
        1.0, le=9.0, description="the same of the oil's compliance, V_t/(4β), the inverse of its stiffness [-]"
    )
    overlap: NotNegative = Field(
        0.3, description="by how much the edges' overlap may differ, where control.linearisation makes it good [mA]"
    )
    play: NotNegative = Field(
        0.1, description="the same of threshold and half of the hysteresis together, where it makes them good [mA]"
    )
    null_offset: NotNegative = Field(0.5, description="by how much the null offset may differ [mA]")
    band: tuple[Positive, Positive] = Field((3.0, 60.0), description="motion that is learnt from: from, to [Hz]")
    rate: Positive = Field(1000.0, description="at which the oil of each isolator is balanced, at most [Hz]")
    memory: Positive = Field(15.0, description="time over which is forgotten what was observed [s]")
    prior: Positive = Field(
        1e-4, description="weight of what is stated: how long a quantity as far off as it may be is to be seen [s]"
    )
    pace: Positive = Field(1.0, description="time over which the law follows what it finds [s]")
    least: Positive = Field(
        2e-3,
        description="flow in the band, as an opening, RMS, below which nothing is learnt; "
        "where edges are made good at least control.linearisation.band [mA]",
    )

    @model_validator(mode="after")
    def _rising(self) -> Self:
        if not self.band[0] < self.band[1] < 0.25 * self.rate:
            raise ValueError(
                f"band = {list(self.band)} Hz must rise, and end below a quarter of rate = {self.rate:g} Hz"
            )
        return self

    def learners(self, plant: Plant, valves: Sequence[KnownValve], sensors: Sensors) -> tuple[Learner, ...]:
        """What is known of a plant's isolators, one per mount.

        Args:
            plant: machine on its isolators.
            valves: what is known of each valve, and made good. Of its edges is learnt what is: their overlap, where any
                is known, and their play, where it is.
            sensors: that measure strokes and pressures.
        """
        lags = lag(instrument_poles(sensors.stroke)[1]), lag(instrument_poles(sensors.pressure)[1])
        return tuple(self._of(one, valve.numbers, lags) for one, valve in zip(plant.actuators, valves, strict=True))

    def _of(self, actuator: Actuator, known: Known, lags: tuple[float, float]) -> Learner:
        """Of one isolator; one that does not obey learns nothing.

        Within the band of its edges a loop may hunt, and what is learnt there is no property of the valve.
        """
        one, two = actuator.piston_area / actuator.volume_1, actuator.piston_area_2 / actuator.volume_2
        area = (one * actuator.piston_area + two * actuator.piston_area_2) / (one + two)
        oil = 1.0 / (actuator.bulk_modulus * (one + two))
        told = float(not actuator.passive)
        gain, compliance = 1.0 + told * self.flow_gain, 1.0 + told * self.compliance
        overlaps = [getattr(known, name) for name in EDGES]
        overlap = told * self.overlap * (any(overlaps) and min(overlaps) >= 0.0)
        play = told * self.play * (known.play > 0.0)
        edges = any(overlaps) or known.play > 0.0
        return Learner(
            area_1=actuator.piston_area,
            area_2=actuator.piston_area_2,
            area=area,
            flow=actuator.flow_gain,
            oil=oil,
            leak=actuator.flow_pressure / area,
            stretch=actuator.membrane_stiffness * oil / area,
            creep=Inverse.of(actuator).creep,
            stroke_lag=lags[0],
            pressure_lag=lags[1],
            least_gain=1.0 / gain,
            most_gain=gain,
            least_compliance=1.0 / compliance,
            most_compliance=compliance,
            least_overlap=-min(overlap, max(min(overlaps), 0.0)),
            most_overlap=overlap,
            least_play=-min(play, known.play),
            most_play=play,
            least_offset=-told * self.null_offset,
            most_offset=told * self.null_offset,
            rate=self.rate,
            low=self.band[0],
            high=self.band[1],
            memory=self.memory,
            prior=self.prior,
            pace=self.pace,
            least=max(self.least, known.band) if edges else self.least,
        )
