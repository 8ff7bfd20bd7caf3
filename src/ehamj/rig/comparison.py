"""Transmissibilities of one machine side by side: linear and measured, passive and under control; as files."""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ehamj.control import LinearController
from ehamj.control.commands import Passive
from ehamj.control.sensors import Sensors
from ehamj.errors import InputError
from ehamj.estimate.third_octave import Band, bands
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.response import (
    GROUNDS,
    Transfer,
    as_lengths,
    band_attenuation,
    deviations,
    foot_channels,
    lever_scale,
    machine_channels,
    rigid_floor,
    single_mounts,
    unit,
)
from ehamj.plant.axes import DOFS
from ehamj.result import Result, written_whole
from ehamj.rig.lines import lines
from ehamj.rig.measured import LEVEL, Measurement, by_multisine, by_welch
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings

Array = NDArray[np.float64]

PER_BAND: Final = 16
"""Frequencies per third-octave at which the linear responses are computed."""
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

    def attenuation(self) -> "Iterator[tuple[str, str, str, Array]]":
        """Variant, linear or measured, degree of freedom, attenuation of each band [dB] (`band_attenuation`)."""
        chosen = self.chosen
        for variant in self.variants:
            for dof in self.settings.dofs:
                output = own_output(self.outputs, dof)
                element = variant.linear.response[:, self.outputs.index(output), variant.linear.inputs.index(dof)]
                yield variant.name, "linear", dof, band_attenuation(variant.linear.frequency, element, chosen)
            for one, output, source in _elements(variant.measured):
                if output == own_output(self.outputs, source):
                    measured = one.estimate.response[:, one.outputs.index(output), one.inputs.index(source)]
                    yield variant.name, "measured", source, band_attenuation(one.estimate.frequency, measured, chosen)

    def agreement(self) -> dict[str, dict[str, dict[str, float | None]]]:
        """Per variant and output, the largest deviation of measured from linear where coherent.

        ``of_linear``: of the linear response (`deviations`); ``of_floor``: of the floor's motion, rotations taken as
        motion at the mounts' mean distance. None where nothing is coherent, or moves at all.
        """
        found: dict[str, dict[str, dict[str, float | None]]] = {}
        for variant in self.variants:
            if variant.at_lines is None:
                continue
            (one,) = variant.measured
            measured, linear = one.estimate.response, variant.at_lines.response
            errors = {
                "of_linear": deviations(measured, linear, one.outputs, one.inputs, self.length),
                "of_floor": np.abs(measured - linear) * as_lengths(one.outputs, one.inputs, self.length),
            }
            judged = (one.estimate.multiple > COHERENT) & np.isfinite(errors["of_linear"]).all(axis=2)
            found[variant.name] = {
                name: {
                    what: float(error[judged[:, k], k].max()) if judged[:, k].any() else None
                    for what, error in errors.items()
                }
                for k, name in enumerate(one.outputs)
            }
        return found


def own_output(outputs: Sequence[str], dof: str) -> str:
    """The machine's channel of the same degree of freedom as the floor's."""
    return next(name for name in outputs if name.endswith(f" {dof}"))


def compare_scenario(scenario: Scenario, settings: TransmissibilitySettings) -> Comparison:
    """Linear and measured by multisines, passive and under the scenario's control.

    Raises:
        InputError: see `by_multisine`.
    """
    kinds = {"passive": scenario.model_copy(update={"control": Passive()})}
    if scenario.controller() is not None:
        kinds[scenario.control.kind] = scenario
    model, s = linear_model(scenario), settings
    outputs, frequency = machine_channels(s.reference), lines(s.first, s.last, s.lines)
    variants = []
    for name, one in kinds.items():
        measured = by_multisine(one, outputs, s.dofs, frequency, s.realisations, s.velocity, s.estimator, s.confidence)
        controller = one.controller()
        sensing = one.sensors, one.seed
        at_lines = rigid_floor(model, frequency, controller, outputs, s.dofs, *sensing)
        variants.append(replace(_linear(name, model, controller, s, *sensing), measured=(measured,), at_lines=at_lines))
    return Comparison(scenario, s, tuple(variants), lever_scale(model.plant))


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
    model, outputs = linear_model(result.scenario), machine_channels(s.reference)
    pairs: list[tuple[Sequence[str], Sequence[str]]] = [([own_output(outputs, dof)], [dof]) for dof in s.dofs]
    if s.joint:
        pairs = [([own_output(outputs, dof) for dof in s.dofs], s.dofs)]
    measured = by_welch(result, pairs, s.segment, s.per_octave, s.estimator, s.confidence)
    measured = [one.within(s.first, s.last) for one in measured]
    variants = [_linear("passive", model, None, s, result.scenario.sensors, result.scenario.seed)]
    if result.controller is not None:
        variants.append(
            _linear(
                result.scenario.control.kind, model, result.controller, s, result.scenario.sensors, result.scenario.seed
            )
        )
    variants[-1] = replace(variants[-1], measured=tuple(measured))
    return Comparison(result.scenario, s, tuple(variants), lever_scale(model.plant))


def _linear(
    name: str,
    model: LinearModel,
    controller: LinearController | None,
    s: TransmissibilitySettings,
    sensors: Sensors,
    seed: int,
) -> Variant:
    count = max(2, round(PER_BAND * 10.0 * np.log10(s.last / s.first)) + 1)
    hertz = np.geomspace(s.first, s.last, count)
    outputs = machine_channels(s.reference)
    return Variant(
        name,
        rigid_floor(model, hertz, controller, outputs, s.dofs, sensors, seed),
        single_mounts(model, hertz, controller, (*outputs, *foot_channels()), sensors, seed),
    )


def _elements(measured: Sequence[Measurement]) -> Iterator[tuple[Measurement, str, str]]:
    for one in measured:
        for output in one.outputs:
            for source in one.inputs:
                yield one, output, source


# --- files -----------------------------------------------------------------------------------------------------------


def write_tables(folder: Path, found: Comparison) -> None:
    """Write ``transmissibility.nc``, ``transmissibility.csv`` (a rigid floor; single mounts are in the former) and
    ``attenuation.csv`` into an existing folder."""
    with written_whole(folder / "transmissibility.nc") as path:
        to_dataset(found).to_netcdf(path, engine="h5netcdf")
    head = ("variant", "kind", "output", "input", "unit", "frequency_hz", "magnitude", "phase_deg", "radius",
            "multiple_coherence", "ordinary_coherence")  # fmt: skip
    _write_csv(folder / "transmissibility.csv", head, _rows(found))
    rows = (
        (variant, kind, dof, band.name, "" if np.isnan(level) else f"{level:.6g}")
        for variant, kind, dof, levels in found.attenuation()
        for band, level in zip(found.chosen, levels, strict=True)
    )
    _write_csv(folder / "attenuation.csv", ("variant", "kind", "dof", "band_hz", "attenuation_db"), rows)


def _write_csv(path: Path, head: Sequence[str], rows: Iterator[Sequence[str]]) -> None:
    with written_whole(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(rows)


def _rows(found: Comparison) -> Iterator[Sequence[str]]:
    """A row per variant, kind, element and frequency; linear responses have no coherence."""

    def row(first: Sequence[str], f: float, value: complex, *more: float) -> Sequence[str]:
        numbers = (f, abs(value), float(np.degrees(np.angle(value))), *more)
        texts = ("" if np.isnan(number) else f"{number:.9g}" for number in numbers)
        return (*first, *texts, *([""] * (3 - len(more))))

    for variant in found.variants:
        linear = variant.linear
        for i, output in enumerate(linear.outputs):
            for j, source in enumerate(linear.inputs):
                first = (variant.name, "linear", output, f"floor {source}", unit(output, source))
                for f, value in zip(linear.frequency, linear.response[:, i, j], strict=True):
                    yield row(first, f, value)
        for one, output, source in _elements(variant.measured):
            e, i, j = one.estimate, one.outputs.index(output), one.inputs.index(source)
            first = (variant.name, "measured", output, f"floor {source}", unit(output, source))
            for k, f in enumerate(e.frequency):
                yield row(first, f, e.response[k, i, j], e.radius[k, i, j], e.multiple[k, i], e.ordinary[k, i, j])


def to_dataset(found: Comparison) -> xr.Dataset:
    """Everything as one labelled dataset; complex responses as magnitude and phase, NaN where not measured."""
    first, s = found.variants[0], found.settings
    coordinates: dict[str, Any] = {
        "variant": [variant.name for variant in found.variants],
        "output": list(first.linear.outputs),
        "input": list(first.linear.inputs),
        "point": list(first.single.outputs),
        "ground": list(GROUNDS),
        "frequency": ("frequency", first.linear.frequency, {"units": "Hz"}),
        "band": ("band", [band.centre for band in found.chosen], {"units": "Hz", "long_name": "exact centre"}),
    }
    data = _polar("linear", ("variant", "frequency", "output", "input"), "floor to machine, linear",
                  np.array([variant.linear.response for variant in found.variants]))  # fmt: skip
    data |= _polar("single_mount", ("variant", "frequency", "point", "ground"), "ground below one mount, linear",
                   np.array([variant.single.response for variant in found.variants]))  # fmt: skip
    grids = [one.estimate.frequency for variant in found.variants for one in variant.measured]
    if grids:
        coordinates["line"] = ("line", grids[0], {"units": "Hz"})
        data |= _measured(found, grids[0])
    for kind in ("linear", "measured"):
        levels = np.full((len(found.variants), len(s.dofs), len(found.chosen)), np.nan)
        for variant, what, dof, values in found.attenuation():
            if what == kind:
                levels[coordinates["variant"].index(variant), s.dofs.index(dof)] = values
        text = f"attenuation per third-octave, {kind}, positive: quieter than the floor"
        data[f"attenuation_{kind}"] = (("variant", "input", "band"), levels, {"units": "dB", "long_name": text})
    attributes = {"title": found.scenario.name, "reference": s.reference, "estimator": s.estimator,
                  "confidence": s.confidence}  # fmt: skip
    return xr.Dataset(data, coordinates, attributes)


UNITS: Final = "m/m, m/rad, rad/m or rad/rad by output and input"


def _polar(name: str, dims: Sequence[str], text: str, values: NDArray[np.complex128]) -> dict[str, Any]:
    return {
        f"{name}_magnitude": (dims, np.abs(values), {"units": UNITS, "long_name": f"{text}, magnitude"}),
        f"{name}_phase": (dims, np.degrees(np.angle(values)), {"units": "degree", "long_name": f"{text}, phase"}),
    }


def _measured(found: Comparison, grid: Array) -> dict[str, Any]:
    first = found.variants[0].linear
    shape = (len(found.variants), grid.size, len(first.outputs), len(first.inputs))
    response, radius = np.full(shape, np.nan, complex), np.full(shape, np.nan)
    multiple, ordinary = np.full(shape, np.nan), np.full(shape, np.nan)
    for v, variant in enumerate(found.variants):
        for one, output, source in _elements(variant.measured):
            e, i, j = one.estimate, one.outputs.index(output), one.inputs.index(source)
            at = (v, slice(None), first.outputs.index(output), first.inputs.index(source))
            response[at], radius[at] = e.response[:, i, j], e.radius[:, i, j]
            multiple[at], ordinary[at] = e.multiple[:, i], e.ordinary[:, i, j]
    dims = ("variant", "line", "output", "input")
    data = _polar("measured", dims, "floor to machine, measured", response)
    more = (
        ("confidence_radius", radius, UNITS, "radius of the confidence circle about each measured response"),
        ("multiple_coherence", multiple, "1", "share of the output that all inputs together explain"),
        ("ordinary_coherence", ordinary, "1", "share of the output that this input alone explains"),
    )
    return data | {name: (dims, values, {"units": units, "long_name": text}) for name, values, units, text in more}
