"""Anti-windup: how a law's states learn that the valves did not get what it wanted.

While a command is limited, x⁺ = A x + B u + L (applied − C x − D u) is an observer of the law by its own applied
command (Åström and Wittenmark, Computer-Controlled Systems, 3rd ed., sec. 9.4): its poles are those of A − L C.
"""

from enum import Enum

import numpy as np
import scipy

from ehamj.arrays import Array
from ehamj.control.blocks import Block
from ehamj.errors import InputError


class AntiWindup(Enum):
    """How an architecture's states learn what the valves did not get; it says so, or gives the matrix L."""

    NONE = "they do not"
    INPUTS = "by inputs of its block, one per valve after those measured: applied − wanted [V]"
    DUAL_LQ = "by `anti_windup_gain`, over the time of recovery"


def parted(
    block: Block, measured: int, choice: AntiWindup | Array, period: float, recovery: float
) -> tuple[Block, Array | None]:
    """A law's block of the ``measured`` inputs alone, and its L (states, valves), none without anti-windup.

    Raises:
        ValueError: if the block's inputs are not those that the choice needs, or it answers what was lost at once.
        InputError: as `anti_windup_gain`.
    """
    A, B, C, D = block
    wanted = measured + (C.shape[0] if choice is AntiWindup.INPUTS else 0)
    if B.shape[1] != wanted:
        raise ValueError(f"a law that measures {measured} channels with {choice} has {B.shape[1]} inputs, not {wanted}")
    if np.any(D[:, measured:]):
        raise ValueError("a law answers at once what the valves did not get")
    law = Block(A, B[:, :measured], C, D[:, :measured])
    if choice is AntiWindup.INPUTS:
        return law, B[:, measured:]
    if choice is AntiWindup.DUAL_LQ:
        return law, anti_windup_gain(A, C, period, recovery)
    return law, None if choice is AntiWindup.NONE else np.asarray(choice, float)


def limited_radius(A: Array, C: Array, gain: Array) -> float:
    """Spectral radius of A − L C: above one, the law runs away while its commands are limited."""
    return float(np.abs(np.linalg.eigvals(A - gain @ C)).max()) if A.size else 0.0


def anti_windup_gain(A: Array, C: Array, period: float, time: float) -> Array:
    """L (states, outputs) by the dual of LQ, independent of how the states are scaled.

    The states are scaled by what each adds to the commands over ``time`` (observability Gramian, forgotten as
    e^(−t/time)); in this scale the weight of states over commands is period/(2 time), which takes an integrator back
    with just that time constant. Modes faster than that are hardly touched.

    Raises:
        InputError: if ``time`` is shorter than a period, or a state on the border of stability does not show in any
            command, so that no gain can hold it.
    """
    if not (np.isfinite(time) and time >= period):
        raise InputError(f"anti-windup: time = {time:g} s must be at least the controller's period, {period:g} s")
    n, m = A.shape[0], C.shape[0]
    scale, seen = _scale(A * np.exp(-period / time), C) if np.any(C) else (np.zeros((n, 0)), np.zeros((0, n)))
    gain = np.zeros((n, m))
    if seen.size:
        Ao, Co = seen @ A @ scale, C @ scale
        try:
            P = scipy.linalg.solve_discrete_are(Ao.T, Co.T, np.eye(Ao.shape[0]) * period / (2.0 * time), np.eye(m))
        except (np.linalg.LinAlgError, ValueError) as error:
            raise InputError(f"anti-windup: no stable choice exists for this law ({error}); give the matrix") from error
        gain = np.asarray(scale @ np.linalg.solve(Co @ P @ Co.T + np.eye(m), Co @ P @ Ao.T).T)
    if limited_radius(A, C, gain) >= 1.0:
        raise InputError("anti-windup: a state on the border of stability shows in no command; remove it from the law")
    return gain


def _scale(A: Array, C: Array) -> tuple[Array, Array]:
    """Scaled states → states, and back, for the states that show in the commands; the others are left out."""
    gramian = scipy.linalg.solve_discrete_lyapunov(A.T, C.T @ C)
    size = np.sqrt(np.maximum(np.diag(gramian), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(gramian / np.outer(size, size))
    kept = values > 1e-10 * values.max()
    root = np.sqrt(values[kept])
    return vectors[:, kept] / size[:, None] / root, (vectors[:, kept] * root).T * size
