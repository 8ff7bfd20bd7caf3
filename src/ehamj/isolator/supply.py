"""One supply for all actuators: a pump with a flow limit, an accumulator, a line, and the manifold that they share."""

import math
from typing import Self

from pydantic import Field, model_validator

from ehamj.compiled import kernel
from ehamj.settings import Parameters, quantity


class Supply(Parameters):
    """Oil supply and tank; pressures are absolute."""

    pressure: float = quantity(70e5, "Pa", "P_s", "supply pressure", "assumed", gt=0)
    tank_pressure: float = quantity(0.0, "Pa", "P_t", "tank pressure", "assumed", ge=0)
    dynamic: bool = Field(False, description="pump, accumulator, line and manifold, which the four actuators share")
    pump_flow: float = quantity(1.5e-4, "m³/s", "Q_max", "largest flow of the pump", "assumed", gt=0)
    pump_droop: float = quantity(
        5e5, "Pa", "Δp_c", "fall of pressure at which the pump gives all its flow", "assumed", gt=0
    )
    accumulator_volume: float = quantity(
        1e-3, "m³", "V_0", "gas volume of the accumulator at precharge", "assumed", gt=0
    )
    accumulator_precharge: float = quantity(45e5, "Pa", "p_0", "gas pressure of the empty accumulator", "assumed", gt=0)
    accumulator_exponent: float = quantity(
        1.3, "-", "n", "polytropic exponent of the accumulator", "assumed", ge=1, le=1.7
    )
    line_length: float = quantity(3.0, "m", "l", "length of the line from pump to manifold", "assumed", gt=0)
    line_diameter: float = quantity(12e-3, "m", "d", "inner diameter of the line", "assumed", gt=0)
    manifold_volume: float = quantity(5e-4, "m³", "V_m", "oil volume of the manifold", "assumed", gt=0)
    oil_density: float = quantity(870.0, "kg/m³", "ρ", "density of the oil", "assumed", gt=0)
    oil_viscosity: float = quantity(0.04, "Pa s", "µ", "dynamic viscosity of the oil", "assumed", gt=0)
    oil_modulus: float = quantity(1.4e9, "Pa", "β", "bulk modulus of the oil in the manifold", "assumed", gt=0)

    @model_validator(mode="after")
    def _order(self) -> Self:
        if self.pressure <= self.tank_pressure:
            raise ValueError(f"pressure = {self.pressure:g} Pa must be above tank_pressure = {self.tank_pressure:g} Pa")
        if self.dynamic and self.accumulator_precharge >= self.pressure:
            precharge = f"accumulator_precharge = {self.accumulator_precharge:g} Pa"
            raise ValueError(f"{precharge} must be below pressure = {self.pressure:g} Pa")
        return self

    @property
    def rating_pressure(self) -> float:
        """Pressure drop per edge at which the flow gain holds, Δp₀ = (P_s − P_t)/2 [Pa]."""
        return 0.5 * (self.pressure - self.tank_pressure)

    @property
    def line_resistance(self) -> float:
        """Laminar resistance of the line, 128 µ l/(π d⁴) [Pa s/m³] (Hagen–Poiseuille)."""
        return 128.0 * self.oil_viscosity * self.line_length / (math.pi * self.line_diameter**4)

    @property
    def line_inertance(self) -> float:
        """Inertance of the line, ρ l/A [Pa s²/m³]."""
        return self.oil_density * self.line_length / (math.pi / 4 * self.line_diameter**2)


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
