"""Isolation that begins at a frequency, with preview: which share of the floor's motion upstream the machine follows.

A wave reaches the sensor upstream τ before a mount. Where isolation begins at f₀ (`ehamj.control.lowend`), the machine
follows x = F(s)·x_up, which is N = F(s) e^(sτ) of the floor below the mount: F is causal, N need not be, and with
enough τ it is one below f₀ and zero above without a phase between. Local sensors measure all the rest, as without
preview: what is wrong of τ matters only as far as F passes anything.

F is the sum of Laguerre functions behind a low-pass that is least in

    ∫ ( |1 + c/s|²·|1 − N|² + R·|N|² ) Φ df

for a floor Φ that is flat over third octaves: the first is the voltage that W = 1 − N takes, R weighs from f₀ on what
remains, the more the farther above f₀, where local sensors leave less.
"""

from collections.abc import Sequence
from functools import cache
from typing import Final, NamedTuple

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.control.blocks import TWO_PI, Block, joined
from ehamj.control.channels import UPSTREAM, axis_of
from ehamj.control.inverse import creep
from ehamj.control.upstream import Upstream
from ehamj.errors import InputError
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant

ORDER: Final = 16
"""Laguerre functions: they carry half a second of preview at 5 Hz."""
MOST_PERIODS: Final = 4.0
"""Of f₀: the functions delay no longer."""
POLES: Final = (0.4, 0.6, 0.9, 1.3)
"""Their pole over f₀: that is taken which is best."""
ABOVE: Final = 4.0
"""Corner of the low-pass behind which they lie, over f₀."""
REST: Final = 10.0 ** (-29.0 / 20.0)
"""Share of the floor that is aimed to be left at most in the third octave at f₀."""
WEIGHTS: Final = np.geomspace(300.0, 5_000.0, 8)
"""R at f₀: the least is taken with which no more is left; more than the last of them is not worth its voltage."""
EDGE: Final = 10.0**-0.05
"""Lower edge of the third octave at f₀, over f₀."""
SLOW: Final = 0.2
"""Corner below which the floor's velocity is taken to fall, as acceleration does from there on, over f₀."""
SPAN: Final = (0.02, 30.0)
"""Frequencies looked at, over f₀."""
POINTS: Final = 400
NOISE: Final = 1e-6
"""Weight of |F|² itself, which keeps shares of functions that cancel each other small."""


class Shape(NamedTuple):
    """Laguerre functions of one pole p behind a low-pass at w [rad/s]."""

    pole: float
    corner: float

    def responses(self, s: ComplexArray) -> ComplexArray:
        """Each function at s = jω, (frequency, function)."""
        p, w = self.pole, self.corner
        first = np.sqrt(2.0 * p) / (s + p) * w**2 / (s**2 + np.sqrt(2.0) * w * s + w**2)
        return np.asarray(first[:, None] * ((s - p) / (s + p))[:, None] ** np.arange(ORDER))

    def block(self, shares: Array) -> Block:
        """Sums of the functions of one input, ``shares`` (sum, function)."""
        p, w = self.pole, self.corner
        A = -2.0 * p * np.tri(ORDER, k=-1) - p * np.eye(ORDER)
        chain = Block(A, np.full((ORDER, 1), np.sqrt(2.0 * p)), shares, np.zeros((len(shares), 1)))
        low = Block.filter([], w * np.exp(1j * np.pi * np.array([0.75, 1.25])), w**2)
        return low.then(chain)


@cache
def _best(times: tuple[float, ...], frequency: float, creep: float) -> tuple[Shape, Array]:
    """The shape that is least for all times [s] together, and the functions' shares for each, (time, function)."""
    f = frequency * np.geomspace(*SPAN, POINTS)
    s = np.asarray(1j * TWO_PI * f, complex)
    floor = 1.0 / np.sqrt(1.0 + (SLOW * frequency / f) ** 4)
    volts, kept = floor * np.abs(1.0 + creep / s), f >= EDGE * frequency
    rest = kept * np.sqrt(f / frequency)
    first = kept & (f < frequency / EDGE)
    shapes = [Shape(TWO_PI * pole * frequency, TWO_PI * ABOVE * frequency) for pole in POLES]
    for weight in WEIGHTS:
        found = []
        for shape in shapes:
            own = shape.responses(s)
            fits = [_shares(own, s, tau, volts, np.sqrt(weight) * rest) for tau in times]
            left = max(float(np.mean(np.abs(own[first] @ shares) ** 2)) for shares, _ in fits)
            found.append((sum(cost for _, cost in fits), left, shape, np.array([shares for shares, _ in fits])))
        _, left, shape, shares = min(found, key=lambda one: one[0])
        if left <= REST**2:
            break
    return shape, shares


def _shares(own: ComplexArray, s: ComplexArray, tau: float, volts: Array, rest: Array) -> tuple[Array, float]:
    """Least squares for one time [s], and what is left. On points even over log f a flat floor weighs all alike."""
    led = np.exp(s * tau)[:, None] * own
    rows = [volts, rest, np.full(len(s), np.sqrt(NOISE))]
    matrix = np.vstack([row[:, None] * led for row in rows])
    wanted = np.concatenate([volts, np.zeros(2 * len(s))])
    matrix = np.vstack([matrix.real, matrix.imag])
    wanted = np.concatenate([wanted, np.zeros(wanted.size)])
    shares = np.asarray(np.linalg.lstsq(matrix, wanted, rcond=1e-10)[0], float)
    return shares, float(np.sum((matrix @ shares - wanted) ** 2))


def followed(plant: Plant, upstream: Upstream, frequency: float, weights: Array) -> tuple[tuple[str, ...], Block]:
    """What the machine follows at its mounts, over the floor upstream: channels there, and the block from them.

    Args:
        plant: the machine on its mounts.
        upstream: the sensor, and the wave that is believed.
        frequency: from which isolation begins [Hz].
        weights: of each mount and axis in each output, (output, mount, axis).
    """
    longest = float(np.max(upstream.times(plant.positions)))
    if longest > MOST_PERIODS / frequency:
        raise InputError(
            f"sensors.upstream.position: the wave takes {longest:.3g} s from there to the mounts, more than is used "
            f"where isolation begins at {frequency:g} Hz, {MOST_PERIODS / frequency:.3g} s; move the sensor nearer"
        )
    times, which = np.unique(upstream.times(plant.positions), return_inverse=True)
    shape, shares = _best(tuple(times.tolist()), frequency, creep(plant))
    read = [axis for axis in range(len(AXES)) if np.any(weights[:, :, axis])]
    chains = [shape.block(weights[:, :, axis] @ shares[which]) for axis in read]
    return tuple(f"ground_velocity {UPSTREAM} {AXES[axis]}" for axis in read), joined(chains)


def less_followed(
    channels: Sequence[str], plant: Plant, upstream: Upstream, frequency: float
) -> tuple[tuple[str, ...], Block]:
    """Ground velocities without what the machine follows: channels upstream, and the block from all to the first."""
    weights = np.zeros((len(channels), len(plant.mounts), len(AXES)))
    for row, name in zip(weights, channels, strict=True):
        _, mount, label = name.split(" ")
        at = plant.mounts.index(mount)
        row[at] = axis_of(label, np.array(plant.directions[at]))
    read, block = followed(plant, upstream, frequency, weights)
    return read, joined([Block.gain(np.eye(len(channels))), block.times(-1.0)])
