"""What a law knows of its valves, and makes good before the converter: the table [control.linearisation].

The compiled stage is `ehamj.control.compiled.opening`. What it knows is read off the valves of the machine that the law
is held for (`designed_for`; without, the scenario's own), less or more where a share is not one.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field

from ehamj.arrays import Array
from ehamj.control.channels import SUPPLY
from ehamj.control.compiled.opening import SIZE, Known
from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.flow_curve import POINTS, FlowCurve
from ehamj.isolator.supply import Supply
from ehamj.plant.axes import CHAMBERS
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative, Positive, Settings

LARGEST_FACTOR = 1.5
"""Of a pressure drop, √(Δp/Δp₀): with all of P_s over one edge it is √2."""


class KnownValve(NamedTuple):
    """What is known of one valve."""

    numbers: Known
    curve: tuple[float, ...]
    """Shares of the full flow at equal shares of the stroke."""

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {**self.numbers._asdict(), "curve": list(self.curve)}

    @classmethod
    def from_dict(cls, table: Any) -> Self:
        """The inverse of `to_dict`.

        Raises:
            InputError: if a key is missing or unknown, or a number is not one.
        """
        keys = (*Known._fields, "curve")
        if not isinstance(table, Mapping) or set(table) != set(keys):
            raise InputError(f"controller.valves: each must be a table of {', '.join(keys)}")
        try:
            numbers = Known(*(float(table[name]) for name in Known._fields))
            curve = tuple(float(share) for share in table["curve"])
        except (TypeError, ValueError) as error:
            raise InputError(f"controller.valves: {error}; every entry must be a number") from error
        whole = np.isfinite([*numbers, *curve]).all() and len(curve) == POINTS
        if not whole or min(numbers.valve_gain, numbers.stroke, numbers.rated, numbers.band, numbers.reversal) <= 0.0:
            raise InputError(
                f"controller.valves: numbers must be finite, valve_gain, stroke, rated, band and reversal positive, "
                f"and curve {POINTS} shares"
            )
        return cls(numbers, curve)


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
        0.02, description="wanted opening to each side of null over which the jump across the overlap is spread [mA]"
    )
    reversal: Positive = Field(
        0.1, description="half of the travel of the edges over which the spool is taken through its play [mA]"
    )
    least_drop: float = Field(
        0.1, gt=0, le=1, description="pressure drop, over the rated one, below which the gain rises no further [-]"
    )

    def known(self, plant: Plant) -> tuple[KnownValve, ...]:
        """What is known of the valves of a plant, one per mount."""
        return tuple(self._of(actuator, plant.supply) for actuator in plant.actuators)

    def _of(self, actuator: Actuator, supply: Supply) -> KnownValve:
        """What is known of one valve."""
        one, two = actuator.piston_area / actuator.volume_1, actuator.piston_area_2 / actuator.volume_2
        curve = FlowCurve.values_of(actuator)
        numbers = Known(
            valve_gain=actuator.valve_gain,
            stroke=actuator.spool_stroke,
            reach=min(actuator.spool_stroke, actuator.valve_gain * actuator.voltage_limit),
            supply=supply.pressure,
            supply_measured=float(self.supply == "measured"),
            tank=supply.tank_pressure,
            rated=supply.rating_pressure,
            laminar=actuator.laminar_ratio,
            least=float(np.sqrt(self.least_drop)) if self.pressure_drop else 1.0,
            most=LARGEST_FACTOR if self.pressure_drop else 1.0,
            share=one / (one + two),
            supply_1=self.overlap * actuator.overlap[0],
            tank_1=self.overlap * actuator.overlap[1],
            supply_2=self.overlap * actuator.overlap[2],
            tank_2=self.overlap * actuator.overlap[3],
            band=self.band,
            play=self.threshold * actuator.threshold + 0.5 * self.hysteresis * actuator.hysteresis,
            reversal=self.reversal,
            offset=self.null_offset * actuator.null_offset,
            curved=float(self.flow_curve and curve.curved),
        )
        return KnownValve(numbers, tuple(curve[:POINTS]))


def measured(valves: Sequence[KnownValve], mounts: Sequence[str]) -> tuple[str, ...]:
    """Channels that are read to make good what is known of valves: their absolute chamber pressures, or none."""
    if all(valve.numbers.least >= valve.numbers.most for valve in valves):
        return ()
    chambers = tuple(f"chamber_pressure {mount} {chamber}" for mount in mounts for chamber in CHAMBERS)
    return (*chambers, SUPPLY) if any(valve.numbers.supply_measured for valve in valves) else chambers


def numbers_of(valves: Sequence[KnownValve]) -> Array:
    """What is known, as the compiled stage takes it, (valve·`SIZE`)."""
    found = np.array([(*valve.numbers, *valve.curve) for valve in valves], float)
    assert found.size == len(valves) * SIZE
    return found.ravel()
