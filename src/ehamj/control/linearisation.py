"""What a law knows of its valves, and makes good before the converter: the table [control.linearisation].

The compiled stage is `ehamj.control.compiled.opening`. What it knows is read off the valves of the machine that the law
is held for (`designed_for`; without, the scenario's own), less or more where a share is not one.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final, Literal

from pydantic import Field

from ehamj.control.valves import EDGES, Known, KnownValve
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.flow_curve import POINTS, FlowCurve
from ehamj.isolator.supply import Supply
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative, Positive, Settings

LARGEST_FACTOR: Final = 1.5
"""Of a pressure drop, √(Δp/Δp₀): with all of P_s over one edge it is √2."""


class Linearisation(Settings):
    """What of the valves is made good before the converter, so that the flow is the one that the law wants."""

    pressure_drop: bool = Field(
        True,
        description="divide by what the measured pressures let through; reads chamber_pressure of each mount, absolute",
    )
    supply: Literal["measured", "stated"] = Field(
        "measured",
        description="supply pressure for this: measured (reads supply_pressure), or stated in [supply]",
    )
    flow_curve: bool = Field(True, description="invert the flow curve")
    overlap: NotNegative = Field(1.0, description="share of the overlap, or underlap, of each edge that is made good")
    hysteresis: NotNegative = Field(1.0, description="share of the hysteresis that is made good")
    threshold: NotNegative = Field(1.0, description="share of the threshold that is made good")
    null_offset: NotNegative = Field(1.0, description="share of the null offset that is made good")
    band: Positive = Field(
        0.1, description="wanted opening to each side of null over which the jump across the overlap is spread [mA]"
    )
    quiet: NotNegative = Field(
        0.1,
        description="wanted opening, RMS over the last half second, below which the spool keeps to its side of the "
        "overlap until three times this is wanted of the other (0: never) [mA]",
    )
    reversal: Positive = Field(
        0.1, description="half of the travel of the edges over which the spool is taken through its play [mA]"
    )
    rolloff: Positive = Field(
        3.5e-4, description="time constant, twice, to which the lead of what is added over the valve is rolled off [s]"
    )
    least_drop: float = Field(
        0.1, gt=0, le=1, description="pressure drop, over the rated one, below which the gain rises no further [-]"
    )

    def known(self, plant: Plant) -> tuple[KnownValve, ...]:
        """What is known of the valves of a plant, one per mount."""
        return tuple((NOTHING if one.passive else self)._of(one, plant.supply) for one in plant.actuators)

    def _of(self, actuator: Actuator, supply: Supply) -> KnownValve:
        """What is known of one valve."""
        one, two = actuator.piston_area / actuator.volume_1, actuator.piston_area_2 / actuator.volume_2
        curve = FlowCurve.values_of(actuator)
        numbers = Known(
            valve_gain=actuator.valve_gain,
            valve_frequency=actuator.valve_frequency,
            valve_damping=actuator.valve_damping,
            rolloff=self.rolloff,
            stroke=actuator.spool_stroke,
            reach=min(actuator.spool_stroke, actuator.valve_gain * actuator.voltage_limit),
            supply=supply.pressure,
            supply_measured=float(self.supply == "measured"),
            tank=supply.tank_pressure,
            rated=supply.rating_pressure,
            laminar=actuator.laminar_ratio,
            least=math.sqrt(self.least_drop) if self.pressure_drop else 1.0,
            most=LARGEST_FACTOR if self.pressure_drop else 1.0,
            share=one / (one + two),
            supply_1=self.overlap * actuator.overlap[0],
            tank_1=self.overlap * actuator.overlap[1],
            supply_2=self.overlap * actuator.overlap[2],
            tank_2=self.overlap * actuator.overlap[3],
            band=self.band,
            quiet=self.quiet,
            play=self.threshold * actuator.threshold + 0.5 * self.hysteresis * actuator.hysteresis,
            reversal=self.reversal,
            offset=self.null_offset * actuator.null_offset,
            curved=float(self.flow_curve and curve.curved),
        )
        return KnownValve(numbers, tuple(curve[:POINTS]))


def made_good(plant: Plant, valves: Sequence[KnownValve]) -> Plant:
    """The plant as laws have it behind a stage that knows its valves, outside their overlap: each without what is made
    good of it, its pressure drop as it is at rest. What is believed wrongly, and what happens across the overlap, is in
    `ehamj.control.describing`."""
    if not valves:
        return plant
    own = (_without(one, valve.numbers) for one, valve in zip(plant.actuators, valves, strict=True))
    return replace(plant, actuators=tuple(own))


def _without(actuator: Actuator, known: Known) -> Actuator:
    """A valve without what is made good of it."""
    gone: dict[str, Any] = {"null_offset": actuator.null_offset - known.offset}
    if any(getattr(known, name) for name in EDGES):
        gone["overlap"] = (0.0,) * len(EDGES)
    if known.play:
        gone |= {"hysteresis": 0.0, "threshold": 0.0}
    if known.curved:
        gone["flow_curve"] = ()
    changed = {name: value for name, value in gone.items() if value != getattr(actuator, name)}
    return actuator.with_values(changed) if changed else actuator


NOTHING: Final = Linearisation(
    pressure_drop=False, flow_curve=False, overlap=0.0, hysteresis=0.0, threshold=0.0, null_offset=0.0, quiet=0.0
)
"""Nothing is made good: of a mount that laws leave out, and of valves of which a law only learns."""
