"""The oil: compressibility with entrained air and elastic walls, cavitation, and what a chamber holds.

A chamber's state is a pressure that may fall below the vapour pressure: it then stands for the void, of which
p_v − p = −β·ln(1 − void/V). The oil is at the vapour pressure meanwhile, nothing is lost, and the chamber recovers when
the void has closed.
"""

import math
from typing import Any, ClassVar, NamedTuple

from ehamj.compiled import kernel
from ehamj.isolator.component import Component
from ehamj.settings import Unlimited, quantity

ATMOSPHERE = 101325.0
"""Pressure at which the air fraction is stated and the walls are unstretched [Pa]."""

LEAST = 1.0
"""Pressure below which entrained air counts no further [Pa]."""


class Fluid(Component):
    """The oil in the chambers, and the walls around it."""

    bulk_modulus: float = quantity(1.4e9, "Pa", "β", "effective bulk modulus of the oil", "paper", gt=0)
    vapour_pressure: float = quantity(0.0, "Pa", "P_v", "pressure at which the oil cavitates", "assumed", ge=0)
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

    takes: ClassVar[Any] = ("bulk_modulus", "vapour_pressure", "air_fraction", "polytropic_exponent", "wall_compliance")

    @property
    def wall_compliance(self) -> float:
        """Compliance of the walls, 1/β_w [1/Pa]."""
        return 1.0 / self.wall_modulus


@kernel
def actual_pressure(state: float, vapour_pressure: float) -> float:
    """Pressure of the oil [Pa]: never below the vapour pressure."""
    return max(state, vapour_pressure)


@kernel
def filled_share(state: float, pressure: float, modulus: float) -> float:
    """Share of a chamber that is oil, exp((p − p_v)/β) below the vapour pressure; the rest is void.

    It counts down to a thousandth: what is emptier has no oil to follow.
    """
    return max(math.exp((state - pressure) / modulus), 1e-3) if state < pressure else 1.0


@kernel
def relative_volume(pressure: float, oil: "Fluid") -> float:
    """Volume of a mass of oil over its volume at atmospheric pressure: liquid of constant modulus, polytropic air.

    v = (1 − α)·exp(−(p − p₀)/β) + α·(p₀/p)^(1/n), with the air's volume fraction α at p₀.
    """
    liquid = (1.0 - oil.air_fraction) * math.exp((ATMOSPHERE - pressure) / oil.bulk_modulus)
    if oil.air_fraction == 0.0:
        return liquid
    return liquid + oil.air_fraction * (ATMOSPHERE / max(pressure, LEAST)) ** (1.0 / oil.polytropic_exponent)


@kernel
def oil_modulus(pressure: float, oil: "Fluid") -> float:
    """Bulk modulus of oil with entrained air, −v/(dv/dp) of `relative_volume` [Pa]; without air the liquid's own."""
    if oil.air_fraction == 0.0:
        return oil.bulk_modulus
    p = max(pressure, LEAST)
    liquid = (1.0 - oil.air_fraction) * math.exp((ATMOSPHERE - p) / oil.bulk_modulus)
    gas = oil.air_fraction * (ATMOSPHERE / p) ** (1.0 / oil.polytropic_exponent)
    return (liquid + gas) / (liquid / oil.bulk_modulus + gas / (oil.polytropic_exponent * p))


@kernel
def stretch(state: float, wall_compliance: float) -> float:
    """Volume of a chamber over that with unstretched walls, w = 1 + (p − p₀)/β_w."""
    return 1.0 + (state - ATMOSPHERE) * wall_compliance


@kernel
def pressure_rate(
    inflow: float, swept: float, pressure: float, volume: float, bulk_modulus: float, wall_compliance: float
) -> float:
    """Rate of a chamber's pressure [Pa/s]: Ṗ = β/V·(Q − V̇) (paper eq. 4), with walls that give way.

    ``inflow`` Q [m³/s] (where it cavitates, over `filled_share`), ``swept`` V̇ [m³/s] and ``volume`` V [m³] of the
    unstretched chamber, whose volume grows by w (`stretch`): Ṗ = (Q − w V̇)/(V (w/β + 1/β_w)).
    ``wall_compliance`` is 1/β_w [1/Pa].
    """
    wider = stretch(pressure, wall_compliance)
    return bulk_modulus * (inflow - wider * swept) / (volume * (wider + bulk_modulus * wall_compliance))


@kernel
def chamber_rate(state: float, flow: float, swept: float, volume: float, oil: "Fluid") -> float:
    """Rate of a chamber's pressure state [Pa/s] from what flows in, air, void and walls counted."""
    pressure = actual_pressure(state, oil.vapour_pressure)
    modulus = oil_modulus(pressure, oil)
    # Oil that enters a chamber with a void fills it the sooner the less of it is oil: mass is conserved.
    return pressure_rate(
        flow / filled_share(state, pressure, modulus), swept, state, volume, modulus, oil.wall_compliance
    )


@kernel
def liquid_rate(state: float, flow: float, swept: float, volume: float, oil: "Fluid") -> float:
    """As `chamber_rate`, to the bit, for oil without air that does not cavitate."""
    return pressure_rate(flow, swept, state, volume, oil.bulk_modulus, oil.wall_compliance)


@kernel
def specific_energy(pressure: float, oil: "Fluid") -> float:
    """Energy stored by compression from atmospheric pressure, over the volume there [J/m³]: e = −∫p dv.

    In closed form for `relative_volume`: the liquid's part and the air's (isothermal, n = 1, as its limit).
    """
    p = max(pressure, LEAST)
    beta, exponent = oil.bulk_modulus, oil.polytropic_exponent
    ratio = math.exp((ATMOSPHERE - p) / beta)
    liquid = (1.0 - oil.air_fraction) * ((ATMOSPHERE + beta) - (p + beta) * ratio)
    if oil.air_fraction == 0.0:
        return liquid
    if exponent == 1.0:
        return liquid + oil.air_fraction * ATMOSPHERE * math.log(p / ATMOSPHERE)
    gas = ATMOSPHERE / (exponent - 1.0) * ((p / ATMOSPHERE) ** ((exponent - 1.0) / exponent) - 1.0)
    return liquid + oil.air_fraction * gas


class Contents(NamedTuple):
    """What a chamber holds."""

    void: float
    """Volume of the void by cavitation [m³]."""
    mass: float
    """Mass of the oil over its density at atmospheric pressure [m³]; the void holds none."""
    energy: float
    """Energy stored by compression [J], less what the void has done at the vapour pressure."""


@kernel
def contents(state: float, volume: float, oil: "Fluid") -> Contents:
    """What a chamber of an unstretched ``volume`` [m³] holds at its pressure state [Pa]."""
    pressure = actual_pressure(state, oil.vapour_pressure)
    filled = filled_share(state, pressure, oil_modulus(pressure, oil))
    wider = volume * stretch(state, oil.wall_compliance)
    void = wider * (1.0 - filled)
    mass = wider * filled / relative_volume(pressure, oil)
    return Contents(void, mass, mass * specific_energy(pressure, oil) - oil.vapour_pressure * void)


class Crossing(NamedTuple):
    """What crosses a chamber's border in a time."""

    oil: float
    """Mass of oil over its density at atmospheric pressure [m³/s]."""
    energy: float
    """Enthalpy of that oil [W]."""
    work: float
    """Work on the walls and the piston [W]."""
    power: float
    """Flow times pressure [W]."""


@kernel
def crossing(state: float, rate: float, flow: float, swept: float, volume: float, oil: "Fluid") -> Crossing:
    """What crosses the border of a chamber whose pressure state [Pa] has this ``rate`` [Pa/s]."""
    pressure = actual_pressure(state, oil.vapour_pressure)
    inflow = 1.0 / relative_volume(pressure, oil) * flow
    moved = stretch(state, oil.wall_compliance) * swept + volume * oil.wall_compliance * rate
    return Crossing(
        inflow, inflow * specific_energy(pressure, oil) + pressure * flow, pressure * moved, pressure * flow
    )
