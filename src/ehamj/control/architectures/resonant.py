"""Narrow-band feedback of the machine's motion at the lines of motors and fans.

For each line a resonator on the velocities of heave, roll and pitch, and of what else the mounts drive,

    ẋ_p = −g·2ζω·(s cos φ − ω sin φ)/(s² + 2ζωs + ω²)·v,

whose loop gain at its line is g, and whose phase φ takes back the lag of instrument, computation, hold and valve there.
Beside a broadband loop (`ehamj.control.architectures.modal`) φ also takes back the turn of that loop's sensitivity.
"""

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from ehamj.control.blocks import TWO_PI, Block, added, beside
from ehamj.control.channels import MountChannels
from ehamj.control.instruments import Instrument
from ehamj.control.inverse import creep, instrument_poles, valve_poles, volts
from ehamj.control.law import Controller
from ehamj.control.sensors import Sensors
from ehamj.control.settings import DigitalSettings
from ehamj.control.windup import AntiWindup
from ehamj.isolator.actuator import Actuator
from ehamj.plant.plant import Plant
from ehamj.settings import Positive


class ResonantSettings(DigitalSettings):
    """Resonators at given lines."""

    kind: Literal["resonant"] = "resonant"
    lines: tuple[Positive, ...] = Field(description="frequencies of the lines [Hz]", min_length=1)
    gain: Positive = Field(3.0, description="loop gain at each line [-]; 3 attenuates by 12 dB")
    bandwidth: Annotated[float, Field(gt=0, lt=0.5)] = Field(0.005, description="damping ratio of each resonator [-]")

    def controller(self, plant: Plant, sensors: Sensors) -> Controller:
        return self.beside((), plant, sensors)

    def beside(self, others: Sequence[DigitalSettings], plant: Plant, sensors: Sensors) -> Controller:
        """The law with the phases that it needs beside others."""
        inputs, layout = MountChannels.of(plant).feet, plant.obeying.central
        actuator, sensor = plant.obeying.actuators[0], sensors.of(inputs[0])
        loops = []
        for k, motion in enumerate(layout.motions):
            slow = creep(plant, layout.spread[:, k])
            answers = [self._answer(line, motion, actuator, slow, sensor, others) for line in self.lines]
            loops.append(added([self._resonator(*one) for one in zip(self.lines, answers, strict=True)]))
        law = beside(loops).between(layout.fit, volts(plant) @ layout.spread)
        return self.digital(law.sampled(self.period), inputs, plant, sensors=sensors, anti_windup=AntiWindup.NONE)

    def _answer(
        self, line: float, motion: str, actuator: Actuator, creep: float, sensor: Instrument | None,
        others: Sequence[DigitalSettings],
    ) -> complex:  # fmt: skip
        """Measured velocity at ``line`` [Hz] over the piston velocity asked for, with broadband loops closed."""
        s = 2j * np.pi * line
        poles = valve_poles(actuator)
        lag = np.exp(-s * self.hold) * np.prod(poles) / np.prod(s - poles)
        slow, fast = instrument_poles(sensor)
        lag *= np.prod(fast) / np.prod(fast - s) if fast.size else 1.0
        plain = lag * s / (s + creep)
        asked = sum(other.asked(motion, s, creep) for other in others)
        if not asked:
            return complex(plain * (s**slow.size / np.prod(s - slow) if slow.size else 1.0))
        return complex(plain / (1.0 - asked / s * plain))

    def _resonator(self, line: float, answer: complex) -> Block:
        """Piston velocity [m/s] over velocity [m/s]."""
        omega, zeta = TWO_PI * line, self.bandwidth
        wanted = -self.gain / answer
        A = omega * np.array([[0.0, 1.0], [-1.0, -2.0 * zeta]])
        # At its line, 2ζω s/(s² + 2ζωs + ω²) is one, and 2ζω·ω/(…) is −j.
        C = 2.0 * zeta * np.array([[-wanted.imag, wanted.real]])
        return Block(A, np.array([[0.0], [omega]]), C, np.zeros((1, 1)))
