"""A held digital law around many machines at once: margins, stability, and what a floor makes of the closed loops.

The definitions are those of `ehamj.linear.margins.report` and `ehamj.linear.response.ground_response`; what differs:
frequencies beside those of the law are taken from a raster of `RASTER` (a law's response is known there once for all
designs), and images of the machine around the sampling rate are left out of responses too (`ehamj.linear.loop`).
Stability follows from the turns of det(1 + L) over that of the nominal loop, whose eigenvalues are known (Nyquist);
where that is not plain, ``doubtful`` says so, and eigenvalues must decide.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array, ComplexArray
from ehamj.control import LinearController
from ehamj.designs.compiled.seen import SIDE
from ehamj.designs.designs import Designs
from ehamj.designs.readings import Instruments
from ehamj.designs.responses import arrays, compiled_answers
from ehamj.designs.stack import Stack
from ehamj.linear.loop import Loop, own_readings
from ehamj.linear.margins import ENDS, grid
from ehamj.plant.axes import AXES
from ehamj.plant.layout import Layout
from ehamj.plant.mounts import UPRIGHT
from ehamj.scenario.model import Scenario

RASTER: Final = 2e-3
"""Relative distance of frequencies that are taken about poles."""
FIRST: Final = 0.02
"""Lowest of them [Hz], as of `ehamj.linear.margins.grid`."""
WIDTHS: Final = np.linspace(-4.0, 4.0, 17)
"""Frequencies about a pole, in its half-widths, as there."""
PLAIN: Final = 1.5
"""Turn of the determinant from one frequency to the next up to which its way is plain [rad]."""
SURE: Final = 0.2
"""Distance of its turns from a whole number up to which they are plain."""
CLOSE: Final = 0.02
"""Disk margin of all valves at once below which eigenvalues decide on stability."""
KEPT: Final = 512
"""Layouts of mounts whose patterns are kept."""


@dataclass(frozen=True)
class Margins:
    """Margins of many loops, per place where they can be broken (`HeldLoop.places`) the gain [dB], the phase [deg] and
    the disk margin, (design, place, 3): infinite where a gain never crosses. ``disk`` (design,) is that of all valves
    at once, ``grown`` how many more poles grow than of the nominal loop, and ``doubtful`` where that is not plain."""

    places: Array
    disk: Array
    grown: NDArray[np.int64]
    doubtful: NDArray[np.bool_]

    @property
    def worst(self) -> Array:
        """Least gain [dB], phase [deg] and disk margin of each design, (design, 3)."""
        least = self.places.min(axis=1)
        least[:, 2] = np.minimum(least[:, 2], self.disk)
        return np.asarray(least)


class HeldLoop:
    """A law that is held around machines that differ from a scenario's; its machine must have closed forms
    (`ehamj.designs.designs.Designs`), and the law must measure something of it for margins."""

    def __init__(self, scenario: Scenario, law: LinearController) -> None:
        self.scenario, self.plant, self.loop = scenario, scenario.plant, Loop.of(scenario, law)
        self.own, self.active = own_readings(law), np.flatnonzero(self.plant.layout.active)
        self.instruments = Instruments(self.plant, self.loop)
        self._patterns: dict[bytes, Array] = {}
        self._last: tuple[Array, ComplexArray] | None = None
        wide = any(line.low < line.high for line in law.lines)
        self.laws = (law, *((law.turned(end) for end in ENDS) if wide else ()))

    @cached_property
    def places(self) -> tuple[str, ...]:
        """Where loops can be broken: at each valve, each pattern of the valves, each reading of the machine."""
        valves = (f"valve {name}" for name in self.plant.obeying.mounts)
        readings = (f"reading {self.loop.law.inputs[k]}" for k in self.own)
        return (*valves, *self.plant.central.patterns, *readings)

    # --- the law over frequency -----------------------------------------------------------------------------------

    @cached_property
    def base(self) -> Array:
        """Frequencies at which every loop is looked at [Hz]."""
        return np.unique(np.concatenate([grid(law) for law in self.laws]))

    @cached_property
    def hertz(self) -> Array:
        """All at which the laws are known: those, and the raster [Hz]."""
        half = 0.5 / max(part.period for part in self.loop.law.parts)
        raster = FIRST * np.exp(RASTER * np.arange(1, int(np.log(half / FIRST) / RASTER)))
        return np.unique(np.concatenate([self.base, raster[raster < half]]))

    @cached_property
    def _answers(self) -> tuple[Array, ...]:
        """Of each law at `hertz`, over its readings of the machine: real and imaginary parts (2, f, mount, reading),
        filled up to a multiple of `SIDE`."""
        silent = -len(self.own) % SIDE
        found = []
        for law in self.laws:
            own = np.pad(self._response(law, self.hertz)[:, :, self.own], ((0, 0), (0, 0), (0, silent)))
            found.append(np.array([own.real, own.imag]))
        return tuple(found)

    def _response(self, law: LinearController, hertz: Array) -> ComplexArray:
        """Commands over what the readings are of, instruments, delay and hold included, (f, mount, reading)."""
        read = self.loop.sensors.response(law.inputs, hertz)
        return np.ascontiguousarray(law.response(hertz) * read[:, None, :])

    def _law_at(self, hertz: Array) -> ComplexArray:
        """The first law's `_response`, kept: blocks of designs ask for the same frequencies."""
        if self._last is None or not np.array_equal(self._last[0], hertz):
            self._last = (hertz, self._response(self.loop.law, hertz))
        return self._last[1]

    # --- margins --------------------------------------------------------------------------------------------------

    @cached_property
    def _nominal(self) -> tuple[ComplexArray, ...]:
        """Determinants of the nominal loop over `hertz` by law."""
        stack = Stack.of(Designs.of(self.scenario, {}).values)
        everywhere = np.arange(self.hertz.size)[None]
        found = []
        for law in self._answers:
            nominal = np.zeros(self.hertz.size, complex)
            self._measured(stack, law, everywhere, np.array([self.hertz.size]), nominal)
            found.append(nominal)
        return tuple(found)

    def _measured(
        self,
        stack: Stack,
        law: Array,
        picks: NDArray[np.int64],
        counts: NDArray[np.int64],
        nominal: ComplexArray,
    ) -> tuple[Array, Array, Array]:
        own, mounts = len(picks), self.active.size
        places, turns = np.empty((own, len(self.places), 4)), np.empty((own, 2))
        centred, largest = np.empty((*picks.shape, mounts, mounts), complex), np.empty(own)
        readings = self.instruments.readings(stack).of(self.own)
        seen = readings.side_by_side(law.shape[-1])
        measure, bound = compiled_margins()
        measure(
            arrays(stack), self.hertz, law, seen, (picks, counts), self.active, self._pattern_bases(stack), nominal,
            (places, turns, centred),
        )  # fmt: skip
        bound(centred, counts, largest)
        return places, turns, largest

    def margins(self, stack: Stack, poles: ComplexArray, count: int | None = None) -> Margins:
        """Margins of each design.

        Args:
            stack: designs.
            poles: of each passive machine without its valves (design, pole) [1/s], about which loops are looked at
                closely; NaN where there is no rest.
            count: of the designs so many first ones are looked at; all without.
        """
        picks, counts = (part[:count] for part in self._picks(stack, poles))
        found = []
        for law, nominal in zip(self._answers, self._nominal, strict=True):
            places, turned, largest = self._measured(stack, law, picks, counts, nominal)
            turns = -turned[:, 0] / np.pi
            grown = np.rint(turns).astype(np.int64)
            disk = 1.0 / np.maximum(largest, 0.5)
            doubtful = (turned[:, 1] > PLAIN) | (np.abs(turns - grown) > SURE) | (disk < CLOSE)
            levels = np.empty((*places.shape[:2], 3))
            levels[..., 0] = 20.0 / np.log(10.0) * places[..., 0]
            levels[..., 1] = np.degrees(places[..., 1])
            levels[..., 2] = 1.0 / np.maximum(np.sqrt(places[..., 2]), 0.5)
            found.append(Margins(levels, disk, grown, doubtful))
        worst = Margins(
            np.min([one.places for one in found], axis=0), np.min([one.disk for one in found], axis=0),
            found[0].grown, found[0].doubtful,
        )  # fmt: skip
        empty = stack.empty[:count]
        worst.places[empty], worst.disk[empty] = np.nan, np.nan
        return worst

    def _picks(self, stack: Stack, poles: ComplexArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Numbers of each design's frequencies, rising, and how many they are."""
        frequency, damping = stack.oil[..., 9], stack.oil[..., 10]
        swing = np.sqrt(np.maximum(1.0 - damping**2, 0.0))
        valves = -damping * frequency + 1j * frequency * swing
        every = np.concatenate([poles, np.where(swing > 0.0, valves, np.nan)], axis=1)
        every = np.where(every.imag > 0.0, every, np.nan)
        centre, width = np.abs(every) / (2 * np.pi), np.abs(every.real) / (2 * np.pi)
        near = centre[..., None] + width[..., None] * WIDTHS
        at = np.searchsorted(self.hertz, np.nan_to_num(near, nan=0.0))
        at = np.minimum(at, self.hertz.size - 1).reshape(len(every), -1)
        taken = np.zeros((len(every), self.hertz.size), bool)
        np.put_along_axis(taken, at, True, axis=1)
        taken[:, np.searchsorted(self.hertz, self.base)] = True
        counts = taken.sum(axis=1)
        picks = np.zeros((len(every), counts.max()), np.int64)
        for design, own in enumerate(taken):
            picks[design, : counts[design]] = np.flatnonzero(own)
        return picks, counts

    def _pattern_bases(self, stack: Stack) -> Array:
        """Strokes of the valves per pattern and the inverse, (2, design, mount, mount)."""
        values, directions = stack.elements.values, np.array(self.plant.directions)[self.active]
        places = np.stack([values.mounts[axis][..., self.active] for axis in AXES], axis=-1)
        upright = bool((directions[:, 2] > 1.0 - UPRIGHT).all())  # whose patterns do not depend on heights
        heights = np.broadcast_to(0.0 if upright else values.common["cg.2"], len(stack.mass))
        places = np.broadcast_to(places, (len(stack.mass), *places.shape[-2:]))
        found = []
        for own, height in zip(places, heights, strict=True):
            key = own.tobytes() + height.tobytes()
            if key not in self._patterns:
                if len(self._patterns) >= KEPT:
                    self._patterns.clear()
                layout = Layout(own, directions, (True,) * self.active.size).raised(float(height))
                self._patterns[key] = np.array([layout.pattern_basis, np.linalg.inv(layout.pattern_basis)])
            found.append(self._patterns[key])
        return np.ascontiguousarray(np.stack(found, axis=1))

    # --- a floor --------------------------------------------------------------------------------------------------

    def floor(
        self, stack: Stack, hertz: Array, ground: ComplexArray, count: int | None = None
    ) -> tuple[ComplexArray, ComplexArray]:
        """What a floor makes of the centre of gravity and of the commands as they act.

        Args:
            stack: designs.
            hertz: frequencies (f,) [Hz].
            ground: displacement of the ground at each mount along x, y, z, (f or 1, mount, 3, column) [m].
            count: as `margins`.

        Returns:
            Displacement along x, y, z (design, f, 3, column) [m], commands (design, f, mount, column) [V]; NaN of
            designs without a rest in their cylinders.
        """
        designs, mounts, columns = len(stack.mass[:count]), len(self.plant.mounts), ground.shape[-1]
        frames = np.einsum("mkx,fmxc->fmkc", stack.frames, ground)
        frames = np.array(np.broadcast_to(frames, (hertz.size, *frames.shape[1:])))
        found = np.empty((designs, hertz.size, len(AXES), columns), complex)
        commands = np.empty((designs, hertz.size, mounts, columns), complex)
        compiled_answers()(
            arrays(stack), np.array(np.broadcast_to(hertz, (designs, hertz.size))),
            self._law_at(hertz), np.arange(hertz.size), tuple(self.instruments.readings(stack)),
            frames, self.instruments.seen(hertz, ground), found, commands,
        )  # fmt: skip
        found[stack.empty[:count]], commands[stack.empty[:count]] = np.nan, np.nan
        return found, commands


@cache
def compiled_margins() -> Any:
    """`ehamj.designs.compiled.loops.loop_margins` and `ehamj.designs.compiled.structured.largest_mus`, compiled or
    taken from where that is kept."""
    from ehamj.compiled.kept import compiled
    from ehamj.designs.compiled.loops import loop_margins
    from ehamj.designs.compiled.structured import largest_mus

    return compiled(loop_margins), compiled(largest_mus)
