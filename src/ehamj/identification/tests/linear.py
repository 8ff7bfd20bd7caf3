"""Responses compared in frequency: the linear model about the machine's equilibrium beside what was measured."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.control.channels import axis_of
from ehamj.control.settings import DigitalSettings
from ehamj.errors import InputError
from ehamj.identification.residual import Compared, Failed
from ehamj.identification.tests.played import Averaging, fine_response
from ehamj.identification.unknowns import Unknown, Values
from ehamj.linear.machine import FORCES, LinearModel, linear_model
from ehamj.measured.measured import ForcePlace
from ehamj.plant.axes import AXES
from ehamj.plant.levers import lever
from ehamj.scenario.model import Scenario

LATEST: Final = 0.02
"""Delay of a channel at most, earlier or later [s]."""
MOTIONS: Final = ("displacement", "velocity", "acceleration")


@dataclass(frozen=True)
class Port:
    """An input or output of measured responses, and what of its sensor is not known."""

    name: str
    """ehamj's name of the channel, or ``force KEY``."""
    unit: str
    place: ForcePlace | None = None
    gain: str = ""
    """Name of the unknown gain; empty: there is none."""
    delay: str = ""

    def unknowns(self, test: str) -> tuple[Unknown, ...]:
        """Those of its sensor."""
        found = []
        if self.gain:
            found.append(Unknown(self.gain, "1", 1.0, 0.1, 10.0, test=test, closed=True))
        if self.delay:
            found.append(Unknown(self.delay, "s", 0.0, -LATEST, LATEST, test=test, size=1e-3, closed=True))
        return tuple(found)


@dataclass(frozen=True)
class Line:
    """One compared response: of an output to a mixture of the inputs, which is one of them where they were alone."""

    name: str
    output: int
    mixture: ComplexArray = field(repr=False)
    """Shares of the inputs at each frequency, (f, input)."""
    measured: ComplexArray = field(repr=False)
    """(f,); NaN where it is not compared."""
    deviation: Array = field(repr=False)
    """√E|error|², (f,); NaN: to be estimated."""
    coherence: Array | None = field(default=None, repr=False)


class LinearResiduals:
    """See `ehamj.identification.residual.Residuals`."""

    def __init__(
        self, name: str, held_out: bool, scenario_at: Callable[[Values], Scenario], frequency: Array,
        inputs: Sequence[Port], outputs: Sequence[Port], lines: Sequence[Line], held: float | None = None,
        averaging: Averaging | None = None,
    ) -> None:  # fmt: skip
        """What was measured, and what it is compared with.

        Args:
            name: of the test.
            held_out: whether it only validates.
            scenario_at: the scenario of the test at a point.
            frequency: of all responses [Hz], (f,).
            inputs: of the model, in the order of mixtures.
            outputs: of the model.
            lines: responses that are compared.
            averaging: that a record's lines went through, which the model's go through as well; without, lines are
                responses themselves.
            held: rate at which a converter held the commands, where they were measured before it [Hz].
        """
        self.name, self.held_out = name, held_out
        self.inputs, self.outputs, self.lines = tuple(inputs), tuple(outputs), tuple(lines)
        self.frequency, self._scenario_at, self._held, self._averaging = frequency, scenario_at, held, averaging
        self.unknowns = tuple(one for port in (*inputs, *outputs) for one in port.unknowns(name))

    def compared(self, batch: Sequence[Values]) -> list[tuple[Compared, ...] | Failed]:
        """See `Residuals.compared`."""
        return [self._at(values) for values in batch]

    def rough(self, batch: Sequence[Values], share: float = 1.0) -> list[tuple[Compared, ...] | Failed]:
        """The same: it takes no time."""
        return self.compared(batch)

    def found(self, values: Values) -> Mapping[str, Any]:
        """Nothing else."""
        return {}

    def _at(self, values: Values) -> tuple[Compared, ...] | Failed:
        hertz = self.frequency if self._averaging is None else self._averaging.hertz
        try:
            response = self._response(self._scenario_at(values), hertz)
        except InputError as error:
            return Failed(str(error))
        s = np.asarray(2j * np.pi * hertz, np.complex128)
        into, out = (
            np.stack([_sensor(port, values, s) for port in ports], axis=1) for ports in (self.inputs, self.outputs)
        )
        # A response through its sensors: y' = g_y e^(−s τ_y) H u, u' = g_u e^(−s τ_u) u.
        sensed = response * out[:, :, None] / into[:, None, :]
        if self._averaging is None:
            return tuple(self._line(line, sensed[:, line.output] * line.mixture, values) for line in self.lines)
        parts, count = self._averaging.parts(sensed), len(self.inputs)
        return tuple(
            self._line(line, parts[:, line.output, :, number % count], values) for number, line in enumerate(self.lines)
        )

    def _line(self, line: Line, parts: ComplexArray, values: Values) -> Compared:
        """A compared response from what each input contributes to it, (f, input)."""
        port, s = self.outputs[line.output], np.asarray(2j * np.pi * self.frequency, np.complex128)
        predicted = parts.sum(axis=1)
        slopes: dict[str, ComplexArray] = {}
        if port.gain:
            slopes[port.gain] = predicted / values[port.gain]
        if port.delay:
            slopes[port.delay] = -s * predicted
        for k, driving in enumerate(self.inputs):
            if driving.gain:
                slopes[driving.gain] = -parts[:, k] / values[driving.gain]
            if driving.delay:
                slopes[driving.delay] = s * parts[:, k]
        known = np.isfinite(line.measured)
        coherence = None if line.coherence is None else line.coherence[known]
        return Compared(
            line.name, port.unit, "frequency", self.frequency[known], line.measured[known], predicted[known],
            line.deviation[known], {name: slope[known] for name, slope in slopes.items()}, coherence,
        )  # fmt: skip

    def _response(self, scenario: Scenario, hertz: Array) -> ComplexArray:
        """Outputs over inputs of the model at frequencies [Hz], (f, output, input)."""
        model = linear_model(scenario.plant)
        names = [port.name for port in self.outputs]
        s = np.asarray(2j * np.pi * hertz, np.complex128)
        whole = fine_response(model, hertz, names, model.inputs)
        columns = {name: whole[:, :, k] for k, name in enumerate(model.inputs)}
        found = np.stack([_input(port, model, scenario, columns, s) for port in self.inputs], axis=2)
        if self._held is not None:
            hold = np.exp(-0.5 * s / self._held) * np.sinc(hertz / self._held)
            commands = [k for k, port in enumerate(self.inputs) if port.name.startswith("valve_command")]
            found[:, :, commands] *= hold[:, None, None]
        return np.asarray(found)


def check_linear(scenario: Scenario, said: str) -> None:
    """Refuse a machine under a law, whose responses are not those of the machine alone.

    Raises:
        InputError: naming the way out.
    """
    if isinstance(scenario.control, DigitalSettings):
        raise InputError(
            f"{said}: compared in frequency, the machine must be without a law; set control.kind = 'passive' or "
            "'open-loop' for the test, or compare = 'time'"
        )


def _sensor(port: Port, values: Values, s: ComplexArray) -> ComplexArray:
    gain = values[port.gain] if port.gain else 1.0
    return np.asarray(gain * np.exp(-s * values[port.delay]) if port.delay else np.full(s.size, gain + 0j))


def _input(
    port: Port, model: LinearModel, scenario: Scenario, columns: Mapping[str, ComplexArray], s: ComplexArray
) -> ComplexArray:
    """Responses of all outputs to one input, (f, output)."""
    if port.place is not None:
        cg, point = scenario.plant.machine.cg, port.place.point
        at = cg if point == "cg" else scenario.points[point] if isinstance(point, str) else point
        load = lever(np.array(at) - np.array(cg)).T @ np.array(port.place.direction)
        return np.asarray(sum(share * columns[name] for share, name in zip(load, FORCES, strict=True)))
    if port.name in columns:
        own = columns[port.name]
        if not port.name.startswith("ground_"):
            return own
    variable, mount, label = port.name.split(" ")
    order = MOTIONS.index(variable.removeprefix("ground_"))
    axis = axis_of(label, np.array(model.plant.directions[model.plant.mounts.index(mount)]))
    moved = sum(
        share
        * (columns[f"ground_displacement {mount} {name}"] + s[:, None] * columns[f"ground_velocity {mount} {name}"])
        for share, name in zip(axis, AXES, strict=True)
        if share
    )
    return np.asarray(moved / s[:, None] ** order)
