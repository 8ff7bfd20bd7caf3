"""The table [sensors] of a scenario: which instrument measures each class of channel, and what it makes of them."""

import math
from collections.abc import Sequence
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from ehamj.arrays import Array
from ehamj.control.channels import ALONG, CROSS, SPOOLS, SUPPLY, channel_row, is_upstream, quantity_of
from ehamj.control.compiled.signals import Layout
from ehamj.control.instruments import (
    ALIGNMENT,
    Accelerometer,
    DisplacementSensor,
    Geophone,
    Instrument,
    PressureSensor,
    SpoolSensor,
    StrokeSensor,
    randomness,
)
from ehamj.control.upstream import Upstream
from ehamj.errors import InputError
from ehamj.plant.axes import DOFS
from ehamj.plant.plant import Plant
from ehamj.settings import Settings

Vibration = Annotated[Geophone | Accelerometer | DisplacementSensor, Field(discriminator="kind")]


class Sensors(Settings):
    """The instruments by class of channel; a class without a table is measured exactly."""

    ground: Vibration | None = Field(None, description="of every ground_… channel")
    inertial: Vibration | None = Field(None, description="of every foot_…, cg_… and machine_… channel")
    stroke: StrokeSensor | None = Field(None, description="of every stroke channel")
    pressure: PressureSensor | None = Field(None, description="of every …_pressure channel")
    spool: SpoolSensor | None = Field(None, description="of every spool and edges channel, built into the valve")
    upstream: Upstream | None = Field(
        None,
        description="a sensor in the floor that a wave reaches before the machine: laws told where isolation begins "
        "(isolate_from) take from it what the machine follows; without: they have the floor below the mounts alone",
    )

    def of(self, channel: str) -> Instrument | None:
        """The instrument that measures a channel, None where that is exact.

        Raises:
            InputError: if the instrument there measures another quantity, or there is none upstream.
        """
        variable = channel.partition(" ")[0]
        if is_upstream(channel) and self.upstream is None:
            raise InputError(
                f"controller.inputs: channel {channel!r}: no sensor stands upstream; state sensors.upstream.position "
                "and the wave that it is there for, or do not read it"
            )
        table = class_of(variable)
        sensor: Instrument | None = getattr(self, table)
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
        angle = randomness(seed, channel, ALIGNMENT).uniform(0.0, 2.0 * np.pi)
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
        return shares @ np.array([channel_row(name, plant) for name in names]).reshape(
            len(names), Layout.of(len(plant.mounts)).size
        )

    def response(self, channels: Sequence[str], hertz: ArrayLike) -> NDArray[np.complex128]:
        """Reading over channel at ``hertz`` [Hz], shape (frequency, channels); sensors do not couple."""
        f = np.atleast_1d(np.asarray(hertz, float))
        sensors = [self.of(name) for name in channels]
        return np.array([np.ones(f.size) if s is None else s.response(f) for s in sensors], complex).T


IDEAL = Sensors.stated()
"""Everything is measured exactly."""


def class_of(variable: str) -> str:
    """Table of [sensors] that a variable belongs to."""
    if variable in SPOOLS:
        return "spool"
    if variable in ("chamber_pressure", "load_pressure", SUPPLY):
        return "pressure"
    first = variable.partition("_")[0]
    return {"ground": "ground", "stroke": "stroke"}.get(first, "inertial")


def _cross_channels(channel: str) -> list[str]:
    """The two channels at right angles to one."""
    stem, _, label = channel.rpartition(" ")
    if label == ALONG:
        return [f"{stem} {other}" for other in CROSS]
    group = next(group for group in (DOFS[:3], DOFS[3:]) if label in group)
    return [f"{stem} {other}" for other in group if other != label]
