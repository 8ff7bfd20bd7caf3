"""How compiled code takes the records of `ehamj.memory` apart, and puts back what it found."""

from typing import Any

from ehamj.compiled import kernel, written
from ehamj.isolator.actuator import COMPONENTS
from ehamj.isolator.equations import Isolator, State
from ehamj.isolator.supply import Feed, Supply, SupplyState
from ehamj.memory import PLACES, RATE_ORDER, Cubic


def _made(name: str, values: Any) -> str:
    """Source that makes a named tuple of a record with fields of its names."""
    return f"{name}({', '.join(f'row.{field}' for field in values._fields)})"


def unpacker(values: Any) -> Any:
    """The kernel that does so."""
    return written("row", f"return {_made('values', values)}", values=values)


def _unpack_isolator() -> Any:
    values = {component.__name__: component.Values for component in COMPONENTS}
    parts = ", ".join(_made(*each) for each in values.items())
    places = "".join(f"row.{field}, " for field in PLACES.values())
    return written("row", f"return Isolator({parts}, ({places}))", Isolator=Isolator, **values)


def _unpack_options() -> Any:
    states = {option.__name__: option.State for option in PLACES}
    parts = ""
    for option, field in PLACES.items():
        own = ", ".join(f"act[int(row.{field}) + {j}]" for j in range(len(option.State._fields)))
        parts += f"{option.__name__}({own}), "
    return written("act, row", f"return ({parts})", **states)


def _pack_options() -> Any:
    body = ["pass"]
    for option in RATE_ORDER:
        place = f"row.{PLACES[option]}"
        for j in range(len(option.State._fields)):
            body.append(f"if {place} > 0.0: act_dot[int({place}) + {j}] = rates[{len(body) - 1}]")
    return written("rates, act_dot, row", *body)


isolator_of = _unpack_isolator()
"""`ehamj.isolator.equations.Isolator` of a record."""
options_of = _unpack_options()
"""States of the options of an isolator from the activations and its record: a tuple of each option's own."""
put_options = _pack_options()
"""Write the rates of those states."""
state_of, feed_of, cubic_of = unpacker(State), unpacker(Feed), unpacker(Cubic)
supply_of, supply_state_of = unpacker(Supply.Values), unpacker(SupplyState)


@kernel
def put_cubic(cubic, start, end):  # type: ignore[no-untyped-def]
    """Write a cubic from value and slope·step at its start and at its end."""
    cubic.value, cubic.slope, cubic.end_value, cubic.end_slope = start[0], start[1], end[0], end[1]


@kernel
def through(start: float, middle: float, end: float, s: float) -> float:
    """Value at the fraction ``s`` of the step of what is known at the times at which the integrator asks."""
    bend = 2.0 * (start - 2.0 * middle + end)
    return start + s * (end - start + (s - 1.0) * bend)


@kernel
def hermite(cubic: Cubic, s: float) -> tuple[float, float]:
    """Value and slope·step of a cubic at the fraction ``s`` of the step."""
    rise = cubic.end_value - cubic.value
    c = 3.0 * rise - 2.0 * cubic.slope - cubic.end_slope
    d = cubic.slope + cubic.end_slope - 2.0 * rise
    return cubic.value + s * (cubic.slope + s * (c + s * d)), cubic.slope + s * (2.0 * c + 3.0 * s * d)
