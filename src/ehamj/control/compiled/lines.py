"""How a law follows lines whose frequency drifts, compiled: its resonators turn with the line.

A pair of states of a law (`ehamj.control.lines.Line`) is a complex x that becomes ρ e^{jωT} x + βe at a sample. Once
the line has its way, x turns with it, whatever phase and size β has; what turns at ω and lags behind by a ``time``,

    z = e^{jωT} z + (x − z)·T/time,    then stands at an angle to it:    δ = Im(x z̄)/(time·|x|²),

summed over the motions, is what the line is off ω. With ω following as dω/dt = δ/``pace``, slowly beside the
resonators, the frequency closes in on the line as e^(−t/pace), and stays within its range (Bodson and Douglas,
Automatica 33(12), 1997, and Brown and Zhang, Automatica 40(4), 2004, follow a line by such states too). |x|² is taken
for a quarter of |z|² at least, so that nothing that is measured moves ω faster than 2/(time·pace).

While a command fades or is limited the valves do not answer: x then turns and is forgotten as ever, and takes nothing
in; ω stays where it is. So it is for a period of the line after that: who learnt between the peaks of a command that
all meet the limit would ask for ever higher ones.

Arrays are flat, the lanes of a block of machines last: entry i of a lane is at ``i * len(lanes) + lane``.
"""

from typing import Any, Final, NamedTuple

from ehamj.compiled import kernel, written
from ehamj.compiled.lanes import peek

LEAST: Final = 0.25
"""Share of |z|² that |x|² is taken for at least."""
PLACES: Final = 3
"""Whole numbers of a line, see `places`."""
KEPT: Final = 4
"""Numbers that are kept of a pair: x without what is read, and z."""


class Followed(NamedTuple):
    """A line as the loop knows it."""

    real: float
    """ρ e^{jωT} by themselves."""
    imaginary: float
    undamped: float
    """1/ρ."""
    nominal: float
    """ω/2π by itself [Hz]."""
    low: float
    """Range [Hz]."""
    high: float
    half: float
    """Half of the angle per sample that a hertz more turns, π T [s]."""
    lag: float
    """Share of a sample in z."""
    period: float
    """Of the line, in samples."""
    step: float
    """Hertz per angle between x and z, in a sample."""


FOLLOWED: Final = len(Followed._fields)
followed: Any = written(
    "numbers, at, lanes",
    f"return Followed({', '.join(f'peek(numbers, at + {k} * len(lanes))' for k in range(FOLLOWED))})",
    Followed=Followed, peek=peek,
)  # fmt: skip
"""`Followed` of a line whose numbers begin at a place."""


@kernel
def places(lines, number):  # type: ignore[no-untyped-def]
    """Where a line's states lie, how many pairs they are, and where it keeps what it must."""
    return lines[PLACES * number], lines[PLACES * number + 1], lines[PLACES * number + 2]


@kernel
def turn(law, laws, memory, lanes):  # type: ignore[no-untyped-def]
    """Turn a law's pairs by what their lines are off, before its states advance, and keep what they become without
    readings; the turn is a quotient whose size is one (it falls short of its angle φ by φ³/12)."""
    width, values, kept = len(lanes), memory.values, memory.lines
    for j in range(law.lines):
        number = law.line_at + j
        first, pairs, at = places(laws.lines, number)
        for lane in range(width):
            own = followed(laws.followed, number * FOLLOWED * width + lane, lanes)
            q = own.half * (values[(law.frequencies + j) * width + lane] - own.nominal)
            size = 1.0 / (1.0 + q * q)
            c, s = (1.0 - q * q) * size, 2.0 * q * size
            real = own.undamped * (c * own.real - s * own.imaginary)
            imaginary = own.undamped * (s * own.real + c * own.imaginary)
            for p in range(pairs):
                x, y = (first + 2 * p) * width + lane, (at + 1 + KEPT * p) * width + lane
                a, b = c * values[x] - s * values[x + width], s * values[x] + c * values[x + width]
                values[x], values[x + width] = a, b
                kept[y], kept[y + width] = own.real * a - own.imaginary * b, own.imaginary * a + own.real * b
                z = y + 2 * width
                a, b = kept[z], kept[z + width]
                kept[z], kept[z + width] = real * a - imaginary * b, imaginary * a + real * b


@kernel
def follow(share, law, laws, memory, lanes):  # type: ignore[no-untyped-def]
    """Move the frequencies of a law's lines, after its states have advanced; or take back what was read, while commands
    fade or any is limited, and for a period after."""
    width, valves, values, kept = len(lanes), memory.totals.size // 2, memory.values, memory.lines
    for lane in range(width):
        reaches = share >= 1.0
        for i in range(lane, valves, width):
            reaches = reaches and memory.totals[valves + i] == 0.0
        for j in range(law.lines):
            number = law.line_at + j
            first, pairs, at = places(laws.lines, number)
            own = followed(laws.followed, number * FOLLOWED * width + lane, lanes)
            kept[at * width + lane] = max(kept[at * width + lane] - 1.0, 0.0) if reaches else own.period
            free = kept[at * width + lane] == 0.0
            turned, size, lagging = 0.0, 0.0, 0.0
            for p in range(pairs):
                x, y = (first + 2 * p) * width + lane, (at + 1 + KEPT * p) * width + lane
                if not free:
                    values[x], values[x + width] = kept[y], kept[y + width]
                    continue
                z = y + 2 * width
                a, b = values[x], values[x + width]
                c, d = kept[z] + own.lag * (a - kept[z]), kept[z + width] + own.lag * (b - kept[z + width])
                kept[z], kept[z + width] = c, d
                turned += b * c - a * d
                size += a * a + b * b
                lagging += c * c + d * d
            size = max(size, LEAST * lagging)
            if size > 0.0:
                hertz = (law.frequencies + j) * width + lane
                values[hertz] = min(max(values[hertz] + own.step * (turned / size), own.low), own.high)
