"""The state equation of one isolator, composed from its components, compiled.

Everything is handed over by value: states, parameters and inputs of one isolator as small named tuples of floats. Who
calls has unpacked them, from records or from arrays of many machines.
"""

from collections import namedtuple
from typing import Any, NamedTuple

from ehamj.compiled import kernel
from ehamj.isolator.actuator import COMPONENTS
from ehamj.isolator.component import STAGES, At, in_turn
from ehamj.isolator.cylinder import chamber_volumes, oil_force, swept_flows
from ehamj.isolator.edges import chamber_flows, lapped_chamber_flows
from ehamj.isolator.fluid import actual_pressure, chamber_rate, crossing
from ehamj.isolator.membrane import lift
from ehamj.isolator.overlap import edge_openings
from ehamj.isolator.spool import full_stroke, spool_acceleration, spool_target

_PARTS = (*(component.__name__.lower() for component in COMPONENTS), "places")
Isolator: Any = namedtuple("Isolator", _PARTS)  # type: ignore[misc]
"""The values of all components, and for each option with states where they are (0: the isolator has it not)."""


class State(NamedTuple):
    """States of every isolator: spool [mA] and its rate [mA/s], pressures of both chambers [Pa]."""

    spool: float
    spool_rate: float
    pressure_1: float
    pressure_2: float


class Plate(NamedTuple):
    """Motion of the plate over the ground: stroke [m] and its rate [m/s]; and of the ground: height [m], rate [m/s]."""

    stroke: float
    speed: float
    ground: float
    ground_rate: float


_target, _error, _motion, _metering, _opening, _flow, _settled = (in_turn(stage, COMPONENTS) for stage in STAGES)


@kernel
def spool_rates(command, at, states, own):  # type: ignore[no-untyped-def]
    """Rate and acceleration of the spool at a ``command`` [V], and the rates of the options' states."""
    target, rates = _target(spool_target(command, own.spool), at, own, states)
    error, more = _error(target - at.position, at, own, states)
    acceleration = spool_acceleration(error, at.rate, own.spool)
    motion, last = _motion((at.rate, acceleration), at, own, states)
    return motion, rates + more + last


@kernel
def metered(at, states, own):  # type: ignore[no-untyped-def]
    """Position of the metering edges [mA]."""
    return _metering(at.position, at, own, states)[0]


@kernel
def valve_flows(at, pressure_1, pressure_2, feed, states, own):  # type: ignore[no-untyped-def]
    """Flows of the valve, and the rates of the options' states."""
    position, rates = _metering(at.position, at, own, states)
    opening, more = _opening(position, at, own, states)
    opening, last = _flow(full_stroke(opening, at.stroke), at, own, states)
    if own.overlap.lapped == 0.0:
        flows = chamber_flows(opening, pressure_1, pressure_2, feed, own.edges)
    else:
        openings = edge_openings(opening, at.stroke, own.overlap)
        flows = lapped_chamber_flows(openings, pressure_1, pressure_2, feed, own.edges)
    return flows, rates + more + last


@kernel
def isolator_rates(state, states, command, plate, held, time, feed, own):  # type: ignore[no-untyped-def]
    """Time derivatives of an isolator's states and of its options', its flows, and its force on the plate [N].

    Args:
        state: `State`.
        states: of each option with states its own tuple.
        command: [V].
        plate: `Plate`.
        held: where the metering edges stood at the end of the last step [mA].
        time: [s].
        feed: `ehamj.isolator.supply.Feed`.
        own: `Isolator`.
    """
    at = At(state.spool, state.spool_rate, own.spool.spool_stroke, held, time)
    pressure_1 = actual_pressure(state.pressure_1, own.fluid.vapour_pressure)
    pressure_2 = actual_pressure(state.pressure_2, own.fluid.vapour_pressure)
    volume_1, volume_2 = chamber_volumes(plate.stroke, own.cylinder)
    swept_1, swept_2 = swept_flows(plate.speed, own.cylinder)
    (rate, acceleration), rates = spool_rates(command, at, states, own)
    flows, more = valve_flows(at, pressure_1, pressure_2, feed, states, own)
    derivative = State(
        rate,
        acceleration,
        chamber_rate(state.pressure_1, flows.into_1, swept_1, volume_1, own.fluid),
        chamber_rate(state.pressure_2, flows.into_2, swept_2, volume_2, own.fluid),
    )
    still, moving = lift(plate.ground, plate.ground_rate, own.membrane)
    force = oil_force(pressure_1, pressure_2, own.cylinder) + still + moving
    return derivative, rates + more, flows, force


@kernel
def settled(state, held, time, states, own):  # type: ignore[no-untyped-def]
    """What a step leaves to be put right at its end: position and rate of the spool, and where its edges stand."""
    at = At(state.spool, state.spool_rate, own.spool.spool_stroke, held, time)
    (position, rate), _ = _settled((state.spool, state.spool_rate), at, own, states)
    return position, rate, metered(At(position, rate, at.stroke, held, time), states, own)


@kernel
def balance(state, rates, flows, plate, feed, own):  # type: ignore[no-untyped-def]
    """What crosses the border of each chamber, and the powers [W] from the supply and lost over edges."""
    volume_1, volume_2 = chamber_volumes(plate.stroke, own.cylinder)
    swept_1, swept_2 = swept_flows(plate.speed, own.cylinder)
    one = crossing(state.pressure_1, rates.pressure_1, flows.into_1, swept_1, volume_1, own.fluid)
    two = crossing(state.pressure_2, rates.pressure_2, flows.into_2, swept_2, volume_2, own.fluid)
    supplied = feed.supply_pressure * flows.drawn
    drained = feed.tank_pressure * (flows.drawn - (flows.into_1 + flows.into_2))
    throttled = supplied - drained - (one.power + two.power)
    return one, two, supplied, throttled
