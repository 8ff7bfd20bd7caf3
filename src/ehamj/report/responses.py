"""Transmissibilities as figures and tables: on a page of their own, and as a section of a run's report."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from ehamj import plots
from ehamj.errors import InputError
from ehamj.linear.machine import linear_model
from ehamj.linear.response import ZERO, Transfer, machine_channels, rigid_floor, unit
from ehamj.pages import Page, Picture, Section, Table, write_page
from ehamj.pages.words import AXIS_NAMES, decibel, exact, number
from ehamj.plots import Response
from ehamj.report.shown import Results
from ehamj.result import Result
from ehamj.rig.comparison import COHERENT, Comparison, Variant, own_output, runs_unknown_law
from ehamj.rig.measured import Measurement, by_welch

NAMES: Final = {**AXIS_NAMES, "rz": "yaw, rz"}
MATRIX_UNIT: Final = "m/m"
FREQUENCIES: Final = np.geomspace(1.0, 315.0, 300)
"""At which a report's linear responses are computed [Hz]."""
UNKNOWN: Final = "left out where the confidence circle reaches zero"
USABLE: Final = 0.4
"""Share of the recording rate up to which a run's own transmissibility is shown."""


def write_transmissibility(folder: Path, found: Comparison) -> None:
    """Write ``transmissibility.html``, one page without external parts, and its figures as ``figures/*.svg``."""
    write_page(folder, "transmissibility.html", comparison_page(found))


def comparison_page(found: Comparison) -> Page:
    """A comparison as a page."""
    point = {"cg": "the centre of gravity", "mounts": "the mount plane's centre"}[found.settings.reference]
    methods = list(dict.fromkeys(one.method for variant in found.variants for one in variant.measured))
    how = [
        f"Displacement of the machine (translation of {point}, rotation) over that of a rigid floor at the mount "
        "plane's centre. Linear: about the equilibrium, with the sampled control loop.",
        f"Measured in nonlinear runs: {'; '.join(methods)}; {UNKNOWN}.",
    ]
    meaning = (
        "Attenuation: positive is quieter than the floor, of a floor with the same velocity at every frequency of a "
        "band."
    )
    sections = [Section("responses", "Each direction by itself", list(elements(found)), notes=how)]
    if whole := list(matrix(found)):
        sections.append(Section("matrix", "Every direction", whole))
    tables = [*attenuation_tables(found), *agreement_table(found)]
    sections.append(Section("tables", "Numbers", tables=tables, notes=[meaning]))
    name = found.scenario.name
    return Page(f"{name}: transmissibility", f"{name}: floor to machine", found.scenario.description, sections)


def transmissibility(results: Results, colors: Mapping[str, str]) -> Iterator[Picture]:
    """Floor to machine of stored runs: linear, and measured from each run by Welch's method.

    The vertical, and what else the floor of a run excites. A run that is too short shows the linear response alone.
    """
    responses = {label: own for label, result in results.items() if (own := _own(result)) is not None}
    if not responses:
        return
    passive = any(result.scenario.control.kind == "passive" for result in results.values())
    for dof in AXIS_NAMES:
        shown = (
            [] if passive else [_linear("valves held, linear", next(iter(responses.values())).held, dof, plots.GREY)]
        )
        shown += [
            _linear(f"{label}, linear", own.linear, dof, colors[label])
            for label, own in responses.items()
            if own.linear is not None
        ]
        measured = [
            _measured(f"{label}, measured", own.measured[dof], colors[label])
            for label, own in responses.items()
            if dof in own.measured
        ]
        if measured or dof == "z":
            output = own_output(machine_channels(), dof)
            figure = plots.response(f"Transmissibility, {AXIS_NAMES[dof]}", [*shown, *measured], unit(output, dof))
            methods = dict.fromkeys(own.measured[dof].method for own in responses.values() if dof in own.measured)
            caption = (
                f"Measured: {'; '.join(methods)}; {UNKNOWN}." if methods else "Not measured: the run is too short."
            )
            yield Picture(f"transmissibility-{dof}", figure, caption)


@dataclass(frozen=True)
class _Own:
    """What a run's floor does to its machine."""

    held: Transfer
    linear: Transfer | None
    """None under a law of which only its commands are known."""
    measured: dict[str, Measurement]


def _own(result: Result) -> _Own | None:
    """Linear responses with valves held and as controlled, and measured by degree of freedom; None: not linearised."""
    try:
        model = linear_model(result.scenario)
        held: Transfer = rigid_floor(model, FREQUENCIES)
        law, scenario = result.controller, result.scenario
        linear: Transfer | None = (
            held if law is None else rigid_floor(model, FREQUENCIES, law, sensors=scenario.sensors, seed=scenario.seed)
        )
        if runs_unknown_law(result):
            linear = None
    except InputError:
        return None
    measured = {}
    with suppress(InputError):  # too short for a spectrum: there is nothing to measure
        outputs = machine_channels()
        for one in by_welch(result, [([own_output(outputs, dof)], [dof]) for dof in AXIS_NAMES]):
            usable = result.summary.get("analysis", {}).get("usable_to_hz") or math.inf
            last = min(float(FREQUENCIES[-1]), usable, USABLE * result.scenario.record_rate)
            within = one.within(float(FREQUENCIES[0]), last)
            if np.isfinite(within.estimate.response).any():
                measured[one.inputs[0]] = within
    return _Own(held, linear, measured)


def _linear(label: str, found: Transfer, dof: str, color: str) -> Response:
    values = found.response[:, found.outputs.index(own_output(found.outputs, dof)), found.inputs.index(dof)]
    return Response(label, found.frequency, values, color)


def _measured(label: str, found: Measurement, color: str) -> Response:
    e = found.estimate
    return Response(
        label, e.frequency, e.response[:, 0, 0], color, e.radius[:, 0, 0], e.multiple[:, 0], e.ordinary[:, 0, 0]
    )


def _colors(variants: Sequence[Variant]) -> dict[str, str]:
    """Colour of each variant; passive always has the same."""
    others = iter((plots.BLUE, plots.GREEN, plots.PURPLE, plots.SKY, plots.ORANGE) * len(variants))
    return {one.name: plots.VERMILLION if one.name == "passive" else next(others) for one in variants}


def elements(found: Comparison) -> Iterator[Picture]:
    """A figure for each degree of freedom of the floor: the machine's own answer in it, linear and measured."""
    for dof in found.settings.dofs:
        output = own_output(found.outputs, dof)
        title = f"Floor to machine, {NAMES[dof]}"
        figure = plots.response(title, list(curves(found, output, dof)), unit(output, dof), found.settings.confidence)
        yield Picture(f"transmissibility-{dof}", figure)


def curves(found: Comparison, output: str, source: str) -> Iterator[Response]:
    """One element of the matrix: linear and measured, of each variant."""
    color = _colors(found.variants)
    for variant in found.variants:
        one = variant.linear
        values = one.response[:, one.outputs.index(output), one.inputs.index(source)]
        yield Response(f"{variant.name}, linear", one.frequency, values, color[variant.name])
    for variant in found.variants:
        for measured in variant.measured:
            if output in measured.outputs and source in measured.inputs:
                e, i, j = measured.estimate, measured.outputs.index(output), measured.inputs.index(source)
                yield Response(
                    f"{variant.name}, measured",
                    e.frequency,
                    e.response[:, i, j],
                    color[variant.name],
                    e.radius[:, i, j],
                    e.multiple[:, i],
                    e.ordinary[:, i, j],
                )


def matrix(found: Comparison) -> Iterator[Picture]:
    """All magnitudes as one figure; rotations count as motion at the mounts' mean distance, so that all are m/m."""
    if len(found.settings.dofs) < 2:
        return
    linear = found.variants[0].linear
    turn = {dof: found.length if dof.startswith("r") else 1.0 for dof in NAMES}
    panels = {}
    for output in linear.outputs:
        row = output.split(" ")[-1]
        sizes = [
            max(np.abs(curve.response).max() for curve in curves(found, output, dof) if not curve.measured) / turn[dof]
            for dof in linear.inputs
        ]
        for dof, size in zip(linear.inputs, sizes, strict=True):
            if size > ZERO * max(sizes):
                factor = turn[row] / turn[dof]
                panels[row, dof] = [scaled(curve, factor) for curve in curves(found, output, dof)]
    rows = [output.split(" ")[-1] for output in linear.outputs]
    figure = plots.response_matrix("Floor to machine, every direction", rows, linear.inputs, panels, MATRIX_UNIT)
    caption = f"Rotations count as motion at {found.length:.3g} m, the mounts' mean distance. 0: zero by symmetry."
    yield Picture("transmissibility-matrix", figure, caption, wide=True)


def scaled(curve: Response, factor: float) -> Response:
    """The curve times a factor."""
    radius = None if curve.radius is None else factor * curve.radius
    return Response(
        curve.label, curve.frequency, factor * curve.response, curve.color, radius, curve.multiple, curve.ordinary
    )


def attenuation_tables(found: Comparison) -> Iterator[Table]:
    """Attenuation per third-octave, a table per degree of freedom."""
    columns: dict[str, dict[str, Sequence[float]]] = {}
    for variant, kind, dof, levels in found.attenuation():
        columns.setdefault(dof, {})[f"{variant}, {kind}"] = levels.tolist()
    for dof, parts in columns.items():
        rows = [
            [band.name, *(decibel(None if np.isnan(part[k]) else part[k]) for part in parts.values())]
            for k, band in enumerate(found.chosen)
        ]
        yield Table(f"Attenuation per third-octave [dB], {NAMES[dof]}", ["band [Hz]", *parts], rows)


def agreement_table(found: Comparison) -> Iterator[Table]:
    """Largest deviation of measured from linear, per variant and output."""
    agreement = found.agreement()
    if agreement:
        heads = [f"{name}, of {what}" for name in agreement for what in ("linear", "the floor")]
        rows = [
            [output, *(percent(value) for part in agreement.values() for value in part[output].values())]
            for output in found.outputs
        ]
        note = (
            "Largest |measured − linear| of a row's elements where the multiple coherence is above "
            f"{exact(COHERENT)}: over |linear| (of elements that are zero by symmetry, over the row's largest), and "
            "over the floor's motion. The linear response is that of vanishing motion; what a control has made small "
            "shows the valves' nonlinearity all the more."
        )
        yield Table("Measured against linear [%]", ["machine", *heads], rows, note)


def percent(value: float | None) -> str:
    """A share in per cent."""
    return number(None if value is None else 100.0 * value, 2)
