"""From a wanted flow to the command that makes a real valve give it, compiled: the inverse of what a valve is known
to do.

A law's voltage u asks for the flow K_Q·y, y = K_v·u, that an ideal valve gives at its rated pressure drop. The valve,
whose edges open as z = c(x + x_n) (flow curve, null offset), gives

    y = a·[φ_s1·(z − x_s1)⁺ − φ_1t·(−z − x_1t)⁺] + (1 − a)·[φ_2t·(z − x_2t)⁺ − φ_s2·(−z − x_s2)⁺],

a the part of chamber 1 in what drives the piston, φ = √(Δp/Δp₀) of each edge's measured drop, and x_s1 … its overlap.
Solved for x, where no edge is open with a jump that is spread over a band (as where the flow curve begins flat), it is
what the edges are to do; the spool stands to one side of them by its play (`leaning`).
"""

import math
from typing import Final, NamedTuple

from ehamj.compiled import kernel, written
from ehamj.compiled.lanes import peek
from ehamj.control.valves import Known
from ehamj.isolator.edges import turbulence
from ehamj.isolator.flow_curve import POINTS

FIELDS: Final = len(Known._fields)
SUPPLY: Final = Known._fields.index("supply")
SIZE: Final = FIELDS + POINTS
"""Numbers known of a valve: `Known`, and the shares of flow of its curve."""
HELD: Final = 3.0
"""Wanted of the other side before the spool leaves its own while little is wanted, over what that is."""


class Pressures(NamedTuple):
    """Absolute pressures of both chambers and of the supply, as they are measured [Pa]."""

    pressure_1: float
    pressure_2: float
    supply: float


class Edges(NamedTuple):
    """What is let through per opening of each edge [-]."""

    supply_1: float
    tank_1: float
    supply_2: float
    tank_2: float


@kernel
def drop_factor(drop: float, own: Known) -> float:
    """φ of a pressure drop [Pa]."""
    return min(max(turbulence(drop / own.rated, own.laminar), own.least), own.most)


@kernel
def edges_of(at: Pressures, own: Known) -> Edges:
    """What each edge lets through at absolute pressures of the chambers and the supply [Pa]."""
    one, two = own.share, 1.0 - own.share
    if own.least >= own.most:
        return Edges(one, one, two, two)
    return Edges(
        one * drop_factor(at.supply - at.pressure_1, own),
        one * drop_factor(at.pressure_1 - own.tank, own),
        two * drop_factor(at.supply - at.pressure_2, own),
        two * drop_factor(at.pressure_2 - own.tank, own),
    )


@kernel
def passed(z: float, edges: Edges, own: Known) -> float:
    """y that the valve gives at an opening z [mA]."""
    return (
        edges.supply_1 * max(z - own.supply_1, 0.0)
        + edges.tank_2 * max(z - own.tank_2, 0.0)
        - edges.tank_1 * max(-z - own.tank_1, 0.0)
        - edges.supply_2 * max(-z - own.supply_2, 0.0)
    )


@kernel
def beyond(y: float, first: float, first_at: float, second: float, second_at: float) -> float:
    """How far two edges that begin at ``first_at`` and ``second_at`` are to open for y ≥ 0 [mA]."""
    if second_at < first_at:
        first, first_at, second, second_at = second, second_at, first, first_at
    if y <= first * (second_at - first_at):
        return first_at + y / first
    return (y + first * first_at + second * second_at) / (first + second)


@kernel
def between(y: float, edges: Edges, own: Known) -> float:
    """The opening z for y of a valve of which edges of both directions are open at null: straight between the places
    where an edge opens or closes."""
    low, high = -math.inf, math.inf
    at_low, at_high = 0.0, 0.0
    for place in (own.supply_1, own.tank_2, -own.tank_1, -own.supply_2):
        there = passed(place, edges, own)
        if there <= y and place > low:
            low, at_low = place, there
        if there >= y and place < high:
            high, at_high = place, there
    if low == -math.inf:
        return high + (y - at_high) / (edges.tank_1 + edges.supply_2)
    if high == math.inf:
        return low + (y - at_low) / (edges.supply_1 + edges.tank_2)
    return low if at_high <= at_low else low + (high - low) * (y - at_low) / (at_high - at_low)


@kernel
def crossed(y: float, own: Known) -> float:
    """A jump from −1 to 1 at null, spread over the band."""
    t = min(max(y / own.band, -1.0), 1.0)
    return 0.5 * t * (3.0 - t * t)


@kernel
def opened(y: float, place: float, edges: Edges, own: Known) -> float:
    """The opening z for y, its jump at null spread over the band, in which it is at a place [mA] (`place_of`)."""
    ahead, behind = min(own.supply_1, own.tank_2), -min(own.tank_1, own.supply_2)
    if ahead < behind:
        return between(y, edges, own)
    if y >= 0.0:
        excess = beyond(y, edges.supply_1, own.supply_1, edges.tank_2, own.tank_2) - ahead
    else:
        excess = -beyond(-y, edges.tank_1, own.tank_1, edges.supply_2, own.supply_2) - behind
    return excess + 0.5 * (ahead + behind) + 0.5 * (ahead - behind) * crossed(place, own)


@kernel
def curve_at(place, numbers, at, lanes):  # type: ignore[no-untyped-def]
    """Share of the full flow at a share of the stroke, both from 0 to 1."""
    k = min(int(place * (POINTS - 1)), POINTS - 2)
    low, high = numbers[at + k * len(lanes)], numbers[at + (k + 1) * len(lanes)]
    return low + (place * (POINTS - 1) - k) * (high - low)


@kernel
def place_on_curve(share, numbers, at, lanes):  # type: ignore[no-untyped-def]
    """Share of the stroke at which the curve has a share of the full flow; beyond its end as far beyond."""
    if share >= 1.0:
        return share
    k = 0
    while numbers[at + (k + 1) * len(lanes)] <= share:
        k += 1
    low, high = numbers[at + k * len(lanes)], numbers[at + (k + 1) * len(lanes)]
    return (k + (share - low) / (high - low)) / (POINTS - 1)


_ENTRIES: Final = ", ".join(f"peek(numbers, at + {k} * len(lanes))" for k in range(FIELDS))
known = written("numbers, at, lanes", f"return Known({_ENTRIES})", Known=Known, peek=peek)
"""`Known` of a valve whose numbers begin at a place."""


@kernel
def opening_for(wanted, place, edges, own, numbers, curve, lanes):  # type: ignore[no-untyped-def]
    """The opening x + x_n for a wanted one, the jump at null at a place of its band [mA]."""
    z = opened(wanted, place, edges, own)
    if own.curved == 0.0:
        return z
    begins = own.stroke * place_on_curve(0.0, numbers, curve, lanes)
    size = own.stroke * place_on_curve(abs(z) / own.stroke, numbers, curve, lanes)
    return math.copysign(size - begins, z) + begins * crossed(place, own)


@kernel
def asked_at(position, edges, own, numbers, curve, lanes):  # type: ignore[no-untyped-def]
    """The wanted voltage [V] that a position of the edges gives [mA]: `opening_for` inverted, its band left out."""
    x = min(max(position + own.offset, -own.stroke), own.stroke)
    if own.curved != 0.0:
        x = math.copysign(own.stroke * curve_at(abs(x) / own.stroke, numbers, curve, lanes), x)
    return passed(x, edges, own) / own.valve_gain


@kernel
def keeps_side(level: float, own: Known) -> bool:
    """Whether so little is wanted (`place_of`) that the spool keeps to its side of the overlap."""
    return level < 4.0 * own.quiet * own.quiet


@kernel
def place_of(wanted: float, before: float, level: float, own: Known) -> float:
    """Where in its band the jump at null is [mA] after a sample: where the opening is wanted, or behind that.

    While little is wanted (``level``, a mean square [mA²]) the spool keeps to its side of the overlap, on which the
    valve has no jump. The place then has play about what is wanted: of half a width `HELD`·q up to a level of q²,
    none from (2q)² on, q the law's ``quiet``.
    """
    if not keeps_side(level, own):
        return wanted
    behind = HELD * min(2.0 * own.quiet - math.sqrt(level), own.quiet)
    return min(max(before, wanted - behind), wanted + behind)


@kernel
def leaning(before: float, opening: float, lean: float, own: Known) -> float:
    """To which side of its play the spool leans, −1 to 1, once the edges have moved on from ``before`` [mA]."""
    return min(max(lean + (opening - before) / own.reversal, -1.0), 1.0)
