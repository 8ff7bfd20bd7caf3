"""What synthesis works on: bilinear images of sampled plants and loops, in units of a motion's bandwidth.

Synthesis works on the bilinear image of a sampled plant, s = (2/T)(z − 1)/(z + 1), and the loop that it finds goes
back by the same map (`Block.sampled`): peaks of responses, and with them H∞ norms and margins, are those of the sampled
loop exactly; only frequencies are stretched, f → tan(π f T)/(π T).
"""

import warnings
from typing import TYPE_CHECKING

import numpy as np

from ehamj.control.blocks import TWO_PI, Block
from ehamj.errors import InputError

if TYPE_CHECKING:
    from ehamj.synthesis.settings import MotionWeights


def normalised(plant: Block, weights: "MotionWeights") -> Block:
    """A motion's plant in units of ω₀: time ω₀ t, input piston velocity over ω₀, sideways velocity over ω₀."""
    omega = TWO_PI * weights.bandwidth
    units = np.array([1.0, 1.0 / omega])[: plant.C.shape[0], None]
    return Block(plant.A / omega, plant.B, units * plant.C, omega * units * plant.D)


def restored(law: Block, weights: "MotionWeights") -> Block:
    """The loop for a `normalised` plant in SI."""
    omega = TWO_PI * weights.bandwidth
    units = np.array([omega, 1.0])[: law.B.shape[1]]
    return Block(omega * law.A, law.B * units, omega * law.C, law.D * units).times(weights.gain)


def towards_one(corner: float, low: float) -> Block:
    """(s + corner)/(s + low), its state of a size between input and output: slycot wants that."""
    share = np.sqrt(corner - low)
    return Block(*(np.array([[value]]) for value in (-low, share, share, 1.0)))


def continuous(block: Block, period: float) -> Block:
    """The continuous block whose trapezoidal image (`Block.sampled`) is this sampled one."""
    A, B, C, D = block
    inverse = np.linalg.inv(np.eye(A.shape[0]) + A)
    return Block(
        2.0 / period * (A - np.eye(A.shape[0])) @ inverse, 2.0 / period * inverse @ B, 2.0 * C @ inverse,
        D - C @ inverse @ B,
    )  # fmt: skip


def reduced(block: Block, order: int) -> Block:
    """A stable block with at most ``order`` states by balanced truncation (slycot AB09AD); it keeps its fast end.

    Raises:
        InputError: if the block is not stable.
    """
    import control

    if block.A.shape[0] <= order:
        return block
    if np.linalg.eigvals(block.A).real.max() >= 0.0:
        raise InputError(
            "design: what is to be reduced is not stable; loosen the weights, or check warp and sway loops"
        )
    with warnings.catch_warnings():
        # A block whose minimal realisation is smaller still becomes that one, which is what is wanted.
        warnings.filterwarnings("ignore", message="(?s).*greater.*minimal realization")
        small = control.balred(control.ss(*block), order, method="truncate")
    return Block(small.A, small.B, small.C, small.D)
