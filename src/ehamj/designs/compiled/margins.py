"""Margins of one loop gain after the other while frequencies rise, as `ehamj.linear.margins.margins` has them."""

import math

from ehamj.compiled import kernel
from ehamj.designs.compiled.machine import inverse_of, size_of

LEAST = 1e-140
"""Sensitivity that is none."""


@kernel
def begin(best):  # type: ignore[no-untyped-def]
    """Nothing is known yet of a place: least gain [ln] and phase [rad], largest |S − 1/2|² and |S|²."""
    best[0] = best[1] = math.inf
    best[2] = best[3] = 0.0


@kernel
def follow(sensitivity, last, first, best):  # type: ignore[no-untyped-def]
    """Take in the sensitivity of a place at the next frequency; ``last`` holds its loop gain at the one before."""
    away = sensitivity - 0.5
    best[2] = max(best[2], size_of(away))
    best[3] = max(best[3], size_of(sensitivity))
    if size_of(sensitivity) < LEAST * LEAST:
        sensitivity = LEAST + 0.0j
    gain, before = inverse_of(sensitivity) - 1.0, last[0]
    last[0] = gain
    if first:
        return
    one, two = size_of(before), size_of(gain)
    crosses = (one - 1.0) * (two - 1.0) < 0.0
    turns = (before.imag < 0.0) != (gain.imag < 0.0) and (
        before.real * abs(gain.imag) + gain.real * abs(before.imag) < 0.0
    )
    if not (crosses or turns):
        return
    log_one, log_two = 0.5 * math.log(max(one, 1e-300)), 0.5 * math.log(max(two, 1e-300))
    angle = math.atan2(before.imag, before.real)
    turned = math.atan2(gain.imag, gain.real) - angle
    if turned > math.pi:
        turned -= 2.0 * math.pi
    elif turned < -math.pi:
        turned += 2.0 * math.pi
    if crosses:
        there = angle + turned * log_one / (log_one - log_two)
        best[1] = min(best[1], abs((there + 2.0 * math.pi) % (2.0 * math.pi) - math.pi))
    if turns and turned != 0.0:
        part = ((math.pi if turned > 0.0 else -math.pi) - angle) / turned
        best[0] = min(best[0], abs(log_one + part * (log_two - log_one)))
