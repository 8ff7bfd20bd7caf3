"""Feedback of absolute motion: the loop of one motion, and the measurement of displacement that it acts on.

A displacement is measured by two instruments that complement each other (as HEPI's sensor blending does):

    y = H(s)·(inertial displacement) + (1 − H(s))·(stroke + ground displacement)

with H a third-order high-pass. Above its corner the loop holds the machine still in space, below it over its ground:
that needs no drifting integral of an inertial sensor, and no high-pass that costs phase. The loop acts on the piston's
velocity,

    ẋ_p = −2π f_c·(1 + c/s)·(1 + 2π f_i/s)·notch(s)·lead(s)·y,

where (1 + c/s) inverts leakage and membrane (`ehamj.control.inverse`), so that the loop gain is f_c/f times the
valve's lag and the oil's resonance.
"""

from typing import Annotated

import numpy as np
from pydantic import Field

from ehamj.control.blocks import TWO_PI, Block, added, beside, joined, pair
from ehamj.control.instruments import Instrument
from ehamj.control.inverse import instrument_poles, restoring
from ehamj.control.lowend import yielding
from ehamj.errors import InputError
from ehamj.settings import NotNegative, Positive, Settings

LEAK = 0.01
"""Corner at which the loops' integrals end [Hz]: static loads remain, and nothing winds up for ever."""


class MotionLoop(Settings):
    """The loop of one motion."""

    crossing: NotNegative = Field(description="f_c: frequency at which the ideal loop gain is one [Hz]; 0: no loop")
    integral: NotNegative = Field(12.0, description="f_i: corner below which the loop gain rises twice as fast [Hz]")
    lead: NotNegative = Field(0.0, description="corner of a lead, whose gain ends at eight times it [Hz]; 0: none")
    notch: Positive = Field(500.0, description="centre of the dip that keeps the oil's resonance low [Hz]")
    notch_depth: Annotated[float, Field(gt=0, le=1)] = Field(0.5, description="gain in its centre [-]")
    notch_width: Positive = Field(2.0, description="its width: damping ratio of its poles [-]")
    rolloff: Positive = Field(10_000.0, description="corner of the first-order roll-off [Hz]")

    def block(self, creep: float) -> Block:
        """Piston velocity [m/s] over displacement [m] (or rates over angles)."""
        zeros: list[complex] = [-creep, -TWO_PI * self.integral] if self.integral else [-creep]
        poles: list[complex] = [*(complex(-TWO_PI * LEAK) for _ in zeros), -TWO_PI * self.rolloff]
        zeros.extend(pair(self.notch, self.notch_depth * self.notch_width))
        poles.extend(pair(self.notch, self.notch_width))
        gain = TWO_PI * self.crossing * TWO_PI * self.rolloff
        if self.lead:
            zeros.append(-TWO_PI * self.lead)
            poles.append(-8.0 * TWO_PI * self.lead)
            gain *= 8.0
        return Block.filter(zeros, poles, -gain)


class Blend(Settings):
    """How inertial and relative sensors are blended into one displacement."""

    corner: Positive = Field(0.15, description="above it inertial sensors are believed, below it strokes [Hz]")
    restore: Positive = Field(0.05, description="corner to which the ground instrument's high-pass is moved down [Hz]")

    def block(self, foot: Instrument | None, ground: Instrument | None, isolate_from: float = 0.0) -> Block:
        """Displacement [m] from inertial velocity [m/s], stroke [m] and ground velocity [m/s].

        H = s³/(s³ + a s² + b s + d): the strokes' share is (a s² + b s + d)/(…), the inertial velocity's s²/(…) less
        the high-pass that the instrument has anyway. With ``isolate_from`` [Hz] the displacement is counted from where
        the machine is meant to follow the floor (`ehamj.control.lowend`).

        Raises:
            InputError: if the inertial instrument's high-pass is of more than second order.
        """
        omega = TWO_PI * self.corner
        a, b, d = 2.0 * omega, 2.0 * omega**2, omega**3
        slow, _ = instrument_poles(foot)
        if slow.size > 2:
            raise InputError(
                f"sensors.inertial.order = {slow.size}: must be at most 2 for feedback, which takes the high-pass back"
            )
        numerator = np.concatenate([np.atleast_1d(np.poly(slow)).real, np.zeros(2 - slow.size)])
        # States of one size: displacement and what leads to it, in units of the corner.
        A = np.array([[-a, omega, 0.0], [-b / omega, 0.0, omega], [-d / omega**2, 0.0, 0.0]])
        shares = np.array([numerator, [a, b, d]]).T / omega ** np.arange(3)[:, None]
        blend = Block(A, shares, np.array([[1.0, 0.0, 0.0]]), np.zeros((1, 2)))
        moved = self.ground(ground)
        full = beside([Block.gain(np.eye(2)), moved]).then(Block.gain([[1.0, 0.0, 0.0], [0.0, 1.0, 1.0]])).then(blend)
        if not isolate_from:
            return full
        followed = moved.then(yielding(isolate_from)).times(-1.0)
        return added([full, followed.between([[0.0, 0.0, 1.0]], [[1.0]])])

    def seeing(self, foot: Instrument | None, ground: Instrument | None, isolate_from: float, upstream: bool) -> Block:
        """`block`; with a sensor ``upstream`` and isolation that begins somewhere it has one input more, the velocity
        [m/s] that the machine follows (`ehamj.control.preview`)."""
        if not (upstream and isolate_from):
            return self.block(foot, ground, isolate_from)
        return joined([self.block(foot, ground), self.ground(ground).times(-1.0)])

    def ground(self, sensor: Instrument | None) -> Block:
        """Displacement of the ground [m] from its measured velocity [m/s], above ``restore``."""
        poles, moved = restoring(instrument_poles(sensor)[0], self.restore)
        return Block.filter(poles, np.append(moved, -TWO_PI * self.restore), 1.0)
