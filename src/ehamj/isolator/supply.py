"""One supply for all actuators: a pump with a flow limit, an accumulator, a line, and the manifold that they share."""

import math
from typing import Any, ClassVar, NamedTuple, Self

from pydantic import Field, model_validator

from ehamj.compiled import kernel
from ehamj.isolator.component import Component
from ehamj.settings import quantity


class Supply(Component):
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

    takes: ClassVar[Any] = (
        "pressure", "pump_conductance", "pump_flow", "accumulator_volume", "accumulator_precharge",
        "accumulator_exponent", "line_resistance", "line_inertance", "manifold_volume", "oil_modulus",
    )  # fmt: skip

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
    def pump_conductance(self) -> float:
        """Flow of the pump per fall of pressure [m³/s/Pa]."""
        return self.pump_flow / self.pump_droop

    @property
    def line_resistance(self) -> float:
        """Laminar resistance of the line, 128 µ l/(π d⁴) [Pa s/m³] (Hagen–Poiseuille)."""
        return 128.0 * self.oil_viscosity * self.line_length / (math.pi * self.line_diameter**4)

    @property
    def line_inertance(self) -> float:
        """Inertance of the line, ρ l/A [Pa s²/m³]."""
        return self.oil_density * self.line_length / (math.pi / 4 * self.line_diameter**2)


class Feed(NamedTuple):
    """What a valve is fed with: P_s, P_t, and the drop per edge at which its gain holds, Δp₀ [Pa]."""

    supply_pressure: float
    tank_pressure: float
    rated_pressure: float


class SupplyState(NamedTuple):
    """States of a supply that the isolators share: pressure of the accumulator [Pa], flow in the line [m³/s], pressure
    of the manifold [Pa]."""

    station_pressure: float
    line_flow: float
    supply_pressure: float


def middle(own: Supply) -> SupplyState:
    """Where the pump controls, between no flow and all of it."""
    pressure = own.pressure - 0.5 * own.pump_flow / own.pump_conductance
    return SupplyState(pressure, 0.5 * own.pump_flow, pressure)


@kernel
def supply_rates(state: SupplyState, drawn: float, own: Supply) -> SupplyState:
    """Rates of the supply's states, from the flow [m³/s] that all isolators draw.

    The pump is pressure-controlled: conductance·(P_s − p), between 0 and its limit. The gas (volume V₀ at precharge p₀)
    is polytropic: p V^n = p₀ V₀^n, so that Ṗ = n p/V·(Q_pump − Q_line). The line is a resistance R and an inertance L:
    L Q̇ = p_station − p_manifold − R Q.
    """
    station = state.station_pressure
    pumped = min(max(own.pump_conductance * (own.pressure - station), 0.0), own.pump_flow)
    gas = own.accumulator_volume * (own.accumulator_precharge / station) ** (1.0 / own.accumulator_exponent)
    return SupplyState(
        own.accumulator_exponent * station / gas * (pumped - state.line_flow),
        (station - state.supply_pressure - own.line_resistance * state.line_flow) / own.line_inertance,
        own.oil_modulus / own.manifold_volume * (state.line_flow - drawn),
    )
