"""What the laws of a controller do at a sample, compiled: outputs, their queue, one converter, their states.

Arrays are flat, the lanes of a block of machines last: entry i of a lane is at ``i * len(lanes) + lane``. What is the
same for each entry and lane runs through both at once.

A command may switch within a step of the integrator. Its response is then that of the switch to fourth order, as
anywhere else, if the integrator, which asks at start, middle and end, sees there a(w), b(w), c(w) of what changes, for
a command that acts in the last share w of the step:

    (a + 4 b + c)/6 = w,    (a + 2 b)/6 = w²/2,    (a + b)/12 = w³/6,

so that the mean of the command and its first two moments are exact (`step_shares`). A switch at the start of a step is
there already: (1, 1, 1); one at its end (0, 0, 0).
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import types

from ehamj.arrays import Array
from ehamj.compiled import copy, kernel
from ehamj.compiled.native import c_function
from ehamj.control.compiled.converter import Conversion, converted, faded, taken
from ehamj.control.compiled.lines import follow, turn
from ehamj.control.compiled.products import add_product, add_rows, advance_states, wanted
from ehamj.control.compiled.spools import FOLLOWS, fed_back
from ehamj.control.compiled.stage import REMEMBERS, linearised

LAW: Final = np.dtype(
    [
        (name, np.int64)
        for name in (
            "states",
            "inputs",
            "every",  # steps between samples
            "delay",  # whole steps from a sample to its command
            "function",  # address of a Python law; 0: none
            # Where its matrices begin in `Laws.matrices`, their rows in `Laws.rows` (−1: the matrices are full), its
            # inputs in `Laws.inputs_of`:
            "matrices",
            "rows",
            "windup",  # -1: no anti-windup; else where it begins, among the rows where they are
            "inputs_at",
            # Where in `LawMemory.values` its states lie; per valve its latest outputs, those that are held, what fade
            # and range last took; and the ring of outputs that wait for their time:
            "states_at",
            "latest",
            "held",
            "taken",
            "ring",
            "places",  # of the ring: as many samples as the delay is long, and one
            # Lines that it follows: how many, which of `Laws.lines` is the first, where their frequencies lie in
            # `LawMemory.values`.
            "lines",
            "line_at",
            "frequencies",
        )
    ]
    # What of a step the delay is longer than its whole steps, and what of a switch there is seen at each stage:
    + [(name, np.float64) for name in ("fraction", "at_start", "at_middle", "at_end")]
)
"""A law as the loop knows it; all fields but the last four are whole numbers."""


def step_shares(fraction: float) -> tuple[float, float, float]:
    """What of a command that switches at this fraction of a step is seen at its start, middle and end."""
    w = 1.0 - fraction
    return w**2 * (4.0 * w - 3.0), w**2 * (3.0 - 2.0 * w), w * (6.0 - w * (9.0 - 4.0 * w))


NOT_DUE: Final = 0
WAITS: Final = 1
AT_ONCE: Final = 2
FAILED: Final = 3
"""What a sample means for the commands: none was taken, they wait, they act at once, or a Python law failed."""


class Laws(NamedTuple):
    """The laws that run side by side; of a block of machines the matrices and ranges are each lane's own."""

    table: Any
    """A `LAW` per law; after them one more for the loops about the spools, where there are, and last one for the stage
    beside them, where there is one."""
    matrices: Any
    """A, B, C, D and anti-windup of every law, each transposed and flat; or row by row what is not zero."""
    rows: Any
    """Of laws made of blocks, whose matrices are mostly zero, where each row of A, B, C, D and anti-windup begins in
    ``matrices``, which then hold what is not zero; of each matrix its end too."""
    columns: Any
    """Column of each number in ``matrices``, for these laws."""
    inputs_of: Any
    """Channels that the laws measure, one law after the other."""
    converter: Conversion
    ranges: Any
    """Of each valve's command [V]."""
    switching: Any
    """Laws whose commands switch within a step, in the order in which they do."""
    valves: Any
    """What the stage beside the laws (`ehamj.control.compiled.stage`) knows of each valve; none: no stage."""
    pressures: Any
    """Channels of the pressures that it reads: none, or two of each valve (−1: not read), and last the supply's."""
    learners: Any
    """What is known of each mount that learns (`ehamj.control.compiled.learning`); none: nothing is learnt."""
    strokes: Any
    """Channels of the strokes that are read to learn."""
    lines: Any
    """(line·`PLACES`): where of each line that a law follows the states lie in `LawMemory.values`, how many pairs they
    are, and where in `LawMemory.lines` it keeps what it must."""
    followed: Any
    """(line·`FOLLOWED`)"""
    spools: Any
    """What is known of each spool that is fed back (`ehamj.control.compiled.spools`); none: none is."""
    positions: Any
    """Channels of their positions."""
    base: int
    """Steps of which all periods are multiples; 0: no controller."""


class LawMemory(NamedTuple):
    """What the laws remember (see `LAW`), and scratch."""

    values: Any
    measured: Any
    scratch: Any
    totals: Any
    """(2·valve): wanted, and what fade and range take."""
    switching: Any
    """(3·valve): what switches within the present step add at its start, middle and end, within the valves' ranges."""
    around: Any
    """(2·valve): what all laws together command before and after a switch."""
    stage: Any
    """(valve·`REMEMBERS`)"""
    known: Any
    """What the stage knows of each valve now: `Laws.valves`, with what was learnt since."""
    gathered: Any
    """(valve·`GATHERS`) to learn from."""
    lines: Any
    """Of each line that is followed: how long it is to stand still, and what is kept of its pairs (1 + pair·`KEPT`)."""
    spools: Any
    """(valve·`FOLLOWS`)"""

    @classmethod
    def of(cls, size: int, inputs: int, mounts: int, lines: int, stage: tuple[Array, Array]) -> "LawMemory":
        """Memory of a size, with so many numbers of lines, and what a stage beside the laws knows and has gathered."""
        total, switching, around, remembered, spools = (np.zeros(n * mounts) for n in (2, 3, 2, REMEMBERS, FOLLOWS))
        scratch = np.zeros(size), np.zeros(inputs), np.zeros(size)
        return cls(*scratch, total, switching, around, remembered, *stage, np.zeros(lines), spools)


call_law = c_function(types.int32, types.float64, types.intp, types.intp, types.intp)
"""int law(double time, double *measured, double *limited, double *wanted)"""


@kernel
def due(number, law):  # type: ignore[no-untyped-def]
    """Whether outputs of a law have waited as many whole steps as its delay has."""
    since = number - law.delay
    return since >= 0 and since % law.every == 0


@kernel
def waiting(number, law, size, lanes):  # type: ignore[no-untyped-def]
    """Where the outputs of a law that are due lie."""
    return law.ring * len(lanes) + size * (((number - law.delay) // law.every) % law.places)


@kernel
def queued(number, law, size, lanes):  # type: ignore[no-untyped-def]
    """Where the outputs of a sample of a law are put: to wait, or without delay to be held."""
    if law.delay == 0 and law.fraction == 0.0:
        return law.held * len(lanes)
    return law.ring * len(lanes) + size * ((number // law.every) % law.places)


@kernel
def release(number, laws, memory, control, lanes):  # type: ignore[no-untyped-def]
    """Hand the valves the outputs whose time has come, or comes within this step."""
    changed, values = False, memory.values
    for k in range(laws.table.size):
        law = laws.table[k]
        begun = number if law.fraction == 0.0 else number - 1  # step within which what is held from now on switched
        if (law.delay > 0 or law.fraction > 0.0) and due(begun, law):
            place, held = waiting(begun, law, control.size, lanes), law.held * len(lanes)
            for i in range(control.size):
                values[held + i] = values[place + i]
            changed = True
        if law.fraction > 0.0 and law.delay > 0 and due(number, law):
            changed = True
    if changed:
        convert_held(number, laws, memory, control, lanes)


@kernel
def sum_after(number, fraction, laws, values, result, lanes):  # type: ignore[no-untyped-def]
    """What all laws together command after a fraction of a step, of every valve and lane."""
    result[:] = 0.0
    for law in laws.table:
        moved = 0.0 < law.fraction <= fraction and due(number, law)
        place = waiting(number, law, result.size, lanes) if moved else law.held * len(lanes)
        for i in range(result.size):
            result[i] += values[place + i]
    for i in range(result.size):
        result[i] = converted(result[i], laws.converter.limit, laws.converter.resolution)


@kernel
def convert_held(number, laws, memory, control, lanes):  # type: ignore[no-untyped-def]
    """Commands from what all laws hold, and what it adds that they switch within this step.

    Outputs of this very step that a sample has yet to give may be in what is added: it is found again after that.
    """
    size, values, added = control.size, memory.values, memory.switching
    table, ranges, switching = laws.table, laws.ranges, laws.switching
    now, then = memory.around[:size], memory.around[size:]
    sum_after(number, 0.0, laws, values, control, lanes)
    copy(control, now)
    added[:] = 0.0
    j = 0
    while j < switching.size:
        law, moved = table[switching[j]], False
        while j < switching.size and table[switching[j]].fraction == law.fraction:  # they switch together
            moved, j = moved or due(number, table[switching[j]]), j + 1
        if moved:
            sum_after(number, law.fraction, laws, values, then, lanes)
            for i in range(size):
                rise = converted(then[i], ranges[i], 0.0) - converted(now[i], ranges[i], 0.0)
                now[i] = then[i]
                added[i] += law.at_start * rise
                added[size + i] += law.at_middle * rise
                added[2 * size + i] += law.at_end * rise


@kernel
def compute(time, law, laws, readings, memory, lanes):  # type: ignore[no-untyped-def]
    """Let one law compute its outputs; False where a Python law failed."""
    width, valves, values = len(lanes), memory.totals.size // 2, memory.values
    n, p, first, at = law.states * width, law.inputs * width, law.matrices * width, law.inputs_at
    for i in range(law.inputs):
        for lane in range(width):
            memory.measured[(at + i) * width + lane] = readings[laws.inputs_of[at + i] * width + lane]
    latest = values[law.latest * width : law.latest * width + valves]
    inputs = memory.measured[at * width : at * width + p]
    if law.function != 0:
        lost = values[law.taken * width : law.taken * width + valves]
        return call_law(law.function, (time, inputs.ctypes.data, lost.ctypes.data, latest.ctypes.data)) == 0
    states = values[law.states_at * width : law.states_at * width + n]
    if law.rows >= 0:
        latest[:] = 0.0
        rows = law.rows + 2 * (law.states + 1)
        add_rows(laws, rows, states, latest, lanes)
        add_rows(laws, rows + valves // width + 1, inputs, latest, lanes)
        return True
    C = first + law.states * (n + p)
    D = C + law.states * valves
    wanted(laws.matrices[C:D], laws.matrices[D : D + law.inputs * valves], states, inputs, latest, lanes)
    return True


@kernel
def take_sample(number, time, laws, readings, memory, lanes):  # type: ignore[no-untyped-def]
    """Let every law that is due compute, then the loops about the spools; returns what that means for the commands."""
    staged, fed = laws.valves.size > 0, laws.spools.size > 0
    count = laws.table.size - staged - fed
    answer = sample_laws(number, time, count, staged, laws, readings, memory, lanes)
    if fed and answer != FAILED and number % laws.table[count].every == 0:
        law = laws.table[count]
        answer = max(answer, AT_ONCE if law.delay == 0 else WAITS)
        place = queued(number, law, memory.totals.size // 2, lanes)
        fed_back(faded(time, laws.converter), readings, laws, memory, count, place, lanes)
    return answer


@kernel
def sample_laws(number, time, count, staged, laws, readings, memory, lanes):  # type: ignore[no-untyped-def]
    """Let every one of ``count`` laws that is due compute; returns what that means for the commands."""
    answer = NOT_DUE
    for k in range(count):
        law = laws.table[k]
        if number % law.every == 0:
            answer = max(answer, AT_ONCE if law.delay == 0 else WAITS)
            if not compute(time, law, laws, readings, memory, lanes):
                return FAILED
    if answer == NOT_DUE:
        return answer
    valves = memory.totals.size // 2
    total, lost = memory.totals[:valves], memory.totals[valves:]
    for i in range(valves):
        total[i] = 0.0
        for k in range(count):
            total[i] += memory.values[laws.table[k].latest * len(lanes) + i]
    share = faded(time, laws.converter)
    if staged:
        stage = laws.table[laws.table.size - 1]
        place = queued(number, stage, valves, lanes) if number % stage.every == 0 else -1
        linearised(share, readings, laws, memory, place, lanes)
    else:
        taken(total, share, laws.converter, lost)
    for k in range(count):
        if number % laws.table[k].every == 0:
            finish_sample(number, share, laws.table[k], laws, memory, lanes)
    return answer


@kernel
def finish_sample(number, share, law, laws, memory, lanes):  # type: ignore[no-untyped-def]
    """Advance the states of a law, and queue its outputs (without delay: hold them)."""
    width, values, matrices = len(lanes), memory.values, laws.matrices
    n, p, first, at = law.states * width, law.inputs * width, law.matrices * width, law.inputs_at * width
    valves = memory.totals.size // 2
    lost = memory.totals[valves:]
    if law.function == 0 and n > 0:
        states = values[law.states_at * width : law.states_at * width + n]
        B = first + law.states * n
        inputs, scratch = memory.measured[at : at + p], memory.scratch[:n]
        windup = law.windup * width
        if law.lines > 0:
            turn(law, laws, memory, lanes)
        if law.rows >= 0:
            scratch[:] = 0.0
            add_rows(laws, law.rows, states, scratch, lanes)
            add_rows(laws, law.rows + law.states + 1, inputs, scratch, lanes)
            copy(scratch, states)
            if law.windup >= 0:
                add_rows(laws, law.windup, lost, states, lanes)
        else:
            advance_states(matrices[first:B], matrices[B : B + law.states * p], states, inputs, scratch, lanes)
            if law.windup >= 0:
                add_product(matrices[windup : windup + law.states * valves], lost, states, lanes)
        if law.lines > 0:
            follow(share, law, laws, memory, lanes)
    place = queued(number, law, valves, lanes)
    for i in range(valves):
        values[law.taken * width + i] = lost[i]
        values[place + i] = share * values[law.latest * width + i]
