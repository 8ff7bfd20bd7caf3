"""LQG synthesis: Kalman filter and optimal feedback for heave, roll and pitch.

For each motion, with plant G (`ehamj.synthesis.plants`, normalised by ω₀ = 2π·``bandwidth``, so that G ≈ ω₀/(s + c)),

    y = d + G(u + g·e),   measured = y + n₁, and v/ω₀ + ``doubt``·n₂,   u = (s + ω₀)/(s + ω_l)·c,
    cost = E[y² + (``effort``·c)² + (``sway``·v/ω₀)²]

(v: sideways velocity, of roll and pitch). The floor d is white noise through ω₀(s + ω_i)/(s + ω_l)²: a floor of even
velocity moves as 1/f, and below ``integral`` it counts as 1/f². The noise n₁ is white and equals the floor at the
bandwidth; it stands for all that is not known of the machine above, since the instruments' own noise is far smaller and
would leave no margins (Doyle, IEEE TAC 23(4), 1978). So does e behind the valve, which recovers margins (Doyle and
Stein, IEEE TAC 24(4), 1979). Penalising c instead of u costs nothing at low frequency, where the floor must be
cancelled. The integrals end at ω_l, where d is 1/r times the noise, r being the instrument's noise over the floor.
"""

from typing import Literal

import numpy as np
import scipy

from ehamj.control.blocks import Block
from ehamj.control.sensors import Sensors
from ehamj.errors import InputError
from ehamj.plant.plant import Plant
from ehamj.synthesis.images import normalised, reduced, restored, towards_one
from ehamj.synthesis.settings import MotionWeights, SynthesisSettings


class LqgSettings(SynthesisSettings):
    """LQG control of the machine's motions beside feedforward."""

    kind: Literal["lqg"] = "lqg"
    heave: MotionWeights = MotionWeights.stated(bandwidth=94.4, integral=40.0, effort=0.00311, inside=0.0841, gain=0.9)
    roll: MotionWeights = MotionWeights.stated(
        bandwidth=116.0, integral=33.0, effort=0.00789, inside=0.415, sway=0.7, doubt=0.514, gain=0.95
    )
    pitch: MotionWeights = MotionWeights.stated(
        bandwidth=144.0, integral=50.0, effort=0.0032, inside=0.0632, sway=0.732, doubt=0.127, gain=0.9
    )

    def loop(self, motion: Block, weights: MotionWeights, plant: Plant, sensors: Sensors) -> Block:
        import control

        integral, low = weights.integral / weights.bandwidth, self.low(weights, sensors)
        G = normalised(motion, weights)
        own = towards_one(1.0, low).then(G)  # from c
        # Floor: white noise through (s + integral)/(s + low)·1/(s + low).
        last = Block(np.array([[-low]]), np.array([[1.0]]), np.array([[1.0]]), np.zeros((1, 1)))
        floor = towards_one(integral, low).then(last)
        n, m, outputs = own.A.shape[0], floor.A.shape[0], G.C.shape[0]
        A, B = np.asarray(scipy.linalg.block_diag(own.A, floor.A)), np.vstack([own.B, np.zeros((m, 1))])
        C, D = np.hstack([own.C, np.eye(outputs, 1) @ floor.C]), own.D
        behind = np.vstack([np.zeros((1, 1)), G.B, np.zeros((m, 1))])  # the state of (s + 1)/(s + low) comes first
        shakes = np.hstack([weights.inside * behind, np.vstack([np.zeros((n, 1)), floor.B])])
        counts, doubts = np.diag([1.0, weights.sway**2][:outputs]), np.diag([1.0, weights.doubt**2][:outputs])
        try:
            # What counts is C x + D c: the cost has terms of state and command together.
            F, _, _ = control.lqr(A, B, C.T @ counts @ C, D.T @ counts @ D + weights.effort**2, C.T @ counts @ D)
            L, _, _ = control.lqe(A, shakes, C, np.eye(2), doubts)
        except (np.linalg.LinAlgError, control.ControlDimension, ValueError, ArithmeticError) as error:
            raise InputError(f"design: no LQG law for {weights!r} ({error}); change the weights") from error
        inside = Block(A - B @ F - L @ (C - D @ F), L, -F, np.zeros((1, outputs)))
        return reduced(restored(inside.then(towards_one(1.0, low)), weights), self.order)
