"""Random floors as sums of lines of exact power: synthesis, phases that spread evenly over time, coherence.

The floor repeats after the run (or after a whole number of runs that lasts `LEAST_PERIOD`), so that the run holds each
line a whole number of times and its periodogram is the target itself, without leakage and without the scatter of
random amplitudes. With freely drawn phases a windowed reading of N lines would still scatter by 1/√N (0.9 dB in the
1 Hz band of a minute), because a window weighs times unequally and the energy of a band clusters in time. So the steps
of phase from line to line, which are the times at which the energy arrives, are evenly spaced over the period within
each third octave and only their order is drawn.
"""

from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property
from math import ceil

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from ehamj.ground.motion import GroundSettings, Motion, Start
from ehamj.ground.spectra import Axis, Spectrum
from ehamj.ground.waves import Coherence, Wave, spread
from ehamj.plant.axes import AXES
from ehamj.series import Lines, check_lines, parts, room
from ehamj.settings import Fade
from ehamj.signals import Array, Product, Signal

LEAST_PERIOD = 10.0
"""Shortest period of a floor [s]: shorter runs are a part of it, so that low bands still hold lines."""

FEW = 64
"""Lines in a band below which the order of their phases is chosen among several."""

DRAWS = 32
"""How many orders are drawn then."""


def period(duration: float) -> float:
    """Time after which the floor of a run repeats [s]: a whole number of runs, at least `LEAST_PERIOD`."""
    return duration * ceil(LEAST_PERIOD / duration)


def even_phases(sizes: Sequence[int], random: np.random.Generator) -> Iterator[Array]:
    """Phases of lines [rad], whose steps within each of successive bands of ``sizes`` spread evenly over the circle.

    Only the order of the steps, and one common turn per band, are drawn. Lines two apart beat too: where a band has few
    lines, that order of several is taken in which these beats, weighed by a Hann window, cancel best. They come in
    parts of at most `PART`.
    """
    phase, last = 0.0, np.empty(0)
    for size in sizes:
        drawn = [_order(size, random) for _ in range(DRAWS if size < FEW else 1)]
        order, turn = drawn[0]
        if len(drawn) > 1:
            order, turn = min(drawn, key=lambda own: _beats(np.concatenate([last, _steps(own[0], own[1], size)])))
        for part in parts(0, size):
            steps = _steps(order[part], turn, size)
            phases = np.cumsum(np.concatenate([[phase], steps]))[1:]
            phase, last = phases[-1], steps[-1:]
            yield phases


def _order(size: int, random: np.random.Generator) -> tuple[NDArray[np.int32], float]:
    """Order of a band's steps, and its turn: all that is held at once of as many lines as a band has."""
    order = np.arange(size, dtype=np.int32)
    random.shuffle(order)
    return order, random.uniform()


def _steps(order: NDArray[np.int32], turn: float, size: int) -> Array:
    return 2.0 * np.pi * (order + turn) / size


def _beats(steps: Array) -> float:
    return float(np.abs(np.cos(steps[1:] + steps[:-1]).sum()))


@dataclass(frozen=True)
class _Comb:
    """Lines at multiples of 1/``length`` that hold the power of a spectrum: each of what is ± half a resolution away.

    There are as many as the floor is long: what is asked of them is asked of some at a time.
    """

    spectrum: Spectrum
    length: float
    """Time after which the floor repeats [s]."""

    @property
    def count(self) -> int:
        """Number of the highest."""
        return int(np.floor(self.spectrum.high * self.length + 0.5))

    @cached_property
    def sizes(self) -> dict[int, int]:
        """How many of those that hold power lie in each third octave, by its number."""
        found: Counter[int] = Counter()
        for part in parts(1, self.count + 1):
            numbers = np.arange(part.start, part.stop)
            found.update(self.bands(numbers[self._share(numbers) > 0]).tolist())
        return dict(found)

    @property
    def lowest(self) -> int:
        """Number of the lowest third octave that holds some."""
        return min(self.sizes)

    @cached_property
    def first(self) -> int:
        """Number of the lowest that holds power."""
        return next(
            part.start + int(np.argmax(share))
            for part in parts(1, self.count + 1)
            if (share := self._share(np.arange(part.start, part.stop)) > 0).any()
        )

    def bands(self, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        """Third octaves in which lines lie."""
        return np.rint(10.0 * np.log10(numbers / self.length / 1000.0)).astype(np.int64)

    def speed(self, numbers: NDArray[np.int64]) -> Array:
        """Peak velocity of lines [m/s]."""
        frequency = np.clip(numbers / self.length, self.spectrum.low, self.spectrum.high)
        return np.sqrt(2.0 * self.spectrum.density(frequency) * self._share(numbers) / self.length)

    def _share(self, numbers: NDArray[np.int64]) -> Array:
        """How much of a line's resolution lies within the spectrum."""
        frequency, half = numbers / self.length, 0.5 / self.length
        low, high = self.spectrum.low, self.spectrum.high
        inside = np.minimum(high, frequency + half) - np.maximum(low, frequency - half)
        return np.clip(inside * self.length, 0.0, 1.0)

    def drawn(self, sets: int, random: np.random.Generator) -> "Iterator[tuple[NDArray[np.int64], Array]]":
        """Numbers of some lines, one after the other, and phases of as many ``sets`` of them, (set, n) [rad]."""
        sizes, begun = list(self.sizes.values()), []
        for number in range(sets):
            begun.append(deepcopy(random))
            if number + 1 < sets:  # one set is drawn after the other
                deque(even_phases(sizes, random), maxlen=0)
        first = self.first
        for phases in zip(*(even_phases(sizes, own) for own in begun), strict=True):
            yield np.arange(first, first + phases[0].size), np.array(phases)
            first += phases[0].size


def random_lines(spectrum: Spectrum, start: Start, axis: str, coherence: Coherence | None = None) -> tuple[Lines, ...]:
    """Displacement [m] of a random floor of this spectrum: one signal, or one per mount where there is a coherence.

    A line at f holds the power of the PSD between f ± half a resolution. Mounts that are partly coherent mix as many
    independent sets of lines; each mount's lines are then scaled per third octave to the power that the target has.
    """
    comb = _Comb(spectrum, period(start.duration))
    what = f"a random floor up to {spectrum.high:g} Hz over duration = {start.duration:g} s"
    check_lines(spectrum.high * comb.length, what)
    if not comb.sizes:
        raise ValueError(
            f"ground: no line of a floor that lasts {comb.length:g} s lies from {spectrum.low:g} to "
            f"{spectrum.high:g} Hz; make the duration longer or the spectrum wider"
        )
    random = np.random.default_rng([start.seed, AXES.index(axis), *start.part])
    sets = 1 if coherence is None else len(start.positions)
    lines = [room(comb.count + 1) for _ in range(sets)]
    wanted = np.zeros(1 + max(comb.sizes) - comb.lowest)
    found = np.zeros((sets, wanted.size))
    for numbers, phases in comb.drawn(sets, random):
        speed, mixed, here = comb.speed(numbers), np.exp(1j * phases), slice(numbers[0], numbers[-1] + 1)
        if coherence is not None:
            factor = coherence.factor(numbers / comb.length, start.positions)
            mixed = np.einsum("fmk,kf->mf", factor, mixed[::-1])
            bands = comb.bands(numbers) - comb.lowest
            np.add.at(wanted, bands, speed**2)
            for own, unit in zip(found, mixed, strict=True):
                np.add.at(own, bands, speed**2 * np.abs(unit) ** 2)
        for line, unit in zip(lines, mixed, strict=True):
            line[here] = speed * unit
    correction = np.sqrt(wanted / np.maximum(found, 1e-300))  # brings each band of each mount to its power
    for part in parts(comb.first, comb.count + 1):
        numbers = np.arange(part.start, part.stop)
        for line, own in zip(lines, correction, strict=True):
            velocity = line[part]
            if coherence is not None:
                velocity = velocity * own[comb.bands(numbers) - comb.lowest]
            line[part] = velocity / (2j * np.pi * (numbers / comb.length))
    return tuple(Lines(comb.length, own) for own in lines)


class RandomGround(GroundSettings):
    """What random floors have: axes that move independently of each other, and how they pass below the machine."""

    axes: tuple[Axis, ...] = Field(("z",), description="axes that move", min_length=1)
    wave: Wave | None = Field(None, description="pass below the machine as a plane wave; without: everywhere at once")
    coherence: Coherence | None = Field(
        None, description="partial coherence between the mounts; without: they move alike but for the wave's delay"
    )
    fade_in: Fade = Field(0.5, description="time over which the motion fades in [s]")

    def random_floor(
        self,
        start: Start,
        spectra: Mapping[Axis, Spectrum],
        envelope: Signal | None = None,
        notes: tuple[str, ...] = (),
        usable_to: float = float("inf"),
    ) -> Motion:
        """Motion of a floor of these spectra per axis.

        Args:
            start: mounts, duration and seed.
            spectra: of the axes that move.
            envelope: factor on the motion over time, which travels with it.
            notes: see `Motion`.
            usable_to: see `Motion` [Hz].
        """
        signals: dict[str, Signal | tuple[Signal, ...]] = {}
        for axis, spectrum in spectra.items():
            lines = random_lines(spectrum, start, axis, self.coherence)
            own: tuple[Signal, ...] = lines if envelope is None else tuple(Product(line, envelope) for line in lines)
            signals[axis] = own[0] if self.coherence is None else own
        if self.coherence is not None:
            mounts = start.positions[: len(start.mounts)]
            notes = (*notes, _stated(self.coherence, mounts))
        return spread(start, signals, self.wave, self.fade_in, notes=notes, usable_to=usable_to)


def _stated(coherence: Coherence, positions: Array) -> str:
    farthest = np.linalg.norm(positions[:, None] - positions, axis=2).max()
    at = ", ".join(f"{float(coherence.magnitude(np.array(f), farthest)):.2f} at {f} Hz" for f in (10, 50, 80))
    return (
        f"mounts move with Luco-Wong coherency (γ = {coherence.gamma:g}, V_s = {coherence.shear_speed:g} m/s): "
        f"between the two farthest apart, {farthest:.3g} m, it is {at}"
    )
