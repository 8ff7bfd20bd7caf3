"""Transmissibilities of one machine side by side: linear and measured, passive and under control; as files."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Final, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.arrays import Array, ComplexArray
from ehamj.control.commands import Passive
from ehamj.errors import InputError
from ehamj.estimate.bands import Band, band_attenuation, bands
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.response import (
    ZERO,
    Transfer,
    as_lengths,
    foot_channels,
    lever_scale,
    machine_channels,
    rigid_floor,
    single_mounts,
)
from ehamj.plant.axes import DOFS
from ehamj.result import Result
from ehamj.rig.measurement import Measurement
from ehamj.rig.multisine import LEVEL, by_multisine, lines
from ehamj.rig.welch import by_welch
from ehamj.run.progress import Progress, silent
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings

PER_BAND: Final = 16
"""Frequencies per third-octave at which the linear responses are computed."""
JUDGED: Final = 0.01
"""Share of its row's largest from which an element is judged by itself: 40 dB below, nobody asks for its dB."""
COHERENT: Final = 0.95
"""Multiple coherence above which a measured element is held against the linear one."""


class TransmissibilitySettings(Settings):
    """How a transmissibility is computed and measured."""

    method: Literal["multisine", "welch"] = Field(
        "multisine", description="multisine: runs made for it; welch: a run with the scenario's own floor"
    )
    estimator: Literal["h1", "h2", "hv"] = Field("h1", description="estimator of the measured responses")
    reference: Literal["cg", "mounts"] = Field(
        "cg", description="point of the machine: centre of gravity, or the mount plane's centre"
    )
    dofs: tuple[Literal["x", "y", "z", "rx", "ry", "rz"], ...] = Field(
        DOFS, min_length=1, description="degrees of freedom in which the floor moves"
    )
    first: float = Field(1.0, gt=0, description="lowest frequency [Hz]")
    last: float = Field(300.0, gt=0, description="highest frequency [Hz]")
    lines: int = Field(40, ge=1, description="about how many lines a multisine has; they lie on whole Hz")
    realisations: int = Field(2, ge=2, description="realisations of the multisine's random phases")
    velocity: float = Field(LEVEL, gt=0, description="RMS velocity of each line of the multisine [m/s]")
    segment: Annotated[float, Field(gt=0)] | None = Field(
        None, description="length of the Welch segments [s]; without: by the length of the run, at most 4 s"
    )
    per_octave: float = Field(24.0, gt=0, description="bins per octave in which Welch's lines are averaged")
    joint: bool = Field(
        False, description="welch: all degrees of freedom as inputs together; without, each with its own output"
    )
    confidence: float = Field(0.95, gt=0, lt=1, description="probability of the confidence bands")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.first < self.last:
            raise ValueError(f"first = {self.first:g} Hz must be below last = {self.last:g} Hz")
        if len(set(self.dofs)) != len(self.dofs):
            raise ValueError(f"dofs = {', '.join(self.dofs)}: each must stand there once")
        return self


@dataclass(frozen=True)
class Variant:
    """The machine under one control: its linear transmissibilities, and the measured ones if there are any."""

    name: str
    linear: Transfer
    """Of a rigid floor."""
    single: Transfer
    """Of the ground below each mount by itself."""
    measured: tuple[Measurement, ...] = ()
    at_lines: Transfer | None = None
    """The linear one at the measured frequencies, where all inputs were measured together."""


class Element(NamedTuple):
    """The response of one output to one motion of the floor, over frequency."""

    variant: str
    kind: Literal["linear", "measured"]
    output: str
    source: str
    frequency: Array
    response: ComplexArray
    sure: tuple[Array, ...] = ()
    """Of a measured one: radius of the confidence circle, multiple and ordinary coherence."""


class Agreement(NamedTuple):
    """How far the measured responses of one output are from the linear ones at the coherent lines; None: no such.

    ``magnitude_db`` [dB] and ``phase_deg`` [deg] are the largest deviations of the elements that count: those above
    `JUDGED` of the row's largest, and known to differ from zero. ``of_floor_db`` is the largest |measured − linear| of
    any element over the floor's motion [dB]; it tells what comes through where theory has nothing.
    """

    magnitude_db: float | None
    phase_deg: float | None
    of_floor_db: float | None
    lines: int


@dataclass(frozen=True)
class Comparison:
    """Transmissibilities of a machine, variant by variant."""

    scenario: Scenario
    settings: TransmissibilitySettings
    variants: tuple[Variant, ...]
    length: float
    """By which rotations are judged beside translations [m]."""

    @property
    def outputs(self) -> tuple[str, ...]:
        """Channels of the machine."""
        return self.variants[0].linear.outputs

    @property
    def chosen(self) -> tuple[Band, ...]:
        """Third-octave bands that lie in the range of frequencies."""
        whole = bands(max(0.1, self.settings.first / 2), self.settings.last)
        low, high = self.settings.first, self.settings.last
        return tuple(band for band in whole if band.centre >= 0.99 * low and band.centre <= 1.01 * high)

    def elements(self) -> "Iterator[Element]":
        """Every response to a rigid floor: variant by variant the linear ones, then the measured."""
        for variant in self.variants:
            linear = variant.linear
            for i, output in enumerate(linear.outputs):
                for j, source in enumerate(linear.inputs):
                    yield Element(variant.name, "linear", output, source, linear.frequency, linear.response[:, i, j])
            for one in variant.measured:
                e = one.estimate
                for i, output in enumerate(one.outputs):
                    for j, source in enumerate(one.inputs):
                        sure = e.radius[:, i, j], e.multiple[:, i], e.ordinary[:, i, j]
                        response = e.response[:, i, j]
                        yield Element(variant.name, "measured", output, source, e.frequency, response, sure)

    def attenuation(self) -> "Iterator[tuple[str, str, str, Array]]":
        """Variant, linear or measured, degree of freedom, attenuation of each band [dB] (`band_attenuation`)."""
        for one in self.elements():
            if one.output == own_output(self.outputs, one.source):
                yield one.variant, one.kind, one.source, band_attenuation(one.frequency, one.response, self.chosen)

    def agreement(self) -> dict[str, dict[str, Agreement]]:
        """Per variant and output, how far measured and linear are apart where coherent."""
        found: dict[str, dict[str, Agreement]] = {}
        for variant in self.variants:
            if variant.at_lines is not None:
                (one,) = variant.measured
                found[variant.name] = {
                    name: self._agreement(one, variant.at_lines.response, k) for k, name in enumerate(one.outputs)
                }
        return found

    def _agreement(self, one: Measurement, linear: ComplexArray, k: int) -> Agreement:
        """Of one output; rotations taken as motion at the mounts' mean distance."""
        factor = as_lengths(one.outputs, one.inputs, self.length)[k]
        expected, measured = linear[:, k] * factor, one.estimate.response[:, k] * factor
        radius, coherent = one.estimate.radius[:, k] * factor, one.estimate.multiple[:, k] > COHERENT
        size = np.abs(expected)
        known = coherent[:, None] & (size > JUDGED * size.max(axis=1, keepdims=True)) & (radius < np.abs(measured))
        ratio = measured[known & (size > ZERO)] / expected[known & (size > ZERO)]
        apart = np.abs(measured - expected)[coherent]
        return Agreement(
            float(np.abs(20.0 * np.log10(np.abs(ratio))).max()) if ratio.size else None,
            float(np.degrees(np.abs(np.angle(ratio))).max()) if ratio.size else None,
            float(20.0 * np.log10(apart.max())) if apart.size and apart.max() > 0.0 else None,
            int(coherent.sum()),
        )


def own_output(outputs: Sequence[str], dof: str) -> str:
    """The machine's channel of the same degree of freedom as the floor's."""
    return next(name for name in outputs if name.endswith(f" {dof}"))


def compare_scenario(scenario: Scenario, settings: TransmissibilitySettings, progress: Progress = silent) -> Comparison:
    """Linear and measured by multisines, passive and under the scenario's control; ``progress`` hears what runs.

    Raises:
        InputError: see `by_multisine`.
    """
    kinds = {"passive": scenario.model_copy(update={"control": Passive()})}
    if scenario.controller() is not None:
        kinds[scenario.control.kind] = scenario
    s = settings
    outputs, frequency = machine_channels(s.reference), lines(s.first, s.last, s.lines)
    variants = []
    for name, one in kinds.items():
        measured = by_multisine(
            one, outputs, s.dofs, frequency, s.realisations, s.velocity, s.estimator, s.confidence,
            partial(_prefixed, progress, name),
        )  # fmt: skip
        law = one.controller()
        model, loop = linear_under(one.plant, law), Loop.of(one, law)
        at_lines = rigid_floor(model, frequency, loop, outputs, s.dofs)
        variants.append(replace(_linear(name, model, loop, s), measured=(measured,), at_lines=at_lines))
    return Comparison(scenario, s, tuple(variants), lever_scale(scenario.plant))


def _prefixed(progress: Progress, name: str, step: str) -> None:
    progress(f"{name}, {step}")


def runs_unknown_law(result: Result) -> bool:
    """Whether a run's valves followed a law of which only the commands are kept, such as a function in Python."""
    follows = result.scenario.control.kind not in ("passive", "open-loop") or bool(result.dataset.sizes.get("sensor"))
    return result.controller is None and follows


def compare_result(result: Result, settings: TransmissibilitySettings) -> Comparison:
    """Linear, passive and under the control that ran; measured from the stored run itself by Welch's method.

    Raises:
        InputError: see `by_welch`.
    """
    s = settings
    if runs_unknown_law(result):
        raise InputError("result: ran under a law in Python, which has no linear response to compare with")
    model, outputs = linear_model(result.scenario.plant), machine_channels(s.reference)
    pairs: list[tuple[Sequence[str], Sequence[str]]] = [([own_output(outputs, dof)], [dof]) for dof in s.dofs]
    if s.joint:
        pairs = [([own_output(outputs, dof) for dof in s.dofs], s.dofs)]
    measured = by_welch(result, pairs, s.segment, s.per_octave, s.estimator, s.confidence)
    measured = [one.within(s.first, s.last) for one in measured]
    variants = [_linear("passive", model, None, s)]
    loop = Loop.of(result.scenario, result.controller)
    if loop is not None:
        behind = linear_under(result.scenario.plant, result.controller)
        variants.append(_linear(result.scenario.control.kind, behind, loop, s))
    variants[-1] = replace(variants[-1], measured=tuple(measured))
    return Comparison(result.scenario, s, tuple(variants), lever_scale(model.plant))


def _linear(name: str, model: LinearModel, loop: Loop | None, s: TransmissibilitySettings) -> Variant:
    count = max(2, round(PER_BAND * 10.0 * np.log10(s.last / s.first)) + 1)
    hertz = np.geomspace(s.first, s.last, count)
    outputs = machine_channels(s.reference)
    single = (*outputs, *foot_channels(model.plant.mounts))
    return Variant(name, rigid_floor(model, hertz, loop, outputs, s.dofs), single_mounts(model, hertz, loop, single))
