"""What the chambers of all actuators hold, from recorded states: pressure, void, oil and its energy, as arrays."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ehamj.isolator.fluid import ATMOSPHERE, LEAST
from ehamj.plant.plant import Plant

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Chambers:
    """Constants of the chambers, shape (mount, chamber) each; the formulas are those of `ehamj.isolator.fluid`."""

    area: Array
    volume: Array
    moving: Array
    vapour: Array
    modulus: Array
    air: Array
    exponent: Array
    wall: Array

    @classmethod
    def of(cls, plant: Plant) -> Self:
        """The chambers of a plant."""
        both = np.ones(2)
        actuators = plant.actuators
        share = np.array([[a.volume_share, 1.0 - a.volume_share] for a in actuators])

        def each(name: str) -> Array:
            return np.outer([getattr(a, name) for a in actuators], both)

        return cls(
            area=each("piston_area") * np.array([[1.0, a.area_ratio] for a in actuators]),
            volume=each("chamber_volume") * share,
            moving=each("moving_volume") * np.array([1.0, -1.0]),
            vapour=each("vapour_pressure"),
            modulus=each("bulk_modulus"),
            air=each("air_fraction"),
            exponent=each("polytropic_exponent"),
            wall=each("wall_modulus"),
        )

    def pressure(self, states: Array) -> Array:
        """Pressure of the oil [Pa] from the pressure states (time, mount, chamber)."""
        return np.maximum(states, self.vapour)

    def volumes(self, states: Array, stroke: Array) -> Array:
        """Volume of the chambers with stretched walls [m³]; ``stroke`` (time, mount) [m]."""
        return (self.volume + self.moving * self.area * stroke[:, :, None]) * (1.0 + (states - ATMOSPHERE) / self.wall)

    def relative_volume(self, pressure: Array) -> Array:
        """Volume of a mass of oil over that at atmospheric pressure."""
        liquid = (1.0 - self.air) * np.exp((ATMOSPHERE - pressure) / self.modulus)
        return liquid + self.air * (ATMOSPHERE / np.maximum(pressure, LEAST)) ** (1.0 / self.exponent)

    def oil_modulus(self, pressure: Array) -> Array:
        """Bulk modulus of oil with entrained air [Pa]."""
        p = np.maximum(pressure, LEAST)
        liquid = (1.0 - self.air) * np.exp((ATMOSPHERE - p) / self.modulus)
        gas = self.air * (ATMOSPHERE / p) ** (1.0 / self.exponent)
        return (liquid + gas) / (liquid / self.modulus + gas / (self.exponent * p))

    def filled(self, states: Array) -> Array:
        """Share of the chambers that is oil; the rest is void."""
        pressure = self.pressure(states)
        return np.exp((states - pressure) / self.oil_modulus(pressure))

    def void(self, states: Array, stroke: Array) -> Array:
        """Volume of the void by cavitation [m³]."""
        return self.volumes(states, stroke) * (1.0 - self.filled(states))

    def mass(self, states: Array, stroke: Array) -> Array:
        """Mass of the oil, over its density at atmospheric pressure [m³]."""
        return self.volumes(states, stroke) * self.filled(states) / self.relative_volume(self.pressure(states))

    def energy(self, states: Array, stroke: Array) -> Array:
        """Energy stored by compression [J], less what the void has done at the vapour pressure."""
        p = np.maximum(self.pressure(states), LEAST)
        ratio = np.exp((ATMOSPHERE - p) / self.modulus)
        liquid = (1.0 - self.air) * ((ATMOSPHERE + self.modulus) - (p + self.modulus) * ratio)
        n = self.exponent
        relative = p / ATMOSPHERE
        with np.errstate(divide="ignore", invalid="ignore"):
            gas = np.where(
                n == 1.0, ATMOSPHERE * np.log(relative), ATMOSPHERE / (n - 1.0) * (relative ** ((n - 1.0) / n) - 1.0)
            )
        return self.mass(states, stroke) * (liquid + self.air * gas) - self.vapour * self.void(states, stroke)
