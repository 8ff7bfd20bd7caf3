"""The right-hand side of the reference model.

State of n mounts: coordinates x, y, z, rx, ry, rz (6), their rates (6), spools (n) [mA], their rates (n), pressures
(mount, chamber) (2n) [Pa]; with a shared supply the accumulator's pressure [Pa], the line's flow [m³/s] and the
manifold's pressure [Pa].
"""

import math
from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from ehamj.verify.reference.inputs import GRID

ATMOSPHERE = 101325.0
"""Pressure at which the air fraction and the walls' stretch are stated [Pa]."""


def _compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    return numba.njit(error_model="numpy", cache=True)(function)


@_compiled
def _quintic(k, s):  # type: ignore[no-untyped-def]
    return ((((k[5] * s + k[4]) * s + k[3]) * s + k[2]) * s + k[1]) * s + k[0]


@_compiled
def _slope(k, s):  # type: ignore[no-untyped-def]
    return ((((5 * k[5] * s + 4 * k[4]) * s + 3 * k[3]) * s + 2 * k[2]) * s + k[1]) / GRID


@_compiled
def _edge(gain, opening, drop, rated, eps, leakage):  # type: ignore[no-untyped-def]
    """Flow over one edge: K_Q·opening·φ(Δp/Δp₀) and a laminar leak."""
    r = drop / rated
    root = (r * r + eps * eps) ** 0.25
    turbulent = gain * opening * r / root if root > 0.0 else 0.0
    return turbulent + leakage * drop


@_compiled
def drive(c, i, spool, voltage):  # type: ignore[no-untyped-def]
    """Force of the solenoid over the spool's mass [mA/s²]."""
    error = c.K_v[i] * max(-c.v_max[i], min(c.v_max[i], voltage)) - spool
    if abs(error) <= c.threshold[i]:
        return 0.0
    error -= math.copysign(c.threshold[i], error)
    return max(-c.a_max[i], min(c.a_max[i], c.omega[i] ** 2 * error))


@_compiled
def _modulus(c, i, p):  # type: ignore[no-untyped-def]
    """Bulk modulus of liquid with polytropic air at the pressure p: harmonic by volume."""
    if c.air[i] == 0.0:
        return c.beta[i]
    liquid = (1.0 - c.air[i]) * math.exp(-(p - ATMOSPHERE) / c.beta[i])
    gas = c.air[i] * (ATMOSPHERE / p) ** (1.0 / c.exponent[i])
    share = gas / (liquid + gas)
    return 1.0 / ((1.0 - share) / c.beta[i] + share / (c.exponent[i] * p))


@_compiled
def _stand(c, i, y, ground, s, p1, p2, force):  # type: ignore[no-untyped-def]
    """Add a mount's forces to the machine's; returns its stroke and the stroke's rate."""
    offset, speed = 0.0, 0.0
    for axis in range(3):
        offset, speed = -_quintic(ground[axis], s), -_slope(ground[axis], s)
        for j in range(6):
            offset += c.feet[i, axis, j] * y[j]
            speed += c.feet[i, axis, j] * y[6 + j]
        push = -c.stiffness[i, axis] * offset - c.damping[i, axis] * speed
        if axis == 2:
            push += c.area[i, 0] * p1 - c.area[i, 1] * p2
        for j in range(6):
            force[j] += c.feet[i, axis, j] * push
    return offset, speed


@_compiled
def _opening(c, i, edge):  # type: ignore[no-untyped-def]
    """Opening behind the metering edges' position, along the flow curve [mA]."""
    opening = max(-c.stroke[i], min(c.stroke[i], edge + c.offset[i]))
    share = np.interp(abs(opening) / c.stroke[i], c.curve[i, 0], c.curve[i, 1])
    return math.copysign(share * c.stroke[i], opening)


@_compiled
def _flows(c, i, opening, supply, p1, p2):  # type: ignore[no-untyped-def]
    """What flows into chamber 1 and 2, and what is taken from the supply [m³/s]."""
    rated = 0.5 * (c.P_s - c.P_t)
    e0 = min(max(opening - c.laps[i, 0], 0.0), c.stroke[i])
    e1 = min(max(-opening - c.laps[i, 1], 0.0), c.stroke[i])
    e2 = min(max(-opening - c.laps[i, 2], 0.0), c.stroke[i])
    e3 = min(max(opening - c.laps[i, 3], 0.0), c.stroke[i])
    from_1 = _edge(c.K_Q[i], e0, supply - p1, rated, c.eps[i], c.g0[i])
    to_1 = _edge(c.K_Q[i], e1, p1 - c.P_t, rated, c.eps[i], c.g0[i])
    from_2 = _edge(c.K_Q[i], e2, supply - p2, rated, c.eps[i], c.g0[i])
    to_2 = _edge(c.K_Q[i], e3, p2 - c.P_t, rated, c.eps[i], c.g0[i])
    across = c.cross[i] * (p1 - p2)
    return from_1 - to_1 - across, from_2 - to_2 + across, from_1 + from_2


@_compiled
def _compress(c, i, chamber, state, p, flow, offset, speed):  # type: ignore[no-untyped-def]
    """Rate of a chamber's pressure state [Pa/s]."""
    sign = 1.0 if chamber == 0 else -1.0
    stretch = 1.0 + (state - ATMOSPHERE) * c.wall[i]
    volume = c.volume[i, chamber] + sign * c.moves[i] * c.area[i, chamber] * offset
    # compliance of oil and walls at this pressure [m³/Pa]
    compliance = volume * (stretch / _modulus(c, i, p) + c.wall[i])
    # Below the vapour pressure the state stands for a void: p_v − p = −β ln(share that is oil). What the oil's
    # volume gains must be the flow, so that the flow counts more the less oil there is.
    filled = math.exp(min(state - c.vapour[i], 0.0) / _modulus(c, i, p))
    return (flow / filled - stretch * sign * c.area[i, chamber] * speed) / compliance


@_compiled
def _station(c, accumulator, line, manifold, drawn, out):  # type: ignore[no-untyped-def]
    """Rates of the shared supply."""
    conductance, limit, gas, precharge, n, resistance, inertance, volume, beta = c.supply
    pump = min(max(conductance * (c.P_s - accumulator), 0.0), limit)
    filled = gas * (precharge / accumulator) ** (1.0 / n)
    out[0] = n * accumulator / filled * (pump - line)
    out[1] = (accumulator - manifold - resistance * line) / inertance
    out[2] = beta / volume * (line - drawn)


@_compiled
def rates(t, y, c, quintics, held, side, memory, stopped, out):  # type: ignore[no-untyped-def]
    """Time derivative of the state; ``held`` [V] comes from a controller, the modes from the integration."""
    n = c.area.shape[0]
    piece = min(max(int(t / GRID), 0), quintics.shape[0] - 1)
    s = t / GRID - piece
    force = c.weight + c.topple * y[:6]
    shared = c.supply.size > 0
    first_pressure, station = 12 + 2 * n, 12 + 4 * n
    supply = y[station + 2] if shared else c.P_s
    drawn = 0.0
    for i in range(n):
        k = first_pressure + 2 * i
        p1, p2 = max(y[k], c.vapour[i]), max(y[k + 1], c.vapour[i])
        offset, speed = _stand(c, i, y, quintics[piece, 3 * i : 3 * i + 3], s, p1, p2, force)
        spool, rate = y[12 + i], y[12 + n + i]
        if stopped[i] != 0.0:
            out[12 + i] = out[12 + n + i] = 0.0
        else:
            pull = drive(c, i, spool, held[i] + _quintic(quintics[piece, 3 * n + i], s))
            out[12 + i] = rate
            out[12 + n + i] = pull - 2.0 * c.zeta[i] * c.omega[i] * rate
        edge = memory[i] if side[i] == 0.0 and c.play[i] > 0.0 else spool - side[i] * 0.5 * c.play[i]
        into_1, into_2, taken = _flows(c, i, _opening(c, i, edge), supply, p1, p2)
        drawn += taken
        out[k] = _compress(c, i, 0, y[k], p1, into_1, offset, speed)
        out[k + 1] = _compress(c, i, 1, y[k + 1], p2, into_2, offset, speed)
    out[:6] = y[6:12]
    out[6:12] = c.inverse_mass @ force
    if shared:
        _station(c, y[station], y[station + 1], y[station + 2], drawn, out[station:])
