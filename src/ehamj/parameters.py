"""Physical parameters: frozen, validated, in SI, each value with its source.

A source is one of

- ``paper``: Table I or the text of the source paper,
- ``identified``: fitted to something that the paper states,
- ``assumed``: chosen, because nobody measured it,
- ``given``: set by the user.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from ehamj.layout import MOUNTS

Source = Literal["paper", "identified", "assumed", "given"]
Position2 = tuple[float, float]
Vector3 = tuple[float, float, float]


class Settings(BaseModel):
    """Base of everything a user writes: frozen, no unknown keys, no conversion of types (a string or ``true`` is not a
    number), finite numbers unless a field says otherwise."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)

    @model_validator(mode="before")
    @classmethod
    def _lists_are_tuples(cls, table: Any) -> Any:
        if not isinstance(table, Mapping):
            return table
        return {key: _tuples(value) for key, value in table.items()}


def _tuples(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _tuples(entry) for key, entry in value.items()}
    return tuple(_tuples(entry) for entry in value) if isinstance(value, list) else value


def quantity(default: Any, unit: str, symbol: str, text: str, source: Source, **limits: Any) -> Any:
    """A field with its unit, symbol and source; ``limits`` are pydantic's (gt, ge, lt, le, …)."""
    extra: dict[str, Any] = {"unit": unit, "symbol": symbol, "source": source}
    return Field(default, description=f"{text} [{unit}]", json_schema_extra=extra, **limits)


class Parameters(Settings):
    """Settings whose every value carries a source; a value that differs from the default is ``given``."""

    sources: dict[str, Source] = Field(default_factory=dict, description="where each value comes from")

    @model_validator(mode="after")
    def _complete_sources(self) -> Self:
        known = self.quantities()
        for name in self.sources:
            if name not in known:
                raise ValueError(f"sources names {name!r}, which is not one of {', '.join(known)}")
        complete: dict[str, Source] = {}
        for name, (_, _, source) in known.items():
            is_default = getattr(self, name) == type(self).model_fields[name].default
            complete[name] = self.sources.get(name, source if is_default else "given")
        object.__setattr__(self, "sources", complete)
        return self

    @classmethod
    def quantities(cls) -> dict[str, tuple[str, str, Source]]:
        """Unit, symbol and default source of each physical value, by name."""
        found = {}
        for name, field in cls.model_fields.items():
            extra = field.json_schema_extra
            if isinstance(extra, dict) and "unit" in extra:
                found[name] = (str(extra["unit"]), str(extra["symbol"]), extra["source"])
        return found  # type: ignore[return-value]

    def with_values(self, values: dict[str, Any]) -> Self:
        """A copy with other values, which become ``given`` unless they are what they were."""
        changed = {
            name: value for name, value in values.items() if name == "sources" or getattr(self, name, None) != value
        }
        sources = {name: source for name, source in self.sources.items() if name not in changed}
        sources.update(changed.pop("sources", {}))
        return type(self).model_validate({**self.model_dump(exclude={"sources"}), **changed, "sources": sources})


Unlimited = Annotated[float, Field(allow_inf_nan=True)]


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

    def rated_at(self, supply: "Supply") -> Self:
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


FIRST_GENERATION = Actuator()
"""The paper's first prototype (Table I)."""

RECOMMENDED = Actuator(
    chamber_volume=FIRST_GENERATION.chamber_volume / 2,
    piston_area=FIRST_GENERATION.piston_area * 2,
    flow_pressure=FIRST_GENERATION.flow_pressure * 2,
    sources={"chamber_volume": "paper", "piston_area": "paper", "flow_pressure": "paper"},
)
"""The paper's recommendation (section 5): half the volume, twice the area and the flow-pressure coefficient."""

ELASTIC_MOUNT = Actuator(
    piston_area=1e-6,  # its oil carries 7 N at most, of 10 kN
    membrane_stiffness=1e6,
    membrane_damping=3.2e3,
    lateral_stiffness=5e5,
    lateral_damping=1.6e3,
    sources=dict.fromkeys(
        ("piston_area", "membrane_stiffness", "membrane_damping", "lateral_stiffness", "lateral_damping"), "assumed"
    ),
)
"""A passive spring mount, in place of the actuator: four carry 4 t at 5 Hz vertically, damping ratio 5 %."""

PNEUMATIC_MOUNT = Actuator(
    # Spring and damping chamber of 2.1 dm³ together at 6 bar, of which n·p·A²/V is membrane_stiffness; what the
    # narrow bore between them adds above its frequency, as much again, is K_h = 4βA²/V_t, with β = n·p.
    piston_area=0.02,
    bulk_modulus=8.4e5,
    chamber_volume=8.4e-3,
    moving_volume=False,  # the pressure carries the weight, and the piston stays in the middle
    flow_pressure=3.75e-8,
    edge_leakage_share=1e-3,
    membrane_stiffness=1.6e5,
    membrane_damping=100.0,
    lateral_stiffness=1e5,
    lateral_damping=1.6e3,
    sources=dict.fromkeys(
        (
            "piston_area",
            "bulk_modulus",
            "chamber_volume",
            "flow_pressure",
            "edge_leakage_share",
            "membrane_stiffness",
            "membrane_damping",
            "lateral_stiffness",
            "lateral_damping",
        ),
        "assumed",
    ),
)
"""A passive air spring with a damping chamber, as a standard linear solid: four carry 4 t at 2 to 2.8 Hz vertically.

Its spring is the membrane's, its bore the leakage across the piston (DeBra, Precision Engineering 1984). Levelling
valves are not modelled: static stiffness is that of the gas.
"""

ACTUATOR_PRESETS: dict[str, Actuator] = {
    "first-generation": FIRST_GENERATION,
    "recommended": RECOMMENDED,
    "elastic-mount": ELASTIC_MOUNT,
    "pneumatic-mount": PNEUMATIC_MOUNT,
}


OILS: dict[str, dict[str, float]] = {
    # The paper's effective modulus, with whatever air and hose it contained.
    "paper": {},
    # Mineral oil at 40 °C and well de-aerated; secant modulus as in textbooks (Merritt; Jelali and Kroll).
    "mineral": {"bulk_modulus": 1.6e9, "air_fraction": 0.005, "vapour_pressure": 10.0},
    # The same with the air of a tank that foams.
    "mineral-aerated": {"bulk_modulus": 1.6e9, "air_fraction": 0.03, "vapour_pressure": 10.0},
    # Fire-resistant HFC fluid: stiffer, and with the vapour pressure of its water at 40 °C.
    "water-glycol": {"bulk_modulus": 3.2e9, "air_fraction": 0.005, "vapour_pressure": 6e3},
}
"""Values that belong to an oil, typical and assumed; those of an actuator's table override them."""


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


class Machine(Parameters):
    """The rigid machine: mass properties and outline; the origin is the mount plane's centre, z up."""

    mass: float = quantity(4000.0, "kg", "m", "mass without the plates", "assumed", gt=0)
    inertia: Vector3 = quantity(
        (2000.0, 3000.0, 4000.0), "kg m²", "J", "principal inertia about the CG, x, y, z", "assumed"
    )
    cg: Vector3 = quantity((0.0, 0.0, 0.75), "m", "r_CG", "centre of gravity from the mount plane's centre", "assumed")
    size: Vector3 = quantity((2.2, 1.6, 1.9), "m", "l", "outline: length in x, width in y, height", "assumed")

    @model_validator(mode="after")
    def _physical(self) -> Self:
        for name in ("inertia", "size"):
            if min(getattr(self, name)) <= 0:
                raise ValueError(f"{name} = {list(getattr(self, name))} must be positive in each entry")
        a, b, c = self.inertia
        if a + b < c or b + c < a or c + a < b:  # as the engine has it, to the last bit
            raise ValueError(
                f"inertia = {[a, b, c]} is of no rigid body: each entry is at most the sum of the other two"
            )
        half_x, half_y = self.size[0] / 2, self.size[1] / 2
        if abs(self.cg[0]) > half_x or abs(self.cg[1]) > half_y or not 0 <= self.cg[2] <= self.size[2]:
            raise ValueError(f"cg = {list(self.cg)} lies outside the machine's outline, size = {list(self.size)}")
        return self


class Mount(Settings):
    """Where one actuator stands under the machine."""

    name: Literal["front-left", "front-right", "rear-left", "rear-right"]
    position: Position2 = Field(description="x and y from the mount plane's centre [m]")
    actuator: str = Field("isolator", description="name of a table [actuators.NAME]")


DEFAULT_MOUNTS: tuple[Mount, ...] = tuple(
    Mount(name=name, position=position)  # type: ignore[arg-type]
    for name, position in zip(MOUNTS, ((0.9, 0.6), (0.9, -0.6), (-0.9, 0.6), (-0.9, -0.6)), strict=True)
)


@dataclass(frozen=True)
class Plant:
    """Everything physical that is simulated: the machine, its four isolators in the order of the mounts, the supply."""

    machine: Machine
    positions: tuple[Position2, ...]
    """x and y of each mount [m]."""
    actuators: tuple[Actuator, ...]
    supply: Supply
    gravity: float
    """Gravitational acceleration, downwards positive [m/s²]."""
    plates: Literal["sliding", "tied"]
    """``sliding``: each plate on a joint of its own; ``tied``: the plate's inertia on the stroke coordinate."""
    bookkeeping: bool = False
    """Whether oil and energy are balanced in the simulation's own states."""

    @property
    def total_mass(self) -> float:
        """Machine and plates [kg]."""
        return self.machine.mass + sum(actuator.plate_mass for actuator in self.actuators)
