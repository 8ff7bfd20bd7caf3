"""The digital control loop around a step, compiled: sensors, laws at their rates, commands that wait, one converter."""

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ehamj.compiled import kernel
from ehamj.control import AnyController, Controller, PythonController
from ehamj.control.channels import ACCELERATION, DISPLACEMENT, GROUND, PLATE, STATE, STATIC, VELOCITY, quantity_of
from ehamj.control.compiled.call import call_law
from ehamj.control.compiled.kernels import (
    add_product,
    advance_states,
    converted,
    faded,
    filter_readings,
    limited,
    settle_filters,
    wanted,
)
from ehamj.control.instruments import Discrete, discretise
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.memory import N_STATES
from ehamj.plant.axes import AXES, DOF_OF_JOINT
from ehamj.plant.mounts import N_MOUNTS
from ehamj.plant.plant import Plant

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

N_GROUND: Final = N_MOUNTS * len(AXES)

# Columns of the table of laws. Offsets of vectors are into the loop's memory, of matrices into `Loop.matrices`.
N_PART_STATES, N_PART_INPUTS, EVERY, DELAY, MATRICES, WINDUP, OWN_STATES, INPUTS_AT, FUNCTION = range(9)
LATEST, HELD, TAKEN, RING, PLACES = range(9, 14)
N_COLUMNS: Final = 14

NOT_DUE: Final = 0
WAITS: Final = 1
AT_ONCE: Final = 2
FAILED: Final = 3
"""What a sample means for the commands: none was taken, they wait, they act at once, or a Python law failed."""

_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, *(ctypes.c_void_p,) * 3)


@dataclass(frozen=True, eq=False)
class Loop:
    """A controller and its sensors as the stepping loop runs them, for one simulation.

    ``memory`` holds, one after the other: states of all laws; per law its latest outputs, those that are held, what
    fade and range last took, and a ring of outputs that wait for their time (as many samples as the delay is long, and
    one); the readings; what they count from; the states of the sensors' filters.
    """

    parts: Integers
    """A row per law, see the columns above."""
    matrices: Array
    """A, B, C, D and anti-windup of every law, each transposed and flat."""
    inputs_of: Integers
    """Channels that the laws measure, one law after the other."""
    terms: Integers
    weights: Array
    """Each channel as a short sum of signals: which (channels, terms), and their factors."""
    filters: Array
    feedthrough: Array
    """See `ehamj.control.compiled.kernels.filter_readings`."""
    zeroed: Array
    """One for a channel that counts from its value at the start, zero for the others."""
    grid: Array
    """Range and resolution of each reading (channels, 2)."""
    converter: Array
    """Range [V], resolution [V], switch-on [s] and fade [s] of the commands."""
    base: int
    """Steps of which all periods are multiples; 0: no controller."""
    states: int
    memory: Array
    functions: tuple[Any, ...] = ()
    """Python laws as C functions; kept alive here."""
    failures: list[Exception] = field(default_factory=list)

    @property
    def readings(self) -> int:
        """Number of channels that are measured."""
        return int(self.terms.shape[0])

    @property
    def readings_at(self) -> int:
        """Where the readings lie in the memory."""
        return int(self.memory.size - self.readings * (2 + self.filters.shape[1]))

    def samples(self, first: int, count: int) -> tuple[int, int]:
        """Of ``count`` steps from ``first``: the number of the first sample among them, and how many there are."""
        if self.base == 0:
            return 0, 0
        begin, end = -(-first // self.base), -(-(first + count) // self.base)
        return begin, end - begin


def _empty(*shape: int) -> Array:
    return np.zeros(shape)


NO_LOOP: Final = Loop(
    np.zeros((0, N_COLUMNS), np.int64), _empty(0), np.zeros(0, np.int64), np.zeros((0, 0), np.int64), _empty(0, 0),
    _empty(3, 0, 0), _empty(0), _empty(0), _empty(0, 2), _empty(4), 0, 0, _empty(0),
)  # fmt: skip


def make_loop(
    controller: AnyController | None, plant: Plant, timestep: float, sensors: Sensors = IDEAL, seed: int = 0
) -> Loop:
    """A controller made ready for a step that divides its periods and delays, at the beginning of a simulation.

    Raises:
        InputError: if a sensor does not measure what the controller reads.
    """
    if controller is None:
        return NO_LOOP
    channels = tuple(controller.inputs)
    terms, weights = _terms(sensors.rows(channels, plant, seed))
    filters, feedthrough, grid = _instruments(channels, sensors, timestep)
    failures: list[Exception] = []
    laws: Sequence[Controller | PythonController] = controller.parts
    functions = {k: _function(p, failures) for k, p in enumerate(laws) if isinstance(p, PythonController)}
    parts, matrices, inputs_of, size = _parts(laws, channels, timestep, functions)
    converter = controller.converter
    return Loop(
        parts,
        matrices,
        inputs_of,
        terms,
        weights,
        filters,
        feedthrough,
        np.array([float(converter.from_rest and quantity_of(name.partition(" ")[0]) in STATIC) for name in channels]),
        grid,
        np.array([converter.voltage_limit, converter.resolution, converter.switch_on, converter.fade]),
        int(np.gcd.reduce(parts[:, EVERY])),
        controller.states,
        np.zeros(size + len(channels) * (2 + filters.shape[1])),
        tuple(functions.values()),
        failures,
    )


def _terms(rows: Array) -> tuple[Integers, Array]:
    """Rows over the vector of signals as short sums: which signals (channels, terms), and their factors."""
    count = int((rows != 0).sum(axis=1).max(initial=0))
    terms = np.argsort(rows == 0, axis=1, kind="stable")[:, :count]
    return np.ascontiguousarray(terms, np.int64), np.ascontiguousarray(np.take_along_axis(rows, terms, axis=1))


def _instruments(channels: tuple[str, ...], sensors: Sensors, timestep: float) -> tuple[Array, Array, Array]:
    """Filters, feedthrough and grid of all channels, filled up with nothing to the longest filter."""
    exact = Discrete(_empty(0, 0), _empty(0), _empty(0), 1.0, _empty(0))
    found = [sensors.of(name) for name in channels]
    discrete = [exact if sensor is None else discretise(sensor, timestep) for sensor in found]
    n = max((d.A.shape[0] for d in discrete), default=0)
    filters = np.zeros((n + 3, n, len(channels)))
    for c, d in enumerate(discrete):
        own = d.A.shape[0]
        filters[:own, :own, c] = d.A
        filters[n, :own, c], filters[n + 1, :own, c], filters[n + 2, :own, c] = d.B, d.C, d.settled
    grid = [(np.inf, 0.0) if s is None else (s.range, s.resolution) for s in found]
    return filters, np.array([d.D for d in discrete]), np.array(grid, float).reshape(len(channels), 2)


def _parts(
    parts: Sequence[Controller | PythonController],
    channels: tuple[str, ...],
    timestep: float,
    functions: dict[int, Any],
) -> tuple[Integers, Array, Integers, int]:
    """Table of laws, their matrices and channels, and the size of their memory."""
    table = np.zeros((len(parts), N_COLUMNS), np.int64)
    matrices: list[Array] = []
    inputs_of: list[int] = []
    offset, states, size = 0, 0, sum(part.states for part in parts)
    for k, part in enumerate(parts):
        row = table[k]
        row[N_PART_STATES], row[N_PART_INPUTS] = part.states, len(part.inputs)
        row[EVERY], row[DELAY] = round(part.period / timestep), round(part.latency / timestep)
        row[MATRICES], row[WINDUP], row[OWN_STATES], row[INPUTS_AT] = offset, -1, states, len(inputs_of)
        row[LATEST], row[HELD], row[TAKEN] = size, size + N_MOUNTS, size + 2 * N_MOUNTS
        row[RING], row[PLACES] = size + 3 * N_MOUNTS, row[DELAY] // row[EVERY] + 1
        if k in functions:
            row[FUNCTION] = ctypes.cast(functions[k], ctypes.c_void_p).value
        if isinstance(part, Controller):
            own = [part.A, part.B, part.C, part.D]
            if part.anti_windup is not None:
                row[WINDUP] = offset + sum(matrix.size for matrix in own)
                own.append(part.anti_windup)
            matrices += [matrix.T.ravel() for matrix in own]
            offset += sum(matrix.size for matrix in own)
        inputs_of += [channels.index(name) for name in part.inputs]
        states += part.states
        size = int(row[RING] + N_MOUNTS * row[PLACES])
    flat = np.concatenate(matrices) if matrices else _empty(0)
    return table, flat, np.array(inputs_of, np.int64), size


def _function(law: PythonController, failures: list[Exception]) -> Any:
    """A Python law as a C function; what it raises goes to ``failures``."""
    law.reset()

    def call(time: float, measured: int, taken: int, result: int) -> int:
        try:
            inputs, limited_by = _vector(measured, len(law.inputs)), _vector(taken, N_MOUNTS)
            _vector(result, N_MOUNTS)[:] = law.wanted(time, inputs, limited_by)
        except Exception as error:
            failures.append(error)
            return 1
        return 0

    return _FUNCTION(call)


def _vector(address: int, size: int) -> Array:
    """The numbers at an address, not copied."""
    if size == 0:
        return np.zeros(0)
    return np.ctypeslib.as_array((ctypes.c_double * size).from_address(address))


@kernel
def gather(signals, qpos, qvel, qacc, act, length, velocity, ground, rate):  # type: ignore[no-untyped-def]
    """The vector of signals that every channel is a combination of (`ehamj.control.channels`)."""
    for dof in range(len(DOF_OF_JOINT)):
        joint = DOF_OF_JOINT[dof]
        signals[DISPLACEMENT + dof] = qpos[joint]
        signals[VELOCITY + dof] = qvel[joint]
        signals[ACCELERATION + dof] = qacc[joint]
    for channel in range(N_GROUND):
        signals[GROUND + channel] = ground[channel, 0]
        signals[GROUND + N_GROUND + channel] = ground[channel, 1] * rate
        signals[GROUND + 2 * N_GROUND + channel] = ground[channel, 2]
    for k in range(N_STATES * N_MOUNTS):
        signals[STATE + k] = act[k]
    for mount in range(N_MOUNTS):
        signals[PLATE + mount] = length[mount]
        signals[PLATE + N_MOUNTS + mount] = velocity[mount]


@kernel
def combine(terms, weights, signals, raw):  # type: ignore[no-untyped-def]
    """Channels as sums of signals."""
    raw[:] = 0.0
    for channel in range(terms.shape[0]):
        for term in range(terms.shape[1]):
            raw[channel] += weights[channel, term] * signals[terms[channel, term]]


@kernel
def release(number, parts, converter, memory, control):  # type: ignore[no-untyped-def]
    """Hand the valves the outputs whose time has come."""
    changed = False
    for k in range(parts.shape[0]):
        since, every = number - parts[k, DELAY], parts[k, EVERY]
        if parts[k, DELAY] > 0 and since >= 0 and since % every == 0:
            place = parts[k, RING] + N_MOUNTS * ((since // every) % parts[k, PLACES])
            for valve in range(N_MOUNTS):
                memory[parts[k, HELD] + valve] = memory[place + valve]
            changed = True
    if changed:
        convert_held(parts, converter, memory, control)


@kernel
def convert_held(parts, converter, memory, control):  # type: ignore[no-untyped-def]
    """Commands from what all laws hold."""
    for valve in range(N_MOUNTS):
        total = 0.0
        for k in range(parts.shape[0]):
            total += memory[parts[k, HELD] + valve]
        control[valve] = converted(total, converter[0], converter[1])


@kernel
def measure(sample, noise, grid, analogue, readings):  # type: ignore[no-untyped-def]
    """Readings of one sample from what the instruments give; ``noise`` (samples, channels) may be empty."""
    for c in range(readings.size):
        value = analogue[c] + noise[sample, c] if noise.shape[0] > 0 else analogue[c]
        readings[c] = converted(value, grid[c, 0], grid[c, 1])


@kernel
def take_sample(number, time, parts, matrices, inputs_of, converter, readings, memory, measured, scratch, totals):  # type: ignore[no-untyped-def]
    """Let every law that is due compute; returns what that means for the commands. ``totals`` (2, 4) is scratch."""
    answer = NOT_DUE
    for k in range(parts.shape[0]):
        if number % parts[k, EVERY] != 0:
            continue
        answer = max(answer, AT_ONCE if parts[k, DELAY] == 0 else WAITS)
        n, p, first, at = parts[k, N_PART_STATES], parts[k, N_PART_INPUTS], parts[k, MATRICES], parts[k, INPUTS_AT]
        for i in range(p):
            measured[at + i] = readings[inputs_of[at + i]]
        latest = memory[parts[k, LATEST] : parts[k, LATEST] + N_MOUNTS]
        if parts[k, FUNCTION] != 0:
            taken = memory[parts[k, TAKEN] : parts[k, TAKEN] + N_MOUNTS]
            inputs = measured[at : at + p]
            if call_law(parts[k, FUNCTION], time, inputs.ctypes.data, taken.ctypes.data, latest.ctypes.data) != 0:
                return FAILED
        else:
            C = first + n * (n + p)
            states = memory[parts[k, OWN_STATES] : parts[k, OWN_STATES] + n]
            D = C + N_MOUNTS * n
            wanted(matrices[C:D], matrices[D : D + N_MOUNTS * p], states, measured[at : at + p], latest)
    if answer == NOT_DUE:
        return answer
    total, taken = totals[0], totals[1]
    total[:] = 0.0
    for k in range(parts.shape[0]):
        for valve in range(N_MOUNTS):
            total[valve] += memory[parts[k, LATEST] + valve]
    share = faded(time, converter[2], converter[3])
    limited(total, share, converter[0], taken)
    for k in range(parts.shape[0]):
        if number % parts[k, EVERY] == 0:
            finish_sample(number, k, share, parts, matrices, memory, measured, scratch, taken)
    return answer


@kernel
def finish_sample(number, k, share, parts, matrices, memory, measured, scratch, taken):  # type: ignore[no-untyped-def]
    """Advance the states of law ``k``, and queue its outputs (without delay: hold them)."""
    n, p, first, at = parts[k, N_PART_STATES], parts[k, N_PART_INPUTS], parts[k, MATRICES], parts[k, INPUTS_AT]
    if parts[k, FUNCTION] == 0 and n > 0:
        states = memory[parts[k, OWN_STATES] : parts[k, OWN_STATES] + n]
        B = first + n * n
        advance_states(matrices[first:B], matrices[B : B + n * p], states, measured[at : at + p], scratch[:n])
        if parts[k, WINDUP] >= 0:
            add_product(matrices[parts[k, WINDUP] : parts[k, WINDUP] + N_MOUNTS * n], taken, states)
    place = parts[k, RING] + N_MOUNTS * ((number // parts[k, EVERY]) % parts[k, PLACES])
    if parts[k, DELAY] == 0:
        place = parts[k, HELD]
    for valve in range(N_MOUNTS):
        memory[parts[k, TAKEN] + valve] = taken[valve]
        memory[place + valve] = share * memory[parts[k, LATEST] + valve]


@kernel
def read_sensors(  # type: ignore[no-untyped-def]
    number, sample, terms, weights, filters, feedthrough, zeroed, grid, noise, signals, raw, analogue, scratch, rest,
    states, readings
):  # fmt: skip
    """Filter the channels for one step; at a sample (number ``sample`` of ``noise``; −1: none) take the readings."""
    combine(terms, weights, signals, raw)
    if number == 0:
        rest[:] = zeroed * raw
    raw -= rest
    if filters.shape[1] > 0:
        if number == 0:
            settle_filters(filters, raw, states)
        filter_readings(filters, feedthrough, raw, states, analogue, scratch)
    else:
        analogue[:] = raw
    if sample >= 0:
        measure(sample, noise, grid, analogue, readings)
