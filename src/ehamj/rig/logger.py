"""A virtual logger: measurements of a simulated machine as a real one would have written them, and what goes wrong.

Each column of its file is a `Tap`: a channel of the run with noise, a converter of some bits over a range, and, where
asked, a wrong gain, an offset, a clock of its own, or a fault of a wire, a sensor or a head of a column.
The same seed gives the same file.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from zlib import crc32

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.forces.kinds import STREAM
from ehamj.records.units import powers
from ehamj.result import Result, written_whole
from ehamj.rig.measurement import channel
from ehamj.run.simulate import Observed
from ehamj.scenario.model import Scenario
from ehamj.variables import VARIABLES

FORCE: Final = "force"
"""``force 0`` is the first [[force]] of the scenario, along its direction [N]."""
HEADROOM: Final = 1.25
"""Range of a converter over the largest value that a channel has, where none is stated."""


@dataclass(frozen=True, kw_only=True)
class Tap:
    """One column of a logger's file: what it is of, and how it was measured.

    Values are taken in this order: ``delay``, ``gain`` and ``offset`` of the sensor, ``noise``, the converter.
    """

    channel: str
    """As of `ehamj.control.channels`, ``valve_command MOUNT``, or ``force K``: the K-th force of the scenario."""
    name: str = ""
    """Head of the column; the channel's own name where there is none."""
    unit: str = ""
    """That the column is written in; where there is none, that of the result: SI, and mA of a spool."""
    noise: float = 0.0
    """RMS of white noise over that of the channel about its mean [-]."""
    hiss: float = 0.0
    """RMS of further white noise, in the channel's own unit."""
    bits: int | None = 16
    """Of the converter; none: exact."""
    full_scale: float | None = None
    """The converter's range is ± this, in the channel's own unit; beyond, it clips. None: it was set to fit."""
    gain: float = 1.0
    """Of the sensor over what its data sheet says [-]; negative where it is the wrong way round."""
    offset: float = 0.0
    """That the sensor adds, in the channel's own unit."""
    delay: float = 0.0
    """By which the column comes late [s]."""
    drift: float = 0.0
    """Share by which the column's clock is too slow [-], so that it comes ever later."""
    dead: bool = False
    """Whether the wire is off: noise of the converter's last bit is all there is."""
    head: str = ""
    """Unit that the head of the column states, where that is not the one it is written in."""

    @property
    def title(self) -> str:
        """Name of the column."""
        return self.name or self.channel


@dataclass(frozen=True)
class Logged:
    """What the logger wrote: ``samples`` (n, column), in ``units``, at ``rate`` [Hz] from time 0 on."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    rate: float
    samples: Array

    def __getitem__(self, name: str) -> Array:
        """A column by its name, (n,).

        Raises:
            KeyError: if there is none.
        """
        if name not in self.names:
            raise KeyError(f"{name!r} is none of {', '.join(self.names)}")
        return self.samples[:, self.names.index(name)]

    @property
    def time(self) -> Array:
        """[s], (n,)."""
        return np.arange(len(self.samples)) / self.rate

    def save(self, path: str | Path) -> Path:
        """Write it as a CSV file, times first, each column's name and unit in its head; gives the path."""
        path = Path(path)
        columns = [f"{name} [{unit}]" for name, unit in zip(self.names, self.units, strict=True)]
        heads = ["time [s]", *(f'"{column}"' if "," in column else column for column in columns)]
        with written_whole(path) as unfinished:
            rows = np.column_stack([self.time, self.samples])
            np.savetxt(unfinished, rows, fmt="%.10g", delimiter=",", header=",".join(heads), comments="")
        return path


def logged(run: Result | Observed, taps: Sequence[Tap], rate: float | None = None, seed: int = 0) -> Logged:
    """Measurements of a run by a logger.

    Args:
        run: a simulation, or what was observed of one.
        taps: the columns, each of a name of its own.
        rate: of the logger [Hz], a whole part of the run's ``record_rate``, which is taken without. It has no filter:
            what the run holds above half of it folds.
        seed: of the noise; a column's own does not depend on the others.

    Raises:
        InputError: if a tap's channel, unit or number cannot be, or the rate is none of the run's.
    """
    scenario, dataset = run.scenario, run.dataset
    every = _every(scenario.record_rate, rate)
    _check(taps)
    columns = [_column(scenario, dataset, tap, every, seed) for tap in taps]
    names, units = (tap.title for tap in taps), (tap.head or tap.unit or own_unit(tap.channel) for tap in taps)
    return Logged(tuple(names), tuple(units), scenario.record_rate / every, np.column_stack(columns))


def own_unit(name: str) -> str:
    """Unit that a channel is simulated in."""
    variable = name.split(" ")[0]
    if variable == FORCE:
        return "N"
    if variable == "load_pressure":
        return "Pa"
    if variable not in VARIABLES:
        raise InputError(f"channel {name!r} is none that a run has; such as 'foot_acceleration front-left z'")
    return VARIABLES[variable][1].split(" ")[0]


def _every(record_rate: float, rate: float | None) -> int:
    """Rows of the run per sample of the logger."""
    if rate is None:
        return 1
    every = record_rate / rate if rate > 0.0 else 0.0
    if every < 1.0 or abs(every - round(every)) > 1e-9 * every:
        raise InputError(f"rate = {rate:g} Hz: must be record_rate = {record_rate:g} Hz over a whole number")
    return round(every)


def _check(taps: Sequence[Tap]) -> None:
    titles = [tap.title for tap in taps]
    if not taps:
        raise InputError("taps: are none; a logger's file has at least one column")
    for tap in taps:
        if titles.count(tap.title) > 1:
            raise InputError(f"taps: {tap.title!r} is the name of {titles.count(tap.title)} columns; name them apart")
        if tap.bits is not None and not 2 <= tap.bits <= 32:
            raise InputError(f"{tap.title}: bits = {tap.bits} must be from 2 to 32, or None")
        if min(tap.noise, tap.hiss) < 0.0:
            raise InputError(f"{tap.title}: noise and hiss must not be negative")
        if tap.full_scale is not None and not tap.full_scale > 0.0:
            raise InputError(f"{tap.title}: full_scale = {tap.full_scale:g} must be positive")


def _column(scenario: Scenario, dataset: xr.Dataset, tap: Tap, every: int, seed: int) -> Array:
    time = dataset["time"].values
    exact = _exact(scenario, dataset, tap.channel)
    sampled = time[::every]
    if tap.delay or tap.drift:
        at = np.clip(sampled * (1.0 - tap.drift) - tap.delay, time[0], time[-1])
        read = CubicSpline(time, exact)(at)
    else:
        read = exact[::every]
    random = np.random.default_rng([seed, crc32(tap.title.encode())])
    read = 0.0 * read if tap.dead else tap.gain * read + tap.offset
    noise = tap.noise * abs(tap.gain) * float(np.std(exact)) * (not tap.dead)
    read = read + np.hypot(noise, tap.hiss) * random.standard_normal(read.size)
    return _converted(read, tap, random) * factor(own_unit(tap.channel), tap.unit, tap.title)


def _converted(read: Array, tap: Tap, random: np.random.Generator) -> Array:
    """What the converter makes of it."""
    largest = float(np.abs(read).max()) or 1.0
    scale = HEADROOM * largest if tap.full_scale is None else tap.full_scale
    if tap.bits is None:
        return read if tap.full_scale is None else np.clip(read, -scale, scale)
    step = scale / 2 ** (tap.bits - 1)
    if tap.dead:
        read = read + step * random.integers(-1, 2, read.size)
    return np.asarray(step * np.clip(np.round(read / step), -(2 ** (tap.bits - 1)), 2 ** (tap.bits - 1) - 1))


def factor(own: str, wanted: str, told: str) -> float:
    """What a value in ``own`` unit is multiplied by to be in the ``wanted`` one.

    Raises:
        InputError: if there is no such unit, or it is of something else.
    """
    if wanted in ("", own):
        return 1.0
    try:
        from_own, to_wanted = powers(own), powers(wanted)
    except ValueError as error:
        raise InputError(f"{told}: unit {error}") from None
    if from_own[1:] != to_wanted[1:]:
        raise InputError(f"{told}: unit = {wanted!r} is none of what the channel is measured in, such as {own}")
    return from_own.size / to_wanted.size


def _exact(scenario: Scenario, dataset: xr.Dataset, name: str) -> Array:
    """A channel as it was, (n,), in its `own_unit`."""
    own_unit(name)
    if name.split(" ")[0] == FORCE:
        return _force(scenario, name, dataset["time"].values)
    try:
        return channel(dataset, name)
    except (KeyError, ValueError) as error:
        raise InputError(f"channel {name!r} is none of this run ({error})") from None


def _force(scenario: Scenario, name: str, time: Array) -> Array:
    number = name.removeprefix(FORCE).strip()
    if not number.isdecimal() or int(number) >= len(scenario.force):
        raise InputError(f"channel {name!r}: the run has {len(scenario.force)} forces, the first of them is 'force 0'")
    own = scenario.force[int(number)]
    parts = own.parts(scenario.duration, np.random.default_rng([scenario.seed, STREAM, int(number)]))
    along = [float(direction @ own.axis) * signal.sample(time).value for direction, signal in parts]
    return np.asarray(np.sum(along, axis=0))
