"""H∞ synthesis: mixed sensitivity of heave, roll and pitch, with weights from floor, noise and valve.

For each motion, with plant G (`ehamj.synthesis.plants`, normalised by ω₀ = 2π·``bandwidth``, so that G ≈ ω₀/(s + c)),

    y = d + G(u + g·e)          z = (W₁·y, ``effort``·u, W_v·u, ``sway``·v/ω₀)
    measured = y + r·n₁, and v/ω₀ + ``doubt``·n₂

(v: sideways velocity, of roll and pitch) find the u = K·measured that minimises the H∞ norm from (d, e, n) to z.
W₁ = (s + ω₀)(s + ω_i)/(s + ω_l)² is how much each frequency of the floor counts: displacement of a floor of even
velocity rises as 1/f, and below ``integral`` as 1/f². A disturbance e behind the valve keeps K from cancelling the
oil's resonance, which another oil moves (Zhou, Doyle and Glover, Robust and Optimal Control, 1996, sec. 16.3);
``effort`` keeps the gain low above the bandwidth. r is the instrument's noise over the floor in the third-octave at the
bandwidth. W_v is the command that the floor's displacement asks for, over a third of the valve's range (the rest is for
peaks): it binds on floors far too strong for the valves.

Solved by slycot's SB10AD; the law is the suboptimal central one a little above the least norm, whose fast poles stay
within reach, reduced by balanced truncation.
"""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from ehamj.control.blocks import TWO_PI, Block, added, beside
from ehamj.control.inverse import Inverse
from ehamj.control.sensors import Sensors
from ehamj.errors import InputError
from ehamj.plant.plant import Plant
from ehamj.synthesis.images import normalised, reduced, restored, towards_one
from ehamj.synthesis.settings import MotionWeights, SynthesisSettings

PEAK = 3.0
"""Peak over RMS of a floor's command."""
FLOOR_FROM = 1.0
"""Frequency from which on the floor's velocity is even [Hz]."""


class HInfinitySettings(SynthesisSettings):
    """H∞ mixed sensitivity of the machine's motions beside feedforward."""

    kind: Literal["h-infinity"] = "h-infinity"
    heave: MotionWeights = MotionWeights.stated(bandwidth=27.0, integral=23.7, effort=0.00256, inside=2.26)
    roll: MotionWeights = MotionWeights.stated(
        bandwidth=20.4, integral=14.4, effort=0.00144, inside=4.42, sway=0.167, doubt=5.06
    )
    pitch: MotionWeights = MotionWeights.stated(
        bandwidth=57.2, integral=51.4, effort=0.0291, inside=0.142, sway=1.51, doubt=0.549
    )
    above: Annotated[float, Field(gt=1)] = Field(1.05, description="norm of the law over the least possible [-]")

    def loop(self, motion: Block, weights: MotionWeights, plant: Plant, sensors: Sensors) -> Block:
        return mixed_sensitivity(motion, weights, self, plant, sensors)[0]


def mixed_sensitivity(
    motion: Block, weights: MotionWeights, settings: HInfinitySettings, plant: Plant, sensors: Sensors
) -> tuple[Block, float]:
    """The loop of one motion, piston velocity over displacement, and the least norm.

    Raises:
        InputError: if there is none.
    """
    import slycot

    A, B, C, D = generalised(motion, weights, settings, plant, sensors)
    size = (A.shape[0], B.shape[1], C.shape[0], 1, motion.C.shape[0])
    try:
        least = slycot.sb10ad(*size, 1e6, A, B, C, D, 1, 1e-3, 0.0)[0]
        _, *law = slycot.sb10ad(*size, settings.above * least, A, B, C, D, 4, 1e-3, 0.0)[:5]
    except (ArithmeticError, slycot.exceptions.SlycotError) as error:
        raise InputError(f"design: no H∞ law for {weights!r} ({error}); widen or soften the weights") from error
    return reduced(restored(Block(*law), weights), settings.order), float(least)


def generalised(
    motion: Block, weights: MotionWeights, settings: HInfinitySettings, plant: Plant, sensors: Sensors
) -> Block:
    """From (d, e, noises, u) to (z₁, z₂, z₃, z₄ of roll and pitch, then the measured), in units of ω₀."""
    G = normalised(motion, weights)
    r, low = settings.noise_over_floor(weights, sensors), settings.low(weights, sensors)
    outputs = G.C.shape[0]
    inputs = 2 + outputs + 1
    moved, floor, noise = np.zeros((1, inputs)), np.zeros((outputs, inputs)), np.zeros((outputs, inputs))
    moved[0, [1, -1]] = weights.inside, 1.0
    floor[0, 0] = 1.0
    noise[:, 2:-1] = np.diag([r, weights.doubt][:outputs])
    true = added([G.between(moved, np.eye(outputs)), Block.gain(floor)])
    # Beside each other: y (and sideways velocity), u twice, what is measured.
    repeated = true.between(np.eye(inputs), np.vstack([np.eye(outputs), np.zeros((2, outputs)), np.eye(outputs)]))
    command = np.zeros((outputs, inputs)), np.eye(1, inputs, inputs - 1), np.eye(1, inputs, inputs - 1), noise
    W1 = towards_one(1.0, low).then(towards_one(weights.integral / weights.bandwidth, low))
    weighed = [W1, *([Block.gain([[weights.sway]])] if outputs > 1 else [])]
    weighed += [Block.gain([[weights.effort]]), _voltage(weights, settings, plant), Block.gain(np.eye(outputs))]
    return added([repeated, Block.gain(np.vstack(command))]).then(beside(weighed))


def _voltage(weights: MotionWeights, settings: HInfinitySettings, plant: Plant) -> Block:
    """W_v, in units of ω₀: from u = ẋ_p/ω₀ per displacement of the floor to the share of the range."""
    actuator = plant.actuators[0]
    omega, low = TWO_PI * weights.bandwidth, FLOOR_FROM / weights.bandwidth
    per_displacement = Inverse.of(actuator).volts * omega * settings.floor / omega  # V at ω₀ for u = 1
    share = np.sqrt(per_displacement * PEAK / actuator.voltage_limit)
    return Block(*(np.array([[value]]) for value in (-low, share, share, 0.0)))
