"""What a law knows of one valve: numbers that its file holds, and what they make it read."""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, Final, NamedTuple, Self

from ehamj.control.channels import SUPPLY
from ehamj.control.tables import number_in
from ehamj.errors import InputError
from ehamj.isolator.flow_curve import POINTS
from ehamj.plant.axes import CHAMBERS

POSITIVE: Final = ("valve_gain", "valve_frequency", "rolloff", "stroke", "rated", "band", "reversal")
"""What must be positive of a known valve."""
EDGES: Final = ("supply_1", "tank_1", "supply_2", "tank_2")
"""Its overlaps."""


class Known(NamedTuple):
    """What is known of one valve; its curve follows in memory."""

    valve_gain: float
    """K_v [mA/V]."""
    valve_frequency: float
    """ω [rad/s]."""
    valve_damping: float
    """ζ."""
    rolloff: float
    """τ [s] of what is added."""
    stroke: float
    """x_max [mA]."""
    reach: float
    """How far its own range of commands takes the spool [mA]."""
    supply: float
    """P_s [Pa], where it is not measured."""
    supply_measured: float
    """1 where it is, 0 where it is not."""
    tank: float
    """P_t [Pa]."""
    rated: float
    """Δp₀ [Pa]."""
    laminar: float
    """ε [-]."""
    least: float
    """Smallest φ that is made good [-]; 1: none is, and the law reads no pressure."""
    most: float
    """Largest φ [-]."""
    share: float
    """a [-]."""
    supply_1: float
    """Overlaps of the edges [mA]."""
    tank_1: float
    supply_2: float
    tank_2: float
    band: float
    """Wanted opening to each side of null over which its jump is spread [mA]."""
    quiet: float
    """Wanted opening, RMS, below which the spool keeps to its side of the overlap [mA]; 0: never."""
    play: float
    """How far the spool leads the edges [mA]."""
    reversal: float
    """Half of the travel over which the lead changes sides [mA]."""
    offset: float
    """Opening with the spool centred, x_n [mA]."""
    curved: float
    """1 where a curve is known, 0 where it is straight."""


class KnownValve(NamedTuple):
    """What is known of one valve."""

    numbers: Known
    curve: tuple[float, ...]
    """Shares of the full flow at equal shares of the stroke."""

    @property
    def reads_pressure(self) -> bool:
        """Whether its pressure drop is made good."""
        return self.numbers.least < self.numbers.most

    @property
    def makes_good(self) -> tuple[str, ...]:
        """What of the valve is made good, in words."""
        own = self.numbers
        found = {
            "pressure drop": self.reads_pressure,
            "flow curve": bool(own.curved),
            "overlap": any(getattr(own, name) for name in EDGES),
            "play": own.play > 0.0,
            "null offset": own.offset != 0.0,
        }
        return tuple(words for words, so in found.items() if so)

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
        numbers = Known(*(number_in(table[name], f"controller.valves.{name}") for name in Known._fields))
        if not isinstance(table["curve"], Sequence) or isinstance(table["curve"], str):
            raise InputError("controller.valves: curve must be a list of numbers")
        curve = tuple(number_in(one, f"controller.valves.curve.{k}") for k, one in enumerate(table["curve"]))
        whole = all(map(math.isfinite, (*numbers, *curve))) and len(curve) == POINTS
        if not whole or min(getattr(numbers, name) for name in POSITIVE) <= 0.0:
            raise InputError(
                f"controller.valves: numbers must be finite, {', '.join(POSITIVE)} positive, and curve {POINTS} shares"
            )
        rises = curve[0] == 0.0 and curve[-1] == 1.0 and all(one <= next_ for one, next_ in pairwise(curve))
        if not (
            rises
            and 0.0 < numbers.share < 1.0
            and 0.0 < numbers.least <= numbers.most
            and min(numbers.play, numbers.quiet) >= 0.0
        ):
            raise InputError(
                "controller.valves: curve must rise from 0 to 1, share lie between 0 and 1, least between 0 and most, "
                "and play and quiet be zero or positive"
            )
        return cls(numbers, curve)


def measured(valves: Sequence[KnownValve], mounts: Sequence[str], learning: bool = False) -> tuple[str, ...]:
    """Channels that are read to make good what is known of valves, or to learn of them: their absolute chamber
    pressures, or none."""
    read = [(one, mount) for one, mount in zip(valves, mounts, strict=False) if learning or one.reads_pressure]
    chambers = tuple(name for _, mount in read for name in chambers_of(mount))
    fed = any(one.reads_pressure and one.numbers.supply_measured for one, _ in read)
    return (*chambers, SUPPLY) if fed else chambers


def chambers_of(mount: str) -> tuple[str, ...]:
    """Channels of the chamber pressures of a mount."""
    return tuple(f"chamber_pressure {mount} {chamber}" for chamber in CHAMBERS)
