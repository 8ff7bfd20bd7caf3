"""The oil: compressibility with entrained air and elastic walls, cavitation, and what a chamber holds.

A chamber's state is a pressure that may fall below the vapour pressure: it then stands for the void, of which
p_v − p = −β·ln(1 − void/V). The oil is at the vapour pressure meanwhile, nothing is lost, and the chamber recovers when
the void has closed.
"""

import math

from ehamj.compiled import kernel

ATMOSPHERE = 101325.0
"""Pressure at which the air fraction is stated and the walls are unstretched [Pa]."""

LEAST = 1.0
"""Pressure below which entrained air counts no further [Pa]."""


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
def relative_volume(pressure: float, liquid_modulus: float, air: float, exponent: float) -> float:
    """Volume of a mass of oil over its volume at atmospheric pressure: liquid of constant modulus, polytropic air.

    v = (1 − α)·exp(−(p − p₀)/β) + α·(p₀/p)^(1/n); ``air`` α is the volume fraction at p₀, ``exponent`` n.
    """
    liquid = (1.0 - air) * math.exp((ATMOSPHERE - pressure) / liquid_modulus)
    if air == 0.0:
        return liquid
    return liquid + air * (ATMOSPHERE / max(pressure, LEAST)) ** (1.0 / exponent)


@kernel
def oil_modulus(pressure: float, liquid_modulus: float, air: float, exponent: float) -> float:
    """Bulk modulus of oil with entrained air, −v/(dv/dp) of `relative_volume` [Pa]; without air the liquid's own."""
    if air == 0.0:
        return liquid_modulus
    p = max(pressure, LEAST)
    liquid = (1.0 - air) * math.exp((ATMOSPHERE - p) / liquid_modulus)
    gas = air * (ATMOSPHERE / p) ** (1.0 / exponent)
    return (liquid + gas) / (liquid / liquid_modulus + gas / (exponent * p))


@kernel
def pressure_rate(
    inflow: float, swept: float, pressure: float, volume: float, bulk_modulus: float, wall_compliance: float
) -> float:
    """Rate of a chamber's pressure [Pa/s]: Ṗ = β/V·(Q − V̇) (paper eq. 4), with walls that give way.

    ``inflow`` Q [m³/s] (where it cavitates, over `filled_share`), ``swept`` V̇ [m³/s] and ``volume`` V [m³] of the
    unstretched chamber, whose volume grows by w = 1 + (p − p₀)/β_w: Ṗ = (Q − w V̇)/(V (w/β + 1/β_w)).
    ``wall_compliance`` is 1/β_w [1/Pa].
    """
    stretch = 1.0 + (pressure - ATMOSPHERE) * wall_compliance
    return bulk_modulus * (inflow - stretch * swept) / (volume * (stretch + bulk_modulus * wall_compliance))


@kernel
def specific_energy(pressure: float, liquid_modulus: float, air: float, exponent: float) -> float:
    """Energy stored by compression from atmospheric pressure, over the volume there [J/m³]: e = −∫p dv.

    In closed form for `relative_volume`: the liquid's part and the air's (isothermal, n = 1, as its limit).
    """
    p = max(pressure, LEAST)
    ratio = math.exp((ATMOSPHERE - p) / liquid_modulus)
    liquid = (1.0 - air) * ((ATMOSPHERE + liquid_modulus) - (p + liquid_modulus) * ratio)
    if air == 0.0:
        return liquid
    if exponent == 1.0:
        return liquid + air * ATMOSPHERE * math.log(p / ATMOSPHERE)
    gas = ATMOSPHERE / (exponent - 1.0) * ((p / ATMOSPHERE) ** ((exponent - 1.0) / exponent) - 1.0)
    return liquid + air * gas


@kernel
def chamber_mass(
    state: float,
    volume: float,
    vapour: float,
    liquid_modulus: float,
    air: float,
    exponent: float,
    wall_compliance: float,
) -> float:
    """Mass of the oil in a chamber over its density at atmospheric pressure [m³]; the void holds none."""
    pressure = actual_pressure(state, vapour)
    modulus = oil_modulus(pressure, liquid_modulus, air, exponent)
    filled = filled_share(state, pressure, modulus)
    stretch = 1.0 + (state - ATMOSPHERE) * wall_compliance
    return volume * stretch * filled / relative_volume(pressure, liquid_modulus, air, exponent)
