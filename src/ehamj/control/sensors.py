"""Sensors between the machine and the controller: pass band, noise, range, resolution, drift, alignment.

What a controller measures is

    round(clip(G(s)·(channel along the sensor's own axis) + noise + drift))

with G a Butterworth high-pass at ``low`` and low-pass at ``high``, each of ``order``. The noise has the one-sided
amplitude density n(f) = noise·√(1 + (noise_corner/f)²), which bends over to flat below ``low`` and falls with the
low-pass, through which it leaves the instrument (at the sampling rate, by the bilinear transform, so that it falls to
nothing at half of it; a corner that the rate does not carry lets all of it pass). Between integration steps the input
is taken as straight (ramp-invariant discretisation), so that the filter's phase has no error of its own.
"""

import math
import zlib
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator
from scipy import signal
from scipy.linalg import expm

from ehamj.control.channels import N_SIGNALS, channel_row
from ehamj.errors import InputError
from ehamj.plant.axes import DOFS
from ehamj.plant.plant import Plant
from ehamj.settings import Parameters, Settings, Unlimited, quantity

Array = NDArray[np.float64]

ALIGNMENT, NOISE = 1, 2
"""Streams of random numbers of a channel."""


class StateSpace(NamedTuple):
    """ẋ = A x + B u, y = C x + D u of one sensor."""

    A: Array
    B: Array
    C: Array
    D: float


class Sensor(Parameters):
    """What every instrument has; the kinds below add values in their own units."""

    measures: ClassVar[str]
    """Quantity that the instrument measures: displacement, velocity, acceleration or pressure."""

    low: float = quantity(0.0, "Hz", "f_l", "corner of the high-pass (0: none)", "assumed", ge=0)
    high: Unlimited = quantity(math.inf, "Hz", "f_h", "corner of the low-pass (inf: none)", "assumed", gt=0)
    order: int = Field(2, ge=1, le=4, description="order of each Butterworth filter")
    noise: float
    noise_corner: float = quantity(1.0, "Hz", "f_n", "frequency below which the noise rises as 1/f", "assumed", ge=0)
    range: float
    resolution: float
    drift: float
    random_walk: float

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
            b, a = signal.butter(self.order, 2 * np.pi * corner, kind, analog=True)
            s = 2j * np.pi * f
            total *= np.polyval(b, s) / np.polyval(a, s)
        return total

    def noise_density(self, hertz: ArrayLike) -> Array:
        """One-sided amplitude density of the noise at ``hertz`` > 0 [unit/√Hz]."""
        f = np.asarray(hertz, float)
        passed = 1.0 / np.sqrt(1.0 + (f / self.high) ** (2 * self.order))
        return np.asarray(self.noise * passed * np.sqrt(1.0 + self.noise_corner**2 / (f**2 + self.low**2)))

    def state_space(self) -> StateSpace:
        """G(s), high-pass before low-pass, states of the size of the signal."""
        A, B, C, D = np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), 1.0
        for kind, corner in self.filters:
            omega = 2 * np.pi * corner
            # In units of the corner the coefficients are of size one.
            a, b, c, d = signal.tf2ss(*signal.butter(self.order, 1.0, kind, analog=True))
            A = np.block([[A, np.zeros((A.shape[0], a.shape[0]))], [omega * b @ C, omega * a]])
            B = np.vstack([B, omega * b * D])
            C, D = np.hstack([d @ C, c]), float(d[0, 0]) * D
        return StateSpace(A, B[:, 0], C[0], D)


def _density(default: float, unit: str) -> Any:
    return quantity(default, f"{unit}/√Hz", "n", "noise density above its corner, one-sided", "assumed", ge=0)


def _range(unit: str) -> Any:
    return quantity(math.inf, unit, "R", "the reading is limited to ± this (inf: not)", "assumed", gt=0)


def _resolution(unit: str) -> Any:
    return quantity(0.0, unit, "Δ", "the reading is a multiple of this (0: exact)", "assumed", ge=0)


def _drift(unit: str) -> Any:
    return quantity(0.0, f"{unit}/s", "d", "steady drift of the reading, its sign by chance", "assumed", ge=0)


def _walk(unit: str) -> Any:
    return quantity(0.0, f"{unit}/√s", "w", "spread of a random walk of the reading after 1 s", "assumed", ge=0)


def _misalignment() -> Any:
    text = "angle between the sensor's axis and the channel's, its direction by chance"
    return quantity(0.0, "deg", "α", text, "assumed", ge=0, le=45)


class Aligned(Sensor):
    """An instrument with an axis."""

    misalignment: float

    @property
    def tilt(self) -> float:
        return math.radians(self.misalignment)


class Geophone(Aligned):
    """Measures velocity. Defaults are an instrument good enough for 56 dB on a VC-C floor."""

    measures: ClassVar[str] = "velocity"
    kind: Literal["geophone"]
    low: float = quantity(0.1, "Hz", "f_l", "corner of the high-pass (0: none)", "assumed", ge=0)
    high: Unlimited = quantity(1000.0, "Hz", "f_h", "corner of the low-pass (inf: none)", "assumed", gt=0)
    noise: float = _density(3e-9, "m/s")
    range: Unlimited = _range("m/s")
    resolution: float = _resolution("m/s")
    drift: float = _drift("m/s")
    random_walk: float = _walk("m/s")
    misalignment: float = _misalignment()


class Accelerometer(Aligned):
    """Measures acceleration. The default noise is that of a seismic accelerometer, 1 µg/√Hz."""

    measures: ClassVar[str] = "acceleration"
    kind: Literal["accelerometer"]
    low: float = quantity(0.1, "Hz", "f_l", "corner of the high-pass (0: none)", "assumed", ge=0)
    high: Unlimited = quantity(1000.0, "Hz", "f_h", "corner of the low-pass (inf: none)", "assumed", gt=0)
    noise: float = _density(9.8e-6, "m/s²")
    range: Unlimited = _range("m/s²")
    resolution: float = _resolution("m/s²")
    drift: float = _drift("m/s²")
    random_walk: float = _walk("m/s²")
    misalignment: float = _misalignment()


class DisplacementSensor(Aligned):
    """Measures displacement, against a reference that stands still."""

    measures: ClassVar[str] = "displacement"
    kind: Literal["displacement"]
    high: Unlimited = quantity(5000.0, "Hz", "f_h", "corner of the low-pass (inf: none)", "assumed", gt=0)
    noise: float = _density(1e-10, "m")
    range: Unlimited = _range("m")
    resolution: float = _resolution("m")
    drift: float = _drift("m")
    random_walk: float = _walk("m")
    misalignment: float = _misalignment()


class StrokeSensor(Sensor):
    """Measures the stroke of an actuator, built into it and so without misalignment."""

    measures: ClassVar[str] = "displacement"
    kind: Literal["displacement"] = "displacement"
    high: Unlimited = quantity(5000.0, "Hz", "f_h", "corner of the low-pass (inf: none)", "assumed", gt=0)
    noise: float = _density(1e-10, "m")
    range: Unlimited = _range("m")
    resolution: float = _resolution("m")
    drift: float = _drift("m")
    random_walk: float = _walk("m")


class PressureSensor(Sensor):
    """Measures a chamber's absolute pressure, or the difference of both."""

    measures: ClassVar[str] = "pressure"
    kind: Literal["pressure"] = "pressure"
    high: Unlimited = quantity(5000.0, "Hz", "f_h", "corner of the low-pass (inf: none)", "assumed", gt=0)
    noise: float = _density(5.0, "Pa")
    range: Unlimited = _range("Pa")
    resolution: float = _resolution("Pa")
    drift: float = _drift("Pa")
    random_walk: float = _walk("Pa")


Vibration = Annotated[Geophone | Accelerometer | DisplacementSensor, Field(discriminator="kind")]


class Sensors(Settings):
    """The instruments by class of channel; a class without a table is measured exactly."""

    ground: Vibration | None = Field(None, description="of every ground_… channel")
    inertial: Vibration | None = Field(None, description="of every foot_…, cg_… and machine_… channel")
    stroke: StrokeSensor | None = Field(None, description="of every stroke channel")
    pressure: PressureSensor | None = Field(None, description="of every chamber_pressure and load_pressure channel")

    def of(self, channel: str) -> Sensor | None:
        """The instrument that measures a channel, None where that is exact.

        Raises:
            InputError: if the instrument there measures another quantity.
        """
        variable = channel.partition(" ")[0]
        table = _class_of(variable)
        sensor: Sensor | None = getattr(self, table) if table else None
        if sensor is None:
            return None
        wanted = quantity_of(variable)
        if wanted != sensor.measures:
            stem = variable.removesuffix(f"_{wanted}")
            own = stem if table == "stroke" else f"{stem}_{sensor.measures}"
            kind = getattr(sensor, "kind", "")
            raise InputError(
                f"controller.inputs: channel {channel!r}: [sensors.{table}] is of kind {kind!r} and measures "
                f"{sensor.measures}; read {channel.replace(variable, own)!r} instead, or change the sensor"
            )
        return sensor

    def mixture(self, channel: str, seed: int) -> dict[str, float]:
        """The channel along its sensor's own axis, as channels and their shares.

        Raises:
            InputError: if the instrument there measures another quantity.
        """
        sensor = self.of(channel)
        if sensor is None or sensor.tilt == 0.0:
            return {channel: 1.0}
        angle = _random(seed, channel, ALIGNMENT).uniform(0.0, 2.0 * np.pi)
        across = zip(_cross_channels(channel), (math.cos(angle), math.sin(angle)), strict=True)
        return {channel: math.cos(sensor.tilt), **{name: math.sin(sensor.tilt) * share for name, share in across}}

    def mixtures(self, channels: Sequence[str], seed: int) -> tuple[tuple[str, ...], Array]:
        """All channels that reach the sensors, and their shares in each reading, (channels, found)."""
        found = [self.mixture(name, seed) for name in channels]
        names = tuple(dict.fromkeys(name for mixture in found for name in mixture))
        return names, np.array([[m.get(name, 0.0) for name in names] for m in found]).reshape(len(found), len(names))

    def rows(self, channels: Sequence[str], plant: Plant, seed: int) -> Array:
        """What the sensors at the channels see, as rows over the vector of signals; see `ehamj.control.channels`."""
        names, shares = self.mixtures(channels, seed)
        return shares @ np.array([channel_row(name, plant) for name in names]).reshape(len(names), N_SIGNALS)

    def response(self, channels: Sequence[str], hertz: ArrayLike) -> NDArray[np.complex128]:
        """Reading over channel at ``hertz`` [Hz], shape (frequency, channels); sensors do not couple."""
        f = np.atleast_1d(np.asarray(hertz, float))
        sensors = [self.of(name) for name in channels]
        return np.array([np.ones(f.size) if s is None else s.response(f) for s in sensors], complex).T


IDEAL = Sensors()
"""Everything is measured exactly."""


def _class_of(variable: str) -> str | None:
    """Table of [sensors] that a variable belongs to; the spool's own transducer is taken as exact."""
    if variable in ("chamber_pressure", "load_pressure"):
        return "pressure"
    first = variable.partition("_")[0]
    return {"ground": "ground", "stroke": "stroke", "spool": None}.get(first, "inertial")


def quantity_of(variable: str) -> str:
    """Displacement, velocity, acceleration or pressure."""
    return "displacement" if variable == "stroke" else variable.rpartition("_")[2]


def _cross_channels(channel: str) -> list[str]:
    """The two channels at right angles to one."""
    stem, _, label = channel.rpartition(" ")
    group = next(group for group in (DOFS[:3], DOFS[3:]) if label in group)
    return [f"{stem} {other}" for other in group if other != label]


def _random(seed: int, channel: str, stream: int) -> np.random.Generator:
    """Random numbers of a channel, whatever other channels there are."""
    return np.random.default_rng([seed, zlib.crc32(channel.encode()), stream])


class Discrete(NamedTuple):
    """One sensor between integration steps: y = C x + D u, then x⁺ = A x + B u; it begins at x = ``settled``·u."""

    A: Array
    B: Array
    C: Array
    D: float
    settled: Array


def discretise(sensor: Sensor, step: float) -> Discrete:
    """Ramp-invariant: exact for an input that is straight between steps [s]."""
    a, b, c, d = sensor.state_space()
    n = a.shape[0]
    if n == 0:
        return Discrete(a, b, c, d, b)
    block = np.zeros((n + 2, n + 2))
    block[:n, :n], block[:n, n], block[n, n + 1] = a * step, b * step, 1.0
    power = expm(block)
    A, first, second = power[:n, :n], power[:n, n], power[:n, n + 1]  # x⁺ = A x + first·u + second·(u⁺ − u)
    # With x − second·u as the state, no input is needed before its time.
    B = A @ second + first - second
    at_rest = np.linalg.solve(-a, b) - second  # a has no pole at zero
    starts = sensor.measures in ("displacement", "pressure")  # which have stood there; the others begin from nothing
    return Discrete(A, B, c, float(d + c @ second), at_rest if starts else -second)


class ReadingNoise:
    """Noise and drift of the readings, sample after sample; the same whatever the lengths asked for."""

    def __init__(self, channels: tuple[str, ...], sensors: Sensors, seed: int, period: float) -> None:
        self._sensors = [sensors.of(name) for name in channels]
        self._random = [_random(seed, name, NOISE) for name in channels]
        self._period, self._done = period, 0
        self._passes = [None if sensor is None else self._low_pass(sensor) for sensor in self._sensors]
        self._signs = [float(random.choice((-1.0, 1.0))) for random in self._random]
        self._states = [
            np.zeros(2) if sensor is None else self._start(sensor, random)
            for sensor, random in zip(self._sensors, self._random, strict=True)
        ]

    @property
    def silent(self) -> bool:
        """Whether there is none at all."""
        return all(s is None or s.noise == s.drift == s.random_walk == 0.0 for s in self._sensors)

    def take(self, samples: int) -> Array:
        """The next samples, (samples, channels) in the channels' units."""
        found = np.zeros((samples, len(self._sensors)))
        times = (self._done + np.arange(samples)) * self._period
        for k, (sensor, random) in enumerate(zip(self._sensors, self._random, strict=True)):
            if sensor is not None:
                drawn = random.standard_normal((samples, 3))
                slow, walked, self._states[k] = self._accumulate(sensor, drawn, self._states[k])
                white = sensor.noise * math.sqrt(0.5 / self._period) * drawn[:, 0]
                low_pass = self._passes[k]
                electronic = white + slow if low_pass is None else low_pass.take(white + slow)
                found[:, k] = electronic + walked + self._signs[k] * sensor.drift * times
        self._done += samples
        return found

    def _start(self, sensor: Sensor, random: np.random.Generator) -> Array:
        """State before the first sample: of the rising noise drawn from its long-run spread, of the walk zero."""
        decay = math.exp(-2.0 * np.pi * sensor.low * self._period)
        spread = self._kick(sensor) / math.sqrt(1.0 - decay**2) if decay < 1.0 else 0.0
        return np.array([spread * random.standard_normal(), 0.0])

    def _low_pass(self, sensor: Sensor) -> "_LowPass | None":
        """The instrument's low-pass at the sampling rate, where that carries it."""
        corner = 2.0 * sensor.high * self._period
        return _LowPass(sensor.order, corner) if corner < 1.0 else None

    def _kick(self, sensor: Sensor) -> float:
        """Spread of what a sample adds to the rising noise: its density is then noise·noise_corner/f."""
        return sensor.noise * sensor.noise_corner * 2.0 * np.pi * math.sqrt(0.5 * self._period)

    def _accumulate(self, sensor: Sensor, drawn: Array, state: Array) -> tuple[Array, Array, Array]:
        decay = math.exp(-2.0 * np.pi * sensor.low * self._period)
        slow, _ = signal.lfilter([1.0], [1.0, -decay], self._kick(sensor) * drawn[:, 1], zi=[decay * state[0]])
        walked, _ = signal.lfilter(
            [1.0], [1.0, -1.0], sensor.random_walk * math.sqrt(self._period) * drawn[:, 2], zi=[state[1]]
        )
        last = np.array([slow[-1], walked[-1]]) if drawn.shape[0] else state
        return slow, walked, last


class _LowPass:
    """A Butterworth low-pass of ``order`` at ``corner`` (share of half the sampling rate), fed piece by piece."""

    def __init__(self, order: int, corner: float) -> None:
        self._sections = signal.butter(order, corner, output="sos")
        self._state = np.zeros((self._sections.shape[0], 2))

    def take(self, values: Array) -> Array:
        """The filtered values, (n,)."""
        if values.size == 0:
            return values
        filtered, self._state = signal.sosfilt(self._sections, values, zi=self._state)
        return np.asarray(filtered)
