"""The ground below the machines of all lanes, and what it does to them within a step."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np

from ehamj.arrays import Array
from ehamj.compiled import kernel
from ehamj.compiled.lanes import add_products, copy_lanes, peek, poke, set_lanes
from ehamj.ground.motion import GroundSample
from ehamj.memory import INPUTS, ORDERS, Cubic
from ehamj.mujoco.unpacking import hermite
from ehamj.plant.axes import AXES
from ehamj.smallmotion.lanes import stacked

STAGES, END, MIDDLE = 3, 2, 0.5
"""Stages of a step: start, middle and end, which is the last; the middle's fraction of the step."""


class Effects(NamedTuple):
    """What the ground does to a machine; n coordinates, m mounts."""

    by_value: Array
    """Accelerations per displacement (n, m·axis) [1/s² and alike]; forces where a slide moves."""
    by_rate: Array
    """Per velocity."""
    always: Array
    """What is there without (n,)."""
    along: Array
    """Unit vectors of the mounts' actions (m, axis)."""
    stroke: Array
    """Strokes of the machine at its equilibrium over ground at 0 (m,) [m]."""


class Floor(NamedTuple):
    """The ground in a stretch of steps as far as it moves: j numbers the axes that do, mount after mount, and upstream
    behind them."""

    points: Any
    """(step + 1, j, 3) displacement, velocity·step and acceleration at the start of each step and the end of the last
    [m, m, m/s²]; with the lane last where lanes have floors of their own."""
    own: int
    """1 where they have."""
    places: Any
    """(j,) of each among mount·input."""
    first: Any
    """(m + 1) where those of each mount begin."""
    weights: Any
    """(n, 2, j) effects per displacement and velocity·step; flat with the lane last, as all that follow."""
    always: Any
    """(n)"""
    along: Any
    """(2, j) strokes per displacement, their rates per velocity·step."""
    strokes: Any
    """(m) over ground at 0 [m]."""

    @classmethod
    def of(cls, samples: Sequence[GroundSample | None], effects: Sequence[Effects], steps: int, step: float) -> Self:
        """The floors of lanes in so many steps [s] (None: at rest), and their effects on each machine."""
        mounts = effects[0].along.shape[0]
        unlike = {id(one): one for one in samples}
        tables = {key: _points(one, steps, mounts + 1, step) for key, one in unlike.items()}
        moving = np.any([np.any(table, axis=(0, 2)) for table in tables.values()], axis=0)
        mount, axis = np.divmod(np.flatnonzero(moving), len(AXES))
        along = [-np.vstack([one.along, np.zeros(len(AXES))])[mount, axis] for one in effects]
        none = ((0, 0), (0, len(AXES)))  # what the ground upstream does to the machine
        return cls(
            stacked(tables[id(one)][:, moving] for one in (samples if len(tables) > 1 else samples[:1])),
            int(len(tables) > 1),
            mount * len(INPUTS) + axis,
            np.searchsorted(mount, np.arange(mounts + 1)),
            stacked(
                np.stack([np.pad(part, none)[:, moving] for part in (one.by_value, one.by_rate / step)], axis=1)
                for one in effects
            ),
            stacked(one.always for one in effects),
            stacked(np.stack([own, own / step]) for own in along),
            stacked(one.stroke for one in effects),
        )

    def part(self, first: int, steps: int, of: int) -> Self:
        """The floor in some of its steps, of how many it has."""
        size = self.points.size // (of + 1)
        return self._replace(points=self.points[first * size : (first + steps + 1) * size])


def _points(sample: GroundSample | None, steps: int, mounts: int, step: float) -> Array:
    """A floor's displacement, velocity·step and acceleration at the ends of steps, (step + 1, m·axis, 3), of so many
    mounts at most."""
    points = np.zeros((steps + 1, mounts, len(AXES), ORDERS))
    for order, part in enumerate(sample or ()):
        points[:, : part.shape[1], :, order] = part
    points[..., 1] *= step
    return points.reshape(steps + 1, -1, ORDERS)


class Riding(NamedTuple):
    """What the ground does at start, middle and end of a step; flat with the lane last."""

    values: Any
    """(3, j, 3) its displacement, velocity·step and acceleration (in the middle left alone)."""
    force: Any
    """(n) scratch."""
    pushed: Any
    """(3, n) accelerations [m/s², rad/s²]."""
    strokes: Any
    """(3, m, 2) strokes of a machine in its equilibrium, and their rates [m, m/s]."""

    @classmethod
    def of(cls, coordinates: int, mounts: int, width: int) -> Self:
        """Room for it."""
        sizes = (STAGES * (mounts + 1) * len(AXES) * ORDERS, coordinates, STAGES * coordinates, STAGES * mounts * 2)
        return cls(*(np.zeros(size * width) for size in sizes))


@kernel
def put_point(floor, point, values, lanes):  # type: ignore[no-untyped-def]
    """The ground at a point of time into all lanes, as the end of the step."""
    w, size = len(lanes), ORDERS * floor.places.size
    if floor.own:
        copy_lanes(floor.points, point * size * w, values, END * size * w, size * w)
    else:
        for k in range(size):
            value = peek(floor.points, point * size + k)
            for lane in range(w):
                poke(values, (END * size + k) * w + lane, value)


@kernel
def to_start(values, size):  # type: ignore[no-untyped-def]
    """Where a step ends the next one starts; of so many numbers at each stage."""
    copy_lanes(values, END * size, values, 0, size)


@kernel
def put_middle(values, size, lanes):  # type: ignore[no-untyped-def]
    """The ground in the middle of the step, by the cubics between its ends; ``size`` places at each stage."""
    w = len(lanes)
    for k in range(0, size, ORDERS):
        for lane in range(w):
            start, end = k * w + lane, (END * size + k) * w + lane
            cubic = Cubic(peek(values, start), peek(values, start + w), peek(values, end), peek(values, end + w))
            value, slope = hermite(cubic, MIDDLE)
            poke(values, (size + k) * w + lane, value)
            poke(values, (size + k + 1) * w + lane, slope)


@kernel
def act(floor, inverse, row, stage, riding, n, lanes):  # type: ignore[no-untyped-def]
    """What the ground does at a stage; ``row`` is where M⁻¹ begins, where a slide moves."""
    values, force, pushed, strokes = riding.values, riding.force, riding.pushed, riding.strokes
    weights, always, along, count = floor.weights, floor.always, floor.along, floor.places.size
    here, turned = stage * count * ORDERS, inverse.size > 0
    for i in range(n):
        set_lanes(force, i, always, i, lanes)
        for order in range(2):
            add_products(force, i, weights, (2 * i + order) * count, values, here + order, (1, ORDERS), count, lanes)
    for i in range(n):
        if turned:
            for lane in range(len(lanes)):
                poke(pushed, (stage * n + i) * len(lanes) + lane, 0.0)
            add_products(pushed, stage * n + i, inverse, row + i, force, 0, (n, 1), n, lanes)
        else:
            set_lanes(pushed, stage * n + i, force, i, lanes)
    mounts = floor.first.size - 1
    for mount in range(mounts):
        begin, to = floor.first[mount], (stage * mounts + mount) * 2
        size, first = floor.first[mount + 1] - begin, here + begin * ORDERS
        set_lanes(strokes, to, floor.strokes, mount, lanes)
        for lane in range(len(lanes)):
            poke(strokes, (to + 1) * len(lanes) + lane, 0.0)
        for order in range(2):
            add_products(
                strokes, to + order, along, order * count + begin, values, first + order, (1, ORDERS), size, lanes
            )


@kernel
def ride(floor, inverse, times, step, riding, n, lanes):  # type: ignore[no-untyped-def]
    """Move the ground of all lanes through a step of a stretch; the one before has been the last."""
    w, values = len(lanes), riding.values
    size = ORDERS * floor.places.size
    if step == 0:
        put_point(floor, 0, values, lanes)
    to_start(values, size * w)
    to_start(riding.pushed, n * w)
    to_start(riding.strokes, 2 * (floor.first.size - 1) * w)
    put_point(floor, step + 1, values, lanes)
    put_middle(values, size, lanes)
    for stage in range(0 if step == 0 else 1, STAGES):
        act(floor, inverse, (STAGES * step + stage) * n * n if times > 1 else 0, stage, riding, n, lanes)


@kernel
def known(floor, riding, inputs, lanes):  # type: ignore[no-untyped-def]
    """The ground at the start of the step as laws read it: (mount·input·order) with upstream last, which is zero where
    nothing moves."""
    w = len(lanes)
    for j in range(floor.places.size):
        copy_lanes(riding.values, j * ORDERS * w, inputs, floor.places[j] * ORDERS * w, ORDERS * w)
