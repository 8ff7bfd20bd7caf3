"""Narrow-band feedback of the machine's motion at the lines of motors and fans.

For each line a resonator on the velocities of heave, roll and pitch, and of what else the mounts drive,

    ẋ_p = −g·2ζω·(s cos φ − ω sin φ)/(s² + 2ζωs + ω²)·v,

whose loop gain at its line is g, and whose phase φ takes back the lag of instrument, computation, hold and valve there.
Beside a broadband loop (`ehamj.control.architectures.modal`) φ also takes back the turn of that loop's sensitivity, and
its gain is that over what the loop leaves. `ehamj.control.architectures.adaptive` has the same resonators.
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, field_validator

from ehamj.control.blocks import TWO_PI, Block, added, beside
from ehamj.control.channels import MountChannels
from ehamj.control.instruments import Instrument
from ehamj.control.inverse import creep, instrument_poles, valve_poles, volts
from ehamj.control.law import Controller
from ehamj.control.lines import Line
from ehamj.control.sensors import Sensors
from ehamj.control.settings import DigitalSettings
from ehamj.control.windup import AntiWindup
from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.plant.layout import MOTION_NAMES
from ehamj.plant.plant import Plant
from ehamj.settings import Positive

if TYPE_CHECKING:
    Motion = str
else:
    Motion = Literal[tuple(MOTION_NAMES.values())]


class Resonance(NamedTuple):
    """How strong and how wide a resonator is."""

    gain: float
    """Loop gain at its line [-]."""
    damping: float
    """ζ [-]."""


MOST_LINES = 100
"""Each is a resonator for every motion that is held: two states."""


class LineSettings(DigitalSettings):
    """Resonators at lines: what an architecture of them has."""

    lines: tuple[Positive, ...] = Field(
        description="frequencies of the lines [Hz]", min_length=1, max_length=MOST_LINES
    )
    motions: tuple[Motion, ...] | None = Field(
        None, description="motions that are held still at the lines; without: all that the mounts drive", min_length=1
    )

    @field_validator("lines", "motions")
    @classmethod
    def _once(cls, given: "tuple[float | str, ...] | None") -> "tuple[float | str, ...] | None":
        twice = [one for k, one in enumerate(given or ()) if given and one in given[:k]]
        if twice:
            raise ValueError(f"{twice[0]} is there twice; each must be there once")
        return given

    @abstractmethod
    def resonance(self, line: float) -> Resonance:
        """The resonators of a ``line`` [Hz]."""

    def followed(self, pairs: int) -> tuple[Line, ...]:
        """Lines that the law follows, where each has so many ``pairs`` of states; none: it stays where it is."""
        return ()

    def controller(self, plant: Plant, sensors: Sensors) -> Controller:
        return self.beside((), plant, sensors)

    def beside(self, others: Sequence[DigitalSettings], plant: Plant, sensors: Sensors) -> Controller:
        """The law with the phases that it needs beside others.

        Raises:
            InputError: if a line is not below half the sampling rate, or the mounts do not drive a motion.
        """
        inputs, layout = MountChannels.of(plant).feet, plant.obeying.central
        half = 0.5 * self.rate
        if (high := max(self.lines)) >= half:
            raise InputError(f"control.lines: {high:g} Hz must be below half of control.rate, {half:g} Hz")
        own = self._driven(layout.motions)
        actuator, sensor = plant.obeying.actuators[0], sensors.of(inputs[0])
        slow = [creep(plant, layout.spread[:, k]) for k in own]
        of_lines = []
        for line in self.lines:
            answers = [
                self._answer(line, layout.motions[k], actuator, c, sensor, others)
                for k, c in zip(own, slow, strict=True)
            ]
            of_lines.append(beside([_resonator(line, answer, self.resonance(line)) for answer in answers]))
        spread = layout.spread[:, own]
        size = np.sqrt((spread**2).mean(axis=0))  # states are velocities of the pistons, whatever the motion
        law = added([one.between(size[:, None] * layout.fit[own], volts(plant) @ spread / size) for one in of_lines])
        return self.digital(
            law.held(self.period), inputs, plant, sensors=sensors, anti_windup=AntiWindup.NONE,
            lines=self.followed(len(own)),
        )  # fmt: skip

    def _driven(self, motions: Sequence[str]) -> list[int]:
        """Numbers of the motions that are held still, among those that the mounts drive."""
        wanted = motions if self.motions is None else self.motions
        if other := [name for name in wanted if name not in motions]:
            raise InputError(f"control.motions: the mounts do not drive {other[0]}; they drive {', '.join(motions)}")
        return [motions.index(name) for name in wanted]

    def _answer(
        self, line: float, motion: str, actuator: Actuator, creep: float, sensor: Instrument | None,
        others: Sequence[DigitalSettings],
    ) -> complex:  # fmt: skip
        """Measured velocity at ``line`` [Hz] over the piston velocity asked for, with broadband loops closed; half a
        sample of the lag is that of the resonator, which takes its readings as held."""
        s = 2j * np.pi * line
        poles = valve_poles(actuator)
        lag = np.exp(-s * (self.hold + 0.5 * self.period)) * np.prod(poles) / np.prod(s - poles)
        slow, fast = instrument_poles(sensor)
        lag *= np.prod(fast) / np.prod(fast - s) if fast.size else 1.0
        plain = lag * s / (s + creep)
        asked = sum(other.asked(motion, s, creep) for other in others)
        if not asked:
            return complex(plain * (s**slow.size / np.prod(s - slow) if slow.size else 1.0))
        return complex(plain / (1.0 - asked / s * plain))


class ResonantSettings(LineSettings):
    """Resonators at given lines."""

    kind: Literal["resonant"] = "resonant"
    gain: Positive = Field(3.0, description="loop gain at each line [-]; 3 attenuates by 12 dB")
    bandwidth: Annotated[float, Field(gt=0, lt=0.5)] = Field(0.005, description="damping ratio of each resonator [-]")

    def resonance(self, line: float) -> Resonance:
        return Resonance(self.gain, self.bandwidth)


def _resonator(line: float, answer: complex, own: Resonance) -> Block:
    """Piston velocity [m/s] over velocity [m/s], as Re x of ẋ = (−σ + jω_d) x + β v: a pair of states that turns."""
    omega = TWO_PI * line
    decay, turn = own.damping * omega, omega * np.sqrt(1.0 - own.damping**2)
    # At s = jω, half of β/(s + σ − jω_d) + β*/(s + σ + jω_d) is −g over the answer.
    wanted, near, far = -own.gain / answer, 0.5 / (decay + 1j * (omega - turn)), 0.5 / (decay + 1j * (omega + turn))
    beta = (near.conjugate() * wanted - far * wanted.conjugate()) / (abs(near) ** 2 - abs(far) ** 2)
    A = np.array([[-decay, -turn], [turn, -decay]])
    return Block(A, np.array([[beta.real], [beta.imag]]), np.array([[1.0, 0.0]]), np.zeros((1, 1)))
