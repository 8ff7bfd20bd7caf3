"""Random floors as sums of lines of exact power: synthesis, phases that spread evenly over time, coherence.

The floor repeats after the run (or after a whole number of runs that lasts `LEAST_PERIOD`), so that the run holds each
line a whole number of times and its periodogram is the target itself, without leakage and without the scatter of
random amplitudes. With freely drawn phases a windowed reading of N lines would still scatter by 1/√N (0.9 dB in the
1 Hz band of a minute), because a window weighs times unequally and the energy of a band clusters in time. So the steps
of phase from line to line, which are the times at which the energy arrives, are evenly spaced over the period within
each third octave and only their order is drawn.
"""

from collections.abc import Mapping
from math import ceil

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from ehamj.ground.motion import GroundSettings, Motion, Start
from ehamj.ground.spectra import Axis, Spectrum
from ehamj.ground.waves import Coherence, Wave, spread
from ehamj.plant.axes import AXES
from ehamj.signals import Array, Lines, Product, Signal

LEAST_PERIOD = 10.0
"""Shortest period of a floor [s]: shorter runs are a part of it, so that low bands still hold lines."""

FEW = 64
"""Lines in a band below which the order of their phases is chosen among several."""

DRAWS = 32
"""How many orders are drawn then."""


def period(duration: float) -> float:
    """Time after which the floor of a run repeats [s]: a whole number of runs, at least `LEAST_PERIOD`."""
    return duration * ceil(LEAST_PERIOD / duration)


def even_phases(bands: NDArray[np.int64], random: np.random.Generator) -> Array:
    """Phases of lines [rad], shape (n,), whose steps within each run of equal ``bands`` spread evenly over the circle.

    Only the order of the steps, and one common turn per band, are drawn. Lines two apart beat too: where a band has few
    lines, that order of several is taken in which these beats, weighed by a Hann window, cancel best.
    """
    steps = np.empty(bands.size)
    starts = np.flatnonzero(np.diff(bands, prepend=bands[:1] - 1))
    for begin, end in zip(starts, [*starts[1:], bands.size], strict=True):
        size = end - begin
        drawn = [
            2.0 * np.pi * (random.permutation(size) + random.uniform()) / size
            for _ in range(DRAWS if size < FEW else 1)
        ]
        before = steps[max(begin - 1, 0) : begin]
        steps[begin:end] = min(drawn, key=lambda own: _beats(np.concatenate([before, own])))
    return np.cumsum(steps)


def _beats(steps: Array) -> float:
    return float(np.abs(np.cos(steps[1:] + steps[:-1]).sum()))


def random_lines(spectrum: Spectrum, start: Start, axis: str, coherence: Coherence | None = None) -> tuple[Lines, ...]:
    """Displacement [m] of a random floor of this spectrum: one signal, or one per mount where there is a coherence.

    A line at f holds the power of the PSD between f ± half a resolution. Mounts that are partly coherent mix as many
    independent sets of lines; each mount's lines are then scaled per third octave to the power that the target has.
    """
    length = period(start.duration)
    count = int(np.floor(spectrum.high * length + 0.5))
    frequency: Array = np.arange(1, count + 1) / length
    inside = np.minimum(spectrum.high, frequency + 0.5 / length) - np.maximum(spectrum.low, frequency - 0.5 / length)
    share = np.clip(inside * length, 0.0, 1.0)
    used = share > 0
    frequency, share = frequency[used], share[used]
    if not frequency.size:
        raise ValueError(
            f"ground: no line of a floor that lasts {length:g} s lies from {spectrum.low:g} to {spectrum.high:g} Hz; "
            "make the duration longer or the spectrum wider"
        )
    density = spectrum.density(np.clip(frequency, spectrum.low, spectrum.high))
    speed = np.sqrt(2.0 * density * share / length)  # peak velocity of each line
    bands = np.rint(10.0 * np.log10(frequency / 1000.0)).astype(np.int64)
    random = np.random.default_rng([start.seed, AXES.index(axis), *start.part])

    sets = 1 if coherence is None else len(start.positions)
    unit = np.exp(1j * np.array([even_phases(bands, random) for _ in range(sets)]))
    velocity = speed * unit
    if coherence is not None:
        factor = coherence.factor(frequency, start.positions)
        mixed = np.einsum("fmk,kf->mf", factor, unit[::-1])
        velocity = speed * mixed * _correction(speed**2, np.abs(mixed) ** 2, bands - bands[0])
    lines = np.zeros((sets, count + 1), complex)
    lines[:, 1:][:, used] = velocity / (2j * np.pi * frequency)
    return tuple(Lines(length, own) for own in lines)


def _correction(wanted: Array, mixed: Array, bands: NDArray[np.int64]) -> Array:
    """Factor on each mount's lines, shape (mount, n), that brings each band to its power."""
    total = np.bincount(bands, wanted)
    found = np.array([np.bincount(bands, wanted * own) for own in mixed])
    return np.sqrt(total / np.maximum(found, 1e-300))[:, bands]


class RandomGround(GroundSettings):
    """What random floors have: axes that move independently of each other, and how they pass below the machine."""

    axes: tuple[Axis, ...] = Field(("z",), description="axes that move", min_length=1)
    wave: Wave | None = Field(None, description="pass below the machine as a plane wave; without: everywhere at once")
    coherence: Coherence | None = Field(
        None, description="partial coherence between the mounts; without: they move alike but for the wave's delay"
    )
    fade_in: float = Field(0.5, ge=0, description="time over which the motion fades in [s]")

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
            notes = (*notes, _stated(self.coherence, start.positions))
        return spread(start, signals, self.wave, self.fade_in, notes=notes, usable_to=usable_to)


def _stated(coherence: Coherence, positions: Array) -> str:
    farthest = np.linalg.norm(positions[:, None] - positions, axis=2).max()
    at = ", ".join(f"{float(coherence.magnitude(np.array(f), farthest)):.2f} at {f} Hz" for f in (10, 50, 80))
    return (
        f"mounts move with Luco-Wong coherency (γ = {coherence.gamma:g}, V_s = {coherence.shear_speed:g} m/s): "
        f"between the two farthest apart, {farthest:.3g} m, it is {at}"
    )
