"""Ground motion made from formulas: rest and a sine of the slab."""

from typing import Annotated, Literal

from pydantic import Field

from ehamj.ground.motion import Motion, Slab, Start
from ehamj.parameters import Settings
from ehamj.signals import Faded, Multisine, Signal


class RestGround(Settings):
    """The ground is at rest."""

    kind: Literal["rest"] = "rest"

    def motion(self, start: Start) -> Motion:
        """Build the motion."""
        return Slab(start.positions, {})


class SineGround(Settings):
    """A rigid slab moved by one sine in one degree of freedom."""

    kind: Literal["sine"]
    dof: Literal["x", "y", "z", "rx", "ry", "rz"] = Field("z", description="degree of freedom that moves")
    amplitude: float = Field(1e-6, description="amplitude of the displacement [m] or rotation [rad]")
    frequency: Annotated[float, Field(gt=0)] = Field(10.0, description="frequency [Hz]")
    phase: float = Field(0.0, description="phase [rad]")
    fade_in: float = Field(0.0, ge=0, description="time over which the motion fades in [s]")

    def motion(self, start: Start) -> Motion:
        """Build the motion."""
        signal: Signal = Multisine.of(self.amplitude, self.frequency, self.phase)
        if self.fade_in > 0:
            signal = Faded(signal, self.fade_in)
        return Slab(start.positions, {self.dof: signal})
