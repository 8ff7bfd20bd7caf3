"""A controller made ready for the stepping loop: its laws and sensors as the tables that compiled code works on."""

import ctypes
import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ehamj.arrays import Array
from ehamj.control import AnyController, Controller, PythonController
from ehamj.control.channels import STATIC, quantity_of
from ehamj.control.compiled.converter import Conversion
from ehamj.control.compiled.laws import LAW, LawMemory, Laws, step_shares
from ehamj.control.compiled.learning import USED
from ehamj.control.compiled.sensing import Readings, Sensing
from ehamj.control.compiled.signals import Layout
from ehamj.control.compiled.stage import LEVEL, REMEMBERS
from ehamj.control.converter import Converter, check_mounts
from ehamj.control.following import lines_of
from ehamj.control.instruments import OLDER, Discrete, discretise
from ehamj.control.learners import strokes
from ehamj.control.matrices import Integers, Matrices, by_rows
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.control.spools import positions
from ehamj.control.stage import (
    AT_START,
    Inner,
    Stage,
    begun,
    numbers_of,
    paces_of,
    pressure_places,
    spool_numbers,
    stated,
)
from ehamj.plant.plant import Plant

_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, *(ctypes.c_void_p,) * 3)


@dataclass(frozen=True, eq=False)
class DigitalLoop:
    """A controller and its sensors as the stepping loop runs them, with all that they remember.

    Of one simulation, or of a block of them (`stacked`), whose lanes come last in the flat arrays.
    """

    laws: Laws
    law_memory: LawMemory
    sensing: Sensing
    readings: Readings
    states: int
    """Of all laws, frequencies of the lines that they follow, and what they learn; these come first in
    ``law_memory``."""
    functions: tuple[Any, ...]
    """Python laws as C functions; kept alive here."""
    failures: list[Exception]
    """What Python laws raised."""

    def samples(self, first: int, count: int) -> tuple[int, int]:
        """Of ``count`` steps from ``first``: the number of the first sample among them, and how many there are."""
        base = self.laws.base
        if base == 0:
            return 0, 0
        begin, end = -(-first // base), -(-(first + count) // base)
        return begin, end - begin


def no_loop(mounts: int) -> DigitalLoop:
    """No controller and nothing to read."""
    return _made((), (), Converter(), np.zeros((0, 0)), IDEAL, 1.0, np.full(mounts, np.inf))


def make_loop(
    controller: AnyController | None, plant: Plant, timestep: float, sensors: Sensors = IDEAL, seed: int = 0
) -> DigitalLoop:
    """A controller made ready for a step that divides its periods, at the beginning of a simulation.

    Raises:
        InputError: if a sensor does not measure what the controller reads.
    """
    if controller is None:
        return no_loop(len(plant.mounts))
    check_mounts(controller.converter, plant.mounts)
    rows = sensors.rows(controller.reads, plant, seed)
    ranges = np.array([actuator.voltage_limit for actuator in plant.actuators])
    return _made(controller.parts, controller.reads, controller.converter, rows, sensors, timestep, ranges)


def structure(loop: DigitalLoop) -> Hashable:
    """What loops must have in common to run in the lanes of one block: all but numbers of matrices, sensors, memory."""
    laws, sensing = loop.laws, loop.sensing
    names = ("table", "rows", "columns", "inputs_of", "pressures", "strokes", "positions", "lines")
    tables = (*(getattr(laws, name) for name in names), sensing.terms, sensing.entries)
    shapes = tuple((table.shape, table.tobytes()) for table in tables)
    return (
        *shapes,
        laws.converter,
        laws.valves.size,
        laws.learners.size,
        laws.spools.size,
        laws.followed.size,
        laws.base,
        sensing.layout,
        sensing.order,
        loop.states,
    )


def stacked(loops: Sequence[DigitalLoop]) -> DigitalLoop:
    """Loops of one structure as the lanes of a block, each as it stands; of one loop it is a copy.

    Raises:
        ValueError: if their structure differs, or several have a Python function, which computes for one machine alone.
    """
    first = loops[0]
    if len(loops) > 1 and any(loop.functions for loop in loops):
        raise ValueError("a law that is a Python function runs for one machine alone, not in a block of several")
    if any(structure(loop) != structure(first) for loop in loops):
        raise ValueError("the loops differ in structure; only loops of one structure run in one block")

    def lanes(shared: Any, own: tuple[str, ...] = ()) -> Any:
        parts = [[getattr(table, name) for table in shared] for name in own]
        return shared[0]._replace(
            **{name: np.stack(part, axis=-1).ravel() for name, part in zip(own, parts, strict=True)}
        )

    laws = [loop.laws if len(loops) == 1 else by_rows(loop.laws) for loop in loops]
    own = ("weights", "filters", "feedthrough", "zeroed", "gains", "offsets", "limits", "resolutions")
    return replace(
        first,
        laws=lanes(laws, ("matrices", "ranges", "valves", "learners", "spools", "followed")),
        law_memory=lanes([loop.law_memory for loop in loops], LawMemory._fields),
        sensing=lanes([loop.sensing for loop in loops], own),
        readings=lanes([loop.readings for loop in loops], Readings._fields),
    )


def _made(
    parts: Sequence[Controller | PythonController], channels: tuple[str, ...], converter: Converter, rows: Array,
    sensors: Sensors, timestep: float, ranges: Array,
) -> DigitalLoop:  # fmt: skip
    failures: list[Exception] = []
    mounts = ranges.size
    functions = {k: _function(p, failures, mounts) for k, p in enumerate(parts) if isinstance(p, PythonController)}
    stage = (Stage.beside(parts, len(converter.learners)),) if converter.valves else ()
    inner = (Inner.of(converter.spools),) if converter.spools else ()
    table, matrices, inputs_of, size = _laws((*parts, *inner, *stage), channels, timestep, functions, mounts)
    lines, followed, kept, frequencies = lines_of(parts, table)
    filters, feedthrough, grid = _instruments(channels, sensors, timestep)
    measures = converter.measures
    rests = [name not in measures and quantity_of(name.partition(" ")[0]) in STATIC for name in channels]
    times = float(converter.switch_on), float(converter.fade)
    conversion = Conversion(float(converter.voltage_limit), converter.resolution, *times)
    within = np.array([k for k in np.argsort(table["fraction"], kind="stable") if table["fraction"][k]], np.int64)
    known = numbers_of(converter.valves, stage[0].period if stage else timestep, converter.voltage_limit)
    pressures = pressure_places(converter.valves, converter.mounts, channels, bool(converter.learners))
    base = int(np.gcd.reduce(table["every"]))
    learners, of_strokes = np.zeros(0), np.zeros(0, np.int64)
    if stage and converter.learners:
        learners = paces_of(converter.learners, converter.valves, stage[0])
        of_strokes = np.array([channels.index(name) for name in strokes(converter.mounts)], np.int64)
    spools = spool_numbers(converter.spools)
    of_spools = np.array([channels.index(name) for name in positions(converter.spools, converter.mounts)], np.int64)
    laws = Laws(
        table, *matrices.tables, inputs_of, conversion, ranges, within, known, pressures, learners, of_strokes,
        lines, followed, spools, of_spools, base,
    )  # fmt: skip
    gathered = begun(converter.learners, learners)
    memory = LawMemory.of(size, inputs_of.size, mounts, kept, (known.copy(), gathered))
    memory.values[int(table["frequencies"][0]) if len(table) else 0 :][: frequencies.size] = frequencies
    memory.stage[LEVEL::REMEMBERS] = AT_START**2
    if converter.learners:
        first = int(table["states_at"][-1])
        memory.values[first : first + USED * mounts] = stated(converter.learners)
    layout, intact = Layout.of(mounts), (np.ones(len(channels)), np.zeros(len(channels)))
    terms, weights = _terms(rows)
    resting = np.array(rests, float) * converter.from_rest
    order = filters.shape[1]
    entries = (filters != 0.0).any(axis=2).ravel()
    sensing = Sensing(
        layout, terms, weights.ravel(), order, filters.ravel(), entries, feedthrough, resting, *intact, *grid
    )
    return DigitalLoop(
        laws, memory, sensing, Readings.of(sensing),
        sum(part.states for part in (*parts, *stage)) + frequencies.size, tuple(functions.values()), failures,
    )  # fmt: skip


def _terms(rows: Array) -> tuple[Integers, Array]:
    """Rows over the vector of signals as short sums: which signals (channels, terms), and their factors."""
    count = int((rows != 0).sum(axis=1).max(initial=0))
    terms = np.argsort(rows == 0, axis=1, kind="stable")[:, :count]
    return np.ascontiguousarray(terms, np.int64), np.ascontiguousarray(np.take_along_axis(rows, terms, axis=1))


def _instruments(
    channels: tuple[str, ...], sensors: Sensors, timestep: float
) -> tuple[Array, Array, tuple[Array, Array]]:
    """Filters, feedthrough, ranges and resolutions of all channels, filled up with nothing to the longest filter; what
    each remembers of its input comes last in all of them."""
    none = np.zeros(0)
    exact = Discrete(np.zeros((0, 0)), none, none, 1.0, none)
    found = [sensors.of(name) for name in channels]
    discrete = [exact if sensor is None else discretise(sensor, timestep) for sensor in found]
    n = max((d.A.shape[0] for d in discrete), default=0)
    filters = np.zeros((n + 3, n, len(channels)))
    alike: dict[int, list[int]] = {}
    for c, d in enumerate(discrete):
        alike.setdefault(id(d), []).append(c)
    for same in alike.values():
        d = discrete[same[0]]
        own = d.A.shape[0]
        at = [*range(own - OLDER), *range(n - OLDER, n)] if own else []
        filters[np.ix_(at, at, same)] = d.A[:, :, None]
        for row, values in enumerate((d.B, d.C, d.settled), start=n):
            filters[np.ix_([row], at, same)] = values[:, None]
    ranges = np.array([np.inf if s is None else s.range for s in found], float)
    resolutions = np.array([0.0 if s is None else s.resolution for s in found], float)
    return filters, np.array([d.D for d in discrete], float), (ranges, resolutions)


def _laws(
    parts: "Sequence[Controller | PythonController | Stage | Inner]",
    channels: tuple[str, ...],
    timestep: float,
    functions: dict[int, Any],
    mounts: int,
) -> tuple[Any, Matrices, Integers, int]:
    """Table of laws, their matrices and channels, and the size of their memory."""
    table = np.zeros(len(parts), LAW)
    matrices = Matrices()
    inputs_of: list[int] = []
    states, size = 0, sum(part.states + len(part.lines) for part in parts)
    count, frequencies = 0, sum(part.states for part in parts if not isinstance(part, Stage))
    for k, (law, part) in enumerate(zip(table, parts, strict=True)):
        law["states"], law["inputs"] = 0 if isinstance(part, Stage) else part.states, len(part.inputs)
        law["every"], (law["delay"], law["fraction"]) = round(part.period / timestep), _parts(part.latency, timestep)
        law["at_start"], law["at_middle"], law["at_end"] = step_shares(law["fraction"])
        law["states_at"], law["inputs_at"] = states, len(inputs_of)
        law["lines"], law["line_at"], law["frequencies"] = len(part.lines), count, frequencies + count
        count += len(part.lines)
        if isinstance(part, Stage):
            law["states_at"] = frequencies + count
        law["latest"], law["held"], law["taken"] = size + mounts * np.arange(3)
        law["ring"], law["places"] = size + 3 * mounts, law["delay"] // law["every"] + 1
        law["rows"] = law["windup"] = -1
        if k in functions:
            law["function"] = ctypes.cast(functions[k], ctypes.c_void_p).value or 0
        if isinstance(part, Controller):
            own = [part.A, part.B, part.C, part.D, *([] if part.anti_windup is None else [part.anti_windup])]
            matrices.put(law, own)
        inputs_of += [channels.index(name) for name in part.inputs]
        states += part.states
        size = int(law["ring"] + mounts * law["places"])
    return table, matrices, np.array(inputs_of, np.int64), size


def _parts(delay: float, timestep: float) -> tuple[int, float]:
    """A delay as whole steps and a fraction of one."""
    steps = delay / timestep
    whole = math.floor(steps + 1e-6)  # times are rounded
    return whole, steps - whole if steps - whole > 1e-6 else 0.0


def _function(law: PythonController, failures: list[Exception], valves: int) -> Any:
    """A Python law as a C function; what it raises goes to ``failures``."""
    if callable(reset := getattr(law.function, "reset", None)):
        reset()

    def call(time: float, measured: int, taken: int, result: int) -> int:
        try:
            inputs, limited_by = _vector(measured, len(law.inputs)), _vector(taken, valves)
            _vector(result, valves)[:] = law.wanted(time, inputs, limited_by)
        except Exception as error:
            failures.append(error)
            return 1
        return 0

    return _FUNCTION(call)


def _vector(address: int, size: int) -> Array:
    """The numbers at an address, not copied."""
    return np.ctypeslib.as_array((ctypes.c_double * size).from_address(address)) if size else np.zeros(0)
