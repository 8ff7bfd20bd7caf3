"""What a run of a scenario will show, from the linear closed loop: the same floor at each mount, the same levels.

The floor's displacement at each mount and axis goes through the closed loop bin by bin of its Fourier transform, so
that waves, incoherence, sideways motion and whatever an eccentric centre of gravity couples are in it as in the run.
Behind the run's end the floor comes back to rest, so that nothing comes round to the beginning.

What the machine does beyond its linear model follows by one step of Picard's iteration: along the linear motion the
nonlinear equations (turbulent flow, compressed oil, limits of the spools, turning) have other rates than the linear
ones, and these differences shake the linear closed loop as a disturbance of its states. That is the whole answer to
second order in the motion; where commands are limited, or where a valve has a dead zone, it is an estimate.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, NamedTuple

import mujoco
import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from ehamj.arrays import Array, ComplexArray
from ehamj.control import LinearController
from ehamj.control.blocks import response
from ehamj.control.compiled.signals import Layout
from ehamj.ground.motion import Motion
from ehamj.judge.levels import BANDS, SLAB
from ehamj.linear.loop import Loop
from ehamj.linear.machine import FORCES, LinearModel, grounds
from ehamj.linear.margins import grid
from ehamj.linear.response import commanded, readings_of_ground
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import Inputs, rates_along
from ehamj.mujoco.model import build_model
from ehamj.plant.axes import AXES, DOFS
from ehamj.scenario.model import Scenario
from ehamj.signals import rise

OUTPUTS: Final = (*(f"cg_velocity {axis}" for axis in AXES), *(f"machine_velocity {turn}" for turn in SLAB[3:]))
"""Channels of the machine's `SLAB`."""
LEAST_RATE: Final = 2500.0
"""At which motions are followed at least [Hz]; rows of the result are picked from them."""
REST: Final = 20.0
"""Time that the floor takes to come back to rest behind the run, and then for what is slow to die out [s]."""
SLOWED: Final = 0.5
"""In which its speed at the run's end falls to nothing [s]."""
LONGEST: Final = 60.0
"""Of a longer run so much is looked at [s]."""
ENDS: Final = 0.25
"""Behind the run's end, time in which what is nonlinear fades out [s]."""
FAINT: Final = 1e-8
"""Share of a transform's power, weighed as its derivative, that may be left out at its upper end."""
FREQUENCIES: Final = 900
"""At which the closed loop is computed beside those about resonances; between them it is interpolated."""


@dataclass(frozen=True)
class Course:
    """The times that are looked at: ``run`` samples of the run, ``every``-th of which is a row, and the rest."""

    rate: float
    every: int
    run: int

    @classmethod
    def of(cls, scenario: Scenario, duration: float) -> "Course":
        """Of so much of a scenario's run [s]."""
        every = int(np.ceil(LEAST_RATE / scenario.record_rate))
        rate = every * scenario.record_rate
        return cls(rate, every, round(min(duration, LONGEST) * rate) + 1)

    @property
    def stride(self) -> int:
        """Every so many samples what is nonlinear is looked at."""
        return max(int(self.rate / LEAST_RATE), 1)

    @cached_property
    def size(self) -> int:
        """Samples in all, a multiple of the stride."""
        return self.stride * int(next_fast_len(int((self.run + REST * self.rate) / self.stride), real=True))

    @property
    def time(self) -> Array:
        """Of the run [s]."""
        return np.arange(self.run) / self.rate

    @cached_property
    def frequency(self) -> Array:
        """Of the transform's bins [Hz]."""
        return np.asarray(np.arange(self.size // 2 + 1) * (self.rate / self.size))

    def spectrum(self, samples: Array) -> ComplexArray:
        """Transform of what happens in the run, (run, k), and comes to rest behind it without a jump or a kink."""
        away = samples - samples[:1]
        after = np.arange(1, self.size - self.run + 1)[:, None] / self.rate
        slope = (away[-1:] - away[-2:-1]) * self.rate
        behind = away[-1:] + slope * after * (1.0 - rise(after / SLOWED).value)
        behind *= 1.0 - rise(after / (0.5 * REST)).value
        return np.asarray(rfft(np.concatenate([away, behind]), axis=0))

    def over_time(self, spectrum: ComplexArray, length: int | None = None) -> Array:
        """Samples of a transform, as many as the run has, or ``length``."""
        return np.asarray(irfft(spectrum, self.size, axis=0)[: length or self.run])


@dataclass(frozen=True)
class Predicted:
    """Motions that a run will show, rows of the result (rows, `SLAB`) [m/s, rad/s], and commands (run, mount) [V].

    ``causes`` are parts of the machine's motion, which add up to it. The commands are those of the linear machine.
    """

    floor: Array
    """The mounts' velocities (rows, mount, axis)."""
    causes: Mapping[str, Array]
    command: Array


def predicted(
    scenario: Scenario, model: LinearModel, law: LinearController, motion: Motion, duration: float
) -> Predicted:
    """Motions of a machine under a law.

    Args:
        scenario: whose sensors measure and whose forces act.
        model: the linearised machine.
        law: digital controller.
        motion: of the ground.
        duration: of the run [s].
    """
    loop, course = Loop.of(scenario, law), Course.of(scenario, duration)
    sampled = motion.sample(course.time).below(len(model.plant.mounts))
    displacement = course.spectrum(sampled.displacement.reshape(course.run, -1))
    closed = Closed(model, loop, course)
    by_floor = closed.ground(displacement)
    found = {"law, delay and valve": by_floor}
    load = scenario.load()
    if not load.absent:
        found["forces on the machine"] = closed.forces(course.spectrum(load.sample(course.time)[0]))
    whole = Answer(*(np.asarray(sum(parts)) for parts in zip(*found.values(), strict=True)))
    found["nonlinear oil and valves"] = closed.beyond(displacement, whole)
    rows = slice(None, None, course.every)
    causes = {name: course.over_time(one.outputs)[rows] for name, one in found.items()}
    return Predicted(sampled.velocity[rows], causes, course.over_time(whole.commands))


class Answer(NamedTuple):
    """Transforms of what a disturbance makes of the closed loop: `OUTPUTS`, commands as they act, and states."""

    outputs: ComplexArray
    commands: ComplexArray
    states: ComplexArray


class Closed:
    """The closed loop at the bins of a course, and what disturbs it."""

    def __init__(self, model: LinearModel, loop: Loop, course: Course) -> None:
        self.model, self.loop, self.course = model, loop, course
        last = min(0.5 * course.rate, 0.99 * 0.5 / max(part.period for part in loop.law.parts))
        even = np.geomspace(0.5 * course.frequency[1], last, FREQUENCIES)
        near = grid(loop.law, model)
        self.hertz = f = np.unique(np.concatenate([even, near[(near > even[0]) & (near < last)]]))
        unit = np.eye(len(model.A))
        self.inside = response(2j * np.pi * f, model.A, unit, unit)
        """States over rates that are added to theirs, valves held, (f, states, states)."""
        every = np.broadcast_to(np.eye(len(loop.law.inputs), dtype=complex), (f.size, *[len(loop.law.inputs)] * 2))
        self.commanded = commanded(model, loop, f, every)
        """Commands over what moves the readings, (f, valve, reading)."""
        # Between two frequencies responses are straight lines over log f.
        self.bins = np.flatnonzero((course.frequency > f[0]) & (course.frequency < f[-1]))
        place = np.interp(np.log(course.frequency[self.bins]), np.log(f), np.arange(f.size))
        self.below = np.minimum(place.astype(int), f.size - 2)
        self.share = place - self.below

    def ground(self, displacement: ComplexArray) -> Answer:
        """What the ground's displacements do, (bins, mount·axis) [m]."""
        s, places = 2j * np.pi * self.hertz[:, None, None], len(grounds(self.model.plant.mounts))
        B = self.model.B[:, [self.model.inputs.index(name) for name in self.model.ground_inputs]]
        readings = readings_of_ground(self.model, self.loop, self.hertz)
        return self._answer(displacement, self.inside @ B[:, :places] + s * (self.inside @ B[:, places:]), readings)

    def disturbed(self, spectrum: ComplexArray, rates: Array) -> Answer:
        """What inputs (bins, k) do that change the states' rates, (states, k) each."""
        shaken, names = with_inputs(self.model, rates)
        channels, shares = self.loop.mixtures()
        seen = np.zeros((self.hertz.size, len(channels), len(names)), complex)
        own = [k for k, name in enumerate(channels) if not name.startswith("ground_")]
        C, D = shaken.rows([channels[k] for k in own])
        states = self.inside @ rates
        seen[:, own] = C @ states + D
        read = self.loop.sensors.response(self.loop.law.inputs, self.hertz)[:, :, None]
        return self._answer(spectrum, states, read * (shares @ seen))

    def forces(self, wrench: ComplexArray) -> Answer:
        """What a wrench at the centre of gravity does, (bins, 6) [N, N m]."""
        return self.disturbed(wrench, self.model.B[:, [self.model.inputs.index(name) for name in FORCES]])

    def beyond(self, displacement: ComplexArray, linear: Answer) -> Answer:
        """What the machine does beyond the linear motion, by the rates that its own equations have along it."""
        model, course = self.model, self.course
        ground = np.stack([displacement, 2j * np.pi * course.frequency[:, None] * displacement], axis=1)
        stride = course.stride
        length = course.run + int(ENDS * course.rate)
        moved = (course.over_time(one, length)[::stride] for one in (linear.states, linear.commands, ground))
        x, u, g = (one - one[:1] for one in moved)  # all begin from rest; what is constant was left out
        columns = [model.inputs.index(name) for name in (*model.commands, *model.ground_inputs)]
        straight = x @ model.A.T + np.hstack([u, g.reshape(len(g), -1)]) @ model.B[:, columns].T
        differ = nonlinear_rates(model, x, u, g) - straight
        over = (stride * np.arange(len(x)) - course.run) / (ENDS * course.rate)
        differ *= 1.0 - rise(over).value[:, None]
        acting = np.flatnonzero(np.any(differ, axis=0))
        spectrum = np.zeros((course.frequency.size, acting.size), complex)
        found = stride * rfft(differ[:, acting], course.size // stride, axis=0)
        spectrum[: len(found)] = found
        return self.disturbed(spectrum, np.eye(len(model.A))[:, acting])

    def _answer(self, spectrum: ComplexArray, inside: ComplexArray, readings: ComplexArray) -> Answer:
        """By the states and the readings with the valves held, over each input of the spectrum."""
        model, commands = self.model, self.commanded @ readings
        valves = [model.inputs.index(name) for name in model.commands]
        states = inside + self.inside @ model.B[:, valves] @ commands
        C, _ = model.rows(OUTPUTS)
        return Answer(*(self._passed(spectrum, one) for one in (C @ states, commands, states)))

    def _passed(self, spectrum: ComplexArray, over: ComplexArray) -> ComplexArray:
        """What a response (f, output, input) makes of a transform (bins, input)."""
        found = np.zeros((self.course.frequency.size, over.shape[1]), complex)
        # Above all bands, what is fainter than FAINT at the upper end is left out.
        gain = np.abs(over).max(axis=1)[self.below]
        power = np.cumsum(((np.abs(spectrum[self.bins]) * gain).max(axis=1, initial=0.0) ** 2)[::-1])[::-1]
        worth = int(np.searchsorted(-power, -FAINT * power[0])) if power.any() else 0
        worth = max(worth, int(np.searchsorted(self.course.frequency[self.bins], 1.1 * BANDS[-1].edges[1])))
        bins, below, share = self.bins[:worth], self.below[:worth], self.share[:worth]
        for k in np.flatnonzero(np.any(spectrum, axis=0)):
            own = spectrum[bins, k]
            for row in range(over.shape[1]):
                one = over[:, row, k]
                found[bins, row] += (one[below] + share * np.diff(one)[below]) * own
        return found


def with_inputs(model: LinearModel, rates: Array) -> tuple[LinearModel, tuple[str, ...]]:
    """A model with other inputs, which change the states' ``rates`` (states, inputs), and these inputs' names."""
    names = tuple(f"disturbance {k}" for k in range(rates.shape[1]))
    D, first = np.zeros((model.signals[0].shape[0], rates.shape[1])), Layout.of(len(model.plant.mounts)).acceleration
    for dof, name in enumerate(DOFS):
        D[first + dof] = rates[model.states.index(f"velocity {name}")]
    return replace(model, B=rates, inputs=names, signals=(model.signals[0], D)), names


def nonlinear_rates(model: LinearModel, states: Array, commands: Array, ground: Array) -> Array:
    """Rates of the states of the simulated machine, (n, states), about its equilibrium.

    Args:
        model: linear about it.
        states: deviations from it, (n, states).
        commands: (n, mount) [V].
        ground: displacement and velocity of the ground, (n, 2, mount·axis) [m, m/s].
    """
    engine = build_model(model.plant, 1e-4)
    data = mujoco.MjData(engine)
    ground = ground.reshape(len(ground), 2, -1, len(AXES))
    with hydraulics():
        return rates_along(engine, data, states + model.equilibrium, Inputs(ground[:, 0], ground[:, 1], commands))
