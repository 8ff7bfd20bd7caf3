"""What every digital law has in common."""

from typing import Annotated

from pydantic import Field

from ehamj.control.blocks import Block
from ehamj.control.commands import Passive
from ehamj.control.law import UNSTABLE, Controller
from ehamj.control.windup import limited_radius
from ehamj.errors import InputError
from ehamj.plant.mounts import MOUNTS
from ehamj.plant.plant import Plant
from ehamj.settings import Settings
from ehamj.signals import Signal

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]

ISOLATE_FROM = (
    "frequency at which isolation begins on floors too strong for the voltage; below it the machine follows the floor "
    "[Hz]; 0: everywhere"
)


class DigitalSettings(Settings):
    """What every digital controller has; it alone commands the valves."""

    rate: Positive = Field(10_000.0, description="sampling rate [Hz]")
    delay: NotNegative | None = Field(None, description="computation delay [s]; without: one sample")
    bits: Annotated[int, Field(ge=2, le=52)] = Field(16, description="resolution of the command converter [bit]")
    switch_on: NotNegative = Field(0.0, description="time at which the controller takes over [s]")
    fade: NotNegative = Field(0.0, description="time over which its commands fade in [s]")

    def commands(self) -> tuple[Signal, ...]:
        """No open-loop command beside the controller's."""
        return Passive().commands()

    recovery: Positive = Field(
        0.15, description="time over which motion that the valves could not follow is made good [s]"
    )

    @property
    def period(self) -> float:
        """Sampling period [s]."""
        return 1.0 / self.rate

    @property
    def hold(self) -> float:
        """Delay of computation and of the hold, half a sample, together [s]."""
        return (self.period if self.delay is None else self.delay) + 0.5 * self.period

    def digital(self, block: Block, inputs: tuple[str, ...], plant: Plant) -> Controller:
        """The law that a sampled ``block`` from ``inputs`` to the four commands [V] becomes.

        The block may have four inputs more, for what the valves did not get of the commands [V]; it must not answer
        them at once.
        """
        measured = len(inputs)
        windup = block.B[:, measured:] if block.B.shape[1] > measured else None
        if windup is not None and limited_radius(block.A, block.C, windup) > UNSTABLE:
            raise InputError(
                f"control.recovery = {self.recovery:g} s: too slow for loops that cross so low, which would swing up "
                "while commands are limited; shorten it, or raise the crossing, or lower the integral"
            )
        return Controller(
            block.A,
            block.B[:, :measured],
            block.C,
            block.D[:, :measured],
            inputs,
            self.period,
            self.delay,
            min(actuator.voltage_limit for actuator in plant.actuators),
            self.bits,
            switch_on=self.switch_on,
            fade=self.fade,
            from_rest=True,
            anti_windup=windup,
        )


def per_mount(what: str, label: str = "") -> tuple[str, ...]:
    """The channels of a quantity at all mounts: ``ground_velocity front-left z`` and so on."""
    return tuple(f"{what} {mount} {label}".rstrip() for mount in MOUNTS)
