"""The double-acting cylinder: what its two chambers receive from the valve, and lose across the piston."""

from ehamj.compiled import kernel
from ehamj.isolator.valve import lapped_port_flow, port_flow


@kernel
def chamber_flows(
    opening: float,
    pressure_1: float,
    pressure_2: float,
    supply: float,
    tank: float,
    rated: float,
    gain: float,
    edge_leakage: float,
    cross_leakage: float,
    laminar_ratio: float,
) -> tuple[float, float, float]:
    """Flow into chamber 1, into chamber 2, and drawn from the supply [m³/s].

    A positive ``opening`` [mA] feeds chamber 1 and drains chamber 2. Linearised at null with equal chambers it is the
    paper's eq. 3 with K_C = g₀ + c. ``rated`` is the drop per edge at which the gain holds [Pa].
    """
    flow_1, drawn_1 = port_flow(opening, pressure_1, supply, tank, rated, gain, edge_leakage, laminar_ratio)
    flow_2, drawn_2 = port_flow(-opening, pressure_2, supply, tank, rated, gain, edge_leakage, laminar_ratio)
    across = cross_leakage * (pressure_1 - pressure_2)
    return flow_1 - across, flow_2 + across, drawn_1 + drawn_2


@kernel
def lapped_chamber_flows(
    opening: float,
    laps: tuple[float, float, float, float],
    stroke: float,
    pressure_1: float,
    pressure_2: float,
    supply: float,
    tank: float,
    rated: float,
    gain: float,
    edge_leakage: float,
    cross_leakage: float,
    laminar_ratio: float,
) -> tuple[float, float, float]:
    """As `chamber_flows`, for edges with overlap: ``laps`` of supply–1, 1–tank, supply–2 and 2–tank [mA].

    An edge opens beyond its overlap (before null, where negative), and no further than ``stroke`` [mA].
    """
    feeds_1, drains_1 = min(max(opening - laps[0], 0.0), stroke), min(max(-opening - laps[1], 0.0), stroke)
    feeds_2, drains_2 = min(max(-opening - laps[2], 0.0), stroke), min(max(opening - laps[3], 0.0), stroke)
    flow_1, drawn_1 = lapped_port_flow(
        feeds_1, drains_1, pressure_1, supply, tank, rated, gain, edge_leakage, laminar_ratio
    )
    flow_2, drawn_2 = lapped_port_flow(
        feeds_2, drains_2, pressure_2, supply, tank, rated, gain, edge_leakage, laminar_ratio
    )
    across = cross_leakage * (pressure_1 - pressure_2)
    return flow_1 - across, flow_2 + across, drawn_1 + drawn_2
