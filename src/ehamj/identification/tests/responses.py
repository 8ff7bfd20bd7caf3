"""Frequency responses that an analyser wrote, beside those of the linear model, weighted by how well each is known."""

from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from ehamj.errors import InputError
from ehamj.identification.machine import with_values
from ehamj.identification.residual import Residuals
from ehamj.identification.tests.linear import Line, LinearResiduals, Port, check_linear
from ehamj.identification.tests.test import Context, TestSettings, check_channels
from ehamj.identification.unknowns import Values
from ehamj.measured.measured import ForcePlace, MeasuredResponses
from ehamj.measured.reading import channel_of
from ehamj.measured.responses import ResponseChoices, read_responses
from ehamj.measured.settings import Measurement
from ehamj.scenario.model import Scenario
from ehamj.settings import FileName, Positive


class ResponsesTest(ResponseChoices, TestSettings):
    """Responses of strokes, pressures and motions to commands, forces and the ground."""

    kind: Literal["responses"]
    file: FileName | None = Field(
        None,
        description="universal file (UFF 58), table of text, or Touchstone-like file; without: given in Python, by the "
        "test's name",
    )
    measurement: Measurement = Field(default_factory=dict, description="what outputs and inputs of the file are")
    band: tuple[Positive, Positive] = Field((1.0, 400.0), description="what is compared [Hz]")

    def residuals(self, context: Context) -> Residuals:
        """See `TestSettings.residuals`."""
        measured, scenario = self.read(context), self.scenario(context)
        check_linear(scenario, f"test {self.name!r}")
        for key, said in self.measurement.items():
            if said.offset is not None:
                raise InputError(
                    f"{self.place(context)}.measurement.{key}.offset = 'free': a response has no offset; leave it out"
                )
        kept = (measured.frequency >= self.band[0]) & (measured.frequency <= self.band[1])
        if not kept.any():
            raise InputError(
                f"{self.place(context)}.band = {list(self.band)}: responses are from {measured.frequency[0]:g} to "
                f"{measured.frequency[-1]:g} Hz"
            )

        def at(values: Values) -> Scenario:
            return with_values(scenario, {key: values[key] for key in context.keys})

        places = measured.places or (None,) * len(measured.inputs)
        into = [self._port(*one) for one in zip(measured.inputs, measured.input_units, places, strict=True)]
        out = [self._port(*one, None) for one in zip(measured.outputs, measured.output_units, strict=True)]
        lines = [line for p in range(len(out)) for line in _lines(measured, kept, p)]
        return LinearResiduals(self.name, self.hold_out, at, measured.frequency[kept], into, out, lines)

    def read(self, context: Context) -> MeasuredResponses:
        """What was measured.

        Raises:
            InputError: if there is neither a file nor a measurement in memory, or the file is not as it must be.
        """
        given = context.measured.get(self.name)
        if isinstance(given, MeasuredResponses):
            return given
        check_channels(self.measurement, self.place(context))
        if given is not None or self.file is None:
            what = (
                "file is missing, and no responses were" if given is None else "no MeasuredResponses, but others were"
            )
            raise InputError(f"test {self.name!r}: {what} given in Python by this name")
        mounts = context.scenario.plant.mounts
        return read_responses(Path(self.file), self.measurement, mounts, self, self.place(context), self.name)

    def _port(self, name: str, unit: str, place: ForcePlace | None) -> Port:
        key = next((key for key, said in self.measurement.items() if channel_of(key, said) == name), None)
        said = None if key is None else self.measurement[key]
        gain, delay = (
            f"{self.name}.{key}.{what}" if said is not None and getattr(said, what) else ""
            for what in ("gain", "delay")
        )
        return Port(name, unit, place, gain, delay)


def _lines(measured: MeasuredResponses, kept: np.ndarray, p: int) -> list[Line]:
    """Of one output, a line for each input to which its response was measured."""
    found = []
    for q, name in enumerate(measured.inputs):
        values = measured.response[kept, p, q]
        variance, coherence = measured.variance[kept, p, q], measured.coherence[kept, p, q]
        known = np.isfinite(values) & np.isfinite(variance)
        if not known.any():
            continue
        mixture = np.zeros((values.size, len(measured.inputs)), complex)
        mixture[:, q] = 1.0
        own = None if np.isnan(coherence).all() else coherence
        deviation = np.sqrt(np.where(known, variance, np.nan))
        title = f"{measured.outputs[p]} / {name}"
        found.append(Line(title, p, mixture, np.where(known, values, np.nan), deviation, own))
    return found
