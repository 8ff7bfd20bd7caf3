"""A record of a test: channels over time, inputs among them, compared in time or in frequency."""

from pathlib import Path
from typing import Literal

from pydantic import Field

from ehamj.errors import InputError
from ehamj.identification.channels import check_seen
from ehamj.identification.machine import with_values
from ehamj.identification.residual import Residuals
from ehamj.identification.tests.averaged import averaged
from ehamj.identification.tests.driven import FADE, Driven, driven, entry_of
from ehamj.identification.tests.linear import LinearResiduals, Port, check_linear
from ehamj.identification.tests.test import Context, TestSettings, check_channels
from ehamj.identification.tests.timed import Clock, Output, TimeResiduals
from ehamj.identification.unknowns import Values
from ehamj.measured.measured import Measured, MeasuredChannel
from ehamj.measured.reading import read_measured
from ehamj.measured.settings import Measurement
from ehamj.records.choices import Reading
from ehamj.scenario.model import Scenario
from ehamj.settings import Band, FileName, Positive

Comparison = Literal["time", "frequency", "both"]


class RecordTest(Reading, TestSettings):
    """Commands, strokes, pressures, motions and forces over time."""

    kind: Literal["record"]
    file: FileName | None = Field(None, description="file of the record; without: given in Python, by the test's name")
    measurement: Measurement = Field(default_factory=dict, description="what each component of the file is")
    settle: float = Field(0.2, ge=0, description="at the beginning, not compared [s]")
    rate: Positive = Field(1000.0, description="rate of compared samples, where the logger's is a multiple of it [Hz]")
    compare: Comparison = Field(
        "time",
        description="time: the nonlinear engine, driven as the rig was; frequency: the linear model; both: the linear "
        "model finds where to begin, the nonlinear engine ends",
    )
    segment: Positive | None = Field(
        None, description="in frequency: length of a segment of Welch's spectra; without: 2 s, or an eighth of it [s]"
    )
    band: Band = Field((1.0, 400.0), description="in frequency: what is compared [Hz]")

    def residuals(self, context: Context) -> Residuals:
        """See `TestSettings.residuals`."""
        measured = self.read(context)
        if self.compare == "frequency":
            return self._linear(measured, context)
        outputs = self._outputs(measured, context)
        late = any(one.delay for one in outputs)
        faded = FADE if any(one.name.startswith("ground_") for one in measured.inputs) else 0.0
        clock = Clock(measured.rate, measured.channels[0].samples.size, self.settle, late, self.rate, faded)
        if clock.part(int(clock.duration * clock.compared)).start + 10 >= clock.duration * clock.compared:
            raise InputError(
                f"test {self.name!r}: lasts {clock.duration:g} s, of which settle = {self.settle:g} s and filters "
                "leave nothing to compare"
            )
        made = self.driven(measured, context, clock)
        begins = self._linear(measured, context) if self.compare == "both" else None
        stated = self.scenario(context).timestep != "auto"
        return TimeResiduals(self.name, self.hold_out, made.at, made.unknowns, outputs, clock, context, begins, stated)

    def _linear(self, measured: Measured, context: Context) -> LinearResiduals:
        """Its responses beside the linear model's."""
        scenario = self.scenario(context)
        check_linear(scenario, f"test {self.name!r}")
        frequency, lines, alike = averaged(measured, self.settle, self.band, self.segment)
        into, out = ([self._port(channel) for channel in side] for side in (measured.inputs, measured.outputs))

        def at(values: Values) -> Scenario:
            return with_values(scenario, {key: values[key] for key in context.keys})

        holds = [one.hold for one in self.measurement.values() if (one.channel or "").startswith("valve_command ")]
        held = measured.rate if "held" in holds else None
        return LinearResiduals(self.name, self.hold_out, at, frequency, into, out, lines, held, alike)

    def _port(self, channel: MeasuredChannel) -> Port:
        key = entry_of(self, channel)
        said = self.measurement.get(key)
        gain, delay = (
            f"{self.name}.{key}.{what}" if said is not None and getattr(said, what) else ""
            for what in ("gain", "delay")
        )
        return Port(channel.name, channel.unit, channel.place, gain, delay)

    def read(self, context: Context) -> Measured:
        """What was measured.

        Raises:
            InputError: if there is neither a file nor a measurement in memory, or the file is not as it must be.
        """
        given = context.measured.get(self.name)
        if given is not None:
            assert isinstance(given, Measured)
            return given
        check_channels(self.measurement, self.place(context))
        if self.file is None:
            raise InputError(
                f"test {self.name!r}: file is missing, and no measurement was given in Python by this name"
            )
        return read_measured(
            Path(self.file), self.measurement, context.scenario.plant.mounts, self, self.place(context), self.name
        )

    def driven(self, measured: Measured, context: Context, clock: Clock) -> Driven:
        """The scenario of the test, driven as the rig was, at any point."""
        base = self.scenario(context).model_copy(update={"compare": (), "engine": context.engine})
        return driven(self, base, measured, clock, context.keys)

    def _outputs(self, measured: Measured, context: Context) -> list[Output]:
        found = []
        for channel in measured.outputs:
            check_seen(channel.name, context.scenario.plant, f"test {self.name!r}: {channel.component or channel.name}")
            key = entry_of(self, channel)
            said = self.measurement.get(key)
            names = {
                what: f"{self.name}.{key}.{what}" if said is not None and getattr(said, what) else ""
                for what in ("offset", "gain", "delay")
            }
            found.append(Output(channel.name, channel.unit, channel.samples, **names))
        if not found:
            raise InputError(f"test {self.name!r}: measurement: no channel is compared; all are inputs")
        return found
