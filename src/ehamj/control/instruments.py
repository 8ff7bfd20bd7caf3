"""Instruments between the machine and the controller: pass band, noise, range, resolution, drift, alignment.

What a controller measures is

    round(clip(G(s)·(channel along the sensor's own axis) + noise + drift))

with G a Butterworth high-pass at ``low`` and low-pass at ``high``, each of ``order``. The noise has the one-sided
amplitude density n(f) = noise·√(1 + (noise_corner/f)²), which bends over to flat below ``low`` and falls with the
low-pass, through which it leaves the instrument (at the sampling rate, by the bilinear transform, so that it falls to
nothing at half of it; a corner that the rate does not carry lets all of it pass). Between integration steps the input
is taken as the cubic through its last four values, so that the filter is right to fourth order, as the integrator is:
its response is off by 19/720·(2πfh)⁴, that of the quadrature of Adams and Moulton.
"""

import math
import zlib
from dataclasses import dataclass, field
from functools import cache, lru_cache
from typing import Any, ClassVar, Final, Literal, NamedTuple, Self

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from ehamj.arrays import Array
from ehamj.control.blocks import Block
from ehamj.control.channels import STATIC
from ehamj.settings import PROVENANCE, Parameters, Unlimited, quantity

ALIGNMENT, NOISE = 1, 2
"""Streams of random numbers of a channel."""


def randomness(seed: int, channel: str, stream: int) -> "np.random.Generator":
    """Random numbers of a channel, whatever other channels there are."""
    return np.random.default_rng([seed, zlib.crc32(channel.encode()), stream])


def _values(unit: str, noise: float, low: float, high: float) -> dict[str, tuple[Any, Any]]:
    """Type and field of each value that an instrument has, in its ``unit`` and with its defaults."""
    made: dict[str, tuple[Any, Any]] = {
        "low": (float, quantity(low, "Hz", "f_l", "corner of the high-pass (0: none)", "assumed", ge=0)),
        "high": (Unlimited, quantity(high, "Hz", "f_h", "corner of the low-pass (inf: none)", "assumed", gt=0)),
    }
    for name, default, over, symbol, text in (
        ("noise", noise, "/√Hz", "n", "noise density above its corner, one-sided"),
        ("resolution", 0.0, "", "Δ", "the reading is a multiple of this (0: exact)"),
        ("drift", 0.0, "/s", "d", "steady drift of the reading, its sign by chance"),
        ("random_walk", 0.0, "/√s", "w", "spread of a random walk of the reading after 1 s"),
    ):
        made[name] = (float, quantity(default, unit + over, symbol, text, "assumed", ge=0))
    text = "the reading is limited to ± this (inf: not)"
    return made | {"range": (Unlimited, quantity(math.inf, unit, "R", text, "assumed", gt=0))}


@cache
def _butterworth(order: int, kind: str) -> tuple[Array, Array, Array, Array]:
    """State space of an analog filter with its corner at 1 rad/s; a loop with 24 instruments asks 24 times."""
    return tuple(scipy.signal.tf2ss(*scipy.signal.butter(order, 1.0, kind, analog=True)))


class Instrument(Parameters):
    """What every instrument has; a kind states its unit and defaults where its class is named."""

    measures: ClassVar[str]
    """Quantity that the instrument measures: displacement, velocity, acceleration, pressure or position."""

    low: float
    high: Unlimited
    order: int = Field(2, ge=1, le=4, description="order of each Butterworth filter")
    noise: float
    noise_corner: float = quantity(1.0, "Hz", "f_n", "frequency below which the noise rises as 1/f", "assumed", ge=0)
    range: float
    resolution: float
    drift: float
    random_walk: float

    def __init_subclass__(cls, unit: str = "", noise: float = 0.0, low: float = 0.0, high: float = math.inf) -> None:
        super().__init_subclass__()
        for name, (kind, own) in (_values(unit, noise, low, high) if unit else {}).items():
            cls.__annotations__[name] = kind
            setattr(cls, name, own)

    @model_validator(mode="after")
    def _band(self) -> Self:
        if self.low >= self.high:
            raise ValueError(f"low = {self.low:g} Hz must be below high = {self.high:g} Hz")
        if self.resolution > self.range:
            raise ValueError(f"resolution = {self.resolution:g} must not be larger than range = {self.range:g}")
        return self

    @property
    def tilt(self) -> float:
        """Angle between the sensor's axis and the channel's [rad]."""
        return 0.0

    @property
    def filters(self) -> tuple[tuple[str, float], ...]:
        """Kind and corner [Hz] of each filter that there is."""
        found = [("highpass", self.low)] if self.low > 0.0 else []
        return (*found, *([("lowpass", self.high)] if math.isfinite(self.high) else []))

    def response(self, hertz: ArrayLike) -> NDArray[np.complex128]:
        """G(j2πf) at ``hertz`` [Hz], of the same shape."""
        f = np.asarray(hertz, float)
        total = np.ones(f.shape, complex)
        for kind, corner in self.filters:
            b, a = scipy.signal.butter(self.order, 2 * np.pi * corner, kind, analog=True)
            s = 2j * np.pi * f
            total *= np.polyval(b, s) / np.polyval(a, s)
        return total

    def noise_density(self, hertz: ArrayLike) -> Array:
        """One-sided amplitude density of the noise at ``hertz`` > 0 [unit/√Hz]."""
        f = np.asarray(hertz, float)
        passed = 1.0 / np.sqrt(1.0 + (f / self.high) ** (2 * self.order))
        return np.asarray(self.noise * passed * np.sqrt(1.0 + self.noise_corner**2 / (f**2 + self.low**2)))

    def block(self) -> Block:
        """G(s), high-pass before low-pass, states of the size of the signal."""
        total = Block.gain([[1.0]])
        for kind, corner in self.filters:
            omega = 2 * np.pi * corner
            # In units of the corner the coefficients are of size one.
            A, B, C, D = _butterworth(self.order, kind)
            total = total.then(Block(omega * A, omega * B, C, D))
        return total


class Aligned(Instrument):
    """An instrument with an axis."""

    misalignment: float = quantity(
        0.0, "deg", "α", "angle between the sensor's axis and the channel's, its direction by chance", "assumed", ge=0,
        le=45,
    )  # fmt: skip

    @property
    def tilt(self) -> float:
        return math.radians(self.misalignment)


class Geophone(Aligned, unit="m/s", noise=3e-9, low=0.1, high=1000.0):
    """Measures velocity. Defaults are an instrument good enough for 56 dB on a VC-C floor."""

    measures: ClassVar[str] = "velocity"
    kind: Literal["geophone"]


class Accelerometer(Aligned, unit="m/s²", noise=9.8e-6, low=0.1, high=1000.0):
    """Measures acceleration. The default noise is that of a seismic accelerometer, 1 µg/√Hz."""

    measures: ClassVar[str] = "acceleration"
    kind: Literal["accelerometer"]


class DisplacementSensor(Aligned, unit="m", noise=1e-10, high=5000.0):
    """Measures displacement, against a reference that stands still."""

    measures: ClassVar[str] = "displacement"
    kind: Literal["displacement"]


class StrokeSensor(Instrument, unit="m", noise=1e-10, high=5000.0):
    """Measures the stroke of an actuator, built into it and so without misalignment."""

    measures: ClassVar[str] = "displacement"
    kind: Literal["displacement"] = "displacement"


class PressureSensor(Instrument, unit="Pa", noise=5.0, high=5000.0):
    """Measures a chamber's absolute pressure, or the difference of both."""

    measures: ClassVar[str] = "pressure"
    kind: Literal["pressure"] = "pressure"


class SpoolSensor(Instrument, unit="mA", noise=3e-5, high=5000.0):
    """Measures where a valve's spool stands, by a differential transformer (LVDT) that it moves."""

    measures: ClassVar[str] = "position"
    kind: Literal["position"] = "position"


class Discrete(NamedTuple):
    """One sensor between integration steps: y = C x + D u, then x⁺ = A x + B u; it begins at x = ``settled``·u."""

    A: Array
    B: Array
    C: Array
    D: float
    settled: Array


VALUES: Final = 4
"""Last values of a sensor's input, through which it is taken as a polynomial between steps."""
OLDER: Final = VALUES - 2
"""Of these, those that are states of the filter, and the last of them."""


@dataclass(frozen=True)
class _Alike:
    """An instrument among those that have its values."""

    kind: type[Instrument]
    values: tuple[Any, ...]
    instrument: Instrument = field(compare=False)


def discretise(instrument: Instrument, step: float) -> Discrete:
    """Exact for an input that is, between the last two steps [s], the cubic through its last four values.

    A law reads dozens that are alike, and of many runs all the same: they get the same, which nobody is to change.
    """
    names = (name for name in type(instrument).model_fields if name not in PROVENANCE)
    return _discretised(_Alike(type(instrument), tuple(getattr(instrument, name) for name in names), instrument), step)


@lru_cache(maxsize=128)
def _discretised(alike: _Alike, step: float) -> Discrete:
    instrument = alike.instrument
    whole = instrument.block()
    a, b, c, d = whole.A, whole.B[:, 0], whole.C[0], float(whole.D[0, 0])
    n = a.shape[0]
    if n == 0:
        return Discrete(a, b, c, d, b)
    # The input at the start of the last step, and its derivatives per step: a chain of integrators before the filter.
    block = np.diag(np.ones(n + VALUES - 1), 1)
    block[:n] = np.hstack([a * step, b[:, None] * step, np.zeros((n, VALUES - 1))])
    power = scipy.linalg.expm(block)
    A, of_derivatives = power[:n, :n], power[:n, n:]
    times, orders = 1.0 - np.arange(VALUES), np.arange(VALUES)  # the newest value is that at the end of the step
    shares = of_derivatives @ np.linalg.inv(times[:, None] ** orders / scipy.special.factorial(orders))
    # x⁺ = A x + shares·(u⁺, u, u⁻, …). With x − shares₀·u as the state, no input is needed before its time; older ones
    # are states too.
    now, settled = shares[:, 0], np.linalg.solve(-a, b)  # a has no pole at zero
    starts = settled if instrument.measures in STATIC else np.zeros(n)  # which have stood; others begin from nothing
    return Discrete(
        np.block([[A, shares[:, 2:]], [np.zeros((OLDER, n)), np.eye(OLDER, k=-1)]]),
        np.concatenate([A @ now + shares[:, 1], np.eye(OLDER)[0]]),
        np.concatenate([c, np.zeros(OLDER)]),
        float(d + c @ now),
        np.concatenate([starts - now, np.ones(OLDER)]),
    )
