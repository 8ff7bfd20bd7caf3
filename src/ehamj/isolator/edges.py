"""The valve's four metering edges: turbulent flow, and laminar leakage over them and across the piston."""

import math
from typing import Any, ClassVar, NamedTuple

from pydantic import Field

from ehamj.compiled import kernel
from ehamj.isolator.component import Component
from ehamj.isolator.overlap import Openings
from ehamj.isolator.supply import Feed, Supply
from ehamj.settings import quantity


class Flows(NamedTuple):
    """Flow into chamber 1, into chamber 2, and drawn from the supply [m³/s]."""

    into_1: float
    into_2: float
    drawn: float


class Edges(Component):
    """The valve from its opening to the flows."""

    flow_gain: float = quantity(
        1.94e-6, "m³/s/mA", "K_Q", "flow gain at null: oil to the piston per spool position", "paper", gt=0
    )
    flow_pressure: float = quantity(6.6e-11, "m³/s/Pa", "K_C", "flow-pressure coefficient at null", "paper", ge=0)
    edge_leakage_share: float = quantity(
        0.05,
        "-",
        "g_0/K_C",
        "share of K_C that leaks over the valve's edges; the rest leaks across the piston",
        "assumed",
        ge=0,
        le=1,
    )
    laminar_ratio: float = quantity(
        1e-3, "-", "ε", "pressure drop, over the rated one, below which an edge turns laminar", "assumed", ge=0, le=0.1
    )
    rated_flow: float = quantity(
        0.0,
        "m³/s",
        "q_N",
        "flow of one edge fully open at rated_drop; replaces flow_gain (0: it does not)",
        "assumed",
        ge=0,
    )
    rated_drop: float = quantity(
        35e5, "Pa", "Δp_N", "pressure drop over one edge at which rated_flow holds", "assumed", gt=0
    )

    outside_leakage_1: float = quantity(
        0.0, "m³/s/Pa", "g_1", "conductance of a leak from chamber 1 to outside, at tank pressure", "assumed", ge=0
    )
    outside_leakage_2: float = quantity(0.0, "m³/s/Pa", "g_2", "the same from chamber 2", "assumed", ge=0)
    check_valve: bool = Field(False, description="no oil flows back through the valve into the supply")

    takes: ClassVar[Any] = (
        "flow_gain", "edge_leakage", "cross_leakage", "laminar_ratio", "outside_leakage_1", "outside_leakage_2",
        "check_valve",
    )  # fmt: skip

    @property
    def edge_leakage(self) -> float:
        """Laminar conductance of each of the four edges, g₀ [m³/s/Pa]."""
        return self.edge_leakage_share * self.flow_pressure

    @property
    def cross_leakage(self) -> float:
        """Laminar conductance across the piston, c = K_C − g₀ [m³/s/Pa]."""
        return (1.0 - self.edge_leakage_share) * self.flow_pressure

    def rated_gain(self, stroke: float, supply: Supply) -> float:
        """Flow gain from rated-flow data [m³/s/mA], K_Q = q_N/x_max·√(Δp₀/Δp_N), at a full stroke [mA]."""
        return self.rated_flow / stroke * math.sqrt(supply.rating_pressure / self.rated_drop)


@kernel
def turbulence(ratio: float, laminar_ratio: float) -> float:
    """Orifice law φ(r) = r/(r² + ε²)^¼: √r, signed, with a smooth laminar end; ε = 0 is the plain signed root."""
    # The last term only keeps 0/0 away; it is far below the square of any pressure ratio.
    return ratio / math.sqrt(math.sqrt(ratio * ratio + laminar_ratio * laminar_ratio + 1e-300))


@kernel
def port_flow(opening: float, pressure: float, feed: Feed, own: "Edges") -> tuple[float, float]:
    """Flow into a port, and the part of it that the supply gives [m³/s].

    ``opening`` [mA] connects the port to the supply where positive and to the tank where negative; K_Q holds at the
    rated drop Δp₀ = (P_s − P_t)/2; g₀ is the laminar conductance of each of the port's two edges.
    """
    # One orifice serves both directions: the root is most of the cost of a step, and a branch would double it.
    drop = feed.supply_pressure - pressure if opening > 0.0 else pressure - feed.tank_pressure
    # 1/rated is shared by both ports of a valve.
    through = own.flow_gain * opening * turbulence(drop * (1.0 / feed.rated_pressure), own.laminar_ratio)
    drawn = own.edge_leakage * (feed.supply_pressure - pressure)
    if own.check_valve != 0.0 and feed.supply_pressure < pressure:
        drawn = 0.0
        if opening > 0.0:
            through = 0.0
    drained = own.edge_leakage * (pressure - feed.tank_pressure)
    return through + drawn - drained, drawn + (through if opening > 0.0 else 0.0)


@kernel
def lapped_port_flow(feeding: float, draining: float, pressure: float, feed: Feed, own: "Edges") -> tuple[float, float]:
    """As `port_flow`, for edges that open on their own: ``feeding`` from the supply, ``draining`` to the tank [mA]."""
    above, below = feed.supply_pressure - pressure, pressure - feed.tank_pressure
    if own.check_valve != 0.0:
        above = max(above, 0.0)
    in_turbulent = own.flow_gain * feeding * turbulence(above / feed.rated_pressure, own.laminar_ratio)
    out_turbulent = own.flow_gain * draining * turbulence(below / feed.rated_pressure, own.laminar_ratio)
    drawn, drained = in_turbulent + own.edge_leakage * above, out_turbulent + own.edge_leakage * below
    return drawn - drained, drawn


@kernel
def leaked(pressure_1: float, pressure_2: float, feed: Feed, own: "Edges") -> tuple[float, float]:
    """What leaves chambers 1 and 2 across the piston and to outside [m³/s]."""
    across = own.cross_leakage * (pressure_1 - pressure_2)
    return (
        across + own.outside_leakage_1 * (pressure_1 - feed.tank_pressure),
        own.outside_leakage_2 * (pressure_2 - feed.tank_pressure) - across,
    )


@kernel
def chamber_flows(opening: float, pressure_1: float, pressure_2: float, feed: Feed, own: "Edges") -> Flows:
    """Flows of a valve without overlap.

    A positive ``opening`` [mA] feeds chamber 1 and drains chamber 2. Linearised at null with equal chambers it is the
    paper's eq. 3 with K_C = g₀ + c.
    """
    flow_1, drawn_1 = port_flow(opening, pressure_1, feed, own)
    flow_2, drawn_2 = port_flow(-opening, pressure_2, feed, own)
    lost_1, lost_2 = leaked(pressure_1, pressure_2, feed, own)
    return Flows(flow_1 - lost_1, flow_2 - lost_2, drawn_1 + drawn_2)


@kernel
def lapped_chamber_flows(edges: Openings, pressure_1: float, pressure_2: float, feed: Feed, own: "Edges") -> Flows:
    """As `chamber_flows`, for edges with overlap."""
    flow_1, drawn_1 = lapped_port_flow(edges.feeds_1, edges.drains_1, pressure_1, feed, own)
    flow_2, drawn_2 = lapped_port_flow(edges.feeds_2, edges.drains_2, pressure_2, feed, own)
    lost_1, lost_2 = leaked(pressure_1, pressure_2, feed, own)
    return Flows(flow_1 - lost_1, flow_2 - lost_2, drawn_1 + drawn_2)
