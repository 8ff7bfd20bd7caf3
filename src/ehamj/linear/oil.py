"""The chambers' oil of many designs at once: compliances and leakages about rest, from closed forms.

Source: docs/physics.md, section 2.
"""

from dataclasses import dataclass

import numpy as np

from ehamj.arrays import Array
from ehamj.isolator.fluid import ATMOSPHERE
from ehamj.linear.values import Values


@dataclass(frozen=True)
class Oil:
    """The chambers' oil about rest; last axis the mounts."""

    areas: Array
    """Areas of chambers 1 and 2 [m²], (2, …, mount)."""
    compliances: Array
    """Of chambers 1 and 2, (2, …, mount): oil that enters per pressure, walls included, V (w/β + 1/β_w) [m³/Pa]."""
    stretch: Array
    """w = 1 + (p − p₀)/β_w [-]."""
    edge: Array
    """g₀ [m³/s/Pa]."""
    cross: Array
    """c [m³/s/Pa]."""

    @classmethod
    def of(cls, values: Values, strokes: Array, pressures: tuple[Array, Array] | None = None) -> "Oil":
        """The oil with the pistons at ``strokes`` [m], chambers at ``pressures`` [Pa] (without: their middle)."""
        at, wall = values.mounts, values.mounts["wall_modulus"]
        middle = values.middle[..., None]
        areas = np.stack([at["piston_area"], at["piston_area"] * at["area_ratio"]])
        moved = at["moving_volume"] * strokes
        compliances = []
        shares = at["volume_share"], 1.0 - at["volume_share"]
        for share, swept, p in zip(shares, (areas[0], -areas[1]), pressures or (middle, middle), strict=True):
            volume = share * at["chamber_volume"] + swept * moved
            compliances.append(volume * ((1.0 + (p - ATMOSPHERE) / wall) / oil_modulus(values, p) + 1.0 / wall))
        edge = at["edge_leakage_share"] * at["flow_pressure"]
        stretch = 1.0 + (middle - ATMOSPHERE) / wall
        return cls(areas, np.stack(compliances), stretch, edge, at["flow_pressure"] - edge)

    @property
    def empty(self) -> Array:
        """Where a chamber would have no room left (…,), or there is no rest at all."""
        return np.asarray(~(self.compliances > 0.0).all(axis=(0, -1)))


def oil_modulus(values: Values, pressure: Array) -> Array:
    """Bulk modulus of oil with entrained air [Pa], as `ehamj.isolator.fluid.oil_modulus`, (…, mount)."""
    at = values.mounts
    liquid = (1.0 - at["air_fraction"]) * np.exp((ATMOSPHERE - pressure) / at["bulk_modulus"])
    gas = at["air_fraction"] * (ATMOSPHERE / pressure) ** (1.0 / at["polytropic_exponent"])
    compliance = liquid / at["bulk_modulus"] + gas / (at["polytropic_exponent"] * pressure)
    return np.asarray((liquid + gas) / compliance)
