"""Machine, sensors and digital controller from sample to sample: what a loop gain and a closed loop are made of.

Between two events (a sample, an output whose time has come) machine and sensors move as a linear system with held
commands, which is exact; at an event the state jumps. So delays that are fractions of a sample, and laws of several
rates, are exact too. Fade, range and resolution play no part.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Final, NamedTuple

import numpy as np
from scipy.linalg import expm

from ehamj.arrays import Array, ComplexArray
from ehamj.control import Controller, ControllerBank, LinearController
from ehamj.control.blocks import response
from ehamj.control.clock import common_multiple, exact
from ehamj.linear.loop import Loop, Opened
from ehamj.linear.machine import LinearModel
from ehamj.linear.scales import sizes, state_units

STABLE: Final = 1.0 + 1e-9
"""Spectral radius up to which a sampled loop counts as stable: neutral states stand at one, but for rounding."""


class MeasuredMachine(NamedTuple):
    """ẋ = A x + B v, readings = C x: machine and sensors with the valves' commands v [V] as inputs."""

    A: Array
    B: Array
    C: Array
    states: tuple[str, ...]
    channels: tuple[str, ...]
    """Of the readings."""


def measured_machine(model: LinearModel, loop: Loop, disturbances: Sequence[str] = ()) -> MeasuredMachine:
    """The machine with the loop's instruments at its channels; what the ground adds to them is left out.

    Args:
        model: linearised machine.
        loop: with the instruments.
        disturbances: inputs of the model that are states too, which stay as they are.

    Raises:
        InputError: if a channel is unknown, or its instrument measures another quantity.
        ValueError: if a measured channel answers a command at once.
    """
    channels, sensors, valves = loop.law.inputs, loop.sensors, len(model.commands)
    rows = sensors.rows(channels, model.plant, loop.seed)
    C, D = rows @ model.signals[0], rows @ model.signals[1][:, :valves]
    if np.abs(D).max(initial=0.0) > 0:
        raise ValueError("a measured channel answers a command at once")
    A, B, names = model.A, model.B[:, :valves], list(model.states)
    if disturbances:
        columns, more = [model.inputs.index(name) for name in disturbances], len(disturbances)
        A = np.block([[A, model.B[:, columns]], [np.zeros((more, len(A) + more))]])
        B, C = np.vstack([B, np.zeros((more, valves))]), np.hstack([C, rows @ model.signals[1][:, columns]])
        names += [f"disturbance {name}" for name in disturbances]
    for k, name in enumerate(channels):
        sensor = sensors.of(name)
        if sensor is None or not sensor.filters:
            continue
        block = sensor.block()
        size = block.A.shape[0]
        A = np.block([[A, np.zeros((A.shape[0], size))], [np.outer(block.B, C[k]), block.A]])
        B = np.vstack([B, np.zeros((size, valves))])
        reading = np.hstack([block.D @ C[[k]], block.C])[0]
        C = np.hstack([C, np.zeros((len(channels), size))])
        C[k] = reading
        names += [f"controller sensor {name} {state}" for state in range(size)]
    return MeasuredMachine(A, B, C, tuple(names), channels)


def sampled_machine(
    model: LinearModel, loop: Loop, disturbances: Sequence[str] = (), beside: Sequence[Controller] = ()
) -> Any:
    """What a law of one rate sees, as an `ehamj.linear.plants.LinearPlant` with its ``dt``: from the commands that it
    computes at a sample to its readings at the samples, with delay, hold, machine and sensors; no command has a direct
    way.

    The loop gain is ``control.ss(law.A, …, law.period)`` times this.

    Args:
        model: linearised machine.
        loop: of whose law channels, period and delay count; its matrices do not.
        disturbances: further inputs of the model, which come after the commands and are held between samples.
        beside: laws that run around the machine as well; the period must be a multiple of theirs.
    """
    from ehamj.linear.plants import LinearPlant

    law, valves = loop.law.parts[0], np.eye(len(model.commands))
    # A law that gives its states, and keeps them, to the valves: they are the commands.
    nothing = np.zeros((len(valves), len(law.inputs)))
    held = replace(law, A=valves, B=nothing, C=valves, D=nothing, anti_windup=None, lines=())
    together = held if not beside else ControllerBank((*(_alike(other, held) for other in beside), held))
    machine = measured_machine(model, replace(loop, law=together), disturbances)
    places, matrix = _carried(machine, together.parts)
    # States that nothing changes over a period are its inputs: the commands, and what disturbs.
    constant = [machine.states.index(f"disturbance {name}") for name in disturbances]
    own = [*range(*places[-1].law.indices(len(matrix))), *constant]
    states = np.delete(np.arange(len(matrix)), own)
    names = tuple(np.delete([*machine.states, *_names(places, together.parts, model.commands)], own).tolist())
    C = np.pad(machine.C, ((0, 0), (0, len(matrix) - len(machine.states))))
    C = C[[machine.channels.index(name) for name in law.inputs]]
    rest = np.concatenate([model.equilibrium, np.zeros(len(states) - len(model.equilibrium))])
    return LinearPlant.scaled(
        (matrix[np.ix_(states, states)], matrix[np.ix_(states, own)], C[:, states], C[:, own]),
        sizes(names), rest, state_units(names), law.period,
        states=list(names), inputs=[*model.commands, *disturbances], outputs=list(law.inputs),
    )  # fmt: skip


def _alike(law: Controller, pattern: Controller) -> Controller:
    """The law with the converter of another, so that they can run beside each other."""
    names = ("voltage_limit", "bits", "switch_on", "fade", "from_rest")
    return replace(law, **{name: getattr(pattern, name) for name in names}, anti_windup=None)


def _names(places: Sequence["_Places"], parts: Sequence[Controller], commands: Sequence[str]) -> list[str]:
    """Of what follows machine and sensors: states of laws, what is held at the valves, what waits."""
    found = []
    for k, (own, part) in enumerate(zip(places, parts, strict=True)):
        law = f"law {k}" if len(parts) > 1 else "law"
        found += [f"controller {law} {state}" for state in range(part.states)]
        found += [f"controller {law} holds {name}" for name in commands]
        waiting = range((own.queue.stop - own.queue.start) // len(commands))
        found += [f"controller {law} waits {age} {name}" for age in waiting for name in commands]
    return found


def opened_at_samples(model: LinearModel, loop: Loop, z: ComplexArray) -> Opened:
    """The loop of a law of one rate cut open at the commands that it computes; delay and hold count to the plant.

    Args:
        model: linearised machine.
        loop: with a law of one rate.
        z: e^{jωT} of each frequency, (f,).
    """
    (law,) = loop.law.parts
    machine = sampled_machine(model, loop)
    return Opened(law.at(z), response(z, machine.A, machine.B, machine.C))


@dataclass(frozen=True)
class SampledLoop:
    """The closed loop over one ``period`` [s], after which the pattern of all rates repeats: x⁺ = A x."""

    A: Array
    states: tuple[str, ...]
    period: float
    _between: tuple[tuple[float, Array], ...]
    """Times within the period [s], and the map from its beginning to there."""

    def exponents(self, values: ComplexArray, vectors: ComplexArray) -> ComplexArray:
        """Eigenvalues of A in continuous time [rad/s].

        With one rate, frequencies end at half of it. Where several rates make the period longer than a sample, the
        turns within it are found by following the vector (columns of ``vectors``) from event to event.
        """
        s = np.log(values) / self.period
        if len(self._between) < 2:
            return np.asarray(s)
        times = np.array([time for time, _ in self._between])
        overlap = np.array([(vectors.conj() * (step @ vectors)).sum(axis=0) for _, step in self._between])
        most = math.ceil(0.5 * self.period / np.diff(times, prepend=0.0).min())
        turns = 2j * np.pi / self.period * np.arange(-most, most + 1)
        for k in range(s.size):
            trial = np.exp((s[k] + turns)[:, None].conj() * times) @ overlap[:, k]
            s[k] += turns[np.argmax(trial.real)]
        return np.asarray(s)


def sampled_loop(model: LinearModel, loop: Loop) -> SampledLoop:
    """Machine, sensors and law from sample to sample, of several rates from pattern to pattern.

    Outputs act ``latency`` after their sample and are held for a period; those that wait are states.

    Raises:
        InputError: if a channel's instrument measures another quantity.
    """
    machine, parts = measured_machine(model, loop), loop.law.parts
    between: list[tuple[float, Array]] = []
    _, matrix = _carried(machine, parts, between)
    names = (*machine.states, *(f"controller {k}" for k in range(len(matrix) - len(machine.states))))
    return SampledLoop(matrix, names, pattern_period(loop.law), tuple(between) if len(parts) > 1 else ())


def pattern_period(law: LinearController) -> float:
    """Time after which the samples of all rates repeat [s]; of one rate its period."""
    return float(common_multiple(part.period for part in law.parts))


def spectral_radius(model: LinearModel, loop: Loop) -> float:
    """Largest magnitude of an eigenvalue of the sampled loop: stable below one (`STABLE`)."""
    return float(np.abs(np.linalg.eigvals(sampled_loop(model, loop).A)).max())


class _Places(NamedTuple):
    """Where a law lies in the vector that is carried, which begins with machine and sensors."""

    law: slice
    held: slice
    """What its output to the valves is at present."""
    queue: slice
    """Outputs that wait, newest first. At most as many as fit into the delay: a sample's output joins them before the
    first is released."""

    @classmethod
    def of(cls, machine: MeasuredMachine, parts: Sequence[Controller]) -> tuple["_Places", ...]:
        at, valves = machine.B.shape
        waiting = [math.ceil(exact(part.latency) / exact(part.period)) for part in parts]
        sizes = [(part.states, valves, valves * outputs) for part, outputs in zip(parts, waiting, strict=True)]
        ends = at + np.cumsum(sizes)
        found = [slice(int(end) - size, int(end)) for end, size in zip(ends, np.ravel(sizes).tolist(), strict=True)]
        return tuple(cls(*found[k : k + 3]) for k in range(0, len(found), 3))


def _pattern(parts: Sequence[Controller]) -> tuple[Fraction, list[tuple[Fraction, list[int], list[int]]]]:
    """The time after which everything repeats, and events in it: time, laws released, laws sampled."""
    length = common_multiple(part.period for part in parts)
    found: dict[Fraction, tuple[list[int], list[int]]] = {}
    for k, part in enumerate(parts):
        period = exact(part.period)
        for sample in range(int(length / period)):
            found.setdefault(sample * period, ([], []))[1].append(k)
            if part.latency > 0:
                due = (sample * period + exact(part.latency)) % length
                found.setdefault(due, ([], []))[0].append(k)
    return length, [(time, *found[time]) for time in sorted(found)]


def _carried(
    machine: MeasuredMachine, parts: Sequence[Controller], between: list[tuple[float, Array]] | None = None
) -> tuple[tuple[_Places, ...], Array]:
    """The vector's places, and its map over one pattern from just before the first events; at each time after events
    also into ``between``."""
    places = _Places.of(machine, parts)
    length, events = _pattern(parts)
    total = np.eye(places[-1].queue.stop)
    flows: dict[Fraction, Array] = {}
    ends = [time for time, _, _ in events[1:]] + [length]
    for (time, released, sampled), end in zip(events, ends, strict=True):
        for k in released:
            total = _release(places[k], len(total)) @ total
        if sampled:
            total = _sample(machine, [(parts[k], places[k]) for k in sampled], len(total)) @ total
        if end - time not in flows:
            flows[end - time] = _flow(machine, places, float(end - time))
        total = flows[end - time] @ total
        if between is not None:
            between.append((float(end), total))
    return places, total


def _flow(machine: MeasuredMachine, places: Sequence[_Places], time: float) -> Array:
    """Machine and sensors move for a time under what is held."""
    n, valves = machine.B.shape
    block = expm(np.block([[machine.A, machine.B], [np.zeros((valves, n + valves))]]) * time)
    matrix = np.eye(places[-1].queue.stop)
    matrix[:n, :n] = block[:n, :n]
    for own in places:
        matrix[:n, own.held] = block[:n, n:]
    return matrix


def _release(own: _Places, size: int) -> Array:
    """The output that waited longest is held."""
    matrix, valves = np.eye(size), own.held.stop - own.held.start
    matrix[own.held] = np.eye(size)[own.queue][-valves:]
    return matrix


def _sample(machine: MeasuredMachine, sampled: Sequence[tuple[Controller, _Places]], size: int) -> Array:
    """Laws compute: their outputs join those that wait (without delay: are held), their states advance."""
    matrix, (n, valves) = np.eye(size), machine.B.shape
    for law, own in sampled:
        read = machine.C[[machine.channels.index(name) for name in law.inputs]]
        matrix[own.queue] = np.eye(size, k=-valves)[own.queue]
        target = slice(own.queue.start, own.queue.start + valves) if law.latency > 0 else own.held
        for rows, of_readings, of_states in ((target, law.D, law.C), (own.law, law.B, law.A)):
            matrix[rows] = 0.0
            matrix[rows, :n], matrix[rows, own.law] = of_readings @ read, of_states
    return matrix
