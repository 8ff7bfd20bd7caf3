"""The membrane that carries the machine: axial and lateral springs, the pressure plate, and the machine's foot."""

import math
from typing import Any, ClassVar

from ehamj.compiled import kernel
from ehamj.isolator.component import Component
from ehamj.settings import Unlimited, quantity


class Membrane(Component):
    """Membrane, plate and foot; the engine's model has their springs, dampers and masses."""

    membrane_stiffness: float = quantity(6.8e8, "N/m", "K_L", "axial (static) stiffness of the membrane", "paper", ge=0)
    membrane_damping: float = quantity(3900.0, "N s/m", "C", "axial viscous damping", "paper", ge=0)
    lateral_stiffness: float = quantity(
        2e8, "N/m", "k_h", "lateral stiffness, each direction across the action", "assumed", ge=0
    )
    lateral_damping: float = quantity(
        2e4, "N s/m", "c_h", "lateral damping, each direction across the action", "assumed", ge=0
    )
    plate_mass: float = quantity(14.0, "kg", "m_p", "mass of the moving pressure plate", "assumed", ge=0)
    foot_stiffness: Unlimited = quantity(
        math.inf, "N/m", "k_f", "stiffness plate to machine (inf: rigid)", "assumed", gt=0
    )
    foot_damping: float = quantity(
        0.0, "N s/m", "c_f", "damping plate to machine, for a foot with stiffness", "assumed", ge=0
    )

    takes: ClassVar[Any] = ("membrane_stiffness", "membrane_damping", "lateral_stiffness", "lateral_damping")

    @property
    def rigid_foot(self) -> bool:
        """Whether the plate is rigidly bound to the machine."""
        return math.isinf(self.foot_stiffness)


@kernel
def lift(ground: float, rate: float, own: "Membrane") -> tuple[float, float]:
    """Forces on the plate [N] by the ground below the membrane at height [m] and rate [m/s]: of spring and damper."""
    return own.membrane_stiffness * ground, own.membrane_damping * rate


@kernel
def pull(ground: float, slope: float, rate: float, own: "Membrane") -> float:
    """Lateral force on the machine by ground that moved, in one direction [N].

    ``slope``·``rate`` is the ground's velocity [m/s]: motion per step [m], and steps per second.
    """
    return own.lateral_stiffness * ground + own.lateral_damping * slope * rate
