"""The state equation of one isolator, composed from its components, compiled.

Everything is handed over by value: states, parameters and inputs of one isolator as small named tuples of floats. Who
calls has unpacked them, from records or from arrays of many machines.
"""

from collections import namedtuple
from collections.abc import Collection
from typing import Any, Final, NamedTuple

from ehamj.compiled import kernel
from ehamj.isolator.actuator import COMPONENTS
from ehamj.isolator.component import STAGES, At, Component, in_turn
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


class Equations(NamedTuple):
    """Kernels of an isolator."""

    rates: Any
    """(state, states, command, stroke, speed, held, time, feed, own) → derivative, rates of options, flows, oil force.

    - state: `State`; states: of each option with states its own tuple.
    - command: [V]; stroke, speed: of the plate over the ground [m, m/s].
    - held: where the metering edges stood at the end of the last step [mA]; time: [s].
    - feed: `ehamj.isolator.supply.Feed`; own: `Isolator`.
    - oil force: on the plate [N].
    """
    settled: Any
    """(state, held, time, states, own) → what a step leaves to be put right at its end: position and rate of the spool,
    and where its edges stand."""


@kernel
def any_flows(opening, stroke, pressure_1, pressure_2, feed, own):  # type: ignore[no-untyped-def]
    """Flows of a valve, with overlap or without."""
    if own.overlap.lapped == 0.0:
        return unlapped_flows(opening, stroke, pressure_1, pressure_2, feed, own)
    return lapped_flows(opening, stroke, pressure_1, pressure_2, feed, own)


@kernel
def unlapped_flows(opening, stroke, pressure_1, pressure_2, feed, own):  # type: ignore[no-untyped-def]
    """Flows of a valve without overlap."""
    return chamber_flows(opening, pressure_1, pressure_2, feed, own.edges)


@kernel
def lapped_flows(opening, stroke, pressure_1, pressure_2, feed, own):  # type: ignore[no-untyped-def]
    """Flows of a valve with overlap."""
    openings = edge_openings(opening, stroke, own.overlap)
    return lapped_chamber_flows(openings, pressure_1, pressure_2, feed, own.edges)


def equations(absent: Collection[type[Component]] = (), flows_of: Any = any_flows, chamber: Any = chamber_rate) -> Any:
    """The kernels of isolators, composed.

    Args:
        absent: options that none of them has.
        flows_of: of their edges.
        chamber: rate of a chamber's pressure.
    """
    target, error, motion, metering, opening, flow, at_end = (in_turn(stage, COMPONENTS, absent) for stage in STAGES)

    @kernel
    def spool_rates(command, at, states, own):  # type: ignore[no-untyped-def]
        wanted, rates = target(spool_target(command, own.spool), at, own, states)
        driving, more = error(wanted - at.position, at, own, states)
        acceleration = spool_acceleration(driving, at.rate, own.spool)
        moves, last = motion((at.rate, acceleration), at, own, states)
        return moves, rates + more + last

    @kernel
    def valve_flows(at, pressure_1, pressure_2, feed, states, own):  # type: ignore[no-untyped-def]
        position, rates = metering(at.position, at, own, states)
        opened, more = opening(position, at, own, states)
        opened, last = flow(full_stroke(opened, at.stroke), at, own, states)
        return flows_of(opened, at.stroke, pressure_1, pressure_2, feed, own), rates + more + last

    @kernel
    def rates(state, states, command, stroke, speed, held, time, feed, own):  # type: ignore[no-untyped-def]
        at = At(state.spool, state.spool_rate, own.spool.spool_stroke, held, time)
        pressure_1 = actual_pressure(state.pressure_1, own.fluid.vapour_pressure)
        pressure_2 = actual_pressure(state.pressure_2, own.fluid.vapour_pressure)
        volume_1, volume_2 = chamber_volumes(stroke, own.cylinder)
        swept_1, swept_2 = swept_flows(speed, own.cylinder)
        (rate, acceleration), of_options = spool_rates(command, at, states, own)
        flows, more = valve_flows(at, pressure_1, pressure_2, feed, states, own)
        derivative = State(
            rate,
            acceleration,
            chamber(state.pressure_1, flows.into_1, swept_1, volume_1, own.fluid),
            chamber(state.pressure_2, flows.into_2, swept_2, volume_2, own.fluid),
        )
        return derivative, of_options + more, flows, oil_force(pressure_1, pressure_2, own.cylinder)

    @kernel
    def settled(state, held, time, states, own):  # type: ignore[no-untyped-def]
        at = At(state.spool, state.spool_rate, own.spool.spool_stroke, held, time)
        (position, rate), _ = at_end((state.spool, state.spool_rate), at, own, states)
        edges = metering(position, At(position, rate, at.stroke, held, time), own, states)[0]
        return position, rate, edges

    return Equations(rates, settled)


WHOLE: Final = equations()
"""Of any isolator."""

oil_rates, settled = WHOLE


@kernel
def isolator_rates(state, states, command, plate, held, time, feed, own):  # type: ignore[no-untyped-def]
    """As `Equations.rates`, for the motion of a `Plate`; its force is the ground's on the membrane too."""
    derivative, rates, flows, force = oil_rates(
        state, states, command, plate.stroke, plate.speed, held, time, feed, own
    )
    still, moving = lift(plate.ground, plate.ground_rate, own.membrane)
    return derivative, rates, flows, force + still + moving


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
