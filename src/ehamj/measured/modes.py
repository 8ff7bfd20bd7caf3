"""Modes that were measured: frequency, damping and shape at sensors, with their standard deviations."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.measured.sensors import Place, Sensors, sensors_of
from ehamj.plant.plant import Plant
from ehamj.plant.points import Points
from ehamj.settings import Positive, Settings

COLUMNS: Final = (
    "frequency", "damping_ratio", "frequency_deviation", "damping_deviation", "shape", "shape_deviation",
)  # fmt: skip
"""What there is of each mode."""


class Deviations(Settings):
    """Standard deviations of measured modes, where the file states none."""

    frequency: Positive = Field(0.005, description="of a frequency, over the frequency [-]")
    damping: Positive = Field(0.2, description="of a damping ratio, over the ratio [-]")
    shape: Positive = Field(0.05, description="of each entry of a shape, over its largest [-]")


class ModeEntry(Settings):
    """One measured mode."""

    frequency: Positive = Field(description="natural frequency |λ|/2π [Hz]")
    damping_ratio: float | None = Field(None, gt=-1.0, lt=1.0, description="damping ratio [-]")
    frequency_deviation: Positive | None = Field(None, description="standard deviation of the frequency [Hz]")
    damping_deviation: Positive | None = Field(None, description="standard deviation of the damping ratio [-]")
    shape: dict[str, float | tuple[float, float]] = Field(
        default_factory=dict, description="by sensor: a number with its sign, or real and imaginary part [-]"
    )
    shape_deviation: Positive | None = Field(
        None, description="standard deviation of each entry of the shape, over its largest [-]"
    )


@dataclass(frozen=True)
class ModeTable:
    """Modes as a file has them, by frequency.

    ``frequency`` |λ|/2π (k,) [Hz], ``damping_ratio`` (k,) [-], their standard deviations, and ``shape`` (k, n) over
    ``components``, of displacements or of what goes with them; ``shape_deviation`` (k,) of each entry, over the
    shape's largest. NaN: not stated. Where ``real``, the shapes have no phases but signs.
    """

    components: tuple[str, ...]
    frequency: Array
    damping_ratio: Array
    frequency_deviation: Array
    damping_deviation: Array
    shape: ComplexArray
    shape_deviation: Array
    real: bool
    words: str
    """How they were got."""
    places: Mapping[str, Place] = field(default_factory=dict)
    """Where the file itself says that sensors stood."""
    mixing: Array | None = None
    """Standard deviation of the coupling of each two (k, k) [Hz] (`ehamj.identification.modal.compared`); None: not
    known."""

    def __post_init__(self) -> None:
        order = np.argsort(self.frequency, kind="stable")
        for name in COLUMNS:
            object.__setattr__(self, name, getattr(self, name)[order])
        object.__setattr__(self, "mixing", _both(self.mixing, order))

    def of(self, kept: NDArray[np.bool_]) -> "ModeTable":
        """Some of them (k,)."""
        return replace(self, mixing=_both(self.mixing, kept), **{name: getattr(self, name)[kept] for name in COLUMNS})


def _both(square: Array | None, kept: NDArray[Any]) -> Array | None:
    """Some rows and columns, in their order."""
    return None if square is None else square[kept][:, kept]


def listed(entries: Sequence[ModeEntry], places: Mapping[str, Place], words: str) -> ModeTable:
    """Modes that were written one by one.

    Raises:
        InputError: if they do not have the same sensors.
    """
    sensors = tuple(entries[0].shape) if entries else ()
    for k, entry in enumerate(entries):
        if set(entry.shape) != set(sensors):
            other = sorted(set(entry.shape) ^ set(sensors))[0]
            raise InputError(f"mode.{k}.shape: {other!r} is a sensor of some modes only; all must have the same ones")

    def column(name: str) -> Array:
        values = [getattr(entry, name) for entry in entries]
        return np.array([np.nan if value is None else value for value in values], float)

    parts = [[entry.shape[sensor] for sensor in sensors] for entry in entries]
    real = all(isinstance(part, float | int) for row in parts for part in row)
    shape = [[complex(*part) if isinstance(part, tuple) else complex(part) for part in row] for row in parts]
    return ModeTable(
        sensors,
        column("frequency"),
        column("damping_ratio"),
        column("frequency_deviation"),
        column("damping_deviation"),
        np.array(shape, complex).reshape(len(entries), len(sensors)),
        column("shape_deviation"),
        real,
        words,
        places,
    )


@dataclass(frozen=True)
class MeasuredModes:
    """Measured modes by frequency, with sensors that have a place, and every deviation known.

    Shapes (k, n) have one as their largest entry; ``deviation`` is that of each entry. ``damping_ratio`` is NaN where
    none was measured. ``notes`` say what was assumed.
    """

    sensors: Sensors
    frequency: Array
    damping_ratio: Array
    frequency_deviation: Array
    damping_deviation: Array
    shape: ComplexArray
    shape_deviation: Array
    real: bool
    words: str
    notes: tuple[str, ...] = ()
    mixing: Array | None = None
    """As of `ModeTable`."""

    @property
    def names(self) -> tuple[str, ...]:
        """By which a mode is called."""
        return tuple(f"{hertz:.4g} Hz" for hertz in self.frequency)

    def without(self, left_out: NDArray[np.bool_]) -> "MeasuredModes":
        """The others."""
        kept = ~left_out
        return replace(self, mixing=_both(self.mixing, kept), **{name: getattr(self, name)[kept] for name in COLUMNS})


def measured_modes(
    table: ModeTable, places: Mapping[str, Place], deviations: Deviations, plant: Plant, points: Points
) -> MeasuredModes:
    """Measured modes of a machine.

    Args:
        table: as a file has them.
        places: where sensors stood, beside what the file itself says.
        deviations: where the file states none.
        plant: whose feet sensors stand at.
        points: of the scenario.

    Raises:
        InputError: where a sensor has no place, or a value is impossible; it names which.
    """
    sensors = sensors_of(table.components, {**table.places, **places}, plant, points)
    if table.frequency.size == 0:
        raise InputError("file: holds no modes")
    _check(table)
    size = np.abs(table.shape).max(axis=1, initial=0.0)
    if table.components and not size.all():
        where = float(table.frequency[np.argmin(size)])
        raise InputError(f"file: the shape of the mode at {where:g} Hz is zero everywhere; leave that mode out")
    largest = table.shape[np.arange(len(size)), np.argmax(np.abs(table.shape), axis=1)] if sensors.names else size
    shape = table.shape * sensors.scales / largest[:, None] if sensors.names else table.shape
    hertz = np.where(np.isnan(table.frequency_deviation), deviations.frequency * table.frequency, 0.0)
    notes, assumed = [], []
    if hertz.any():
        assumed.append(f"{deviations.frequency:.3g} of each frequency")
    if np.isnan(table.damping_deviation[~np.isnan(table.damping_ratio)]).any():
        assumed.append(f"{deviations.damping:.3g} of each damping ratio")
    if sensors.names and np.isnan(table.shape_deviation).any():
        assumed.append(f"{deviations.shape:.3g} of a shape's largest entry")
    if assumed:
        notes.append(f"standard deviations that the file does not state are taken as {', '.join(assumed)}")
    ratio = table.damping_ratio
    return MeasuredModes(
        sensors,
        table.frequency,
        ratio,
        _known(table.frequency_deviation, deviations.frequency * table.frequency),
        _known(table.damping_deviation, deviations.damping * np.maximum(ratio, 1e-3)),
        shape,
        _known(table.shape_deviation, np.full(len(size), deviations.shape)),
        table.real,
        table.words,
        tuple(notes),
        table.mixing,
    )


def _known(stated: Array, otherwise: Array) -> Array:
    return np.where(np.isnan(stated), otherwise, stated)


def _check(table: ModeTable) -> None:
    """Refuse frequencies, damping ratios and deviations that no mode has."""
    checks = {
        "frequency": (table.frequency, table.frequency > 0.0, "above 0 Hz"),
        "damping ratio": (table.damping_ratio, np.abs(table.damping_ratio) < 1.0, "between -1 and 1; per cent have %"),
        "deviation of the frequency": (table.frequency_deviation, table.frequency_deviation > 0.0, "above 0 Hz"),
        "deviation of the damping ratio": (table.damping_deviation, table.damping_deviation > 0.0, "above 0"),
        "deviation of the shape": (table.shape_deviation, table.shape_deviation > 0.0, "above 0"),
    }
    for what, (values, good, allowed) in checks.items():
        silent = np.isnan(values) & (what != "frequency")
        if not (good | silent).all():
            wrong = int(np.argmin(good | silent))
            raise InputError(
                f"file: the {what} of mode {wrong + 1} (by frequency) is {values[wrong]:g}; it must be {allowed}"
            )
    if not np.isfinite(table.shape).all():
        k, n = np.argwhere(~np.isfinite(table.shape))[0]
        raise InputError(
            f"file: the shape of mode {k + 1} (by frequency) has no number at {table.components[n]}; leave that sensor "
            "out, or measure it"
        )
