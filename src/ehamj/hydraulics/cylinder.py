"""The double-acting cylinder: what the chambers receive, and how their pressures answer."""

from ehamj.compiled import kernel
from ehamj.hydraulics.valve import port_flow


@kernel
def chamber_flows(
    spool: float,
    pressure_1: float,
    pressure_2: float,
    supply: float,
    tank: float,
    gain: float,
    spool_stroke: float,
    edge_leakage: float,
    cross_leakage: float,
    laminar_ratio: float,
) -> tuple[float, float, float]:
    """Flow into chamber 1, into chamber 2, and drawn from the supply [m³/s].

    A positive ``spool`` [mA] feeds chamber 1 and drains chamber 2; beyond ``spool_stroke`` the edges open no further.
    Linearised at null with equal chambers it is the paper's eq. 3 with K_C = g₀ + c.
    """
    opening = min(max(spool, -spool_stroke), spool_stroke)
    flow_1, drawn_1 = port_flow(opening, pressure_1, supply, tank, gain, edge_leakage, laminar_ratio)
    flow_2, drawn_2 = port_flow(-opening, pressure_2, supply, tank, gain, edge_leakage, laminar_ratio)
    across = cross_leakage * (pressure_1 - pressure_2)
    return flow_1 - across, flow_2 + across, drawn_1 + drawn_2


@kernel
def pressure_rate(
    inflow: float, swept: float, pressure: float, volume: float, bulk_modulus: float, vapour_pressure: float
) -> float:
    """Rate of a chamber's pressure [Pa/s]: Ṗ = β/V·(Q − V̇) (paper eq. 4).

    ``inflow`` Q [m³/s], ``swept`` V̇ [m³/s], ``volume`` V [m³]. At the vapour pressure the oil cavitates: the pressure
    holds until more flows in than the piston sweeps.
    """
    rate = bulk_modulus / volume * (inflow - swept)
    if pressure <= vapour_pressure and rate < 0.0:
        return 0.0
    return rate
