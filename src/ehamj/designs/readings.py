"""What a law's instruments see of many machines, and of the ground below them, as arrays for compiled closed forms."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array, ComplexArray
from ehamj.control.channels import channel_row, is_upstream
from ehamj.control.compiled.signals import Layout as Signals
from ehamj.designs.stack import Stack, dofs_of
from ehamj.isolator.equations import State
from ehamj.linear.loop import Loop
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.plant import Plant

MOTIONS = ("displacement", "velocity", "acceleration")


class Readings(NamedTuple):
    """What instruments see of many machines: ``motion`` (design, reading, n) that is ``order`` (reading,) times
    differentiated; shares of spools and pressures, ``states`` (reading, mount, 3), of those ``inside`` (reading,)."""

    motion: Array
    order: NDArray[np.int64]
    states: Array
    inside: NDArray[np.bool_]

    def of(self, chosen: Sequence[int]) -> "Readings":
        """Some of them."""
        own = list(chosen)
        return Readings(np.ascontiguousarray(self.motion[:, own]), self.order[own], self.states[own], self.inside[own])

    def side_by_side(self, size: int) -> tuple[Array, ...]:
        """The same with silent ones behind them, ``size`` in all, motions as (design, n, reading), and orders as
        1 for the one that each has, (3, reading)."""
        more = size - len(self.order)
        motion = np.pad(self.motion, ((0, 0), (0, more), (0, 0))).transpose(0, 2, 1)
        states = np.pad(self.states, ((0, more), (0, 0), (0, 0)))
        order = (np.pad(self.order, (0, more)) == np.arange(len(MOTIONS))[:, None]).astype(float)
        return np.ascontiguousarray(motion), order, states, np.pad(self.inside, (0, more))


class Instruments:
    """The instruments of a law on a plant, whose mounts and centre of gravity may stand elsewhere in a design."""

    def __init__(self, plant: Plant, loop: Loop) -> None:
        self.plant, self.loop = plant, loop
        self.signals = Signals.of(len(plant.mounts))
        # A row over the signals is linear in where its mount, or the centre of gravity, stands.
        names, shares = loop.mixtures()
        found = []
        for place in ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
            machine = plant.machine.model_copy(update={"cg": place})
            moved = replace(plant, machine=machine, positions=(place,) * len(plant.mounts))
            found.append(shares @ np.array([channel_row(name, moved) for name in names]).reshape(len(names), -1))
        self._still, self._along = found[0], np.array(found[1:]) - found[0]

    def readings(self, stack: Stack) -> Readings:
        """What they see of many machines, but for the ground's own motion."""
        mounts, channels = len(self.plant.mounts), self.loop.law.inputs
        designs, n = stack.mass.shape[:2]
        motion, order = np.zeros((designs, len(channels), n)), np.zeros(len(channels), np.int64)
        states, signals = np.zeros((len(channels), mounts, 3)), self.signals
        fields = [State._fields.index(name) for name in ("spool", "pressure_1", "pressure_2")]
        for k, channel in enumerate(channels):
            still, along = self._still[k], self._along[:, k]
            place = self._place_of(channel, stack)
            for power, name in enumerate(MOTIONS):
                own = slice(getattr(signals, name), getattr(signals, name) + len(DOFS))
                if np.any(still[own]) or np.any(along[:, own]):
                    motion[:, k, : len(DOFS)] += dofs_of(still[own] + place @ along[:, own])
                    order[k] = power
            for power, first in enumerate((signals.plate, signals.plate_velocity)):
                shares = still[first : first + mounts]
                if np.any(shares):
                    motion[:, k] += np.einsum("m,dmn->dn", shares, stack.plates)
                    order[k] = power
            every = still[signals.state : signals.state + mounts * len(State._fields)].reshape(mounts, -1)
            states[k] = every[:, fields]
            states[k, :, 0] += still[signals.edges : signals.edges + mounts]
        return Readings(motion, order, states, np.asarray((states != 0.0).any(axis=(1, 2))))

    def _place_of(self, channel: str, stack: Stack) -> Array:
        """Where an instrument stands in each design, (design, 3) [m]."""
        variable, _, label = channel.partition(" ")
        values, mount = stack.elements.values, label.split(" ")[0]
        if variable.startswith("cg_"):
            return _places([values.common[f"cg.{k}"] for k in range(len(AXES))], stack)
        if variable.startswith("foot_") and mount in self.plant.mounts:
            at = self.plant.mounts.index(mount)
            return _places([values.mounts[axis][..., at] for axis in AXES], stack)
        return np.zeros((len(stack.mass), len(AXES)))

    def seen(self, hertz: Array, ground: ComplexArray) -> ComplexArray:
        """The ground's own motion in each reading.

        Args:
            hertz: (f,) [Hz].
            ground: displacement of the ground at each mount along x, y, z, (f or 1, mount, 3, column) [m].

        Returns:
            (f, reading, column). A floor that is given by mounts was upstream what it is at them on average, as much
            earlier as is believed (`ehamj.linear.response`).
        """
        names, shares = self.loop.mixtures()
        s, mounts, signals = 2j * np.pi * hertz[:, None], len(self.plant.mounts), self.signals
        flat = np.broadcast_to(ground, (hertz.size, *ground.shape[1:])).reshape(hertz.size, mounts * len(AXES), -1)
        raw, upstream = np.zeros((hertz.size, len(names), flat.shape[-1]), complex), self.loop.sensors.upstream
        for k, name in enumerate(names):
            row = channel_row(name, self.plant)
            for power, first in enumerate((signals.ground, signals.ground_velocity, signals.ground_acceleration)):
                own = row[first : first + flat.shape[1]]
                if np.any(own):
                    raw[:, k] += s**power * np.einsum("g,fgc->fc", own, flat)
            if is_upstream(name) and upstream is not None:
                led = np.exp(s * upstream.times(self.plant.positions)) / mounts
                variable, _, label = name.split(" ")
                power = MOTIONS.index(variable.removeprefix("ground_"))
                along = flat.reshape(hertz.size, mounts, len(AXES), -1)[:, :, AXES.index(label)]
                raw[:, k] += s**power * np.einsum("fm,fmc->fc", led, along)
        return np.ascontiguousarray(shares @ raw)


def _places(coordinates: Sequence[Array], stack: Stack) -> Array:
    return np.stack([np.broadcast_to(one, len(stack.mass)) for one in coordinates], axis=-1)
