"""What is learnt of each isolator while it runs, compiled: continuity of its oil, balanced block by block.

Over a block of samples the valve's flow is what the piston takes, what the oil is compressed by and what leaks:

    K_Q·mean(y) = A·Δs/T + (V_t/4βA)·ΔF/T + (K_C/A)·mean(F),   F = A_1 P_1 − A_2 P_2,

s the measured stroke, P the measured pressures, and y the opening [mA] that the known valve makes of what it was told,
each where all stand at one time (`Paced`). Differences over a block are exact, so that no signal is differentiated.
Where edges are off what is believed, y goes with its derivatives to their overlap and play, y + ψ_o δ_o + ψ_p δ_p.
With the stated K_Q and compliance, γ and ε times which are true, that is linear in θ = (γ, γ δ_o, γ δ_p, ε − 1):

    A Δs/T + … = γ·y + γ δ_o·ψ_o + γ δ_p·ψ_p − (ε − 1)·(V_t/4βA)·ΔF/T    [all over K_Q: mA],

all five passed through the same band. θ is recursive least squares with forgetting, normalised by the power of the flow
in the band, and with the stated values as a weak observation that is never forgotten,

    R⁺ = λ R + φ φᵀ T/m²,   r likewise,   θ = (R + R_0)⁻¹ r,

so that R + R_0 stays positive definite however little moves, and θ is bounded; it is then projected on its range. What
the law uses follows in `pace`, slowly against every loop and without a jump. R and r do not change, and nothing that is
used moves, while a command is limited or fades, until the band's filters have forgotten that, and while the flow in the
band is below ``least``. The null offset is what is left over on the average, outside the band.

A law's command leads to a piston's velocity ẋ as v = b(1 + c/s)ẋ (`ehamj.control.inverse`): the part that moves the
piston, s/(s + c) of it, is to be larger with the oil's compliance, and all of it with 1/γ (`corrected`).

Arrays are flat, the lanes of a block of machines last: entry i of a lane is at ``i * len(lanes) + lane``.
"""

from typing import Any, Final, NamedTuple

from ehamj.compiled import kernel, written
from ehamj.compiled.lanes import peek, poke
from ehamj.control.learners import Learner, Learnt


class Paced(NamedTuple):
    """How a mount learns from block to block; follows its `Learner` in memory."""

    block: float
    """T [s]."""
    every: float
    """Samples of a block."""
    late: float
    """Whole samples by which what the valve was told comes before what is measured of it."""
    rest: float
    """What it comes before beyond these [s]."""
    rest_play: float
    """The same of the play, whose lead is rolled off [s]."""
    rest_force: float
    """By how much pressures are read earlier than strokes [s]."""
    smooth_low: float
    """Share that a low-pass at the band's lower end takes of a block."""
    smooth_high: float
    kept: float
    """λ: what is remembered from block to block."""
    seen: float
    """Share of a block in the flow's power."""
    follow: float
    """Share by which what is used follows in a block."""
    slow: float
    """Share of a sample in the part of a command that leakage asks for."""
    settling: float
    """Blocks until the band's filters have forgotten."""
    weight_gain: float
    """R_0."""
    weight_overlap: float
    weight_play: float
    weight_compliance: float


LEARNS: Final = len(Learner._fields)
LEARNER: Final = LEARNS + len(Paced._fields)
"""Numbers of a mount that learns."""
USED: Final = len(Learnt._fields)
N: Final = 4
"""Of θ."""
COLUMNS: Final = N + 1

PHASE, FROZEN, POWER, SLOW, STROKE, RISE, SUMS = range(7)
"""RISE: of the force over the last block."""
SUM: Final = 4
LAST, START, TOTAL, MEAN = range(SUM)
"""Of a signal within a block: its last value, its value at the start, the sum, and the mean of the last block."""
FLOW, OVERLAP, PLAY, FORCE = range(4)
FILTERS: Final = SUMS + 4 * SUM
"""Four states for each of y, ψ_o, ψ_p, ΔF/T and what is balanced with them."""
NORMAL: Final = FILTERS + 4 * COLUMNS
"""R and r."""
SOLVED: Final = NORMAL + N * COLUMNS
GATHERS: Final = SOLVED + N * COLUMNS
"""Numbers that a mount remembers to learn."""


def _fields(of: Any, first: int) -> Any:
    entries = ", ".join(f"peek(numbers, at + {first + k} * len(lanes))" for k in range(len(of._fields)))
    return written("numbers, at, lanes", f"return Of({entries})", Of=of, peek=peek)


learner: Any = _fields(Learner, 0)
"""`Learner` of a mount whose numbers begin at a place."""
paced: Any = _fields(Paced, LEARNS)
learnt: Any = _fields(Learnt, 0)
"""`Learnt` from a place of the laws' memory."""


@kernel
def corrected(total, slow, own, used):  # type: ignore[no-untyped-def]
    """The voltage that does what a law's ``total`` is to do [V]; ``slow`` is the part that leakage asks for."""
    fast = own.stretch * (used.compliance - 1.0) / (1.0 + own.stretch)
    return (total + fast * (total - slow)) / used.flow_gain


@kernel
def add_up(values, at, now, width):  # type: ignore[no-untyped-def]
    """Add a sample to the trapezoidal sum of a signal of a block."""
    last = peek(values, at + LAST * width)
    poke(values, at + TOTAL * width, peek(values, at + TOTAL * width) + 0.5 * (last + now))
    poke(values, at + LAST * width, now)


@kernel
def close(values, at, rest, pace, width):  # type: ignore[no-untyped-def]
    """End a block of a signal: its mean, ``rest`` earlier [s]; the next begins."""
    last = peek(values, at + LAST * width)
    shifted = rest / pace.block * (last - peek(values, at + START * width))
    poke(values, at + MEAN * width, peek(values, at + TOTAL * width) / pace.every - shifted)
    poke(values, at + START * width, last)
    poke(values, at + TOTAL * width, 0.0)


@kernel
def in_band(values, at, now, pace, width):  # type: ignore[no-untyped-def]
    """A signal of blocks in the band: two high-passes and two low-passes, each of first order."""
    for k in range(2):
        low = peek(values, at + k * width) + pace.smooth_low * (now - peek(values, at + k * width))
        poke(values, at + k * width, low)
        now = now - low
    for k in range(2, 4):
        now = peek(values, at + k * width) + pace.smooth_high * (now - peek(values, at + k * width))
        poke(values, at + k * width, now)
    return now


@kernel
def solve(values, at, pace, width):  # type: ignore[no-untyped-def]
    """θ = (R + R_0)⁻¹ (r + R_0 θ_0) by elimination, into the last column at `SOLVED`."""
    a, first = at + SOLVED * width, at + NORMAL * width
    for k in range(N * COLUMNS):
        poke(values, a + k * width, peek(values, first + k * width))
    weights = (pace.weight_gain, pace.weight_overlap, pace.weight_play, pace.weight_compliance)
    for k in range(N):
        diagonal = a + (k * COLUMNS + k) * width
        poke(values, diagonal, peek(values, diagonal) + weights[k])
    end = a + N * width
    poke(values, end, peek(values, end) + weights[0])  # θ_0 = (1, 0, 0, 0)
    for k in range(N):
        pivot = peek(values, a + (k * COLUMNS + k) * width)
        for i in range(k + 1, N):
            factor = peek(values, a + (i * COLUMNS + k) * width) / pivot
            for j in range(k, COLUMNS):
                place = a + (i * COLUMNS + j) * width
                poke(values, place, peek(values, place) - factor * peek(values, a + (k * COLUMNS + j) * width))
    for i in range(N - 1, -1, -1):
        left = peek(values, a + (i * COLUMNS + N) * width)
        for j in range(i + 1, N):
            left -= peek(values, a + (i * COLUMNS + j) * width) * peek(values, a + (j * COLUMNS + N) * width)
        poke(values, a + (i * COLUMNS + N) * width, left / peek(values, a + (i * COLUMNS + i) * width))


@kernel
def clipped(value, low, high):  # type: ignore[no-untyped-def]
    """Projected on a range."""
    return min(max(value, low), high)


@kernel
def observe(values, at, phi, own, pace, width):  # type: ignore[no-untyped-def]
    """Add a block's equation φᵀθ = φ_N to R and r."""
    m = pace.block / (peek(values, at + POWER * width) + own.least * own.least)
    for i in range(N):
        for j in range(COLUMNS):
            place = at + (NORMAL + i * COLUMNS + j) * width
            poke(values, place, pace.kept * peek(values, place) + m * (phi[i] * phi[j]))


@kernel
def found(values, at, used, left, own, pace, width):  # type: ignore[no-untyped-def]
    """What the law is to use from now on: each a step towards what is found, within its range."""
    solve(values, at, pace, width)
    end = at + (SOLVED + N) * width
    gain = clipped(peek(values, end), own.least_gain, own.most_gain)
    overlap = clipped(peek(values, end + COLUMNS * width) / gain, own.least_overlap, own.most_overlap)
    play = clipped(peek(values, end + 2 * COLUMNS * width) / gain, own.least_play, own.most_play)
    compliance = clipped(1.0 + peek(values, end + 3 * COLUMNS * width), own.least_compliance, own.most_compliance)
    share = pace.follow
    return Learnt(
        used.flow_gain + share * (gain - used.flow_gain),
        used.compliance + share * (compliance - used.compliance),
        used.overlap + share * (overlap - used.overlap),
        used.play + share * (play - used.play),
        clipped(used.null_offset + 0.1 * share * left / used.flow_gain, own.least_offset, own.most_offset),
    )


@kernel
def balanced(values, at, used, stroke, own, pace, width):  # type: ignore[no-untyped-def]
    """End a block: what the law is to use from now on."""
    sums, force = at + SUMS * width, at + (SUMS + SUM * FORCE) * width
    before = peek(values, force + START * width)
    close(values, force, pace.rest_force, pace, width)
    rise = peek(values, force + LAST * width) - before
    earlier = rise - pace.rest_force / pace.block * (rise - peek(values, at + RISE * width))
    poke(values, at + RISE * width, rise)
    pressed = own.oil * earlier / (pace.block * own.flow)
    moved = own.area * (stroke - peek(values, at + STROKE * width)) / (pace.block * own.flow)
    taken = moved + pressed + own.leak * peek(values, force + MEAN * width) / own.flow
    poke(values, at + STROKE * width, stroke)
    flow = peek(values, sums + MEAN * width)
    by_overlap = peek(values, sums + (SUM * OVERLAP + MEAN) * width)
    by_play = peek(values, sums + (SUM * PLAY + MEAN) * width)
    stated = flow - by_overlap * used.overlap - by_play * used.play
    left = taken - used.flow_gain * flow + (used.compliance - 1.0) * pressed
    filters = at + FILTERS * width
    phi = (
        in_band(values, filters, stated, pace, width),
        in_band(values, filters + 4 * width, by_overlap, pace, width),
        in_band(values, filters + 8 * width, by_play, pace, width),
        in_band(values, filters + 12 * width, -pressed, pace, width),
        in_band(values, filters + 16 * width, taken, pace, width),
    )
    power = peek(values, at + POWER * width)
    power += pace.seen * (phi[0] * phi[0] - power)
    poke(values, at + POWER * width, power)
    frozen = peek(values, at + FROZEN * width)
    if frozen > 0.0:
        poke(values, at + FROZEN * width, frozen - 1.0)
        return used
    if power < own.least * own.least:
        return used
    observe(values, at, phi, own, pace, width)
    return found(values, at, used, left, own, pace, width)


@kernel
def learns(values, at, told, force, stroke, used, own, pace, width):  # type: ignore[no-untyped-def]
    """Take a sample: y, ψ_o and ψ_p of what the valve was ``told``, force [N] and stroke [m]; what is used from now
    on."""
    sums = at + SUMS * width
    add_up(values, sums, told[0], width)
    add_up(values, sums + SUM * OVERLAP * width, told[1], width)
    add_up(values, sums + SUM * PLAY * width, told[2], width)
    add_up(values, at + (SUMS + SUM * FORCE) * width, force, width)
    phase = peek(values, at + PHASE * width) + 1.0
    if phase == pace.every - pace.late:
        close(values, sums, pace.rest, pace, width)
        close(values, sums + SUM * OVERLAP * width, pace.rest, pace, width)
        close(values, sums + SUM * PLAY * width, pace.rest_play, pace, width)
    if phase < pace.every:
        poke(values, at + PHASE * width, phase)
        return used
    poke(values, at + PHASE * width, 0.0)
    return balanced(values, at, used, stroke, own, pace, width)


@kernel
def edge_slopes(y, band, overlap, lean, through):  # type: ignore[no-untyped-def]
    """How y [mA] depends on the edges' overlap and on play: ψ_o, ψ_p; ``through`` is φ of the edges that meter."""
    t = min(max(y / band, -1.0), 1.0)
    jump = 0.5 * t * (3.0 - t * t)
    steep = 1.0 / through + 1.5 * overlap * (1.0 - t * t) / band
    return -through * jump, -lean / steep
