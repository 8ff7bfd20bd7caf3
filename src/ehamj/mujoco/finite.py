"""Feet of a machine that turns: where they are, how they move, and what forces on them do; without loss at 1e-9 rad.

The engine's tendons are the linear part, J·q about the machine at rest. Here is what finite rotations add to it: the
foot of a mount at r moves by u + (R − 1)·r, and forces act on it where it then is. R = Rz·Rx·Ry, as the joints are
ordered. Vectors are tuples of three numbers.
"""

import math
from typing import NamedTuple

from ehamj.compiled import kernel

Three = tuple[float, float, float]


class Turn(NamedTuple):
    """A turn of the machine, and its rate."""

    excess: tuple[Three, Three, Three]
    """Rows of R − 1."""
    rx: Three
    """By how much the axis of the hinge rx has turned; that of rz stays."""
    ry: Three
    spin: Three
    """Rates of the hinges about x, y, z [rad/s]."""
    more: Three
    """What the turned axes add to the angular velocity [rad/s]."""


@kernel
def dot(a: Three, b: Three) -> float:
    """a·b"""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: Three, b: Three) -> Three:
    """a × b"""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def plus(a: Three, b: Three) -> Three:
    """a + b"""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@kernel
def times(factor: float, a: Three) -> Three:
    """factor·a"""
    return factor * a[0], factor * a[1], factor * a[2]


@kernel
def across(a: Three, d: Three) -> Three:
    """The part of a across the unit vector d."""
    along = dot(a, d)
    return a[0] - along * d[0], a[1] - along * d[1], a[2] - along * d[2]


@kernel
def turn_of(angles: Three, spin: Three) -> Turn:
    """The turn by hinge angles rx, ry, rz [rad] and their rates.

    1 − cos φ as 2 sin²(φ/2): the difference of two numbers near one would lose what small angles do.
    """
    sx, sy, sz = math.sin(angles[0]), math.sin(angles[1]), math.sin(angles[2])
    vx = 2.0 * math.sin(0.5 * angles[0]) ** 2
    vy = 2.0 * math.sin(0.5 * angles[1]) ** 2
    vz = 2.0 * math.sin(0.5 * angles[2]) ** 2
    cx, cy, cz = 1.0 - vx, 1.0 - vy, 1.0 - vz
    excess = (
        (vz * vy - vz - vy - sz * sx * sy, -sz * cx, cz * sy + sz * sx * cy),
        (sz * cy + cz * sx * sy, vz * vx - vz - vx, sz * sy - cz * sx * cy),
        (-cx * sy, sx, vx * vy - vx - vy),
    )
    rx, ry = (-vz, sz, 0.0), (-sz * cx, vz * vx - vz - vx, sx)
    return Turn(excess, rx, ry, spin, plus(times(spin[0], rx), times(spin[1], ry)))


@kernel
def swung(turn: Turn, r: Three) -> Three:
    """(R − 1)·r: displacement of a point of the machine by the turn [m]."""
    return dot(turn.excess[0], r), dot(turn.excess[1], r), dot(turn.excess[2], r)


@kernel
def beyond(turn: Turn, angles: Three, r: Three) -> tuple[Three, Three]:
    """What the finite turn adds to θ × r [m], and to its rate [m/s]."""
    by = swung(turn, r)
    place = plus(by, times(-1.0, cross(angles, r)))
    return place, plus(cross(turn.more, plus(r, by)), cross(turn.spin, by))


@kernel
def hinge_moments(turn: Turn, at_rest: Three, moved: Three, extra: Three) -> Three:
    """Moments about the hinges rx, ry, rz [N m] that go beyond the linear ones.

    Args:
        turn: of the machine.
        at_rest: Σ r × F of the whole forces F on the feet, at the places r at rest.
        moved: Σ (R − 1) r × F.
        extra: Σ r × (F less what linear theory has).
    """
    total = plus(at_rest, moved)
    x, y, z = plus(extra, moved)
    return x + dot(turn.rx, total), y + dot(turn.ry, total), z
