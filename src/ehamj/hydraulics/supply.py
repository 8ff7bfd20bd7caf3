"""One supply for all actuators: a pump with a flow limit, an accumulator, a line, and the manifold that they share."""

from ehamj.compiled import kernel


@kernel
def pump_flow(pressure: float, set_pressure: float, conductance: float, limit: float) -> float:
    """Flow of a pressure-controlled pump [m³/s]: conductance·(p_set − p), between 0 and its ``limit``."""
    return min(max(conductance * (set_pressure - pressure), 0.0), limit)


@kernel
def supply_rates(
    station: float,
    line_flow: float,
    manifold: float,
    drawn: float,
    set_pressure: float,
    conductance: float,
    flow_limit: float,
    gas_volume: float,
    precharge: float,
    exponent: float,
    resistance: float,
    inertance: float,
    manifold_volume: float,
    bulk_modulus: float,
) -> tuple[float, float, float]:
    """Rates of the accumulator's pressure [Pa/s], the line's flow [m³/s²] and the manifold's pressure [Pa/s].

    The gas (volume V₀ at ``precharge`` p₀) is polytropic: p V^n = p₀ V₀^n, so that Ṗ = n p/V·(Q_pump − Q_line). The
    line is a resistance R [Pa s/m³] and an inertance L [Pa s²/m³]: L Q̇ = p_station − p_manifold − R Q.
    """
    gas = gas_volume * (precharge / station) ** (1.0 / exponent)
    into = pump_flow(station, set_pressure, conductance, flow_limit) - line_flow
    return (
        exponent * station / gas * into,
        (station - manifold - resistance * line_flow) / inertance,
        bulk_modulus / manifold_volume * (line_flow - drawn),
    )
