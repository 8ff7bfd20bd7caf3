"""One isolator as a user writes it: valve, cylinder, membrane, plate and foot."""

import math
from itertools import pairwise
from typing import Self

from pydantic import Field, model_validator

from ehamj.isolator.supply import Supply
from ehamj.settings import Parameters, Unlimited, quantity


class Actuator(Parameters):
    """One electro-hydraulic isolator: valve, double-acting cylinder, membrane spring, plate and foot.

    Defaults are the first-generation prototype of the paper (Table I).
    """

    piston_area: float = quantity(3.18e-2, "m²", "A_p", "active area of the piston annulus", "paper", gt=0)
    chamber_volume: float = quantity(5.39e-4, "m³", "V_t", "oil volume of both chambers together", "paper", gt=0)
    moving_volume: bool = Field(True, description="chamber volumes follow the stroke (false: constant)")
    bulk_modulus: float = quantity(1.4e9, "Pa", "β", "effective bulk modulus of the oil", "paper", gt=0)
    vapour_pressure: float = quantity(0.0, "Pa", "P_v", "pressure at which the oil cavitates", "assumed", ge=0)
    area_ratio: float = quantity(1.0, "-", "A_2/A_1", "area of chamber 2 over that of chamber 1", "paper", gt=0)
    volume_share: float = quantity(0.5, "-", "V_1/V_t", "share of chamber 1 in the oil volume", "paper", gt=0, lt=1)
    air_fraction: float = quantity(
        0.0, "-", "α", "entrained air at 1 atm, by volume (bulk_modulus is then the liquid's)", "assumed",
        ge=0, lt=1,
    )  # fmt: skip
    polytropic_exponent: float = quantity(1.4, "-", "n", "of the entrained air", "assumed", ge=1, le=1.7)
    wall_modulus: Unlimited = quantity(
        math.inf,
        "Pa",
        "β_w",
        "pressure that would double a chamber by stretching its walls (inf: rigid)",
        "assumed",
        gt=0,
    )
    membrane_stiffness: float = quantity(
        6.8e8, "N/m", "K_L", "vertical (static) stiffness of the membrane", "paper", ge=0
    )
    membrane_damping: float = quantity(3900.0, "N s/m", "C", "vertical viscous damping", "paper", ge=0)
    lateral_stiffness: float = quantity(2e8, "N/m", "k_h", "lateral stiffness, each direction", "assumed", ge=0)
    lateral_damping: float = quantity(2e4, "N s/m", "c_h", "lateral damping, each direction", "assumed", ge=0)
    plate_mass: float = quantity(14.0, "kg", "m_p", "mass of the moving pressure plate", "assumed", ge=0)
    foot_stiffness: Unlimited = quantity(
        math.inf, "N/m", "k_f", "stiffness plate to machine (inf: rigid)", "assumed", gt=0
    )
    foot_damping: float = quantity(
        0.0, "N s/m", "c_f", "damping plate to machine, for a foot with stiffness", "assumed", ge=0
    )
    flow_gain: float = quantity(1.94e-6, "m³/s/mA", "K_Q", "flow gain at null", "paper", gt=0)
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
    valve_gain: float = quantity(2.0, "mA/V", "K_v", "spool position per command", "paper", gt=0)
    valve_frequency: float = quantity(1571.0, "rad/s", "ω_v", "natural frequency of the valve at ±5 %", "paper", gt=0)
    valve_damping: float = quantity(0.65, "-", "ζ", "damping ratio of the valve", "paper", gt=0)
    spool_drive_limit: Unlimited = quantity(
        5.42e6, "mA/s²", "a_max", "limit of the solenoid's drive ω_v²(c − x) (inf: none)", "identified", gt=0
    )
    spool_stroke: float = quantity(
        20.0, "mA", "x_max", "spool position at which the edges are fully open", "assumed", gt=0
    )
    overlap: tuple[float, float, float, float] = quantity(
        (0.0, 0.0, 0.0, 0.0), "mA", "x_0", "overlap of edges supply–1, 1–tank, supply–2, 2–tank (negative: underlap)",
        "assumed",
    )  # fmt: skip
    null_offset: float = quantity(0.0, "mA", "x_n", "opening of the valve with its spool centred", "assumed")
    hysteresis: float = quantity(0.0, "mA", "x_y", "play between spool and metering edges", "assumed", ge=0)
    threshold: float = quantity(0.0, "mA", "x_t", "error of position that does not move the spool", "assumed", ge=0)
    end_stops: bool = Field(False, description="the spool stops at ±spool_stroke")
    flow_curve: tuple[tuple[float, float], ...] = quantity(
        (),
        "-",
        "q/q_N",
        "pairs of spool position and flow, as shares of the full ones, from (0, 0) to (1, 1)",
        "assumed",
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
    voltage_limit: float = quantity(10.0, "V", "v_max", "range of the command", "assumed", gt=0)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for name in ("overlap", "null_offset", "hysteresis", "threshold"):
            value = getattr(self, name)
            largest = max(map(abs, value)) if isinstance(value, tuple) else abs(value)
            if largest >= self.spool_stroke:
                raise ValueError(
                    f"{name} = {value} mA must be smaller than the full stroke, spool_stroke = {self.spool_stroke:g} mA"
                )
        if self.flow_curve:
            places, flows = zip(*self.flow_curve, strict=True)
            if (places[0], flows[0]) != (0.0, 0.0) or (places[-1], flows[-1]) != (1.0, 1.0):
                raise ValueError(f"flow_curve = {list(self.flow_curve)} must go from [0, 0] to [1, 1]")
            off = [place for place in places if abs(10.0 * place - round(10.0 * place)) > 1e-9]
            if off:
                raise ValueError(f"flow_curve: position {off[0]:g} must be a multiple of 0.1")
            if min(b - a for a, b in pairwise(places)) <= 0 or min(b - a for a, b in pairwise(flows)) < 0:
                raise ValueError(
                    f"flow_curve = {list(self.flow_curve)} must increase in position, and not fall in flow"
                )
        return self

    def rated_at(self, supply: Supply) -> Self:
        """The actuator with its flow gain from rated-flow data, if it has them: K_Q = q_N/x_max·√(Δp₀/Δp_N)."""
        if self.rated_flow == 0.0:
            return self
        gain = self.rated_flow / self.spool_stroke * math.sqrt(supply.rating_pressure / self.rated_drop)
        return self.with_values({"flow_gain": gain, "rated_flow": 0.0, "sources": {"flow_gain": "given"}})

    @property
    def edge_leakage(self) -> float:
        """Laminar conductance of each of the four edges, g₀ [m³/s/Pa]."""
        return self.edge_leakage_share * self.flow_pressure

    @property
    def cross_leakage(self) -> float:
        """Laminar conductance across the piston, c = K_C − g₀ [m³/s/Pa]."""
        return (1.0 - self.edge_leakage_share) * self.flow_pressure

    @property
    def hydraulic_stiffness(self) -> float:
        """Stiffness of the trapped oil, K_h = 4βA_p²/V_t [N/m]."""
        return 4.0 * self.bulk_modulus * self.piston_area**2 / self.chamber_volume

    @property
    def maximum_stroke(self) -> float:
        """Stroke at which one chamber is empty [m]."""
        volume_1 = self.volume_share * self.chamber_volume
        return min(volume_1, (self.chamber_volume - volume_1) / self.area_ratio) / self.piston_area

    @property
    def rigid_foot(self) -> bool:
        """Whether the plate is rigidly bound to the machine."""
        return math.isinf(self.foot_stiffness)
