"""What a law knows of its valves, and makes good before the converter: the table [control.linearisation].

The compiled stage is `ehamj.control.compiled.opening`. What it knows is read off the valves of the machine that the law
is held for (`designed_for`; without, the scenario's own), less or more where a share is not one.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final, Literal, NamedTuple, Self

import numpy as np
import scipy.linalg
from pydantic import Field

from ehamj.arrays import Array
from ehamj.control.channels import SUPPLY
from ehamj.control.compiled.opening import Known
from ehamj.control.compiled.stage import Moves
from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.flow_curve import POINTS, FlowCurve
from ehamj.isolator.supply import Supply
from ehamj.plant.axes import CHAMBERS
from ehamj.plant.plant import Plant
from ehamj.settings import NotNegative, Positive, Settings

POSITIVE: Final = ("valve_gain", "valve_frequency", "rolloff", "stroke", "rated", "band", "reversal")
"""What must be positive of a known valve."""

LARGEST_FACTOR: Final = 1.5
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
        if not whole or min(getattr(numbers, name) for name in POSITIVE) <= 0.0:
            raise InputError(
                f"controller.valves: numbers must be finite, {', '.join(POSITIVE)} positive, and curve {POINTS} shares"
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
        0.1, description="wanted opening to each side of null over which the jump across the overlap is spread [mA]"
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
        return tuple(self._of(actuator, plant.supply) for actuator in plant.actuators)

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


class Stage(NamedTuple):
    """The stage as one more law: it samples with the fastest, and what it adds waits as long."""

    period: float
    """[s]"""
    latency: float
    """[s]"""
    states: int = 0
    inputs: tuple[str, ...] = ()

    @classmethod
    def beside(cls, parts: Sequence[Any]) -> Self:
        """Beside laws that have a period and a latency [s]."""
        fastest = min(parts, key=lambda part: (part.period, part.latency))
        return cls(fastest.period, fastest.latency)


def numbers_of(valves: Sequence[KnownValve], period: float) -> Array:
    """What is known, as the compiled stage takes it every ``period`` [s], (valve·`ehamj.control.compiled.stage.KNOWN`)."""
    return np.array([(*one.numbers, *one.curve, *_moves(one.numbers, period)) for one in valves], float).ravel()


def _moves(own: Known, period: float) -> Moves:
    """The stage's states from sample to sample, exact for what is held between."""
    natural, time = own.valve_frequency, own.rolloff
    spool = _held(-(natural**2), -2.0 * own.valve_damping * natural, natural**2, period)
    lag = _held(-1.0 / time**2, -2.0 / time, 1.0 / time**2, period)
    share = 1.0 / (natural * time) ** 2
    return Moves(
        *spool, *lag, 2.0 * time, share, 1.0 - share, 2.0 * own.valve_damping / natural - 2.0 * time * share
    )  # fmt: skip


def _held(stiffness: float, damping: float, gain: float, period: float) -> tuple[float, ...]:
    """ẍ = stiffness·x + damping·ẋ + gain·u with u held: x⁺ and ẋ⁺ of x, ẋ and u each."""
    step = scipy.linalg.expm(np.array([[0.0, 1.0, 0.0], [stiffness, damping, gain], [0.0, 0.0, 0.0]]) * period)
    return tuple(map(float, step[:2].ravel()))
