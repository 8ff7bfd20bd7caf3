"""What a valve and the stage that makes it good give for a wanted opening, by a describing function over amplitude.

At pressures at which the flow gain holds, and so slowly that the spool follows: w = A sin θ is wanted, the spool goes
where the stage sends it, and of what the valve then gives the fundamental over A is N(A). Outside the overlap, where
the law knows the valve, N is 1; across it the gain and the phase tell what the loop does. While little is wanted the
spool keeps to its side of the overlap (`ehamj.control.compiled.opening.place_of`), the one that it begins on.
"""

from collections.abc import Mapping
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array, ComplexArray
from ehamj.compiled import kernel
from ehamj.control.compiled.opening import FIELDS, Edges, known, leaning, opening_for, place_of
from ehamj.control.valves import EDGES, KnownValve
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.component import At
from ehamj.isolator.flow_curve import FlowCurve, curved_opening
from ehamj.isolator.hysteresis import Hysteresis, play
from ehamj.isolator.overlap import Overlap, edge_openings
from ehamj.isolator.spool import full_stroke

POINTS: Final = 400
"""Of a cycle."""
AMPLITUDES: Final = np.geomspace(0.01, 4.0, 40)
"""Of the wanted opening [mA], at which a valve is shown."""
BELIEFS: Final[Mapping[str, float]] = {"as it is": 1.0, "20 % too small": 0.8, "30 % too large": 1.3}
"""What a law may believe of the overlap, in words, over what it knows."""


def describing(valve: KnownValve, actuator: Actuator, amplitudes: ArrayLike = AMPLITUDES) -> ComplexArray:
    """N at amplitudes of the wanted opening (n,) [mA] of a valve behind a stage that knows it as ``valve``."""
    wave = np.exp(2j * np.pi * np.arange(POINTS) / POINTS)
    cycles, found = np.tile(wave.imag, 2), []
    numbers = np.array([*valve.numbers, *valve.curve])
    one = Overlap.values_of(actuator), FlowCurve.values_of(actuator)
    gap = Hysteresis.Values(2.0 * actuator.threshold + actuator.hysteresis)
    for amplitude in np.atleast_1d(np.asarray(amplitudes, float)):
        given = np.empty(cycles.size)
        _compiled()(amplitude * cycles, numbers, gap, actuator.null_offset, actuator.spool_stroke, one, given, (0.0,))
        found.append(2.0 / (POINTS * amplitude) * (given[POINTS:] @ (wave.imag + 1j * wave.real)))
    return np.array(found)


def believed(valve: KnownValve, share: float) -> KnownValve:
    """A known valve whose overlap the law believes to be another share of what it is."""
    own = valve.numbers
    return valve._replace(numbers=own._replace(**{name: share * getattr(own, name) for name in EDGES}))


def across(valve: KnownValve, actuator: Actuator, amplitudes: Array = AMPLITUDES) -> dict[str, ComplexArray]:
    """N of each of `BELIEFS`, by its words; one of a valve that the law knows without overlap."""
    lapped = any(getattr(valve.numbers, name) for name in EDGES)
    chosen = BELIEFS if lapped else {"as it is": 1.0}
    return {words: describing(believed(valve, share), actuator, amplitudes) for words, share in chosen.items()}


@cache
def _compiled() -> Any:
    from ehamj.compiled.kept import compiled

    return compiled(_through)


@kernel
def _given(spool, held, gap, offset, stroke, valve, own):  # type: ignore[no-untyped-def]
    """Where the edges stand [mA], and the opening that an ideal valve would need for their flow [mA]."""
    at = At(spool, 0.0, stroke, held, 0.0)
    edges = play(spool, at, gap)
    z = edge_openings(curved_opening(full_stroke(edges + offset, stroke), at, valve[1]), stroke, valve[0])
    return edges, own.share * (z.feeds_1 - z.drains_1) + (1.0 - own.share) * (z.drains_2 - z.feeds_2)


def _through(wanted, numbers, gap, offset, stroke, valve, given, lanes):  # type: ignore[no-untyped-def]
    """What is given for wanted openings, one after the other [mA]."""
    own = known(numbers, 0, lanes)
    at_rated = Edges(own.share, own.share, 1.0 - own.share, 1.0 - own.share)
    before, lean, held, place, level = 0.0, 0.0, 0.0, own.band, 0.0
    for k in range(wanted.size):
        level += wanted[k] * wanted[k] / wanted.size
    for k in range(wanted.size):
        place = place_of(wanted[k], place, level, own)
        opening = opening_for(wanted[k], place, at_rated, own, numbers, FIELDS, lanes)
        lean, before = leaning(before, opening, lean, own), opening
        held, given[k] = _given(opening + own.play * lean - own.offset, held, gap, offset, stroke, valve, own)
