"""The isolators of many lanes: the equations of `ehamj.isolator`, fed from and to memory of lanes.

Of each mount there is a block: its values (`ehamj.memory.ISOLATOR`), then what it exchanges (`EXCHANGE`); a field has
one number per lane. Isolators are computed in the simplest form that gives all lanes' bits (`PLAIN` to `ANY`).
"""

from collections.abc import Collection
from functools import cache
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.compiled import kernel, written
from ehamj.compiled.lanes import peek, poke, set_lanes
from ehamj.isolator.actuator import COMPONENTS, OPTIONS, Actuator
from ehamj.isolator.component import Component
from ehamj.isolator.equations import WHOLE, Equations, Isolator, State, equations, lapped_flows, settled, unlapped_flows
from ehamj.isolator.fluid import liquid_rate
from ehamj.isolator.spool import Command
from ehamj.isolator.supply import Feed
from ehamj.memory import ISOLATOR, PLACES, RATE_ORDER, size

EXCHANGE: Final = (
    "stroke",  # [m]
    "speed",  # [m/s]
    "command",  # [V]
    "switching",  # what is added to it within the valve's range, of a command that switches within the step [V]
    "supply_pressure",  # [Pa]
    "metering",  # where the metering edges stood at the end of the last step [mA]
    "into_1",  # flow into the chambers [m³/s]
    "into_2",
    "drawn",  # from the supply [m³/s]
    "force",  # of the oil on the plate, over that at rest [N]
    "rest",  # the force at rest [N]
    "at_command_limit",  # states that were counted there
    "at_spool_limit",
    "at_drive_limit",
    "cavitating",
    "taken",  # drawn from the shared supply [m³/s]
    *State._fields,
    *(f"{state}'" for state in State._fields),  # their rates
)
"""Of each mount: what its isolator is given at a stage, and what it gives back."""

EXCHANGE_AT: Final = size(ISOLATOR)
BLOCK: Final = EXCHANGE_AT + len(EXCHANGE)
"""Numbers of a mount in each lane."""
OWN: Final = len(State._fields)
"""States of an isolator."""

_SLOT: Final = {name: EXCHANGE_AT + number for number, name in enumerate(EXCHANGE)}
STROKE, SPEED, COMMAND, SWITCHING, SUPPLY, METERING, INTO_1, INTO_2, DRAWN, FORCE, REST, AT_LIMIT, TAKEN, STATE = (
    _SLOT[name] for name in (
        "stroke", "speed", "command", "switching", "supply_pressure", "metering", "into_1", "into_2", "drawn", "force",
        "rest", "at_command_limit", "taken", State._fields[0],
    )
)  # fmt: skip
RATE: Final = STATE + len(State._fields)

PLAIN, OPEN, LAPPED, ANY = range(4)
"""Forms of the equations: without options, with options that are arithmetic, with overlap too, and of any isolator."""

SLOW: Final = tuple(option for option in OPTIONS if not option.arithmetic or option.State is not None)
"""Options whose isolators go one by one."""

AT: Final = {name: number for number, name in enumerate(ISOLATOR.names or ())}


def _peeked(name: str, values: Any) -> str:
    return f"{name}({', '.join(f'peek(values, at + {AT[field]} * len(lanes))' for field in values._fields)})"


def _unpacker(absent: Collection[type[Component]] = ()) -> Any:
    """The kernel that takes an isolator from its block; of components that are absent it leaves nothing."""
    scope: dict[str, Any] = {"peek": peek, "Isolator": Isolator}
    parts = []
    for component in COMPONENTS:
        scope[component.__name__] = component.Values
        parts.append("0.0" if component in absent else _peeked(component.__name__, component.Values))
    places = "".join(f"peek(values, at + {AT[field]} * len(lanes)), " for field in PLACES.values())
    return written("values, at, lanes", f"return Isolator({', '.join(parts)}, ({places}))", **scope)


def _option_states() -> Any:
    """The kernel that takes the options' states from the activations of a lane."""
    scope: dict[str, Any] = {"peek": peek}
    parts = ""
    for option, field in PLACES.items():
        scope[option.__name__] = option.State
        place = f"int(peek(values, at + {AT[field]} * len(lanes)))"
        own = ", ".join(f"peek(state, first + ({place} + {j}) * len(lanes))" for j in range(len(option.State._fields)))
        parts += f"{option.__name__}({own}), "
    return written("values, at, state, first, lanes", f"return ({parts})", **scope)


def _put_option_rates() -> Any:
    """The kernel that writes the rates of those states."""
    scope: dict[str, Any] = {"peek": peek, "poke": poke, "only": _only}
    body, number = [], 0
    for option in RATE_ORDER:
        place = f"int(peek(values, at + {AT[PLACES[option]]} * len(lanes)))"
        for j in range(len(option.State._fields)):
            body.append(f"only({place} > 0, rate, first + ({place} + {j}) * len(lanes), rates[{number}])")
            number += 1
    return written(
        "rates, values, at, rate, first, lanes", f"return ({''.join(part + ', ' for part in body)})", **scope
    )


@kernel
def _only(there, rate, place, value):  # type: ignore[no-untyped-def]
    if there:
        poke(rate, place, value)
    return 0.0


@kernel
def state_in(blocks, y, lanes):  # type: ignore[no-untyped-def]
    """The `State` that begins at a place."""
    w = len(lanes)
    return State(peek(blocks, y), peek(blocks, y + w), peek(blocks, y + 2 * w), peek(blocks, y + 3 * w))


def _stage(kernels: Equations, absent: Collection[type[Component]], options: bool) -> Any:
    """The kernel that computes one mount of all lanes: rates of its states, flows, force."""
    unpacked, rates_of = _unpacker(absent), kernels.rates

    @kernel
    def stage(blocks, state, rate, acts, mount, time, lanes):  # type: ignore[no-untyped-def]
        w = len(lanes)
        for lane in range(w):
            at = mount * BLOCK * w + lane
            own = unpacked(blocks, at, lanes)
            states = _states(blocks, at, state, acts * w + lane, lanes) if options else NONE
            feed = Feed(peek(blocks, at + SUPPLY * w), peek(blocks, at + TANK * w), peek(blocks, at + RATED * w))
            derivative, more, flows, force = rates_of(
                state_in(blocks, at + STATE * w, lanes),
                states,
                Command(peek(blocks, at + COMMAND * w), peek(blocks, at + SWITCHING * w)),
                peek(blocks, at + STROKE * w),
                peek(blocks, at + SPEED * w),
                peek(blocks, at + METERING * w),
                time,
                feed,
                own,
            )
            y = at + RATE * w
            poke(blocks, y, derivative.spool)
            poke(blocks, y + w, derivative.spool_rate)
            poke(blocks, y + 2 * w, derivative.pressure_1)
            poke(blocks, y + 3 * w, derivative.pressure_2)
            poke(blocks, at + INTO_1 * w, flows.into_1)
            poke(blocks, at + INTO_2 * w, flows.into_2)
            poke(blocks, at + DRAWN * w, flows.drawn)
            poke(blocks, at + FORCE * w, force - peek(blocks, at + REST * w))
            if options:
                _put(more, blocks, at, rate, acts * w + lane, lanes)

    return stage


TANK, RATED, VAPOUR = AT["tank_pressure"], AT["rated_pressure"], AT["vapour_pressure"]
NONE: Final = ()
isolator_in: Final = _unpacker()
"""`Isolator` of a lane's block."""
_states, _put = _option_states(), _put_option_rates()
_plain = _stage(equations(OPTIONS, unlapped_flows, liquid_rate), OPTIONS, False)
_open = _stage(equations(SLOW, unlapped_flows, liquid_rate), SLOW, False)
_lapped = _stage(equations(SLOW, lapped_flows, liquid_rate), SLOW, False)
_any = _stage(WHOLE, (), True)


@kernel
def _load(blocks, state, acts, mount, lanes):  # type: ignore[no-untyped-def]
    """Copy the states of a mount into its block; whether any lane has a void there.

    In one block, at constant distances, the compiler sees that nothing overlaps.
    """
    w, found = len(lanes), 0
    for k in range(OWN):
        set_lanes(blocks, mount * BLOCK + STATE + k, state, acts + mount * OWN + k, lanes)
    for lane in range(w):
        at = mount * BLOCK * w + lane
        vapour = peek(blocks, at + VAPOUR * w)
        found |= (peek(blocks, at + (STATE + 2) * w) < vapour) | (peek(blocks, at + (STATE + 3) * w) < vapour)
    return found


@kernel
def isolators(forms, blocks, state, rate, acts, time, lanes):  # type: ignore[no-untyped-def]
    """Rates of the states of all isolators in all lanes, their flows and forces.

    ``forms`` (mount,) is the simplest form that serves all lanes; ``acts`` where the activations begin in ``state`` and
    ``rate``. What cavitates is computed in full.
    """
    for mount in range(forms.size):
        form = forms[mount]
        void = _load(blocks, state, acts, mount, lanes)
        if form == ANY or void:
            _any(blocks, state, rate, acts, mount, time, lanes)
        elif form == PLAIN:
            _plain(blocks, state, rate, acts, mount, time, lanes)
        elif form == OPEN:
            _open(blocks, state, rate, acts, mount, time, lanes)
        else:
            _lapped(blocks, state, rate, acts, mount, time, lanes)
        for k in range(OWN):
            set_lanes(rate, acts + mount * OWN + k, blocks, mount * BLOCK + RATE + k, lanes)


@kernel
def settle(forms, blocks, state, acts, time, lanes):  # type: ignore[no-untyped-def]
    """What a step leaves to be put right at its end: spools at their stops, and where hysteresis holds the edges."""
    w = len(lanes)
    for mount in range(forms.size):
        first = (acts + mount * OWN) * w
        if forms[mount] == PLAIN:
            set_lanes(blocks, mount * BLOCK + METERING, state, acts + mount * OWN, lanes)
        else:
            for lane in range(w):
                at, y = mount * BLOCK * w + lane, first + lane
                states = _states(blocks, at, state, acts * w + lane, lanes)
                held, own = peek(blocks, at + METERING * w), isolator_in(blocks, at, lanes)
                spool, rate, edges = settled(state_in(state, y, lanes), held, time, states, own)
                poke(state, y, spool)
                poke(state, y + w, rate)
                poke(blocks, at + METERING * w, edges)


@cache
def _usual() -> dict[str, float]:
    """The record of an isolator whose options are all off."""
    return Actuator().record()


def form_of(record: Any) -> int:
    """The simplest form for an isolator's record (`ehamj.memory.ISOLATOR`)."""
    usual = _usual()
    off = {option: all(record[name] == usual[name] for name in option.Values._fields) for option in OPTIONS}
    if record["air_fraction"] != 0.0 or not all(off[option] for option in SLOW):
        return ANY
    if all(off.values()):
        return PLAIN
    return LAPPED if record["lapped"] != 0.0 else OPEN


def forms_of(records: Collection[Any]) -> Array:
    """Of each mount the form that serves every lane; ``records`` are those of the isolators of each lane, (mount,)."""
    return np.max([[form_of(record) for record in lane] for lane in records], axis=0)
