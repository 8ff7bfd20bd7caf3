"""Blows of a hammer in records: from force and accelerations to modes."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.arrays import ComplexArray
from ehamj.errors import InputError, did_you_mean
from ehamj.identification.modal.files import ASSUMED
from ehamj.identification.modal.responses import Mobilities, modes_in
from ehamj.measured.hits import responses_of_hits
from ehamj.measured.measured import ForcePlace, Measured, MeasuredResponses
from ehamj.measured.modes import MeasuredModes, measured_modes
from ehamj.measured.reading import read_measured
from ehamj.measured.sensors import KINDS, Place
from ehamj.measured.settings import MeasuredForce, Measurement
from ehamj.plant.points import check_place
from ehamj.records.choices import Reading
from ehamj.scenario.model import Scenario
from ehamj.settings import Band, Direction, FileName, Positive, Settings, Vector3

AT: Final = " at "
"""Between the name of the hammer's force and the number of the place where it hit."""


class Hit(Settings):
    """A place that was hit, several times, and the record of it."""

    file: FileName = Field(description="file of the record")
    point: str | Vector3 = Field(description="where: a name in [points], or a place from the mount plane's centre [m]")
    direction: Direction = Field(description="along which, as the hammer's force counts (any length)")


class Blows(Reading):
    """Records of blows: the hammer's force, and motions that it made, several blows at each place."""

    hit: tuple[Hit, ...] = Field((), description="places that were hit, where each has a record of its own")
    file: FileName | None = Field(
        None, description="instead: file of one record, whose forces say themselves where they act"
    )
    measurement: Measurement = Field(
        default_factory=dict, description="what each component of the files is; of hits, with one force = {}"
    )
    band: Band = Field(
        (5.0, 1000.0), description="lines that count, where the blows have power within 20 dB of their most [Hz]"
    )
    length: Positive | None = Field(
        None, description="what of a record after each blow counts; without: all until the next one [s]"
    )

    @model_validator(mode="after")
    def _one_record_each(self) -> Self:
        if self.hit and self.file is not None:
            raise ValueError("must have hit, or file")
        forces = [key for key, said in self.measurement.items() if said.force is not None]
        if self.hit and len(forces) != 1:
            raise ValueError(f"measurement: must have one force, the hammer's; it has {len(forces)}")
        return self

    def records(self, mounts: tuple[str, ...], key: str, name: str) -> list[Measured]:
        """The records as they were measured.

        Raises:
            InputError: if there are none, or one is not as it must be.
        """
        if self.file is not None:
            return [read_measured(Path(self.file), self.measurement, mounts, self, key, name)]
        if not self.hit:
            raise InputError(f"{key}.hit is missing: state where the hammer hit, and the record of it")
        return [self._record(number, mounts, key, name) for number in range(len(self.hit))]

    def modes(self, records: Sequence[Measured], scenario: Scenario, key: str, name: str) -> MeasuredModes:
        """Modes of the machine in its responses to the blows, valves held.

        Raises:
            InputError: if blows or motions are not as they must be, or show no mode.
        """
        responses, errors = responses_of_hits(records, self.band, self.length, key, name)
        for number, where in enumerate(responses.places):
            at = f"{key}.hit.{number}" if self.hit else f"{key}.measurement: {responses.inputs[number]}"
            if where is not None:
                _point(where, scenario, at)
        table = modes_in(_mobilities(responses, errors, scenario, key))
        found = measured_modes(table, {}, ASSUMED, scenario.plant, scenario.points)
        how_read = {note for record in records for note in record.notes}
        return replace(found, notes=(*found.notes, *(note for note in responses.notes if note not in how_read)))

    def _record(self, number: int, mounts: tuple[str, ...], key: str, name: str) -> Measured:
        hit = self.hit[number]
        try:
            return read_measured(Path(hit.file), self._at(number, hit), mounts, self, key, name)
        except InputError as error:
            raise InputError(str(error).replace(f"{key}.file", f"{key}.hit.{number}.file")) from None

    def _at(self, number: int, hit: Hit) -> Measurement:
        """What the components of the record of a hit are: its force, by another name for each, acts there."""
        found: Measurement = {}
        for key, said in self.measurement.items():
            if said.force is None:
                found[key] = said
                continue
            force = MeasuredForce(point=hit.point, direction=hit.direction)
            own = said.model_copy(update={"force": force, "component": said.component or key})
            found[f"{key}{AT}{number + 1}"] = own
        return found


def _mobilities(responses: MeasuredResponses, errors: ComplexArray, scenario: Scenario, key: str) -> Mobilities:
    """Accelerations of the outputs that say where they stood."""
    felt = responses.felt or (None,) * len(responses.outputs)
    places, orders = {}, []
    for name, where in zip(responses.outputs, felt, strict=True):
        body, _, motion = name.split(" ")[0].rpartition("_")
        if where is not None:
            at = f"{key}.measurement: {name}: accelerometer"
            places[name] = Place(point=_point(where, scenario, at), direction=where.direction)
            orders.append(2)
        elif body in ("foot", "machine") and motion in KINDS:
            places[name] = Place(channel=name)
            orders.append(KINDS.index(motion))
        else:
            raise InputError(f"{key}.measurement: {name} is no motion of a foot, the machine or an accelerometer; "
                             "leave it out")  # fmt: skip
    turn = ((2j * np.pi * responses.frequency[:, None]) ** (2 - np.array(orders)))[:, :, None]
    words = f"blows at {len(responses.inputs)} places, {len(places)} motions"
    return Mobilities(
        tuple(places), responses.frequency, responses.response * turn, np.sqrt(responses.variance) * np.abs(turn),
        words, places, errors * turn, len(errors) - len(responses.inputs),
    )  # fmt: skip


def _point(where: ForcePlace, scenario: Scenario, key: str) -> Vector3:
    """From the mount plane's centre [m]; ``key`` is of what says it."""
    if isinstance(where.point, str):
        if where.point not in scenario.points:
            near = did_you_mean(where.point, scenario.points)
            known = ", ".join(map(repr, scenario.points))
            raise InputError(f"{key}.point = {where.point!r}: {near}must be one of {known}, or [x, y, z] in m")
        return scenario.points[where.point]
    try:
        check_place(f"{key}.point", where.point, scenario.plant.machine)
    except ValueError as error:
        raise InputError(str(error)) from None
    return where.point
